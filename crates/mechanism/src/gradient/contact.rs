//! The derivatives of one contact over one step.
//!
//! With x = λh and the weights e⁻ˣ, φ1, φ2, frozen at the prediction,
//!
//! β = P c₀ φ1 z₀,  D = P (c₀ r h φ2 + c₂),  z₁ = e⁻ˣ z₀ + h φ1 r s̄:
//!
//! five partial derivatives ∂β/∂z₀, D = ∂F̄/∂s̄, ∂z₁/∂z₀, ∂z₁/∂s̄ and those by the prediction.

use super::Differentiable;
use crate::contacts::ContactState;
use bristle::companion::{Companion, CompanionStep};
use bristle::parameter::Named;
use bristle::rheology::HeldWeights as _;
use bristle::root::enclose;
use bristle::scalar::{is_zero, lit};
use bristle::{Affine, Scalar, Surface};

/// The derivatives of a loss by what a contact keeps. All zero where the loss does not ask for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactAdjoint<T> {
    /// By the deflection [1/m].
    pub deflection: T,
    /// By the normal force of the last step [1/N]; after a step with loads of its own that of the
    /// step before.
    pub load: T,
    /// By the load that was given to the step [1/N].
    pub given_load: T,
    /// By the sliding velocity at the beginning of the last step [s/m].
    pub(crate) before: T,
}

/// All zero.
impl<T: Scalar> Default for ContactAdjoint<T> {
    fn default() -> Self {
        let [deflection, load, given_load, before] = [T::zero(); 4];
        Self { deflection, load, given_load, before }
    }
}

/// Whether the limit has cut the deflection.
fn is_cut<T: Scalar>(step: &CompanionStep<T>, after: &ContactState<T>) -> bool {
    let free = step.weights().end(step.deflection(), step.coefficients().drive * after.mean);
    free != after.deflection()
}

/// φ1' and φ2'.
fn slopes<T: Scalar>(x: T, [decay, phi1, phi2]: [T; 3]) -> [T; 2] {
    if x < lit(0.5) {
        // φ3 = Σ (−x)ᵏ/(k + 3)!, cut below 1e-16
        let mut phi3 = T::zero();
        for k in (3..16).rev() {
            phi3 = (T::one() - x * phi3) * lit(1.0 / f64::from(k));
        }
        let phi3 = phi3 * lit(0.5);
        [phi2 - phi1, phi3 + phi3 - phi2]
    } else {
        let first = (decay - phi1) / x;
        [first, -(first + phi2) / x]
    }
}

impl<T: Scalar> ContactAdjoint<T> {
    /// By the mean sliding velocity of a step, by way of the deflection at its end.
    pub(crate) fn by_mean(&self, after: &ContactState<T>) -> T {
        match &after.frozen {
            Some(step) if !is_cut(step, after) => {
                self.deflection * step.weights().end(T::zero(), step.coefficients().drive)
            }
            _ => T::zero(),
        }
    }

    /// With the states before and after a step, its sliding velocities without belt and with it,
    /// and the derivatives by β and D: adds those by the parameters to a gradient, changes to those
    /// by what the contact was before the step, and returns that by the sliding velocity s₀.
    pub(crate) fn pull_back<M: Differentiable<T>>(
        &mut self,
        companion: &Companion<T, M>,
        duration: T,
        [start, state]: [&ContactState<T>; 2],
        sliding: [T; 2],
        by: [T; 2],
        gradient: &mut [T],
    ) -> T {
        let Some(step) = &state.frozen else { return T::zero() };
        let (reference, cut) = (companion.contact().reference_load(), is_cut(step, state));
        let ((predicted, counts), [before, after]) =
            (start.predict(sliding), [start.load(), state.load()]);
        let (start, end, reloaded) = (start.deflection(), state.deflection(), step.deflection());
        let scale = if after == reference { T::one() } else { after / reference };
        let on = Surface::scaled(predicted, scale);
        let by_end = if cut { T::zero() } else { self.deflection };
        let (mut by_reloaded, by) = by_coefficients(step, duration, state.mean, by, by_end);
        let mut by_surface = [T::zero(); 2];
        if !is_zero(scale) {
            by_surface = companion.contact().model().pull_back(on, &by, gradient);
        }
        let mut stationary = |by: T, at: T| {
            let terms = stationary(companion, on, [by, at], gradient);
            (0..2).for_each(|i| by_surface[i] += terms[i]);
        };
        if cut && end.abs() == reloaded.abs() {
            by_reloaded += if end == reloaded { self.deflection } else { -self.deflection };
        } else if cut {
            stationary(self.deflection, end);
        }
        let (ratio, [mut by_load, mut by_before]) = (after / before, [T::zero(); 2]);
        self.deflection = by_reloaded;
        if reloaded != start && reloaded == start * ratio {
            self.deflection = by_reloaded * ratio;
            if !is_zero(after) {
                by_load = by_reloaded * start / before;
                by_before = -by_load * ratio;
            }
        } else if reloaded != start {
            stationary(by_reloaded, reloaded);
            self.deflection = T::zero();
        }
        let [by_velocity, by_scale] = by_surface;
        by_load += if reference > T::zero() { by_scale / reference } else { T::zero() };
        (self.given_load, self.load) = (self.load + by_load, by_before);
        self.before = if counts { -lit::<T>(0.5) * by_velocity } else { T::zero() };
        by_velocity - self.before
    }
}

/// From the derivatives by β, D and z₁, those by z₀ and the coefficients.
fn by_coefficients<T: Scalar>(
    step: &CompanionStep<T>,
    duration: T,
    mean: T,
    by: [T; 2],
    by_end: T,
) -> (T, Affine<T>) {
    let (weights, load, start) = (step.weights(), step.reference_load(), step.deflection());
    let Affine { relaxation, drive, stiffness, .. } = *step.coefficients();
    let (decay, phi1) = (weights.end(T::one(), T::zero()), weights.undriven_mean(T::one()));
    let driven = weights.driven_mean(T::one());
    let phi2 = if is_zero(duration) { lit(0.5) } else { driven / duration };
    let [phi1_slope, phi2_slope] = slopes(relaxation * duration, [decay, phi1, phi2]);
    let [by_bias, by_damper] = by.map(|by| by * load);
    let by_phi1 = by_bias * stiffness * start + by_end * duration * drive * mean;
    let by_phi2 = by_damper * stiffness * drive * duration;
    let by_x = by_phi1 * phi1_slope + by_phi2 * phi2_slope - by_end * start * decay;
    let by = Affine {
        relaxation: by_x * duration,
        drive: by_damper * stiffness * driven + by_end * phi1 * mean * duration,
        stiffness: by_bias * phi1 * start + by_damper * drive * driven,
        damping: by_damper,
    };
    (by_bias * stiffness * phi1 + by_end * decay, by)
}

/// A deflection was cut to z_ss(u) = r u/λ, at rest, at the predicted speed, at the fastest or at
/// the summit of the curve: adds its derivatives by the parameters to a gradient, and returns those
/// by the predicted velocity and the scale.
#[cold]
fn stationary<T: Scalar, M: Differentiable<T>>(
    companion: &Companion<T, M>,
    on: Surface<T>,
    [by, at]: [T; 2],
    gradient: &mut [T],
) -> [T; 2] {
    let (model, predicted) = (companion.contact().model(), on.velocity());
    // At rest r u/λ is a limit.
    let rest = Named::<T>::smallest();
    let surface = |speed: T| Surface::scaled(speed.larger(rest), on.scale());
    let off = |speed: T| (model.stationary(surface(speed)) - at.abs()).abs();
    let slopes = |speed: T, by: T, gradient: &mut [T]| {
        let (on, zero) = (surface(speed), T::zero());
        let Affine { relaxation, drive, .. } = model.affine(on, at);
        let by_drive = by * on.velocity() / relaxation;
        let by_relaxation = -by_drive * drive / relaxation;
        let by_affine =
            Affine { relaxation: by_relaxation, drive: by_drive, stiffness: zero, damping: zero };
        let [slope, by_scale] = model.pull_back(on, &by_affine, gradient);
        [slope + by * drive / relaxation, by_scale]
    };
    let speeds = [T::zero(), predicted.abs(), companion.fastest()];
    let closer = |one: T, other: T| if off(other) < off(one) { other } else { one };
    let mut speed = speeds.into_iter().fold(speeds[0], closer);
    if !(off(speed) <= lit::<T>(16.0) * T::default_epsilon() * at.abs()) {
        // The deflection at the summit does not depend on its place.
        let slope = |at: T| slopes(at, T::one(), &mut [])[0];
        let mut falling = companion.fastest();
        for _ in 0..64 {
            falling *= if slope(falling) < T::zero() { T::one() } else { lit(0.5) };
        }
        let rising = falling * lit(1e-3);
        let (start, end) = ((rising, slope(rising)), (falling, slope(falling)));
        speed = enclose(slope, start, end, T::zero()).1;
    }
    let [slope, by_scale] = slopes(speed, if at < T::zero() { -by } else { by }, gradient);
    let moves = speed > T::zero() && speed == predicted.abs();
    let slope = if predicted < T::zero() { -slope } else { slope };
    [if moves { slope } else { T::zero() }, by_scale]
}
