//! What is chosen at run time, wherever it goes.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

mod choices;
mod everywhere;
mod ladder;
