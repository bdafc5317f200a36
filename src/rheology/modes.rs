//! The exact step of a bristle of several springs under a held drive, by its modes.
//!
//! ẋ = −Λx + u,  Λ = diag(a) + 1·wᵀ
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x | stretches of the springs | m |
//! | aᵢ ≥ 0 | decay rate of each spring's own stretch | 1/s |
//! | wᵢ ≥ 0 | how each stretch slows the common rate: (\|v\|_ε/g) Kᵢ | 1/s |
//! | uᵢ | drive of each spring, rᵢ v | m/s |
//!
//! Scaled by the roots of the stiffnesses Λ is symmetric: diagonal plus rank one. Its eigenvalues
//! λⱼ are real, at least zero, and lie between the aᵢ, one in each gap and one above them all, not
//! more than Σw above. They are the roots of the *secular equation*
//!
//! 1 = Σ wᵢ/(λ − aᵢ),
//!
//! with eigenvectors Vᵢⱼ = 1/(λⱼ − aᵢ). In each mode the bristle is a scalar that relaxes with λⱼ,
//! and its step is that of [`Weights`]; nothing is inverted, so that Λ may be singular, as it is at
//! rest if there is a spring without a dashpot.
//!
//! To keep all digits, however far apart the rates, each root is found as its distance from the
//! nearer of the two aᵢ around it. The wᵢ are then replaced by those for which the computed roots
//! are exact (Löwner's formula); they differ by roundings, and the modes are orthogonal to
//! rounding. Coinciding decay rates are separated by a few roundings.
//!
//! Sources: J. R. Bunch, C. P. Nielsen, D. C. Sorensen, "Rank-one modification of the symmetric
//! eigenproblem", Numerische Mathematik 31 (1978), 31–48; M. Gu, S. C. Eisenstat, "A stable and
//! efficient algorithm for the rank-one modification of the symmetric eigenproblem", SIAM Journal
//! on Matrix Analysis and Applications 15 (1994), 1266–1276.

use core::cmp::Ordering;

use nalgebra::{SMatrix, SVector};

use super::{DiagonalPlusRankOne, HeldWeights, Weights};
use crate::Scalar;
use crate::scalar::{is_zero, lit};

/// Iterations that a root may take. Three to eight are usual; a cut between two ends halves the
/// decades between them, so that this many cannot run out before the root is found.
const ITERATIONS: usize = 60;

/// The exact step of a bristle of several springs, ẋ = −Λx + u with the matrix
/// [`DiagonalPlusRankOne`] held: in each mode of Λ it is a scalar that relaxes, and steps by
/// [`Weights`].
///
/// Made by [`Affine::weights`](crate::Affine::weights); used through [`HeldWeights`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modes<T: Scalar, const N: usize> {
    /// Eigenvalues λⱼ [1/s].
    rates: SVector<T, N>,
    /// None if each spring is a mode of its own.
    coupled: Option<Coupled<T, N>>,
    steps: SVector<Weights<T>, N>,
    /// Whether every mode relaxes within the step.
    relaxed: bool,
}

/// Modes of several springs each.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Coupled<T: Scalar, const N: usize> {
    /// The modes, one a column: x = shapes ξ.
    shapes: SMatrix<T, N, N>,
    /// The coordinates ξ = coordinates x of a state.
    coordinates: SMatrix<T, N, N>,
    /// Those of the vector 1, with more digits: a drive that all springs have in common acts on it.
    common: SVector<T, N>,
}

impl<T: Scalar, const N: usize> Coupled<T, N> {
    /// The coordinates of a state and of a drive.
    fn coordinates(
        &self,
        state: SVector<T, N>,
        drive: SVector<T, N>,
    ) -> (SVector<T, N>, SVector<T, N>) {
        let first = drive.iter().next().map_or(T::zero(), |&first| first);
        let (state, common) = (self.coordinates * state, self.common * first);
        if drive.iter().all(|&drive| drive == first) {
            return (state, common);
        }
        (state, common + self.coordinates * drive.map(|drive| drive - first))
    }
}

impl<T: Scalar, const N: usize> Modes<T, N> {
    /// The step of length h ≥ 0 \[s\]. NaN for a matrix that is not one of a passive bristle.
    pub(crate) fn new(relaxation: DiagonalPlusRankOne<SVector<T, N>>, duration: T) -> Self {
        let total = relaxation.row.sum();
        let passive = |x: &T| *x >= T::zero() && x.is_finite();
        let admissible = relaxation.decay.iter().all(passive)
            && relaxation.row.iter().all(passive)
            && total.is_finite();
        let (rates, coupled) = if !admissible {
            (SVector::repeat(T::nan()), None)
        } else if is_zero(total) {
            // At rest, and side by side on one velocity.
            (relaxation.decay, None)
        } else {
            let (rates, coupled) = coupled(&relaxation, total);
            (rates, Some(coupled))
        };
        let relaxed = rates.iter().all(|&rate| rate * duration > T::one());
        Self { rates, coupled, steps: rates.map(|rate| Weights::new(rate, duration)), relaxed }
    }

    fn step(
        &self,
        state: SVector<T, N>,
        drive: SVector<T, N>,
        of_mode: impl Fn(&Weights<T>, T, T) -> T,
    ) -> SVector<T, N> {
        let Some(coupled) = &self.coupled else {
            return SVector::from_fn(|j, _| of_mode(&self.steps[j], state[j], drive[j]));
        };
        let (coordinates, drive) = coupled.coordinates(state, drive);
        if self.relaxed {
            // Nothing of the start is left to which a difference could be added.
            coupled.shapes
                * SVector::from_fn(|j, _| of_mode(&self.steps[j], coordinates[j], drive[j]))
        } else {
            // The state and what is new, so that a short step makes a small change with all digits.
            state
                + coupled.shapes
                    * SVector::from_fn(|j, _| {
                        let rate = drive[j] - self.rates[j] * coordinates[j];
                        of_mode(&self.steps[j], T::zero(), rate)
                    })
        }
    }
}

impl<T: Scalar, const N: usize> HeldWeights<T, SVector<T, N>> for Modes<T, N> {
    #[inline]
    fn end(&self, state: SVector<T, N>, drive: SVector<T, N>) -> SVector<T, N> {
        self.step(state, drive, Weights::end)
    }

    #[inline]
    fn mean(&self, state: SVector<T, N>, drive: SVector<T, N>) -> SVector<T, N> {
        self.step(state, drive, Weights::mean)
    }

    // As a sum over the modes, which are orthogonal in ΣKᵢxᵢ².
    fn relaxed_energy(
        &self,
        stiffness: SVector<T, N>,
        state: SVector<T, N>,
        drive: SVector<T, N>,
    ) -> T {
        let (state, drive, stiffness) = match &self.coupled {
            None => (state, drive, stiffness),
            Some(coupled) => {
                let (coordinates, drive) = coupled.coordinates(state, drive);
                let squares = coupled.shapes.component_mul(&coupled.shapes);
                (coordinates, drive, squares.tr_mul(&stiffness))
            }
        };
        (0..N).fold(T::zero(), |sum, j| {
            let step = &self.steps[j];
            let change = step.end(state[j], drive[j]) - state[j];
            sum + stiffness[j] * step.relaxed_square(step.mean(state[j], drive[j]), change)
        })
    }
}

/// Eigenvalues and modes, for Σw > 0.
fn coupled<T: Scalar, const N: usize>(
    relaxation: &DiagonalPlusRankOne<SVector<T, N>>,
    total: T,
) -> (SVector<T, N>, Coupled<T, N>) {
    let (one, zero) = (T::one(), T::zero());
    let DiagonalPlusRankOne { decay, row } = relaxation;
    // In units of the fastest rate no square or reciprocal leaves the range of the scalar type.
    let unit = decay.iter().fold(total, |most, &a| most.larger(a));
    // Negligible beside that unit over any step, and with a square that has a reciprocal.
    let single = T::default_epsilon() > lit(1e-10);
    let tiny: T = if single { lit(1e-17) } else { lit(1e-60) };
    let rounding = T::default_epsilon() * lit(4.0);

    let mut springs: [Spring<T>; N] = core::array::from_fn(|index| {
        let pole = Pole { rate: decay[index] / unit, weight: (row[index] / unit).larger(tiny) };
        Spring { pole, index, root: Root::nowhere() }
    });
    let by_rate = |a: &Spring<T>, b: &Spring<T>| a.pole.rate.partial_cmp(&b.pole.rate);
    springs.sort_unstable_by(|a, b| by_rate(a, b).unwrap_or(Ordering::Equal));
    let mut least = zero;
    for Spring { pole, .. } in &mut springs {
        pole.rate = pole.rate.larger(least);
        least = pole.rate + (rounding * pole.rate).larger(tiny);
    }
    let poles = springs.map(|spring| spring.pole);
    for (j, spring) in springs.iter_mut().enumerate() {
        spring.root = root(&poles, j);
    }
    // Each spring with the root above it, back where it came from.
    springs.sort_unstable_by_key(|spring| spring.index);

    let rates = SVector::from_fn(|j, _| springs[j].root.value() * unit);
    let driven = |j: usize| springs[j].root.distance;
    // λⱼ − aᵢ in row i, column j.
    let gaps = SMatrix::<T, N, N>::from_fn(|i, j| springs[j].root.above(springs[i].pole.rate));
    // Löwner's formula: the row of which these are the exact roots.
    let w = SVector::<T, N>::from_fn(|i, _| {
        (0..N).filter(|&l| l != i).fold(gaps[(i, i)], |product, l| {
            product * (gaps[(i, l)] / (springs[l].pole.rate - springs[i].pole.rate))
        })
    });

    // Each mode is scaled to one where its root lies.
    let shapes = SMatrix::<T, N, N>::from_fn(|i, j| driven(j) / gaps[(i, j)]);
    let inverse = SVector::<T, N>::from_fn(|j, _| {
        let norm = (0..N).fold(zero, |sum, i| sum + w[i] * (shapes[(i, j)] * shapes[(i, j)]));
        one / norm
    });
    let coordinates = SMatrix::from_fn(|j, i| w[i] * shapes[(i, j)] * inverse[j]);
    // Σ wᵢ/(λⱼ − aᵢ) = 1.
    let common = SVector::from_fn(|j, _| driven(j) * inverse[j]);
    (rates, Coupled { shapes, coordinates, common })
}

/// A term of the secular equation.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Pole<T> {
    /// aᵢ
    rate: T,
    /// wᵢ
    weight: T,
}

/// A root of the secular equation, as a distance from the nearer of the two aᵢ around it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Root<T> {
    nearest: T,
    /// ±1
    side: T,
    distance: T,
}

impl<T: Scalar> Root<T> {
    fn nowhere() -> Self {
        Self { nearest: T::nan(), side: T::nan(), distance: T::nan() }
    }

    /// λ
    fn value(&self) -> T {
        self.nearest + self.side * self.distance
    }

    /// λ − a
    fn above(&self, rate: T) -> T {
        (self.nearest - rate) + self.side * self.distance
    }
}

/// A spring, its place among the others and the root above its pole.
#[derive(Debug, Clone, Copy)]
struct Spring<T> {
    pole: Pole<T>,
    index: usize,
    root: Root<T>,
}

/// The j-th root of 1 = Σ wᵢ/(λ − aᵢ) for increasing aᵢ and positive wᵢ.
fn root<T: Scalar>(poles: &[Pole<T>], j: usize) -> Root<T> {
    let (zero, one, half) = (T::zero(), T::one(), lit::<T>(0.5));
    let Some(&Pole { rate: before, .. }) = poles.get(j) else { return Root::nowhere() };
    let next = poles.get(j + 1).map(|pole| pole.rate);
    let (last, after) = (next.is_none(), next.unwrap_or(before));
    let width = after - before;
    let reach =
        if last { poles.iter().fold(zero, |sum, pole| sum + pole.weight) } else { width * half };
    let at_middle =
        || poles.iter().fold(one, |sum, pole| sum - pole.weight / (before - pole.rate + reach));
    let (nearest, side) =
        if last || at_middle() >= zero { (before, T::one()) } else { (after, -T::one()) };
    let (mut low, mut high, mut distance) = (zero, reach, reach);
    for _ in 0..ITERATIONS {
        // The distances from aⱼ and to aⱼ₊₁.
        let (from, to) =
            if side > zero { (distance, width - distance) } else { (width - distance, distance) };
        // The terms with poles at and below aⱼ are like l₀ + l₁/(λ − aⱼ), those above like
        // r₀ + r₁/(aⱼ₊₁ − λ), in value and slope. All sums are of positive numbers.
        let (mut below, mut above, mut l1, mut r1, mut rest) = (zero, zero, zero, zero, one);
        for (i, pole) in poles.iter().enumerate() {
            let inverse = T::one() / Root { nearest, side, distance }.above(pole.rate);
            let term = pole.weight * inverse;
            if i <= j {
                below += term;
                let near = from * inverse;
                l1 += pole.weight * near * near;
                rest -= term * inverse * (before - pole.rate);
            } else {
                above -= term;
                let near = to * inverse;
                r1 += pole.weight * near * near;
                rest += term * inverse * (pole.rate - after);
            }
        }
        let excess = (one - below) + above;
        if (excess > zero) == (side > zero) {
            high = distance;
        } else {
            low = distance;
        }
        let next = if last {
            l1 / rest
        } else if side > zero {
            rational_root([l1, r1, rest], width)
        } else {
            rational_root([r1, l1, -rest], width)
        };
        let next = if next > low && next < high { next } else { between(low, high) };
        let change = (next - distance).abs();
        distance = next;
        if !(change > T::default_epsilon() * lit(2.0) * distance) {
            break;
        }
    }
    Root { nearest, side, distance }
}

/// The distance x from the nearer of two poles at which curvature − near/x + far/(width − x) = 0.
fn rational_root<T: Scalar>([near, far, curvature]: [T; 3], width: T) -> T {
    let scaled = curvature * width;
    let difference = scaled + far - near;
    let radical = (difference * difference + lit::<T>(4.0) * near * far).sqrt();
    let sum = scaled + near + far;
    if sum > T::zero() {
        (near + near) * width / (sum + radical)
    } else {
        (sum - radical) * lit(0.5) / curvature
    }
}

/// Where to go on if an iterate is within rounding of an end, or nowhere.
fn between<T: Scalar>(low: T, high: T) -> T {
    if low > T::zero() { (low * high).sqrt() } else { high * lit(0.5) }
}
