//! A signal that does not change.

use super::Signal;
use crate::Scalar;
use crate::parameter::{self, ParameterError};

/// A signal that does not change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constant<T> {
    value: T,
}

impl<T: Scalar> Constant<T> {
    /// A signal that always has this value.
    ///
    /// # Errors
    ///
    /// Refuses a value that is not finite.
    pub fn new(value: T) -> Result<Self, ParameterError> {
        Ok(Self { value: parameter::finite("value", value)? })
    }

    /// The signal that is always zero: no force.
    pub fn zero() -> Self {
        Self { value: T::zero() }
    }
}

impl<T: Scalar> Signal<T> for Constant<T> {
    #[inline]
    fn value(&self, _time: T) -> T {
        self.value
    }

    #[inline]
    fn value_and_rate(&self, _time: T) -> (T, T) {
        (self.value, T::zero())
    }
}
