//! Steady rolling at the instants of a pilot, and a bound on how far a patch is from it.
//!
//! The bristle that is at ξ now has e = z − z\*, z\*(ξ; v, V) = z_ss (1 − e^(−κξ)), and on its way through the patch
//!
//! ė = −λ e − ∂z\*/∂t,  e = 0 at the inlet:  |e(t)| ≤ ∫ e^−(Λ(t) − Λ(s)) |∂z\*/∂t(ξ(s), s)| ds since it entered,
//! |F − F_ss| ≤ L c₀ ∫ p |e| dξ.
//!
//! With ∂z\*/∂t = ż_ss (1 − e^(−κξ)) + z_ss κ̇ ξ e^(−κξ), the part of the integral between two instants is at most
//!
//! |Δz_ss| (1 − e^−κ) + max |z_ss| |ΔM(κ)|,  M = ∫ max_ξ ξ e^(−κξ) dκ = 1 − e^−κ below κ = 1, 1 − 1/e + (ln κ)/e above,
//!
//! for all bristles that were inside by then, those that are now beyond ξ = ∫V dt. It holds as far as z_ss and κ
//! are monotone from one instant to the next; where v reverses they pass through κ = 0.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | z, z_ss, z\* | deflection, of steady sliding, and of steady rolling | m |
//! | λ, Λ = ∫λ dt | relaxation rate, relaxation | 1/s, – |
//! | κ = λ/V | relaxations in a transit | – |
//! | p, L, c₀ | pressure, length of the patch, stiffness of the bristles | N/m, m, 1/m |
//!
//! Source: the characteristics of Romano et al. (arXiv 2602.09429), section IV-A; the bound is of this crate.

use alloc::vec::Vec;

use super::history::Start;
use super::ladder::{Bound, Cache, Cached};
use super::report::Evidence;
use super::rolling::RollingHistory;
use super::walk::{self, Scheme, Walk};
use crate::bounds::{larger, smaller};
use crate::parameter::ParameterError;
use crate::rolling::{MotionOverTime, Patch, Pressure, RateDependent};
use crate::scalar::{is_zero, lit, to_f64};
use crate::signal::Signal;
use crate::{Affine, Scalar};

/// Places at which the load from there on is known.
const PLACES: usize = 128;

/// A patch at one instant, as if it had rolled steadily for ever.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look<T: Scalar> {
    /// v [m/s], V [1/s]
    pub(super) slip: T,
    pub(super) transport: T,
    pub(super) affine: Affine<T>,
    /// z_ss [m]
    stationary: T,
    /// κ [–]
    decay: T,
    /// F_ss [N]
    pub(super) force: T,
}

/// What is looked at.
#[derive(Debug)]
pub(super) struct Looks<'a, T, M, P, S, W> {
    patch: &'a Patch<T, M, P>,
    motion: &'a MotionOverTime<S, W>,
}

impl<'a, T, M, P, S, W> Looks<'a, T, M, P, S, W>
where
    T: Scalar,
    M: RateDependent<T>,
    P: Pressure<T>,
    S: Signal<T>,
    W: Signal<T>,
{
    pub(super) fn new(patch: &'a Patch<T, M, P>, motion: &'a MotionOverTime<S, W>) -> Self {
        Self { patch, motion }
    }

    pub(super) fn at(&self, time: T) -> Result<Look<T>, ParameterError> {
        let crossing = self.patch.forward(walk::at(self.motion, time))?;
        let crate::rolling::Crossing { slip_velocity: slip, transport } = crossing;
        let patch = self.patch;
        let affine = crate::rolling::coefficients(patch.model(), slip)?;
        let still = is_zero(affine.relaxation);
        let decay = if still { T::zero() } else { affine.relaxation / transport };
        let stationary = if still { T::zero() } else { affine.drive * slip / affine.relaxation };
        let gathered = patch.length() * patch.load() * stationary * patch.pressure().rise(decay);
        let force = walk::force(&affine, gathered, patch.normal_force(), slip);
        Ok(Look { slip, transport, affine, stationary, decay, force })
    }
}

/// ∫ max_ξ ξ e^(−κξ) dκ
fn most_lever<T: Scalar>(decay: T) -> T {
    if decay < T::one() {
        return -(-decay).exp_m1();
    }
    let e = T::one().exp();
    T::one() - T::one() / e + decay.ln() / e
}

/// By how much z* changes at most on the way of a bristle from one instant to the next.
fn change<T: Scalar>(from: &Look<T>, to: &Look<T>) -> T {
    let levers = (most_lever(from.decay) - most_lever(to.decay)).abs();
    let risen = -(-larger(from.decay, to.decay)).exp_m1();
    let largest = larger(from.stationary.abs(), to.stationary.abs());
    (from.stationary - to.stationary).abs() * risen + largest * levers
}

/// What happened between two instants.
#[derive(Debug, Clone, Copy)]
struct Leg<T> {
    change: T,
    /// Least relaxation Λ, and least way ∫V dt.
    relaxation: T,
    way: T,
}

fn leg<T: Scalar, M: RateDependent<T>>(
    model: &M,
    from: &Look<T>,
    to: &Look<T>,
    duration: T,
) -> Leg<T> {
    let way = smaller(from.transport, to.transport) * duration;
    if from.slip * to.slip > T::zero() {
        let rate = smaller(from.affine.relaxation, to.affine.relaxation);
        return Leg { change: change(from, to), relaxation: rate * duration, way };
    }
    let rest = |side: &Look<T>| {
        // On its own side of v = 0.
        let least = T::default_epsilon();
        let slip = if side.slip < T::zero() { -least } else { least };
        let stationary = if is_zero(side.slip) { T::zero() } else { model.stationary(slip) };
        change(side, &Look { stationary, decay: T::zero(), ..*side })
    };
    Leg { change: rest(from) + rest(to), relaxation: T::zero(), way }
}

/// Bound and evidence along so many strides.
pub(super) fn bound<T, M, P, S, W>(
    scene: &RollingHistory<T, M, P, S, W>,
    stride: usize,
    strides: usize,
) -> Result<Bound, ParameterError>
where
    T: Scalar,
    M: RateDependent<T>,
    P: Pressure<T>,
    S: Signal<T>,
    W: Signal<T>,
{
    let patch = &scene.patch;
    let model = patch.model();
    let looks = Looks::new(patch, &scene.motion);
    let step = scene.time(stride);
    let after = load_after(patch);
    let way = Walk {
        motion: &scene.motion,
        length: scene.patch.length(),
        interval: step,
        substeps: 8,
        scheme: Scheme::Held,
    };
    let scale = scene.force_scale();
    let mut last = looks.at(T::zero())?;
    let at_start = match scene.start {
        Start::Steady => T::zero(),
        Start::Undeflected => last.stationary.abs() * -(-last.decay).exp_m1(),
    };
    let mut legs: Vec<Leg<T>> = Vec::with_capacity(strides);
    let mut errors = Vec::with_capacity(strides);
    let mut entries = Vec::with_capacity(strides);
    let (mut relaxation, mut relaxations) = (T::zero(), Vec::with_capacity(strides));
    let mut evaluations = 1.0;
    let (mut slowest, mut fastest) = (last.slip.abs(), last.slip.abs());
    let (mut crossed, mut fastest_rate, mut lag, mut steepest) =
        (T::zero(), T::zero(), T::zero(), T::zero());
    let (mut reversals, mut stuck) = (0_usize, 0_usize);
    for index in 1..=strides {
        let end = scene.time(index * stride);
        let next = looks.at(end)?;
        evaluations += 1.0;
        // The last transit is all that matters.
        let begin = way.transit(end, end - step, 1e-9);
        let (from, duration) = match begin {
            Some(begin) => {
                evaluations += 1.0;
                (looks.at(begin)?, end - begin)
            }
            None => (last, step),
        };
        let mut here = leg(model, &from, &next, duration);
        if begin.is_some() {
            here.way = T::one();
        }
        legs.push(here);
        let (mut error, mut distance, mut gone) = (T::zero(), T::zero(), T::zero());
        for leg in legs.iter().rev() {
            error += leg.change * (-gone).exp() * load_at(&after, distance);
            gone += leg.relaxation;
            distance += leg.way;
            if distance >= T::one() {
                break;
            }
        }
        if distance < T::one() {
            error += at_start * (-gone).exp() * load_at(&after, distance);
        }
        // Without rolling the curve jumps at v = 0, and which side it is on may hang on the last digit.
        let nearly = next.slip.abs() <= scene.fastest() * lit(1e-9);
        let jumps = next.transport * step < lit(1e-6);
        let spread = if nearly && jumps { scale + next.force.abs() } else { T::zero() };
        errors.push(to_f64(next.affine.stiffness.abs() * error + spread));
        let reversed = from.slip * next.slip < T::zero();
        let speeds = (from.slip.abs(), next.slip.abs());
        let (slow, fast) = (smaller(speeds.0, speeds.1), larger(speeds.0, speeds.1));
        let uneven = reversed || slow < fast * lit(0.5);
        let rate = larger(from.affine.relaxation, next.affine.relaxation);
        let varied = (next.force - from.force).abs();
        let steep = uneven && rate * duration > lit(0.3) && varied > scale * lit(0.05);
        entries.push(Cached {
            by_memory: to_f64(next.affine.stiffness),
            without: to_f64(patch.normal_force() * next.affine.damping * next.slip),
            lowest: to_f64(next.force),
            spread: to_f64(spread),
            steep,
        });
        let transits = next.transport * step;
        crossed += transits;
        relaxation += larger(rate * step, transits);
        relaxations.push(to_f64(relaxation));
        fastest_rate = larger(fastest_rate, rate + next.transport);
        let share = if begin.is_some() { T::one() } else { transits };
        lag = larger(lag, varied / (scale * share));
        steepest = larger(steepest, next.decay);
        slowest = smaller(slowest, next.slip.abs());
        fastest = larger(fastest, next.slip.abs());
        if last.slip * next.slip < T::zero() {
            reversals += 1;
            slowest = T::zero();
        }
        if next.decay < T::one() {
            stuck += 1;
        }
        last = next;
    }
    let periods = scene.periods(strides * stride);
    let evidence = Evidence {
        slowest: to_f64(slowest),
        fastest: to_f64(fastest),
        reversals,
        lag: to_f64(lag),
        presliding: 1.0 / to_f64(steepest),
        stuck_share: stuck as f64 / strides as f64,
        relaxation: to_f64(relaxation) / periods,
        transits: Some(to_f64(crossed) / periods),
    };
    Ok(Bound {
        errors: Some(errors),
        relaxation: relaxations,
        fastest_rate: to_f64(fastest_rate),
        evidence,
        cache: Cache { stride, entries },
        evaluations,
    })
}

/// L ∫ p dξ from each of some places to the outlet.
fn load_after<T: Scalar, M, P: Pressure<T>>(patch: &Patch<T, M, P>) -> Vec<T> {
    // Midpoints, eight in each part, put right by the normal force.
    let width = lit::<T>(1.0 / (8 * PLACES) as f64);
    let mut after = alloc::vec![T::zero(); PLACES + 1];
    let mut sum = T::zero();
    for place in (0..PLACES).rev() {
        for point in 0..8 {
            sum += patch.pressure().at(width * lit((8 * place + point) as f64 + 0.5));
        }
        if let Some(entry) = after.get_mut(place) {
            *entry = sum;
        }
    }
    for entry in &mut after {
        *entry *= patch.normal_force() / sum;
    }
    after
}

/// That from the last known place before.
fn load_at<T: Scalar>(after: &[T], place: T) -> T {
    let index = to_f64(place * lit(PLACES as f64)) as usize;
    after.get(index).copied().unwrap_or_else(T::zero)
}
