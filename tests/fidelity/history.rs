//! The fidelity ladder: what it chooses is good enough, and not much dearer than what would have done.

#![cfg(feature = "alloc")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use bristle::curve::Stribeck;
use bristle::exponential::Exponential;
use bristle::fidelity::*;
use bristle::rheology::{KelvinVoigt, Zener, ZenerParameters};
use bristle::signal::{Function, Polyline, Signal, Sine, SineParameters, Vertex};
use bristle::{Bristle, Contact, FrBd, ParameterError, Rule, paper};

type Lumped = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;

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

fn sets() -> [Lumped; 3] {
    [
        (paper::STICK_SLIP_CURVE, paper::STICK_SLIP_BRISTLE),
        (paper::TYRE_CURVE, paper::TYRE_BRISTLE),
        (paper::VALVE_CURVE, paper::VALVE_BRISTLE),
    ]
    .map(|(curve, bristle)| {
        FrBd::new(Stribeck::new(curve).unwrap(), KelvinVoigt::new(bristle).unwrap())
    })
}

fn norm(norm: Norm, a: &[f64], b: &[f64]) -> f64 {
    let off = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    match norm {
        Norm::Greatest => off.fold(0.0, f64::max),
        Norm::RootMeanSquare => (off.map(|e| e * e).sum::<f64>() / a.len() as f64).sqrt(),
    }
}

/// A scene of a given velocity drawn by chance.
struct Drawn {
    velocity: Sine<f64>,
    interval: f64,
    answers: usize,
    period: Option<usize>,
    start: Start,
    tolerance: Tolerance,
    what: String,
}

fn draw(dice: &mut Draw) -> Drawn {
    let amplitude = dice.logarithmic(1e-6, 10.0);
    let frequency = dice.logarithmic(0.01, 1000.0);
    let mean = amplitude * dice.one_of(&[0.0, 0.0, 0.3, 1.1, 2.0]);
    let phase = dice.one_of(&[0.0, 1.0, 2.5]);
    let period = dice.one_of(&[36, 50, 100, 200]);
    let periods = dice.logarithmic(1.0, 60.0);
    let answers = (periods * period as f64) as usize;
    let share = dice.logarithmic(1e-3, 0.2);
    let norm = dice.one_of(&[Norm::Greatest, Norm::RootMeanSquare]);
    let start = dice.one_of(&[Start::Undeflected, Start::Steady]);
    Drawn {
        velocity: Sine::new(SineParameters { mean, amplitude, frequency, phase }).unwrap(),
        interval: 1.0 / (frequency * period as f64),
        answers,
        period: (periods > 2.0).then_some(period),
        start,
        tolerance: Tolerance { norm, share },
        what: format!(
            "v = {mean:.2e} + {amplitude:.2e} sin, {frequency:.2e} Hz, {periods:.1} periods of {period}, {norm:?} {share:.1e}, {start:?}"
        ),
    }
}

/// What a scene came to.
struct Outcome {
    /// No answer: the pilot would have had to be longer.
    refused: bool,
    met: bool,
    ratio: f64,
    line: String,
}

fn judge<M: Reducible<f64>, V: Signal<f64>>(
    scene: &History<f64, M, V>,
    tolerance: Tolerance,
    answers: f64,
    truth: &[f64],
    what: &str,
) -> Outcome {
    let choice = match scene.choose(tolerance) {
        Ok(choice) => choice,
        Err(error @ (FidelityError::PilotTooShort { .. } | FidelityError::OutOfReach { .. })) => {
            let line = format!("{what}: {error}");
            return Outcome { refused: true, met: true, ratio: 1.0, line };
        }
        Err(error) => panic!("{what}: {error}"),
    };
    let error = norm(tolerance.norm, &scene.forces(choice.plan).unwrap(), truth);
    // The cheapest that would have done, from the cheapest plan on.
    let mut plans: Vec<Plan> = Vec::new();
    for plan in scene.plans() {
        let memoryless = plan.rung == Rung::StaticCurve;
        for doubling in 0..if memoryless { 1 } else { 11 } {
            plans.push(scene.with_substeps(plan, 1 << doubling));
        }
    }
    plans.sort_by(|a, b| a.cost_rate.total_cmp(&b.cost_rate));
    let cheapest = plans
        .iter()
        .take_while(|plan| plan.cost_rate < choice.plan.cost_rate)
        .find(|plan| norm(tolerance.norm, &scene.forces(**plan).unwrap(), truth) <= choice.allowed)
        .copied()
        .unwrap_or(choice.plan);
    let ratio = choice.plan.cost_rate / cheapest.cost_rate;
    let top = scene.plans().last().unwrap().rung;
    let evaluations = if top == Rung::FrBd { 2.0 } else { 3.0 };
    let budget = 2000.0_f64.max(0.05 * evaluations * answers);
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

fn exact<V: Signal<f64>>(contact: &Contact<f64, Lumped>, velocity: &V, drawn: &Drawn) -> Vec<f64> {
    let end = drawn.interval * drawn.answers as f64;
    let start = match drawn.start {
        Start::Undeflected => 0.0,
        Start::Steady => contact.stationary(velocity.value(0.0)),
    };
    let mut forces = Vec::new();
    // Every answer at the end of a step: between the ends of long ones the dense output has its own error.
    let drag = Exponential::<5>.fixed(drawn.interval / 16.0).unwrap();
    drag.sample(contact, velocity, 0.0..end, start, drawn.answers + 1, |time, z| {
        forces.push(contact.force(velocity.value(time), z));
    })
    .unwrap();
    forces.remove(0);
    forces
}

fn study(seed: u64, scenes: usize) -> Vec<Outcome> {
    let mut dice = Draw(seed);
    let mut outcomes = Vec::new();
    for index in 0..scenes {
        let set = index % 3;
        let contact = sets()[set].under_load(1.0).unwrap();
        let drawn = draw(&mut dice);
        let truth = exact(&contact, &drawn.velocity, &drawn);
        let scene = History::new(HistoryParameters {
            contact,
            velocity: drawn.velocity,
            interval: drawn.interval,
            answers: drawn.answers,
            period: drawn.period,
            start: drawn.start,
        })
        .unwrap();
        let what = format!("{index:3} set {set} {}", drawn.what);
        outcomes.push(judge(&scene, drawn.tolerance, drawn.answers as f64, &truth, &what));
    }
    outcomes
}

/// Velocities that never repeat themselves: straight lines between twelve values.
fn polylines(seed: u64, scenes: usize) -> Vec<Outcome> {
    let mut dice = Draw(seed);
    let mut outcomes = Vec::new();
    for index in 0..scenes {
        let set = index % 3;
        let contact = sets()[set].under_load(1.0).unwrap();
        let mut drawn = draw(&mut dice);
        drawn.answers = 120 + (dice.next() * 200.0) as usize;
        let amplitude = dice.logarithmic(1e-6, 10.0);
        let end = drawn.interval * drawn.answers as f64;
        let mut time = 0.0;
        let vertices = [(); 12].map(|()| {
            let vertex = Vertex { time, value: amplitude * (2.0 * dice.next() - 1.0) };
            time += end * (0.01 + 0.15 * dice.next());
            vertex
        });
        let velocity = Polyline::new(vertices).unwrap();
        let truth = exact(&contact, &velocity, &drawn);
        let scene = History::new(HistoryParameters {
            contact,
            velocity,
            interval: drawn.interval,
            answers: drawn.answers,
            period: None,
            start: drawn.start,
        })
        .unwrap();
        let (norm, share) = (drawn.tolerance.norm, drawn.tolerance.share);
        let what = format!(
            "{index:3} set {set} polyline {amplitude:.2e} m/s, {end:.2e} s, {norm:?} {share:.1e}"
        );
        outcomes.push(judge(&scene, drawn.tolerance, drawn.answers as f64, &truth, &what));
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

/// Forces far finer than those of any plan: the model's own steps, 256 in an interval.
fn converged<M: Reducible<f64>, V: Signal<f64>>(scene: &History<f64, M, V>) -> Vec<f64> {
    let plan = *scene.plans().last().unwrap();
    scene.forces(scene.with_substeps(plan, 256)).unwrap()
}

/// The same for a bristle of two springs at the top of its ladder.
fn two_springs(seed: u64, scenes: usize) -> Vec<Outcome> {
    let mut dice = Draw(seed);
    let mut outcomes = Vec::new();
    for index in 0..scenes {
        let mut drawn = draw(&mut dice);
        drawn.answers = drawn.answers.min(400);
        drawn.tolerance.share = dice.logarithmic(5e-3, 0.2);
        let zener = Zener::new(ZenerParameters {
            static_stiffness: 1e4,
            relaxing_stiffness: 2e4,
            series_damping: dice.logarithmic(10.0, 1e4),
        });
        let curve = Stribeck::new(paper::STICK_SLIP_CURVE).unwrap();
        let contact = FrBd::new(curve, zener.unwrap()).under_load(2.0).unwrap();
        outcomes.push(other(contact, &drawn, &format!("{index:3} Zener {}", drawn.what)));
    }
    outcomes
}

fn other<M: Reducible<f64>>(contact: Contact<f64, M>, drawn: &Drawn, what: &str) -> Outcome {
    let scene = History::new(HistoryParameters {
        contact,
        velocity: drawn.velocity,
        interval: drawn.interval,
        answers: drawn.answers,
        period: drawn.period,
        start: drawn.start,
    })
    .unwrap();
    let truth = converged(&scene);
    judge(&scene, drawn.tolerance, drawn.answers as f64, &truth, what)
}

#[test]
#[ignore = "a study: SEED chooses the scenes"]
fn tuning() {
    let seed = std::env::var("SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(1);
    let scenes = std::env::var("SCENES").ok().and_then(|s| s.parse().ok()).unwrap_or(60);
    let (sines, lines) = (study(seed, scenes), polylines(seed, scenes));
    for outcome in sines.iter().chain(&lines) {
        println!("{}{}", if outcome.met { "" } else { "WRONG " }, outcome.line);
    }
    let count = |name: &str, outcomes: &[Outcome]| {
        let wrong = outcomes.iter().filter(|o| !o.met).count();
        let dear = outcomes.iter().filter(|o| o.ratio > 2.0).count();
        let refused = outcomes.iter().filter(|o| o.refused).count();
        println!("{name}: {wrong} wrong, {dear} dear, {refused} refused of {}", outcomes.len());
    };
    count("sines", &sines);
    count("lines", &lines);
}

#[test]
#[ignore = "a study: SEED chooses the scenes"]
fn tops() {
    let seed = std::env::var("SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(1);
    let outcomes = two_springs(seed, 24);
    let refused = outcomes.iter().filter(|o| o.refused).count();
    for outcome in &outcomes {
        println!("{}{}", if outcome.met { "" } else { "WRONG " }, outcome.line);
    }
    println!("{} scenes, {refused} refused", outcomes.len());
    assert!(outcomes.iter().all(|outcome| outcome.met));
}

#[test]
#[ignore = "a minute in release: the thousand scenes behind the promise of nine in ten"]
fn a_thousand_scenes_drawn_by_chance_are_answered_within_tolerance_and_without_waste() {
    // Of a seed that no threshold had seen: 13 of the 500 sines and 43 of the 500 polylines miss, none is wrong.
    verdict(&study(777_001, 500));
    verdict(&polylines(777_001, 500));
}

#[test]
fn forty_eight_scenes_drawn_by_chance_are_answered_within_tolerance_and_without_waste() {
    // Other seeds served to find the thresholds.
    verdict(&study(314, 48));
}

#[test]
fn velocities_with_kinks_that_never_repeat_are_answered_so_too() {
    verdict(&polylines(314, 32));
}

#[test]
fn a_bristle_of_two_springs_is_never_replaced_by_one_that_will_not_do() {
    let outcomes = two_springs(2602, 8);
    for outcome in &outcomes {
        assert!(outcome.met, "{}", outcome.line);
    }
    // A refusal proves nothing.
    let refused = outcomes.iter().filter(|outcome| outcome.refused).count();
    println!("{refused} refused of {}", outcomes.len());
    assert!(refused <= 2, "{refused} of {} are not answered", outcomes.len());
}

fn scene(mean: f64, amplitude: f64, frequency: f64) -> History<f64, Lumped, Sine<f64>> {
    let velocity = SineParameters { mean, amplitude, frequency, phase: 0.0 };
    History::new(HistoryParameters {
        contact: sets()[0].under_load(10.0).unwrap(),
        velocity: Sine::new(velocity).unwrap(),
        interval: 0.01 / frequency,
        answers: 1000,
        period: Some(100),
        start: Start::Steady,
    })
    .unwrap()
}

#[test]
fn each_kind_of_scene_gets_the_rung_that_its_physics_asks_for() {
    let percent = Tolerance { norm: Norm::Greatest, share: 0.01 };
    let rung = |mean, amplitude, frequency| {
        scene(mean, amplitude, frequency).choose(percent).unwrap().plan.rung
    };
    // Fast sliding: the lag μ'v̇/λ is nothing. Pre-sliding far below v_S: μ is constant.
    assert_eq!(rung(0.1, 0.05, 1.0), Rung::StaticCurve);
    assert_eq!(rung(0.0, 1e-4, 1.0), Rung::Dahl);
    // The paper's frictional lag at 25 Hz, about the falling part of the curve: neither.
    assert_eq!(rung(0.0055, 0.005, 25.0), Rung::FrBd);
}

/// Asserts that what is chosen for a sine of so many answers keeps within tolerance, or that nothing is chosen.
#[track_caller]
fn keeps_its_word(set: usize, mean: f64, amplitude: f64, drawn: Drawn) {
    let contact = sets()[set].under_load(1.0).unwrap();
    let truth = exact(&contact, &drawn.velocity, &drawn);
    let scene = History::new(HistoryParameters {
        contact,
        velocity: drawn.velocity,
        interval: drawn.interval,
        answers: drawn.answers,
        period: drawn.period,
        start: drawn.start,
    })
    .unwrap();
    let what = format!("{mean} + {amplitude} sin");
    let outcome = judge(&scene, drawn.tolerance, drawn.answers as f64, &truth, &what);
    assert!(outcome.met && !outcome.refused, "{}", outcome.line);
}

fn sine(mean: f64, amplitude: f64, frequency: f64, period: usize, answers: usize) -> Drawn {
    let velocity = SineParameters { mean, amplitude, frequency, phase: 0.0 };
    Drawn {
        velocity: Sine::new(velocity).unwrap(),
        interval: 1.0 / (frequency * period as f64),
        answers,
        period: Some(period),
        start: Start::Undeflected,
        tolerance: Tolerance { norm: Norm::Greatest, share: 0.01 },
        what: String::new(),
    }
}

#[test]
fn a_reversal_at_an_answer_is_not_left_to_the_last_digit_of_the_velocity() {
    // Every fiftieth answer falls on v = 0, but for roundings that differ from period to period.
    let drawn = sine(0.0, 0.354, 0.0142, 100, 3000);
    let tolerance = Tolerance { norm: Norm::Greatest, share: 0.04 };
    keeps_its_word(2, 0.0, 0.354, Drawn { tolerance, ..drawn });
}

#[test]
fn an_error_that_grows_from_period_to_period_is_followed_to_the_end() {
    // A sixteenth of the breakaway distance is slid in a period: at first any curve will do.
    for share in [0.001, 0.002, 0.004, 0.008, 0.016] {
        let drawn = sine(3.0, 3.0, 2e4, 36, 36 * 80);
        let tolerance = Tolerance { norm: Norm::Greatest, share };
        keeps_its_word(1, 3.0, 3.0, Drawn { tolerance, ..drawn });
    }
}

#[test]
fn what_does_on_half_of_the_answers_need_not_do_on_all() {
    let drawn = sine(0.0, 9.75e-4, 2.01e-2, 36, 1177);
    let tolerance = Tolerance { norm: Norm::Greatest, share: 0.14 };
    keeps_its_word(2, 0.0, 9.75e-4, Drawn { tolerance, ..drawn });
}

#[test]
fn a_bound_holds_and_shrinks_with_the_frequency() {
    let wide = Tolerance { norm: Norm::Greatest, share: 1.0 };
    let mut last = f64::INFINITY;
    for frequency in [1.0, 0.1, 0.01] {
        let choice = scene(0.0055, 0.004, frequency).choose(wide).unwrap();
        assert_eq!(choice.verdict, Verdict::Proved);
        // ż_ss falls with the frequency, and with it what the bristle lags behind.
        assert!(choice.error < last, "{frequency} Hz: {}", choice.error);
        last = choice.error;
    }
}

#[test]
fn a_tolerance_that_nothing_meets_is_named_with_what_can_be_had() {
    let impossible = Tolerance { norm: Norm::Greatest, share: 1e-15 };
    match scene(0.0055, 0.005, 25.0).choose(impossible) {
        Err(FidelityError::OutOfReach { allowed, error, .. }) => {
            assert!((allowed - 15e-15).abs() < 1e-16 && error > allowed);
        }
        other => panic!("{other:?}"),
    }
    let starved = scene(0.0055, 0.005, 25.0)
        .choose_within(Tolerance { norm: Norm::Greatest, share: 1e-3 }, 20.0);
    assert!(
        matches!(starved, Err(FidelityError::PilotTooShort { allowed: 20.0, .. })),
        "{starved:?}"
    );
}

#[test]
fn a_period_that_is_none_is_refused_where_it_shows() {
    let scene = |period| {
        History::new(HistoryParameters {
            contact: sets()[0].under_load(1.0).unwrap(),
            velocity: Function::new(|t: f64| (0.05 + 0.002 * t, 0.002), []),
            interval: 0.02,
            answers: 1000,
            period,
            start: Start::Steady,
        })
    };
    assert!(scene(None).is_ok());
    let refused = scene(Some(50)).unwrap_err().to_string();
    assert!(refused.contains("velocity[") && refused.contains("a period before"), "{refused}");
}

#[test]
fn senseless_input_is_refused_by_name() {
    for share in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = scene(0.1, 0.05, 1.0).choose(Tolerance { norm: Norm::Greatest, share });
        assert!(matches!(refused, Err(FidelityError::Parameter(e)) if e.name == "share"));
    }
    let parameters = HistoryParameters {
        contact: sets()[0].under_load(1.0).unwrap(),
        velocity: bristle::signal::Constant::new(0.1).unwrap(),
        interval: 0.1,
        answers: 10,
        period: None,
        start: Start::Undeflected,
    };
    let refused = |parameters| History::new(parameters).unwrap_err().name;
    assert_eq!(refused(HistoryParameters { interval: f64::NAN, ..parameters }), "interval");
    assert_eq!(refused(HistoryParameters { answers: 7, ..parameters }), "answers");
    assert_eq!(refused(HistoryParameters { period: Some(2), ..parameters }), "period");
    let contact = sets()[0].under_load(0.0).unwrap();
    assert_eq!(refused(HistoryParameters { contact, ..parameters }), "normal_force");
}

#[test]
fn the_report_reads_like_a_table() {
    let choice = scene(0.0055, 0.005, 25.0)
        .choose(Tolerance { norm: Norm::RootMeanSquare, share: 0.01 })
        .unwrap();
    let text = choice.to_string();
    for part in ["static curve", "FrBD", "enough", "measured", "the pilot took", "take: "] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    // It fits a terminal, and no plan is listed twice.
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    let name = |trial: &Trial| (trial.plan.rung, trial.plan.integrator, trial.plan.substeps);
    let names: std::collections::HashSet<_> = choice.trials.iter().map(name).collect();
    assert_eq!(names.len(), choice.trials.len(), "{text}");
    assert!(choice.pilot_evaluations <= choice.pilot_budget);
}

#[test]
fn what_the_readme_shows_is_what_comes_out() {
    let velocity = SineParameters { mean: 0.0055, amplitude: 0.005, frequency: 25.0, phase: 0.0 };
    let lag = History::new(HistoryParameters {
        contact: sets()[0].under_load(1.0).unwrap(),
        velocity: Sine::new(velocity).unwrap(),
        interval: 4e-4,
        answers: 1000,
        period: Some(100),
        start: Start::Steady,
    })
    .unwrap();
    let choice = lag.choose(Tolerance { norm: Norm::Greatest, share: 0.01 }).unwrap();
    let text: Vec<String> = choice.to_string().lines().map(|l| l.trim_end().into()).collect();
    println!("{}", text.join("\n"));
    assert!(include_str!("../../README.md").contains(&text.join("\n")), "{}", text.join("\n"));
}

#[test]
fn a_sampled_velocity_with_a_kink_at_every_answer_stays_within_the_budget() {
    let mut dice = Draw(7);
    for (shift, amplitude) in [(0.0, 1e-3), (0.37, 1e-3), (0.0, 1.0), (0.37, 1.0)] {
        let vertices = [0.0; 500].map(|_: f64| 2.0 * dice.next() - 1.0);
        let mut index = 0.0;
        let vertices = vertices.map(|value| {
            index += 1.0;
            Vertex { time: (index - 1.0 + shift) * 0.01, value: amplitude * value }
        });
        let scene = History::new(HistoryParameters {
            contact: sets()[0].under_load(1.0).unwrap(),
            velocity: Polyline::new(vertices).unwrap(),
            interval: 0.01,
            answers: 499,
            period: None,
            start: Start::Undeflected,
        })
        .unwrap();
        match scene.choose(Tolerance { norm: Norm::Greatest, share: 0.01 }) {
            Ok(choice) => assert!(choice.pilot_evaluations <= choice.pilot_budget, "{choice}"),
            Err(FidelityError::PilotTooShort { .. }) => assert!(amplitude == 1.0 || shift > 0.0),
            Err(error) => panic!("{error}"),
        }
    }
}

/// A scene of the paper's stick–slip set under 1 N that starts in steady sliding.
fn dragged<V: Signal<f64>>(
    velocity: V,
    interval: f64,
    answers: usize,
    period: Option<usize>,
) -> Result<History<f64, Lumped, V>, ParameterError> {
    let contact = sets()[0].under_load(1.0).unwrap();
    let start = Start::Steady;
    History::new(HistoryParameters { contact, velocity, interval, answers, period, start })
}

/// A velocity without kinks. (Its rate is not asked for.)
fn function<F: Fn(f64) -> f64 + Clone>(
    velocity: F,
) -> Function<f64, impl Fn(f64) -> (f64, f64) + Clone, 0> {
    Function::new(move |time| (velocity(time), 0.0), [])
}

const PERCENT: Tolerance = Tolerance { norm: Norm::Greatest, share: 0.01 };

/// Whether there is an answer. One that is must be true, and a refusal must name what a pilot would need.
#[track_caller]
fn answered<V: Signal<f64>>(scene: &History<f64, Lumped, V>) -> bool {
    match scene.choose(PERCENT) {
        Err(FidelityError::PilotTooShort { needed, allowed }) => {
            assert!(allowed > 0.0 && needed > allowed, "{needed} of {allowed}");
            false
        }
        Err(other) => panic!("{other}"),
        Ok(choice) => {
            // Held steps of a 32nd of an interval: of second order, some 1e-5 off.
            let fine = scene.with_substeps(scene.plans()[2], 32);
            let truth = scene.forces(fine).unwrap();
            let error = norm(Norm::Greatest, &scene.forces(choice.plan).unwrap(), &truth);
            assert!(error <= choice.allowed, "{error} of {}\n{choice}", choice.allowed);
            true
        }
    }
}

#[test]
fn a_period_of_few_factors_is_seen_at_many_phases_or_refused() {
    for (period, seen) in
        [(251, true), (257, true), (503, false), (509, false), (1009, false), (1018, false)]
    {
        let interval = 1e-4;
        let frequency = 1.0 / (period as f64 * interval);
        let velocity = SineParameters { mean: 0.0, amplitude: 1e-3, frequency, phase: 0.0 };
        let velocity = Sine::new(velocity).unwrap();
        let scene = dragged(velocity, interval, 10 * period, Some(period)).unwrap();
        assert_eq!(answered(&scene), seen, "{period}");
    }
}

#[test]
fn what_happens_between_the_instants_of_a_pilot_is_seen_or_refused() {
    let turn = |answers: f64| core::f64::consts::TAU / answers;
    // A moment of sliding in a log of creep, dips, and a vibration of eight answers that nobody announced.
    let bump = function(|t: f64| {
        let x: f64 = t / 1e-3 - 4100.0;
        1e-4 + 0.1 * (-x * x).exp()
    });
    assert!(!answered(&dragged(bump, 1e-3, 8000, None).unwrap()));
    let dips = function(|t: f64| {
        let answer = (t / 1e-4).round() as usize % 1024;
        if (509..512).contains(&answer) { -0.3 } else { 0.05 }
    });
    assert!(!answered(&dragged(dips, 1e-4, 8192, None).unwrap()));
    let vibration = |t: f64| 0.05 + 0.06 * (turn(8.0) * t / 1e-4).sin();
    assert!(!answered(&dragged(function(vibration), 1e-4, 8000, None).unwrap()));
    // With the period told, or few enough answers, all is seen.
    assert!(answered(&dragged(function(vibration), 1e-4, 8000, Some(8)).unwrap()));
    assert!(answered(&dragged(function(vibration), 1e-4, 400, None).unwrap()));
    // What moves slowly enough is answered as before.
    let slow = function(|t: f64| 1e-4 * (turn(4000.0) * t / 1e-3).sin());
    assert!(answered(&dragged(slow, 1e-3, 8000, None).unwrap()));
}

#[test]
fn a_starved_pilot_is_refused_and_spends_nothing_beyond_its_means() {
    let slow = |t: f64| 0.05 + 0.01 * t.sin();
    let scene = dragged(function(slow), 4e-4, 100_000, None).unwrap();
    for means in [1.0, 10.0, 50.0, 100.0, 200.0, 500.0, 1e4] {
        match scene.choose_within(PERCENT, means) {
            Ok(choice) => assert!(choice.pilot_evaluations <= means, "{choice}"),
            Err(FidelityError::PilotTooShort { needed, allowed }) => {
                assert!(needed > allowed && allowed == means, "{needed} of {allowed}");
            }
            Err(other) => panic!("{other}"),
        }
    }
    assert!(scene.choose_within(PERCENT, 1.0).is_err());
}

#[test]
fn a_velocity_that_stops_being_a_number_later_on_is_named() {
    let turn = core::f64::consts::TAU;
    let broken = |t: f64| if t < 0.11 { 0.01 * (25.0 * turn * t).sin() } else { f64::NAN };
    let scene = dragged(function(broken), 4e-4, 1000, Some(100)).unwrap();
    for plan in scene.plans() {
        match scene.forces(plan) {
            // Collocation finds it by itself.
            Err(FidelityError::Stopped { rung: Rung::FrBd, .. })
                if plan.integrator == Integrator::Collocation => {}
            Err(FidelityError::Parameter(error)) => {
                assert_eq!((error.name, error.component), ("velocity", Some(275)), "{plan:?}");
            }
            other => panic!("{plan:?}: {other:?}"),
        }
    }
    // Between two answers only.
    let broken = |t: f64| {
        let answers = t / 4e-4;
        let between: f64 = answers - answers.round();
        if between.abs() < 0.3 { 0.01 } else { f64::NAN }
    };
    let scene = dragged(function(broken), 4e-4, 1000, Some(100)).unwrap();
    for plan in scene.plans().into_iter().filter(|plan| plan.integrator == Integrator::Hold) {
        let stopped = scene.forces(plan);
        assert!(matches!(stopped, Err(FidelityError::Stopped { .. })), "{stopped:?}");
    }
}

#[test]
fn counts_beyond_all_means_are_refused_by_name() {
    let name = |answers, period| {
        let error = dragged(function(|_| 0.1), 1e-3, answers, period).unwrap_err();
        assert!(matches!(error.rule, Rule::CountBetween { .. }), "{error}");
        error.name
    };
    for many in [1_000_000_001, usize::MAX / 2, usize::MAX / 2 + 1, usize::MAX] {
        assert_eq!(name(many, None), "answers");
        assert_eq!(name(many, Some(100)), "answers");
        assert_eq!(name(1000, Some(many)), "period");
    }
    let scene = dragged(function(|_| 0.1), 1e-3, 1000, Some(1_000_000_000)).unwrap();
    assert!(answered(&scene));
    let plan = scene.plans()[2];
    assert_eq!(scene.with_substeps(plan, usize::MAX).substeps, 1 << 20);
    for substeps in [0, (1 << 20) + 1, usize::MAX] {
        let refused = scene.forces(Plan { substeps, ..plan });
        let named =
            matches!(&refused, Err(FidelityError::Parameter(e)) if e.name == "plan.substeps");
        assert!(named, "{refused:?}");
    }
}

#[test]
fn the_lumped_bristle_answers_an_oscillation_as_the_other_does() {
    use bristle::rheology::{
        GeneralisedMaxwell, GeneralisedMaxwellParameters, MaxwellArm, Rheology,
    };
    let curve = Stribeck::new(paper::STICK_SLIP_CURVE).unwrap();
    let same = |a: f64, b: f64| assert!((a - b).abs() <= 1e-14 * b, "{a} {b}");
    for (omega, damping) in [(1e-3, 100.0), (10.0, 2e3), (200.0, 100.0), (1e5, 3.0)] {
        let (k0, k1) = (1e4, 2e4);
        let zener = Zener::new(ZenerParameters {
            static_stiffness: k0,
            relaxing_stiffness: k1,
            series_damping: damping,
        });
        let zener = FrBd::new(curve, zener.unwrap());
        let lumped = Reducible::lumped(&zener, omega).unwrap();
        // x = ω c/k₁: G' = k₀ + k₁ x²/(1 + x²), G''/ω = c/(1 + x²).
        let x = omega * damping / k1;
        let (storage, loss) = (k0 + k1 * x * x / (1.0 + x * x), damping / (1.0 + x * x));
        same(lumped.rheology().storage_stiffness(), storage);
        let (one, other) =
            (lumped.rheology().complex_modulus(omega), zener.rheology().complex_modulus(omega));
        same(one.storage, other.storage);
        same(one.loss, other.loss);
        same(one.loss, omega * loss);
        assert_eq!(lumped.curve(), &curve);
        assert!(!zener.is_lumped() && lumped.is_lumped());
    }
    // Two springs beside each other make one, with a dashpot of their own.
    let arm = |stiffness| MaxwellArm::<f64> { stiffness, series_damping: None };
    let arms = [arm(3e3), arm(7e3)];
    let both: Result<GeneralisedMaxwell<f64, 2>, _> =
        GeneralisedMaxwell::new(GeneralisedMaxwellParameters { arms, micro_damping: 5.0 });
    let both = FrBd::new(curve, both.unwrap());
    let lumped = Reducible::lumped(&both, 7.0).unwrap();
    same(lumped.rheology().storage_stiffness(), 1e4);
    same(lumped.rheology().complex_modulus(7.0).loss, 35.0);
    assert!(!both.is_lumped());
}

#[test]
fn only_one_constant_spring_with_one_constant_dashpot_is_lumped_already() {
    use bristle::rheology::{
        KelvinVoigtParameters, Maxwell, MaxwellParameters, Rheology, VelocityDependent,
    };
    use bristle::{Bounds, Sliding};
    fn is_lumped<R: Rheology<f64>>(bristle: R) -> bool {
        FrBd::new(Stribeck::new(paper::STICK_SLIP_CURVE).unwrap(), bristle).is_lumped()
    }
    // Twice as much at rest as at full speed.
    let law = |most: f64| {
        VelocityDependent::new(
            move |sliding: Sliding<f64>| {
                let t = sliding.velocity().tanh();
                (most * (1.0 - 0.5 * t * t), -most * t * (1.0 - t * t))
            },
            Bounds { min: 0.5 * most, max: most },
        )
    };
    let (micro_stiffness, micro_damping) = (1e4, 64.5);
    let constant = KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness, micro_damping });
    assert!(is_lumped(constant.unwrap()));
    let bristle = KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness,
        micro_damping: law(micro_damping),
    });
    assert!(!is_lumped(bristle.unwrap()));
    let bristle = KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness: law(micro_stiffness),
        micro_damping,
    });
    assert!(!is_lumped(bristle.unwrap()));
    let fluid = Maxwell::new(MaxwellParameters { micro_stiffness, series_damping: 100.0 });
    assert!(!is_lumped(fluid.unwrap()));
}

#[test]
fn the_pilot_counts_every_look_at_the_curve() {
    use bristle::Bounds;
    use bristle::curve::FunctionCurve;
    use std::{cell::Cell, rc::Rc};
    // Lag, pre-sliding far below and about breakaway, reversals, and a creep.
    for (mean, amplitude, frequency, share, answers) in [
        (0.0055, 0.005, 25.0, 0.01, 1000),
        (0.0, 0.01, 1.0, 0.01, 1000),
        (0.0, 1e-4, 1.0, 0.01, 1000),
        (0.0, 0.1, 1.0, 0.002, 3000),
        (0.003, 0.02, 10.0, 0.005, 1000),
    ] {
        let looks = Rc::new(Cell::new(0_u32));
        let counter = looks.clone();
        let curve = FunctionCurve::new(
            move |speed: f64| {
                counter.set(counter.get() + 1);
                let falling = 0.5 * (-1e4 * speed * speed).exp();
                (1.0 + falling + 0.04 * speed, 0.04 - 2e4 * speed * falling)
            },
            Bounds { min: 1.0, max: 2.0 },
        );
        let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE).unwrap();
        let velocity = SineParameters { mean, amplitude, frequency, phase: 0.0 };
        let scene = History::new(HistoryParameters {
            contact: FrBd::new(curve.unwrap(), bristle).under_load(1.0).unwrap(),
            velocity: Sine::new(velocity).unwrap(),
            interval: 0.01 / frequency,
            answers,
            period: Some(100),
            start: Start::Steady,
        })
        .unwrap();
        looks.set(0);
        let choice = scene.choose(Tolerance { norm: Norm::Greatest, share }).unwrap();
        let (counted, said) = (f64::from(looks.get()), choice.pilot_evaluations);
        println!("{mean} + {amplitude} sin, {frequency} Hz: {counted} looks, {said} said");
        // What is said is more by the steps of plans, which have a price without a look at the curve.
        assert!(counted <= said, "{counted} looks, {said} said");
    }
}

#[test]
fn a_plan_of_another_scene_is_refused_by_its_name() {
    let scene = scene(0.1, 0.05, 1.0);
    let plan = Plan { rung: Rung::Patch, integrator: Integrator::Gauss, ..scene.plans()[0] };
    let refused = scene.forces(plan).unwrap_err().to_string();
    assert_eq!(refused, "this scene has no plan of patch by Gauss points");
}
