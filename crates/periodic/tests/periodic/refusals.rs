//! What is refused, and what it is called; nothing is asked of a system beyond a range.

use std::cell::Cell;

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::ode::System;
use bristle::parameter::ParameterError;
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, FrBd};
use bristle_periodic::{
    BranchEnd, Continuation, ControlLoop, Guess, Outcome, PeriodicError, Pid, PointKind, Shooting,
    hunting, hunting_orbit,
};
use nalgebra::{Matrix1, Matrix2, Vector1, Vector2};

use super::special::Field;
use super::stiff_loop;

/// ṙ = r (p + r² − r⁴), φ̇ = 1: cycles r² = ½ ± √(¼ + p), of 2π s, that fold at p = −¼. The outer
/// ones are stable.
fn folds(p: f64) -> impl System<f64, 2, 0> {
    Field(move |state: &Vector2<f64>| {
        let (x, y) = (state[0], state[1]);
        let square = x * x + y * y;
        let (growth, slope) = (p + square - square * square, 2.0 - 4.0 * square);
        let by_state = Matrix2::new(
            growth + slope * x * x,
            slope * x * y - 1.0,
            slope * x * y + 1.0,
            growth + slope * y * y,
        );
        (Vector2::new(growth * x - y, growth * y + x), by_state)
    })
}

#[test]
fn a_branch_stays_within_its_range() {
    let (start, lowest, highest) = (1.0, Cell::new(f64::INFINITY), Cell::new(f64::NEG_INFINITY));
    let system = |p: f64| -> Result<_, ParameterError> {
        lowest.set(p.min(lowest.get()));
        highest.set(p.max(highest.get()));
        Ok(folds(p))
    };
    let state = Vector2::new((0.5 + 1.25_f64.sqrt()).sqrt(), 0.0);
    let guess = Guess { state, period: std::f64::consts::TAU };
    // The fold lies near the end of a range that is wide, and is far from one that is not.
    for (range, first_step) in [(-0.26..3.0, -0.02), (-1.0..30.0, -20.0)] {
        let along = Continuation { first_step, ..Continuation::over(range.clone()) };
        let border = along.border(system, start, guess).unwrap().unwrap();
        let off = (border.parameter + 0.25).abs();
        assert!(border.kind == PointKind::Fold && off < 1e-6, "{off:e}");
        assert!(lowest.get() >= range.start && highest.get() <= range.end, "{lowest:?}");
    }
    lowest.set(start);
    for (range, first_step, end) in [(0.5..1.5, 0.3, 1.5), (0.5..1.5, -0.3, 0.5)] {
        let along = Continuation { first_step, ..Continuation::over(range) };
        highest.set(start);
        let branch = along.free(system, start, guess).unwrap();
        let last = branch.points.last().unwrap().parameter;
        assert_eq!((branch.end, last), (BranchEnd::Range, end));
        assert_eq!(along.border(system, start, guess), Ok(None));
        assert!(lowest.get() >= 0.5 && highest.get() <= 1.5);
    }
}

#[test]
fn a_start_outside_the_range_is_refused() {
    let guess = Guess { state: Vector2::new(1.3, 0.0), period: std::f64::consts::TAU };
    for (range, first_step) in [(4.0..5.0, 0.01), (0.1..0.2, -0.01)] {
        let along = Continuation { first_step, ..Continuation::over(range.clone()) };
        let system = |p: f64| Ok(folds(p));
        let forced = along.forced(system, |_| 1.0, 1.0, guess.state).map(drop);
        let free = along.free(system, 1.0, guess).map(drop);
        for refused in [forced, free, along.border(system, 1.0, guess).map(drop)] {
            let wanted = format!("parameter is 1, but must lie between {} and", range.start);
            assert!(refused.unwrap_err().to_string().starts_with(&wanted), "{refused:?}");
        }
    }
}

#[test]
fn a_loop_that_rests_or_grows_has_no_cycle() {
    let orbit = |proportional: f64, integral: f64, duration: f64| {
        let mut parameters = stiff_loop();
        parameters.controller = Pid { proportional, integral, ..parameters.controller };
        hunting_orbit(&ControlLoop::new(parameters).unwrap(), 5e-3, duration)
    };
    for duration in [5.0, 20.0, 30.0, 60.0] {
        assert_eq!(orbit(2e4, 1e5, duration), Err(PeriodicError::DoesNotRepeat));
    }
    assert_eq!(orbit(5e3, 1e6, 30.0), Err(PeriodicError::Grows));
    // At 1e16 1/s friction is no longer a number.
    assert_eq!(orbit(5e3, 1e50, 30.0), Err(PeriodicError::Grows));
}

#[test]
fn growth_has_its_rate_however_fast_it_is() {
    // m (s + 2b + d) ((s − b)² + 3b² + 2bd + e) = m s³ + m d s² + m e s + K_I.
    let (b, d, e) = (1e4, 40.0, 1e3);
    let mut fast = stiff_loop();
    fast.controller.integral = 5.0 * (2.0 * b + d) * (4.0 * b * b + 2.0 * b * d + e);
    let report = hunting(&fast, &[1e-3], 1.0).unwrap();
    assert!((report.large_abscissa / b - 1.0).abs() < 1e-9, "{report}");
    assert!(report.rest_abscissa > 0.0 && report.outcomes[0].1 == Outcome::Grows, "{report}");
    // m s³ + K_I, as far as digits go.
    let mut slow = stiff_loop();
    slow.mechanism.mass = 1e100;
    let report = hunting(&slow, &[1e-3], 1.0).unwrap();
    let wanted = 0.5 * 1e-95_f64.cbrt();
    assert!((report.large_abscissa / wanted - 1.0).abs() < 1e-6, "{report}");
}

/// A bristle about to yield has a derivative of nearly zero. A difference to one side took it for a
/// wrong one, and said that the derivatives of component 2 were not those of its rate.
#[test]
fn a_mass_that_creeps_towards_breakaway_has_an_answer() {
    for (integral, derivative, start) in
        [(0.5, 60.0, 2e-3), (10.0, 60.0, 5e-3), (50.0, 60.0, 5e-4), (20.0, 200.0, 7e-3)]
    {
        let curve = StribeckParameters {
            static_coefficient: 0.5,
            dynamic_coefficient: 0.35,
            stribeck_velocity: 2e-3,
            stribeck_exponent: 2.0,
            viscous_friction: 0.0,
        };
        let bristle = KelvinVoigtParameters { micro_stiffness: 5e4, micro_damping: 70.0 };
        let (curve, bristle) = (Stribeck::new(curve), KelvinVoigt::new(bristle));
        let mut creeping = stiff_loop();
        creeping.contact = FrBd::new(curve.unwrap(), bristle.unwrap()).under_load(20.0).unwrap();
        creeping.mechanism.mass = 2.0;
        let gains = Pid { proportional: 2000.0, integral, derivative, ..creeping.controller };
        creeping.controller = gains;
        let found = creeping.outcome(start, 120.0);
        assert!(found.is_ok(), "{integral} {derivative}: {found:?}");
    }
}

#[test]
fn a_loop_that_sticks_for_several_swings_hunts() {
    let mut slow = stiff_loop();
    slow.controller.integral = 5e4;
    // It sticks for some 0.9 s, four periods of the mass on the controller's stiffness.
    let period = |duration| match slow.outcome(5e-3, duration).unwrap() {
        Outcome::Hunts(cycle) => cycle.period,
        _ => f64::NAN,
    };
    // A short simulation knows it to 1 %.
    assert!((period(1.0) / period(30.0) - 1.0).abs() < 0.01, "{}", period(1.0));
}

#[test]
fn a_report_says_why_it_has_no_cycle() {
    let report = hunting(&stiff_loop(), &[1e-3], 1e-12).unwrap();
    assert!(report.hunts() && report.cycle == Some(Err(PeriodicError::DoesNotRepeat)), "{report}");
    assert!(report.to_string().contains("its cycle      not found: the motion does not repeat"));
}

#[test]
fn what_is_refused_is_called_by_its_name() {
    let named = |error: PeriodicError, name: &str| {
        assert!(error.to_string().starts_with(name), "{error}");
    };
    let folds = folds(1.0);
    let (state, shooting) = (Vector2::new(1.3, 0.0), Shooting::default());
    for (period, name) in [(-1.0, "-1,"), (0.0, "0,"), (f64::NAN, "NaN,"), (f64::INFINITY, "inf,")]
    {
        let name = format!("period is {name}");
        named(shooting.free(&folds, Guess { state, period }).unwrap_err(), &name);
        named(shooting.forced(&folds, (0.0, period), state).unwrap_err(), &name);
    }
    let many = Shooting { segments: 100, tolerance: 1e-4, ..shooting };
    let guess = Guess { state, period: std::f64::consts::TAU };
    named(many.free(&folds, guess).unwrap_err(), "segments is 100");
    for first_step in [0.0, f64::NAN] {
        let along = Continuation { first_step, ..Continuation::over(0.5..1.5) };
        let refused = along.free(|_| Ok(self::folds(1.0)), 1.0, guess).unwrap_err();
        named(refused, "first_step is");
        assert!(refused.to_string().ends_with("of either sign"));
    }
    for (integral, proportional, name) in [
        (1e-100, 5e3, "breakaway force / integral is 1.2"),
        (1e100, 5e3, "breakaway force / integral is 1.2"),
        (1e5, 1e100, "breakaway force / (proportional + spring_stiffness) is 1.2"),
    ] {
        let mut parameters = stiff_loop();
        parameters.controller = Pid { proportional, integral, ..parameters.controller };
        named(ControlLoop::new(parameters).unwrap_err().into(), name);
    }
}

#[test]
fn a_light_mass_comes_to_rest_as_a_heavier_one_does() {
    for mass in [1e-2, 1e-9] {
        let mut light = stiff_loop();
        light.mechanism.mass = mass;
        let report = hunting(&light, &[1e-3], 5.0).unwrap();
        assert_eq!(report.outcomes[0].1, Outcome::Rests, "{report}");
        // Without mass K_D s² + K_P s + K_I.
        assert!((report.large_abscissa + 12.5).abs() < 1e-2, "{report}");
    }
}

#[test]
fn what_a_period_costs_is_limited() {
    // ẋ = −1000 x: a million seconds are a few steps, and a thousand million time constants.
    let quick = Field(|state: &Vector1<f64>| (state * -1e3, Matrix1::new(-1e3)));
    let shooting = Shooting { most_steps: 10_000, ..Shooting::default() };
    let orbit = shooting.forced(&quick, (0.0, 1e6), Vector1::new(1.0));
    assert_eq!(orbit, Err(PeriodicError::TooManySteps));
    // One correction of a linear motion, and a second iteration that finds none.
    let orbit = |most_iterations| {
        let shooting = Shooting { most_iterations, ..shooting };
        shooting.forced(&quick, (0.0, 1e-3), Vector1::new(0.1))
    };
    let refused = matches!(orbit(1), Err(PeriodicError::NotConverged { iterations: 1, .. }));
    assert!(refused && orbit(2).is_ok());
    // Companion steps of 10⁻¹⁴ s, of a mass of 10⁻²⁰ kg.
    let mut light = stiff_loop();
    (light.mechanism.mass, light.controller.sample_time) = (1e-20, 1.0);
    assert_eq!(hunting(&light, &[1e-3], 30.0), Err(PeriodicError::TooManySteps));
}
