//! Identification: what is known comes back, with honest errors, and what the data cannot tell is
//! said.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::num::NonZero;
use std::ops::ControlFlow;

use bristle::parameter::Checked;
use bristle::{Bristle, ParameterError, Rule, Scalar};
use bristle_identify::*;
use bristle_specimens::draw::Draw;

/// μ_d, μ_s − μ_d, v_S, σ2, σ0, σ1.
const TRUTH: [f64; 6] = [0.2, 0.1, 0.01, 0.8, 6e3, 8.0];
const STEP: f64 = 2e-3;
const SHAPE: f64 = 2.0;

/// Slides of many speeds, and pre-sliding on top.
fn rich(t: f64) -> f64 {
    0.05 * (1.3 * t).sin() * (0.37 * t).sin() + 0.004 * (17.0 * t).sin()
}

/// To and fro at 10 mm/s.
fn one_speed(t: f64) -> f64 {
    if (t / 0.5).fract() < 0.5 { 0.01 } else { -0.01 }
}

/// What a candidate gives along a velocity, with noise of its own.
fn log_of<C: Candidate<N>, const N: usize>(
    candidate: &C,
    values: &[f64; N],
    velocity: impl Fn(f64) -> f64,
    rows: usize,
    mut noise: impl FnMut() -> f64,
) -> Log {
    let model = candidate.model(values).unwrap();
    let (mut time, mut speeds, mut friction) = (vec![], vec![], vec![]);
    let mut deflection = model.stationary(0.0) * 0.0;
    for row in 0..rows {
        let t = STEP * row as f64;
        let v = velocity(t);
        if let Some(before) = speeds.last() {
            deflection = model.hold(0.5 * (v + before), deflection, STEP).deflection;
        }
        time.push(t);
        speeds.push(v);
        friction.push(model.coefficient(v, deflection) + candidate.offset(values) + noise());
    }
    log_from(&time, MeasuredMotion::Velocity(&speeds), &friction)
}

fn log_from(time: &[f64], motion: MeasuredMotion<'_>, friction: &[f64]) -> Log {
    Log::new(LogParameters { time, motion, friction, normal_force: None }).unwrap()
}

fn go_on(_: &SearchProgress<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// A fit of [`FrBdFit`] with own starts and bounds.
fn fitted_from(parameters: [Parameter; 6], log: &Log) -> Result<Fit, ParameterError> {
    fit(&FrBdFit, parameters, log, &SearchSettings::default(), &mut go_on)
}

/// A fit from the starts of the initial guess.
fn fitted_with<C: Candidate<N>, const N: usize>(
    candidate: &C,
    log: &Log,
    settings: &SearchSettings,
    progress: &mut dyn FnMut(&SearchProgress<'_>) -> ControlFlow<()>,
) -> Result<Fit, ParameterError> {
    fit(candidate, candidate.parameters(&InitialGuess::of(log)?), log, settings, progress)
}

/// That of the rows after 0.2 s.
fn fitted<C: Candidate<N>, const N: usize>(candidate: &C, log: &Log) -> Fit {
    let log = log.clone().settling(0.2).unwrap();
    fitted_with(candidate, &log, &SearchSettings::default(), &mut go_on).unwrap()
}

/// μ_d, μ_s − μ_d, v_S, σ2, σ0, σ1, stick share, offset.
const YIELDING: [f64; 8] = [0.2, 0.1, 0.01, 0.8, 6e3, 8.0, 0.7, 0.01];

/// Fits a log without noise, which gives the parameters back to a relative error.
fn comes_back<C: Candidate<N>, const N: usize>(
    candidate: &C,
    truth: [f64; N],
    rows: usize,
    error: f64,
) {
    let log = log_of(candidate, &truth, rich, rows, || 0.0);
    let found = fitted(candidate, &log);
    for (estimate, truth) in found.estimates.iter().zip(truth) {
        assert!((estimate.value / truth - 1.0).abs() < error, "{found}");
    }
    assert!(N != 6 || found.outcome == SearchOutcome::Converged, "{found}");
}

#[test]
fn without_noise_every_parameter_comes_back() {
    // The rate of convergence is quadratic with no residual left; the start is forgotten to some
    // 10⁻⁶.
    comes_back(&FrBdFit, TRUTH, 3000, 1e-4);
    comes_back(&ElastoPlasticFit::default(), YIELDING, 3000, 1e-3);
    // The offset is 1.3 times the dynamic coefficient: one within it would be clipped.
    let mut large = YIELDING;
    large[7] = 0.26;
    comes_back(&ElastoPlasticFit::default(), large, 3000, 1e-3);
}

/// Whether every parameter is determined, or fixed.
fn is_determined(found: &Fit) -> bool {
    let mut verdicts = found.estimates.iter().map(|estimate| estimate.verdict);
    verdicts.all(|it| matches!(it, Identifiability::Determined | Identifiability::Fixed))
}

/// Seeds for which every parameter lies within three of its standard errors, with noise of 2 % of
/// 0.25.
fn covered(seeds: u64, correlation: f64) -> u64 {
    (0..seeds)
        .filter(|&seed| {
            let mut draw = Draw(1000 + 77 * seed);
            (0..10).for_each(|_| _ = draw.next());
            let mut state = draw.gauss();
            let log = log_of(&FrBdFit, &TRUTH, rich, 4000, || {
                state =
                    correlation * state + (1.0 - correlation * correlation).sqrt() * draw.gauss();
                0.005 * state
            });
            let found = fitted(&FrBdFit, &log);
            assert!(is_determined(&found), "{found}");
            found
                .estimates
                .iter()
                .zip(TRUTH)
                .all(|(e, truth)| (e.value - truth).abs() < 3.0 * e.standard_error)
        })
        .count() as u64
}

#[test]
fn estimates_lie_within_three_standard_errors() {
    // Six Gaussian errors lie all within three deviations in 98.4 % of all cases: of four more than
    // one miss has a chance below 0.2 %.
    assert!(covered(4, 0.0) >= 3);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn correlated_noise_widens_the_standard_errors() {
    // Standard errors that took the rows for independent would be too small by √((1 + ρ)/(1 − ρ)) =
    // 3.
    assert!(covered(4, 0.8) >= 3);
}

#[test]
#[ignore = "minutes; run in release"]
fn estimates_lie_within_three_standard_errors_in_95_percent_of_200_seeds() {
    let (white, coloured) = (covered(200, 0.0), covered(200, 0.8));
    println!("within three standard errors: {white} of 200, correlated noise {coloured} of 200");
    assert!(white >= 190 && coloured >= 190);
}

/// Implements [`Residuals`] by passing residuals of values to a function.
macro_rules! residuals {
    ($type:ty, $count:literal: |$this:ident, $values:pat, $each:ident| $body:expr) => {
        impl Residuals<$count> for $type {
            fn evaluate<T: Scalar>(
                &self,
                $values: &[T; $count],
                $each: &mut impl FnMut(T),
            ) -> Result<(), ParameterError> {
                let $this = self;
                $body;
                Ok(())
            }
        }
    };
}

fn lit<T: Scalar>(value: f64) -> T {
    nalgebra::convert(value)
}

/// The mean of a series.
struct Mean(Vec<f64>);
residuals!(Mean, 1: |this, &[mean], each| this.0.iter().for_each(|&x| each(mean - lit(x))));

/// A parameter between −10 and 10, from 0.5.
fn within_ten(name: &'static str) -> Parameter {
    Parameter { name, unit: "", start: 0.5, least: -10.0, most: 10.0, typical: Some(1.0) }
}

/// The best value of one such parameter.
fn best(residuals: &impl Residuals<1>) -> Fit {
    least_squares(residuals, [within_ten("mean")], &SearchSettings::default(), &mut go_on).unwrap()
}

#[test]
fn the_standard_error_of_a_mean_is_that_of_the_closed_form() {
    // An autoregressive series: the variance of its mean is σ²/n (1 + ρ)/(1 − ρ).
    for correlation in [0.0_f64, 0.9] {
        let series = Mean(Draw(5).coloured(correlation).take(40_000).collect());
        let found = best(&series);
        let want = ((1.0 + correlation) / (1.0 - correlation) / 40_000.0).sqrt();
        let ratio = found.estimates[0].standard_error / want;
        // Bartlett's weights lose some 5 % of a deviation, and a window of τ·10 rows in 40 000
        // leaves as much noise.
        assert!((0.8..1.15).contains(&ratio), "{correlation}: {ratio}");
        // Four times √((1 − ρ²)/n).
        assert!((found.neighbour_correlation - correlation).abs() < 0.02, "{found}");
    }
}

#[test]
fn one_sliding_speed_does_not_determine_the_stribeck_part() {
    let mut draw = Draw(3);
    let log = log_of(&FrBdFit, &TRUTH, one_speed, 3000, || 0.004 * draw.gauss());
    let found = fitted(&FrBdFit, &log);
    for name in ["static_excess", "stribeck_velocity"] {
        let verdict = found.estimate(name).unwrap().verdict;
        assert!(
            matches!(verdict, Identifiability::Undetermined | Identifiability::Uncertain),
            "{found}"
        );
        let text = found.to_string();
        let line = text.lines().find(|line| line.starts_with(name)).unwrap();
        let words = ["UNDETERMINED by these data", "UNCERTAIN: standard error above value"];
        assert!(words.iter().any(|words| line.ends_with(words)), "{found}");
    }
    let stiffness = found.estimate("micro_stiffness").unwrap();
    assert_eq!(stiffness.verdict, Identifiability::Determined, "{found}");
    assert!((stiffness.value - TRUTH[4]).abs() < 4.0 * stiffness.standard_error, "{found}");
}

#[test]
fn a_parameter_at_a_bound_or_between_one_bound_twice_is_reported_there() {
    use Identifiability::{AtLowerBound, AtUpperBound, Fixed};
    let log = log_of(&FrBdFit, &TRUTH, rich, 2000, || 0.0);
    let mut parameters = FrBdFit.parameters(&InitialGuess::of(&log).unwrap());
    // The truth is 6e3. On either side of it, or on it: no data push a fixed parameter to a bound.
    for ([least, start, most], value, verdict, words) in [
        ([1e3, 3e3, 4e3], 4e3, AtUpperBound, "AT ITS UPPER BOUND"),
        ([8e3, 1e4, 2e4], 8e3, AtLowerBound, "AT ITS LOWER BOUND"),
        ([3e3; 3], 3e3, Fixed, "fixed"),
        ([6e3; 3], 6e3, Fixed, "fixed"),
        ([2e4; 3], 2e4, Fixed, "fixed"),
    ] {
        parameters[4] = Parameter { start, least, most, ..parameters[4] };
        let found = fitted_from(parameters, &log).unwrap();
        let stiffness = found.estimate("micro_stiffness").unwrap();
        assert_eq!((stiffness.verdict, stiffness.value), (verdict, value), "{found}");
        let text = found.to_string();
        let line = text.lines().find(|line| line.starts_with("micro_stiffness")).unwrap();
        assert!(stiffness.standard_error.is_nan() && line.ends_with(words), "{found}");
    }
}

#[test]
fn a_stopped_search_returns_the_best_point_so_far() {
    let log = log_of(&FrBdFit, &TRUTH, rich, 2000, || 0.0);
    let mut seen = vec![];
    let mut stop_at_three = |now: &SearchProgress<'_>| {
        seen.push(now.rmse);
        if now.iteration == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let found =
        fitted_with(&FrBdFit, &log, &SearchSettings::default(), &mut stop_at_three).unwrap();
    assert_eq!((found.outcome, found.iterations), (SearchOutcome::Stopped, 3));
    // The same numbers, added up once with and once without their derivatives.
    assert!((found.rmse / seen.last().unwrap() - 1.0).abs() < 1e-9);
    assert!(seen.windows(2).all(|pair| pair[1] <= pair[0]), "{seen:?}");
    let short = SearchSettings { iterations: 2, ..SearchSettings::default() };
    let found = fitted_with(&FrBdFit, &log, &short, &mut go_on).unwrap();
    assert_eq!(found.outcome, SearchOutcome::RunLimit);
}

#[test]
fn a_fit_predicts_what_it_has_not_seen() {
    let mut draw = Draw(9);
    let log = log_of(&FrBdFit, &TRUTH, rich, 5000, || 0.005 * draw.gauss());
    let found = fitted(&FrBdFit, &log.between(0.0, 6.0).unwrap());
    let unseen = log.between(6.0, 10.0).unwrap().settling(0.2).unwrap();
    let prediction = predict(&FrBdFit, &found.values(), &unseen).unwrap();
    // No worse than the noise, but for a deviation of a few per cent from 1900 rows.
    let rmse = unseen.rmse(&prediction);
    assert!(rmse < 0.0053, "{rmse}");
    let measured = unseen.work(unseen.coefficients());
    assert!((unseen.work(&prediction) / measured - 1.0).abs() < 0.01);
}

type Spoil = fn(&mut Columns);

/// Columns of 100 good rows.
struct Columns {
    time: Vec<f64>,
    velocity: Vec<f64>,
    friction: Vec<f64>,
    normal: Vec<f64>,
}

impl Columns {
    fn good() -> Self {
        let time: Vec<f64> = (0..100).map(|i| 0.01 * f64::from(i)).collect();
        let velocity: Vec<f64> = time.iter().map(|t| 0.01 * (12.0 * t).sin()).collect();
        let friction = velocity.iter().map(|v| 5.0 * (v / 1e-3).tanh()).collect();
        Self { normal: vec![10.0; 100], time, velocity, friction }
    }

    fn read(&self) -> Checked<Log> {
        Log::new(LogParameters {
            time: &self.time,
            motion: MeasuredMotion::Velocity(&self.velocity),
            friction: &self.friction,
            normal_force: Some(&self.normal),
        })
    }

    fn spoilt(spoil: impl FnOnce(&mut Self)) -> String {
        let mut columns = Self::good();
        spoil(&mut columns);
        columns.read().unwrap_err().to_string()
    }
}

#[test]
fn bad_rows_are_refused_with_row_value_and_rule() {
    assert!(Columns::good().read().is_ok());
    let cases: [(Spoil, &str); 10] = [
        (|c| c.time[7] = f64::NAN, "time[7] is NaN, but must lie between -1e100 and 1e100"),
        (|c| c.velocity[0] = f64::INFINITY, "velocity[0] is inf, but must lie between"),
        (|c| c.friction[99] = f64::NAN, "friction[99] is NaN, but must lie between"),
        (|c| c.time[5] = 0.04, "time[5] is 0.04, but must be larger than its predecessor 0.04"),
        (|c| c.normal[3] = 0.0, "normal_force[3] is 0, but must lie between 1e-100 and 1e100"),
        (|c| c.normal[3] = 1e-320, "normal_force[3] is 1e-320, but must lie between 1e-100"),
        (|c| c.friction.truncate(9), "there must be 100 rows of friction, not 9"),
        (|c| c.friction.iter_mut().for_each(|f| *f *= 1e6), "must be at most 100 (units?)"),
        (|c| c.friction.iter_mut().for_each(|f| *f *= 1e-6), "must be at least 0.0001 (units?)"),
        (|c| c.velocity.iter_mut().for_each(|v| *v *= 1e-9), "must be at least 1e-9 (units?)"),
    ];
    for (spoil, expected) in cases {
        let refusal = Columns::spoilt(spoil);
        assert!(refusal.contains(expected), "{refusal}");
    }
    let fast = Columns::spoilt(|c| c.velocity.iter_mut().for_each(|v| *v *= 1e7));
    assert!(fast.contains("velocity[") && fast.contains("units?"), "{fast}");
    let short = Columns::good().read().unwrap().between(0.2, 0.3).unwrap_err().to_string();
    assert_eq!(short, "there must be at least 20 rows, not 11");
    let nowhere = Columns::good().read().unwrap().between(f64::NAN, 1.0).unwrap_err().to_string();
    assert_eq!(nowhere, "from is NaN, but must be a number");
}

#[test]
fn motions_without_reversal_or_sliding_are_refused() {
    let refusal = |velocity: fn(f64) -> f64| {
        let log = log_of(&FrBdFit, &TRUTH, velocity, 500, || 0.0);
        fitted_with(&FrBdFit, &log, &SearchSettings::default(), &mut go_on).unwrap_err()
    };
    let one_way = refusal(|_| 0.01);
    assert_eq!((one_way.name, one_way.value), ("number of reversals", 0.0), "{one_way}");
    // 10 mm in one second; turns of less than a thousandth of it do not count, though the velocity
    // changes its sign.
    let hardly = refusal(|t| 0.01 + 0.011 * (400.0 * t).sin()).to_string();
    let want = "number of reversals is 0, but must be at least 1: a turn by more than its noise";
    assert!(hardly.contains(want), "{hardly}");
    // A hundredth of the breakaway distance of 50 µm.
    let stuck = refusal(|t| 1e-5 * (20.0 * t).cos());
    // To and fro by 2 · 10 µm/s over 20/s.
    assert!(stuck.name == "longest stroke" && (stuck.value / 1e-6 - 1.0).abs() < 0.01, "{stuck}");
    assert!(matches!(stuck.rule, Rule::AtLeast { limit, .. } if limit > stuck.value), "{stuck}");
}

#[test]
fn a_bad_bound_or_start_is_refused_by_name() {
    let log = log_of(&FrBdFit, &TRUTH, rich, 500, || 0.0);
    let parameters = FrBdFit.parameters(&InitialGuess::of(&log).unwrap());
    for bad in [f64::NAN, -1.0, f64::INFINITY] {
        let mut spoilt = parameters;
        spoilt[2].start = bad;
        let refused = fitted_from(spoilt, &log);
        assert!(
            matches!(refused, Err(ParameterError { name: "stribeck_velocity", .. })),
            "{refused:?}"
        );
    }
}

#[test]
fn the_curve_alone_comes_from_the_sliding_rows() {
    let mut draw = Draw(4);
    // Slow enough for the bristle to follow, and one row in twenty far off.
    let slow = |t: f64| 0.03 * (1.3 * t).sin();
    let log = log_of(&FrBdFit, &TRUTH, slow, 10_000, || {
        0.002 * draw.gauss() + if draw.next() < 0.05 { 0.5 * draw.next() } else { 0.0 }
    });
    let (guess, points) = InitialGuess::with_points(&log).unwrap();
    let found = guess.static_curve(SHAPE, &points).unwrap();
    for (estimate, truth) in found.estimates.iter().zip(TRUTH) {
        // Rows near a reversal see the curve with the bristle's lag, which is part of the standard
        // errors.
        assert!((estimate.value - truth).abs() < 3.0 * estimate.standard_error, "{found}");
        assert_eq!(estimate.verdict, Identifiability::Determined, "{found}");
        assert!((estimate.value / truth - 1.0).abs() < 0.2, "{found}");
    }
}

#[test]
fn a_simulation_that_leaves_too_few_rows_is_refused() {
    let log = log_of(&FrBdFit, &TRUTH, rich, 1000, || 0.0);
    let refusal = |settle: f64| {
        let log = log.clone().settling(settle).unwrap();
        let refused =
            fitted_with(&FrBdFit, &log, &SearchSettings::default(), &mut go_on).unwrap_err();
        let words = refused.to_string();
        assert_eq!(predict(&FrBdFit, &TRUTH, &log).unwrap_err().to_string(), words);
        words
    };
    for settle in [f64::NAN, f64::INFINITY, -1.0] {
        let want = format!("settling time is {settle}, but must lie between 0 and 1e100");
        assert_eq!(log.clone().settling(settle).unwrap_err().to_string(), want);
    }
    assert_eq!(refusal(1e9), "there must be at least 20 rows after settling, not 0");
    // Rows 981 … 999 of 1000.
    assert_eq!(refusal(980.5 * STEP), "there must be at least 20 rows after settling, not 19");
    let enough = log.clone().settling(979.5 * STEP).unwrap();
    assert!(predict(&FrBdFit, &TRUTH, &enough).is_ok());
    for tolerance in [f64::NAN, f64::INFINITY, -1.0] {
        let settings = SearchSettings { tolerance, ..SearchSettings::default() };
        let refused = fitted_with(&FrBdFit, &log, &settings, &mut go_on).unwrap_err();
        let want = format!("tolerance is {tolerance}, but must lie between 0 and 1e100");
        assert_eq!(refused.to_string(), want);
    }
}

#[test]
fn rows_before_the_end_of_settling_do_not_count() {
    let mut draw = Draw(6);
    let mut row = 0;
    // 0.5 in each of the first 100 rows, noise then.
    let log = log_of(&FrBdFit, &TRUTH, rich, 2000, || {
        row += 1;
        if row <= 100 { 0.5 } else { 0.005 * draw.gauss() }
    });
    let settled = log.clone().settling(99.5 * STEP).unwrap();
    let prediction = predict(&FrBdFit, &TRUTH, &log).unwrap();
    for (log, skipped) in [(&log, 0), (&settled, 100)] {
        let pairs = prediction.iter().zip(log.coefficients()).skip(skipped);
        let squares: f64 = pairs.map(|(a, b)| (a - b).powi(2)).sum();
        let want = (squares / (2000 - skipped) as f64).sqrt();
        let rmse = log.rmse(&prediction);
        assert!((rmse / want - 1.0).abs() < 1e-12, "{rmse} {want}");
    }
    // √(100 · 0.5²/2000) = 0.11 with the beginning.
    assert!(log.rmse(&prediction) > 0.1 && settled.rmse(&prediction) < 0.01);
    let found = fitted_with(&FrBdFit, &settled, &SearchSettings::default(), &mut go_on).unwrap();
    assert_eq!(found.rows, 1900);
    // A window of the log begins anew.
    let window = settled.between(1.0, 2.0).unwrap();
    assert_eq!(window.len(), 501);
    let late = predict(&FrBdFit, &TRUTH, &window).unwrap();
    assert!(window.rmse(&late) < 0.01);
}

#[test]
fn substeps_bring_the_elasto_plastic_model_nearer_to_its_flow() {
    let log = log_of(&ElastoPlasticFit::default(), &YIELDING, rich, 1000, || 0.0);
    let run = |substeps| {
        let candidate = ElastoPlasticFit { substeps: NonZero::new(substeps).unwrap() };
        predict(&candidate, &YIELDING, &log).unwrap()
    };
    let fine = run(256);
    let error = |substeps| {
        let pairs = run(substeps).into_iter().zip(&fine).skip(100);
        pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
    };
    // α is frozen over a step: an error of first order at least, so that a sixteenth of the step
    // leaves less than a quarter.
    assert!(error(1) > 1e-4 && error(16) < 0.25 * error(1), "{} {}", error(1), error(16));
}

#[test]
fn the_works_of_a_prediction_are_sums_of_force_times_way() {
    let mut draw = Draw(2);
    let log = log_of(&FrBdFit, &TRUTH, rich, 1000, || 0.005 * draw.gauss());
    let prediction = predict(&FrBdFit, &TRUTH, &log).unwrap();
    let (t, v) = (log.times(), log.velocities());
    // Trapezia of the force over the way, which is a trapezium of the velocity over time.
    let work = |mu: &[f64]| -> f64 {
        (1..t.len())
            .map(|k| {
                let way = 0.5 * (v[k - 1] + v[k]) * (t[k] - t[k - 1]);
                0.5 * (mu[k - 1] + mu[k]) * way
            })
            .sum()
    };
    for coefficients in [&prediction[..], log.coefficients()] {
        let (found, want) = (log.work(coefficients), work(coefficients));
        // Ways as differences of positions lose what the positions have in digits.
        assert!((found / want - 1.0).abs() < 1e-10, "{found} {want}");
    }
}

#[test]
fn a_bad_first_row_does_not_stretch_the_bristle() {
    let mut columns = Columns::good();
    columns.friction[0] = 1e3;
    let log = columns.read().unwrap();
    // At once at the steady deflection μ_s/σ0, not a hundred times beyond: nothing exceeds μ_s but
    // the damping, (σ1 + σ2) v.
    let prediction = predict(&FrBdFit, &TRUTH, &log).unwrap();
    let most = prediction.iter().fold(0.0, |most: f64, mu| most.max(mu.abs()));
    assert!(most < 0.3 + 8.8 * 0.01, "{most}");

    let mut draw = Draw(8);
    let mut first = true;
    // Out of a force of at most 0.35: the search must not bend the model to reach it.
    let log = log_of(&FrBdFit, &TRUTH, rich, 3000, || {
        0.002 * draw.gauss() + if std::mem::take(&mut first) { 10.0 } else { 0.0 }
    });
    let found = fitted_with(&FrBdFit, &log, &SearchSettings::default(), &mut go_on).unwrap();
    // It is still a row that is wrong, and its residual widens the standard errors; but those are
    // honest.
    for (estimate, truth) in found.estimates.iter().zip(TRUTH) {
        assert!((estimate.value - truth).abs() < 3.0 * estimate.standard_error, "{found}");
    }
    let stiffness = found.estimate("micro_stiffness").unwrap().value;
    assert!((stiffness / TRUTH[4] - 1.0).abs() < 0.05, "{found}");
}

#[test]
fn friction_with_the_wrong_sign_or_without_a_change_is_refused() {
    let refusal = |change: fn(f64) -> f64| {
        let log = log_of(&FrBdFit, &TRUTH, rich, 2000, || 0.0);
        let friction: Vec<f64> = log.coefficients().iter().map(|&mu| change(mu)).collect();
        let motion = MeasuredMotion::Velocity(log.velocities());
        InitialGuess::of(&log_from(log.times(), motion, &friction))
    };
    let Err(ParameterError { value: work, .. }) = refusal(|mu| -mu) else {
        panic!("the wrong sign went unseen")
    };
    let positions = log_of(&FrBdFit, &TRUTH, rich, 2000, || 0.0).positions();
    let path: f64 = positions.windows(2).map(|x| (x[1] - x[0]).abs()).sum();
    // The mean friction against the motion lies between μ_d and μ_s or so, less what the bristle
    // stretches.
    assert!((0.1..0.35).contains(&(-work / path)), "{work} {path}");
    let words = refusal(|mu| -mu).unwrap_err().to_string();
    assert!(words.contains("as if friction drove the motion: is its sign right?"), "{words}");
    let stuck = refusal(|_| 2.0).unwrap_err();
    let want = "is 2, but must not stay there all along: does the sensor work?";
    assert!(stuck.to_string().contains(want), "{stuck}");
    // An offset is neither, and is seen: ten times the friction, and its work over the way left at
    // the end is not counted.
    for (offset, guess) in [(-3.0, refusal(|mu| mu - 3.0)), (3.0, refusal(|mu| mu + 3.0))] {
        let seen = guess.unwrap().offset;
        assert!((seen - offset).abs() < 0.02, "{seen}");
    }
}

#[test]
fn positions_with_noise_have_the_reversals_of_those_without() {
    let rich = log_of(&FrBdFit, &TRUTH, rich, 3000, || 0.0);
    let slow = log_of(&FrBdFit, &TRUTH, |t| 0.03 * (2.6 * t).sin(), 3000, || 0.0);
    let mut draw = Draw(11);
    let read = |clean: &Log, deviation: f64, draw: &mut Draw| {
        let position: Vec<f64> =
            clean.positions().iter().map(|x| x + deviation * draw.gauss()).collect();
        let motion = MeasuredMotion::Position(&position);
        let log = log_from(clean.times(), motion, clean.coefficients());
        (position, log)
    };
    let (position, exact) = read(&rich, 0.0, &mut draw);
    // From positions the held velocities come back as they were, so that the model runs the same
    // way.
    let found = fitted(&FrBdFit, &exact);
    for (estimate, truth) in found.estimates.iter().zip(TRUTH) {
        // But for the velocity at a row, a mean of two: σ1 + σ2 act on it.
        assert!((estimate.value / truth - 1.0).abs() < 0.02, "{found}");
    }
    let v = exact.velocities();
    for k in 1..position.len() - 1 {
        let central = (position[k + 1] - position[k - 1]) / (2.0 * STEP);
        assert!((v[k] - central).abs() < 1e-12, "{k}");
    }
    assert!((v[0] - (position[1] - position[0]) / STEP).abs() < 1e-12);
    // 100 µm between rows of 2 ms: the velocity has a noise of 70 mm/s, and changes its sign
    // hundreds of times; a thousandth of the travel is 23 µm. The body turns where 2.6 t is a
    // multiple of π, four times in 6 s.
    let (_, noisy) = read(&slow, 1e-4, &mut draw);
    let turns = noisy.velocities().windows(2).filter(|v| v[0] * v[1] < 0.0).count();
    let guess = InitialGuess::of(&noisy).unwrap();
    assert!(turns > 300 && guess.reversals == 4, "{turns} {guess:?}");
}

/// μ of [`TRUTH`] in steady sliding.
fn curve(v: f64) -> f64 {
    let [dynamic, excess, velocity, viscous, ..] = TRUTH;
    dynamic + excess * (-(v / velocity).powi(2)).exp() + viscous * v
}

#[test]
fn the_least_turn_is_a_thousandth_of_the_travel_to_two_per_cent() {
    // 10 mm in 1000 rows, back by a little in one row, and 10 mm more.
    for (back, counts) in [(0.98e-3, false), (1.02e-3, true)] {
        let travel = 0.02;
        let turn = |x: f64| if x > 0.01 { x - 1e-5 - travel * back } else { x };
        let position: Vec<f64> = (0..2002).map(|row| turn(1e-5 * f64::from(row))).collect();
        let time: Vec<f64> = (0..2002).map(|row| 1e-3 * f64::from(row)).collect();
        let friction: Vec<f64> = time.iter().map(|t| 0.3 + 0.1 * t).collect();
        let log = log_from(&time, MeasuredMotion::Position(&position), &friction);
        let refused = InitialGuess::of(&log).unwrap_err();
        assert_eq!(refused.name != "number of reversals", counts, "{back}: {refused}");
    }
}

#[test]
fn a_few_bad_rows_do_not_change_the_offset() {
    let mut row = 0;
    let log = log_of(&FrBdFit, &TRUTH, rich, 3000, || {
        row += 1;
        // One row in a hundred, all to one side.
        if row % 100 == 0 { 10.0 } else { 0.0 }
    });
    let clean = log_of(&FrBdFit, &TRUTH, rich, 3000, || 0.0);
    let (clean, _) = InitialGuess::with_points(&clean).unwrap();
    let (guess, _) = InitialGuess::with_points(&log).unwrap();
    assert!((guess.offset - clean.offset).abs() < 0.02, "{guess:?}");
}

#[test]
fn noise_of_a_resting_position_is_no_sliding() {
    // 10 mm/s for 0.2 s, then 0.3 s of rest, to and fro, with a noise of 1 µm.
    let motion = |t: f64| {
        let (turn, phase) = ((t / 0.5) as usize % 2, t % 0.5);
        if phase > 0.2 {
            0.0
        } else if turn == 0 {
            0.01
        } else {
            -0.01
        }
    };
    let clean = log_of(&FrBdFit, &TRUTH, motion, 3000, || 0.0);
    let mut draw = Draw(2);
    let position: Vec<f64> = clean.positions().iter().map(|x| x + 1e-6 * draw.gauss()).collect();
    let log = log_from(clean.times(), MeasuredMotion::Position(&position), clean.coefficients());
    let (_, points) = InitialGuess::with_points(&log).unwrap();
    // A velocity is known to 0.5 mm/s; one row at each end of a stroke is half at rest.
    let slow = points.iter().filter(|point| point.speed < 8e-3).count();
    assert!(points.len() > 500 && slow < points.len() / 20, "{slow} of {}", points.len());
}

#[test]
fn a_curve_ignores_two_outliers_in_ten_and_needs_ten_points() {
    let guess = InitialGuess::of(&log_of(&FrBdFit, &TRUTH, rich, 3000, || 0.0)).unwrap();
    let points = |count: u32| -> Vec<SlidingPoint> {
        let point = |i: u32| {
            let speed = 1e-3 + 5e-2 * f64::from(i) / f64::from(count);
            let wrong = if matches!(i % 10, 4 | 5) { 0.3 } else { 0.0 };
            SlidingPoint { speed, coefficient: curve(speed) + wrong }
        };
        (0..count).map(point).collect()
    };
    // All of 200 are used; of more than 4000 every second, third, …
    for (count, used) in [(200, 200), (4001, 2001), (12_000, 4000)] {
        let found = guess.static_curve(SHAPE, &points(count)).unwrap();
        assert_eq!(found.rows, used, "{count}");
        for (value, truth) in found.values().into_iter().zip(TRUTH) {
            assert!((value / truth - 1.0).abs() < 1e-4, "{found}");
        }
    }
    assert!(guess.static_curve(SHAPE, &points(10)).is_ok());
    let refused = guess.static_curve(SHAPE, &points(9)).unwrap_err();
    assert_eq!(refused.to_string(), "there must be at least 10 points, not 9");
}

#[test]
fn no_initial_guess_makes_a_panic_or_a_fit_of_nothing() {
    let points: Vec<SlidingPoint> = (1..50)
        .map(|i| SlidingPoint {
            speed: 2e-3 * f64::from(i),
            coefficient: 0.2 + 0.01 / f64::from(i),
        })
        .collect();
    let log = log_of(&FrBdFit, &TRUTH, rich, 500, || 0.0);
    let good = InitialGuess::of(&log).unwrap();
    for exponent in [f64::NAN, f64::INFINITY, 0.0, -1.0, 5e-324, 1e300] {
        let refused = good.static_curve(exponent, &points).unwrap_err();
        assert_eq!(refused.name, "stribeck_exponent");
        assert_eq!(refused.value.to_bits(), exponent.to_bits());
    }
    // A curve that falls all the way to the largest speed, and beyond.
    let falling = log_of(&FrBdFit, &[0.2, 0.1, 0.2, 1e-6, 6e3, 8.0], rich, 3000, || 0.0);
    let guess = InitialGuess::of(&falling).unwrap();
    assert!(guess.stribeck_velocity <= guess.fastest, "{guess:?}");
    let fields: [fn(&mut InitialGuess, f64); 7] = [
        |r, x| r.static_coefficient = x,
        |r, x| r.dynamic_coefficient = x,
        |r, x| r.stribeck_velocity = x,
        |r, x| r.viscous_friction = x,
        |r, x| r.micro_stiffness = x,
        |r, x| r.micro_damping = x,
        |r, x| r.fastest = x,
    ];
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -1.0, 1e300, 5e-324] {
        for (field, set) in fields.iter().enumerate() {
            let mut guess = good;
            set(&mut guess, bad);
            let short = SearchSettings { iterations: 1, ..SearchSettings::default() };
            for exponent in [SHAPE, 1.0] {
                let Ok(fit) = guess.static_curve(exponent, &points) else { continue };
                let values = fit.values();
                assert!(values.iter().all(|x| x.is_finite()), "{field} {bad}: {values:?}");
            }
            let found = fit(&FrBdFit, FrBdFit.parameters(&guess), &log, &short, &mut go_on);
            assert!(!bad.is_nan() || found.is_err(), "{field}: {found:?}");
            let _ = ElastoPlasticFit::default().parameters(&guess);
        }
    }
}

#[test]
fn each_exponent_of_a_curve_finds_its_own_points() {
    // μ_d, μ_s − μ_d, v_S, σ2, and how the excess falls with v/v_S.
    let truth = [0.2, 0.1, 0.01, 0.8];
    let falls: [fn(f64) -> f64; 2] = [|u| (-u).exp(), |u| (-u * u).exp()];
    let guess = InitialGuess::of(&log_of(&FrBdFit, &TRUTH, rich, 500, || 0.0)).unwrap();
    for (exponent, falls) in [1.0, 2.0].into_iter().zip(falls) {
        let point = |speed: f64| SlidingPoint {
            speed,
            coefficient: truth[0] + truth[1] * falls(speed / truth[2]) + truth[3] * speed,
        };
        let points: Vec<SlidingPoint> = (1..200).map(|i| point(3e-4 * f64::from(i))).collect();
        let found = guess.static_curve(exponent, &points).unwrap().values();
        for (found, truth) in found.into_iter().zip(truth) {
            assert!((found / truth - 1.0).abs() < 1e-5, "{exponent}: {found} for {truth}");
        }
    }
}

/// Strokes of a length in x₅₀ each, at speeds that alternate from stroke to stroke in mm/s, under a
/// force that turns by 2 μ in proportion to the distance over 2 x₅₀ and then stays: x₅₀ = 10 µm,
/// μ = 0.3. A row each 10 nm at the first speed.
fn elastic_then_sliding(length: f64, speeds: &[f64]) -> Log {
    strokes(8, length, speeds, 1.0)
}

/// So many of these strokes, of which the first turns its force over `first` times the distance.
fn strokes(count: usize, length: f64, speeds: &[f64], first: f64) -> Log {
    let (half, mu) = (1e-5, 0.3);
    let stroke = length * half;
    let (mut time, mut position, mut friction) = (vec![], vec![], vec![]);
    let mut begin = 0.0;
    for number in 0..count {
        let half = if number == 0 { first * half } else { half };
        let speed = 1e-3 * speeds[number % speeds.len()];
        let direction = if number % 2 == 0 { 1.0 } else { -1.0 };
        let rows = (stroke / 1e-8 * 1e-3 * speeds[0] / speed).round();
        for row in 0..rows as usize {
            let x = stroke * row as f64 / rows;
            time.push(begin + x / speed);
            position.push(if direction > 0.0 { x } else { stroke - x });
            friction.push(direction * mu * (-1.0 + x / half).min(1.0));
        }
        begin += stroke / speed;
    }
    log_from(&time, MeasuredMotion::Position(&position), &friction)
}

#[test]
fn the_initial_guess_of_an_elastic_stroke_is_that_of_its_closed_form() {
    let guess = InitialGuess::of(&elastic_then_sliding(20.0, &[1.0])).unwrap();
    // Half of the swing at x₅₀, between rows of a thousandth of it; velocities of positions have
    // eleven digits.
    for (name, value, want) in [
        ("μ_s", guess.static_coefficient, 1.2 * 0.3),
        ("μ_d", guess.dynamic_coefficient, 0.9 * 0.3),
        ("v_S", guess.stribeck_velocity, 1e-3),
        ("σ2", guess.viscous_friction, 0.01 * 0.3 / 1e-3),
        ("σ0", guess.micro_stiffness, 2_f64.ln() * 0.3 / 1e-5),
        ("σ1", guess.micro_damping, 0.1 * 0.3 / 1e-3),
        ("fastest", guess.fastest, 1e-3),
    ] {
        assert!((value / want - 1.0).abs() < 1e-3, "{name}: {value} {want}");
    }
    assert!(guess.offset.abs() < 1e-12 && guess.reversals == 7, "{guess:?}");
    // A stroke that begins without a reversal does not tell the stiffness.
    let first = InitialGuess::of(&strokes(2, 20.0, &[1.0], 0.5)).unwrap();
    assert!((first.micro_stiffness / guess.micro_stiffness - 1.0).abs() < 1e-3, "{first:?}");
}

#[test]
fn a_contact_slides_in_strokes_of_two_and_a_half_times_the_way_to_half_of_the_swing() {
    let refused = InitialGuess::of(&elastic_then_sliding(2.48, &[1.0])).unwrap_err();
    assert_eq!(refused.name, "longest stroke", "{refused}");
    assert!(InitialGuess::of(&elastic_then_sliding(2.52, &[1.0])).is_ok());
}

#[test]
fn rows_slide_beyond_five_breakaway_distances_or_six_tenths_of_the_longest_stroke() {
    // Of strokes of 20 and 13 x₅₀, 5/ln 2 = 7.21 x₅₀ are passed over; of 5 x₅₀, six tenths.
    for (length, passed) in [(20.0, 5.0 / 2_f64.ln()), (13.0, 5.0 / 2_f64.ln()), (5.0, 3.0)] {
        let log = elastic_then_sliding(length, &[1.0]);
        let (_, points) = InitialGuess::with_points(&log).unwrap();
        let share = points.len() as f64 / log.len() as f64;
        let want = 1.0 - passed / length;
        // A few rows of a thousand or more in each stroke.
        assert!((share / want - 1.0).abs() < 0.01, "{length}: {share} {want}");
        for point in points {
            assert!((point.coefficient / 0.3 - 1.0).abs() < 1e-12, "{point:?}");
        }
    }
}

#[test]
fn the_last_row_of_a_log_slides_like_those_before() {
    // Four strokes of a thousand rows at 1 mm/s; the force turns over a hundred. One row stands
    // out: the last.
    let (mut velocity, mut friction) = (vec![], vec![]);
    for direction in [1.0, -1.0, 1.0, -1.0] {
        for row in 0..1000 {
            velocity.push(1e-3 * direction);
            friction.push(0.3 * direction * f64::min(f64::from(row) / 50.0 - 1.0, 1.0));
        }
    }
    friction[3999] = -0.35;
    let time: Vec<f64> = (0..4000).map(|row| 2e-4 * f64::from(row)).collect();
    let log = log_from(&time, MeasuredMotion::Velocity(&velocity), &friction);
    let (_, points) = InitialGuess::with_points(&log).unwrap();
    let coefficient = points.last().unwrap().coefficient;
    assert!((coefficient - 0.35).abs() < 1e-12, "{coefficient}");
}

#[test]
fn speeds_within_a_factor_of_two_do_not_make_a_curve() {
    for (fast, fitted) in [(1.96_f64, false), (2.04, true)] {
        let log = elastic_then_sliding(20.0, &[1.0, 1.0, fast, fast]);
        let (plain, _) = InitialGuess::with_points(&log).unwrap();
        let guess = InitialGuess::of(&log).unwrap();
        assert_eq!(guess != plain, fitted, "{fast}: {guess:?}");
        // Before a fit, the middle of the speeds seen.
        let middle = 1e-3 * fast.sqrt();
        assert!((plain.stribeck_velocity / middle - 1.0).abs() < 1e-3, "{plain:?}");
        // The level is 0.3 at every speed.
        assert!(!fitted || (guess.dynamic_coefficient / 0.3 - 1.0).abs() < 0.05, "{guess:?}");
    }
}

#[test]
fn a_point_beyond_4_685_deviations_has_no_weight() {
    let guess = InitialGuess::of(&log_of(&FrBdFit, &TRUTH, rich, 3000, || 0.0)).unwrap();
    // Points in pairs at ±a from the curve, so that the median of their distances is a, and one
    // more in ten at so many of the deviations 1.4826 a above it.
    let a = 1e-3;
    let level = |deviations: f64| {
        let mut points = vec![];
        for i in 0..200 {
            let speed = 1e-3 + 2.4e-4 * f64::from(i);
            let mut add =
                |off| points.push(SlidingPoint { speed, coefficient: curve(speed) + off });
            add(a);
            add(-a);
            if i % 5 == 0 {
                add(deviations * 1.4826 * a);
            }
        }
        let found = guess.static_curve(SHAPE, &points).unwrap();
        (found.estimate("dynamic_coefficient").unwrap().value - TRUTH[0]) / a
    };
    // Without weight, nothing; at 4.5 deviations (1 − (4.5/4.685)²)² = 0.006 of one point in
    // eleven, or a shift of the level by about 0.004 a.
    let (near, beyond) = (level(4.5), level(4.8));
    assert!(near.abs() > 1e-3 && beyond.abs() < 1e-4, "{near} {beyond}");
}

#[test]
fn outliers_at_the_slowest_points_make_no_static_excess() {
    let guess = InitialGuess::of(&log_of(&FrBdFit, &TRUTH, rich, 3000, || 0.0)).unwrap();
    let points: Vec<SlidingPoint> = (1..=200)
        .map(|i| {
            let speed = 2.4e-4 * f64::from(i);
            let off = if i <= 10 { 3.0 } else { 1e-3 * f64::from(i % 3 - 1) };
            SlidingPoint { speed, coefficient: curve(speed) + off }
        })
        .collect();
    let found = guess.static_curve(SHAPE, &points).unwrap();
    let excess = found.estimate("static_excess").unwrap().value;
    // The slowest of what is left, 2.6 mm/s, is still within v_S: twice ±1e-3 of 0.1 or so.
    assert!((excess / TRUTH[1] - 1.0).abs() < 0.05, "{found}");
}

#[test]
fn friction_is_taken_over_the_normal_force() {
    let time: Vec<f64> = (0..100).map(|row| STEP * f64::from(row)).collect();
    let speeds: Vec<f64> = time.iter().map(|&t| rich(t)).collect();
    let coefficients: Vec<f64> = speeds.iter().map(|v| 0.3 * v.signum()).collect();
    let motion = MeasuredMotion::Velocity(&speeds);
    // Powers of two: nothing is rounded.
    let normal: Vec<f64> = (0..100).map(|row| [2.0, 4.0][row % 2]).collect();
    let friction: Vec<f64> = coefficients.iter().zip(&normal).map(|(mu, p)| mu * p).collect();
    let normal_force = Some(normal.as_slice());
    let log = Log::new(LogParameters { time: &time, motion, friction: &friction, normal_force });
    let want = log_from(&time, MeasuredMotion::Velocity(&speeds), &coefficients);
    assert_eq!(log.unwrap(), want);
}

const GUESS: InitialGuess = InitialGuess {
    static_coefficient: 0.3,
    dynamic_coefficient: 0.2,
    stribeck_velocity: 0.01,
    viscous_friction: 0.5,
    micro_stiffness: 1e4,
    micro_damping: 2.0,
    offset: 0.0,
    fastest: 0.1,
    reversals: 1,
};

#[test]
fn bounds_lie_as_far_from_the_guess_as_documented() {
    let guess = GUESS;
    // Start, lower and upper bound; the viscous force at the largest speed is up to ten times μ_d.
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
    let assert_bounds = |parameters: &[Parameter], want: &[[f64; 3]]| {
        for (parameter, &[start, least, most]) in parameters.iter().zip(want) {
            let found = near(parameter.start, start) && near(parameter.least, least);
            assert!(found && near(parameter.most, most), "{parameter:?}");
        }
    };
    let shared = [
        [0.2, 0.2 / 30.0, 6.0],
        [0.1, 2e-4, 6.0],
        [0.01, 1e-5, 10.0],
        [0.5, 0.0, 20.0],
        [1e4, 1e2, 1e6],
        [2.0, 0.0, 2e3],
    ];
    assert_bounds(&FrBdFit.parameters(&guess), &shared);
    let yielding = ElastoPlasticFit::default().parameters(&guess);
    assert_bounds(&yielding[..6], &shared);
    assert_bounds(&yielding[6..], &[[0.5, 1e-3, 0.99], [0.0, -0.4, 0.4]]);
}

/// The line a + b x through the points of a series, at x = first, first + 1, …
struct Line {
    points: Vec<f64>,
    first: f64,
}

impl Line {
    fn fitted(&self) -> Fit {
        let parameters = ["a", "b"].map(within_ten);
        least_squares(self, parameters, &SearchSettings::default(), &mut go_on).unwrap()
    }
}

residuals!(Line, 2: |this, &[a, b], each| {
    for (row, &y) in this.points.iter().enumerate() {
        each(a + b * lit(this.first + row as f64) - lit(y));
    }
});

#[test]
fn without_spare_rows_there_are_no_standard_errors() {
    let fit = |points: &[f64]| Line { points: points.to_vec(), first: 0.0 }.fitted();
    // Nothing, a point (which tells a, but not b), two points, three.
    for (rows, verdict) in [
        (&[][..], Identifiability::Undetermined),
        (&[1.0], Identifiability::Undetermined),
        (&[1.0, 3.0], Identifiability::Uncertain),
        (&[1.0, 3.0, 5.1], Identifiability::Determined),
    ] {
        let found = fit(rows);
        assert_eq!(found.estimates[1].verdict, verdict, "{found}");
        let spare = rows.len() > 2;
        for estimate in &found.estimates {
            assert_eq!(estimate.standard_error.is_finite(), spare, "{found}");
        }
        assert_eq!(found.correlation[(0, 1)].is_finite(), spare, "{found}");
        assert_eq!(is_determined(&found), spare, "{found}");
    }
}

#[test]
fn the_errors_of_a_line_correlate_by_where_its_points_lie() {
    // Of white noise −x̄/√(mean of x²), where the mean of x² is x̄² + (n² − 1)/12.
    let rows = 20_001;
    for first in [-5_000.0, -15_000.0] {
        let mut draw = Draw(7);
        let points = (0..rows).map(|_| 0.1 * draw.gauss()).collect();
        let mean: f64 = first + 10_000.0;
        let square = mean * mean + (f64::from(rows).powi(2) - 1.0) / 12.0;
        let (found, want) = (Line { points, first }.fitted(), -mean / square.sqrt());
        // A window of ten rows leaves √(10/20 000) = 2 % of noise.
        assert!((found.correlation[(0, 1)] - want).abs() < 0.05, "{want}: {found}");
    }
}

#[test]
fn a_correlation_lies_between_minus_one_and_one() {
    // Far from x = 0 the errors of a and b are those of one slope: −1 but for rounding, of either
    // sign.
    for seed in 0..400 {
        let mut draw = Draw(seed);
        let points: Vec<f64> = (0..3 + seed % 20).map(|_| draw.next()).collect();
        let first = 10.0_f64.powf(5.0 + 2.5 * draw.next());
        let found = Line { points, first }.fitted();
        let c = &found.correlation;
        let sound = c[(0, 1)].is_nan() || c[(0, 1)].abs() <= 1.0 && c[(0, 1)] == c[(1, 0)];
        assert!(sound, "{seed}: {} {} {found}", c[(0, 1)], c[(1, 0)]);
    }
}

/// The mean of 0, 1, 2, and a parameter without effect.
struct Idle;

residuals!(Idle, 2: |_this, &[mean, _], each| {
    (0..30).for_each(|k| each(mean - lit(f64::from(k % 3))));
});

#[test]
fn a_parameter_without_effect_stays_and_the_others_are_found() {
    let parameters = [within_ten("mean"), within_ten("idle")];
    let found = least_squares(&Idle, parameters, &SearchSettings::default(), &mut go_on).unwrap();
    let [mean, idle] = found.array();
    // Rounding of thirty sums.
    assert!((mean - 1.0).abs() < 1e-12 && idle == 0.5, "{found}");
    assert_eq!(found.estimates[1].verdict, Identifiability::Undetermined, "{found}");
}

/// Steps that halve x, and a rest.
struct Halving;

residuals!(Halving, 1: |_this, &[x], each| [x * x, T::one()].into_iter().for_each(each));

#[test]
fn a_search_ends_after_two_changes_below_the_tolerance() {
    // Before step k x = 2⁻ᵏ, and the step takes 15/16 x⁴ from 1 + x⁴: enough up to k = 3 and 7.
    for (tolerance, steps) in [(1e-4, 5), (1e-9, 9)] {
        let settings = SearchSettings { tolerance, ..SearchSettings::default() };
        let found = least_squares(&Halving, [within_ten("x")], &settings, &mut go_on).unwrap();
        assert_eq!((found.outcome, found.iterations), (SearchOutcome::Converged, steps));
    }
}

/// Sensitivities whose squares overflow, at no residual.
struct Steep;

residuals!(Steep, 1: |_this, &[x], each| (0..30).for_each(|_| each((x - lit(0.5)) * lit(1e200))));

#[test]
fn overflowing_sensitivities_are_not_called_determined() {
    let found = best(&Steep);
    let estimate = found.estimates[0];
    assert_eq!(estimate.verdict, Identifiability::Undetermined, "{found}");
    assert!(estimate.standard_error.is_infinite(), "{found}");
}

/// The mean of some rows of a series, with others that the parameter does not touch.
struct Share(Vec<f64>, usize);

residuals!(Share, 1: |this, &[mean], each| {
    for (row, &y) in this.0.iter().enumerate() {
        each(if row < this.1 { mean } else { T::zero() } - lit(y));
    }
});

#[test]
fn scores_are_added_over_a_window() {
    // An autoregressive series in the first fifth of the rows, nothing after. The mean of m rows
    // has the variance σ²/m (1 + ρ)/(1 − ρ). Without a window it would be σ²/m, and from the mean
    // square of all residuals a fifth of it.
    let (rows, share, correlation) = (50_000, 10_000, 0.9_f64);
    let mut series: Vec<f64> = Draw(5).coloured(correlation).take(share).collect();
    series.resize(rows, 0.0);
    let found = best(&Share(series, share));
    let want = ((1.0 + correlation) / (1.0 - correlation) / share as f64).sqrt();
    let ratio = found.estimates[0].standard_error / want;
    // Windows of 190 in 10 000 rows leave √(4/3 · 190/10 000)/2 = 8 % of noise, Bartlett's weights
    // lose some 5 %.
    assert!((0.75..1.15).contains(&ratio), "{ratio}");
    assert!((100..400).contains(&found.window), "{}", found.window);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn long_correlation_times_are_those_of_the_whole_sum() {
    // More lags than are summed row by row: ρ = 0.998 has τ = 999, five of them.
    let correlation = 0.998_f64;
    let rows = 200_000;
    let series: Vec<f64> = Draw(5).coloured(correlation).take(rows).collect();
    let mean = series.iter().sum::<f64>() / rows as f64;
    let product = |lag: usize| -> f64 {
        series.iter().zip(&series[lag..]).map(|(a, b)| (a - mean) * (b - mean)).sum()
    };
    let (square, mut time, mut lag) = (product(0), 1.0, 0);
    while (lag as f64) < 5.0 * time {
        lag += 1;
        time += 2.0 * product(lag) / square;
    }
    let found = best(&Mean(series));
    let ratio = rows as f64 / found.effective_rows / time;
    // The sum ends within a block of ten or so of the same lag, where ρ is noise: √(2 τ/n) = 0.1
    // times 2 · 10 rows of 999.
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}, {lag} lags");
}

/// Two minima: v² = 1 and a little of v = 1, so that v = 1 has no residual, and near −0.95 there is
/// another minimum.
struct Two;

residuals!(Two, 1: |_this, &[v], each| {
    each(v * v - T::one());
    each((v - T::one()) * lit(0.3));
});

#[test]
fn more_starts_find_a_minimum_far_away() {
    let (mut places, mut numbers) = (vec![], vec![]);
    for (starts, want) in [(1, -0.95), (8, 1.0)] {
        let settings = SearchSettings { starts, ..SearchSettings::default() };
        places.clear();
        numbers.clear();
        let mut watch = |now: &SearchProgress<'_>| {
            // Steps tried in vain are told, too.
            if numbers.last() != Some(&now.start) {
                places.push(now.values[0]);
                numbers.push(now.start);
            }
            ControlFlow::Continue(())
        };
        let parameter = Parameter { start: -0.9, least: -3.0, most: 3.0, ..within_ten("v") };
        let found = least_squares(&Two, [parameter], &settings, &mut watch).unwrap();
        // −0.95 is a root of 4v(v² − 1) + 0.18 (v − 1) to one digit more.
        assert!((found.values()[0] - want).abs() < 0.01, "{starts}: {found}");
    }
    places.sort_by(f64::total_cmp);
    places.dedup();
    assert!(places.len() >= 7, "{places:?}");
    // A step that was tried in vain is reported, too.
    numbers.dedup();
    assert_eq!(numbers, Vec::from_iter(0..8));
}

/// Falls at every whole number: no derivative tells so.
struct Steps;

residuals!(Steps, 1: |_this, &[x], each| {
    let value: f64 = x.to_subset_unchecked();
    each(lit(value.floor()));
});

/// |x| with a slope that has the wrong sign.
struct Misled;

residuals!(Misled, 1: |_this, &[x], each| {
    let value: f64 = x.to_subset_unchecked();
    each(lit::<T>(2.0 * value) - x);
});

#[test]
fn a_search_that_a_probe_can_still_improve_has_stalled() {
    let start = |value| {
        [Parameter { start: value, least: 1.0, most: 1e6, typical: Some(1.0), ..within_ten("x") }]
    };
    let found = least_squares(&Steps, start(1e3), &SearchSettings::default(), &mut go_on).unwrap();
    assert_eq!(found.outcome, SearchOutcome::Stalled, "{found}");
    // Five probes by 5 % each.
    assert!((found.values()[0] / (1e3 * 0.95_f64.powi(5)) - 1.0).abs() < 1e-9, "{found}");
}

#[test]
fn a_search_whose_gradient_promises_more_has_stalled() {
    // At the upper bound of what a probe reaches the wrong slope leads nowhere.
    let narrow = Parameter { start: 5.0, least: 4.9999, most: 5.0001, ..within_ten("x") };
    let found = least_squares(&Misled, [narrow], &SearchSettings::default(), &mut go_on).unwrap();
    assert_eq!(found.outcome, SearchOutcome::Stalled, "{found}");
    assert!(!is_determined(&found) || found.estimates[0].value > 4.9, "{found}");
}

#[test]
fn a_column_of_motor_torque_is_no_friction() {
    // τ = J v̇ + G sin x + T with Coulomb friction: the torque that moves a pendulum.
    let (mut time, mut position, mut torque) = (vec![], vec![], vec![]);
    for row in 0..2000 {
        let t = 5e-3 * f64::from(row);
        let (x, v) = ((3.0 * t).sin() + 0.3 * (8.0 * t).sin(), 3.0 * (3.0 * t).cos());
        let v = v + 2.4 * (8.0 * t).cos();
        let acceleration = -9.0 * (3.0 * t).sin() - 19.2 * (8.0 * t).sin();
        time.push(t);
        position.push(x);
        torque.push(0.02 * acceleration + 0.6 * x.sin() + 0.15 * (v / 0.01).tanh());
    }
    let log = log_from(&time, MeasuredMotion::Position(&position), &torque);
    let found = fitted_with(&FrBdFit, &log, &SearchSettings::default(), &mut go_on).unwrap();
    assert!(matches!(found.remarks[..], [Remark::LooksLikeMotorTorque { .. }]), "{found}");
    assert!(found.to_string().contains("motor"), "{found}");
}

/// Gross outliers among the slowest points, where a curve could take them for a static excess. Of
/// 40 draws each 36 and more come out right; with rounds of Huber's weights before Tukey's, of the
/// first three cases none, 10 and 17.
#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn slow_outliers_are_no_static_excess() {
    for (count, gross) in [(3, 3.0), (5, 3.0), (5, 10.0), (10, 10.0), (20, 6.0)] {
        let right = |seed: u64| {
            let mut draw = Draw(seed);
            let point = |i: i32| {
                let speed = 5e-4 * f64::from(i);
                let wrong = if i <= count { gross * (0.5 + draw.next()) } else { 0.0 };
                let fall = 0.1 * (-(speed / 0.01).powi(2)).exp();
                let coefficient = 0.2 + fall + 2.0 * speed + wrong + 0.002 * draw.gauss();
                SlidingPoint { speed, coefficient }
            };
            let points: Vec<SlidingPoint> = (1..200).map(point).collect();
            let guess = InitialGuess {
                static_coefficient: 0.4,
                dynamic_coefficient: 0.25,
                stribeck_velocity: 0.03,
                viscous_friction: 0.1,
                ..GUESS
            };
            let [_, excess, _, _] = guess.static_curve(SHAPE, &points).unwrap().array();
            (excess - 0.1).abs() < 0.03
        };
        let right = (0..10).filter(|&seed| right(1000 + seed)).count();
        assert!(right >= 8, "{count} {gross}: {right} of 10");
    }
}
