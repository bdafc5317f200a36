//! A signal chosen at run time.

#[cfg(feature = "alloc")]
use alloc::vec::Vec;

#[cfg(feature = "alloc")]
use super::{Polyline, Vertex};
use super::{Signal, Sine};
use crate::Scalar;

/// A signal chosen at run time: one of this crate's, with its numbers to the last bit.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum AnySignal<T: Scalar> {
    /// A number that does not change.
    Constant(
        #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::serialisation::constant"))]
        T,
    ),
    /// A sine about a mean.
    Sine(Sine<T>),
    /// Straight lines between any number of points.
    #[cfg(feature = "alloc")]
    Polyline(Polyline<Vec<Vertex<T>>>),
}

/// Calls a function of the signal.
macro_rules! of_the_signal {
    ($self:ident, $signal:ident => $answer:expr) => {
        match $self {
            AnySignal::Constant($signal) => $answer,
            AnySignal::Sine($signal) => $answer,
            #[cfg(feature = "alloc")]
            AnySignal::Polyline($signal) => $answer,
        }
    };
}

impl<T: Scalar> Signal<T> for AnySignal<T> {
    passed_on! { of_the_signal:
        #[inline]
        value(time: T) -> T;
        #[inline]
        value_and_rate(time: T) -> (T, T);
        next_kink(time: T, towards: T) -> Option<T>;
        longest_step() -> Option<T>;
    }
}

impl<T: Scalar> From<T> for AnySignal<T> {
    fn from(value: T) -> Self {
        Self::Constant(value)
    }
}

holds! { AnySignal:
    Sine(Sine<T>)
    #[cfg(feature = "alloc")]
    Polyline(Polyline<Vec<Vertex<T>>>)
}
