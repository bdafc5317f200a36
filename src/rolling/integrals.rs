//! The integrals a patch needs, each without loss of digits.
//!
//! ψ_k(x) = ∫₀¹ tᵏ e^(−xt) dt: moments of a decaying weight,
//! χ_k(α, x) = ∫₀¹ tᵏ⁺¹ φ1(xt) e^(−αt) dt = (ψ_k(α) − ψ_k(α + x))/x: moments of a profile that rises
//! from zero by 1 − e^(−xt), per x,
//!
//! with φ1(x) = (1 − e⁻ˣ)/x.

use nalgebra::{Complex, ComplexField};

use crate::Scalar;
use crate::scalar::lit;

/// Below this sum of exponents a power series needs at most [`TERMS`] terms.
const SMALL: f64 = 0.7;
const TERMS: usize = 16;

/// ψ₀ … ψ_{N−1} at any real x.
pub(super) fn decaying<T: Scalar, const N: usize>(x: T) -> [T; N] {
    decaying_with(x, (-x).exp())
}

/// The same where e⁻ˣ is known.
#[inline]
pub(super) fn decaying_with<T: Scalar, const N: usize>(x: T, decay: T) -> [T; N] {
    let mut psi = [T::zero(); N];
    if N == 0 {
        return psi;
    }
    let top = N as f64;
    if x > lit(2.0 * top) || x < lit(-2.0 * top) {
        // ψ_k = (k ψ_{k−1} − e⁻ˣ)/x shrinks errors where |x| > k.
        let inverse = T::one() / x;
        let mut last = (T::one() - decay) * inverse;
        psi[0] = last;
        for (k, psi) in psi.iter_mut().enumerate().skip(1) {
            last = (lit::<T>(k as f64) * last - decay) * inverse;
            *psi = last;
        }
        return psi;
    }
    // The highest from a series of positive terms, the others by ψ_{k−1} = (x ψ_k + e⁻ˣ)/k.
    let mut last = if x < T::zero() {
        // Σ |x|ⁿ/(n! (k + n + 1))
        let (mut term, mut sum) = (T::one(), T::one() / lit(top));
        for n in 1..200 {
            term *= -x / lit(n as f64);
            let next = sum + term / lit(top + n as f64);
            if next == sum {
                break;
            }
            sum = next;
        }
        sum
    } else {
        // e⁻ˣ Σ xⁿ/((k + 1) … (k + 1 + n))
        let mut term = T::one() / lit(top);
        let mut sum = term;
        for n in 1..200 {
            term *= x / lit(top + n as f64);
            let next = sum + term;
            if next == sum {
                break;
            }
            sum = next;
        }
        decay * sum
    };
    psi[N - 1] = last;
    for k in (1..N).rev() {
        last = (x * last + decay) / lit(k as f64);
        psi[k - 1] = last;
    }
    psi
}

/// χ₀ … χ_{N−1} for α ≥ −50 and x ≥ 0.
#[inline]
pub(super) fn rising<T: Scalar, const N: usize>(alpha: T, x: T) -> [T; N] {
    if x + alpha < lit(SMALL) && alpha > lit(-SMALL) {
        // Σ (−1)ⁿ⁺¹ dₙ/(n! (k + n + 1)) from n = 1, with dₙ = ((α + x)ⁿ − αⁿ)/x.
        let both = alpha + x;
        let mut chi = [T::zero(); N];
        // dₙ (−1)ⁿ⁺¹/n! and αⁿ (−1)ⁿ⁺¹/n!, of which the next follow.
        let mut term = T::one();
        let mut power = alpha;
        // The last term of each choice is below a rounding of the first.
        let size = if alpha < T::zero() { x - alpha } else { both };
        let terms = if size < lit(1e-4) {
            4
        } else if size < lit(0.01) {
            7
        } else {
            TERMS
        };
        for n in 1..=terms {
            for (k, chi) in chi.iter_mut().enumerate() {
                *chi += term * lit(RECIPROCALS[(k + n + 1).min(RECIPROCALS.len() - 1)]);
            }
            let inverse = lit::<T>(-RECIPROCALS[n + 1]);
            term = (both * term + power) * inverse;
            power *= alpha * inverse;
        }
        return chi;
    }
    if x > lit(0.5) {
        let inverse = T::one() / x;
        let (slow, fast) = (decaying::<T, N>(alpha), decaying::<T, N>(alpha + x));
        return core::array::from_fn(|k| (slow[k] - fast[k]) * inverse);
    }
    // A short rise under a steep weight.
    let mut chi = [T::zero(); N];
    integrate(alpha.abs() + x, |t, weight| {
        let mut value = weight * t * phi1(x * t) * (-alpha * t).exp();
        for chi in &mut chi {
            *chi += value;
            value *= t;
        }
    });
    chi
}

/// 1/n for small n; 0 is never asked for.
const RECIPROCALS: [f64; 64] = {
    let mut table = [1.0; 64];
    let mut n = 1;
    while n < 64 {
        table[n] = 1.0 / n as f64;
        n += 1;
    }
    table
};

/// φ1(x) = (1 − e⁻ˣ)/x.
pub(super) fn phi1<T: Scalar>(x: T) -> T {
    decaying::<T, 1>(x)[0]
}

/// Calls `visit` with places t ∈ (0, 1) and weights of a quadrature that is exact to rounding for smooth
/// integrands with parts that decay by up to e^(−steepness) from either end to the other.
pub(super) fn integrate<T: Scalar>(steepness: T, mut visit: impl FnMut(T, T)) {
    // Eight points miss e^(−3t) by less than a rounding; e^(−42) is below one.
    const PANEL: f64 = 3.0;
    const PANELS_TO_NOTHING: usize = 14;
    let mut panel = |from: T, to: T| {
        for (place, weight) in GAUSS {
            visit(from + (to - from) * lit(place), (to - from) * lit(weight));
        }
    };
    let two: T = lit(2.0);
    if steepness < lit(2.0 * PANEL * PANELS_TO_NOTHING as f64) {
        // At most 28, all alike.
        let mut panels = T::one();
        while panels * lit(PANEL) < steepness {
            panels += T::one();
        }
        let (width, mut number) = (T::one() / panels, T::zero());
        while number < panels {
            panel(number * width, (number + T::one()) * width);
            number += T::one();
        }
    } else {
        let width = lit::<T>(PANEL) / steepness;
        let layer = width * lit(PANELS_TO_NOTHING as f64);
        for number in 0..PANELS_TO_NOTHING {
            let from = width * lit(number as f64);
            panel(from, from + width);
            panel(T::one() - from - width, T::one() - from);
        }
        // Nothing steep is left between the two.
        let middle = T::one() / two;
        panel(layer, middle);
        panel(middle, T::one() - layer);
    }
}

/// The same with five points for an integrand that is hardly steep: a polynomial of at most the fourth
/// degree times e^(−steepness t), which they miss by less than 4e-13 · 5040 steepness⁶ of its largest
/// value.
pub(super) fn integrate_gentle<T: Scalar>(
    degree: usize,
    steepness: T,
    mut visit: impl FnMut(T, T),
) {
    if degree <= 4 && steepness <= lit(0.1) {
        for (place, weight) in GAUSS_5 {
            visit(lit(place), lit(weight));
        }
    } else {
        integrate(steepness, visit);
    }
}

/// Gauss–Legendre quadrature with five points on [0, 1] (table 25.4 likewise).
const GAUSS_5: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_6, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

/// Gauss–Legendre quadrature with eight points on [0, 1] (M. Abramowitz and I. A. Stegun, "Handbook of
/// Mathematical Functions", table 25.4, moved).
pub(super) const GAUSS: [(f64, f64); 8] = [
    (0.019_855_071_751_231_884, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_63, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_64),
    (0.408_282_678_752_175_1, 0.181_341_891_689_180_99),
    (0.591_717_321_247_824_9, 0.181_341_891_689_180_99),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_64),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];

/// ψ₀ … ψ_{N−1} at a complex x.
pub(super) fn complex_decaying<T: Scalar, const N: usize>(x: Complex<T>) -> [Complex<T>; N] {
    let zero = Complex::new(T::zero(), T::zero());
    let mut psi = [zero; N];
    if N == 0 {
        return psi;
    }
    let decay = (-x).exp();
    let size = x.modulus();
    if size > lit(2.0 * N as f64 + 2.0) {
        let inverse = Complex::new(T::one(), T::zero()) / x;
        let mut last = (Complex::new(T::one(), T::zero()) - decay) * inverse;
        psi[0] = last;
        for (k, psi) in psi.iter_mut().enumerate().skip(1) {
            last = (last.scale(lit(k as f64)) - decay) * inverse;
            *psi = last;
        }
        return psi;
    }
    integrate(size, |t, weight| {
        let mut value = (-x.scale(t)).exp().scale(weight);
        for psi in &mut psi {
            *psi += value;
            value = value.scale(t);
        }
    });
    psi
}
