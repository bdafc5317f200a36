//! Static compensation: a friction curve and a sign, the baseline of the literature.
//!
//! u = s p μ(v) d(v)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | v | a measured, filtered or reference velocity | m/s |
//! | μ | friction curve | – |
//! | d | direction: a sign with a dead band, or a smooth sign | – |
//! | p, s | normal force, share | N, – |
//! | u | force that is given out | N |
//!
//! Around zero velocity, friction is not a function of the velocity: a stuck contact carries any
//! force up to breakaway. A sign has to choose one. It therefore switches the whole friction with
//! the noise, or, with a dead band, gives nothing while the mechanism sticks.
//!
//! Source: B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30 (1994), 1083–1138.

use super::output::{Compensation, Output, OutputParameters};
use crate::curve::FrictionCurve;
use crate::parameter::{self, ParameterError};
use crate::{Scalar, Sliding};

/// What stands for the sign of the velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DirectionLaw<T> {
    /// sgn v, and zero for |v| up to the half width \[m/s\] of the band.
    DeadBand(T),
    /// tanh(v/v_t), with v_t \[m/s\] positive.
    Smooth(T),
}

/// Parameters of a [`StaticCompensator`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticParameters<T, C> {
    /// Friction curve μ(v).
    pub curve: C,
    /// Normal force p \[N\], zero or positive.
    pub normal_force: T,
    /// What stands for the sign.
    pub direction: DirectionLaw<T>,
    /// Share and limit.
    pub output: OutputParameters<T>,
}

/// Compensation of a friction curve by the sign of a velocity.
///
/// ```
/// use bristle::control::{DirectionLaw, OutputParameters, StaticCompensator, StaticParameters};
/// use bristle::curve::{Coulomb, CoulombParameters};
///
/// let mut compensator = StaticCompensator::new(StaticParameters {
///     curve: Coulomb::new(CoulombParameters { dynamic_coefficient: 0.5, viscous_friction: 0.0 })?,
///     normal_force: 20.0,
///     direction: DirectionLaw::DeadBand(1e-4),
///     output: OutputParameters { share: 0.8, largest_force: 15.0 },
/// })?;
/// assert_eq!(compensator.step(-0.01).force, -8.0);
/// assert_eq!(compensator.step(5e-5).force, 0.0);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticCompensator<T, C> {
    curve: C,
    normal_force: T,
    direction: DirectionLaw<T>,
    output: Output<T>,
}

impl<T: Scalar, C: FrictionCurve<T>> StaticCompensator<T, C> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a normal force, a dead band or a share that is negative or not finite, and a width
    /// of the smooth sign or a largest force that is not positive.
    pub fn new(parameters: StaticParameters<T, C>) -> Result<Self, ParameterError> {
        let StaticParameters { curve, normal_force, direction, output } = parameters;
        match direction {
            DirectionLaw::DeadBand(width) => parameter::non_negative("dead band width", width)?,
            DirectionLaw::Smooth(width) => parameter::positive("smooth width", width)?,
        };
        Ok(Self {
            normal_force: parameter::non_negative("normal_force", normal_force)?,
            output: Output::new(output)?,
            curve,
            direction,
        })
    }

    /// The force for the coming sample, from a velocity [m/s]. Rejects only non-finite velocities.
    #[inline]
    pub fn step(&mut self, velocity: T) -> Compensation<T> {
        if !velocity.is_finite() {
            return self.output.refuse();
        }
        let sliding = Sliding::from(velocity);
        let direction = match self.direction {
            DirectionLaw::DeadBand(width) if sliding.speed() > width => sliding.direction(),
            DirectionLaw::DeadBand(_) => T::zero(),
            DirectionLaw::Smooth(width) => (velocity / width).tanh(),
        };
        let force = self.normal_force * self.curve.coefficient(sliding) * direction;
        self.output.answer(force, T::zero())
    }

    /// Back to the beginning. Only the last answer is forgotten: there is no other state.
    pub fn reset(&mut self) {
        self.output.reset();
    }
}
