//! Inputs over time: forces, velocities, positions and openings that drive a scene.
//!
//! A signal returns its value and its rate of change at a time, and says where it is not smooth,
//! so that an integrator can end a step there.

mod any;
mod function;
mod polyline;
mod sine;

use core::fmt::Debug;

pub use any::AnySignal;
pub use function::Function;
pub use polyline::{Polyline, Vertex};
pub use sine::{Sine, SineParameters};

use crate::Scalar;

/// A quantity that depends on time alone. A number is one that does not change.
pub trait Signal<T: Scalar>: Debug + Clone {
    /// The value at a time \[s\].
    #[inline]
    fn value(&self, time: T) -> T {
        self.value_and_rate(time).0
    }

    /// The value and its rate of change. At a kink both are those just after it.
    fn value_and_rate(&self, time: T) -> (T, T);

    /// The first time strictly between `time` and `towards` at which the signal is not
    /// smooth.
    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        let _ = (time, towards);
        None
    }

    /// A time \[s\] over which the signal has no more than one extremum. Adaptive steps are no
    /// longer, so that none passes over a whole swing; `None` if the steps need no such limit.
    fn longest_step(&self) -> Option<T> {
        None
    }
}

/// A number is a signal that does not change.
impl<T: Scalar> Signal<T> for T {
    #[inline]
    fn value(&self, _time: T) -> T {
        *self
    }

    #[inline]
    fn value_and_rate(&self, _time: T) -> (T, T) {
        (*self, T::zero())
    }
}
