//! The square-root regularisation.

use crate::parameter::{Checked, Named};
use crate::regularisation::Regularisation;
use crate::{Scalar, Sliding};

/// The square-root regularisation of the paper, |v|_ε = √(v² + ε) with ε [m²/s²]; |0|_ε = √ε.
///
/// Source: Romano et al. (arXiv 2602.09429), section II-B.
///
/// ```
/// use bristle::regularisation::{Regularisation, SquareRoot};
///
/// let regularisation = SquareRoot::new(1e-4)?;
/// assert_eq!(regularisation.speed(0.0.into()), 1e-2);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SquareRoot<T> {
    epsilon: T,
}

impl<T: Scalar> SquareRoot<T> {
    /// Takes the regularisation parameter ε > 0 [m²/s²]; for ε = 0 there is
    /// [`Unregularised`](crate::regularisation::Unregularised).
    ///
    /// # Errors
    ///
    /// Refuses an ε that is not positive.
    pub fn new(regularisation: T) -> Checked<Self> {
        Ok(Self { epsilon: Named("regularisation", regularisation).positive()? })
    }

    /// The regularisation parameter ε [m²/s²].
    pub fn epsilon(&self) -> T {
        self.epsilon
    }
}

impl<T: Scalar> Regularisation<T> for SquareRoot<T> {
    #[inline]
    fn speed_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        let square = sliding.velocity() * sliding.velocity() + self.epsilon;
        // Beside a velocity whose square overflows ε is nothing.
        let speed = if square.is_finite() { square.sqrt() } else { sliding.velocity().abs() };
        (speed, sliding.velocity() / speed)
    }

    #[inline]
    fn sign_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        let speed = self.speed(sliding);
        // 1 − sgn² written without its cancellation.
        (sliding.velocity() / speed, self.epsilon / (speed * speed * speed))
    }

    fn speed_at_rest(&self) -> T {
        self.epsilon.sqrt()
    }
}
