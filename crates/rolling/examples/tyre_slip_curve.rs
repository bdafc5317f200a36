//! The tyre of section IV-A (Table 1) in steady rolling at 16 m/s: friction force over the slip
//! ratio for three pressures, and the pneumatic trail.
//!
//! Leaves `tyre_slip_curve.csv` and `tyre_slip_curve.svg`.

use std::error::Error;
use std::process::ExitCode;

use bristle::curve::Stribeck;
use bristle::rheology::KelvinVoigt;
use bristle::{FrBd, ParameterError, paper};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, Stroke, println};
use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential, Pressure};

/// Carries the tyre \[N\]; force ratios do not depend on it.
const NORMAL_FORCE: f64 = 4000.0;

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("tyre_slip_curve", "Force over slip of a rolling tyre")
            .number("rolling-speed", 16.0, "m/s", "rolling speed U")
            .must_be(Rule::Between(1e-3, 1e3))
            .count("samples", 401, "rows per pressure, denser at small slip")
            .must_be(Rule::Between(2.0, 1e6))
            .parse()?;
        let rolling_speed = arguments.number("rolling-speed");
        let samples = arguments.count("samples");

        println!("Table 1 at U = {rolling_speed} m/s, F_z = {NORMAL_FORCE} N");
        println!();
        println!("pressure     slip stiffness  peak F/F_z  at slip  F/F_z at 0.05  at 1.00");
        let mut table = Csv::create(
            arguments.out_dir(),
            "tyre_slip_curve",
            &["pressure", "slip", "force_ratio"],
        )?;
        let slip = "slip ratio v/U (–)";
        let mut forces = Panel::new(slip, "force ratio F/F_z (–)").title("force");
        let mut trails = Panel::new(slip, "pneumatic trail (mm)").title("trail of a lateral force");
        let scene = Scene { rolling_speed, samples };
        let constant = PolynomialExponential::constant();
        let exponential = PolynomialExponential::exponential(bristle_rolling::TYRE_PRESSURE_DECAY)?;
        let parabolic = PolynomialExponential::parabolic();
        for (name, stroke, rows) in [
            ("constant", Stroke::from(Colour::Blue), scene.run("constant", constant)?),
            ("exponential", Colour::Orange.dashed(), scene.run("exponential", exponential)?),
            ("parabolic", Colour::Green.dotted(), scene.run("parabolic", parabolic)?),
        ] {
            for [slip, ratio, _] in &rows {
                table.row(&[name], &[*slip, *ratio])?;
            }
            let points = |column: usize, scale: f64| -> Vec<_> {
                rows.iter().map(|row| (row[0], scale * row[column])).collect()
            };
            forces = forces.line(format!("{name} pressure"), stroke, points(1, 1.0));
            trails = trails.line(format!("{name} pressure"), stroke, points(2, 1e3));
        }
        table.finish()?;
        println!();
        let figure = Figure::new(900, 430)
            .title(
                "Friction force and pneumatic trail of a tyre over the slip ratio, three pressures",
            )
            .columns(2)
            .panel(forces)
            .panel(trails);
        println!("{}", figure.save(arguments.out_dir(), "tyre_slip_curve")?.display());
        Ok(())
    })
}

struct Scene {
    rolling_speed: f64,
    samples: usize,
}

impl Scene {
    /// Slip ratio from 0 to 1, force ratio and pneumatic trail, closer to each other where the
    /// force rises; and a line of the printed table.
    fn run<P: Pressure<f64>>(
        &self,
        name: &str,
        pressure: P,
    ) -> Result<Vec<[f64; 3]>, Box<dyn Error>> {
        let curve = Stribeck::new(paper::TYRE_CURVE)?;
        let tyre = Patch::new(PatchParameters {
            model: FrBd::new(curve, KelvinVoigt::new(paper::TYRE_BRISTLE)?),
            length: bristle_rolling::TYRE_LENGTH,
            pressure,
        })?
        .under_load(NORMAL_FORCE)?;
        let rolling_speed = self.rolling_speed;
        let at = |slip_ratio| Motion { slip_velocity: slip_ratio * rolling_speed, rolling_speed };
        let ratio = |motion| Ok::<_, ParameterError>(tyre.steady(motion)?.force / NORMAL_FORCE);
        let stiffness = tyre.slip_stiffness(rolling_speed)? / 1e3;
        let (small, full) = (ratio(at(0.05))?, ratio(at(1.0))?);
        let peak = match tyre.peak(at(1.0))? {
            Some(peak) => format!("{:10.4}  {:7.4}", ratio(peak)?, peak.slip_ratio()),
            None => format!("{:>10}  {:>7}", "–", "–"),
        };
        println!("{name:11}  {stiffness:11.2} kN  {peak}  {small:13.6}  {full:8.6}");
        (0..self.samples)
            .map(|sample| {
                let slip = (sample as f64 / (self.samples - 1) as f64).powi(2);
                let trail = tyre.pneumatic_trail(at(slip))?;
                Ok([slip, ratio(at(slip))?, trail.unwrap_or(f64::NAN)])
            })
            .collect()
    }
}
