//! Nothing is allocated by a run, its construction, a rejection, a reversal or an event. That no
//! step allocates is shown of the machine code, see tests/bare_metal/tests/no_panic.rs.
#![allow(clippy::unwrap_used, reason = "a test panics to fail")]

use core::ops::ControlFlow;

use bristle::curve::Stribeck;
use bristle::exponential::Exponential;
use bristle::ode::{
    Direction, DormandPrince, DormandPrince8, Event, Method, Rodas4, Rodas5P, RungeKutta4, Solver,
    Statistics, Step, Tolerances,
};
use bristle::rheology::KelvinVoigt;
use bristle::scene::MassSpringDamper;
use bristle::signal::{Sine, SineParameters};
use bristle::{Bristle, FrBd, paper};
use bristle_specimens::specimens::table_2;
use nalgebra::Vector3;

type Rig = MassSpringDamper<f64, FrBd<Stribeck<f64>, KelvinVoigt<f64>>>;

fn rig() -> Rig {
    let (curve, bristle) = table_2();
    let contact = FrBd::new(curve, bristle).under_load(1.0).unwrap();
    MassSpringDamper::new(paper::stick_slip_rig(contact)).unwrap()
}

/// Runs over two slips and counts what was allocated.
fn allocations<M: Method<f64, 3>>(solver: &Solver<f64, M, 3>) -> (u64, Statistics) {
    let rig = rig();
    let velocity = |_: f64, state: &Vector3<f64>| state[1] - 0.1;
    let events = [Event { function: &velocity, direction: Direction::Either, stops: false }];
    let mut statistics = Statistics::default();
    let counted = allocation_counter::measure(|| {
        let mut observer = |_: &Step<f64, 3>| ControlFlow::Continue(());
        let summary = solver.stream(&rig, 0.0..20.0, rig.at_rest(), &events, &mut observer);
        statistics = summary.unwrap().statistics;
    });
    (counted.count_total, statistics)
}

#[test]
fn a_streamed_run_allocates_nothing() {
    let tolerances = Tolerances::scaled(1e-6, rig().scales()).unwrap();
    let runs = [
        allocations(&Solver::checked(DormandPrince, tolerances)),
        allocations(&Solver::checked(DormandPrince8, tolerances)),
        allocations(&Solver::adaptive(Rodas4, tolerances)),
        allocations(&Solver::checked(Rodas5P, tolerances)),
        allocations(&Solver::automatic(1e-3, rig().scales()).unwrap()),
        allocations(&Solver::automatic(1e-7, rig().scales()).unwrap()),
    ];
    for (count, statistics) in runs {
        assert!(statistics.rejected > 0 && statistics.reversals > 0, "{statistics}");
        assert_eq!(count, 0, "{statistics}");
    }
    let (count, statistics) = allocations(&Solver::fixed(RungeKutta4, 5e-3).unwrap());
    assert!(statistics.reversals > 0, "{statistics}");
    assert_eq!(count, 0);
}

#[test]
fn samples_of_a_bristle_under_a_known_velocity_allocate_nothing() {
    let contact = rig().parameters().contact;
    let wave = SineParameters { mean: 0.001, amplitude: 0.01, frequency: 25.0, phase: 0.0 };
    let (wave, solver) = (Sine::new(wave).unwrap(), Exponential::<5>.adaptive(1e-8).unwrap());
    let counted = allocation_counter::measure(|| {
        let run = solver.sample(&contact, &wave, 0.0..0.4, 0.0, 101, |_, _| {});
        assert!(run.unwrap().rejected > 0);
    });
    assert_eq!(counted.count_total, 0);
}

#[cfg(feature = "alloc")]
#[test]
fn a_stored_run_does_allocate_and_is_counted() {
    let solver = Solver::fixed(RungeKutta4, 5e-3).unwrap();
    let rig = rig();
    let counted = allocation_counter::measure(|| {
        let output = bristle::ode::Output::Uniform(11);
        solver.solve(&rig, 0.0..1.0, rig.at_rest(), output).unwrap();
    });
    assert!(counted.count_total > 0);
}
