//! The LuGre model.

use super::affine::forwards;
use super::frbd::{Series, inverse_resistance};
use super::{Affine, Characteristics, Form, FrBd, HeldStep, Law, Limits, Linearised, finite};
use crate::curve::FrictionCurve;
use crate::parameter::{Checked, Named};
use crate::regularisation::{Regularisation, Unregularised};
use crate::rheology::{Elements, HeldWeights, KelvinVoigt};
use crate::scalar::{is_zero, lit};
use crate::{Bristle, Scalar, Surface};

/// The LuGre model of a friction curve C, a [`KelvinVoigt`] bristle R and a regularisation E.
///
/// With the virtual friction coefficient μ_b = F/P:
///
/// ż   = v − (σ0|v|_ε/g(v)) z
///
/// μ_b = σ0 z + σ1 ż + σ2 v
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | z | bristle deflection, the state | m |
/// | v | sliding velocity of the body, the input | m/s |
/// | F, P | friction force, positive against v > 0; reference load, p if constant | N |
/// | g(v) | friction curve inside the bristle, in [`LuGre::classical`] without viscous part | – |
/// | σ0, σ1 | normalised micro-stiffness, micro-damping | 1/m, s/m |
/// | σ2 | viscous friction outside g: taken out of the curve, or a number of its own | s/m |
/// | \|v\|_ε | regularised modulus of the velocity | m/s |
///
/// Steady sliding is F = p (g(v) sgn_ε(v) + σ2 v), with sgn_ε(v) = v/|v|_ε. Under a friction scale
/// s read s g, s σ1 and s σ2: with σ1 unscaled the σ2 that passivity needs would grow as 1/s.
///
/// Take it where LuGre's own parameters or figures are given. [`FrBd`] with the same curve and
/// bristle has the same steady sliding and the laws that LuGre lacks.
///
/// | constructor | take it if |
/// |---|---|
/// | [`LuGre::classical`] | as published: the σ2\|v\| of the curve stands outside g, as σ2 v |
/// | [`LuGre::with_viscous_friction`] | you state σ2 apart from the curve, which is g as it is |
/// | [`LuGre::of_frbd`] | you have an FrBD model, with its regularisation |
///
/// With σ2 = 0 the second is the variant with the viscous part of the curve inside g. The third
/// checks nothing and cannot fail: for a loop that builds a model in each pass, from numbers that
/// were checked once.
///
/// # Laws
///
/// A deflection within max g/σ0 stays there. The model is passive only with enough viscous
/// friction, σ2 ≥ σ1(μ_s − μ_d)/μ_d for the classical model. Its force has no
/// limit: at z = 0 it is p (σ1 + σ2) v.
///
/// Source: C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, "A new model for control of
/// systems with friction", IEEE Transactions on Automatic Control 40 (1995), 419–425.
///
/// ```
/// use bristle::{Bristle, Law, LuGre};
/// use bristle::curve::{Stribeck, StribeckParameters};
/// use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
///
/// let curve = Stribeck::new(StribeckParameters {
///     static_coefficient: 1.5,
///     dynamic_coefficient: 1.0,
///     stribeck_velocity: 0.01,
///     stribeck_exponent: 2.0,
///     viscous_friction: 0.04,
/// })?;
/// let bristle = KelvinVoigt::new(KelvinVoigtParameters {
///     micro_stiffness: 1e4,
///     micro_damping: 64.5,
/// })?;
/// let friction = LuGre::classical(curve, bristle);
/// assert!(!friction.obeys(Law::Passivity));
/// assert_eq!(friction.coefficient(1.0, 0.0), 64.54);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LuGre<C, R, E = Unregularised, T = f64> {
    /// The FrBD model of the curve g, with which it shares springs and steady deflection.
    frbd: FrBd<C, R, E>,
    /// σ2 of the term outside g
    viscous: T,
}

impl<T: Scalar, C: FrictionCurve<T>> LuGre<C, KelvinVoigt<T>, Unregularised, T> {
    /// The classical model: the viscous part σ2|v| of the curve, if it has one, stands outside g as
    /// σ2 v.
    pub fn classical(curve: C, rheology: KelvinVoigt<T>) -> Self {
        let inside = curve.without_viscous_friction();
        // What has been taken out of the curve, neither more nor less.
        let viscous = curve.viscous_friction() - inside.viscous_friction();
        Self { frbd: FrBd::new(inside, rheology), viscous }
    }

    /// The model of a curve g(v), taken as it is, and a viscous friction σ2 [s/m] outside it. With
    /// σ2 = 0 all viscous friction is that of the curve, inside g.
    ///
    /// # Errors
    ///
    /// Refuses a viscous friction that is negative or not finite.
    pub fn with_viscous_friction(
        curve: C,
        rheology: KelvinVoigt<T>,
        viscous_friction: T,
    ) -> Checked<Self> {
        let viscous = Named("viscous_friction", viscous_friction).non_negative()?;
        Ok(Self { frbd: FrBd::new(curve, rheology), viscous })
    }
}

impl<T: Scalar, C, R, E> LuGre<C, R, E, T> {
    /// The LuGre model with curve g, bristle and regularisation of an FrBD model, and a viscous
    /// friction σ2 [s/m] outside the curve. Nothing is checked, unlike in
    /// [`LuGre::with_viscous_friction`]: under a negative σ2 every force is NaN. With a bristle
    /// other than [`KelvinVoigt`] the result is no [`Bristle`].
    #[inline]
    pub fn of_frbd(frbd: FrBd<C, R, E>, viscous_friction: T) -> Self {
        let viscous = if viscous_friction >= T::zero() { viscous_friction } else { T::nan() };
        Self { frbd, viscous }
    }

    /// The model with another regularisation of |v|; when to take one: [`FrBd::regularised`].
    pub fn regularised<F>(self, regularisation: F) -> LuGre<C, R, F, T> {
        LuGre { frbd: self.frbd.regularised(regularisation), viscous: self.viscous }
    }

    /// The model with its curve and regularisation in other types.
    pub(super) fn map<C2, E2>(
        self,
        curve: impl FnOnce(C) -> C2,
        regularisation: impl FnOnce(E) -> E2,
    ) -> LuGre<C2, R, E2, T> {
        let frbd = self.frbd.map(curve, regularisation);
        LuGre { frbd, viscous: self.viscous }
    }

    /// The curve g(v) of steady sliding, without the viscous term outside it.
    pub fn curve(&self) -> &C {
        self.frbd.curve()
    }

    /// The bristle.
    pub fn rheology(&self) -> &R {
        self.frbd.rheology()
    }

    /// The regularisation.
    pub fn regularisation(&self) -> &E {
        self.frbd.regularisation()
    }
}

impl<T: Scalar, C: FrictionCurve<T>, E: Regularisation<T>> LuGre<C, KelvinVoigt<T>, E, T> {
    /// The viscous friction σ2 [s/m] of the term σ2 v outside g; zero for the variant with the
    /// viscous part inside.
    #[doc(alias = "sigma2")]
    pub fn viscous_friction(&self) -> T {
        self.viscous
    }

    /// σ1
    fn damping(&self) -> T {
        self.rheology().parameters().micro_damping
    }

    /// Whether the bristle damps nothing and nothing viscous stands outside g: then the model is
    /// the undamped FrBD one.
    fn is_undamped(&self) -> bool {
        self.viscous == T::zero() && self.damping() == T::zero()
    }

    /// g on the other branch.
    #[cold]
    fn opposite(&self, surface: Surface<T>) -> T {
        surface.friction(self.curve())
    }

    /// 1/g and the coefficients, from the bristle and the surface at a velocity.
    #[inline(always)]
    fn frozen(&self, surface: Surface<T>, series: &Series<T>) -> (T, Affine<T>) {
        let Series { elements, speed, mu: g } = *series;
        let inverse = inverse_resistance(surface, g, |other| self.opposite(other));
        let relaxation = elements.stiffness * speed * inverse;
        let affine = Affine {
            relaxation,
            drive: T::one(),
            // σ1 and σ2 scale as g does, and λ inversely.
            stiffness: elements.stiffness - surface.apply(elements.damping) * relaxation,
            damping: surface.apply(elements.damping + self.viscous),
        };
        (inverse, affine)
    }

    /// Sufficient conditions for F v ≥ Ẇ at every velocity and admissible deflection.
    ///
    /// F v − Ẇ = p (σ0λz² − σ1λ z v + (σ1 + σ2)v²), with λ|z| ≤ |v| max g/min g.
    fn is_passive(&self) -> bool {
        let g = self.curve().bounds(T::unlimited());
        let damping = self.damping();
        let exact = self.regularisation().speed_at_rest() == T::zero();
        // The cross term is covered by the two squares for every z: σ1²λ ≤ 4σ0(σ1 + σ2).
        let slope = self.curve().least_secant(self.regularisation(), T::unlimited());
        let by_squares = damping * damping <= lit::<T>(4.0) * slope * (damping + self.viscous);
        // Or by the damping alone for |z| ≤ max g/σ0: σ1(max g/min g) ≤ σ1 + σ2.
        let by_limit = exact && damping * (g.max - g.min) <= self.viscous * g.min;
        damping == T::zero() || by_squares || by_limit
    }
}

impl<T, C, E> Bristle<T> for LuGre<C, KelvinVoigt<T>, E, T>
where
    T: Scalar,
    C: FrictionCurve<T>,
    E: Regularisation<T>,
{
    type Deflection = T;

    #[inline(always)]
    fn affine(&self, surface: Surface<T>, _deflection: T) -> Affine<T> {
        self.frozen(surface, &self.frbd.series(surface)).1
    }

    #[inline(always)]
    fn affine_and_slopes(&self, surface: Surface<T>, _deflection: T) -> (Affine<T>, Affine<T>) {
        let [series, slope] = self.frbd.series_and_slopes(surface);
        let (inverse, affine) = self.frozen(surface, &series);
        let Series { elements, speed, .. } = series;
        let relaxation_slope =
            elements.stiffness * (slope.speed - speed * slope.mu * inverse) * inverse;
        let slopes = Affine {
            relaxation: relaxation_slope,
            drive: T::zero(),
            stiffness: -surface.apply(elements.damping) * relaxation_slope,
            damping: T::zero(),
        };
        (affine, slopes)
    }

    /// The exact step, with σ1 ż from the rate at its start, which decays. In c₀ z + c₂ v the term
    /// σ1 v of fast sliding would cancel, and with it half the digits of an `f32`.
    #[inline]
    fn hold(&self, surface: impl Into<Surface<T>>, deflection: T, duration: T) -> HeldStep<T> {
        let surface = surface.into();
        let velocity = surface.velocity();
        let affine = self.affine(surface, deflection);
        let weights = affine.weights(forwards(duration));
        let (end, mean) = (weights.end(deflection, velocity), weights.mean(deflection, velocity));
        let Elements { stiffness, damping, .. } = surface.elements(self.rheology());
        let rate = surface.apply(damping) * affine.rate(velocity, deflection);
        let viscous = surface.apply(self.viscous) * velocity;
        // e⁻ˣ and φ1 of the rate are its value at the end and its mean.
        let (one, zero) = (T::one(), T::zero());
        HeldStep {
            deflection: end,
            end_coefficient: stiffness * end + weights.end(one, zero) * rate + viscous,
            mean_coefficient: stiffness * mean + weights.mean(one, zero) * rate + viscous,
        }
    }

    fn stationary(&self, surface: impl Into<Surface<T>>) -> T {
        self.frbd.stationary(surface)
    }

    /// ∂ż/∂v = (|v|_ε/g)(g sgn_ε)' and ∂μ_b/∂v = σ1 ∂ż/∂v + σ2: the terms that cancel in steady
    /// sliding are left out.
    fn steady_linearised(&self, surface: impl Into<Surface<T>>) -> Linearised<T> {
        let surface = surface.into();
        let (affine, slopes) = self.affine_and_slopes(surface, T::zero());
        let (sign, sign_slope) = surface.regularised_sign_and_slope(self.regularisation());
        let (g, g_slope) = surface.friction_and_slope(self.curve());
        let Elements { stiffness, damping, .. } = surface.elements(self.rheology());
        let by_velocity = affine.relaxation / stiffness * (g_slope * sign + g * sign_slope);
        Linearised {
            rate_by_velocity: by_velocity,
            coefficient_by_velocity: surface.apply(damping) * by_velocity
                + surface.apply(self.viscous),
            ..Linearised::new(&affine, &slopes, surface.velocity(), self.stationary(surface))
        }
    }

    fn stationary_coefficient(&self, surface: impl Into<Surface<T>>) -> T {
        // σ1 ż is zero; in c₀ z + c₂ v it would be the difference of two large numbers.
        let surface = surface.into();
        surface.regularised_sign(self.regularisation()) * surface.friction(self.curve())
            + surface.apply(self.viscous) * surface.velocity()
    }

    fn storage_stiffness(&self) -> T {
        self.frbd.storage_stiffness()
    }

    fn holding_coefficient(&self, surface: Surface<T>, carried: T) -> T {
        self.frbd.holding_coefficient(surface, carried)
    }

    fn form(&self) -> Form {
        Form::OfVelocity
    }

    fn name(&self) -> &'static str {
        "LuGre"
    }

    fn obeys(&self, law: Law) -> bool {
        match law {
            Law::SteadySliding => true,
            Law::Secant | Law::BoundedForce => self.is_undamped(),
            Law::Passivity => self.is_passive(),
            Law::BoundedDeflection => self.limits(T::one()).deflection.is_some(),
            Law::BoundedRelaxation => self.limits(T::unlimited()).relaxation_rate.is_some(),
            Law::OddSymmetry => self.frbd.obeys(law),
            Law::NoDrift => false,
        }
    }

    fn characteristics(&self, fastest: T) -> Option<Characteristics<T>> {
        let inside = self.curve().viscous_friction() > T::zero();
        let name = if inside { "LuGre, viscous part inside g" } else { "classical LuGre" };
        let g = self.curve().bounds(T::unlimited());
        // Necessary and sufficient for an exact modulus, where g is bounded.
        let exact = is_zero(self.regularisation().speed_at_rest());
        let needed = finite(self.damping() * (g.max - g.min) / g.min).filter(|_| exact);
        Some(Characteristics {
            name,
            viscous_friction: self.viscous,
            needed_viscous_friction: needed,
            ..self.frbd.characteristics(fastest)?
        })
    }

    fn limits(&self, fastest: T) -> Limits<T> {
        Limits::up_to(fastest, |fastest| {
            let g = self.curve().bounds(fastest);
            let stiffness = self.frbd.storage_stiffness();
            let slope = self.curve().least_secant(self.regularisation(), fastest);
            Limits {
                deflection: finite(g.max / stiffness),
                coefficient: if self.is_undamped() { finite(g.max) } else { None },
                relaxation_rate: finite(stiffness / slope),
            }
        })
    }
}
