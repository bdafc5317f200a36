//! Steps of many bristles at once: a granular bed, a brush of seals, a tyre of a million contacts.
//!
//! Plain slices in, slices out, one number for each bristle: every bristle has a velocity, a normal force
//! and a deflection of its own; the parameters are shared ([`Batch::of`]) or of each ([`Batch::of_each`]). Nothing is
//! allocated. For [`FrBd`](crate::FrBd) with a Coulomb, Stribeck (δ = 1 or 2) or rational Stribeck curve and a spring or Kelvin–Voigt
//! bristle, and for [`Dahl`](crate::Dahl), in `f32` and `f64`.
//!
//! # The passive step
//!
//! [`Batch::companions`] makes every bristle a source and a damper over a step, as
//! [`Companion`](crate::companion::Companion) does, here by the implicit midpoint rule with the coefficients frozen at a
//! predicted velocity v\*. A bristle of stiffness σ0 and damping σ1 is then a damper κ in series
//! with the surface's μ/|v\*|, and one share c does for everything:
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
//! | v\*, v̄ | velocity predicted for its middle, and mean velocity | m/s |
//! | z₀, z₁, z̄ | deflection before and after it, and their mean | m |
//! | p, F̄ | normal force, and mean friction force | N |
//! | μ | friction curve | – |
//! | σ0, σ1 | normalised micro-stiffness and micro-damping | 1/m, s/m |
//! | κ | damping of a bristle over a step | s/m |
//! | c | share of the velocity that deflects the bristle: 1 at rest, 0 in fast sliding | – |
//! | λ, r | relaxation rate σ0|v\*|/g and drive μ/g, g = σ1|v\*| + μ | 1/s, – |
//!
//! The mechanism solves for its mean velocities, and [`Batch::commit`] ends the step: one
//! exponential a step, that of the curve. The energy W = ½ p σ0 z² obeys
//!
//! h F̄ v̄ = W₁ − W₀ + D,  D = h p (σ0 λ z̄² + σ1 r v̄²) ≥ 0
//!
//! for every h, z₀, v\* and v̄: no step gives energy that was not stored. Positions, velocities and
//! deflections are of second order in h if v\* is that of the middle up to O(h²) (see
//! [`VelocityHistory`](crate::companion::VelocityHistory)); the difference to [`Companion`](crate::companion::Companion)'s exponential step is of third.
//! Where λh > 2 the deflection swings about its stationary value and decays slowly, by (2 − λh)/(2 + λh) a step, though it stays within
//! its limit; there take [`Batch::hold`], a shorter step, or the scalar one. With damping λ is at most σ0/(σ1 + σ2).
//!
//! A deflection that a mispredicted velocity would take beyond its limit is cut to (μ_s + σ2|v̄|)/σ0, or to
//! its size before the step if that is larger, which only removes energy.
//!
//! # The exact step
//!
//! [`Batch::hold`] is [`Contact::hold`](crate::Contact::hold) for all: the velocity is held, and deflection and mean force are exact,
//!
//! z₁ = e⁻ˣ z₀ + (1 − e⁻ˣ) z_ss,  z̄ = φ1 z₀ + (1 − φ1) z_ss,  F̄ = p r (σ0 z̄ + σ1 v),
//!
//! x = λh, φ1 = (1 − e⁻ˣ)/x, z_ss = sgn(v) μ(v)/σ0: two exponentials a step. See there for what such a step is good for.
//!
//! ```
//! use bristle::batch::{Batch, PassiveOutput, CommitInput, PassiveInput};
//! use bristle::{FrBd, paper};
//! use bristle::curve::Stribeck;
//! use bristle::rheology::KelvinVoigt;
//!
//! let model = FrBd::new(Stribeck::new(paper::STICK_SLIP_CURVE)?, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?);
//! let grains = Batch::of(&model)?;
//! // Three grains on a belt of 0.1 m/s, under loads of their own [N].
//! let (mass, h, belt, normal_forces) = (0.1, 1e-3, 0.1, [0.5, 1.0, 2.0]);
//! let (mut v, mut z) = ([0.0; 3], [0.0; 3]); // m/s, m
//! let (mut shares, mut biases, mut dampings) = ([0.0; 3], [0.0; 3], [0.0; 3]);
//! for _ in 0..100 {
//!     let slip = v.map(|v| v - belt); // predicted by the velocity before the step
//!     let predicted = PassiveInput { velocities: &slip, normal_forces: &normal_forces, deflections: &z };
//!     let dampers = PassiveOutput { shares: &mut shares, biases: &mut biases, dampings: &mut dampings };
//!     let begun = grains.companions(predicted, h, dampers)?;
//!     // m (v₁ − v)/h = −F̄ with v₁ = 2 v̄ − v
//!     let mut mean = [0.0; 3];
//!     for i in 0..3 {
//!         mean[i] = (2.0 * mass / h * slip[i] - biases[i]) / (2.0 * mass / h + dampings[i]);
//!         v[i] = 2.0 * (mean[i] + belt) - v[i];
//!     }
//!     let ended = grains.commit(CommitInput { shares: &shares, velocities: &mean }, h, &mut z)?;
//!     assert!(begun.is_finite() && ended.is_finite());
//! }
//! assert!(v.iter().all(|v| (v - belt).abs() < 1e-3)); // all carried along
//! # Ok::<(), bristle::batch::BatchError>(())
//! ```
//!
//! # Numbers that are none
//!
//! A bristle never touches another. One that is not finite is counted in the step's [`Outcome`], which must be looked at:
//!
//! | of a bristle | gives |
//! |---|---|
//! | a velocity that is NaN or infinite | NaN everywhere, or the same in the deflection that ends a passive step |
//! | a deflection that is NaN or infinite | the same in force and deflection |
//! | a normal force that is NaN or infinite | the same in the force; the deflection goes on |
//! | a negative normal force | NaN in the force, for surfaces do not pull; the deflection goes on |
//! | no normal force | no force; the deflection goes on |
//!
//! Slices that differ in length, and parameters or durations out of range, are refused by name before anything
//! is written.
//!
//! # The same bits
//!
//! Every bristle takes the same additions, multiplications and divisions, in the same order, wherever it stands in
//! a batch of any length: the last ones that fill no vector are filled up with ones. No operation is fused
//! (`mul_add`), and the exponential is one of our own, so that the bits are also the same for every
//! instruction set, with the features `simd` and `rayon` and without, for shared parameters and those of each. What is not
//! promised are the sign and payload of a NaN, and targets that compute wider than they store (x87).
//!
//! The exponential is right to two units in the last place and zero where it would be below the
//! smallest normal number. Results agree with the scalar steps to some roundings.
//!
//! # Speed
//!
//! The code is written for the compiler to vectorise. With the feature `simd` it is compiled for SSE2, AVX2 and AVX-512
//! (NEON on ARM) and the processor is asked at run time; without, for what the build's target has (SSE2, on x86-64). The feature
//! `rayon` adds `Batch::in_parallel`.
//!
//! One thread, 4096 bristles, FrBD with δ = 2, on a Xeon with AVX-512; times over that of the
//! platform's `exp` on as many numbers (3.9 ns in `f64`, 1.9 ns in `f32`), and the scalar steps' over the batch's:
//!
//! | | AVX2, `f64` | `f32` | AVX-512, `f64` | `f32` |
//! |---|---|---|---|---|
//! | passive step, both halves, over `exp` | 0.97 | 0.86 | 0.67 | 0.67 |
//! | exact step over `exp` | 1.8 | 1.5 | 1.4 | 1.0 |
//! | scalar passive step over it | 4.6 | 9.0 | 7.2 | 11 |
//! | scalar exact step over it | 2.3 | 4.7 | 3.1 | 6.8 |
//!
//! ```sh
//! RUSTFLAGS="-C target-feature=+avx2" cargo bench --bench batch
//! cargo bench --bench batch --features simd,rayon # the widest vectors there are, and threads
//! ```

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

use core::marker::PhantomData;

use crate::parameter;
use drive::{Kernel, Slices};
use kernel::{Commit, Hold, Operation, Predict};
use material::{Exponential, Falling, Gaussian, Material, Rational, Source, Stored};

/// What the bristles are made of.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Bristles<'a, T> {
    /// All the same.
    Same(Material<T>),
    /// Each its own, checked, and of one length.
    Each(Columns<'a, T>),
}

/// Many bristles, of one model or each with parameters of its own.
///
/// It holds parameters, no state: one serves any number of bristles (or as many as it has parameters
/// for), and any number of steps.
///
/// ```
/// use bristle::batch::{Batch, HeldInput, HeldOutput};
/// use bristle::{Dahl, DahlParameters};
///
/// let model = Dahl::new(DahlParameters { dynamic_coefficient: 0.5_f32, micro_stiffness: 1e4 })?;
/// let batch = Batch::of(&model)?;
/// let (mut deflections, mut mean_forces) = ([0.0; 2], [0.0; 2]);
/// let held = HeldInput { velocities: &[0.1, f32::NAN], normal_forces: &[20.0, 20.0] };
/// let moved = HeldOutput { deflections: &mut deflections, mean_forces: &mut mean_forces };
/// let outcome = batch.hold(held, 1e-3, moved)?; // s
/// assert!(mean_forces[0] > 0.0 && mean_forces[0] < 10.0);
/// assert_eq!((outcome.not_finite, outcome.first), (1, Some(1)));
/// # Ok::<(), bristle::batch::BatchError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Batch<'a, T> {
    fall: Fall,
    bristles: Bristles<'a, T>,
    #[cfg(feature = "rayon")]
    parallel: bool,
}

/// What a passive step has to know of every bristle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassiveInput<'a, T> {
    /// Velocities v\* predicted for the middle of the step [m/s].
    pub velocities: &'a [T],
    /// Normal forces p \[N\].
    pub normal_forces: &'a [T],
    /// Deflections z₀ before the step \[m\].
    pub deflections: &'a [T],
}

/// What a passive step makes of every bristle: F̄ = bias + damping·v̄.
#[derive(Debug, PartialEq)]
pub struct PassiveOutput<'a, T> {
    /// Shares c \[–\] of the velocity that deflect the bristles, for [`Batch::commit`].
    pub shares: &'a mut [T],
    /// Mean friction forces at v̄ = 0 \[N\].
    pub biases: &'a mut [T],
    /// Their increase with the mean velocity [N s/m], zero or positive.
    pub dampings: &'a mut [T],
}

/// What ends a passive step of every bristle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommitInput<'a, T> {
    /// Shares c \[–\], as the beginning of the step left them.
    pub shares: &'a [T],
    /// Mean velocities v̄ over the step [m/s].
    pub velocities: &'a [T],
}

/// What an exact step has to know of every bristle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldInput<'a, T> {
    /// Velocities v, held over the step [m/s].
    pub velocities: &'a [T],
    /// Normal forces p \[N\].
    pub normal_forces: &'a [T],
}

/// What an exact step changes of every bristle.
#[derive(Debug, PartialEq)]
pub struct HeldOutput<'a, T> {
    /// Deflections \[m\]: before the step, and then after it.
    pub deflections: &'a mut [T],
    /// Friction forces averaged over the step \[N\].
    pub mean_forces: &'a mut [T],
}

impl<'a, T: Real> Batch<'a, T> {
    /// Bristles of one model, as many as the slices of a step have.
    ///
    /// # Errors
    ///
    /// Refuses a Stribeck curve whose exponent is neither 1 nor 2.
    pub fn of(model: &impl Uniform<T>) -> Result<Self, BatchError> {
        let (fall, material) = model.material()?;
        Ok(Self {
            fall,
            bristles: Bristles::Same(material),
            #[cfg(feature = "rayon")]
            parallel: false,
        })
    }

    /// Bristles with parameters of their own: FrBD with a Kelvin–Voigt bristle and a curve that falls in
    /// one way for all. Looks at every parameter, once.
    ///
    /// ```
    /// use bristle::batch::{Batch, Columns, Fall};
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
    /// Names the parameter that is out of its range and its index, or the slice whose length is not
    /// that of the others.
    pub fn of_each(fall: Fall, columns: Columns<'a, T>) -> Result<Self, BatchError> {
        let Columns {
            static_coefficients: first,
            dynamic_coefficients,
            stribeck_velocities,
            viscous_frictions,
            micro_stiffnesses,
            micro_dampings,
        } = columns;
        let reference = ("static_coefficients", first.len());
        same_length(reference, "dynamic_coefficients", dynamic_coefficients)?;
        same_length(reference, "stribeck_velocities", stribeck_velocities)?;
        same_length(reference, "viscous_frictions", viscous_frictions)?;
        same_length(reference, "micro_stiffnesses", micro_stiffnesses)?;
        same_length(reference, "micro_dampings", micro_dampings)?;
        (0..first.len()).try_for_each(|index| columns.check(index))?;
        Ok(Self {
            fall,
            bristles: Bristles::Each(columns),
            #[cfg(feature = "rayon")]
            parallel: false,
        })
    }

    /// The same, with the steps of more than some 8000 bristles spread over rayon's threads. The bits of the results
    /// stay the same. Once, when its pool of threads is first used, rayon allocates.
    #[cfg(feature = "rayon")]
    #[must_use]
    pub fn in_parallel(self) -> Self {
        Self { parallel: true, ..self }
    }

    /// Begins a passive step of length h ≥ 0 \[s\]: every bristle as a source and a damper, and the shares that
    /// [`Batch::commit`] takes.
    ///
    /// # Errors
    ///
    /// Names a slice whose length is not that of the velocities, or a duration that is negative or not finite.
    pub fn companions(
        &self,
        predicted: PassiveInput<'_, T>,
        duration: T,
        dampers: PassiveOutput<'_, T>,
    ) -> Result<Outcome, BatchError> {
        let duration = parameter::non_negative("duration", duration)?;
        let PassiveInput { velocities, normal_forces, deflections } = predicted;
        let PassiveOutput { shares, biases, dampings } = dampers;
        let reference = ("velocities", velocities.len());
        same_length(reference, "normal_forces", normal_forces)?;
        same_length(reference, "deflections", deflections)?;
        same_length(reference, "shares", shares)?;
        same_length(reference, "biases", biases)?;
        same_length(reference, "dampings", dampings)?;
        let inputs = [velocities, normal_forces, deflections];
        self.apply(Predict { duration }, inputs, [shares, biases, dampings], reference)
    }

    /// Ends a passive step of length h ≥ 0 \[s\], the one it began with: the new deflections, in place, once the
    /// mechanism has found its mean velocities.
    ///
    /// # Errors
    ///
    /// Names a slice whose length is not that of the velocities, or a duration that is negative or not finite.
    pub fn commit(
        &self,
        found: CommitInput<'_, T>,
        duration: T,
        deflections: &mut [T],
    ) -> Result<Outcome, BatchError> {
        let duration = parameter::non_negative("duration", duration)?;
        let CommitInput { shares, velocities } = found;
        let reference = ("velocities", velocities.len());
        same_length(reference, "shares", shares)?;
        same_length(reference, "deflections", deflections)?;
        // The curve is not asked again.
        let batch = Self { fall: Fall::Rational, ..*self };
        batch.apply(Commit { duration }, [shares, velocities], [deflections], reference)
    }

    /// The exact step of length h ≥ 0 \[s\] at held velocities: the new deflections, in place, and the mean forces.
    ///
    /// # Errors
    ///
    /// Names a slice whose length is not that of the velocities, or a duration that is negative or not finite.
    pub fn hold(
        &self,
        held: HeldInput<'_, T>,
        duration: T,
        moved: HeldOutput<'_, T>,
    ) -> Result<Outcome, BatchError> {
        let duration = parameter::non_negative("duration", duration)?;
        let HeldInput { velocities, normal_forces } = held;
        let HeldOutput { deflections, mean_forces } = moved;
        let reference = ("velocities", velocities.len());
        same_length(reference, "normal_forces", normal_forces)?;
        same_length(reference, "deflections", deflections)?;
        same_length(reference, "mean_forces", mean_forces)?;
        let inputs = [velocities, normal_forces];
        self.apply(Hold { duration }, inputs, [deflections, mean_forces], reference)
    }

    /// Applies an operation to slices of one length, which is that of the `reference`.
    fn apply<const I: usize, const O: usize>(
        &self,
        operation: impl Operation<T, I, O>,
        inputs: [&[T]; I],
        outputs: [&mut [T]; O],
        reference: (&'static str, usize),
    ) -> Result<Outcome, BatchError> {
        let length = reference.1;
        match self.bristles {
            Bristles::Same(material) => {
                let slices = Slices { parameters: [], inputs, outputs, length };
                Ok(self.choose(operation, material, slices))
            }
            Bristles::Each(columns) => {
                same_length(reference, "static_coefficients", columns.static_coefficients)?;
                let parameters = columns.in_order();
                let slices = Slices { parameters, inputs, outputs, length };
                Ok(self.choose(operation, Stored, slices))
            }
        }
    }

    /// Chooses the fall of the curve, once for all bristles.
    fn choose<const P: usize, const I: usize, const O: usize>(
        &self,
        operation: impl Operation<T, I, O>,
        source: impl Source<T, P>,
        slices: Slices<'_, T, P, I, O>,
    ) -> Outcome {
        match self.fall {
            Fall::Exponential => {
                self.run(Kernel { fall: PhantomData::<Exponential>, source, operation }, slices)
            }
            Fall::Gaussian => {
                self.run(Kernel { fall: PhantomData::<Gaussian>, source, operation }, slices)
            }
            Fall::Rational => {
                self.run(Kernel { fall: PhantomData::<Rational>, source, operation }, slices)
            }
        }
    }

    /// On one thread or on several.
    fn run<
        F: Falling<T>,
        S: Source<T, P>,
        K: Operation<T, I, O>,
        const P: usize,
        const I: usize,
        const O: usize,
    >(
        &self,
        kernel: Kernel<F, S, K>,
        slices: Slices<'_, T, P, I, O>,
    ) -> Outcome {
        #[cfg(feature = "rayon")]
        if self.parallel {
            return parallel::run(kernel, slices);
        }
        drive::run(kernel, slices)
    }
}

/// Refuses a slice whose length is not that of another, which is given by its name and length.
fn same_length<T>(
    (other, expected): (&'static str, usize),
    name: &'static str,
    slice: &[T],
) -> Result<(), BatchError> {
    if slice.len() == expected {
        Ok(())
    } else {
        Err(BatchError::Length { name, length: slice.len(), other, expected })
    }
}
