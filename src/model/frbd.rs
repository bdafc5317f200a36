//! The FrBD model: its four coefficients and their slopes.

use super::{Affine, Characteristics, Form, Law, Limits, Linearised, finite};
use crate::curve::FrictionCurve;
use crate::parameter::Named;
use crate::regularisation::{Regularisation, Unregularised};
use crate::rheology::{Deflection, ElementBounds, Elements, Rheology};
use crate::scalar::is_zero;
use crate::{Bristle, Scalar, Sliding, Surface};

/// An FrBD model (friction with bristle dynamics) of a friction curve C, a bristle R and a
/// regularisation E.
///
/// **Take it by default.** It is passive and its force stays within the curve, whatever the curve
/// and the velocity, which [`LuGre`](crate::LuGre) does not promise; it has the curve's fall and a
/// damping, which [`Dahl`](crate::Dahl) has not. It is not for a body that must stand still
/// under a force that varies below breakaway: there it creeps in each cycle, and
/// [`ElastoPlastic`](crate::ElastoPlastic) does not.
///
/// For a bristle of one spring σ0 beside a dashpot σ1, with the virtual friction coefficient
/// μ_b = F/P:
///
/// ż   = −(σ0|v|_ε/g(v)) z + (μ(v)/g(v)) v,  g(v) = σ1|v|_ε + μ(v)
///
/// μ_b = σ0 z + σ1 ż = (μ(v)/g(v)) (σ0 z + σ1 v)
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | z | bristle deflection, the state | m |
/// | v | sliding velocity of the body, the input | m/s |
/// | F, P, p | friction force, positive against v > 0; reference load; normal force | N |
/// | μ(v) | friction curve, viscous part σ2\|v\| included | – |
/// | σ0, σ1 | normalised micro-stiffness and micro-damping | 1/m, s/m |
/// | \|v\|_ε | regularised modulus of the velocity, see [`Regularisation`] | m/s |
/// | sgn_ε(v) = v/\|v\|_ε | regularised sign | – |
///
/// Where σ1 is not known, a damping ratio of the stuck body gives it: see
/// [`KelvinVoigtParameters`](crate::rheology::KelvinVoigtParameters).
///
/// Steady sliding is on the curve: z = sgn_ε(v) μ(v)/σ0 and F = p μ(v) sgn_ε(v). Both equations
/// follow from the secant law F/p = (μ(v)/|v|_ε)(v − ż): the bristle is in series with a dashpot
/// μ/|v|_ε, the surface. So any other bristle R gives a model, too. One of several springs has
/// their stretches as its state, see [`Rheology`].
///
/// # Laws
///
/// The model is passive for every positive curve and every bristle of constant stiffness.
///
/// With a single spring, a deflection within max μ/σ0 stays there, the force then never exceeds
/// p max μ over the velocities met, and the relaxation rate is bounded by σ0/(σ1 + σ2) (if that is
/// finite, and σ2|0|_ε ≤ μ_d).
///
/// With several springs of stiffness Kᵢ [1/m] beside a dashpot d [s/m], the force keeps p max μ in
/// every run from rest; the relaxation rates are bounded by Σ Kᵢ/(d + σ2) plus the fastest decay
/// rate aᵢ of a spring [1/s].
///
/// On a branch locked to the other direction of sliding g falls with the speed, to zero at about
/// |v| = μ/(σ1 + σ2). Where it has fallen to half, rate and force are NaN, and a solver whose trial
/// step has come so far takes a shorter one.
///
/// Source: Romano et al. (arXiv 2602.09429), sections II-B and III-A; Lemmas III.1 and III.2.
///
/// ```
/// use bristle::{Bristle, FrBd};
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
/// let friction = FrBd::new(curve, bristle);
///
/// // Sliding at 0.1 m/s, stepped by exact 1 ms steps until it is steady:
/// let mut deflection = 0.0_f64;
/// for _ in 0..1000 {
///     deflection = friction.hold(0.1, deflection, 1e-3).deflection;
/// }
/// assert!((friction.coefficient(0.1, deflection) - 1.004).abs() < 1e-12);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct FrBd<C, R, E = Unregularised> {
    curve: C,
    rheology: R,
    #[cfg_attr(feature = "serde", serde(default))]
    regularisation: E,
}

impl<C, R> FrBd<C, R> {
    /// The model of a friction curve and a bristle, with |v| as it is.
    pub fn new<T: Scalar>(curve: C, rheology: R) -> Self
    where
        C: FrictionCurve<T>,
        R: Rheology<T>,
    {
        Self { curve, rheology, regularisation: Unregularised }
    }
}

impl<C, R, E> FrBd<C, R, E> {
    /// The model with another regularisation of |v|, which makes it smooth at v = 0. Take one if
    /// your own solver does not locate reversals, or a source gives its ε. The price: nothing
    /// sticks, see [`Regularisation`]. The solvers of [`ode`](crate::ode) need none.
    pub fn regularised<F>(self, regularisation: F) -> FrBd<C, R, F> {
        FrBd { curve: self.curve, rheology: self.rheology, regularisation }
    }

    /// The model with its curve and regularisation in other types.
    pub(super) fn map<C2, E2>(
        self,
        curve: impl FnOnce(C) -> C2,
        regularisation: impl FnOnce(E) -> E2,
    ) -> FrBd<C2, R, E2> {
        FrBd {
            curve: curve(self.curve),
            rheology: self.rheology,
            regularisation: regularisation(self.regularisation),
        }
    }

    /// The friction curve.
    pub fn curve(&self) -> &C {
        &self.curve
    }

    /// The bristle.
    pub fn rheology(&self) -> &R {
        &self.rheology
    }

    /// The regularisation.
    pub fn regularisation(&self) -> &E {
        &self.regularisation
    }

    /// g(v) = σ1|v|_ε + μ(v).
    #[cold]
    fn resistance<T>(&self, surface: Surface<T>) -> T
    where
        T: Scalar,
        C: FrictionCurve<T>,
        R: Rheology<T>,
        E: Regularisation<T>,
    {
        self.series(surface).resistance()
    }

    /// The bristle and the surface at a velocity.
    #[inline(always)]
    pub(super) fn series<T>(&self, surface: Surface<T>) -> Series<T, R::Deflection>
    where
        T: Scalar,
        C: FrictionCurve<T>,
        R: Rheology<T>,
        E: Regularisation<T>,
    {
        Series {
            elements: surface.elements(&self.rheology),
            speed: surface.regularised_speed(&self.regularisation),
            mu: surface.friction(&self.curve),
        }
    }

    /// The bristle and the surface at a velocity, and their derivatives.
    #[inline(always)]
    pub(super) fn series_and_slopes<T>(&self, surface: Surface<T>) -> [Series<T, R::Deflection>; 2]
    where
        T: Scalar,
        C: FrictionCurve<T>,
        R: Rheology<T>,
        E: Regularisation<T>,
    {
        let (elements, elements_slope) = surface.elements_and_slopes(&self.rheology);
        let (speed, speed_slope) = surface.regularised_speed_and_slope(&self.regularisation);
        let (mu, mu_slope) = surface.friction_and_slope(&self.curve);
        [
            Series { elements, speed, mu },
            Series { elements: elements_slope, speed: speed_slope, mu: mu_slope },
        ]
    }
}

/// A bristle in series with the surface at one velocity, or the derivatives of these numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Series<T, D = T> {
    pub(super) elements: Elements<T, D>,
    /// |v|_ε; for elasto-plastic FrBD α|v|_ε.
    pub(super) speed: T,
    pub(super) mu: T,
}

impl<T: Scalar, D: Deflection<T>> Series<T, D> {
    /// g = σ1|v|_ε + μ.
    #[inline(always)]
    pub(super) fn resistance(&self) -> T {
        self.elements.damping * self.speed + self.mu
    }

    /// The coefficients, from 1/g.
    #[inline(always)]
    pub(super) fn affine(&self, inverse: T) -> Affine<T, D> {
        let Elements { stiffness, decay, damping } = self.elements;
        let drive = self.mu * inverse;
        Affine {
            relaxation: D::relaxation(decay, stiffness * (self.speed * inverse)),
            drive: D::fill(drive),
            stiffness: stiffness * drive,
            damping: damping * drive,
        }
    }

    /// The derivatives of the coefficients, from those of the series and 1/g.
    #[inline(always)]
    pub(super) fn slopes(&self, slope: &Self, inverse: T) -> Affine<T, D> {
        let Self { elements, speed, mu } = *self;
        // (μ/g)' and (|v|/g)' with the products that cancel taken out by hand.
        let viscous = elements.damping * speed;
        let viscous_slope = slope.elements.damping * speed + elements.damping * slope.speed;
        let drive_slope = (viscous * slope.mu - mu * viscous_slope) * inverse * inverse;
        let (drive, share) = (mu * inverse, speed * inverse);
        let share_slope = self.share_slope(slope, inverse);
        Affine {
            relaxation: D::relaxation(
                slope.elements.decay,
                slope.elements.stiffness * share + elements.stiffness * share_slope,
            ),
            drive: D::fill(drive_slope),
            stiffness: slope.elements.stiffness * drive + elements.stiffness * drive_slope,
            damping: slope.elements.damping * drive + elements.damping * drive_slope,
        }
    }

    /// (|v|_ε/g)'.
    #[inline(always)]
    fn share_slope(&self, slope: &Self, inverse: T) -> T {
        (slope.speed * self.mu - self.speed * (slope.elements.damping * self.speed + slope.mu))
            * inverse
            * inverse
    }
}

impl<T, C, R, E> Bristle<T> for FrBd<C, R, E>
where
    T: Scalar,
    C: FrictionCurve<T>,
    R: Rheology<T>,
    E: Regularisation<T>,
{
    type Deflection = R::Deflection;

    #[inline(always)]
    fn affine(&self, surface: Surface<T>, _deflection: R::Deflection) -> Affine<T, R::Deflection> {
        let series = self.series(surface);
        let resistance = series.resistance();
        series.affine(inverse_resistance(surface, resistance, |other| self.resistance(other)))
    }

    #[inline(always)]
    fn affine_and_slopes(
        &self,
        surface: Surface<T>,
        _deflection: R::Deflection,
    ) -> (Affine<T, R::Deflection>, Affine<T, R::Deflection>) {
        let [series, slope] = self.series_and_slopes(surface);
        let resistance = series.resistance();
        let inverse = inverse_resistance(surface, resistance, |other| self.resistance(other));
        (series.affine(inverse), series.slopes(&slope, inverse))
    }

    fn stationary(&self, surface: impl Into<Surface<T>>) -> R::Deflection {
        let surface = surface.into();
        let elements = surface.elements(&self.rheology);
        let mu = surface.friction(&self.curve);
        elements.stationary(if elements.creeps() {
            // The surface, μ/|v|_ε, is in series with the dashpots.
            let speed = surface.regularised_speed(&self.regularisation);
            mu * surface.velocity() / (speed + mu * elements.fluidity())
        } else {
            surface.regularised_sign(&self.regularisation) * mu
        })
    }

    fn holding_coefficient(&self, surface: Surface<T>, carried: T) -> T {
        surface.largest_up_to(carried, |surface| surface.friction(&self.curve))
    }

    /// With N = μ v − |v|_ε Σ Kᵢxᵢ = g ż; the terms of N' that cancel in steady sliding are left
    /// out.
    fn steady_linearised(&self, surface: impl Into<Surface<T>>) -> Linearised<T, Self::Deflection> {
        let surface = surface.into();
        let deflection = self.stationary(surface);
        let [series, slope] = self.series_and_slopes(surface);
        let (sign, sign_slope) = surface.regularised_sign_and_slope(&self.regularisation);
        let Series { elements, speed, mu } = series;
        let resistance = series.resistance();
        let inverse = inverse_resistance(surface, resistance, |other| self.resistance(other));
        let (affine, slopes) = (series.affine(inverse), series.slopes(&slope, inverse));
        // ż/|v|_ε: zero unless the bristle creeps.
        let fluidity = elements.fluidity();
        let creep = if is_zero(fluidity) {
            T::zero()
        } else {
            fluidity * mu * sign / (speed + mu * fluidity)
        };
        let stiffening = slope.elements.stiffness.inner_product(deflection);
        let by_velocity = speed * inverse * (slope.mu * sign + mu * sign_slope - stiffening)
            + creep * resistance * series.share_slope(&slope, inverse);
        Linearised {
            rate_by_velocity: R::Deflection::fill(by_velocity)
                - slope.elements.decay.scaled_by(deflection),
            coefficient_by_velocity: elements.damping * by_velocity
                + slope.elements.damping * (creep * speed)
                + stiffening,
            ..Linearised::new(&affine, &slopes, surface.velocity(), deflection)
        }
    }

    fn storage_stiffness(&self) -> Self::Deflection {
        self.rheology.storage_stiffness()
    }

    fn form(&self) -> Form {
        Form::OfVelocity
    }

    fn name(&self) -> &'static str {
        if self.rheology.elements(Sliding::from(T::zero())).creeps() {
            "FrBD with a bristle that creeps"
        } else {
            "FrBD"
        }
    }

    fn obeys(&self, law: Law) -> bool {
        let bounds = self.rheology.bounds();
        match law {
            Law::Secant => true,
            Law::SteadySliding => !self.rheology.elements(Sliding::from(T::zero())).creeps(),
            Law::Passivity => bounds.stiffness.is_constant(),
            Law::BoundedForce => bounds.stiffness.is_constant() && R::Deflection::SPRINGS == 1,
            Law::BoundedDeflection => self.limits(T::one()).deflection.is_some(),
            Law::BoundedRelaxation => self.limits(T::unlimited()).relaxation_rate.is_some(),
            Law::OddSymmetry => self.curve.is_even() && bounds.even,
            Law::NoDrift => false,
        }
    }

    fn characteristics(&self, fastest: T) -> Option<Characteristics<T>> {
        let bounds = self.rheology.bounds();
        Some(Characteristics {
            speed_at_rest: self.regularisation.speed_at_rest(),
            creeps: self.rheology.elements(Sliding::from(T::zero())).creeps(),
            ..Characteristics::new("FrBD", &self.curve, &bounds, fastest)?
        })
    }

    fn limits(&self, fastest: T) -> Limits<T> {
        Limits::up_to(fastest, |fastest| {
            let mu = self.curve.bounds(fastest);
            let ElementBounds { stiffness, decay, damping, constant_decay, .. } =
                self.rheology.bounds();
            let resistance = damping.min + self.curve.least_secant(&self.regularisation, fastest);
            // The largest eigenvalue of diag(a) + (|v|/g) 1·Kᵀ is at most max a + (|v|/g) ΣK.
            let relaxation_rate = finite(stiffness.max / resistance + decay.max);
            if R::Deflection::SPRINGS == 1 {
                Limits {
                    deflection: finite(mu.max / stiffness.min),
                    coefficient: finite(mu.max * (stiffness.max / stiffness.min)),
                    relaxation_rate,
                }
            } else {
                // From rest, |F| ≤ p max μ; no box of stretches is kept. Proof: the force of the
                // springs S = Σ Kᵢ xᵢ is a convolution of ż, whose inverse is
                // ż = J(0)Ṡ + J'(0)S + ∫J''(t−τ)S(τ)dτ with their creep compliance J, J(0) > 0,
                // J' ≥ 0, J'' ≤ 0. When S is the largest so far, and not below max μ, the secant
                // law gives ż ≤ 0, and by J(0)Ṡ ≤ ż − J'(t)S ≤ 0 it rises no further. And
                // |S| ≤ max μ implies (μ/g)|S + d v| ≤ max μ.
                let linear = stiffness.is_constant() && constant_decay;
                let coefficient = if linear { finite(mu.max) } else { None };
                Limits { deflection: None, coefficient, relaxation_rate }
            }
        })
    }
}

/// 1/g, and zero where friction and damping are below what the scalar carries (10⁻²⁰⁰, `f32`
/// 10⁻³⁶): there is no friction then, as without a load. NaN on a branch locked to the other
/// direction of sliding where g has fallen to half of its value on the right one, about a third of
/// the way to its pole. NaN if g has overflowed: 0 would switch the friction off.
#[inline(always)]
pub(crate) fn inverse_resistance<T: Scalar>(
    surface: Surface<T>,
    resistance: T,
    at: impl FnOnce(Surface<T>) -> T,
) -> T {
    let inverse = T::one() / resistance;
    let admissible = if surface.speed() < T::zero() {
        resistance + resistance > at(surface.mirrored())
    } else {
        inverse > T::zero()
    };
    let carried = !(resistance < Named::<T>::smallest() * Named::<T>::smallest());
    if !admissible {
        T::nan()
    } else if carried {
        inverse
    } else {
        T::zero()
    }
}
