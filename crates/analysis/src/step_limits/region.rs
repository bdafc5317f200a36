//! Stability functions, and how far one can go along a ray before |R| exceeds one.

use bristle::root::enclose;
use nalgebra::{Complex, ComplexField};

use super::Scheme;

/// A stability function R(z) = 1 + z + … + z^p/p! + further terms: the order p, and these terms.
type Polynomial = (usize, &'static [f64]);

/// Coefficients of the longest of them, that of Dormand–Prince 8.
const MOST: usize = 13;

/// The polynomial R; none where no step is too long for a decaying motion, and none for schemes
/// that no R describes. The further terms are sums Σ bᵢ aᵢⱼ … over chains of as many a of the
/// tableau, in exact arithmetic from the printed one.
pub(super) fn polynomial(scheme: Scheme) -> Option<Polynomial> {
    match scheme {
        // The bristle alone, under a held velocity, is stepped by the explicit Euler method.
        Scheme::Euler | Scheme::SemiImplicitEuler => Some((1, &[])),
        Scheme::RungeKutta4 => Some((4, &[])),
        Scheme::DormandPrince => Some((5, &[1.0 / 600.0])),
        Scheme::DormandPrince8 => Some((8, &DORMAND_PRINCE_8)),
        Scheme::ExactHold | Scheme::Passive | Scheme::Rosenbrock => None,
    }
}

const DORMAND_PRINCE_8: [f64; 4] = [
    2.691_692_200_169_087e-6,
    2.341_345_108_209_781_3e-7,
    1.494_736_485_459_154_7e-8,
    3.613_324_578_128_245e-10,
];

/// Motions whose damping ratio is smaller than this count as undamped: it is within the rounding of
/// eigenvalues.
const UNDAMPED: f64 = 1e-10;

/// The largest step at which a motion e^(st) does not grow; `None` without limit, as for a motion
/// that stands still or grows by itself.
pub(super) fn largest_step(scheme: Scheme, rate: Complex<f64>) -> Option<f64> {
    let polynomial = polynomial(scheme)?;
    let size = ComplexField::sqrt(rate.norm_sqr());
    if size == 0.0 || rate.re > UNDAMPED * size {
        return None;
    }
    let limit = reach(polynomial, rate / size) / size;
    limit.is_finite().then_some(limit)
}

/// Terms of |R|²: one more than twice the largest degree.
const TERMS: usize = 2 * (MOST - 1) + 1;

/// How far along a ray from zero, in a direction of unit length, |R| first exceeds one.
fn reach((order, further): Polynomial, direction: Complex<f64>) -> f64 {
    let direction = if direction.re.abs() <= UNDAMPED {
        Complex::new(0.0, direction.im.signum())
    } else {
        direction
    };
    // |R(xu)|² = Σ dⱼ xʲ. For a motion without damping the first dⱼ vanish; what rounding leaves of
    // them would decide the answer.
    let (mut powers, mut polynomial) = ([Complex::new(1.0, 0.0); MOST], [1.0; MOST]);
    let mut factorial = 1.0;
    for k in 1..MOST {
        powers[k] = powers[k - 1] * direction;
        factorial *= k as f64;
        let beyond = k.checked_sub(order + 1).map(|k| further.get(k).copied().unwrap_or(0.0));
        polynomial[k] = beyond.unwrap_or(1.0 / factorial);
    }
    let mut terms = [0.0; TERMS];
    let mut sizes = [0.0; TERMS];
    for (k, a) in polynomial.iter().enumerate() {
        for (l, b) in polynomial.iter().enumerate() {
            terms[k + l] += a * b * (powers[k] * powers[l].conj()).re;
            sizes[k + l] += a * b;
        }
    }
    terms[0] = 0.0; // |R|² − 1
    for (term, size) in terms.iter_mut().zip(sizes) {
        if term.abs() <= 1e-14 * size {
            *term = 0.0;
        }
    }
    let first = terms.iter().position(|term| *term != 0.0).unwrap_or(0);
    let excess = |x: f64| terms[first..].iter().rev().fold(0.0, |sum, term| sum * x + term);
    if excess(0.0) > 0.0 {
        return 0.0;
    }
    // Every region here lies within |z| < 8; its indentations are wider than a sixty-fourth.
    let mut inside = 0.0;
    while inside < 16.0 && !(excess(inside + 1.0 / 64.0) > 0.0) {
        inside += 1.0 / 64.0;
    }
    let outside = inside + 1.0 / 64.0;
    enclose(excess, (inside, excess(inside)), (outside, excess(outside)), 0.0).0
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test panics to fail")]
mod tests {
    use super::*;

    fn along_the_real_axis(scheme: Scheme) -> f64 {
        largest_step(scheme, Complex::new(-1.0, 0.0)).unwrap()
    }

    #[test]
    fn the_real_axis_is_left_where_exact_arithmetic_leaves_it() {
        // Bisected in rational arithmetic.
        for (scheme, limit) in [
            (Scheme::Euler, 2.0),
            (Scheme::RungeKutta4, 2.785_293_563_405_282),
            (Scheme::DormandPrince, 3.306_567_892_634_946_7),
            (Scheme::DormandPrince8, 6.393_651_522_851_058),
        ] {
            // |R|² is flattest for the last, where e^6.4 amplifies rounding.
            let got = along_the_real_axis(scheme);
            assert!((got - limit).abs() < 1e-9, "{scheme}: {got}, not {limit}");
        }
    }

    #[test]
    fn the_imaginary_axis_is_left_where_the_closed_forms_say() {
        // RK4: |R(iy)|² = 1 − y⁶/72 + y⁸/576.
        let undamped = |scheme| largest_step(scheme, Complex::new(0.0, 1.0));
        assert_eq!(undamped(Scheme::Euler), Some(0.0));
        let rk4 = undamped(Scheme::RungeKutta4).unwrap();
        assert!((rk4 - 8.0f64.sqrt()).abs() < 1e-12, "{rk4}");
    }

    #[test]
    fn what_stands_still_or_grows_sets_no_limit() {
        assert_eq!(largest_step(Scheme::Euler, Complex::new(0.0, 0.0)), None);
        assert_eq!(largest_step(Scheme::Euler, Complex::new(1.0, 1.0)), None);
        assert_eq!(largest_step(Scheme::Rosenbrock, Complex::new(-1.0, 1.0)), None);
    }
}
