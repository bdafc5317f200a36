//! `ode::solve` beside the best single method on mechanisms of many contacts:
//! `cargo bench -p bristle-all --bench many_states`, about five minutes.
//!
//! Three scenes of 3 K states (position, velocity and deflection of each contact) over 5 s, none
//! with derivatives: K blocks in a row on a belt, where a reversal comes every few steps; K driven
//! axes side by side with springs between them; an arm of K links under gravity, whose joints
//! follow sines. `ode::solve` is given the tolerance of the solution. The single method is given
//! what no user has: of three methods, each with the loosest tolerance of a step (in quarter
//! decades) with which no sample is off by more than the tolerance, the one that takes the least
//! time. A sample is off by its largest difference from that of order 5 with steps of 1e-12, over
//! the scale of the state.
//!
//! Best times of several rounds count, in turns.

use std::error::Error;
use std::time::Instant;

use bristle::curve::Stribeck;
use bristle::ode::{self, AnyMethod, Output, Solver, System, Tolerances, Trajectory};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Branch, Bristle, Contact, FrBd, paper};
use bristle_specimens::blocks::Few;
use nalgebra::{SMatrix, SVector};

type Friction = Contact<f64, FrBd<Stribeck<f64>, KelvinVoigt<f64>>>;
type Answer<const N: usize> = Result<Trajectory<f64, N>, Box<dyn Error>>;

const SPAN: core::ops::Range<f64> = 0.0..5.0;
const OUTPUT: Output<'static, f64> = Output::Uniform(201);
const METHODS: [AnyMethod; 3] =
    [AnyMethod::DormandPrince, AnyMethod::DormandPrince8, AnyMethod::Rodas5P];
/// Rounds of which the best counts.
const ROUNDS: usize = 7;
/// Of the whole arm [m], [kg].
const LENGTH: f64 = 2.0;
const MASS: f64 = 3.0;
/// [m/s²].
const GRAVITY: f64 = 9.81;

/// Joints with position control and friction, each with a sine of its own to follow.
struct Joints {
    friction: Friction,
    /// Of the position [N m/rad] and of the velocity [N m s/rad].
    gains: [f64; 2],
}

impl Joints {
    fn new(gains: [f64; 2]) -> Result<Self, Box<dyn Error>> {
        let bristle = KelvinVoigtParameters { micro_stiffness: 1e3, micro_damping: 2.0 };
        let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
        let friction = FrBd::new(curve, KelvinVoigt::new(bristle)?).under_load(3.0)?;
        Ok(Self { friction, gains })
    }

    /// Writes the rates of position and deflection. Answers with the torque of joint i.
    fn torque(&self, i: usize, time: f64, state: &[f64], branch: Branch, rate: &mut [f64]) -> f64 {
        let [angle, velocity, deflection] = [0, 1, 2].map(|k| state[3 * i + k]);
        let friction = self.friction.response(branch.of(velocity), deflection);
        (rate[3 * i], rate[3 * i + 2]) = (velocity, friction.rate);
        let angular = 0.7 + 0.31 * i as f64;
        let (sine, cosine) = (angular * time).sin_cos();
        let off = [0.5 * sine - angle, 0.5 * angular * cosine - velocity];
        self.gains[0] * off[0] + self.gains[1] * off[1] - friction.force
    }

    fn scales<const N: usize>() -> SVector<f64, N> {
        SVector::from_fn(|i, _| [0.5, 0.5, 1e-3][i % 3])
    }
}

/// Side by side, with springs of 40 N m/rad between them.
struct Axes<const K: usize>(Joints);

impl<const N: usize, const K: usize> System<f64, N, K> for Axes<K> {
    fn rate(&self, time: f64, state: &SVector<f64, N>, branches: [Branch; K]) -> SVector<f64, N> {
        let mut rate = SVector::<f64, N>::zeros();
        for (i, branch) in branches.into_iter().enumerate() {
            let own = self.0.torque(i, time, state.as_slice(), branch, rate.as_mut_slice());
            let angle = |i: usize| state.get(3 * i).copied().unwrap_or(0.0);
            let before = if i == 0 { 0.0 } else { angle(i - 1) };
            let springs = 40.0 * (before + angle(i + 1) - 2.0 * angle(i));
            rate[3 * i + 1] = (own + springs) / (0.3 + 0.1 * i as f64);
        }
        rate
    }

    fn sliding_velocities(&self, _: f64, state: &SVector<f64, N>) -> [f64; K] {
        core::array::from_fn(|i| state[3 * i + 1])
    }

    fn scales(&self) -> SVector<f64, N> {
        Joints::scales()
    }
}

/// In a row, links with a mass at each end: with the angles φ from the horizontal, M φ̈ = Q,
/// Mᵢⱼ = m l² (K − max(i, j)) cos(φᵢ − φⱼ), and 0.02 kg m² more on the diagonal.
struct Arm<const K: usize>(Joints);

impl<const N: usize, const K: usize> System<f64, N, K> for Arm<K> {
    fn rate(&self, time: f64, state: &SVector<f64, N>, branches: [Branch; K]) -> SVector<f64, N> {
        let mut rate = SVector::<f64, N>::zeros();
        let (mut angles, mut speeds, mut torques) = ([0.0; K], [0.0; K], [0.0; K]);
        let (mut angle, mut speed) = (0.0, 0.0);
        for (i, branch) in branches.into_iter().enumerate() {
            torques[i] = self.0.torque(i, time, state.as_slice(), branch, rate.as_mut_slice());
            (angle, speed) = (angle + state[3 * i], speed + state[3 * i + 1]);
            (angles[i], speeds[i]) = (angle, speed);
        }
        let (mass, length) = (MASS / K as f64, LENGTH / K as f64);
        let mut inertia = SMatrix::<f64, K, K>::from_diagonal_element(0.02);
        let mut force = SVector::<f64, K>::zeros();
        for i in 0..K {
            let weight = mass * GRAVITY * length * (K - i) as f64 * angles[i].cos();
            force[i] = torques[i] - torques.get(i + 1).unwrap_or(&0.0) - weight;
            for j in 0..K {
                let (sine, cosine) = (angles[i] - angles[j]).sin_cos();
                let beyond = mass * length * length * (K - i.max(j)) as f64;
                inertia[(i, j)] += beyond * cosine;
                force[i] -= beyond * sine * speeds[j] * speeds[j];
            }
        }
        let accelerations = inertia.cholesky().map(|factors| factors.solve(&force));
        let accelerations = accelerations.unwrap_or(SVector::repeat(f64::NAN));
        for i in 0..K {
            let before = if i == 0 { 0.0 } else { accelerations[i - 1] };
            rate[3 * i + 1] = accelerations[i] - before;
        }
        rate
    }

    fn sliding_velocities(&self, _: f64, state: &SVector<f64, N>) -> [f64; K] {
        core::array::from_fn(|i| state[3 * i + 1])
    }

    fn scales(&self) -> SVector<f64, N> {
        Joints::scales()
    }
}

fn by_hand<S: System<f64, N, K>, const N: usize, const K: usize>(
    system: &S,
    method: AnyMethod,
    tolerance: f64,
) -> Answer<N> {
    let tolerances = Tolerances::scaled(tolerance, system.scales())?;
    let solver = Solver::adaptive(method, tolerances);
    Ok(solver.solve(system, SPAN, SVector::zeros(), OUTPUT)?)
}

/// The largest difference of two answers over the scales.
fn distance<const N: usize>(
    answer: &Trajectory<f64, N>,
    reference: &Trajectory<f64, N>,
    scales: &SVector<f64, N>,
) -> f64 {
    let samples = answer.states().iter().zip(reference.states());
    samples.map(|(a, b)| (a - b).component_div(scales).amax()).fold(0.0, f64::max)
}

fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

/// A row of the table.
fn compare<S: System<f64, N, K>, const N: usize, const K: usize>(
    name: &str,
    system: &S,
) -> Result<(), Box<dyn Error>> {
    let reference = by_hand(system, AnyMethod::DormandPrince, 1e-12)?;
    print!("| {name} | {N} ");
    for tolerance in [1e-6, 1e-9] {
        let ours = || ode::solve(system, SPAN, SVector::zeros(), tolerance, OUTPUT);
        let answer = ours()?;
        let off = distance(&answer, &reference, &system.scales()) / tolerance;
        // Of each method, the loosest step that will do.
        let mut single = METHODS.map(|method| {
            let steps =
                (0..24).map(|quarter| tolerance * 10f64.powf(1.0 - 0.25 * f64::from(quarter)));
            let mut enough = steps.take_while(|&step| step > 1e-12).filter_map(|step| {
                let answer = by_hand(system, method, step).ok()?;
                let is_near = distance(&answer, &reference, &system.scales()) <= tolerance;
                is_near.then(|| (step, answer.statistics().evaluations, f64::INFINITY))
            });
            enough.next()
        });
        let mut own = f64::INFINITY;
        for _ in 0..ROUNDS {
            own = own.min(seconds(|| drop(ours())));
            for (method, single) in METHODS.into_iter().zip(&mut single) {
                if let Some((step, _, best)) = single {
                    *best = best.min(seconds(|| drop(by_hand(system, method, *step))));
                }
            }
        }
        let best = single.into_iter().zip(METHODS).filter_map(|(single, method)| {
            single.map(|(_, evaluations, time)| (time, evaluations, method))
        });
        let best = best.min_by(|(one, ..), (other, ..)| one.total_cmp(other));
        let evaluations = answer.statistics().evaluations;
        match best {
            Some((time, by_hand, method)) => {
                let ratio = own / time;
                print!("| {evaluations}, {off:.1} | {by_hand}, {method:?} | {ratio:.1} ");
            }
            None => print!("| {evaluations}, {off:.1} | none | – "),
        }
    }
    println!("|");
    Ok(())
}

fn scenes<const N: usize, const K: usize>() -> Result<(), Box<dyn Error>>
where
    Few<K>: System<f64, N, K>,
{
    compare::<_, N, K>("blocks", &Few::<K>)?;
    compare::<_, N, K>("axes", &Axes::<K>(Joints::new([200.0, 8.0])?))?;
    compare::<_, N, K>("arm, gain 100", &Arm::<K>(Joints::new([100.0, 10.0])?))?;
    compare::<_, N, K>("arm, gain 400", &Arm::<K>(Joints::new([400.0, 40.0])?))
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("evaluations and worst sample over the tolerance; by hand; CPU time over that\n");
    println!("| scene | states | 1e-6 | by hand | ratio | 1e-9 | by hand | ratio |");
    println!("|---|---|---|---|---|---|---|---|");
    scenes::<3, 1>()?;
    scenes::<6, 2>()?;
    scenes::<12, 4>()?;
    scenes::<21, 7>()?;
    scenes::<42, 14>()
}
