//! An undamped bristle: F/p = σ0 z.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | σ0 | normalised micro-stiffness | 1/m |

use super::{ElementBounds, Elements};
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
    fn elements_and_slopes(&self, _sliding: Sliding<T>) -> (Elements<T>, Elements<T>) {
        let zero = T::zero();
        (
            Elements { stiffness: self.stiffness, decay: zero, damping: zero },
            Elements { stiffness: zero, decay: zero, damping: zero },
        )
    }

    #[inline(always)]
    fn storage_stiffness(&self) -> T {
        self.stiffness
    }

    fn bounds(&self) -> ElementBounds<T> {
        let (stiffness, damping) = (Bounds::constant(self.stiffness), Bounds::constant(T::zero()));
        ElementBounds::elastic(stiffness, damping, true)
    }
}
