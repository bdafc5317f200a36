//! Passivity, steady sliding, bounds, derivatives, runs, and refusals.

use bristle::companion::{PointMass, Prediction, VelocityHistory};
use bristle::curve::{FrictionCurve, Stribeck, StribeckParameters};
use bristle::nalgebra::SVector;
use bristle::ode::{self, Output, System};
use bristle::rheology::Deflection as _;
use bristle::scene::PrescribedVelocity;
use bristle::signal::{Sine, SineParameters};
use bristle::{Branch, Bristle, Law, Surface};
use bristle_analysis::ledger::EnergyLedger;
use bristle_memory::{Element, MaxwellSlip, MaxwellSlipParameters, Parallel};
use bristle_specimens::draw::Draw;
use num_dual::Dual64;

use super::{coulomb, even, slip, stribeck, zeros};

#[test]
fn steady_sliding_reproduces_the_curve() {
    for (ratio, damping) in [(0.5, 0.0), (0.95, 64.5)] {
        let contact = slip::<_, 7>(stribeck(), damping, ratio).under_load(3.0).unwrap();
        for v in [1e-6, -3e-3, 0.02, -0.5, 10.0_f64] {
            let want = 3.0 * v.signum() * stribeck().at(v);
            // Sums of seven terms.
            assert!((contact.stationary_force(v) - want).abs() < 1e-14 * want.abs(), "{v}");
            // From rest over a metre. α is frozen at zero, then at one.
            let far = 1.0 + 1.0 / v.abs();
            let past = contact.hold(v, zeros(), far).deflection;
            let slid = contact.hold(v, past, far);
            assert!((slid.end_force - want).abs() < 1e-12 * want.abs(), "{v}");
        }
    }
}

#[test]
fn companion_steps_give_no_energy_whatever_is_predicted_and_the_load_does() {
    let mut draw = Draw::seeded(1);
    for _ in 0..40 {
        let model = slip::<_, 6>(stribeck(), draw.logarithmic(1e-3, 1e3), draw.next().max(0.01));
        let mut joint = model.under_load(1.0).unwrap().companion(1.0).unwrap();
        let (mut x, mut gained) = (zeros(), 0.0_f64);
        for _ in 0..500 {
            let velocity = |draw: &mut Draw| draw.sign() * draw.logarithmic(1e-6, 1.0);
            let (predicted, mean) = (velocity(&mut draw), velocity(&mut draw));
            let load = draw.one_of(&[0.0, 0.01, 0.3, 1.0, 4.0]);
            let before = joint.contact().stored_energy(x);
            let reloaded = joint.reload(load, predicted, x).unwrap();
            let held = joint.contact().stored_energy(reloaded.deflection);
            assert!((before - held - reloaded.dissipated).abs() <= 1e-15 * before);
            assert!(reloaded.dissipated >= 0.0);
            let about = reloaded.deflection.each(|x| x * 2.0 * draw.next());
            let about = Prediction { velocity: predicted, deflection: about };
            let h = draw.logarithmic(1e-6, 1.0);
            let step = joint.step_about(about, reloaded.deflection, h);
            let done = step.commit(mean);
            x = done.deflection;
            let after = joint.contact().stored_energy(x);
            let size = done.work.abs() + held + after;
            gained = gained.max((after - held - done.work) / size);
            assert!(done.dissipated >= 0.0 && step.damping() >= 0.0 && step.is_passive());
        }
        // Roundings of six terms.
        assert!(gained < 1e-14, "{gained:e}");
    }
}

#[test]
fn sharp_steps_give_no_energy_for_any_history_of_yield() {
    let mut draw = Draw::seeded(2);
    let model = slip::<_, 6>(stribeck(), 0.0, 0.5);
    let contact = model.under_load(1.0).unwrap();
    let mut x = zeros();
    for _ in 0..100_000 {
        let surface = Surface::scaled(draw.sign() * draw.next(), 3.0 * draw.next());
        let displacement = draw.sign() * draw.logarithmic(1e-7, 1e-2);
        let step = model.sharp_step(surface, displacement, x);
        let (before, after) = (contact.stored_energy(x), contact.stored_energy(step.deflection));
        let work = step.coefficient * displacement;
        let lost = work - (after - before);
        assert!(lost >= -1e-15 * (work.abs() + before + after), "{lost:e}");
        x = step.deflection;
    }
}

#[test]
fn a_run_that_is_held_loses_what_the_ledger_says() {
    let contact = slip::<_, 5>(stribeck(), 20.0, 0.8).under_load(2.0).unwrap();
    let (mut x, mut ledger) = (zeros(), EnergyLedger::new());
    for step in 0..20_000 {
        let v = 2e-3 * (1e-3 * f64::from(step)).sin() + 5e-4 * (7.3e-3 * f64::from(step)).sin();
        x = ledger.hold(&contact, v, x, 1e-3).deflection;
    }
    assert!(ledger.is_passive(1e-15));
    let total = ledger.total();
    assert!(total.dissipated > 0.0 && total.residual().abs() < 1e-13 * total.supplied);
}

/// The same model of dual numbers.
fn dual(ratio: f64) -> MaxwellSlip<Stribeck<Dual64>, Dual64, 4> {
    let t = Dual64::from_re;
    let curve = StribeckParameters {
        static_coefficient: t(1.5),
        dynamic_coefficient: t(1.0),
        stribeck_velocity: t(0.01),
        stribeck_exponent: t(2.0),
        viscous_friction: t(0.04),
    };
    let elements = even::<4>().map(|element| Element {
        stiffness: t(element.stiffness),
        yield_length: t(element.yield_length),
    });
    MaxwellSlip::new(MaxwellSlipParameters {
        curve: Stribeck::new(curve).unwrap(),
        elements,
        micro_damping: t(30.0),
        stick_ratio: t(ratio),
    })
    .unwrap()
}

#[test]
fn derivatives_are_those_of_dual_numbers() {
    let mut draw = Draw::seeded(3);
    for _ in 0..2000 {
        let ratio = 0.05 + 0.9 * draw.next();
        let (model, twin) = (slip::<_, 4>(stribeck(), 30.0, ratio), dual(ratio));
        let v = draw.sign() * draw.logarithmic(1e-5, 1.0);
        let scale = draw.one_of(&[1.0, 0.4, 2.0]);
        let full = model.yield_lengths(Surface::scaled(v, scale));
        let x = Parallel(full.map(|full| full * 1.2 * draw.sign() * draw.next()));
        let linearised = model.linearised(Surface::scaled(v, scale), x);
        let seeded = |along: Option<usize>| {
            let at = |value, one| Dual64::new(value, if one { 1.0 } else { 0.0 });
            let surface = Surface::scaled(at(v, along.is_none()), at(scale, false));
            let x = Parallel(SVector::<_, 4>::from_fn(|i, _| at(x[i], along == Some(i))));
            (twin.rate(surface, x), twin.coefficient(surface, x))
        };
        let near = |got: f64, want: f64, size: f64| {
            // Near the yield α' is a product of a sine and a cosine of like arguments.
            assert!((got - want).abs() <= 1e-9 * size.max(want.abs()), "{got} is not {want}");
        };
        let (rate, coefficient) = seeded(None);
        near(linearised.coefficient, coefficient.re, 1.0);
        near(linearised.coefficient_by_velocity, coefficient.eps, 1.0);
        for i in 0..4 {
            near(linearised.rate[i], rate[i].re, v.abs());
            near(linearised.rate_by_velocity[i], rate[i].eps, 1.0);
            let (rate, coefficient) = seeded(Some(i));
            near(linearised.rate_by_deflection[i], rate[i].eps, 1.0);
            near(linearised.coefficient_by_deflection[i], coefficient.eps, 1e4);
        }
    }
}

#[test]
fn deflections_and_relaxation_rates_keep_their_limits() {
    let model = slip::<_, 6>(stribeck(), 50.0, 0.9);
    let limits = model.limits(0.1);
    // The longest yield length under μ_s, and Σσ/σ1.
    let want = 11.0 / 6.0 * 1e-4 * 1.5;
    assert!((limits.deflection.unwrap() - want).abs() < 1e-9, "{limits:?}");
    assert!((limits.relaxation_rate.unwrap() - 1e4 / 50.0).abs() < 1e-9);
    assert_eq!(model.limits(f64::NAN).deflection, None);
    let (mut draw, mut x) = (Draw::seeded(4), zeros());
    for _ in 0..20_000 {
        let v = 0.1 * (2.0 * draw.next() - 1.0);
        let affine = model.affine(v.into(), x);
        assert!(affine.relaxation.max() <= limits.relaxation_rate.unwrap());
        // A frozen α overshoots by |v| h at most.
        x = model.hold(v, x, 1e-7).deflection;
        assert!(x.amax() <= limits.deflection.unwrap() + 1e-8);
    }
    let [obeyed, broken] = [true, false]
        .map(|obeys| Law::ALL.into_iter().filter(move |&law| model.obeys(law) == obeys).count());
    assert_eq!((obeyed, broken), (6, 2));
    // Without damping an element relaxes the faster, the larger the velocity.
    assert!(!slip::<_, 6>(stribeck(), 0.0, 0.9).obeys(Law::BoundedRelaxation));
}

#[test]
fn cycles_of_force_below_the_first_yield_leave_no_drift() {
    // The first of five elements yields at 20 µm · μ_s; all are springs up to ρ of it.
    let contact = slip::<_, 5>(stribeck(), 20.0, 0.9).under_load(1.0).unwrap();
    let joint = contact.companion(0.1).unwrap();
    let (mut x, mut v, mut place, h) = (zeros(), 0.0, 0.0, 1e-3);
    let mut at_rest = [0.0; 2];
    for cycle in 0..2000 {
        for (end, force) in [(0, 0.25), (1, 0.05)] {
            for _ in 0..40 {
                let step = joint.step(v, x, h);
                let mass = PointMass { mass: 1e-3, velocity: v, force, end_weight: 1.0 };
                v = step.point_mass(mass);
                x = step.commit(v).deflection;
                place += h * v;
            }
            if cycle == 100 {
                at_rest[end] = place;
            }
            if cycle > 100 {
                // Sums of 160 000 displacements of up to 1e-5 m.
                assert!((place - at_rest[end]).abs() < 1e-15, "{:e}", place - at_rest[end]);
            }
        }
    }
    assert!((at_rest[0] - 0.25e-4).abs() < 1e-9);
}

/// A block on a spring whose end moves: position, velocity and four deflections.
struct Block(bristle::Contact<f64, MaxwellSlip<Stribeck<f64>, f64, 4>>);

impl System<f64, 6> for Block {
    fn rate(&self, time: f64, y: &SVector<f64, 6>, [branch]: [Branch; 1]) -> SVector<f64, 6> {
        let friction =
            self.0.response(branch.of(y[1]), Parallel(y.fixed_rows::<4>(2).into_owned()));
        let [a, b, c, d] = friction.rate.0.into();
        let pull = 300.0 * (1e-3 * (10.0 * time).sin() - y[0]);
        SVector::from([y[1], pull - friction.force, a, b, c, d])
    }

    fn sliding_velocities(&self, _: f64, y: &SVector<f64, 6>) -> [f64; 1] {
        [y[1]]
    }

    fn scales(&self) -> SVector<f64, 6> {
        SVector::from([1e-4, 1e-3, 1e-5, 1e-5, 1e-5, 1e-5])
    }
}

#[test]
fn a_mechanism_simulated_and_in_passive_steps_comes_to_the_same() {
    let contact = slip::<_, 4>(stribeck(), 30.0, 0.7).under_load(0.1).unwrap();
    let exact = |tolerance| {
        let run =
            ode::solve(&Block(contact), 0.0..0.6, SVector::zeros(), tolerance, Output::Uniform(2));
        run.unwrap().states()[1]
    };
    let (reference, loose) = (exact(1e-9), exact(1e-6));
    assert!((reference - loose).component_div(&Block(contact).scales()).amax() < 1e-3);
    let joint = contact.companion(0.1).unwrap();
    let error = |count: u32| {
        let h = 0.6 / f64::from(count);
        let (mut place, mut v, mut x) = (0.0, 0.0, zeros());
        let mut history = VelocityHistory::new(v);
        for n in 0..count {
            let velocity = history.predict();
            // Where α is frozen: the deflection at the middle, by half a step.
            let deflection = contact.hold(velocity, x, 0.5 * h).deflection;
            let step = joint.step_about(Prediction { velocity, deflection }, x, h);
            let end = 1e-3 * (10.0 * h * (f64::from(n) + 0.5)).sin();
            let pull = 300.0 * (end - place);
            let mean =
                (2.0 / h * v + pull - step.bias()) / (2.0 / h + 0.5 * h * 300.0 + step.damping());
            x = step.commit(mean).deflection;
            (place, v) = (place + h * mean, 2.0 * mean - v);
            history.push(v);
        }
        (place - reference[0]).abs()
    };
    let errors = [125, 250, 500, 1000].map(error);
    // Second order, scattered by where in a step the elements yield.
    assert!(errors[3] < errors[0] / 30.0 && errors[3] < 1e-8, "{errors:?}");
}

#[test]
fn a_scene_solves_with_stiff_and_other_methods() {
    let contact = slip::<_, 3>(stribeck(), 64.5, 0.8).under_load(1.0).unwrap();
    let sine = SineParameters { mean: 0.0, amplitude: 0.01, frequency: 1.0, phase: 0.0 };
    let scene = PrescribedVelocity::new(contact, Sine::new(sine).unwrap());
    let run =
        ode::solve(&scene, 0.0..1.3, SVector::<_, 3>::zeros(), 1e-8, Output::Uniform(14)).unwrap();
    // By small held steps, of second order with the velocity at their middle.
    let (mut x, h) = (zeros(), 1e-5);
    for step in 0..130_000 {
        let v = scene.velocity(h * (f64::from(step) + 0.5));
        x = contact.hold(v, x, h).deflection;
    }
    let end = run.states()[13];
    assert!((end - x.0).amax() < 1e-9, "{:e}", (end - x.0).amax());
}

#[test]
fn single_precision_gives_the_same_to_its_digits() {
    let elements = even::<5>().map(|element| Element {
        stiffness: element.stiffness as f32,
        yield_length: element.yield_length as f32,
    });
    let curve = StribeckParameters {
        static_coefficient: 1.5_f32,
        dynamic_coefficient: 1.0,
        stribeck_velocity: 0.01,
        stribeck_exponent: 2.0,
        viscous_friction: 0.04,
    };
    let single = MaxwellSlip::new(MaxwellSlipParameters {
        curve: Stribeck::new(curve).unwrap(),
        elements,
        micro_damping: 10.0,
        stick_ratio: 0.8,
    })
    .unwrap();
    let double = slip::<_, 5>(stribeck(), 10.0, 0.8);
    let (mut x, mut y) = (Parallel::<f32, 5>::default(), zeros());
    for step in 0..1000 {
        let v = 1e-3 * (0.02 * f64::from(step)).sin();
        let (a, b) = (single.hold(v as f32, x, 1e-3), double.hold(v, y, 1e-3));
        (x, y) = (a.deflection, b.deflection);
        // A thousand sums of six digits.
        assert!((f64::from(a.end_coefficient) - b.end_coefficient).abs() < 1e-4);
    }
}

#[test]
fn unusable_parameters_are_refused_by_name() {
    let sound = MaxwellSlipParameters {
        curve: coulomb(),
        elements: even::<3>(),
        micro_damping: 1.0,
        stick_ratio: 0.9,
    };
    assert!(MaxwellSlip::new(sound).is_ok());
    let refused = |change: &dyn Fn(&mut MaxwellSlipParameters<_, f64, 3>)| {
        let mut parameters = sound;
        change(&mut parameters);
        let error = MaxwellSlip::new(parameters).unwrap_err();
        (error.name, error.component)
    };
    for bad in [f64::NAN, -1.0, f64::INFINITY] {
        let stiffness = refused(&|it| it.elements[1].stiffness = bad);
        assert_eq!(stiffness, ("elements.stiffness", Some(1)));
        let length = refused(&|it| it.elements[2].yield_length = bad);
        assert_eq!(length, ("elements.yield_length", Some(2)));
        assert_eq!(refused(&|it| it.micro_damping = bad), ("micro_damping", None));
        assert_eq!(refused(&|it| it.stick_ratio = bad), ("stick_ratio", None));
    }
    assert_eq!(refused(&|it| it.elements[0].yield_length = 0.0).1, Some(0));
    assert_eq!(refused(&|it| it.stick_ratio = 1.0), ("stick_ratio", None));
    assert_eq!(refused(&|it| it.stick_ratio = 0.0), ("stick_ratio", None));
    let none = refused(&|it| {
        it.elements = it.elements.map(|it: Element<f64>| Element { stiffness: 0.0, ..it })
    });
    assert_eq!(none, ("sum of stiffness times yield_length", None));
    let elements = [];
    let empty =
        MaxwellSlipParameters { curve: coulomb(), elements, micro_damping: 0.0, stick_ratio: 0.5 };
    assert_eq!(MaxwellSlip::new(empty).unwrap_err().name, "elements");
}

#[test]
fn nan_comes_out_as_nan() {
    let contact = slip::<_, 3>(stribeck(), 1.0, 0.5).under_load(1.0).unwrap();
    let mut x = zeros();
    assert!(contact.hold(f64::NAN, x, 1e-3).end_force.is_nan());
    assert!(contact.hold(0.1, x, -1e-3).end_force.is_nan());
    x.0[1] = f64::NAN;
    assert!(contact.force(0.1, x).is_nan() && contact.rate(0.1, x)[1].is_nan());
}
