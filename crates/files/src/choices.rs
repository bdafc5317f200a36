//! What a file chooses from beside the choices of the library.

use bristle::curve::AnyCurve;
use bristle::parameter::Named;
use bristle::regularisation::AnyRegularisation;
use bristle::rheology::{MaxwellArm, ZenerParameters};
use bristle::serialisation;
use bristle::signal::{AnySignal, Polyline, Sine, Vertex};
use bristle_joint::{
    CurrentMotor, Gravity, JointInput, JointInputValue, JointMotion, PositionControl, VoltageMotor,
};
use bristle_plane::{DiscPressure, FootprintPoint, PlaneFrBd, PlaneLuGre};
use serde::{Deserialize, Deserializer, Serialize};

use crate::setup::{Result, must};

/// Most points of a footprint.
const MOST_POINTS: u64 = 100_000;

/// Springs side by side, or in a row.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Springs {
    /// A spring alone beside one behind a dashpot.
    Zener(ZenerParameters<f64>),
    /// Side by side, each alone or behind a dashpot, beside one dashpot [s/m].
    GeneralisedMaxwell { arms: Vec<MaxwellArm<f64>>, micro_damping: f64 },
}

/// Friction with bristle dynamics on N axes.
pub(crate) type Frbd<const N: usize> = PlaneFrBd<AnyCurve<f64>, f64, N, AnyRegularisation<f64>>;

/// LuGre on N axes.
pub(crate) type Lugre<const N: usize> = PlaneLuGre<AnyCurve<f64>, f64, N, AnyRegularisation<f64>>;

/// A friction model of N axes.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum PlaneModel<const N: usize> {
    FrBd(Frbd<N>),
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

/// A model of N axes under a normal force [N].
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Pressed<const N: usize> {
    pub(crate) model: PlaneModel<N>,
    pub(crate) normal_force: f64,
}

/// The points of a contact surface.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Points {
    /// Of a disc: its radius [m], how the pressure falls towards the edge, rings of points.
    Disc { radius: f64, pressure: DiscPressure, rings: u16 },
    /// Of a rectangle under a uniform pressure: length and width [m], columns and rows.
    Rectangle { size: [f64; 2], counts: [u16; 2] },
    /// Given one by one.
    List(Vec<FootprintPoint<f64>>),
}

impl Points {
    /// The points, if there are not too many.
    pub(crate) fn points(&self) -> Result<Vec<FootprintPoint<f64>>> {
        let few = |count: u64, name: &str, value: String| match count {
            0..=MOST_POINTS => Ok(()),
            _ => must(name, value, format!("give up to {MOST_POINTS} points, not {count}")),
        };
        match self {
            &Self::Disc { radius, pressure, rings } => {
                few(3 * u64::from(rings).pow(2), "rings", rings.to_string())?;
                if !(radius >= 0.0) {
                    return must("radius", radius, "be zero or positive");
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

/// What acts on a joint: a signal, gravity or a controller.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Input {
    Constant(#[serde(deserialize_with = "constant")] f64),
    Sine(Sine<f64>),
    Polyline(Polyline<Vec<Vertex<f64>>>),
    /// The torque of a link that hangs from the joint.
    Gravity(Gravity<f64>),
    PositionControl(PositionControl<f64, AnySignal<f64>>),
}

fn constant<'de, D: Deserializer<'de>>(of: D) -> std::result::Result<f64, D::Error> {
    serialisation::read(of, |constant| Named("constant", constant).finite())
}

/// The motor of a joint: a torque [N m], a current [A] or a voltage [V].
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Motor {
    Torque(Input),
    Current(CurrentMotor<f64, Input>),
    Voltage(VoltageMotor<f64, Input>),
}

/// A choice of inputs is an input.
macro_rules! input {
    ($choice:ident: $($variant:ident)*) => {
        impl JointInput<f64> for $choice {
            fn at(&self, motion: JointMotion<f64>) -> JointInputValue<f64> {
                match self {
                    $(Self::$variant(input) => input.at(motion),)*
                }
            }

            fn next_kink(&self, time: f64, towards: f64) -> Option<f64> {
                match self {
                    $(Self::$variant(input) => JointInput::next_kink(input, time, towards),)*
                }
            }

            fn longest_step(&self) -> Option<f64> {
                match self {
                    $(Self::$variant(input) => JointInput::longest_step(input),)*
                }
            }
        }
    };
}
input!(Input: Constant Sine Polyline Gravity PositionControl);
input!(Motor: Torque Current Voltage);

#[cfg(test)]
mod tests {
    use super::*;
    use bristle::ParameterError;
    use bristle::signal::SineParameters;

    #[test]
    fn a_motor_hands_on_the_steps_of_its_input() -> std::result::Result<(), ParameterError> {
        let parameters = SineParameters { mean: 0.0, amplitude: 1.0, frequency: 5.0, phase: 0.0 };
        let sine = Sine::new(parameters)?;
        let motor = Motor::Torque(Input::Sine(sine));
        assert!(motor.longest_step().is_some());
        assert_eq!(motor.longest_step(), JointInput::longest_step(&sine));
        Ok(())
    }
}
