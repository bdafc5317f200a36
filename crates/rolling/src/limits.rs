//! Bounds of the deflection and force of a patch: input-to-state and input-to-output stability, as
//! numbers.
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
//! force ([`Law::BoundedForce`](bristle::Law::BoundedForce)) what v has made since t = 0 gives at
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

use super::quadrature::weigh;
use super::{Motion, Patch, Pressure};
use bristle::parameter::{Checked, Named};
use bristle::scalar::{is_zero, lit};
use bristle::{Bristle, Scalar};

/// Limits of deflection and force, see [`Patch::limits`]. Both grow with the root mean square ‖z₀‖
/// \[m\] of the initial deflection:
///
/// ‖z‖ ≤ `gain` + `remaining_deflection` ‖z₀‖,  |F| ≤ `force` + `remaining_force` ‖z₀‖.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchLimits<T> {
    /// γ(|v|_∞) \[m\]: the root mean square of the deflection that the motion can make.
    #[doc(alias = "ISS")]
    pub gain: T,
    /// Upper bound of |F| \[N\] from undeflected bristles. Infinite for a model without a
    /// limit of c₀.
    #[doc(alias = "IOS")]
    pub force: T,
    /// β/‖z₀‖ \[–\]: 1 until the initial bristles have left the patch, then 0.
    pub remaining_deflection: T,
    /// The rise of the limit of the force with ‖z₀‖ [N/m].
    pub remaining_force: T,
    /// Z; infinite if there is none.
    deflection: T,
    /// |v|_∞/V \[m\]
    slope: T,
}

impl<T: Scalar, M: Bristle<T, Deflection = T>, P: Pressure<T>> Patch<T, M, P> {
    /// Limits of deflection and force for every motion with |v| ≤ |v|_∞, the slip velocity given,
    /// at a constant rolling speed, a time t \[s\] after the beginning: input-to-state and
    /// input-to-output stability.
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
    /// // After a second the initial bristles have left.
    /// let limits = tyre.limits(Motion { slip_velocity: 0.1, rolling_speed: 16.0 }, 1.0)?;
    /// // In little slip no bristle comes far enough to slide: σ0 |v| L/(2 U) of the normal force.
    /// assert!((limits.force - 4000.0 * 252.0 * 0.1 / 320.0).abs() < 1e-9);
    /// assert_eq!(limits.remaining_force, 0.0);
    /// # Ok::<(), bristle::ParameterError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Refuses a slip velocity or a time that is negative or not finite, and a rolling speed that
    /// is not positive.
    pub fn limits(&self, fastest: Motion<T>, elapsed: T) -> Checked<PatchLimits<T>> {
        let transport = self.rolling(fastest)?;
        let fastest = Named("slip_velocity", fastest.slip_velocity).non_negative()?;
        let elapsed = Named("elapsed", elapsed).non_negative()?;
        let model = self.model().limits(fastest);
        let (stiffness, damping) = output_limits(self.model(), fastest);
        let (zero, one) = (T::zero(), T::one());
        let scale = self.contact().friction_scale();
        let slope = fastest / transport;
        let deflection = model.deflection.map_or(one / zero, |most| most * scale);
        // A smaller scale leaves the bounds of c₀ and c₂, a larger one raises viscous friction.
        let damping = damping * scale.larger(one);
        let (weight, carried) = (self.length() * self.factor, self.contact().reference_load());

        // Where the limit of the deflection is reached, if within the patch.
        let reach = Some(deflection / slope).filter(|&reach| reach < one);
        let gain = reach.map_or(slope / lit::<T>(3.0).sqrt(), |reach| {
            deflection * (one - lit::<T>(2.0 / 3.0) * reach).sqrt()
        });
        let mut bent = zero;
        weigh(self.pressure(), reach, zero.into(), |place, weighted| {
            bent += weighted * deflection.smaller(slope * place);
        });
        let force = weight * stiffness * bent + carried * damping * fastest;
        let force = model.coefficient.map_or(force, |most| force.smaller(carried * (most * scale)));
        let inlet = transport * elapsed;
        let (mut remaining_deflection, mut remaining_force) = (zero, zero);
        if inlet < one {
            let mut square = zero;
            weigh(self.pressure(), Some(inlet), zero.into(), |place, weighted| {
                square += if place < inlet { zero } else { weighted * self.pressure().at(place) };
            });
            (remaining_deflection, remaining_force) = (one, weight * stiffness * square.sqrt());
        }
        Ok(PatchLimits { gain, force, remaining_deflection, remaining_force, deflection, slope })
    }
}

impl<T: Scalar> PatchLimits<T> {
    /// a(ξ) = min(|v|_∞ ξ/V, Z) \[m\]: the upper bound of |z| at a place once the initial
    /// deflection has left the patch.
    pub fn deflection(&self, place: T) -> T {
        self.deflection.smaller(self.slope * place)
    }
}

/// Upper bounds of |c₀| [1/m] and |c₂| [s/m] at velocities with |v| ≤ `fastest`; infinite if there
/// is no such limit. c₂ is at most σ1 + σ2, and c₀ lies between σ0 − σ1 max λ and σ0.
fn output_limits<T: Scalar, M: Bristle<T, Deflection = T>>(model: &M, fastest: T) -> (T, T) {
    let Some(known) = model.characteristics(fastest) else {
        return (T::unlimited(), T::unlimited());
    };
    let (stiffness, damping) = (known.micro_stiffness.max, known.micro_damping.max);
    let below = match model.limits(fastest).relaxation_rate {
        _ if is_zero(damping) => T::zero(),
        Some(rate) => damping * rate - stiffness,
        None => T::unlimited(),
    };
    (stiffness.larger(below), damping + known.viscous_friction)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    extern crate std;
    use std::format;

    use bristle::curve::{Stribeck, StribeckParameters};
    use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
    use bristle::{Bristle, LuGre, paper};

    use super::output_limits;

    #[test]
    fn the_coefficients_of_lugre_stay_within_their_limits_and_come_near_them() {
        let curve = |viscous_friction| {
            Stribeck::new(StribeckParameters { viscous_friction, ..paper::TYRE_CURVE }).unwrap()
        };
        // Slow enough for c₀ > 0, fast enough for c₀ < −σ0, undamped, viscous without a dashpot.
        for (damping, viscous, fastest) in
            [(0.3, 0.0018, 0.1), (0.3, 0.0018, 60.0), (0.0, 0.01, 60.0), (2.0, 0.0, 60.0)]
        {
            let bristle = KelvinVoigtParameters { micro_stiffness: 252.0, micro_damping: damping };
            let bristle = KelvinVoigt::new(bristle).unwrap();
            let model = LuGre::classical(curve(viscous), bristle);
            let (most_stiffness, most_direct) = output_limits(&model, fastest);
            let (mut stiffness, mut direct) = (0.0_f64, 0.0_f64);
            for number in -2000..=2000 {
                let affine = model.affine((fastest * f64::from(number) / 2000.0).into(), 0.0);
                stiffness = stiffness.max(affine.stiffness.abs());
                direct = direct.max(affine.damping.abs());
            }
            let name = format!("σ1 = {damping}, σ2 = {viscous}, up to {fastest}");
            assert!(stiffness <= most_stiffness, "{name}: {stiffness} > {}", most_stiffness);
            assert!(direct <= most_direct, "{name}: {direct} > {}", most_direct);
            // At 60 m/s Stribeck's part has gone: max λ is attained. c₂ is the same everywhere.
            assert!(stiffness >= most_stiffness * (1.0 - 1e-12), "{name}: {stiffness}");
            assert!(direct >= most_direct * (1.0 - 1e-12), "{name}: {direct}");
            assert_eq!(
                stiffness > 2.0 * 252.0,
                damping > 0.0 && fastest > 1.0,
                "{name}: {stiffness}"
            );
        }
    }
}
