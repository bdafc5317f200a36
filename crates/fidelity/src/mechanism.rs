//! A mass with a spring and a damper under friction, drive and force.

use alloc::vec::Vec;
use nalgebra::Vector3;

use super::scene::{Answers, Level, Quantity, Run, Scene, check_run, each_step, resolving};
use super::{FidelityError, cost};
use bristle::companion::{PointMass, VelocityHistory};
use bristle::ode::System;
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::scalar::{is_zero, lit, to_f64};
use bristle::scene::MassSpringDamper;
use bristle::signal::Signal;
use bristle::{Bristle, Contact, Dahl, DahlParameters, Scalar};

impl Level {
    /// The friction curve with true rest: the mass stops where a force up to p μ_s can hold it.
    pub const TRUE_REST: Self = Self { model: "static curve", method: Some("true rest") };
    /// A bristle under the coefficient at rest in passive steps
    /// ([`companion`](bristle::companion)).
    pub const DAHL_COMPANION: Self = Self { model: "Dahl", method: Some("companion") };
    /// The scene's own model in passive steps ([`companion`](bristle::companion)).
    pub const REFERENCE_COMPANION: Self = Self { model: "reference", method: Some("companion") };
}

/// Position, velocity or friction force at equal intervals of a mass on a spring. The stick-slip
/// rig of the paper:
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle_fidelity::{Answers, MechanismScene, Quantity, Scene, Tolerance, choose};
/// use bristle::rheology::KelvinVoigt;
/// use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
/// use bristle::{Bristle, FrBd, Mechanism, paper};
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let friction = FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?);
/// let system = MassSpringDamper::new(MassSpringDamperParameters {
///     contact: friction.under_load(1.0)?,
///     mechanism: Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.0 },
///     drive_velocity: 0.1,
///     force: 0.0,
/// })?;
/// let (start, answers) = (system.at_rest(), Answers { interval: 0.1_f64, count: 200 });
/// let scene = MechanismScene::new(system, start, answers, Quantity::Position)?;
/// let choice = choose(&scene, Tolerance::at_every_answer(7.5e-3))?; // m, 1 % of the stretch
/// let best = choice.best;
/// assert_eq!(best.level.model, "reference"); // others drift apart from slip to slip
/// assert_eq!(scene.run(best.level, best.steps)?.evaluations, best.evaluations);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct MechanismScene<T: Scalar, M, F> {
    system: MassSpringDamper<T, M, F>,
    dahl: Contact<T, Dahl<T>>,
    /// p μ_s \[N\].
    breakaway: T,
    start: Vector3<T>,
    answers: Answers<T>,
    quantity: Quantity,
}

/// A run, and position, velocity and deflection at its answers.
type Motion<T> = (Run, Vec<Vector3<T>>);

/// A step of the mass, which carries its spring and its damper.
struct MassStep<T> {
    duration: T,
    body: PointMass<T>,
    /// The velocity in its middle, extrapolated.
    predicted: T,
}

impl<T: Scalar, M: Bristle<T, Deflection = T>, F: Signal<T>> MechanismScene<T, M, F> {
    /// A mechanism with the reference model, from position \[m\], velocity [m/s] and deflection
    /// \[m\] at t = 0 on. A spring whose far end does not move steadily, but by y(t), is one with
    /// V = 0 under the force k y(t).
    ///
    /// # Errors
    ///
    /// Refuses an interval or a breakaway force that is not positive, no answers or more than a
    /// million, and a start that is not finite.
    pub fn new(
        system: MassSpringDamper<T, M, F>,
        start: Vector3<T>,
        answers: Answers<T>,
        quantity: Quantity,
    ) -> Checked<Self> {
        ParameterError::of_components(&start, |&state| Named("start", state).finite())?;
        let contact = &system.parameters().contact;
        let normal_force = Named("normal_force", contact.normal_force()).positive()?;
        let micro_stiffness = contact.model().storage_stiffness();
        let deflection = contact.model().limits(T::zero()).deflection.unwrap_or_else(T::zero);
        let breakaway =
            Named("breakaway force", normal_force * micro_stiffness * deflection).positive()?;
        let dynamic_coefficient = breakaway / normal_force;
        let dahl = Dahl::new(DahlParameters { dynamic_coefficient, micro_stiffness })?;
        let dahl = contact.with_model(dahl);
        let answers = answers.checked()?;
        Ok(Self { system, dahl, breakaway, start, answers, quantity })
    }

    /// f + k (V t − x) \[N\].
    fn applied(&self, time: T, state: &Vector3<T>) -> Checked<T> {
        let force = Named("force", self.system.parameters().force.value(time)).finite()?;
        Ok(force + self.system.spring_force(time, state))
    }

    /// Steps of the mass, (2m/h + kh/2 + c) v̄ = 2m v₀/h + f + k (V t − x₀) − F̄ with f and V t in
    /// the middle of each, under a friction that answers v̄, and at an answer the force. This is
    /// the step of a free mass m + (h/2)(kh/2 + c) under a force less (kh/2 + c) v₀.
    fn stepped(
        &self,
        steps: u32,
        mut mean_velocity: impl FnMut(&MassStep<T>, &mut Vector3<T>, &mut Run) -> T,
        force: impl Fn(T, &Vector3<T>, &mut Run) -> Checked<T>,
    ) -> Checked<Motion<T>> {
        let mechanism = self.system.parameters().mechanism;
        let (mut state, mut states, mut run) = (self.start, Vec::new(), Run::default());
        let mut history = VelocityHistory::new(state[1]);
        let next_kink = |from, to| self.system.parameters().force.next_kink(from, to);
        for span in self.answers.spans() {
            for (duration, look, _) in each_step(span, steps, next_kink) {
                let half = duration * lit(0.5);
                let drag = mechanism.spring_stiffness * half + mechanism.viscous_damping;
                let body = PointMass {
                    mass: mechanism.mass + half * drag,
                    velocity: state[1],
                    force: self.applied(look, &state)? - drag * state[1],
                    end_weight: lit(0.5),
                };
                let step = MassStep { duration, body, predicted: history.predict() };
                let mean = mean_velocity(&step, &mut state, &mut run);
                state[0] += mean * duration;
                state[1] = lit::<T>(2.0) * mean - state[1];
                history.push(state[1]);
            }
            states.push(state);
            let answer = match self.quantity {
                Quantity::Force => force(span.1, &state, &mut run)?,
                Quantity::Position => state[0],
                Quantity::Velocity => state[1],
            };
            run.answers.push(to_f64(answer));
        }
        Ok((run, states))
    }

    /// The friction curve with true rest. A step ends at rest (v₁ = 0, v̄ = v₀/2) if the F̄ that
    /// this takes is no more than p μ_s. Else it slides the way of that force, F̄ that of the curve
    /// at the extrapolated velocity.
    fn slide(&self, steps: u32) -> Checked<Motion<T>> {
        let curve = |velocity, run: &mut Run| {
            run.count(1, cost::CURVE);
            self.system.parameters().contact.stationary_force(velocity)
        };
        let mean_velocity = |step: &MassStep<T>, _: &mut Vector3<T>, run: &mut Run| {
            run.cost += cost::SLIDE;
            let PointMass { mass, velocity, force, .. } = step.body;
            let to_rest = velocity * lit(0.5);
            let stopping = force + mass * velocity / step.duration;
            if !(stopping.abs() > self.breakaway) {
                return to_rest;
            }
            let way = if stopping > T::zero() { T::one() } else { -T::one() };
            let slides = step.predicted * way > T::zero();
            let friction = if slides { curve(step.predicted, run) } else { way * self.breakaway };
            let mean = velocity + (force - friction) * step.duration * lit(0.5) / mass;
            // It does not slide on past rest.
            if (mean - to_rest) * way > T::zero() { mean } else { to_rest }
        };
        self.stepped(steps, mean_velocity, |time, state, run| {
            if is_zero(state[1]) {
                let applied = self.applied(time, state)?;
                return Ok(applied.smaller(self.breakaway).larger(-self.breakaway));
            }
            Ok(curve(state[1], run))
        })
    }

    /// Passive steps, each solved once.
    fn companion<N: Bristle<T, Deflection = T>>(
        &self,
        contact: &Contact<T, N>,
        steps: u32,
        cost_of_step: f64,
    ) -> Checked<Motion<T>> {
        let companion = contact.clone().companion(T::zero())?;
        let mean_velocity = |step: &MassStep<T>, state: &mut Vector3<T>, run: &mut Run| {
            run.count(1, cost_of_step);
            let friction = companion.step(step.predicted, state[2], step.duration);
            let mean = friction.point_mass(step.body);
            state[2] = friction.commit(mean).deflection;
            mean
        };
        self.stepped(steps, mean_velocity, |_, state, run| {
            run.count(1, cost::FORCE);
            Ok(contact.force(state[1], state[2]))
        })
    }

    fn motion(&self, level: Level, steps: u32) -> Result<Motion<T>, FidelityError> {
        check_run(&self.levels(), level, steps)?;
        let motion = match level {
            Level::TRUE_REST => self.slide(steps),
            Level::DAHL_COMPANION => self.companion(&self.dahl, steps, cost::DAHL_COMPANION),
            _ => self.companion(&self.system.parameters().contact, steps, cost::COMPANION),
        };
        Ok(motion?)
    }
}

impl<T: Scalar, M: Bristle<T, Deflection = T>, F: Signal<T>> Scene for MechanismScene<T, M, F> {
    fn levels(&self) -> Vec<Level> {
        alloc::vec![Level::TRUE_REST, Level::DAHL_COMPANION, Level::REFERENCE_COMPANION]
    }

    fn interval(&self) -> f64 {
        to_f64(self.answers.interval)
    }

    fn quantity(&self) -> Quantity {
        self.quantity
    }

    fn fewest_steps(&self) -> u32 {
        resolving(self.answers.interval, self.system.longest_step())
    }

    fn run(&self, level: Level, steps: u32) -> Result<Run, FidelityError> {
        Ok(self.motion(level, steps)?.0)
    }

    /// All from the run of the reference with these steps. Of the static curve the pre-sliding
    /// share: the breakaway distance over the farthest way from the start, at most 1. Of Dahl by
    /// how much the steady friction differs from that at rest at most, over that at rest. Of the
    /// reference the share of the answers at which the mass is stuck: slower than a hundredth of
    /// its fastest velocity.
    fn physics(&self, level: Level, steps: u32) -> Option<(&'static str, f64)> {
        let (_, states) = self.motion(Level::REFERENCE_COMPANION, steps).ok()?;
        let most = |of: &dyn Fn(&Vector3<T>) -> T| states.iter().map(of).fold(T::zero(), T::larger);
        Some(match level {
            Level::TRUE_REST => {
                let farthest = most(&|state| (state[0] - self.start[0]).abs());
                let stiffness = self.dahl.model().storage_stiffness() * self.dahl.reference_load();
                ("presliding", to_f64(self.breakaway / (stiffness * farthest)).min(1.0))
            }
            Level::DAHL_COMPANION => {
                let steady = |speed| self.system.parameters().contact.stationary_force(speed);
                let change = most(&|state| match state[1].abs() {
                    speed if is_zero(speed) => speed,
                    speed => (steady(speed) - self.breakaway).abs(),
                });
                ("variation", to_f64(change / self.breakaway))
            }
            _ => {
                let fastest = most(&|state| state[1].abs());
                let stuck = |state: &&Vector3<T>| state[1].abs() * lit(100.0) <= fastest;
                let stuck = states.iter().filter(stuck).count();
                ("stuck", stuck as f64 / states.len() as f64)
            }
        })
    }
}
