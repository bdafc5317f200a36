//! The mechanism of one log in any scalar: its torques, its passive step, and its friction along
//! the measured motion.
//!
//! A step of length h takes torques and friction at its middle, predicted from the last
//! acceleration, and the dependence of the torques on position and velocity implicitly, as
//! [`GearedJoint::step`](bristle_joint::GearedJoint::step) does.

use alloc::vec::Vec;

use super::friction::{Friction, Gear};
use super::joint::{Joint, MotorConstants};
use super::log::{DriveLog, Source};
use super::smooth::Smoothed;
use crate::residuals::within;
use bristle::parameter::ParameterError;
use bristle::scalar::{lit, nan};
use bristle::{Bristle, Scalar};
use bristle_joint::{GearFriction, GearTorques};

/// A torque and its derivatives with respect to position and velocity.
type Torque<T> = [T; 3];

/// The mechanism of one log.
pub(super) struct Plant<'a, T: Scalar> {
    log: &'a DriveLog,
    rows: &'a [Smoothed],
    joint: &'a Joint,
    inertia: T,
    /// k_t.
    constant: T,
    /// k_t/R.
    gain: T,
    /// γ of the duty, if it is not one.
    exponent: Option<T>,
    terms: Vec<T>,
    pub(super) gear: Gear<T>,
}

/// Motion and deflection at an instant, and the mean acceleration before it.
#[derive(Debug, Clone, Copy)]
pub(super) struct State<T> {
    pub(super) position: T,
    pub(super) velocity: T,
    pub(super) deflection: T,
    pub(super) acceleration: T,
}

impl<'a, T: Scalar> Plant<'a, T> {
    /// From the parameters of a log, in the order of [`Joint::table`].
    pub(super) fn new(
        joint: &'a Joint,
        friction: &Friction,
        (log, rows): (&'a DriveLog, &'a [Smoothed]),
        constants: MotorConstants,
        fastest: f64,
        values: &[T],
    ) -> Result<Self, ParameterError> {
        let one = T::one();
        let terms: usize = joint.terms.iter().map(|term| term.count()).sum();
        let skipped = 2 + constants.count() + terms;
        let friction_values = values.get(skipped..).unwrap_or_default();
        let mut all = values.iter().copied();
        let mut next = || all.next().unwrap_or_else(nan);
        let inertia = next() + lit(log.load.inertia);
        let constant = if constants.torque_constant { next() } else { one };
        let gain = if constants.resistance { constant / next() } else { constant };
        let exponent = constants.duty_exponent.then(&mut next);
        let drag = next();
        let terms: Vec<T> = all.take(terms).collect();
        let gear = GearFriction::new(friction.gear(friction_values, drag, fastest)?)?;
        Ok(Self { log, rows, joint, inertia, constant, gain, exponent, terms, gear })
    }

    /// Time of a row \[s\].
    pub(super) fn time(&self, row: usize) -> f64 {
        self.log.time.get(row).copied().unwrap_or(f64::NAN)
    }

    /// Measured position at a row \[rad\].
    pub(super) fn position(&self, row: usize) -> f64 {
        self.log.position.get(row).copied().unwrap_or(f64::NAN)
    }

    /// Torque of the motor between a row and the next, at a share of the time between them.
    #[inline]
    fn motor(&self, row: usize, share: f64, x: T, v: T) -> Torque<T> {
        let zero = T::zero();
        let log = self.log;
        if !log.enabled.get(row).copied().unwrap_or(false) {
            return [zero; 3];
        }
        let between = |values: &[f64]| {
            let here = values.get(row).copied().unwrap_or(f64::NAN);
            let next = values.get(row + 1).copied().unwrap_or(here);
            lit::<T>(if log.held { here } else { here + share * (next - here) })
        };
        let drive = between(&log.drive);
        match &log.source {
            Source::Torque => [drive, zero, zero],
            Source::Current => [self.constant * drive, zero, zero],
            Source::Voltage => self.electric(drive, zero, v),
            Source::Duty { gain, supply } => {
                let (supply, gain) = (between(supply), lit::<T>(*gain));
                let duty = gain * (drive - x);
                if duty.abs() < T::one() {
                    let (share, slope) = self.effective(duty);
                    self.electric(supply * share, -supply * gain * slope, v)
                } else {
                    self.electric(supply * duty.signum(), zero, v)
                }
            }
        }
    }

    /// The motor torque that loads the gear: that of a measured drive is smoothed. Its noise would
    /// load and unload the gear in every step, and each rise makes the bristle forget.
    #[inline]
    fn loading(&self, row: usize, share: f64, motor: T, v: T) -> T {
        let enabled = self.log.enabled.get(row).copied().unwrap_or(false);
        let (Some(here), Some(next)) = (self.rows.get(row), self.rows.get(row + 1)) else {
            return motor;
        };
        if self.log.held || !enabled {
            return motor;
        }
        let effort = lit(here.effort + share * (next.effort - here.effort));
        match self.log.source {
            Source::Torque => effort,
            Source::Current => self.constant * effort,
            Source::Voltage => self.electric(effort, T::zero(), v)[0],
            Source::Duty { .. } => motor,
        }
    }

    /// sgn(d) |d|^γ of the duty d, and its slope; rounded off at a thousandth.
    #[inline]
    fn effective(&self, duty: T) -> (T, T) {
        let Some(exponent) = self.exponent else { return (duty, T::one()) };
        let less = exponent - T::one();
        let square = duty * duty;
        let size = square + lit(1e-6);
        let factor = size.powf(lit::<T>(0.5) * less);
        (duty * factor, factor * (T::one() + less * square / size))
    }

    /// Torque of a voltage that may depend on the position.
    #[inline]
    fn electric(&self, voltage: T, by_position: T, v: T) -> Torque<T> {
        let emf = self.constant;
        [self.gain * (voltage - emf * v), self.gain * by_position, -self.gain * emf]
    }

    /// Torque of all terms and a measured one.
    #[inline]
    fn external(&self, measured: f64, x: T, v: T) -> Torque<T> {
        let zero = T::zero();
        let (mut sum, mut rest) = ([lit(measured), zero, zero], self.terms.as_slice());
        for term in &self.joint.terms {
            let (ours, others) = rest.split_at_checked(term.count()).unwrap_or_default();
            let torque = term.torque(ours, self.log.load.gravity_torque, x, v);
            for (sum, part) in sum.iter_mut().zip(torque) {
                *sum += part;
            }
            rest = others;
        }
        sum
    }

    /// Motor torque and external torque of a smoothed row.
    pub(super) fn measured(&self, row: &Smoothed) -> GearTorques<T> {
        let (x, v): (T, T) = (lit(row.position), lit(row.velocity));
        let effort = match (&self.log.source, row.supply > 0.0) {
            (Source::Duty { .. }, true) => {
                let supply = lit::<T>(row.supply);
                supply * self.effective(lit::<T>(row.effort) / supply).0
            }
            _ => lit(row.effort),
        };
        let motor = match self.log.source {
            Source::Torque => effort,
            Source::Current => self.constant * effort,
            Source::Voltage | Source::Duty { .. } => {
                self.gain * (effort - lit::<T>(row.enabled) * self.constant * v)
            }
        };
        GearTorques { motor, external: self.external(row.external, x, v)[0] }
    }

    /// The torque that friction takes from a smoothed row, by the equation of motion.
    pub(super) fn remaining(&self, row: &Smoothed) -> T {
        let GearTorques { motor, external } = self.measured(row);
        motor + external
            - self.inertia * lit(row.acceleration)
            - self.gear.drag() * lit(row.velocity)
    }

    /// The deflection that gives the torque which friction takes from a smoothed row, at most that
    /// of steady sliding; the gear is loaded as there.
    pub(super) fn deflected(&mut self, row: &Smoothed) -> Result<T, ParameterError> {
        let (torque, torques) = (self.remaining(row), self.measured(row));
        let load = self.gear.load(torques);
        let none = self.gear.step(torques, T::zero(), T::zero(), T::zero())?;
        let _ = none;
        let model = self.gear.model();
        let full = model.stationary(bristle::Branch::Forward.of(T::zero()));
        let share = torque / (load * model.storage_stiffness() * full);
        Ok(full * if share.is_finite() { within(share, -T::one(), T::one()) } else { T::zero() })
    }

    /// The deflection at a row, from that at the row before, along the measured motion.
    pub(super) fn follow(
        &mut self,
        deflection: T,
        before: &Smoothed,
        after: &Smoothed,
        duration: f64,
    ) -> Result<T, ParameterError> {
        let (one, other) = (self.measured(before), self.measured(after));
        let half = lit::<T>(0.5);
        let torques = GearTorques {
            motor: half * (one.motor + other.motor),
            external: half * (one.external + other.external),
        };
        let velocity = lit(0.5 * (before.velocity + after.velocity));
        let step = self.gear.step(torques, velocity, deflection, lit(duration))?;
        Ok(step.commit(velocity).deflection)
    }

    /// Torque of the friction at a smoothed row.
    pub(super) fn friction(&self, row: &Smoothed, deflection: T) -> T {
        let load = self.gear.load(self.measured(row));
        load * self.gear.model().coefficient(lit::<T>(row.velocity), deflection)
    }

    /// The motion at the next row, in so many steps.
    #[inline]
    pub(super) fn advance(
        &mut self,
        mut state: State<T>,
        row: usize,
        steps: u32,
    ) -> Result<State<T>, ParameterError> {
        let duration = self.time(row + 1) - self.time(row);
        let h = lit::<T>(duration / f64::from(steps));
        let (half, two) = (lit::<T>(0.5) * h, lit::<T>(2.0));
        for number in 0..steps {
            let share = (f64::from(number) + 0.5) / f64::from(steps);
            let State { position, velocity, deflection, acceleration } = state;
            let predicted = velocity + half * acceleration;
            let middle = position + half * predicted;
            let motor = self.motor(row, share, middle, predicted);
            let here = self.log.external.get(row).copied().unwrap_or(0.0);
            let next = self.log.external.get(row + 1).copied().unwrap_or(here);
            let external = self.external(here + share * (next - here), middle, predicted);
            let loading = self.loading(row, share, motor[0], predicted);
            let torques = GearTorques { motor: loading, external: external[0] };
            let step = self.gear.step(torques, predicted, deflection, h)?;
            let slope = half * (motor[1] + external[1]) + motor[2] + external[2];
            let driving = motor[0] + external[0] - slope * (predicted - velocity);
            let resisting = self.inertia + half * (step.damping() - slope);
            let acceleration = (driving - step.torque(velocity)) / resisting;
            let mean = velocity + half * acceleration;
            state = State {
                position: position + h * mean,
                velocity: two * mean - velocity,
                deflection: step.commit(mean).deflection,
                acceleration,
            };
        }
        Ok(state)
    }
}
