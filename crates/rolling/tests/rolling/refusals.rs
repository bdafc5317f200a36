//! What a patch must not take, or must take like its neighbour.

#![allow(clippy::unwrap_used, reason = "a test panics to fail")]

use crate::tyre::{loaded, tyre};
use bristle::curve::{FunctionCurve, Stribeck};
use bristle::regularisation::SquareRoot;
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bounds, FrBd, LuGre, paper};
use bristle_rolling::{ExactPatch, Motion, Patch, PatchParameters, PolynomialExponential, Segment};

fn constant<M>(model: M) -> Patch<f64, M, PolynomialExponential<f64, 1>> {
    loaded(model, PolynomialExponential::constant())
}

#[test]
fn minus_zero_is_zero() {
    let motion = |rolling_speed| Motion { slip_velocity: 1.0, rolling_speed };
    let force = |transport| constant(tyre()).steady(motion(transport)).unwrap().force;
    assert_eq!(force(-0.0), force(0.0));
    // Regularised bristles relax at rest too.
    let soft = constant(tyre().regularised(SquareRoot::new(1e-4).unwrap()));
    let still = soft.steady(Motion { slip_velocity: 0.0, rolling_speed: -0.0 }).unwrap();
    assert_eq!(still.force, 0.0);
    let mut rolling = soft.exact([Segment::default(); 30]).unwrap();
    assert!(rolling.step(motion(-0.0), 1e-3).unwrap() > 0.0);
}

/// A pattern of steps that once filled the slots: narrow ones, and between them long ones that are
/// looked at and dropped.
#[test]
fn steps_that_are_dropped_do_not_fill_the_slots() {
    fn each<const N: usize>(pressure: PolynomialExponential<f64, N>, slots: usize) {
        let plain = Patch::new(PatchParameters { model: tyre(), length: 0.1, pressure }).unwrap();
        let mut rolling = plain.exact(vec![Segment::default(); slots]).unwrap();
        let steady = |v| Motion { slip_velocity: v, rolling_speed: 16.0 };
        rolling.settle(steady(0.5)).unwrap();
        let expected = rolling.force(0.5);
        let drop_one = |rolling: &mut ExactPatch<f64, _, N, _>, way: f64| {
            assert!(rolling.companion_step(steady(-3.0), way / 160.0).is_ok());
        };
        for number in 0..2000 {
            let way = rolling.narrowest() * [0.01, 0.4, 0.1][number % 3];
            let force = rolling.step(steady(0.5), way / 160.0).unwrap();
            drop_one(&mut rolling, [0.3, 0.9, 2.0][number % 3]);
            assert!(rolling.segments() <= slots, "{} of {slots}", rolling.segments());
            // The law of merging, see `ExactPatch`.
            let off = (force / expected - 1.0).abs();
            assert!(off < 0.2 * rolling.narrowest().powi(2), "{number}: off by {off:e}");
        }
    }
    for slots in [22, 50, 300] {
        each(PolynomialExponential::constant(), slots);
        each(PolynomialExponential::parabolic(), slots);
    }
}

#[test]
fn a_curve_that_is_no_number_is_named_by_every_function() {
    for value in [f64::NAN, f64::INFINITY, -0.5] {
        // The closure breaks its promise.
        let bounds = Bounds { min: 0.1, max: 1.0 };
        let curve = FunctionCurve::new(move |_| (value, 0.0), bounds).unwrap();
        let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE).unwrap();
        let patch = constant(FrBd::new(curve, bristle));
        let motion = Motion { slip_velocity: 1.0, rolling_speed: 10.0 };
        let named = |error: bristle::ParameterError| {
            assert!(error.name.contains("friction model"), "{error}");
        };
        named(patch.steady(motion).unwrap_err());
        named(patch.peak(motion).unwrap_err());
        named(patch.pneumatic_trail(motion).unwrap_err());
        named(patch.linearised(motion).unwrap_err());
        let mut rolling = patch.exact([Segment::default(); 30]).unwrap();
        named(rolling.step(motion, 1e-3).unwrap_err());
        named(rolling.step(Motion { rolling_speed: 0.0, ..motion }, 0.0).unwrap_err());
        named(rolling.companion_step(motion, 1e-3).unwrap_err());
    }
}

#[test]
fn what_is_too_large_for_a_mean_force_is_refused() {
    let bristle =
        KelvinVoigt::new(KelvinVoigtParameters { micro_damping: 1.0, ..paper::TYRE_BRISTLE });
    let curve = Stribeck::new(paper::TYRE_CURVE).unwrap();
    let rolling = constant(LuGre::classical(curve, bristle.unwrap()));
    let mut rolling = rolling.exact([Segment::default(); 30]).unwrap();
    let mut seen = 0;
    for rolling_speed in [5e-324, 1e-300, 1e-100, 1.0, 1e99] {
        for duration in [0.0, 5e-324, 1e-100, 1.0, 1e99] {
            for slip_velocity in [0.0, 1e-3, -1e99] {
                let motion = Motion { slip_velocity, rolling_speed };
                rolling.step(Motion { slip_velocity: 0.1, rolling_speed: 1.0 }, 0.1).unwrap();
                if let Ok(step) = rolling.companion_step(motion, duration) {
                    assert!(step.bias().is_finite() && step.damping() >= 0.0);
                    seen += 1;
                }
            }
        }
    }
    assert!(seen > 50);
}
