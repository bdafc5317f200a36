//! The tip of the implicit bristle: the solution of Φ(v_s) = e.
//!
//! Newton's method within a bracket: Φ rises from μ(0) on, and Φ(u) > (σ1 + σ2) u bounds the
//! solution from above.

use super::Balance;
use crate::curve::FrictionCurve;
use crate::scalar::{is_zero, lit, to_f64};
use crate::{Branch, Scalar, Surface};

/// Newton steps after which every other step halves the bracket.
const FREE: u32 = 8;

/// Most evaluations of one solution. With the lower end at zero, a halving takes the upper one down
/// by 1e-4: eleven halvings for 40 decades, five more until the ends are within a factor of 16, and
/// 56 for the digits of an `f64`, 72 together; every other step after the free ones is one of them.
const MOST: u32 = 160;

/// The surface under the tip at one speed.
#[derive(Debug, Clone, Copy)]
pub(super) struct UnderTip<T> {
    pub(super) speed: T,
    /// μ and dμ/d|v|.
    pub(super) mu: T,
    pub(super) mu_slope: T,
}

/// The state of the tip.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tip<T> {
    /// The direction in which it slides or would slide, and its sign ±1.
    pub(super) branch: Branch,
    pub(super) direction: T,
    pub(super) surface: UnderTip<T>,
}

impl<T: Scalar> Tip<T> {
    /// At rest, for a range of loads.
    pub(super) fn sticks(&self) -> bool {
        is_zero(self.surface.speed)
    }
}

impl<T: Scalar, C: FrictionCurve<T>> Balance<'_, C, T> {
    /// e = σ0 z + σ1 v.
    #[inline]
    pub(super) fn trial(&self, velocity: T, deflection: T) -> T {
        self.stiffness * deflection + self.damping * velocity
    }

    /// The surface at a tip speed in one direction.
    #[inline]
    pub(super) fn surface(&self, branch: Branch, speed: T) -> UnderTip<T> {
        let surface = Surface::scaled(branch.at_speed(speed), self.scale);
        let (mu, slope) = surface.friction_and_slope(self.curve);
        // By the speed: the slope comes with the sign of the direction.
        UnderTip { speed, mu, mu_slope: slope * surface.direction() }
    }

    /// Solves Φ(v_s) = e.
    #[inline]
    pub(super) fn tip(&self, velocity: T, deflection: T) -> Tip<T> {
        let trial = self.trial(velocity, deflection);
        let (branch, direction) = heading(trial);
        let size = direction * trial;
        let rest = self.surface(branch, T::zero());
        let tip = |surface| Tip { branch, direction, surface };
        if !size.is_finite() {
            return tip(UnderTip { speed: T::nan(), mu: T::nan(), ..rest });
        }
        if rest.mu >= size {
            return tip(rest);
        }
        // Beyond every solution of Φ(u) = `size`, because Φ(u) > (σ1 + σ2) u: a few roundings, so
        // that it is not met by a step that should end short of it.
        let farthest = size / self.rise() * (T::one() + T::default_epsilon() * lit(8.0));
        let bracket = (T::zero(), farthest);
        tip(self.root(branch, size, bracket, (size - rest.mu) / self.rise()))
    }

    /// σ1 + s σ2, which the slope of Φ is at least on average.
    pub(super) fn rise(&self) -> T {
        self.damping + self.scale * self.curve.viscous_friction()
    }

    /// The surface where Φ(u) = `size`, within a bracket.
    fn root(&self, branch: Branch, size: T, bracket: (T, T), guess: T) -> UnderTip<T> {
        let (mut low, mut high) = bracket;
        let damping = self.damping;
        let epsilon = T::default_epsilon();
        let least_rise = epsilon.sqrt() * self.rise();
        let mut speed = if guess > low && guess < high { guess } else { middle(low, high) };
        let mut round = 0;
        loop {
            round += 1;
            // Of a dual number the value alone: the last correction brings the derivative.
            speed = lit(to_f64(speed));
            let here = self.surface(branch, speed);
            let excess = damping * speed + here.mu - size;
            let correction = excess / (damping + here.mu_slope);
            if excess < T::zero() {
                low = speed;
            } else {
                high = speed;
            }
            let newton = speed - correction;
            // Where Φ is nearly flat, roundings over its slope are no small step.
            let steep = damping + here.mu_slope > least_rise;
            let admissible = newton >= low && newton <= high && steep;
            let rounding = epsilon * lit(2.0) * (damping * speed + here.mu + size);
            let arrived = excess.abs() <= rounding || correction.abs() <= epsilon * speed;
            let inside = newton > low && newton < high;
            let next = if inside && (round <= FREE || round % 2 == 0) {
                newton
            } else {
                middle(low, high)
            };
            let closed = !(next > low && next < high);
            if arrived || closed {
                if !admissible {
                    return here;
                }
                // One more step, a few roundings long, to first order.
                let mu = here.mu - here.mu_slope * correction;
                return UnderTip { speed: newton, mu, ..here };
            }
            if round >= MOST {
                return here;
            }
            speed = next;
        }
    }
}

/// The direction of a load or velocity, and its sign ±1.
pub(super) fn heading<T: Scalar>(signed: T) -> (Branch, T) {
    if signed < T::zero() { (Branch::Backward, -T::one()) } else { (Branch::Forward, T::one()) }
}

/// Where to halve a bracket: in the middle of its ends if these are close, else of their
/// logarithms.
fn middle<T: Scalar>(low: T, high: T) -> T {
    if high <= low * lit(16.0) {
        (low + high) * lit(0.5)
    } else {
        let least = high * lit(1e-8);
        let low = if low > least { low } else { least };
        low.sqrt() * high.sqrt()
    }
}
