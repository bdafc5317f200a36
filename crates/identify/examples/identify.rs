//! Inertia, friction and load factors of a joint from logs of its drive and position.
//!
//! Without files it makes logs of a known joint: encoder counts, noise of the torque. With files,
//!
//! ```sh
//! cargo run --release -p bristle-identify --features serde --example identify -- \
//!     --log monday_*.csv --held-out tuesday.csv --terms gravity --columns torque=tau*2.4
//! ```
//!
//! fits the first ones, names a model by them alone, and predicts the others. A column is taken by
//! the beginning of its name in the first line: `time_s`, `position [rad]`, and one of `torque`,
//! `current`, `voltage` and `goal`, that of a position controller with duty = clamp(K_p (goal −
//! position) − K_d velocity, ±1), options `gain` and `derivative-gain`. There may be `velocity`,
//! `supply`, `enabled` and `external_torque`.
//!
//! Without `--held-out` the last third of every log is held out. Logs that begin in motion take
//! `--begin motion`, or `--begin monday=motion,rest` those whose name has `monday`.
//!
//! Leaves `identify.csv`, every row with its errors of position and torque, `identify.svg`, the
//! measured and the simulated position of the logs held out, and with the feature `serde` the joint
//! as `identify.toml`, for `identify::mechanism::JointModel`.

#[path = "identify/logs.rs"]
mod logs;

use std::error::Error;
use std::ops::ControlFlow;
use std::process::ExitCode;

use bristle::Units;
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, Values, println};
use bristle_identify::mechanism::{
    self, Friction, GroupScores, Joint, JointFit, Loss, Progress, Score, Settings, Term,
};
use logs::Named;

/// Panels of the chart at most.
const PANELS: usize = 8;

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("identify", "A joint from logs of drive and position")
            .files("log", "logs to fit, tables with a line of names")
            .files("held-out", "logs that are only predicted")
            .text("columns", "", "NAME=COLUMN*FACTOR,… where names differ from the first line's")
            .text(
                "between-rows",
                "linear",
                "the drive between two rows: linear or held, or command, held without noise",
            )
            .text("begin", "rest", "how logs begin: rest or motion; PART=motion,…,rest, as gain")
            .number("delay", 0.0, "s", "time by which the drive acts later than its rows say")
            .must_be(Rule::AtLeast(0.0))
            .text("gain", "", "duty per radian; PART=GAIN,… for files whose name has the part")
            .text("derivative-gain", "", "duty taken off per rad/s, as gain")
            .number("supply", 0.0, "V", "voltage that the duty is of, without a column of it")
            .must_be(Rule::AtLeast(0.0))
            .text(
                "terms",
                "",
                "torques on the load side: gravity, spring, constant, backward-drag, ripple:NUMBER",
            )
            .text("units", "rotation", "of the results: rotation or translation")
            .text("load-gravity", "", "known torque of the load / N m; PART=TORQUE,…, as gain")
            .text("load-inertia", "", "known inertia of the load / kg m²; PART=INERTIA,…, as gain")
            .text("known", "", "PARAMETER=VALUE,… that are known")
            .text("start", "", "PARAMETER=VALUE,… where the search starts")
            .text("each", "", "PARAMETER,… that each log has for itself")
            .text(
                "model",
                "all",
                "coulomb, stribeck, dahl, frbd or lugre, with -loaded, -directional, -exponential \
                 behind, …",
            )
            .text("loss", "squares", "squares, huber or tukey")
            .text("criterion", "simulated", "of the last search: simulated or inverse")
            .count("runs", 200, "most runs with derivatives of a model")
            .must_be(Rule::AtLeast(1.0))
            .parse()?;
        let files = [arguments.files("log"), arguments.files("held-out")];
        let (mut joint, mut models) = (joint(&arguments)?, models(arguments.text("model"))?);
        let (fitted, held_out) = if files[0].is_empty() {
            joint = joint.with(Term::Gravity);
            if arguments.text("model") == "all" {
                models = vec![
                    Friction::coulomb(),
                    Friction::coulomb().loaded(),
                    Friction::dahl(),
                    Friction::dahl().loaded(),
                ];
            }
            logs::synthetic()?
        } else if files[1].is_empty() {
            logs::split(logs::read(&files[0], &arguments)?)
        } else {
            (logs::read(&files[0], &arguments)?, logs::read(&files[1], &arguments)?)
        };
        let fit = search(&joint, &models, [&fitted, &held_out], &arguments)?;
        report(&fit, [&fitted, &held_out], &arguments)
    })
}

/// A name from the command line as a joint takes it, for the rest of the program.
fn lasting(name: &str) -> &'static str {
    name.to_owned().leak()
}

/// `NAME=VALUE,NAME=VALUE` with the names of parameters, which the joint checks.
fn pairs(option: &str, text: &str) -> Result<Vec<(&'static str, f64)>, Box<dyn Error>> {
    let pair = |part: &str| -> Result<(&'static str, f64), Box<dyn Error>> {
        let (name, value) = part.split_once('=').unwrap_or((part, ""));
        let value = value
            .parse()
            .map_err(|_| format!("--{option} must be PARAMETER=VALUE,…, but {part:?} was given"))?;
        Ok((lasting(name), value))
    };
    text.split(',').filter(|part| !part.is_empty()).map(pair).collect()
}

/// The mechanism, and what is known of it.
fn joint(arguments: &Values) -> Result<Joint, Box<dyn Error>> {
    let mut joint = Joint::new().in_units(match arguments.text("units") {
        "rotation" => Units::Rotation,
        "translation" => Units::Translation,
        other => return Err(format!("--units has no {other:?}").into()),
    });
    for term in arguments.text("terms").split(',').filter(|term| !term.is_empty()) {
        if let Some(number) = term.strip_prefix("ripple:") {
            joint = Term::ripple(number.parse()?).into_iter().fold(joint, Joint::with);
            continue;
        }
        joint = joint.with(match term {
            "gravity" => Term::Gravity,
            "spring" => Term::spring(),
            "constant" => Term::constant(),
            "backward-drag" => Term::backward_drag(),
            other => return Err(format!("--terms has no {other:?}").into()),
        });
    }
    for (name, value) in pairs("start", arguments.text("start"))? {
        joint = joint.start(name, value);
    }
    for (name, value) in pairs("known", arguments.text("known"))? {
        joint = joint.known(name, value);
    }
    for name in arguments.text("each").split(',').filter(|name| !name.is_empty()) {
        joint = joint.of_each_log(lasting(name));
    }
    Ok(joint)
}

/// The candidates for the friction.
fn models(text: &str) -> Result<Vec<Friction>, Box<dyn Error>> {
    if text == "all" {
        return Ok(Friction::candidates());
    }
    let model = |word: &str| -> Result<Friction, Box<dyn Error>> {
        let mut parts = word.split('-');
        let friction = match parts.next().unwrap_or_default() {
            "coulomb" => Friction::coulomb(),
            "stribeck" => Friction::stribeck(),
            "dahl" => Friction::dahl(),
            "frbd" => Friction::frbd(),
            "lugre" => Friction::lugre(),
            other => return Err(format!("--model has no {other:?}").into()),
        };
        parts.try_fold(friction, |friction, part| match part {
            "loaded" => Ok(friction.loaded()),
            "directional" => Ok(friction.directional()),
            "exponential" => Ok(friction.exponential()),
            other => Err(format!("--model has no -{other}").into()),
        })
    };
    text.split(',').map(model).collect()
}

/// Fits the only model, or compares all of them and takes the one that is named.
fn search(
    joint: &Joint,
    models: &[Friction],
    [fitted, held_out]: [&[Named]; 2],
    arguments: &Values,
) -> Result<JointFit, Box<dyn Error>> {
    let loss = match arguments.text("loss") {
        "squares" => Loss::Squares,
        "huber" => Loss::Huber,
        "tukey" => Loss::Tukey,
        other => return Err(format!("--loss has no {other:?}").into()),
    };
    let horizons = match arguments.text("criterion") {
        "simulated" => Vec::new(),
        "inverse" => vec![0.0],
        other => return Err(format!("--criterion has no {other:?}").into()),
    };
    let gradient_runs = arguments.count("runs");
    let settings = Settings { loss, gradient_runs, horizons, ..Settings::default() };
    let files = [("log ", fitted), ("held-out log ", held_out)];
    let [fitted, held_out] = [fitted, held_out].map(logs::logs);
    let parts = models.len() * gradient_runs;
    let mut bar = bristle_charts::Progress::new("runs, of at most", parts);
    let mut watch = |now: &Progress<'_>| {
        bar.reach((now.candidate * gradient_runs + now.gradient_runs).min(parts - 1));
        ControlFlow::Continue(())
    };
    let fit = if let [model] = models {
        let fit = mechanism::fit_joint(joint, model, &fitted, &held_out, &settings, &mut watch)?;
        bar.reach(parts);
        println!("{}", with_files(&fit.to_string(), files));
        fit
    } else {
        let found = mechanism::compare(joint, models, &fitted, &held_out, &settings, &mut watch)?;
        bar.reach(parts);
        println!("{}", with_files(&found.to_string(), files));
        found.named().ok_or("no search has converged")?.clone()
    };
    Ok(fit)
}

/// A report whose remarks and rows of logs name the files in place of the numbers of the logs.
fn with_files(report: &str, groups: [(&str, &[Named]); 2]) -> String {
    let line = |line: &str| {
        let text = line.trim_start();
        let found =
            groups.iter().find_map(|(what, files)| Some((text.strip_prefix(what)?, *files)));
        let (rest, files) = found.unwrap_or_default();
        let number = rest.trim_start_matches(|c: char| c.is_ascii_digit());
        let place = rest[..rest.len() - number.len()].parse::<usize>().ok();
        match place.and_then(|place| files.get(place)) {
            Some(Named { name, .. }) if line == text => format!("{name}{number}\n"),
            // A row of a table.
            Some(Named { name, .. }) => format!("  {name:25} {}\n", number.trim_start()),
            None => format!("{line}\n"),
        }
    };
    report.lines().map(line).collect()
}

fn print_error(part: &str, name: &str, score: &Score) {
    let (size, relative) = (score.mean_absolute, 100.0 * score.relative);
    println!("  {part:9} {name:32} {size:.4}  {relative:5.1} %");
}

/// Errors log by log, table, chart and model.
fn report(
    fit: &JointFit,
    [fitted, held_out]: [&[Named]; 2],
    arguments: &Values,
) -> Result<(), Box<dyn Error>> {
    let mut table = Csv::create(
        arguments.out_dir(),
        "identify",
        &["part", "log", "t", "measured", "simulated", "error", "torque_error"],
    )?;
    let length = match arguments.text("units") {
        "translation" => "m",
        _ => "rad",
    };
    let title = format!("Position of logs that were not fitted, and of the model {}", fit.friction);
    let height = 60 + 230 * held_out.len().clamp(1, PANELS) as u32;
    let mut figure = Figure::new(860, height).title(title).columns(2);
    println!("simulated position: mean size of the error, rmse over the motion");
    let groups =
        [("fitted", fitted, Some(&fit.fitted)), ("held out", held_out, fit.held_out.as_ref())];
    for (part, logs, scores) in groups {
        let Some(GroupScores { all, each }) = scores else { continue };
        for ((place, Named { name, log }), scores) in logs.iter().enumerate().zip(each) {
            print_error(part, name, &scores.simulated);
            let (simulated, torque_errors) = (fit.simulate(log)?, fit.torque_errors(log)?);
            let rows = || log.times().iter().zip(log.positions()).zip(&simulated);
            for (((&t, &measured), &simulated), torque_error) in rows().zip(torque_errors) {
                let numbers = [t, measured, simulated, simulated - measured, torque_error];
                table.row(&[part, name], &numbers)?;
            }
            if part == "held out" && place < PANELS {
                let line = |values: &[f64]| -> Vec<(f64, f64)> {
                    log.times().iter().copied().zip(values.iter().copied()).collect()
                };
                // A line of names has no subscripts.
                let (name, error) = (name.replace('_', " "), scores.simulated.mean_absolute);
                let title = format!("{name}: mean error {error:.4} {length}");
                let panel = Panel::new("time t (s)", format!("position x ({length})"))
                    .title(title)
                    .line("measured", Colour::Orange.width(4.0), line(log.positions()))
                    .line("simulated", Colour::Blue.width(1.2), line(&simulated));
                let errors = simulated.iter().zip(log.positions()).map(|(x, y)| x - y);
                let errors = line(&errors.collect::<Vec<f64>>());
                let beside = Panel::new("time t (s)", format!("error ({length})"))
                    .title("its error")
                    .line("simulated less measured", Colour::Green.width(1.2), errors);
                figure = figure.panel(panel).panel(beside);
            }
        }
        print_error(part, "all", &all.simulated);
        println!();
    }
    table.finish()?;
    #[cfg(feature = "serde")]
    {
        let path = arguments.out_dir().join("identify.toml");
        let text = toml::to_string(&fit.model()?)?;
        // What is written is read again.
        toml::from_str::<mechanism::JointModel>(&text)?.gear()?;
        std::fs::write(&path, text).map_err(|e| format!("cannot write {}: {e}", path.display()))?;
        println!("{}", path.display());
    }
    println!("{}", figure.save(arguments.out_dir(), "identify")?.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_remarks_of_logs_have_the_names_of_their_files() -> Result<(), Box<dyn Error>> {
        let (fitted, held_out) = logs::synthetic()?;
        let report = "fitted    1\n  log 1    2\n  held-out log 0   3\nlog 0 has gaps\nlog 7: no";
        let named = with_files(report, [("log ", &fitted), ("held-out log ", &held_out)]);
        let want = format!(
            "fitted    1\n  {:25} 2\n  {:25} 3\nsmall swings has gaps\nlog 7: no\n",
            "large swings", "predicted log"
        );
        assert_eq!(named, want);
        Ok(())
    }
}
