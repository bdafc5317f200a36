//! The fidelity ladder of contact patches: what it chooses is good enough, and not much dearer than what would have done.

#![cfg(feature = "alloc")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]
#![allow(dead_code, unreachable_pub, reason = "the study is also run by itself")]

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::fidelity::*;
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::rolling::Motion;
use bristle::rolling::*;
use bristle::signal::{Constant, Polyline, Signal, Sine, SineParameters, Vertex};
use bristle::{FrBd, paper};

type Model = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;

/// Uniform numbers in [0, 1) by the 64-bit linear congruential generator of Knuth (MMIX), upper 53 bits.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn one_of<A: Copy>(&mut self, all: &[A]) -> A {
        all[((self.next() * all.len() as f64) as usize).min(all.len() - 1)]
    }

    fn logarithmic(&mut self, from: f64, to: f64) -> f64 {
        from * (to / from).powf(self.next())
    }
}

/// Table 1, a rubber with damping, Table 2.
fn model(set: usize) -> Model {
    let rubber = StribeckParameters {
        static_coefficient: 1.3,
        dynamic_coefficient: 0.9,
        stribeck_velocity: 0.5,
        stribeck_exponent: 1.0,
        viscous_friction: 0.01,
    };
    let soft = KelvinVoigtParameters { micro_stiffness: 400.0, micro_damping: 0.5 };
    let (curve, bristle) = match set {
        0 | 1 => (paper::TYRE_CURVE, paper::TYRE_BRISTLE),
        2 => (rubber, soft),
        _ => (paper::STICK_SLIP_CURVE, paper::STICK_SLIP_BRISTLE),
    };
    FrBd::new(Stribeck::new(curve).unwrap(), KelvinVoigt::new(bristle).unwrap())
}

fn patch<P: Pressure<f64>>(set: usize, pressure: P) -> Patch<f64, Model, P> {
    let parameters = PatchParameters { model: model(set), length: paper::TYRE_LENGTH, pressure };
    Patch::new(parameters).unwrap().carrying(1000.0).unwrap()
}

fn trapezium() -> TabulatedPressure<f64, 4> {
    TabulatedPressure::trapezoidal(TrapezoidalParameters {
        rising_part: 0.1,
        falling_part: 0.3,
        plateau: 1.0,
    })
    .unwrap()
}

/// The force at a time, from nothing but the model's coefficients: every bristle followed back to where it entered, in steps
/// that cross a `finesse`th of the patch.
fn truth<P: Pressure<f64>, S: Signal<f64>, W: Signal<f64>>(
    patch: &Patch<f64, Model, P>,
    motion: &MotionOverTime<S, W>,
    start: Start,
    time: f64,
    finesse: f64,
) -> f64 {
    let model = patch.model();
    let v_at = |t: f64| motion.slip_velocity.value(t);
    let w_at = |t: f64| motion.rolling_speed.value(t) / paper::TYRE_LENGTH;
    // What has become of a bristle of z: kept z + gained.
    let (mut kept, mut gained, mut place, mut now) = (1.0_f64, 0.0_f64, 0.0_f64, time);
    let mut sum = 0.0;
    let mut piece = |from: f64, z_from: f64, to: f64, z_to: f64| {
        // Three points: z is taken to be straight, p as it is.
        let to = to.min(1.0);
        let mid = 0.5 * (from + to);
        let (p, q, r) =
            (patch.pressure().at(from.min(1.0)), patch.pressure().at(mid), patch.pressure().at(to));
        sum += (to - from) / 6.0 * (p * z_from + 2.0 * q * (z_from + z_to) + r * z_to);
    };
    while place < 1.0 && now > 0.0 {
        let h = (1.0 / (finesse * w_at(now))).min(now);
        let (v, w) = (v_at(now - 0.5 * h), w_at(now - 0.5 * h));
        let affine = model.at_velocity(v);
        let x = affine.relaxation * h;
        let fresh = if x == 0.0 {
            affine.drive * v * h
        } else {
            affine.drive * v / affine.relaxation * -(-x).exp_m1()
        };
        let before = (place, gained);
        gained += kept * fresh;
        kept *= (-x).exp();
        place += w * h;
        now -= h;
        piece(before.0, before.1, place, gained);
    }
    if place < 1.0 {
        // Those that were there at the start.
        let at_start =
            Motion { slip_velocity: v_at(0.0), rolling_speed: paper::TYRE_LENGTH * w_at(0.0) };
        let steady = patch.steady(at_start).unwrap();
        let (width, parts) = (1.0 - place, 4000);
        let z = |xi: f64| match start {
            Start::Steady => kept * steady.deflection(xi) + gained,
            Start::Undeflected => gained,
        };
        for part in 0..parts {
            let (a, b) = (
                width * f64::from(part) / f64::from(parts),
                width * f64::from(part + 1) / f64::from(parts),
            );
            piece(place + a, z(a), place + b, z(b));
        }
    }
    let v = v_at(time);
    let affine = model.at_velocity(v);
    patch.load() * patch.length() * affine.stiffness * sum
        + patch.normal_force() * affine.damping * v
}

fn norm(norm: Norm, a: &[f64], b: &[f64]) -> f64 {
    let off = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    match norm {
        Norm::Greatest => off.fold(0.0, f64::max),
        Norm::RootMeanSquare => (off.map(|e| e * e).sum::<f64>() / a.len() as f64).sqrt(),
    }
}

/// What is asked of a scene.
#[derive(Debug, Clone, Copy)]
struct Drawn {
    interval: f64,
    answers: usize,
    period: Option<usize>,
    start: Start,
    tolerance: Tolerance,
    /// Steps in a transit for the truth.
    finesse: f64,
}

#[derive(Debug)]
struct Outcome {
    refused: bool,
    met: bool,
    ratio: f64,
    line: String,
}

fn judge<P: Pressure<f64>, S: Signal<f64>, W: Signal<f64>>(
    scene: &RollingHistory<f64, Model, P, S, W>,
    patch: &Patch<f64, Model, P>,
    motion: &MotionOverTime<S, W>,
    drawn: &Drawn,
    what: &str,
) -> Outcome {
    let tolerance = drawn.tolerance;
    let choice = match scene.choose(tolerance) {
        Ok(choice) => choice,
        Err(error @ FidelityError::PilotTooShort { .. }) => {
            let line = format!("{what}: {error}");
            return Outcome { refused: true, met: true, ratio: 1.0, line };
        }
        Err(error) => panic!("{what}: {error}"),
    };
    let times = (1..=drawn.answers).map(|index| drawn.interval * index as f64);
    let truth: Vec<f64> =
        times.map(|time| truth(patch, motion, drawn.start, time, drawn.finesse)).collect();
    let error = norm(tolerance.norm, &scene.forces(choice.plan).unwrap(), &truth);
    let mut plans: Vec<Plan> = Vec::new();
    for plan in scene.plans() {
        for doubling in 0..if plan.rung == Rung::SlipCurve { 1 } else { 8 } {
            plans.push(scene.with_substeps(plan, 1 << doubling));
        }
    }
    plans.sort_by(|a, b| a.cost_rate.total_cmp(&b.cost_rate));
    let cheapest = plans
        .iter()
        .take_while(|plan| plan.cost_rate < 0.999 * choice.plan.cost_rate)
        .find(|plan| norm(tolerance.norm, &scene.forces(**plan).unwrap(), &truth) <= choice.allowed)
        .copied()
        .unwrap_or(choice.plan);
    let ratio = choice.plan.cost_rate / cheapest.cost_rate;
    let budget = 2000.0_f64.max(0.05 * 2.0 * drawn.answers as f64);
    assert!(choice.pilot_evaluations <= budget, "{what}: pilot {}", choice.pilot_evaluations);
    if choice.verdict == Verdict::Proved {
        assert!(error <= choice.error, "{what}: {error:e} above the bound {:e}", choice.error);
    }
    Outcome {
        refused: false,
        met: error <= choice.allowed,
        ratio,
        line: format!(
            "{what}\n      {} {} x{} {}: error {:.3} of allowed (said {:.3}), cost {ratio:.2} of {} {} x{}, pilot {:.0}",
            choice.plan.rung,
            choice.plan.integrator,
            choice.plan.substeps,
            choice.verdict,
            error / choice.allowed,
            choice.error / choice.allowed,
            cheapest.rung,
            cheapest.integrator,
            cheapest.substeps,
            choice.pilot_evaluations
        ),
    }
}

/// Under one of four pressures.
fn under<S: Signal<f64>, W: Signal<f64>>(
    set: usize,
    pressure: usize,
    motion: &MotionOverTime<S, W>,
    drawn: &Drawn,
    what: &str,
) -> Outcome {
    fn exact<S: Signal<f64>, W: Signal<f64>, const N: usize>(
        patch: Patch<f64, Model, PolynomialExponential<f64, N>>,
        motion: &MotionOverTime<S, W>,
        drawn: &Drawn,
        what: &str,
    ) -> Outcome {
        let scene = RollingHistory::new(parameters(patch, motion, drawn)).unwrap();
        judge(&scene, &patch, motion, drawn, what)
    }
    match pressure {
        0 => exact(patch(set, PolynomialExponential::constant()), motion, drawn, what),
        1 => {
            let decay = PolynomialExponential::exponential(1.0).unwrap();
            exact(patch(set, decay), motion, drawn, what)
        }
        2 => exact(patch(set, PolynomialExponential::parabolic()), motion, drawn, what),
        _ => {
            let patch = patch(set, trapezium());
            let scene = RollingHistory::on_grid(parameters(patch, motion, drawn)).unwrap();
            judge(&scene, &patch, motion, drawn, what)
        }
    }
}

fn parameters<P, S: Clone, W: Clone>(
    patch: Patch<f64, Model, P>,
    motion: &MotionOverTime<S, W>,
    drawn: &Drawn,
) -> RollingHistoryParameters<f64, Model, P, S, W> {
    let Drawn { interval, answers, period, start, .. } = *drawn;
    RollingHistoryParameters { patch, motion: motion.clone(), interval, answers, period, start }
}

fn draw(dice: &mut Draw, most_periods: f64) -> (f64, f64, f64, f64, Drawn) {
    let amplitude = dice.logarithmic(1e-6, 10.0);
    let frequency = dice.logarithmic(0.01, 1000.0);
    let mean = amplitude * dice.one_of(&[0.0, 0.0, 0.3, 1.1, 2.0]);
    let transport = dice.logarithmic(1.0, 50.0) / paper::TYRE_LENGTH;
    let period = dice.one_of(&[36, 50, 100, 200]);
    let periods = dice.logarithmic(1.0, most_periods);
    let share = dice.logarithmic(1e-3, 0.1);
    let drawn = Drawn {
        interval: 1.0 / (frequency * period as f64),
        answers: (periods * period as f64) as usize,
        period: (periods > 2.0).then_some(period),
        start: dice.one_of(&[Start::Undeflected, Start::Steady]),
        tolerance: Tolerance { norm: dice.one_of(&[Norm::Greatest, Norm::RootMeanSquare]), share },
        // A period of the motion is followed in two hundred steps at least.
        finesse: (200.0 * frequency / (0.7 * transport)).max(1000.0),
    };
    (mean, amplitude, frequency, transport, drawn)
}

fn sines(seed: u64, scenes: usize, most_periods: f64) -> Vec<Outcome> {
    let mut dice = Draw(seed);
    let mut outcomes = Vec::new();
    for index in 0..scenes {
        let (mean, amplitude, frequency, transport, drawn) = draw(&mut dice, most_periods);
        let sine = |mean, amplitude, phase| {
            Sine::new(SineParameters { mean, amplitude, frequency, phase }).unwrap()
        };
        let swing = transport * dice.one_of(&[0.0, 0.0, 0.1, 0.3]);
        let motion = MotionOverTime {
            slip_velocity: sine(mean, amplitude, dice.one_of(&[0.0, 1.0, 2.5])),
            rolling_speed: sine(paper::TYRE_LENGTH * transport, paper::TYRE_LENGTH * swing, 0.5),
        };
        let (set, pressure) = (index % 4, (index / 4) % 4);
        let what = format!(
            "{index:3} set {set} pressure {pressure} v = {mean:.2e} + {amplitude:.2e} sin, V = {transport:.2e} + {swing:.2e} sin, {frequency:.2e} Hz, {} answers of {:?}, {:?} {:.1e}, {:?}",
            drawn.answers, drawn.period, drawn.tolerance.norm, drawn.tolerance.share, drawn.start
        );
        outcomes.push(under(set, pressure, &motion, &drawn, &what));
    }
    outcomes
}

/// Motions that never repeat themselves: straight lines between twelve values.
fn polylines(seed: u64, scenes: usize) -> Vec<Outcome> {
    let mut dice = Draw(seed);
    let mut outcomes = Vec::new();
    for index in 0..scenes {
        let (_, amplitude, frequency, transport, drawn) = draw(&mut dice, 2.0);
        let answers = 120 + (dice.next() * 200.0) as usize;
        // Kinks cost the truth its order: the square of a step times the change of slope.
        let finesse = drawn.finesse.max(1000.0 * frequency / (0.7 * transport));
        let drawn = Drawn { answers, period: None, finesse, ..drawn };
        let end = drawn.interval * answers as f64;
        let mut line = |least: f64, most: f64| {
            let mut time = 0.0;
            Polyline::new([(); 12].map(|()| {
                let value = least + (most - least) * dice.next();
                let vertex = Vertex { time, value };
                time += end * (0.01 + 0.15 * dice.next());
                vertex
            }))
            .unwrap()
        };
        let motion = MotionOverTime {
            slip_velocity: line(-amplitude, amplitude),
            rolling_speed: line(0.07 * transport, 0.13 * transport),
        };
        let (set, pressure) = (index % 4, (index / 4) % 4);
        let what = format!(
            "{index:3} set {set} pressure {pressure} polyline {amplitude:.2e} m/s, V = {transport:.2e}, {frequency:.2e} Hz, {end:.2e} s, {answers} answers, {:?} {:.1e}",
            drawn.tolerance.norm, drawn.tolerance.share
        );
        outcomes.push(under(set, pressure, &motion, &drawn, &what));
    }
    outcomes
}

fn verdict(outcomes: &[Outcome]) {
    let wrong: Vec<_> = outcomes.iter().filter(|o| !o.met).map(|o| &o.line).collect();
    let dear: Vec<_> = outcomes.iter().filter(|o| !(o.ratio <= 2.0)).map(|o| &o.line).collect();
    for outcome in outcomes {
        println!("{}{}", if outcome.met { "" } else { "WRONG " }, outcome.line);
    }
    let refused = outcomes.iter().filter(|o| o.refused).count();
    let all = outcomes.len();
    println!("{all} scenes, {} wrong, {} dear, {refused} refused", wrong.len(), dear.len());
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!((dear.len() + refused) * 10 <= all, "{dear:#?}");
}

#[test]
#[ignore = "a study, for a release build: SEED chooses the scenes"]
fn three_hundred_scenes_drawn_by_chance() {
    let seed = std::env::var("SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(2611);
    // What is missed of the cost lies with motions that never repeat themselves: of these one in six is refused, for
    // want of means for the reference.
    let mut outcomes = sines(seed, 192, 60.0);
    outcomes.extend(polylines(seed, 128));
    verdict(&outcomes);
}

#[test]
fn a_dozen_scenes_drawn_by_chance_are_answered_within_tolerance() {
    // The seed was chosen after the last change of a threshold. What they cost is
    // judged over more scenes.
    let mut outcomes = sines(2611, 8, 2.0);
    outcomes.extend(polylines(2611, 4));
    for outcome in &outcomes {
        assert!(outcome.met, "{}", outcome.line);
    }
    let refused = outcomes.iter().filter(|outcome| outcome.refused).count();
    println!("{refused} refused of {}", outcomes.len());
    assert!(refused <= 2, "{refused} of {} are not answered", outcomes.len());
}

/// A tyre of Table 1 under a parabola, rolling at 16 m/s.
fn tyre(
    mean: f64,
    amplitude: f64,
    frequency: f64,
) -> RollingHistory<f64, Model, PolynomialExponential<f64, 3>, Sine<f64>, Constant<f64>> {
    let slip = SineParameters { mean, amplitude, frequency, phase: 0.0 };
    RollingHistory::new(RollingHistoryParameters {
        patch: patch(0, PolynomialExponential::parabolic()),
        motion: MotionOverTime {
            slip_velocity: Sine::new(slip).unwrap(),
            rolling_speed: Constant::new(16.0).unwrap(),
        },
        interval: 0.01 / frequency,
        answers: 1000,
        period: Some(100),
        start: Start::Steady,
    })
    .unwrap()
}

#[test]
fn each_kind_of_motion_gets_the_rung_that_its_physics_asks_for() {
    let rung = |frequency, share| {
        let tolerance = Tolerance { norm: Norm::Greatest, share };
        let choice = tyre(0.2, 0.2, frequency).choose(tolerance).unwrap();
        (choice.plan.rung, choice.verdict)
    };
    // A thousand transits in a period, thirty, a half.
    assert_eq!(rung(0.16, 0.05), (Rung::SlipCurve, Verdict::Proved));
    assert_eq!(rung(5.0, 0.03).0, Rung::RelaxationLength);
    assert_eq!(rung(320.0, 0.01).0, Rung::Patch);
}

#[test]
fn the_relaxation_length_in_adhesion_is_that_of_the_pressure() {
    // ∫pξ²/(2∫pξ) of a parabola: (1/4 − 1/5)/(2 (1/3 − 1/4)) = 0.3 of the length.
    let length = tyre(0.0, 1e-6, 1.0).relaxation_length();
    assert!((length / paper::TYRE_LENGTH - 0.3).abs() < 1e-4, "{length}");
}

#[test]
fn the_slip_curve_and_the_relaxation_length_are_exact_where_nothing_changes() {
    let scene = tyre(0.3, 0.0, 10.0);
    let steady = patch(0, PolynomialExponential::parabolic())
        .steady(Motion { slip_velocity: 0.3, rolling_speed: 16.0 })
        .unwrap()
        .force;
    for plan in scene.plans() {
        for force in scene.forces(plan).unwrap() {
            assert!((force / steady - 1.0).abs() < 1e-12, "{plan:?}: {force}");
        }
    }
    let choice = scene.choose(Tolerance { norm: Norm::Greatest, share: 1e-9 }).unwrap();
    assert_eq!((choice.plan.rung, choice.verdict), (Rung::SlipCurve, Verdict::Proved));
}

#[test]
fn a_bound_holds_and_shrinks_with_the_frequency() {
    let wide = Tolerance { norm: Norm::Greatest, share: 10.0 };
    let mut last = f64::INFINITY;
    for frequency in [100.0, 10.0, 1.0, 0.1] {
        let scene = tyre(0.3, 0.25, frequency);
        let choice = scene.choose(wide).unwrap();
        assert_eq!(choice.verdict, Verdict::Proved);
        let finest = scene.with_substeps(*scene.plans().last().unwrap(), 16);
        let truth = scene.forces(finest).unwrap();
        let error = norm(Norm::Greatest, &scene.forces(choice.plan).unwrap(), &truth);
        assert!(error <= choice.error, "{frequency} Hz: {error:e} above {:e}", choice.error);
        assert!(choice.error < last);
        last = choice.error;
    }
}

#[test]
fn senseless_patches_and_motions_are_refused_by_name() {
    let parabola = patch(0, PolynomialExponential::parabolic());
    let refused = |slip: f64, transport: [f64; 2], interval, answers| {
        let value = |time, value| Vertex { time, value };
        let motion = MotionOverTime {
            slip_velocity: bristle::signal::Function::new(move |_: f64| (slip, 0.0), []),
            rolling_speed: Polyline::new([value(0.0, transport[0]), value(1.0, transport[1])])
                .unwrap(),
        };
        let tolerance = Tolerance { norm: Norm::Greatest, share: 0.01 };
        let period = None;
        let start = Start::Steady;
        let drawn = Drawn { interval, answers, period, start, tolerance, finesse: 1.0 };
        RollingHistory::new(parameters(parabola, &motion, &drawn)).unwrap_err().name
    };
    assert_eq!(refused(f64::NAN, [100.0; 2], 0.1, 10), "slip_velocity");
    assert_eq!(refused(f64::INFINITY, [100.0; 2], 0.1, 10), "slip_velocity");
    assert_eq!(refused(1.0, [100.0, -1.0], 0.1, 10), "rolling_speed");
    assert_eq!(refused(1.0, [100.0; 2], f64::NAN, 10), "interval");
    assert_eq!(refused(1.0, [100.0; 2], 0.1, 7), "answers");
    for share in [0.0, -1.0, f64::NAN] {
        let answer = tyre(0.3, 0.2, 1.0).choose(Tolerance { norm: Norm::Greatest, share });
        assert!(matches!(answer, Err(FidelityError::Parameter(e)) if e.name == "share"));
    }
}

#[test]
fn a_tolerance_that_nothing_meets_is_named_and_a_starved_pilot_says_what_it_needs() {
    let impossible = Tolerance { norm: Norm::Greatest, share: 1e-15 };
    let answer = tyre(0.1, 0.3, 100.0).choose(impossible);
    assert!(matches!(answer, Err(FidelityError::OutOfReach { .. })), "{answer:?}");
    let fine = Tolerance { norm: Norm::Greatest, share: 1e-3 };
    let starved = tyre(0.1, 0.3, 100.0).choose_within(fine, 50.0);
    assert!(
        matches!(starved, Err(FidelityError::PilotTooShort { allowed: 50.0, .. })),
        "{starved:?}"
    );
}

/// The tyre along any motion, from steady rolling on.
fn rolled<S: Signal<f64>, W: Signal<f64>>(
    slip_velocity: S,
    rolling_speed: W,
    interval: f64,
    answers: usize,
    period: Option<usize>,
) -> Result<RollingHistory<f64, Model, PolynomialExponential<f64, 3>, S, W>, bristle::ParameterError>
{
    RollingHistory::new(RollingHistoryParameters {
        patch: patch(0, PolynomialExponential::parabolic()),
        motion: MotionOverTime { slip_velocity, rolling_speed },
        interval,
        answers,
        period,
        start: Start::Steady,
    })
}

/// Whether there is an answer. One that is must be true, and a refusal must name what a pilot would need.
#[track_caller]
fn answered<S: Signal<f64>, W: Signal<f64>>(
    scene: &RollingHistory<f64, Model, PolynomialExponential<f64, 3>, S, W>,
) -> bool {
    match scene.choose(Tolerance { norm: Norm::Greatest, share: 0.01 }) {
        Err(FidelityError::PilotTooShort { needed, allowed }) => {
            assert!(allowed > 0.0 && needed > allowed, "{needed} of {allowed}");
            false
        }
        Err(other) => panic!("{other}"),
        Ok(choice) => {
            let truth = scene.forces(scene.with_substeps(scene.plans()[2], 16)).unwrap();
            let error = norm(Norm::Greatest, &scene.forces(choice.plan).unwrap(), &truth);
            assert!(error <= choice.allowed, "{error} of {}\n{choice}", choice.allowed);
            true
        }
    }
}

#[test]
fn a_period_of_few_factors_is_seen_at_many_phases_or_refused() {
    for period in [240, 251, 509] {
        let interval = 1e-5;
        let frequency = 1.0 / (period as f64 * interval);
        let slip = SineParameters { mean: 0.0, amplitude: 0.3, frequency, phase: 0.0 };
        let transport = Constant::new(160.0).unwrap();
        let slip = Sine::new(slip).unwrap();
        let scene = rolled(slip, transport, interval, 10 * period, Some(period)).unwrap();
        assert_eq!(answered(&scene), period == 240, "{period}");
    }
}

#[test]
fn what_happens_between_the_instants_of_a_pilot_is_seen_or_refused() {
    let interval = 1e-4;
    let steady = || Constant::new(160.0).unwrap();
    let value = |answer: f64, value| Vertex { time: answer * interval, value };
    let reversal = Polyline::new([
        value(2049.0, 0.3),
        value(2049.5, -0.3),
        value(2054.0, -0.3),
        value(2054.5, 0.3),
    ])
    .unwrap();
    assert!(!answered(&rolled(reversal, steady(), interval, 4000, None).unwrap()));
    let frequency = 1.0 / (8.0 * interval);
    let slip = SineParameters { mean: 0.3, amplitude: 0.3, frequency, phase: 0.0 };
    let slip = Sine::new(slip).unwrap();
    assert!(!answered(&rolled(slip, steady(), interval, 4000, None).unwrap()));
    assert!(answered(&rolled(slip, steady(), interval, 4000, Some(8)).unwrap()));
    // Brakes that lock for a moment.
    let locked = Polyline::new([
        value(2049.0, 160.0),
        value(2050.0, 0.0),
        value(2054.0, 0.0),
        value(2055.0, 160.0),
    ])
    .unwrap();
    let slip = Constant::new(0.3).unwrap();
    assert!(!answered(&rolled(slip, locked, interval, 4000, None).unwrap()));
    assert!(answered(&rolled(slip, steady(), interval, 4000, None).unwrap()));
}

#[test]
fn counts_and_speeds_beyond_all_means_are_refused_by_name() {
    let slip = Constant::new(0.3).unwrap();
    let name = |transport: f64, answers, period| {
        let transport = Constant::new(paper::TYRE_LENGTH * transport).unwrap();
        rolled(slip, transport, 1e-2, answers, period).unwrap_err().name
    };
    for many in [1_000_000_001, usize::MAX / 2, usize::MAX / 2 + 1, usize::MAX] {
        assert_eq!(name(160.0, 1000, Some(many)), "period");
        assert_eq!(name(0.0, many, None), "answers");
    }
    // Long after what the pilot looks at.
    for speed in [1e12, f64::INFINITY, f64::NAN] {
        let jump = bristle::signal::Function::new(
            move |time: f64| (if time < 0.505 { 100.0 } else { speed }, 0.0),
            [0.505],
        );
        let scene = rolled(slip, jump, 1e-2, 100, Some(25)).unwrap();
        for plan in scene.plans() {
            let refused = scene.forces(plan).map(|forces| forces.iter().all(|f| f.is_finite()));
            let named =
                matches!(&refused, Err(FidelityError::Parameter(e)) if e.name == "rolling_speed");
            // However fast, the last transit is rolled through.
            assert!(named || speed == 1e12 && matches!(refused, Ok(true)), "{plan:?} {refused:?}");
        }
        // A moment at that speed between two answers, and not at the second.
        let moment = bristle::signal::Function::new(
            move |time: f64| (if (0.501..0.509).contains(&time) { speed } else { 100.0 }, 0.0),
            [0.501, 0.509],
        );
        let scene = rolled(slip, moment, 1e-2, 100, Some(25)).unwrap();
        let gauss = scene.plans()[3];
        assert_eq!(gauss.integrator, Integrator::Gauss);
        let refused = scene.forces(gauss);
        let named =
            matches!(&refused, Err(FidelityError::Parameter(e)) if e.name == "rolling_speed");
        assert!(named, "{refused:?}");
        let plan = scene.plans()[2];
        assert_eq!(scene.with_substeps(plan, usize::MAX).substeps, 1 << 20);
        let refused = scene.forces(Plan { substeps: usize::MAX, ..plan });
        let named =
            matches!(&refused, Err(FidelityError::Parameter(e)) if e.name == "plan.substeps");
        assert!(named, "{refused:?}");
    }
}

/// What the slip curve alone errs by \[N\], and the bound on it.
fn error_and_bound<S: Signal<f64>, W: Signal<f64>, const N: usize>(
    patch: Patch<f64, Model, PolynomialExponential<f64, N>>,
    motion: &MotionOverTime<S, W>,
    drawn: &Drawn,
) -> (f64, f64) {
    let scene = RollingHistory::new(parameters(patch, motion, drawn)).unwrap();
    let choice = scene.choose(drawn.tolerance).unwrap();
    assert_eq!((choice.plan.rung, choice.verdict), (Rung::SlipCurve, Verdict::Proved));
    let times = (1..=drawn.answers).map(|index| drawn.interval * index as f64);
    let truth: Vec<f64> =
        times.map(|time| truth(&patch, motion, drawn.start, time, drawn.finesse)).collect();
    (norm(Norm::Greatest, &scene.forces(choice.plan).unwrap(), &truth), choice.error)
}

/// So many answers at so long an interval, with a tolerance that the slip curve always meets.
fn any_error(interval: f64, answers: usize, start: Start, finesse: f64) -> Drawn {
    let tolerance = Tolerance { norm: Norm::Greatest, share: 1e3 };
    Drawn { interval, answers, period: None, start, tolerance, finesse }
}

#[test]
fn no_bound_is_below_the_error_of_a_start_a_swing_or_a_reversal() {
    let tyre = patch(0, PolynomialExponential::parabolic());
    // A start from nothing; κ from one to eighty; reversals that fall between answers, at little and at much κ.
    for (mean, amplitude, frequency, transport, interval, answers, start) in [
        (0.3, 0.0, 1.0, 160.0, 6.25e-6, 400, Start::Undeflected),
        (2.0, 1.9, 50.0, 20.0, 2e-4, 400, Start::Steady),
        (0.0, 1.0, 20.0, 160.0, 1.0 / 720.0, 72, Start::Steady),
        (0.3, 1.0, 1.0, 40.0, 1.0 / 36.0, 72, Start::Steady),
        (0.0, 3.0, 300.0, 20.0, 1e-4, 100, Start::Steady),
    ] {
        let slip = SineParameters { mean, amplitude, frequency, phase: 0.0 };
        let motion = MotionOverTime {
            slip_velocity: Sine::new(slip).unwrap(),
            rolling_speed: Constant::new(paper::TYRE_LENGTH * transport).unwrap(),
        };
        // A step of the truth is a thousandth of a transit or of a period.
        let finesse = 1000.0_f64.max(1000.0 * frequency / transport);
        let drawn = any_error(interval, answers, start, finesse);
        let (error, bound) = error_and_bound(tyre, &motion, &drawn);
        println!("{mean} + {amplitude} sin, {frequency} Hz: {error} {bound} {}", bound / error);
        assert!(error <= bound, "{mean} + {amplitude} sin: {error} N above {bound} N");
    }
}

#[test]
fn the_bound_of_a_start_from_nothing_is_attained_where_all_bristles_slide() {
    // κ = 3450: at the first answer, 0.7 % of a relaxation later, z_ss is still missing almost everywhere.
    let motion = MotionOverTime {
        slip_velocity: Constant::new(10.0).unwrap(),
        rolling_speed: Constant::new(0.2).unwrap(),
    };
    let drawn = any_error(1e-6, 20, Start::Undeflected, 1e5);
    let even = patch(0, PolynomialExponential::constant());
    let (error, bound) = error_and_bound(even, &motion, &drawn);
    assert!(error <= bound && bound < 1.02 * error, "{error} N, bound {bound} N");
}

#[test]
fn the_bound_of_a_step_of_the_slip_is_attained_where_only_the_deflection_changes() {
    // μ = 0.01 + v: λ = σ0 v/μ is nearly that of any v, κ = 500, and z_ss goes with v.
    let curve = StribeckParameters {
        static_coefficient: 0.01,
        dynamic_coefficient: 0.01,
        viscous_friction: 1.0,
        ..paper::TYRE_CURVE
    };
    let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE).unwrap();
    let patch = Patch::new(PatchParameters {
        model: FrBd::new(Stribeck::new(curve).unwrap(), bristle),
        length: paper::TYRE_LENGTH,
        pressure: PolynomialExponential::constant(),
    });
    let [at, jump] = [4.99e-5, 5e-5];
    let vertices = [(0.0, 1.0), (at, 1.0), (jump, 2.0), (1.0, 2.0)];
    let motion = MotionOverTime {
        slip_velocity: Polyline::new(vertices.map(|(time, value)| Vertex { time, value })).unwrap(),
        rolling_speed: Constant::new(0.05).unwrap(),
    };
    // Steps of the truth of a tenth of the jump.
    let drawn = any_error(1e-5, 20, Start::Steady, 2e8);
    let (error, bound) = error_and_bound(patch.unwrap().carrying(1000.0).unwrap(), &motion, &drawn);
    assert!(error <= bound && bound < 1.05 * error, "{error} N, bound {bound} N");
}

#[test]
fn the_pilot_counts_every_look_at_the_curve_of_a_patch() {
    use bristle::Bounds;
    use bristle::curve::FunctionCurve;
    use std::{cell::Cell, rc::Rc};
    // A thousand transits in a period, thirty, one and a half, a half.
    for (mean, amplitude, frequency, share) in [
        (0.2, 0.2, 0.16, 0.05),
        (0.2, 0.2, 5.0, 0.03),
        (0.1, 0.3, 100.0, 0.01),
        (0.2, 0.2, 320.0, 0.01),
    ] {
        let looks = Rc::new(Cell::new(0_u32));
        let counter = looks.clone();
        let curve = FunctionCurve::new(
            move |speed: f64| {
                counter.set(counter.get() + 1);
                let falling = 0.4 * (-0.01 * speed * speed).exp();
                (0.2 + falling + 0.0018 * speed, 0.0018 - 0.02 * speed * falling)
            },
            Bounds { min: 0.2, max: 0.7 },
        );
        let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE).unwrap();
        let patch = Patch::new(PatchParameters {
            model: FrBd::new(curve.unwrap(), bristle),
            length: paper::TYRE_LENGTH,
            pressure: PolynomialExponential::parabolic(),
        });
        let slip = SineParameters { mean, amplitude, frequency, phase: 0.0 };
        let scene = RollingHistory::new(RollingHistoryParameters {
            patch: patch.unwrap().carrying(1000.0).unwrap(),
            motion: MotionOverTime {
                slip_velocity: Sine::new(slip).unwrap(),
                rolling_speed: Constant::new(16.0).unwrap(),
            },
            interval: 0.01 / frequency,
            answers: 1000,
            period: Some(100),
            start: Start::Steady,
        })
        .unwrap();
        looks.set(0);
        let choice = scene.choose(Tolerance { norm: Norm::Greatest, share }).unwrap();
        let (counted, said) = (f64::from(looks.get()), choice.pilot_evaluations);
        println!("{frequency} Hz: {counted} looks, {said} said");
        // A few looks at the ends are not counted, and what is kept may be looked at again.
        assert!(counted <= 1.05 * said + 20.0, "{frequency} Hz: {counted} looks, {said} said");
    }
}

#[test]
fn the_bound_of_a_reversal_between_two_answers_passes_through_rest() {
    // From 30 m/s, where μ = 0.25, down to rest, where μ_s = 0.6 (the bristles follow), and up to −30 m/s within a
    // microsecond: that both ends have |z_ss| = 0.25/σ0 says nothing of the way. And in a jump alone, all is in one leg.
    for from in [0.01, 30.0] {
        let [before, after] = [0.01 - 2e-6, 0.01 - 1e-6];
        let vertices = [(0.0, 30.0), (before, from), (after, -30.0), (1.0, -30.0)];
        let vertices = vertices.map(|(time, value)| Vertex { time, value });
        let motion = MotionOverTime {
            slip_velocity: Polyline::new(vertices).unwrap(),
            rolling_speed: Constant::new(0.05).unwrap(),
        };
        // Steps of the truth as long as the jump.
        let drawn = any_error(0.01, 8, Start::Steady, 2e6);
        let even = patch(0, PolynomialExponential::constant());
        let (error, bound) = error_and_bound(even, &motion, &drawn);
        println!("by {from} m/s: {error} N, bound {bound} N");
        assert!(error > if from < 1.0 { 700.0 } else { 450.0 }, "{error} N");
        assert!(error <= bound, "by {from} m/s: {error} N above {bound} N");
    }
}
