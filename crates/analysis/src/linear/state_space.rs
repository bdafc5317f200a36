//! A linear system with one input and one output.
//!
//! ẋ = A x + B u,  y = C x + D u,  G(s) = C (sI − A)⁻¹ B + D
//!
//! Poles are the eigenvalues of A.
//!
//! Source: T. Kailath, "Linear Systems" (Prentice-Hall, 1980).

use bristle::Scalar;
use bristle::parameter::{Checked, Named, Rule};
use bristle::scalar::{lit, to_f64};
use nalgebra::{Complex, ComplexField, RowSVector, SMatrix, SVector};

use crate::eigenvalues::eigenvalues;

/// A linear system with N states, one input u and one output y: ẋ = A x + B u, y = C x + D u.
///
/// ```
/// use bristle::nalgebra::{Complex, Matrix1};
/// use bristle_analysis::linear::StateSpace;
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
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// The small motions of a whole mechanism have its Jacobian as A:
///
/// ```
/// use bristle::curve::Stribeck;
/// use bristle::nalgebra::{RowVector3, Vector3};
/// use bristle::ode::System;
/// use bristle::rheology::KelvinVoigt;
/// use bristle::scene::MassSpringDamper;
/// use bristle::{Branch, Bristle, FrBd, paper};
/// use bristle_analysis::linear::StateSpace;
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
/// let moduli = stuck.poles()?.map(|pole| pole.norm_sqr().sqrt());
/// assert!((moduli.into_iter().fold(0.0, f64::max) - 10002f64.sqrt()).abs() < 1e-9);
/// # Ok::<(), bristle::ParameterError>(())
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

impl<T: Scalar, const N: usize> StateSpace<T, N> {
    /// Every entry of the four, with the name of its matrix.
    pub(super) fn entries(&self) -> impl Iterator<Item = (&'static str, T)> {
        let dynamics = self.dynamics.iter().map(|&entry| ("dynamics", entry));
        let input = self.input.iter().map(|&entry| ("input", entry));
        let output = self.output.iter().map(|&entry| ("output", entry));
        dynamics.chain(input).chain(output).chain([("feedthrough", self.feedthrough)])
    }

    /// The system, if every entry is finite.
    pub(super) fn finite(self) -> Checked<Self> {
        for (name, entry) in self.entries() {
            Named(name, entry).check(entry.is_finite(), Rule::Finite)?;
        }
        Ok(self)
    }

    /// The transfer function G(s) = C (sI − A)⁻¹ B + D; not finite at a pole, D at infinity.
    pub fn transfer(&self, s: Complex<T>) -> Complex<T> {
        let direct = Complex::from(self.feedthrough);
        if s.re.abs() >= T::unlimited() || s.im.abs() >= T::unlimited() {
            return direct;
        }
        let shifted = SMatrix::<Complex<T>, N, N>::from_fn(|i, j| {
            let entry = Complex::from(-self.dynamics[(i, j)]);
            if i == j { entry + s } else { entry }
        });
        let Some(states) = solve(shifted, self.input.map(Complex::from)) else {
            return Complex::new(T::unlimited(), T::unlimited());
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
    pub fn frequency_response(&self, angular_frequency: T) -> Checked<Complex<T>> {
        Named("angular_frequency", angular_frequency).number()?;
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
    pub fn static_gain(&self) -> Checked<T> {
        self.finite()?;
        let gain = self.transfer(Complex::new(T::zero(), T::zero())).re;
        let rule = "be finite: there is a pole at zero";
        Named("static gain", gain).stated(gain.is_finite(), rule)?;
        self.stable()?;
        Ok(gain)
    }

    /// The poles, eigenvalues of A [1/s], in no order. Real ones have an imaginary part of exactly
    /// zero, the others come in exact conjugates.
    ///
    /// # Errors
    ///
    /// Refuses a matrix that is not finite.
    pub fn poles(&self) -> Checked<[Complex<T>; N]> {
        let rule = Rule::Stated("be finite, and its eigenvalues be found");
        let values = eigenvalues(&self.dynamics.map(to_f64));
        let values =
            values.ok_or_else(|| Named("sum of a matrix", self.dynamics.sum()).refused(rule))?;
        Ok(values.map(|root| Complex::new(lit(root.re), lit(root.im))))
    }

    /// The largest real part of the poles [1/s]: small motions grow if it is positive.
    ///
    /// # Errors
    ///
    /// Refuses a matrix that is not finite.
    pub fn abscissa(&self) -> Checked<T> {
        let parts = self.poles()?.into_iter().map(|pole| pole.re);
        Ok(parts.reduce(T::larger).unwrap_or_else(T::zero))
    }

    /// Accepts a system whose transients die out.
    ///
    /// # Errors
    ///
    /// Names the largest growth rate otherwise.
    pub fn stable(&self) -> Checked<()> {
        let abscissa = self.abscissa()?;
        let rule = "be negative: small motions must die out for a steady response";
        Named("largest real part of the poles", abscissa)
            .stated(abscissa < T::zero(), rule)
            .map(drop)
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
    let mut scales = SVector::<T, N>::from_fn(|i, _| terms.row(i).amax());
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
