use bristle::ode::{
    Automatic, Direction, Event, Linearisation, Output, Solver, System, Tolerances,
};
use bristle::{Branch, FrBd, LuGre};
use bristle_periodic::{ControlLoop, Shooting};
use nalgebra::{Complex, DMatrix, DVector, SVector};

use super::{Friction, bristle, curve, friction, hunting_loop, rig, stick_slip};

/// The chain of three masses with two contacts, under cos 1.2t on the second mass.
struct Chain(Friction);

const FREQUENCY: f64 = 1.2;

impl System<f64, 8, 2> for Chain {
    fn rate(&self, time: f64, state: &SVector<f64, 8>, branches: [Branch; 2]) -> SVector<f64, 8> {
        self.linearised(time, state, branches).unwrap().rate
    }

    fn sliding_velocities(&self, _: f64, state: &SVector<f64, 8>) -> [f64; 2] {
        [state[3], state[4] - state[3]]
    }

    fn linearised(
        &self,
        time: f64,
        state: &SVector<f64, 8>,
        branches: [Branch; 2],
    ) -> Option<Linearisation<f64, 8>> {
        let mut by_state = nalgebra::SMatrix::<f64, 8, 8>::zeros();
        for i in 0..3 {
            by_state[(i, 3 + i)] = 1.0;
            for j in 0..3usize {
                let stiffness = if i == j {
                    2.0
                } else if i.abs_diff(j) == 1 {
                    -1.0
                } else {
                    0.0
                };
                by_state[(3 + i, j)] = -stiffness;
                by_state[(3 + i, 3 + j)] = -0.02 * stiffness;
            }
        }
        let mut rate = by_state * state;
        rate[4] += (FREQUENCY * time).cos();
        let sliding = self.sliding_velocities(time, state);
        // W: the first contact on mass 1, the second between 1 and 2.
        let rows = [[1.0, 0.0], [-1.0, 1.0]];
        for k in 0..2 {
            let contact = self.0.linearised(branches[k].of(sliding[k]), state[6 + k]);
            rate[6 + k] = contact.rate;
            by_state[(6 + k, 6 + k)] = contact.rate_by_deflection;
            for i in 0..2 {
                rate[3 + i] -= rows[k][i] * contact.force;
                by_state[(3 + i, 6 + k)] -= rows[k][i] * contact.force_by_deflection;
                by_state[(6 + k, 3 + i)] = rows[k][i] * contact.rate_by_velocity;
                for j in 0..2 {
                    by_state[(3 + i, 3 + j)] -= rows[k][i] * rows[k][j] * contact.force_by_velocity;
                }
            }
        }
        let mut by_time = SVector::zeros();
        by_time[4] = -FREQUENCY * (FREQUENCY * time).sin();
        Some(Linearisation { rate, by_state, by_time })
    }

    fn scales(&self) -> SVector<f64, 8> {
        SVector::from([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.05, 0.05])
    }
}

fn chain() -> Chain {
    Chain(friction([1.3, 1.0, 0.1, 0.0], [20.0, 0.2]))
}

/// Single and multiple shooting.
const BOTH: [Shooting; 2] = [
    Shooting { tolerance: 1e-12, most_iterations: 30, most_steps: 10_000_000, segments: 1 },
    Shooting { tolerance: 1e-12, most_iterations: 30, most_steps: 10_000_000, segments: 7 },
];

#[test]
fn the_chain_repeats_with_its_force() {
    BOTH.iter().for_each(the_chain_repeats);
}

fn the_chain_repeats(shooting: &Shooting) {
    let period = std::f64::consts::TAU / FREQUENCY;
    let orbit = shooting.forced(&chain(), (0.0, period), SVector::zeros()).unwrap();
    // MODEL values, ten digits.
    let want = [
        -0.0613145018,
        -0.0137835258,
        -0.0733261702,
        0.2333878676,
        0.3561109223,
        0.6872045191,
        0.0471729514,
        0.0453890266,
    ];
    for (got, want) in orbit.start.iter().zip(want) {
        assert!((got - want).abs() < 1e-10, "{got} {want}");
    }
    // Given to 1e-5; the third was 7e-6 off, as the differences below tell.
    let want = [(-0.30111, 0.74309), (0.54837, 0.0), (-0.30611, 0.12510), (0.13444, 0.0)];
    let got = orbit.multipliers.map(|multiplier| multiplier.value());
    for (re, im) in want {
        let near = |it: &Complex<f64>| (it.re - re).abs() < 1e-5 && (it.im.abs() - im).abs() < 1e-5;
        assert_eq!(got.iter().filter(|it| near(it)).count(), if im == 0.0 { 1 } else { 2 });
    }
    assert!(orbit.multipliers[6].log_modulus < 1e-4_f64.ln());
    // Against central differences of runs: 1e-6 of a scale, steps to 1e-13.
    let scales = chain().scales();
    let solver = Solver::adaptive(Automatic, Tolerances::scaled(1e-13, scales).unwrap());
    let end = |state| solver.solve(&chain(), 0.0..period, state, Output::Uniform(2)).unwrap();
    let differences = DMatrix::from_columns(&core::array::from_fn::<_, 8, _>(|j| {
        let mut off = SVector::<f64, 8>::zeros();
        off[j] = 1e-6 * scales[j];
        let [more, less] = [orbit.start + off, orbit.start - off].map(end);
        let apart = more.last().unwrap().1 - less.last().unwrap().1;
        DVector::from_iterator(8, (apart / (2e-6 * scales[j])).iter().copied())
    }));
    for wanted in differences.complex_eigenvalues().iter() {
        println!("{wanted}");
        // Differences of 1e-6 leave 1e-7.
        assert!(got.iter().any(|it| (it - wanted).norm() < 1e-6), "{wanted}");
    }
}

#[test]
fn stick_slip_repeats_with_its_own_period() {
    let frbd = rig(FrBd::new(curve(), bristle()), 0.1);
    let lugre = rig(LuGre::classical(curve(), bristle()), 0.1);
    let guesses = [stick_slip(&frbd, 0.1), stick_slip(&lugre, 0.1)];
    for shooting in BOTH {
        let orbits = [shooting.free(&frbd, guesses[0]), shooting.free(&lugre, guesses[1])];
        for ((orbit, guess), want) in orbits.into_iter().zip(guesses).zip([7.639267, 7.630918]) {
            let orbit = orbit.unwrap();
            assert!((orbit.period - want).abs() < 1e-6, "{} {want}", orbit.period);
            // The last period of a simulation to 1e-9 is that of one that began from rest.
            assert!((guess.period - orbit.period).abs() < 1e-6, "{}", guess.period);
            // What the mass did before it stuck is forgotten.
            assert!(orbit.is_stable() && orbit.transverse()[0].log_modulus < -40.0, "{orbit:?}");
        }
    }
}

#[test]
fn a_damped_loop_moves_no_faster_than_its_friction_lets_it() {
    let mut parameters = hunting_loop();
    parameters.mechanism.viscous_damping = 30.0;
    let scales = ControlLoop::new(parameters).unwrap().scales();
    // 5 N of friction at 400 N/m, 400 N/(m s) and 20 + 30 N s/m: 0.0125 m, felt after 1 s, 0.1 m/s.
    let want = SVector::from([0.0125, 0.1, 1e-4, 0.0125]);
    assert!((scales - want).component_div(&want).amax() < 1e-12, "{scales}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "a hundred periods take a minute without optimisation")]
fn a_loop_hunts() {
    let system = ControlLoop::new(hunting_loop()).unwrap();
    let position = |_: f64, state: &SVector<f64, 4>| state[0];
    let crosses = Event { function: &position, direction: Direction::Rising, stops: false };
    let guess = BOTH[0].settle(&system, system.displaced(0.02), 60.0, &crosses).unwrap();
    // Simulation misleads: it closes in by 15 % a period.
    assert!((guess.period - 13.76).abs() < 0.01, "{}", guess.period);
    let [_, orbit] = BOTH.map(|shooting| {
        let orbit = shooting.free(&system, guess).unwrap();
        assert!((orbit.period - 13.41431327).abs() < 1e-8, "{}", orbit.period);
        let across = orbit.transverse();
        assert!((across[0].value() - 0.848580).norm() < 1e-6, "{across:?}");
        assert!(across[1].value().norm() < 1e-6 && across[2].value().norm() < 1e-6);
        orbit
    });
    // The state at the largest x, and the period of a simulation that has closed in: 0.85^100 is
    // 1e-7.
    let tolerances = Tolerances::scaled(1e-12, system.scales()).unwrap();
    let solver = Solver::adaptive(Automatic, tolerances);
    let velocity = |_: f64, state: &SVector<f64, 4>| state[1];
    let turns =
        [Event { function: &velocity, direction: Direction::Falling, stops: false }, crosses];
    let run = |start, end| {
        solver.solve_with_events(&system, 0.0..end, start, &turns, Output::Uniform(2)).unwrap()
    };
    let cycle = run(orbit.start, orbit.period);
    let largest = cycle.events().iter().map(|it| it.state).max_by(|a, b| a[0].total_cmp(&b[0]));
    let largest = largest.unwrap();
    for (i, want, digit) in
        [(0, 3.20011418e-3, 1e-11), (2, 7.26418569e-5, 1e-13), (3, -1.00024273e-2, 1e-10)]
    {
        assert!((largest[i] - want).abs() < digit, "{largest}");
    }
    let run = run(guess.state, 101.0 * orbit.period);
    let passages: Vec<f64> =
        run.events().iter().filter(|it| it.index == 1).map(|it| it.time).collect();
    let [.., before, last] = passages[..] else { unreachable!() };
    assert!((last - before - orbit.period).abs() < 1e-6, "{}", last - before);
}
