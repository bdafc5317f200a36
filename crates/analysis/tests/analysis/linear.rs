//! Linearised contacts and mechanisms against printed values, closed forms, the runs of the
//! nonlinear models themselves, and what they refuse.

use std::f64::consts::TAU;
use std::ops::{ControlFlow, Range};

use bristle::curve::{FrictionCurve, FunctionCurve, Stribeck, StribeckParameters};
use bristle::ode::{DormandPrince8, Solver, Step, System, Tolerances};
use bristle::regularisation::{HyperbolicTangent, Regularisation, SquareRoot, Unregularised};
use bristle::rheology::{Deflection, GeneralisedMaxwell, KelvinVoigt};
use bristle::scene::{
    DiaphragmValve, MassSpringDamper, MassSpringDamperParameters, PrescribedVelocity,
};
use bristle::signal::{Sine, SineParameters};
use bristle::{
    Bounds, Branch, Bristle, Contact, Dahl, DahlParameters, FrBd, LuGre, Mechanism, ParameterError,
    Rule, Scalar, Sliding, paper,
};
use bristle_analysis::linear::{
    StateSpace, SteadySliding, Threshold, critical_speed, critical_stiffness, state_space,
    steady_sliding, steady_state_space,
};
use bristle_specimens::own_rheology::{VelocityLaw, own_element};
use bristle_specimens::recipe::{decades, nonzero_velocity, recipe};
use bristle_specimens::specimens::{
    coulomb, elasto_plastic, kelvin_voigt, rational, square_root, stribeck, table_2_bristle,
    table_2_curve, table_2_frbd, table_2_lugre,
};
use bristle_specimens::viscoelastic::{Subject, arms, maxwell};
use bristle_specimens::{assert_within, check, lit};
use nalgebra::{
    Complex, ComplexField, Matrix1, Matrix3, RowVector3, RowVector4, SMatrix, SVector, Vector2,
    Vector3, Vector4,
};
use proptest::prelude::*;

fn table_2() -> Contact<f64, FrBd<Stribeck<f64>, KelvinVoigt<f64>>> {
    table_2_frbd().under_load(1.0).unwrap()
}

fn modulus(z: Complex<f64>) -> f64 {
    ComplexField::modulus(z)
}

/// σ0 = 100 (1 + 0.3 tanh v), σ1 = 5 e^(−v²/4) + 1, μ = 0.8 + 0.5 e^(−4v²) + 0.1|v|_ε, ε = 0.01.
fn all_varying() -> impl Bristle<f64, Deflection = f64> {
    let stiffness = VelocityLaw::new(
        |sliding: Sliding<f64>| {
            let t = sliding.velocity().tanh();
            (100.0 * (1.0 + 0.3 * t), 30.0 * (1.0 - t * t))
        },
        Bounds { min: 70.0, max: 130.0 },
    );
    let damping = VelocityLaw::new(
        |sliding: Sliding<f64>| {
            let v = sliding.velocity();
            let bell = 5.0 * (-0.25 * v * v).exp();
            (bell + 1.0, -0.5 * v * bell)
        },
        Bounds { min: 1.0, max: 6.0 },
    );
    let curve = FunctionCurve::new(
        |s: f64| {
            let (bell, modulus) = (0.5 * (-4.0 * s * s).exp(), (s * s + 0.01).sqrt());
            (0.8 + bell + 0.1 * modulus, -8.0 * s * bell + 0.1 * s / modulus)
        },
        Bounds { min: 0.8, max: f64::INFINITY },
    )
    .unwrap();
    FrBd::new(curve, own_element(stiffness, damping)).regularised(SquareRoot::new(0.01).unwrap())
}

#[test]
fn the_velocity_derivatives_of_an_frbd_model_with_everything_varying_are_those_of_computer_algebra()
{
    // H1 and H2 by a computer algebra system and by finite differences in high precision, here to
    // all digits they were printed with.
    let (v, z) = (0.37, 0.0063);
    let contact = all_varying().under_load(2.0).unwrap();
    let small = state_space(&contact, v, z).unwrap();
    assert_eq!(format!("{:.12}", small.input.x), "-0.027262038347");
    assert_eq!(format!("{:.13}", small.feedthrough / 2.0), "-0.0335609575841");
    assert_eq!(small.dynamics.x, -contact.model().affine(v.into(), z).relaxation);
    assert_eq!(small.output.x, 2.0 * contact.model().affine(v.into(), z).stiffness);
}

/// The transfer function of FrBD with constant σ0, σ1 in steady sliding from its curve alone.
fn assert_transfer<C: FrictionCurve<f64>, E: Regularisation<f64>>(
    (curve, regularisation): (&C, &E),
    (stiffness, damping, load): (f64, f64, f64),
    v: f64,
    s: Complex<f64>,
) {
    let model = FrBd::new(curve.clone(), kelvin_voigt(stiffness, damping))
        .regularised(regularisation.clone());
    let small = steady_state_space(&model.under_load(load).unwrap(), v).unwrap();

    let (mu, mu_slope) = curve.coefficient_and_slope(v.into());
    let (speed, sign) = (regularisation.speed(v.into()), regularisation.sign(v.into()));
    let (_, sign_slope) = regularisation.sign_and_slope(v.into());
    let g = damping * speed + mu;
    let relaxation = stiffness * speed / g;
    let slope = mu_slope * sign + mu * sign_slope;
    let shape = (s * damping + stiffness) / (s + relaxation);
    let want = shape * (load * speed / g * slope);
    let got = small.transfer(s);
    // H1 is the sum of r, r'v and −λ'z, each as large as one and the slopes' terms; about ten
    // roundings.
    let terms = 2.0 + v.abs() / g * (mu_slope.abs() + damping) + speed / g * slope.abs();
    let scale = load * terms * modulus(shape);
    let off = modulus(got - want);
    assert!(off <= 1e-13 * scale, "{curve:?} {regularisation:?} at {v:e}: {got} is not {want}");
    // Its pole and, relative to all that cancels, its gain.
    let [pole] = small.poles().unwrap();
    assert_within(4e-16, relaxation, pole.re, -relaxation, || "pole".to_owned());
    let gain = small.static_gain().unwrap();
    let scale = load * terms * stiffness / relaxation;
    assert_within(1e-13, scale, gain, load * slope, || format!("gain at {v:e}"));
}

#[test]
fn in_steady_sliding_the_transfer_function_follows_from_the_curve() {
    let frequencies = (decades(1e-6, 1e6), decades(1e-6, 1e6));
    check(256, (recipe(), nonzero_velocity(), frequencies), |(r, v, (re, im))| {
        let v = v.clamp(-1e2, 1e2);
        let bristle = (r.stiffness, r.damping, r.load);
        let s = Complex::new(re, im) * (r.stiffness / (r.damping + r.dynamic));
        let root = SquareRoot::new(r.epsilon).unwrap();
        let tangent = HyperbolicTangent::new(r.threshold.max(v.abs() / 15.0)).unwrap();
        for exponent in [2.0, 3.3] {
            let curve = stribeck(&r, exponent);
            assert_transfer((&curve, &Unregularised), bristle, v, s);
            assert_transfer((&curve, &root), bristle, v, s);
            assert_transfer((&curve, &tangent), bristle, v, s);
        }
        assert_transfer((&rational(&r), &root), bristle, v, s);
        assert_transfer((&coulomb(&r), &Unregularised), bristle, v, s);
    });
}

#[test]
fn the_transfer_of_a_damped_bristle_vanishes_at_its_own_rate() {
    // σ0 + σ1 s = 0. The sum of λ and σ0/σ1 (31.9 and 155) with H1 cancelled to one part in ten.
    let small = steady_state_space(&table_2(), 5.5e-3).unwrap();
    let zero = small.transfer(Complex::new(-1e4 / 64.5, 0.0));
    assert!(modulus(zero) < 1e-13 * small.feedthrough.abs(), "{zero}");
}

/// A Maxwell element beside a spring: two stretches.
fn zener() -> GeneralisedMaxwell<f64, 2> {
    arms([(1e4, None), (3e4, Some(600.0))], 2.0)
}

#[test]
fn a_bristle_of_two_springs_has_the_matrices_of_its_derivatives() {
    let contact = FrBd::new(table_2_curve::<f64>(), zener()).under_load(3.0).unwrap();
    for (v, z) in [(5.5e-3, Vector2::new(1e-4, -2e-5)), (-0.2, Vector2::new(-3e-5, 1e-5))] {
        let small = state_space(&contact, v, z).unwrap();
        for (i, along) in [Vector2::x(), Vector2::y()].into_iter().enumerate() {
            let (rate_v, force_v, rate_x, force_x) =
                contact.derivatives(v, z.as_slice(), along.as_slice());
            for (got, want) in [
                (small.dynamics.column(i).as_slice(), &rate_x[..]),
                (small.input.as_slice(), &rate_v[..]),
                (&[small.output[i], small.feedthrough], &[force_x, force_v]),
            ] {
                for (got, want) in got.iter().zip(want) {
                    // Ten roundings.
                    assert_within(1e-13, want.abs(), *got, *want, || format!("{i} at {v}"));
                }
            }
        }
    }
    // In steady sliding the series spring alone carries: the gain is the slope of the curve.
    let steady = steady_state_space(&contact, 5.5e-3).unwrap();
    let slope = 3.0 * table_2_curve().coefficient_and_slope(5.5e-3.into()).1;
    assert_within(1e-12, slope.abs(), steady.static_gain().unwrap(), slope, || "gain".to_owned());
}

/// The first Fourier coefficient over one period, from samples of equal distance: c in Re(c
/// e^(iωt)) for a real signal, exact but for harmonics of the order of the number of samples.
fn fourier(samples: &[f64]) -> Complex<f64> {
    let n = samples.len() as f64;
    let terms = samples.iter().enumerate().map(|(j, &y)| {
        let angle = -TAU * j as f64 / n;
        Complex::new(angle.cos(), angle.sin()) * (2.0 * y / n)
    });
    terms.sum()
}

/// Runs a system for a number of periods and answers with the quantity over the last of them.
fn last_period<S: System<f64, N>, const N: usize>(
    system: &S,
    start: SVector<f64, N>,
    frequency: f64,
    periods: f64,
    quantity: impl Fn(f64, &SVector<f64, N>) -> f64,
) -> Vec<f64> {
    let tolerances = Tolerances::scaled(1e-12, system.scales()).unwrap();
    let solver = Solver::checked(DormandPrince8, tolerances);
    // Dense output is less accurate than steps, so that steps end at the samples.
    let samples = 64;
    let begin = (periods - 1.0) / frequency;
    let mut state = start;
    let end_of = |from: f64, to: f64, state: SVector<f64, N>| {
        let mut observer = |_: &Step<f64, N>| ControlFlow::Continue(());
        solver.stream(system, from..to, state, &[], &mut observer).unwrap().state
    };
    state = end_of(0.0, begin, state);
    let mut time = begin;
    let mut values = Vec::new();
    for j in 1..=samples {
        values.push(quantity(time, &state));
        let next = begin + f64::from(j) / f64::from(samples) / frequency;
        state = end_of(time, next, state);
        time = next;
    }
    values
}

#[test]
fn a_small_oscillation_of_the_velocity_gives_the_force_of_the_frequency_response() {
    fn assert_response<M: Bristle<f64, Deflection = f64>>(model: M) {
        let mean = 5.5e-3;
        let contact = model.under_load(2.0).unwrap();
        let small = steady_state_space(&contact, mean).unwrap();
        for frequency in [0.5, 5.0, 50.0, 500.0] {
            let amplitude = 1e-3 * mean;
            let sine = SineParameters { mean, amplitude, frequency, phase: 0.0 };
            let scene = PrescribedVelocity::new(contact.clone(), Sine::new(sine).unwrap());
            // Long enough for e^(−λt) to vanish: λ ≥ 31 1/s.
            let periods = (1.2 * frequency).ceil() + 1.0;
            let force = |t: f64, state: &_| scene.friction_force(t, state);
            let force = last_period(&scene, scene.stationary(0.0), frequency, periods, force);
            // v = mean + amplitude sin ωt: Re(−i amplitude e^(iωt)).
            let got = fourier(&force) / Complex::new(0.0, -amplitude);
            let want = small.frequency_response(TAU * frequency).unwrap();
            // The cubic terms of the model make a relative (amplitude/v_S)² ≈ 3e-7; the tolerance
            // of the run another 1e-12 · 2 N/amplitude.
            let off = modulus(got - want);
            assert!(off <= 2e-6 * modulus(want), "{frequency} Hz: {got} is not {want}");
        }
    }
    assert_response(table_2_frbd());
    assert_response(table_2_lugre());
}

/// A mass on a spring whose end moves at v_d(t); states: stretch, velocity, deflection.
#[derive(Debug)]
struct Pulled {
    contact: Contact<f64, FrBd<Stribeck<f64>, KelvinVoigt<f64>>>,
    mechanism: Mechanism<f64>,
    drive: Sine<f64>,
}

impl System<f64, 3> for Pulled {
    fn rate(&self, time: f64, state: &Vector3<f64>, [branch]: [Branch; 1]) -> Vector3<f64> {
        use bristle::signal::Signal;
        let Mechanism { mass, spring_stiffness, viscous_damping } = self.mechanism;
        let friction = self.contact.response(branch.of(state.y), state.z);
        let force = spring_stiffness * state.x - viscous_damping * state.y - friction.force;
        Vector3::new(self.drive.value(time) - state.y, force / mass, friction.rate)
    }

    fn sliding_velocities(&self, _time: f64, state: &Vector3<f64>) -> [f64; 1] {
        [state.y]
    }

    fn scales(&self) -> Vector3<f64> {
        Vector3::new(1e-1, 1e-2, 1e-4)
    }
}

#[test]
fn a_small_oscillation_of_the_drive_gives_the_force_of_the_coupled_response() {
    // In the falling part of the curve, held by damping and a stiff spring (k_c = 836 N/m there).
    let (mean, frequency) = (5.5e-3, 4.0);
    let amplitude = 1e-3 * mean;
    let mechanism = Mechanism { mass: 1.0, spring_stiffness: 4000.0, viscous_damping: 30.0 };
    let steady = steady_sliding(&table_2(), mechanism, mean).unwrap();
    let start = Vector3::new(steady.stretch, steady.velocity, steady.deflection);
    let drive = Sine::new(SineParameters { mean, amplitude, frequency, phase: 0.0 }).unwrap();
    let pulled = Pulled { contact: table_2(), mechanism, drive };
    // It stands still in steady sliding.
    let still = pulled.rate(0.0, &start, [Branch::Free]);
    assert!(still.amax() < 1e-12, "{still}");
    // Transients decay by the abscissa.
    let periods = (frequency * 16.0 / -steady.state_space.abscissa().unwrap()).ceil() + 1.0;
    let force = last_period(&pulled, start, frequency, periods, |_, state| {
        pulled.contact.force(state.y, state.z)
    });
    let got = fourier(&force) / Complex::new(0.0, -amplitude);
    let want = steady.state_space.frequency_response(TAU * frequency).unwrap();
    // As above; near resonance the velocity's amplitude is a few times that of the drive.
    assert!(modulus(got - want) <= 2e-5 * modulus(want), "{got} is not {want}");
}

/// Every root of one list is near one of the other.
fn assert_same_roots(got: &[Complex<f64>], want: &[Complex<f64>], tolerance: f64) {
    assert_eq!(got.len(), want.len());
    let size = want.iter().map(|root| modulus(*root)).fold(0.0, f64::max);
    for (these, those) in [(got, want), (want, got)] {
        for root in these {
            let off = those.iter().map(|other| modulus(root - other)).fold(f64::INFINITY, f64::min);
            assert!(off <= tolerance * size, "{got:?} are not {want:?}: off by {:e}", off / size);
        }
    }
}

#[test]
fn the_eigenvalues_of_a_sliding_mass_are_those_of_the_scene() {
    fn assert_rig<M: Bristle<f64, Deflection = f64>>(model: M, drive_velocity: f64) {
        let mass = 0.7;
        let mechanism = Mechanism { mass, spring_stiffness: 35.0, viscous_damping: 0.4 };
        let rig = MassSpringDamper::new(MassSpringDamperParameters {
            contact: model.clone().under_load(1.3).unwrap(),
            mechanism,
            drive_velocity,
            force: 0.0,
        });
        let (rig, drive) = (rig.unwrap(), drive_velocity);
        let steady = steady_sliding(&rig.parameters().contact, mechanism, drive).unwrap();
        let state = Vector3::new(-steady.stretch, drive, steady.deflection);
        // The scene stands still but for its position, which runs with the drive.
        let rate = rig.rate(0.0, &state, [Branch::Free]);
        // A few roundings of the terms c₀ z and c₂ v, which cancel in LuGre's force, and of the
        // damping.
        let affine = model.affine(drive.into(), steady.deflection);
        let terms = (affine.stiffness * steady.deflection).abs() + (affine.damping * drive).abs();
        let (force, drift) = (1.3 * terms + (0.4 * drive).abs(), 1e-14 * drive.abs());
        let force = 1e-14 * force / mass;
        assert!(rate.y.abs() <= force && rate.z.abs() <= drift, "{rate}");
        let jacobian = rig.linearised(0.0, &state, [Branch::Free]).unwrap().by_state;
        // nalgebra does not scale: in units of like entries.
        let bristle = jacobian[(1, 2)].abs().max(1.0).sqrt();
        let units = Matrix3::from_diagonal(&Vector3::new(0.14, 1.0, 1.0 / bristle));
        let even = units.try_inverse().unwrap() * jacobian * units;
        let want = even.complex_eigenvalues();
        // Where two nearly meet, each is known to the root of a rounding only.
        let size = want.iter().map(|root| modulus(*root)).fold(0.0, f64::max);
        let apart = |i: usize, j: usize| modulus(want[i] - want[j]) > 0.05 * size;
        if apart(0, 1) && apart(1, 2) && apart(0, 2) {
            let poles = steady.state_space.poles().unwrap();
            assert_same_roots(&poles, want.as_slice(), 1e-9);
        }
    }
    check(256, (recipe(), nonzero_velocity()), |(r, v)| {
        let v = v.signum() * v.abs().clamp(1e-5, 1e1);
        let k = r.stiffness.min(1e7);
        let (curve, bristle) = (stribeck::<f64>(&r, 2.0), kelvin_voigt(k, r.damping));
        assert_rig(FrBd::new(curve, bristle), v);
        assert_rig(FrBd::new(curve, bristle).regularised(square_root(&r)), v);
        assert_rig(LuGre::classical(curve, bristle), v);
        assert_rig(elasto_plastic(curve, bristle, 0.5 * r.dynamic / k), v);
    });
}

#[test]
fn the_valve_at_a_state_is_a_state_space_too() {
    let friction = FrBd::new(
        Stribeck::new(paper::VALVE_CURVE).unwrap(),
        KelvinVoigt::new(paper::VALVE_BRISTLE).unwrap(),
    );
    let contact = friction.under_load(1.0).unwrap();
    let valve = DiaphragmValve::new(paper::valve(contact, 0.425, 50.0)).unwrap();
    let state = Vector4::new(6e-3, 1e-3, 8e-7, 1.2e5);
    let (input, output) = (Vector4::new(0.0, 1.0, 0.0, 0.0), RowVector4::new(0.0, 1.0, 0.0, 0.0));
    let derivatives = valve.linearised(0.0, &state, [Branch::Forward]).unwrap();
    let small = StateSpace { dynamics: derivatives.by_state, input, output, feedthrough: 0.0 };
    // The states differ by eleven orders of magnitude; nalgebra does not scale, so that units in
    // which the matrix is even are given to it.
    let units = SMatrix::from_diagonal(&Vector4::new(1e-4, 1.0, 1e-4, 1e3));
    let even = units.try_inverse().unwrap() * small.dynamics * units;
    let want = even.complex_eigenvalues();
    assert_same_roots(&small.poles().unwrap(), want.as_slice(), 1e-9);
}

/// A contact that brakes a mass on a driven spring.
struct OnSpring<M> {
    contact: Contact<f64, M>,
    mechanism: Mechanism<f64>,
}

impl<M: Bristle<f64, Deflection = f64>> OnSpring<M> {
    fn steady_sliding(&self, velocity: f64) -> Result<SteadySliding<f64>, ParameterError> {
        steady_sliding(&self.contact, self.mechanism, velocity)
    }

    fn critical_stiffness(&self, velocity: f64) -> Result<Threshold<f64>, ParameterError> {
        critical_stiffness(&self.contact, self.mechanism, velocity)
    }

    fn critical_speed(&self, speeds: Range<f64>) -> Result<Threshold<f64>, ParameterError> {
        critical_speed(&self.contact, self.mechanism, speeds)
    }
}

fn on_spring<M: Bristle<f64, Deflection = f64>>(
    contact: Contact<f64, M>,
    mass: f64,
    spring_stiffness: f64,
    viscous_damping: f64,
) -> OnSpring<M> {
    OnSpring { contact, mechanism: Mechanism { mass, spring_stiffness, viscous_damping } }
}

/// The critical value above which, or below which, it is stable.
fn above(found: Result<Threshold<f64>, ParameterError>) -> f64 {
    let Ok(Threshold::StableAbove(critical)) = found else { panic!("{found:?}") };
    critical
}

fn below(found: Result<Threshold<f64>, ParameterError>) -> f64 {
    let Ok(Threshold::StableBelow(critical)) = found else { panic!("{found:?}") };
    critical
}

#[test]
fn on_a_spring_frbd_stick_slips_exactly_where_its_curve_falls() {
    // Whatever the spring and the mass: the sign of (μ sgn_ε)' decides.
    let mechanism = (decades(1e-3, 1e3), decades(1e-2, 1e6));
    check(256, (recipe(), nonzero_velocity(), mechanism), |(r, v, (mass, stiffness))| {
        let v = v.clamp(-1e2, 1e2);
        let curve = stribeck::<f64>(&r, 2.0);
        let root = SquareRoot::new(r.epsilon).unwrap();
        let (mu, mu_slope) = curve.coefficient_and_slope(v.into());
        let (sign, sign_slope) = Regularisation::sign_and_slope(&root, v.into());
        let slope = mu_slope * sign + mu * sign_slope;
        let g = r.damping * root.speed(v.into()) + mu;
        // H1 is known to some roundings of its terms, of order one.
        if (root.speed(v.into()) / g * slope).abs() < 1e-12 * (1.0 + v.abs() / g * mu_slope.abs()) {
            return;
        }
        let model = FrBd::new(curve, kelvin_voigt(r.stiffness, r.damping)).regularised(root);
        let rig = on_spring(model.under_load(r.load).unwrap(), mass, stiffness, 0.0);
        let want = if slope > 0.0 { Threshold::AlwaysStable } else { Threshold::NeverStable };
        assert_eq!(rig.critical_stiffness(v).unwrap(), want, "slope {slope:e}");
    });
}

#[test]
fn damping_beside_the_friction_sets_a_critical_stiffness() {
    // k_c = −(mλ + D) λ S/D at 5.5 mm/s with Table 2 and 1 kg, by multiprecision arithmetic.
    for (damping, want) in [
        (15.0, 4_734.718_535_153_756_9),
        (20.0, 2_456.559_272_688_252_4),
        (30.0, 836.446_552_831_534_59),
        (39.0, 104.350_183_097_031_13),
    ] {
        let rig = |stiffness| on_spring(table_2(), 1.0, stiffness, damping);
        let critical = above(rig(1.0).critical_stiffness(5.5e-3));
        // S is a difference of d and 40, and H1 of ones that leave 0.15.
        assert_within(1e-12, want, critical, want, || format!("d = {damping}"));
        let abscissa = |stiffness: f64| {
            let steady = rig(stiffness).steady_sliding(5.5e-3).unwrap();
            let poles = steady.state_space.dynamics.complex_eigenvalues();
            poles.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max)
        };
        assert!(abscissa(critical * (1.0 - 1e-6)) > 0.0 && abscissa(critical * (1.0 + 1e-6)) < 0.0);
    }
    let rig = |damping| on_spring(table_2(), 1.0, 1.0, damping);
    assert_eq!(rig(8.0).critical_stiffness(5.5e-3).unwrap(), Threshold::NeverStable);
    assert_eq!(rig(45.0).critical_stiffness(5.5e-3).unwrap(), Threshold::AlwaysStable);
}

#[test]
fn the_critical_stiffness_parts_stable_from_unstable_for_every_model() {
    let mechanism = (decades(1e-3, 1e3), prop_oneof![Just(0.0), decades(1e-2, 1e3)]);
    let seen = std::cell::Cell::new([0; 4]);
    let speeds = decades(1e-4, 1e1);
    check(512, (recipe(), speeds, mechanism), |(r, v, (mass, damping))| {
        let model = LuGre::classical(
            stribeck::<f64>(&r, 2.0),
            kelvin_voigt(r.stiffness.min(1e6), r.damping.min(1e3)),
        );
        let contact = model.under_load(r.load.min(1e3)).unwrap();
        let rig = |stiffness| on_spring(contact, mass, stiffness, damping);
        // The sign of the abscissa by nalgebra, if it is beyond its rounding.
        let stable = |stiffness: f64| {
            let matrix = rig(stiffness).steady_sliding(v).unwrap().state_space.dynamics;
            // In units of the stretch that make the matrix even.
            let unit = (mass / stiffness).sqrt();
            let units = Matrix3::from_diagonal(&Vector3::new(unit, 1.0, unit));
            let even = units.try_inverse().unwrap() * matrix * units;
            let poles = even.complex_eigenvalues();
            let size = poles.iter().map(|pole| modulus(*pole)).fold(0.0, f64::max);
            let abscissa = poles.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max);
            (abscissa.abs() > 1e-9 * size).then_some(abscissa < 0.0)
        };
        let (kind, expected) = match rig(1.0).critical_stiffness(v).unwrap() {
            Threshold::AlwaysStable => (0, [1e-2, 1.0, 1e4].map(|stiffness| (stiffness, true))),
            Threshold::NeverStable => (1, [1e-2, 1.0, 1e4].map(|stiffness| (stiffness, false))),
            Threshold::StableAbove(k) => (2, [(0.5 * k, false), (0.9 * k, false), (1.1 * k, true)]),
            Threshold::StableBelow(k) => (3, [(0.5 * k, true), (0.9 * k, true), (1.1 * k, false)]),
            // Far beyond the Stribeck velocity its curve is flat.
            Threshold::Marginal => {
                assert!([1e-2, 1.0, 1e4].into_iter().all(|stiffness| stable(stiffness).is_none()));
                return;
            }
        };
        let mut counts = seen.get();
        counts[kind] += 1;
        seen.set(counts);
        for (stiffness, want) in expected {
            if (1e-6..1e8).contains(&stiffness)
                && let Some(got) = stable(stiffness)
            {
                assert_eq!(got, want, "k = {stiffness:e}, v = {v:e}");
            }
        }
    });
    let [always, never, above, _] = seen.get();
    assert!(always > 20 && never > 20 && above > 5, "{:?}", seen.get());
}

#[test]
fn the_critical_speed_is_where_the_curve_turns_up() {
    // 100 u e^(−u²)/… = 0.04 by multiprecision arithmetic: 29.86 mm/s for Table 2, and 4.000 µm/s
    // below which the viscous part outweighs the falling one again.
    let rig = on_spring(table_2(), 1.0, 2.0, 0.0);
    let speed = above(rig.critical_speed(1e-6..10.0));
    // H1 = v μ'/(σ1 v + μ) is a difference of ones that crosses zero at 0.23 per m/s: its rounding
    // is 1e-15 m/s.
    assert_within(1e-14, 1.0, speed, 0.029_863_165_817_389_6, || "upper".to_owned());
    let speed = below(rig.critical_speed(1e-6..0.02));
    // There it crosses at 0.027 per m/s: 8e-15 m/s.
    assert_within(3e-14, 1.0, speed, 4.000_000_640_000_256e-6, || "lower".to_owned());
    assert_eq!(rig.critical_speed(0.05..10.0).unwrap(), Threshold::AlwaysStable);
    assert_eq!(rig.critical_speed(1e-3..0.02).unwrap(), Threshold::NeverStable);
    // So light on so soft a spring that mλ + D < 0, and the other two conditions alone would hold.
    let light = on_spring(table_2(), 0.01, 1e-3, 0.0);
    assert_eq!(light.critical_speed(1e-3..0.02).unwrap(), Threshold::NeverStable);
    assert_eq!(light.critical_stiffness(5.5e-3).unwrap(), Threshold::NeverStable);
}

/// The controllable canonical form of (b₂s² + b₁s + b₀)/(s³ + a₂s² + a₁s + a₀) + d.
fn canonical(b: [f64; 3], a: [f64; 3], d: f64) -> StateSpace<f64, 3> {
    StateSpace {
        dynamics: Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, -a[0], -a[1], -a[2]),
        input: Vector3::new(0.0, 0.0, 1.0),
        output: RowVector3::new(b[0], b[1], b[2]),
        feedthrough: d,
    }
}

#[test]
fn poles_gains_and_the_transfer_function_are_those_of_the_fraction() {
    // (s + 1)(s + 4)(s + 5) = s³ + 10 s² + 29 s + 20.
    let poles = [20.0, 29.0, 10.0];
    let real = |roots: &[f64]| -> Vec<Complex<f64>> {
        roots.iter().map(|&root| Complex::new(root, 0.0)).collect()
    };
    for numerator in
        [[6.0, 5.0, 1.0], [-6.0, 2.0, 0.0], [0.0, 2.0, 0.0], [7.0, 0.0, 0.0], [5.0, 2.0, 1.0]]
    {
        let system = canonical(numerator, poles, 0.0);
        assert_same_roots(&system.poles().unwrap(), &real(&[-1.0, -4.0, -5.0]), 1e-13);
        let gain = system.static_gain().unwrap();
        assert_within(1e-15, 1.0, gain, numerator[0] / 20.0, || "gain".to_owned());
        let s = Complex::new(0.3, 2.0);
        let top = s * s * numerator[2] + s * numerator[1] + numerator[0];
        let bottom = (s + 1.0) * (s + 4.0) * (s + 5.0);
        assert!(modulus(system.transfer(s) - top / bottom) < 1e-14);
    }
}

fn assert_pole_at_zero<const N: usize>(system: &StateSpace<f64, N>) {
    let refused = system.static_gain().unwrap_err().to_string();
    assert_eq!(refused, "static gain is inf, but must be finite: there is a pole at zero");
}

#[test]
fn what_has_no_answer_is_refused_by_name() {
    let contact = table_2();
    let kink = "velocity is 0, but must not be 0, where friction has a kink";
    for refused in [steady_state_space(&contact, 0.0), state_space(&contact, 0.0, 1e-5)] {
        let words = refused.unwrap_err().to_string();
        assert!(words.starts_with(kink), "{words}");
    }
    // Undeflected, both sides agree; on a side, everything is known.
    assert!(state_space(&contact, 0.0, 0.0).is_ok());
    let forward = steady_state_space(&contact, Branch::Forward.of(0.0)).unwrap();
    assert_pole_at_zero(&forward);
    let refused = forward.frequency_response(1.0).unwrap_err();
    let unstable = "largest real part of the poles";
    assert_eq!((refused.name, refused.value), (unstable, 0.0));
    // Regularised, rest is an equilibrium like any other.
    let smooth = table_2_frbd().regularised(SquareRoot::new(1e-10).unwrap());
    assert!(steady_state_space(&smooth.under_load(1.0).unwrap(), 0.0).is_ok());
    assert!(steady_state_space(&contact, f64::INFINITY).is_err());
    assert!(steady_state_space(&contact, f64::NAN).is_err());
    assert_eq!(state_space(&contact, f64::NAN, 0.0).unwrap_err().name, "velocity");
    assert_eq!(state_space(&contact, 0.1, f64::NAN).unwrap_err().name, "deflection");

    // An elasto-plastic model that is regularised never reaches its full deflection.
    let soft = elasto_plastic(table_2_curve(), table_2_bristle(), 5e-5)
        .regularised(SquareRoot::new(1e-6).unwrap());
    let refused = steady_state_space(&soft.under_load(1.0).unwrap(), 1e-3).unwrap_err();
    assert!(refused.name == "rate of the deflection" && refused.value != 0.0, "{refused}");
    let words = refused.to_string();
    assert!(words.ends_with("steady sliding: the model has no equilibrium there"), "{words}");

    let stick_slip = on_spring(contact, 1.0, 2.0, 0.0).steady_sliding(5e-3).unwrap();
    let refused = stick_slip.state_space.frequency_response(1.0).unwrap_err();
    assert!(refused.name == unstable && refused.value > 0.0, "{refused}");

    let mechanism = Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 };
    assert!(steady_sliding(&contact, mechanism, 0.1).is_err());
    assert!(critical_stiffness(&contact, mechanism, 0.1).is_err());
    assert!(critical_speed(&contact, mechanism, 1e-3..1.0).is_err());
    let rig = on_spring(contact, 1.0, 2.0, 0.0);
    for range in [0.0..1.0, 1.0..0.5, f64::NAN..1.0, 1.0..f64::NAN] {
        assert!(rig.critical_speed(range).is_err());
    }
}

#[test]
fn friction_that_does_not_depend_on_the_speed_is_marginal_at_every_speed() {
    for mu in [0.3, 0.5, 0.7, 1.0, 1.1] {
        for (stiffness, damping) in [(1e4, 64.5), (1e5, 0.0), (3e5, 100.0)] {
            let bristle = kelvin_voigt::<f64>(stiffness, damping);
            fn assert_marginal(model: impl Bristle<f64, Deflection = f64>) {
                let rig = on_spring(model.under_load(1.0).unwrap(), 1.0, 2.0, 0.0);
                assert_eq!(rig.critical_speed(1e-3..1.0).unwrap(), Threshold::Marginal);
                for v in [1e-9, 0.1, -0.13, 7.0] {
                    assert_eq!(rig.critical_stiffness(v).unwrap(), Threshold::Marginal, "{v}");
                }
            }
            assert_marginal(FrBd::new(super::coulomb(mu, 0.0), bristle));
            assert_marginal(LuGre::classical(super::coulomb(mu, 0.0), bristle));
            assert_marginal(elasto_plastic(super::coulomb(mu, 0.0), bristle, 0.5 * mu / stiffness));
            let (dynamic_coefficient, micro_stiffness) = (mu, stiffness);
            let dahl = DahlParameters { dynamic_coefficient, micro_stiffness };
            assert_marginal(Dahl::new(dahl).unwrap());
        }
    }
    // Damping beside it makes it stable; and without a load there is nothing but the damping.
    let coulomb = FrBd::new(super::coulomb(0.7, 0.0), table_2_bristle());
    let rig = |load, damping| on_spring(coulomb.under_load(load).unwrap(), 1.0, 2.0, damping);
    assert_eq!(rig(1.0, 0.1).critical_speed(1e-3..1.0).unwrap(), Threshold::AlwaysStable);
    assert_eq!(rig(0.0, 0.1).critical_speed(1e-3..1.0).unwrap(), Threshold::AlwaysStable);
    assert_eq!(rig(0.0, 0.0).critical_speed(1e-3..1.0).unwrap(), Threshold::Marginal);
}

#[test]
fn the_steady_slope_keeps_its_digits_however_slow_the_sliding() {
    fn assert_rising<T: Scalar>(decades: i32, tolerance: f64) {
        let bristle = || kelvin_voigt::<T>(lit(1e4), lit(64.5));
        let contact =
            FrBd::new(super::coulomb::<T>(1.0, 0.04), bristle()).under_load(T::one()).unwrap();
        for decade in 0..decades {
            let v: T = lit(1.3 * 10_f64.powi(-decade));
            let gain = steady_state_space(&contact, v).unwrap().static_gain().unwrap();
            let gain: f64 = gain.to_subset_unchecked();
            assert_within(tolerance, 0.04, gain, 0.04, || format!("{v}"));
            let mechanism = Mechanism {
                mass: T::one(),
                spring_stiffness: lit(2.0),
                viscous_damping: T::zero(),
            };
            let threshold = critical_stiffness(&contact, mechanism, v).unwrap();
            assert_eq!(threshold, Threshold::AlwaysStable, "{v}");
        }
    }
    // A few roundings.
    assert_rising::<f32>(12, 1e-6);
    assert_rising::<f64>(90, 1e-14);
    // Table 2 far below its Stribeck velocity: the viscous part alone.
    let gain = steady_state_space(&table_2(), 1e-100).unwrap().static_gain().unwrap();
    assert_within(1e-14, 0.04, gain, 0.04, || "Table 2".to_owned());
}

#[test]
fn small_motions_about_steady_sliding_are_the_derivatives_there() {
    fn assert_same<M: Bristle<f64>>(model: &M, v: f64) {
        let near = |a: f64, b: f64, size: f64, what: &str| {
            assert_within(1e-11, size.max(1.0), a, b, || format!("{what} at {v}: {model:?}"));
        };
        let z = model.stationary(v);
        let (steady, plain) = (model.steady_linearised(v), model.linearised(v, z));
        let (affine, slopes) = model.affine_and_slopes(v.into(), z);
        // Of the terms that cancel.
        let size = M::Deflection::relax(slopes.relaxation, z).largest() + affine.drive.largest();
        let off = steady.rate_by_velocity - plain.rate_by_velocity;
        near(off.largest(), 0.0, size, "∂ż/∂v");
        let size = size * (1.0 + affine.damping) + slopes.stiffness.inner_product(z).abs();
        near(steady.coefficient_by_velocity, plain.coefficient_by_velocity, size, "∂μ_b/∂v");
        assert_eq!(steady.rate, plain.rate);
        assert_eq!(steady.rate_by_deflection, plain.rate_by_deflection);
        assert_eq!(steady.coefficient_by_deflection, plain.coefficient_by_deflection);
    }
    check(256, (recipe(), nonzero_velocity()), |(r, v)| {
        let v = v.signum() * v.abs().clamp(1e-5, 1e1);
        let curve = stribeck::<f64>(&r, 2.0);
        let root = SquareRoot::new(r.epsilon).unwrap();
        let bristle = || kelvin_voigt::<f64>(r.stiffness, r.damping);
        assert_same(&FrBd::new(curve, bristle()), v);
        assert_same(&FrBd::new(curve, bristle()).regularised(root), v);
        assert_same(&LuGre::classical(curve, bristle()), v);
        assert_same(&LuGre::classical(curve, bristle()).regularised(root), v);
        let maxwell = maxwell(r.stiffness, r.damping.max(1e-2));
        assert_same(&FrBd::new(curve, maxwell), v);
        assert_same(&FrBd::new(curve, maxwell).regularised(root), v);
    });
    for v in [-3.0, -0.2, 0.7] {
        assert_same(&all_varying(), v);
        assert_same(&FrBd::new(table_2_curve(), three_arms(2.0)), v);
    }
}

/// A static spring, and two behind dashpots that relax with 1000/s and 1/s.
fn three_arms(micro_damping: f64) -> GeneralisedMaxwell<f64, 3> {
    arms([(1e4, None), (2e4, Some(20.0)), (5e3, Some(5e3))], micro_damping)
}

#[test]
fn a_linear_system_that_is_not_finite_is_refused_and_one_far_out_is_not() {
    fn lag<T: Scalar>(rate: f64) -> StateSpace<T, 1> {
        StateSpace {
            dynamics: Matrix1::new(lit(-rate)),
            input: Matrix1::new(lit(rate)),
            output: Matrix1::new(lit(2.0)),
            feedthrough: T::one(),
        }
    }
    fn assert_lag<T: Scalar>(rate: f64) {
        let lag = lag::<T>(rate);
        let at_corner = lag.frequency_response(lit(rate)).unwrap();
        let (re, im) = (at_corner.re - lit(2.0), at_corner.im + T::one());
        let rounding = T::default_epsilon() * lit(8.0);
        assert!(re.abs() < rounding && im.abs() < rounding, "{rate:e}: {at_corner}");
        assert!((lag.static_gain().unwrap() - lit(3.0)).abs() < rounding);
    }
    [1e-25, 1e-20, 1e-3, 1e18, 1e20, 1e25].into_iter().for_each(assert_lag::<f32>);
    [1e-200, 1e-160, 1.0, 1e160, 1e200].into_iter().for_each(assert_lag::<f64>);
    let one = lag::<f64>(1.0);
    for infinite in [f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(one.frequency_response(infinite).unwrap(), Complex::new(1.0, 0.0));
    }
    let refused = one.frequency_response(f64::NAN).unwrap_err();
    assert_eq!(refused.to_string(), "angular_frequency is NaN, but must be a number");
    let nan = Matrix1::new(f64::NAN);
    for bad in [
        StateSpace { dynamics: nan, ..one },
        StateSpace { input: nan, ..one },
        StateSpace { output: nan, ..one },
        StateSpace { feedthrough: f64::NAN, ..one },
        StateSpace { input: Matrix1::new(f64::INFINITY), ..one },
    ] {
        assert_eq!(bad.static_gain().unwrap_err().rule, Rule::Finite);
        assert_eq!(bad.frequency_response(1.0).unwrap_err().rule, Rule::Finite);
    }
}

/// ẋ₁ = −x₁ + c x₂, ẋ₂ = −x₂ + u: the gain from u to x₁ is c, however large.
#[test]
fn a_strong_coupling_one_way_is_no_singular_system() {
    for coupling in [1.0, 1e10, 1e20, 1e100] {
        let chain = StateSpace::<f64, 2> {
            dynamics: SMatrix::from_row_slice(&[-1.0, coupling, 0.0, -1.0]),
            input: SVector::from([0.0, 1.0]),
            output: SVector::from([1.0, 0.0]).transpose(),
            feedthrough: 0.0,
        };
        assert_within(1e-15, coupling, chain.static_gain().unwrap(), coupling, || "gain".into());
    }
}

#[test]
fn the_roots_of_a_real_matrix_are_real_or_exact_pairs() {
    check(256, prop::array::uniform16(-1.0..1.0), |entries: [f64; 16]| {
        let system = StateSpace::<f64, 4> {
            dynamics: SMatrix::from_row_slice(&entries),
            input: Vector4::zeros(),
            output: RowVector4::zeros(),
            feedthrough: 1.0,
        };
        let poles = system.poles().unwrap();
        for pole in poles {
            assert!(pole.im == 0.0 || poles.contains(&pole.conj()), "{poles:?}");
        }
        assert_eq!(poles.iter().filter(|pole| pole.im == 0.0).count() % 2, 0);
        // Some roundings of a matrix of order one, but for roots that nearly meet: of sums none.
        let trace: f64 = poles.iter().map(|pole| pole.re).sum();
        assert_within(1e-12, 1.0, trace, system.dynamics.trace(), || "trace".to_owned());
    });
    // (s + 3)(s² + 2 s + 25) = s³ + 5 s² + 31 s + 75.
    let poles = canonical([1.0, 0.0, 0.0], [75.0, 31.0, 5.0], 0.0).poles().unwrap();
    let (up, real) = (Complex::new(-1.0, 24_f64.sqrt()), Complex::new(-3.0, 0.0));
    assert_same_roots(&poles, &[up, up.conj(), real], 1e-14);
}

#[test]
fn steady_sliding_stretches_the_spring_by_friction_and_damping() {
    let rig = on_spring(table_2(), 1.0, 2.0, 0.3);
    for v in [-0.7, -0.004, 0.0055, 0.2] {
        let sliding = rig.steady_sliding(v).unwrap();
        // p (μ_d + (μ_s − μ_d) e^(−(v/v_S)²) + σ2 |v|) sgn v.
        let x: f64 = v / 0.01;
        let friction = (1.0 + 0.5 * (-x * x).exp() + 0.04 * v.abs()) * v.signum();
        let at = || format!("v = {v}");
        assert_within(1e-14, 1.5, sliding.friction_force, friction, at);
        assert_within(1e-14, 1.0, sliding.stretch, (friction + 0.3 * v) / 2.0, at);
        // σ0 z = μ sgn v, less σ1 ż = 0.
        assert_within(1e-14, 1e-4, sliding.deflection, friction / 1e4, at);
        assert_eq!(sliding.velocity, v);
    }
}

#[test]
fn two_changes_of_stability_a_twentieth_apart_are_not_missed() {
    // μ' = 0.1 (v − v₁)(v − v₂) is negative between the two only.
    let (low, high) = (1.0, 1.05);
    for scale in [0.97, 1.0, 1.013, 1.1, 1.37] {
        let (low, high) = (low * scale, high * scale);
        let curve = FunctionCurve::new(
            move |s: f64| {
                let cubic = s * s * s / 3.0 - (low + high) * s * s / 2.0 + low * high * s;
                (1.0 + 0.1 * cubic, 0.1 * (s - low) * (s - high))
            },
            Bounds { min: 1.0, max: f64::INFINITY },
        )
        .unwrap();
        let contact = FrBd::new(curve, table_2_bristle()).under_load(1.0).unwrap();
        let rig = on_spring(contact, 1.0, 2.0, 0.0);
        let speed = above(rig.critical_speed(0.1..10.0));
        // A slope of 0.005 s/m per m/s, from terms of 0.1 s/m.
        assert_within(1e-12, 1.0, speed, high, || format!("upper of {low}, {high}"));
        let middle = 0.5 * (low + high);
        let speed = below(rig.critical_speed(0.1..middle));
        assert_within(1e-12, 1.0, speed, low, || format!("lower of {low}, {high}"));
    }
}

#[test]
fn a_spring_can_be_too_stiff_for_a_bristle_of_much_damping() {
    // Classical LuGre at σ1 v/μ > 1: the curve rises with its viscous part, and yet falls at first.
    let curve = StribeckParameters { viscous_friction: 60.0, ..paper::STICK_SLIP_CURVE };
    let bristle = kelvin_voigt(1e4, 1e3);
    let contact = LuGre::classical(Stribeck::new(curve).unwrap(), bristle).under_load(1.0).unwrap();
    let (v, mass): (f64, f64) = (5.5e-3, 10.0);
    let rig = on_spring(contact, mass, 1.0, 0.0);
    let x = v / 0.01;
    let (dry, fall) = (1.0 + 0.5 * (-x * x).exp(), -(x / 0.01) * (-x * x).exp());
    // ż = v − σ0 |v| z/g: λ = σ0 v/g, D = σ1 v g'/g + σ2, S = g' + σ2; (mλ + D) λ S + D k = 0.
    let (rate, quick, slope) = (1e4 * v / dry, 1e3 * v * fall / dry + 60.0, fall + 60.0);
    assert!(slope > 0.0 && quick < 0.0 && mass * rate + quick > 0.0);
    let want = (mass * rate + quick) * rate * slope / -quick;
    let stiffness = below(rig.critical_stiffness(v));
    assert_within(1e-13, want, stiffness, want, || "stiffness".to_owned());
    let abscissa = |stiffness| {
        let sliding = on_spring(contact, mass, stiffness, 0.0).steady_sliding(v).unwrap();
        sliding.state_space.abscissa().unwrap()
    };
    assert!(abscissa(0.99 * want) < 0.0 && abscissa(1.01 * want) > 0.0);
}

#[test]
fn a_direct_part_that_is_infinite_and_a_pivot_of_rounding_are_refused() {
    use nalgebra::{Matrix2, RowVector2};
    /// Coulomb friction beside a viscous one whose force is beyond the range of numbers at a load
    /// of 10 N.
    #[derive(Debug, Clone)]
    struct Viscous(f64);
    impl FrictionCurve<f64> for Viscous {
        fn coefficient_and_slope(&self, _: Sliding<f64>) -> (f64, f64) {
            (1.0, 0.0)
        }
        fn bounds(&self, _: f64) -> Bounds<f64> {
            Bounds::constant(1.0)
        }
        fn viscous_friction(&self) -> f64 {
            self.0
        }
        fn with_less_viscous_friction(&self, part: f64) -> Self {
            Self(self.0 - part)
        }
    }
    let contact = LuGre::classical(Viscous(f64::MAX), table_2_bristle()).under_load(10.0).unwrap();
    let refused = state_space(&contact, Branch::Forward.of(0.0), 0.0).unwrap_err();
    assert_eq!((refused.name, refused.rule), ("feedthrough", Rule::Finite));
    // The second row is minus the first one; in binary, to a rounding only.
    let singular = StateSpace {
        dynamics: Matrix2::new(-0.1, 0.3, 0.1, -0.3),
        input: Vector2::new(1.0, 0.0),
        output: RowVector2::new(1.0, 0.0),
        feedthrough: 0.0,
    };
    assert_pole_at_zero(&singular);
    // The third row is three times the first one less the second, 3 · 0.1 − 0.3 = 6e-17 as numbers,
    // and the entry that this is subtracted from is zero.
    let difference = StateSpace {
        dynamics: -Matrix3::new(1.0, 0.0, 0.1, 0.0, 1.0, 0.3, 3.0, -1.0, 0.0),
        input: Vector3::new(1.0, 0.0, 0.0),
        output: RowVector3::new(1.0, 0.0, 0.0),
        feedthrough: 0.0,
    };
    assert_pole_at_zero(&difference);
}
