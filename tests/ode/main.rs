//! The integrators, and the scenes and signals that they run.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

mod accuracy;
mod blind_spots;
mod dense;
mod drawn;
mod dynamic;
mod events;
mod failures;
mod kinks;
mod output;
mod reversals;
mod scenes;
mod signals;
mod statistics;
mod stiff;
mod trust;
