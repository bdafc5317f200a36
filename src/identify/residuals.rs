//! What is fitted: residuals as a function of a few parameters, in any scalar.

use core::fmt::Debug;

use crate::{Bristle, ParameterError, Scalar};

use super::InitialGuess;

/// How a parameter is searched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scaling {
    /// By itself, in units of a typical magnitude, positive.
    Linear {
        /// The typical magnitude.
        typical: f64,
    },
    /// By its logarithm: for a positive quantity known at first to a decade or so.
    Logarithmic,
}

/// A parameter to be found: what it is, where to look, where to begin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Name.
    pub name: &'static str,
    /// Unit, empty for a pure number.
    pub unit: &'static str,
    /// Where the search begins.
    pub start: f64,
    /// Lower bound, finite; above zero on a logarithmic scale.
    pub least: f64,
    /// Upper bound, finite.
    pub most: f64,
    /// How it is searched.
    pub scaling: Scaling,
}

impl Parameter {
    /// A positive parameter on a logarithmic scale, within a factor around its start.
    pub fn positive(name: &'static str, unit: &'static str, start: f64, factor: f64) -> Self {
        let (least, most) = (start / factor, start * factor);
        Self { name, unit, start, least, most, scaling: Scaling::Logarithmic }
    }
}

/// A value within bounds. Unlike `clamp` it lets what is not a number through, for the search to refuse by name, and does
/// not panic at bounds that are none.
pub(super) fn within<T: Scalar>(value: T, least: T, most: T) -> T {
    if value < least {
        least
    } else if value > most {
        most
    } else {
        value
    }
}

/// Residuals of a model with N parameters, generic over the scalar so that dual numbers differentiate them.
///
/// [`least_squares`](super::least_squares) makes Σ r² least. For friction along a log implement [`Candidate`] instead.
///
/// ```
/// use bristle::identify::{self, Parameter, Residuals, Scaling, Settings};
/// use bristle::{ParameterError, Scalar};
/// use core::ops::ControlFlow;
///
/// /// y = a e^(−b x), measured at three places.
/// struct Decay;
///
/// impl Residuals<2> for Decay {
///     fn parameters(&self) -> [Parameter; 2] {
///         [Parameter::positive("a", "", 1.0, 1e3), Parameter::positive("b", "1/s", 1.0, 1e3)]
///     }
///     fn evaluate<T: Scalar>(&self, values: &[T; 2], each: &mut impl FnMut(T)) -> Result<(), ParameterError> {
///         for (x, y) in [(0.0, 2.0), (1.0, 1.0), (2.0, 0.5)] {
///             let [x, y]: [T; 2] = [nalgebra::convert(x), nalgebra::convert(y)];
///             each(values[0] * (-values[1] * x).exp() - y);
///         }
///         Ok(())
///     }
/// }
///
/// let fit = identify::least_squares(&Decay, &Settings::default(), &mut |_| ControlFlow::Continue(()))?;
/// assert!((fit.values()[0] - 2.0).abs() < 1e-6 && (fit.values()[1] - 2_f64.ln()).abs() < 1e-6);
/// # Ok::<(), identify::IdentifyError>(())
/// ```
pub trait Residuals<const N: usize> {
    /// The parameters and where to look for them.
    fn parameters(&self) -> [Parameter; N];

    /// Hands every residual to `each`, always as many and in the same order: that of time, if there is one, for
    /// the standard errors.
    ///
    /// # Errors
    ///
    /// Parameters that the model refuses; the search then takes a shorter step.
    fn evaluate<T: Scalar>(
        &self,
        values: &[T; N],
        each: &mut impl FnMut(T),
    ) -> Result<(), ParameterError>;
}

/// A friction model with N parameters to be found: write one for a model of your own.
///
/// ```
/// use bristle::identify::{Candidate, Parameter, InitialGuess};
/// use bristle::{Dahl, DahlParameters, ParameterError, Scalar};
///
/// /// Dahl's model.
/// #[derive(Debug)]
/// struct JustDahl;
///
/// impl Candidate<2> for JustDahl {
///     type Model<T: Scalar> = Dahl<T>;
///
///     fn parameters(&self, rough: &InitialGuess) -> [Parameter; 2] {
///         [
///             Parameter::positive("dynamic_coefficient", "", rough.dynamic_coefficient, 10.0),
///             Parameter::positive("micro_stiffness", "1/m", rough.micro_stiffness, 100.0),
///         ]
///     }
///
///     fn model<T: Scalar>(&self, &[dynamic_coefficient, micro_stiffness]: &[T; 2]) -> Result<Dahl<T>, ParameterError> {
///         Dahl::new(DahlParameters { dynamic_coefficient, micro_stiffness })
///     }
/// }
/// ```
pub trait Candidate<const N: usize>: Debug {
    /// The model, in any scalar.
    type Model<T: Scalar>: Bristle<T>;

    /// The parameters, with starts and bounds from what the data tell at a glance.
    fn parameters(&self, rough: &InitialGuess) -> [Parameter; N];

    /// The model with these parameters.
    ///
    /// # Errors
    ///
    /// Parameters out of their ranges.
    fn model<T: Scalar>(&self, values: &[T; N]) -> Result<Self::Model<T>, ParameterError>;

    /// What the sensor adds to the friction coefficient \[–\]: zero, or one of the parameters.
    fn offset<T: Scalar>(&self, values: &[T; N]) -> T {
        let _ = values;
        T::zero()
    }
}
