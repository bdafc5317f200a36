//! The exact reduction of a rolling patch against the characteristics themselves.
//!
//! `cargo test --release -p bristle-rolling --test rolling exact:: -- --ignored` runs the long
//! version of what is random.
#![cfg(feature = "alloc")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test panics to fail")]

use crate::characteristics::{History, Random};
use crate::tyre::{LENGTH, bristle, curve, motion, patch, step_of, tyre};
use bristle::regularisation::{HyperbolicTangent, SquareRoot};
use bristle::{Bristle, Dahl, DahlParameters, FrBd, LuGre};
use bristle_rolling::{PolynomialExponential, PolynomialExponentialParameters, Pressure};

/// μ_s/σ0 of the tyre [m].
const SCALE: f64 = 0.6 / 252.0;

fn pressure<const N: usize>(coefficients: [f64; N], decay: f64) -> PolynomialExponential<f64, N> {
    PolynomialExponential::new(PolynomialExponentialParameters { coefficients, decay }).unwrap()
}

/// A random step: velocity, transport velocity and duration, with everything a step can meet.
fn draw(random: &mut Random) -> (f64, f64, f64) {
    let side = if random.unit() < 0.5 { -1.0 } else { 1.0 };
    let v = if random.unit() < 0.1 { 0.0 } else { side * random.decades(1e-9, 100.0) };
    if random.unit() < 0.15 {
        return (v, 0.0, random.decades(1e-9, 10.0));
    }
    let transport = random.decades(1e-2, 1e5);
    (v, transport, random.decades(1e-3, 3.0) / transport)
}

/// Rolls over random steps and compares the force with that of the characteristics every so many
/// steps. Returns the greatest difference, over that of fully deflected bristles.
fn worst_of<M: Bristle<f64, Deflection = f64> + Copy, const N: usize>(
    model: M,
    pressure: PolynomialExponential<f64, N>,
    (steps, every, seed): (usize, usize, u64),
) -> f64 {
    let initial = |xi: f64| SCALE * (1.0 - 3.0 * (xi - 0.5).abs());
    let patch = patch(model, pressure);
    let mut rolling = patch.exact_in(1000).unwrap();
    rolling.set_profile(2, initial).unwrap();
    let mut history = History::new(&initial, &[0.5]);
    let mut random = Random(seed);
    let weight = |xi: f64| pressure.at(xi);
    let total = weigh_all(&pressure);
    let (mut worst, mut next) = (0.0_f64, 1);
    for number in 0..steps {
        let (v, transport, h) = draw(&mut random);
        let force = rolling.step(motion(v, transport), h).unwrap();
        history.push(step_of(&model, v, transport, h));
        // Early steps with the initial profile, and then every so often.
        if number == next || number + 1 == steps {
            next += if next < 20 { 1 } else { every };
            let affine = model.affine(v.into(), 0.0);
            let deflections = history.weighted(&weight, pressure.decay().abs() + 4.0);
            let viscous = pressure.total() * affine.damping * v;
            let want = LENGTH * (affine.stiffness * deflections + viscous);
            let full = affine.stiffness.abs() * SCALE * total + viscous.abs();
            let off = (force - want).abs() / (LENGTH * full);
            worst = if off <= worst { worst } else { off };
        }
    }
    worst
}

/// Σ |cₖ| ∫ ξᵏ e^(−aξ) dξ: what rounding is relative to where a pressure has terms of both signs.
fn weigh_all<const N: usize>(pressure: &PolynomialExponential<f64, N>) -> f64 {
    let coefficients = pressure.coefficients().map(f64::abs);
    self::pressure(coefficients, pressure.decay()).total()
}

/// Is given a model's name, and its error under the pressure of some number.
type Check<'a> = dyn FnMut(&str, &dyn Fn(usize) -> f64) + 'a;

fn every_model(check: &mut Check<'_>, run: (usize, usize, u64)) {
    fn over<M: Bristle<f64, Deflection = f64> + Copy>(
        model: M,
        number: usize,
        (steps, every, seed): (usize, usize, u64),
    ) -> f64 {
        let run = (steps, every, seed + number as u64);
        match number {
            0 => worst_of(model, PolynomialExponential::constant(), run),
            1 => worst_of(model, PolynomialExponential::exponential(0.1).unwrap(), run),
            2 => worst_of(model, PolynomialExponential::parabolic(), run),
            3 => worst_of(model, pressure([1.0, 0.5, -0.7, 0.3, 0.6, -0.4], 2.5), run),
            _ => worst_of(model, pressure([0.3, 1.5, 0.7, -0.9, 0.0, 0.4], -3.0), run),
        }
    }
    let soft = SquareRoot::new(1e-4).unwrap();
    let tanh = HyperbolicTangent::new(1e-3).unwrap();
    let (plain, damped) = (FrBd::new(curve(), bristle(0.0)), FrBd::new(curve(), bristle(0.3)));
    check("FrBD", &|n| over(plain, n, run));
    check("FrBD, damped", &|n| over(damped, n, run));
    check("FrBD, smooth", &|n| over(damped.regularised(soft), n, run));
    check("FrBD, tanh", &|n| over(plain.regularised(tanh), n, run));
    let lugre = LuGre::classical(curve(), bristle(0.3));
    check("LuGre", &|n| over(lugre, n, run));
    check("LuGre, smooth", &|n| over(lugre.regularised(soft), n, run));
    let inside = LuGre::with_viscous_friction(curve(), bristle(0.3), 0.0).unwrap();
    check("LuGre, viscous inside", &|n| over(inside, n, run));
    let dahl =
        Dahl::new(DahlParameters { dynamic_coefficient: 0.6, micro_stiffness: 252.0 }).unwrap();
    check("Dahl", &|n| over(dahl, n, run));
}

/// A hundred roundings of what is added up.
const EXACT: f64 = 1e-13;

#[test]
fn the_force_is_that_of_the_characteristics() {
    // 8 models × 5 pressures × 3000 steps, ten crossings of the patch or more.
    every_model(
        &mut |name, over| {
            for number in 0..5 {
                let worst = over(number);
                assert!(worst <= EXACT, "{name}, pressure {number}: {worst:e}");
            }
        },
        (3000, 240, 7),
    );
}

#[test]
#[ignore = "long: cargo test --release -p bristle-rolling --test rolling exact:: -- --ignored"]
fn the_force_is_that_of_the_characteristics_for_long() {
    every_model(
        &mut |name, over| {
            for number in 0..5 {
                let worst = over(number);
                println!("{name}, pressure {number}: {worst:e}");
                assert!(worst <= EXACT, "{name}, pressure {number}: {worst:e}");
            }
        },
        (1_000_000, 300, 1234),
    );
}

#[test]
fn a_long_run_of_one_patch_is_as_exact() {
    let worst = worst_of(tyre(), PolynomialExponential::parabolic(), (200_000, 3_000, 99));
    assert!(worst <= EXACT, "{worst:e}");
}

#[test]
fn every_bristle_is_where_its_characteristic_takes_it() {
    let initial = |xi: f64| SCALE * (1.0 - 2.0 * xi);
    let mut rolling = patch(tyre(), PolynomialExponential::parabolic()).exact_in(1000).unwrap();
    rolling.set_profile(1, initial).unwrap();
    let mut history = History::new(&initial, &[]);
    let mut random = Random(5);
    for _ in 0..1000 {
        let (v, transport, h) = draw(&mut random);
        rolling.step(motion(v, transport), h).unwrap();
        history.push(step_of(&tyre(), v, transport, h));
        for _ in 0..5 {
            let place = random.unit();
            let (got, want) = (rolling.deflection(place), history.deflection(place));
            // A profile may fall from full to none within 1e-3 of the patch, at a place that is
            // known to some roundings: 1e3 · 1e-15.
            assert!((got - want).abs() < 1e-11 * SCALE, "{place}: {got:e} {want:e}");
        }
    }
}

#[test]
fn a_deflection_moves_out_exactly_and_nothing_is_left_of_it() {
    // No relaxation at v = 0: the profile moves on as it is, F = L c₀ ∫ p z(ξ − Vt) dξ.
    let initial = |xi: f64| SCALE * (1.0 - 2.0 * (xi - 0.5).abs());
    for slots in [22, 300] {
        let patch = patch(tyre(), PolynomialExponential::constant());
        let mut rolling = patch.exact(vec![Default::default(); slots]).unwrap();
        rolling.set_profile(2, initial).unwrap();
        let stiffness = LENGTH * tyre().affine((0.0).into(), 0.0).stiffness * SCALE;
        let way = 1.0 / 160.0;
        for number in 1..=300 * 160 {
            let force = rolling.step(motion(0.0, 160.0), way / 160.0).unwrap();
            let left = (1.0 - f64::from(number) * way).max(0.0);
            let inside = if left > 0.5 { 0.5 - (1.0 - left).powi(2) } else { left * left };
            // Half a rounding of the place a step.
            assert!((force - stiffness * inside).abs() < 1e-13 * stiffness, "{number}: {force:e}");
            assert!(number <= 160 || force == 0.0, "{number}: {force:e}");
        }
    }
}

#[test]
fn free_rolling_for_three_hundred_transits_after_sliding_leaves_nothing() {
    fn check<const N: usize>(pressure: PolynomialExponential<f64, N>) {
        let mut rolling = patch(tyre(), pressure).exact_in(500).unwrap();
        let mut random = Random(8);
        for _ in 0..2000 {
            rolling.step(motion(100.0 * random.unit(), 100.0), 2e-5).unwrap();
        }
        // One transit and a rounding.
        for _ in 0..501 {
            rolling.step(motion(0.0, 100.0), 2e-5).unwrap();
        }
        for _ in 0..300 * 500 {
            assert_eq!(rolling.step(motion(0.0, 100.0), 2e-5).unwrap(), 0.0);
        }
        assert_eq!(rolling.force(1.0), 0.0);
    }
    check(PolynomialExponential::constant());
    check(PolynomialExponential::exponential(0.1).unwrap());
    check(PolynomialExponential::parabolic());
}

#[test]
fn a_patch_at_rest_keeps_its_force() {
    let mut rolling = patch(tyre(), PolynomialExponential::parabolic()).exact_in(100).unwrap();
    let mut random = Random(4);
    for _ in 0..137 {
        rolling.step(motion(random.unit(), 100.0), 1e-4).unwrap();
    }
    let force = rolling.force(0.0);
    for _ in 0..100_000 {
        let now = rolling.step(motion(0.0, 0.0), 1e-3).unwrap();
        // λ = 0: nothing is rounded. Moments are added up anew, always alike.
        assert!((now - force).abs() <= 4.0 * f64::EPSILON * force, "{now:e} {force:e}");
    }
}

#[test]
fn a_small_slip_after_full_sliding_keeps_its_digits() {
    // Relative, not to full deflection: nothing is ever subtracted, so that what has left leaves no
    // rounding behind.
    for v in [1e-9, -1e-6, 1e-3] {
        let mut rolling = patch(tyre(), PolynomialExponential::parabolic()).exact_in(300).unwrap();
        // Nothing narrower than its share, so that nothing is merged.
        let mut random = Random(3);
        for _ in 0..1000 {
            rolling
                .step(motion(100.0 * random.unit(), 100.0), 4e-5 * (1.0 + random.unit()))
                .unwrap();
        }
        let step = 4e-5 * (1.0 + random.unit());
        for _ in 0..(1.0 / (100.0 * step)) as usize + 2 {
            rolling.step(motion(v, 100.0), step).unwrap();
        }
        for _ in 0..1000 {
            let force = rolling.step(motion(v, 100.0), 4e-5 * (1.0 + random.unit())).unwrap();
            let want = steady_parabola(v, 100.0);
            // Some hundred steps a transit.
            assert!((force / want - 1.0).abs() < 1e-13, "{v:e}: {force:e} {want:e}");
        }
    }
}

/// Steady force under a parabola of total 1 N/m: with κ = λ/V, of z_ss the part
/// 1 − 6 (κ − 2 + (κ + 2) e^−κ)/κ³, as a series for small κ.
fn steady_parabola(v: f64, transport: f64) -> f64 {
    let affine = tyre().affine(v.into(), 0.0);
    let kappa = affine.relaxation / transport;
    let (mut part, mut power) = (0.0, 1.0);
    if kappa < 1.0 {
        // κ Σ (−1)ⁿ⁺¹ κⁿ⁻¹/(n! (n + 2) (n + 3))
        for n in 1..=24 {
            let n = f64::from(n);
            power /= n;
            part += 6.0 * power / ((n + 2.0) * (n + 3.0));
            power *= -kappa;
        }
    } else {
        let left = (kappa - 2.0 + (kappa + 2.0) * (-kappa).exp()) / kappa.powi(3);
        part = (1.0 - 6.0 * left) / kappa;
    }
    LENGTH * affine.stiffness * affine.drive * v / transport * part
}

#[test]
fn a_step_input_from_rest_is_steady_after_one_transit() {
    // V h = 1/64 to the last digit, so that the transit ends with a step.
    for (v, transport, steps) in
        [(1e-9, 64.0, 64), (0.1, 16.0, 32), (3.0, 128.0, 128), (-40.0, 1.0, 16)]
    {
        let h = 1.0 / (transport * f64::from(steps));
        let mut rolling = patch(tyre(), PolynomialExponential::parabolic()).exact_in(200).unwrap();
        let want = steady_parabola(v, transport);
        let mut force = 0.0;
        for number in 1..=2 * steps {
            force = rolling.step(motion(v, transport), h).unwrap();
            if number >= steps {
                // A rounding a step.
                assert!((force / want - 1.0).abs() < 1e-14, "{v}, {number}: {force:e} {want:e}");
            } else if number < steps * 3 / 4 && v.abs() < 1.0 {
                assert!((force / want - 1.0).abs() > 1e-3, "{number}");
            }
        }
        rolling.settle(motion(v, transport)).unwrap();
        assert!((force / rolling.force(v) - 1.0).abs() < 1e-14);
    }
}

#[test]
fn a_held_step_may_be_taken_in_parts() {
    let mut random = Random(12);
    let new = || patch(tyre(), pressure([0.2, 1.0, 0.0, -0.5], 0.7)).exact_in(7000).unwrap();
    let (mut whole, mut parts) = (new(), new());
    for _ in 0..2000 {
        let (v, transport, h) = draw(&mut random);
        let want = whole.step(motion(v, transport), h).unwrap();
        let count = 1 + (random.unit() * 6.0) as usize;
        let mut got = 0.0;
        for _ in 0..count {
            got = parts.step(motion(v, transport), h / count as f64).unwrap();
        }
        assert!((got - want).abs() < EXACT * LENGTH * 0.6, "{got:e} {want:e}");
    }
}

#[test]
fn a_clone_goes_on_alike_and_has_a_name() {
    let mut one = patch(tyre(), PolynomialExponential::constant()).exact_in(20).unwrap();
    for number in 0..50 {
        one.step(motion(f64::from(number), 20.0), 1e-3).unwrap();
    }
    let mut other = one.clone();
    assert!(format!("{other:?}").starts_with("ExactPatch"));
    for number in 0..50 {
        let motion = motion(-f64::from(number), 20.0);
        assert_eq!(one.step(motion, 1e-3), other.step(motion, 1e-3));
    }
}
