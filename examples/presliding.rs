//! Pre-sliding (section V-A, Table 2): a unit mass under a sinusoidal force of 90 % of the
//! breakaway force moves on its bristles, along a hysteresis loop. At 5 and 10 Hz the mass swings
//! on them far enough to slide for a part of each period.
//!
//! Leaves `presliding.csv` and `presliding.svg`, friction force over position.

use std::error::Error;
use std::process::ExitCode;

use bristle::curve::Stribeck;
use bristle::ode::{DormandPrince, Output, Solver, Tolerances};
use bristle::rheology::KelvinVoigt;
use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
use bristle::signal::{Sine, SineParameters};
use bristle::{Bristle, FrBd, LuGre, Mechanism, paper};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, println};

const FREQUENCIES: [f64; 3] = [1.0, 5.0, 10.0];
const PERIODS: f64 = 3.0;
const NORMAL_FORCE: f64 = 1.0;

/// Time, position, velocity, deflection, force.
type Row = [f64; 5];

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("presliding", "Hysteresis below breakaway")
            .count("samples", 3001, "rows per model and frequency, evenly spaced")
            .must_be(Rule::Between(2.0, 1e7))
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
        let columns = ["model", "frequency", "t", "x", "v", "z", "force"];
        let mut table = Csv::create(arguments.out_dir(), "presliding", &columns)?;
        println!("unit mass, 0.9 μ_s p sin(2πft), three periods, Table 2, rtol {rtol:e}");
        println!();
        println!(
            "model  frequency  travel in the last period  drift per period  lost energy per period"
        );
        let mut loops = Vec::new();
        for (name, label) in [("frbd", "FrBD"), ("lugre", "LuGre")] {
            for (index, frequency) in FREQUENCIES.into_iter().enumerate() {
                let rows = match name {
                    "frbd" => run(FrBd::new(curve, bristle), frequency, samples, rtol)?,
                    _ => run(LuGre::classical(curve, bristle), frequency, samples, rtol)?,
                };
                report(label, frequency, &rows);
                for row in &rows {
                    let [t, x, v, z, force] = *row;
                    table.row(&[name], &[frequency, t, x, v, z, force])?;
                }
                let points = rows.iter().map(|row| (row[1] * 1e6, row[4])).collect();
                loops.push((label, index, points));
            }
        }
        table.finish()?;
        println!();
        println!("{}", chart(&loops).save(arguments.out_dir(), "presliding")?.display());
        Ok(())
    })
}

/// Force [N] over position [µm] of a model at one of the frequencies.
type Loop = (&'static str, usize, Vec<(f64, f64)>);

fn chart(loops: &[Loop]) -> Figure {
    let strokes = [Colour::Blue.into(), Colour::Orange.dashed(), Colour::Green.dotted()];
    // Both panels have the axes that show all loops.
    let positions = || loops.iter().flat_map(|(_, _, points)| points.iter().map(|point| point.0));
    let least = positions().fold(0.0, f64::min);
    let most = positions().fold(0.0, f64::max);
    let figure = Figure::new(900, 430).columns(2);
    let figure = figure.title("Hysteresis below breakaway: friction force over position");
    ["FrBD", "LuGre"].into_iter().fold(figure, |figure, label| {
        let panel = Panel::new("position x (µm)", "friction force F (N)")
            .title(label)
            .x_range(1.05 * least..=1.05 * most)
            .y_range(-1.6..=1.6);
        let own = loops.iter().filter(|(model, ..)| *model == label);
        figure.panel(own.fold(panel, |panel, (_, index, points)| {
            panel.line(format!("{} Hz", FREQUENCIES[*index]), strokes[*index], points)
        }))
    })
}

/// Simulates the mass with one friction model at one frequency.
fn run<M: Bristle<f64, Deflection = f64>>(
    model: M,
    frequency: f64,
    samples: usize,
    rtol: f64,
) -> Result<Vec<Row>, Box<dyn Error>> {
    let breakaway = paper::STICK_SLIP_CURVE.static_coefficient * NORMAL_FORCE;
    let force = SineParameters { mean: 0.0, amplitude: 0.9 * breakaway, frequency, phase: 0.0 };
    let scene = MassSpringDamper::new(MassSpringDamperParameters {
        contact: model.under_load(NORMAL_FORCE)?,
        mechanism: Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 },
        drive_velocity: 0.0,
        force: Sine::new(force)?,
    })?;
    let solver = Solver::checked(DormandPrince, Tolerances::scaled(rtol, scene.scales())?);
    let span = 0.0..PERIODS / frequency;
    let trajectory = solver.solve(&scene, span, scene.at_rest(), Output::Uniform(samples))?;
    let row = |(t, state): (f64, &nalgebra::Vector3<f64>)| {
        [t, state[0], state[1], state[2], scene.friction_force(state)]
    };
    Ok(trajectory.iter().map(row).collect())
}

/// What the last period did.
fn report(label: &str, frequency: f64, rows: &[Row]) {
    let first = rows.len() - 1 - (rows.len() - 1) / PERIODS as usize;
    let last = &rows[first..];
    let least = last.iter().map(|row| row[1]).fold(f64::INFINITY, f64::min);
    let most = last.iter().map(|row| row[1]).fold(f64::NEG_INFINITY, f64::max);
    let drift = last[last.len() - 1][1] - last[0][1];
    // ∮ F dx by the trapezoidal rule.
    let lost: f64 = last.windows(2).map(|w| 0.5 * (w[0][4] + w[1][4]) * (w[1][1] - w[0][1])).sum();
    println!(
        "{label:5}  {frequency:6} Hz  {:22.3} µm  {:13.3} µm  {:19.3} µJ",
        (most - least) * 1e6,
        drift * 1e6,
        lost * 1e6,
    );
}
