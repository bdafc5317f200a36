//! A method chosen at run time.

use core::fmt;
use core::str::FromStr;

use super::automatic::Alternating;
use super::dense_output::DenseOutput;
use super::explicit::Explicit;
use super::rosenbrock::Rosenbrock;
use super::stepper::{Field, OneStep, Point, Stepper, TrialStep, as_the_one_at_work};
use super::storage::States;
use super::tolerance::ToleranceRange;
use super::{Automatic, DormandPrince, DormandPrince8, Rodas4, Rodas5P, RungeKutta4};
use crate::Scalar;
use crate::parameter::ParameterError;

/// A method chosen at run time, with the steps of the method itself to the last bit.
///
/// Its names are `automatic`, `dormand_prince`, `dormand_prince8`, `rodas4`, `rodas5p` and
/// `runge_kutta4`.
///
/// ```
/// use bristle::ode::{AnyMethod, Solver, Tolerances};
/// use bristle::scene::MassSpringDamper;
/// use bristle::{Bristle, Dahl, DahlParameters, paper};
///
/// let method: AnyMethod = "rodas5p".parse()?;
/// let friction = Dahl::new(DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 })?;
/// let rig = MassSpringDamper::new(paper::stick_slip_rig(friction.under_load(1.0)?))?;
/// let solver = Solver::checked(method, Tolerances::scaled(1e-6, rig.scales())?);
/// assert!(solver.begin(&rig, 0.0..1.0, rig.at_rest()).is_ok());
///
/// // Runge–Kutta 4 has no error estimate: it takes fixed steps only.
/// let solver = Solver::checked(AnyMethod::RungeKutta4, Tolerances::scaled(1e-6, rig.scales())?);
/// assert!(solver.begin(&rig, 0.0..1.0, rig.at_rest()).is_err());
/// # Ok::<(), bristle::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum AnyMethod {
    /// `DormandPrince8` and `Rodas5P` take turns.
    #[default]
    Automatic,
    /// Explicit, order 5(4).
    DormandPrince,
    /// Explicit, order 8(5,3).
    DormandPrince8,
    /// L-stable Rosenbrock method of order 4(3).
    Rodas4,
    /// L-stable Rosenbrock method of order 5(4).
    #[cfg_attr(feature = "serde", serde(rename = "rodas5p"))]
    Rodas5P,
    /// The classical method, with fixed steps.
    RungeKutta4,
}

const NAMES: [(&str, AnyMethod); 6] = [
    ("automatic", AnyMethod::Automatic),
    ("dormand_prince", AnyMethod::DormandPrince),
    ("dormand_prince8", AnyMethod::DormandPrince8),
    ("rodas4", AnyMethod::Rodas4),
    ("rodas5p", AnyMethod::Rodas5P),
    ("runge_kutta4", AnyMethod::RungeKutta4),
];

impl fmt::Display for AnyMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = NAMES.iter().find(|(_, method)| method == self).map_or("", |(name, _)| name);
        f.pad(name)
    }
}

impl FromStr for AnyMethod {
    type Err = ParameterError;

    /// The method of a name.
    ///
    /// # Errors
    ///
    /// Refuses any other name.
    fn from_str(name: &str) -> Result<Self, ParameterError> {
        let named = NAMES.iter().find(|(known, _)| *known == name);
        named.map(|(_, method)| *method).ok_or_else(|| {
            let takes = "a method is automatic, dormand_prince, dormand_prince8, rodas4, rodas5p \
                         or runge_kutta4";
            ParameterError::chosen("another name", takes)
        })
    }
}

impl<T: Scalar, V: States<T>> OneStep<T, V> for AnyMethod {
    type Stepper = AnyStepper<T, V>;

    fn stepper(&self, tolerance: f64, state: &V) -> Self::Stepper {
        match self {
            Self::Automatic => AnyStepper::Automatic(Automatic.stepper(tolerance, state)),
            Self::DormandPrince => AnyStepper::DormandPrince(Explicit::new(state)),
            Self::DormandPrince8 => AnyStepper::DormandPrince8(Explicit::new(state)),
            Self::Rodas4 => AnyStepper::Rodas4(Rosenbrock::new(state)),
            Self::Rodas5P => AnyStepper::Rodas5P(Rosenbrock::new(state)),
            Self::RungeKutta4 => AnyStepper::RungeKutta4(Explicit::new(state)),
        }
    }

    fn tolerance_range(&self) -> ToleranceRange {
        match self {
            Self::Automatic => ToleranceRange::AUTOMATIC,
            Self::Rodas4 | Self::Rodas5P => ToleranceRange::ROSENBROCK,
            _ => ToleranceRange::SINGLE,
        }
    }

    fn check_adaptive(&self) -> Result<(), ParameterError> {
        if *self == Self::RungeKutta4 {
            let takes = "adaptive steps take a method with an error estimate";
            return Err(ParameterError::chosen("runge_kutta4", takes));
        }
        Ok(())
    }
}

/// The method at work.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "one for a run, on the stack")]
pub(crate) enum AnyStepper<T: Scalar, V: States<T>> {
    Automatic(Alternating<T, V>),
    DormandPrince(Explicit<DormandPrince, T, V, 7>),
    DormandPrince8(Explicit<DormandPrince8, T, V, 16>),
    Rodas4(Rosenbrock<Rodas4, T, V, 6>),
    Rodas5P(Rosenbrock<Rodas5P, T, V, 8>),
    RungeKutta4(Explicit<RungeKutta4, T, V, 5>),
}

/// Calls a function of the method at work.
macro_rules! of_the_method {
    ($self:ident.$function:ident($($argument:expr),*)) => {
        match $self {
            AnyStepper::Automatic(stepper) => stepper.$function($($argument),*),
            AnyStepper::DormandPrince(stepper) => stepper.$function($($argument),*),
            AnyStepper::DormandPrince8(stepper) => stepper.$function($($argument),*),
            AnyStepper::Rodas4(stepper) => stepper.$function($($argument),*),
            AnyStepper::Rodas5P(stepper) => stepper.$function($($argument),*),
            AnyStepper::RungeKutta4(stepper) => stepper.$function($($argument),*),
        }
    };
}

impl<T: Scalar, V: States<T>> Stepper<T, V> for AnyStepper<T, V> {
    fn begin<F: Field<T, V>>(&mut self, field: &mut F, point: &mut Point<T, V>) {
        of_the_method!(self.begin(field, point));
    }

    #[inline]
    fn step(&mut self, field: &mut impl Field<T, V>, from: &Point<T, V>, h: T) -> TrialStep<T, V> {
        of_the_method!(self.step(field, from, h))
    }

    as_the_one_at_work!(of_the_method);

    fn accepted(&mut self, step: T, end: &Point<T, V>, proposed: Option<T>) -> Option<T> {
        of_the_method!(self.accepted(step, end, proposed))
    }
}
