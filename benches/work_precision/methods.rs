//! The methods that are compared, in one table: a new one is a line of [`all`].

use bristle::ode::{
    self, Automatic, DormandPrince, DormandPrince8, Output, Rodas4, Rodas5P, RungeKutta4, Solver,
    Statistics, System, Tolerances,
};

use crate::scenes::{DragSetting, SAMPLES, Scene};

/// A method as it runs on scenes of N states.
#[derive(Debug)]
pub struct Method<S, const N: usize> {
    /// A name without commas.
    pub name: &'static str,
    /// What its setting is.
    pub setting: Setting,
    /// Runs it on a scene with a setting.
    pub run: fn(&Scene<S, N>, f64) -> Run,
}

/// What a method is set by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Setting {
    /// The relative tolerance; the absolute one is that part of each state's scale.
    Tolerance,
    /// The length of the step \[s\].
    Step,
}

/// What a run of any code gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The judged component at the uniform samples; as many as were reached.
    pub judged: Vec<f64>,
    /// What it cost.
    pub cost: Cost,
    /// Why it failed, if it did.
    pub failure: Option<String>,
}

/// What a run cost, counted by the code itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cost {
    /// Evaluations of the right-hand side.
    pub rates: u64,
    /// Evaluations of the Jacobian.
    pub jacobians: u64,
    /// Accepted steps.
    pub steps: u64,
    /// Rejected trial steps, those cut at a reversal among them.
    pub rejected: u64,
}

/// A run of more trial steps has failed: about ten times what the explicit methods need on the
/// valve.
const MOST_STEPS: u64 = 10_000_000;

/// Every method of the crate that suits a scene.
pub fn all<S: System<f64, N> + Clone, const N: usize>(scene: &Scene<S, N>) -> Vec<Method<S, N>> {
    use Setting::{Step, Tolerance};
    let method = |name, setting, run| Method { name, setting, run };
    let mut methods = vec![
        method("DormandPrince", Tolerance, |scene, tol| adaptive(DormandPrince, scene, tol)),
        method("DormandPrince8", Tolerance, |scene, tol| adaptive(DormandPrince8, scene, tol)),
        method("Rodas4", Tolerance, |scene, tol| adaptive(Rodas4, scene, tol)),
        method("Rodas5P", Tolerance, |scene, tol| adaptive(Rodas5P, scene, tol)),
        method("Automatic", Tolerance, |scene, tol| adaptive(Automatic, scene, tol)),
        method("solve", Tolerance, |scene, tol| run(Solver::automatic(tol, scene.scales), scene)),
        method("RungeKutta4", Step, |scene, step| fixed(RungeKutta4, scene, step)),
        method("RungeKutta4 plain", Step, |scene, step| plain(RungeKutta4, scene, step)),
    ];
    if scene.dragged.is_some() {
        methods.push(method("Exponential", Tolerance, |scene, tol| {
            dragged(scene, DragSetting::Tolerance(tol))
        }));
        methods.push(method("Exponential fixed", Step, |scene, step| {
            dragged(scene, DragSetting::Step(step))
        }));
    }
    methods
}

fn dragged<S, const N: usize>(scene: &Scene<S, N>, setting: DragSetting) -> Run {
    match scene.dragged.as_ref().map(|dragged| dragged.run(setting)) {
        Some(Ok((judged, cost))) => Run { judged, cost: cost.into(), failure: None },
        Some(Err(failure)) => failed(failure),
        None => failed("no prescribed velocity".into()),
    }
}

/// A run that did not start.
fn failed(failure: String) -> Run {
    Run { judged: Vec::new(), cost: Cost::default(), failure: Some(failure) }
}

fn adaptive<S, M, const N: usize>(method: M, scene: &Scene<S, N>, tolerance: f64) -> Run
where
    S: System<f64, N> + Clone,
    M: ode::Method<f64, N>,
{
    let tolerances = Tolerances::scaled(tolerance, scene.scales);
    // As the peers take theirs. The error is measured.
    run(tolerances.map(|tolerances| Solver::adaptive(method, tolerances)), scene)
}

fn fixed<S, M, const N: usize>(method: M, scene: &Scene<S, N>, step: f64) -> Run
where
    S: System<f64, N> + Clone,
    M: ode::Method<f64, N>,
{
    run(Solver::fixed(method, step), scene)
}

fn plain<S, M, const N: usize>(method: M, scene: &Scene<S, N>, step: f64) -> Run
where
    S: System<f64, N> + Clone,
    M: ode::Method<f64, N>,
{
    run(Solver::fixed(method, step).map(Solver::plain), scene)
}

fn run<S, M, const N: usize>(
    solver: Result<Solver<f64, M, N>, bristle::ParameterError>,
    scene: &Scene<S, N>,
) -> Run
where
    S: System<f64, N> + Clone,
    M: ode::Method<f64, N>,
{
    let solver = match solver {
        Ok(solver) => solver.with_most_steps(MOST_STEPS),
        Err(error) => return failed(error.to_string()),
    };
    let output = Output::Uniform(SAMPLES);
    let solved = solver.solve(&scene.system, 0.0..scene.end, scene.start, output);
    let (trajectory, failure) = match solved {
        Ok(trajectory) => (Some(trajectory), None),
        Err(failure) => {
            (failure.trajectory.map(|stored| *stored), Some(failure.reason.to_string()))
        }
    };
    let states = trajectory.iter().flat_map(|stored| stored.states());
    Run {
        judged: states.map(|state| state[scene.judged]).collect(),
        cost: trajectory.as_ref().map(|stored| stored.statistics()).unwrap_or_default().into(),
        failure,
    }
}

impl From<Statistics> for Cost {
    fn from(statistics: Statistics) -> Self {
        Self {
            rates: statistics.evaluations,
            jacobians: statistics.jacobians,
            steps: statistics.steps,
            rejected: statistics.rejected,
        }
    }
}
