//! The exact reduction of a rolling patch against the characteristics themselves.

use crate::characteristics::History;
use crate::tyre::{
    LENGTH, Model, constant, dahl, exponential, frbd, lugre, lugre_inside, motion, parabolic,
    patch, polynomial, step_of, tyre,
};
use bristle::Bristle;
use bristle::regularisation::{HyperbolicTangent, SquareRoot};
use bristle_rolling::{PolynomialExponential, Pressure};
use bristle_specimens::draw::Draw;

/// μ_s/σ0 of the tyre [m].
const SCALE: f64 = 0.6 / 252.0;

/// A random step: velocity, transport velocity and duration, with everything a step can meet.
fn draw(random: &mut Draw) -> (f64, f64, f64) {
    let side = if random.next() < 0.5 { -1.0 } else { 1.0 };
    let v = if random.next() < 0.1 { 0.0 } else { side * random.logarithmic(1e-9, 100.0) };
    if random.next() < 0.15 {
        return (v, 0.0, random.logarithmic(1e-9, 10.0));
    }
    let transport = random.logarithmic(1e-2, 1e5);
    (v, transport, random.logarithmic(1e-3, 3.0) / transport)
}

/// Rolls over random steps and compares the force with that of the characteristics every so many
/// steps. Returns the greatest difference, over that of fully deflected bristles.
fn worst_of<M: Model, const N: usize>(
    model: M,
    pressure: PolynomialExponential<f64, N>,
    (steps, every, seed): (usize, usize, u64),
) -> f64 {
    let patch = patch(model, pressure);
    // κ is 2.6 or less: the quadrature of the history is made for twice that and the pressure.
    let (start, mut rolling) = (motion(0.6, 100.0), patch.exact_in(1000).unwrap());
    rolling.settle(start).unwrap();
    let steady = patch.steady(start).unwrap();
    let initial = |xi: f64| steady.deflection(xi);
    let mut history = History::new(&initial, &[]);
    let mut random = Draw(seed);
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
    let coefficients = pressure.parameters().coefficients.map(f64::abs);
    polynomial(coefficients, pressure.decay()).total()
}

/// A hundred roundings of what is added up.
const EXACT: f64 = 1e-13;

/// Eight models under five pressures.
fn every_model(run: (usize, usize, u64)) {
    fn over<M: Model>(name: &str, model: M, (steps, every, seed): (usize, usize, u64)) {
        let run = |number| (steps, every, seed + number);
        let worst = [
            worst_of(model, constant(), run(0)),
            worst_of(model, exponential(0.1), run(1)),
            worst_of(model, parabolic(), run(2)),
            worst_of(model, polynomial([1.0, 0.5, -0.7, 0.3, 0.6, -0.4], 2.5), run(3)),
            worst_of(model, polynomial([0.3, 1.5, 0.7, -0.9, 0.0, 0.4], -3.0), run(4)),
        ];
        assert!(worst.iter().all(|&worst| worst <= EXACT), "{name}: {worst:?}");
    }
    let soft = SquareRoot::new(1e-4).unwrap();
    over("FrBD", tyre(), run);
    over("FrBD, damped", frbd(0.3), run);
    over("FrBD, smooth", frbd(0.3).regularised(soft), run);
    over("FrBD, tanh", tyre().regularised(HyperbolicTangent::new(1e-3).unwrap()), run);
    over("LuGre", lugre(0.3), run);
    over("LuGre, smooth", lugre(0.3).regularised(soft), run);
    over("LuGre, viscous inside", lugre_inside(0.3), run);
    over("Dahl", dahl(), run);
}

#[test]
fn the_force_is_that_of_the_characteristics() {
    // 3000 steps, ten crossings of the patch or more.
    every_model((3000, 240, 7));
}

#[test]
fn every_bristle_is_where_its_characteristic_takes_it() {
    let patch = patch(tyre(), parabolic());
    let (start, mut rolling) = (motion(-0.6, 100.0), patch.exact_in(1000).unwrap());
    rolling.settle(start).unwrap();
    let steady = patch.steady(start).unwrap();
    let initial = |xi: f64| steady.deflection(xi);
    let mut history = History::new(&initial, &[]);
    let mut random = Draw(5);
    for _ in 0..1000 {
        let (v, transport, h) = draw(&mut random);
        rolling.step(motion(v, transport), h).unwrap();
        history.push(step_of(&tyre(), v, transport, h));
        for _ in 0..5 {
            let place = random.next();
            let (got, want) = (rolling.deflection(place), history.deflection(place));
            // A profile may fall from full to none within 1e-3 of the patch, at a place that is
            // known to some roundings: 1e3 · 1e-15.
            assert!((got - want).abs() < 1e-11 * SCALE, "{place}: {got:e} {want:e}");
        }
    }
}

#[test]
fn a_deflection_moves_out_exactly_and_nothing_is_left_of_it() {
    // No relaxation at v = 0: the profile moves on as it is, F = L c₀ ∫ p z(ξ − Vt) dξ, here of
    // z_ss (1 − e^(−κξ)).
    for slots in [22, 300] {
        let patch = patch(tyre(), constant());
        let mut rolling = patch.exact([vec![Default::default(); slots]]).unwrap();
        let start = motion(0.6, 100.0);
        rolling.settle(start).unwrap();
        let steady = patch.steady(start).unwrap();
        let stiffness = LENGTH * tyre().affine((0.0).into(), 0.0).stiffness;
        let (stiffness, decay) = (stiffness * steady.stationary_deflection, steady.decay);
        let way = 1.0 / 160.0;
        for number in 1..=300 * 160 {
            let force = rolling.step(motion(0.0, 160.0), way / 160.0).unwrap();
            let left = (1.0 - f64::from(number) * way).max(0.0);
            let inside = left + (-decay * left).exp_m1() / decay;
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
        let mut random = Draw(8);
        for _ in 0..2000 {
            rolling.step(motion(100.0 * random.next(), 100.0), 2e-5).unwrap();
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
    check(constant());
    check(exponential(0.1));
    check(parabolic());
}
