//! An elastic joint: its energy, the motion through its play, and its borders.

use bristle::companion::Companion;
use bristle::{Bristle, Dahl, DahlParameters, Mechanism};
use bristle_mechanism::{
    Block, Chain, ContactState, Coupling, ElasticJoint, ElasticJointMotion, ElasticJointParameters,
    Inputs, Motion, on_ground,
};
use bristle_specimens::draw::Draw;

use crate::refusals::refused;

const JOINT: ElasticJointParameters<f64> =
    ElasticJointParameters { inertias: [0.01, 0.1], stiffness: 50.0, damping: 0.0, backlash: 0.02 };

fn companion(load: f64) -> Companion<f64, Dahl<f64>> {
    let parameters = DahlParameters { dynamic_coefficient: 1.0, micro_stiffness: 1e3 };
    Dahl::new(parameters).unwrap().under_load(load).unwrap().companion(1.0).unwrap()
}

/// Random joints, torques, loads and lengths of step over five decades: the teeth cross the whole
/// play in a step, bounce within it, or never leave a flank.
#[test]
fn no_step_makes_energy_and_none_loses_it() {
    let mut draw = Draw::seeded(5);
    for _ in 0..3000 {
        let parameters = ElasticJointParameters {
            inertias: [draw.logarithmic(1e-3, 1.0), draw.logarithmic(1e-3, 1.0)],
            stiffness: draw.logarithmic(1.0, 1e4),
            damping: if draw.next() < 0.5 { 0.0 } else { draw.logarithmic(1e-3, 1.0) },
            backlash: if draw.next() < 0.2 { 0.0 } else { draw.logarithmic(1e-4, 0.5) },
        };
        let joint = ElasticJoint::new(parameters).unwrap();
        let companions = [companion(0.5), companion(1.0)];
        let mut contacts = companions.map(|companion| ContactState::new(&companion, 0.0));
        let signed = |draw: &mut Draw| 2.0 * draw.next() - 1.0;
        let mut motion = ElasticJointMotion {
            position: [0.3 * signed(&mut draw), 0.3 * signed(&mut draw)],
            velocity: [5.0 * signed(&mut draw), 5.0 * signed(&mut draw)],
        };
        let h = draw.logarithmic(1e-5, 1.0);
        for _ in 0..20 {
            let torques = [10.0 * signed(&mut draw), 10.0 * signed(&mut draw)];
            let loads = Some([draw.next(), draw.next()]);
            let before = motion;
            let stretched = motion.position[0] - motion.position[1];
            let done = joint.step(h, torques, &mut motion, &companions, &mut contacts, loads);
            let [motor, link] = done.mean_velocities;
            let mut given = h * (torques[0] * motor + torques[1] * link) - done.dissipated;
            let mut terms = h * (torques[0] * motor).abs() + h * (torques[1] * link).abs();
            for contact in &contacts {
                let step = contact.last_step();
                given -= step.work;
                terms += step.work.abs();
                assert!(step.dissipated >= 0.0);
            }
            let (start, end) = (joint.energy(&before), joint.energy(&motion));
            // The work of the shaft is a product with a difference of angles, e₁ − e₀.
            let turned = motion.position.iter().fold(1.0_f64, |most, q| most.max(q.abs()));
            let torque = done.torque.abs() + parameters.stiffness * stretched.abs();
            terms += start + end + done.dissipated + torque * turned;
            // The accelerations are solved for: their roundings are multiplied by how much stiffer
            // shaft and friction are than the inertias in a step.
            let lightest = parameters.inertias[0].min(parameters.inertias[1]);
            let stiff =
                1.0 + h * (parameters.damping + h * (parameters.stiffness + 1e3)) / lightest;
            let rounding = 100.0 * f64::EPSILON * terms * stiff.sqrt();
            assert!(
                (end - start - given).abs() <= rounding,
                "{:e} {rounding:e}",
                end - start - given
            );
        }
    }
}

/// Without friction and losses: flight through the play, half an oscillation on a flank, and back.
#[test]
fn the_period_in_the_play_is_that_of_flights_and_half_oscillations() {
    let joint = ElasticJoint::new(JOINT).unwrap();
    let companions = [companion(0.0); 2];
    let rate = (JOINT.stiffness * (1.0 / JOINT.inertias[0] + 1.0 / JOINT.inertias[1])).sqrt();
    let velocity = 0.5;
    let period = 2.0 * (std::f64::consts::PI / rate + JOINT.backlash / velocity);
    let error = |steps: u32| {
        let mut contacts = companions.map(|companion| ContactState::new(&companion, 0.0));
        // At rest together: momentum zero.
        let share = JOINT.inertias[0] / JOINT.inertias[1];
        let [motor, link] = [velocity / (1.0 + share), -velocity * share / (1.0 + share)];
        let mut motion = ElasticJointMotion { position: [0.0; 2], velocity: [motor, link] };
        for _ in 0..steps {
            let h = 3.0 * period / f64::from(steps);
            let _ = joint.step(h, [0.0; 2], &mut motion, &companions, &mut contacts, None);
        }
        (motion.position[0] - motion.position[1]).abs()
    };
    let errors = [2000, 4000, 8000, 16000].map(error);
    let order = (errors[0] / errors[3]).log2() / 3.0;
    // Where in a step the teeth meet differs from run to run.
    assert!(errors[3] < 1e-5 && (order - 2.0).abs() < 0.3, "{errors:?}: order {order}");
}

#[test]
fn without_backlash_it_is_a_chain_of_two() {
    let parameters = ElasticJointParameters { damping: 0.05, backlash: 0.0, ..JOINT };
    let joint = ElasticJoint::new(parameters).unwrap();
    let blocks = parameters.inertias.map(|inertia| Block {
        to_ground: Mechanism { mass: inertia, spring_stiffness: 0.0, viscous_damping: 0.0 },
        to_next: Coupling { stiffness: parameters.stiffness, damping: parameters.damping },
    });
    let mut chain = Chain { blocks: &blocks }.on_heap([on_ground(0), on_ground(1)]).unwrap();
    let companions = [companion(0.1), companion(0.05)];
    let mut contacts = [companions.map(|companion| ContactState::new(&companion, 0.0)); 2];
    let mut motion = ElasticJointMotion { position: [0.0; 2], velocity: [0.0; 2] };
    let (mut x, mut v, h) = ([0.0; 2], [0.0; 2], 2e-3);
    for n in 0..1000 {
        let torques = [0.5 * (0.01 * f64::from(n)).sin(), 0.1];
        let inputs = Inputs::force(&torques);
        let of_chain = Motion { position: &mut x, velocity: &mut v };
        chain.step(h, &inputs, of_chain, &companions, &mut contacts[0]).unwrap();
        let _ = joint.step(h, torques, &mut motion, &companions, &mut contacts[1], None);
    }
    for k in 0..2 {
        // A thousand steps of a stable motion, some roundings each.
        assert!((x[k] - motion.position[k]).abs() < 1e-12 * x[k].abs().max(1.0));
        assert!((v[k] - motion.velocity[k]).abs() < 1e-11);
    }
}

#[test]
fn what_is_no_joint_is_refused() {
    let joint = |parameters| ElasticJoint::<f64>::new(parameters).map(drop);
    refused(
        joint(ElasticJointParameters { inertias: [1.0, 0.0], ..JOINT }),
        "inertias[1] is 0, but must",
    );
    refused(joint(ElasticJointParameters { stiffness: 0.0, ..JOINT }), "stiffness is 0, but must");
    refused(joint(ElasticJointParameters { damping: -1.0, ..JOINT }), "damping is -1, but must");
    refused(joint(ElasticJointParameters { backlash: f64::NAN, ..JOINT }), "backlash is NaN");
    let companions = [companion(1.0); 2];
    let mut contacts = companions.map(|companion| ContactState::new(&companion, 0.0));
    let mut motion = ElasticJointMotion { position: [0.0; 2], velocity: [1.0; 2] };
    let joint = ElasticJoint::new(JOINT).unwrap();
    let _ = joint.step(-1e-3, [0.0; 2], &mut motion, &companions, &mut contacts, None);
    assert!(motion.position.iter().chain(&motion.velocity).all(|x| x.is_nan()));
}
