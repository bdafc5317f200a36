//! The exact reduction of a patch of uniform bristles: its force without a grid.
//!
//! Over a step with v and V held, every bristle in the patch obeys the map
//! z ← e^(−λh) z + z_ss (1 − e^(−λh)) and moves on by V h. The bristles that entered have the
//! profile z_ss (1 − e^(−λξ/V)). Under a pressure e^(−aξ) Σ cₖ ξᵏ the force needs only the moments
//! ∫ ξᵏ e^(−aξ) z dξ. Their update is exact, so the force is exact up to rounding for every history
//! of held velocities.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | v, V | slip velocity, rolling speed over the length of the patch | m/s, 1/s |
//! | λ, z_ss = r v/λ | relaxation rate, stationary deflection | 1/s, m |
//! | h | length of the step | s |
//!
//! Source: the characteristics of Romano et al. (arXiv 2602.09429), section IV-A. The queue is the
//! two-stack queue of sliding-window aggregation, cf. K. Tangwongsan, M. Hirzel, S. Schneider,
//! "Low-latency sliding-window aggregation in worst-case constant time", DEBS 2017.

mod coupling;
pub(crate) mod profile;
mod queue;
mod smooth;

use coupling::Coupling;
pub use coupling::{PatchLedger, PatchStep};
pub use queue::{Memory, Segment};

use core::marker::PhantomData;

use nalgebra::SVector;

use super::axes::{OfAxes, PatchModel};
use super::patch::finite;
use super::{Motion, Patch, PolynomialExponential, Pressure};
use bristle::parameter::{Checked, Named};
use bristle::scalar::lit;
use bristle::{Affine, Bristle, Reloaded, Scalar};
use profile::level;
use queue::Queue;

#[cfg(feature = "alloc")]
type Segments<T, const N: usize> = alloc::vec::Vec<Segment<T, N>>;

/// Most segments that [`Patch::exact_in`] allocates.
#[cfg(feature = "alloc")]
const MOST_SEGMENTS: usize = 10_000_000;

/// A patch in motion, without a grid.
///
/// The amortised cost of a step does not grow with the number of segments into which the history
/// has divided the profile:
///
/// ```
/// use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential, Segment};
/// use bristle::{FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let curve = Stribeck::new(paper::TYRE_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
/// let tyre = Patch::new(PatchParameters {
///     model: FrBd::new(curve, bristle),
///     length: bristle_rolling::TYRE_LENGTH,
///     pressure: PolynomialExponential::parabolic(),
/// })?
/// .under_load(4000.0)?; // N
///
/// // No allocation: the caller gives the memory.
/// let mut rolling = tyre.exact([[Segment::default(); 200]])?;
/// let mut force = 0.0;
/// for millisecond in 0..100 {
///     let motion = Motion { slip_velocity: 0.02 * f64::from(millisecond), rolling_speed: 16.0 };
///     force = rolling.step(motion, 1e-3)?;
/// }
/// assert!(force > 1500.0 && force < 2400.0);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// # Memory and merging
///
/// Every step adds a segment of width V h, which stays until it has crossed the patch. With memory
/// for C segments all steps with V h ≥ w = 2/(C − 6) are kept exactly. A patch that stands, V = 0,
/// adds none.
///
/// Narrower segments are merged in pairs into straight lines of a width from w to 2 w, with the
/// integral and the first moment of the pair under e^(−aξ), and within its deflections. Under a
/// pressure of one coefficient the force does not change while a merged segment is away from the
/// outlet; under others it hardly does.
///
/// Where the outlet cuts a merged segment the error is O(w³) for smooth velocities and O(w²) where
/// they jump: below 0.2 w³ and 0.2 w² of the normal force for a slip velocity that swings once a
/// crossing at a few percent of slip.
///
/// # Accuracy
///
/// The sums only ever grow by what enters, so no digits are lost to bristles that have left, and
/// nothing drifts. Rounding adds up over one crossing of the patch: about 1e-16 for each of its n
/// steps, and for n = 10 000 about 1e-13 for the place of the outlet.
///
/// In single precision the rounding is 6e-8 a step: avoid rolling for long in steps of V h < 1e-4.
/// Passing through such speeds, and standing, does no harm.
///
/// # Time
///
/// A step takes a fixed number of operations. About once per crossing of the patch a step also
/// rebuilds the queue, with one visit to each segment: constant cost per step on average, but
/// O(C) for that one. A step of V h > 1 replaces the profile.
#[derive(Debug, Clone)]
pub struct ExactPatch<T, M, const N: usize, B, V = T, const A: usize = 1> {
    patch: Patch<T, M, PolynomialExponential<T, N>>,
    queues: [Queue<T, N, B>; A],
    of: PhantomData<V>,
}

/// A patch in motion in combined slip: [`ExactPatch`] with a vector for the slip velocity and the
/// force. Memory, merging, accuracy and time are those of `ExactPatch` on each of the A axes: with
/// v and V held over a step all bristles of axis i share λᵢ and rᵢ vᵢ.
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
/// let mut rolling = tyre.exact([[Segment::default(); 200]; 2])?;
/// let mut force = Vector2::zeros();
/// for millisecond in 0..100 {
///     // Braking, with a slip angle that grows.
///     let slip_velocity = Vector2::new(0.8, 0.01 * f64::from(millisecond)); // m/s
///     force = rolling.step(Motion { slip_velocity, rolling_speed: 16.0 }, 1e-3)?;
/// }
/// let aligning = rolling.moment(Vector2::new(0.8, 0.99)).y; // N m
/// assert!(force.x > 800.0 && force.y > 1000.0 && aligning > 0.0);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
pub type CombinedPatch<T, M, const A: usize, const N: usize, B> =
    ExactPatch<T, M, N, B, SVector<T, A>, A>;

impl<T: Scalar, M, const N: usize> Patch<T, M, PolynomialExponential<T, N>> {
    /// The patch in motion, with undeflected bristles, in memory that the caller provides for each
    /// axis: an array, a mutable slice or a vector of segments. [`ExactPatch`] says how many.
    ///
    /// # Errors
    ///
    /// Refuses fewer than 22 segments.
    pub fn exact<B: Memory<T, N>, V, const A: usize>(
        self,
        segments: [B; A],
    ) -> Checked<ExactPatch<T, M, N, B, V, A>>
    where
        M: PatchModel<T, V, A>,
    {
        for memory in &segments {
            Named("segments", memory.as_ref().len()).count(Queue::<T, N, B>::LEAST)?;
        }
        let decay = self.pressure().decay();
        let queues = segments.map(|memory| Queue::new(memory, decay));
        Ok(ExactPatch { queues, patch: self, of: PhantomData })
    }

    /// The patch in motion, with undeflected bristles and memory for steps of V h ≥ 1/`segments`:
    /// these are kept exactly.
    ///
    /// # Errors
    ///
    /// Refuses fewer than 8 segments and more than ten million.
    #[cfg(feature = "alloc")]
    pub fn exact_in<V, const A: usize>(
        self,
        segments: usize,
    ) -> Checked<ExactPatch<T, M, N, Segments<T, N>, V, A>>
    where
        M: PatchModel<T, V, A>,
    {
        Named("segments", segments).count_between(8, MOST_SEGMENTS)?;
        self.exact([(); A].map(|()| alloc::vec![Segment::default(); 2 * segments + 8]))
    }
}

/// What shortening all deflections to a share dissipates of a stored energy.
pub(crate) fn slipped<T: Scalar>(stored: T, kept: T) -> T {
    stored * (T::one() - kept) * (T::one() + kept)
}

impl<T, M, const N: usize, B, V, const A: usize> ExactPatch<T, M, N, B, V, A>
where
    T: Scalar,
    M: PatchModel<T, V, A>,
    B: Memory<T, N>,
    V: OfAxes<T, A>,
{
    /// The patch.
    pub fn patch(&self) -> &Patch<T, M, PolynomialExponential<T, N>> {
        &self.patch
    }

    /// Changes the normal force F_z \[N\], zero or positive, before a step with a slip velocity
    /// [m/s], as [`Contact::reload`](bristle::Contact::reload): stiffness and damping stay those of
    /// the reference load. Where the load falls below what the most deflected bristle carries, all
    /// deflections are shortened by one factor until it is held.
    ///
    /// A wheel that stands on a slope stands while its load varies. The slip stiffness of one that
    /// rolls does not follow its load: see [`ExactPatch::renew`].
    ///
    /// Takes time in proportion to the number of segments where the load falls.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite, and a positive one on a patch without
    /// a reference load; the patch is as it was.
    pub fn reload(&mut self, normal_force: T, slip_velocity: V) -> Checked<Reloaded<T, ()>> {
        let change = self.patch.contact.change_load(normal_force)?;
        if change.after >= change.before {
            return Ok(Reloaded { deflection: (), dissipated: T::zero() });
        }
        let ranges = self.queues.each_ref().map(Queue::range);
        let kept = M::kept(self.patch.contact(), change, slip_velocity, ranges);
        let dissipated = slipped(self.stored_energy(), kept);
        self.queues.iter_mut().for_each(|queue| queue.scale(kept));
        Ok(Reloaded { deflection: (), dissipated })
    }

    /// Changes the normal force by renewal, see [`Contact::renew`](bristle::Contact::renew): the
    /// stiffness follows the load, as that of a wheel that rolls does, whose bristles are new with
    /// each crossing of the patch. A wheel that stands creeps by it.
    ///
    /// Takes time in proportion to the number of segments.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite; the patch is as it was.
    pub fn renew(&mut self, normal_force: T) -> Checked<Reloaded<T, ()>> {
        let stored = self.stored_energy();
        let (kept, lost) = self.patch.renew_load(normal_force)?.renewed();
        self.queues.iter_mut().for_each(|queue| queue.scale(kept));
        Ok(Reloaded { deflection: (), dissipated: lost * stored })
    }

    /// Takes all bristles to the profile of steady rolling.
    ///
    /// # Errors
    ///
    /// Refuses a motion that is not finite or runs backwards.
    pub fn settle(&mut self, motion: Motion<V, T>) -> Checked<()> {
        let all = self.patch.frozen(motion)?;
        self.queues.iter_mut().zip(&all).for_each(|(queue, frozen)| queue.settle(frozen));
        Ok(())
    }

    /// Rolls on for a time h ≥ 0 \[s\] with a motion held, and returns the friction force F \[N\]
    /// at the end, positive against v > 0. Of a motion that varies take that at the middle of the
    /// step: second order. For one axis see [`ExactPatch::follow`].
    ///
    /// # Errors
    ///
    /// Refuses a velocity that is not finite, a rolling speed or a duration that is negative, and a
    /// velocity at which a coefficient of the model is not finite; the patch is as it was.
    #[inline]
    pub fn step(&mut self, motion: Motion<V, T>, duration: T) -> Checked<V> {
        let duration = Named("duration", duration).non_negative()?;
        let all = self.patch.frozen(motion)?;
        let Self { patch, queues, .. } = self;
        Ok(V::of_axes(core::array::from_fn(|i| {
            let (queue, frozen) = (&mut queues[i], &all[i]);
            queue.roll(frozen, frozen.drive(), duration);
            patch.force_of(queue, &frozen.affine, frozen.slip_velocity)
        })))
    }

    /// The source and the damper that stand for the patch over a step of length h ≥ 0 \[s\], from
    /// a motion predicted for its middle.
    ///
    /// Second order in h if the prediction is right up to O(h²). A step with its commit costs three
    /// to eight plain ones of [`ExactPatch::step`] at a thousand steps a crossing, and nine to
    /// seventeen at a hundred, where what leaves takes more quadrature nodes.
    ///
    /// A wheel of inertia J and radius R on a drum, under a drive torque τ: J (ω₁ − ω)/h = τ + R
    /// F̄ with v̄ = v_x − R ω̄ is solved for the mean ω̄.
    ///
    /// ```
    /// use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential};
    /// use bristle::{FrBd, paper};
    /// use bristle::curve::Stribeck;
    /// use bristle::rheology::KelvinVoigt;
    ///
    /// let curve = Stribeck::new(paper::TYRE_CURVE)?;
    /// let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
    /// let tyre = Patch::new(PatchParameters {
    ///     model: FrBd::new(curve, bristle),
    ///     length: 0.1,
    ///     pressure: PolynomialExponential::constant(),
    /// })?
    /// .under_load(4000.0)?; // N
    /// let mut patch = tyre.exact_in(100)?;
    /// let (inertia, radius) = (1.0, 0.3); // kg m², m
    /// let (drum, torque, h) = (20.0, -200.0, 5e-3); // m/s, N m, s
    /// let mut spin = drum / radius; // rad/s: rolling freely
    /// let mut expected = spin;
    /// for _ in 0..200 {
    ///     let motion = Motion {
    ///         slip_velocity: drum - expected * radius,
    ///         rolling_speed: expected * radius,
    ///     };
    ///     let step = patch.companion_step(motion, h)?;
    ///     let pull = step.bias() + step.damping() * drum;
    ///     let mean = (2.0 * inertia / h * spin + torque + radius * pull)
    ///         / (2.0 * inertia / h + step.damping() * radius * radius);
    ///     step.commit(drum - mean * radius)?;
    ///     let next = 2.0 * mean - spin;
    ///     expected = 1.5 * next - 0.5 * spin; // the middle of the next step
    ///     spin = next;
    /// }
    /// // The tyre carries the torque.
    /// assert!((patch.force(drum - spin * radius) - 200.0 / 0.3).abs() < 0.01);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Bounds
    ///
    /// The energy balance holds for every prediction. The bounds of deflection and force hold
    /// while v̄ is the slip velocity predicted. Where it is not, as when a wheel locks within a
    /// long step, the mean force may exceed F_z max μ, and bristles their limit until they leave.
    /// Then solve again with the v̄ found, or take shorter steps.
    ///
    /// A step that pushes bristles which entered since the last rebuild over the outlet rebuilds
    /// the queue, even if it is dropped: see [`ExactPatch`] on time.
    ///
    /// # Errors
    ///
    /// Refuses a velocity that is not finite, a rolling speed or a duration that is negative, and
    /// what gives a bias or a damping that is not finite; the patch is as it was.
    pub fn companion_step(
        &mut self,
        predicted: Motion<V, T>,
        duration: T,
    ) -> Checked<PatchStep<'_, T, M, N, B, V, A>> {
        let duration = Named("duration", duration).non_negative()?;
        let all = self.patch.frozen(predicted)?;
        let stiffness = self.patch.model().stiffness_of_axes();
        let Self { patch, queues, .. } = &mut *self;
        let coupling = |i: usize| patch.coupling(&mut queues[i], stiffness[i], all[i], duration);
        let couplings = core::array::from_fn::<_, A, _>(coupling);
        for Coupling { bias, damping, .. } in couplings {
            finite("bias", bias)?;
            finite("damping", damping)?;
        }
        Ok(PatchStep { rolling: self, couplings })
    }

    /// The friction force \[N\] at a slip velocity [m/s], with the bristles as they are.
    pub fn force(&self, slip_velocity: V) -> V {
        self.each(slip_velocity, Patch::force_of)
    }

    /// The moment of the friction force about the middle of the patch \[N m\] at a slip velocity
    /// [m/s], with the bristles as they are: L² ∫ (ξ − ½) p μ_b dξ. That of a lateral force is the
    /// self-aligning moment, which turns the wheel into the direction it moves in.
    ///
    /// The next moment of the profile tells it in a fixed number of operations if the last
    /// coefficient of the pressure is zero ([`PolynomialExponential::padded`]). Otherwise the time
    /// is proportional to the number of segments.
    pub fn moment(&self, slip_velocity: V) -> V {
        self.each(slip_velocity, Patch::moment_of)
    }

    /// The energy stored in the bristles, W = (L/2) ∫ K p z² dξ \[J\], with the pressure p under
    /// the reference load. The time is proportional to the number of segments.
    pub fn stored_energy(&self) -> T {
        let axes = self.queues.iter().zip(self.patch.model().stiffness_of_axes());
        axes.fold(T::zero(), |sum, (queue, k)| sum + self.patch.stored_in(queue, k))
    }

    /// The deflection z \[m\] at a place ξ between 0 and 1, NaN elsewhere. The time is proportional
    /// to the number of segments.
    pub fn deflection(&self, place: T) -> V {
        V::of_axes(self.queues.each_ref().map(|queue| queue.deflection(place)))
    }

    /// A function of the patch, each axis's bristles, coefficients and slip velocity.
    fn each(
        &self,
        slip_velocity: V,
        of: impl Fn(&Patch<T, M, PolynomialExponential<T, N>>, &Queue<T, N, B>, &Affine<T>, T) -> T,
    ) -> V {
        V::of_axes(M::each(self.patch.contact(), slip_velocity, |i, contact, v| {
            of(&self.patch, &self.queues[i], &contact.affine(v, T::zero()), v)
        }))
    }
}

impl<T: Scalar, M: Bristle<T, Deflection = T>, const N: usize, B: Memory<T, N>>
    ExactPatch<T, M, N, B>
{
    /// Steps with V h below this are merged.
    pub fn narrowest(&self) -> T {
        self.queues[0].narrowest
    }

    /// Number of segments of which the profile consists.
    pub fn segments(&self) -> usize {
        self.queues[0].len()
    }
}

/// A patch and the bristles of one axis.
impl<T: Scalar, M, const N: usize> Patch<T, M, PolynomialExponential<T, N>> {
    fn moment_of<B: Memory<T, N>>(
        &self,
        queue: &Queue<T, N, B>,
        affine: &Affine<T>,
        slip_velocity: T,
    ) -> T {
        let (pressure, half) = (self.pressure(), lit::<T>(0.5));
        // About the middle, of moments about the inlet.
        let leaned = |moments: [T; N]| {
            pressure.weigh_next(&moments).map(|(integral, next)| next - half * integral)
        };
        let gathered = leaned(queue.staying(T::zero())).unwrap_or_else(|| {
            let mut sum = T::zero();
            queue.over_bristles(pressure, |place, deflection, load| {
                sum += (place - half) * (load * deflection);
            });
            sum
        });
        let uniform = leaned(level(pressure.decay()))
            .unwrap_or_else(|| pressure.lever(T::zero()) - half * pressure.total());
        let direct = affine.damping * slip_velocity * uniform;
        let length = self.length();
        length * length * self.factor * (affine.stiffness * gathered + direct)
    }

    #[inline]
    fn force_of<B: Memory<T, N>>(
        &self,
        queue: &Queue<T, N, B>,
        affine: &Affine<T>,
        slip_velocity: T,
    ) -> T {
        // L ∫ p z dξ [N m]
        let gathered =
            self.factor * self.length() * self.pressure().weigh(&queue.staying(T::zero()));
        let load = self.contact().reference_load();
        affine.stiffness * gathered + load * (affine.damping * slip_velocity)
    }
}
