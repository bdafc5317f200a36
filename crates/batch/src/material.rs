//! What the bristles of a batch are made of: one model for all, or parameters of each.
//!
//! μ(v) = μ_d + (μ_s − μ_d) fall(|v|/v_S) + σ2|v|, with a Kelvin–Voigt bristle σ0, σ1 on each axis.

use super::BatchError;
use super::real::{self, Real};
use bristle::curve::{AnyCurve, FrictionCurve};
use bristle::parameter::{Checked, Named, ParameterError, Rule};
use bristle::regularisation::AnyRegularisation;
use bristle::rheology::KelvinVoigt;
use bristle::scalar::lit;
use bristle::{Affine, AnyBristle, Bristle, Dahl, DahlParameters, Form, FrBd, LoadChange, Surface};
use bristle_plane::{PlaneBristle, PlaneFrBd};
use core::fmt::Debug;
pub(super) use sealed::{AxisMaterial, Material, Valley};

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

pub(super) const EXPONENTIAL: u8 = Fall::Exponential as u8;
pub(super) const GAUSSIAN: u8 = Fall::Gaussian as u8;
pub(super) const RATIONAL: u8 = Fall::Rational as u8;

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
        super::same_length(self.named().map(|(name, column)| (name, 1, column.len())))?;
        for (name, column) in self.named() {
            let zero_too = matches!(name, "viscous_frictions" | "micro_dampings");
            let gate = if zero_too { Named::non_negative } else { Named::positive };
            ParameterError::of_components(column, |&value| gate(Named(name, value)))?;
        }
        let [(name, statics), (other, dynamics), ..] = self.named();
        let pairs = statics.iter().zip(dynamics);
        let ordered = |(&above, &below): (&T, &T)| Named(name, above).at_least(other, below);
        Ok(ParameterError::of_components(pairs, ordered)?)
    }
}

impl<T: Real, const N: usize> Material<T, N> {
    /// The weighted speed ‖(aᵢ vᵢ)‖ and the speed ‖v‖.
    #[inline(always)]
    pub(super) fn speeds(&self, velocity: [T; N]) -> (T, T) {
        if let ([axis], [v]) = (self.axes.as_slice(), velocity.as_slice()) {
            return ((axis.ratio * *v).size(), v.size());
        }
        let (mut weighted, mut speed) = (T::zero(), T::zero());
        for (axis, v) in self.axes.iter().zip(velocity) {
            let along = axis.ratio * v;
            (weighted, speed) = (weighted + along * along, speed + v * v);
        }
        (weighted.sqrt(), speed.sqrt())
    }

    /// μ(v) at a speed |v|.
    #[inline(always)]
    pub(super) fn coefficient<const FALL: u8>(&self, speed: T) -> T {
        let Valley { dynamic, drop, inverse_velocity, viscous } = self.curve;
        let u = speed * inverse_velocity;
        let fall = match FALL {
            EXPONENTIAL => real::decay(-u).decay,
            GAUSSIAN => real::decay(-(u * u)).decay,
            _ => T::one() / (T::one() + u * u),
        };
        dynamic + drop * fall + viscous * speed
    }

    /// An upper bound of μ up to a speed, without an exponential.
    #[inline(always)]
    pub(super) fn most(&self, speed: T) -> T {
        self.curve.dynamic + self.curve.drop + self.curve.viscous * speed
    }
}

impl<T: Real> Valley<T> {
    #[inline(always)]
    fn new([static_, dynamic, velocity, viscous]: [T; 4]) -> Self {
        let (drop, inverse_velocity) = (static_ - dynamic, T::one() / velocity);
        Self { dynamic, drop, inverse_velocity, viscous }
    }

    /// Does not fall, at any speed.
    fn flat(dynamic: T, viscous: T) -> Self {
        Self { dynamic, drop: T::zero(), inverse_velocity: T::zero(), viscous }
    }
}

impl<T: Real> AxisMaterial<T> {
    /// The axis of a contact in which no direction is special.
    fn plain(stiffness: T, damping: T) -> Self {
        Self { ratio: T::one(), stiffness, damping }
    }

    fn of(ratio: T, bristle: &KelvinVoigt<T>) -> Self {
        let parameters = bristle.parameters();
        Self { ratio, stiffness: parameters.micro_stiffness, damping: parameters.micro_damping }
    }

    /// vᵢ/‖(aᵢ vᵢ)‖. At rest, where nothing moves, any finite number will do.
    #[inline(always)]
    pub(super) fn direction<const N: usize>(&self, velocity: T, weighted: T) -> T {
        let zero = T::zero();
        if N == 1 {
            let size = T::one() / self.ratio;
            return if velocity < zero { -size } else { size };
        }
        if weighted > zero { velocity / weighted } else { zero }
    }
}

/// A model that all bristles of a batch can share: [`FrBd`] of a Coulomb, Stribeck (exponent 1 or
/// 2) or rational Stribeck curve, one of those of [`AnyCurve`], and a constant [`KelvinVoigt`]
/// bristle, or [`Dahl`]. An [`AnyBristle`] is one if it holds one of these. A [`PlaneFrBd`] of such
/// a curve is one of N axes.
pub trait Uniform<T, const N: usize = 1>: sealed::Model<T, N> {}

pub(super) mod sealed {
    use super::{Checked, Fall};

    /// The parameters of a curve that falls from static to dynamic friction.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(crate) struct Valley<T> {
        /// μ_d
        pub(crate) dynamic: T,
        /// μ_s − μ_d
        pub(crate) drop: T,
        /// 1/v_S
        pub(crate) inverse_velocity: T,
        /// σ2
        pub(crate) viscous: T,
    }

    /// The parameters of one axis of a bristle.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(crate) struct AxisMaterial<T> {
        /// a, its friction over the curve
        pub(crate) ratio: T,
        /// σ0
        pub(crate) stiffness: T,
        /// σ1
        pub(crate) damping: T,
    }

    /// The parameters of one bristle.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Material<T, const N: usize> {
        pub(crate) curve: Valley<T>,
        pub(crate) axes: [AxisMaterial<T>; N],
        /// Whether a deflection within the ellipsoid of friction stays there: the axes relax alike.
        pub(crate) ellipsoid: bool,
    }

    /// A model that a batch can compute.
    pub trait Model<T, const N: usize> {
        fn material(&self) -> Checked<(Fall, Material<T, N>)>;
    }
}

/// The parameters of a curve that a batch can compute.
fn valley<T: Real>(curve: impl Into<AnyCurve<T>>) -> Checked<(Fall, Valley<T>)> {
    Ok(match curve.into() {
        AnyCurve::Coulomb(curve) => {
            let curve = curve.parameters();
            (Fall::Rational, Valley::flat(curve.dynamic_coefficient, curve.viscous_friction))
        }
        AnyCurve::Stribeck(curve) => {
            let p = curve.parameters();
            let exponent = p.stribeck_exponent;
            let fall = if exponent == T::one() {
                Fall::Exponential
            } else if exponent == lit(2.0) {
                Fall::Gaussian
            } else {
                let rule = Rule::Stated("be 1 or 2 here");
                return Err(Named("stribeck_exponent", exponent).refused(rule));
            };
            let (static_, dynamic) = (p.static_coefficient, p.dynamic_coefficient);
            (fall, Valley::new([static_, dynamic, p.stribeck_velocity, p.viscous_friction]))
        }
        AnyCurve::RationalStribeck(curve) => {
            let p = curve.parameters();
            let (static_, dynamic) = (p.static_coefficient, p.dynamic_coefficient);
            let valley = [static_, dynamic, p.stribeck_velocity, p.viscous_friction];
            (Fall::Rational, Valley::new(valley))
        }
        _ => {
            let takes = "a batch takes Coulomb, Stribeck or rational Stribeck";
            return Err(ParameterError::chosen("another curve", takes));
        }
    })
}

impl<T: Real, C: Into<AnyCurve<T>> + Clone> sealed::Model<T, 1> for FrBd<C, KelvinVoigt<T>> {
    fn material(&self) -> Checked<(Fall, Material<T, 1>)> {
        let (fall, curve) = valley(self.curve().clone())?;
        let axes = [AxisMaterial::of(T::one(), self.rheology())];
        Ok((fall, Material { curve, axes, ellipsoid: true }))
    }
}

impl<T, C, const N: usize> sealed::Model<T, N> for PlaneFrBd<C, T, N>
where
    T: Real,
    C: Into<AnyCurve<T>> + FrictionCurve<T>,
{
    fn material(&self) -> Checked<(Fall, Material<T, N>)> {
        let (fall, curve) = valley(self.curve().clone())?;
        let axes = self.bristles();
        let axes = axes.map(|axis| AxisMaterial::of(axis.friction_ratio, &axis.bristle));
        let ellipsoid = self.limits(T::zero()).ellipsoid;
        Ok((fall, Material { curve, axes, ellipsoid }))
    }
}

/// Dahl's model is FrBD of a constant curve and a spring.
impl<T: Real> sealed::Model<T, 1> for Dahl<T> {
    fn material(&self) -> Checked<(Fall, Material<T, 1>)> {
        let DahlParameters { dynamic_coefficient, micro_stiffness } = self.parameters();
        let curve = Valley::flat(dynamic_coefficient, T::zero());
        let axes = [AxisMaterial::plain(micro_stiffness, T::zero())];
        Ok((Fall::Rational, Material { curve, axes, ellipsoid: true }))
    }
}

impl<T: Real> sealed::Model<T, 1> for AnyBristle<T> {
    fn material(&self) -> Checked<(Fall, Material<T, 1>)> {
        match self {
            Self::FrBd(model) => match model.regularisation() {
                AnyRegularisation::Unregularised => {
                    FrBd::new(model.curve().clone(), *model.rheology()).material()
                }
                _ => Err(ParameterError::chosen("a regularised one", "a batch takes |v| as it is")),
            },
            Self::Dahl(model) => model.material(),
            _ => Err(ParameterError::chosen(self.name(), "a batch takes FrBD or Dahl")),
        }
    }
}

impl<T, M: sealed::Model<T, N>, const N: usize> Uniform<T, N> for M {}

/// A model of its own.
#[derive(Debug, Clone, Copy)]
pub(super) struct OwnModel<'a, T> {
    pub(super) object: &'a dyn Own<T>,
    /// K
    pub(super) stiffness: T,
    /// Of the deflection, at rest; infinite if the model has none.
    pub(super) limit: T,
}

impl<'a, T: Real> OwnModel<'a, T> {
    /// A model whose coefficients depend on the velocity alone.
    pub(super) fn new<M>(model: &'a M) -> Checked<Self>
    where
        M: Bristle<T, Deflection = T> + Sync,
    {
        if model.form() != Form::OfVelocity {
            let takes = "a batch takes models whose coefficients depend on the velocity alone";
            return Err(ParameterError::chosen(model.name(), takes));
        }
        let limit = model.limits(T::zero()).deflection.unwrap_or_else(T::unlimited);
        Ok(Self { object: model, stiffness: model.storage_stiffness(), limit })
    }
}

/// What a step asks of a model of its own.
pub(super) trait Own<T>: Debug + Sync {
    fn affine(&self, surface: Surface<T>, deflection: T) -> Affine<T>
    where
        T: Real;
    /// Deflection after an exact step, and mean coefficient.
    fn hold(&self, surface: Surface<T>, deflection: T, duration: T) -> (T, T);
    fn stationary(&self, surface: Surface<T>) -> T;
    /// The share of a deflection that is kept under another load.
    fn kept(&self, change: LoadChange<T>, surface: Surface<T>, carried: T) -> T;
}

impl<T: Real, M: Bristle<T, Deflection = T> + Sync> Own<T> for M {
    fn affine(&self, surface: Surface<T>, deflection: T) -> Affine<T> {
        Bristle::affine(self, surface, deflection)
    }

    fn hold(&self, surface: Surface<T>, deflection: T, duration: T) -> (T, T) {
        let step = Bristle::hold(self, surface, deflection, duration);
        (step.deflection, step.mean_coefficient)
    }

    fn stationary(&self, surface: Surface<T>) -> T {
        Bristle::stationary(self, surface)
    }

    fn kept(&self, change: LoadChange<T>, surface: Surface<T>, carried: T) -> T {
        change.kept_by(self, surface, carried)
    }
}

/// Where the parameters of a bristle come from, out of P numbers stored for each.
pub(super) trait Source<T, const N: usize, const P: usize>: Copy + Send + Sync {
    fn material(&self, columns: [T; P]) -> Material<T, N>;
}

impl<T: Real, const N: usize> Source<T, N, 0> for Material<T, N> {
    #[inline(always)]
    fn material(&self, _: [T; 0]) -> Material<T, N> {
        *self
    }
}

/// A material whose friction ratios are one: the compiler sees it, and drops their products.
#[derive(Debug, Clone, Copy)]
pub(super) struct Alike<T, const N: usize>(pub(super) Material<T, N>);

impl<T: Real, const N: usize> Source<T, N, 0> for Alike<T, N> {
    #[inline(always)]
    fn material(&self, _: [T; 0]) -> Material<T, N> {
        let Self(material) = *self;
        let plain = |axis: AxisMaterial<T>| AxisMaterial::plain(axis.stiffness, axis.damping);
        Material { axes: material.axes.map(plain), ..material }
    }
}

/// Parameters of each bristle, in the order of [`Columns::named`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Stored;

impl<T: Real, const N: usize> Source<T, N, 6> for Stored {
    #[inline(always)]
    fn material(
        &self,
        [static_, dynamic, velocity, viscous, stiffness, damping]: [T; 6],
    ) -> Material<T, N> {
        let curve = Valley::new([static_, dynamic, velocity, viscous]);
        let axes = [AxisMaterial::plain(stiffness, damping); N];
        Material { curve, axes, ellipsoid: true }
    }
}
