//! The sliding velocity as friction sees it: signed value, speed and direction.

use crate::scalar::Scalar;

/// Which smooth branch of |v| to use.
///
/// Every friction law contains |v| and sgn v, which are smooth except at v = 0. A solver that knows
/// the direction of sliding *locks* the branch: it replaces |v| by +v or −v and gets a smooth
/// field. The speed on a locked branch may be negative, so that a trial step may overshoot the
/// reversal before it is cut back to it. You meet a branch in an
/// [`ode::System`](crate::ode::System), which passes `branch.of(v)` on to its contact; anywhere
/// else a plain velocity is enough.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Branch {
    /// |v| as it is, with its kink at v = 0.
    #[default]
    Free,
    /// |v| = v: the direction of sliding is locked to v > 0.
    Forward,
    /// |v| = −v: the direction of sliding is locked to v < 0.
    Backward,
}

impl Branch {
    /// A velocity v [m/s] seen from this branch: what a system passes on to its contact.
    ///
    /// ```
    /// use bristle::Branch;
    ///
    /// let overshoot = Branch::Forward.of(-1e-3);
    /// assert_eq!(overshoot.speed(), -1e-3);
    /// assert_eq!(Branch::Free.of(-1e-3).speed(), 1e-3);
    /// ```
    #[inline(always)]
    pub fn of<T: Scalar>(self, velocity: T) -> Sliding<T> {
        let (speed, direction) = match self {
            Branch::Forward => (velocity, T::one()),
            Branch::Backward => (-velocity, -T::one()),
            // `abs` shows the compiler that such a speed is never negative.
            Branch::Free if velocity > T::zero() => (velocity.abs(), T::one()),
            Branch::Free if velocity < T::zero() => (velocity.abs(), -T::one()),
            // v = 0: the middle of the one-sided values; NaN stays NaN.
            Branch::Free => (velocity * velocity, velocity * velocity),
        };
        Sliding { velocity, speed, direction }
    }

    /// The branch on which a velocity of this sign lies; `Free` for zero, where the direction is
    /// open.
    pub fn towards<T: Scalar>(velocity: T) -> Self {
        if velocity > T::zero() {
            Branch::Forward
        } else if velocity < T::zero() {
            Branch::Backward
        } else {
            Branch::Free
        }
    }

    /// The branch locked to the direction of a velocity; forward for zero, where a side has to be
    /// chosen.
    #[inline]
    pub fn locked<T: Scalar>(velocity: T) -> Self {
        if velocity < T::zero() { Branch::Backward } else { Branch::Forward }
    }

    /// A speed [m/s] in the direction of this branch; forward on the free one.
    #[inline(always)]
    pub fn at_speed<T: Scalar>(self, speed: T) -> Sliding<T> {
        self.of(if self == Branch::Backward { -speed } else { speed })
    }

    /// The branch after a reversal: the opposite direction; the free branch stays free.
    #[must_use]
    pub fn reversed(self) -> Self {
        match self {
            Branch::Free => Branch::Free,
            Branch::Forward => Branch::Backward,
            Branch::Backward => Branch::Forward,
        }
    }
}

/// A sliding velocity seen from a [`Branch`]: made by [`Branch::of`], or from a plain number [m/s],
/// which stands for [`Branch::Free`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sliding<T> {
    velocity: T,
    speed: T,
    direction: T,
}

impl<T: Scalar> Sliding<T> {
    /// Signed velocity v [m/s].
    #[inline(always)]
    pub fn velocity(&self) -> T {
        self.velocity
    }

    /// Speed |v| [m/s]; on a locked branch ±v, negative for a velocity of the wrong sign.
    #[inline(always)]
    pub fn speed(&self) -> T {
        self.speed
    }

    /// Direction d|v|/dv: sgn v on the free branch (0 at v = 0), the sign of a locked branch on it.
    #[inline(always)]
    pub fn direction(&self) -> T {
        self.direction
    }

    /// Velocity, speed and direction, as plain numbers for a call that is not inlined.
    #[inline(always)]
    pub(crate) fn parts(self) -> (T, T, T) {
        (self.velocity, self.speed, self.direction)
    }

    /// From parts that belong together.
    #[inline(always)]
    pub(crate) fn from_parts(velocity: T, speed: T, direction: T) -> Self {
        Self { velocity, speed, direction }
    }

    /// The opposite velocity, seen from the same branch: to compare a law for the two directions of
    /// sliding. On a locked branch the speed is then negative.
    pub fn mirrored(&self) -> Self {
        Self { velocity: -self.velocity, speed: -self.speed, direction: self.direction }
    }
}

impl<T: Scalar> From<T> for Sliding<T> {
    #[inline(always)]
    fn from(velocity: T) -> Self {
        Branch::Free.of(velocity)
    }
}
