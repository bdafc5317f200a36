//! A patch inside a mechanism: over a step it is a source and a damper.
//!
//! With the coefficients taken at a predicted motion (v\*, V\*) the bristles obey a linear
//! equation. Its drive is the mean slip velocity v̄ of the step, which the mechanism determines.
//! The force averaged over the step is affine in it:
//!
//! F̄ = bias + damping·v̄,  damping ≥ 0,
//!
//! and the energy balance is that of the patch itself, integrated over the step:
//!
//! h F̄ v̄ = W₁ − W₀ + D_volume + D_outlet,
//!
//! W = (L/2) ∫ Σ0 z² dξ,  D_outlet = (L/2) Σ0(1) V ∫ z(1, t)² dt,
//!
//! D_volume = L ∫∫ (p (K λ z² + (c₀ − K r) z v̄ + c₂ v̄²) − ½ V Σ0' z²) dξ dt
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | F̄, v̄ | force and slip velocity averaged over the step | N, m/s |
//! | K | stiffness of the stored energy (σ0) | 1/m |
//! | Σ0 = K p | stiffness per length | N/m² |
//! | W | energy stored in the bristles | J |
//! | D | dissipated energy: within the patch, and with the bristles that leave it deflected | J |
//!
//! For FrBD and a pressure that does not rise towards the outlet all parts of D are squares, for
//! every step, prediction and mean velocity.
//!
//! Source: the storage function is that of Romano et al. (arXiv 2602.09429), section IV-B; the
//! step is derived here.

use super::profile::{level_moments, shifted};
use super::queue::Queue;
use super::{ExactPatch, Memory};
use crate::axes::{OfAxes, PatchModel};
use crate::moments::phi1;
use crate::patch::Frozen;
use crate::quadrature::{integrate, integrate_gentle};
use crate::{Patch, PolynomialExponential, Pressure};
use bristle::parameter::Checked;
use bristle::rheology::HeldWeights as _;
use bristle::scalar::{is_zero, lit};
use bristle::{Affine, Scalar};

/// Friction of a patch over one step: F̄ = bias + damping·v̄.
///
/// Made by [`ExactPatch::companion_step`]. Dropping it without [`PatchStep::commit`] leaves the
/// bristles as they were: a step can be solved again with a better prediction. Making a step may
/// merge neighbouring segments, which keeps forces but loses stored energy where they were
/// deflected differently: 0.2 % of it with 100 segments and steps of very different lengths, 18 %
/// with 8.
#[derive(Debug)]
#[must_use = "the bristles move when it is committed"]
pub struct PatchStep<'a, T: Scalar, M, const N: usize, B, V = T, const A: usize = 1> {
    pub(super) rolling: &'a mut ExactPatch<T, M, N, B, V, A>,
    pub(super) couplings: [Coupling<T>; A],
}

/// A step with its coefficients held, and the source and the damper that stand for it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coupling<T: Scalar> {
    frozen: Frozen<T>,
    duration: T,
    pub(super) bias: T,
    pub(super) damping: T,
}

impl<T: Scalar> Coupling<T> {
    /// F̄ = bias + damping·v̄
    fn force(&self, mean_slip_velocity: T) -> T {
        self.bias + self.damping * mean_slip_velocity
    }

    /// Ends the step with a mean slip velocity that is finite.
    fn commit<const N: usize, B: Memory<T, N>>(
        &self,
        queue: &mut Queue<T, N, B>,
        mean_slip_velocity: T,
    ) -> T {
        queue.roll(&self.frozen, self.frozen.affine.drive * mean_slip_velocity, self.duration);
        self.force(mean_slip_velocity)
    }
}

/// Where the work of a step has gone: work = stored + volume + outlet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchLedger<T> {
    /// Friction force averaged over the step \[N\].
    pub force: T,
    /// Work of the mechanism on the patch \[J\], h F̄ v̄.
    pub work: T,
    /// Change of the stored energy \[J\] by this step, without what merging segments loses
    /// ([`PatchStep`]).
    pub stored: T,
    /// Energy \[J\] that left with deflected bristles at the outlet, never negative.
    pub outlet: T,
    /// Energy \[J\] dissipated inside the patch: what is left of the work, so that the account
    /// always balances. Check it against the kinetic energy of your mechanism.
    ///
    /// Never negative, up to rounding, if the patch is passive. Where the pressure rises towards
    /// the outlet, bristles gain energy as they move on, and it can be negative.
    pub volume: T,
}

/// A patch and the bristles of one axis, of a stiffness K [1/m].
impl<T: Scalar, M, const N: usize> Patch<T, M, PolynomialExponential<T, N>> {
    /// The numbers of [`ExactPatch::companion_step`].
    pub(super) fn coupling<B: Memory<T, N>>(
        &self,
        queue: &mut Queue<T, N, B>,
        stiffness: T,
        frozen: Frozen<T>,
        duration: T,
    ) -> Coupling<T> {
        let Frozen { affine, transport, .. } = frozen;
        queue.make_room(transport * duration);
        let [free, driven, kept] = self.mean_deflections(queue, &affine, transport, duration);
        let weight = self.factor * self.length();
        let driven = affine.drive * driven;
        let beyond = beyond_springs(&affine, stiffness, [driven, kept, self.pressure().total()]);
        let bias = weight * affine.stiffness * free;
        let damping = weight * (stiffness * affine.drive * driven + beyond);
        // A rounding, where a stiffness varies.
        let damping = if damping < T::zero() { T::zero() } else { damping };
        Coupling { frozen, duration, bias, damping }
    }

    /// (L/2) Σ0(1) V ∫ z(1, t)² dt over a step with a mean slip velocity.
    fn outlet_loss<B: Memory<T, N>>(
        &self,
        queue: &Queue<T, N, B>,
        stiffness: T,
        coupling: &Coupling<T>,
        mean_slip_velocity: T,
    ) -> T {
        let &Coupling { frozen: Frozen { affine, transport, .. }, duration, .. } = coupling;
        let drive = affine.drive * mean_slip_velocity;
        let one = T::one();
        let reach = transport * duration;
        let mut squares = T::zero();
        queue.leaving(reach.smaller(one), |from, to, steepness, outgoing| {
            let way = to - from;
            let steepness = lit::<T>(2.0) * (steepness + affine.relaxation * (way / transport));
            integrate(steepness, |part, weight| {
                let at = from + way * part;
                let time = at / transport;
                let x = affine.relaxation * time;
                let z = (-x).exp() * outgoing(at) + drive * time * phi1(x);
                squares += weight * way * z * z;
            });
        });
        if reach > one {
            let z = drive / transport * phi1(affine.relaxation / transport);
            squares += (reach - one) * z * z;
        }
        let stiffness = stiffness * self.pressure().at(one);
        lit::<T>(0.5) * self.length() * self.factor * stiffness * squares
    }

    /// Integrals over the patch, weighted with the pressure and averaged over a step, of the
    /// deflection if nothing drives the bristles; of an undeflected patch under r v = 1; and of
    /// e^(−λ age), where the age is the time since the bristle entered or the step began. After
    /// `make_room`.
    ///
    /// Each is one integral over the bristles with the pressure that they meet on their way: in
    /// closed form for those that stay, by quadrature over the segments that leave and over the
    /// part that is new at the end.
    fn mean_deflections<B: Memory<T, N>>(
        &self,
        queue: &Queue<T, N, B>,
        affine: &Affine<T>,
        transport: T,
        duration: T,
    ) -> [T; 3] {
        let pressure = self.pressure();
        let decay = pressure.decay();
        let (zero, one) = (T::zero(), T::one());
        let degree = pressure.terms() + 1;
        let distance = transport * duration;
        let exponent = affine.relaxation * duration;
        let staying = queue.staying(distance);
        let mut free = pressure.weigh_on_the_way(&staying, distance, exponent);
        let whole = affine.weights(duration);
        // How far old bristles get, and ∫ p dξ of those that stay.
        let reach = distance.smaller(one);
        let staying = shifted(level_moments(one - reach, decay), reach, decay);
        let staying = pressure.weigh(&staying);
        let mut driven = whole.driven_mean(one) * staying;
        let mut kept = whole.undriven_mean(one) * staying;
        if !(distance > zero) {
            return [free, driven, kept];
        }

        // The part of the step during which old bristles are inside.
        let crossing = reach / distance;
        queue.leaving(reach, |from, to, steepness, outgoing| {
            let way = to - from;
            let steepness = steepness + exponent * (way / distance) + decay.abs() * way;
            integrate_gentle(degree, steepness, |part, weight| {
                // A bristle that is this far from the outlet.
                let at = from + way * part;
                let along = level_moments::<T, N>(at, decay + affine.relaxation / transport);
                let met = pressure.weigh(&shifted(along, one - at, decay));
                free += weight * (way / distance) * outgoing(at) * met;
            });
        });
        let steepness = exponent * crossing + decay.abs() * reach;
        integrate_gentle(degree, steepness, |part, weight| {
            // This place is old before the share u of the step, and new after it.
            let share = crossing * part;
            let until = affine.weights(duration * share);
            let carried = weight * reach * pressure.at(reach * part);
            let (old, new) = (one - share, share);
            driven += carried * (old * until.end(zero, one) + new * until.driven_mean(one));
            kept += carried * (old * until.end(one, zero) + new * until.undriven_mean(one));
        });
        [free, driven, kept]
    }

    /// W = (L/2) ∫ K p z² dξ \[J\]
    pub(super) fn stored_in<B: Memory<T, N>>(&self, queue: &Queue<T, N, B>, stiffness: T) -> T {
        let mut sum = T::zero();
        queue.over_bristles(self.pressure(), |_, z, load| sum += load * z * z);
        let half = lit::<T>(0.5) * stiffness;
        half * (self.length() * self.factor * sum)
    }
}

/// ∫ p (m (c₀ − K r) + c₂) dξ, where m is the mean deflection over a step under v̄ = 1 of bristles
/// that were undeflected, and K the stiffness of the stored energy: what the friction coefficient
/// rises by beyond the springs. From ∫ p m, ∫ p κ with the mean κ of e^(−λ age), and ∫ p.
fn beyond_springs<T: Scalar>(affine: &Affine<T>, stiffness: T, integrals: [T; 3]) -> T {
    let ([driven, kept, carried], damping) = (integrals, affine.damping);
    let excess = affine.stiffness - stiffness * affine.drive;
    if is_zero(excess) || !(kept + kept < carried) {
        return excess * driven + damping * carried;
    }
    // LuGre's excess is −σ1 λ: in fast sliding both terms are nearly σ1. With λ m = r (1 − κ) the
    // sum is taken apart; of c₂ − σ1 a few roundings count as zero.
    let share = excess * affine.drive / affine.relaxation;
    let rest = share + damping;
    let springs = stiffness * affine.drive / affine.relaxation;
    let rounding = lit::<T>(16.0) * T::default_epsilon() * (damping + springs);
    let rest = if rest.abs() <= rounding { T::zero() } else { rest };
    rest * carried - share * kept
}

impl<T, M, const N: usize, B, V, const A: usize> PatchStep<'_, T, M, N, B, V, A>
where
    T: Scalar,
    M: PatchModel<T, V, A>,
    B: Memory<T, N>,
    V: OfAxes<T, A>,
{
    /// Mean friction force \[N\] if the mean slip velocity is zero.
    pub fn bias(&self) -> V {
        V::of_axes(self.couplings.map(|axis| axis.bias))
    }

    /// Increase of the mean friction force with the mean slip velocity [N s/m], zero or positive on
    /// each axis.
    pub fn damping(&self) -> V {
        V::of_axes(self.couplings.map(|axis| axis.damping))
    }

    /// Mean friction force F̄ \[N\] for a mean slip velocity v̄ [m/s], positive against v̄ > 0.
    pub fn force(&self, mean_slip_velocity: V) -> V {
        let mean = mean_slip_velocity.axes();
        V::of_axes(core::array::from_fn(|i| self.couplings[i].force(mean[i])))
    }

    /// Ends the step with the mean slip velocity v̄ [m/s] that the mechanism has found, and returns
    /// the mean friction force F̄ \[N\]: its impulse on the mechanism is −F̄ h.
    ///
    /// # Errors
    ///
    /// Refuses a velocity that is not finite; the patch is as it was.
    pub fn commit(self, mean_slip_velocity: V) -> Checked<V> {
        let mean = mean_slip_velocity.finite("mean_slip_velocity")?.axes();
        let queues = &mut self.rolling.queues;
        let commit = |i: usize| self.couplings[i].commit(&mut queues[i], mean[i]);
        Ok(V::of_axes(core::array::from_fn(commit)))
    }

    /// Ends the step as [`PatchStep::commit`] does, with an account of where the work has gone on
    /// each axis. The time is proportional to the number of segments.
    ///
    /// # Errors
    ///
    /// Refuses a velocity that is not finite; the patch is as it was.
    pub fn commit_with_ledger(self, mean_slip_velocity: V) -> Checked<[PatchLedger<T>; A]> {
        let mean = mean_slip_velocity.finite("mean_slip_velocity")?.axes();
        let ExactPatch { patch, queues, .. } = self.rolling;
        let stiffness = patch.model().stiffness_of_axes();
        Ok(core::array::from_fn(|i| {
            let (queue, coupling, stiffness) = (&mut queues[i], &self.couplings[i], stiffness[i]);
            let outlet = patch.outlet_loss(queue, stiffness, coupling, mean[i]);
            let before = patch.stored_in(queue, stiffness);
            let force = coupling.commit(queue, mean[i]);
            let stored = patch.stored_in(queue, stiffness) - before;
            let work = coupling.duration * force * mean[i];
            PatchLedger { force, work, stored, outlet, volume: work - stored - outlet }
        }))
    }
}
