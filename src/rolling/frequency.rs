//! A rolling patch about a steady motion: its linearisation and frequency response.
//!
//! With z = z* + z̃, v = v* + ṽ, V = V* + Ṽ and z* = z_ss (1 − e^(−κξ)), κ = λ/V*,
//!
//! ∂z̃/∂t + V* ∂z̃/∂ξ = −λ z̃ + H₁(ξ) ṽ − (z_ss κ e^(−κξ)) Ṽ,  z̃(0, t) = 0,
//! F̃ = L ∫₀¹ p (c₀ z̃ + H₂(ξ) ṽ) dξ,
//! H₁ = b₀ + b₁ e^(−κξ),  b₀ = r + r'v* − λ'z_ss,  b₁ = λ'z_ss,
//! H₂ = c₂ + c₂'v* + c₀'z*.
//!
//! For ṽ = e^(iωt), θ = ω/V* and s = κ + iθ,
//!
//! z̃(ξ) = (b₀/V*) (1 − e^(−sξ))/s + (b₁/V*) e^(−κξ) (1 − e^(−iθξ))/(iθ):
//!
//! the first part is what the bristle at ξ has gathered since it entered, less what it would have
//! gathered before. The delays e^(−iθξ) of the bristles' ways since the inlet make the response
//! ripple with the period 2π of θ, which is ω over the rate of transits. Weighted with the
//! pressure, and with P(s) = ∫₀¹ p e^(−sξ) dξ and Q(a, b) = (P(a) − P(b))/(b − a),
//!
//! F̃/ṽ = L ((c₀/V*) (b₀ Q(0, s) + b₁ Q(κ, s)) + (c₂ + c₂'v*) P(0) + c₀'z_ss R(κ)),
//! F̃/Ũ = −c₀ z_ss (κ/V*) Q(κ, s),  V = U/L.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | H₁, H₂ | the paper's names for how ṽ drives the bristle and the force | –, s/m |
//! | ω | angular frequency | rad/s |
//! | θ | phase that passes during a transit of the patch | rad |
//!
//! Source: Romano et al. (arXiv 2602.09429), section IV-C, which gives H₁ and H₂ (the term with
//! σ0'(v) there lacks the factor z); the response in closed form is worked out here.

use nalgebra::Complex;

use super::steady::Linearisation;
use super::{Motion, Patch, Pressure, RateDependent};
use crate::Scalar;
use crate::parameter::ParameterError;

/// A patch linearised about a steady motion, see [`Patch::linearised`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearisedPatch<T, P> {
    pressure: P,
    /// L, and what multiplies the pressure.
    weight: T,
    transport: T,
    length: T,
    tangent: Linearisation<T>,
}

impl<T: Scalar, M: RateDependent<T>, P: Pressure<T>> Patch<T, M, P> {
    /// The patch linearised about a steady motion. About v = 0 it takes the middle of the one-sided
    /// slopes: there λ = 0 and λ' = 0, and it is the patch in adhesion.
    ///
    /// ```
    /// use bristle::rolling::{Motion, Patch, PatchParameters, PolynomialExponential};
    /// use bristle::{FrBd, paper};
    /// use bristle::curve::Stribeck;
    /// use bristle::rheology::KelvinVoigt;
    ///
    /// let curve = Stribeck::new(paper::TYRE_CURVE)?;
    /// let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
    /// let tyre = Patch::new(PatchParameters {
    ///     model: FrBd::new(curve, bristle),
    ///     length: paper::TYRE_LENGTH,
    ///     pressure: PolynomialExponential::constant(),
    /// })?
    /// .carrying(4000.0)?; // N
    /// let cruise = Motion { slip_velocity: 0.0, rolling_speed: 16.0 };
    /// let linearised = tyre.linearised(cruise)?;
    /// // A slow change of slip gets the slip stiffness, a fast one less and later.
    /// let slow = linearised.by_slip_velocity(1e-3);
    /// let fast = linearised.by_slip_velocity(300.0); // rad/s
    /// assert!((slow.re * 16.0 / tyre.slip_stiffness(16.0)? - 1.0).abs() < 1e-9);
    /// assert!(fast.re < slow.re && fast.im < 0.0);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Relaxation length
    ///
    /// The way after which the force has followed a small step of slip is −U Im G/(ω Re G) for ω →
    /// 0. About v = 0 and without damping it is L ∫pξ² dξ/(2 ∫pξ dξ): L/3 for constant pressure,
    /// 0.3 L for a parabola. It is that of the patch alone: what is measured on a tyre, some
    /// decimetres, is mostly its carcass, to first order slip stiffness over lateral
    /// (longitudinal) stiffness of the tyre.
    ///
    /// # Errors
    ///
    /// Refuses a motion that is not finite, and a rolling speed that is not positive.
    pub fn linearised(&self, motion: Motion<T>) -> Result<LinearisedPatch<T, P>, ParameterError> {
        let motion = self.rolling(motion)?;
        Ok(LinearisedPatch {
            pressure: self.pressure().clone(),
            weight: self.length() * self.load(),
            transport: motion.transport,
            length: self.length(),
            tangent: Linearisation::new(self.model(), motion)?,
        })
    }
}

/// Where and how fast, see [`LinearisedPatch::deflection`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave<T> {
    /// Place ξ in the patch \[–\].
    pub place: T,
    /// Angular frequency ω [rad/s].
    pub angular_frequency: T,
}

impl<T: Scalar, P: Pressure<T>> LinearisedPatch<T, P> {
    /// κ = λ/V \[–\]: how often a bristle relaxes on its way through the patch.
    #[doc(alias = "kappa")]
    pub fn decay(&self) -> T {
        self.tangent.decay
    }

    /// H₁(ξ) = b₀ + b₁ e^(−κξ) \[–\]: how the slip velocity drives the bristle at a place.
    #[doc(alias = "H1")]
    pub fn drive(&self, place: T) -> T {
        self.tangent.drive + self.tangent.fading_drive * (-self.tangent.decay * place).exp()
    }

    /// H₂(ξ) = c₂ + c₂'v + c₀'z*(ξ) [s/m]: how the slip velocity acts on the friction coefficient
    /// at a place directly.
    #[doc(alias = "H2")]
    pub fn direct(&self, place: T) -> T {
        self.tangent.direct - self.tangent.rising_direct * (-self.tangent.decay * place).exp_m1()
    }

    /// The deflection over the slip velocity, z̃(ξ)/ṽ \[s\], at a place and an angular frequency.
    pub fn deflection(&self, at: Wave<T>) -> Complex<T> {
        let Wave { place, angular_frequency } = at;
        let tangent = &self.tangent;
        let wave = Complex::new(T::zero(), angular_frequency / self.transport);
        let both = wave + Complex::from(tangent.decay);
        let age = place / self.transport;
        let gathered = super::moments::complex_phi1(both.scale(place)).scale(tangent.drive);
        let faded = super::moments::complex_phi1(wave.scale(place))
            .scale(tangent.fading_drive * (-tangent.decay * place).exp());
        (gathered + faded).scale(age)
    }

    /// The frequency response from the slip velocity to the force, F̃/ṽ [N s/m], at an angular
    /// frequency ω [rad/s] of either sign. At ω = 0 it is the slope of the steady force, see
    /// [`Patch::steady_slopes`].
    pub fn by_slip_velocity(&self, angular_frequency: T) -> Complex<T> {
        let (tangent, pressure) = (&self.tangent, &self.pressure);
        let both = self.exponent(angular_frequency);
        let gathered = pressure.transform_slope(T::zero(), both).scale(tangent.drive)
            + pressure.transform_slope(tangent.decay, both).scale(tangent.fading_drive);
        // Risen and remaining apart, of which LuGre's first is a small difference.
        let direct = (tangent.rising_direct + tangent.direct) * pressure.rise(tangent.decay)
            + tangent.direct * pressure.remaining(tangent.decay);
        (gathered.scale(tangent.stiffness / self.transport) + Complex::from(direct))
            .scale(self.weight)
    }

    /// The frequency response from the rolling speed to the force, F̃/Ũ [N s/m], at an angular
    /// frequency ω [rad/s] of either sign.
    pub fn by_rolling_speed(&self, angular_frequency: T) -> Complex<T> {
        let tangent = &self.tangent;
        let shifted =
            self.pressure.transform_slope(tangent.decay, self.exponent(angular_frequency));
        let share = tangent.decay / (self.transport * self.length);
        shifted.scale(-self.weight * tangent.stiffness * tangent.stationary * share)
    }

    /// s = κ + iω/V
    fn exponent(&self, angular_frequency: T) -> Complex<T> {
        Complex::new(self.tangent.decay, angular_frequency / self.transport)
    }
}
