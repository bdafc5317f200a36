//! Zero-phase smoothing: position, velocity and acceleration of a log at every row, from a cubic
//! fitted to the rows around it.
//!
//! Σ w(|tᵢ − t|/W) (xᵢ − a − b(tᵢ − t) − c(tᵢ − t)² − d(tᵢ − t)³)² → min,  w(u) = (1 − u³)³
//!
//! The window W reaches as far to both sides, so that nothing is delayed; rows need not be evenly
//! spaced. It is so wide that noise of standard deviation s leaves 4 % of the velocity,
//!
//! W = (s² Δt/(0.01 v)²)^(1/3),
//!
//! and at least six rows.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x, s | position, standard deviation of its noise | rad |
//! | v | root mean square of the velocity from row to row, with noise | rad/s |
//! | Δt, W | median step of the time, half width of the window | s |
//!
//! Source: W. S. Cleveland, "Robust locally weighted regression and smoothing scatterplots",
//! Journal of the American Statistical Association 74 (1979), without the robust weights.

use nalgebra::{Matrix4, Vector4};

use super::log::{DriveLog, Source};
use crate::initial_guess::noise;
use crate::log::{pairs, span};

/// Motion and effort at a row.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Smoothed {
    pub(super) position: f64,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    /// Torque, current or voltage of the drive that acts at the row: the coefficients of its cubic
    /// in time.
    pub(super) effort: [f64; 4],
    /// Share of the window in which it is enabled.
    pub(super) enabled: f64,
    pub(super) external: f64,
    /// Voltage of the supply of a controller, zero for other drives.
    pub(super) supply: f64,
}

/// A quarter of the share of the velocity that noise leaves.
const NOISE: f64 = 0.01;
/// Rows to both sides, at least.
const ROWS: f64 = 6.0;
/// The window reaches over at most this share of a log.
const WIDEST: f64 = 0.05;

/// Half windows after which a log that begins in motion is simulated.
const WINDOWS: f64 = 2.0;

/// The half width of the window \[s\] that suits a log.
fn window(log: &DriveLog) -> f64 {
    let step = log.usual_step();
    let duration = span(&log.time);
    let rows = pairs(&log.position).zip(pairs(&log.time));
    let travel = rows.map(|((a, b), (s, t))| (b - a) * (b - a) / (t - s)).sum::<f64>();
    let velocity = (travel / duration).sqrt().max(f64::MIN_POSITIVE);
    let deviation = noise(&log.position) / 6.0;
    let wanted = (step * (deviation / (NOISE * velocity)).powi(2)).cbrt();
    wanted.min(WIDEST * duration).max(ROWS * step)
}

/// A log with every row smoothed within the pieces between gaps. The effort may depend on the
/// motion.
pub(super) fn smoothed(log: DriveLog) -> DriveLog {
    // Of a log with more noise it stays.
    let wait = if log.rows.is_empty() { WINDOWS * window(&log) } else { log.wait };
    let log = DriveLog { rows: motion(&log), wait, ..log };
    let (lag, mut rows) = (log.lag(), log.rows.iter());
    // The drive acts later than its rows say.
    let rows = at_each(&log, lag, |row, fitted| {
        let effort = fitted.at(&|i| log.effort(i, lag));
        let supply = match &log.source {
            Source::Duty { supply, .. } => value(supply, row),
            _ => 0.0,
        };
        Smoothed { effort, supply, ..rows.next().copied().unwrap_or_default() }
    });
    DriveLog { rows, ..log }
}

/// The value of a column at a row.
fn value(column: &[f64], row: usize) -> f64 {
    column.get(row).copied().unwrap_or(0.0)
}

/// What is found for each row from the local cubic so long before it.
fn at_each<R>(log: &DriveLog, lag: f64, mut each: impl FnMut(usize, &Cubic) -> R) -> Vec<R> {
    let (width, mut found) = (window(log), Vec::with_capacity(log.time.len()));
    for piece in log.pieces() {
        let times = log.time.get(piece.clone()).unwrap_or_default();
        for (row, &time) in piece.clone().zip(times) {
            let centre = (time - lag).max(times.first().copied().unwrap_or(0.0));
            let from = piece.start + times.partition_point(|&t| t < centre - width);
            let to = piece.start + times.partition_point(|&t| t <= centre + width);
            found.push(each(row, &Cubic::new(from..to, centre, width, &log.time)));
        }
    }
    found
}

/// The rows without their effort.
fn motion(log: &DriveLog) -> Vec<Smoothed> {
    let enabled = |i| f64::from(u8::from(log.enabled.get(i).copied().unwrap_or(false)));
    at_each(log, 0.0, |_, fitted| {
        let position = fitted.at(&|i| value(&log.position, i));
        let measured = log.velocity.as_ref().map(|velocity| fitted.at(&|i| value(velocity, i)));
        let (velocity, acceleration) = match measured {
            Some([velocity, acceleration, ..]) => (velocity, acceleration),
            None => (position[1], 2.0 * position[2]),
        };
        Smoothed {
            position: position[0],
            velocity,
            acceleration,
            enabled: fitted.at(&enabled)[0],
            external: fitted.at(&|i| value(&log.external, i))[0],
            ..Smoothed::default()
        }
    })
}

/// The weights of a local cubic, for any column.
struct Cubic {
    /// Row, its time over the window, its weight.
    rows: Vec<(usize, f64, f64)>,
    inverse: Matrix4<f64>,
    width: f64,
}

fn powers(u: f64) -> Vector4<f64> {
    Vector4::new(1.0, u, u * u, u * u * u)
}

impl Cubic {
    fn new(range: core::ops::Range<usize>, centre: f64, width: f64, time: &[f64]) -> Self {
        let rows: Vec<_> = range
            .filter_map(|i| {
                let u = (time.get(i)? - centre) / width;
                Some((i, u, (1.0 - u.abs().powi(3)).max(0.0).powi(3)))
            })
            .collect();
        let mut normal = Matrix4::identity() * 1e-9;
        for &(_, u, weight) in &rows {
            normal += powers(u) * powers(u).transpose() * weight;
        }
        Self { rows, inverse: normal.try_inverse().unwrap_or_else(Matrix4::zeros), width }
    }

    /// The coefficients a, b, c, d of a column.
    fn at(&self, column: &dyn Fn(usize) -> f64) -> [f64; 4] {
        let mut right = Vector4::zeros();
        for &(i, u, weight) in &self.rows {
            right += powers(u) * (weight * column(i));
        }
        let [a, b, c, d] = (self.inverse * right).into();
        let w = self.width;
        [a, b / w, c / (w * w), d / (w * w * w)]
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use crate::mechanism::{Drive, DriveLog, DriveLogParameters};
    use bristle_specimens::draw::Draw;

    #[test]
    fn noise_leaves_four_percent_of_the_velocity() {
        let mut draw = Draw::seeded(1);
        let time: Vec<f64> = (0..2000).map(|i| 1e-2 * f64::from(i)).collect();
        let position: Vec<f64> = time.iter().map(|t| t.sin() + 5e-3 * draw.gauss()).collect();
        let columns = DriveLogParameters::new(&time, &position, Drive::Torque(&position));
        let rows = DriveLog::new(columns).unwrap().rows;
        let errors = rows.iter().zip(&time).map(|(row, t)| (row.velocity - t.cos()).powi(2));
        let error = (errors.sum::<f64>() / 2000.0).sqrt();
        // √(∫k²) = 4.14 for the kernel of the slope, times 1 % of v: √(½ + 2 s²/Δt²) = 1 of rows.
        // About 70 windows of their own tell it to 10 %.
        assert!((error - 0.0414).abs() < 0.01, "{error}");
    }
}
