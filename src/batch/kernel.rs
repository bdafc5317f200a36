//! The arithmetic of one bristle: what a step reads of it, and what it leaves.

use super::material::{Falling, Material};
use super::real::{self, Real};
use crate::scalar::{lit, nan};

/// One operation on one bristle, with I numbers read and O numbers written.
pub(super) trait Operation<T, const I: usize, const O: usize>: Copy + Send + Sync {
    /// Whether the O numbers are read before they are written.
    const READS: bool;
    /// What becomes of the O numbers.
    fn apply<F: Falling<T>>(
        &self,
        material: &Material<T>,
        inputs: [T; I],
        outputs: [T; O],
    ) -> [T; O];
}

/// |v|, NaN for an infinite one: no velocity at all, and nothing finite shall come of it.
#[inline(always)]
fn speed<T: Real>(velocity: T) -> T {
    let speed = velocity.size();
    if speed.is_number() { speed } else { nan() }
}

/// The normal force; NaN for a negative one.
#[inline(always)]
fn load<T: Real>(normal_force: T) -> T {
    if normal_force >= T::zero() { normal_force } else { nan() }
}

/// Shares, biases and dampings of a midpoint step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Predict<T> {
    pub(super) duration: T,
}

impl<T: Real> Operation<T, 3, 3> for Predict<T> {
    const READS: bool = false;

    #[inline(always)]
    fn apply<F: Falling<T>>(&self, material: &Material<T>, inputs: [T; 3], _: [T; 3]) -> [T; 3] {
        let [velocity, normal_force, deflection] = inputs;
        let stiffening = lit::<T>(0.5) * self.duration * material.stiffness + material.damping;
        let speed = speed(velocity);
        let mu = material.coefficient::<F>(speed);
        let share = mu / (mu + stiffening * speed);
        let carried = load(normal_force) * share;
        [share, carried * (material.stiffness * deflection), carried * stiffening]
    }
}

/// The deflections after a midpoint step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Commit<T> {
    pub(super) duration: T,
}

impl<T: Real> Operation<T, 2, 1> for Commit<T> {
    const READS: bool = true;

    #[inline(always)]
    fn apply<F: Falling<T>>(
        &self,
        material: &Material<T>,
        inputs: [T; 2],
        outputs: [T; 1],
    ) -> [T; 1] {
        let ([share, velocity], [before]) = (inputs, outputs);
        let (zero, one) = (T::zero(), T::one());
        let stiffness = self.duration * material.stiffness;
        // h σ0/κ, at most 2; κ is zero for a step of no length.
        let loss = if stiffness > zero {
            stiffness / (lit::<T>(0.5) * stiffness + material.damping)
        } else {
            zero
        };
        let after = before + (self.duration * share * velocity - loss * (one - share) * before);
        let (size, most) = (before.size(), material.most(speed(velocity)) * material.compliance());
        // An infinite velocity has no limit, and is not cut to a finite deflection.
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

/// Deflections and mean forces of the exact step at a held velocity.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hold<T> {
    pub(super) duration: T,
}

impl<T: Real> Operation<T, 2, 2> for Hold<T> {
    const READS: bool = true;

    #[inline(always)]
    fn apply<F: Falling<T>>(
        &self,
        material: &Material<T>,
        inputs: [T; 2],
        outputs: [T; 2],
    ) -> [T; 2] {
        let ([velocity, normal_force], [before, _]) = (inputs, outputs);
        let one = T::one();
        let speed = speed(velocity);
        let mu = material.coefficient::<F>(speed);
        let inverse = one / (material.damping * speed + mu);
        let drive = mu * inverse;
        // x = λh, and the decay over the step in pieces.
        let exponent = self.duration * material.stiffness * speed * inverse;
        let decay = real::decay(-exponent);
        // 1 − φ1 = x φ2; close to x = 0 by the polynomial, without the loss of digits of 1 − φ1 there.
        let far = one - decay.loss / exponent;
        let rest = if decay.is_near { exponent * decay.curvature } else { far };
        // r v/λ, the deflection of steady sliding; of no account at rest, where it jumps, for there x = 0.
        let size = mu * material.compliance();
        let steady = if velocity < T::zero() { -size } else { size };
        let missing = steady - before;
        let (after, mean) = (before + decay.loss * missing, before + rest * missing);
        let force =
            load(normal_force) * drive * (material.stiffness * mean + material.damping * velocity);
        [after, force]
    }
}
