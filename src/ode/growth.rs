//! How the errors of the steps grow over a run: an estimate of the error of the solution.
//!
//! e ← R(hJ) e ± d,  e = 0 at the start.
//!
//! | symbol | meaning |
//! |---|---|
//! | e | error of the solution, in the unit of each state |
//! | d | estimated error of the step, added with the sign that makes the sum larger |
//! | J | Jacobian ∂f/∂x \[1/s\], the mean of that at the start and at the end of the step |
//! | h | step \[s\] |
//! | R | stability function of the method |
//!
//! An explicit method takes R for e^(hJ): near the limit of its stability |R(hλ)| ≫ e^(hλ), and
//! what dies out in the system remains in the answer and may grow later.
//! A part of e above the tolerance of a step is held by the control of the steps, whatever R: it is
//! multiplied by e^(hJ), as with a Rosenbrock method, which is L-stable. The exponential is that of
//! eight parts, each the Padé approximation (1 + 2A/5 + A²/20)/(1 − 3A/5 + 3A²/20 − A³/60) of order
//! 5, which is L-stable, too: what dies out in the system dies out here. A step that is as long as
//! half a swing of a stuck mass then turns the error by the right angle; in one piece it would
//! leave a part that the slip after it enlarges. Of a turn by hω it damps (hω/8)⁶/900: with the
//! order 3 it was (hω/8)⁴/9, and an oscillation that grows by e in 50 of its periods seemed to die
//! out.
//! The rate is continuous at a reversal, so e passes it unchanged.
//!
//! Source: E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", 2nd edition
//! (Springer, 1996), section IV.3.

use core::marker::PhantomData;

use nalgebra::ComplexField;

use super::stepper::TrialStep;
use super::storage::{Entries, States, columns, eliminate, product, slices, substitute};
use crate::Scalar;
use crate::scalar::{lit, to_f64};

/// From so many states on what costs as their square or cube decides: products with a vector are
/// cheaper than factors of a matrix, and a Jacobian serves several steps.
pub(super) const MANY: usize = 12;

/// Of more states an explicit method asks for no Jacobian: to multiply two of them, or to
/// factorise one, costs more than hundreds of steps. What it would be multiplied with is the
/// direction of a difference.
pub(super) const LARGE: usize = 400;

/// Most terms of the power series of e^A x. More are needed where the step is stiff; then the
/// factors are taken.
const TERMS: usize = 24;

/// The power series ends after two terms in a row below this part of the largest component.
const SMALL: f64 = 1e-2;

/// The exponential is that of so many parts of a step: in two, what grows by e⁷ grew ninefold.
const PARTS: u8 = 8;

/// A state whose error over its tolerance is below this part of that of all has an estimate of its
/// own.
const FAR: f64 = 1e-2;

/// A step leaves at least this part of an error that dies out by itself, hJᵢᵢ < ln LEFT: where J
/// changes over the step, no method damps as e^(hJ) does, and the estimate of its error may be
/// small by accident.
const LEFT: f64 = 0.1;

/// ln LEFT.
const DIES: f64 = -2.3;

/// The estimate of a step tells of the next one, unless that is so many times longer.
const LEAP: f64 = 2.0;

/// The estimated error of a run so far.
#[derive(Debug, Clone)]
pub(super) struct Growth<T, V> {
    error: V,
    /// The largest tolerance of a step that each state has had: errors are compared with the
    /// largest values met, since a slip that comes a little late has every velocity for a moment.
    allowed: V,
    /// The largest error so far, over these.
    pub(super) greatest: f64,
    /// The last step \[s\], and the mean square of its estimated error over the tolerances.
    last: (f64, f64),
    scalar: PhantomData<T>,
}

impl<T: Scalar, V: States<T>> Growth<T, V> {
    pub(super) fn new(state: &V) -> Self {
        let zero = || V::filled(state.count(), T::zero());
        Self {
            error: zero(),
            allowed: zero(),
            greatest: 0.0,
            last: (0.0, 0.0),
            scalar: PhantomData,
        }
    }

    /// The error of the solution over a step, given what writes hJ x for any x, with hJ where it is
    /// known as a whole and the rₖ of an explicit method, a further error that no estimate of the
    /// step shows, and its tolerances.
    #[inline]
    pub(super) fn carried(
        &mut self,
        (times, growth): (&mut impl FnMut(&V, &mut V), Option<&V::Matrix>),
        stability: &[f64],
        (missed, allowed): (&V, &V),
    ) -> V {
        let states = allowed.count();
        for (error, &missed) in self.error.entries_mut().iter_mut().zip(missed.entries()) {
            *error += missed.copysign(*error);
        }
        let near = near(stability);
        let is_near = |growth: &V::Matrix| !is_beyond(states, growth.entries(), near);
        let by_own = if growth.is_some_and(is_near) { &[] } else { stability };
        let (series, own) = match states < MANY {
            true => (None, own(times, &self.error, by_own)),
            false => series(times, &self.error, allowed, by_own),
        };
        let mut carried = series.unwrap_or_else(|| {
            let Some(growth) = growth else { return self.error.clone() };
            let part = lit(1.0 / f64::from(PARTS));
            let part = Exponential::<T, V>::new(allowed, growth.entries(), part);
            (0..PARTS).fold(self.error.clone(), |grown, _| part.apply_to(grown))
        });
        if !by_own.is_empty() {
            for i in 0..states {
                if own[i].abs() <= allowed[i] {
                    carried[i] = own[i];
                }
            }
        }
        carried
    }

    /// The mean square of the error of a step h that counts, of its estimate by order q, given J at
    /// both ends and the part that is taken of the estimate of a short step. One over which a state
    /// grows is not short; and its estimate, which may vanish by chance, is no less than that of
    /// the step before times h^q.
    pub(super) fn counted(
        &mut self,
        ends: Option<[&V::Matrix; 2]>,
        (step, order): (T, u8),
        (square, part): (f64, f64),
    ) -> f64 {
        let (states, step) = (self.error.count(), to_f64(step));
        let mut grows = 0.0;
        for end in ends.iter().flatten() {
            for i in 0..states {
                grows = f64::max(grows, step * to_f64(end.entries()[i * states + i]));
            }
        }
        let grows = grows.min(1.0);
        let (length, before) = core::mem::replace(&mut self.last, (step, square));
        let longer = (step / length).abs();
        let power = ComplexField::powi(longer, 2 * i32::from(order));
        let expected = if longer < LEAP { before * power * grows } else { 0.0 };
        let part = part.max(grows);
        part * part * if expected > square { expected } else { square }
    }

    /// Takes a step: what is carried over it with hJ and the rₖ, the trial with the mean square of
    /// its estimated error over the tolerances, and the tolerances.
    #[inline]
    pub(super) fn step(
        &mut self,
        (carried, growth, stability): (V, Option<&V::Matrix>, &[f64]),
        (trial, square): (&TrialStep<T, V>, f64),
        allowed: &V,
    ) {
        let (states, near) = (trial.error.count(), near::<T>(stability));
        let [error, carried, allowed] = slices(states, [&trial.error, &carried, allowed]);
        let known = &mut self.error.entries_mut()[..states];
        let largest = &mut self.allowed.entries_mut()[..states];
        let by_itself =
            |i: usize| growth.map_or(T::zero(), |growth| growth.entries()[i * states + i]);
        let (mut along, mut own) = (T::zero(), T::zero());
        for i in 0..states {
            let part = error[i] / allowed[i];
            along += carried[i] / allowed[i] * part;
            own += part * part;
        }
        // A method with two estimates gives the mean square of both together.
        let size = (lit::<T>(square * states as f64) / own).sqrt();
        let size = if size.is_finite() { size } else { T::zero() };
        let sign = if along < T::zero() { -T::one() } else { T::one() };
        for i in 0..states {
            let part = error[i] / allowed[i];
            let left = (known[i] * lit(LEFT)).abs();
            let dies = by_itself(i) < lit(DIES) && carried[i].abs() < left;
            let carried = if dies { left.copysign(carried[i]) } else { carried[i] };
            // The orders of two estimates say nothing of what decays near the limit of stability,
            // nor does an estimate as a whole of what dies out.
            let at_limit = !stability.is_empty() && by_itself(i).abs() > near;
            let size = if at_limit || dies { size.larger(T::one()) } else { size };
            // Those of the other states say nothing of one that has died out.
            let size = match &trial.coarse_error {
                Some(coarse) if part * part < own * lit(FAR * FAR) => {
                    let ratio = coarse[i] * lit(0.1) / error[i];
                    size.larger((ratio * ratio + T::one()).sqrt().recip())
                }
                _ => size,
            };
            known[i] = carried + error[i] * size * sign;
            largest[i] = largest[i].larger(allowed[i]);
            let part = to_f64((known[i] / largest[i]).abs());
            if !(part <= self.greatest) {
                self.greatest = if part.is_finite() { part } else { f64::INFINITY };
            }
        }
    }
}

/// The modulus of an eigenvalue at half of the limit of stability, with the rₖ: R is e^A to about a
/// hundredth below.
fn near<T: Scalar>(stability: &[f64]) -> T {
    lit(stability.len() as f64 / 4.0)
}

/// tr A.
pub(super) fn trace<T: Scalar>(states: usize, a: &[T]) -> T {
    (0..states).fold(T::zero(), |sum, i| sum + a[i * states + i])
}

/// tr A².
pub(super) fn trace_of_square<T: Scalar>(states: usize, a: &[T]) -> T {
    let mut sum = T::zero();
    for (i, column) in columns(a, states).enumerate() {
        for (&entry, other) in column.iter().zip(columns(a, states)) {
            sum += other[i] * entry;
        }
    }
    sum
}

/// Whether the traces of A and A² show an eigenvalue beyond a limit.
fn is_beyond<T: Scalar>(states: usize, a: &[T], limit: T) -> bool {
    !(trace(states, a).abs() < limit && trace_of_square(states, a).abs() < limit * limit)
}

/// R(A) x with the rₖ of an explicit method, given what writes A x.
#[inline]
fn own<T: Scalar, V: States<T>>(times: &mut impl FnMut(&V, &mut V), x: &V, stability: &[f64]) -> V {
    let (mut sum, mut product) = (x.clone(), x.clone());
    for &ratio in stability.iter().rev() {
        times(&sum, &mut product);
        for i in 0..x.count() {
            sum[i] = x[i] + product[i] * lit(ratio);
        }
    }
    sum
}

/// e^A x by its power series, to a part of its largest component over a scale, or none if it does
/// not converge fast; and R(A) x with the rₖ of an explicit method, from the same products.
fn series<T: Scalar, V: States<T>>(
    times: &mut impl FnMut(&V, &mut V),
    x: &V,
    scale: &V,
    stability: &[f64],
) -> (Option<V>, V) {
    let (mut sum, mut own, mut term, mut before) = (x.clone(), x.clone(), x.clone(), x.clone());
    let (inverse, mut small, mut weight) = (scale.like(|i| scale[i].recip()), 0, 1.0);
    for n in 1..=TERMS {
        let part = lit::<T>(1.0 / n as f64);
        weight *= stability.get(n - 1).map_or(0.0, |ratio| ratio * n as f64);
        let (of_own, mut last, mut most) = (lit::<T>(weight), T::zero(), T::zero());
        core::mem::swap(&mut term, &mut before);
        times(&before, &mut term);
        let scales = inverse.entries().iter();
        let sums = sum.entries_mut().iter_mut().zip(own.entries_mut());
        for ((term, &scale), (sum, own)) in term.entries_mut().iter_mut().zip(scales).zip(sums) {
            *term *= part;
            *sum += *term;
            *own += *term * of_own;
            last = last.larger((*term * scale).abs());
            most = most.larger((*sum * scale).abs());
        }
        small = if last <= most * lit(SMALL) { small + 1 } else { 0 };
        if small >= 2 && n >= stability.len() {
            return (Some(sum), own);
        }
    }
    (None, own)
}

/// The factors of an approximation of e^A; not finite where A is not.
pub(super) struct Exponential<T: Scalar, V: States<T>> {
    /// 1 + 2A/5 + A²/20.
    above: V::Matrix,
    /// 1 − 3A/5 + 3A²/20 − A³/60, factorised: below the diagonal the multipliers, on it the
    /// reciprocal pivots.
    below: V::Matrix,
    /// The row exchanged with each.
    exchanged: V::Numbers,
}

impl<T: Scalar, V: States<T>> Exponential<T, V> {
    /// That of a part of A, over states like these.
    #[inline]
    pub(super) fn new(like: &V, a: &[T], part: T) -> Self {
        let states = like.count();
        let (mut above, mut exchanged) = (like.matrix(), V::Numbers::filled(states, 0));
        for (entry, &a) in above.entries_mut().iter_mut().zip(a) {
            *entry = a * part;
        }
        let square = product(states, above.entries(), &above);
        let mut below = product(states, above.entries(), &square);
        let entries = above.entries_mut().iter_mut().zip(square.entries());
        for (below, (above, &square)) in below.entries_mut().iter_mut().zip(entries) {
            *below = square * lit(0.15) - *above * lit(0.6) - *below * lit(1.0 / 60.0);
            *above = *above * lit(0.4) + square * lit(0.05);
        }
        for i in 0..states {
            above.entries_mut()[i * states + i] += T::one();
            below.entries_mut()[i * states + i] += T::one();
        }
        for k in 0..states {
            let below = below.entries_mut();
            let mut largest = k;
            for i in k + 1..states {
                if below[k * states + i].abs() > below[k * states + largest].abs() {
                    largest = i;
                }
            }
            below.chunks_exact_mut(states).for_each(|column| column.swap(k, largest));
            exchanged.entries_mut()[k] = largest;
            eliminate(states, below, k, |pivot| T::one() / pivot);
        }
        Self { above, below, exchanged }
    }

    /// Multiplies e^A with columns.
    #[inline]
    pub(super) fn apply_to<C: Entries<T>>(&self, columns: C) -> C {
        let states = self.exchanged.entries().len();
        let mut columns = product(states, self.above.entries(), &columns);
        for x in columns.entries_mut().chunks_exact_mut(states.max(1)) {
            for (k, &exchanged) in self.exchanged.entries().iter().enumerate() {
                x.swap(k, exchanged);
            }
            substitute(self.below.entries(), x);
        }
        columns
    }
}

#[cfg(test)]
mod tests {
    use super::{Exponential, Growth, PhantomData, is_beyond, own, series};
    use crate::ode::AnyMethod;
    use crate::ode::stepper::{OneStep, Stepper, TrialStep};
    use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector1, Vector2, Vector3};

    /// e^A x.
    fn exponential<const N: usize>(a: &SMatrix<f64, N, N>, x: &SVector<f64, N>) -> SVector<f64, N> {
        Exponential::new(x, a.as_slice(), 1.0).apply_to(*x)
    }

    #[test]
    fn the_exponential_has_order_five_and_lets_die_what_is_stiff() {
        // A turn by an angle, with damping.
        let error = |angle: f64| {
            let a = Matrix2::new(-angle, -angle, angle, -angle);
            let turned = Vector2::new(angle.cos(), angle.sin()) * (-angle).exp();
            (exponential(&a, &Vector2::x()) - turned).norm()
        };
        let order = (error(0.1) / error(0.05)).log2();
        assert!((order - 6.0).abs() < 0.1, "{order}");
        let stiff = Matrix3::<f64>::new(-1e8, 3.0, 0.0, 0.0, 1.0, 0.0, 5e7, 0.0, -1e8);
        let moved = exponential(&stiff, &Vector3::new(1.0, 1.0, 1.0));
        assert!(moved[0].abs() < 1e-6 && moved[2].abs() < 1e-6, "{moved}");
        assert!((moved[1] / 1f64.exp() - 1.0).abs() < 0.02, "{moved}");
    }

    #[test]
    fn the_series_is_the_exponential_or_none() {
        for angle in [0.0, 0.1, 3.0] {
            let a = Matrix2::new(-angle, -angle, angle, -angle);
            let turned = Vector2::new(f64::cos(angle), angle.sin()) * f64::exp(-angle);
            let one = Vector2::repeat(1.0);
            let found =
                series(&mut |x, to| *to = a * x, &Vector2::x(), &one, &[]).0.unwrap_or_default();
            // Terms below a hundredth of the sum are left out.
            assert!((found - turned).norm() < 0.01 * turned.norm(), "{angle}: {found}");
        }
        let stiff = Matrix2::new(-1e3, 0.0, 0.0, -1.0);
        let ones = Vector2::repeat(1.0);
        assert_eq!(series(&mut |x, to| *to = stiff * x, &ones, &ones, &[]).0, None);
    }

    /// Takes a step with hJ, the rₖ, a trial with its mean square and what it does not show.
    fn step<const N: usize>(
        growth: &mut Growth<f64, SVector<f64, N>>,
        (a, stability): (&SMatrix<f64, N, N>, &[f64]),
        (trial, square, missed): (&TrialStep<f64, SVector<f64, N>>, f64, &SVector<f64, N>),
        allowed: &SVector<f64, N>,
    ) {
        let carried =
            growth.carried((&mut |x, to| *to = a * x, Some(a)), stability, (missed, allowed));
        growth.step((carried, Some(a), stability), (trial, square), allowed);
    }

    #[test]
    fn half_a_swing_in_one_step_turns_the_error_round() {
        // What is displaced by 1 at zero velocity is displaced by −1 after half a turn, at rest.
        let mut growth = Growth::<f64, Vector2<f64>>::new(&Vector2::zeros());
        let (none, allowed) = (SMatrix::<f64, 2, 2>::zeros(), Vector2::new(1.0, 1.0));
        let no = &Vector2::zeros();
        step(&mut growth, (&none, &[]), (&trial(Vector2::new(1.0, 0.0), None), 0.5, no), &allowed);
        let angle = 2.6;
        let turn = Matrix2::new(0.0, angle, -angle, 0.0);
        step(&mut growth, (&turn, &[]), (&trial(Vector2::zeros(), None), 0.0, no), &allowed);
        let wanted = Vector2::new(angle.cos(), -angle.sin());
        assert!((growth.error - wanted).norm() < 0.15, "{}", growth.error);
    }

    #[test]
    fn what_a_step_does_not_show_is_carried_along_and_grows_as_the_solution() {
        let mut growth = Growth::<f64, Vector1<f64>>::new(&Vector1::zeros());
        let allowed = Vector1::new(1e-3);
        let seven = SMatrix::<f64, 1, 1>::new(7.0);
        let nothing = trial(Vector1::zeros(), None);
        step(&mut growth, (&seven, &[]), (&nothing, 0.0, &Vector1::new(1e-3)), &allowed);
        // In two parts of a step it was 9.4 for 1 097.
        let factor = growth.greatest / 7f64.exp();
        assert!(factor > 0.8 && factor < 1.25, "{factor}");
    }

    #[test]
    fn an_explicit_method_carries_an_error_by_its_own_polynomial() {
        // 1 + z + z²/2 + z³/6 + z⁴/24 + z⁵/120 + z⁶/600 (Hairer and Wanner, section IV.2).
        let polynomial = |z: f64| {
            let factors = [1.0, 2.0, 3.0, 4.0, 5.0, 5.0];
            factors.iter().rev().fold(1.0, |sum, factor| 1.0 + z / factor * sum)
        };
        let stepper = AnyMethod::DormandPrince.stepper(0.0, &Vector1::<f64>::zeros());
        for z in [-3.2, -1.6, 2.0] {
            let found = own(&mut |x, to| *to = x * z, &Vector1::new(2.0), stepper.stability());
            let error = found[0] - 2.0 * polynomial(z);
            assert!(error.abs() < 1e-13, "{z}: {error}");
            let one = Vector1::new(1.0);
            let (_, same) =
                series(&mut |x, to| *to = x * z, &(one * 2.0), &one, stepper.stability());
            assert!((same[0] - found[0]).abs() < 1e-13, "{z}: {same}");
            assert!(is_beyond(1, &[z], 1.5));
        }
        // Up to there it is the exponential, to 2 % here.
        for z in [-1.4f64, 1.4] {
            assert!(!is_beyond(1, &[z], 1.5));
            assert!((polynomial(z) / z.exp() - 1.0).abs() < 0.02);
        }
        // Of turns that cancel in tr A, tr A² has something left.
        assert!(is_beyond(2, &[0.0, 1.6, -1.6, 0.0], 1.5));
    }

    /// A trial with estimates, their second one if it has one.
    fn trial<const N: usize>(
        error: SVector<f64, N>,
        coarse_error: Option<SVector<f64, N>>,
    ) -> TrialStep<f64, SVector<f64, N>> {
        let (state, scalar) = (SVector::zeros(), PhantomData);
        TrialStep { state, error, coarse_error, order: 5, scalar }
    }

    #[test]
    fn errors_of_steps_add_up_with_the_growth_between_them() {
        let mut growth = Growth::<f64, Vector1<f64>>::new(&Vector1::zeros());
        let (doubled, allowed) = (SMatrix::<f64, 1, 1>::new(2f64.ln()), Vector1::new(1e-3));
        let no = Vector1::zeros();
        for _ in 0..10 {
            // Half of a tolerance each. What R = 1 + 10 z leaves, above a tolerance, is not taken.
            step(
                &mut growth,
                (&doubled, &[10.0]),
                (&trial(Vector1::new(-5e-4), None), 0.25, &no),
                &allowed,
            );
        }
        // The approximation of e^(ln 2).
        let a = 2f64.ln() / 8.0;
        let below = 1.0 - 0.6 * a + 0.15 * a * a - a * a * a / 60.0;
        let factor = ((1.0 + 0.4 * a + 0.05 * a * a) / below).powi(8);
        let wanted = 0.5 * (factor.powi(10) - 1.0) / (factor - 1.0);
        assert!((growth.greatest / wanted - 1.0).abs() < 1e-12, "{}", growth.greatest);
        // What it leaves below one is.
        let before = growth.error[0];
        let nothing = [-(1.0 - 1e-7) / 2f64.ln()];
        step(
            &mut growth,
            (&doubled, &nothing),
            (&trial(Vector1::zeros(), None), 0.0, &no),
            &allowed,
        );
        assert!((growth.error[0] / before / 1e-7 - 1.0).abs() < 1e-6, "{}", growth.error);
        let unknown = SMatrix::<f64, 1, 1>::new(f64::NAN);
        step(&mut growth, (&unknown, &[]), (&trial(Vector1::zeros(), None), 0.0, &no), &allowed);
        assert_eq!(growth.greatest, f64::INFINITY);
    }

    #[test]
    fn a_state_that_has_died_out_has_an_estimate_of_its_own() {
        // Both together are a thousandth of the finer one, which is all that the first state has.
        let (fine, coarse) = (Vector2::new(1e-6, 1.0), Vector2::new(1e-6, 1e4));
        let (mut growth, none) = (Growth::new(&fine), Matrix2::zeros());
        let one = Vector2::repeat(1.0);
        step(
            &mut growth,
            (&none, &[]),
            (&trial(fine, Some(coarse)), 0.5e-6, &Vector2::zeros()),
            &one,
        );
        let wanted = 1e-6 / 1.01f64.sqrt();
        assert!((growth.error[0] / wanted - 1.0).abs() < 1e-12, "{}", growth.error);
        assert!((growth.error[1] / 1e-3 - 1.0).abs() < 1e-6, "{}", growth.error);
    }

    #[test]
    fn near_the_limit_of_stability_the_finer_estimate_counts_in_full() {
        // Both together are a thousandth of the finer one.
        let (fine, coarse) = (Vector1::new(1.0), Vector1::new(1e4));
        let stepper = AnyMethod::DormandPrince8.stepper(0.0, &Vector1::<f64>::zeros());
        for (z, wanted) in [(-2.5, 1e-3), (-3.5, 1.0)] {
            let mut growth = Growth::new(&fine);
            let trial = trial(fine, Some(coarse));
            let a = Vector1::new(z);
            step(
                &mut growth,
                (&a, stepper.stability()),
                (&trial, 1e-6, &Vector1::zeros()),
                &Vector1::new(1.0),
            );
            assert!((growth.error[0] / wanted - 1.0).abs() < 1e-6, "{z}: {}", growth.error);
        }
    }
}
