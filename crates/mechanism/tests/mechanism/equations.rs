//! Equations of motion: solved, they reach what steps tend to and what others have written out.

use bristle::ode::dynamic::System;
use bristle::ode::{self, Output, dynamic};
use bristle::{Branch, Bristle, Contact, Dahl, DahlParameters};
use bristle_mechanism::{
    Acting, ContactState, ElasticJoint, ElasticJointMotion, ElasticJointParameters,
    EquationsOfMotion, Inputs, Motion,
};
use bristle_specimens::implicit::TABLE_2;

use crate::arm::{self, TwoLinks, two_links};
use crate::reference::{self, ROWS, chain, dense, friction};
use crate::refusals::refused;

/// The state at the end.
fn end(system: &impl dynamic::System<f64>, start: Vec<f64>, time: f64, tolerance: f64) -> Vec<f64> {
    let solved = ode::solve(system, 0.0..time, start, tolerance, Output::Uniform(2)).unwrap();
    solved.states()[1].clone()
}

fn largest_difference<'a>(
    one: impl IntoIterator<Item = &'a f64>,
    other: impl IntoIterator<Item = &'a f64>,
) -> f64 {
    one.into_iter().zip(other).fold(0.0, |most, (a, b)| f64::max(most, (a - b).abs()))
}

#[test]
fn three_masses_reach_the_reference() {
    let contacts = [*friction().contact()];
    let drive = |acting: Acting<'_, f64>| acting.force[1] = (1.2 * acting.time).cos();
    let (dense, chain) = (dense(ROWS), chain());
    let of_dense = EquationsOfMotion::new(&dense, &contacts, [0.1, 0.1], drive).unwrap();
    let of_chain = EquationsOfMotion::new(&chain, &contacts, [0.1, 0.1], drive).unwrap();
    let both =
        [end(&of_dense, vec![0.0; 8], 20.0, 1e-10), end(&of_chain, vec![0.0; 8], 20.0, 1e-10)];
    for got in both {
        let got = [got[..3].to_vec(), got[3..6].to_vec(), got[6..].to_vec()];
        assert!(reference::error(&got) < 1e-9, "{got:?}");
    }
}

/// Two tips under loads that differ: each function is negative where its tip sticks.
#[test]
fn the_switching_functions_are_those_of_both_tips() {
    let contacts = [TABLE_2.model().under_load(1.0).unwrap()];
    let act = |acting: Acting<'_, f64>| acting.load.copy_from_slice(&[1.4, 0.5]);
    let chain = chain();
    let system = EquationsOfMotion::new(&chain, &contacts, [0.1, 0.1], act).unwrap();
    let branches = [Branch::Forward; 2];
    let (mut seen, mut rate) = ([0; 4], vec![0.0; 8]);
    for i in 0..400_u32 {
        let deflections = [f64::from(i % 20), f64::from(i / 20)].map(|i| 2.2e-5 * i);
        let state = [&[0.0; 3][..], &[1e-3, 2e-3, 3e-3], &deflections].concat();
        system.rate(0.0, &state, &branches, &mut rate);
        let mut sliding = [0.0; 2];
        system.sliding_velocities(0.0, &state, &mut sliding);
        let sticks = [0, 1].map(|k| rate[6 + k] == sliding[k]);
        let mut told = vec![];
        system.switching_functions(0.0, &state, &branches, &mut |value| told.push(value));
        assert_eq!(told.iter().map(|&value| value < 0.0).collect::<Vec<_>>(), sticks, "{i}");
        seen[usize::from(sticks[0]) + 2 * usize::from(sticks[1])] += 1;
    }
    assert!(seen.iter().all(|&count| count > 5), "{seen:?}");
    // Other models have none.
    let contacts = [*friction().contact()];
    let system = EquationsOfMotion::new(&chain, &contacts, [0.1, 0.1], |_| ()).unwrap();
    let tell = &mut |value| panic!("{value}");
    system.switching_functions(0.0, &[0.0; 8], &branches, tell);
}

/// A push of 0.3 ms on what stands still, which no step would meet: as in three runs.
#[test]
fn steps_end_where_what_acts_jumps() {
    let (chain, contacts) = (chain(), [*friction().contact()]);
    let push = |force: f64| move |acting: Acting<'_, f64>| acting.force[2] = force;
    let (begin, over) = (1.5, 1.5003);
    let act = |acting: Acting<'_, f64>| {
        let force = if (begin..over).contains(&acting.time) { 3000.0 } else { 0.0 };
        push(force)(acting);
    };
    let system = EquationsOfMotion::new(&chain, &contacts, [0.1, 0.1], act).unwrap();
    let known = system.with_kinks(vec![begin, over]).unwrap();
    let found = end(&known, vec![0.0; 8], 4.0, 1e-8);
    let parts = [(begin, 0.0), (over - begin, 3000.0), (4.0 - over, 0.0)];
    let apart = parts.into_iter().fold(vec![0.0; 8], |state, (time, force)| {
        let act = push(force);
        let part = EquationsOfMotion::new(&chain, &contacts, [0.1, 0.1], act).unwrap();
        end(&part, state, time, 1e-10)
    });
    assert!(apart[2].abs() > 0.01, "{apart:?}");
    assert!(largest_difference(&found, &apart) < 1e-8, "{found:?} {apart:?}");
}

/// A belt of 0.2 m/s below the first mass, and loads that vary: the same as in short steps.
#[test]
fn belts_and_loads_act_as_in_steps() {
    let (mut mechanism, companions) = (chain(), [friction(); 2]);
    let contacts = companions.map(|companion| *companion.contact());
    let load = |time: f64| [1.0 + 0.5 * time.sin(), 1.0];
    let act = |Acting { time, prescribed, load: to, .. }: Acting<'_, f64>| {
        prescribed[0] = -0.2;
        to.copy_from_slice(&load(time));
    };
    let still = mechanism.clone();
    let system = EquationsOfMotion::new(&still, &contacts, [0.1, 0.1], act).unwrap();
    let want = end(&system.with_longest_step(0.5).unwrap(), vec![0.0; 8], 5.0, 1e-9);
    let mut error = |steps: u32| {
        let mut states = companions.map(|companion| ContactState::new(&companion, 0.0));
        let (mut position, mut velocity, h) = ([0.0; 3], [0.0; 3], 5.0 / f64::from(steps));
        for n in 0..steps {
            let inputs = Inputs {
                force: &[0.0; 3],
                prescribed: &[-0.2, 0.0],
                load: &load(h * (f64::from(n) + 0.5)),
            };
            let motion = Motion { position: &mut position, velocity: &mut velocity };
            mechanism.step(h, &inputs, motion, &companions, &mut states).unwrap();
        }
        largest_difference(position.iter().chain(&velocity), &want)
    };
    let (coarse, fine) = (error(2000), error(8000));
    assert!(fine < 1e-5 && coarse / fine > 11.0 && coarse / fine < 21.0, "{coarse} {fine}");
}

#[test]
fn two_links_solve_as_the_equations_of_textbooks() {
    let start = [1.2, -0.7, 0.0, 0.0, 0.0, 0.0];
    let contact = *friction().contact();
    let written = TwoLinks(contact);
    let want = ode::solve(&written, 0.0..3.0, start.into(), 1e-9, Output::Uniform(2)).unwrap();
    let (arm, contacts) = (two_links(), [contact]);
    let act = |acting: Acting<'_, f64>| {
        let [q, v] = [acting.position, acting.velocity].map(|x| [x[0], x[1]]);
        acting.force.copy_from_slice(&arm::torque(acting.time, q, v));
    };
    let system = EquationsOfMotion::new(&arm, &contacts, [1.0, 1.0], act).unwrap();
    let error = largest_difference(&end(&system, start.into(), 3.0, 1e-9), &want.states()[1]);
    assert!(error < 1e-8, "{error}");
}

/// A motor swings a link through the play of its shaft: the steps tend to the same with order two.
#[test]
fn an_elastic_joint_solves_as_its_steps() {
    let joint = ElasticJoint::new(ElasticJointParameters {
        inertias: [0.01, 0.1],
        stiffness: 50.0,
        damping: 0.02,
        backlash: 0.02,
    });
    let joint = joint.unwrap();
    let dahl = DahlParameters { dynamic_coefficient: 1.0, micro_stiffness: 1e3 };
    let dahl = Dahl::new(dahl).unwrap();
    let contacts = [0.02, 0.05].map(|load| dahl.under_load(load).unwrap());
    let torque = |time: f64| 0.2 * (4.0 * time).sin();
    let act = |acting: Acting<'_, f64>| acting.force[0] = torque(acting.time);
    let system = EquationsOfMotion::new(&joint, &contacts, [0.1, 1.0], act).unwrap();
    let want = end(&system, vec![0.0; 6], 2.0, 1e-9);
    let error = |steps: u32| {
        let companions = contacts.map(|contact: Contact<f64, _>| contact.companion(1.0).unwrap());
        let mut states = companions.map(|companion| ContactState::new(&companion, 0.0));
        let mut motion = ElasticJointMotion { position: [0.0; 2], velocity: [0.0; 2] };
        let h = 2.0 / f64::from(steps);
        for n in 0..steps {
            let torques = [torque(h * (f64::from(n) + 0.5)), 0.0];
            let _ = joint.step(h, torques, &mut motion, &companions, &mut states, None);
        }
        largest_difference(motion.position.iter().chain(&motion.velocity), &want)
    };
    let (coarse, fine) = (error(4000), error(16000));
    assert!(fine < 1e-4 && coarse / fine > 10.0, "{coarse} {fine}");
}

#[test]
fn what_is_no_system_is_refused() {
    let (chain, contact) = (chain(), *friction().contact());
    let with = |contacts: &[_], magnitudes| {
        let act = |_: Acting<'_, f64>| ();
        EquationsOfMotion::new(&chain, contacts, magnitudes, act)?.with_longest_step(0.0).map(drop)
    };
    refused(with(&[contact; 3], [1.0, 1.0]), "there must be 2 contacts, not 3");
    refused(with(&[], [1.0, 1.0]), "there must be 2 contacts, not 0");
    refused(with(&[contact], [1.0, f64::NAN]), "magnitudes[1] is NaN");
    refused(with(&[contact], [1.0, 1.0]), "longest step is 0");
    let kinks = |kinks: Vec<f64>| {
        let act = |_: Acting<'_, f64>| ();
        EquationsOfMotion::new(&chain, &[contact], [1.0, 1.0], act)?.with_kinks(kinks).map(drop)
    };
    refused(kinks(vec![f64::NAN]), "kinks[0] is NaN");
    refused(
        kinks(vec![-1.0, 2.0, 2.0]),
        "kinks[2] is 2, but must be larger than its predecessor 2",
    );
    assert!(kinks(vec![]).is_ok() && kinks(vec![-1.0, 2.0]).is_ok());
}

/// A contact that carries nothing slides freely, whether it is lifted or has never been loaded.
#[test]
fn a_contact_without_load_does_nothing() {
    let (chain, contact) = (chain(), *friction().contact());
    let act = |acting: Acting<'_, f64>| acting.load.fill(0.0);
    let unloaded = [contact.model().under_load(0.0).unwrap()];
    let none = EquationsOfMotion::new(&chain, &unloaded, [0.1, 0.1], |_| ()).unwrap();
    let of_act = [contact];
    let lifted = EquationsOfMotion::new(&chain, &of_act, [0.1, 0.1], act).unwrap();
    // In its second mode, (1, 0, −1), at ω² = 2 with a damping of 0.02 ω²: x = e^(−0.02 t) cos ωₐt.
    let (decay, time) = (0.02_f64, 3.0_f64);
    let angular = (2.0 - decay * decay).sqrt();
    let (sin, cos) = (angular * time).sin_cos();
    let want = (-decay * time).exp() * (cos + decay / angular * sin);
    for system in [end(&lifted, start(), time, 1e-9), end(&none, start(), time, 1e-9)] {
        assert!((system[0] - want).abs() < 1e-8, "{} {want}", system[0]);
    }
    fn start() -> Vec<f64> {
        vec![1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    }
}
