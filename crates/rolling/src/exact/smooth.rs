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
//! The error of a piece is estimated from two halves, which are then used, by how they differ from
//! the whole: in what they make of the bristles that stay, in ∫ z dξ of those that enter, and in
//! the distance. In smooth motion the halves are some fifteen times better than that; of a stiff
//! bristle, which follows its stationary deflection, they are not.
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

use super::queue::Held;
use super::{ExactPatch, Memory, Motion};
use crate::patch::coefficients;
use bristle::parameter::{Checked, Named, Rule};
use bristle::root::enclose;
use bristle::scalar::{is_zero, lit};
use bristle::signal::Signal;
use bristle::{Bristle, Scalar};

/// A piece of a span that moves the bristles by more of the patch than this is halved, …
const LONGEST: f64 = 0.25;
/// … at most so many times.
const HALVINGS: usize = 8;
/// Most pieces of a span.
const MOST_PIECES: f64 = 1e5;

/// The end of a piece of a span and the steps over it.
type Piece<T> = (T, [Option<Held<T>>; 2]);

/// Reversals within this part of a step's ends are passed over: the error is of the square of it.
/// There a signal that jumps at an end still has the value that it has inside.
const ENDS: f64 = 1e-6;

impl<T: Scalar, M: Bristle<T, Deflection = T>, const N: usize, B: Memory<T, N>>
    ExactPatch<T, M, N, B>
{
    /// Rolls on over a span of time \[s\] with velocities that vary, and returns the friction
    /// force F \[N\] at its end, with the velocity of that time.
    ///
    /// A span is divided where a signal is not smooth and where v reverses (unless it does so
    /// twice within a third of a piece), so that the order holds there too; where |v| crosses a
    /// knot of a tabulated curve it does not. Spans of different lengths may follow each other.
    /// Spans that are merged, V h below [`ExactPatch::narrowest`], gain nothing from being shorter.
    ///
    /// ```
    /// use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential};
    /// use bristle::signal::{Sine, SineParameters};
    /// use bristle::{FrBd, paper};
    /// use bristle::curve::Stribeck;
    /// use bristle::rheology::KelvinVoigt;
    ///
    /// let curve = Stribeck::new(paper::TYRE_CURVE)?;
    /// let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
    /// let tyre = Patch::new(PatchParameters {
    ///     model: FrBd::new(curve, bristle),
    ///     length: bristle_rolling::TYRE_LENGTH,
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
    ) -> Checked<T> {
        self.roll_over(motion, span, None)
    }

    /// Rolls on as [`ExactPatch::follow`] does, in pieces so short that the error of the force is
    /// about a tolerance or less, as a share F/F_z \[–\] of the normal force: the error that the
    /// pieces of one crossing of the patch (or of one relaxation of its bristles, if that is
    /// shorter) make together.
    ///
    /// Not in it is the error of merging, see [`ExactPatch`]: it needs memory for segments that are
    /// as narrow as the pieces.
    ///
    /// ```
    /// use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential};
    /// use bristle::signal::{Sine, SineParameters};
    /// use bristle::{FrBd, paper};
    /// use bristle::curve::Stribeck;
    /// use bristle::rheology::KelvinVoigt;
    ///
    /// let curve = Stribeck::new(paper::TYRE_CURVE)?;
    /// let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
    /// let tyre = Patch::new(PatchParameters {
    ///     model: FrBd::new(curve, bristle),
    ///     length: bristle_rolling::TYRE_LENGTH,
    ///     pressure: PolynomialExponential::parabolic(),
    /// })?;
    /// let swing = SineParameters { mean: 0.1, amplitude: 0.5, frequency: 10.0, phase: 0.0 };
    /// let motion = Motion { slip_velocity: Sine::new(swing)?, rolling_speed: 16.0 };
    /// let ratio = |tolerance| -> Result<f64, bristle::ParameterError> {
    ///     let mut rolling = tyre.exact_in(2000)?;
    ///     Ok(rolling.follow_within(&motion, 0.0..0.05, tolerance)? / tyre.normal_force())
    /// };
    /// assert!((ratio(1e-6)? - ratio(1e-9)?).abs() < 1e-6);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses what [`ExactPatch::follow`] refuses, a tolerance below a thousand roundings of the
    /// scalar, and a span of more than 100 000 pieces, as that of a noisy signal; the patch is as
    /// it was.
    pub fn follow_within<S: Signal<T>, W: Signal<T>>(
        &mut self,
        motion: &Motion<S, W>,
        span: Range<T>,
        tolerance: T,
    ) -> Checked<T> {
        let least = lit::<T>(1000.0) * T::default_epsilon();
        let tolerance = Named("tolerance", tolerance).positive()?;
        Named("tolerance", tolerance).at_least("a thousand roundings", least)?;
        self.roll_over(motion, span, Some(tolerance))
    }

    fn roll_over<S: Signal<T>, W: Signal<T>>(
        &mut self,
        motion: &Motion<S, W>,
        span: Range<T>,
        tolerance: Option<T>,
    ) -> Checked<T> {
        let from = Named("start of the span", span.start).finite()?;
        let to = Named("end of the span", span.end).finite()?;
        Named("duration", to - from).non_negative()?;
        let at_end = slip_at(motion, to)?;
        let affine_at_end = coefficients(self.patch.contact(), at_end)?;
        // With a tolerance a piece is at most twice as long as the one before.
        let until = |time: T, last: T| tolerance.map_or(to, |_| to.smaller(time + last + last));
        // Look first, so that a refusal leaves the patch as it was.
        let (mut time, mut last, mut first, mut pieces) = (from, to - from, None, 0);
        while time < to {
            let piece = self.next_piece(motion, time..until(time, last), tolerance)?;
            (time, last) = (piece.0, piece.0 - time);
            first = first.or(Some(piece));
            pieces += 1;
            Named("pieces of the span", pieces as f64).at_most("limit", MOST_PIECES)?;
        }
        (time, last) = (from, to - from);
        while time < to {
            let look = || self.next_piece(motion, time..until(time, last), tolerance);
            let (next, held) = first.take().map_or_else(look, Ok)?;
            held.iter().flatten().for_each(|held| self.queues[0].advance(held));
            (time, last) = (next, next - time);
        }
        Ok(self.patch.force_of(&self.queues[0], &affine_at_end, at_end))
    }

    /// The end of the first piece of a span that is smooth, moves the bristles by little and keeps
    /// the tolerance, and what happens over it or over its halves.
    fn next_piece<S: Signal<T>, W: Signal<T>>(
        &self,
        motion: &Motion<S, W>,
        Range { start, mut end }: Range<T>,
        tolerance: Option<T>,
    ) -> Checked<Piece<T>> {
        let Motion { slip_velocity, rolling_speed } = motion;
        let kinks = [slip_velocity.next_kink(start, end), rolling_speed.next_kink(start, end)];
        let inside = kinks.into_iter().flatten().filter(|kink| *kink > start);
        end = inside.fold(end, T::smaller);
        let mut halvings = 0;
        loop {
            end = reversal(motion, start, end)?.unwrap_or(end);
            let middle = start + (end - start) * lit(0.5);
            let whole = self.held(motion, start..end)?;
            let last = !(middle > start && middle < end);
            if last || whole.distance <= lit(LONGEST) {
                let Some(tolerance) = tolerance.filter(|_| !last) else {
                    return Ok((end, [Some(whole), None]));
                };
                let halves = [self.held(motion, start..middle)?, self.held(motion, middle..end)?];
                let (error, share) = self.error_of(&whole, &halves);
                if error <= tolerance * share {
                    return Ok((end, halves.map(Some)));
                }
            } else if halvings >= HALVINGS {
                let parts = (1_usize << HALVINGS) as f64;
                let rule = Rule::AtMost { other: "the limit for one span", limit: LONGEST * parts };
                let crossed = whole.distance * lit(parts);
                return Err(Named("crossings of the patch", crossed).refused(rule));
            }
            halvings += 1;
            end = middle;
        }
    }

    /// The estimated error of two halves of a piece, over the normal force, and the part of a
    /// crossing or of a relaxation that they take.
    fn error_of(&self, whole: &Held<T>, [first, second]: &[Held<T>; 2]) -> (T, T) {
        let both = second.map.after(first.map);
        let entered = |held: &Held<T>| held.inflow.moments::<1>(T::one(), T::zero())[0];
        let older = second.map.of_moments([entered(first)], first.distance, T::zero())[0];
        let share = whole.distance + (T::one() - both.decay);
        // The deflection that the piece tends to; a bristle that never relaxes has no use for it.
        let typical = if is_zero(share) { T::zero() } else { both.offset.abs() / share };
        let off = (whole.map.offset - both.offset).abs()
            + typical * (whole.map.decay - both.decay).abs()
            + (entered(whole) - entered(second) - older).abs()
            + typical * (whole.distance - first.distance - second.distance).abs();
        // Not below the roundings of a piece.
        let rounding = lit::<T>(8.0) * T::default_epsilon() * typical;
        let off = if off > rounding { off } else { T::zero() };
        (self.patch.model().storage_stiffness() * off, share)
    }

    /// A step over a span with the motions at its two Gauss points.
    #[inline]
    fn held<S: Signal<T>, W: Signal<T>>(
        &self,
        motion: &Motion<S, W>,
        span: Range<T>,
    ) -> Checked<Held<T>> {
        let duration = span.end - span.start;
        let offset = duration * (lit::<T>(3.0).sqrt() / lit(6.0));
        let middle = span.start + duration * lit(0.5);
        let at = |time: T| {
            let motion = Motion {
                slip_velocity: motion.slip_velocity.value(time),
                rolling_speed: motion.rolling_speed.value(time),
            };
            self.patch.frozen(motion)
        };
        let ([first], [second]) = (at(middle - offset)?, at(middle + offset)?);
        let half: T = lit(0.5);
        let [relaxation1, relaxation2] = [first, second].map(|point| point.affine.relaxation);
        let [drive1, drive2] = [first, second].map(|point| point.drive());
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

fn slip_at<T: Scalar, S: Signal<T>, W>(motion: &Motion<S, W>, time: T) -> Checked<T> {
    Named("slip_velocity", motion.slip_velocity.value(time)).finite()
}

/// The first reversal of v between two times, of those that looking at its thirds shows.
fn reversal<T: Scalar, S: Signal<T>, W>(
    motion: &Motion<S, W>,
    from: T,
    to: T,
) -> Checked<Option<T>> {
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
