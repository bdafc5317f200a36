//! How much model a sinusoidal velocity needs (Table 2): over amplitude and frequency, the cheapest
//! model whose friction force stays within a tolerance of FrBD's, root mean square over ten periods
//! of a hundred answers. Left the velocity reverses, right it only comes close to rest.
//!
//! Leaves `fidelity_atlas.csv` and `fidelity_atlas.svg`, a map of the models.

use std::process::ExitCode;

use bristle::curve::Stribeck;
use bristle::rheology::KelvinVoigt;
use bristle::signal::{Sine, SineParameters};
use bristle::{Bristle, FrBd, paper};
use bristle_charts::{Arguments, Colour, Csv, Figure, Marker, Panel, Progress, Rule, println};
use bristle_fidelity::{Answers, Choice, FidelityError, KnownVelocity, Level, Tolerance, choose};

/// Answers in a period.
const PERIOD: usize = 100;

/// What the atlas tells apart, with its mark.
const KINDS: [(&str, Colour, Marker); 5] = [
    ("static curve", Colour::Grey, Marker::Square),
    ("Dahl, one step per answer", Colour::Sky, Marker::Square),
    ("Dahl, shorter steps", Colour::Blue, Marker::Disc),
    ("FrBD, one step per answer", Colour::Orange, Marker::Square),
    ("FrBD, shorter steps", Colour::Vermilion, Marker::Disc),
];

fn main() -> ExitCode {
    bristle_charts::run(|| {
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
        let columns =
            ["amplitude", "frequency", "mean", "model", "steps", "error", "evaluations", "cost"];
        let mut table = Csv::create(arguments.out_dir(), "fidelity_atlas", &columns)?;
        let mut figure = Figure::new(1000, 470)
            .title("The cheapest model of sufficient accuracy, over amplitude and frequency")
            .note(format!(
                "Error of the force allowed: {} % (RMS) of the largest steady force.",
                100.0 * share
            ))
            .columns(2);
        let mut progress = Progress::new("amplitudes", 2 * amplitudes.len());
        for (title, mean) in [("v = A sin 2πft", 0.0), ("v = 1.2 A + A sin 2πft", 1.2)] {
            let mut marks: [Vec<(f64, f64)>; 5] = Default::default();
            for &amplitude in &amplitudes {
                for &frequency in &frequencies {
                    let mean = mean * amplitude;
                    let choice = chosen(mean, amplitude, frequency, share)?;
                    let best = choice.best;
                    let texts = [amplitude, frequency, mean].map(|number| number.to_string());
                    let [amplitude_text, frequency_text, mean_text] = texts.each_ref();
                    table.row(
                        &[amplitude_text, frequency_text, mean_text, best.level.model],
                        &[f64::from(best.steps), best.error, best.evaluations as f64, best.cost],
                    )?;
                    let kind = match (best.level, best.steps) {
                        (Level::STATIC_CURVE, _) => 0,
                        (Level::DAHL, 1) => 1,
                        (Level::DAHL, _) => 2,
                        (_, 1) => 3,
                        _ => 4,
                    };
                    marks[kind].push((amplitude, frequency));
                }
                progress.step();
            }
            println!("{title}, within {} %", 100.0 * share);
            let all = (amplitudes.len() * frequencies.len()) as f64;
            let axes = ("amplitude A (m/s)", "frequency f (Hz)");
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
        println!("\nthe lag of section V-A: v = 0.0055 + 0.005 sin(2π 25 t) m/s");
        println!("{}", chosen(0.0055, 0.005, 25.0, share)?);
        println!("\n{}", figure.save(arguments.out_dir(), "fidelity_atlas")?.display());
        Ok(())
    })
}

/// The choice for a sine. No answer falls on a reversal, where the static curve has two values.
fn chosen(mean: f64, amplitude: f64, frequency: f64, share: f64) -> Result<Choice, FidelityError> {
    let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
    let friction = FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?);
    let contact = friction.under_load(1.0)?;
    let velocity = SineParameters { mean, amplitude, frequency, phase: 0.03 };
    let answers = Answers { interval: 1.0 / (frequency * PERIOD as f64), count: 10 * PERIOD };
    let scene = KnownVelocity::new(contact, Sine::new(velocity)?, answers)?.starting_steadily();
    let largest = contact.limits(mean + amplitude).force.unwrap_or(f64::NAN);
    choose(&scene, Tolerance::root_mean_square(share * largest))
}

/// Values evenly spread over the decades between two ends.
fn spread(from: f64, to: f64, count: usize) -> Vec<f64> {
    let step = (to / from).ln() / (count - 1) as f64;
    (0..count).map(|index| from * (step * index as f64).exp()).collect()
}
