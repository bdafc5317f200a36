//! Recursive least squares that forgets within bounds, in the factors of its covariance.
//!
//! y = φᵀθ + e,  P = U D Uᵀ
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | y, e | measurement, and its error with the variance r | unit of y |
//! | φ, θ | regressor, parameters | – |
//! | P, P₀ | covariance of the estimate, and its upper bound | – |
//! | U, D | unit upper triangle, diagonal | – |
//! | n | memory: how many samples count | – |
//!
//! A sample forgets, teaches, and gives back to one parameter i, the next in turn, what forgetting
//! took from its prior. With λ = 1 − 1/n and N parameters:
//!
//! P⁻¹ ← λ P⁻¹ + φφᵀ/r + eᵢeᵢᵀ (λ⁻ᴺ − 1)/P₀ᵢᵢ,  θ ← θ + Pφ (y − φᵀθ)/r
//!
//! so that P ≤ P₀ for every sequence of regressors: no wind-up. Plain forgetting lets P grow
//! without bound while a machine moves at one speed. P₀ is the variance of uniform distributions
//! within the bounds of the parameters. Forgetting along φ alone bounds P, too, but hardly ever
//! forgets what is poorly excited: it left a third of a step in the level of an axis as drag.
//!
//! D never loses its sign, as P itself would in single precision. A parameter that leaves its
//! bounds is set to the bound, and the others move as their covariances with it say.
//!
//! Sources: G. J. Bierman, "Factorization Methods for Discrete Sequential Estimation", Academic
//! Press 1977, chapter V; M. E. Salgado, G. C. Goodwin, R. H. Middleton, "Modified least squares
//! algorithm incorporating exponential resetting and forgetting", Int. J. Control 47 (1988),
//! 477–491; B. Lai, D. S. Bernstein, "Exponential resetting and cyclic resetting recursive least
//! squares", IEEE Control Systems Letters 7 (2023), 985–990; G. C. Goodwin, K. S. Sin, "Adaptive
//! Filtering, Prediction and Control", Prentice-Hall 1984, section 3.7, for the bounds.

use bristle::Scalar;
use bristle::nalgebra::{SMatrix, SVector};
use bristle::parameter::{Checked, Named, ParameterError};
use bristle::scalar::lit;

/// Parameters of [`RecursiveLeastSquares`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecursiveLeastSquaresParameters<T: Scalar, const N: usize> {
    /// The estimate at the beginning, within the bounds.
    pub start: SVector<T, N>,
    /// The least that each parameter may become.
    pub least: SVector<T, N>,
    /// The most that each parameter may become. If it is the least, the parameter is known.
    pub most: SVector<T, N>,
    /// Standard deviation √r of the measurement's error \[unit of y\], positive.
    pub noise: T,
    /// Memory n in samples, at least 2 N: what a sample taught fades with (1 − 1/n) a sample.
    pub memory: T,
}

/// An estimate of N parameters and its covariance.
///
/// ```
/// use bristle::nalgebra::Vector2;
/// use bristle_adaptation::{RecursiveLeastSquares, RecursiveLeastSquaresParameters};
///
/// let mut line = RecursiveLeastSquares::new(RecursiveLeastSquaresParameters {
///     start: Vector2::new(0.0, 0.0),
///     least: Vector2::new(-5.0, -5.0),
///     most: Vector2::new(5.0, 5.0),
///     noise: 0.01_f32,
///     memory: 100.0,
/// })?;
/// for x in [0.0, 0.3, 1.0, 0.7, 0.2] {
///     assert!(line.update(&Vector2::new(1.0, x), 2.0 - 0.5 * x));
/// }
/// assert!((line.estimate() - Vector2::new(2.0, -0.5)).norm() < 1e-3);
/// assert!(!line.update(&Vector2::new(1.0, f32::NAN), 2.0));
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecursiveLeastSquares<T: Scalar, const N: usize> {
    least: SVector<T, N>,
    most: SVector<T, N>,
    /// Diagonal of P₀
    widest: SVector<T, N>,
    /// r
    noise: T,
    /// λ
    kept: T,
    /// λ⁻ᴺ − 1
    returned: T,
    /// i
    turn: usize,
    estimate: SVector<T, N>,
    /// U, of which the upper triangle is used
    factor: SMatrix<T, N, N>,
    /// D
    diagonal: SVector<T, N>,
}

impl<T: Scalar, const N: usize> RecursiveLeastSquares<T, N> {
    /// Checks the parameters. The covariance is that of uniform distributions within the bounds.
    ///
    /// # Errors
    ///
    /// Refuses bounds that are not finite or in the wrong order, a start outside them, a noise that
    /// is not positive and a memory of less than 2 N samples.
    pub fn new(parameters: RecursiveLeastSquaresParameters<T, N>) -> Checked<Self> {
        let RecursiveLeastSquaresParameters { start, least, most, noise, memory } = parameters;
        let bounds = least.iter().zip(most.iter()).zip(start.iter());
        ParameterError::of_components(bounds, |((&least, &most), &start)| {
            Named("least", least).finite()?;
            Named("most", most).at_least("least", least)?;
            Named("most", most).finite()?;
            Named("start", start).at_most("most", most)?;
            Named("start", start).at_least("least", least)
        })?;
        let noise = Named("noise", noise).positive()?;
        let memory = Named("memory", memory).positive()?;
        let memory = Named("memory", memory).at_least("2 N samples", lit(2.0 * N as f64))?;
        let kept = T::one() - T::one() / memory;
        let rule = "be so short that a sample counts: below one over the rounding";
        Named("memory", memory).stated(kept < T::one(), rule)?;
        let all = (0..N).fold(T::one(), |all, _| all * kept);
        let width = most - least;
        let widest = width.component_mul(&width) / lit::<T>(12.0);
        Ok(Self {
            least,
            most,
            widest,
            noise: noise * noise,
            kept,
            returned: T::one() / all - T::one(),
            turn: 0,
            estimate: start,
            factor: SMatrix::identity(),
            diagonal: widest * all,
        })
    }

    /// The parameters θ now.
    pub fn estimate(&self) -> &SVector<T, N> {
        &self.estimate
    }

    /// The covariance P of the estimate, as far as the error is white and of the given noise.
    pub fn covariance(&self) -> SMatrix<T, N, N> {
        self.factor * SMatrix::from_diagonal(&self.diagonal) * self.factor.transpose()
    }

    /// Takes a regressor and its measurement, and says whether it did: if they or what follows from
    /// them are not finite, or the regressor is zero, nothing changes.
    pub fn update(&mut self, regressor: &SVector<T, N>, measured: T) -> bool {
        // What is known is no part of the problem.
        let free = self.widest.map(|variance| variance > T::zero());
        let open = regressor.zip_map(&free, |factor, free| if free { factor } else { T::zero() });
        let mut next = *self;
        next.diagonal /= self.kept;
        next.learn(&open, measured - regressor.dot(&self.estimate), self.noise);
        next.turn = if self.turn + 1 < N { self.turn + 1 } else { 0 };
        for (i, &variance) in self.widest.iter().enumerate() {
            if i == self.turn && variance > T::zero() {
                let unit =
                    SVector::<T, N>::from_fn(|j, _| if j == i { T::one() } else { T::zero() });
                next.learn(&unit, T::zero(), variance / self.returned);
            }
        }
        next.keep_within_bounds();
        let numbers = next.estimate.iter().chain(next.diagonal.iter()).chain(next.factor.iter());
        let sound = numbers.fold(open.norm_squared() > T::zero(), |sound, x| sound & x.is_finite());
        if sound {
            *self = next;
        }
        sound
    }

    /// A measurement of a variance, whose prediction is off by an `error`.
    fn learn(&mut self, regressor: &SVector<T, N>, error: T, mut variance: T) {
        let mut gain = SVector::<T, N>::zeros();
        let columns = self.factor.column_iter_mut().zip(self.diagonal.iter_mut());
        for (j, ((mut column, diagonal), &own)) in columns.zip(regressor.iter()).enumerate() {
            let above = column.iter().zip(regressor.iter()).take(j);
            let f = above.fold(own, |f, (&entry, &factor)| f + entry * factor);
            let (before, g) = (variance, *diagonal * f);
            variance += f * g;
            *diagonal *= before / variance;
            for (entry, gain) in column.iter_mut().zip(gain.iter_mut()).take(j) {
                let old = *entry;
                *entry = old - *gain * (f / before);
                *gain += old * g;
            }
            if let Some(gain) = gain.get_mut(j) {
                *gain = g;
            }
        }
        self.estimate += gain * (error / variance);
    }

    /// Sets what has left its bounds to the bound; the others follow: θⱼ += Pⱼᵢ/Pᵢᵢ Δθᵢ.
    fn keep_within_bounds(&mut self) {
        for i in 0..N {
            let unit = SVector::<T, N>::from_fn(|j, _| if j == i { T::one() } else { T::zero() });
            let off = unit.dot(&(self.within() - self.estimate));
            if off.abs() > T::zero() {
                let column = self.covariance() * unit;
                self.estimate += column * (off / unit.dot(&column));
            }
        }
        // To what is within already the others may have returned, and rounding may be off by one.
        self.estimate = self.within();
    }

    fn within(&self) -> SVector<T, N> {
        let above = self.estimate.zip_map(&self.least, |x, least| x.larger(least));
        above.zip_map(&self.most, |x, most| x.smaller(most))
    }
}
