//! Rolling contact: steady, exact, on a grid, and in a braked wheel.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test panics to fail")]

#[path = "../common/mod.rs"]
mod common;

mod combined;
mod exact;
mod exact_limits;
mod grid;
mod passive;
mod refusals;
mod smooth;
mod spin;
mod steady;
mod theory;
mod wheel;
