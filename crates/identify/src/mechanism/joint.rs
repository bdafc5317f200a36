//! The mechanism around the friction: which torques there are, and which of their parameters are
//! known, searched, or of each log.

use core::fmt;
use std::sync::Arc;

use super::friction::Friction;
use super::log::DriveLog;
use super::start::Guess;
use crate::Parameter;
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::scalar::{lit, to_f64};
use bristle::{Scalar, Units};
use bristle_joint::JointInputValue;

/// A torque on the load side of the gear: it loads the gear as an external torque does.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Term {
    /// −G sin(x − x0), parameters `gravity_torque` G [N m] and `hanging_angle` x0 \[rad\]. To G is
    /// added what a log [knows](super::KnownLoad).
    Gravity,
    /// θ φ(x, v) with its factor θ as parameter, see [`Term::own`].
    Own(OwnTerm),
}

/// A function of position and velocity, from [`Term::own`].
#[derive(Clone)]
pub struct OwnTerm {
    name: &'static str,
    unit: &'static str,
    torque: Arc<dyn Fn(f64, f64) -> [f64; 3] + Send + Sync>,
}

impl fmt::Debug for OwnTerm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OwnTerm").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Term {
    /// θ φ(x, v) with the factor θ as parameter, of a name and a unit. The function returns φ,
    /// ∂φ/∂x and ∂φ/∂v.
    ///
    /// ```
    /// use bristle_identify::mechanism::Term;
    ///
    /// // A fan, −θ |v| v.
    /// let fan = Term::own("fan", "N m s²/rad²", |_, v| [-v.abs() * v, 0.0, -2.0 * v.abs()]);
    /// ```
    pub fn own(
        name: &'static str,
        unit: &'static str,
        torque: impl Fn(f64, f64) -> [f64; 3] + Send + Sync + 'static,
    ) -> Self {
        Self::Own(OwnTerm { name, unit, torque: Arc::new(torque) })
    }

    /// A constant torque, parameter `offset_torque` [N m].
    pub fn constant() -> Self {
        Self::own("offset_torque", "N", |_, _| [1.0, 0.0, 0.0])
    }

    /// −k x, parameter `spring_rate` [N m/rad].
    pub fn spring() -> Self {
        Self::own("spring_rate", "N/m", |x, _| [-x, -1.0, 0.0])
    }

    /// −B₋ v where v < 0, parameter `backward_drag` B₋ [N m s/rad]: by how much the drag backwards
    /// exceeds that forwards.
    pub fn backward_drag() -> Self {
        Self::own("backward_drag", "N s/m", |_, v| if v < 0.0 { [-v, 0.0, -1.0] } else { [0.0; 3] })
    }

    /// a cos(n x) + b sin(n x) and its second harmonic, with a known number n of waves per radian:
    /// cogging, a cable. Parameters `ripple_cos_1` a, `ripple_sin_1` b, `ripple_cos_2` and
    /// `ripple_sin_2` [N m].
    ///
    /// ```
    /// use bristle_identify::mechanism::{Joint, Term};
    ///
    /// let joint = Term::ripple(7.0).into_iter().fold(Joint::new(), Joint::with);
    /// # let _ = joint;
    /// ```
    pub fn ripple(number: f64) -> [Self; 4] {
        let wave = |name, n: f64, lead: f64| {
            Self::own(name, "N", move |x, _| {
                let (sin, cos) = (n * x + lead).sin_cos();
                [cos, -n * sin, 0.0]
            })
        };
        let quarter = -core::f64::consts::FRAC_PI_2;
        [
            wave("ripple_cos_1", number, 0.0),
            wave("ripple_sin_1", number, quarter),
            wave("ripple_cos_2", 2.0 * number, 0.0),
            wave("ripple_sin_2", 2.0 * number, quarter),
        ]
    }

    /// The names of its parameters.
    pub(super) fn names(&self) -> &[&'static str] {
        match self {
            Self::Gravity => &["gravity_torque", "hanging_angle"],
            Self::Own(own) => core::slice::from_ref(&own.name),
        }
    }

    /// The torque of the parameters at a position and a velocity, and its derivatives with respect
    /// to them. To the torque of gravity is added a known one.
    #[inline]
    pub(super) fn torque<T: Scalar>(&self, parameters: &[T], known: f64, x: T, v: T) -> [T; 3] {
        match (self, parameters) {
            (Self::Gravity, &[torque, hanging]) => {
                let torque = torque + lit(known);
                let (sin, cos) = (x - hanging).sin_cos();
                [-torque * sin, -torque * cos, T::zero()]
            }
            (Self::Own(own), &[factor]) => {
                let (at_x, at_v) = (to_f64(x), to_f64(v));
                let [value, by_x, by_v] = (own.torque)(at_x, at_v).map(lit::<T>);
                // The value with the derivatives that x and v carry.
                let value = value + by_x * (x - lit(at_x)) + by_v * (v - lit(at_v));
                [value * factor, by_x * factor, by_v * factor]
            }
            _ => [T::nan(); 3],
        }
    }

    /// That of several terms with the parameters of all.
    #[inline]
    pub(super) fn sum<T: Scalar>(terms: &[Self], all: &[T], known: f64, x: T, v: T) -> [T; 3] {
        let (mut sum, mut rest) = ([T::zero(); 3], all);
        for term in terms {
            let ours = rest.split_off(..term.names().len()).unwrap_or_default();
            let torque = term.torque(ours, known, x, v);
            sum.iter_mut().zip(torque).for_each(|(sum, part)| *sum += part);
        }
        sum
    }

    /// Its parameters with units of translation, from values and typical sizes.
    fn parameters(&self, guess: &Guess, found: &[(f64, f64)]) -> Vec<Parameter> {
        let signed = |name, unit, (start, typical): (f64, f64)| {
            let most = start.abs() + 30.0 * typical;
            Parameter::scaled(name, unit, start, -most..=most, typical)
        };
        match (self, found) {
            (Self::Gravity, &[(gravity, typical), hanging]) => {
                let name = "gravity_torque";
                let gravity = if guess.known_gravity == 0.0 {
                    Parameter::positive(name, "N", gravity.max(0.1 * typical), 100.0)
                } else {
                    // A known load may be overstated.
                    let most = gravity.abs() + 100.0 * typical;
                    let bounds = -OVERSTATED * guess.known_gravity..=most;
                    Parameter::scaled(name, "N", gravity, bounds, typical)
                };
                vec![gravity, signed("hanging_angle", "m", hanging)]
            }
            (Self::Own(own), &[found]) => vec![signed(own.name, own.unit, found)],
            _ => Vec::new(),
        }
    }
}

/// Share of a known gravity by which it may be overstated.
const OVERSTATED: f64 = 0.5;

/// What the state of each log has where its simulation begins, beside the smoothed velocity and the
/// deflection along the measured motion, over that of steady sliding: [`DriveLog::in_motion`].
pub(super) const INITIAL: [&str; 2] = ["initial_velocity", "initial_deflection"];

/// The names that a joint takes.
const TAKES: &str = "a joint takes inertia, drag, delay; gravity_torque and hanging_angle with \
    Term::Gravity; offset_torque, spring_rate, backward_drag, ripple_cos_1 and so on with the \
    terms of these names; torque_constant, resistance, inductance, duty_exponent with a drive that \
    has them; coulomb_torque, motor_load_factor, external_load_factor, breakaway_excess, \
    stribeck_velocity, stribeck_exponent, backward_ratio, micro_stiffness and micro_damping; names \
    of its own terms";

/// A torque and its derivatives with respect to position and velocity, as the input of a joint.
pub(super) fn input<T: Scalar>([value, by_angle, by_velocity]: [T; 3]) -> JointInputValue<T> {
    JointInputValue { by_angle, by_velocity, ..JointInputValue::constant(value) }
}

/// What is said of a parameter beforehand.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Said {
    Start(f64),
    /// Start and bounds; the same number three times if it is known.
    Between([f64; 3]),
    OfEachLog,
}

impl Said {
    /// Gives a parameter its start and bounds.
    fn apply(self, parameter: &mut Parameter) -> Checked<()> {
        let name = parameter.name;
        match self {
            Self::Start(value) => {
                Named(name, value).finite()?;
                parameter.start = value;
                if parameter.typical.is_none() {
                    Named(name, value).positive()?;
                    *parameter = Parameter::positive(name, parameter.unit, value, 30.0);
                }
                parameter.least = parameter.least.min(value);
                parameter.most = parameter.most.max(value);
            }
            Self::Between(values @ [start, least, most]) => {
                values.into_iter().try_for_each(|v| Named(name, v).finite().map(drop))?;
                (parameter.start, parameter.least, parameter.most) = (start, least, most);
                if least == most {
                    parameter.typical = Some(if start == 0.0 { 1.0 } else { start.abs() });
                }
            }
            Self::OfEachLog => {}
        }
        Ok(())
    }
}

/// The mechanism around the friction,
///
/// (J + J_log) v̇ = τ_m + τ_e + Σ terms − B v − T,
///
/// with what is known of its parameters. Moment of inertia J and drag B are always there.
///
/// ```
/// use bristle_identify::mechanism::{Joint, Term};
///
/// // A servo with a pendulum of known weight.
/// let joint = Joint::new()
///     .with(Term::Gravity)
///     .known("gravity_torque", 0.48) // N m
///     .start("torque_constant", 0.3) // N m/A, as in its datasheet
///     .start("resistance", 2.5) // Ω
///     .of_each_log("hanging_angle");
/// # let _ = joint;
/// ```
#[derive(Debug, Clone, Default)]
pub struct Joint {
    pub(super) terms: Vec<Term>,
    units: Option<Units>,
    said: Vec<(&'static str, Said)>,
}

impl Joint {
    /// Inertia and drag.
    pub fn new() -> Self {
        Self::default()
    }

    /// With another torque.
    #[must_use]
    pub fn with(mut self, term: Term) -> Self {
        self.terms.push(term);
        self
    }

    /// The units in which results are printed: those of rotation, unless others are said.
    #[must_use]
    pub fn in_units(self, units: Units) -> Self {
        Self { units: Some(units), ..self }
    }

    /// The unit that takes the place of one of translation.
    pub(super) fn unit(&self, translation: &'static str) -> &'static str {
        self.units.unwrap_or(Units::Rotation).of(translation)
    }

    fn say(mut self, name: &'static str, said: Said) -> Self {
        self.said.push((name, said));
        self
    }

    /// With a parameter that is known: it is not searched.
    #[must_use]
    pub fn known(self, name: &'static str, value: f64) -> Self {
        self.between(name, value, value, value)
    }

    /// With a parameter whose search starts from a value. `torque_constant` and `resistance` need
    /// one, or must be known; `duty_exponent` is 1, `inductance` and `delay` are 0 unless one is
    /// given.
    #[must_use]
    pub fn start(self, name: &'static str, value: f64) -> Self {
        self.say(name, Said::Start(value))
    }

    /// With a parameter that is searched within bounds of your own.
    #[must_use]
    pub fn between(self, name: &'static str, start: f64, least: f64, most: f64) -> Self {
        self.say(name, Said::Between([start, least, most]))
    }

    /// With a parameter that each log has for itself.
    #[must_use]
    pub fn of_each_log(self, name: &'static str) -> Self {
        self.say(name, Said::OfEachLog)
    }

    /// A value given for a parameter.
    pub(super) fn given(&self, name: &str) -> Option<f64> {
        let mut said = self.said.iter().rev().filter(|(of, _)| *of == name);
        said.find_map(|(_, said)| match *said {
            Said::Start(value) | Said::Between([value, ..]) => Some(value),
            Said::OfEachLog => None,
        })
    }

    /// The joint with a friction and the parameters of both in their order, for some logs. Steps
    /// reach from row to row.
    pub(super) fn model(
        &self,
        friction: &Friction,
        guess: &Guess,
        logs: &[DriveLog],
    ) -> Checked<Model> {
        let mut base = vec![Parameter::positive("inertia", "kg", guess.inertia, 1000.0)];
        base.extend(&guess.drive);
        let viscous = guess.torque / guess.speed;
        let bounds = 0.0..=10.0 * viscous;
        base.push(Parameter::scaled("drag", "N s/m", guess.drag, bounds, 0.1 * viscous));
        let mut found = guess.terms.as_slice();
        for term in &self.terms {
            let ours = found.split_off(..term.names().len()).unwrap_or_default();
            base.extend(term.parameters(guess, ours));
        }
        base.extend(friction.parameters(guess));
        let of_friction = Friction::lugre().loaded().directional().parameters(guess);
        for &(name, said) in &self.said {
            match base.iter_mut().find(|parameter| parameter.name == name) {
                Some(parameter) => said.apply(parameter)?,
                // Of the friction's parameters each candidate has its own.
                None if of_friction.iter().any(|parameter| parameter.name == name) => {}
                None => return Err(ParameterError::chosen(name, TAKES)),
            }
        }
        let searched = |name| base.iter().any(|p| p.name == name && p.least < p.most);
        if friction.directional && !friction.loaded && searched("offset_torque") {
            let rule = "a direction-dependent friction under a constant load takes its own offset";
            return Err(ParameterError::chosen("offset_torque", rule));
        }
        let (velocity, deflects) = (0.01 * guess.speed, searched("micro_stiffness"));
        let initial = [("m/s", velocity, true), ("", 0.1, deflects)];
        for (name, (unit, size, _)) in INITIAL.into_iter().zip(initial).filter(|(_, it)| it.2) {
            base.push(Parameter::scaled(name, unit, 0.0, -100.0 * size..=100.0 * size, size));
        }
        base.iter_mut().for_each(|parameter| parameter.unit = self.unit(parameter.unit));
        let all = base.into_iter().flat_map(|parameter| {
            let initial = INITIAL.contains(&parameter.name);
            let each = initial || self.said.contains(&(parameter.name, Said::OfEachLog));
            let logs = logs.get(..if each { logs.len() } else { 1 }).unwrap_or_default();
            let ours = logs.iter().enumerate().filter(move |(_, log)| log.in_motion || !initial);
            ours.map(move |(log, _)| (parameter, each.then_some(log)))
        });
        let ((parameters, of_logs), joint) = (all.unzip(), self.clone());
        let (friction, fastest, step) = (*friction, guess.fastest, f64::INFINITY);
        Ok(Model { joint, friction, parameters, of_logs, fastest, step })
    }
}

/// A joint with a candidate for its friction, their parameters as they are searched, those of each
/// log several times, and how they are simulated.
#[derive(Debug, Clone)]
pub(super) struct Model {
    pub(super) joint: Joint,
    pub(super) friction: Friction,
    pub(super) parameters: Vec<Parameter>,
    /// Of each parameter the log whose own it is.
    pub(super) of_logs: Vec<Option<usize>>,
    /// Largest speed of the logs [rad/s].
    pub(super) fastest: f64,
    /// Longest step [s].
    pub(super) step: f64,
}

impl Model {
    /// Values of which those of some logs alone are the mean of the others. A log keeps the state
    /// in which it begins.
    pub(super) fn without(&self, values: Vec<f64>, out: impl Fn(usize) -> bool) -> Vec<f64> {
        let is_initial = |i: usize| INITIAL.contains(&self.parameters[i].name);
        let is_out = |i: usize| !is_initial(i) && self.of_logs[i].is_some_and(&out);
        let mean = |i: usize| {
            let same = |j: &usize| self.parameters[*j].name == self.parameters[i].name;
            let others: Vec<f64> =
                (0..values.len()).filter(|j| same(j) && !is_out(*j)).map(|j| values[j]).collect();
            others.iter().sum::<f64>() / others.len() as f64
        };
        (0..values.len()).map(|i| if is_out(i) { mean(i) } else { values[i] }).collect()
    }

    /// Values for logs that were not fitted, which begin as they were measured.
    pub(super) fn as_measured(&self, mut values: Vec<f64>) -> Vec<f64> {
        let initial = self.parameters.iter().zip(&mut values);
        let initial = initial.filter(|(parameter, _)| INITIAL.contains(&parameter.name));
        initial.for_each(|(_, value)| *value = 0.0);
        values
    }

    /// The value of a parameter for a log. Of parameters that each log has for itself a log beyond
    /// those fitted takes the mean.
    pub(super) fn value<T: Scalar>(&self, values: &[T], log: usize, name: &str) -> Option<T> {
        let all = self.parameters.iter().zip(&self.of_logs).zip(values);
        let ours = all.filter(|((parameter, _), _)| parameter.name == name);
        let ours = ours.map(|((_, of), &value)| (*of, value));
        let one = ours.clone().find(|(of, _)| of.is_none_or(|of| of == log));
        one.map(|(_, value)| value).or_else(|| {
            let sum = ours.clone().map(|(_, value)| value).reduce(|sum, value| sum + value)?;
            Some(sum / lit(ours.count() as f64))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Term;

    #[test]
    fn the_derivative_of_a_torque_is_its_slope() {
        for (term, parameters) in [
            (Term::Gravity, vec![0.6, 0.2]),
            (Term::constant(), vec![0.3]),
            (Term::spring(), vec![0.7]),
            (Term::backward_drag(), vec![0.4]),
        ]
        .into_iter()
        .chain(Term::ripple(3.0).map(|term| (term, vec![0.2])))
        {
            for v in [0.3, -0.3] {
                let at = |x: f64, v: f64| term.torque(&parameters, 0.1, x, v)[0];
                let (h, [_, by_x, by_v]) = (1e-5, term.torque(&parameters, 0.1, 0.5, v));
                let slope = (at(0.5 + h, v) - at(0.5 - h, v)) / (2.0 * h);
                // h² of the cubic term, and roundings over h.
                assert!((by_x - slope).abs() < 1e-8, "{term:?}: {by_x} {slope}");
                let slope = (at(0.5, v + h) - at(0.5, v - h)) / (2.0 * h);
                assert!((by_v - slope).abs() < 1e-8, "{term:?}: {by_v} {slope}");
            }
        }
    }
}
