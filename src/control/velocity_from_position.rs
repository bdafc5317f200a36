//! Displacement and velocity from an encoder.
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
//! The sum of all w h is the distance travelled, however coarse the encoder. Each w is a multiple
//! of q/h with the size q of one count: 10 mm/s for counts of 1 µm at 10 kHz.
//!
//! The filter is the backward Euler step of τ v̇_f = w − v_f, stable for every h. After n − 1
//! refused samples it takes n such steps at once towards the mean velocity of all n, with the
//! weight 1 − (τ/(τ + h))ⁿ.

use crate::parameter::{Checked, Named};
use crate::scalar::{is_zero, lit};
use crate::{Affine, Bristle, Contact, Scalar};

/// Parameters of a [`VelocityFromPosition`]: of the encoder in a
/// [`FeedbackCompensator`](super::FeedbackCompensator) and a
/// [`FrictionObserver`](super::FrictionObserver).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct VelocityFromPositionParameters<T> {
    /// Sample time h \[s\], positive.
    pub sample_time: T,
    /// Time constant τ \[s\] of the filter of the velocity, zero for none. It smooths the velocity
    /// at which the curve is read, and the ė of an observer; the bristle itself moves by the
    /// unfiltered displacement. One count changes the filtered velocity by q/(τ + h), and the
    /// filter delays it by about τ. Begin with 0.1/ω_c to 0.3/ω_c, where ω_c [rad/s] is the
    /// bandwidth of the controller.
    #[doc(alias = "tau")]
    pub time_constant: T,
    /// Speed \[m/s\] that the mechanism cannot exceed, positive: a faster sample is refused as a
    /// fault.
    pub fastest: T,
    /// Size of one encoder count q \[m\], its resolution; zero for a position without steps. It
    /// only widens the test for faults: n samples may move by fastest·h·n + 2 q. A coarse encoder
    /// that is sampled quickly needs this: with q > fastest·h every single count would be refused.
    pub count: T,
}

/// What one sample of an encoder says of the motion, from [`VelocityFromPosition::step`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionSample<T> {
    /// Displacement since the last good sample \[m\]; zero for the first sample and after a
    /// restart.
    pub displacement: T,
    /// Filtered velocity v_f [m/s].
    pub velocity: T,
    /// Whether the mechanism was found elsewhere (moved by hand, or the encoder was reset), and the
    /// measurement starts again from there.
    pub restarted: bool,
    /// The displacement over one sample time [m/s].
    pub(super) secant: T,
}

/// Displacement and velocity from sampled positions, without those that cannot be true. Feedback
/// and the observer have one inside; by itself it serves a compensator or an estimator of your own.
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
/// assert!(encoder.step(0.0).is_some()); // the first position
/// let sample = encoder.step(2e-6).unwrap();
/// assert_eq!(sample.displacement, 2e-6); // m
/// assert!((sample.velocity - 0.2 * 2e-3).abs() < 1e-15); // m/s: the filter takes a fifth of it
/// assert_eq!(encoder.step(f64::NAN), None); // refused: only the time goes on
/// assert_eq!(encoder.step(0.5), None); // half a metre in two milliseconds
/// assert_eq!(encoder.step(5e-6).unwrap().displacement, 5e-6 - 2e-6);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityFromPosition<T> {
    pub(super) sample_time: T,
    /// h/(τ + h): what a new velocity weighs in the filter.
    pub(super) weight: T,
    pub(super) fastest: T,
    /// Two counts.
    slack: T,
    /// Position of the last good sample.
    position: Option<T>,
    /// Displacement of the last sample, if it was refused for being too far away.
    elsewhere: Option<T>,
    /// Number of samples since the last good one, including the coming one.
    elapsed: T,
    /// Weight of so many samples at once, 1 − (1 − weight)^elapsed.
    elapsed_weight: T,
    filtered: T,
}

impl<T: Scalar> VelocityFromPosition<T> {
    /// This encoder going on after another: with its position, velocity and refused samples.
    pub(super) fn after(self, before: &Self) -> Self {
        let Self { position, elsewhere, elapsed, filtered, .. } = *before;
        let elapsed_weight = if self.weight == before.weight {
            before.elapsed_weight
        } else {
            T::one() - (T::one() - self.weight).powf(elapsed)
        };
        Self { position, elsewhere, elapsed, elapsed_weight, filtered, ..self }
    }

    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a sample time or a fastest speed that is not positive, and a time constant or a
    /// count that is negative or not finite.
    pub fn new(parameters: VelocityFromPositionParameters<T>) -> Checked<Self> {
        let sample_time = Named("sample_time", parameters.sample_time).positive()?;
        let time_constant = Named("time_constant", parameters.time_constant).non_negative()?;
        let weight = sample_time / (time_constant + sample_time);
        Ok(Self {
            sample_time,
            weight,
            fastest: Named("fastest", parameters.fastest).positive()?,
            slack: lit::<T>(2.0) * Named("count", parameters.count).non_negative()?,
            position: None,
            elsewhere: None,
            elapsed: T::one(),
            elapsed_weight: weight,
            filtered: T::zero(),
        })
    }

    /// Takes a position \[m\].
    ///
    /// The answer is `None` for a position that is not finite, or farther away than the fastest
    /// speed allows. The next good sample's displacement covers the refused ones.
    ///
    /// Two positions in a row that are too far away but close to one another are believed: the
    /// mechanism was moved by hand, or its encoder was reset. It goes on from there with no
    /// displacement, see [`MotionSample::restarted`].
    #[inline]
    #[must_use = "`None` is a refused sample"]
    pub fn step(&mut self, position: T) -> Option<MotionSample<T>> {
        let sample = self.arrive(position - self.position.unwrap_or(position))?;
        self.position = Some(position);
        Some(sample)
    }

    /// Takes a displacement \[m\] since the last call with a finite one, such as a difference of
    /// counts times the size of a count: in `f32`, the difference of two positions far from zero
    /// has lost its digits. Call either this or [`VelocityFromPosition::step`], not both in turn.
    ///
    /// Displacements that were refused for being too large are remembered, so that a glitch and the
    /// way back from it cancel. After a NaN hand in the displacement since the call before the NaN.
    #[inline]
    #[must_use = "`None` is a refused sample"]
    pub fn advance(&mut self, displacement: T) -> Option<MotionSample<T>> {
        if !displacement.is_finite() {
            self.miss();
            return None;
        }
        self.arrive(self.elsewhere.unwrap_or_else(T::zero) + displacement)
    }

    /// Lets a sample time go by without a sample.
    #[inline]
    pub(super) fn miss(&mut self) {
        self.elapsed += T::one();
        self.elapsed_weight += self.weight * (T::one() - self.elapsed_weight);
    }

    /// Takes a displacement \[m\] from the last good sample, if the mechanism can be that fast.
    #[inline]
    fn arrive(&mut self, displacement: T) -> Option<MotionSample<T>> {
        let farthest = self.fastest * self.sample_time;
        let possible = displacement.abs() <= farthest * self.elapsed + self.slack;
        let secant = displacement / self.sample_time;
        let near = |other: T| (displacement - other).abs() <= farthest + self.slack;
        if possible {
            self.filtered += self.elapsed_weight * (secant / self.elapsed - self.filtered);
        } else if !self.elsewhere.is_some_and(near) {
            self.elsewhere = displacement.is_finite().then_some(displacement);
            self.miss();
            return None;
        }
        (self.elapsed, self.elapsed_weight, self.elsewhere) = (T::one(), self.weight, None);
        let (displacement, secant) =
            if possible { (displacement, secant) } else { (T::zero(), T::zero()) };
        Some(MotionSample { displacement, velocity: self.filtered, restarted: !possible, secant })
    }

    /// The filtered velocity v_f [m/s].
    pub fn velocity(&self) -> T {
        self.filtered
    }

    /// Back to the beginning: no position yet, and no velocity.
    pub fn reset(&mut self) {
        (self.elapsed, self.elapsed_weight, self.elsewhere) = (T::one(), self.weight, None);
        (self.position, self.filtered) = (None, T::zero());
    }
}

/// The curve is read at no less than this fraction of the secant velocity, so that the ratio of the
/// two stays bounded.
const SLOWEST: f64 = 1e-3;

/// The coefficients of a bristle that is moved by a displacement, with the curve read at another
/// speed.
///
/// A bristle is moved by distance: along a displacement dx at speed u, dz/dx = r(u) − sgn(dx)
/// (λ(u)/u) z. Over a sample with the secant velocity w this is the step of a held velocity w with
/// the relaxation rate λ(u)|w|/u. The speed u is the modulus of the smooth velocity \[m/s\], its
/// direction that of w.
#[inline]
pub(super) fn along<T: Scalar, M: Bristle<T, Deflection = T>>(
    contact: &Contact<T, M>,
    secant: T,
    smooth: T,
    deflection: T,
) -> Affine<T> {
    if is_zero(secant) {
        return Affine { relaxation: T::zero(), ..contact.affine(smooth, deflection) };
    }
    let speed = smooth.abs().larger(secant.abs() * lit(SLOWEST));
    let velocity = if secant < T::zero() { -speed } else { speed };
    let affine = contact.affine(velocity, deflection);
    Affine { relaxation: affine.relaxation * (secant.abs() / speed), ..affine }
}
