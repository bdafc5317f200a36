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
    /// Speed \[m/s\] that the mechanism cannot exceed, positive: a sample that asks for more is refused as a fault.
    pub fastest: T,
}

/// Velocity from sampled positions.
///
/// ```
/// use bristle::control::{SecantVelocity, SecantVelocityParameters};
///
/// let mut encoder = SecantVelocity::new(SecantVelocityParameters {
///     sample_time: 1e-3_f64,
///     time_constant: 4e-3,
///     fastest: 1.0,
/// })?;
/// encoder.push(0.0);
/// assert_eq!(encoder.push(2e-6), Some(2e-6)); // the way since the last good sample
/// assert!((encoder.filtered() - 0.2 * 2e-3).abs() < 1e-15);
/// assert_eq!(encoder.push(f64::NAN), None); // refused, and nothing has changed
/// assert_eq!(encoder.push(0.5), None); // half a metre in two milliseconds
/// assert_eq!(encoder.push(5e-6), Some(5e-6 - 2e-6));
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecantVelocity<T> {
    sample_time: T,
    /// h/(τ + h)
    weight: T,
    fastest: T,
    position: Option<T>,
    /// The last position, if it was refused for being too far away.
    elsewhere: Option<T>,
    /// Samples since the last good one, this one included.
    elapsed: T,
    secant: T,
    filtered: T,
}

impl<T: Scalar> SecantVelocity<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a sample time or a fastest speed that is not positive, and a time constant that is negative or not finite.
    pub fn new(parameters: SecantVelocityParameters<T>) -> Result<Self, ParameterError> {
        let sample_time = parameter::positive("sample_time", parameters.sample_time)?;
        let time_constant = parameter::non_negative("time_constant", parameters.time_constant)?;
        Ok(Self {
            sample_time,
            weight: sample_time / (time_constant + sample_time),
            fastest: parameter::positive("fastest", parameters.fastest)?,
            position: None,
            elsewhere: None,
            elapsed: T::one(),
            secant: T::zero(),
            filtered: T::zero(),
        })
    }

    /// Takes a position \[m\]. Answers with the displacement since the last good sample \[m\], zero for the first; `None`, with
    /// nothing changed, for a position that is no finite number, or farther away than the fastest speed allows.
    ///
    /// After samples that were refused the displacement covers them too. A second position beside one that was too far away is
    /// believed: the mechanism was moved, or its encoder set anew, and it goes on from there with no displacement.
    #[inline]
    pub fn push(&mut self, position: T) -> Option<T> {
        let from = self.position.unwrap_or(position);
        if let Some(displacement) = self.advance(position - from) {
            self.position = Some(position);
            return Some(displacement);
        }
        let near = |other: T| (position - other).abs() <= self.fastest * self.sample_time;
        if self.elsewhere.is_some_and(near) {
            self.elapsed = T::one();
            (self.position, self.elsewhere, self.secant) = (Some(position), None, T::zero());
            return Some(T::zero());
        }
        self.elsewhere = position.is_finite().then_some(position);
        None
    }

    /// The same for a displacement \[m\] since the last good sample, such as a difference of counts times the size of one:
    /// in `f32` the difference of two positions far from zero has lost its digits.
    #[inline]
    pub fn advance(&mut self, displacement: T) -> Option<T> {
        if !(displacement.abs() <= self.fastest * self.sample_time * self.elapsed) {
            self.elapsed += T::one();
            return None;
        }
        self.secant = displacement / self.sample_time;
        self.filtered += self.weight * (self.secant / self.elapsed - self.filtered);
        (self.elapsed, self.elsewhere) = (T::one(), None);
        Some(displacement)
    }

    /// The displacement of the last good sample over one sample time: the secant velocity w [m/s], unless samples before it were
    /// refused.
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

    pub(super) fn fastest(&self) -> T {
        self.fastest
    }

    /// Forgets the position and stands still.
    pub fn reset(&mut self) {
        (self.position, self.elsewhere, self.elapsed) = (None, None, T::one());
        (self.secant, self.filtered) = (T::zero(), T::zero());
    }
}
