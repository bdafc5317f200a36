//! What a wheel needs of its tyre: a source and a damper along it, whatever the tyre does sideways.

use crate::{ExactPatch, Memory, Motion, OfAxes, PatchModel};
use bristle::Scalar;
use bristle::parameter::{Checked, Named, Rule};

/// Romano et al., Table 1: the length of the tyre's contact patch, 0.1 m. Its curve and bristle are
/// in [`bristle::paper`].
pub const TYRE_LENGTH: f64 = 0.1;

/// Romano et al., Table 1: the parameter a of the tyre's exponential pressure, 0.1.
pub const TYRE_PRESSURE_DECAY: f64 = 0.1;

/// A tyre of a [`BrakedWheel`](crate::BrakedWheel): an [`ExactPatch`] that slips along the wheel
/// alone, or a [`CombinedPatch`](crate::CombinedPatch) of two axes, along and across. Pairs are
/// along and across.
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
        solve: impl FnOnce([T; 2]) -> Checked<Option<T>>,
    ) -> Checked<Option<[T; 2]>>;
}

/// Where there are more axes than two, the others do not slip.
impl<T, M, const N: usize, B, V, const A: usize> Tyre<T> for ExactPatch<T, M, N, B, V, A>
where
    T: Scalar,
    M: PatchModel<T, V, A>,
    B: Memory<T, N>,
    V: OfAxes<T, A>,
{
    fn length(&self) -> T {
        self.patch().length()
    }

    fn stored_energy(&self) -> T {
        self.stored_energy()
    }

    fn aligning_moment(&self, slip_velocity: [T; 2]) -> T {
        if A < 2 { T::zero() } else { pair(self.moment(of_pair(slip_velocity)))[1] }
    }

    fn roll(
        &mut self,
        predicted: Motion<[T; 2], T>,
        duration: T,
        solve: impl FnOnce([T; 2]) -> Checked<Option<T>>,
    ) -> Checked<Option<[T; 2]>> {
        let Motion { slip_velocity: [along, across], rolling_speed } = predicted;
        let rule = Rule::Stated("be zero on a tyre of one axis (a PlaneBristle makes one of two)");
        Named("lateral_velocity", across).check(A > 1 || across == T::zero(), rule)?;
        let slip_velocity = of_pair([along, across]);
        let step = self.companion_step(Motion { slip_velocity, rolling_speed }, duration)?;
        let ([bias, _], [damping, _]) = (pair(step.bias()), pair(step.damping()));
        let Some(along) = solve([bias, damping])? else { return Ok(None) };
        Ok(Some(pair(step.commit(of_pair([along, across]))?)))
    }
}

fn of_pair<T: Scalar, V: OfAxes<T, A>, const A: usize>(pair: [T; 2]) -> V {
    let number = |axis: usize| pair.get(axis).copied().unwrap_or_else(T::zero);
    V::of_axes(core::array::from_fn(number))
}

fn pair<T: Scalar, V: OfAxes<T, A>, const A: usize>(vector: V) -> [T; 2] {
    let axes = vector.axes();
    core::array::from_fn(|axis| axes.get(axis).copied().unwrap_or_else(T::zero))
}
