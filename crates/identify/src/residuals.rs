//! What is fitted: residuals as a function of a few parameters, in any scalar.

use core::ops::RangeInclusive;

use bristle::Scalar;
use bristle::parameter::{Checked, Named};

/// A parameter to be found: its name, its bounds, and where the search starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Name.
    pub name: &'static str,
    /// Unit, empty for a pure number.
    pub unit: &'static str,
    /// Where the search starts.
    pub start: f64,
    /// Lower bound, finite; positive on a logarithmic scale.
    pub least: f64,
    /// Upper bound, finite.
    pub most: f64,
    /// Typical magnitude, positive: the unit in which the value is searched. `None` searches the
    /// logarithm of the value: for a positive quantity whose magnitude is known roughly.
    pub typical: Option<f64>,
}

impl Parameter {
    /// A positive parameter on a logarithmic scale, with bounds at a factor below and above its
    /// start, as far as a parameter may go: to 10⁻¹⁰⁰ and 10¹⁰⁰.
    pub fn positive(name: &'static str, unit: &'static str, start: f64, factor: f64) -> Self {
        let least = Named::<f64>::smallest();
        let bounds = (start / factor).max(least)..=(start * factor).min(1.0 / least);
        Self::logarithmic(name, unit, start, bounds)
    }

    /// A positive parameter within bounds on a logarithmic scale.
    pub fn logarithmic(
        name: &'static str,
        unit: &'static str,
        start: f64,
        bounds: RangeInclusive<f64>,
    ) -> Self {
        let (least, most) = bounds.into_inner();
        Self { name, unit, start, least, most, typical: None }
    }

    /// A parameter within bounds that is searched in units of its typical magnitude.
    pub fn scaled(
        name: &'static str,
        unit: &'static str,
        start: f64,
        bounds: RangeInclusive<f64>,
        typical: f64,
    ) -> Self {
        Self { typical: Some(typical), ..Self::logarithmic(name, unit, start, bounds) }
    }
}

/// Residuals of a model with N parameters, generic over the scalar so that dual numbers can
/// differentiate them.
///
/// [`least_squares`](super::least_squares) minimises Σ r². For friction along a log implement
/// [`Candidate`](super::Candidate) instead.
///
/// ```
/// use bristle_identify as identify;
/// use bristle_identify::{Parameter, Residuals, SearchSettings};
/// use bristle::{ParameterError, Scalar};
/// use core::ops::ControlFlow;
///
/// /// y = a e^(−b x), measured at three places.
/// struct Decay;
///
/// impl Residuals<2> for Decay {
///     fn evaluate<T: Scalar>(
///         &self,
///         &[a, b]: &[T; 2],
///         each: &mut impl FnMut(T),
///     ) -> Result<(), ParameterError> {
///         for (x, y) in [(0.0, 2.0), (1.0, 1.0), (2.0, 0.5)] {
///             let [x, y]: [T; 2] = [x, y].map(nalgebra::convert);
///             each(a * (-b * x).exp() - y);
///         }
///         Ok(())
///     }
/// }
///
/// let mut go_on = |_: &identify::SearchProgress<'_>| ControlFlow::Continue(());
/// let parameters =
///     [Parameter::positive("a", "", 1.0, 1e3), Parameter::positive("b", "1/s", 1.0, 1e3)];
/// let fit = identify::least_squares(&Decay, parameters, &SearchSettings::default(), &mut go_on)?;
/// let [a, b] = fit.array();
/// assert!((a - 2.0).abs() < 1e-6 && (b - 2_f64.ln()).abs() < 1e-6);
/// # Ok::<(), ParameterError>(())
/// ```
pub trait Residuals<const N: usize> {
    /// Passes every residual to `each`, always the same number in the same order. The standard
    /// errors need the order of time, if there is one.
    ///
    /// # Errors
    ///
    /// Parameters that the model refuses. The search then takes a shorter step.
    fn evaluate<T: Scalar>(&self, values: &[T; N], each: &mut impl FnMut(T)) -> Checked<()>;
}
