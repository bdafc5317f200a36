//! Steady rolling: held slip velocity v and rolling speed U, with V = U/L.
//!
//! V dz/dξ = −λ z + r v with z(0) = 0 is solved by z = z_ss (1 − e^(−κξ)), κ = λ/V, z_ss = r v/λ.
//! Since c₀ z_ss + c₂ v = μ_ss, the friction coefficient of steady sliding,
//!
//! μ_b(ξ) = μ_ss (1 − e^(−κξ)) + c₂ v e^(−κξ),
//! F = L (μ_ss R(κ) + c₂ v (P − R(κ))),  R(κ) = ∫₀¹ p (1 − e^(−κξ)) dξ,  P = ∫₀¹ p dξ:
//!
//! a bristle enters with the coefficient c₂ v of its dashpot and changes over to that of sliding.
//! Both terms have the same sign, so that no digits are lost at any slip, and the form holds for
//! every model.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | κ | relaxation of a bristle over one transit: small is adhesion, large sliding | – |
//! | z_ss | deflection of steady sliding | m |
//! | μ_ss | friction coefficient of steady sliding | – |
//! | R, P | what of the pressure rises with the deflection, and all of it | N/m |
//!
//! Source: Romano et al. (arXiv 2602.09429), section IV-A, where the force is written out for
//! constant, exponential and parabolic pressure.

use super::patch::{Frozen, coefficients};
use super::quadrature::weigh;
use super::{Motion, Patch, Pressure};
use bristle::parameter::{Checked, Named};
use bristle::root::enclose;
use bristle::scalar::{is_zero, lit};
use bristle::{Bristle, Contact, Scalar};

/// A patch in steady rolling, see [`Patch::steady`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steady<T> {
    /// The friction force F \[N\].
    pub force: T,
    /// κ = λ/V \[–\]: how often a bristle relaxes on its way through the patch. Infinite for a
    /// patch that slides without rolling.
    #[doc(alias = "kappa")]
    pub decay: T,
    /// z_ss \[m\]: the deflection that bristles approach.
    pub stationary_deflection: T,
    /// μ_ss \[–\]: the friction coefficient that they approach.
    pub stationary_coefficient: T,
    /// c₂ v \[–\]: the friction coefficient of a bristle that has just entered.
    pub entry_coefficient: T,
}

impl<T: Scalar> Steady<T> {
    /// The deflection z(ξ) = z_ss (1 − e^(−κξ)) \[m\] at a place.
    pub fn deflection(&self, place: T) -> T {
        self.stationary_deflection * self.risen(place)
    }

    /// The virtual friction coefficient μ_b(ξ) = μ_ss (1 − e^(−κξ)) + c₂ v e^(−κξ) \[–\] at a
    /// place.
    pub fn coefficient(&self, place: T) -> T {
        self.stationary_coefficient * self.risen(place) + self.entry_coefficient * self.left(place)
    }

    fn risen(&self, place: T) -> T {
        if self.decay.is_finite() { -(-self.decay * place).exp_m1() } else { T::one() }
    }

    fn left(&self, place: T) -> T {
        if self.decay.is_finite() { (-self.decay * place).exp() } else { T::zero() }
    }
}

impl<T: Scalar, M, P: Pressure<T>> Patch<T, M, P> {
    /// The steady rolling of an axis.
    pub(super) fn steady_of<K: Bristle<T, Deflection = T>>(
        &self,
        contact: &Contact<T, K>,
        frozen: Frozen<T>,
    ) -> Steady<T> {
        let Frozen { affine, slip_velocity: v, transport } = frozen;
        let still = is_zero(affine.relaxation);
        let surface = contact.surface(v);
        let stationary_coefficient = if is_zero(surface.scale()) {
            T::zero()
        } else {
            contact.model().stationary_coefficient(surface)
        };
        let steady = Steady {
            force: T::zero(),
            decay: if still { T::zero() } else { affine.relaxation / transport },
            stationary_deflection: contact.stationary(v),
            stationary_coefficient,
            entry_coefficient: affine.damping * v,
        };
        // μ_ss R(κ) + c₂ v (P − R(κ))
        let carried = steady.stationary_coefficient * self.pressure().rise(steady.decay)
            + steady.entry_coefficient * self.pressure().remaining(steady.decay);
        Steady { force: self.length() * self.factor * carried, ..steady }
    }
}

impl<T: Scalar, M: Bristle<T, Deflection = T>, P: Pressure<T>> Patch<T, M, P> {
    /// The patch in steady rolling: force and profile in closed form. With V = 0 it slides without
    /// rolling and F = F_z μ_ss(v); with v = 0 there is no force.
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
    /// let motion = Motion { slip_velocity: 0.05 * 16.0, rolling_speed: 16.0 }; // m/s
    /// let steady = tyre.steady(motion)?;
    /// assert!((steady.force - 4000.0 * 0.348954).abs() < 4000.0 * 5e-7);
    /// // κ = 2.1: at the outlet bristles have 88 % of the deflection of full sliding.
    /// assert!((steady.deflection(1.0) / steady.stationary_deflection - 0.88).abs() < 0.005);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses a motion that is not finite, and a negative rolling speed.
    pub fn steady(&self, motion: Motion<T>) -> Checked<Steady<T>> {
        let [frozen] = self.frozen(motion)?;
        Ok(self.steady_of(self.contact(), frozen))
    }

    /// Slip stiffness: the slope dF/ds \[N\] of the steady force over the slip ratio s = v/U at s
    /// = 0. For a lateral force it is the cornering stiffness [N/rad].
    ///
    /// dF/ds = L² (σ0 ∫₀¹ p ξ dξ + c₂(0) V P) for a model without regularisation: friction itself
    /// is not in it, and the rolling speed only with a damped bristle.
    ///
    /// # Errors
    ///
    /// Refuses a rolling speed that is not positive.
    pub fn slip_stiffness(&self, rolling_speed: T) -> Checked<T> {
        let about = self.linearised(Motion { slip_velocity: T::zero(), rolling_speed })?;
        Ok(about.by_slip_velocity(T::zero()).re * rolling_speed)
    }

    /// The peak of the steady force over the slip: its highest maximum at slip velocities between 0
    /// and a given one (of either sign), at a rolling speed. None where the force only grows.
    ///
    /// [`Patch::steady`] at the motion of the peak tells its force.
    ///
    /// Maxima are looked for at 600 slips in geometric progression over the six decades below the
    /// given one, and then found to rounding as zeros of the slope.
    ///
    /// # Errors
    ///
    /// Refuses a slip velocity that is not finite or zero, a rolling speed that is not positive,
    /// and a slip on the way at which a coefficient of the model is not finite.
    pub fn peak(&self, up_to: Motion<T>) -> Checked<Option<Motion<T>>> {
        const SLIPS: usize = 600;
        const DECADES: f64 = 6.0;
        self.rolling(up_to)?;
        let most = Named("magnitude of slip_velocity", up_to.slip_velocity.abs()).positive()?;
        // The magnitude of the force over that of the slip, and its slope: of checked motions, so
        // that neither can fail.
        let sign = if up_to.slip_velocity < T::zero() { -T::one() } else { T::one() };
        let at = |slip: T| Motion { slip_velocity: sign * slip, ..up_to };
        let force = |slip: T| self.steady(at(slip)).map_or(T::zero(), |steady| sign * steady.force);
        let slope = |slip: T| {
            self.linearised(at(slip)).map_or(T::zero(), |at| at.by_slip_velocity(T::zero()).re)
        };
        let higher = |a: Option<(T, T)>, b: Option<(T, T)>| {
            a.into_iter().chain(b).reduce(|a, b| if b.1 > a.1 { b } else { a })
        };
        // A maximum counts once the force has fallen by more than rounding.
        let fallen = T::one() - lit::<T>(512.0) * T::default_epsilon();
        // Slip and force of the best maximum, and of those that do not count yet.
        let (mut best, mut candidate) = (None, None);
        let mut before: Option<(T, T)> = None;
        for number in 1..=SLIPS {
            let decades = DECADES * (number as f64 / SLIPS as f64 - 1.0);
            let slip = most * lit::<T>(core::f64::consts::LN_10 * decades).exp();
            coefficients(self.contact(), sign * slip)?;
            let here = (slip, slope(slip));
            let rising = before.filter(|&(_, slope)| slope > T::zero() && !(here.1 > T::zero()));
            if let Some(rising) = rising {
                let (found, _) = enclose(slope, rising, here, T::zero());
                candidate = higher(candidate, Some((found, force(found))));
            }
            if candidate.is_some_and(|(_, height)| force(slip) < height * fallen) {
                best = higher(best, candidate.take());
            }
            before = Some(here);
        }
        Ok(best.map(|(slip, _)| at(slip)))
    }

    /// The pneumatic trail \[m\]: how far behind the middle of the patch the steady force acts. A
    /// lateral force F turns the wheel into the direction it moves in by the self-aligning moment
    /// F times the trail. None for a patch that stands still or carries nothing. By quadrature of
    ///
    /// L ∫₀¹ (ξ − ½) p μ_b dξ / ∫₀¹ p μ_b dξ.
    ///
    /// In full slip the force acts where the pressure does: a pressure that leans to the inlet
    /// turns the sign there.
    ///
    /// # Errors
    ///
    /// Refuses a motion that is not finite, and a negative rolling speed.
    pub fn pneumatic_trail(&self, motion: Motion<T>) -> Checked<Option<T>> {
        let [frozen] = self.frozen(motion)?;
        let Frozen { affine, slip_velocity, transport } = frozen;
        let steady = self.steady_of(self.contact(), frozen);
        let half: T = lit(0.5);
        let steepness = if steady.decay.is_finite() { steady.decay } else { T::zero() };
        let (mut force, mut moment) = (T::zero(), T::zero());
        weigh(self.pressure(), None, steepness.into(), |place, pressure| {
            let coefficient = if is_zero(slip_velocity) {
                // Per slip velocity, of which the trail takes the limit.
                affine.drive * affine.stiffness * place / transport + affine.damping
            } else {
                steady.coefficient(place)
            };
            force += pressure * coefficient;
            moment += pressure * coefficient * (place - half);
        });
        let trail = self.length() * moment / force;
        Ok(trail.is_finite().then_some(trail))
    }
}
