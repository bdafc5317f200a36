//! Rosenbrock methods, each from its tableau: every stage solves one linear system with the matrix
//! that all stages share,
//!
//! (I/(hγ) − J) Uᵢ = f(t + αᵢh, x + Σ aᵢⱼ Uⱼ) + Σ (cᵢⱼ/h) Uⱼ + h γᵢ ∂f/∂t,  J = ∂f/∂x,
//!
//! and the solution is the state of the last stage plus U of the last stage, which is also the
//! error estimate. Nothing is iterated; an exact Jacobian is part of the method's order.
//!
//! Source: E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", 2nd edition
//! (Springer, 1996), section IV.7, equation (7.25).

use core::fmt::Debug;
use core::marker::PhantomData;

use super::dense_output::DenseOutput;
use super::explicit::{combine, entry, for_each_stage, row};
use super::stepper::{Field, Point, Stepper, TrialStep};
use super::storage::{Entries, States, eliminate, slices, substitute};
use super::system::Linearisation;
use crate::Scalar;
use crate::scalar::lit;

/// The coefficients of a Rosenbrock method.
pub(crate) trait RosenbrockTableau: Debug + Copy {
    /// γ.
    const GAMMA: f64;
    /// Times αᵢ of the stages as fractions of the step.
    const TIMES: &'static [f64];
    /// Weights γᵢ of ∂f/∂t; zero for the stages left out.
    const TIME_WEIGHTS: &'static [f64];
    /// Rows of aᵢⱼ. A stage without a row has the state of the stage before plus its U.
    const WEIGHTS: &'static [&'static [f64]];
    /// Rows of cᵢⱼ.
    const COUPLING: &'static [&'static [f64]];
    /// Weights of the Uⱼ in each further term of the dense output.
    const EXTENSION: &'static [&'static [f64]];
    /// Order of the error estimate.
    const ERROR_ORDER: u8;
}

/// A Rosenbrock method with S stages.
#[derive(Debug, Clone)]
pub(crate) struct Rosenbrock<B, T: Scalar, V: States<T>, const S: usize> {
    u: [V; S],
    /// The right-hand side of the stage solved last.
    right: V,
    /// The derivatives where the next step starts.
    at_start: Linearisation<V, V::Matrix>,
    /// The derivatives where the last trial ends.
    at_end: Linearisation<V, V::Matrix>,
    /// 1/(hγ) of the last trial.
    shift: T,
    /// Whether something grows faster than that where the step starts.
    is_outgrown: bool,
    tableau: PhantomData<B>,
}

/// What the stages of one trial step share.
struct NextStep<'a, T: Scalar, V: States<T>> {
    from: &'a Point<T, V>,
    step: T,
    per_step: T,
    factors: V::Matrix,
    /// The state at which the last stage was evaluated.
    state: V,
}

impl<B: RosenbrockTableau, T: Scalar, V: States<T>, const S: usize> Rosenbrock<B, T, V, S> {
    /// The Jacobian where the next step starts.
    pub(super) fn jacobian(&self) -> &V::Matrix {
        &self.at_start.by_state
    }

    /// Solves for stage I, if the method has it.
    #[inline(always)]
    fn stage<const I: usize>(&mut self, field: &mut impl Field<T, V>, trial: &mut NextStep<T, V>) {
        if I >= S {
            return;
        }
        let states = trial.state.count();
        if I < B::WEIGHTS.len() {
            let [start] = slices(states, [&trial.from.state]);
            let to = &mut trial.state.entries_mut()[..states];
            combine!(self.u, row(B::WEIGHTS, I), states, |i, sum| to[i] = start[i] + sum);
        } else {
            for (entry, &u) in trial.state.entries_mut().iter_mut().zip(self.u[I - 1].entries()) {
                *entry += u;
            }
        }
        let time = trial.from.time + trial.step * lit(const { entry(B::TIMES, I) });
        field.rate_to(time, &trial.state, &mut self.right);
        let weight = const { entry(B::TIME_WEIGHTS, I) };
        let of_time = trial.step * lit(weight);
        let [by_time] = slices(states, [&self.at_start.by_time]);
        let right = &mut self.right.entries_mut()[..states];
        combine!(self.u, row(B::COUPLING, I), states, |i, sum| {
            right[i] += sum * trial.per_step;
            if weight != 0.0 {
                right[i] += by_time[i] * of_time;
            }
        });
        solve::<T, V>(&trial.factors, &self.right, &mut self.u[I]);
    }

    /// The method at the start of a run.
    pub(super) fn new(state: &V) -> Self {
        const { assert!(B::COUPLING.len() == S && B::TIMES.len() == S && S <= 8) };
        const { assert!(B::EXTENSION.len() == 2 || B::EXTENSION.len() == 3) };
        let zero = || V::filled(state.count(), T::zero());
        let unknown = || Linearisation { rate: zero(), by_state: state.matrix(), by_time: zero() };
        Self {
            u: core::array::from_fn(|_| zero()),
            right: zero(),
            at_start: unknown(),
            at_end: unknown(),
            shift: T::zero(),
            is_outgrown: false,
            tableau: PhantomData,
        }
    }
}

impl<B: RosenbrockTableau, T: Scalar, V: States<T>, const S: usize> Stepper<T, V>
    for Rosenbrock<B, T, V, S>
{
    fn begin<F: Field<T, V>>(&mut self, field: &mut F, point: &mut Point<T, V>) {
        self.at_start = field.linearised(point.time, &point.state);
        point.rate.clone_from(&self.at_start.rate);
    }

    #[inline(always)]
    fn step(&mut self, field: &mut impl Field<T, V>, from: &Point<T, V>, h: T) -> TrialStep<T, V> {
        let per_step = T::one() / h;
        self.shift = per_step / lit(B::GAMMA);
        let factors = factorised::<T, V>(from.state.count(), self.jacobian(), self.shift);
        self.is_outgrown = is_outgrown(from.state.count(), factors.entries());
        let first: T = lit(const { entry(B::TIME_WEIGHTS, 0) });
        let (first, Linearisation { rate, by_time, .. }) = (h * first, &self.at_start);
        for i in 0..from.state.count() {
            self.right[i] = rate[i] + by_time[i] * first;
        }
        solve::<T, V>(&factors, &self.right, &mut self.u[0]);
        let mut trial = NextStep { from, step: h, per_step, factors, state: from.state.clone() };
        for_each_stage!(self.stage(field, &mut trial));
        let error = self.u[S - 1].clone();
        let state = error.with(&trial.state, |error, state| state + error);
        TrialStep { state, error, coarse_error: None, order: B::ERROR_ORDER, scalar: PhantomData }
    }

    #[inline]
    fn arrive<F: Field<T, V>>(&mut self, field: &mut F, end: &mut Point<T, V>) {
        self.at_end = field.linearised(end.time, &end.state);
        end.rate.clone_from(&self.at_end.rate);
    }

    #[inline]
    fn represents_growth(&self) -> bool {
        let states = self.right.count();
        let at_end = factorised::<T, V>(states, &self.at_end.by_state, self.shift);
        !self.is_outgrown && !is_outgrown(states, at_end.entries())
    }

    #[inline]
    fn jacobians_of_step<F: Field<T, V>>(
        &mut self,
        _field: &mut F,
        _from: &Point<T, V>,
        _end: &Point<T, V>,
    ) -> [&V::Matrix; 2] {
        [&self.at_start.by_state, &self.at_end.by_state]
    }

    fn dense_output<F: Field<T, V>>(
        &mut self,
        _field: &mut F,
        from: &Point<T, V>,
        end: &Point<T, V>,
    ) -> DenseOutput<T, V> {
        let states = end.state.count();
        macro_rules! term {
            ($index:literal) => {{
                let mut term = V::filled(states, T::zero());
                let to = &mut term.entries_mut()[..states];
                combine!(self.u, row(B::EXTENSION, $index), states, |i, sum| to[i] = sum);
                term
            }};
        }
        let chord = end.state.with(&from.state, |end, start| end - start);
        let mut own = DenseOutput::new(from.state.clone(), [chord, term!(0), term!(1)]);
        if B::EXTENSION.len() > 2 {
            own.push(term!(2));
        }
        own
    }

    #[inline]
    fn accepted(&mut self, _step: T, _end: &Point<T, V>, proposed: Option<T>) -> Option<T> {
        self.at_start.rate.clone_from(&self.at_end.rate);
        self.at_start.by_state.clone_from(&self.at_end.by_state);
        self.at_start.by_time.clone_from(&self.at_end.by_time);
        proposed
    }
}

/// A pivot is refused if cancellation leaves less than this part of its terms.
const WORN: f64 = 1e-4;

/// The factors of sI − J, eliminated in the order of the states: below the diagonal the
/// multipliers, on it the reciprocal pivots.
///
/// Rows are not exchanged: a pivot vanishes only where the first few states alone, the others held,
/// would grow by about e⁴ within the step. Such a step is not accurate: the result is NaN, and the
/// driver tries a shorter one.
#[inline(always)]
fn factorised<T: Scalar, V: States<T>>(states: usize, jacobian: &V::Matrix, shift: T) -> V::Matrix {
    let mut lu = jacobian.clone();
    lu.entries_mut().iter_mut().for_each(|entry| *entry = -*entry);
    for i in 0..states {
        lu.entries_mut()[i * states + i] += shift;
    }
    for k in 0..states {
        let before = shift + jacobian.entries()[k * states + k].abs();
        eliminate(states, lu.entries_mut(), k, |pivot| {
            let sound = pivot.abs() > before * lit(WORN);
            if sound { T::one() / pivot } else { T::nan() }
        });
    }
    lu
}

/// Whether an odd number of real eigenvalues of J lie beyond s, from the sign of the determinant
/// of sI − J.
///
/// With s = 1/(hγ) a solution of the test equation ẋ = λx then grows by more than e^(1/γ) over the
/// step, while that of the method changes its sign or dies out, as one with λ < 0 does: a breakaway
/// from a rest that has become unstable would be missed, without an error to estimate.
fn is_outgrown<T: Scalar>(states: usize, lu: &[T]) -> bool {
    (0..states).fold(false, |is_odd, i| is_odd ^ (lu[i * states + i] < T::zero()))
}

/// Solves (sI − J) x = right by the factors.
#[inline(always)]
fn solve<T: Scalar, V: States<T>>(lu: &V::Matrix, right: &V, x: &mut V) {
    x.clone_from(right);
    substitute(lu.entries(), x.entries_mut());
}

/// The laws that every tableau keeps, whatever its order.
#[cfg(test)]
pub(super) mod laws {
    extern crate std;
    use super::RosenbrockTableau;
    use crate::ode::explicit::trees::{Rosenbrock, trees};
    use std::vec::Vec;

    /// All rows of aᵢⱼ, those that follow from the row before included.
    fn rows<B: RosenbrockTableau>() -> Vec<Vec<f64>> {
        let mut rows: Vec<Vec<f64>> = B::WEIGHTS.iter().map(|row| row.to_vec()).collect();
        while rows.len() < B::TIMES.len() {
            let mut next = rows[rows.len() - 1].clone();
            next.push(1.0);
            rows.push(next);
        }
        rows
    }

    fn method<B: RosenbrockTableau>() -> Rosenbrock {
        Rosenbrock::new(B::GAMMA, &rows::<B>(), B::COUPLING)
    }

    /// Weights of the U in the solution: those of the last stage's state, and one.
    fn solution<B: RosenbrockTableau>() -> Vec<f64> {
        let mut weights = rows::<B>()[B::TIMES.len() - 1].clone();
        weights.push(1.0);
        weights
    }

    /// The stages lie where their weights say.
    pub(in crate::ode) fn times<B: RosenbrockTableau>() {
        let method = method::<B>();
        for (stage, &wanted) in B::TIMES.iter().enumerate() {
            let time: f64 = method.alpha[stage].iter().sum();
            assert!((time - wanted).abs() < 1e-13, "{stage}: {time}");
            let weight = method.time_weight(stage);
            let wanted = B::TIME_WEIGHTS.get(stage).unwrap_or(&0.0);
            assert!((weight - wanted).abs() < 1e-13, "{stage}: {weight}");
        }
    }

    /// The solution meets every condition up to an order and no further.
    pub(in crate::ode) fn order<B: RosenbrockTableau>(order: usize) {
        let (method, solution) = (method::<B>(), solution::<B>());
        for tree in trees(order) {
            let defect = method.weighted(&tree, &solution) - 1.0 / tree.density();
            assert!(defect.abs() < 1e-13, "{tree:?}: {defect}");
        }
        let next = trees(order + 1).into_iter().filter(|tree| tree.order() == order + 1);
        let defect = next.map(|tree| method.weighted(&tree, &solution) - 1.0 / tree.density());
        assert!(defect.fold(0.0, |most, defect| f64::max(most, defect.abs())) > 1e-5);
    }

    /// The error estimate vanishes up to an order and no further.
    pub(in crate::ode) fn estimate<B: RosenbrockTableau>(order: usize) {
        let (method, stages) = (method::<B>(), B::TIMES.len());
        let weights: Vec<f64> = (1..=stages).map(|i| f64::from(u8::from(i == stages))).collect();
        for tree in trees(order) {
            let defect = method.weighted(&tree, &weights);
            assert!(defect.abs() < 1e-13, "{tree:?}: {defect}");
        }
        let next = trees(order + 1).into_iter().filter(|tree| tree.order() == order + 1);
        let greatest = next.map(|tree| method.weighted(&tree, &weights).abs()).fold(0.0, f64::max);
        assert!(greatest > 1e-4, "{greatest}");
    }

    /// The last stage is the solution: R(∞) = 0, for the estimate too.
    pub(in crate::ode) fn stiff_accuracy<B: RosenbrockTableau>() {
        let method = method::<B>();
        let weights = method.weights(&solution::<B>());
        for (beta, weight) in method.beta[B::TIMES.len() - 1].iter().zip(&weights) {
            assert!((beta - weight).abs() < 1e-13, "{beta} {weight}");
        }
    }

    /// The dense output meets every condition up to an order within the step.
    pub(in crate::ode) fn extension<B: RosenbrockTableau>(order: usize) {
        let solution = solution::<B>();
        let mut terms: Vec<&[f64]> = Vec::from([&solution[..]]);
        terms.extend(B::EXTENSION);
        for theta in [0.1f64, 0.37, 0.5, 0.9] {
            for tree in trees(order) {
                let got = method::<B>().extended(&tree, theta, &terms);
                let want = theta.powi(tree.order() as i32) / tree.density();
                assert!((got - want).abs() < 1e-13, "{theta} {tree:?}: {}", got - want);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{factorised, is_outgrown};
    use nalgebra::{Matrix3, Vector3};

    #[test]
    fn growth_is_outgrown_by_an_odd_number_of_eigenvalues_beyond_the_shift() {
        // Of every three of eigenvalues below and beyond s.
        for number in 0..8 {
            let [a, b, c] = [0, 1, 2].map(|i| if number >> i & 1 == 1 { 25.0 } else { 4.0 });
            let jacobian = Matrix3::new(a, 7.0, 2.0, 0.0, b, -3.0, 0.0, 0.0, c);
            let found =
                is_outgrown(3, factorised::<_, Vector3<f64>>(3, &jacobian, 10.0).as_slice());
            assert_eq!(found, u32::count_ones(number) % 2 == 1, "{jacobian}");
        }
    }
}
