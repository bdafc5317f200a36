//! Work over precision on the transient of a tyre: Table 1, U = 2 m/s,
//! v(t) = 1 − exp(−t/5 ms) + 0.5 sin(2π 10 t), 0 … 0.5 s, from undeflected bristles.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use bristle::curve::Stribeck;
use bristle::rheology::KelvinVoigt;
use bristle::signal::Function;
use bristle::{Bristle, FrBd, LuGre, paper};
use bristle_charts::{Csv, println};
use bristle_rolling::{Grid, Motion, Patch, PatchParameters, PolynomialExponential, Pressure};

use crate::characteristics::{SmoothHistory, gauss};
use crate::upwind::Upwind;

/// Rolling speed [m/s].
const SPEED: f64 = 2.0;
/// Transport velocity, speed over length [1/s].
const TRANSPORT: f64 = 20.0;
const END: f64 = 0.5;
const SAMPLES: usize = 100;
/// No setting is tried that is expected to take longer than this \[s\].
const LONG: f64 = 6.0;
/// Below this the error is rounding.
const ROUNDING: f64 = 2e-14;

/// One solver with one setting.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    pub(crate) model: &'static str,
    pub(crate) pressure: &'static str,
    pub(crate) solver: &'static str,
    /// Steps between two samples for the exact reduction, cells of a grid.
    pub(crate) setting: usize,
    /// Greatest error of F/F_z.
    pub(crate) error: f64,
    /// Shortest time of a run \[s\].
    pub(crate) seconds: f64,
}

pub(crate) const SOLVERS: [&str; 5] = [
    "exact reduction, 4th order",
    "exact reduction, 2nd order",
    "semi-Lagrangian",
    "semi-Lagrangian, v held",
    "upwind, v held",
];

fn slip(t: f64) -> f64 {
    1.0 - (-t / 0.005).exp() + 0.5 * (20.0 * std::f64::consts::PI * t).sin()
}

fn time(number: usize, steps: usize) -> f64 {
    END * number as f64 / steps as f64
}

pub(crate) fn measure() -> Result<Vec<Row>, Box<dyn Error>> {
    let curve = Stribeck::new(paper::TYRE_CURVE)?;
    let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
    let mut rows = Vec::new();
    each_pressure(&mut rows, "frbd", FrBd::new(curve, bristle))?;
    each_pressure(&mut rows, "lugre", LuGre::classical(curve, bristle))?;
    Ok(rows)
}

fn each_pressure<M: Bristle<f64, Deflection = f64> + Copy>(
    rows: &mut Vec<Row>,
    name: &'static str,
    model: M,
) -> Result<(), Box<dyn Error>> {
    let exponential = PolynomialExponential::exponential(bristle_rolling::TYRE_PRESSURE_DECAY)?;
    sweep(rows, (name, "parabolic"), model, PolynomialExponential::parabolic())?;
    sweep(rows, (name, "constant"), model, PolynomialExponential::constant())?;
    sweep(rows, (name, "exponential"), model, exponential)
}

fn sweep<M: Bristle<f64, Deflection = f64> + Copy, const N: usize>(
    rows: &mut Vec<Row>,
    (model_name, pressure_name): (&'static str, &'static str),
    model: M,
    pressure: PolynomialExponential<f64, N>,
) -> Result<(), Box<dyn Error>> {
    let patch =
        Patch::new(PatchParameters { model, length: bristle_rolling::TYRE_LENGTH, pressure })?;
    let patch = patch.under_load(1.0)?;
    let reference = reference(&patch, 2e-4);
    let other = reference_error(&reference, &self::reference(&patch, 1.3e-4));
    let done = rows.chunk_by(|a, b| (a.model, a.pressure) == (b.model, b.pressure)).count();
    let number = format!("{} of 6", done + 1);
    println!("{model_name}, {pressure_name}, {number}: two references differ by {other:.1e}");
    if !(other < ROUNDING) {
        return Err(format!("the references differ by {other:e}").into());
    }
    for solver in SOLVERS {
        println!("  {solver}: setting, error, time / ms");
        // Steps a sample or cells, doubled.
        let mut setting = match solver {
            _ if solver.starts_with("exact") => 1,
            _ if solver.starts_with("upwind") => 25,
            _ => 20,
        };
        let mut last: Option<Row> = None;
        loop {
            let run = || run(&patch, solver, setting);
            let (forces, mut seconds) = timed(run)?;
            let error = reference_error(&reference, &forces);
            let again = match seconds {
                short if short < 0.01 => 9,
                long if long > 0.5 => 0,
                _ => 1,
            };
            for _ in 0..again {
                seconds = seconds.min(timed(run)?.1);
            }
            println!("    {setting:6} {error:8.1e} {:10.4}", seconds * 1e3);
            let row =
                Row { model: model_name, pressure: pressure_name, solver, setting, error, seconds };
            let stuck = last.as_ref().is_some_and(|last| error > 0.6 * last.error && error < 1e-11);
            rows.push(row.clone());
            last = Some(row);
            // A grid takes four times as long for twice the cells.
            let slow = solver.ends_with("2nd order") && error < 1e-10;
            if stuck || slow || error < ROUNDING || 4.0 * seconds > LONG {
                break;
            }
            setting *= 2;
        }
    }
    Ok(())
}

type Forces = Result<Vec<f64>, Box<dyn Error>>;

fn timed(run: impl Fn() -> Forces) -> Result<(Vec<f64>, f64), Box<dyn Error>> {
    let begin = Instant::now();
    let forces = run()?;
    Ok((forces, begin.elapsed().as_secs_f64()))
}

fn run<M: Bristle<f64, Deflection = f64> + Copy, const N: usize>(
    patch: &Patch<f64, M, PolynomialExponential<f64, N>>,
    solver: &str,
    setting: usize,
) -> Forces {
    let mut forces = Vec::with_capacity(SAMPLES);
    // V times the time between two samples.
    let way = TRANSPORT * END / SAMPLES as f64;
    if solver.starts_with("exact") {
        let follow = solver.ends_with("4th order");
        // The rate is never asked for.
        let signal = Function::new(|t| (slip(t), f64::NAN), []);
        let motion = Motion { slip_velocity: signal, rolling_speed: SPEED };
        let steps = SAMPLES * setting;
        let mut rolling = (*patch).exact_in((setting as f64 / way) as usize + 10)?;
        for number in 0..steps {
            let span = time(number, steps)..time(number + 1, steps);
            let force = if follow {
                rolling.follow(&motion, span)?
            } else {
                let slip_velocity = slip(0.5 * (span.start + span.end));
                let middle = Motion { slip_velocity, rolling_speed: SPEED };
                rolling.step(middle, span.end - span.start)?;
                rolling.force(slip(span.end))
            };
            if (number + 1) % setting == 0 {
                forces.push(force);
            }
        }
        return Ok(forces);
    }
    let upwind = solver.starts_with("upwind");
    let courant = if upwind { 0.9 } else { 1.0 };
    let mut grid = Grid::new(patch, setting)?;
    let mut baseline = Upwind::new(patch.model(), &grid);
    // The semi-Lagrangian grids have a multiple of ten cells: a Courant number of one.
    let parts = (way * setting as f64 / courant - 1e-9).ceil() as usize;
    let steps = SAMPLES * parts;
    let h = END / steps as f64;
    for number in 0..steps {
        let start = time(number, steps);
        if upwind {
            baseline.step(slip(start + 0.5 * h), TRANSPORT * h * setting as f64, h);
        } else if solver.ends_with("held") {
            let slip_velocity = slip(start + 0.5 * h);
            grid.step(Motion { slip_velocity, rolling_speed: SPEED }, h)?;
        } else {
            let field =
                Motion { slip_velocity: |_, t: f64| slip(start + t), rolling_speed: |_, _| SPEED };
            grid.step_field(&field, h)?;
        }
        if (number + 1) % parts == 0 {
            let slip = slip(time(number + 1, steps));
            forces.push(if upwind { baseline.force(slip) } else { grid.force(|_| slip) });
        }
    }
    Ok(forces)
}

/// F/F_z at the samples by quadrature of the characteristics, in panels of some length \[s\].
fn reference<M: Bristle<f64, Deflection = f64>, const N: usize>(
    patch: &Patch<f64, M, PolynomialExponential<f64, N>>,
    panel: f64,
) -> Vec<f64> {
    let model = patch.model();
    let history = SmoothHistory {
        coefficients: &|t| {
            let affine = model.affine((slip(t)).into(), 0.0);
            (affine.relaxation, affine.drive * slip(t))
        },
        transport: &|_| TRANSPORT,
        kinks: &[],
        panel,
    };
    let gauss = gauss();
    let pressure = patch.pressure();
    let rest = |place: f64| {
        let left = 1.0 - place;
        gauss.iter().map(|(node, weight)| left * weight * pressure.at(place + left * node)).sum()
    };
    (1..=SAMPLES)
        .map(|number| {
            let t = time(number, SAMPLES);
            let affine = model.affine((slip(t)).into(), 0.0);
            let deflections = history.weighted(0.0, t, &rest) / pressure.total();
            affine.stiffness * deflections + affine.damping * slip(t)
        })
        .collect()
}

fn reference_error(reference: &[f64], forces: &[f64]) -> f64 {
    if reference.len() != forces.len() {
        return f64::NAN;
    }
    let apart = reference.iter().zip(forces).map(|(a, b)| (a - b).abs());
    // `f64::max` would pass over NaN.
    apart.fold(0.0, |most, apart| if apart <= most { most } else { apart })
}

/// Prints how long each solver takes for some errors: the first setting that reaches them.
pub(crate) fn summary(rows: &[Row]) {
    for target in [1e-4, 1e-6, 1e-8, 1e-10] {
        println!("CPU time / ms for an error of {target:e}, and over that of the exact reduction");
        for model in ["frbd", "lugre"] {
            for pressure in ["constant", "exponential", "parabolic"] {
                let of = |solver: &str| {
                    let own = rows.iter().filter(|row| {
                        row.model == model && row.pressure == pressure && row.solver == solver
                    });
                    let reached = own.clone().filter(|row| row.error <= target);
                    let best = reached.map(|row| row.seconds).fold(f64::INFINITY, f64::min);
                    let least = own.clone().map(|row| row.error).fold(f64::INFINITY, f64::min);
                    let longest = own.map(|row| row.seconds).fold(0.0, f64::max);
                    (best, least, longest)
                };
                let exact = of(SOLVERS[0]).0;
                println!("  {model}, {pressure}");
                for solver in SOLVERS {
                    let (seconds, least, longest) = of(solver);
                    if seconds.is_finite() {
                        let ratio = seconds / exact;
                        println!("    {solver:28} {:10.4} {ratio:10.1}", seconds * 1e3);
                    } else {
                        let longest = longest * 1e3;
                        println!("    {solver:28} not reached: {least:.1e} after {longest:.0} ms");
                    }
                }
            }
        }
    }
}

pub(crate) fn write(folder: &Path, rows: &[Row]) -> Result<PathBuf, Box<dyn Error>> {
    let columns = ["model", "pressure", "solver", "setting", "error", "cpu_s"];
    let mut table = Csv::create(folder, "rolling_contact", &columns)?;
    for row in rows {
        let numbers = [row.setting as f64, row.error, row.seconds];
        table.row(&[row.model, row.pressure, row.solver], &numbers)?;
    }
    table.finish()
}
