//! Parameters and bounds of a model, and the search for the least slope of its curve.

use crate::curve::FrictionCurve;
use crate::parameter::{Named, ParameterError, Rule};
use crate::rheology::ElementBounds;
use crate::scalar::{is_zero, lit, to_f64};
use crate::{Bounds, Branch, Scalar};

/// Parameters and bounds of a model, as its theorems use them: what an audit reads of a model of
/// any type. From [`Bristle::characteristics`](crate::Bristle::characteristics), which says who
/// asks for them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Characteristics<T> {
    /// Name of the model.
    pub name: &'static str,
    /// Micro-stiffness σ0 [1/m] over all velocities.
    #[doc(alias = "sigma0")]
    pub micro_stiffness: Bounds<T>,
    /// Micro-damping σ1 [s/m] over all velocities.
    #[doc(alias = "sigma1")]
    pub micro_damping: Bounds<T>,
    /// Friction coefficient at rest, μ_s \[–\].
    #[doc(alias = "mu_s")]
    pub static_coefficient: T,
    /// Friction coefficient of steady sliding over all velocities, without a viscous part: its
    /// least value is μ_d \[–\].
    #[doc(alias = "mu_d")]
    pub dry_coefficient: Bounds<T>,
    /// Slope dμ/d|v| [s/m] just above rest: μ is differentiable at v = 0 only where it is zero.
    /// Minus infinity for a Stribeck exponent below one.
    pub slope_at_rest: T,
    /// Least slope dμ/d|v| [s/m] over the speeds asked about, viscous part included. By a search
    /// over the decades below the fastest, narrowed down around the least value found.
    pub least_slope: T,
    /// Viscous friction σ2 [s/m] outside the bristle: the term σ2 v of classical LuGre. Zero where
    /// it is a part of the curve, as in FrBD.
    #[doc(alias = "sigma2")]
    pub viscous_friction: T,
    /// The viscous friction [s/m] without which the model is not passive, where there is such a
    /// threshold: σ1 (μ_s − μ_d)/μ_d for classical LuGre.
    pub needed_viscous_friction: Option<T>,
    /// Regularised speed at rest |0|_ε [m/s]: √ε of
    /// [`SquareRoot`](crate::regularisation::SquareRoot), v_t of
    /// [`HyperbolicTangent`](crate::regularisation::HyperbolicTangent), zero for an exact modulus.
    pub speed_at_rest: T,
    /// Deflection \[m\] up to which the bristle is elastic, for a model that has such a limit.
    pub stick_limit: Option<T>,
    /// Whether the bristle yields without end under a steady force, see
    /// [`Elements::creeps`](crate::rheology::Elements::creeps).
    pub creeps: bool,
    /// Why the friction curve is not to be trusted, with value and velocity; `None` if nothing was
    /// found. The search for the least slope checks at each of its speeds that μ is positive,
    /// finite and within [`FrictionCurve::bounds`], and that its slope is finite. A curve of your
    /// own can break that; an audit then returns this error.
    pub curve_fault: Option<ParameterError>,
}

/// Speeds per decade, and decades, of the search for the least slope.
const PER_DECADE: usize = 32;
const DECADES: usize = 12;
/// 10^(−1/32).
const NEXT: f64 = 0.930_572_040_929_699_2;

impl<T: Scalar> Characteristics<T> {
    /// Of a curve for speeds up to `fastest` and a bristle; the model adds the rest. `None` for a
    /// speed that is negative or not finite.
    pub(super) fn new<C: FrictionCurve<T>>(
        name: &'static str,
        curve: &C,
        elements: &ElementBounds<T>,
        fastest: T,
    ) -> Option<Self> {
        if !(fastest >= T::zero() && fastest.is_finite()) {
            return None;
        }
        let (least_slope, curve_fault) = searched(curve, fastest);
        Some(Self {
            name,
            micro_stiffness: elements.stiffness,
            micro_damping: elements.damping,
            static_coefficient: curve.at(T::zero()),
            dry_coefficient: curve.without_viscous_friction().bounds(T::unlimited()),
            slope_at_rest: curve.slope_at_rest(),
            least_slope,
            viscous_friction: T::zero(),
            needed_viscous_friction: None,
            speed_at_rest: T::zero(),
            stick_limit: None,
            creeps: false,
            curve_fault,
        })
    }
}

/// The least dμ/d|v| at speeds up to `fastest`, by search, and the first speed of the search, of
/// either direction, at which the curve is not finite or leaves its bounds.
fn searched<T: Scalar, C: FrictionCurve<T>>(curve: &C, fastest: T) -> (T, Option<ParameterError>) {
    let bounds = curve.bounds(fastest);
    // The bounds are sums of the parameters, the values of a few functions.
    let rounding = T::one() + lit::<T>(1e2) * T::default_epsilon();
    let ratio: T = lit(NEXT);
    let ordered =
        Named("upper bound of a curve", bounds.max).at_least("its lower bound", bounds.min);
    let (mut least, mut fault) = (curve.slope_at_rest(), ordered.err());
    for branch in [Branch::Forward, Branch::Backward] {
        let sliding = |speed: T| branch.at_speed(speed);
        let slope =
            |speed: T| curve.coefficient_and_slope(sliding(speed)).1 * sliding(speed).direction();
        let speeds = core::iter::successors(Some(fastest), |&speed| Some(speed * ratio));
        let mut steepest = (fastest, slope(fastest));
        for speed in speeds.take(PER_DECADE * DECADES + 1).chain(core::iter::once(T::zero())) {
            let (mu, slope) = (curve.coefficient(sliding(speed)), slope(speed));
            let place = to_f64(sliding(speed).velocity());
            let inside = mu * rounding >= bounds.min && mu <= bounds.max * rounding;
            if !(inside && mu > T::zero() && mu.is_finite()) {
                let (least, most) = (to_f64(bounds.min), to_f64(bounds.max));
                let rule = Rule::BetweenAt { least, most, place };
                fault = fault.or(Some(Named("friction curve", mu).refused(rule)));
            } else if !slope.is_finite() && !is_zero(speed) {
                // Infinitely steep it may be at rest.
                let rule = Rule::FiniteAt { place };
                fault = fault.or(Some(Named("slope of the friction curve", slope).refused(rule)));
            }
            if slope < steepest.1 {
                steepest = (speed, slope);
            }
        }
        // Thirds of the interval around it; flat at the bottom, so that half the digits are all
        // of them.
        let (mut low, mut high) = (steepest.0 * ratio, (steepest.0 / ratio).smaller(fastest));
        for _ in 0..80 {
            let third = (high - low) / lit(3.0);
            if slope(low + third) < slope(high - third) {
                high -= third;
            } else {
                low += third;
            }
        }
        least = least.smaller(steepest.1.smaller(slope((low + high) * lit(0.5))));
    }
    (least, fault)
}
