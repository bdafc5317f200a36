//! Loops within loops, in slow motion: the figures of a table that was computed independently.
//! Force at 120 µm after 0 → 120 → 60 → 120 µm, against before; and force at 80 µm before and after
//! 50 loops 80 → 60 → 80.

use bristle::{Bristle, Dahl, DahlParameters};
use bristle_memory::{Element, MaxwellSlip, MaxwellSlipParameters, Parallel};

use super::{coulomb, even, slip, zeros};

/// Steps of 0.05 µm: α is frozen over each, (1 − ρ) of the shortest yield length is ten of them.
const STEP: f64 = 5e-8;

/// What a path through the given places [µm] leaves of a state and a force.
fn along<X: Copy>(start: X, places: &[i32], step: &impl Fn(X, f64) -> (X, f64)) -> (X, f64) {
    let (mut x, mut force) = (start, 0.0);
    for leg in places.windows(2) {
        let distance = f64::from(leg[1] - leg[0]) * 1e-6;
        let count = (distance.abs() / STEP).round() as usize;
        for _ in 0..count {
            (x, force) = step(x, distance / count as f64);
        }
    }
    (x, force)
}

/// Miss of the loop, force before the fifty and after.
fn figures<X: Copy>(start: X, step: impl Fn(X, f64) -> (X, f64)) -> [f64; 3] {
    let (x, outer) = along(start, &[0, 120], &step);
    let (_, closed) = along(x, &[120, 60, 120], &step);
    let (mut x, before) = along(start, &[0, 80], &step);
    let mut after = before;
    for _ in 0..50 {
        (x, after) = along(x, &[80, 60, 80], &step);
    }
    [closed - outer, before, after]
}

/// Slow steps of a model by `hold`: 1 s each.
fn held<M: Bristle<f64>>(model: M) -> impl Fn(M::Deflection, f64) -> (M::Deflection, f64) {
    move |x, displacement| {
        let held = model.hold(displacement, x, 1.0);
        (held.deflection, held.end_coefficient)
    }
}

#[track_caller]
fn same(got: [f64; 3], want: [f64; 3], tolerance: f64) {
    for (got, want) in got.iter().zip(want) {
        assert!((got - want).abs() <= tolerance, "{got} is not {want}");
    }
}

#[test]
fn one_deflection_forgets() {
    let dahl = DahlParameters { dynamic_coefficient: 1.0, micro_stiffness: 1e4 };
    let dahl = Dahl::new(dahl).unwrap();
    // Half a unit of the last digit.
    same(figures(0.0, held(dahl)), [-0.285, 0.551, 0.100], 6e-4);
}

#[test]
fn ten_deflections_that_are_plastic_from_the_beginning_forget_as_well() {
    let ten = even::<10>().map(|Element { stiffness, yield_length }| {
        let dynamic_coefficient = stiffness * yield_length;
        Dahl::new(DahlParameters { dynamic_coefficient, micro_stiffness: stiffness }).unwrap()
    });
    let step = |mut z: [f64; 10], displacement: f64| {
        let mut force = 0.0;
        for (z, model) in z.iter_mut().zip(&ten) {
            let held = model.hold(displacement, *z, 1.0);
            (*z, force) = (held.deflection, force + held.end_coefficient);
        }
        (z, force)
    };
    same(figures([0.0; 10], step), [-0.219, 0.486, 0.097], 6e-4);
}

#[test]
fn one_elasto_plastic_element_forgets_less() {
    let element = Element { stiffness: 1e4, yield_length: 1e-4 };
    let model = MaxwellSlip::new(MaxwellSlipParameters {
        curve: coulomb(),
        elements: [element],
        micro_damping: 0.0,
        stick_ratio: 0.5,
    });
    same(figures(zeros::<1>(), held(model.unwrap())), [-0.091, 0.756, 0.570], 6e-4);
}

#[test]
fn ten_elements_remember_better_the_closer_their_stick_limit_is_to_their_yield() {
    for (ratio, want) in [
        (0.5, [-0.051, 0.619, 0.521]),
        (0.8, [-0.020, 0.636, 0.607]),
        (0.95, [-0.0054, 0.640, 0.633]),
    ] {
        same(figures(zeros(), held(slip::<_, 10>(coulomb(), 0.0, ratio))), want, 6e-4);
    }
}

#[test]
fn sharp_elements_remember_exactly() {
    let model = slip::<_, 10>(coulomb(), 0.0, 0.95);
    let sharp = |x: Parallel<f64, 10>, displacement: f64| {
        let step = model.sharp_step(0.0, displacement, x);
        (step.deflection, step.coefficient)
    };
    let [miss, before, after] = figures(zeros(), sharp);
    // Ten thousand increments of 5e-8 m, each rounded at 1e-4 m, times a stiffness of 1e4 1/m.
    assert!(miss.abs() < 1e-12 && (after - before).abs() < 1e-12, "{miss:e}, {before}, {after}");
    assert!((before - 0.640).abs() < 1e-12);
    // In one leap as in small steps: the largest displacement alone counts.
    let leap = model.sharp_step(0.0, 8e-5, zeros());
    assert!((leap.coefficient - before).abs() < 1e-12);
    // Eight elements have yielded at 160 µm; two springs are left.
    assert_eq!(model.sharp_step(0.0, 1.6e-4, zeros()).stiffness, 2e3);
}

#[test]
fn smooth_elements_come_to_the_sharp_ones_as_the_stick_ratio_comes_to_one() {
    let far = |ratio: f64| {
        let model = slip::<_, 10>(coulomb(), 0.0, ratio);
        let path = [0, 150, -70, 40, 10, 120];
        let (_, smooth) = along(zeros(), &path, &held(model));
        let sharp = |x: Parallel<f64, 10>, displacement: f64| {
            let step = model.sharp_step(0.0, displacement, x);
            (step.deflection, step.coefficient)
        };
        (smooth - along(zeros(), &path, &sharp).1).abs()
    };
    // What an element lacks is in proportion to 1 − ρ.
    let [coarse, fine] = [far(0.8), far(0.95)];
    assert!(fine < 0.4 * coarse && fine < 0.02, "{coarse} and {fine}");
}

#[test]
fn loops_follow_masings_rules() {
    // After a reversal at X the branch is the virgin curve doubled: F(X) − F(X − u) = 2 V(u/2).
    let elements = even::<10>();
    let model = slip::<_, 10>(coulomb(), 0.0, 0.95);
    for (out, back) in [(50e-6, 20e-6), (140e-6, 100e-6), (140e-6, 260e-6)] {
        let top = model.sharp_step(0.0, out, zeros());
        let end = model.sharp_step(0.0, -back, top.deflection);
        let want = 2.0 * bristle_memory::virgin::coefficient(&elements, 0.5 * back);
        // Sums of ten terms of up to one.
        assert!((top.coefficient - end.coefficient - want).abs() < 1e-14, "{out} and {back}");
    }
}
