//! What grows from far below the tolerance: a rest that has become unstable, steady sliding on a
//! falling curve.
//!
//! There an error of a step as large as the departure itself is no error to any tolerance, and a
//! method with h|μ| ≫ 1 makes of e^(hμ) what it likes: an L-stable one, nothing. So where a
//! perturbation grows, μ = λ + iω with λ > 0, steps are so short that a method of order q follows
//! it, while it grows by the factor e, to the relative tolerance ε of a step:
//!
//! |h μ|^(q+1)/((q+1)! h λ) ≤ ε.
//!
//! Both follow from powers of P = e^(hJ). A norm would also grow where an oscillation merely turns
//! an error from one state into another; the spectral radius does not. With N states,
//!
//! (ln |tr Pᵐ| − ln N)/m ≤ h λ ≤ ln ‖Pᵐ‖/m,   |h μ|² ≈ ‖(hJ)² Pᵐ‖/‖Pᵐ‖,
//!
//! since Pᵐ keeps what grows fastest, where (hJ)² is (hμ)² if μ is real, and nearly so if λ ≪ ω.

use nalgebra::ComplexField;

use super::controller::rough_power;
use super::growth::{Exponential, MANY, trace};
use super::storage::{Entries, States, euclidean, product};
use crate::Scalar;
use crate::scalar::{lit, to_f64};

/// Every so many steps of so many states is looked at: powers of a large matrix cost as much as
/// several steps.
const fn look(states: usize) -> usize {
    if states < MANY { 16 } else { 4 * states }
}

/// A step longer by this factor than the one looked at last is looked at, too.
const fn longer(states: usize) -> f64 {
    if states < MANY { 2.0 } else { 8.0 }
}

/// A step over which tr hJ, the sum of what grows and what dies out, is this large is looked at.
const SPREADS: f64 = 0.5;

/// What grows by less than e to this power over the rest of the run remains below the tolerance if
/// it is far below now.
const MATTERS: f64 = 4.0;

/// The next step after one that grows just as much as allowed may be longer by this factor.
const ROOM: f64 = 1.2;

/// The exponential is that of a part 2^−k of the matrix, with a norm, or a root of that of its
/// square, of at most this and with at most this k: there the approximation damps an oscillation by
/// 3·10⁻⁸.
const PART: (f64, u32) = (0.25, 16);

/// The highest power m: slower growth than ln N/m a step is not seen.
const POWER: f64 = 65536.0;

/// The steps that follow what grows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seeds<T> {
    /// The length \[s\] of the step looked at last.
    seen: T,
    /// Steps since.
    since: usize,
    /// The longest step \[s\] that follows what grows; none if nothing does.
    longest: Option<T>,
}

impl<T: Scalar> Seeds<T> {
    pub(super) fn new() -> Self {
        Self { seen: T::zero(), since: 0, longest: None }
    }

    /// The longest step \[s\] that follows what grows, if something does.
    pub(super) fn longest(&self) -> Option<T> {
        self.longest.map(|longest| longest * lit(ROOM))
    }

    /// Looks at a step of a length with hJ, every so many steps, where it is longer than the one
    /// looked at last, and where a volume of states grows. Answers with a shorter one if it does
    /// not follow what grows, for a method of an order with a tolerance of a step, relative to the
    /// scales.
    #[inline]
    pub(super) fn shorter<V: States<T>>(
        &mut self,
        growth: &V::Matrix,
        (length, remaining): (T, T),
        scales: &V,
        (order, tolerance): (u8, f64),
    ) -> Option<T> {
        self.since += 1;
        let states = scales.count();
        let is_known = self.since < look(states) && length <= self.seen * lit(longer(states));
        if is_known && trace(states, growth.entries()) < lit(SPREADS) {
            return None;
        }
        let matters = MATTERS * to_f64(length / remaining);
        let times =
            fastest(growth, scales, matters).map(|growth| longer_by(growth, (order, tolerance)));
        let longest = times.map(|times| length * lit(times));
        if let Some(longest) = longest.filter(|&longest| longest < length) {
            let shorter = longest * lit(0.9);
            self.longest = Some(shorter);
            return Some(shorter);
        }
        (self.seen, self.since, self.longest) = (length, 0, longest);
        None
    }
}

/// The factor by which a step with hλ and |hμ| may be longer, or has to be shorter, for a method of
/// an order to follow to a tolerance.
fn longer_by((rate, swing): (f64, f64), (order, tolerance): (u8, f64)) -> f64 {
    let factorial = (2..=u32::from(order) + 1).fold(1.0, |product, i| product * f64::from(i));
    let swing = f64::max(swing, rate);
    let power = ComplexField::powi(swing, i32::from(order));
    let error = power * (swing / rate) / factorial;
    rough_power(tolerance / error, 1.0 / f64::from(order))
}

/// hλ of what grows fastest, and its |hμ|; none if hλ is not so large that it matters.
fn fastest<T: Scalar, V: States<T>>(
    growth: &V::Matrix,
    scales: &V,
    matters: f64,
) -> Option<(f64, f64)> {
    let (states, a) = (scales.count(), growth.entries());
    let size = norm(a, scales).smaller(norm(product(states, a, growth).entries(), scales).sqrt());
    let (most, halvings) = PART;
    let mut part = T::one();
    for _ in 0..halvings {
        if size * part > lit(most) {
            part *= lit(0.5);
        }
    }
    let mut power = scales.matrix();
    for i in 0..states {
        power.entries_mut()[i * states + i] = T::one();
    }
    power = Exponential::<T, V>::new(scales, a, part).apply_to(power);
    // e^(hJ·exponent − shift).
    let (mut exponent, mut shift) = (to_f64(part), 0.0);
    let mut small = lit::<T>(matters * exponent).exp();
    let dimension = to_f64(lit::<T>(states as f64).ln());
    loop {
        let size = norm(power.entries(), scales);
        if shift == 0.0 && size <= small {
            return None;
        }
        if size > lit(1e12) {
            power.entries_mut().iter_mut().for_each(|entry| *entry /= size);
            shift += to_f64(size.ln());
        }
        if exponent >= 4.0 {
            let trace = to_f64(trace(states, power.entries()).abs().ln()) + shift;
            let rate = (trace - dimension) / exponent;
            if exponent >= 32.0 && rate * exponent > 16.0 * (dimension + 1.0) {
                if rate < matters {
                    return None;
                }
                let turned = product(states, a, &product(states, a, &power));
                let swing =
                    euclidean(states, turned.entries()) / euclidean(states, power.entries());
                return Some((rate, to_f64(swing.sqrt())));
            }
        }
        if !(exponent < POWER) {
            return None;
        }
        power = product(states, power.entries(), &power);
        small *= small;
        (exponent, shift) = (exponent * 2.0, shift * 2.0);
    }
}

/// The largest sum of a row, in units of the scales.
fn norm<T: Scalar, V: States<T>>(matrix: &[T], scales: &V) -> T {
    let states = scales.count();
    let mut most = T::zero();
    for i in 0..states {
        let entries = (0..states).map(|j| matrix[j * states + i].abs() * scales[j]);
        let row = entries.fold(T::zero(), |sum, entry| sum + entry);
        most = most.larger(row / scales[i]);
    }
    most
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic, reason = "a test panics to fail")]
mod tests {
    use super::{Seeds, fastest, longer_by};
    use nalgebra::{Matrix3, Vector3};

    /// hJ with the eigenvalues λ ± iω and −κ in states of different units.
    fn matrix([rate, turn, decay]: [f64; 3], scales: &Vector3<f64>) -> Matrix3<f64> {
        let plain = Matrix3::new(rate, turn, 1.0, -turn, rate, -2.0, 0.0, 0.0, -decay);
        Matrix3::from_fn(|i, j| plain[(i, j)] * scales[i] / scales[j])
    }

    #[test]
    fn what_grows_fastest_is_found_in_any_units() {
        for scales in [Vector3::repeat(1.0), Vector3::new(1.0, 1e-9, 1e5)] {
            for (rate, turn) in [(0.3, 0.0), (0.05, 2.0), (3.0, 1.0), (0.1, 30.0), (50.0, 0.0)] {
                let growth = matrix([rate, turn, 1e3], &scales);
                let Some((found, swing)) = fastest(&growth, &scales, 1e-3) else {
                    panic!("{rate} {turn}: not found")
                };
                // From below, to a sixteenth; an approximation of e^z damps a little.
                assert!(found <= 1.001 * rate && found > 0.85 * rate, "{rate} {turn}: {found}");
                // With λ ≪ ω or ω = 0 it is |μ|, otherwise within the shape of an ellipse.
                let wanted = rate.hypot(turn);
                assert!(swing > 0.6 * wanted && swing < 1.6 * wanted, "{rate} {turn}: {swing}");
            }
            for (rate, turn) in [(-0.1, 2.0), (-1e-3, 30.0), (0.0, 0.0)] {
                assert_eq!(fastest(&matrix([rate, turn, 1e3], &scales), &scales, 1e-3), None);
            }
        }
    }

    #[test]
    fn a_step_that_an_order_follows_has_an_error_of_the_tolerance() {
        // Of e^z without turning: z⁶/720 over z.
        let z = 0.4;
        let times = longer_by((z, z), (5, 1e-6));
        let longest = z * times;
        assert!((longest.powi(5) / 720.0 / 1e-6 - 1.0).abs() < 0.1, "{longest}");
    }

    #[test]
    fn what_cannot_grow_much_until_the_end_is_left_alone() {
        let (scales, mut seeds) = (Vector3::repeat(1.0), Seeds::new());
        let growth = matrix([2.0, 0.0, 1e3], &scales);
        assert_eq!(seeds.shorter(&growth, (1.0, 1.5), &scales, (8, 1e-6)), None);
        let mut seeds = Seeds::new();
        let shorter = seeds.shorter(&growth, (1.0, 100.0), &scales, (8, 1e-6)).unwrap();
        assert!(shorter < 0.4, "{shorter}");
        assert!(seeds.longest().unwrap() >= shorter);
    }
}
