//! Whatever takes a model, a pressure or a signal gives the same numbers, to the last bit, for one
//! that is chosen at run time: scenes, wheels, patches, compensators.

use bristle::control::{
    FeedForwardCompensator, FeedForwardParameters, FeedbackCompensator, FeedbackParameters,
    FrictionObserver, Injection, MicroDamping, ObserverParameters, OutputParameters,
    VelocityFromPositionParameters,
};
use bristle::curve::{AnyCurve, FrictionCurve};
use bristle::nalgebra::{Complex, SVector, Vector2, Vector6};
use bristle::ode::System;
use bristle::regularisation::{AnyRegularisation, Regularisation, Unregularised};
use bristle::rheology::{GeneralisedMaxwell, GeneralisedMaxwellParameters, MaxwellArm, Rheology};
use bristle::scene::{
    DiaphragmValve, DiaphragmValveParameters, MassSpringDamper, MassSpringDamperParameters,
    PrescribedVelocity,
};
use bristle::signal::{AnySignal, Signal, Sine, SineParameters};
use bristle::{AnyBristle, Branch, Bristle, FrBd, LuGre, Mechanism};
use bristle_joint::{GearFriction, GearFrictionParameters, TorqueLoad, TorqueLoadParameters};
use bristle_joint::{GearedJoint, GearedJointParameters, Gravity, JointInput, JointMotion};
use bristle_plane::{Axis, PlaneBristle, PlaneFrBd, PlaneLuGre};
use bristle_plane::{PlaneBody, PlaneBodyParameters};
use bristle_rolling::{
    AnyPressure, Motion, Patch, PatchParameters, PolynomialExponential,
    PolynomialExponentialParameters, Pressure, Segment,
};
use bristle_rolling::{BrakedWheel, BrakedWheelParameters, Tyre, WheelLoads};
use proptest::prelude::*;

use bristle_specimens::recipe::{Recipe, recipe, state};
use bristle_specimens::specimens::{
    coulomb, dahl, elasto_plastic, kelvin_voigt, square_root, stribeck,
};

/// Numbers as bits; one NaN is as good as another.
fn bits(numbers: impl IntoIterator<Item = f64>) -> Vec<u64> {
    numbers.into_iter().map(|x| if x.is_nan() { 0 } else { x.to_bits() }).collect()
}

fn sine(r: &Recipe) -> Sine<f64> {
    let (mean, amplitude) = (0.1 * r.load, r.load);
    Sine::new(SineParameters { mean, amplitude, frequency: 3.0, phase: 0.4 }).unwrap()
}

/// Rates and derivatives of a system at a time and a state, on each branch.
fn rates<S: System<f64, N, 1>, const N: usize>(system: &S, state: SVector<f64, N>) -> Vec<f64> {
    let mut all: Vec<f64> = system.scales().iter().copied().collect();
    for branch in [Branch::Free, Branch::Forward, Branch::Backward] {
        all.extend(system.rate(0.3, &state, [branch]).iter());
        if let Some(linear) = system.linearised(0.3, &state, [branch]) {
            all.extend(linear.rate.iter().chain(linear.by_state.iter()).chain(&linear.by_time));
        }
    }
    all
}

/// What a model does in every scene of one contact, driven by a signal.
fn scenes<M, F>(model: &M, signal: &F, r: &Recipe, [v, z]: [f64; 2]) -> Vec<u64>
where
    M: Bristle<f64, Deflection = f64>,
    F: Signal<f64> + JointInput<f64>,
{
    let contact = || model.clone().under_load(r.load).unwrap();
    let mechanism = Mechanism { mass: 1.3, spring_stiffness: 20.0, viscous_damping: 0.2 };
    let mut all = rates(&PrescribedVelocity::new(contact(), signal.clone()), [z].into());
    let rig = MassSpringDamper::new(MassSpringDamperParameters {
        contact: contact(),
        mechanism,
        drive_velocity: 0.1,
        force: signal.clone(),
    });
    all.extend(rates(&rig.unwrap(), [0.01, v, z].into()));
    let valve = DiaphragmValve::new(DiaphragmValveParameters {
        contact: contact(),
        mechanism,
        diaphragm_area: 0.04,
        preload: 2500.0,
        least_pressure: 4e4,
        pressure_gain: 1600.0,
        time_constant: 0.9,
        opening: signal.clone(),
    });
    all.extend(rates(&valve.unwrap(), [0.01, v, z, 5e4].into()));
    let load = TorqueLoadParameters { idle_load: 0.5, motor_share: 1.0, external_share: 0.6 };
    let gear = GearFriction::new(GearFrictionParameters {
        friction: model.clone(),
        load: TorqueLoad::new(load).unwrap(),
        reference_load: 1.0,
        drag: 0.05,
        fastest: 10.0,
    });
    let joint = GearedJoint::new(GearedJointParameters {
        gear: gear.unwrap(),
        inertia: 0.02,
        motor: signal.clone(),
        external: Gravity { horizontal_torque: 1.2, hanging_angle: 0.1 },
    });
    all.extend(rates(&joint.unwrap(), [0.01, v, z].into()));
    bits(all)
}

fn encoder() -> VelocityFromPositionParameters<f64> {
    VelocityFromPositionParameters {
        sample_time: 1e-3,
        time_constant: 2e-3,
        fastest: 10.0,
        count: 1e-6,
    }
}

/// What compensators give for a model over some samples of a motion.
fn controllers<M: Bristle<f64, Deflection = f64>>(model: &M, r: &Recipe, v: f64) -> Vec<u64> {
    let contact = || model.clone().under_load(r.load).unwrap();
    let output = OutputParameters { share: 0.9, largest_force: 3.0 * r.load };
    let velocity = encoder();
    let forward =
        FeedForwardParameters { contact: contact(), sample_time: 1e-3, fastest: 10.0, output };
    let mut forward = FeedForwardCompensator::new(forward).unwrap();
    let damping = MicroDamping::Filtered;
    let back = FeedbackParameters { contact: contact(), velocity, damping, output };
    let mut back = FeedbackCompensator::new(back).ok();
    let mut all = Vec::new();
    for sample in 0..20 {
        let time = 1e-3 * f64::from(sample);
        let (position, velocity) = (v * (9.0 * time).sin() / 9.0, v * (9.0 * time).cos());
        all.push(forward.step(velocity).force);
        all.extend(back.as_mut().map(|back| back.step(position).force));
    }
    bits(all)
}

/// What an observer gives for a model over some samples of a motion.
fn observed<M: Bristle<f64, Deflection = f64>>(model: M, v: f64) -> Vec<u64> {
    let velocity = encoder();
    let output = OutputParameters { share: 0.9, largest_force: 30.0 };
    let mut observer = FrictionObserver::new(ObserverParameters {
        contact: model.under_load(10.0).unwrap(),
        mass: 1.0,
        proportional_gain: 400.0,
        derivative_gain: 30.0,
        integral_gain: 1000.0,
        injection: Injection::Velocity { gain: 0.1, corner: 10.0 },
        velocity,
        output,
    })
    .unwrap();
    let position = |sample| v * (9e-3 * f64::from(sample)).sin() / 9.0;
    bits((0..20).map(|sample| observer.step(position(sample), 0.1).force))
}

/// What a tyre does under a wheel that brakes.
fn wheel<P: Tyre<f64>>(tyre: P, lateral_velocity: f64) -> Vec<u64> {
    let brake = FrBd::new(coulomb(&Recipe::TABLE_2), kelvin_voigt(20.0, 0.1));
    let mut wheel = BrakedWheel::new(BrakedWheelParameters {
        tyre,
        brake: brake.under_load(0.0).unwrap().measured_at(1500.0).unwrap(),
        mass: 400.0,
        inertia: 1.0,
        radius: 0.3,
        speed: 20.0,
        angular_velocity: 66.0,
    })
    .unwrap();
    let loads = WheelLoads { lateral_velocity, ..WheelLoads::braking(300.0) };
    let states = (0..10).map(|_| wheel.step(loads, 2e-3).unwrap());
    let states: Vec<_> = states.collect();
    bits(states.iter().flat_map(|s| [s.speed, s.angular_velocity, s.force, s.lateral_force]))
}

/// What the bristles of a model do in a patch: steady rolling and a braked wheel.
fn patch<M: Bristle<f64, Deflection = f64>, P: Pressure<f64>>(
    model: M,
    pressure: P,
    v: f64,
) -> Vec<u64> {
    let patch = Patch::new(PatchParameters { model, length: 0.1, pressure }).unwrap();
    let patch = patch.under_load(4000.0).unwrap();
    let motion = Motion { slip_velocity: v, rolling_speed: 5.0 };
    bits(patch.steady(motion).map_or([0.0; 2], |steady| [steady.force, steady.entry_coefficient]))
}

fn rolling<M: Bristle<f64, Deflection = f64>>(model: M) -> Vec<u64> {
    let pressure = PolynomialExponential::parabolic();
    let patch = Patch::new(PatchParameters { model, length: 0.1, pressure }).unwrap();
    wheel(patch.under_load(4000.0).unwrap().exact([[Segment::default(); 60]]).unwrap(), 0.0)
}

/// A model and the one chosen at run time, everywhere.
fn same<M>(model: M, r: &Recipe, [v, z]: [f64; 2]) -> Result<(), TestCaseError>
where
    M: Bristle<f64, Deflection = f64> + Into<AnyBristle<f64>>,
{
    let any: AnyBristle<f64> = model.clone().into();
    let signal = AnySignal::from(sine(r));
    let scene = scenes(&any, &signal, r, [v, z]);
    prop_assert_eq!(scenes(&model, &sine(r), r, [v, z]), scene, "{}", any.name());
    prop_assert_eq!(controllers(&model, r, v), controllers(&any, r, v), "{}", any.name());
    Ok(())
}

fn same_rolling<M>(model: M, v: f64) -> Result<(), TestCaseError>
where
    M: Bristle<f64, Deflection = f64> + Into<AnyBristle<f64>>,
{
    let any: AnyBristle<f64> = model.clone().into();
    let (pressure, chosen) = (PolynomialExponential::parabolic(), AnyPressure::Quadratic);
    let patch_of_any = patch(any.clone(), chosen(pressure), v);
    prop_assert_eq!(patch(model.clone(), pressure, v), patch_of_any);
    prop_assert_eq!(observed(model.clone(), v), observed(any.clone(), v));
    prop_assert_eq!(rolling(model), rolling(any));
    Ok(())
}

/// What a model of two axes does: in a plane, and in the tyre of a wheel that is steered.
fn plane<M>(model: &M, [v, z]: [f64; 2]) -> Vec<u64>
where
    M: PlaneBristle<f64, 2>,
{
    let contact = model.clone().under_load(4000.0).unwrap();
    let (velocity, deflection) = (Vector2::new(v, -0.3 * v), Vector2::new(z, 0.5 * z));
    let mut all: Vec<f64> = contact.stationary_force(&velocity).iter().copied().collect();
    let held = contact.hold(&velocity, &deflection, 1e-3);
    all.extend(held.mean_force.iter().chain(&held.deflection));
    let free = Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.1 };
    let body =
        PlaneBodyParameters { contact, mechanisms: [free; 2], anchor: [0.1; 2], force: [0.2; 2] };
    let body = PlaneBody::new(body).unwrap();
    let state = Vector6::new(0.0, 0.1, v, -0.3 * v, z, 0.5 * z);
    let linear = body.linearised(0.3, &state, []).unwrap();
    let scales: Vector6<f64> = body.scales();
    all.extend(body.rate(0.3, &state, []).iter().chain(&linear.by_state).chain(&scales));
    let pressure = PolynomialExponential::constant();
    let patch = Patch::new(PatchParameters { model: model.clone(), length: 0.1, pressure });
    let patch = patch.unwrap().under_load(4000.0).unwrap();
    let tyre = patch.exact([[Segment::default(); 60]; 2]).unwrap();
    [bits(all), wheel(tyre, 0.4)].concat()
}

/// What a bristle of several springs does.
fn springs<R, C, E>(bristle: R, curve: C, modulus: E, [v, z]: [f64; 2]) -> Vec<u64>
where
    R: Rheology<f64, Deflection = SVector<f64, 2>>,
    C: FrictionCurve<f64>,
    E: Regularisation<f64>,
{
    let contact = FrBd::new(curve, bristle).regularised(modulus).under_load(3.0).unwrap();
    let stretches = [z, -0.3 * z].into();
    let held = contact.hold(v, stretches, 1e-3);
    let rate = contact.rate(v, stretches);
    bits(held.deflection.iter().chain(&rate).copied().chain([held.mean_force]))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(debug_assertions) { 16 } else { 128 }))]

    #[test]
    fn scenes_and_controllers_take_models_chosen_at_run_time(r in recipe(), s in state()) {
        let at = [s.velocity, s.fraction * r.dynamic / r.stiffness];
        let bristle = || kelvin_voigt(r.stiffness, r.damping);
        let curve = stribeck(&r, 2.0);
        let stick_limit = 0.5 * curve.bounds(f64::INFINITY).min / r.stiffness;
        same(FrBd::new(curve, bristle()), &r, at)?;
        same(FrBd::new(curve, bristle()).regularised(square_root(&r)), &r, at)?;
        same(LuGre::classical(curve, bristle()), &r, at)?;
        same(dahl(&r), &r, at)?;
        same(elasto_plastic(curve, bristle(), stick_limit), &r, at)?;
    }

    #[test]
    fn patches_and_wheels_take_models_chosen_at_run_time(r in recipe(), s in state()) {
        let curve = stribeck(&r, 2.0);
        same_rolling(FrBd::new(curve, kelvin_voigt(r.stiffness, r.damping)), s.velocity)?;
        same_rolling(LuGre::classical(curve, kelvin_voigt(r.stiffness, 0.0)), s.velocity)?;
        same_rolling(dahl(&r), s.velocity)?;
    }

    #[test]
    fn several_axes_and_springs_take_curves_chosen_at_run_time(r in recipe(), s in state()) {
        let at = [s.velocity, s.fraction * r.dynamic / r.stiffness];
        let axis = |friction_ratio, factor| Axis {
            friction_ratio,
            bristle: kelvin_voigt(factor * r.stiffness, r.damping),
        };
        let axes = [axis(1.0, 1.0), axis(0.6, 0.7)];
        let curve = stribeck::<f64>(&r, 0.7);
        let (any, rough) = (AnyCurve::from(curve), AnyRegularisation::from(Unregularised));
        let (smooth, modulus) = (square_root::<f64>(&r), AnyRegularisation::from(square_root(&r)));
        let fixed = PlaneFrBd::new(curve, axes).unwrap();
        let chosen = PlaneFrBd::new(any.clone(), axes).unwrap();
        prop_assert_eq!(plane(&fixed, at), plane(&chosen.clone().regularised(rough), at));
        let smoothed = chosen.regularised(modulus);
        prop_assert_eq!(plane(&fixed.regularised(smooth), at), plane(&smoothed, at));
        let fixed = PlaneLuGre::classical(curve, axes).unwrap();
        let chosen = PlaneLuGre::classical(any.clone(), axes).unwrap();
        prop_assert_eq!(plane(&fixed, at), plane(&chosen.regularised(rough), at));

        let damping = r.damping + 1.0;
        let arms = [
            MaxwellArm { stiffness: r.stiffness, series_damping: None },
            MaxwellArm { stiffness: 2.0 * r.stiffness, series_damping: Some(damping) },
        ];
        let beside = GeneralisedMaxwellParameters { arms, micro_damping: r.damping };
        let beside = GeneralisedMaxwell::new(beside).unwrap();
        let chosen = springs(beside, any.clone(), modulus, at);
        prop_assert_eq!(springs(beside, curve, smooth, at), chosen);
    }

    #[test]
    fn pressures_and_signals_chosen_at_run_time_are_what_they_hold(
        c in prop::array::uniform3(0.0..5.0_f64),
        decay in 0.0..3.0_f64,
        place in 0.0..=1.0_f64,
    ) {
        fn integrals(p: &impl Pressure<f64>, place: f64) -> Vec<u64> {
            let (at, knot) = (p.at_and_slope(place), p.next_knot(place).unwrap_or(2.0));
            let wave = Complex::new(0.3, 4.0 * place);
            let (transform, slope) = (p.transform(wave), p.transform_slope(0.1, wave));
            bits([
                p.at(place), at.0, at.1, knot, p.total(), p.rise(place), p.remaining(place),
                p.lever(place), transform.re, transform.im, slope.re, slope.im,
            ])
        }
        macro_rules! same {
            ($variant:ident, $pressure:expr) => {
                let pressure = $pressure;
                let any = AnyPressure::$variant(pressure.clone());
                prop_assert_eq!(integrals(&pressure, place), integrals(&any, place));
            };
        }
        let of = |coefficients| PolynomialExponentialParameters { coefficients, decay };
        same!(Quadratic, PolynomialExponential::new(of(c)).unwrap());
        same!(Exponential, PolynomialExponential::new(PolynomialExponentialParameters {
            coefficients: [c[0]],
            decay,
        }).unwrap());
        same!(Polynomial, PolynomialExponential::new(of(c)).unwrap().padded::<12>());

        fn values(s: &(impl Signal<f64> + JointInput<f64>), time: f64) -> Vec<u64> {
            let (value, rate) = s.value_and_rate(time);
            let kink = Signal::next_kink(s, time, 2.0).unwrap_or(9.0);
            let input = s.at(JointMotion { time, angle: 0.1, velocity: 0.2 });
            let longest = Signal::longest_step(s).unwrap_or(9.0);
            bits([s.value(time), value, rate, kink, longest, input.value])
        }
        let [mean, amplitude, frequency] = [c[0], c[1], 0.1 + c[2]];
        let sine = SineParameters { mean, amplitude, frequency, phase: decay };
        let sine = Sine::new(sine).unwrap();
        prop_assert_eq!(values(&sine, place), values(&AnySignal::from(sine), place));
        prop_assert_eq!(values(&c[0], place), values(&AnySignal::from(c[0]), place));
        {
            use bristle_rolling::FunctionPressure;
            use bristle::signal::{Polyline, Vertex};
            let vertex = |time, value| Vertex { time, value };
            let line = [vertex(0.0, c[0]), vertex(0.4, c[1]), vertex(1.0, c[2])].to_vec();
            let line = Polyline::new(line).unwrap();
            same!(Polyline, FunctionPressure::new(line.clone()).unwrap());
            prop_assert_eq!(values(&line, place), values(&AnySignal::from(line), place));
        }
    }
}

#[test]
fn the_ladder_of_models_takes_mechanisms_and_patches_chosen_at_run_time() {
    use bristle_fidelity::{Answers, MechanismScene, PatchScene, Quantity, Tolerance, choose};

    let r = &Recipe::TABLE_2;
    let fixed = FrBd::new(stribeck(r, 2.0), kelvin_voigt(r.stiffness, r.damping));
    let answers = Answers { interval: 0.01, count: 100 };
    fn pulled<M>(model: M, answers: Answers<f64>) -> String
    where
        M: Bristle<f64, Deflection = f64>,
    {
        let rig = bristle::paper::stick_slip_rig(model.under_load(1.0).unwrap());
        let rig = MassSpringDamper::new(rig).unwrap();
        let scene = MechanismScene::new(rig, [0.0; 3].into(), answers, Quantity::Position);
        format!("{:?}", choose(&scene.unwrap(), Tolerance::at_every_answer(1e-3)).unwrap())
    }
    assert_eq!(pulled(fixed, answers), pulled(AnyBristle::from(fixed), answers));

    let answers = Answers { interval: 1e-3, count: 100 };
    fn rolled<M>(model: M, answers: Answers<f64>) -> String
    where
        M: Bristle<f64, Deflection = f64>,
    {
        let pressure = PolynomialExponential::parabolic();
        let patch = Patch::new(PatchParameters { model, length: 0.1, pressure }).unwrap();
        let motion = Motion { slip_velocity: sine(&Recipe::TABLE_2), rolling_speed: 5.0 };
        let scene = PatchScene::new(patch.under_load(1e3).unwrap(), motion, answers).unwrap();
        format!("{:?}", choose(&scene, Tolerance::at_every_answer(50.0)).unwrap())
    }
    assert_eq!(rolled(fixed, answers), rolled(AnyBristle::from(fixed), answers));
}
