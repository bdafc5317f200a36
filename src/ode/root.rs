//! The place of a sign change.

use crate::Scalar;
use crate::scalar::{is_zero, lit};

/// The argument in [a, b] at which a function of opposite signs at both ends passes zero, on the
/// side of b: by the Illinois variant of regula falsi, bisected where that stalls.
pub(crate) fn crossing<T: Scalar>(
    mut function: impl FnMut(T) -> T,
    (mut a, mut at_a): (T, T),
    (mut b, mut at_b): (T, T),
) -> T {
    if is_zero(at_a) {
        return a;
    }
    if is_zero(at_b) {
        return b;
    }
    let half: T = lit(0.5);
    let tolerance = T::default_epsilon() * lit(4.0);
    for round in 0..200 {
        if (b - a).abs() <= tolerance * (T::one() + b.abs()) {
            break;
        }
        let secant = b - at_b * (b - a) / (at_b - at_a);
        let inside = (secant - a) * (b - secant) > T::zero();
        let c = if inside && round % 4 != 3 { secant } else { (a + b) * half };
        let at_c = function(c);
        if is_zero(at_c) {
            return c;
        }
        if (at_c > T::zero()) == (at_b > T::zero()) {
            b = c;
            at_b = at_c;
            at_a *= half;
        } else {
            a = c;
            at_a = at_c;
            at_b *= half;
        }
    }
    b
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::crossing;

    #[test]
    fn roots_are_found_to_rounding_also_of_flat_and_steep_functions() {
        let root = 0.3;
        for power in [1, 3, 9] {
            let f = |x: f64| (x - root).powi(power);
            let found = crossing(f, (0.0, f(0.0)), (1.0, f(1.0)));
            // A flat root is only known to where the function is distinguishable from zero.
            assert!((found - root).abs() < 1e-14 * 10.0, "{power}: {found}");
        }
        let step = |x: f64| if x < root { -1e-9 } else { 1e9 };
        assert!((crossing(step, (0.0, -1e-9), (1.0, 1e9)) - root).abs() < 1e-14);
    }

    #[test]
    fn the_answer_lies_on_the_far_side_of_the_crossing() {
        let f = |x: f64| x * x - 0.5;
        assert!(f(crossing(f, (0.0, -0.5), (1.0, 0.5))) >= 0.0);
    }
}
