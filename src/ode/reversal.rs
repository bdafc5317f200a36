//! Where a sliding direction reverses within a step.

use super::crossing::{Crossing, Search};
use super::step::Step;
use super::stepper::Point;
use super::storage::{Entries, States};
use super::system::Equations;
use crate::scalar::lit;
use crate::{Branch, Scalar};

/// A velocity on the wrong side of zero by less than this part of the error that its tolerances
/// allow is noise of the integration: to restart at each of its zeros would cost much and tell
/// nothing.
const NOISE: f64 = 1e-3;

/// A step cut at a reversal has reached it if no more than this part of the velocity is left.
const NEARLY: f64 = 1e-2;

/// After so many splits in a row that hardly advance, a contact takes a step on the free branch.
const PATIENCE: u32 = 6;

/// A split that leaves less than this part of the trial step hardly advances.
const HARDLY: f64 = 1e-3;

/// The first step after a turn is at most this many times that after the last turn the same way.
const AGAIN: f64 = 1.25;

/// What the driver knows of one sliding contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContactBranch<T> {
    /// The direction to which the contact is locked.
    pub(super) branch: Branch,
    /// Sliding velocity at the current point, positive on the right side of zero.
    ahead: T,
    /// How far on the wrong side is still noise.
    pub(super) noise: T,
    /// How far on the wrong side the last reversal left the contact: its place is not exact.
    left: T,
    /// The greatest speed met so far, which sets the rounding of the velocity.
    greatest: T,
    /// Splits in a row that hardly advanced.
    pub(super) stalled: u32,
    /// Lengths \[s\] of the first steps taken after the last turns forward and backward; zero if
    /// there was none.
    firsts: [T; 2],
    /// No step was taken since the last turn.
    pub(super) fresh: bool,
}

impl<T: Scalar> ContactBranch<T> {
    /// A contact that is not locked yet.
    pub(super) fn free() -> Self {
        Self {
            branch: Branch::Free,
            ahead: T::zero(),
            noise: T::zero(),
            left: T::zero(),
            greatest: T::zero(),
            stalled: 0,
            firsts: [T::zero(); 2],
            fresh: false,
        }
    }

    /// Takes note of the length of a step, if it is the first since a turn.
    pub(super) fn took(&mut self, length: T) {
        if self.fresh {
            self.fresh = false;
            self.firsts[usize::from(self.branch == Branch::Backward)] = length;
        }
    }

    /// The length to try after a turn: a swinging stuck mass needs about the same step every time
    /// it turns this way, which may differ from that of the other way.
    pub(super) fn likely(&self, proposed: T) -> T {
        let before = self.firsts[usize::from(self.branch == Branch::Backward)];
        if before > T::zero() { proposed.smaller(before * lit(AGAIN)) } else { proposed }
    }

    /// Takes note of the sliding velocity at the current point.
    pub(super) fn update(&mut self, velocity: T) {
        self.ahead = self.branch.of(velocity).speed();
        self.left = T::zero();
        self.greatest = self.greatest.larger(velocity.abs());
    }

    /// Locks the contact to the side on which it slides, if its velocity has jumped there.
    pub(super) fn jump(&mut self, velocity: T) -> bool {
        let has_jumped = self.branch != Branch::Free && self.ahead < -self.noise;
        if has_jumped {
            self.branch = Branch::towards(velocity);
            self.update(velocity);
        }
        has_jumped
    }

    /// Takes note of the sliding velocity where the contact has just been locked, and of the error
    /// that the tolerances allow it, unless it is known from before.
    pub(super) fn begin(&mut self, velocity: T, error: Option<T>) {
        self.update(velocity);
        self.left = (-self.ahead).larger(T::zero());
        let rounding = self.greatest * T::default_epsilon() * lit(4.0);
        self.noise = error.map_or(self.noise, |error| error * lit(NOISE)).larger(rounding);
    }

    /// Whether a step cut at a reversal has reached it, from what was known at its start.
    pub(super) fn reaches_zero(&self, start: &Self) -> bool {
        self.ahead <= self.noise.larger(start.ahead * lit(NEARLY))
    }

    /// Turns to the other direction, after a step cut to a fraction of its trial.
    pub(super) fn turn(&mut self, fraction: T) {
        self.stalled = if fraction < lit(HARDLY) { self.stalled + 1 } else { 0 };
        self.branch = if self.stalled > PATIENCE { Branch::Free } else { self.branch.reversed() };
        self.fresh = true;
    }
}

/// What a trial step does to the sliding directions.
pub(super) enum Reversal<T> {
    /// No contact reverses.
    None,
    /// This contact was on the wrong branch from the start.
    AtStart(usize),
    /// This contact reverses at this fraction of the step.
    Within(usize, T),
    /// A sliding velocity is not finite.
    Unknown,
}

/// A velocity that falls below this part of its greatest value in a step is examined closely.
const CLOSE: f64 = 0.05;

/// Whether no contact comes near a reversal between two points, as far as a cubic tells: the one
/// through the velocity at both ends and at the thirds, which stays within the hull of its four
/// control points. No velocity is asked for after the latest time, where an input may jump.
#[inline]
pub(super) fn surely_none<T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, K>(
    system: &S,
    locks: &[ContactBranch<T>],
    [from, end]: [&Point<T, V>; 2],
    latest: T,
) -> bool {
    let duration = end.time - from.time;
    let third = duration * lit(1.0 / 3.0);
    // The cubic through both states with their rates, at one third from each end.
    let at_third = |near: &Point<T, V>, far: &Point<T, V>, duration: T| {
        near.state.like(|i| {
            let chord = far.state[i] - near.state[i];
            let (start, stop) = (near.rate[i] * duration, far.rate[i] * duration);
            let way = chord * lit(7.0) + start * lit(4.0) - stop * lit(2.0);
            near.state[i] + way * lit(1.0 / 27.0)
        })
    };
    let early = system.velocities(from.time + third, &at_third(from, end, duration));
    let late = system.velocities(end.time - third, &at_third(end, from, -duration));
    let last = system.velocities(end.time.smaller(latest), &end.state);
    let velocities = early.entries().iter().zip(late.entries()).zip(last.entries());
    locks.iter().zip(velocities).all(|(lock, ((&early, &late), &last))| {
        let ahead = |velocity: T| lock.branch.of(velocity).speed();
        let [v0, v1, v2, v3] = [lock.ahead, ahead(early), ahead(late), ahead(last)];
        let sixth: T = lit(1.0 / 6.0);
        let control = |near: T, beside: T, beyond: T, far: T| {
            (beside * lit(18.0) - near * lit(5.0) - beyond * lit(9.0) + far * lit(2.0)) * sixth
        };
        let (b1, b2) = (control(v0, v1, v2, v3), control(v3, v2, v1, v0));
        let least = v0.smaller(b1).smaller(b2.smaller(v3));
        let most = v0.larger(b1).larger(b2.larger(v3));
        let is_far = least > lock.noise && least > most * lit(CLOSE);
        let is_known = (early + late + last).is_finite();
        is_known && (is_far || lock.branch == Branch::Free)
    })
}

/// Whether a trial step takes a contact to the wrong side of zero, and which one first. No velocity
/// is asked for after the latest time.
pub(super) fn first_reversal<T: Scalar, V: States<T>, S: Equations<T, V, K> + ?Sized, K>(
    system: &S,
    locks: &[ContactBranch<T>],
    step: &Step<T, V>,
    (latest, smallest_step): (T, T),
) -> Reversal<T> {
    let half: T = lit(0.5);
    let time_at = |fraction: T| step.time_at(fraction).smaller(latest);
    let mut state = step.at_fraction(half);
    let middle = system.velocities(time_at(half), &state);
    let end = system.velocities(step.end_time.smaller(latest), &step.end);
    let mut velocities = end.clone();
    let duration = (step.end_time - step.start_time).abs();
    let mut first = Reversal::None;
    let mut earliest = T::one();
    let known = middle.entries().iter().zip(end.entries());
    for (index, (lock, (&middle, &end))) in locks.iter().zip(known).enumerate() {
        if !(middle.is_finite() && end.is_finite()) {
            return Reversal::Unknown;
        }
        if lock.branch == Branch::Free {
            continue;
        }
        let ahead = |velocity: T| lock.branch.of(velocity).speed();
        let at = |fraction: T| {
            step.at_fraction_to(fraction, &mut state);
            system.velocities_to(time_at(fraction), &state, &mut velocities);
            velocities.entries().get(index).map_or(T::zero(), |&v| ahead(v))
        };
        let search = Search {
            // On the wrong side by noise, or in the first step by the inexact place of the
            // reversal. To forgive more would keep a creeping contact on the wrong branch for ever,
            // where the bristle is driven beyond every limit.
            forgiven: lock.noise.larger(lock.left * lit(2.0)),
            tolerance: T::default_epsilon() * lit(4.0),
            shortest: smallest_step * lit(4.0) / duration,
        };
        let speeds = [(T::zero(), lock.ahead), (half, ahead(middle)), (T::one(), ahead(end))];
        match search.first(at, &speeds) {
            Crossing::AtStart => return Reversal::AtStart(index),
            Crossing::At(place) if place < earliest => {
                earliest = place;
                first = Reversal::Within(index, place);
            }
            Crossing::At(_) | Crossing::None => {}
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::super::stepper::Point;
    use super::super::system::System;
    use super::{ContactBranch, surely_none};
    use crate::Branch;
    use nalgebra::Vector1;

    /// Its state is its sliding velocity.
    struct Slider;

    impl System<f64, 1> for Slider {
        fn rate(&self, _: f64, _: &Vector1<f64>, _: [Branch; 1]) -> Vector1<f64> {
            Vector1::zeros()
        }

        fn sliding_velocities(&self, _: f64, state: &Vector1<f64>) -> [f64; 1] {
            [state[0]]
        }
    }

    /// A cubic velocity is the one through its ends with their rates; it has the control points b,
    /// and the rates 3 (b₁ − b₀)/h and 3 (b₃ − b₂)/h.
    #[test]
    fn a_cubic_velocity_is_surely_far_from_zero_where_its_control_points_are() {
        let (start, duration) = (2.0, 0.4);
        let levels = [-0.3, 0.02, 0.2, 1.0];
        for number in 0..256 {
            let b: [f64; 4] = core::array::from_fn(|i| levels[number >> (2 * i) & 3]);
            if b[0] < 0.0 {
                continue; // The step begins on the right side.
            }
            let (least, most) = (
                b.iter().copied().fold(1.0, f64::min),
                b.iter().fold(0.0, |most, &b| f64::max(most, b)),
            );
            for branch in [Branch::Forward, Branch::Backward] {
                let b = b.map(|b| if branch == Branch::Forward { b } else { -b });
                let point = |time, state, rate| Point {
                    time,
                    state: Vector1::new(state),
                    rate: Vector1::new(rate),
                    scale: Vector1::new(1.0),
                };
                let from = point(start, b[0], 3.0 * (b[1] - b[0]) / duration);
                let end = point(start + duration, b[3], 3.0 * (b[3] - b[2]) / duration);
                let mut lock = ContactBranch::free();
                lock.branch = branch;
                lock.update(b[0]);
                let found = surely_none(&Slider, &[lock], [&from, &end], end.time);
                assert_eq!(found, least > 0.05 * most, "{b:?}");
            }
        }
    }

    #[test]
    fn a_turn_remembers_the_first_step_after_the_last_turn_the_same_way() {
        let mut lock = ContactBranch::<f64>::free();
        lock.branch = Branch::Backward;
        lock.turn(1.0); // forward
        assert_eq!(lock.likely(1.0), 1.0);
        lock.took(0.1);
        lock.took(0.7); // not the first any more
        lock.turn(1.0); // backward
        assert_eq!(lock.likely(1.0), 1.0);
        lock.took(0.01);
        lock.turn(1.0);
        assert_eq!(lock.likely(1.0), 0.125);
        assert_eq!(lock.likely(0.05), 0.05);
        lock.turn(1.0);
        assert_eq!(lock.likely(1.0), 0.0125);
    }
}
