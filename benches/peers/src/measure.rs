//! One method on one scene over all its settings.

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

use bristle::ode::System;
use cpu_time::ThreadTime;

use crate::field::{Field, LONGEST_RUN, Spent};
use crate::methods;
use crate::peer::{Failure, Peer, Run};
use crate::row::{NO_ANSWER, OK, Row, WRONG};
use crate::scenes::Scene;

/// Runs of a setting, at least, unless they take too long.
const RUNS: usize = 3;
/// CPU time to spend on a setting, at least, and again in each later pass …
const SHORTEST: Duration = Duration::from_millis(7);
/// … if a run takes less than this.
const WORTH_AGAIN: Duration = Duration::from_millis(20);
/// CPU time after which a setting is not run again.
const LONGEST: Duration = Duration::from_millis(120);
/// A run longer than this makes the next tolerance a whole decade tighter instead of half of one.
const SLOW: Duration = Duration::from_millis(40);
/// Failed settings in a row after which a method is given up on a scene; but not before
/// [`FORGIVEN`] has been tried, as some only fail at loose tolerances.
const PATIENCE: usize = 3;
/// Half decades of the tolerance: 10⁻⁶.
const FORGIVEN: u32 = 12;

/// Half decades of the relative tolerance: 10⁻² to 10⁻¹².
const LOOSEST: u32 = 4;
const TIGHTEST: u32 = 24;

/// Fixed steps begin with the time span over this number and are halved, at most so many times,
/// until a run takes so long.
const FEWEST_STEPS: f64 = 125.0;
const HALVINGS: i32 = 24;
const LONGEST_STEPS: Duration = Duration::from_millis(500);

/// Statuses of runs that the watchdog ended.
const SLOW_RUN: &str = "slow";
const MANY_EVALUATIONS: &str = "evaluations";

/// A failed run, with what the crate said.
#[derive(Debug, Clone)]
pub(crate) struct Complaint {
    pub(crate) row: Row,
    pub(crate) message: String,
}

/// A method on a scene, ours or a peer's.
struct Method<'a> {
    crate_: &'static str,
    method: &'static str,
    /// The scene, the model and the scale of its error.
    scene: (&'static str, &'static str, f64),
    reference: &'a [f64],
    /// Runs it with a setting.
    run: Box<dyn Fn(f64) -> Outcome + 'a>,
}

/// A method's rows, which can be timed again.
pub(crate) struct Sweep<'a> {
    pub(crate) rows: Vec<Row>,
    settings: Vec<f64>,
    run: Box<dyn Fn(f64) -> Outcome + 'a>,
}

impl Sweep<'_> {
    /// Looks for shorter times. A machine that does other things besides has slow spells of many
    /// seconds; what is compared should not have been timed in different ones only.
    pub(crate) fn time_again(&mut self) {
        for (row, &setting) in self.rows.iter_mut().zip(&self.settings) {
            if row.status != OK || row.cpu_s > WORTH_AGAIN.as_secs_f64() {
                continue;
            }
            let mut total = Duration::ZERO;
            while total < SHORTEST {
                let taken = timed(|| (self.run)(setting)).1;
                total += taken;
                row.cpu_s = row.cpu_s.min(taken.as_secs_f64());
            }
        }
    }
}

fn timed(run: impl Fn() -> Outcome) -> (Outcome, Duration) {
    let clock = ThreadTime::now();
    let outcome = run();
    (outcome, clock.elapsed())
}

/// What a run came to: evaluations of f and of its Jacobian, and the rest.
type Outcome = (u64, u64, Result<Run, Failure>);

/// Runs a peer at ever tighter tolerances.
pub(crate) fn sweep<'a, S: System<f64, N>, const N: usize>(
    scene: &'a Scene<S, N>,
    peer: &Peer<S, N>,
    reference: &'a [f64],
    complaints: &mut Vec<Complaint>,
) -> Sweep<'a> {
    let Peer { crate_, method, solve } = *peer;
    let run = move |tolerance: f64| {
        let field = Field::new(scene);
        let outcome = guarded(|| solve(&field, tolerance));
        (field.rates(), field.jacobians(), outcome)
    };
    let scene = (scene.name, scene.model, scene.scale);
    Method { crate_, method, scene, reference, run: Box::new(run) }.tolerances(complaints)
}

/// Runs one of our own methods over its settings.
pub(crate) fn sweep_own<'a, S: System<f64, N> + Clone, const N: usize>(
    scene: &'a Scene<S, N>,
    own: &methods::Method<S, N>,
    reference: &'a [f64],
    complaints: &mut Vec<Complaint>,
) -> Sweep<'a> {
    let methods::Method { name, setting, run } = *own;
    let run = move |setting: f64| {
        let run = run(scene, setting);
        let methods::Cost { rates, jacobians, steps, rejected } = run.cost;
        let outcome = match run.failure {
            None => Ok(Run { judged: run.judged, steps, rejected }),
            Some(message) => Err(Failure::new("failed", message)),
        };
        (rates, jacobians, outcome)
    };
    let (scene, end) = ((scene.name, scene.model, scene.scale), scene.end);
    let (crate_, run) = (crate::OURS, Box::new(run));
    let method = Method { crate_, method: name, scene, reference, run };
    match setting {
        methods::Setting::Tolerance => method.tolerances(complaints),
        methods::Setting::Step => method.steps(end, complaints),
    }
}

impl<'a> Method<'a> {
    fn tolerances(self, complaints: &mut Vec<Complaint>) -> Sweep<'a> {
        let (mut rows, mut settings) = (Vec::new(), Vec::new());
        let mut failures = 0;
        let mut half_decades = LOOSEST;
        while half_decades <= TIGHTEST && (failures < PATIENCE || half_decades <= FORGIVEN) {
            let exponent = -0.5 * f64::from(half_decades);
            let tolerance = 10f64.powf(exponent);
            let row = self.setting(format!("rtol=1e{exponent}"), tolerance, complaints);
            let (slow, spent) = (row.cpu_s > SLOW.as_secs_f64(), is_spent(&row));
            failures = if row.status == OK { 0 } else { failures + 1 };
            rows.push(row);
            settings.push(tolerance);
            if spent {
                break;
            }
            half_decades += if slow { 2 } else { 1 };
        }
        Sweep { rows, settings, run: self.run }
    }

    /// Halves the step until that takes too long or gains nothing.
    fn steps(self, end: f64, complaints: &mut Vec<Complaint>) -> Sweep<'a> {
        let (mut rows, mut settings): (Vec<Row>, Vec<f64>) = (Vec::new(), Vec::new());
        for halvings in 0..HALVINGS {
            let step = end / FEWEST_STEPS * 0.5f64.powi(halvings);
            let row = self.setting(format!("step={step:.3e}s"), step, complaints);
            // Of the steps that are too long for stability the last one tells enough.
            if rows.iter().all(|row| row.status != OK) {
                rows.clear();
                settings.clear();
            }
            let longer = rows.last().and_then(Row::achieved);
            let rounding = |error: f64| error < 1e-10 && longer.is_some_and(|e| error > 0.5 * e);
            let floor = row.achieved().is_some_and(|error| error < 1e-12 || rounding(error));
            // Steps too long for stability may take long as well, and shorter ones less.
            let long = row.status == OK && row.cpu_s > LONGEST_STEPS.as_secs_f64();
            rows.push(row);
            settings.push(step);
            if floor || long {
                break;
            }
        }
        Sweep { rows, settings, run: self.run }
    }

    fn setting(&self, setting: String, value: f64, complaints: &mut Vec<Complaint>) -> Row {
        let (scene, model, scale) = self.scene;
        let mut row = Row {
            scene: scene.to_owned(),
            model: model.to_owned(),
            crate_: self.crate_.to_owned(),
            method: self.method.to_owned(),
            setting,
            error: None,
            cpu_s: f64::INFINITY,
            rhs_evals: 0,
            jac_evals: 0,
            steps: 0,
            rejected: 0,
            status: OK.to_owned(),
        };
        let (mut runs, mut total) = (0, Duration::ZERO);
        loop {
            let ((rates, jacobians, outcome), taken) = timed(|| (self.run)(value));
            runs += 1;
            total += taken;
            row.cpu_s = row.cpu_s.min(taken.as_secs_f64());
            (row.rhs_evals, row.jac_evals) = (rates, jacobians);
            let outcome = outcome.and_then(|run| {
                let error = largest_error(&run, self.reference, scale);
                if error.is_nan() {
                    let message = "success, but not every sample is a number";
                    return Err(Failure::new("nan", message));
                }
                Ok((run, error))
            });
            match outcome {
                Ok((run, error)) => {
                    (row.steps, row.rejected) = (run.steps, run.rejected);
                    row.error = Some(error);
                    row.status = if error < NO_ANSWER { OK } else { WRONG }.to_owned();
                }
                Err(Failure { word, message }) => {
                    row.status = word.to_owned();
                    complaints.push(Complaint { row: row.clone(), message });
                }
            }
            let enough = runs >= RUNS && total >= SHORTEST;
            if row.status != OK || enough || total + taken > LONGEST {
                return row;
            }
        }
    }
}

/// Whether a run was too long to try a tighter one.
fn is_spent(row: &Row) -> bool {
    row.status == SLOW_RUN
        || row.status == MANY_EVALUATIONS
        || row.cpu_s > LONGEST_RUN.as_secs_f64()
}

/// max |x − x_ref|/scale; NaN if any is.
fn largest_error(run: &Run, reference: &[f64], scale: f64) -> f64 {
    if run.judged.len() != reference.len() {
        return f64::NAN;
    }
    let errors = run.judged.iter().zip(reference).map(|(x, x_ref)| (x - x_ref).abs() / scale);
    errors
        .fold(0.0, |largest, error| if error > largest || error.is_nan() { error } else { largest })
}

thread_local! {
    /// What the last panic said.
    static LAST_WORDS: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Makes panics of peers silent: they are a result here, not a crash of this program.
pub(crate) fn catch_last_words() {
    std::panic::set_hook(Box::new(|panic| {
        LAST_WORDS.with(|words| *words.borrow_mut() = panic.to_string());
    }));
}

fn guarded(run: impl FnOnce() -> Result<Run, Failure>) -> Result<Run, Failure> {
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(outcome) => outcome,
        Err(payload) => Err(match payload.downcast_ref::<Spent>() {
            Some(Spent::Evaluations) => {
                Failure::new(MANY_EVALUATIONS, "ended by the watchdog: too many evaluations")
            }
            Some(Spent::Time) => Failure::new(SLOW_RUN, "ended by the watchdog: over 1.5 s"),
            None => Failure::new("panic", LAST_WORDS.with(RefCell::take)),
        }),
    }
}
