//! Steps of many bristles at once: a granular bed, a brush seal, a tyre of a million contacts.
//!
//! Slices in, slices out, one number for each bristle. Every bristle has a velocity, a normal force
//! and a deflection of its own; its parameters are shared ([`Batch::of`]) or its own
//! ([`Batch::of_each`]). Nothing is allocated.
//!
//! A batch vectorises [`FrBd`](bristle::FrBd) with a Coulomb, Stribeck (δ = 1 or 2) or rational
//! Stribeck curve and a spring or Kelvin–Voigt bristle, and [`Dahl`](bristle::Dahl), in `f32` and
//! `f64`. Its bristles have one axis or several ([`PlaneFrBd`](bristle_plane::PlaneFrBd)). Other
//! models, and your own, go one by one ([`Batch::of_model`]).
//!
//! # The passive step
//!
//! [`Batch::companions`] turns every bristle into a source and a damper over a step, as
//! [`Companion`](bristle::companion::Companion) does, here by the implicit midpoint rule with the
//! coefficients frozen at a predicted velocity v\*. A bristle of stiffness σ0 and damping σ1 is
//! then a damper κ in series with the surface's μ/|v\*|, and one share c describes the step:
//!
//! κ = σ1 + h σ0/2,  c = μ(v\*)/(μ(v\*) + κ|v\*|)
//!
//! F̄ = bias + damping·v̄,  bias = p c σ0 z₀,  damping = p c κ
//!
//! z₁ = z₀ + c h v̄ − (1 − c)(h σ0/κ) z₀
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | h | length of the step | s |
//! | v\*, v̄ | velocity predicted for the middle of the step, and mean velocity | m/s |
//! | z₀, z₁, z̄ | deflection before and after the step, and their mean | m |
//! | p, F̄ | normal force, and mean friction force | N |
//! | μ | friction curve | – |
//! | σ0, σ1 | normalised micro-stiffness and micro-damping | 1/m, s/m |
//! | κ | damping of a bristle over a step | s/m |
//! | c | share of the velocity that deflects the bristle: 1 at rest, 0 in fast sliding | – |
//! | λ | relaxation rate σ0\|v\*\|/g, where g = σ1\|v\*\| + μ | 1/s |
//! | r | drive μ/g | – |
//!
//! The mechanism solves for its mean velocities, and [`Batch::commit`] ends the step. A step costs
//! one exponential, that of the curve. The energy W = ½ p σ0 z² obeys
//!
//! h F̄ v̄ = W₁ − W₀ + D,  D = h p (σ0 λ z̄² + σ1 r v̄²) ≥ 0
//!
//! for every h, z₀, v\* and v̄: no step gives energy that was not stored.
//!
//! Positions, velocities and deflections are of second order in h if v\* is the velocity at the
//! middle up to O(h²), see [`VelocityHistory`](bristle::companion::VelocityHistory). The difference
//! from the exponential step of [`Companion`](bristle::companion::Companion) is of third order.
//!
//! Where λh > 2 the deflection oscillates about its stationary value and decays slowly, by (2 −
//! λh)/(2 + λh) a step, though it stays within its limit. Take [`Batch::hold`], a shorter step or
//! the scalar step there. With damping, λ is at most σ0/(σ1 + σ2).
//!
//! If the prediction was wrong, the deflection can exceed its limit. It is then cut to
//! (μ_s + σ2|v̄|)/σ0, or to its size before the step if that is larger. This only removes energy.
//!
//! # A load that varies
//!
//! Without more, the stiffness of a bristle is p σ0 and follows its normal force. With
//! [`Batch::measured_at`] it is P σ0, that of a reference load P, and the normal force scales the
//! curve by s = p/P, as in a [`Contact`](bristle::Contact): read P for p and s μ for μ in all
//! formulas. [`Batch::reload`] changes the normal forces before a step. What the surface holds
//! stands still; a bristle whose load falls keeps the share
//!
//! min(1, max(1/γ, p'/p)),  γ = σ0|z|/(s' B),  B = max(μ_s, μ(v\*))
//!
//! of its deflection. A contact that is born, from p = 0, begins at z = 0. Bristles with reference
//! loads Pᵢ of their own are those of [`Batch::of_each`] with σ0 Pᵢ/P and σ1 Pᵢ/P.
//!
//! A stiffness that follows the load has another change of it: multiply each deflection by
//! min(1, p/p') before a step, as [`Contact::renew`](bristle::Contact::renew) does. Without it, a
//! load that rises gives energy.
//!
//! # Models of your own
//!
//! [`Batch::of_model`] takes any [`Bristle`] of one deflection whose coefficients λ, r, c₀, c₂
//! ([`Affine`](bristle::Affine)) depend on the velocity alone. The methods are the same, and so are
//! the steps: at v\*
//!
//! z̄ = (z₀ + (h/2) r v̄)/(1 + λh/2),  F̄ = P (c₀ z̄ + c₂ v̄),  z₁ = 2 z̄ − z₀
//!
//! The bristles go one by one, at the speed of the model.
//!
//! # Several axes
//!
//! Bristles of N axes have one normal force and N velocities, deflections, shares, biases and
//! dampings each. A slice holds them **axis after axis**: those of all bristles along the first
//! axis, then those of all bristles along the second. Of n bristles it has N n numbers.
//!
//! At v\* each axis i is a bristle of its own, as in [`plane`](bristle_plane): its μ is
//! aᵢ² μ(‖v\*‖), its |v\*| the weighted speed ‖(aᵢ vᵢ\*)‖. So the energy balance holds for each
//! axis. A deflection is cut to aᵢ(μ_s + σ2 Σ|v̄ⱼ|)/σ0ᵢ. A speed whose square overflows counts as
//! infinite, one whose square underflows as zero. A falling load cuts all axes alike: γ is the norm
//! of σ0ᵢ zᵢ/(aᵢ s' B) where the axes relax alike, and the largest of these numbers elsewhere.
//!
//! ```
//! use bristle_batch::{Batch, ReloadInput, StepInput};
//! use bristle::curve::Stribeck;
//! use bristle::paper;
//! use bristle_plane::PlaneFrBd;
//! use bristle::rheology::KelvinVoigt;
//!
//! let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
//! let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
//! let grains = PlaneFrBd::<_, _, 2>::isotropic(curve, bristle);
//! let grains = Batch::of(&grains)?.measured_at(2.0)?; // N
//! // Three contacts, the second of which is born: its load was zero before this step.
//! let (before, after) = ([1.0, 0.0, 4.0], [1.0, 3.0, 2.0]); // N
//! let velocities = [0.3, 0.0, -0.3, 0.4, -0.1, 0.0]; // m/s, along x and then along y
//! let mut deflections = [1e-5, 2e-5, 3e-5, 0.0, 1e-5, 0.0]; // m
//! let mut dissipated = [0.0; 3]; // J
//! let loads = ReloadInput { before: &before, after: &after, velocities: &velocities };
//! let reloaded = grains.reload(loads, &mut deflections, &mut dissipated)?;
//! assert_eq!(deflections, [1e-5, 0.0, 3e-5, 0.0, 0.0, 0.0]);
//! let mut forces = [0.0; 6]; // N
//! let input =
//!     StepInput { velocities: &velocities, normal_forces: &after, deflections: &mut deflections };
//! let held = grains.hold(input, 1.0, &mut forces)?;
//! assert!(reloaded.is_finite() && held.is_finite());
//! // In steady sliding the deflection, and with it the friction, is along the velocity.
//! assert!((deflections[3] / deflections[0] - 4.0_f64 / 3.0).abs() < 1e-9);
//! # Ok::<(), bristle_batch::BatchError>(())
//! ```
//!
//! # The exact step
//!
//! [`Batch::hold`] is [`Contact::hold`](bristle::Contact::hold) for all bristles: the velocity is
//! held, and deflection and mean force are exact,
//!
//! z₁ = e⁻ˣ z₀ + (1 − e⁻ˣ) z_ss,  z̄ = φ1 z₀ + (1 − φ1) z_ss,  F̄ = p r (σ0 z̄ + σ1 v),
//!
//! x = λh, φ1 = (1 − e⁻ˣ)/x, z_ss = sgn(v) μ(v)/σ0. A step costs two exponentials.
//!
//! ```
//! use bristle_batch::{Batch, CommitInput, PassiveOutput, StepInput};
//! use bristle::{FrBd, paper};
//! use bristle::curve::Stribeck;
//! use bristle::rheology::KelvinVoigt;
//!
//! let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
//! let model = FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?);
//! let grains = Batch::of(&model)?;
//! // Three grains on a belt of 0.1 m/s, under loads of their own [N].
//! let (mass, h, belt, normal_forces) = (0.1, 1e-3, 0.1, [0.5, 1.0, 2.0]);
//! let (mut v, mut z) = ([0.0; 3], [0.0; 3]); // m/s, m
//! let (mut shares, mut biases, mut dampings) = ([0.0; 3], [0.0; 3], [0.0; 3]);
//! for _ in 0..100 {
//!     let slip = v.map(|v| v - belt); // predicted by the velocity before the step
//!     let input =
//!         StepInput { velocities: &slip, normal_forces: &normal_forces, deflections: &mut z };
//!     let output =
//!         PassiveOutput { shares: &mut shares, biases: &mut biases, dampings: &mut dampings };
//!     let begun = grains.companions(input, h, output)?;
//!     // m (v₁ − v)/h = −F̄ with v₁ = 2 v̄ − v
//!     let mut mean = [0.0; 3];
//!     for i in 0..3 {
//!         let inertia = 2.0 * mass / h;
//!         mean[i] = (inertia * slip[i] - biases[i]) / (inertia + dampings[i]);
//!         v[i] = 2.0 * (mean[i] + belt) - v[i];
//!     }
//!     let found =
//!         CommitInput { shares: &shares, velocities: &mean, normal_forces: &normal_forces };
//!     let ended = grains.commit(found, h, &mut z)?;
//!     assert!(begun.is_finite() && ended.is_finite());
//! }
//! assert!(v.iter().all(|v| (v - belt).abs() < 1e-3)); // all carried along
//! # Ok::<(), bristle_batch::BatchError>(())
//! ```
//!
//! # Non-finite values
//!
//! No bristle affects another. One whose result is not finite is counted in the step's [`Outcome`],
//! which the caller must look at:
//!
//! | input of a bristle | result |
//! |---|---|
//! | velocity NaN or infinite | NaN everywhere; at the end of a passive step not finite |
//! | deflection NaN or infinite | force and deflection not finite |
//! | normal force NaN or infinite | force not finite; the deflection goes on |
//! | normal force negative | force NaN, for surfaces do not pull; the deflection goes on |
//! | normal force zero | no force; the deflection goes on |
//! | with a reference load: normal force NaN, infinite or negative | NaN everywhere |
//!
//! Slices that differ in length, and parameters or durations out of range, are refused by name
//! before anything is written.
//!
//! # Bit equality
//!
//! Every bristle takes the same additions, multiplications and divisions in the same order,
//! wherever it stands in a batch of any length and order. No operation is fused (`mul_add`), and
//! the exponential is the crate's own. So the bits do not depend on the instruction set, on the
//! features `simd` and `rayon`, or on whether parameters are shared.
//!
//! Not promised are the sign and payload of a NaN, and targets that compute wider than they store
//! (x87). The exponential is accurate to two units in the last place, and zero where it would be
//! below the smallest normal number. Results agree with the scalar steps up to rounding.
//!
//! # Speed
//!
//! The code is written for the compiler to vectorise. With the feature `simd` it is compiled for
//! SSE2, AVX2 and AVX-512 (NEON on ARM), and the processor is asked at run time; without it, for
//! the build's target (SSE2 on x86-64). The feature `rayon` adds `Batch::in_parallel`.
//!
//! One thread, 4096 bristles, FrBD with δ = 2, on a Xeon with AVX-512. The first two rows are
//! multiples of the platform's `exp` on as many numbers (3.9 ns in `f64`, 1.9 ns in `f32`), the
//! last two are the scalar step's time over the batch's:
//!
//! | | AVX2, `f64` | `f32` | AVX-512, `f64` | `f32` |
//! |---|---|---|---|---|
//! | passive step, both halves, over `exp` | 0.92 | 0.70 | 0.67 | 0.67 |
//! | exact step over `exp` | 1.8 | 1.5 | 1.4 | 1.0 |
//! | scalar passive step over the batch's | 5.1 | 11 | 7.2 | 11 |
//! | scalar exact step over the batch's | 2.2 | 4.6 | 3.1 | 6.8 |
//!
//! A reference load makes the passive step 13 to 20 % longer (SSE2). [`Batch::reload`] takes as
//! long as 1.3 steps (`f32`: 1.5). One by one ([`Batch::of_model`]) the same model takes as long as
//! 4.9 steps (`f32`: 13).
//!
//! Passive steps of several axes are multiples of that of one axis:
//!
//! | | AVX2, `f64` | `f32` | AVX-512, `f64` | `f32` |
//! |---|---|---|---|---|
//! | two axes alike | 1.7 | 2.1 | 2.1 | 1.9 |
//! | two axes unlike | 1.9 | 2.3 | 2.3 | 2.0 |
//! | three axes alike | 3.0 | 4.2 | 3.4 | 3.3 |
//!
//! ```sh
//! RUSTFLAGS="-C target-feature=+avx2" cargo bench -p bristle-batch
//! cargo bench -p bristle-batch --features simd,rayon # the widest vectors there are, and threads
//! ```
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(feature = "std")]
extern crate std;

mod drive;
mod kernel;
mod material;
mod outcome;
#[cfg(feature = "rayon")]
mod parallel;
mod real;

pub use material::{Columns, Fall, Uniform};
pub use outcome::{BatchError, Outcome};
pub use real::Real;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

use bristle::Bristle;
use bristle::parameter::{Checked, Named, ParameterError};
use drive::Slices;
use kernel::{Bound, Commit, Hold, Kernel, Operation, Predict, Reload, Single, Step};
use material::{Alike, EXPONENTIAL, GAUSSIAN, Material, OwnModel, RATIONAL, Source, Stored};

/// What the bristles are made of.
#[derive(Debug, Clone, Copy)]
enum Bristles<'a, T, const N: usize> {
    /// One material for all.
    Shared(Material<T, N>),
    /// Parameters of each, checked and of one length, alike on all axes.
    Each(Columns<'a, T>),
    /// A model of its own, of one axis.
    Own(OwnModel<'a, T>),
}

/// Many bristles of N axes, of one model or each with parameters of its own.
///
/// It holds parameters and no state: one batch serves any number of bristles (or as many as it has
/// parameters for), and any number of steps.
///
/// ```
/// use bristle_batch::{Batch, StepInput};
/// use bristle::{Dahl, DahlParameters};
///
/// let parameters = DahlParameters { dynamic_coefficient: 0.5_f32, micro_stiffness: 1e4 };
/// let batch = Batch::of(&Dahl::new(parameters)?)?;
/// let (mut deflections, mut mean_forces) = ([0.0; 2], [0.0; 2]);
/// let (velocities, normal_forces) = (&[0.1, f32::NAN], &[20.0, 20.0]);
/// let input = StepInput { velocities, normal_forces, deflections: &mut deflections };
/// let outcome = batch.hold(input, 1e-3, &mut mean_forces)?; // s
/// assert!(mean_forces[0] > 0.0 && mean_forces[0] < 10.0);
/// assert_eq!((outcome.not_finite, outcome.first), (1, Some(1)));
/// # Ok::<(), bristle_batch::BatchError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Batch<'a, T, const N: usize = 1> {
    fall: Fall,
    bristles: Bristles<'a, T, N>,
    /// The load at which stiffness and damping were measured, if not the normal force of each step.
    reference: Option<T>,
    /// Without the feature `rayon` this changes nothing.
    parallel: bool,
}

/// Motion, load and state of every bristle: input of [`Batch::companions`] and [`Batch::hold`]. All
/// but the normal forces have a number for each axis, axis after axis.
#[derive(Debug, PartialEq)]
pub struct StepInput<'a, T> {
    /// Velocities [m/s]: v\* predicted for the middle of a passive step, v held over an exact one.
    pub velocities: &'a [T],
    /// Normal forces p \[N\].
    pub normal_forces: &'a [T],
    /// Deflections \[m\] before the step. [`Batch::hold`] replaces them by those after it,
    /// [`Batch::companions`] leaves them as they are.
    pub deflections: &'a mut [T],
}

/// Output of a passive step: the mean force of every bristle and axis is F̄ = bias + damping·v̄.
#[derive(Debug, PartialEq)]
pub struct PassiveOutput<'a, T> {
    /// Shares c \[–\] of the velocities that deflect the bristles, for [`Batch::commit`]. Of a
    /// model of its own the predicted velocities [m/s].
    pub shares: &'a mut [T],
    /// Mean friction forces at v̄ = 0 \[N\].
    pub biases: &'a mut [T],
    /// Increase of the mean forces with the mean velocities [N s/m], zero or positive.
    pub dampings: &'a mut [T],
}

/// Normal forces of every bristle, before and after a change, and its motion: [`Batch::reload`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReloadInput<'a, T> {
    /// Normal forces p \[N\] of the last step.
    pub before: &'a [T],
    /// Normal forces p' \[N\] of the coming step.
    pub after: &'a [T],
    /// Velocities v\* [m/s] predicted for the middle of the coming step, axis after axis.
    pub velocities: &'a [T],
}

/// Input of the end of a passive step: [`Batch::commit`]. All but the normal forces have a number
/// for each axis, axis after axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommitInput<'a, T> {
    /// What the beginning wrote to [`PassiveOutput::shares`].
    pub shares: &'a [T],
    /// Mean velocities v̄ over the step [m/s].
    pub velocities: &'a [T],
    /// Normal forces p \[N\], those of [`StepInput::normal_forces`].
    pub normal_forces: &'a [T],
}

impl<'a, T: Real> Batch<'a, T> {
    /// Bristles with parameters of their own: FrBD with a Kelvin–Voigt bristle, and a curve that
    /// falls in the same way for all. Every parameter is checked once, here.
    ///
    /// ```
    /// use bristle_batch::{Batch, Columns, Fall};
    ///
    /// let columns = Columns {
    ///     static_coefficients: &[1.5, 0.6],
    ///     dynamic_coefficients: &[1.0, 0.7],
    ///     stribeck_velocities: &[0.01, 0.01],
    ///     viscous_frictions: &[0.0, 0.0],
    ///     micro_stiffnesses: &[1e4, 1e4],
    ///     micro_dampings: &[64.5, 64.5],
    /// };
    /// let refused = Batch::of_each(Fall::Gaussian, columns).unwrap_err();
    /// assert_eq!(
    ///     refused.to_string(),
    ///     "static_coefficients[1] is 0.6, but must be at least dynamic_coefficients = 0.7"
    /// );
    /// ```
    ///
    /// # Errors
    ///
    /// Names a parameter that is out of its range and its index, or a slice whose length differs
    /// from that of the others.
    pub fn of_each(fall: Fall, columns: Columns<'a, T>) -> Result<Self, BatchError> {
        columns.check()?;
        Ok(Self::new(fall, Bristles::Each(columns)))
    }

    /// Bristles of a model of your own, or of any other of one deflection. The steps are those of
    /// [`Batch::of`], one by one: the speed is that of the model, and nothing is vectorised.
    ///
    /// ```
    /// use bristle::curve::{Stribeck, StribeckParameters};
    /// use bristle::rheology::KelvinVoigt;
    /// use bristle::{LuGre, paper};
    /// use bristle_batch::{Batch, StepInput};
    ///
    /// let curve = StribeckParameters { stribeck_exponent: 1.4, ..paper::STICK_SLIP_CURVE };
    /// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
    /// let lugre = LuGre::classical(Stribeck::new(curve)?, bristle);
    /// let (mut deflections, mut mean_forces) = ([0.0; 2], [0.0; 2]);
    /// let (velocities, normal_forces) = (&[0.1, -0.1], &[20.0, 20.0]); // m/s, N
    /// let input = StepInput { velocities, normal_forces, deflections: &mut deflections };
    /// let outcome = Batch::of_model(&lugre)?.hold(input, 1e-3, &mut mean_forces)?; // s
    /// assert!(outcome.is_finite() && mean_forces[0] == -mean_forces[1]);
    /// # Ok::<(), bristle_batch::BatchError>(())
    /// ```
    ///
    /// A step of a model gives no energy that was not stored if
    /// [`CompanionStep::is_passive`](bristle::companion::CompanionStep::is_passive) holds for it.
    ///
    /// # Errors
    ///
    /// Refuses a model whose coefficients depend on the deflection, by its name: elasto-plastic
    /// FrBD and the implicit bristle. A model tells this by [`Bristle::form`].
    pub fn of_model<M>(model: &'a M) -> Result<Self, BatchError>
    where
        M: Bristle<T, Deflection = T> + Sync,
    {
        // The curve is the model's own: any fall will do.
        Ok(Self::new(Fall::Rational, Bristles::Own(OwnModel::new(model)?)))
    }

    /// The bristles on N axes instead of one, alike on all of them.
    ///
    /// # Errors
    ///
    /// Refuses a model of its own, which has one axis.
    pub fn isotropic<const N: usize>(self) -> Result<Batch<'a, T, N>, BatchError> {
        let bristles = match self.bristles {
            Bristles::Shared(Material { curve, axes: [axis], ellipsoid }) => {
                Bristles::Shared(Material { curve, axes: [axis; N], ellipsoid })
            }
            Bristles::Each(columns) => Bristles::Each(columns),
            Bristles::Own(_) => {
                let takes = "bristles of several axes take FrBD or Dahl";
                return Err(ParameterError::chosen("a model of its own", takes).into());
            }
        };
        let Self { fall, reference, parallel, .. } = self;
        Ok(Batch { fall, bristles, reference, parallel })
    }
}

impl<'a, T: Real, const N: usize> Batch<'a, T, N> {
    /// Bristles of one model, as many as the slices of a step have.
    ///
    /// # Errors
    ///
    /// Refuses a Stribeck curve whose exponent is neither 1 nor 2, and curves of other kinds.
    pub fn of(model: &impl Uniform<T, N>) -> Result<Self, BatchError> {
        let (fall, material) = model.material()?;
        Ok(Self::new(fall, Bristles::Shared(material)))
    }

    fn new(fall: Fall, bristles: Bristles<'a, T, N>) -> Self {
        Self { fall, bristles, reference: None, parallel: false }
    }

    /// The batch whose stiffness and damping [1/m, s/m] belong to a reference load P \[N\],
    /// whatever the normal forces are, see [there](crate#a-load-that-varies). [`Batch::reload`]
    /// changes those.
    ///
    /// # Errors
    ///
    /// Refuses a reference load that is not positive and finite.
    pub fn measured_at(self, reference_load: T) -> Result<Self, BatchError> {
        let reference_load = Named("reference_load", reference_load).positive()?;
        Ok(Self { reference: Some(reference_load), ..self })
    }

    /// A copy whose steps of more than some 8000 bristles are spread over rayon's threads, with the
    /// same bits in the results. Rayon allocates once, when its pool of threads is first used.
    #[cfg(feature = "rayon")]
    #[must_use]
    pub fn in_parallel(self) -> Self {
        Self { parallel: true, ..self }
    }

    /// Begins a passive step of length h ≥ 0 \[s\]: every bristle as a source and a damper, and the
    /// shares that [`Batch::commit`] takes.
    ///
    /// # Errors
    ///
    /// Names a slice whose length is not that of the velocities, or a duration that is negative or
    /// not finite.
    pub fn companions(
        &self,
        input: StepInput<'_, T>,
        duration: T,
        output: PassiveOutput<'_, T>,
    ) -> Result<Outcome, BatchError> {
        let inputs = [
            ("velocities", N, input.velocities),
            ("normal_forces", 1, input.normal_forces),
            ("deflections", N, &*input.deflections),
        ];
        let outputs = [
            ("shares", N, output.shares),
            ("biases", N, output.biases),
            ("dampings", N, output.dampings),
        ];
        if self.reference.is_some() {
            return self.apply(Predict(self.step::<true>(duration)?), inputs, outputs);
        }
        self.apply(Predict(self.step::<false>(duration)?), inputs, outputs)
    }

    /// Ends a passive step of length h ≥ 0 \[s\], the length that it began with: the new
    /// deflections, in place, once the mechanism has found its mean velocities.
    ///
    /// # Errors
    ///
    /// Names a slice whose length is not that of the velocities, or a duration that is negative or
    /// not finite.
    pub fn commit(
        &self,
        input: CommitInput<'_, T>,
        duration: T,
        deflections: &mut [T],
    ) -> Result<Outcome, BatchError> {
        let inputs = [
            ("velocities", N, input.velocities),
            ("shares", N, input.shares),
            ("normal_forces", 1, input.normal_forces),
        ];
        let outputs = [("deflections", N, deflections)];
        // The curve is not evaluated again; any fall will do, and one needs no code for the others.
        let batch = Self { fall: Fall::Rational, ..*self };
        if self.reference.is_some() {
            return batch.apply(Commit(self.step::<true>(duration)?), inputs, outputs);
        }
        batch.apply(Commit(self.step::<false>(duration)?), inputs, outputs)
    }

    /// The exact step of length h ≥ 0 \[s\] at held velocities: the new deflections, in place, and
    /// the friction forces averaged over the step \[N\].
    ///
    /// # Errors
    ///
    /// Names a slice whose length is not that of the velocities, or a duration that is negative or
    /// not finite.
    pub fn hold(
        &self,
        input: StepInput<'_, T>,
        duration: T,
        mean_forces: &mut [T],
    ) -> Result<Outcome, BatchError> {
        let inputs =
            [("velocities", N, input.velocities), ("normal_forces", 1, input.normal_forces)];
        let outputs = [("deflections", N, input.deflections), ("mean_forces", N, mean_forces)];
        if self.reference.is_some() {
            return self.apply(Hold(self.step::<true>(duration)?), inputs, outputs);
        }
        self.apply(Hold(self.step::<false>(duration)?), inputs, outputs)
    }

    /// Changes the normal forces of a batch that has [reference loads](Batch::measured_at), before
    /// a step whose normal forces differ from those of the last one: the new deflections, in place,
    /// and the energies that are dissipated \[J\], see
    /// [`Contact::reload`](bristle::Contact::reload).
    ///
    /// A deflection that the surface still holds stays as it is. A bristle whose load falls below
    /// what it carries slips back. One without a load, before or after, has no deflection.
    ///
    /// A normal force that is negative or not finite, before or after, makes a bristle forget: its
    /// deflection becomes zero, and its energy is not finite.
    ///
    /// ```
    /// use bristle_batch::{Batch, ReloadInput};
    /// use bristle::{Dahl, DahlParameters};
    ///
    /// let parameters = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 };
    /// let batch = Batch::of(&Dahl::new(parameters)?)?.measured_at(2.0)?; // N
    /// // Each is stuck and carries 0.2 N. Below 0.4 N of load it slips.
    /// let (mut deflections, mut dissipated) = ([1e-5; 3], [0.0; 3]);
    /// let loads =
    ///     ReloadInput { before: &[2.0; 3], after: &[8.0, 1.0, 0.2], velocities: &[0.0; 3] };
    /// let outcome = batch.reload(loads, &mut deflections, &mut dissipated)?;
    /// assert_eq!(deflections, [1e-5, 1e-5, 0.5e-5]);
    /// assert!(outcome.is_finite() && dissipated[1] == 0.0 && dissipated[2] > 0.0);
    /// # Ok::<(), bristle_batch::BatchError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Names a slice whose length is not that of the normal forces before, and refuses a batch
    /// without reference loads.
    pub fn reload(
        &self,
        input: ReloadInput<'_, T>,
        deflections: &mut [T],
        dissipated: &mut [T],
    ) -> Result<Outcome, BatchError> {
        if self.reference.is_none() {
            let takes = "a reload takes Batch::measured_at";
            return Err(ParameterError::chosen("a stiffness that follows the load", takes).into());
        }
        self.apply(
            Reload(self.step(T::zero())?),
            [
                ("before", 1, input.before),
                ("after", 1, input.after),
                ("velocities", N, input.velocities),
            ],
            [("deflections", N, deflections), ("dissipated", 1, dissipated)],
        )
    }

    fn step<const MEASURED: bool>(&self, duration: T) -> Checked<Step<T, MEASURED>> {
        let duration = Named("duration", duration).non_negative()?;
        Ok(Step { duration, reference: self.reference.unwrap_or_else(T::one) })
    }

    /// Applies an operation to slices, once all of them have the length of the first. Each has a
    /// name and a count of numbers for every bristle, 1 or N.
    fn apply<const I: usize, const O: usize>(
        &self,
        operation: impl Operation<T, N, I, O>,
        inputs: [(&'static str, usize, &[T]); I],
        outputs: [(&'static str, usize, &mut [T]); O],
    ) -> Result<Outcome, BatchError> {
        let stored = match self.bristles {
            Bristles::Shared(_) | Bristles::Own(_) => None,
            Bristles::Each(columns) => {
                Some(("static_coefficients", 1, columns.static_coefficients.len()))
            }
        };
        let read = inputs.iter().map(|(name, count, slice)| (*name, *count, slice.len()));
        let written = outputs.iter().map(|(name, count, slice)| (*name, *count, slice.len()));
        let length = same_length(read.chain(written).chain(stored))?;
        // One axis after the other; what has one number for a bristle has no other axis.
        let inputs = inputs.map(|(_, _, mut slice)| {
            [(); N].map(|()| slice.split_off(..length).unwrap_or_default())
        });
        let outputs = outputs.map(|(_, _, mut slice)| {
            [(); N].map(|()| slice.split_off_mut(..length).unwrap_or_default())
        });
        Ok(match self.bristles {
            Bristles::Shared(material) => {
                let slices = Slices { parameters: [], inputs, outputs, length };
                if material.axes.iter().all(|axis| axis.ratio == T::one()) {
                    self.choose(operation, Alike(material), slices)
                } else {
                    self.choose(operation, material, slices)
                }
            }
            Bristles::Each(columns) => {
                let parameters = columns.named().map(|(_, column)| column);
                let slices = Slices { parameters, inputs, outputs, length };
                self.choose(operation, Stored, slices)
            }
            Bristles::Own(model) => {
                let slices = Slices { parameters: [], inputs, outputs, length };
                self.run(Single { model, operation }, slices)
            }
        })
    }

    /// Chooses the fall of the curve, once for all bristles.
    fn choose<const P: usize, const I: usize, const O: usize>(
        &self,
        operation: impl Operation<T, N, I, O>,
        source: impl Source<T, N, P>,
        slices: Slices<'_, T, N, P, I, O>,
    ) -> Outcome {
        match self.fall {
            Fall::Exponential => self.run(Bound::<_, _, EXPONENTIAL> { source, operation }, slices),
            Fall::Gaussian => self.run(Bound::<_, _, GAUSSIAN> { source, operation }, slices),
            Fall::Rational => self.run(Bound::<_, _, RATIONAL> { source, operation }, slices),
        }
    }

    /// On one thread or on several.
    fn run<const P: usize, const I: usize, const O: usize>(
        &self,
        kernel: impl Kernel<T, N, P, I, O>,
        slices: Slices<'_, T, N, P, I, O>,
    ) -> Outcome {
        #[cfg(feature = "rayon")]
        if self.parallel {
            return parallel::run(kernel, slices);
        }
        drive::run(kernel, slices)
    }
}

/// The one number of bristles of some named slices, which have so many numbers for each. An error
/// names the first slice that differs.
fn same_length(
    slices: impl IntoIterator<Item = (&'static str, usize, usize)>,
) -> Result<usize, BatchError> {
    let mut slices = slices.into_iter();
    let Some((other, count, length)) = slices.next() else { return Ok(0) };
    let bristles = length.checked_div(count).unwrap_or_default();
    if bristles * count != length {
        return Err(BatchError::Axes { name: other, length, axes: count });
    }
    match slices.find(|&(_, count, length)| length != bristles * count) {
        Some((name, count, length)) => {
            Err(BatchError::Length { name, length, other, expected: bristles * count })
        }
        None => Ok(bristles),
    }
}
