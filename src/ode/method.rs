//! What a one-step method is to the driver that runs it.

use core::fmt::Debug;

use nalgebra::SVector;

use super::curve::Curve;
use super::system::Linearisation;
use crate::Scalar;
use crate::scalar::lit;
use crate::stability::Scheme;

/// A right-hand side on locked branches, as a method sees it: smooth, and counted.
pub trait Field<T: Scalar, const N: usize> {
    /// f(t, x).
    fn rate(&mut self, time: T, state: &SVector<T, N>) -> SVector<T, N>;

    /// f(t, x) with its partial derivatives: the system's own, or by finite differences where it
    /// has none.
    fn linearised(&mut self, time: T, state: &SVector<T, N>) -> Linearisation<T, N>;
}

/// Where a step starts or ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point<T, const N: usize> {
    /// Time \[s\].
    pub time: T,
    /// State x.
    pub state: SVector<T, N>,
    /// Rate f(t, x).
    pub rate: SVector<T, N>,
    /// The error of each state that the tolerances allow here; one for fixed steps.
    pub scale: SVector<T, N>,
}

/// A trial step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attempt<T, const N: usize> {
    /// State at the end.
    pub state: SVector<T, N>,
    /// Estimate of the local error; zero for a method without one.
    pub error: SVector<T, N>,
    /// A second estimate of lower order, for a method that weighs one with the other.
    pub coarse_error: Option<SVector<T, N>>,
    /// Order of the estimate: halving the step divides it by 2 to this power.
    pub order: u8,
}

/// A one-step method.
pub trait Method<T: Scalar, const N: usize>: Debug + Clone {
    /// What the method keeps for a run: its stages, for the dense output, and what one step leaves
    /// to the next.
    type Memory: Debug + Clone;

    /// The memory at the start of a run.
    fn memory(&self) -> Self::Memory;

    /// What is known of the stability of its steps; `None` for a method that is not on the list.
    fn scheme(&self) -> Option<Scheme> {
        None
    }

    /// Evaluates the rate, and whatever else the method needs, at a point where a run starts, or
    /// goes on with another branch or beyond a kink.
    fn begin<F: Field<T, N>>(
        &self,
        memory: &mut Self::Memory,
        field: &mut F,
        point: &mut Point<T, N>,
    ) {
        let _ = memory;
        point.rate = field.rate(point.time, &point.state);
    }

    /// Tries a step of signed length h from a point.
    fn attempt<F: Field<T, N>>(
        &self,
        memory: &mut Self::Memory,
        field: &mut F,
        from: &Point<T, N>,
        step: T,
    ) -> Attempt<T, N>;

    /// Evaluates the rate at the end of a trial step, without harm to another trial from the same
    /// start.
    fn arrive<F: Field<T, N>>(
        &self,
        memory: &mut Self::Memory,
        field: &mut F,
        end: &mut Point<T, N>,
    ) {
        let _ = memory;
        end.rate = field.rate(end.time, &end.state);
    }

    /// The curve through a trial step, after [`Method::arrive`].
    fn curve<F: Field<T, N>>(
        &self,
        memory: &Self::Memory,
        field: &mut F,
        from: &Point<T, N>,
        end: &Point<T, N>,
    ) -> Curve<T, N> {
        let _ = (memory, field);
        Curve::hermite(from, end)
    }

    /// Learns that the step to `end` was accepted, and what length is proposed for the next one, if it
    /// is not fixed. Answers with the length to take.
    fn accepted<F: Field<T, N>>(
        &self,
        memory: &mut Self::Memory,
        field: &mut F,
        from: &Point<T, N>,
        end: &Point<T, N>,
        proposed: Option<T>,
    ) -> Option<T> {
        let _ = (memory, field, from, end);
        proposed
    }
}

/// A method that estimates its local error, so that a driver can choose the step.
pub trait Embedded {}

/// x + h Σ wⱼ kⱼ over the given stages.
#[inline(always)]
pub(super) fn along<T: Scalar, const N: usize, const S: usize, const W: usize, const M: usize>(
    x: &SVector<T, N>,
    step: T,
    k: &[SVector<T, N>; S],
    weights: &[f64; W],
    stages: [usize; M],
) -> SVector<T, N> {
    let mut sum = combine(k, weights, stages);
    for i in 0..N {
        sum[i] = x[i] + step * sum[i];
    }
    sum
}

/// Σ wⱼ kⱼ over the given stages; the others have no weight.
#[inline(always)]
pub(super) fn combine<T: Scalar, const N: usize, const S: usize, const W: usize, const M: usize>(
    k: &[SVector<T, N>; S],
    weights: &[f64; W],
    stages: [usize; M],
) -> SVector<T, N> {
    let mut sum = SVector::zeros();
    for i in 0..N {
        let mut component = T::zero();
        for stage in stages {
            component += k[stage][i] * lit::<T>(weights[stage]);
        }
        sum[i] = component;
    }
    sum
}
