//! Gears, motors and joints in files.

use bristle::parameter::Named;
use bristle::serialisation::read;
use bristle::{Bristle, Scalar, serialised_as};
use serde::{Deserialize, Deserializer, Serialize};

use crate::{
    CurrentMotor, CurrentMotorParameters, GearFriction, GearFrictionParameters, GearedJoint,
    GearedJointParameters, JointInput, LoadLaw, TorqueLoad, TorqueLoadParameters, VoltageMotor,
    VoltageMotorParameters,
};

/// Reads a number that no constructor checks, under its own name.
macro_rules! finite {
    ($($name:ident)*) => {$(
        pub(crate) fn $name<'de, T, D>(deserializer: D) -> Result<T, D::Error>
        where
            T: Scalar + Deserialize<'de>,
            D: Deserializer<'de>,
        {
            read(deserializer, |value: T| Named(stringify!($name), value).finite())
        }
    )*};
}
finite!(horizontal_torque hanging_angle proportional_gain derivative_gain);

serialised_as!([] TorqueLoad<T> as TorqueLoadParameters<T>: Self::new, Self::parameters);
serialised_as!([M: Bristle<T>, L: LoadLaw<T>] GearFriction<T, M, L> as GearFile<T, M, L>:
|file: GearFile<T, M, L>| {
    let GearFile { friction, load, reference_load, drag, fastest, .. } = file;
    let parameters = GearFrictionParameters { friction, load, reference_load, drag, fastest };
    let mut gear = Self::new(parameters)?;
    gear.set_friction_scale(file.friction_scale)?;
    gear.set_drag_scale(file.drag_scale)?;
    Ok(gear)
},
|gear| {
    let parameters = gear.parameters();
    let GearFrictionParameters { friction, load, reference_load, drag, fastest } = parameters;
    let (friction_scale, drag_scale) = (gear.friction_scale(), gear.drag_scale());
    GearFile { friction, load, reference_load, drag, fastest, friction_scale, drag_scale }
});
serialised_as!([I: JointInput<T>] CurrentMotor<T, I> as CurrentMotorParameters<T, I>:
    Self::new, Self::parameters);
serialised_as!([U: JointInput<T>] VoltageMotor<T, U> as VoltageMotorParameters<T, U>:
    Self::new, Self::parameters);
serialised_as!([M: Bristle<T, Deflection = T>, L: LoadLaw<T>, A: JointInput<T>, E: JointInput<T>]
    GearedJoint<T, M, L, A, E> as GearedJointParameters<T, M, L, A, E>:
    Self::new, Self::parameters);

/// The friction of a gear in a file, with its scales.
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
    reference_load: T,
    drag: T,
    fastest: T,
    #[serde(default = "T::one")]
    friction_scale: T,
    #[serde(default = "T::one")]
    drag_scale: T,
}
