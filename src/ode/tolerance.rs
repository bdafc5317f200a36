//! How accurate each state shall be.

use nalgebra::SVector;

use super::controller::rough_power;
use crate::Scalar;
use crate::parameter::{self, ParameterError};
use crate::scalar::{lit, to_f64};

/// Smallest relative tolerance over the rounding ε of the scalar type. The sums of one step round
/// by a few ε, which no shorter step makes smaller.
const LEAST: f64 = 10.0;

/// Largest relative tolerance: a coarser answer is none.
const MOST: f64 = 0.1;

/// Tolerance of one step for a solution good to 10⁻⁹; otherwise it goes with the power ⅔ of the
/// tolerance of the solution, since breakaway amplifies a looser one more: 10⁻⁷ for 10⁻⁶.
const AT_BEST: f64 = 1e-9;

/// Loosest relative tolerance of one step. Over drawn scenes, five times as much missed slips.
const LOOSEST: f64 = 2e-6;

/// Finest relative tolerance of one step over the rounding ε, unless a finer one is asked for.
const FINEST: f64 = 100.0;

/// Tolerances of a solution, per component: |errorᵢ| ≤ absoluteᵢ + relativeᵢ |xᵢ|, in the
/// root mean square over the components.
///
/// States of a friction problem differ by many orders of magnitude (a deflection of 10⁻⁶ m beside
/// a pressure of 10⁵ Pa): one absolute tolerance for all of them is always wrong for some.
///
/// ```
/// use bristle::ode::Tolerances;
/// use bristle::nalgebra::Vector3;
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

impl<T: Scalar, const N: usize> Tolerances<T, N> {
    /// Relative tolerances \[–\] and absolute ones, in the unit of each state; all positive.
    ///
    /// # Errors
    ///
    /// Names the component that is not positive, and a relative tolerance that the rounding of the
    /// scalar type would exceed: below 10 ε, that is 2·10⁻¹⁵ in `f64` and 1.2·10⁻⁶ in `f32`.
    pub fn new(relative: SVector<T, N>, absolute: SVector<T, N>) -> Result<Self, ParameterError> {
        for (index, &value) in relative.iter().enumerate() {
            parameter::component(index, check("relative", value))?;
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
    /// Refuses a tolerance or a scale that is not positive, and a tolerance below 10 ε.
    pub fn scaled(relative: T, scales: SVector<T, N>) -> Result<Self, ParameterError> {
        check("relative", relative)?;
        for (index, &scale) in scales.iter().enumerate() {
            parameter::component(index, parameter::positive("scales", scale))?;
        }
        Self::new(SVector::repeat(relative), scales * relative)
    }

    /// The tolerances of one step, of those of the solution ε: 10⁻⁹ (ε/10⁻⁹)^⅔, but no more than
    /// 2·10⁻⁶ or ε, and of that a part 1/care. Breakaway amplifies errors: a local error of 10⁻³
    /// can shift a slip by much more than that, or miss it.
    pub(super) fn local(mut self, care: f64) -> Self {
        for (relative, absolute) in self.relative.iter_mut().zip(self.absolute.iter_mut()) {
            let asked = to_f64(*relative);
            let power = AT_BEST * rough_power(asked / AT_BEST, 2.0 / 3.0);
            let tight = power.min(LOOSEST).min(asked) / care;
            // No tighter than rounding allows.
            let least = asked.min(FINEST * to_f64(T::default_epsilon()));
            let part = lit::<T>(tight.max(least) / asked);
            *relative *= part;
            *absolute *= part;
        }
        self
    }

    /// The absolute tolerance of each state.
    pub fn absolute(&self) -> &SVector<T, N> {
        &self.absolute
    }

    /// The relative tolerance of each state.
    pub fn relative(&self) -> &SVector<T, N> {
        &self.relative
    }

    /// The error allowed each state where it is found.
    #[inline]
    pub(super) fn at(&self, state: &SVector<T, N>) -> SVector<T, N> {
        let mut allowed = self.absolute;
        for i in 0..N {
            allowed[i] += self.relative[i] * state[i].abs();
        }
        allowed
    }
}

/// Checks a relative tolerance.
pub(super) fn check<T: Scalar>(name: &'static str, relative: T) -> Result<T, ParameterError> {
    let least = lit::<T>(LEAST) * T::default_epsilon();
    parameter::positive(name, relative)?;
    parameter::at_most(name, relative, "a tenth", lit(MOST))?;
    parameter::at_least(name, relative, "ten roundings of the scalar", least)
}
