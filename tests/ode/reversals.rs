//! Reversals of a sliding direction: found where they are, however many there are in a step, and
//! not found where there are none.
#![cfg(feature = "alloc")]

use bristle::Branch;
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::ode::{
    self, AnyMethod, DormandPrince, Linearisation, Output, Solver, Statistics, Step, StopReason,
    System, Tolerances,
};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::scene::{MassSpringDamper, MassSpringDamperParameters, PrescribedVelocity};
use bristle::signal::{Function, Polyline, Signal, Sine, SineParameters, Vertex};
use bristle::{Bristle, Dahl, DahlParameters, FrBd, LuGre, Mechanism};
use bristle_specimens::ode::{
    Counted, OfAny, Sided, every_method, every_solver, rig, stick_slip, table_2_frbd, tolerance,
};
use core::cell::Cell;
use core::ops::ControlFlow;
use nalgebra::{Matrix1, Vector1, Vector2, Vector3};

use crate::drawn::distance;

/// A smooth velocity.
fn velocity(v: impl Fn(f64) -> f64 + Clone) -> impl Signal<f64> {
    // The integrators here never ask for the rate of an input.
    Function::new(move |t| (v(t), f64::NAN), [])
}

/// Runs ẋ = sgn v(t) with steps as long as they come, and compares x with the time spent sliding
/// forward less that spent sliding backward, and the number of reversals.
#[track_caller]
fn assert_sides(
    what: &str,
    v: &(impl Signal<f64> + 'static),
    (from, to): (f64, f64),
    forward_less_backward: f64,
    reversals: u64,
) {
    for step in [0.07, 0.3, 0.77, 1.0, 5.0] {
        every_solver!(step, tolerance(1e-6), |name, solver| {
            let system = Sided(v.clone());
            let run = solver.solve(&system, from..to, Vector1::new(0.0), Output::Uniform(2));
            let run = run.unwrap();
            let x = run.last().unwrap().1[0];
            // A reversal is located to a few roundings of a step's length; a grazing one to the
            // square root of that (v changes by no more than a rounding meanwhile).
            let error = (x - forward_less_backward).abs();
            assert!(error < 1e-12, "{what}, {name}, step {step}: off by {error:e}");
            assert_eq!(run.statistics().reversals, reversals, "{what}, {name}, step {step}");
        });
    }
}

#[test]
fn a_velocity_reverses_where_it_changes_its_sign_however_often_in_a_step_and_nowhere_else() {
    let v = velocity(|t| (1.234 - t) * (1.0 + t));
    assert_sides("once", &v, (0.0, 3.0), 1.234 - (3.0 - 1.234), 1);
    // Beyond zero for 2√d, in the middle of a step and away from it.
    for d in [1e-6, 1e-4, 0.03] {
        let dip = 2.0 * f64::sqrt(d);
        let v = velocity(move |t| (t - 1.0) * (t - 1.0) - d);
        assert_sides("dip", &v, (0.0, 2.0), 2.0 - 2.0 * dip, 2);
        let v = velocity(move |t| d - (t - 1.0) * (t - 1.0));
        assert_sides("bump", &v, (0.0, 2.0), 2.0 * dip - 2.0, 2);
        let v = velocity(move |t| (t - 0.3) * (t - 0.3) - d);
        assert_sides("early dip", &v, (0.0, 2.0), 2.0 - 2.0 * dip, 2);
    }
    for above in [0.0, 1e-9, 1e-3] {
        let v = velocity(move |t| (t - 1.0) * (t - 1.0) + above);
        assert_sides("touching", &v, (0.0, 2.0), 2.0, 0);
        let v = velocity(move |t| -(t - 0.9) * (t - 0.9) - above);
        assert_sides("touching from below", &v, (0.0, 2.0), -2.0, 0);
    }
    // A run from zero velocity takes the direction in which it goes.
    for sign in [1.0, -1.0] {
        let from_zero = velocity(move |t| sign * t);
        assert_sides("from zero", &from_zero, (0.0, 2.0), sign * 2.0, 0);
        every_solver!(0.3, tolerance(1e-6), |name, solver| {
            let system = Sided(from_zero.clone());
            let run = solver.solve(&system, 0.0..2.0, Vector1::new(0.0), Output::Uniform(2));
            // The acceleration tells it: no trial is lost.
            assert_eq!(run.unwrap().statistics().rejected, 0, "{name}, {sign}");
        });
        let v = velocity(move |t| sign * t * t);
        assert_sides("from a flat zero", &v, (0.0, 2.0), sign * 2.0, 0);
        let v = velocity(move |t| sign * (1.0 - t));
        assert_sides("to zero at the end", &v, (0.0, 1.0), sign, 0);
        // Back for 0.3 s, then forth: the zero at the start is not the reversal.
        let v = velocity(move |t| sign * t * (t - 0.3));
        assert_sides("back and forth", &v, (0.0, 2.0), sign * (1.7 - 0.3), 1);
    }
}

#[test]
fn a_step_cut_at_a_reversal_is_as_exact_as_any_other() {
    /// ẋ = n tⁿ⁻¹ + sgn v(t), v = 0.73 − t: exact for a method of order n, but not for its dense
    /// output.
    #[derive(Debug)]
    struct Power(i32);
    impl System<f64, 1> for Power {
        fn rate(&self, t: f64, _: &Vector1<f64>, [branch]: [Branch; 1]) -> Vector1<f64> {
            let direction = branch.of(0.73 - t).direction();
            Vector1::new(f64::from(self.0) * t.powi(self.0 - 1) + direction)
        }
        fn linearised(
            &self,
            t: f64,
            x: &Vector1<f64>,
            branches: [Branch; 1],
        ) -> Option<Linearisation<f64, 1>> {
            let bend = f64::from(self.0 * (self.0 - 1)) * t.powi(self.0 - 2);
            let (rate, by_state) = (self.rate(t, x, branches), Matrix1::zeros());
            Some(Linearisation { rate, by_state, by_time: Vector1::new(bend) })
        }
        fn sliding_velocities(&self, t: f64, _: &Vector1<f64>) -> [f64; 1] {
            [0.73 - t]
        }
    }
    every_method!(|name, method, order, dense| {
        let solver = OfAny::fixed(method, 0.5).unwrap();
        let power = Power(order as i32);
        let run = solver.solve(&power, 0.0..2.0, Vector1::new(0.0), Output::Steps).unwrap();
        for (time, x) in run.iter() {
            let sided = if time < 0.73 { time } else { 1.46 - time };
            let exact = time.powi(order as i32) + sided;
            // A few roundings of values of up to 32 or 256, magnified by the Rosenbrock methods'
            // weights of up to a hundred.
            assert!((x[0] - exact).abs() < 2e-12, "{name}: {x} at {time}");
        }
        assert_eq!(run.statistics().reversals, 1, "{name}");
    });
}

#[test]
fn a_rig_that_starts_a_little_ahead_of_its_drive_is_first_pulled_back() {
    // The spring pulls back for a millisecond or so, then forth, within the first step.
    for ahead in [1e-6, 1e-4, 1e-3] {
        for drive in [0.1, -0.1] {
            let rig = rig(table_2_frbd::<f64>(), drive);
            let start = Vector3::new(ahead * drive.signum(), 0.0, 0.0);
            let fine = OfAny::fixed(bristle::ode::DormandPrince, 1e-4).unwrap();
            let fine = fine.solve(&rig, 0.0..0.5, start, Output::Uniform(2)).unwrap();
            for step in [1e-3, 4e-3, 0.01] {
                let tolerances = Tolerances::scaled(1e-6, rig.scales()).unwrap();
                every_solver!(step, tolerances, |name, solver| {
                    let run = solver.solve(&rig, 0.0..0.5, start, Output::Uniform(2)).unwrap();
                    let error = run.last().unwrap().1 - fine.last().unwrap().1;
                    let error = error.component_div(&rig.scales()).abs().max();
                    // A whole radian of the stuck mass in a step of 0.01 s: RK4 keeps three digits
                    // of a vibration that is a hundredth of breakaway.
                    assert!(error < 2e-4, "{name} by {step}, from {ahead}: {error:e}");
                });
            }
        }
    }
}

#[test]
fn the_branch_of_a_run_is_the_direction_of_sliding() {
    let v = velocity(|t| 1.0 - t);
    every_solver!(0.1, tolerance(1e-6), |name, solver| {
        let system = Sided(v.clone());
        let mut run = solver.begin(&system, 0.0..2.0, Vector1::new(0.0)).unwrap();
        assert_eq!(run.branches(), [Branch::Forward], "{name}");
        while run.advance().unwrap().is_some() {}
        assert_eq!(run.branches(), [Branch::Backward], "{name}");
    });
}

#[test]
fn what_is_smaller_than_the_tolerance_is_noise_and_not_a_reversal() {
    /// A velocity a sin t and its rate as states, in this or the other order: the velocity is
    /// known to a tolerance only.
    #[derive(Debug)]
    struct Tremor(usize);
    impl System<f64, 2> for Tremor {
        fn rate(&self, _: f64, x: &Vector2<f64>, _: [Branch; 1]) -> Vector2<f64> {
            let mut rate = Vector2::new(x[1], x[0]);
            rate[1 - self.0] *= -1.0;
            rate
        }
        fn sliding_velocities(&self, _: f64, x: &Vector2<f64>) -> [f64; 1] {
            [x[self.0]]
        }
    }
    impl Tremor {
        fn start(&self, amplitude: f64) -> Vector2<f64> {
            let mut start = Vector2::zeros();
            start[1 - self.0] = amplitude;
            start
        }
    }
    // A part of the absolute tolerance of a step is allowed for: at least a thousandth, and never
    // more than the whole. Of 1e-6 the steps of this method are given 1.25e-9.
    let solver = OfAny::checked(bristle::ode::DormandPrince, tolerance(1e-6));
    let solver = solver.with_largest_step(0.1).unwrap();
    for tremor in [Tremor(0), Tremor(1)] {
        let reversals = |amplitude: f64| {
            let start = tremor.start(amplitude);
            let run = solver.solve(&tremor, 0.0..20.0, start, Output::Uniform(2)).unwrap();
            run.statistics().reversals
        };
        assert_eq!(reversals(0.5e-12), 0);
        // π, 2π … 6π lie within twenty seconds.
        assert_eq!(reversals(1e-8), 6);
        assert_eq!(reversals(1.0), 6);
        // A fixed step has no tolerance, and every sign counts.
        let solver = OfAny::fixed(bristle::ode::RungeKutta4, 0.1).unwrap();
        let run = solver.solve(&tremor, 0.0..20.0, tremor.start(0.5e-12), Output::Uniform(2));
        assert_eq!(run.unwrap().statistics().reversals, 6);
    }
}

#[test]
fn what_is_at_rest_stays_at_rest() {
    // The drive stands still, the spring is slack.
    let rig = rig(table_2_frbd::<f64>(), 0.0);
    every_solver!(0.01, Tolerances::scaled(1e-6, rig.scales()).unwrap(), |name, solver| {
        let run = solver.solve(&rig, 0.0..50.0, rig.at_rest(), Output::Uniform(3)).unwrap();
        assert_eq!(*run.last().unwrap().1, Vector3::zeros(), "{name}");
        assert_eq!(run.statistics().reversals, 0, "{name}");
        assert_eq!(run.statistics().rejected, 0, "{name}");
    });
}

#[test]
fn a_rig_starts_from_rest_without_acceleration() {
    // At t = 0 the spring is slack: velocity, acceleration and deflection are all zero.
    for drive in [0.1, -0.1] {
        let rig = rig(table_2_frbd::<f64>(), drive);
        every_solver!(5e-3, Tolerances::scaled(1e-6, rig.scales()).unwrap(), |name, solver| {
            let run = solver.solve(&rig, 0.0..1.0, rig.at_rest(), Output::Uniform(2)).unwrap();
            let state = run.last().unwrap().1;
            // Stuck: the bristle carries the spring, F = p σ0 z = k v_ref t, but for the creep of
            // FrBD below breakaway dF/dx = p σ0 (1 − F/F_b), within two per cent here.
            let deflection = 2.0 * drive / 1e4;
            assert!((state[2] / deflection - 1.0).abs() < 0.02, "{name}: {state}");
            // Without velocity and acceleration the first direction is that of the jerk.
            assert_eq!(run.statistics().reversals, 0, "{name}, driven at {drive}");
        });
    }
}

#[test]
fn an_oscillation_that_dies_out_ends_at_rest_and_not_in_reversals() {
    let rig = rig(table_2_frbd::<f64>(), 0.0);
    for start in [Vector3::new(0.1, 0.0, 0.0), Vector3::new(0.0, 0.05, 0.0)] {
        every_solver!(0.01, Tolerances::scaled(1e-6, rig.scales()).unwrap(), |name, solver| {
            let system = Counted::new(rig);
            let run = solver.solve(&system, 0.0..60.0, start, Output::Uniform(2)).unwrap();
            let state = run.last().unwrap().1;
            // The stuck mass is damped out; what is left is slow creep, and the noise of the
            // tolerance.
            assert!(state[1].abs() < 1e-6, "{name}: {state}");
            // In equilibrium the bristle carries the spring.
            let friction = rig.friction_force(state);
            assert!((friction + 2.0 * state[0]).abs() < 1e-5, "{name}: {friction} {state}");
            // Each step is split once at the most; 60 s at the step that the stuck mass allows
            // (0.028 s for order 4) are 2200 steps, and 6000 at the fixed one.
            let Statistics { steps, reversals, .. } = run.statistics();
            assert!(reversals <= steps && steps < 12_000, "{name}: {}", run.statistics());
            assert!(system.calls.get() < 100_000, "{name}: {}", run.statistics());
        });
    }
}

/// Dry friction without a bristle under a force of half its strength: at v = 0 the rate is −0.5 on
/// one side and 1.5 on the other, and there is no solution on either.
#[derive(Debug, Default)]
struct DryFriction {
    /// Evaluations at t = 0.
    starts: Cell<u32>,
}

impl System<f64, 1> for DryFriction {
    fn rate(&self, time: f64, v: &Vector1<f64>, [branch]: [Branch; 1]) -> Vector1<f64> {
        self.starts.set(self.starts.get() + u32::from(time == 0.0));
        Vector1::new(0.5 - branch.of(v[0]).direction())
    }

    fn sliding_velocities(&self, _: f64, v: &Vector1<f64>) -> [f64; 1] {
        [v[0]]
    }
}

#[test]
fn a_run_that_ends_in_endless_reversals_is_not_repeated() {
    let solver = Solver::checked(DormandPrince, tolerance(1e-6));
    let (once, system) = (DryFriction::default(), DryFriction::default());
    let start = Vector1::new(1.0);
    // A stream cannot be repeated.
    let mut observer = |_: &Step<f64, 1>| ControlFlow::Continue(());
    solver.stream(&once, 0.0..10.0, start, &[], &mut observer).unwrap_err();
    let stopped = solver.solve(&system, 0.0..10.0, start, Output::Steps).unwrap_err();
    assert_eq!(stopped.reason, StopReason::EndlessReversals { contact: 0 });
    assert_eq!(system.starts, once.starts);
}

#[test]
fn a_field_that_jumps_at_rest_ends_in_an_error_that_says_so() {
    every_solver!(0.01, tolerance(1e-6), |name, solver| {
        let system = Counted::new(DryFriction::default());
        // A limit, so that the test ends if the run does not.
        let solver = solver.with_most_steps(100_000);
        let run = solver.solve(&system, 0.0..10.0, Vector1::new(1.0), Output::Steps);
        match run {
            // A Rosenbrock method on the free branch may take the jump for a steep slope, and hold
            // the velocity at zero, as dry friction does.
            Ok(run) => {
                assert!(name.contains("Rodas") || name.contains("Automatic"), "{name} answers");
                assert!(run.last().unwrap().1[0].abs() < 1e-6, "{name}: slides on");
            }
            Err(stopped) => {
                let reason = stopped.reason;
                assert!(
                    matches!(
                        reason,
                        StopReason::EndlessReversals { contact: 0 }
                            | StopReason::StepTooSmall { .. }
                    ),
                    "{name}: {reason:?}, {}",
                    stopped.statistics
                );
                assert!(system.calls.get() < 100_000, "{name}: {} calls", system.calls.get());
                // Until v = 1 − t/2 comes to rest at t = 2 all is well, and that is kept.
                let (time, state) = stopped.trajectory.as_ref().unwrap().last().unwrap();
                assert!(time >= 2.0 - 1e-9 && time == stopped.time, "{name}: {time}");
                assert!(state[0].abs() < 0.01, "{name}: {state}");
                let slid =
                    stopped.trajectory.as_ref().unwrap().iter().filter(|&(t, _)| t < 2.0 - 1e-6);
                for (t, v) in slid {
                    assert!((v[0] - (1.0 - t / 2.0)).abs() < 1e-9, "{name}: {v} at {t}");
                }
            }
        }
    });
}

#[test]
fn a_field_that_jumps_at_rest_is_no_obstacle_while_it_is_passed() {
    /// The same under a force that wins.
    #[derive(Debug)]
    struct DryFriction;
    impl System<f64, 1> for DryFriction {
        fn rate(&self, _: f64, v: &Vector1<f64>, [branch]: [Branch; 1]) -> Vector1<f64> {
            Vector1::new(-3.0 - branch.of(v[0]).direction())
        }
        fn sliding_velocities(&self, _: f64, v: &Vector1<f64>) -> [f64; 1] {
            [v[0]]
        }
    }
    for step in [0.01, 0.3, 5.0] {
        every_solver!(step, tolerance(1e-6), |name, solver| {
            let run = solver.solve(&DryFriction, 0.0..1.0, Vector1::new(1.0), Output::Uniform(2));
            let run = run.unwrap();
            // v = 1 − 4t to rest at t = 1/4, then −2(t − 1/4).
            let v = run.last().unwrap().1[0];
            assert!((v + 1.5).abs() < 1e-12, "{name}: {v}");
            assert_eq!(run.statistics().reversals, 1, "{name}");
        });
    }
}

/// A mass of 1 kg, pushed backward by 20 N against a friction of 1.5 N at most.
fn pushed() -> MassSpringDamper<f64, FrBd<Stribeck<f64>, KelvinVoigt<f64>>> {
    MassSpringDamper::new(MassSpringDamperParameters {
        contact: table_2_frbd().under_load(1.0).unwrap(),
        mechanism: Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 },
        drive_velocity: 0.0,
        force: -20.0,
    })
    .unwrap()
}

#[test]
fn a_step_across_the_pole_of_a_locked_branch_is_taken_again() {
    let mass = pushed();
    // Beyond a third of the way to the pole the model answers no more.
    let rate = |v| mass.parameters().contact.rate(Branch::Forward.of(v), 1e-4);
    assert!(rate(-0.1).is_nan() && rate(-0.004).is_finite());
    // From 0.1 m/s to −0.3 m/s in a step of 0.02 s; the pole is at −0.0155 m/s. Smaller steps
    // serve as reference.
    let fine = |step: f64| {
        let solver = OfAny::fixed(bristle::ode::DormandPrince, step).unwrap();
        let start = Vector3::new(0.0, 0.1, 1e-4);
        let run = solver.solve(&mass, 0.0..0.1, start, Output::Uniform(2)).unwrap();
        *run.last().unwrap().1
    };
    let reference = fine(1e-5);
    for step in [0.008, 0.012, 0.015] {
        every_solver!(step, Tolerances::scaled(1e-6, mass.scales()).unwrap(), |name, solver| {
            let start = Vector3::new(0.0, 0.1, 1e-4);
            let run = solver.solve(&mass, 0.0..0.1, start, Output::Uniform(51)).unwrap();
            for (t, state) in run.iter() {
                assert!(state.iter().all(|x| x.is_finite()), "{name}: {state} at {t}");
            }
            let state = run.last().unwrap().1;
            // The friction of 1.5 N at most, wrong for a step or two, of 20 N: a few per cent of
            // a step's change of 0.3 m/s.
            assert!((state[1] - reference[1]).abs() < 0.02, "{name}: {state} {reference}");
            assert_eq!(run.statistics().reversals, 1, "{name}: {}", run.statistics());
        });
    }
}

#[test]
fn a_fixed_step_returns_to_its_grid_after_a_pole() {
    let mass = pushed();
    let step = 0.01;
    let solver = OfAny::fixed(bristle::ode::RungeKutta4, step).unwrap();
    let start = Vector3::new(0.0, 0.1, 1e-4);
    let run = solver.solve(&mass, 0.0..0.2, start, Output::Steps).unwrap();
    for k in 0..=20 {
        // k·h is the grid, to the rounding of the product.
        let grid = step * f64::from(k);
        let near = run.times().iter().any(|t| (t - grid).abs() < 1e-15);
        assert!(near, "{grid} is not among {:?}", run.times());
    }
    // Back to whole steps in doublings: two or three at each of the few poles.
    assert!(run.times().len() < 40, "{:?}", run.times());
    // The last ten steps are whole again.
    let times = run.times();
    for pair in times[times.len() - 10..].windows(2) {
        assert!((pair[1] - pair[0] - step).abs() < 1e-15, "{pair:?}");
    }
}

#[test]
fn a_step_near_the_pole_of_a_locked_branch_does_no_harm() {
    // Half of the stability limit of the bristle (0.018 s), but some stage or other of these runs
    // comes so near to the pole that its rate is a thousand times too large, and finite.
    let force = Sine::new(SineParameters {
        mean: -0.146_383_753_276_418_28,
        amplitude: 1.769_909_812_274_547,
        frequency: 1.5684,
        phase: 0.0,
    });
    let mass = MassSpringDamper::new(MassSpringDamperParameters {
        contact: table_2_frbd::<f64>().under_load(1.0).unwrap(),
        mechanism: Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 },
        drive_velocity: 0.0,
        force: force.unwrap(),
    })
    .unwrap();
    for i in 0..30 {
        every_method!(|name, method, order, dense| {
            let step = 0.01 + 2e-5 * f64::from(i);
            let solver = OfAny::fixed(method, step).unwrap();
            let run = solver.solve(&mass, 0.0..4.0, mass.at_rest(), Output::Steps).unwrap();
            for (time, state) in run.iter() {
                // The bound of the model is μ_s/σ0 = 1.5e-4 ; a third more for
                // the error of a coarse step.
                assert!(state[2].abs() < 2e-4, "{name} by {step}: {state} at {time}");
            }
        });
    }
}

#[test]
fn an_adaptive_run_of_the_rig_reverses_as_often_as_a_fine_one() {
    // Fewer reversals would be slips missed, more would be chatter.
    let rig = stick_slip();
    let count = |relative: f64| {
        let tolerances = Tolerances::scaled(relative, rig.scales()).unwrap();
        let solver = OfAny::checked(bristle::ode::DormandPrince, tolerances);
        let run = solver.solve(&rig, 0.0..25.0, rig.at_rest(), Output::Uniform(2)).unwrap();
        run.statistics().reversals
    };
    let solver = OfAny::fixed(bristle::ode::RungeKutta4, 2e-3).unwrap();
    let fine = solver.solve(&rig, 0.0..25.0, rig.at_rest(), Output::Uniform(2)).unwrap();
    let fine = fine.statistics().reversals;
    assert_eq!([count(1e-6), count(1e-8)], [fine, fine]);
}

#[test]
fn a_creeping_contact_is_not_kept_on_the_wrong_branch() {
    // On the wrong branch the bristle is not relaxed but driven, beyond its bound of 1.5e-4 m and
    // without end. A velocity that grows a little at each small step must not be forgiven for it.
    for (mass, relative) in [(0.1, 1e-3), (0.1, 1e-4), (0.03, 1e-4), (0.01, 1e-5)] {
        let contact = table_2_frbd::<f64>().under_load(1.0).unwrap();
        let parameters = bristle::paper::stick_slip_rig(contact);
        let mechanism = Mechanism { mass, ..parameters.mechanism };
        let rig = MassSpringDamper::new(MassSpringDamperParameters { mechanism, ..parameters });
        let rig = rig.unwrap();
        let tolerances = Tolerances::scaled(relative, rig.scales()).unwrap();
        let solver = OfAny::checked(bristle::ode::DormandPrince, tolerances);
        for solver in [solver, solver.with_largest_step(1e-3).unwrap()] {
            let run = solver.solve(&rig, 0.0..12.0, rig.at_rest(), Output::Steps).unwrap();
            let most = run.states().iter().map(|state| state[2].abs()).fold(0.0, f64::max);
            // Two per cent for the error of so loose a tolerance.
            assert!(most < 1.53e-4, "{mass} kg at {relative:e}: {most:e}");
        }
    }
}

/// Within millionths of a second of a reversal a body is slower than the Stribeck velocity, and its
/// bristle tends to another deflection. No stage of a step lies there: samples were off by 1 158 to
/// 5 792 tolerances.
#[test]
fn the_peak_of_the_curve_at_a_fast_reversal_is_seen() {
    for (deceleration, micro_stiffness) in [(700.0, 300.0), (700.0, 3e3), (1500.0, 3e3)] {
        let curve = Stribeck::new(StribeckParameters {
            static_coefficient: 1.5,
            dynamic_coefficient: 1.0,
            stribeck_velocity: 1e-3,
            stribeck_exponent: 2.0,
            viscous_friction: 0.0,
        });
        let bristle = KelvinVoigtParameters { micro_stiffness, micro_damping: 0.0 };
        let friction = LuGre::classical(curve.unwrap(), KelvinVoigt::new(bristle).unwrap());
        let value = 0.004 * deceleration;
        let ends = [Vertex { time: 0.0, value }, Vertex { time: 0.008, value: -value }];
        let contact = friction.under_load(1.0).unwrap();
        let scene = PrescribedVelocity::new(contact, Polyline::new(ends).unwrap());
        let (scales, span, output) = (scene.scales(), 0.0..0.008, Output::Uniform(801));
        let start = Vector1::new(1.0 / micro_stiffness);
        let fine = Tolerances::scaled(1e-13, scales).unwrap();
        let fine = Solver::adaptive(AnyMethod::Rodas5P, fine).with_largest_step(2e-7).unwrap();
        let fine = fine.solve(&scene, span.clone(), start, output).unwrap();
        let run = ode::solve(&scene, span, start, 1e-10, output).unwrap();
        let worst = distance(&run, &fine, &scales) / 1e-10;
        assert!(worst < 20.0, "{deceleration} {micro_stiffness}: {worst}");
    }
}

/// A table of positions has a velocity in steps. With Dahl's model z goes to ±μ/σ0 on exponentials.
#[test]
fn a_velocity_that_jumps_across_zero_reverses_at_its_kink() {
    let jumps = |t: f64| if (0.5..0.8).contains(&t) { (-0.2, 0.0) } else { (0.1, 0.0) };
    let velocity = Function::new(jumps, [0.5, 0.8]);
    assert_sides("jumps", &velocity, (0.0, 1.0), 0.4, 2);
    let far = 1e-3; // [m]
    let parameters = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: 0.5 / far };
    let contact = Dahl::new(parameters).unwrap().under_load(1.0).unwrap();
    let scene = PrescribedVelocity::new(contact, velocity);
    every_solver!(1e-4, tolerance(1e-8), |name, solver| {
        let run = solver.solve(&scene, 0.0..1.0, Vector1::zeros(), Output::Steps).unwrap();
        for (time, z) in run.iter() {
            let relaxed = |from: f64, to: f64, way: f64| to + (from - to) * (-way / far).exp();
            let first = relaxed(0.0, far, 0.1 * time.min(0.5));
            let second = relaxed(first, -far, 0.2 * (time.min(0.8) - 0.5).max(0.0));
            let want = relaxed(second, far, 0.1 * (time - 0.8).max(0.0));
            assert!((z[0] - want).abs() < 1e-6 * far, "{name} at {time}: {} for {want}", z[0]);
        }
        let at: Vec<f64> = run.reversals().iter().map(|it| it.time).collect();
        assert_eq!(at, [0.5, 0.8], "{name}");
    });
}
