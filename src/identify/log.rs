//! Measured motion and friction, checked row by row.

use alloc::vec::Vec;

use super::IdentifyError;

/// Fewest rows of a log.
pub(super) const FEWEST: usize = 20;

/// What was measured of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion<'a> {
    /// Position x \[m\] at each time. Between two rows the velocity is taken as Δx/Δt.
    Position(&'a [f64]),
    /// Sliding velocity v [m/s] at each time. Between two rows it is taken as the mean of both.
    Velocity(&'a [f64]),
}

/// What a [`Log`] is made of: columns of equal length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogParameters<'a> {
    /// Time t \[s\], increasing.
    pub time: &'a [f64],
    /// Position or velocity.
    pub motion: Motion<'a>,
    /// Friction force F \[N\], positive against v > 0: what brakes, not what pulls.
    pub friction: &'a [f64],
    /// Normal force p \[N\], positive. Without it p = 1 N, and μ is a force or a torque.
    pub normal_force: Option<&'a [f64]>,
}

/// Measured motion and friction.
///
/// ```
/// use bristle::identify::{Log, LogParameters, Motion};
///
/// let time: Vec<f64> = (0..100).map(|i| 1e-2 * f64::from(i)).collect();
/// let velocity: Vec<f64> = time.iter().map(|t| 1e-3 * (6.0 * t).sin()).collect();
/// let mut friction: Vec<f64> = velocity.iter().map(|v| 2.0 * (v / 1e-4).tanh()).collect();
/// friction[42] = f64::NAN;
/// let columns = LogParameters {
///     time: &time,
///     motion: Motion::Velocity(&velocity),
///     friction: &friction,
///     normal_force: None,
/// };
/// let refused = Log::new(columns).unwrap_err();
/// assert_eq!(refused.to_string(), "row 42: friction is NaN, but must be finite");
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    pub(super) time: Vec<f64>,
    /// Velocity held over the interval that ends at each row; the first is that of the second.
    pub(super) held: Vec<f64>,
    /// Velocity at each row.
    pub(super) velocity: Vec<f64>,
    /// F/p at each row.
    pub(super) coefficient: Vec<f64>,
    normalised: bool,
}

impl Log {
    /// Checks the columns.
    ///
    /// # Errors
    ///
    /// Names the row, the column, the value and the rule: columns of one length and at least 20 rows, every number finite and F/p too,
    /// time increasing, normal force positive, and magnitudes that friction can have (no speed above 10⁴ m/s, no median
    /// |F|/p outside 10⁻⁴ … 100 where the normal force is given, a travel of at least a nanometre), which a slip of units has not.
    pub fn new(parameters: LogParameters<'_>) -> Result<Self, IdentifyError> {
        let LogParameters { time, motion, friction, normal_force } = parameters;
        let (motion_name, along) = match motion {
            Motion::Position(x) => ("position", x),
            Motion::Velocity(v) => ("velocity", v),
        };
        let rows = time.len();
        if rows < FEWEST {
            return Err(IdentifyError::TooFewRows { rows, least: FEWEST });
        }
        let columns = [
            ("time", Some(time)),
            (motion_name, Some(along)),
            ("friction", Some(friction)),
            ("normal_force", normal_force),
        ];
        for (column, values) in
            columns.into_iter().filter_map(|(name, values)| Some((name, values?)))
        {
            if values.len() != rows {
                return Err(IdentifyError::Lengths { column, length: values.len(), rows });
            }
            if let Some((row, &value)) =
                values.iter().enumerate().find(|(_, value)| !value.is_finite())
            {
                return Err(IdentifyError::Row { row, column, value, rule: "be finite" });
            }
        }
        for (row, pair) in time.windows(2).enumerate() {
            if let [before, after] = *pair
                && !(after > before && (after - before).is_finite())
            {
                let rule = "be later than the row before, by a finite time";
                return Err(IdentifyError::Row {
                    row: row + 1,
                    column: "time",
                    value: after,
                    rule,
                });
            }
        }
        if let Some(normal) = normal_force
            && let Some((row, &value)) = normal.iter().enumerate().find(|&(_, &p)| !(p > 0.0))
        {
            return Err(IdentifyError::Row {
                row,
                column: "normal_force",
                value,
                rule: "be positive",
            });
        }
        let steps = || time.windows(2).zip(along.windows(2));
        let secant = |times: &[f64], ends: &[f64]| match (times, ends) {
            (&[t0, t1], &[a, b]) => match motion {
                Motion::Position(_) => (b - a) / (t1 - t0),
                Motion::Velocity(_) => 0.5 * (a + b),
            },
            _ => 0.0,
        };
        let mut held: Vec<f64> = steps().map(|(times, ends)| secant(times, ends)).collect();
        held.insert(0, held.first().copied().unwrap_or(0.0));
        let velocity = match motion {
            Motion::Velocity(v) => v.to_vec(),
            Motion::Position(_) => {
                let mut middle: Vec<f64> =
                    held.windows(2).map(|pair| 0.5 * pair.iter().sum::<f64>()).collect();
                // Row k lies between the intervals k and k + 1; the last has no interval after it.
                middle.remove(0);
                let (first, last) = (held.first().copied(), held.last().copied());
                let ends = (first.unwrap_or(0.0), last.unwrap_or(0.0));
                core::iter::once(ends.0).chain(middle).chain([ends.1]).collect()
            }
        };
        let coefficient: Vec<f64> = match normal_force {
            Some(normal) => friction.iter().zip(normal).map(|(f, p)| f / p).collect(),
            None => friction.to_vec(),
        };
        // A quotient of two finite numbers can be infinite.
        if let Some((row, &value)) =
            coefficient.iter().enumerate().find(|&(_, mu): &(_, &f64)| !mu.is_finite())
        {
            let column = "friction/normal_force";
            return Err(IdentifyError::Row { row, column, value, rule: "be finite" });
        }
        let log = Self {
            time: time.to_vec(),
            held,
            velocity,
            coefficient,
            normalised: normal_force.is_some(),
        };
        log.plausible()?;
        Ok(log)
    }

    /// Refuses what only a slip of units makes.
    fn plausible(&self) -> Result<(), IdentifyError> {
        let refuse =
            |row, column, value, rule| Err(IdentifyError::Row { row, column, value, rule });
        if let Some((row, &value)) = self.held.iter().enumerate().find(|(_, v)| !(v.abs() <= 1e4)) {
            return refuse(row, "velocity", value, "lie between -10000 and 10000 m/s (units?)");
        }
        if self.normalised {
            let mut sizes: Vec<f64> = self.coefficient.iter().map(|mu| mu.abs()).collect();
            let median = median(&mut sizes);
            if !(median >= 1e-4) {
                return Err(IdentifyError::Implausible {
                    quantity: "the median of |friction|/normal_force",
                    value: median,
                    rule: "be at least 0.0001 (units?)",
                });
            }
            if median > 100.0 {
                return Err(IdentifyError::Implausible {
                    quantity: "the median of |friction|/normal_force",
                    value: median,
                    rule: "be at most 100 (units?)",
                });
            }
        }
        let travel = self.travel();
        if !(travel >= 1e-9) {
            return Err(IdentifyError::Implausible {
                quantity: "the travel in m",
                value: travel,
                rule: "be at least 1e-9 (units?)",
            });
        }
        Ok(())
    }

    /// The rows with from ≤ t ≤ to \[s\].
    ///
    /// # Errors
    ///
    /// Refuses a window of fewer than 20 rows, and an end that is NaN; both may be infinite.
    pub fn between(&self, from: f64, to: f64) -> Result<Self, IdentifyError> {
        for (name, value) in [("from", from), ("to", to)] {
            if value.is_nan() {
                return Err(IdentifyError::Setting { name, value, rule: "be a number" });
            }
        }
        let first = self.time.partition_point(|&t| t < from);
        let end = self.time.partition_point(|&t| t <= to).max(first);
        if end - first < FEWEST {
            return Err(IdentifyError::TooFewRows { rows: end - first, least: FEWEST });
        }
        let part = |column: &[f64]| column.get(first..end).unwrap_or_default().to_vec();
        Ok(Self {
            time: part(&self.time),
            held: part(&self.held),
            velocity: part(&self.velocity),
            coefficient: part(&self.coefficient),
            normalised: self.normalised,
        })
    }

    /// Number of rows.
    #[expect(clippy::len_without_is_empty, reason = "a log is never empty")]
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Time \[s\] of each row.
    pub fn times(&self) -> &[f64] {
        &self.time
    }

    /// Sliding velocity [m/s] at each row: as measured, or of a position the mean of the differences before and after.
    pub fn velocities(&self) -> &[f64] {
        &self.velocity
    }

    /// Friction coefficient F/p \[–\] at each row.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficient
    }

    /// Position \[m\] at each row, from zero at the first.
    pub fn positions(&self) -> Vec<f64> {
        let mut position = 0.0;
        let mut before = None;
        let rows = self.time.iter().zip(&self.held);
        rows.map(|(&time, &velocity)| {
            if let Some(before) = before.replace(time) {
                position += velocity * (time - before);
            }
            position
        })
        .collect()
    }

    /// Largest distance \[m\] between two positions.
    fn travel(&self) -> f64 {
        let range = |(least, most): (f64, f64), x: f64| (least.min(x), most.max(x));
        let (least, most) = self.positions().into_iter().fold((0.0, 0.0), range);
        most - least
    }
}

/// The median; zero of nothing.
pub(super) fn median(values: &mut [f64]) -> f64 {
    quantile(values, 0.5)
}

/// The value below which a share of all lies; zero of nothing.
pub(super) fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let index = (share * values.len().saturating_sub(1) as f64) as usize;
    values.get(index).copied().unwrap_or(0.0)
}
