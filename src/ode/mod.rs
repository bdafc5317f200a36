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
//! cost N + 2 evaluations a step and half of the digits of the Jacobian, and with a wrong scale
//! they may ruin the result.
//!
//! Tolerances are per component, because the states of a friction problem differ by many orders of
//! magnitude, and they are those of the solution. Breakaway amplifies the errors of the steps, a
//! thousandfold in stick-slip, so the driver estimates the error of the solution: it carries the
//! errors of all steps along by the system's own Jacobian. [`solve`] and [`Solver::solve`] begin
//! with steps held to a tenth of the tolerance (a twentieth with a single method), and repeat the
//! run with tighter ones where the estimate exceeds twelve times the tolerance; the steps of such
//! attempts count as rejected.
//!
//! A tolerance does not see what grows from far below it, such as steady sliding on a falling curve
//! that has not begun to stick and slip. Where the Jacobian has eigenvalues that make something
//! grow e⁴-fold over the rest of the run, steps are short enough to follow it. Nor does it always
//! see a kink of the right-hand side that nobody declares; the Jacobians at both ends of a step
//! show it, or, with 12 states and more, what one leaves of the change of the rates. The
//! derivatives that a system gives are compared with differences now and then, and refused if they
//! are wrong ([`StopReason::WrongDerivative`]).
//!
//! A run that hands out its steps ([`Solver::stream`], [`Solver::begin`]) cannot be repeated. Its
//! steps are four thousand times as tight as the tolerance, and it stops with
//! [`StopReason::ErrorsGrow`] where that is not enough. Tolerances above 10⁻⁴ are met as 10⁻⁴ would
//! be (by `Automatic` as 2·10⁻⁴), since coarser steps miss slips without notice.
//! [`Solver::adaptive`] does none of this.
//!
//! The estimate mostly exceeds the error, by a factor of ten. `docs/work-precision.md` says how far
//! answers were off on drawn rigs and valves.

#![allow(
    private_bounds,
    private_interfaces,
    reason = "methods and storages are those of this module"
)]

mod any;
mod automatic;
mod controller;
mod crossing;
mod dense_output;
mod derivative_check;
mod dormand_prince;
mod dormand_prince8;
mod error_limit;
mod event;
mod explicit;
mod failure;
mod graze;
mod growth;
mod integration;
mod kink;
mod locked;
mod progress;
mod rejection;
mod reversal;
mod rodas4;
mod rodas5p;
mod rosenbrock;
mod runge_kutta4;
mod seeds;
mod solver;
mod standing;
mod start;
mod statistics;
mod step;
mod stepper;
mod system;
mod tolerance;
#[cfg(feature = "alloc")]
mod trajectory;
mod turn;

#[cfg(feature = "alloc")]
pub mod dynamic;
mod storage;

use nalgebra::{SMatrix, SVector};

pub use any::AnyMethod;
pub use automatic::Automatic;
pub(crate) use crossing::{Crossing, Search};

pub use dormand_prince::DormandPrince;
pub use dormand_prince8::DormandPrince8;
pub use event::Direction;
pub use failure::StopReason;
pub(crate) use progress::{NextStep, Progress, StepControl};
pub use rodas4::Rodas4;
pub use rodas5p::Rodas5P;
pub use runge_kutta4::RungeKutta4;
pub use solver::Observer;
pub use statistics::Statistics;
pub use stepper::Method;
pub use system::System;
#[cfg(feature = "alloc")]
pub use trajectory::{Output, solve};

/// The types of this module for states in any storage: an `SVector` for those of a number known
/// when the program is compiled, for which this module has shorter names, and a `Vec` for those of
/// [`crate::ode::dynamic`].
pub mod generic {
    pub use super::event::{Event, Occurrence};
    pub use super::failure::Failure;
    pub use super::integration::Integration;
    pub use super::solver::{Solver, Summary};
    pub use super::step::Step;
    pub use super::system::{Equations, Linearisation};
    pub use super::tolerance::Tolerances;
    #[cfg(feature = "alloc")]
    pub use super::trajectory::Trajectory;
}

/// A [`generic::Solver`] of N states.
pub type Solver<T, M, const N: usize> = generic::Solver<T, M, SVector<T, N>>;
/// A [`generic::Integration`] of N states and K contacts.
pub type Integration<'a, T, S, M, const N: usize, const K: usize> =
    generic::Integration<'a, T, SVector<T, N>, S, M, system::Fixed<K>>;
/// A [`generic::Tolerances`] of N states.
pub type Tolerances<T, const N: usize> = generic::Tolerances<T, SVector<T, N>>;
/// A [`generic::Linearisation`] of N states.
pub type Linearisation<T, const N: usize> = generic::Linearisation<SVector<T, N>, SMatrix<T, N, N>>;
/// A [`generic::Step`] of N states.
pub type Step<T, const N: usize> = generic::Step<T, SVector<T, N>>;
/// A [`generic::Event`] of N states.
pub type Event<'a, T, const N: usize> = generic::Event<'a, T, SVector<T, N>>;
/// A [`generic::Occurrence`] of N states.
pub type Occurrence<T, const N: usize> = generic::Occurrence<T, SVector<T, N>>;
/// A [`generic::Summary`] of N states.
pub type Summary<T, const N: usize> = generic::Summary<T, SVector<T, N>>;
/// A [`generic::Failure`] of N states.
pub type Failure<T, const N: usize> = generic::Failure<T, SVector<T, N>>;
/// A [`generic::Trajectory`] of N states.
#[cfg(feature = "alloc")]
pub type Trajectory<T, const N: usize> = generic::Trajectory<T, SVector<T, N>>;
