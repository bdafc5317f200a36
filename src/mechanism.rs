//! A mass with a spring and a damper, without its friction.

use crate::parameter::{Checked, Named};
use crate::scalar::Scalar;

/// A mass with a spring and a damper, without its friction: what a contact holds or brakes.
///
/// m ẍ + c ẋ + k x = other forces, with the position x \[m\]. Moments of inertia, angles and
/// torques serve as well. A spring stiffness of zero is no spring, a damping of zero no damper.
///
/// [`MassSpringDamper`](crate::scene::MassSpringDamper) simulates it under friction; the crate
/// bristle-analysis analyses it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Mechanism<T> {
    /// Mass m \[kg\], positive.
    pub mass: T,
    /// Stiffness k [N/m] of the spring to the ground or to a driven point, zero or positive.
    pub spring_stiffness: T,
    /// Viscous damping c [N s/m] in addition to the friction, zero or positive.
    pub viscous_damping: T,
}

impl<T: Scalar> Mechanism<T> {
    /// Returns the mechanism if every parameter is in its range.
    pub fn checked(self) -> Checked<Self> {
        Ok(Self {
            mass: Named("mass", self.mass).positive()?,
            spring_stiffness: Named("spring_stiffness", self.spring_stiffness).non_negative()?,
            viscous_damping: Named("viscous_damping", self.viscous_damping).non_negative()?,
        })
    }
}
