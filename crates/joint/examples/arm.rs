//! An arm lifts itself, holds, and is switched off. The friction of its gears follows the torques
//! through them. A constant load, the mean of what the gears carry while they hold, brakes the
//! falling arm too much.
//!
//! Two links stand below; `--links FILE` reads a table of any number of them, with the columns mass
//! [kg], length and centre [m], inertia and rotor [kg m²], torque [N m], the largest of the motor,
//! and lifted [rad], the angle that the joint is lifted to.
//!
//! Leaves `arm.csv` and `arm.svg`, angles and friction torques over time.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{FrBd, ParameterError};
use bristle_analysis::ledger::EnergyLedger;

use bristle_charts::{Arguments, Csv, Figure, Panel, Rule, Stroke, println, read_columns};
use bristle_joint::{
    GearFriction, GearFrictionParameters, GearTorques, TorqueLoad, TorqueLoadParameters,
};
use bristle_mechanism::{Arm, ArmMotion, ArmParameters, ContactState, Link, on_joint};

/// A link, the largest torque of its motor [N m] and the angle it is lifted to [rad].
struct Driven {
    link: Link<f64>,
    torque: f64,
    lifted: f64,
}

/// Two slender rods: the upper is lifted above the horizontal, the lower one bent upwards.
fn two_links() -> Vec<Driven> {
    let (mass, length) = (1.0, 0.3);
    let inertia = mass * length * length / 12.0;
    let link = Link { mass, length, centre: 0.15, inertia, rotor: 0.01, damping: DRAG };
    [1.75, 0.5].map(|lifted| Driven { link, torque: 15.0, lifted }).into()
}

fn links_of(file: &Path) -> Result<Vec<Driven>, Box<dyn Error>> {
    let names = ["mass", "length", "centre", "inertia", "rotor", "torque", "lifted"];
    let choice = names.map(|name| format!("{name}={name}")).join(",");
    let columns = read_columns(file, &choice)?;
    let rows = columns.first().map_or(0, |(_, first)| first.len());
    let row = |row: usize| {
        let [mass, length, centre, inertia, rotor, torque, lifted] =
            std::array::from_fn(|column| columns[column].1[row]);
        let link = Link { mass, length, centre, inertia, rotor, damping: DRAG };
        Driven { link, torque, lifted }
    };
    Ok((0..rows).map(row).collect())
}

const GRAVITY: f64 = 9.81;
/// Drag of each gear [N m s/rad].
const DRAG: f64 = 0.05;

/// Load of the gears [N m] at which their stiffness was measured.
const REFERENCE_LOAD: f64 = 5.0;

/// Gains of the position controllers over their largest torque [1/rad, s/rad].
const GAINS: [f64; 2] = [200.0 / 15.0, 8.0 / 15.0];

/// When the arm has been lifted, and when its motors are switched off [s].
const LIFTED: f64 = 2.0;
const SWITCHED_OFF: f64 = 4.0;

type Gear = GearFriction<f64, FrBd<Stribeck<f64>, KelvinVoigt<f64>>, TorqueLoad<f64>>;

fn gear(load: TorqueLoadParameters<f64>) -> Result<Gear, ParameterError> {
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: 0.15,
        dynamic_coefficient: 0.1,
        stribeck_velocity: 0.05, // rad/s
        stribeck_exponent: 1.0,
        viscous_friction: 0.0,
    })?;
    let bristle = KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness: 300.0, // 1/rad
        micro_damping: 1.0,     // s/rad
    })?;
    GearFriction::new(GearFrictionParameters {
        friction: FrBd::new(curve, bristle),
        load: TorqueLoad::new(load)?,
        reference_load: REFERENCE_LOAD,
        drag: DRAG,
        fastest: 20.0,
    })
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("arm", "Links whose gears feel their load")
            .files("links", "table of links, instead of two")
            .number("step", 1e-3, "s", "length of a step")
            .must_be(Rule::Between(1e-6, 5e-3))
            .number("end", 9.0, "s", "end of the simulated time")
            .must_be(Rule::Between(SWITCHED_OFF, 1e3))
            .parse()?;
        let (h, end) = (arguments.number("step"), arguments.number("end"));

        let links = match arguments.files("links")[..] {
            [] => two_links(),
            [file, ..] => links_of(file)?,
        };
        let joints = 0..links.len();

        let following =
            TorqueLoadParameters { idle_load: 1.0, motor_share: 1.0, external_share: 0.6 };
        let following = gear(following)?;
        let followed = run(&links, &vec![following; links.len()], h, end)?;
        // The mean load of each gear while the arm is held.
        let gears = joints.clone().map(|joint| {
            let held = followed.rows.iter();
            let held = held.filter(|row| (LIFTED..SWITCHED_OFF).contains(&row.time));
            let (sum, count) =
                held.fold((0.0, 0.0), |(sum, count), row| (sum + row.of[LOAD][joint], count + 1.0));
            let idle_load = sum / count;
            gear(TorqueLoadParameters { idle_load, motor_share: 0.0, external_share: 0.0 })
        });
        let kept = run(&links, &gears.collect::<Result<Vec<_>, _>>()?, h, end)?;

        println!("{}", following.audit(1.0, 5.0)?);
        let columns = ["q", "v", "p", "friction"];
        let columns = columns.map(|name| joints.clone().map(move |i| format!("{name}{}", i + 1)));
        let columns: Vec<_> = columns.into_iter().flatten().collect();
        let columns: Vec<_> =
            ["load", "t"].into_iter().chain(columns.iter().map(String::as_str)).collect();
        let mut table = Csv::create(arguments.out_dir(), "arm", &columns)?;
        let runs = [("follows torques", &followed), ("constant", &kept)];
        println!("load of the gears  dissipated  returned beyond the stored  angles at the end");
        for (name, run) in runs {
            let Some(last) = run.rows.last() else { continue };
            let angles = last.of[ANGLE].iter().map(|q| format!("{:8.2}°", q.to_degrees()));
            let (dissipated, gain) = (run.ledger.total().dissipated, run.ledger.gain());
            let angles: String = angles.collect();
            println!("{name:17}  {dissipated:8.4} J  {gain:24.1e} J {angles}");
            for Row { time, of } in &run.rows {
                let numbers = std::iter::once(*time).chain(of.iter().flatten().copied());
                table.row(&[name], &numbers.collect::<Vec<_>>())?;
            }
        }
        table.finish()?;
        println!("{}", chart(&runs).save(arguments.out_dir(), "arm")?.display());
        Ok(())
    })
}

fn chart(runs: &[(&'static str, &Run)]) -> Figure {
    let figure = Figure::new(900, 430).columns(2);
    let figure = figure.title("An arm that is lifted, held, and switched off at 4 s");
    let angles =
        Panel::new("time t (s)", "angles q_1, q_2 (°)").title("angles of both joints").own_legend();
    let torques =
        Panel::new("time t (s)", "torque (N m)").title("friction torque at q_1").own_legend();
    let mut panels = [angles, torques];
    for (name, run) in runs {
        let [mut angles, mut torques] = panels;
        let stroke = |joint| match *name {
            "constant" => Stroke::nth(joint).colour.dashed(),
            _ => Stroke::nth(joint),
        };
        let over_time = |of: &dyn Fn(&Row) -> f64| -> Vec<(f64, f64)> {
            run.rows.iter().step_by(5).map(|row| (row.time, of(row))).collect()
        };
        for joint in 0..run.rows.first().map_or(0, |row| row.of[ANGLE].len()) {
            let points = over_time(&|row| row.of[ANGLE][joint].to_degrees());
            angles = angles.line(format!("q_{}, load {name}", joint + 1), stroke(joint), &points);
        }
        torques =
            torques.line(format!("load {name}"), stroke(0), over_time(&|row| row.of[FRICTION][0]));
        panels = [angles, torques];
    }
    let [angles, torques] = panels;
    figure.panel(angles).panel(torques)
}

/// Time, and what each joint has there.
struct Row {
    time: f64,
    of: [Vec<f64>; 4],
}

const ANGLE: usize = 0;
const LOAD: usize = 2;
const FRICTION: usize = 3;

struct Run {
    rows: Vec<Row>,
    /// The energy of all gears.
    ledger: EnergyLedger<f64>,
}

fn run(links: &[Driven], gears: &[Gear], h: f64, end: f64) -> Result<Run, ParameterError> {
    let n = links.len();
    let rigid: Vec<_> = links.iter().map(|driven| driven.link).collect();
    let parameters = ArmParameters { links: &rigid, gravity: GRAVITY };
    let mut arm = Arm::on_heap(&parameters, (0..n).map(on_joint).collect::<Vec<_>>())?;
    let companions = gears.iter().map(|gear| gear.contact().companion(20.0));
    let companions = companions.collect::<Result<Vec<_>, _>>()?;
    let new = |companion| ContactState::new(companion, 0.0);
    let mut contacts: Vec<_> = companions.iter().map(new).collect();
    let [mut q, mut v, mut a] = [(); 3].map(|()| vec![0.0; n]);
    let (mut rows, mut ledger) = (Vec::new(), EnergyLedger::new());
    for step in 0..(end / h).round() as u32 {
        let time = h * (f64::from(step) + 0.5);
        let motion = ArmMotion { position: &mut q, velocity: &mut v, acceleration: &mut a };
        arm.step(h, motion, &companions, &mut contacts, |middle| {
            for (i, (driven, gear)) in links.iter().zip(gears).enumerate() {
                let motor = controller(time, driven, middle.position[i], middle.velocity[i]);
                let external = middle.gravity[i];
                middle.torque[i] = motor;
                middle.load[i] = gear.load(GearTorques { motor, external });
            }
        })?;
        contacts.iter().for_each(|contact| ledger.enter(contact.last_step()));
        let loads = contacts.iter().map(ContactState::load).collect();
        let friction = contacts.iter().map(|contact| contact.last_step().force).collect();
        let of = [q.clone(), v.clone(), loads, friction];
        rows.push(Row { time: h * f64::from(step + 1), of });
    }
    Ok(Run { rows, ledger })
}

/// A motor's torque: position control towards a smooth lift, nothing after switching off.
fn controller(time: f64, driven: &Driven, q: f64, v: f64) -> f64 {
    if time > SWITCHED_OFF {
        return 0.0;
    }
    let part = (time / LIFTED).min(1.0);
    let reference = driven.lifted * (part * part * (3.0 - 2.0 * part));
    let share = GAINS[0] * (reference - q) - GAINS[1] * v;
    driven.torque * share.clamp(-1.0, 1.0)
}
