//! The laws of friction with bristle dynamics, each written once and run over every implementor
//! that claims it; and a counterexample for every law that one denies.

use bristle::curve::{FrictionCurve, FunctionCurve};
use bristle::{Affine, AnyBristle, Bounds, Bristle, Contact, FrBd, Law, LuGre, Surface};
use bristle_specimens::closed_form::{ClosedForm, Curve, Element, Family, Modulus};
use bristle_specimens::own_rheology::own_element;
use bristle_specimens::recipe::{Recipe, State, decades, recipe, scale, state};
use bristle_specimens::specimens::{
    Specimen, coulomb, curves, dahl, elasto_plastic, kelvin_voigt, specimens, spring, square_root,
    stribeck, table_2_bristle, table_2_curve, varying_stiffness,
};
use bristle_specimens::{assert_affine, assert_within, check, integral, root, runge_kutta};
use proptest::prelude::*;

/// What a handful of roundings may cost, relative to the sum of the absolute terms. The longest
/// chains here are about twenty operations, 5e-15; powers (δ = 3.3 over thirteen decades of
/// speed) and products λh up to 700 in an exponent lose two digits more.
const ROUNDING: f64 = 1e-12;

/// One specimen in one state.
struct Case<'a> {
    specimen: &'a Specimen<f64>,
    form: &'a ClosedForm,
    subject: &'a Contact<f64, AnyBristle<f64>>,
    state: &'a State,
    /// Reference load P \[N\].
    load: f64,
    v: f64,
    /// A deflection within the limit for every velocity, or for those up to |v|.
    z: f64,
}

impl Case<'_> {
    fn name(&self) -> String {
        format!("{} at v = {:e}, z = {:e}", self.specimen.name(), self.v, self.z)
    }

    fn obeys(&self, law: Law) -> bool {
        self.subject.model().obeys(law)
    }

    /// The sum of the absolute terms of F at deflections up to a size.
    fn force_terms(&self, reach: f64) -> f64 {
        let terms = self.form.terms(self.v, self.z);
        self.load * (terms.stiffness * reach + terms.damping * self.v.abs())
    }

    /// The length of a step: `horizon` relaxation times, or the given one where nothing relaxes.
    fn step(&self) -> f64 {
        let rate = self.subject.affine(self.v, self.z).relaxation;
        if rate > 0.0 { self.state.horizon / rate } else { self.state.duration }
    }
}

/// Runs a check over every specimen at random parameters, loads and states.
fn every_specimen(cases: u32, test: impl Fn(&Case<'_>)) {
    check(cases, (recipe(), state(), scale()), |(recipe, state, scale)| {
        for specimen in specimens(&recipe) {
            let specimen = specimen.under(scale);
            let (form, subject, v) = (&specimen.form, &specimen.subject, state.velocity);
            let most = |fastest| subject.limits(fastest).deflection;
            let z = state.fraction * most(f64::INFINITY).or_else(|| most(v)).unwrap();
            let (specimen, load) = (&specimen, recipe.load);
            test(&Case { specimen, form, subject, state: &state, load, v, z });
        }
    });
}

/// Runs a check over every specimen that claims a law; there must be some.
fn every_claimant(law: Law, cases: u32, test: impl Fn(&Case<'_>)) {
    let claims = std::cell::Cell::new(0);
    every_specimen(cases, |case| {
        if case.obeys(law) {
            claims.set(claims.get() + 1);
            test(case);
        }
    });
    assert!(claims.get() > cases, "hardly anybody claims {law}");
}

#[test]
fn coefficients_and_stationary_deflection_are_the_closed_forms_and_rate_and_force_their_sums() {
    every_specimen(64, |case| {
        let Case { form, subject, load, v, z, .. } = *case;
        let (terms, want, a) = (form.terms(v, z), form.coefficients(v, z), subject.affine(v, z));
        assert_affine(ROUNDING, terms, a, want, || case.name());
        for (got, terms) in [
            (subject.rate(v, z), [a.drive * v, -a.relaxation * z]),
            (subject.force(v, z), [load * a.stiffness * z, load * a.damping * v]),
        ] {
            // The same two products and one sum, so the same roundings but for the load.
            let (sum, want) = (terms[0].abs() + terms[1].abs(), terms[0] + terms[1]);
            assert_within(4.0 * f64::EPSILON, sum, got, want, || case.name());
        }
        // z_ss = sgn_ε(v) μ/σ0, also where an elasto-plastic model does not arrive at it.
        let want = form.sign(v) * form.mu(v) / form.sigma0(v);
        assert_within(ROUNDING, want.abs(), subject.stationary(v), want, || case.name());
    });
}

#[test]
fn steady_sliding_reproduces_the_curve() {
    every_claimant(Law::SteadySliding, 64, |case| {
        let Case { form, subject, load, v, .. } = *case;
        let (z, name) = (subject.stationary(v), || case.name());
        let (dry, viscous) = (load * form.mu(v) * form.sign(v), load * form.outside() * v);
        // The two terms of the force at z_ss are added up from c₀z and c₂v.
        let (c, scale) = (form.terms(v, z), load * form.mu(v));
        let terms = load * (c.stiffness * z.abs() + c.damping * v.abs()) + scale;
        assert_within(ROUNDING, terms, subject.force(v, z), dry + viscous, name);
        // Given on purpose, it does not suffer from LuGre's difference c₀z + c₂v.
        let scale = scale + viscous.abs();
        assert_within(ROUNDING, scale, subject.stationary_force(v), dry + viscous, name);
        let terms = c.relaxation * z.abs() + c.drive * v.abs();
        assert_within(ROUNDING, terms, subject.rate(v, z), 0.0, name);
    });
}

/// Two models that must be the same, up to a reciprocal more or less.
fn assert_same<A, B>(a: &A, b: &B, v: f64, z: f64, what: &str)
where
    A: Bristle<f64, Deflection = f64>,
    B: Bristle<f64, Deflection = f64>,
{
    let want = b.affine(v.into(), z);
    assert_affine(4.0 * f64::EPSILON, want, a.affine(v.into(), z), want, || what.into());
    let (got, want) = (a.stationary(v), b.stationary(v));
    assert_within(4.0 * f64::EPSILON, want.abs(), got, want, || what.into());
}

#[test]
fn where_a_parameter_vanishes_one_model_is_another() {
    check(128, (recipe(), state(), 1.0..10.0), |(recipe, state, beyond)| {
        let v = state.velocity;
        let dry = Recipe { viscous: 0.0, ..recipe };
        let (curve, undamped) = (stribeck(&dry, 2.0), spring(recipe.stiffness));
        let z = state.fraction * recipe.static_ / recipe.stiffness;
        assert_same(&FrBd::new(coulomb(&dry), undamped), &dahl(&dry), v, z, "FrBD is Dahl's");
        let frbd = FrBd::new(curve, undamped);
        assert_same(&LuGre::classical(curve, undamped), &frbd, v, z, "LuGre's is FrBD");
        // An elasto-plastic bristle beyond its full deflection, by one rounding at least.
        let damped = kelvin_voigt(recipe.stiffness, recipe.damping);
        let stick_limit = recipe.stick_fraction * recipe.dynamic / recipe.stiffness;
        let plastic = elasto_plastic(curve, damped, stick_limit);
        let v = if v == 0.0 { 1.0 } else { v };
        let z = beyond * (1.0 + 1e-15) * plastic.stationary(v);
        assert_same(&plastic, &FrBd::new(curve, damped), v, z, "α = 1");
    });
}

#[test]
fn lugre_of_an_frbd_model_has_its_parts_and_no_negative_viscous_friction() {
    let (curve, bristle) = (table_2_curve::<f64>(), table_2_bristle());
    let frbd = FrBd::new(curve, bristle);
    let lugre = LuGre::with_viscous_friction(curve, bristle, 0.3).unwrap();
    assert_eq!(LuGre::of_frbd(frbd, 0.3), lugre);
    for refused in [-0.3, f64::NAN] {
        assert!(LuGre::of_frbd(frbd, refused).coefficient(1.0, 0.0).is_nan());
        assert!(LuGre::with_viscous_friction(curve, bristle, refused).is_err());
    }
}

#[test]
fn plasticity_rises_from_zero_at_the_stick_limit_to_one_at_full_deflection() {
    let recipe = Recipe { static_: 1.0, viscous: 0.0, ..Recipe::TABLE_2 };
    let model = elasto_plastic(coulomb(&recipe), kelvin_voigt(1e4, 64.5), 5e-5);
    // z_b = 5e-5 m, z_m = 1e-4 m: half way sin 0 = 0, a quarter sin(−π/4).
    let quarter = 0.5 - 0.5 * std::f64::consts::FRAC_1_SQRT_2;
    for (z, alpha) in [
        (0.0, 0.0),
        (5e-5, 0.0),
        (6.25e-5, quarter),
        (7.5e-5, 0.5),
        (8.75e-5, 1.0 - quarter),
        (1e-4, 1.0),
        (2e-4, 1.0),
    ] {
        for (v, z, alpha) in
            [(0.1, z, alpha), (-0.1, -z, alpha), (0.1, -z, 0.0), (-0.1, z, 0.0), (0.0, z, 0.0)]
        {
            // The phase is a difference of numbers twice the width: a few roundings.
            assert_within(1e-14, 1.0, model.plasticity(v, z), alpha, || format!("α({v}, {z})"));
        }
    }
    // Between the kinks of α, and there alone, the switching function is negative.
    for (z, side) in [(4e-5, 1.0), (6e-5, -1.0), (9e-5, -1.0), (1.1e-4, 1.0), (-6e-5, 1.0)] {
        for (surface, z) in [(0.1.into(), z), ((-0.1).into(), -z)] {
            let value: f64 = model.switching_function(surface, z).unwrap();
            assert_eq!(value.signum(), side, "{z}");
        }
        let scaled = model.switching_function(Surface::scaled(0.1, 0.5), 0.5 * z).unwrap();
        assert_eq!(scaled.signum(), side, "{z}");
    }
    assert_eq!(model.characteristics(1.0).unwrap().stick_limit, Some(5e-5));
    assert!(model.plasticity(0.1, f64::NAN).is_nan());
    assert!(model.rate(0.1, f64::NAN).is_nan());
}

#[test]
fn the_bristle_is_in_series_with_a_dashpot_frozen_at_the_rigid_velocity() {
    every_claimant(Law::Secant, 64, |case| {
        let (off, terms) = secant_violation(case.specimen, case.v, case.z);
        assert_within(ROUNDING, terms, off, 0.0, || case.name());
    });
}

/// v_s − s F/p with the compliance s = |v|_ε/μ, and the sum of its absolute terms.
fn secant_violation(specimen: &Specimen<f64>, v: f64, z: f64) -> (f64, f64) {
    let (form, terms) = (&specimen.form, specimen.form.terms(v, z));
    let compliance = form.speed(v) / (form.scale * form.curve.mu(&form.recipe, v));
    let sliding = v - specimen.subject.rate(v, z);
    let force = specimen.subject.force(v, z) / form.recipe.load;
    let sum = v.abs()
        + terms.drive * v.abs()
        + terms.relaxation * z.abs()
        + compliance * (terms.stiffness * z.abs() + terms.damping * v.abs());
    (sliding - compliance * force, sum)
}

// energy

#[test]
fn the_dissipated_power_is_the_work_less_what_is_stored() {
    every_specimen(64, |case| {
        let Case { form, subject, load, v, .. } = *case;
        // Any deflection, also far beyond the limit: the identity is algebra.
        for z in [case.z, 10.0 * case.z] {
            let terms = form.power_terms(v, z) + form.power_by_alpha(v, z);
            let stored = load * form.storage() * z;
            let balance = subject.force(v, z) * v - stored * subject.rate(v, z);
            let dissipated = subject.dissipated_power(v, z);
            assert_within(ROUNDING, terms, dissipated, balance, || case.name());
            assert_within(ROUNDING, terms, dissipated, form.dissipation(v, z), || case.name());
            let energy = 0.5 * stored * z;
            assert_within(ROUNDING, energy, subject.stored_energy(z), energy, || case.name());
        }
    });
}

#[test]
fn friction_never_gives_more_energy_than_it_stored() {
    every_claimant(Law::Passivity, 96, |case| {
        let Case { form, subject, v, z, .. } = *case;
        let power = subject.dissipated_power(v, z);
        assert!(power >= -ROUNDING * form.power_terms(v, z), "{}: {power:e}", case.name());
    });
}

#[test]
fn frbd_dissipates_in_its_surface_and_in_its_dashpot_each_for_itself() {
    every_specimen(64, |case| {
        let Case { specimen, form, subject, load, v, .. } = *case;
        let in_family = specimen.is_frbd() || specimen.freezes();
        if form.stiffness != Element::Constant || !in_family {
            return;
        }
        let (z, name) = (3.0 * case.z, || case.name());
        let (rate, force) = (subject.rate(v, z), subject.force(v, z));
        let surface = force * (v - rate);
        let dashpot = load * form.sigma1(v) * rate * rate;
        let terms = form.terms(v, z);
        let force_terms = load * (terms.stiffness * z.abs() + terms.damping * v.abs());
        let rate_terms = terms.relaxation * z.abs() + terms.drive * v.abs();
        let sum = form.power_terms(v, z)
            + form.power_by_alpha(v, z)
            + force_terms * (v.abs() + rate_terms)
            + load * form.sigma1(v) * rate_terms * rate_terms;
        let want = form.dissipation(v, z);
        assert_within(ROUNDING, sum, surface + dashpot, want, name);
        assert!(surface >= -ROUNDING * sum, "{}: F v_s = {surface:e}", name());
        // What the library adds up for this family has no negative term, so it is accurate
        // relative to itself, and its sign is beyond rounding. The tip velocity has an error that
        // is not relative to itself.
        let power = subject.dissipated_power(v, z);
        let by_tip = if specimen.is_implicit() { sum } else { 0.0 };
        assert_within(ROUNDING, want + form.power_by_alpha(v, z) + by_tip, power, want, name);
        assert!(power >= 0.0, "{}: {power:e}", name());
    });
}

// bounds

#[test]
fn the_deflection_turns_back_at_its_limit() {
    every_claimant(Law::BoundedDeflection, 64, |case| {
        let Case { form, subject, v, .. } = *case;
        for fastest in [v.abs(), 10.0 * v.abs(), f64::INFINITY] {
            let Some(limit) = subject.limits(fastest).deflection else { continue };
            for z in [limit, -limit] {
                let (rate, terms) = (subject.rate(v, z), form.terms(v, z));
                let sum = terms.relaxation * limit + terms.drive * v.abs();
                let outwards = rate * z.signum();
                assert!(outwards <= ROUNDING * sum, "{}: {rate:e} at {z:e}", case.name());
            }
        }
    });
}

#[test]
fn the_deflection_stays_within_its_limit_over_any_sequence_of_steps() {
    every_claimant(Law::BoundedDeflection, 48, |case| {
        let Case { form, subject, state, .. } = *case;
        let fastest = state.velocity.abs().max(1e-9);
        let limit = subject.limits(fastest).deflection.unwrap();
        let mut z = state.fraction * limit;
        for &(fraction, horizon) in &state.chain {
            let (v, h) = (fraction * fastest, horizon * limit / fastest);
            // Steps that freeze α may overshoot by the displacement of the step; those that follow
            // a tip by the accuracy of that.
            let slack = match form.family {
                Family::ElastoPlastic => v.abs() * h,
                Family::Implicit => 1e-8 * limit,
                _ => ROUNDING * limit,
            };
            z = subject.hold(v, z, h).deflection;
            assert!(z.abs() <= limit + slack, "{}: {z:e} beyond {limit:e}", case.name());
            z = z.clamp(-limit, limit);
        }
    });
}

/// What a law promises for every velocity is given as a limit; a model that denies it may know a
/// limit for some velocities.
#[test]
fn every_limit_that_is_given_holds() {
    every_specimen(96, |case| {
        let Case { form, subject, state, load, v, .. } = *case;
        for fastest in [v.abs(), 10.0 * v.abs(), f64::INFINITY] {
            let limits = subject.limits(fastest);
            let name = || format!("{}, up to {fastest:e}", case.name());
            if fastest.is_finite() && fastest > 0.0 {
                assert!(limits.deflection.is_some(), "{}", name());
                assert_eq!(limits.relaxation_rate.is_some(), form.scale == 1.0, "{}", name());
            }
            if let (Some(limit), Some(most)) = (limits.force, limits.deflection) {
                let force = subject.force(v, state.fraction * most).abs();
                assert!(force <= limit * (1.0 + ROUNDING), "{}: F = {force:e}", name());
            }
            if case.obeys(Law::BoundedForce)
                && let Some(most) = limits.deflection
            {
                // p max μ; for the value of the maximum see tests/models/curves.rs.
                let limit = limits.force.expect("a bounded deflection bounds the force");
                assert!(limit >= load * form.mu(v) * (1.0 - ROUNDING), "{}", name());
                let carried = most * form.recipe.stiffness * load;
                assert_within(ROUNDING, limit, carried, limit, name);
            }
            if let Some(limit) = limits.relaxation_rate {
                // At any deflection, for α is largest far out, and at any velocity of the range.
                let faster = [v, 1e6 * v, -1e12];
                let velocities = if fastest.is_finite() { &faster[..1] } else { &faster };
                for (&v, size) in velocities.iter().flat_map(|v| [(v, 1.0), (v, 3.0)]) {
                    let rate = subject.affine(v, size * case.z).relaxation;
                    assert!(rate <= limit * (1.0 + ROUNDING), "{}: λ = {rate:e}", name());
                }
            } else {
                let claimed = case.obeys(Law::BoundedRelaxation) && form.scale == 1.0;
                assert!(!claimed || fastest == 0.0, "{}: no limit of λ", name());
            }
        }
    });
}

#[test]
fn the_relaxation_limit_of_frbd_is_stiffness_over_damping_and_viscosity() {
    // σ0/(σ1 + σ2), with ε > 0 provided that σ2 |0|_ε ≤ μ_d.
    check(128, recipe(), |r| {
        for specimen in specimens::<f64>(&r) {
            let form = &specimen.form;
            let plain = form.curve == Curve::Stribeck(2.0) && form.damping == Element::Constant;
            let family = matches!(form.family, Family::FrBd | Family::ElastoPlastic);
            let covered = r.viscous * form.modulus.at_rest(&r) <= r.dynamic * (1.0 - ROUNDING);
            if plain && family && covered && form.stiffness == Element::Constant {
                let want = r.stiffness / (r.damping + r.viscous);
                let got = specimen.subject.limits(f64::INFINITY).relaxation_rate;
                let got = got.unwrap_or(f64::INFINITY);
                assert!((got - want).abs() <= ROUNDING * want || got == want, "{got} {want}");
            }
        }
    });
}

#[test]
fn the_relaxation_limits_of_table_2_are_known() {
    let (curve, bristle) = (table_2_curve::<f64>(), table_2_bristle());
    let rate = FrBd::new(curve, bristle).limits(f64::INFINITY).relaxation_rate.unwrap();
    // The critical step of Euler's method with the velocity held, 2/λ = 0.012908 s.
    assert_within(1e-12, 1.0, 2.0 / rate, 0.012908, || "Euler".into());
    // With the viscous part inside, σ0/σ2.
    let inside = LuGre::with_viscous_friction(curve, bristle, 0.0).unwrap();
    let rate = inside.limits(f64::INFINITY).relaxation_rate.unwrap();
    assert_within(ROUNDING, 2.5e5, rate, 2.5e5, || "LuGre".into());
    assert_eq!(LuGre::classical(curve, bristle).limits(f64::INFINITY).relaxation_rate, None);
    // σ2√ε = 20 μ_d: at rest λ = σ0√ε/(σ1√ε + μ_d) exceeds σ0/(σ1 + σ2).
    let r = Recipe { viscous: 2.0, damping: 1.0, epsilon: 100.0, ..Recipe::TABLE_2 };
    let model = FrBd::new(coulomb(&r), kelvin_voigt(r.stiffness, r.damping));
    let limits = model.regularised(square_root(&r)).limits(f64::INFINITY);
    assert!(limits.relaxation_rate.unwrap() >= 1e5 / 11.0);
}

/// Classical LuGre with σ2 at a multiple of Barabanov and Ortega's threshold, under s times its
/// reference load.
fn at_threshold(r: &Recipe, multiple: f64, scale: f64) -> Specimen<f64> {
    let threshold = r.damping * (r.static_ - r.dynamic) / r.dynamic;
    let r = Recipe { viscous: multiple * threshold, ..*r };
    let form = ClosedForm::new(
        &r,
        Family::LuGreClassical,
        Curve::Stribeck(2.0),
        (Element::Constant, Element::Constant),
    );
    let model = LuGre::classical(stribeck(&r, 2.0), kelvin_voigt(r.stiffness, r.damping));
    let subject = AnyBristle::own(model).under_load(r.load).unwrap();
    Specimen { subject, form }.under(scale)
}

/// Parameters for which the passivity threshold is neither zero nor out of bounds.
fn lugre_recipe() -> impl Strategy<Value = Recipe> {
    (recipe(), decades(1e-2, 1e4), decades(1e-2, 1e1)).prop_map(|(r, damping, drop)| Recipe {
        damping,
        static_: r.dynamic * (1.0 + drop),
        ..r
    })
}

#[test]
fn lugre_is_passive_just_above_the_threshold_of_viscous_friction_and_not_below() {
    check(256, (lugre_recipe(), state(), scale()), |(r, state, scale)| {
        // Above by more than the roundings of the threshold itself.
        let specimen = at_threshold(&r, 1.0 + 1e-9, scale);
        assert!(specimen.subject.model().obeys(Law::Passivity));
        let limit = scale * r.static_ / r.stiffness;
        for (v, z) in [
            (state.velocity, state.fraction * limit),
            // Where it is tight: fast sliding against the largest deflection.
            (1e3 * r.stribeck_velocity, limit),
            (-1e12, -limit),
        ] {
            let power = specimen.subject.dissipated_power(v, z);
            let terms = specimen.form.power_terms(v, z);
            assert!(power >= -ROUNDING * terms, "v = {v:e}, z = {z:e}, s = {scale}: {power:e}");
        }
        let specimen = at_threshold(&r, 0.99, scale);
        assert!(!specimen.subject.model().obeys(Law::Passivity));
        // At z = s μ_s/σ0 and v ≫ v_S,
        // (F v − Ẇ)/P = s (v²(σ2 − σ1(μ_s − μ_d)/μ_d) + |v|μ_s²/μ_d).
        let missing = 0.01 * r.damping * (r.static_ - r.dynamic) / r.dynamic;
        let v = 10.0 * r.stribeck_velocity + 2.0 * r.static_ * r.static_ / (r.dynamic * missing);
        assert!(specimen.subject.dissipated_power(v, limit) < 0.0, "s = {scale}");
    });
}

#[test]
fn table_2_would_need_eight_hundred_times_its_viscous_friction() {
    let claims = |viscous| {
        let r = Recipe { viscous, ..Recipe::TABLE_2 };
        LuGre::classical(stribeck(&r, 2.0), kelvin_voigt(r.stiffness, r.damping))
            .obeys(Law::Passivity)
    };
    // 32.25 = 64.5 (1.5 − 1)/1, all exact in binary.
    assert!(!claims(0.04) && !claims(32.249_999) && claims(32.25));
}

#[test]
fn the_force_of_lugre_leaves_the_curve_and_that_of_frbd_does_not() {
    let (curve, bristle) = (table_2_curve::<f64>(), table_2_bristle());
    // At z = 0, v = 1 m/s: σ1 + σ2 = 64.5 + 0.04, and σ1 alone.
    assert_eq!(LuGre::classical(curve, bristle).coefficient(1.0, 0.0), 64.54);
    let inside = LuGre::with_viscous_friction(curve, bristle, 0.0).unwrap();
    assert_eq!(inside.coefficient(1.0, 0.0), 64.5);
    let frbd = FrBd::new(curve, bristle).coefficient(1.0, 0.0);
    assert_within(5e-5, 1.0, frbd, 1.0235, || "FrBD".into());
}

// elements that depend on the velocity

#[test]
fn a_stiffness_that_depends_on_the_velocity_needs_enough_damping() {
    // (F v − Ẇ)/p = (sσ0|v|/g)z² + (σ0−s) r z v + σ1 r v² ≥ 0 for every z iff
    // μ(σ0(v) − s)² ≤ 4σ1 s σ0(v)|v|_ε: the condition for passivity is sharp at each velocity.
    let seen = std::cell::Cell::new([0, 0]);
    let parameters = (recipe(), state(), decades(1e-3, 1e3));
    check(512, parameters, |(r, state, damping)| {
        let v = if state.velocity == 0.0 { 1e-3 } else { state.velocity };
        // Damping about the amount that decides.
        let form = ClosedForm::new(
            &r,
            Family::FrBd,
            Curve::Stribeck(2.0),
            (Element::Varying, Element::Constant),
        );
        let s = r.stiffness;
        let needed =
            form.mu(v) * (form.sigma0(v) - s).powi(2) / (4.0 * s * form.sigma0(v) * v.abs());
        let r = Recipe { damping: damping * needed, ..r };
        if !(1e-90..1e90).contains(&r.damping) {
            return;
        }
        let form = ClosedForm { recipe: r, ..form };
        let model = FrBd::new(stribeck(&r, 2.0), own_element(varying_stiffness(&r), r.damping));
        assert!(!model.obeys(Law::Passivity), "a closure does not allow to tell");
        let contact = model.under_load(r.load).unwrap();
        // The deflection at which the quadratic is least.
        let c = form.coefficients(v, 0.0);
        let worst = -(form.sigma0(v) - s) * c.drive * v / (2.0 * s * c.relaxation);
        let mut seen_here = seen.get();
        if damping > 1.01 {
            seen_here[0] += 1;
            for z in [worst, state.fraction * worst, 3.0 * state.fraction * r.static_ / s] {
                let power = contact.dissipated_power(v, z);
                assert!(power >= -ROUNDING * form.power_terms(v, z), "v = {v:e}, z = {z:e}");
            }
        } else if damping < 0.99 && form.sigma0(v) != s {
            // (−1 % of the balance of two like terms, against roundings of all of them.)
            let power = contact.dissipated_power(v, worst);
            if 0.01 * form.dissipation(v, worst).abs() > ROUNDING * form.power_terms(v, worst) {
                seen_here[1] += 1;
                assert!(power < 0.0, "v = {v:e}, z = {worst:e}: {power:e}");
            }
        }
        seen.set(seen_here);
    });
    assert!(seen.get().iter().all(|&n| n > 50), "one side hardly met: {:?}", seen.get());
}

// symmetry

#[test]
fn reversing_velocity_and_deflection_reverses_rate_and_force() {
    every_claimant(Law::OddSymmetry, 48, |case| {
        let Case { subject, v, z, .. } = *case;
        let (now, mirrored) = (subject.response(v, z), subject.response(-v, -z));
        // Signs do not round.
        assert_eq!((mirrored.rate, mirrored.force), (-now.rate, -now.force), "{}", case.name());
    });
}

// a held velocity

/// Closed form of a step of a held velocity: deflection at a time, from the coefficients at its
/// beginning (which are tested by themselves).
struct Held {
    v: f64,
    z: f64,
    c: Affine<f64>,
}

impl Held {
    fn deflection(&self, t: f64) -> f64 {
        let Self { v, z, c } = self;
        if c.relaxation == 0.0 {
            z + c.drive * v * t
        } else {
            let x = c.relaxation * t;
            z * (-x).exp() - c.drive * v / c.relaxation * (-x).exp_m1()
        }
    }

    fn mean(&self, h: f64) -> f64 {
        if h == 0.0 {
            return self.z;
        }
        let x = self.c.relaxation * h;
        if x < 1.0 {
            // Eight panels of a quadrature that is exact up to degree nine: (1/8)¹⁰/10!, nothing.
            integral(0.0, h, 8, |t| self.deflection(t)) / h
        } else {
            let phi = -(-x).exp_m1() / x;
            phi * self.z + (1.0 - phi) * self.c.drive * self.v / self.c.relaxation
        }
    }
}

#[test]
fn a_held_velocity_is_stepped_exactly() {
    every_specimen(64, |case| {
        let Case { subject, load, v, z, .. } = *case;
        if case.specimen.is_implicit() {
            // Its coefficients change along the step, see tests/models/implicit_hold.rs; but in the
            // end it slides.
            if v != 0.0 {
                let (got, want) = (subject.hold(v, z, 1e300).deflection, subject.stationary(v));
                assert_within(1e-7, z.abs().max(want.abs()), got, want, || case.name());
            }
            return;
        }
        let held = Held { v, z, c: subject.affine(v, z) };
        // At the end λh overflows, and what is left is steady sliding.
        let forever = if held.c.relaxation < 1e-200 { 0.0 } else { 1e300 };
        for h in [0.0, case.step(), forever] {
            let (end, mean, got) = (held.deflection(h), held.mean(h), subject.hold(v, z, h));
            let reach = z.abs().max(end.abs());
            let (sum, name) = (case.force_terms(reach), || format!("{}, {h:e} s", case.name()));
            assert_within(ROUNDING, reach, got.deflection, end, name);
            let force = |z: f64| load * (held.c.stiffness * z + held.c.damping * v);
            assert_within(ROUNDING, sum, got.end_force, force(end), name);
            assert_within(ROUNDING, sum, got.mean_force, force(mean), name);
        }
    });
}

#[test]
fn no_velocity_is_so_large_that_it_switches_the_friction_off() {
    let overflows = std::cell::Cell::new(0);
    every_claimant(Law::SteadySliding, 8, |case| {
        let Case { specimen, subject, state, .. } = *case;
        if specimen.freezes() {
            return;
        }
        for (sign, exponent) in (100..=308).flat_map(|exponent| [(1.0, exponent), (-1.0, exponent)])
        {
            let (v, slower) = (sign * 10_f64.powi(exponent), sign * 1e99);
            let z = state.fraction.abs() * subject.stationary(slower);
            let held = subject.hold(v, z, 1e6);
            // A number is no less than the friction of steady sliding, which any bristle reaches.
            let least = 0.99 * sign * subject.stationary_force(slower);
            for force in [subject.stationary_force(v), held.end_force, held.mean_force] {
                let name = || format!("{} at {v:e}: {force:e}", specimen.name());
                assert!(!force.is_finite() || sign * force >= least, "{}", name());
                assert!(force.is_finite() || exponent > 140, "{}", name());
                overflows.set(overflows.get() + u32::from(!force.is_finite()));
            }
        }
    });
    assert!(overflows.get() > 0);
}

// creep and drift

#[test]
fn below_breakaway_a_regularised_model_creeps() {
    // v_creep = √ε r/√(1−r²) for |v|_ε = √(v²+ε), and v_t artanh r for v coth(v/v_t).
    check(64, (recipe(), 0.01..0.99_f64), |(r, load_fraction)| {
        // Creep is far below the Stribeck velocity, and viscosity does not count.
        let (root_epsilon, v_t) = (1e-8 * r.stribeck_velocity, 1e-8 * r.stribeck_velocity);
        let r = Recipe { epsilon: root_epsilon * root_epsilon, threshold: v_t, ..r };
        let r = Recipe { viscous: r.viscous.min(r.dynamic / r.stribeck_velocity), ..r };
        let wanted = |modulus| match modulus {
            Modulus::Exact => None,
            Modulus::SquareRoot => {
                Some(root_epsilon * load_fraction / (1.0 - load_fraction * load_fraction).sqrt())
            }
            Modulus::HyperbolicTangent => Some(v_t * load_fraction.atanh()),
        };
        for specimen in specimens::<f64>(&r) {
            let Some(want) = wanted(specimen.form.modulus) else { continue };
            if !specimen.subject.model().obeys(Law::SteadySliding) {
                continue;
            }
            let breakaway = r.load * specimen.form.mu(0.0);
            let got = root(0.0, 1e3 * root_epsilon, |v| {
                specimen.subject.stationary_force(v) - load_fraction * breakaway
            });
            // μ differs from μ_s by (v/v_S)^0.7 of the drop (tenfold at most) for δ = 0.7, with
            // v/v_S ≤ 1e-7: 1.3e-4; near r = 1 the velocity amplifies that by 1/(1−r²) ≤ 50.
            assert_within(0.1, want, got, want, || specimen.name());
            let smooth = !matches!(specimen.form.curve, Curve::Stribeck(d) if d < 1.0);
            if smooth {
                // (v/v_S) ≤ 1e-7 of tenfold drops, viscosity and table slopes, times 50.
                assert_within(1e-3, want, got, want, || specimen.name());
            }
        }
    });
}

/// Displacement of a cycle of held velocities ±v between two forces F1 and F2 (as fractions of
/// breakaway), with the lengths of the steps found from the force alone.
fn drift(specimen: &Specimen<f64>, speed: f64, low: f64, high: f64, cycles: usize) -> f64 {
    let breakaway = specimen.form.recipe.load * specimen.form.mu(0.0);
    let subject = &specimen.subject;
    // No force between these is further apart than a few full deflections.
    let longest = 100.0 * specimen.form.mu(0.0) / specimen.form.recipe.stiffness / speed;
    let go = |z: f64, v: f64, force: f64| {
        let duration = root(0.0, longest, |h| {
            (subject.hold(v, z, h).end_force - force * breakaway) * v.signum()
        });
        (subject.hold(v, z, duration).deflection, v * duration)
    };
    // From zero up and down once, so that the cycle starts where it will end.
    let mut z = go(go(0.0, speed, high).0, -speed, low).0;
    let mut displacement = 0.0;
    for _ in 0..cycles {
        let (up, forward) = go(z, speed, high);
        let (down, backward) = go(up, -speed, low);
        z = down;
        displacement += forward + backward;
    }
    displacement
}

#[test]
fn quasi_static_cycles_make_frbd_and_lugre_drift_and_leave_no_drift_below_a_stick_limit() {
    // Drift, with F_b = p μ_s: (μ_s/σ0) ln[(F_b²−F1²)/(F_b²−F2²)] per cycle.
    let r = Recipe { stribeck_velocity: 1.0, varying_velocity: 1.0, ..Recipe::TABLE_2 };
    let (mut elastic, mut drifting) = (0, 0);
    for specimen in specimens::<f64>(&r) {
        let form = &specimen.form;
        let full = form.mu(0.0) / r.stiffness;
        if specimen.subject.model().obeys(Law::NoDrift) {
            elastic += 1;
            // Elastic up to F = p σ0 z_b.
            let limit = form.stick_limit() / full;
            for (low, high) in [(0.1 * limit, 0.5 * limit), (-0.9 * limit, 0.99 * limit)] {
                let got = drift(&specimen, 1e-10, low, high, 3);
                // Only roundings of full deflections.
                assert_within(ROUNDING, full, got, 0.0, || specimen.name());
            }
        }
        if form.modulus != Modulus::Exact || specimen.freezes() {
            continue;
        }
        drifting += 1;
        for (low, high) in [(0.1, 0.5), (0.0, 0.9), (-0.3, 0.6)] {
            // Each way by dF/dx = pσ0(1 ∓ F/F_b), with F_b of its own direction.
            let asymmetric = form.curve == Curve::Asymmetric;
            let forward = form.mu(0.0);
            let backward = if asymmetric { form.mu(-1e-12) } else { forward };
            let (f1, f2) = (low * forward, high * forward);
            let up = forward * ((forward - f1) / (forward - f2)).ln();
            let down = backward * ((backward + f2) / (backward + f1)).ln();
            let want = 3.0 * (up - down) / r.stiffness;
            if !asymmetric {
                let ratio: f64 = (1.0 - low * low) / (1.0 - high * high);
                let law = 3.0 * full * ratio.ln();
                // Differences of logarithms down to a tenth of them.
                assert_within(ROUNDING, law, want, law, || "drift per cycle".into());
            }
            // σ1 v/μ_s = 6e-9, and (v/v_S)^0.7 = 1e-7 for δ = 0.7; the drift is the difference
            // of two displacements ten times larger.
            let got = drift(&specimen, 1e-10, low, high, 3);
            assert_within(3e-6, want, got, want, || format!("{} {low} {high}", specimen.name()));
        }
    }
    assert!(elastic > 20 && drifting > 60);
}

#[test]
fn between_the_stick_limit_and_breakaway_an_elasto_plastic_bristle_drifts_too() {
    // Elastic up to 0.6 of breakaway: cycles up to 0.59 leave nothing, up to 0.9 something, but
    // less than without the stick limit (no drift below it).
    let r = Recipe { static_: 1.0, viscous: 0.0, ..Recipe::TABLE_2 };
    let full = r.dynamic / r.stiffness;
    let bristle = kelvin_voigt(r.stiffness, 0.0);
    let model = elasto_plastic(coulomb(&r), bristle, 0.6 * full);
    let drift = |high: f64| {
        // α changes along the way: steps of a thousandth of the full deflection.
        let (v, h) = (1e-6, 1e-3 * full / 1e-6);
        let (mut z, mut steps) = (0.0, 0);
        while model.coefficient(v, z) < high {
            z = model.hold(v, z, h).deflection;
            steps += 1;
        }
        while model.coefficient(-v, z) > 0.0 {
            z = model.hold(-v, z, h).deflection;
            steps -= 1;
        }
        f64::from(steps) * 1e-3 * full
    };
    // To a step.
    assert!(drift(0.59).abs() < 2e-3 * full);
    assert!(drift(0.9) > 0.02 * full && drift(0.9) < -(1.0_f64 - 0.81).ln() * full);
}

// loops

#[test]
fn the_settled_loop_of_dahl_is_the_closed_form() {
    check(64, (recipe(), decades(1e-3, 1e2)), |(r, amplitude)| {
        // Amplitude X over the full deflection μ_d/σ0; the velocity does not matter.
        let r = Recipe { viscous: 0.0, ..r };
        let full = r.dynamic / r.stiffness;
        let x = amplitude * full;
        let contact = dahl(&r).under_load(r.load).unwrap();
        let speed = r.stribeck_velocity;
        // A disturbance fades by e^{−4X/full} in each cycle, to a part in 1e14 in 8/(X/full).
        let mut z = 0.0;
        for _ in 0..(2.0 + 8.0 / amplitude) as usize {
            z = contact.hold(speed, z, 2.0 * x / speed).deflection;
            z = contact.hold(-speed, z, 2.0 * x / speed).deflection;
        }
        for fraction in [-1.0, -0.7, 0.0, 0.4, 1.0] {
            let at = fraction * x;
            let got = contact.hold(speed, z, (at + x) / speed).end_force;
            // F = F_c (1 − e^{−σ0x/μ_d}/cosh(σ0X/μ_d)), written without its overflow.
            let decay = 2.0 * (-(at + x) / full).exp() / (1.0 + (-2.0 * x / full).exp());
            let want = r.load * r.dynamic * (1.0 - decay);
            assert_within(ROUNDING, r.load * r.dynamic, got, want, || format!("x/X = {fraction}"));
        }
    });
}

/// ∮ F dv over a settled small sinusoid v0 + a sin ωt.
fn lag_loop(specimen: &Specimen<f64>, v0: f64, amplitude: f64, omega: f64) -> f64 {
    let subject = &specimen.subject;
    let cycle = |z: f64| {
        runge_kutta(0.0..std::f64::consts::TAU / omega, 200, [z, 0.0], |t, [z, _]| {
            let (sin, cos) = (omega * t).sin_cos();
            let now = subject.response(v0 + amplitude * sin, z);
            [now.rate, now.force * amplitude * omega * cos]
        })
    };
    let settled = (0..5).fold(subject.stationary(v0), |z, _| cycle(z)[0]);
    cycle(settled)[1]
}

#[test]
fn lag_loops_are_normal_where_the_curve_falls_and_reversed_where_it_rises() {
    let mut met = 0;
    // μ' < 0 in the Stribeck range and > 0 well above it.
    for (v0, falls) in [(3e-3, true), (0.3, false)] {
        let mu = |v: f64| Curve::Stribeck(2.0).mu(&Recipe::TABLE_2, v);
        let slope = (mu(v0 * 1.001) - mu(v0 * 0.999)) / (0.002 * v0);
        assert_eq!(slope < 0.0, falls);
        for s1 in [0.0, 0.5, 64.5, 500.0] {
            let r = Recipe { damping: s1, ..Recipe::TABLE_2 };
            for specimen in specimens::<f64>(&r) {
                let form = &specimen.form;
                let plain = (form.curve, form.modulus, form.stiffness, form.damping)
                    == (Curve::Stribeck(2.0), Modulus::Exact, Element::Constant, Element::Constant);
                if !plain || !matches!(form.family, Family::FrBd | Family::LuGreInside) {
                    continue;
                }
                met += 1;
                let (g, s0) = (form.resistance(v0, 0.0), r.stiffness);
                // At the corner of the lag, where the loop is widest.
                let (lambda, a) = (s0 * v0 / g, 1e-3 * v0);
                let got = lag_loop(&specimen, v0, a, lambda) / (std::f64::consts::PI * a * a);
                let flips = form.family == Family::LuGreInside && s1 * v0 > g;
                assert_eq!(got > 0.0, falls != flips, "{} at {v0}: {got}", specimen.name());
                // π a² Im G(iλ), with G the transfer function of the linearised model (LuGre: h₁ =
                // v g'/g in place of |v|μ'/g). The amplitude is a thousandth of v0, so second-order
                // terms are 1e-6; the loop is settled to e^{−12π}, and 200 RK4 steps per turn leave
                // 1e-7.
                let want = slope * (s1 * lambda - s0) / (2.0 * lambda) * v0 / g;
                assert_within(1e-4, want.abs(), got, want, || specimen.name());
            }
        }
    }
    assert_eq!(met, 16);
}

/// A state at which a specimen breaks a law, if a search over velocities and deflections finds one.
fn counterexample(specimen: &Specimen<f64>, law: Law) -> Option<String> {
    let (form, subject) = (&specimen.form, &specimen.subject);
    if law == Law::NoDrift {
        // Back and forth between two forces; fast for √ε and slow for v_S.
        let high = 0.9 * form.stick_limit() * form.recipe.stiffness / form.mu(0.0);
        let drift = drift(specimen, 1e-3, 0.0, high, 1);
        let full = form.mu(0.0) / form.recipe.stiffness;
        return (drift > 0.01 * full).then(|| format!("{} drifts by {drift:e} m", specimen.name()));
    }
    let speeds = (-12..=12).map(|i| 10_f64.powf(f64::from(i) / 2.0));
    let velocities: Vec<f64> = speeds.flat_map(|s| [s, -s]).collect();
    // Everything here is far beyond rounding.
    let clearly = 1e-6;
    let farthest = subject.limits(1e9).deflection.unwrap();
    let states = velocities.iter().flat_map(|&v| {
        let limit = subject.limits(v.abs()).deflection.unwrap();
        (-10..=10).map(move |i| (v, limit, f64::from(i) / 10.0 * limit))
    });
    // The largest μ on the speeds up to one, see tests/models/curves.rs.
    let curve = curves(&form.recipe).into_iter().find(|(curve, _)| *curve == form.curve);
    let most = |speed: f64| curve.as_ref().unwrap().1.bounds(speed).max;
    let broken = |&(v, limit, z): &(f64, f64, f64)| {
        match law {
            Law::SteadySliding => {
                let got = subject.stationary_force(v) / form.recipe.load;
                let want = form.mu(v) * form.sign(v) + form.outside() * v;
                (got - want).abs() > clearly * want.abs()
            }
            Law::Secant => {
                let (off, terms) = secant_violation(specimen, v, z);
                off.abs() > clearly * terms
            }
            Law::Passivity => {
                // Also where the power, a quadratic in z, is least, if faster sliding than this
                // can have brought the bristle there.
                let (a, stiffness) = (subject.affine(v, z), form.storage());
                let worst =
                    -(a.stiffness - stiffness * a.drive) * v / (2.0 * stiffness * a.relaxation);
                let reachable = worst.abs() <= farthest;
                [z, if reachable { worst } else { z }].iter().any(|&z| {
                    let power = subject.dissipated_power(v, z);
                    power < 0.0 && power < -clearly * form.power_terms(v, z)
                })
            }
            Law::BoundedDeflection => {
                let terms = form.terms(v, z);
                let sum = terms.relaxation * z.abs() + terms.drive * v.abs();
                z.abs() >= limit && subject.rate(v, z) * z.signum() > clearly * sum
            }
            Law::BoundedForce => {
                let force = subject.force(v, z).abs();
                force > form.recipe.load * most(v.abs()) * (1.0 + clearly)
            }
            Law::OddSymmetry => {
                let (now, mirrored) = (subject.response(v, z), subject.response(-v, -z));
                (now.rate + mirrored.rate).abs() > clearly * now.rate.abs()
                    || (now.force + mirrored.force).abs() > clearly * now.force.abs()
            }
            Law::BoundedRelaxation => {
                // Ten times the speed gives ten times the rate, already at 1e6 m/s.
                let rate = |v: f64| subject.affine(v, 1e3 * z).relaxation;
                v.abs() >= 1e5 && z != 0.0 && rate(10.0 * v) > 9.0 * rate(v)
            }
            _ => panic!("no search for {law}"),
        }
    };
    let found = states.into_iter().find(broken);
    found.map(|(v, _, z)| format!("{} breaks {law} at v = {v:e}, z = {z:e}", specimen.name()))
}

/// Why a specimen denies a law that it may well obey.
fn cannot_tell(specimen: &Specimen<f64>, law: Law) -> Option<&'static str> {
    let form = &specimen.form;
    let lugre = matches!(form.family, Family::LuGreClassical | Family::LuGreInside);
    match law {
        Law::Passivity
            if lugre && form.modulus != Modulus::Exact && form.curve == Curve::Coulomb =>
        {
            Some("the theorem is for ε = 0")
        }
        Law::BoundedForce
            if form.family == Family::LuGreClassical
                && (form.curve, form.damping) == (Curve::Coulomb, Element::None) =>
        {
            Some("σ2 v is not within the curve g whose maximum the law speaks of")
        }
        Law::Passivity if form.stiffness == Element::Varying && form.damping != Element::None => {
            Some("the bounds of a closure do not tell how σ0 goes to σ0(0)")
        }
        _ => None,
    }
}

#[test]
fn every_law_that_is_denied_has_a_counterexample() {
    let moderate = Recipe { damping: 0.5, ..Recipe::TABLE_2 };
    // Without viscous friction nothing but the micro-damping bounds λ.
    let dry = Recipe { viscous: 0.0, ..moderate };
    let mut denied = [0; Law::ALL.len()];
    for recipe in [moderate, dry] {
        for specimen in specimens::<f64>(&recipe) {
            for (law, denied) in Law::ALL.into_iter().zip(&mut denied) {
                let claimed = specimen.subject.model().obeys(law);
                let found = counterexample(&specimen, law);
                if claimed {
                    assert_eq!(found, None);
                } else {
                    *denied += 1;
                    assert!(
                        found.is_some() || cannot_tell(&specimen, law).is_some(),
                        "{} denies {law} without a reason",
                        specimen.name()
                    );
                }
            }
        }
    }
    // A bounded deflection is denied by none of these, see the next test; all others by some.
    for (law, denied) in Law::ALL.into_iter().zip(denied) {
        assert_eq!(denied > 0, law != Law::BoundedDeflection, "{law}");
    }
}

#[test]
fn a_curve_without_an_upper_bound_does_not_tell_about_deflection_and_force() {
    let curve = FunctionCurve::new(
        |speed: f64| (1.0 + speed * speed, 2.0 * speed),
        Bounds { min: 1.0, max: f64::INFINITY },
    )
    .unwrap();
    let model = FrBd::new(curve, kelvin_voigt(1e4, 64.5));
    assert!(!model.obeys(Law::BoundedDeflection));
    assert_eq!(model.limits(1.0).deflection, None);
    assert_eq!(model.limits(1.0).coefficient, None);
    assert!(model.obeys(Law::Passivity) && model.obeys(Law::BoundedRelaxation));
    // 64.5² is more than 4·64.5 times μ/|v| ≥ 0, and no deflection is the largest.
    let lugre = LuGre::with_viscous_friction(curve, kelvin_voigt(1e4, 64.5), 0.0).unwrap();
    assert!(!lugre.obeys(Law::Passivity) && !lugre.obeys(Law::BoundedDeflection));
    // A companion step cuts nothing off: it stores what its exact step stretches the bristle by.
    let companion = model.under_load(1.0).unwrap().companion(1.0).unwrap();
    assert!(companion.step(1e-3, 0.0, 1.0).commit(1.0).deflection > 1e-2);
}

#[test]
fn every_law_has_a_name_of_its_own() {
    let names: std::collections::HashSet<_> = Law::ALL.iter().map(Law::to_string).collect();
    assert_eq!(names.len(), Law::ALL.len());
    assert_eq!(format!("{:>12}|", Law::Secant), "  secant law|");
}

#[test]
fn without_a_load_nothing_acts_and_nothing_moves() {
    // Of the models themselves only a damped bristle of FrBD has numbers at s = 0, r = 0 and
    // λ = σ0/σ1 where |v|_ε > 0: the contact answers for all.
    let r = Recipe { stribeck_velocity: 0.3, ..Recipe::TABLE_2 };
    for specimen in specimens::<f64>(&r) {
        let contact = specimen.model().under_load(0.0).unwrap().measured_at(3.0).unwrap();
        for (v, z) in [(-0.3, 1e-5), (0.0, -1e-5), (0.02, 0.0)] {
            let (now, held) = (contact.response(v, z), contact.hold(v, z, 1e-3));
            let (linear, steady) = (contact.linearised(v, z), contact.stationary_force(v));
            let numbers =
                [now.rate, now.force, held.end_force, held.mean_force, linear.rate, steady];
            assert!(numbers.iter().all(|x| *x == 0.0), "{}: {numbers:?}", specimen.name());
            assert_eq!(held.deflection, z, "{}", specimen.name());
        }
        let form = &specimen.form;
        if form.family == Family::FrBd && form.sigma1(0.1) > 0.0 {
            let affine = specimen.model().affine(Surface::scaled(0.1, 0.0), 0.0);
            let want = form.sigma0(0.1) / form.sigma1(0.1);
            assert_within(ROUNDING, want, affine.relaxation, want, || specimen.name());
            assert_eq!((affine.drive, affine.stiffness, affine.damping), (0.0, 0.0, 0.0));
        }
    }
}
