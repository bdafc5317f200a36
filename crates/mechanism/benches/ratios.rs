//! What a step of a mechanism costs beside the companion steps of its contacts alone, all within
//! one run: `cargo bench -p bristle-mechanism --bench ratios`.
//!
//! Friction is that of the paper's Table 2, sliding in the middle of the Stribeck range where the
//! curve needs its exponential. Of a contact and its mass alone each step waits for the one before;
//! contacts side by side do not wait for each other. Every line is the best of many rounds, and
//! lines take turns, so that other load of the machine affects them alike.

use std::hint::black_box;
use std::time::Instant;

use bristle::companion::{Companion, CompletedStep, PointMass, VelocityHistory};
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::scalar::lit;
use bristle::{Bristle, FrBd, Mechanism, ParameterError, Scalar, paper};
use bristle_mechanism::gradient::{ArmAdjoint, ArmState, ContactAdjoint, backwards};
use bristle_mechanism::{
    Arm, ArmMiddle, ArmMotion, ArmParameters, Block, Chain, ContactState, Coupling, Inputs,
    LinearMechanism, Link, Matrices, Motion, Rows, Structure, on_ground, on_joint,
};
use num_dual::DualSVec64;

type Friction = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;

const ROUNDS: usize = 1000;
/// Length of a step [s], mean velocity [m/s] and force [N] that keeps it up.
const STEP: f64 = 1e-3;
const SPEED: f64 = 0.008;
const FORCE: f64 = 1.2637;

/// Nanoseconds of the best round so far.
struct Best(f64);

impl Best {
    fn time(&mut self, steps: usize, mut work: impl FnMut()) {
        let start = Instant::now();
        (0..steps).for_each(|_| work());
        self.0 = self.0.min(start.elapsed().as_secs_f64() * 1e9 / steps as f64);
    }
}

/// Independent masses with a contact each, and the account of its step.
struct Alone {
    companion: Companion<f64, Friction>,
    velocities: Vec<f64>,
    accounts: Vec<CompletedStep<f64>>,
    histories: Vec<VelocityHistory<f64>>,
}

/// Every round begins here, so that all stay where the curve needs its exponential.
const DEFLECTION: f64 = 1.25e-4;

impl Alone {
    fn new(companion: Companion<f64, Friction>, count: usize) -> Self {
        let histories = vec![VelocityHistory::new(SPEED); count];
        let account = companion.step(SPEED, DEFLECTION, STEP).commit(SPEED);
        let account = CompletedStep { deflection: DEFLECTION, ..account };
        let (velocities, accounts) = (vec![SPEED; count], vec![account; count]);
        Self { companion, velocities, accounts, histories }
    }

    fn reset(&mut self) {
        *self = Self::new(self.companion, self.velocities.len());
    }

    fn step(&mut self, energies: bool) {
        match energies {
            true => self.each(|done, account| *account = done),
            false => self.each(|done, account| account.deflection = done.deflection),
        }
    }

    fn each(&mut self, keep: impl Fn(CompletedStep<f64>, &mut CompletedStep<f64>)) {
        let masses = self.velocities.iter_mut().zip(&mut self.accounts).zip(&mut self.histories);
        for ((velocity, account), history) in masses {
            let step = self.companion.step(history.predict(), account.deflection, STEP);
            let mean = step.point_mass(PointMass {
                mass: 1.0,
                velocity: *velocity,
                force: FORCE,
                end_weight: 0.5,
            });
            keep(step.commit(mean), account);
            *velocity = 2.0 * mean - *velocity;
            history.push(*velocity);
        }
    }
}

/// A mechanism and its state.
struct Coupled<R, S> {
    mechanism: LinearMechanism<f64, R, S>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    force: Vec<f64>,
    companions: Vec<Companion<f64, Friction>>,
    contacts: Vec<ContactState<f64>>,
    missing: f64,
}

impl<R: Rows<f64>, S: AsRef<[f64]> + AsMut<[f64]>> Coupled<R, S> {
    fn new(
        mechanism: LinearMechanism<f64, R, S>,
        companion: Companion<f64, Friction>,
        velocity: f64,
        force: f64,
    ) -> Self {
        let (n, m) = (mechanism.coordinates(), mechanism.rows().contacts());
        Self {
            mechanism,
            position: vec![0.0; n],
            velocity: vec![velocity; n],
            force: vec![force; n],
            companions: vec![companion],
            contacts: vec![ContactState::new(&companion, DEFLECTION); m],
            missing: 0.0,
        }
    }

    fn reset(&mut self, velocity: f64) {
        self.position.fill(0.0);
        self.velocity.fill(velocity);
        self.contacts.fill(ContactState::new(&self.companions[0], DEFLECTION));
    }

    fn step(&mut self, energies: bool) {
        let motion = Motion { position: &mut self.position, velocity: &mut self.velocity };
        let inputs = Inputs::force(&self.force);
        let done = self.mechanism.step(STEP, &inputs, motion, &self.companions, &mut self.contacts);
        black_box(done.is_ok());
        if energies {
            for contact in &self.contacts {
                let CompletedStep { work, stored, dissipated, .. } = contact.last_step();
                self.missing += work - stored - dissipated;
            }
        }
    }
}

fn main() -> Result<(), ParameterError> {
    let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
    let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
    let companion = FrBd::new(curve, bristle).under_load(1.0)?.companion(1.0)?;

    let matrices =
        Matrices { structure: Structure::Dense, mass: &[1.0], damping: &[], stiffness: &[] };
    let storage = [0.0; Structure::Dense.storage(1, 1)];
    let one = LinearMechanism::new(&matrices, [[(0, 1.0)]], storage)?;
    let (mut one, mut alone) =
        (Coupled::new(one, companion, SPEED, FORCE), Alone::new(companion, 1));

    let block = Block {
        to_ground: Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 },
        to_next: Coupling { stiffness: 100.0, damping: 0.1 },
    };
    let rows: Vec<_> = (0..1000).map(on_ground).collect();
    let chain = Chain { blocks: &[block; 1000] }.on_heap(rows)?;
    let mut chain = Coupled::new(chain, companion, SPEED, FORCE);
    let mut blocks = Alone::new(companion, 1000);

    // A string of 100 modes, bowed at a seventh of its length.
    let modes: Vec<f64> = (1..=100).map(f64::from).collect();
    let stiffness: Vec<f64> = modes.iter().map(|n| (30.0 * n).powi(2)).collect();
    let damping: Vec<f64> = modes.iter().map(|n| 0.2 + 0.01 * n).collect();
    let shape = |n: &f64| (n * std::f64::consts::PI / 7.0).sin();
    let row: Vec<_> = modes.iter().map(shape).enumerate().collect();
    let matrices = Matrices {
        structure: Structure::Diagonal,
        mass: &[1.0; 100],
        damping: &damping,
        stiffness: &stiffness,
    };
    let string = LinearMechanism::on_heap(&matrices, [row])?;
    let mut string = Coupled::new(string, companion, 1e-3, 0.0);

    println!("                                             ns a step   ratio");
    for energies in [false, true] {
        let mut best = [(); 5].map(|()| Best(f64::INFINITY));
        for _ in 0..ROUNDS {
            alone.reset();
            best[0].time(200, || alone.step(energies));
            one.reset(SPEED);
            best[1].time(200, || one.step(energies));
            blocks.reset();
            best[2].time(5, || blocks.step(energies));
            chain.reset(SPEED);
            best[3].time(5, || chain.step(energies));
            string.reset(1e-3);
            best[4].time(100, || string.step(energies));
        }
        let [alone, one, blocks, chain, string] = best.map(|best| best.0);
        println!("{}", if energies { "with the energies of each step" } else { "motion alone" });
        println!("mass and contact alone                       {alone:9.1}");
        println!("the same as a mechanism                      {one:9.1}   {:5.2}", one / alone);
        println!("1000 masses and contacts alone               {blocks:9.1}");
        let ratio = chain / blocks;
        println!("1000 blocks in a chain                       {chain:9.1}   {ratio:5.2}");
        let ratio = string / alone;
        println!("100 modes, one contact                       {string:9.1}   {ratio:5.2}");
    }
    black_box([one.missing, chain.missing, string.missing]);
    gradient(companion)
}

const JOINTS: usize = 7;

/// An arm of seven joints, 42 friction parameters, driven to and fro: half a second at a time, so
/// that other load of the machine is left out.
#[derive(Clone, Copy)]
struct Swing {
    motion: [[f64; JOINTS]; 3],
    contacts: [ContactState<f64>; JOINTS],
}

fn swing<T: Scalar>(n: usize, middle: ArmMiddle<'_, T>) {
    let time = STEP * (n as f64 + 0.5);
    for (i, torque) in middle.torque.iter_mut().enumerate() {
        *torque = lit(4.0 / (1.0 + i as f64) * (3.0 * time + i as f64).sin());
    }
}

fn arm<T: Scalar>() -> Result<SevenJoints<T>, ParameterError> {
    let [mass, length, centre] = [1.0, 0.2, 0.1].map(lit);
    let [inertia, rotor, damping] = [0.003, 0.02, 0.05].map(lit);
    let link = Link { mass, length, centre, inertia, rotor, damping };
    let parameters = ArmParameters { links: &[link; JOINTS], gravity: lit(9.81) };
    Arm::on_heap(&parameters, std::array::from_fn(on_joint))
}

type SevenJoints<T> = Arm<T, [[(usize, T); 1]; JOINTS], Vec<T>>;
/// Derivatives by the six parameters of a joint at once.
type Dual = DualSVec64<6>;

/// A simulation whose first joint has the parameters of the others, seeded.
fn dual(steps: usize) -> Result<Dual, ParameterError> {
    let StribeckParameters { static_coefficient, dynamic_coefficient, .. } =
        paper::STICK_SLIP_CURVE;
    let StribeckParameters { stribeck_velocity, viscous_friction, .. } = paper::STICK_SLIP_CURVE;
    let KelvinVoigtParameters { micro_stiffness, micro_damping } = paper::STICK_SLIP_BRISTLE;
    let values = [
        static_coefficient,
        dynamic_coefficient,
        stribeck_velocity,
        viscous_friction,
        micro_stiffness,
        micro_damping,
    ];
    let companion = |seeded: bool| {
        let seed = |i: usize| {
            let value = Dual::from_re(values[i]);
            if seeded { value.derivative(i) } else { value }
        };
        let curve = Stribeck::new(StribeckParameters {
            static_coefficient: seed(0),
            dynamic_coefficient: seed(1),
            stribeck_velocity: seed(2),
            stribeck_exponent: Dual::from_re(paper::STICK_SLIP_CURVE.stribeck_exponent),
            viscous_friction: seed(3),
        })?;
        let bristle = KelvinVoigtParameters { micro_stiffness: seed(4), micro_damping: seed(5) };
        FrBd::new(curve, KelvinVoigt::new(bristle)?).under_load(lit(1.0))?.companion(lit(1.0))
    };
    let (mut companions, mut arm) = ([companion(false)?; JOINTS], arm::<Dual>()?);
    companions[0] = companion(true)?;
    let mut contacts = companions.map(|companion| ContactState::new(&companion, lit(0.0)));
    let [mut q, mut v, mut a] = [[Dual::from_re(0.0); JOINTS]; 3];
    for n in 0..steps {
        let motion = ArmMotion { position: &mut q, velocity: &mut v, acceleration: &mut a };
        arm.step(lit(STEP), motion, &companions, &mut contacts, |middle| swing(n, middle))?;
    }
    Ok(q[0])
}

/// Time of a gradient by the adjoint over that of a simulation.
fn gradient(companion: Companion<f64, Friction>) -> Result<(), ParameterError> {
    let (arm, companions) = (arm()?, [companion; JOINTS]);
    let contacts = companions.map(|companion| ContactState::new(&companion, 0.0));
    let (start, steps) = (Swing { motion: [[0.0; JOINTS]; 3], contacts }, 500);
    let forwards = |arm: &mut Arm<_, _, Vec<f64>>, n: usize, state: &mut Swing| {
        let [position, velocity, acceleration] = &mut state.motion;
        let motion = ArmMotion { position, velocity, acceleration };
        arm.step(STEP, motion, &companions, &mut state.contacts, |middle| swing(n, middle))
    };
    let (mut one, mut other) = (arm.clone(), arm);
    let mut best = [(); 4].map(|()| Best(f64::INFINITY));
    for _ in 0..ROUNDS / 5 {
        best[0].time(1, || {
            let mut state = start;
            let done = (0..steps).try_for_each(|n| forwards(&mut one, n, &mut state));
            black_box((done.is_ok(), state));
        });
        best[3].time(1, || {
            black_box(dual(steps).is_ok());
        });
        for (best, between) in best[1..3].iter_mut().zip([1, 22]) {
            best.time(1, || {
                let mut gradient = [0.0; 6 * JOINTS];
                let mut by = [[0.0; JOINTS]; 3];
                let mut contacts = [ContactAdjoint::default(); JOINTS];
                let step = |n, state: &mut Swing| forwards(&mut one, n, state);
                let done = backwards(start, steps, between, step, |_, states| {
                    for (by, q) in by[0].iter_mut().zip(states[1].motion[0]) {
                        *by += 2.0 * q;
                    }
                    let states = states.map(|Swing { motion, contacts }| {
                        let [position, velocity, acceleration] = motion;
                        ArmState { position, velocity, acceleration, contacts }
                    });
                    let [position, velocity, acceleration] = &mut by;
                    let by = &mut contacts;
                    let adjoint = ArmAdjoint { position, velocity, acceleration, contacts: by };
                    other.pull_back(STEP, states, &companions, |_| (), adjoint, &mut gradient)
                });
                black_box((done.is_ok(), gradient));
            });
        }
    }
    let [alone, all, some, dual] = best.map(|best| best.0 * 1e-6);
    println!();
    println!("7 joints, 500 steps, 42 parameters                  ms   ratio");
    println!("simulation                                   {alone:9.2}");
    println!("gradient, all states kept                    {all:9.2}   {:5.2}", all / alone);
    println!("gradient, one state in 22 kept               {some:9.2}   {:5.2}", some / alone);
    let dual = JOINTS as f64 * dual;
    println!("dual numbers, six parameters at once         {dual:9.2}   {:5.2}", dual / alone);
    Ok(())
}
