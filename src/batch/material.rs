//! What the bristles of a batch are made of: one model for all, or parameters of each.
//!
//! μ(v) = μ_d + (μ_s − μ_d) fall(|v|/v_S) + σ2|v|, with a Kelvin–Voigt bristle σ0, σ1.

use super::BatchError;
use super::real::Real;
use crate::curve::{Coulomb, RationalStribeck, Stribeck, Valley};
use crate::parameter::{self, ParameterError, Rule};
use crate::rheology::{KelvinVoigt, Rheology};
use crate::scalar::lit;
use crate::{Dahl, FrBd, Sliding};

/// How friction falls from its static to its dynamic coefficient, over u = |v|/v_S.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fall {
    /// e^−u: the Stribeck curve of exponent δ = 1.
    Exponential,
    /// e^−u²: the Stribeck curve of exponent δ = 2.
    Gaussian,
    /// 1/(1 + u²): the rational Stribeck curve, which needs no exponential.
    Rational,
}

/// Parameters of every bristle of a batch, one slice for each: FrBD with a Kelvin–Voigt bristle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Columns<'a, T> {
    /// Static friction coefficients μ_s \[–\], each at least the dynamic one.
    #[doc(alias = "mu_s")]
    pub static_coefficients: &'a [T],
    /// Dynamic friction coefficients μ_d \[–\], positive.
    #[doc(alias = "mu_d")]
    pub dynamic_coefficients: &'a [T],
    /// Stribeck velocities v_S [m/s], positive.
    #[doc(alias = "v_S")]
    pub stribeck_velocities: &'a [T],
    /// Viscous frictions σ2 [s/m], zero or positive.
    #[doc(alias = "sigma2")]
    pub viscous_frictions: &'a [T],
    /// Normalised micro-stiffnesses σ0 [1/m], positive.
    #[doc(alias = "sigma0")]
    pub micro_stiffnesses: &'a [T],
    /// Normalised micro-dampings σ1 [s/m], zero or positive.
    #[doc(alias = "sigma1")]
    pub micro_dampings: &'a [T],
}

impl<'a, T: Real> Columns<'a, T> {
    /// The columns with their names, in the order that [`Stored`] takes them.
    pub(super) fn named(&self) -> [(&'static str, &'a [T]); 6] {
        [
            ("static_coefficients", self.static_coefficients),
            ("dynamic_coefficients", self.dynamic_coefficients),
            ("stribeck_velocities", self.stribeck_velocities),
            ("viscous_frictions", self.viscous_frictions),
            ("micro_stiffnesses", self.micro_stiffnesses),
            ("micro_dampings", self.micro_dampings),
        ]
    }

    /// Checks the lengths and every value.
    pub(super) fn check(&self) -> Result<(), BatchError> {
        super::same_length(self.named().map(|(name, column)| (name, column.len())))?;
        let (positive, non_negative) = (parameter::positive::<T>, parameter::non_negative::<T>);
        type Gate<T> = fn(&'static str, T) -> Result<T, ParameterError>;
        let gates: [Gate<T>; 6] =
            [positive, positive, positive, non_negative, positive, non_negative];
        for ((name, column), gate) in self.named().into_iter().zip(gates) {
            for (index, &value) in column.iter().enumerate() {
                parameter::component(index, gate(name, value))?;
            }
        }
        let [(static_name, statics), (dynamic_name, dynamics), ..] = self.named();
        for (index, (&static_, &dynamic)) in statics.iter().zip(dynamics).enumerate() {
            let above = parameter::at_least(static_name, static_, dynamic_name, dynamic);
            parameter::component(index, above)?;
        }
        Ok(())
    }
}

/// The parameters of one bristle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material<T> {
    /// μ_d
    pub(super) dynamic: T,
    /// μ_s − μ_d
    pub(super) drop: T,
    /// 1/v_S
    pub(super) inverse_velocity: T,
    /// σ2
    pub(super) viscous: T,
    /// σ0
    pub(super) stiffness: T,
    /// σ1
    pub(super) damping: T,
}

impl<T: Real> Material<T> {
    /// μ(v) at a speed |v|.
    #[inline(always)]
    pub(super) fn coefficient<F: Falling<T>>(&self, speed: T) -> T {
        self.dynamic + self.drop * F::fall(speed * self.inverse_velocity) + self.viscous * speed
    }

    /// 1/σ0. Of shared parameters the compiler takes it out of the loop.
    #[inline(always)]
    pub(super) fn compliance(&self) -> T {
        T::one() / self.stiffness
    }

    /// An upper bound of μ up to a speed, without an exponential.
    #[inline(always)]
    pub(super) fn most(&self, speed: T) -> T {
        self.dynamic + self.drop + self.viscous * speed
    }
}

/// A model that all bristles of a batch can share: [`FrBd`] of a [`Coulomb`], [`Stribeck`]
/// (exponent 1 or 2) or [`RationalStribeck`] curve and a constant [`KelvinVoigt`]
/// bristle, or [`Dahl`].
pub trait Uniform<T>: sealed::Model<T> {}

pub(super) mod sealed {
    use super::{Fall, Material, ParameterError};

    /// A model that a batch can compute.
    pub trait Model<T> {
        fn material(&self) -> Result<(Fall, Material<T>), ParameterError>;
    }

    /// A curve that a batch can compute, as a material whose bristle is still to be filled in.
    pub trait Curve<T> {
        fn curve(&self) -> Result<(Fall, Material<T>), ParameterError>;
    }

    /// A bristle of one spring, none of whose elements depends on the velocity.
    pub trait Constant {}
}

impl<T> sealed::Constant for KelvinVoigt<T> {}

impl<T: Real> sealed::Curve<T> for Stribeck<T> {
    fn curve(&self) -> Result<(Fall, Material<T>), ParameterError> {
        let exponent = self.exponent();
        let fall = if exponent == T::one() {
            Fall::Exponential
        } else if exponent == lit(2.0) {
            Fall::Gaussian
        } else {
            let rule = Rule::Stated("be 1 or 2 here");
            return Err(parameter::refused("stribeck_exponent", exponent, rule));
        };
        let Valley { dynamic, drop, inverse_velocity, viscous } = self.valley;
        Ok((fall, Material { drop, inverse_velocity, ..flat(dynamic, viscous) }))
    }
}

impl<T: Real> sealed::Curve<T> for RationalStribeck<T> {
    fn curve(&self) -> Result<(Fall, Material<T>), ParameterError> {
        let Valley { dynamic, drop, inverse_velocity, viscous } = self.0;
        Ok((Fall::Rational, Material { drop, inverse_velocity, ..flat(dynamic, viscous) }))
    }
}

impl<T: Real> sealed::Curve<T> for Coulomb<T> {
    fn curve(&self) -> Result<(Fall, Material<T>), ParameterError> {
        Ok((Fall::Rational, flat(self.dynamic, self.viscous)))
    }
}

/// A curve that does not fall, at any speed; without a bristle.
fn flat<T: Real>(dynamic: T, viscous: T) -> Material<T> {
    let zero = T::zero();
    Material {
        dynamic,
        drop: zero,
        inverse_velocity: zero,
        viscous,
        stiffness: zero,
        damping: zero,
    }
}

impl<T, C, R> sealed::Model<T> for FrBd<C, R>
where
    T: Real,
    C: sealed::Curve<T>,
    R: Rheology<T, Deflection = T> + sealed::Constant,
{
    fn material(&self) -> Result<(Fall, Material<T>), ParameterError> {
        let (fall, curve) = self.curve().curve()?;
        let elements = self.rheology().elements(Sliding::from(T::zero()));
        let (stiffness, damping) = (elements.stiffness, elements.damping);
        Ok((fall, Material { stiffness, damping, ..curve }))
    }
}

/// Dahl's model is FrBD of a constant curve and a spring.
impl<T: Real> sealed::Model<T> for Dahl<T> {
    fn material(&self) -> Result<(Fall, Material<T>), ParameterError> {
        let curve = flat(self.dynamic, T::zero());
        Ok((Fall::Rational, Material { stiffness: self.stiffness, ..curve }))
    }
}

impl<T, M: sealed::Model<T>> Uniform<T> for M {}

/// Where the parameters of a bristle come from, out of P numbers stored for each.
pub(super) trait Source<T, const P: usize>: Copy + Send + Sync {
    fn material(&self, columns: [T; P]) -> Material<T>;
}

impl<T: Real> Source<T, 0> for Material<T> {
    #[inline(always)]
    fn material(&self, _: [T; 0]) -> Material<T> {
        *self
    }
}

/// Parameters of each bristle, in the order of [`Columns::named`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Stored;

impl<T: Real> Source<T, 6> for Stored {
    #[inline(always)]
    fn material(
        &self,
        [static_, dynamic, velocity, viscous, stiffness, damping]: [T; 6],
    ) -> Material<T> {
        let (drop, inverse_velocity) = (static_ - dynamic, T::one() / velocity);
        Material { dynamic, drop, inverse_velocity, viscous, stiffness, damping }
    }
}

/// The fall of a curve as a type, chosen before the loop over the bristles.
pub(super) trait Falling<T>: Copy + Send + Sync {
    fn fall(u: T) -> T;
}

macro_rules! falling {
    ($($name:ident: $u:ident => $fall:expr;)*) => {$(
        #[derive(Debug, Clone, Copy)]
        pub(super) struct $name;
        impl<T: Real> Falling<T> for $name {
            #[inline(always)]
            fn fall($u: T) -> T {
                $fall
            }
        }
    )*};
}

falling! {
    Exponential: u => super::real::decay(-u).decay;
    Gaussian: u => super::real::decay(-(u * u)).decay;
    Rational: u => T::one() / (T::one() + u * u);
}
