//! Explicit Runge–Kutta methods, each from its Butcher tableau.
//!
//! kᵢ = f(t + cᵢ h, x + h Σⱼ aᵢⱼ kⱼ),  x₁ = x + h Σ bⱼ kⱼ,  error = h Σ eⱼ kⱼ.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | h | step | s |
//! | kᵢ | rate at stage i | that of x over s |
//! | cᵢ, aᵢⱼ | time of stage i as a fraction of the step, weights of the earlier stages in it | – |
//! | bⱼ, eⱼ | weights of the solution and of its error estimate | – |
//!
//! The dense output is the cubic through both ends with their rates, with further terms h Σ dⱼ kⱼ.
//!
//! Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd
//! edition (Springer, 1993), sections II.1, II.5 and II.6.

use core::fmt::Debug;
use core::marker::PhantomData;
use core::ops::Range;

use super::dense_output::DenseOutput;
use super::growth::MANY;
use super::stepper::{Field, Point, Stepper, TrialStep};
use super::storage::{States, slices};
use crate::Scalar;
use crate::scalar::lit;

/// The coefficients of an explicit Runge–Kutta method.
pub(crate) trait ExplicitTableau: Debug + Copy {
    /// Number s of stages of a step. Stage s lies at the end of the step, with the rate there.
    const STAGES: usize;
    /// cᵢ.
    const TIMES: &'static [f64];
    /// Rows of aᵢⱼ. Row s holds the weights b of the solution; the rows beyond it belong to stages
    /// that serve the dense output alone.
    const WEIGHTS: &'static [&'static [f64]];
    /// eⱼ; empty for a method without an estimate. If stage s is among them, a trial evaluates it.
    const ERROR: &'static [f64] = &[];
    /// Weights of a second estimate whose order is lower by two; empty if there is none.
    const COARSE_ERROR: &'static [f64] = &[];
    /// The power of h that it follows.
    const COARSE_ORDER: i32 = 0;
    /// Whether the error is a mean of both estimates, as that of order 8 is.
    const IS_MEAN: bool = false;
    /// Order of the estimate.
    const ERROR_ORDER: u8;
    /// dⱼ of each further term of the dense output.
    const EXTENSION: &'static [&'static [f64]] = &[];
    /// Largest stable h|λ| on the negative real axis.
    const REAL_LIMIT: f64;
}

/// Does something with each component of Σ wⱼ kⱼ over at most 16 vectors of so many states, with
/// weights known when it is compiled: no zero is multiplied.
macro_rules! combine {
    ($k:expr, $weights:expr, $states:expr, |$place:ident, $sum:ident| $body:expr) => {
        combine!(@ $k, $weights, $states, $place, $sum, $body, 0 a 1 b 2 c 3 d 4 e 5 f 6 g 7 h
            8 i 9 j 10 k 11 l 12 m 13 n 14 o 15 p)
    };
    (
        @ $k:expr, $weights:expr, $states:expr, $place:ident, $sum:ident, $body:expr,
        $($j:literal $slice:ident)*
    ) => {{
        $(
            let used = $j < S && const { entry($weights, $j) } != 0.0;
            let $slice: &[T] = if used { &$k[$j].entries()[..$states] } else { &[] };
        )*
        for $place in 0..$states {
            let mut sum = None;
            $(
                let weight = const { entry($weights, $j) };
                if $j < S && weight != 0.0 {
                    let term = $slice[$place] * lit(weight);
                    sum = Some(sum.map_or(term, |sum: T| sum + term));
                }
            )*
            let $sum = sum.unwrap_or(T::zero());
            $body;
        }
    }};
}
pub(super) use combine;

/// An entry of a list; zero beyond its end.
pub(super) const fn entry(list: &[f64], index: usize) -> f64 {
    if index < list.len() { list[index] } else { 0.0 }
}

/// A row of a table; empty beyond its end.
pub(super) const fn row(table: &'static [&'static [f64]], index: usize) -> &'static [f64] {
    if index < table.len() { table[index] } else { &[] }
}

/// rₖ of the stability function R(z) = 1 + r₁z(1 + r₂z(1 + …)): bᵀAᵏ⁻¹1/bᵀAᵏ⁻²1 and r₁ = 1.
const fn stability<const S: usize>(weights: &[&[f64]], stages: usize) -> [f64; S] {
    let (mut ratios, mut powers, mut before, mut k) = ([0.0; S], [1.0; S], 1.0, 0);
    while k < stages {
        // From the last row on: each takes the ones before it as they were.
        let mut i = stages + 1;
        while i > 0 {
            i -= 1;
            let (mut sum, mut j) = (0.0, 0);
            while j < i {
                sum += entry(weights[i], j) * powers[j];
                j += 1;
            }
            powers[i] = sum;
        }
        ratios[k] = powers[stages] / before;
        before = powers[stages];
        k += 1;
    }
    ratios
}

/// An explicit Runge–Kutta method with S stages, those of its dense output included.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Explicit<B, T: Scalar, V: States<T>, const S: usize> {
    k: [V; S],
    /// The state at which the last stage before the end was evaluated.
    before_end: V,
    /// The state at which the last one within the step was.
    within: V,
    /// Of the last accepted step, and of the last trial.
    estimates: [Estimates<T, V>; 2],
    /// The Jacobians known last before the next step, and where the last trial ended.
    jacobians: [Option<V::Matrix>; 2],
    /// Steps that the first of them has served.
    served: usize,
    tableau: PhantomData<B>,
}

/// The two estimates of a step, e and the coarser c; zeros if they are not known. Where the
/// solution is smooth they follow powers of h.
#[derive(Debug, Clone, Copy)]
struct Estimates<T, V> {
    step: T,
    /// |e|²/|c|².
    ratio: T,
    /// c over the scale.
    coarse: V,
}

impl<T: Scalar, V: States<T>> Estimates<T, V> {
    fn unknown(states: usize) -> Self {
        Self { step: T::one(), ratio: T::zero(), coarse: V::filled(states, T::zero()) }
    }
}

/// The smallest part of its expected value to which |e|/|c| may fall from one step to the next.
const CHANCE: f64 = 0.3;

/// Beyond so many times its expected value a step is rough: a kink lies in it that nobody declared.
const ROUGH: f64 = 10.0;

/// So many times its expected value, too, |c| rises at a kink while |e| need not.
const LEAP: f64 = 50.0;

/// Or so many times its own the largest component of c, ...
const OWN_LEAP: f64 = 30.0;

/// ... of so many states, those of two contacts: |c| hides one of them.
const CROWD: usize = 6;

/// |e| of a step is not so many times that of a longer one from the same point.
const RISE: f64 = 1.5;

/// The error of a rough step is at least this part of |c|: |e| may pass zero there as well.
const KINK: f64 = 0.1;

/// Beyond this part of the stability limit, stability holds a step.
const HELD: f64 = 0.6;

/// The steps that a Jacobian of so many states serves: by differences it costs an evaluation for
/// each of them, a step of order 8 twelve. One that is older tells of growth that is none.
pub(super) const fn serves(states: usize) -> usize {
    match states {
        ..MANY => 1,
        MANY..20 => states / 2,
        20..40 => 10,
        _ => states / 4,
    }
}

/// Calls a function for every stage from 1 on, so that each sum has a length known in advance.
macro_rules! for_each_stage {
    ($stepper:ident.$stage:ident($($argument:expr),*)) => {
        for_each_stage!(@ $stepper.$stage($($argument),*) 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15)
    };
    (@ $stepper:ident.$stage:ident $arguments:tt $($index:literal)*) => {
        $( for_each_stage!(# $stepper.$stage::<$index> $arguments); )*
    };
    (# $stepper:ident.$stage:ident::<$index:literal> ($($argument:expr),*)) => {
        $stepper.$stage::<$index>($($argument),*)
    };
}
pub(super) use for_each_stage;

impl<B: ExplicitTableau, T: Scalar, V: States<T>, const S: usize> Explicit<B, T, V, S> {
    /// Evaluates stage I at x + h Σ aᵢⱼ kⱼ if it belongs to the given range.
    #[inline(always)]
    fn stage<const I: usize>(
        &mut self,
        field: &mut impl Field<T, V>,
        from: &Point<T, V>,
        step: T,
        stages: Range<usize>,
    ) {
        if I < stages.start || I >= stages.end {
            return;
        }
        let state = if I < B::STAGES { &mut self.before_end } else { &mut self.within };
        let count = state.count();
        let [start] = slices(count, [&from.state]);
        let end = &mut state.entries_mut()[..count];
        combine!(self.k, row(B::WEIGHTS, I), count, |i, sum| end[i] = start[i] + step * sum);
        let time = from.time + step * lit(const { entry(B::TIMES, I) });
        field.rate_to(time, state, &mut self.k[I]);
    }

    /// Whether h|λ| of an accepted step exceeds a part of the stability limit, with |λ| from the
    /// last two stages: |f(x₁) − f(x̃)|/|x₁ − x̃|.
    fn is_held_by_stability(&self, end: &Point<T, V>, step: T) -> bool {
        let [rates, before] =
            slices(end.state.count(), [&self.k[B::STAGES], &self.k[B::STAGES - 1]]);
        let [scale, reached, before_end] =
            slices(rates.len(), [&end.scale, &end.state, &self.before_end]);
        let (mut over, mut under) = (T::zero(), T::zero());
        for i in 0..rates.len() {
            let inverse = T::one() / scale[i];
            let rate = (rates[i] - before[i]) * inverse;
            let state = (reached[i] - before_end[i]) * inverse;
            over += rate * rate;
            under += state * state;
        }
        let limit: T = lit(B::REAL_LIMIT * HELD);
        // States that hardly differ show nothing but their rounding.
        under > lit(1e-6) && over * step * step > under * limit * limit
    }

    /// Keeps what an accepted step tells of the next. Answers whether stability holds it.
    pub(super) fn took_held(&mut self, end: &Point<T, V>, step: T) -> bool {
        self.took();
        self.is_held_by_stability(end, step)
    }

    /// Keeps what an accepted step tells of the next.
    fn took(&mut self) {
        self.estimates.swap(0, 1);
        let [before, latest] = &mut self.estimates;
        if !(before.ratio.is_finite() && before.coarse.is_finite()) {
            before.ratio = T::zero();
        }
        latest.step = T::zero();
        if let Some(at_end) = self.jacobians[1].take() {
            self.jacobians[0] = Some(at_end);
        }
    }

    /// Forgets what the last step tells of the next.
    pub(super) fn forget(&mut self) {
        let [before, latest] = &mut self.estimates;
        (before.ratio, latest.step) = (T::zero(), T::zero());
        self.jacobians = [None, None];
    }

    /// The finer of two errors, or more if the step before makes more likely; and whether the step
    /// is rough, so that the order of neither estimate says anything.
    ///
    /// |e| may pass zero by chance, as it does in systems of one or two states, and the step would
    /// become far too long. |e|/|c| behaves as h², and may not fall by much more than that. A kink
    /// lies in the step if it rises far more, or falls while |c| rises; or if the largest component
    /// of c rises by itself, for of several contacts |c| hides a kink of one; or if |e| of a longer
    /// step from the same point was smaller.
    fn likely(&mut self, fine: V, coarse: &V, scale: &V, step: T) -> (V, bool) {
        let over_scale = |error: &V| error.like(|i| error[i] / scale[i]);
        let [fines, coarses] = [over_scale(&fine), over_scale(coarse)];
        let [before, latest] = &mut self.estimates;
        let all = [&fines, &coarses, &before.coarse, &latest.coarse];
        let [of_fine, of_coarse, of_before, of_latest] =
            all.map(|parts| parts.entries().iter().fold(T::zero(), |sum, &part| sum + part * part));
        let ratio = of_fine / of_coarse;
        let longer = step / before.step;
        let expected = before.ratio * longer.powi(4);
        let is_known = expected > T::zero();
        let power = longer.powi(B::COARSE_ORDER);
        let pairs = coarses.entries().iter().zip(before.coarse.entries());
        let (largest, own) = pairs.fold((T::zero(), T::zero()), |most, (&now, before)| {
            if now.abs() > most.0 { (now.abs(), before.abs()) } else { most }
        });
        let leaps = ratio < expected && of_coarse > of_before * power * power * lit(LEAP * LEAP);
        let leaps_alone = fine.count() >= CROWD && largest > own * power * lit(OWN_LEAP);
        let rises = latest.step.abs() >= step.abs()
            && of_fine > latest.ratio * of_latest * lit(RISE * RISE);
        *latest = Estimates { step, ratio, coarse: coarses };
        if is_known && ratio > expected * lit(ROUGH * ROUGH) {
            let times = ratio.sqrt().recip() * lit::<T>(KINK);
            let times = times.larger(T::one());
            return (fine.like(|i| fine[i] * times), true);
        }
        if rises || is_known && (leaps || leaps_alone) {
            return (coarse.like(|i| coarse[i] * lit(KINK)), true);
        }
        let least = expected * lit(CHANCE * CHANCE);
        if ratio < least {
            latest.ratio = least;
            let part = least.sqrt();
            return (coarse.like(|i| coarse[i] * part), false);
        }
        (fine, false)
    }

    /// The method at the start of a run.
    pub(super) fn new(state: &V) -> Self {
        const { assert!(B::WEIGHTS.len() == S && B::TIMES.len() == S && B::STAGES < S) };
        let zero = || V::filled(state.count(), T::zero());
        Self {
            k: core::array::from_fn(|_| zero()),
            before_end: zero(),
            within: zero(),
            estimates: [(); 2].map(|()| Estimates::unknown(state.count())),
            jacobians: [None, None],
            served: 0,
            tableau: PhantomData,
        }
    }
}

impl<B: ExplicitTableau, T: Scalar, V: States<T>, const S: usize> Stepper<T, V>
    for Explicit<B, T, V, S>
{
    const ESTIMATES_ERROR: bool = !B::ERROR.is_empty();

    fn begin<F: Field<T, V>>(&mut self, field: &mut F, point: &mut Point<T, V>) {
        self.forget();
        field.rate_to(point.time, &point.state, &mut point.rate);
    }

    #[inline]
    fn step(&mut self, field: &mut impl Field<T, V>, from: &Point<T, V>, h: T) -> TrialStep<T, V> {
        self.k[0].clone_from(&from.rate);
        for_each_stage!(self.stage(field, from, h, 1..B::STAGES));
        let states = from.state.count();
        let [start] = slices(states, [&from.state]);
        let zero = || V::filled(states, T::zero());
        let (mut state, mut error) = (zero(), zero());
        let end = &mut state.entries_mut()[..states];
        combine!(self.k, row(B::WEIGHTS, B::STAGES), states, |i, sum| end[i] = start[i] + h * sum);
        if B::ERROR.len() > B::STAGES {
            field.rate_to(from.time + h, &state, &mut self.k[B::STAGES]);
        }
        let fine = &mut error.entries_mut()[..states];
        combine!(self.k, B::ERROR, states, |i, sum| fine[i] = sum * h);
        let mut coarse_error = None;
        if !B::COARSE_ERROR.is_empty() {
            let mut coarse = zero();
            let to = &mut coarse.entries_mut()[..states];
            combine!(self.k, B::COARSE_ERROR, states, |i, sum| to[i] = sum * h);
            let is_rough;
            (error, is_rough) = self.likely(error, &coarse, &from.scale, h);
            coarse_error = Some(coarse).filter(|_| B::IS_MEAN && !is_rough);
        }
        TrialStep { state, error, coarse_error, order: B::ERROR_ORDER, scalar: PhantomData }
    }

    #[inline]
    fn arrive<F: Field<T, V>>(&mut self, field: &mut F, end: &mut Point<T, V>) {
        if B::ERROR.len() <= B::STAGES {
            field.rate_to(end.time, &end.state, &mut self.k[B::STAGES]);
        }
        end.rate.clone_from(&self.k[B::STAGES]);
    }

    #[inline]
    fn jacobians_of_step<F: Field<T, V>>(
        &mut self,
        field: &mut F,
        from: &Point<T, V>,
        end: &Point<T, V>,
    ) -> [&V::Matrix; 2] {
        self.served += 1;
        let serves = serves(from.state.count());
        let [at_start, at_end] = &mut self.jacobians;
        if self.served < serves && at_start.is_some() {
            *at_end = None;
        } else {
            self.served = 0;
            *at_end = Some(field.jacobian(end));
        }
        let at_end = at_end.as_ref();
        let at_start = at_start.get_or_insert_with(|| match at_end {
            Some(at_end) if serves > 1 => at_end.clone(),
            _ => field.jacobian(from),
        });
        [at_start, at_end.unwrap_or(at_start)]
    }

    fn stability(&self) -> &'static [f64] {
        const { &stability::<S>(B::WEIGHTS, B::STAGES) }.split_at(B::STAGES).0
    }

    #[inline]
    fn dense_output<F: Field<T, V>>(
        &mut self,
        field: &mut F,
        from: &Point<T, V>,
        end: &Point<T, V>,
    ) -> DenseOutput<T, V> {
        let step = end.time - from.time;
        for_each_stage!(self.stage(field, from, step, B::STAGES + 1..S));
        let (mut own, states) = (from.cubic_to(end), end.state.count());
        macro_rules! extend {
            ($($term:literal)*) => { $(
                if $term < B::EXTENSION.len() {
                    let mut term = V::filled(states, T::zero());
                    let to = &mut term.entries_mut()[..states];
                    combine!(self.k, row(B::EXTENSION, $term), states, |i, sum| to[i] = sum * step);
                    own.push(term);
                }
            )* };
        }
        extend!(0 1 2 3);
        // A stage that serves the dense output alone may hit the pole beyond a reversal.
        if own.is_finite() { own } else { from.cubic_to(end) }
    }

    #[inline]
    fn accepted(&mut self, step: T, end: &Point<T, V>, proposed: Option<T>) -> Option<T> {
        self.took();
        let proposed = proposed?;
        // The further stages of a dense output enlarge fast motions that have died out.
        let is_held = B::STAGES + 1 < S && self.is_held_by_stability(end, step);
        Some(if is_held { proposed.smaller(step.abs() * lit(HELD)) } else { proposed })
    }
}

/// The laws that every tableau keeps, whatever its order.
#[cfg(test)]
pub(super) mod laws {
    extern crate std;
    use super::ExplicitTableau;
    use super::trees::{RungeKutta, Tree, trees};
    use std::vec::Vec;

    fn method<B: ExplicitTableau>() -> RungeKutta {
        RungeKutta { a: B::WEIGHTS.iter().map(|row| row.to_vec()).collect() }
    }

    fn of_order(order: usize) -> impl Iterator<Item = Tree> {
        trees(order).into_iter().filter(move |tree| tree.order() == order)
    }

    /// The stages lie where their weights say.
    pub(in crate::ode) fn times<B: ExplicitTableau>(tolerance: f64) {
        for (row, c) in B::WEIGHTS.iter().zip(B::TIMES) {
            assert!((row.iter().sum::<f64>() - c).abs() < tolerance, "{c}");
        }
    }

    /// The solution meets every condition up to an order, and some of the next by no less than
    /// `least`.
    pub(in crate::ode) fn order<B: ExplicitTableau>(order: usize, tolerance: f64, least: f64) {
        let solution = B::WEIGHTS[B::STAGES];
        let defect = |tree: &Tree| method::<B>().weighted(tree, solution) - 1.0 / tree.density();
        for tree in trees(order) {
            assert!(defect(&tree).abs() < tolerance, "{tree:?}: {}", defect(&tree));
        }
        let next = of_order(order + 1).map(|tree| defect(&tree).abs());
        assert!(next.fold(0.0, f64::max) > least);
    }

    /// The error estimate vanishes up to an order and no further.
    pub(in crate::ode) fn estimate<B: ExplicitTableau>(weights: &[f64], order: usize) {
        let greatest = |order: usize| {
            let sizes = of_order(order).map(|tree| method::<B>().weighted(&tree, weights).abs());
            sizes.fold(0.0, f64::max)
        };
        for below in 1..=order {
            assert!(greatest(below) < 2e-14, "{order}: {}", greatest(below));
        }
        assert!(greatest(order + 1) > 1e-5, "{order}: {}", greatest(order + 1));
    }

    /// The dense output meets every condition up to an order within the step.
    pub(in crate::ode) fn extension<B: ExplicitTableau>(order: usize, tolerance: f64) {
        let (solution, terms) = (B::WEIGHTS[B::STAGES], B::EXTENSION.iter().copied());
        let terms: Vec<&[f64]> = terms.collect();
        for theta in [0.1f64, 0.37, 0.5, 0.9] {
            for tree in trees(order) {
                // A tree of order ρ needs Σ bᵢ(θ) Φᵢ = θ^ρ/γ.
                let got = method::<B>().extended(&tree, theta, solution, B::STAGES, &terms);
                let want = theta.powi(tree.order() as i32) / tree.density();
                assert!((got - want).abs() < tolerance, "{theta} {tree:?}: {}", got - want);
            }
        }
    }
}

/// Rooted trees, and what the order conditions make of them: for the tests of the tableaux.
///
/// Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd
/// edition (Springer, 1993), section II.2; for Rosenbrock methods E. Hairer, G. Wanner, part II,
/// section IV.7.
#[cfg(test)]
pub(super) mod trees {
    extern crate std;
    use std::vec;
    use std::vec::Vec;

    /// A rooted tree as the list of its root's subtrees.
    #[derive(Clone, Debug)]
    pub(in crate::ode) struct Tree(Vec<Tree>);

    impl Tree {
        /// The number of nodes.
        pub(in crate::ode) fn order(&self) -> usize {
            1 + self.0.iter().map(Tree::order).sum::<usize>()
        }

        /// γ, the density: 1/γ is what the weighted sum over the tree must be.
        pub(in crate::ode) fn density(&self) -> f64 {
            self.0.iter().map(Tree::density).product::<f64>() * self.order() as f64
        }
    }

    /// All rooted trees of up to so many nodes.
    pub(in crate::ode) fn trees(most: usize) -> Vec<Tree> {
        let mut all = vec![Tree(vec![])];
        for order in 2..=most {
            let known = all.clone();
            extend(&known, 0, order - 1, &mut Vec::new(), &mut all);
        }
        all
    }

    /// Every set of known trees with so many nodes left, in non-decreasing position, under a root.
    fn extend(
        known: &[Tree],
        from: usize,
        left: usize,
        picked: &mut Vec<Tree>,
        all: &mut Vec<Tree>,
    ) {
        if left == 0 {
            all.push(Tree(picked.clone()));
            return;
        }
        for i in from..known.len() {
            if known[i].order() <= left {
                picked.push(known[i].clone());
                extend(known, i, left - known[i].order(), picked, all);
                picked.pop();
            }
        }
    }

    /// An explicit Runge–Kutta method: the weights of the earlier stages in each.
    pub(in crate::ode) struct RungeKutta {
        pub(in crate::ode) a: Vec<Vec<f64>>,
    }

    impl RungeKutta {
        /// The elementary weight of a tree at each stage.
        fn stages(&self, tree: &Tree) -> Vec<f64> {
            let mut product = vec![1.0; self.a.len()];
            for child in &tree.0 {
                let below = self.stages(child);
                for (factor, row) in product.iter_mut().zip(&self.a) {
                    *factor *= row.iter().zip(&below).map(|(a, b)| a * b).sum::<f64>();
                }
            }
            product
        }

        pub(in crate::ode) fn weighted(&self, tree: &Tree, weights: &[f64]) -> f64 {
            self.stages(tree).iter().zip(weights).map(|(s, w)| s * w).sum()
        }

        /// The sum over a tree within the step, for the nested form of `DenseOutput`: weights of
        /// the solution, the stage at the end of the step, weights of the terms from the fourth on.
        pub(in crate::ode) fn extended(
            &self,
            tree: &Tree,
            theta: f64,
            solution: &[f64],
            last: usize,
            inner: &[&[f64]],
        ) -> f64 {
            let phi = self.stages(tree);
            let chord = self.weighted(tree, solution);
            let from_start = phi[0] - chord;
            let mut terms = vec![chord, from_start, chord - phi[last] - from_start];
            terms.extend(inner.iter().map(|weights| self.weighted(tree, weights)));
            nested(&terms, theta)
        }
    }

    /// A Rosenbrock method: αᵢⱼ and βᵢⱼ = αᵢⱼ + γᵢⱼ, from the form in which its stages are solved.
    pub(in crate::ode) struct Rosenbrock {
        pub(in crate::ode) alpha: Vec<Vec<f64>>,
        pub(in crate::ode) beta: Vec<Vec<f64>>,
        gammas: Vec<Vec<f64>>,
    }

    impl Rosenbrock {
        /// Γ⁻¹ = I/γ − C and α = A Γ.
        pub(in crate::ode) fn new(gamma: f64, a: &[Vec<f64>], c: &[&[f64]]) -> Self {
            let s = c.len();
            // Forward substitution: (I/γ − C) Γ = I.
            let mut gammas = vec![vec![0.0; s]; s];
            for i in 0..s {
                let entry = |j: usize| {
                    let unit = f64::from(u8::from(i == j));
                    gamma * (unit + (j..i).map(|k| c[i][k] * gammas[k][j]).sum::<f64>())
                };
                let row: Vec<f64> = (0..s).map(|j| if j <= i { entry(j) } else { 0.0 }).collect();
                gammas[i] = row;
            }
            let times = |row: &Vec<f64>| -> Vec<f64> {
                (0..s).map(|j| row.iter().zip(&gammas).map(|(a, row)| a * row[j]).sum()).collect()
            };
            let alpha: Vec<Vec<f64>> = a.iter().map(times).collect();
            let add = |(x, y): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
                x.iter().zip(y).map(|(x, y)| x + y).collect()
            };
            let beta = alpha.iter().zip(&gammas).map(add).collect();
            Self { alpha, beta, gammas }
        }

        /// Weights of the stages kᵢ from those of the Uᵢ.
        pub(in crate::ode) fn weights(&self, of_u: &[f64]) -> Vec<f64> {
            let column = |j: usize| of_u.iter().zip(&self.gammas).map(|(m, row)| m * row[j]).sum();
            (0..self.alpha.len()).map(column).collect()
        }

        /// Σⱼ γᵢⱼ, which weighs ∂f/∂t.
        pub(in crate::ode) fn time_weight(&self, stage: usize) -> f64 {
            self.gammas[stage].iter().sum()
        }

        /// The elementary weight of a tree at each stage: β where a node has one child, α where it
        /// has more.
        fn stages(&self, tree: &Tree) -> Vec<f64> {
            let rows = if tree.0.len() == 1 { &self.beta } else { &self.alpha };
            let mut product = vec![1.0; rows.len()];
            for child in &tree.0 {
                let below = self.stages(child);
                for (factor, row) in product.iter_mut().zip(rows) {
                    *factor *= row.iter().zip(&below).map(|(a, b)| a * b).sum::<f64>();
                }
            }
            product
        }

        /// The sum over a tree with weights of the Uᵢ.
        pub(in crate::ode) fn weighted(&self, tree: &Tree, of_u: &[f64]) -> f64 {
            let weights = self.weights(of_u);
            self.stages(tree).iter().zip(weights).map(|(s, w)| s * w).sum()
        }

        /// The sum over a tree within the step, for the nested form: weights of the Uᵢ in each
        /// term.
        pub(in crate::ode) fn extended(&self, tree: &Tree, theta: f64, terms: &[&[f64]]) -> f64 {
            let terms: Vec<f64> =
                terms.iter().map(|weights| self.weighted(tree, weights)).collect();
            nested(&terms, theta)
        }
    }

    /// θ(q₀ + θ̄(q₁ + θ(q₂ + …))).
    fn nested(terms: &[f64], theta: f64) -> f64 {
        terms.iter().enumerate().rev().fold(0.0, |value, (index, term)| {
            (term + value) * if index % 2 == 0 { theta } else { 1.0 - theta }
        })
    }

    #[test]
    fn there_are_as_many_trees_as_order_conditions() {
        let all = trees(8);
        let count = |order| all.iter().filter(|tree| tree.order() == order).count();
        assert_eq!([1, 2, 3, 4, 5, 6, 7, 8].map(count), [1, 1, 2, 4, 9, 20, 48, 115]);
    }
}
