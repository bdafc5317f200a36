//! Stiff systems: what the Rosenbrock methods promise, and the default that takes turns.
#![cfg(feature = "alloc")]

use bristle::ode::{
    self, Automatic, DormandPrince, DormandPrince8, Linearisation, Method, Output, Rodas4, Rodas5P,
    Statistics, StopReason, System, Tolerances,
};
use bristle::scene::PrescribedVelocity;
use bristle::signal::{Sine, SineParameters};
use bristle::{Branch, Bristle};
use bristle_specimens::ode::{Field, OfAny, observed_order, rig, table_2_frbd, table_2_lugre};
use nalgebra::{Matrix1, Matrix2, SVector, Vector1, Vector2};

/// ẋ = −λ (x − cos t) − sin t (Prothero and Robinson): x = cos t, whatever λ.
struct Stiff {
    rate: f64,
}

impl System<f64, 1, 0> for Stiff {
    fn rate(&self, t: f64, x: &Vector1<f64>, _: [Branch; 0]) -> Vector1<f64> {
        Vector1::new(-self.rate * (x[0] - t.cos()) - t.sin())
    }

    fn sliding_velocities(&self, _: f64, _: &Vector1<f64>) -> [f64; 0] {
        []
    }

    fn linearised(
        &self,
        t: f64,
        x: &Vector1<f64>,
        branches: [Branch; 0],
    ) -> Option<Linearisation<f64, 1>> {
        Some(Linearisation {
            rate: self.rate(t, x, branches),
            by_state: Matrix1::new(-self.rate),
            by_time: Vector1::new(-self.rate * t.sin() - t.cos()),
        })
    }
}

fn stiff_errors<M: Method<f64, 1>>(method: M, rate: f64) -> Vec<(f64, f64)> {
    let step = |halving: i32| 0.2 * 0.5f64.powi(halving);
    (0..4)
        .map(|halving| {
            let solver = OfAny::fixed(method, step(halving)).unwrap();
            let run = solver.solve(&Stiff { rate }, 0.0..10.0, Vector1::new(1.0), Output::Steps);
            let run = run.unwrap();
            let error = run.iter().map(|(t, x)| (x[0] - t.cos()).abs()).fold(0.0, f64::max);
            (step(halving), error)
        })
        .collect()
}

#[test]
fn stiffness_costs_rodas5p_two_orders_at_most_and_no_accuracy() {
    // hλ from 0.025 to 2e4: worst where hλ is about 1, and falling as 1/λ beyond.
    let worst = stiff_errors(Rodas5P, 10.0)[0].1;
    for rate in [1.0, 10.0, 1e2, 1e3, 1e5] {
        let errors = stiff_errors(Rodas5P, rate);
        assert!(observed_order(&errors) > 2.9, "{rate:e}: {errors:?}");
        for (step, error) in &errors {
            assert!(*error < 2.0 * worst * (step / 0.2).powi(3), "{rate:e}: {errors:?}");
        }
    }
    // Rodas4 was not made for it: its order falls to 1.
    let errors = stiff_errors(Rodas4, 1e5);
    assert!(observed_order(&errors) < 1.5, "{errors:?}");
}

#[test]
fn a_stiff_transient_is_gone_after_one_step() {
    // R(∞) = 0. What is left of the 1 it starts off by is of the order of 1/(hλ).
    fn left<M: Method<f64, 1>>(method: M) -> f64 {
        let solver = OfAny::fixed(method, 0.1).unwrap();
        let run = solver.solve(&Stiff { rate: 1e9 }, 0.0..0.1, Vector1::new(2.0), Output::Steps);
        let run = run.unwrap();
        assert_eq!(run.statistics().steps, 1);
        (run.last().unwrap().1[0] - 0.1f64.cos()).abs()
    }
    // The rest is the error of a smooth step of 0.1.
    assert!(left(Rodas4) < 1e-4, "{}", left(Rodas4));
    assert!(left(Rodas5P) < 1e-4, "{}", left(Rodas5P));
}

#[test]
fn a_state_that_grows_is_no_obstacle_where_the_matrix_is_singular() {
    /// ẍ = x, started on its unstable manifold: x = eᵗ.
    struct Saddle;
    impl System<f64, 2, 0> for Saddle {
        fn rate(&self, _: f64, x: &Vector2<f64>, _: [Branch; 0]) -> Vector2<f64> {
            Vector2::new(x[1], x[0])
        }
        fn sliding_velocities(&self, _: f64, _: &Vector2<f64>) -> [f64; 0] {
            []
        }
        fn linearised(
            &self,
            t: f64,
            x: &Vector2<f64>,
            branches: [Branch; 0],
        ) -> Option<Linearisation<f64, 2>> {
            let by_state = Matrix2::new(0.0, 1.0, 1.0, 0.0);
            Some(Linearisation {
                rate: self.rate(t, x, branches),
                by_state,
                by_time: Vector2::zeros(),
            })
        }
    }
    // I/(hγ) − J is singular at h = 1/γ = 4: refused, and taken again shorter.
    let solver = OfAny::fixed(Rodas4, 4.0).unwrap();
    let run = solver.solve(&Saddle, 0.0..4.0, Vector2::new(1.0, 1.0), Output::Steps).unwrap();
    assert!(run.statistics().rejected > 0);
    let error = run.last().unwrap().1[0] / 4f64.exp() - 1.0;
    assert!(error.abs() < 0.05, "{error}");
}

/// A system whose Jacobian nobody wrote down.
struct WithoutTangent<S>(S);

impl<S: System<f64, N, K>, const N: usize, const K: usize> System<f64, N, K> for WithoutTangent<S> {
    fn rate(&self, t: f64, x: &SVector<f64, N>, branches: [Branch; K]) -> SVector<f64, N> {
        self.0.rate(t, x, branches)
    }
    fn sliding_velocities(&self, t: f64, x: &SVector<f64, N>) -> [f64; K] {
        self.0.sliding_velocities(t, x)
    }
    fn scales(&self) -> SVector<f64, N> {
        System::scales(&self.0)
    }
}

#[test]
fn finite_differences_stand_in_for_a_jacobian() {
    let rig = rig(table_2_frbd::<f64>(), 0.1);
    let tolerances = Tolerances::scaled(1e-7, rig.scales()).unwrap();
    let solver = OfAny::checked(Rodas5P, tolerances);
    let span = 0.0..16.0;
    let known = solver.solve(&rig, span.clone(), rig.at_rest(), Output::Uniform(17)).unwrap();
    let system = WithoutTangent(rig);
    let found = solver.solve(&system, span, rig.at_rest(), Output::Uniform(17)).unwrap();
    for (a, b) in known.states().iter().zip(found.states()) {
        // Through a slip, which magnifies the tolerance some hundred times.
        let apart = (a - b).component_div(&rig.scales()).abs().max();
        assert!(apart < 1e-4, "{apart}");
    }
    let (known, found) = (known.statistics(), found.statistics());
    assert!(found.steps < known.steps + known.steps / 20, "{known}; {found}");
    // N + 2 for each Jacobian, and a little less where the runs differ.
    assert!(found.evaluations > known.evaluations + 4 * found.jacobians, "{known}; {found}");
}

/// Position at t = 25 s, of the stick-slip rig with either model; see `accuracy.rs`.
const FRBD: f64 = 2.231_433_760_84;
const LUGRE: f64 = 2.234_089_300_2;

#[test]
fn the_default_keeps_its_tolerance_from_loose_to_tight() {
    for exponent in 1..=9 {
        let tolerance = 10f64.powi(-exponent);
        let frbd = rig(table_2_frbd::<f64>(), 0.1);
        let run = ode::solve(&frbd, 0.0..25.0, frbd.at_rest(), tolerance, Output::Uniform(2));
        let error = (run.unwrap().last().unwrap().1[0] - FRBD).abs();
        // At one instant; a tenth for loose tolerances, which are tightened.
        let allowed = if exponent <= 4 { 0.1 * tolerance } else { tolerance };
        assert!(error < allowed, "{tolerance:e}: {error:e}");
        let lugre = rig(table_2_lugre::<f64>(), 0.1);
        let run = ode::solve(&lugre, 0.0..25.0, lugre.at_rest(), tolerance, Output::Uniform(2));
        let error = (run.unwrap().last().unwrap().1[0] - LUGRE).abs();
        assert!(error < allowed, "LuGre, {tolerance:e}: {error:e}");
    }
}

fn cost<M: Method<f64, 3>>(method: M) -> Statistics {
    let rig = rig(table_2_lugre::<f64>(), 0.1);
    let tolerances = Tolerances::scaled(1e-7, rig.scales()).unwrap();
    let solver = OfAny::adaptive(method, tolerances);
    let run = solver.solve(&rig, 0.0..25.0, rig.at_rest(), Output::Uniform(2)).unwrap();
    run.statistics()
}

#[test]
fn the_default_takes_turns_both_ways() {
    let automatic = cost(Automatic);
    // Jacobians in some steps and not in others; every slip is stiff with LuGre, every arrest is
    // not.
    assert!(automatic.jacobians > 50, "{automatic}");
    assert!(automatic.jacobians < automatic.steps * 3 / 4, "{automatic}");
    // No explicit method comes near: λ reaches 5000 1/s in each slip.
    let explicit = cost(DormandPrince);
    assert!(10 * automatic.steps < explicit.steps, "{automatic}; {explicit}");
    let implicit = cost(Rodas5P);
    assert!(automatic.steps < implicit.steps, "{automatic}; {implicit}");
}

#[test]
fn what_an_error_estimate_misses_by_chance_does_not_reach_the_solution() {
    // One state, whose estimate of order 5 passes zero now and then.
    let curve = table_2_frbd::<f64>();
    let mut worst = 0.0f64;
    for frequency in [25.0, 50.0, 100.0] {
        let velocity = SineParameters { mean: 0.0055, amplitude: 0.005, frequency, phase: 0.0 };
        let scene =
            PrescribedVelocity::new(curve.under_load(1.0).unwrap(), Sine::new(velocity).unwrap());
        let run = |tolerance: f64| {
            let scales = Vector1::new(1.5e-4);
            let solver =
                OfAny::checked(DormandPrince8, Tolerances::scaled(tolerance, scales).unwrap());
            let span = 0.0..20.0 / frequency;
            solver.solve(&scene, span, Vector1::new(0.0), Output::Dense).unwrap()
        };
        let exact = run(1e-13);
        for exponent in 60..=100 {
            let tolerance = 10f64.powf(-0.1 * f64::from(exponent));
            let coarse = run(tolerance);
            for (time, state) in coarse.iter() {
                let error = (state[0] - exact.at(time).unwrap()[0]).abs() / 1.5e-4;
                worst = worst.max(error / tolerance);
            }
        }
    }
    // It was 53; without the guard 576.
    assert!(worst < 200.0, "{worst}");
}

#[test]
fn the_default_refuses_what_is_no_tolerance() {
    let rig = rig(table_2_frbd::<f64>(), 0.1);
    for tolerance in [0.0, -1e-6, 0.11, 5.0, f64::NAN, f64::INFINITY] {
        let run = ode::solve(&rig, 0.0..1.0, rig.at_rest(), tolerance, Output::Steps);
        let failure = run.unwrap_err();
        let StopReason::Refused(error) = failure.reason else { panic!("{failure}") };
        assert_eq!(error.name, "tolerance");
    }
}

#[test]
fn the_default_runs_in_single_precision() {
    let rig = rig(table_2_frbd::<f32>(), 0.1);
    let run = ode::solve(&rig, 0.0..25.0, rig.at_rest(), 1e-3, Output::Uniform(2)).unwrap();
    let position = f64::from(run.last().unwrap().1[0]);
    assert!((position - FRBD).abs() < 0.05, "{position}");
}

#[test]
fn the_default_needs_no_friction() {
    // Van der Pol's oscillator, now stiff and now not.
    let van_der_pol = Field(|_: f64, x: &Vector2<f64>| {
        Vector2::new(x[1], 1e3 * (1.0 - x[0] * x[0]) * x[1] - x[0])
    });
    let start = Vector2::new(2.0, 0.0);
    let run = ode::solve(&van_der_pol, 0.0..2000.0, start, 1e-4, Output::Uniform(2)).unwrap();
    // Reference at t = 2000: Hairer and Wanner's test set, problem VDPOL at μ = 1000.
    let x = run.last().unwrap().1[0];
    assert!((x - 1.706_167_732_170_483).abs() < 1e-5, "{x}");
    // Each jump multiplies the estimated error by 10¹⁰ for a moment, and steps are as tight as that
    // asks. Those of a step's own tolerance are not.
    let tolerances = Tolerances::scaled(1e-8, Vector2::repeat(1.0)).unwrap();
    let solver = OfAny::adaptive(Automatic, tolerances);
    let run = solver.solve(&van_der_pol, 0.0..2000.0, start, Output::Uniform(2)).unwrap();
    let x = run.last().unwrap().1[0];
    assert!((x - 1.706_167_732_170_483).abs() < 1e-5, "{x}");
    assert!(run.statistics().steps < 5000, "{}", run.statistics());
}
