//! The exact reduction in combined slip: each axis a patch of one axis, whose model is frozen at
//! the slip velocity of the step.
//!
//! With v ∈ ℝᴬ and V held over a step all bristles of axis i share λᵢ and rᵢ vᵢ, so that each axis
//! is reduced exactly as a patch of one axis is. Over a step inside a mechanism each axis is a
//! source and a damper, F̄ᵢ = biasᵢ + dampingᵢ v̄ᵢ, with an energy balance of its own.

use nalgebra::SVector;

use super::coupling::Coupling;
use super::queue::Queue;
use super::{Memory, PatchLedger, slipped};
use crate::combined::{axes_of, finite};
use crate::patch::Frozen;
use crate::{Motion, Patch, PolynomialExponential};
use bristle::parameter::{Named, ParameterError};
use bristle::scalar::is_zero;
use bristle::{Affine, Reloaded, Scalar};
use bristle_plane::PlaneBristle;

/// A patch in motion in combined slip, without a grid: [`ExactPatch`](super::ExactPatch) with a
/// vector for the slip velocity and the force. Memory, merging, accuracy and time are those of
/// `ExactPatch` on each of the A axes.
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::nalgebra::Vector2;
/// use bristle::paper;
/// use bristle_plane::PlaneFrBd;
/// use bristle::rheology::KelvinVoigt;
/// use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential, Segment};
///
/// let curve = Stribeck::new(paper::TYRE_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
/// let tyre = Patch::new(PatchParameters {
///     model: PlaneFrBd::isotropic(curve, bristle),
///     length: bristle_rolling::TYRE_LENGTH,
///     pressure: PolynomialExponential::parabolic().padded::<4>(), // for the moment
/// })?
/// .under_load(4000.0)?; // N
///
/// let mut rolling = tyre.combined([[Segment::default(); 200]; 2])?;
/// let mut force = Vector2::zeros();
/// for millisecond in 0..100 {
///     // Braking, with a slip angle that grows.
///     let slip_velocity = Vector2::new(0.8, 0.01 * f64::from(millisecond)); // m/s
///     force = rolling.step(Motion { slip_velocity, rolling_speed: 16.0 }, 1e-3)?;
/// }
/// let aligning = rolling.moment(&Vector2::new(0.8, 0.99)).y; // N m
/// assert!(force.x > 800.0 && force.y > 1000.0 && aligning > 0.0);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone)]
pub struct CombinedPatch<T, M, const A: usize, const N: usize, B> {
    patch: Patch<T, M, PolynomialExponential<T, N>>,
    queues: [Queue<T, N, B>; A],
}

/// Friction of a patch over one step in combined slip, F̄ᵢ = biasᵢ + dampingᵢ v̄ᵢ.
///
/// Made by [`CombinedPatch::companion_step`]; what [`PatchStep`](super::PatchStep) says holds on
/// each axis.
#[derive(Debug)]
#[must_use = "the bristles move when it is committed"]
pub struct CombinedStep<'a, T: Scalar, M, const A: usize, const N: usize, B> {
    rolling: &'a mut CombinedPatch<T, M, A, N, B>,
    couplings: [Coupling<T>; A],
}

impl<T: Scalar, M, const N: usize> Patch<T, M, PolynomialExponential<T, N>> {
    /// The patch in motion in combined slip, with undeflected bristles, in memory that the caller
    /// provides for each axis: see [`Patch::exact`].
    ///
    /// # Errors
    ///
    /// Refuses fewer than 22 segments.
    pub fn combined<B, const A: usize>(
        self,
        segments: [B; A],
    ) -> Result<CombinedPatch<T, M, A, N, B>, ParameterError>
    where
        M: PlaneBristle<T, A>,
        B: Memory<T, N>,
    {
        for memory in &segments {
            Named("segments", memory.as_ref().len()).count(Queue::<T, N, B>::LEAST)?;
        }
        let decay = self.pressure().decay();
        let queues = segments.map(|memory| Queue::new(memory, decay));
        Ok(CombinedPatch { patch: self, queues })
    }

    /// The patch in motion in combined slip, with undeflected bristles and memory for steps of
    /// V h ≥ 1/`segments`: see [`Patch::exact_in`].
    ///
    /// # Errors
    ///
    /// Refuses fewer than 8 segments and more than ten million.
    #[cfg(feature = "alloc")]
    pub fn combined_in<const A: usize>(
        self,
        segments: usize,
    ) -> Result<CombinedPatch<T, M, A, N, alloc::vec::Vec<super::Segment<T, N>>>, ParameterError>
    where
        M: PlaneBristle<T, A>,
    {
        let memory = super::memory(segments)?;
        self.combined(core::array::from_fn(|_| memory.clone()))
    }
}

impl<T: Scalar, M: PlaneBristle<T, A>, const A: usize, const N: usize, B: Memory<T, N>>
    CombinedPatch<T, M, A, N, B>
{
    /// The patch.
    pub fn patch(&self) -> &Patch<T, M, PolynomialExponential<T, N>> {
        &self.patch
    }

    /// The deflections z \[m\] at a place ξ between 0 and 1, NaN elsewhere. The time is
    /// proportional to the number of segments.
    pub fn deflection(&self, place: T) -> SVector<T, A> {
        SVector::from_fn(|i, _| self.queues[i].deflection(place))
    }

    /// Changes the normal force F_z \[N\], zero or positive, before a step with a slip velocity
    /// [m/s]: [`ExactPatch::reload`](super::ExactPatch::reload) with a vector.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite, and a positive one on a patch without
    /// a reference load; the patch is as it was.
    pub fn reload(
        &mut self,
        normal_force: T,
        slip_velocity: &SVector<T, A>,
    ) -> Result<Reloaded<T, ()>, ParameterError> {
        let change = self.patch.change_load(normal_force)?;
        if change.after >= change.before {
            return Ok(Reloaded { deflection: (), dissipated: T::zero() });
        }
        // No bristle is deflected by more on any axis.
        let most = SVector::from_fn(|i, _| {
            let (low, high) = self.queues[i].range();
            (-low).larger(high)
        });
        let limits = self.patch.model().limits(slip_velocity.norm());
        let kept = if is_zero(normal_force) {
            T::zero()
        } else {
            change.kept(limits.utilisation(&most, self.patch.contact().friction_scale()))
        };
        let dissipated = slipped(self.stored_energy(), kept);
        self.queues.iter_mut().for_each(|queue| queue.scale(kept));
        Ok(Reloaded { deflection: (), dissipated })
    }

    /// Changes the normal force by renewal: [`ExactPatch::renew`](super::ExactPatch::renew).
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite; the patch is as it was.
    pub fn renew(&mut self, normal_force: T) -> Result<Reloaded<T, ()>, ParameterError> {
        let stored = self.stored_energy();
        let (kept, lost) = self.patch.renew_load(normal_force)?.renewed();
        self.queues.iter_mut().for_each(|queue| queue.scale(kept));
        Ok(Reloaded { deflection: (), dissipated: lost * stored })
    }

    /// Takes all bristles to the profile of steady rolling.
    ///
    /// # Errors
    ///
    /// Refuses a motion that is not finite or runs backwards; the patch is as it was.
    pub fn settle(&mut self, motion: Motion<SVector<T, A>, T>) -> Result<(), ParameterError> {
        let all = self.frozen(motion)?;
        self.queues.iter_mut().zip(&all).for_each(|(queue, frozen)| queue.settle(frozen));
        Ok(())
    }

    /// Rolls on for a time h ≥ 0 \[s\] with a motion held, and returns the friction force F \[N\]
    /// at the end. Of a motion that varies take that at the middle of the step: second order.
    ///
    /// # Errors
    ///
    /// Refuses a velocity that is not finite, a rolling speed or a duration that is negative, and a
    /// velocity at which a coefficient of the model is not finite; the patch is as it was.
    #[inline]
    pub fn step(
        &mut self,
        motion: Motion<SVector<T, A>, T>,
        duration: T,
    ) -> Result<SVector<T, A>, ParameterError> {
        let duration = Named("duration", duration).non_negative()?;
        let all = self.frozen(motion)?;
        let Self { patch, queues } = self;
        Ok(SVector::from_fn(|i, _| patch.step_in(&mut queues[i], &all[i], duration)))
    }

    /// The friction force \[N\] at a slip velocity [m/s], with the bristles as they are.
    pub fn force(&self, slip_velocity: &SVector<T, A>) -> SVector<T, A> {
        self.each(slip_velocity, Patch::force_of)
    }

    /// The moment of each axis's force about the middle of the patch \[N m\]: that of the lateral
    /// axis is the self-aligning moment M_z. See [`ExactPatch::moment`](super::ExactPatch::moment).
    pub fn moment(&self, slip_velocity: &SVector<T, A>) -> SVector<T, A> {
        self.each(slip_velocity, Patch::moment_of)
    }

    /// The energy stored in the bristles \[J\], see
    /// [`ExactPatch::stored_energy`](super::ExactPatch::stored_energy).
    pub fn stored_energy(&self) -> T {
        let stiffness = self.patch.model().storage_stiffness();
        let axes = self.queues.iter().zip(&stiffness);
        axes.fold(T::zero(), |sum, (queue, &k)| sum + self.patch.stored_in(queue, k))
    }

    /// The sources and the dampers that stand for the patch over a step of length h ≥ 0 \[s\], from
    /// a motion predicted for its middle:
    /// [`ExactPatch::companion_step`](super::ExactPatch::companion_step) with a vector.
    ///
    /// # Errors
    ///
    /// Refuses a velocity that is not finite, a rolling speed or a duration that is negative, and
    /// what gives a bias or a damping that is not finite; the patch is as it was.
    pub fn companion_step(
        &mut self,
        predicted: Motion<SVector<T, A>, T>,
        duration: T,
    ) -> Result<CombinedStep<'_, T, M, A, N, B>, ParameterError> {
        let duration = Named("duration", duration).non_negative()?;
        let mut couplings = [Coupling::idle(); A];
        let all = self.frozen(predicted)?;
        let stiffness = self.patch.model().storage_stiffness();
        let axes = self.queues.iter_mut().zip(&stiffness).zip(all);
        for (((queue, &k), frozen), coupling) in axes.zip(&mut couplings) {
            *coupling = self.patch.coupling(queue, k, frozen, duration)?;
        }
        Ok(CombinedStep { rolling: self, couplings })
    }

    /// A function of the patch, each axis's bristles, coefficients and slip velocity.
    fn each(
        &self,
        slip_velocity: &SVector<T, A>,
        of: impl Fn(&Patch<T, M, PolynomialExponential<T, N>>, &Queue<T, N, B>, &Affine<T>, T) -> T,
    ) -> SVector<T, A> {
        let axes = axes_of(self.patch.contact(), slip_velocity);
        SVector::from_fn(|i, _| {
            let v = slip_velocity[i];
            of(&self.patch, &self.queues[i], &axes[i].affine(v, T::zero()), v)
        })
    }

    /// The coefficients and the motion of each axis.
    #[inline]
    fn frozen(&self, motion: Motion<SVector<T, A>, T>) -> Result<[Frozen<T>; A], ParameterError> {
        let Motion { slip_velocity, rolling_speed } = motion;
        let axes = axes_of(self.patch.contact(), finite("slip_velocity", &slip_velocity)?);
        let mut all = [Frozen::still(); A];
        for ((frozen, contact), &slip_velocity) in all.iter_mut().zip(&axes).zip(&slip_velocity) {
            *frozen = self.patch.frozen(contact, Motion { slip_velocity, rolling_speed })?;
        }
        Ok(all)
    }
}

impl<T: Scalar, M: PlaneBristle<T, A>, const A: usize, const N: usize, B: Memory<T, N>>
    CombinedStep<'_, T, M, A, N, B>
{
    /// Mean friction force \[N\] if the mean slip velocity is zero.
    pub fn bias(&self) -> SVector<T, A> {
        SVector::from_fn(|i, _| self.couplings[i].bias)
    }

    /// Diagonal of the damping [N s/m]: zero or positive.
    pub fn damping(&self) -> SVector<T, A> {
        SVector::from_fn(|i, _| self.couplings[i].damping)
    }

    /// Mean friction force F̄ \[N\] for a mean slip velocity v̄ [m/s].
    pub fn force(&self, mean_slip_velocity: &SVector<T, A>) -> SVector<T, A> {
        SVector::from_fn(|i, _| self.couplings[i].force(mean_slip_velocity[i]))
    }

    /// Ends the step with the mean slip velocity v̄ [m/s] that the mechanism has found, and returns
    /// the mean friction force F̄ \[N\].
    ///
    /// # Errors
    ///
    /// Refuses a velocity that is not finite; the patch is as it was.
    pub fn commit(
        self,
        mean_slip_velocity: &SVector<T, A>,
    ) -> Result<SVector<T, A>, ParameterError> {
        let (mean, force) =
            (finite("mean_slip_velocity", mean_slip_velocity)?, self.force(mean_slip_velocity));
        let queues = self.rolling.queues.iter_mut();
        for ((queue, coupling), &v) in queues.zip(&self.couplings).zip(mean) {
            coupling.commit(queue, v);
        }
        Ok(force)
    }

    /// Ends the step as [`CombinedStep::commit`] does, with an account of each axis. The time is
    /// proportional to the number of segments.
    ///
    /// # Errors
    ///
    /// Refuses a velocity that is not finite; the patch is as it was.
    pub fn commit_with_ledger(
        self,
        mean_slip_velocity: &SVector<T, A>,
    ) -> Result<[PatchLedger<T>; A], ParameterError> {
        let mean = finite("mean_slip_velocity", mean_slip_velocity)?;
        let (CombinedPatch { patch, queues }, couplings) = (self.rolling, &self.couplings);
        let stiffness = patch.model().storage_stiffness();
        Ok(core::array::from_fn(|i| {
            patch.commit_with_ledger(&mut queues[i], stiffness[i], &couplings[i], mean[i])
        }))
    }
}
