//! Starting values: the equation of motion along the smoothed logs, linear in most parameters.
//!
//! τ_m + τ_known = J v̇ + B v + T_c sgn v − Σ θᵢ φᵢ(x, v)
//!
//! over rows that move at a tenth of the usual speed at least.

use core::f64::consts::{PI, TAU};
use core::ops::ControlFlow;

use super::friction::Friction;
use super::joint::{Joint, Model, Term};
use super::log::{DriveLog, Source};
use super::plant::Plant;
use super::smooth::Smoothed;
use crate::least_squares::{Found, minimise};
use crate::log::extent;
use crate::problem::Objective;
use crate::{Parameter, SearchProgress, SearchSettings};
use bristle::Scalar;
use bristle::parameter::{Checked, Named};
use bristle::scalar::lit;

/// Hanging angles from which is searched, around the circle.
const ANGLES: usize = 6;
/// Most runs with derivatives from each.
const RUNS: usize = 6;
/// Share of the usual inertia and friction that is nothing.
const NOTHING: f64 = 0.01;
/// Most rows: neighbours tell the same.
const MOST_ROWS: usize = 2000;

/// Values around which the parameters are searched.
pub(super) struct Guess {
    pub(super) inertia: f64,
    pub(super) drag: f64,
    pub(super) coulomb: f64,
    /// The parameters of the drives, those that they have.
    pub(super) drive: Vec<Parameter>,
    /// Largest gravity that logs know.
    pub(super) known_gravity: f64,
    /// Those of the terms in their order, and how large they usually are.
    pub(super) terms: Vec<(f64, f64)>,
    /// Largest torque of the motor.
    pub(super) torque: f64,
    /// Range of positions.
    pub(super) range: f64,
    /// Root mean square and largest size of the velocity.
    pub(super) speed: f64,
    pub(super) fastest: f64,
}

/// A constant of the motor.
fn given(joint: &Joint, name: &'static str, unit: &'static str) -> Checked<Parameter> {
    let rule = "be known or started: this drive needs it";
    let value = joint.given(name).unwrap_or(f64::NAN);
    Named(name, value).stated(!value.is_nan(), rule)?;
    Ok(Parameter::positive(name, unit, Named(name, value).positive()?, 30.0))
}

/// Values that suit the logs.
pub(super) fn guess(joint: &Joint, logs: &[DriveLog]) -> Checked<Guess> {
    let any = |of: fn(&Source) -> bool| logs.iter().any(|log| of(&log.source));
    let largest = |of: fn(&DriveLog) -> f64| logs.iter().map(of).fold(0.0, f64::max);
    let (is_other, is_electric) = (any(|it| *it != Source::Torque), any(Source::is_electric));
    let constant = is_other.then(|| given(joint, "torque_constant", "N/A")).transpose()?;
    let resistance = is_electric.then(|| given(joint, "resistance", "Ω")).transpose()?;
    let [k, r] = [constant, resistance].map(|it| it.map_or(1.0, |it| it.start));
    let mut drive: Vec<Parameter> = [constant, resistance].into_iter().flatten().collect();
    let is_duty = any(|source| matches!(source, Source::Duty { .. }));
    if is_duty && joint.given("duty_exponent").is_some() {
        drive.push(Parameter::scaled("duty_exponent", "", 1.0, 0.2..=3.0, 0.3));
    }
    if let Some(inductance) = joint.given("inductance").filter(|_| is_electric) {
        Named("inductance", inductance).non_negative()?;
        let row = r * largest(DriveLog::usual_step);
        drive.push(Parameter::scaled("inductance", "H", 0.0, 0.0..=20.0 * row, row));
    }
    if joint.given("delay").is_some() {
        let row = largest(DriveLog::usual_step);
        drive.push(Parameter::scaled("delay", "s", 0.0, 0.0..=20.0 * row, row));
    }

    // How large motion and torques are.
    let rows = || logs.iter().flat_map(|one| &one.rows);
    let count = rows().count().max(1) as f64;
    let speed = (rows().map(|row| row.velocity * row.velocity).sum::<f64>() / count).sqrt();
    let fastest = rows().fold(0.0, |most, row| f64::max(most, row.velocity.abs()));
    let torque = rows().fold(0.0, |most, row| f64::max(most, (row.effort[0] * k / r).abs()));
    let swing = rows().map(|row| row.acceleration * row.acceleration).sum::<f64>() / count;
    let span = largest(|log| extent(&log.position));
    let known_gravity = largest(|log| log.load.gravity_torque.abs());
    let size = torque.max(known_gravity).max(joint.given("gravity_torque").unwrap_or(0.0));
    Named("the largest torque of the drives", size).positive()?;

    let largest_of = |term: &Term| {
        let torque = |row: &Smoothed| term.torque(&[1.0], 0.0, row.position, row.velocity)[0].abs();
        rows().map(torque).fold(0.0, f64::max)
    };
    let part = 0.1 * size;
    let terms = joint.terms.iter().flat_map(|term| match term {
        Term::Gravity if known_gravity > 0.0 => vec![(0.0, part), (PI, 0.1)],
        Term::Gravity => vec![(3.0 * part, part), (PI, 0.1)],
        Term::Own(_) => vec![(0.0, part / largest_of(term).max(f64::MIN_POSITIVE))],
    });
    let sizes = Guess {
        inertia: size / swing.sqrt().max(f64::MIN_POSITIVE),
        drag: 0.0,
        coulomb: part,
        drive,
        known_gravity,
        terms: terms.collect(),
        torque: size,
        range: span,
        speed,
        fastest,
    };
    refine(joint, logs, sizes)
}

/// The least squares of the equation of motion, from sizes.
fn refine(joint: &Joint, logs: &[DriveLog], mut guess: Guess) -> Checked<Guess> {
    let model = joint.model(&Friction::coulomb(), &guess, logs)?;
    let slowest = 0.1 * guess.speed;
    let rows = || logs.iter().flat_map(|one| &one.rows);
    let moving = rows().filter(|row| row.velocity.abs() >= slowest).count();
    let mut parameters = model.parameters.clone();
    Named("rows that move", moving).count(parameters.len() + 1)?;
    let every = rows().count().div_ceil(MOST_ROWS);
    let moving = Moving { model: &model, logs, slowest, every };
    let own = ["inertia", "drag", "coulomb_torque"];
    let names = || joint.terms.iter().flat_map(Term::names).copied();
    for parameter in &mut parameters {
        if !names().chain(own).any(|name| name == parameter.name) {
            (parameter.least, parameter.most) = (parameter.start, parameter.start);
        }
    }
    let is_angle = |name| name == "hanging_angle" && joint.given(name).is_none();
    let angles = if names().any(is_angle) { ANGLES } else { 1 };
    let settings = SearchSettings { iterations: RUNS, tolerance: 1e-3, starts: 1 };
    let mut best: Option<Found> = None;
    for number in 0..angles {
        for parameter in parameters.iter_mut().filter(|parameter| is_angle(parameter.name)) {
            parameter.start = TAU * (number as f64 / ANGLES as f64 - 0.5);
        }
        let mut go_on = |_: &SearchProgress<'_>| ControlFlow::Continue(());
        let found = minimise(&moving, &parameters, &settings, 0, &mut go_on)?;
        if best.as_ref().is_none_or(|best| found.cost < best.cost) {
            best = Some(found);
        }
    }
    let Some(found) = best else { return Ok(guess) };
    let value = |name: &str| model.value(&found.values, usize::MAX, name).unwrap_or(0.0);
    // Of a drive with the wrong sign, neither inertia nor friction is left.
    let left = (value("inertia") / guess.inertia).max(value("coulomb_torque") / guess.coulomb);
    let rule =
        "be clearly positive: does the drive have the sign of the position, and both SI units?";
    Named("inertia", value("inertia")).stated(left > NOTHING, rule)?;
    guess.terms.iter_mut().zip(names()).for_each(|(found, name)| found.0 = value(name));
    let coulomb = value("coulomb_torque").max(0.02 * guess.torque);
    Ok(Guess { inertia: value("inertia"), drag: value("drag"), coulomb, ..guess })
}

/// The equation of motion along rows that move.
struct Moving<'a> {
    model: &'a Model,
    logs: &'a [DriveLog],
    /// Least speed [rad/s].
    slowest: f64,
    /// Every so many rows count.
    every: usize,
}

impl Objective for Moving<'_> {
    fn evaluate<T: Scalar>(&self, values: &[T], each: &mut impl FnMut(T)) -> Checked<()> {
        for (number, log) in self.logs.iter().enumerate() {
            let plant = Plant::new(self.model, log, number, values)?;
            let coulomb = self.model.value(values, number, "coulomb_torque");
            let coulomb = coulomb.unwrap_or_else(T::nan);
            for row in log.rows.iter().step_by(self.every) {
                if row.velocity.abs() >= self.slowest {
                    each(plant.remaining(row) - coulomb * lit(row.velocity.signum()));
                }
            }
        }
        Ok(())
    }
}
