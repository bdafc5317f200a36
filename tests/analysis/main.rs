//! Audit, energy ledger and linearisation.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

#[path = "../common/mod.rs"]
mod common;

mod audit;
mod ledger;
mod linear;
