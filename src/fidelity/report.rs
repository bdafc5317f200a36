//! What the ladder answers.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;

use crate::parameter::ParameterError;

/// A model of a scene, from the cheapest to the truest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Rung {
    /// F = p μ(v) sgn v: no memory.
    StaticCurve,
    /// One deflection under a constant friction coefficient.
    Dahl,
    /// One deflection under the friction curve: FrBD with one spring and one dashpot.
    FrBd,
    /// The model of the scene itself.
    Reference,
    /// A contact patch in steady rolling at the motion of the instant: no memory.
    SlipCurve,
    /// A force that follows that one over a relaxation length.
    RelaxationLength,
    /// The contact patch itself.
    Patch,
}

impl Rung {
    pub(super) fn is_memoryless(self) -> bool {
        matches!(self, Rung::StaticCurve | Rung::SlipCurve)
    }
}

impl fmt::Display for Rung {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Rung::StaticCurve => "static curve",
            Rung::Dahl => "Dahl",
            Rung::FrBd => "FrBD",
            Rung::Reference => "reference",
            Rung::SlipCurve => "slip curve",
            Rung::RelaxationLength => "relaxation length",
            Rung::Patch => "patch",
        })
    }
}

/// How a rung is stepped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Integrator {
    /// Nothing to step.
    Evaluation,
    /// The exact step ([`Bristle::hold`](crate::Bristle::hold)) at the velocity in the middle of the step.
    Hold,
    /// Exponential collocation with three nodes a step ([`exponential`](crate::exponential)).
    Collocation,
    /// A first-order lag, exact for a target that runs straight over a step.
    Ramp,
    /// The exact reduction of a patch with the motion at two Gauss points of each step, of fourth order
    /// ([`ExactPatch::follow`](crate::rolling::ExactPatch::follow)).
    Gauss,
    /// A patch on a [`Grid`](crate::rolling::Grid) of so many cells, with the motion in the middle of the step.
    Grid {
        /// Number of cells.
        cells: usize,
    },
    /// Implicit steps of a mechanism in closed form, friction at rest set-valued: true rest.
    Implicit,
    /// Passive steps of a mechanism, solved once each ([`Contact::companion`](crate::Contact::companion)).
    Companion,
    /// Error control ([`Solver::automatic`](crate::ode::Solver::automatic)) at a tolerance of 10^−digits.
    Adaptive {
        /// Minus the decimal logarithm of the tolerance.
        digits: u8,
    },
}

impl fmt::Display for Integrator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Integrator::Evaluation => "evaluation",
            Integrator::Hold => "exact hold",
            Integrator::Collocation => "collocation",
            Integrator::Ramp => "exact ramp",
            Integrator::Gauss => "Gauss points",
            Integrator::Grid { cells } => return f.pad(&format!("grid of {cells}")),
            Integrator::Implicit => "implicit",
            Integrator::Companion => "companion",
            Integrator::Adaptive { digits } => {
                return f.pad(&format!("adaptive 1e-{digits}"));
            }
        })
    }
}

/// What is wanted of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Quantity {
    /// The friction force \[N\].
    #[default]
    Force,
    /// The position of the mass \[m\].
    Position,
    /// Its velocity [m/s].
    Velocity,
}

impl Quantity {
    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::Force => "N",
            Quantity::Position => "m",
            Quantity::Velocity => "m/s",
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Quantity::Force => "friction force",
            Quantity::Position => "position",
            Quantity::Velocity => "velocity",
        })
    }
}

/// In which sense an error is small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Norm {
    /// The largest error at any answer.
    Greatest,
    /// The root of the mean of the squares over all answers.
    RootMeanSquare,
}

/// How far off the answers may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// In which sense.
    pub norm: Norm,
    /// The error allowed, as a share \[–\] of the largest steady force in the scene,
    /// [`History::force_scale`](super::History::force_scale),
    /// [`RollingHistory::force_scale`](super::RollingHistory::force_scale); of a [`MechanismHistory`](super::MechanismHistory), of the
    /// scale it was given.
    pub share: f64,
}

/// A way to compute the answers of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// The model.
    pub rung: Rung,
    /// How it is stepped.
    pub integrator: Integrator,
    /// Length of a step \[s\]; under error control the time between two answers.
    pub step: f64,
    /// Steps between two answers; 1 under error control. Of a contact patch see
    /// [`RollingHistory::with_substeps`](super::RollingHistory::with_substeps).
    pub substeps: usize,
    /// Weighted right-hand sides per second of scene \[1/s\], see [`fidelity`](crate::fidelity).
    pub cost_rate: f64,
}

/// On what a finding rests.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// On a bound.
    Proved,
    /// On a pilot run beside the reference.
    Measured,
    /// On pilot runs with longer steps, whose error is taken to fall with the first power of the step.
    Extrapolated,
    /// On the integrator's own error control, at a tolerance tightened by a stated factor
    /// ([`MechanismHistory::choose`](super::MechanismHistory::choose)): no pilot was long enough.
    Estimated,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Verdict::Proved => "bound",
            Verdict::Measured => "measured",
            Verdict::Extrapolated => "extrapolated",
            Verdict::Estimated => "error control",
        })
    }
}

/// One plan that was looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// The plan. (Tried with longer steps than its own it is no worse with its own.)
    pub plan: Plan,
    /// Its error, in the unit of the quantity, or a bound on it.
    pub error: f64,
    /// On what that rests.
    pub verdict: Verdict,
    /// Whether it meets the tolerance.
    pub met: bool,
}

/// Numbers that tell what kind of a scene it is, from the part that the pilot looks at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Smallest speed [m/s].
    pub slowest: f64,
    /// Largest speed [m/s].
    pub fastest: f64,
    /// Reversals of the velocity.
    pub reversals: usize,
    /// Lag \[–\]: the largest |ż_ss|/(λ z_b), how far behind the steady deflection one runs. Far below one the
    /// bristle follows the velocity without delay. Infinite where it does not relax. Of a contact patch: by how much
    /// of the tolerance's unit the steady force changes in a transit, at most.
    pub lag: f64,
    /// Pre-sliding \[–\]: the breakaway distance z_b = μ(0)/σ0 over the longest way in one direction. Far
    /// above one nothing ever breaks away. Of a contact patch: the least V/λ, transits while a bristle relaxes once.
    pub presliding: f64,
    /// Share of the time \[–\] in which less than z_b was slid since the last reversal. Of a contact patch: with V > λ.
    pub stuck_share: f64,
    /// Relaxation Λ = ∫λ dt \[–\] in a period, or in all: e^−Λ of a disturbance is left.
    pub relaxation: f64,
    /// Transits of a contact patch \[–\] in a period, or in all.
    pub transits: Option<f64>,
}

/// The cheapest plan that meets a tolerance, and the evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// What is wanted.
    pub quantity: Quantity,
    /// The plan.
    pub plan: Plan,
    /// Its error in the norm of the tolerance, in the unit of the quantity, or a bound on it.
    pub error: f64,
    /// On what that rests.
    pub verdict: Verdict,
    /// What kind of a scene it is.
    pub evidence: Evidence,
    /// What was asked for.
    pub tolerance: Tolerance,
    /// The same in the unit of the quantity.
    pub allowed: f64,
    /// Every plan that was looked at on the way, in this order, with what was found of it last.
    pub trials: Vec<Trial>,
    /// What the pilot has cost: looks at the friction model, of which none is made twice; a step of Dahl's counts 0.7.
    pub pilot_evaluations: f64,
    /// Those that it might have cost.
    pub pilot_budget: f64,
    /// Share of the scene that the pilot looked at \[–\].
    pub seen: f64,
}

/// A number to three digits, in powers of ten only where it is very small or large.
struct Three(f64);

impl fmt::Display for Three {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = nalgebra::ComplexField::abs(self.0);
        if !size.is_finite() {
            return f.pad("–");
        }
        if size > 0.0 && !(1e-3..1e5).contains(&size) {
            return f.pad(&format!("{:.2e}", self.0));
        }
        let (mut decimals, mut above) = (2, 10.0);
        while decimals > 0 && size >= above {
            (decimals, above) = (decimals - 1, 10.0 * above);
        }
        let mut below = 1.0;
        while size > 0.0 && size < below {
            (decimals, below) = (decimals + 1, 0.1 * below);
        }
        f.pad(&format!("{:.decimals$}", self.0))
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (percent, allowed) = (100.0 * self.tolerance.share, Three(self.allowed));
        let sense = match self.tolerance.norm {
            Norm::Greatest => "at every answer",
            Norm::RootMeanSquare => "root mean square",
        };
        let (quantity, unit) = (self.quantity, self.quantity.unit());
        writeln!(f, "{quantity} within {percent} % of its scale: {allowed} {unit}, {sense}")?;
        let Evidence { slowest, fastest, reversals, lag, presliding, stuck_share, .. } =
            self.evidence;
        let reversals = match reversals {
            0 => String::from("no reversal"),
            1 => String::from("1 reversal"),
            many => format!("{many} reversals"),
        };
        write!(f, "{} to {} m/s, {reversals}, ", Three(slowest), Three(fastest))?;
        let (lag, presliding, stuck) = (Three(lag), Three(presliding), 100.0 * stuck_share);
        match self.evidence.transits {
            None => {
                writeln!(f, "lag {lag}, pre-sliding {presliding}, stuck {stuck:.0} % of the time")?;
            }
            Some(transits) => {
                writeln!(f, "{} transits in a period or in all", Three(transits))?;
                write!(f, "steady force changes by up to {lag} of its scale in a transit, ")?;
                writeln!(f, "{stuck:.0} % of the time V > λ")?;
            }
        }
        writeln!(f)?;
        writeln!(
            f,
            "{:17} {:14} {:>8} {:>12} {:>13} {:>10}  {:12}",
            "model",
            "integrator",
            "step / s",
            "cost / (1/s)",
            match quantity {
                Quantity::Velocity => format!("error / ({unit})"),
                _ => format!("error / {unit}"),
            },
            "of allowed",
            "evidence"
        )?;
        let mut trials: Vec<&Trial> = self.trials.iter().collect();
        trials.sort_by(|a, b| a.plan.cost_rate.total_cmp(&b.plan.cost_rate));
        for Trial { plan, error, verdict, met } in trials {
            let memoryless = plan.rung.is_memoryless();
            let step = Three(if memoryless { f64::NAN } else { plan.step });
            let part = format!("{} %", Three(100.0 * error / self.allowed));
            writeln!(
                f,
                "{:17} {:14} {:>8} {:>12} {:>13} {:>10}  {:12} {}",
                plan.rung,
                plan.integrator,
                step,
                Three(plan.cost_rate),
                Three(*error),
                part,
                verdict,
                if *met { "enough" } else { "no" }
            )?;
        }
        if self.trials.iter().any(|trial| !trial.met && trial.error <= self.allowed) {
            writeln!(f, "(what is measured must stay below 85 to 97 % of what is allowed)")?;
        }
        let Plan { rung, integrator, step, .. } = self.plan;
        writeln!(f)?;
        if rung.is_memoryless() {
            writeln!(f, "take: {rung}")?;
        } else {
            writeln!(f, "take: {rung}, {integrator}, a step each {} s", Three(step))?;
        }
        let (spent, budget) = (self.pilot_evaluations, self.pilot_budget);
        write!(f, "the pilot took {spent:.0} of {budget:.0} evaluations, ")?;
        if self.seen < 1.0 {
            write!(f, "over {} % of the scene", Three(100.0 * self.seen))
        } else {
            write!(f, "over all of the scene")
        }
    }
}

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FidelityError {
    /// A number that is out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A plan that belongs to another scene.
    #[error("this scene has no plan of {rung} by {integrator}")]
    NoSuchPlan {
        /// The model of the plan.
        rung: Rung,
        /// How it is stepped.
        integrator: Integrator,
    },
    /// No rung meets the tolerance with any step that was tried.
    #[error(
        "an error of {allowed:e} {unit} is out of reach: the best is {error:e} {unit}, by {} with steps of {:e} s ({evaluations} evaluations spent)",
        plan.rung, plan.step, unit = quantity.unit()
    )]
    OutOfReach {
        /// Of what.
        quantity: Quantity,
        /// The error allowed, in its unit.
        allowed: f64,
        /// The least that was found.
        error: f64,
        /// With which plan.
        plan: Plan,
        /// What the pilot has cost.
        evaluations: f64,
    },
    /// The part of the scene that a pilot would have to see is too long for it.
    #[error(
        "a pilot would take {needed:e} evaluations or more and may take {allowed:e}: allow it more (choose_within), or, if the scene repeats itself and its period was not given, give it"
    )]
    PilotTooShort {
        /// Evaluations needed.
        needed: f64,
        /// Evaluations allowed.
        allowed: f64,
    },
    /// The mechanism ends up with more energy than was put into it: the friction model drives it.
    #[error(
        "at t = {time} s the mechanism holds {energy:e} J, and no more than {limit:e} J was put into it: the friction drives it"
    )]
    GainsEnergy {
        /// When \[s\].
        time: f64,
        /// Kinetic and stored energy \[J\].
        energy: f64,
        /// The most that start, base and applied force can have left there \[J\].
        limit: f64,
    },
    /// The motion waits where it is unstable, and leaves by what the errors have grown to: no run in this arithmetic tells when.
    #[error(
        "the mass slides steadily where that is unstable, and errors grow there by a factor of {factor:e}: roundings decide when it slips"
    )]
    Undetermined {
        /// By which errors grow.
        factor: f64,
    },
    /// A run stopped.
    #[error("{rung} stopped at t = {time} s: {reason}")]
    Stopped {
        /// The rung.
        rung: Rung,
        /// The time \[s\].
        time: f64,
        /// Why.
        reason: crate::ode::StopReason,
    },
}
