//! The derivatives of one contact over one step.
//!
//! With x = λh and the weights e⁻ˣ, φ1, φ2, frozen at the prediction,
//!
//! β = P c₀ φ1 z₀,  D = P (c₀ r h φ2 + c₂),  z₁ = e⁻ˣ z₀ + h φ1 r s̄:
//!
//! five partial derivatives ∂β/∂z₀, D = ∂F̄/∂s̄, ∂z₁/∂z₀, ∂z₁/∂s̄ and those by the prediction.

use super::Differentiable;
use crate::contacts::ContactState;
use bristle::companion::Companion;
use bristle::rheology::HeldWeights as _;
use bristle::scalar::{is_zero, lit};
use bristle::{Affine, Branch, Scalar, Surface};

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
    pub(crate) trace: Trace<T>,
}

impl<T: Scalar> ContactAdjoint<T> {
    /// All zero.
    pub fn new() -> Self {
        let zero = T::zero();
        let trace = Trace::default();
        Self { deflection: zero, load: zero, given_load: zero, before: zero, trace }
    }
}

impl<T: Scalar> Default for ContactAdjoint<T> {
    fn default() -> Self {
        Self::new()
    }
}

/// What a step began with, and what it met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Trace<T> {
    predicted: T,
    /// Whether the prediction is the sliding velocity alone.
    alone: bool,
    deflection: T,
    load: [T; 2],
    /// s̄, and ∂loss/∂s̄ by way of the deflection.
    pub(crate) mean: T,
    pub(crate) by_mean: T,
    /// Whether the limit has cut the deflection.
    cut: bool,
}

impl<T: Scalar> Default for Trace<T> {
    fn default() -> Self {
        let zero = T::zero();
        let (predicted, deflection, mean, by_mean) = (zero, zero, zero, zero);
        Self { predicted, alone: true, deflection, load: [zero; 2], mean, by_mean, cut: false }
    }
}

/// φ1' and φ2'.
fn slopes<T: Scalar>(x: T, [decay, phi1, phi2]: [T; 3]) -> [T; 2] {
    if x < lit(0.5) {
        // φ3 = Σ (−x)ᵏ/(k + 3)!, cut below 1e-16
        let mut phi3 = T::zero();
        for k in (3..16).rev() {
            phi3 = (T::one() - x * phi3) / lit(f64::from(k));
        }
        let phi3 = phi3 * lit(0.5);
        [phi2 - phi1, phi3 + phi3 - phi2]
    } else {
        let first = (decay - phi1) / x;
        [first, -(first + phi2) / x]
    }
}

impl<T: Scalar> Trace<T> {
    /// Before the step.
    pub(crate) fn new(state: &ContactState<T>, [without, sliding, load]: [T; 3]) -> Self {
        let last = state.before().map_or(sliding, |before| before + (sliding - without));
        let alone = sliding * last < T::zero() || state.before().is_none();
        let ahead = if alone { T::zero() } else { lit::<T>(0.5) * (sliding - last) };
        Self {
            predicted: sliding + ahead,
            alone,
            deflection: state.deflection(),
            load: [state.load(), load],
            ..Self::default()
        }
    }
}

impl<T: Scalar> ContactAdjoint<T> {
    /// Of a step without loads of its own: the load was that of the step before.
    pub(crate) fn keep_load(&mut self) {
        self.load += self.given_load;
        self.given_load = T::zero();
    }

    /// After the step, with its mean sliding velocity: the derivative by that.
    pub(crate) fn by_mean(&mut self, state: &ContactState<T>, mean: T) -> T {
        let Some(step) = state.frozen() else { return T::zero() };
        let drive = step.coefficients().drive;
        self.trace.mean = mean;
        self.trace.cut = step.weights().end(step.deflection(), drive * mean) != state.deflection();
        if !self.trace.cut {
            self.trace.by_mean = self.deflection * step.weights().end(T::zero(), drive);
        }
        self.trace.by_mean
    }

    /// With the derivatives by β and D: adds those by the parameters to a gradient, changes to
    /// those by what the contact was before the step, and returns that by the sliding velocity s₀.
    pub(crate) fn pull_back<M: Differentiable<T>>(
        &mut self,
        companion: &Companion<T, M>,
        duration: T,
        state: &ContactState<T>,
        [by_bias, by_damper]: [T; 2],
        gradient: &mut [T],
    ) -> T {
        let Some(step) = state.frozen() else { return T::zero() };
        let (contact, trace, end) = (companion.contact(), self.trace, state.deflection());
        let (predicted, cut, reloaded) = (trace.predicted, trace.cut, step.deflection());
        let (model, reference, affine) =
            (contact.model(), contact.reference_load(), step.coefficients());
        let scale = trace.load[1] / reference;
        let constant = trace.load[1] == reference;
        let on = Surface::scaled(predicted, if constant { T::one() } else { scale });
        let (one, zero, x) = (T::one(), T::zero(), affine.relaxation * duration);
        let weights = step.weights();
        let (decay, phi1) = (weights.end(one, zero), weights.undriven_mean(one));
        let phi2 = if is_zero(duration) { lit(0.5) } else { weights.driven_mean(one) / duration };
        let [phi1_slope, phi2_slope] = slopes(x, [decay, phi1, phi2]);
        let (by_bias, by_damper) = (by_bias * reference, by_damper * reference);
        let by_end = if cut { T::zero() } else { self.deflection };
        let Affine { drive, stiffness, .. } = *affine;
        let by_decay = by_end * reloaded;
        let by_phi1 = by_bias * stiffness * reloaded + by_end * duration * drive * trace.mean;
        let by_phi2 = by_damper * stiffness * drive * duration;
        let by_x = by_phi1 * phi1_slope + by_phi2 * phi2_slope - by_decay * decay;
        let by = Affine {
            relaxation: by_x * duration,
            drive: (by_damper * stiffness * phi2 + by_end * phi1 * trace.mean) * duration,
            stiffness: by_bias * phi1 * reloaded + by_damper * drive * duration * phi2,
            damping: by_damper,
        };
        let mut by_reloaded = by_bias * stiffness * phi1 + by_end * decay;
        let mut by_surface = [T::zero(); 2];
        if !is_zero(on.scale()) {
            by_surface = model.pull_back(on, &by, gradient);
        }
        let mut add = |terms: [T; 2]| (0..2).for_each(|i| by_surface[i] += terms[i]);
        if cut && end.abs() == reloaded.abs() {
            let same = (end > T::zero()) == (reloaded > T::zero());
            by_reloaded += if same { self.deflection } else { -self.deflection };
        } else if cut {
            let speeds = [T::zero(), companion.fastest(), predicted.abs()];
            let at = [self.deflection, end, predicted];
            add(stationary(model, on, at, &speeds, gradient));
        }
        let [before, after] = trace.load;
        let (mut by_load, mut by_before, mut by_deflection) = (T::zero(), T::zero(), by_reloaded);
        if reloaded != trace.deflection {
            let ratio = after / before;
            by_deflection = by_reloaded * ratio;
            if is_zero(after) {
            } else if reloaded == trace.deflection * ratio {
                by_load = by_reloaded * trace.deflection / before;
                by_before = -by_load * ratio;
            } else {
                by_deflection = T::zero();
                let at = [by_reloaded, reloaded, predicted];
                add(stationary(model, on, at, &[T::zero(), predicted.abs()], gradient));
            }
        }
        let [by_velocity, by_scale] = by_surface;
        if reference > T::zero() {
            by_load += by_scale / reference;
        }
        self.deflection = by_deflection;
        self.given_load = self.load + by_load;
        self.load = by_before;
        let half = lit::<T>(0.5);
        self.before = if trace.alone { T::zero() } else { -half * by_velocity };
        by_velocity - self.before
    }
}

/// A deflection was cut to z_ss(u) at one of some speeds u: adds its derivatives by the parameters
/// to a gradient, and returns those by the predicted velocity and the scale.
fn stationary<T: Scalar, M: Differentiable<T>>(
    model: &M,
    on: Surface<T>,
    [by, at, predicted]: [T; 3],
    speeds: &[T],
    gradient: &mut [T],
) -> [T; 2] {
    let surface = |speed: T| Surface::scaled(Branch::Forward.of(speed), on.scale());
    let off = |speed: T| (model.stationary(surface(speed)).abs() - at.abs()).abs();
    let closer = |one: T, other: T| if off(other) < off(one) { other } else { one };
    let mut speed = speeds.iter().copied().fold(predicted.abs(), closer);
    let rounding = lit::<T>(16.0) * T::default_epsilon();
    if !(off(speed) <= rounding * at.abs()) {
        speed = summit(speeds, |speed| {
            model.pull_back_stationary(surface(speed), T::one(), &mut [])[0]
        });
    }
    let by = if at < T::zero() { -by } else { by };
    let [slope, by_scale] = model.pull_back_stationary(surface(speed), by, gradient);
    let moves = speed == predicted.abs();
    let slope = if predicted < T::zero() { -slope } else { slope };
    [if moves { slope } else { T::zero() }, by_scale]
}

/// The speed at which a curve that first rises is highest, by bisection of its slope. The deflection
/// there does not depend on the place of the summit, but on the parameters.
#[cold]
fn summit<T: Scalar>(speeds: &[T], slope: impl Fn(T) -> T) -> T {
    let half = lit::<T>(0.5);
    let mut falling = speeds.iter().copied().fold(T::zero(), T::larger);
    let mut rising = T::zero();
    for _ in 0..64 {
        if slope(falling) < T::zero() {
            break;
        }
        falling *= half;
    }
    for _ in 0..60 {
        let middle = (rising + falling) * half;
        if slope(middle) < T::zero() {
            falling = middle;
        } else {
            rising = middle;
        }
    }
    falling
}
