//! The step-size controller.
//!
//! h ← h · 0.9 · err^(−α) · err₋₁^β with α = (1 − 3β'/4)/q, β = β'/q, β' = 0.2, where err is the
//! error of the step over its tolerance, err₋₁ that of the step before, and q the order of the
//! estimate. It is a PI controller: the second factor keeps the step steady where stability limits
//! it, not accuracy.
//!
//! Source: E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", 2nd edition
//! (Springer, 1996), section IV.2.

/// The memory of the controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Controller {
    /// Mean square of the error of the last accepted step.
    before: f64,
    /// Trials rejected in a row. After one the step may not grow; after two the estimate is not yet
    /// in its asymptotic range, and the step shrinks faster.
    rejected: u32,
}

const SAFETY: f64 = 0.9;
const SMALLEST: f64 = 0.1;
const LARGEST: f64 = 8.0;
/// Largest factor after a second rejection in a row.
const HURRY: f64 = 0.6;
/// Errors below 10⁻² of the tolerance say nothing about the trend.
const FLOOR: f64 = 1e-4;

impl Controller {
    pub(crate) fn new() -> Self {
        Self { before: 1.0, rejected: 0 }
    }

    /// Whether the last trial was rejected.
    pub(crate) fn is_rejecting(&self) -> bool {
        self.rejected > 0
    }

    /// The factor for the step after an accepted one, from the mean square of its error and the
    /// order q of the estimate.
    pub(crate) fn accepted(&mut self, square: f64, order: u8) -> f64 {
        let q = f64::from(order);
        // The mean square is the error squared, hence the halves.
        let proportional = rough_power(square, -0.5 * 0.85 / q);
        let trend = rough_power(self.before, 0.5 * 0.2 / q);
        let largest = if self.rejected > 0 { 1.0 } else { LARGEST };
        self.before = if square > FLOOR { square } else { FLOOR };
        self.rejected = 0;
        (SAFETY * proportional * trend).clamp(SMALLEST, largest)
    }

    /// The factor for the trial after a rejected one; the error may not be finite.
    pub(crate) fn rejected(&mut self, square: f64, order: u8) -> f64 {
        self.rejected += 1;
        if square.is_finite() {
            let factor = SAFETY * rough_power(square, -0.5 / f64::from(order));
            factor.clamp(SMALLEST, if self.rejected > 1 { HURRY } else { SAFETY })
        } else {
            0.25
        }
    }
}

/// x^e to within one percent for |e| ≤ 1, without the cost of `powf`: between powers of two the
/// logarithm and the exponential are straight lines with a parabolic correction.
pub(crate) fn rough_power(x: f64, exponent: f64) -> f64 {
    /// Makes the parabola exact in the middle between two powers of two.
    const BEND: f64 = 0.34;
    const MANTISSA: u64 = (1 << 52) - 1;
    const ONE: u64 = 1023 << 52;
    // An error of zero is as good as the smallest normal number.
    let bits = if x > f64::MIN_POSITIVE { x } else { f64::MIN_POSITIVE }.to_bits();
    let fraction = f64::from_bits(bits & MANTISSA | ONE) - 1.0;
    let logarithm = (bits >> 52) as f64 - 1023.0 + fraction + BEND * fraction * (1.0 - fraction);
    let power = (logarithm * exponent).clamp(-1000.0, 1000.0);
    let mut whole = power as i64;
    if (whole as f64) > power {
        whole -= 1;
    }
    let fraction = power - whole as f64;
    let mantissa = 1.0 + fraction - BEND * fraction * (1.0 - fraction);
    mantissa * f64::from_bits(((1023 + whole) as u64) << 52)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{Controller, HURRY, LARGEST, SAFETY, rough_power};

    #[test]
    fn a_step_does_not_grow_after_a_rejection_and_shrinks_faster_after_two() {
        let mut controller = Controller::new();
        assert_eq!(controller.accepted(0.0, 5), LARGEST);
        // An error of 1.01 of the tolerance hardly asks for less.
        let first = controller.rejected(1.02, 5);
        assert!(first > 0.85 && first <= SAFETY, "{first}");
        let second = controller.rejected(1.02, 5);
        assert_eq!(second, HURRY);
        assert_eq!(controller.accepted(0.0, 5), 1.0);
        assert_eq!(controller.accepted(0.0, 5), LARGEST);
        assert_eq!(controller.rejected(f64::NAN, 5), 0.25);
    }

    #[test]
    fn the_trend_of_the_error_counts() {
        let after = |before: f64| {
            let mut controller = Controller::new();
            controller.accepted(before, 5);
            controller.accepted(0.25, 5)
        };
        // A falling error lets the step grow more than a rising one.
        assert!(after(1.0) > 1.05 * after(0.01), "{} {}", after(1.0), after(0.01));
    }

    #[test]
    fn the_rough_power_is_within_one_percent() {
        for exponent in [-1.0, -0.5, -0.1, -0.085, 0.02, 0.1, 1.0] {
            for i in -3000..3000 {
                let x = 10f64.powf(f64::from(i) * 0.01);
                let ratio = rough_power(x, exponent) / x.powf(exponent);
                assert!((ratio - 1.0).abs() < 0.01, "{x}^{exponent}: {ratio}");
            }
        }
        assert!(rough_power(0.0, -0.1).is_finite());
    }
}
