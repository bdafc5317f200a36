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
    /// Time from row to row \[s\], if a delay is searched.
    pub(super) delay: Option<f64>,
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
        Source::Torque => row.effort[0],
        Source::Current => constant * row.effort[0],
        Source::Voltage | Source::Duty { .. } => {
            constant * (row.effort[0] - row.enabled * constant * row.velocity) / resistance
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
    let moving: Vec<_> = (rows().filter(|(_, row)| row.velocity.abs() >= 0.1 * speed))
        .map(|(log, row)| equation.row(log, row, motor(log, row, k, r)))
        .collect();
    Named("rows that move", moving.len()).count(equation.width() + 1)?;
    let ([inertia, drag, coulomb], terms) = equation.best(&moving);
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
        delay: joint.given("delay").map(|_| largest(DriveLog::usual_step)),
        terms,
        torque: size,
        range: span,
        speed,
        fastest,
    })
}

/// A row of the equation without gravity.
struct Row {
    entries: DVector<f64>,
    right: f64,
    position: f64,
    /// Gravity that is known [N m].
    gravity: f64,
}

/// The equation of motion with columns for inertia, drag and Coulomb friction, and one for each
/// term, at a hanging angle.
struct Equation<'a> {
    terms: &'a [Term],
    /// Inertia, drag and Coulomb torque, where they are known.
    known: [Option<f64>; 3],
    gravity: Option<f64>,
    hanging: Option<f64>,
}

/// Hanging angles that are tried, around the circle: every 10°.
const ANGLES: usize = 36;
/// Halvings of 10° about the best of them, down to a ten-thousandth of a radian.
const HALVINGS: usize = 11;

impl<'a> Equation<'a> {
    fn new(joint: &'a Joint) -> Self {
        let known =
            |name: &str| joint.given(name).filter(|(_, known)| *known).map(|(value, _)| value);
        Self {
            terms: &joint.terms,
            known: ["inertia", "drag", "coulomb_torque"].map(known),
            gravity: known("gravity_torque"),
            hanging: known("hanging_angle"),
        }
    }

    fn width(&self) -> usize {
        3 + self.terms.len()
    }

    /// The least squares over all hanging angles: gravity of a load that is known may exceed that
    /// of the link by far, so that no equation that is linear in both tells the angle.
    fn best(&self, rows: &[Row]) -> ([f64; 3], Vec<f64>) {
        let has_gravity = self.terms.iter().any(|term| matches!(term, Term::Gravity));
        let mut angle = self.hanging.unwrap_or(0.0);
        if has_gravity && self.hanging.is_none() {
            let mut step = core::f64::consts::TAU / ANGLES as f64;
            let squares = |angle: f64| self.solve(rows, angle).0;
            let mut least = (f64::INFINITY, angle);
            let mut attempt = |angle: f64| {
                let reached = squares(angle);
                if reached < least.0 {
                    least = (reached, angle);
                }
                least.1
            };
            for i in 0..ANGLES {
                angle = attempt((i as f64 - 0.5 * (ANGLES - 2) as f64) * step);
            }
            for _ in 0..HALVINGS {
                step *= 0.5;
                let middle = angle;
                attempt(middle - step);
                angle = attempt(middle + step);
            }
        }
        let (_, found) = self.solve(rows, angle);
        let first = core::array::from_fn(|i| self.known[i].unwrap_or(found[i]));
        let terms = self.terms.iter().zip(found.iter().skip(3)).flat_map(|(term, &value)| {
            let gravity = [self.gravity.unwrap_or(value), angle];
            let found = if let Term::Gravity = term { gravity } else { [value, 0.0] };
            found.into_iter().take(term.names().len())
        });
        (first, terms.collect())
    }

    /// What remains of all rows at a hanging angle [(N m)²], and the values of the columns. The
    /// link's own gravity pulls down.
    fn solve(&self, rows: &[Row], hanging: f64) -> (f64, DVector<f64>) {
        let (mut triangle, mut squares) = (Triangle::new(self.width()), 0.0);
        let gravity = self.terms.iter().position(|term| matches!(term, Term::Gravity));
        for row in rows {
            let (mut entries, mut right) = (row.entries.clone(), row.right);
            if let Some(place) = gravity {
                let sin = (row.position - hanging).sin();
                right -= row.gravity * sin;
                entries[3 + place] = if self.gravity.is_some() { 0.0 } else { sin };
            }
            triangle.push(&mut entries, right);
            squares += right * right;
        }
        let mut free = vec![true; self.width()];
        for (free, known) in free.iter_mut().zip(&self.known) {
            *free = known.is_none();
        }
        let diagonal = triangle.column_norms() * 1e-6;
        let mut found = triangle.damped(&diagonal, &free);
        if let Some(place) = gravity.filter(|place| found[3 + place] < 0.0) {
            free[3 + place] = false;
            found = triangle.damped(&diagonal, &free);
        }
        let explained = 2.0 * found.dot(&triangle.gradient()) - triangle.image_squared(&found);
        (squares - explained, found)
    }

    fn row(&self, log: &DriveLog, row: &Smoothed, motor: f64) -> Row {
        let &Smoothed { position, velocity, acceleration, external, .. } = row;
        let mut entries = DVector::zeros(self.width());
        let mut right = motor + external - log.load.inertia * acceleration;
        let first = [acceleration, velocity, velocity.signum()];
        for (i, (entry, known)) in first.into_iter().zip(self.known).enumerate() {
            match known {
                Some(value) => right -= value * entry,
                None => entries[i] = entry,
            }
        }
        for (i, term) in (3..).zip(self.terms) {
            if !matches!(term, Term::Gravity) {
                entries[i] = -term.torque(&[1.0], 0.0, position, velocity)[0];
            }
        }
        let gravity = self.gravity.unwrap_or(0.0) + log.load.gravity_torque;
        Row { entries, right, position, gravity }
    }
}
