//! What a wheel needs of its tyre: a source and a damper along it, whatever the tyre does sideways.

use crate::{CombinedPatch, ExactPatch, Memory, Motion};
use bristle::parameter::{Named, ParameterError, Rule};
use bristle::{Bristle, Scalar};
use bristle_plane::PlaneBristle;

/// Romano et al., Table 1: the length of the tyre's contact patch, 0.1 m. Its curve and bristle are
/// in [`bristle::paper`].
pub const TYRE_LENGTH: f64 = 0.1;

/// Romano et al., Table 1: the parameter a of the tyre's exponential pressure, 0.1.
pub const TYRE_PRESSURE_DECAY: f64 = 0.1;

/// A tyre of a [`BrakedWheel`](crate::BrakedWheel): an [`ExactPatch`] that slips along the wheel
/// alone, or a [`CombinedPatch`] of two axes, along and across. Pairs are along and across.
pub trait Tyre<T: Scalar> {
    /// Length of the patch \[m\].
    fn length(&self) -> T;

    /// Energy stored in the bristles \[J\].
    fn stored_energy(&self) -> T;

    /// The self-aligning moment [N m] at a slip velocity [m/s].
    fn aligning_moment(&self, slip_velocity: [T; 2]) -> T;

    /// A step over which the slip velocity across is the predicted one, and that along is what
    /// `solve` makes of bias \[N\] and damping [N s/m] of the force along the wheel. Returns the
    /// mean forces \[N\]. If `solve` answers with none, there is no step.
    ///
    /// # Errors
    ///
    /// Refuses what the companion step of the patch refuses, and a slip for which the tyre has no
    /// axis, and passes on what `solve` refuses; the tyre is as it was.
    fn roll(
        &mut self,
        predicted: Motion<[T; 2], T>,
        duration: T,
        solve: impl FnOnce([T; 2]) -> Result<Option<T>, ParameterError>,
    ) -> Result<Option<[T; 2]>, ParameterError>;
}

impl<T: Scalar, M: Bristle<T, Deflection = T>, const N: usize, B: Memory<T, N>> Tyre<T>
    for ExactPatch<T, M, N, B>
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

    fn roll(
        &mut self,
        predicted: Motion<[T; 2], T>,
        duration: T,
        solve: impl FnOnce([T; 2]) -> Result<Option<T>, ParameterError>,
    ) -> Result<Option<[T; 2]>, ParameterError> {
        let Motion { slip_velocity: [along, across], rolling_speed } = predicted;
        let rule = Rule::Stated("be zero on a tyre of one axis (Patch::combined makes one of two)");
        Named("lateral_velocity", across).check(across == T::zero(), rule)?;
        let step = self.companion_step(Motion { slip_velocity: along, rolling_speed }, duration)?;
        let Some(along) = solve([step.bias(), step.damping()])? else { return Ok(None) };
        Ok(Some([step.commit(along)?, T::zero()]))
    }
}

impl<T: Scalar, M: PlaneBristle<T, 2>, const N: usize, B: Memory<T, N>> Tyre<T>
    for CombinedPatch<T, M, 2, N, B>
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

    fn roll(
        &mut self,
        predicted: Motion<[T; 2], T>,
        duration: T,
        solve: impl FnOnce([T; 2]) -> Result<Option<T>, ParameterError>,
    ) -> Result<Option<[T; 2]>, ParameterError> {
        let Motion { slip_velocity, rolling_speed } = predicted;
        let predicted = Motion { slip_velocity: slip_velocity.into(), rolling_speed };
        let step = self.companion_step(predicted, duration)?;
        let Some(along) = solve([step.bias()[0], step.damping()[0]])? else { return Ok(None) };
        Ok(Some(step.commit(&[along, slip_velocity[1]].into())?.into()))
    }
}
