//! Derivatives of the coefficients of a model with respect to its parameters.

use bristle::curve::Stribeck;
use bristle::rheology::KelvinVoigt;
use bristle::scalar::{is_zero, lit};
use bristle::{Affine, Bristle, FrBd, Scalar, Surface};

/// A model of one spring whose four coefficients have known derivatives with respect to its
/// parameters θ: what a gradient asks for.
///
/// It must be of [`Form::OfVelocity`](bristle::Form::OfVelocity).
pub trait Differentiable<T: Scalar>: Bristle<T, Deflection = T> {
    /// The number of parameters.
    const PARAMETERS: usize;

    /// With the derivatives `by` of a quantity by λ, r, c₀ and c₂: adds those by each parameter to
    /// a gradient, and returns those by the velocity and by the friction scale.
    fn pull_back(&self, surface: Surface<T>, by: &Affine<T>, gradient: &mut [T]) -> [T; 2];
}

/// A curve at a speed, without scale: μ, ∂μ/∂|v|, and ∂μ/∂(μ_s, μ_d, v_S, σ2), with one
/// exponential.
fn curve<T: Scalar>(curve: &Stribeck<T>, speed: T) -> (T, T, [T; 4]) {
    let p = curve.parameters();
    let (drop, exponent) = (p.static_coefficient - p.dynamic_coefficient, p.stribeck_exponent);
    let share = speed / p.stribeck_velocity;
    let power = if exponent == lit(2.0) {
        share * share
    } else if exponent == T::one() || is_zero(share) {
        share
    } else {
        share.powf(exponent)
    };
    let decay = (-power).exp();
    let fall = drop * decay * exponent;
    let by_velocity = fall * power / p.stribeck_velocity;
    // At rest: 0 for δ > 1, 1 for δ = 1.
    let steepness = if is_zero(share) && exponent > T::one() { share } else { power / share };
    let steepness = if is_zero(share) && exponent == T::one() { T::one() } else { steepness };
    let slope = p.viscous_friction - fall * steepness / p.stribeck_velocity;
    let mu = p.dynamic_coefficient + p.viscous_friction * speed + drop * decay;
    (mu, slope, [decay, T::one() - decay, by_velocity, speed])
}

/// The parameters μ_s, μ_d, v_S, σ2, σ0, σ1, in this order; the Stribeck exponent is kept.
impl<T: Scalar> Differentiable<T> for FrBd<Stribeck<T>, KelvinVoigt<T>> {
    const PARAMETERS: usize = 6;

    // λ = σ0|v|/g, r = μ/g, c₀ = σ0 r, c₂ = σ1 r, g = σ1|v| + μ
    fn pull_back(&self, surface: Surface<T>, by: &Affine<T>, gradient: &mut [T]) -> [T; 2] {
        let bristle = self.rheology().parameters();
        let [stiffness, damping] = [bristle.micro_stiffness, bristle.micro_damping];
        let speed = surface.speed();
        let (unscaled, slope, curve) = curve(self.curve(), speed);
        let mu = surface.apply(unscaled);
        let inverse = T::one() / (damping * speed + mu);
        let (drive, share) = (mu * inverse, speed * inverse);
        let by_drive = by.drive + stiffness * by.stiffness + damping * by.damping;
        let by_share = stiffness * by.relaxation;
        let across = (by_drive * damping - by_share) * inverse * inverse;
        let by_mu = across * speed;
        let by_speed = -across * mu;
        let by_unscaled = surface.apply(by_mu);
        let [a, b, c, d] = curve.map(|slope| by_unscaled * slope);
        let by_stiffness = by.stiffness * drive + by.relaxation * share;
        let by_damping = by.damping * drive - (by_drive * drive + by_share * share) * share;
        let terms = [a, b, c, d, by_stiffness, by_damping];
        gradient.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        [(by_unscaled * slope + by_speed) * surface.direction(), by_mu * unscaled]
    }
}
