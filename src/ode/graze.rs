//! Kinks that begin and end within a step, between its stages: a floor that is touched, a tip that
//! slips for a moment.
//!
//! A [switching function](super::System::switching_function) that has one sign at both ends of a
//! step is followed to its lowest value in between by parabolas through three points. Below zero
//! the step shall end just beyond the zero, where the error of the next one shows the kink.

use super::dense_output::DenseOutput;
use super::integration::Integration;
use super::locked::Interval;
use super::stepper::{OneStep, Point, Stepper};
use super::storage::States;
use super::system::Equations;
use crate::Scalar;
use crate::scalar::lit;

/// A lowest value of so much of the larger end, by three points of any curve, is looked at on the
/// curve of the method.
const NEAR: f64 = 0.2;

/// Parabolas, each through the last one's lowest point.
const PARABOLAS: u32 = 4;

/// Halvings of the part of a step in which the zero lies.
const HALVINGS: u32 = 10;

/// A place in a step, and the value there.
type Value<T> = (T, T);

impl<T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, M: OneStep<T, V>, K>
    Integration<'_, T, V, S, M, K>
{
    /// Answers with a shorter step, to just beyond the first of two zeros between the ends.
    #[inline]
    pub(super) fn grazed(&mut self, end: &Point<T, V>, interval: Interval<T>) -> Option<T> {
        let start = self.system.switching(self.point.time, &self.point.state, &self.branches)?;
        let last = self.system.switching(end.time, &end.state, &self.branches)?;
        if start * last > T::zero() { self.touches(end, interval, (start, last)) } else { None }
    }

    #[cold]
    fn touches(&mut self, end: &Point<T, V>, at: Interval<T>, (a, b): (T, T)) -> Option<T> {
        let (step, zero, one) = (end.time - self.point.time, T::zero(), T::one());
        let side = a.signum();
        let mut points = [(zero, a.abs()), (lit(0.5), zero), (one, b.abs())];
        let value = |run: &Self, curve: &DenseOutput<T, V>, place: T| {
            let time = run.point.time + step * place;
            run.system.switching(time, &curve.at(place), &run.branches).map(|value| side * value)
        };
        points[1].1 = value(self, &self.step.dense_output, lit(0.5))?;
        let (_, least) = lowest(points)?;
        if least > lit::<T>(NEAR) * a.abs().larger(b.abs()) {
            return None;
        }
        let (stepper, mut field, from) = self.parts(at);
        let curve = stepper.dense_output(&mut field, from, end);
        points[1].1 = value(self, &curve, lit(0.5))?;
        for _ in 0..PARABOLAS {
            let (place, least) = points[1];
            if least < zero {
                let (mut before, mut beyond) = (points[0].0, place);
                for _ in 0..HALVINGS {
                    let middle = (before + beyond) * lit(0.5);
                    if value(self, &curve, middle)? < zero {
                        beyond = middle
                    } else {
                        before = middle
                    }
                }
                return Some(step * beyond);
            }
            let (place, _) = lowest(points)?;
            let found = (place, value(self, &curve, place)?);
            let [first, middle, last] = points;
            points = match (found.1 < middle.1, place < middle.0) {
                (true, true) => [first, found, middle],
                (true, false) => [middle, found, last],
                (false, true) => [found, middle, last],
                (false, false) => [first, middle, found],
            };
        }
        None
    }
}

/// The lowest point of the parabola through three points, if it lies between them.
fn lowest<T: Scalar>([(a, fa), (b, fb), (c, fc)]: [Value<T>; 3]) -> Option<Value<T>> {
    // Divided differences: f = fa + (x − a)(first + (x − b) second).
    let first = (fb - fa) / (b - a);
    let second = ((fc - fb) / (c - b) - first) / (c - a);
    let place = (a + b - first / second) * lit(0.5);
    let inside = second > T::zero() && place > a && place < c;
    inside.then(|| (place, fa + (place - a) * (first + (place - b) * second)))
}
