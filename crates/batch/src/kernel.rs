//! The arithmetic of one bristle: what a step reads, and what it writes.
//!
//! Every column has N axes. What has one number for a bristle, such as its normal force, is the
//! first axis of a column whose other axes are absent. Loops over axes are plain: the compiler
//! unrolls them and then vectorises the loop over the bristles, which it does not do for iterators.
#![allow(clippy::needless_range_loop, reason = "plain loops are unrolled, iterators are not")]

use super::material::{Material, Source};
use super::real::{self, Real};
use bristle::scalar::{lit, nan};

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
}

/// The one number of a bristle in a column whose other axes are absent.
#[inline(always)]
fn only<T: Real, const N: usize>(column: [T; N]) -> T {
    column.first().copied().unwrap_or_else(nan)
}

/// The column that [`only`] reads.
#[inline(always)]
fn alone<T: Real, const N: usize>(value: T) -> [T; N] {
    let mut column = [T::zero(); N];
    if let Some(first) = column.first_mut() {
        *first = value;
    }
    column
}

/// The normal force; NaN for a negative one.
#[inline(always)]
fn load<T: Real>(normal_force: T) -> T {
    if normal_force >= T::zero() { normal_force } else { nan() }
}

/// A change of the load: normal forces before and after → deflection, in place, and the energy that
/// leaves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reload;

impl<T: Real, const N: usize> Operation<T, N, 2, 2> for Reload {
    #[inline(always)]
    fn apply<const FALL: u8>(
        &self,
        material: &Material<T, N>,
        [before, after]: [[T; N]; 2],
        [mut deflection, _]: [[T; N]; 2],
    ) -> [[T; N]; 2] {
        let (zero, one) = (T::zero(), T::one());
        let (from, to) = (load(only(before)), load(only(after)));
        let rises = to > from;
        let (kept, lost) =
            if rises { (from / to, (to - from) / to) } else { (one, (from - to) / from) };
        // Not for NaN.
        let touches = from > zero && to > zero && from.is_finite() && to.is_finite();
        let (kept, lost) = if touches { (kept, lost) } else { (zero, one) };
        // NaN unless the load is finite.
        let mut left = zero * to;
        for (axis, z) in material.axes.iter().zip(&mut deflection) {
            let stored = lit::<T>(0.5) * from * axis.stiffness * *z * *z;
            left = lost * stored + left;
            *z *= kept;
        }
        [deflection, alone(left)]
    }
}

/// The beginning of a midpoint step: velocity, normal force, deflection → share, bias, damping.
#[derive(Debug, Clone, Copy)]
pub(super) struct Predict<T> {
    pub(super) duration: T,
}

impl<T: Real, const N: usize> Operation<T, N, 3, 3> for Predict<T> {
    const READS_OUTPUTS: bool = false;

    #[inline(always)]
    fn apply<const FALL: u8>(
        &self,
        material: &Material<T, N>,
        [velocity, normal_force, deflection]: [[T; N]; 3],
        [mut shares, mut biases, mut dampings]: [[T; N]; 3],
    ) -> [[T; N]; 3] {
        let (weighted, speed) = material.speeds(velocity);
        let mu = material.coefficient::<FALL>(speed);
        let load = load(only(normal_force));
        for i in 0..N {
            let axis = &material.axes[i];
            let stiffening = lit::<T>(0.5) * self.duration * axis.stiffness + axis.damping;
            let mu = axis.square() * mu;
            shares[i] = mu / (mu + stiffening * weighted);
            let carried = load * shares[i];
            biases[i] = carried * (axis.stiffness * deflection[i]);
            dampings[i] = carried * stiffening;
        }
        [shares, biases, dampings]
    }
}

/// The end of a midpoint step: mean velocity, share → deflection, in place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Commit<T> {
    pub(super) duration: T,
}

impl<T: Real, const N: usize> Operation<T, N, 2, 1> for Commit<T> {
    #[inline(always)]
    fn apply<const FALL: u8>(
        &self,
        material: &Material<T, N>,
        [velocity, share]: [[T; N]; 2],
        [mut deflection]: [[T; N]; 1],
    ) -> [[T; N]; 1] {
        let (zero, one) = (T::zero(), T::one());
        // At least ‖v̄‖, without a root.
        let speed = velocity.iter().fold(zero, |sum, v| sum + v.size());
        let most = material.most(speed);
        for i in 0..N {
            let (axis, z) = (&material.axes[i], deflection[i]);
            let stiffness = self.duration * axis.stiffness;
            // h σ0/κ, at most 2. Without damping κ is zero for a step of no length.
            let loss = if stiffness > zero {
                stiffness / (lit::<T>(0.5) * stiffness + axis.damping)
            } else {
                zero
            };
            let after = z + (self.duration * share[i] * velocity[i] - loss * (one - share[i]) * z);
            let (size, most) = (z.size(), most * axis.ratio * axis.compliance());
            // The limit at an infinite velocity, infinite or 0·∞, cuts nothing.
            let limit = if size > most { size } else { most };
            // A minimum and a maximum, not a choice among three: one instruction each.
            let below = if after > limit { limit } else { after };
            deflection[i] = if below < -limit { -limit } else { below };
        }
        [deflection]
    }
}

/// The exact step at a held velocity: velocity, normal force → deflection, in place, and mean
/// force.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hold<T> {
    pub(super) duration: T,
}

impl<T: Real, const N: usize> Operation<T, N, 2, 2> for Hold<T> {
    #[inline(always)]
    fn apply<const FALL: u8>(
        &self,
        material: &Material<T, N>,
        [velocity, normal_force]: [[T; N]; 2],
        [mut deflection, mut force]: [[T; N]; 2],
    ) -> [[T; N]; 2] {
        let one = T::one();
        let (weighted, speed) = material.speeds(velocity);
        let mu = material.coefficient::<FALL>(speed);
        let load = load(only(normal_force));
        for i in 0..N {
            let (axis, v, z) = (&material.axes[i], velocity[i], deflection[i]);
            let mu = axis.square() * mu;
            let inverse = one / (axis.damping * weighted + mu);
            let drive = mu * inverse;
            // x = λh
            let exponent = self.duration * axis.stiffness * weighted * inverse;
            let decay = real::decay(-exponent);
            // 1 − φ1 = x φ2. Near x = 0 the polynomial, for there 1 − φ1 cancels.
            let far = one - decay.loss / exponent;
            let rest = if decay.is_near { exponent * decay.curvature } else { far };
            // r v/λ, the deflection in steady sliding.
            let steady = axis.direction::<N>(v, weighted) * (mu * axis.compliance());
            let missing = steady - z;
            let mean = z + rest * missing;
            deflection[i] = z + decay.loss * missing;
            force[i] = load * drive * (axis.stiffness * mean + axis.damping * v);
        }
        [deflection, force]
    }
}
