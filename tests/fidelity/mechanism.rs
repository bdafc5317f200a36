//! The fidelity ladder of mechanisms: what it chooses is good enough, and not much dearer than what would have done.

#![cfg(feature = "alloc")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use bristle::Mechanism;
use bristle::curve::Stribeck;
use bristle::fidelity::*;
use bristle::ode::{
    Linearisation, Output, Rodas5P, Solver, System, Tolerances, TolerancesParameters,
};
use bristle::rheology::KelvinVoigt;
use bristle::signal::{Polyline, Signal, Sine, SineParameters, Vertex};
use bristle::{Affine, Branch, Bristle, Contact, FrBd, Law, Limits, LuGre, Sliding, paper};
use nalgebra::{Matrix3, Vector3};

type Lumped = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;
type Parameters<M> = MechanismHistoryParameters<f64, M, Polyline<f64, 2>, Sine<f64>>;

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
        self.linearised(time, s, [branch]).unwrap().rate
    }

    fn sliding_velocities(&self, _time: f64, s: &Vector3<f64>) -> [f64; 1] {
        [s[1]]
    }

    fn linearised(
        &self,
        time: f64,
        s: &Vector3<f64>,
        [b]: [Branch; 1],
    ) -> Option<Linearisation<f64, 3>> {
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
        Some(Linearisation {
            rate: Vector3::new(s[1], net / m, friction.rate),
            by_state,
            by_time: Vector3::new(0.0, (f_rate + k * y_rate) / m, 0.0),
        })
    }
}

/// A scene drawn by chance.
struct Drawn {
    parameters: Parameters<Lumped>,
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
    let level = [0.0, 1.0].map(|time| Vertex { time, value: 0.0 });
    let level = Polyline::new(level).unwrap();
    let (
        spring_stiffness,
        drive,
        amplitude,
        frequency,
        answers,
        interval,
        period,
        position,
        velocity,
    ) = if kind == 0 {
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
        (spring, level, load, frequency, answers, interval, period, position, position * angular)
    };
    let scale = match quantity {
        Quantity::Force => breakaway,
        Quantity::Position => position,
        _ => velocity,
    };
    let mean = if kind == 0 { 0.0 } else { bias * breakaway };
    let force = SineParameters { mean, amplitude, frequency, phase: 0.0 };
    Drawn {
        parameters: MechanismHistoryParameters {
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
            bias,
            load / breakaway
        ),
    }
}

fn exact<M: Bristle<f64, Deflection = f64>>(parameters: &Parameters<M>) -> Vec<f64> {
    exact_within(parameters, 1e-10)
}

fn exact_within<M: Bristle<f64, Deflection = f64>>(
    parameters: &Parameters<M>,
    relative: f64,
) -> Vec<f64> {
    let MechanismHistoryParameters {
        contact,
        mechanism,
        drive,
        force,
        interval,
        answers,
        quantity,
        ..
    } = parameters;
    let truth = Truth { contact, mechanism: *mechanism, drive: *drive, force: *force };
    let deflection = contact.limits(0.0).deflection.unwrap();
    let load = contact.model().storage_stiffness() * deflection * contact.normal_force();
    let speed = (load * deflection / mechanism.mass).sqrt();
    let tolerances = Tolerances::new(TolerancesParameters {
        relative: Vector3::repeat(relative),
        absolute: Vector3::new(deflection, speed, deflection) * relative,
    });
    let solver = Solver::adaptive(Rodas5P, tolerances.unwrap());
    // Between the ends of steps the curve has an error of its own: no step is longer than an interval.
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
    /// Roundings decide: two tight runs differ, and nothing but a refusal is right.
    unknown: bool,
    met: bool,
    ratio: f64,
    line: String,
}

fn judge(drawn: Drawn, budget: Option<f64>) -> Outcome {
    let Drawn { parameters, tolerance, what } = drawn;
    let (truth, other) = (exact_within(&parameters, 1e-11), exact_within(&parameters, 1e-10));
    let allowed = tolerance.share * parameters.scale;
    let unknown = norm(tolerance.norm, &truth, &other) > 0.05 * allowed;
    let scene = MechanismHistory::new(parameters).unwrap();
    let chosen = match budget {
        Some(most) => scene.choose_within(tolerance, most),
        None => scene.choose(tolerance),
    };
    let choice = match chosen {
        Ok(choice) => choice,
        Err(
            error @ (FidelityError::PilotTooShort { .. }
            | FidelityError::OutOfReach { .. }
            | FidelityError::Undetermined { .. }),
        ) => {
            let what = if unknown { format!("UNKNOWN {what}") } else { what };
            let line = format!("{what}: {error}");
            return Outcome { refused: true, unknown, met: true, ratio: 1.0, line };
        }
        Err(error) => panic!("{what}: {error}"),
    };
    if unknown {
        let line = format!("UNKNOWN {what}: {choice}");
        return Outcome { refused: false, unknown, met: false, ratio: 1.0, line };
    }
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
        unknown,
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
    scene: &MechanismHistory<f64, Lumped, Polyline<f64, 2>, Sine<f64>>,
    choice: &Choice,
) -> f64 {
    let interval = choice.plan.step * choice.plan.substeps as f64;
    interval * scene.answers() as f64
}

fn study(seed: u64, scenes: usize, budget: Option<f64>) -> Vec<Outcome> {
    let mut dice = Draw(seed);
    let mut outcomes = Vec::new();
    for index in 0..scenes {
        let drawn = draw(&mut dice, index % 2, (index / 2) % 3);
        let what = format!("{index:3} {}", drawn.what);
        outcomes.push(judge(Drawn { what, ..drawn }, budget));
        if std::env::var("SEED").is_ok() {
            let o = outcomes.last().unwrap();
            println!(
                "{}{}{}",
                if o.met { "" } else { "WRONG " },
                if o.ratio > 2.0 { "DEAR " } else { "" },
                o.line
            );
        }
    }
    outcomes
}

/// The figures of a study: no answer is wrong; how many are dear or refused. Where roundings decide a refusal is right.
fn verdict(outcomes: &[Outcome]) -> usize {
    let wrong: Vec<_> = outcomes.iter().filter(|o| !o.met).map(|o| &o.line).collect();
    let dear = outcomes.iter().filter(|o| !(o.ratio <= 2.0)).count();
    let refused = outcomes.iter().filter(|o| o.refused && !o.unknown).count();
    let unknown = outcomes.iter().filter(|o| o.unknown).count();
    println!(
        "{} scenes, {} wrong, {dear} dear, {refused} refused, {unknown} undetermined",
        outcomes.len(),
        wrong.len()
    );
    assert!(wrong.is_empty(), "{wrong:#?}");
    dear + refused
}

#[test]
#[ignore = "a study: SEED chooses the scenes, BUDGET what the pilot may cost"]
fn tuning() {
    let seed = std::env::var("SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(1);
    let budget = std::env::var("BUDGET").ok().and_then(|s| s.parse().ok());
    verdict(&study(seed, 60, budget));
}

/// Where the last seeds missed, before the thresholds were what they are.
#[test]
#[ignore = "minutes, in release: a million evaluations"]
fn a_force_between_the_steps_of_a_slow_scene_is_not_missed() {
    let outcomes = study(2602, 36, None);
    assert!(outcomes[35].met, "{}", outcomes[35].line);
}

#[test]
#[ignore = "minutes, in release"]
fn of_a_hundred_and_twenty_scenes_drawn_by_chance_none_is_answered_wrongly_and_half_are_cheap() {
    // Seeds that were drawn after the last change of a threshold; others served to find those.
    let mut outcomes = study(7707, 60, None);
    outcomes.extend(study(7708, 60, None));
    let missed = verdict(&outcomes);
    assert!(missed <= 66, "{missed} of {}", outcomes.len());
}

/// The stick-slip rig of the paper's section V-A: base at `speed`, so many answers in so many seconds.
fn rig(speed: f64, answers: usize, end: f64, quantity: Quantity, scale: f64) -> Parameters<Lumped> {
    let drive =
        [(0.0, 0.0), (2.0 * end, 2.0 * end * speed)].map(|(time, value)| Vertex { time, value });
    let force = SineParameters { mean: 0.0, amplitude: 0.0, frequency: 1.0, phase: 0.0 };
    MechanismHistoryParameters {
        contact: sets()[0].under_load(1.0).unwrap(),
        mechanism: Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.0 },
        drive: Polyline::new(drive).unwrap(),
        force: Sine::new(force).unwrap(),
        position: 0.0,
        velocity: 0.0,
        start: Start::Undeflected,
        interval: end / answers as f64,
        answers,
        period: None,
        quantity,
        scale,
    }
}

fn within(share: f64) -> Tolerance {
    Tolerance { norm: Norm::Greatest, share }
}

#[test]
fn stick_slip_is_answered_within_tolerance_in_each_quantity() {
    // The stretch at breakaway is 0.74 m, a slip some 1 m/s fast.
    for (quantity, scale) in
        [(Quantity::Position, 0.75), (Quantity::Velocity, 1.0), (Quantity::Force, 1.5)]
    {
        for share in [0.1, 0.01] {
            let parameters = rig(0.1, 200, 20.0, quantity, scale);
            let truth = exact(&parameters);
            let scene = MechanismHistory::new(parameters).unwrap();
            let choice = scene.choose_within(within(share), 5e4).unwrap();
            let carried = scene.carry_out(choice.plan).unwrap();
            let error = norm(Norm::Greatest, &carried.answers, &truth);
            assert!(error <= choice.allowed, "{error:e}\n{choice}");
            assert!(choice.to_string().starts_with(&format!("{quantity} within")), "{choice}");
            assert!(choice.to_string().contains(quantity.unit()));
        }
    }
}

#[test]
fn what_never_comes_near_breakaway_rests_by_a_bound() {
    // A push of 1 mN for a tenth of a second moves 1 kg by no more than 5 µm, friction or not.
    let mut parameters = rig(0.0, 100, 0.1, Quantity::Position, 1e-3);
    let force = SineParameters { mean: 1e-3, amplitude: 0.0, frequency: 1.0, phase: 0.0 };
    parameters.force = Sine::new(force).unwrap();
    let truth = exact(&parameters);
    let choice = MechanismHistory::new(parameters).unwrap().choose(within(0.01)).unwrap();
    assert_eq!((choice.plan.rung, choice.verdict), (Rung::StaticCurve, Verdict::Proved));
    assert_eq!(choice.pilot_evaluations, 0.0);
    // ½ f t²/m, by the sum of ends of intervals a hundredth more.
    assert!((choice.error / 5e-6 - 1.0).abs() < 0.02, "{:e}", choice.error);
    assert!(truth.iter().all(|x| x.abs() <= choice.error));
}

#[test]
fn the_static_rung_rests_truly_and_slides_by_the_closed_form() {
    // Coulomb friction: 1 kg thrown at 1 m/s under 2 N stops after v/a = 0.5 s and v²/(2a) = 0.25 m, and stays.
    let curve = bristle::curve::Coulomb::new(bristle::curve::CoulombParameters {
        dynamic_coefficient: 2.0,
        viscous_friction: 0.0,
    });
    let model = FrBd::new(curve.unwrap(), KelvinVoigt::new(paper::STICK_SLIP_BRISTLE).unwrap());
    let scene = |quantity| {
        let base = rig(0.0, 100, 1.0, quantity, 1.0);
        MechanismHistory::new(MechanismHistoryParameters {
            contact: model.under_load(1.0).unwrap(),
            mechanism: Mechanism { spring_stiffness: 0.0, ..base.mechanism },
            drive: base.drive,
            force: base.force,
            position: 0.0,
            velocity: 1.0,
            start: Start::Steady,
            interval: base.interval,
            answers: base.answers,
            period: None,
            quantity,
            scale: 1.0,
        })
        .unwrap()
    };
    let carried = |quantity| {
        let scene = scene(quantity);
        scene.carry_out(scene.plans()[0]).unwrap().answers
    };
    let (positions, velocities) = (carried(Quantity::Position), carried(Quantity::Velocity));
    for (index, (x, v)) in positions.iter().zip(&velocities).enumerate() {
        let t = (0.01 * (index + 1) as f64).min(0.5);
        // The step in which it stops is 10 ms long, at a speed of no more than 20 mm/s: half of that at most.
        assert!((x - (t - t * t)).abs() < 1e-4, "{t} {x}");
        assert!((v - (1.0 - 2.0 * t)).abs() < 1e-12, "{t} {v}");
    }
    // Exactly at rest, not nearly; and nothing pushes.
    assert_eq!(velocities[99], 0.0);
    assert_eq!(carried(Quantity::Force)[99], 0.0);
}

#[test]
fn numbers_out_of_range_are_refused_by_name() {
    let refused = |change: &dyn Fn(&mut Parameters<Lumped>), says: &str| {
        let mut parameters = rig(0.1, 100, 10.0, Quantity::Position, 1.0);
        change(&mut parameters);
        let error = MechanismHistory::new(parameters).unwrap_err().to_string();
        assert!(error.starts_with(says), "{error}");
    };
    refused(&|p| p.mechanism.mass = 0.0, "mass is 0");
    refused(&|p| p.mechanism.mass = -1.0, "mass is -1");
    refused(&|p| p.mechanism.mass = f64::NAN, "mass is NaN");
    refused(&|p| p.mechanism.spring_stiffness = -2.0, "spring_stiffness is -2");
    refused(&|p| p.mechanism.viscous_damping = -0.1, "viscous_damping is -0.1");
    refused(&|p| p.interval = f64::INFINITY, "interval is inf");
    refused(&|p| p.scale = 0.0, "scale is 0");
    refused(&|p| p.velocity = f64::NAN, "velocity is NaN");
    refused(&|p| p.answers = 7, "answers is 7");
    refused(&|p| p.period = Some(3), "period is 3");
    let scene = MechanismHistory::new(rig(0.1, 100, 10.0, Quantity::Position, 1.0)).unwrap();
    assert!(scene.choose(within(0.0)).unwrap_err().to_string().starts_with("share is 0"));
    assert!(scene.choose(within(f64::NAN)).unwrap_err().to_string().starts_with("share is NaN"));
    let plan = Plan { integrator: Integrator::Hold, ..scene.plans()[0] };
    assert!(scene.carry_out(plan).is_err());
}

#[test]
fn a_tolerance_below_all_roundings_is_refused_with_numbers() {
    let scene = MechanismHistory::new(rig(0.1, 100, 2.0, Quantity::Position, 1.0)).unwrap();
    let error = scene.choose_within(within(1e-19), 1e6).unwrap_err();
    let named = matches!(
        error,
        FidelityError::OutOfReach { quantity: Quantity::Position, .. }
            | FidelityError::PilotTooShort { .. }
    );
    assert!(named && error.to_string().contains("e-19 m"), "{error}");
}

/// A model that pushes: FrBD with its force turned round.
#[derive(Debug, Clone)]
struct Motor(Lumped);

impl Bristle<f64> for Motor {
    type Deflection = f64;

    fn affine(&self, sliding: Sliding<f64>, z: f64) -> Affine<f64> {
        let affine = self.0.affine(sliding, z);
        Affine { stiffness: -affine.stiffness, damping: -affine.damping, ..affine }
    }

    fn affine_and_slopes(&self, sliding: Sliding<f64>, z: f64) -> (Affine<f64>, Affine<f64>) {
        let (_, slopes) = self.0.affine_and_slopes(sliding, z);
        let turned = Affine { stiffness: -slopes.stiffness, damping: -slopes.damping, ..slopes };
        (self.affine(sliding, z), turned)
    }

    fn stationary(&self, sliding: impl Into<Sliding<f64>>) -> f64 {
        self.0.stationary(sliding)
    }

    fn storage_stiffness(&self) -> f64 {
        self.0.storage_stiffness()
    }

    fn obeys(&self, _law: Law) -> bool {
        false
    }

    fn limits(&self, fastest: f64) -> Limits<f64> {
        self.0.limits(fastest)
    }
}

#[test]
fn a_friction_that_drives_its_mass_is_named_with_its_energy() {
    let base = rig(0.1, 100, 10.0, Quantity::Position, 1.0);
    let scene = MechanismHistory::new(MechanismHistoryParameters {
        contact: Motor(sets()[0]).under_load(1.0).unwrap(),
        mechanism: base.mechanism,
        drive: base.drive,
        force: base.force,
        position: 0.0,
        velocity: 0.01,
        start: Start::Undeflected,
        interval: base.interval,
        answers: base.answers,
        period: None,
        quantity: Quantity::Position,
        scale: 1.0,
    })
    .unwrap();
    let error = scene.choose(within(0.01)).unwrap_err();
    let FidelityError::GainsEnergy { energy, limit, .. } = error else { panic!("{error}") };
    assert!(energy > limit && error.to_string().contains("the friction drives it"));
}

#[test]
fn lugre_can_be_the_reference_too() {
    let base = rig(0.1, 150, 10.0, Quantity::Position, 0.75);
    let model = LuGre::classical(
        Stribeck::new(paper::STICK_SLIP_CURVE).unwrap(),
        KelvinVoigt::new(paper::STICK_SLIP_BRISTLE).unwrap(),
    );
    let parameters = MechanismHistoryParameters {
        contact: model.under_load(1.0).unwrap(),
        mechanism: base.mechanism,
        drive: base.drive,
        force: base.force,
        position: 0.0,
        velocity: 0.0,
        start: Start::Undeflected,
        interval: base.interval,
        answers: base.answers,
        period: None,
        quantity: Quantity::Position,
        scale: 0.75,
    };
    let truth = exact(&parameters);
    let scene = MechanismHistory::new(parameters).unwrap();
    let choice = scene.choose_within(within(0.01), 5e4).unwrap();
    let carried = scene.carry_out(choice.plan).unwrap();
    assert!(norm(Norm::Greatest, &carried.answers, &truth) <= choice.allowed, "{choice}");
}

/// A mass that is pulled so slowly that it waits on the falling part of its curve. Its steady sliding is unstable, σ = 8.668/s
/// by [`Contact::critical_speed`](bristle::Contact::critical_speed); it comes there at 22 s and slips at 24.37 s (multiple precision of 30 and of 40 digits, by
/// extrapolated midpoint steps of order 16 and 1 and 1.5 ms): so long because it starts exactly on its way. Roundings have grown as
/// large as the motion by then, and each tolerance has its own slip.
#[test]
fn a_slip_whose_time_roundings_decide_is_refused_with_the_growth_of_errors() {
    let base = rig(7.519_596e-4, 1476, 1476.0 * 1.893_790_26e-2, Quantity::Position, 0.0152);
    let parameters = Parameters {
        mechanism: Mechanism {
            mass: 1.581_093_576e-2,
            spring_stiffness: 98.600_011,
            viscous_damping: 0.0,
        },
        ..base
    };
    let (one, other) = (exact_within(&parameters, 1e-9), exact_within(&parameters, 1e-10));
    // No less than 4 mm of a slip of 15 mm.
    assert!(norm(Norm::Greatest, &one, &other) > 4e-3);
    let error =
        MechanismHistory::new(parameters).unwrap().choose_within(within(0.09), 1e5).unwrap_err();
    let FidelityError::Undetermined { factor } = error else { panic!("{error}") };
    assert!(factor > 1e12, "{factor:e}");
    assert!(error.to_string().contains("roundings decide"));
}

#[test]
fn twelve_short_scenes_drawn_by_chance_are_answered_within_tolerance_and_half_of_them_cheaply() {
    let mut dice = Draw(2602);
    let mut outcomes = Vec::new();
    for index in 0.. {
        let drawn = draw(&mut dice, index % 2, (index / 2) % 3);
        let p = &drawn.parameters;
        let swings = (p.contact.model().storage_stiffness() / p.mechanism.mass).sqrt()
            * p.interval
            * p.answers as f64;
        // Without optimisation the truth of a longer one takes seconds.
        if p.answers <= 250 && swings < 3e3 {
            outcomes.push(judge(drawn, None));
        }
        if outcomes.len() == 12 {
            break;
        }
    }
    let missed = verdict(&outcomes);
    assert!(missed <= 6, "{missed} of {}", outcomes.len());
}
