//! Inputs that jump or bend: a step ends there, and none of its stages looks beyond.
#![cfg(feature = "alloc")]

use bristle::Mechanism;
use bristle::ode::{Output, Solver, System};
use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
use bristle::signal::{Function, Polyline, Signal, Vertex};
use bristle::{Branch, Bristle};
use bristle_specimens::ode::{Integral, OfAny, every_solver, table_2_frbd, tolerance};
use nalgebra::{Vector1, Vector2, Vector3};

use crate::blind_spots::METHODS;

/// Integrates u over a span by every solver, and compares with the area under it.
#[track_caller]
fn assert_area(u: impl Signal<f64> + 'static, (from, to): (f64, f64), area: f64) {
    let system = Integral(u);
    for step in [0.1, 0.7, 10.0] {
        every_solver!(step, tolerance(1e-6), |name, solver| {
            // A limit, so that the test ends if the run does not.
            let solver = solver.with_most_steps(3000);
            let run = solver.solve(&system, from..to, Vector1::new(0.0), Output::Uniform(2));
            let Ok(run) = run else { panic!("{name}, {from}..{to}: {}", run.unwrap_err()) };
            let error = run.last().unwrap().1[0] - area;
            // Rounding of areas up to twenty in up to seventy steps, magnified by the Rosenbrock
            // methods' weights of up to a hundred. A single stage on the wrong side of a kink is an
            // error of a hundredth of the step, or more.
            assert!(error.abs() < 2e-12, "{name}, {from}..{to} by {step}: off by {error:e}");
        });
    }
}

/// u = 1 until the kink, then 3.
fn jump(kink: f64) -> impl Signal<f64> {
    Function::new(move |t: f64| (if t < kink { 1.0 } else { 3.0 }, 0.0), [kink])
}

fn jump_area(kink: f64, from: f64, to: f64) -> f64 {
    let area = |t: f64| if t < kink { t - kink } else { 3.0 * (t - kink) };
    area(to) - area(from)
}

#[test]
fn a_jump_is_integrated_exactly() {
    // Places with all kinds of rounding against the spans.
    for i in 1..20 {
        let kink = 0.1311 * f64::from(i);
        for (from, to) in [(0.0, 4.0), (-1.0, 5.7), (0.013, 3.3)] {
            assert_area(jump(kink), (from, to), jump_area(kink, from, to));
        }
    }
    // From the jump on, up to it, and to and from within a rounding of it.
    for kink in [0.0, 0.3, 1.0, 2.7, -1.3] {
        assert_area(jump(kink), (kink, kink + 2.0), 6.0);
        assert_area(jump(kink), (kink - 2.0, kink), 2.0);
    }
    for offset in [-2, -1, 0, 1, 2] {
        let end = 1.0 + f64::from(offset) * f64::EPSILON;
        assert_area(jump(1.0), (0.0, end), 1.0);
        assert_area(jump(1.0), (end, 2.0), 3.0);
    }
}

#[test]
fn several_jumps_are_all_met_and_in_turn() {
    // Listed in no order, two of them a rounding apart.
    let close = 1.1 + 4.0 * f64::EPSILON;
    let u = Function::new(
        move |t: f64| {
            let steps = [0.4, 1.1, close, 2.5].iter().filter(|&&kink| t >= kink).count();
            (steps as f64, 0.0)
        },
        [2.5, 0.4, close, 1.1],
    );
    let area = 0.0 * 0.4 + 1.0 * 0.7 + 3.0 * 1.4 + 4.0 * 0.5;
    assert_area(u, (0.0, 3.0), area);
}

#[test]
fn ramps_are_integrated_exactly() {
    let trapeze = Polyline::new([
        Vertex { time: 0.3, value: -1.0 },
        Vertex { time: 1.1, value: 2.0 },
        Vertex { time: 1.7, value: 2.0 },
        Vertex { time: 2.9, value: 0.5 },
    ])
    .unwrap();
    // Level, ramp, level, ramp, level.
    let area = -0.3 + 0.5 * 0.8 + 2.0 * 0.6 + 1.25 * 1.2 + 0.5 * 1.1;
    assert_area(trapeze, (0.0, 4.0), area);
    // From the middle of a ramp, and from a corner.
    assert_area(trapeze, (0.7, 1.7), 1.25 * 0.4 + 1.2);
}

#[test]
fn the_plain_method_does_look_beyond() {
    // The counterpart: what the stops are worth.
    let system = Integral(jump(0.55));
    every_solver!(0.1, tolerance(1e-6), |name, solver| {
        let run = solver.plain().solve(&system, 0.0..1.0, Vector1::new(0.0), Output::Uniform(2));
        let error = (run.unwrap().last().unwrap().1[0] - jump_area(0.55, 0.0, 1.0)).abs();
        // A tenth of a step at most, and the tolerance at least in part.
        assert!(error > 1e-9 && error < 0.1, "{name}: {error:e}");
    });
}

#[test]
fn states_that_feed_back_keep_the_order_across_a_jump() {
    // ẋ = u(t) − x with a jump from 0 to 1 at t = 1: x = 1 − e^(1−t).
    #[derive(Debug)]
    struct Lag;
    impl System<f64, 1, 0> for Lag {
        fn rate(&self, t: f64, x: &Vector1<f64>, _: [Branch; 0]) -> Vector1<f64> {
            Vector1::new(if t < 1.0 { 0.0 } else { 1.0 } - x[0])
        }
        fn sliding_velocities(&self, _: f64, _: &Vector1<f64>) -> [f64; 0] {
            []
        }
        fn next_kink(&self, time: f64, towards: f64) -> Option<f64> {
            (time < 1.0 && 1.0 < towards).then_some(1.0)
        }
    }
    every_solver!(0.03, tolerance(1e-9), |name, solver| {
        let run = solver.solve(&Lag, 0.0..3.0, Vector1::new(0.0), Output::Uniform(301)).unwrap();
        for (time, x) in run.iter() {
            let exact = if time < 1.0 { 0.0 } else { -f64::exp_m1(1.0 - time) };
            // h⁴/120 for RK4.
            assert!((x[0] - exact).abs() < 1e-8, "{name}: {x} at {time}");
        }
    });
}

#[test]
fn a_reversal_and_a_jump_at_the_same_time_are_both_met() {
    /// The input jumps and the velocity passes zero at the same time; the state adds both up.
    #[derive(Debug)]
    struct Both(f64);
    impl System<f64, 1> for Both {
        fn rate(&self, t: f64, _: &Vector1<f64>, [branch]: [Branch; 1]) -> Vector1<f64> {
            let input = if t < self.0 { 1.0 } else { 3.0 };
            Vector1::new(input + 10.0 * branch.of(self.0 - t).direction())
        }
        fn sliding_velocities(&self, t: f64, _: &Vector1<f64>) -> [f64; 1] {
            [self.0 - t]
        }
        fn next_kink(&self, time: f64, towards: f64) -> Option<f64> {
            (time < self.0 && self.0 < towards).then_some(self.0)
        }
    }
    for kink in [0.3, 0.5, 1.0, 1.1, 1.7] {
        for step in [0.1, 0.25, 10.0] {
            every_solver!(step, tolerance(1e-6), |name, solver| {
                let area = 11.0 * kink - 7.0 * (2.0 - kink);
                let run =
                    solver.solve(&Both(kink), 0.0..2.0, Vector1::new(0.0), Output::Uniform(2));
                let run = run.unwrap();
                let error = run.last().unwrap().1[0] - area;
                assert!(error.abs() < 1e-12, "{name}, {kink} by {step}: {error:e}");
                assert_eq!(run.statistics().reversals, 1, "{name}, {kink} by {step}");
            });
        }
    }
}

#[test]
fn a_velocity_that_jumps_across_zero_reverses_there() {
    let v = Function::new(|t: f64| (if t < 0.7 { 1.0 } else { -2.0 }, 0.0), [0.7]);
    for step in [0.1, 0.25, 10.0] {
        every_solver!(step, tolerance(1e-6), |name, solver| {
            let system = bristle_specimens::ode::Sided(v);
            let run = solver.solve(&system, 0.0..1.0, Vector1::new(0.0), Output::Uniform(2));
            let run = run.unwrap();
            let error = run.last().unwrap().1[0] - 0.4;
            assert!(error.abs() < 1e-12, "{name} by {step}: {error:e}");
            assert_eq!(run.statistics().reversals, 1, "{name} by {step}");
        });
    }
}

#[test]
fn a_scene_meets_the_kinks_of_its_input() {
    // A mass in stick under a force that jumps to a third of the breakaway force: with the stop
    // at the jump a coarse run agrees with a fine one to its own order.
    let scene = |force| {
        MassSpringDamper::new(MassSpringDamperParameters {
            contact: table_2_frbd().under_load(1.0).unwrap(),
            mechanism: Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 },
            drive_velocity: 0.0,
            force,
        })
        .unwrap()
    };
    let force = Function::new(|t: f64| (if t < 0.0312 { 0.1 } else { 0.5 }, 0.0), [0.0312]);
    let fine = OfAny::fixed(bristle::ode::DormandPrince, 1e-4).unwrap();
    let start = Vector3::zeros();
    let fine = fine.solve(&scene(force), 0.0..0.1, start, Output::Uniform(2)).unwrap();
    let error = |force| {
        let coarse = OfAny::fixed(bristle::ode::DormandPrince, 4e-3).unwrap();
        let coarse = coarse.solve(&scene(force), 0.0..0.1, start, Output::Uniform(2)).unwrap();
        (coarse.last().unwrap().1[2] - fine.last().unwrap().1[2]).abs() / 1.5e-4
    };
    // 0.4 rad per step of a vibration at 100 rad/s: 0.4⁵/5000 per step.
    assert!(error(force) < 1e-4, "{:e}", error(force));
}

/// A ball that is thrown up under a ceiling, x = −½ (t − 1)² by a deflection of h beyond it, and
/// what the ceiling feels, ẇ = k max(x, 0).
struct Ceiling {
    stiffness: f64,
    says: bool,
}

impl System<f64, 3, 0> for Ceiling {
    fn rate(&self, _: f64, x: &Vector3<f64>, _: [Branch; 0]) -> Vector3<f64> {
        Vector3::new(x[1], -1.0, self.stiffness * x[0].max(0.0))
    }

    fn sliding_velocities(&self, _: f64, _: &Vector3<f64>) -> [f64; 0] {
        []
    }

    fn switching_functions(
        &self,
        _: f64,
        x: &Vector3<f64>,
        _: [Branch; 0],
        tell: &mut dyn FnMut(f64),
    ) {
        self.says.then_some(x[0]).map(tell);
    }
}

#[test]
fn a_touch_between_the_stages_is_met_where_a_system_says_what_touches() {
    // ∫ k (h − ½ t²) dt over t² < 2 h, which lasts for 2.8 ms of 2.3 s.
    let (height, stiffness) = (1e-6_f64, 1e9);
    let felt = stiffness * 4.0 / 3.0 * height * (2.0 * height).sqrt();
    let felt_by = |method, says| {
        let start = Vector3::new(height - 0.5, 1.0, 0.0);
        let solver = Solver::checked(method, tolerance(1e-8));
        let run = solver.solve(&Ceiling { stiffness, says }, 0.0..2.3, start, Output::Steps);
        run.map(|run| run.last().unwrap().1[2])
    };
    for method in METHODS {
        let told = felt_by(method, true).unwrap();
        assert!((told - felt).abs() < 1e-5 * felt, "{method:?}: {told} {felt}");
    }
    // Nothing else tells of it.
    assert_eq!(felt_by(METHODS[0], false).unwrap(), 0.0);
}

/// What rests at a zero of the switching function to a rounding, beside what moves.
struct Resting {
    says: bool,
}

impl System<f64, 2, 0> for Resting {
    fn rate(&self, time: f64, x: &Vector2<f64>, _: [Branch; 0]) -> Vector2<f64> {
        Vector2::new(1e2 * (time.sin() - x[0]) + time.cos(), 3.0 * (3.0 * time).cos())
    }

    fn sliding_velocities(&self, _: f64, _: &Vector2<f64>) -> [f64; 0] {
        []
    }

    fn switching_functions(
        &self,
        time: f64,
        x: &Vector2<f64>,
        _: [Branch; 0],
        tell: &mut dyn FnMut(f64),
    ) {
        self.says.then(|| x[0] - time.sin()).map(tell);
    }
}

#[test]
fn what_rests_at_a_zero_shortens_no_steps() {
    for (method, part) in METHODS.into_iter().flat_map(|method| [(method, 1e-3), (method, 1e-6)]) {
        let steps = |says| {
            let solver = Solver::checked(method, tolerance(part));
            let run = solver.solve(&Resting { says }, 0.0..20.0, Vector2::zeros(), Output::Steps);
            let statistics = run.unwrap().statistics();
            (statistics.steps, statistics.rejected)
        };
        assert_eq!(steps(true), steps(false), "{method:?} at {part:e}");
    }
}
