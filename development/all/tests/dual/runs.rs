//! The derivatives of scenes against dual numbers, and dual numbers through whole runs.

use bristle::Branch;
use bristle::ode::{DormandPrince, Output, RungeKutta4, System, Tolerances};
use bristle_specimens::ode::{OfAny, rig, table_2_frbd, table_2_lugre};
use bristle_specimens::scenes::{driven, forced, prescribed, random_state, shaken, valve};
use bristle_specimens::{assert_within, check};
use nalgebra::{SVector, Vector3};
use num_dual::Dual64;
use proptest::prelude::*;

/// Runs a block with every scene, once in `f64` and once in dual numbers, for two models.
macro_rules! every_scene {
    (|$name:ident, $scene:ident, $dual:ident| $body:block) => {
        every_scene!(@models prescribed forced driven shaken valve: |$name, $scene, $dual| $body);
    };
    (@models $($of:ident)*: |$name:ident, $scene:ident, $dual:ident| $body:block) => {$(
        every_scene!(@one $of, table_2_frbd, |$name, $scene, $dual| $body);
        every_scene!(@one $of, table_2_lugre, |$name, $scene, $dual| $body);
    )*};
    (@one $of:ident, $model:ident, |$name:ident, $scene:ident, $dual:ident| $body:block) => {{
        let $name = concat!(stringify!($of), ", ", stringify!($model));
        let ($scene, $dual) = ($of($model::<f64>()), $of($model::<Dual64>()));
        $body
    }};
}

/// Checks `tangent` against the dual numbers of `rate`, column by column, on one branch.
fn assert_tangent<const N: usize>(
    name: &str,
    scene: &impl System<f64, N>,
    dual: &impl System<Dual64, N>,
    time: f64,
    state: SVector<f64, N>,
    branch: Branch,
) {
    let tangent = scene.linearised(time, &state, [branch]).unwrap();
    let rate = scene.rate(time, &state, [branch]);
    let scales = scene.scales();
    // The sum of the absolute terms of a row is not less than what the row's own derivatives
    // give over typical states; rates of a few scales lose a dozen roundings in sums of these.
    let sizes = SVector::<f64, N>::from_fn(|i, _| {
        (0..N).map(|j| (tangent.by_state[(i, j)] * state[j]).abs()).sum::<f64>()
            + (0..N).map(|j| (tangent.by_state[(i, j)] * scales[j]).abs()).sum::<f64>()
            + rate[i].abs()
            + tangent.by_time[i].abs()
    });
    let what = |part: &str, i: usize, j: usize| {
        format!("{name}, {part} [{i}, {j}] on {branch:?} at t = {time}, {state}")
    };
    let lifted = state.map(Dual64::from);
    for i in 0..N {
        assert_within(1e-13, sizes[i], tangent.rate[i], rate[i], || what("rate", i, 0));
    }
    for j in 0..N {
        let mut moved = lifted;
        moved[j].eps = 1.0;
        let column = dual.rate(Dual64::from(time), &moved, [branch]);
        for i in 0..N {
            let unit = sizes[i] / scales[j];
            let (got, want) = (tangent.by_state[(i, j)], column[i].eps);
            assert_within(1e-12, unit, got, want, || what("by_state", i, j));
        }
    }
    let column = dual.rate(Dual64::new(time, 1.0), &lifted, [branch]);
    for i in 0..N {
        // An input changes by its amplitude times 2π·0.7 per second.
        let unit = sizes[i] * 5.0;
        assert_within(1e-12, unit, tangent.by_time[i], column[i].eps, || what("by_time", i, 0));
    }
}

#[test]
fn every_tangent_is_the_derivative_of_the_rate() {
    let numbers = prop::array::uniform4(-1.0..1.0_f64);
    check(200, (numbers, 0.0..5.0_f64), |(numbers, time)| {
        every_scene!(|name, scene, dual| {
            let state = random_state(System::scales(&scene), &numbers);
            let [velocity] = scene.sliding_velocities(time, &state);
            // Free, on the right side, and on the wrong side where a model has an answer there (it
            // has none beyond a third of the way to its pole at 0.0155 m/s or more).
            let mut branches = vec![Branch::Free, Branch::towards(velocity)];
            if velocity.abs() < 0.004 {
                branches.push(Branch::towards(velocity).reversed());
            }
            for branch in branches {
                assert_tangent(name, &scene, &dual, time, state, branch);
            }
        });
    });
}

#[test]
fn a_locked_branch_has_derivatives_beyond_the_reversal() {
    // The law above meets slow slips rarely; here every state is one. A third of the way to the
    // pole at −μ_d/(σ1 + σ2) = −0.0155 m/s the model ends.
    let numbers = prop::array::uniform4(-1.0..1.0_f64);
    check(100, numbers, |numbers| {
        let (scene, dual) = (driven(table_2_frbd::<f64>()), driven(table_2_frbd::<Dual64>()));
        let mut state = random_state(scene.scales(), &numbers);
        state[1] = 0.004 * numbers[1];
        for branch in [Branch::Forward, Branch::Backward] {
            assert_tangent("slow", &scene, &dual, 1.0, state, branch);
        }
    });
}

#[test]
fn every_scale_is_positive_and_makes_tolerances() {
    every_scene!(|name, scene, dual| {
        let scales = System::scales(&scene);
        assert!(scales.iter().all(|scale| scale.is_finite() && *scale > 0.0), "{name}: {scales}");
        assert!(Tolerances::scaled(1e-6, scales).is_ok(), "{name}");
        let lifted = System::scales(&dual).map(|scale| scale.re);
        // Dual numbers divide by way of the reciprocal.
        assert!((lifted - scales).component_div(&scales).abs().max() < 1e-15, "{name}: {lifted}");
    });
}
/// Position of the rig at t = 12 s, after a slip and back in stick, for a drive velocity and an
/// initial position.
fn twelve_seconds(drive: Dual64, position: Dual64, adaptive: bool) -> Dual64 {
    let dual = Dual64::from_re;
    let rig = rig(table_2_frbd::<Dual64>(), drive);
    let start = Vector3::new(position, dual(0.0), dual(0.0));
    let (span, output) = (dual(0.0)..dual(12.0), Output::Uniform(2));
    let run = if adaptive {
        let tolerances = Tolerances::scaled(dual(1e-9), rig.scales()).unwrap();
        OfAny::checked(DormandPrince, tolerances).solve(&rig, span, start, output).unwrap()
    } else {
        OfAny::fixed(RungeKutta4, dual(4e-3)).unwrap().solve(&rig, span, start, output).unwrap()
    };
    assert!(run.statistics().reversals > 0, "nothing to differentiate across");
    run.last().unwrap().1[0]
}

#[test]
fn dual_numbers_carry_derivatives_through_reversals() {
    for adaptive in [false, true] {
        let position = |drive: f64, x: f64| {
            twelve_seconds(Dual64::from_re(drive), Dual64::from_re(x), adaptive).re
        };
        // Central differences over 2e-4: truncation of 1e-8 relative, error of the runs (1e-8 at
        // most, nearly the same on both sides) over it below 1e-4.
        let h = 1e-4;
        let by_drive = (position(0.1 + h, 0.0) - position(0.1 - h, 0.0)) / (2.0 * h);
        let by_start = (position(0.1, h) - position(0.1, -h)) / (2.0 * h);
        let dual = twelve_seconds(Dual64::new(0.1, 1.0), Dual64::from_re(0.0), adaptive).eps;
        assert!((dual - by_drive).abs() < 1e-4 * by_drive.abs(), "{dual} {by_drive}");
        let dual = twelve_seconds(Dual64::from_re(0.1), Dual64::new(0.0, 1.0), adaptive).eps;
        assert!((dual - by_start).abs() < 1e-4 * (1.0 + by_start.abs()), "{dual} {by_start}");
    }
}
