//! Gradients by the adjoint are those of dual numbers through the same program.

use bristle::companion::Companion;
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, FrBd, Scalar};
use bristle_mechanism::gradient::{
    Adjoint, ArmAdjoint, ArmMiddleAdjoint, ArmState, ContactAdjoint, backwards,
};
use bristle_mechanism::{
    Arm, ArmMiddle, ArmMotion, ArmParameters, ContactState, Inputs, LinearMechanism, Link,
    Matrices, Motion, Structure, on_joint,
};
use bristle_specimens::lit;
use num_dual::Dual64;

const N: usize = 3;
const H: f64 = 5e-3;
const STEPS: usize = 400;
type Friction<T> = FrBd<Stribeck<T>, KelvinVoigt<T>>;
type OneRow<T> = [(usize, T); 1];

fn friction<T: Scalar>(p: &[T], reference_load: f64) -> Companion<T, Friction<T>> {
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: p[0],
        dynamic_coefficient: p[1],
        stribeck_velocity: p[2],
        stribeck_exponent: lit(2.0),
        viscous_friction: p[3],
    });
    let bristle = KelvinVoigtParameters { micro_stiffness: p[4], micro_damping: p[5] };
    let model = FrBd::new(curve.unwrap(), KelvinVoigt::new(bristle).unwrap());
    // The limit of a low speed: deflections are cut, in some steps.
    model.under_load(lit(reference_load)).unwrap().companion(lit(0.3)).unwrap()
}

/// Six parameters of each joint.
fn parameters() -> Vec<f64> {
    (0..N).flat_map(|i| [0.4, 0.3, 0.1 + 0.02 * i as f64, 0.02, 500.0, 1.0]).collect()
}

#[derive(Clone)]
struct State<T: Scalar> {
    motion: [Vec<T>; 3],
    contacts: Vec<ContactState<T>>,
}

/// An arm that is driven to and fro by a controller, its loads following torques and gravity, so
/// that joints reverse, stick, and slip back where the load falls.
struct Driven<T: Scalar> {
    arm: Arm<T, Vec<OneRow<T>>, Vec<T>>,
    companions: Vec<Companion<T, Friction<T>>>,
}

fn drive<T: Scalar>(n: usize, middle: ArmMiddle<'_, T>) {
    let time = H * (n as f64 + 0.5);
    for i in 0..N {
        let aim = lit::<T>(0.8 * (3.0 * time + i as f64).sin());
        let torque = (aim - middle.position[i]) * lit(20.0) - middle.velocity[i];
        let jerk = 1.0 + (40.0 * time).sin();
        middle.torque[i] = torque;
        middle.load[i] = lit::<T>(0.2 + 2.0 * jerk) + (torque - middle.gravity[i]).abs() * lit(0.3);
    }
}

impl<T: Scalar> Driven<T> {
    fn new(parameters: &[T]) -> (Self, State<T>) {
        let link = |i: usize| {
            let [mass, length, centre] = [1.0 - 0.2 * i as f64, 0.3, 0.14];
            let [mass, length, centre] = [mass, length, centre].map(lit);
            let [inertia, rotor, damping] = [0.008, 0.05, 0.02].map(lit);
            Link { mass, length, centre, inertia, rotor, damping }
        };
        let links: Vec<_> = (0..N).map(link).collect();
        let rows = (0..N).map(on_joint).collect();
        let arm = ArmParameters { links: &links, gravity: lit(9.81) };
        let arm = Arm::on_heap(&arm, rows).unwrap();
        let companions: Vec<_> = parameters.chunks(6).map(|p| friction(p, 1.5)).collect();
        let contacts = companions.iter().map(|c| ContactState::new(c, T::zero())).collect();
        (Self { arm, companions }, State { motion: [(); 3].map(|()| vec![T::zero(); N]), contacts })
    }

    fn step(&mut self, n: usize, state: &mut State<T>) {
        let [position, velocity, acceleration] = &mut state.motion;
        let motion = ArmMotion { position, velocity, acceleration };
        let (contacts, companions) = (&mut state.contacts, &self.companions);
        self.arm.step(lit(H), motion, companions, contacts, |middle| drive(n, middle)).unwrap();
    }
}

/// What a state adds to the loss: squares of angles and velocities, and the friction's deflection.
fn loss<T: Scalar>(state: &State<T>) -> T {
    let square = |x: &[T]| x.iter().fold(T::zero(), |sum, x| sum + *x * *x);
    let bent = state.contacts.iter().fold(T::zero(), |sum, c| sum + c.deflection());
    square(&state.motion[0]) + square(&state.motion[1]) * lit(0.1) + bent * lit(10.0)
}

fn total<T: Scalar>(parameters: &[T]) -> T {
    let (mut driven, mut state) = Driven::new(parameters);
    (0..STEPS).fold(T::zero(), |sum, n| {
        driven.step(n, &mut state);
        sum + loss(&state)
    })
}

/// The gradient, and how often a joint reversed.
fn gradient(between: usize) -> (Vec<f64>, usize) {
    let (mut driven, start) = Driven::new(&parameters());
    let (mut other, _) = Driven::new(&parameters());
    let mut gradient = vec![0.0; 6 * N];
    let mut by = [(); 3].map(|()| vec![0.0; N]);
    let mut by_contacts = [ContactAdjoint::default(); N];
    let mut reversals = 0;
    let step = |n, state: &mut State<f64>| {
        other.step(n, state);
        Ok::<_, bristle::ParameterError>(())
    };
    backwards(start, STEPS, between, step, |n, states| {
        let after = states[1];
        for i in 0..N {
            by[0][i] += 2.0 * after.motion[0][i];
            by[1][i] += 0.2 * after.motion[1][i];
            by_contacts[i].deflection += 10.0;
            reversals += usize::from(states[0].motion[1][i] * after.motion[1][i] < 0.0);
        }
        let states =
            states.map(|State { motion: [position, velocity, acceleration], contacts }| ArmState {
                position,
                velocity,
                acceleration,
                contacts,
            });
        let [position, velocity, acceleration] = &mut by;
        let contacts = &mut by_contacts;
        let adjoint = ArmAdjoint { position, velocity, acceleration, contacts };
        let drive_back = |back: ArmMiddleAdjoint<'_, f64>| {
            assert!(
                after.contacts.iter().map(ContactState::load).eq(back.middle.load.iter().copied())
            );
            let [position, velocity, gravity] = [back.position, back.velocity, back.gravity];
            let (weight, torque) = (back.middle.gravity, back.middle.torque);
            let middle = ArmMiddle { torque, ..back.middle };
            drive(n, middle);
            for i in 0..N {
                let signed = torque[i] - weight[i];
                let by_load = 0.3 * signed.signum() * back.contacts[i].given_load;
                let by_torque = back.torque[i] + by_load;
                gravity[i] -= by_load;
                position[i] -= 20.0 * by_torque;
                velocity[i] -= by_torque;
            }
        };
        driven.arm.pull_back(H, states, &driven.companions, drive_back, adjoint, &mut gradient)
    })
    .unwrap();
    (gradient, reversals)
}

#[test]
fn the_gradient_of_an_arm_is_that_of_dual_numbers() {
    let (got, reversals) = gradient(1);
    assert!(reversals > 10, "{reversals}");
    let largest = got.iter().zip(parameters()).map(|(g, p)| (g * p).abs()).fold(0.0, f64::max);
    for (k, (got, p)) in got.iter().zip(parameters()).enumerate() {
        let mut dual: Vec<_> = parameters().into_iter().map(Dual64::from).collect();
        dual[k] = dual[k].derivative();
        let want = total(&dual).eps;
        // Of 400 steps with some hundred roundings each, relative to the largest sensitivity.
        assert!(((got - want) * p).abs() < 1e-12 * largest, "{k}: {got:e}, not {want:e}");
    }
}

#[test]
fn checkpoints_change_no_bit() {
    let all = gradient(1).0;
    for between in [7, 20, STEPS, 1000] {
        assert_eq!(gradient(between).0, all);
    }
}

/// Two masses on springs and a belt, one of them under a load that falls below what its bristle
/// carries: the loss is the work of both at the end, by way of each structure.
fn linear<T: Scalar>(
    structure: Structure,
    parameters: &[T],
) -> (Linear<T>, Vec<Companion<T, Friction<T>>>) {
    let [stiffness, damping] = [[3.0, -1.0, -1.0, 2.0], [0.2, -0.1, -0.1, 0.1]];
    let in_structure = |full: [f64; 4]| -> Vec<T> {
        let order: &[usize] = match structure {
            Structure::Dense => &[0, 1, 2, 3],
            Structure::Diagonal => &[0, 3],
            Structure::Banded { .. } => &[0, 0, 1, 3],
        };
        order.iter().map(|&k| lit(full[k])).collect()
    };
    let (mass, stiffness) = (in_structure([1.0, 0.0, 0.0, 0.5]), in_structure(stiffness));
    let damping = in_structure(damping);
    let matrices = Matrices { structure, mass: &mass, damping: &damping, stiffness: &stiffness };
    let rows = vec![vec![(0, T::one())], vec![(1, T::one()), (0, lit(-0.5))]];
    let companions = parameters.chunks(6).map(|p| friction(p, 2.0)).collect();
    (LinearMechanism::on_heap(&matrices, rows).unwrap(), companions)
}

type Linear<T> = LinearMechanism<T, Vec<Vec<(usize, T)>>, Vec<T>>;

fn acting(n: usize) -> ([f64; 2], [f64; 2], [f64; 2]) {
    let time = 0.01 * n as f64;
    let load = |phase: f64| (1.0 + 1.2 * (5.0 * time + phase).sin()).max(0.0);
    ([3.0 * (2.0 * time).sin(), 1.0], [0.1, -0.05], [load(0.0), load(1.0)])
}

#[test]
fn the_gradient_of_a_linear_mechanism_is_that_of_dual_numbers() {
    // One of them without σ1, as Dahl's.
    let parameters = [0.5, 0.4, 0.05, 0.1, 200.0, 0.0, 0.3, 0.2, 0.1, 0.0, 300.0, 1.0];
    let steps = 300;
    let band = Structure::Banded { half_bandwidth: 1 };
    // In the last case one companion serves both contacts.
    for (structure, parameters) in [
        (Structure::Dense, &parameters[..]),
        (Structure::Diagonal, &parameters),
        (band, &parameters),
        (band, &parameters[6..]),
    ] {
        let total = |k: usize| {
            let mut dual: Vec<_> = parameters.iter().copied().map(Dual64::from).collect();
            dual[k] = dual[k].derivative();
            let (mut mechanism, companions) = linear(structure, &dual);
            let mut contacts = [ContactState::new(&companions[0], lit(1e-4)); 2];
            let [mut position, mut velocity] = [[Dual64::from(0.1); 2]; 2];
            for n in 0..steps {
                let (force, prescribed, load) = acting(n);
                let [force, prescribed, load] =
                    [force, prescribed, load].map(|x| x.map(Dual64::from));
                let inputs = Inputs { force: &force, prescribed: &prescribed, load: &load };
                let motion = Motion { position: &mut position, velocity: &mut velocity };
                let h = lit(0.01);
                mechanism.step(h, &inputs, motion, &companions, &mut contacts).unwrap();
            }
            (position[0] + velocity[1] * 2.0 + contacts[1].deflection() * 100.0).eps
        };
        let (mut mechanism, companions) = linear(structure, parameters);
        let (mut other, _) = linear(structure, parameters);
        let start = ([[0.1; 2]; 2], [ContactState::new(&companions[0], 1e-4); 2]);
        let [mut by_position, mut by_velocity, mut by_force] = [[1.0, 0.0], [0.0, 2.0], [0.0; 2]];
        let mut by_contacts = [ContactAdjoint::default(); 2];
        by_contacts[1].deflection = 100.0;
        let mut gradient = vec![0.0; parameters.len()];
        let step = |n, ([position, velocity], contacts): &mut ([[f64; 2]; 2], [_; 2])| {
            let (force, prescribed, load) = acting(n);
            let inputs = Inputs { force: &force, prescribed: &prescribed, load: &load };
            other.step(0.01, &inputs, Motion { position, velocity }, &companions, contacts)
        };
        backwards(start, steps, 17, step, |n, [(_, before), (_, after)]| {
            let (force, prescribed, load) = acting(n);
            let inputs = Inputs { force: &force, prescribed: &prescribed, load: &load };
            let adjoint = Adjoint {
                position: &mut by_position,
                velocity: &mut by_velocity,
                force: &mut by_force,
                contacts: &mut by_contacts,
            };
            let contacts = [&before[..], after];
            mechanism.pull_back(0.01, &inputs, &companions, contacts, adjoint, &mut gradient)
        })
        .unwrap();
        for (k, got) in gradient.into_iter().enumerate() {
            let want = total(k);
            // Some hundred roundings in each of 300 steps of a stable motion.
            assert!(
                (got - want).abs() < 1e-12 * want.abs().max(1e-3),
                "{k}: {got:e}, not {want:e}"
            );
        }
    }
}
