//! Error and time of one method over its settings.
//!
//! The error is the greatest one over all samples. The time is the shortest of several runs, dense
//! output at the samples included: wall-clock time of a program of one thread, which on a machine
//! that does other things besides only ever errs upward.

use std::time::{Duration, Instant};

use bristle::ode::System;

use crate::methods::{Method, Run, Setting};
use crate::row::Row;
use crate::scenes::{SAMPLES, Scene};

/// Least number of runs of a point, and the least and the most time \[s\] spent on it.
const RUNS: u32 = 3;
const LEAST: Duration = Duration::from_millis(30);
const MOST: Duration = Duration::from_millis(1500);

/// No setting is tried that is expected to take a run longer than this \[s\].
const LONG: f64 = 3.0;

/// Tolerances from 1e-2 to 1e-12, two a decade.
const TOLERANCES: i32 = 21;

/// Fixed steps begin with the time span over this number, and are halved.
const FEWEST_STEPS: f64 = 125.0;
/// At most so many times.
const HALVINGS: i32 = 24;

/// Halving the step is over below this error …
const EXACT: f64 = 1e-12;
/// … or where below this one it no longer halves the error: rounding.
const SMALL: f64 = 1e-10;

/// Measures a method over its settings, from loose to tight.
pub fn sweep<S: System<f64, N> + Clone, const N: usize>(
    scene: &Scene<S, N>,
    reference: &[f64],
    method: &Method<S, N>,
) -> Vec<Row> {
    let point = |setting: f64| {
        let (run, time) = repeat(|| (method.run)(scene, setting));
        Row {
            scene: scene.name,
            model: scene.model,
            method: method.name,
            setting,
            error: error(&run.judged, reference) / scene.scale,
            seconds: time.as_secs_f64(),
            cost: run.cost,
            failure: run.failure,
        }
    };
    let mut rows: Vec<Row> = Vec::new();
    match method.setting {
        Setting::Tolerance => {
            for half_decade in 0..TOLERANCES {
                rows.push(point(10f64.powf(-2.0 - 0.5 * f64::from(half_decade))));
                if rows.last().is_some_and(|row| row.seconds > LONG) {
                    break;
                }
            }
        }
        Setting::Step => {
            for halving in 0..HALVINGS {
                let row = point(scene.end / FEWEST_STEPS * 0.5f64.powi(halving));
                // Of the steps that are too long for stability the last one tells enough.
                if rows.iter().all(Row::fails) {
                    rows.clear();
                }
                // Steps too long for stability may take long as well, and shorter ones less.
                let long = !row.fails() && 2.0 * row.seconds > LONG;
                let floor = rows
                    .last()
                    .is_some_and(|longer| row.error < SMALL && row.error > 0.5 * longer.error);
                let over = long || floor || row.error < EXACT;
                rows.push(row);
                if over {
                    break;
                }
            }
        }
    }
    rows
}

/// Runs something several times; the last result and the shortest time.
pub fn repeat(work: impl Fn() -> Run) -> (Run, Duration) {
    let (mut shortest, mut total) = (Duration::MAX, Duration::ZERO);
    let mut runs = 0;
    loop {
        let begin = Instant::now();
        let run = work();
        let time = begin.elapsed();
        shortest = shortest.min(time);
        total += time;
        runs += 1;
        if total >= MOST || (runs >= RUNS && total >= LEAST) {
            return (run, shortest);
        }
    }
}

/// The greatest difference of two lists of samples; NaN if there are not as many as there should
/// be.
pub fn error(judged: &[f64], reference: &[f64]) -> f64 {
    if judged.len() != SAMPLES || reference.len() != SAMPLES {
        return f64::NAN;
    }
    let apart = judged.iter().zip(reference).map(|(a, b)| (a - b).abs());
    // `f64::max` would pass over NaN.
    apart.fold(0.0, |most, apart| if apart <= most { most } else { apart })
}
