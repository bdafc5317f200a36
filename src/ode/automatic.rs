//! The default: an explicit method while accuracy limits the step, a Rosenbrock method while
//! stability would. The driver switches between them in mid-run, both ways.
//!
//! Stick and slip differ: a stuck mass is stiff (its fast swing on the bristles has died out, but
//! would still limit an explicit step); breakaway and arrest are not.
//!
//! An explicit step is limited by stability if h|λ| is near the limit of its stability region; |λ|
//! is estimated from its last two stages, |f(x₁) − f(x̃)|/|x₁ − x̃| (Hairer and Wanner, below). In
//! a Rosenbrock step the Jacobian J is at hand, and its spectral radius follows from traces of
//! powers,
//!
//! ρ ≈ max(|tr J¹⁶|^(1/16), |tr J³²|^(1/32)).
//!
//! It does not depend on the units of the states, nor on the direction of a complex pair: where one
//! trace vanishes the other does not.
//!
//! Source of the first: E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", 2nd
//! edition (Springer, 1996), section IV.2.

use super::dense_output::DenseOutput;
use super::explicit::{Explicit, ExplicitTableau, serves};
use super::growth::{LARGE, MANY, trace, trace_of_square};
use super::rosenbrock::Rosenbrock;
use super::stepper::{Field, OneStep, Point, Stepper, TrialStep, as_the_one_at_work};
use super::storage::{Entries, States, product};
use super::tolerance::ToleranceRange;
use super::{DormandPrince, DormandPrince8, Rodas5P};
use crate::Scalar;
use crate::scalar::{lit, to_f64};

/// The method behind [`solve`](super::solve): [`DormandPrince8`] and [`Rodas5P`] take turns. For a
/// single state, as of a bristle at a given velocity, and loose steps, [`DormandPrince`] is the
/// explicit one. With more than 400 states it is `DormandPrince8` alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Automatic;

impl<T: Scalar, V: States<T>> OneStep<T, V> for Automatic {
    type Stepper = Alternating<T, V>;

    fn stepper(&self, tolerance: f64, state: &V) -> Self::Stepper {
        let states = state.count();
        Alternating {
            eighth: Explicit::new(state),
            fifth: Explicit::new(state),
            rosenbrock: Rosenbrock::new(state),
            explicit: if states == 1 && tolerance > FIFTH { Turn::Fifth } else { Turn::Eighth },
            turn: if states > LARGE { Turn::Eighth } else { Turn::Rosenbrock },
            is_new: false,
            since: 0,
            votes: 0,
            needed: VOTES,
        }
    }

    fn tolerance_range(&self) -> ToleranceRange {
        ToleranceRange::AUTOMATIC
    }
}

/// An explicit and a Rosenbrock method that take turns.
#[derive(Debug, Clone)]
pub(crate) struct Alternating<T: Scalar, V: States<T>> {
    eighth: Explicit<DormandPrince8, T, V, 16>,
    fifth: Explicit<DormandPrince, T, V, 7>,
    rosenbrock: Rosenbrock<Rodas5P, T, V, 8>,
    /// The explicit method of this run.
    explicit: Turn,
    /// The method whose turn it is.
    turn: Turn,
    /// Whether the Rosenbrock method has yet to see the point where its turn starts.
    is_new: bool,
    /// Accepted steps since the last change.
    since: u32,
    /// Steps in a row that spoke for a change.
    votes: u32,
    /// Votes that a change to the dearer method needs: more after a change that did not last.
    needed: u32,
}

/// A method that may have its turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Turn {
    Fifth,
    Eighth,
    Rosenbrock,
}

/// Calls a function of the method at work.
macro_rules! at_work {
    ($self:ident.$function:ident($($argument:expr),*)) => {
        match $self.turn {
            Turn::Fifth => $self.fifth.$function($($argument),*),
            Turn::Eighth => $self.eighth.$function($($argument),*),
            Turn::Rosenbrock => $self.rosenbrock.$function($($argument),*),
        }
    };
}

/// With steps of looser tolerances than this, an explicit step of order 5 on a single state is
/// about as long as one of order 8: the swing of the given velocity limits both. With more states
/// it is not.
const FIFTH: f64 = 5e-7;

/// Below this h ρ of a Rosenbrock step an explicit method is cheaper: it can take steps of
/// 0.8 of its limit, or two to three times as long if accuracy allows, at about the same cost.
///
/// With many states these steps of 0.8 of the limit may be shorter by as much as they are cheaper:
/// twelve evaluations and a part of a Jacobian, for nine and a whole one by differences.
const fn easy(states: usize) -> f64 {
    if states < MANY {
        return 2.5;
    }
    let explicit = 12.0 + (states / serves(states)) as f64;
    0.8 * DormandPrince8::REAL_LIMIT * (9 + states) as f64 / explicit
}

/// Votes for a change.
const VOTES: u32 = 2;

/// Votes for a change from the Rosenbrock method where that is the dearer one: the steps with which
/// its turn begins are no longer than those before.
const VOTES_OF_MANY: u32 = 3;

/// Most votes that a change to the dearer method may need. A turn of the Rosenbrock method with
/// many states that does not last costs several times as many evaluations as there are states.
const fn most_votes(states: usize) -> u32 {
    if states < MANY { 32 } else { 8 * states as u32 }
}

/// A turn of fewer steps of the dearer method was not worth the change.
const SHORT: u32 = 12;

impl<T: Scalar, V: States<T>> Alternating<T, V> {
    /// Counts a step of so many states that speaks for a change or against it. Answers whether to
    /// change.
    fn vote(&mut self, states: usize, for_change: bool) -> bool {
        let is_explicit = self.turn != Turn::Rosenbrock;
        let is_dear = is_explicit == (states < MANY);
        let needed = match is_dear {
            false => self.needed,
            true if states < MANY => VOTES,
            true => VOTES_OF_MANY,
        };
        self.votes = if for_change { self.votes + 1 } else { 0 };
        if self.votes < needed {
            return false;
        }
        if is_dear {
            let more = (self.needed * 2).min(most_votes(states));
            self.needed = if self.since > SHORT { VOTES } else { more };
        }
        self.eighth.forget();
        self.fifth.forget();
        self.is_new = is_explicit;
        self.turn = if is_explicit { Turn::Rosenbrock } else { self.explicit };
        (self.since, self.votes) = (0, 0);
        true
    }
}

impl<T: Scalar, V: States<T>> Stepper<T, V> for Alternating<T, V> {
    fn begin<F: Field<T, V>>(&mut self, field: &mut F, point: &mut Point<T, V>) {
        self.is_new = false;
        at_work!(self.begin(field, point));
    }

    #[inline]
    fn step(&mut self, field: &mut impl Field<T, V>, from: &Point<T, V>, h: T) -> TrialStep<T, V> {
        if self.is_new {
            self.begin(field, &mut from.clone());
        }
        at_work!(self.step(field, from, h))
    }

    as_the_one_at_work!(at_work);

    fn accepted(&mut self, step: T, end: &Point<T, V>, proposed: Option<T>) -> Option<T> {
        self.since += 1;
        let states = end.state.count();
        if states > LARGE {
            return self.eighth.accepted(step, end, proposed);
        }
        let held = match self.turn {
            Turn::Fifth => Some(self.fifth.took_held(end, step)),
            Turn::Eighth => Some(self.eighth.took_held(end, step)),
            Turn::Rosenbrock => None,
        };
        if let Some(held) = held {
            self.vote(states, held);
            return proposed;
        }
        self.rosenbrock.accepted(step, end, proposed);
        // Fixed steps stay with the method that is stable at any length.
        let proposed = proposed?;
        let length = step.abs();
        let easy = easy(states);
        let mut growth = self.rosenbrock.jacobian().clone();
        growth.entries_mut().iter_mut().for_each(|entry| *entry *= length);
        let reach = spectral_radius(states, &growth, easy);
        if !self.vote(states, reach < easy) {
            return Some(proposed);
        }
        let reach = if reach > 0.01 { reach } else { 0.01 };
        let limit = match self.explicit {
            Turn::Fifth => DormandPrince::REAL_LIMIT,
            _ => DormandPrince8::REAL_LIMIT,
        };
        Some(proposed.smaller(length * lit(limit * 0.8 / reach)))
    }
}

/// The largest magnitude of an eigenvalue, within about ten percent, and by k^(1/16) too large if k
/// are equal; infinite beyond about 10²⁰, and where traces of lower powers already show that it is
/// larger than a limit.
fn spectral_radius<T: Scalar, A: Entries<T>>(states: usize, matrix: &A, limit: f64) -> f64 {
    let traces = |power: &A| {
        [trace(states, power.entries()), trace_of_square(states, power.entries())]
            .map(|trace| to_f64(trace).abs())
    };
    let (mut power, mut most) = (matrix.clone(), limit);
    for _ in 0..4 {
        // Each eigenvalue within the limit adds its power at most.
        let [first, second] = traces(&power);
        if first > most * states as f64 || second > most * most * states as f64 {
            return f64::INFINITY;
        }
        power = product(states, power.entries(), &power);
        most *= most;
    }
    let root = |size: f64, exponent: f64| {
        if size.is_finite() {
            super::controller::rough_power(size, exponent)
        } else {
            f64::INFINITY
        }
    };
    let [sixteenth, thirty_second] = traces(&power);
    f64::max(root(sixteenth, 1.0 / 16.0), root(thirty_second, 1.0 / 32.0))
}

#[cfg(test)]
mod tests {
    use super::super::stepper::{Linear, OneStep, Point, Stepper};
    use super::{Automatic, Turn, spectral_radius};
    use crate::Scalar;
    use nalgebra::{Matrix2, Matrix3, SMatrix, SVector};

    /// The turn after some steps of a length on ẋ = −x, beginning with the Rosenbrock method, and
    /// the lengths proposed where the controller would take 100.
    fn steps<const N: usize, const C: usize>(length: f64) -> (Turn, [f64; C]) {
        let (ones, decay) = (SVector::<f64, N>::repeat(1.0), -SMatrix::identity());
        let mut stepper = Automatic.stepper(0.0, &ones);
        let mut field = Linear(&decay);
        let mut from = Point { time: 0.0, state: ones, rate: -ones, scale: ones };
        stepper.begin(&mut field, &mut from);
        let proposals = core::array::from_fn(|i| {
            let (state, time) = (stepper.step(&mut field, &from, length).state, i as f64 * length);
            let mut end = Point { time, state, rate: -state, scale: ones };
            stepper.arrive(&mut field, &mut end);
            from = end;
            stepper.accepted(length, &from, Some(100.0)).unwrap_or(f64::NAN)
        });
        (stepper.turn, proposals)
    }

    #[test]
    fn the_first_explicit_step_is_at_most_four_fifths_of_the_stable_one() {
        // Steps of two time constants, which an explicit method can take as well.
        let (turn, proposals) = steps::<1, 2>(2.0);
        assert!(turn == Turn::Eighth && proposals[0] == 100.0, "{proposals:?}");
        // The polynomial of order eight is stable up to 6.39; the spectral radius is rough.
        assert!((proposals[1] / (0.8 * 6.39) - 1.0).abs() < 0.12, "{proposals:?}");
    }

    #[test]
    fn with_many_states_explicit_steps_may_be_shorter_by_as_much_as_they_are_cheaper() {
        // 12 + 2 evaluations for 9 + 12 and 9 + 24: up to steps of 7.7 and 11.7 time constants.
        let turns = |length| [steps::<1, 3>(length).0, steps::<12, 3>(length).0];
        assert_eq!(turns(2.0), [Turn::Eighth; 2]);
        // Of as many equal eigenvalues the radius is taken a sixth too large.
        assert_eq!(turns(5.0), [Turn::Rosenbrock, Turn::Eighth]);
        assert_eq!(turns(8.0), [Turn::Rosenbrock; 2]);
        assert_eq!(steps::<24, 3>(8.0).0, Turn::Eighth);
    }

    #[test]
    fn the_spectral_radius_is_found_in_any_units() {
        fn radius<T: Scalar, const N: usize>(matrix: &SMatrix<T, N, N>) -> f64 {
            let found = spectral_radius(N, matrix, f64::INFINITY);
            // A limit of more changes nothing, one of a little less may end the search.
            assert!(spectral_radius(N, matrix, 1.13 * found) == found, "{matrix}");
            assert!(spectral_radius(N, matrix, 0.8 * found) >= found, "{matrix}");
            found
        }
        let close =
            |found: f64, want: f64| assert!((found / want - 1.0).abs() < 0.12, "{found} {want}");
        close(radius(&Matrix3::from_diagonal(&[-0.3, 2.0, -5.0].into())), 5.0);
        // Complex pairs of every direction.
        for i in 0..40 {
            let angle = 0.04 * f64::from(i);
            let (sin, cos) = angle.sin_cos();
            close(radius(&(Matrix2::new(cos, -sin, sin, cos) * 3.0)), 3.0);
        }
        // The same oscillator, in metres and in nanometres.
        let oscillator = |unit: f64| Matrix2::new(0.0, 1.0 / unit, -1e4 * unit, -64.5);
        close(radius(&oscillator(1.0)), 100.0);
        close(radius(&oscillator(1e-9)), 100.0);
        assert!(radius(&Matrix2::<f32>::new(1e30, 0.0, 0.0, 1.0)).is_infinite());
        // Beyond a limit by tr A, and by tr A².
        assert!(spectral_radius(2, &Matrix2::<f64>::new(5.0, 0.0, 0.0, 4.0), 4.0).is_infinite());
        assert!(spectral_radius(2, &Matrix2::<f64>::new(5.0, 0.0, 0.0, -4.0), 4.0).is_infinite());
    }
}
