//! The arithmetic of one bristle: what a step reads, and what it writes.
//!
//! Every column has N axes. What has one number for a bristle, such as its normal force, is the
//! first axis of a column whose other axes are absent. Loops over axes are plain: the compiler
//! unrolls them and then vectorises the loop over the bristles, which it does not do for iterators.
#![allow(clippy::needless_range_loop, reason = "plain loops are unrolled, iterators are not")]

use super::material::{Material, OwnModel, Source};
use super::real::{self, Real};
use bristle::scalar::lit;
use bristle::{Affine, LoadChange, Surface};

/// What a step does to one bristle of N axes: from P parameters, I inputs and the O outputs before
/// it.
pub(super) trait Kernel<T, const N: usize, const P: usize, const I: usize, const O: usize>:
    Copy + Send + Sync
{
    /// Whether the step depends on the outputs before it. Reading them for nothing costs bandwidth.
    const READS_OUTPUTS: bool;
    /// The O outputs after the step.
    fn apply(&self, parameters: [T; P], inputs: [[T; N]; I], before: [[T; N]; O]) -> [[T; N]; O];
}

/// An operation on bristles with parameters from a source and a curve that falls in one way, a
/// [`Fall`](super::Fall) as a number: chosen before the loop over the bristles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bound<S, K, const FALL: u8> {
    pub(super) source: S,
    pub(super) operation: K,
}

impl<T, S, K, const FALL: u8, const N: usize, const P: usize, const I: usize, const O: usize>
    Kernel<T, N, P, I, O> for Bound<S, K, FALL>
where
    S: Source<T, N, P>,
    K: Operation<T, N, I, O>,
{
    const READS_OUTPUTS: bool = K::READS_OUTPUTS;

    #[inline(always)]
    fn apply(&self, parameters: [T; P], inputs: [[T; N]; I], before: [[T; N]; O]) -> [[T; N]; O] {
        self.operation.apply::<FALL>(&self.source.material(parameters), inputs, before)
    }
}

/// An operation on bristles of a model of its own, one by one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Single<'a, T, K> {
    pub(super) model: OwnModel<'a, T>,
    pub(super) operation: K,
}

impl<T, K, const N: usize, const I: usize, const O: usize> Kernel<T, N, 0, I, O>
    for Single<'_, T, K>
where
    T: Real,
    K: Operation<T, N, I, O>,
{
    const READS_OUTPUTS: bool = true;

    fn apply(&self, _: [T; 0], inputs: [[T; N]; I], before: [[T; N]; O]) -> [[T; N]; O] {
        self.operation.single(&self.model, inputs.map(only), before.map(only)).map(alone)
    }
}

/// A step of one bristle whose material is known.
pub(super) trait Operation<T, const N: usize, const I: usize, const O: usize>:
    Copy + Send + Sync
{
    /// Whether the step depends on the outputs before it.
    const READS_OUTPUTS: bool = true;
    /// The O outputs after the step.
    fn apply<const FALL: u8>(
        &self,
        material: &Material<T, N>,
        inputs: [[T; N]; I],
        before: [[T; N]; O],
    ) -> [[T; N]; O];
    /// The same of one axis, with the coefficients of a model of its own.
    fn single(&self, model: &OwnModel<'_, T>, inputs: [T; I], before: [T; O]) -> [T; O];
}

/// The one number of a bristle in a column whose other axes are absent.
#[inline(always)]
fn only<T: Real, const N: usize>(column: [T; N]) -> T {
    column.first().copied().unwrap_or_else(T::nan)
}

/// The column that [`only`] reads.
#[inline(always)]
fn alone<T: Real, const N: usize>(value: T) -> [T; N] {
    core::array::from_fn(|axis| if axis == 0 { value } else { T::zero() })
}

/// The normal force; NaN for a negative one.
#[inline(always)]
fn load<T: Real>(normal_force: T) -> T {
    if normal_force >= T::zero() { normal_force } else { T::nan() }
}

/// The length of a step, and the reference load of its bristles if that is not the normal force.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step<T, const MEASURED: bool> {
    pub(super) duration: T,
    pub(super) reference: T,
}

impl<T: Real, const MEASURED: bool> Step<T, MEASURED> {
    /// Reference load P and friction scale s; not a number for a normal force that is none.
    #[inline(always)]
    fn loaded(&self, normal_force: T) -> (T, T) {
        let load = load(normal_force);
        if MEASURED { (self.reference, load / self.reference) } else { (load, T::one()) }
    }
}

/// A quotient; without a load nothing over nothing, which is nothing.
#[inline(always)]
fn quotient<T: Real, const MEASURED: bool>(numerator: T, denominator: T) -> T {
    if MEASURED && denominator == T::zero() { T::zero() } else { numerator / denominator }
}

/// The coefficients of a model at a velocity, for friction of a scale. Without friction all are
/// zero.
fn affine<T: Real>(model: &OwnModel<'_, T>, velocity: T, scale: T, deflection: T) -> Affine<T> {
    if scale == T::zero() {
        return Affine::none();
    }
    model.object.affine(Surface::scaled(velocity, scale), deflection)
}

/// Whether a bristle touches before and after a change of the load. Not for NaN.
#[inline(always)]
fn touches<T: Real>(from: T, to: T) -> bool {
    from > T::zero() && to > T::zero() && from.is_finite() && to.is_finite()
}

/// A change of the load under a stiffness that stays: normal forces before and after, predicted
/// velocity → deflection, in place, and the energy that leaves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reload<T>(pub(super) Step<T, true>);

impl<T: Real> Reload<T> {
    /// The energy that leaves, of the ½ P Σ K z² that springs have under a load. NaN unless both
    /// loads are finite.
    #[inline(always)]
    fn left([from, to]: [T; 2], kept: T, stored: T) -> T {
        let (zero, one) = (T::zero(), T::one());
        let stored = if from == zero { zero } else { stored };
        stored * ((one - kept) * (one + kept)) + (zero * from + zero * to)
    }
}

impl<T: Real, const N: usize> Operation<T, N, 3, 2> for Reload<T> {
    #[inline(always)]
    fn apply<const FALL: u8>(
        &self,
        material: &Material<T, N>,
        [before, after, velocity]: [[T; N]; 3],
        [mut deflection, _]: [[T; N]; 2],
    ) -> [[T; N]; 2] {
        let (zero, one) = (T::zero(), T::one());
        let (from, to) = (load(only(before)), load(only(after)));
        let (reference, scale) = self.0.loaded(to);
        // The largest coefficient up to the speed; of a curve that falls and rises, at an end.
        let (_, speed) = material.speeds(velocity);
        let (rest, moving) = (material.most(zero), material.coefficient::<FALL>(speed));
        let holds = scale * if moving <= rest { rest } else { moving };
        let (mut square, mut largest, mut stored) = (zero, zero, zero);
        for i in 0..N {
            let (axis, z) = (&material.axes[i], deflection[i]);
            let carried = axis.stiffness * z;
            let share = carried.size() / (holds * axis.ratio);
            square += share * share;
            largest = if share <= largest { largest } else { share };
            stored += lit::<T>(0.5) * reference * (carried * z);
        }
        // One axis needs no root, and loses no small number.
        let utilisation = if N > 1 && material.ellipsoid { square.sqrt() } else { largest };
        let (held, share) = (one / utilisation, to / from);
        let slips = if held <= share { share } else { held };
        let kept = if to >= from || utilisation <= one { one } else { slips };
        let kept = if touches(from, to) { kept } else { zero };
        deflection.iter_mut().for_each(|z| *z *= kept);
        [deflection, alone(Self::left([from, to], kept, stored))]
    }

    fn single(
        &self,
        model: &OwnModel<'_, T>,
        [before, after, velocity]: [T; 3],
        [z, _]: [T; 2],
    ) -> [T; 2] {
        let (from, to) = (load(before), load(after));
        let (reference, scale) = self.0.loaded(to);
        let carried = model.stiffness * z;
        let surface = Surface::scaled(velocity, scale);
        let kept = if touches(from, to) {
            let change = LoadChange { before: from, after: to };
            model.object.kept(change, surface, carried)
        } else {
            T::zero()
        };
        let stored = lit::<T>(0.5) * reference * (carried * z);
        [z * kept, Self::left([from, to], kept, stored)]
    }
}

/// The beginning of a midpoint step: velocity, normal force, deflection → share, bias, damping.
#[derive(Debug, Clone, Copy)]
pub(super) struct Predict<T, const MEASURED: bool>(pub(super) Step<T, MEASURED>);

impl<T: Real, const N: usize, const MEASURED: bool> Operation<T, N, 3, 3> for Predict<T, MEASURED> {
    const READS_OUTPUTS: bool = false;

    #[inline(always)]
    fn apply<const FALL: u8>(
        &self,
        material: &Material<T, N>,
        [velocity, normal_force, deflection]: [[T; N]; 3],
        [mut shares, mut biases, mut dampings]: [[T; N]; 3],
    ) -> [[T; N]; 3] {
        let (weighted, speed) = material.speeds(velocity);
        let (load, scale) = self.0.loaded(only(normal_force));
        let mu = material.coefficient::<FALL>(speed) * scale;
        for i in 0..N {
            let axis = &material.axes[i];
            let stiffening = lit::<T>(0.5) * self.0.duration * axis.stiffness + axis.damping;
            let mu = axis.ratio * axis.ratio * mu;
            shares[i] = quotient::<T, MEASURED>(mu, mu + stiffening * weighted);
            let carried = load * shares[i];
            biases[i] = carried * (axis.stiffness * deflection[i]);
            dampings[i] = carried * stiffening;
        }
        [shares, biases, dampings]
    }

    /// The end of the step needs the predicted velocity: it is what this writes for the share.
    fn single(
        &self,
        model: &OwnModel<'_, T>,
        [velocity, normal_force, deflection]: [T; 3],
        _: [T; 3],
    ) -> [T; 3] {
        let (load, scale) = self.0.loaded(normal_force);
        let affine = affine(model, velocity, scale, deflection);
        let half = lit::<T>(0.5) * self.0.duration;
        let slack = T::one() / (T::one() + half * affine.relaxation);
        let stiffness = affine.stiffness * slack;
        let damping = stiffness * half * affine.drive + affine.damping;
        // A rounding, where the stiffness is negative.
        let damping = if damping < T::zero() { T::zero() } else { damping };
        [velocity, load * (stiffness * deflection), load * damping]
    }
}

/// The end of a midpoint step: mean velocity, share, normal force → deflection, in place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Commit<T, const MEASURED: bool>(pub(super) Step<T, MEASURED>);

impl<T: Real, const N: usize, const MEASURED: bool> Operation<T, N, 3, 1> for Commit<T, MEASURED> {
    #[inline(always)]
    fn apply<const FALL: u8>(
        &self,
        material: &Material<T, N>,
        [velocity, share, normal_force]: [[T; N]; 3],
        [mut deflection]: [[T; N]; 1],
    ) -> [[T; N]; 1] {
        let (zero, one) = (T::zero(), T::one());
        let (_, scale) = self.0.loaded(only(normal_force));
        // At least ‖v̄‖, without a root.
        let speed = velocity.iter().fold(zero, |sum, v| sum + v.size());
        let most = material.most(speed) * scale;
        for i in 0..N {
            let (axis, z) = (&material.axes[i], deflection[i]);
            let stiffness = self.0.duration * axis.stiffness;
            // h σ0/κ, at most 2. Without damping κ is zero for a step of no length.
            let loss = if stiffness > zero {
                stiffness / (lit::<T>(0.5) * stiffness + axis.damping)
            } else {
                zero
            };
            let after =
                z + (self.0.duration * share[i] * velocity[i] - loss * (one - share[i]) * z);
            let (size, most) = (z.size(), most * axis.ratio * (one / axis.stiffness));
            // The limit at an infinite velocity, infinite or 0·∞, cuts nothing.
            let limit = if size > most { size } else { most };
            // A minimum and a maximum, not a choice among three: one instruction each.
            let below = if after > limit { limit } else { after };
            deflection[i] = if below < -limit { -limit } else { below };
        }
        [deflection]
    }

    fn single(
        &self,
        model: &OwnModel<'_, T>,
        [velocity, predicted, normal_force]: [T; 3],
        [z]: [T; 1],
    ) -> [T; 1] {
        let (_, scale) = self.0.loaded(normal_force);
        let affine = affine(model, predicted, scale, z);
        let pace =
            self.0.duration / (T::one() + lit::<T>(0.5) * self.0.duration * affine.relaxation);
        let after = z + pace * (affine.drive * velocity - affine.relaxation * z);
        // What is stationary at the predicted velocity stays, too.
        let surface = Surface::scaled(predicted, scale);
        let sizes = [z.size(), model.limit * scale, model.object.stationary(surface).size()];
        let limit =
            sizes.into_iter().fold(T::zero(), |most, size| if size > most { size } else { most });
        let below = if after > limit { limit } else { after };
        [if below < -limit { -limit } else { below }]
    }
}

/// The exact step at a held velocity: velocity, normal force → deflection, in place, and mean
/// force.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hold<T, const MEASURED: bool>(pub(super) Step<T, MEASURED>);

impl<T: Real, const N: usize, const MEASURED: bool> Operation<T, N, 2, 2> for Hold<T, MEASURED> {
    #[inline(always)]
    fn apply<const FALL: u8>(
        &self,
        material: &Material<T, N>,
        [velocity, normal_force]: [[T; N]; 2],
        [mut deflection, mut force]: [[T; N]; 2],
    ) -> [[T; N]; 2] {
        let one = T::one();
        let (weighted, speed) = material.speeds(velocity);
        let (load, scale) = self.0.loaded(only(normal_force));
        let mu = material.coefficient::<FALL>(speed) * scale;
        for i in 0..N {
            let (axis, v, z) = (&material.axes[i], velocity[i], deflection[i]);
            let mu = axis.ratio * axis.ratio * mu;
            let inverse = quotient::<T, MEASURED>(one, axis.damping * weighted + mu);
            let drive = mu * inverse;
            // x = λh
            let exponent = self.0.duration * axis.stiffness * weighted * inverse;
            let decay = real::decay(-exponent);
            // 1 − φ1 = x φ2. Near x = 0 the polynomial, for there 1 − φ1 cancels.
            let far = one - decay.loss / exponent;
            let rest = if decay.is_near { exponent * decay.curvature } else { far };
            // r v/λ, the deflection in steady sliding.
            let steady = axis.direction::<N>(v, weighted) * (mu * (one / axis.stiffness));
            let missing = steady - z;
            let mean = z + rest * missing;
            deflection[i] = z + decay.loss * missing;
            force[i] = load * drive * (axis.stiffness * mean + axis.damping * v);
        }
        [deflection, force]
    }

    fn single(
        &self,
        model: &OwnModel<'_, T>,
        [velocity, normal_force]: [T; 2],
        [z, _]: [T; 2],
    ) -> [T; 2] {
        let (load, scale) = self.0.loaded(normal_force);
        if scale == T::zero() {
            return [z, T::zero()];
        }
        let (deflection, coefficient) =
            model.object.hold(Surface::scaled(velocity, scale), z, self.0.duration);
        [deflection, load * coefficient]
    }
}
