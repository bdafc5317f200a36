//! The elasto-plastic FrBD model.

use super::frbd::{Series, inverse_resistance};
use super::{Affine, Characteristics, FrBd, Law, Limits, Linearised};
use crate::curve::FrictionCurve;
use crate::parameter::{Checked, Named};
use crate::regularisation::{Regularisation, Unregularised};
use crate::rheology::{Elements, KelvinVoigt, Rheology};
use crate::scalar::is_zero;
use crate::{Bristle, Scalar, Surface};

/// The elasto-plastic FrBD model of a friction curve C, a [`KelvinVoigt`] bristle R of constant
/// stiffness and a regularisation E: below a stick limit z_b \[m\] the bristle is purely elastic.
///
/// With the symbols of [`FrBd`](crate::FrBd) and the virtual friction coefficient μ_b = F/P:
///
/// ż   = −(ασ0|v|_ε/g) z + (μ/g) v,  g = ασ1|v|_ε + μ(v)
///
/// μ_b = (μ/g)(σ0 z + σ1 v)
///
/// The plasticity α(z, v) \[–\] is 0 up to |z| = z_b and wherever z and v have opposite signs, 1
/// from the stationary deflection z_m = μ(v)/σ0 \[m\] on, and in between
///
/// α = ½ + ½ sin(π (|z| − (z_m + z_b)/2)/(z_m − z_b)).
///
/// Under a friction scale s the limit is s z_b.
///
/// **Take it where a force that varies below breakaway must not move the body:** a held part, an
/// axis under vibration, a locked clutch. With α = 0 the bristle follows the body, ż = v, so that
/// force cycles below p σ0 z_b cause no drift; [`FrBd`](crate::FrBd), LuGre and Dahl creep in each
/// cycle. It has three prices:
///
/// - Its coefficients depend on z ([`Form::Switched`](crate::Form::Switched)): observers, patches
///   and batches refuse it.
/// - Its force may exceed p max μ while α < 1.
/// - A step freezes α at its beginning, which is of first order, and a fast body meets a spring
///   where it should slide. [`Companion::step_about`](crate::companion::Companion::step_about)
///   freezes α at a predicted deflection, z + ½ h v for a step of length h, and is of second order:
///   take it for this model.
///
/// α has kinks where |z| passes s z_b and z_m, and adaptive steps shall end there. Scenes and
/// mechanisms tell a solver of them; in a system of your own hand them on
/// ([`ode::System::switching_functions`](crate::ode::System::switching_functions)).
///
/// Source: P. Dupont, V. Hayward, B. Armstrong, F. Altpeter, "Single state elastoplastic friction
/// models", IEEE Transactions on Automatic Control 47 (2002), 787–792, in the FrBD model of Romano
/// et al. (arXiv 2602.09429), section III-A.
///
/// ```
/// use bristle::{Bristle, ElastoPlastic};
/// use bristle::curve::{Coulomb, CoulombParameters};
/// use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
///
/// let curve =
///     Coulomb::new(CoulombParameters { dynamic_coefficient: 1.0, viscous_friction: 0.0 })?;
/// let bristle =
///     KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness: 1e4, micro_damping: 60.0 })?;
/// let friction = ElastoPlastic::new(curve, bristle, 5e-5)?;
/// // Below the stick limit the bristle follows the body.
/// assert_eq!(friction.rate(0.01, 4e-5), 0.01);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElastoPlastic<C, R, E = Unregularised, T = f64> {
    /// The model for α = 1.
    plastic: FrBd<C, R, E>,
    stick_limit: T,
}

impl<T: Scalar, C: FrictionCurve<T>> ElastoPlastic<C, KelvinVoigt<T>, Unregularised, T> {
    /// The model with a stick limit z_b \[m\], positive and below min μ/σ0. To measure it, pull
    /// slowly and let go: p σ0 z_b is the largest force after which the body comes back to where it
    /// was. Not measured, take half of μ_d/σ0. Near min μ/σ0 it yields sharply, which needs short
    /// steps.
    ///
    /// # Errors
    ///
    /// Refuses a stick limit that is not positive or not below min μ/σ0.
    #[doc(alias = "breakaway")]
    pub fn new(curve: C, rheology: KelvinVoigt<T>, stick_limit: T) -> Checked<Self> {
        Named("stick_limit", stick_limit).positive()?;
        let least = curve.bounds(T::unlimited()).min / rheology.storage_stiffness();
        Named("stick_limit", stick_limit).below("min μ/σ0", least)?;
        Ok(Self { plastic: FrBd::new(curve, rheology), stick_limit })
    }
}

impl<T: Scalar, C, R, E> ElastoPlastic<C, R, E, T> {
    /// The model with another regularisation of |v|; when to take one: [`FrBd::regularised`].
    pub fn regularised<F>(self, regularisation: F) -> ElastoPlastic<C, R, F, T> {
        let plastic = self.plastic.regularised(regularisation);
        ElastoPlastic { plastic, stick_limit: self.stick_limit }
    }

    /// The [`FrBd`] model of the same curve, bristle and regularisation, which is this one with
    /// α = 1 throughout. Take it to read these parts, or to compare the two.
    pub fn plastic(&self) -> &FrBd<C, R, E> {
        &self.plastic
    }

    /// The stick limit z_b \[m\].
    pub fn stick_limit(&self) -> T {
        self.stick_limit
    }

    /// The model with its curve and regularisation in other types.
    pub(super) fn map<C2, E2>(
        self,
        curve: impl FnOnce(C) -> C2,
        regularisation: impl FnOnce(E) -> E2,
    ) -> ElastoPlastic<C2, R, E2, T> {
        let plastic = self.plastic.map(curve, regularisation);
        ElastoPlastic { plastic, stick_limit: self.stick_limit }
    }
}

impl<T: Scalar, C: FrictionCurve<T>, E: Regularisation<T>> ElastoPlastic<C, KelvinVoigt<T>, E, T> {
    /// The plasticity α \[–\] at a state: 0 for an elastic bristle, 1 for one that slides as
    /// FrBD's.
    #[doc(alias = "alpha")]
    pub fn plasticity(&self, surface: impl Into<Surface<T>>, deflection: T) -> T {
        let surface = surface.into();
        self.alpha(surface, deflection, surface.friction(self.plastic.curve()), T::zero())[0]
    }

    /// α and its derivatives with respect to the deflection and to the velocity.
    fn alpha(&self, surface: Surface<T>, deflection: T, mu: T, mu_slope: T) -> [T; 3] {
        let (zero, aligned) = (T::zero(), surface.direction() * deflection);
        let stiffness = self.storage_stiffness();
        let full = mu / stiffness;
        // s z_b; without friction the bristle is plastic.
        let stick_limit = surface.apply(self.stick_limit);
        if !(surface.scale() > T::zero()) {
            return [T::one() + surface.scale(), zero, zero];
        }
        if !(aligned > stick_limit) {
            // Elastic; a NaN deflection stays NaN.
            return [if aligned.is_finite() { zero } else { aligned }, zero, zero];
        }
        if aligned >= full {
            return [T::one(), zero, zero];
        }
        let width = full - stick_limit;
        // ½ + ½ sin(2w − π/2) = sin² w, which keeps its digits near the stick limit.
        let (sin, cos) = (T::frac_pi_2() * (aligned - stick_limit) / width).sin_cos();
        let slope = T::pi() * sin * cos / width;
        // dα/dz_m at fixed z, with w = (π/2)(z − z_b)/(z_m − z_b).
        let by_full = -slope * (aligned - stick_limit) / width;
        [sin * sin, slope * surface.direction(), by_full * mu_slope / stiffness]
    }

    /// 1/g.
    #[inline]
    fn inverse(&self, surface: Surface<T>, series: &Series<T>, alpha: T) -> T {
        inverse_resistance(surface, series.resistance(), |right| {
            let Series { elements, speed, mu } = self.plastic.series(right);
            alpha * elements.damping * speed + mu
        })
    }

    /// The coefficients, their derivatives with respect to the velocity, and those with respect to
    /// the deflection.
    fn affine_and_derivatives(&self, surface: Surface<T>, deflection: T) -> [Affine<T>; 3] {
        let [mut series, mut slope] = self.plastic.series_and_slopes(surface);
        let [alpha, by_deflection, by_velocity] =
            self.alpha(surface, deflection, series.mu, slope.mu);
        let (zero, speed) = (T::zero(), series.speed);
        series.speed = alpha * speed;
        slope.speed = alpha * slope.speed + by_velocity * speed;
        let still = Elements { stiffness: zero, decay: zero, damping: zero };
        let along = Series { elements: still, speed: by_deflection * speed, mu: zero };
        let inverse = self.inverse(surface, &series, alpha);
        [series.affine(inverse), series.slopes(&slope, inverse), series.slopes(&along, inverse)]
    }
}

impl<T, C, E> Bristle<T> for ElastoPlastic<C, KelvinVoigt<T>, E, T>
where
    T: Scalar,
    C: FrictionCurve<T>,
    E: Regularisation<T>,
{
    type Deflection = T;

    #[inline]
    fn affine(&self, surface: Surface<T>, deflection: T) -> Affine<T> {
        let mut series = self.plastic.series(surface);
        let [alpha, ..] = self.alpha(surface, deflection, series.mu, T::zero());
        series.speed *= alpha;
        series.affine(self.inverse(surface, &series, alpha))
    }

    fn affine_and_slopes(&self, surface: Surface<T>, deflection: T) -> (Affine<T>, Affine<T>) {
        let [affine, slopes, _] = self.affine_and_derivatives(surface, deflection);
        (affine, slopes)
    }

    fn linearised(&self, surface: impl Into<Surface<T>>, deflection: T) -> Linearised<T> {
        let surface = surface.into();
        let velocity = surface.velocity();
        let [affine, slopes, along] = self.affine_and_derivatives(surface, deflection);
        let mut linearised = Linearised::new(&affine, &slopes, velocity, deflection);
        linearised.rate_by_deflection += along.rate(velocity, deflection);
        linearised.coefficient_by_deflection += along.coefficient(velocity, deflection);
        linearised
    }

    fn stationary(&self, surface: impl Into<Surface<T>>) -> T {
        self.plastic.stationary(surface)
    }

    fn storage_stiffness(&self) -> T {
        self.plastic.storage_stiffness()
    }

    /// (z − s z_b)(z − z_m) \[m²\] with z along the sliding: α has kinks at both.
    fn switching_function(&self, surface: Surface<T>, deflection: T) -> Option<T> {
        let aligned = surface.direction() * deflection;
        let full = surface.friction(self.plastic.curve()) / self.storage_stiffness();
        Some((aligned - surface.apply(self.stick_limit)) * (aligned - full))
    }

    fn holding_coefficient(&self, surface: Surface<T>, carried: T) -> T {
        self.plastic.holding_coefficient(surface, carried)
    }

    fn name(&self) -> &'static str {
        "elasto-plastic FrBD"
    }

    fn obeys(&self, law: Law) -> bool {
        match law {
            // Regularised, the stationary deflection is below z_m and α is below one there.
            Law::SteadySliding => is_zero(self.plastic.regularisation().speed_at_rest()),
            Law::NoDrift => true,
            Law::Secant | Law::BoundedForce => false,
            Law::Passivity | Law::BoundedDeflection | Law::BoundedRelaxation | Law::OddSymmetry => {
                self.plastic.obeys(law)
            }
        }
    }

    fn characteristics(&self, fastest: T) -> Option<Characteristics<T>> {
        Some(Characteristics {
            name: "elasto-plastic FrBD",
            stick_limit: Some(self.stick_limit),
            ..self.plastic.characteristics(fastest)?
        })
    }

    fn limits(&self, fastest: T) -> Limits<T> {
        Limits { coefficient: None, ..self.plastic.limits(fastest) }
    }
}
