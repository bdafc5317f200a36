//! Steps of a fixed length: held, exponential and companion steps, and how long a step may be.

#[path = "../common/mod.rs"]
mod common;

mod companion;
mod exponential;
mod point_mass;
mod stability;
