//! A friction model chosen at run time.

#[cfg(feature = "alloc")]
use super::own::OwnModel;
use super::{
    Affine, Characteristics, Dahl, ElastoPlastic, Form, FrBd, HeldStep, ImplicitBristle, Law,
    Limits, Linearised, LuGre,
};
use crate::curve::{AnyCurve, FrictionCurve};
use crate::regularisation::AnyRegularisation;
use crate::rheology::{KelvinVoigt, Maxwell};
use crate::{Bristle, LoadChange, Scalar, Surface};

/// A friction model of one deflection chosen at run time, by a configuration file for instance: one
/// of this crate's, over any curve. It gives the same bits as the model that it holds.
///
/// It goes wherever a model goes: contacts, companions, scenes, audits, compensators, patches and
/// batches. What takes only some of the models refuses the others when it is built.
///
/// ```
/// use bristle::curve::{AnyCurve, Stribeck};
/// use bristle::rheology::KelvinVoigt;
/// use bristle::{AnyBristle, Bristle, FrBd, LuGre, ParameterError, paper};
///
/// fn named(name: &str, curve: AnyCurve<f64>) -> Result<AnyBristle<f64>, ParameterError> {
///     let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
///     Ok(match name {
///         "lugre" => LuGre::classical(curve, bristle).into(),
///         _ => FrBd::new(curve, bristle).into(),
///     })
/// }
/// let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
/// let friction = named("lugre", curve.into())?.under_load(10.0)?;
/// let fixed = LuGre::classical(curve, KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?);
/// assert_eq!(friction.force(0.1, 1e-4), fixed.under_load(10.0)?.force(0.1, 1e-4));
/// # Ok::<(), ParameterError>(())
/// ```
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum AnyBristle<T: Scalar> {
    /// Friction with bristle dynamics: a spring and a dashpot side by side.
    #[cfg_attr(feature = "serde", serde(rename = "frbd"))]
    FrBd(FrBd<AnyCurve<T>, KelvinVoigt<T>, AnyRegularisation<T>>),
    /// FrBD with a bristle that creeps: a spring and a dashpot in series.
    Maxwell(FrBd<AnyCurve<T>, Maxwell<T>, AnyRegularisation<T>>),
    /// The LuGre model.
    #[cfg_attr(feature = "serde", serde(rename = "lugre"))]
    LuGre(LuGre<AnyCurve<T>, KelvinVoigt<T>, AnyRegularisation<T>, T>),
    /// The Dahl model.
    Dahl(Dahl<T>),
    /// The elasto-plastic FrBD model.
    ElastoPlastic(ElastoPlastic<AnyCurve<T>, KelvinVoigt<T>, AnyRegularisation<T>, T>),
    /// The implicit bristle.
    Implicit(ImplicitBristle<AnyCurve<T>, T>),
    /// A model of your own, see [`AnyBristle::own`].
    #[cfg(feature = "alloc")]
    #[cfg_attr(feature = "serde", serde(skip))]
    Own(OwnModel<T>),
}

/// Calls a function of the model.
macro_rules! of_the_model {
    ($self:ident, $model:ident => $answer:expr) => {
        match $self {
            AnyBristle::FrBd($model) => $answer,
            AnyBristle::Maxwell($model) => $answer,
            AnyBristle::LuGre($model) => $answer,
            AnyBristle::Dahl($model) => $answer,
            AnyBristle::ElastoPlastic($model) => $answer,
            AnyBristle::Implicit($model) => $answer,
            #[cfg(feature = "alloc")]
            AnyBristle::Own($model) => $answer,
        }
    };
}

impl<T: Scalar> AnyBristle<T> {
    /// A model of your own with one deflection. It goes where the others go, at the cost of a call
    /// for each evaluation; files do not hold it.
    #[cfg(feature = "alloc")]
    pub fn own(model: impl Bristle<T, Deflection = T> + Send + Sync + 'static) -> Self {
        Self::Own(OwnModel::new(model))
    }

    /// The coefficients of the larger models: a call, so that the others are inlined, with numbers
    /// for arguments, because what is passed in memory is waited for in the others, too.
    #[inline(never)]
    fn called(&self, parts: [T; 4], deflection: T) -> Affine<T> {
        of_the_model!(self, model => model.affine(Surface::from_parts(parts), deflection))
    }
}

impl<T: Scalar> Bristle<T> for AnyBristle<T> {
    type Deflection = T;

    #[inline(always)]
    fn affine(&self, surface: Surface<T>, deflection: T) -> Affine<T> {
        match self {
            Self::FrBd(model) => model.affine(surface, deflection),
            Self::Maxwell(model) => model.affine(surface, deflection),
            Self::LuGre(model) => model.affine(surface, deflection),
            Self::Dahl(model) => model.affine(surface, deflection),
            _ => self.called(surface.parts(), deflection),
        }
    }

    passed_on! { of_the_model:
        #[inline]
        affine_and_slopes(surface: Surface<T>, deflection: T) -> (Affine<T>, Affine<T>);
        form() -> Form;
        name() -> &'static str;
        stationary(surface: impl Into<Surface<T>>) -> T;
        stationary_coefficient(surface: impl Into<Surface<T>>) -> T;
        #[inline]
        storage_stiffness() -> T;
        folding_scale() -> Option<T>;
        switching_function(surface: Surface<T>, deflection: T) -> Option<T>;
        holding_coefficient(surface: Surface<T>, carried: T) -> T;
        #[inline]
        held(change: LoadChange<T>, surface: Surface<T>, deflection: T) -> T;
        obeys(law: Law) -> bool;
        limits(fastest: T) -> Limits<T>;
        characteristics(fastest: T) -> Option<Characteristics<T>>;
        #[inline]
        linearised(surface: impl Into<Surface<T>>, deflection: T) -> Linearised<T>;
        steady_linearised(surface: impl Into<Surface<T>>) -> Linearised<T>;
        #[inline]
        hold(surface: impl Into<Surface<T>>, deflection: T, duration: T) -> HeldStep<T>;
    }
}

/// Models whose curve and modulus become choices.
macro_rules! holds_parts {
    ($($variant:ident($model:ident<$bristle:ident $(, $scalar:ident)?>))*) => {$(
        impl<T, C, E> From<$model<C, $bristle<T>, E $(, $scalar)?>> for AnyBristle<T>
        where
            T: Scalar,
            C: Into<AnyCurve<T>>,
            E: Into<AnyRegularisation<T>>,
        {
            fn from(model: $model<C, $bristle<T>, E $(, $scalar)?>) -> Self {
                Self::$variant(model.map(C::into, E::into))
            }
        }
    )*};
}

holds_parts! {
    FrBd(FrBd<KelvinVoigt>)
    Maxwell(FrBd<Maxwell>)
    LuGre(LuGre<KelvinVoigt, T>)
    ElastoPlastic(ElastoPlastic<KelvinVoigt, T>)
}
holds! { AnyBristle: Dahl(Dahl<T>) }

impl<T: Scalar, C: FrictionCurve<T> + Into<AnyCurve<T>>> From<ImplicitBristle<C, T>>
    for AnyBristle<T>
{
    fn from(model: ImplicitBristle<C, T>) -> Self {
        Self::Implicit(model.map(C::into))
    }
}
