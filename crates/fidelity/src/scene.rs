//! A scene: a quantity wanted at equal intervals, and models that can compute it.

use alloc::vec::Vec;
use core::fmt;

use super::FidelityError;
use bristle::Scalar;
use bristle::parameter::{Checked, Named};
use bristle::scalar::{lit, to_f64};

/// A representative scene, and the models that can run it.
///
/// A scene of your own says which models it has and runs them. Here a mass slides to rest under
/// FrBD, and Coulomb's law competes with it:
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle_fidelity::{FidelityError, Level, Quantity, Run, Scene, Tolerance, choose};
/// use bristle::rheology::KelvinVoigt;
/// use bristle::{Bristle, Contact, FrBd, paper};
///
/// struct SlidingBlock {
///     friction: Contact<f64, FrBd<Stribeck<f64>, KelvinVoigt<f64>>>, // of 1 kg
/// }
///
/// const COULOMB: Level = Level { model: "Coulomb", method: Some("Euler") };
/// const BRISTLE: Level = Level { model: "FrBD", method: Some("exact hold, Euler") };
///
/// impl Scene for SlidingBlock {
///     fn levels(&self) -> Vec<Level> {
///         vec![COULOMB, BRISTLE] // the cheapest first, the reference last
///     }
///
///     fn interval(&self) -> f64 {
///         0.01 // s
///     }
///
///     fn quantity(&self) -> Quantity {
///         Quantity::Velocity
///     }
///
///     fn run(&self, level: Level, steps: u32) -> Result<Run, FidelityError> {
///         let h = self.interval() / f64::from(steps);
///         let (mut v, mut z, mut run) = (1.0_f64, 0.0, Run::default());
///         for _ in 0..50 {
///             for _ in 0..steps {
///                 if level == COULOMB {
///                     v -= h * self.friction.normal_force(); // μ = 1
///                     run.count(1, 0.1);
///                 } else {
///                     let step = self.friction.hold(v, z, h);
///                     (v, z) = (v - h * step.mean_force, step.deflection);
///                     run.count(1, 1.7);
///                 }
///             }
///             run.answers.push(v);
///         }
///         Ok(run)
///     }
/// }
///
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let model = FrBd::new(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?);
/// let block = SlidingBlock { friction: model.under_load(1.0)? };
/// assert_eq!(choose(&block, Tolerance::at_every_answer(0.05))?.best.level, COULOMB);
/// assert_eq!(choose(&block, Tolerance::at_every_answer(0.002))?.best.level, BRISTLE);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Scene {
    /// The model levels from the cheapest to the most expensive. The last one is the reference.
    fn levels(&self) -> Vec<Level>;

    /// The time between two answers \[s\].
    fn interval(&self) -> f64;

    /// Runs a level over the whole scene, with so many steps from one answer to the next: 1, 2, 4 …
    /// The run that checks a reference has an odd number above 1, and best looks at the inputs of
    /// the scene elsewhere than the other runs.
    ///
    /// # Errors
    ///
    /// Refuses a level that is not one of this scene's, and says why a run stopped.
    fn run(&self, level: Level, steps: u32) -> Result<Run, FidelityError>;

    /// Steps from one answer to the next without which the inputs of the scene are not resolved:
    /// runs with fewer may agree about an alias of an input, and are no reference.
    fn fewest_steps(&self) -> u32 {
        1
    }

    /// The physical quantity of the answers.
    fn quantity(&self) -> Quantity {
        Quantity::Force
    }

    /// The name and value of a dimensionless number: small if the physics that a level leaves out
    /// does not matter in this scene.
    fn physics(&self, level: Level, steps: u32) -> Option<(&'static str, f64)> {
        let _ = (level, steps);
        None
    }
}

/// A model with the method that steps it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Level {
    /// The model.
    pub model: &'static str,
    /// The method, which more steps make more accurate; `None` for a model without memory, each of
    /// whose answers is one evaluation.
    pub method: Option<&'static str>,
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.model)?;
        self.method.map_or(Ok(()), |method| write!(f, ", {method}"))
    }
}

/// The answers of a run, and its cost.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Run {
    /// The answers, in the unit of the scene's quantity.
    pub answers: Vec<f64>,
    /// Evaluations of the friction model.
    pub evaluations: u64,
    /// Their cost in evaluations of FrBD with one spring, see [`fidelity`](crate#cost).
    pub cost: f64,
}

impl Run {
    /// Counts evaluations that cost so much each.
    #[inline]
    pub fn count(&mut self, evaluations: u64, cost_of_each: f64) {
        self.evaluations += evaluations;
        self.cost += cost_of_each * evaluations as f64;
    }
}

/// The quantity that is wanted of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Quantity {
    /// The friction force \[N\].
    #[default]
    Force,
    /// The position of the mass \[m\].
    Position,
    /// The velocity of the mass [m/s].
    Velocity,
}

impl Quantity {
    /// Its name and its unit.
    pub const fn name_and_unit(self) -> (&'static str, &'static str) {
        match self {
            Quantity::Force => ("friction force", "N"),
            Quantity::Position => ("position", "m"),
            Quantity::Velocity => ("velocity", "m/s"),
        }
    }
}

/// Most steps from one answer to the next: a step of a microsecond where answers are a second
/// apart.
pub(super) const MOST_STEPS: u32 = 1 << 20;

/// Most answers of a scene: a quarter of an hour at 1 kHz, and 8 MB for each run that is kept.
const MOST_ANSWERS: usize = 1_000_000;

/// The steps over a time that are none longer than an input allows
/// ([`Signal::longest_step`](bristle::signal::Signal::longest_step)).
pub(super) fn resolving<T: Scalar>(duration: T, longest: Option<T>) -> u32 {
    longest.map_or(1, |longest| to_f64((duration / longest).ceil()) as u32)
}

/// Checks that a scene with these levels has such a run.
pub(super) fn check_run(levels: &[Level], level: Level, steps: u32) -> Result<(), FidelityError> {
    if !levels.contains(&level) {
        return Err(FidelityError::NoSuchLevel(level));
    }
    Ok(Named("steps", steps as usize).count_between(1, MOST_STEPS as usize)?)
}

/// When answers are wanted: at Δ, 2Δ, …
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answers<T> {
    /// Time between two answers Δ \[s\].
    pub interval: T,
    /// Number of answers, up to a million.
    pub count: usize,
}

impl<T: Scalar> Answers<T> {
    pub(super) fn checked(self) -> Checked<Self> {
        let interval = Named("interval", self.interval).positive()?;
        Named("answers", self.count).count_between(1, MOST_ANSWERS)?;
        Ok(Self { interval, ..self })
    }

    /// The time of an answer; the start is that of answer 0.
    pub(super) fn time(&self, answer: usize) -> T {
        self.interval * lit(answer as f64)
    }

    /// The times of all answers.
    pub(super) fn times(&self) -> impl Iterator<Item = T> + '_ {
        self.spans().map(|(_, time)| time)
    }

    /// The spans from one answer to the next.
    pub(super) fn spans(&self) -> impl Iterator<Item = (T, T)> + '_ {
        (1..=self.count).map(|answer| (self.time(answer - 1), self.time(answer)))
    }
}

/// The steps from one time to another, divided where an input is not smooth: length, middle, where
/// it looks at its inputs, and end of each. Those of a check ([`Scene::run`]) are shifted by half a
/// step, so that they look where other runs have their ends.
#[inline]
pub(super) fn each_step<T: Scalar>(
    (start, end): (T, T),
    steps: u32,
    next_kink: impl Fn(T, T) -> Option<T>,
) -> impl Iterator<Item = (T, T, T)> {
    let length = (end - start) / lit(f64::from(steps));
    let check = steps > 1 && !steps.is_multiple_of(2);
    let shift = if check { 0.5 } else { 0.0 };
    let (mut from, mut index) = (start, 1);
    core::iter::from_fn(move || {
        while index <= steps + u32::from(check) {
            let place = f64::from(index) - shift;
            let last = index >= steps && place >= steps.into();
            let to = if last { end } else { start + length * lit(place) };
            if from < to {
                let kink = next_kink(from, to).filter(|kink| *kink > from && *kink < to);
                let until = kink.unwrap_or(to);
                let step = (until - from, (from + until) * lit(0.5), until);
                from = until;
                return Some(step);
            }
            index += 1;
        }
        None
    })
}
