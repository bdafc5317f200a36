//! Friction simulated without writing Rust: model, scene and solver from a TOML file.
//!
//! The program `bristle` simulates a file and leaves a table and a chart. [`read`] and
//! [`Setup::run`] do so in Rust:
//!
//! ```
//! let file = r#"
//! [solver]
//! end = 3.0     # s
//! samples = 301
//!
//! [scene.prescribed_velocity]
//! velocity.sine = { mean = 0.0, amplitude = 5e-4, frequency = 1.0, phase = 0.0 }  # m/s, Hz, rad
//!
//! [scene.prescribed_velocity.contact]
//! normal_force = 10.0                                                             # N
//! model.dahl = { dynamic_coefficient = 0.5, micro_stiffness = 1e4 }               # –, 1/m
//! "#;
//! let table = bristle_files::read(file)?.run()?;
//! assert_eq!((table.rows.len(), table.columns[2].0), (301, "force"));
//! let refused = bristle_files::read(&file.replace("10.0", "-10.0")).unwrap_err();
//! let why = ":10:1: normal_force is -10, but must lie between 0 and 1e100";
//! assert_eq!(refused.to_string(), why);
//! # Ok::<(), bristle_files::Refusal>(())
//! ```
//!
//! Scenes, keys and names are in the crate's `docs/files.md`.

mod choices;
mod refusal;
mod scenes;
mod setup;

pub use refusal::{Refusal, read};
pub use setup::{Column, Setup, SolverSetup, Table};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(doctest)]
#[doc = include_str!("../docs/files.md")]
struct Page;
