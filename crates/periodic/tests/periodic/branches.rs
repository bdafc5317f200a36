use bristle::ode::{Automatic, Direction, Event, Output, Solver, System, Tolerances};
use bristle::parameter::ParameterError;
use bristle::signal::{Sine, SineParameters};
use bristle::{Bristle, Dahl, DahlParameters, ElastoPlastic, FrBd, Mechanism};
use bristle_analysis::linear::Threshold;
use bristle_periodic::{
    BranchEnd, Continuation, Guess, Outcome, PeriodicError, Pid, PointKind, Shooting, hunting,
    hunting_map,
};
use nalgebra::{SVector, Vector3};

use super::{bristle, curve, hunting_loop, rig, rig_on, stick_slip};

#[test]
#[cfg_attr(debug_assertions, ignore = "a branch takes a minute without optimisation")]
fn stick_slip_ends_in_a_fold_where_simulated_cycles_die_out() {
    let [soft, paper, stiff] = [
        end_of_stick_slip((0.1, 1.5), 20, 1e-5),
        end_of_stick_slip((2.0, 0.1), 1, 1e-6),
        end_of_stick_slip((10.0, 0.1), 10, 1e-5),
    ];
    assert!(paper.contains(&PointKind::Flip) && paper.contains(&PointKind::Fold), "{paper:?}");
    assert!(stiff.contains(&PointKind::Fold) && soft.contains(&PointKind::Flip), "{soft:?}");
}

/// What is special about a branch from a speed on, the last stable motion of which is simulated
/// beside its place.
fn end_of_stick_slip(
    (stiffness, speed): (f64, f64),
    segments: usize,
    beside: f64,
) -> Vec<PointKind> {
    let model = FrBd::new(curve(), bristle());
    let rig = |velocity: f64| rig_on(stiffness, model, velocity);
    let mut along = Continuation { most_points: 60, ..Continuation::over(0.02..2.0) };
    along.shooting.segments = segments;
    let start = stick_slip(&rig(speed), speed);
    let branch = along.free(|speed| Ok(rig(speed)), speed, start).unwrap();
    let stable = branch.points.iter().filter(|point| point.orbit.is_stable());
    let last = stable.max_by(|a, b| a.parameter.total_cmp(&b.parameter)).unwrap();
    // From its own state, a little slower the mass goes on sticking and slipping; a little faster
    // it slides steadily after some hundred periods.
    let mut slowest = [0.0; 2];
    for (slowest, change) in slowest.iter_mut().zip([-beside, beside]) {
        let rig = rig(last.parameter * (1.0 + change));
        let tolerances = Tolerances::scaled(1e-12, rig.scales()).unwrap();
        let solver = Solver::adaptive(Automatic, tolerances);
        let end = 600.0 * last.orbit.period;
        let mut run = solver.begin(&rig, 0.0..end, last.orbit.start).unwrap();
        *slowest = f64::INFINITY;
        while let Some(step) = run.advance().unwrap() {
            if step.end_time() > end - last.orbit.period {
                *slowest = f64::min(*slowest, step.end()[1]);
            }
        }
    }
    assert!(slowest[0] < 0.01 && slowest[1] > 0.1, "{stiffness} {slowest:?}");
    branch.special().map(|point| point.kind).collect()
}

#[test]
#[cfg_attr(debug_assertions, ignore = "a branch takes a minute without optimisation")]
fn the_branch_of_stick_slip_ends_where_steady_sliding_turns_unstable() {
    let model = FrBd::new(curve(), bristle());
    let mechanism = Mechanism { mass: 1.0, spring_stiffness: 10.0, viscous_damping: 0.0 };
    let contact = model.under_load(1.0).unwrap();
    let onset = bristle_analysis::linear::critical_speed(&contact, mechanism, 1e-3..1.0).unwrap();
    let Threshold::StableAbove(onset) = onset else { unreachable!("{onset:?}") };
    let rig = |speed: f64| rig_on(10.0, model, speed);
    let mut along = Continuation::over(0.02..2.0);
    along.shooting.segments = 10;
    let branch = along.free(|speed| Ok(rig(speed)), 0.1, stick_slip(&rig(0.1), 0.1)).unwrap();
    assert_eq!(branch.end, BranchEnd::Equilibrium);
    let hopf = branch.points.last().unwrap();
    // Where a branch shrinks to a point is found to 1e-3 of a step along it: to 1e-3 of the onset.
    assert!((hopf.parameter - onset).abs() < 1e-3 * onset, "{} {onset}", hopf.parameter);
    // Its period is that of the swing on the spring, of which the bristle's share is 1e-3.
    assert!((hopf.orbit.period / (std::f64::consts::TAU / 10_f64.sqrt()) - 1.0).abs() < 2e-3);
}

#[test]
fn a_branch_of_forced_motions_is_that_of_a_linear_oscillator() {
    /// ẍ + 0.6 ẋ + x = cos ωt, without friction.
    struct Oscillator(f64);
    impl System<f64, 2, 0> for Oscillator {
        fn rate(&self, t: f64, x: &SVector<f64, 2>, b: [bristle::Branch; 0]) -> SVector<f64, 2> {
            self.linearised(t, x, b).unwrap().rate
        }
        fn sliding_velocities(&self, _: f64, _: &SVector<f64, 2>) -> [f64; 0] {
            []
        }
        fn linearised(
            &self,
            time: f64,
            x: &SVector<f64, 2>,
            _: [bristle::Branch; 0],
        ) -> Option<bristle::ode::Linearisation<f64, 2>> {
            let by_state = nalgebra::Matrix2::new(0.0, 1.0, -1.0, -0.6);
            let input = SVector::from([0.0, (self.0 * time).cos()]);
            let by_time = SVector::from([0.0, -self.0 * (self.0 * time).sin()]);
            Some(bristle::ode::Linearisation { rate: by_state * x + input, by_state, by_time })
        }
    }
    let period = |omega: f64| std::f64::consts::TAU / omega;
    let mut along = Continuation::over(0.5..1.5);
    let mut branch = |segments: usize| {
        along.shooting.segments = segments;
        along.forced(|omega| Ok(Oscillator(omega)), period, 0.6, SVector::zeros()).unwrap()
    };
    let branches = [branch(1), branch(3)];
    assert!(branches.iter().all(|branch| branch.end == BranchEnd::Range));
    for point in branches.iter().flat_map(|branch| &branch.points) {
        let w = point.parameter;
        let real = (1.0 - w * w) / ((1.0 - w * w).powi(2) + (0.6 * w).powi(2));
        // Points of a branch are found to 3e-8 of the scales, which are one.
        assert!((point.orbit.start[0] - real).abs() < 1e-7, "{w} {}", point.orbit.start[0]);
        // det Φ = e^(−0.6 T)
        let sum: f64 = point.orbit.multipliers.iter().map(|it| it.log_modulus).sum();
        assert!((sum + 0.6 * point.orbit.period).abs() < 1e-9);
    }
}

#[test]
fn a_prescribed_velocity_needs_no_iteration() {
    let wave = SineParameters { mean: 2e-3, amplitude: 0.02, frequency: 3.0, phase: 0.4 };
    let wave = Sine::new(wave).unwrap();
    let contact = FrBd::new(curve(), bristle()).under_load(1.0).unwrap();
    let shooting = Shooting::default();
    let orbit = shooting.prescribed(&contact, wave, (0.1, 1.0 / 3.0)).unwrap();
    // Simulated for so long that the start is forgotten.
    let scene = bristle::scene::PrescribedVelocity::new(contact, wave);
    let end = 0.1 + 20.0 / 3.0;
    let start = SVector::from([0.0]);
    let run = bristle::ode::solve(&scene, 0.1..end, start, 1e-11, Output::Uniform(2)).unwrap();
    let (got, want) = (orbit.start[0], run.last().unwrap().1[0]);
    assert!((got - want).abs() < 1e-9 * 1.5e-4, "{got} {want}");
    let elasto_plastic = ElastoPlastic::new(curve(), bristle(), 5e-5).unwrap();
    let refused = shooting.prescribed(&elasto_plastic.under_load(1.0).unwrap(), wave, (0.0, 1.0));
    assert!(matches!(refused, Err(PeriodicError::Refused(_))));
}

#[test]
fn maps_agree_with_single_runs_and_rest_with_rest() {
    let map = |integral: f64, derivative: f64| {
        let mut parameters = hunting_loop();
        (parameters.controller.integral, parameters.controller.derivative) = (integral, derivative);
        parameters
    };
    let (across, down) = ([0.0, 800.0, 4000.0], [20.0, 30.0]);
    let rows = hunting_map(map, [&across, &down], 0.02, 60.0).unwrap();
    for (row, &derivative) in rows.iter().zip(&down) {
        assert_eq!(row[0], Outcome::Rests); // without integral action
        for (outcome, &integral) in row.iter().zip(&across) {
            assert_eq!(*outcome, map(integral, derivative).outcome(0.02, 60.0).unwrap());
        }
        let Outcome::Hunts(cycle) = row[2] else { unreachable!("{:?}", row[2]) };
        // It began 2 cm away.
        assert!(cycle.amplitude > 1e-4 && cycle.amplitude < 0.02, "{cycle}");
    }
    // m s³ + K_D s² + K_P s + K_I grows if K_D K_P < m K_I: large motions do, from large starts.
    let grows = hunting(&map(10_000.0, 20.0), &[0.5], 60.0).unwrap();
    assert!(grows.large_abscissa > 0.0 && grows.outcomes[0].1 == Outcome::Grows, "{grows}");
    assert!(grows.hunts() && grows.to_string().contains("GROW"));
}

#[test]
fn large_motions_of_a_filtered_loop_have_the_poles_of_its_linear_part() {
    // m s³ (τ s + 1) + (K_P s + K_I) (τ s + 1) + K_D s² = τ (s + 1) (s + 2) (s + 3) (s + 4).
    let mut filtered = hunting_loop();
    filtered.controller = Pid {
        proportional: 4.76,
        integral: 2.4,
        derivative: 3.024,
        filter_time: 0.1,
        sample_time: 0.0,
    };
    let report = hunting(&filtered, &[0.02], 1.0).unwrap();
    // Roundings of the coefficients, over the distance of the poles.
    assert!((report.large_abscissa + 1.0).abs() < 1e-10, "{report}");
}

/// A short simulation is told from an end: some of these loops slip for a minute and rest then,
/// others stick for half a minute between slips.
#[test]
#[cfg_attr(debug_assertions, ignore = "hours are simulated")]
fn what_is_said_of_a_loop_does_not_depend_on_the_duration() {
    let hunts = |outcome: Outcome| matches!(outcome, Outcome::Hunts(_));
    let (mut resting, mut hunting) = (0, 0);
    for (sample_time, integrals) in [(0.0, &[150.0, 400.0, 900.0, 2000.0][..]), (0.01, &[2000.0])] {
        for &integral in integrals {
            for derivative in [10.0, 25.0, 45.0, 70.0] {
                let mut parameters = hunting_loop();
                let gains = &mut parameters.controller;
                (gains.integral, gains.derivative) = (integral, derivative);
                gains.sample_time = sample_time;
                let for_ever = hunts(parameters.outcome(0.02, 3000.0).unwrap());
                for duration in [1.0, 10.0, 60.0] {
                    let found = parameters.outcome(0.02, duration).unwrap();
                    assert_eq!(
                        hunts(found),
                        for_ever,
                        "{gains:?}, {duration} s",
                        gains = parameters.controller
                    );
                }
                if for_ever { hunting += 1 } else { resting += 1 }
            }
        }
    }
    assert!(resting > 5 && hunting > 5, "{resting} {hunting}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "a branch takes a minute without optimisation")]
fn sampled_and_filtered_loops_come_close_to_the_continuous_one() {
    let continuous = hunting(&hunting_loop(), &[0.02], 120.0).unwrap();
    let (exact, across) = continuous.cycle.clone().unwrap().unwrap();
    assert!((across[0].value() - 0.848580).norm() < 1e-6);
    let mut sampled = hunting_loop();
    sampled.controller.sample_time = 1e-3;
    let mut filtered = hunting_loop();
    filtered.controller.filter_time = 1e-4;
    for (parameters, share) in [(sampled, 0.02), (filtered, 0.02)] {
        let report = hunting(&parameters, &[0.02], 120.0).unwrap();
        let Outcome::Hunts(cycle) = report.outcomes[0].1 else { unreachable!("{report}") };
        assert!((cycle.amplitude / exact.amplitude - 1.0).abs() < share, "{cycle} {exact}");
        let (_, near) = report.cycle.clone().unwrap().unwrap();
        assert!((near[0].value() - across[0].value()).norm() < share, "{report}");
        assert_eq!(report.is_quasi_periodic, parameters.controller.sample_time > 0.0);
    }
}

#[test]
fn bad_input_has_an_answer_with_a_name() {
    let shooting = Shooting::default();
    let model = FrBd::new(curve(), bristle());
    let system = rig(model, 0.1);
    let at = |period: f64, stretch: f64| {
        shooting.free(&system, Guess { state: Vector3::new(stretch, 0.1, 1e-4), period })
    };
    let refused = |it: &Result<_, PeriodicError>| matches!(it, Err(PeriodicError::Refused(_)));
    for period in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(refused(&at(period, 0.7).map(drop)), "{period}");
    }
    assert!(refused(&at(7.0, f64::NAN).map(drop)));
    // Steady sliding: a point, not a cycle.
    let sliding = Vector3::new(0.5 * 1.004, 0.1, 1.004e-4);
    let point = shooting.free(&system, Guess { state: sliding, period: 4.4 });
    assert!(point.is_err(), "{point:?}");
    let fast = rig(model, 1.5);
    let guess = Guess { state: sliding, period: 7.6 };
    for segments in [0, 101, usize::MAX] {
        assert!(refused(&Shooting { segments, ..shooting }.free(&fast, guess).map(drop)));
    }
    let ahead = |_: f64, state: &Vector3<f64>| state[1] - 1.5;
    let section = Event { function: &ahead, direction: Direction::Rising, stops: false };
    // Branches over nothing, and gains that are none.
    let along = |range: std::ops::Range<f64>| {
        let make = |speed: f64| -> Result<_, ParameterError> { Ok(rig(model, speed)) };
        Continuation::over(range).free(make, 0.1, guess).map(drop)
    };
    assert!(refused(&along(1.0..1.0)) && refused(&along(f64::NAN..1.0)));
    for bad in [f64::NAN, -1.0, f64::INFINITY] {
        let mut parameters = hunting_loop();
        parameters.controller.integral = bad;
        assert!(refused(&hunting(&parameters, &[0.02], 60.0).map(drop)));
        assert!(refused(&hunting_loop().outcome(0.02, bad).map(drop)));
    }
    assert!(refused(&hunting(&hunting_loop(), &[], 60.0).map(drop)));
    let named = |error: PeriodicError, name: &str| {
        assert!(error.to_string().starts_with(name), "{error}");
    };
    let mut free = hunting_loop();
    free.contact = model.under_load(0.0).unwrap();
    named(hunting(&free, &[0.02], 60.0).unwrap_err(), "normal_force is 0");
    named(shooting.settle(&fast, sliding, f64::NAN, &section).unwrap_err(), "duration is NaN");
    let dahl =
        Dahl::new(DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 1e4 }).unwrap();
    let still = shooting.prescribed(&dahl.under_load(1.0).unwrap(), 0.0, (0.0, 1.0));
    assert!(still.is_err(), "{still:?}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "a search in vain takes half a minute without optimisation")]
fn a_cycle_that_does_not_exist_is_not_found() {
    // Faster than the fold.
    let (shooting, fast) = (Shooting::default(), rig(FrBd::new(curve(), bristle()), 1.5));
    for segments in [1, 8] {
        let guess = Guess { state: Vector3::new(0.8, 0.5, 1e-4), period: 4.5 };
        let none = Shooting { segments, ..shooting }.free(&fast, guess);
        assert!(none.is_err(), "{none:?}");
    }
    let ahead = |_: f64, state: &Vector3<f64>| state[1] - 1.5;
    let section = Event { function: &ahead, direction: Direction::Rising, stops: false };
    let settled = shooting.settle(&fast, Vector3::new(0.502, 0.1, 1.004e-4), 60.0, &section);
    let settled = settled.and_then(|guess| shooting.free(&fast, guess));
    assert!(settled.is_err(), "{settled:?}");
}
