//! Rolling contact: bristles that enter a contact patch, are deflected on their way through it, and
//! leave it at the other end. A tyre, a roller, a bearing.
//!
//! ∂z/∂t + V ∂z/∂ξ = −λ(v) z + r(v) v,  z(0, t) = 0,  F = L ∫₀¹ p(ξ) (c₀(v) z + c₂(v) v) dξ
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | ξ | place in the patch, 0 at the inlet and 1 at the outlet | – |
//! | z(ξ, t) | deflection of the bristle that is at ξ | m |
//! | L | length of the patch | m |
//! | V | transport velocity: rolling speed over length | 1/s |
//! | v | slip velocity | m/s |
//! | v/(L V) | slip | – |
//! | p(ξ) | pressure: normal force per length | N/m |
//! | λ, r, c₀, c₂ | coefficients of the friction model, see [`Affine`](crate::Affine) | 1/s, –, 1/m, s/m |
//!
//! Source: Romano et al. (arXiv 2602.09429), section IV.

mod exact;
#[cfg(feature = "alloc")]
mod grid;
mod integrals;
mod patch;
mod pressure;

pub use exact::{ExactPatch, MotionOverTime, Order, PatchCommitted, PatchLedger, PatchStep, Slot};
#[cfg(feature = "alloc")]
pub use grid::{Grid, GridParameters, MotionField, Transport};
pub use patch::{Motion, Patch, PatchParameters, RateDependent, Slip, WheelMotion};
pub use pressure::{PolynomialExponential, PolynomialExponentialParameters, Pressure};
