//! How much model a sinusoidal velocity needs (Table 2): over amplitude and frequency, the cheapest rung whose friction
//! force stays within a tolerance of the FrBD model's, root mean square over ten periods of a hundred answers. Left the
//! velocity reverses, right it only comes close to rest.
//!
//! Leaves `fidelity_atlas.csv` and `fidelity_atlas.svg`, a map of the rungs.

#[macro_use]
mod support;

use std::process::ExitCode;

use bristle::curve::Stribeck;
use bristle::fidelity::{
    FidelityError, History, HistoryParameters, Integrator, Norm, Rung, Start, Tolerance,
};
use bristle::rheology::KelvinVoigt;
use bristle::signal::{Sine, SineParameters};
use bristle::{Bristle, FrBd, paper};
use support::{Arguments, Colour, Csv, Figure, Marker, Panel, Rule};

/// Answers in a period.
const PERIOD: usize = 100;

/// What the atlas tells apart, with its mark.
const KINDS: [(&str, Colour, Marker); 6] = [
    ("static curve", Colour::Grey, Marker::Square),
    ("Dahl, a step an answer", Colour::Sky, Marker::Square),
    ("Dahl, shorter steps", Colour::Blue, Marker::Disc),
    ("FrBD, a held step an answer", Colour::Orange, Marker::Square),
    ("FrBD, shorter steps or collocation", Colour::Vermilion, Marker::Disc),
    ("undecided", Colour::Black, Marker::Triangle),
];

fn main() -> ExitCode {
    support::run(|| {
        let arguments = Arguments::new("fidelity_atlas", "How much model a velocity needs")
            .number("tolerance", 0.02, "", "error allowed, of the largest steady force")
            .must_be(Rule::Between(1e-6, 1.0))
            .count("amplitudes", 43, "amplitudes from 1 µm/s to 10 m/s")
            .must_be(Rule::Between(2.0, 1000.0))
            .count("frequencies", 31, "frequencies from 0.01 Hz to 1 kHz")
            .must_be(Rule::Between(2.0, 1000.0))
            .parse()?;
        let share = arguments.number("tolerance");
        let amplitudes = spread(1e-6, 10.0, arguments.count("amplitudes"));
        let frequencies = spread(0.01, 1000.0, arguments.count("frequencies"));

        let friction = FrBd::new(
            Stribeck::new(paper::STICK_SLIP_CURVE)?,
            KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?,
        );
        let columns =
            ["amplitude", "frequency", "mean", "rung", "integrator", "step", "error_bound", "cost"];
        let mut table = Csv::create(arguments.out_dir(), "fidelity_atlas", &columns)?;
        let mut figure = Figure::new(1000, 470).columns(2);
        for (title, mean) in [("v = A sin 2πft", 0.0), ("v = 1.2 A + A sin 2πft", 1.2)] {
            let mut marks: [Vec<(f64, f64)>; 6] = Default::default();
            for &amplitude in &amplitudes {
                for &frequency in &frequencies {
                    // No answer falls on a reversal, where the static curve has two.
                    let (mean, phase) = (mean * amplitude, 0.03);
                    let velocity = SineParameters { mean, amplitude, frequency, phase };
                    let scene = History::new(HistoryParameters {
                        contact: friction.under_load(1.0)?,
                        velocity: Sine::new(velocity)?,
                        interval: 1.0 / (frequency * PERIOD as f64),
                        answers: 10 * PERIOD,
                        period: Some(PERIOD),
                        start: Start::Steady,
                    })?;
                    let tolerance = Tolerance { norm: Norm::RootMeanSquare, share };
                    let kind = match scene.choose(tolerance) {
                        Ok(choice) => {
                            let plan = choice.plan;
                            let texts = [
                                amplitude.to_string(),
                                frequency.to_string(),
                                mean.to_string(),
                                plan.rung.to_string(),
                                plan.integrator.to_string(),
                            ];
                            let numbers = [plan.step, choice.error, plan.cost_rate];
                            table.row(&texts.each_ref().map(String::as_str), &numbers)?;
                            match (plan.rung, plan.integrator, plan.substeps) {
                                (Rung::StaticCurve, ..) => 0,
                                (Rung::Dahl, _, 1) => 1,
                                (Rung::Dahl, ..) => 2,
                                (_, Integrator::Hold, 1) => 3,
                                _ => 4,
                            }
                        }
                        Err(FidelityError::PilotTooShort { .. }) => 5,
                        Err(error) => return Err(error.into()),
                    };
                    marks[kind].push((amplitude, frequency));
                }
            }
            println!("{title}, within {} %", 100.0 * share);
            let all = (amplitudes.len() * frequencies.len()) as f64;
            let axes = ("amplitude A / (m/s)", "frequency f / Hz");
            let mut panel = Panel::new(axes.0, axes.1).title(title).log_x().log_y();
            for ((name, colour, marker), points) in KINDS.into_iter().zip(&marks) {
                if !points.is_empty() {
                    println!("  {name:36} {:5.1} %", 100.0 * points.len() as f64 / all);
                    panel = panel.points(name, colour.marked(marker).size(5.0), points);
                }
            }
            figure = figure.panel(panel);
        }
        table.finish()?;

        // The lag of section V-A, in full.
        let lag = SineParameters { mean: 0.0055, amplitude: 0.005, frequency: 25.0, phase: 0.0 };
        let scene = History::new(HistoryParameters {
            contact: friction.under_load(1.0)?,
            velocity: Sine::new(lag)?,
            interval: 4e-4,
            answers: 10 * PERIOD,
            period: Some(PERIOD),
            start: Start::Steady,
        })?;
        println!("\nv = 0.0055 + 0.005 sin(2π 25 t) m/s");
        println!("{}", scene.choose(Tolerance { norm: Norm::RootMeanSquare, share })?);
        println!("\n{}", figure.save(arguments.out_dir(), "fidelity_atlas")?.display());
        Ok(())
    })
}

/// Values evenly spread over the decades between two ends.
fn spread(from: f64, to: f64, count: usize) -> Vec<f64> {
    let step = (to / from).ln() / (count - 1) as f64;
    (0..count).map(|index| from * (step * index as f64).exp()).collect()
}
