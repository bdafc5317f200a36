//! The energy ledger: balances of exact steps, passive steps and integrations, the LuGre energy
//! machine, and the verdict.

use std::ops::ControlFlow;

use bristle::ode::{
    DormandPrince, DormandPrince8, Method, Rodas4, Rodas5P, RungeKutta4, Solver, Step, Tolerances,
};
use bristle::scene::{MassSpringDamper, PrescribedVelocity};
use bristle::signal::{Sine, SineParameters};
use bristle::{Bristle, Contact, FrBd, LuGre, paper};
use bristle_analysis::ledger::{EnergyBalance, EnergyLedger};
use bristle_specimens::recipe::{recipe, state};
use bristle_specimens::specimens::{
    kelvin_voigt, lugre_inside, stribeck, table_2_bristle, table_2_curve, table_2_frbd,
    table_2_lugre,
};
use bristle_specimens::{assert_within, check};
use nalgebra::Vector1;

/// 1 mm/s over 1.5 mm, 10 m/s over 0.1 mm.
const PHASES: [(f64, f64); 2] = [(1e-3, 1.5), (10.0, 1e-5)];

/// Work per settled cycle of the energy machine \[J\], by arithmetic of high precision, with the
/// digits it was printed with.
const WORK: [&str; 3] = ["-0.0178134", "-0.00074745", "0.0023826"];

fn assert_digits(got: f64, want: &str) {
    let decimals = want.split('.').nth(1).unwrap().len();
    assert_eq!(format!("{got:.decimals$}"), want);
}

#[test]
fn the_energy_machine_of_exact_steps_gives_the_printed_work() {
    fn assert_machine<M: Bristle<f64, Deflection = f64>>(model: M, work: &str) {
        let contact = model.under_load(1.0).unwrap();
        let (mut z, mut ledger) = (0.0, EnergyLedger::new());
        for _ in 0..100 {
            ledger.close_cycle();
            for (velocity, duration) in PHASES {
                z = ledger.hold(&contact, velocity, z, duration).deflection;
            }
        }
        let EnergyBalance { supplied, stored, dissipated } = ledger.cycle();
        assert_digits(supplied, work);
        // The orbit is periodic, so that all is dissipated; with the other sign, made.
        assert!(stored.abs() < 1e-15, "{stored:e}");
        assert_within(1e-14, 0.1, dissipated, supplied, || "balance".to_owned());
        assert_eq!(ledger.is_passive(1e-12), supplied > 0.0);
        // An engine has given at least what all its cycles gave.
        assert!(ledger.gain() >= -80.0 * supplied);
    }
    assert_machine(table_2_lugre(), WORK[0]);
    assert_machine(lugre_inside(table_2_curve(), table_2_bristle()), WORK[1]);
    assert_machine(table_2_frbd(), WORK[2]);
}

#[test]
fn the_energy_machine_of_an_integrator_gives_the_printed_work_too() {
    fn assert_machine<M: Bristle<f64, Deflection = f64>>(model: M, work: &str) {
        let contact = model.under_load(1.0).unwrap();
        let (mut state, mut ledger) = (Vector1::new(0.0), EnergyLedger::new());
        for _ in 0..12 {
            ledger.close_cycle();
            for (velocity, duration) in PHASES {
                let scene = PrescribedVelocity::new(contact.clone(), velocity);
                let tolerances = Tolerances::scaled(1e-10, scene.scales()).unwrap();
                let solver = Solver::checked(DormandPrince8, tolerances);
                let mut meter = |step: &Step<f64, 1>| {
                    ledger.integrate(&contact, step, |_, state| (velocity, state.x));
                    ControlFlow::Continue(())
                };
                let run = solver.stream(&scene, 0.0..duration, state, &[], &mut meter);
                state = run.unwrap().state;
            }
        }
        assert_digits(ledger.cycle().supplied, work);
        assert!(ledger.total().residual().abs() < 1e-9, "{:e}", ledger.total().residual());
    }
    assert_machine(table_2_lugre(), WORK[0]);
    assert_machine(lugre_inside(table_2_curve(), table_2_bristle()), WORK[1]);
    assert_machine(table_2_frbd(), WORK[2]);
}

#[test]
fn exact_and_passive_steps_balance_to_rounding() {
    check(128, (recipe(), state()), |(r, state)| {
        let (curve, k) = (stribeck::<f64>(&r, 2.0), kelvin_voigt(r.stiffness, r.damping));
        let limit = r.static_ / r.stiffness;
        fn assert_run<M: Bristle<f64, Deflection = f64> + Copy>(
            contact: &Contact<f64, M>,
            z: f64,
            steps: &[(f64, f64)],
            passive: bool,
        ) {
            let mut ledger = EnergyLedger::new();
            let (mut terms, mut at) = (contact.stored_energy(z), z);
            for &(velocity, duration) in steps {
                let before = contact.stored_energy(at);
                let affine = contact.model().affine(velocity.into(), at);
                let hold = ledger.hold(contact, velocity, at, duration);
                let drag = contact.normal_force() * affine.damping * velocity * velocity * duration;
                // The terms of the mean force and of the dissipation, which cancel in LuGre's.
                let spring = contact.normal_force() * affine.stiffness.abs();
                let reach = hold.deflection.abs() + at.abs();
                terms += before + drag + spring * reach * (velocity * duration).abs();
                terms += contact.stored_energy(reach) * (1.0 + affine.relaxation * duration);
                at = hold.deflection;
            }
            let total = ledger.total();
            assert_within(1e-13, terms, total.residual(), 0.0, || format!("{total:?}"));
            let stored = contact.stored_energy(at) - contact.stored_energy(z);
            assert_within(1e-13, terms, total.stored, stored, || "stored".to_owned());
            if passive {
                assert!(total.dissipated >= 0.0 && ledger.is_passive(1e-13 * terms));
            }
            // The companion's steps, whose velocities are not those predicted.
            let companion = contact.companion(1.0).unwrap();
            let (mut ledger, mut at) = (EnergyLedger::new(), z);
            for &(velocity, duration) in steps {
                let done = companion.step(0.7 * velocity, at, duration).commit(velocity);
                ledger.enter(done);
                at = done.deflection;
            }
            let total = ledger.total();
            let sum = total.supplied.abs() + total.stored.abs() + total.dissipated.abs();
            if passive {
                assert_within(1e-12, sum + terms, total.residual(), 0.0, || format!("{total:?}"));
                assert!(total.dissipated >= 0.0);
            }
        }
        let z = state.fraction * limit;
        let fast = state.velocity.abs().max(1e-6);
        let steps: Vec<_> = state
            .chain
            .iter()
            .map(|&(v, horizon)| {
                let velocity = v * fast;
                let g = r.damping * velocity.abs() + r.dynamic;
                (velocity, horizon * g / (r.stiffness * velocity.abs().max(1e-9)))
            })
            .collect();
        assert_run(&FrBd::new(curve, k).under_load(r.load).unwrap(), z, &steps, true);
        assert_run(&LuGre::classical(curve, k).under_load(r.load).unwrap(), z, &steps, false);
    });
}

/// The ledger of a stick-slip run, and the work of the spring's end less what mass and spring keep
/// of it.
fn stick_slip<T: Method<f64, 3>>(solver: &Solver<f64, T, 3>) -> (EnergyLedger<f64>, f64) {
    let contact = table_2_frbd().under_load(1.0).unwrap();
    let rig = MassSpringDamper::new(paper::stick_slip_rig(contact)).unwrap();
    let (stiffness, drive) = (2.0, 0.1);
    let mut ledger = EnergyLedger::new();
    let mut work = 0.0;
    let mut observer = |step: &Step<f64, 3>| {
        ledger.integrate(&contact, step, |_, state| (state[1], state[2]));
        // k e v_d is smooth: the same points as in the tests' own quadrature.
        let (from, to) = (step.start_time(), step.end_time());
        work += bristle_specimens::integral(from, to, 1, |t| {
            stiffness * (drive * t - step.at(t)[0]) * drive
        });
        ControlFlow::Continue(())
    };
    let end = 20.0;
    let state = solver.stream(&rig, 0.0..end, rig.at_rest(), &[], &mut observer).unwrap().state;
    let stretch = drive * end - state[0];
    let kept = 0.5 * stiffness * stretch * stretch + 0.5 * state[1] * state[1];
    (ledger, work - kept)
}

#[test]
fn the_balance_of_an_integration_closes_to_its_tolerance() {
    let scales =
        MassSpringDamper::new(paper::stick_slip_rig(table_2_frbd().under_load(1.0).unwrap()))
            .unwrap()
            .scales();
    for tolerance in [1e-6, 1e-9] {
        // Slips multiply the errors of steps.
        let tolerances = Tolerances::scaled(0.01 * tolerance, scales).unwrap();
        for (name, (ledger, work)) in [
            ("DormandPrince", stick_slip(&Solver::adaptive(DormandPrince, tolerances))),
            ("DormandPrince8", stick_slip(&Solver::adaptive(DormandPrince8, tolerances))),
            ("Rodas4", stick_slip(&Solver::adaptive(Rodas4, tolerances))),
            ("Rodas5P", stick_slip(&Solver::adaptive(Rodas5P, tolerances))),
        ] {
            let total = ledger.total();
            // Two slips, after each of which the motion forgets what came before.
            let most = 10.0 * tolerance * total.supplied;
            assert!(total.residual().abs() < most, "{name}: {:e}", total.residual());
            let supplied = total.supplied;
            assert!((supplied - work).abs() < most, "{name}: {supplied} is not {work}");
            assert!(ledger.is_passive(most) && total.supplied > 1.0, "{name}");
        }
    }
    let (ledger, work) = stick_slip(&Solver::fixed(RungeKutta4, 1e-3).unwrap());
    let total = ledger.total();
    // Fourth order at a tenth of the swing's time.
    assert!(total.residual().abs() < 1e-8 && (total.supplied - work).abs() < 1e-8);
}

#[test]
fn the_gain_is_what_has_been_given_since_the_peak_and_a_nan_vouches_for_nothing() {
    let mut ledger = EnergyLedger::new();
    for (supplied, gain) in [(1.0, 0.0), (-0.5, 0.5), (-0.25, 0.75), (0.5, 0.75), (-0.75, 1.0)] {
        // The sums are exact: 1, 0.5, 0.25, 0.75, 0.
        ledger.enter(EnergyBalance { supplied, stored: 0.0, dissipated: supplied });
        assert_eq!(ledger.gain(), gain);
    }
    assert!(ledger.is_passive(1.0) && !ledger.is_passive(0.99));
    // Of what is supplied, what is stored is not made: net 0.5, then 0.25.
    let mut stored = EnergyLedger::new();
    stored.enter(EnergyBalance { supplied: 1.0, stored: 0.5, dissipated: 0.5 });
    stored.enter(EnergyBalance { supplied: -0.75, stored: -0.5, dissipated: -0.25 });
    assert_eq!(stored.gain(), 0.25);
    ledger.enter(EnergyBalance { supplied: f64::NAN, stored: 0.0, dissipated: 0.0 });
    ledger.enter(EnergyBalance { supplied: 1.0, stored: 0.0, dissipated: 1.0 });
    assert!(!ledger.is_passive(1e9));
}

#[test]
fn what_is_small_is_not_lost_beside_what_is_large() {
    let mut ledger = EnergyLedger::new();
    // Spacing of doubles at 1e16: two. The sum of the first three alone would be 1e16 and that of
    // all 0.
    for joule in [1.0, 1e16, 1.0, -1e16] {
        ledger.enter(EnergyBalance { supplied: joule, stored: 2.0 * joule, dissipated: -joule });
    }
    let two = EnergyBalance { supplied: 2.0, stored: 4.0, dissipated: -2.0 };
    assert_eq!((ledger.total(), ledger.cycle()), (two, two));
}

#[test]
fn the_balance_closes_under_a_velocity_that_varies_in_time() {
    let contact = table_2_frbd().under_load(1.0).unwrap();
    let swing = SineParameters { mean: 0.0, amplitude: 0.01, frequency: 1.0, phase: 0.3 };
    let scene = PrescribedVelocity::new(contact, Sine::new(swing).unwrap());
    let solver =
        Solver::checked(DormandPrince8, Tolerances::scaled(1e-10, scene.scales()).unwrap());
    let mut ledger = EnergyLedger::new();
    let mut meter = |step: &Step<f64, 1>| {
        ledger.integrate(&contact, step, |time, state| (scene.velocity(time), state.x));
        ControlFlow::Continue(())
    };
    solver.stream(&scene, 0.0..2.0, Vector1::new(0.0), &[], &mut meter).unwrap();
    let total = ledger.total();
    // About 1 N over two periods of 6.4 mm; the tolerance is of a deflection's energy of 1e-4 J.
    assert!(total.supplied > 5e-3 && total.residual().abs() < 1e-9, "{total:?}");
}
