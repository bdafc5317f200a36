//! Floquet multipliers, with the factors of Φ kept apart.
//!
//! Φ = Φ_M … Φ₁,  Φ_k Q_{k−1} = Q_k R_k,  Q₀ᵀ Φ Q₀ = S R_M … R₁,  S = Q₀ᵀ Q_M
//!
//! | symbol | meaning |
//! |---|---|
//! | Φ_k | derivatives over a part of the run |
//! | Q_k, R_k | orthogonal, and upper triangular |
//!
//! One pass over the factors follows another, with Q₀ the Q_M before, until S is diagonal or
//! block-diagonal: then the multipliers are products of the diagonals of R_k, taken as sums of
//! logarithms, or eigenvalues of a product of blocks. No sum mixes what is 10⁻³⁰⁰ with what is one,
//! so each multiplier keeps its digits. Multipliers of similar size (within a factor of eight)
//! and complex pairs stay together in a block.
//!
//! Source: A. W. Bojanczyk, G. H. Golub, P. Van Dooren, "The periodic Schur decomposition" (SPIE
//! 1770, 1992); here by simultaneous iteration instead of chased bulges.

use core::f64::consts::PI;

use nalgebra::{Complex, DMatrix, SMatrix, Schur};

/// Passes over the factors, at most: they separate multipliers whose ratio is below 0.12.
const MOST_PASSES: usize = 12;

/// Entries of S below this separate blocks.
const SEPARATE: f64 = 1e-11;

/// Passes after S has become diagonal: the error of a multiplier, relative to itself, is then the
/// square of this.
const PASSES_MORE: usize = 2;

/// A Floquet multiplier μ: by what a small disturbance is multiplied over a period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Multiplier {
    /// ln |μ|; below zero if the disturbance dies out, −∞ if at once.
    pub log_modulus: f64,
    /// The angle of μ \[rad\], in −π … π: 0 for a positive real one, π for a negative one.
    pub angle: f64,
}

impl Multiplier {
    /// μ, zero below 10⁻³⁰⁸.
    pub fn value(&self) -> Complex<f64> {
        Complex::from_polar(self.log_modulus.exp(), self.angle)
    }

    /// Whether |μ| is one within the roundings of the runs, 10⁻⁹: neither does the disturbance die
    /// out, nor does it grow.
    pub fn is_neutral(&self) -> bool {
        self.log_modulus.abs() < 1e-9
    }

    /// μ²
    pub(crate) fn squared(self) -> Self {
        let turns = (self.angle / PI).round();
        Self { log_modulus: 2.0 * self.log_modulus, angle: 2.0 * (self.angle - turns * PI) }
    }
}

/// All but the multiplier that is 1.
pub(crate) fn without_one(all: &[Multiplier]) -> Vec<Multiplier> {
    let off = |m: &Multiplier| (m.value() - 1.0).norm();
    let mut others = all.to_vec();
    let one = (0..all.len()).min_by(|&a, &b| off(&all[a]).total_cmp(&off(&all[b])));
    one.map(|at| others.remove(at));
    others
}

/// The multipliers of a product of factors, the first first; by decreasing modulus. `None` if the
/// factors are not finite.
pub(crate) fn multipliers<const N: usize>(
    factors: &[SMatrix<f64, N, N>],
) -> Option<[Multiplier; N]> {
    if !factors.iter().all(|factor| factor.iter().all(|entry| entry.is_finite())) {
        return None;
    }
    let mut q = DMatrix::<f64>::identity(N, N);
    let (mut triangles, mut turn) = (Vec::new(), q.clone());
    let mut left = PASSES_MORE;
    for _ in 0..MOST_PASSES {
        let start = q.clone();
        triangles.clear();
        for factor in factors {
            let decomposed = (DMatrix::from_fn(N, N, |i, j| factor[(i, j)]) * &q).qr();
            q = decomposed.q();
            triangles.push(decomposed.r());
        }
        turn = start.transpose() * &q;
        if (1..N).all(|at| separates(&turn, at)) {
            left -= 1;
            if left == 0 {
                break;
            }
        }
    }
    let (mut all, mut from) = (Vec::with_capacity(N), 0);
    for to in (1..=N).filter(|&at| at == N || separates(&turn, at)) {
        all.extend(block(&triangles, &turn, from, to - from)?);
        from = to;
    }
    all.sort_by(|a, b| b.log_modulus.total_cmp(&a.log_modulus));
    all.try_into().ok()
}

/// Whether a block of S ends before this row.
fn separates(turn: &DMatrix<f64>, at: usize) -> bool {
    let size = turn.nrows();
    turn.view((at, 0), (size - at, at)).iter().all(|entry| entry.abs() <= SEPARATE)
}

/// The multipliers of a diagonal block.
fn block(
    triangles: &[DMatrix<f64>],
    turn: &DMatrix<f64>,
    from: usize,
    size: usize,
) -> Option<Vec<Multiplier>> {
    let (mut product, mut log_scale) = (DMatrix::<f64>::identity(size, size), 0.0);
    for triangle in triangles {
        product = triangle.view((from, from), (size, size)) * product;
        let largest = product.amax();
        if largest == 0.0 {
            return Some(vec![Multiplier { log_modulus: f64::NEG_INFINITY, angle: 0.0 }; size]);
        }
        product /= largest;
        log_scale += largest.ln();
    }
    let matrix = turn.view((from, from), (size, size)) * product;
    let values = Schur::try_new(matrix, f64::EPSILON, 10_000)?.complex_eigenvalues();
    let multiplier = |value: &Complex<f64>| Multiplier {
        log_modulus: value.norm().ln() + log_scale,
        angle: value.arg(),
    };
    Some(values.iter().map(multiplier).collect())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test panics to fail")]
mod tests {
    use super::multipliers;
    use nalgebra::{Matrix3, Rotation3, Vector3};

    #[test]
    fn multipliers_six_hundred_decades_apart_keep_their_digits() {
        // Φ = P D P⁻¹ in 300 equal factors, seen from axes that turn: the multipliers are dᵢ³⁰⁰.
        let d: Vector3<f64> = Vector3::new(0.998, -0.1, 1e-2);
        let p = Matrix3::new(1.0, 0.5, 0.2, -0.3, 1.0, 0.4, 0.1, -0.6, 1.0);
        let factor = p * Matrix3::from_diagonal(&d) * p.try_inverse().unwrap();
        let turned = |angle: f64| Rotation3::from_euler_angles(angle, 0.3 * angle, 0.0);
        let tau = std::f64::consts::TAU;
        let factors: Vec<_> = (0..300)
            .map(|k| {
                // Both angles come back: 3.0 turns of the first, 0.9 would not, so close by hand.
                let at = |k: i32| if k == 300 { 0.0 } else { tau * f64::from(k) / 100.0 };
                turned(at(k + 1)).matrix() * factor * turned(at(k)).matrix().transpose()
            })
            .collect();
        let found = multipliers(&factors).unwrap();
        for (multiplier, wanted) in found.iter().zip(d.iter()) {
            let want = 300.0 * wanted.abs().ln();
            // 300 roundings of factors whose condition is 10².
            assert!((multiplier.log_modulus - want).abs() < 1e-10, "{multiplier:?} {want}");
            assert!(multiplier.angle.sin().abs() < 1e-9 && multiplier.angle.cos() > 0.0);
        }
        assert!(multipliers(&[Matrix3::repeat(f64::NAN)]).is_none());
    }
}
