//! A sine about a mean: u(t) = mean + amplitude · sin(2π · frequency · t + phase).

use super::Signal;
use crate::Scalar;
use crate::parameter::{Checked, Named};

/// Parameters of [`Sine`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct SineParameters<T> {
    /// Mean value, in the unit of the signal.
    pub mean: T,
    /// Amplitude, in the unit of the signal.
    pub amplitude: T,
    /// Frequency \[Hz\], positive.
    pub frequency: T,
    /// Phase at t = 0 \[rad\].
    pub phase: T,
}

/// A sine about a mean, u(t) = mean + amplitude · sin(2π · frequency · t + phase).
///
/// ```
/// use bristle::signal::{Signal, Sine, SineParameters};
///
/// let parameters = SineParameters { mean: 1.0, amplitude: 0.5, frequency: 2.0, phase: 0.0 };
/// let force = Sine::new(parameters)?;
/// assert_eq!(force.value(0.125), 1.5);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sine<T> {
    parameters: SineParameters<T>,
    /// 2π · frequency [rad/s]
    angular: T,
}

impl<T: Scalar> Sine<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn new(parameters: SineParameters<T>) -> Checked<Self> {
        Named("frequency", parameters.frequency).positive()?;
        Named("mean", parameters.mean).finite()?;
        Named("amplitude", parameters.amplitude).finite()?;
        Named("phase", parameters.phase).finite()?;
        Ok(Self { parameters, angular: T::two_pi() * parameters.frequency })
    }

    /// The parameters, as they were given.
    pub fn parameters(&self) -> SineParameters<T> {
        self.parameters
    }
}

impl<T: Scalar> Signal<T> for Sine<T> {
    #[inline]
    fn value(&self, time: T) -> T {
        let SineParameters { mean, amplitude, phase, .. } = self.parameters;
        mean + amplitude * (self.angular * time + phase).sin()
    }

    #[inline]
    fn value_and_rate(&self, time: T) -> (T, T) {
        let SineParameters { mean, amplitude, phase, .. } = self.parameters;
        let (sin, cos) = (self.angular * time + phase).sin_cos();
        (mean + amplitude * sin, amplitude * self.angular * cos)
    }

    /// A quarter of the period.
    #[inline]
    fn longest_step(&self) -> Option<T> {
        Some(T::frac_pi_2() / self.angular)
    }
}
