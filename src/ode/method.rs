//! What a one-step method is to the driver that runs it.

use core::fmt::Debug;

use nalgebra::SVector;

use crate::Scalar;

/// A right-hand side on locked branches, as a method sees it: smooth, and counted.
pub trait Field<T: Scalar, const N: usize> {
    /// f(t, x).
    fn rate(&mut self, time: T, state: &SVector<T, N>) -> SVector<T, N>;
}

/// Where a step starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point<T, const N: usize> {
    /// Time \[s\].
    pub time: T,
    /// State x.
    pub state: SVector<T, N>,
    /// Rate f(t, x).
    pub rate: SVector<T, N>,
}

/// A trial step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attempt<T, const N: usize> {
    /// State at the end.
    pub state: SVector<T, N>,
    /// Rate at the end.
    pub rate: SVector<T, N>,
    /// Estimate of the local error; zero for a method without one.
    pub error: SVector<T, N>,
    /// Coefficient of θ²(1 − θ)² in the dense output; zero for a cubic one.
    pub quartic: SVector<T, N>,
}

/// A one-step method.
pub trait Method<T: Scalar, const N: usize>: Debug + Clone {
    /// Tries a step of signed length h from a point.
    fn attempt<F: Field<T, N>>(&self, field: &mut F, from: &Point<T, N>, step: T) -> Attempt<T, N>;
}

/// A method that estimates its local error, so that a driver can choose the step.
pub trait Embedded {
    /// Order of the estimate: halving the step divides it by 2 to this power.
    const ESTIMATE_ORDER: u8;
}
