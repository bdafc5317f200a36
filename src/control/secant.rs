//! The velocity that an encoder tells: the secant of two samples, and a smooth one beside it.
//!
//! w = (x_n − x_(n−1))/h,  v_f ← v_f + (w − v_f) h/(τ + h)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x_n | position at sample n | m |
//! | h | sample time | s |
//! | w | secant velocity: the true mean velocity, but for the quantisation | m/s |
//! | τ | time constant of the filter | s |
//! | v_f | filtered velocity | m/s |
//!
//! The sum of all w h is the distance gone, however coarse the encoder. Each w is a multiple of q/h: 10 mm/s for
//! counts of 1 µm at 10 kHz. The filter is the backward Euler step of τ v̇_f = w − v_f, stable for every h.

use crate::Scalar;
use crate::parameter::{self, ParameterError};

/// Parameters of a [`SecantVelocity`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecantVelocityParameters<T> {
    /// Sample time h \[s\], positive.
    pub sample_time: T,
    /// Time constant τ \[s\] of the filter, zero for none.
    #[doc(alias = "tau")]
    pub time_constant: T,
}

/// Velocity from sampled positions.
///
/// ```
/// use bristle::control::{SecantVelocity, SecantVelocityParameters};
///
/// let mut encoder = SecantVelocity::new(SecantVelocityParameters {
///     sample_time: 1e-3,
///     time_constant: 4e-3,
/// })?;
/// encoder.push(0.0);
/// assert_eq!(encoder.push(2e-6), Some(2e-6)); // the way since the last good sample
/// assert!((encoder.filtered() - 0.2 * 2e-3).abs() < 1e-15);
/// assert_eq!(encoder.push(f64::NAN), None); // refused, and nothing has changed
/// assert_eq!(encoder.push(3e-6), Some(1e-6));
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecantVelocity<T> {
    sample_time: T,
    /// h/(τ + h)
    weight: T,
    position: Option<T>,
    secant: T,
    filtered: T,
}

impl<T: Scalar> SecantVelocity<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a sample time that is not positive, and a time constant that is negative or not finite.
    pub fn new(parameters: SecantVelocityParameters<T>) -> Result<Self, ParameterError> {
        let sample_time = parameter::positive("sample_time", parameters.sample_time)?;
        let time_constant = parameter::non_negative("time_constant", parameters.time_constant)?;
        Ok(Self {
            sample_time,
            weight: sample_time / (time_constant + sample_time),
            position: None,
            secant: T::zero(),
            filtered: T::zero(),
        })
    }

    /// Takes a position \[m\]. Answers with the displacement since the last good sample \[m\], zero for the first;
    /// `None`, with nothing changed, for a position that is no finite number or unimaginably far from the last.
    ///
    /// After samples that were refused the displacement covers them too, and the secant velocity is too large by
    /// as much.
    #[inline]
    pub fn push(&mut self, position: T) -> Option<T> {
        let from = self.position.unwrap_or(position);
        let displacement = self.advance(position - from)?;
        self.position = Some(position);
        Some(displacement)
    }

    /// The same for a displacement \[m\] since the last sample, such as a difference of counts times the size of
    /// one: in `f32` the difference of two positions far from zero has lost its digits.
    #[inline]
    pub fn advance(&mut self, displacement: T) -> Option<T> {
        let secant = displacement / self.sample_time;
        let filtered = self.filtered + self.weight * (secant - self.filtered);
        if !(secant.is_finite() && filtered.is_finite()) {
            return None;
        }
        (self.secant, self.filtered) = (secant, filtered);
        Some(displacement)
    }

    /// The secant velocity w [m/s] of the last good sample.
    pub fn secant(&self) -> T {
        self.secant
    }

    /// The filtered velocity v_f [m/s].
    pub fn filtered(&self) -> T {
        self.filtered
    }

    /// The weight h/(τ + h) \[–\] of a new secant velocity.
    pub(super) fn weight(&self) -> T {
        self.weight
    }

    pub(super) fn sample_time(&self) -> T {
        self.sample_time
    }

    /// Forgets the position and stands still.
    pub fn reset(&mut self) {
        (self.position, self.secant, self.filtered) = (None, T::zero(), T::zero());
    }
}
