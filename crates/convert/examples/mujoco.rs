//! A joint with LuGre friction in MuJoCo's four integrators and here: creep below breakaway over
//! the step, and error over processor time where a sine reverses it.
//!
//! MuJoCo's figures are those of `benches/mujoco/creep.py`, which left `creep.csv` and `sine.csv`
//! beside it. Leaves `mujoco.csv` and `mujoco.svg`.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use bristle::companion::{PointMass, VelocityHistory};
use bristle::curve::Stribeck;
use bristle::ode::{self, Output};
use bristle::rheology::KelvinVoigt;
use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
use bristle::signal::{Signal, Sine, SineParameters};
use bristle::{Bristle, Contact, LuGre, Mechanism};
use bristle_charts::{
    Arguments, Colour, Csv, Figure, Marker, Panel, Result, Rule, Way, println, read_columns,
};
use bristle_convert::MujocoDcMotor;

const INERTIA: f64 = 0.01; // kg m²
const STIFFNESSES: [f64; 3] = [1e4, 1e5, 1e6]; // N m/rad
/// Creep below it [rad] is drawn there: the joint stands.
const STANDS: f64 = 1e-10;
/// What is lost is drawn there.
const LOST: f64 = 100.0;
const SAMPLES: usize = 20;

type Friction = LuGre<Stribeck<f64>, KelvinVoigt<f64>>;

const THEIRS: [Way<&str>; 4] = [
    Way::new("Euler", "Euler", "MuJoCo, Euler", Colour::Orange, Marker::Disc),
    Way::new("RK4", "RK4", "MuJoCo, RK4", Colour::Blue, Marker::Square),
    Way::new(
        "implicitfast",
        "implicitfast",
        "MuJoCo, implicitfast",
        Colour::Purple,
        Marker::Diamond,
    ),
    Way::new("implicit", "implicit", "MuJoCo, implicit", Colour::Black, Marker::Triangle),
];

/// How a step of ours learns its velocity.
#[derive(Clone, Copy)]
enum Step {
    /// The last velocity, held over the step.
    Hold,
    Companion,
}

const OURS: [Way<Step>; 2] = [
    Way::new(Step::Hold, "hold", "hold, fed back", Colour::Sky, Marker::Disc),
    Way::new(Step::Companion, "companion", "companion", Colour::Green, Marker::Disc),
];

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../benches/mujoco");
        let arguments = Arguments::new("mujoco", "LuGre friction in MuJoCo and here")
            .text("folder", beside, "where creep.csv and sine.csv are")
            .count("runs", 15, "of which the least time counts")
            .must_be(Rule::Between(1.0, 1e4))
            .parse()?;
        let folder = PathBuf::from(arguments.text("folder"));
        let columns = ["panel", "method", "x", "y"];
        let mut table = Csv::create(arguments.out_dir(), "mujoco", &columns)?;
        let mut figure = Figure::new(980, 820).columns(2);
        for stiffness in STIFFNESSES {
            figure = figure.panel(creep(&folder.join("creep.csv"), stiffness, &mut table)?);
        }
        let panel = sine(&folder.join("sine.csv"), arguments.count("runs"), &mut table)?;
        table.finish()?;
        let figure = figure
            .title("A joint with LuGre friction, in MuJoCo and here")
            .note(
                "On the upper border: the run was lost. On the lower one of (a) to (c): it stands. \
                 implicitfast lies below implicit. Times of MuJoCo are of its whole step.",
            )
            .panel(panel);
        println!("{}", figure.save(arguments.out_dir(), "mujoco")?.display());
        Ok(())
    })
}

fn joint(stiffness: f64) -> Result<Contact<f64, Friction>> {
    let motor = MujocoDcMotor {
        stiffness,
        damping: (INERTIA * stiffness).sqrt(),
        coulomb_friction: 1.0,
        static_friction: 1.5,
        stribeck_velocity: 0.1,
        viscous_damping: 0.0,
    };
    Ok(LuGre::classical(motor.curve()?, motor.bristle()?).under_load(1.0)?)
}

/// Positions \[rad\] every 2 s/`samples`, under a torque that is given at the middle of each step.
fn run(
    way: Step,
    contact: Contact<f64, Friction>,
    torque: impl Fn(f64) -> f64,
    step: f64,
    samples: usize,
) -> Result<Vec<f64>> {
    let joint = contact.companion(0.1)?;
    let (mut x, mut v, mut z, mut history) = (0.0, 0.0, 0.0, VelocityHistory::new(0.0));
    let (count, mut places) = ((2.0 / step).round() as usize, Vec::with_capacity(samples));
    for n in 0..count {
        let force = torque((n as f64 + 0.5) * step);
        match way {
            Step::Hold => {
                let held = joint.contact().hold(v, z, step);
                v += step * (force - held.mean_force) / INERTIA;
                (x, z) = (x + step * v, held.deflection);
            }
            Step::Companion => {
                let friction = joint.step(history.predict(), z, step);
                let body = PointMass { mass: INERTIA, velocity: v, force, end_weight: 0.5 };
                let mean = friction.point_mass(body);
                (x, v) = (x + step * mean, 2.0 * mean - v);
                z = friction.commit(mean).deflection;
                history.push(v);
            }
        }
        if (n + 1) % (count / samples) == 0 {
            places.push(x);
        }
    }
    Ok(places)
}

fn scene<F: Signal<f64>>(stiffness: f64, force: F) -> Result<MassSpringDamper<f64, Friction, F>> {
    Ok(MassSpringDamper::new(MassSpringDamperParameters {
        contact: joint(stiffness)?,
        mechanism: Mechanism { mass: INERTIA, spring_stiffness: 0.0, viscous_damping: 0.0 },
        drive_velocity: 0.0,
        force,
    })?)
}

/// The lines of a table of MuJoCo's that a method wrote, with columns of numbers.
fn written(path: &Path, method: &str, columns: &str) -> Result<Vec<Vec<f64>>> {
    let text = std::fs::read_to_string(path)?;
    let which: Vec<bool> =
        text.lines().skip(1).map(|line| line.split(',').next() == Some(method)).collect();
    let columns = read_columns(path, columns)?;
    let rows = which.iter().enumerate().filter(|(_, own)| **own);
    Ok(rows.map(|(row, _)| columns.iter().map(|column| column.1[row]).collect()).collect())
}

/// How far the joint moves between 1 s and 2 s under a third of breakaway.
fn creep(path: &Path, stiffness: f64, table: &mut Csv) -> Result<Panel> {
    let label = format!("creep, σ_0 = {:.0e} N m/rad", stiffness);
    let mut panel = Panel::new("step h (s)", "x(2 s) − x(1 s) (rad)").title(label);
    panel = panel.log_x().log_y().y_range(0.3 * STANDS..=3.0 * LOST);
    let drawn = |creep: f64| creep.abs().clamp(STANDS, LOST);
    let name = format!("creep {stiffness:e}");
    for way in THEIRS {
        let chosen = "k=stiffness,h=step,a=place_1s,b=place_2s,reset=reset";
        let rows = written(path, way.scheme, chosen)?;
        let rows = rows.iter().filter(|row| row[0] == stiffness);
        let points: Vec<_> = rows
            .map(|row| (row[1], if row[4] > 0.0 { LOST } else { drawn(row[3] - row[2]) }))
            .collect();
        points.iter().try_for_each(|&(x, y)| table.row(&[&name, way.name], &[x, y]))?;
        panel = panel.marked_line(way.label, way.colour, way.colour.marked(way.marker), points);
    }
    for way in OURS {
        let mut points = Vec::new();
        for step in [5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4] {
            let places = run(way.scheme, joint(stiffness)?, |_| 0.5, step, 2)?;
            let creep = places[1] - places[0];
            points.push((step, if creep.is_finite() { drawn(creep) } else { LOST }));
        }
        points.iter().try_for_each(|&(x, y)| table.row(&[&name, way.name], &[x, y]))?;
        panel = panel.marked_line(way.label, way.colour, way.colour.marked(way.marker), points);
    }
    let block = scene(stiffness, 0.5)?;
    let solved = ode::solve(&block, 0.0..2.0, block.at_rest(), 1e-6, Output::Uniform(3))?;
    let creep = solved.states()[2][0] - solved.states()[1][0];
    println!("σ0 = {stiffness:e} N m/rad: ode::solve at 1e-6 creeps {creep:.1e} rad");
    Ok(panel.horizontal(STANDS, ""))
}

/// Error of the position under 2 sin(2πt) N m over the time of 2 s.
fn sine(path: &Path, runs: usize, table: &mut Csv) -> Result<Panel> {
    let force = SineParameters { mean: 0.0, amplitude: 2.0, frequency: 1.0, phase: 0.0 };
    let block = scene(1e4, Sine::new(force)?)?;
    let solve = |tolerance| -> Result<Vec<f64>> {
        let span = (0.0..2.0, block.at_rest());
        let run = ode::solve(&block, span.0, span.1, tolerance, Output::Uniform(SAMPLES + 1))?;
        Ok(run.states()[1..].iter().map(|state| state[0]).collect())
    };
    let reference = solve(1e-10)?;
    let error = |places: &[f64]| {
        let pairs = places.iter().zip(&reference).map(|(x, exact)| (x - exact).abs());
        let worst = pairs.fold(0.0, |worst, off| if off <= worst { worst } else { off });
        if worst < 1.0 { worst } else { f64::NAN }
    };
    let mut panel = Panel::new("processor time (s)", "largest error of x (rad)")
        .title("a sine of 2 N m, σ_0 = 1e4 N m/rad")
        .log_x()
        .log_y();
    let columns = (1..=SAMPLES).map(|n| format!(",x{n}=x{n}")).collect::<String>();
    for way in THEIRS {
        let rows = written(path, way.scheme, &format!("cpu=cpu{columns}"))?;
        let points: Vec<_> = rows.iter().map(|row| (row[0], error(&row[1..]))).collect();
        points.iter().try_for_each(|&(x, y)| table.row(&["sine", way.name], &[x, y]))?;
        panel = panel.marked_line(way.label, way.colour, way.colour.marked(way.marker), points);
    }
    let timed = |task: &dyn Fn() -> Result<Vec<f64>>| -> Result<(f64, f64)> {
        let (mut least, mut places) = (f64::INFINITY, Vec::new());
        for _ in 0..runs {
            let start = Instant::now();
            places = task()?;
            least = least.min(start.elapsed().as_secs_f64());
        }
        Ok((least, error(&places)))
    };
    for way in OURS {
        let mut points = Vec::new();
        for step in [2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5] {
            let torque = |t: f64| 2.0 * (TAU * t).sin();
            points.push(timed(&|| run(way.scheme, joint(1e4)?, torque, step, SAMPLES))?);
        }
        points.iter().try_for_each(|&(x, y)| table.row(&["sine", way.name], &[x, y]))?;
        panel = panel.marked_line(way.label, way.colour, way.colour.marked(way.marker), points);
    }
    let tolerances = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];
    let points =
        tolerances.iter().map(|&it| timed(&|| solve(it))).collect::<Result<Vec<(f64, f64)>>>()?;
    points.iter().try_for_each(|&(x, y)| table.row(&["sine", "solve"], &[x, y]))?;
    let colour = Colour::Vermilion;
    Ok(panel.marked_line("ode::solve", colour, colour.marked(Marker::Disc), points))
}
