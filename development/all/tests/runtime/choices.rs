//! What is chosen at run time has the numbers of the type that it holds, to the last bit.

use bristle::control::{
    FeedForwardCompensator, FeedForwardParameters, FrictionObserver, Injection, ObserverParameters,
    OutputParameters, VelocityFromPositionParameters,
};
use bristle::curve::{AnyCurve, FrictionCurve, Knot, Stribeck, Tabulated};
use bristle::ode::{AnyMethod, DormandPrince, DormandPrince8, Rodas4, Rodas5P, RungeKutta4};
use bristle::ode::{Automatic, Method, Solver, Summary, Tolerances};
use bristle::rheology::{KelvinVoigt, Maxwell, MaxwellParameters};
use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
use bristle::signal::{AnySignal, Sine, SineParameters};
use bristle::{
    Affine, AnyBristle, Branch, Bristle, FrBd, Law, Linearised, LuGre, Mechanism, ParameterError,
    Sliding, Surface, paper,
};
use bristle_analysis::audit::{AuditParameters, audit};
use bristle_batch::Batch;
use bristle_rolling::{AnyPressure, Motion, Patch, PatchParameters, PolynomialExponential};
use proptest::prelude::*;

use bristle_specimens::recipe::{Recipe, recipe, state};
use bristle_specimens::specimens::{asymmetric, function};
use bristle_specimens::specimens::{
    coulomb, dahl, elasto_plastic, hyperbolic_tangent, implicit, kelvin_voigt, rational,
    square_root, stribeck, tabulated,
};

/// Every number of a model at some states, as bits.
fn bits<M: Bristle<f64, Deflection = f64>>(model: &M, states: &[(f64, f64)]) -> Vec<u64> {
    let affine = |a: Affine<f64>| [a.relaxation, a.drive, a.stiffness, a.damping];
    let linear = |l: Linearised<f64>| {
        [
            l.rate,
            l.coefficient,
            l.rate_by_deflection,
            l.rate_by_velocity,
            l.coefficient_by_deflection,
            l.coefficient_by_velocity,
        ]
    };
    let mut all = vec![model.storage_stiffness()];
    for law in Law::ALL {
        all.push(f64::from(u8::from(model.obeys(law))));
    }
    for &(v, z) in states {
        let branches = [Sliding::from(v), Branch::Forward.of(v), Branch::Backward.of(v)];
        let free = branches.map(Surface::from);
        for sliding in free.into_iter().chain([Surface::scaled(v, 0.3)]) {
            all.extend(affine(model.affine(sliding, z)));
            let (a, b) = model.affine_and_slopes(sliding, z);
            all.extend(affine(a).into_iter().chain(affine(b)));
            all.extend(linear(model.linearised(sliding, z)));
            all.extend(linear(model.steady_linearised(sliding)));
            all.extend([model.rate(sliding, z), model.coefficient(sliding, z)]);
            all.extend([model.stationary(sliding), model.stationary_coefficient(sliding)]);
        }
        let step = model.hold(v, z, 1e-3);
        all.extend([step.deflection, step.end_coefficient, step.mean_coefficient]);
        let limits = model.limits(v);
        let nothing = f64::INFINITY;
        all.push(limits.deflection.unwrap_or(nothing));
        all.push(limits.coefficient.unwrap_or(nothing));
        all.push(limits.relaxation_rate.unwrap_or(nothing));
        let companion = model.clone().under_load(2.0).unwrap().companion(1.0).unwrap();
        let step = companion.step(v, z, 1e-3);
        let done = step.commit(0.5 * v);
        all.extend([step.bias(), step.damping(), done.deflection, done.stored, done.dissipated]);
    }
    all.extend(format!("{:?}", model.characteristics(0.3)).bytes().map(f64::from));
    // One NaN is as good as another.
    all.into_iter().map(|x| if x.is_nan() { 0 } else { x.to_bits() }).collect()
}

fn same<M>(model: &M, states: &[(f64, f64)]) -> Result<(), TestCaseError>
where
    M: Bristle<f64, Deflection = f64> + Into<AnyBristle<f64>>,
{
    let any: AnyBristle<f64> = model.clone().into();
    prop_assert_eq!(bits(model, states), bits(&any, states), "{}", any.name());
    Ok(())
}

/// What a curve says of itself.
fn claims(c: &impl FrictionCurve<f64>) -> (f64, f64, Option<f64>, bool, [bristle::Bounds<f64>; 2]) {
    let bounds = [c.bounds(0.3), c.bounds(f64::INFINITY)];
    (c.viscous_friction(), c.slope_at_rest(), c.least_slope(), c.is_even(), bounds)
}

fn with_curve<C>(c: &C, r: &Recipe, states: &[(f64, f64)]) -> Result<(), TestCaseError>
where
    C: FrictionCurve<f64> + Into<AnyCurve<f64>>,
{
    let any: AnyCurve<f64> = c.clone().into();
    prop_assert_eq!(claims(c), claims(&any));
    prop_assert_eq!(
        claims(&c.with_less_viscous_friction(0.3 * c.viscous_friction())),
        claims(&any.with_less_viscous_friction(0.3 * any.viscous_friction()))
    );
    let bristle = || kelvin_voigt(r.stiffness, r.damping);
    let stick_limit = 0.5 * c.bounds(f64::INFINITY).min / r.stiffness;
    same(&FrBd::new(c.clone(), bristle()), states)?;
    same(&FrBd::new(c.clone(), bristle()).regularised(square_root(r)), states)?;
    same(&FrBd::new(c.clone(), bristle()).regularised(hyperbolic_tangent(r)), states)?;
    let creeping =
        MaxwellParameters { micro_stiffness: r.stiffness, series_damping: r.damping + 1.0 };
    same(&FrBd::new(c.clone(), Maxwell::new(creeping).unwrap()), states)?;
    same(&LuGre::classical(c.clone(), bristle()), states)?;
    same(&LuGre::with_viscous_friction(c.clone(), bristle(), 0.0).unwrap(), states)?;
    same(&LuGre::classical(c.clone(), bristle()).regularised(square_root(r)), states)?;
    same(&elasto_plastic(c.clone(), bristle(), stick_limit), states)?;
    let Some(fall) = c.least_slope().map(|slope| -slope).filter(|fall| fall.is_finite()) else {
        return Ok(());
    };
    let damped = kelvin_voigt(r.stiffness, r.damping + 1.1 * fall.max(0.0) + 1e-2);
    same(&implicit(c.clone(), damped), states)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(debug_assertions) { 24 } else { 256 }))]

    #[test]
    fn models_chosen_at_run_time_are_the_models(r in recipe(), s in state()) {
        let states = [
            (s.velocity, s.fraction * r.dynamic / r.stiffness),
            (-s.velocity, s.fraction * r.static_ / r.stiffness),
            (0.0, 0.0),
        ];
        with_curve(&coulomb(&r), &r, &states)?;
        with_curve(&stribeck(&r, 1.0), &r, &states)?;
        with_curve(&stribeck(&r, 2.0), &r, &states)?;
        with_curve(&stribeck(&r, 0.7), &r, &states)?;
        with_curve(&rational(&r), &r, &states)?;
        // Parameters come back as they were given.
        let given = (r.static_, r.dynamic, r.stribeck_velocity, r.viscous);
        let p = stribeck::<f64>(&r, 0.7).parameters();
        let back = (p.static_coefficient, p.dynamic_coefficient, p.stribeck_velocity);
        prop_assert_eq!((back.0, back.1, back.2, p.viscous_friction), given);
        let p = rational::<f64>(&r).parameters();
        let back = (p.static_coefficient, p.dynamic_coefficient, p.stribeck_velocity);
        prop_assert_eq!((back.0, back.1, back.2, p.viscous_friction), given);
        same(&dahl(&r), &states)?;
        {
            with_curve(&asymmetric(&r), &r, &states)?;
            let knots: Vec<Knot<f64>> = tabulated::<f64>(&r).knots().collect();
            with_curve(&Tabulated::from_slice(&knots).unwrap(), &r, &states)?;
            let bristle = kelvin_voigt(r.stiffness, r.damping);
            let own = AnyCurve::own(function(&r));
            let (fixed, any) = (FrBd::new(function(&r), bristle), FrBd::new(own, bristle));
            prop_assert_eq!(bits(&fixed, &states), bits(&any, &states));
        }
    }

    #[test]
    fn a_table_is_the_same_in_any_storage(r in recipe(), s in state()) {
        let array = tabulated::<f64>(&r);
        let knots: Vec<Knot<f64>> = array.knots().collect();
        let vector = Tabulated::from_slice(&knots).unwrap();
        let at = |v: f64| array.coefficient_and_slope(v.into());
        prop_assert_eq!(at(s.velocity), vector.coefficient_and_slope(s.velocity.into()));
        prop_assert_eq!(array.least_slope(), vector.least_slope());
        prop_assert_eq!(array.bounds(1.0), vector.bounds(1.0));
    }
}

fn rig<M: Bristle<f64, Deflection = f64>>(model: M) -> MassSpringDamper<f64, M, AnySignal<f64>> {
    let sine = SineParameters { mean: 0.5, amplitude: 1.2, frequency: 3.0, phase: 0.0 };
    MassSpringDamper::new(MassSpringDamperParameters {
        contact: model.under_load(1.0).unwrap(),
        mechanism: Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.1 },
        drive_velocity: 0.1,
        force: Sine::new(sine).unwrap().into(),
    })
    .unwrap()
}

fn run<M: Method<f64, 3>>(
    solver: impl FnOnce(Tolerances<f64, 3>) -> Solver<f64, M, 3>,
) -> (f64, [f64; 3], u64) {
    let curve = Stribeck::new(paper::STICK_SLIP_CURVE).unwrap();
    let model = FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE).unwrap());
    let rig = rig(AnyBristle::from(model));
    let mut ignore = |_: &bristle::ode::Step<f64, 3>| core::ops::ControlFlow::Continue(());
    let Summary { time, state, statistics, .. } =
        solver(Tolerances::scaled(1e-5, rig.scales()).unwrap())
            .stream(&rig, 0.0..0.5, rig.at_rest(), &[], &mut ignore)
            .unwrap();
    (time, state.into(), statistics.evaluations)
}

/// Adaptive steps of a method.
fn adaptive<M: Method<f64, 3>>(method: M) -> (f64, [f64; 3], u64) {
    run(|tolerances| Solver::checked(method, tolerances))
}

#[test]
fn methods_chosen_at_run_time_take_the_same_steps() {
    assert_eq!(adaptive(Automatic), adaptive(AnyMethod::Automatic));
    assert_eq!(adaptive(DormandPrince), adaptive(AnyMethod::DormandPrince));
    assert_eq!(adaptive(DormandPrince8), adaptive(AnyMethod::DormandPrince8));
    assert_eq!(adaptive(Rodas4), adaptive(AnyMethod::Rodas4));
    assert_eq!(adaptive(Rodas5P), adaptive(AnyMethod::Rodas5P));
    let (fixed, any) = (RungeKutta4, AnyMethod::RungeKutta4);
    let step = 1e-3;
    assert_eq!(
        run(|_| Solver::fixed(fixed, step).unwrap()),
        run(|_| Solver::fixed(any, step).unwrap())
    );
    for name in ["automatic", "dormand_prince", "rodas4", "rodas5p", "runge_kutta4"] {
        assert_eq!(name.parse::<AnyMethod>().unwrap().to_string(), name);
    }
    let refused = "euler".parse::<AnyMethod>().unwrap_err().to_string();
    assert!(refused.starts_with("a method is automatic, dormand_prince, "), "{refused}");
}

/// A candidate of the identification whose model is chosen at run time.
#[derive(Debug)]
struct AnyFit;

impl bristle_identify::Candidate<2> for AnyFit {
    type Model<T: bristle::Scalar> = AnyBristle<T>;

    fn parameters(
        &self,
        guess: &bristle_identify::InitialGuess,
    ) -> [bristle_identify::Parameter; 2] {
        use bristle_identify::Parameter;
        [
            Parameter::positive("dynamic_coefficient", "", guess.dynamic_coefficient, 10.0),
            Parameter::positive("micro_stiffness", "1/m", guess.micro_stiffness, 100.0),
        ]
    }

    fn model<T: bristle::Scalar>(
        &self,
        &[dynamic_coefficient, micro_stiffness]: &[T; 2],
    ) -> Result<AnyBristle<T>, ParameterError> {
        let parameters = bristle::DahlParameters { dynamic_coefficient, micro_stiffness };
        Ok(bristle::Dahl::new(parameters)?.into())
    }
}

/// FrBD and the elasto-plastic model, chosen at run time.
fn two() -> [AnyBristle<f64>; 2] {
    let curve = Stribeck::new(paper::STICK_SLIP_CURVE).unwrap();
    let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE).unwrap();
    [FrBd::new(curve, bristle).into(), elasto_plastic(curve, bristle, 5e-5).into()]
}

fn patch(model: AnyBristle<f64>) -> Result<f64, ParameterError> {
    let pressure = AnyPressure::Quadratic(PolynomialExponential::parabolic());
    let patch = Patch::new(PatchParameters { model, length: 0.1, pressure })?.under_load(100.0)?;
    Ok(patch.steady(Motion { slip_velocity: 0.1, rolling_speed: 2.0 })?.force)
}

fn observer(model: AnyBristle<f64>) -> Result<f64, ParameterError> {
    let velocity = VelocityFromPositionParameters {
        sample_time: 1e-3,
        time_constant: 2e-3,
        fastest: 0.5,
        count: 0.0,
    };
    let mut observer = FrictionObserver::new(ObserverParameters {
        contact: model.under_load(1.0)?,
        mass: 1.0,
        proportional_gain: 400.0,
        derivative_gain: 30.0,
        integral_gain: 1000.0,
        injection: Injection::Velocity { gain: 0.1, corner: 10.0 },
        velocity,
        output: OutputParameters { share: 1.0, largest_force: 3.0 },
    })?;
    let _ = observer.step(0.0, 1e-4);
    Ok(observer.step(1e-5, 1e-4).force)
}

fn feed_forward(model: AnyBristle<f64>) -> Result<f64, ParameterError> {
    let mut compensator = FeedForwardCompensator::new(FeedForwardParameters {
        contact: model.under_load(1.0)?,
        sample_time: 1e-3,
        fastest: 1.0,
        output: OutputParameters { share: 1.0, largest_force: 3.0 },
    })?;
    Ok(compensator.step(0.01).force)
}

#[test]
fn every_module_takes_a_model_chosen_at_run_time() {
    let [frbd, elastic] = two();
    for model in two() {
        assert!(feed_forward(model).unwrap() > 0.0);
    }
    assert!(patch(frbd.clone()).unwrap() > 0.0 && observer(frbd.clone()).is_ok());
    assert!(Batch::of(&frbd).is_ok());
    {
        let fitted: Result<AnyBristle<f64>, _> =
            bristle_identify::Candidate::model(&AnyFit, &[0.5, 1e4]);
        assert_eq!(fitted.unwrap().name(), "Dahl");
    }
    let fixed = {
        let curve = Stribeck::new(paper::STICK_SLIP_CURVE).unwrap();
        FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE).unwrap())
    };
    let (contact, fixed) = (frbd.clone().under_load(1.0).unwrap(), fixed.under_load(1.0).unwrap());
    let parameters = AuditParameters::up_to(0.5);
    assert_eq!(
        audit(&contact, parameters).unwrap().to_string(),
        audit(&fixed, parameters).unwrap().to_string()
    );
    {
        use bristle_fidelity::{Answers, KnownVelocity, Tolerance, choose};
        let velocity =
            Sine::new(SineParameters { mean: 0.0, amplitude: 1e-3, frequency: 1.0, phase: 0.0 })
                .unwrap();
        let answers = Answers { interval: 0.01, count: 200 };
        let tolerance = Tolerance::at_every_answer(0.05);
        let any = KnownVelocity::new(contact, velocity, answers).unwrap();
        let fixed = KnownVelocity::new(fixed, velocity, answers).unwrap();
        let (any, fixed) = (choose(&any, tolerance).unwrap(), choose(&fixed, tolerance).unwrap());
        assert_eq!(format!("{any:?}"), format!("{fixed:?}"));
    }
    let refused = [
        patch(elastic.clone()).unwrap_err().to_string(),
        observer(elastic.clone()).unwrap_err().to_string(),
        Batch::of(&elastic).unwrap_err().to_string(),
    ];
    for (told, who) in refused.into_iter().zip(["a patch", "an observer", "a batch"]) {
        assert!(told.starts_with(&format!("{who} takes ")), "{told}");
        assert!(told.ends_with(", not elasto-plastic FrBD"), "{told}");
    }
}

#[test]
fn a_controller_takes_another_model_without_losing_its_state() {
    let [frbd, _] = two();
    let lugre = {
        let curve = Stribeck::new(paper::STICK_SLIP_CURVE).unwrap();
        LuGre::classical(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE).unwrap())
    };
    let output = OutputParameters { share: 1.0, largest_force: 3.0 };
    let parameters = |model: AnyBristle<f64>, sample_time| FeedForwardParameters {
        contact: model.under_load(1.0).unwrap(),
        sample_time,
        fastest: 1.0,
        output,
    };
    let mut changed = FeedForwardCompensator::new(parameters(frbd.clone(), 1e-3)).unwrap();
    for _ in 0..10 {
        let _ = changed.step(0.003);
    }
    let deflection = changed.step(0.003).deflection;
    // What is refused changes nothing.
    let before = changed.clone();
    assert!(changed.change(parameters(frbd, -1.0)).is_err());
    assert_eq!(format!("{before:?}"), format!("{changed:?}"));
    changed.change(parameters(lugre.into(), 1e-3)).unwrap();
    let held = lugre.under_load(1.0).unwrap().hold(0.003, deflection, 1e-3);
    let answer = changed.step(0.003);
    assert_eq!((answer.force, answer.deflection), (held.mean_force, held.deflection));

    // Of an observer: equal parameters change nothing, and bad gains are refused.
    let velocity = VelocityFromPositionParameters {
        sample_time: 1e-3,
        time_constant: 2e-3,
        fastest: 0.5,
        count: 0.0,
    };
    let parameters = |derivative_gain| ObserverParameters {
        contact: two()[0].clone().under_load(1.0).unwrap(),
        mass: 1.0,
        proportional_gain: 400.0,
        derivative_gain,
        integral_gain: 1000.0,
        injection: Injection::Velocity { gain: 0.1, corner: 10.0 },
        velocity,
        output,
    };
    let mut steady = FrictionObserver::new(parameters(30.0)).unwrap();
    let mut changed = steady.clone();
    for sample in 0..50 {
        let position = 1e-6 * f64::from(sample * sample);
        // A sample is lost now and then.
        let position = if sample % 7 == 3 { f64::NAN } else { position };
        assert!(changed.change(parameters(1.0)).is_err());
        changed.change(parameters(30.0)).unwrap();
        assert_eq!(steady.step(position, 1e-3), changed.step(position, 1e-3));
    }
}
