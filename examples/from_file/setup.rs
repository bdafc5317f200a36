//! What a file of the example `from_file` holds, and its simulation.

use std::fmt::Display;

use bristle::curve::AnyCurve;
use bristle::gear::{GearFriction, GearFrictionParameters, TorqueLoad};
use bristle::nalgebra::{SMatrix, SVector, Vector2};
use bristle::ode::{AnyMethod, Output, Solver, System, Tolerances};
use bristle::plane::PlaneFrBd;
use bristle::regularisation::AnyRegularisation;
use bristle::rheology::{
    GeneralisedKelvinVoigt, GeneralisedMaxwell, GeneralisedMaxwellParameters,
    KelvinVoigtParameters, MaxwellArm, Rheology,
};
use bristle::rolling::{AnyPressure, Patch, PatchParameters, PolynomialExponential};
use bristle::scene::{
    BrakedWheel, BrakedWheelParameters, CurrentMotor, CurrentMotorParameters, DiaphragmValve,
    GearedJoint, GearedJointParameters, Gravity, JointInput, JointMotion, MassSpringDamper,
    PlaneBody, PositionControl, PrescribedVelocity, VoltageMotor, VoltageMotorParameters,
    WheelLoads,
};
use bristle::signal::{AnySignal, Signal};
use bristle::stability::{self, Scheme};
use bristle::{AnyBristle, Branch, Bristle, FrBd, ParameterError};
use serde::{Deserialize, Serialize};

/// What may go wrong: a refused parameter, or a run that stopped.
pub(crate) type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// A scene, and how it is solved.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Setup {
    /// Time span, method and accuracy.
    pub(crate) solver: SolverSetup,
    /// Contact and mechanism.
    pub(crate) scene: SceneSetup,
}

/// Time span, method and accuracy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SolverSetup {
    /// The run goes from t = 0 to here [s].
    pub(crate) end: f64,
    /// Rows of the table, evenly spaced, both ends included.
    pub(crate) samples: usize,
    /// The method; `automatic` if it is absent.
    pub(crate) method: Option<AnyMethod>,
    /// Tolerance relative to the scale of each state, for adaptive steps; 1e-6 if neither it nor a
    /// step is given.
    pub(crate) tolerance: Option<f64>,
    /// Length [s] of fixed steps, in place of a tolerance.
    pub(crate) step: Option<f64>,
}

/// Every scene of this crate with one contact.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(clippy::large_enum_variant, reason = "there is one")]
pub(crate) enum SceneSetup {
    /// A bristle dragged at a given velocity.
    PrescribedVelocity(PrescribedVelocity<f64, AnyBristle<f64>, AnySignal<f64>>),
    /// A bristle of several springs dragged at a given velocity.
    Viscoelastic(Viscoelastic),
    /// A mass with a spring, a damper and friction.
    MassSpringDamper(MassSpringDamper<f64, AnyBristle<f64>, AnySignal<f64>>),
    /// A pneumatic valve.
    DiaphragmValve(DiaphragmValve<f64, AnyBristle<f64>, AnySignal<f64>>),
    /// A wheel that is braked to a stop.
    BrakedWheel(Wheel),
    /// A joint driven by a motor through a gear.
    GearedJoint(Joint),
    /// A body that slides in a plane, on springs whose far ends move.
    PlaneBody(PlaneBlock),
}

/// A body on two axes.
pub(crate) type PlaneBlock = PlaneBody<
    f64,
    PlaneFrBd<AnyCurve<f64>, f64, 2, AnyRegularisation<f64>>,
    2,
    AnySignal<f64>,
    AnySignal<f64>,
>;

/// FrBD with a bristle of one to six springs.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Viscoelastic {
    /// The friction curve.
    pub(crate) curve: AnyCurve<f64>,
    /// The springs.
    pub(crate) springs: Springs,
    /// Normal force [N].
    pub(crate) normal_force: f64,
    /// Sliding velocity v(t) [m/s].
    pub(crate) velocity: AnySignal<f64>,
}

/// Springs side by side, or in a row.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Springs {
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

/// A braked wheel with its load and its brake.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Wheel {
    /// Wheel, tyre and brake.
    pub(crate) wheel: BrakedWheelParameters<f64, Tyre, AnyBristle<f64>>,
    /// Normal force of the tyre [N].
    pub(crate) tyre_load: f64,
    /// Normal force of the brake over time: its capacity over μ.
    pub(crate) brake_load: AnySignal<f64>,
}

/// A joint driven by a motor through a gear.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Joint {
    /// Friction of the gear, its load law and its drag.
    pub(crate) gear: GearFrictionParameters<f64, AnyBristle<f64>, TorqueLoad<f64>>,
    /// Moment of inertia at the joint [kg m²].
    pub(crate) inertia: f64,
    /// The motor.
    pub(crate) motor: Motor,
    /// Gravity on the link.
    pub(crate) gravity: Gravity<f64>,
    /// Angle at the beginning [rad].
    pub(crate) angle: f64,
}

/// The motor of a joint.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Motor {
    /// A torque over time [N m].
    Torque(AnySignal<f64>),
    /// A current over time [A].
    Current(CurrentMotorParameters<f64, AnySignal<f64>>),
    /// A voltage over time [V].
    Voltage(VoltageMotorParameters<f64, AnySignal<f64>>),
    /// A current that follows from a position controller [A].
    PositionControl(CurrentMotorParameters<f64, PositionControl<f64, AnySignal<f64>>>),
}

/// A tyre in a file: the model of its bristles, its length and its pressure.
pub(crate) type Tyre = PatchParameters<f64, AnyBristle<f64>, AnyPressure<f64>>;

/// A column: its name, the label of its axis, and the factor from SI units to those of the axis.
pub(crate) type Column = (&'static str, &'static str, f64);

/// A run as a table: named columns with their labels, and rows that begin with the time.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Table {
    /// The columns after the time.
    pub(crate) columns: Vec<Column>,
    /// The rows.
    pub(crate) rows: Vec<Vec<f64>>,
}

const FORCE: Column = ("force", "friction force F (N)", 1.0);
const BODY: [Column; 3] =
    [("x", "position x (m)", 1.0), ("v", "velocity v (m/s)", 1.0), ("z", "deflection z (µm)", 1e6)];

impl Setup {
    /// Checks the solver's keys and simulates the scene.
    pub(crate) fn run(&self) -> Result<Table> {
        self.solver.check(matches!(self.scene, SceneSetup::BrakedWheel(_)))?;
        self.simulate()
    }

    /// Simulates the scene.
    pub(crate) fn simulate(&self) -> Result<Table> {
        let solver = &self.solver;
        match &self.scene {
            SceneSetup::PrescribedVelocity(scene) => {
                let columns = vec![BODY[1], BODY[2], FORCE];
                solver.run(scene, SVector::zeros(), columns, |time, state: &SVector<f64, 1>| {
                    vec![scene.velocity(time), state[0], scene.friction_force(time, state)]
                })
            }
            SceneSetup::Viscoelastic(scene) => scene.run(solver),
            SceneSetup::MassSpringDamper(rig) => {
                let columns = [&BODY[..], &[FORCE]].concat();
                solver.run(rig, rig.at_rest(), columns, |_, state| {
                    vec![state[0], state[1], state[2], rig.friction_force(state)]
                })
            }
            SceneSetup::DiaphragmValve(valve) => {
                let parameters = valve.parameters();
                let pressure = ("pressure", "pressure P (kPa)", 1e-3);
                let opening = ("opening", "opening OP (%)", 1.0);
                let columns = [&BODY[..], &[pressure, FORCE, opening]].concat();
                solver.run(valve, valve.balanced(0.0), columns, |time, state| {
                    let force = valve.friction_force(state);
                    let opening = parameters.opening.value(time);
                    vec![state[0], state[1], state[2], state[3], force, opening]
                })
            }
            SceneSetup::BrakedWheel(wheel) => wheel.run(solver),
            SceneSetup::GearedJoint(joint) => joint.run(solver),
            SceneSetup::PlaneBody(body) => {
                let columns = vec![
                    ("x", "position x (m)", 1.0),
                    ("y", "position y (m)", 1.0),
                    ("vx", "velocity v_x (m/s)", 1.0),
                    ("vy", "velocity v_y (m/s)", 1.0),
                    ("force_x", "friction force F_x (N)", 1.0),
                    ("force_y", "friction force F_y (N)", 1.0),
                ];
                solver.run(body, SVector::zeros(), columns, |_, state: &SVector<f64, 6>| {
                    let part = |from| Vector2::new(state[from], state[from + 1]);
                    let force = body.contact().force(&part(2), &part(4));
                    let mut row: Vec<f64> = state.iter().copied().take(4).collect();
                    row.extend(force.iter());
                    row
                })
            }
        }
    }
}

impl SolverSetup {
    /// Refuses a number out of its range, and keys that contradict each other.
    fn check(&self, passive: bool) -> Result<()> {
        let Self { end, samples, method, tolerance, step } = *self;
        if !(end > 0.0 && end.is_finite()) {
            return Err(format!("end is {end}, but must be positive and finite").into());
        }
        if !(2..=10_000_000).contains(&samples) {
            return Err(format!("samples is {samples}, but must lie between 2 and 1e7").into());
        }
        if let Some(step) = step
            && !(step >= 1e-9 * end && step.is_finite())
        {
            let least = 1e-9 * end;
            let rule = format!("must be finite and at least a billionth of end = {least}");
            return Err(format!("step is {step}, but {rule}").into());
        }
        if let Some(tolerance) = tolerance {
            let named = |refused| ParameterError { name: "tolerance", component: None, ..refused };
            Tolerances::scaled(tolerance, SVector::<f64, 1>::repeat(1.0)).map_err(named)?;
        }
        let absent = |key, value: &dyn Display, why| {
            Err(format!("{key} is {value}, but must be absent: {why}").into())
        };
        let chosen = method.unwrap_or_default();
        match (method, tolerance, step) {
            (Some(method), ..) if passive => {
                absent("method", &method, "a braked wheel takes passive steps of length `step`")
            }
            (_, Some(tolerance), _) if passive => {
                absent("tolerance", &tolerance, "a braked wheel takes steps of length `step`")
            }
            _ if passive => Ok(()),
            (_, Some(_), Some(step)) => absent("step", &step, "tolerance chooses the steps"),
            (_, _, Some(step)) if chosen == AnyMethod::Automatic => {
                absent("step", &step, "the method automatic chooses the steps")
            }
            (_, Some(tolerance), _) if chosen == AnyMethod::RungeKutta4 => {
                absent("tolerance", &tolerance, "runge_kutta4 takes steps of length `step`")
            }
            (_, _, None) if chosen == AnyMethod::RungeKutta4 => {
                Err("method is runge_kutta4, but must come with a step".into())
            }
            _ => Ok(()),
        }
    }

    /// Integrates a system, and makes a row of each sample.
    ///
    /// Fixed steps must be stable at the start, at every sample and at every reversal.
    fn run<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: &S,
        start: SVector<f64, N>,
        columns: Vec<Column>,
        row: impl Fn(f64, &SVector<f64, N>) -> Vec<f64>,
    ) -> Result<Table> {
        let method = self.method.unwrap_or_default();
        let solver = match self.step {
            Some(step) => Solver::fixed(method, step)?,
            None => {
                let tolerance = self.tolerance.unwrap_or(1e-6);
                Solver::adaptive(method, Tolerances::scaled(tolerance, system.scales())?)
            }
        };
        let sides = [Branch::Forward, Branch::Backward].map(|side| [side; K]);
        for side in sides {
            self.check_step(system, 0.0, &start, side)?;
        }
        let run = solver.solve(system, 0.0..self.end, start, Output::Uniform(self.samples))?;
        for (time, state) in run.iter() {
            let branches = system.sliding_velocities(time, state).map(Branch::towards);
            self.check_step(system, time, state, branches)?;
        }
        for reversal in run.reversals() {
            for side in sides {
                self.check_step(system, reversal.time, &reversal.state, side)?;
            }
        }
        let rows = run.iter().map(|(time, state)| {
            let mut line = vec![time];
            line.extend(row(time, state));
            line
        });
        Ok(Table { columns, rows: rows.collect() })
    }

    /// Refuses a fixed step in which a small motion about a state would grow although it decays.
    fn check_step<S: System<f64, N, K>, const N: usize, const K: usize>(
        &self,
        system: &S,
        time: f64,
        state: &SVector<f64, N>,
        branches: [Branch; K],
    ) -> Result<()> {
        let method = self.method.unwrap_or_default();
        let (Some(step), Some(scheme)) = (self.step, explicit(method)) else { return Ok(()) };
        let jacobian = match system.linearised(time, state, branches) {
            Some(tangent) => tangent.by_state,
            None => differences(system, time, state, branches),
        };
        match stability::largest_step_of(&jacobian, scheme) {
            Some(limit) if step > limit => {
                let why = format!("{method} is unstable beyond it at t = {time:.6} s");
                Err(format!("step is {step}, but must be at most {limit:.2e}: {why}").into())
            }
            _ => Ok(()),
        }
    }
}

/// The scheme of a method that has a longest stable step.
fn explicit(method: AnyMethod) -> Option<Scheme> {
    match method {
        AnyMethod::DormandPrince => Some(Scheme::DormandPrince),
        AnyMethod::DormandPrince8 => Some(Scheme::DormandPrince8),
        AnyMethod::RungeKutta4 => Some(Scheme::RungeKutta4),
        _ => None,
    }
}

/// The Jacobian of a right-hand side, by central differences.
fn differences<S: System<f64, N, K>, const N: usize, const K: usize>(
    system: &S,
    time: f64,
    state: &SVector<f64, N>,
    branches: [Branch; K],
) -> SMatrix<f64, N, N> {
    let mut jacobian = SMatrix::<f64, N, N>::zeros();
    for (index, scale) in system.scales().iter().enumerate() {
        let little = 6e-6 * scale.max(state[index].abs());
        let rate = |by: f64| {
            let mut moved = *state;
            moved[index] += by;
            system.rate(time, &moved, branches)
        };
        jacobian.set_column(index, &((rate(little) - rate(-little)) / (2.0 * little)));
    }
    jacobian
}

impl Viscoelastic {
    fn run(&self, solver: &SolverSetup) -> Result<Table> {
        /// One call for each number of springs.
        macro_rules! of_length {
            ($list:expr, $make:expr, $($n:literal)*) => {
                match $list.len() {
                    $($n => {
                        let mut list = [$list[0]; $n];
                        list.copy_from_slice(&$list);
                        self.dragged::<$n, _>(solver, $make(list)?)
                    })*
                    many => Err(format!("there must be 1 to 6 springs, not {many}").into()),
                }
            };
        }
        match &self.springs {
            Springs::GeneralisedMaxwell { arms, micro_damping } => of_length!(
                arms,
                |arms| GeneralisedMaxwell::new(GeneralisedMaxwellParameters {
                    arms,
                    micro_damping: *micro_damping
                }),
                1 2 3 4 5 6
            ),
            Springs::GeneralisedKelvinVoigt(elements) => {
                of_length!(elements, GeneralisedKelvinVoigt::new, 1 2 3 4 5 6)
            }
        }
    }

    fn dragged<const N: usize, R: Rheology<f64, Deflection = SVector<f64, N>>>(
        &self,
        solver: &SolverSetup,
        bristle: R,
    ) -> Result<Table> {
        const STRETCHES: [Column; 6] = [
            ("x1", "stretch x_1 (µm)", 1e6),
            ("x2", "stretch x_2 (µm)", 1e6),
            ("x3", "stretch x_3 (µm)", 1e6),
            ("x4", "stretch x_4 (µm)", 1e6),
            ("x5", "stretch x_5 (µm)", 1e6),
            ("x6", "stretch x_6 (µm)", 1e6),
        ];
        let contact = FrBd::new(self.curve.clone(), bristle).under_load(self.normal_force)?;
        let scene = PrescribedVelocity::new(contact, self.velocity.clone());
        let columns = [&[BODY[1]], &STRETCHES[..N], &[FORCE]].concat();
        solver.run(&scene, SVector::zeros(), columns, |time, state| {
            let mut row = vec![scene.velocity(time)];
            row.extend(state.iter());
            row.push(scene.friction_force(time, state));
            row
        })
    }
}

impl Wheel {
    fn run(&self, solver: &SolverSetup) -> Result<Table> {
        match &self.wheel.tyre.pressure {
            AnyPressure::Exponential(pressure) => self.braked(solver, *pressure),
            AnyPressure::Quadratic(pressure) => self.braked(solver, *pressure),
            AnyPressure::Polynomial(pressure) => self.braked(solver, *pressure),
            _ => Err("a braked wheel takes a polynomial pressure, not a measured one".into()),
        }
    }

    fn braked<const N: usize>(
        &self,
        solver: &SolverSetup,
        pressure: PolynomialExponential<f64, N>,
    ) -> Result<Table> {
        let BrakedWheelParameters { tyre, brake, mass, inertia, radius, speed, angular_velocity } =
            self.wheel.clone();
        let patch =
            Patch::new(PatchParameters { model: tyre.model, length: tyre.length, pressure })?
                .carrying(self.tyre_load)?;
        let mut wheel = BrakedWheel::new(BrakedWheelParameters {
            tyre: patch.exact_in(100)?,
            brake,
            mass,
            inertia,
            radius,
            speed,
            angular_velocity,
        })?;
        let columns = vec![
            ("x", "way x (m)", 1.0),
            ("v", "speed v_x (m/s)", 1.0),
            ("omega", "angular velocity ω (rad/s)", 1.0),
            ("force", "force of the tyre (N)", 1.0),
            ("torque", "torque of the brake (N m)", 1.0),
        ];
        let mut table = Table { columns, rows: Vec::new() };
        let step = solver.step.unwrap_or(5e-3);
        let interval = solver.end / (solver.samples - 1) as f64;
        loop {
            let state = wheel.state();
            if state.time >= interval * table.rows.len() as f64 - 0.5 * step {
                let motion = [state.time, state.position, state.speed, state.angular_velocity];
                table.rows.push([&motion[..], &[state.force, state.brake_torque]].concat());
            }
            if !(state.time < solver.end - 0.5 * step) {
                return Ok(table);
            }
            wheel.step(WheelLoads::braking(self.brake_load.value(state.time)), step)?;
        }
    }
}

impl Joint {
    fn run(&self, solver: &SolverSetup) -> Result<Table> {
        match &self.motor {
            Motor::Torque(torque) => self.driven(solver, torque.clone()),
            Motor::Current(motor) => self.driven(solver, CurrentMotor::new(motor.clone())?),
            Motor::Voltage(motor) => self.driven(solver, VoltageMotor::new(motor.clone())?),
            Motor::PositionControl(motor) => self.driven(solver, CurrentMotor::new(motor.clone())?),
        }
    }

    fn driven<A: JointInput<f64>>(&self, solver: &SolverSetup, motor: A) -> Result<Table> {
        let joint = GearedJoint::new(GearedJointParameters {
            gear: GearFriction::new(self.gear.clone())?,
            inertia: self.inertia,
            motor: motor.clone(),
            external: self.gravity,
        })?;
        let columns = vec![
            ("q", "angle q (rad)", 1.0),
            ("v", "angular velocity v (rad/s)", 1.0),
            ("z", "deflection z (mrad)", 1e3),
            ("motor", "motor torque τ_m (N m)", 1.0),
        ];
        solver.run(&joint, joint.at_rest(self.angle), columns, |time, state| {
            let motion = JointMotion { time, angle: state[0], velocity: state[1] };
            vec![state[0], state[1], state[2], motor.at(motion).value]
        })
    }
}
