//! A bristle dragged at a known velocity v(t), to high order with any step: exponential
//! collocation.
//!
//! In one direction of sliding the deflection obeys a scalar linear equation with smooth
//! coefficients,
//!
//! ż = −λ(t) z + r(t) v(t) = −λ (z − z_ss),  z_ss = r v/λ,
//!
//! z(h) = e^−Λ z(0) + ∫ e^−(Λ − Λ(s)) r v ds,  Λ(s) = ∫₀ˢ λ,
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | z, z_ss | deflection, and the stationary one at the velocity of the instant | m |
//! | λ, r | relaxation rate, drive (see [`Affine`](crate::Affine)) | 1/s, – |
//! | Λ | relaxation over the step | – |
//! | S | nodes a step, 2 to 8 | – |
//!
//! so z(h) is a mean of z(0) and of the z_ss on the way, with positive weights. A step takes v, λ
//! and r at S Radau nodes, all at once: none waits for another, as the stages of a Runge–Kutta
//! method do.
//!
//! * Let R be the range of z_ss over the nodes, widened by the lag of a bristle that follows it.
//!   The part of z(0) outside R is the *excess*; it decays exactly by e^−Λ, since the equation is
//!   linear. At a held velocity R is a point and nothing is left to approximate.
//! * The rest is a polynomial of degree S that meets the equation at the nodes: collocation, which
//!   for a linear equation is one small linear system. Its order is 2S − 1; as λh → ∞ the end
//!   becomes z_ss there, and as λh → 0 it is Gauss–Radau quadrature of v.
//! * z(h) is cut to the range of z(0) and of the z_ss at the nodes. The mean over these nodes with
//!   the weights b_i hλ_i e^−(Λ − Λ_i), all positive, misses the exact solution by an error of the
//!   same order, so the exact solution is never farther outside: the cut costs no order.
//! * Between the ends runs a polynomial of one degree more, through the rate at the start too: an
//!   error of order S + 2 in the length of the step.
//! * Where v reverses the step is split, with the place of the reversal found to rounding: |v| has
//!   a kink there.
//!
//! The mean force and the work come from the same nodes, to the order 2S − 1.
//!
//! An elasto-plastic model's α is frozen at the beginning of each step, and only the first order is
//! left: take short steps.
//!
//! Source: the collocation is Radau IIA of E. Hairer, G. Wanner, "Solving Ordinary Differential
//! Equations II", section IV.5; splitting off the exact transient and the cut are of this crate.

mod dense_step;
mod nodes;
mod run;
mod solver;

pub use dense_step::{DenseStep, StepSummary};
pub use run::CollocationRun;
pub use solver::CollocationSolver;

use core::ops::Range;

use crate::ode::{Crossing, Search, StepControl};
use crate::parameter::{Checked, Named};
use crate::scalar::{is_zero, lit};
use crate::{Branch, Bristle, Contact, Scalar};
use dense_step::Sample;
use nodes::{MOST_NODES, Nodes};

/// Parts into which the reversals of one velocity may split a step.
const MOST_PARTS: usize = 1000;

/// Searches for an earlier reversal than the one found, each in a shorter step.
const MOST_SEARCHES: usize = 64;

/// Exponential collocation with S nodes a step, of order 2S − 1.
///
/// Each node costs one evaluation of the friction model. Three serve a control loop, five a
/// simulation.
///
/// ```
/// use bristle::exponential::Exponential;
/// use bristle::{Bristle, FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
/// let contact = FrBd::new(curve, bristle).under_load(1.0)?;
///
/// // Velocities sampled once per millisecond, straight lines between them.
/// let samples = [0.0, 0.004, 0.009, 0.002, -0.006];
/// let mut deflection = 0.0;
/// let mut work = 0.0;
/// for pair in samples.windows(2) {
///     let step = Exponential::<3>.ramp(&contact, pair[0]..pair[1], deflection, 1e-3);
///     deflection = step.deflection;
///     work += step.work;
/// }
/// assert!(work > 0.0 && deflection > 0.0);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Exponential<const S: usize>;

impl<const S: usize> Exponential<S> {
    /// A step of length h ≥ 0 \[s\] over which the velocity [m/s] varies linearly, from the start
    /// of a range to its end.
    ///
    /// Where it reverses, the step is split. See [`Contact::hold`] for what such a step is good
    /// for.
    #[inline]
    pub fn ramp<T: Scalar, M: Bristle<T, Deflection = T>>(
        self,
        contact: &Contact<T, M>,
        velocities: Range<T>,
        deflection: T,
        duration: T,
    ) -> StepSummary<T> {
        if !(duration >= T::zero()) {
            return StepSummary::unknown();
        }
        let Range { start: from, end: to } = velocities;
        let along = |place: T| from + (to - from) * place;
        let (zero, one) = (T::zero(), T::one());
        let part = |span: (T, T), branch, deflection| {
            smooth::<T, M, _, S>(contact, branch, along, span, duration, deflection).summary()
        };
        let ahead = if is_zero(from) { to } else { from };
        let branch = Branch::locked(ahead);
        if !(from < zero && to > zero || from > zero && to < zero) {
            return part((zero, one), branch, deflection);
        }
        let turn = from / (from - to);
        let before = part((zero, turn), branch, deflection);
        let after = part((turn, one), branch.reversed(), before.deflection);
        StepSummary { mean: before.mean * turn, ..before }.then(after, one - turn)
    }

    /// A step of length h ≥ 0 \[s\] over which the velocity [m/s] is a smooth function of the part
    /// of the step that is over, from 0 to 1.
    ///
    /// Where it reverses, the step is split. A reversal and its return between two neighbouring
    /// nodes may be missed.
    pub fn step<T: Scalar, M: Bristle<T, Deflection = T>>(
        self,
        contact: &Contact<T, M>,
        velocity: impl Fn(T) -> T,
        deflection: T,
        duration: T,
    ) -> StepSummary<T> {
        let (zero, one) = (T::zero(), T::one());
        let mut total = StepSummary { deflection, end: zero, mean: zero, work: zero };
        let mut branch = Branch::locked(velocity(zero));
        let mut start = zero;
        for _ in 0..if duration >= zero { MOST_PARTS } else { 0 } {
            let search = |branch: Branch, end: T| {
                let ahead = |place| branch.of(velocity(place)).speed();
                let places = places::<T, S>((start, end));
                crossing(ahead, (start, ahead(start)), (places, places.map(ahead)), zero)
            };
            let mut found = search(branch, one);
            if found == Crossing::AtStart {
                branch = branch.reversed();
                found = search(branch, one);
            }
            let mut end = one;
            // A shorter step shows more.
            for _ in 0..MOST_SEARCHES {
                match found {
                    Crossing::At(place) if place < end => end = place,
                    _ => break,
                }
                found = search(branch, end);
            }
            let span = (start, end);
            let part =
                smooth::<T, M, _, S>(contact, branch, &velocity, span, duration, total.deflection);
            total = total.then(part.summary(), end - start);
            if !(end < one) {
                return total;
            }
            branch = branch.reversed();
            start = end;
        }
        // Not the velocity of a body: it reverses without end.
        StepSummary::unknown()
    }

    /// Steps chosen so that the error of each stays below a tolerance, as a part of the deflection
    /// at breakaway.
    ///
    /// # Errors
    ///
    /// Refuses a tolerance that is not positive.
    pub fn adaptive<T: Scalar>(self, tolerance: T) -> Checked<CollocationSolver<T, S>> {
        let tolerance = Some(Named("tolerance", tolerance).positive()?);
        Ok(CollocationSolver { control: StepControl::adaptive(), tolerance })
    }

    /// Steps of a fixed length \[s\], each split at reversals and where the velocity is not smooth.
    ///
    /// # Errors
    ///
    /// Refuses a step that is not positive.
    pub fn fixed<T: Scalar>(self, step: T) -> Checked<CollocationSolver<T, S>> {
        Ok(CollocationSolver { control: StepControl::fixed(step)?, tolerance: None })
    }
}

/// The nodes between two times.
#[inline(always)]
fn places<T: Scalar, const S: usize>((start, end): (T, T)) -> [T; S] {
    let mut places = [end; S];
    for (place, part) in places.iter_mut().zip(Nodes::<S>::OF.places) {
        if part < 1.0 {
            *place = start + (end - start) * lit(part);
        }
    }
    places
}

/// Where the direction first reverses, from the speed at the start and at the nodes of a step.
#[inline]
fn crossing<T: Scalar, const S: usize>(
    ahead: impl Fn(T) -> T,
    start: (T, T),
    (places, speeds): ([T; S], [T; S]),
    shortest: T,
) -> Crossing<T> {
    // After a reversal the start lies on the wrong side by a rounding.
    let mut known = [(start.0, start.1.larger(T::zero())); MOST_NODES + 1];
    for ((known, place), speed) in known.iter_mut().skip(1).zip(places).zip(speeds) {
        *known = (place, speed);
    }
    let search = Search { forgiven: T::zero(), tolerance: T::zero(), shortest };
    search.first(ahead, known.get(..=S).unwrap_or(&[]))
}

/// The solution over a part of a step without a reversal inside.
#[inline(always)]
fn smooth<T: Scalar, M: Bristle<T, Deflection = T>, V: Fn(T) -> T, const S: usize>(
    contact: &Contact<T, M>,
    branch: Branch,
    velocity: V,
    span: (T, T),
    duration: T,
    deflection: T,
) -> DenseStep<T, S> {
    let places = places::<T, S>(span);
    let sample = |place| Sample::new(contact, branch, velocity(place), deflection);
    let mut samples = [sample(span.1); S];
    for (sample_at, place) in samples.iter_mut().zip(places).take(S - 1) {
        *sample_at = sample(place);
    }
    // The dense output, which needs the start, is not asked for here.
    let times = (T::zero(), (span.1 - span.0) * duration);
    DenseStep::new(times, contact.reference_load(), deflection, &samples[0], &samples)
}
