//! An arm of any number of joints: against two links written out by hand, and by its energy.

use bristle::nalgebra::{Matrix2, SVector, Vector2};
use bristle::ode::{self, Output, System};
use bristle::{Branch, Bristle, Contact, Dahl, DahlParameters};
use bristle_mechanism::{Arm, ArmMotion, ArmParameters, ContactState, Link, on_joint};
use bristle_specimens::draw::Draw;

use crate::reference::{Friction, friction};
use crate::refusals::refused;

const LINKS: [Link<f64>; 2] = [
    Link { mass: 1.3, length: 0.4, centre: 0.15, inertia: 0.02, rotor: 0.03, damping: 0.1 },
    Link { mass: 0.8, length: 0.3, centre: 0.2, inertia: 0.01, rotor: 0.02, damping: 0.05 },
];
const GRAVITY: f64 = 9.81;
const START: [f64; 2] = [1.2, -0.7];

/// Motor torques [N m]: control of the position, and a swing.
pub(crate) fn torque(time: f64, q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
    [6.0 * (3.0 * time).sin() - 20.0 * q[0] - v[0], -10.0 * (q[1] - 0.5) - v[1]]
}

/// The equations of two links in the angles of their joints, as in textbooks.
pub(crate) struct TwoLinks(pub(crate) Contact<f64, Friction>);

impl System<f64, 6, 2> for TwoLinks {
    fn rate(&self, time: f64, state: &SVector<f64, 6>, on: [Branch; 2]) -> SVector<f64, 6> {
        let [q1, q2, v1, v2, z1, z2] = (*state).into();
        let [a, b] = LINKS;
        let own = b.inertia + b.mass * b.centre * b.centre;
        let arm = b.mass * a.length * b.centre;
        let first = a.inertia
            + a.mass * a.centre * a.centre
            + b.mass * a.length * a.length
            + own
            + 2.0 * arm * q2.cos();
        let both = own + arm * q2.cos();
        let mass = Matrix2::new(first + a.rotor, both, both, own + b.rotor);
        let k = arm * q2.sin();
        let coriolis = Vector2::new(-k * (2.0 * v1 * v2 + v2 * v2), k * v1 * v1);
        let second = b.mass * GRAVITY * b.centre * (q1 + q2).sin();
        let weight = (a.mass * a.centre + b.mass * a.length) * GRAVITY * q1.sin() + second;
        let friction = [(v1, z1), (v2, z2)];
        let [f1, f2] = [0, 1].map(|i| self.0.response(on[i].of(friction[i].0), friction[i].1));
        let resisting =
            Vector2::new(f1.force + a.damping * v1 + weight, f2.force + b.damping * v2 + second);
        let torque = Vector2::from(torque(time, [q1, q2], [v1, v2]));
        let acceleration = mass.lu().solve(&(torque - coriolis - resisting)).unwrap();
        [v1, v2, acceleration[0], acceleration[1], f1.rate, f2.rate].into()
    }

    fn sliding_velocities(&self, _time: f64, state: &SVector<f64, 6>) -> [f64; 2] {
        [state[2], state[3]]
    }
}

pub(crate) type Rows = [[(usize, f64); 1]; 2];

/// Angles and velocities after 3 s in steps of h.
fn run<S>(mut arm: Arm<f64, Rows, S>, h: f64) -> [f64; 4]
where
    S: AsRef<[f64]> + AsMut<[f64]>,
{
    let companion = friction();
    let mut contacts = [ContactState::new(&companion, 0.0); 2];
    let (mut q, mut v, mut a) = (START, [0.0; 2], [0.0; 2]);
    for n in 0..(3.0 / h).round() as u32 {
        let motion = ArmMotion { position: &mut q, velocity: &mut v, acceleration: &mut a };
        arm.step(h, motion, &[companion], &mut contacts, |middle| {
            let time = h * (f64::from(n) + 0.5);
            let [q, v] = [middle.position, middle.velocity].map(|x| [x[0], x[1]]);
            middle.torque.copy_from_slice(&torque(time, q, v));
        })
        .unwrap();
    }
    [q[0], q[1], v[0], v[1]]
}

const PARAMETERS: ArmParameters<'static, f64> = ArmParameters { links: &LINKS, gravity: GRAVITY };

pub(crate) fn two_links() -> Arm<f64, Rows, Vec<f64>> {
    Arm::on_heap(&PARAMETERS, [on_joint(0), on_joint(1)]).unwrap()
}

#[test]
fn bits_are_those_of_a_size_known_at_run_time_and_steps_do_not_allocate() {
    // What was in the storage before does not count.
    let storage = [f64::NAN; ArmParameters::<f64>::storage(2, 2)];
    let fixed = Arm::new(&PARAMETERS, [on_joint(0), on_joint(1)], storage).unwrap();
    let want = run(two_links(), 1e-2);
    let allocated = allocation_counter::measure(|| assert_eq!(run(fixed, 1e-2), want));
    assert_eq!(allocated.count_total, 0);
}

#[test]
pub(crate) fn two_links_move_as_the_equations_of_textbooks() {
    let start = [START[0], START[1], 0.0, 0.0, 0.0, 0.0].into();
    let system = TwoLinks(*friction().contact());
    let solved = ode::solve(&system, 0.0..3.0, start, 1e-9, Output::Uniform(2)).unwrap();
    let want = solved.states()[1];
    let error = |h| {
        let got = run(two_links(), h);
        got.iter().zip(want.iter()).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
    };
    let errors = [4e-3, 2e-3, 1e-3, 5e-4].map(error);
    let order = (errors[0] / errors[3]).log2() / 3.0;
    // A kink moves through the steps.
    assert!(errors[3] < 1e-4 && (order - 2.0).abs() < 0.15, "{errors:?}: order {order}");
}

/// A free arm of n random links keeps its energy, and, without gravity, the angular momentum about
/// its base, to the second order: M, c and V belong together.
#[test]
fn a_free_arm_keeps_its_energy() {
    let mut draw = Draw::seeded(7);
    for n in 1..=7 {
        let links: Vec<_> = (0..n)
            .map(|_| Link {
                mass: 0.5 + draw.next(),
                length: 0.2 + 0.3 * draw.next(),
                centre: 0.3 * draw.next(),
                inertia: 0.01 * draw.next(),
                rotor: 0.02,
                damping: 0.0,
            })
            .collect();
        let start: Vec<_> = (0..n).map(|_| 4.0 * draw.next() - 2.0).collect();
        let drift = |h: f64| {
            let none: Vec<[(usize, f64); 1]> = Vec::new();
            let parameters = ArmParameters { links: &links, gravity: GRAVITY };
            let mut arm = Arm::on_heap(&parameters, none).unwrap();
            let (mut q, mut v, mut a) = (start.clone(), vec![0.0; n], vec![0.0; n]);
            let (before, mut most) = (arm.energy(&q, &v), 0.0_f64);
            for _ in 0..(1.0 / h).round() as u32 {
                let motion = ArmMotion { position: &mut q, velocity: &mut v, acceleration: &mut a };
                arm.step::<Friction>(h, motion, &[], &mut [], |_| ()).unwrap();
                most = most.max((arm.energy(&q, &v) - before).abs());
            }
            (most, before)
        };
        let ((coarse, _), (fine, energy)) = (drift(2e-4), drift(1e-4));
        let ratio = coarse / fine;
        assert!(fine < 1e-3 * energy && ratio > 3.5 && ratio < 4.5, "{n}: {fine:e} {ratio}");
    }
}

/// Loads that rise and fall, and a step far beyond the accuracy: what each contact gives back it
/// had before.
/// K_D h/J + K_P h²/(2J) ≤ 1 for a link without gravity, whose friction is next to none.
#[test]
fn a_drive_has_the_largest_step_that_is_said() {
    let (inertia, h) = (0.05, 1e-3);
    let link = Link { mass: 1.0, length: 0.2, centre: 0.0, inertia, rotor: 0.0, damping: 0.0 };
    let parameters = ArmParameters { links: &[link], gravity: 0.0 };
    let friction = DahlParameters { dynamic_coefficient: 1e-9, micro_stiffness: 1.0 };
    let friction = Dahl::new(friction).unwrap().under_load(1e-9).unwrap().companion(1.0).unwrap();
    let end = |damped: f64, times: f64| {
        let gains = [(1.0 - damped) * 2.0 / (h * h), damped / h].map(|gain| gain * inertia * times);
        let mut arm = Arm::on_heap(&parameters, [on_joint(0)]).unwrap();
        let mut contacts = [ContactState::new(&friction, 0.0)];
        let [mut q, mut v, mut a] = [[1e-3], [1e-3], [0.0]];
        for _ in 0..20_000 {
            let motion = ArmMotion { position: &mut q, velocity: &mut v, acceleration: &mut a };
            arm.step(h, motion, &[friction], &mut contacts, |middle| {
                middle.torque[0] = -gains[0] * middle.position[0] - gains[1] * middle.velocity[0];
            })
            .unwrap();
        }
        q[0].abs()
    };
    for damped in [0.2, 0.5, 0.9, 1.0] {
        let ends = [end(damped, 0.99), end(damped, 1.01)];
        assert!(ends[0] < 2e-3 && !(ends[1] < 1e3), "{damped}: {ends:?}");
    }
}

#[test]
fn contacts_of_an_arm_are_passive() {
    let (n, mut draw, companion) = (5, Draw::seeded(3), friction());
    let link = Link { rotor: 0.05, ..LINKS[0] };
    let parameters = ArmParameters { links: &[link; 5], gravity: GRAVITY };
    let rows: Vec<_> = (0..n).map(on_joint).collect();
    let mut arm = Arm::on_heap(&parameters, rows).unwrap();
    let mut contacts = vec![ContactState::new(&companion, 0.0); n];
    let (mut q, mut v, mut a) = (vec![1.0; n], vec![0.0; n], vec![0.0; n]);
    let stored = |state: &ContactState<f64>| companion.contact().stored_energy(state.deflection());
    for _ in 0..5000 {
        let before: Vec<f64> = contacts.iter().map(stored).collect();
        let motion = ArmMotion { position: &mut q, velocity: &mut v, acceleration: &mut a };
        arm.step(0.02, motion, &[companion], &mut contacts, |middle| {
            middle.load.iter_mut().for_each(|load| *load = 2.0 * draw.next());
            for (torque, v) in middle.torque.iter_mut().zip(middle.velocity) {
                *torque = 10.0 * (draw.next() - 0.5) - v;
            }
        })
        .unwrap();
        for (state, before) in contacts.iter().zip(before) {
            let done = state.last_step();
            // 16 ε of its terms is the rounding of a step.
            let rounding = 16.0 * f64::EPSILON * (done.work.abs() + before + stored(state));
            assert!(done.dissipated >= 0.0 && done.work >= stored(state) - before - rounding);
        }
    }
}

#[test]
fn what_is_no_arm_is_refused() {
    let none: [[(usize, f64); 1]; 0] = [];
    let arm = |links: &[Link<f64>], gravity| {
        Arm::on_heap(&ArmParameters { links, gravity }, none).map(drop)
    };
    assert!(arm(&LINKS, 0.0).is_ok() && arm(&LINKS, -9.81).is_ok());
    refused(arm(&[], 0.0), "of links there must be at least 1, not 0");
    refused(arm(&LINKS, f64::NAN), "gravity is NaN");
    let [a, b] = LINKS;
    refused(arm(&[a, Link { mass: -1.0, ..b }], 0.0), "mass[1] is -1");
    let light = Link { inertia: 0.0, rotor: 0.0, centre: 0.0, ..b };
    refused(arm(&[a, light], 0.0), "inertia about the joint[1] is 0");
    let parameters = ArmParameters { links: &LINKS, gravity: 0.0 };
    refused(Arm::on_heap(&parameters, [on_joint(2)]), "coordinate of contact[0] is 2");
    let small = [0.0; ArmParameters::<f64>::storage(2, 0) - 1];
    refused(Arm::new(&parameters, none, small), "there must be at least 48 numbers of storage");
}
