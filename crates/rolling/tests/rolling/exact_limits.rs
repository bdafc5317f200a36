//! The exact reduction of a rolling patch at its limits: tiny and huge steps, merged segments,
//! little memory, single precision, bad input.
#![cfg(feature = "alloc")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test panics to fail")]

use crate::characteristics::{History, Random};
use crate::tyre::{LENGTH, motion, patch, step_of, tyre};
use bristle::curve::Stribeck;
use bristle::rheology::KelvinVoigt;
use bristle::{Bristle, FrBd, Rule, paper};
use bristle_rolling::{
    ExactPatch, Motion, Patch, PatchParameters, PolynomialExponential, Pressure, Segment,
};

/// The greatest error of the force while steps of V h = `way` are merged, over that of full
/// deflection.
fn merged_error<const N: usize>(
    pressure: PolynomialExponential<f64, N>,
    slots: usize,
    way: f64,
    velocity: &dyn Fn(usize) -> f64,
) -> f64 {
    let mut rolling = patch(tyre(), pressure).exact(vec![Segment::default(); slots]).unwrap();
    let undeflected = |_: f64| 0.0;
    let mut history = History::new(&undeflected, &[]);
    let transport = 400.0;
    let h = way / transport;
    let mut worst = 0.0_f64;
    let per_transit = (1.0 / way) as usize;
    for number in 0..3 * per_transit {
        let v = velocity(number);
        let force = rolling.step(motion(v, transport), h).unwrap();
        history.push(step_of(&tyre(), v, transport, h));
        if number % (per_transit / 53) == 11 {
            let affine = tyre().affine(v.into(), 0.0);
            let z = history.weighted(&|xi| pressure.at(xi), 4.0);
            let want = LENGTH * affine.stiffness * z;
            worst = worst.max((force - want).abs() / (LENGTH * 0.6));
        }
    }
    worst
}

const WAY: f64 = 1.0 / 2048.0;

#[test]
fn merged_steps_err_by_the_cube_of_their_width_and_by_its_square_where_the_velocity_jumps() {
    let smooth = |n: usize| 0.4 + 2.0 * (n as f64 * WAY * 7.3).sin();
    // A new velocity every 0.173 of the patch.
    let jumps = |n: usize| 3.0 * (Random((n as f64 * WAY / 0.173) as u64 * 77 + 5).unit() - 0.5);
    let mut errors = Vec::new();
    for slots in [22, 38, 70, 134] {
        let narrowest = 2.0 / (slots - 6) as f64;
        let of = |velocity: &dyn Fn(usize) -> f64| {
            [
                merged_error(PolynomialExponential::constant(), slots, WAY, velocity),
                merged_error(
                    PolynomialExponential::exponential(1.0).unwrap(),
                    slots,
                    WAY,
                    velocity,
                ),
                merged_error(PolynomialExponential::parabolic(), slots, WAY, velocity),
            ]
        };
        let (smooth, jumps) = (of(&smooth), of(&jumps));
        for error in smooth {
            // The slope of the profile changes by about 20 full deflections over the patch. The
            // factor is measured: 0.10 for constant, 0.06 for exponential, 0.18 for parabolic
            // pressure.
            assert!(error < 0.2 * narrowest.powi(3), "{narrowest}: {error:e}");
        }
        for error in jumps {
            // Measured 0.033 at most.
            assert!(error < 0.05 * narrowest.powi(2), "{narrowest}: {error:e}");
        }
        errors.push(smooth);
    }
    // Four times three halvings of the width: third order.
    for (most, least) in errors[0].iter().zip(errors[3]) {
        assert!(most / least > 250.0, "{most:e} {least:e}");
    }
}

#[test]
fn merging_keeps_the_force_exact_until_the_front_is_cut() {
    // Constant pressure asks for the integral alone, which merging keeps: while the bristles of a
    // step input are all inside, the force is exact, however few the slots.
    let mut rolling =
        patch(tyre(), PolynomialExponential::constant()).exact([Segment::default(); 22]).unwrap();
    let undeflected = |_: f64| 0.0;
    let mut history = History::new(&undeflected, &[]);
    for number in 0..990 {
        let v = if number % 2 == 0 { 1.0 } else { -0.3 };
        let force = rolling.step(motion(v, 200.0), 5e-6).unwrap();
        history.push(step_of(&tyre(), v, 200.0, 5e-6));
        if number % 33 == 0 {
            let stiffness = tyre().affine(v.into(), 0.0).stiffness;
            let want = LENGTH * stiffness * history.weighted(&|_| 1.0, 1.0);
            // A thousand steps, a rounding each.
            assert!((force - want).abs() < 1e-13 * LENGTH * 0.6, "{number}: {force:e} {want:e}");
        }
    }
}

#[test]
fn narrow_and_wide_steps_in_turns_fit_the_slots_and_stay_exact() {
    narrow_and_wide(30_000);
}

#[test]
#[ignore = "long: cargo test --release -p bristle-rolling --test rolling exact_limits -- --ignored"]
fn narrow_and_wide_steps_in_turns_fit_the_slots_for_a_million_steps() {
    narrow_and_wide(250_000);
}

fn narrow_and_wide(steps: usize) {
    // No narrow step follows another, so none is merged: as many segments as there can be.
    for slots in [22, 23, 41, 206] {
        let rolling = patch(tyre(), PolynomialExponential::parabolic());
        let mut rolling = rolling.exact(vec![Segment::default(); slots]).unwrap();
        let narrowest = rolling.narrowest();
        assert_eq!(narrowest, 2.0 / (slots as f64 - 6.0));
        let undeflected = |_: f64| 0.0;
        let mut history = History::new(&undeflected, &[]);
        let mut random = Random(slots as u64);
        let (mut most, mut worst) = (0, 0.0_f64);
        let mut wide_factor = 0.0;
        for number in 0..steps {
            if number % 1000 == 0 {
                wide_factor =
                    [1.0 + 1e-12, 1.0 + 1e-9, random.decades(1.0001, 4.0), 1.5][number / 1000 % 4];
            }
            let narrow = [1e-9, 1e-3, 0.999][number / 5000 % 3];
            let way = narrowest * if number % 2 == 0 { narrow } else { wide_factor };
            let v = 4.0 * (random.unit() - 0.5);
            let force = rolling.step(motion(v, 100.0), way / 100.0).unwrap();
            history.push(step_of(&tyre(), v, 100.0, way / 100.0));
            most = most.max(rolling.segments());
            assert!(rolling.segments() <= slots, "{number}: {}", rolling.segments());
            if number % 5003 == 17 {
                let stiffness = tyre().affine(v.into(), 0.0).stiffness;
                let p = |xi: f64| 6.0 * xi * (1.0 - xi);
                let want = LENGTH * stiffness * history.weighted(&p, 4.0);
                worst = worst.max((force - want).abs() / (LENGTH * 0.6));
            }
        }
        assert!(worst < 1e-13, "{worst:e}");
        assert!(most > slots / 2, "{most} of {slots}");
    }
}

#[test]
fn any_pattern_of_steps_fits_the_slots_and_respects_the_bounds() {
    let mut random = Random(2);
    for slots in [22, 27, 100] {
        let rolling = patch(tyre(), PolynomialExponential::constant());
        let mut rolling = rolling.exact(vec![Segment::default(); slots]).unwrap();
        let narrowest = rolling.narrowest();
        let (mut low, mut high) = (1.0, 1.0);
        for number in 0..40_000 {
            if number % 97 == 0 {
                low = random.decades(1e-6, 2.0);
                high = low * random.decades(1.0, 50.0);
            }
            let way = narrowest * random.decades(low, high);
            // Full sliding to both sides: the profile touches both bounds.
            let v = if random.unit() < 0.5 { -30.0 } else { 30.0 };
            let force = rolling.step(motion(v, 50.0), way / 50.0).unwrap();
            assert!(rolling.segments() <= slots, "{number}: {}", rolling.segments());
            // |z| ≤ max μ/σ0, and here all of it is μ(30 m/s)/σ0.
            let most = LENGTH * tyre().affine((30.0).into(), 0.0).stiffness * rolling_bound();
            assert!(force.abs() <= most * (1.0 + 1e-13), "{number}: {force:e} {most:e}");
            if number % 500 == 0 {
                for place in 0..=50 {
                    let z = rolling.deflection(f64::from(place) / 50.0);
                    assert!(z.abs() <= rolling_bound() * (1.0 + 1e-13), "{number}: {z:e}");
                }
            }
        }
    }
}

/// |z_ss| of sliding at 30 m/s.
fn rolling_bound() -> f64 {
    let affine = tyre().affine((30.0).into(), 0.0);
    affine.drive * 30.0 / affine.relaxation
}

#[test]
fn a_tiny_deflection_keeps_its_digits_through_merging_and_after_heavy_sliding() {
    for slots in [22, 64, 2006] {
        let rolling = patch(tyre(), PolynomialExponential::parabolic());
        let mut rolling = rolling.exact(vec![Segment::default(); slots]).unwrap();
        for _ in 0..3000 {
            rolling.step(motion(50.0, 100.0), 1e-5).unwrap();
        }
        for _ in 0..3000 {
            rolling.step(motion(1e-9, 100.0), 1e-5).unwrap();
        }
        let settled = rolling.step(motion(1e-9, 100.0), 1e-5).unwrap();
        // At such a slip z = v ξ/V, and F = L c₀ v/V ∫ξ p dξ, less a part of 1e-9.
        let affine = tyre().affine(1e-9.into(), 0.0);
        let kappa = affine.relaxation / 100.0;
        let want = LENGTH * affine.stiffness * 1e-9 / 100.0 * (0.5 - 0.15 * kappa);
        // A thousand steps a transit, a rounding each, and what merging costs: the profile is
        // straight but for κ.
        let tolerance = 1e-13 + 0.2 * rolling.narrowest().powi(3) * kappa;
        assert!((settled / want - 1.0).abs() < tolerance, "{slots}: {settled:e} {want:e}");
    }
}

#[test]
fn extreme_numbers_give_no_nan_and_no_wrong_force() {
    let mut rolling =
        patch(tyre(), PolynomialExponential::parabolic()).exact([Segment::default(); 40]).unwrap();
    let steady = |rolling: &mut ExactPatch<_, _, 3, _>| {
        let force = rolling.step(motion(3.0, 100.0), 1.0).unwrap();
        let affine = tyre().affine((3.0).into(), 0.0);
        let k = affine.relaxation / 100.0;
        let z = affine.drive * 3.0 / affine.relaxation;
        let left = (k - 2.0 + (k + 2.0) * (-k).exp()) / k.powi(3);
        let want = LENGTH * affine.stiffness * z * (1.0 - 6.0 * left);
        assert!((force - want).abs() < 1e-13 * want, "{force:e} {want:e}");
        force
    };
    let force = steady(&mut rolling);
    // Nothing moves.
    for (v, transport, h) in [
        (3.0, 1e-300, 1e-300),
        (3.0, 1e100, 1e-300),
        (3.0, 1e-200, 1e-100),
        (0.0, 1e-300, 1e100),
        (0.0, 5e-324, 1e100),
        (0.0, 0.0, 1e100),
        (1e-300, 1e-300, 1e-20),
    ] {
        for _ in 0..100 {
            rolling.step(motion(v, transport), h).unwrap();
        }
        // A hundred steps that change nothing, a rounding each.
        let now = rolling.force(3.0);
        assert!((now - force).abs() < 1e-13 * force, "{v:e} {transport:e} {h:e}: {now:e}");
    }
    // Bristles that stand and slide, or that all came in under the same velocity, for ever.
    let sliding = LENGTH * tyre().affine((3.0).into(), 0.0).stiffness * stationary(3.0);
    for (v, transport, h) in [
        (3.0, 0.0, 1e100),
        (3.0, 1e-300, 1e100),
        (3.0, 1e-100, 1e100),
        (3.0, 1e-90, 1e100),
        (3.0, 1e-9, 1e100),
        (1e100, 1e-100, 1e100),
    ] {
        let force = rolling.step(motion(v, transport), h).unwrap();
        let want = sliding * tyre().affine(v.into(), 0.0).stiffness
            / tyre().affine((3.0).into(), 0.0).stiffness
            * stationary(v)
            / stationary(3.0);
        // A boundary layer at the inlet: 1e-9 of the patch over 1e3.
        assert!(
            (force - want).abs() < 1e-11 * want,
            "{v:e} {transport:e} {h:e}: {force:e} {want:e}"
        );
    }
    // The patch crosses in no time: bristles have none to deflect.
    for transport in [1e30, 1e100] {
        let force = rolling.step(motion(3.0, transport), 1e-3).unwrap();
        let want = 0.5 * LENGTH * tyre().affine((3.0).into(), 0.0).stiffness * 3.0 / transport;
        assert!((force / want - 1.0).abs() < 1e-13, "{transport:e}: {force:e} {want:e}");
    }
    for (v, transport) in [(0.0, 5e-324), (3.0, 5e-324), (3.0, 1e-300), (0.0, 1e-300)] {
        rolling.settle(motion(v, transport)).unwrap();
        let want = LENGTH * tyre().affine((3.0).into(), 0.0).stiffness * stationary(v);
        let force = rolling.force(3.0);
        assert!((force - want).abs() <= 1e-13 * want, "{v:e} {transport:e}: {force:e} {want:e}");
    }
    steady(&mut rolling);
}

/// z_ss at a velocity, 0 at rest.
fn stationary(v: f64) -> f64 {
    let affine = tyre().affine(v.into(), 0.0);
    if v == 0.0 { 0.0 } else { affine.drive * v / affine.relaxation }
}

#[test]
fn random_extremes_stay_finite_and_bounded() {
    let mut random = Random(17);
    let mut rolling =
        patch(tyre(), PolynomialExponential::parabolic()).exact([Segment::default(); 30]).unwrap();
    for number in 0..100_000 {
        let v = [0.0, 1.0, -1.0][number % 3] * random.decades(1e-100, 1e100);
        let transport = if random.unit() < 0.1 { 0.0 } else { random.decades(1e-200, 1e100) };
        let h = if random.unit() < 0.7 && transport > 1e-90 {
            random.decades(1e-4, 2.0) / transport
        } else {
            random.decades(1e-200, 1e100)
        };
        let force = rolling.step(motion(v, transport), h).unwrap();
        // μ grows with v: the bound is that of the greatest so far, so read it as a coefficient.
        let grip = LENGTH * (0.6 + 0.0018 * 1e100);
        assert!(
            force.abs() <= grip * (1.0 + 1e-12),
            "{number}: {v:e} {transport:e} {h:e} {force:e}"
        );
    }
}

#[test]
fn bad_input_is_refused_by_name_and_changes_nothing() {
    let parabola = patch(tyre(), PolynomialExponential::parabolic());
    for count in [0, 1, 21] {
        let refused = parabola.exact(vec![Segment::default(); count]).unwrap_err();
        assert_eq!((refused.name, refused.value), ("segments", count as f64));
        assert_eq!(refused.rule, Rule::Count { least: 22 });
    }
    let refused = parabola.exact_in(7).unwrap_err();
    assert_eq!((refused.name, refused.value), ("segments", 7.0));
    // No allocation that aborts.
    for segments in [10_000_001, 1_000_000_000_000, usize::MAX] {
        assert_eq!(parabola.exact_in(segments).unwrap_err().name, "segments");
    }
    let mut rolling = parabola.exact_in(50).unwrap();
    for number in 0..40 {
        rolling.step(motion(f64::from(number) - 20.0, 10.0), 3e-3).unwrap();
    }
    let before = format!("{rolling:?}");
    let (nan, infinite) = (f64::NAN, f64::INFINITY);
    let refused = [
        ("slip_velocity", motion(nan, 1.0), 1.0),
        ("slip_velocity", motion(infinite, 1.0), 1.0),
        ("slip_velocity", motion(-infinite, 1.0), 1.0),
        ("rolling_speed", motion(1.0, nan), 1.0),
        ("rolling_speed", motion(1.0, -1e-300), 1.0),
        ("rolling_speed", motion(1.0, infinite), 1.0),
        ("duration", motion(1.0, 1.0), nan),
        ("duration", motion(1.0, 1.0), -1e-300),
        ("duration", motion(1.0, 1.0), infinite),
    ];
    for (name, motion, duration) in refused {
        assert_eq!(rolling.step(motion, duration).unwrap_err().name, name);
        if duration == 1.0 {
            assert_eq!(rolling.settle(motion).unwrap_err().name, name);
        }
    }
    let hole = |xi: f64| if xi == 0.25 { nan } else { 1e-3 };
    let refused = rolling.set_profile(4, hole).unwrap_err();
    assert_eq!((refused.name, refused.component), ("deflection", Some(1)));
    assert_eq!(rolling.set_profile(4, |_| infinite).unwrap_err().component, Some(0));
    assert_eq!(rolling.set_profile(0, |_| 0.0).unwrap_err().name, "segments");
    assert_eq!(rolling.set_profile(55, |_| 0.0).unwrap_err().name, "segments");
    for load in [-1.0, nan] {
        assert_eq!(rolling.reload(load, 0.0).unwrap_err().name, "normal_force");
        assert_eq!(rolling.renew(load).unwrap_err().name, "normal_force");
    }
    assert_eq!(format!("{rolling:?}"), before);
    assert!(rolling.set_profile(54, |_| 0.0).is_ok());
}

#[test]
fn a_patch_allocates_nothing_in_slots_of_its_caller() {
    let mut slots = [Segment::default(); 100];
    let counted = allocation_counter::measure(|| {
        let mut rolling =
            patch(tyre(), PolynomialExponential::parabolic()).exact(&mut slots[..]).unwrap();
        rolling.set_profile(10, |xi| 1e-3 * xi).unwrap();
        let mut random = Random(3);
        for _ in 0..5000 {
            let way = random.decades(1e-6, 2.0);
            rolling.step(motion(random.unit() - 0.5, 10.0), way / 10.0).unwrap();
        }
        rolling.settle(motion(1.0, 10.0)).unwrap();
    });
    assert_eq!(counted.count_total, 0);
}

#[test]
fn single_precision_follows_double() {
    let curve = Stribeck::new(bristle::curve::StribeckParameters {
        static_coefficient: 0.6_f32,
        dynamic_coefficient: 0.2,
        stribeck_velocity: 10.0,
        stribeck_exponent: 2.0,
        viscous_friction: 0.0018,
    })
    .unwrap();
    let bristle =
        bristle::rheology::KelvinVoigtParameters { micro_stiffness: 252.0_f32, micro_damping: 0.0 };
    let model = FrBd::new(curve, KelvinVoigt::new(bristle).unwrap());
    let parameters = PatchParameters {
        model,
        length: 0.1_f32,
        pressure: PolynomialExponential::<f32, 3>::parabolic(),
    };
    let mut single = Patch::new(parameters).unwrap().exact([Segment::default(); 200]).unwrap();
    let mut double =
        patch(tyre(), PolynomialExponential::parabolic()).exact([Segment::default(); 200]).unwrap();
    let mut random = Random(31);
    for number in 0..20_000 {
        let way = if number % 100 == 0 { 0.0 } else { random.decades(1e-3, 0.5) as f32 };
        let v = (4.0 * (random.unit() - 0.5)) as f32;
        let (transport, h) = (100.0_f32, way / 100.0);
        let got = Motion { slip_velocity: v, rolling_speed: 0.1 * transport };
        let got = single.step(got, h).unwrap();
        let want = double.step(motion(v.into(), transport.into()), h.into()).unwrap();
        // Some hundred steps a transit, a rounding of 6e-8 each, which mostly cancel: ten of them
        // were measured, 6.3e-7.
        assert!((f64::from(got) - want).abs() < 2e-6 * LENGTH * 0.6, "{number}: {got} {want}");
    }
}

#[test]
fn a_curve_that_has_no_answer_does_not_stay_in_the_patch() {
    const NAMED: &str = "relaxation rate of the friction model";
    let bounds = bristle::Bounds { min: 0.6, max: 0.6 };
    let coefficient = |speed: f64| (if speed > 2.0 { f64::NAN } else { 0.6 }, 0.0);
    let curve = bristle::curve::FunctionCurve::new(coefficient, bounds).unwrap();
    let model = FrBd::new(curve, KelvinVoigt::new(paper::TYRE_BRISTLE).unwrap());
    let pressure = PolynomialExponential::constant();
    let patch = Patch::new(PatchParameters { model, length: LENGTH, pressure }).unwrap();
    let mut rolling = patch.exact([Segment::default(); 22]).unwrap();
    let force = rolling.step(motion(1.0, 10.0), 1e-3).unwrap();
    assert_eq!(rolling.step(motion(3.0, 10.0), 1e-3).unwrap_err().name, NAMED);
    assert_eq!(rolling.settle(motion(3.0, 10.0)).unwrap_err().name, NAMED);
    let slip_velocity = 3.0;
    let over_time = Motion { slip_velocity, rolling_speed: slip_velocity };
    let refused = rolling.follow(&over_time, 0.0..1e-3).unwrap_err();
    assert_eq!(refused.name, NAMED);
    assert_eq!(rolling.force(1.0), force);
}
