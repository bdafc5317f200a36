//! What the bristles of a batch are made of: one model for all, or parameters of each.

use super::real::Real;
use crate::curve::{Coulomb, RationalStribeck, Stribeck};
use crate::parameter::{self, ParameterError, Rule};
use crate::rheology::{KelvinVoigt, Rheology, Spring};
use crate::scalar::{lit, to_f64};
use crate::{Dahl, FrBd, Sliding};

/// How friction falls from its static to its dynamic coefficient, over u = |v|/v_S.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fall {
    /// e^−u, the Stribeck curve of exponent δ = 1.
    Exponential,
    /// e^−u², the Stribeck curve of exponent δ = 2.
    Gaussian,
    /// 1/(1 + u²), the rational Stribeck curve: no exponential.
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

impl<T: Real> Columns<'_, T> {
    /// The columns as [`Stored`] takes them.
    pub(super) fn in_order(&self) -> [&[T]; 6] {
        [
            self.static_coefficients,
            self.dynamic_coefficients,
            self.stribeck_velocities,
            self.viscous_frictions,
            self.micro_stiffnesses,
            self.micro_dampings,
        ]
    }

    /// Checks the parameters of one bristle, if all slices have it.
    pub(super) fn check(&self, index: usize) -> Result<(), ParameterError> {
        let check = |name, column: &[T], gate: fn(&'static str, T) -> Result<T, ParameterError>| {
            let value = column.get(index).copied().unwrap_or_else(T::one);
            parameter::component(index, gate(name, value))
        };
        let (positive, non_negative) = (parameter::positive::<T>, parameter::non_negative::<T>);
        let dynamic = check("dynamic_coefficients", self.dynamic_coefficients, positive)?;
        let static_ = check("static_coefficients", self.static_coefficients, positive)?;
        let above =
            parameter::at_least("static_coefficients", static_, "dynamic_coefficients", dynamic);
        parameter::component(index, above)?;
        check("stribeck_velocities", self.stribeck_velocities, positive)?;
        check("viscous_frictions", self.viscous_frictions, non_negative)?;
        check("micro_stiffnesses", self.micro_stiffnesses, positive)?;
        check("micro_dampings", self.micro_dampings, non_negative)?;
        Ok(())
    }
}

/// The parameters of one bristle: μ(v) = μ_d + (μ_s − μ_d) fall(|v|/v_S) + σ2|v|, σ0 and σ1.
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

/// A model that all bristles of a batch can share: [`FrBd`] of a [`Coulomb`], [`Stribeck`] (exponent
/// 1 or 2) or [`RationalStribeck`] curve and a [`Spring`] or a constant [`KelvinVoigt`] bristle, or [`Dahl`].
pub trait Uniform<T>: sealed::Model<T> {}

pub(super) mod sealed {
    use super::{Fall, Material, ParameterError, Rheology};
    use crate::Scalar;

    /// A model that a batch can do.
    pub trait Model<T> {
        fn material(&self) -> Result<(Fall, Material<T>), ParameterError>;
    }

    /// A curve that a batch can do; of the material all but the bristle.
    pub trait Curve<T> {
        fn curve(&self) -> Result<(Fall, Material<T>), ParameterError>;
    }

    /// A bristle that a batch can do: one spring, and nothing depends on the velocity.
    pub trait Constant<T: Scalar>: Rheology<T, Deflection = T> {}
}

impl<T: Real> sealed::Constant<T> for Spring<T> {}
impl<T: Real> sealed::Constant<T> for KelvinVoigt<T> {}

impl<T: Real> sealed::Curve<T> for Stribeck<T> {
    fn curve(&self) -> Result<(Fall, Material<T>), ParameterError> {
        let (one, two) = (T::one(), lit(2.0));
        let exponent = self.exponent();
        let fall = if exponent == one {
            Fall::Exponential
        } else if exponent == two {
            Fall::Gaussian
        } else {
            return Err(ParameterError {
                name: "stribeck_exponent",
                component: None,
                value: to_f64(exponent),
                rule: Rule::Either { first: 1.0, second: 2.0 },
            });
        };
        Ok((
            fall,
            Material {
                dynamic: self.dynamic,
                drop: self.drop,
                inverse_velocity: self.inverse_velocity,
                viscous: self.viscous,
                stiffness: T::zero(),
                damping: T::zero(),
            },
        ))
    }
}

impl<T: Real> sealed::Curve<T> for RationalStribeck<T> {
    fn curve(&self) -> Result<(Fall, Material<T>), ParameterError> {
        Ok((
            Fall::Rational,
            Material {
                dynamic: self.dynamic,
                drop: self.drop,
                inverse_velocity: self.inverse_velocity,
                viscous: self.viscous,
                stiffness: T::zero(),
                damping: T::zero(),
            },
        ))
    }
}

impl<T: Real> sealed::Curve<T> for Coulomb<T> {
    fn curve(&self) -> Result<(Fall, Material<T>), ParameterError> {
        let zero = T::zero();
        // Nothing falls, at any speed.
        Ok((
            Fall::Rational,
            Material {
                dynamic: self.dynamic,
                drop: zero,
                inverse_velocity: zero,
                viscous: self.viscous,
                stiffness: zero,
                damping: zero,
            },
        ))
    }
}

impl<T, C, R> sealed::Model<T> for FrBd<C, R>
where
    T: Real,
    C: sealed::Curve<T>,
    R: sealed::Constant<T>,
{
    fn material(&self) -> Result<(Fall, Material<T>), ParameterError> {
        let (fall, curve) = self.curve().curve()?;
        let elements = self.rheology().elements(Sliding::from(T::zero()));
        let (stiffness, damping) = (elements.stiffness, elements.damping);
        Ok((fall, Material { stiffness, damping, ..curve }))
    }
}

impl<T: Real, C: sealed::Curve<T>, R: sealed::Constant<T>> Uniform<T> for FrBd<C, R> {}

impl<T: Real> sealed::Model<T> for Dahl<T> {
    fn material(&self) -> Result<(Fall, Material<T>), ParameterError> {
        // FrBD of a constant curve and a spring.
        let zero = T::zero();
        Ok((
            Fall::Rational,
            Material {
                dynamic: self.dynamic,
                drop: zero,
                inverse_velocity: zero,
                viscous: zero,
                stiffness: self.stiffness,
                damping: zero,
            },
        ))
    }
}

impl<T: Real> Uniform<T> for Dahl<T> {}

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

/// Parameters of each bristle, see [`Columns::in_order`].
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

impl<T: Real> Material<T> {
    /// μ(v) at a speed |v|.
    #[inline(always)]
    pub(super) fn coefficient<F: Falling<T>>(&self, speed: T) -> T {
        self.dynamic + self.drop * F::fall(speed * self.inverse_velocity) + self.viscous * speed
    }

    /// 1/σ0: of shared parameters the compiler takes it out of the loop.
    #[inline(always)]
    pub(super) fn compliance(&self) -> T {
        T::one() / self.stiffness
    }

    /// A number that μ nowhere exceeds up to a speed, without an exponential.
    #[inline(always)]
    pub(super) fn most(&self, speed: T) -> T {
        self.dynamic + self.drop + self.viscous * speed
    }
}
