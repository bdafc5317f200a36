//! A regularisation chosen at run time.

use super::{HyperbolicTangent, Regularisation, SquareRoot, Unregularised};
use crate::{Scalar, Sliding};

/// A regularisation chosen at run time: one of this crate's, with its numbers to the last bit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "serde", serde(bound(deserialize = "T: Scalar + serde::Deserialize<'de>")))]
#[cfg_attr(feature = "serde", serde(bound(serialize = "T: Scalar + serde::Serialize")))]
#[non_exhaustive]
pub enum AnyRegularisation<T> {
    /// |v| as it is.
    #[default]
    Unregularised,
    /// √(v² + ε).
    SquareRoot(SquareRoot<T>),
    /// v coth(v/v_t).
    HyperbolicTangent(HyperbolicTangent<T>),
}

/// Calls a function of the regularisation.
macro_rules! of_the_regularisation {
    ($self:ident, $modulus:ident => $answer:expr) => {
        match $self {
            AnyRegularisation::Unregularised => {
                let $modulus = &Unregularised;
                $answer
            }
            AnyRegularisation::SquareRoot($modulus) => $answer,
            AnyRegularisation::HyperbolicTangent($modulus) => $answer,
        }
    };
}

impl<T: Scalar> Regularisation<T> for AnyRegularisation<T> {
    #[inline(always)]
    fn speed(&self, sliding: Sliding<T>) -> T {
        of_the_regularisation!(self, modulus => modulus.speed(sliding))
    }

    #[inline(always)]
    fn speed_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        of_the_regularisation!(self, modulus => modulus.speed_and_slope(sliding))
    }

    #[inline]
    fn sign(&self, sliding: Sliding<T>) -> T {
        of_the_regularisation!(self, modulus => modulus.sign(sliding))
    }

    #[inline]
    fn sign_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        of_the_regularisation!(self, modulus => modulus.sign_and_slope(sliding))
    }

    fn speed_at_rest(&self) -> T {
        of_the_regularisation!(self, modulus => modulus.speed_at_rest())
    }
}

impl<T> From<Unregularised> for AnyRegularisation<T> {
    fn from(_: Unregularised) -> Self {
        Self::Unregularised
    }
}

impl<T> From<SquareRoot<T>> for AnyRegularisation<T> {
    fn from(modulus: SquareRoot<T>) -> Self {
        Self::SquareRoot(modulus)
    }
}

impl<T> From<HyperbolicTangent<T>> for AnyRegularisation<T> {
    fn from(modulus: HyperbolicTangent<T>) -> Self {
        Self::HyperbolicTangent(modulus)
    }
}
