//! The integrals a patch needs, each without loss of digits.
//!
//! ψ_k(x) = ∫₀¹ tᵏ e^(−xt) dt: moments of a decaying weight,
//! χ_k(α, x) = ∫₀¹ tᵏ⁺¹ φ1(xt) e^(−αt) dt = (ψ_k(α) − ψ_k(α + x))/x: moments of a profile that rises
//! from zero by 1 − e^(−xt), per x,
//!
//! with φ1(x) = (1 − e⁻ˣ)/x. Both have three-term recurrences that lose nothing in one direction only;
//! which one depends on whether k or |x| is larger.

use nalgebra::{Complex, ComplexField};

use crate::Scalar;
use crate::bounds::larger;
use crate::scalar::{lit, nan};

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
        for k in 1..N {
            last = (lit::<T>(k as f64) * last - decay) * inverse;
            psi[k] = last;
        }
        return psi;
    }
    // The highest from a series of positive terms, the others by ψ_{k−1} = (x ψ_k + e⁻ˣ)/k.
    if x < T::zero() {
        // Σ |x|ⁿ/(n! (k + n + 1))
        let (mut term, mut last) = (T::one(), T::one() / lit(top));
        for n in 1..200 {
            term *= -x / lit(n as f64);
            let next = last + term / lit(top + n as f64);
            if next == last {
                break;
            }
            last = next;
        }
        psi[N - 1] = last;
        // Downwards errors grow by |x|/k, upwards they shrink by k/|x|.
        let mut k = N - 1;
        while k > 0 && lit::<T>(k as f64) >= -x {
            last = (x * last + decay) / lit(k as f64);
            psi[k - 1] = last;
            k -= 1;
        }
        if k > 0 {
            // Here x < −1.
            let inverse = T::one() / x;
            last = (T::one() - decay) * inverse;
            psi[0] = last;
            for (j, psi) in psi.iter_mut().enumerate().take(k).skip(1) {
                last = (lit::<T>(j as f64) * last - decay) * inverse;
                *psi = last;
            }
        }
        return psi;
    }
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
    let mut last = decay * sum;
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
        for n in 1..=TERMS {
            for (k, chi) in chi.iter_mut().enumerate() {
                *chi += term * lit(RECIPROCALS[(k + n + 1).min(RECIPROCALS.len() - 1)]);
            }
            let inverse = lit::<T>(-RECIPROCALS[n + 1]);
            term = (both * term + power) * inverse;
            power *= alpha * inverse;
        }
        return chi;
    }
    // The weight is spread over a length of about 1/(1 + α), over which the rise has to be felt for
    // the difference to keep its digits.
    let rises = lit::<T>(0.5) * larger(T::one(), T::one() + alpha);
    if x > rises {
        let inverse = T::one() / x;
        let (slow, fast) = (decaying::<T, N>(alpha), decaying::<T, N>(alpha + x));
        return core::array::from_fn(|k| (slow[k] - fast[k]) * inverse);
    }
    // A slow rise under a steep weight.
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

/// Calls `visit` with places t ∈ (0, 1) and weights of a quadrature that is exact to rounding for
/// polynomials up to degree 15 with parts that decay by up to e^(−steepness) from either end to the other.
pub(super) fn integrate<T: Scalar>(steepness: T, visit: impl FnMut(T, T)) {
    integrate_in(4, steepness, visit);
}

/// The same for integrands that are smooth on the scale of 1/`panels`.
pub(super) fn integrate_in<T: Scalar>(panels: usize, steepness: T, mut visit: impl FnMut(T, T)) {
    // Eight points miss e^(−2t) by 2e-18, and e^(−48) is below a rounding.
    const PANEL: f64 = 2.0;
    const LAYER: usize = 24;
    if steepness < lit(2.0 * PANEL * LAYER as f64) {
        let mut number = panels;
        while lit::<T>(number as f64 * PANEL) < steepness {
            number += 1;
        }
        evenly((T::zero(), T::one()), number, &mut visit);
    } else {
        let layer = lit::<T>(PANEL * LAYER as f64) / steepness;
        evenly((T::zero(), layer), LAYER, &mut visit);
        // Nothing steep is left between the two.
        evenly((layer, T::one() - layer), panels, &mut visit);
        evenly((T::one() - layer, T::one()), LAYER, &mut visit);
    }
}

/// Gauss panels of equal width.
fn evenly<T: Scalar>((from, to): (T, T), panels: usize, visit: &mut impl FnMut(T, T)) {
    let width = (to - from) / lit(panels as f64);
    for number in 0..panels {
        let start = from + lit::<T>(number as f64) * width;
        for (place, weight) in GAUSS {
            visit(start + width * lit(place), width * lit(weight));
        }
    }
}

/// The same as [`integrate_in`] for integrands with a factor e^(−sξ), Re s ≥ 0, which may be a wave
/// that nothing damps. The work grows with |s|; beyond 2 097 152 the weights are NaN.
pub(super) fn integrate_wave<T: Scalar>(
    panels: usize,
    rate: Complex<T>,
    mut visit: impl FnMut(T, T),
) {
    const MOST: usize = 1 << 20;
    let size = rate.modulus();
    if rate.re >= rate.im.abs() {
        integrate_in(panels, size, visit);
    } else if size < lit(2.0 * MOST as f64) {
        let mut number = panels;
        while lit::<T>(number as f64 * 2.0) < size {
            number += 1;
        }
        evenly((T::zero(), T::one()), number, &mut visit);
    } else {
        visit(T::zero(), nan());
    }
}

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
        for k in 1..N {
            last = (last.scale(lit(k as f64)) - decay) * inverse;
            psi[k] = last;
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

/// φ1(x) = (1 − e⁻ˣ)/x at a complex x.
pub(super) fn complex_phi1<T: Scalar>(x: Complex<T>) -> Complex<T> {
    if x.modulus() < lit(0.5) {
        // Σ (−x)ⁿ/(n + 1)!, cut below 1e-19.
        let one = Complex::new(T::one(), T::zero());
        (2..=14).rev().fold(one, |sum, n| one - (x * sum).scale(lit(1.0 / f64::from(n))))
    } else {
        (Complex::new(T::one(), T::zero()) - (-x).exp()) / x
    }
}
