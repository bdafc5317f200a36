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
//! | Φ = σ1 u + f(u), f = μ sgn_ε | as in the model | – |
//! | E*, u⁻, u⁺ | load where a folded Φ changes its branch; tip's speeds beside it | –, m/s |
//!
//! While the tip sticks, z and the load grow as v t. While it slides, g = g₀ e^(−Λ), and
//!
//! t = (1/σ0) ∫ Φ'(u) dΛ,  ∫ F dt = (p/σ0) ∫ f(u) Φ'(u) dΛ.
//!
//! The integrands are finite at a fold (Φ' = 0) and constant near steady sliding. They are taken
//! over pieces of Λ by Gauss's rule with three nodes; the part of f that is linear in u is
//! integrated in closed form. The rule must also return the change of f over the piece,
//! ∫ f' g dΛ, which the ends tell: that is the estimate of its error.
//!
//! Where the load reaches E*, the tip goes over from u⁻ to u⁺ or back. With u⁻ < w < u⁺ both
//! branches lead to E*. There the load stays: the tip alternates between the branches, at the mean
//! speed w, and the bristle carries σ0 z = E* − σ1 w.
//!
//! A curve whose last valley is higher than its first summit has more folds than one E* describes;
//! there the coefficients are frozen over the step.

use super::ImplicitBristle;
use super::solve::{Fold, Surface, heading};
use crate::bounds::{larger, smaller};
use crate::curve::FrictionCurve;
use crate::regularisation::Regularisation;
use crate::scalar::{is_zero, lit, to_f64};
use crate::{Branch, Bristle, FoldRule, HeldStep, Scalar};

/// Most pieces of Λ, tried or kept, in one step. The rest is done with the coefficients frozen.
const PIECES: u32 = 288;

/// Pieces after which the accuracy is relaxed by a factor of a hundred, and again after as many.
const PATIENCE: u32 = 96;

/// Most changes between sticking and sliding, branches and directions: from fast sliding one way to
/// fast sliding the other way takes five.
const PHASES: u32 = 8;

/// Longest piece: e^−40 is below the roundings of an `f64`.
const LONGEST: f64 = 40.0;

/// Error of a piece in f, as a share of μ, beside sixteen roundings.
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
    here: Surface<T>,
    /// On the branch beyond the fold.
    beyond: bool,
    deflection: T,
    /// Time left, and ∫ F/p dt so far.
    left: T,
    impulse: T,
    pieces: u32,
}

/// One piece of sliding.
struct Piece<T> {
    gap: T,
    end: Surface<T>,
    time: T,
    impulse: T,
    error: T,
}

/// What ended a phase.
enum End {
    Time,
    Edge,
    TooManyPieces,
}

impl<C, E, T> ImplicitBristle<C, E, T>
where
    T: Scalar,
    C: FrictionCurve<T>,
    E: Regularisation<T>,
{
    pub(super) fn step(&self, velocity: T, deflection: T, duration: T) -> HeldStep<T> {
        let frozen = |deflection: T, duration: T| {
            self.affine(velocity.into(), deflection).hold(velocity, deflection, duration)
        };
        let finite = velocity.is_finite() && deflection.is_finite() && duration.is_finite();
        // Several folds between the first summit and the last valley are not ordered by the rules.
        let several = |fold: &Fold<T>| !(fold.valley.1 <= fold.summit.1);
        if !finite || !(duration > T::zero()) || self.folds.iter().flatten().any(several) {
            return frozen(deflection, duration);
        }
        let (stiffness, damping) = self.elements();
        let exact = is_zero(self.regularisation.speed_at_rest());
        let tip = self.tip(velocity, deflection);
        let mut sticks = tip.sticks;
        let rate = self.affine_at(&tip).rate(velocity, deflection);
        let size = self.trial(velocity, deflection).abs();
        let beyond = self.switch(tip.branch).is_some_and(|(load, ..)| match self.fold_rule {
            Some(FoldRule::Fastest) => size >= load,
            _ => size > load,
        });
        let mut path = Path {
            branch: tip.branch,
            direction: tip.direction,
            velocity: tip.direction * velocity,
            gap: tip.direction * rate,
            here: self.surface(tip.branch, tip.surface.speed),
            beyond,
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
            // The speed at which the branch ends on the way to w, if it does before.
            let switch = self.switch(path.branch);
            let falls = path.gap < T::zero();
            let edge = match switch {
                Some((_, _, fast)) if path.beyond && falls => Some(fast),
                Some((_, slow, _)) if !path.beyond && !falls => Some(slow),
                _ if falls => Some(T::zero()),
                _ => None,
            };
            let edge = edge
                .filter(|&edge| if falls { path.velocity < edge } else { path.velocity > edge });
            let ended =
                if sticks { self.stick(&mut path, velocity) } else { self.slide(&mut path, edge) };
            match ended {
                End::Time if sticks => {
                    let end = stiffness * path.deflection + damping * velocity;
                    return answer(&path, end);
                }
                End::Time => return answer(&path, path.direction * path.here.carried),
                End::TooManyPieces => break,
                End::Edge => {}
            }
            // From sticking over the fold only if the load is there already.
            let switch = self.switch(path.branch);
            let held = path.here.carried;
            let crossing = if sticks {
                switch.filter(|&(load, ..)| load <= held)
            } else {
                switch.filter(|_| path.beyond || !falls)
            };
            match crossing {
                Some((load, slow, fast)) => {
                    let w = path.velocity;
                    if w >= slow && w <= fast {
                        // Both branches lead here.
                        let carried = path.direction * (load - damping * w);
                        path.deflection = carried / stiffness;
                        path.impulse += carried * path.left;
                        return answer(&path, carried);
                    }
                    let down = !sticks && falls;
                    let to = if down { slow } else { fast };
                    self.place(&mut path, to, !down);
                    sticks = exact && down && is_zero(to);
                }
                None if sticks => sticks = false,
                None if exact => sticks = true,
                None => self.turn(&mut path, velocity),
            }
        }
        let rest = frozen(path.deflection, path.left);
        path.impulse += rest.mean_coefficient * path.left;
        path.deflection = rest.deflection;
        answer(&path, rest.end_coefficient)
    }

    /// E*, u⁻ and u⁺ in one direction.
    fn switch(&self, branch: Branch) -> Option<(T, T, T)> {
        let Fold { summit, valley, other } = self.fold_of(branch)?;
        Some(match self.fold_rule? {
            FoldRule::Slowest => (summit.1, summit.0, other),
            FoldRule::Fastest => (valley.1, other, valley.0),
        })
    }

    /// Puts the tip at a speed of its branch.
    fn place(&self, path: &mut Path<T>, speed: T, beyond: bool) {
        path.here = self.surface(path.branch, speed);
        path.gap = path.velocity - speed;
        path.beyond = beyond;
    }

    /// The load has passed zero: from rest in the direction of the velocity.
    fn turn(&self, path: &mut Path<T>, velocity: T) {
        (path.branch, path.direction) = heading(velocity);
        path.velocity = velocity.abs();
        self.place(path, T::zero(), false);
    }

    /// Sticks until the load is as large as the surface can hold, in the direction of the velocity.
    fn stick(&self, path: &mut Path<T>, velocity: T) -> End {
        self.turn(path, velocity);
        let (stiffness, _) = self.elements();
        let load = path.direction * self.trial(velocity, path.deflection);
        let held = path.here.carried;
        let most = self.switch(path.branch).map_or(held, |(load, ..)| smaller(held, load));
        let until = (most - load) / (stiffness * path.velocity);
        let lasts = !(until < path.left);
        let time = if lasts { path.left } else { larger(until, T::zero()) };
        let way = velocity * time;
        path.deflection += way;
        path.impulse += path.direction * time * (load + lit::<T>(0.5) * stiffness * way.abs());
        path.left -= time;
        if lasts { End::Time } else { End::Edge }
    }

    /// Slides until the time is over, or the tip's speed has come to an edge.
    fn slide(&self, path: &mut Path<T>, edge: Option<T>) -> End {
        let (stiffness, damping) = self.elements();
        let accuracy = lit::<T>(ACCURACY) + T::default_epsilon() * lit(16.0);
        let rest = self.regularisation.speed_at_rest();
        // The longest piece that the error allows. A regularised Φ' changes with u + |0|_ε.
        let mut reach = lit::<T>(LONGEST);
        if !is_zero(rest) {
            reach = smaller(reach, (path.here.speed + rest) / path.gap.abs());
        }
        let mut wanted = None;
        loop {
            let slope = damping + path.here.carried_slope;
            // Steady sliding, as far as the balance can tell, here and where the tip is heading: a
            // regularised f that is flat at this speed is steep near rest.
            let steady = |at: &Surface<T>| {
                let steepest = damping + self.curve.viscous_friction() + at.carried_slope.abs();
                path.gap.abs() * steepest <= T::default_epsilon() * path.here.mu
            };
            let target = larger(path.velocity, T::zero());
            if steady(&path.here) && steady(&self.surface(path.branch, target)) {
                path.impulse += path.direction * path.here.carried * path.left;
                self.settle(path);
                return End::Time;
            }
            // ln(g/(w − edge)).
            let to_edge =
                edge.map(|edge| ((edge - path.here.speed) / (path.velocity - edge)).ln_1p());
            if to_edge.is_some_and(|to_edge| !(to_edge > T::zero())) {
                return End::Edge;
            }
            if path.pieces >= PIECES {
                return End::TooManyPieces;
            }
            path.pieces += 1;
            let guess = stiffness * path.left / larger(slope, T::zero());
            let length = smaller(reach, wanted.take().unwrap_or(guess));
            // The derivative of a dual number comes with the last correction, or with the edge.
            let last = to_edge.filter(|&to_edge| to_edge <= length);
            let length = last.unwrap_or_else(|| lit(to_f64(length)));
            let piece = self.piece(path, length, edge.filter(|_| last.is_some()));
            let patience = i32::try_from(path.pieces / PATIENCE).unwrap_or(0);
            let allowed = accuracy * piece.end.mu * lit::<T>(100.0).powi(patience);
            // The rule is of sixth order.
            let share = allowed / (piece.error + allowed * lit(1e-3));
            let factor = share.powf(lit(1.0 / 7.0)) * lit(0.9);
            if piece.error > allowed && length > T::default_epsilon() {
                reach = length * smaller(larger(factor, lit(0.05)), lit(0.7));
                continue;
            }
            let late = piece.time - path.left;
            let behind = late * stiffness;
            let slope = damping + piece.end.carried_slope;
            // Late by one e-fold at most: before that the gap was larger.
            let arrived = (behind * piece.gap).abs() <= allowed && !(behind > slope);
            if arrived && slope > T::zero() && !(last.is_some() && late < T::zero()) {
                // To first order over what is left, but not next to a fold, where the slope
                // vanishes.
                let way = -behind * piece.gap / slope;
                let near = way.abs() <= (path.gap - piece.gap).abs();
                let way = if near { way } else { T::zero() };
                let carried = piece.end.carried + piece.end.carried_slope * way;
                path.here = Surface { carried, ..piece.end };
                path.gap = piece.gap - way;
                path.impulse += path.direction * (piece.impulse - late * carried);
                self.settle(path);
                return End::Time;
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
                return End::Edge;
            }
            reach = smaller(length * smaller(factor, lit(8.0)), lit(LONGEST));
        }
    }

    /// The deflection at which the balance has its tip here.
    fn settle(&self, path: &mut Path<T>) {
        let (stiffness, damping) = self.elements();
        path.deflection = path.direction * (path.here.carried - damping * path.gap) / stiffness;
    }

    /// A piece of Λ of some length, which ends at a known speed or not.
    fn piece(&self, path: &Path<T>, length: T, speed: Option<T>) -> Piece<T> {
        let (stiffness, damping) = self.elements();
        let (gap, here, w) = (path.gap, path.here, path.velocity);
        // u − u₀ = g₀ (1 − e^−Λ), and u from the end where it keeps its digits.
        let falls = w.abs() < here.speed;
        let at = |length: T| {
            let (way, kept) = (-gap * (-length).exp_m1(), gap * (-length).exp());
            (way, kept, if falls { w - kept } else { here.speed + way })
        };
        let (way, gap_there, there) = match speed {
            Some(speed) => (speed - here.speed, w - speed, speed),
            None => at(length),
        };
        let end = self.surface(path.branch, there);
        let nodes = NODES.map(|(node, weight)| {
            let (_, gap, speed) = at(length * lit(node));
            (lit::<T>(weight), gap, self.surface(path.branch, speed))
        });
        // f is a line through the end, integrated in closed form, and a rest that is left to the
        // rule.
        let chord = weighted(&nodes, |_, at| at.carried_slope);
        let line = |gap: T| end.carried + chord * (gap_there - gap);
        let bend = weighted(&nodes, |gap, at| (at.carried_slope - chord) * gap);
        let rest = weighted(&nodes, |gap, at| {
            at.carried * (damping + at.carried_slope) - line(gap) * (damping + chord)
        });
        // ∫ (u − u_end) dΛ = g_end Λ − (u_end − u₀).
        let lines = end.carried * length + chord * (gap_there * length - way);
        Piece {
            gap: gap_there,
            end,
            time: length * (damping + chord) / stiffness,
            impulse: (lines * (damping + chord) + length * rest) / stiffness,
            error: (chord * way + length * bend - (end.carried - here.carried)).abs(),
        }
    }
}

/// Gauss's rule over a piece: weight, g and the surface at each node.
fn weighted<T: Scalar>(nodes: &[(T, T, Surface<T>)], term: impl Fn(T, &Surface<T>) -> T) -> T {
    nodes.iter().fold(T::zero(), |sum, (weight, gap, at)| sum + *weight * term(*gap, at))
}
