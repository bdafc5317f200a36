//! Audits, ledgers and linear analysis.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

mod audit;
mod ledger;
mod linear;
