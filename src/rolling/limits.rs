//! What a patch cannot exceed: input-to-state and input-to-output stability, as numbers.
//!
//! Along the way of a bristle ż = −λ z + r v with λ ≥ 0 and 0 < r ≤ 1, so that of its deflection
//! at time t
//!
//! - the part that stems from its deflection z₀ at t = 0 is at most |z₀|, and there is none left
//!   once it has left the patch: after 1/V every bristle has entered undeflected;
//! - the part that v has made since, in the time min(t, ξ/V) it has been in the patch, is at most
//!   |v|_∞ min(t, ξ/V), and at most Z = sup |z_ss|, which it approaches at every instant:
//!
//! |z(ξ, t)| ≤ |z₀(ξ − Vt)| + a(ξ),  a(ξ) = min(|v|_∞ ξ/V, Z),  the first only where ξ > Vt.
//!
//! Input-to-state stability in the norm of L²(0, 1), with ‖a‖ ≤ Z and ‖a‖ ≤ |v|_∞/(√3 V):
//!
//! ‖z(·, t)‖ ≤ β(‖z₀‖, t) + γ(|v|_∞),  β = ‖z₀‖ for t < 1/V, then 0,
//! γ = ‖a‖ = |v|_∞/(√3 V) for q ≥ 1, Z √(1 − 2q/3) for q < 1,  q = Z V/|v|_∞.
//!
//! β jumps; it lies below e^(1 − Vt) ‖z₀‖, which is of class KL. Input-to-output stability, with
//! |c₀| ≤ C₀ and |c₂| ≤ C₂ for |v| ≤ |v|_∞:
//!
//! |F(t)| ≤ L C₀ ‖p‖_(Vt, 1) β + L (C₀ ∫₀¹ p a dξ + C₂ |v|_∞ ∫₀¹ p dξ),
//!
//! by Schwarz' inequality with the norm of p on what is left of (Vt, 1). For models with a bounded
//! force ([`Law::BoundedForce`](crate::Law::BoundedForce)) what v has made since t = 0 gives at
//! most F_z max μ, which replaces the second term where it is smaller.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | \|v\|_∞ | largest \|v\| so far | m/s |
//! | ‖z‖ | (∫₀¹ z² dξ)^½, the root mean square of the deflection | m |
//! | Z | limit of the deflection, max μ/σ0 | m |
//! | β, γ | what is left of the initial deflection, what the input can make | m |
//!
//! Source: Romano et al. (arXiv 2602.09429), section IV-B, which shows that β and γ exist and
//! gives |F| in terms of the largest p. These are sharper: a step of v in adhesion attains γ.

use super::patch::Crossing;
use super::quadrature::{PANELS, between_knots, integrate_in};
use super::{Motion, Patch, Pressure, RateDependent};
use crate::Scalar;
use crate::bounds::smaller;
use crate::parameter::{self, ParameterError};
use crate::scalar::{is_zero, lit};

/// Where the patch started from and how long ago.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Origin<T> {
    /// ‖z₀‖ \[m\]: root mean square of the initial deflection over the patch.
    pub initial_norm: T,
    /// Time t \[s\] since then, zero or positive.
    pub elapsed: T,
}

/// Limits of deflection and force, see [`Patch::limits`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchLimits<T, P> {
    pressure: P,
    /// L, and what multiplies the pressure.
    weight: T,
    fastest: T,
    /// V = U/L
    transport: T,
    /// Z; infinite if there is none.
    deflection: T,
    /// C₀, C₂
    stiffness: T,
    damping: T,
    /// max μ of a model with bounded force.
    coefficient: Option<T>,
}

impl<T: Scalar, M: RateDependent<T>, P: Pressure<T>> Patch<T, M, P> {
    /// Limits of deflection and force for every motion with |v| ≤ |v|_∞, the slip velocity given,
    /// at a constant rolling speed.
    ///
    /// ```
    /// use bristle::rolling::{Motion, Origin, Patch, PatchParameters, PolynomialExponential};
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
    /// let limits = tyre.limits(Motion { slip_velocity: 0.1, rolling_speed: 16.0 })?;
    /// // In little slip no bristle comes far enough to slide: σ0 |v| L/(2 U) of the normal force.
    /// let settled = Origin { initial_norm: 0.0, elapsed: 1.0 };
    /// assert!((limits.force(settled)? - 4000.0 * 252.0 * 0.1 / 320.0).abs() < 1e-9);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses a slip velocity that is negative or not finite, and a rolling speed that is not
    /// positive.
    pub fn limits(&self, fastest: Motion<T>) -> Result<PatchLimits<T, P>, ParameterError> {
        let Crossing { slip_velocity: fastest, transport } = self.rolling(fastest)?;
        let fastest = parameter::non_negative("slip_velocity", fastest)?;
        let limits = self.model().limits(fastest);
        let (stiffness, damping) = self.model().output_limits(fastest);
        Ok(PatchLimits {
            pressure: self.pressure().clone(),
            weight: self.length() * self.load(),
            fastest,
            transport,
            deflection: limits.deflection.unwrap_or_else(|| T::one() / T::zero()),
            stiffness,
            damping,
            coefficient: limits.coefficient,
        })
    }
}

impl<T: Scalar, P: Pressure<T>> PatchLimits<T, P> {
    /// a(ξ) = min(|v|_∞ ξ/V, Z) \[m\]: what |z| at a place cannot exceed once the initial
    /// deflection has left the patch.
    pub fn deflection(&self, place: T) -> T {
        smaller(self.deflection, self.slope() * place)
    }

    /// β(‖z₀‖, t) \[m\]: what is left of the initial deflection.
    ///
    /// # Errors
    ///
    /// Refuses an initial norm or a time that is negative or not finite.
    pub fn remainder(&self, origin: Origin<T>) -> Result<T, ParameterError> {
        let norm = parameter::non_negative("initial_norm", origin.initial_norm)?;
        let elapsed = parameter::non_negative("elapsed", origin.elapsed)?;
        let left = self.transport * elapsed < T::one();
        Ok(if left { norm } else { T::zero() })
    }

    /// γ(|v|_∞) \[m\]: the root mean square of the deflection that the motion can make.
    #[doc(alias = "gamma")]
    pub fn gain(&self) -> T {
        let three = lit::<T>(3.0);
        self.reach().map_or(self.slope() / three.sqrt(), |reached| {
            self.deflection * (T::one() - lit::<T>(2.0) / three * reached).sqrt()
        })
    }

    /// Input-to-state stability: ‖z(·, t)‖ ≤ β(‖z₀‖, t) + γ(|v|_∞) \[m\].
    ///
    /// # Errors
    ///
    /// Refuses an initial norm or a time that is negative or not finite.
    #[doc(alias = "ISS")]
    pub fn deflection_norm(&self, origin: Origin<T>) -> Result<T, ParameterError> {
        Ok(self.remainder(origin)? + self.gain())
    }

    /// Input-to-output stability: what |F(t)| \[N\] cannot exceed. Infinite for a model without a
    /// limit of c₀.
    ///
    /// # Errors
    ///
    /// Refuses an initial norm or a time that is negative or not finite.
    #[doc(alias = "IOS")]
    pub fn force(&self, origin: Origin<T>) -> Result<T, ParameterError> {
        let remainder = self.remainder(origin)?;
        let carried = self.weight * self.pressure.total();
        let entered = self.weight
            * self.stiffness
            * self.weighed(self.reach(), |place, p| p * self.deflection(place))
            + carried * self.damping * self.fastest;
        let entered = self.coefficient.map_or(entered, |most| smaller(entered, carried * most));
        if is_zero(remainder) {
            return Ok(entered);
        }
        let inlet = self.transport * origin.elapsed;
        let square =
            self.weighed(Some(inlet), |place, p| if place < inlet { T::zero() } else { p * p });
        Ok(entered + self.weight * self.stiffness * square.sqrt() * remainder)
    }

    /// |v|_∞/V \[m\]
    fn slope(&self) -> T {
        self.fastest / self.transport
    }

    /// Where the limit of the deflection is reached, if within the patch.
    fn reach(&self) -> Option<T> {
        let reached = self.deflection / self.slope();
        (reached < T::one()).then_some(reached)
    }

    /// ∫₀¹ f(ξ, p(ξ)) dξ of a function that is smooth between the knots and one more place.
    fn weighed(&self, kink: Option<T>, function: impl Fn(T, T) -> T) -> T {
        let mut sum = T::zero();
        let mut part = |from: T, width: T| {
            integrate_in(PANELS, T::zero(), |t, weight| {
                let place = from + width * t;
                sum += width * weight * function(place, self.pressure.at(place));
            });
        };
        between_knots(&self.pressure, |from, width| match kink {
            Some(kink) if kink > from && kink < from + width => {
                part(from, kink - from);
                part(kink, from + width - kink);
            }
            _ => part(from, width),
        });
        sum
    }
}
