//! What a machine records of itself: its drive and its position, checked row by row.

use core::ops::Range;

use super::smooth::{Smoothed, smoothed};
use crate::log::{column, median, pairs, range, times, window};
use bristle::parameter::{Checked, Named};

/// What drives the mechanism, row by row, positive along v > 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive<'a> {
    /// Torque of the motor at the joint [N m].
    Torque(&'a [f64]),
    /// Current \[A\]; the torque is k_t i.
    Current(&'a [f64]),
    /// Voltage \[V\]; the torque is k_t (u − k_t v)/R.
    Voltage(&'a [f64]),
    /// Duty of a position controller that is known, as a servo has it in its firmware:
    /// d = clamp(K_p (goal − x) − K_d v, ±1). A simulation closes the loop with its own motion.
    ///
    /// The voltage is supply times d, or supply · sgn(d) |d|^γ if something is said of the
    /// parameter `duty_exponent` γ, as [`Joint::start`](super::Joint::start) does: the drivers of
    /// small servos give more than their share at small duties.
    Duty {
        /// Goal of the position \[rad\].
        goal: &'a [f64],
        /// Gain K_p [1/rad], positive.
        gain: f64,
        /// Gain K_d of the velocity [s/rad], zero or positive.
        derivative_gain: f64,
        /// Voltage of the supply \[V\], positive.
        supply: &'a [f64],
    },
}

/// What is known of the load in one log, beside what all logs share.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct KnownLoad {
    /// Moment of inertia at the joint [kg m²], added to that of the mechanism.
    pub inertia: f64,
    /// Torque of gravity where the link is horizontal [N m], added to that of
    /// [`Term::Gravity`](super::Term::Gravity).
    pub gravity_torque: f64,
}

/// What a [`DriveLog`] is made of: columns of equal length. Those that were not recorded stay as
/// [`DriveLogParameters::new`] has them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveLogParameters<'a> {
    /// Time \[s\], increasing. After a step of more than ten times the median a simulation starts
    /// anew.
    pub time: &'a [f64],
    /// Position \[rad\].
    pub position: &'a [f64],
    /// Velocity [rad/s], if it was measured and not computed from the position.
    pub velocity: Option<&'a [f64]>,
    /// The drive.
    pub drive: Drive<'a>,
    /// Whether the drive is held from each row to the next; otherwise it is linear between rows.
    pub held: bool,
    /// Whether the drive was measured, with noise: it is then smoothed where it loads the gear.
    /// Otherwise it is a command. A goal is always one.
    pub noisy: bool,
    /// Time \[s\] by which the drive acts later than its rows say, zero or positive. To it is added
    /// the parameter `delay`, which is searched if [`Joint::start`](super::Joint::start) says
    /// something of it.
    pub delay: f64,
    /// External torque that loads the gear [N m], positive along v > 0, if one was measured.
    pub external_torque: Option<&'a [f64]>,
    /// Where the drive is enabled: elsewhere the motor is open, without torque or back-EMF.
    pub enabled: Option<&'a [bool]>,
    /// What is known of the load in this log.
    pub load: KnownLoad,
}

impl<'a> DriveLogParameters<'a> {
    /// Columns of time, position and drive, of a drive that was measured without delay, is enabled
    /// throughout and linear between rows.
    pub fn new(time: &'a [f64], position: &'a [f64], drive: Drive<'a>) -> Self {
        Self {
            time,
            position,
            velocity: None,
            drive,
            held: false,
            noisy: true,
            delay: 0.0,
            external_torque: None,
            enabled: None,
            load: KnownLoad::default(),
        }
    }
}

/// How the drive becomes a torque.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Source {
    Torque,
    Current,
    Voltage,
    Duty { gain: f64, derivative_gain: f64, supply: Vec<f64> },
}

impl Source {
    /// Whether the drive is a voltage.
    pub(super) fn is_electric(&self) -> bool {
        matches!(self, Self::Voltage | Self::Duty { .. })
    }
}

/// Drive and position of a mechanism over time.
///
/// ```
/// use bristle_identify::mechanism::{Drive, DriveLog, DriveLogParameters};
///
/// let time: Vec<f64> = (0..100).map(|i| 1e-2 * f64::from(i)).collect();
/// let position: Vec<f64> = time.iter().map(|t| (6.0 * t).sin()).collect();
/// let mut torque = vec![0.0; 100];
/// torque[7] = f64::NAN;
/// let columns = DriveLogParameters::new(&time, &position, Drive::Torque(&torque));
/// let refused = DriveLog::new(columns).unwrap_err();
/// assert_eq!(refused.to_string(), "torque[7] is NaN, but must lie between -1e100 and 1e100");
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct DriveLog {
    pub(super) time: Vec<f64>,
    pub(super) position: Vec<f64>,
    pub(super) velocity: Option<Vec<f64>>,
    /// Torque, current, voltage or goal.
    pub(super) drive: Vec<f64>,
    pub(super) source: Source,
    pub(super) held: bool,
    pub(super) noisy: bool,
    pub(super) delay: f64,
    pub(super) external: Vec<f64>,
    pub(super) enabled: Vec<bool>,
    pub(super) load: KnownLoad,
    /// Whether it begins in motion, or under load.
    pub(super) in_motion: bool,
    /// Motion and effort, smoothed.
    pub(super) rows: Vec<Smoothed>,
    /// Time after which it is simulated, if it begins in motion \[s\].
    pub(super) wait: f64,
}

/// A step of the time longer than so many medians is a gap.
const GAP: f64 = 10.0;

/// Velocity over the root mean square of all that noise does not reach at the first row.
const CLEAR: f64 = 0.3;

/// Velocity over the root mean square of all below which it stands still: noise leaves less.
const STILL: f64 = 0.1;

/// Refuses a position that never changes.
fn moving(position: Vec<f64>) -> Checked<Vec<f64>> {
    let (least, most) = range(&position);
    let rule = "not stay there all along: does the sensor work?";
    Named("position", least).stated(most > least, rule)?;
    Ok(position)
}

impl DriveLog {
    /// Checks the columns.
    ///
    /// # Errors
    ///
    /// Names the column, the row, the value and the rule. Columns must have one length of at least
    /// 20 rows. Every number must be finite, the time increasing and the supply positive. Refuses
    /// a position that never changes.
    pub fn new(parameters: DriveLogParameters<'_>) -> Checked<Self> {
        let DriveLogParameters { velocity, external_torque, enabled, load, .. } = parameters;
        let DriveLogParameters { held, noisy, delay, .. } = parameters;
        let time = times(parameters.time)?;
        let rows = time.len();
        let finite = |names, values| column(names, values, rows, Named::finite);
        let (drive, source) = match parameters.drive {
            Drive::Torque(u) => (finite(["torque", "rows of torque"], u)?, Source::Torque),
            Drive::Current(u) => (finite(["current", "rows of current"], u)?, Source::Current),
            Drive::Voltage(u) => (finite(["voltage", "rows of voltage"], u)?, Source::Voltage),
            Drive::Duty { goal, gain, derivative_gain, supply } => {
                let gain = Named("gain", gain).positive()?;
                let derivative_gain = Named("derivative_gain", derivative_gain).non_negative()?;
                let supply = column(["supply", "rows of supply"], supply, rows, Named::positive)?;
                let source = Source::Duty { gain, derivative_gain, supply };
                (finite(["goal", "rows of goal"], goal)?, source)
            }
        };
        let external = external_torque
            .map(|u| finite(["external_torque", "rows of external_torque"], u))
            .transpose()?;
        let enabled_rows = enabled.map_or(rows, <[_]>::len);
        Named("rows of enabled", enabled_rows).count_between(rows, rows)?;
        Named("delay", delay).non_negative()?;
        Named("load.inertia", load.inertia).non_negative()?;
        Named("load.gravity_torque", load.gravity_torque).finite()?;
        Ok(smoothed(Self {
            position: moving(finite(["position", "rows of position"], parameters.position)?)?,
            velocity: velocity.map(|v| finite(["velocity", "rows of velocity"], v)).transpose()?,
            external: external.unwrap_or_else(|| vec![0.0; rows]),
            enabled: enabled.map_or_else(|| vec![true; rows], <[_]>::to_vec),
            noisy: noisy && !matches!(source, Source::Duty { .. }),
            time,
            drive,
            source,
            held,
            delay,
            load,
            in_motion: false,
            rows: Vec::new(),
            wait: 0.0,
        }))
    }

    /// The rows with from ≤ t ≤ to \[s\].
    ///
    /// # Errors
    ///
    /// Refuses a window of fewer than 20 rows, an end that is NaN, and a position that does not
    /// change in it.
    pub fn between(&self, from: f64, to: f64) -> Checked<Self> {
        let rows = window(&self.time, from, to)?;
        let part = |column: &[f64]| column.get(rows.clone()).unwrap_or_default().to_vec();
        Ok(smoothed(Self {
            time: part(&self.time),
            position: moving(part(&self.position))?,
            velocity: self.velocity.as_deref().map(part),
            drive: part(&self.drive),
            source: match &self.source {
                &Source::Duty { gain, derivative_gain, ref supply } => {
                    Source::Duty { gain, derivative_gain, supply: part(supply) }
                }
                other => other.clone(),
            },
            external: part(&self.external),
            enabled: self.enabled.get(rows.clone()).unwrap_or_default().to_vec(),
            rows: Vec::new(),
            ..*self
        }))
    }

    /// A log that begins in motion, or at rest under load. Smoothed velocities see rows of one side
    /// only at the first row: its simulation begins two half windows of the smoothing later, the
    /// bristle having been moved along the measured motion. What is to be added there is searched,
    /// for each such log: `initial_velocity` [rad/s] to the smoothed velocity, and
    /// `initial_deflection` \[–\], over that of steady sliding, if the bristle's stiffness is
    /// searched. They take up errors of the model, too. Logs held out, and those that are simulated
    /// by the result, have neither.
    #[must_use]
    pub fn in_motion(self) -> Self {
        Self { in_motion: true, ..self }
    }

    /// Time \[s\] of each row.
    pub fn times(&self) -> &[f64] {
        &self.time
    }

    /// Position \[rad\] at each row.
    pub fn positions(&self) -> &[f64] {
        &self.position
    }

    /// The median time from row to row \[s\].
    pub(super) fn usual_step(&self) -> f64 {
        let mut steps: Vec<f64> = pairs(&self.time).map(|(from, to)| to - from).collect();
        median(&mut steps)
    }

    /// The rows between gaps of the time.
    pub(super) fn pieces(&self) -> Vec<Range<usize>> {
        let (longest, mut end) = (GAP * self.usual_step(), 0);
        let pieces = self.time.chunk_by(|from, to| to - from <= longest).map(|piece| {
            end += piece.len();
            end - piece.len()..end
        });
        pieces.collect()
    }

    /// Time from a row to the middle of its drive's effect \[s\].
    pub(super) fn lag(&self) -> f64 {
        self.delay + if self.held { 0.5 * self.usual_step() } else { 0.0 }
    }

    /// Duty of the controller by the goal of a row, where it acts and without its limits. Zero for
    /// other drives.
    fn unlimited_duty(&self, row: usize, lag: f64) -> f64 {
        let Source::Duty { gain, derivative_gain, .. } = &self.source else { return 0.0 };
        let goal = self.drive.get(row).copied().unwrap_or(0.0);
        let time = self.time.get(row).copied().unwrap_or(0.0) + lag;
        let next = self.time.partition_point(|&t| t <= time).clamp(1, self.time.len() - 1);
        let at = |column: &[f64], row: usize| column.get(row).copied().unwrap_or(0.0);
        let [[s, t], [x, y]] =
            [&self.time, &self.position].map(|column| [at(column, next - 1), at(column, next)]);
        let share = ((time - s) / (t - s)).min(1.0);
        let velocity = |row: usize| self.rows.get(row).map_or(0.0, |row| row.velocity);
        let [v, w] = [next - 1, next].map(velocity);
        gain * (goal - x - (y - x) * share) - derivative_gain * (v + (w - v) * share)
    }

    /// Torque, current or voltage of the drive by a row, at the measured position where it acts;
    /// zero where it is not enabled.
    pub(super) fn effort(&self, row: usize, lag: f64) -> f64 {
        let value = match &self.source {
            Source::Duty { supply, .. } => {
                let supply = supply.get(row).copied().unwrap_or(0.0);
                supply * self.unlimited_duty(row, lag).clamp(-1.0, 1.0)
            }
            _ => self.drive.get(row).copied().unwrap_or(0.0),
        };
        if self.enabled.get(row).copied().unwrap_or(false) { value } else { 0.0 }
    }

    /// Root mean square of the velocity.
    fn usual_speed(&self) -> f64 {
        let squares: f64 = self.rows.iter().map(|row| row.velocity * row.velocity).sum();
        (squares / self.rows.len() as f64).sqrt()
    }

    /// Whether its first velocity is clearly one, of which noise leaves so much there.
    pub(super) fn begins_in_motion(&self) -> bool {
        let clear = CLEAR * self.usual_speed();
        self.rows.first().is_some_and(|row| row.velocity.abs() > clear)
    }

    /// Whether it stands still in more than half of its rows.
    pub(super) fn mostly_rests(&self) -> bool {
        let slow = STILL * self.usual_speed();
        self.rows.iter().filter(|row| row.velocity.abs() < slow).count() > self.rows.len() / 2
    }

    /// Whether the controller is at its limit wherever it is enabled.
    pub(super) fn is_saturated(&self) -> bool {
        let mut on = self.enabled.iter().enumerate().filter(|(_, on)| **on).peekable();
        on.peek().is_some() && on.all(|(row, _)| self.unlimited_duty(row, 0.0).abs() >= 1.0)
    }
}
