//! The stick-slip rig of the paper (section V-A, Table 2): a mass pulled by a spring whose end
//! moves at 0.1 m/s, with FrBD and LuGre friction.
//!
//! Leaves `stick_slip.csv` and `stick_slip.svg`: the whole run, and the first slip enlarged, where
//! the two models can be told apart.

use std::error::Error;
use std::process::ExitCode;

use bristle::curve::Stribeck;
use bristle::ode::{Direction, DormandPrince, Event, Output, Solver, Tolerances, Trajectory};
use bristle::rheology::KelvinVoigt;
use bristle::scene::MassSpringDamper;
use bristle::{Bristle, FrBd, LuGre, paper};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Progress, Rule, Stroke, println};
use nalgebra::Vector3;

/// Something to draw, from a state and the friction force there.
type Quantity = fn(&Vector3<f64>, f64) -> f64;

/// The mass sticks where it is slower than this [m/s].
const STUCK: f64 = 2e-3;

/// The first slip, with some time before and after it [s].
const FIRST_SLIP: std::ops::RangeInclusive<f64> = 7.2..=10.8;

/// One model's run, ready for the table and the chart.
struct Run {
    name: &'static str,
    label: &'static str,
    stroke: Stroke,
    trajectory: Trajectory<f64, 3>,
    force: Vec<f64>,
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("stick_slip", "The stick-slip rig of the paper")
            .number("end", 60.0, "s", "end of the simulated time; 10⁵ s take some 15 s")
            .must_be(Rule::Between(0.1, 1e5))
            .count("samples", 12001, "rows per model, evenly spaced, both ends included")
            .must_be(Rule::Between(2.0, 1e7))
            .number(
                "rtol",
                1e-8,
                "",
                "tolerance of the integration, relative to each state's scale",
            )
            .must_be(Rule::Positive)
            .parse()?;
        let span = arguments.number("end");
        let samples = arguments.count("samples");
        let rtol = arguments.number("rtol");

        let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
        let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
        let frbd = FrBd::new(curve, bristle);
        let lugre = LuGre::classical(curve, bristle);
        let mut progress = Progress::new("models", 2);
        let frbd = run("frbd", "FrBD", Colour::Blue.into(), frbd, span, samples, rtol)?;
        progress.step();
        let lugre = run("lugre", "LuGre", Colour::Orange.dashed(), lugre, span, samples, rtol)?;
        progress.step();
        let runs = [frbd, lugre];

        println!(
            "m = 1 kg, k = 2 N/m, v_ref = 0.1 m/s, Table 2, from rest, {span} s, rtol {rtol:e}"
        );
        println!();
        println!(
            "        slips  mean period  top speed  friction force     steps  evaluations  \
             reversals"
        );
        for run in &runs {
            run.report();
        }

        let mut table = Csv::create(
            arguments.out_dir(),
            "stick_slip",
            &["model", "t", "x", "v", "z", "force"],
        )?;
        for run in &runs {
            for ((t, state), &force) in run.trajectory.iter().zip(&run.force) {
                table.row(&[run.name], &[t, state[0], state[1], state[2], force])?;
            }
        }
        table.finish()?;
        println!();
        println!("{}", chart(&runs).save(arguments.out_dir(), "stick_slip")?.display());
        Ok(())
    })
}

/// Simulates the rig with one friction model.
fn run<M: Bristle<f64, Deflection = f64>>(
    name: &'static str,
    label: &'static str,
    stroke: Stroke,
    model: M,
    end: f64,
    samples: usize,
    rtol: f64,
) -> Result<Run, Box<dyn Error>> {
    let rig = MassSpringDamper::new(paper::stick_slip_rig(model.under_load(1.0)?))?;
    let solver = Solver::checked(DormandPrince, Tolerances::scaled(rtol, rig.scales())?);
    // A slip begins where the speed passes the Stribeck velocity.
    let slips = |_: f64, state: &Vector3<f64>| state[1] - paper::STICK_SLIP_CURVE.stribeck_velocity;
    let events = [Event { function: &slips, direction: Direction::Rising, stops: false }];
    let output = Output::Uniform(samples);
    let trajectory = solver.solve_with_events(&rig, 0.0..end, rig.at_rest(), &events, output)?;
    let force = trajectory.states().iter().map(|state| rig.friction_force(state)).collect();
    Ok(Run { name, label, stroke, trajectory, force })
}

impl Run {
    fn report(&self) {
        let slips = self.trajectory.events();
        let period = match slips {
            [first, .., last] => {
                format!("{:.6} s", (last.time - first.time) / (slips.len() - 1) as f64)
            }
            _ => "–".to_owned(),
        };
        let top = self.trajectory.states().iter().map(|state| state[1]).fold(0.0, f64::max);
        let least = self.force.iter().copied().fold(f64::INFINITY, f64::min);
        let most = self.force.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let statistics = self.trajectory.statistics();
        println!(
            "{:6}  {:5}  {period:>11}  {top:5.3} m/s  {least:6.3} … {most:5.3} N  {:8}  {:11}  \
             {:9}",
            self.label,
            slips.len(),
            statistics.steps,
            statistics.evaluations,
            statistics.reversals,
        );
    }

    /// The times during which the mass sticks [s].
    fn stick(&self) -> Vec<std::ops::RangeInclusive<f64>> {
        let samples: Vec<_> = self.trajectory.iter().collect();
        let stuck = |v: f64| v.abs() < STUCK;
        let spans = samples.chunk_by(|a, b| stuck(a.1[1]) == stuck(b.1[1]));
        let spans = spans.filter(|span| stuck(span[0].1[1]));
        spans.map(|span| span[0].0..=span[span.len() - 1].0).collect()
    }

    /// A quantity over time.
    fn over_time(&self, value: impl Fn(&Vector3<f64>, f64) -> f64) -> Vec<(f64, f64)> {
        let states = self.trajectory.iter().zip(&self.force);
        states.map(|((t, state), &force)| (t, value(state, force))).collect()
    }
}

fn chart(runs: &[Run; 2]) -> Figure {
    let rows: [(&str, Quantity); 4] = [
        ("position x (m)", |state, _| state[0]),
        ("velocity v (m/s)", |state, _| state[1]),
        ("deflection z (µm)", |state, _| state[2] * 1e6),
        ("friction force F (N)", |_, force| force),
    ];
    let [frbd, lugre] = runs;
    let stick = frbd.stick();
    let mut figure = Figure::new(900, 900)
        .title("Stick-slip of a spring-driven mass: FrBD and LuGre over time")
        .columns(2);
    for (index, (label, value)) in rows.into_iter().enumerate() {
        let panel = Panel::new("time t (s)", label);
        let panel = stick.iter().fold(panel, |panel, range| panel.shade("stick", range.clone()));
        let whole = panel.line(frbd.label, frbd.stroke, frbd.over_time(value));
        let slip = whole.clone().x_range(FIRST_SLIP);
        let slip = slip.line(lugre.label, lugre.stroke, lugre.over_time(value));
        figure = figure.panel(if index == 0 { whole.title("FrBD") } else { whole });
        figure = figure.panel(if index == 0 { slip.title("the first slip") } else { slip });
    }
    figure
}
