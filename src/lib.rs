//! Dynamic friction models.
#![no_std]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

mod bounds;
mod contact;
mod curve;
mod model;
pub mod ode;
mod parameter;
mod regularisation;
mod rheology;
mod scalar;
pub mod scene;
pub mod signal;
mod sliding;

pub use bounds::Bounds;
pub use contact::{Contact, ContactResponse, LinearisedContact};
pub use curve::{
    Asymmetric, Coulomb, CoulombParameters, FrictionCurve, FunctionCurve, Knot, RationalStribeck,
    RationalStribeckParameters, Stribeck, StribeckParameters, Tabulated,
};
pub use model::{
    Affine, Bristle, Dahl, DahlParameters, ElastoPlastic, ElastoPlasticParameters, FrBd, Hold, Law,
    Limits, Linearised, LuGre, Response,
};
pub use parameter::{ParameterError, Rule};
pub use regularisation::{Exact, HyperbolicTangent, Regularisation, SquareRoot};
pub use rheology::{
    Decaying, Deflection, Elements, KelvinVoigt, KelvinVoigtParameters, Rheology, Spring,
    SpringParameters, Varying, VelocityLaw,
};
pub use scalar::Scalar;
pub use sliding::{Branch, Sliding};
