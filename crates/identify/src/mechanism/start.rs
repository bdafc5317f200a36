//! Starting values: the equation of motion along the smoothed logs, linear in most parameters.
//!
//! τ_m + τ_known = J v̇ + B v + T_c sgn v − Σ θᵢ φᵢ(x, v)
//!
//! over all rows that move at a tenth of the usual speed at least.

use alloc::vec::Vec;

use nalgebra::DVector;

use super::joint::{Joint, MotorConstants, Term};
use super::log::{DriveLog, Source};
use super::smooth::Smoothed;
use crate::log::range;
use crate::triangle::Triangle;
use bristle::parameter::{self, ParameterError};

/// Values around which the parameters are searched.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Guess {
    pub(super) inertia: f64,
    pub(super) drag: f64,
    pub(super) coulomb: f64,
    pub(super) constants: MotorConstants,
    pub(super) torque_constant: Option<f64>,
    pub(super) resistance: Option<f64>,
    /// Those of the terms, in their order.
    pub(super) terms: Vec<f64>,
    /// Largest torque of the motor.
    pub(super) torque: f64,
    /// Range of positions.
    pub(super) range: f64,
    /// Root mean square and largest size of the velocity.
    pub(super) speed: f64,
    pub(super) fastest: f64,
}

/// The motor torque of a smoothed row.
fn motor(log: &DriveLog, row: &Smoothed, constant: f64, resistance: f64) -> f64 {
    match log.source {
        Source::Torque => row.effort,
        Source::Current => constant * row.effort,
        Source::Voltage | Source::Duty { .. } => {
            constant * (row.effort - row.enabled * constant * row.velocity) / resistance
        }
    }
}

/// Values that suit the logs.
pub(super) fn guess(
    joint: &Joint,
    logs: &[DriveLog],
    smoothed: &[Vec<Smoothed>],
) -> Result<Guess, ParameterError> {
    let constants = MotorConstants::of(joint, logs);
    let given = |needed: bool, name| match (needed, joint.given(name)) {
        (false, _) => Ok(None),
        (true, Some((value, _))) => parameter::positive(name, value).map(Some),
        (true, None) => {
            Err(parameter::chosen(name, "this drive takes a known or starting value of"))
        }
    };
    let torque_constant = given(constants.torque_constant, "torque_constant")?;
    let resistance = given(constants.resistance, "resistance")?;
    let (k, r) = (torque_constant.unwrap_or(1.0), resistance.unwrap_or(1.0));

    let rows = || {
        let all = logs.iter().zip(smoothed);
        all.flat_map(|(log, rows)| rows.iter().map(move |row| (log, row)))
    };
    let count = rows().count().max(1) as f64;
    let speed = (rows().map(|(_, row)| row.velocity * row.velocity).sum::<f64>() / count).sqrt();
    let fastest = rows().fold(0.0, |most, (_, row)| f64::max(most, row.velocity.abs()));
    let torque = rows().fold(0.0, |most, (log, row)| f64::max(most, motor(log, row, k, r).abs()));
    let swing = rows().map(|(_, row)| row.acceleration * row.acceleration).sum::<f64>() / count;
    let spans = logs.iter().map(|log| range(&log.position));
    let span = spans.map(|(least, most)| most - least).fold(0.0, f64::max);
    let known_torque = logs.iter().map(|log| log.load.gravity_torque.abs()).fold(0.0, f64::max);
    let size = torque.max(known_torque).max(joint.given("gravity_torque").map_or(0.0, |g| g.0));
    parameter::positive("the largest torque of the drives", size)?;

    // Inertia, drag, Coulomb friction, and two columns for each term.
    let width = 3 + 2 * joint.terms.len();
    let mut triangle = Triangle::new(width);
    let mut free = alloc::vec![true; width];
    let known = |name: &str| joint.given(name).filter(|(_, known)| *known).map(|(value, _)| value);
    let fixed = [known("inertia"), known("drag"), known("coulomb_torque")];
    for (free, known) in free.iter_mut().zip(&fixed) {
        *free = known.is_none();
    }
    let gravity = known("gravity_torque");
    for (log, row) in rows().filter(|(_, row)| row.velocity.abs() >= 0.1 * speed) {
        let &Smoothed { position: x, velocity: v, acceleration, external, .. } = row;
        let mut entries = DVector::zeros(width);
        let first = [acceleration, v, v.signum()];
        let mut right = motor(log, row, k, r) + external - log.load.inertia * acceleration;
        for (i, (entry, known)) in first.into_iter().zip(fixed).enumerate() {
            match known {
                Some(value) => right -= value * entry,
                None => entries[i] = entry,
            }
        }
        for (i, term) in joint.terms.iter().enumerate() {
            let (column, (sin, cos)) = (3 + 2 * i, x.sin_cos());
            let ours = log.load.gravity_torque;
            let pair = match (term, gravity) {
                (Term::Constant, _) => [-1.0, 0.0],
                (Term::Spring, _) => [x, 0.0],
                // −(G + G_log) sin(x − x0) with both known: about small x0.
                (Term::Gravity, Some(gravity)) => {
                    right -= (gravity + ours) * sin;
                    [0.0, -(gravity + ours) * cos]
                }
                (Term::Gravity, None) => {
                    right -= ours * sin;
                    [sin, -cos]
                }
                (Term::Own(_), _) => [-term.torque(&[1.0], 0.0, x, v)[0], 0.0],
            };
            (entries[column], entries[column + 1]) = (pair[0], pair[1]);
        }
        triangle.push(&mut entries, right);
    }
    parameter::count("rows that move", triangle.rows, width + 1)?;
    let scale = triangle.column_norms() * 1e-6;
    let found = triangle.damped(&scale, &free);
    let at = |i: usize| found.get(i).copied().unwrap_or(0.0);
    let loads = logs.iter().map(|log| log.load.inertia).sum::<f64>() / logs.len().max(1) as f64;
    let [inertia, drag, coulomb] =
        core::array::from_fn(|i| fixed.get(i).copied().flatten().unwrap_or_else(|| at(i)));
    // Of a drive with the wrong sign, inertia and friction both come out negative.
    let rule = "be positive: does the drive have the sign of the position, and both SI units?";
    let total = inertia + loads;
    parameter::stated("inertia", total, total > 0.0 || coulomb > 0.0, rule)?;
    let terms = joint.terms.iter().enumerate().flat_map(|(i, term)| {
        let pair = [at(3 + 2 * i), at(4 + 2 * i)];
        let found = match (term, gravity) {
            (Term::Gravity, Some(gravity)) => [gravity, pair[1]],
            (Term::Gravity, None) => [pair[0].hypot(pair[1]), pair[1].atan2(pair[0])],
            _ => pair,
        };
        found.into_iter().take(term.count())
    });
    let terms = terms.collect();
    Ok(Guess {
        inertia: inertia.max(1e-3 * size / swing.sqrt().max(f64::MIN_POSITIVE)),
        drag: drag.max(0.0),
        coulomb: coulomb.max(0.02 * size),
        constants,
        torque_constant,
        resistance,
        terms,
        torque: size,
        range: span,
        speed,
        fastest,
    })
}
