//! What repeats in mechanisms with friction: stick-slip, hunting, forced vibration. Its period, its
//! stability, where it begins and ends.
//!
//! | item | what it gives |
//! |---|---|
//! | [`Shooting`] | a periodic motion of any system of [`bristle::ode`], with its [`Multiplier`]s |
//! | [`Shooting::prescribed`] | a bristle under a velocity that repeats, without iteration |
//! | [`Continuation`] | the branch of such motions over a parameter, with its [`PointKind`]s |
//! | [`Continuation::border`] | the parameter at which stable motions end |
//! | [`DrivenMass`] | the stick-slip rig in coordinates that repeat |
//! | [`ControlLoop`] | a position loop (P to PID) around a mass with friction, as a system |
//! | [`hunting()`], [`hunting_map`] | does a loop hunt: a report, and a map over two gains |
//!
//! Runs are those of [`bristle::ode`], split at reversals. The field is continuous there, so the
//! derivatives Φ of a run by its start do not jump, and keep their order. (They would for a sharp
//! slider; at the samples of a controller they jump as its state does.) A small disturbance is
//! multiplied by the eigenvalues μ of Φ in each period: the motion is stable if all are inside the
//! unit circle, but for the 1 of a motion whose phase is free.
//!
//! Numbers are `f64`: in single precision the runs leave no digits for Newton's method.
#![cfg_attr(docsrs, feature(doc_cfg))]

mod border;
mod branch;
mod control_loop;
mod driven_mass;
mod error;
mod flow;
mod hunting;
mod multipliers;
mod prescribed;
mod segments;
mod shooting;

pub use branch::{BranchEnd, BranchPoint, Continuation, OrbitBranch, PointKind};
pub use control_loop::{ControlLoop, ControlLoopParameters, Pid};
pub use driven_mass::DrivenMass;
pub use error::PeriodicError;
pub use hunting::{HuntingCycle, HuntingReport, Outcome, hunting, hunting_map, hunting_orbit};
pub use multipliers::Multiplier;
pub use shooting::{Guess, Orbit, Shooting};

/// What a search finds, or why there is none.
type Answer<T> = Result<T, PeriodicError>;

/// The programs on this page are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Pages;
