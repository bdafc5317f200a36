//! Integrators that know about friction.
//!
//! The kink of |v| at each reversal is what general-purpose codes stumble over. Here a [`System`]
//! says where its sliding velocities are, the driver locks their directions, steps on the smooth
//! field, locates each reversal on the dense output and splits the step there. States live on the
//! stack; no step allocates.
//!
//! | method | for |
//! |---|---|
//! | [`DormandPrince`] | adaptive steps, order 5(4), dense output |
//! | [`RungeKutta4`] | fixed steps, split at reversals; or [`plain`](Solver::plain) at a fixed cost |
//!
//! Tolerances are per component: the states of a friction problem have nothing in common but the
//! time. Take 1e-6 of each state's scale or tighter: with loose tolerances a stuck mass chatters at
//! the level of the tolerance, every reversal is located, and the run is both wrong (each cycle
//! lets the mass creep a little) and often dearer than a tight one.

mod automatic;
mod controller;
mod curve;
mod dormand_prince;
mod dormand_prince8;
mod event;
mod failure;
mod integration;
mod locked;
mod method;
mod reversal;
mod rodas4;
mod rodas5p;
mod root;
mod rosenbrock;
mod runge_kutta4;
mod settings;
mod solver;
mod statistics;
mod step;
mod system;
mod tolerance;
#[cfg(feature = "alloc")]
mod trajectory;
#[cfg(test)]
mod trees;

pub use automatic::Automatic;
pub use curve::Curve;
pub use dormand_prince::DormandPrince;
pub use dormand_prince8::DormandPrince8;
pub use event::{Action, Direction, Event, Occurrence};
pub use failure::{Failure, StopReason};
pub use integration::Integration;
pub use method::{Attempt, Embedded, Field, Method, Point};
pub use rodas4::Rodas4;
pub use rodas5p::Rodas5P;
pub use runge_kutta4::RungeKutta4;
pub use solver::{Observer, Outcome, Solver, Summary};
pub use statistics::Statistics;
pub use step::Step;
pub use system::{System, Tangent};
pub use tolerance::{Tolerances, TolerancesParameters};
#[cfg(feature = "alloc")]
pub use trajectory::{Interrupted, Output, Reversal, Trajectory, solve};
