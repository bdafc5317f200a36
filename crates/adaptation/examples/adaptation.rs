//! Friction that rises by 30 % while an arm on a gear moves, and what follows it: nothing, a
//! disturbance observer, adaptation, both.
//!
//! Leaves `adaptation.csv` and `adaptation.svg`: the estimate and the tracking error, with friction
//! of the family that the controller knows, and with elasto-plastic friction and a torque that
//! depends on the angle.

#[path = "adaptation/arm.rs"]
mod arm;

use std::process::ExitCode;

use arm::{Method, NOMINAL, Record, Truth, elasto_plastic, known, rms, run};
use bristle_adaptation::FrictionEstimate;
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, println};

type Points = Vec<(f64, f64)>;

/// What each parameter contributes while the arm slides at 3 rad/s under a load of 4 N m.
type Torque = fn(&FrictionEstimate<f64>) -> f64;
const TORQUES: [(&str, Colour, Torque); 4] = [
    ("idle load × 0.1", Colour::Black, |estimate| 0.1 * estimate.idle_load),
    ("load share × 0.1 × 4 N m", Colour::Purple, |estimate| 0.4 * estimate.load_share),
    ("drag × 3 rad/s", Colour::Sky, |estimate| 3.0 * estimate.drag),
    ("offset", Colour::Vermilion, |estimate| estimate.offset),
];

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("adaptation", "Friction followed while an arm moves")
            .number("factor", 1.3, "", "friction after 10 s over that before")
            .must_be(Rule::Positive)
            .number("cogging", 0.1, "N m", "torque that depends on the angle, on the right")
            .must_be(Rule::AtLeast(0.0))
            .number("corner", 100.0, "rad/s", "of the disturbance observer")
            .must_be(Rule::Positive)
            .parse()?;
        let number = |name| arguments.number(name);
        let mut table =
            Csv::create(arguments.out_dir(), "adaptation", &["plant", "curve", "t", "value"])?;
        let (mut estimates, mut errors) = (Vec::new(), Vec::new());
        for (name, cogging) in [("same family", 0.0), ("another family", number("cogging"))] {
            let truth = |time: f64| Truth {
                friction: scaled(if time < 10.0 { 1.0 } else { number("factor") }),
                cogging,
            };
            let runs = [
                ("none", Method::Nominal, Colour::Grey),
                ("observer", Method::DisturbanceObserver(number("corner")), Colour::Orange),
                ("adaptation", Method::Adaptation, Colour::Blue),
                ("both", Method::Both(number("corner")), Colour::Green),
            ];
            let mut panel =
                Panel::new("time t (s)", "error (mrad, rms of 1 s)").log_y().title(name);
            for (label, method, colour) in runs {
                let records = match cogging {
                    0.0 => run(known()?, truth, method, 30_000)?,
                    _ => run(elasto_plastic()?, truth, method, 30_000)?,
                };
                println!(
                    "{name:15} {label:12} {:.3} mrad before, {:.3} mrad from 15 s",
                    1e3 * rms(&records[..10_000], 5.0),
                    1e3 * rms(&records, 15.0)
                );
                let error = errors_over_time(&records);
                error.iter().try_for_each(|&(t, e)| table.row(&[name, label], &[t, e]))?;
                panel = panel.line(label, colour, &error);
                if method == Method::Adaptation {
                    let mut panel = Panel::new("time t (s)", "friction torque (N m)").title(name);
                    for (label, colour, torque) in TORQUES {
                        let points: Points = records
                            .iter()
                            .step_by(20)
                            .map(|record| (record.time, torque(&record.estimate)))
                            .collect();
                        points.iter().try_for_each(|&(t, x)| table.row(&[name, label], &[t, x]))?;
                        let real =
                            [0.0, 9.999, 10.0, 30.0].map(|t| (t, torque(&truth(t).friction)));
                        panel = panel.line("", colour.dashed(), real).line(label, colour, &points);
                    }
                    estimates.push(panel);
                }
            }
            errors.push(panel);
        }
        table.finish()?;
        let mut figure = Figure::new(980, 760).title("Friction followed while it runs").columns(2);
        for panel in estimates.into_iter().chain(errors) {
            figure = figure.panel(panel);
        }
        println!("\n{}", figure.save(arguments.out_dir(), "adaptation")?.display());
        Ok(())
    })
}

/// The nominal friction times a factor.
fn scaled(factor: f64) -> FrictionEstimate<f64> {
    FrictionEstimate {
        idle_load: factor * NOMINAL.idle_load,
        load_share: factor * NOMINAL.load_share,
        drag: factor * NOMINAL.drag,
        offset: factor * NOMINAL.offset,
    }
}

/// Root mean square [mrad] of each second.
fn errors_over_time(records: &[Record]) -> Points {
    let second = |of: &[Record]| (of[0].time + 0.5, 1e3 * rms(of, 0.0));
    records.chunks(1000).map(second).collect()
}
