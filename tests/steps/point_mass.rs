//! A free mass under a companion step, solved in closed form, and steps about a predicted
//! deflection.

use bristle::companion::{Companion, PointMass, Prediction};
use bristle::curve::Stribeck;
#[cfg(feature = "alloc")]
use bristle::ode::{DormandPrince, Output, Solver, Tolerances};
use bristle::rheology::KelvinVoigt;
#[cfg(feature = "alloc")]
use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
use bristle::{Bristle, FrBd};
use bristle_specimens::check;
use bristle_specimens::recipe::{Recipe, decades, velocity};
use bristle_specimens::specimens::{elasto_plastic, implicit, kelvin_voigt, spring, stribeck};
use proptest::prelude::*;

fn curve() -> Stribeck<f64> {
    let (static_, dynamic, stribeck_velocity, viscous) = (0.6, 0.45, 0.1, 0.01);
    stribeck(&Recipe { static_, dynamic, stribeck_velocity, viscous, ..Recipe::TABLE_2 }, 2.0)
}

fn bristle() -> KelvinVoigt<f64> {
    kelvin_voigt(3e3, 20.0)
}

fn frbd() -> Companion<f64, FrBd<Stribeck<f64>, KelvinVoigt<f64>>> {
    FrBd::new(curve(), bristle()).under_load(9.81).unwrap().companion(10.0).unwrap()
}

/// m (v₁ − v₀) = h (f − F̄) with v̄ = v₀ + θ (v₁ − v₀), relative to the sum of its terms.
#[test]
fn the_velocity_of_a_point_mass_solves_its_equation() {
    let companion = frbd();
    let weight = prop_oneof![Just(0.5), Just(0.625), Just(1.0)];
    let case = (
        velocity(),
        velocity(),
        -2e-4..2e-4,
        decades(1e-6, 1e1),
        decades(1e-3, 1e3),
        velocity(),
        weight,
    );
    check(256, case, |(predicted, velocity, z, h, mass, force, end_weight)| {
        let step = companion.step(predicted, z, h);
        let mean = step.point_mass(PointMass { mass, velocity, force, end_weight });
        let change = (mean - velocity) / end_weight;
        let (left, right) = (mass * change, h * (force - step.force(mean)));
        let terms = mass * (mean.abs() + velocity.abs()) / end_weight
            + h * (force.abs() + step.bias().abs() + step.damping() * mean.abs());
        // A dozen roundings of 1.1e-16.
        assert!((left - right).abs() <= 2e-15 * terms, "{left:e} {right:e}");
    });
}

#[test]
fn a_body_without_mass_moves_as_forces_and_friction_say() {
    let companion = frbd();
    let step = companion.step(0.01, 1e-4, 1e-2);
    let body = PointMass { mass: 0.0, velocity: 3.0, force: 2.0, end_weight: 1.0 };
    assert!((step.force(step.point_mass(body)) - 2.0).abs() < 1e-14);
}

#[test]
fn a_mass_or_a_weight_that_is_none_gives_no_number() {
    let companion = frbd();
    let step = companion.step(0.1, 0.0, 1e-3);
    for mass in [-1.0, -1e-300, f64::NEG_INFINITY, f64::NAN] {
        let body = PointMass { mass, velocity: 3.0, force: 2.0, end_weight: 1.0 };
        assert!(step.point_mass(body).is_nan(), "{mass}");
    }
    for end_weight in [-1.0, -1e-300, 1.5, f64::INFINITY, f64::NAN] {
        let body = PointMass { mass: 1.0, velocity: 3.0, force: 2.0, end_weight };
        assert!(step.point_mass(body).is_nan(), "{end_weight}");
    }
}

#[test]
fn at_the_target_velocity_the_friction_is_gone() {
    let mut companion = frbd();
    let step = companion.step(0.01, 1e-4, 1e-2);
    let target = step.target_velocity().unwrap();
    assert!(target < 0.0, "the bristle pulls back");
    assert!(step.force(target).abs() < 1e-15 * step.bias());
    // Without a load, and with a spring over no time, there is no damper.
    let forgotten = companion.reload(0.0, 0.0, 1e-4).unwrap().deflection;
    assert_eq!(forgotten, 0.0);
    let idle = companion.step(0.01, forgotten, 1e-2);
    assert_eq!(idle.target_velocity(), None);
    let spring = FrBd::new(curve(), spring(3e3)).under_load(9.81).unwrap().companion(10.0).unwrap();
    assert_eq!(spring.step(0.01, 1e-4, 0.0).target_velocity(), None);
}

/// Of a step about a deflection that has nothing to do with it.
fn balances<M: Bristle<f64, Deflection = f64>>(model: M) {
    let companion = model.under_load(9.81).unwrap().companion(10.0).unwrap();
    let case = (velocity(), -1e-3..1e-3, velocity(), -2e-4..2e-4, decades(1e-6, 1e1));
    check(256, case, |(velocity, deflection, mean, z, h)| {
        let step = companion.step_about(Prediction { velocity, deflection }, z, h);
        let done = step.commit(mean);
        assert!(step.is_passive() && done.dissipated >= 0.0, "{:e}", done.dissipated);
        // Work and stored energy are differences of terms of up to ½ p K (|z| + h|v̄|)².
        let terms = 9.81 * 3e3 * (z.abs() + h * mean.abs()).powi(2)
            + 9.81 * 20.0 * h * mean * mean
            + done.work.abs();
        let residual = done.work - done.stored - done.dissipated;
        assert!(residual.abs() <= 1e-13 * terms, "{residual:e} of {terms:e}");
    });
}

#[test]
fn a_wrong_deflection_in_the_prediction_gives_no_energy() {
    balances(elasto_plastic(curve(), bristle(), 1e-4));
    balances(implicit(curve(), bristle()));
}

#[test]
fn for_a_model_that_does_not_ask_for_it_the_predicted_deflection_does_nothing() {
    let companion = frbd();
    let about = Prediction { velocity: 0.3, deflection: 7.0 };
    assert_eq!(companion.step_about(about, 1e-4, 1e-2), companion.step(0.3, 1e-4, 1e-2));
}

/// How far velocity and deflection are off, of a mass on a spring whose end moves, after 2 ms in
/// which the bristle yields.
#[cfg(feature = "alloc")]
fn errors<M: Bristle<f64, Deflection = f64>>(model: M, foreseen: bool, steps: u32) -> [f64; 2] {
    let (span, start) = (2e-3, [0.02, 1.2e-4]);
    let contact = model.under_load(9.81).unwrap();
    let (mass, spring_stiffness, drive_velocity) = (1.0, 5e3, 0.1);
    let rig = MassSpringDamper::new(MassSpringDamperParameters {
        contact: contact.clone(),
        mechanism: bristle::Mechanism { mass, spring_stiffness, viscous_damping: 0.0 },
        drive_velocity,
        force: 0.0,
    })
    .unwrap();
    let state = nalgebra::Vector3::new(0.0, start[0], start[1]);
    let tolerances = Tolerances::scaled(1e-13, rig.scales()).unwrap();
    let solver = Solver::checked(DormandPrince, tolerances);
    let exact = solver.solve(&rig, 0.0..span, state, Output::Steps).unwrap();
    let exact = exact.states().last().unwrap();

    let companion = contact.clone().companion(1.0).unwrap();
    let h = span / f64::from(steps);
    let (mut x, [mut v, mut z]) = (0.0, start);
    for n in 0..steps {
        let t = h * f64::from(n);
        let spring = |t: f64, x: f64| spring_stiffness * (drive_velocity * t - x);
        let velocity = v + 0.5 * h * (spring(t, x) - contact.force(v, z)) / mass;
        let deflection = if foreseen { z + 0.5 * h * contact.rate(v, z) } else { z };
        let step = companion.step_about(Prediction { velocity, deflection }, z, h);
        let force = spring(t + 0.5 * h, x + 0.5 * h * velocity);
        let mean = step.point_mass(PointMass { mass, velocity: v, force, end_weight: 0.5 });
        (x, v, z) = (x + h * mean, 2.0 * mean - v, step.commit(mean).deflection);
    }
    [(v - exact[1]).abs(), (z - exact[2]).abs()]
}

/// Orders of velocity and deflection, from a halved step.
#[cfg(feature = "alloc")]
fn orders<M: Bristle<f64, Deflection = f64>>(model: M, foreseen: bool) -> [f64; 2] {
    let [coarse, fine] = [32, 64].map(|steps| errors(model.clone(), foreseen, steps));
    [0, 1].map(|i| (coarse[i] / fine[i]).log2())
}

#[cfg(feature = "alloc")]
#[test]
fn with_a_predicted_deflection_models_that_depend_on_it_step_to_second_order() {
    let plastic = elasto_plastic(curve(), bristle(), 1e-4);
    for orders in [orders(plastic, true), orders(implicit(curve(), bristle()), true)] {
        assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.2), "{orders:?}");
    }
    let frozen = orders(plastic, false);
    assert!(frozen.iter().all(|order| (order - 1.0).abs() < 0.2), "{frozen:?}");
}
