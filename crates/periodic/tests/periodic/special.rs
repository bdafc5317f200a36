//! Special points of branches against closed forms, and the border of hunting against simulation.

use bristle::ode::{
    Automatic, Direction, Event, Linearisation, Output, Solver, System, Tolerances,
};
use bristle::{Branch, FrBd};
use bristle_periodic::{
    BranchEnd, Continuation, ControlLoop, Guess, OrbitBranch, PeriodicError, PointKind, Shooting,
    hunting, hunting_orbit,
};
use nalgebra::{Matrix2, Matrix4, SMatrix, SVector, Vector2, Vector4};

use super::{bristle, curve, hunting_loop, rig, stick_slip};

/// ẋ = f(x) with its derivatives, without friction.
pub(crate) struct Field<F>(pub(crate) F);

impl<F, const N: usize> System<f64, N, 0> for Field<F>
where
    F: Fn(&SVector<f64, N>) -> (SVector<f64, N>, SMatrix<f64, N, N>),
{
    fn rate(&self, _: f64, x: &SVector<f64, N>, _: [Branch; 0]) -> SVector<f64, N> {
        (self.0)(x).0
    }

    fn sliding_velocities(&self, _: f64, _: &SVector<f64, N>) -> [f64; 0] {
        []
    }

    fn linearised(
        &self,
        _: f64,
        x: &SVector<f64, N>,
        _: [Branch; 0],
    ) -> Option<Linearisation<f64, N>> {
        let (rate, by_state) = (self.0)(x);
        Some(Linearisation { rate, by_state, by_time: SVector::zeros() })
    }
}

/// Of a branch of cycles of 2π s that begins at 0.5 and goes down, in steps as they are in use.
fn down<S: System<f64, N, 0>, const N: usize>(
    system: impl Fn(f64) -> S,
    segments: usize,
    state: SVector<f64, N>,
) -> OrbitBranch<N> {
    let guess = Guess { state, period: std::f64::consts::TAU };
    let mut along = Continuation { first_step: -0.02, ..Continuation::over(-0.5..1.0) };
    along.shooting.segments = segments;
    along.free(|parameter| Ok(system(parameter)), 0.5, guess).unwrap()
}

#[test]
fn a_branch_begins_with_a_hundredth_of_its_range() {
    let along = Continuation::over(10.0..90.0);
    assert!((along.first_step - 0.8).abs() < 1e-12, "{}", along.first_step);
    assert!(along.largest_step == 0.1 && along.most_points == 400 && !along.stable_only);
}

#[test]
fn a_cycle_shrinks_to_its_hopf_point() {
    // Van der Pol, ẍ − (p − x²) ẋ + x = 0: its cycle, of amplitude 2√p, ends at p = 0. About x = 1
    // it is not odd, and is followed over whole periods.
    for (centre, segments) in [(0.0, 1), (0.0, 3), (1.0, 1), (1.0, 3)] {
        let system = |p: f64| {
            Field(move |state: &Vector2<f64>| {
                let (x, v) = (state[0] - centre, state[1]);
                let damping = p - x * x;
                let by_state = Matrix2::new(0.0, 1.0, -1.0 - 2.0 * x * v, damping);
                (Vector2::new(v, damping * v - x), by_state)
            })
        };
        let branch = down(system, segments, Vector2::new(centre + 1.4, 0.0));
        assert_eq!(branch.end, BranchEnd::Equilibrium);
        let [.., last] = branch.points[..] else { unreachable!() };
        assert_eq!(last.kind, PointKind::Hopf);
        // At amplitudes of 10⁻⁴ of a step, p = amplitude²/4.
        assert!(last.parameter.abs() < 1e-7, "{}", last.parameter);
        assert!((last.orbit.period - std::f64::consts::TAU).abs() < 1e-6);
        assert_eq!(branch.special().count(), 1);
    }
}

#[test]
fn a_border_is_named_whatever_it_is() {
    // Van der Pol with time that runs forwards, and backwards: the cycle is unstable then.
    let system = |p: f64, time: f64| {
        Field(move |state: &Vector2<f64>| {
            let (x, v, damping) = (state[0], state[1], p - state[0] * state[0]);
            let by_state = Matrix2::new(0.0, 1.0, -1.0 - 2.0 * x * v, damping) * time;
            (Vector2::new(v, damping * v - x) * time, by_state)
        })
    };
    let guess = Guess { state: Vector2::new(1.4, 0.0), period: std::f64::consts::TAU };
    let guess = Shooting::default().free(&system(0.5, 1.0), guess).unwrap().guess();
    let along = |first_step: f64, time: f64| {
        let along = Continuation { first_step, ..Continuation::over(-0.5..1.0) };
        along.border(|p| Ok(system(p, time)), 0.5, guess)
    };
    let rest = along(-0.02, 1.0).unwrap().unwrap();
    assert!(rest.kind == PointKind::Hopf && rest.parameter.abs() < 1e-7, "{rest:?}");
    assert_eq!(along(0.02, 1.0), Ok(None));
    assert_eq!(along(0.02, -1.0), Err(PeriodicError::Unstable));
}

#[test]
fn a_motion_that_is_odd_at_the_start_only_is_followed_over_its_whole_period() {
    // The unit circle at φ̇ = 1 − p cos φ, in 2π/√(1 − p²): odd at p = 0.
    let system = |p: f64| {
        Ok(Field(move |state: &Vector2<f64>| {
            let (x, y) = (state[0], state[1]);
            let (inside, turn, speed) = (1.0 - x * x - y * y, 2.0 * x * y, 1.0 - p * x);
            let above = [inside - 2.0 * x * x + p * y, -turn - speed];
            let below = [speed - p * x - turn, inside - 2.0 * y * y];
            let by_state = Matrix2::new(above[0], above[1], below[0], below[1]);
            (Vector2::new(inside * x - speed * y, inside * y + speed * x), by_state)
        }))
    };
    let guess = Guess { state: Vector2::new(0.0, 1.0), period: std::f64::consts::TAU };
    let branch = Continuation::over(0.0..0.8).free(system, 0.0, guess).unwrap();
    let [.., last] = branch.points[..] else { unreachable!() };
    assert!(last.parameter == 0.8 && (last.orbit.period * 0.6 / guess.period - 1.0).abs() < 1e-6);
}

#[test]
fn a_torus_branches_off_where_a_complex_pair_passes_the_unit_circle() {
    // The unit circle, with u̇ = A (u − c) beside it: multipliers e^(2π λ). A focus, p ± 0.3 i, of
    // an odd system and of one that is not; a saddle whose real multipliers e^(2π p), e^(2π) have
    // a product of one at p = −1 is none.
    for (centre, by_state, wanted) in [
        (0.0, [0.0, -0.3, 0.3, 0.0], Some(0.0)),
        (1.0, [0.0, -0.3, 0.3, 0.0], Some(0.0)),
        (0.0, [-0.2, 0.0, 0.0, 0.2], None),
    ] {
        let system = |p: f64| {
            Field(move |state: &Vector4<f64>| {
                let (x, y) = (state[0], state[1]);
                let inside = 1.0 - x * x - y * y;
                let [a, b, c, d] = by_state;
                let mut by_state = Matrix4::zeros();
                let (turn, same) = (2.0 * x * y, |at: f64| inside - 2.0 * at * at);
                let circle = Matrix2::new(same(x), -1.0 - turn, 1.0 - turn, same(y));
                let beside = Matrix2::new(a + p, b, c, d + p);
                by_state.fixed_view_mut::<2, 2>(0, 0).copy_from(&circle);
                by_state.fixed_view_mut::<2, 2>(2, 2).copy_from(&beside);
                let u = beside * Vector2::new(state[2] - centre, state[3] - centre);
                (Vector4::new(inside * x - y, inside * y + x, u[0], u[1]), by_state)
            })
        };
        let branch = down(system, 1, Vector4::new(1.0, 0.0, centre, centre));
        let found: Vec<_> = branch.special().map(|it| (it.kind, it.parameter)).collect();
        let tori: Vec<_> = found.iter().filter(|it| it.0 == PointKind::Torus).collect();
        assert_eq!(tori.first().map(|it| it.1.abs() < 1e-7), wanted.map(|_| true), "{found:?}");
        assert_eq!(tori.len(), usize::from(wanted.is_some()));
    }
}

/// Passages of a simulation through x = 0, and the integral of x there.
fn passages<S: System<f64, 4>>(system: &S, start: Vector4<f64>, duration: f64) -> Vec<(f64, f64)> {
    let tolerances = Tolerances::scaled(1e-12, system.scales()).unwrap();
    let position = |_: f64, state: &SVector<f64, 4>| state[0];
    let target = [Event { function: &position, direction: Direction::Either, stops: false }];
    let solver = Solver::adaptive(Automatic, tolerances);
    let run = solver.solve_with_events(system, 0.0..duration, start, &target, Output::Uniform(2));
    run.unwrap().events().iter().map(|it| (it.time, it.state[3])).collect()
}

#[test]
#[cfg_attr(debug_assertions, ignore = "a branch takes a minute without optimisation")]
fn the_border_of_hunting_is_that_of_simulation() {
    // At K_I = 400 an odd cycle loses its stability, and no cycle that it leads to is stable
    // beyond; at 900 it leaves for one that is not odd, which ends in a fold.
    for (integral, kind) in [(400.0, PointKind::Crossing), (900.0, PointKind::Fold)] {
        let system = |derivative: f64| {
            let mut parameters = hunting_loop();
            (parameters.controller.integral, parameters.controller.derivative) =
                (integral, derivative);
            ControlLoop::new(parameters)
        };
        let orbit = hunting_orbit(&system(20.0).unwrap(), 0.02, 60.0).unwrap();
        let along = Continuation { first_step: 1.0, ..Continuation::over(10.0..90.0) };
        // Half a period from x to −x is a whole one; multipliers are good to 1e-6.
        let first = Continuation { most_points: 1, ..along.clone() };
        let half = first.free(system, 20.0, orbit.guess()).unwrap().points[0].orbit;
        assert!((half.period - orbit.period).abs() < 1e-8);
        assert!((half.transverse()[0].value() - orbit.transverse()[0].value()).norm() < 1e-6);
        let border = along.border(system, 20.0, orbit.guess()).unwrap().unwrap();
        assert_eq!(border.kind, kind);
        let simulated = |share: f64, off: f64, periods: f64| {
            let mut start = border.orbit.start;
            start[3] *= 1.0 + off;
            let system = system(share * border.parameter).unwrap();
            passages(&system, start, periods * border.orbit.period)
        };
        for (share, hunts) in [(1.0 - 2e-6, true), (1.0 + 2e-6, false)] {
            if kind == PointKind::Crossing {
                // In fifty periods a small asymmetry, the sum of the integrals at a passage and at
                // the next, dies out or grows: by 1e-4, of which runs to 1e-12 leave 1e-7.
                let all = simulated(share, 1e-5, 52.2);
                let asymmetry = |at: usize| (all[at].1 + all[at + 1].1).abs();
                let growth = asymmetry(101) / asymmetry(1) - 1.0;
                assert!(growth.abs() > 2e-5 && (growth < 0.0) == hunts, "{share} {growth:e}");
            } else {
                // What has lost its cycle comes to rest.
                let all = simulated(share, 0.0, 500.0);
                let late = all.iter().filter(|it| it.0 > 480.0 * border.orbit.period).count();
                assert!(if hunts { late >= 39 } else { late <= 2 }, "{share} {late}");
            }
        }
    }
}

#[test]
fn a_multiple_of_the_period_gives_the_period() {
    let rig = rig(FrBd::new(curve(), bristle()), 0.1);
    let Guess { state, period } = stick_slip(&rig, 0.1);
    for times in [2.0, 3.0] {
        let orbit = Shooting::default().free(&rig, Guess { state, period: times * period });
        assert!((orbit.unwrap().period - 7.639267).abs() < 1e-6);
    }
}

#[test]
fn what_neither_grows_nor_dies_out_is_neutral() {
    // ẍ = −x over a period of 1 s: multipliers e^(±i). Runs leave roundings.
    let swing = Field(|state: &Vector2<f64>| {
        let by_state = Matrix2::new(0.0, 1.0, -1.0, 0.0);
        (by_state * state, by_state)
    });
    let orbit = Shooting::default().forced(&swing, (0.0, 1.0), Vector2::new(0.1, 0.0)).unwrap();
    assert!(orbit.multipliers.iter().all(|it| it.is_neutral()) && !orbit.is_stable());
    // m s³ + K_D s² + K_P s + K_I has the poles ±i √(K_P/m) where K_D K_P = m K_I.
    for derivative in [10.0, 30.0, 70.0] {
        let mut parameters = hunting_loop();
        parameters.controller.derivative = derivative;
        parameters.controller.integral = derivative * 400.0;
        let report = hunting(&parameters, &[1e-5], 1.0).unwrap();
        assert!(report.to_string().contains("large motions  neutral"), "{report}");
    }
}

#[test]
fn a_branch_has_a_limit_of_steps() {
    let model = FrBd::new(curve(), bristle());
    let start = stick_slip(&rig(model, 0.1), 0.1);
    let limited = |largest_step: f64, most_steps: u64| {
        let shooting = Shooting { most_steps, ..Shooting::default() };
        let steps = Continuation { shooting, largest_step, ..Continuation::over(0.02..2.0) };
        steps.free(|speed| Ok(rig(model, speed)), 0.1, start)
    };
    let branch = limited(1e9, 20_000).unwrap();
    assert_eq!(branch.end, BranchEnd::Lost(PeriodicError::TooManySteps));
    assert_eq!(limited(0.1, 100), Err(PeriodicError::TooManySteps));
}
