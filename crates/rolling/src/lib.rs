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
//! | U | rolling speed | m/s |
//! | V = U/L | crossings of the patch per second | 1/s |
//! | v | slip velocity | m/s |
//! | s = v/U | slip ratio | – |
//! | p(ξ) | pressure: normal force per length | N/m |
//! | λ, r, c₀, c₂ | coefficients of the model, see [`Affine`](bristle::Affine) | 1/s, –, 1/m, s/m |
//!
//! # Slip ratio
//!
//! v is the *rigid* slip velocity: the velocity of the body's surface over the ground if neither
//! were elastic. It is positive where the ground drags the body back. F opposes it.
//!
//! | motion | v | s |
//! |---|---|---|
//! | any | | v/U |
//! | wheel of radius R | v_x − ωR, with U = ωR | (v_x − ωR)/(ωR) > 0 in braking, ∞ if locked |
//! | lateral, wheel at a slip angle α | v_y = v_x tan α, with U = ωR ≈ v_x | tan α |
//!
//! The longitudinal slip of ISO 8855 and SAE J670 is κ_x = (ωR − v_x)/v_x: negative in braking, −1
//! for a locked wheel. κ_x = −s/(1 + s) and s = −κ_x/(1 + κ_x). For small slip s ≈ −κ_x.
//!
//! A patch of one axis slips in one direction, along or across. A model of several axes
//! ([`PlaneFrBd`](bristle_plane::PlaneFrBd)) makes a patch in *combined slip*, as of a tyre that
//! brakes in a bend: [`Patch::combined_steady`], [`CombinedPatch`]. With spin, as of a tyre that
//! turns on the spot or leans, the slip velocity varies along the patch: `CombinedGrid`.
//!
//! # Parameters from measurements
//!
//! Without damping the slip stiffness C does not depend on the curve and is proportional to σ0: σ0
//! is the measured C over [`Patch::slip_stiffness`] at σ0 = 1/m, which is 2C/(L F_z) for a
//! symmetric pressure. Then fit the curve to slip and height of the [`Patch::peak`] and to the
//! force of a locked wheel. The peak lies well below the static coefficient, because bristles near
//! the inlet are not yet deflected.
//!
//! # Which pressure for what
//!
//! Steady rolling, its linearisation and the grids take any [`Pressure`]. The exact reduction, and
//! with it the coupling to mechanisms, takes a [`PolynomialExponential`]. A polynomial follows a
//! trapezium well: the coefficients 0, 8, −24, 32, −16 are 1 − (2ξ − 1)⁴. A measured pressure, or
//! one given by a function, is a [`FunctionPressure`].
//!
//! Source: Romano et al. (arXiv 2602.09429), section IV.
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(feature = "alloc")]
extern crate alloc;

mod axes;
mod braked_wheel;
mod combined;
mod exact;
mod frequency;
#[cfg(feature = "alloc")]
mod grid;
mod limits;
mod moments;
mod passivity;
mod patch;
mod pressure;
mod quadrature;
#[cfg(feature = "serde")]
mod serialisation;
mod steady;
mod tyre;

pub use axes::{OfAxes, PatchModel};
pub use braked_wheel::{BrakedWheel, BrakedWheelParameters, WheelLoads, WheelState};
pub use exact::{CombinedPatch, ExactPatch, Memory, PatchLedger, PatchStep, Segment};
pub use frequency::LinearisedPatch;
#[cfg(feature = "alloc")]
pub use grid::{CombinedGrid, Grid};
pub use limits::PatchLimits;
pub use passivity::PatchPassivity;
pub use patch::{Motion, Patch, PatchParameters};
pub use pressure::{
    AnyPressure, FunctionPressure, PolynomialExponential, PolynomialExponentialParameters, Pressure,
};
pub use steady::Steady;
pub use tyre::{TYRE_LENGTH, TYRE_PRESSURE_DECAY, Tyre};

/// The README's program compiles and runs.
#[cfg(all(doctest, feature = "alloc"))]
#[doc = include_str!("../README.md")]
struct Readme;

/// So do those of the page.
#[cfg(all(doctest, feature = "alloc"))]
#[doc = include_str!("../docs/rolling-contact.md")]
struct Page;
