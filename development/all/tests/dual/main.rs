//! Models, scenes and runs on dual numbers, against which every derivative of the library is held.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test panics to fail")]

mod models;
mod runs;
