//! The exact step of one relaxing deflection under a held drive.

use super::HeldWeights;
use crate::Scalar;
use crate::scalar::lit;

/// The exact step of length h \[s\] of ż = −λz + u, with the relaxation rate λ [1/s] and the drive
/// u = r v [m/s] held: with x = λh, φ1(x) = (1 − e⁻ˣ)/x and φ2(x) = (1 − φ1(x))/x,
///
/// z(h) = e⁻ˣ z + φ1 h u,  mean of z over the step = φ1 z + φ2 h u.
///
/// Made by [`Affine::weights`](crate::Affine::weights), which says when to take it; used through
/// [`HeldWeights`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights<T> {
    /// x = λh
    exponent: T,
    /// e⁻ˣ
    decay: T,
    /// φ1 h \[s\]
    end_by_drive: T,
    /// φ1
    phi1: T,
    /// Two factors of φ2 h: of no unit, and \[s\].
    mean_by_drive: [T; 2],
}

impl<T: Scalar> Weights<T> {
    /// e⁻ˣ, φ1(x) = (1 − e⁻ˣ)/x and φ2(x) = (1 − φ1(x))/x without loss of digits, for x \[–\] of
    /// either sign: for steps of your own.
    #[inline]
    pub fn relaxed(x: T) -> (T, T, T) {
        if x < lit(0.5) && x > lit(-0.5) {
            // φ2 = Σ (−x)ᵏ/(k + 2)!, cut below 2e-17; the others follow from it without
            // cancellation. Even and odd powers apart and in pairs, so that the sums do not wait
            // for each other.
            const EVEN: [[f64; 2]; 3] = [
                [1.0 / 2.0, 1.0 / 24.0],
                [1.0 / 720.0, 1.0 / 40_320.0],
                [1.0 / 3_628_800.0, 1.0 / 479_001_600.0],
            ];
            const LAST_EVEN: f64 = 1.0 / 87_178_291_200.0;
            const ODD: [[f64; 2]; 3] = [
                [1.0 / 6.0, 1.0 / 120.0],
                [1.0 / 5040.0, 1.0 / 362_880.0],
                [1.0 / 39_916_800.0, 1.0 / 6_227_020_800.0],
            ];
            let w = x * x;
            let w2 = w * w;
            let pair = |pair: [f64; 2]| lit::<T>(pair[0]) + w * lit::<T>(pair[1]);
            let ([e0, e1, e2], [o0, o1, o2]) = (EVEN, ODD);
            let (mut even, mut odd) = (pair(e0) + w2 * pair(e1), pair(o0) + w2 * pair(o1));
            // In single precision the rest, less than x⁸/10! = 1e-9, is below the roundings.
            if T::default_epsilon() < lit(1e-10) {
                let w4 = w2 * w2;
                even += w4 * (pair(e2) + w2 * lit::<T>(LAST_EVEN));
                odd += w4 * pair(o2);
            }
            let phi2 = even - x * odd;
            let phi1 = T::one() - x * phi2;
            (T::one() - x * phi1, phi1, phi2)
        } else {
            let decay = (-x).exp();
            let phi1 = (T::one() - decay) / x;
            (decay, phi1, (T::one() - phi1) / x)
        }
    }

    /// The step of length h \[s\] at a relaxation rate λ [1/s].
    #[inline]
    pub(crate) fn new(relaxation: T, duration: T) -> Self {
        let exponent = relaxation * duration;
        let (decay, phi1, phi2) = Self::relaxed(exponent);
        let (end_by_drive, mean_by_drive) = if exponent < T::one() {
            (phi1 * duration, [phi2, duration])
        } else {
            // By way of the stationary deflection, which no length of step overflows. A λ that has
            // overflowed knows none.
            let inverse = T::one() / relaxation;
            let inverse = if inverse > T::zero() { inverse } else { T::nan() };
            ((T::one() - decay) * inverse, [T::one() - phi1, inverse])
        };
        Self { exponent, decay, end_by_drive, phi1, mean_by_drive }
    }

    /// λ ∫ z² dt over the step \[m²\], from the deflection's mean z̄ and its change Δz \[m\]: with
    /// p K it is the energy that the bristle dissipates by relaxing. Both terms of
    ///
    /// x z̄² + ½ L(x/2) Δz²,  L(y) = coth y − 1/y (Langevin's function)
    ///
    /// are squares, so that no rounding makes it negative.
    #[inline]
    pub fn relaxed_square(&self, mean: T, change: T) -> T {
        let x = self.exponent;
        // Above it the closed form loses less than two digits, of an f32 less than one.
        let series_to = if T::default_epsilon() < lit(1e-10) { 0.5 } else { 1.5 };
        let spread = if x < lit(series_to) {
            // Σ B₂ₙ xᵏ/(2n)! with k = 2n − 1 and Bernoulli's numbers, cut below 3e-16 of the first
            // (2e-9 of an f32).
            const SERIES: [f64; 7] = [
                1.0 / 12.0,
                -1.0 / 720.0,
                1.0 / 30_240.0,
                -1.0 / 1_209_600.0,
                1.0 / 47_900_160.0,
                -691.0 / 1_307_674_368_000.0,
                1.0 / 74_724_249_600.0,
            ];
            x * SERIES.iter().rev().fold(T::zero(), |sum, &c| lit::<T>(c) + x * x * sum)
        } else {
            let one = T::one();
            (lit::<T>(0.5) * (one + self.decay) - self.phi1) / (one - self.decay)
        };
        x * mean * mean + spread * change * change
    }
}

impl<T: Scalar> HeldWeights<T, T> for Weights<T> {
    #[inline(always)]
    fn end(&self, deflection: T, drive: T) -> T {
        self.decay * deflection + self.end_by_drive * drive
    }

    #[inline(always)]
    fn mean(&self, deflection: T, drive: T) -> T {
        self.undriven_mean(deflection) + self.driven_mean(drive)
    }

    // Neither waits for a product with zero.
    #[inline(always)]
    fn undriven_mean(&self, deflection: T) -> T {
        self.phi1 * deflection
    }

    #[inline(always)]
    fn driven_mean(&self, drive: T) -> T {
        let [share, time] = self.mean_by_drive;
        share * (time * drive)
    }

    // What does not wait for φ1 and φ2 is multiplied while they are computed.
    #[inline(always)]
    fn undriven_sums(&self, springs: [T; 2], state: T) -> [T; 2] {
        springs.map(|stiffness| self.undriven_mean(stiffness * state))
    }

    // In LuGre's fast sliding k r/λ is nearly −d: (1 − φ1) k r/λ + d is taken apart. Of the sum a
    // few roundings count as zero.
    #[inline(always)]
    fn driven_damping(&self, springs: T, drive: T, damping: T) -> T {
        let ([share, time], stiffness) = (self.mean_by_drive, springs * drive);
        if !(springs < T::zero() && self.exponent >= T::one()) {
            return share * (time * stiffness) + damping;
        }
        let part = time * stiffness;
        let rest = part + damping;
        let is_rounding = rest.abs() <= lit::<T>(16.0) * T::default_epsilon() * damping;
        (if is_rounding { T::zero() } else { rest }) - part * self.phi1
    }

    #[inline(always)]
    fn relaxed_energy(&self, stiffness: T, deflection: T, drive: T) -> T {
        let change = self.end(deflection, drive) - deflection;
        stiffness * self.relaxed_square(self.mean(deflection, drive), change)
    }
}

#[cfg(test)]
mod tests {
    use super::Weights;
    use approx::assert_relative_eq;

    #[test]
    fn the_series_and_the_closed_form_agree_where_they_meet() {
        // Just above the switch at ½ the closed form loses less than two digits; below it the
        // series loses none.
        let closed = |x: f64| {
            let phi1 = -(-x).exp_m1() / x;
            ((-x).exp(), phi1, (1.0 - phi1) / x)
        };
        for x in [0.3, 0.4, 0.499_999_999, 0.5, 0.7, 3.0, 50.0, 1e6, -0.4] {
            let (got, want) = (Weights::relaxed(x), closed(x));
            for (got, want) in [(got.0, want.0), (got.1, want.1), (got.2, want.2)] {
                assert_relative_eq!(got, want, max_relative = 2e-15);
            }
        }
        assert_eq!(Weights::relaxed(0.0), (1.0, 1.0, 0.5));
    }
}
