//! An undamped bristle: F/p = σ0 z.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | σ0 | normalised micro-stiffness | 1/m |

use super::Elements;
use crate::parameter::{self, ParameterError};
use crate::rheology::Rheology;
use crate::{Bounds, Scalar, Sliding};

/// Parameters of [`Spring`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpringParameters<T> {
    /// Normalised micro-stiffness σ0 [1/m], positive.
    #[doc(alias = "sigma0")]
    pub micro_stiffness: T,
}

/// An undamped bristle, F/p = σ0 z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring<T> {
    stiffness: T,
}

impl<T: Scalar> Spring<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a stiffness that is not positive.
    pub fn new(parameters: SpringParameters<T>) -> Result<Self, ParameterError> {
        Ok(Self { stiffness: parameter::positive("micro_stiffness", parameters.micro_stiffness)? })
    }
}

impl<T: Scalar> Rheology<T> for Spring<T> {
    type Deflection = T;

    #[inline(always)]
    fn elements(&self, _sliding: Sliding<T>) -> Elements<T> {
        Elements { stiffness: self.stiffness, decay: T::zero(), damping: T::zero() }
    }

    #[inline(always)]
    fn elements_and_slopes(&self, sliding: Sliding<T>) -> (Elements<T>, Elements<T>) {
        let slopes = Elements { stiffness: T::zero(), decay: T::zero(), damping: T::zero() };
        (self.elements(sliding), slopes)
    }

    #[inline]
    fn stationary(&self, _sliding: Sliding<T>, coefficient: T) -> T {
        coefficient / self.stiffness
    }

    fn storage_stiffness(&self) -> T {
        self.stiffness
    }

    fn stiffness_bounds(&self) -> Bounds<T> {
        Bounds::constant(self.stiffness)
    }

    fn damping_bounds(&self) -> Bounds<T> {
        Bounds::constant(T::zero())
    }

    fn decay_bounds(&self) -> Bounds<T> {
        Bounds::constant(T::zero())
    }

    fn has_constant_decay(&self) -> bool {
        true
    }

    fn is_single_spring(&self) -> bool {
        true
    }

    fn is_even(&self) -> bool {
        true
    }
}
