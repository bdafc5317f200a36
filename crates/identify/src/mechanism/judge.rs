//! What speaks against a result: logs that the model does not explain, degrees, one load only.
//!
//! A log is not explained where the errors of the position are larger than a third of the standard
//! deviation of the motion, both over the segments that were fitted. A ninth of its variance is
//! then left, where a position that stays at its mean leaves all of it. Noise and friction that is
//! modelled a little wrong leave a hundredth at most; a wrong sign or a missing torque leave nearly
//! all.

use super::criteria::INVERSE;
use super::log::DriveLog;
use super::plant::Plant;
use super::report::{GroupScores, JointFit, Score};
use crate::log::extent;
use crate::{Identifiability, Remark};

/// Range of positions of a pendulum [rad] that looks like degrees: more than four turns.
const TURNS: f64 = 25.0;
/// Variation of the external torque over the largest torque, below which there is one load only.
const ONE_LOAD: f64 = 0.1;
/// Error over motion from which on a log is not explained.
const UNEXPLAINED: f64 = 1.0 / 3.0;
/// Least motion that is to be explained, over that of the log that moves most: a joint that sticks
/// moves by counts of its encoder.
const LEAST_MOTION: f64 = 0.03;

/// Adds what speaks against the result.
pub(super) fn judge(result: &mut JointFit, logs: &[DriveLog]) {
    let unexplained = unexplained(result, logs);
    let one_load = one_load(result, logs);
    let at_bound =
        |verdict| matches!(verdict, Identifiability::AtLowerBound | Identifiability::AtUpperBound);
    let ratio = result.fit.estimate("backward_ratio").map(|estimate| estimate.verdict);
    let one_way = ratio.is_some_and(at_bound) && result.fit.estimate("offset_torque").is_some();
    for estimate in &mut result.fit.estimates {
        let name = estimate.parameter.name;
        let exchanged = one_way && ["offset_torque", "coulomb_torque"].contains(&name);
        if one_load.is_some() && name.ends_with("load_factor") || exchanged {
            estimate.verdict = Identifiability::Undetermined;
            estimate.standard_error = f64::INFINITY;
        } else if !unexplained.is_empty() && estimate.verdict == Identifiability::Determined {
            estimate.verdict = Identifiability::Unexplained;
        }
    }
    let pendulum = result.fit.estimate("gravity_torque").is_some();
    let mut remarks = unexplained;
    remarks.append(&mut result.fit.remarks);
    for (number, log) in logs.iter().enumerate() {
        let (range, count) = (extent(&log.position), log.pieces().len() - 1);
        let turns = Remark::ManyTurns { log: number, range };
        remarks.extend((pendulum && range > TURNS).then_some(turns));
        remarks.extend((count > 0).then_some(Remark::Gaps { log: number, count }));
        let begins = !log.in_motion && log.begins_in_motion();
        remarks.extend(begins.then_some(Remark::BeginsInMotion { log: number }));
        remarks.extend(log.mostly_rests().then_some(Remark::MostlyAtRest { log: number }));
        remarks.extend(log.is_saturated().then_some(Remark::Saturated { log: number }));
    }
    let whole = over_whole_logs(result, &remarks);
    remarks.extend(whole);
    remarks.extend(one_load);
    remarks.extend(one_way.then_some(Remark::OffsetOrDirection));
    let turns = |remark: &Remark| matches!(remark, Remark::ManyTurns { .. });
    if remarks.iter().any(turns) {
        // With a wrong unit nothing else that could be said means anything.
        remarks.retain(turns);
    }
    result.fit.remarks = remarks;
}

/// Standard deviation of the motion to which errors are compared.
fn motion(score: &Score) -> f64 {
    score.rmse / score.relative
}

/// The logs that the model does not explain, the worst first; none where only torques were fitted.
fn unexplained(result: &JointFit, logs: &[DriveLog]) -> Vec<Remark> {
    if result.horizon == INVERSE {
        return Vec::new();
    }
    let (_, errors) = result.model.errors(&result.fit.values(), logs, result.horizon);
    let least = LEAST_MOTION * errors.iter().map(motion).fold(0.0, f64::max);
    let shares = errors.iter().map(|score| score.rmse / motion(score).max(least)).enumerate();
    // NaN, where the model has no answer, explains nothing.
    let mut fails: Vec<_> = shares.filter(|(_, error)| !(*error <= UNEXPLAINED)).collect();
    fails.sort_by(|a, b| b.1.total_cmp(&a.1));
    fails.into_iter().map(|(log, error)| Remark::Unexplained { log, error }).collect()
}

/// What simulations of whole logs say, beside what is said of the segments that were fitted.
fn over_whole_logs(result: &JointFit, said: &[Remark]) -> Vec<Remark> {
    let each = |group: &GroupScores| group.each.iter().map(|scores| scores.simulated).collect();
    let fitted: Vec<Score> = each(&result.fitted);
    let held_out: Vec<Score> = result.held_out.as_ref().map(each).unwrap_or_default();
    let most = fitted.iter().map(motion).fold(0.0, f64::max);
    let fails = |it: &Score| !(it.rmse <= UNEXPLAINED * motion(it).max(LEAST_MOTION * most));
    let mut remarks = Vec::new();
    for (log, score) in fitted.iter().enumerate() {
        let is_said = |it: &Remark| matches!(*it, Remark::Unexplained { log: of, .. } if of == log);
        let is_new = fails(score) && !said.iter().any(is_said);
        remarks.extend(is_new.then_some(Remark::OffAsWhole { log, error: score.relative }));
    }
    for (log, score) in held_out.iter().enumerate() {
        let (error, still) = (score.relative, motion(score) < LEAST_MOTION * most);
        remarks.extend(fails(score).then_some(Remark::NotPredicted { log, error }));
        remarks.extend(still.then_some(Remark::HardlyMoves { log }));
    }
    remarks
}

/// What keeps the factors of the load from being told.
fn one_load(result: &JointFit, logs: &[DriveLog]) -> Option<Remark> {
    if !result.friction.loaded {
        return None;
    }
    let (mut motor, mut external) = (0.0_f64, (f64::INFINITY, f64::NEG_INFINITY));
    for (number, log) in logs.iter().enumerate() {
        let plant = Plant::new(&result.model, log, number, &result.fit.values()).ok()?;
        for row in &log.rows {
            let torques = plant.measured(row);
            motor = motor.max(torques.motor.abs());
            external = (external.0.min(torques.external), external.1.max(torques.external));
        }
    }
    (external.1 - external.0 < ONE_LOAD * motor).then_some(Remark::OneLoad)
}
