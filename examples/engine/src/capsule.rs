//! A capsule of 45 g held between two pads: gravity pulls it with 0.44 N through a grip that could
//! hold 17 to 84 N. Users report that it creeps out of the grip in engines that regularise
//! friction.
//!
//! The grip is the scene that they report. A capsule that stands upright on level ground asks
//! nothing of its friction, and one that lies along a slope is the block of
//! [`scene`](crate::scene).
//!
//! Each pad has a bristle of two axes in its own plane, put into rapier as the two motors of a
//! joint (see [`bond`](crate::bond)).

use std::error::Error;

use bristle::curve::{Coulomb, CoulombParameters};
use bristle::nalgebra::Vector2;
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle_plane::{PlaneBristle, PlaneCompanion, PlaneCompanionStep, PlaneFrBd};
use rapier3d_f64::prelude::*;

use crate::bond::Part;

/// Friction coefficient of the pads.
const FRICTION: f64 = 0.7;
/// Mass [kg], radius and half length of the cylinder [m] of the capsule.
const CAPSULE: (f64, f64, f64) = (0.045, 0.004, 0.02);
/// Gravity [m/s²].
const GRAVITY: f64 = 9.81;
/// Time in which the pads close, before anything is measured [s].
const CLOSING: f64 = 0.5;
/// The tangents of a pad, whose normal is x.
const TANGENTS: [JointAxis; 2] = [JointAxis::LinY, JointAxis::LinZ];

/// The friction of the pads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Grip {
    /// rapier's own.
    Rapier,
    /// p μ v/√(‖v‖² + ε²), implicit in its numerator, smeared over ε [m/s].
    Regularised(f64),
    /// FrBD on two axes.
    FrBd,
}

/// A pad, its joint with the capsule, and the bristles between them.
struct Pad {
    part: Part,
    joint: ImpulseJointHandle,
    /// The point of the capsule that it touches, in the capsule's frame.
    foot: Vector,
    bristles: PlaneCompanion<f64, PlaneFrBd<Coulomb<f64>, f64, 2>, 2>,
    deflection: Vector2<f64>,
    step: Option<PlaneCompanionStep<f64, 2>>,
}

/// The components of a vector in the plane of the pads.
fn across(v: Vector) -> Vector2<f64> {
    Vector2::new(v.y, v.z)
}

/// How far the capsule slips through the grip in the first second of gravity [m] and how fast from
/// then on [m/s], over a time [s] at some steps a second, under a normal force [N] and gravity at
/// an angle [rad] to the vertical in the plane of the pads.
pub fn slip(
    grip: Grip,
    (rate, seconds): (f64, f64),
    normal_force: f64,
    angle: f64,
) -> Result<(f64, f64), Box<dyn Error>> {
    let (mass, radius, length) = CAPSULE;
    let gravity = Vector::new(0.0, angle.sin(), -angle.cos()) * GRAVITY;
    let mut world = PhysicsWorld { gravity, ..PhysicsWorld::new() };
    world.integration_parameters.dt = 1.0 / rate;
    // The pads share the load, and the solver has to find out how.
    world.integration_parameters.num_internal_pgs_iterations = 500;
    // rapier's contacts are springs in proportion to the mass; 45 g would give way to the pads.
    world.integration_parameters.contact_softness.natural_frequency = 500.0;
    world.integration_parameters.static_contact_softness.natural_frequency = 500.0;
    let coefficient = if grip == Grip::Rapier { FRICTION } else { 0.0 };
    let volume = std::f64::consts::PI * radius * radius * (2.0 * length + 4.0 / 3.0 * radius);
    let capsule = world.insert(
        // It cannot roll, so that what is measured is slip.
        RigidBodyBuilder::dynamic().locked_axes(LockedAxes::ROTATION_LOCKED).can_sleep(false),
        ColliderBuilder::capsule_y(length, radius).density(mass / volume).friction(coefficient),
    );
    let shape = || ColliderBuilder::cuboid(0.01, 0.03, 0.03).friction(coefficient).mass(0.1);
    let slide = LockedAxes::ROTATION_LOCKED
        | LockedAxes::TRANSLATION_LOCKED_Y
        | LockedAxes::TRANSLATION_LOCKED_Z;
    let (fixed, sliding) = (
        RigidBodyBuilder::fixed(),
        RigidBodyBuilder::dynamic().locked_axes(slide).linear_damping(20.0).can_sleep(false),
    );
    let curve =
        Coulomb::new(CoulombParameters { dynamic_coefficient: FRICTION, viscous_friction: 0.0 })?;
    let bristle =
        KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness: 2e3, micro_damping: 4.0 })?;
    let mut pads = Vec::new();
    for (side, body) in [(-1.0, fixed), (1.0, sliding)] {
        let place = Vector::new(side * (radius + 0.01), 0.0, 0.0);
        let part = world.insert(body.translation(place), shape());
        let foot = Vector::new(side * radius, 0.0, 0.0);
        let mut free = GenericJointBuilder::new(JointAxesMask::empty()).local_anchor2(foot);
        for axis in TANGENTS {
            free = free.motor_model(axis, MotorModel::ForceBased);
        }
        let joint = world.insert_impulse_joint(part.0, capsule.0, free);
        let bristles = PlaneFrBd::isotropic(curve, bristle).under_load(normal_force)?;
        let (bristles, deflection) = (bristles.companion(1.0)?, Vector2::zeros());
        pads.push(Pad { part, joint, foot, bristles, deflection, step: None });
    }
    if let Some(pad) = pads.last() {
        world.bodies[pad.part.0].add_force(Vector::new(-normal_force, 0.0, 0.0), true);
    }
    let place = |world: &PhysicsWorld| across(world.bodies[capsule.0].translation());
    let mut start = place(&world);
    let mut first = start;
    // Gravity waits until the pads have closed.
    world.gravity = Vector::ZERO;
    let closed = (CLOSING * rate) as usize;
    for n in 0..closed + (seconds * rate) as usize {
        if n == closed {
            start = place(&world);
            world.gravity = gravity;
        }
        if n == closed + rate as usize {
            first = place(&world);
        }
        let before: Vec<_> = pads.iter().map(|pad| pad.place(&world, capsule)).collect();
        for pad in &mut pads {
            pad.begin(&mut world, capsule, grip)?;
        }
        world.step();
        for (pad, before) in pads.iter_mut().zip(before) {
            let moved = (pad.place(&world, capsule) - before) * rate;
            if let Some(step) = pad.step.take() {
                pad.deflection = step.commit(&moved).deflection;
            }
        }
    }
    Ok(((first - start).norm(), (place(&world) - first).norm() / (seconds - 1.0)))
}

impl Pad {
    /// Where the capsule's foot is in the plane of the pad [m].
    fn place(&self, world: &PhysicsWorld, capsule: Part) -> Vector2<f64> {
        let foot = *world.bodies[capsule.0].position() * self.foot;
        across(foot - world.bodies[self.part.0].translation())
    }

    /// Sets the motors for the coming step.
    fn begin(
        &mut self,
        world: &mut PhysicsWorld,
        capsule: Part,
        grip: Grip,
    ) -> Result<(), Box<dyn Error>> {
        let h = world.integration_parameters.dt;
        let pair = world.contact_pair(self.part.1, capsule.1);
        let normal_force = pair.map_or(0.0, |pair| pair.total_impulse_magnitude()) / h;
        let body = &world.bodies[capsule.0];
        let velocity = across(body.velocity_at_point(*body.position() * self.foot));
        // Damping and target velocity of each motor.
        let motors = match grip {
            Grip::Rapier => [None; 2],
            Grip::Regularised(epsilon) => {
                let damping = normal_force * FRICTION / velocity.norm().hypot(epsilon);
                [(damping > 0.0).then_some((damping, 0.0)); 2]
            }
            Grip::FrBd => {
                let reloaded = self.bristles.reload(normal_force, &velocity, &self.deflection)?;
                let step = self.bristles.step(&velocity, &reloaded.deflection, h);
                self.step = Some(step);
                step.axes().map(|axis| Some((axis.damping(), axis.target_velocity()?)))
            }
        };
        if let Some(joint) = world.impulse_joints.get_mut(self.joint, true) {
            for (axis, motor) in TANGENTS.into_iter().zip(motors) {
                // A motor without stiffness and damping is rigid in rapier, not absent.
                let (damping, target) = motor.unwrap_or((1.0, 0.0));
                joint.data.set_motor(axis, 0.0, target, 0.0, damping);
                joint.data.set_motor_max_force(axis, motor.map_or(0.0, |_| f64::MAX));
            }
        }
        Ok(())
    }
}
