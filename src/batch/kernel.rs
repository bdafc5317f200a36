//! The arithmetic of one bristle: what a step reads, and what it writes.

use super::material::{Material, Source};
use super::real::{self, Real};
use crate::scalar::{lit, nan};

/// What a step does to one bristle: from P parameters, I inputs and the O outputs before it.
pub(super) trait Kernel<T, const P: usize, const I: usize, const O: usize>:
    Copy + Send + Sync
{
    /// Whether the step depends on the outputs before it. Reading them for nothing costs bandwidth.
    const READS_OUTPUTS: bool;
    /// The O outputs after the step.
    fn apply(&self, parameters: [T; P], inputs: [T; I], before: [T; O]) -> [T; O];
}

/// An operation on bristles with parameters from a source and a curve that falls in one way, a
/// [`Fall`](super::Fall) as a number: chosen before the loop over the bristles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bound<S, K, const FALL: u8> {
    pub(super) source: S,
    pub(super) operation: K,
}

impl<T, S, K, const FALL: u8, const P: usize, const I: usize, const O: usize> Kernel<T, P, I, O>
    for Bound<S, K, FALL>
where
    S: Source<T, P>,
    K: Operation<T, I, O>,
{
    const READS_OUTPUTS: bool = K::READS_OUTPUTS;

    #[inline(always)]
    fn apply(&self, parameters: [T; P], inputs: [T; I], before: [T; O]) -> [T; O] {
        self.operation.apply::<FALL>(&self.source.material(parameters), inputs, before)
    }
}

/// A step of one bristle whose material is known.
pub(super) trait Operation<T, const I: usize, const O: usize>: Copy + Send + Sync {
    /// Whether the step depends on the outputs before it.
    const READS_OUTPUTS: bool = true;
    /// The O outputs after the step.
    fn apply<const FALL: u8>(
        &self,
        material: &Material<T>,
        inputs: [T; I],
        before: [T; O],
    ) -> [T; O];
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

impl<T: Real> Operation<T, 2, 2> for Reload {
    #[inline(always)]
    fn apply<const FALL: u8>(
        &self,
        material: &Material<T>,
        [before, after]: [T; 2],
        [deflection, _]: [T; 2],
    ) -> [T; 2] {
        let (zero, one) = (T::zero(), T::one());
        let (from, to) = (load(before), load(after));
        let rises = to > from;
        let (kept, lost) =
            if rises { (from / to, (to - from) / to) } else { (one, (from - to) / from) };
        // Not for NaN.
        let touches = from > zero && to > zero;
        let (kept, lost) = if touches { (kept, lost) } else { (zero, one) };
        let stored = lit::<T>(0.5) * from * material.stiffness * deflection * deflection;
        // NaN unless the load is finite.
        [deflection * kept, lost * stored + zero * to]
    }
}

/// The beginning of a midpoint step: velocity, normal force, deflection → share, bias, damping.
#[derive(Debug, Clone, Copy)]
pub(super) struct Predict<T> {
    pub(super) duration: T,
}

impl<T: Real> Operation<T, 3, 3> for Predict<T> {
    const READS_OUTPUTS: bool = false;

    #[inline(always)]
    fn apply<const FALL: u8>(
        &self,
        material: &Material<T>,
        [velocity, normal_force, deflection]: [T; 3],
        _: [T; 3],
    ) -> [T; 3] {
        let stiffening = lit::<T>(0.5) * self.duration * material.stiffness + material.damping;
        let speed = velocity.size();
        let mu = material.coefficient::<FALL>(speed);
        let share = mu / (mu + stiffening * speed);
        let carried = load(normal_force) * share;
        [share, carried * (material.stiffness * deflection), carried * stiffening]
    }
}

/// The end of a midpoint step: mean velocity, share → deflection, in place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Commit<T> {
    pub(super) duration: T,
}

impl<T: Real> Operation<T, 2, 1> for Commit<T> {
    #[inline(always)]
    fn apply<const FALL: u8>(
        &self,
        material: &Material<T>,
        [velocity, share]: [T; 2],
        [before]: [T; 1],
    ) -> [T; 1] {
        let (zero, one) = (T::zero(), T::one());
        let stiffness = self.duration * material.stiffness;
        // h σ0/κ, at most 2. Without damping κ is zero for a step of no length.
        let loss = if stiffness > zero {
            stiffness / (lit::<T>(0.5) * stiffness + material.damping)
        } else {
            zero
        };
        let after = before + (self.duration * share * velocity - loss * (one - share) * before);
        let (size, most) = (before.size(), material.most(velocity.size()) * material.compliance());
        // The limit at an infinite velocity, infinite or 0·∞, cuts nothing.
        let limit = if size > most { size } else { most };
        [if after > limit {
            limit
        } else if after < -limit {
            -limit
        } else {
            after
        }]
    }
}

/// The exact step at a held velocity: velocity, normal force → deflection, in place, and mean
/// force.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hold<T> {
    pub(super) duration: T,
}

impl<T: Real> Operation<T, 2, 2> for Hold<T> {
    #[inline(always)]
    fn apply<const FALL: u8>(
        &self,
        material: &Material<T>,
        [velocity, normal_force]: [T; 2],
        [before, _]: [T; 2],
    ) -> [T; 2] {
        let one = T::one();
        let speed = velocity.size();
        let mu = material.coefficient::<FALL>(speed);
        let inverse = one / (material.damping * speed + mu);
        let drive = mu * inverse;
        // x = λh
        let exponent = self.duration * material.stiffness * speed * inverse;
        let decay = real::decay(-exponent);
        // 1 − φ1 = x φ2. Near x = 0 the polynomial, for there 1 − φ1 cancels.
        let far = one - decay.loss / exponent;
        let rest = if decay.is_near { exponent * decay.curvature } else { far };
        // r v/λ, the deflection in steady sliding. At rest its sign does not matter: x = 0 there.
        let size = mu * material.compliance();
        let steady = if velocity < T::zero() { -size } else { size };
        let missing = steady - before;
        let (after, mean) = (before + decay.loss * missing, before + rest * missing);
        let force =
            load(normal_force) * drive * (material.stiffness * mean + material.damping * velocity);
        [after, force]
    }
}
