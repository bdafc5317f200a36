//! The exact reduction of a rolling patch against the characteristics themselves.

mod common;

use bristle::rolling::{
    Motion, Patch, PatchParameters, PolynomialExponential, PolynomialExponentialParameters,
    RateDependent,
};
use bristle::{FrBd, KelvinVoigt, LuGre, Stribeck, paper};

/// A held motion, as the friction model sees it.
#[derive(Debug, Clone, Copy)]
struct Step {
    relaxation: f64,
    drive: f64,
    transport: f64,
    duration: f64,
}

/// The deflection at a place by following its bristle back to the inlet or to the beginning, and then
/// forth through the closed form of every step.
fn deflection(history: &[Step], initial: &dyn Fn(f64) -> f64, place: f64) -> f64 {
    let mut place = place;
    let mut first = history.len();
    let mut entered = None;
    while first > 0 {
        first -= 1;
        let step = history[first];
        let way = step.transport * step.duration;
        if place < way {
            entered = Some(place / step.transport);
            break;
        }
        place -= way;
    }
    let relax = |z: f64, step: &Step, time: f64| {
        let x = step.relaxation * time;
        let phi1 = if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x };
        (-x).exp() * z + step.drive * time * phi1
    };
    let (mut z, rest) = match entered {
        Some(time) => (relax(0.0, &history[first], time), &history[first + 1..]),
        None => (initial(place), history),
    };
    for step in rest {
        z = relax(z, step, step.duration);
    }
    z
}

/// ∫ p z dξ by Gauss–Legendre quadrature between the places where the profile has kinks.
fn weighted(
    history: &[Step],
    initial: &dyn Fn(f64) -> f64,
    kinks: &[f64],
    pressure: impl Fn(f64) -> f64,
) -> f64 {
    let mut places = vec![0.0, 1.0];
    let mut way = 0.0;
    for step in history.iter().rev() {
        way += step.transport * step.duration;
        places.push(way);
    }
    places.extend(kinks.iter().map(|kink| kink + way));
    places.retain(|place| (0.0..=1.0).contains(place));
    places.sort_by(f64::total_cmp);
    let panel = |pair: &[f64]| {
        common::integral(pair[0], pair[1], 12, |xi| pressure(xi) * deflection(history, initial, xi))
    };
    places.windows(2).map(panel).sum()
}

#[test]
fn the_force_is_that_of_the_characteristics() {
    let model = FrBd::new(
        Stribeck::new(paper::TYRE_CURVE).unwrap(),
        KelvinVoigt::new(paper::TYRE_BRISTLE).unwrap(),
    );
    let pressure = PolynomialExponential::new(PolynomialExponentialParameters {
        coefficients: [1.0, 0.5, -0.7],
        decay: 0.3,
    })
    .unwrap();
    let patch = Patch::new(PatchParameters { model, length: 0.1, pressure }).unwrap();
    let mut rolling = patch.exact_in(400).unwrap();
    let initial = |xi: f64| 1e-4 * (1.0 - 2.0 * (xi - 0.5).abs());
    rolling.set_profile(2, initial).unwrap();
    let mut seed = 12345_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut history = Vec::new();
    let mut worst = 0.0_f64;
    for n in 0..400 {
        let v =
            if n % 17 == 3 { 0.0 } else { 4.0 * (random() - 0.5) * 10_f64.powf(-6.0 * random()) };
        let transport = if n % 11 == 5 { 0.0 } else { 100.0 * random() };
        let h = if n % 50 == 49 { 2e-2 * random() } else { 2e-3 * random() } + 2e-4;
        let affine = model.at_velocity(v);
        history.push(Step {
            relaxation: affine.relaxation,
            drive: affine.drive * v,
            transport,
            duration: h,
        });
        let force =
            rolling.step(Motion { slip_velocity: v, transport_velocity: transport }, h).unwrap();
        let p = |xi: f64| (1.0 + 0.5 * xi - 0.7 * xi * xi) * (-0.3 * xi).exp();
        let want = weighted(&history, &initial, &[0.0, 0.5], p);
        let got = force / 0.1 / affine.stiffness;
        worst = worst.max((got - want).abs() / (0.6 / 252.0));
    }
    println!("worst {worst:e}, {} segments", rolling.segments());
    assert!(worst < 1e-13, "{worst:e}");
}

#[test]
fn lugre_compiles() {
    let model = LuGre::classical(
        Stribeck::new(paper::TYRE_CURVE).unwrap(),
        KelvinVoigt::new(paper::TYRE_BRISTLE).unwrap(),
    );
    let patch = Patch::new(PatchParameters {
        model,
        length: 0.1,
        pressure: PolynomialExponential::parabolic(),
    })
    .unwrap();
    let mut rolling = patch.exact_in(2000).unwrap();
    let begin = std::time::Instant::now();
    let n = 1_000_000;
    let mut sum = 0.0;
    for i in 0..n {
        let v = 1.0 + 0.5 * f64::from(i % 100) * 0.01;
        sum += rolling.step(Motion { slip_velocity: v, transport_velocity: 100.0 }, 1e-5).unwrap();
    }
    let exact = begin.elapsed().as_secs_f64() / f64::from(n) * 1e9;
    let begin = std::time::Instant::now();
    let mut z = 0.0;
    for i in 0..n {
        let v = 1.0 + 0.5 * f64::from(i % 100) * 0.01;
        z = bristle::Bristle::hold(&model, v, z, 1e-5).deflection;
    }
    let hold = begin.elapsed().as_secs_f64() / f64::from(n) * 1e9;
    println!("{exact} ns, hold {hold} ns, {} {sum} {z}", exact / hold);
}
