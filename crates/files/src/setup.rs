//! What a file holds, and its simulation.

use std::fmt::Display;

use bristle::nalgebra::SVector;
use bristle::number::Number;
use bristle::ode::{AnyMethod, Output, Solver, StopReason, System, Tolerances, Trajectory};
use bristle::scene::{DiaphragmValve, MassSpringDamper, PrescribedVelocity};
use bristle::signal::{AnySignal, Signal};
use bristle::{AnyBristle, ParameterError};
use serde::{Deserialize, Serialize};
use toml::Value;

use crate::choices::PlaneModel;
use crate::refusal::Refusal;
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
pub(crate) type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Refuses a value by its name and a rule.
pub(crate) fn must<R>(name: &str, value: impl Display, rule: impl Display) -> Result<R> {
    Err(format!("{name} is {value}, but must {rule}").into())
}

/// A scene, and how it is solved: [`read`](crate::read) from a file.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setup {
    /// Time span, method and accuracy.
    pub solver: SolverSetup,
    /// Contact and mechanism.
    scene: Scene,
    /// The file, in which a refusal is found.
    #[serde(skip)]
    pub(crate) text: String,
}

/// Time span, method and accuracy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolverSetup {
    /// The run goes from t = 0 to here \[s\].
    pub end: f64,
    /// Rows of the table, evenly spaced, both ends included: 2 to 1e6.
    pub samples: usize,
    /// The method; `automatic` if it is absent.
    pub method: Option<AnyMethod>,
    /// Tolerance relative to the scale of each state, for adaptive steps, at most 0.1; 1e-6 if
    /// neither it nor a step is given.
    pub tolerance: Option<f64>,
    /// Length \[s\] of fixed steps, in place of a tolerance.
    pub step: Option<f64>,
    /// A run that is broken off after so many steps; the table then has a row for each step.
    #[serde(skip)]
    pub most_steps: Option<u64>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(clippy::large_enum_variant, reason = "there is one")]
enum Scene {
    PrescribedVelocity(PrescribedVelocity<f64, AnyBristle<f64>, AnySignal<f64>>),
    Viscoelastic(Viscoelastic),
    MassSpringDamper(MassSpringDamper<f64, AnyBristle<f64>, AnySignal<f64>>),
    DiaphragmValve(DiaphragmValve<f64, AnyBristle<f64>, AnySignal<f64>>),
    BrakedWheel(Wheel<AnyBristle<f64>>),
    SteeredWheel(Wheel<PlaneModel<2>>),
    RollingPatch(RollingPatch),
    GearedJoint(Joint),
    PlaneBody(PlaneBlock<2>),
    TurningBody(PlaneBlock<3>),
    Footprint(Surface),
}

/// A column: its name, the label of its axis, and the factor from SI units to those of the label.
pub type Column = (&'static str, &'static str, f64);

/// A run as a table in SI units: rows that begin with the time \[s\].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// The columns after the time.
    pub columns: Vec<Column>,
    /// The rows.
    pub rows: Vec<Vec<f64>>,
    /// The largest difference \[–\] that half the step makes, over the scale of each state or over
    /// its largest size; of fixed steps alone.
    pub error: Option<f64>,
}

pub(crate) const FORCE: Column = ("force", "friction force F (N)", 1.0);
pub(crate) const BODY: [Column; 3] =
    [("x", "position x (m)", 1.0), ("v", "velocity v (m/s)", 1.0), ("z", "deflection z (µm)", 1e6)];

impl Setup {
    /// Simulates the scene.
    ///
    /// # Errors
    ///
    /// Refuses keys of the solver that are out of range or contradict each other, parameters that
    /// only a run can refuse, steps whose error is large, and a run that would not end. Says why a
    /// run stopped.
    pub fn run(&self) -> std::result::Result<Table, Refusal> {
        self.table().map_err(|error| Refusal::of_run(&self.text, error.to_string()))
    }

    fn table(&self) -> Result<Table> {
        self.solver.check(match self.scene {
            Scene::BrakedWheel(_) | Scene::SteeredWheel(_) => Some("a braked wheel"),
            Scene::RollingPatch(_) => Some("a rolling patch"),
            Scene::Footprint(_) => Some("a footprint"),
            _ => None,
        })?;
        let most = MOST_PERIODS / self.solver.end;
        let mut frequencies = frequencies(&Value::try_from(&self.scene)?).into_iter();
        if let Some(frequency) = frequencies.find(|frequency| !(*frequency <= most)) {
            let rule = format!("be at most {most}: a run has up to a million periods");
            return must("frequency", frequency, rule);
        }
        let table = self.simulate()?;
        for row in &table.rows {
            for (column, value) in table.columns.iter().zip(&row[1..]) {
                if !value.is_finite() {
                    return Err(format!("{} is {value} at t = {} s", column.0, row[0]).into());
                }
            }
        }
        Ok(table)
    }

    fn simulate(&self) -> Result<Table> {
        let solver = &self.solver;
        match &self.scene {
            Scene::PrescribedVelocity(scene) => {
                let columns = vec![BODY[1], BODY[2], FORCE];
                solver.run(scene, SVector::zeros(), columns, |time, state: &SVector<f64, 1>| {
                    vec![scene.velocity(time), state[0], scene.friction_force(time, state)]
                })
            }
            Scene::Viscoelastic(scene) => scene.run(solver),
            Scene::MassSpringDamper(rig) => {
                let columns = [&BODY[..], &[FORCE]].concat();
                solver.run(rig, rig.at_rest(), columns, |_, state| {
                    vec![state[0], state[1], state[2], rig.friction_force(state)]
                })
            }
            Scene::DiaphragmValve(valve) => {
                let pressure = ("pressure", "pressure P (kPa)", 1e-3);
                let opening = ("opening", "opening OP (%)", 1.0);
                let columns = [&BODY[..], &[pressure, FORCE, opening]].concat();
                let parameters = valve.parameters();
                solver.run(valve, valve.balanced(0.0), columns, |time, state| {
                    let rest = [valve.friction_force(state), parameters.opening.value(time)];
                    [state.as_slice(), &rest].concat()
                })
            }
            Scene::BrakedWheel(wheel) => wheel.run(solver),
            Scene::SteeredWheel(wheel) => wheel.run_steered(solver),
            Scene::RollingPatch(patch) => patch.run(solver),
            Scene::GearedJoint(joint) => joint.run(solver),
            Scene::PlaneBody(body) => body.run::<6>(solver),
            Scene::TurningBody(body) => body.run::<9>(solver),
            Scene::Footprint(surface) => surface.run(solver),
        }
    }
}

/// The frequencies of all sines within a value.
fn frequencies(value: &Value) -> Vec<f64> {
    match value {
        Value::Table(table) => {
            let own = table.get("frequency").and_then(Value::as_float).into_iter();
            own.chain(table.values().flat_map(frequencies)).collect()
        }
        Value::Array(list) => list.iter().flat_map(frequencies).collect(),
        _ => Vec::new(),
    }
}

impl SolverSetup {
    /// Refuses a number out of its range, and keys that contradict each other.
    ///
    /// Some scenes take steps of their own.
    fn check(&self, own_steps: Option<&str>) -> Result<()> {
        let Self { end, samples, method, tolerance, step, .. } = *self;
        if !(end > 0.0 && end.is_finite()) {
            return must("end", end, "be positive and finite");
        }
        if !(2..=MOST_SAMPLES).contains(&samples) {
            return must("samples", samples, "lie between 2 and 1e6");
        }
        let least = end / MOST_STEPS as f64;
        if let Some(step) = step.filter(|&step| !(step >= least && step.is_finite())) {
            let rule = format!("be finite and at least {least}: a run has up to 1e7 steps");
            return must("step", step, rule);
        }
        if let Some(tolerance) = tolerance {
            let named = |refused| ParameterError { name: "tolerance", component: None, ..refused };
            Tolerances::scaled(tolerance, SVector::<f64, 1>::repeat(1.0)).map_err(named)?;
        }
        if let Some(scene) = own_steps {
            let rule = format!("be absent: {scene} takes steps of length `step`");
            return match (method, tolerance) {
                (Some(method), _) => must("method", method, rule),
                (_, Some(tolerance)) => must("tolerance", tolerance, rule),
                _ => Ok(()),
            };
        }
        match (method.unwrap_or_default(), tolerance, step) {
            (_, Some(_), Some(step)) => {
                must("step", step, "be absent: tolerance chooses the steps")
            }
            (AnyMethod::Automatic, _, Some(step)) => {
                must("step", step, "be absent: the method automatic chooses the steps")
            }
            (AnyMethod::RungeKutta4, Some(tolerance), _) => {
                let rule = "be absent: runge_kutta4 takes steps of length `step`";
                must("tolerance", tolerance, rule)
            }
            (AnyMethod::RungeKutta4, _, None) => must("method", "runge_kutta4", "come with a step"),
            _ => Ok(()),
        }
    }

    /// The table of a scene that takes steps of its own, of so many bristles: no longer than
    /// `step`, and whole ones between two rows. `advance` takes one from a time, and answers with
    /// the row at its end.
    pub(crate) fn stepped(
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
            let longest = self.end * most / (parts * self.samples as f64);
            let why = format!("a run has up to {most} steps of {bristles} bristles");
            return must("end", self.end, format!("be at most {longest}: {why}"));
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
    /// Behind a pointer, so that systems of as many states share the compiled solver.
    ///
    /// A run of fixed steps is repeated with half the step: what that changes is its error.
    pub(crate) fn run<const N: usize, const K: usize>(
        &self,
        system: &dyn System<f64, N, K>,
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
        let row = |(time, state)| [&[time][..], &row(time, state)].concat();
        Ok(Table { columns, rows: run.iter().map(row).collect(), error })
    }

    /// Integrates a system with fixed steps or with the tolerance.
    fn trajectory<const N: usize, const K: usize>(
        &self,
        system: &dyn System<f64, N, K>,
        start: SVector<f64, N>,
        step: Option<f64>,
    ) -> Result<Trajectory<f64, N>> {
        let method = self.method.unwrap_or_default();
        let solver = match step {
            Some(step) => Solver::fixed(method, step)?,
            None => {
                let tolerance = self.tolerance.unwrap_or(1e-6);
                Solver::checked(method, Tolerances::scaled(tolerance, system.scales())?)
            }
        };
        let rows = Output::Uniform(self.samples);
        let (most, output) = match (self.most_steps, step) {
            (Some(most), _) => (most, Output::Steps),
            (None, None) => (MOST_STEPS, rows),
            // With more parts than this between reversals, it is the step that makes them.
            (None, Some(step)) => (10_000 + (10.0 * self.end / step) as u64, rows),
        };
        let solved = solver.with_most_steps(most).solve(system, 0.0..self.end, start, output);
        solved.or_else(|failure| match (failure.reason, &failure.trajectory, self.step) {
            (StopReason::TooManySteps { .. }, Some(run), _) if self.most_steps.is_some() => {
                Ok((**run).clone())
            }
            (StopReason::Refused(_), ..) | (.., None) => Err(failure.into()),
            (.., Some(step)) => {
                let rule = "be shorter, unless the motion itself diverges";
                must("step", Number(step), format!("{rule}: {failure}; {ADVICE}"))
            }
        })
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
    let changes = run.iter().zip(finer.iter()).flat_map(|((time, state), (_, nearer))| {
        let change = (state - nearer).component_div(&sizes).abs();
        (0..N).map(move |index| (change[index], time, index))
    });
    let (error, time, index) =
        changes.fold((0.0, 0.0, 0), |worst, it| if it.0 <= worst.0 { worst } else { it });
    if error <= MOST_ERROR {
        return Ok(error);
    }
    let error = Number(error);
    let why = format!("half of it changes component {index} of the state at t = {time} s");
    must("step", Number(step), format!("be shorter: {why} by {error:.2} of its scale; {ADVICE}"))
}
