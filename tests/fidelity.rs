//! The fidelity ladder: what it chooses is good enough, and not much dearer than what would have done.

use bristle::exponential::Exponential;
use bristle::fidelity::*;
use bristle::signal::{Signal, Sine, SineParameters};
use bristle::{
    Bristle, Contact, FrBd, ImplicitBristle, ImplicitBristleParameters, KelvinVoigt, Stribeck,
    Zener, ZenerParameters, paper,
};

type Lumped = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;

/// Uniform numbers in [0, 1) by the 64-bit linear congruential generator of Knuth (MMIX), upper 53 bits.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
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
        Err(error) => {
            return Outcome { met: false, ratio: f64::NAN, line: format!("{what}: {error}") };
        }
    };
    if std::env::var("SHOW").is_ok() {
        println!("{choice}");
    }
    let error = norm(tolerance.norm, &scene.forces(choice.plan).unwrap(), truth);
    if std::env::var("SHOW").is_ok() && error > choice.allowed {
        let got = scene.forces(choice.plan).unwrap();
        let off = |i: &usize| (got[*i] - truth[*i]).abs();
        let worst = (0..got.len()).max_by(|a, b| off(a).total_cmp(&off(b))).unwrap();
        println!("worst at answer {} of {}: {:e} {:e}", worst + 1, got.len(), got[worst], truth[worst]);
    }
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
        .find(|plan| {
            norm(tolerance.norm, &scene.forces(**plan).unwrap(), truth) <= choice.allowed
        })
        .copied()
        .unwrap_or(choice.plan);
    let ratio = choice.plan.cost_rate / cheapest.cost_rate;
    let top = scene.plans().last().unwrap().rung;
    let evaluations = if top == Rung::FrBd { 2.0 } else { 3.0 };
    let budget = 2000.0_f64.max(0.05 * evaluations * answers);
    assert!(choice.pilot_evaluations <= budget, "{what}: pilot {}", choice.pilot_evaluations);
    Outcome {
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

fn exact(contact: &Contact<f64, Lumped>, drawn: &Drawn) -> Vec<f64> {
    let end = drawn.interval * drawn.answers as f64;
    let start = match drawn.start {
        Start::Undeflected => 0.0,
        Start::Steady => contact.stationary(drawn.velocity.value(0.0)),
    };
    let mut forces = Vec::new();
    // Every answer at the end of a step: between the ends of long ones the dense output has its own error.
    let drag = Exponential::<5>.fixed(drawn.interval / 16.0).unwrap();
    drag.sample(contact, &drawn.velocity, 0.0..end, start, drawn.answers + 1, |time, z| {
        forces.push(contact.force(drawn.velocity.value(time), z));
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
        let truth = exact(&contact, &drawn);
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

fn verdict(outcomes: &[Outcome]) {
    let wrong: Vec<_> = outcomes.iter().filter(|o| !o.met).map(|o| &o.line).collect();
    let dear: Vec<_> = outcomes.iter().filter(|o| !(o.ratio <= 2.0)).map(|o| &o.line).collect();
    for outcome in outcomes {
        println!("{}{}", if outcome.met { "" } else { "WRONG " }, outcome.line);
    }
    println!("{} scenes, {} wrong, {} dear", outcomes.len(), wrong.len(), dear.len());
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(dear.len() * 10 <= outcomes.len(), "{dear:#?}");
}

/// Deflections far finer than any plan would take: the model's own steps at a sixteenth of an interval, and half of those.
fn converged<M: Reducible<f64>, V: Signal<f64>>(scene: &History<f64, M, V>) -> Vec<f64> {
    let plan = *scene.plans().last().unwrap();
    scene.forces(scene.with_substeps(plan, 256)).unwrap()
}

/// The same for a bristle of two springs and for the unapproximated one, at the top of their ladders.
fn other_tops(seed: u64, scenes: usize) -> Vec<Outcome> {
    let mut dice = Draw(seed);
    let mut outcomes = Vec::new();
    for index in 0..scenes {
        let mut drawn = draw(&mut dice);
        drawn.answers = drawn.answers.min(400);
        drawn.tolerance.share = dice.logarithmic(5e-3, 0.2);
        let curve = Stribeck::new(paper::STICK_SLIP_CURVE).unwrap();
        let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE).unwrap();
        let zener = Zener::new(ZenerParameters {
            static_stiffness: 1e4,
            relaxing_stiffness: 2e4,
            series_damping: dice.logarithmic(10.0, 1e4),
        })
        .unwrap();
        if index % 2 == 0 {
            let contact = FrBd::new(curve, zener).under_load(2.0).unwrap();
            outcomes.push(other(contact, &drawn, &format!("{index:3} Zener {}", drawn.what)));
        } else {
            let implicit = ImplicitBristle::new(ImplicitBristleParameters {
                curve,
                rheology: bristle,
                fold_rule: None,
            });
            let contact = implicit.unwrap().under_load(2.0).unwrap();
            outcomes.push(other(contact, &drawn, &format!("{index:3} implicit {}", drawn.what)));
        }
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
fn tuning() {
    let seed = std::env::var("SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(1);
    verdict(&study(seed, 60));
}

#[test]
fn tops() {
    let seed = std::env::var("SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(1);
    verdict(&other_tops(seed, 24));
}
