//! Reference solutions, by a method that shares nothing with the crate's integrators.
//!
//! Over a step of length h the rate ẋ is a polynomial of degree s − 1 that satisfies ẋ = f(t, x) at
//! the s nodes c₁ … c_s of the step (collocation, with Radau's nodes of order 2s − 1 at its end,
//! and L-stable):
//!
//!     kᵢ = f(t₀ + cᵢh, x₀ + h Σⱼ aᵢⱼ kⱼ),   x₁ = x₀ + h Σⱼ bⱼ kⱼ
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | t₀, x₀, h | start of the step, state there, length of the step | s, –, s |
//! | cᵢ, bᵢ | nodes and weights on \[0, 1\], from the Legendre polynomials | – |
//! | aᵢⱼ | integral of the j-th Lagrange polynomial from 0 to cᵢ | – |
//! | kᵢ | rate at the i-th node, the unknowns | unit of x per s |
//!
//! Newton's iteration solves for all kᵢ together, in units of each state's scale over h, with the
//! system's own Jacobian at every node, until it gains nothing more. The step is chosen by the last
//! two Legendre coefficients of the rate, so that the polynomial is accurate everywhere in the
//! step; its end is more accurate than that by many powers of ten where the step resolves the fast
//! parts. Steps end on every output sample, on every kink of an input (seen from before it), and
//! where a sliding velocity reverses: the branch of |v| is locked within a step, and the length at
//! which v = 0 is found by secants over steps of exactly that length. States are summed with their
//! rounding errors kept.
//!
//! A velocity on the wrong side of zero may be rounding. What rounds is the balance of forces (in
//! the valve 9.3 kN of pressure against 60 N of friction), by 155 · 1.1e-16 = 2e-14 of the friction
//! force and, on a bristle whose swing defines the velocity's scale, by as much of that scale; and
//! the time of the last reversal, by an ulp. Less than that is no reversal.
//!
//! # What is reached
//!
//! The judged component, largest difference over all samples and over the scale of the scene: from
//! [`OTHER`] (Gauss nodes, order 18, steps at most 0.37 of a sample, ten times the noise); from
//! Gauss nodes with 12 stages; and, as methods of another kind, from the crate's own at the best of
//! their settings, with fixed steps too. Those are limited by their own rounding, over up to 10⁶
//! steps. The bench prints the first; the others, the slip periods and the words below were
//! measured once, by hand.
//!
//! | scene | FrBD: OTHER | Gauss 12 | the crate | LuGre: OTHER | Gauss 12 | the crate |
//! |---|---|---|---|---|---|---|
//! | S1 | 7e-15 | 9e-15 | 4e-13 | 5e-15 | 1e-14 | 6e-13 |
//! | S2 ramp | 1e-14 | 6e-15 | 7e-14 | 2e-16 | 2e-16 | 3e-15 |
//! | S2 sine | 2e-15 | 2e-15 | 2e-14 | 3e-16 | 3e-16 | 1e-14 |
//! | S3 1 Hz | 2e-14 | 2e-14 | 6e-14 | 1e-14 | 8e-15 | 1e-13 |
//! | S3 5 Hz | 9e-15 | 1e-14 | 2e-13 | 4e-15 | 5e-15 | 1e-13 |
//! | S3 10 Hz | 4e-15 | 4e-15 | 4e-14 | 3e-15 | 4e-15 | 3e-14 |
//! | S4, all | 2e-16 | 3e-16 | 7e-15 | 2e-16 | 3e-16 | 8e-15 |
//!
//! The time between slips in S1 comes out as 7.6392670 s (FrBD) and 7.6309184 s (LuGre). Twenty
//! times less noise, or ten times more, changes no scene by more than 1.2e-15. In the ramp the
//! valve's stem never reverses: held by almost its breakaway force it follows the pressure, which
//! approaches its end as e^(−t/τ), and at 120 s still creeps forward at 2e-13 m/s, of which 4e-14
//! m/s is uncertain.
//!
//! Source: E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", sections IV.5 and
//! IV.8.

use std::f64::consts::{PI, TAU};
use std::fmt;

use bristle::Branch;
use bristle::ode::System;
use nalgebra::SVector;

use crate::scenes::{SAMPLES, Scene};

/// How a reference is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    /// Which nodes.
    pub nodes: Nodes,
    /// Stages s of the collocation.
    pub stages: usize,
    /// What the last two Legendre coefficients may add to a state within a step, over its scale.
    pub tolerance: f64,
    /// Longest step, as a part of the distance between two samples.
    pub longest: f64,
    /// A sliding velocity on the wrong side of zero by less than this part of its scale is no
    /// reversal.
    pub noise: f64,
}

/// The nodes of a collocation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nodes {
    /// Radau's, the last of them at the end of the step: order 2s − 1, L-stable.
    Radau,
    /// Gauss's: order 2s, A-stable, no damping.
    Gauss,
}

/// The reference.
pub const FINE: Rule =
    Rule { nodes: Nodes::Radau, stages: 12, tolerance: 1e-13, longest: 1.0, noise: 2e-14 };

/// What it is checked against.
pub const OTHER: Rule =
    Rule { nodes: Nodes::Gauss, stages: 9, tolerance: 3e-13, longest: 0.37, noise: 2e-13 };

/// Trial steps after which a scene is given up: 70 times what any has needed.
const MOST_STEPS: usize = 1_000_000;

/// Places within a step at which the sliding velocity is looked at, besides the end.
const LOOKS: [f64; 20] = [
    1e-4, 1e-3, 0.01, 0.03, 0.06, 0.1, 0.15, 0.2, 0.27, 0.34, 0.41, 0.48, 0.55, 0.62, 0.69, 0.76,
    0.83, 0.9, 0.95, 0.98,
];

/// Why there is no reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReferenceError {
    /// The system does not tell its Jacobian.
    NoTangent,
    /// The steps shrink to nothing at this time \[s\].
    Stalled(f64),
}

impl fmt::Display for ReferenceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoTangent => write!(f, "the system does not tell its Jacobian"),
            Self::Stalled(time) => write!(f, "the reference does not get beyond t = {time} s"),
        }
    }
}

impl std::error::Error for ReferenceError {}

/// The judged component at the uniform samples.
pub fn reference<S: System<f64, N> + Clone, const N: usize>(
    scene: &Scene<S, N>,
) -> Result<Vec<f64>, ReferenceError> {
    Ok(solve(scene, FINE)?.judged(scene))
}

/// How far a second reference lies from the first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Check {
    /// Greatest difference over all samples, over the judged scale.
    pub difference: f64,
    /// Steps of the second.
    pub steps: usize,
    /// Reversals of the sliding velocity in the second.
    pub reversals: usize,
}

/// Compares a reference with one of other nodes, another order, other and shorter steps, and
/// another tolerance of rounding at reversals.
pub fn check<S: System<f64, N> + Clone, const N: usize>(
    scene: &Scene<S, N>,
    reference: &[f64],
) -> Result<Check, ReferenceError> {
    let other = solve(scene, OTHER)?;
    let apart = reference.iter().zip(other.judged(scene)).map(|(a, b)| (a - b).abs());
    Ok(Check {
        difference: apart.fold(0.0, f64::max) / scene.scale,
        steps: other.steps,
        reversals: other.reversals.len(),
    })
}

/// A reference with all its states.
#[derive(Debug, Clone)]
pub struct Solution<const N: usize> {
    /// The states at the uniform samples.
    pub states: Vec<SVector<f64, N>>,
    /// Steps taken.
    pub steps: usize,
    /// Times \[s\] at which the sliding velocity reverses.
    pub reversals: Vec<f64>,
}

impl<const N: usize> Solution<N> {
    /// The judged component alone.
    pub fn judged<S>(&self, scene: &Scene<S, N>) -> Vec<f64> {
        self.states.iter().map(|state| state[scene.judged]).collect()
    }
}

/// Solves a scene by a rule.
pub fn solve<S: System<f64, N> + Clone, const N: usize>(
    scene: &Scene<S, N>,
    rule: Rule,
) -> Result<Solution<N>, ReferenceError> {
    let nodes = Collocation::new(rule.nodes, rule.stages);
    let mut run = Run {
        scene,
        nodes: &nodes,
        noise: rule.noise,
        time: 0.0,
        state: scene.start,
        rounding: SVector::zeros(),
        latest: f64::INFINITY,
        branch: Branch::Forward,
        solution: Solution { states: vec![scene.start], steps: 0, reversals: Vec::new() },
    };
    let longest = rule.longest * scene.end / (SAMPLES - 1) as f64;
    let mut step = longest * 1e-3;
    let mut turned = false;
    let mut trials = 0;
    for sample in 1..SAMPLES {
        let goal = if sample + 1 == SAMPLES {
            scene.end
        } else {
            scene.end * (sample as f64 / (SAMPLES - 1) as f64)
        };
        while run.time < goal {
            // A kink on the sample counts, too.
            let kink = scene.system.next_kink(run.time, goal.next_up());
            let stop = kink.unwrap_or(goal);
            run.latest = kink.map_or(f64::INFINITY, f64::next_down);
            step = step.min(longest);
            let (end, length) = run.until(stop, step);
            trials += 1;
            if !(length > 0.0) || step < 1e-20 || trials > MOST_STEPS {
                return Err(ReferenceError::Stalled(run.time));
            }
            let Some(piece) = run.collocate(length)? else {
                step = 0.5 * length;
                continue;
            };
            let error = run.neglected(&piece);
            let room = 0.9 * (rule.tolerance / error).powf(1.0 / (rule.stages as f64 - 1.0));
            if error > rule.tolerance {
                step = length * room.clamp(0.2, 0.9);
                continue;
            }
            let grown = step.max(length * room.clamp(0.2, 2.0));
            match run.first_wrong(&piece) {
                None => {
                    run.accept(&piece, end);
                    step = grown;
                    turned = false;
                }
                Some((None, _)) if turned => {
                    // Wrong on either branch: it turns back within the step. A shorter one tells.
                    step = 0.1 * length;
                    turned = false;
                }
                Some((None, _)) => {
                    run.branch = run.branch.reversed();
                    turned = true;
                }
                Some((Some(right), wrong)) => {
                    let (piece, end) = run.up_to_reversal(&piece, right, wrong)?;
                    run.accept(&piece, end);
                    run.solution.reversals.push(end);
                    run.branch = run.branch.reversed();
                    turned = false;
                }
            }
        }
        run.solution.states.push(run.state);
    }
    Ok(run.solution)
}

/// A solution on its way.
struct Run<'a, S, const N: usize> {
    scene: &'a Scene<S, N>,
    nodes: &'a Collocation,
    noise: f64,
    time: f64,
    state: SVector<f64, N>,
    /// What the rounding of the state has lost.
    rounding: SVector<f64, N>,
    /// The last time at which the inputs are what they are now.
    latest: f64,
    branch: Branch,
    solution: Solution<N>,
}

/// A step: the Legendre coefficients of the rate, times the length of the step.
struct Piece<const N: usize> {
    length: f64,
    coefficients: Vec<SVector<f64, N>>,
}

impl<const N: usize> Piece<N> {
    /// What has been added to the state at a fraction of the step.
    fn gain(&self, fraction: f64) -> SVector<f64, N> {
        let x = 2.0 * fraction - 1.0;
        // ∫₀^θ P_k = (P_{k+1} − P_{k−1})/(2(2k + 1)), with P₋₁ = −1 for k = 0.
        let (mut before, mut now) = (-1.0, 1.0);
        let mut sum = SVector::zeros();
        for (k, coefficient) in self.coefficients.iter().enumerate() {
            let after = next_legendre(k, x, before, now);
            sum += coefficient * ((after - before) / (2.0 * (2 * k + 1) as f64));
            (before, now) = (now, after);
        }
        sum
    }

    /// What is added over the whole step: all polynomials but the first have mean zero.
    fn total(&self) -> SVector<f64, N> {
        self.coefficients[0]
    }
}

impl<S: System<f64, N> + Clone, const N: usize> Run<'_, S, N> {
    /// The end and the length of a step that does not go beyond a stop. The length is the exact
    /// difference of the two times.
    fn until(&self, stop: f64, step: f64) -> (f64, f64) {
        let left = stop - self.time;
        let end = if step > 0.999 * left {
            stop
        } else if step > 0.5 * left {
            self.time + 0.5 * left
        } else {
            self.time + step
        };
        (end, end - self.time)
    }

    /// Solves the collocation equations over a length; `None` where Newton's iteration fails.
    fn collocate(&self, length: f64) -> Result<Option<Piece<N>>, ReferenceError> {
        let Collocation { nodes, integrals, .. } = self.nodes;
        let stages = nodes.len();
        let scales = &self.scene.scales;
        let tangent = |time: f64, gain: &SVector<f64, N>| {
            let state = self.state + (self.rounding + gain);
            self.scene.system.linearised(time, &state, [self.branch])
        };
        let first = tangent(self.time, &SVector::zeros()).ok_or(ReferenceError::NoTangent)?;
        // h kᵢ over the scales.
        let guess = (first.rate * length).component_div(scales);
        let mut gains = vec![guess; stages];
        let mut system = Linear::new(stages * N);
        let mut previous = f64::INFINITY;
        for _ in 0..20 {
            for (i, (node, integrals)) in nodes.iter().zip(integrals).enumerate() {
                let terms = gains.iter().zip(integrals).map(|(gain, integral)| gain * *integral);
                let gain = terms.sum::<SVector<f64, N>>().component_mul(scales);
                let time = (self.time + node * length).min(self.latest);
                let here = tangent(time, &gain).ok_or(ReferenceError::NoTangent)?;
                for row in 0..N {
                    let equation = i * N + row;
                    let by_scale = length / scales[row];
                    system.right[equation] = here.rate[row] * by_scale - gains[i][row];
                    for (j, integral) in integrals.iter().enumerate() {
                        for column in 0..N {
                            let slope = here.by_state[(row, column)] * scales[column] * by_scale;
                            let unit = if i == j && row == column { 1.0 } else { 0.0 };
                            system.set(equation, j * N + column, unit - integral * slope);
                        }
                    }
                }
            }
            if !system.solve() {
                return Ok(None);
            }
            let mut change = 0.0_f64;
            for (index, &correction) in system.right.iter().enumerate() {
                gains[index / N][index % N] += correction;
                change = change.max(correction.abs());
            }
            let done = change < 1e-16 || (change < 1e-11 && change > 0.25 * previous);
            if done {
                let piece = self.nodes.legendre(length, &gains, scales);
                return Ok(Some(piece));
            }
            previous = change;
        }
        Ok(None)
    }

    /// What the last two Legendre coefficients add to a state, over its scale.
    fn neglected(&self, piece: &Piece<N>) -> f64 {
        let last = piece.coefficients.iter().rev().take(2);
        let size = last.map(|c| c.component_div(&self.scene.scales).amax()).fold(0.0, f64::max);
        size / (2 * piece.coefficients.len() - 1) as f64 + 1e-30
    }

    /// The sliding velocity at a fraction of a step, positive on the right side of the branch.
    fn ahead(&self, piece: &Piece<N>, fraction: f64) -> f64 {
        let gain = if fraction == 1.0 { piece.total() } else { piece.gain(fraction) };
        let state = self.state + (self.rounding + gain);
        let time = self.time + fraction * piece.length;
        let [velocity] = self.scene.system.sliding_velocities(time, &state);
        self.branch.of(velocity).speed()
    }

    /// The sliding velocity that rounding may leave on the wrong side of zero: of the velocity and
    /// the state, and of the time at which the last reversal was placed.
    fn rounding_of_velocity(&self) -> f64 {
        let velocity = |time: f64, state: &SVector<f64, N>| {
            let [velocity] = self.scene.system.sliding_velocities(time, state);
            velocity
        };
        let now = velocity(self.time, &self.state);
        let soon = 1e-3 * self.scene.end / SAMPLES as f64;
        let rate = self.scene.system.rate(self.time, &self.state, [self.branch]);
        let then = velocity(self.time + soon, &(self.state + rate * soon));
        let acceleration = (then - now).abs() / soon;
        let mut noise = 2.0 * f64::EPSILON * (now.abs() + self.time * acceleration);
        for (index, scale) in self.scene.scales.iter().enumerate() {
            let mut beside = self.state;
            beside[index] += scale;
            noise += self.noise * (velocity(self.time, &beside) - now).abs();
        }
        noise
    }

    /// The first place in a step at which the velocity is on the wrong side, and the last place
    /// before it at which it is on the right one, if there is any.
    fn first_wrong(&self, piece: &Piece<N>) -> Option<(Option<f64>, f64)> {
        let noise = self.rounding_of_velocity();
        let mut right = None;
        for fraction in [0.0].into_iter().chain(LOOKS).chain([1.0]) {
            let ahead = self.ahead(piece, fraction);
            if ahead < -noise {
                return Some((right, fraction));
            }
            if ahead > noise {
                right = Some(fraction);
            }
        }
        None
    }

    /// A step to the reversal that lies between two places of a trial step, and its end.
    fn up_to_reversal(
        &self,
        trial: &Piece<N>,
        right: f64,
        wrong: f64,
    ) -> Result<(Piece<N>, f64), ReferenceError> {
        // Halving on the polynomial of the trial, which is as accurate as the tolerance …
        let (mut right, mut wrong) = (right, wrong);
        for _ in 0..60 {
            let middle = 0.5 * (right + wrong);
            if self.ahead(trial, middle) > 0.0 {
                right = middle;
            } else {
                wrong = middle;
            }
        }
        // … then steps of that very length, corrected by the slope of the trial there.
        let beside = 1e-3 * right;
        let slope = (self.ahead(trial, right + beside) - self.ahead(trial, right - beside))
            / (2.0 * beside * trial.length);
        let mut end = self.time + right * trial.length;
        let mut best: Option<(f64, Piece<N>, f64)> = None;
        for _ in 0..4 {
            let length = end - self.time;
            if !(length > 0.0) {
                break;
            }
            let Some(piece) = self.collocate(length)? else { break };
            let left = self.ahead(&piece, 1.0);
            if best.as_ref().is_none_or(|(least, ..)| left.abs() < *least) {
                best = Some((left.abs(), piece, end));
            }
            end -= left / slope;
        }
        let (_, piece, end) = best.ok_or(ReferenceError::Stalled(self.time))?;
        Ok((piece, end))
    }

    fn accept(&mut self, piece: &Piece<N>, end: f64) {
        self.time = end;
        let gain = self.rounding + piece.total();
        let sum = self.state + gain;
        // What the sum has lost (O. Møller, 1965; D. E. Knuth, two-sum).
        let part = sum - self.state;
        self.rounding = (self.state - (sum - part)) + (gain - part);
        self.state = sum;
        self.solution.steps += 1;
    }
}

/// P_{k+1}(x) from P_{k−1} and P_k.
fn next_legendre(k: usize, x: f64, before: f64, now: f64) -> f64 {
    if k == 0 { x } else { ((2 * k + 1) as f64 * x * now - k as f64 * before) / (k + 1) as f64 }
}

/// A root by Newton's iteration on a function and its slope.
fn root(guess: f64, function: impl Fn(f64) -> (f64, f64)) -> f64 {
    (0..10).fold(guess, |x, _| {
        let (value, slope) = function(x);
        x - value / slope
    })
}

/// Nodes on \[0, 1\], with what follows from them.
struct Collocation {
    nodes: Vec<f64>,
    /// aᵢⱼ.
    integrals: Vec<Vec<f64>>,
    /// (2k + 1) bⱼ P_k(cⱼ), row k: what takes rates at the nodes to Legendre coefficients.
    transform: Vec<Vec<f64>>,
}

impl Collocation {
    fn new(kind: Nodes, stages: usize) -> Self {
        // P₀ … P_s at x, with P₋₁ = −1 before them.
        let legendre = |x: f64| {
            let mut values = vec![-1.0, 1.0];
            for k in 0..stages {
                values.push(next_legendre(k, x, values[k], values[k + 1]));
            }
            values
        };
        let order = stages as f64;
        // (1 − x²) P_s′ = s (P_{s−1} − x P_s)
        let slope = |x: f64, before: f64, now: f64| order * (before - x * now) / (1.0 - x * x);
        let (mut nodes, mut weights) = (Vec::new(), Vec::new());
        for i in 0..stages {
            let i = i as f64;
            match kind {
                Nodes::Gauss => {
                    // P_s(x) = 0, b = 1/((1 − x²) P_s′²)
                    let guess = -(PI * (i + 0.75) / (order + 0.5)).cos();
                    let x = root(guess, |x| {
                        let values = legendre(x);
                        let (before, now) = (values[stages], values[stages + 1]);
                        (now, slope(x, before, now))
                    });
                    let values = legendre(x);
                    let slope = slope(x, values[stages], values[stages + 1]);
                    nodes.push(x);
                    weights.push(1.0 / ((1.0 - x * x) * slope * slope));
                }
                Nodes::Radau if i == 0.0 => {
                    nodes.push(1.0);
                    weights.push(1.0 / (order * order));
                }
                Nodes::Radau => {
                    // P_s(x) = P_{s−1}(x), b = (1 + x)/(2 s² P_{s−1}²)
                    let guess = (TAU * i / (2.0 * order - 1.0)).cos();
                    let x = root(guess, |x| {
                        let values = legendre(x);
                        let (before, now) = (values[stages], values[stages + 1]);
                        // (1 − x²) P_{s−1}′ = s (x P_{s−1} − P_s)
                        let slope_before = order * (x * before - now) / (1.0 - x * x);
                        (now - before, slope(x, before, now) - slope_before)
                    });
                    let before = legendre(x)[stages];
                    nodes.push(x);
                    weights.push(0.5 * (1.0 + x) / (order * order * before * before));
                }
            }
        }
        let values: Vec<Vec<f64>> = nodes.iter().map(|&x| legendre(x)).collect();
        let transform: Vec<Vec<f64>> = (0..stages)
            .map(|k| {
                let row = weights.iter().zip(&values);
                row.map(|(weight, values)| (2 * k + 1) as f64 * weight * values[k + 1]).collect()
            })
            .collect();
        let integrals = values
            .iter()
            .map(|at| {
                let integral = |k: usize| (at[k + 2] - at[k]) / (2.0 * (2 * k + 1) as f64);
                (0..stages)
                    .map(|j| (0..stages).map(|k| integral(k) * transform[k][j]).sum())
                    .collect()
            })
            .collect();
        let nodes = nodes.into_iter().map(|x| 0.5 * (1.0 + x)).collect();
        Self { nodes, integrals, transform }
    }

    /// The step whose rates at the nodes, times its length and over the scales, are given.
    fn legendre<const N: usize>(
        &self,
        length: f64,
        gains: &[SVector<f64, N>],
        scales: &SVector<f64, N>,
    ) -> Piece<N> {
        let coefficient = |row: &Vec<f64>| {
            let terms = row.iter().zip(gains).map(|(weight, gain)| gain * *weight);
            terms.sum::<SVector<f64, N>>().component_mul(scales)
        };
        Piece { length, coefficients: self.transform.iter().map(coefficient).collect() }
    }
}

/// A dense linear system, solved by elimination with row exchanges.
struct Linear {
    size: usize,
    matrix: Vec<f64>,
    /// The right-hand side, then the solution.
    right: Vec<f64>,
}

impl Linear {
    fn new(size: usize) -> Self {
        Self { size, matrix: vec![0.0; size * size], right: vec![0.0; size] }
    }

    fn set(&mut self, row: usize, column: usize, value: f64) {
        self.matrix[row * self.size + column] = value;
    }

    /// Whether there is a finite solution.
    fn solve(&mut self) -> bool {
        let n = self.size;
        for pivot in 0..n {
            let mut best = pivot;
            for row in pivot + 1..n {
                let size = |row: usize| self.matrix[row * n + pivot].abs();
                if size(row) > size(best) {
                    best = row;
                }
            }
            if best != pivot {
                for column in pivot..n {
                    self.matrix.swap(best * n + column, pivot * n + column);
                }
                self.right.swap(best, pivot);
            }
            let (above, below) = self.matrix.split_at_mut((pivot + 1) * n);
            let line = &above[pivot * n..];
            let inverse = 1.0 / line[pivot];
            for (offset, row) in below.chunks_exact_mut(n).enumerate() {
                let factor = row[pivot] * inverse;
                if factor != 0.0 {
                    for (value, over) in row[pivot + 1..].iter_mut().zip(&line[pivot + 1..]) {
                        *value -= factor * over;
                    }
                    self.right[pivot + 1 + offset] -= factor * self.right[pivot];
                }
            }
        }
        for row in (0..n).rev() {
            let line = &self.matrix[row * n..(row + 1) * n];
            let known: f64 =
                line[row + 1..].iter().zip(&self.right[row + 1..]).map(|(a, x)| a * x).sum();
            self.right[row] = (self.right[row] - known) / line[row];
        }
        self.right.iter().all(|value| value.is_finite())
    }
}
