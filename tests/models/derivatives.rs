//! Every derivative of the library against dual numbers, which differentiate the values
//! themselves; at v = 0, where only one-sided derivatives exist, against closed forms; and all of
//! it once in `f32`.
//!
//! A derivative is a sum of the terms of the product and quotient rules, which can cancel. Errors
//! are measured against the sum of their absolute values, as `bristle_specimens::closed_form`
//! writes it down, since neither the library nor the dual numbers can do better than a few
//! roundings of it.

use bristle::curve::FrictionCurve;
use bristle::regularisation::Regularisation;
use bristle::{Affine, Branch, Bristle, Law, Scalar};
use bristle_specimens::closed_form::{Curve, Family, Modulus, Table};
use bristle_specimens::recipe::{Recipe, fraction, nonzero_velocity, recipe, scale};
use bristle_specimens::specimens::{Specimen, curves, regularisations, specimens};
use bristle_specimens::{assert_affine, assert_within, check, lit};
use num_dual::Dual64;
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

// The parts

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

#[test]
fn the_hyperbolic_tangent_has_an_accurate_slope_in_itself() {
    // Unlike the terms above: coth u − u/sinh² u in the only form that does not cancel near rest,
    // (sinh 2u − 2u)/(2 sinh² u), with the series of sinh 2u − 2u below one.
    check(512, (recipe(), -300.0..300.0_f64, 0.0..8.0_f64), |(r, u, decades)| {
        let u = u / 10_f64.powf(decades);
        let regularisations = regularisations::<f64>(&r);
        let (_, tangent) =
            regularisations.iter().find(|e| e.0 == Modulus::HyperbolicTangent).unwrap();
        let v = u * r.threshold;
        let excess = if u.abs() < 1.0 {
            let mut term = 2.0 * u;
            (1..12)
                .map(|n| {
                    term *= 4.0 * u * u / f64::from(2 * n * (2 * n + 1));
                    term
                })
                .sum()
        } else {
            (2.0 * u).sinh() - 2.0 * u
        };
        let slope = excess / (2.0 * u.sinh().powi(2));
        // Above the switch at |u| = 0.35 the closed form loses a digit and a half.
        assert_within(1e-13, slope.abs(), tangent.speed_and_slope(v.into()).1, slope, || {
            format!("u = {u:e}")
        });
        // 1/cosh² is accurate in itself as far as it goes (e^−600).
        let slope = 1.0 / (u.cosh() * u.cosh() * r.threshold);
        assert_within(1e-13, slope, tangent.sign_and_slope(v.into()).1, slope, || {
            format!("u = {u:e}")
        });
    });
}

// The models

fn full_deflection(specimen: &Specimen<f64>, v: f64) -> f64 {
    specimen.form.mu(v) / specimen.form.recipe.stiffness
}

/// The four coefficients in another scalar.
fn each<T: Scalar, U: Scalar>(a: Affine<T>, part: impl Fn(T) -> U) -> Affine<U> {
    Affine {
        relaxation: part(a.relaxation),
        drive: part(a.drive),
        stiffness: part(a.stiffness),
        damping: part(a.damping),
    }
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
            let full = full_deflection(&specimen, v);
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
            let z = fraction * full_deflection(&specimen, v);
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

// One-sided derivatives at v = 0

/// dμ/d|v| just above rest.
fn slope_from_rest(curve: Curve, r: &Recipe) -> f64 {
    let drop = r.static_ - r.dynamic;
    match curve {
        Curve::Stribeck(1.0) => r.viscous - drop / r.stribeck_velocity,
        // Flat at first for δ > 1; for δ < 1 the documentation promises the viscous part alone.
        Curve::Coulomb | Curve::Stribeck(_) | Curve::Rational | Curve::Asymmetric => r.viscous,
        Curve::Tabulated => Table(r.knots()).slope(0),
        Curve::Function => 0.0,
    }
}

#[test]
fn curves_have_their_one_sided_slopes_at_rest() {
    check(256, recipe(), |r| {
        for (curve, subject) in curves::<f64>(&r) {
            let slope = |branch: Branch| subject.coefficient_and_slope(branch.of(0.0)).1;
            let forward = slope_from_rest(curve, &r);
            let backward = if curve == Curve::Asymmetric { 0.0 } else { -forward };
            let terms = r.viscous
                + (r.static_ - r.dynamic) / r.stribeck_velocity
                + curve.dry_slope_terms(&r, 0.0);
            for (branch, want) in [(Branch::Forward, forward), (Branch::Backward, backward)] {
                assert_within(ROUNDING, terms, slope(branch), want, || format!("{curve:?}"));
            }
            assert_eq!(slope(Branch::Free), 0.0, "{curve:?}: sgn 0 = 0");
        }
    });
}

#[test]
fn the_free_branch_at_rest_takes_the_middle_of_both_sides() {
    check(64, (recipe(), fraction()), |(r, fraction)| {
        for specimen in specimens::<f64>(&r) {
            let form = &specimen.form;
            // The forward curve answers for both where they differ; an elasto-plastic bristle
            // is elastic where there is no direction.
            if form.curve == Curve::Asymmetric || specimen.freezes() {
                continue;
            }
            let z = fraction * full_deflection(&specimen, 0.0);
            let model = specimen.subject.model();
            let [forward, backward, free] = [Branch::Forward, Branch::Backward, Branch::Free]
                .map(|branch| model.affine_and_slopes(branch.of(0.0).into(), z).1);
            let middle = Affine {
                relaxation: 0.5 * (forward.relaxation + backward.relaxation),
                drive: 0.5 * (forward.drive + backward.drive),
                stiffness: 0.5 * (forward.stiffness + backward.stiffness),
                damping: 0.5 * (forward.damping + backward.damping),
            };
            let terms = form.slope_terms(0.0, z);
            assert_affine(ROUNDING, terms, free, middle, || specimen.name());
        }
    });
}

// Single precision

#[test]
fn everything_runs_in_single_precision() {
    // Parameters, velocity and deflection are rounded first, so that both start from the same;
    // what is left is some ten roundings of 6e-8.
    const SINGLE: f64 = 1e-5;
    let single = |x: f64| f64::from(x as f32);
    check(64, inputs(), |(r, v, fraction, _)| {
        let r = Recipe {
            load: single(r.load),
            dynamic: single(r.dynamic),
            static_: single(r.static_),
            stribeck_velocity: single(r.stribeck_velocity),
            viscous: single(r.viscous),
            stiffness: single(r.stiffness),
            damping: single(r.damping),
            varying_velocity: single(r.varying_velocity),
            epsilon: single(r.epsilon),
            threshold: single(r.threshold),
            ..r
        };
        let v = single(v);
        for (double, twin) in specimens::<f64>(&r).iter().zip(&specimens::<f32>(&r)) {
            let form = &double.form;
            // Knots are rounded in single precision, and so is the small difference of two that
            // a straight line carries on for eight decades.
            if form.curve == Curve::Tabulated && v.abs() > 20.0 * r.stribeck_velocity {
                continue;
            }
            let z = single(fraction * full_deflection(double, v));
            let name = || format!("f32 {} at v = {v:e}, z = {z:e}", double.name());
            let (got, want) =
                (twin.subject.affine(v as f32, z as f32), double.subject.affine(v, z));
            // α has a condition of z_m/(z_m − z_b) ≤ 10 and more on top of it.
            let tolerance = if form.in_transition(v, z) { 100.0 * SINGLE } else { SINGLE };
            assert_affine(tolerance, form.terms(v, z), each(got, f64::from), want, name);
            let slopes = twin.subject.linearised(v as f32, z as f32);
            assert!(slopes.rate_by_velocity.is_finite() && slopes.force_by_velocity.is_finite());
            assert!(twin.subject.hold(v as f32, z as f32, 1e-3).mean_force.is_finite());
            let (got, want) = (twin.subject.limits(v as f32), double.subject.limits(v));
            for (got, want) in [
                (got.deflection, want.deflection),
                (got.force, want.force),
                (got.relaxation_rate, want.relaxation_rate),
            ] {
                let (got, want) = (f64::from(got.unwrap_or(0.0)), want.unwrap_or(0.0));
                // σ0/(σ1 + least slope) of an implicit bristle may be a difference.
                let difference = 2.0 * form.sigma1(v) * want / form.sigma0(v);
                let scale = want * (1.0 + if double.is_implicit() { difference } else { 0.0 });
                assert_within(tolerance, scale, got, want, name);
            }
            // The passivity threshold is all that could flip, by a rounding.
            for law in Law::ALL.into_iter().filter(|law| *law != Law::Passivity) {
                let claims = (twin.subject.model().obeys(law), double.subject.model().obeys(law));
                assert_eq!(claims.0, claims.1, "{law}: {}", name());
            }
        }
    });
}
