//! The mechanism around the friction: which torques there are, and which of their parameters are
//! known, searched, or of each log.

use alloc::sync::Arc;
use alloc::vec::Vec;
use core::fmt;

use super::friction::Friction;
use super::log::{DriveLog, Source};
use super::start::Guess;
use crate::{Estimate, Parameter};
use bristle::Scalar;
use bristle::parameter::{self, ParameterError};
use bristle::scalar::{lit, nan, to_f64};

/// A torque on the load side of the gear: it loads the gear as an external torque does.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Term {
    /// A constant torque, parameter `offset_torque` [N m].
    Constant,
    /// −k x, parameter `spring_rate` [N m/rad].
    Spring,
    /// −G sin(x − x0), parameters `gravity_torque` G [N m] and `hanging_angle` x0 \[rad\]. To G is
    /// added what a log [knows](super::KnownLoad).
    Gravity,
    /// θ φ(x, v) with a function of your own and its factor θ as parameter, see [`Term::own`].
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

    /// Number of parameters.
    pub(super) fn count(&self) -> usize {
        if matches!(self, Self::Gravity) { 2 } else { 1 }
    }

    /// The torque of the parameters at a position and a velocity, and its derivatives with respect
    /// to them. To the torque of gravity is added a known one.
    #[inline]
    pub(super) fn torque<T: Scalar>(&self, parameters: &[T], known: f64, x: T, v: T) -> [T; 3] {
        let zero = T::zero();
        match (self, parameters) {
            (Self::Constant, &[torque]) => [torque, zero, zero],
            (Self::Spring, &[rate]) => [-rate * x, -rate, zero],
            (Self::Gravity, &[torque, hanging]) => {
                let torque = torque + lit(known);
                let (sin, cos) = (x - hanging).sin_cos();
                [-torque * sin, -torque * cos, zero]
            }
            (Self::Own(own), &[factor]) => {
                let (at_x, at_v) = (to_f64(x), to_f64(v));
                let [value, by_x, by_v] = (own.torque)(at_x, at_v).map(lit::<T>);
                // The value with the derivatives that x and v carry.
                let value = value + by_x * (x - lit(at_x)) + by_v * (v - lit(at_v));
                [value * factor, by_x * factor, by_v * factor]
            }
            _ => [nan(); 3],
        }
    }

    fn parameters(&self, guess: &Guess, found: &[f64]) -> Vec<Parameter> {
        let torque = guess.torque;
        let signed = |name, unit, start: f64, typical: f64| {
            let most = start.abs() + 30.0 * typical;
            Parameter { name, unit, start, least: -most, most, typical: Some(typical) }
        };
        match (self, found) {
            (Self::Constant, &[c]) => alloc::vec![signed("offset_torque", "N m", c, 0.1 * torque)],
            (Self::Spring, &[rate]) => {
                alloc::vec![signed("spring_rate", "N m/rad", rate, 0.1 * torque / guess.range)]
            }
            (Self::Gravity, &[gravity, hanging]) => {
                let gravity = gravity.max(0.01 * torque);
                let hanging = signed("hanging_angle", "rad", hanging, 0.1);
                alloc::vec![Parameter::positive("gravity_torque", "N m", gravity, 100.0), hanging]
            }
            (Self::Own(own), &[factor]) => {
                let typical = if factor == 0.0 { torque } else { factor.abs() };
                alloc::vec![signed(own.name, own.unit, factor, typical)]
            }
            _ => Vec::new(),
        }
    }
}

/// The names that a joint takes.
const TAKES: &str = "a joint takes inertia and drag; \
    torque_constant, resistance and duty_exponent with a drive that has them; \
    offset_torque with Term::Constant; spring_rate with Term::Spring; \
    gravity_torque and hanging_angle with Term::Gravity; names of its own terms; \
    coulomb_torque, motor_load_factor, external_load_factor, breakaway_excess, \
    stribeck_velocity, backward_ratio, micro_stiffness and micro_damping";

/// What is said of a parameter beforehand.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Said {
    Known(f64),
    Start(f64),
    Between([f64; 3]),
    OfEachLog,
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

    fn say(mut self, name: &'static str, said: Said) -> Self {
        self.said.push((name, said));
        self
    }

    /// With a parameter that is known: it is not searched.
    #[must_use]
    pub fn known(self, name: &'static str, value: f64) -> Self {
        self.say(name, Said::Known(value))
    }

    /// With a parameter whose search starts from a value. `torque_constant` and `resistance` need
    /// one, or must be known; `duty_exponent` is 1 unless one is given.
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

    /// A value given for a parameter, and whether it is known.
    pub(super) fn given(&self, name: &str) -> Option<(f64, bool)> {
        let said = self.said.iter().rev().filter(|(of, _)| *of == name);
        said.filter_map(|(_, said)| match *said {
            Said::Known(value) => Some((value, true)),
            Said::Start(value) | Said::Between([value, ..]) => Some((value, false)),
            Said::OfEachLog => None,
        })
        .next()
    }

    /// The parameters of joint and friction in their order, for so many logs.
    pub(super) fn table(
        &self,
        friction: &Friction,
        guess: &Guess,
        logs: usize,
    ) -> Result<Table, ParameterError> {
        let mut base = alloc::vec![Parameter::positive("inertia", "kg m²", guess.inertia, 1000.0)];
        if let Some(constant) = guess.torque_constant {
            base.push(Parameter::positive("torque_constant", "N m/A", constant, 30.0));
        }
        if let Some(resistance) = guess.resistance {
            base.push(Parameter::positive("resistance", "Ω", resistance, 30.0));
        }
        if guess.constants.duty_exponent {
            base.push(Parameter {
                name: "duty_exponent",
                unit: "",
                start: 1.0,
                least: 0.2,
                most: 3.0,
                typical: Some(0.3),
            });
        }
        let viscous = guess.torque / guess.speed;
        let (least, most, typical) = (0.0, 10.0 * viscous, Some(0.1 * viscous));
        let (name, unit, start) = ("drag", "N m s/rad", guess.drag);
        base.push(Parameter { name, unit, start, least, most, typical });
        let mut found = guess.terms.as_slice();
        for term in &self.terms {
            let (ours, others) = found.split_at_checked(term.count()).unwrap_or_default();
            base.extend(term.parameters(guess, ours));
            found = others;
        }
        base.extend(friction.parameters(guess));
        let mut each = alloc::vec![false; base.len()];
        for &(name, said) in &self.said {
            let place = base.iter().position(|parameter| parameter.name == name);
            let Some((parameter, each)) =
                place.and_then(|i| Some((base.get_mut(i)?, each.get_mut(i)?)))
            else {
                // Of the friction's parameters each candidate has its own.
                if Friction::NAMES.contains(&name) {
                    continue;
                }
                return Err(parameter::chosen(name, TAKES));
            };
            match said {
                Said::Known(value) => {
                    parameter::finite(name, value)?;
                    (parameter.start, parameter.least, parameter.most) = (value, value, value);
                    let size = if value == 0.0 { 1.0 } else { value.abs() };
                    parameter.typical = Some(size);
                }
                Said::Start(value) => {
                    parameter::finite(name, value)?;
                    parameter.start = value;
                    if parameter.typical.is_none() {
                        parameter::positive(name, value)?;
                        (parameter.least, parameter.most) = (value / 30.0, value * 30.0);
                    }
                    parameter.least = parameter.least.min(value);
                    parameter.most = parameter.most.max(value);
                }
                Said::Between([start, least, most]) => {
                    (parameter.start, parameter.least, parameter.most) = (start, least, most);
                }
                Said::OfEachLog => *each = true,
            }
        }
        Ok(Table::new(&base, &each, logs))
    }
}

/// Parameters as they are searched: those of each log several times.
#[derive(Debug, Clone)]
pub(super) struct Table {
    pub(super) parameters: Vec<Parameter>,
    /// Number of its log.
    pub(super) logs: Vec<Option<usize>>,
    /// For each parameter of a log, its place; of those of each log, that of the first.
    places: Vec<(usize, bool)>,
    count: usize,
}

impl Table {
    fn new(base: &[Parameter], each: &[bool], count: usize) -> Self {
        let (mut parameters, mut logs, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for (&parameter, &each) in base.iter().zip(each) {
            places.push((parameters.len(), each));
            for log in 0..if each { count } else { 1 } {
                parameters.push(parameter);
                logs.push(each.then_some(log));
            }
        }
        Self { parameters, logs, places, count }
    }

    /// The values of a log. Of parameters that each log has for itself a log beyond those fitted
    /// takes the mean.
    pub(super) fn of_log<T: Scalar>(&self, values: &[T], log: usize) -> Vec<T> {
        let one = |&(place, each): &(usize, bool)| {
            let ours = if each { values.get(place..place + self.count) } else { None };
            match ours {
                Some(ours) => ours.get(log).copied().unwrap_or_else(|| {
                    let sum = ours.iter().fold(T::zero(), |sum, &value| sum + value);
                    sum / lit(self.count as f64)
                }),
                None => values.get(place).copied().unwrap_or_else(nan),
            }
        };
        self.places.iter().map(one).collect()
    }

    /// The values of the first log by their names.
    pub(super) fn start_from(&mut self, values: &[f64]) {
        for (parameter, &value) in self.parameters.iter_mut().zip(values) {
            parameter.start = value;
        }
    }

    /// Number of parameters that are searched.
    pub(super) fn searched(&self) -> usize {
        self.parameters.iter().filter(|parameter| parameter.least < parameter.most).count()
    }

    /// Numbers the estimates by their logs.
    pub(super) fn number(&self, estimates: &mut [Estimate]) {
        for (estimate, &log) in estimates.iter_mut().zip(&self.logs) {
            estimate.log = log;
        }
    }
}

/// Which constants of the motor are among the parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct MotorConstants {
    pub(super) torque_constant: bool,
    pub(super) resistance: bool,
    pub(super) duty_exponent: bool,
}

impl MotorConstants {
    /// Those that the drives of the logs need, and an exponent if something is said of it.
    pub(super) fn of(joint: &Joint, logs: &[DriveLog]) -> Self {
        let duty = |log: &DriveLog| matches!(log.source, Source::Duty { .. });
        let current = logs.iter().any(|log| log.source == Source::Current);
        let resistance = logs.iter().any(|log| duty(log) || log.source == Source::Voltage);
        let said = joint.given("duty_exponent").is_some();
        Self {
            torque_constant: resistance || current,
            resistance,
            duty_exponent: said && logs.iter().any(duty),
        }
    }

    /// Whether a fit with these constants can simulate logs that need others.
    pub(super) fn cover(self, other: Self) -> bool {
        self.torque_constant >= other.torque_constant && self.resistance >= other.resistance
    }

    /// Their number.
    pub(super) fn count(self) -> usize {
        [self.torque_constant, self.resistance, self.duty_exponent].map(usize::from).iter().sum()
    }
}
