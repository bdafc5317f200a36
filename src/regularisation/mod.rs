//! Regularisation: smooth stand-ins |v|_ε and sgn_ε(v) for |v| and sgn v.
//! Which to take: the table at [`Regularisation`].

mod any;
mod hyperbolic_tangent;
mod square_root;
mod unregularised;

use core::fmt::Debug;

pub use any::AnyRegularisation;
pub use hyperbolic_tangent::HyperbolicTangent;
pub use square_root::SquareRoot;
pub use unregularised::Unregularised;

use crate::{Scalar, Sliding};

/// A regularised modulus |v|_ε ≥ |v| [m/s] and the sign sgn_ε(v) = v/|v|_ε \[–\] that goes with it.
///
/// | regularisation | \|v\|_ε | take it if |
/// |---|---|---|
/// | [`Unregularised`] | \|v\| | nothing else is asked for: bodies stick, solvers find the kink |
/// | [`SquareRoot`] | √(v² + ε) | a solver of your own needs a smooth field, or a source gives ε |
/// | [`HyperbolicTangent`] | v coth(v/v_t) | the parameters are those of a multibody code |
/// | [`AnyRegularisation`] | one of these | it is chosen at run time |
///
/// It enters where the bristle meets the sliding surface: λ = σ0|v|_ε/g, g = σ1|v|_ε + μ (Romano et
/// al., section II-B). With any regularisation but [`Unregularised`] nothing ever sticks: under a
/// force F below the breakaway force F_b the body creeps, for the square root at
/// v ≈ √ε r/√(1 − r²) with r = F/F_b.
pub trait Regularisation<T: Scalar>: Debug + Clone {
    /// The regularised speed |v|_ε [m/s]. Override it where the slope costs extra.
    #[inline(always)]
    fn speed(&self, sliding: Sliding<T>) -> T {
        self.speed_and_slope(sliding).0
    }

    /// The regularised speed and its slope d|v|_ε/dv \[–\].
    fn speed_and_slope(&self, sliding: Sliding<T>) -> (T, T);

    /// The regularised sign sgn_ε(v) = v/|v|_ε \[–\], at most 1 in magnitude.
    fn sign(&self, sliding: Sliding<T>) -> T {
        sliding.velocity() / self.speed(sliding)
    }

    /// The regularised sign and its slope [s/m].
    fn sign_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        let (speed, slope) = self.speed_and_slope(sliding);
        let sign = sliding.velocity() / speed;
        (sign, (T::one() - sign * slope) / speed)
    }

    /// The regularised speed at rest |0|_ε [m/s], which is also the largest |v|_ε − |v|. Zero says
    /// that the modulus is exact, so that a bristle at rest keeps its force.
    fn speed_at_rest(&self) -> T;
}
