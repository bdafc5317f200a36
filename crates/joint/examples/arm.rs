//! An arm of two links lifts itself, holds, and is switched off. The friction of its gears follows
//! the torques through them. A constant load, the mean of what the gears carry while they hold,
//! brakes the falling arm too much.
//!
//! Over each step both gears are a source and a damper, and the two joints one linear system for
//! their mean velocities:
//!
//! (2/h M(q) + diag(damping)) v̄ = 2/h M(q) v₀ + τ_m − g(q) − c(q, v) − bias
//!
//! Leaves `arm.csv` and `arm.svg`, angles and friction torques over time.

use std::process::ExitCode;

use bristle::companion::VelocityHistory;
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{FrBd, ParameterError};
use bristle_analysis::ledger::EnergyLedger;
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, println};
use bristle_joint::{
    GearFriction, GearFrictionParameters, GearTorques, LoadedDeflection, TorqueLoad,
    TorqueLoadParameters,
};
use nalgebra::{Matrix2, Vector2};

/// Mass [kg], length [m] and distance of the centre of mass from the axis [m] of each link; both
/// are slender rods.
const MASS: f64 = 1.0;
const LENGTH: f64 = 0.3;
const CENTRE: f64 = 0.15;
/// Moment of inertia of each motor at its joint [kg m²].
const ROTOR: f64 = 0.01;
const GRAVITY: f64 = 9.81;

/// Load of the gears [N m] at which their stiffness was measured.
const REFERENCE_LOAD: f64 = 5.0;

/// Gains of the position controllers [N m/rad, N m s/rad] and their largest torque [N m].
const GAINS: [f64; 2] = [200.0, 8.0];
const LARGEST_TORQUE: f64 = 15.0;

/// When the arm has been lifted, and when its motors are switched off [s].
const LIFTED: f64 = 2.0;
const SWITCHED_OFF: f64 = 4.0;
/// What it is lifted to [rad]: the upper link above the horizontal, the lower one bent upwards.
const LIFTED_TO: [f64; 2] = [1.75, 0.5];

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
        drag: 0.05, // N m s/rad
        fastest: 20.0,
    })
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("arm", "Two links whose gears feel their load")
            .number("step", 1e-3, "s", "length of a step")
            .must_be(Rule::Between(1e-6, 5e-3))
            .number("end", 9.0, "s", "end of the simulated time")
            .must_be(Rule::Between(SWITCHED_OFF, 1e3))
            .parse()?;
        let (h, end) = (arguments.number("step"), arguments.number("end"));

        let following =
            TorqueLoadParameters { idle_load: 1.0, motor_share: 1.0, external_share: 0.6 };
        let followed = run([gear(following)?, gear(following)?], h, end)?;
        // The mean load of each gear while the arm is held.
        let mean_load = |joint: usize| {
            let held: Vec<f64> = followed
                .rows
                .iter()
                .filter(|row| (LIFTED..SWITCHED_OFF).contains(&row.time))
                .map(|row| row.load[joint])
                .collect();
            held.iter().sum::<f64>() / held.len() as f64
        };
        let constant = |joint| TorqueLoadParameters {
            idle_load: mean_load(joint),
            motor_share: 0.0,
            external_share: 0.0,
        };
        let kept = run([gear(constant(0))?, gear(constant(1))?], h, end)?;

        println!("{}", gear(following)?.audit(1.0, 5.0)?);
        println!("load of the gears  angles at the end     dissipated  returned beyond the stored");
        let columns = ["load", "t", "q1", "q2", "v1", "v2", "p1", "p2", "friction1", "friction2"];
        let mut table = Csv::create(arguments.out_dir(), "arm", &columns)?;
        let runs = [("follows torques", &followed), ("constant", &kept)];
        for (name, run) in runs {
            let Some(last) = run.rows.last() else { continue };
            let [first, second] = [last.angle[0], last.angle[1]].map(f64::to_degrees);
            println!(
                "{name:17}  {first:7.2}° {second:7.2}°  {:11.4} J  {:.1e} J",
                run.ledger.total().dissipated,
                run.ledger.gain()
            );
            for Row { time, angle, velocity, load, friction } in &run.rows {
                let pairs = [angle, velocity, load, friction];
                let pairs = pairs.iter().flat_map(|pair| pair.iter().copied());
                table.row(&[name], &std::iter::once(*time).chain(pairs).collect::<Vec<_>>())?;
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
        let colours = match *name {
            "constant" => [Colour::Blue.dashed(), Colour::Orange.dashed()],
            _ => [Colour::Blue.into(), Colour::Orange.into()],
        };
        let [mut angles, mut torques] = panels;
        let over_time = |of: &dyn Fn(&Row) -> f64| -> Vec<(f64, f64)> {
            run.rows.iter().step_by(5).map(|row| (row.time, of(row))).collect()
        };
        for (joint, colour) in colours.into_iter().enumerate() {
            let points = over_time(&|row| row.angle[joint].to_degrees());
            angles = angles.line(format!("q_{}, load {name}", joint + 1), colour, &points);
        }
        torques =
            torques.line(format!("load {name}"), colours[0], over_time(&|row| row.friction[0]));
        panels = [angles, torques];
    }
    let [angles, torques] = panels;
    figure.panel(angles).panel(torques)
}

/// One step of both joints.
struct Row {
    time: f64,
    angle: Vector2<f64>,
    velocity: Vector2<f64>,
    load: Vector2<f64>,
    friction: Vector2<f64>,
}

struct Run {
    rows: Vec<Row>,
    /// The energy of both gears.
    ledger: EnergyLedger<f64>,
}

fn run(gears: [Gear; 2], h: f64, end: f64) -> Result<Run, ParameterError> {
    let (mut q, mut v) = (Vector2::zeros(), Vector2::zeros());
    let mut z = [LoadedDeflection::none(); 2];
    let mut history = [VelocityHistory::new(0.0); 2];
    let (mut rows, mut ledger) = (Vec::new(), EnergyLedger::new());
    for n in 0..(end / h).round() as u32 {
        let time = h * (f64::from(n) + 0.5);
        // Everything at the middle of the step, as predicted.
        let predicted = Vector2::from(history.map(|history| history.predict()));
        let middle = q + 0.5 * h * predicted;
        let mass = inertia(middle);
        let (weight, coupling) = (gravity(middle), coriolis(middle, predicted));
        let motor = controller(time, middle, predicted);

        let mut matrix = 2.0 / h * mass;
        let mut right = matrix * v + motor - weight - coupling;
        let mut begin = |joint: usize| {
            let torques = GearTorques { motor: motor[joint], external: -weight[joint] };
            let step = gears[joint].step(torques, predicted[joint], z[joint], h)?;
            matrix[(joint, joint)] += step.damping();
            right[joint] -= step.bias();
            Ok::<_, ParameterError>(step)
        };
        let steps = [begin(0)?, begin(1)?];
        // Positive definite: it always has a solution.
        let Some(mean) = matrix.cholesky().map(|matrix| matrix.solve(&right)) else { break };

        let done = [0, 1].map(|joint| steps[joint].commit(mean[joint]));
        for joint in 0..2 {
            z[joint] = done[joint].deflection;
            ledger.enter(done[joint]);
        }
        q += h * mean;
        v = 2.0 * mean - v;
        for (history, velocity) in history.iter_mut().zip(v.iter()) {
            history.push(*velocity);
        }
        rows.push(Row {
            time: h * f64::from(n + 1),
            angle: q,
            velocity: v,
            load: Vector2::from(z.map(|z| z.load)),
            friction: Vector2::from(done.map(|done| done.force)),
        });
    }
    Ok(Run { rows, ledger })
}

/// M(q) of two slender rods and their motors; the angle of the second link is that to the first.
fn inertia(q: Vector2<f64>) -> Matrix2<f64> {
    let rod = MASS * LENGTH * LENGTH / 12.0;
    let (own, arm) = (rod + MASS * CENTRE * CENTRE, MASS * LENGTH * CENTRE * q[1].cos());
    let first = own + own + MASS * LENGTH * LENGTH + 2.0 * arm + ROTOR;
    Matrix2::new(first, own + arm, own + arm, own + ROTOR)
}

/// c(q, v): the torques of centrifugal and Coriolis forces.
fn coriolis(q: Vector2<f64>, v: Vector2<f64>) -> Vector2<f64> {
    let k = MASS * LENGTH * CENTRE * q[1].sin();
    Vector2::new(-k * (2.0 * v[0] * v[1] + v[1] * v[1]), k * v[0] * v[0])
}

/// g(q): the torques that hold the arm; it hangs at q = 0.
fn gravity(q: Vector2<f64>) -> Vector2<f64> {
    let second = MASS * GRAVITY * CENTRE * (q[0] + q[1]).sin();
    Vector2::new(MASS * GRAVITY * (CENTRE + LENGTH) * q[0].sin() + second, second)
}

/// The motors' torques: position control towards a smooth lift, nothing after switching off.
fn controller(time: f64, q: Vector2<f64>, v: Vector2<f64>) -> Vector2<f64> {
    if time > SWITCHED_OFF {
        return Vector2::zeros();
    }
    let part = (time / LIFTED).min(1.0);
    let reference = Vector2::from(LIFTED_TO) * (part * part * (3.0 - 2.0 * part));
    let torque = GAINS[0] * (reference - q) - GAINS[1] * v;
    torque.map(|torque| torque.clamp(-LARGEST_TORQUE, LARGEST_TORQUE))
}
