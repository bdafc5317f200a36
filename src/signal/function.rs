//! A signal given by a function of time.

use core::fmt;

use super::Signal;
use crate::Scalar;

/// A signal given by a closure that returns the value and its rate of change, and K times at
/// which it is not smooth.
///
/// ```
/// use bristle::signal::{Function, Signal};
///
/// // A force that is switched on at t = 1 s.
/// let step = Function::new(|t: f64| if t < 1.0 { (0.0, 0.0) } else { (5.0, 0.0) }, [1.0]);
/// assert_eq!(step.next_kink(0.0, 10.0), Some(1.0));
/// ```
#[derive(Clone, Copy)]
pub struct Function<T, F, const K: usize = 0> {
    function: F,
    kinks: [T; K],
}

impl<T: Scalar, F: Fn(T) -> (T, T), const K: usize> Function<T, F, K> {
    /// A signal from a function and the times at which it is not smooth, in any order.
    ///
    /// At a kink the function should answer with what holds just after it.
    pub fn new(function: F, kinks: [T; K]) -> Self {
        Self { function, kinks }
    }
}

impl<T: fmt::Debug, F, const K: usize> fmt::Debug for Function<T, F, K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Function").field("kinks", &self.kinks).finish_non_exhaustive()
    }
}

impl<T: Scalar, F: Fn(T) -> (T, T) + Clone, const K: usize> Signal<T> for Function<T, F, K> {
    #[inline]
    fn value_and_rate(&self, time: T) -> (T, T) {
        (self.function)(time)
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        let kinks = self.kinks.iter().copied().filter(|&kink| kink > time && kink < towards);
        kinks.reduce(T::smaller)
    }
}
