//! The place of a sign change: of an event within a step, or of an equation of your own.

use crate::Scalar;
use crate::scalar::{is_zero, lit};

/// Encloses a zero of a function that has opposite signs at a and b, each given with the value
/// there. Returns the ends of an interval no longer than `tolerance`, or than rounding allows,
/// first the one on the side of a; twice the place itself if the function is zero there.
///
/// By regula falsi, with the weight of an end that stays for a second time halved (Illinois), and
/// bisection where that is slow.
pub fn enclose<T: Scalar>(
    mut function: impl FnMut(T) -> T,
    (mut a, mut at_a): (T, T),
    (mut b, mut at_b): (T, T),
    tolerance: T,
) -> (T, T) {
    if is_zero(at_a) {
        return (a, a);
    }
    if is_zero(at_b) {
        return (b, b);
    }
    let half: T = lit(0.5);
    let side_of_b = at_b > T::zero();
    // Which end moved last.
    let mut moved = None;
    let (mut slow, mut width) = (false, b - a);
    for round in 0..400 {
        let middle = (a + b) * half;
        if !(middle > a && middle < b && b - a > tolerance) {
            break;
        }
        if round % 3 == 2 {
            slow = (b - a) * lit(2.0) > width;
            width = b - a;
        }
        // Within a rounding of an end it is on, the secant steps off it to enclose the root.
        let rounding = T::default_epsilon() * (a.abs() + b.abs());
        let secant = b - at_b * (b - a) / (at_b - at_a);
        let secant = if secant - a < rounding { a + rounding } else { secant };
        let secant = if b - secant < rounding { b - rounding } else { secant };
        let inside = secant > a && secant < b;
        let c = if inside && !slow { secant } else { middle };
        slow = false;
        let at_c = function(c);
        if is_zero(at_c) {
            return (c, c);
        }
        if (at_c > T::zero()) == side_of_b {
            b = c;
            at_b = at_c;
            if moved == Some(true) {
                at_a *= half;
            }
            moved = Some(true);
        } else {
            a = c;
            at_a = at_c;
            if moved == Some(false) {
                at_b *= half;
            }
            moved = Some(false);
        }
    }
    (a, b)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::enclose;
    use core::cell::Cell;

    #[test]
    fn a_crossing_is_found_to_rounding_with_few_looks() {
        let looks = Cell::new(0);
        let most = Cell::new(0);
        let find = |f: &dyn Fn(f64) -> f64, a: f64, b: f64| {
            looks.set(0);
            let counted = |x| {
                looks.set(looks.get() + 1);
                f(x)
            };
            let found = enclose(counted, (a, f(a)), (b, f(b)), 0.0).0;
            most.set(most.get().max(looks.get()));
            found
        };
        for shift in 0..20 {
            let root = 0.3 + f64::from(shift) * 1e-3;
            let wave = |x: f64| -(x - root).sin();
            assert!((find(&wave, 0.0, 1.5) - root).abs() <= 2e-16, "{shift}");
            assert!(wave(find(&wave, 0.0, 1.5)) >= 0.0);
            let bent = |x: f64| (root - x) * (x + 0.01) * (2.0 - x);
            assert!((find(&bent, 0.0, 1.5) - root).abs() <= 2e-16, "{shift}");
            let line = |x: f64| root - x;
            assert!((find(&line, 0.0, 1e3) - root).abs() <= 2e-13, "{shift}");
        }
        // An order of 1.44 from a tenth to a rounding, and two looks to enclose the root.
        assert!(most.get() <= 18, "{most:?}");
        // Flat, and steep: bisection helps.
        let step = |x: f64| if x < 0.3 { 1e-9 } else { -1e9 };
        assert!((find(&step, 0.0, 1.0) - 0.3).abs() < 1e-15);
        let flat = |x: f64| (0.3 - x) * (0.3 - x) * (0.3 - x);
        assert!((find(&flat, 0.0, 1.0) - 0.3).abs() < 1e-15);
    }

    #[test]
    fn the_ends_lie_on_their_sides_of_the_crossing() {
        let f = |x: f64| x * x - 0.5;
        let (before, after) = enclose(f, (0.0, -0.5), (1.0, 0.5), 1e-6);
        assert!(f(before) < 0.0 && f(after) > 0.0 && after - before <= 1e-6);
    }
}
