//! Parameters, models and scenes in files, with serde and a format of the user's choice.
//!
//! Parameters are read field by field, and everything built of them goes through its constructor:
//! a file is refused with parameter, value and rule, at the place that the format reports. Unknown
//! fields are refused. What is written reads back to the same bits.

use alloc::vec::Vec;

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::curve::{
    Coulomb, CoulombParameters, Cubic, FrictionCurve, Knot, RationalStribeck,
    RationalStribeckParameters, Stribeck, StribeckParameters, Tabulated,
};
use crate::parameter::{Checked, Named};
use crate::regularisation::{HyperbolicTangent, Regularisation, SquareRoot};
use crate::rheology::{
    GeneralisedMaxwell, GeneralisedMaxwellParameters, KelvinVoigt, KelvinVoigtParameters, Maxwell,
    MaxwellParameters,
};
use crate::scene::{
    DiaphragmValve, DiaphragmValveParameters, MassSpringDamper, MassSpringDamperParameters,
};
use crate::signal::{Polyline, Signal, Sine, SineParameters, Vertex};
use crate::{
    Bristle, Contact, Dahl, DahlParameters, ElastoPlastic, ImplicitBristle, LuGre, Mechanism,
    Scalar,
};

/// Arrays of any length.
pub mod array {
    use super::{Deserialize, Deserializer, Error, Serialize, Serializer, Vec};

    /// Writes an array as a list.
    ///
    /// # Errors
    ///
    /// Those of the format.
    pub fn serialize<T: Serialize, S: Serializer, const N: usize>(
        array: &[T; N],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(array)
    }

    /// Reads a list of N.
    ///
    /// # Errors
    ///
    /// Another number of them, and those of the format.
    pub fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>, const N: usize>(
        deserializer: D,
    ) -> Result<[T; N], D::Error> {
        let list = Vec::deserialize(deserializer)?;
        let length = list.len();
        list.try_into()
            .map_err(|_| D::Error::custom(format_args!("there must be {N} of them, not {length}")))
    }
}

/// Reads a value from what a file holds, through the constructor of the value.
///
/// # Errors
///
/// What the constructor refuses, at the place in the file.
pub fn read<'de, P, T, D>(deserializer: D, new: impl FnOnce(P) -> Checked<T>) -> Result<T, D::Error>
where
    P: Deserialize<'de>,
    D: Deserializer<'de>,
{
    new(P::deserialize(deserializer)?).map_err(D::Error::custom)
}

/// Reads a signal that does not change: no constructor checks it.
pub(crate) fn constant<'de, T, D>(deserializer: D) -> Result<T, D::Error>
where
    T: Scalar + Deserialize<'de>,
    D: Deserializer<'de>,
{
    read(deserializer, |value| Named("constant", value).finite())
}

/// Implements serde's traits for a type that is read and written as something else:
/// `[generics] type as what: read, write`, with T for the scalar.
#[macro_export]
macro_rules! serialised_as {
    (
        [$($generic:ident: $($bound:path)|+),* $(; const $n:ident)?]
        $type:ty as $file:ty: $new:expr, $file_of:expr
    ) => {
        impl<'de, T: $crate::Scalar + ::serde::Deserialize<'de>
            $(, $generic: $($bound +)+ ::serde::Deserialize<'de>)* $(, const $n: usize)?>
            ::serde::Deserialize<'de> for $type
        {
            fn deserialize<De: ::serde::Deserializer<'de>>(
                deserializer: De,
            ) -> Result<Self, De::Error> {
                $crate::serialisation::read::<$file, Self, De>(deserializer, $new)
            }
        }

        impl<T: $crate::Scalar + ::serde::Serialize
            $(, $generic: $($bound +)+ ::serde::Serialize)* $(, const $n: usize)?>
            ::serde::Serialize for $type
        {
            fn serialize<Se: ::serde::Serializer>(
                &self,
                serializer: Se,
            ) -> Result<Se::Ok, Se::Error> {
                let file_of: fn(&Self) -> $file = $file_of;
                ::serde::Serialize::serialize(&file_of(self), serializer)
            }
        }
    };
}

serialised_as!([] Coulomb<T> as CoulombParameters<T>: Self::new, Self::parameters);
serialised_as!([] Stribeck<T> as StribeckParameters<T>: Self::new, Self::parameters);
serialised_as!([] RationalStribeck<T> as RationalStribeckParameters<T>:
    Self::new, Self::parameters);
serialised_as!([] Dahl<T> as DahlParameters<T>: Self::new, Self::parameters);
serialised_as!([] KelvinVoigt<T> as KelvinVoigtParameters<T>: Self::new, Self::parameters);
serialised_as!([] Sine<T> as SineParameters<T>: Self::new, Self::parameters);
serialised_as!([] SquareRoot<T> as T: Self::new, Self::epsilon);
serialised_as!([] HyperbolicTangent<T> as T: Self::new, Self::threshold_velocity);
serialised_as!([; const N] GeneralisedMaxwell<T, N> as GeneralisedMaxwellParameters<T, N>:
    Self::new, Self::parameters);
serialised_as!([] Tabulated<Vec<Cubic<T>>> as Vec<Knot<T>>:
    |knots: Vec<Knot<T>>| Self::from_slice(&knots), |table| table.knots().collect());
serialised_as!([] Polyline<Vec<Vertex<T>>> as Vec<Vertex<T>>:
    Self::new, |line| line.vertices().clone());
serialised_as!([] Maxwell<T> as MaxwellParameters<T>: Self::new, Self::parameters);
serialised_as!([C: FrictionCurve<T>, E: Regularisation<T> | Default]
LuGre<C, KelvinVoigt<T>, E, T> as LuGreFile<C, E, T>:
|file: LuGreFile<C, E, T>| {
    let LuGreFile { curve, rheology, regularisation, viscous_friction } = file;
    let model = match viscous_friction {
        Some(outside) => LuGre::with_viscous_friction(curve, rheology, outside)?,
        None => LuGre::classical(curve, rheology),
    };
    Ok(model.regularised(regularisation))
},
|model| LuGreFile {
    curve: model.curve().clone(),
    rheology: *model.rheology(),
    regularisation: model.regularisation().clone(),
    viscous_friction: Some(model.viscous_friction()),
});
serialised_as!([C: FrictionCurve<T>, E: Regularisation<T> | Default]
ElastoPlastic<C, KelvinVoigt<T>, E, T> as ElastoPlasticFile<C, E, T>:
|file: ElastoPlasticFile<C, E, T>| {
    let ElastoPlasticFile { curve, rheology, regularisation, stick_limit } = file;
    Ok(ElastoPlastic::new(curve, rheology, stick_limit)?.regularised(regularisation))
},
|model| ElastoPlasticFile {
    curve: model.plastic().curve().clone(),
    rheology: *model.plastic().rheology(),
    regularisation: model.plastic().regularisation().clone(),
    stick_limit: model.stick_limit(),
});
serialised_as!([C: FrictionCurve<T>] ImplicitBristle<C, T> as ImplicitFile<C, T>:
|file: ImplicitFile<C, T>| Self::new(file.curve, file.rheology),
|model| ImplicitFile {
    curve: model.curve().clone(),
    rheology: *model.rheology(),
});

serialised_as!([M: Bristle<T, Deflection = T>, F: Signal<T>]
    MassSpringDamper<T, M, F> as MassSpringDamperParameters<T, M, F>:
    Self::new, |rig| rig.parameters().clone());
serialised_as!([M: Bristle<T, Deflection = T>, U: Signal<T>]
    DiaphragmValve<T, M, U> as DiaphragmValveParameters<T, M, U>:
    Self::new, |valve| valve.parameters().clone());

impl<'de, T: Scalar + Deserialize<'de>, M: Deserialize<'de>> Deserialize<'de> for Contact<T, M> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read(deserializer, |file: ContactFile<T, M>| {
            let contact = Self::new(file.model, file.normal_force)?;
            match file.reference_load.filter(|load| *load != T::zero()) {
                Some(load) => contact.measured_at(load),
                None => Ok(contact),
            }
        })
    }
}

impl<'de, T: Scalar + Deserialize<'de>> Deserialize<'de> for Mechanism<T> {
    // Checked here, too, so that the place of a refusal is that of the mechanism.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read(deserializer, |file: MechanismFile<T>| {
            let MechanismFile { mass, spring_stiffness, viscous_damping } = file;
            Self { mass, spring_stiffness, viscous_damping }.checked()
        })
    }
}

/// A mechanism in a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Mechanism")]
struct MechanismFile<T> {
    mass: T,
    spring_stiffness: T,
    viscous_damping: T,
}

/// A contact in a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Contact")]
struct ContactFile<T, M> {
    model: M,
    normal_force: T,
    #[serde(default = "Option::default")]
    reference_load: Option<T>,
}

/// A LuGre model in a file: g(v) and the viscous friction outside it. If that is absent, it is
/// the classical model, whose curve gives it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "LuGre")]
struct LuGreFile<C, E, T: Scalar> {
    curve: C,
    rheology: KelvinVoigt<T>,
    #[serde(default)]
    regularisation: E,
    #[serde(default = "Option::default")]
    viscous_friction: Option<T>,
}

/// An elasto-plastic model in a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "ElastoPlastic")]
struct ElastoPlasticFile<C, E, T: Scalar> {
    curve: C,
    rheology: KelvinVoigt<T>,
    #[serde(default)]
    regularisation: E,
    stick_limit: T,
}

/// An implicit bristle in a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Implicit")]
struct ImplicitFile<C, T: Scalar> {
    curve: C,
    rheology: KelvinVoigt<T>,
}
