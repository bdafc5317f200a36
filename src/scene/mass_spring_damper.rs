//! A mass with a spring, a damper and friction, pulled by the spring and by a force.
//!
//! ẋ = v,  m v̇ = f(t) + k (V t − x) − c v − F(v, z),  ż = h(v, z)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x, v | position and velocity of the mass | m, m/s |
//! | z | deflection of the bristle | m |
//! | m, k, c | mass, spring stiffness, viscous damping | kg, N/m, N s/m |
//! | V | velocity of the spring's far end, which starts at the origin | m/s |
//! | f | applied force | N |
//! | F | friction force | N |
//!
//! With f = 0 and c = 0 it is the stick-slip rig of Romano et al. (arXiv 2602.09429), section V-A;
//! with k = 0 it is a mass under a given force.

use nalgebra::Vector3;

use super::{Body, POSITION, VELOCITY};
use crate::ode::{Linearisation, System};
use crate::parameter::{Checked, Named};
use crate::scalar::is_zero;
use crate::signal::Signal;
use crate::{Branch, Bristle, Contact, Mechanism, Scalar};

/// Parameters of [`MassSpringDamper`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct MassSpringDamperParameters<T: Scalar, M, F = T> {
    /// Friction under its normal force.
    pub contact: Contact<T, M>,
    /// Mass, spring and damper; the spring and the damper may be absent (zero).
    pub mechanism: Mechanism<T>,
    /// Velocity V [m/s] of the spring's far end; zero for a spring fixed to the ground.
    pub drive_velocity: T,
    /// Applied force f(t) \[N\]; a number for a constant one, 0 for none.
    pub force: F,
}

/// A mass with a spring, a damper and friction, pulled by the spring and by a force.
///
/// States: position x \[m\], velocity v [m/s], deflection z \[m\].
///
/// ```
/// use bristle::ode::{self, Output};
/// use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
/// use bristle::{Bristle, Dahl, DahlParameters, Mechanism};
///
/// let friction = Dahl::new(DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 5e3 })?;
/// let block = MassSpringDamper::new(MassSpringDamperParameters {
///     contact: friction.under_load(10.0)?, // N
///     mechanism: Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 },
///     drive_velocity: 0.0,
///     force: 7.0, // N
/// })?;
/// let run = ode::solve(&block, 0.0..1.0, block.at_rest(), 1e-6, Output::Uniform(11))?;
/// // Sliding friction is 5 N: the block gains 0.2 m/s in each tenth of a second.
/// let gained: f64 = run.states()[10][1] - run.states()[9][1];
/// assert!((gained - 0.2).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassSpringDamper<T: Scalar, M, F = T> {
    parameters: MassSpringDamperParameters<T, M, F>,
    inverse_mass: T,
}

impl<T: Scalar, M: Bristle<T, Deflection = T>, F: Signal<T>> MassSpringDamper<T, M, F> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Names the parameter that is out of its range; the force is checked at time zero.
    pub fn new(parameters: MassSpringDamperParameters<T, M, F>) -> Checked<Self> {
        Named("force", parameters.force.value(T::zero())).finite()?;
        let mechanism = parameters.mechanism.checked()?;
        Named("drive_velocity", parameters.drive_velocity).finite()?;
        let parameters = MassSpringDamperParameters { mechanism, ..parameters };
        Ok(Self { parameters, inverse_mass: T::one() / mechanism.mass })
    }

    #[inline(always)]
    fn body(&self) -> Body<'_, T, M> {
        let MassSpringDamperParameters { contact, mechanism, .. } = &self.parameters;
        Body { contact, mechanism: *mechanism, inverse_mass: self.inverse_mass }
    }

    /// The parameters, as they were given.
    pub fn parameters(&self) -> &MassSpringDamperParameters<T, M, F> {
        &self.parameters
    }

    /// The state at rest at the origin with an undeflected bristle.
    pub fn at_rest(&self) -> Vector3<T> {
        Vector3::zeros()
    }

    /// The friction force F \[N\] at a state.
    pub fn friction_force(&self, state: &Vector3<T>) -> T {
        self.body().friction_force(state)
    }

    /// The force k (V t − x) \[N\] of the spring on the mass.
    #[inline]
    pub fn spring_force(&self, time: T, state: &Vector3<T>) -> T {
        self.parameters.mechanism.spring_stiffness
            * (self.parameters.drive_velocity * time - state[POSITION])
    }

    /// A typical magnitude of each state, for tolerances.
    ///
    /// Deflection: at breakaway. Position: the stretch of the spring at breakaway, without a spring
    /// the deflection. Velocity: what the mass reaches when that stretch is released, or the drive
    /// velocity if that is larger.
    pub fn scales(&self) -> Vector3<T> {
        let deflection = self.body().breakaway_deflection();
        let stiffness = self.parameters.mechanism.spring_stiffness;
        if is_zero(stiffness) {
            return Vector3::new(deflection, self.body().bristle_velocity(), deflection);
        }
        let stretch = self.body().breakaway_force() / stiffness;
        let released = stretch * (stiffness * self.inverse_mass).sqrt();
        Vector3::new(stretch, self.parameters.drive_velocity.abs().larger(released), deflection)
    }
}

impl<T, M, F> System<T, 3> for MassSpringDamper<T, M, F>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    F: Signal<T>,
{
    #[inline]
    fn rate(&self, time: T, state: &Vector3<T>, [branch]: [Branch; 1]) -> Vector3<T> {
        let force = self.parameters.force.value(time) + self.spring_force(time, state);
        self.body().rate(force, state, branch)
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
        let (force, force_rate) = self.parameters.force.value_and_rate(time);
        let force = force + self.spring_force(time, state);
        let mut linearised = self.body().linearised(force, state, branch);
        let stiffness = self.parameters.mechanism.spring_stiffness * self.inverse_mass;
        linearised.by_time[VELOCITY] =
            force_rate * self.inverse_mass + stiffness * self.parameters.drive_velocity;
        Some(linearised)
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        self.parameters.force.next_kink(time, towards)
    }

    #[inline]
    fn switching_functions(
        &self,
        _time: T,
        state: &Vector3<T>,
        [branch]: [Branch; 1],
        tell: &mut dyn FnMut(T),
    ) {
        self.body().switching_function(state, branch).map(tell);
    }

    fn longest_step(&self) -> Option<T> {
        self.parameters.force.longest_step()
    }

    fn scales(&self) -> Vector3<T> {
        MassSpringDamper::scales(self)
    }
}
