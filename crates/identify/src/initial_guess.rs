//! Starting values from a log: reversals, pre-sliding stiffness, rows in sliding.
//!
//! After a reversal at x = 0, a bristle with little damping that slides slowly has turned its force
//! by
//!
//! Δμ = 2μ (1 − e^(−σ0 x/μ)),
//!
//! from one side of the curve to the other. Half of this is reached at x₅₀ = ln 2 · μ/σ0, so that
//! σ0 = ln 2 · μ/x₅₀.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x | distance since the reversal | m |
//! | μ, Δμ | friction coefficient in sliding, its change since the reversal | – |
//! | σ0 | micro-stiffness | 1/m |
//! | x₅₀ | distance to half of the swing of the force | m |
//!
//! Rows farther than 5 μ/σ0 from the last reversal lie on the friction curve. In shorter strokes
//! the last 40 % are taken.

use core::ops::RangeInclusive;

use super::Log;
use super::log::{extent, median, quantile, span};
use bristle::parameter::{Checked, Named};

/// The range of nearly all rows is that between this share and the same share from the top: a few
/// bad rows do not change it.
const TAIL: f64 = 0.02;
/// Distances μ/σ0 after which a row counts as sliding: e⁻⁵ of the bristle's lag is left, below 1 %.
const SETTLED: f64 = 5.0;
/// Share of the longest stroke that is passed over at most, so that short strokes have sliding rows
/// too.
const SKIPPED: f64 = 0.6;
/// Shortest stroke, over x₅₀, in which a contact can slide: a bristle that only stretches turns the
/// whole swing over 2 x₅₀.
const STRETCH: f64 = 2.5;
/// A turn that counts as a reversal is at least this share of the travel, whatever the noise.
const TURN: f64 = 1e-3;

/// Starting values for a fit, estimated from the log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InitialGuess {
    /// μ_s \[–\], or p μ_s \[N\] without normal force; never below the dynamic coefficient.
    pub static_coefficient: f64,
    /// μ_d \[–\].
    pub dynamic_coefficient: f64,
    /// v_S [m/s], not above the largest speed.
    pub stribeck_velocity: f64,
    /// σ2 [s/m].
    pub viscous_friction: f64,
    /// σ0 [1/m].
    pub micro_stiffness: f64,
    /// σ1 [s/m]: a tenth of μ over the largest speed. This is no estimate, only a start for the
    /// fit.
    pub micro_damping: f64,
    /// Offset of the sensor in the friction coefficient \[–\]: the middle between both directions.
    /// A candidate without an offset, such as [`FrBdFit`](super::FrBdFit), cannot follow it.
    /// Subtract it from the data, or use [`ElastoPlasticFit`](super::ElastoPlasticFit).
    pub offset: f64,
    /// Largest speed in the log [m/s].
    pub fastest: f64,
    /// Number of reversals found.
    pub reversals: usize,
}

/// Friction in sliding, far enough from the last reversal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlidingPoint {
    /// Speed |v| [m/s].
    pub speed: f64,
    /// Friction coefficient \[–\] against the motion.
    pub coefficient: f64,
}

impl InitialGuess {
    /// A first guess without a fit of the curve, and the rows in sliding, for
    /// [`InitialGuess::static_curve`].
    ///
    /// # Errors
    ///
    /// Refuses a log without a reversal, or in which no stroke is long enough to slide, and
    /// friction that never changes, or that drives the motion (without its offset, over the whole
    /// log).
    pub fn with_points(log: &Log) -> Checked<(Self, Vec<SlidingPoint>)> {
        let position = log.positions();
        let noise = noise(&position);
        let strokes = Stroke::all(&position, noise, log)?;
        let reversals = strokes.len() - 1;
        let (low, high) = bulk(&mut log.coefficient.clone());
        let (swing, middle) = (high - low, 0.5 * (high + low));
        let rule = "not stay there all along: does the sensor work?";
        Named("friction/normal_force", middle).stated(swing > 0.0, rule)?;

        let longest = strokes.iter().map(|stroke| stroke.travel.abs()).fold(0.0, f64::max);
        // The first stroke does not begin with a reversal.
        let halves = strokes.iter().skip(1).filter_map(|stroke| stroke.half_turn(swing));
        let half = median(&mut halves.collect::<Vec<f64>>());
        let stretch = "the distance over which a bristle turns the force";
        let needed = STRETCH * Named("distance to half of the swing", half).positive()?;
        Named("longest stroke", longest).at_least(stretch, needed)?;
        let offset_free: Vec<f64> = log.coefficient.iter().map(|mu| mu - middle).collect();
        let work = log.work(&offset_free);
        let rule = "not be negative, as if friction drove the motion: is its sign right?";
        Named("work of friction over the normal force", work).stated(work >= 0.0, rule)?;

        let breakaway = half / core::f64::consts::LN_2;
        let passed = f64::min(SETTLED * breakaway, SKIPPED * longest);
        // At rest, the noise of the position looks like speeds up to this.
        let slowest = noise * (log.len() - 1) as f64 / span(&log.time);
        let points: Vec<SlidingPoint> =
            strokes.iter().flat_map(|stroke| stroke.sliding(passed, slowest, middle)).collect();
        let (slow, fast) = bulk(&mut points.iter().map(|point| point.speed).collect::<Vec<_>>());
        let usual = median(&mut points.iter().map(|point| point.coefficient).collect::<Vec<_>>());
        let size = if usual > 0.0 { usual } else { 0.5 * swing };
        let fastest = log.held.iter().fold(0.0, |most, v| f64::max(most, v.abs()));
        // Of the curve only the level is known here. The rest is a mild fall in the middle of the
        // speeds seen, and viscous parts that hardly count at the largest speed.
        let guess = Self {
            static_coefficient: 1.2 * size,
            dynamic_coefficient: 0.9 * size,
            stribeck_velocity: if slow > 0.0 { (slow * fast).sqrt() } else { 0.2 * fastest },
            viscous_friction: 0.01 * size / fastest,
            micro_stiffness: size / breakaway,
            micro_damping: 0.1 * size / fastest,
            offset: middle,
            fastest,
            reversals,
        };
        Ok((guess, points))
    }
}

/// The rows between two turns: position, friction coefficient, velocity.
struct Stroke {
    rows: Vec<(f64, f64, f64)>,
    begin: f64,
    travel: f64,
}

impl Stroke {
    /// All strokes of a log, two at least.
    fn all(position: &[f64], noise: f64, log: &Log) -> Checked<Vec<Self>> {
        let strokes = strokes(position, f64::max(noise, TURN * extent(position)));
        let reversals = strokes.len().saturating_sub(1);
        let rule = "be at least 1: a turn by more than its noise and 1/1000 of the travel";
        Named("number of reversals", reversals as f64).stated(reversals > 0, rule)?;
        let one = |rows: RangeInclusive<usize>| {
            let columns = position.iter().zip(&log.coefficient).zip(&log.velocity);
            let columns = columns.map(|((&x, &mu), &v)| (x, mu, v));
            let rows: Vec<_> = columns.take(rows.end() + 1).skip(*rows.start()).collect();
            let [begin, end] = [rows.first(), rows.last()].map(|row| row.map_or(0.0, |row| row.0));
            Self { rows, begin, travel: end - begin }
        };
        Ok(strokes.into_iter().map(one).collect())
    }

    /// The distance to half of the swing of the force, if the stroke begins with a reversal.
    fn half_turn(&self, swing: f64) -> Option<f64> {
        let mu_from = self.rows.first()?.1;
        let level = 0.5 * swing;
        let mut before = (0.0, 0.0);
        for &(x, mu, _) in self.rows.iter().skip(1) {
            let now = ((x - self.begin).abs(), (mu - mu_from).abs());
            if now.1 >= level {
                let share = (level - before.1) / (now.1 - before.1).max(f64::MIN_POSITIVE);
                return Some(before.0 + (now.0 - before.0) * share);
            }
            before = now;
        }
        None
    }

    /// The rows beyond a distance from the reversal that are faster than noise.
    fn sliding(&self, passed: f64, slowest: f64, middle: f64) -> Vec<SlidingPoint> {
        let direction = self.travel.signum();
        let slides = |&&(x, _, v): &&(f64, f64, f64)| {
            (x - self.begin).abs() >= passed && v * direction > slowest
        };
        let point = |&(_, mu, v): &(f64, f64, f64)| SlidingPoint {
            speed: v.abs(),
            coefficient: (mu - middle) * direction,
        };
        self.rows.iter().filter(slides).map(point).collect()
    }
}

/// The range of nearly all values.
pub(super) fn bulk(values: &mut [f64]) -> (f64, f64) {
    (quantile(values, TAIL), quantile(values, 1.0 - TAIL))
}

/// Six standard deviations of the noise of a position, from its second differences: three quarters
/// of the second differences of Gaussian noise of deviation s are below 1.15 √6 s = 2.82 s. (The
/// median would be zero for a position rounded to a grid, where half of them may vanish.)
pub(super) fn noise(position: &[f64]) -> f64 {
    let bends = position.windows(3).map(|x| (x[0] - 2.0 * x[1] + x[2]).abs());
    6.0 * quantile(&mut bends.collect::<Vec<f64>>(), 0.75) / 2.82
}

/// The first and last rows of the strokes between turns that go farther than a threshold.
fn strokes(position: &[f64], threshold: f64) -> Vec<RangeInclusive<usize>> {
    let mut strokes = Vec::new();
    // Row and position of the farthest point of the present stroke; its direction, zero at first.
    let (mut first, mut direction) = (0, 0.0_f64);
    let mut farthest = (0, position.first().copied().unwrap_or(0.0));
    for (row, &x) in position.iter().enumerate() {
        let ahead = x - farthest.1;
        if direction == 0.0 {
            if ahead.abs() > threshold {
                (direction, farthest) = (ahead.signum(), (row, x));
            }
        } else if ahead * direction >= 0.0 {
            farthest = (row, x);
        } else if ahead.abs() > threshold {
            strokes.push(first..=farthest.0);
            (first, direction, farthest) = (farthest.0, -direction, (row, x));
        }
    }
    if direction != 0.0 {
        strokes.push(first..=position.len().saturating_sub(1));
    }
    strokes
}

#[cfg(test)]
mod tests {
    use super::{bulk, noise, strokes};

    #[test]
    fn nearly_all_values_are_those_between_the_fiftieth_from_either_end() {
        let mut values: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        assert_eq!(bulk(&mut values), (2.0, 98.0));
    }

    #[test]
    fn the_noise_of_a_position_is_six_of_its_deviations_whatever_the_motion() {
        // Sums of twelve uniform numbers, of variance one; the motion is as smooth as 1e-3 of it.
        let mut seed = 7_u64;
        let mut uniform = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        for deviation in [1e-6, 3e-3] {
            let row = |i| deviation * (f64::from(i) * 0.03).sin();
            let position: Vec<f64> = (0..40_000)
                .map(|i| row(i) + deviation * ((0..12).map(|_| uniform()).sum::<f64>() - 6.0))
                .collect();
            // A quartile of 40 000 values has an error of 0.7 %, and the constant one of 0.4 %.
            let ratio = noise(&position) / (6.0 * deviation);
            assert!((ratio - 1.0).abs() < 0.02, "{deviation}: {ratio}");
        }
    }

    #[test]
    fn a_stroke_ends_at_the_farthest_row_before_a_turn_beyond_the_threshold() {
        let position = [0.0, 0.5, 2.0, 5.0, 4.5, 4.0, 5.0, 6.0, 4.9, 3.0, 4.0, 5.0];
        // Back by 1 from 5 does not count as more than 1; back by 3 from 6 does, and by 2 from 3.
        assert_eq!(strokes(&position, 1.0), [0..=7, 7..=9, 9..=11]);
        assert_eq!(strokes(&position, 0.99), [0..=3, 3..=5, 5..=7, 7..=9, 9..=11]);
        assert_eq!(strokes(&position, 3.0), [0..=11]);
        assert_eq!(strokes(&position, 6.0), []);
        assert_eq!(strokes(&[], 0.0), []);
    }
}
