//! A bristle dragged at a known velocity.

use alloc::vec::Vec;

use super::scene::{Clock, Level, Plan, Run, Scene, Start, direction};
use super::{FidelityError, Reducible, cost};
use crate::bounds::larger;
use crate::parameter::{self, ParameterError};
use crate::rheology::Deflection;
use crate::root::enclose;
use crate::scalar::{is_zero, lit, to_f64};
use crate::signal::Signal;
use crate::{Bristle, Contact, Dahl, DahlParameters, Scalar};

impl Level {
    /// F = p μ(v) sgn v: no memory.
    pub const STATIC_CURVE: Self = Self::memoryless("static curve");
    /// A bristle under a constant friction coefficient, the mean of μ over the scene; each step
    /// exact at the velocity in its middle.
    pub const DAHL: Self = Self::stepped("Dahl", "exact hold");
    /// The model of one spring below the reference ([`Reducible::lumped`]), in such steps.
    pub const LUMPED: Self = Self::stepped("lumped FrBD", "exact hold");
    /// The scene's own model; each step exact at the velocity in its middle ([`Bristle::hold`]).
    pub const REFERENCE: Self = Self::stepped("reference", "exact hold");
}

/// Parameters of [`KnownVelocity`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownVelocityParameters<T, M, V> {
    /// The reference model under its normal force.
    pub contact: Contact<T, M>,
    /// Sliding velocity v(t) [m/s], from t = 0 on.
    pub velocity: V,
    /// Time between two answers Δ \[s\]: the friction force is wanted at Δ, 2Δ, …
    pub interval: T,
    /// Number of answers, up to a million.
    pub answers: usize,
    /// How the bristle begins.
    pub start: Start,
}

/// The friction force at equal intervals along a known sliding velocity.
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::fidelity::{KnownVelocity, KnownVelocityParameters};
/// use bristle::fidelity::{Level, Start, Tolerance, choose};
/// use bristle::rheology::KelvinVoigt;
/// use bristle::signal::{Sine, SineParameters};
/// use bristle::{Bristle, FrBd, paper};
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let friction = FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?);
/// let scene = |mean, amplitude| {
///     let velocity = SineParameters { mean, amplitude, frequency: 1.0, phase: 0.0 };
///     KnownVelocity::new(KnownVelocityParameters {
///         contact: friction.under_load(1.0)?,
///         velocity: Sine::new(velocity)?,
///         interval: 0.01_f64,
///         answers: 1000,
///         start: Start::Steady,
///     })
/// };
/// let tolerance = Tolerance::at_every_answer(0.015); // N, 1 % of breakaway
/// // Where it slides on the bristle follows the curve. In pre-sliding it is a spring.
/// assert_eq!(choose(&scene(0.03, 0.02)?, tolerance)?.plan.level, Level::STATIC_CURVE);
/// assert_eq!(choose(&scene(0.0, 1e-4)?, tolerance)?.plan.level, Level::DAHL);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct KnownVelocity<T: Scalar, M: Reducible<T>, V> {
    contact: Contact<T, M>,
    lumped: Contact<T, M::Lumped>,
    dahl: Contact<T, Dahl<T>>,
    velocity: V,
    clock: Clock<T>,
    start: Start,
}

impl<T: Scalar, M: Reducible<T>, V: Signal<T>> KnownVelocity<T, M, V> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses an interval or a normal force that is not positive, no answers or more than a
    /// million, a velocity that is not finite at an answer, and a model whose lumped one is out of
    /// range.
    pub fn new(parameters: KnownVelocityParameters<T, M, V>) -> Result<Self, ParameterError> {
        let KnownVelocityParameters { contact, velocity, interval, answers, start } = parameters;
        let clock = Clock::new(interval, answers)?;
        let normal_force = parameter::positive("normal_force", contact.normal_force())?;
        // How fast the velocity changes: its root-mean-square rate over that of itself.
        let (mut rates, mut squares) = (T::zero(), T::zero());
        let mut last = parameter::finite("velocity", velocity.value(T::zero()))?;
        for (index, time) in clock.times().enumerate() {
            let checked = parameter::finite("velocity", velocity.value(time));
            let now = parameter::component(index + 1, checked)?;
            rates += (now - last) * (now - last);
            squares += now * now;
            last = now;
        }
        let frequency =
            if is_zero(squares) { squares } else { (rates / squares).sqrt() / interval };
        let lumped = contact.model().lumped(larger(frequency, T::one() / clock.time(answers)))?;
        let mean = clock.times().fold(T::zero(), |sum, time| {
            // The curve beside v = 0, where it has no sign and is 0.
            let now = velocity.value(time);
            let now = if is_zero(now) { T::default_epsilon() } else { now };
            sum + lumped.stationary_coefficient(now).abs() / lit(answers as f64)
        });
        let dahl = Dahl::new(DahlParameters {
            dynamic_coefficient: mean,
            micro_stiffness: lumped.storage_stiffness(),
        })?;
        let (dahl, lumped) = (dahl.under_load(normal_force)?, lumped.under_load(normal_force)?);
        Ok(Self { contact, lumped, dahl, velocity, clock, start })
    }

    fn static_curve(&self) -> Run {
        let mut run = Run::default();
        for time in self.clock.times() {
            run.answers.push(to_f64(self.contact.stationary_force(self.velocity.value(time))));
            run.count(1, cost::CURVE);
        }
        run
    }

    /// The first time between two at which the velocity is not smooth or reverses: a step of a held
    /// velocity knows one direction only.
    fn next_kink(&self, from: T, to: T) -> Option<T> {
        let kink = self.velocity.next_kink(from, to);
        let end = kink.unwrap_or(to);
        // Beside the ends, where the velocity may jump or be zero.
        let beside = (end - from) * lit(1e-8);
        let ends = [from + beside, end - beside].map(|time| (time, self.velocity.value(time)));
        let [(_, first), (_, last)] = ends;
        let reverses =
            first < T::zero() && last > T::zero() || first > T::zero() && last < T::zero();
        if !reverses {
            return kink;
        }
        Some(enclose(|time| self.velocity.value(time), ends[0], ends[1], beside).1)
    }

    fn hold<N: Bristle<T>>(
        &self,
        contact: &Contact<T, N>,
        steps: u32,
        costs: (f64, f64),
    ) -> Result<Run, FidelityError> {
        let mut z = match self.start {
            Start::Undeflected => N::Deflection::fill(T::zero()),
            Start::Steady => contact.stationary(self.velocity.value(T::zero())),
        };
        let (mut run, mut last) = (Run::default(), T::zero());
        for time in self.clock.times() {
            let kink = |from, to| self.next_kink(from, to);
            Clock::each_step((last, time), steps, kink, |step, look| {
                z = contact.model().hold(self.velocity.value(look), z, step).deflection;
                run.count(1, costs.0);
                Ok(())
            })?;
            run.answers.push(to_f64(contact.force(self.velocity.value(time), z)));
            run.count(1, costs.1);
            last = time;
        }
        Ok(run)
    }
}

impl<T: Scalar, M: Reducible<T>, V: Signal<T>> Scene for KnownVelocity<T, M, V> {
    fn levels(&self) -> Vec<Level> {
        let mut levels = alloc::vec![Level::STATIC_CURVE, Level::DAHL];
        if !self.contact.model().is_lumped() {
            levels.push(Level::LUMPED);
        }
        levels.push(Level::REFERENCE);
        levels
    }

    fn interval(&self) -> f64 {
        to_f64(self.clock.interval)
    }

    fn run(&self, plan: &Plan) -> Result<Run, FidelityError> {
        let steps = plan.checked(&self.levels())?;
        match plan.level {
            Level::STATIC_CURVE => Ok(self.static_curve()),
            Level::DAHL => self.hold(&self.dahl, steps, (cost::DAHL_HOLD, 0.0)),
            Level::LUMPED => self.hold(&self.lumped, steps, (cost::HOLD, cost::FORCE)),
            _ => self.hold(&self.contact, steps, M::COSTS),
        }
    }

    /// Of the static curve the lag: the change of the steady deflection in one relaxation time, in
    /// breakaway distances, 2 where the velocity reverses. Of Dahl the pre-sliding share: the
    /// breakaway distance over the longest way in one direction, at most 1. Of the others the share
    /// of the time that the bristle is stuck: since it last reversed it has slid less than that.
    fn physics(&self, plan: &Plan) -> Option<(&'static str, f64)> {
        let model = self.lumped.model();
        let breakaway = to_f64(model.limits(T::zero()).deflection?);
        let dt = self.interval();
        let mut last = self.velocity.value(T::zero());
        let (mut lag, mut way, mut longest, mut stuck) = (0.0_f64, 0.0_f64, 0.0_f64, 0_u32);
        for now in self.clock.times().map(|time| self.velocity.value(time)) {
            let rate = to_f64(model.stationary(now) - model.stationary(last)).abs() / dt;
            let relaxation = to_f64(model.affine(direction(now).of(now), T::zero()).relaxation);
            let reversed = direction(now) != direction(last);
            let here = if reversed { 2.0 } else { rate / (relaxation * breakaway) };
            lag = if here <= lag { lag } else { here.min(2.0) };
            way = if reversed { 0.0 } else { way } + dt * to_f64(now).abs();
            longest = longest.max(way);
            stuck += u32::from(way < breakaway);
            last = now;
        }
        Some(match plan.level {
            Level::STATIC_CURVE => ("lag", lag),
            Level::DAHL => ("presliding", (breakaway / longest).min(1.0)),
            _ => ("stuck", f64::from(stuck) / self.clock.answers as f64),
        })
    }
}
