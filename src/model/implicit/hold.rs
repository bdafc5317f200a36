//! The step of the implicit bristle at a held velocity.
//!
//! With the velocity held, the speed u of the tip in the direction of the load obeys
//!
//! Φ(u) = |e|,  d|e|/dt = σ0 (w − u),  hence  du/dt = σ0 (w − u)/Φ'(u)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | u, w | speed of the tip, velocity of the body, along the load e = σ0 z + σ1 v | m/s |
//! | g = w − u | distance from steady sliding; ż in that direction | m/s |
//! | Φ = σ1 u + μ(u) | the load that the tip carries at a speed | – |
//!
//! While the tip sticks, z and the load grow as v t. While it slides, g = g₀ e^(−Λ), and
//!
//! t = (1/σ0) ∫ Φ'(u) dΛ,  ∫ F dt = (p/σ0) ∫ μ(u) Φ'(u) dΛ.
//!
//! The integrands are constant near steady sliding. They are taken
//! over pieces of Λ by Gauss's rule with three nodes; the part of μ that is linear in u is
//! integrated in closed form. The rule must also return the change of μ over the piece,
//! ∫ μ' g dΛ, which the ends tell: that is the estimate of its error.

use super::Balance;
use super::solve::{UnderTip, heading};
use crate::curve::FrictionCurve;
use crate::scalar::{lit, to_f64};
use crate::{Branch, HeldStep, Scalar};

/// Most pieces of Λ, tried or kept, in one step. The rest is done with the coefficients frozen.
const PIECES: u32 = 288;

/// Most phases of sticking and sliding: from sliding one way to sliding the other way takes three.
const PHASES: u32 = 8;

/// Longest piece: e^−40 is below the roundings of an `f64`.
const LONGEST: f64 = 40.0;

/// Error of a piece in μ, as a share of μ, beside sixteen roundings.
const ACCURACY: f64 = 1e-9;

/// Gauss's rule with three nodes on [0, 1].
const NODES: [(f64, f64); 3] = [
    (0.112_701_665_379_258_31, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_69, 5.0 / 18.0),
];

/// The tip on its way through a step.
struct Path<T> {
    branch: Branch,
    /// ±1, of the branch.
    direction: T,
    /// w and g.
    velocity: T,
    gap: T,
    here: UnderTip<T>,
    sticks: bool,
    deflection: T,
    /// Time left, and ∫ F/p dt so far.
    left: T,
    impulse: T,
    pieces: u32,
}

/// One piece of sliding.
struct Piece<T> {
    gap: T,
    end: UnderTip<T>,
    time: T,
    impulse: T,
    error: T,
}

impl<T: Scalar, C: FrictionCurve<T>> Balance<'_, C, T> {
    pub(super) fn step(&self, velocity: T, deflection: T, duration: T) -> HeldStep<T> {
        let held = self.held(velocity, deflection, duration);
        let HeldStep { deflection, end_coefficient, mean_coefficient } = held;
        if [deflection, end_coefficient, mean_coefficient].iter().all(T::is_finite) {
            return held;
        }
        // A curve that is not a number on the way makes no part of the step one.
        let (deflection, end_coefficient, mean_coefficient) = (T::nan(), T::nan(), T::nan());
        HeldStep { deflection, end_coefficient, mean_coefficient }
    }

    fn held(&self, velocity: T, deflection: T, duration: T) -> HeldStep<T> {
        let frozen = |deflection: T, duration: T| {
            self.affine_at(&self.tip(velocity, deflection)).hold(velocity, deflection, duration)
        };
        let finite = [velocity, deflection, duration].iter().all(T::is_finite);
        if !finite || !(duration > T::zero()) {
            return frozen(deflection, duration);
        }
        let tip = self.tip(velocity, deflection);
        let mut path = Path {
            branch: tip.branch,
            direction: tip.direction,
            velocity: tip.direction * velocity,
            gap: tip.direction * self.affine_at(&tip).rate(velocity, deflection),
            here: self.surface(tip.branch, tip.surface.speed),
            sticks: tip.sticks(),
            deflection,
            left: duration,
            impulse: T::zero(),
            pieces: 0,
        };
        let answer = |path: &Path<T>, end_coefficient: T| HeldStep {
            deflection: path.deflection,
            end_coefficient,
            mean_coefficient: path.impulse / duration,
        };
        for _ in 0..PHASES {
            if path.sticks {
                self.stick(&mut path, velocity);
            } else {
                self.slide(&mut path);
            }
            if !(path.left > T::zero()) {
                return answer(&path, path.direction * path.here.mu);
            }
        }
        let rest = frozen(path.deflection, path.left);
        path.impulse += rest.mean_coefficient * path.left;
        path.deflection = rest.deflection;
        answer(&path, rest.end_coefficient)
    }

    /// Sticks until the load is as large as the surface can hold, in the direction of the velocity.
    fn stick(&self, path: &mut Path<T>, velocity: T) {
        (path.branch, path.direction) = heading(velocity);
        path.velocity = velocity.abs();
        (path.here, path.gap) = (self.surface(path.branch, T::zero()), path.velocity);
        let stiffness = self.stiffness;
        let load = path.direction * self.trial(velocity, path.deflection);
        let held = path.here.mu;
        if !held.is_finite() {
            // Nothing tells what the surface holds.
            (path.deflection, path.impulse, path.left) = (held, held, T::zero());
            return;
        }
        let until = (held - load) / (stiffness * path.velocity);
        path.sticks = !(until < path.left);
        let time = if path.sticks { path.left } else { until.larger(T::zero()) };
        let way = path.velocity * time;
        path.deflection += path.direction * way;
        path.impulse += path.direction * time * (load + lit::<T>(0.5) * stiffness * way);
        path.left -= time;
        if path.sticks {
            path.here.mu = load + stiffness * way;
        }
    }

    /// Keeps the load for the rest of the time.
    fn stay(&self, path: &mut Path<T>) {
        path.impulse += path.direction * path.here.mu * path.left;
        path.left = T::zero();
        self.settle(path);
    }

    /// Slides to where the tip comes to rest or the time is over.
    fn slide(&self, path: &mut Path<T>) {
        let falls = path.gap < T::zero() && path.velocity < T::zero();
        self.slide_on(path, falls);
        path.sticks = falls && path.left > T::zero();
    }

    /// Slides until the time is over, or a tip whose speed falls to zero rests.
    fn slide_on(&self, path: &mut Path<T>, falls: bool) {
        let (stiffness, damping) = (self.stiffness, self.damping);
        let accuracy = lit::<T>(ACCURACY) + T::default_epsilon() * lit(16.0);
        // The longest piece that the error allows, and one that should end with the time.
        let mut reach = lit::<T>(LONGEST);
        let mut wanted = None;
        while path.pieces < PIECES {
            // Steady sliding, as far as the balance can tell.
            let steepest = self.rise() + path.here.mu_slope.abs();
            if path.gap.abs() * steepest <= T::default_epsilon() * path.here.mu {
                return self.stay(path);
            }
            // ln(g/w).
            let to_rest = falls.then(|| (-path.here.speed / path.velocity).ln_1p());
            if to_rest.is_some_and(|to_rest| !(to_rest > T::zero())) {
                return;
            }
            path.pieces += 1;
            let slope = damping + path.here.mu_slope;
            let guess = stiffness * path.left / slope.larger(T::zero());
            let length = reach.smaller(wanted.take().unwrap_or(guess));
            // The derivative of a dual number comes with the last correction, or at rest.
            let last = to_rest.filter(|&to_rest| to_rest <= length);
            let length = last.unwrap_or_else(|| lit(to_f64(length)));
            let piece = self.piece(path, length, last.is_some());
            let allowed = accuracy * piece.end.mu;
            // The rule is of sixth order.
            let share = allowed / (piece.error + allowed * lit(1e-3));
            let factor = share.powf(lit(1.0 / 7.0)) * lit(0.9);
            if piece.error > allowed && length > T::default_epsilon() {
                reach = length * factor.larger(lit(0.05)).smaller(lit(0.7));
                continue;
            }
            let late = piece.time - path.left;
            let behind = late * stiffness;
            let slope = damping + piece.end.mu_slope;
            // Late by one e-fold at most: before that the gap was larger.
            let arrived = (behind * piece.gap).abs() <= allowed && !(behind > slope);
            if arrived && slope > T::zero() && !(last.is_some() && late < T::zero()) {
                // To first order over what is left, but not next to a fold, where the slope
                // vanishes.
                let way = -behind * piece.gap / slope;
                let near = way.abs() <= (path.gap - piece.gap).abs();
                let way = if near { way } else { T::zero() };
                path.impulse += path.direction * (piece.impulse - late * piece.end.mu);
                let mu = piece.end.mu + piece.end.mu_slope * way;
                path.here = UnderTip { mu, ..piece.end };
                path.gap = piece.gap - way;
                path.left = T::zero();
                return self.settle(path);
            }
            if late > T::zero() {
                let newton = length - behind / slope;
                let inside = newton > T::zero() && newton < length;
                wanted = Some(if inside { newton } else { length * lit(0.5) });
                continue;
            }
            path.left = -late;
            path.impulse += path.direction * piece.impulse;
            (path.gap, path.here) = (piece.gap, piece.end);
            self.settle(path);
            if last.is_some() {
                return;
            }
            reach = (length * factor.smaller(lit(8.0))).smaller(lit(LONGEST));
        }
    }

    /// The deflection at which the balance has its tip here.
    fn settle(&self, path: &mut Path<T>) {
        let (stiffness, damping) = (self.stiffness, self.damping);
        path.deflection = path.direction * (path.here.mu - damping * path.gap) / stiffness;
    }

    /// A piece of Λ of some length, to where the tip rests or not.
    fn piece(&self, path: &Path<T>, length: T, to_rest: bool) -> Piece<T> {
        let (stiffness, damping) = (self.stiffness, self.damping);
        let (gap, here, w) = (path.gap, path.here, path.velocity);
        // u − u₀ = g₀ (1 − e^−Λ), and u from the end where it keeps its digits.
        let falls = w.abs() < here.speed;
        let at = |length: T| {
            let (way, kept) = (-gap * (-length).exp_m1(), gap * (-length).exp());
            (way, kept, if falls { w - kept } else { here.speed + way })
        };
        let (way, gap_there, there) =
            if to_rest { (-here.speed, w, T::zero()) } else { at(length) };
        let end = self.surface(path.branch, there);
        let nodes = NODES.map(|(node, weight)| {
            let (_, gap, speed) = at(length * lit(node));
            (lit::<T>(weight), gap, self.surface(path.branch, speed))
        });
        // μ is a line through the end, integrated in closed form, and a rest that is left to the
        // rule.
        let chord = weighted(&nodes, |_, at| at.mu_slope);
        let line = |gap: T| end.mu + chord * (gap_there - gap);
        let bend = weighted(&nodes, |gap, at| (at.mu_slope - chord) * gap);
        let rest = weighted(&nodes, |gap, at| {
            at.mu * (damping + at.mu_slope) - line(gap) * (damping + chord)
        });
        // ∫ (u − u_end) dΛ = g_end Λ − (u_end − u₀).
        let lines = end.mu * length + chord * (gap_there * length - way);
        Piece {
            gap: gap_there,
            end,
            time: length * (damping + chord) / stiffness,
            impulse: (lines * (damping + chord) + length * rest) / stiffness,
            error: (chord * way + length * bend - (end.mu - here.mu)).abs(),
        }
    }
}

/// Gauss's rule over a piece: weight, g and the surface at each node.
fn weighted<T: Scalar>(nodes: &[(T, T, UnderTip<T>)], term: impl Fn(T, &UnderTip<T>) -> T) -> T {
    nodes.iter().fold(T::zero(), |sum, (weight, gap, at)| sum + *weight * term(*gap, at))
}
