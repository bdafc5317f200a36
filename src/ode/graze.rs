//! Kinks of which a [switching function](super::System::switching_function) tells.
//!
//! A step over a zero of the function shall end just beyond it: an error estimate may vanish by
//! chance over a kink. A function that has one sign at both ends of a step, and falls from both
//! towards the middle, may have two zeros in between, where a floor is touched or a tip slips for a
//! moment. It is followed to its lowest value by parabolas through three points.
//!
//! What is zero within the tolerances of the states tells nothing: a gap at rest would cut every
//! step where rounding turns its sign.

use super::dense_output::DenseOutput;
use super::integration::Integration;
use super::locked::Interval;
use super::stepper::{OneStep, Point, Stepper};
use super::storage::States;
use super::system::Equations;
use crate::Scalar;
use crate::scalar::{lit, to_f64};

/// How a value changes at an end of a step shows after so much of it, on any curve. A zero that is
/// nearer is at the end.
const SOON: f64 = 1e-2;

/// Parts of a step, of which the lowest end begins the search.
const PARTS: usize = 6;

/// Parabolas, each through the last one's lowest point.
const PARABOLAS: u32 = 4;

/// Halvings of the part of a step in which the zero lies.
const HALVINGS: u32 = 10;

/// A place in a step, and the value there.
type Value<T> = (T, T);

impl<T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, M: OneStep<T, V>, K>
    Integration<'_, T, V, S, M, K>
{
    /// Answers with a shorter step, to just beyond the first zero between the ends.
    #[inline]
    pub(super) fn grazed(&mut self, end: &Point<T, V>, interval: Interval<T>) -> Option<T> {
        let start = self.system.switching(self.point.time, &self.point.state, &self.branches)?;
        let last = self.system.switching(end.time, &end.state, &self.branches)?;
        let (along, one) = ((end.time - self.point.time, start.signum()), T::one());
        let touches = start * last > T::zero();
        let curve = &self.step.dense_output;
        let near = [lit(SOON), one - lit(SOON)].map(|place| self.value_within(curve, along, place));
        let looks = match near {
            [Some(first), Some(near)] if touches => first < start.abs() && near < last.abs(),
            [Some(first), Some(near)] => first > T::zero() && near < T::zero(),
            _ => false,
        };
        looks.then(|| self.zero(end, interval, (along, touches)))?
    }

    /// The length of a step to just beyond the first zero, or the first of two.
    #[cold]
    fn zero(
        &mut self,
        end: &Point<T, V>,
        interval: Interval<T>,
        (along, touches): ((T, T), bool),
    ) -> Option<T> {
        let noise = self.noise(end)?;
        let (stepper, mut field, from) = self.parts(interval);
        let curve = stepper.dense_output(&mut field, from, end);
        let value = |place| self.value_within(&curve, along, place);
        let ends = (T::zero(), T::one());
        let (mut before, mut beyond) = if touches { deepest(&value)? } else { ends };
        let is_felt = value(beyond)? < -noise && (touches || value(before)? > noise);
        if !is_felt {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = (before + beyond) * lit(0.5);
            if value(middle)? < T::zero() { beyond = middle } else { before = middle }
        }
        Some(along.0 * beyond)
    }

    /// What the switching function may be off where each state is off by its tolerance.
    fn noise(&self, end: &Point<T, V>) -> Option<T> {
        let value = |state: &V| self.system.switching(end.time, state, &self.branches);
        let (last, mut beside) = (value(&end.state)?, end.state.clone());
        let mut noise = T::zero();
        for i in 0..beside.count() {
            beside[i] += end.scale[i];
            noise += (value(&beside)? - last).abs();
            beside[i] = end.state[i];
        }
        Some(noise)
    }

    /// The switching function within a step of a length on a curve, times a sign.
    fn value_within(&self, curve: &DenseOutput<T, V>, (step, side): (T, T), place: T) -> Option<T> {
        let time = self.point.time + step * place;
        let value = self.system.switching(time, &curve.at(place), &self.branches)?;
        Some(side * value)
    }
}

/// Two places with a zero in between, and a negative value at the later one, if there are any.
#[cold]
fn deepest<T: Scalar>(value: &impl Fn(T) -> Option<T>) -> Option<(T, T)> {
    let mut values = [(T::zero(), T::zero()); PARTS + 1];
    for (part, to) in values.iter_mut().enumerate() {
        let place = lit(part as f64 / PARTS as f64);
        *to = (place, value(place)?);
    }
    let least = |x: &&[Value<T>], y: &&[Value<T>]| to_f64(x[1].1).total_cmp(&to_f64(y[1].1));
    let &[first, middle, last] = values.windows(3).min_by(least)? else { return None };
    let mut points = [first, middle, last];
    for _ in 0..PARABOLAS {
        let [first, middle, last] = points;
        if middle.1 < T::zero() {
            break;
        }
        let place = lowest(points)?;
        let found = (place, value(place)?);
        points = match (found.1 < middle.1, place < middle.0) {
            (true, true) => [first, found, middle],
            (true, false) => [middle, found, last],
            (false, true) => [found, middle, last],
            (false, false) => [first, middle, found],
        };
    }
    (points[1].1 < T::zero()).then_some((T::zero(), points[1].0))
}

/// Where the parabola through three points is lowest, if that is between them.
fn lowest<T: Scalar>([(a, fa), (b, fb), (c, fc)]: [Value<T>; 3]) -> Option<T> {
    // Divided differences: f = fa + (x − a)(first + (x − b) second).
    let first = (fb - fa) / (b - a);
    let second = ((fc - fb) / (c - b) - first) / (c - a);
    let place = (a + b - first / second) * lit(0.5);
    (second > T::zero() && place > a && place < c).then_some(place)
}
