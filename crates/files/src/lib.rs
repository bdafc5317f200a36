//! A friction scene from a file: model, scene and solver, read with serde and run.

mod choices;
mod refusal;
mod scenes;
mod setup;

pub use refusal::{Refusal, read};
pub use setup::{Setup, SolverSetup, Table};
