//! Three masses between walls, with friction to the ground and between the first two: the motion
//! that two integrators of high order agree on.

use bristle::companion::Companion;
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, FrBd, Mechanism};
use bristle_mechanism::{
    Block, Chain, ContactState, Coupling, Inputs, LinearMechanism, Matrices, Motion, Rows,
    Structure, on_ground, to_next,
};

pub(crate) type Friction = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;
pub(crate) const STIFFNESS: [[f64; 3]; 3] = [[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]];
pub(crate) type TwoRows = [[(usize, f64); 2]; 2];
pub(crate) const ROWS: TwoRows = [[(0, 1.0), (0, 0.0)], [(0, -1.0), (1, 1.0)]];

/// State at t = 20 s: x [m], v [m/s], z [m].
const POSITION: [f64; 3] = [-0.22505770761, -0.29653210404, -0.46710691334];
const VELOCITY: [f64; 3] = [0.12573074125, 0.22050196318, 0.16293919841];
const DEFLECTION: [f64; 2] = [-0.01989800196, -0.01349918664];

pub(crate) fn friction() -> Companion<f64, Friction> {
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: 1.3,
        dynamic_coefficient: 1.0,
        stribeck_velocity: 0.1,
        stribeck_exponent: 2.0,
        viscous_friction: 0.0,
    });
    let bristle = KelvinVoigtParameters { micro_stiffness: 20.0, micro_damping: 0.2 };
    let model = FrBd::new(curve.unwrap(), KelvinVoigt::new(bristle).unwrap());
    model.under_load(1.0).unwrap().companion(1.0).unwrap()
}

/// x, v and z after 20 s, in steps of a 20th of a second over a divisor.
pub(crate) fn run<R, S>(mechanism: &mut LinearMechanism<f64, R, S>, divisor: u32) -> [Vec<f64>; 3]
where
    R: Rows<f64>,
    S: AsRef<[f64]> + AsMut<[f64]>,
{
    let companions = [friction(); 2];
    let mut contacts = companions.map(|companion| ContactState::new(&companion, 0.0));
    let (mut position, mut velocity, h) = ([0.0; 3], [0.0; 3], 0.05 / f64::from(divisor));
    for n in 0..400 * divisor {
        let force = [0.0, (1.2 * h * (f64::from(n) + 0.5)).cos(), 0.0];
        let motion = Motion { position: &mut position, velocity: &mut velocity };
        mechanism.step(h, &Inputs::force(&force), motion, &companions, &mut contacts).unwrap();
    }
    let deflections = contacts.iter().map(ContactState::deflection).collect();
    [position.to_vec(), velocity.to_vec(), deflections]
}

pub(crate) fn dense<R: Rows<f64>>(rows: R) -> LinearMechanism<f64, R, Vec<f64>> {
    let damping = STIFFNESS.map(|row| row.map(|k| 0.02 * k));
    LinearMechanism::on_heap(
        &Matrices {
            structure: Structure::Dense,
            mass: &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            damping: damping.as_flattened(),
            stiffness: STIFFNESS.as_flattened(),
        },
        rows,
    )
    .unwrap()
}

pub(crate) fn chain() -> LinearMechanism<f64, TwoRows, Vec<f64>> {
    let block = |wall: f64| Block {
        to_ground: Mechanism { mass: 1.0, spring_stiffness: wall, viscous_damping: 0.02 * wall },
        to_next: Coupling { stiffness: 1.0, damping: 0.02 },
    };
    Chain { blocks: &[block(1.0), block(0.0), block(1.0)] }
        .on_heap([on_ground(0), to_next(0)])
        .unwrap()
}

/// The largest error of position, velocity and deflection.
pub(crate) fn error([position, velocity, deflection]: &[Vec<f64>; 3]) -> f64 {
    let off = |got: &[f64], want: &[f64]| {
        got.iter().zip(want).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
    };
    off(position, &POSITION).max(off(velocity, &VELOCITY)).max(off(deflection, &DEFLECTION))
}

/// The errors that a prototype of another prediction had are 5.0e-3, 1.24e-3, 2.9e-4, 6.6e-5.
#[test]
fn steps_reach_the_reference_with_order_two() {
    let errors = [1, 2, 4, 8].map(|divisor| error(&run(&mut dense(ROWS), divisor)));
    for (error, known) in errors.into_iter().zip([5.0e-3, 1.24e-3, 2.9e-4, 6.65e-5]) {
        assert!(error <= known && error > 0.85 * known, "{errors:?}");
    }
    // A kink moves through the steps: the order is that of the whole, not of each halving.
    let order = (errors[0] / errors[3]).log2() / 3.0;
    assert!((order - 2.0).abs() < 0.1, "{order}");
}

/// Error 6.6e-5 / 4ⁿ after n more halvings.
#[test]
fn short_steps_reach_the_digits_of_the_reference() {
    assert!(error(&run(&mut chain(), 256)) < 1e-7);
}
