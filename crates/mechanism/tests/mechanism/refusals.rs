//! What is refused, by name and value, and what is not.

use bristle::{Bristle, Dahl, DahlParameters, Mechanism, ParameterError};
use bristle_mechanism::{
    Block, Chain, ContactState, Coupling, Inputs, LinearMechanism, Matrices, Motion, Structure,
    on_ground, to_next,
};

type NoRows = [[(usize, f64); 1]; 0];
const NOTHING: NoRows = [];

fn dense(
    mass: [f64; 4],
    damping: [f64; 4],
    stiffness: [f64; 4],
) -> Result<LinearMechanism<f64, NoRows, Vec<f64>>, ParameterError> {
    let structure = Structure::Dense;
    let matrices = Matrices { structure, mass: &mass, damping: &damping, stiffness: &stiffness };
    LinearMechanism::on_heap(&matrices, NOTHING)
}

#[track_caller]
pub(crate) fn refused<V>(result: Result<V, ParameterError>, text: &str) {
    let message = result.map(drop).unwrap_err().to_string();
    assert!(message.starts_with(text), "{message}");
}

const ONE: [f64; 4] = [1.0, 0.0, 0.0, 1.0];
const ZERO: [f64; 4] = [0.0; 4];

#[test]
fn matrices_that_are_not_what_they_must_be_are_refused() {
    let negative = [1.0, 2.0, 2.0, 1.0];
    refused(dense([2.0, 2.0, 2.0, 2.0], ZERO, ZERO), "pivot of mass[1] is 0, but must be positive");
    refused(dense([1.0, 0.0, 0.0, 0.0], ZERO, ZERO), "mass[1] is 0, but must");
    refused(dense([1.0, 0.0, 0.0, f64::NAN], ZERO, ZERO), "mass[1] is NaN, but must");
    refused(
        dense(ONE, negative, ZERO),
        "entry of damping in row[1] is 2, but must be at most √(aᵢᵢ aⱼⱼ)",
    );
    refused(
        dense(ONE, [0.0, 1.0, 1.0, 1.0], ZERO),
        "entry of damping in row[1] is 1, but must be at most",
    );
    refused(dense(ONE, [-1.0, 0.0, 0.0, 1.0], ZERO), "damping[0] is -1, but must lie between");
    refused(
        dense(ONE, ZERO, [1.0, 0.5, 0.4, 1.0]),
        "entry of stiffness in row[1] is 0.4, but must equal",
    );
    refused(
        dense(ONE, ZERO, [1.0, f64::NAN, 0.0, 1.0]),
        "entry of stiffness in row[1] is NaN, but must",
    );
    refused(
        dense(ONE, ZERO, [1.0, 0.0, f64::INFINITY, 1.0]),
        "entry of stiffness in row[1] is inf, but must",
    );
    // Three springs whose sum has the eigenvalue −0.8: no pair of entries shows it.
    let row = [1.0, -0.9, -0.9, -0.9, 1.0, -0.9, -0.9, -0.9, 1.0];
    let matrices = |damping, stiffness| Matrices {
        structure: Structure::Dense,
        mass: &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        damping,
        stiffness,
    };
    let hidden = LinearMechanism::on_heap(&matrices(&[], &row), NOTHING);
    refused(hidden, "pivot of stiffness[2] is -");
    refused(LinearMechanism::on_heap(&matrices(&row, &[]), NOTHING), "pivot of damping[2] is -");
    let short = LinearMechanism::on_heap(&matrices(&[], &row[1..]), NOTHING);
    refused(short, "there must be 9 entries of stiffness, not 8");
    let oblong = Matrices { mass: &[1.0, 0.0, 1.0], ..matrices(&[], &[]) };
    refused(
        LinearMechanism::on_heap(&oblong, NOTHING),
        "number of entries of mass is 3, but must be n²: a dense matrix must be square",
    );
    let none = Matrices { mass: &[], ..matrices(&[], &[]) };
    refused(
        LinearMechanism::on_heap(&none, NOTHING),
        "of coordinates there must be at least 1, not 0",
    );
    let wide = Structure::Banded { half_bandwidth: usize::MAX };
    let wide = Matrices { structure: wide, ..matrices(&[], &[]) };
    assert!(LinearMechanism::on_heap(&wide, NOTHING).is_err());
    let small = LinearMechanism::new(&matrices(&[], &[]), NOTHING, [0.0; 41]);
    refused(small, "there must be at least 42 numbers of storage, not 41");
}

/// Eigenvalues of zero, zero stiffness, no contact, and a matrix that is symmetric to rounding.
#[test]
fn borders_are_accepted() {
    assert!(dense(ONE, ZERO, ZERO).is_ok());
    assert!(dense([1e-6, 0.0, 0.0, 1e6], [1.0, -1.0, -1.0, 1.0], [3.0, -3.0, -3.0, 3.0]).is_ok());
    assert!(dense(ONE, ZERO, [0.3, 0.1 + 0.2, 0.3, 0.3]).is_ok());
    let mut free = dense(ONE, ZERO, ZERO).unwrap();
    let (mut x, mut v) = ([0.0; 2], [1.0, 2.0]);
    let motion = Motion { position: &mut x, velocity: &mut v };
    free.step::<Dahl<f64>>(0.5, &Inputs::force(&[0.0, 1.0]), motion, &[], &mut []).unwrap();
    assert_eq!((x, v), ([0.5, 1.125], [1.0, 2.5]));
    let motion = Motion { position: &mut x, velocity: &mut v };
    free.step::<Dahl<f64>>(-0.5, &Inputs::force(&[0.0, 1.0]), motion, &[], &mut []).unwrap();
    assert!(x.iter().chain(&v).all(|x| x.is_nan()));
}

#[test]
fn contacts_on_nothing_are_refused() {
    let block = Block {
        to_ground: Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 },
        to_next: Coupling { stiffness: 1.0, damping: 0.0 },
    };
    let blocks = [block; 3];
    let chain = Chain { blocks: &blocks };
    let on = |row: [(usize, f64); 2]| chain.on_heap([on_ground(0), row]);
    refused(on([(0, 0.0), (1, 0.0)]), "largest factor of contact[1] is 0, but must be positive");
    refused(on(on_ground(3)), "coordinate of contact[1] is 3, but must be below coordinates = 3");
    refused(on(to_next(2)), "coordinate of contact[1] is 3, but must be below coordinates = 3");
    refused(on([(0, f64::NAN), (1, 1.0)]), "factor of contact[1] is NaN, but must");
    let far = "distance of the coordinates of contact[1] is 2, but must be at most half_bandwidth";
    refused(on([(0, 1.0), (2, 1.0)]), far);
    let empty: Vec<[(usize, f64); 0]> = vec![[]];
    refused(chain.on_heap(empty), "largest factor of contact[0] is 0, but must be positive");
    let mut soft = blocks;
    soft[1].to_next.stiffness = -1.0;
    let chain = Chain { blocks: &soft };
    refused(chain.on_heap(NOTHING), "coupling stiffness of block[1] is -1, but must");
    soft[1] = Block { to_ground: Mechanism { mass: 0.0, ..block.to_ground }, ..block };
    refused(Chain { blocks: &soft }.on_heap(NOTHING), "mass[1] is 0, but must");
    refused(
        Chain::<f64> { blocks: &[] }.on_heap(NOTHING),
        "of blocks there must be at least 1, not 0",
    );
}

/// A step that is refused has moved nothing; NaN in gives NaN out.
#[test]
fn a_step_refuses_lengths_alone() {
    let parameters = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e3 };
    let friction = Dahl::new(parameters).unwrap();
    let loaded = friction.under_load(1.0).unwrap().companion(1.0).unwrap();
    let unloaded = friction.under_load(0.0).unwrap().companion(1.0).unwrap();
    let matrices =
        Matrices { structure: Structure::Diagonal, mass: &[1.0], damping: &[], stiffness: &[] };
    let mut mechanism = LinearMechanism::on_heap(&matrices, [[(0, 1.0)], [(0, 2.0)]]).unwrap();
    let companions = [loaded, unloaded];
    let start = companions.map(|companion| ContactState::new(&companion, 1e-4));
    let (mut contacts, mut x, mut v) = (start, [0.1_f64], [0.2_f64]);
    let mut step = |h: f64, force: &[f64], prescribed: &[f64], load: &[f64]| {
        if v[0].is_nan() {
            (contacts, x, v) = (start, [0.1], [0.2]);
        }
        let motion = Motion { position: &mut x, velocity: &mut v };
        let inputs = Inputs { force, prescribed, load };
        let done = mechanism.step(h, &inputs, motion, &companions, &mut contacts);
        done.map(|()| (v[0], contacts[0].deflection()))
    };
    refused(step(0.1, &[], &[], &[]), "of forces there must be 1, not 0");
    refused(step(0.1, &[0.0], &[1.0], &[]), "there must be 2 prescribed velocities, not 1");
    refused(step(0.1, &[0.0], &[], &[1.0]), "there must be 2 loads, not 1");
    // As one that was not asked before.
    let (x, v) = (&mut [0.1], &mut [0.2]);
    let (mut untouched, inputs) = (start, Inputs::force(&[0.0]));
    let mut other = LinearMechanism::on_heap(&matrices, [[(0, 1.0)], [(0, 2.0)]]).unwrap();
    let motion = Motion { position: x, velocity: v };
    other.step(0.1, &inputs, motion, &companions, &mut untouched).unwrap();
    let (long, mut with) = (&mut [0.0; 2], untouched);
    let motion = Motion { position: long, velocity: &mut [0.2] };
    let done = other.step(0.1, &inputs, motion, &companions, &mut with);
    refused(done, "of positions there must be 1, not 2");
    let motion = Motion { position: &mut [0.1], velocity: long };
    let done = other.step(0.1, &inputs, motion, &companions, &mut with);
    refused(done, "of velocities there must be 1, not 2");
    assert_eq!(step(0.1, &[0.0], &[], &[]).unwrap(), (v[0], untouched[0].deflection()));

    let nan = f64::NAN;
    let mut lost = |h, force, prescribed, load: &[f64]| {
        let (velocity, _) = step(h, &[force], &[0.0, prescribed], load).unwrap();
        velocity.is_nan()
    };
    assert!(!lost(0.1, 0.0, 0.0, &[1.0, 0.0]));
    assert!(lost(-0.1, 0.0, 0.0, &[]) && lost(nan, 0.0, 0.0, &[]));
    assert!(lost(0.1, nan, 0.0, &[]) && lost(0.1, 0.0, nan, &[]));
    for load in [[-1.0, 0.0], [nan, 0.0], [f64::INFINITY, 0.0], [1.0, nan], [1.0, 1.0]] {
        assert!(lost(0.1, 0.0, 0.0, &load), "{load:?}"); // the second is built without a load
    }
}
