//! The exact step of a bristle of several springs under a held drive, by its modes.
//!
//! ẋ = −Λx + u·1,  Λ = diag(a) + 1·wᵀ
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x | stretches of the springs | m |
//! | aᵢ ≥ 0 | decay rate of each spring's own stretch | 1/s |
//! | wᵢ ≥ 0 | how each stretch slows the common rate: (\|v\|_ε/g) Kᵢ | 1/s |
//! | u | drive, r v | m/s |
//!
//! Scaled by the roots of the stiffnesses Λ is symmetric: diagonal plus rank one. Its eigenvalues λⱼ
//! are real, at least zero, and lie between the aᵢ, one in each gap and one above them all, not more
//! than Σw above. They are the roots of the *secular equation*
//!
//! 1 = Σ wᵢ/(λ − aᵢ),
//!
//! with eigenvectors Vᵢⱼ = 1/(λⱼ − aᵢ). In each mode the bristle is a scalar that relaxes with λⱼ, and
//! its step is that of [`Weights`]; nothing is inverted, so that Λ may be singular, as it is at rest if
//! there is a spring without a dashpot.
//!
//! To keep all digits, however far apart the rates, each root is found as its distance from the nearer
//! of the two aᵢ around it, and the wᵢ are then replaced by those for which the computed roots are exact
//! (Löwner's formula); they differ by roundings, and the modes are orthogonal to rounding. Decay rates
//! that coincide are parted by a few roundings.
//!
//! Sources: J. R. Bunch, C. P. Nielsen, D. C. Sorensen, "Rank-one modification of the symmetric
//! eigenproblem", Numerische Mathematik 31 (1978), 31–48; M. Gu, S. C. Eisenstat, "A stable and
//! efficient algorithm for the rank-one modification of the symmetric eigenproblem", SIAM Journal on
//! Matrix Analysis and Applications 15 (1994), 1266–1276.

use nalgebra::{SMatrix, SVector};

use super::{Decaying, Weights};
use crate::Scalar;
use crate::bounds::larger;
use crate::scalar::{is_zero, lit, nan};

/// Iterations that a root may take. Three to eight are usual; a cut between two ends halves the
/// decades between them, so that this many cannot run out before the root is found.
const ITERATIONS: usize = 60;

/// The exact step of a bristle of several springs: its modes, and the step of each.
///
/// Made by [`Deflection::weights`](super::Deflection::weights).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modes<T: Scalar, const N: usize> {
    /// Eigenvalues λⱼ [1/s].
    rates: SVector<T, N>,
    /// The modes, one a column: x = shapes ξ.
    shapes: SMatrix<T, N, N>,
    /// The coordinates ξ = coordinates x of a state.
    coordinates: SMatrix<T, N, N>,
    /// Those of the vector 1, on which the drive acts.
    driven: SVector<T, N>,
    steps: SVector<Weights<T>, N>,
    /// Whether every mode relaxes within the step.
    relaxed: bool,
}

impl<T: Scalar, const N: usize> Modes<T, N> {
    /// The step of length h ≥ 0 \[s\]. NaN for a matrix that is not one of a passive bristle.
    pub(crate) fn new(relaxation: Decaying<SVector<T, N>>, duration: T) -> Self {
        let total = relaxation.row.sum();
        let passive = |x: &T| *x >= T::zero() && x.is_finite();
        let admissible = relaxation.decay.iter().all(passive)
            && relaxation.row.iter().all(passive)
            && total.is_finite();
        let (rates, shapes, coordinates, driven) = if !admissible {
            let nan = SVector::repeat(nan());
            (nan, SMatrix::repeat(crate::scalar::nan()), SMatrix::identity(), nan)
        } else if is_zero(total) {
            // At rest every spring is for itself.
            let identity = SMatrix::identity();
            (relaxation.decay, identity, identity, SVector::repeat(T::one()))
        } else {
            coupled(&relaxation, total)
        };
        let relaxed = rates.iter().all(|&rate| rate * duration > T::one());
        Self {
            rates,
            shapes,
            coordinates,
            driven,
            steps: rates.map(|rate| Weights::new(rate, duration)),
            relaxed,
        }
    }

    /// The state at the end of the step, under a drive u [m/s].
    #[inline]
    pub(crate) fn end(&self, state: SVector<T, N>, drive: T) -> SVector<T, N> {
        self.step(state, drive, Weights::end)
    }

    /// The state averaged over the step, under a drive u [m/s].
    #[inline]
    pub(crate) fn mean(&self, state: SVector<T, N>, drive: T) -> SVector<T, N> {
        self.step(state, drive, Weights::mean)
    }

    /// ∫ Σ Kᵢ xᵢ (Λx)ᵢ dt over the step, of every mode for itself, for they are orthogonal in ΣKᵢxᵢ².
    pub(crate) fn relaxed_energy(
        &self,
        stiffness: SVector<T, N>,
        state: SVector<T, N>,
        drive: T,
    ) -> T {
        let coordinates = self.coordinates * state;
        (0..N).fold(T::zero(), |sum, j| {
            let shape = self.shapes.column(j);
            let stiffness = stiffness.dot(&shape.component_mul(&shape));
            let (start, drive) = (coordinates[j], self.driven[j] * drive);
            let step = &self.steps[j];
            let change = step.end(start, drive) - start;
            sum + stiffness * step.relaxed_square(step.mean(start, drive), change)
        })
    }

    fn step(
        &self,
        state: SVector<T, N>,
        drive: T,
        of_mode: impl Fn(&Weights<T>, T, T) -> T,
    ) -> SVector<T, N> {
        let coordinates = self.coordinates * state;
        if self.relaxed {
            // Nothing of the start is left to which a difference could be added.
            self.shapes
                * SVector::from_fn(|j, _| {
                    of_mode(&self.steps[j], coordinates[j], self.driven[j] * drive)
                })
        } else {
            // The state and what is new, so that a short step makes a small change with all digits.
            state
                + self.shapes
                    * SVector::from_fn(|j, _| {
                        let rate = self.driven[j] * drive - self.rates[j] * coordinates[j];
                        of_mode(&self.steps[j], T::zero(), rate)
                    })
        }
    }
}

/// Eigenvalues, modes, coordinates, and the coordinates of 1, for Σw > 0.
fn coupled<T: Scalar, const N: usize>(
    relaxation: &Decaying<SVector<T, N>>,
    total: T,
) -> (SVector<T, N>, SMatrix<T, N, N>, SMatrix<T, N, N>, SVector<T, N>) {
    let (one, zero) = (T::one(), T::zero());
    let Decaying { decay, row } = relaxation;
    // In units of the fastest rate no square or reciprocal leaves the range of the scalar type.
    let unit = decay.iter().fold(total, |most, &a| larger(most, a));
    // What is negligible beside that unit over any step, and has a square with a reciprocal.
    let single = T::default_epsilon() > lit(1e-10);
    let tiny: T = if single { lit(1e-17) } else { lit(1e-60) };
    let rounding = T::default_epsilon() * lit(4.0);

    let mut order: SVector<usize, N> = SVector::from_fn(|i, _| i);
    for i in 1..N {
        let mut k = i;
        while k > 0 && decay[order[k]] < decay[order[k - 1]] {
            order.swap_rows(k, k - 1);
            k -= 1;
        }
    }
    let mut a: SVector<T, N> = order.map(|i| decay[i] / unit);
    for i in 1..N {
        let least = a[i - 1] + larger(rounding * a[i - 1], tiny);
        a[i] = larger(a[i], least);
    }
    let w: SVector<T, N> = order.map(|i| larger(row[i] / unit, tiny));

    // λⱼ − aᵢ in row i, column j, and the distance of each root from the aᵢ next to it.
    let mut gaps = SMatrix::<T, N, N>::zeros();
    let mut distances = SVector::<T, N>::zeros();
    let mut rates = SVector::<T, N>::zeros();
    for j in 0..N {
        let (nearest, side, distance) = root(a.as_slice(), w.as_slice(), one, j);
        distances[j] = distance;
        rates[j] = (a[nearest] + side * distance) * unit;
        for i in 0..N {
            let offset = if i == nearest { zero } else { a[nearest] - a[i] };
            gaps[(i, j)] = offset + side * distance;
        }
    }
    // Löwner's formula: the row of which these are the exact roots.
    let w = SVector::<T, N>::from_fn(|i, _| {
        (0..N)
            .filter(|&l| l != i)
            .fold(gaps[(i, i)], |product, l| product * (gaps[(i, l)] / (a[l] - a[i])))
    });

    let (mut shapes, mut coordinates) = (SMatrix::zeros(), SMatrix::zeros());
    let mut driven = SVector::zeros();
    for j in 0..N {
        // Each mode is scaled to one where its root lies.
        let shape = SVector::<T, N>::from_fn(|i, _| distances[j] / gaps[(i, j)]);
        let norm = w.dot(&shape.component_mul(&shape));
        let inverse = one / norm;
        for i in 0..N {
            shapes[(order[i], j)] = shape[i];
            coordinates[(j, order[i])] = w[i] * shape[i] * inverse;
        }
        // Σ wᵢ/(λⱼ − aᵢ) = 1.
        driven[j] = distances[j] * inverse;
    }
    (rates, shapes, coordinates, driven)
}

/// The j-th root of c = Σ wᵢ/(λ − aᵢ) for increasing aᵢ, positive wᵢ, and c positive, or zero (then
/// there is none above all aᵢ): the index of the nearer of the two aᵢ around it, on which side of that
/// it lies, and how far from it.
pub(super) fn root<T: Scalar>(a: &[T], w: &[T], constant: T, j: usize) -> (usize, T, T) {
    let (zero, half) = (T::zero(), lit::<T>(0.5));
    let n = a.len();
    let last = j + 1 == n;
    let width = if last { zero } else { a[j + 1] - a[j] };
    let (nearest, side, reach) = if last {
        (j, T::one(), w.iter().fold(zero, |sum, &w| sum + w) / constant)
    } else {
        let reach = width * half;
        let at_middle = (0..n).fold(constant, |sum, i| sum - w[i] / (a[j] - a[i] + reach));
        if at_middle >= zero { (j, T::one(), reach) } else { (j + 1, -T::one(), reach) }
    };
    let (mut low, mut high, mut distance) = (zero, reach, reach);
    for _ in 0..ITERATIONS {
        // The distances from aⱼ and to aⱼ₊₁.
        let (from, to) =
            if side > zero { (distance, width - distance) } else { (width - distance, distance) };
        // The terms with poles at and below aⱼ are like l₀ + l₁/(λ − aⱼ), those above like
        // r₀ + r₁/(aⱼ₊₁ − λ), in value and slope. All sums are of positive numbers.
        let (mut below, mut above, mut l1, mut r1, mut rest) = (zero, zero, zero, zero, constant);
        for i in 0..n {
            let offset = if i == nearest { zero } else { a[nearest] - a[i] };
            let inverse = T::one() / (offset + side * distance);
            let term = w[i] * inverse;
            if i <= j {
                below += term;
                let near = from * inverse;
                l1 += w[i] * near * near;
                rest -= term * inverse * (a[j] - a[i]);
            } else {
                above -= term;
                let near = to * inverse;
                r1 += w[i] * near * near;
                rest += term * inverse * (a[i] - a[j + 1]);
            }
        }
        let excess = (constant - below) + above;
        if (excess > zero) == (side > zero) {
            high = distance;
        } else {
            low = distance;
        }
        // rest − l₁/(λ − aⱼ) + r₁/(aⱼ₊₁ − λ) = 0, for the distance from the nearer pole.
        let next = if last {
            l1 / rest
        } else {
            let (near, far, curvature) = if side > zero { (l1, r1, rest) } else { (r1, l1, -rest) };
            let scaled = curvature * width;
            let difference = scaled + far - near;
            let radical = (difference * difference + lit::<T>(4.0) * near * far).sqrt();
            let sum = scaled + near + far;
            if sum > zero {
                (near + near) * width / (sum + radical)
            } else {
                (sum - radical) * half / curvature
            }
        };
        let next = if next > low && next < high {
            next
        } else if low > zero {
            // Within rounding of an end, or nowhere.
            (low * high).sqrt()
        } else {
            high * half
        };
        let change = (next - distance).abs();
        distance = next;
        if !(change > T::default_epsilon() * lit(2.0) * distance) {
            break;
        }
    }
    (nearest, side, distance)
}
