//! A regularisation chosen at run time.

use super::{HyperbolicTangent, Regularisation, SquareRoot, Unregularised};
use crate::{Scalar, Sliding};

/// A regularisation chosen at run time, by a file for instance: one of this crate's, with its
/// numbers to the last bit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum AnyRegularisation<T: Scalar> {
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
    passed_on! { of_the_regularisation:
        #[inline(always)]
        speed(sliding: Sliding<T>) -> T;
        #[inline(always)]
        speed_and_slope(sliding: Sliding<T>) -> (T, T);
        #[inline]
        sign(sliding: Sliding<T>) -> T;
        #[inline]
        sign_and_slope(sliding: Sliding<T>) -> (T, T);
        speed_at_rest() -> T;
    }
}

impl<T: Scalar> From<Unregularised> for AnyRegularisation<T> {
    fn from(_: Unregularised) -> Self {
        Self::Unregularised
    }
}

holds! { AnyRegularisation:
    SquareRoot(SquareRoot<T>)
    HyperbolicTangent(HyperbolicTangent<T>)
}
