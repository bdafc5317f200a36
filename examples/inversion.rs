//! What one step of an inversion costs: FrBD takes one Newton-like step of the bristle's force
//! balance, the implicit bristle solves it. Table 2, p = 1 N, in four scenes: frictional lag,
//! stick-slip, pre-sliding and the rate at which a disturbance of steady sliding fades.
//!
//! Leaves `inversion.csv` and `inversion.svg`.

use std::error::Error;
use std::f64::consts::PI;
use std::process::ExitCode;

use bristle::curve::{FrictionCurve, Stribeck};
use bristle::ode::{Direction, DormandPrince8, Event, Output, Solver, Tolerances};
use bristle::rheology::KelvinVoigt;
use bristle::scene::{MassSpringDamper, MassSpringDamperParameters, PrescribedVelocity};
use bristle::signal::{Sine, SineParameters};
use bristle::{Bristle, FrBd, ImplicitBristle, Mechanism, paper};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, Stroke, println};
use nalgebra::Vector3;

const LAG_FREQUENCIES: [f64; 2] = [25.0, 100.0];
const STICK_SLIP_END: f64 = 60.0;
const LOAD_CYCLES: f64 = 20.0;

/// What one model did: lag loops (v, F) by frequency, the drag of stick-slip (t, F), its period,
/// pre-sliding (x, F), and rates (v, 1/s).
struct Run {
    name: &'static str,
    label: &'static str,
    stroke: Stroke,
    lag: Vec<Vec<(f64, f64)>>,
    stick_slip: Vec<(f64, f64)>,
    period: Option<f64>,
    presliding: Vec<(f64, f64)>,
    rates: Vec<(f64, f64)>,
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments =
            Arguments::new("inversion", "FrBD beside the bristle whose force balance is solved")
                .count("samples", 4001, "rows per model and scene, evenly spaced")
                .must_be(Rule::Between(100.0, 1e6))
                .number("rtol", 1e-9, "", "tolerance, relative to each state's scale")
                .must_be(Rule::Positive)
                .parse()?;
        let (samples, rtol) = (arguments.count("samples"), arguments.number("rtol"));

        let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
        let rheology = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
        let one_step = FrBd::new(curve, rheology);
        let solved = ImplicitBristle::new(curve, rheology)?;
        let runs = [
            run("implicit", "implicit bristle", Colour::Black.into(), &solved, samples, rtol)?,
            run("frbd", "FrBD", Colour::Blue.dashed(), &one_step, samples, rtol)?,
        ];

        println!("Table 2, p = 1 N, rtol {rtol:e}");
        println!();
        println!("                  stick-slip   drift per load cycle   disturbance of steady");
        println!("                  period       0 … 0.8 of breakaway   sliding at 5.5 mm/s");
        for run in &runs {
            let period = run.period.map_or("–".to_owned(), |period| format!("{period:.6} s"));
            let at = |cycle: f64| {
                let row = (run.presliding.len() - 1) as f64 * cycle / LOAD_CYCLES;
                run.presliding[row as usize].0
            };
            let drift = (at(LOAD_CYCLES) - at(0.5 * LOAD_CYCLES)) / (0.5 * LOAD_CYCLES);
            // No minus before a zero.
            let drift = (drift * 1e3).round() * 1e-3 + 0.0;
            let (_, rate) = run
                .rates
                .iter()
                .copied()
                .min_by(|a, b| (a.0 - 5.5).abs().total_cmp(&(b.0 - 5.5).abs()))
                .unwrap_or_default();
            println!("{:16}  {period:11}  {drift:17.3} µm   {rate:18.1} 1/s", run.label);
        }
        println!();
        for (index, frequency) in LAG_FREQUENCIES.into_iter().enumerate() {
            let [a, b] = [&runs[0].lag[index], &runs[1].lag[index]];
            let apart = a.iter().zip(b).map(|(a, b)| (a.1 - b.1).abs()).fold(0.0, f64::max);
            println!("lag loops at {frequency:5} Hz are up to {apart:.3} apart in μ_b");
        }

        let columns = ["model", "scene", "x", "y"];
        let mut table = Csv::create(arguments.out_dir(), "inversion", &columns)?;
        for run in &runs {
            for (scene, points) in [
                ("lag_25_hz", &run.lag[0]),
                ("lag_100_hz", &run.lag[1]),
                ("stick_slip", &run.stick_slip),
                ("presliding", &run.presliding),
                ("rate", &run.rates),
            ] {
                for &(x, y) in points {
                    table.row(&[run.name, scene], &[x, y])?;
                }
            }
        }
        table.finish()?;
        println!();
        println!("{}", chart(&runs, &curve).save(arguments.out_dir(), "inversion")?.display());
        Ok(())
    })
}

fn sine(mean: f64, amplitude: f64, frequency: f64) -> Result<Sine<f64>, Box<dyn Error>> {
    Ok(Sine::new(SineParameters { mean, amplitude, frequency, phase: 0.0 })?)
}

/// Plays every scene with one model.
fn run<M: Bristle<f64, Deflection = f64>>(
    name: &'static str,
    label: &'static str,
    stroke: Stroke,
    model: &M,
    samples: usize,
    rtol: f64,
) -> Result<Run, Box<dyn Error>> {
    let contact = || model.clone().under_load(1.0);

    let mut lag = Vec::new();
    for frequency in LAG_FREQUENCIES {
        let velocity = sine(0.0055, 0.005, frequency)?;
        let scene = PrescribedVelocity::new(contact()?, velocity);
        let solver = Solver::checked(DormandPrince8, Tolerances::scaled(rtol, scene.scales())?);
        // After whole periods in which it settles: a disturbance of FrBD fades with 32 1/s.
        let settled = solver.solve(&scene, 0.0..1.0, scene.stationary(0.0), Output::Uniform(2))?;
        let start = settled.states()[1];
        let span = 1.0..1.0 + 1.0 / frequency;
        let last = solver.solve(&scene, span, start, Output::Uniform(samples))?;
        let point =
            |(t, state): (f64, &_)| (scene.velocity(t) * 1e3, scene.friction_force(t, state));
        lag.push(last.iter().map(point).collect());
    }

    let rig = MassSpringDamper::new(paper::stick_slip_rig(contact()?))?;
    let solver = Solver::checked(DormandPrince8, Tolerances::scaled(rtol, rig.scales())?);
    let slips = |_: f64, state: &Vector3<f64>| state[1] - paper::STICK_SLIP_CURVE.stribeck_velocity;
    let events = [Event { function: &slips, direction: Direction::Rising, stops: false }];
    let output = Output::Uniform(samples);
    let trajectory =
        solver.solve_with_events(&rig, 0.0..STICK_SLIP_END, rig.at_rest(), &events, output)?;
    let period = match trajectory.events() {
        [first, .., last] => {
            Some((last.time - first.time) / (trajectory.events().len() - 1) as f64)
        }
        _ => None,
    };
    let stick_slip = trajectory.iter().map(|(t, state)| (t, rig.friction_force(state))).collect();

    // A unit mass under a force between 0 and 0.8 of breakaway, once a second; from 0, so that
    // nothing swings.
    let force =
        Sine::new(SineParameters { mean: 0.6, amplitude: 0.6, frequency: 1.0, phase: -0.5 * PI })?;
    let scene = MassSpringDamper::new(MassSpringDamperParameters {
        contact: contact()?,
        mechanism: Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 },
        drive_velocity: 0.0,
        force,
    })?;
    let solver = Solver::checked(DormandPrince8, Tolerances::scaled(rtol, scene.scales())?);
    let trajectory =
        solver.solve(&scene, 0.0..LOAD_CYCLES, scene.at_rest(), Output::Uniform(samples))?;
    let presliding =
        trajectory.iter().map(|(_, state)| (state[0] * 1e6, scene.friction_force(state))).collect();

    // −∂ż/∂z at steady sliding, from 1e-4 to 1 m/s.
    let rates = (0..=400)
        .map(|i| 5.5e-3 * 10_f64.powf(f64::from(i - 174) / 100.0))
        .map(|v| (v * 1e3, -model.linearised(v, model.stationary(v)).rate_by_deflection))
        .collect();
    Ok(Run { name, label, stroke, lag, stick_slip, period, presliding, rates })
}

fn chart(runs: &[Run], curve: &Stribeck<f64>) -> Figure {
    let steady: Vec<_> = (0..=200)
        .map(|i| 5e-4 + f64::from(i) * 5e-5)
        .map(|v| (v * 1e3, curve.coefficient(v.into())))
        .collect();
    let mut lag = Panel::new("sliding velocity v (mm/s)", "friction force F (N)")
        .title("frictional lag, 25 Hz")
        .line("steady sliding", Colour::Orange.width(1.0), &steady);
    let mut stick_slip = Panel::new("time t (s)", "friction force F (N)")
        .title("stick-slip, the first half")
        .x_range(0.0..=30.0);
    let mut presliding = Panel::new("position x (µm)", "friction force F (N)")
        .title("load cycles 0 … 0.8 of breakaway");
    let mut rates = Panel::new("sliding velocity v (mm/s)", "rate −∂ż/∂z (1/s)")
        .title("disturbances of steady sliding fade")
        .log_x()
        .log_y();
    for run in runs {
        lag = lag.line(run.label, run.stroke, &run.lag[0]);
        stick_slip = stick_slip.line(run.label, run.stroke, &run.stick_slip);
        // The first five cycles.
        let first = &run.presliding[..run.presliding.len() / 4];
        presliding = presliding.line(run.label, run.stroke, first);
        rates = rates.line(run.label, run.stroke, &run.rates);
    }
    Figure::new(960, 760)
        .title("What one step of an inversion costs")
        .columns(2)
        .panel(lag)
        .panel(stick_slip)
        .panel(presliding)
        .panel(rates)
}
