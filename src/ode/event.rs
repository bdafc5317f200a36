//! Events: zeros of a function along the solution.

use core::fmt;

use super::step::Step;
use super::storage::States;
use crate::Scalar;
use crate::root::enclose;
use crate::scalar::lit;

/// In which direction a function has to pass zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Direction {
    /// From negative to positive, as the run goes.
    Rising,
    /// From positive to negative, as the run goes.
    Falling,
    /// Either.
    #[default]
    Either,
}

/// A zero of a function g(t, x) along the solution, located on the dense output.
///
/// A step is looked at in both its halves: a function that passes zero twice within one of them
/// goes unnoticed, which a limit on the step prevents
/// ([`Solver::with_largest_step`](super::Solver::with_largest_step)).
///
/// ```
/// use bristle::ode::{Direction, Event};
/// use bristle::nalgebra::Vector3;
///
/// let velocity = |_time: f64, state: &Vector3<f64>| state[1];
/// let turns_back = Event { function: &velocity, direction: Direction::Falling, stops: true };
/// ```
///
/// A mass under friction passes zero velocity several times before it rests. To stop at rest, take
/// its mechanical energy less a small limit, falling.
#[derive(Clone, Copy)]
pub struct Event<'a, T, V> {
    /// The function g(t, x).
    pub function: &'a dyn Fn(T, &V) -> T,
    /// In which direction it has to pass zero.
    pub direction: Direction,
    /// Whether the run ends there. The event is reported in any case.
    pub stops: bool,
}

impl<T, V> fmt::Debug for Event<'_, T, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Event")
            .field("direction", &self.direction)
            .field("stops", &self.stops)
            .finish_non_exhaustive()
    }
}

/// An event that happened, or a sliding direction that reversed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Occurrence<T, V> {
    /// Which event, by its place in the list given to the run; which contact, by its place among
    /// the system's sliding velocities.
    pub index: usize,
    /// When \[s\].
    pub time: T,
    /// The state then.
    pub state: V,
}

impl<T: Scalar, V: States<T>> Event<'_, T, V> {
    /// The fractions of a step at which the event happens, at most one in each half.
    pub(super) fn within(&self, step: &Step<T, V>) -> [Option<T>; 2] {
        let half: T = lit(0.5);
        let at = |fraction: T| (self.function)(step.time_at(fraction), &step.at_fraction(fraction));
        let start = (T::zero(), (self.function)(step.start_time, step.start()));
        let middle = (half, at(half));
        let end = (T::one(), (self.function)(step.end_time, &step.end));
        let find = |a: (T, T), b: (T, T)| {
            let rises = a.1 < T::zero() && b.1 >= T::zero();
            let falls = a.1 > T::zero() && b.1 <= T::zero();
            let wanted = match self.direction {
                Direction::Rising => rises,
                Direction::Falling => falls,
                Direction::Either => rises || falls,
            };
            wanted.then(|| enclose(at, a, b, T::default_epsilon() * lit(4.0)).1)
        };
        [find(start, middle), find(middle, end)]
    }
}
