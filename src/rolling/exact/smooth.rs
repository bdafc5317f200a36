//! Velocities that vary smoothly over a step, to fourth order.
//!
//! A bristle obeys ż = −λ(t) z + u(t), u = r v. Over a step h with the values 1 and 2 at its two
//! Gauss points, t = (½ ∓ √3/6) h, the step with the held coefficients
//!
//! λ̄ = (λ₁ + λ₂)/2,  ū = (u₁ + u₂)/2 + w (√3/12) h (λ₁ u₂ − λ₂ u₁),  w = 1/√(1 + (λ̄h/6)²)
//!
//! has an error of O(h⁵): the Magnus expansion of the affine equation, which needs one commutator.
//! w → 1 keeps the order and lets a stiff bristle end at u/λ of the end of the step. The bristles
//! that enter have the profile of held coefficients over the distance V̄h, and in addition
//!
//! (√3/2) h (u₂ V₁ − u₁ V₂)/V̄ e^(−λ̄h/2) t (1 − t)
//!
//! at the part t of that distance. This makes the profile right to O(h³) everywhere, and its
//! integral and first moment to O(h⁵). The force is of fourth order wherever the outlet cuts.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | v, V | slip velocity, rolling speed over the length of the patch | m/s, 1/s |
//! | λ, r | relaxation rate, drive of the friction model | 1/s, – |
//!
//! Source: S. Blanes, F. Casas, J. A. Oteo, J. Ros, "The Magnus expansion and some of its
//! applications", Physics Reports 470, 2009, for the expansion; the profile of the bristles that
//! enter is derived here.

use core::ops::Range;

use super::queue::{Held, Segment};
use super::{Crossing, ExactPatch, Motion, RateDependent};
use crate::parameter::{self, ParameterError, Rule};
use crate::root::enclose;
use crate::scalar::{is_zero, lit};
use crate::signal::Signal;
use crate::{Affine, Scalar};

/// A piece of a span that moves the bristles by more of the patch than this is halved, …
const LONGEST: f64 = 0.25;
/// … at most so many times.
const HALVINGS: usize = 8;

/// Reversals within this part of a step's ends are passed over: the error is of the square of it.
/// There a signal that jumps at an end still has the value that it has inside.
const ENDS: f64 = 1e-6;

impl<T, M, const N: usize, B> ExactPatch<T, M, N, B>
where
    T: Scalar,
    M: RateDependent<T>,
    B: AsRef<[Segment<T, N>]> + AsMut<[Segment<T, N>]>,
{
    /// Rolls on over a span of time \[s\] with velocities that vary, and returns the friction
    /// force F \[N\] at its end, with the velocity of that time.
    ///
    /// A span is divided where a signal is not smooth and where v reverses (unless it does so
    /// twice within a third of it), so that the order holds there too; where |v| crosses a knot of
    /// a tabulated curve it does not. Spans of different lengths may follow each other. Spans that
    /// are merged, V h below [`ExactPatch::narrowest`], gain nothing from being shorter.
    ///
    /// ```
    /// use bristle::rolling::{Motion, Patch, PatchParameters, PolynomialExponential};
    /// use bristle::signal::{Sine, SineParameters};
    /// use bristle::{FrBd, paper};
    /// use bristle::curve::Stribeck;
    /// use bristle::rheology::KelvinVoigt;
    ///
    /// let curve = Stribeck::new(paper::TYRE_CURVE)?;
    /// let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
    /// let tyre = Patch::new(PatchParameters {
    ///     model: FrBd::new(curve, bristle),
    ///     length: paper::TYRE_LENGTH,
    ///     pressure: PolynomialExponential::parabolic(),
    /// })?;
    /// let swing = SineParameters { mean: 0.1, amplitude: 0.5, frequency: 10.0, phase: 0.0 };
    /// let motion = Motion {
    ///     slip_velocity: Sine::new(swing)?,
    ///     rolling_speed: 16.0,
    /// };
    /// let mut rolling = tyre.exact_in(100)?;
    /// let mut force = 0.0;
    /// for millisecond in 0..100 {
    ///     let time = 1e-3 * f64::from(millisecond);
    ///     force = rolling.follow(&motion, time..time + 1e-3)?;
    /// }
    /// assert!(force > 0.0 && force < tyre.normal_force());
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses a span that ends before it begins, a signal that is not finite, a rolling speed
    /// below zero, a velocity at which the model's relaxation rate or drive is not finite, and a
    /// span over more than about 64 crossings of the patch; the patch is as it was.
    pub fn follow<S: Signal<T>, W: Signal<T>>(
        &mut self,
        motion: &Motion<S, W>,
        span: Range<T>,
    ) -> Result<T, ParameterError> {
        let from = parameter::finite("start of the span", span.start)?;
        let to = parameter::finite("end of the span", span.end)?;
        parameter::non_negative("duration", to - from)?;
        let at_end = slip_at(motion, to)?;
        let affine_at_end = self.coefficients(at_end)?;
        // Look first, so that a refusal leaves the patch as it was.
        let (mut time, mut only) = (from, None);
        while time < to {
            let (next, held) = self.next_piece(motion, time..to)?;
            only = (time <= from && next >= to).then_some(held);
            time = next;
        }
        if let Some(held) = only {
            self.queue.advance(&held);
        } else {
            let mut time = from;
            while time < to {
                let (next, held) = self.next_piece(motion, time..to)?;
                self.queue.advance(&held);
                time = next;
            }
        }
        Ok(self.force_of(&affine_at_end, at_end))
    }

    /// The end of the first piece of a span that is smooth and moves the bristles by little, and
    /// what happens over it.
    fn next_piece<S: Signal<T>, W: Signal<T>>(
        &self,
        motion: &Motion<S, W>,
        Range { start, mut end }: Range<T>,
    ) -> Result<(T, Held<T>), ParameterError> {
        let Motion { slip_velocity, rolling_speed } = motion;
        let kinks = [slip_velocity.next_kink(start, end), rolling_speed.next_kink(start, end)];
        for kink in kinks.into_iter().flatten() {
            if kink > start && kink < end {
                end = kink;
            }
        }
        if let Some(reversal) = reversal(motion, start, end)? {
            end = reversal;
        }
        let half = lit::<T>(0.5);
        let mut crossed = None;
        for _ in 0..=HALVINGS {
            let duration = end - start;
            let middle = start + duration * half;
            let at = |time: T| {
                self.patch.forward(Motion {
                    slip_velocity: slip_velocity.value(time),
                    rolling_speed: rolling_speed.value(time),
                })
            };
            let offset = duration * (lit::<T>(3.0).sqrt() / lit(6.0));
            let (first, second) = (at(middle - offset)?, at(middle + offset)?);
            let distance = (first.transport + second.transport) * half * duration;
            if distance <= lit(LONGEST) || !(middle > start && middle < end) {
                return Ok((end, self.held(&first, &second, duration)?));
            }
            crossed = crossed.or(Some(distance));
            end = middle;
        }
        let limit = LONGEST * (1_usize << HALVINGS) as f64;
        let rule = Rule::AtMost { other: "the limit for one span", limit };
        Err(parameter::refused("crossings of the patch", crossed.unwrap_or_else(T::zero), rule))
    }

    /// A step with the motions at its two Gauss points.
    #[inline]
    fn held(
        &self,
        first: &Crossing<T>,
        second: &Crossing<T>,
        duration: T,
    ) -> Result<Held<T>, ParameterError> {
        let half: T = lit(0.5);
        let Affine { relaxation: relaxation1, drive, .. } =
            self.coefficients(first.slip_velocity)?;
        let drive1 = drive * first.slip_velocity;
        let Affine { relaxation: relaxation2, drive, .. } =
            self.coefficients(second.slip_velocity)?;
        let drive2 = drive * second.slip_velocity;
        let root_of_three = lit::<T>(3.0).sqrt();
        let relaxation = (relaxation1 + relaxation2) * half;
        let sixth = relaxation * duration / lit(6.0);
        let commutator = duration * (relaxation1 * drive2 - relaxation2 * drive1);
        let damped =
            commutator * root_of_three / (lit::<T>(12.0) * (T::one() + sixth * sixth).sqrt());
        let transport = (first.transport + second.transport) * half;
        let drive = (drive1 + drive2) * half + damped;
        let mut held = Held::new(relaxation, drive, transport, duration);
        if transport > T::zero() {
            let turn = (drive2 * first.transport - drive1 * second.transport) / transport;
            held.inflow.bulge = root_of_three * half * duration * turn * held.map.decay.sqrt();
        }
        Ok(held)
    }
}

fn slip_at<T: Scalar, S: Signal<T>, W>(
    motion: &Motion<S, W>,
    time: T,
) -> Result<T, ParameterError> {
    parameter::finite("slip_velocity", motion.slip_velocity.value(time))
}

/// The first reversal of v between two times.
fn reversal<T: Scalar, S: Signal<T>, W>(
    motion: &Motion<S, W>,
    from: T,
    to: T,
) -> Result<Option<T>, ParameterError> {
    let mut last = None;
    for part in [ENDS, 1.0 / 3.0, 2.0 / 3.0, 1.0 - ENDS] {
        let time = from + (to - from) * lit(part);
        let v = slip_at(motion, time)?;
        if is_zero(v) {
            continue;
        }
        if let Some((before, earlier)) = last
            && (v > T::zero()) != (earlier > T::zero())
        {
            let slip = |time| motion.slip_velocity.value(time);
            let (_, after) = enclose(slip, (before, earlier), (time, v), T::zero());
            return Ok((after > from && after < to).then_some(after));
        }
        last = Some((time, v));
    }
    Ok(None)
}
