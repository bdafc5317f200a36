//! What happens while nothing moves, between the stages of a long step, or at a reversal.
//!
//! A step over which hardly a state moves has hardly an error to estimate, and the next one is
//! longer. A force or a load that acts within it falls between the stages. So such a step is looked
//! into: the span has a thousand pieces, and each piece that the step covers is asked for the rates
//! at one time in it, at the state where the step begins, for the state hardly moves. They have to
//! be those of the step's curve. The times are spread by the golden ratio, so that no period falls
//! between them.
//!
//! A long step over which states move may pass over a floor that they touch between two stages. It
//! is asked for the rates on its curve in a tenth as many pieces: they have to be its slopes. So is
//! a step of any length in its middle, soon after a kink that nobody declared: what has left a
//! floor for a moment may be back before the next stage. And so is a step that begins or ends at a
//! reversal, closer and closer to it.

use super::dense_output::DenseOutput;
use super::integration::Integration;
use super::locked::Interval;
use super::stepper::{Field, OneStep, Point};
use super::storage::{Entries, States};
use super::system::Equations;
use super::tolerance::Tolerances;
use crate::Scalar;
use crate::scalar::{lit, to_f64};

/// Pieces of a span.
const PIECES: f64 = 1000.0;

/// A step over fewer pieces is left to its stages; where states move, one over fewer times so many.
const LEAST: f64 = 2.0;

/// The part of a piece between the times in two neighbouring ones: 1/φ.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// In a step that moves a state by more tolerances, states change within a piece.
const HARDLY: f64 = 100.0;

/// So many pieces are one where states move.
const MOVING: f64 = 10.0;

/// What happens between two stages lasts no longer than this part of a step: of order 8 none lies
/// from 0.31 to 0.61.
const LASTS: f64 = 0.3;

/// The slope of a curve is that over this part of the step to both sides.
const NEAR: f64 = 1e-3;

/// The parts of a step at a reversal that no stage of any method sees, ...
const UNSEEN: f64 = 0.03;

/// ... from one to the next.
const CLOSER: f64 = 0.1;

impl<T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, M: OneStep<T, V>, K>
    Integration<'_, T, V, S, M, K>
{
    /// Answers with a shorter step where the rates would move a state within one piece farther from
    /// the curve than its tolerance, and than the whole step moves any.
    #[inline]
    pub(super) fn unseen(&mut self, end: &Point<T, V>, interval: Interval<T>) -> Option<T> {
        let step = end.time - self.point.time;
        let count = to_f64(step / self.progress.span()) * PIECES;
        let size = |change: V| to_f64(change.over(&end.scale));
        let moved = end.state.with(&self.point.state, |end, start| end - start);
        let moved = if count > LEAST { size(moved) } else { f64::INFINITY };
        if !(moved < HARDLY) {
            let pieces = count / MOVING;
            let looks = (pieces > LEAST).then(|| (pieces, pieces.recip()));
            let looks = looks.or(self.kinks.is_near().then_some((1.0, LASTS)))?;
            return self.passed_over(end, interval, looks);
        }
        let curve = self.step.dense_output.clone();
        let (_, mut field, from) = self.parts(interval);
        let (piece, mut within, mut before) = (step * lit(1.0 / count), 0.5, from.state.clone());
        for number in 0..count as u32 {
            let done = f64::from(number);
            let after = curve.at(lit((done + 1.0) / count));
            if !(size(after.with(&from.state, |after, start| after - start)) < HARDLY) {
                return None;
            }
            let rate = field.rate(from.time + piece * lit(done + within), &from.state);
            if !(size(after.like(|i| rate[i] * piece + before[i] - after[i])) <= moved.max(1.0)) {
                return Some(piece * lit(done.max(0.5)));
            }
            before = after;
            within = (within + GOLDEN) % 1.0;
        }
        None
    }

    /// The same over some pieces of a step over which states move: with a shorter one where its
    /// curve strays within one of them, for so much of the step, by more than the solution may be
    /// off.
    #[cold]
    fn passed_over(
        &mut self,
        end: &Point<T, V>,
        interval: Interval<T>,
        (count, lasts): (f64, f64),
    ) -> Option<T> {
        let most = self.most_growth?;
        let curve = self.own_curve(end, interval);
        let (_, mut field, from) = self.parts(interval);
        let (step, mut within) = (end.time - from.time, 0.5);
        for number in 0..count as u32 {
            let place = (f64::from(number) + within) / count;
            let rate = field.rate(from.time + step * lit(place), &curve.at(lit(place)));
            let off = astray(&curve, (place, NEAR), &rate, step);
            if !(to_f64(off.over(&end.scale)) * lasts <= most) {
                return Some(step * lit(place * 0.9));
            }
            within = (within + GOLDEN) % 1.0;
        }
        None
    }

    /// Answers with a shorter step where the rates right after a reversal or right before one lead
    /// a state farther off the curve than the solution may be: the friction of a body at rest falls
    /// within a small part of the way. They act on what there is of a velocity, over what there is
    /// of the time: on the square of the part.
    #[inline]
    pub(super) fn strayed(
        &mut self,
        end: &Point<T, V>,
        interval: Interval<T>,
        is_cut: bool,
    ) -> Option<T> {
        let has_turned = self.locks.entries().iter().any(|lock| lock.fresh);
        let most = self.most_growth.filter(|_| has_turned || is_cut)?;
        let least = self.settings.tolerances.as_ref().map_or(1.0, Tolerances::largest);
        let curve = self.own_curve(end, interval);
        let (_, mut field, from) = self.parts(interval);
        let step = end.time - from.time;
        for (_, is_end) in [(has_turned, false), (is_cut, true)].into_iter().filter(|side| side.0) {
            let place = |part: f64| if is_end { 1.0 - part } else { part };
            let mut part = UNSEEN;
            while part * part > least {
                let at = lit(place(part));
                let rate = field.rate(from.time + step * at, &curve.at(at));
                let off = astray(&curve, (place(part), CLOSER * part), &rate, step);
                if !(to_f64(off.over(&end.scale)) * part <= most) {
                    return Some(step * lit(place(3.0 * part)));
                }
                part *= CLOSER;
            }
        }
        None
    }
}

/// What a rate makes of a whole step, less what the slope of its curve at a place does, which is
/// that over so much of the step to both sides.
fn astray<T: Scalar, V: States<T>>(
    curve: &DenseOutput<T, V>,
    (place, near): (f64, f64),
    rate: &V,
    step: T,
) -> V {
    let [before, after] = [place - near, place + near].map(|place| curve.at(lit(place)));
    let way = after.with(&before, |after, before| (after - before) * lit(0.5 / near));
    rate.with(&way, |rate, way| rate * step - way)
}
