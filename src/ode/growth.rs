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
//! eight parts, each the Padé approximation (1 + A/3)/(1 − 2A/3 + A²/6) of order 3, which is
//! L-stable, too: what dies out in the system dies out here. A step that is as long as half a swing
//! of a stuck mass then turns the error by the right angle; in one piece it would leave a part that
//! the slip after it enlarges. The rate is continuous at a reversal, so e passes it unchanged.
//!
//! Source: E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", 2nd edition
//! (Springer, 1996), section IV.3.

use nalgebra::{SMatrix, SVector};

use super::stepper::TrialStep;
use crate::Scalar;
use crate::scalar::{lit, to_f64};

/// From so many states on what costs as their square or cube decides: products with a vector are
/// cheaper than factors of a matrix, and a Jacobian serves several steps.
pub(super) const MANY: usize = 12;

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

/// The estimated error of a run so far.
#[derive(Debug, Clone, Copy)]
pub(super) struct Growth<T, const N: usize> {
    error: SVector<T, N>,
    /// The largest tolerance of a step that each state has had: errors are compared with the
    /// largest values met, since a slip that comes a little late has every velocity for a moment.
    allowed: SVector<T, N>,
    /// The largest error so far, over these.
    greatest: f64,
}

impl<T: Scalar, const N: usize> Growth<T, N> {
    pub(super) fn new() -> Self {
        Self { error: SVector::zeros(), allowed: SVector::zeros(), greatest: 0.0 }
    }

    /// The largest error so far of any state over its tolerance of a step; infinite if unknown.
    pub(super) fn greatest(&self) -> f64 {
        self.greatest
    }

    /// Takes a step: hJ, the rₖ of an explicit method, the trial with the mean square of its
    /// estimated error over the tolerances and a further error that it does not show, and the
    /// tolerances.
    #[inline]
    pub(super) fn step(
        &mut self,
        (growth, stability): (&SMatrix<T, N, N>, &[f64]),
        (trial, square, missed): (&TrialStep<T, N>, f64, &SVector<T, N>),
        allowed: &SVector<T, N>,
    ) {
        let error = &trial.error;
        self.error.zip_apply(missed, |error: &mut T, missed| *error += missed.copysign(*error));
        let series = if N < MANY { None } else { series(growth, &self.error, allowed) };
        let mut carried = series.unwrap_or_else(|| {
            let part = Exponential::new(&(growth * lit::<T>(1.0 / f64::from(PARTS))));
            let mut grown = self.error;
            for _ in 0..PARTS {
                part.apply_to(&mut grown);
            }
            grown
        });
        if let Some(own) = own(growth, &self.error, stability) {
            carried.zip_zip_apply(&own, allowed, |carried, own, allowed| {
                *carried = if own.abs() <= allowed { own } else { *carried };
            });
        }
        let (mut along, mut own) = (T::zero(), T::zero());
        for i in 0..N {
            let part = error[i] / allowed[i];
            along += carried[i] / allowed[i] * part;
            own += part * part;
        }
        // A method with two estimates gives the mean square of both together.
        let size = (lit::<T>(square * N as f64) / own).sqrt();
        let size = if size.is_finite() { size } else { T::zero() };
        let sign = if along < T::zero() { -T::one() } else { T::one() };
        for i in 0..N {
            let part = error[i] / allowed[i];
            // The two estimates of the other states say nothing of one that has died out.
            let size = match &trial.coarse_error {
                Some(coarse) if part * part < own * lit(FAR * FAR) => {
                    let ratio = coarse[i] * lit(0.1) / error[i];
                    size.larger((ratio * ratio + T::one()).sqrt().recip())
                }
                _ => size,
            };
            self.error[i] = carried[i] + error[i] * size * sign;
            self.allowed[i] = self.allowed[i].larger(allowed[i]);
            let part = to_f64((self.error[i] / self.allowed[i]).abs());
            if !(part <= self.greatest) {
                self.greatest = if part.is_finite() { part } else { f64::INFINITY };
            }
        }
    }
}

/// tr A².
pub(super) fn trace_of_square<T: Scalar, const N: usize>(a: &SMatrix<T, N, N>) -> T {
    let mut sum = T::zero();
    for i in 0..N {
        for j in 0..N {
            sum += a[(i, j)] * a[(j, i)];
        }
    }
    sum
}

/// R(A) x with the rₖ of an explicit method; none where the traces of A and A² show no eigenvalue
/// beyond a quarter of the number of stages, half of the limit of stability: there it is e^A x to
/// about a hundredth.
#[inline]
fn own<T: Scalar, const N: usize>(
    a: &SMatrix<T, N, N>,
    x: &SVector<T, N>,
    stability: &[f64],
) -> Option<SVector<T, N>> {
    let near: T = lit(stability.len() as f64 / 4.0);
    if stability.is_empty() || a.trace().abs() < near && trace_of_square(a).abs() < near * near {
        return None;
    }
    let mut sum = *x;
    for &ratio in stability.iter().rev() {
        let before = sum;
        for i in 0..N {
            let row = (0..N).fold(T::zero(), |sum, j| sum + a[(i, j)] * before[j]);
            sum[i] = x[i] + row * lit(ratio);
        }
    }
    Some(sum)
}

/// e^A x by its power series, to a part of its largest component over a scale; none if it does not
/// converge fast.
fn series<T: Scalar, const N: usize>(
    a: &SMatrix<T, N, N>,
    x: &SVector<T, N>,
    scale: &SVector<T, N>,
) -> Option<SVector<T, N>> {
    let size = |x: &SVector<T, N>| x.component_div(scale).amax();
    let (mut sum, mut term, mut small) = (*x, *x, 0);
    for n in 1..=TERMS {
        term = a * term * lit::<T>(1.0 / n as f64);
        sum += term;
        small = if size(&term) <= size(&sum) * lit(SMALL) { small + 1 } else { 0 };
        if small == 2 {
            return Some(sum);
        }
    }
    None
}

/// The factors of an approximation of e^A; not finite where A is not.
pub(super) struct Exponential<T, const N: usize> {
    /// 1 + A/3.
    above: SMatrix<T, N, N>,
    /// 1 − 2A/3 + A²/6, factorised: below the diagonal the multipliers, on it the reciprocal
    /// pivots.
    below: SMatrix<T, N, N>,
    /// The row exchanged with each.
    exchanged: [usize; N],
}

impl<T: Scalar, const N: usize> Exponential<T, N> {
    #[inline]
    pub(super) fn new(a: &SMatrix<T, N, N>) -> Self {
        let mut above = a * lit::<T>(1.0 / 3.0);
        let mut below = a * a * lit::<T>(1.0 / 6.0) - a * lit::<T>(2.0 / 3.0);
        for i in 0..N {
            above[(i, i)] += T::one();
            below[(i, i)] += T::one();
        }
        let mut exchanged = [0; N];
        for k in 0..N {
            let mut largest = k;
            for i in k + 1..N {
                if below[(i, k)].abs() > below[(largest, k)].abs() {
                    largest = i;
                }
            }
            below.swap_rows(k, largest);
            exchanged[k] = largest;
            let inverse = T::one() / below[(k, k)];
            below[(k, k)] = inverse;
            for i in k + 1..N {
                let multiplier = below[(i, k)] * inverse;
                below[(i, k)] = multiplier;
                for j in k + 1..N {
                    let row = below[(k, j)];
                    below[(i, j)] -= multiplier * row;
                }
            }
        }
        Self { above, below, exchanged }
    }

    /// Multiplies e^A with columns.
    #[inline]
    pub(super) fn apply_to<const C: usize>(&self, columns: &mut SMatrix<T, N, C>) {
        *columns = self.above * *columns;
        for mut x in columns.column_iter_mut() {
            for k in 0..N {
                x.swap_rows(k, self.exchanged[k]);
            }
            for i in 1..N {
                for j in 0..i {
                    let known = x[j];
                    x[i] -= self.below[(i, j)] * known;
                }
            }
            for i in (0..N).rev() {
                for j in i + 1..N {
                    let known = x[j];
                    x[i] -= self.below[(i, j)] * known;
                }
                x[i] *= self.below[(i, i)];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Exponential, Growth, own, series};
    use crate::ode::AnyMethod;
    use crate::ode::any::AnyStepper;
    use crate::ode::stepper::{OneStep, Stepper, TrialStep};
    use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector1, Vector2, Vector3};

    /// e^A x.
    fn exponential<const N: usize>(a: &SMatrix<f64, N, N>, x: &SVector<f64, N>) -> SVector<f64, N> {
        let mut moved = *x;
        Exponential::new(a).apply_to(&mut moved);
        moved
    }

    #[test]
    fn the_exponential_has_order_three_and_lets_die_what_is_stiff() {
        // A turn by an angle, with damping.
        let error = |angle: f64| {
            let a = Matrix2::new(-angle, -angle, angle, -angle);
            let turned = Vector2::new(angle.cos(), angle.sin()) * (-angle).exp();
            (exponential(&a, &Vector2::x()) - turned).norm()
        };
        let order = (error(0.1) / error(0.05)).log2();
        assert!((order - 4.0).abs() < 0.1, "{order}");
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
            let found = series(&a, &Vector2::x(), &Vector2::repeat(1.0)).unwrap_or_default();
            // Terms below a hundredth of the sum are left out.
            assert!((found - turned).norm() < 0.01 * turned.norm(), "{angle}: {found}");
        }
        let stiff = Matrix2::new(-1e3, 0.0, 0.0, -1.0);
        assert_eq!(series(&stiff, &Vector2::repeat(1.0), &Vector2::repeat(1.0)), None);
    }

    #[test]
    fn half_a_swing_in_one_step_turns_the_error_round() {
        // What is displaced by 1 at zero velocity is displaced by −1 after half a turn, at rest.
        let mut growth = Growth::<f64, 2>::new();
        let (none, allowed) = (SMatrix::<f64, 2, 2>::zeros(), Vector2::new(1.0, 1.0));
        let no = &Vector2::zeros();
        growth.step((&none, &[]), (&trial(Vector2::new(1.0, 0.0), None), 0.5, no), &allowed);
        let angle = 2.6;
        let turn = Matrix2::new(0.0, angle, -angle, 0.0);
        growth.step((&turn, &[]), (&trial(Vector2::zeros(), None), 0.0, no), &allowed);
        let wanted = Vector2::new(angle.cos(), -angle.sin());
        assert!((growth.error - wanted).norm() < 0.15, "{}", growth.error);
    }

    #[test]
    fn what_a_step_does_not_show_is_carried_along_and_grows_as_the_solution() {
        let (mut growth, allowed) = (Growth::<f64, 1>::new(), Vector1::new(1e-3));
        let seven = SMatrix::<f64, 1, 1>::new(7.0);
        let nothing = trial(Vector1::zeros(), None);
        growth.step((&seven, &[]), (&nothing, 0.0, &Vector1::new(1e-3)), &allowed);
        // In two parts of a step it was 9.4 for 1 097.
        let factor = growth.greatest() / 7f64.exp();
        assert!(factor > 0.8 && factor < 1.25, "{factor}");
    }

    #[test]
    fn an_explicit_method_carries_an_error_by_its_own_polynomial() {
        // 1 + z + z²/2 + z³/6 + z⁴/24 + z⁵/120 + z⁶/600 (Hairer and Wanner, section IV.2).
        let polynomial = |z: f64| {
            let factors = [1.0, 2.0, 3.0, 4.0, 5.0, 5.0];
            factors.iter().rev().fold(1.0, |sum, factor| 1.0 + z / factor * sum)
        };
        let stepper: AnyStepper<f64, 1> = AnyMethod::DormandPrince.stepper(0.0);
        for z in [-3.2, -1.6, 2.0] {
            let found = own(&Vector1::new(z), &Vector1::new(2.0), stepper.stability());
            let error = found.unwrap_or_default()[0] - 2.0 * polynomial(z);
            assert!(error.abs() < 1e-13, "{z}: {error}");
        }
        // Up to there it is the exponential, to 2 % here.
        for z in [-1.4f64, 1.4] {
            assert_eq!(own(&Vector1::new(z), &Vector1::new(2.0), stepper.stability()), None);
            assert!((polynomial(z) / z.exp() - 1.0).abs() < 0.02);
        }
        // Of turns that cancel in tr A, tr A² has something left.
        let turn = Matrix2::new(0.0, 1.4, -1.4, 0.0);
        assert!(own(&turn, &Vector2::x(), stepper.stability()).is_some());
    }

    /// A trial with estimates, their second one if it has one.
    fn trial<const N: usize>(
        error: SVector<f64, N>,
        coarse_error: Option<SVector<f64, N>>,
    ) -> TrialStep<f64, N> {
        TrialStep { state: SVector::zeros(), error, coarse_error, order: 5 }
    }

    #[test]
    fn errors_of_steps_add_up_with_the_growth_between_them() {
        let mut growth = Growth::<f64, 1>::new();
        let (doubled, allowed) = (SMatrix::<f64, 1, 1>::new(2f64.ln()), Vector1::new(1e-3));
        let no = Vector1::zeros();
        for _ in 0..10 {
            // Half of a tolerance each. What R = 1 + 10 z leaves, above a tolerance, is not taken.
            growth.step(
                (&doubled, &[10.0]),
                (&trial(Vector1::new(-5e-4), None), 0.25, &no),
                &allowed,
            );
        }
        // The approximation of e^(ln 2).
        let a = 2f64.ln() / 8.0;
        let factor = ((1.0 + a / 3.0) / (1.0 - 2.0 * a / 3.0 + a * a / 6.0)).powi(8);
        let wanted = 0.5 * (factor.powi(10) - 1.0) / (factor - 1.0);
        assert!((growth.greatest() / wanted - 1.0).abs() < 1e-12, "{}", growth.greatest());
        // What it leaves below one is.
        let before = growth.error[0];
        let nothing = [-(1.0 - 1e-7) / 2f64.ln()];
        growth.step((&doubled, &nothing), (&trial(Vector1::zeros(), None), 0.0, &no), &allowed);
        assert!((growth.error[0] / before / 1e-7 - 1.0).abs() < 1e-6, "{}", growth.error);
        let unknown = SMatrix::<f64, 1, 1>::new(f64::NAN);
        growth.step((&unknown, &[]), (&trial(Vector1::zeros(), None), 0.0, &no), &allowed);
        assert_eq!(growth.greatest(), f64::INFINITY);
    }

    #[test]
    fn a_state_that_has_died_out_has_an_estimate_of_its_own() {
        // Both together are a thousandth of the finer one, which is all that the first state has.
        let (fine, coarse) = (Vector2::new(1e-6, 1.0), Vector2::new(1e-6, 1e4));
        let (mut growth, none) = (Growth::new(), Matrix2::zeros());
        let one = Vector2::repeat(1.0);
        growth.step((&none, &[]), (&trial(fine, Some(coarse)), 0.5e-6, &Vector2::zeros()), &one);
        let wanted = 1e-6 / 1.01f64.sqrt();
        assert!((growth.error[0] / wanted - 1.0).abs() < 1e-12, "{}", growth.error);
        assert!((growth.error[1] / 1e-3 - 1.0).abs() < 1e-6, "{}", growth.error);
    }
}
