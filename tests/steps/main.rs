//! Steps of a fixed length: held, exponential and companion steps, and how long a step may be.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

mod companion;
mod exponential;
mod load;
mod point_mass;
mod stability;
