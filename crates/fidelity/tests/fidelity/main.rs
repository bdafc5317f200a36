//! How much model a scene needs: what is chosen is good enough, and the cheapest that is.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod judge;
mod known_velocity;
mod mechanism;
mod patch;
mod scene;
mod search;
