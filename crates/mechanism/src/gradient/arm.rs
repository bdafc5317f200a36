//! The adjoint of the step of an arm: its masses and torques depend on where it is.

use core::mem::take;

use super::{ContactAdjoint, Differentiable};
use crate::arm::{Arm, ArmMiddle, KEPT, Room};
use crate::contacts::{ContactState, Step};
use crate::mechanism::Storage;
use crate::rows::Rows;
use crate::step::{check_length, forwards};
use bristle::Scalar;
use bristle::companion::Companion;
use bristle::parameter::Checked;
use bristle::scalar::lit;

/// The derivatives of a loss by the state of an arm: at the end of a step when given, at its
/// beginning afterwards.
#[derive(Debug, PartialEq)]
pub struct ArmAdjoint<'a, T> {
    /// By the angles q.
    pub position: &'a mut [T],
    /// By the angular velocities.
    pub velocity: &'a mut [T],
    /// By the mean accelerations of the step before.
    pub acceleration: &'a mut [T],
    /// By what the contacts keep.
    pub contacts: &'a mut [ContactAdjoint<T>],
}

/// An arm and its contacts at the beginning or at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmState<'a, T: Scalar> {
    /// Angles q \[rad\] of the joints.
    pub position: &'a [T],
    /// Angular velocities [rad/s].
    pub velocity: &'a [T],
    /// Mean accelerations [rad/s²] of the step before.
    pub acceleration: &'a [T],
    /// What the contacts keep.
    pub contacts: &'a [ContactState<T>],
}

/// The derivatives of a loss by what a drive was given and has written, at the middle of a step. A
/// drive that looks at the arm adds its own to those of what it looked at.
#[derive(Debug, PartialEq)]
pub struct ArmMiddleAdjoint<'a, T> {
    /// The middle, with the loads of the step and without torques: give it to the drive again where
    /// the derivatives ask for what it writes.
    pub middle: ArmMiddle<'a, T>,
    /// By the torques of the motors.
    pub torque: &'a [T],
    /// By what the contacts were given: `given_load`.
    pub contacts: &'a [ContactAdjoint<T>],
    /// By the angles: to be added to.
    pub position: &'a mut [T],
    /// By the angular velocities: to be added to.
    pub velocity: &'a mut [T],
    /// By the torques of gravity: to be added to.
    pub gravity: &'a mut [T],
}

impl<T: Scalar, R: Rows<T>, S: Storage<T>> Arm<T, R, S> {
    /// Goes back over a [step](Arm::step), from the states before and after it, as
    /// [`LinearMechanism::pull_back`](crate::LinearMechanism::pull_back) does. `drive_back` adds
    /// the derivatives by what the drive has looked at; one whose torques and loads are of the time
    /// alone has nothing to add.
    ///
    /// # Errors
    ///
    /// Refuses slices of lengths that do not fit; nothing has changed.
    pub fn pull_back<M: Differentiable<T>>(
        &mut self,
        duration: T,
        [before, after]: [ArmState<'_, T>; 2],
        companions: &[Companion<T, M>],
        drive_back: impl FnOnce(ArmMiddleAdjoint<'_, T>),
        adjoint: ArmAdjoint<'_, T>,
        gradient: &mut [T],
    ) -> Checked<()> {
        let ArmAdjoint { position, velocity, acceleration, contacts: by } = adjoint;
        let motion = [before.position, before.velocity, before.acceleration];
        self.check(motion, companions, before.contacts)?;
        self.check([position, velocity, acceleration], companions, after.contacts)?;
        let (n, gravity) = (self.mechanism.coordinates(), self.gravity);
        check_length("accelerations", after.acceleration, n)?;
        self.mechanism.check_gradient(companions, after.contacts, by, gradient)?;
        let duration = forwards(duration);
        let half = lit::<T>(0.5) * duration;
        let (rows, mut parts) = self.mechanism.prepared(duration);
        let mut room = Room::new(take(&mut parts.room), n, by.len());
        room.predict(motion, half, gravity);
        room.assemble(parts.mass, parts.acceleration);
        let step = Step { duration, companions, rows };
        let contacts = [before.contacts, after.contacts];
        let of_motion = [&mut *position, &mut *velocity, &mut *acceleration];
        parts.pull_back(&step, &[], contacts, of_motion, by, gradient);
        room.middle(after.contacts);
        room.pull_back(gravity, [parts.acceleration, after.acceleration], by, drive_back);
        let [by_position, by_velocity, _] = &room.adjoint;
        for i in 0..n {
            let by_middle = by_velocity[i] + half * by_position[i];
            position[i] += by_position[i];
            velocity[i] += by_middle;
            acceleration[i] = half * by_middle;
        }
        Ok(())
    }
}

impl<T: Scalar> Room<'_, T> {
    /// The derivatives by the middle of the step, from y and the accelerations a: those of
    /// yᵀ (τ + g(q) − M(q) a − c(q, v)).
    fn pull_back(
        &mut self,
        gravity: T,
        [y, acceleration]: [&[T]; 2],
        contacts: &[ContactAdjoint<T>],
        drive_back: impl FnOnce(ArmMiddleAdjoint<'_, T>),
    ) {
        let Self { kept, position, velocity, gravity: weight, torque, turned, load, .. } = self;
        let [by_position, by_velocity, by_gravity] = &mut self.adjoint;
        by_position.fill(T::zero());
        by_velocity.fill(T::zero());
        by_gravity.copy_from_slice(y);
        drive_back(ArmMiddleAdjoint {
            middle: ArmMiddle { position, velocity, gravity: weight, torque, load },
            torque: y,
            contacts,
            position: by_position,
            velocity: by_velocity,
            gravity: by_gravity,
        });
        // Absolute angles, in the room of what is done: Y, A, and the derivatives by θ and θ̇.
        let [cosine, sine, rate] = turned;
        let (across, along, by_angle, by_rate) = (weight, torque, position, velocity);
        let mut sums = [T::zero(); 3];
        for i in 0..y.len() {
            let terms = [y[i], acceleration[i], by_gravity[i]];
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
            (across[i], along[i]) = (sums[0], sums[1]);
            by_angle[i] = -sums[2] * gravity * kept[KEPT * i + 1] * cosine[i];
            by_rate[i] = T::zero();
        }
        let two = lit::<T>(2.0);
        for i in 0..y.len() {
            for j in 0..i {
                let factor = kept[KEPT * j] * kept[KEPT * i + 1];
                let c = factor * (cosine[i] * cosine[j] + sine[i] * sine[j]);
                let s = factor * (sine[i] * cosine[j] - cosine[i] * sine[j]);
                let turning = across[i] * rate[j] * rate[j] - across[j] * rate[i] * rate[i];
                let term = c * turning - s * (across[i] * along[j] + across[j] * along[i]);
                by_angle[i] -= term;
                by_angle[j] += term;
                by_rate[j] -= two * s * across[i] * rate[j];
                by_rate[i] += two * s * across[j] * rate[i];
            }
        }
        let mut sums = [T::zero(); 2];
        for i in (0..y.len()).rev() {
            sums = [sums[0] + by_angle[i], sums[1] + by_rate[i]];
            by_position[i] += sums[0];
            by_velocity[i] += sums[1];
        }
    }
}
