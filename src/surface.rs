//! What a friction model meets at one instant: velocity, branch and friction scale.

use crate::curve::FrictionCurve;
use crate::regularisation::Regularisation;
use crate::rheology::{Elements, Rheology};
use crate::{Branch, Scalar, Sliding};

/// What a friction model meets at one instant: a sliding velocity v [m/s] under a friction scale
/// s = p/P \[–\].
///
/// **Where a method takes `impl Into<Surface<T>>`, pass the velocity:** a plain number, or a
/// [`Sliding`] on a locked branch. The scale is then one, and a [`Contact`](crate::Contact) puts in
/// that of its load. Build a surface only for a scale of your own ([`Surface::scaled`]): of a load
/// that you keep beside the contact, of wear or of temperature.
///
/// The scale multiplies the friction curve, μ → s μ, and leaves the stiffness as it was measured,
/// under the reference load P. A model of your own asks the surface for the values of its curve
/// ([`Surface::friction`], [`Surface::apply`]) and gets them scaled. Velocity, speed and direction
/// are given out as numbers, but not the [`Sliding`] that a curve takes: a model that hands its
/// surface to the curve, past the scale, does not compile (the second example). One that takes
/// [`Surface::velocity`] for that does, and loses scale and branch.
///
/// ```
/// use bristle::Surface;
/// use bristle::curve::{Coulomb, CoulombParameters};
///
/// let curve = CoulombParameters { dynamic_coefficient: 0.5, viscous_friction: 0.0 };
/// let curve = Coulomb::new(curve)?;
/// assert_eq!(Surface::from(0.1).friction(&curve), 0.5);
/// assert_eq!(Surface::scaled(0.1, 0.3).friction(&curve), 0.15);
/// # Ok::<(), bristle::ParameterError>(())
/// ```
///
/// ```compile_fail
/// # use bristle::{Surface, curve::{Coulomb, FrictionCurve}};
/// fn friction(surface: Surface<f64>, curve: &Coulomb<f64>) -> f64 {
///     curve.coefficient(surface)
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface<T> {
    sliding: Sliding<T>,
    scale: T,
}

impl<T: Scalar> Surface<T> {
    /// A sliding velocity under a friction scale s \[–\].
    #[inline(always)]
    pub fn scaled(sliding: impl Into<Sliding<T>>, scale: T) -> Self {
        Self { sliding: sliding.into(), scale }
    }

    /// The same velocity with s times the scale \[–\]: two causes that scale the friction multiply.
    #[inline(always)]
    pub fn rescaled(self, scale: T) -> Self {
        Self { scale: self.scale * scale, ..self }
    }

    /// Signed velocity v [m/s].
    #[inline(always)]
    pub fn velocity(&self) -> T {
        self.sliding.velocity()
    }

    /// Speed |v| [m/s]. On a branch that is locked to the other direction it is negative, so that a
    /// law continues smoothly beyond a reversal: take a power or a logarithm of its size. See
    /// [`Sliding::speed`].
    #[inline(always)]
    pub fn speed(&self) -> T {
        self.sliding.speed()
    }

    /// Direction d|v|/dv, which is sgn v but for locked branches: see [`Sliding::direction`].
    #[inline(always)]
    pub fn direction(&self) -> T {
        self.sliding.direction()
    }

    /// The friction scale s \[–\].
    #[inline(always)]
    pub fn scale(&self) -> T {
        self.scale
    }

    /// A friction coefficient \[–\], or its derivative, scaled by s, for one that comes from no
    /// [`FrictionCurve`]. At s = 1 it costs a comparison.
    #[inline(always)]
    pub fn apply(&self, coefficient: T) -> T {
        if self.scale == T::one() { coefficient } else { product(coefficient, self.scale) }
    }

    /// s μ(v) \[–\]: what the surface carries in steady sliding.
    #[inline(always)]
    pub fn friction<C: FrictionCurve<T>>(&self, curve: &C) -> T {
        self.apply(curve.coefficient(self.sliding))
    }

    /// s μ(v) \[–\] and its derivative with respect to the signed velocity [s/m].
    #[inline(always)]
    pub fn friction_and_slope<C: FrictionCurve<T>>(&self, curve: &C) -> (T, T) {
        let (mu, slope) = curve.coefficient_and_slope(self.sliding);
        (self.apply(mu), self.apply(slope))
    }

    /// The regularised speed |v|_ε [m/s].
    #[inline(always)]
    pub fn regularised_speed<E: Regularisation<T>>(&self, regularisation: &E) -> T {
        regularisation.speed(self.sliding)
    }

    /// The regularised speed [m/s] and its slope d|v|_ε/dv \[–\].
    #[inline(always)]
    pub fn regularised_speed_and_slope<E: Regularisation<T>>(&self, regularisation: &E) -> (T, T) {
        regularisation.speed_and_slope(self.sliding)
    }

    /// The regularised sign sgn_ε(v) \[–\] and its slope [s/m].
    #[inline]
    pub fn regularised_sign_and_slope<E: Regularisation<T>>(&self, regularisation: &E) -> (T, T) {
        regularisation.sign_and_slope(self.sliding)
    }

    /// The regularised sign sgn_ε(v) \[–\].
    #[inline]
    pub fn regularised_sign<E: Regularisation<T>>(&self, regularisation: &E) -> T {
        regularisation.sign(self.sliding)
    }

    /// The springs and dashpots of a bristle, which do not scale with the load.
    #[inline(always)]
    pub fn elements<R: Rheology<T>>(&self, rheology: &R) -> Elements<T, R::Deflection> {
        rheology.elements(self.sliding)
    }

    /// The springs and dashpots of a bristle, and their derivatives with respect to the velocity.
    #[inline(always)]
    pub fn elements_and_slopes<R: Rheology<T>>(
        &self,
        rheology: &R,
    ) -> (Elements<T, R::Deflection>, Elements<T, R::Deflection>) {
        rheology.elements_and_slopes(self.sliding)
    }

    /// The larger value of a function at rest and at this speed, in the direction of a sign: what a
    /// falling or a rising curve holds at most, for a model's
    /// [`holding_coefficient`](crate::Bristle::holding_coefficient).
    pub fn largest_up_to(&self, sign: T, function: impl Fn(Self) -> T) -> T {
        let branch = Branch::locked(sign);
        let at = |speed| function(Self::scaled(branch.at_speed(speed), self.scale));
        at(self.sliding.velocity().abs()).larger(at(T::zero()))
    }

    /// The opposite velocity on the same branch, see [`Sliding::mirrored`].
    pub fn mirrored(&self) -> Self {
        Self { sliding: self.sliding.mirrored(), scale: self.scale }
    }

    /// Velocity, speed, direction and scale.
    #[inline(always)]
    pub(crate) fn parts(self) -> [T; 4] {
        let (velocity, speed, direction) = self.sliding.parts();
        [velocity, speed, direction, self.scale]
    }

    /// From parts that belong together.
    #[inline(always)]
    pub(crate) fn from_parts([velocity, speed, direction, scale]: [T; 4]) -> Self {
        Self { sliding: Sliding::from_parts(velocity, speed, direction), scale }
    }
}

/// Out of line, so that a scale of one costs a comparison and no product.
#[cold]
#[inline(never)]
fn product<T: Scalar>(coefficient: T, scale: T) -> T {
    coefficient * scale
}

impl<T: Scalar> From<T> for Surface<T> {
    #[inline(always)]
    fn from(velocity: T) -> Self {
        Self { sliding: velocity.into(), scale: T::one() }
    }
}

impl<T: Scalar> From<Sliding<T>> for Surface<T> {
    #[inline(always)]
    fn from(sliding: Sliding<T>) -> Self {
        Self { sliding, scale: T::one() }
    }
}
