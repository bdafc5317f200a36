//! Three measures of how well a mechanism explains a log.
//!
//! | criterion | residual | unit |
//! |---|---|---|
//! | inverse | torque that the measured motion needs, less friction: the equation of motion | N m |
//! | segments | position after a start from the measured motion, over segments of a length | rad |
//! | simulated | position, from the first row of a log on | rad |
//!
//! The inverse criterion is smooth in the parameters and finds them from far, but is as good as the
//! derivatives of the position. The simulated one is what a simulator needs, and can be rugged:
//! after a slip that comes late everything is late. Segments lie between the two.
//!
//! A segment starts with position and velocity of the smoothed log, and with the deflection of a
//! bristle that has been moved along the measured motion. At the first row, and after a gap, it is
//! the deflection that balances the other torques.

use alloc::vec::Vec;
use core::ops::Range;

use super::friction::Friction;
use super::joint::{Joint, MotorConstants, Table};
use super::log::DriveLog;
use super::plant::{Plant, State};
use super::smooth::Smoothed;
use crate::problem::Objective;
use bristle::Scalar;
use bristle::parameter::ParameterError;
use bristle::scalar::lit;

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Criterion {
    Inverse,
    /// Length of the segments \[s\]; infinite for the whole log.
    Segments(f64),
}

/// Logs with what was computed from them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Data<'a> {
    pub(super) logs: &'a [DriveLog],
    pub(super) smoothed: &'a [Vec<Smoothed>],
}

/// The residuals of a joint along logs.
#[derive(Debug, Clone)]
pub(super) struct Errors<'a> {
    pub(super) joint: &'a Joint,
    pub(super) friction: &'a Friction,
    pub(super) table: &'a Table,
    pub(super) data: Data<'a>,
    pub(super) constants: MotorConstants,
    pub(super) fastest: f64,
    /// Longest step \[s\].
    pub(super) step: f64,
    /// Largest gradient of a row that counts for the standard errors \[rad\].
    pub(super) largest_gradient: f64,
    pub(super) criterion: Criterion,
    /// Square roots of the weights of all residuals; one where there is none.
    pub(super) weights: Vec<f64>,
}

/// The segments of a log: from the row of the start to the last one.
pub(super) fn segments(log: &DriveLog, length: f64) -> Vec<Range<usize>> {
    let mut segments = Vec::new();
    for piece in log.pieces() {
        let last = piece.end - 1;
        let mut from = piece.start;
        while from < last {
            let begin = log.time.get(from).copied().unwrap_or(0.0);
            let until = log.time.partition_point(|&t| t <= begin + length * (1.0 + 1e-9));
            let mut end = until.saturating_sub(1).clamp(from + 1, last);
            // No segment of a remainder.
            if (last - end) < (end - from) / 2 {
                end = last;
            }
            segments.push(from..end);
            from = end;
        }
    }
    segments
}

/// The numbers of residuals of the parts of a log: of its segments, or of all its rows.
pub(super) fn counts(log: &DriveLog, criterion: Criterion) -> Vec<usize> {
    match criterion {
        Criterion::Inverse => {
            let pieces = segments(log, f64::INFINITY);
            alloc::vec![pieces.into_iter().map(|piece| piece.len() + 1).sum()]
        }
        Criterion::Segments(length) => {
            segments(log, length).into_iter().map(|segment| segment.len()).collect()
        }
    }
}

impl Errors<'_> {
    fn of_log<T: Scalar>(
        &self,
        number: usize,
        log: &DriveLog,
        rows: &[Smoothed],
        values: &[T],
        each: &mut impl FnMut(T),
    ) -> Result<(), ParameterError> {
        let values = self.table.of_log(values, number);
        let mut plant = Plant::new(
            self.joint,
            self.friction,
            (log, rows),
            self.constants,
            self.fastest,
            &values,
        )?;
        let length = match self.criterion {
            Criterion::Inverse => f64::INFINITY,
            Criterion::Segments(length) => length,
        };
        let mut deflection = T::zero();
        let mut reached = None;
        for segment in segments(log, length) {
            let Some(first) = rows.get(segment.start) else { continue };
            if reached != Some(segment.start) {
                deflection = plant.deflected(first)?;
            }
            reached = Some(segment.end);
            if self.criterion == Criterion::Inverse {
                each(plant.remaining(first) - plant.friction(first, deflection));
            } else {
                self.simulate(&mut plant, &segment, first, deflection, each)?;
            }
            let follows = self.criterion == Criterion::Inverse || length.is_finite();
            let pairs = rows
                .iter()
                .zip(rows.iter().skip(1))
                .zip(log.time.iter().zip(log.time.iter().skip(1)));
            let pairs = pairs.skip(segment.start).take(if follows { segment.len() } else { 0 });
            for ((before, after), (from, to)) in pairs {
                deflection = plant.follow(deflection, before, after, to - from)?;
                if self.criterion == Criterion::Inverse {
                    each(plant.remaining(after) - plant.friction(after, deflection));
                }
            }
        }
        Ok(())
    }

    /// Passes the errors of the position over a segment to `each`.
    fn simulate<T: Scalar>(
        &self,
        plant: &mut Plant<'_, T>,
        segment: &Range<usize>,
        first: &Smoothed,
        deflection: T,
        each: &mut impl FnMut(T),
    ) -> Result<(), ParameterError> {
        let Smoothed { position, velocity, acceleration, .. } = *first;
        let [position, velocity, acceleration] = [position, velocity, acceleration].map(lit);
        let mut state = State { position, velocity, deflection, acceleration };
        // The load of the bristle that follows the measured motion stays what it is.
        let gear = plant.gear.clone();
        for row in segment.clone() {
            let (from, to) = (plant.time(row), plant.time(row + 1));
            let steps = ((to - from) / self.step - 1e-6).ceil().clamp(1.0, 1e6) as u32;
            state = plant.advance(state, row, steps)?;
            each(state.position - lit(plant.position(row + 1)));
        }
        plant.gear = gear;
        Ok(())
    }

    /// The residuals of each segment, or of each log by the inverse criterion. Empty where the
    /// model has no answer.
    pub(super) fn by_segment(&self, values: &[f64]) -> Vec<Vec<f64>> {
        let mut all = Vec::new();
        if self.evaluate(values, &mut |r: f64| all.push(r)).is_err() {
            return Vec::new();
        }
        let mut rest = all.as_slice();
        let mut parts = Vec::new();
        for log in self.data.logs {
            for count in counts(log, self.criterion) {
                let (part, others) = rest.split_at_checked(count).unwrap_or((rest, &[]));
                parts.push(part.to_vec());
                rest = others;
            }
        }
        parts
    }
}

impl Objective for Errors<'_> {
    fn largest_gradient(&self) -> f64 {
        self.largest_gradient
    }

    fn evaluate<T: Scalar>(
        &self,
        values: &[T],
        each: &mut impl FnMut(T),
    ) -> Result<(), ParameterError> {
        let mut weights = self.weights.iter();
        let mut weighted = |r: T| {
            each(match weights.next() {
                Some(&weight) => r * lit(weight),
                None => r,
            })
        };
        for (number, (log, rows)) in self.data.logs.iter().zip(self.data.smoothed).enumerate() {
            self.of_log(number, log, rows, values, &mut weighted)?;
        }
        Ok(())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::mechanism::smooth::smooth;
    use crate::mechanism::start::guess;
    use crate::mechanism::{Drive, DriveLogParameters, KnownLoad, Term};
    use num_dual::DualSVec64;

    /// Dual numbers against central differences, residual by residual.
    fn sensitivities(friction: Friction, criterion: Criterion) {
        let time: Vec<f64> = (0..200).map(|i| 5e-3 * f64::from(i)).collect();
        let position: Vec<f64> = time.iter().map(|t| 0.6 * (7.0 * t).sin()).collect();
        let goal: Vec<f64> = time.iter().map(|t| 0.9 * (7.0 * t + 0.4).sin()).collect();
        let supply = alloc::vec![7.0; 200];
        let drive = Drive::Duty { goal: &goal, gain: 1.1, supply: &supply };
        let load = KnownLoad { inertia: 0.005, gravity_torque: 0.1 };
        let columns =
            DriveLogParameters { load, ..DriveLogParameters::new(&time, &position, drive) };
        let logs = [DriveLog::new(columns).unwrap()];
        let fan = Term::own("fan", "N m s²/rad²", |_, v| [-v.abs() * v, 0.0, -2.0 * v.abs()]);
        let joint = Joint::new()
            .with(Term::Gravity)
            .with(Term::Constant)
            .with(Term::Spring)
            .with(fan)
            .start("inertia", 0.01)
            .start("torque_constant", 0.4)
            .start("resistance", 3.0)
            .start("duty_exponent", 0.8)
            .start("fan", 1e-3)
            .start("spring_rate", 0.1)
            .start("drag", 0.01)
            .start("coulomb_torque", 0.1);
        let smoothed = [smooth(&logs[0])];
        let guess = guess(&joint, &logs, &smoothed).unwrap();
        let table = joint.table(&friction, &guess, 1).unwrap();
        let errors = Errors {
            joint: &joint,
            friction: &friction,
            table: &table,
            data: Data { logs: &logs, smoothed: &smoothed },
            constants: guess.constants,
            fastest: 20.0,
            step: 1e-3,
            largest_gradient: f64::INFINITY,
            criterion,
            weights: Vec::new(),
        };
        let values: Vec<f64> = table.parameters.iter().map(|p| p.start).collect();
        for (i, parameter) in table.parameters.iter().enumerate() {
            let duals: Vec<DualSVec64<1>> = (values.iter().enumerate())
                .map(|(j, &value)| {
                    let dual = DualSVec64::from_re(value);
                    if i == j { dual.derivative(0) } else { dual }
                })
                .collect();
            let mut exact = Vec::new();
            errors
                .evaluate(&duals, &mut |r: DualSVec64<1>| {
                    exact.push(r.eps.unwrap_generic(nalgebra::Const::<1>, nalgebra::U1)[0]);
                })
                .unwrap();
            let size = parameter.typical.unwrap_or(parameter.start);
            let run = |change: f64| {
                let (mut moved, mut residuals) = (values.clone(), Vec::new());
                moved[i] += change * size;
                errors.evaluate(&moved, &mut |r: f64| residuals.push(r)).unwrap();
                residuals
            };
            let (up, down) = (run(1e-6), run(-1e-6));
            let scale = exact.iter().fold(0.0, |most, d| f64::max(most, d.abs())) * size;
            for (row, (up, down)) in up.iter().zip(&down).enumerate() {
                let (difference, dual) = ((up - down) / 2e-6, exact[row] * size);
                // A step that a reversal or the limit of the duty divides differs in a few rows'
                // second order: 10⁻⁶ of the largest; roundings are 10⁻¹⁶/10⁻⁶ of the position.
                assert!(
                    (difference - dual).abs() < 1e-4 * scale + 1e-8,
                    "{friction} {criterion:?} {} row {row}: {difference} {dual}",
                    parameter.name
                );
            }
            assert!(scale > 0.0, "{friction} {criterion:?} {}", parameter.name);
        }
    }

    #[test]
    fn sensitivities_are_those_of_the_residuals() {
        for criterion in [Criterion::Inverse, Criterion::Segments(0.2)] {
            for friction in [
                Friction::dahl().loaded(),
                Friction::frbd().loaded().directional(),
                Friction::lugre().loaded(),
            ] {
                sensitivities(friction, criterion);
            }
        }
    }

    #[test]
    fn segments_cover_every_row_once_and_leave_no_remainder() {
        let time: Vec<f64> = (0..25).map(|i| 0.1 * f64::from(i)).collect();
        let torque = alloc::vec![0.0; 25];
        let drive = Drive::Torque(&torque);
        let mut columns = DriveLogParameters::new(&time, &time, drive);
        let log = DriveLog::new(columns).unwrap();
        // Rows 20 to 24 are less than half a segment more.
        assert_eq!(segments(&log, 1.0), [0..10, 10..24]);
        assert_eq!(segments(&log, f64::INFINITY), core::slice::from_ref(&(0..24)));
        // After a gap they begin anew.
        let shifted: Vec<f64> = time.iter().map(|t| if *t > 1.15 { t + 9.0 } else { *t }).collect();
        columns.time = &shifted;
        let log = DriveLog::new(columns).unwrap();
        assert_eq!(segments(&log, f64::INFINITY), [0..11, 12..24]);
    }
}
