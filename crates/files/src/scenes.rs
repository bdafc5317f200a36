//! The scenes of a file that are more than a value of the library.

use bristle::curve::AnyCurve;
use bristle::nalgebra::{SVector, Vector2, Vector3};
use bristle::rheology::{GeneralisedMaxwell, GeneralisedMaxwellParameters as Parallel};
use bristle::scene::PrescribedVelocity;
use bristle::serialisation::array;
use bristle::signal::{AnySignal, Signal};
use bristle::{AnyBristle, Bristle, FrBd, Mechanism, ParameterError};
use bristle_joint::{
    GearFriction, GearedJoint, GearedJointParameters, JointInput, JointMotion, TorqueLoad,
};
use bristle_plane::{Footprint, PlaneBody, PlaneBodyParameters, PlaneBristle};
use bristle_rolling::{AnyPressure, Grid, Motion, Patch, PatchParameters, PolynomialExponential};
use bristle_rolling::{BrakedWheel, BrakedWheelParameters, Tyre, WheelLoads};
use serde::{Deserialize, Serialize};

use crate::choices::of_the_model;
use crate::choices::{Input, Motor, PlaneModel, Points, Pressed, Springs};
use crate::setup::{BODY, Column, FORCE, Result, SolverSetup, Table, must};

/// Segments of a tyre, and the steps in which a bristle crosses its patch.
const SEGMENTS: usize = 100;
/// Most cells of a patch.
const MOST_CELLS: usize = 10_000;

/// FrBD with a bristle of one to six springs, dragged at a given velocity [m/s] under a normal
/// force [N].
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Viscoelastic {
    curve: AnyCurve<f64>,
    springs: Springs,
    normal_force: f64,
    velocity: AnySignal<f64>,
}

impl Viscoelastic {
    pub(crate) fn run(&self, solver: &SolverSetup) -> Result<Table> {
        /// One call for each number of springs.
        macro_rules! of_length {
            ($arms:expr, $micro_damping:expr, $($n:literal)*) => {
                match $arms.len() {
                    $($n => {
                        let mut arms = [$arms[0]; $n];
                        arms.copy_from_slice($arms);
                        let parameters = Parallel { arms, micro_damping: $micro_damping };
                        self.dragged::<$n>(solver, GeneralisedMaxwell::new(parameters)?)
                    })*
                    many => Err(format!("there must be 1 to 6 springs, not {many}").into()),
                }
            };
        }
        match &self.springs {
            Springs::Zener(zener) => self.dragged(solver, GeneralisedMaxwell::zener(*zener)?),
            Springs::GeneralisedMaxwell { arms, micro_damping } => {
                of_length!(arms, *micro_damping, 1 2 3 4 5 6)
            }
        }
    }

    fn dragged<const N: usize>(
        &self,
        solver: &SolverSetup,
        bristle: GeneralisedMaxwell<f64, N>,
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
            let (velocity, force) = (scene.velocity(time), scene.friction_force(time, state));
            [&[velocity], state.as_slice(), &[force]].concat()
        })
    }
}

/// A tyre in a file: the model of its bristles, its length and its pressure.
type TyreSetup<M> = PatchParameters<f64, M, AnyPressure<f64>>;

/// A braked wheel under the load of its tyre [N].
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Wheel<M> {
    wheel: BrakedWheelParameters<f64, TyreSetup<M>, AnyBristle<f64>>,
    tyre_load: f64,
    /// Normal force of the brake over time: its capacity over μ.
    brake_load: AnySignal<f64>,
    /// Lateral velocity of the wheel [m/s]; zero if it is absent, and on a tyre of one axis.
    lateral_velocity: Option<AnySignal<f64>>,
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
    pub(crate) fn run(&self, solver: &SolverSetup) -> Result<Table> {
        let tyre = &self.wheel.tyre;
        of_the_polynomial!(&tyre.pressure, pressure => {
            let tyre = self.patch(tyre.model.clone(), *pressure)?.exact_in(SEGMENTS)?;
            self.braked(solver, tyre, 5)
        })
    }
}

impl Wheel<PlaneModel<2>> {
    pub(crate) fn run_steered(&self, solver: &SolverSetup) -> Result<Table> {
        let tyre = &self.wheel.tyre;
        of_the_polynomial!(&tyre.pressure, pressure => of_the_model!(&tyre.model, model => {
            let tyre = self.patch(model.clone(), *pressure)?.exact_in(SEGMENTS)?;
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
        Ok(patch.under_load(self.tyre_load).map_err(named)?)
    }

    fn braked<P: Tyre<f64>>(&self, solver: &SolverSetup, tyre: P, columns: usize) -> Result<Table> {
        let BrakedWheelParameters { brake, mass, inertia, radius, speed, angular_velocity, .. } =
            self.wheel.clone();
        let parameters =
            BrakedWheelParameters { tyre, brake, mass, inertia, radius, speed, angular_velocity };
        let mut wheel = BrakedWheel::new(parameters)?;
        solver.stepped(5e-3, SEGMENTS, COLUMNS[..columns].to_vec(), |time, step| {
            let middle = time + 0.5 * step;
            let braking = WheelLoads::braking(self.brake_load.value(middle));
            let lateral = self.lateral_velocity.as_ref();
            let lateral_velocity = lateral.map_or(0.0, |lateral| lateral.value(middle));
            let state = wheel.step(WheelLoads { lateral_velocity, ..braking }, step)?;
            let mut row = vec![state.position, state.speed, state.angular_velocity];
            row.extend([state.force, state.brake_torque, state.lateral_force]);
            row.push(wheel.aligning_moment(lateral_velocity));
            row.truncate(columns);
            Ok(row)
        })
    }
}

/// A patch of bristles on a grid, under a normal force [N], at a given slip velocity and rolling
/// speed [m/s].
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RollingPatch {
    patch: TyreSetup<AnyBristle<f64>>,
    normal_force: f64,
    cells: usize,
    slip_velocity: AnySignal<f64>,
    rolling_speed: AnySignal<f64>,
}

impl RollingPatch {
    pub(crate) fn run(&self, solver: &SolverSetup) -> Result<Table> {
        let cells = self.cells;
        if !(1..=MOST_CELLS).contains(&cells) {
            return must("cells", cells, "lie between 1 and 1e4");
        }
        let patch = Patch::new(self.patch.clone())?.under_load(self.normal_force)?;
        let mut grid = Grid::new(&patch, cells)?;
        let columns = vec![
            ("v", "slip velocity v (m/s)", 1.0),
            ("u", "rolling speed U (m/s)", 1.0),
            FORCE,
            ("stored", "stored energy W (J)", 1.0),
        ];
        let motion = |time| Motion {
            slip_velocity: self.slip_velocity.value(time),
            rolling_speed: self.rolling_speed.value(time),
        };
        solver.stepped(f64::INFINITY, cells, columns, |time, step| {
            let _ = grid.step(motion(time + 0.5 * step), step)?;
            let Motion { slip_velocity, rolling_speed } = motion(time + step);
            let force = grid.force(|_| slip_velocity);
            Ok(vec![slip_velocity, rolling_speed, force, grid.stored_energy()])
        })
    }
}

/// A joint driven by a motor through a gear: its moment of inertia [kg m²], an external torque
/// [N m], its angle at the beginning [rad].
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Joint {
    gear: GearFriction<f64, AnyBristle<f64>, TorqueLoad<f64>>,
    inertia: f64,
    motor: Motor,
    external: Input,
    angle: f64,
}

impl Joint {
    pub(crate) fn run(&self, solver: &SolverSetup) -> Result<Table> {
        let Self { gear, inertia, motor, external, angle } = self.clone();
        if !angle.is_finite() {
            return must("angle", angle, "be finite");
        }
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
            let torques = [self.motor.at(motion).value, joint.friction_torque(time, state)];
            [state.as_slice(), &torques].concat()
        })
    }
}

/// A body of N axes on springs whose far ends move [m], with a force along each axis [N].
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlaneBlock<const N: usize> {
    contact: Pressed<N>,
    #[serde(with = "array")]
    mechanisms: [Mechanism<f64>; N],
    #[serde(with = "array")]
    anchor: [AnySignal<f64>; N],
    #[serde(with = "array")]
    force: [AnySignal<f64>; N],
}

/// The columns of a body on three axes.
const AXES: [Column; 9] = [
    ("x", "position x (m)", 1.0),
    ("y", "position y (m)", 1.0),
    ("s", "rotation times radius (m)", 1.0),
    ("vx", "velocity v_x (m/s)", 1.0),
    ("vy", "velocity v_y (m/s)", 1.0),
    ("vs", "spin times radius (m/s)", 1.0),
    ("force_x", "friction force F_x (N)", 1.0),
    ("force_y", "friction force F_y (N)", 1.0),
    ("force_s", "friction torque over radius (N)", 1.0),
];

impl<const N: usize> PlaneBlock<N> {
    /// The run, with three states for each axis.
    pub(crate) fn run<const S: usize>(&self, solver: &SolverSetup) -> Result<Table> {
        of_the_model!(&self.contact.model, model => self.slides::<_, S>(solver, model.clone()))
    }

    fn slides<M: PlaneBristle<f64, N>, const S: usize>(
        &self,
        solver: &SolverSetup,
        model: M,
    ) -> Result<Table> {
        let Self { contact, mechanisms, anchor, force } = self.clone();
        let contact = model.under_load(contact.normal_force)?;
        let body = PlaneBody::new(PlaneBodyParameters { contact, mechanisms, anchor, force })?;
        let columns = AXES.chunks(3).flat_map(|columns| columns[..N].to_vec()).collect();
        solver.run(&body, SVector::zeros(), columns, |_, state: &SVector<f64, S>| {
            let part = |from: usize| SVector::<f64, N>::from_fn(|axis, _| state[from + axis]);
            let force = body.contact().force(&part(N), &part(2 * N));
            [&state.as_slice()[..2 * N], force.as_slice()].concat()
        })
    }
}

/// A contact surface of points at a given twist: velocity at the origin [m/s] and spin [rad/s],
/// (v_x, v_y, ω) over time.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Surface {
    contact: Pressed<2>,
    points: Points,
    twist: [AnySignal<f64>; 3],
}

impl Surface {
    pub(crate) fn run(&self, solver: &SolverSetup) -> Result<Table> {
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
        let twist = |time| Vector3::from_fn(|axis, _| self.twist[axis].value(time));
        solver.stepped(f64::INFINITY, deflections.len(), columns, |time, step| {
            let _ = surface.hold(&twist(time + 0.5 * step), &mut deflections, step)?;
            let now = twist(time + step);
            let wrench = surface.wrench(&now, &deflections);
            Ok([now.as_slice(), wrench.as_slice()].concat())
        })
    }
}
