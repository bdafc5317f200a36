//! The elasto-plastic FrBD model: a bristle that is purely elastic below a stick limit.
//!
//! ż   = −(ασ0|v|_ε/g) z + (μ/g) v,  g = ασ1|v|_ε + μ(v)
//! μ_b = (μ/g)(σ0 z + σ1 v)
//!
//! with the symbols of [`FrBd`](crate::FrBd) and α(z, v) ∈ [0, 1]: zero up to the stick limit
//! |z| = z_b and wherever z and v have opposite signs, one from the stationary deflection
//! z_m = μ(v)/σ0 on, and in between
//!
//! α = ½ + ½ sin(π (|z| − (z_m + z_b)/2)/(z_m − z_b)).
//!
//! With α = 0 the bristle follows the body (ż = v): load cycles below the stick limit cause no
//! drift, where FrBD and LuGre creep. In return the four coefficients depend on z, the force for
//! α < 1 is not bounded by the curve, and α is frozen at the beginning of a step.
//!
//! Source: the α of P. Dupont, V. Hayward, B. Armstrong, F. Altpeter, "Single state elastoplastic
//! friction models", IEEE Transactions on Automatic Control 47 (2002), 787–792, in the FrBD model
//! of Romano et al. (arXiv 2602.09429), section III-A.

use super::frbd::{Series, inverse_resistance, least_slope};
use super::{Affine, Characteristics, Law, Limits, Linearised, finite};
use crate::curve::FrictionCurve;
use crate::parameter::{self, ParameterError};
use crate::regularisation::{Regularisation, Unregularised};
use crate::rheology::{Elements, KelvinVoigt, Rheology, VelocityLaw};
use crate::scalar::unlimited;
use crate::{Bristle, Scalar, Sliding};

/// Parameters of [`ElastoPlastic`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElastoPlasticParameters<C, R, T = f64> {
    /// Friction curve.
    pub curve: C,
    /// Kelvin–Voigt bristle of constant stiffness.
    pub rheology: R,
    /// Stick limit z_b \[m\], positive and below min μ/σ0: up to it the bristle is elastic.
    #[doc(alias = "breakaway")]
    pub stick_limit: T,
}

/// The elasto-plastic FrBD model of a friction curve C, a [`KelvinVoigt`] bristle R of constant
/// stiffness and a regularisation E.
///
/// With the symbols of [`FrBd`](crate::FrBd) and the virtual friction coefficient μ_b = F/p:
///
/// ż   = −(ασ0|v|_ε/g) z + (μ/g) v,  g = ασ1|v|_ε + μ(v)
///
/// μ_b = (μ/g)(σ0 z + σ1 v)
///
/// α(z, v) is 0 up to the stick limit |z| = z_b, and wherever z and v have opposite signs; it is 1
/// from the stationary deflection μ(v)/σ0 on, and rises smoothly in between. Up to the stick limit
/// the bristle is elastic: load cycles cause no drift.
///
/// Source: P. Dupont, V. Hayward, B. Armstrong, F. Altpeter, "Single state elastoplastic friction
/// models", IEEE Transactions on Automatic Control 47 (2002), 787–792, in the FrBD model of Romano
/// et al. (arXiv 2602.09429), section III-A.
///
/// ```
/// use bristle::{Bristle, ElastoPlastic, ElastoPlasticParameters};
/// use bristle::curve::{Coulomb, CoulombParameters};
/// use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
///
/// let friction = ElastoPlastic::new(ElastoPlasticParameters {
///     curve: Coulomb::new(CoulombParameters { dynamic_coefficient: 1.0, viscous_friction: 0.0 })?,
///     rheology: KelvinVoigt::new(KelvinVoigtParameters {
///         micro_stiffness: 1e4,
///         micro_damping: 60.0,
///     })?,
///     stick_limit: 5e-5,
/// })?;
/// // Below the stick limit the bristle follows the body.
/// assert_eq!(friction.rate(0.01, 4e-5), 0.01);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElastoPlastic<C, R, E = Unregularised, T = f64> {
    curve: C,
    rheology: R,
    regularisation: E,
    stick_limit: T,
}

impl<T: Scalar, C: FrictionCurve<T>, D: VelocityLaw<T>>
    ElastoPlastic<C, KelvinVoigt<T, T, D>, Unregularised, T>
{
    /// Checks the stick limit against the curve.
    ///
    /// # Errors
    ///
    /// Refuses a stick limit that is not positive or not below min μ/σ0.
    pub fn new(
        parameters: ElastoPlasticParameters<C, KelvinVoigt<T, T, D>, T>,
    ) -> Result<Self, ParameterError> {
        let ElastoPlasticParameters { curve, rheology, stick_limit } = parameters;
        parameter::positive("stick_limit", stick_limit)?;
        let least = curve.bounds(unlimited()).min / rheology.storage_stiffness();
        parameter::below("stick_limit", stick_limit, "min μ/σ0", least)?;
        Ok(Self { curve, rheology, regularisation: Unregularised, stick_limit })
    }
}

impl<C, R, E, T> ElastoPlastic<C, R, E, T> {
    /// The model with another regularisation of |v|.
    pub fn regularised<F>(self, regularisation: F) -> ElastoPlastic<C, R, F, T> {
        ElastoPlastic {
            curve: self.curve,
            rheology: self.rheology,
            regularisation,
            stick_limit: self.stick_limit,
        }
    }
}

/// α and its partial derivatives.
struct Plasticity<T> {
    alpha: T,
    by_deflection: T,
    by_velocity: T,
}

impl<T, C, D, E> ElastoPlastic<C, KelvinVoigt<T, T, D>, E, T>
where
    T: Scalar,
    C: FrictionCurve<T>,
    D: VelocityLaw<T>,
    E: Regularisation<T>,
{
    /// The stick limit z_b \[m\].
    pub fn stick_limit(&self) -> T {
        self.stick_limit
    }

    /// How plastic the bristle is at a state, α ∈ [0, 1].
    #[doc(alias = "alpha")]
    pub fn plasticity(&self, sliding: impl Into<Sliding<T>>, deflection: T) -> T {
        let sliding = sliding.into();
        self.plastic(sliding, deflection, self.curve.coefficient(sliding), T::zero()).alpha
    }

    fn plastic(&self, sliding: Sliding<T>, deflection: T, mu: T, mu_slope: T) -> Plasticity<T> {
        let constant =
            |alpha| Plasticity { alpha, by_deflection: T::zero(), by_velocity: T::zero() };
        let aligned = sliding.direction() * deflection;
        let stiffness = self.rheology.storage_stiffness();
        let full = mu / stiffness;
        if !(aligned > self.stick_limit) {
            // Elastic; a NaN deflection stays NaN.
            return constant(if aligned.is_finite() { T::zero() } else { aligned });
        }
        if aligned >= full {
            return constant(T::one());
        }
        let width = full - self.stick_limit;
        // ½ + ½ sin(2w − π/2) = sin² w, which keeps its digits near the stick limit.
        let (sin, cos) = (T::frac_pi_2() * (aligned - self.stick_limit) / width).sin_cos();
        let slope = T::pi() * sin * cos / width;
        // dα/dz_m at fixed z, with w = (π/2)(z − z_b)/(z_m − z_b).
        let by_full = -slope * (aligned - self.stick_limit) / width;
        Plasticity {
            alpha: sin * sin,
            by_deflection: slope * sliding.direction(),
            by_velocity: by_full * mu_slope / stiffness,
        }
    }

    /// 1/g.
    #[inline]
    fn inverse(&self, sliding: Sliding<T>, series: &Series<T>, alpha: T) -> T {
        inverse_resistance(sliding, series.resistance(), |right| {
            let viscous = self.rheology.elements(right).damping * self.regularisation.speed(right);
            alpha * viscous + self.curve.coefficient(right)
        })
    }

    /// The coefficients, their derivatives with respect to the velocity, and those with respect to
    /// the deflection.
    fn affine_and_derivatives(&self, sliding: Sliding<T>, deflection: T) -> [Affine<T>; 3] {
        let (elements, elements_slope) = self.rheology.elements_and_slopes(sliding);
        let (speed, speed_slope) = self.regularisation.speed_and_slope(sliding);
        let (mu, mu_slope) = self.curve.coefficient_and_slope(sliding);
        let Plasticity { alpha, by_deflection, by_velocity } =
            self.plastic(sliding, deflection, mu, mu_slope);
        let series = Series { elements, speed: alpha * speed, mu };
        let slope = Series {
            elements: elements_slope,
            speed: alpha * speed_slope + by_velocity * speed,
            mu: mu_slope,
        };
        let zero = T::zero();
        let still = Elements { stiffness: zero, decay: zero, damping: zero };
        let along = Series { elements: still, speed: by_deflection * speed, mu: zero };
        let inverse = self.inverse(sliding, &series, alpha);
        [series.affine(inverse), series.slopes(&slope, inverse), series.slopes(&along, inverse)]
    }
}

impl<T, C, D, E> Bristle<T> for ElastoPlastic<C, KelvinVoigt<T, T, D>, E, T>
where
    T: Scalar,
    C: FrictionCurve<T>,
    D: VelocityLaw<T>,
    E: Regularisation<T>,
{
    type Deflection = T;

    #[inline]
    fn affine(&self, sliding: Sliding<T>, deflection: T) -> Affine<T> {
        let mu = self.curve.coefficient(sliding);
        let alpha = self.plastic(sliding, deflection, mu, T::zero()).alpha;
        let series = Series {
            elements: self.rheology.elements(sliding),
            speed: alpha * self.regularisation.speed(sliding),
            mu,
        };
        series.affine(self.inverse(sliding, &series, alpha))
    }

    fn affine_and_slopes(&self, sliding: Sliding<T>, deflection: T) -> (Affine<T>, Affine<T>) {
        let [affine, slopes, _] = self.affine_and_derivatives(sliding, deflection);
        (affine, slopes)
    }

    fn linearised(&self, sliding: impl Into<Sliding<T>>, deflection: T) -> Linearised<T> {
        let sliding = sliding.into();
        let velocity = sliding.velocity();
        let [affine, slopes, along] = self.affine_and_derivatives(sliding, deflection);
        let held = Linearised::new(&affine, &slopes, velocity, deflection);
        Linearised {
            rate_by_deflection: held.rate_by_deflection + along.rate(velocity, deflection),
            coefficient_by_deflection: held.coefficient_by_deflection
                + along.coefficient(velocity, deflection),
            ..held
        }
    }

    fn stationary(&self, sliding: impl Into<Sliding<T>>) -> T {
        let sliding = sliding.into();
        let coefficient = self.regularisation.sign(sliding) * self.curve.coefficient(sliding);
        coefficient / self.rheology.storage_stiffness()
    }

    fn storage_stiffness(&self) -> T {
        self.rheology.storage_stiffness()
    }

    fn obeys(&self, law: Law) -> bool {
        match law {
            // Regularised, the stationary deflection is below z_m and α is below one there.
            Law::SteadySliding => self.regularisation.speed_at_rest() == T::zero(),
            Law::Passivity | Law::NoDrift => true,
            Law::BoundedDeflection => self.limits(T::one()).deflection.is_some(),
            Law::BoundedRelaxation => self.limits(unlimited()).relaxation_rate.is_some(),
            Law::OddSymmetry => self.curve.is_even() && self.rheology.bounds().even,
            Law::Secant | Law::BoundedForce => false,
        }
    }

    fn characteristics(&self, fastest: T) -> Option<Characteristics<T>> {
        let bounds = self.rheology.bounds();
        Some(Characteristics {
            speed_at_rest: self.regularisation.speed_at_rest(),
            stick_limit: Some(self.stick_limit),
            ..Characteristics::new("elasto-plastic FrBD", &self.curve, &bounds, fastest)?
        })
    }

    fn limits(&self, fastest: T) -> Limits<T> {
        Limits::up_to(fastest, |fastest| {
            let mu = self.curve.bounds(fastest);
            let stiffness = self.rheology.storage_stiffness();
            let damping = self.rheology.bounds().damping;
            let slope = least_slope(&self.curve, &self.regularisation, fastest);
            Limits {
                deflection: finite(mu.max / stiffness),
                coefficient: None,
                relaxation_rate: finite(stiffness / (damping.min + slope)),
            }
        })
    }
}
