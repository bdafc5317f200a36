//! One motion, whatever the structure and the storage, and steps of contacts of one's own.

use bristle::companion::{PointMass, VelocityHistory};
use bristle::curve::Stribeck;
use bristle::nalgebra::DMatrix as Matrix;
use bristle::rheology::KelvinVoigt;
use bristle::{Bristle, Dahl, DahlParameters, ElastoPlastic, Scalar, paper};
use bristle_mechanism::{
    ContactState, Inputs, LinearMechanism, Matrices, Motion, Sources, Structure,
};
use bristle_plane::{PlaneBristle, PlaneFrBd};
use bristle_specimens::draw::Draw;
use bristle_specimens::lit;

use crate::energy::Random;
use crate::reference::{ROWS, STIFFNESS, chain, dense, friction, run};

const IDENTITY: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

#[test]
fn bits_are_those_of_sizes_known_at_run_time() {
    let damping = STIFFNESS.map(|row| row.map(|k| 0.02 * k));
    let matrices = Matrices {
        structure: Structure::Dense,
        mass: &IDENTITY,
        damping: damping.as_flattened(),
        stiffness: STIFFNESS.as_flattened(),
    };
    // What was in the storage before does not count.
    let storage = [f64::NAN; Structure::Dense.storage(3, 2)];
    let mut fixed = LinearMechanism::new(&matrices, ROWS, storage).unwrap();
    let rows: Vec<Vec<_>> = ROWS.iter().map(|row| row.to_vec()).collect();
    assert_eq!(run(&mut fixed, 4), run(&mut dense(rows), 4));
}

/// The mode shapes of three equal masses between walls.
#[test]
fn modes_a_band_and_full_matrices_move_alike() {
    let shapes: [[f64; 3]; 3] = core::array::from_fn(|mode| {
        core::array::from_fn(|i| {
            let angle = std::f64::consts::PI * ((mode + 1) * (i + 1)) as f64 / 4.0;
            0.5_f64.sqrt() * angle.sin()
        })
    });
    let stiffness: [f64; 3] = core::array::from_fn(|mode| {
        let angle = std::f64::consts::PI * (mode + 1) as f64 / 4.0;
        2.0 - 2.0 * angle.cos()
    });
    let matrices = Matrices {
        structure: Structure::Diagonal,
        mass: &[1.0; 3],
        damping: &stiffness.map(|k| 0.02 * k),
        stiffness: &stiffness,
    };
    let rows = [0, 1].map(|contact| {
        [0, 1, 2].map(|mode| {
            let first = if contact == 0 { 0.0 } else { shapes[mode][0] };
            (mode, shapes[mode][contact] - first)
        })
    });
    let mut modal = LinearMechanism::on_heap(&matrices, rows).unwrap();
    let companions = [crate::reference::friction(); 2];
    let mut contacts = companions.map(|companion| ContactState::new(&companion, 0.0));
    let (mut position, mut velocity, h) = ([0.0; 3], [0.0; 3], 0.05);
    for n in 0..400 {
        let force = (1.2 * h * (f64::from(n) + 0.5)).cos();
        let force = shapes.map(|shape| shape[1] * force);
        let motion = Motion { position: &mut position, velocity: &mut velocity };
        modal.step(h, &Inputs::force(&force), motion, &companions, &mut contacts).unwrap();
    }
    let masses = |modal: [f64; 3]| -> Vec<f64> {
        (0..3).map(|i| (0..3).map(|mode| shapes[mode][i] * modal[mode]).sum()).collect()
    };
    let deflections = contacts.iter().map(ContactState::deflection).collect();
    let modal = [masses(position), masses(velocity), deflections];
    let (dense, band) = (run(&mut dense(ROWS), 1), run(&mut chain(), 1));
    for (dense, others) in
        dense.iter().flatten().zip(modal.iter().flatten().zip(band.iter().flatten()))
    {
        // 400 steps of a stable motion, a few roundings each.
        assert!((dense - others.0).abs() < 1e-13 && (dense - others.1).abs() < 1e-13);
    }
}

#[test]
fn random_bands_move_as_full_matrices() {
    let mut draw = Draw::seeded(14);
    for case in 0..1000 {
        let random = Random::new(&mut draw);
        let n = random.coordinates;
        let force: Vec<_> = (0..n).map(|_| draw.next()).collect();
        let velocity: Vec<_> = (0..n).map(|_| draw.next() - 0.5).collect();
        let position: Vec<_> = (0..n).map(|_| draw.next() - 0.5).collect();
        let h = draw.logarithmic(1e-4, 1e-1);
        let ends = [false, true].map(|banded| {
            let mut mechanism = random.mechanism(banded);
            let (mut x, mut v) = (position.clone(), velocity.clone());
            let new = |companion| ContactState::new(companion, 0.0);
            let mut contacts: Vec<_> = random.companions.iter().map(new).collect();
            let motion = Motion { position: &mut x, velocity: &mut v };
            let inputs = Inputs::force(&force);
            mechanism.step(h, &inputs, motion, &random.companions, &mut contacts).unwrap();
            v
        });
        let size = ends[0].iter().fold(1.0_f64, |most, v| most.max(v.abs()));
        for (full, band) in ends[0].iter().zip(&ends[1]) {
            // Roundings times the condition numbers of A and of the contacts, some 1e5.
            assert!((full - band).abs() <= 1e-11 * size, "{case}: {full} {band}");
        }
    }
}

/// With one mass and one contact it is the step of a point mass under a load that varies, in either
/// scalar type.
#[test]
fn one_contact_on_one_mass_is_a_point_mass() {
    fn off<T: Scalar>() -> T {
        let t = lit::<T>;
        let parameters = DahlParameters { dynamic_coefficient: t(0.5), micro_stiffness: t(1000.0) };
        let friction = Dahl::new(parameters).unwrap().under_load(t(2.0)).unwrap();
        let companion = friction.companion(t(1.0)).unwrap();
        let mut reloaded = companion;
        let (mass, h) = ([t(1.5)], t(0.01));
        let matrices =
            Matrices { structure: Structure::Diagonal, mass: &mass, damping: &[], stiffness: &[] };
        let storage = [T::zero(); Structure::Diagonal.storage(1, 1)];
        let rows = [[(0, T::one())]];
        let mut mechanism = LinearMechanism::new(&matrices, rows, storage).unwrap();
        let (mut x, mut v) = ([T::zero()], [t(0.3)]);
        let mut contacts = [ContactState::new(&companion, T::zero())];
        let (mut velocity, mut z) = (v[0], T::zero());
        let mut history = VelocityHistory::new(velocity);
        let (mut most, mut slipped) = (T::zero(), T::zero());
        for n in 0..300 {
            let force = t((0.05 * f64::from(n)).sin() * 1.6);
            let load = t(1.8 + 1.5 * (0.3 * f64::from(n)).cos());
            let left = reloaded.reload(load, history.predict(), z).unwrap();
            slipped += left.dissipated;
            let step = reloaded.step(history.predict(), left.deflection, h);
            let mass = PointMass { mass: mass[0], velocity, force, end_weight: t(0.5) };
            let mean = step.point_mass(mass);
            (velocity, z) = (t(2.0) * mean - velocity, step.commit(mean).deflection);
            history.push(velocity);
            let motion = Motion { position: &mut x, velocity: &mut v };
            let (force, load) = ([force], [load]);
            let inputs = Inputs { load: &load, ..Inputs::force(&force) };
            mechanism.step(h, &inputs, motion, &[companion], &mut contacts).unwrap();
            most = most.larger((v[0] - velocity).abs());
        }
        assert!(velocity.abs() > t(1e-3) && slipped > t(1e-6));
        most / T::default_epsilon()
    }
    // Some roundings of 0.3 m/s a step, which friction forgets.
    assert!(off::<f64>() < 30.0 && off::<f32>() < 30.0, "{} {}", off::<f64>(), off::<f32>());
}

/// The sums of one coordinate with one contact are those of many.
#[test]
fn one_contact_on_one_mass_moves_as_beside_another_one() {
    fn run<const N: usize>(structure: Structure) -> [Vec<[f64; 6]>; N] {
        let [mass, damping, stiffness] = [1.3, 0.07, 21.0].map(|value| match structure {
            Structure::Dense => Matrix::from_diagonal_element(N, N, value).as_slice().to_vec(),
            _ => vec![value; N],
        });
        let matrices =
            Matrices { structure, mass: &mass, damping: &damping, stiffness: &stiffness };
        let rows: Vec<_> = (0..N).map(|i| [(i, 1.5), (i, -0.6)]).collect();
        let mut mechanism = LinearMechanism::on_heap(&matrices, rows).unwrap();
        let (mut x, mut v) = ([0.02; N], [0.3; N]);
        let mut contacts = [ContactState::new(&friction(), 0.0); N];
        let mut states = [const { Vec::new() }; N];
        for n in 0..500 {
            let wave = |rate: f64| (rate * f64::from(n)).sin();
            let [force, belt, load] =
                [1.6 * wave(0.05), 0.1 * wave(0.11), 0.1 + 0.1 * wave(0.3)].map(|one| [one; N]);
            let inputs = match n {
                0..100 => Inputs::force(&force),
                _ => Inputs { force: &force, prescribed: &belt, load: &load },
            };
            let h = if n < 400 { 0.01 } else { 0.02 };
            let motion = Motion { position: &mut x, velocity: &mut v };
            mechanism.step(h, &inputs, motion, &[friction()], &mut contacts).unwrap();
            for (i, states) in states.iter_mut().enumerate() {
                let done = contacts[i].last_step();
                let mean = mechanism.mean_velocities()[i];
                states.push([x[i], v[i], mean, done.deflection, done.force, done.dissipated]);
            }
        }
        states
    }
    for structure in [Structure::Diagonal, Structure::Dense] {
        let ([alone], [one, other]) = (run::<1>(structure), run::<2>(structure));
        assert!(alone == one && one == other, "{structure:?}");
        assert!(alone.iter().flatten().all(|value| value.is_finite()));
    }
}

/// A block that slides and spins: a contact of three axes is three rows.
#[test]
fn a_contact_in_a_plane_takes_a_row_for_each_axis() {
    use bristle::nalgebra::Vector3;
    let curve = Stribeck::new(paper::STICK_SLIP_CURVE).unwrap();
    let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE).unwrap();
    let friction = PlaneFrBd::<_, _, 3>::isotropic(curve, bristle).under_load(1.0).unwrap();
    let companion = friction.companion(1.0).unwrap();
    let mass = Vector3::new(1.0, 1.0, 0.5);
    let matrices = Matrices {
        structure: Structure::Diagonal,
        mass: mass.as_slice(),
        damping: &[],
        stiffness: &[],
    };
    let rows = [0, 1, 2].map(|axis| [(axis, 1.0)]);
    let storage = [0.0; Structure::Diagonal.storage(3, 3)];
    let mut mechanism = LinearMechanism::new(&matrices, rows, storage).unwrap();
    let (mut x, mut v) = ([0.0; 3], [0.3, 0.1, -0.2]);
    let (mut z, mut velocity, h) = (Vector3::zeros(), Vector3::from(v), 0.01);
    let force = Vector3::new(0.03, 0.07, -0.01);
    for _ in 0..100 {
        let step = companion.step(&velocity, &z, h);
        let want =
            step.point_mass(PointMass { mass, velocity, force, end_weight: Vector3::repeat(0.5) });
        let (bias, damping) = (step.bias(), step.damping());
        let mut sliding: Vector3<f64> = velocity;
        let sources = Sources {
            bias: bias.as_slice(),
            damping: damping.as_slice(),
            sliding: sliding.as_mut_slice(),
        };
        let motion = Motion { position: &mut x, velocity: &mut v };
        mechanism.advance(h, force.as_slice(), motion, sources).unwrap();
        z = step.commit(&sliding).deflection;
        velocity = Vector3::from(v);
        assert!((sliding - want).norm() < 1e-15); // 0.3 m/s
    }
    assert!(velocity.norm() < 1e-3); // it came to rest
}

#[test]
fn one_companion_serves_all_contacts() {
    let friction = crate::reference::friction();
    let ends = [&[friction] as &[_], &[friction; 2]].map(|companions| {
        let mut contacts = [ContactState::new(&friction, 0.0); 2];
        let (mut x, mut v) = ([0.1, 0.2, 0.3], [1.0, -1.0, 0.5]);
        for _ in 0..10 {
            let motion = Motion { position: &mut x, velocity: &mut v };
            let inputs = Inputs::force(&[0.0; 3]);
            chain().step(0.05, &inputs, motion, companions, &mut contacts).unwrap();
        }
        (x, v, contacts.map(|state| state.deflection()))
    });
    assert_eq!(ends[0], ends[1]);
    let (x, v) = (&mut [0.0; 3], &mut [0.0; 3]);
    let motion = Motion { position: x, velocity: v };
    let mut contacts = [ContactState::new(&friction, 0.0); 2];
    let inputs = Inputs::force(&[0.0; 3]);
    let refused = chain().step(0.05, &inputs, motion, &[friction; 3], &mut contacts).unwrap_err();
    assert_eq!(refused.to_string(), "there must be 2 companions, not 3");
}

/// Matrices that change are those of a new mechanism.
#[test]
fn a_mechanism_that_changes_is_a_new_one() {
    let matrices = |mass| Matrices {
        structure: Structure::Dense,
        mass,
        damping: &[],
        stiffness: STIFFNESS.as_flattened(),
    };
    let heavy = IDENTITY.map(|m| 3.0 * m);
    let turned = [[(2, 0.5), (1, 1.0)], [(0, -1.0), (1, 1.0)]];
    let mut changed = LinearMechanism::on_heap(&matrices(&IDENTITY), ROWS).unwrap();
    let before = run(&mut changed, 1);
    changed.change(&matrices(&heavy), turned).unwrap();
    let after = run(&mut changed, 1);
    let mut new = LinearMechanism::on_heap(&matrices(&heavy), turned).unwrap();
    assert_eq!(after, run(&mut new, 1));
    assert_ne!(before, after);
}

/// Another length of the step factors A anew, and steps allocate nothing.
#[test]
fn steps_of_any_length_do_not_allocate() {
    let (friction, mut chain, mut dense) = (crate::reference::friction(), chain(), dense(ROWS));
    let companions = [friction; 2];
    let ends = [1.0, 0.3].map(|h: f64| {
        let mut ends = [[0.0; 3]; 2];
        let counted = allocation_counter::measure(|| {
            for (end, banded) in ends.iter_mut().zip([false, true]) {
                let mut contacts = companions.map(|friction| ContactState::new(&friction, 0.0));
                let (mut x, inputs) = ([0.1; 3], Inputs::force(&[1.0; 3]));
                let motion = Motion { position: &mut x, velocity: end };
                let done = match banded {
                    false => dense.step(h, &inputs, motion, &companions, &mut contacts),
                    true => chain.step(h, &inputs, motion, &companions, &mut contacts),
                };
                assert!(done.is_ok());
            }
        });
        assert_eq!(counted.count_total, 0);
        ends
    });
    for [full, band] in ends {
        assert!(full.iter().zip(band).all(|(a, b)| (a - b).abs() < 1e-14)); // 1 m/s
    }
    assert!((ends[0][0][2] - ends[1][0][2]).abs() > 0.01, "{ends:?}");
}

/// The deflection in the middle of a step is predicted, too, for models that switch with it.
#[test]
fn an_elasto_plastic_contact_is_of_second_order() {
    let curve = Stribeck::new(paper::STICK_SLIP_CURVE).unwrap();
    let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE).unwrap();
    let friction = ElastoPlastic::new(curve, bristle, 3e-5).unwrap().under_load(1.0).unwrap();
    let companion = friction.companion(1.0).unwrap();
    let matrices = Matrices {
        structure: Structure::Diagonal,
        mass: &[1.0],
        damping: &[],
        stiffness: &[100.0],
    };
    let end = |steps: u32| {
        let mut mechanism = LinearMechanism::on_heap(&matrices, [[(0, 1.0)]]).unwrap();
        let (mut x, mut v) = ([0.0], [0.0]);
        let (mut contacts, h) = ([ContactState::new(&companion, 0.0)], 0.5 / f64::from(steps));
        for n in 0..steps {
            let motion = Motion { position: &mut x, velocity: &mut v };
            let force = [1.2 * (20.0 * h * (f64::from(n) + 0.5)).sin()];
            let inputs = Inputs::force(&force);
            mechanism.step(h, &inputs, motion, &[companion], &mut contacts).unwrap();
        }
        x[0] + contacts[0].deflection()
    };
    // A stuck mass that oscillates with 100 rad/s between elastic and yielding.
    let errors = [256, 1024].map(|steps| (end(steps) - end(65_536)).abs());
    let order = (errors[0] / errors[1]).log(4.0);
    assert!(order > 1.7, "{order} {errors:?}");
}

/// After an impact nothing is extrapolated across it: the next step is that of a contact that has
/// not moved yet.
#[test]
fn a_contact_that_forgets_its_velocity_steps_as_a_new_one() {
    let (companions, mut position) = ([friction(); 2], [0.1, 0.0, -0.2]);
    let mut contacts = companions.map(|companion| ContactState::new(&companion, 0.0));
    let mut mechanism = dense(ROWS);
    let mut step = |velocity: &mut [f64; 3], contacts: &mut [ContactState<f64>; 2]| {
        let motion = Motion { position: &mut position, velocity };
        let inputs = Inputs::force(&[0.5, 0.0, 0.0]);
        mechanism.step(0.05, &inputs, motion, &companions, contacts).unwrap();
        position = [0.1, 0.0, -0.2];
        contacts.each_ref().map(|contact| contact.last_step().force)
    };
    let mut moving = [0.3, -0.1, 0.2];
    (0..3).for_each(|_| _ = step(&mut moving, &mut contacts));
    let struck = [0.9, -0.5, 0.2];
    let mut new = contacts.each_ref().map(|c| ContactState::new(&companions[0], c.deflection()));
    let extrapolated = step(&mut struck.clone(), &mut contacts.clone());
    contacts.iter_mut().for_each(ContactState::forget_velocity);
    let forces = step(&mut struck.clone(), &mut contacts);
    assert_eq!(forces, step(&mut struck.clone(), &mut new));
    assert_ne!(forces, extrapolated);
}
