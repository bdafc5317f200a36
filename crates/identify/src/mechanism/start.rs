//! Starting values: the equation of motion along the smoothed logs, linear in most parameters.
//!
//! τ_m + τ_known = J v̇ + B v + T_c sgn v − Σ θᵢ φᵢ(x, v)
//!
//! over all rows that move at a tenth of the usual speed at least.

use nalgebra::DVector;

use super::joint::{Joint, Term};
use super::log::{DriveLog, Source};
use super::smooth::{Smoothed, SmoothedLog};
use crate::log::range;
use crate::triangle::Triangle;
use bristle::parameter::{Named, ParameterError};

/// Values around which the parameters are searched.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Guess {
    pub(super) inertia: f64,
    pub(super) drag: f64,
    pub(super) coulomb: f64,
    pub(super) torque_constant: Option<f64>,
    pub(super) resistance: Option<f64>,
    /// Whether the exponent of the duty is searched.
    pub(super) duty_exponent: bool,
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

/// A constant of the motor, if the drive needs it.
fn given(joint: &Joint, needed: bool, name: &'static str) -> Result<Option<f64>, ParameterError> {
    match (needed, joint.given(name)) {
        (false, _) => Ok(None),
        (true, Some((value, _))) => Named(name, value).positive().map(Some),
        (true, None) => {
            Err(ParameterError::chosen(name, "this drive takes a known or starting value of"))
        }
    }
}

/// Values that suit the logs.
pub(super) fn guess(joint: &Joint, logs: &[SmoothedLog<'_>]) -> Result<Guess, ParameterError> {
    let any = |of: fn(&Source) -> bool| logs.iter().any(|smoothed| of(&smoothed.log.source));
    let torque_constant = given(joint, any(|source| *source != Source::Torque), "torque_constant")?;
    let resistance = given(joint, any(Source::is_electric), "resistance")?;
    let (k, r) = (torque_constant.unwrap_or(1.0), resistance.unwrap_or(1.0));

    // How large motion and torques are.
    let rows = || logs.iter().flat_map(|one| one.rows.iter().map(move |row| (one.log, row)));
    let count = rows().count().max(1) as f64;
    let speed = (rows().map(|(_, row)| row.velocity * row.velocity).sum::<f64>() / count).sqrt();
    let fastest = rows().fold(0.0, |most, (_, row)| f64::max(most, row.velocity.abs()));
    let torque = rows().fold(0.0, |most, (log, row)| f64::max(most, motor(log, row, k, r).abs()));
    let swing = rows().map(|(_, row)| row.acceleration * row.acceleration).sum::<f64>() / count;
    let largest = |of: fn(&DriveLog) -> f64| logs.iter().map(|one| of(one.log)).fold(0.0, f64::max);
    let span = largest(|log| {
        let (least, most) = range(&log.position);
        most - least
    });
    let known_torque = largest(|log| log.load.gravity_torque.abs());
    let size = torque.max(known_torque).max(joint.given("gravity_torque").map_or(0.0, |g| g.0));
    Named("the largest torque of the drives", size).positive()?;

    let equation = Equation::new(joint);
    let mut triangle = Triangle::new(equation.width());
    for (log, row) in rows().filter(|(_, row)| row.velocity.abs() >= 0.1 * speed) {
        let (mut entries, right) = equation.row(log, row, motor(log, row, k, r));
        triangle.push(&mut entries, right);
    }
    Named("rows that move", triangle.rows).count(equation.width() + 1)?;
    let ([inertia, drag, coulomb], terms) = equation.solve(&triangle);
    // Of a drive with the wrong sign, inertia and friction both come out negative.
    let rule = "be positive: does the drive have the sign of the position, and both SI units?";
    let loads = logs.iter().map(|one| one.log.load.inertia).sum::<f64>() / logs.len().max(1) as f64;
    let total = inertia + loads;
    Named("inertia", total).stated(total > 0.0 || coulomb > 0.0, rule)?;
    Ok(Guess {
        inertia: inertia.max(1e-3 * size / swing.sqrt().max(f64::MIN_POSITIVE)),
        drag: drag.max(0.0),
        coulomb: coulomb.max(0.02 * size),
        torque_constant,
        resistance,
        duty_exponent: joint.given("duty_exponent").is_some()
            && any(|source| matches!(source, Source::Duty { .. })),
        terms,
        torque: size,
        range: span,
        speed,
        fastest,
    })
}

/// The equation of motion with columns for inertia, drag and Coulomb friction, and two for each
/// term.
struct Equation<'a> {
    terms: &'a [Term],
    /// Inertia, drag and Coulomb torque, where they are known.
    known: [Option<f64>; 3],
    gravity: Option<f64>,
}

impl<'a> Equation<'a> {
    fn new(joint: &'a Joint) -> Self {
        let known =
            |name: &str| joint.given(name).filter(|(_, known)| *known).map(|(value, _)| value);
        Self {
            terms: &joint.terms,
            known: ["inertia", "drag", "coulomb_torque"].map(known),
            gravity: known("gravity_torque"),
        }
    }

    fn width(&self) -> usize {
        3 + 2 * self.terms.len()
    }

    /// Left and right side of a row.
    fn row(&self, log: &DriveLog, row: &Smoothed, motor: f64) -> (DVector<f64>, f64) {
        let &Smoothed { position: x, velocity: v, acceleration, external, .. } = row;
        let mut entries = DVector::zeros(self.width());
        let first = [acceleration, v, v.signum()];
        let mut right = motor + external - log.load.inertia * acceleration;
        for (i, (entry, known)) in first.into_iter().zip(self.known).enumerate() {
            match known {
                Some(value) => right -= value * entry,
                None => entries[i] = entry,
            }
        }
        for (i, term) in self.terms.iter().enumerate() {
            let (column, (sin, cos)) = (3 + 2 * i, x.sin_cos());
            let ours = log.load.gravity_torque;
            let pair = match (term, self.gravity) {
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
        (entries, right)
    }

    /// Inertia, drag and Coulomb torque, and the parameters of the terms.
    fn solve(&self, triangle: &Triangle) -> ([f64; 3], Vec<f64>) {
        let mut free = vec![true; self.width()];
        for (free, known) in free.iter_mut().zip(&self.known) {
            *free = known.is_none();
        }
        let found = triangle.damped(&(triangle.column_norms() * 1e-6), &free);
        let at = |i: usize| found.get(i).copied().unwrap_or(0.0);
        let first = core::array::from_fn(|i| self.known[i].unwrap_or_else(|| at(i)));
        let terms = self.terms.iter().enumerate().flat_map(|(i, term)| {
            let pair = [at(3 + 2 * i), at(4 + 2 * i)];
            let found = match (term, self.gravity) {
                (Term::Gravity, Some(gravity)) => [gravity, pair[1]],
                (Term::Gravity, None) => [pair[0].hypot(pair[1]), pair[1].atan2(pair[0])],
                _ => pair,
            };
            found.into_iter().take(term.names().len())
        });
        (first, terms.collect())
    }
}
