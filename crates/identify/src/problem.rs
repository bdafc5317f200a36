//! A least-squares problem in its search variables.
//!
//! The search variable of a positive parameter is its logarithm, that of any other parameter its
//! value over a typical magnitude. The number of parameters is known at run time. A run with dual
//! numbers carries one derivative and takes as long as one and a half without: eight at a time, in
//! one dual number, take twice as long as eight runs.

use nalgebra::DVector;
use num_dual::Dual64;

use super::Identifiability;
use super::residuals::{Parameter, Residuals};
use super::triangle::Triangle;
use bristle::Scalar;
use bristle::parameter::{Checked, Named, Rule};

/// Values of the search variables.
pub(super) type Point = DVector<f64>;

/// Residuals as a function of parameters whose number is known at run time.
pub(super) trait Objective {
    /// Passes every residual to `each`, see [`Residuals::evaluate`].
    fn evaluate<T: Scalar>(&self, values: &[T], each: &mut impl FnMut(T)) -> Checked<()>;

    /// Passes every residual as it depends on one parameter alone: zero if it does not.
    fn evaluate_by<T: Scalar>(
        &self,
        values: &[T],
        _parameter: usize,
        each: &mut impl FnMut(T),
    ) -> Checked<()> {
        self.evaluate(values, each)
    }

    /// Σ r²; infinite where the model has no finite answer.
    fn cost(&self, values: &[f64]) -> f64 {
        let mut cost = 0.0;
        match self.evaluate(values, &mut |r: f64| cost += r * r) {
            Ok(()) if cost.is_finite() => cost,
            _ => f64::INFINITY,
        }
    }
}

/// Takes values as the starts of parameters.
pub(super) fn begin_at(parameters: &mut [Parameter], values: &[f64]) {
    for (parameter, &value) in parameters.iter_mut().zip(values) {
        parameter.start = value;
    }
}

/// Residuals of N parameters.
pub(super) struct Counted<'a, R, const N: usize>(pub(super) &'a R);

impl<R: Residuals<N>, const N: usize> Objective for Counted<'_, R, N> {
    fn evaluate<T: Scalar>(&self, values: &[T], each: &mut impl FnMut(T)) -> Checked<()> {
        match values.try_into() {
            Ok(values) => self.0.evaluate(values, each),
            Err(_) => Named("parameters", values.len()).count(N),
        }
    }
}

/// Residuals at a point, and their gradients in the search variables.
pub(super) struct Rows {
    pub(super) rows: Vec<(f64, Point)>,
    /// Whether all numbers are finite.
    pub(super) finite: bool,
}

impl Rows {
    /// The linear problem J δ ≈ −r of so many search variables.
    pub(super) fn linear(&self, width: usize) -> Triangle {
        let mut triangle = Triangle::new(width);
        for (residual, gradient) in &self.rows {
            triangle.push(&mut gradient.clone(), -residual);
        }
        triangle
    }
}

/// Residuals with their parameters, and start and bounds of the search variables.
pub(super) struct Problem<'a, R> {
    pub(super) residuals: &'a R,
    pub(super) parameters: &'a [Parameter],
    pub(super) start: Point,
    pub(super) least: Point,
    pub(super) most: Point,
}

impl<'a, R: Objective> Problem<'a, R> {
    /// Checks starts and bounds.
    pub(super) fn new(residuals: &'a R, parameters: &'a [Parameter]) -> Checked<Self> {
        for &Parameter { name, start, least, most, typical, .. } in parameters {
            Named(name, least).finite()?;
            Named(name, most).finite()?;
            let inside = least <= start && start <= most;
            Named(name, start).check(inside, Rule::Between { least, most })?;
            let unit = typical.unwrap_or(least);
            let rule = "have a positive lower bound or typical magnitude";
            Named(name, unit).stated(unit > 0.0 && unit.is_finite(), rule)?;
        }
        let point = |of: fn(&Parameter) -> f64| {
            let variable = |p: &Parameter| p.typical.map_or_else(|| of(p).ln(), |it| of(p) / it);
            Point::from_iterator(parameters.len(), parameters.iter().map(variable))
        };
        let (start, least, most) = (point(|p| p.start), point(|p| p.least), point(|p| p.most));
        Ok(Self { residuals, parameters, start, least, most })
    }

    /// A point within the bounds, component by component. NaN stays, to be refused by name.
    pub(super) fn within(&self, of: impl Fn(usize) -> f64) -> Point {
        let within = |i: usize, _| of(i).larger(self.least[i]).smaller(self.most[i]);
        Point::from_fn(self.parameters.len(), within)
    }

    pub(super) fn values(&self, point: &Point) -> Vec<f64> {
        let value = |(i, &Parameter { least, most, typical, .. }): (usize, &Parameter)| {
            match typical {
                // At a bound to the last digit, where the exponential rounds.
                _ if point[i] <= self.least[i] => least,
                _ if point[i] >= self.most[i] => most,
                Some(typical) => point[i] * typical,
                None => point[i].exp(),
            }
        };
        self.parameters.iter().enumerate().map(value).collect()
    }

    /// Derivatives of the values with respect to the search variables.
    pub(super) fn slopes(&self, values: &[f64]) -> Vec<f64> {
        let slopes = self.parameters.iter().zip(values);
        slopes.map(|(parameter, &value)| parameter.typical.unwrap_or(value)).collect()
    }

    /// Σ r²; infinite where the model has no finite answer.
    pub(super) fn cost(&self, point: &Point) -> f64 {
        self.residuals.cost(&self.values(point))
    }

    /// Every residual with its gradient in the search variables.
    pub(super) fn rows(&self, point: &Point) -> Rows {
        let values = self.values(point);
        let slopes = self.slopes(&values);
        let width = values.len();
        let (mut rows, mut done) = (Vec::<(f64, Point)>::new(), Ok(()));
        // One run at least, for the residuals.
        for run in (0..width).filter(|&i| i == 0 || !self.is_fixed(i)) {
            let seed = |i| f64::from(u8::from(i == run && !self.is_fixed(i)));
            let duals = values.iter().enumerate().map(|(i, &value)| Dual64::new(value, seed(i)));
            let (duals, mut column) = (duals.collect::<Vec<_>>(), Vec::<Dual64>::new());
            let each = &mut |r| column.push(r);
            done = done.and(match run {
                0 => self.residuals.evaluate(&duals, each),
                _ => self.residuals.evaluate_by(&duals, run, each),
            });
            if run == 0 {
                rows.extend(column.iter().map(|r| (r.re, Point::zeros(width))));
            }
            for ((_, gradient), r) in rows.iter_mut().zip(&column) {
                gradient[run] = r.eps * slopes[run];
            }
        }
        let all =
            |(r, gradient): &(f64, Point)| r.is_finite() && gradient.iter().all(|x| x.is_finite());
        Rows { finite: done.is_ok() && rows.iter().all(all), rows }
    }

    /// Whether a parameter has one bound twice.
    fn is_fixed(&self, i: usize) -> bool {
        self.least[i] >= self.most[i]
    }

    /// Which parameters cannot move, and why: fixed, or at a bound that the descent points beyond.
    pub(super) fn resting(&self, point: &Point, descent: &Point) -> Vec<Option<Identifiability>> {
        let rests = |i| {
            if self.is_fixed(i) {
                Some(Identifiability::Fixed)
            } else if point[i] <= self.least[i] && descent[i] <= 0.0 {
                Some(Identifiability::AtLowerBound)
            } else if point[i] >= self.most[i] && descent[i] >= 0.0 {
                Some(Identifiability::AtUpperBound)
            } else {
                None
            }
        };
        (0..self.parameters.len()).map(rests).collect()
    }
}
