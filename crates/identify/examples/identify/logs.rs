//! Logs from files, and those of a known joint.

use std::error::Error;
use std::path::Path;
use std::str::FromStr;

use bristle::signal::Function;
use bristle::{Dahl, DahlParameters};
use bristle_identify::mechanism::{Drive, DriveLog, DriveLogParameters, KnownLoad};
use bristle_joint::{GearFriction, GearFrictionParameters, TorqueLoad, TorqueLoadParameters};
use bristle_joint::{GearedJoint, GearedJointParameters, Gravity, JointState};

use bristle_charts::{Values, println};

/// A log and the name of its file.
pub(crate) struct Named {
    pub(crate) name: String,
    pub(crate) log: DriveLog,
}

/// The logs alone.
pub(crate) fn logs(named: &[Named]) -> Vec<DriveLog> {
    named.iter().map(|named| named.log.clone()).collect()
}

/// Columns that are taken, by these names.
const COLUMNS: [&str; 10] = [
    "time",
    "position",
    "velocity",
    "torque",
    "current",
    "voltage",
    "goal",
    "supply",
    "enabled",
    "external_torque",
];

/// Those that drive the joint.
const DRIVES: [&str; 4] = ["torque", "current", "voltage", "goal"];

/// Reads logs from files.
pub(crate) fn read(files: &[&Path], arguments: &Values) -> Result<Vec<Named>, Box<dyn Error>> {
    let one = |path: &&Path| -> Result<Named, Box<dyn Error>> {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let log = read_one(path, &stem, arguments);
        let log = log.map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Named { name: stem.into_owned(), log })
    };
    files.iter().map(one).collect()
}

fn read_one(path: &Path, stem: &str, arguments: &Values) -> Result<DriveLog, Box<dyn Error>> {
    let given = arguments.text("columns");
    let mut choice: Vec<String> =
        given.split(',').filter(|part| !part.is_empty()).map(str::to_owned).collect();
    let is_given = |name: &str| given.split(',').any(|part| part.split('=').next() == Some(name));
    let names = bristle_charts::read_names(path)?;
    for wanted in COLUMNS.into_iter().filter(|name| !is_given(name)) {
        // Of several drives the one that was chosen.
        if DRIVES.contains(&wanted) && DRIVES.iter().any(|drive| is_given(drive)) {
            continue;
        }
        let fits = |name: &&String| {
            let rest = name.to_lowercase().strip_prefix(wanted).map(str::to_owned);
            // What follows is the unit.
            rest.is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
        };
        if let Some(name) = names.iter().find(fits) {
            choice.push(format!("{wanted}={name}"));
        }
    }
    let columns = bristle_charts::read_columns(path, &choice.join(","))?;
    let find = |wanted: &str| {
        let found = columns.iter().find(|(name, _)| name == wanted);
        found.map(|(_, column)| column.as_slice())
    };
    let need = |wanted: &str| {
        find(wanted).ok_or_else(|| {
            let names = names.join(", ");
            format!("no column {wanted:?} among {names}; --columns {wanted}=COLUMN chooses one")
        })
    };
    let (time, position) = (need("time")?, need("position")?);
    let known = |option: &str| match arguments.text(option) {
        "" => Ok(0.0),
        text => by_name(option, text, stem),
    };
    let mut supply = Vec::new();
    let drive = match DRIVES.map(find) {
        [Some(torque), None, None, None] => Drive::Torque(torque),
        [None, Some(current), None, None] => Drive::Current(current),
        [None, None, Some(voltage), None] => Drive::Voltage(voltage),
        [None, None, None, Some(goal)] => {
            match find("supply") {
                Some(measured) => supply.extend(measured),
                None => supply.resize(time.len(), arguments.number("supply")),
            }
            Drive::Duty {
                goal,
                gain: by_name("gain", arguments.text("gain"), stem)?,
                derivative_gain: known("derivative-gain")?,
                supply: &supply,
            }
        }
        [None, None, None, None] => {
            return Err("needs a column torque, current, voltage or goal".into());
        }
        _ => return Err("has several drives: choose one, as by --columns torque=NAME".into()),
    };
    let enabled: Option<Vec<bool>> =
        find("enabled").map(|column| column.iter().map(|&value| value > 0.5).collect());
    let (held, noisy) = match arguments.text("between-rows") {
        "linear" => (false, true),
        "held" => (true, true),
        "command" => (true, false),
        other => return Err(format!("--between-rows has no {other:?}").into()),
    };
    let load =
        KnownLoad { inertia: known("load-inertia")?, gravity_torque: known("load-gravity")? };
    let log = DriveLog::new(DriveLogParameters {
        held,
        noisy,
        delay: arguments.number("delay"),
        load,
        velocity: find("velocity"),
        external_torque: find("external_torque"),
        enabled: enabled.as_deref(),
        ..DriveLogParameters::new(time, position, drive)
    })?;
    match by_name::<String>("begin", arguments.text("begin"), stem)?.as_str() {
        "rest" => Ok(log),
        "motion" => Ok(log.in_motion()),
        other => Err(format!("--begin has no {other:?}").into()),
    }
}

/// A value for all files, or that of the first part which the name of the file has.
fn by_name<T: FromStr>(option: &str, text: &str, stem: &str) -> Result<T, Box<dyn Error>> {
    let values = text.split(',').map(|part| part.split_once('=').unwrap_or(("", part)));
    let found = values.into_iter().find(|(part, _)| stem.contains(part));
    found.and_then(|(_, value)| value.parse().ok()).ok_or_else(|| {
        format!("--{option} must be VALUE or PART=VALUE,…, but {text:?} was given").into()
    })
}

/// The last third of every log is held out, unless the joint stands still in one of the parts.
pub(crate) fn split(whole: Vec<Named>) -> (Vec<Named>, Vec<Named>) {
    let (mut fitted, mut held_out) = (Vec::new(), Vec::new());
    for Named { name, log } in whole {
        let times = log.times();
        let at = times.get(times.len() * 2 / 3).copied().unwrap_or(0.0);
        if let (Ok(first), Ok(last)) = (log.between(f64::MIN, at), log.between(at, f64::MAX)) {
            held_out.push(Named { name: format!("{name}, last third"), log: last });
            fitted.push(Named { name, log: first });
        } else {
            println!("{name} is fitted whole: it is short, or stands still for a third");
            fitted.push(Named { name, log });
        }
    }
    (fitted, held_out)
}

/// Of the encoder.
const COUNTS: f64 = 4096.0;
/// Standard deviation of the torque's noise [N m].
const NOISE: f64 = 0.01;

/// Two logs of a known joint, and a third to be predicted: 6 s at 200 Hz, a motor that swings a
/// pendulum through a gear.
pub(crate) fn synthetic() -> Result<(Vec<Named>, Vec<Named>), Box<dyn Error>> {
    println!(
        "logs of a known joint: inertia 0.008 kg m², gravity 0.5 N m, drag 0.01 N m s/rad,\n\
         Coulomb torque 0.05 N m, load factors 0.2 (motor) and 0.1 (external), \
         stiffness 200 1/rad;\n\
         {COUNTS} counts a turn, noise {NOISE} N m\n"
    );
    let mut noise = bristle_charts::noise();
    let mut log = |name: &str, swing: f64, phase: f64| -> Result<Named, Box<dyn Error>> {
        let load = TorqueLoadParameters { idle_load: 0.05, motor_share: 0.2, external_share: 0.1 };
        let friction = DahlParameters { dynamic_coefficient: 1.0, micro_stiffness: 200.0 };
        let gear = GearFriction::new(GearFrictionParameters {
            friction: Dahl::new(friction)?,
            load: TorqueLoad::new(load)?,
            reference_load: load.idle_load,
            drag: 0.01,
            fastest: 20.0,
        })?;
        let torque = |t: f64| swing * (2.0 * t + phase).sin() + 0.2 * ((0.6 * t + 3.0) * t).sin();
        let joint = GearedJoint::new(GearedJointParameters {
            gear,
            inertia: 0.008,
            motor: Function::new(move |t: f64| (torque(t), 0.0), []),
            external: Gravity { horizontal_torque: 0.5, hanging_angle: 0.0 },
        })?;
        let mut state = JointState::at_rest(0.0);
        let (mut time, mut position, mut measured) = (vec![], vec![], vec![]);
        let count = 2.0 * std::f64::consts::PI / COUNTS;
        for millisecond in 0..6000 {
            if millisecond % 5 == 0 {
                time.push(state.time);
                position.push((state.angle / count).round() * count);
                measured.push(torque(state.time) + NOISE * noise());
            }
            state = joint.step(&state, 1e-3)?.0;
        }
        let drive = Drive::Torque(&measured);
        let log = DriveLog::new(DriveLogParameters::new(&time, &position, drive))?;
        Ok(Named { name: name.to_owned(), log })
    };
    let fitted = vec![log("small swings", 0.1, 0.0)?, log("large swings", 0.35, 1.0)?];
    Ok((fitted, vec![log("predicted log", 0.25, 2.0)?]))
}
