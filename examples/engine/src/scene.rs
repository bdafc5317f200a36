//! The scenes: a block of 1 kg on a slope, on a plane that tilts, and on a belt.

use std::error::Error;

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, ElastoPlastic, FrBd};
use rapier3d_f64::prelude::*;

use crate::bond::{Bond, Coupling, Part};
use crate::law::{Bristles, Frictionless, Law, Regularised};

/// Gravity [m/s²].
pub const GRAVITY: f64 = 9.81;

/// Mass of the block [kg].
pub const MASS: f64 = 1.0;

/// Half extents of the block [m].
const HALF: Vector = Vector::new(0.1, 0.05, 0.1);

/// Thickness of the ground, halved [m].
const GROUND: f64 = 0.5;

/// The friction curve: 0.6 at rest, 0.45 sliding.
pub const CURVE: StribeckParameters<f64> = StribeckParameters {
    static_coefficient: 0.6,
    dynamic_coefficient: 0.45,
    stribeck_velocity: 0.1,
    stribeck_exponent: 2.0,
    viscous_friction: 0.0,
};

/// Bristles that bend by 0.2 mm before they break away.
pub const BRISTLE: KelvinVoigtParameters<f64> =
    KelvinVoigtParameters { micro_stiffness: 3e3, micro_damping: 20.0 };

/// The belt [m/s], and the spring that holds the block on it [N/m].
pub const BELT: f64 = 0.1;
/// The spring that holds the block on the belt [N/m].
pub const SPRING: f64 = 50.0;

/// Sweeps of rapier's solver in each substep, by default one.
const SWEEPS: usize = 8;

/// No velocity of these scenes is higher [m/s].
const FASTEST: f64 = 20.0;

/// A friction in the engine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Friction {
    /// rapier's own, with the static coefficient; it knows one only.
    Rapier,
    /// The curve with its jump smeared over ε [m/s], evaluated at the beginning of the step.
    Explicit(f64),
    /// The same, with the velocity in the numerator at the end of the step.
    Implicit(f64),
    /// FrBD.
    FrBd(Coupling),
    /// Elasto-plastic FrBD.
    ElastoPlastic(Coupling),
}

impl Friction {
    /// How it gets into the engine.
    fn coupling(self) -> Coupling {
        match self {
            Friction::FrBd(coupling) | Friction::ElastoPlastic(coupling) => coupling,
            Friction::Explicit(_) | Friction::Implicit(_) => Coupling::Force,
            Friction::Rapier => Coupling::Motor,
        }
    }

    /// rapier's coefficient.
    fn coefficient(self) -> f64 {
        if self == Friction::Rapier { CURVE.static_coefficient } else { 0.0 }
    }

    /// The coefficient of fast sliding.
    pub fn sliding_coefficient(self) -> f64 {
        if self == Friction::Rapier { CURVE.static_coefficient } else { CURVE.dynamic_coefficient }
    }

    fn law(self) -> Result<Box<dyn Law>, Box<dyn Error>> {
        let curve = Stribeck::new(CURVE)?;
        Ok(match self {
            Friction::Rapier => Box::new(Frictionless::default()),
            Friction::Explicit(epsilon) => Box::new(Regularised::new(curve, epsilon, false)),
            Friction::Implicit(epsilon) => Box::new(Regularised::new(curve, epsilon, true)),
            Friction::FrBd(_) => Box::new(Bristles::new(frbd()?, MASS * GRAVITY, FASTEST)?),
            Friction::ElastoPlastic(_) => {
                Box::new(Bristles::new(elasto_plastic()?, MASS * GRAVITY, FASTEST)?)
            }
        })
    }
}

/// The FrBD model of all scenes.
pub fn frbd() -> Result<impl Bristle<f64, Deflection = f64>, Box<dyn Error>> {
    Ok(FrBd::new(Stribeck::new(CURVE)?, KelvinVoigt::new(BRISTLE)?))
}

/// The elasto-plastic model of all scenes: elastic up to nine tenths of the least deflection of
/// sliding.
pub fn elasto_plastic() -> Result<impl Bristle<f64, Deflection = f64>, Box<dyn Error>> {
    Ok(ElastoPlastic::new(
        Stribeck::new(CURVE)?,
        KelvinVoigt::new(BRISTLE)?,
        0.9 * CURVE.dynamic_coefficient / BRISTLE.micro_stiffness,
    )?)
}

/// A block on a ground.
pub struct Scene {
    /// The engine.
    pub world: PhysicsWorld,
    /// The friction under the block.
    pub bond: Bond,
    ground: Part,
    block: Part,
    /// On the block [N/m].
    spring: f64,
}

impl Scene {
    /// At rest on a slope [rad] that falls towards +x.
    pub fn slope(friction: Friction, rate: f64, angle: f64) -> Result<Self, Box<dyn Error>> {
        Self::new(friction, rate, RigidBodyBuilder::fixed(), angle, 0.0)
    }

    /// At rest on a plane that has a slope [rad] and tilts further [rad/s] about the block's foot.
    pub fn tilting(
        friction: Friction,
        rate: f64,
        angle: f64,
        turning: f64,
    ) -> Result<Self, Box<dyn Error>> {
        let ground =
            RigidBodyBuilder::kinematic_velocity_based().angvel(Vector::new(0.0, 0.0, -turning));
        let mut scene = Self::new(friction, rate, ground, angle, 0.0)?;
        // Or rapier keeps the contact's normal until the plane has turned by 11°, and with it the
        // friction's limit.
        scene.world.integration_parameters.contact_recycling = false;
        Ok(scene)
    }

    /// On a belt that moves towards +x, held by a spring; at first both stand as the belt does.
    pub fn belt(friction: Friction, rate: f64) -> Result<Self, Box<dyn Error>> {
        let ground =
            RigidBodyBuilder::kinematic_velocity_based().linvel(Vector::new(BELT, 0.0, 0.0));
        let mut scene = Self::new(friction, rate, ground, 0.0, SPRING)?;
        scene.world.bodies[scene.block.0].set_linvel(Vector::new(BELT, 0.0, 0.0), true);
        Ok(scene)
    }

    fn new(
        friction: Friction,
        rate: f64,
        ground: RigidBodyBuilder,
        angle: f64,
        spring: f64,
    ) -> Result<Self, Box<dyn Error>> {
        let mut world =
            PhysicsWorld { gravity: Vector::new(0.0, -GRAVITY, 0.0), ..PhysicsWorld::new() };
        world.integration_parameters.dt = 1.0 / rate;
        // The block must not turn under the friction at its foot: friction and contact are solved
        // in turns.
        world.integration_parameters.num_internal_pgs_iterations = SWEEPS;
        let turn = Vector::new(0.0, 0.0, -angle);
        // The body's origin is the place of the foot; the collider hangs below.
        let ground = world.insert(
            ground.rotation(turn),
            ColliderBuilder::cuboid(200.0, GROUND, 2.0)
                .translation(Vector::new(0.0, -GROUND, 0.0))
                .friction(friction.coefficient()),
        );
        let up = *world.bodies[ground.0].rotation() * Vector::new(0.0, HALF.y, 0.0);
        let volume = 8.0 * HALF.x * HALF.y * HALF.z;
        let block = world.insert(
            RigidBodyBuilder::dynamic().translation(up).rotation(turn).can_sleep(false),
            ColliderBuilder::cuboid(HALF.x, HALF.y, HALF.z)
                .density(MASS / volume)
                .friction(friction.coefficient()),
        );
        let foot = Vector::new(0.0, -HALF.y, 0.0);
        if spring > 0.0 {
            let wall = world.insert_body(RigidBodyBuilder::fixed());
            let mut joint = GenericJointBuilder::new(JointAxesMask::empty())
                .local_anchor2(foot)
                .motor_model(JointAxis::LinX, MotorModel::ForceBased)
                .build();
            joint.set_motor(JointAxis::LinX, 0.0, 0.0, spring, 0.0);
            world.insert_impulse_joint(wall, block.0, joint);
        }
        let laws = [friction.law()?, friction.law()?];
        let bond = Bond::new(&mut world, friction.coupling(), ground, block, foot, laws);
        Ok(Self { world, bond, ground, block, spring })
    }

    /// One step.
    pub fn step(&mut self) -> Result<(), Box<dyn Error>> {
        let pull = Vector::new(-self.spring * self.block_x(), 0.0, 0.0);
        let others = self.world.gravity * MASS + pull;
        Ok(self.bond.step(&mut self.world, others)?)
    }

    /// The block gets a velocity along the ground [m/s].
    pub fn launch(&mut self, velocity: f64) {
        let along = *self.world.bodies[self.ground.0].rotation() * Vector::X;
        self.world.bodies[self.block.0].set_linvel(along * velocity, true);
    }

    /// Where the block is, in the world's x direction [m].
    pub fn block_x(&self) -> f64 {
        self.world.bodies[self.block.0].translation().x
    }

    /// Along the slope [m].
    pub fn place(&self) -> f64 {
        self.bond.place(&self.world).x
    }

    /// Down the slope [m/s].
    pub fn velocity(&self) -> f64 {
        self.bond.sliding_velocity(&self.world).x
    }

    /// Kinetic and potential energy of the block, without the bristles' [J].
    pub fn mechanical_energy(&self) -> f64 {
        let block = &self.world.bodies[self.block.0];
        let x = self.block_x();
        block.kinetic_energy() - MASS * self.world.gravity.dot(block.translation())
            + 0.5 * self.spring * x * x
    }

    /// The angle of the ground [rad].
    pub fn angle(&self) -> f64 {
        let along = *self.world.bodies[self.ground.0].rotation() * Vector::X;
        (-along.y).atan2(along.x)
    }
}
