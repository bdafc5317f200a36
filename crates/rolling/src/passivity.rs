//! Whether a patch can give away more energy than it was given.
//!
//! With the stored energy W = (L/2) ∫ Σ0 z² dξ, Σ0 = σ0 p, and the boundary z(0) = 0,
//!
//! F v − Ẇ = (bristles' own dissipation ≥ 0) + (L/2) Σ0(1) V(1) z(1)² − (L/2) ∫ (Σ0 V)' z² dξ:
//!
//! what the bristles carry out of the patch is lost, and what they carry to higher pressure is
//! gained. Hence the *sufficient* condition
//!
//! (Σ0 V)' ≤ 0 on [0, 1].
//!
//! Constant and falling pressure meet it. No pressure that is zero at the inlet and not elsewhere
//! does.
//!
//! What happens where it fails is seen about v = 0, where the bristles adhere: by the frequency
//! response ([`LinearisedPatch`](super::LinearisedPatch)) with λ = 0, r = 1 and θ = ω/V, the work
//! per period of a small sinusoid is positive iff
//!
//! Re G = L ((c₀/V) S(θ) + c₂ P) ≥ 0,  S(θ) = (1/θ) ∫₀¹ p sin(θξ) dξ,  P = ∫₀¹ p dξ.
//!
//! S is negative in bands of θ for pressure that rises; then damping is *necessary*, c₂ ≥ D c₀/V
//! with D = max(−S/P). For the parabola S is negative in (2πn, θ_n), tan(θ_n/2) = θ_n/2, and D =
//! 0.0111157223 at θ = 7.31442.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | Σ0 = σ0 p | stiffness per length | N/m² |
//! | V | transport velocity | 1/s |
//! | θ | phase that passes during a transit of the patch | rad |
//! | D | least damping number c₂ V/c₀ | – |
//!
//! Source: Romano et al. (arXiv 2602.09429), section IV-B (passivity; the integral in its proof
//! lacks a sign and V, the condition is unaffected). The small-signal bound is worked out here.

use nalgebra::Complex;

use super::patch::coefficients;
use super::{Patch, Pressure};
use bristle::parameter::{Checked, Named};
use bristle::scalar::lit;
use bristle::{Bristle, Law, Scalar};

/// What the sufficient condition (Σ0 V)' ≤ 0 says about a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PatchPassivity<T> {
    /// The condition holds: F v ≥ Ẇ for every motion.
    Passive,
    /// It fails, by most at a place. The patch may or may not be passive.
    Rises {
        /// The place ξ \[–\] where Σ0 V rises most steeply of those looked at.
        place: T,
        /// (Σ0 V)' there: [N/m²] from [`Patch::passivity`], which leaves V out, and
        /// [N/(m s)] from [`PatchPassivity::of`], (Σ0 U)'. Infinite where the pressure jumps up.
        slope: T,
    },
    /// The friction model itself is not known to be passive.
    Model,
}

/// Places looked at from each knot to the next, ends included.
const PLACES: usize = 257;

impl<T: Scalar> PatchPassivity<T> {
    /// Checks the sufficient condition (Σ0 U)' ≤ 0 for a stiffness σ0(ξ) [1/m] and a rolling
    /// speed U(ξ) [m/s] that depend on the place: closures that answer the value and its slope.
    /// The friction model is taken to be passive.
    ///
    /// Looked at are 257 places from each knot of the pressure to the next, and whether Σ0 V has
    /// risen from one to the next; σ0 and U must be smooth on that scale.
    ///
    /// ```
    /// use bristle_rolling::{PatchPassivity, PolynomialExponential};
    ///
    /// let flat = PolynomialExponential::constant();
    /// let uniform = |_: f64| (252.0, 0.0);
    /// assert_eq!(PatchPassivity::of(&flat, uniform, |_| (100.0, 0.0)), PatchPassivity::Passive);
    /// // Bristles that are carried ever faster.
    /// let faster = PatchPassivity::of(&flat, uniform, |place| (100.0 + 10.0 * place, 10.0));
    /// let PatchPassivity::Rises { slope, .. } = faster else { unreachable!() };
    /// assert!((slope - 2520.0_f64).abs() < 1e-9);
    /// ```
    pub fn of<P: Pressure<T>>(
        pressure: &P,
        stiffness: impl Fn(T) -> (T, T),
        rolling_speed: impl Fn(T) -> (T, T),
    ) -> Self {
        let at = |place: T| {
            let (p, p_slope) = pressure.at_and_slope(place);
            let (s, s_slope) = stiffness(place);
            let (v, v_slope) = rolling_speed(place);
            let terms = (p_slope * s * v, p * s_slope * v, p * s * v_slope);
            let size = terms.0.abs() + terms.1.abs() + terms.2.abs();
            (p * s * v, terms.0 + terms.1 + terms.2, size)
        };
        let mut worst: Option<(T, T)> = None;
        let rounding = lit::<T>(64.0) * T::default_epsilon();
        let mut last: Option<(T, T)> = None;
        super::quadrature::between_knots(pressure, None, |from, width| {
            for number in 0..PLACES {
                let mut place = from + width * lit(number as f64 / (PLACES - 1) as f64);
                if number + 1 == PLACES {
                    // This side of the knot.
                    place *= T::one() - lit::<T>(2.0) * T::default_epsilon();
                }
                let (value, mut slope, size) = at(place);
                // NaN is no proof either.
                let mut rises = !(slope <= rounding * size);
                if let Some((before, steepness)) = last
                    && !(value - before
                        <= rounding * (before.abs() + value.abs() + size + steepness))
                {
                    rises = true;
                    if number == 0 {
                        slope = T::one() / T::zero();
                    } else if !(slope > T::zero()) {
                        // It rose in between.
                        slope = (value - before) / width * lit((PLACES - 1) as f64);
                    }
                }
                if rises && worst.is_none_or(|(_, other)| slope > other) {
                    worst = Some((place, slope));
                }
                last = Some((value, size));
            }
        });
        worst.map_or(Self::Passive, |(place, slope)| Self::Rises { place, slope })
    }
}

impl<T: Scalar, M: Bristle<T, Deflection = T>, P: Pressure<T>> Patch<T, M, P> {
    /// Checks the sufficient condition (Σ0 V)' ≤ 0 for uniform σ0 and V, which is dp/dξ ≤ 0, after
    /// having asked the model whether it is passive itself.
    ///
    /// Looked at are 257 places from each knot of the pressure to the next.
    ///
    /// ```
    /// use bristle_rolling::{PatchPassivity, Patch, PatchParameters, PolynomialExponential};
    /// use bristle::{FrBd, paper};
    /// use bristle::curve::Stribeck;
    /// use bristle::rheology::KelvinVoigt;
    ///
    /// let friction =
    ///     FrBd::new(Stribeck::new(paper::TYRE_CURVE)?, KelvinVoigt::new(paper::TYRE_BRISTLE)?);
    /// let constant = PolynomialExponential::constant();
    /// let (model, length) = (friction, 0.1);
    /// let tyre = Patch::new(PatchParameters { model, length, pressure: constant })?;
    /// assert_eq!(tyre.passivity(), PatchPassivity::Passive);
    /// // A parabola rises most steeply at the inlet, by 6 N/m times 252 1/m.
    /// let parabola = PolynomialExponential::parabolic();
    /// let (model, length) = (friction, 0.1);
    /// let tyre = Patch::new(PatchParameters { model, length, pressure: parabola })?;
    /// assert_eq!(tyre.passivity(), PatchPassivity::Rises { place: 0.0, slope: 6.0 * 252.0 });
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    pub fn passivity(&self) -> PatchPassivity<T> {
        if !self.model().obeys(Law::Passivity) {
            return PatchPassivity::Model;
        }
        let stiffness = self.factor * self.model().storage_stiffness();
        let uniform = |value: T| move |_: T| (value, T::zero());
        PatchPassivity::of(self.pressure(), uniform(stiffness), uniform(T::one()))
    }

    /// The least damping c₂ [s/m] at v = 0 (σ1, and for the classical LuGre model σ1 + σ2) with
    /// which the patch takes energy from every small sinusoid about v = 0 at a rolling speed
    /// U > 0 [m/s]; zero if it needs none. It is a *necessary* condition for passivity, and a
    /// sufficient one for small signals, of a model without regularisation.
    ///
    /// The phase θ = ω/V is searched up to 400 rad in steps of a twentieth; pressures that vary
    /// within less than a sixtieth of the patch can hide more above.
    ///
    /// ```
    /// use bristle_rolling::{Patch, PatchParameters, PolynomialExponential};
    /// use bristle::{FrBd, paper};
    /// use bristle::curve::Stribeck;
    /// use bristle::rheology::KelvinVoigt;
    ///
    /// let friction =
    ///     FrBd::new(Stribeck::new(paper::TYRE_CURVE)?, KelvinVoigt::new(paper::TYRE_BRISTLE)?);
    /// let parabola = PolynomialExponential::parabolic();
    /// let (model, length) = (friction, 0.1);
    /// let tyre = Patch::new(PatchParameters { model, length, pressure: parabola })?;
    /// let least = tyre.least_passive_damping(16.0)?;
    /// assert!((least * 160.0 / 252.0 - 0.0111157223).abs() < 1e-10);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses a rolling speed that is not positive and a pressure that carries nothing.
    pub fn least_passive_damping(&self, rolling_speed: T) -> Checked<T> {
        let rolling_speed = Named("rolling_speed", rolling_speed).positive()?;
        let total = Named("total pressure", self.pressure().total()).positive()?;
        let stiffness = coefficients(self.contact(), T::zero())?.stiffness;
        let number = damping_number(self.pressure(), total);
        Ok(number * stiffness * self.length() / rolling_speed)
    }
}

/// D, the largest −S(θ)/P; zero if it is nowhere positive.
fn damping_number<T: Scalar, P: Pressure<T>>(pressure: &P, total: T) -> T {
    const STEP: f64 = 0.05;
    const STEPS: usize = 8000;
    let activity = |theta: T| {
        // −∫ p sin(θξ) dξ is the imaginary part of the transform at iθ.
        pressure.transform(Complex::new(T::zero(), theta)).im / (theta * total)
    };
    // Rounding of the transform is not activity.
    let rounding = lit::<T>(64.0) * T::default_epsilon();
    let (mut place, mut most) = (T::zero(), T::zero());
    for number in 1..=STEPS {
        let theta: T = lit(STEP * number as f64);
        // |∫ p sin| ≤ P: nothing beyond exceeds what there is.
        if most * theta > T::one() {
            break;
        }
        let here = activity(theta);
        if here > most && here * theta > rounding {
            (place, most) = (theta, here);
        }
    }
    if !(most > T::zero()) {
        return T::zero();
    }
    // Thirds of the steps at both sides: the value to rounding.
    let (mut low, mut high) = (place - lit(STEP), place + lit(STEP));
    for _ in 0..48 {
        let third = (high - low) / lit(3.0);
        let (before, after) = (low + third, high - third);
        (low, high) =
            if activity(before) > activity(after) { (low, after) } else { (before, high) };
    }
    activity((low + high) * lit(0.5))
}
