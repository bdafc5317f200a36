//! The coupling of a rolling patch to a mechanism: step-mean force and energy balance.

mod common;

use bristle::rolling::{
    Motion, Patch, PatchParameters, PolynomialExponential, PolynomialExponentialParameters,
};
use bristle::{FrBd, KelvinVoigt, KelvinVoigtParameters, Stribeck, paper};
use common::{assert_within, check};
use proptest::prelude::*;

type Tyre = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;

fn tyre(micro_damping: f64) -> Tyre {
    let bristle =
        KelvinVoigt::new(KelvinVoigtParameters { micro_damping, ..paper::TYRE_BRISTLE }).unwrap();
    FrBd::new(Stribeck::new(paper::TYRE_CURVE).unwrap(), bristle)
}

fn patch<const N: usize>(
    micro_damping: f64,
    pressure: PolynomialExponential<f64, N>,
) -> Patch<f64, Tyre, PolynomialExponential<f64, N>> {
    Patch::new(PatchParameters { model: tyre(micro_damping), length: 0.1, pressure }).unwrap()
}

/// One step: predicted and found slip velocity, V, h.
#[derive(Debug, Clone, Copy)]
struct Step {
    predicted: f64,
    mean: f64,
    transport: f64,
    duration: f64,
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let velocity = || (common::recipe::decades(1e-6, 30.0), any::<bool>());
    let signed = |(v, backward): (f64, bool)| if backward { -v } else { v };
    let step = (
        velocity().prop_map(signed),
        prop_oneof![velocity().prop_map(signed), Just(0.0)],
        prop_oneof![1 => Just(0.0), 5 => common::recipe::decades(0.1, 400.0)],
        common::recipe::decades(1e-5, 3e-2),
    );
    let step = step.prop_map(|(predicted, mean, transport, duration)| Step {
        predicted,
        mean,
        transport,
        duration,
    });
    prop::collection::vec(step, 1..40)
}

#[test]
fn a_patch_whose_pressure_does_not_rise_never_gives_more_than_it_stored() {
    fn holds<const N: usize>(pressure: PolynomialExponential<f64, N>, damping: f64, run: &[Step]) {
        let mut rolling = patch(damping, pressure).exact_in(100).unwrap();
        for step in run {
            let motion =
                Motion { slip_velocity: step.predicted, transport_velocity: step.transport };
            let companion = rolling.companion_step(motion, step.duration).unwrap();
            assert!(companion.damping() >= 0.0);
            let before = companion.bias().abs() + companion.damping() * step.mean.abs();
            let done = companion.commit_with_ledger(step.mean);
            let scale = before * step.mean.abs() * step.duration
                + rolling.stored_energy()
                + done.stored.abs()
                + done.outlet;
            // Every term is right to some roundings of the largest.
            assert!(done.volume >= -1e-12 * scale, "{done:?} of {scale:e} at {step:?}");
            assert!(done.outlet >= 0.0);
        }
    }
    check(300, (steps(), prop_oneof![Just(0.0), 0.0..50.0]), |(run, damping)| {
        holds(PolynomialExponential::constant(), damping, &run);
        holds(PolynomialExponential::exponential(0.7).unwrap(), damping, &run);
        let falling =
            PolynomialExponentialParameters { coefficients: [1.0, -0.3, -0.6], decay: 0.2 };
        holds(PolynomialExponential::new(falling).unwrap(), damping, &run);
    });
}

#[test]
fn the_mean_force_is_the_mean_of_the_force() {
    fn holds<const N: usize>(pressure: PolynomialExponential<f64, N>, run: &[Step]) {
        let mut rolling = patch(1.0, pressure).exact_in(200).unwrap();
        for step in run {
            let motion = Motion { slip_velocity: step.mean, transport_velocity: step.transport };
            // The force at Gauss points of many parts of the step, by plain exact steps.
            let parts = 40;
            let part = step.duration / f64::from(parts);
            let mut walk = rolling.clone();
            let mut mean = 0.0;
            // A step that ends at every node: three-point Gauss–Legendre.
            let nodes = [0.5 - 0.15_f64.sqrt(), 0.5, 0.5 + 0.15_f64.sqrt()];
            let mut last = 0.0;
            for number in 0..parts {
                for (node, weight) in nodes.iter().zip([5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0]) {
                    let at = (f64::from(number) + node) * part;
                    mean += weight / f64::from(parts) * walk.step(motion, at - last).unwrap();
                    last = at;
                }
            }
            let companion = rolling.companion_step(motion, step.duration).unwrap();
            let force = companion.commit(step.mean).force;
            let limit = rolling.patch().normal_force() * 0.66;
            // The quadrature of the test: the force has kinks where segments leave.
            assert_within(1e-5, limit, force, mean, || format!("{step:?}"));
        }
    }
    let short = steps().prop_map(|mut run| {
        run.truncate(6);
        run
    });
    check(100, short, |run| {
        holds(PolynomialExponential::constant(), &run);
        holds(PolynomialExponential::parabolic(), &run);
        holds(PolynomialExponential::exponential(0.7).unwrap(), &run);
    });
}
