//! The error of fixed steps across the kink of |v|, with and without a split at each reversal.
//!
//! A Dahl bristle follows a sinusoidal motion, for which the deflection is known in closed form:
//! between two reversals z = ±z_m + (z_r ∓ z_m) exp(−|x − x_r|/z_m), with z_m = μ_d/σ0 and the
//! state (x_r, z_r) at the last reversal.
//!
//! Leaves `reversal_order.csv` and `reversal_order.svg`, error over step length.

use std::error::Error;
use std::f64::consts::TAU;
use std::process::ExitCode;

use bristle::ode::{DormandPrince, Method, Output, RungeKutta4, Solver};
use bristle::scene::PrescribedVelocity;
use bristle::signal::{Sine, SineParameters};
use bristle::{Bristle, Dahl, DahlParameters};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, Stroke, print, println};
use nalgebra::Vector1;

const FRICTION: DahlParameters<f64> =
    DahlParameters { dynamic_coefficient: 1.0, micro_stiffness: 1e4 };
/// Amplitude of the motion [m]: two and a half times z_m.
const AMPLITUDE: f64 = 2.5e-4;
const FREQUENCY: f64 = 1.0;
const PERIODS: f64 = 3.0;

type Scene = PrescribedVelocity<f64, Dahl<f64>, Sine<f64>>;

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments =
            Arguments::new("reversal_order", "The error of fixed steps across reversals")
                .count("samples", 2001, "output samples over which the error is taken")
                .must_be(Rule::Between(2.0, 1e7))
                .parse()?;
        let samples = arguments.count("samples");

        let velocity = SineParameters {
            mean: 0.0,
            amplitude: AMPLITUDE * TAU * FREQUENCY,
            frequency: FREQUENCY,
            phase: TAU / 4.0,
        };
        let scene =
            PrescribedVelocity::new(Dahl::new(FRICTION)?.under_load(1.0)?, Sine::new(velocity)?);
        let rows = [
            sweep("rk4_plain", RungeKutta4, true, &scene, samples)?,
            sweep("rk4_split", RungeKutta4, false, &scene, samples)?,
            sweep("dp5_plain", DormandPrince, true, &scene, samples)?,
            sweep("dp5_split", DormandPrince, false, &scene, samples)?,
        ];

        let mut table =
            Csv::create(arguments.out_dir(), "reversal_order", &["method", "step", "error"])?;
        println!("Dahl bristle under a sinusoidal motion, error of z over z_m, {samples} samples");
        println!();
        print!("step / ms ");
        for (step, _) in &rows[0].errors {
            print!("{:>9.2}", step * 1e3);
        }
        println!("   order");
        for row in &rows {
            print!("{:10}", row.name);
            for &(step, error) in &row.errors {
                print!("  {error:7.1e}");
                table.row(&[row.name], &[step, error])?;
            }
            println!("   {:5.2}", row.order());
        }
        table.finish()?;

        let strokes: [(&str, Stroke); 4] = [
            ("RK4, plain", Colour::Orange.dashed()),
            ("RK4, split at reversals", Colour::Orange.into()),
            ("DP5, plain", Colour::Blue.dashed()),
            ("DP5, split at reversals", Colour::Blue.into()),
        ];
        let panel = Panel::new("step h (s)", "max error of z over z_m (–)").log_x().log_y();
        let panel = rows
            .iter()
            .zip(strokes)
            .fold(panel, |panel, (row, (label, stroke))| panel.line(label, stroke, &row.errors));
        // From above the last error of a method, over three halvings.
        let slopes = [(0, 2, Colour::Black.width(0.8)), (1, 4, Colour::Black.dashed().width(0.8))];
        let slopes = slopes.into_iter().chain([(3, 5, Colour::Black.dotted().width(0.8))]);
        let panel = slopes.fold(panel, |panel, (row, order, stroke)| {
            let (step, error) = rows[row].errors[0];
            let line = [1.0, 0.125].map(|x: f64| (x * step, 3.0 * error * x.powi(order)));
            panel.line(format!("slope {order}"), stroke, line)
        });
        let figure = Figure::new(720, 460)
            .title("Error over step length: plain steps, and steps split at reversals")
            .panel(panel);
        println!();
        println!("{}", figure.save(arguments.out_dir(), "reversal_order")?.display());
        Ok(())
    })
}

/// The errors of one method over the step.
struct Sweep {
    name: &'static str,
    errors: Vec<(f64, f64)>,
}

impl Sweep {
    /// Least-squares slope of log error over log step, where rounding does not yet count.
    fn order(&self) -> f64 {
        let points: Vec<_> = self
            .errors
            .iter()
            .filter(|(_, error)| *error > 1e-12)
            .map(|(step, error)| (step.ln(), error.ln()))
            .collect();
        let n = points.len() as f64;
        let (sx, sy) = points.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0, sum.1 + p.1));
        let sxy: f64 = points.iter().map(|p| (p.0 - sx / n) * (p.1 - sy / n)).sum();
        let sxx: f64 = points.iter().map(|p| (p.0 - sx / n).powi(2)).sum();
        sxy / sxx
    }
}

fn sweep<M: Method<f64, 1>>(
    name: &'static str,
    method: M,
    plain: bool,
    scene: &Scene,
    samples: usize,
) -> Result<Sweep, Box<dyn Error>> {
    let limit = FRICTION.dynamic_coefficient / FRICTION.micro_stiffness;
    let mut errors = Vec::new();
    for halving in 0..7 {
        // No whole number of steps a period, so that no grid point meets a reversal.
        let step = 1.0 / (FREQUENCY * 51.3) * 0.5f64.powi(halving);
        let solver = Solver::fixed(method, step)?;
        let solver = if plain { solver.plain() } else { solver };
        let span = 0.0..PERIODS / FREQUENCY;
        let output = Output::Uniform(samples);
        let trajectory = solver.solve(scene, span, Vector1::new(0.0), output)?;
        let error = trajectory
            .iter()
            .map(|(time, state)| (state.x - deflection(time)).abs() / limit)
            .fold(0.0, f64::max);
        errors.push((step, error));
    }
    Ok(Sweep { name, errors })
}

/// The deflection at a time, in closed form from reversal to reversal; x = X sin(2πft).
fn deflection(time: f64) -> f64 {
    let limit = FRICTION.dynamic_coefficient / FRICTION.micro_stiffness;
    let along = |z: f64, from: f64, to: f64| {
        let end = limit * (to - from).signum();
        end + (z - end) * (-(to - from).abs() / limit).exp()
    };
    let reversals = (time * FREQUENCY * 2.0 + 0.5).floor() as u32;
    let (mut x, mut z) = (0.0, 0.0);
    for reversal in 0..reversals {
        let next = if reversal % 2 == 0 { AMPLITUDE } else { -AMPLITUDE };
        z = along(z, x, next);
        x = next;
    }
    along(z, x, AMPLITUDE * (TAU * FREQUENCY * time).sin())
}
