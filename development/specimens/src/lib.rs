//! What the tests share: random parameters, closed forms, every implementor, and how to compare.
//!
//! A new curve, rheology, regularisation or model is added by one line in [`specimens`] (and by
//! its closed form, which is what it is tested against, in [`closed_form`]).

#![allow(missing_docs, missing_debug_implementations, reason = "for the tests alone")]
#![allow(clippy::should_implement_trait, reason = "`Draw::next` never ends, and needs no adapters")]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

pub mod blocks;
pub mod closed_form;
pub mod draw;
pub mod implicit;
pub mod joints;
pub mod ode;
pub mod own_rheology;
pub mod recipe;
pub mod scenes;
pub mod specimens;
pub mod viscoelastic;

use std::ops::Range;

use bristle::{Affine, ParameterError, Scalar};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestRunner};

/// The literal in a scalar type.
pub fn lit<T: bristle::Scalar>(value: f64) -> T {
    nalgebra::convert(value)
}

/// Asserts that `got` is within `tolerance` of `want`, relative to `scale`: usually the sum of
/// the absolute values of the terms that were added up, since no floating-point sum can do better
/// than a few roundings of those. NaN is never within.
#[track_caller]
pub fn assert_within(
    tolerance: f64,
    scale: f64,
    got: f64,
    want: f64,
    what: impl FnOnce() -> String,
) {
    assert!(
        (got - want).abs() <= tolerance * scale,
        "{}: got {got:e}, want {want:e}, off by {:e} of {scale:e}",
        what(),
        (got - want).abs() / scale
    );
}

/// Asserts that four coefficients, or their slopes, are what they should be, each within so much
/// of the terms it is a sum of.
#[track_caller]
pub fn assert_affine(
    tolerance: f64,
    terms: Affine<f64>,
    got: Affine<f64>,
    want: Affine<f64>,
    what: impl Fn() -> String,
) {
    for (terms, got, want, name) in [
        (terms.relaxation, got.relaxation, want.relaxation, "λ"),
        (terms.drive, got.drive, want.drive, "r"),
        (terms.stiffness, got.stiffness, want.stiffness, "c₀"),
        (terms.damping, got.damping, want.damping, "c₂"),
    ] {
        assert_within(tolerance, terms, got, want, || format!("{name} of {}", what()));
    }
}

/// Asserts that a value is refused, by the name of what it is a value of. NaN is what it was given.
#[track_caller]
pub fn assert_refused<A>(result: Result<A, ParameterError>, name: &str, value: f64) {
    let Err(error) = result else { panic!("{name} = {value} is accepted") };
    assert_eq!(error.name, name, "{error}");
    assert!(error.value == value || error.value.is_nan() && value.is_nan(), "{error}");
}

/// Asserts that some fields of good parameters each refuse every one of some values.
#[macro_export]
macro_rules! assert_fields_refuse {
    ($values:expr, $new:expr, $good:expr; $($field:ident)+) => {
        for value in $values {
            $({
                let mut parameters = $good;
                parameters.$field = value;
                $crate::assert_refused($new(parameters), stringify!($field), value);
            })+
        }
    };
}

/// The four coefficients in another scalar.
pub fn each<T: Scalar, U: Scalar>(a: Affine<T>, part: impl Fn(T) -> U) -> Affine<U> {
    Affine {
        relaxation: part(a.relaxation),
        drive: part(a.drive),
        stiffness: part(a.stiffness),
        damping: part(a.damping),
    }
}

/// Runs a check over random values. The seed is fixed, so that a failure comes back; other seeds
/// and more cases with `PROPTEST_RNG_SEED` and `PROPTEST_CASES`.
pub fn check<S: Strategy>(cases: u32, strategy: S, test: impl Fn(S::Value)) {
    let mut config = Config { failure_persistence: None, ..Config::default() };
    if config.rng_seed == RngSeed::Random {
        config.rng_seed = RngSeed::Fixed(9429);
    }
    if std::env::var_os("PROPTEST_CASES").is_none() {
        config.cases = cases;
    }
    // A failing case is simplified for a while, not for ever.
    config.max_shrink_iters = 200;
    let result = TestRunner::new(config).run(&strategy, |value| {
        test(value);
        Ok(())
    });
    if let Err(failure) = result {
        panic!("{failure}");
    }
}

/// ∫ f over [from, to] by Gauss–Legendre quadrature with five points in each of `panels` panels
/// (nodes and weights as in Abramowitz and Stegun, table 25.4).
pub fn integral(from: f64, to: f64, panels: usize, f: impl Fn(f64) -> f64) -> f64 {
    const NODES: [(f64, f64); 5] = [
        (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let half = 0.5 * (to - from) / panels as f64;
    (0..panels)
        .map(|i| {
            let middle = from + half * (2 * i + 1) as f64;
            NODES.iter().map(|(node, weight)| weight * f(middle + half * node)).sum::<f64>() * half
        })
        .sum()
}

/// The state at the end of a span, by the classical Runge–Kutta method.
pub fn runge_kutta<const N: usize>(
    span: Range<f64>,
    steps: u32,
    mut state: [f64; N],
    rate: impl Fn(f64, [f64; N]) -> [f64; N],
) -> [f64; N] {
    let h = (span.end - span.start) / f64::from(steps);
    for n in 0..steps {
        let t = span.start + h * f64::from(n);
        let along = |a: f64, k: [f64; N]| std::array::from_fn(|i| state[i] + a * k[i]);
        let k1 = rate(t, state);
        let k2 = rate(t + 0.5 * h, along(0.5 * h, k1));
        let k3 = rate(t + 0.5 * h, along(0.5 * h, k2));
        let k4 = rate(t + h, along(h, k3));
        let mean = |i: usize| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0;
        state = along(h, std::array::from_fn(mean));
    }
    state
}

/// The root of an increasing function by bisection to the last digit.
pub fn root(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    assert!(f(low) <= 0.0 && f(high) >= 0.0, "no root between {low:e} and {high:e}");
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if f(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
