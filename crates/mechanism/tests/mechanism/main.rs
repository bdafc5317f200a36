//! Many contacts in one mechanism: reference motion, energy, structures, refusals.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

mod arm;
mod elastic_joint;
mod energy;
mod equations;
mod gradient;
mod reference;
mod refusals;
mod structures;
