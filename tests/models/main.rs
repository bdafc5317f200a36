//! Curves, bristles, regularisations and models: their laws, closed forms, derivatives and
//! refusals.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

mod curves;
mod derivatives;
mod implicit;
mod implicit_hold;
mod laws;
mod parameters;
mod viscoelastic;
