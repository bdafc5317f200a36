//! The fidelity ladder of mechanisms: what it chooses is good enough, and not much dearer than what would have done.

#![cfg(feature = "alloc")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use bristle::fidelity::*;
use bristle::ode::{Output, Rodas5P, Solver, System, Tangent, TolerancesParameters, Tolerances};
use bristle::signal::{Polyline, Signal, Sine, SineParameters, Vertex};
use bristle::stability::Mechanism;
use bristle::{Branch, Bristle, Contact, FrBd, KelvinVoigt, Stribeck, paper};
use nalgebra::{Matrix3, Vector3};

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

/// The stick-slip set and the valve's packing.
fn sets() -> [Lumped; 2] {
    [
        (paper::STICK_SLIP_CURVE, paper::STICK_SLIP_BRISTLE),
        (paper::VALVE_CURVE, paper::VALVE_BRISTLE),
    ]
    .map(|(curve, bristle)| {
        FrBd::new(Stribeck::new(curve).unwrap(), KelvinVoigt::new(bristle).unwrap())
    })
}

/// The equations once more, for the truth.
struct Truth<'a, M> {
    contact: &'a Contact<f64, M>,
    mechanism: Mechanism<f64>,
    drive: Polyline<f64, 2>,
    force: Sine<f64>,
}

impl<M: Bristle<f64, Deflection = f64>> System<f64, 3> for Truth<'_, M> {
    fn rate(&self, time: f64, s: &Vector3<f64>, [branch]: [Branch; 1]) -> Vector3<f64> {
        self.tangent(time, s, [branch]).unwrap().rate
    }

    fn sliding_velocities(&self, _time: f64, s: &Vector3<f64>) -> [f64; 1] {
        [s[1]]
    }

    fn tangent(&self, time: f64, s: &Vector3<f64>, [b]: [Branch; 1]) -> Option<Tangent<f64, 3>> {
        let Mechanism { mass: m, spring_stiffness: k, viscous_damping: d } = self.mechanism;
        let friction = self.contact.linearised(b.of(s[1]), s[2]);
        let (y, y_rate) = self.drive.value_and_rate(time);
        let (f, f_rate) = self.force.value_and_rate(time);
        let net = f + k * (y - s[0]) - d * s[1] - friction.force;
        #[rustfmt::skip]
        let by_state = Matrix3::new(
            0.0, 1.0, 0.0,
            -k / m, -(d + friction.force_by_velocity) / m, -friction.force_by_deflection / m,
            0.0, friction.rate_by_velocity, friction.rate_by_deflection,
        );
        Some(Tangent {
            rate: Vector3::new(s[1], net / m, friction.rate),
            by_state,
            by_time: Vector3::new(0.0, (f_rate + k * y_rate) / m, 0.0),
        })
    }
}

/// A scene drawn by chance.
struct Drawn {
    parameters: MotionParameters<f64, Lumped, Polyline<f64, 2>, Sine<f64>>,
    tolerance: Tolerance,
    what: String,
}

fn draw(dice: &mut Draw, set: usize, kind: usize) -> Drawn {
    let contact = sets()[set].under_load(1.0).unwrap();
    let breakaway = [1.5, 59.86][set];
    let stiffness = contact.model().storage_stiffness();
    let deflection = breakaway / stiffness;
    let mass = dice.logarithmic(0.01, 100.0);
    let damping = dice.one_of(&[0.0, 0.0, 1.0]) * dice.logarithmic(1e-3, 1.0) * mass;
    let spring = dice.logarithmic(1e-4, 0.1) * stiffness;
    let speed = dice.logarithmic(1e-4, 1.0);
    let load = breakaway * dice.logarithmic(0.03, 10.0);
    let frequency = dice.logarithmic(0.01, 1000.0);
    let per_period = dice.one_of(&[36, 50, 100, 200]);
    let periods = dice.logarithmic(1.0, 60.0);
    let quantity = dice.one_of(&[Quantity::Position, Quantity::Velocity, Quantity::Force]);
    let share = dice.logarithmic(1e-3, 1e-1);
    let norm = dice.one_of(&[Norm::Greatest, Norm::RootMeanSquare]);
    let bias = dice.one_of(&[0.0, 0.0, 0.2, 0.6]);
    let level = |_: f64| {
        Polyline::new([Vertex { time: 0.0, value: 0.0 }, Vertex { time: 1.0, value: 0.0 }]).unwrap()
    };
    let (spring_stiffness, drive, amplitude, frequency, answers, interval, period, position, velocity) =
        if kind == 0 {
            // A base that moves steadily: so many times the time to the first breakaway.
            let loading = breakaway / (spring * speed) + (spring / mass).sqrt().recip();
            let answers = (dice.logarithmic(60.0, 1500.0)) as usize;
            let end = loading * dice.logarithmic(0.3, 12.0);
            let drive = Polyline::new([
                Vertex { time: 0.0, value: 0.0 },
                Vertex { time: 2.0 * end, value: 2.0 * end * speed },
            ]);
            let stretch = breakaway / spring;
            let swing = stretch * (spring / mass).sqrt();
            let interval = end / answers as f64;
            (spring, drive.unwrap(), 0.0, 1.0, answers, interval, None, stretch, swing.max(speed))
        } else {
            let spring = if kind == 1 { 0.0 } else { spring };
            let answers = ((periods * per_period as f64) as usize).max(16);
            let angular = std::f64::consts::TAU * frequency;
            let far = load / (mass * angular * angular);
            let position = deflection.max(far.min(load / spring));
            let period = (periods > 3.0).then_some(per_period);
            let interval = 1.0 / (frequency * per_period as f64);
            (spring, level(0.0), load, frequency, answers, interval, period, position, position * angular)
        };
    let scale = match quantity {
        Quantity::Force => breakaway,
        Quantity::Position => position,
        _ => velocity,
    };
    let mean = if kind == 0 { 0.0 } else { bias * breakaway };
    let force = SineParameters { mean, amplitude, frequency, phase: 0.0 };
    Drawn {
        parameters: MotionParameters {
            contact,
            mechanism: Mechanism { mass, spring_stiffness, viscous_damping: damping },
            drive,
            force: Sine::new(force).unwrap(),
            position: 0.0,
            velocity: 0.0,
            start: Start::Undeflected,
            interval,
            answers,
            period,
            quantity,
            scale,
        },
        tolerance: Tolerance { norm, share },
        what: format!(
            "set {set} kind {kind} m {mass:.2e} k {spring_stiffness:.2e} {} of breakaway {:.2e} at {frequency:.2e} Hz, drive {speed:.2e}, {answers} answers of {interval:.2e} s, period {period:?}, {quantity} {norm:?} {share:.1e}",
            bias, load / breakaway
        ),
    }
}

fn exact<M: Bristle<f64, Deflection = f64>>(
    parameters: &MotionParameters<f64, M, Polyline<f64, 2>, Sine<f64>>,
) -> Vec<f64> {
    let MotionParameters { contact, mechanism, drive, force, interval, answers, quantity, .. } =
        parameters;
    let truth = Truth { contact, mechanism: *mechanism, drive: *drive, force: *force };
    let deflection = contact.limits(0.0).deflection.unwrap();
    let load = contact.limits(0.0).coefficient.unwrap();
    let speed = (load * deflection / mechanism.mass).sqrt();
    // Absolute tolerances of a millionth of a millionth of pre-sliding.
    let tolerances = Tolerances::new(TolerancesParameters {
        relative: Vector3::repeat(1e-10),
        absolute: Vector3::new(deflection, speed, deflection) * 1e-10,
    });
    let solver = Solver::adaptive(Rodas5P, tolerances.unwrap());
    // Answers at ends of steps, for between them the curve has an error of its own: a sixteenth suffices.
    let times: Vec<f64> = (1..=*answers).map(|i| interval * i as f64).collect();
    let solver = solver.with_largest_step(*interval).unwrap();
    let span = 0.0..interval * *answers as f64;
    let run = solver.solve(&truth, span, Vector3::zeros(), Output::Times(&times)).unwrap();
    run.states()
        .iter()
        .map(|s| match quantity {
            Quantity::Position => s[0],
            Quantity::Velocity => s[1],
            _ => contact.force(s[1], s[2]),
        })
        .collect()
}

fn norm(norm: Norm, a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let off = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    match norm {
        Norm::Greatest => off.fold(0.0, f64::max),
        Norm::RootMeanSquare => (off.map(|e| e * e).sum::<f64>() / a.len() as f64).sqrt(),
    }
}

/// What a scene came to.
struct Outcome {
    refused: bool,
    met: bool,
    ratio: f64,
    line: String,
}

fn judge(drawn: Drawn) -> Outcome {
    let Drawn { parameters, tolerance, what } = drawn;
    let truth = exact(&parameters);
    let scene = Motion::new(parameters).unwrap();
    let choice = match scene.choose(tolerance) {
        Ok(choice) => choice,
        Err(
            error @ (FidelityError::PilotTooShort { .. } | FidelityError::OutOfReach { .. }),
        ) => {
            let line = format!("{what}: {error}");
            return Outcome { refused: true, met: true, ratio: 1.0, line };
        }
        Err(error) => panic!("{what}: {error}"),
    };
    let off = |plan: Plan| {
        let carried = scene.carry_out(plan).unwrap();
        (norm(tolerance.norm, &carried.answers, &truth), carried.cost)
    };
    let (error, cost) = off(choice.plan);
    assert!(
        choice.pilot_evaluations <= choice.pilot_budget * 1.1,
        "{what}: pilot {} of {}",
        choice.pilot_evaluations,
        choice.pilot_budget
    );
    if choice.verdict == Verdict::Proved {
        assert!(error <= choice.error, "{what}: {error:e} above the bound {:e}", choice.error);
    }
    // The cheapest that would have done.
    let (mut least, mut best) = (cost, choice.plan);
    for plan in scene.plans() {
        if plan.cost_rate.is_nan() {
            let (error, cost) = off(plan);
            if error <= choice.allowed && cost < least {
                (least, best) = (cost, plan);
            }
            continue;
        }
        for doubling in 0..12 {
            let plan = Plan { substeps: 1 << doubling, ..plan };
            // Never sliding, the static curve costs less than it says, at best half.
            if plan.cost_rate * plan.substeps as f64 * scene_time(&scene, &choice) > 2.0 * least {
                break;
            }
            let (error, cost) = off(plan);
            if error <= choice.allowed {
                if cost < least {
                    (least, best) = (cost, plan);
                }
                break;
            }
        }
    }
    let ratio = cost / least;
    Outcome {
        refused: false,
        met: error <= choice.allowed,
        ratio,
        line: format!(
            "{what}\n      {} {} x{} {}: error {:.3} of allowed (said {:.3}), cost {cost:.0}, {ratio:.2} of {} {} x{}, pilot {:.0} of {:.0}",
            choice.plan.rung,
            choice.plan.integrator,
            choice.plan.substeps,
            choice.verdict,
            error / choice.allowed,
            choice.error / choice.allowed,
            best.rung,
            best.integrator,
            best.substeps,
            choice.pilot_evaluations,
            choice.pilot_budget,
        ),
    }
}

/// Length of a scene [s].
fn scene_time(
    scene: &Motion<f64, Lumped, Polyline<f64, 2>, Sine<f64>>,
    choice: &Choice,
) -> f64 {
    let interval = choice.plan.step * choice.plan.substeps as f64;
    interval * scene.answers() as f64
}

fn study(seed: u64, scenes: usize) -> Vec<Outcome> {
    let mut dice = Draw(seed);
    let mut outcomes = Vec::new();
    for index in 0..scenes {
        let drawn = draw(&mut dice, index % 2, (index / 2) % 3);
        let what = format!("{index:3} {}", drawn.what);
        outcomes.push(judge(Drawn { what, ..drawn }));
        if std::env::var("SEED").is_ok() {
            let o = outcomes.last().unwrap();
            println!("{}{}{}", if o.met { "" } else { "WRONG " }, if o.ratio > 2.0 { "DEAR " } else { "" }, o.line);
        }
    }
    outcomes
}

fn verdict(outcomes: &[Outcome]) {
    let wrong: Vec<_> = outcomes.iter().filter(|o| !o.met).map(|o| &o.line).collect();
    let dear: Vec<_> = outcomes.iter().filter(|o| !(o.ratio <= 2.0)).map(|o| &o.line).collect();
    let refused = outcomes.iter().filter(|o| o.refused).count();
    let all = outcomes.len();
    println!("{all} scenes, {} wrong, {} dear, {refused} refused", wrong.len(), dear.len());
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!((dear.len() + refused) * 10 <= all, "{dear:#?}");
}

#[test]
#[ignore = "a study: SEED chooses the scenes"]
fn tuning() {
    let seed = std::env::var("SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(1);
    verdict(&study(seed, 60));
}

// SCRATCH-BEGIN
#[test]
#[ignore]
fn weights() {
    use std::hint::black_box;
    use std::time::Instant;
    let contact = sets()[0].under_load(1.0).unwrap();
    let mechanism = Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.1 };
    let drive = Polyline::new([Vertex { time: 0.0, value: 0.0 }, Vertex { time: 1000.0, value: 100.0 }]).unwrap();
    let force = Sine::new(SineParameters { mean: 0.0, amplitude: 3.0, frequency: 1.0, phase: 0.0 }).unwrap();
    let parameters = MotionParameters {
        contact, mechanism, drive, force, position: 0.0, velocity: 0.0, start: Start::Undeflected,
        interval: 1e-3, answers: 20000, period: None, quantity: Quantity::Position, scale: 1.0,
    };
    let scene = Motion::new(parameters).unwrap();
    let mut best = std::collections::BTreeMap::<String, f64>::new();
    for _ in 0..30 {
        let mut note = |name: &str, value: f64| {
            let b = best.entry(name.into()).or_insert(f64::INFINITY);
            *b = b.min(value);
        };
        let begin = Instant::now();
        let mut s = 0.0;
        for i in 0..100_000 {
            let v = black_box(1e-4 * f64::from(i % 1000) - 0.02);
            let r = contact.response(v, s * 1e-9);
            s += r.rate + r.force;
        }
        black_box(s);
        note("rhs", begin.elapsed().as_secs_f64() * 1e9 / 1e5);
        for plan in scene.plans().iter().filter(|p| !p.cost_rate.is_nan()) {
            let begin = Instant::now();
            let run = scene.carry_out(*plan).unwrap();
            black_box(&run);
            note(&format!("{} {}", plan.rung, plan.integrator), begin.elapsed().as_secs_f64() * 1e9 / 2e4);
        }
        let truth = Truth { contact: &contact, mechanism, drive, force };
        for (name, digits) in [("auto 3", 1e-3), ("auto 5", 1e-5), ("auto 8", 1e-8)] {
            let solver = Solver::automatic(digits, Vector3::new(0.75, 1.0, 1.5e-4)).unwrap();
            let begin = Instant::now();
            let run = solver.solve(&truth, 0.0..20.0, Vector3::zeros(), Output::Uniform(2)).unwrap();
            let t = begin.elapsed().as_secs_f64() * 1e9;
            note(&format!("{name} per evaluation {} jac {} steps {}", run.statistics().evaluations, run.statistics().jacobians, run.statistics().steps), t / run.statistics().evaluations as f64);
        }
        let solver = Solver::adaptive(Rodas5P, Tolerances::scaled(1e-6, Vector3::new(0.75, 1.0, 1.5e-4)).unwrap());
        let begin = Instant::now();
        let run = solver.solve(&truth, 0.0..20.0, Vector3::zeros(), Output::Uniform(2)).unwrap();
        let t = begin.elapsed().as_secs_f64() * 1e9;
        note(&format!("rodas5p {}", run.statistics()), t / run.statistics().evaluations as f64);
        let solver = Solver::adaptive(bristle::ode::DormandPrince8, Tolerances::scaled(1e-6, Vector3::new(0.75, 1.0, 1.5e-4)).unwrap());
        let begin = Instant::now();
        let run = solver.solve(&truth, 0.0..20.0, Vector3::zeros(), Output::Uniform(2)).unwrap();
        let t = begin.elapsed().as_secs_f64() * 1e9;
        note(&format!("dp8 {}", run.statistics()), t / run.statistics().evaluations as f64);
    }
    for (name, value) in best {
        println!("{name}: {value:.1} ns");
    }
}
// SCRATCH-END
