//! Slopes where dual numbers have none: the hyperbolic tangent near rest in itself, at v = 0, where
//! only one-sided derivatives exist, against closed forms; and every model once in `f32`. All other
//! derivatives are in development/all/tests/dual.

use bristle::curve::FrictionCurve;
use bristle::regularisation::Regularisation;
use bristle::{Affine, Branch, Bristle, Law};
use bristle_specimens::closed_form::{Curve, Modulus, Table};
use bristle_specimens::recipe::{Recipe, fraction, nonzero_velocity, recipe};
use bristle_specimens::specimens::{curves, regularisations, specimens};
use bristle_specimens::{assert_affine, assert_within, check, each};

/// A few roundings of about thirty operations, 1e-14, which powers multiply by δ|ln u| ≤ 3.3·32.
const ROUNDING: f64 = 1e-12;

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
            let z = fraction * specimen.full_deflection(0.0);
            let model = specimen.subject.model();
            let [forward, backward, free] = [Branch::Forward, Branch::Backward, Branch::Free]
                .map(|branch| model.affine_and_slopes(branch.of(0.0).into(), z).1);
            let middle = |of: fn(Affine<f64>) -> f64| 0.5 * (of(forward) + of(backward));
            let middle = Affine {
                relaxation: middle(|a| a.relaxation),
                drive: middle(|a| a.drive),
                stiffness: middle(|a| a.stiffness),
                damping: middle(|a| a.damping),
            };
            let terms = form.slope_terms(0.0, z);
            assert_affine(ROUNDING, terms, free, middle, || specimen.name());
        }
    });
}

#[test]
fn everything_runs_in_single_precision() {
    // Parameters, velocity and deflection are rounded first, so that both start from the same;
    // what is left is some ten roundings of 6e-8.
    const SINGLE: f64 = 1e-5;
    let single = |x: f64| f64::from(x as f32);
    check(64, (recipe(), nonzero_velocity(), -1.2..1.2_f64), |(r, v, fraction)| {
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
            let z = single(fraction * double.full_deflection(v));
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
