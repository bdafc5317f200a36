//! What a friction contact of [`bristle`] does before anything is simulated, and where the energy
//! of a run went.
//!
//! | module | what it answers |
//! |---|---|
//! | [`audit`] | which laws hold for a set of parameters, what is bounded, how long a step may be |
//! | [`step_limits`] | the largest stable step of each integration method |
//! | [`linear`] | small motions: poles, frequency response, the onset of stick-slip |
//! | [`ledger`] | energy supplied, stored and dissipated over a run, and whether it was passive |
//!
//! All are functions of a [`Contact`](bristle::Contact), a model under a normal force:
//!
//! ```
//! use bristle::{Bristle, FrBd, curve::Stribeck, paper, rheology::KelvinVoigt};
//! use bristle_analysis::audit::{AuditParameters, LawStatus, audit};
//! use bristle_analysis::linear::{Threshold, critical_speed};
//! use bristle_analysis::step_limits::{Scheme, largest_step};
//!
//! let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
//! let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
//! let contact = FrBd::new(curve, bristle).under_load(1.0)?; // N
//! let rig = paper::stick_slip_rig(contact).mechanism; // a mass of 1 kg on a spring
//!
//! let report = audit(&contact, AuditParameters::up_to(1.0))?; // m/s
//! assert_eq!(report.passivity.verdict, LawStatus::Holds);
//! let steps = largest_step(&contact, Some(rig), 1.0, Scheme::RungeKutta4)?;
//! assert!(steps.check(1e-3).is_ok()); // s
//! let threshold = critical_speed(&contact, rig, 1e-3..1.0)?; // m/s
//! assert!(matches!(threshold, Threshold::StableAbove(speed) if (speed - 0.0299).abs() < 1e-4));
//! # Ok::<(), bristle::ParameterError>(())
//! ```
//!
//! Nothing here allocates, and nothing panics. Parameters out of their range are refused by name.
#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod audit;
mod eigenvalues;
pub mod ledger;
pub mod linear;
pub mod step_limits;

/// The README's program compiles and runs.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
