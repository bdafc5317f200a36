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

use core::ops::Range;
use std::sync::Mutex;

use super::joint::Model;
use super::log::DriveLog;
use super::plant::Plant;
use crate::problem::Objective;
use bristle::Scalar;
use bristle::parameter::Checked;
use bristle::scalar::lit;
use bristle_joint::LoadedDeflection;

/// The length of segments that stands for the inverse criterion.
pub(super) const INVERSE: f64 = 0.0;
/// The length of segments that stands for whole logs.
pub(super) const WHOLE: f64 = f64::INFINITY;

/// The residuals of a model along logs.
#[derive(Debug, Clone)]
pub(super) struct Errors<'a> {
    pub(super) model: &'a Model,
    pub(super) logs: &'a [DriveLog],
    /// Length of the segments \[s\], [`INVERSE`] or [`WHOLE`].
    pub(super) length: f64,
    /// Largest gradient of a row that counts for the standard errors \[rad\].
    pub(super) largest_gradient: f64,
    /// Square roots of the weights of the residuals of each log; one where there is none.
    pub(super) weights: Vec<Vec<f64>>,
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

impl<'a> Errors<'a> {
    /// Without weights, and whatever their gradients.
    pub(super) fn new(model: &'a Model, logs: &'a [DriveLog], length: f64) -> Self {
        Self { model, logs, length, largest_gradient: f64::INFINITY, weights: Vec::new() }
    }

    /// The residuals of the mechanism of a log.
    fn of_plant<T: Scalar>(&self, plant: &Plant<'_, T>, log: &DriveLog) -> Checked<Vec<T>> {
        let mut residuals = Vec::new();
        let inverse = self.length == INVERSE;
        let length = if inverse { WHOLE } else { self.length };
        // The bristle that follows the measured motion, from segment to segment.
        let mut bristle = LoadedDeflection::none();
        let mut reached = None;
        for mut segment in segments(log, length) {
            let Some(first) = log.rows.get(segment.start) else { continue };
            let (is_first, is_fresh) = (segment.start == 0, reached != Some(segment.start));
            if is_fresh {
                bristle = plant.deflected(first);
            }
            reached = Some(segment.end);
            if inverse {
                residuals.push(plant.imbalance(first, bristle.deflection));
            } else {
                if is_fresh {
                    let begins = plant.begins(&segment);
                    for row in segment.start..begins {
                        bristle = plant.follow(bristle, row)?;
                        residuals.push(T::zero());
                    }
                    segment.start = begins;
                }
                let Some(first) = log.rows.get(segment.start) else { continue };
                let mut state = plant.begin(first, bristle, is_first);
                let measured = log.position.iter().skip(segment.start + 1);
                for (row, &position) in segment.clone().zip(measured) {
                    state = plant.advance(state, row)?;
                    residuals.push(state.joint.angle - lit(position));
                }
            }
            if self.length == WHOLE {
                continue;
            }
            for row in segment {
                bristle = plant.follow(bristle, row)?;
                if let (true, Some(after)) = (inverse, log.rows.get(row + 1)) {
                    residuals.push(plant.imbalance(after, bristle.deflection));
                }
            }
        }
        Ok(residuals)
    }

    /// Sum of squares to which those of a log are compared: of the motor's torque, or of the
    /// position about its mean in each segment.
    pub(super) fn whole(&self, number: usize, log: &DriveLog, values: &[f64]) -> f64 {
        if self.length == INVERSE {
            let plant = Plant::new(self.model, log, number, values);
            let torque = |row| plant.as_ref().map_or(f64::NAN, |plant| plant.measured(row).motor);
            return log.rows.iter().map(|row| torque(row).powi(2)).sum();
        }
        let about_mean = |rows: Range<usize>| -> f64 {
            let ours = log.position.get(rows).unwrap_or_default();
            let mean = ours.iter().sum::<f64>() / ours.len() as f64;
            ours.iter().map(|x| (x - mean) * (x - mean)).sum()
        };
        segments(log, self.length).into_iter().map(about_mean).sum()
    }

    /// The weighted residuals log by log, by as many threads as the machine has. A log without
    /// weights is not simulated.
    pub(super) fn by_log<T: Scalar>(&self, values: &[T]) -> Checked<Vec<Vec<T>>> {
        let of_log = |number: usize, log: &DriveLog| {
            let weights = self.weights.get(number).map_or(&[][..], Vec::as_slice);
            if !weights.is_empty() && weights.iter().all(|&weight| weight == 0.0) {
                return Ok(vec![T::zero(); weights.len()]);
            }
            let plant = Plant::new(self.model, log, number, values)?;
            let mut residuals = self.of_plant(&plant, log)?;
            residuals.iter_mut().zip(weights).for_each(|(r, &weight)| *r *= lit(weight));
            Ok(residuals)
        };
        side_by_side(self.logs, of_log).into_iter().collect()
    }
}

impl Objective for Errors<'_> {
    fn evaluate<T: Scalar>(&self, values: &[T], each: &mut impl FnMut(T)) -> Checked<()> {
        self.by_log(values)?.into_iter().flatten().for_each(each);
        Ok(())
    }

    /// Logs that do not depend on the parameter are not simulated.
    fn evaluate_by<T: Scalar>(
        &self,
        values: &[T],
        parameter: usize,
        each: &mut impl FnMut(T),
    ) -> Checked<()> {
        let Some(&Some(own)) = self.model.of_logs.get(parameter) else {
            return self.evaluate(values, each);
        };
        let more = usize::from(self.length == INVERSE);
        let rows = |log| segments(log, WHOLE).iter().map(|rows| rows.len() + more).sum();
        let mut weights: Vec<_> = self.logs.iter().map(|log| vec![0.0; rows(log)]).collect();
        if let Some(ours) = weights.get_mut(own) {
            *ours = self.weights.get(own).cloned().unwrap_or_default();
        }
        Errors { weights, ..*self }.evaluate(values, each)
    }
}

/// What a function gives for each of a list with its number, in their order, by as many threads as
/// the machine has.
fn side_by_side<I: Sync, R: Send>(list: &[I], of: impl Fn(usize, &I) -> R + Sync) -> Vec<R> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(list.len());
    let mut results: Vec<Option<R>> = list.iter().map(|_| None).collect();
    let left = Mutex::new(list.iter().enumerate().zip(&mut results));
    let work = || {
        let next = || left.lock().ok()?.next();
        while let Some(((number, item), result)) = next() {
            *result = Some(of(number, item));
        }
    };
    std::thread::scope(|scope| {
        let start = |_| std::thread::Builder::new().spawn_scoped(scope, work).ok();
        let others: Vec<_> = (1..threads).filter_map(start).collect();
        work();
        for other in others {
            // A panic of a term of the user's own.
            other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        }
    });
    results.into_iter().flatten().collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::mechanism::joint::INITIAL;
    use crate::mechanism::start::guess;
    use crate::mechanism::{Drive, DriveLogParameters, Friction, Joint, KnownLoad, Term};
    use num_dual::Dual64;

    /// Dual numbers against central differences, residual by residual.
    fn sensitivities(friction: Friction, length: f64) {
        let time: Vec<f64> = (0..200).map(|i| 5e-3 * f64::from(i)).collect();
        let position: Vec<f64> = time.iter().map(|t| 0.6 * (7.0 * t).sin()).collect();
        let goal: Vec<f64> = time.iter().map(|t| 0.9 * (7.0 * t + 0.4).sin()).collect();
        let supply = vec![7.0; 200];
        let drive = Drive::Duty { goal: &goal, gain: 1.1, derivative_gain: 0.02, supply: &supply };
        let load = KnownLoad { inertia: 0.005, gravity_torque: 0.1 };
        let columns =
            DriveLogParameters { load, ..DriveLogParameters::new(&time, &position, drive) };
        let log = DriveLog::new(columns).unwrap();
        let logs = [log.between(0.2, 0.7).unwrap().in_motion(), log];
        let fan = Term::own("fan", "N m s²/rad²", |_, v| [-v.abs() * v, 0.0, -2.0 * v.abs()]);
        let joint = Joint::new()
            .with(Term::Gravity)
            .with(Term::constant())
            .with(Term::spring())
            .with(fan)
            .start("inertia", 0.01)
            .start("torque_constant", 0.4)
            .start("resistance", 3.0)
            .start("duty_exponent", 0.8)
            .start("inductance", 0.01)
            .start("fan", 1e-3)
            .start("spring_rate", 0.1)
            .start("drag", 0.01)
            .start("coulomb_torque", 0.1);
        let guess = guess(&joint, &logs).unwrap();
        let model = joint.model(&friction, &guess, &logs).unwrap();
        let model = Model { fastest: 20.0, step: 1e-3, ..model };
        let errors = Errors::new(&model, &logs, length);
        let parameters = &model.parameters;
        let values: Vec<f64> = parameters.iter().map(|p| p.start).collect();
        let searched = |(_, p): &(usize, &crate::Parameter)| p.least < p.most;
        for (i, parameter) in parameters.iter().enumerate().filter(searched) {
            let seed = |j| f64::from(u8::from(i == j));
            let duals = values.iter().enumerate().map(|(j, &value)| Dual64::new(value, seed(j)));
            let duals: Vec<Dual64> = duals.collect();
            let mut exact = Vec::new();
            errors.evaluate(&duals, &mut |r: Dual64| exact.push(r.eps)).unwrap();
            let mut alone = Vec::new();
            errors.evaluate_by(&duals, i, &mut |r: Dual64| alone.push(r.eps)).unwrap();
            assert_eq!(alone, exact, "{friction} over {length} s {}", parameter.name);
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
                    "{friction} over {length} s {} row {row}: {difference} {dual}",
                    parameter.name
                );
            }
            let acts = length != INVERSE || !INITIAL.contains(&parameter.name);
            assert!(!acts || scale > 0.0, "{friction} over {length} s {}", parameter.name);
        }
    }

    #[test]
    fn sensitivities_are_those_of_the_residuals() {
        for length in [INVERSE, 0.2] {
            for friction in [
                Friction::dahl().loaded(),
                Friction::frbd().loaded().directional(),
                Friction::lugre().loaded(),
            ] {
                sensitivities(friction, length);
            }
        }
    }

    #[test]
    fn segments_cover_every_row_once_and_leave_no_remainder() {
        let time: Vec<f64> = (0..25).map(|i| 0.1 * f64::from(i)).collect();
        let torque = vec![0.0; 25];
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
