//! How accurate each state shall be.

use nalgebra::SVector;

use super::method::Attempt;
use crate::Scalar;
use crate::bounds::larger;
use crate::parameter::{self, ParameterError};
use crate::scalar::{lit, to_f64};

/// Tolerances of the local error, per component: |errorᵢ| ≤ absoluteᵢ + relativeᵢ |xᵢ|, in the
/// root mean square over the components.
///
/// States of a friction problem differ by many orders of magnitude (a deflection of 10⁻⁶ m beside
/// a pressure of 10⁵ Pa): one absolute tolerance for all of them is always wrong for some.
///
/// ```
/// use bristle::ode::Tolerances;
/// use nalgebra::Vector3;
///
/// // Position, velocity, bristle deflection: 1e-8 of their typical magnitudes.
/// let tolerances = Tolerances::scaled(1e-8, Vector3::new(1.0, 0.1, 1e-4))?;
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances<T, const N: usize> {
    relative: SVector<T, N>,
    absolute: SVector<T, N>,
}

/// Parameters of [`Tolerances`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TolerancesParameters<T, const N: usize> {
    /// Relative tolerance of each state \[–\], positive.
    pub relative: SVector<T, N>,
    /// Absolute tolerance of each state, in its unit, positive.
    pub absolute: SVector<T, N>,
}

impl<T: Scalar, const N: usize> Tolerances<T, N> {
    /// Checks the tolerances.
    ///
    /// # Errors
    ///
    /// Names the component that is not positive.
    pub fn new(parameters: TolerancesParameters<T, N>) -> Result<Self, ParameterError> {
        let TolerancesParameters { relative, absolute } = parameters;
        for (index, &value) in relative.iter().enumerate() {
            parameter::component(index, parameter::positive("relative", value))?;
        }
        for (index, &value) in absolute.iter().enumerate() {
            parameter::component(index, parameter::positive("absolute", value))?;
        }
        Ok(Self { relative, absolute })
    }

    /// A relative tolerance for every state, and the same fraction of its typical magnitude as
    /// the absolute one. [`System::scales`](super::System::scales) gives the magnitudes.
    ///
    /// # Errors
    ///
    /// Refuses a tolerance or a scale that is not positive.
    pub fn scaled(relative: T, scales: SVector<T, N>) -> Result<Self, ParameterError> {
        parameter::positive("relative", relative)?;
        for (index, &scale) in scales.iter().enumerate() {
            parameter::component(index, parameter::positive("scales", scale))?;
        }
        Self::new(TolerancesParameters {
            relative: SVector::repeat(relative),
            absolute: scales * relative,
        })
    }

    /// The absolute tolerance of each state.
    pub fn absolute(&self) -> &SVector<T, N> {
        &self.absolute
    }

    /// The relative tolerance of each state.
    pub fn relative(&self) -> &SVector<T, N> {
        &self.relative
    }

    /// Mean square of the error of a trial step over the tolerances; not finite if the step is not.
    #[inline]
    pub(crate) fn mean_square(&self, start: &SVector<T, N>, attempt: &Attempt<T, N>) -> f64 {
        let mut sum = T::zero();
        for i in 0..N {
            let size = larger(start[i].abs(), attempt.state[i].abs());
            let ratio = attempt.error[i] / (self.absolute[i] + self.relative[i] * size);
            sum += ratio * ratio;
        }
        to_f64(sum) / N.max(1) as f64
    }

    /// Root mean square of a vector over the tolerances at a state.
    pub(crate) fn norm(&self, vector: &SVector<T, N>, state: &SVector<T, N>) -> T {
        let mut sum = T::zero();
        for i in 0..N {
            let ratio = vector[i] / (self.absolute[i] + self.relative[i] * state[i].abs());
            sum += ratio * ratio;
        }
        (sum / lit(N.max(1) as f64)).sqrt()
    }
}
