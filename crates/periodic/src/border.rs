//! Where stable cycles end.
//!
//! A cycle that loses its stability is left for another one, or for rest. Which one, no multiplier
//! says: it is simulated.

use bristle::ode::{Direction, Event, System};
use bristle::parameter::Checked;
use nalgebra::SVector;

use crate::{Answer, BranchEnd, BranchPoint, Continuation, Guess, Orbit, PeriodicError};

/// Beyond a border, by this share of the range, what leaves the cycle is simulated, from a start
/// off it by the second share of its state, over so many periods.
const BEYOND: f64 = 0.01;
const OFF: f64 = 1e-3;
const LONG: f64 = 1e3;

impl Continuation {
    /// Where the stable cycles through a guess at a parameter end: a fold, or a point at which the
    /// cycle loses its stability and what leaves it comes to rest. Another stable cycle that it
    /// leaves for is followed on. None if one is stable at the end of the range. As many points as
    /// it takes, in the direction of `first_step`.
    ///
    /// What leaves a cycle is simulated over a thousand periods, a hundredth of the range beyond,
    /// at most at its end: narrow a range in which a second border may lie so near to the first.
    ///
    /// # Errors
    ///
    /// As [`Continuation::free`]; [`PeriodicError::Unstable`] if the cycle is none to begin with;
    /// why a branch was lost before it ended.
    pub fn border<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: impl Fn(f64) -> Checked<S>,
        mut parameter: f64,
        mut guess: Guess<N>,
    ) -> Answer<Option<BranchPoint<N>>> {
        let along = Self { stable_only: true, most_points: usize::MAX, ..self.clone() };
        loop {
            let branch = along.free(&system, parameter, guess)?;
            let border = match (branch.end, branch.special().last()) {
                _ if !branch.points[0].orbit.is_stable() => return Err(PeriodicError::Unstable),
                (BranchEnd::Lost(error), _) => return Err(error),
                (BranchEnd::Range, _) => return Ok(None),
                (_, Some(&border)) => border,
                _ => return Err(PeriodicError::Unstable),
            };
            let beyond = BEYOND * (self.range.end - self.range.start);
            let beyond = border.parameter + beyond.copysign(self.first_step);
            parameter = beyond.clamp(self.range.start, self.range.end);
            match self.left(&system(parameter)?, &border.orbit)? {
                Some(orbit) => guess = orbit.guess(),
                None => return Ok(Some(border)),
            }
        }
    }

    /// The stable cycle in which the motion ends that leaves another one, if there is one.
    fn left<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: &S,
        from: &Orbit<N>,
    ) -> Answer<Option<Orbit<N>>> {
        let cyclic = self.shooting.cyclic(None, system.scales())?;
        let normal = cyclic.of(system).scaled_rate(0.0, &from.start);
        let apart = |state: &SVector<f64, N>| (state - from.start).component_div(&cyclic.scales);
        let ahead = |_: f64, state: &SVector<f64, N>| normal.dot(&apart(state));
        let plane = Event { function: &ahead, direction: Direction::Rising, stops: false };
        let (start, duration) = (from.start * (1.0 + OFF), LONG * from.period);
        let guess = self.shooting.settle(system, start, duration, &plane);
        match guess.and_then(|guess| self.shooting.free(system, guess)) {
            Err(PeriodicError::TooManySteps) => Err(PeriodicError::TooManySteps),
            found => Ok(found.ok().filter(Orbit::is_stable)),
        }
    }
}
