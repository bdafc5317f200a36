//! What the Rosenbrock methods share: stages that each solve one linear system with the same matrix.
//!
//! (I/(hγ) − J) Uᵢ = f(t + αᵢh, x + Σ aᵢⱼ Uⱼ) + Σ (cᵢⱼ/h) Uⱼ + h γᵢ ∂f/∂t,  J = ∂f/∂x,
//!
//! and x + Σ mⱼ Uⱼ at the end. Nothing is iterated; an exact Jacobian is part of the method's order.
//!
//! Source: E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", 2nd edition
//! (Springer, 1996), section IV.7, equation (7.25).

use nalgebra::{SMatrix, SVector};

use super::method::{Attempt, Field, Point};
use super::system::Linearisation;
use crate::Scalar;
use crate::scalar::{lit, nan};

/// The coefficients of a method of S stages.
pub(super) struct Tableau<const S: usize> {
    pub(super) gamma: f64,
    /// Times αᵢ of the stages.
    pub(super) times: [f64; S],
    /// Weights γᵢ of ∂f/∂t.
    pub(super) time_weights: [f64; S],
    /// aᵢⱼ, of which the last row is that of the last stage; the solution is its state plus U_s.
    pub(super) a: [[f64; S]; S],
    /// The first stage whose state is that of the stage before plus its U, as it then is of all that
    /// follow.
    pub(super) chained: usize,
    /// cᵢⱼ.
    pub(super) c: [[f64; S]; S],
}

/// What a Rosenbrock method keeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stages<T: Scalar, const N: usize, const S: usize> {
    pub(super) u: [SVector<T, N>; S],
    /// The derivatives where the next step starts.
    pub(super) tangent: Linearisation<T, N>,
    /// The derivatives where the last trial ends.
    pub(super) at_end: Linearisation<T, N>,
}

impl<T: Scalar, const N: usize, const S: usize> Stages<T, N, S> {
    pub(super) fn new() -> Self {
        let tangent = Linearisation {
            rate: SVector::zeros(),
            by_state: SMatrix::zeros(),
            by_time: SVector::zeros(),
        };
        Self { u: [SVector::zeros(); S], tangent, at_end: tangent }
    }

    pub(super) fn begin<F: Field<T, N>>(&mut self, field: &mut F, point: &mut Point<T, N>) {
        self.tangent = field.linearised(point.time, &point.state);
        point.rate = self.tangent.rate;
    }

    #[inline]
    pub(super) fn arrive<F: Field<T, N>>(&mut self, field: &mut F, end: &mut Point<T, N>) {
        self.at_end = field.linearised(end.time, &end.state);
        end.rate = self.at_end.rate;
    }

    /// A trial step. The last stage is the error estimate.
    #[inline(always)]
    pub(super) fn attempt<F: Field<T, N>>(
        &mut self,
        tableau: &Tableau<S>,
        field: &mut F,
        from: &Point<T, N>,
        step: T,
        order: u8,
    ) -> Attempt<T, N> {
        let per_step = T::one() / step;
        let matrix = Factors::of_shifted(&self.tangent.by_state, per_step / lit(tableau.gamma));
        let first: T = lit(tableau.time_weights[0]);
        self.u[0] = matrix.solve(self.tangent.rate + self.tangent.by_time * (step * first));
        let mut stage = Stage { tableau, from, step, per_step, matrix, state: from.state };
        // One by one, so that the sums over the stages before have known lengths.
        stage.solve::<F, 1>(self, field);
        stage.solve::<F, 2>(self, field);
        stage.solve::<F, 3>(self, field);
        stage.solve::<F, 4>(self, field);
        stage.solve::<F, 5>(self, field);
        stage.solve::<F, 6>(self, field);
        stage.solve::<F, 7>(self, field);
        let error = self.u[S - 1];
        Attempt { state: stage.state + error, error, coarse_error: None, order }
    }
}

/// What the stages of one trial step have in common.
struct Stage<'a, T: Scalar, const N: usize, const S: usize> {
    tableau: &'a Tableau<S>,
    from: &'a Point<T, N>,
    step: T,
    per_step: T,
    matrix: Factors<T, N>,
    /// The state at which the last stage was evaluated.
    state: SVector<T, N>,
}

impl<T: Scalar, const N: usize, const S: usize> Stage<'_, T, N, S> {
    /// Solves for stage I, if the method has it.
    #[inline(always)]
    fn solve<F: Field<T, N>, const I: usize>(
        &mut self,
        stages: &mut Stages<T, N, S>,
        field: &mut F,
    ) {
        if I >= S {
            return;
        }
        let Tableau { times, time_weights, a, c, chained, .. } = self.tableau;
        let u = &mut stages.u;
        let sum = |weights: &[f64; S]| -> SVector<T, N> {
            let mut sum = SVector::zeros();
            for (u, &weight) in u.iter().zip(weights).take(I) {
                sum += u * lit::<T>(weight);
            }
            sum
        };
        self.state =
            if I >= *chained { self.state + u[I - 1] } else { self.from.state + sum(&a[I]) };
        let mut right = field.rate(self.from.time + self.step * lit::<T>(times[I]), &self.state);
        right += sum(&c[I]) * self.per_step;
        if time_weights[I] != 0.0 {
            right += stages.tangent.by_time * (self.step * lit::<T>(time_weights[I]));
        }
        u[I] = self.matrix.solve(right);
    }
}

/// A pivot of which cancellation leaves less than this part is no pivot.
const WORN: f64 = 1e-4;

/// The factors of sI − J, eliminated in the order of the states.
///
/// No row is exchanged: a pivot vanishes only where the first few states alone, the others held,
/// would grow by e⁴ or so within the step. No such step is accurate; the answer is NaN, and it is
/// taken again, shorter.
struct Factors<T: Scalar, const N: usize> {
    /// Below the diagonal the multipliers, on it the reciprocal pivots.
    lu: SMatrix<T, N, N>,
}

impl<T: Scalar, const N: usize> Factors<T, N> {
    #[inline(always)]
    fn of_shifted(jacobian: &SMatrix<T, N, N>, shift: T) -> Self {
        let mut lu = -jacobian;
        for i in 0..N {
            lu[(i, i)] += shift;
        }
        for k in 0..N {
            let before = shift.abs() + jacobian[(k, k)].abs();
            let pivot = lu[(k, k)];
            let sound = pivot.abs() > before * lit(WORN);
            let inverse = if sound { T::one() / pivot } else { nan() };
            lu[(k, k)] = inverse;
            for i in k + 1..N {
                let multiplier = lu[(i, k)] * inverse;
                lu[(i, k)] = multiplier;
                for j in k + 1..N {
                    let row = lu[(k, j)];
                    lu[(i, j)] -= multiplier * row;
                }
            }
        }
        Self { lu }
    }

    #[inline(always)]
    fn solve(&self, mut x: SVector<T, N>) -> SVector<T, N> {
        for i in 1..N {
            for j in 0..i {
                let below = x[j];
                x[i] -= self.lu[(i, j)] * below;
            }
        }
        for i in (0..N).rev() {
            for j in i + 1..N {
                let above = x[j];
                x[i] -= self.lu[(i, j)] * above;
            }
            x[i] *= self.lu[(i, i)];
        }
        x
    }
}

/// What a method of S stages makes of its tableau. `extension` gives the terms of the curve through a step from
/// the U of its stages and its rise.
macro_rules! rosenbrock_method {
    ($method:ident, stages: $stages:literal, order: $order:literal) => {
        impl Embedded for $method {}

        impl<T: Scalar, const N: usize> Method<T, N> for $method {
            type Memory = Stages<T, N, $stages>;

            fn scheme(&self) -> Option<Scheme> {
                Some(Scheme::Rosenbrock)
            }

            fn memory(&self) -> Self::Memory {
                Stages::new()
            }

            fn begin<F: Field<T, N>>(
                &self,
                stages: &mut Self::Memory,
                field: &mut F,
                point: &mut Point<T, N>,
            ) {
                stages.begin(field, point);
            }

            #[inline]
            fn attempt<F: Field<T, N>>(
                &self,
                stages: &mut Self::Memory,
                field: &mut F,
                from: &Point<T, N>,
                step: T,
            ) -> Attempt<T, N> {
                stages.attempt(&TABLEAU, field, from, step, $order)
            }

            #[inline]
            fn arrive<F: Field<T, N>>(
                &self,
                stages: &mut Self::Memory,
                field: &mut F,
                end: &mut Point<T, N>,
            ) {
                stages.arrive(field, end);
            }

            fn curve<F: Field<T, N>>(
                &self,
                stages: &Self::Memory,
                _field: &mut F,
                from: &Point<T, N>,
                end: &Point<T, N>,
            ) -> Curve<T, N> {
                Curve::new(from.state, &extension(&stages.u, end.state - from.state))
            }

            #[inline]
            fn accepted<F: Field<T, N>>(
                &self,
                stages: &mut Self::Memory,
                _field: &mut F,
                _from: &Point<T, N>,
                _end: &Point<T, N>,
                proposed: Option<T>,
            ) -> Option<T> {
                stages.tangent = stages.at_end;
                proposed
            }
        }
    };
}

pub(super) use rosenbrock_method;

/// What every such method's coefficients must keep, whatever its order.
#[cfg(test)]
pub(super) mod laws {
    use super::Tableau;
    use crate::ode::trees::{Rosenbrock, trees};

    fn method<const S: usize>(tableau: &Tableau<S>) -> Rosenbrock {
        Rosenbrock::new(tableau.gamma, &tableau.a, &tableau.c)
    }

    /// Weights of the U in the solution: those of the last stage's state, and one.
    pub(in crate::ode) fn solution<const S: usize>(tableau: &Tableau<S>) -> [f64; S] {
        let mut weights = tableau.a[S - 1];
        weights[S - 1] = 1.0;
        weights
    }

    /// Weights of the U in the error estimate, which is the last of them.
    fn estimate<const S: usize>() -> [f64; S] {
        let mut weights = [0.0; S];
        weights[S - 1] = 1.0;
        weights
    }

    /// The stages lie where their weights say.
    pub(in crate::ode) fn times<const S: usize>(tableau: &Tableau<S>) {
        let method = method(tableau);
        for stage in 0..S {
            let time: f64 = method.alpha[stage].iter().sum();
            assert!((time - tableau.times[stage]).abs() < 1e-13, "{stage}: {time}");
            let weight = method.time_weight(stage);
            assert!((weight - tableau.time_weights[stage]).abs() < 1e-13, "{stage}: {weight}");
        }
    }

    /// The solution meets every condition up to an order and no further.
    pub(in crate::ode) fn order<const S: usize>(tableau: &Tableau<S>, order: usize) {
        let (method, solution) = (method(tableau), solution(tableau));
        for tree in trees(order) {
            let defect = method.weighted(&tree, &solution) - 1.0 / tree.density();
            assert!(defect.abs() < 1e-13, "{tree:?}: {defect}");
        }
        let next = trees(order + 1).into_iter().filter(|tree| tree.order() == order + 1);
        let defect = next.map(|tree| method.weighted(&tree, &solution) - 1.0 / tree.density());
        assert!(defect.fold(0.0, |most, defect| f64::max(most, defect.abs())) > 1e-5);
    }

    /// The error estimate vanishes up to an order and no further.
    pub(in crate::ode) fn estimate_order<const S: usize>(tableau: &Tableau<S>, order: usize) {
        let (method, weights) = (method(tableau), estimate::<S>());
        for tree in trees(order) {
            let defect = method.weighted(&tree, &weights);
            assert!(defect.abs() < 1e-13, "{tree:?}: {defect}");
        }
        let next = trees(order + 1).into_iter().filter(|tree| tree.order() == order + 1);
        let greatest = next.map(|tree| method.weighted(&tree, &weights).abs()).fold(0.0, f64::max);
        assert!(greatest > 1e-4, "{greatest}");
    }

    /// The last stage is the solution: R(∞) = 0, for the estimate too.
    pub(in crate::ode) fn stiff_accuracy<const S: usize>(tableau: &Tableau<S>) {
        let method = method(tableau);
        let weights = method.weights(&solution(tableau));
        for (beta, weight) in method.beta[S - 1].iter().zip(&weights) {
            assert!((beta - weight).abs() < 1e-13, "{beta} {weight}");
        }
    }

    /// A state that follows from the one before is the one that its weights say.
    pub(in crate::ode) fn chain<const S: usize>(tableau: &Tableau<S>) {
        for stage in tableau.chained..S {
            let mut before = tableau.a[stage - 1];
            before[stage - 1] = 1.0;
            assert_eq!(tableau.a[stage], before);
        }
    }

    /// The continuous extension meets every condition up to an order within the step.
    pub(in crate::ode) fn extension<const S: usize>(
        tableau: &Tableau<S>,
        terms: &[&[f64]],
        order: usize,
    ) {
        for theta in [0.1, 0.37, 0.5, 0.9] {
            for tree in trees(order) {
                let got = method(tableau).extended(&tree, theta, terms);
                let want = theta.powi(tree.order() as i32) / tree.density();
                assert!((got - want).abs() < 1e-13, "{theta} {tree:?}: {}", got - want);
            }
        }
    }
}
