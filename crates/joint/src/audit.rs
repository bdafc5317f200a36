//! The audit of a gear: self-locking and efficiency, in closed form.

use core::fmt;

use bristle::number::Number;
use bristle::parameter::{Checked, Named};
use bristle::{Branch, Bristle, Scalar};

use crate::{GearFriction, GearTorques, LoadLaw, TorqueLoad};

/// What a gear under a load p = p0 + |k_m τ_m − k_e τ_e| does in steady motion: fields for
/// programs, and a table when printed. The balances are those of
/// [`GearFriction::driving_torque`] and [`GearFriction::braking_torque`].
///
/// ```
/// use bristle_joint::{GearFriction, GearFrictionParameters, TorqueLoad, TorqueLoadParameters};
/// use bristle::{Dahl, DahlParameters};
///
/// let friction = Dahl::new(DahlParameters { dynamic_coefficient: 0.1, micro_stiffness: 300.0 })?;
/// let load = TorqueLoad::new(TorqueLoadParameters {
///     idle_load: 2.0,
///     motor_share: 1.0,
///     external_share: 0.6,
/// })?;
/// let (reference_load, drag, fastest) = (2.0, 0.05, 5.0);
/// let gear = GearFrictionParameters { friction, load, reference_load, drag, fastest };
/// let gear = GearFriction::new(gear)?;
/// let audit = gear.audit(1.0, 5.0)?;
/// println!("{audit}");
/// assert!(audit.locking < 1.0 && audit.braking_efficiency < audit.driving_efficiency);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// ```text
/// audit of a gear at 1 rad/s and an external torque of 5 N m
/// self-locking        no, moves by itself from 0.21277 N m on; μ_s k_e = 0.06, μ k_e = 0.06
/// driving             6.1667 N m; efficiency 0.81081, at large torques 0.84906
/// being driven        4.0455 N m brake it; efficiency 0.80909, at large torques 0.85455
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearAudit<T> {
    /// Velocity [rad/s].
    pub velocity: T,
    /// External torque [N m], without its sign.
    pub external_torque: T,
    /// Friction coefficient at rest, s μ_s \[–\].
    pub static_coefficient: T,
    /// Friction coefficient at the velocity, s μ(v) \[–\].
    pub coefficient: T,
    /// s μ_s k_e \[–\]. From 1 on no external torque breaks the gear away from rest.
    pub static_locking: T,
    /// s μ(v) k_e \[–\]. From 1 on the gear is self-locking: it stops under every external torque.
    /// A gear that only holds at rest lets go if it creeps or is shaken, because μ falls.
    pub locking: T,
    /// The external torque [N m] from which on the gear moves by itself, s p0 μ_s/(1 − s μ_s k_e);
    /// `None` if it holds at rest.
    pub back_driving_torque: Option<T>,
    /// Motor torque [N m] that drives the gear against the external torque; `None` if it jams.
    pub driving_torque: Option<T>,
    /// |τ_e|/τ_m \[–\] of that; `None` as well.
    pub driving_efficiency: Option<T>,
    /// The limit of the driving efficiency at large torques, (1 − μ k_m)/(1 + μ k_e); zero if the
    /// gear jams.
    pub largest_driving_efficiency: T,
    /// Motor torque [N m] that brakes the gear under the external torque; `None` if friction holds
    /// it.
    pub braking_torque: Option<T>,
    /// |τ_m|/τ_e \[–\] of that; `None` as well.
    pub braking_efficiency: Option<T>,
    /// The limit of the efficiency of being driven at large torques, (1 − μ k_e)/(1 + μ k_m); zero
    /// if friction holds every torque.
    pub largest_braking_efficiency: T,
}

impl<T: Scalar, M: Bristle<T>> GearFriction<T, M, TorqueLoad<T>> {
    /// Self-locking and efficiency of the gear in steady motion at a velocity [rad/s] and under an
    /// external torque [N m], in closed form.
    ///
    /// # Errors
    ///
    /// Refuses a velocity of zero, an external torque that is not positive, and what is not finite.
    pub fn audit(&self, velocity: T, external_torque: T) -> Checked<GearAudit<T>> {
        Named("velocity", velocity.abs()).positive()?;
        Named("external_torque", external_torque).positive()?;
        let (zero, one) = (T::zero(), T::one());
        let direction = Branch::locked(velocity);
        let coefficient = |v| self.friction_scale() * self.model().stationary_coefficient(v).abs();
        let static_coefficient = coefficient(direction.of(zero));
        let mu = coefficient(velocity.into());
        let law = self.law().parameters();
        let (motor, external) = (mu * law.motor_share, mu * law.external_share);
        let static_locking = static_coefficient * law.external_share;
        let slack = one - static_locking;
        let idle = self.law().load(GearTorques { motor: zero, external: zero });
        let driving_torque = self.driving_torque(velocity, external_torque);
        let braking_torque = self.braking_torque(velocity, external_torque);
        Ok(GearAudit {
            velocity,
            external_torque,
            static_coefficient,
            coefficient: mu,
            static_locking,
            locking: external,
            back_driving_torque: (slack > zero).then(|| static_coefficient * idle / slack),
            driving_torque,
            driving_efficiency: driving_torque.map(|torque| external_torque / torque),
            largest_driving_efficiency: zero.larger((one - motor) / (one + external)),
            braking_torque,
            braking_efficiency: braking_torque.map(|torque| torque / external_torque),
            largest_braking_efficiency: zero.larger((one - external) / (one + motor)),
        })
    }
}

/// Width of the first column, as in the audit of a contact.
const NAME: usize = 19;

impl<T: Scalar> fmt::Display for GearAudit<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (velocity, torque) = (Number::of(self.velocity), Number::of(self.external_torque));
        write!(f, "audit of a gear at {velocity:.5} rad/s ")?;
        writeln!(f, "and an external torque of {torque:.5} N m")?;
        write!(f, "{:<NAME$} ", "self-locking")?;
        match self.back_driving_torque {
            Some(from) => write!(f, "no, moves by itself from {:.5} N m on; ", Number::of(from))?,
            None if self.locking >= T::one() => write!(f, "yes: ")?,
            None => write!(f, "AT REST ONLY: ")?,
        }
        let (rest, motion) = (Number::of(self.static_locking), Number::of(self.locking));
        writeln!(f, "μ_s k_e = {rest:.5}, μ k_e = {motion:.5}")?;
        let mut row = |name, torque, efficiency, verb, largest, none| {
            write!(f, "{name:<NAME$} ")?;
            let (Some(torque), Some(efficiency)) = (torque, efficiency) else {
                return writeln!(f, "{none}");
            };
            let [torque, efficiency, largest] = [torque, efficiency, largest].map(Number::of::<T>);
            writeln!(
                f,
                "{torque:.5} N m{verb}; efficiency {efficiency:.5}, at large torques {largest:.5}"
            )
        };
        let (torque, efficiency) = (self.driving_torque, self.driving_efficiency);
        row("driving", torque, efficiency, "", self.largest_driving_efficiency, "JAMS: μ k_m ≥ 1")?;
        let (torque, efficiency) = (self.braking_torque, self.braking_efficiency);
        let (largest, none) = (self.largest_braking_efficiency, "friction holds this torque");
        row("being driven", torque, efficiency, " brake it", largest, none)
    }
}
