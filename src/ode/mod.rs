//! Integrators that know about friction.
//!
//! At each reversal |v| has a kink, a jump in its slope, where general-purpose codes lose accuracy
//! or time. Here a [`System`] says where its sliding velocities are, the driver locks their
//! directions, steps on the smooth field, locates each reversal on the dense output and splits the
//! step there. States live on the stack; no step allocates.
//!
//! | method | for |
//! |---|---|
//! | [`Automatic`] | the default of [`solve`]: `DormandPrince8` and `Rodas5P` take turns |
//! | [`DormandPrince`] | explicit, order 5(4): inputs of low smoothness, moderate tolerances |
//! | [`DormandPrince8`] | explicit, order 8(5,3): tight tolerances |
//! | [`Rodas4`], [`Rodas5P`] | L-stable Rosenbrock methods of order 4(3) and 5(4): stiff systems |
//! | [`RungeKutta4`] | fixed steps, split at reversals or [`plain`](Solver::plain) |
//! | [`AnyMethod`] | one of these, chosen at run time |
//!
//! All but `RungeKutta4` choose their steps by an error estimate and have a dense output of their
//! own. A Rosenbrock method needs the Jacobian: give [`System::linearised`]. Otherwise finite
//! differences are taken, over √ε of the larger of each state and its [scale](System::scales). They
//! cost N + 2 evaluations a step and half of the digits of the Jacobian, and with a wrong scale they
//! may ruin the result.
//!
//! Tolerances are per component, because the states of a friction problem differ by many orders of
//! magnitude. Breakaway amplifies errors, so every adaptive method takes its steps with tolerances
//! tighter than those asked for: a tenth at 10⁻⁶, at most 2·10⁻⁶, and less for some methods. A
//! Rosenbrock method rejects a step over which a state at rest grows by more than it can represent.
//!
//! On the paper's scenes no run that succeeds is off, in any state, by a thousand times a tolerance
//! of 10⁻⁵ or less, nor by a tenth of the state's scale at any tolerance. That is no guarantee: on
//! drawn rigs (`cargo test --release --test ode -- --ignored drawn`, other rigs with each
//! `BRISTLE_SEED`) single runs were off by 2 300 tolerances of 10⁻⁵, and by 1.6 scales at 10⁻¹.

mod any;
mod automatic;
mod controller;
mod crossing;
mod dense_output;
mod dormand_prince;
mod dormand_prince8;
mod event;
mod explicit;
mod failure;
mod integration;
mod locked;
mod reversal;
mod rodas4;
mod rodas5p;
mod rosenbrock;
mod runge_kutta4;
mod solver;
mod start;
mod statistics;
mod step;
mod stepper;
mod system;
mod tolerance;
#[cfg(feature = "alloc")]
mod trajectory;
mod walk;

pub use any::AnyMethod;
pub use automatic::Automatic;
pub(crate) use crossing::{Crossing, Search};

pub use dormand_prince::DormandPrince;
pub use dormand_prince8::DormandPrince8;
pub use event::{Direction, Event, Occurrence};
pub use failure::{Failure, StopReason};
pub use integration::Integration;
pub use rodas4::Rodas4;
pub use rodas5p::Rodas5P;
pub use runge_kutta4::RungeKutta4;
pub(crate) use solver::check_samples;
pub use solver::{Observer, Solver, Summary};
pub use statistics::Statistics;
pub use step::Step;
pub use stepper::Method;
pub use system::{Linearisation, System};
pub use tolerance::Tolerances;
#[cfg(feature = "alloc")]
pub use trajectory::{Output, Trajectory, solve};
pub(crate) use walk::{Pace, Trial, Walk};
