//! The interface between a one-step method and the driver.

use core::fmt::Debug;
use core::marker::PhantomData;

#[cfg(test)]
use nalgebra::SMatrix;
use nalgebra::SVector;

use super::dense_output::DenseOutput;
use super::storage::{States, slices};
use super::system::Linearisation;
use super::tolerance::ToleranceRange;
use crate::Scalar;
use crate::parameter::ParameterError;
use crate::scalar::to_f64;

/// The right-hand side on locked branches, as a method sees it: smooth, and its calls counted.
pub(crate) trait Field<T: Scalar, V: States<T>> {
    /// f(t, x), written over a vector.
    fn rate_to(&mut self, time: T, state: &V, rate: &mut V);

    /// f(t, x).
    #[inline(always)]
    fn rate(&mut self, time: T, state: &V) -> V {
        let mut rate = V::filled(state.count(), T::zero());
        self.rate_to(time, state, &mut rate);
        rate
    }

    /// f(t, x) with its partial derivatives: those of the system, or finite differences if it
    /// gives none.
    fn linearised(&mut self, time: T, state: &V) -> Linearisation<V, V::Matrix>;

    /// ∂f/∂x alone at a point whose rate is known.
    fn jacobian(&mut self, point: &Point<T, V>) -> V::Matrix;
}

/// The start or the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point<T, V> {
    /// Time \[s\].
    pub(super) time: T,
    /// State x.
    pub(super) state: V,
    /// Rate f(t, x).
    pub(super) rate: V,
    /// The error of each state that the tolerances allow here; one for fixed steps.
    pub(super) scale: V,
}

impl<T: Scalar, V: States<T>> Point<T, V> {
    /// The cubic through this point and another with the rates at both.
    #[inline]
    pub(super) fn cubic_to(&self, end: &Self) -> DenseOutput<T, V> {
        let step = end.time - self.time;
        let chord = end.state.with(&self.state, |end, start| end - start);
        let from_start = self.rate.with(&chord, |rate, chord| rate * step - chord);
        let from_end = chord
            .with(&end.rate, |chord, rate| chord - rate * step)
            .with(&from_start, |rest, from_start| rest - from_start);
        DenseOutput::new(self.state.clone(), [chord, from_start, from_end])
    }
}

/// The result of a trial step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TrialStep<T, V> {
    /// State at the end.
    pub(super) state: V,
    /// Estimate of the local error; zero for a method without one.
    pub(super) error: V,
    /// A second estimate of lower order, for a method that combines two.
    pub(super) coarse_error: Option<V>,
    /// Order q of the estimate: it behaves as h^q.
    pub(super) order: u8,
    pub(super) scalar: PhantomData<T>,
}

impl<T: Scalar, V: States<T>> TrialStep<T, V> {
    /// Mean square of the error over the larger of the errors allowed at the start and at the end.
    #[inline]
    pub(super) fn mean_square(&self, at_start: &V, at_end: &V) -> f64 {
        let (mut fine, mut coarse) = (T::zero(), T::zero());
        let states = self.error.count();
        let [fines, at_start, at_end] = slices(states, [&self.error, at_start, at_end]);
        for i in 0..states {
            let inverse = T::one() / at_start[i].larger(at_end[i]);
            let ratio = fines[i] * inverse;
            fine += ratio * ratio;
            if let Some(error) = &self.coarse_error {
                let ratio = error[i] * inverse;
                coarse += ratio * ratio;
            }
        }
        let (fine, count) = (to_f64(fine), states.max(1) as f64);
        match self.coarse_error {
            None => fine / count,
            Some(_) => {
                let combined = fine + 0.01 * to_f64(coarse);
                if combined > 0.0 { fine * (fine / combined) / count } else { combined }
            }
        }
    }
}

/// A one-step method at work: its stages, and what one step passes on to the next.
pub(crate) trait Stepper<T: Scalar, V: States<T>>: Debug + Clone {
    /// Whether the method estimates its local error, so that the driver can choose the step.
    const ESTIMATES_ERROR: bool = true;

    /// Evaluates the rate, and whatever else the method needs, at a point where a run starts or
    /// continues after a reversal or a kink.
    fn begin<F: Field<T, V>>(&mut self, field: &mut F, point: &mut Point<T, V>);

    /// Tries a step of signed length h from a point.
    fn step(&mut self, field: &mut impl Field<T, V>, from: &Point<T, V>, h: T) -> TrialStep<T, V>;

    /// Evaluates the rate at the end of a trial step. Another trial from the same start may follow.
    fn arrive<F: Field<T, V>>(&mut self, field: &mut F, end: &mut Point<T, V>);

    /// Whether the method can represent what grows over a trial step, after [`Stepper::arrive`].
    fn represents_growth(&self) -> bool {
        true
    }

    /// The Jacobians at both ends of a trial step, after [`Stepper::arrive`]; of many states, one
    /// known before for both.
    fn jacobians_of_step<F: Field<T, V>>(
        &mut self,
        field: &mut F,
        from: &Point<T, V>,
        end: &Point<T, V>,
    ) -> [&V::Matrix; 2];

    /// rₖ of the stability function R(z) = 1 + r₁z(1 + r₂z(1 + …)) of an explicit method.
    fn stability(&self) -> &'static [f64] {
        &[]
    }

    /// The dense output of a trial step, after [`Stepper::arrive`].
    fn dense_output<F: Field<T, V>>(
        &mut self,
        field: &mut F,
        from: &Point<T, V>,
        end: &Point<T, V>,
    ) -> DenseOutput<T, V>;

    /// Takes note that a step of so signed a length was accepted. Given the length proposed for the
    /// next step (`None` if steps are fixed), answers with the length to take.
    fn accepted(&mut self, step: T, end: &Point<T, V>, proposed: Option<T>) -> Option<T>;
}

/// What a stepper of several answers as the one at work does, which a macro chooses.
macro_rules! as_the_one_at_work {
    ($of:ident) => {
        #[inline]
        fn arrive<F: Field<T, V>>(&mut self, field: &mut F, end: &mut Point<T, V>) {
            $of!(self.arrive(field, end));
        }

        #[inline]
        fn represents_growth(&self) -> bool {
            $of!(self.represents_growth())
        }

        #[inline]
        fn jacobians_of_step<F: Field<T, V>>(
            &mut self,
            field: &mut F,
            from: &Point<T, V>,
            end: &Point<T, V>,
        ) -> [&V::Matrix; 2] {
            $of!(self.jacobians_of_step(field, from, end))
        }

        fn stability(&self) -> &'static [f64] {
            $of!(self.stability())
        }

        fn dense_output<F: Field<T, V>>(
            &mut self,
            field: &mut F,
            from: &Point<T, V>,
            end: &Point<T, V>,
        ) -> DenseOutput<T, V> {
            $of!(self.dense_output(field, from, end))
        }
    };
}
pub(super) use as_the_one_at_work;

/// ẋ = A x.
#[cfg(test)]
pub(super) struct Linear<'a, T, const N: usize>(pub(super) &'a SMatrix<T, N, N>);

#[cfg(test)]
impl<T: Scalar, const N: usize> Field<T, SVector<T, N>> for Linear<'_, T, N> {
    fn rate_to(&mut self, _: T, state: &SVector<T, N>, rate: &mut SVector<T, N>) {
        *rate = self.0 * state;
    }

    fn linearised(
        &mut self,
        _: T,
        state: &SVector<T, N>,
    ) -> Linearisation<SVector<T, N>, SMatrix<T, N, N>> {
        let (rate, by_time) = (self.0 * state, SVector::zeros());
        Linearisation { rate, by_state: *self.0, by_time }
    }

    fn jacobian(&mut self, _: &Point<T, SVector<T, N>>) -> SMatrix<T, N, N> {
        *self.0
    }
}

/// A one-step method of this module: [`RungeKutta4`](super::RungeKutta4),
/// [`DormandPrince`](super::DormandPrince), [`DormandPrince8`](super::DormandPrince8),
/// [`Rodas4`](super::Rodas4), [`Rodas5P`](super::Rodas5P), [`Automatic`](super::Automatic), or one
/// of them chosen at run time, [`AnyMethod`](super::AnyMethod).
pub trait Method<T: Scalar, const N: usize>: OneStep<T, SVector<T, N>> {}

impl<T: Scalar, M: OneStep<T, SVector<T, N>>, const N: usize> Method<T, N> for M {}

/// What the driver asks of a method.
pub(crate) trait OneStep<T: Scalar, V: States<T>>: Debug + Copy {
    /// What steps with it.
    type Stepper: Stepper<T, V>;

    /// The method at the start of a run from states of this size with this relative tolerance of a
    /// step; zero if steps are fixed.
    fn stepper(&self, tolerance: f64, state: &V) -> Self::Stepper;

    /// How loose its steps may be where nothing is known of the growth of errors.
    fn tolerance_range(&self) -> ToleranceRange {
        ToleranceRange::SINGLE
    }

    /// Refuses adaptive steps of a method, chosen at run time, without an error estimate.
    fn check_adaptive(&self) -> Result<(), ParameterError> {
        Ok(())
    }
}
