//! No regularisation: |v| and sgn v themselves (ε = 0).

use crate::regularisation::Regularisation;
use crate::{Scalar, Sliding};

/// No regularisation: |v| and sgn v as they are, with sgn 0 = 0 on the free branch. A model has
/// this one unless another is given, and a body under less than breakaway then stands still.
///
/// ```
/// use bristle::regularisation::{Regularisation, Unregularised};
///
/// assert_eq!(Unregularised.speed((-0.3).into()), 0.3);
/// assert_eq!(Unregularised.sign(0.0.into()), 0.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "Word", into = "Word"))]
pub struct Unregularised;

/// What it is in a file, as [`AnyRegularisation`](super::AnyRegularisation) writes it: not all
/// formats have a unit.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case", rename = "Unregularised")]
enum Word {
    Unregularised,
}

#[cfg(feature = "serde")]
impl From<Word> for Unregularised {
    fn from(_: Word) -> Self {
        Self
    }
}

#[cfg(feature = "serde")]
impl From<Unregularised> for Word {
    fn from(_: Unregularised) -> Self {
        Self::Unregularised
    }
}

impl<T: Scalar> Regularisation<T> for Unregularised {
    #[inline(always)]
    fn speed_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        (sliding.speed(), sliding.direction())
    }

    #[inline(always)]
    fn sign(&self, sliding: Sliding<T>) -> T {
        sliding.direction()
    }

    #[inline(always)]
    fn sign_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        (sliding.direction(), T::zero())
    }

    fn speed_at_rest(&self) -> T {
        T::zero()
    }
}
