//! Parameters of a friction model from measured motion and friction.
//!
//! Without a file it makes noisy data of a known model and finds its parameters. With one,
//!
//! ```sh
//! cargo run --release -p bristle-identify --example identify_friction -- FILE \
//!     --columns t=1,x=3*1e-3,f=4*-1e-6,n=2*1e-6 --from 12 --to 108 --predict 204
//! ```
//!
//! fits the rows from 12 to 108 s and predicts those up to 204 s: columns t \[s\], x \[m\] or v
//! [m/s], f \[N\] (positive against v > 0), and n \[N\] if it was measured.
//!
//! Leaves `identify_friction.csv` and `identify_friction.svg`: the friction coefficient over time
//! and over position, data and model.

use std::error::Error;
use std::num::NonZero;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::ExitCode;

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, FrBd};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Progress, Rule, Values, println};
use bristle_identify as identify;
use bristle_identify::{
    Candidate, ElastoPlasticFit, FrBdFit, InitialGuess, Log, LogParameters, MeasuredMotion,
    SearchSettings,
};

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new(
            "identify_friction",
            "Friction parameters from measured motion and friction",
        )
        .file()
        .text("columns", "t=1,x=2,f=3", "NAME=COLUMN*FACTOR for t, x or v, f, and n, in SI units")
        .text("model", "lumped", "lumped or yielding (elasto-plastic)")
        .number("from", -1e9, "s", "first time to fit")
        .number("to", 1e9, "s", "last time to fit")
        .number("predict", 1e9, "s", "last time to predict, from the last one fitted on")
        .number("settle", 0.0, "s", "time at the beginning that does not count")
        .must_be(Rule::AtLeast(0.0))
        .count("substeps", 1, "steps per row of the model yielding")
        .must_be(Rule::Between(1.0, 1e3))
        .count("starts", 1, "searches from different places")
        .must_be(Rule::Between(1.0, 1e3))
        .parse()?;
        let log = match arguments.file() {
            Some(path) => {
                let (from, to) = (arguments.number("from"), arguments.number("predict"));
                read(path, arguments.text("columns"), from, to)?
            }
            None => synthetic()?,
        };
        match arguments.text("model") {
            "lumped" => report(&FrBdFit, &log, &arguments),
            "yielding" => {
                let substeps = u32::try_from(arguments.count("substeps"))?;
                let candidate = ElastoPlasticFit { substeps: NonZero::try_from(substeps)? };
                report(&candidate, &log, &arguments)
            }
            other => {
                Err(format!("--model must be lumped or yielding, but {other:?} was given").into())
            }
        }
    })
}

/// The rows of a file within a span of time.
fn read(path: &Path, choice: &str, from: f64, to: f64) -> Result<Log, Box<dyn Error>> {
    let columns = bristle_charts::read_columns(path, choice)?;
    let named =
        |wanted: &str| columns.iter().find(|(name, _)| name == wanted).map(|(_, column)| column);
    let time = named("t").ok_or("--columns must name t")?;
    let first = time.iter().position(|&t| t >= from).unwrap_or(time.len());
    let end = time.iter().rposition(|&t| t <= to).map_or(first, |last| (last + 1).max(first));
    let find = |wanted: &str| named(wanted).map(|column| &column[first..end]);
    let motion = match (find("x"), find("v")) {
        (Some(position), None) => MeasuredMotion::Position(position),
        (None, Some(velocity)) => MeasuredMotion::Velocity(velocity),
        _ => return Err("--columns must name either x or v".into()),
    };
    Ok(Log::new(LogParameters {
        time: &time[first..end],
        motion,
        friction: find("f").ok_or("--columns must name f")?,
        normal_force: find("n"),
    })?)
}

/// The model of the synthetic data.
const CURVE: StribeckParameters<f64> = StribeckParameters {
    static_coefficient: 0.30,
    dynamic_coefficient: 0.20,
    stribeck_velocity: 0.01, // m/s
    stribeck_exponent: 2.0,
    viscous_friction: 0.8, // s/m
};
const BRISTLE: KelvinVoigtParameters<f64> =
    KelvinVoigtParameters { micro_stiffness: 6e3, micro_damping: 8.0 };

/// Ten seconds at 500 Hz: slides of many speeds and pre-sliding, under 50 N, with 2 % noise.
fn synthetic() -> Result<Log, Box<dyn Error>> {
    let friction = FrBd::new(Stribeck::new(CURVE)?, KelvinVoigt::new(BRISTLE)?);
    let mut noise = bristle_charts::noise();
    let (mut time, mut velocity, mut force, mut deflection) = (vec![], vec![], vec![], 0.0);
    for row in 0..5001 {
        let t = 2e-3 * f64::from(row);
        let v = 0.05 * (1.3 * t).sin() * (0.37 * t).sin() + 0.004 * (17.0 * t).sin();
        if let Some(before) = velocity.last() {
            deflection = friction.hold(0.5 * (v + before), deflection, 2e-3).deflection;
        }
        time.push(t);
        velocity.push(v);
        force.push(50.0 * (friction.coefficient(v, deflection) + 0.02 * 0.25 * noise()));
    }
    println!(
        "synthetic data: μ_d 0.2, μ_s − μ_d 0.1, v_S 0.01 m/s, σ2 0.8 s/m, σ0 6000 1/m, \
         σ1 8 s/m; noise of 2 %"
    );
    let normal = vec![50.0; time.len()];
    Ok(Log::new(LogParameters {
        time: &time,
        motion: MeasuredMotion::Velocity(&velocity),
        friction: &force,
        normal_force: Some(&normal),
    })?)
}

fn report<C: Candidate<N>, const N: usize>(
    candidate: &C,
    log: &Log,
    arguments: &Values,
) -> Result<(), Box<dyn Error>> {
    let (from, to) = (arguments.number("from"), arguments.number("to"));
    let log = &log.clone().settling(arguments.number("settle"))?;
    let seen = log.between(from, to)?;
    let settings =
        SearchSettings { starts: arguments.count("starts"), ..SearchSettings::default() };
    let mut progress = Progress::new("searches", settings.starts);
    let mut start = 0;
    let mut watch = |now: &identify::SearchProgress<'_>| {
        if now.start != start {
            start = now.start;
            progress.step();
        }
        ControlFlow::Continue(())
    };
    let parameters = candidate.parameters(&InitialGuess::of(&seen)?);
    let fit = identify::fit(candidate, parameters, &seen, &settings, &mut watch)?;
    progress.step();
    println!("\n{fit}\n");

    let mut table = Csv::create(
        arguments.out_dir(),
        "identify_friction",
        &["part", "t", "x", "v", "data", "model"],
    )?;
    let new_over_time = || Panel::new("time t (s)", "friction coefficient F/p (–)");
    let mut over_time = new_over_time();
    let mut over_position = Panel::new("position x (mm)", "friction coefficient F/p (–)");
    let last = seen.times().last().copied().unwrap_or(to);
    let unseen = log.between(last.next_up(), arguments.number("predict")).ok();
    let parts = [("fitted", Some(seen), Colour::Green), ("predicted", unseen, Colour::Blue)];
    // Positions of all parts from one zero, that of the first row of all.
    let whole = log.positions();
    let begin = |part: &Log| {
        let first = part.times().first().copied().unwrap_or(0.0);
        whole.get(log.times().partition_point(|&t| t < first)).copied().unwrap_or(0.0)
    };
    println!("| model | part | rmse of F/p | mean size | relative | work, model over data |");
    for (name, log, colour) in parts {
        let Some(log) = log else { continue };
        let model = identify::predict(candidate, &fit.values(), &log)?;
        let data = log.coefficients();
        let errors = || model.iter().zip(data);
        let mean = |sum: f64| sum / log.len() as f64;
        let size = mean(errors().map(|(model, data)| (model - data).abs()).sum());
        let square = mean(errors().map(|(_, data)| data * data).sum());
        let (rmse, work) = (log.rmse(&model), log.work(&model) / log.work(data));
        let relative = 100.0 * rmse / square.sqrt();
        println!(
            "| `{word}` | {name} | {rmse:.4} | {size:.4} | {relative:.1} % | {work:.3} |",
            word = arguments.text("model")
        );
        let zero = begin(&log);
        let positions = log.positions().into_iter().map(|x| zero + x).collect();
        let columns = [log.times().to_vec(), positions, log.velocities().to_vec()];
        let [t, x, v] = &columns;
        for row in 0..log.len() {
            table.row(&[name], &[t[row], x[row], v[row], data[row], model[row]])?;
        }
        // A few loops; all of them would hide one another.
        let rows = log.len().min(1600);
        let millimetres: Vec<f64> = x.iter().map(|x| 1e3 * x).collect();
        let pairs = |x: &[f64], y: &[f64]| -> Vec<(f64, f64)> {
            x.iter().copied().zip(y.iter().copied()).take(rows).collect()
        };
        // Of two parts the one not seen before.
        over_time = new_over_time().line("data", Colour::Orange.width(4.0), pairs(t, data)).line(
            name,
            colour,
            pairs(t, &model),
        );
        over_position = over_position
            .line("data", Colour::Orange.width(4.0), pairs(&millimetres, data))
            .line(name, colour, pairs(&millimetres, &model));
    }
    table.finish()?;
    let figure = Figure::new(760, 640)
        .title("Friction of a measured motion and of the identified model")
        .panel(over_time)
        .panel(over_position);
    println!("\n{}", figure.save(arguments.out_dir(), "identify_friction")?.display());
    Ok(())
}
