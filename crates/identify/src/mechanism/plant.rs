//! The mechanism of one log in any scalar: its torques, its passive step, and its friction along
//! the measured motion.
//!
//! The step is [`GearFriction::joint_step`].

use core::ops::Range;

use super::friction::Gear;
use super::joint::{INITIAL, Model, Term, input};
use super::log::{DriveLog, Source};
use super::smooth::Smoothed;
use bristle::parameter::Checked;
use bristle::scalar::lit;
use bristle::{Branch, Bristle, Scalar, Surface};
use bristle_joint::{
    GearFriction, GearTorques, JointMotion, JointState, JointTorques, LoadedDeflection,
};

/// The mechanism of one log.
pub(super) struct Plant<'a, T: Scalar> {
    model: &'a Model,
    log: &'a DriveLog,
    inertia: T,
    /// k_t.
    constant: T,
    /// k_t/R.
    gain: T,
    /// γ of the duty, if it is not one.
    exponent: Option<T>,
    /// L/R of a voltage's motor \[s\], if something is said of L.
    lag: Option<T>,
    /// Delay of the drive that is searched, beside that of the log \[s\].
    delay: Option<T>,
    terms: Vec<T>,
    /// Of a log that begins in motion, what its state there has beside the measured one.
    initial: Option<[T; 2]>,
    /// The friction at the beginning.
    pub(super) gear: Gear<T>,
}

impl<'a, T: Scalar> Plant<'a, T> {
    /// From the parameters of all logs, for the log of a number.
    pub(super) fn new(
        model: &'a Model,
        log: &'a DriveLog,
        number: usize,
        values: &[T],
    ) -> Checked<Self> {
        let value = |name: &str| model.value(values, number, name);
        let constant = value("torque_constant").unwrap_or_else(T::one);
        let names = model.joint.terms.iter().flat_map(Term::names);
        let inductance = value("inductance").filter(|_| log.source.is_electric());
        Ok(Self {
            model,
            log,
            inertia: value("inertia").unwrap_or_else(T::nan) + lit(log.load.inertia),
            constant,
            gain: value("resistance").map_or(constant, |resistance| constant / resistance),
            exponent: value("duty_exponent"),
            lag: inductance.zip(value("resistance")).map(|(l, r)| l / r),
            delay: value("delay"),
            terms: names.map(|name| value(name).unwrap_or_else(T::nan)).collect(),
            initial: log.in_motion.then(|| INITIAL.map(|name| value(name).unwrap_or_else(T::zero))),
            gear: GearFriction::new(model.friction.gear(value, model.fastest)?)?,
        })
    }

    /// Time of a row \[s\].
    fn time(&self, row: usize) -> f64 {
        self.log.time.get(row).copied().unwrap_or(f64::NAN)
    }

    /// Time from a row to the next \[s\].
    pub(super) fn duration(&self, row: usize) -> f64 {
        self.time(row + 1) - self.time(row)
    }

    /// Torque of the motor, with its derivatives by position and velocity, between a row and the
    /// next, at a share of the time between them, and the torque of it that loads the gear: that of
    /// a measured drive is smoothed. Its noise would load and unload the gear in every step, and
    /// let a bristle at its limit slip.
    #[inline]
    fn motor(&self, row: usize, [share, half]: [f64; 2], x: T, v: T) -> ([T; 3], T) {
        let (log, zero) = (self.log, T::zero());
        if !log.enabled.get(row).copied().unwrap_or(false) {
            return ([zero; 3], zero);
        }
        let drive = self.drive(row, share, half);
        let Source::Duty { gain, derivative_gain, supply } = &log.source else {
            let torque = self.driven([drive, zero, zero], v);
            let measured = log.rows.get(row).zip(log.rows.get(row + 1)).filter(|_| log.noisy);
            let loading = measured.map_or(torque[0], |(here, next)| {
                let [here, next] = [here, next].map(|row| self.effort(row));
                self.driven([here + lit::<T>(share) * (next - here), zero, zero], v)[0]
            });
            return (torque, loading);
        };
        let volts = between(supply, row, if log.held { 0.0 } else { share });
        let [supply, gain, derivative_gain] = [volts, *gain, *derivative_gain].map(lit::<T>);
        let duty = gain * (drive - x) - derivative_gain * v;
        let torque = if duty.abs() < T::one() {
            let (share, slope) = self.effective(duty);
            let slopes = [gain, derivative_gain].map(|gain| -supply * gain * slope);
            self.driven([supply * share, slopes[0], slopes[1]], v)
        } else {
            self.driven([supply * duty.signum(), zero, zero], v)
        };
        (torque, torque[0])
    }

    /// The column of the drive as it acts at a share of the time between a row and the next, the
    /// mean over so many shares to both sides.
    #[inline]
    fn drive(&self, row: usize, share: f64, half: f64) -> T {
        let log = self.log;
        if self.delay.is_none() && log.delay == 0.0 {
            return lit(between(&log.drive, row, if log.held { 0.0 } else { share }));
        }
        let duration = self.duration(row);
        let delay = self.delay.unwrap_or_else(T::zero) + lit(log.delay);
        let half = lit::<T>(if log.held { half * duration } else { 0.0 });
        let middle = lit::<T>(self.time(row) + share * duration) - delay;
        let mut from = row;
        while from > 0 && lit::<T>(self.time(from)) > middle - half {
            from -= 1;
        }
        let [here, next] = [from, from + 1].map(|row| lit::<T>(self.time(row)));
        let part = if log.held {
            (middle + half - next) / (half + half)
        } else {
            (middle - here) / (next - here)
        };
        let [one, other] = [0.0, 1.0].map(|share| lit::<T>(between(&log.drive, from, share)));
        one + (other - one) * part.larger(T::zero()).smaller(T::one())
    }

    /// The smoothed drive as it acts at a row. That of a controller acts by its motion, too, and is
    /// not shifted.
    #[inline]
    fn effort(&self, row: &Smoothed) -> T {
        let [a, b, c, _] = row.effort.map(lit::<T>);
        self.delay.filter(|_| row.supply == 0.0).map_or(a, |delay| a - delay * (b - delay * c))
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

    /// Torque of the motor by its own torque, a current, or a voltage that may depend on position
    /// and velocity; with its derivatives.
    #[inline]
    fn driven(&self, [effort, by_position, by_velocity]: [T; 3], v: T) -> [T; 3] {
        let zero = T::zero();
        match self.log.source {
            Source::Torque => [effort, zero, zero],
            Source::Current => [self.constant * effort, zero, zero],
            Source::Voltage | Source::Duty { .. } => {
                let emf = self.constant;
                [effort - emf * v, by_position, by_velocity - emf].map(|volts| self.gain * volts)
            }
        }
    }

    /// Torque of all terms and a measured one, with its derivatives.
    #[inline]
    fn external(&self, measured: f64, x: T, v: T) -> [T; 3] {
        let known = self.log.load.gravity_torque;
        let [sum, by_x, by_v] = Term::sum(&self.model.joint.terms, &self.terms, known, x, v);
        [sum + lit(measured), by_x, by_v]
    }

    /// Motor torque and external torque of a smoothed row.
    pub(super) fn measured(&self, row: &Smoothed) -> GearTorques<T> {
        let (x, v): (T, T) = (lit(row.position), lit(row.velocity));
        let effort = self.effort(row);
        let (supply, is_duty) = (lit::<T>(row.supply), row.supply > 0.0);
        let (mut effort, slope) = if is_duty {
            let (share, slope) = self.effective(effort / supply);
            (supply * share, slope)
        } else {
            (effort, T::one())
        };
        let mut turning = v;
        if let Some(lag) = self.lag {
            // The current of the voltage L/R ago.
            effort -= lag * slope * lit(row.effort[1]);
            turning -= lag * lit(row.acceleration);
        }
        let motor = self.driven([effort, T::zero(), T::zero()], lit::<T>(row.enabled) * turning)[0];
        GearTorques { motor, external: self.external(row.external, x, v)[0] }
    }

    /// The torque that friction takes from a smoothed row, by the equation of motion.
    pub(super) fn remaining(&self, row: &Smoothed) -> T {
        let GearTorques { motor, external } = self.measured(row);
        motor + external
            - self.inertia * lit(row.acceleration)
            - self.gear.drag() * lit(row.velocity)
    }

    /// The deflection of steady sliding under a load.
    fn full(&self, load: T) -> T {
        let contact = self.gear.contact();
        let scale = load / contact.reference_load();
        contact.stationary(Surface::scaled(Branch::Forward.of(T::zero()), scale))
    }

    /// The deflection that gives the torque which friction takes from a smoothed row, at most that
    /// of steady sliding under the load there.
    pub(super) fn deflected(&self, row: &Smoothed) -> LoadedDeflection<T> {
        let (torque, load) = (self.remaining(row), self.gear.load(self.measured(row)));
        let (contact, full) = (self.gear.contact(), self.full(load));
        let stiffness = contact.reference_load() * contact.model().storage_stiffness();
        let share = torque / (stiffness * full);
        let share = if share.is_finite() { share } else { T::zero() };
        let share = share.larger(-T::one()).smaller(T::one());
        LoadedDeflection { deflection: full * share, load }
    }

    /// The deflection at the next row, from that at a row, along the measured motion.
    pub(super) fn follow(
        &self,
        bristle: LoadedDeflection<T>,
        row: usize,
    ) -> Checked<LoadedDeflection<T>> {
        let Some([before, after]) = self.log.rows.get(row..row + 2) else { return Ok(bristle) };
        let (one, other) = (self.measured(before), self.measured(after));
        let half = lit::<T>(0.5);
        let torques = GearTorques {
            motor: half * (one.motor + other.motor),
            external: half * (one.external + other.external),
        };
        let velocity = lit(0.5 * (before.velocity + after.velocity));
        let step = self.gear.step(torques, velocity, bristle, lit(self.duration(row)))?;
        Ok(step.commit(velocity).deflection)
    }

    /// What is left of the equation of motion at a smoothed row [N m].
    pub(super) fn imbalance(&self, row: &Smoothed, deflection: T) -> T {
        let (load, velocity) = (self.gear.load(self.measured(row)), lit::<T>(row.velocity));
        self.remaining(row) - self.gear.contact().response_under(load, velocity, deflection).force
    }

    /// The row at which a simulation begins that cannot see the motion before its rows: at the
    /// first, or, if the log begins in motion, where windows of the smoothing that reach to both
    /// sides have moved the bristle.
    pub(super) fn begins(&self, rows: &Range<usize>) -> usize {
        let wait = if self.initial.is_some() { self.log.wait } else { 0.0 };
        let until = self.time(rows.start) + wait;
        rows.clone().find(|&row| self.time(row) >= until).unwrap_or(rows.start)
    }

    /// The motion that begins at a smoothed row, the first one of a log or another.
    pub(super) fn begin(
        &self,
        row: &Smoothed,
        bristle: LoadedDeflection<T>,
        is_first: bool,
    ) -> Running<T> {
        let [angle, mut velocity, acceleration] =
            [row.position, row.velocity, row.acceleration].map(lit::<T>);
        let (LoadedDeflection { mut deflection, load }, time) = (bristle, T::zero());
        if let (true, Some([faster, share])) = (is_first, self.initial) {
            velocity += faster;
            deflection += share * self.full(load);
        }
        let joint = JointState { time, angle, velocity, deflection, load, acceleration };
        Running { joint, current: [self.measured(row).motor; 2] }
    }

    /// The motion at the next row, in steps up to a length.
    ///
    /// Under a voltage u that is held and a velocity v̄, the current tends to (u − k_t v̄)/R with
    /// e^(−R h/L). So it takes no more energy than it is given, however long the step.
    #[inline]
    pub(super) fn advance(&self, mut state: Running<T>, row: usize) -> Checked<Running<T>> {
        let duration = self.duration(row);
        let steps = (duration / self.model.step - 1e-6).ceil().max(1.0) as u32;
        let h = lit::<T>(duration / f64::from(steps));
        let on = self.log.enabled.get(row).copied().unwrap_or(false);
        let lag = self.lag.filter(|_| on).map(|lag| (lag, settled(h, lag)));
        for number in 0..steps {
            let half = 0.5 / f64::from(steps);
            let share = f64::from(number) / f64::from(steps) + half;
            let Running { joint, current } = state;
            let mut tends = ([T::zero(); 3], T::zero(), T::zero());
            let torques = |JointMotion { angle: x, velocity: v, .. }| {
                let (mut motor, mut loading) = self.motor(row, [share, half], x, v);
                if let Some((lag, settled)) = lag {
                    tends = (motor, loading, v);
                    let mean = T::one() - settled * lag / h;
                    motor = motor.map(|slope| mean * slope);
                    motor[0] += (T::one() - mean) * current[0];
                    loading = mean * loading + (T::one() - mean) * current[1];
                }
                let external = self.external(between(&self.log.external, row, share), x, v);
                let loading = GearTorques { motor: loading, external: external[0] };
                JointTorques { motor: input(motor), external: input(external), loading }
            };
            state.joint = self.gear.joint_step(self.inertia, &joint, h, torques)?.0;
            state.current = lag.map_or([T::zero(); 2], |(_, settled)| {
                let ([steady, by_x, by_v], loading, v) = tends;
                let half = lit::<T>(0.5);
                let other = half * (joint.velocity + state.joint.velocity) - v;
                let steady = steady + (half * h * by_x + by_v) * other;
                let [one, two] = current;
                [one + settled * (steady - one), two + settled * (loading - two)]
            });
        }
        Ok(state)
    }
}

/// The motion of a joint, and the torques of its current: on the joint, and as the gear's load.
#[derive(Clone, Copy)]
pub(super) struct Running<T> {
    pub(super) joint: JointState<T>,
    current: [T; 2],
}

/// By which share a current goes where it tends to, 1 − e^(−h/lag).
fn settled<T: Scalar>(h: T, lag: T) -> T {
    // Beyond a rounding the derivatives by a lag of zero would be 0 · ∞.
    if lag * lit(40.0) > h { T::one() - (-h / lag).exp() } else { T::one() }
}

/// The value of a column at a share of the time between a row and the next.
fn between(values: &[f64], row: usize, share: f64) -> f64 {
    let here = values.get(row).copied().unwrap_or(f64::NAN);
    let next = values.get(row + 1).copied().unwrap_or(here);
    here + share * (next - here)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::mechanism::start::guess;
    use crate::mechanism::{Drive, DriveLogParameters, Friction, Joint};

    /// A servo that swings, with parameters that are known, for a check.
    fn servo(known: &[(&'static str, f64)], check: impl Fn(&DriveLog, &Model, &[f64])) {
        let time: Vec<f64> = (0..100).map(|i| 1e-2 * f64::from(i)).collect();
        let position: Vec<f64> = time.iter().map(|t| (9.0 * t).sin()).collect();
        let goal: Vec<f64> = time.iter().map(|t| 0.7 * (9.0 * t + 0.8).sin()).collect();
        let (gain, derivative_gain, supply) = (3.0, 0.03, vec![7.0; 100]);
        let drive = Drive::Duty { goal: &goal, gain, derivative_gain, supply: &supply };
        let log = DriveLog::new(DriveLogParameters::new(&time, &position, drive)).unwrap();
        let joint = known.iter().fold(Joint::new(), |joint, said| joint.known(said.0, said.1));
        let guess = guess(&joint, core::slice::from_ref(&log)).unwrap();
        let model = joint.model(&Friction::coulomb(), &guess, core::slice::from_ref(&log)).unwrap();
        let values: Vec<f64> = model.parameters.iter().map(|p| p.start).collect();
        check(&log, &model, &values);
    }

    #[test]
    fn the_derivatives_of_a_motor_are_its_slopes() {
        let known = [("torque_constant", 0.4), ("resistance", 3.0), ("duty_exponent", 0.8)];
        servo(&known, |log, model, values| {
            let plant = Plant::new(model, log, 0, values).unwrap();
            let at = |x: f64, v: f64| plant.motor(7, [0.3, 0.1], x, v).0;
            let (h, [_, by_x, by_v]) = (1e-5, at(0.6, 2.0));
            let by = |dx: f64, dv: f64| {
                (at(0.6 + dx, 2.0 + dv)[0] - at(0.6 - dx, 2.0 - dv)[0]) / (2.0 * h)
            };
            for (slope, difference) in [(by_x, by(h, 0.0)), (by_v, by(0.0, h))] {
                // h² of the power, and roundings over h.
                assert!(slope != 0.0 && (slope - difference).abs() < 1e-8, "{slope} {difference}");
            }
        });
    }

    /// Wheel and current swing without a voltage, and no step gives them energy, however long.
    #[test]
    fn a_current_with_inductance_gives_no_energy_of_its_own() {
        for inertia in [1e-6, 1e-4, 1e-2] {
            let (constant, inductance) = (0.4, 0.3);
            let known = [("torque_constant", constant), ("resistance", 3.0), ("drag", 0.0)];
            let known = known.into_iter().chain([("inductance", inductance), ("inertia", 0.01)]);
            let known: Vec<_> = known.chain([("coulomb_torque", 1e-9)]).collect();
            servo(&known, |log, model, values| {
                let drive = vec![0.0; 100];
                let log = DriveLog { source: Source::Voltage, drive, ..log.clone() };
                let values = [&[inertia], &values[1..]].concat();
                let plant = Plant::new(model, &log, 0, &values).unwrap();
                let joint = JointState { velocity: 1.0, ..JointState::at_rest(0.0) };
                let (mut state, mut before) = (Running { joint, current: [0.0; 2] }, f64::INFINITY);
                for row in 0..99 {
                    let [motion, current] = [state.joint.velocity, state.current[0] / constant];
                    let energy = inertia * motion * motion + inductance * current * current;
                    // Roundings.
                    assert!(energy <= before * (1.0 + 1e-12), "{inertia} {row}: {energy} {before}");
                    before = energy;
                    state = plant.advance(state, row).unwrap();
                }
                assert!(before > 0.0 && before < 0.999 * inertia, "{before}");
            });
        }
    }
}
