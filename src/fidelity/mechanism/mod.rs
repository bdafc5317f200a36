//! A mechanism of one degree of freedom, and the rungs that can move it.

mod climb;
mod machine;
mod survey;

use alloc::vec::Vec;

use nalgebra::Vector3;

use self::machine::{Dry, Grid, Machine, NO_LIMIT, Run, Sample};
use super::history::count;
use super::report::{Choice, FidelityError, Integrator, Plan, Quantity, Rung, Tolerance};
use super::{Start, weight};
use crate::Mechanism;
use crate::bounds::larger;
use crate::parameter::{self, ParameterError};
use crate::scalar::{lit, to_f64};
use crate::signal::Signal;
use crate::{Bristle, Contact, Dahl, DahlParameters, Scalar};

/// Parameters of [`MechanismHistory`].
#[derive(Debug, Clone, PartialEq)]
pub struct MechanismHistoryParameters<T, M, D, F> {
    /// The model to be replaced by a cheaper one, under its normal force.
    pub contact: Contact<T, M>,
    /// Mass, spring to the base (zero for a free joint) and damping.
    pub mechanism: Mechanism<T>,
    /// Position y(t) \[m\] of the spring's far end.
    pub drive: D,
    /// Force f(t) \[N\] on the mass.
    pub force: F,
    /// Position at the start \[m\].
    pub position: T,
    /// Velocity at the start [m/s].
    pub velocity: T,
    /// How the bristle begins.
    pub start: Start,
    /// Time between two answers Δ \[s\]: they are wanted at Δ, 2Δ, …
    pub interval: T,
    /// Number of answers, 8 to 10⁹.
    pub answers: usize,
    /// Answers in one period of drive and force, 8 to 10⁹, if they repeat themselves. It is taken at your word.
    pub period: Option<usize>,
    /// What is wanted.
    pub quantity: Quantity,
    /// The unit of tolerances, in the unit of the quantity: the error that a share of one would be.
    pub scale: T,
}

/// A motion, or a friction force, wanted at equal intervals of a mass on a spring:
///
/// ẋ = v,  m v̇ = f(t) + k (y(t) − x) − d v − F.
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | x, v | position and velocity of the mass | m, m/s |
/// | m, k, d | mass, spring, damping beside the friction | kg, N/m, N s/m |
/// | y, f | position of the spring's far end, force on the mass | m, N |
/// | F | friction force | N |
///
/// A spring to the ground is one whose far end does not move, and a free joint one without a spring. The stick-slip rig of the paper,
/// position within 1 % of the spring's stretch at breakaway:
///
/// ```
/// use bristle::fidelity::{MechanismHistory, MechanismHistoryParameters, Norm, Quantity, Rung, Start, Tolerance};
/// use bristle::signal::{Constant, Polyline, Vertex};
/// use bristle::Mechanism;
/// use bristle::{Bristle, FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
///
/// let friction = FrBd::new(
///     Stribeck::new(paper::STICK_SLIP_CURVE)?,
///     KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?,
/// );
/// let rig = MechanismHistory::new(MechanismHistoryParameters {
///     contact: friction.under_load(1.0)?,
///     mechanism: Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.0 },
///     drive: Polyline::new([
///         Vertex { time: 0.0, value: 0.0 },
///         Vertex { time: 20.0, value: 2.0 },
///     ])?,
///     force: Constant::new(0.0)?,
///     position: 0.0,
///     velocity: 0.0,
///     start: Start::Undeflected,
///     interval: 0.1_f64,
///     answers: 200,
///     period: None,
///     quantity: Quantity::Position,
///     scale: 0.75,
/// })?;
/// // All of it has to be seen, which takes a longer pilot than `choose` allows.
/// let choice = rig.choose_within(Tolerance { norm: Norm::Greatest, share: 0.01 }, 5e4)?;
/// // Two models of friction drift apart from slip to slip: it takes the model itself.
/// assert_eq!(choice.plan.rung, Rung::Reference);
/// let positions = rig.carry_out(choice.plan)?.answers;
/// assert_eq!(positions.len(), 200);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct MechanismHistory<T: Scalar, M, D, F> {
    contact: Contact<T, M>,
    dahl: Contact<T, Dahl<T>>,
    machine: Machine<T, D, F>,
    dry: Dry<T>,
    start: Start,
    interval: T,
    answers: usize,
    period: Option<usize>,
    quantity: Quantity,
    scale: T,
    /// Typical magnitudes of position, velocity and deflection.
    scales: Vector3<T>,
}

/// What a plan gives when it is carried out.
#[derive(Debug, Clone, PartialEq)]
pub struct Carried<T> {
    /// The quantity at every answer.
    pub answers: Vec<T>,
    /// Weighted right-hand sides that it took.
    pub cost: f64,
}

impl<T, M, D, F> MechanismHistory<T, M, D, F>
where
    T: Scalar,
    M: Bristle<T, Deflection = T>,
    D: Signal<T>,
    F: Signal<T>,
{
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// Refuses a mass, an interval, a scale or a normal force that is not positive, a spring or a damping that is
    /// negative, fewer than 8 answers in all or in a period, and signals that are not finite at the answers.
    pub fn new(parameters: MechanismHistoryParameters<T, M, D, F>) -> Result<Self, ParameterError> {
        let MechanismHistoryParameters {
            contact,
            mechanism,
            drive,
            force,
            position,
            velocity,
            start,
            interval,
            answers,
            period,
            quantity,
            scale,
        } = parameters;
        parameter::positive("mass", mechanism.mass)?;
        parameter::non_negative("spring_stiffness", mechanism.spring_stiffness)?;
        parameter::non_negative("viscous_damping", mechanism.viscous_damping)?;
        let normal_force = parameter::positive("normal_force", contact.normal_force())?;
        let position = parameter::finite("position", position)?;
        let velocity = parameter::finite("velocity", velocity)?;
        let interval = parameter::positive("interval", interval)?;
        let scale = parameter::positive("scale", scale)?;
        count("answers", answers)?;
        if let Some(period) = period {
            count("period", period)?;
        }
        let machine = Machine { mechanism, drive, force, position, velocity };
        let model = contact.model();
        let micro_stiffness = model.storage_stiffness();
        let most = model.limits(T::zero()).deflection;
        let breakaway = most.map_or(T::zero(), |limit| limit * micro_stiffness) * normal_force;
        let breakaway = parameter::positive("breakaway force", breakaway)?;
        let dahl = Dahl::new(DahlParameters {
            dynamic_coefficient: breakaway / normal_force,
            micro_stiffness,
        })?
        .under_load(normal_force)?;
        // Where the curve is a straight line at last; far above any Stribeck velocity.
        let far = |speed: f64| model.stationary_coefficient(lit::<T>(speed));
        let rise = (far(2e4) - far(1e4)) * lit(1e-4);
        let viscous = if rise > T::zero() { rise * normal_force } else { T::zero() };
        let deflection = breakaway / (micro_stiffness * normal_force);
        let mut furthest = deflection;
        let mut fastest = (breakaway * deflection / mechanism.mass).sqrt();
        if mechanism.spring_stiffness > T::zero() {
            let stretch = breakaway / mechanism.spring_stiffness;
            furthest = larger(furthest, stretch);
            let swing = (mechanism.spring_stiffness / mechanism.mass).sqrt();
            fastest = larger(fastest, stretch * swing);
        }
        let motion = Self {
            contact,
            dahl,
            machine,
            dry: Dry { breakaway, viscous },
            start,
            interval,
            answers,
            period,
            quantity,
            scale,
            scales: Vector3::new(furthest, larger(fastest, velocity.abs()), deflection),
        };
        for index in 0..=answers {
            parameter::finite("applied force", motion.machine.applied(motion.time(index)))?;
        }
        Ok(motion)
    }

    /// Finds a cheap plan that meets a tolerance.
    ///
    /// The pilot costs no more than 2000 evaluations of the friction model (and those of the step it ends in), or a twentieth
    /// of a full run of the reference under error control if that is more. Where it cannot see enough, the answer is the reference with a
    /// tolerance 300 times tighter than asked for (1000 times for velocities and forces), and tighter still where two runs over the part that was seen say so:
    /// [`Verdict::Estimated`](super::Verdict::Estimated). Where a spring can lead the mass along
    /// unstable sliding it is refused, for errors grow there without limit before the slip. It may cost many times what would have done,
    /// and does in a third of all scenes: allow the pilot more ([`MechanismHistory::choose_within`]).
    ///
    /// # Errors
    ///
    /// Refuses a share that is not positive, says what the best is if no rung meets the tolerance, where
    /// friction puts energy into the mechanism, and where roundings decide when it slips.
    pub fn choose(&self, tolerance: Tolerance) -> Result<Choice, FidelityError> {
        parameter::positive("share", tolerance.share)?;
        climb::choose(self, tolerance, None)
    }

    /// The same with another limit on what the pilot may cost [evaluations of the friction model].
    ///
    /// # Errors
    ///
    /// As [`MechanismHistory::choose`].
    pub fn choose_within(
        &self,
        tolerance: Tolerance,
        most_evaluations: f64,
    ) -> Result<Choice, FidelityError> {
        parameter::positive("share", tolerance.share)?;
        let most = parameter::positive("most_evaluations", most_evaluations)?;
        climb::choose(self, tolerance, Some(most))
    }

    /// Carries a plan out.
    ///
    /// # Errors
    ///
    /// Refuses a plan that is not one of this scene's; says why a run stopped.
    pub fn carry_out(&self, plan: Plan) -> Result<Carried<T>, FidelityError> {
        let way = Way { rung: plan.rung, integrator: plan.integrator };
        let run = self.run(way, plan.substeps.max(1), self.answers, NO_LIMIT)?;
        let answers = run.samples.iter().map(|sample| lit(self.value(sample))).collect();
        Ok(Carried { answers, cost: run.cost })
    }

    /// Every plan with one step between two answers, and those with error control, from the cheapest rung on.
    /// The cost of the latter is known only when they are carried out, and not a number.
    pub fn plans(&self) -> Vec<Plan> {
        let mut plans = Vec::new();
        for way in Self::ways() {
            plans.push(self.plan(way, 1, Self::step_cost(way)));
        }
        for digits in 2..=self.most_digits() {
            let integrator = Integrator::Adaptive { digits };
            plans.push(self.plan(Way { rung: Rung::Reference, integrator }, 1, f64::NAN));
        }
        plans
    }

    /// Number of answers.
    pub fn answers(&self) -> usize {
        self.answers
    }

    /// The rungs with steps of a fixed length.
    fn ways() -> [Way; 3] {
        [
            Way { rung: Rung::StaticCurve, integrator: Integrator::Implicit },
            Way { rung: Rung::Dahl, integrator: Integrator::Companion },
            Way { rung: Rung::Reference, integrator: Integrator::Companion },
        ]
    }

    /// Of one step and one answer; sliding all the time.
    fn step_cost(way: Way) -> f64 {
        match way.rung {
            Rung::StaticCurve => weight::SLIDE + weight::STEADY,
            Rung::Dahl => weight::DAHL_COMPANION,
            _ => weight::COMPANION,
        }
    }

    fn plan(&self, way: Way, substeps: usize, cost: f64) -> Plan {
        let interval = to_f64(self.interval);
        Plan {
            rung: way.rung,
            integrator: way.integrator,
            step: interval / substeps as f64,
            substeps,
            cost_rate: cost / interval,
        }
    }

    fn run(
        &self,
        way: Way,
        substeps: usize,
        answers: usize,
        most: (f64, f64),
    ) -> Result<Run, FidelityError> {
        let with_force = self.quantity == Quantity::Force;
        let grid = Grid { interval: self.interval, answers, substeps, with_force };
        let (velocity, machine) = (self.machine.velocity, &self.machine);
        let steady = self.start == Start::Steady;
        let from = |stationary: T| if steady { stationary } else { T::zero() };
        match (way.rung, way.integrator) {
            (Rung::StaticCurve, Integrator::Implicit) => {
                Ok(machine.slide(&self.contact, self.dry, grid))
            }
            (Rung::Dahl, Integrator::Companion) => {
                let z = from(self.dahl.stationary(velocity));
                machine.companion(&self.dahl, z, Self::step_cost(way), grid)
            }
            (Rung::Reference, Integrator::Companion) => {
                let z = from(self.contact.stationary(velocity));
                machine.companion(&self.contact, z, Self::step_cost(way), grid)
            }
            (Rung::Reference, Integrator::Adaptive { digits }) => {
                let z = from(self.contact.stationary(velocity));
                let tolerance =
                    lit::<T>(nalgebra::ComplexField::powi(10.0_f64, -i32::from(digits)));
                machine.adaptive(
                    &self.contact,
                    z,
                    (tolerance, self.scales, self.longest_step()),
                    grid,
                    most,
                )
            }
            _ => Err(FidelityError::NoSuchPlan { rung: way.rung, integrator: way.integrator }),
        }
    }

    /// The longest step that error control may take: an eighth of a period, a sixteenth of a scene without, never less than the
    /// time between two answers.
    fn longest_step(&self) -> T {
        let answers = match self.period {
            Some(period) => period as f64 / 8.0,
            None => self.answers as f64 / 16.0,
        };
        self.interval * lit(larger(answers, 1.0))
    }

    /// Tolerances tighter than this are roundings.
    fn most_digits(&self) -> u8 {
        if to_f64(T::default_epsilon()) < 1e-12 { 13 } else { 5 }
    }

    fn time(&self, index: usize) -> T {
        self.interval * lit(index as f64)
    }

    /// What is wanted.
    fn value(&self, sample: &Sample) -> f64 {
        match self.quantity {
            Quantity::Force => sample.force,
            Quantity::Position => to_f64(self.machine.position) + sample.position,
            Quantity::Velocity => sample.velocity,
        }
    }
}

/// A rung and how it is stepped.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Way {
    rung: Rung,
    integrator: Integrator,
}
