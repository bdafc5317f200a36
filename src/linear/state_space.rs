//! A linear system with one input and one output.
//!
//! ẋ = A x + B u,  y = C x + D u,  G(s) = C (sI − A)⁻¹ B + D
//!
//! Poles are the eigenvalues of A. Zeros are the eigenvalues of the system whose input keeps y = 0.
//! With D ≠ 0 that input is u = −C x/D, and the zeros are the eigenvalues of A − B C/D. With D = 0
//! the equation C x = 0 expresses one state by the others, and its derivative C A x + C B u = 0 is
//! the output of a system with one state less.
//!
//! Source: T. Kailath, "Linear Systems" (Prentice-Hall, 1980), section 2.5, for zeros by inversion.

use core::fmt;

use nalgebra::{Complex, ComplexField, RowSVector, SMatrix, SVector};

use super::LinearisationError;
use crate::Scalar;
use crate::bounds::larger;
use crate::eigenvalues::eigenvalues;
use crate::number::Number;
use crate::parameter;
use crate::scalar::{lit, to_f64};

/// A linear system with N states, one input u and one output y: ẋ = A x + B u, y = C x + D u.
///
/// ```
/// use bristle::linear::StateSpace;
/// use bristle::nalgebra::{Complex, Matrix1};
///
/// // y = (2 + s)/(1 + s) u
/// let lead = StateSpace {
///     dynamics: Matrix1::new(-1.0),
///     input: Matrix1::new(1.0),
///     output: Matrix1::new(1.0),
///     feedthrough: 1.0,
/// };
/// assert_eq!(lead.static_gain()?, 2.0);
/// assert_eq!(lead.frequency_response(1.0)?, Complex::new(1.5, -0.5));
/// assert_eq!(lead.zeros()?.as_slice(), [Complex::new(-2.0, 0.0)]);
/// # Ok::<(), bristle::linear::LinearisationError>(())
/// ```
///
/// The small motions of a whole mechanism have its Jacobian as A:
///
/// ```
/// use bristle::linear::StateSpace;
/// use bristle::ode::System;
/// use bristle::scene::MassSpringDamper;
/// use bristle::{Branch, Bristle, FrBd, paper};
/// use bristle::curve::Stribeck;
/// use bristle::rheology::KelvinVoigt;
/// use bristle::nalgebra::{RowVector3, Vector3};
///
/// let friction = FrBd::new(
///     Stribeck::new(paper::STICK_SLIP_CURVE)?,
///     KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?,
/// );
/// let rig = MassSpringDamper::new(paper::stick_slip_rig(friction.under_load(1.0)?))?;
/// let derivatives = rig.linearised(0.0, &rig.at_rest(), [Branch::Forward]).unwrap();
/// let stuck = StateSpace {
///     dynamics: derivatives.by_state,
///     input: Vector3::new(0.0, 1.0, 0.0),     // force on the mass of 1 kg
///     output: RowVector3::new(0.0, 1.0, 0.0), // its velocity
///     feedthrough: 0.0,
/// };
/// // The stuck mass swings on its bristles and its spring: ω² = (σ0 p + k)/m.
/// let poles = stuck.poles()?;
/// let moduli = poles.as_slice().iter().map(|pole| pole.norm_sqr().sqrt());
/// assert!((moduli.fold(0.0, f64::max) - 10002f64.sqrt()).abs() < 1e-9);
/// # Ok::<(), bristle::linear::LinearisationError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StateSpace<T: Scalar, const N: usize> {
    /// A: rates of the states by the states.
    #[doc(alias = "A")]
    pub dynamics: SMatrix<T, N, N>,
    /// B: rates of the states by the input.
    #[doc(alias = "B")]
    pub input: SVector<T, N>,
    /// C: output by the states.
    #[doc(alias = "C")]
    pub output: RowSVector<T, N>,
    /// D: output by the input.
    #[doc(alias = "D")]
    pub feedthrough: T,
}

/// A list of at most N roots, real or complex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Roots<T, const N: usize> {
    values: [Complex<T>; N],
    count: usize,
}

impl<T: Scalar, const N: usize> Roots<T, N> {
    /// The eigenvalues of the leading block of a matrix.
    fn of(matrix: &SMatrix<T, N, N>, count: usize) -> Result<Self, LinearisationError> {
        let values = eigenvalues(&matrix.map(to_f64), count);
        let values = values.ok_or(LinearisationError::NotFinite)?;
        Ok(Self { values: values.map(|root| Complex::new(lit(root.re), lit(root.im))), count })
    }

    /// The roots, in no order. Real ones have an imaginary part of exactly zero, the others come in
    /// exact conjugates.
    pub fn as_slice(&self) -> &[Complex<T>] {
        self.values.get(..self.count).unwrap_or(&self.values)
    }

    /// The largest real part; `None` for an empty list.
    pub fn abscissa(&self) -> Option<T> {
        self.as_slice().iter().map(|root| root.re).reduce(|a, b| if b > a { b } else { a })
    }
}

/// A line for each real root, and one for each pair with its undamped frequency and damping ratio.
///
/// ```
/// use bristle::linear::StateSpace;
/// use bristle::nalgebra::{Matrix2, RowVector2, Vector2};
///
/// // s² + 2 s + 25 = 0
/// let swing = StateSpace {
///     dynamics: Matrix2::new(0.0, 1.0, -25.0, -2.0),
///     input: Vector2::new(0.0, 1.0),
///     output: RowVector2::new(1.0, 0.0),
///     feedthrough: 0.0,
/// };
/// assert_eq!(swing.poles()?.to_string(), "-1 ± 4.899i 1/s (ω = 5 rad/s, ζ = 0.2)");
/// # Ok::<(), bristle::linear::LinearisationError>(())
/// ```
impl<T: Scalar, const N: usize> fmt::Display for Roots<T, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // One line for a pair, by its upper root.
        let upper = self.as_slice().iter().filter(|root| !(root.im < T::zero()));
        for (i, root) in upper.enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            let (re, im) = (to_f64(root.re), to_f64(root.im));
            let real = Number(re);
            if im > 0.0 {
                let frequency = ComplexField::hypot(re, im);
                let (ratio, omega, im) = (Number(-re / frequency), Number(frequency), Number(im));
                write!(f, "{real:.5} ± {im:.5}i 1/s (ω = {omega:.5} rad/s, ζ = {ratio:.5})")?;
            } else {
                write!(f, "{real:.5} 1/s")?;
            }
        }
        Ok(())
    }
}

impl<T: Scalar, const N: usize> StateSpace<T, N> {
    /// The system, if every entry is finite.
    pub(super) fn finite(self) -> Result<Self, LinearisationError> {
        let mut entries = self.dynamics.iter().chain(&self.input).chain(&self.output);
        if entries.all(|entry| entry.is_finite()) && self.feedthrough.is_finite() {
            Ok(self)
        } else {
            Err(LinearisationError::NotFinite)
        }
    }

    /// The transfer function G(s) = C (sI − A)⁻¹ B + D; not finite at a pole, D at infinity.
    pub fn transfer(&self, s: Complex<T>) -> Complex<T> {
        let infinite = |x: T| x.abs() >= T::one() / T::zero();
        if infinite(s.re) || infinite(s.im) {
            return Complex::new(self.feedthrough, T::zero());
        }
        let shifted = SMatrix::<Complex<T>, N, N>::from_fn(|i, j| {
            let entry = Complex::new(-self.dynamics[(i, j)], T::zero());
            if i == j { entry + s } else { entry }
        });
        let states = solve(shifted, self.input.map(|entry| Complex::new(entry, T::zero())));
        let direct = Complex::new(self.feedthrough, T::zero());
        let Some(states) = states else {
            let pole = T::one() / T::zero();
            return Complex::new(pole, pole);
        };
        self.output.iter().zip(&states).fold(direct, |sum, (&c, &x)| sum + x * c)
    }

    /// The frequency response G(iω) at an angular frequency ω [rad/s]: gain and phase of the output
    /// of a sinusoidal input once all transients have died out. At infinity it is D.
    ///
    /// # Errors
    ///
    /// Refuses a system whose transients do not die out, one that is not finite, and a frequency
    /// that is NaN.
    pub fn frequency_response(
        &self,
        angular_frequency: T,
    ) -> Result<Complex<T>, LinearisationError> {
        parameter::number("angular_frequency", angular_frequency)?;
        self.finite()?.stable()?;
        Ok(self.transfer(Complex::new(T::zero(), angular_frequency)))
    }

    /// The static gain G(0): output per constant input. For a contact in steady sliding it is the
    /// slope of its steady friction, p (μ sgn_ε)' [N s/m].
    ///
    /// # Errors
    ///
    /// Refuses a system with a pole at zero, one whose transients do not die out, and one that is
    /// not finite.
    pub fn static_gain(&self) -> Result<T, LinearisationError> {
        self.finite()?;
        let gain = self.transfer(Complex::new(T::zero(), T::zero())).re;
        if !gain.is_finite() {
            return Err(LinearisationError::Singular);
        }
        self.stable()?;
        Ok(gain)
    }

    /// The poles, eigenvalues of A [1/s].
    ///
    /// # Errors
    ///
    /// Refuses a matrix that is not finite.
    pub fn poles(&self) -> Result<Roots<T, N>, LinearisationError> {
        Roots::of(&self.dynamics, N)
    }

    /// The zeros [1/s]: fewer than poles if D = 0, none for a system whose input does not reach its
    /// output.
    ///
    /// A small D adds a zero far out, near −C B/D. The others are then those of the system without
    /// D, and the far one is left out where it exceeds the range of the scalar type.
    ///
    /// # Errors
    ///
    /// Refuses a system that is not finite.
    pub fn zeros(&self) -> Result<Roots<T, N>, LinearisationError> {
        self.finite()?;
        if self.feedthrough == T::zero() {
            return self.zeros_with(T::zero());
        }
        let near = self.zeros_with(T::zero())?;
        let Ok(all) = self.zeros_with(self.feedthrough) else { return Ok(near) };
        let length = |root: &Complex<T>| ComplexField::hypot(root.re, root.im);
        let far = all.as_slice().iter().reduce(|a, b| if length(b) > length(a) { b } else { a });
        let Some(far) = far.filter(|_| near.count + 1 == N) else { return Ok(all) };
        // With half the digits either way where the two meet.
        let limit = length(far) * T::default_epsilon().sqrt();
        let poles = self.poles()?;
        let small = |roots: &Roots<T, N>| roots.as_slice().iter().all(|root| length(root) < limit);
        if !(small(&near) && small(&poles)) {
            return Ok(all);
        }
        let mut values = near.values;
        match values.get_mut(near.count) {
            Some(last) if far.re.is_finite() => *last = Complex::new(far.re, T::zero()),
            _ => return Ok(near),
        }
        Ok(Roots { values, count: N })
    }

    /// The zeros with another D.
    fn zeros_with(&self, feedthrough: T) -> Result<Roots<T, N>, LinearisationError> {
        let (mut a, mut b, mut c, mut d, mut order) =
            (self.dynamics, self.input, self.output, feedthrough, N);
        while d == T::zero() {
            // By the state that weighs most in the output.
            let weights = (0..order).map(|i| (i, c[i].abs()));
            let heaviest = weights.reduce(|a, b| if b.1 > a.1 { b } else { a });
            let Some((k, weight)) = heaviest else { break };
            if !(weight > T::zero()) {
                break;
            }
            let (next, terms) = (0..order).fold((T::zero(), T::zero()), |(sum, size), i| {
                (sum + c[i] * b[i], size + (c[i] * b[i]).abs())
            });
            // A difference of rounding size is none.
            let rounding = lit::<T>(8.0) * T::default_epsilon() * terms;
            let next = if next.abs() > rounding { next } else { T::zero() };
            // The derivative of the output, with the state taken out.
            let rate = SVector::<T, N>::from_fn(|j, _| {
                (0..order).fold(T::zero(), |sum, i| sum + c[i] * a[(i, j)])
            });
            let share = SVector::<T, N>::from_fn(|j, _| c[j] / c[k]);
            let kept = |i: usize| if i < k { i } else { i + 1 };
            order -= 1;
            let (old_a, old_b) = (a, b);
            a = SMatrix::zeros();
            b = SVector::zeros();
            c = RowSVector::zeros();
            for i in 0..order {
                for j in 0..order {
                    a[(i, j)] = old_a[(kept(i), kept(j))] - old_a[(kept(i), k)] * share[kept(j)];
                }
                b[i] = old_b[kept(i)];
                c[i] = rate[kept(i)] - rate[k] * share[kept(i)];
            }
            d = next;
        }
        if d == T::zero() {
            order = 0;
        }
        Roots::of(&(a - b * c * (T::one() / d)), order)
    }

    /// The largest real part of the poles [1/s]: small motions grow if it is positive.
    ///
    /// # Errors
    ///
    /// Refuses a matrix that is not finite.
    pub fn abscissa(&self) -> Result<T, LinearisationError> {
        Ok(self.poles()?.abscissa().unwrap_or_else(T::zero))
    }

    /// The corner frequency [rad/s]: the modulus of the slowest pole. Below it the output follows
    /// the input quasi-statically. For a contact with one deflection it is the relaxation rate λ.
    ///
    /// # Errors
    ///
    /// Refuses a matrix that is not finite.
    pub fn corner_frequency(&self) -> Result<T, LinearisationError> {
        let poles = self.poles()?;
        let sizes = poles.as_slice().iter().map(|pole| ComplexField::hypot(pole.re, pole.im));
        Ok(sizes.reduce(|a, b| if b < a { b } else { a }).unwrap_or_else(T::zero))
    }

    /// Accepts a system whose transients die out.
    ///
    /// # Errors
    ///
    /// Names the largest growth rate otherwise.
    pub fn stable(&self) -> Result<(), LinearisationError> {
        let abscissa = self.abscissa()?;
        if abscissa < T::zero() {
            Ok(())
        } else {
            Err(LinearisationError::Unstable { abscissa: to_f64(abscissa) })
        }
    }
}

/// a/b, with b scaled to one so that its square neither overflows nor vanishes.
fn quotient<T: Scalar>(a: Complex<T>, b: Complex<T>) -> Complex<T> {
    let (re, im) = (b.re.abs(), b.im.abs());
    let scale = if im > re { im } else { re };
    let b = Complex::new(b.re / scale, b.im / scale);
    let square = b.re * b.re + b.im * b.im;
    let a = Complex::new(a.re / scale, a.im / scale);
    Complex::new((a.re * b.re + a.im * b.im) / square, (a.im * b.re - a.re * b.im) / square)
}

/// The solution of M x = b by elimination; `None` if M is singular to rounding.
///
/// Pivots are scaled by their rows, so that units do not matter. A pivot of the size of its own
/// rounding counts as zero.
fn solve<T: Scalar, const N: usize>(
    mut matrix: SMatrix<Complex<T>, N, N>,
    mut right: SVector<Complex<T>, N>,
) -> Option<SVector<Complex<T>, N>> {
    // Sum of the moduli of the terms in each entry.
    let mut terms = matrix.map(ComplexField::norm1);
    let mut scales = SVector::<T, N>::from_fn(|i, _| {
        terms.row(i).iter().fold(T::zero(), |most, &term| larger(most, term))
    });
    for k in 0..N {
        let weigh = |i: usize| (i, matrix[(i, k)].norm1() / scales[i]);
        let (best, _) = (k..N).map(weigh).reduce(|a, b| if b.1 > a.1 { b } else { a })?;
        matrix.swap_rows(k, best);
        terms.swap_rows(k, best);
        right.swap_rows(k, best);
        scales.swap_rows(k, best);
        let pivot = matrix[(k, k)];
        if !(pivot.norm1() > lit::<T>(8.0) * T::default_epsilon() * terms[(k, k)]) {
            return None;
        }
        for i in k + 1..N {
            let factor = quotient(matrix[(i, k)], pivot);
            for j in k..N {
                let row = matrix[(k, j)];
                matrix[(i, j)] -= factor * row;
                let part = factor.norm1() * terms[(k, j)];
                terms[(i, j)] += part;
            }
            let above = right[k];
            right[i] -= factor * above;
        }
    }
    for i in (0..N).rev() {
        for j in i + 1..N {
            let later = right[j];
            right[i] -= matrix[(i, j)] * later;
        }
        right[i] = quotient(right[i], matrix[(i, i)]);
    }
    Some(right)
}
