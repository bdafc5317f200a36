//! The laws of the friction scale s, each written once and run over every implementor. The
//! derivatives at a scale are in tests/models/derivatives.rs, loads in tests/steps/load.rs and
//! tests/load.rs.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test panics to fail")]

use std::cell::Cell;

use bristle::rheology::{GeneralisedMaxwell, ZenerParameters};
use bristle::{Branch, Bristle, FrBd, Law, LuGre, Surface};
use bristle_specimens::closed_form::Family;
use bristle_specimens::recipe::{Recipe, State, recipe, scale, state};
use bristle_specimens::specimens::{AsModel, Specimen, kelvin_voigt, specimens, stribeck};
use bristle_specimens::{assert_within, check};

const ROUNDING: f64 = 1e-12;

/// Runs a check over every specimen at random parameters, states and scales.
fn every_scaled(cases: u32, test: impl Fn(&Specimen<f64>, &State, f64)) {
    check(cases, (recipe(), state(), scale()), |(recipe, state, scale)| {
        for specimen in specimens(&recipe) {
            test(&specimen, &state, scale);
        }
    });
}

/// A deflection within the limit under a scale, or up to three times it.
fn deflection(specimen: &Specimen<f64>, state: &State, scale: f64) -> f64 {
    let limit = specimen.subject.limits(state.velocity.abs()).deflection.unwrap();
    state.fraction * limit * scale.min(3.0)
}

#[test]
fn a_scale_of_one_leaves_the_same_bits() {
    check(32, (recipe(), state()), |(recipe, state)| {
        for specimen in specimens::<f64>(&recipe) {
            let (subject, h) = (&specimen.subject, state.duration);
            let (v, z) = (state.velocity, deflection(&specimen, &state, 1.0));
            for sliding in [Branch::Free, Branch::Forward, Branch::Backward].map(|b| b.of(v)) {
                let (plain, scaled) = (Surface::from(sliding), Surface::scaled(sliding, 1.0));
                let all = |surface| {
                    let numbers = (subject.affine_and_slopes(surface, z), subject.rate(surface, z));
                    let steady = (subject.stationary(surface), subject.stationary_force(surface));
                    let held = subject.held(surface, z, h);
                    let linear =
                        (subject.linearised(surface, z), subject.steady_linearised(surface));
                    format!("{numbers:?} {steady:?} {held:?} {linear:?}")
                };
                assert_eq!(all(plain), all(scaled), "{}", specimen.name());
            }
        }
    });
}

#[test]
fn the_four_coefficients_at_a_scale_are_the_closed_forms() {
    every_scaled(64, |specimen, state, scale| {
        let (v, z) = (state.velocity, deflection(specimen, state, scale));
        let got = specimen.subject.affine(Surface::scaled(v, scale), z);
        let form = specimen.form.scaled(scale);
        let (want, terms) = (form.coefficients(v, z), form.terms(v, z));
        for (got, want, terms, what) in [
            (got.relaxation, want.relaxation, terms.relaxation, "λ"),
            (got.drive, want.drive, terms.drive, "r"),
            (got.stiffness, want.stiffness, terms.stiffness, "c₀"),
            (got.damping, want.damping, terms.damping, "c₂"),
        ] {
            assert_within(ROUNDING, terms, got, want, || {
                format!("{} {what} at v = {v:e}, z = {z:e}, s = {scale}", specimen.name())
            });
        }
    });
}

#[test]
fn steady_sliding_is_scaled_and_a_long_step_ends_in_it() {
    every_scaled(64, |specimen, state, scale| {
        let (v, subject) = (state.velocity, &specimen.subject);
        let surface = Surface::scaled(v, scale);
        let name = || format!("{} at v = {v:e}, s = {scale}", specimen.name());
        let (one, p) = (subject.stationary_force(v.into()), specimen.form.recipe.load);
        let (z, at_one) = (subject.stationary(surface), subject.stationary(v.into()));
        assert_within(4.0 * f64::EPSILON, z.abs(), z, scale * at_one, name);
        // Regularised, an elasto-plastic bristle has α < 1 in steady sliding.
        if !subject.obeys(Law::SteadySliding) {
            return;
        }
        let got = subject.stationary_force(surface);
        assert_within(4.0 * f64::EPSILON, one.abs() * scale, got, scale * one, name);
        let start = deflection(specimen, state, scale);
        if v == 0.0 || subject.affine(surface, start).relaxation == 0.0 {
            return;
        }
        let held = subject.held(surface, start, 1e300);
        let terms = specimen.form.scaled(scale).terms(v, z);
        let reach = start.abs().max(z.abs());
        let sum = terms.stiffness * reach + terms.damping * v.abs();
        // The step of an implicit bristle has the accuracy of its own.
        let tolerance = if specimen.is_implicit() { 1e-7 } else { ROUNDING };
        if specimen.form.family != Family::ElastoPlastic {
            assert_within(tolerance, reach, held.deflection, z, name);
            assert_within(tolerance, sum, held.end_coefficient, scale * one / p, name);
        }
    });
}

#[test]
fn a_bristle_of_several_springs_slides_on_the_scaled_curve() {
    let zener =
        ZenerParameters { static_stiffness: 1e4, relaxing_stiffness: 2e4, series_damping: 50.0 };
    let bristle = GeneralisedMaxwell::zener(zener).unwrap();
    let model = FrBd::new(stribeck::<f64>(&Recipe::TABLE_2, 2.0), bristle);
    for v in [-0.4, 0.003, 0.7] {
        for scale in [0.3, 2.0] {
            let surface = Surface::scaled(v, scale);
            let want = scale * model.stationary_coefficient(v);
            let held = model.hold(surface, model.stationary(v), 1e3).end_coefficient;
            assert_within(ROUNDING, want.abs(), held, want, || format!("{v} {scale}"));
        }
    }
}

#[test]
fn no_scale_makes_a_passive_model_give_energy() {
    let claims = Cell::new(0);
    every_scaled(64, |specimen, state, scale| {
        let (subject, form) = (&specimen.subject, specimen.form.scaled(scale));
        if !subject.obeys(Law::Passivity) {
            return;
        }
        claims.set(claims.get() + 1);
        let (v, p) = (state.velocity, form.recipe.load);
        let surface = Surface::scaled(v, scale);
        let storage = form.storage();
        let energy = |z: f64| 0.5 * storage * z * z;
        // Only LuGre's theorem is for deflections within the limit.
        let lugre = matches!(form.family, Family::LuGreClassical | Family::LuGreInside);
        for size in if lugre { &[1.0][..] } else { &[1.0, 5.0] } {
            let z = size * deflection(specimen, state, scale);
            let name = || format!("{} at v = {v:e}, z = {z:e}, s = {scale}", specimen.name());
            // At an instant.
            let stored = p * storage * z * subject.rate(surface, z);
            let power = subject.force(surface, z) * v - stored;
            let terms = form.power_terms(v, z) + form.power_by_alpha(v, z);
            assert!(power >= -ROUNDING * terms, "{}: {power:e}", name());
            // Over an exact step.
            let rate = subject.affine(surface, z).relaxation;
            let h = if rate > 0.0 { state.horizon / rate } else { state.duration };
            let held = subject.held(surface, z, h);
            let work = held.mean_coefficient * v * h;
            let (from, to) = (energy(z), energy(held.deflection));
            let rounding = if specimen.is_implicit() { 1e-8 } else { 16.0 * f64::EPSILON };
            let margin = work - (to - from);
            assert!(margin >= -rounding * (work.abs() + from + to), "{}: {margin:e}", name());
        }
    });
    assert!(claims.get() > 2000, "{}", claims.get());
}

#[test]
fn a_companion_step_keeps_its_balance_at_every_scale() {
    let case = (recipe(), state(), scale(), -1.0..1.0);
    check(48, case, |(recipe, state, scale, share)| {
        for specimen in specimens::<f64>(&recipe) {
            if !specimen.subject.obeys(Law::Passivity) || !specimen.is_frbd() {
                continue;
            }
            let contact = AsModel(&specimen).under_load(scale * recipe.load).unwrap();
            let contact = contact.measured_at(recipe.load).unwrap();
            let companion = contact.companion(state.velocity.abs()).unwrap();
            let z = deflection(&specimen, &state, scale);
            let step = companion.step(state.velocity, z, state.duration);
            assert!(step.is_passive(), "{}", specimen.name());
            // Whatever the mean velocity comes to.
            let mean = share * (state.velocity.abs() + 1e-3);
            let done = step.commit(mean);
            let force = step.force(mean);
            let stored = contact.stored_energy(done.deflection) - contact.stored_energy(z);
            let margin = force * mean * state.duration - stored;
            // Bias and damping are sums of the terms that are rounded.
            let work = (step.bias().abs() + step.damping() * mean.abs()) * mean.abs();
            let terms = work * state.duration
                + contact.stored_energy(done.deflection)
                + contact.stored_energy(z);
            assert!(margin >= -16.0 * f64::EPSILON * terms, "{}: {margin:e}", specimen.name());
            assert!(done.dissipated >= 0.0);
        }
    });
}

#[test]
fn the_threshold_of_lugres_passivity_does_not_move_with_the_scale() {
    let inputs = (recipe(), state(), scale(), 0.1..1e3_f64, 0.01..10.0_f64);
    check(256, inputs, |(r, state, scale, damping, drop)| {
        let (dynamic, static_) = (r.dynamic, r.dynamic * (1.0 + drop));
        let model = |multiple: f64| {
            let viscous = multiple * damping * (static_ - dynamic) / dynamic;
            let r = Recipe { damping, static_, viscous, ..r };
            LuGre::classical(stribeck::<f64>(&r, 2.0), kelvin_voigt(r.stiffness, damping))
        };
        // The power per reference load, and the sum of its terms.
        let power = |multiple, v: f64, z: f64| {
            let (model, surface) = (model(multiple), Surface::scaled(v, scale));
            let a = model.affine(surface, z);
            let terms = [a.stiffness * z * v, a.damping * v * v, -r.stiffness * z * a.rate(v, z)];
            (terms.iter().sum::<f64>(), terms.iter().map(|x| x.abs()).sum::<f64>())
        };
        // |z| ≤ s μ_s/σ0.
        let limit = scale * static_ / r.stiffness;
        for (v, z) in [
            (state.velocity, state.fraction * limit),
            (1e3 * r.stribeck_velocity, limit),
            (-1e12, -limit),
        ] {
            let (power, terms) = power(1.0 + 1e-9, v, z);
            assert!(power >= -ROUNDING * terms, "v = {v:e}, z = {z:e}, s = {scale}: {power:e}");
        }
        // A twentieth below, F v − Ẇ = s (v²(σ2 − σ1(μ_s − μ_d)/μ_d) + |v| μ_s²/μ_d).
        let missing = 0.05 * damping * (static_ - dynamic) / dynamic;
        let v = 10.0 * r.stribeck_velocity + 2.0 * static_ * static_ / (dynamic * missing);
        assert!(power(0.95, v, limit).0 < 0.0, "v = {v:e}, s = {scale}");
    });
}

#[test]
fn without_a_load_nothing_acts_and_nothing_moves() {
    // Of the models themselves only a damped bristle of FrBD has numbers at s = 0, r = 0 and
    // λ = σ0/σ1 where |v|_ε > 0: the contact answers for all.
    let r = Recipe { stribeck_velocity: 0.3, ..Recipe::TABLE_2 };
    for specimen in specimens::<f64>(&r) {
        let contact = AsModel(&specimen).under_load(0.0).unwrap().measured_at(3.0).unwrap();
        for (v, z) in [(-0.3, 1e-5), (0.0, -1e-5), (0.02, 0.0)] {
            let now = contact.response(v, z);
            let held = contact.hold(v, z, 1e-3);
            let linear = contact.linearised(v, z);
            let numbers = [now.rate, now.force, held.end_force, held.mean_force, linear.rate];
            assert!(numbers.iter().all(|x| *x == 0.0), "{}: {numbers:?}", specimen.name());
            assert_eq!(held.deflection, z, "{}", specimen.name());
            assert_eq!(contact.stationary_force(v), 0.0, "{}", specimen.name());
        }
        let form = &specimen.form;
        if form.family == Family::FrBd && form.sigma1(0.1) > 0.0 {
            let affine = specimen.subject.affine(Surface::scaled(0.1, 0.0), 0.0);
            let want = form.sigma0(0.1) / form.sigma1(0.1);
            assert_within(ROUNDING, want, affine.relaxation, want, || specimen.name());
            assert_eq!((affine.drive, affine.stiffness, affine.damping), (0.0, 0.0, 0.0));
        }
    }
}
