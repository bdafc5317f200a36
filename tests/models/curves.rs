//! Friction curves and regularisations: limits, bounds, switches and branches.

use bristle::curve::{Asymmetric, Coulomb, FrictionCurve};
use bristle::regularisation::{HyperbolicTangent, Regularisation, SquareRoot, Unregularised};
use bristle::{Bounds, Branch, Bristle, FrBd, Law, LuGre, Scalar, Sliding};
use bristle_specimens::closed_form::{Curve, Modulus, Table};
use bristle_specimens::recipe::{Recipe, decades, recipe, velocity};
use bristle_specimens::specimens::{
    coulomb, curves, kelvin_voigt, rational, regularisations, stribeck, table,
};
use bristle_specimens::{assert_within, check, root};
use proptest::prelude::*;

/// Some ten roundings; an exponent w has its own multiplied by w e^−w < 1.
const ROUNDING: f64 = 1e-14;

const INFINITY: f64 = f64::INFINITY;

#[test]
fn every_curve_is_its_closed_form() {
    check(1024, (recipe(), velocity()), |(r, v)| {
        for (curve, subject) in curves::<f64>(&r) {
            let want = curve.mu(&r, v);
            // The cubics of a table add up coefficients of either sign, as large as the knots'.
            let scale = if curve == Curve::Tabulated { want + 10.0 * r.dynamic } else { want };
            assert_within(ROUNDING, scale, subject.coefficient(v.into()), want, || {
                format!("{curve:?} at v = {v:e}")
            });
            assert!(subject.coefficient(v.into()) > 0.0);
            assert_eq!(subject.at(v), subject.coefficient(v.into()));
        }
    });
}

#[test]
fn an_exponential_that_no_longer_counts_leaves_exactly_the_rest() {
    let r = Recipe { viscous: 0.0, ..Recipe::TABLE_2 };
    for exponent in [0.7, 1.0, 2.0, 3.3] {
        let curve = stribeck::<f64>(&r, exponent);
        // (|v|/v_S)^δ = 40, and e^−40 = 4e-18.
        let v = r.stribeck_velocity * 40_f64.powf(1.0 / exponent);
        assert_eq!(curve.coefficient(v.into()), r.dynamic);
        assert_eq!(curve.coefficient_and_slope((-v).into()), (r.dynamic, 0.0));
    }
}

/// At some hundred neighbours of a number a function is its closed form to so many roundings, and
/// does not jump.
fn assert_smooth(at: f64, roundings: f64, pair: impl Fn(f64) -> (f64, f64)) {
    let mut previous = f64::NAN;
    for i in -400..=400 {
        let (got, want) = pair(at * (1.0 + f64::from(i) * f64::EPSILON));
        let tolerance = roundings * f64::EPSILON;
        assert_within(tolerance, want, got, want, || format!("neighbour {i} of {at}"));
        assert!(!((got - previous).abs() > 2.0 * tolerance * want), "neighbour {i} of {at}");
        previous = got;
    }
}

#[test]
fn the_stribeck_curve_has_no_seams_where_it_changes_method() {
    // Below w = 1e-3 a series, above an exponential, and nothing beyond a rounding of μ_d.
    for (static_, dynamic) in [(1.5, 1.0), (1.001, 1.0), (20.0, 0.01)] {
        let r = Recipe { static_, dynamic, ..Recipe::TABLE_2 };
        let drop = static_ - dynamic;
        let negligible = (4.0 * drop / (f64::EPSILON * dynamic)).ln();
        for exponent in [0.7, 1.0, 2.0, 3.3] {
            let curve = stribeck::<f64>(&r, exponent);
            for w in [1e-3, negligible] {
                let middle = r.stribeck_velocity * w.powf(1.0 / exponent);
                assert_smooth(middle, 4.0, |v| {
                    let want = Curve::Stribeck(exponent).mu(&r, v);
                    // A quarter of a rounding is cut off, and a few are made.
                    let (mu, slope) = curve.coefficient_and_slope(v.into());
                    let u = v / r.stribeck_velocity;
                    let steepness = exponent * u.powf(exponent - 1.0) / r.stribeck_velocity;
                    let want_slope = r.viscous - drop * (-u.powf(exponent)).exp() * steepness;
                    // The slope of what is cut off, besides roundings.
                    let cut = f64::EPSILON * dynamic * steepness;
                    let slack = ROUNDING * (r.viscous + drop * (-w).exp() * steepness) + cut;
                    assert!(
                        (slope - want_slope).abs() <= slack,
                        "δ = {exponent}, w = {w}: {slope}"
                    );
                    (mu, want)
                });
            }
        }
    }
}

#[test]
fn a_curve_without_its_viscous_part_lacks_only_that() {
    check(256, (recipe(), velocity()), |(r, v)| {
        for (curve, subject) in curves::<f64>(&r) {
            let viscous = subject.viscous_friction();
            assert_eq!(viscous, if r.viscous == 0.0 { 0.0 } else { curve.viscous(&r) });
            let dry = subject.without_viscous_friction();
            assert_eq!(dry.viscous_friction(), 0.0, "{curve:?}");
            let (whole, rest) = (subject.coefficient(v.into()), dry.coefficient(v.into()));
            assert_within(ROUNDING, whole, rest + viscous * v.abs(), whole, || {
                format!("{curve:?}")
            });
            assert!(dry.bounds(INFINITY).min > 0.0);
        }
    });
}

#[test]
fn two_curves_in_one_share_the_smaller_of_their_viscous_parts() {
    let r = Recipe::TABLE_2;
    let of = |viscous| Recipe { viscous, ..r };
    let same = Asymmetric { forward: stribeck::<f64>(&r, 2.0), backward: coulomb(&r) };
    assert_eq!(FrictionCurve::<f64>::viscous_friction(&same), r.viscous);
    let dry = FrictionCurve::<f64>::without_viscous_friction(&same);
    assert_eq!(dry, Asymmetric { forward: stribeck(&of(0.0), 2.0), backward: coulomb(&of(0.0)) });
    let different = Asymmetric { forward: stribeck::<f64>(&r, 2.0), backward: coulomb(&of(0.3)) };
    let common = r.viscous.min(0.3);
    assert_eq!(FrictionCurve::<f64>::viscous_friction(&different), common);
    let dry = FrictionCurve::<f64>::without_viscous_friction(&different);
    assert_eq!(FrictionCurve::<f64>::viscous_friction(&dry), 0.0);
    for v in [-3.0, -0.1, 0.1, 3.0] {
        let (whole, rest) = (different.at(v), dry.at(v));
        assert_within(ROUNDING, whole, rest + common * f64::abs(v), whole, || format!("{v}"));
    }
}

#[test]
fn lugres_force_hardly_changes_where_the_two_directions_hardly_differ() {
    // σ1 z' = 0 in steady sliding at 1 m/s: F/p = μ_d + σ2, all of it inside the curve or σ2
    // outside of it; from z = 0 only what is outside of the curve adds to σ1.
    let r = Recipe::TABLE_2;
    let of = |viscous| coulomb::<f64>(&Recipe { viscous, ..r });
    let force = |backward| {
        let curve = Asymmetric { forward: of(0.2), backward: of(backward) };
        LuGre::classical(curve, kelvin_voigt(1e4, 1.0)).coefficient(1.0, 0.0)
    };
    assert_eq!(force(0.2), 1.2);
    assert_within(1e-11, 1.0, force(0.2 + 1e-12), 1.2, || "σ2 hardly larger backwards".into());
    assert_within(1e-11, 1.0, force(0.2 - 1e-12), 1.2, || "σ2 hardly smaller backwards".into());
}

#[test]
fn a_branch_gives_speed_and_direction() {
    use Branch::{Backward, Forward, Free};
    for (branch, v, want) in [
        (Free, 0.3, (0.3, 1.0)),
        (Free, -0.3, (0.3, -1.0)),
        (Free, 0.0, (0.0, 0.0)),
        (Free, -0.0, (0.0, 0.0)),
        // So small that its square is zero.
        (Free, 1e-300, (1e-300, 1.0)),
        (Free, -f64::MIN_POSITIVE, (f64::MIN_POSITIVE, -1.0)),
        (Free, -INFINITY, (INFINITY, -1.0)),
        (Forward, 0.3, (0.3, 1.0)),
        (Forward, -0.3, (-0.3, 1.0)),
        (Forward, 0.0, (0.0, 1.0)),
        (Backward, -0.3, (0.3, -1.0)),
        (Backward, 0.3, (-0.3, -1.0)),
        (Backward, 0.0, (0.0, -1.0)),
    ] {
        let sliding = branch.of(v);
        assert_eq!(sliding.velocity().to_bits(), f64::to_bits(v));
        assert_eq!((sliding.speed(), sliding.direction()), want, "{branch:?} {v}");
        assert!(branch.of(f64::NAN).speed().is_nan(), "{branch:?}");
    }
    for v in [1e-300, -1e-300, 0.0, -0.0, f64::NAN] {
        let want = if v > 0.0 {
            Forward
        } else if v < 0.0 {
            Backward
        } else {
            Free
        };
        assert_eq!((Branch::towards(v), Branch::towards(-v)), (want, want.reversed()), "{v}");
    }
    assert!(Free.of(f64::NAN).direction().is_nan());
    assert_eq!((Sliding::from(-0.3), Branch::default()), (Free.of(-0.3), Free));
}

#[test]
fn even_curves_do_not_know_the_direction_and_others_say_so() {
    check(256, (recipe(), velocity()), |(r, v)| {
        for (curve, subject) in curves::<f64>(&r) {
            assert_eq!(subject.is_even(), curve != Curve::Asymmetric);
            if subject.is_even() {
                let ((mu, slope), mirrored) = (
                    subject.coefficient_and_slope(v.into()),
                    subject.coefficient_and_slope((-v).into()),
                );
                assert_eq!(mirrored, (mu, -slope), "{curve:?} at {v:e}");
            }
        }
    });
}

#[test]
fn an_asymmetric_curve_asks_the_curve_of_the_direction() {
    let (forward, backward) = (stribeck::<f64>(&Recipe::TABLE_2, 2.0), rational(&Recipe::TABLE_2));
    let curve = Asymmetric { forward, backward };
    for v in [-2.0, -4e-3, -1e-9, 0.0, 1e-9, 4e-3, 2.0] {
        for (branch, of_direction) in [
            (Branch::Forward, forward.coefficient_and_slope(Branch::Forward.of(v))),
            (Branch::Backward, backward.coefficient_and_slope(Branch::Backward.of(v))),
        ] {
            assert_eq!(curve.coefficient_and_slope(branch.of(v)), of_direction);
            assert_eq!(curve.coefficient(branch.of(v)), of_direction.0);
        }
        let free = if v < 0.0 { backward.at(v) } else { forward.at(v) };
        assert_eq!(curve.at(v), free, "{v}");
    }
}

#[test]
fn curves_continue_smoothly_to_speeds_of_the_wrong_sign() {
    check(256, (recipe(), 0.0..0.2_f64), |(r, u)| {
        // On the forward branch at v = −u v_S, by the formula of the positive speeds; evenly
        // where |v|^δ has no other continuation.
        let s = -u * r.stribeck_velocity;
        let drop = r.static_ - r.dynamic;
        for (curve, subject) in curves::<f64>(&r) {
            let decay = match curve {
                Curve::Stribeck(1.0) => u.exp(),
                Curve::Stribeck(exponent) => (-u.powf(exponent)).exp(),
                Curve::Asymmetric => (-u * u).exp(),
                Curve::Rational => 1.0 / (1.0 + u * u),
                Curve::Coulomb => 0.0,
                Curve::Tabulated | Curve::Function => continue,
            };
            let want = r.dynamic + drop * decay + r.viscous * s;
            let scale = r.dynamic + drop * decay + r.viscous * s.abs();
            let got = subject.coefficient(Branch::Forward.of(s));
            assert_within(ROUNDING, scale, got, want, || format!("{curve:?} at {s:e}"));
            if curve != Curve::Asymmetric {
                assert_eq!(subject.coefficient(Branch::Backward.of(-s)), got, "{curve:?}");
            }
        }
    });
}

#[test]
fn a_table_continues_its_first_cubic_to_speeds_of_the_wrong_sign() {
    let knots = [(0.0, 0.42), (0.01, 0.35), (0.1, 0.30), (1.0, 0.33)];
    let curve = table::<f64, 4>(knots);
    // Lagrange extrapolation through four points of the first interval is that cubic itself.
    let at = [0.0, 0.003, 0.006, 0.009];
    for s in [-0.001, -0.004] {
        let want: f64 = at
            .iter()
            .map(|&a| {
                let weight: f64 =
                    at.iter().filter(|&&b| b != a).map(|b| (s - b) / (a - b)).product();
                weight * curve.coefficient(a.into())
            })
            .sum();
        // Weights up to 25 multiply the roundings.
        assert_within(1e-14, 25.0, curve.coefficient(Branch::Forward.of(s)), want, || {
            format!("{s}")
        });
        assert_eq!(
            curve.coefficient(Branch::Backward.of(-s)),
            curve.coefficient(Branch::Forward.of(s))
        );
    }
}

/// Extreme of a function of the speed on ever finer grids about the best sample; `sign` +1 for the
/// largest, −1 for the smallest value. Kinks can be as close together as they like and are sampled
/// by themselves.
fn extreme(f: impl Fn(f64) -> f64, fastest: f64, kinks: &[f64], sign: f64) -> f64 {
    let smallest = 1e-12 * fastest;
    let mut speeds = vec![0.0, fastest];
    speeds.extend((0..600).map(|i| smallest * (fastest / smallest).powf(f64::from(i) / 600.0)));
    speeds.extend(kinks.iter().filter(|&&kink| kink < fastest));
    let mut best = f64::NEG_INFINITY;
    for _ in 0..8 {
        speeds.sort_by(f64::total_cmp);
        let values: Vec<f64> = speeds.iter().map(|&s| sign * f(s)).collect();
        let at = (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap();
        let (low, high) = (speeds[at.saturating_sub(1)], speeds[(at + 1).min(speeds.len() - 1)]);
        best = best.max(values[at]);
        speeds = (0..=40).map(|i| low + (high - low) * f64::from(i) / 40.0).collect();
    }
    sign * best
}

#[test]
fn bounds_are_valid_and_tight() {
    check(64, (recipe(), decades(1e-3, 1e4)), |(r, reach)| {
        let fastest = reach * r.stribeck_velocity;
        for (curve, subject) in curves::<f64>(&r) {
            // Those of a closure are taken on trust.
            if curve == Curve::Function {
                continue;
            }
            let bounds = subject.bounds(fastest);
            let both = |v: f64| [v, -v].map(|v| curve.mu(&r, v));
            let largest = |s: f64| both(s).into_iter().fold(0.0, f64::max);
            let smallest = |s: f64| both(s).into_iter().fold(INFINITY, f64::min);
            let kinks = r.knots().map(|(speed, _)| speed);
            let name = || format!("{curve:?} up to {fastest:e}");
            // A flat extreme is found to all digits of its value from half of those of its place.
            let found = extreme(smallest, fastest, &kinks, -1.0);
            assert_within(1e-12, found, bounds.min, found, || format!("min of {}", name()));
            let found = extreme(largest, fastest, &kinks, 1.0);
            assert_within(1e-12, found, bounds.max, found, || format!("max of {}", name()));
        }
    });
}

#[test]
fn bounds_over_every_velocity_are_the_limits() {
    check(128, recipe(), |r| {
        for (curve, subject) in curves::<f64>(&r) {
            let bounds = subject.bounds(INFINITY);
            let rises = match curve {
                Curve::Tabulated => Table(r.knots()).slope(4) > 0.0,
                Curve::Function => false,
                _ => r.viscous > 0.0,
            };
            // Fast enough to be past every turn, which lies where e^−(v/v_S)^δ still counts.
            let fast = subject.bounds(1e7 * r.stribeck_velocity);
            assert_eq!(bounds.max == INFINITY, rises, "{curve:?}: {bounds:?}");
            if !rises {
                assert_eq!(bounds.max, fast.max, "{curve:?}");
            }
            // The rational curve still has 1e-14 of its drop there.
            let scale = bounds.min + 1e-2 * (r.static_ - r.dynamic);
            assert_within(1e-12, scale, bounds.min, fast.min, || format!("{curve:?}"));
        }
    });
}

#[test]
fn a_flat_start_with_viscosity_has_its_maximum_just_above_rest() {
    // The slope is zero where the decay is as steep as σ2 v_S/(μ_s − μ_d): once before the place
    // where it is steepest (u^δ = (δ−1)/δ, and 1/√3 for the rational curve), and once after.
    for exponent in [Some(2.0), Some(1.5), Some(3.3), Some(8.0), None] {
        let curve = exponent.map_or(Curve::Rational, Curve::Stribeck);
        let steepness = |u: f64| match exponent {
            Some(d) if u > 0.0 => d * u.powf(d - 1.0) * (-u.powf(d)).exp(),
            _ => 2.0 * u / (1.0 + u * u).powi(2),
        };
        let of = |d: f64| ((d - 1.0) / d).powf(1.0 / d);
        let steepest = exponent.map_or(3.0_f64.sqrt().recip(), of);
        // Far below the steepest fall, and hardly below it.
        for share in [0.1, 0.6, 0.98] {
            let balance = share * steepness(steepest);
            let drop = Recipe::TABLE_2.static_ - Recipe::TABLE_2.dynamic;
            let viscous = balance * drop / Recipe::TABLE_2.stribeck_velocity;
            let r = Recipe { viscous, ..Recipe::TABLE_2 };
            let bounds = |fastest: f64| match exponent {
                Some(exponent) => stribeck::<f64>(&r, exponent).bounds(fastest),
                None => rational::<f64>(&r).bounds(fastest),
            };
            let summit = root(0.0, steepest, |u| steepness(u) - balance) * r.stribeck_velocity;
            let valley = root(steepest, 20.0, |u| balance - steepness(u)) * r.stribeck_velocity;
            let mu = |v: f64| curve.mu(&r, v);
            assert!(mu(summit) > r.static_ && mu(valley) < mu(summit));
            let lowest = mu(valley).min(r.static_);
            for (fastest, min, max) in [
                (0.5 * summit, r.static_, mu(0.5 * summit)),
                (summit * 1.001, r.static_, mu(summit)),
                (valley * 1.001, lowest, mu(summit)),
                (100.0, lowest, mu(100.0)),
            ] {
                let got = bounds(fastest);
                let name = |end| move || format!("{end} of {curve:?}, {share}, up to {fastest}");
                assert_within(ROUNDING, min, got.min, min, name("min"));
                assert_within(ROUNDING, max, got.max, max, name("max"));
            }
        }
    }
}

#[test]
fn ranges_unite_and_know_a_constant() {
    let a = Bounds { min: 1.0, max: 2.0 };
    assert_eq!(a.union(Bounds { min: 0.5, max: 1.5 }), Bounds { min: 0.5, max: 2.0 });
    assert_eq!(a.union(Bounds::constant(3.0)), Bounds { min: 1.0, max: 3.0 });
    assert!(Bounds::constant(0.3).is_constant() && !a.is_constant());
}

/// Tables of five to many knots at random distances and heights.
fn knots() -> impl Strategy<Value = [(f64, f64); 6]> {
    (prop::array::uniform6(decades(1e-4, 1e1)), prop::array::uniform6(0.1..2.0)).prop_map(
        |(widths, coefficients)| {
            let mut speed = 0.0;
            std::array::from_fn(|i| {
                speed += if i == 0 { 0.0 } else { widths[i] };
                (speed, coefficients[i])
            })
        },
    )
}

#[test]
fn a_table_passes_through_its_knots_and_is_monotone_between_them() {
    check(256, knots(), |knots| {
        let curve = table::<f64, 6>(knots);
        for (i, &(speed, mu)) in knots.iter().enumerate() {
            assert_eq!(curve.coefficient(speed.into()), mu);
            assert_eq!(curve.coefficient((-speed).into()), mu);
            let Some(&(next, to)) = knots.get(i + 1) else { continue };
            let mut previous = mu;
            for k in 1..=50 {
                let s = speed + (next - speed) * f64::from(k) / 50.0;
                let value = curve.coefficient(s.into());
                // A cubic that is level somewhere rounds about its level there.
                let slack = 16.0 * f64::EPSILON * (mu + to);
                assert!((value - previous) * (to - mu).signum() >= -slack, "at {s}");
                assert!(value >= mu.min(to) - slack && value <= mu.max(to) + slack);
                previous = value;
                // The sign of the slope agrees, up to roundings of the steepest slope, which is
                // three secants, and of the place.
                let slope = curve.coefficient_and_slope(s.into()).1;
                let width = next - speed;
                let secant = (to - mu).abs() / width;
                let slack = (1e-13 + 20.0 * f64::EPSILON * next / width) * secant;
                assert!(k == 50 || slope * (to - mu).signum() >= -slack, "at {s}");
            }
        }
    });
}

#[test]
fn a_table_is_continuously_differentiable_at_its_knots_and_beyond() {
    check(256, knots(), |knots| {
        let curve = table::<f64, 6>(knots);
        for (i, &(speed, _)) in knots.iter().enumerate().skip(1) {
            let (below, above) = (speed * (1.0 - f64::EPSILON), speed);
            let (left, right) = (
                curve.coefficient_and_slope(below.into()),
                curve.coefficient_and_slope(above.into()),
            );
            let steepest = Table(knots).slope_terms(below) + Table(knots).slope_terms(above);
            // Half a rounding of the speed away, the value differs by that times the slope and
            // by a few roundings, and the slope by the curvature, at most ten slopes per width.
            let width = speed - knots[i - 1].0;
            let step = speed * f64::EPSILON;
            let name = || format!("knot {i} at {speed:e}");
            assert_within(1.0, 16.0 * f64::EPSILON + 2.0 * step * steepest, left.0, right.0, name);
            let slack = (1e-13 + 10.0 * step / width) * steepest;
            assert_within(1.0, slack, left.1, right.1, name);
            assert_within(1e-12, steepest, right.1, Table(knots).slope(i), name);
        }
        // Straight on, rising or level.
        let (last, mu) = knots[5];
        let slope = curve.coefficient_and_slope(last.into()).1;
        assert!(slope >= 0.0);
        for s in [last, 2.0 * last, 1e6 * last] {
            let (value, there) = curve.coefficient_and_slope(s.into());
            assert_eq!(there, slope);
            let want = mu + slope * (s - last);
            assert_within(4.0 * f64::EPSILON, want, value, want, || format!("beyond at {s:e}"));
        }
    });
}

#[test]
fn two_knots_make_a_line_or_an_arc_that_ends_level() {
    let rising = table::<f64, 2>([(0.0, 0.2), (2.0, 0.4)]);
    for s in [0.0, 0.5, 1.0, 2.0, 7.0] {
        assert_within(ROUNDING, 1.0, rising.coefficient(s.into()), 0.2 + 0.1 * s, || {
            format!("{s}")
        });
    }
    // Falling: slope −0.1 at rest, zero at the end, t = s/2:
    // 0.4 − 0.2t at first order, and the Hermite cubic 0.4 − 0.2 (t + t² − t³).
    let falling = table::<f64, 2>([(0.0, 0.4), (2.0, 0.2)]);
    for t in [0.0_f64, 0.25, 0.5, 1.0] {
        let want = 0.4 - 0.2 * (t + t * t - t * t * t);
        assert_within(ROUNDING, 1.0, falling.coefficient((2.0 * t).into()), want, || {
            format!("{t}")
        });
    }
    assert_eq!(falling.coefficient_and_slope(9.0.into()), (0.2, 0.0));
    assert_eq!(falling.bounds(INFINITY), Bounds { min: 0.2, max: 0.4 });
}

#[test]
fn every_regularisation_is_its_closed_form() {
    check(1024, (recipe(), velocity()), |(r, v)| {
        for (modulus, subject) in regularisations::<f64>(&r) {
            let name = || format!("{modulus:?} at v = {v:e}");
            let all =
                |v: f64| (subject.speed_and_slope(v.into()), subject.sign_and_slope(v.into()));
            let ((speed, slope), (sign, sign_slope)) = all(v);
            let want = (modulus.speed(&r, v), modulus.sign(&r, v));
            assert_within(ROUNDING, want.0, speed, want.0, name);
            assert_within(ROUNDING, want.1.abs(), sign, want.1, name);
            let at_rest = match modulus {
                Modulus::Exact => 0.0,
                Modulus::SquareRoot => r.epsilon.sqrt(),
                Modulus::HyperbolicTangent => r.threshold,
            };
            assert_within(ROUNDING, at_rest, subject.speed_at_rest(), at_rest, name);
            assert_within(ROUNDING, at_rest, subject.speed(0.0.into()), at_rest, name);
            // The speed is larger, and its sign smaller, up to half a rounding of a root, a
            // quotient, a tanh.
            let up = 1.0 + 2.0 * f64::EPSILON;
            assert!(speed * up >= v.abs(), "{}", name());
            assert!(speed <= (v.abs() + subject.speed_at_rest()) * up, "{}", name());
            assert!(sign.abs() <= up && slope.abs() <= up && sign_slope >= 0.0, "{}", name());
            assert_within(ROUNDING, v.abs(), sign * speed, v, name);
            // Even and odd, to the last bit; alone as with its slope.
            assert_eq!(all(-v), ((speed, -slope), (-sign, sign_slope)), "{}", name());
            let alone = (subject.speed((-v).into()), subject.sign((-v).into()));
            assert_eq!(alone, (subject.speed(v.into()), -subject.sign(v.into())), "{}", name());
            assert_within(ROUNDING, want.1.abs(), alone.1, -want.1, name);
        }
    });
}

#[test]
fn only_the_exact_modulus_knows_a_branch() {
    let r = Recipe::TABLE_2;
    for (modulus, subject) in regularisations::<f64>(&r) {
        let (locked, free) = (Branch::Forward.of(-1e-6), Branch::Free.of(-1e-6));
        if modulus == Modulus::Exact {
            assert_eq!((subject.speed(locked), subject.sign(locked)), (-1e-6, 1.0));
            assert_eq!(subject.speed_and_slope(locked), (-1e-6, 1.0));
            assert_eq!(subject.sign_and_slope(Branch::Free.of(0.0)), (0.0, 0.0));
        } else {
            // Smooth as they are.
            assert_eq!(subject.speed_and_slope(locked), subject.speed_and_slope(free));
            assert_eq!(subject.sign_and_slope(locked), subject.sign_and_slope(free));
        }
    }
    assert_eq!(Regularisation::<f64>::speed_at_rest(&Unregularised), 0.0);
}

#[test]
fn the_hyperbolic_tangent_has_no_seams_where_its_series_ends() {
    let tangent = HyperbolicTangent::new(1.0).unwrap();
    // u² = 1e-8 for the speed: 1 + u²/3 − u⁴/45, next term u⁶ 2/945 = 2e-27.
    let series = |u: f64| 1.0 + u * u / 3.0 - u.powi(4) / 45.0;
    assert_smooth(1e-4, 4.0, |u| (tangent.speed(u.into()), series(u)));
    // u² = 0.1225 for its slope: coth u − u/sinh² u cancels 2.9 and 2.7 to 0.23 there: thirty
    // roundings.
    let slope = |u: f64| 1.0 / u.tanh() - u / u.sinh().powi(2);
    assert_smooth(0.35, 60.0, |u| (tangent.speed_and_slope(u.into()).1, slope(u)));
}

#[test]
fn a_regularisation_of_ones_own_needs_three_methods() {
    /// √(v² + ε) by the required methods alone.
    #[derive(Debug, Clone)]
    struct Bare(f64);
    impl Regularisation<f64> for Bare {
        fn speed(&self, sliding: Sliding<f64>) -> f64 {
            (sliding.velocity().powi(2) + self.0).sqrt()
        }
        fn speed_and_slope(&self, sliding: Sliding<f64>) -> (f64, f64) {
            let speed = self.speed(sliding);
            (speed, sliding.velocity() / speed)
        }
        fn speed_at_rest(&self) -> f64 {
            self.0.sqrt()
        }
    }
    let (bare, own) = (Bare(1e-4), SquareRoot::new(1e-4).unwrap());
    for v in [-3.0, -1e-2, 0.0, 1e-5, 2e-3, 0.7] {
        let ((sign, slope), want) = (bare.sign_and_slope(v.into()), own.sign_and_slope(v.into()));
        assert_within(ROUNDING, 1.0, sign, want.0, || format!("{v}"));
        assert_within(ROUNDING, 1.0, bare.sign(v.into()), own.sign(v.into()), || format!("{v}"));
        // (1 − sgn²)/|v|_ε cancels.
        assert_within(ROUNDING, 1.0 / own.speed(v.into()), slope, want.1, || format!("{v}"));
    }
}

#[test]
fn a_curve_of_ones_own_needs_two_methods_and_claims_nothing() {
    /// μ = 0.1 + |v|, which the library does not know to have a viscous part.
    #[derive(Debug, Clone)]
    struct Own;
    impl<T: Scalar> FrictionCurve<T> for Own {
        fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
            (bristle_specimens::lit::<T>(0.1) + sliding.speed(), sliding.direction())
        }
        fn bounds(&self, fastest: T) -> Bounds<T> {
            Bounds {
                min: bristle_specimens::lit(0.1),
                max: bristle_specimens::lit::<T>(0.1) + fastest,
            }
        }
    }
    assert_eq!(FrictionCurve::<f64>::viscous_friction(&Own), 0.0);
    assert!(!FrictionCurve::<f64>::is_even(&Own));
    let model = FrBd::new(Own, kelvin_voigt(1e4, 1.0));
    assert!(!Bristle::<f64>::obeys(&model, Law::OddSymmetry));
    let dry = FrictionCurve::<f64>::without_viscous_friction(&Own);
    assert_eq!(dry.coefficient(Sliding::from(-2.0)), 2.1);
    let both = Asymmetric { forward: Own, backward: coulomb::<f64>(&Recipe::TABLE_2) };
    assert_eq!(both.bounds(2.0), Bounds { min: 0.1, max: 2.1 });
    let _: Coulomb<f64> = both.backward;
}
