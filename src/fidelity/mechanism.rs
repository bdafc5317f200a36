//! A mass with a spring and a damper under friction, drive and force.

use alloc::vec::Vec;
use core::ops::ControlFlow;

use nalgebra::Vector3;

use super::scene::{Clock, Level, Plan, Quantity, Refinement, Run, Scene};
use super::{FidelityError, cost};
use crate::bounds::{larger, smaller};
use crate::companion::VelocityHistory;
use crate::ode::{Solver, Step};
use crate::parameter::{self, ParameterError};
use crate::scalar::{is_zero, lit, to_f64};
use crate::scene::MassSpringDamper;
use crate::signal::Signal;
use crate::{Bristle, Contact, Dahl, DahlParameters, Scalar};

impl Level {
    /// The friction curve with true rest: the mass stops where a force up to p μ_s can hold it.
    pub const TRUE_REST: Self = Self::stepped("static curve", "true rest");
    /// A bristle under the coefficient at rest in passive steps ([`companion`](crate::companion)).
    pub const DAHL_COMPANION: Self = Self::stepped("Dahl", "companion");
    /// The scene's own model in passive steps ([`companion`](crate::companion)).
    pub const REFERENCE_COMPANION: Self = Self::stepped("reference", "companion");
    /// The scene's own model under error control ([`Solver::automatic`]).
    pub const REFERENCE_CONTROLLED: Self =
        Self { model: "reference", method: "controlled", refinement: Refinement::ErrorControl };
}

/// Parameters of [`MechanismScene`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MechanismSceneParameters<T: Scalar, M, F> {
    /// The mechanism with the reference model. A spring whose far end does not move steadily, but
    /// by y(t), is one with V = 0 under the force k y(t).
    pub system: MassSpringDamper<T, M, F>,
    /// Position \[m\], velocity [m/s] and deflection \[m\] at the start.
    pub start: Vector3<T>,
    /// Time between two answers Δ \[s\]: they are wanted at Δ, 2Δ, …
    pub interval: T,
    /// Number of answers, up to a million.
    pub answers: usize,
    /// What is wanted.
    pub quantity: Quantity,
}

/// Position, velocity or friction force at equal intervals of a mass on a spring. The stick-slip
/// rig of the paper:
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::fidelity::{
///     MechanismScene, MechanismSceneParameters, Quantity, Scene, Tolerance, choose,
/// };
/// use bristle::rheology::KelvinVoigt;
/// use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
/// use bristle::signal::Constant;
/// use bristle::{Bristle, FrBd, Mechanism, paper};
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let friction = FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?);
/// let system = MassSpringDamper::new(MassSpringDamperParameters {
///     contact: friction.under_load(1.0)?,
///     mechanism: Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.0 },
///     drive_velocity: 0.1,
///     force: Constant::zero(),
/// })?;
/// let scene = MechanismScene::new(MechanismSceneParameters {
///     start: system.at_rest(),
///     system,
///     interval: 0.1_f64,
///     answers: 200,
///     quantity: Quantity::Position,
/// })?;
/// let choice = choose(&scene, Tolerance::at_every_answer(7.5e-3))?; // m, 1 % of the stretch
/// assert_eq!(choice.plan.level.model, "reference"); // others drift apart from slip to slip
/// assert_eq!(scene.run(&choice.plan)?.evaluations, choice.evaluations);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct MechanismScene<T: Scalar, M, F> {
    system: MassSpringDamper<T, M, F>,
    dahl: Contact<T, Dahl<T>>,
    /// p μ_s \[N\].
    breakaway: T,
    start: Vector3<T>,
    clock: Clock<T>,
    quantity: Quantity,
}

/// Position, velocity and deflection at an answer, and the friction force.
type Sample<T> = (Vector3<T>, T);

/// A step of the mass for its mean velocity v̄ = (v₀ + v₁)/2: resistance · v̄ = push − F̄.
struct MassStep<T> {
    duration: T,
    resistance: T,
    push: T,
    /// The velocity in its middle, extrapolated.
    predicted: T,
}

impl<T: Scalar, M: Bristle<T, Deflection = T>, F: Signal<T>> MechanismScene<T, M, F> {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses an interval or a breakaway force that is not positive, no answers or more than a
    /// million, and a start that is not finite.
    pub fn new(parameters: MechanismSceneParameters<T, M, F>) -> Result<Self, ParameterError> {
        let MechanismSceneParameters { system, start, interval, answers, quantity } = parameters;
        for (index, &state) in start.iter().enumerate() {
            parameter::component(index, parameter::finite("start", state))?;
        }
        let contact = system.contact();
        let normal_force = parameter::positive("normal_force", contact.normal_force())?;
        let micro_stiffness = contact.model().storage_stiffness();
        let deflection = contact.model().limits(T::zero()).deflection.unwrap_or_else(T::zero);
        let breakaway =
            parameter::positive("breakaway force", normal_force * micro_stiffness * deflection)?;
        let dynamic_coefficient = breakaway / normal_force;
        let dahl = Dahl::new(DahlParameters { dynamic_coefficient, micro_stiffness })?;
        let dahl = dahl.under_load(normal_force)?;
        let clock = Clock::new(interval, answers)?;
        Ok(Self { system, dahl, breakaway, start, clock, quantity })
    }

    /// f + k (V t − x) \[N\].
    fn applied(&self, time: T, state: &Vector3<T>) -> T {
        self.system.force().value(time) + self.system.spring_force(time, state)
    }

    /// Steps of the mass, (2m/h + kh/2 + c) v̄ = 2m v₀/h + f + k (V t − x₀) − F̄ with f and V t in
    /// the middle of each, under a friction that answers v̄, and at an answer the force.
    fn stepped(
        &self,
        steps: u32,
        run: &mut Run,
        mut mean_velocity: impl FnMut(&MassStep<T>, &mut Vector3<T>, &mut Run) -> T,
        force: impl Fn(T, &Vector3<T>, &mut Run) -> T,
    ) -> Result<Vec<Sample<T>>, FidelityError> {
        let mechanism = self.system.mechanism();
        let (mut state, mut samples, mut last) = (self.start, Vec::new(), T::zero());
        let mut history = VelocityHistory::new(state[1]);
        let next_kink = |from, to| self.system.force().next_kink(from, to);
        for time in self.clock.times() {
            Clock::each_step((last, time), steps, next_kink, |duration, look| {
                let inertia = mechanism.mass * lit(2.0) / duration;
                let spring = mechanism.spring_stiffness * duration * lit(0.5);
                let resistance = inertia + spring + mechanism.viscous_damping;
                let push = inertia * state[1] + self.applied(look, &state);
                let step = MassStep { duration, resistance, push, predicted: history.predict() };
                let mean = mean_velocity(&step, &mut state, run);
                state[0] += mean * duration;
                state[1] = lit::<T>(2.0) * mean - state[1];
                history.push(state[1]);
                Ok(())
            })?;
            samples.push((state, force(time, &state, run)));
            last = time;
        }
        Ok(samples)
    }

    /// The friction curve with true rest. A step ends at rest (v₁ = 0, v̄ = v₀/2) if the F̄ that
    /// this takes is no more than p μ_s. Else it slides the way of that force, F̄ that of the curve
    /// at the extrapolated velocity.
    fn slide(&self, steps: u32, run: &mut Run) -> Result<Vec<Sample<T>>, FidelityError> {
        let curve = |velocity, run: &mut Run| {
            run.count(1, cost::CURVE);
            self.system.contact().stationary_force(velocity)
        };
        let mean_velocity = |step: &MassStep<T>, state: &mut Vector3<T>, run: &mut Run| {
            run.cost += cost::SLIDE;
            let to_rest = state[1] * lit(0.5);
            let stopping = step.push - step.resistance * to_rest;
            if !(stopping.abs() > self.breakaway) {
                return to_rest;
            }
            let way = if stopping > T::zero() { T::one() } else { -T::one() };
            let slides = step.predicted * way > T::zero();
            let friction = if slides { curve(step.predicted, run) } else { way * self.breakaway };
            let mean = (step.push - friction) / step.resistance;
            // It does not slide on past rest.
            if (mean - to_rest) * way > T::zero() { mean } else { to_rest }
        };
        self.stepped(steps, run, mean_velocity, |time, state, run| {
            if is_zero(state[1]) {
                return larger(smaller(self.applied(time, state), self.breakaway), -self.breakaway);
            }
            curve(state[1], run)
        })
    }

    /// Passive steps, each solved once.
    fn companion<N: Bristle<T, Deflection = T>>(
        &self,
        contact: &Contact<T, N>,
        (steps, cost_of_step): (u32, f64),
        run: &mut Run,
    ) -> Result<Vec<Sample<T>>, FidelityError> {
        let companion = contact.clone().companion(T::zero())?;
        let mean_velocity = |step: &MassStep<T>, state: &mut Vector3<T>, run: &mut Run| {
            run.count(1, cost_of_step);
            let friction = companion.step(step.predicted, state[2], step.duration);
            let mean = (step.push - friction.bias()) / (step.resistance + friction.damping());
            state[2] = friction.commit(mean).deflection;
            mean
        };
        self.stepped(steps, run, mean_velocity, |_, state, run| self.force(contact, state, run))
    }

    /// The force of a bristle, if it is wanted.
    fn force<N>(&self, contact: &Contact<T, N>, state: &Vector3<T>, run: &mut Run) -> T
    where
        N: Bristle<T, Deflection = T>,
    {
        if self.quantity != Quantity::Force {
            return T::zero();
        }
        run.count(1, cost::FORCE);
        contact.force(state[1], state[2])
    }

    /// Error control. Steps are no longer than the time between 4/n answers, so that no force is
    /// stepped over when n is doubled.
    fn controlled(&self, plan: &Plan, run: &mut Run) -> Result<Vec<Sample<T>>, FidelityError> {
        // Tighter than this error control sees nothing but roundings.
        let tolerance = larger(lit(plan.error_control()), T::default_epsilon() * lit(64.0));
        let largest = self.clock.interval * lit(4.0 / f64::from(plan.steps));
        let solver = Solver::automatic(tolerance, self.system.scales())?
            .with_largest_step(largest)?
            .with_most_steps(MOST_CONTROLLED_STEPS);
        let end = self.clock.time(self.clock.answers);
        let mut samples = Vec::new();
        let mut times = self.clock.times().peekable();
        let mut observe = |step: &Step<T, 3>| {
            while let Some(time) = times.next_if(|time| *time <= step.end_time()) {
                let state = step.at(time);
                samples.push((state, self.force(self.system.contact(), &state, run)));
            }
            ControlFlow::Continue(())
        };
        let done = solver.stream(&self.system, T::zero()..end, self.start, &[], &mut observe);
        let statistics = done
            .map_err(|failure| FidelityError::Stopped {
                level: plan.level,
                time: to_f64(failure.time),
                reason: failure.reason,
            })?
            .statistics;
        run.count(statistics.evaluations, cost::STAGE);
        run.count(statistics.jacobians, cost::JACOBIAN);
        Ok(samples)
    }

    fn motion(&self, plan: &Plan, run: &mut Run) -> Result<Vec<Sample<T>>, FidelityError> {
        let (steps, reference) = (plan.checked(&self.levels())?, self.system.contact());
        match plan.level {
            Level::TRUE_REST => self.slide(steps, run),
            Level::DAHL_COMPANION => self.companion(&self.dahl, (steps, cost::DAHL_COMPANION), run),
            Level::REFERENCE_COMPANION => self.companion(reference, (steps, cost::COMPANION), run),
            _ => self.controlled(plan, run),
        }
    }
}

/// Steps of a run under error control at most: some seconds.
const MOST_CONTROLLED_STEPS: u64 = 10_000_000;

impl<T: Scalar, M: Bristle<T, Deflection = T>, F: Signal<T>> Scene for MechanismScene<T, M, F> {
    fn levels(&self) -> Vec<Level> {
        let reference = [Level::REFERENCE_COMPANION, Level::REFERENCE_CONTROLLED];
        [Level::TRUE_REST, Level::DAHL_COMPANION].into_iter().chain(reference).collect()
    }

    fn interval(&self) -> f64 {
        to_f64(self.clock.interval)
    }

    fn quantity(&self) -> Quantity {
        self.quantity
    }

    fn run(&self, plan: &Plan) -> Result<Run, FidelityError> {
        let mut run = Run::default();
        let answer = |(state, force): Sample<T>| match self.quantity {
            Quantity::Force => to_f64(force),
            Quantity::Position => to_f64(state[0]),
            Quantity::Velocity => to_f64(state[1]),
        };
        run.answers = self.motion(plan, &mut run)?.into_iter().map(answer).collect();
        Ok(run)
    }

    /// Of the static curve the pre-sliding share: the breakaway distance over the farthest way from
    /// the start, at most 1. Of Dahl the drop of the curve from rest to the fastest velocity, over
    /// its value at rest. Of the reference the share of the answers at which the mass is stuck:
    /// slower than a hundredth of its fastest velocity.
    fn physics(&self, plan: &Plan) -> Option<(&'static str, f64)> {
        let samples = self.motion(plan, &mut Run::default()).ok()?;
        let size = |index: usize| move |(state, _): &Sample<T>| (state[index]).abs();
        let fastest = samples.iter().map(size(1)).fold(T::zero(), larger);
        Some(match plan.level {
            Level::TRUE_REST => {
                let way = |(state, _): &Sample<T>| (state[0] - self.start[0]).abs();
                let farthest = samples.iter().map(way).fold(T::zero(), larger);
                let stiffness = self.dahl.model().storage_stiffness() * self.dahl.normal_force();
                ("presliding", to_f64(self.breakaway / (stiffness * farthest)).min(1.0))
            }
            Level::DAHL_COMPANION => {
                let sliding = self.system.contact().stationary_force(fastest);
                ("drop", to_f64((self.breakaway - sliding) / self.breakaway))
            }
            _ => {
                let stuck = samples.iter().filter(|s| size(1)(s) * lit(100.0) <= fastest).count();
                ("stuck", stuck as f64 / samples.len() as f64)
            }
        })
    }
}
