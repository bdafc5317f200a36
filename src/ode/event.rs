//! Events: zeros of a function along the solution.

use core::fmt;

use nalgebra::SVector;

use super::step::Step;
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

/// What happens at an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Action {
    /// It is reported, and the run goes on.
    #[default]
    Continue,
    /// It is reported, and the run ends there.
    Stop,
}

/// A zero of a function g(t, x) along the solution, located on the dense output.
///
/// A step is looked at in both its halves: a function that passes zero twice within one of them
/// goes unnoticed, which a limit on the step prevents
/// ([`Solver::with_largest_step`](super::Solver::with_largest_step)).
///
/// ```
/// use bristle::ode::{Action, Direction, Event};
/// use bristle::nalgebra::Vector3;
///
/// let velocity = |_time: f64, state: &Vector3<f64>| state[1];
/// let comes_to_rest =
///     Event { function: &velocity, direction: Direction::Falling, action: Action::Stop };
/// ```
#[derive(Clone, Copy)]
pub struct Event<'a, T, const N: usize> {
    /// The function g(t, x).
    pub function: &'a dyn Fn(T, &SVector<T, N>) -> T,
    /// In which direction it has to pass zero.
    pub direction: Direction,
    /// What happens then.
    pub action: Action,
}

impl<T, const N: usize> fmt::Debug for Event<'_, T, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Event")
            .field("direction", &self.direction)
            .field("action", &self.action)
            .finish_non_exhaustive()
    }
}

/// An event that happened.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Occurrence<T, const N: usize> {
    /// Which event, by its place in the list given to the run.
    pub event: usize,
    /// When \[s\].
    pub time: T,
    /// The state then.
    pub state: SVector<T, N>,
}

impl<T: Scalar, const N: usize> Event<'_, T, N> {
    /// The fractions of a step at which the event happens, at most one in each half.
    pub(super) fn within(&self, step: &Step<T, N>) -> [Option<T>; 2] {
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
