//! Branches of periodic motions over a parameter, by pseudo-arclength.
//!
//! y = (x₀, T, p),  G(y) = 0,  G_y t = 0,  t·(y − y_i − s t) = 0
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x₀, T | a state and the period of the motion, or of each of its segments | of each state, s |
//! | p | parameter, in units of the width of its range | – |
//! | G | what shooting makes zero: the motion does not close, its phase is not fixed | – |
//! | t | tangent of the branch, a unit vector in x₀ (over its scales) and p | – |
//! | s | step along the tangent | – |
//!
//! The branch runs through folds, where p turns back, as if they were not there: it is followed in
//! s. What is special is a zero of a test function, found by false position:
//!
//! | special point | zero of |
//! |---|---|
//! | fold | t_p; a multiplier μ passes 1 |
//! | flip (period doubling) | ∏(1 + μ) |
//! | crossing of branches | ∏(1 − μ), where t_p is not zero |
//! | torus (Neimark–Sacker) | ∏(1 − μᵢ μⱼ) over pairs, of a complex pair |
//! | Hopf | f(x₀) along the rate before: the cycle shrinks to a point and turns over |
//!
//! Cycles that are odd, x(t + T/2) = −x(t), of systems that are, are followed over half a period,
//! from x₀ to −x₀, with multipliers ν, μ = ν². There another branch crosses where a ν passes −1,
//! and nothing is singular.
//!
//! Source: H. B. Keller, "Numerical solution of bifurcation and nonlinear eigenvalue problems"
//! (1977); A. H. Nayfeh, B. Balachandran, "Applied Nonlinear Dynamics" (Wiley, 1995), section 6.1.

use core::ops::Range;

use bristle::ode::System;
use bristle::parameter::{Checked, Named, Rule};
use nalgebra::{Complex, DMatrix, DVector, SVector, Vector2};

use crate::segments::{Cyclic, Equations, solve};
use crate::shooting::{Newton, SMALLEST};
use crate::{Answer, Guess, Multiplier, Orbit, PeriodicError, Shooting};

/// How a branch is followed.
#[derive(Debug, Clone, PartialEq)]
pub struct Continuation {
    /// The runs and iterations for each point.
    pub shooting: Shooting,
    /// The branch ends at the ends of this range of the parameter; no system is made beyond them.
    /// Points are found to 3·10⁻⁸ of its width, and what lies within one step of
    /// [`largest_step`](Self::largest_step) may be stepped over: narrow it to the values that
    /// matter.
    pub range: Range<f64>,
    /// The first step of the parameter, with its sign: in which direction the branch is followed.
    pub first_step: f64,
    /// Largest step along the branch, in units of the scales of the states and of the width of the
    /// range.
    pub largest_step: f64,
    /// Points, at most.
    pub most_points: usize,
    /// Whether the branch ends where its motions lose their stability.
    pub stable_only: bool,
}

impl Continuation {
    /// Upwards, first by a hundredth of the range, in steps of a tenth at most, with up to 400
    /// points, whether stable or not.
    pub fn over(range: Range<f64>) -> Self {
        let first_step = 0.01 * (range.end - range.start);
        let shooting = Shooting { most_iterations: 12, ..Shooting::default() };
        Self {
            shooting,
            range,
            first_step,
            largest_step: 0.1,
            most_points: 400,
            stable_only: false,
        }
    }

    fn checked(&self, parameter: f64) -> Checked<f64> {
        let Range { start, end } = self.range;
        Named("range.start", start).finite()?;
        Named("range.end", end).finite()?;
        Named("width of the range", end - start).positive()?;
        Named("parameter", parameter).between(start, end)?;
        let is_step = Named("first_step", self.first_step.abs()).positive().is_ok();
        let rule = "be of a magnitude between 1e-100 and 1e100, of either sign";
        Named("first_step", self.first_step).stated(is_step, rule)?;
        Named("largest_step", self.largest_step).positive()?;
        Named("most_points", self.most_points).count(1)?;
        Ok(end - start)
    }
}

/// What is special about a point of a branch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PointKind {
    /// Nothing.
    Regular,
    /// The branch turns back: two motions, one of them unstable, meet and vanish.
    Fold,
    /// A motion of twice the period branches off.
    Flip,
    /// Another branch crosses: an odd motion becomes one of two that are not, as well located as a
    /// fold. Any other crossing to 10⁻³ of the parameter: Newton's equations are singular there.
    Crossing,
    /// A motion with a second frequency branches off (Neimark–Sacker): a pair of complex
    /// multipliers passes the unit circle.
    Torus,
    /// The cycle shrinks to an equilibrium, where a pair of its poles passes the imaginary axis.
    Hopf,
}

/// A point of a branch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BranchPoint<const N: usize> {
    /// The parameter.
    pub parameter: f64,
    /// The motion.
    pub orbit: Orbit<N>,
    /// What is special about it.
    pub kind: PointKind,
}

/// Why a branch ends.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum BranchEnd {
    /// It leaves the range of the parameter: its last point is at an end of it.
    Range,
    /// It has as many points as were allowed.
    Points,
    /// Its cycle has shrunk to an equilibrium, at its last point.
    Equilibrium,
    /// Its motions lose their stability, and only stable ones were asked for.
    Unstable,
    /// No shorter step finds a next point: why the last trial failed.
    Lost(PeriodicError),
}

/// A branch of periodic motions.
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitBranch<const N: usize> {
    /// Its points in their order, at least one.
    pub points: Vec<BranchPoint<N>>,
    /// Why it ends after the last one.
    pub end: BranchEnd,
}

impl<const N: usize> OrbitBranch<N> {
    /// The points that are not regular.
    pub fn special(&self) -> impl Iterator<Item = &BranchPoint<N>> {
        self.points.iter().filter(|point| point.kind != PointKind::Regular)
    }
}

/// The unknowns y; the parameter over the width of its range.
#[derive(Debug, Clone)]
struct Unknowns<const N: usize> {
    segments: Vec<Guess<N>>,
    parameter: f64,
}

/// A point that was found, with the tangent there.
struct Found<const N: usize> {
    unknowns: Unknowns<N>,
    orbit: Orbit<N>,
    /// In the states and durations of the segments, and p.
    tangent: DVector<f64>,
    /// f(x₀) over the scales [1/s].
    rate: SVector<f64, N>,
    /// How far the motion goes from x₀, over the scales.
    extent: f64,
}

/// The period that inputs force at a parameter.
type Forced<'a> = Option<&'a dyn Fn(f64) -> f64>;

/// The problem of a branch: the system at each parameter.
struct Problem<'a, F, const N: usize, const K: usize> {
    system: F,
    period: Forced<'a>,
    cyclic: Cyclic<N>,
    most_iterations: usize,
    range: &'a Range<f64>,
    width: f64,
}

impl Continuation {
    /// The branch of cycles through a guess at a parameter, of systems without inputs.
    ///
    /// # Errors
    ///
    /// Refuses a range that is empty, a start outside it, steps of zero, and whatever `system`
    /// refuses at the start; [`PeriodicError`] if there is no cycle there. What ends the branch
    /// later is its [`OrbitBranch::end`].
    pub fn free<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: impl Fn(f64) -> Checked<S>,
        parameter: f64,
        guess: Guess<N>,
    ) -> Answer<OrbitBranch<N>> {
        self.follow(system, None, parameter, guess)
    }

    /// The branch of forced motions through a state at a parameter; their period \[s\] may
    /// depend on the parameter.
    ///
    /// # Errors
    ///
    /// As [`Continuation::free`].
    pub fn forced<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: impl Fn(f64) -> Checked<S>,
        period: impl Fn(f64) -> f64,
        parameter: f64,
        state: SVector<f64, N>,
    ) -> Answer<OrbitBranch<N>> {
        let guess = Guess { state, period: period(parameter) };
        self.follow(system, Some(&period), parameter, guess)
    }

    fn follow<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: impl Fn(f64) -> Checked<S>,
        period: Forced<'_>,
        parameter: f64,
        guess: Guess<N>,
    ) -> Answer<OrbitBranch<N>> {
        let (width, most_iterations) = (self.checked(parameter)?, self.shooting.most_iterations);
        let start = system(parameter)?;
        let cyclic = self.shooting.cyclic(period.map(|_| 0.0), start.scales())?;
        let segments = cyclic.of(&start).cut(guess)?;
        let mut problem: Problem<'_, _, N, K> =
            Problem { system, period, cyclic, most_iterations, range: &self.range, width };
        let mut upwards = DVector::zeros(segments.len() * (N + 1) + 1);
        upwards[segments.len() * (N + 1)] = 1.0;
        let start = Unknowns { segments, parameter: parameter / width };
        let mut at = problem.correct(&start, &upwards, 0.0)?;
        if let Some(half) = problem.half(&at)? {
            problem.cyclic.sign = -1.0;
            at = problem.correct(&half, &upwards, 0.0)?;
        }
        if by_parameter(&at.tangent) * self.first_step < 0.0 {
            at.tangent *= -1.0;
        }
        let step = (self.first_step / width / by_parameter(&at.tangent)).abs();
        let mut step = step.min(self.largest_step);
        let mut points = vec![problem.point(&at, PointKind::Regular)];
        let end = loop {
            if points.len() >= self.most_points {
                break BranchEnd::Points;
            }
            // Where the step leads to the end of the range, the parameter is given.
            let left = problem.left(&at);
            step = step.min(left);
            let given = &upwards * by_parameter(&at.tangent).signum();
            let plane = if step < left { &at.tangent } else { &given };
            let next = match problem.correct(&problem.ahead(&at, step), plane, step) {
                Ok(next) => next,
                Err(error) if step < SHORTEST || error == PeriodicError::TooManySteps => {
                    break BranchEnd::Lost(error);
                }
                Err(_) => {
                    step *= 0.5;
                    continue;
                }
            };
            points.extend(KINDS.iter().find_map(|&kind| problem.locate(kind, [&at, &next], step)));
            if points.last().is_some_and(|it| it.kind == PointKind::Hopf) {
                break BranchEnd::Equilibrium;
            }
            if self.stable_only && !next.orbit.is_stable() {
                break BranchEnd::Unstable;
            }
            points.push(problem.point(&next, PointKind::Regular));
            if step >= left {
                break BranchEnd::Range;
            }
            (at, step) = (next, (step * GROWTH).min(self.largest_step));
        };
        Ok(OrbitBranch { points, end })
    }
}

/// By how much a step along a branch grows if the one before has succeeded.
const GROWTH: f64 = 1.5;

/// How far a point may lie from its prediction, over the step: farther off another part of the
/// branch may have been met.
const MOST_OFF: f64 = 0.3;

/// Points of a branch are found to the first part of the scales; where branches cross, to roundings
/// below the second.
const CLOSE: (f64, f64) = (3e-8, 1e-5);

/// Steps along a branch are not shortened below this.
const SHORTEST: f64 = 3e-6;

/// Share of the width of the range by which the parameter is changed for a derivative: half of the
/// digits of a run.
const DIFFERENCE: f64 = 1e-6;

/// What can be special, in the order in which it is looked for: at a Hopf point the branch turns
/// back, too, and at a fold a multiplier passes 1.
const KINDS: [PointKind; 5] =
    [PointKind::Hopf, PointKind::Fold, PointKind::Flip, PointKind::Crossing, PointKind::Torus];

impl<const N: usize> Found<N> {
    /// What vanishes at a special point between this one and another.
    fn test(&self, kind: PointKind, other: &Self) -> f64 {
        let across: Vec<_> = self.orbit.transverse().iter().map(Multiplier::value).collect();
        let one = Complex::from(1.0);
        let product: Complex<f64> = match kind {
            PointKind::Hopf => return self.rate.dot(&other.rate) / other.rate.norm_squared(),
            PointKind::Flip => across.iter().map(|it| one + it).product(),
            PointKind::Crossing => across.iter().map(|it| one - it).product(),
            PointKind::Torus => {
                let pairs = across.iter().enumerate();
                pairs.flat_map(|(i, a)| across[..i].iter().map(move |b| one - a * b)).product()
            }
            _ => return by_parameter(&self.tangent),
        };
        product.re
    }
}

impl<S, F, const N: usize, const K: usize> Problem<'_, F, N, K>
where
    S: System<f64, N, K>,
    F: Fn(f64) -> Checked<S>,
{
    /// A parameter in its own unit. Refused outside the range, but for roundings.
    fn inside(&self, parameter: f64) -> Checked<f64> {
        let (value, &Range { start, end }) = (parameter * self.width, self.range);
        let inside = value.clamp(start, end);
        let is_inside = (value - inside).abs() <= 1e-12 * (value.abs() + self.width);
        let rule = Rule::Between { least: start, most: end };
        Named("parameter", value).check(is_inside, rule).map(|_| inside)
    }

    /// How far the end of the range is along the tangent.
    fn left(&self, from: &Found<N>) -> f64 {
        let along = by_parameter(&from.tangent);
        let end = if along < 0.0 { self.range.start } else { self.range.end };
        (end / self.width - from.unknowns.parameter) / along
    }

    /// A step along the tangent from a point.
    fn ahead(&self, from: &Found<N>, step: f64) -> Unknowns<N> {
        let mut at = from.unknowns.clone();
        at.add(&(&from.tangent * step), &self.cyclic);
        at
    }

    /// The point of the branch on the plane across a tangent, near one a step away from another.
    fn correct(&self, near: &Unknowns<N>, tangent: &DVector<f64>, step: f64) -> Answer<Found<N>> {
        let mut at = near.clone();
        let (mut off, weights) = (DVector::zeros(tangent.len()), self.weights(tangent.len()));
        let mut newton = Newton::new(self.most_iterations, CLOSE);
        loop {
            let system = (self.system)(self.inside(at.parameter)?)?;
            let (found, matrix) = self.equations(&system, &mut at, tangent)?;
            let correction = solve(matrix.clone(), &found.right)?;
            if newton.is_over(correction.norm())? {
                if self.period.is_none() && !(found.extent > SMALLEST) {
                    return Err(PeriodicError::Equilibrium);
                }
                let orbit = self.cyclic.orbit(&at.segments, &found.flows)?;
                let off = off.component_mul(&off).dot(&weights).sqrt();
                // Not onto another part of the branch.
                if off > MOST_OFF * step && step > 0.0 {
                    let (iterations, correction) = (self.most_iterations, off / step);
                    return Err(PeriodicError::NotConverged { iterations, correction });
                }
                let mut tangent = self.tangent(matrix)?;
                if self.cyclic.is_uneven(&found.flows) {
                    // The same tangent at other states: it changes T and p alike.
                    let before = at.whole(&tangent);
                    at.segments = self.cyclic.recut(at.segments[0].state, &found.flows)?;
                    tangent = self.tangent(self.equations(&system, &mut at, &tangent)?.1)?;
                    tangent *= at.whole(&tangent).dot(&before).signum();
                }
                let start = at.segments[0].state;
                let rate = self.cyclic.of(&system).scaled_rate(0.0, &start);
                return Ok(Found { unknowns: at, orbit, tangent, rate, extent: found.extent });
            }
            // The plane across the tangent is kept, as each correction lies in it.
            let correction = &correction * (0.5 / correction.norm()).min(1.0);
            at.add(&correction, &self.cyclic);
            off += correction;
        }
    }

    /// What the unknowns count in a length along the branch: the mean square of the states, and p.
    fn weights(&self, size: usize) -> DVector<f64> {
        let share = (N + 1) as f64 / (size - 1) as f64;
        DVector::from_fn(size, |i, _| match i {
            _ if i + 1 == size => 1.0,
            _ if i % (N + 1) == N => 0.0,
            _ => share,
        })
    }

    /// The tangent of length one, from the equations at a point.
    fn tangent(&self, matrix: DMatrix<f64>) -> Answer<DVector<f64>> {
        let mut right = DVector::zeros(matrix.nrows());
        right[matrix.nrows() - 1] = 1.0;
        let tangent = solve(matrix, &right)?;
        let length = tangent.component_mul(&tangent).dot(&self.weights(right.len())).sqrt();
        Ok(tangent / length)
    }

    /// Newton's equations for the segments and δp: the last one is that of the arclength.
    fn equations(
        &self,
        system: &S,
        at: &mut Unknowns<N>,
        tangent: &DVector<f64>,
    ) -> Answer<(Equations<N>, DMatrix<f64>)> {
        let above = at.parameter + DIFFERENCE;
        let difference = if self.inside(above).is_ok() { DIFFERENCE } else { -DIFFERENCE };
        let [place, beside] = [self.inside(at.parameter)?, self.inside(at.parameter + difference)?];
        let other = (self.system)(beside)?;
        let mut longer = 1.0;
        if let Some(forced) = self.period {
            let [period, later] = [place, beside].map(forced);
            let now: f64 = at.segments.iter().map(|it| it.period).sum();
            at.segments.iter_mut().for_each(|it| it.period *= period / now);
            longer = later / period;
        }
        let mut found = self.cyclic.of(system).equations(&mut at.segments)?;
        let last = found.right.len();
        found.right = found.right.resize_vertically(last + 1, 0.0);
        let mut matrix = found.matrix.clone().resize(last + 1, last + 1, 0.0);
        let mut time = 0.0;
        for (index, flow) in found.flows.iter().enumerate() {
            let Guess { state, period } = at.segments[index];
            let later = match self.period {
                Some(_) => longer * period,
                None => {
                    let target = self.cyclic.target(&at.segments, index).1;
                    self.cyclic.of(&other).arrival(&at.segments[index], &target)?
                }
            };
            let moved = self.cyclic.of(&other).end((longer * time, state), later)? - flow.end;
            // ∂τ/∂p over τ: the end is followed to where the motion arrives, which is less curved.
            let slower = (later / period - 1.0) / difference;
            let row = index * (N + 1);
            for i in 0..N {
                let moved = moved[i] / self.cyclic.scales[i] / difference;
                matrix[(row + i, last)] = moved - matrix[(row + i, row + N)] * slower;
            }
            if self.period.is_some() {
                matrix[(row + N, last)] = -slower;
            }
            time += period;
        }
        matrix.set_row(last, &tangent.component_mul(&self.weights(last + 1)).transpose());
        Ok((found, matrix))
    }

    /// The unknowns over half a period, of an odd cycle of an odd system.
    fn half(&self, found: &Found<N>) -> Answer<Option<Unknowns<N>>> {
        let parameter = found.unknowns.parameter;
        let (state, period) = (found.orbit.start, 0.5 * found.orbit.period);
        let system = (self.system)(self.inside(parameter)?)?;
        let running = self.cyclic.of(&system);
        let middle = running.end((0.0, state), period)?;
        let states = [state, 0.5 * state, running.end((0.0, state), 0.5 * period)?];
        // The parameter must leave the system odd, wherever in its range there is one.
        let is_odd = |parameter: f64| {
            (self.system)(parameter).map_or(true, |system| {
                let running = self.cyclic.of(&system);
                let rate = |state: &SVector<f64, N>| running.scaled_rate(0.0, state);
                let is_odd = |it| (rate(it) + rate(&-it)).norm() <= 1e-9 * rate(it).norm();
                states.iter().all(is_odd)
            })
        };
        let apart = (middle + state).component_div(&self.cyclic.scales).norm();
        let places = [self.inside(parameter)?, self.range.start, self.range.end];
        // Of points that are found to 3e-8.
        let half = self.period.is_none() && apart < 1e-5 && places.into_iter().all(is_odd);
        let segments = running.cut(Guess { state, period })?;
        Ok(half.then_some(Unknowns { segments, parameter }))
    }

    /// A point over the whole period.
    fn point(&self, found: &Found<N>, kind: PointKind) -> BranchPoint<N> {
        let is_half = self.cyclic.sign < 0.0;
        let orbit = if is_half { found.orbit.doubled() } else { found.orbit };
        // After −1 over half a period, 1 over the whole.
        let kind = if is_half && kind == PointKind::Flip { PointKind::Crossing } else { kind };
        BranchPoint { parameter: found.unknowns.parameter * self.width, orbit, kind }
    }

    /// The zero of a test function between two points.
    fn locate(
        &self,
        kind: PointKind,
        [from, to]: [&Found<N>; 2],
        step: f64,
    ) -> Option<BranchPoint<N>> {
        let end = |at: f64, it: &Found<N>| (at, it.test(kind, from));
        let (mut low, mut high) = (end(0.0, from), end(step, to));
        if !(low.1 * high.1 < 0.0) {
            return None;
        }
        let is = |it: &Found<N>| match kind {
            PointKind::Hopf => !it.orbit.forced && it.extent < step,
            // Two real multipliers whose product is one, neither of them one, are nothing.
            PointKind::Torus => it.orbit.transverse().iter().any(|it| it.log_modulus.abs() < 1e-3),
            _ => true,
        };
        let is_singular = matches!(kind, PointKind::Crossing | PointKind::Hopf);
        let enough = if is_singular { 1e-3 } else { 1e-9 };
        let mut point = is(to).then(|| self.point(to, kind));
        for _ in 0..20 {
            let place = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
            // Where branches cross, Newton's equations are singular: beside it, then.
            let beside = [place, 0.5 * (low.0 + place), 0.5 * (place + high.0)];
            let correct =
                |at| Some((at, self.correct(&self.ahead(from, at), &from.tangent, at).ok()?));
            let Some((place, found)) = beside.into_iter().find_map(correct) else { break };
            let new = end(place, &found);
            // Illinois: the end that stays counts half.
            if new.1 * low.1 > 0.0 {
                (low, high.1) = (new, 0.5 * high.1);
            } else {
                (high, low.1) = (new, 0.5 * low.1);
            }
            point = is(&found).then(|| self.point(&found, kind));
            if new.1.abs() < 1e-7 || high.0 - low.0 < enough * step {
                break;
            }
        }
        point
    }
}

impl<const N: usize> Unknowns<N> {
    /// Adds corrections in units of the scales, of the durations, and of the width of the range.
    fn add(&mut self, by: &DVector<f64>, cyclic: &Cyclic<N>) {
        cyclic.correct(&mut self.segments, by);
        self.parameter += by_parameter(by);
    }

    /// What T and p have of a change of all unknowns.
    fn whole(&self, by: &DVector<f64>) -> Vector2<f64> {
        let periods = self.segments.iter().enumerate();
        let period = periods.map(|(index, it)| by[index * (N + 1) + N] * it.period).sum();
        Vector2::new(period, by_parameter(by))
    }
}

/// What the parameter has of a change of all unknowns.
fn by_parameter(all: &DVector<f64>) -> f64 {
    all[all.len() - 1]
}
