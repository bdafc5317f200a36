//! The step of the implicit bristle at a held velocity, without inner roots.
//!
//! With the velocity held the state is one number, and so is the speed u of the tip in the direction of the load:
//!
//! Φ(u) = |e|,  d|e|/dt = σ0 (w − u),  hence  du/dt = σ0 (w − u)/Φ'(u)
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | u, w | speed of the tip, velocity of the body, both in the direction of the load e = σ0 z + σ1 v | m/s |
//! | g = w − u | what is left of the way to steady sliding, ż in that direction | m/s |
//! | Φ = σ1 u + f(u), f = μ sgn_ε | as in the model | – |
//! | E*, u⁻, u⁺ | where a folded Φ is folded by the rule: the load, and the tip's speed below and above it | –, m/s |
//!
//! While the tip sticks, z and the load grow as v t: closed form. While it slides, g = g₀ e^(−Λ), and
//!
//! t = (1/σ0) ∫ Φ'(u) dΛ,  ∫ F dt = (p/σ0) ∫ f(u) Φ'(u) dΛ,
//!
//! integrals of known functions, with an integrand that is finite at a fold (Φ' = 0) and constant near steady sliding. They
//! are taken over pieces of Λ by Gauss's rule with three nodes. The same rule must return the change of f,
//! ∫ f' g dΛ, that the ends of a piece tell: an estimate of its error at no cost. What is linear in u is integrated in closed form.
//!
//! Where the load comes to E*, the tip goes over from u⁻ to u⁺ or back. With u⁻ < w < u⁺ both sides lead to
//! E*: there the load stays, the tip changes back and forth without end, w on average, and the bristle
//! carries σ0 z = E* − σ1 w.
//!
//! In one step a tip that has passed the fold can come back, stick, be turned round and pass the other fold: at most five
//! changes. A curve whose last valley is higher than its first summit has more folds than one E* tells; there the
//! coefficients are frozen over the step.

use super::{Fold, ImplicitBristle, Surface, damping};
use crate::bounds::{larger, smaller};
use crate::curve::FrictionCurve;
use crate::regularisation::Regularisation;
use crate::rheology::Rheology;
use crate::scalar::{is_zero, lit, to_f64};
use crate::{Branch, Bristle, FoldRule, HeldStep, Scalar};

/// Most pieces of Λ, tried or kept, in one step. What is left then is done with the coefficients frozen.
const PIECES: u32 = 288;

/// Pieces after which the accuracy is let go by a factor of a hundred, and again after as many, so that the step comes to its end.
const PATIENCE: u32 = 96;

/// Most changes between sticking and sliding, branches and directions: back from fast sliding to fast sliding the
/// other way takes five.
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

/// Where the rule changes the branch.
#[derive(Debug, Clone, Copy)]
struct Switch<T> {
    /// E*.
    load: T,
    /// u⁻ and u⁺.
    slow: T,
    fast: T,
}

/// The way of the tip through one step.
struct Path<T> {
    branch: Branch,
    /// ±1, of the branch.
    direction: T,
    /// w and g.
    velocity: T,
    gap: T,
    here: Surface<T>,
    /// Beyond the fold.
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
    /// ∫ g dt = (1/σ0) ∫ Φ' g dΛ.
    travel: T,
    impulse: T,
    error: T,
}

/// What a phase ended with.
enum End {
    Time,
    Edge,
    /// Too many pieces.
    Frozen,
}

impl<T, C, E> ImplicitBristle<C, E, T>
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
        if !finite || !(duration > T::zero()) || self.folds.iter().flatten().any(several) {
            return frozen(deflection, duration);
        }
        let damping = damping(&self.rheology);
        let stiffness = self.rheology.storage_stiffness();
        let tip = self.tip(velocity, deflection);
        let (branch, rate) = if tip.direction < T::zero() {
            (Branch::Backward, -self.affine_at(&tip).rate(velocity, deflection))
        } else {
            (Branch::Forward, self.affine_at(&tip).rate(velocity, deflection))
        };
        let size = self.trial(velocity, deflection).abs();
        let mut path = Path {
            branch,
            direction: tip.direction,
            velocity: tip.direction * velocity,
            gap: rate,
            here: self.surface(branch, tip.surface.speed),
            beyond: self.switch(branch).is_some_and(|switch| match self.fold_rule {
                Some(FoldRule::Fastest) => size >= switch.load,
                _ => size > switch.load,
            }),
            deflection,
            left: duration,
            impulse: T::zero(),
            pieces: 0,
        };
        let exact = is_zero(self.regularisation.speed_at_rest());
        let mut sticks = tip.sticks;
        let answer = |path: &Path<T>, end: T| HeldStep {
            deflection: path.deflection,
            end_coefficient: end,
            mean_coefficient: path.impulse / duration,
        };
        for _ in 0..PHASES {
            if sticks {
                if let End::Time = self.stick(&mut path, velocity) {
                    let end = stiffness * path.deflection + damping * velocity;
                    return answer(&path, end);
                }
                sticks = false;
                let switch = self.switch(path.branch).filter(|s| s.load <= path.here.carried);
                if let Some(switch) = switch {
                    if self.pinned(&mut path, &switch) {
                        return answer(&path, stiffness * path.deflection);
                    }
                    self.place(&mut path, switch.fast, true);
                }
                continue;
            }
            let limit = self.limit(&path);
            match self.slide(&mut path, limit) {
                End::Time => return answer(&path, path.direction * path.here.carried),
                End::Frozen => break,
                End::Edge => {}
            }
            let down = path.velocity < limit.unwrap_or(path.velocity);
            match self.switch(path.branch).filter(|_| path.beyond || !down) {
                Some(switch) => {
                    if self.pinned(&mut path, &switch) {
                        return answer(&path, stiffness * path.deflection);
                    }
                    let to = if down { switch.slow } else { switch.fast };
                    self.place(&mut path, to, !down);
                    sticks = exact && down && is_zero(to);
                }
                None if exact => sticks = true,
                None => self.turn(&mut path, velocity),
            }
        }
        let rest = frozen(path.deflection, path.left);
        path.impulse += rest.mean_coefficient * path.left;
        path.deflection = rest.deflection;
        answer(&path, rest.end_coefficient)
    }

    fn switch(&self, branch: Branch) -> Option<Switch<T>> {
        let fold =
            self.folds.get(usize::from(branch == Branch::Backward)).and_then(|fold| *fold)?;
        let Fold { summit, valley, other } = fold;
        Some(match self.fold_rule? {
            FoldRule::Slowest => Switch { load: summit.1, slow: summit.0, fast: other },
            FoldRule::Fastest => Switch { load: valley.1, slow: other, fast: valley.0 },
        })
    }

    /// How far the tip can go on its branch, if that is not to steady sliding.
    fn limit(&self, path: &Path<T>) -> Option<T> {
        let (switch, w) = (self.switch(path.branch), path.velocity);
        if path.gap < T::zero() {
            let least = switch.filter(|_| path.beyond).map_or(T::zero(), |switch| switch.fast);
            (w < least).then_some(least)
        } else {
            let most = switch.filter(|_| !path.beyond)?.slow;
            (w > most).then_some(most)
        }
    }

    /// Puts the tip at a speed of its branch.
    fn place(&self, path: &mut Path<T>, speed: T, beyond: bool) {
        path.here = self.surface(path.branch, speed);
        path.gap = path.velocity - speed;
        path.beyond = beyond;
    }

    /// The load has passed zero: from rest in the direction of the velocity.
    fn turn(&self, path: &mut Path<T>, velocity: T) {
        let (branch, direction) = if velocity < T::zero() {
            (Branch::Backward, -T::one())
        } else {
            (Branch::Forward, T::one())
        };
        (path.branch, path.direction) = (branch, direction);
        path.velocity = velocity.abs();
        self.place(path, T::zero(), false);
    }

    /// At the switch, where both branches lead to it: spends the time that is left.
    fn pinned(&self, path: &mut Path<T>, switch: &Switch<T>) -> bool {
        let w = path.velocity;
        if !(w >= switch.slow && w <= switch.fast) {
            return false;
        }
        let stiffness = self.rheology.storage_stiffness();
        let carried = path.direction * (switch.load - damping(&self.rheology) * w);
        path.deflection = carried / stiffness;
        path.impulse += carried * path.left;
        true
    }

    /// Sticks until the load is as large as the surface can hold, in the direction of the velocity.
    fn stick(&self, path: &mut Path<T>, velocity: T) -> End {
        self.turn(path, velocity);
        let stiffness = self.rheology.storage_stiffness();
        let load = path.direction * self.trial(velocity, path.deflection);
        let held = path.here.carried;
        let most = self.switch(path.branch).map_or(held, |switch| smaller(held, switch.load));
        let until = (most - load) / (stiffness * path.velocity);
        let lasts = !(until < path.left);
        let time = if lasts { path.left } else { larger(until, T::zero()) };
        let way = velocity * time;
        path.deflection += way;
        path.impulse += path.direction * time * (load + lit::<T>(0.5) * stiffness * way.abs());
        path.left -= time;
        if lasts { End::Time } else { End::Edge }
    }

    /// Slides until the time is over, or the tip's speed has come to a limit.
    fn slide(&self, path: &mut Path<T>, limit: Option<T>) -> End {
        let damping = damping(&self.rheology);
        let stiffness = self.rheology.storage_stiffness();
        let accuracy = lit::<T>(ACCURACY) + T::default_epsilon() * lit(16.0);
        let rest = self.regularisation.speed_at_rest();
        // The next piece as the error lets it grow; and one that took too long, if there was one. A regularised
        // tip's Φ' changes with u + |0|_ε.
        let (mut reach, mut open) = (lit::<T>(LONGEST), lit::<T>(LONGEST));
        if !is_zero(rest) {
            reach = smaller(reach, (path.here.speed + rest) / path.gap.abs());
        }
        loop {
            let slope = larger(damping + path.here.carried_slope, T::zero());
            // Nothing left to come: as the balance weighs it, and not beside the velocity.
            let steepest = damping + self.curve.viscous_friction() + path.here.carried_slope.abs();
            if path.gap.abs() * steepest <= T::default_epsilon() * path.here.mu {
                let carried = path.direction * path.here.carried;
                path.deflection = (carried - damping * path.direction * path.gap) / stiffness;
                path.impulse += carried * path.left;
                return End::Time;
            }
            // ln(g/(w − limit)).
            let edge =
                limit.map(|limit| ((limit - path.here.speed) / (path.velocity - limit)).ln_1p());
            if edge.is_some_and(|edge| !(edge > T::zero())) {
                return End::Edge;
            }
            let wanted = stiffness * path.left / slope;
            let mut length = smaller(if wanted < open { wanted } else { open }, reach);
            loop {
                if path.pieces >= PIECES {
                    return End::Frozen;
                }
                path.pieces += 1;
                let at_edge = edge.is_some_and(|edge| edge <= length);
                // Of a dual number the value alone, but for the edge: the last correction brings the derivative.
                let piece = match edge {
                    Some(edge) if at_edge => self.piece(path, edge, limit),
                    _ => {
                        length = lit(to_f64(length));
                        self.piece(path, length, None)
                    }
                };
                if at_edge {
                    length = edge.unwrap_or(length);
                }
                let patience = i32::try_from(path.pieces / PATIENCE).unwrap_or(0);
                let allowed = accuracy * piece.end.mu * lit::<T>(100.0).powi(patience);
                // Of sixth order.
                let share = allowed / (piece.error + allowed * lit(1e-3));
                let factor = share.powf(lit(1.0 / 7.0)) * lit(0.9);
                if piece.error > allowed && length > T::default_epsilon() {
                    length *= smaller(larger(factor, lit(0.05)), lit(0.7));
                    continue;
                }
                let late = piece.time - path.left;
                let slope = damping + piece.end.carried_slope;
                let arrived = late.abs() * stiffness * piece.gap.abs() <= allowed;
                if arrived && slope > T::zero() && !(at_edge && late < T::zero()) {
                    // To first order over what is left.
                    let way = -late * stiffness * piece.gap / slope;
                    // Not next to a fold, where the slope vanishes.
                    let near = way.abs() <= (path.gap - piece.gap).abs();
                    let way = if near { way } else { T::zero() };
                    let carried = piece.end.carried + piece.end.carried_slope * way;
                    path.here = Surface { carried, ..piece.end };
                    path.impulse += path.direction * (piece.impulse - late * carried);
                    let travel = piece.travel - late * piece.gap;
                    self.settle(path, travel, (carried, piece.gap - way));
                    return End::Time;
                }
                if late > T::zero() {
                    open = length;
                    let newton = length - late * stiffness / slope;
                    let inside = newton > T::zero() && newton < length;
                    length = if inside { newton } else { length * lit(0.5) };
                    continue;
                }
                path.left = -late;
                path.impulse += path.direction * piece.impulse;
                self.settle(path, piece.travel, (piece.end.carried, piece.gap));
                (path.gap, path.here) = (piece.gap, piece.end);
                if at_edge {
                    return End::Edge;
                }
                open -= length;
                if !(open > T::zero()) || to_f64(open) > 0.5 * LONGEST {
                    open = lit(LONGEST);
                }
                reach = smaller(length * smaller(factor, lit(8.0)), lit(LONGEST));
                break;
            }
        }
    }

    /// A piece of Λ of some length, which ends at a known speed or not.
    fn piece(&self, path: &Path<T>, length: T, speed: Option<T>) -> Piece<T> {
        let damping = damping(&self.rheology);
        let (gap, here, w) = (path.gap, path.here, path.velocity);
        // u − u₀ = g₀ (1 − e^−Λ), and u from the end that it keeps its digits by.
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
            Node { weight: lit(weight), gap, surface: self.surface(path.branch, speed) }
        });
        // A line through the end; what bends away from it is left to the rule.
        let chord = weighted(&nodes, |node| node.surface.carried_slope);
        let line = |gap: T| end.carried + chord * (gap_there - gap);
        let bend = weighted(&nodes, |node| (node.surface.carried_slope - chord) * node.gap);
        let rest = weighted(&nodes, |Node { gap, surface, .. }| {
            surface.carried * (damping + surface.carried_slope) - line(*gap) * (damping + chord)
        });
        let square = weighted(&nodes, |Node { gap, surface, .. }| {
            (surface.carried * surface.carried_slope - line(*gap) * chord) * *gap
        });
        let stiffness = self.rheology.storage_stiffness();
        let rise = chord * way + length * bend;
        // Of f, and of ½ f², beside that of the line.
        let start = end.carried - chord * way;
        let off = (rise - (end.carried - here.carried)).abs();
        let half: T = lit(0.5);
        let off_square =
            (length * square - half * (start - here.carried) * (start + here.carried)).abs();
        // ∫ (u − u_end) dΛ = g_end Λ − (u_end − u₀).
        let line = end.carried * length + chord * (gap_there * length - way);
        Piece {
            gap: gap_there,
            end,
            time: length * (damping + chord) / stiffness,
            travel: (damping * way + rise) / stiffness,
            impulse: (line * (damping + chord) + length * rest) / stiffness,
            error: off + off_square / end.mu,
        }
    }

    /// The deflection at the end of a piece: as the balance has it, unless it is so small that it would lose its digits.
    fn settle(&self, path: &mut Path<T>, travel: T, (carried, gap): (T, T)) {
        let damped = damping(&self.rheology) * gap;
        let balance = carried - damped;
        path.deflection += path.direction * travel;
        if balance.abs() * lit(16.0) >= carried.abs() + damped.abs() {
            path.deflection = path.direction * balance / self.rheology.storage_stiffness();
        }
    }
}

/// A node of Gauss's rule on a piece.
struct Node<T> {
    weight: T,
    gap: T,
    surface: Surface<T>,
}

fn weighted<T: Scalar>(nodes: &[Node<T>], term: impl Fn(&Node<T>) -> T) -> T {
    nodes.iter().fold(T::zero(), |sum, node| sum + node.weight * term(node))
}

/// Whether Φ has several folds between its first summit and its last valley, which the rules do not order.
fn several<T: Scalar>(fold: &Fold<T>) -> bool {
    !(fold.valley.1 <= fold.summit.1)
}
