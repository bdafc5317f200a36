//! What a file of the example `from_file` holds, and its simulation.

use std::fmt::Display;

use bristle::nalgebra::SVector;
use bristle::ode::{AnyMethod, Output, Solver, StopReason, System, Tolerances, Trajectory};
use bristle::scene::{DiaphragmValve, MassSpringDamper, PrescribedVelocity};
use bristle::signal::Signal;
use bristle::{AnyBristle, ParameterError};
use serde::{Deserialize, Serialize};

use crate::choices::{FileSignal, PlaneModel};
use crate::scenes::{Joint, PlaneBlock, RollingPatch, Surface, Viscoelastic, Wheel};

/// Most rows of a table.
const MOST_SAMPLES: usize = 1_000_000;
/// Most steps of a run.
const MOST_STEPS: u64 = 10_000_000;
/// Most steps of a run times the bristles that take them.
const MOST_WORK: f64 = 1e9;
/// Most periods of a sine over a run.
const MOST_PERIODS: f64 = 1e6;
/// Largest error of fixed steps over the scales.
const MOST_ERROR: f64 = 0.1;
/// What to write instead of a fixed step.
const ADVICE: &str = "a tolerance in its place chooses the steps";

/// What may go wrong: a refused parameter, or a run that stopped.
pub type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// A scene, and how it is solved.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setup {
    /// Time span, method and accuracy.
    pub solver: SolverSetup,
    /// Contact and mechanism.
    pub scene: SceneSetup,
}

/// Time span, method and accuracy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolverSetup {
    /// The run goes from t = 0 to here [s].
    pub end: f64,
    /// Rows of the table, evenly spaced, both ends included.
    pub samples: usize,
    /// The method; `automatic` if it is absent.
    pub method: Option<AnyMethod>,
    /// Tolerance relative to the scale of each state, for adaptive steps; 1e-6 if neither it nor a
    /// step is given.
    pub tolerance: Option<f64>,
    /// Length [s] of fixed steps, in place of a tolerance.
    pub step: Option<f64>,
    /// A run that is broken off after so many steps; the table then has a row for each step.
    #[serde(skip)]
    pub most_steps: Option<u64>,
}

/// Every scene of this crate.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(clippy::large_enum_variant, reason = "there is one")]
pub enum SceneSetup {
    /// A bristle dragged at a given velocity.
    PrescribedVelocity(PrescribedVelocity<f64, AnyBristle<f64>, FileSignal>),
    /// A bristle of several springs dragged at a given velocity.
    Viscoelastic(Viscoelastic),
    /// A mass with a spring, a damper and friction.
    MassSpringDamper(MassSpringDamper<f64, AnyBristle<f64>, FileSignal>),
    /// A pneumatic valve.
    DiaphragmValve(DiaphragmValve<f64, AnyBristle<f64>, FileSignal>),
    /// A wheel that is braked to a stop.
    BrakedWheel(Wheel<AnyBristle<f64>>),
    /// A wheel that is braked and slips sideways.
    SteeredWheel(Wheel<PlaneModel<2>>),
    /// A patch of bristles at a given slip velocity and rolling speed.
    RollingPatch(RollingPatch),
    /// A joint driven by a motor through a gear.
    GearedJoint(Joint),
    /// A body that slides in a plane, on springs whose far ends move.
    PlaneBody(PlaneBlock<2>),
    /// Such a body with its rotation.
    TurningBody(PlaneBlock<3>),
    /// A contact surface of points at a given twist.
    Footprint(Surface),
}

/// A column: its name, the label of its axis, and the factor from SI units to those of the axis.
pub type Column = (&'static str, &'static str, f64);

/// A run as a table: named columns with their labels, and rows that begin with the time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// The columns after the time.
    pub columns: Vec<Column>,
    /// The rows.
    pub rows: Vec<Vec<f64>>,
    /// The error of fixed steps over the scales, where it is known.
    pub error: Option<f64>,
}

pub const FORCE: Column = ("force", "friction force F (N)", 1.0);
pub const BODY: [Column; 3] =
    [("x", "position x (m)", 1.0), ("v", "velocity v (m/s)", 1.0), ("z", "deflection z (µm)", 1e6)];

impl Setup {
    /// Checks the solver's keys and simulates the scene.
    pub fn run(&self) -> Result<Table> {
        let own_steps = match self.scene {
            SceneSetup::BrakedWheel(_) | SceneSetup::SteeredWheel(_) => Some("a braked wheel"),
            SceneSetup::RollingPatch(_) => Some("a rolling patch"),
            SceneSetup::Footprint(_) => Some("a footprint"),
            _ => None,
        };
        self.solver.check(own_steps)?;
        let table = self.simulate()?;
        for row in &table.rows {
            for (column, value) in table.columns.iter().zip(row.iter().skip(1)) {
                if !value.is_finite() {
                    return Err(format!("{} is {value} at t = {} s", column.0, row[0]).into());
                }
            }
        }
        Ok(table)
    }

    /// Simulates the scene.
    pub fn simulate(&self) -> Result<Table> {
        let solver = &self.solver;
        match &self.scene {
            SceneSetup::PrescribedVelocity(scene) => {
                let columns = vec![BODY[1], BODY[2], FORCE];
                solver.admit(System::<f64, 1>::longest_step(scene))?;
                solver.run(scene, SVector::zeros(), columns, |time, state: &SVector<f64, 1>| {
                    vec![scene.velocity(time), state[0], scene.friction_force(time, state)]
                })
            }
            SceneSetup::Viscoelastic(scene) => scene.run(solver),
            SceneSetup::MassSpringDamper(rig) => {
                let columns = [&BODY[..], &[FORCE]].concat();
                solver.admit(rig.parameters().force.longest_step())?;
                solver.run(rig, rig.at_rest(), columns, |_, state| {
                    vec![state[0], state[1], state[2], rig.friction_force(state)]
                })
            }
            SceneSetup::DiaphragmValve(valve) => {
                let parameters = valve.parameters();
                let pressure = ("pressure", "pressure P (kPa)", 1e-3);
                let opening = ("opening", "opening OP (%)", 1.0);
                let columns = [&BODY[..], &[pressure, FORCE, opening]].concat();
                solver.admit(parameters.opening.longest_step())?;
                solver.run(valve, valve.balanced(0.0), columns, |time, state| {
                    let force = valve.friction_force(state);
                    let opening = parameters.opening.value(time);
                    vec![state[0], state[1], state[2], state[3], force, opening]
                })
            }
            SceneSetup::BrakedWheel(wheel) => wheel.run(solver),
            SceneSetup::SteeredWheel(wheel) => wheel.run_steered(solver),
            SceneSetup::RollingPatch(patch) => patch.run(solver),
            SceneSetup::GearedJoint(joint) => joint.run(solver),
            SceneSetup::PlaneBody(body) => body.run::<6>(solver),
            SceneSetup::TurningBody(body) => body.run::<9>(solver),
            SceneSetup::Footprint(surface) => surface.run(solver),
        }
    }
}

impl SolverSetup {
    /// Refuses a number out of its range, and keys that contradict each other.
    ///
    /// Some scenes take steps of their own.
    fn check(&self, own_steps: Option<&str>) -> Result<()> {
        let Self { end, samples, method, tolerance, step, .. } = *self;
        if !(end > 0.0 && end.is_finite()) {
            return Err(format!("end is {end}, but must be positive and finite").into());
        }
        if !(2..=MOST_SAMPLES).contains(&samples) {
            return Err(format!("samples is {samples}, but must lie between 2 and 1e6").into());
        }
        if let Some(step) = step
            && !(step >= end / MOST_STEPS as f64 && step.is_finite())
        {
            let least = end / MOST_STEPS as f64;
            let rule = format!("must be finite and at least {least}: a run has up to 1e7 steps");
            return Err(format!("step is {step}, but {rule}").into());
        }
        if let Some(tolerance) = tolerance {
            let named = |refused| ParameterError { name: "tolerance", component: None, ..refused };
            Tolerances::scaled(tolerance, SVector::<f64, 1>::repeat(1.0)).map_err(named)?;
        }
        let absent = |key, value: &dyn Display, why: &str| {
            Err(format!("{key} is {value}, but must be absent: {why}").into())
        };
        let chosen = method.unwrap_or_default();
        if let Some(scene) = own_steps {
            let why = format!("{scene} takes steps of length `step`");
            return match (method, tolerance) {
                (Some(method), _) => absent("method", &method, &why),
                (_, Some(tolerance)) => absent("tolerance", &tolerance, &why),
                _ => Ok(()),
            };
        }
        match (method, tolerance, step) {
            (_, Some(_), Some(step)) => absent("step", &step, "tolerance chooses the steps"),
            (_, _, Some(step)) if chosen == AnyMethod::Automatic => {
                absent("step", &step, "the method automatic chooses the steps")
            }
            (_, Some(tolerance), _) if chosen == AnyMethod::RungeKutta4 => {
                absent("tolerance", &tolerance, "runge_kutta4 takes steps of length `step`")
            }
            (_, _, None) if chosen == AnyMethod::RungeKutta4 => {
                Err("method is runge_kutta4, but must come with a step".into())
            }
            _ => Ok(()),
        }
    }

    /// Refuses an input that turns too often for the run to end, given the time over which it has
    /// one extremum at most.
    pub fn admit(&self, longest: Option<f64>) -> Result<()> {
        let most = MOST_PERIODS / self.end;
        match longest.map(|quarter| 0.25 / quarter) {
            Some(frequency) if !(frequency <= most) => {
                // The digits that were given: those of a quarter of the period are rounded.
                let frequency: f64 = format!("{frequency:.12e}").parse()?;
                let rule = format!("at most {most}: a run has up to a million periods");
                Err(format!("frequency is {frequency}, but must be {rule}").into())
            }
            _ => Ok(()),
        }
    }

    /// The table of a scene that takes steps of its own, of so many bristles: no longer than
    /// `step`, and whole ones between two rows. `advance` takes one from a time, and answers with
    /// the row at its end.
    pub fn stepped(
        &self,
        longest: f64,
        bristles: usize,
        columns: Vec<Column>,
        mut advance: impl FnMut(f64, f64) -> Result<Vec<f64>>,
    ) -> Result<Table> {
        let interval = self.end / (self.samples - 1) as f64;
        let parts = (interval / self.step.unwrap_or(longest)).ceil().max(1.0);
        let most = (MOST_WORK / bristles as f64).min(MOST_STEPS as f64);
        if self.most_steps.is_none() && !(parts * self.samples as f64 <= most + 1.0) {
            let rule = format!("at most {}", self.end * most / (parts * self.samples as f64));
            let why = format!("a run has up to {most} steps of {bristles} bristles");
            return Err(format!("end is {}, but must be {rule}: {why}", self.end).into());
        }
        let step = interval / parts;
        let row = |time, rest: Vec<f64>| [&[time][..], &rest].concat();
        let mut rows = vec![row(0.0, advance(0.0, 0.0)?)];
        let (mut taken, mut part) = (0, 0.0);
        while rows.len() < self.samples && self.most_steps.is_none_or(|most| taken < most) {
            let start = (rows.len() - 1) as f64 * interval;
            let end = advance(start + part * step, step)?;
            (taken, part) = (taken + 1, part + 1.0);
            if part == parts || self.most_steps.is_some() {
                (part, _) = (0.0, rows.push(row(start + interval, end)));
            }
        }
        Ok(Table { columns, rows, error: None })
    }

    /// Integrates a system, and makes a row of each sample.
    ///
    /// A run of fixed steps is repeated with half the step: what that changes is its error.
    pub fn run<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: &S,
        start: SVector<f64, N>,
        columns: Vec<Column>,
        row: impl Fn(f64, &SVector<f64, N>) -> Vec<f64>,
    ) -> Result<Table> {
        let run = self.trajectory(system, start, self.step)?;
        let error = match self.step {
            Some(step) if self.most_steps.is_none() => {
                let finer = self.trajectory(system, start, Some(0.5 * step))?;
                Some(error_of_steps(step, &run, &finer, system.scales())?)
            }
            _ => None,
        };
        let rows = run.iter().map(|(time, state)| {
            let mut line = vec![time];
            line.extend(row(time, state));
            line
        });
        Ok(Table { columns, rows: rows.collect(), error })
    }

    /// Integrates a system with fixed steps or with the tolerance.
    fn trajectory<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: &S,
        start: SVector<f64, N>,
        step: Option<f64>,
    ) -> Result<Trajectory<f64, N>> {
        let method = self.method.unwrap_or_default();
        let solver = match step {
            Some(step) => Solver::fixed(method, step)?,
            None => {
                let tolerance = self.tolerance.unwrap_or(1e-6);
                Solver::adaptive(method, Tolerances::scaled(tolerance, system.scales())?)
            }
        };
        let (most, output) = match (self.most_steps, step) {
            (Some(most), _) => (most, Output::Steps),
            (None, None) => (MOST_STEPS, Output::Uniform(self.samples)),
            // With more parts than this between reversals, it is the step that makes them.
            (None, Some(step)) => {
                (10_000 + (10.0 * self.end / step) as u64, Output::Uniform(self.samples))
            }
        };
        let failure = match solver.with_most_steps(most).solve(system, 0.0..self.end, start, output)
        {
            Ok(run) => return Ok(run),
            Err(failure) => failure,
        };
        match (failure.reason, &failure.trajectory, self.step) {
            (StopReason::TooManySteps { .. }, Some(run), _) if self.most_steps.is_some() => {
                Ok((**run).clone())
            }
            (StopReason::Refused(_), ..) | (.., None) => Err(failure.into()),
            (.., Some(step)) => {
                let rule = "must be shorter, unless the motion itself diverges";
                Err(format!("step is {}, but {rule}: {failure}; {ADVICE}", shown(step)).into())
            }
        }
    }
}

/// The error of fixed steps, over the scale of each state or over its largest size: what half the
/// step changes in the worst of the rows.
fn error_of_steps<const N: usize>(
    step: f64,
    run: &Trajectory<f64, N>,
    finer: &Trajectory<f64, N>,
    scales: SVector<f64, N>,
) -> Result<f64> {
    let largest = |sizes: SVector<f64, N>, state: &SVector<f64, N>| sizes.sup(&state.abs());
    let sizes = finer.states().iter().fold(scales, largest);
    let mut worst = (0.0, 0.0, 0);
    for ((time, state), (_, nearer)) in run.iter().zip(finer.iter()) {
        for (index, part) in (state - nearer).component_div(&sizes).iter().enumerate() {
            if !(part.abs() <= worst.0) {
                worst = (part.abs(), time, index);
            }
        }
    }
    let (error, time, index) = worst;
    if error <= MOST_ERROR {
        return Ok(error);
    }
    let error = shown(format!("{error:.1e}").parse()?);
    let why = format!("half of it changes component {index} of the state at t = {time} s");
    let rule = format!("must be shorter: {why} by {error} of its scale");
    Err(format!("step is {}, but {rule}; {ADVICE}", shown(step)).into())
}

/// A number for a reader: plain from 1e-3 to 1e6, with an exponent beyond.
pub fn shown(number: f64) -> String {
    if number == 0.0 || !number.is_finite() || (1e-3..1e6).contains(&number.abs()) {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}
