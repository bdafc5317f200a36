//! The scenes of a file that are more than a value of the library.

use bristle::curve::AnyCurve;
use bristle::nalgebra::{SVector, Vector2, Vector3};
use bristle::ode::System;
use bristle::rheology::{
    GeneralisedKelvinVoigt, GeneralisedMaxwell, GeneralisedMaxwellParameters, Rheology,
};
use bristle::scene::PrescribedVelocity;
use bristle::signal::Signal;
use bristle::{AnyBristle, Bristle, FrBd, Mechanism, ParameterError};
use bristle_joint::{GearFriction, TorqueLoad};
use bristle_joint::{GearedJoint, GearedJointParameters, JointInput, JointMotion};
use bristle_plane::{Footprint, PlaneBristle};
use bristle_plane::{PlaneBody, PlaneBodyParameters};
use bristle_rolling::{AnyPressure, Grid, Motion, Patch, PatchParameters, PolynomialExponential};
use bristle_rolling::{BrakedWheel, BrakedWheelParameters, Tyre, WheelLoads};
use serde::{Deserialize, Serialize};

use crate::choices::{
    FileSignal, Frbd, Input, Lugre, Motor, PlaneModel, Points, Pressed, Springs, array,
    of_the_model,
};
use crate::setup::{BODY, Column, FORCE, Result, SolverSetup, Table};

/// Segments of a tyre, and the steps in which a bristle crosses its patch.
const SEGMENTS: usize = 100;
/// Most cells of a patch.
const MOST_CELLS: usize = 10_000;

/// FrBD with a bristle of one to six springs, dragged at a given velocity.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Viscoelastic {
    /// The friction curve.
    pub curve: AnyCurve<f64>,
    /// The springs.
    pub springs: Springs,
    /// Normal force [N].
    pub normal_force: f64,
    /// Sliding velocity v(t) [m/s].
    pub velocity: FileSignal,
}

impl Viscoelastic {
    pub fn run(&self, solver: &SolverSetup) -> Result<Table> {
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
            Springs::Zener(zener) => self.dragged(solver, GeneralisedMaxwell::zener(*zener)?),
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
        solver.admit(self.velocity.longest_step())?;
        let columns = [&[BODY[1]], &STRETCHES[..N], &[FORCE]].concat();
        solver.run(&scene, SVector::zeros(), columns, |time, state| {
            let mut row = vec![scene.velocity(time)];
            row.extend(state.iter());
            row.push(scene.friction_force(time, state));
            row
        })
    }
}

/// A tyre in a file: the model of its bristles, its length and its pressure.
pub type TyreSetup<M> = PatchParameters<f64, M, AnyPressure<f64>>;

/// A braked wheel with its load, its brake and its steering.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wheel<M> {
    /// Wheel, tyre and brake.
    pub wheel: BrakedWheelParameters<f64, TyreSetup<M>, AnyBristle<f64>>,
    /// Normal force of the tyre [N].
    pub tyre_load: f64,
    /// Normal force of the brake over time: its capacity over μ.
    pub brake_load: FileSignal,
    /// Lateral velocity of the wheel [m/s]; zero if it is absent, and on a tyre of one axis.
    pub lateral_velocity: Option<FileSignal>,
}

/// Calls a function of the pressure of a tyre.
macro_rules! of_the_polynomial {
    ($pressure:expr, $name:ident => $answer:expr) => {
        match $pressure {
            AnyPressure::Exponential($name) => $answer,
            AnyPressure::Quadratic($name) => $answer,
            AnyPressure::Polynomial($name) => $answer,
            _ => Err("a braked wheel takes a polynomial pressure, not a measured one".into()),
        }
    };
}

impl Wheel<AnyBristle<f64>> {
    pub fn run(&self, solver: &SolverSetup) -> Result<Table> {
        let tyre = &self.wheel.tyre;
        of_the_polynomial!(&tyre.pressure, pressure => {
            let tyre = self.patch(tyre.model.clone(), *pressure)?.exact_in(SEGMENTS)?;
            self.braked(solver, tyre, 5)
        })
    }
}

impl Wheel<PlaneModel<2>> {
    pub fn run_steered(&self, solver: &SolverSetup) -> Result<Table> {
        let tyre = &self.wheel.tyre;
        of_the_polynomial!(&tyre.pressure, pressure => of_the_model!(&tyre.model, model => {
            let tyre = self.patch(model.clone(), *pressure)?.combined_in::<2>(SEGMENTS)?;
            self.braked(solver, tyre, COLUMNS.len())
        }))
    }
}

/// The columns of a wheel; the last are those of a steered one.
const COLUMNS: [Column; 7] = [
    ("x", "way x (m)", 1.0),
    ("v", "speed v_x (m/s)", 1.0),
    ("omega", "angular velocity ω (rad/s)", 1.0),
    ("force", "force of the tyre (N)", 1.0),
    ("torque", "torque of the brake (N m)", 1.0),
    ("force_y", "lateral force of the tyre (N)", 1.0),
    ("moment", "self-aligning moment (N m)", 1.0),
];

impl<M: Clone> Wheel<M> {
    fn patch<B, const N: usize>(
        &self,
        model: B,
        pressure: PolynomialExponential<f64, N>,
    ) -> Result<Patch<f64, B, PolynomialExponential<f64, N>>> {
        let length = self.wheel.tyre.length;
        let named = |refused| ParameterError { name: "tyre_load", ..refused };
        let patch = Patch::new(PatchParameters { model, length, pressure })?;
        Ok(patch.carrying(self.tyre_load).map_err(named)?)
    }

    fn braked<P: Tyre<f64>>(&self, solver: &SolverSetup, tyre: P, columns: usize) -> Result<Table> {
        let BrakedWheelParameters { brake, mass, inertia, radius, speed, angular_velocity, .. } =
            self.wheel.clone();
        let mut wheel = BrakedWheel::new(BrakedWheelParameters {
            tyre,
            brake,
            mass,
            inertia,
            radius,
            speed,
            angular_velocity,
        })?;
        let lateral = self.lateral_velocity.clone().unwrap_or_else(FileSignal::none);
        solver.admit(self.brake_load.longest_step())?;
        solver.admit(lateral.longest_step())?;
        solver.stepped(5e-3, SEGMENTS, COLUMNS[..columns].to_vec(), |time, step| {
            let middle = time + 0.5 * step;
            let braking = WheelLoads::braking(self.brake_load.value(middle));
            let lateral_velocity = lateral.value(middle);
            let state = wheel.step(WheelLoads { lateral_velocity, ..braking }, step)?;
            let mut row = vec![state.position, state.speed, state.angular_velocity];
            row.extend([state.force, state.brake_torque, state.lateral_force]);
            row.push(wheel.aligning_moment(lateral_velocity));
            row.truncate(columns);
            Ok(row)
        })
    }
}

/// A patch of bristles at a given slip velocity and rolling speed, on a grid.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RollingPatch {
    /// Bristles, length and pressure.
    pub patch: TyreSetup<AnyBristle<f64>>,
    /// Normal force [N].
    pub normal_force: f64,
    /// Cells of the grid.
    pub cells: usize,
    /// Slip velocity v(t) [m/s].
    pub slip_velocity: FileSignal,
    /// Rolling speed U(t) [m/s].
    pub rolling_speed: FileSignal,
}

impl RollingPatch {
    pub fn run(&self, solver: &SolverSetup) -> Result<Table> {
        let Self { cells, slip_velocity, rolling_speed, .. } = self;
        if !(1..=MOST_CELLS).contains(cells) {
            return Err(format!("cells is {cells}, but must lie between 1 and 1e4").into());
        }
        let patch = Patch::new(self.patch.clone())?.carrying(self.normal_force)?;
        let mut grid = Grid::new(&patch, *cells)?;
        solver.admit(slip_velocity.longest_step())?;
        solver.admit(rolling_speed.longest_step())?;
        let columns = vec![
            ("v", "slip velocity v (m/s)", 1.0),
            ("u", "rolling speed U (m/s)", 1.0),
            FORCE,
            ("stored", "stored energy W (J)", 1.0),
        ];
        solver.stepped(f64::INFINITY, *cells, columns, |time, step| {
            let middle = time + 0.5 * step;
            let motion = Motion {
                slip_velocity: slip_velocity.value(middle),
                rolling_speed: rolling_speed.value(middle),
            };
            let _ = grid.step(motion, step)?;
            let now = [slip_velocity, rolling_speed].map(|signal| signal.value(time + step));
            Ok(vec![now[0], now[1], grid.force(now[0]), grid.stored_energy()])
        })
    }
}

/// A joint driven by a motor through a gear.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Joint {
    /// Friction of the gear, its load law and its drag.
    pub gear: GearFriction<f64, AnyBristle<f64>, TorqueLoad<f64>>,
    /// Moment of inertia at the joint [kg m²].
    pub inertia: f64,
    /// The motor.
    pub motor: Motor,
    /// External torque [N m].
    pub external: Input,
    /// Angle at the beginning [rad].
    pub angle: f64,
}

impl Joint {
    pub fn run(&self, solver: &SolverSetup) -> Result<Table> {
        let Self { gear, inertia, motor, external, angle } = self.clone();
        if !angle.is_finite() {
            return Err(format!("angle is {angle}, but must be finite").into());
        }
        solver.admit(motor.longest_step())?;
        solver.admit(external.longest_step())?;
        let parameters = GearedJointParameters { gear, inertia, motor, external };
        let joint = GearedJoint::new(parameters)?;
        let columns = vec![
            ("q", "angle q (rad)", 1.0),
            ("v", "angular velocity v (rad/s)", 1.0),
            ("z", "deflection z (mrad)", 1e3),
            ("motor", "motor torque τ_m (N m)", 1.0),
            ("friction", "friction torque T (N m)", 1.0),
        ];
        solver.run(&joint, joint.at_rest(angle), columns, |time, state| {
            let motion = JointMotion { time, angle: state[0], velocity: state[1] };
            let friction = joint.friction_torque(time, state);
            vec![state[0], state[1], state[2], self.motor.at(motion).value, friction]
        })
    }
}

/// A body of N axes, on springs whose far ends move.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneBlock<const N: usize> {
    /// Friction under its normal force.
    pub contact: Pressed<N>,
    /// Mass, spring and damper of each axis.
    #[serde(with = "array")]
    pub mechanisms: [Mechanism<f64>; N],
    /// Place of each spring's far end [m].
    #[serde(with = "array")]
    pub anchor: [FileSignal; N],
    /// Force along each axis [N].
    #[serde(with = "array")]
    pub force: [FileSignal; N],
}

/// A body on axes with a model M.
type Body<M, const N: usize> = PlaneBody<f64, M, N, FileSignal, FileSignal>;

/// The columns of a body on three axes.
const AXES: [[Column; 3]; 3] = [
    [
        ("x", "position x (m)", 1.0),
        ("y", "position y (m)", 1.0),
        ("s", "rotation times radius (m)", 1.0),
    ],
    [
        ("vx", "velocity v_x (m/s)", 1.0),
        ("vy", "velocity v_y (m/s)", 1.0),
        ("vs", "spin times radius (m/s)", 1.0),
    ],
    [
        ("force_x", "friction force F_x (N)", 1.0),
        ("force_y", "friction force F_y (N)", 1.0),
        ("force_s", "friction torque over radius (N)", 1.0),
    ],
];

impl<const N: usize> PlaneBlock<N> {
    /// The run, with three states for each axis.
    pub fn run<const S: usize>(&self, solver: &SolverSetup) -> Result<Table>
    where
        Body<Frbd<N>, N>: System<f64, S, 0>,
        Body<Lugre<N>, N>: System<f64, S, 0>,
    {
        for signal in self.anchor.iter().chain(&self.force) {
            solver.admit(signal.longest_step())?;
        }
        of_the_model!(&self.contact.model, model => self.slides(solver, model.clone()))
    }

    fn slides<M: PlaneBristle<f64, N>, const S: usize>(
        &self,
        solver: &SolverSetup,
        model: M,
    ) -> Result<Table>
    where
        Body<M, N>: System<f64, S, 0>,
    {
        let Self { contact, mechanisms, anchor, force } = self.clone();
        let contact = model.under_load(contact.normal_force)?;
        let body = PlaneBody::new(PlaneBodyParameters { contact, mechanisms, anchor, force })?;
        let columns = AXES.iter().flat_map(|columns| columns.iter().take(N).copied()).collect();
        solver.run(&body, SVector::zeros(), columns, |_, state: &SVector<f64, S>| {
            let part = |from: usize| SVector::<f64, N>::from_fn(|axis, _| state[from + axis]);
            let force = body.contact().force(&part(N), &part(2 * N));
            state.iter().take(2 * N).chain(force.iter()).copied().collect()
        })
    }
}

/// A contact surface of points at a given twist.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Surface {
    /// Friction under the whole normal force.
    pub contact: Pressed<2>,
    /// The points.
    pub points: Points,
    /// The twist: velocity at the origin [m/s] and spin [rad/s], (v_x, v_y, ω) over time.
    pub twist: [FileSignal; 3],
}

impl Surface {
    pub fn run(&self, solver: &SolverSetup) -> Result<Table> {
        for signal in &self.twist {
            solver.admit(signal.longest_step())?;
        }
        of_the_model!(&self.contact.model, model => self.dragged(solver, model.clone()))
    }

    fn dragged<M: PlaneBristle<f64, 2>>(&self, solver: &SolverSetup, model: M) -> Result<Table> {
        let contact = model.under_load(self.contact.normal_force)?;
        let surface = Footprint::new(contact, self.points.points()?)?;
        let mut deflections = vec![Vector2::zeros(); surface.points().len()];
        let columns = vec![
            ("vx", "velocity v_x (m/s)", 1.0),
            ("vy", "velocity v_y (m/s)", 1.0),
            ("omega", "spin ω (rad/s)", 1.0),
            ("force_x", "friction force F_x (N)", 1.0),
            ("force_y", "friction force F_y (N)", 1.0),
            ("torque", "friction torque M (N m)", 1.0),
        ];
        solver.stepped(f64::INFINITY, deflections.len(), columns, |time, step| {
            let twist = |time| Vector3::from_fn(|axis, _| self.twist[axis].value(time));
            let _ = surface.hold(&twist(time + 0.5 * step), &mut deflections, step)?;
            let now = twist(time + step);
            let wrench = surface.wrench(&now, &deflections);
            Ok(now.iter().chain(wrench.iter()).copied().collect())
        })
    }
}
