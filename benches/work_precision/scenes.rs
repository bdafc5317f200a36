//! The scenes on which methods are compared: the paper's experiments, with both friction models.
//!
//! | scene | what | judged by | scale |
//! |---|---|---|---|
//! | S1 | stick-slip, 100 s, from rest | position | 1 m |
//! | S2 ramp | valve, OP 0 → 100 % over 100 s, then held, 120 s | position | 0.036 m |
//! | S2 sine | valve, OP = 50 + 40 sin(2π·0.05 t) %, 120 s | position | 0.036 m |
//! | S3 | pre-sliding at 1, 5 and 10 Hz, ten periods, from rest | position | μ_s/σ0 |
//! | S4 | frictional lag at 25, 50 and 100 Hz, twenty periods | deflection | μ_s/σ0 |
//! | S5 | block pulled around a circle by two springs, 40 s, from rest | position x | 1 m |
//!
//! S5 has two axes and nothing to lock: its friction depends on ‖v‖, which has a cone, not a kink.

use std::fmt;
use std::rc::Rc;

use bristle::curve::Stribeck;
use bristle::exponential::Exponential;
use bristle::ode::{Linearisation, Statistics, System};
use bristle::rheology::KelvinVoigt;
use bristle::scene::{
    DiaphragmValve, MassSpringDamper, MassSpringDamperParameters, PrescribedVelocity,
};
use bristle::signal::{Polyline, Signal, Sine, SineParameters, Vertex};
use bristle::{Branch, Bristle, FrBd, LuGre, Mechanism, ParameterError, paper};
use bristle_plane::{Axis, PlaneBristle, PlaneFrBd, PlaneLuGre};
use bristle_plane::{PlaneBody, PlaneBodyParameters};
use nalgebra::{SVector, Vector1, Vector6};

/// A system over a time span from t = 0, and how solutions of it are judged.
#[derive(Debug, Clone)]
pub struct Scene<S, const N: usize> {
    /// A name without spaces.
    pub name: &'static str,
    /// The friction model: `frbd` or `lugre`.
    pub model: &'static str,
    /// What is integrated.
    pub system: S,
    /// The state at t = 0.
    pub start: SVector<f64, N>,
    /// A typical magnitude of each state, for tolerances.
    pub scales: SVector<f64, N>,
    /// The end of the time span [s].
    pub end: f64,
    /// The component that is judged.
    pub judged: usize,
    /// What its error is divided by, in its unit.
    pub scale: f64,
    /// The same scene as a bristle dragged at a known velocity, where it is one.
    pub dragged: Option<Dragged>,
}

/// Runs a dragged bristle with adaptive or fixed steps: its deflections at the uniform samples.
#[derive(Clone)]
pub struct Dragged(Rc<DragRun>);

type DragRun = dyn Fn(DragSetting) -> Result<(Vec<f64>, Statistics), String>;

/// How the steps of a dragged bristle are chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DragSetting {
    /// By a tolerance, relative to the deflection at breakaway.
    Tolerance(f64),
    /// All of this length \[s\].
    Step(f64),
}

impl Dragged {
    /// Runs it.
    pub fn run(&self, setting: DragSetting) -> Result<(Vec<f64>, Statistics), String> {
        self.0(setting)
    }
}

impl fmt::Debug for Dragged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Dragged")
    }
}

/// What is done with every scene, whatever its number of states.
pub trait Visitor {
    /// Is shown one scene.
    fn visit<S: System<f64, N> + Clone, const N: usize>(&mut self, scene: &Scene<S, N>);
}

/// Output samples over which an error is taken, evenly spaced from t = 0 to the end.
pub const SAMPLES: usize = 2001;

/// How many scenes [`each`] shows.
pub const COUNT: usize = 20;

/// Shows every scene, each with FrBD and with classical LuGre.
pub fn each(visitor: &mut impl Visitor) -> Result<(), ParameterError> {
    stick_slip("frbd", frbd(TABLE_2)?, visitor)?;
    stick_slip("lugre", lugre(TABLE_2)?, visitor)?;
    valve("frbd", frbd(TABLE_3)?, visitor)?;
    valve("lugre", lugre(TABLE_3)?, visitor)?;
    for (name, frequency) in [("S3_1Hz", 1.0), ("S3_5Hz", 5.0), ("S3_10Hz", 10.0)] {
        presliding(name, "frbd", frbd(TABLE_2)?, frequency, visitor)?;
        presliding(name, "lugre", lugre(TABLE_2)?, frequency, visitor)?;
    }
    for (name, frequency) in [("S4_25Hz", 25.0), ("S4_50Hz", 50.0), ("S4_100Hz", 100.0)] {
        lag(name, "frbd", frbd(TABLE_2)?, frequency, visitor)?;
        lag(name, "lugre", lugre(TABLE_2)?, frequency, visitor)?;
    }
    let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
    let axes = [1.0, 0.6].map(|friction_ratio| Axis { friction_ratio, bristle });
    let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
    pulled_block("frbd", PlaneFrBd::new(curve, axes)?, visitor)?;
    pulled_block("lugre", PlaneLuGre::classical(curve, axes)?, visitor)?;
    Ok(())
}

type Parameters =
    (bristle::curve::StribeckParameters<f64>, bristle::rheology::KelvinVoigtParameters<f64>);

/// Stick-slip, pre-sliding and lag.
const TABLE_2: Parameters = (paper::STICK_SLIP_CURVE, paper::STICK_SLIP_BRISTLE);
/// The valve.
const TABLE_3: Parameters = (paper::VALVE_CURVE, paper::VALVE_BRISTLE);

type FrictionCurve = Stribeck<f64>;
type Spring = KelvinVoigt<f64>;

fn frbd((curve, bristle): Parameters) -> Result<FrBd<FrictionCurve, Spring>, ParameterError> {
    Ok(FrBd::new(Stribeck::new(curve)?, KelvinVoigt::new(bristle)?))
}

fn lugre(
    (curve, bristle): Parameters,
) -> Result<LuGre<FrictionCurve, KelvinVoigt<f64>>, ParameterError> {
    Ok(LuGre::classical(Stribeck::new(curve)?, KelvinVoigt::new(bristle)?))
}

/// Deflection at breakaway [m] with Table 2.
fn breakaway_deflection() -> f64 {
    paper::STICK_SLIP_CURVE.static_coefficient / paper::STICK_SLIP_BRISTLE.micro_stiffness
}

fn stick_slip<M: Bristle<f64, Deflection = f64>>(
    model: &'static str,
    friction: M,
    visitor: &mut impl Visitor,
) -> Result<(), ParameterError> {
    let rig = MassSpringDamper::new(paper::stick_slip_rig(friction.under_load(1.0)?))?;
    visitor.visit(&Scene {
        name: "S1",
        model,
        start: rig.at_rest(),
        scales: rig.scales(),
        system: rig,
        end: 100.0,
        judged: 0,
        scale: 1.0,
        dragged: None,
    });
    Ok(())
}

fn valve<M: Bristle<f64, Deflection = f64>>(
    model: &'static str,
    friction: M,
    visitor: &mut impl Visitor,
) -> Result<(), ParameterError> {
    let contact = friction.under_load(1.0)?;
    let ramp =
        Polyline::new([Vertex { time: 0.0, value: 0.0 }, Vertex { time: 100.0, value: 100.0 }])?;
    let wave =
        Sine::new(SineParameters { mean: 50.0, amplitude: 40.0, frequency: 0.05, phase: 0.0 })?;
    let [first, second] = [0.933, 0.425]; // s, in the paper
    valve_test("S2_ramp", model, contact.clone(), first, ramp, visitor)?;
    valve_test("S2_sine", model, contact, second, wave, visitor)
}

fn valve_test<M: Bristle<f64, Deflection = f64>, U: Signal<f64>>(
    name: &'static str,
    model: &'static str,
    contact: bristle::Contact<f64, M>,
    time_constant: f64,
    opening: U,
    visitor: &mut impl Visitor,
) -> Result<(), ParameterError> {
    let valve = DiaphragmValve::new(paper::valve(contact, time_constant, opening))?;
    visitor.visit(&Scene {
        name,
        model,
        start: valve.balanced(0.0),
        scales: valve.scales(),
        system: valve,
        end: 120.0,
        judged: 0,
        scale: 0.036,
        dragged: None,
    });
    Ok(())
}

fn presliding<M: Bristle<f64, Deflection = f64>>(
    name: &'static str,
    model: &'static str,
    friction: M,
    frequency: f64,
    visitor: &mut impl Visitor,
) -> Result<(), ParameterError> {
    let amplitude = 0.9 * paper::STICK_SLIP_CURVE.static_coefficient;
    let scene = MassSpringDamper::new(MassSpringDamperParameters {
        contact: friction.under_load(1.0)?,
        mechanism: Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 },
        drive_velocity: 0.0,
        force: Sine::new(SineParameters { mean: 0.0, amplitude, frequency, phase: 0.0 })?,
    })?;
    visitor.visit(&Scene {
        name,
        model,
        start: scene.at_rest(),
        scales: scene.scales(),
        system: scene,
        end: 10.0 / frequency,
        judged: 0,
        scale: breakaway_deflection(),
        dragged: None,
    });
    Ok(())
}

fn lag<M: Bristle<f64, Deflection = f64> + 'static>(
    name: &'static str,
    model: &'static str,
    friction: M,
    frequency: f64,
    visitor: &mut impl Visitor,
) -> Result<(), ParameterError> {
    let velocity = SineParameters { mean: 0.0055, amplitude: 0.005, frequency, phase: 0.0 };
    let (contact, velocity) = (friction.under_load(1.0)?, Sine::new(velocity)?);
    let end = 20.0 / frequency;
    let scene = PrescribedVelocity::new(contact.clone(), velocity);
    let dragged = Dragged(Rc::new(move |setting| {
        let method = Exponential::<5>;
        let solver = match setting {
            DragSetting::Tolerance(tolerance) => method.adaptive(tolerance),
            DragSetting::Step(step) => method.fixed(step),
        };
        let solver = solver.map_err(|error| error.to_string())?;
        let mut deflections = Vec::with_capacity(SAMPLES);
        let store = |_, deflection| deflections.push(deflection);
        let cost = solver.sample(&contact, &velocity, 0.0..end, 0.0, SAMPLES, store);
        Ok((deflections, cost.map_err(|failure| failure.to_string())?))
    }));
    visitor.visit(&Scene {
        name,
        model,
        start: Vector1::new(0.0),
        scales: Vector1::new(breakaway_deflection()),
        system: scene,
        end,
        judged: 0,
        scale: breakaway_deflection(),
        dragged: Some(dragged),
    });
    Ok(())
}

fn pulled_block<M: PlaneBristle<f64, 2>>(
    model: &'static str,
    friction: M,
    visitor: &mut impl Visitor,
) -> Result<(), ParameterError> {
    let (amplitude, frequency) = (1.5, 0.3 / std::f64::consts::TAU);
    let anchor =
        |mean, amplitude, phase| Sine::new(SineParameters { mean, amplitude, frequency, phase });
    let mechanism = Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.0 };
    let block = PlaneBody::new(PlaneBodyParameters {
        contact: friction.under_load(1.0)?,
        mechanisms: [mechanism; 2],
        anchor: [
            anchor(0.0, amplitude, 0.0)?,
            anchor(amplitude, -amplitude, std::f64::consts::FRAC_PI_2)?,
        ],
        force: [0.0; 2],
    })?;
    visitor.visit(&Scene {
        name: "S5",
        model,
        start: Vector6::zeros(),
        scales: block.scales(),
        system: NeverReverses(block),
        end: 40.0,
        judged: 0,
        scale: 1.0,
        dragged: None,
    });
    Ok(())
}

/// A system without sliding velocities, as one with a velocity that never reverses.
#[derive(Debug, Clone)]
struct NeverReverses<S>(S);

impl<S: System<f64, N, 0>, const N: usize> System<f64, N> for NeverReverses<S> {
    fn rate(&self, time: f64, state: &SVector<f64, N>, _: [Branch; 1]) -> SVector<f64, N> {
        self.0.rate(time, state, [])
    }

    fn sliding_velocities(&self, _: f64, _: &SVector<f64, N>) -> [f64; 1] {
        [1.0]
    }

    fn linearised(
        &self,
        time: f64,
        state: &SVector<f64, N>,
        _: [Branch; 1],
    ) -> Option<Linearisation<f64, N>> {
        self.0.linearised(time, state, [])
    }

    fn scales(&self) -> SVector<f64, N> {
        self.0.scales()
    }
}
