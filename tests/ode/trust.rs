//! Success means success: no run that answers is far off, in any state, whatever its tolerance.
#![cfg(feature = "alloc")]

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::ode::{
    AnyMethod, Automatic, DormandPrince, DormandPrince8, Failure, Method, Output, Rodas4, Rodas5P,
    Solver, StopReason, System, Tolerances, Trajectory,
};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::scene::{
    DiaphragmValve, MassSpringDamper, MassSpringDamperParameters, PrescribedVelocity,
};
use bristle::signal::{Polyline, Sine, SineParameters, Vertex};
use bristle::{Branch, Bristle, FrBd, LuGre, Mechanism, paper};
use bristle_specimens::draw::Draw;
use nalgebra::{SVector, Vector1};

const SAMPLES: usize = 1001;

/// More steps than this and a run is refused, which is honest.
const MOST_STEPS: u64 = 400_000;

/// Largest error of an answer over its tolerance, for tolerances of 10⁻⁵ or less.
const TOLERANCES: f64 = 1000.0;

/// Largest error of any answer over the scale of the state.
const SCALES: f64 = 0.1;

fn run<M: Method<f64, N>, S: System<f64, N>, const N: usize>(
    solver: fn(M, Tolerances<f64, N>) -> Solver<f64, M, N>,
    (method, tolerance): (M, f64),
    (system, start, end): (&S, SVector<f64, N>, f64),
) -> Result<Trajectory<f64, N>, Box<Failure<f64, N>>> {
    let tolerances = Tolerances::scaled(tolerance, system.scales()).unwrap();
    let solver = solver(method, tolerances).with_most_steps(MOST_STEPS);
    solver.solve(system, 0.0..end, start, Output::Uniform(SAMPLES))
}

/// The largest distance of two solutions, in scales.
fn distance<const N: usize>(
    (a, b): (&Trajectory<f64, N>, &Trajectory<f64, N>),
    scales: &SVector<f64, N>,
) -> f64 {
    let pairs = a.states().iter().zip(b.states());
    pairs.fold(0.0, |most, (a, b)| f64::max(most, (a - b).component_div(scales).abs().max()))
}

/// Every adaptive method on one scene, against two references that agree. Answers with the number
/// of runs that succeeded, none if the scene has no reference.
fn check<S: System<f64, N>, const N: usize>(
    name: &str,
    (system, start, end): (&S, SVector<f64, N>, f64),
    tolerances: &[f64],
    is_stiff: bool,
) -> usize {
    let (scales, scene) = (system.scales(), (system, start, end));
    let fine = run(Solver::adaptive, (Automatic, 1e-11), scene);
    let other = run(Solver::adaptive, (Rodas5P, 1e-10), scene);
    let (Ok(fine), Ok(other)) = (fine, other) else { return 0 };
    let doubt = distance((&fine, &other), &scales);
    if !(doubt < 1e-6) {
        return 0;
    }
    let mut successes = 0;
    for &tolerance in tolerances {
        let limit = if tolerance <= 1e-5 { TOLERANCES * tolerance } else { SCALES };
        let mut judge = |method: &str, answer: Result<Trajectory<f64, N>, _>| {
            if let Ok(answer) = answer {
                let error = distance((&answer, &fine), &scales);
                assert!(error < limit + doubt, "{name}, {method} at {tolerance:e}: {error:e}");
                successes += 1;
            }
        };
        if !is_stiff {
            judge("DormandPrince", run(Solver::checked, (DormandPrince, tolerance), scene));
            judge("DormandPrince8", run(Solver::checked, (DormandPrince8, tolerance), scene));
        }
        judge("Rodas4", run(Solver::checked, (Rodas4, tolerance), scene));
        judge("Rodas5P", run(Solver::checked, (Rodas5P, tolerance), scene));
        judge("Automatic", run(Solver::checked, (Automatic, tolerance), scene));
    }
    successes
}

/// Mass, load, curve, bristle, spring [N/m], drive [m/s], and the end of the run [s].
struct Rig {
    load: f64,
    curve: StribeckParameters<f64>,
    bristle: KelvinVoigtParameters<f64>,
    mechanism: Mechanism<f64>,
    drive: f64,
    end: f64,
}

impl Rig {
    /// Table 2 of the paper.
    fn of_the_paper(end: f64) -> Self {
        let mechanism = Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.0 };
        let (curve, bristle) = (paper::STICK_SLIP_CURVE, paper::STICK_SLIP_BRISTLE);
        Self { load: 1.0, curve, bristle, mechanism, drive: 0.1, end }
    }

    fn check(&self, name: &str, draw: &mut Draw, tolerances: &[f64]) -> usize {
        let curve = Stribeck::new(self.curve).unwrap();
        let bristle = KelvinVoigt::new(self.bristle).unwrap();
        let numbers = [draw.logarithmic(1e-3, 0.3), 0.3 + 0.65 * draw.next()];
        self.check_with(&format!("{name}, FrBD"), FrBd::new(curve, bristle), numbers, tolerances)
            + self.check_with(
                &format!("{name}, LuGre"),
                LuGre::classical(curve, bristle),
                numbers,
                tolerances,
            )
    }

    fn check_with<M: Bristle<f64, Deflection = f64> + Copy>(
        &self,
        name: &str,
        friction: M,
        [slowness, part]: [f64; 2],
        tolerances: &[f64],
    ) -> usize {
        let contact = friction.under_load(self.load).unwrap();
        let (mechanism, drive_velocity) = (self.mechanism, self.drive);
        let pulled = MassSpringDamperParameters { contact, mechanism, drive_velocity, force: 0.0 };
        let pulled = MassSpringDamper::new(pulled).unwrap();
        let scene = (&pulled, pulled.at_rest(), self.end);
        let mut successes = check(&format!("{name}, stick-slip"), scene, tolerances, false);

        let stiffness = self.load * self.bristle.micro_stiffness;
        let frequency = slowness * (stiffness / mechanism.mass).sqrt() / std::f64::consts::TAU;
        let amplitude = part * self.load * self.curve.static_coefficient;
        let force = Sine::new(SineParameters { mean: 0.0, amplitude, frequency, phase: 0.0 });
        let held = MassSpringDamperParameters {
            contact,
            mechanism: Mechanism { spring_stiffness: 0.0, ..mechanism },
            drive_velocity: 0.0,
            force: force.unwrap(),
        };
        let held = MassSpringDamper::new(held).unwrap();
        let scene = (&held, held.at_rest(), 5.0 / frequency);
        successes += check(&format!("{name}, pre-sliding"), scene, tolerances, false);

        let velocity =
            SineParameters { mean: 0.0055, amplitude: 0.01, frequency: 25.0, phase: 0.0 };
        let dragged = PrescribedVelocity::new(contact, Sine::new(velocity).unwrap());
        let scene = (&dragged, Vector1::new(0.0), 0.2);
        successes + check(&format!("{name}, lag"), scene, tolerances, false)
    }
}

/// The paper's valve under a ramp and under a sine, its friction multiplied by some factors.
fn check_valve(name: &str, [friction, stribeck, stiffness, damping]: [f64; 4], end: f64) -> usize {
    let mut curve = paper::VALVE_CURVE;
    curve.static_coefficient *= friction;
    curve.dynamic_coefficient *= friction;
    curve.stribeck_velocity *= stribeck;
    let mut bristle = paper::VALVE_BRISTLE;
    bristle.micro_stiffness *= stiffness;
    bristle.micro_damping *= damping;
    let friction = FrBd::new(Stribeck::new(curve).unwrap(), KelvinVoigt::new(bristle).unwrap());
    let contact = friction.under_load(1.0).unwrap();
    let ramp = [Vertex { time: 0.0, value: 0.0 }, Vertex { time: 100.0, value: 100.0 }];
    let ramp = paper::valve(contact, 0.933, Polyline::new(ramp).unwrap());
    let ramp = DiaphragmValve::new(ramp).unwrap();
    let sine = SineParameters { mean: 50.0, amplitude: 40.0, frequency: 0.05, phase: 0.0 };
    let sine = DiaphragmValve::new(paper::valve(contact, 0.425, Sine::new(sine).unwrap())).unwrap();
    let tolerances = [1e-3, 1e-6];
    check(&format!("{name}, ramp"), (&ramp, ramp.balanced(0.0), end), &tolerances, true)
        + check(&format!("{name}, sine"), (&sine, sine.balanced(0.0), end), &tolerances, true)
}

#[test]
fn an_answer_of_any_method_is_near_in_every_state() {
    // Dormand–Prince at 1e-6 was 28 876 tolerances off here, and a Rosenbrock method at 1e-3 lost
    // the solution.
    let mut draw = Draw(1);
    let tolerances = [1e-3, 1e-6];
    let rig = Rig::of_the_paper(40.0);
    assert!(rig.check("the paper's rig", &mut draw, &tolerances) >= 55);
    assert!(check_valve("the paper's valve", [1.0; 4], 3.0) >= 9);
}

#[test]
fn steps_are_as_tight_as_the_growth_of_errors_asks() {
    let curve = Stribeck::new(paper::STICK_SLIP_CURVE).unwrap();
    let friction = FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE).unwrap());
    let contact = friction.under_load(1.0).unwrap();
    let rig = MassSpringDamper::new(paper::stick_slip_rig(contact)).unwrap();
    let solver = |tolerance: f64| {
        Solver::checked(Automatic, Tolerances::scaled(tolerance, rig.scales()).unwrap())
    };
    let solve = |tolerance: f64, end: f64| {
        solver(tolerance).solve(&rig, 0.0..end, rig.at_rest(), Output::Uniform(2)).unwrap()
    };
    // Stuck, errors die out: one run. Slips repeat it, and all its steps are rejected.
    let (stuck, slipping) = (solve(1e-6, 5.0).statistics(), solve(1e-6, 25.0).statistics());
    assert!(stuck.rejected < stuck.steps / 4, "{stuck}");
    assert!(slipping.rejected > slipping.steps / 10, "{slipping}");
}

#[test]
fn a_bristle_at_a_given_velocity_takes_loose_steps_of_order_five() {
    let curve = Stribeck::new(paper::STICK_SLIP_CURVE).unwrap();
    let friction = FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE).unwrap());
    let contact = friction.under_load(1.0).unwrap();
    let velocity = SineParameters { mean: 0.0055, amplitude: 0.005, frequency: 50.0, phase: 0.0 };
    let scene = PrescribedVelocity::new(contact, Sine::new(velocity).unwrap());
    let solve = |method: AnyMethod, tolerance: f64| {
        let tolerances = Tolerances::scaled(tolerance, scene.scales()).unwrap();
        let solver = Solver::checked(method, tolerances);
        solver.solve(&scene, 0.0..0.4, Vector1::new(0.0), Output::Uniform(1001)).unwrap()
    };
    // A trial of order 5 evaluates six rates; one of order 8 twelve, and three for the samples.
    for (tolerance, least, most) in [(1e-3, 5.5, 6.5), (1e-4, 5.5, 6.5), (1e-9, 12.0, 16.0)] {
        let automatic = solve(AnyMethod::Automatic, tolerance);
        let statistics = automatic.statistics();
        let trials = (statistics.steps + statistics.rejected) as f64;
        let of_a_trial = statistics.evaluations as f64 / trials;
        assert!(of_a_trial > least && of_a_trial < most, "{tolerance:e}: {statistics}");
        // Over 24 tolerances from 1e-3 to 3e-7 its error is 0.1 to 2.3 of them, by chance.
        let fine = solve(AnyMethod::Rodas5P, 1e-10);
        let error = distance((&automatic, &fine), &scene.scales());
        assert!(error < f64::max(3.0 * tolerance, 1e-8), "{tolerance:e}: {error:e}");
    }
}

#[test]
fn a_run_whose_errors_outgrow_its_tolerance_is_repeated_or_stopped() {
    /// x = cos t, from which every error grows as e^20t.
    struct Unstable;
    impl System<f64, 1, 0> for Unstable {
        fn rate(&self, time: f64, x: &Vector1<f64>, _: [Branch; 0]) -> Vector1<f64> {
            Vector1::new(20.0 * (x[0] - time.cos()) - time.sin())
        }
        fn sliding_velocities(&self, _: f64, _: &Vector1<f64>) -> [f64; 0] {
            []
        }
    }
    let (start, tolerance) = (Vector1::new(1.0), 1e-6);
    let tolerances = Tolerances::scaled(tolerance, start).unwrap();
    let judge = |method: AnyMethod, repeats: bool| {
        let solver = Solver::checked(method, tolerances);
        // A stream stops where errors have grown too much: steps are 4000 times as tight, the
        // estimate may exceed the tolerance tenfold, and a hundred steps add up.
        let mut run = solver.begin(&Unstable, 0.0..1.0, start).unwrap();
        let stopped = loop {
            match run.advance() {
                Ok(Some(_)) => {}
                Ok(None) => panic!("{method:?}: the errors did not grow"),
                Err(failure) => break failure,
            }
        };
        let StopReason::ErrorsGrow { times } = stopped.reason else { panic!("{stopped}") };
        assert!(times > 1.0 && times < 1e4, "{method:?}: {times}");
        assert!(run.advance().is_err(), "{method:?}");
        // Repeated with tighter steps it arrives: errors have grown by e^14 = 1.2e6.
        let answer = solver.solve(&Unstable, 0.0..0.7, start, Output::Steps).unwrap();
        let statistics = answer.statistics();
        let repeated = statistics.rejected > statistics.steps / 5;
        assert_eq!(repeated, repeats, "{method:?}: {statistics}");
        for (time, state) in answer.iter() {
            let error = (state[0] - time.cos()).abs();
            assert!(error < 4e-6, "{method:?}: {error:e} at {time}");
        }
        // No steps are tight enough for e^40.
        let failure = solver.solve(&Unstable, 0.0..2.0, start, Output::Steps).unwrap_err();
        assert!(matches!(failure.reason, StopReason::ErrorsGrow { .. }), "{method:?}: {failure}");
        assert!(failure.to_string().contains("what the tolerances allow"), "{failure}");
        // Steps with a tolerance of their own go on, far off.
        let solver = Solver::adaptive(method, tolerances);
        let wrong = solver.solve(&Unstable, 0.0..1.0, start, Output::Steps).unwrap();
        let (time, state) = wrong.last().unwrap();
        assert!((state[0] - time.cos()).abs() > 1e-2, "{method:?}");
    };
    judge(AnyMethod::DormandPrince, true);
    judge(AnyMethod::DormandPrince8, true);
    judge(AnyMethod::Rodas4, true);
    // Steps that follow e^20t from below the tolerance are tight enough for it at once.
    judge(AnyMethod::Rodas5P, false);
    judge(AnyMethod::Automatic, true);
}

#[test]
fn a_step_does_not_pass_over_two_reversals_of_a_prescribed_velocity() {
    // In the quasi-steady sliding of LuGre nothing else shortens the steps.
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: 1.2,
        dynamic_coefficient: 0.9,
        stribeck_velocity: 1e-3,
        stribeck_exponent: 2.0,
        viscous_friction: 0.0,
    });
    let bristle = KelvinVoigtParameters { micro_stiffness: 1e6, micro_damping: 10.0 };
    let bristle = KelvinVoigt::new(bristle).unwrap();
    let contact = LuGre::classical(curve.unwrap(), bristle).under_load(1.0).unwrap();
    let velocity = SineParameters { mean: 0.0055, amplitude: 0.01, frequency: 25.0, phase: 0.0 };
    let scene = PrescribedVelocity::new(contact, Sine::new(velocity).unwrap());
    let tolerances = Tolerances::scaled(1e-3, scene.scales()).unwrap();
    let solver = Solver::checked(Rodas5P, tolerances);
    let run = solver.solve(&scene, 0.0..0.2, Vector1::new(0.0), Output::Steps).unwrap();
    // Two in each of five periods.
    assert_eq!(run.reversals().len(), 10);
    let longest = run.times().windows(2).fold(0.0, |most, pair| f64::max(most, pair[1] - pair[0]));
    assert!(longest <= 0.01 * (1.0 + 1e-12), "{longest}");
}
