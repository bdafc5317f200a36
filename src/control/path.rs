//! A bristle is moved by distance, not by time: a displacement w h taken at a speed s.
//!
//! Along a displacement dx at speed s, dz/dx = r(s) − sgn(dx) (λ(s)/s) z. Over a sample h with the secant velocity w
//! that is the step of a held velocity w whose relaxation rate is λ(s)|w|/s: the way is w h, and the curve is read at s.

use crate::bounds::larger;
use crate::scalar::{is_zero, lit};
use crate::{Affine, Bristle, Scalar};

/// The curve is read at no less than this part of the secant velocity, so that the ratio stays bounded.
const SLOWEST: f64 = 1e-3;

/// The coefficients for a secant velocity [m/s], with the curve read at the speed of a smoother velocity.
#[inline]
pub(super) fn along<T: Scalar, M: Bristle<T, Deflection = T>>(
    model: &M,
    secant: T,
    smooth: T,
    deflection: T,
) -> Affine<T> {
    if is_zero(secant) {
        return Affine { relaxation: T::zero(), ..model.affine(smooth.into(), deflection) };
    }
    let speed = larger(smooth.abs(), secant.abs() * lit(SLOWEST));
    let velocity = if secant < T::zero() { -speed } else { speed };
    let affine = model.affine(velocity.into(), deflection);
    Affine { relaxation: affine.relaxation * (secant.abs() / speed), ..affine }
}
