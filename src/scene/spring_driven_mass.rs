//! A mass pulled by a spring whose end moves steadily, the classical stick-slip rig:
//! ẋ = v, m v̇ = k (y − x) − F with y = v_ref t.
//!
//! Source: Romano et al. (arXiv 2602.09429), section V-A.

use nalgebra::Vector3;

use super::{DEFLECTION, Moving, POSITION, VELOCITY, typical_deflection, typical_force};
use crate::bounds::larger;
use crate::linear::{LinearisationError, MassOnSpring, MassOnSpringParameters, SteadySliding};
use crate::ode::{Linearisation, System};
use crate::parameter::{self, ParameterError};
use crate::stability::Mechanism;
use crate::{Branch, Bristle, Contact, Scalar};

/// Parameters of [`SpringDrivenMass`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpringDrivenMassParameters<T, M> {
    /// Friction under its normal force.
    pub contact: Contact<T, M>,
    /// Mass m \[kg\], positive.
    pub mass: T,
    /// Spring stiffness k [N/m], positive.
    pub spring_stiffness: T,
    /// Velocity v_ref [m/s] of the spring's far end, which starts at y = 0.
    pub drive_velocity: T,
}

/// A mass pulled by a spring whose end moves steadily. States: position \[m\], velocity [m/s],
/// deflection \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpringDrivenMass<T, M> {
    contact: Contact<T, M>,
    inverse_mass: T,
    spring_stiffness: T,
    drive_velocity: T,
}

impl<T: Scalar, M: Bristle<T, Deflection = T>> SpringDrivenMass<T, M> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range.
    pub fn new(parameters: SpringDrivenMassParameters<T, M>) -> Result<Self, ParameterError> {
        let SpringDrivenMassParameters { contact, mass, spring_stiffness, drive_velocity } =
            parameters;
        Ok(Self {
            contact,
            inverse_mass: T::one() / parameter::positive("mass", mass)?,
            spring_stiffness: parameter::positive("spring_stiffness", spring_stiffness)?,
            drive_velocity: parameter::finite("drive_velocity", drive_velocity)?,
        })
    }

    /// The state at rest at the origin, the bristle undeflected.
    pub fn at_rest(&self) -> Vector3<T> {
        Vector3::zeros()
    }

    /// The friction force \[N\] at a state.
    pub fn friction_force(&self, state: &Vector3<T>) -> T {
        self.contact.force(state[VELOCITY], state[DEFLECTION])
    }

    /// The force \[N\] of the spring on the mass.
    pub fn spring_force(&self, time: T, state: &Vector3<T>) -> T {
        self.spring_stiffness * (self.drive_velocity * time - state[POSITION])
    }

    /// Steady sliding at the drive velocity, and the small motions about it: stick-slip if they grow.
    ///
    /// In the state of the scene the mass is then at x = y − stretch.
    ///
    /// # Errors
    ///
    /// As for [`MassOnSpring::steady_sliding`].
    pub fn steady_sliding(&self) -> Result<SteadySliding<T>, LinearisationError> {
        let mechanism = Mechanism {
            mass: T::one() / self.inverse_mass,
            spring_stiffness: self.spring_stiffness,
            viscous_damping: T::zero(),
        };
        let contact = self.contact.clone();
        let rig = MassOnSpring::new(MassOnSpringParameters { contact, mechanism })?;
        rig.steady_sliding(self.drive_velocity)
    }

    /// A typical magnitude of each state, for tolerances: the spring's stretch at breakaway, the
    /// drive velocity or the one that stretch can give, whichever is larger, the bristle's
    /// deflection at breakaway.
    pub fn scales(&self) -> Vector3<T> {
        let stretch = typical_force(&self.contact) / self.spring_stiffness;
        let released = stretch * (self.spring_stiffness * self.inverse_mass).sqrt();
        Vector3::new(
            stretch,
            larger(self.drive_velocity.abs(), released),
            typical_deflection(&self.contact),
        )
    }
}

impl<T: Scalar, M: Bristle<T, Deflection = T>> System<T, 3> for SpringDrivenMass<T, M> {
    #[inline]
    fn rate(&self, time: T, state: &Vector3<T>, [branch]: [Branch; 1]) -> Vector3<T> {
        let velocity = state[VELOCITY];
        let friction = self.contact.response(branch.of(velocity), state[DEFLECTION]);
        let force = self.spring_force(time, state) - friction.force;
        Vector3::new(velocity, force * self.inverse_mass, friction.rate)
    }

    #[inline]
    fn sliding_velocities(&self, _time: T, state: &Vector3<T>) -> [T; 1] {
        [state[VELOCITY]]
    }

    #[inline]
    fn linearised(
        &self,
        time: T,
        state: &Vector3<T>,
        [branch]: [Branch; 1],
    ) -> Option<Linearisation<T, 3>> {
        let sliding = branch.of(state[VELOCITY]);
        let Moving { mut rate, mut by_state } =
            Moving::new(&self.contact, sliding, state[DEFLECTION], self.inverse_mass);
        let stiffness = self.spring_stiffness * self.inverse_mass;
        rate[VELOCITY] += self.spring_force(time, state) * self.inverse_mass;
        by_state[(VELOCITY, POSITION)] = -stiffness;
        let by_time = Vector3::new(T::zero(), stiffness * self.drive_velocity, T::zero());
        Some(Linearisation { rate, by_state, by_time })
    }

    fn scales(&self) -> Vector3<T> {
        SpringDrivenMass::scales(self)
    }
}
