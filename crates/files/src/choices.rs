//! What a file chooses from beside the choices of the library.

use std::fmt;
use std::marker::PhantomData;

use bristle::curve::AnyCurve;
use bristle::regularisation::AnyRegularisation;
use bristle::rheology::{KelvinVoigtParameters, MaxwellArm, ZenerParameters};
use bristle::signal::{AnySignal, Polyline, Signal, Sine, Vertex};
use bristle_joint::{
    CurrentMotor, Gravity, JointInput, JointInputValue, JointMotion, PositionControl, VoltageMotor,
};
use bristle_plane::{DiscPressure, FootprintPoint, PlaneFrBd, PlaneLuGre};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, IgnoredAny, IntoDeserializer, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::setup::Result;

/// Most points of a footprint.
const MOST_POINTS: u64 = 100_000;

/// Springs side by side, or in a row.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Springs {
    /// A spring alone beside one behind a dashpot.
    Zener(ZenerParameters<f64>),
    /// Side by side, each alone or behind a dashpot, beside one dashpot.
    GeneralisedMaxwell {
        /// The springs.
        arms: Vec<MaxwellArm<f64>>,
        /// The dashpot beside them [s/m].
        micro_damping: f64,
    },
    /// In a row, each beside a dashpot.
    GeneralisedKelvinVoigt(Vec<KelvinVoigtParameters<f64, f64>>),
}

/// Friction with bristle dynamics on N axes.
pub type Frbd<const N: usize> = PlaneFrBd<AnyCurve<f64>, f64, N, AnyRegularisation<f64>>;

/// LuGre on N axes.
pub type Lugre<const N: usize> = PlaneLuGre<AnyCurve<f64>, f64, N, AnyRegularisation<f64>>;

/// A friction model of N axes.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PlaneModel<const N: usize> {
    /// Friction with bristle dynamics.
    #[serde(rename = "frbd")]
    FrBd(Frbd<N>),
    /// The LuGre model.
    #[serde(rename = "lugre")]
    LuGre(Lugre<N>),
}

/// Calls a function of the model.
macro_rules! of_the_model {
    ($model:expr, $name:ident => $answer:expr) => {
        match $model {
            $crate::choices::PlaneModel::FrBd($name) => $answer,
            $crate::choices::PlaneModel::LuGre($name) => $answer,
        }
    };
}
pub(crate) use of_the_model;

/// A model of N axes under a normal force.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pressed<const N: usize> {
    /// The model.
    pub model: PlaneModel<N>,
    /// Normal force [N].
    pub normal_force: f64,
}

/// The points of a contact surface.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Points {
    /// Of a disc.
    Disc {
        /// Radius [m].
        radius: f64,
        /// How the pressure falls towards the edge.
        pressure: DiscPressure,
        /// Rings of points.
        rings: u16,
    },
    /// Of a rectangle under a uniform pressure.
    Rectangle {
        /// Length and width [m].
        size: [f64; 2],
        /// Columns and rows.
        counts: [u16; 2],
    },
    /// Given one by one.
    List(Vec<FootprintPoint<f64>>),
}

impl Points {
    /// The points, if there are not too many.
    pub fn points(&self) -> Result<Vec<FootprintPoint<f64>>> {
        let few = |count: u64, name: &str, value: String| {
            let rule = format!("must give up to {MOST_POINTS} points, not {count}");
            if count <= MOST_POINTS {
                Ok(())
            } else {
                Err(format!("{name} is {value}, but {rule}"))
            }
        };
        match self {
            &Self::Disc { radius, pressure, rings } => {
                few(3 * u64::from(rings).pow(2), "rings", rings.to_string())?;
                if !(radius >= 0.0) {
                    return Err(format!("radius is {radius}, but must be zero or positive").into());
                }
                Ok(FootprintPoint::disc(radius, pressure, rings).collect())
            }
            &Self::Rectangle { size, counts } => {
                let [columns, rows] = counts.map(u64::from);
                few(columns * rows, "counts", format!("{counts:?}"))?;
                Ok(FootprintPoint::rectangle(size, counts).collect())
            }
            Self::List(points) => Ok(points.clone()),
        }
    }
}

/// What acts on a joint: a signal, gravity or a controller. A plain number is a constant.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum Input {
    /// A number.
    #[serde(deserialize_with = "finite_constant")]
    Constant(f64),
    /// A sine.
    Sine(Sine<f64>),
    /// Straight lines between points.
    Polyline(Polyline<Vec<Vertex<f64>>>),
    /// The torque of a link that hangs from the joint.
    Gravity(Gravity<f64>),
    /// A position controller.
    PositionControl(PositionControl<f64, FileSignal>),
}

fn finite_constant<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> std::result::Result<f64, D::Error> {
    let constant = f64::deserialize(deserializer)?;
    let refused = || D::Error::custom(format!("constant is {constant}, but must be finite"));
    constant.is_finite().then_some(constant).ok_or_else(refused)
}

impl Serialize for Input {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

impl<'de> Deserialize<'de> for Input {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        deserializer.deserialize_any(OrNumber(PhantomData))
    }
}

/// A signal of the library. A plain number is a constant.
#[derive(Debug, Clone, Serialize)]
#[serde(transparent)]
pub struct FileSignal(AnySignal<f64>);

impl FileSignal {
    /// Zero at all times.
    pub fn none() -> Self {
        Self(AnySignal::Constant(0.0))
    }
}

impl<'de> Deserialize<'de> for FileSignal {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        deserializer.deserialize_any(OrNumber(PhantomData))
    }
}

impl Signal<f64> for FileSignal {
    fn value(&self, time: f64) -> f64 {
        self.0.value(time)
    }

    fn value_and_rate(&self, time: f64) -> (f64, f64) {
        self.0.value_and_rate(time)
    }

    fn next_kink(&self, time: f64, towards: f64) -> Option<f64> {
        Signal::next_kink(&self.0, time, towards)
    }

    fn longest_step(&self) -> Option<f64> {
        self.0.longest_step()
    }
}

/// A choice of which a file may give the constant as a plain number.
trait Choice: Sized {
    const EXPECTED: &'static str;

    fn constant(value: f64) -> Self;

    fn chosen<'de, D: Deserializer<'de>>(of: D) -> std::result::Result<Self, D::Error>;
}

impl Choice for Input {
    const EXPECTED: &'static str = "an input: a number, `constant`, `sine`, `polyline`, `gravity` \
                                    or `position_control`";

    fn constant(value: f64) -> Self {
        Self::Constant(value)
    }

    fn chosen<'de, D: Deserializer<'de>>(of: D) -> std::result::Result<Self, D::Error> {
        Self::deserialize(of)
    }
}

impl Choice for FileSignal {
    const EXPECTED: &'static str = "a signal: a number, `constant`, `sine` or `polyline`";

    fn constant(value: f64) -> Self {
        Self(AnySignal::Constant(value))
    }

    fn chosen<'de, D: Deserializer<'de>>(of: D) -> std::result::Result<Self, D::Error> {
        AnySignal::deserialize(of).map(Self)
    }
}

struct OrNumber<C>(PhantomData<C>);

impl<'de, C: Choice> Visitor<'de> for OrNumber<C> {
    type Value = C;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(C::EXPECTED)
    }

    fn visit_f64<E: Error>(self, value: f64) -> std::result::Result<C, E> {
        finite_constant(value.into_deserializer()).map(C::constant)
    }

    fn visit_i64<E: Error>(self, value: i64) -> std::result::Result<C, E> {
        self.visit_f64(value as f64)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<C, A::Error> {
        let chosen = C::chosen(MapAccessDeserializer::new(&mut map))?;
        match map.next_key::<IgnoredAny>()? {
            None => Ok(chosen),
            Some(_) => Err(A::Error::custom("wanted exactly 1 element")),
        }
    }
}

/// Calls a function of the input.
macro_rules! of_the_input {
    ($self:ident, $input:ident => $answer:expr) => {
        match $self {
            Input::Constant($input) => $answer,
            Input::Sine($input) => $answer,
            Input::Polyline($input) => $answer,
            Input::Gravity($input) => $answer,
            Input::PositionControl($input) => $answer,
        }
    };
}

impl Input {
    /// The time over which it turns once at most.
    pub fn longest_step(&self) -> Option<f64> {
        match self {
            Self::Sine(sine) => sine.longest_step(),
            Self::PositionControl(control) => control.reference.longest_step(),
            _ => None,
        }
    }
}

impl JointInput<f64> for Input {
    fn at(&self, motion: JointMotion<f64>) -> JointInputValue<f64> {
        of_the_input!(self, input => input.at(motion))
    }

    fn next_kink(&self, time: f64, towards: f64) -> Option<f64> {
        of_the_input!(self, input => JointInput::next_kink(input, time, towards))
    }
}

/// The motor of a joint.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Motor {
    /// A torque [N m].
    Torque(Input),
    /// A current [A].
    Current(CurrentMotor<f64, Input>),
    /// A voltage [V].
    Voltage(VoltageMotor<f64, Input>),
}

impl Motor {
    /// The time over which its input turns once at most.
    pub fn longest_step(&self) -> Option<f64> {
        match self {
            Self::Torque(input) => input.longest_step(),
            Self::Current(motor) => motor.parameters().current.longest_step(),
            Self::Voltage(motor) => motor.parameters().voltage.longest_step(),
        }
    }
}

impl JointInput<f64> for Motor {
    fn at(&self, motion: JointMotion<f64>) -> JointInputValue<f64> {
        match self {
            Self::Torque(input) => input.at(motion),
            Self::Current(motor) => motor.at(motion),
            Self::Voltage(motor) => motor.at(motion),
        }
    }

    fn next_kink(&self, time: f64, towards: f64) -> Option<f64> {
        match self {
            Self::Torque(input) => input.next_kink(time, towards),
            Self::Current(motor) => motor.next_kink(time, towards),
            Self::Voltage(motor) => motor.next_kink(time, towards),
        }
    }
}

/// Arrays of a generic length, read from lists.
pub mod array {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<V: Serialize, S: Serializer, const N: usize>(
        array: &[V; N],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(array)
    }

    pub fn deserialize<'de, V: Deserialize<'de>, D: Deserializer<'de>, const N: usize>(
        deserializer: D,
    ) -> Result<[V; N], D::Error> {
        let list = Vec::deserialize(deserializer)?;
        list.try_into().map_err(|list: Vec<V>| {
            D::Error::custom(format!("there must be {N} of them, not {}", list.len()))
        })
    }
}
