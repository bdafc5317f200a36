//! What a log tells at a glance: reversals, pre-sliding stiffness, sliding rows, a curve through them.
//!
//! After a reversal at x = 0 a bristle with little damping, sliding slowly, has turned its force by
//!
//! Δμ = 2μ (1 − e^(−σ0 x/μ)),
//!
//! from one side of the curve to the other, half of it at x₅₀ = ln 2 · μ/σ0. So σ0 = ln 2 · μ/x₅₀. What is slid beyond
//! 5 μ/σ0 since the last reversal (of shorter strokes the last 40 %) lies on the curve.

use alloc::vec::Vec;

use super::log::{median, quantile};
use super::static_curve::{SlidingPoint, StribeckCurve, static_curve};
use super::{IdentifyError, Log};

/// What a log tells at a glance: where to begin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InitialGuess {
    /// μ_s \[–\], or p μ_s \[N\] without normal force; never below the dynamic one.
    pub static_coefficient: f64,
    /// μ_d \[–\].
    pub dynamic_coefficient: f64,
    /// v_S [m/s], not above the largest speed.
    pub stribeck_velocity: f64,
    /// σ2 [s/m].
    pub viscous_friction: f64,
    /// σ0 [1/m].
    pub micro_stiffness: f64,
    /// σ1 [s/m]: a tenth of μ over the fastest speed, a guess; the fit looks for it.
    pub micro_damping: f64,
    /// What the sensor seems to add to the friction coefficient \[–\]: the middle between both directions. A candidate without
    /// an offset, such as [`FrBdFit`](super::FrBdFit), cannot follow it: then take it off the data, or take
    /// [`MaxwellFit`](super::MaxwellFit) or [`ElastoPlasticFit`](super::ElastoPlasticFit).
    pub offset: f64,
    /// Largest speed in the log [m/s].
    pub fastest: f64,
    /// Reversals found.
    pub reversals: usize,
}

/// A stretch of rows in one direction.
struct Stroke {
    first: usize,
    last: usize,
}

impl InitialGuess {
    /// Looks at a log.
    ///
    /// # Errors
    ///
    /// A log without a reversal, or in which no stroke is long enough to slide; friction that never changes, or that drives
    /// the motion (less its offset, over the whole log).
    pub fn of(log: &Log) -> Result<Self, IdentifyError> {
        let (rough, points) = Self::with_points(log)?;
        // One speed tells nothing of how friction depends on it.
        let mut speeds: Vec<f64> = points.iter().map(|point| point.speed).collect();
        if !(quantile(&mut speeds, 0.9) > 2.0 * quantile(&mut speeds, 0.1)) {
            return Ok(rough);
        }
        let Ok(fit) = static_curve(&StribeckCurve { rough, exponent: 2.0 }, &points) else {
            return Ok(rough);
        };
        let [dynamic_coefficient, excess, stribeck_velocity, viscous_friction] = fit.values();
        let static_coefficient = dynamic_coefficient + excess;
        Ok(Self {
            static_coefficient,
            dynamic_coefficient,
            // What the curve does beyond the largest speed nothing tells.
            stribeck_velocity: stribeck_velocity.min(rough.fastest),
            viscous_friction,
            ..rough
        })
    }

    /// The sliding part of a log, for [`static_curve`], and a first guess.
    ///
    /// # Errors
    ///
    /// As [`InitialGuess::of`].
    pub fn with_points(log: &Log) -> Result<(Self, Vec<SlidingPoint>), IdentifyError> {
        let position = log.positions();
        let noise = noise(&position);
        let threshold = threshold(&position, noise);
        let strokes = strokes(&position, threshold);
        let range = log
            .held
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
        if strokes.len() < 2 {
            return Err(IdentifyError::NoReversal { threshold, least: range.0, most: range.1 });
        }
        let mut sorted = log.coefficient.clone();
        let (low, high) = (quantile(&mut sorted, 0.02), quantile(&mut sorted, 0.98));
        let (swing, middle) = (high - low, 0.5 * (high + low));
        let level = 0.5 * swing;
        if !(swing > 0.0) {
            return Err(IdentifyError::NoChange { value: middle });
        }

        // The way to half of the swing, after each reversal.
        let mut halves = Vec::new();
        let mut longest = 0.0_f64;
        for stroke in &strokes {
            let rows =
                || position.iter().zip(&log.coefficient).take(stroke.last + 1).skip(stroke.first);
            let Some((&from, &mu_from)) = rows().next() else { continue };
            let way = rows().last().map_or(0.0, |(x, _)| (x - from).abs());
            longest = longest.max(way);
            if stroke.first == 0 {
                continue;
            }
            let mut before = (0.0, 0.0);
            for (x, mu) in rows() {
                let now = ((x - from).abs(), (mu - mu_from).abs());
                if now.1 >= level {
                    let share = (level - before.1) / (now.1 - before.1).max(f64::MIN_POSITIVE);
                    halves.push(before.0 + (now.0 - before.0) * share);
                    break;
                }
                before = now;
            }
        }
        let half = median(&mut halves);
        // A bristle that only stretches would turn the whole swing over 2 x₅₀.
        if !(half > 0.0) || longest < 2.5 * half {
            return Err(IdentifyError::NoSliding { longest, least: 2.5 * half });
        }
        // Work of friction without its offset, and the way along which it acts.
        let steps = position.windows(2).zip(log.coefficient.windows(2));
        let (work, path) = steps.fold((0.0, 0.0), |(work, path), pair| match pair {
            (&[from, to], &[before, after]) => {
                (work + (to - from) * (0.5 * (before + after) - middle), path + (to - from).abs())
            }
            _ => (work, path),
        });
        if !(work >= 0.0) {
            return Err(IdentifyError::DrivesMotion { work, path });
        }
        let breakaway = half / core::f64::consts::LN_2;
        let needed = f64::min(5.0 * breakaway, 0.6 * longest);
        // Standing still, noise of the position looks like speeds up to this.
        let rows_per_second = (log.len() - 1) as f64
            / (log.time.last().zip(log.time.first())).map_or(1.0, |(last, first)| last - first);
        let slowest = noise * rows_per_second;
        let mut points = Vec::new();
        for stroke in &strokes {
            let rows = log
                .velocity
                .iter()
                .zip(&log.coefficient)
                .zip(&position)
                .take(stroke.last + 1)
                .skip(stroke.first);
            let mut from = None;
            let direction = match (position.get(stroke.first), position.get(stroke.last)) {
                (Some(a), Some(b)) => (b - a).signum(),
                _ => continue,
            };
            for ((&velocity, &mu), &x) in rows {
                let from = *from.get_or_insert(x);
                if (x - from).abs() >= needed && velocity * direction > slowest {
                    points.push(SlidingPoint {
                        speed: velocity.abs(),
                        coefficient: (mu - middle) * direction,
                    });
                }
            }
        }
        let mut speeds: Vec<f64> = points.iter().map(|point| point.speed).collect();
        let mut friction: Vec<f64> = points.iter().map(|point| point.coefficient).collect();
        let fastest = range.1.max(-range.0);
        let (slow, fast) = (quantile(&mut speeds, 0.02), quantile(&mut speeds, 0.98));
        let usual = median(&mut friction);
        let size = if usual > 0.0 { usual } else { level };
        let rough = Self {
            static_coefficient: 1.2 * size,
            dynamic_coefficient: 0.9 * size,
            stribeck_velocity: if slow > 0.0 { (slow * fast).sqrt() } else { 0.2 * fastest },
            viscous_friction: 0.01 * size / fastest,
            micro_stiffness: size / breakaway,
            micro_damping: 0.1 * size / fastest,
            offset: middle,
            fastest,
            reversals: strokes.len() - 1,
        };
        Ok((rough, points))
    }
}

/// Six deviations of the noise of a position, from its second differences: three quarters of those of noise of
/// deviation s are below 1.15 √6 s = 2.82 s. (Rounded to a grid, half of them may be zero.)
fn noise(position: &[f64]) -> f64 {
    let bends = position.windows(3).filter_map(|three| match *three {
        [a, b, c] => Some((a - 2.0 * b + c).abs()),
        _ => None,
    });
    6.0 * quantile(&mut bends.collect::<Vec<f64>>(), 0.75) / 2.82
}

/// The way back that is more than noise, and than a thousandth of the travel.
fn threshold(position: &[f64], noise: f64) -> f64 {
    let (least, most) =
        position.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
    f64::max(noise, 1e-3 * (most - least))
}

/// Strokes between reversals that go further than a threshold.
fn strokes(position: &[f64], threshold: f64) -> Vec<Stroke> {
    let mut strokes = Vec::new();
    let (mut first, mut extreme, mut direction) =
        (0, (0, position.first().copied().unwrap_or(0.0)), 0.0_f64);
    for (row, &x) in position.iter().enumerate() {
        let ahead = (x - extreme.1) * direction;
        if direction == 0.0 {
            if (x - extreme.1).abs() > threshold {
                direction = (x - extreme.1).signum();
                extreme = (row, x);
            }
        } else if ahead >= 0.0 {
            extreme = (row, x);
        } else if -ahead > threshold {
            strokes.push(Stroke { first, last: extreme.0 });
            first = extreme.0;
            direction = -direction;
            extreme = (row, x);
        }
    }
    if direction != 0.0 {
        strokes.push(Stroke { first, last: position.len().saturating_sub(1) });
    }
    strokes
}
