//! The exact reduction of a patch of uniform bristles: its force without a grid.
//!
//! Over a step with the velocities v and V held, every bristle that is in the patch is mapped by
//! the same z ← e^(−λh) z + z_ss (1 − e^(−λh)) and moves on by V h, and those that entered have
//! the profile z_ss (1 − e^(−λξ/V)). A pressure e^(−aξ) Σ cₖ ξᵏ asks for the moments ∫ ξᵏ e^(−aξ)
//! z dξ alone. Both together make the force of any history of held velocities exact, up to
//! rounding.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | v, V | slip velocity, transport velocity | m/s, 1/s |
//! | λ, z_ss = r v/λ | relaxation rate, stationary deflection | 1/s, m |
//! | h | length of the step | s |
//!
//! Source: the characteristics of Romano et al. (arXiv 2602.09429), section IV-A; the queue is
//! that of sliding-window aggregation, cf. K. Tangwongsan, M. Hirzel, S. Schneider, "Low-latency
//! sliding-window aggregation in worst-case constant time", DEBS 2017.

mod coupling;
mod profile;
mod queue;
mod smooth;

pub use coupling::{PatchCommitted, PatchLedger, PatchStep};
pub use queue::Segment;
pub use smooth::MotionOverTime;

use super::patch::{Crossing, coefficients};
use super::{Motion, Patch, PolynomialExponential, RateDependent};
use crate::parameter::{self, ParameterError};
use crate::scalar::lit;
use crate::{Affine, Scalar};
use profile::Profile;
use queue::{Held, Queue};

/// Most segments that [`Patch::exact_in`] allocates.
#[cfg(feature = "alloc")]
const MOST_SEGMENTS: usize = 10_000_000;

/// A patch in motion, without a grid.
///
/// A step costs a few evaluations of an exponential, whatever the number of segments into which the
/// history has divided the profile:
///
/// ```
/// use bristle::rolling::{Motion, Patch, PatchParameters, PolynomialExponential, Segment};
/// use bristle::{FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let curve = Stribeck::new(paper::TYRE_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
/// let tyre = Patch::new(PatchParameters {
///     model: FrBd::new(curve, bristle),
///     length: paper::TYRE_LENGTH,
///     pressure: PolynomialExponential::parabolic(),
/// })?
/// .carrying(4000.0)?; // N
///
/// // No allocation: the caller gives the memory.
/// let mut rolling = tyre.exact([Segment::default(); 200])?;
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
/// Every step adds a segment of width V h, until it has crossed the patch. Of the slots given, C,
/// all steps with V h ≥ w = 2/(C − 6) are kept exactly. Narrower ones are merged with each other
/// into segments of a width from w to 2 w, straight lines of the same integral and first moment
/// under the pressure's e^(−aξ) (never beyond the deflections that they stand for). The force of
/// those hardly changes while they are far from the outlet, under a pressure of one coefficient
/// not at all; there the line is cut, with an error of O(w³) where the velocities are smooth,
/// O(w²) where they jump: below 0.2 w³ and 0.2 w² of the normal force in a patch whose slip
/// velocity swings once a transit at a few percent of slip. Segments that were merged keep the
/// relative accuracy of a small slip. A patch that does not roll, V = 0, adds none.
///
/// # Accuracy
///
/// Nothing is ever subtracted that was added before, so that no digits are lost to what has left,
/// and nothing drifts. Roundings add up over one transit: some 1e-16 for each of its n steps, and
/// of the place of the outlet too, as with n = 10 000 some 1e-13. In single precision, with 6e-8
/// for each, avoid to keep rolling in steps of V h below 1e-4; to pass through such velocities, or
/// to stand, does no harm.
///
/// # Time
///
/// A step does a fixed number of operations of its own, whatever C, and rebuilds on the side: if V
/// h is never above 1/20 a step rebuilds at most 4 C V h + 1 segments, on average not quite one a
/// step. Longer steps amid short ones may leave up to C to the next. A step beyond a quarter of
/// the patch is taken in parts, up to four; those of a transit and more, V h > 1, cost the same as
/// one, for nothing is left of what was.
#[derive(Debug, Clone)]
pub struct ExactPatch<T, M, const N: usize, B> {
    patch: Patch<T, M, PolynomialExponential<T, N>>,
    queue: Queue<T, N, B>,
}

impl<T: Scalar, M: RateDependent<T>, const N: usize> Patch<T, M, PolynomialExponential<T, N>> {
    /// The patch in motion, with undeflected bristles, in slots that the caller provides: an
    /// array, a mutable slice or a vector. See [`ExactPatch`] for how many.
    ///
    /// # Errors
    ///
    /// Refuses fewer than 22 slots.
    pub fn exact<B>(self, segments: B) -> Result<ExactPatch<T, M, N, B>, ParameterError>
    where
        B: AsRef<[Segment<T, N>]> + AsMut<[Segment<T, N>]>,
    {
        let least = Queue::<T, N, B>::LEAST;
        parameter::count("segments", segments.as_ref().len(), least)?;
        let decay = self.pressure().decay();
        Ok(ExactPatch { queue: Queue::new(segments, decay), patch: self })
    }

    /// The same with memory for as many segments as given, all kept exactly if none is narrower
    /// than its share of the patch.
    ///
    /// # Errors
    ///
    /// Refuses fewer than 8 segments and more than ten million.
    #[cfg(feature = "alloc")]
    pub fn exact_in(
        self,
        segments: usize,
    ) -> Result<ExactPatch<T, M, N, alloc::vec::Vec<Segment<T, N>>>, ParameterError> {
        parameter::count("segments", segments, 8)?;
        let most = MOST_SEGMENTS as f64;
        parameter::at_most("segments", segments as f64, "the largest patch", most)?;
        self.exact(alloc::vec![Segment::default(); 2 * segments + 8])
    }
}

impl<T, M, const N: usize, B> ExactPatch<T, M, N, B>
where
    T: Scalar,
    M: RateDependent<T>,
    B: AsRef<[Segment<T, N>]> + AsMut<[Segment<T, N>]>,
{
    /// The patch.
    pub fn patch(&self) -> &Patch<T, M, PolynomialExponential<T, N>> {
        &self.patch
    }

    /// The same patch under another normal force F_z \[N\], its bristles as they are.
    ///
    /// # Errors
    ///
    /// Refuses a normal force that is negative or not finite.
    pub fn set_normal_force(&mut self, normal_force: T) -> Result<(), ParameterError> {
        self.patch.set_normal_force(normal_force)
    }

    /// Steps with V h below this are merged.
    pub fn narrowest(&self) -> T {
        self.queue.narrowest()
    }

    /// Number of segments of which the profile consists.
    pub fn segments(&self) -> usize {
        self.queue.len()
    }

    /// Takes all bristles to the profile of steady rolling.
    ///
    /// # Errors
    ///
    /// Refuses a motion that is not finite or runs backwards.
    pub fn settle(&mut self, motion: Motion<T>) -> Result<(), ParameterError> {
        let Crossing { slip_velocity, transport } = self.patch.forward(motion)?;
        let Affine { relaxation, drive, .. } = self.coefficients(slip_velocity)?;
        // A crossing that takes for ever is none.
        if (T::one() / transport).is_finite() {
            self.queue.replace(relaxation, drive * slip_velocity, transport);
        } else {
            let z = self.patch.model().stationary(slip_velocity);
            self.queue.fill(1, |_| Profile::straight(T::one(), z, z));
        }
        Ok(())
    }

    /// Takes the bristles to a profile z(ξ) \[m\], straight lines between its values at equally
    /// spaced places.
    ///
    /// # Errors
    ///
    /// Refuses a deflection that is not finite, and no or more segments than half of the slots.
    pub fn set_profile(
        &mut self,
        segments: usize,
        deflection: impl Fn(T) -> T,
    ) -> Result<(), ParameterError> {
        let most = self.queue.capacity() / 2;
        parameter::count("segments", segments, 1)?;
        parameter::at_most("segments", segments as f64, "half of the memory", most as f64)?;
        let place = |number: usize| lit::<T>(number as f64) / lit(segments as f64);
        for number in 0..=segments {
            let checked = parameter::finite("deflection", deflection(place(number)));
            parameter::component(number, checked)?;
        }
        self.queue.fill(segments, |number| {
            let (from, to) = (place(number), place(number + 1));
            Profile::straight(to - from, deflection(from), deflection(to))
        });
        Ok(())
    }

    /// Rolls on for a time h ≥ 0 \[s\] with a motion held, and returns the friction force F \[N\]
    /// at the end, positive against v > 0.
    ///
    /// For velocities that vary smoothly see [`ExactPatch::follow`].
    ///
    /// # Errors
    ///
    /// Refuses a velocity that is not finite, a rolling speed or a duration that is negative, and a
    /// velocity at which a coefficient of the model is not finite; the patch is as it was.
    #[inline]
    pub fn step(&mut self, motion: Motion<T>, duration: T) -> Result<T, ParameterError> {
        let Crossing { slip_velocity, transport } = self.patch.forward(motion)?;
        let duration = parameter::non_negative("duration", duration)?;
        let affine = self.coefficients(slip_velocity)?;
        self.roll(affine.relaxation, affine.drive * slip_velocity, transport, duration);
        Ok(self.force_of(&affine, slip_velocity))
    }

    #[inline]
    fn coefficients(&self, slip_velocity: T) -> Result<Affine<T>, ParameterError> {
        coefficients(self.patch.model(), slip_velocity)
    }

    /// Moves the bristles with held coefficients.
    #[inline]
    fn roll(&mut self, relaxation: T, drive: T, transport: T, duration: T) {
        if transport * duration <= T::one() {
            self.queue.advance(&Held::new(relaxation, drive, transport, duration));
        } else {
            self.queue.replace(relaxation, drive, transport);
        }
    }

    /// The friction force \[N\] at a slip velocity [m/s], with the bristles as they are.
    pub fn force(&self, slip_velocity: T) -> T {
        self.force_of(&self.patch.model().at_velocity(slip_velocity), slip_velocity)
    }

    #[inline]
    fn force_of(&self, affine: &Affine<T>, slip_velocity: T) -> T {
        let patch = &self.patch;
        // L ∫ p z dξ [N m]
        let gathered =
            patch.load() * patch.length() * patch.pressure().weigh(&self.queue.moments());
        affine.stiffness * gathered + patch.normal_force() * (affine.damping * slip_velocity)
    }
}
