//! The range of a curve that falls from static to dynamic friction and rises with viscosity.
//!
//! μ(s) = μ_d + (μ_s − μ_d) D(u) + σ2 s with u = s/v_S and a decay D from 1 to 0. Its slope is
//! zero where −D'(u) = σ2 v_S/(μ_s − μ_d). Since −D' rises to one summit and falls again (or
//! only falls), there are at most two such points: a maximum just above rest, where viscosity
//! outruns a decay that starts flat, and then the minimum of the Stribeck valley.

use super::RationalStribeckParameters;
use crate::parameter::{Checked, Named};
use crate::scalar::{is_zero, lit};
use crate::{Bounds, Scalar};

/// The parameters of a curve that falls from static to dynamic friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Valley<T> {
    pub(super) given: RationalStribeckParameters<T>,
    /// μ_s − μ_d
    pub(crate) drop: T,
    /// 1/v_S
    pub(crate) inverse_velocity: T,
}

impl<T: Scalar> Valley<T> {
    /// Checks μ_s, μ_d, v_S and σ2.
    pub(super) fn new(given: RationalStribeckParameters<T>) -> Checked<Self> {
        let (static_, dynamic) = (given.static_coefficient, given.dynamic_coefficient);
        let (velocity, viscous) = (given.stribeck_velocity, given.viscous_friction);
        Named("dynamic_coefficient", dynamic).positive()?;
        Named("static_coefficient", static_).positive()?;
        Named("static_coefficient", static_).at_least("dynamic_coefficient", dynamic)?;
        Named("stribeck_velocity", velocity).positive()?;
        Named("viscous_friction", viscous).non_negative()?;
        Ok(Self { given, drop: static_ - dynamic, inverse_velocity: T::one() / velocity })
    }

    pub(super) fn with_less_viscous_friction(&self, part: T) -> Self {
        let viscous_friction = self.given.viscous_friction - part;
        Self { given: RationalStribeckParameters { viscous_friction, ..self.given }, ..*self }
    }

    /// Range of the curve for speeds up to `fastest` [m/s], given D(u) and −D'(u) and where the
    /// latter is largest.
    pub(super) fn bounds(
        &self,
        fastest: T,
        decay_and_steepness: impl Fn(T) -> (T, T),
        steepest: T,
    ) -> Bounds<T> {
        let fastest = fastest * self.inverse_velocity;
        let velocity = T::one() / self.inverse_velocity;
        let value = |u: T| {
            let viscous = if is_zero(self.given.viscous_friction) {
                T::zero()
            } else {
                self.given.viscous_friction * u * velocity
            };
            self.given.dynamic_coefficient + self.drop * decay_and_steepness(u).0 + viscous
        };
        let steepness = |u: T| decay_and_steepness(u).1;
        // The steepness at which viscosity balances the fall.
        let balance = self.given.viscous_friction * velocity / self.drop;
        let (start, end) = (value(T::zero()), value(fastest));
        let mut bounds = Bounds::constant(start).union(Bounds::constant(end));
        if balance > T::zero() && balance < steepness(steepest) {
            // Far enough for the steepness to have fallen below the balance again.
            let mut far = steepest.larger(T::one());
            for _ in 0..64 {
                if steepness(far) < balance {
                    break;
                }
                far *= lit(2.0);
            }
            // The summit and the valley, by bisection between a gentle and a steep place. The value
            // at the turn is flat: half the digits of its place are enough for all of its own.
            for mut gentle in [T::zero(), far] {
                let mut steep = steepest;
                for _ in 0..60 {
                    let middle = (gentle + steep) * lit(0.5);
                    if steepness(middle) < balance {
                        gentle = middle;
                    } else {
                        steep = middle;
                    }
                }
                let turn = (gentle + steep) * lit(0.5);
                if turn <= fastest {
                    bounds = bounds.union(Bounds::constant(value(turn)));
                }
            }
        }
        bounds
    }
}
