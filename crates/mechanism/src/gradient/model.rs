//! Derivatives of the coefficients of a model with respect to its parameters.

use bristle::curve::Stribeck;
use bristle::rheology::KelvinVoigt;
use bristle::{Affine, Bristle, Dahl, FrBd, Scalar, Surface};

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

    /// The same of the deflection z_ss of steady sliding, with the derivative by it, at v > 0.
    fn pull_back_stationary(&self, surface: Surface<T>, by: T, gradient: &mut [T]) -> [T; 2];
}

/// Adds to a gradient, in the order of the parameters.
fn add<T: Scalar, const N: usize>(gradient: &mut [T], terms: [T; N]) {
    gradient.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
}

/// ∂μ/∂(μ_s, μ_d, v_S, σ2) of a curve, without scale.
fn by_curve<T: Scalar>(curve: &Stribeck<T>, speed: T) -> [T; 4] {
    let p = curve.parameters();
    let share = speed / p.stribeck_velocity;
    let power = if share > T::zero() { share.powf(p.stribeck_exponent) } else { T::zero() };
    let decay = (-power).exp();
    let drop = p.static_coefficient - p.dynamic_coefficient;
    let by_velocity = drop * decay * p.stribeck_exponent * power / p.stribeck_velocity;
    [decay, T::one() - decay, by_velocity, speed]
}

/// The parameters μ_s, μ_d, v_S, σ2, σ0, σ1, in this order; the Stribeck exponent is kept.
impl<T: Scalar> Differentiable<T> for FrBd<Stribeck<T>, KelvinVoigt<T>> {
    const PARAMETERS: usize = 6;

    // λ = σ0|v|/g, r = μ/g, c₀ = σ0 r, c₂ = σ1 r, g = σ1|v| + μ
    fn pull_back(&self, surface: Surface<T>, by: &Affine<T>, gradient: &mut [T]) -> [T; 2] {
        let bristle = self.rheology().parameters();
        let [stiffness, damping] = [bristle.micro_stiffness, bristle.micro_damping];
        let (mu, mu_slope) = surface.friction_and_slope(self.curve());
        let speed = surface.speed();
        let inverse = T::one() / (damping * speed + mu);
        let (drive, share) = (mu * inverse, speed * inverse);
        let by_drive = by.drive + stiffness * by.stiffness + damping * by.damping;
        let by_share = stiffness * by.relaxation;
        let across = (by_drive * damping - by_share) * inverse * inverse;
        let by_mu = across * speed;
        let by_speed = -across * mu;
        let curve = by_curve(self.curve(), speed);
        let [a, b, c, d] = curve.map(|slope| by_mu * surface.apply(slope));
        let by_stiffness = by.stiffness * drive + by.relaxation * share;
        let by_damping = by.damping * drive - (by_drive * drive + by_share * share) * share;
        add(gradient, [a, b, c, d, by_stiffness, by_damping]);
        let unscaled = mu / surface.scale();
        [by_mu * mu_slope + by_speed * surface.direction(), by_mu * unscaled]
    }

    fn pull_back_stationary(&self, surface: Surface<T>, by: T, gradient: &mut [T]) -> [T; 2] {
        let stiffness = self.rheology().parameters().micro_stiffness;
        let (mu, slope) = surface.friction_and_slope(self.curve());
        let by = by / stiffness;
        let curve = by_curve(self.curve(), surface.speed());
        let [a, b, c, d] = curve.map(|slope| by * surface.apply(slope));
        add(gradient, [a, b, c, d, -by * mu / stiffness, T::zero()]);
        [by * slope, by * mu / surface.scale()]
    }
}

/// The parameters μ_d, σ0, in this order.
impl<T: Scalar> Differentiable<T> for Dahl<T> {
    const PARAMETERS: usize = 2;

    // λ = σ0|v|/μ, r = 1, c₀ = σ0
    fn pull_back(&self, surface: Surface<T>, by: &Affine<T>, gradient: &mut [T]) -> [T; 2] {
        let p = self.parameters();
        let mu = surface.apply(p.dynamic_coefficient);
        let by_share = by.relaxation / mu;
        let by_mu = -by_share * p.micro_stiffness * surface.speed() / mu;
        let by_stiffness = by.stiffness + by_share * surface.speed();
        add(gradient, [surface.apply(by_mu), by_stiffness]);
        [by_share * p.micro_stiffness * surface.direction(), by_mu * p.dynamic_coefficient]
    }

    fn pull_back_stationary(&self, surface: Surface<T>, by: T, gradient: &mut [T]) -> [T; 2] {
        let p = self.parameters();
        let by = by / p.micro_stiffness;
        let mu = surface.apply(p.dynamic_coefficient);
        add(gradient, [surface.apply(by), -by * mu / p.micro_stiffness]);
        [T::zero(), by * p.dynamic_coefficient]
    }
}
