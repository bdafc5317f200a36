//! What repeats.
mod control_loop;
mod driven_mass;
mod error;
mod flow;
mod multipliers;
mod shooting;

pub use control_loop::{ControlLoop, ControlLoopParameters, Pid};
pub use driven_mass::DrivenMass;
pub use error::PeriodicError;
pub use multipliers::Multiplier;
pub use shooting::{Guess, Orbit, Shooting};
