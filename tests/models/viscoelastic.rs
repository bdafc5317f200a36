//! Viscoelastic bristles: each law written once and run over every one of them, the exact step
//! against eigenvectors of ninety digits and brute force, and the limits in which one bristle
//! becomes another.

use bristle::curve::{Coulomb, CoulombParameters};
use bristle::rheology::{
    Deflection, GeneralisedMaxwell, GeneralisedMaxwellParameters, HeldWeights, Maxwell, MaxwellArm,
    MaxwellParameters, Rheology, ZenerParameters,
};
use bristle::{Bristle, FrBd, Law, ParameterError, Rule, Scalar};
use bristle_specimens::recipe::{Recipe, decades, recipe, velocity};
use bristle_specimens::specimens::{kelvin_voigt, spring, stribeck};
use bristle_specimens::viscoelastic::{
    Change, arms, case, every, maxwell, own_arms, parts, specimens, stretches, varying, zener,
};
use bristle_specimens::{assert_within, check, lit};
use nalgebra::{DMatrix, Matrix3, SVector, Vector2, Vector3};
use proptest::prelude::*;

/// A few dozen roundings relative to the sum of the absolute terms.
const ROUNDING: f64 = 1e-12;

#[test]
fn every_spring_follows_the_common_rate_and_decays_on_its_own() {
    every(64, |specimen, v, x| {
        let (form, name) = (&specimen.form, || specimen.name());
        let (rate, terms) = form.common_rate(v, x);
        for ((got, a), x) in specimen.subject.rate(v, x).iter().zip(form.decay(v)).zip(x) {
            assert_within(ROUNDING, terms + a * x.abs(), *got, rate - a * x, name);
        }
        let (p, (size, sum)) = (form.recipe.load, form.carried(x));
        let scale = p * (size + form.damping(v) * terms);
        let force = specimen.subject.force(v, x);
        assert_within(ROUNDING, scale, force, p * (sum + form.damping(v) * rate), name);
        // The secant law, v_s = (|v|_ε/μ) F/p.
        let compliance = form.speed(v) / form.mu(v);
        let scale = v.abs() + terms + compliance * scale / p;
        assert_within(ROUNDING, scale, v - rate, compliance * force / p, name);
    });
}

#[test]
fn surface_and_dashpots_dissipate_each_for_itself_in_every_state() {
    every(64, |specimen, v, x| {
        let (form, subject, name) = (&specimen.form, &specimen.subject, || specimen.name());
        let p = form.recipe.load;
        let (common, terms) = form.common_rate(v, x);
        let force = subject.force(v, x);
        // p Σ Kᵢ xᵢ yᵢ
        let sum = |y: &[f64]| {
            let each = form.arms.iter().zip(x.iter().zip(y));
            p * each.map(|(arm, (x, y))| arm.0 * x * y).sum::<f64>()
        };
        let decayed: Vec<f64> = form.decay(v).iter().zip(x).map(|(a, x)| a * x).collect();
        let (inner, released) = (sum(&decayed), sum(&subject.rate(v, x)));
        let beside = p * form.damping(v) * common * common;
        let surface = force * (v - common);
        let force_terms = p * (form.carried(x).0 + form.damping(v) * terms);
        let scale =
            force_terms * (v.abs() + 2.0 * terms) + inner + p * form.damping(v) * terms * terms;
        let (want, power) = (surface + beside + inner, subject.dissipated_power(v, x));
        assert_within(ROUNDING, scale, force * v - released, want, name);
        assert_within(ROUNDING, scale, power, want, name);
        assert!(surface >= -ROUNDING * scale && inner >= 0.0 && beside >= 0.0);
        assert!(power >= -ROUNDING * scale, "{}", name());
        assert_within(ROUNDING, 0.5 * sum(x), subject.stored_energy(x), 0.5 * sum(x), name);
    });
}

#[test]
fn a_bristle_claims_what_its_kind_can_keep() {
    every(8, |specimen, _, x| {
        let (form, subject) = (&specimen.form, &specimen.subject);
        let single = x.len() == 1;
        for (law, claim) in [
            (Law::Secant, true),
            (Law::Passivity, true),
            (Law::SteadySliding, !form.creeps()),
            (Law::BoundedForce, single),
            (Law::BoundedDeflection, single && form.recipe.viscous >= 0.0),
            (Law::NoDrift, false),
            (
                Law::OddSymmetry,
                form.series == Change::Constant && form.beside_law == Change::Constant,
            ),
        ] {
            assert_eq!(subject.obeys(law), claim, "{} {law}", specimen.name());
        }
        let limits = subject.limits(1.0);
        assert_eq!(limits.deflection.is_some(), single);
        assert_eq!(limits.force.is_some(), single || form.is_linear());
    });
}

#[test]
fn steady_sliding_is_on_the_curve_with_a_static_spring_and_creeps_without() {
    every(64, |specimen, v, _| {
        let (form, subject) = (&specimen.form, &specimen.subject);
        let (p, mu, speed) = (form.recipe.load, form.mu(v), form.speed(v));
        let dashpots: f64 = form.damping(v)
            + form.arms.iter().zip(form.decay(v)).map(|(arm, a)| arm.0 / a).sum::<f64>();
        let resistance = speed / mu + if form.creeps() { 1.0 / dashpots } else { 0.0 };
        let want = if v == 0.0 { 0.0 } else { p * v / resistance };
        let name = || format!("{} at {v:e}", specimen.name());
        let x = subject.stationary(v);
        let scale = want.abs() + p * form.carried(&x).0;
        assert_within(ROUNDING, scale, subject.stationary_force(v), want, name);
        for (rate, (x, a)) in subject.rate(v, &x).iter().zip(x.iter().zip(form.decay(v))) {
            let scale = form.common_rate(v, &subject.stationary(v)).1 + a * x.abs();
            assert_within(ROUNDING, scale, *rate, 0.0, name);
        }
    });
}

#[test]
fn no_eigenvalue_exceeds_the_relaxation_limit() {
    every(32, |specimen, v, x| {
        let form = &specimen.form;
        let share = form.speed(v) / (form.mu(v) + form.damping(v) * form.speed(v));
        // The matrix scaled by the roots of the stiffnesses is symmetric.
        let decay = form.decay(v);
        let n = x.len();
        let matrix = DMatrix::from_fn(n, n, |i, j| {
            let coupling = share * (form.arms[i].0 * form.arms[j].0).sqrt();
            coupling + if i == j { decay[i] } else { 0.0 }
        });
        let fastest = matrix.symmetric_eigenvalues().max();
        for limits in [specimen.subject.limits(v), specimen.subject.limits(f64::INFINITY)] {
            let holds = limits.relaxation_rate.is_none_or(|limit| fastest <= limit * (1.0 + 1e-9));
            assert!(holds, "{}: {fastest:e} beyond {limits:?}", specimen.name());
        }
        let limit = specimen.subject.limits(v).relaxation_rate;
        assert_eq!(limit.is_some(), form.scale == 1.0, "{}: limit at {v:e}", specimen.name());
    });
}

#[test]
fn a_run_from_rest_keeps_its_force_within_the_curve() {
    let chain = prop::collection::vec((-1.0..=1.0_f64, decades(1e-4, 1e2)), 12);
    check(64, (recipe(), parts(), decades(1e-6, 1e1), chain), |(r, p, fastest, chain)| {
        for specimen in specimens::<f64>(&r, &p) {
            let Some(limit) = specimen.subject.limits(fastest).force else { continue };
            let form = &specimen.form;
            // Lengths of step about the time in which the stiffest spring breaks away.
            let unit = r.static_ / form.arms.iter().map(|arm| arm.0).fold(0.0, f64::max) / fastest;
            let mut x = vec![0.0; form.arms.len()];
            for (fraction, length) in &chain {
                let v = fraction * fastest;
                let (next, end, mean) = specimen.subject.hold(v, &x, length * unit);
                let start = specimen.subject.force(v, &x);
                for force in [start, end, mean] {
                    assert!(
                        force.abs() <= limit * (1.0 + ROUNDING),
                        "{}: {force:e} beyond {limit:e}",
                        specimen.name()
                    );
                }
                x = next;
            }
        }
    });
}

/// Decay rates; row; state; length and drive; end; mean. By mpmath: eigenvectors of the symmetric
/// matrix (`eigsy`) with 90 digits, then φ functions. In the last two a spring of a millionth
/// stands between two whose terms in the secular equation cancel to a millionth: roots alone would
/// leave modes that are orthogonal to ten digits.
const STEPS: [&str; 13] = [
    "0 5; 20 40; 1e-5 -2e-5; 0.001 0.02; 2.9992885059234147e-5 4.223710353590319e-8; \
     2.009656475899677e-5 -9.870408860351986e-6",
    "0 5; 20 40; 1e-5 -2e-5; 0.3 0.02; 0.0005749329182546163 0.00019577837361051521; \
     0.0004403051207654291 0.00023276969642940077",
    "0 5; 20 40; 1e-5 -2e-5; 10000000000 0.02; 0.001 -4.1947820138042097e-94; \
     0.00099999999995625 1.94e-14",
    "0 5; 20 40; 1e-5 -2e-5; 1e-14 0.02; 1.0000000000206001e-5 -1.9999999999793e-5; \
     1.0000000000103e-5 -1.99999999998965e-5",
    "0 1000000; 1e-6 2e-6; 1e-5 3e-6; 3 1e-6; 1.2999965500037501e-5 9.999870000335e-13; \
     1.1499983500007125e-5 1.9999881666835e-12",
    "0 1e-6; 100000 100000; 1e-5 -1e-5; 10 0.5; 1.2499962500106251e-5 -7.499962500068751e-6; \
     1.249998000004375e-5 -7.499982500006251e-6",
    "0 1e-6; 100000 100000; 1e-5 -1e-5; 1000000 0; 6.06530659714908e-6 \
     -6.0653065971187535e-6; 7.869386805771516e-6 -7.86938680573217e-6",
    "0 0 3; 1 2 4; 0.001 -0.002 0.003; 0.7 0.1; 0.021788376646180135 0.018788376646180136 \
     0.006746464025902023; 0.014613844377832879 0.01161384437783288 0.00811519648584672",
    "2 2 3; 1 2 4; 0.001 -0.002 0.003; 0.7 0.1; 0.012439757734023536 0.011699966842198716 \
     0.00939232921323102; 0.010078983853371732 0.008464548776103746 0.009122859959768068",
    "0 0.001 1 1000 1000000; 1000 0.001 1000000 1 1e-6; 0.001 0.001 -0.001 0.001 -0.001; 1 1; \
     0.001998002494346018 0.0019960049931820483 -9.980034923475198e-7 -9.970074798811087e-10 \
     -9.970064848636617e-13; 0.001998500163635491 0.001997501163969606 -9.99502161634492e-7 \
     1.998003491353498e-6 -1.997504656975527e-12",
    "1000000 0 0.001 1000 1; 1e-6 1000 0.001 1 1000000; -0.001 0.001 0.001 0.001 -0.001; 1000 \
     1; -3.675111947696237e-13 0.0013678787057805756 0.0003680630748928807 \
     -3.6751156154726334e-10 -3.6787870596494443e-7; -6.321212938519133e-13 \
     0.0016317520464512439 0.0009998156308876948 1.367879073292137e-9 -6.317534155134595e-7",
    "0 1 2; 1000000 1e-6 1000000; 1e-5 -20 3e-5; 1 0.02; -3.6624658540467775e-6 \
     -7.3575924948684275 3.6824695291715807e-6; -6.307506003503799e-6 -12.642421167597426 \
     6.327532308390821e-6",
    "0 1 2; 1000000000 1e-9 1000000000; 1e-5 -20000 3e-5; 2 0; -1.3533528289827448e-6 \
     -2706.705664732254 1.3533528303360976e-6; -4.3233235708469655e-6 -8646.64717331055 \
     4.323323585170289e-6",
];

/// The state after and the mean over a step, in the norm of the energy.
fn golden<const N: usize>(parts: &[Vec<f64>]) {
    type State<const N: usize> = SVector<f64, N>;
    let of = |i: usize| State::<N>::from_column_slice(&parts[i]);
    let (row, x, [h, u]) = (of(1), of(2), [parts[3][0], parts[3][1]]);
    let relaxation = <State<N> as Deflection<f64>>::relaxation(of(0), row);
    let weights = <State<N> as Deflection<f64>>::weights(relaxation, h);
    let norm = |x: State<N>| row.component_mul(&x).dot(&x).sqrt();
    // Four thousand random matrices with rates from 1e-12 to 1e12 1/s came within 2e-15.
    let tolerance = 4e-15 * norm(x).max(norm(of(4))).max(norm(of(5)));
    let drive = State::repeat(u);
    for (got, want) in [(weights.end(x, drive), of(4)), (weights.mean(x, drive), of(5))] {
        assert!(norm(got - want) <= tolerance, "{got} is not {want} after {h} s");
    }
}

#[test]
fn the_exact_step_is_that_of_ninety_digits() {
    for step in STEPS {
        let numbers = |part: &str| part.split_whitespace().map(|x| x.parse().unwrap()).collect();
        let parts: Vec<Vec<f64>> = step.split(';').map(numbers).collect();
        match parts[0].len() {
            2 => golden::<2>(&parts),
            3 => golden::<3>(&parts),
            _ => golden::<5>(&parts),
        }
    }
}

/// Rates and states apart by many decades, and a step in units of any of the rates.
#[test]
fn the_exact_step_is_the_step_of_many_small_ones() {
    let pick = (0..5_usize, decades(1e-12, 1e12));
    check(96, (case(), pick), |((r, p, v, forces), (which, length))| {
        for specimen in specimens::<f64>(&r, &p) {
            let (form, subject) = (&specimen.form, &specimen.subject);
            let x = stretches(form, &forces);
            let share = form.speed(v) / (form.mu(v) + form.damping(v) * form.speed(v));
            let i = which % x.len();
            let rate = form.decay(v)[i] + share * form.arms[i].0;
            let h = length / if rate > 0.0 { rate } else { 1.0 };
            let (whole, _, mean) = subject.hold(v, &x, h);
            let (half, _, first) = subject.hold(v, &x, 0.5 * h);
            let (twice, _, second) = subject.hold(v, &half, 0.5 * h);
            let energy = |x: &[f64]| subject.stored_energy(x);
            let size = energy(&x).max(energy(&whole)).max(energy(&half));
            let apart: Vec<f64> = whole.iter().zip(&twice).map(|(a, b)| a - b).collect();
            // In the norm of the energy: a few roundings of each of three steps.
            let off = (energy(&apart) / size).sqrt();
            assert!(size == 0.0 || off < 1e-13, "{}: {off:e}", specimen.name());
            let scale = r.load * (form.carried(&x).0 + form.carried(&whole).0 + form.mu(v));
            assert_within(1e-12, scale, 0.5 * (first + second), mean, || specimen.name());
            // h F̄ v = ΔW + what is dissipated.
            let stored = energy(&whole) - energy(&x);
            let work = h * mean * v;
            let scale = work.abs() + size + h * scale * v.abs();
            assert!(work - stored >= -1e-12 * scale, "{}: {work:e}, {stored:e}", specimen.name());
        }
    });
}

#[test]
fn a_held_step_in_single_precision_is_the_rounded_one() {
    // Parameters and states as they are in f32, the reference in f64 from the same numbers.
    check(64, (0.1..10.0_f64, -1.0..1.0_f64, decades(1e-6, 1e6)), |(scale, v, h)| {
        let (k, e) = ([1e4 * scale, 2e4, 3e3], [50.0, 4e3]);
        let round = |x: f64| f64::from(x as f32);
        let r = Recipe::TABLE_2;
        let wide = FrBd::new(
            stribeck::<f64>(&r, 2.0),
            arms([(round(k[0]), None), (k[1], Some(e[0])), (k[2], Some(e[1]))], 1.0),
        );
        let single = FrBd::new(
            stribeck::<f32>(&r, 2.0),
            arms([(k[0], None), (k[1], Some(e[0] as f32)), (k[2], Some(e[1] as f32))], 1.0_f32),
        );
        let x = SVector::<f64, 3>::new(1e-4, -2e-5, 3e-5).map(round);
        let got = single.hold(v as f32, x.map(|x| x as f32), h as f32);
        let want = wide.hold(round(v), x, round(h));
        // The matrix is rounded to f32 first, which an eigenvalue times h up to 1e9 would see, were
        // the slow springs not gone by then: 1e-5 is fifty roundings.
        assert_within(1e-5, 2.0, f64::from(got.end_coefficient), want.end_coefficient, || {
            format!("end, h = {h:e}")
        });
        assert_within(1e-5, 2.0, f64::from(got.mean_coefficient), want.mean_coefficient, || {
            format!("mean, h = {h:e}")
        });
    });
}

#[test]
fn what_is_no_number_stays_none() {
    let r = Recipe::TABLE_2;
    let contact = FrBd::new(stribeck(&r, 2.0), zener(1e4, 1e4, 100.0)).under_load(1.0).unwrap();
    let x = Vector2::new(1e-5, 2e-5);
    for (v, x, h) in [
        (f64::NAN, x, 1e-3),
        (0.1, Vector2::new(f64::NAN, 0.0), 1e-3),
        (0.0, Vector2::new(0.0, f64::NAN), 1e-3),
        (0.1, x, f64::NAN),
        (0.1, x, -1e-3),
        (f64::INFINITY, x, 1e-3),
    ] {
        let hold = contact.hold(v, x, h);
        assert!(
            hold.end_force.is_nan() && hold.mean_force.is_nan(),
            "v = {v}, x = {x}, h = {h}: {hold:?}"
        );
    }
    // A row with the wrong sign belongs to no passive bristle.
    let relaxation = <Vector2<f64> as Deflection<f64>>::relaxation(x, Vector2::new(1.0, -1.0));
    let weights = <Vector2<f64> as Deflection<f64>>::weights(relaxation, 1.0);
    assert!(weights.end(x, Vector2::zeros())[0].is_nan());
}

#[test]
fn nothing_happens_in_no_time() {
    every(16, |specimen, v, x| {
        let (end, force, mean) = specimen.subject.hold(v, x, 0.0);
        assert_eq!(end, x, "{}", specimen.name());
        let scale = specimen.form.recipe.load * specimen.form.carried(x).0 + force.abs();
        assert_within(ROUNDING, scale, mean, force, || specimen.name());
    });
}

/// What a passive step says, for any prediction and any mean velocity.
fn assert_passive_step<R: Rheology<f64>>(
    r: &Recipe,
    bristle: R,
    (predicted, mean, h): (f64, f64, f64),
    x: R::Deflection,
) {
    let contact = FrBd::new(stribeck(r, 2.0), bristle).under_load(r.load).unwrap();
    let companion = contact.clone().companion(predicted.abs()).unwrap();
    let step = companion.step(predicted, x, h);
    assert!(step.damping() >= 0.0 && step.is_passive());
    let done = step.commit(mean);
    // Each mode gives squares only.
    assert!(done.dissipated >= 0.0, "{:e}", done.dissipated);
    let (before, after) = (contact.stored_energy(x), contact.stored_energy(done.deflection));
    let scale = done.work.abs() + before + after + done.dissipated;
    // The force is bias + damping v̄: two numbers that may cancel, times the distance.
    let scale = scale + h * mean.abs() * (step.bias().abs() + step.damping() * mean.abs());
    assert_within(1e-12, scale, done.work, done.stored + done.dissipated, || "balance".into());
    assert_within(1e-12, before + after, done.stored, after - before, || "ΔW".into());
    if !contact.model().obeys(Law::BoundedDeflection) {
        // With a prediction that comes true it is the exact step.
        let (done, hold) = (step.commit(predicted), contact.hold(predicted, x, h));
        assert_eq!(done.deflection, hold.deflection);
        let scale = step.bias().abs() + step.damping() * predicted.abs() + hold.mean_force.abs();
        let weighted = contact.model().storage_stiffness().scaled_by(x);
        let scale = scale + r.load * weighted.largest() * 5.0;
        assert_within(1e-12, scale, done.force, hold.mean_force, || "F̄".into());
    }
}

#[test]
fn a_passive_step_balances_its_energy_for_any_prediction() {
    let steps = (velocity(), velocity(), decades(1e-9, 1e6));
    check(256, (case(), steps), |((r, p, _, forces), step)| {
        let (k, e) = (p.stiffness, p.series);
        let x = |i: usize, k: f64| forces[i] * r.static_ / k;
        assert_passive_step(
            &r,
            maxwell(k[0], e[0]),
            step,
            forces[0].clamp(-1.0, 1.0) * r.static_ / k[0],
        );
        let two = Vector2::new(x(0, k[0]), x(1, k[1]));
        assert_passive_step(&r, zener(k[0], k[1], e[1]), step, two);
        let three = SVector::<f64, 3>::from_fn(|i, _| x(i, k[i]));
        let bristle = arms([(k[0], None), (k[1], Some(e[1])), (k[2], Some(e[2]))], p.beside);
        assert_passive_step(&r, bristle, step, three);
        let creeping = [0, 1, 2].map(|i| (k[i], Some(e[i].into())));
        let bristle = own_arms(creeping, varying(&r, p.beside));
        assert_passive_step(&r, bristle, step, three);
    });
}

#[test]
fn one_static_arm_is_a_kelvin_voigt_bristle() {
    check(64, case(), |(r, p, v, forces)| {
        let (k, d, x) = (p.stiffness[0], p.beside, forces[0] * r.static_ / p.stiffness[0]);
        let one = FrBd::new(stribeck(&r, 2.0), arms([(k, None)], d));
        let same = FrBd::new(stribeck(&r, 2.0), kelvin_voigt(k, d));
        let state = [x].into();
        let (held, want) = (one.hold(v, state, 1e-3), same.hold(v, x, 1e-3));
        for (got, want) in [
            (one.rate(v, state)[0], same.rate(v, x)),
            (one.coefficient(v, state), same.coefficient(v, x)),
            (held.mean_coefficient, want.mean_coefficient),
            (one.stationary(v)[0], same.stationary(v)),
        ] {
            // Differences of the terms K x and d v.
            let scale = want.abs() + r.static_ * 3.0 * (1.0 + v.abs() + (v / d).abs()) + v.abs();
            let scale = scale + r.static_ * (v.abs() + forces[0].abs() / d);
            assert_within(ROUNDING, scale, got, want, || "arm".into());
        }
        assert_eq!(one.limits(1.0), same.limits(1.0));
        let undamped = FrBd::new(stribeck(&r, 2.0), arms([(k, None)], 0.0));
        let spring = FrBd::new(stribeck(&r, 2.0), spring(k));
        assert_eq!(undamped.rate(v, state)[0], spring.rate(v, x));
    });
}

#[test]
fn several_springs_claim_no_bound_of_deflection_and_force_for_they_break_it() {
    // Both stretches within max μ/K, the first at its limit: the second spring pulls it on.
    let model = FrBd::new(of_one(), arms([(1e4, None), (1e4, Some(2e3))], 30.0));
    let pulled = model.rate(0.1, Vector2::new(1e-4, -1e-4));
    assert!(pulled[0] > 0.0 && !model.obeys(Law::BoundedDeflection));
    assert!(model.coefficient(0.1, Vector2::new(1e-4, 1e-4)) > 1.1);
    assert!(!model.obeys(Law::BoundedForce));
}

#[test]
fn the_matrix_of_a_bristle_of_several_springs_is_its_decay_and_a_common_row() {
    let (decay, row) = (Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.5, -1.0, 2.0));
    let matrix = Matrix3::from_diagonal(&decay) + Vector3::repeat(1.0) * row.transpose();
    let relaxation = <Vector3<f64> as Deflection<f64>>::relaxation(decay, row);
    for x in [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.25, -4.0, 8.0)] {
        // Small binary fractions: exact.
        assert_eq!(Deflection::relax(relaxation, x), matrix * x);
        assert_eq!(Deflection::relax(-relaxation, x), -(matrix * x));
    }
}

#[test]
fn a_maxwell_bristle_is_one_of_one_arm() {
    check(64, case(), |(r, p, v, forces)| {
        let (k, e) = (p.stiffness[0], p.series[0]);
        let x = forces[0] * r.static_ / k;
        let one = FrBd::new(stribeck(&r, 2.0), maxwell(k, e));
        let two = FrBd::new(stribeck(&r, 2.0), arms([(k, Some(e))], 0.0));
        // (a + K|v|/g) x in one product, or in two.
        let scale = v.abs() * (1.0 + forces[0].abs()) + k / e * x.abs();
        assert_within(ROUNDING, scale, two.rate(v, [x].into())[0], one.rate(v, x), || "ẋ".into());
        let (held, want) = (two.hold(v, [x].into(), 1e-2), one.hold(v, x, 1e-2));
        for (got, want) in [
            (two.coefficient(v, [x].into()), one.coefficient(v, x)),
            (two.stationary(v)[0], one.stationary(v)),
        ] {
            assert_within(ROUNDING, want.abs(), got, want, || "force and creep".into());
        }
        let scale = k * (x.abs() + want.deflection.abs());
        let (got, want) = (held.mean_coefficient, want.mean_coefficient);
        assert_within(ROUNDING, scale, got, want, || "mean".into());
        assert_eq!(one.limits(1.0), two.limits(1.0));
    });
}

/// The force at the end of a pull at 4 mm/s over 20 ms and a rest of 20 ms, with Table 2.
fn pulled<R: Rheology<f64>>(bristle: R) -> (f64, f64) {
    let model = FrBd::new(stribeck(&Recipe::TABLE_2, 2.0), bristle);
    let rest = R::Deflection::fill(0.0);
    let pull = model.hold(0.004, rest, 0.02);
    (pull.end_coefficient, model.hold(0.0, pull.deflection, 0.02).end_coefficient)
}

#[test]
fn a_fast_arm_is_a_dashpot_and_a_slow_one_a_spring() {
    let assert_alike = |got: (f64, f64), want: (f64, f64), tolerance: f64| {
        assert_within(tolerance, 1.0, got.0, want.0, || format!("pull, {tolerance:e}"));
        assert_within(tolerance, 1.0, got.1, want.1, || format!("rest, {tolerance:e}"));
    };
    // A stiff arm relaxes in η/K: what differs is of that order of the 20 ms. A dashpot of 64.5 s/m
    // and more is a spring for (η/K)⁻¹ · 20 ms.
    let damped = pulled(kelvin_voigt(1e4, 64.5));
    for stiffness in [1e8, 1e10, 1e12] {
        assert_alike(pulled(zener(1e4, stiffness, 64.5)), damped, 645.0 / stiffness / 0.02);
    }
    let stiff = pulled(spring(3e4));
    for damping in [1e6, 1e9, 1e12] {
        let tolerance = 10.0 * 0.02 * 2e4 / damping + 1e-14;
        assert_alike(pulled(zener(1e4, 2e4, damping)), stiff, tolerance);
        // Without the static spring: Maxwell to a spring.
        assert_alike(pulled(maxwell(3e4, damping)), stiff, 1.5 * tolerance);
    }
    // And with no damping to speak of the arm is not there.
    assert_alike(pulled(zener(1e4, 2e4, 1e-9)), pulled(spring(1e4)), 1e-8);
}

#[test]
fn the_complex_modulus_is_the_sum_of_its_arms() {
    check(128, (parts(), decades(1e-12, 1e12)), |(p, omega)| {
        let (k, e) = (p.stiffness, p.series);
        let bristle = arms([(k[0], None), (k[1], Some(e[1])), (k[2], Some(e[2]))], p.beside);
        let got = bristle.complex_modulus(omega);
        // K₀ + Σ iωηᵢKᵢ/(Kᵢ + iωηᵢ), multiplied out: (ωη)²K/(K² + (ωη)²), ωηK²/(K² + (ωη)²).
        let (mut storage, mut loss) = (k[0], omega * p.beside);
        for i in 1..3 {
            let c = omega * e[i];
            storage += c * c * k[i] / (k[i] * k[i] + c * c);
            loss += c * k[i] * k[i] / (k[i] * k[i] + c * c);
        }
        assert_within(ROUNDING, storage, got.re, storage, || format!("G' at {omega:e}"));
        assert_within(ROUNDING, loss, got.im, loss, || format!("G'' at {omega:e}"));
    });
    let still = zener(1e4, 2e4, 50.0).complex_modulus(0.0);
    assert_eq!((still.re, still.im), (1e4, 0.0));
    let flowing = maxwell(1e4, 50.0).complex_modulus(0.0);
    assert_eq!((flowing.re, flowing.im), (0.0, 0.0));
    let fast = zener(1e4, 2e4, 50.0).complex_modulus(1e300);
    assert_within(ROUNDING, 3e4, fast.re, 3e4, || "G'(∞)".into());
}

#[test]
fn a_small_oscillation_is_answered_by_the_complex_modulus() {
    // Stuck, ẑ = 1 nm against a breakaway of 100 µm: what slides meanwhile is 1e-5 of it. The
    // velocity is held at its value in the middle of 500 parts of a period, (π/500)²/6 = 7e-6 off.
    fn answer<R: Rheology<f64>>(bristle: R, omega: f64) -> (f64, f64) {
        let model = FrBd::new(stribeck(&Recipe::TABLE_2, 2.0), bristle);
        let (amplitude, parts) = (1e-9, 500);
        let h = std::f64::consts::TAU / omega / f64::from(parts);
        let mut x = R::Deflection::fill(0.0);
        let mut moduli = (0.0, 0.0);
        // Until what does not oscillate has gone, ten times the slowest relaxation of 10 ms.
        let periods = 2 + (0.1 * omega / std::f64::consts::TAU) as i32;
        for n in 0..periods * parts {
            let angle = omega * h * (f64::from(n) + 0.5);
            let hold = model.hold(amplitude * omega * angle.cos(), x, h);
            x = hold.deflection;
            if n >= (periods - 1) * parts {
                // z = ẑ sin ωt: storage in phase with sin, loss with cos.
                let share = hold.mean_coefficient * 2.0 / f64::from(parts) / amplitude;
                moduli.0 += share * angle.sin();
                moduli.1 += share * angle.cos();
            }
        }
        moduli
    }
    for omega in [20.0, 300.0, 4e3] {
        let two = zener(1e4, 2e4, 200.0);
        let three = arms([(1e4, None), (2e4, Some(200.0)), (5e4, Some(20.0))], 3.0);
        for (got, want) in [
            (answer(two, omega), two.complex_modulus(omega)),
            (answer(three, omega), three.complex_modulus(omega)),
        ] {
            let size = want.re + want.im;
            assert_within(1e-4, size, got.0, want.re, || format!("G' at {omega}"));
            assert_within(1e-4, size, got.1, want.im, || format!("G'' at {omega}"));
        }
    }
}

#[cfg(feature = "alloc")]
#[test]
fn a_scene_of_several_springs_has_the_exact_steps_and_its_own_jacobian() {
    use bristle::Branch::Forward;
    use bristle::ode::{self, Output, System};
    use bristle::scene::PrescribedVelocity;
    use bristle::signal::{Sine, SineParameters};

    let model = FrBd::new(stribeck(&Recipe::TABLE_2, 2.0), zener(1e4, 2e4, 100.0));
    let contact = model.under_load(2.0).unwrap();
    let held = PrescribedVelocity::new(contact, 0.02);
    let start = Vector2::new(1e-5, -2e-5);
    let run = ode::solve(&held, 0.0..0.05, start, 1e-9, Output::Steps).unwrap();
    let exact = contact.hold(0.02, start, 0.05);
    let (time, state) = run.last().unwrap();
    // The tolerance, over a few relaxations.
    assert!((state - exact.deflection).amax() < 1e-7 * 1e-4, "{state} and {}", exact.deflection);
    assert_within(1e-7, 3.0, held.friction_force(time, state), exact.end_force, || "F".into());
    assert_eq!(System::scales(&held), Vector2::repeat(1.5 / 3e4));

    let wave = SineParameters { mean: 0.0, amplitude: 0.01, frequency: 1.0, phase: 0.0 };
    let sine = PrescribedVelocity::new(contact, Sine::new(wave).unwrap());
    let rate = |time: f64, state: Vector2<f64>| sine.rate(time, &state, [Forward]);
    let tangent = sine.linearised(0.05, &start, [Forward]).unwrap();
    assert_eq!(tangent.rate, rate(0.05, start));
    for (unit, got) in [Vector2::x(), Vector2::y()].iter().zip(tangent.by_state.column_iter()) {
        // Affine in the state.
        let column = rate(0.05, start + unit) - tangent.rate;
        assert!((column - got).amax() <= ROUNDING * got.amax(), "{got} and {column}");
    }
    // Central differences over 1e-6 s: (2π 1e-6)² of it, and roundings of 1e-16/1e-6.
    let slope = (rate(0.05 + 1e-6, start) - rate(0.05 - 1e-6, start)) / 2e-6;
    assert!((slope - tangent.by_time).amax() < 1e-7 * slope.amax(), "{slope} {}", tangent.by_time);
}

#[test]
fn what_makes_no_bristle_is_refused_by_name() {
    let maxwell = |micro_stiffness, series_damping| {
        Maxwell::<f64>::new(MaxwellParameters { micro_stiffness, series_damping }).err()
    };
    let zener = |static_stiffness, relaxing_stiffness, series_damping| {
        let springs = ZenerParameters { static_stiffness, relaxing_stiffness, series_damping };
        GeneralisedMaxwell::<f64, 2>::zener(springs).err()
    };
    let arms = |stiffness, eta, micro_damping| {
        let arm = |stiffness, series_damping| MaxwellArm { stiffness, series_damping };
        let arms = [arm(1.0, None), arm(stiffness, Some(eta))];
        GeneralisedMaxwell::<f64, 2>::new(GeneralisedMaxwellParameters { arms, micro_damping })
            .err()
    };
    for bad in [f64::NAN, f64::INFINITY, -1.0, 0.0] {
        for (refused, name, component) in [
            (maxwell(bad, 1.0), "micro_stiffness", None),
            (maxwell(1.0, bad), "series_damping", None),
            (zener(bad, 1.0, 1.0), "static_stiffness", None),
            (zener(1.0, bad, 1.0), "relaxing_stiffness", None),
            (zener(1.0, 1.0, bad), "series_damping", None),
            (arms(bad, 1.0, 0.0), "arms.stiffness", Some(1)),
            (arms(1.0, bad, 0.0), "arms.series_damping", Some(1)),
            (arms(1e4, 1e-58, 0.0), "stiffness over series_damping", Some(1)),
            // No damping beside the arms is allowed.
            (arms(1.0, 1.0, if bad == 0.0 { -1.0 } else { bad }), "micro_damping", None),
        ] {
            let error = refused.expect("must be refused");
            assert_eq!((error.name, error.component), (name, component), "{error}");
        }
    }
    let none = GeneralisedMaxwellParameters::<f64, 0> { arms: [], micro_damping: 1.0 };
    assert_eq!(GeneralisedMaxwell::new(none).unwrap_err().name, "arms");
}

/// μ = 1 at every speed.
fn of_one<T: Scalar>() -> Coulomb<T> {
    let parameters =
        CoulombParameters { dynamic_coefficient: T::one(), viscous_friction: T::zero() };
    Coulomb::new(parameters).unwrap()
}

#[test]
fn an_arm_that_lets_go_faster_than_a_step_can_tell_is_refused() {
    fn zener<T: Scalar>(eta: f64) -> Result<GeneralisedMaxwell<T, 2>, ParameterError> {
        let [static_stiffness, relaxing_stiffness, series_damping] = [1e4, 1e4, eta].map(lit);
        let parameters = ZenerParameters { static_stiffness, relaxing_stiffness, series_damping };
        GeneralisedMaxwell::zener(parameters)
    }
    let refused = zener::<f32>(1e-7).unwrap_err();
    let Rule::AtMost { limit, .. } = refused.rule else { panic!("{refused}") };
    assert_eq!((refused.name, limit), ("stiffness over series_damping", 1e10));
    // One just within holds its static spring: 1 − e^(−σ0 v t/μ) after 1 s.
    let contact = FrBd::new(of_one::<f32>(), zener(1e-6).unwrap()).under_load(1.0).unwrap();
    let want = -(-1e-2_f64).exp_m1();
    let got = f64::from(contact.hold(1e-6, Vector2::zeros(), 1.0).end_force);
    assert_within(1e-5, want, got, want, || "static spring".to_owned());

    let refused = zener::<f64>(1e-58).unwrap_err();
    assert_eq!(refused.value, 1e4 / 1e-58);
    let contact = FrBd::new(of_one::<f64>(), zener(1e-45).unwrap()).under_load(1.0).unwrap();
    let got = contact.hold(1e-3, Vector2::zeros(), 1.0).end_force;
    assert_within(1e-12, 1.0, got, -(-10.0_f64).exp_m1(), || "f64".to_owned());
}

#[test]
fn springs_may_have_drives_of_their_own() {
    // The end under a held drive against the exponential of the augmented matrix.
    let (decay, row) = (Vector3::new(0.0, 2.0, 30.0), Vector3::new(5.0, 1.0, 8.0));
    let (x, u, h) = (Vector3::new(0.3, -0.2, 0.1), Vector3::new(1.0, -2.0, 0.5), 0.2);
    let relaxation = <Vector3<f64> as Deflection<f64>>::relaxation(decay, row);
    let weights = <Vector3<f64> as Deflection<f64>>::weights(relaxation, h);
    let mut augmented = nalgebra::Matrix4::zeros();
    augmented.fixed_view_mut::<3, 3>(0, 0).copy_from(&(-h * relaxation.matrix()));
    augmented.fixed_view_mut::<3, 1>(0, 3).copy_from(&(h * u));
    let end = augmented.exp() * x.push(1.0);
    // The exponential of a matrix of size ten keeps some fourteen digits.
    assert!((weights.end(x, u) - end.xyz()).amax() < 1e-13);
    // h Λ x̄ = x − x(h) + h u.
    let balance = relaxation.matrix() * weights.mean(x, u) * h - (x - end.xyz() + u * h);
    assert!(balance.amax() < 1e-13);
}
