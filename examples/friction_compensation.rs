//! A linear axis follows a slow sine and then stands still, under a PID controller, with and
//! without friction compensation from its encoder.
//!
//! The axis is a carriage of 12 kg on a ball screw with figures from a typical datasheet: 30 N to
//! break away, 20 N running, 100 N s/m, elastic over 60 µm, an encoder of 0.5 µm and a motor of 250
//! N.
//!
//! Its friction is FrBD, and for comparison the implicit bristle, in passive steps of 50 µs, each
//! solved twice. The controller is held between its samples. The compensators do not know the true
//! parameters: theirs are 7 to 20 % off, with another Stribeck exponent.
//!
//! Coulomb compensation has the same controller and the same filtered velocity, and is the best of
//! a list of dead bands and smooth signs.
//!
//! Leaves `friction_compensation.csv` (the tables) and `friction_compensation.svg`.

use std::error::Error;
use std::f64::consts::TAU;
use std::process::ExitCode;

use bristle::companion::{Companion, PointMass, VelocityHistory};
use bristle::control::{
    FeedForwardCompensator, FeedForwardParameters, FeedbackCompensator, FeedbackParameters,
    FrictionObserver, Injection, MicroDamping, ObserverParameters, OutputParameters,
    VelocityFromPosition, VelocityFromPositionParameters,
};
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, FrBd, ImplicitBristle, LuGre, ParameterError};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Progress, Rule, Stroke, println};

/// The axis: mass [kg], encoder count [m], limit of the motor [N].
const MASS: f64 = 12.0;
const COUNT: f64 = 0.5e-6;
const MOTOR: f64 = 250.0;

/// Its friction. The normal force is 1, so that coefficients are forces in newtons.
const TRUE_CURVE: StribeckParameters<f64> = StribeckParameters {
    static_coefficient: 30.0,
    dynamic_coefficient: 20.0,
    stribeck_velocity: 0.005,
    stribeck_exponent: 2.0,
    viscous_friction: 100.0,
};
const TRUE_BRISTLE: KelvinVoigtParameters<f64> =
    KelvinVoigtParameters { micro_stiffness: 5e5, micro_damping: 2000.0 };

/// The friction that the compensators assume.
const CURVE: StribeckParameters<f64> = StribeckParameters {
    static_coefficient: 28.0,
    dynamic_coefficient: 21.5,
    stribeck_velocity: 0.006,
    stribeck_exponent: 1.0,
    viscous_friction: 90.0,
};
const BRISTLE: KelvinVoigtParameters<f64> =
    KelvinVoigtParameters { micro_stiffness: 4.2e5, micro_damping: 1600.0 };

/// The reference: a sine [m, Hz] for a number of periods, then rest at its top until the end [s].
const AMPLITUDE: f64 = 1e-3;
const FREQUENCY: f64 = 0.5;
const PERIODS: f64 = 1.25;
pub(crate) const END: f64 = 6.0;

/// Statistics of tracking begin after the first half period, those of rest after its first second
/// [s].
const SETTLED: f64 = 0.5 / FREQUENCY;
const AT_REST: f64 = PERIODS / FREQUENCY + 1.0;

/// Largest speed of the axis [m/s].
const FASTEST: f64 = 0.1;

/// Length of the plant's steps [s].
const FINE: f64 = 5e-5;

/// Time constant of the velocity's filter [s], for the controller and every compensator.
const FILTER: f64 = 2e-3;

/// Position, velocity and acceleration of the reference.
fn reference(time: f64) -> (f64, f64, f64) {
    let omega = TAU * FREQUENCY;
    let (sin, cos) = (omega * time.min(PERIODS / FREQUENCY)).sin_cos();
    let moving = if time < PERIODS / FREQUENCY { 1.0 } else { 0.0 };
    (AMPLITUDE * sin, AMPLITUDE * omega * cos * moving, -AMPLITUDE * omega * omega * sin * moving)
}

/// A PID controller: poles of the frictionless axis at the bandwidth [Hz], damped by 0.8, and one
/// at a fifth of it.
#[derive(Clone, Copy)]
struct Gains {
    proportional: f64,
    derivative: f64,
    integral: f64,
}

impl Gains {
    fn of(bandwidth: f64) -> Self {
        let omega = TAU * bandwidth;
        let (slow, damping) = (omega / 5.0, 0.8);
        // (s² + 2ζω s + ω²)(s + ω/5)
        Self {
            proportional: MASS * (omega * omega + 2.0 * damping * omega * slow),
            derivative: MASS * (2.0 * damping * omega + slow),
            integral: MASS * omega * omega * slow,
        }
    }
}

/// What stands for the sign of the velocity in Coulomb compensation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Sign {
    /// sgn v, and zero up to a speed [m/s].
    DeadBand(f64),
    /// tanh(v/v_t) with v_t [m/s].
    Smooth(f64),
}

impl Sign {
    fn of(self, velocity: f64) -> f64 {
        match self {
            Sign::DeadBand(width) if velocity.abs() > width => velocity.signum(),
            Sign::DeadBand(_) => 0.0,
            Sign::Smooth(width) => (velocity / width).tanh(),
        }
    }
}

/// The kind of compensation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Way {
    None,
    Coulomb(Sign),
    LuGre,
    FrBd,
    FeedForward,
    Observer,
}

/// One run: the way, the share that is compensated, the sample rate [Hz], the bandwidth of the
/// controller [Hz].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setting {
    pub(crate) way: Way,
    pub(crate) share: f64,
    pub(crate) rate: f64,
    pub(crate) bandwidth: f64,
    pub(crate) plant: Plant,
    /// How many times finer than [`FINE`] the plant's steps are.
    pub(crate) refinement: usize,
    /// Whether the compensator knows the true parameters.
    pub(crate) informed: bool,
}

impl Setting {
    pub(crate) fn of(way: Way) -> Self {
        Self {
            way,
            share: 1.0,
            rate: 1e3,
            bandwidth: 20.0,
            plant: Plant::FrBd,
            refinement: 1,
            informed: false,
        }
    }
}

/// The result of a run.
#[derive(Debug, Clone)]
pub(crate) struct Outcome {
    /// Tracking error, root of the mean square and greatest [m].
    pub(crate) rms: f64,
    pub(crate) greatest: f64,
    /// Actuator force, root of the mean square [N], and what it moves per second [N/s].
    pub(crate) effort: f64,
    pub(crate) restlessness: f64,
    /// At rest: sign changes of the error, from beyond two counts on one side to beyond two counts
    /// on the other, and its range [m].
    pub(crate) sign_changes: usize,
    pub(crate) range: f64,
    /// Time, position error, actuator force, at every sample.
    pub(crate) samples: Vec<(f64, f64, f64)>,
}

/// A compensator, ready to be asked once per sample.
type Ask = Box<dyn FnMut(&Sample) -> f64>;

struct Sample {
    position: f64,
    reference: f64,
    /// Mean velocity of the reference over the coming sample.
    reference_velocity: f64,
    velocity: f64,
}

fn compensator(setting: &Setting) -> Result<Ask, ParameterError> {
    let (curve, bristle) =
        if setting.informed { (TRUE_CURVE, TRUE_BRISTLE) } else { (CURVE, BRISTLE) };
    let model = FrBd::new(Stribeck::new(curve)?, KelvinVoigt::new(bristle)?);
    let lugre = LuGre::classical(Stribeck::new(curve)?, KelvinVoigt::new(bristle)?);
    let velocity = VelocityFromPositionParameters {
        sample_time: setting.rate.recip(),
        time_constant: FILTER,
        fastest: FASTEST,
        count: COUNT,
    };
    let output = OutputParameters { share: setting.share, largest_force: MOTOR };
    let damping = MicroDamping::Filtered;
    Ok(match setting.way {
        Way::None => Box::new(|_| 0.0),
        Way::Coulomb(sign) => {
            let StribeckParameters { dynamic_coefficient, viscous_friction, .. } = curve;
            let share = setting.share;
            Box::new(move |sample| {
                let friction = dynamic_coefficient + viscous_friction * sample.velocity.abs();
                let wanted = share * friction * sign.of(sample.velocity);
                wanted.clamp(-MOTOR, MOTOR)
            })
        }
        Way::LuGre => {
            let contact = lugre.under_load(1.0)?;
            let parameters = FeedbackParameters { contact, velocity, damping, output };
            let mut law = FeedbackCompensator::new(parameters)?;
            Box::new(move |sample| law.step(sample.position).force)
        }
        Way::FrBd => {
            let contact = model.under_load(1.0)?;
            let parameters = FeedbackParameters { contact, velocity, damping, output };
            let mut law = FeedbackCompensator::new(parameters)?;
            Box::new(move |sample| law.step(sample.position).force)
        }
        Way::FeedForward => {
            let mut law = FeedForwardCompensator::new(FeedForwardParameters {
                contact: model.under_load(1.0)?,
                sample_time: setting.rate.recip(),
                fastest: FASTEST,
                output,
            })?;
            Box::new(move |sample| law.step(sample.reference_velocity).force)
        }
        Way::Observer => {
            let gains = Gains::of(setting.bandwidth);
            let mut law = FrictionObserver::new(ObserverParameters {
                contact: model.under_load(1.0)?,
                mass: MASS,
                proportional_gain: gains.proportional,
                derivative_gain: gains.derivative,
                integral_gain: gains.integral,
                injection: Injection::Velocity {
                    gain: 0.05,
                    corner: 0.7 * gains.derivative / MASS,
                },
                velocity,
                output,
            })?;
            Box::new(move |sample| law.step(sample.position, sample.reference).force)
        }
    })
}

/// The friction of the axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Plant {
    Implicit,
    FrBd,
}

/// The axis under its controller.
pub(crate) fn run(setting: Setting) -> Result<Outcome, Box<dyn Error>> {
    let (curve, bristle) = (Stribeck::new(TRUE_CURVE)?, KelvinVoigt::new(TRUE_BRISTLE)?);
    match setting.plant {
        Plant::FrBd => {
            simulate(setting, FrBd::new(curve, bristle).under_load(1.0)?.companion(FASTEST)?)
        }
        Plant::Implicit => {
            let friction = ImplicitBristle::new(curve, bristle)?;
            simulate(setting, friction.under_load(1.0)?.companion(FASTEST)?)
        }
    }
}

/// A run with the friction of the axis.
fn simulate<M: Bristle<f64, Deflection = f64>>(
    setting: Setting,
    plant: Companion<f64, M>,
) -> Result<Outcome, Box<dyn Error>> {
    let mut compensate = compensator(&setting)?;
    let gains = Gains::of(setting.bandwidth);
    let h = setting.rate.recip();
    let velocity = VelocityFromPositionParameters {
        sample_time: h,
        time_constant: FILTER,
        fastest: FASTEST,
        count: COUNT,
    };
    let (mut encoder, mut desired) =
        (VelocityFromPosition::new(velocity)?, VelocityFromPosition::new(velocity)?);
    let fine = (h / FINE).round() as usize * setting.refinement;
    let step = h / fine as f64;

    // The axis starts a third of a count off the bristle's rest position.
    let (mut x, mut v, mut z, mut sum) = (COUNT / 3.0, 0.0, 0.0, 0.0);
    let mut history = VelocityHistory::new(v);
    let count = (END / h).round() as usize;
    let mut samples = Vec::with_capacity(count);
    for n in 0..count {
        let time = n as f64 * h;
        let position = (x / COUNT).round() * COUNT;
        let (target, _, _) = reference(time);
        let (next, _, _) = reference(time + h);
        let (_, _, acceleration) = reference(time + 0.5 * h);
        // Both are filtered alike, so that the filter's lag is not an error.
        let (_, _) = (encoder.step(position), desired.step(target));
        let error = position - target;
        let friction = compensate(&Sample {
            position,
            reference: target,
            reference_velocity: (next - target) / h,
            velocity: encoder.velocity(),
        });
        let wanted = MASS * acceleration + friction
            - gains.proportional * error
            - gains.derivative * (encoder.velocity() - desired.velocity())
            - gains.integral * sum;
        let force = wanted.clamp(-MOTOR, MOTOR);
        // The integral stops at the motor's limit.
        if force == wanted {
            sum += error * h;
        }
        samples.push((time, x - target, force));
        for _ in 0..fine {
            let solve = |predicted: f64| {
                let friction = plant.step(predicted, z, step);
                let body = PointMass { mass: MASS, velocity: v, force, end_weight: 0.5 };
                (friction.point_mass(body), friction)
            };
            let (first, _) = solve(history.predict());
            let (mean, friction) = solve(first);
            (x, v, z) = (x + step * mean, 2.0 * mean - v, friction.commit(mean).deflection);
            history.push(v);
        }
    }
    Ok(Outcome::of(samples))
}

impl Outcome {
    fn of(samples: Vec<(f64, f64, f64)>) -> Self {
        let tracking = |s: &&(f64, f64, f64)| s.0 >= SETTLED && s.0 < PERIODS / FREQUENCY;
        let mean = |value: &dyn Fn(&(f64, f64, f64)) -> f64| {
            let of = samples.iter().filter(tracking);
            of.clone().map(value).sum::<f64>() / of.count() as f64
        };
        let rest: Vec<f64> = samples.iter().filter(|s| s.0 >= AT_REST).map(|s| s.1).collect();
        // Between its extremes, whatever it stands off its target.
        let (low, high) =
            rest.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &e| (a.min(e), b.max(e)));
        let (mut side, mut sign_changes) = (0.0, 0);
        for error in &rest {
            let here = error - 0.5 * (low + high);
            if here.abs() > 2.0 * COUNT && here.signum() != side {
                sign_changes += usize::from(side != 0.0);
                side = here.signum();
            }
        }
        let moved: f64 = samples.windows(2).map(|pair| (pair[1].2 - pair[0].2).abs()).sum();
        Self {
            rms: mean(&|s| s.1 * s.1).sqrt(),
            greatest: samples.iter().filter(tracking).map(|s| s.1.abs()).fold(0.0, f64::max),
            effort: mean(&|s| s.2 * s.2).sqrt(),
            restlessness: moved / END,
            sign_changes,
            range: high - low,
            samples,
        }
    }
}

/// The signs of Coulomb compensation: half widths of a dead band, from zero to beyond the largest
/// speed of the axis, and of a smooth sign [m/s].
fn signs() -> impl Iterator<Item = Sign> {
    let widths = [5e-5, 1e-4, 2e-4, 4e-4, 8e-4, 1.6e-3, 3.2e-3, 6.4e-3, 1.28e-2];
    let bands = [0.0].into_iter().chain(widths).map(Sign::DeadBand);
    bands.chain(widths.into_iter().map(Sign::Smooth))
}

/// The Coulomb compensation that tracks best at a setting, and the best without hunting at rest.
pub(crate) fn best_coulomb(setting: Setting) -> Result<[(Way, Outcome); 2], Box<dyn Error>> {
    let mut best: Option<(Way, Outcome)> = None;
    let mut calm: Option<(Way, Outcome)> = None;
    for sign in signs() {
        let way = Way::Coulomb(sign);
        let outcome = run(Setting { way, ..setting })?;
        let better = |than: &Option<(Way, Outcome)>| {
            than.as_ref().is_none_or(|(_, least)| outcome.rms < least.rms)
        };
        if outcome.sign_changes <= 2 && better(&calm) {
            calm = Some((way, outcome.clone()));
        }
        if better(&best) {
            best = Some((way, outcome));
        }
    }
    // Where every sign chatters at rest, the best one stands for both.
    let best = best.ok_or("no sign to choose from")?;
    Ok([best.clone(), calm.unwrap_or(best)])
}

// ---- report ----

/// A way as it is named and drawn.
struct Look {
    name: &'static str,
    label: &'static str,
    stroke: Stroke,
}

fn look(way: Way) -> Look {
    let (name, label, stroke) = match way {
        Way::None => ("none", "none", Colour::Grey.width(4.0)),
        Way::Coulomb(_) => ("coulomb", "Coulomb, tuned", Colour::Vermilion.into()),
        Way::LuGre => ("lugre", "LuGre, feedback", Colour::Orange.width(2.6)),
        Way::FrBd => ("frbd", "FrBD, feedback", Colour::Blue.dashed().width(1.2)),
        Way::FeedForward => ("feed_forward", "FrBD, feed-forward", Colour::Green.into()),
        Way::Observer => ("observer", "FrBD observer", Colour::Black.dotted()),
    };
    Look { name, label, stroke }
}

/// Time and something to draw, from a sample.
type Quantity = fn(&(f64, f64, f64)) -> (f64, f64);

/// Where in a study the Coulomb compensation stands that does not hunt.
const CALM: usize = 2;

/// One setting with every way.
type Study = Vec<(Setting, Outcome)>;

fn study(base: Setting) -> Result<Study, Box<dyn Error>> {
    let mut all = vec![(base, run(base)?)];
    for (way, outcome) in best_coulomb(base)? {
        all.push((Setting { way, ..base }, outcome));
    }
    for way in [Way::LuGre, Way::FrBd, Way::FeedForward, Way::Observer] {
        let setting = Setting { way, ..base };
        all.push((setting, run(setting)?));
    }
    Ok(all)
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments =
            Arguments::new("friction_compensation", "A servo with friction compensation")
                .number("share", 1.2, "", "over-compensation shown in the second panel")
                .must_be(Rule::Between(0.0, 2.0))
                .parse()?;
        let base = Setting::of(Way::None);
        let over = Setting { share: arguments.number("share"), ..base };
        let settings = [
            base,
            Setting { share: 0.8, ..base },
            over,
            Setting { rate: 1e4, ..base },
            Setting { rate: 1e2, bandwidth: 4.0, ..base },
            Setting { rate: 1e2, bandwidth: 4.0, ..over },
            Setting { plant: Plant::Implicit, ..base },
            Setting { plant: Plant::Implicit, ..over },
        ];
        let mut progress = Progress::new("settings", settings.len());
        let mut studies = Vec::new();
        for setting in settings {
            studies.push(study(setting)?);
            progress.step();
        }
        println!(
            "{MASS} kg, {} µm a count, {FREQUENCY} Hz sine of {} mm, then at rest",
            COUNT * 1e6,
            AMPLITUDE * 1e3
        );
        println!(
            "force moved: by the actuator, per second; \
             changes: of the error's sign at rest, in {} s",
            END - AT_REST
        );
        for study in &studies {
            report(study);
        }
        let columns = [
            "plant",
            "way",
            "share",
            "rate",
            "bandwidth",
            "rms",
            "greatest",
            "effort",
            "force_moved",
            "sign_changes",
            "range",
        ];
        let mut table = Csv::create(arguments.out_dir(), "friction_compensation", &columns)?;
        for (index, (setting, outcome)) in studies.iter().flat_map(|study| study.iter().enumerate())
        {
            let way = if index == CALM { "coulomb_calm" } else { look(setting.way).name };
            let plant = match setting.plant {
                Plant::FrBd => "frbd",
                Plant::Implicit => "implicit",
            };
            let changes = outcome.sign_changes as f64;
            let Outcome { rms, greatest, effort, restlessness, range, .. } = *outcome;
            let Setting { share, rate, bandwidth, .. } = *setting;
            let numbers =
                [share, rate, bandwidth, rms, greatest, effort, restlessness, changes, range];
            table.row(&[plant, way], &numbers)?;
        }
        table.finish()?;
        println!();
        let figure = chart(&studies[0], &studies[2]);
        println!("{}", figure.save(arguments.out_dir(), "friction_compensation")?.display());
        Ok(())
    })
}

fn report(study: &Study) {
    let Some((first, _)) = study.first() else { return };
    println!();
    println!(
        "plant: {:?}, share {}, {} Hz, bandwidth {} Hz",
        first.plant, first.share, first.rate, first.bandwidth
    );
    println!(
        "                    rms error  greatest  rms force  force moved  changes  range at rest"
    );
    for (index, (setting, outcome)) in study.iter().enumerate() {
        let label = if index == CALM { "Coulomb, calm" } else { look(setting.way).label };
        println!(
            "{:18} {:7.2} µm {:6.1} µm {:8.2} N {:8.0} N/s {:8} {:11.2} µm{}",
            label,
            outcome.rms * 1e6,
            outcome.greatest * 1e6,
            outcome.effort,
            outcome.restlessness,
            outcome.sign_changes,
            outcome.range * 1e6,
            match setting.way {
                Way::Coulomb(direction) => format!("  {direction:?}"),
                _ => String::new(),
            }
        );
    }
}

fn chart(tracking: &Study, resting: &Study) -> Figure {
    let error: Quantity = |sample| (sample.0, sample.1 * 1e6);
    let force: Quantity = |sample| (sample.0, sample.2);
    let within = |outcome: &Outcome, span: [f64; 2], of: Quantity| {
        let shown =
            outcome.samples.iter().filter(|sample| sample.0 >= span[0] && sample.0 <= span[1]);
        shown.map(of).collect::<Vec<_>>()
    };
    let drawn = |way: Way| !matches!(way, Way::FeedForward | Way::Observer);
    let panel = |study: &Study, title: &str, label: &str, span: [f64; 2], of: Quantity| {
        let shown = study
            .iter()
            .enumerate()
            .filter(|(index, (setting, _))| *index != CALM && drawn(setting.way));
        shown.map(|(_, run)| run).fold(
            Panel::new("time t (s)", label).title(title),
            |panel, (setting, outcome)| {
                let Look { label, stroke, .. } = look(setting.way);
                panel.line(label, stroke, within(outcome, span, of))
            },
        )
    };
    let share = resting.first().map_or(f64::NAN, |(setting, _)| setting.share);
    Figure::new(760, 860)
        .title("A servo follows a slow sine, with and without friction compensation")
        .panel(panel(
            tracking,
            "tracking error along a slow sine",
            "error e (µm)",
            [SETTLED, PERIODS / FREQUENCY],
            error,
        ))
        .panel(panel(
            tracking,
            "actuator force around a reversal",
            "actuator force u (N)",
            [1.4, 1.7],
            force,
        ))
        .panel(panel(
            resting,
            &format!("at rest, {share} times the friction compensated"),
            "error e (µm)",
            [END - 0.5, END],
            error,
        ))
}
