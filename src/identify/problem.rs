//! A least-squares problem in its search variables.
//!
//! The search variable of a positive parameter is its logarithm, that of any other parameter its
//! value over a typical magnitude.

use nalgebra::{Const, SVector, U1};
use num_dual::DualSVec64;

use super::Identifiability;
use super::residuals::{Parameter, Residuals};
use super::triangle::Triangle;
use crate::parameter::{self, ParameterError, Rule};

/// Values of the search variables.
pub(super) type Point<const N: usize> = SVector<f64, N>;

/// The search variable of a value.
fn coordinate(parameter: &Parameter, value: f64) -> f64 {
    parameter.typical.map_or_else(|| value.ln(), |typical| value / typical)
}

/// Residuals with their parameters, and the bounds of the search variables.
pub(super) struct Problem<'a, R, const N: usize> {
    pub(super) residuals: &'a R,
    pub(super) parameters: [Parameter; N],
    pub(super) least: Point<N>,
    pub(super) most: Point<N>,
}

impl<'a, R: Residuals<N>, const N: usize> Problem<'a, R, N> {
    /// Checks starts and bounds.
    pub(super) fn new(
        residuals: &'a R,
        parameters: [Parameter; N],
    ) -> Result<Self, ParameterError> {
        for Parameter { name, start, least, most, typical, .. } in parameters {
            parameter::finite("least", least)?;
            parameter::finite("most", most)?;
            let inside = least <= start && start <= most;
            parameter::check(name, start, inside, Rule::Between { least, most })?;
            let unit = typical.unwrap_or(least);
            let rule = "have a positive lower bound or typical magnitude";
            parameter::stated(name, unit, unit > 0.0 && unit.is_finite(), rule)?;
        }
        let point = |of: fn(&Parameter) -> f64| parameters.map(|p| coordinate(&p, of(&p))).into();
        Ok(Self { residuals, parameters, least: point(|p| p.least), most: point(|p| p.most) })
    }

    pub(super) fn start(&self) -> Point<N> {
        self.parameters.map(|parameter| coordinate(&parameter, parameter.start)).into()
    }

    pub(super) fn values(&self, point: &Point<N>) -> [f64; N] {
        core::array::from_fn(|i| {
            let Parameter { least, most, typical, .. } = self.parameters[i];
            match typical {
                // At a bound to the last digit, where the exponential rounds.
                _ if point[i] <= self.least[i] => least,
                _ if point[i] >= self.most[i] => most,
                Some(typical) => point[i] * typical,
                None => point[i].exp(),
            }
        })
    }

    /// Derivatives of the values with respect to the search variables.
    pub(super) fn slopes(&self, point: &Point<N>) -> Point<N> {
        let values = self.values(point);
        Point::from_fn(|i, _| self.parameters[i].typical.unwrap_or(values[i]))
    }

    /// Σ r²; infinite where the model has no finite answer.
    pub(super) fn cost(&self, point: &Point<N>) -> f64 {
        let mut cost = 0.0;
        match self.residuals.evaluate(&self.values(point), &mut |r: f64| cost += r * r) {
            Ok(()) if cost.is_finite() => cost,
            _ => f64::INFINITY,
        }
    }

    /// Passes on every residual with its gradient in the search variables. Returns whether all are
    /// finite.
    pub(super) fn rows(&self, point: &Point<N>, mut each: impl FnMut(f64, &Point<N>)) -> bool {
        let values = self.values(point);
        let duals: [DualSVec64<N>; N] =
            core::array::from_fn(|i| DualSVec64::from_re(values[i]).derivative(i));
        let slopes = self.slopes(point);
        let mut finite = true;
        let done = self.residuals.evaluate(&duals, &mut |r: DualSVec64<N>| {
            let gradient = r.eps.unwrap_generic(Const::<N>, U1).component_mul(&slopes);
            finite &= r.re.is_finite() && gradient.iter().all(|x| x.is_finite());
            each(r.re, &gradient);
        });
        finite && done.is_ok()
    }

    /// The linear problem J δ ≈ −r at a point, if it is finite.
    pub(super) fn linearised(&self, point: &Point<N>) -> Option<Triangle<N>> {
        let mut triangle = Triangle::new();
        self.rows(point, |residual, gradient| triangle.push(*gradient, -residual))
            .then_some(triangle)
    }

    /// Which parameters cannot move, and why: fixed, or at a bound that the descent points beyond.
    pub(super) fn resting(
        &self,
        point: &Point<N>,
        descent: &Point<N>,
    ) -> [Option<Identifiability>; N] {
        core::array::from_fn(|i| {
            if self.least[i] >= self.most[i] {
                Some(Identifiability::Fixed)
            } else if point[i] <= self.least[i] && descent[i] <= 0.0 {
                Some(Identifiability::AtLowerBound)
            } else if point[i] >= self.most[i] && descent[i] >= 0.0 {
                Some(Identifiability::AtUpperBound)
            } else {
                None
            }
        })
    }
}
