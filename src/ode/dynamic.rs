//! Systems of a size known at run time: with the driver and the methods of fixed sizes, and the
//! same bits.
//!
//! States are on the heap. With up to 400 of them everything is as with a fixed number. With more,
//! the cost of an explicit step grows as their number: no Jacobian is taken, for differences along
//! single directions serve to estimate the error of the solution, and nothing looks for what grows
//! from far below a tolerance (see the [module](super)). [`solve`](super::solve) takes explicit
//! steps alone then: two thousand of a chain of 3 000 states with as many reversals take ten
//! seconds.
//!
//! A stiff system of so many states is dear by either kind of method: an explicit one takes as many
//! steps as stability asks for, and a step of a Rosenbrock method costs as the cube of their
//! number, about a second for 1 000 states and twenty seconds for 3 000.
//!
//! [`ode::solve`](super::solve) takes these systems as those of fixed size. Where you choose a
//! method or tolerances yourself, [`Solver`] and [`Tolerances`] of this module are those for them.
//!
//! ```
//! use bristle::ode::{self, Output, dynamic};
//! use bristle::{Branch, Bristle, Contact, Dahl, DahlParameters};
//!
//! /// Blocks on a belt of 0.1 m/s, each on a spring to the one before; the first to a wall. States
//! /// are the position, the velocity and the bristle deflection of each.
//! struct Blocks { stiffnesses: Vec<f64>, contact: Contact<f64, Dahl<f64>> }
//!
//! impl dynamic::System<f64> for Blocks {
//!     fn states(&self) -> usize { 3 * self.stiffnesses.len() }
//!     fn contacts(&self) -> usize { self.stiffnesses.len() }
//!
//!     fn rate(&self, _: f64, state: &[f64], branches: &[Branch], rate: &mut [f64]) {
//!         let pull = |i: usize| {
//!             let before = if i > 0 { state[3 * i - 3] } else { 0.0 };
//!             self.stiffnesses.get(i).map_or(0.0, |k| k * (state[3 * i] - before))
//!         };
//!         for (i, branch) in branches.iter().enumerate() {
//!             let velocity = state[3 * i + 1];
//!             let friction = self.contact.response(branch.of(velocity - 0.1), state[3 * i + 2]);
//!             let next = if i + 1 < branches.len() { pull(i + 1) } else { 0.0 };
//!             rate[3 * i] = velocity;
//!             rate[3 * i + 1] = next - pull(i) - friction.force;
//!             rate[3 * i + 2] = friction.rate;
//!         }
//!     }
//!
//!     fn sliding_velocities(&self, _: f64, state: &[f64], velocities: &mut [f64]) {
//!         for (velocity, block) in velocities.iter_mut().zip(state.chunks(3)) {
//!             *velocity = block[1] - 0.1;
//!         }
//!     }
//!
//!     fn scales(&self, scales: &mut [f64]) {
//!         scales.chunks_mut(3).for_each(|block| block.copy_from_slice(&[0.1, 0.1, 1e-3]));
//!     }
//! }
//!
//! let read = "10 12 9 11"; // from a file
//! let stiffnesses = read.split(' ').map(str::parse).collect::<Result<Vec<f64>, _>>()?;
//! let friction = Dahl::new(DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 500.0 })?;
//! let blocks = Blocks { stiffnesses, contact: friction.under_load(1.0)? };
//! let motion = ode::solve(&blocks, 0.0..5.0, vec![0.0; 12], 1e-6, Output::Uniform(101))?;
//! assert_eq!(motion.states().len(), 101);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use alloc::vec;
use alloc::vec::Vec;
use core::fmt::Debug;

pub use super::generic::{
    Event, Failure, Integration, Occurrence, Solver, Step, Summary, Tolerances, Trajectory,
};
use super::system::{self, Equations};
use crate::{Branch, Scalar};

/// A mechanism whose numbers of states and of sliding contacts are known at run time: ẋ = f(t, x).
///
/// Its functions are those of [`ode::System`](super::System), which says more. Every slice has the
/// length that [`System::states`] or [`System::contacts`] says.
pub trait System<T: Scalar> {
    /// The number of states.
    fn states(&self) -> usize;

    /// The number of sliding contacts.
    fn contacts(&self) -> usize;

    /// Writes the right-hand side f(t, x) over `rate`, which has other values before, each contact
    /// on its branch.
    fn rate(&self, time: T, state: &[T], branches: &[Branch], rate: &mut [T]);

    /// Writes the sliding velocity [m/s] of each contact, in the order and with the sign of
    /// [`Branch::of`] in [`System::rate`].
    fn sliding_velocities(&self, time: T, state: &[T], velocities: &mut [T]);

    /// Writes the right-hand side with its partial derivatives, all zero before, and answers with
    /// true, if they are known.
    fn linearised(
        &self,
        time: T,
        state: &[T],
        branches: &[Branch],
        linearisation: Linearisation<'_, T>,
    ) -> bool {
        let _ = (time, state, branches, linearisation);
        false
    }

    /// The first time strictly between `time` and `towards` at which an input is not smooth.
    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        let _ = (time, towards);
        None
    }

    /// Tells each quantity that passes zero where the right-hand side has a kink without a
    /// reversal: see [`ode::System::switching_functions`](super::System::switching_functions).
    fn switching_functions(
        &self,
        time: T,
        state: &[T],
        branches: &[Branch],
        tell: &mut dyn FnMut(T),
    ) {
        let _ = (time, state, branches, tell);
    }

    /// No adaptive step is longer than this \[s\].
    fn longest_step(&self) -> Option<T> {
        None
    }

    /// Writes a typical magnitude of each state, one before.
    fn scales(&self, scales: &mut [T]) {
        let _ = scales;
    }
}

/// A right-hand side and its partial derivatives at one point, to be written.
#[derive(Debug)]
pub struct Linearisation<'a, T> {
    /// f(t, x).
    pub rate: &'a mut [T],
    /// The Jacobian by columns: ∂fᵢ/∂xⱼ at j n + i, for n states.
    pub by_state: &'a mut [T],
    /// ∂f/∂t.
    pub by_time: &'a mut [T],
}

/// Of a number of contacts known at run time.
#[derive(Debug, Clone, Copy)]
pub struct Any;

impl<T: Scalar, S: System<T> + ?Sized> Equations<T, Vec<T>, Any> for S {
    type Contacts<X: Copy + Debug> = Vec<X>;

    fn states(&self) -> usize {
        System::states(self)
    }

    fn contacts(&self) -> usize {
        System::contacts(self)
    }

    #[inline]
    fn rate_to(&self, time: T, state: &Vec<T>, branches: &Vec<Branch>, rate: &mut Vec<T>) {
        self.rate(time, state, branches, rate);
    }

    #[inline]
    fn velocities_to(&self, time: T, state: &Vec<T>, velocities: &mut Vec<T>) {
        self.sliding_velocities(time, state, velocities);
    }

    #[inline]
    fn tangent(
        &self,
        time: T,
        state: &Vec<T>,
        branches: &Vec<Branch>,
    ) -> Option<system::Linearisation<Vec<T>, Vec<T>>> {
        let zeros = |count| vec![T::zero(); count];
        let n = state.len();
        let (mut rate, mut by_state, mut by_time) = (zeros(n), zeros(n * n), zeros(n));
        let to = Linearisation { rate: &mut rate, by_state: &mut by_state, by_time: &mut by_time };
        let is_known = self.linearised(time, state, branches, to);
        is_known.then_some(system::Linearisation { rate, by_state, by_time })
    }

    #[inline]
    fn kink(&self, time: T, towards: T) -> Option<T> {
        self.next_kink(time, towards)
    }

    #[inline]
    fn switching(&self, time: T, state: &Vec<T>, branches: &Vec<Branch>) -> Option<Vec<T>> {
        let tell_all = |tell: &mut dyn FnMut(T)| {
            self.switching_functions(time, state, branches, tell);
        };
        system::told(state.len(), tell_all)
    }

    fn limit(&self) -> Option<T> {
        self.longest_step()
    }

    fn magnitudes(&self) -> Vec<T> {
        let mut scales = vec![T::one(); System::states(self)];
        self.scales(&mut scales);
        scales
    }
}
