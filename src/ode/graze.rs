//! Kinks of which a [switching function](super::System::switching_functions) tells.
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
use super::stepper::{OneStep, Point};
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
        // At a kink of an input it may jump.
        let latest = end.time.smaller(interval.1);
        let last = self.system.switching(latest, &end.state, &self.branches)?;
        let step = end.time - self.point.time;
        let curve = &self.step.dense_output;
        let [soon, late] =
            [lit(SOON), T::one() - lit(SOON)].map(|place| self.values_within(curve, step, place));
        let (soon, late) = (soon?, late?);
        let looks = |i: usize| {
            let side = start[i].signum();
            let [start, soon, late, last] = [&start, &soon, &late, &last].map(|x| side * x[i]);
            if last > T::zero() {
                soon < start && late < last
            } else {
                soon > T::zero() && late < T::zero()
            }
        };
        let of_functions = (0..end.state.count()).filter(|&i| looks(i));
        let zeros = of_functions.filter_map(|i| self.zero(end, interval, (i, [start[i], last[i]])));
        zeros.reduce(|one, other| if one.abs() < other.abs() { one } else { other })
    }

    /// The length of a step to just beyond the first zero of one function, or the first of two. Its
    /// values at both ends are given.
    #[cold]
    fn zero(
        &mut self,
        end: &Point<T, V>,
        interval: Interval<T>,
        (function, [start, last]): (usize, [T; 2]),
    ) -> Option<T> {
        let (noise, side) = (self.noise(end, function)?, start.signum());
        let touches = start * last > T::zero();
        if !touches && !(start.abs().smaller(last.abs()) > noise) {
            return None;
        }
        let step = end.time - self.point.time;
        let curve = self.own_curve(end, interval);
        let value = |place| Some(side * self.values_within(&curve, step, place)?[function]);
        let (mut before, mut beyond) = (T::zero(), T::one());
        if touches {
            (before, beyond) = deepest(&value)?;
            if !(value(beyond)? < -noise) {
                return None;
            }
        }
        for _ in 0..HALVINGS {
            let middle = (before + beyond) * lit(0.5);
            if value(middle)? < T::zero() { beyond = middle } else { before = middle }
        }
        Some(step * beyond)
    }

    /// What a switching function may be off where each state is off by its tolerance.
    fn noise(&self, end: &Point<T, V>, function: usize) -> Option<T> {
        let value =
            |state: &V| Some(self.system.switching(end.time, state, &self.branches)?[function]);
        let (last, mut beside) = (value(&end.state)?, end.state.clone());
        let mut noise = T::zero();
        for i in 0..beside.count() {
            beside[i] += end.scale[i];
            noise += (value(&beside)? - last).abs();
            beside[i] = end.state[i];
        }
        Some(noise)
    }

    /// The switching functions within a step of a length on a curve.
    fn values_within(&self, curve: &DenseOutput<T, V>, step: T, place: T) -> Option<V> {
        self.system.switching(self.point.time + step * place, &curve.at(place), &self.branches)
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
