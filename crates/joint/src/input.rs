//! What acts on a joint: torques of gravity and of a motor, its current or voltage, a controller.
//!
//! | input | value | |
//! |---|---|---|
//! | a number, a [`signal`](bristle::signal) | u(t) | anything that depends on time alone |
//! | [`Gravity`] | −G sin(q − q0) | N m |
//! | [`PositionControl`] | K_p (r(t) − q) − K_d v | torque, current or voltage |
//! | [`CurrentMotor`] | k_t i | N m |
//! | [`VoltageMotor`] | k_t i, i = (u − k_t v)/R | N m |
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | q, v | angle and angular velocity of the joint | rad, rad/s |
//! | G, q0 | torque of a horizontal link, angle at which it hangs | N m, rad |
//! | r, K_p, K_d | reference, gains | rad, per rad, per rad/s |
//! | k_t | torque constant at the joint: that of the motor times the ratio of the gear | N m/A |
//! | i, u, R | current, voltage, resistance | A, V, Ω |
//!
//! In SI units the constant of the back-EMF is k_t, too [V s/rad]. The inductance is left out: it
//! is over within a millisecond.

use core::fmt::Debug;

use bristle::Scalar;
use bristle::parameter::{Checked, Named};
use bristle::scalar::lit;
use bristle::signal::{AnySignal, Function, Polyline, Signal, Sine, Vertex};
#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// Time and motion of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointMotion<T> {
    /// Time t \[s\].
    pub time: T,
    /// Angle q \[rad\].
    pub angle: T,
    /// Angular velocity v [rad/s].
    pub velocity: T,
}

/// The value of a [`JointInput`] and its partial derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointInputValue<T> {
    /// The value.
    pub value: T,
    /// Its derivative with respect to the angle [1/rad].
    pub by_angle: T,
    /// Its derivative with respect to the angular velocity [s/rad].
    pub by_velocity: T,
}

impl<T: Scalar> JointInputValue<T> {
    /// A value that does not change.
    pub fn constant(value: T) -> Self {
        let zero = T::zero();
        Self { value, by_angle: zero, by_velocity: zero }
    }

    /// Refuses a value or a derivative that is not finite.
    pub(super) fn check(self, name: &'static str) -> Checked<()> {
        let Self { value, by_angle, by_velocity } = self;
        let mut all = [value, by_angle, by_velocity].into_iter();
        all.try_for_each(|number| Named(name, number).finite().map(drop))
    }

    /// This value times a factor.
    #[inline]
    fn scaled(self, factor: T) -> Self {
        let [value, by_angle, by_velocity] =
            [self.value, self.by_angle, self.by_velocity].map(|number| number * factor);
        Self { value, by_angle, by_velocity }
    }

    /// This value, cut to a size.
    #[inline]
    fn within(self, limit: Option<T>) -> Self {
        match limit {
            Some(limit) if self.value > limit => Self::constant(limit),
            Some(limit) if self.value < -limit => Self::constant(-limit),
            _ => self,
        }
    }
}

/// A quantity that depends on time and motion of a joint: a torque, a current, a voltage. Numbers
/// and the signals of [`signal`](bristle::signal) are such inputs.
///
/// ```
/// use bristle_joint::{JointInput, JointInputValue, JointMotion};
///
/// /// A spring on the joint [N m/rad].
/// #[derive(Debug, Clone)]
/// struct Spring(f64);
///
/// impl JointInput<f64> for Spring {
///     fn at(&self, motion: JointMotion<f64>) -> JointInputValue<f64> {
///         let torque = JointInputValue::constant(-self.0 * motion.angle);
///         JointInputValue { by_angle: -self.0, ..torque }
///     }
/// }
/// ```
pub trait JointInput<T: Scalar>: Debug + Clone {
    /// The value and its partial derivatives.
    fn at(&self, motion: JointMotion<T>) -> JointInputValue<T>;

    /// The first time strictly between `time` and `towards` at which the input is not smooth, see
    /// [`Signal::next_kink`].
    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        let _ = (time, towards);
        None
    }

    /// A time \[s\] within which the input has no more than one extremum over time, see
    /// [`Signal::longest_step`].
    fn longest_step(&self) -> Option<T> {
        None
    }
}

/// A signal, as an input that depends on time alone.
macro_rules! of_time {
    ($($header:tt)*) => {
        $($header)* {
            #[inline]
            fn at(&self, motion: JointMotion<T>) -> JointInputValue<T> {
                JointInputValue::constant(self.value(motion.time))
            }

            fn next_kink(&self, time: T, towards: T) -> Option<T> {
                Signal::next_kink(self, time, towards)
            }

            fn longest_step(&self) -> Option<T> {
                Signal::longest_step(self)
            }
        }
    };
}

of_time!(impl<T: Scalar> JointInput<T> for T);
of_time!(impl<T: Scalar> JointInput<T> for Sine<T>);
of_time!(impl<T: Scalar> JointInput<T> for AnySignal<T>);
of_time!(impl<T: Scalar, const K: usize> JointInput<T> for Polyline<[Vertex<T>; K]>);
of_time!(impl<T: Scalar> JointInput<T> for Polyline<&[Vertex<T>]>);
#[cfg(feature = "alloc")]
of_time!(impl<T: Scalar> JointInput<T> for Polyline<alloc::vec::Vec<Vertex<T>>>);
of_time!(impl<T: Scalar, F: Fn(T) -> (T, T) + Clone, const K: usize> JointInput<T>
    for Function<T, F, K>);

/// The torque of gravity on a link, −G sin(q − q0) [N m].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "serde", serde(bound(deserialize = "T: Scalar + Deserialize<'de>")))]
pub struct Gravity<T> {
    /// Torque G [N m] of the horizontal link: its mass times 9.81 m/s² times the distance of its
    /// centre of mass from the axis.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::file::horizontal_torque"))]
    pub horizontal_torque: T,
    /// Angle q0 \[rad\] at which the link hangs.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::file::hanging_angle"))]
    pub hanging_angle: T,
}

impl<T: Scalar> JointInput<T> for Gravity<T> {
    #[inline]
    fn at(&self, motion: JointMotion<T>) -> JointInputValue<T> {
        let (sin, cos) = (motion.angle - self.hanging_angle).sin_cos();
        let (value, by_angle) = (-self.horizontal_torque * sin, -self.horizontal_torque * cos);
        JointInputValue { by_angle, ..JointInputValue::constant(value) }
    }
}

/// A position controller: K_p (r(t) − q) − K_d v, a torque, a current or a voltage.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(deserialize = "T: Scalar + Deserialize<'de>, R: Deserialize<'de>"))
)]
pub struct PositionControl<T, R> {
    /// Reference r(t) \[rad\].
    pub reference: R,
    /// Gain K_p, in units of the output per rad.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::file::proportional_gain"))]
    pub proportional_gain: T,
    /// Gain K_d, in units of the output per rad/s.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::file::derivative_gain"))]
    pub derivative_gain: T,
}

impl<T: Scalar, R: Signal<T>> JointInput<T> for PositionControl<T, R> {
    #[inline]
    fn at(&self, motion: JointMotion<T>) -> JointInputValue<T> {
        let Self { reference, proportional_gain, derivative_gain } = self;
        let error = reference.value(motion.time) - motion.angle;
        JointInputValue {
            value: *proportional_gain * error - *derivative_gain * motion.velocity,
            by_angle: -*proportional_gain,
            by_velocity: -*derivative_gain,
        }
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        self.reference.next_kink(time, towards)
    }

    fn longest_step(&self) -> Option<T> {
        self.reference.longest_step()
    }
}

/// Parameters of [`CurrentMotor`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct CurrentMotorParameters<T, I> {
    /// Current i asked for \[A\].
    pub current: I,
    /// Torque constant k_t at the joint [N m/A], positive.
    #[doc(alias = "k_t")]
    pub torque_constant: T,
    /// Largest current \[A\], positive; `None` for no limit.
    pub largest_current: Option<T>,
}

/// The torque [N m] of a motor whose current is given: k_t i, with |i| up to a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurrentMotor<T, I> {
    parameters: CurrentMotorParameters<T, I>,
}

impl<T: Scalar, I: JointInput<T>> CurrentMotor<T, I> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a torque constant or a largest current that is not positive.
    pub fn new(parameters: CurrentMotorParameters<T, I>) -> Checked<Self> {
        Named("torque_constant", parameters.torque_constant).positive()?;
        positive("largest_current", parameters.largest_current)?;
        Ok(Self { parameters })
    }

    /// The parameters.
    pub fn parameters(&self) -> CurrentMotorParameters<T, I> {
        self.parameters.clone()
    }
}

impl<T: Scalar, I: JointInput<T>> JointInput<T> for CurrentMotor<T, I> {
    #[inline]
    fn at(&self, motion: JointMotion<T>) -> JointInputValue<T> {
        let CurrentMotorParameters { current, torque_constant, largest_current } = &self.parameters;
        current.at(motion).within(*largest_current).scaled(*torque_constant)
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        self.parameters.current.next_kink(time, towards)
    }

    /// Where the limit cuts the input, its extremum is flat, and what lies between two cuts is
    /// short: half of what the input asks for.
    fn longest_step(&self) -> Option<T> {
        self.parameters.current.longest_step().map(|step| step * lit(0.5))
    }
}

/// Parameters of [`VoltageMotor`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct VoltageMotorParameters<T, U> {
    /// Voltage u asked for \[V\].
    pub voltage: U,
    /// Torque constant k_t at the joint [N m/A], positive; also the constant of the back-EMF
    /// [V s/rad].
    #[doc(alias = "k_t")]
    pub torque_constant: T,
    /// Resistance R \[Ω\], positive.
    pub resistance: T,
    /// Largest voltage \[V\], positive: that of the supply; `None` for no limit.
    pub largest_voltage: Option<T>,
    /// Largest current \[A\], positive; `None` for no limit.
    pub largest_current: Option<T>,
}

/// The torque [N m] of a motor whose voltage is given: k_t i with i = (u − k_t v)/R, with |u| and
/// |i| up to limits.
///
/// ```
/// use bristle_joint::{JointInput, JointMotion, VoltageMotor, VoltageMotorParameters};
///
/// let motor = VoltageMotor::new(VoltageMotorParameters {
///     voltage: 20.0, // V, more than there is
///     torque_constant: 1.2,
///     resistance: 2.4,
///     largest_voltage: Some(12.0),
///     largest_current: None,
/// })?;
/// // 1.2 · (12 − 1.2 · 5)/2.4
/// let torque = motor.at(JointMotion { time: 0.0, angle: 0.0, velocity: 5.0 });
/// assert!((torque.value - 3.0_f64).abs() < 1e-14 && (torque.by_velocity + 0.6).abs() < 1e-15);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoltageMotor<T, U> {
    parameters: VoltageMotorParameters<T, U>,
}

impl<T: Scalar, U: JointInput<T>> VoltageMotor<T, U> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a torque constant, a resistance or a limit that is not positive.
    pub fn new(parameters: VoltageMotorParameters<T, U>) -> Checked<Self> {
        Named("torque_constant", parameters.torque_constant).positive()?;
        Named("resistance", parameters.resistance).positive()?;
        positive("largest_voltage", parameters.largest_voltage)?;
        positive("largest_current", parameters.largest_current)?;
        Ok(Self { parameters })
    }

    /// The parameters.
    pub fn parameters(&self) -> VoltageMotorParameters<T, U> {
        self.parameters.clone()
    }
}

impl<T: Scalar, U: JointInput<T>> JointInput<T> for VoltageMotor<T, U> {
    #[inline]
    fn at(&self, motion: JointMotion<T>) -> JointInputValue<T> {
        let VoltageMotorParameters { torque_constant, resistance, .. } = self.parameters;
        let mut voltage =
            self.parameters.voltage.at(motion).within(self.parameters.largest_voltage);
        voltage.value -= torque_constant * motion.velocity;
        voltage.by_velocity -= torque_constant;
        let current = voltage.scaled(T::one() / resistance).within(self.parameters.largest_current);
        current.scaled(torque_constant)
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        self.parameters.voltage.next_kink(time, towards)
    }

    /// Where the limit cuts the input, its extremum is flat, and what lies between two cuts is
    /// short: half of what the input asks for.
    fn longest_step(&self) -> Option<T> {
        self.parameters.voltage.longest_step().map(|step| step * lit(0.5))
    }
}

/// Checks a limit, if there is one.
fn positive<T: Scalar>(name: &'static str, limit: Option<T>) -> Checked<()> {
    limit.map_or(Ok(()), |limit| Named(name, limit).positive().map(drop))
}
