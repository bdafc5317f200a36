//! The integrators, and the scenes and signals that they run.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

#[path = "../common/mod.rs"]
mod common;

mod accuracy;
mod dense;
mod events;
mod failures;
mod joint;
mod kinks;
mod ode_common;
mod output;
mod plane;
mod reversals;
mod scenes;
mod signals;
mod statistics;
mod stiff;
mod trust;
