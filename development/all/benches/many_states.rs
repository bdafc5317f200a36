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

use bristle::ode::{self, AnyMethod, Output, Solver, System, Tolerances, Trajectory};
use bristle_specimens::blocks::Few;
use bristle_specimens::joints::{Arm, Axes, Joints};
use nalgebra::SVector;

type Answer<const N: usize> = Result<Trajectory<f64, N>, Box<dyn Error>>;

const SPAN: core::ops::Range<f64> = 0.0..5.0;
const OUTPUT: Output<'static, f64> = Output::Uniform(201);
const METHODS: [AnyMethod; 3] =
    [AnyMethod::DormandPrince, AnyMethod::DormandPrince8, AnyMethod::Rodas5P];
/// Rounds of which the best counts.
const ROUNDS: usize = 7;

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

/// That follow 0.5 sin(0.7 t), 0.5 sin(1.01 t), …
fn joints<const K: usize>(gains: [f64; 2]) -> Joints<K> {
    Joints::new(gains, std::array::from_fn(|i| [0.5, 0.7 + 0.31 * i as f64, 0.0]))
}

fn scenes<const N: usize, const K: usize>() -> Result<(), Box<dyn Error>>
where
    Few<K>: System<f64, N, K>,
{
    compare::<_, N, K>("blocks", &Few::<K>)?;
    compare::<_, N, K>("axes", &Axes::<K>(joints([200.0, 8.0])))?;
    compare::<_, N, K>("arm, gain 100", &Arm::<K>(joints([100.0, 10.0])))?;
    compare::<_, N, K>("arm, gain 400", &Arm::<K>(joints([400.0, 40.0])))
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
