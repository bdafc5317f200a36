//! The exact reduction of a rolling patch at its limits: tiny and huge steps, merged segments,
//! little memory, single precision, bad input.

use crate::characteristics::History;
use crate::tyre::{
    LENGTH, STIFFNESS, constant, exponential, frbd_of, motion, parabolic, patch, step_of, tyre,
};
use bristle::Bristle;
use bristle::signal::Function;
use bristle_rolling::{Motion, PolynomialExponential, Pressure, Segment};
use bristle_specimens::assert_within;
use bristle_specimens::draw::Draw;

const WAY: f64 = 1.0 / 2048.0;

const SLOTS: [usize; 4] = [22, 38, 70, 134];

/// The greatest error of the force with each number of slots while steps of V h = [`WAY`] are
/// merged, over that of full deflection.
fn merged_errors<const N: usize>(
    pressure: PolynomialExponential<f64, N>,
    velocity: &dyn Fn(usize) -> f64,
) -> [f64; 4] {
    let mut rolling = SLOTS.map(|slots| patch(tyre(), pressure).exact([slots_of(slots)]).unwrap());
    let mut history = History::new(&|_| 0.0, &[]);
    let (mut worst, h) = ([0.0_f64; 4], WAY / 400.0);
    for number in 0..3 * 2048 {
        let v = velocity(number);
        let forces = rolling.each_mut().map(|it| it.step(motion(v, 400.0), h).unwrap());
        history.push(step_of(&tyre(), v, 400.0, h));
        if number % 38 == 11 {
            let want = force_of(&history, |xi| pressure.at(xi));
            for (worst, force) in worst.iter_mut().zip(forces) {
                *worst = worst.max((force - want).abs() / (LENGTH * 0.6));
            }
        }
    }
    worst
}

fn slots_of<const N: usize>(count: usize) -> Vec<Segment<f64, N>> {
    vec![Segment::default(); count]
}

/// That of the characteristics, whose springs do not depend on the velocity.
fn force_of(history: &History<'_>, pressure: impl Fn(f64) -> f64) -> f64 {
    LENGTH * STIFFNESS * history.weighted(&pressure, 4.0)
}

#[test]
fn merged_steps_err_by_the_cube_of_their_width_and_by_its_square_where_the_velocity_jumps() {
    let smooth = |n: usize| 0.4 + 2.0 * (n as f64 * WAY * 7.3).sin();
    // A new velocity every 0.173 of the patch.
    let jumps = |n: usize| 3.0 * (Draw((n as f64 * WAY / 0.173) as u64 * 77 + 5).next() - 0.5);
    let of = |velocity: &dyn Fn(usize) -> f64| {
        [
            merged_errors(constant(), velocity),
            merged_errors(exponential(1.0), velocity),
            merged_errors(parabolic(), velocity),
        ]
    };
    for (smooth, jumps) in of(&smooth).into_iter().zip(of(&jumps)) {
        for (i, slots) in SLOTS.into_iter().enumerate() {
            let narrowest = 2.0 / (slots - 6) as f64;
            // The slope of the profile changes by about 20 full deflections over the patch. The
            // factor is measured: 0.10 for constant, 0.06 for exponential, 0.18 for parabolic
            // pressure.
            assert!(smooth[i] < 0.2 * narrowest.powi(3), "{narrowest}: {smooth:?}");
            // Measured 0.033 at most.
            assert!(jumps[i] < 0.05 * narrowest.powi(2), "{narrowest}: {jumps:?}");
        }
        // Four times three halvings of the width: third order.
        assert!(smooth[0] / smooth[3] > 250.0, "{smooth:?}");
    }
}

#[test]
fn merging_keeps_the_force_exact_until_the_front_is_cut() {
    // Constant pressure asks for the integral alone, which merging keeps: while the bristles of a
    // step input are all inside, the force is exact, however few the slots.
    let mut rolling = patch(tyre(), constant()).exact([[Segment::default(); 22]]).unwrap();
    let mut history = History::new(&|_| 0.0, &[]);
    for number in 0..990 {
        let v = if number % 2 == 0 { 1.0 } else { -0.3 };
        let force = rolling.step(motion(v, 200.0), 5e-6).unwrap();
        history.push(step_of(&tyre(), v, 200.0, 5e-6));
        if number % 33 == 0 {
            let want = force_of(&history, |_| 1.0);
            // A thousand steps, a rounding each.
            assert!((force - want).abs() < 1e-13 * LENGTH * 0.6, "{number}: {force:e} {want:e}");
        }
    }
}

#[test]
fn narrow_and_wide_steps_in_turns_fit_the_slots_and_stay_exact() {
    narrow_and_wide(30_000);
}

fn narrow_and_wide(steps: usize) {
    // No narrow step follows another, so none is merged: as many segments as there can be.
    for slots in [22, 23, 41, 206] {
        let mut rolling = patch(tyre(), parabolic()).exact([slots_of(slots)]).unwrap();
        let narrowest = rolling.narrowest();
        assert_eq!(narrowest, 2.0 / (slots as f64 - 6.0));
        let mut history = History::new(&|_| 0.0, &[]);
        let mut random = Draw(slots as u64);
        let (mut most, mut worst) = (0, 0.0_f64);
        let mut wide_factor = 0.0;
        for number in 0..steps {
            if number % 1000 == 0 {
                wide_factor = [1.0 + 1e-12, 1.0 + 1e-9, random.logarithmic(1.0001, 4.0), 1.5]
                    [number / 1000 % 4];
            }
            let narrow = [1e-9, 1e-3, 0.999][number / 5000 % 3];
            let way = narrowest * if number % 2 == 0 { narrow } else { wide_factor };
            let v = 4.0 * (random.next() - 0.5);
            let force = rolling.step(motion(v, 100.0), way / 100.0).unwrap();
            history.push(step_of(&tyre(), v, 100.0, way / 100.0));
            most = most.max(rolling.segments());
            assert!(rolling.segments() <= slots, "{number}: {}", rolling.segments());
            if number % 5003 == 17 {
                let want = force_of(&history, |xi| 6.0 * xi * (1.0 - xi));
                worst = worst.max((force - want).abs() / (LENGTH * 0.6));
            }
        }
        assert!(worst < 1e-13, "{worst:e}");
        assert!(most > slots / 2, "{most} of {slots}");
    }
}

#[test]
fn any_pattern_of_steps_fits_the_slots_and_respects_the_bounds() {
    let mut random = Draw(2);
    // |z| ≤ max μ/σ0, and here all of it is μ(30 m/s)/σ0.
    let widest = tyre().stationary(30.0) * (1.0 + 1e-13);
    let strongest = LENGTH * tyre().stationary_coefficient(30.0) * (1.0 + 1e-13);
    for slots in [22, 27, 100] {
        let mut rolling = patch(tyre(), constant()).exact([slots_of(slots)]).unwrap();
        let narrowest = rolling.narrowest();
        let (mut low, mut high) = (1.0, 1.0);
        for number in 0..40_000 {
            if number % 97 == 0 {
                low = random.logarithmic(1e-6, 2.0);
                high = low * random.logarithmic(1.0, 50.0);
            }
            let way = narrowest * random.logarithmic(low, high);
            // Full sliding to both sides: the profile touches both bounds.
            let v = if random.next() < 0.5 { -30.0 } else { 30.0 };
            let force = rolling.step(motion(v, 50.0), way / 50.0).unwrap();
            assert!(rolling.segments() <= slots, "{number}: {}", rolling.segments());
            assert!(force.abs() <= strongest, "{number}: {force:e}");
            if number % 500 == 0 {
                for place in 0..=50 {
                    let z = rolling.deflection(f64::from(place) / 50.0);
                    assert!(z.abs() <= widest, "{number}: {z:e}");
                }
            }
        }
    }
}

#[test]
fn a_tiny_deflection_keeps_its_digits_through_merging_and_after_heavy_sliding() {
    for slots in [22, 64, 2006] {
        let mut rolling = patch(tyre(), parabolic()).exact([slots_of(slots)]).unwrap();
        for _ in 0..3000 {
            rolling.step(motion(50.0, 100.0), 1e-5).unwrap();
        }
        for _ in 0..3000 {
            rolling.step(motion(1e-9, 100.0), 1e-5).unwrap();
        }
        let settled = rolling.step(motion(1e-9, 100.0), 1e-5).unwrap();
        // At such a slip z = v ξ/V, and F = L c₀ v/V ∫ξ p dξ, less a part of 1e-9.
        let kappa = tyre().affine(1e-9.into(), 0.0).relaxation / 100.0;
        let want = LENGTH * STIFFNESS * 1e-9 / 100.0 * (0.5 - 0.15 * kappa);
        // A thousand steps a transit, a rounding each, and what merging costs: the profile is
        // straight but for κ.
        let tolerance = 1e-13 + 0.2 * rolling.narrowest().powi(3) * kappa;
        assert!((settled / want - 1.0).abs() < tolerance, "{slots}: {settled:e} {want:e}");
    }
}

#[test]
fn extreme_numbers_give_no_nan_and_no_wrong_force() {
    let mut rolling = patch(tyre(), parabolic()).exact([[Segment::default(); 40]]).unwrap();
    let steady = rolling.patch().steady(motion(3.0, 100.0)).unwrap().force;
    let near = |got: f64, want: f64, tolerance: f64, what: [f64; 3]| {
        assert_within(tolerance, want, got, want, || format!("{what:?}"));
    };
    let settled = [3.0, 100.0, 1.0];
    near(rolling.step(motion(3.0, 100.0), 1.0).unwrap(), steady, 1e-13, settled);
    // Nothing moves.
    for [v, transport, h] in [
        [3.0, 1e-300, 1e-300],
        [3.0, 1e100, 1e-300],
        [3.0, 1e-200, 1e-100],
        [0.0, 1e-300, 1e100],
        [0.0, 5e-324, 1e100],
        [0.0, 0.0, 1e100],
        [1e-300, 1e-300, 1e-20],
    ] {
        for _ in 0..100 {
            rolling.step(motion(v, transport), h).unwrap();
        }
        // A hundred steps that change nothing, a rounding each.
        near(rolling.force(3.0), steady, 1e-13, [v, transport, h]);
    }
    // Bristles that stand and slide, or that all came in under the same velocity, for ever.
    for [v, transport] in
        [[3.0, 0.0], [3.0, 1e-300], [3.0, 1e-100], [3.0, 1e-90], [3.0, 1e-9], [1e100, 1e-100]]
    {
        let force = rolling.step(motion(v, transport), 1e100).unwrap();
        // A boundary layer at the inlet: 1e-9 of the patch over 1e3.
        let want = LENGTH * tyre().stationary_coefficient(v);
        near(force, want, 1e-11, [v, transport, 1e100]);
    }
    // The patch crosses in no time: bristles have none to deflect.
    for transport in [1e30, 1e100] {
        let force = rolling.step(motion(3.0, transport), 1e-3).unwrap();
        near(force, LENGTH * STIFFNESS * 1.5 / transport, 1e-13, [3.0, transport, 1e-3]);
    }
    for [v, transport] in [[0.0, 5e-324], [3.0, 5e-324], [3.0, 1e-300], [0.0, 1e-300]] {
        rolling.settle(motion(v, transport)).unwrap();
        let want = LENGTH * STIFFNESS * tyre().stationary(v);
        near(rolling.force(3.0), want, 1e-13, [v, transport, f64::INFINITY]);
    }
    near(rolling.step(motion(3.0, 100.0), 1.0).unwrap(), steady, 1e-13, settled);
}

#[test]
fn random_extremes_stay_finite_and_bounded() {
    let mut random = Draw(17);
    let mut rolling = patch(tyre(), parabolic()).exact([[Segment::default(); 30]]).unwrap();
    for number in 0..100_000 {
        let v = [0.0, 1.0, -1.0][number % 3] * random.logarithmic(1e-100, 1e100);
        let transport = if random.next() < 0.1 { 0.0 } else { random.logarithmic(1e-200, 1e100) };
        let h = if random.next() < 0.7 && transport > 1e-90 {
            random.logarithmic(1e-4, 2.0) / transport
        } else {
            random.logarithmic(1e-200, 1e100)
        };
        let force = rolling.step(motion(v, transport), h).unwrap();
        // μ grows with v: the bound is that of the greatest so far, so read it as a coefficient.
        let grip = LENGTH * (0.6 + 0.0018 * 1e100);
        let within = force.abs() <= grip * (1.0 + 1e-12);
        assert!(within, "{number}: {v:e} {transport:e} {h:e} {force:e}");
    }
}

#[test]
fn a_patch_allocates_nothing_in_slots_of_its_caller() {
    let mut slots = [Segment::default(); 100];
    let swing = Function::new(|t: f64| ((90.0 * t).sin(), 90.0 * (90.0 * t).cos()), []);
    let signals = Motion { slip_velocity: swing, rolling_speed: 2.0 };
    let counted = allocation_counter::measure(|| {
        let mut rolling = patch(tyre(), parabolic()).exact([&mut slots[..]]).unwrap();
        let mut random = Draw(3);
        for number in 0..5000 {
            let way = random.logarithmic(1e-6, 2.0);
            rolling.step(motion(random.next() - 0.5, 10.0), way / 10.0).unwrap();
            let time = 1e-3 * f64::from(number);
            rolling.follow(&signals, time..time + 1e-3).unwrap();
        }
        rolling.settle(motion(1.0, 10.0)).unwrap();
    });
    assert_eq!(counted.count_total, 0);
}

#[test]
fn single_precision_follows_double() {
    let mut single = patch(frbd_of::<f32>(0.0), parabolic()).exact_in(200).unwrap();
    let mut double = patch(tyre(), parabolic()).exact_in(200).unwrap();
    let mut random = Draw(31);
    for number in 0..20_000 {
        let way = if number % 100 == 0 { 0.0 } else { random.logarithmic(1e-3, 0.5) as f32 };
        let (v, h) = ((4.0 * (random.next() - 0.5)) as f32, way / 100.0);
        let got = single.step(Motion { slip_velocity: v, rolling_speed: 10.0 }, h).unwrap();
        let want = double.step(motion(v.into(), 100.0), h.into()).unwrap();
        // Some hundred steps a transit, a rounding of 6e-8 each, which mostly cancel: ten of them
        // were measured, 6.3e-7.
        assert!((f64::from(got) - want).abs() < 2e-6 * LENGTH * 0.6, "{number}: {got} {want}");
    }
}
