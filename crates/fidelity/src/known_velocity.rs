//! A bristle dragged at a known velocity.

use alloc::vec::Vec;

use super::scene::{Answers, Level, Run, Scene, check_run, direction, each_step};
use super::{FidelityError, Reducible, cost};
use bristle::parameter::{self, ParameterError};
use bristle::rheology::Deflection;
use bristle::root::enclose;
use bristle::scalar::{is_zero, larger, lit, to_f64};
use bristle::signal::Signal;
use bristle::{Bristle, Contact, Dahl, DahlParameters, Scalar};

impl Level {
    /// F = p μ(v) sgn v: no memory.
    pub const STATIC_CURVE: Self = Self { model: "static curve", method: None };
    /// A bristle under a constant friction coefficient, the mean of μ over the scene; each step
    /// exact at the velocity in its middle.
    pub const DAHL: Self = Self { model: "Dahl", method: Some("exact hold") };
    /// The model of one spring below the reference ([`Reducible::lumped`]), in such steps.
    pub const LUMPED: Self = Self { model: "lumped FrBD", method: Some("exact hold") };
    /// The scene's own model; each step exact at the velocity in its middle ([`Bristle::hold`]).
    pub const REFERENCE: Self = Self { model: "reference", method: Some("exact hold") };
}

/// The friction force at equal intervals along a known sliding velocity.
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle_fidelity::{Answers, KnownVelocity, Level, Tolerance, choose};
/// use bristle::rheology::KelvinVoigt;
/// use bristle::signal::{Sine, SineParameters};
/// use bristle::{Bristle, FrBd, ParameterError, paper};
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let friction = FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?);
/// let scene = |mean, amplitude| -> Result<_, ParameterError> {
///     let velocity = Sine::new(SineParameters { mean, amplitude, frequency: 1.0, phase: 0.0 })?;
///     let answers = Answers { interval: 0.01_f64, count: 1000 };
///     let scene = KnownVelocity::new(friction.under_load(1.0)?, velocity, answers)?;
///     Ok(scene.starting_steadily())
/// };
/// let tolerance = Tolerance::at_every_answer(0.015); // N, 1 % of breakaway
/// // Where it slides on the bristle follows the curve. In pre-sliding it is a spring.
/// assert_eq!(choose(&scene(0.03, 0.02)?, tolerance)?.best.level, Level::STATIC_CURVE);
/// assert_eq!(choose(&scene(0.0, 1e-4)?, tolerance)?.best.level, Level::DAHL);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct KnownVelocity<T: Scalar, M: Reducible<T>, V> {
    contact: Contact<T, M>,
    lumped: Contact<T, M::Lumped>,
    dahl: Contact<T, Dahl<T>>,
    velocity: V,
    answers: Answers<T>,
    steady: bool,
}

impl<T: Scalar, M: Reducible<T>, V: Signal<T>> KnownVelocity<T, M, V> {
    /// The force of a contact, which is the reference, along a velocity v(t) [m/s] from t = 0 on.
    /// The bristle starts undeflected.
    ///
    /// # Errors
    ///
    /// Refuses an interval or a normal force that is not positive, no answers or more than a
    /// million, a velocity that is not finite at an answer, and a model whose lumped one is out of
    /// range.
    pub fn new(
        contact: Contact<T, M>,
        velocity: V,
        answers: Answers<T>,
    ) -> Result<Self, ParameterError> {
        let answers = answers.checked()?;
        let normal_force = parameter::positive("normal_force", contact.normal_force())?;
        // How fast the velocity changes: its root-mean-square rate over that of itself.
        let (mut rates, mut squares) = (T::zero(), T::zero());
        let mut last = parameter::finite("velocity", velocity.value(T::zero()))?;
        for (index, time) in answers.times().enumerate() {
            let checked = parameter::finite("velocity", velocity.value(time));
            let now = parameter::component(index + 1, checked)?;
            rates += (now - last) * (now - last);
            squares += now * now;
            last = now;
        }
        let frequency =
            if is_zero(squares) { squares } else { (rates / squares).sqrt() / answers.interval };
        let lumped =
            contact.model().lumped(larger(frequency, T::one() / answers.time(answers.count)))?;
        let mean = answers.times().fold(T::zero(), |sum, time| {
            // The curve beside v = 0, where it has no sign and is 0.
            let now = velocity.value(time);
            let now = if is_zero(now) { T::default_epsilon() } else { now };
            sum + lumped.stationary_coefficient(now).abs() / lit(answers.count as f64)
        });
        let dahl = Dahl::new(DahlParameters {
            dynamic_coefficient: mean,
            micro_stiffness: lumped.storage_stiffness(),
        })?;
        let (dahl, lumped) = (dahl.under_load(normal_force)?, lumped.under_load(normal_force)?);
        Ok(Self { contact, lumped, dahl, velocity, answers, steady: false })
    }

    /// Starts as in steady sliding at the first velocity.
    #[must_use]
    pub fn starting_steadily(self) -> Self {
        Self { steady: true, ..self }
    }

    fn static_curve(&self) -> Run {
        let mut run = Run::default();
        for time in self.answers.times() {
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
    ) -> Result<Run, ParameterError> {
        let mut z = if self.steady {
            contact.stationary(self.velocity.value(T::zero()))
        } else {
            N::Deflection::fill(T::zero())
        };
        let mut run = Run::default();
        for span in self.answers.spans() {
            for (step, look, _) in each_step(span, steps, |from, to| self.next_kink(from, to)) {
                let velocity = parameter::finite("velocity", self.velocity.value(look))?;
                z = contact.model().hold(velocity, z, step).deflection;
                run.count(1, costs.0);
            }
            run.answers.push(to_f64(contact.force(self.velocity.value(span.1), z)));
            run.count(1, costs.1);
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
        to_f64(self.answers.interval)
    }

    fn run(&self, level: Level, steps: u32) -> Result<Run, FidelityError> {
        check_run(&self.levels(), level, steps)?;
        let run = match level {
            Level::STATIC_CURVE => return Ok(self.static_curve()),
            Level::DAHL => self.hold(&self.dahl, steps, (cost::DAHL_HOLD, 0.0)),
            Level::LUMPED => self.hold(&self.lumped, steps, (cost::HOLD, cost::FORCE)),
            _ => self.hold(&self.contact, steps, self.contact.model().costs()),
        };
        Ok(run?)
    }

    /// Of the static curve the lag: the change of the steady deflection in one relaxation time, in
    /// breakaway distances, 2 where the velocity reverses. Of Dahl the pre-sliding share: the
    /// breakaway distance over the longest way in one direction, at most 1. Of the others the share
    /// of the time that the bristle is stuck: since it last reversed it has slid less than that.
    fn physics(&self, level: Level, _: u32) -> Option<(&'static str, f64)> {
        let model = self.lumped.model();
        let breakaway = to_f64(model.limits(T::zero()).deflection?);
        let dt = self.interval();
        let mut last = self.velocity.value(T::zero());
        let (mut lag, mut way, mut longest, mut stuck) = (0.0_f64, 0.0_f64, 0.0_f64, 0_u32);
        for now in self.answers.times().map(|time| self.velocity.value(time)) {
            let rate = to_f64(model.stationary(now) - model.stationary(last)).abs() / dt;
            let relaxation =
                to_f64(model.affine(direction(now).of(now).into(), T::zero()).relaxation);
            let reversed = direction(now) != direction(last);
            let here = if reversed { 2.0 } else { rate / (relaxation * breakaway) };
            lag = if here <= lag { lag } else { here.min(2.0) };
            way = if reversed { 0.0 } else { way } + dt * to_f64(now).abs();
            longest = longest.max(way);
            stuck += u32::from(way < breakaway);
            last = now;
        }
        Some(match level {
            Level::STATIC_CURVE => ("lag", lag),
            Level::DAHL => ("presliding", (breakaway / longest).min(1.0)),
            _ => ("stuck", f64::from(stuck) / self.answers.count as f64),
        })
    }
}
