//! Which step and which scheme a real-time simulation can afford: the stick-slip rig of the paper
//! (section V-A, Table 2) in fixed steps of 20 µs to 20 ms, in `f32` and in `f64`.
//!
//! The error is the root mean square of that of the spring's elongation over the whole run. The
//! cost is the time of the processor for one second simulated, from the median of many short parts
//! of the run. A scheme is called unstable from the first step on at which it diverges, or where
//! its velocity zigzags from step to step by more than 0.4 mm/s while the rig should stick.
//!
//! Leaves `real_time.csv` and `real_time.svg`. Times differ between machines; the ratios of the
//! schemes hardly do.

use std::error::Error;
use std::hint::black_box;
use std::process::ExitCode;
use std::time::Instant;

use bristle::companion::Companion;
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::ode::{self, Output};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::scene::MassSpringDamper;
use bristle::{Bristle, Contact, FrBd, Scalar, paper};
use bristle_charts::{Arguments, Colour, Csv, Figure, Marker, Panel, Progress, Rule, Way, println};

/// The shortest step [s], and the steps as multiples of it: closer together where schemes become
/// unstable.
const SHORTEST: f64 = 2e-5;
const STEPS: [usize; 14] = [1, 2, 4, 8, 16, 32, 64, 128, 256, 384, 512, 640, 768, 1024];

/// The rig should stick where the reference is slower than this [m/s].
const STUCK: f64 = 2e-3;

/// A zigzag of the velocity [m/s] beyond this is an instability: in stable runs it is below half of
/// this, at the edges of the slips.
const ZIGZAG: f64 = 4e-4;

/// Steps that are timed together, and how often the run is repeated for it.
const PART: usize = 1000;
const RUNS: usize = 5;

/// A run is given up beyond this elongation [m] or velocity [m/s].
const LOST: f64 = 1e3;

#[derive(Clone, Copy, PartialEq)]
enum Scheme {
    Explicit,
    Hold,
    CompanionOnce,
    CompanionTwice,
}

const WAYS: [Way<Scheme>; 4] = [
    Way::new(Scheme::Explicit, "explicit", "explicit", Colour::Vermilion, Marker::Disc),
    Way::new(Scheme::Hold, "hold", "hold", Colour::Purple, Marker::Diamond),
    Way::new(Scheme::CompanionOnce, "companion_once", "companion", Colour::Green, Marker::Square),
    Way::new(
        Scheme::CompanionTwice,
        "companion_twice",
        "companion twice",
        Colour::Blue,
        Marker::Disc,
    ),
];

type Friction<T> = FrBd<Stribeck<T>, KelvinVoigt<T>>;

/// The rig in one scalar type. Its state is the spring's elongation [m], the velocity [m/s] and the
/// deflection [m]: a position beside the drive's would lose digits to rounding as time goes on.
struct Rig<T: Scalar> {
    contact: Contact<T, Friction<T>>,
    companion: Companion<T, Friction<T>>,
    mass: T,
    stiffness: T,
    drive: T,
}

fn lit<T: Scalar>(value: f64) -> T {
    nalgebra::convert(value)
}

fn wide<T: Scalar>(value: T) -> f64 {
    nalgebra::try_convert(value).unwrap_or(f64::NAN)
}

fn friction<T: Scalar>() -> Result<Friction<T>, Box<dyn Error>> {
    let (curve, bristle) = (paper::STICK_SLIP_CURVE, paper::STICK_SLIP_BRISTLE);
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: lit(curve.static_coefficient),
        dynamic_coefficient: lit(curve.dynamic_coefficient),
        stribeck_velocity: lit(curve.stribeck_velocity),
        stribeck_exponent: lit(curve.stribeck_exponent),
        viscous_friction: lit(curve.viscous_friction),
    })?;
    let bristle = KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness: lit(bristle.micro_stiffness),
        micro_damping: lit(bristle.micro_damping),
    })?;
    Ok(FrBd::new(curve, bristle))
}

impl<T: Scalar> Rig<T> {
    fn new() -> Result<Self, Box<dyn Error>> {
        let contact = friction::<T>()?.under_load(T::one())?;
        let companion = contact.companion(T::zero())?;
        let rig = paper::stick_slip_rig(friction::<f64>()?.under_load(1.0)?);
        let (mass, stiffness) = (lit(rig.mechanism.mass), lit(rig.mechanism.spring_stiffness));
        Ok(Self { contact, companion, mass, stiffness, drive: lit(rig.drive_velocity) })
    }

    /// One step h from a state, given the velocity where the step before began.
    #[inline(always)]
    fn step(&self, scheme: Scheme, [e, v, z]: [T; 3], before: T, h: T) -> [T; 3] {
        let half: T = lit(0.5);
        match scheme {
            // The velocity first, then the rest with the new one.
            Scheme::Explicit => {
                let response = self.contact.response(v, z);
                let v = v + (self.stiffness * e - response.force) * h / self.mass;
                [e + (self.drive - v) * h, v, z + response.rate * h]
            }
            Scheme::Hold => {
                let held = self.contact.hold(v, z, h);
                let middle = e + half * (self.drive - v) * h;
                let force = self.stiffness * middle - held.mean_force;
                [e + (self.drive - v) * h, v + force * h / self.mass, held.deflection]
            }
            Scheme::CompanionOnce => self.passive([e, v, z], lit::<T>(1.5) * v - half * before, h),
            Scheme::CompanionTwice => {
                let predicted = lit::<T>(1.5) * v - half * before;
                let [_, end, _] = self.passive([e, v, z], predicted, h);
                self.passive([e, v, z], half * (v + end), h)
            }
        }
    }

    /// The bristle as a source and a damper in the mean velocity v̄ of the step:
    /// m (v₁ − v₀)/h = k (e + h (v_d − v̄)/2) − F̄ with v₁ = 2 v̄ − v₀.
    #[inline(always)]
    fn passive(&self, [e, v, z]: [T; 3], predicted: T, h: T) -> [T; 3] {
        let (half, two): (T, T) = (lit(0.5), lit(2.0));
        let friction = self.companion.step(predicted, z, h);
        let inertia = two * self.mass / h;
        let spring = self.stiffness * (e + half * self.drive * h);
        let mean = (inertia * v + spring - friction.bias())
            / (inertia + half * self.stiffness * h + friction.damping());
        let z = friction.commit(mean).deflection;
        [e + (self.drive - mean) * h, two * mean - v, z]
    }

    /// The time of a step [s], the median over parts of the run.
    fn time(&self, scheme: Scheme, h: T, steps: usize) -> f64 {
        let mut times = Vec::new();
        for _ in 0..RUNS {
            let (mut state, mut before) = ([T::zero(); 3], T::zero());
            for _ in 0..steps.div_ceil(PART).min(100) {
                let begin = Instant::now();
                for _ in 0..PART {
                    let next = self.step(scheme, state, before, h);
                    before = state[1];
                    state = next;
                }
                state = black_box(state);
                times.push(begin.elapsed().as_secs_f64() / PART as f64);
            }
        }
        times.sort_by(f64::total_cmp);
        times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
    }

    /// Root mean squares of the error of the elongation [m], and of the zigzag of the velocity
    /// [m/s] where the rig should stick; NaN for a run that diverges.
    fn errors(&self, scheme: Scheme, every: usize, steps: usize, truth: &Truth) -> [f64; 2] {
        let h: T = lit(SHORTEST * every as f64);
        let (mut state, mut before) = ([T::zero(); 3], T::zero());
        let ([mut error, mut chatter], [mut count, mut stuck]) = ([0.0; 2], [0.0; 2]);
        for i in 1..=steps {
            let next = self.step(scheme, state, before, h);
            // The distance of a velocity from the mean of those beside it, halved.
            let zigzag = wide(state[1] - (before + next[1]) * lit(0.5)) * 0.5;
            before = state[1];
            state = next;
            let ([e, v, _], [true_e, true_v]) = (state.map(wide), truth.at(i * every));
            if !(e.abs() < LOST && v.abs() < LOST) {
                return [f64::NAN; 2];
            }
            error += (e - true_e) * (e - true_e);
            count += 1.0;
            if true_v.abs() < STUCK {
                chatter += zigzag * zigzag;
                stuck += 1.0;
            }
        }
        [(error / count).sqrt(), (chatter / f64::max(stuck, 1.0)).sqrt()]
    }
}

/// Elongation [m] and velocity [m/s] at every multiple of the shortest step.
struct Truth {
    states: Vec<[f64; 2]>,
}

impl Truth {
    fn new(end: f64) -> Result<Self, Box<dyn Error>> {
        let rig = paper::stick_slip_rig(friction::<f64>()?.under_load(1.0)?);
        let drive = rig.drive_velocity;
        let rig = MassSpringDamper::new(rig)?;
        let samples = (end / SHORTEST).round() as usize + 1;
        let end = SHORTEST * (samples - 1) as f64;
        let run = ode::solve(&rig, 0.0..end, rig.at_rest(), 1e-8, Output::Uniform(samples))?;
        let states = run.iter().map(|(time, state)| [drive * time - state[0], state[1]]).collect();
        Ok(Self { states })
    }

    fn at(&self, sample: usize) -> [f64; 2] {
        self.states.get(sample).copied().unwrap_or([f64::NAN; 2])
    }
}

struct Point {
    step: f64,
    error: f64,
    chatter: f64,
    /// Nanoseconds for one second simulated.
    cost: f64,
}

impl Point {
    fn is_stable(&self) -> bool {
        self.chatter <= ZIGZAG
    }
}

struct Sweep {
    way: &'static Way<Scheme>,
    scalar: &'static str,
    points: Vec<Point>,
}

impl Sweep {
    fn new<T: Scalar>(
        way: &'static Way<Scheme>,
        scalar: &'static str,
        end: f64,
        truth: &Truth,
    ) -> Result<Self, Box<dyn Error>> {
        let rig = Rig::<T>::new()?;
        let mut points = Vec::new();
        for every in STEPS {
            let step = SHORTEST * every as f64;
            let steps = (end / step) as usize;
            let [error, chatter] = rig.errors(way.scheme, every, steps, truth);
            let cost = rig.time(way.scheme, lit(step), steps) * 1e9 / step;
            points.push(Point { step, error, chatter, cost });
        }
        Ok(Self { way, scalar, points })
    }

    /// The first step of those that are longer and not stable [s].
    fn unstable_from(&self) -> Option<f64> {
        self.points.iter().find(|point| !point.is_stable()).map(|point| point.step)
    }

    fn label(&self) -> String {
        let limit = match self.unstable_from() {
            Some(step) => format!("unstable at {:.2} ms", step * 1e3),
            None => "stable".into(),
        };
        format!("{}, {limit}", self.way.label)
    }
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("real_time", "What a real-time simulation can afford")
            .number("end", 30.0, "s", "end of the simulated time, three slips or so")
            .must_be(Rule::Between(10.0, 1e3))
            .parse()?;
        let end = arguments.number("end");
        let truth = Truth::new(end)?;
        let mut progress = Progress::new("sweeps", 2 * WAYS.len());
        let mut sweeps = Vec::new();
        for way in &WAYS {
            sweeps.push(Sweep::new::<f32>(way, "f32", end, &truth)?);
            progress.step();
            sweeps.push(Sweep::new::<f64>(way, "f64", end, &truth)?);
            progress.step();
        }

        println!("The stick-slip rig, {end} s in fixed steps.");
        println!("scalar scheme: step / ms, error / m, ns per second simulated, ns per step");
        let columns = ["scalar", "scheme", "step", "error", "chatter", "ns_per_second", "stable"];
        let mut table = Csv::create(arguments.out_dir(), "real_time", &columns)?;
        for Sweep { way, scalar, points } in &sweeps {
            println!("{scalar} {}", way.label);
            for point in points {
                let Point { step, error, chatter, cost } = *point;
                let note = if point.is_stable() { "" } else { " unstable" };
                let each = cost * step;
                println!("  {:8.3} {error:9.2e} {cost:11.0} {each:6.1}{note}", step * 1e3);
                let numbers = [step, error, chatter, cost, f64::from(u8::from(point.is_stable()))];
                table.row(&[scalar, way.name], &numbers)?;
            }
        }
        table.finish()?;
        println!("{}", chart(&sweeps).save(arguments.out_dir(), "real_time")?.display());
        Ok(())
    })
}

fn chart(sweeps: &[Sweep]) -> Figure {
    let mut figure = Figure::new(1000, 480)
        .title("Fixed steps on the stick-slip rig: error over time spent")
        .note(
            "One symbol a step, 0.02 ms to 20.48 ms. \
             Triangles: unstable steps that do not diverge.",
        )
        .columns(2);
    for scalar in ["f64", "f32"] {
        let mut panel = Panel::new(
            "time spent for one second simulated (ns)",
            "RMS error of the elongation (m)",
        )
        .title(scalar)
        .log_x()
        .log_y()
        .x_range(1e3..=1e7)
        .y_range(1e-9..=1.0)
        .own_legend();
        for sweep in sweeps.iter().filter(|sweep| sweep.scalar == scalar) {
            let Way { colour, marker, .. } = sweep.way;
            let place = |point: &Point| (point.cost, point.error);
            let stable = sweep.points.iter().filter(|point| point.is_stable());
            let unstable = sweep.points.iter().filter(|point| !point.is_stable());
            let symbol = colour.marked(*marker).size(4.5);
            panel = panel
                .marked_line(&sweep.label(), colour.width(1.2), symbol, stable.map(place))
                .points(
                    "",
                    colour.marked(Marker::Triangle).size(6.0),
                    unstable.filter(|point| point.error.is_finite()).map(place),
                );
        }
        figure = figure.panel(panel);
    }
    figure
}
