//! How the friction of a pair of bodies gets into rapier.
//!
//! rapier's own friction is switched off (coefficient 0), and the law's bias and damping take its
//! place in one of two ways.
//!
//! *Motor.* A joint that locks nothing has a motor along each of the two tangents. A motor of
//! rapier is a damper towards a velocity, force = damping·(target − v), solved with all other
//! constraints at the end of each substep. This is a companion step with target = −bias/damping.
//!
//! Averaged over the substeps its force is exactly −(bias + damping·v̄), where v̄ is the
//! displacement over the step divided by h, because rapier moves the bodies by these velocities.
//! Masses and other forces need not be known.
//!
//! *Force.* The mean velocity is solved beforehand in closed form, from the mass and all other
//! forces along the tangent, and −F̄ acts as an external force. rapier spreads an external force
//! over its n substeps, so that the displacement is h v̄ with v̄ = v₀ + (n + 1)/(2n) (v₁ − v₀). An
//! impulse before the step is not spread, and the weight is: a body that ought to stand walks.

use bristle::ParameterError;
use bristle::companion::PointMass;
use rapier3d_f64::prelude::*;

use crate::law::Law;

/// The tangents of the ground's frame, x and z; its y axis is the normal.
const TANGENTS: [(JointAxis, usize); 2] = [(JointAxis::LinX, 0), (JointAxis::LinZ, 2)];

/// A way into the engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coupling {
    /// As motors of a joint.
    Motor,
    /// As an external force, solved in closed form.
    Force,
    /// As an impulse before the step, for comparison.
    Impulse,
}

/// A body, its collider.
pub type Part = (RigidBodyHandle, ColliderHandle);

/// Friction between a body and a plane ground, with one law along each tangent.
#[derive(Debug)]
pub struct Bond {
    coupling: Coupling,
    joint: ImpulseJointHandle,
    ground: Part,
    body: Part,
    /// The body's contact point, in its own frame.
    foot: Vector,
    laws: [Box<dyn Law>; 2],
    /// What the coupling by a force takes for the body's mass [kg].
    pub believed_mass: f64,
}

impl Bond {
    /// Lets a body's foot, in the body's frame, rub on the ground.
    pub fn new(
        world: &mut PhysicsWorld,
        coupling: Coupling,
        ground: Part,
        body: Part,
        foot: Vector,
        laws: [Box<dyn Law>; 2],
    ) -> Self {
        let mut free = GenericJointBuilder::new(JointAxesMask::empty()).local_anchor2(foot);
        for (axis, _) in TANGENTS {
            free = free.motor_model(axis, MotorModel::ForceBased);
        }
        let joint = world.insert_impulse_joint(ground.0, body.0, free);
        world.bodies[body.0].recompute_mass_properties_from_colliders(&world.colliders);
        let believed_mass = world.bodies[body.0].mass();
        Self { coupling, joint, ground, body, foot, laws, believed_mass }
    }

    /// One step of the world with this friction in it. `others` is the sum of all other forces on
    /// the body [N], in the world's frame; only the coupling by a force needs it.
    pub fn step(&mut self, world: &mut PhysicsWorld, others: Vector) -> Result<(), ParameterError> {
        let h = world.integration_parameters.dt;
        let normal_force = self.normal_force(world);
        let velocity = self.sliding_velocity(world);
        let before = self.place(world);
        let turn = *world.bodies[self.ground.0].rotation();
        let others = turn.inverse() * others;

        let mut push = Vector::ZERO;
        for (i, (axis, component)) in TANGENTS.into_iter().enumerate() {
            self.laws[i].begin(velocity[component], normal_force, h)?;
            if self.coupling == Coupling::Motor {
                let Some(joint) = world.impulse_joints.get_mut(self.joint, true) else { continue };
                // A motor without stiffness and damping is rigid in rapier, not absent.
                let damper = self.laws[i].damper();
                let (damping, target) = damper.unwrap_or((1.0, 0.0));
                joint.data.set_motor(axis, 0.0, target, 0.0, damping);
                joint.data.set_motor_max_force(axis, damper.map_or(0.0, |_| f64::MAX));
            } else {
                let substeps = world.integration_parameters.num_solver_iterations as f64;
                push[component] = -self.laws[i].force(PointMass {
                    mass: self.believed_mass,
                    velocity: velocity[component],
                    force: others[component],
                    end_weight: 0.5 * (substeps + 1.0) / substeps,
                });
            }
        }
        let body = &mut world.bodies[self.body.0];
        let foot = *body.position() * self.foot;
        match self.coupling {
            Coupling::Motor => {}
            Coupling::Force => body.add_force_at_point(turn * push, foot, true),
            Coupling::Impulse => body.apply_impulse_at_point(turn * push * h, foot, true),
        }
        world.step();
        if self.coupling == Coupling::Force {
            // The force has left a torque, too.
            world.bodies[self.body.0].reset_forces(false);
            world.bodies[self.body.0].reset_torques(false);
        }
        let moved = (self.place(world) - before) / h;
        self.laws[0].commit(moved.x);
        self.laws[1].commit(moved.z);
        Ok(())
    }

    /// The normal force of the last step [N], from the impulses of the contact.
    pub fn normal_force(&self, world: &PhysicsWorld) -> f64 {
        let pair = world.contact_pair(self.ground.1, self.body.1);
        pair.map_or(0.0, |pair| pair.total_impulse_magnitude()) / world.integration_parameters.dt
    }

    /// Where the foot stands in the ground's frame [m].
    pub fn place(&self, world: &PhysicsWorld) -> Vector {
        let foot = *world.bodies[self.body.0].position() * self.foot;
        world.bodies[self.ground.0].position().inverse() * foot
    }

    /// The velocity of the foot over the ground, in the ground's frame [m/s].
    pub fn sliding_velocity(&self, world: &PhysicsWorld) -> Vector {
        let foot = *world.bodies[self.body.0].position() * self.foot;
        let [body, ground] = [self.body.0, self.ground.0].map(|part| &world.bodies[part]);
        ground.rotation().inverse()
            * (body.velocity_at_point(foot) - ground.velocity_at_point(foot))
    }

    /// The law along a tangent, 0 or 1.
    pub fn law(&self, tangent: usize) -> &dyn Law {
        self.laws[tangent.min(1)].as_ref()
    }
}
