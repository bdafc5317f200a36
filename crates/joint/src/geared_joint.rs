//! A joint driven by a motor through a gear whose friction follows the torques.
//!
//! q̇ = v,  J v̇ = τ_m + τ_e − T(v, z, p),  ż = h(v, z, p)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | q, v | angle and angular velocity | rad, rad/s |
//! | z | deflection of the bristle | rad |
//! | J | moment of inertia, that of the motor times the square of the gear's ratio | kg m² |
//! | τ_m, τ_e | motor torque, external torque; functions of time, angle and velocity | N m |
//! | p, T | load and friction torque of the gear, see [`GearFriction`] | N m |
//!
//! # Kinks
//!
//! Beside the reversals of v, which the driver locates, p has a kink where its two torques cancel,
//! and T has one where the load falls below what the bristle carries. They are left to the error
//! estimate. Declared as a sliding velocity, the kink of p saved no step in the scene of the tests;
//! locked like one, |k_m τ_m − k_e τ_e| could become negative.
//!
//! # A step
//!
//! [`GearFriction::joint_step`], and with it [`GearedJoint::step`], takes torques and friction at
//! the middle of a step, as predicted from the last acceleration, and the dependence of the torques
//! on angle and velocity about it implicitly:
//!
//! (2J/h) (v̄ − v₀) = τ* + (τ_q h/2 + τ_v)(v̄ − v*) − bias − damping·v̄,  q₁ = q₀ + h v̄.
//!
//! It is of second order, and passive as far as the friction is concerned: the friction torque
//! never gives more energy than was stored.
//!
//! Source: derived here; the load law as in [`GearFriction`].

use nalgebra::Vector3;

use crate::input::{JointInput, JointInputValue, JointMotion};
use crate::{GearFriction, GearTorques, LoadLaw, LoadedDeflection};
use bristle::companion::CompletedStep;
use bristle::ode::System;
use bristle::parameter::{Checked, Named};
use bristle::scalar::lit;
use bristle::{Branch, Bristle, Scalar, Surface};

/// Parameters of [`GearedJoint`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct GearedJointParameters<T, M, L, A, E = T> {
    /// Friction of the gear, with its load law and drag.
    #[cfg_attr(
        feature = "serde",
        serde(bound(
            serialize = "GearFriction<T, M, L>: serde::Serialize",
            deserialize = "GearFriction<T, M, L>: serde::Deserialize<'de>"
        ))
    )]
    pub gear: GearFriction<T, M, L>,
    /// Moment of inertia J [kg m²] at the joint, positive.
    pub inertia: T,
    /// Motor torque τ_m [N m] at the joint: a signal, a [`VoltageMotor`](crate::VoltageMotor), …
    pub motor: A,
    /// External torque τ_e [N m] that loads the gear: [`Gravity`](crate::Gravity), a signal, …; 0
    /// for none.
    pub external: E,
}

/// A joint driven by a motor through a gear.
///
/// States: angle q \[rad\], angular velocity v [rad/s], deflection z \[rad\].
///
/// ```
/// use bristle_joint::{GearFriction, GearFrictionParameters, TorqueLoad, TorqueLoadParameters};
/// use bristle::ode::{self, Output};
/// use bristle_joint::{GearedJoint, GearedJointParameters, Gravity};
/// use bristle::{Dahl, DahlParameters};
///
/// let friction = Dahl::new(DahlParameters { dynamic_coefficient: 0.1, micro_stiffness: 300.0 })?;
/// let load = TorqueLoad::new(TorqueLoadParameters {
///     idle_load: 0.5,
///     motor_share: 1.0,
///     external_share: 0.6,
/// })?;
/// let (reference_load, drag, fastest) = (0.5, 0.05, 10.0);
/// let parameters = GearFrictionParameters { friction, load, reference_load, drag, fastest };
/// let joint = GearedJoint::new(GearedJointParameters {
///     gear: GearFriction::new(parameters)?,
///     inertia: 0.02,
///     motor: 0.0, // switched off: the arm drops and swings
///     external: Gravity { horizontal_torque: 1.2, hanging_angle: 0.0 },
/// })?;
/// let start = [1.5, 0.0, 0.0].into();
/// let drop = ode::solve(&joint, 0.0..10.0, start, 1e-6, Output::Uniform(101))?;
/// // It comes to rest where friction balances gravity, if not before.
/// let end: [f64; 3] = drop.states()[100].into();
/// assert!(end[1].abs() < 1e-3 && 1.2 * end[0].sin().abs() < 0.1 * (0.5 + 0.6 * 1.2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearedJoint<T, M, L, A, E = T> {
    parameters: GearedJointParameters<T, M, L, A, E>,
}

/// The motion of a joint that takes passive steps, and its mean acceleration over the last one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointState<T> {
    /// Time t \[s\].
    pub time: T,
    /// Angle q \[rad\].
    pub angle: T,
    /// Angular velocity v [rad/s].
    pub velocity: T,
    /// Deflection z \[rad\].
    pub deflection: T,
    /// Load p [N m] at the middle of the last step, zero before the first: see
    /// [`LoadedDeflection::load`].
    pub load: T,
    /// Mean acceleration over the last step [rad/s²], from which the next one is predicted.
    pub acceleration: T,
}

impl<T: Scalar> JointState<T> {
    /// A joint at an angle \[rad\] at rest at time zero, with an undeflected bristle.
    pub fn at_rest(angle: T) -> Self {
        let zero = T::zero();
        Self { time: zero, angle, velocity: zero, deflection: zero, load: zero, acceleration: zero }
    }
}

/// The torques on a joint at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointTorques<T> {
    /// Motor torque τ_m [N m] at the joint, with its derivatives.
    pub motor: JointInputValue<T>,
    /// External torque τ_e [N m], with its derivatives.
    pub external: JointInputValue<T>,
    /// The torques that load the gear: the values of the two above, or, where those were measured
    /// and are noisy, smoothed ones. Noise would load and unload the gear in every step.
    pub loading: GearTorques<T>,
}

impl<T: Scalar> JointTorques<T> {
    /// Motor and external torque, which load the gear as they are.
    #[inline]
    pub fn of(motor: JointInputValue<T>, external: JointInputValue<T>) -> Self {
        let loading = GearTorques { motor: motor.value, external: external.value };
        Self { motor, external, loading }
    }
}

/// The state after a step, and the account of the gear's friction over it.
type JointStep<T> = (JointState<T>, CompletedStep<T, LoadedDeflection<T>>);

impl<T: Scalar, M: Bristle<T, Deflection = T>, L: LoadLaw<T>> GearFriction<T, M, L> {
    /// A step of length h ≥ 0 \[s\] of a joint with this friction and a moment of inertia J
    /// [kg m²]: the motion at its end, and what the friction has done, drag included. The torques
    /// are asked for once, at the predicted middle of the step.
    ///
    /// A first state with the true acceleration makes the first step as accurate as the others.
    ///
    /// # Errors
    ///
    /// Refuses a load that is negative or not finite, as that of torques that are not.
    #[inline]
    pub fn joint_step(
        &self,
        inertia: T,
        state: &JointState<T>,
        duration: T,
        torques: impl FnOnce(JointMotion<T>) -> JointTorques<T>,
    ) -> Checked<JointStep<T>> {
        let JointState { time, angle, velocity, deflection, load, acceleration } = *state;
        let (half, two) = (lit::<T>(0.5) * duration, lit::<T>(2.0));
        let predicted = velocity + half * acceleration;
        let middle =
            JointMotion { time: time + half, angle: angle + half * predicted, velocity: predicted };
        let JointTorques { motor, external, loading } = torques(middle);
        let before = LoadedDeflection { deflection, load };
        let step = self.step(loading, predicted, before, duration)?;
        // Of the torques with the mean velocity, −∂τ/∂v̄.
        let slope =
            half * (motor.by_angle + external.by_angle) + motor.by_velocity + external.by_velocity;
        // With v̄ = v + (h/2) a: (J + (h/2) (damping − slope)) a = τ* − slope (v* − v) − T(v).
        let driving = motor.value + external.value - slope * (predicted - velocity);
        let resisting = inertia + half * (step.damping() - slope);
        let acceleration = (driving - step.torque(velocity)) / resisting;
        let mean = velocity + half * acceleration;
        let done = step.commit(mean);
        let next = JointState {
            time: time + duration,
            angle: angle + duration * mean,
            velocity: two * mean - velocity,
            deflection: done.deflection.deflection,
            load: done.deflection.load,
            acceleration,
        };
        Ok((next, done))
    }
}

impl<T, M, L, A, E> GearedJoint<T, M, L, A, E>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    L: LoadLaw<T>,
    A: JointInput<T>,
    E: JointInput<T>,
{
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a moment of inertia that is not positive, and torques or derivatives that are not
    /// finite at rest at the origin at time zero.
    pub fn new(parameters: GearedJointParameters<T, M, L, A, E>) -> Checked<Self> {
        let zero = T::zero();
        let beginning = JointMotion { time: zero, angle: zero, velocity: zero };
        parameters.motor.at(beginning).check("motor")?;
        parameters.external.at(beginning).check("external")?;
        Named("inertia", parameters.inertia).positive()?;
        Ok(Self { parameters })
    }

    /// The parameters, with the gear as it is.
    pub fn parameters(&self) -> GearedJointParameters<T, M, L, A, E> {
        self.parameters.clone()
    }

    /// Friction of the gear.
    pub fn gear(&self) -> &GearFriction<T, M, L> {
        &self.parameters.gear
    }

    /// Friction of the gear, to set its scales while the joint moves.
    pub fn gear_mut(&mut self) -> &mut GearFriction<T, M, L> {
        &mut self.parameters.gear
    }

    /// The state at rest at an angle \[rad\] with an undeflected bristle.
    pub fn at_rest(&self, angle: T) -> Vector3<T> {
        Vector3::new(angle, T::zero(), T::zero())
    }

    #[inline]
    fn acting(&self, time: T, state: &Vector3<T>) -> JointTorques<T> {
        let motion = JointMotion { time, angle: state[0], velocity: state[1] };
        JointTorques::of(self.parameters.motor.at(motion), self.parameters.external.at(motion))
    }

    /// The torques [N m] on the joint at a time and a state.
    pub fn torques(&self, time: T, state: &Vector3<T>) -> GearTorques<T> {
        self.acting(time, state).loading
    }

    /// The torque [N m] of friction and drag at a time and a state.
    pub fn friction_torque(&self, time: T, state: &Vector3<T>) -> T {
        let (gear, [_, velocity, deflection]) = (self.gear(), <[T; 3]>::from(*state));
        let load = gear.load(self.torques(time, state));
        let friction = gear.contact().response_under(load, velocity, deflection).force;
        friction + gear.drag() * velocity
    }

    /// A step of length h ≥ 0 \[s\] by [`GearFriction::joint_step`].
    ///
    /// # Errors
    ///
    /// Refuses a load that is negative or not finite, as that of torques that are not.
    #[inline]
    pub fn step(&self, state: &JointState<T>, duration: T) -> Checked<JointStep<T>> {
        let GearedJointParameters { gear, inertia, motor, external } = &self.parameters;
        gear.joint_step(*inertia, state, duration, |middle| {
            JointTorques::of(motor.at(middle), external.at(middle))
        })
    }
}

impl<T, M, L, A, E> System<T, 3> for GearedJoint<T, M, L, A, E>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    L: LoadLaw<T>,
    A: JointInput<T>,
    E: JointInput<T>,
{
    #[inline]
    fn rate(&self, time: T, state: &Vector3<T>, [branch]: [Branch; 1]) -> Vector3<T> {
        let (gear, [_, velocity, deflection]) = (self.gear(), <[T; 3]>::from(*state));
        let JointTorques { motor, external, loading } = self.acting(time, state);
        let load = gear.load(loading);
        let friction = gear.contact().response_under(load, branch.of(velocity), deflection);
        let torque = motor.value + external.value - gear.drag() * velocity - friction.force;
        Vector3::new(velocity, torque / self.parameters.inertia, friction.rate)
    }

    #[inline]
    fn sliding_velocities(&self, _time: T, state: &Vector3<T>) -> [T; 1] {
        [state[1]]
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        let GearedJointParameters { motor, external, .. } = &self.parameters;
        let first = motor.next_kink(time, towards);
        external.next_kink(time, first.unwrap_or(towards)).or(first)
    }

    #[inline]
    fn switching_functions(
        &self,
        time: T,
        state: &Vector3<T>,
        [branch]: [Branch; 1],
        tell: &mut dyn FnMut(T),
    ) {
        let (gear, [_, velocity, deflection]) = (self.gear(), <[T; 3]>::from(*state));
        let (contact, sliding) = (gear.contact(), branch.of(velocity));
        // Most models have none, and need no torques.
        if contact.switching_function(sliding, deflection).is_some() {
            let scale = gear.load(self.torques(time, state)) / contact.reference_load();
            let surface = Surface::scaled(sliding, scale);
            contact.model().switching_function(surface, deflection).map(tell);
        }
    }

    fn longest_step(&self) -> Option<T> {
        let GearedJointParameters { motor, external, .. } = &self.parameters;
        let steps = [motor.longest_step(), external.longest_step()];
        steps.into_iter().flatten().reduce(T::smaller)
    }

    /// The deflection at breakaway for angle and deflection, and the speed at which the joint
    /// swings through it on its bristles, both under the reference load.
    fn scales(&self) -> Vector3<T> {
        let contact = self.gear().contact();
        let deflection = contact.model().limits(T::zero()).deflection.unwrap_or_else(|| lit(1e-6));
        let stiffness = contact.reference_load() * contact.model().storage_stiffness();
        let stiffness = stiffness.larger(T::default_epsilon());
        let velocity = (stiffness / self.parameters.inertia).sqrt() * deflection;
        Vector3::new(deflection, velocity, deflection)
    }
}
