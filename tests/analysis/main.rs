//! Audit, energy ledger, linearisation, and parameters of other tools.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

#[path = "../common/mod.rs"]
mod common;

mod audit;
mod convert;
mod ledger;
mod linear;
