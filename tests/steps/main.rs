//! Steps of a fixed length: held, exponential and companion steps, and how long a step may be.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

#[path = "../common/mod.rs"]
mod common;

mod companion;
mod exponential;
mod load;
mod point_mass;
mod stability;
