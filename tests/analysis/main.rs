//! Audit, energy ledger and linearisation.

#[path = "../common/mod.rs"]
mod common;

mod audit;
mod ledger;
mod linear;
