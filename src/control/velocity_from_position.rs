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
//! counts of 1 µm at 10 kHz. The filter is the backward Euler step of τ v̇_f = w − v_f, stable for every h. After n − 1 samples that
//! were refused it takes n such steps at once, towards the mean velocity of all n: with the weight 1 − (τ/(τ + h))ⁿ.

use crate::Scalar;
use crate::parameter::{self, ParameterError};
use crate::scalar::lit;

/// Parameters of a [`VelocityFromPosition`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityFromPositionParameters<T> {
    /// Sample time h \[s\], positive.
    pub sample_time: T,
    /// Time constant τ \[s\] of the filter, zero for none.
    #[doc(alias = "tau")]
    pub time_constant: T,
    /// Speed \[m/s\] that the mechanism cannot exceed, positive: a sample that asks for more is refused as a fault.
    pub fastest: T,
    /// Size of one encoder count q \[m\], zero or positive: two counts more than the fastest speed takes are quantisation, not
    /// speed. A coarse encoder sampled quickly needs it: with q > fastest·h every single count would be refused.
    pub count: T,
}

/// Velocity from sampled positions.
///
/// ```
/// use bristle::control::{VelocityFromPosition, VelocityFromPositionParameters};
///
/// let mut encoder = VelocityFromPosition::new(VelocityFromPositionParameters {
///     sample_time: 1e-3_f64,
///     time_constant: 4e-3,
///     fastest: 1.0,
///     count: 0.0,
/// })?;
/// encoder.push(0.0);
/// assert_eq!(encoder.push(2e-6), Some(2e-6)); // the way since the last good sample
/// assert!((encoder.filtered() - 0.2 * 2e-3).abs() < 1e-15);
/// assert_eq!(encoder.push(f64::NAN), None); // refused: only time has passed
/// assert_eq!(encoder.push(0.5), None); // half a metre in two milliseconds
/// assert_eq!(encoder.push(5e-6), Some(5e-6 - 2e-6));
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityFromPosition<T> {
    sample_time: T,
    /// h/(τ + h)
    weight: T,
    fastest: T,
    /// Two counts.
    slack: T,
    position: Option<T>,
    /// The last way since the good sample, if it was refused for being too far.
    elsewhere: Option<T>,
    /// Samples since the last good one, this one included.
    elapsed: T,
    /// The weight of as many samples at once, 1 − (1 − weight)^elapsed.
    news: T,
    secant: T,
    filtered: T,
}

/// What a sample has told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Reading<T> {
    /// The way since the last good sample \[m\].
    Displacement(T),
    /// The mechanism is elsewhere, and goes on from there.
    Restarted,
    /// Nothing that can be believed.
    Refused,
}

impl<T: Scalar> Reading<T> {
    fn way(self) -> Option<T> {
        match self {
            Self::Displacement(way) => Some(way),
            Self::Restarted => Some(T::zero()),
            Self::Refused => None,
        }
    }
}

impl<T: Scalar> VelocityFromPosition<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a sample time or a fastest speed that is not positive, and a time constant or a count that is negative or not finite.
    pub fn new(parameters: VelocityFromPositionParameters<T>) -> Result<Self, ParameterError> {
        let sample_time = parameter::positive("sample_time", parameters.sample_time)?;
        let time_constant = parameter::non_negative("time_constant", parameters.time_constant)?;
        let weight = sample_time / (time_constant + sample_time);
        Ok(Self {
            sample_time,
            weight,
            fastest: parameter::positive("fastest", parameters.fastest)?,
            slack: lit::<T>(2.0) * parameter::non_negative("count", parameters.count)?,
            position: None,
            elsewhere: None,
            elapsed: T::one(),
            news: weight,
            secant: T::zero(),
            filtered: T::zero(),
        })
    }

    /// Takes a position \[m\]. Answers with the displacement since the last good sample \[m\], zero for the first; `None`, with
    /// nothing changed but the time since then, for a position that is no finite number, or farther away than the fastest speed allows.
    ///
    /// After samples that were refused the displacement covers them too. A second position beside one that was too far away is
    /// believed: the mechanism was moved, or its encoder set anew, and it goes on from there with no displacement.
    #[inline]
    pub fn push(&mut self, position: T) -> Option<T> {
        self.read(position).way()
    }

    /// [`VelocityFromPosition::push`], which also tells whether the mechanism was found elsewhere.
    #[inline]
    pub(super) fn read(&mut self, position: T) -> Reading<T> {
        let from = self.position.unwrap_or(position);
        let reading = self.arrive(position - from);
        if reading != Reading::Refused {
            self.position = Some(position);
        }
        reading
    }

    /// The same for a displacement \[m\] since the last call, such as a difference of counts times the size of one: in `f32` the
    /// difference of two positions far from zero has lost its digits. Take one of the two, not both by turns.
    ///
    /// Displacements that were refused for being too large are remembered, so that a glitch and the way back from it come to nothing.
    /// One that is no finite number tells nothing: the next is taken for the displacement since the call before it.
    #[inline]
    pub fn advance(&mut self, displacement: T) -> Option<T> {
        if !displacement.is_finite() {
            self.miss();
            return None;
        }
        self.arrive(self.elsewhere.unwrap_or_else(T::zero) + displacement).way()
    }

    /// A sample time goes by without a sample.
    #[inline]
    pub(super) fn miss(&mut self) {
        self.elapsed += T::one();
        self.news += self.weight * (T::one() - self.news);
    }

    /// Goes a way \[m\] from where the last good sample was, if it can be.
    #[inline]
    fn arrive(&mut self, way: T) -> Reading<T> {
        let farthest = self.fastest * self.sample_time;
        if way.abs() <= farthest * self.elapsed + self.slack {
            self.secant = way / self.sample_time;
            self.filtered += self.news * (self.secant / self.elapsed - self.filtered);
            self.settle();
            return Reading::Displacement(way);
        }
        if self.elsewhere.is_some_and(|other| (way - other).abs() <= farthest + self.slack) {
            self.secant = T::zero();
            self.settle();
            return Reading::Restarted;
        }
        self.elsewhere = way.is_finite().then_some(way);
        self.miss();
        Reading::Refused
    }

    /// After a good sample.
    #[inline]
    fn settle(&mut self) {
        (self.elapsed, self.news, self.elsewhere) = (T::one(), self.weight, None);
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
        self.settle();
        self.position = None;
        (self.secant, self.filtered) = (T::zero(), T::zero());
    }
}
