//! Sampled loops against a controller by hand around a mass that is simulated.

use bristle::ode::{Automatic, Output, Solver, System, Tolerances};
use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
use bristle_periodic::{
    ControlLoop, ControlLoopParameters, Guess, PeriodicError, Pid, Shooting, hunting, hunting_orbit,
};
use nalgebra::{Complex, DMatrix, SVector, Vector3};

use super::{Model, hunting_loop};

/// Position, velocity, deflection, integral and filtered velocity after so many samples.
fn samples(
    of: &ControlLoopParameters<Model>,
    count: usize,
    mut state: SVector<f64, 5>,
) -> SVector<f64, 5> {
    let Pid { proportional, integral, derivative, filter_time, sample_time } = of.controller;
    for _ in 0..count {
        let [x, v, z, sum, filtered] = *state.as_ref();
        let kept = if filter_time > 0.0 { (-sample_time / filter_time).exp() } else { 0.0 };
        let filtered = kept * filtered + (1.0 - kept) * v;
        let force = -proportional * x - integral * sum - derivative * filtered;
        let ControlLoopParameters { contact, mechanism, .. } = *of;
        let mass = MassSpringDamperParameters { contact, mechanism, drive_velocity: 0.0, force };
        let mass = MassSpringDamper::new(mass).unwrap();
        let scales = ControlLoop::sampled(*of).unwrap().scales().fixed_rows::<3>(0).into_owned();
        let solver = Solver::adaptive(Automatic, Tolerances::scaled(1e-13, scales).unwrap());
        let start = Vector3::new(x, v, z);
        let run = solver.solve(&mass, 0.0..sample_time, start, Output::Uniform(2)).unwrap();
        let [x, v, z] = *run.last().unwrap().1.as_ref();
        state = SVector::from([x, v, z, sum + sample_time * state[0], filtered]);
    }
    state
}

/// Eigenvalues of the derivatives of so many samples, by central differences.
fn differences(
    of: &ControlLoopParameters<Model>,
    count: usize,
    state: SVector<f64, 5>,
) -> Vec<Complex<f64>> {
    let scales = ControlLoop::sampled(*of).unwrap().scales();
    let columns = core::array::from_fn::<_, 5, _>(|j| {
        let mut off = SVector::<f64, 5>::zeros();
        off[j] = 1e-6 * scales[j];
        let apart = samples(of, count, state + off) - samples(of, count, state - off);
        apart.component_div(&scales.fixed_rows::<5>(0)) / 2e-6
    });
    let matrix = DMatrix::from_fn(5, 5, |i, j| columns[j][i]);
    matrix.complex_eigenvalues().iter().copied().collect()
}

fn sampled(
    [integral, derivative, filter_time, sample_time]: [f64; 4],
) -> ControlLoopParameters<Model> {
    let controller =
        Pid { integral, derivative, filter_time, sample_time, ..hunting_loop().controller };
    ControlLoopParameters { controller, ..hunting_loop() }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "thousands of samples take a minute without optimisation")]
fn multipliers_of_sampled_loops_are_those_of_differences() {
    // One that repeats after 1299 samples, and one with a filter that never does.
    for (gains, repeats) in [([400.0, 20.0, 0.0, 0.01], true), ([2000.0, 10.0, 5e-3, 0.01], false)]
    {
        let parameters = sampled(gains);
        let system = ControlLoop::sampled(parameters).unwrap();
        let orbit = hunting_orbit(&system, 0.02, 60.0).unwrap();
        let (periods, scales) =
            (orbit.period / 0.01, system.scales().fixed_rows::<5>(0).into_owned());
        let (start, count) = (orbit.start.fixed_rows::<5>(0).into_owned(), periods.round());
        assert_eq!((orbit.forced, (periods - count).abs() < 1e-9), (repeats, repeats), "{orbit:?}");
        // What is left of a sample goes along the change over one.
        let end = samples(&parameters, count as usize, start);
        let on = (samples(&parameters, 1, end) - end) * (periods - count);
        let defect = (end + on - start).component_div(&scales).norm();
        // Newton's corrections end at 1e-10, those of roundings at 1e-7.
        assert!(defect < 1e-7, "{defect:e}");
        let found = orbit.multipliers.map(|it| it.value());
        for wanted in differences(&parameters, count as usize, start) {
            assert!(found.iter().any(|it| (it - wanted).norm() < 1e-5), "{wanted} {found:?}");
        }
        assert!(orbit.is_stable() && orbit.multipliers[0].value().norm() > 0.5);
    }
}

#[test]
fn rest_and_large_motions_of_a_sampled_loop_have_multipliers() {
    for gains in [[400.0, 20.0, 0.0, 0.01], [2000.0, 10.0, 5e-3, 2e-3]] {
        let (parameters, h) = (sampled(gains), gains[3]);
        let report = hunting(&parameters, &[1e-6], 0.1).unwrap();
        let mut moduli: Vec<_> =
            differences(&parameters, 1, SVector::zeros()).iter().map(|it| it.norm()).collect();
        moduli.sort_by(f64::total_cmp);
        // The mass rests anywhere on its bristles; then it creeps. Differences leave 1e-7.
        assert!((moduli[4] - 1.0).abs() < 1e-6, "{moduli:?}");
        let creeps = (report.rest_abscissa * h).exp();
        assert!(report.rest_abscissa < 0.0 && (moduli[3] - creeps).abs() < 1e-6, "{moduli:?}");
    }
    // A held force u moves a free mass by h v + h² u/2 and h u: |μ|² = 1 − h K_D + h² K_P/2.
    let report = hunting(&sampled([0.0, 20.0, 0.0, 0.01]), &[1e-6], 0.1).unwrap();
    let wanted = 0.82_f64.ln() / 0.02;
    assert!((report.large_abscissa - wanted).abs() < 1e-9, "{report}");
}

#[test]
fn sampled_loops_that_do_not_repeat_have_an_answer_with_a_name() {
    let system = ControlLoop::sampled(sampled([0.0, 20.0, 0.0, 0.01])).unwrap();
    let rests = hunting_orbit(&system, 0.02, 10.0);
    assert_eq!(rests, Err(PeriodicError::DoesNotRepeat));
    let (_, jump) = system.samples().unwrap();
    let at = |sample_time: f64, jump, period: f64| {
        let guess = Guess { state: system.displaced(1e-3), period };
        Shooting::default().sampled(&system, (sample_time, jump), guess)
    };
    assert!(at(0.01, jump, 0.1).is_err());
    for refused in [
        at(0.0, jump, 0.1),
        at(f64::NAN, jump, 0.1),
        at(0.01, jump * f64::NAN, 0.1),
        at(0.01, jump, 0.0),
        at(0.01, jump, 1e9),
    ] {
        assert!(matches!(refused, Err(PeriodicError::Refused(_))), "{refused:?}");
    }
}
