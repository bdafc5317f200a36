//! Several axes: models, footprints, bodies in a plane.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

mod body;
mod footprint;
mod limit_surface;
mod plane;
