//! No regularisation: |v| and sgn v themselves (ε = 0).

use crate::regularisation::Regularisation;
use crate::{Scalar, Sliding};

/// No regularisation: |v| and sgn v as they are, with sgn 0 = 0 on the free branch.
///
/// ```
/// use bristle::regularisation::{Regularisation, Unregularised};
///
/// assert_eq!(Unregularised.speed((-0.3).into()), 0.3);
/// assert_eq!(Unregularised.sign(0.0.into()), 0.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Unregularised;

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
