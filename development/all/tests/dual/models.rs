//! Every derivative of the library against dual numbers, which differentiate the values
//! themselves.
//!
//! A derivative is a sum of the terms of the product and quotient rules, which can cancel. Errors
//! are measured against the sum of their absolute values, as `bristle_specimens::closed_form`
//! writes it down, since neither the library nor the dual numbers can do better than a few
//! roundings of it.

use bristle::curve::{FrictionCurve, Stribeck, StribeckParameters};
use bristle::regularisation::Regularisation;
use bristle::{Branch, Bristle};
use bristle_specimens::closed_form::{Curve, Family, Modulus};
use bristle_specimens::recipe::{Recipe, fraction, nonzero_velocity, recipe, scale};
use bristle_specimens::specimens::{
    Specimen, curves, implicit, kelvin_voigt, regularisations, specimens, table_2,
};
use bristle_specimens::viscoelastic::{self, parts, stretches};
use bristle_specimens::{assert_affine, assert_within, check, each, lit};
use num_dual::{Dual2_64, Dual64};
use proptest::prelude::*;

/// A few roundings of about thirty operations on either side, 1e-14; `powd` of the dual numbers is
/// exp(δ ln u), which multiplies them by δ|ln u| ≤ 3.3·32.
const ROUNDING: f64 = 1e-12;

/// The variable of the differentiation.
fn variable(value: f64) -> Dual64 {
    Dual64::new(value, 1.0)
}

/// The tanh of the dual numbers is sinh/cosh, which overflows where the library's does not.
fn within_range_of_dual_tanh(r: Recipe, v: f64) -> Recipe {
    Recipe { threshold: r.threshold.max(v.abs() / 300.0), ..r }
}
/// Random parameters, v ≠ 0, a deflection relative to the full one (beyond it, too), and a friction
/// scale.
fn inputs() -> impl Strategy<Value = (Recipe, f64, f64, f64)> {
    (recipe(), nonzero_velocity(), fraction(), scale())
        .prop_map(|(r, v, z, scale)| (within_range_of_dual_tanh(r, v), v, 1.2 * z, scale))
}
#[test]
fn the_slope_of_every_curve_is_its_derivative() {
    check(512, inputs(), |(r, v, ..)| {
        for ((curve, exact), (_, dual)) in curves::<f64>(&r).iter().zip(curves::<Dual64>(&r)) {
            let want = dual.coefficient(variable(v).into());
            let (mu, slope) = exact.coefficient_and_slope(v.into());
            let name = || format!("{curve:?} at v = {v:e}");
            let terms = curve.dry_slope_terms(&r, v) + curve.viscous(&r);
            assert_within(ROUNDING, terms, slope, want.eps, name);
            assert_within(ROUNDING, mu, mu, want.re, name);
            // One value, by either method.
            assert_within(4.0 * f64::EPSILON, mu, exact.coefficient(v.into()), mu, name);
        }
    });
}

#[test]
fn the_slopes_of_every_regularisation_are_its_derivatives() {
    check(512, inputs(), |(r, v, ..)| {
        let duals = regularisations::<Dual64>(&r);
        for ((modulus, exact), (_, dual)) in regularisations::<f64>(&r).iter().zip(duals) {
            let name = || format!("{modulus:?} at v = {v:e}");
            let (speed, slope) = exact.speed_and_slope(v.into());
            let want = dual.speed(variable(v).into());
            assert_within(ROUNDING, modulus.slope_terms(&r, v), slope, want.eps, name);
            assert_eq!(speed, exact.speed(v.into()), "{}", name());
            let (sign, slope) = exact.sign_and_slope(v.into());
            let want = dual.sign(variable(v).into());
            // Each way of writing it has terms up to 1/|v|_ε, or 1/v_t for the tangent.
            let terms = match modulus {
                Modulus::Exact => 0.0,
                Modulus::SquareRoot => 2.0 / speed,
                Modulus::HyperbolicTangent => 2.0 / r.threshold,
            };
            assert_within(ROUNDING, terms, slope, want.eps, name);
            assert_within(4.0 * f64::EPSILON, 1.0, sign, exact.sign(v.into()), name);
        }
    });
}
/// All derivatives of one specimen at one velocity on one branch, against its dual twin. The
/// tolerance is of the terms at the velocity `mirror`.
fn assert_derivatives(
    specimen: &Specimen<f64>,
    twin: &Specimen<Dual64>,
    (branch, v, z): (Branch, f64, f64),
    (tolerance, mirror): (f64, f64),
) {
    let name = || format!("{} at v = {v:e} ({branch:?}), z = {z:e}", specimen.name());
    let (form, subject) = (&specimen.form, &specimen.subject);
    let p = form.recipe.load;
    let (at, moving) = (branch.of(v), branch.of(variable(v)));
    let standing = branch.of(lit::<Dual64>(v));

    let (values, slopes) = subject.model().affine_and_slopes(subject.surface(at), z);
    let want = each(twin.subject.affine(moving, lit(z)), |dual| dual.eps);
    assert_affine(tolerance, form.slope_terms(mirror, z), slopes, want, || {
        format!("slopes of {}", name())
    });
    // The values that come with the slopes are the values.
    assert_affine(ROUNDING, form.terms(mirror, z), values, subject.affine(at, z), name);

    let got = subject.linearised(at, z);
    let terms = form.partials_terms(mirror, z);
    let by_velocity = twin.subject.response(moving, lit(z));
    let by_deflection = twin.subject.response(standing, variable(z));
    let force_terms = [terms.coefficient_by_deflection, terms.coefficient_by_velocity];
    let [force_by_deflection, force_by_velocity] = force_terms.map(|terms| p * terms);
    for (terms, got, want, what) in [
        (terms.rate_by_deflection, got.rate_by_deflection, by_deflection.rate, "∂ż/∂z"),
        (terms.rate_by_velocity, got.rate_by_velocity, by_velocity.rate, "∂ż/∂v"),
        (force_by_deflection, got.force_by_deflection, by_deflection.force, "∂F/∂z"),
        (force_by_velocity, got.force_by_velocity, by_velocity.force, "∂F/∂v"),
    ] {
        assert_within(tolerance, terms, got, want.eps, || format!("{what} of {}", name()));
    }
    let values = form.terms(mirror, z);
    let sum = values.relaxation * z.abs() + values.drive * v.abs();
    assert_within(ROUNDING, sum, got.rate, subject.rate(at, z), || format!("ż of {}", name()));
    let sum = p * (values.stiffness * z.abs() + values.damping * v.abs());
    assert_within(ROUNDING, sum, got.force, subject.force(at, z), || format!("F of {}", name()));
}

/// Every specimen under a load, beside its dual twin.
fn twins(r: &Recipe, scale: f64) -> impl Iterator<Item = (Specimen<f64>, Specimen<Dual64>)> {
    let specimens = specimens::<f64>(r).into_iter().zip(specimens::<Dual64>(r));
    specimens.map(move |(one, twin)| (one.under(scale), twin.under(scale)))
}

#[test]
fn every_derivative_of_every_model_is_that_of_dual_numbers() {
    check(96, (inputs(), 0.001..0.999), |((r, v, fraction, scale), within)| {
        for (specimen, twin) in twins(&r, scale) {
            let full = specimen.full_deflection(v);
            let state = (Branch::Free, v, fraction * full);
            assert_derivatives(&specimen, &twin, state, (ROUNDING, v));
            // The band between the stick limit and the full deflection, which random states seldom
            // meet.
            if specimen.form.family == Family::ElastoPlastic {
                let stick = specimen.form.stick_limit();
                let z = (stick + within * (full - stick)) * v.signum();
                assert!(specimen.form.in_transition(v, z));
                assert_derivatives(&specimen, &twin, (Branch::Free, v, z), (ROUNDING, v));
            }
        }
    });
}

#[test]
fn derivatives_hold_at_rest_and_at_slightly_negative_speeds_on_a_locked_branch() {
    check(64, (inputs(), 1e-6..1.0), |((r, v, fraction, _), overshoot)| {
        // Far from the pole at μ/(σ1 + σ2), from where the continued table might turn negative,
        // and from where the continued elements would be many times what they are at rest.
        let floor = r.dynamic * r.table.iter().fold(1.0_f64, |a, b| a.min(*b));
        let reach = (0.01 * r.stribeck_velocity)
            .min(0.1 * floor / (1.5 * r.damping + r.viscous))
            .min(0.1 * r.varying_velocity);
        let branch = Branch::towards(v);
        let wrong = -v.signum() * overshoot * reach;
        let r = within_range_of_dual_tanh(r, wrong);
        for (specimen, twin) in twins(&r, 1.0) {
            let z = fraction * specimen.full_deflection(v);
            // The sums of the terms are those of the mirrored velocity up to small factors: a
            // tenth of g, thrice the varying elements, the continued curves; squared at most.
            let tolerance = 20.0 * ROUNDING;
            // The tip of an implicit bristle does not know of branches.
            let mirror = if specimen.is_implicit() { wrong } else { -wrong };
            assert_derivatives(&specimen, &twin, (branch, wrong, z), (tolerance, mirror));
            // At rest they are one-sided. A power of a dual zero has none, see below; an implicit
            // bristle is at rest where its tip is.
            let power = matches!(specimen.form.curve, Curve::Stribeck(d) if d != 1.0 && d != 2.0);
            if !power && !specimen.is_implicit() {
                let side = v.signum() * f64::MIN_POSITIVE;
                assert_derivatives(&specimen, &twin, (branch, 0.0, z), (tolerance, side));
            }
        }
    });
}
#[test]
fn every_derivative_of_several_springs_is_that_of_dual_numbers() {
    let strategy = (recipe(), parts(), nonzero_velocity(), prop::array::uniform5(-3.0..3.0));
    check(48, strategy, |(r, p, v, forces)| {
        let duals = viscoelastic::specimens::<Dual64>(&r, &p);
        for (exact, dual) in viscoelastic::specimens::<f64>(&r, &p).iter().zip(&duals) {
            let (form, x) = (&exact.form, stretches(&exact.form, &forces));
            let along: Vec<f64> = x.iter().rev().map(|x| 1e-6 + x).collect();
            let lifted = |each: &dyn Fn(f64, f64) -> Dual64| -> Vec<Dual64> {
                x.iter().zip(&along).map(|(x, a)| each(*x, *a)).collect()
            };
            let by_velocity = (Dual64::new(v, 1.0), lifted(&|x, _| x.into()));
            let by_state = (Dual64::from(v), lifted(&Dual64::new));
            let (rate_v, force_v, rate_x, force_x) = exact.subject.derivatives(v, &x, &along);
            let (rate, terms) = form.common_rate(v, &x);
            let along_terms = form.common_rate(v, &along).1;
            // Slopes over the velocities on which the curve, the dashpots and |v| change.
            let least = v.abs().min(r.stribeck_velocity).min(r.varying_velocity);
            let force_terms = r.load * (form.carried(&x).0 + form.damping(v) * terms);
            let name = |of| move || format!("{} {of}", exact.name());
            let want = dual.subject.force(by_velocity.0, &by_velocity.1).eps;
            assert_within(ROUNDING, 10.0 * force_terms / least, force_v, want, name("∂F/∂v"));
            let want = dual.subject.force(by_state.0, &by_state.1).eps;
            let scale = r.load * form.carried(&along).0;
            assert_within(ROUNDING, scale, force_x, want, name("∂F/∂x"));
            let want_v = dual.subject.rate(by_velocity.0, &by_velocity.1);
            let want_x = dual.subject.rate(by_state.0, &by_state.1);
            for (i, a) in form.decay(v).into_iter().enumerate() {
                let scale = (10.0 * (terms + a * x[i].abs()) + rate.abs()) / least;
                assert_within(ROUNDING, scale, rate_v[i], want_v[i].eps, name("∂ẋ/∂v"));
                let scale = along_terms + a * along[i].abs();
                assert_within(ROUNDING, scale, rate_x[i], want_x[i].eps, name("∂ẋ/∂x"));
            }
        }
    });
}
#[test]
fn the_derivatives_of_an_implicit_bristle_by_dual_numbers_are_of_first_order() {
    // Parameters can carry the derivative, too: ∂v_s/∂μ_d at a fixed load is −∂f/∂μ_d / Φ', with
    // Φ' = 23.9 in Table 2.
    let (curve, bristle) = table_2();
    let model = implicit(curve, bristle);
    let z = model.stationary(5.5e-3);
    let by_hand = model.linearised(5.5e-3, z).rate_by_deflection;
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: Dual64::new(1.5, 0.0),
        dynamic_coefficient: Dual64::new(1.0, 1.0),
        stribeck_velocity: Dual64::from(0.01),
        stribeck_exponent: Dual64::from(2.0),
        viscous_friction: Dual64::from(0.04),
    })
    .unwrap();
    let dual = implicit(curve, kelvin_voigt(Dual64::from(1e4), Dual64::from(64.5)));
    let got = dual.tip_velocity(Dual64::from(5.5e-3), Dual64::from(z)).eps;
    let want = -(1.0 - (-0.3025_f64).exp()) * (-by_hand / 1e4);
    assert_within(1e-12, want.abs(), got, want, || "∂v_s/∂μ_d".into());
    // The second derivative of a twice dual number is not right, which the documentation says; its
    // value and first derivative are.
    let (curve, bristle) = table_2::<Dual2_64>();
    let got = implicit(curve, bristle).rate(Dual2_64::from(5.5e-3), Dual2_64::new(z, 1.0, 0.0));
    assert_within(1e-12, by_hand.abs(), got.v1, by_hand, || "∂ż/∂z".into());
}

#[test]
fn a_longer_step_of_an_implicit_bristle_goes_on_at_the_rate_of_its_end() {
    let (model, dual) = (table_2::<f64>(), table_2::<Dual64>());
    let (model, dual) = (implicit(model.0, model.1), implicit(dual.0, dual.1));
    // It sticks, begins to slide, slides on, slides back.
    for (velocity, z) in [(1e-3, 0.0), (0.02, 0.0), (5.0, 0.0), (-0.3, 1e-4)] {
        for h in [1e-4, 1e-2, 0.1].map(variable) {
            let held = dual.hold(Dual64::from(velocity), z.into(), h);
            let (impulse, force) = (held.mean_coefficient * h, held.end_coefficient.re);
            let rate = model.rate(velocity, held.deflection.re);
            assert_within(1e-12, velocity.abs(), held.deflection.eps, rate, || "∂z/∂h".into());
            assert_within(1e-12, force.abs(), impulse.eps, force, || "∂(h F)/∂h".into());
        }
    }
}
