//! The tip of the implicit bristle: the solution of Φ(v_s) = e, and the folds of Φ.
//!
//! Newton's method within a bracket. Without a fold Φ rises from μ(0) on, and Φ(u) > (σ1 + σ2) u
//! bounds the solution from above. With a fold the rule says on which side of it to look.

use super::{FoldRule, ImplicitBristle};
use crate::curve::FrictionCurve;
use crate::scalar::{is_zero, lit, nan, smaller, to_f64};
use crate::{Branch, Scalar};

/// Newton steps after which every other step halves the bracket.
const FREE: u32 = 8;

/// Most evaluations of one solution. With the lower end at zero, a halving takes the upper one down
/// by 1e-4: eleven halvings for 40 decades, five more until the ends are within a factor of 16, and
/// 56 for the digits of an `f64`, 72 together; every other step after the free ones is one of them.
const MOST: u32 = 160;

/// The surface under the tip at one speed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface<T> {
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
    pub(super) surface: Surface<T>,
}

impl<T: Scalar> Tip<T> {
    /// At rest, for a range of loads.
    pub(super) fn sticks(&self) -> bool {
        is_zero(self.surface.speed)
    }
}

/// A fold of Φ: where the rule goes over from one rising branch to the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fold<T> {
    /// The load E* that both branches carry there: Φ at the first summit with
    /// [`FoldRule::Slowest`], at the last valley with [`FoldRule::Fastest`].
    pub(super) load: T,
    /// The tip's speeds u⁻ and u⁺ on the slow and on the fast branch [m/s]; u⁻ is zero if the
    /// surface holds more than E* at rest.
    pub(super) slow: T,
    pub(super) fast: T,
    /// Whether there is nothing but one summit and one valley between these.
    pub(super) single: bool,
}

impl<T: Scalar, C: FrictionCurve<T>> ImplicitBristle<C, T> {
    /// e = σ0 z + σ1 v.
    #[inline]
    pub(super) fn trial(&self, velocity: T, deflection: T) -> T {
        let (stiffness, damping) = self.elements();
        stiffness * deflection + damping * velocity
    }

    /// The surface at a tip speed in one direction.
    #[inline]
    pub(super) fn surface(&self, branch: Branch, speed: T) -> Surface<T> {
        let velocity = if branch == Branch::Backward { -speed } else { speed };
        let sliding = branch.of(velocity);
        let (mu, slope) = self.curve.coefficient_and_slope(sliding);
        // By the speed: the slope comes with the sign of the direction.
        Surface { speed, mu, mu_slope: slope * sliding.direction() }
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
            return tip(Surface { speed: nan(), mu: nan(), ..rest });
        }
        let farthest = self.farthest(size);
        // From where on, what Φ is there, and how far.
        let (low, carried, high) = match self.fold_of(branch) {
            Some(fold) if self.is_beyond(&fold, size) => (fold.fast, fold.load, farthest),
            Some(fold) => (T::zero(), rest.mu, smaller(fold.slow, farthest)),
            None => (T::zero(), rest.mu, farthest),
        };
        if is_zero(low) && rest.mu >= size {
            return tip(rest);
        }
        let rise = self.elements().1 + self.curve.viscous_friction();
        tip(self.root(branch, size, (low, high), low + (size - carried) / rise))
    }

    /// A speed beyond every solution of Φ(u) = `size`, because Φ(u) > (σ1 + σ2) u: a few roundings,
    /// so that it is not met by a step that should end short of it.
    fn farthest(&self, size: T) -> T {
        let rise = self.elements().1 + self.curve.viscous_friction();
        size / rise * (T::one() + T::default_epsilon() * lit(8.0))
    }

    /// The fold of Φ in one direction, if it has one.
    pub(super) fn fold_of(&self, branch: Branch) -> Option<Fold<T>> {
        let [forward, backward] = self.folds;
        if branch == Branch::Backward { backward } else { forward }
    }

    /// Whether the rule takes the fast branch at a load.
    fn is_beyond(&self, fold: &Fold<T>, size: T) -> bool {
        match self.fold_rule {
            Some(FoldRule::Fastest) => size >= fold.load,
            _ => size > fold.load,
        }
    }

    /// The surface where Φ(u) = `size`, within a bracket.
    fn root(&self, branch: Branch, size: T, bracket: (T, T), guess: T) -> Surface<T> {
        let (mut low, mut high) = bracket;
        let (_, damping) = self.elements();
        let epsilon = T::default_epsilon();
        let least_rise = epsilon.sqrt() * (damping + self.curve.viscous_friction());
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
            // Next to a fold, where Φ is flat, roundings over its slope are no small step.
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
                return Surface { speed: newton, mu: here.mu - here.mu_slope * correction, ..here };
            }
            if round >= MOST {
                return here;
            }
            speed = next;
        }
    }

    /// Finds the fold of Φ in one direction, if it has one. Φ is looked at from 1e-12 to 1e6 m/s,
    /// at sixteen speeds to each doubling; a fall between two of these is too shallow to matter.
    #[cold]
    pub(super) fn fold(&self, branch: Branch) -> Option<Fold<T>> {
        const PER_DOUBLING: u32 = 16;
        const DOUBLINGS: u32 = 60;
        let (_, damping) = self.elements();
        let load = |speed: T| damping * speed + self.surface(branch, speed).mu;
        let rises = |speed: T| damping + self.surface(branch, speed).mu_slope >= T::zero();
        // Brackets of the first summit, if it is not at rest, and of the last valley.
        let ratio = lit::<T>(2.0).powf(lit(1.0 / f64::from(PER_DOUBLING)));
        let (mut summit, mut valley) = (None, None);
        let (mut before, mut speed, mut rose) = (T::zero(), lit(1e-12), true);
        for _ in 0..DOUBLINGS * PER_DOUBLING {
            let up = rises(speed);
            if !up {
                summit = summit.or(Some((before, speed)));
            } else if !rose {
                valley = Some((before, speed));
            }
            (before, speed, rose) = (speed, speed * ratio, up);
        }
        let turn = |(mut low, mut high): (T, T), first: bool| {
            for _ in 0..200 {
                let middle = (low + high) * lit(0.5);
                if rises(middle) == first { low = middle } else { high = middle }
            }
            (low + high) * lit(0.5)
        };
        // From rest on it falls if it does just beyond: at rest |v|^δ with δ < 1 does not tell.
        let summit = if !rises(lit(1e-30)) { T::zero() } else { turn(summit?, true) };
        let valley = turn(valley?, false);
        let (most, least) = (load(summit), load(valley));
        let single = least <= most;
        Some(match self.fold_rule {
            Some(FoldRule::Fastest) => {
                let before = (T::zero(), if single { summit } else { valley });
                let rests = load(T::zero()) >= least;
                let slow =
                    if rests { T::zero() } else { self.root(branch, least, before, nan()).speed };
                Fold { load: least, slow, fast: valley, single }
            }
            _ => {
                let after = if single { (valley, self.farthest(most)) } else { (summit, valley) };
                let fast = self.root(branch, most, after, nan()).speed;
                Fold { load: most, slow: summit, fast, single }
            }
        })
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
