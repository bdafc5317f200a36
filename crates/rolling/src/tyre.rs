//! What a wheel needs of its tyre: a source and a damper along it, whatever the tyre does sideways.

use nalgebra::SVector;

use crate::{CombinedPatch, ExactPatch, Motion, Segment};
use bristle::parameter::{self, ParameterError, Rule};
use bristle::{Bristle, Scalar};
use bristle_plane::PlaneBristle;

/// A tyre of a [`BrakedWheel`](crate::BrakedWheel): an [`ExactPatch`] that slips along the wheel
/// alone, or a [`CombinedPatch`] of two axes, along and across. Pairs are along and across.
pub trait Tyre<T: Scalar> {
    /// Length of the patch \[m\].
    fn length(&self) -> T;

    /// Energy stored in the bristles \[J\].
    fn stored_energy(&self) -> T;

    /// The self-aligning moment [N m] at a slip velocity [m/s].
    fn aligning_moment(&self, slip_velocity: [T; 2]) -> T;

    /// Bias \[N\] and damping [N s/m] of the force along the wheel over a step.
    ///
    /// # Errors
    ///
    /// Refuses what the companion step of the patch refuses, and a slip for which the tyre has no
    /// axis; the tyre is as it was.
    fn source_and_damper(
        &mut self,
        predicted: Motion<[T; 2], T>,
        duration: T,
    ) -> Result<[T; 2], ParameterError>;

    /// A step over which the slip velocity across is the predicted one, and that along follows from
    /// bias and damping by `solve`. Returns the mean forces \[N\].
    ///
    /// # Errors
    ///
    /// Refuses what [`Tyre::source_and_damper`] refuses, and passes on what `solve` refuses; the
    /// tyre is as it was.
    fn roll(
        &mut self,
        predicted: Motion<[T; 2], T>,
        duration: T,
        solve: impl FnOnce([T; 2]) -> Result<T, ParameterError>,
    ) -> Result<[T; 2], ParameterError>;
}

impl<T, M, const N: usize, B> Tyre<T> for ExactPatch<T, M, N, B>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    B: AsRef<[Segment<T, N>]> + AsMut<[Segment<T, N>]>,
{
    fn length(&self) -> T {
        self.patch().length()
    }

    fn stored_energy(&self) -> T {
        self.stored_energy()
    }

    fn aligning_moment(&self, _: [T; 2]) -> T {
        T::zero()
    }

    fn source_and_damper(
        &mut self,
        predicted: Motion<[T; 2], T>,
        duration: T,
    ) -> Result<[T; 2], ParameterError> {
        let step = self.companion_step(straight(predicted)?, duration)?;
        Ok([step.bias(), step.damping()])
    }

    fn roll(
        &mut self,
        predicted: Motion<[T; 2], T>,
        duration: T,
        solve: impl FnOnce([T; 2]) -> Result<T, ParameterError>,
    ) -> Result<[T; 2], ParameterError> {
        let step = self.companion_step(straight(predicted)?, duration)?;
        let slip_velocity = solve([step.bias(), step.damping()])?;
        Ok([step.commit(slip_velocity)?, T::zero()])
    }
}

/// The motion of a tyre of one axis, which has no lateral friction.
fn straight<T: Scalar>(motion: Motion<[T; 2], T>) -> Result<Motion<T>, ParameterError> {
    let Motion { slip_velocity: [along, across], rolling_speed } = motion;
    let rule = Rule::Stated("be zero on a tyre of one axis (Patch::combined makes one of two)");
    parameter::check("lateral_velocity", across, across == T::zero(), rule)?;
    Ok(Motion { slip_velocity: along, rolling_speed })
}

impl<T, M, const N: usize, B> Tyre<T> for CombinedPatch<T, M, 2, N, B>
where
    T: Scalar,
    M: PlaneBristle<T, 2>,
    B: AsRef<[Segment<T, N>]> + AsMut<[Segment<T, N>]>,
{
    fn length(&self) -> T {
        self.patch().length()
    }

    fn stored_energy(&self) -> T {
        self.stored_energy()
    }

    fn aligning_moment(&self, slip_velocity: [T; 2]) -> T {
        self.moment(&slip_velocity.into())[1]
    }

    fn source_and_damper(
        &mut self,
        predicted: Motion<[T; 2], T>,
        duration: T,
    ) -> Result<[T; 2], ParameterError> {
        let step = self.companion_step(combined(predicted), duration)?;
        Ok([step.bias()[0], step.damping()[0]])
    }

    fn roll(
        &mut self,
        predicted: Motion<[T; 2], T>,
        duration: T,
        solve: impl FnOnce([T; 2]) -> Result<T, ParameterError>,
    ) -> Result<[T; 2], ParameterError> {
        let across = predicted.slip_velocity[1];
        let step = self.companion_step(combined(predicted), duration)?;
        let along = solve([step.bias()[0], step.damping()[0]])?;
        Ok(step.commit(&[along, across].into())?.into())
    }
}

fn combined<T: Scalar>(motion: Motion<[T; 2], T>) -> Motion<SVector<T, 2>, T> {
    Motion { slip_velocity: motion.slip_velocity.into(), rolling_speed: motion.rolling_speed }
}
