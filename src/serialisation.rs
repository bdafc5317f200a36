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
use crate::gear::{
    GearFriction, GearFrictionParameters, LoadLaw, TorqueLoad, TorqueLoadParameters,
};
use crate::parameter;
use crate::plane::{Axis, PlaneBristle, PlaneContact, PlaneFrBd, PlaneLuGre};
use crate::regularisation::{HyperbolicTangent, Regularisation, SquareRoot};
use crate::rheology::{
    GeneralisedKelvinVoigt, GeneralisedMaxwell, GeneralisedMaxwellParameters, KelvinVoigt,
    KelvinVoigtParameters, Maxwell, MaxwellArm, MaxwellParameters,
};
use crate::rolling::{FunctionPressure, PolynomialExponential, PolynomialExponentialParameters};
use crate::scene::{
    CurrentMotor, CurrentMotorParameters, DiaphragmValve, DiaphragmValveParameters, GearedJoint,
    GearedJointParameters, JointInput, MassSpringDamper, MassSpringDamperParameters, PlaneBody,
    PlaneBodyParameters, VoltageMotor, VoltageMotorParameters,
};
use crate::signal::{Polyline, Signal, Sine, SineParameters, Vertex};
use crate::{
    Bristle, Contact, Dahl, DahlParameters, ElastoPlastic, FoldRule, ImplicitBristle, LuGre,
    Mechanism, ParameterError, Scalar,
};

/// Arrays of any length.
pub(crate) mod array {
    use super::{Deserialize, Deserializer, Error, Serialize, Serializer, Vec};

    pub(crate) fn serialize<T: Serialize, S: Serializer, const N: usize>(
        array: &[T; N],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(array)
    }

    pub(crate) fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>, const N: usize>(
        deserializer: D,
    ) -> Result<[T; N], D::Error> {
        let list = Vec::deserialize(deserializer)?;
        let length = list.len();
        list.try_into()
            .map_err(|_| D::Error::custom(format_args!("there must be {N} of them, not {length}")))
    }
}

/// Reads a value from what a file holds, through the constructor of the value.
fn read<'de, P, T, D>(
    deserializer: D,
    new: impl FnOnce(P) -> Result<T, ParameterError>,
) -> Result<T, D::Error>
where
    P: Deserialize<'de>,
    D: Deserializer<'de>,
{
    new(P::deserialize(deserializer)?).map_err(D::Error::custom)
}

/// Reads a number that no constructor checks, under its own name.
macro_rules! finite {
    ($($name:ident)*) => {$(
        pub(crate) fn $name<'de, T, D>(deserializer: D) -> Result<T, D::Error>
        where
            T: Scalar + Deserialize<'de>,
            D: Deserializer<'de>,
        {
            read(deserializer, |value: T| parameter::finite(stringify!($name), value))
        }
    )*};
}
finite!(constant horizontal_torque hanging_angle proportional_gain derivative_gain);

/// A type that is read and written as something else: `[generics] type as what: read, write`.
macro_rules! through {
    (
        [$($generic:ident: $($bound:path)|+),* $(; const $n:ident)?]
        $type:ty as $file:ty: $new:expr, $file_of:expr
    ) => {
        impl<'de, T: Scalar + Deserialize<'de>
            $(, $generic: $($bound +)+ Deserialize<'de>)* $(, const $n: usize)?>
            Deserialize<'de> for $type
        {
            fn deserialize<De: Deserializer<'de>>(deserializer: De) -> Result<Self, De::Error> {
                read::<$file, Self, De>(deserializer, $new)
            }
        }

        impl<T: Scalar + Serialize
            $(, $generic: $($bound +)+ Serialize)* $(, const $n: usize)?>
            Serialize for $type
        {
            fn serialize<Se: Serializer>(&self, serializer: Se) -> Result<Se::Ok, Se::Error> {
                let file_of: fn(&Self) -> $file = $file_of;
                file_of(self).serialize(serializer)
            }
        }
    };
}

through!([] Coulomb<T> as CoulombParameters<T>: Self::new, Self::parameters);
through!([] Stribeck<T> as StribeckParameters<T>: Self::new, Self::parameters);
through!([] RationalStribeck<T> as RationalStribeckParameters<T>: Self::new, Self::parameters);
through!([] Dahl<T> as DahlParameters<T>: Self::new, Self::parameters);
through!([] KelvinVoigt<T> as KelvinVoigtParameters<T, T>: Self::new, Self::parameters);
through!([] Sine<T> as SineParameters<T>: Self::new, Self::parameters);
through!([] SquareRoot<T> as T: Self::new, Self::epsilon);
through!([] HyperbolicTangent<T> as T: Self::new, Self::threshold_velocity);
through!([; const N] GeneralisedMaxwell<T, N> as GeneralisedMaxwellParameters<T, N>:
    Self::new, Self::parameters);
through!([; const N] PolynomialExponential<T, N> as PolynomialExponentialParameters<T, N>:
    Self::new, Self::parameters);
through!([] Tabulated<Vec<Cubic<T>>> as Vec<Knot<T>>:
    |knots: Vec<Knot<T>>| Self::from_slice(&knots), |table| table.knots().collect());
through!([] Polyline<Vec<Vertex<T>>> as Vec<Vertex<T>>:
    Self::new, |line| line.vertices().clone());
through!([] FunctionPressure<T, Polyline<Vec<Vertex<T>>>> as Polyline<Vec<Vertex<T>>>:
    Self::new, |pressure| pressure.function().clone());
through!([] Maxwell<T> as MaxwellFile<T>:
|file: MaxwellFile<T>| {
    let MaxwellFile { micro_stiffness, series_damping } = file;
    Self::new(MaxwellParameters { micro_stiffness, series_damping })
},
|bristle| {
    let MaxwellArm { stiffness, series_damping } = *bristle.arm();
    // It has one always.
    let series_damping = series_damping.unwrap_or_else(T::zero);
    MaxwellFile { micro_stiffness: stiffness, series_damping }
});
through!([C: FrictionCurve<T>, E: Regularisation<T> | Default]
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
through!([C: FrictionCurve<T>, E: Regularisation<T> | Default]
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
through!([C: FrictionCurve<T>] ImplicitBristle<C, T> as ImplicitFile<C, T>:
|file: ImplicitFile<C, T>| Self::new(file.curve, file.rheology, file.fold_rule),
|model| ImplicitFile {
    curve: model.curve().clone(),
    rheology: *model.rheology(),
    fold_rule: model.fold_rule(),
});

through!([M: Bristle<T, Deflection = T>, F: Signal<T>]
    MassSpringDamper<T, M, F> as MassSpringDamperParameters<T, M, F>:
    Self::new, Self::parameters);
through!([M: Bristle<T, Deflection = T>, U: Signal<T>]
    DiaphragmValve<T, M, U> as DiaphragmValveParameters<T, M, U>:
    Self::new, Self::parameters);

through!([C: FrictionCurve<T>, E: Regularisation<T> | Default; const N]
PlaneFrBd<C, T, N, E> as PlaneFile<C, E, T, N>:
|file: PlaneFile<C, E, T, N>| {
    Ok(PlaneFrBd::new(file.curve, file.axes)?.regularised(file.regularisation))
},
|model| PlaneFile {
    curve: model.curve().clone(),
    axes: *model.bristles(),
    regularisation: model.regularisation().clone(),
});
through!([C: FrictionCurve<T>, E: Regularisation<T> | Default; const N]
PlaneLuGre<C, T, N, E> as PlaneLuGreFile<C, E, T, N>:
|file: PlaneLuGreFile<C, E, T, N>| {
    let PlaneLuGreFile { curve, axes, regularisation, viscous_friction } = file;
    let model = match viscous_friction {
        Some(outside) => PlaneLuGre::with_viscous_friction(curve, axes, outside)?,
        None => PlaneLuGre::classical(curve, axes)?,
    };
    Ok(model.regularised(regularisation))
},
|model| PlaneLuGreFile {
    curve: model.parts().curve().clone(),
    axes: *model.parts().bristles(),
    regularisation: model.parts().regularisation().clone(),
    viscous_friction: Some(model.viscous_friction()),
});
through!([M: PlaneBristle<T, N>, A: Signal<T>, F: Signal<T>; const N]
    PlaneBody<T, M, N, A, F> as PlaneBodyParameters<T, M, N, A, F>:
    Self::new, |body| body.parameters().clone());

through!([] TorqueLoad<T> as TorqueLoadParameters<T>: Self::new, Self::parameters);
through!([M: Bristle<T>, L: LoadLaw<T>] GearFriction<T, M, L> as GearFile<T, M, L>:
|file: GearFile<T, M, L>| {
    let GearFile { friction, load, drag, fastest, friction_scale, drag_scale } = file;
    let mut gear = Self::new(GearFrictionParameters { friction, load, drag, fastest })?;
    gear.set_friction_scale(friction_scale)?;
    gear.set_drag_scale(drag_scale)?;
    Ok(gear)
},
|gear| {
    let GearFrictionParameters { friction, load, drag, fastest } = gear.parameters();
    let (friction_scale, drag_scale) = (gear.friction_scale(), gear.drag_scale());
    GearFile { friction, load, drag, fastest, friction_scale, drag_scale }
});
through!([I: JointInput<T>] CurrentMotor<T, I> as CurrentMotorParameters<T, I>:
    Self::new, Self::parameters);
through!([U: JointInput<T>] VoltageMotor<T, U> as VoltageMotorParameters<T, U>:
    Self::new, Self::parameters);
through!([M: Bristle<T, Deflection = T>, L: LoadLaw<T>, A: JointInput<T>, E: JointInput<T>]
    GearedJoint<T, M, L, A, E> as GearedJointParameters<T, M, L, A, E>:
    Self::new, Self::parameters);

impl<'de, T, M> Deserialize<'de> for Contact<T, M>
where
    T: Scalar + Deserialize<'de>,
    M: Bristle<T> + Deserialize<'de>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read(deserializer, |file: ContactFile<T, M>| Self::new(file.model, file.normal_force))
    }
}

impl<'de, T, M, const N: usize> Deserialize<'de> for PlaneContact<T, M, N>
where
    T: Scalar + Deserialize<'de>,
    M: PlaneBristle<T, N> + Deserialize<'de>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read(deserializer, |file: ContactFile<T, M>| Self::new(file.model, file.normal_force))
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
}

/// A Maxwell bristle in a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Maxwell")]
struct MaxwellFile<T> {
    micro_stiffness: T,
    series_damping: T,
}

/// What a model of a curve C, a regularisation E and a scalar T is in a file.
macro_rules! model_file {
    ($(#[$about:meta])* $name:literal $file:ident[$($generic:tt)*] { $($fields:tt)* }) => {
        $(#[$about])*
        #[derive(Serialize, Deserialize)]
        #[serde(
            deny_unknown_fields,
            rename = $name,
            bound(
                deserialize = "C: Deserialize<'de>, E: Default + Deserialize<'de>, \
                               T: Scalar + Deserialize<'de>",
                serialize = "C: Serialize, E: Serialize, T: Scalar + Serialize"
            )
        )]
        struct $file<$($generic)*> { $($fields)* }
    };
}

model_file! {
    /// A LuGre model in a file: g(v) and the viscous friction outside it. If that is absent, it is
    /// the classical model, whose curve gives it.
    "LuGre" LuGreFile[C, E, T] {
        curve: C,
        rheology: KelvinVoigt<T>,
        #[serde(default)]
        regularisation: E,
        #[serde(default = "Option::default")]
        viscous_friction: Option<T>,
    }
}

model_file! {
    /// A model on several axes in a file.
    "PlaneFrBd" PlaneFile[C, E, T, const N: usize] {
        curve: C,
        #[serde(with = "array")]
        axes: [Axis<T>; N],
        #[serde(default)]
        regularisation: E,
    }
}

model_file! {
    /// A LuGre model on several axes in a file: g and the viscous friction outside it, as of
    /// [`LuGreFile`].
    "PlaneLuGre" PlaneLuGreFile[C, E, T, const N: usize] {
        curve: C,
        #[serde(with = "array")]
        axes: [Axis<T>; N],
        #[serde(default)]
        regularisation: E,
        #[serde(default = "Option::default")]
        viscous_friction: Option<T>,
    }
}

/// The friction of a gear in a file, with its scales; its load is that without torques.
#[derive(Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    rename = "GearFriction",
    bound(
        deserialize = "T: Scalar + Deserialize<'de>, M: Deserialize<'de>, L: Deserialize<'de>",
        serialize = "T: Scalar + Serialize, M: Serialize, L: Serialize"
    )
)]
struct GearFile<T, M, L> {
    friction: M,
    load: L,
    drag: T,
    fastest: T,
    #[serde(default = "T::one")]
    friction_scale: T,
    #[serde(default = "T::one")]
    drag_scale: T,
}

model_file! {
    /// An elasto-plastic model in a file.
    "ElastoPlastic" ElastoPlasticFile[C, E, T] {
        curve: C,
        rheology: KelvinVoigt<T>,
        #[serde(default)]
        regularisation: E,
        stick_limit: T,
    }
}

/// An implicit bristle in a file.
#[derive(Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    rename = "Implicit",
    bound(
        deserialize = "C: Deserialize<'de>, T: Scalar + Deserialize<'de>",
        serialize = "C: Serialize, T: Scalar + Serialize"
    )
)]
struct ImplicitFile<C, T> {
    curve: C,
    rheology: KelvinVoigt<T>,
    #[serde(default = "Option::default")]
    fold_rule: Option<FoldRule>,
}

impl<'de, T: Scalar + Deserialize<'de>, const N: usize> Deserialize<'de>
    for GeneralisedKelvinVoigt<T, N>
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::new(array::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

impl<T: Scalar + Serialize, const N: usize> Serialize for GeneralisedKelvinVoigt<T, N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        array::serialize(self.elements(), serializer)
    }
}
