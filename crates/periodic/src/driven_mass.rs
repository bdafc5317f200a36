//! A mass on a spring whose far end moves steadily, in coordinates that repeat.
//!
//! ė = V − v,  m v̇ = k e − c v − F(v, z),  ż = h(v, z)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | e | stretch of the spring | m |
//! | v, z | velocity of the mass, deflection of the bristle | m/s, m |
//! | V | velocity of the spring's far end | m/s |
//! | m, k, c | mass, spring stiffness, viscous damping | kg, N/m, N s/m |
//!
//! It is the stick-slip rig of Romano et al. (arXiv 2602.09429), section V-A, with the stretch
//! V t − x in place of the position x, which does not repeat. A mass on a belt, held by a spring on
//! the ground, moves alike, with v the sliding velocity and c = 0.

use bristle::ode::{Linearisation, System};
use bristle::parameter::{Checked, Named};
use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
use bristle::{Branch, Bristle, Contact, Mechanism};
use nalgebra::Vector3;

/// A mass on a spring whose far end moves steadily. States: stretch \[m\], velocity [m/s],
/// deflection \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivenMass<M> {
    scene: MassSpringDamper<f64, M>,
    drive_velocity: f64,
}

impl<M: Bristle<f64, Deflection = f64>> DrivenMass<M> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a mechanism without a spring or out of range, and a velocity V [m/s] that is not
    /// finite.
    pub fn new(
        contact: Contact<f64, M>,
        mechanism: Mechanism<f64>,
        drive_velocity: f64,
    ) -> Checked<Self> {
        Named("spring_stiffness", mechanism.spring_stiffness).positive()?;
        let parameters =
            MassSpringDamperParameters { contact, mechanism, drive_velocity, force: 0.0 };
        Ok(Self { scene: MassSpringDamper::new(parameters)?, drive_velocity })
    }

    /// The state at rest with a relaxed spring and an undeflected bristle.
    pub fn at_rest(&self) -> Vector3<f64> {
        Vector3::zeros()
    }
}

/// The scene at time zero, where x = −e.
fn place(state: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(-state[0], state[1], state[2])
}

impl<M: Bristle<f64, Deflection = f64>> System<f64, 3> for DrivenMass<M> {
    #[inline]
    fn rate(&self, _: f64, state: &Vector3<f64>, branches: [Branch; 1]) -> Vector3<f64> {
        let mut rate = self.scene.rate(0.0, &place(state), branches);
        rate[0] = self.drive_velocity - rate[0];
        rate
    }

    fn sliding_velocities(&self, _: f64, state: &Vector3<f64>) -> [f64; 1] {
        [state[1]]
    }

    fn linearised(
        &self,
        _: f64,
        state: &Vector3<f64>,
        branches: [Branch; 1],
    ) -> Option<Linearisation<f64, 3>> {
        let mut linearised = self.scene.linearised(0.0, &place(state), branches)?;
        linearised.rate[0] = self.drive_velocity - linearised.rate[0];
        // Row and column of the stretch have the other sign.
        for i in 1..3 {
            linearised.by_state[(0, i)] *= -1.0;
            linearised.by_state[(i, 0)] *= -1.0;
        }
        linearised.by_time = Vector3::zeros();
        Some(linearised)
    }

    #[inline]
    fn switching_functions(
        &self,
        _: f64,
        x: &Vector3<f64>,
        branches: [Branch; 1],
        tell: &mut dyn FnMut(f64),
    ) {
        self.scene.switching_functions(0.0, &place(x), branches, tell);
    }

    fn scales(&self) -> Vector3<f64> {
        self.scene.scales()
    }
}
