//! Rolling contact: steady, exact, on a grid, and in a braked wheel.
#![cfg(feature = "alloc")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test panics to fail")]

mod characteristics;
mod combined;
mod exact;
mod exact_limits;
mod grid;
mod load;
mod passive;
mod refusals;
mod smooth;
mod spin;
mod steady;
mod theory;
mod tyre;
mod wheel;
