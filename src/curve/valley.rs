//! The range of a curve that falls from static to dynamic friction and rises with viscosity.
//!
//! μ(s) = μ_d + (μ_s − μ_d) D(u) + σ2 s with u = s/v_S and a decay D from 1 to 0. Its slope is
//! zero where −D'(u) = σ2 v_S/(μ_s − μ_d). Since −D' rises to one summit and falls again (or
//! only falls), there are at most two such points: a maximum just above rest, where viscosity
//! outruns a decay that starts flat, and then the minimum of the Stribeck valley.

use crate::bounds::{larger, smaller};
use crate::scalar::lit;
use crate::{Bounds, Scalar};

/// A Stribeck-like curve over the scaled speed u = s/v_S.
pub(crate) struct Valley<V, S> {
    /// μ at u.
    pub(crate) value: V,
    /// −D'(u), the steepness of the decay.
    pub(crate) steepness: S,
}

impl<V, S> Valley<V, S> {
    /// Range of the curve for 0 ≤ u ≤ `fastest`, given where the steepness is largest and the
    /// steepness at which viscosity balances the fall, σ2 v_S/(μ_s − μ_d).
    pub(crate) fn bounds<T: Scalar>(&self, fastest: T, steepest: T, balance: T) -> Bounds<T>
    where
        V: Fn(T) -> T,
        S: Fn(T) -> T,
    {
        let start = (self.value)(T::zero());
        let end = (self.value)(fastest);
        let mut bounds = Bounds { min: smaller(start, end), max: larger(start, end) };
        if balance > T::zero() && balance < (self.steepness)(steepest) {
            // Far enough for the steepness to have fallen below the balance again.
            let mut far = larger(steepest, T::one());
            for _ in 0..64 {
                if (self.steepness)(far) < balance {
                    break;
                }
                far *= lit(2.0);
            }
            let summit = self.balanced(T::zero(), steepest, balance);
            let valley = self.balanced(far, steepest, balance);
            for turn in [summit, valley] {
                if turn <= fastest {
                    let value = (self.value)(turn);
                    bounds.min = smaller(bounds.min, value);
                    bounds.max = larger(bounds.max, value);
                }
            }
        }
        bounds
    }

    /// Bisection for the u between a gentle and a steep place where the steepness is `balance`.
    fn balanced<T: Scalar>(&self, mut gentle: T, mut steep: T, balance: T) -> T
    where
        S: Fn(T) -> T,
    {
        // The value at the turn is flat: half the digits of its place are enough for all of its
        // own.
        for _ in 0..60 {
            let middle = (gentle + steep) * lit(0.5);
            if (self.steepness)(middle) < balance {
                gentle = middle;
            } else {
                steep = middle;
            }
        }
        (gentle + steep) * lit(0.5)
    }
}
