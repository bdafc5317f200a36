//! A method chosen at run time.

use core::fmt;
use core::str::FromStr;

use nalgebra::SMatrix;

use super::automatic::Alternating;
use super::dense_output::DenseOutput;
use super::explicit::Explicit;
use super::rosenbrock::Rosenbrock;
use super::stepper::{Field, OneStep, Point, Stepper, TrialStep};
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

impl<T: Scalar, const N: usize> OneStep<T, N> for AnyMethod {
    type Stepper = AnyStepper<T, N>;

    fn stepper(&self, tolerance: f64) -> Self::Stepper {
        match self {
            Self::Automatic => AnyStepper::Automatic(Automatic.stepper(tolerance)),
            Self::DormandPrince => AnyStepper::DormandPrince(DormandPrince.stepper(tolerance)),
            Self::DormandPrince8 => AnyStepper::DormandPrince8(DormandPrince8.stepper(tolerance)),
            Self::Rodas4 => AnyStepper::Rodas4(Rodas4.stepper(tolerance)),
            Self::Rodas5P => AnyStepper::Rodas5P(Rodas5P.stepper(tolerance)),
            Self::RungeKutta4 => AnyStepper::RungeKutta4(RungeKutta4.stepper(tolerance)),
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
pub(crate) enum AnyStepper<T: Scalar, const N: usize> {
    Automatic(Alternating<T, N>),
    DormandPrince(Explicit<DormandPrince, T, N, 7>),
    DormandPrince8(Explicit<DormandPrince8, T, N, 16>),
    Rodas4(Rosenbrock<Rodas4, T, N, 6>),
    Rodas5P(Rosenbrock<Rodas5P, T, N, 8>),
    RungeKutta4(Explicit<RungeKutta4, T, N, 5>),
}

/// Calls a function of the method at work.
macro_rules! of_the_method {
    ($self:ident, $stepper:ident => $answer:expr) => {
        match $self {
            AnyStepper::Automatic($stepper) => $answer,
            AnyStepper::DormandPrince($stepper) => $answer,
            AnyStepper::DormandPrince8($stepper) => $answer,
            AnyStepper::Rodas4($stepper) => $answer,
            AnyStepper::Rodas5P($stepper) => $answer,
            AnyStepper::RungeKutta4($stepper) => $answer,
        }
    };
}

impl<T: Scalar, const N: usize> Stepper<T, N> for AnyStepper<T, N> {
    fn begin<F: Field<T, N>>(&mut self, field: &mut F, point: &mut Point<T, N>) {
        of_the_method!(self, stepper => stepper.begin(field, point));
    }

    #[inline]
    fn step(&mut self, field: &mut impl Field<T, N>, from: &Point<T, N>, h: T) -> TrialStep<T, N> {
        of_the_method!(self, stepper => stepper.step(field, from, h))
    }

    #[inline]
    fn arrive<F: Field<T, N>>(&mut self, field: &mut F, end: &mut Point<T, N>) {
        of_the_method!(self, stepper => stepper.arrive(field, end));
    }

    #[inline]
    fn represents_growth(&self) -> bool {
        of_the_method!(self, stepper => stepper.represents_growth())
    }

    #[inline]
    fn jacobians_of_step<F: Field<T, N>>(
        &mut self,
        field: &mut F,
        from: &Point<T, N>,
        end: &Point<T, N>,
    ) -> [SMatrix<T, N, N>; 2] {
        of_the_method!(self, stepper => stepper.jacobians_of_step(field, from, end))
    }

    fn stability(&self) -> &'static [f64] {
        of_the_method!(self, stepper => stepper.stability())
    }

    fn dense_output<F: Field<T, N>>(
        &mut self,
        field: &mut F,
        from: &Point<T, N>,
        end: &Point<T, N>,
    ) -> DenseOutput<T, N> {
        of_the_method!(self, stepper => stepper.dense_output(field, from, end))
    }

    fn accepted(&mut self, step: T, end: &Point<T, N>, proposed: Option<T>) -> Option<T> {
        of_the_method!(self, stepper => stepper.accepted(step, end, proposed))
    }
}
