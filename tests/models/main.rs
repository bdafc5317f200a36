//! Curves, bristles, regularisations and models: their laws, closed forms, derivatives and
//! refusals.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

#[path = "../common/mod.rs"]
mod common;

mod curves;
mod derivatives;
mod footprint;
mod implicit;
mod implicit_hold;
mod laws;
mod parameters;
mod plane;
mod runtime;
mod runtime_everywhere;
mod viscoelastic;
