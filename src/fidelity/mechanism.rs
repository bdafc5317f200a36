//! A mass with a spring and a damper under friction, drive and force.

use alloc::vec::Vec;
use core::ops::ControlFlow;

use nalgebra::Vector3;

use super::scene::{Clock, Level, Plan, Quantity, Refinement, Run, Scene, Start};
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
pub struct MechanismSceneParameters<T, M, F> {
    /// The mechanism with the reference model. A spring whose far end does not move steadily, but
    /// by y(t), is one with V = 0 under the force k y(t).
    pub system: MassSpringDamper<T, M, F>,
    /// Position at the start \[m\].
    pub position: T,
    /// Velocity at the start [m/s].
    pub velocity: T,
    /// How the bristle begins.
    pub start: Start,
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
///     Level, MechanismScene, MechanismSceneParameters, Quantity, Scene, Start, Tolerance, choose,
/// };
/// use bristle::rheology::KelvinVoigt;
/// use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
/// use bristle::signal::Constant;
/// use bristle::{Bristle, FrBd, Mechanism, paper};
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let friction = FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?);
/// let scene = MechanismScene::new(MechanismSceneParameters {
///     system: MassSpringDamper::new(MassSpringDamperParameters {
///         contact: friction.under_load(1.0)?,
///         mechanism: Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.0 },
///         drive_velocity: 0.1,
///         force: Constant::zero(),
///     })?,
///     position: 0.0,
///     velocity: 0.0,
///     start: Start::Undeflected,
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
    position: T,
    velocity: T,
    start: Start,
    clock: Clock<T>,
    quantity: Quantity,
}

/// The mass at an answer.
#[derive(Debug, Clone, Copy)]
struct Sample<T> {
    position: T,
    velocity: T,
    force: T,
}

/// A step of the mass: (2m/h + kh/2 + c) v̄ = 2m v₀/h + f + k (V t − x₀) − F̄ for its mean velocity
/// v̄ = (v₀ + v₁)/2, with f and V t in its middle.
struct MassStep<T> {
    resistance: T,
    push: T,
}

impl<T, M, F> MechanismScene<T, M, F>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    F: Signal<T>,
{
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses an interval or a breakaway force that is not positive, no answers or more than a
    /// million, and a position, a velocity or a force at an answer that is not finite.
    pub fn new(parameters: MechanismSceneParameters<T, M, F>) -> Result<Self, ParameterError> {
        let MechanismSceneParameters {
            system,
            position,
            velocity,
            start,
            interval,
            answers,
            quantity,
        } = parameters;
        let clock = Clock::new(interval, answers)?;
        let contact = system.contact();
        let normal_force = parameter::positive("normal_force", contact.normal_force())?;
        let micro_stiffness = contact.model().storage_stiffness();
        let deflection = contact.model().limits(T::zero()).deflection.unwrap_or_else(T::zero);
        let breakaway = normal_force * micro_stiffness * deflection;
        let breakaway = parameter::positive("breakaway force", breakaway)?;
        let dynamic_coefficient = breakaway / normal_force;
        let dahl = Dahl::new(DahlParameters { dynamic_coefficient, micro_stiffness })?;
        for answer in 0..=answers {
            let force = parameter::finite("force", system.force().value(clock.time(answer)));
            parameter::component(answer, force)?;
        }
        Ok(Self {
            dahl: dahl.under_load(normal_force)?,
            system,
            breakaway,
            position: parameter::finite("position", position)?,
            velocity: parameter::finite("velocity", velocity)?,
            start,
            clock,
            quantity,
        })
    }

    fn mass_step(&self, step: T, look: T, position: T, velocity: T) -> MassStep<T> {
        let mechanism = self.system.mechanism();
        let half = lit::<T>(0.5);
        let inertia = mechanism.mass * lit(2.0) / step;
        MassStep {
            resistance: inertia
                + mechanism.spring_stiffness * step * half
                + mechanism.viscous_damping,
            push: inertia * velocity + self.applied(look, position),
        }
    }

    /// f + k (V t − x) \[N\].
    fn applied(&self, time: T, position: T) -> T {
        let state = Vector3::new(position, T::zero(), T::zero());
        self.system.force().value(time) + self.system.spring_force(time, &state)
    }

    /// The friction curve with true rest. A step ends at rest (v₁ = 0, v̄ = v₀/2) if the F̄ that this
    /// takes is no more than p μ_s. Else it slides the way of that force, F̄ that of the curve at the
    /// extrapolated velocity.
    fn slide(&self, steps: u32, run: &mut Run) -> Vec<Sample<T>> {
        let contact = self.system.contact();
        let (mut position, mut velocity) = (self.position, self.velocity);
        let mut history = VelocityHistory::new(velocity);
        let mut samples = Vec::new();
        for answer in 1..=self.clock.answers {
            let next_kink = |from, to| self.system.force().next_kink(from, to);
            Clock::each_step(self.clock.span(answer), steps, next_kink, |from, to, look| {
                let MassStep { resistance, push } =
                    self.mass_step(to - from, look, position, velocity);
                let to_rest = velocity * lit(0.5);
                let stopping = push - resistance * to_rest;
                let mut mean = to_rest;
                if stopping.abs() > self.breakaway {
                    let way = if stopping > T::zero() { T::one() } else { -T::one() };
                    let predicted = history.predict();
                    let mut friction = way * self.breakaway;
                    if predicted * way > T::zero() {
                        friction = contact.stationary_force(predicted);
                        run.count(1, cost::CURVE);
                    }
                    let sliding = (push - friction) / resistance;
                    // It does not slide on past rest.
                    if (sliding - to_rest) * way > T::zero() {
                        mean = sliding;
                    }
                }
                position += mean * (to - from);
                velocity = lit::<T>(2.0) * mean - velocity;
                history.push(velocity);
                run.count(0, 0.0);
                run.cost += cost::SLIDE;
            });
            let force = if is_zero(velocity) {
                let balance = self.applied(self.clock.time(answer), position);
                larger(smaller(balance, self.breakaway), -self.breakaway)
            } else {
                run.count(1, cost::CURVE);
                contact.stationary_force(velocity)
            };
            samples.push(Sample { position, velocity, force });
        }
        samples
    }

    /// Passive steps, each solved once.
    fn companion<N: Bristle<T, Deflection = T>>(
        &self,
        contact: &Contact<T, N>,
        steps: u32,
        cost_of_step: f64,
        run: &mut Run,
    ) -> Result<Vec<Sample<T>>, FidelityError> {
        let companion = contact.clone().companion(T::zero())?;
        let (mut position, mut velocity) = (self.position, self.velocity);
        let mut deflection = self.initial(contact);
        let mut history = VelocityHistory::new(velocity);
        let mut samples = Vec::new();
        for answer in 1..=self.clock.answers {
            let next_kink = |from, to| self.system.force().next_kink(from, to);
            Clock::each_step(self.clock.span(answer), steps, next_kink, |from, to, look| {
                let MassStep { resistance, push } =
                    self.mass_step(to - from, look, position, velocity);
                let step = companion.step(history.predict(), deflection, to - from);
                let mean = (push - step.bias()) / (resistance + step.damping());
                position += mean * (to - from);
                velocity = lit::<T>(2.0) * mean - velocity;
                deflection = step.commit(mean).deflection;
                history.push(velocity);
                run.count(1, cost_of_step);
            });
            samples.push(self.sample(contact, Vector3::new(position, velocity, deflection), run));
        }
        Ok(samples)
    }

    fn initial<N: Bristle<T, Deflection = T>>(&self, contact: &Contact<T, N>) -> T {
        match self.start {
            Start::Undeflected => T::zero(),
            Start::Steady => contact.stationary(self.velocity),
        }
    }

    fn sample<N: Bristle<T, Deflection = T>>(
        &self,
        contact: &Contact<T, N>,
        state: Vector3<T>,
        run: &mut Run,
    ) -> Sample<T> {
        let [position, velocity, deflection] = state.into();
        let mut force = T::zero();
        if self.quantity == Quantity::Force {
            force = contact.force(velocity, deflection);
            run.count(1, cost::FORCE);
        }
        Sample { position, velocity, force }
    }

    /// Error control. Steps are no longer than the time between 4/n answers, so that no force is
    /// stepped over when n is doubled.
    fn controlled(&self, plan: &Plan, run: &mut Run) -> Result<Vec<Sample<T>>, FidelityError> {
        let contact = self.system.contact();
        // Tighter than this error control sees nothing but roundings.
        let tolerance = larger(lit(plan.error_control()), T::default_epsilon() * lit(64.0));
        let largest = self.clock.interval * lit(4.0 / f64::from(plan.steps));
        let solver = Solver::automatic(tolerance, self.system.scales())?
            .with_largest_step(largest)?
            .with_most_steps(MOST_CONTROLLED_STEPS);
        let start = Vector3::new(self.position, self.velocity, self.initial(contact));
        let end = self.clock.time(self.clock.answers);
        let mut samples = Vec::new();
        let mut observe = |step: &Step<T, 3>| {
            let mut next = self.clock.time(samples.len() + 1);
            while samples.len() < self.clock.answers && next <= step.end_time() {
                samples.push(self.sample(contact, step.at(next), run));
                next = self.clock.time(samples.len() + 1);
            }
            ControlFlow::Continue(())
        };
        let summary = solver
            .stream(&self.system, T::zero()..end, start, &[], &mut observe)
            .map_err(|failure| FidelityError::Stopped {
                level: plan.level,
                time: to_f64(failure.time),
                reason: failure.reason,
            })?;
        run.count(summary.statistics.evaluations, cost::STAGE);
        run.count(summary.statistics.jacobians, cost::JACOBIAN);
        Ok(samples)
    }

    fn motion(&self, plan: &Plan, run: &mut Run) -> Result<Vec<Sample<T>>, FidelityError> {
        let steps = plan.checked(&self.levels())?;
        match plan.level {
            Level::TRUE_REST => Ok(self.slide(steps, run)),
            Level::DAHL_COMPANION => self.companion(&self.dahl, steps, cost::DAHL_COMPANION, run),
            Level::REFERENCE_COMPANION => {
                self.companion(self.system.contact(), steps, cost::COMPANION, run)
            }
            _ => self.controlled(plan, run),
        }
    }
}

/// Steps of a run under error control at most: some seconds.
const MOST_CONTROLLED_STEPS: u64 = 10_000_000;

impl<T, M, F> Scene for MechanismScene<T, M, F>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    F: Signal<T>,
{
    fn levels(&self) -> Vec<Level> {
        alloc::vec![
            Level::TRUE_REST,
            Level::DAHL_COMPANION,
            Level::REFERENCE_COMPANION,
            Level::REFERENCE_CONTROLLED,
        ]
    }

    fn interval(&self) -> f64 {
        to_f64(self.clock.interval)
    }

    fn quantity(&self) -> Quantity {
        self.quantity
    }

    fn run(&self, plan: &Plan) -> Result<Run, FidelityError> {
        let mut run = Run::default();
        let samples = self.motion(plan, &mut run)?;
        let answers = samples.iter().map(|sample| {
            to_f64(match self.quantity {
                Quantity::Force => sample.force,
                Quantity::Position => sample.position,
                Quantity::Velocity => sample.velocity,
            })
        });
        Ok(Run { answers: answers.collect(), ..run })
    }

    /// Of the static curve the pre-sliding share: the breakaway distance over the range of the
    /// position, at most 1. Of Dahl the drop of the curve from rest to the fastest velocity, over its
    /// value at rest. Of the reference the share of the answers at which the mass is stuck: slower
    /// than a hundredth of its fastest velocity.
    fn physics(&self, plan: &Plan) -> Option<(&'static str, f64)> {
        let samples = self.motion(plan, &mut Run::default()).ok()?;
        let (mut least, mut most, mut fastest) = (self.position, self.position, T::zero());
        for sample in &samples {
            least = smaller(least, sample.position);
            most = larger(most, sample.position);
            fastest = larger(fastest, sample.velocity.abs());
        }
        let part = |a: T, b: T| to_f64(a) / to_f64(b);
        Some(match plan.level {
            Level::TRUE_REST => {
                let distance = self.breakaway / self.dahl.model().storage_stiffness();
                ("presliding", part(distance / self.dahl.normal_force(), most - least).min(1.0))
            }
            Level::DAHL_COMPANION => {
                let sliding = self.system.contact().stationary_force(fastest);
                ("drop", part(self.breakaway - sliding, self.breakaway))
            }
            _ => {
                let slow = |sample: &&Sample<T>| sample.velocity.abs() * lit(100.0) <= fastest;
                ("stuck", samples.iter().filter(slow).count() as f64 / samples.len() as f64)
            }
        })
    }
}
