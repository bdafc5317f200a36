//! What repeats.
mod branch;
mod control_loop;
mod driven_mass;
mod error;
mod flow;
mod hunting;
mod multipliers;
mod shooting;

pub use branch::{BranchEnd, BranchPoint, Continuation, OrbitBranch, PointKind};
pub use control_loop::{ControlLoop, ControlLoopParameters, Pid};
pub use driven_mass::DrivenMass;
pub use error::PeriodicError;
pub use hunting::{HuntingCycle, HuntingReport, Outcome, hunting, hunting_map, hunting_orbit};
pub use multipliers::Multiplier;
pub use shooting::{Guess, Orbit, Shooting};
