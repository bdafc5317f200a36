//! Frictional lag (section V-A, Table 2): at a velocity that oscillates without reversing, friction
//! lags behind its steady curve and traces a loop around it.
//!
//! Leaves `frictional_lag.csv` and `frictional_lag.svg`, friction force over velocity.

use std::error::Error;
use std::process::ExitCode;

use bristle::curve::{FrictionCurve, Stribeck};
use bristle::ode::{DormandPrince, Output, Solver, Tolerances};
use bristle::rheology::KelvinVoigt;
use bristle::scene::PrescribedVelocity;
use bristle::signal::{Sine, SineParameters};
use bristle::{Bristle, FrBd, LuGre, paper};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, Stroke, println};

const FREQUENCIES: [f64; 3] = [25.0, 50.0, 100.0];
const PERIODS: usize = 10;
/// Until then [s] the loops settle: a disturbance fades with about 32 1/s. Whole periods of every
/// frequency.
const SETTLED: f64 = 1.0;
const MEAN: f64 = 0.0055;
const AMPLITUDE: f64 = 0.005;

/// Time, velocity, deflection, force.
type Row = [f64; 4];

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("frictional_lag", "Friction lags behind its steady curve")
            .count("samples", 5001, "rows per model and frequency, evenly spaced")
            .must_be(Rule::Between(PERIODS as f64 + 1.0, 1e7))
            .number(
                "rtol",
                1e-9,
                "",
                "tolerance of the integration, relative to each state's scale",
            )
            .must_be(Rule::Positive)
            .parse()?;
        let samples = arguments.count("samples");
        let rtol = arguments.number("rtol");

        let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
        let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
        let columns = ["model", "frequency", "t", "v", "z", "force"];
        let mut table = Csv::create(arguments.out_dir(), "frictional_lag", &columns)?;
        println!("v = {MEAN} + {AMPLITUDE} sin(2πft) m/s, settled, Table 2, rtol {rtol:e}");
        println!();
        println!("model  frequency  least force  greatest force  width at {MEAN} m/s  loop");
        let steady: Vec<_> = (0..=200)
            .map(|i| MEAN + AMPLITUDE * (f64::from(i) / 100.0 - 1.0))
            .map(|v| (v * 1e3, curve.coefficient(v.into())))
            .collect();
        let mut figure = Figure::new(900, 430)
            .title("Frictional lag: friction force over velocity, around the steady curve")
            .columns(2);
        for (name, label) in [("frbd", "FrBD"), ("lugre", "LuGre")] {
            let axes = ("sliding velocity v (mm/s)", "friction force F (N)");
            let mut panel = Panel::new(axes.0, axes.1).title(label).line(
                "steady sliding",
                Colour::Black.width(1.0),
                &steady,
            );
            for (index, frequency) in FREQUENCIES.into_iter().enumerate() {
                let rows = match name {
                    "frbd" => run(FrBd::new(curve, bristle), frequency, samples, rtol)?,
                    _ => run(LuGre::classical(curve, bristle), frequency, samples, rtol)?,
                };
                for &[t, v, z, force] in &rows {
                    table.row(&[name], &[frequency, t, v, z, force])?;
                }
                let last = &rows[rows.len() - 1 - (rows.len() - 1) / PERIODS..];
                report(label, frequency, last);
                let loops: Vec<_> = last.iter().map(|row| (row[1] * 1e3, row[3])).collect();
                panel = panel.line(format!("{frequency} Hz"), stroke(index), &loops);
            }
            figure = figure.panel(panel);
        }
        table.finish()?;
        println!();
        println!("{}", figure.save(arguments.out_dir(), "frictional_lag")?.display());
        Ok(())
    })
}

fn stroke(index: usize) -> Stroke {
    [Colour::Blue.into(), Colour::Orange.dashed(), Colour::Green.dotted()][index]
}

/// Drags the bristle with one friction model at one frequency.
fn run<M: Bristle<f64, Deflection = f64>>(
    model: M,
    frequency: f64,
    samples: usize,
    rtol: f64,
) -> Result<Vec<Row>, Box<dyn Error>> {
    let velocity = SineParameters { mean: MEAN, amplitude: AMPLITUDE, frequency, phase: 0.0 };
    let scene = PrescribedVelocity::new(model.under_load(1.0)?, Sine::new(velocity)?);
    let solver = Solver::checked(DormandPrince, Tolerances::scaled(rtol, scene.scales())?);
    let before = solver.solve(&scene, 0.0..SETTLED, scene.stationary(0.0), Output::Uniform(2))?;
    let span = SETTLED..SETTLED + PERIODS as f64 / frequency;
    let trajectory = solver.solve(&scene, span, before.states()[1], Output::Uniform(samples))?;
    let row = |(t, state): (f64, &nalgebra::Vector1<f64>)| {
        [t, scene.velocity(t), state.x, scene.friction_force(t, state)]
    };
    Ok(trajectory.iter().map(row).collect())
}

/// What the last period did: how high, how wide, which way round.
fn report(label: &str, frequency: f64, last: &[Row]) {
    let least = last.iter().map(|row| row[3]).fold(f64::INFINITY, f64::min);
    let most = last.iter().map(|row| row[3]).fold(f64::NEG_INFINITY, f64::max);
    // ∮ F dv > 0: more force while the velocity rises than while it falls.
    let area: f64 = last.windows(2).map(|w| 0.5 * (w[0][3] + w[1][3]) * (w[1][1] - w[0][1])).sum();
    let direction = if area > 0.0 { "normal (clockwise)" } else { "reversed (counter-clockwise)" };
    // Once while the velocity rises, once while it falls.
    let crossings = last.windows(2).filter(|w| (w[0][1] - MEAN) * (w[1][1] - MEAN) <= 0.0);
    let forces =
        crossings.map(|w| w[0][3] + (w[1][3] - w[0][3]) * (MEAN - w[0][1]) / (w[1][1] - w[0][1]));
    let (low, high) = forces.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), force| {
        (low.min(force), high.max(force))
    });
    let width = 1e3 * (high - low);
    println!(
        "{label:5}  {frequency:6} Hz  {least:9.4} N  {most:12.4} N  {width:16.1} mN  {direction}"
    );
}
