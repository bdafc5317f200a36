//! Dynamic friction models, and solvers that locate the kink of |v| at v = 0.
//!
//! A body rubs on another through elastic bristles. A friction curve μ(v) and a rheology (the
//! springs and dashpots of a bristle) give a *friction model with bristle dynamics* ([`FrBd`]) with
//! one state, the deflection z \[m\]. The force shows stick-slip, frictional lag and hysteresis.
//! Beside it stand [`LuGre`], [`Dahl`], [`ElastoPlastic`] and [`ImplicitBristle`], all behind one
//! trait, [`Bristle`]. A kink is a jump in slope.
//!
//! | step | what | where |
//! |---|---|---|
//! | 1 | a friction curve μ(v) | [`curve::Stribeck`] and others, trait [`curve::FrictionCurve`] |
//! | 2 | a bristle | [`rheology::KelvinVoigt`] and others, trait [`rheology::Rheology`] |
//! | 3 | a model of both | [`FrBd`] and others, trait [`Bristle`] |
//! | 4 | a normal force | [`Bristle::under_load`] makes a [`Contact`] |
//! | 5a | in a loop, at a held velocity | [`Contact::hold`] |
//! | 5b | at a velocity known over time | [`exponential`] |
//! | 5c | in a controller, against friction | [`control`] |
//! | 5d | in your own mechanism, any step | [`Contact::companion`] |
//! | 5e | in a mechanism to simulate | [`scene`], or your own [`ode::System`] |
//! | 6 | a simulation | [`ode::solve`], or [`ode::Solver`] with a method of your choice |
//!
//! A normal force that varies: the table at [`Contact`]. Curves, models, signals and methods chosen
//! at run time: [`curve::AnyCurve`], [`AnyBristle`], [`signal::AnySignal`] and [`ode::AnyMethod`];
//! the feature `serde` reads them from files. A curve, bristle or model of your own goes wherever
//! these go.
//!
//! Beside this crate stand others, built on what is public here:
//!
//! | crate | what |
//! |---|---|
//! | `bristle-analysis` | laws and bounds, stable steps, onset of stick-slip, energy of a run |
//! | `bristle-plane` | sliding in a plane, spin, footprints |
//! | `bristle-rolling` | contact patches: tyres, rollers |
//! | `bristle-joint` | friction of gears, motors, geared joints |
//! | `bristle-memory` | loops within loops: guides, piezo stages, bolted joints |
//! | `bristle-mechanism` | many contacts in one mechanism |
//! | `bristle-periodic` | what repeats: hunting loops, stick-slip cycles, their stability |
//! | `bristle-adaptation` | friction that changes, followed in a control loop |
//! | `bristle-batch` | many bristles at once |
//! | `bristle-fidelity` | the cheapest model that a scene needs |
//! | `bristle-identify` | parameters from logs |
//! | `bristle-convert` | parameters of other tools |
//! | `bristle-files` | scenes from files, as a program |
//!
//! Guides, in the repository: `docs/choosing.md` (which model, step and solver), `control-loop.md`,
//! `embedded.md`, `paper.md` (the paper's experiments), `experiments.md` (the classical ones, and
//! other models of the field), `work-precision.md` (beside other ODE codes), `gallery.md` (all
//! charts); in the folders `docs` of the crates `plane.md`, `joint.md`, `rolling-contact.md`,
//! `gradients.md`, `identification.md`, `files.md` and `coming-from.md` (parameters of other
//! tools).
//!
//! ```
//! use bristle::{Bristle, FrBd, Law, curve::Stribeck, paper, rheology::KelvinVoigt};
//!
//! let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
//! let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
//! let contact = FrBd::new(curve, bristle).under_load(10.0)?; // N
//!
//! // Breakaway: steady sliding at 1 µm/s carries the static friction coefficient.
//! assert!((contact.stationary_force(1e-6) - 15.0).abs() < 1e-6);
//! // What the theorems promise up to 1 m/s: deflection [m], force [N], relaxation rate [1/s].
//! let limits = contact.limits(1.0);
//! assert!(limits.deflection.unwrap() < 1.51e-4 && limits.force.unwrap() < 15.1);
//! assert!(contact.model().obeys(Law::Passivity));
//! # Ok::<(), bristle::ParameterError>(())
//! ```
//!
//! # Conventions
//!
//! SI units throughout. The friction force opposes the velocity: m v̇ = … − F. Quantities per
//! normal force carry the field's symbols σ0 [1/m], σ1 [s/m], σ2 [s/m] as search aliases. Angles,
//! torques and inertias serve as well as positions, forces and masses, with the units of σ0 … v_S
//! to match: for a joint take p = 1, μ in N m, σ0 in N m/rad, σ1 and σ2 in N m s/rad, v_S in rad/s.
//! With [`Units::Rotation`], audits and the reports of bristle-fidelity print rad and N m.
//!
//! Parameters are checked once, when a value is built. Afterwards a model does not fail; a run can
//! fail, and says why. Nothing panics. NaN given to a model at run time comes out as NaN; an
//! integration that meets one stops and says where.
//!
//! # Source
//!
//! L. Romano, O. M. Aamo, J. Åslund, E. Frisk, "First-order friction models with bristle dynamics:
//! lumped and distributed formulations", arXiv 2602.09429, cited below as Romano et al.
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(feature = "alloc")]
extern crate alloc;

#[macro_use]
mod forward;

mod bounds;
pub mod companion;
mod contact;
pub mod control;
pub mod curve;
mod error;
pub mod exponential;
mod mechanism;
mod model;
pub mod number;
pub mod ode;
pub mod paper;
pub mod parameter;
pub mod regularisation;
pub mod rheology;
pub mod root;
pub mod scalar;
pub mod scene;
#[cfg(feature = "serde")]
pub mod serialisation;
pub mod signal;
mod sliding;
mod surface;

/// The linear algebra of states and matrices, in the version that this crate uses.
pub use nalgebra;

pub use bounds::Bounds;
pub use contact::{
    Contact, ContactLimits, ContactResponse, HeldContact, LinearisedContact, LoadChange, Reloaded,
};
pub use error::Error;
pub use mechanism::Mechanism;
#[cfg(feature = "alloc")]
pub use model::OwnModel;
pub use model::{
    Affine, AnyBristle, Bristle, Characteristics, Dahl, DahlParameters, ElastoPlastic, Form, FrBd,
    HeldStep, ImplicitBristle, Law, Limits, Linearised, LuGre,
};
pub use number::Units;
pub use parameter::{ParameterError, Rule};
pub use scalar::Scalar;
pub use sliding::{Branch, Sliding};
pub use surface::Surface;
