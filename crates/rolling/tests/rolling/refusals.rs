//! What a patch must not take, or must take like its neighbour.

use crate::combined::Rubber;
use crate::tyre::{constant, frbd, loaded, lugre, motion, parabolic, patch, tyre};
use bristle::curve::FunctionCurve;
use bristle::regularisation::SquareRoot;
use bristle::{Bounds, FrBd, Rule};
use bristle_rolling::{CombinedGrid, ExactPatch, Grid, Motion, PolynomialExponential, Segment};
use nalgebra::Vector2;

const NAN: f64 = f64::NAN;
const INFINITE: f64 = f64::INFINITY;

#[test]
fn minus_zero_is_zero() {
    let motion = |rolling_speed| Motion { slip_velocity: 1.0, rolling_speed };
    let force = |speed| loaded(tyre(), constant()).steady(motion(speed)).unwrap().force;
    assert_eq!(force(-0.0), force(0.0));
    // Regularised bristles relax at rest too.
    let soft = loaded(tyre().regularised(SquareRoot::new(1e-4).unwrap()), constant());
    let still = soft.steady(Motion { slip_velocity: 0.0, rolling_speed: -0.0 }).unwrap();
    assert_eq!(still.force, 0.0);
    let mut rolling = soft.exact([[Segment::default(); 30]]).unwrap();
    assert!(rolling.step(motion(-0.0), 1e-3).unwrap() > 0.0);
}

/// A pattern of steps that once filled the slots: narrow ones, and between them long ones that are
/// looked at and dropped.
#[test]
fn steps_that_are_dropped_do_not_fill_the_slots() {
    fn each<const N: usize>(pressure: PolynomialExponential<f64, N>, slots: usize) {
        let mut rolling = patch(tyre(), pressure).exact([vec![Segment::default(); slots]]).unwrap();
        rolling.settle(motion(0.5, 160.0)).unwrap();
        let expected = rolling.force(0.5);
        let drop_one = |rolling: &mut ExactPatch<f64, _, N, _>, way: f64| {
            assert!(rolling.companion_step(motion(-3.0, 160.0), way / 160.0).is_ok());
        };
        for number in 0..600 + 2 * slots {
            let way = rolling.narrowest() * [0.01, 0.4, 0.1][number % 3];
            let force = rolling.step(motion(0.5, 160.0), way / 160.0).unwrap();
            drop_one(&mut rolling, [0.3, 0.9, 2.0][number % 3]);
            assert!(rolling.segments() <= slots, "{} of {slots}", rolling.segments());
            // The law of merging, see `ExactPatch`.
            let off = (force / expected - 1.0).abs();
            assert!(off < 0.2 * rolling.narrowest().powi(2), "{number}: off by {off:e}");
        }
    }
    for slots in [22, 50, 300] {
        each(constant(), slots);
        each(parabolic(), slots);
    }
}

#[test]
fn a_curve_that_is_no_number_is_named_and_does_not_stay_in_the_patch() {
    for value in [NAN, INFINITE, -0.5] {
        // The closure breaks its promise.
        let coefficient = move |speed: f64| (if speed > 2.0 { value } else { 0.6 }, 0.0);
        let curve = FunctionCurve::new(coefficient, Bounds { min: 0.1, max: 1.0 }).unwrap();
        let patch = loaded(FrBd::new(curve, *tyre().rheology()), constant());
        let mut rolling = patch.exact([[Segment::default(); 30]]).unwrap();
        let force = rolling.step(motion(1.0, 100.0), 1e-3).unwrap();
        let fast = motion(3.0, 100.0);
        for error in [
            patch.steady(fast).unwrap_err(),
            patch.peak(fast).unwrap_err(),
            patch.pneumatic_trail(fast).unwrap_err(),
            patch.linearised(fast).unwrap_err(),
            rolling.step(fast, 1e-3).unwrap_err(),
            rolling.step(Motion { rolling_speed: 0.0, ..fast }, 0.0).unwrap_err(),
            rolling.settle(fast).unwrap_err(),
            rolling.follow(&fast, 0.0..1e-3).unwrap_err(),
            rolling.companion_step(fast, 1e-3).unwrap_err(),
        ] {
            assert_eq!(error.name, "relaxation rate of the friction model");
        }
        assert_eq!(rolling.force(1.0), force);
    }
}

#[test]
fn what_is_too_large_for_a_mean_force_is_refused() {
    let mut rolling = loaded(lugre(1.0), constant()).exact([[Segment::default(); 30]]).unwrap();
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

#[test]
fn a_motion_that_is_none_is_named_and_changes_nothing() {
    let line = patch(frbd(0.5), parabolic());
    let plane = crate::combined::patch(Rubber::TREAD.model(), parabolic());
    let (mut exact, mut grid) = (line.exact_in(50).unwrap(), Grid::new(&line, 10).unwrap());
    let mut two = plane.exact_in(50).unwrap();
    let mut cells = CombinedGrid::new(&plane, 10).unwrap();
    let good = motion(0.3, 10.0);
    let field = |motion: Motion<f64>| Motion {
        // Somewhere in the patch only, after nodes that were well.
        slip_velocity: move |place, _| if place > 0.75 { motion.slip_velocity } else { 1.0 },
        rolling_speed: move |_, _| motion.rolling_speed,
    };
    let turned = |Motion { slip_velocity, rolling_speed }: Motion<f64>| Motion {
        slip_velocity: Vector2::new(0.2, slip_velocity),
        rolling_speed,
    };
    let turned_field = |motion: Motion<f64>| {
        let Motion { slip_velocity, rolling_speed } = field(motion);
        Motion { slip_velocity: move |x, t| Vector2::new(0.2, slip_velocity(x, t)), rolling_speed }
    };
    exact.step(good, 3e-3).unwrap();
    grid.step(good, 3e-3).unwrap();
    two.step(turned(good), 3e-3).unwrap();
    cells.step_field(&turned_field(good), 3e-3).unwrap();
    let before = (format!("{exact:?}"), grid.clone(), two.clone(), cells.clone());
    for (name, motion, duration) in [
        ("slip_velocity", motion(NAN, 1.0), 1.0),
        ("slip_velocity", motion(INFINITE, 1.0), 1.0),
        ("slip_velocity", motion(-INFINITE, 1.0), 1.0),
        ("rolling_speed", motion(1.0, NAN), 1.0),
        ("rolling_speed", motion(1.0, INFINITE), 1.0),
        ("rolling_speed", motion(1.0, -1e-300), 1.0),
        ("duration", motion(1.0, 1.0), NAN),
        ("duration", motion(1.0, 1.0), INFINITE),
        ("duration", motion(1.0, 1.0), -1e-300),
    ] {
        assert_eq!(exact.step(motion, duration).unwrap_err().name, name);
        assert_eq!(exact.companion_step(motion, duration).unwrap_err().name, name);
        let component = (name == "slip_velocity").then_some(1);
        for error in [
            two.step(turned(motion), duration).unwrap_err(),
            two.companion_step(turned(motion), duration).unwrap_err(),
        ] {
            assert_eq!((error.name, error.component), (name, component));
        }
        // A grid rolls backwards, too.
        if !(motion.rolling_speed < 0.0) {
            assert_eq!(grid.step(motion, duration).unwrap_err().name, name);
            assert_eq!(grid.step_field(&field(motion), duration).unwrap_err().name, name);
            let error = cells.step_field(&turned_field(motion), duration).unwrap_err();
            assert_eq!((error.name, error.component), (name, component));
        }
        if name != "duration" {
            for error in [
                exact.settle(motion).unwrap_err(),
                line.steady(motion).unwrap_err(),
                line.pneumatic_trail(motion).unwrap_err(),
                line.linearised(motion).unwrap_err(),
                two.settle(turned(motion)).unwrap_err(),
                plane.combined_steady(turned(motion)).unwrap_err(),
                plane.combined_linearised(turned(motion)).unwrap_err(),
            ] {
                assert_eq!(error.name, name);
            }
        }
    }
    assert!(format!("{exact:?}") == before.0);
    assert_eq!(grid.deflections(), before.1.deflections());
    assert_eq!(cells.deflections(), before.3.deflections());
    let v = Vector2::new(0.1, 0.2);
    assert_eq!(two.force(v), before.2.force(v));
}

#[test]
fn what_a_mechanism_has_found_must_be_a_velocity_or_it_would_stay_in_the_patch() {
    let mut one = patch(frbd(0.5), parabolic()).exact_in(50).unwrap();
    let plane = crate::combined::patch(Rubber::TREAD.model(), parabolic());
    let mut two = plane.exact_in(50).unwrap();
    let v = Vector2::new(0.2, 0.3);
    let (along, turned) = (motion(0.3, 10.0), Motion { slip_velocity: v, rolling_speed: 1.0 });
    one.step(along, 3e-3).unwrap();
    two.step(turned, 3e-3).unwrap();
    let forces = (one.force(0.1), two.force(v));
    for bad in [NAN, INFINITE] {
        let step = one.companion_step(along, 1e-3).unwrap();
        assert_eq!(step.commit(bad).unwrap_err().name, "mean_slip_velocity");
        let step = one.companion_step(along, 1e-3).unwrap();
        assert_eq!(step.commit_with_ledger(bad).unwrap_err().name, "mean_slip_velocity");
        let step = two.companion_step(turned, 1e-3).unwrap();
        let error = step.commit(Vector2::new(0.0, bad)).unwrap_err();
        assert_eq!((error.name, error.component), ("mean_slip_velocity", Some(1)));
    }
    // Nothing happens in no time.
    let step = one.companion_step(along, 0.0).unwrap();
    let [nothing] = step.commit_with_ledger(5.0).unwrap();
    assert_eq!((nothing.work, nothing.stored, nothing.outlet), (0.0, 0.0, 0.0));
    assert_eq!((one.force(0.1), two.force(v)), forces);
}

#[test]
fn memory_that_does_not_suffice_is_refused() {
    let line = patch(tyre(), parabolic());
    for count in [0, 1, 21] {
        let refused = line.exact([vec![Segment::default(); count]]).unwrap_err();
        assert_eq!((refused.name, refused.value), ("segments", count as f64));
        assert_eq!(refused.rule, Rule::Count { least: 22 });
    }
    let plane = crate::combined::patch(Rubber::TREAD.model(), parabolic());
    // None that aborts, either.
    for segments in [7, 10_000_001, 1_000_000_000_000, usize::MAX] {
        assert_eq!(line.exact_in(segments).unwrap_err().name, "segments");
        assert_eq!(plane.exact_in(segments).unwrap_err().name, "segments");
    }
    assert_eq!(plane.exact([[Segment::default(); 21]; 2]).unwrap_err().name, "segments");
    for cells in [0, usize::MAX] {
        assert_eq!(Grid::new(&line, cells).unwrap_err().name, "cells");
        assert_eq!(CombinedGrid::new(&plane, cells).unwrap_err().name, "cells");
    }
}
