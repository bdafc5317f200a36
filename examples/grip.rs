//! A part in a gripper: it stands still while the grip varies, if the stiffness of the bristles
//! does not follow the load; and while its weight shakes, if the bristles are elastic up to a
//! limit.
//!
//! Leaves `grip.csv` and `grip.svg`: how far the part has slipped over time. On the left the grip
//! varies, on the right the weight.

use std::error::Error;
use std::f64::consts::TAU;
use std::process::ExitCode;

use bristle::companion::{PointMass, VelocityHistory};
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, Contact, ElastoPlastic, FrBd};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, Stroke, println};

/// μ_s = 0.8, μ_d = 0.6.
const CURVE: StribeckParameters<f64> = StribeckParameters {
    static_coefficient: 0.8,
    dynamic_coefficient: 0.6,
    stribeck_velocity: 0.01,
    stribeck_exponent: 2.0,
    viscous_friction: 0.0,
};
const BRISTLE: KelvinVoigtParameters<f64> =
    KelvinVoigtParameters { micro_stiffness: 5e3, micro_damping: 10.0 };
/// Up to this deflection the elasto-plastic bristle is elastic [m].
const STICK_LIMIT: f64 = 1e-4;
/// The part [kg] and its weight [N].
const MASS: f64 = 0.3;
const WEIGHT: f64 = 2.943;
/// Length of a step [s].
const STEP: f64 = 1e-4;

/// What varies, and by which share of itself.
#[derive(Clone, Copy)]
struct Scene {
    grip: f64,
    frequency: f64,
    share_of_grip: f64,
    share_of_weight: f64,
    /// Whether the stiffness follows the load.
    renews: bool,
}

/// A row of the table and a line of the chart.
struct Run {
    name: &'static str,
    label: &'static str,
    stroke: Stroke,
    /// Time [s] and position [m].
    path: Vec<(f64, f64)>,
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("grip", "A part in a gripper that varies")
            .number("end", 5.0, "s", "end of the simulated time")
            .must_be(Rule::Between(0.1, 3600.0))
            .number("grip", 16.0, "N", "mean normal force")
            .must_be(Rule::Between(4.0, 1e3))
            .number("share", 0.5, "", "amplitude over the mean: of the grip, or of the weight")
            .must_be(Rule::Between(0.0, 0.95))
            .number("frequency", 50.0, "Hz", "of both")
            .must_be(Rule::Positive)
            .parse()?;
        let [end, grip, share, frequency] =
            ["end", "grip", "share", "frequency"].map(|name| arguments.number(name));
        let still =
            Scene { grip, frequency, share_of_grip: 0.0, share_of_weight: 0.0, renews: false };
        let load = Scene { share_of_grip: share, ..still };
        let renewal = Scene { renews: true, ..load };
        let weight = Scene { share_of_weight: share, ..still };

        let (curve, bristle) = (Stribeck::new(CURVE)?, KelvinVoigt::new(BRISTLE)?);
        let frbd = FrBd::new(curve, bristle).under_load(grip)?;
        let elastic = ElastoPlastic::new(curve, bristle, STICK_LIMIT)?.under_load(grip)?;
        let line = |name, label, stroke, path| Run { name, label, stroke, path };
        let (blue, orange) = (Stroke::from(Colour::Blue), Colour::Orange.dashed());
        let (green, red) = (Stroke::from(Colour::Green), Colour::Vermilion.dashed());
        let by_load = [
            line("renewal", "stiffness follows the load", orange, renewal.run(frbd, end)?),
            line("reload", "stiffness of a reference load", blue, load.run(frbd, end)?),
        ];
        let by_weight = [
            line("frbd", "FrBD", red, weight.run(frbd, end)?),
            line("elasto_plastic", "elasto-plastic", green, weight.run(elastic, end)?),
        ];

        let margin = |load: f64, weight: f64| CURVE.static_coefficient * load / weight;
        let used = (1.0 - share, 1.0 + share);
        println!("{WEIGHT} N held by {grip} N, ±{share} at {frequency} Hz, steps of {STEP} s");
        println!(
            "The least of what the grip can hold is {:.2} times the weight if the grip varies,",
            margin(used.0 * grip, WEIGHT)
        );
        println!("and {:.2} times if the weight does.\n", margin(grip, used.1 * WEIGHT));
        println!("                                   slipped after {end} s   a second");
        let mut table = Csv::create(arguments.out_dir(), "grip", &["run", "t", "x"])?;
        for run in by_load.iter().chain(&by_weight) {
            let last = run.path.last().map_or(0.0, |place| place.1);
            println!("{:32}  {:13.3e} m  {:9.3e} m", run.label, last, last / end);
            for &(time, place) in &run.path {
                table.row(&[run.name], &[time, place])?;
            }
        }
        table.finish()?;
        println!();
        println!("{}", chart(&by_load, &by_weight).save(arguments.out_dir(), "grip")?.display());
        Ok(())
    })
}

impl Scene {
    /// Passive steps of the part: its position over time.
    fn run<M: Bristle<f64, Deflection = f64>>(
        self,
        contact: Contact<f64, M>,
        end: f64,
    ) -> Result<Vec<(f64, f64)>, Box<dyn Error>> {
        let mut companion = contact.companion(1.0)?;
        // It hangs on its bristles already.
        let mut z = WEIGHT / (BRISTLE.micro_stiffness * self.grip);
        let (mut velocity, mut position) = (0.0, 0.0);
        let mut history = VelocityHistory::new(0.0);
        let mut path = vec![(0.0, 0.0)];
        let steps = (end / STEP).round() as usize;
        for step in 0..steps {
            let phase = (TAU * self.frequency * (step as f64 + 0.5) * STEP).sin();
            let (load, force) = (
                self.grip * (1.0 + self.share_of_grip * phase),
                WEIGHT * (1.0 + self.share_of_weight * phase),
            );
            let predicted = history.predict();
            z = if self.renews {
                companion.renew(load, z)?.deflection
            } else {
                companion.reload(load, predicted, z)?.deflection
            };
            let friction = companion.step(predicted, z, STEP);
            let mean =
                friction.point_mass(PointMass { mass: MASS, velocity, force, end_weight: 0.5 });
            velocity = 2.0 * mean - velocity;
            history.push(velocity);
            z = friction.commit(mean).deflection;
            position += STEP * mean;
            if (step + 1) % (steps / 500).max(1) == 0 {
                path.push(((step + 1) as f64 * STEP, position));
            }
        }
        Ok(path)
    }
}

fn chart(by_load: &[Run], by_weight: &[Run]) -> Figure {
    let panel = |title: &str, runs: &[Run]| {
        let panel = Panel::new("time t (s)", "slipped x (mm)").title(title.to_owned());
        runs.iter().fold(panel, |panel, run| {
            let path: Vec<(f64, f64)> = run.path.iter().map(|&(t, x)| (t, 1e3 * x)).collect();
            panel.line(run.label, run.stroke, path)
        })
    };
    Figure::new(900, 380)
        .title("A part in a gripper: how far it has slipped")
        .columns(2)
        .panel(panel("the grip varies", by_load))
        .panel(panel("the weight varies", by_weight))
}
