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
//! For ω = 0 these are the slopes of the steady force, with R' = dR/dκ = ∫₀¹ p ξ e^(−κξ) dξ,
//!
//! ∂F/∂v = L (c₀ (b₀ R/κ + b₁ R')/V + c₀'z_ss R + (c₂ + c₂'v) P(0)),
//! ∂F/∂U = −c₀ z_ss R' κ/V,
//!
//! in which nothing is divided by λ, so that v = 0 is a velocity like any other. For F̃/Ũ take
//! Q(κ, s) from [`Pressure::transform_slope`] and R' from [`Pressure::lever`]. The moment of the
//! force about the middle of the patch has L (ξ − ½) p in place of p: it is L times the response of
//! a patch under the pressure ξ p, less L/2 times that of this one.
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

use super::patch::{checked, of_velocity, slopes};
use super::{Motion, Patch, Pressure};
use bristle::parameter::Checked;
use bristle::scalar::is_zero;
use bristle::{Affine, Bristle, Scalar};

/// A patch linearised about a steady motion, see [`Patch::linearised`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearisedPatch<T, P> {
    pressure: P,
    /// L, and what multiplies the pressure.
    weight: T,
    transport: T,
    /// c₀
    stiffness: T,
    /// κ
    decay: T,
    /// b₀ = r + r'v − λ'z_ss
    b0: T,
    /// b₁ = λ'z_ss
    b1: T,
    /// c₂ + c₂'v
    direct: T,
    /// c₀'z_ss
    rising_direct: T,
}

impl<T: Scalar, M: Bristle<T, Deflection = T>, P: Pressure<T>> Patch<T, M, P> {
    /// The patch linearised about a steady motion. About v = 0 it takes the middle of the one-sided
    /// slopes: there λ = 0 and λ' = 0, and it is the patch in adhesion.
    ///
    /// ```
    /// use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential};
    /// use bristle::{FrBd, paper};
    /// use bristle::curve::Stribeck;
    /// use bristle::rheology::KelvinVoigt;
    ///
    /// let curve = Stribeck::new(paper::TYRE_CURVE)?;
    /// let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
    /// let tyre = Patch::new(PatchParameters {
    ///     model: FrBd::new(curve, bristle),
    ///     length: bristle_rolling::TYRE_LENGTH,
    ///     pressure: PolynomialExponential::constant(),
    /// })?
    /// .under_load(4000.0)?; // N
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
    pub fn linearised(&self, motion: Motion<T>) -> Checked<LinearisedPatch<T, P>> {
        let (v, transport) = (motion.slip_velocity, self.rolling(motion)?);
        of_velocity(self.model())?;
        let (affine, slopes) = slopes(self.contact(), v);
        Ok(self.linearised_about((v, transport), (checked(affine)?, slopes), T::one()))
    }

    /// The force linearised about v and V, given its coefficients and their slopes with respect to
    /// a slip velocity: its own (`share` one) or that of another axis (zero).
    pub(super) fn linearised_about(
        &self,
        (v, transport): (T, T),
        (affine, slopes): (Affine<T>, Affine<T>),
        share: T,
    ) -> LinearisedPatch<T, P> {
        let stationary = self.contact().stationary(v);
        // A slope can be infinite at rest (|v|^δ with δ < 1), where nothing is there to be
        // multiplied.
        let times = |slope: T, value: T| if is_zero(value) { T::zero() } else { slope * value };
        let b1 = times(slopes.relaxation, stationary);
        LinearisedPatch {
            pressure: self.pressure().clone(),
            weight: self.length() * self.factor,
            transport,
            stiffness: affine.stiffness,
            decay: affine.relaxation / transport,
            b0: share * affine.drive + times(slopes.drive, v) - b1,
            b1,
            direct: share * affine.damping + times(slopes.damping, v),
            rising_direct: times(slopes.stiffness, stationary),
        }
    }
}

impl<T: Scalar, P: Pressure<T>> LinearisedPatch<T, P> {
    /// κ = λ/V \[–\]: how often a bristle relaxes on its way through the patch.
    #[doc(alias = "kappa")]
    pub fn decay(&self) -> T {
        self.decay
    }

    /// H₁(ξ) = b₀ + b₁ e^(−κξ) \[–\]: how the slip velocity drives the bristle at a place.
    #[doc(alias = "H1")]
    pub fn drive(&self, place: T) -> T {
        self.b0 + self.b1 * (-self.decay * place).exp()
    }

    /// H₂(ξ) = c₂ + c₂'v + c₀'z*(ξ) [s/m]: how the slip velocity acts on the friction coefficient
    /// at a place directly.
    #[doc(alias = "H2")]
    pub fn direct(&self, place: T) -> T {
        self.direct - self.rising_direct * (-self.decay * place).exp_m1()
    }

    /// The frequency response from the slip velocity to the force, F̃/ṽ [N s/m], at an angular
    /// frequency ω [rad/s] of either sign. At ω = 0 it is ∂F/∂v, the slope of the steady force.
    /// LuGre's loses the digits by which c₀ z_ss' and c₂ exceed their sum.
    pub fn by_slip_velocity(&self, angular_frequency: T) -> Complex<T> {
        let (pressure, decay) = (&self.pressure, self.decay);
        // ∫ p H₂ dξ, risen and remaining apart: LuGre's first is a small difference.
        let direct = (self.rising_direct + self.direct) * pressure.rise(decay)
            + self.direct * pressure.remaining(decay);
        let [gathered0, gathered1] = if is_zero(angular_frequency) {
            let lever = pressure.lever(decay);
            let risen = if is_zero(decay) { lever } else { pressure.rise(decay) / decay };
            [risen, lever].map(Complex::from)
        } else {
            let both = Complex::new(decay, angular_frequency / self.transport);
            [T::zero(), decay].map(|from| pressure.transform_slope(from, both))
        };
        let gathered = gathered0.scale(self.b0) + gathered1.scale(self.b1);
        let gathered = gathered.scale(self.stiffness / self.transport);
        (gathered + Complex::from(direct)).scale(self.weight)
    }
}
