//! Measured motion and friction, checked row by row.

use core::ops::Range;

use bristle::parameter::{Checked, Named, ParameterError};

/// Fewest rows of a log.
pub(super) const FEWEST: usize = 20;

/// What was measured of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MeasuredMotion<'a> {
    /// Position x \[m\] at each time. Between two rows the velocity is Δx/Δt.
    Position(&'a [f64]),
    /// Sliding velocity v [m/s] at each time. Between two rows it is the mean of both.
    Velocity(&'a [f64]),
}

/// What a [`Log`] is made of: columns of equal length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogParameters<'a> {
    /// Time t \[s\], increasing.
    pub time: &'a [f64],
    /// Position or velocity.
    pub motion: MeasuredMotion<'a>,
    /// Friction force F \[N\], positive against v > 0: the force that brakes.
    pub friction: &'a [f64],
    /// Normal force p \[N\], positive. Without it p = 1 N, and μ stands for a force or a torque.
    pub normal_force: Option<&'a [f64]>,
}

/// Measured motion and friction.
///
/// ```
/// use bristle_identify::{Log, LogParameters, MeasuredMotion};
///
/// let time: Vec<f64> = (0..100).map(|i| 1e-2 * f64::from(i)).collect();
/// let velocity: Vec<f64> = time.iter().map(|t| 1e-3 * (6.0 * t).sin()).collect();
/// let mut friction: Vec<f64> = velocity.iter().map(|v| 2.0 * (v / 1e-4).tanh()).collect();
/// friction[42] = f64::NAN;
/// let columns = LogParameters {
///     time: &time,
///     motion: MeasuredMotion::Velocity(&velocity),
///     friction: &friction,
///     normal_force: None,
/// };
/// let refused = Log::new(columns).unwrap_err();
/// assert_eq!(
///     refused.to_string(),
///     "friction[42] is NaN, but must lie between -1e100 and 1e100"
/// );
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    pub(super) time: Vec<f64>,
    /// Velocity held over the interval that ends at each row. The first row repeats the second.
    pub(super) held: Vec<f64>,
    /// Velocity at each row.
    pub(super) velocity: Vec<f64>,
    /// F/p at each row.
    pub(super) coefficient: Vec<f64>,
    /// Time at the beginning that does not count.
    settle: f64,
}

/// Fastest speed [m/s] that a log may have; millimetres taken for metres give more.
const FASTEST: f64 = 1e4;
/// Least and largest median of |F|/p: five decades around friction coefficients, which are of order
/// one.
const COEFFICIENTS: (f64, f64) = (1e-4, 100.0);
/// Shortest travel [m], below any distance over which friction is measured.
const SHORTEST: f64 = 1e-9;

impl Log {
    /// Checks the columns.
    ///
    /// # Errors
    ///
    /// Names the column, the row, the value and the rule. Columns must have one length of at least
    /// 20 rows. Every number must be finite, the time increasing and the normal force positive.
    ///
    /// Magnitudes that only a mistake in units explains are refused: a speed above 10⁴ m/s, a
    /// travel below a nanometre, and, with a normal force, a median |F|/p outside 10⁻⁴ … 100.
    pub fn new(parameters: LogParameters<'_>) -> Checked<Self> {
        let LogParameters { time, motion, friction, normal_force } = parameters;
        let time = times(time)?;
        let finite = |names, values| column(names, values, time.len(), Named::finite);
        let mut coefficient = finite(["friction", "rows of friction"], friction)?;
        if let Some(normal) = normal_force {
            let names = ["normal_force", "rows of normal_force"];
            let normal = column(names, normal, time.len(), Named::positive)?;
            coefficient.iter_mut().zip(normal).for_each(|(f, p)| *f /= p);
        }
        let (along, is_position) = match motion {
            MeasuredMotion::Position(x) => (finite(["position", "rows of position"], x)?, true),
            MeasuredMotion::Velocity(v) => (finite(["velocity", "rows of velocity"], v)?, false),
        };
        let mean_velocity = |((start, end), (a, b)): ((f64, f64), (f64, f64))| {
            if is_position { (b - a) / (end - start) } else { 0.5 * (a + b) }
        };
        let mut held: Vec<f64> = pairs(&time).zip(pairs(&along)).map(mean_velocity).collect();
        held.insert(0, held.first().copied().unwrap_or(0.0));
        let velocity = if is_position {
            // The mean of the intervals before and after each row; at the ends, of one.
            let after = held.iter().skip(1).chain(held.last());
            held.iter().zip(after).map(|(before, after)| 0.5 * (before + after)).collect()
        } else {
            along
        };
        let log = Self { time, held, velocity, coefficient, settle: 0.0 };
        log.check_magnitudes(normal_force.is_some())?;
        Ok(log)
    }

    /// Refuses what only a mistake in units explains.
    fn check_magnitudes(&self, normalised: bool) -> Checked<()> {
        let rule = "lie between -10000 and 10000 m/s (units?)";
        let usual = |&v: &f64| Named("velocity", v).stated(v.abs() <= FASTEST, rule);
        ParameterError::of_components(&self.held, usual)?;
        if normalised {
            let name = "the median of |friction|/normal_force";
            let mut sizes: Vec<f64> = self.coefficient.iter().map(|mu| mu.abs()).collect();
            let median = median(&mut sizes);
            let (least, most) = COEFFICIENTS;
            Named(name, median).stated(median >= least, "be at least 0.0001 (units?)")?;
            Named(name, median).stated(median <= most, "be at most 100 (units?)")?;
        }
        let travel = extent(&self.positions());
        let rule = "be at least 1e-9 (units?)";
        Named("the travel in m", travel).stated(travel >= SHORTEST, rule).map(drop)
    }

    /// The log whose first `duration` \[s\] does not count in [`fit`](super::fit) and
    /// [`Log::rmse`]: until then the bristle has not forgotten its initial deflection.
    ///
    /// # Errors
    ///
    /// Refuses a duration that is negative or not finite.
    pub fn settling(self, duration: f64) -> Checked<Self> {
        Ok(Self { settle: Named("settling time", duration).non_negative()?, ..self })
    }

    /// The rows with from ≤ t ≤ to \[s\]; the settling time begins anew.
    ///
    /// # Errors
    ///
    /// Refuses a window of fewer than 20 rows, and an end that is NaN; both may be infinite.
    pub fn between(&self, from: f64, to: f64) -> Checked<Self> {
        let rows = window(&self.time, from, to)?;
        let part = |column: &[f64]| column.get(rows.clone()).unwrap_or_default().to_vec();
        Ok(Self {
            time: part(&self.time),
            held: part(&self.held),
            velocity: part(&self.velocity),
            coefficient: part(&self.coefficient),
            settle: self.settle,
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

    /// Sliding velocity [m/s] at each row: as measured, or, from a position, the mean of the
    /// differences before and after.
    pub fn velocities(&self) -> &[f64] {
        &self.velocity
    }

    /// Friction coefficient F/p \[–\] at each row.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficient
    }

    /// The first row that counts.
    pub(super) fn settled(&self) -> usize {
        let begin = self.time.first().copied().unwrap_or(0.0) + self.settle;
        self.time.partition_point(|&t| t < begin)
    }

    /// Root mean square of the difference between a friction coefficient at every row and the
    /// measured one, over the rows that count.
    pub fn rmse(&self, coefficients: &[f64]) -> f64 {
        let rows = coefficients.iter().zip(&self.coefficient).skip(self.settled());
        let squares = rows.clone().map(|(model, measured)| (model - measured) * (model - measured));
        f64::sqrt(squares.sum::<f64>() / rows.count() as f64)
    }

    /// Work \[m\] of a friction coefficient at every row, over the normal force, along the whole
    /// log: [`Log::coefficients`] gives the measured one.
    pub fn work(&self, coefficients: &[f64]) -> f64 {
        let step = |((from, to), (before, after))| (to - from) * 0.5 * (before + after);
        pairs(&self.positions()).zip(pairs(coefficients)).map(step).sum()
    }

    /// Position \[m\] at each row, from zero at the first.
    pub fn positions(&self) -> Vec<f64> {
        let mut position = 0.0;
        let steps = pairs(&self.time).zip(self.held.iter().skip(1));
        let positions = steps.map(|((before, time), velocity)| {
            position += velocity * (time - before);
            position
        });
        core::iter::once(0.0).chain(positions).collect()
    }
}

/// Neighbouring values.
pub(super) fn pairs(values: &[f64]) -> impl Iterator<Item = (f64, f64)> {
    values.iter().copied().zip(values.iter().copied().skip(1))
}

/// From the first time to the last.
pub(super) fn span(time: &[f64]) -> f64 {
    time.last().zip(time.first()).map_or(0.0, |(last, first)| last - first)
}

/// The rows with from ≤ t ≤ to; at least as many as a log has.
pub(super) fn window(time: &[f64], from: f64, to: f64) -> Checked<Range<usize>> {
    Named("from", from).number()?;
    Named("to", to).number()?;
    let first = time.partition_point(|&t| t < from);
    let end = time.partition_point(|&t| t <= to).max(first);
    Named("rows", end - first).count(FEWEST)?;
    Ok(first..end)
}

/// Times, if there are enough of them and they increase.
pub(super) fn times(time: &[f64]) -> Checked<Vec<f64>> {
    Named("rows", time.len()).count(FEWEST)?;
    let mut before = f64::NEG_INFINITY;
    ParameterError::of_components(time, |&value| {
        Named("time", value).increasing(core::mem::replace(&mut before, value))
    })?;
    Ok(time.to_vec())
}

/// A column, if it has so many rows and all its values obey a rule: its name, and what its rows are
/// called.
pub(super) fn column(
    [name, rows_of_it]: [&'static str; 2],
    values: &[f64],
    rows: usize,
    check: impl Fn(Named<f64>) -> Checked<f64>,
) -> Checked<Vec<f64>> {
    Named(rows_of_it, values.len()).count_between(rows, rows)?;
    let checked = |(row, &value)| ParameterError::of_component(row, check(Named(name, value)));
    values.iter().enumerate().map(checked).collect()
}

/// The smallest and the largest value.
pub(super) fn range(values: &[f64]) -> (f64, f64) {
    let wider = |(least, most): (f64, f64), &x: &f64| (least.min(x), most.max(x));
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), wider)
}

/// How far the largest value is from the smallest.
pub(super) fn extent(values: &[f64]) -> f64 {
    let (least, most) = range(values);
    most - least
}

/// The median; zero for no values.
pub(super) fn median(values: &mut [f64]) -> f64 {
    quantile(values, 0.5)
}

/// The value below which a share of all values lies; zero for no values.
pub(super) fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let index = (share * values.len().saturating_sub(1) as f64) as usize;
    values.get(index).copied().unwrap_or(0.0)
}
