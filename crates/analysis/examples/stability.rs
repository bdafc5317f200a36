//! Where methods fail: the stick-slip rig of the paper (section V-A, Table 2) in fixed steps, from
//! 0.1 ms to half a second.
//!
//! Beyond its critical steps each method goes its own way: it diverges, it chatters where it should
//! be stuck, or it slides smoothly and wrongly without complaint. The library predicts the critical
//! steps; here they are measured too, as the steps at which a small disturbance starts to grow.
//!
//! Leaves `stability.csv` and `stability.svg`: error, chatter and slip period over the step.

use std::error::Error;
use std::process::ExitCode;

use bristle::companion::{Companion, VelocityHistory};
use bristle::curve::Stribeck;
use bristle::ode::{DormandPrince, Output, RungeKutta4, Solver, System, Tolerances, Trajectory};
use bristle::rheology::KelvinVoigt;
use bristle::scene::{MassSpringDamper, MassSpringDamperParameters, PrescribedVelocity};
use bristle::{Branch, Bristle, FrBd, LuGre, Mechanism, paper};
use bristle_analysis::step_limits::{self, Scheme};
use bristle_charts::{Arguments, Colour, Csv, Figure, Marker, Panel, Progress, Rule, Way, println};
use nalgebra::{Vector1, Vector3};

/// The range of the step [s].
const SHORTEST: f64 = 1e-4;
const LONGEST: f64 = 0.5;

/// The rig sticks where the reference is slower than this [m/s]; a slip begins where the speed
/// passes the second value after it has been below the first.
const STUCK: f64 = 2e-3;
const SLIPPING: f64 = 0.2;

/// Samples of the reference per second: straight lines between them are off by less than 1e-9 m.
const SAMPLES: f64 = 1e4;

/// A run is given up where the position [m] or the velocity [m/s] is beyond this.
const LOST: f64 = 1e3;

const WAYS: [Way<Scheme>; 5] = [
    Way::new(Scheme::Euler, "euler", "Euler", Colour::Vermilion, Marker::Disc),
    Way::new(Scheme::ExactHold, "exact_hold", "exact hold", Colour::Purple, Marker::Diamond),
    Way::new(
        Scheme::SemiImplicitEuler,
        "semi_implicit_euler",
        "semi-implicit Euler",
        Colour::Black,
        Marker::Triangle,
    ),
    Way::new(Scheme::RungeKutta4, "rk4", "RK4, plain", Colour::Blue, Marker::Square),
    Way::new(Scheme::Passive, "passive", "passive", Colour::Green, Marker::Disc),
];

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("stability", "Where methods fail on friction")
            .number("end", 30.0, "s", "end of the simulated time, three slips or so")
            .must_be(Rule::Between(20.0, 1e3))
            .count("steps", 30, "lengths of the step, evenly spaced on a logarithmic scale")
            .must_be(Rule::Between(2.0, 1e3))
            .parse()?;
        let end = arguments.number("end");
        let count = arguments.count("steps");
        let ratio = LONGEST / SHORTEST;
        let steps: Vec<f64> =
            (0..count).map(|i| SHORTEST * ratio.powf(i as f64 / (count - 1) as f64)).collect();

        let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
        let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
        let mut progress = Progress::new("models", 2);
        let frbd = study("frbd", "FrBD", FrBd::new(curve, bristle), end, &steps)?;
        progress.step();
        let lugre = study("lugre", "LuGre", LuGre::classical(curve, bristle), end, &steps)?;
        progress.step();
        let studies = [frbd, lugre];
        println!("The stick-slip rig, {end} s in fixed steps from {SHORTEST} to {LONGEST} s.");
        println!(
            "Critical steps in ms, predicted / measured: bristle at the top speed, stuck mass."
        );
        println!("Outcome, step by step: . right, w wrong, n no stick-slip, D diverged");
        for study in &studies {
            study.report();
        }

        let columns = [
            "model",
            "method",
            "outcome",
            "step",
            "error",
            "chatter",
            "slip_period",
            "bristle_predicted",
            "bristle_measured",
            "stuck_predicted",
            "stuck_measured",
        ];
        let mut table = Csv::create(arguments.out_dir(), "stability", &columns)?;
        for study in &studies {
            for sweep in &study.sweeps {
                for run in &sweep.runs {
                    let limits = [sweep.bristle, sweep.stuck].map(|critical| {
                        critical.map_or([f64::NAN; 2], |c| [c.predicted, c.measured])
                    });
                    let numbers = [run.step, run.error, run.chatter, run.period];
                    let numbers: Vec<f64> =
                        numbers.into_iter().chain(limits.into_iter().flatten()).collect();
                    let texts = [study.name, sweep.way.name, run.outcome(study.period).name()];
                    table.row(&texts, &numbers)?;
                }
            }
        }
        table.finish()?;
        println!();
        println!("{}", chart(&studies).save(arguments.out_dir(), "stability")?.display());
        Ok(())
    })
}

// ---------------------------------------------------------------------------------------------
// The rig, stepped by hand

struct Rig<M> {
    parameters: MassSpringDamperParameters<f64, M>,
    system: MassSpringDamper<f64, M>,
    companion: Companion<f64, M>,
}

impl<M: Bristle<f64, Deflection = f64>> Rig<M> {
    fn new(parameters: MassSpringDamperParameters<f64, M>) -> Result<Self, Box<dyn Error>> {
        let system = MassSpringDamper::new(parameters.clone())?;
        // Its deflection's limit is that of slow sliding, where friction is greatest.
        let companion = parameters.contact.clone().companion(0.0)?;
        Ok(Self { parameters, system, companion })
    }

    /// One step from a state, with the velocity predicted for its middle.
    fn step(
        &self,
        scheme: Scheme,
        time: f64,
        state: &Vector3<f64>,
        predicted: f64,
        h: f64,
    ) -> Vector3<f64> {
        let MassSpringDamperParameters { contact, mechanism, drive_velocity, .. } =
            &self.parameters;
        let Mechanism { mass, spring_stiffness, .. } = mechanism;
        let [x, v, z] = [state[0], state[1], state[2]];
        let spring = |time: f64, x: f64| spring_stiffness * (drive_velocity * time - x);
        match scheme {
            Scheme::Euler => state + self.system.rate(time, state, [Branch::Free]) * h,
            Scheme::SemiImplicitEuler => {
                let v = v + (spring(time, x) - contact.force(v, z)) * h / mass;
                Vector3::new(x + v * h, v, z + contact.rate(v, z) * h)
            }
            Scheme::ExactHold => {
                let hold = contact.hold(v, z, h);
                let force = spring(time + 0.5 * h, x + 0.5 * v * h) - hold.mean_force;
                Vector3::new(x + v * h, v + force * h / mass, hold.deflection)
            }
            Scheme::Passive => {
                // The bristle as a source and a damper in v̄, the mean velocity of the step:
                // m (v₁ − v₀)/h = f − k (x + h v̄/2) − F̄ with v₁ = 2 v̄ − v₀.
                let friction = self.companion.step(predicted, z, h);
                let inertia = 2.0 * mass / h;
                let mean = (inertia * v + spring(time + 0.5 * h, x) - friction.bias())
                    / (inertia + 0.5 * spring_stiffness * h + friction.damping());
                let z = friction.commit(mean).deflection;
                Vector3::new(x + mean * h, 2.0 * mean - v, z)
            }
            _ => RungeKutta4::step(&self.system, time, state, h),
        }
    }

    /// A whole run in steps of one length, against a reference.
    fn run(&self, scheme: Scheme, h: f64, end: f64, reference: &Reference) -> Run {
        let mut state = self.system.at_rest();
        let mut history = VelocityHistory::new(state[1]);
        let (mut error, mut count) = (0.0, 0);
        let (mut chatter, mut stuck) = (0.0, 0);
        let (mut slips, mut ready) = (Vec::new(), true);
        for step in 0..(end / h) as usize {
            let time = step as f64 * h;
            state = self.step(scheme, time, &state, history.predict(), h);
            history.push(state[1]);
            if !(state[0].abs() <= LOST && state[1].abs() <= LOST) {
                let nan = f64::NAN;
                return Run { step: h, error: nan, chatter: nan, period: nan, slips: slips.len() };
            }
            let [position, velocity] = reference.at(time + h);
            error += (state[0] - position).powi(2);
            count += 1;
            if velocity.abs() < STUCK {
                chatter += (state[1] - velocity).powi(2);
                stuck += 1;
            }
            if ready && state[1] > SLIPPING {
                slips.push(time + h);
            }
            ready = state[1] < STUCK || ready && state[1] <= SLIPPING;
        }
        let root_mean = |sum: f64, count: usize| (sum / count as f64).sqrt();
        let error = root_mean(error, count);
        let chatter = root_mean(chatter, stuck);
        Run { step: h, error, chatter, period: period(&slips), slips: slips.len() }
    }
}

/// The mean time [s] from slip to slip; NaN for fewer than two.
fn period(slips: &[f64]) -> f64 {
    match slips {
        [first, .., last] => (last - first) / (slips.len() - 1) as f64,
        _ => f64::NAN,
    }
}

/// What is taken for the truth.
struct Reference(Trajectory<f64, 3>);

impl Reference {
    /// Position and velocity.
    fn at(&self, time: f64) -> [f64; 2] {
        let states = self.0.states();
        let sample = time * SAMPLES;
        let index = (sample as usize).min(states.len() - 2);
        let state = states[index].lerp(&states[index + 1], sample - index as f64);
        [state[0], state[1]]
    }
}

/// What came of one method with one step.
struct Run {
    step: f64,
    /// Root mean square error of the position [m].
    error: f64,
    /// Root mean square error of the velocity [m/s] where the rig should stick.
    chatter: f64,
    /// Mean slip period [s].
    period: f64,
    slips: usize,
}

#[derive(Clone, Copy, PartialEq)]
enum Outcome {
    Right,
    Wrong,
    NoStickSlip,
    Diverged,
}

impl Outcome {
    fn name(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Wrong => "wrong",
            Self::NoStickSlip => "no stick-slip",
            Self::Diverged => "diverged",
        }
    }

    fn letter(self) -> char {
        match self {
            Self::Right => '.',
            Self::Wrong => 'w',
            Self::NoStickSlip => 'n',
            Self::Diverged => 'D',
        }
    }
}

impl Run {
    /// Right is a period within 1 % and a position within a tenth of a slip of half a metre.
    fn outcome(&self, period: f64) -> Outcome {
        if self.error.is_nan() {
            Outcome::Diverged
        } else if self.slips < 2 {
            Outcome::NoStickSlip
        } else if (self.period / period - 1.0).abs() < 0.01 && self.error < 0.05 {
            Outcome::Right
        } else {
            Outcome::Wrong
        }
    }
}

// ---------------------------------------------------------------------------------------------
// Critical steps

#[derive(Clone, Copy)]
struct Critical {
    predicted: f64,
    measured: f64,
}

/// The first step at which a small disturbance grows, searched from a tenth of a guess upward. Asks
/// for what is left of it after so many steps, as a part of its first size.
fn onset(guess: f64, left: impl Fn(f64, usize) -> f64) -> f64 {
    // From the first half of a run to its second. What is left of a hundredth is calm, what is lost
    // has grown.
    let grows = |h: f64| {
        let later = left(h, 800);
        !later.is_finite() || later > f64::max(left(h, 400), 0.01)
    };
    let mut below = 0.1 * guess;
    while !grows(1.1 * below) && below < 10.0 * guess {
        below *= 1.1;
    }
    let mut above = 1.1 * below;
    for _ in 0..8 {
        let middle = 0.5 * (below + above);
        *(if grows(middle) { &mut above } else { &mut below }) = middle;
    }
    below
}

/// One method over all steps.
struct Sweep {
    way: &'static Way<Scheme>,
    runs: Vec<Run>,
    bristle: Option<Critical>,
    stuck: Option<Critical>,
}

/// One model.
struct Study {
    name: &'static str,
    label: &'static str,
    top_speed: f64,
    period: f64,
    sweeps: Vec<Sweep>,
}

fn study<M: Bristle<f64, Deflection = f64>>(
    name: &'static str,
    label: &'static str,
    model: M,
    end: f64,
    steps: &[f64],
) -> Result<Study, Box<dyn Error>> {
    let contact = model.under_load(1.0)?;
    let rig = Rig::new(paper::stick_slip_rig(contact.clone()))?;
    let solver = Solver::checked(DormandPrince, Tolerances::scaled(1e-10, rig.system.scales())?);
    let output = Output::Uniform((end * SAMPLES) as usize + 1);
    let reference = Reference(solver.solve(&rig.system, 0.0..end, rig.system.at_rest(), output)?);
    let states = reference.0.states();
    let top_speed = states.iter().map(|state| state[1].abs()).fold(0.0, f64::max);
    let slips: Vec<f64> = reference
        .0
        .times()
        .iter()
        .zip(states.windows(2))
        .filter(|(_, pair)| pair[0][1] <= SLIPPING && pair[1][1] > SLIPPING)
        .map(|(&time, _)| time)
        .collect();

    let mechanism = rig.system.parameters().mechanism;
    let still = Rig::new(MassSpringDamperParameters {
        drive_velocity: 0.0,
        ..paper::stick_slip_rig(contact.clone())
    })?;
    let dragged = PrescribedVelocity::new(contact.clone(), top_speed);
    let mut sweeps = Vec::new();
    for way in &WAYS {
        let limits = step_limits::largest_step(&contact, Some(mechanism), top_speed, way.scheme)?;
        let bristle = limits.bristle.map(|predicted| {
            let measured = onset(predicted, |h, count| {
                let steady = dragged.stationary(0.0);
                let mut z = steady * 1.001;
                for _ in 0..count {
                    z = match way.scheme {
                        Scheme::RungeKutta4 => RungeKutta4::step(&dragged, 0.0, &z, h),
                        _ => z + Vector1::new(contact.rate(top_speed, z.x)) * h,
                    };
                }
                (z - steady).norm() / (1e-3 * steady.norm())
            });
            Critical { predicted, measured }
        });
        let stuck = limits.stuck_from_rest.map(|predicted| {
            let measured = onset(predicted, |h, count| {
                let kick = 1e-9; // m/s; no more than a thousand times that is small
                let mut state = Vector3::new(0.0, kick, 0.0);
                let mut largest = 0.0; // of a swing's last phases
                for step in 0..count {
                    state = still.step(way.scheme, 0.0, &state, state[1], h);
                    if !(state[1].abs() < 1e3 * kick) {
                        return f64::INFINITY;
                    }
                    largest = if step + 50 < count { 0.0 } else { state[1].abs().max(largest) };
                }
                largest / kick
            });
            Critical { predicted, measured }
        });
        let runs = steps.iter().map(|&h| rig.run(way.scheme, h, end, &reference)).collect();
        sweeps.push(Sweep { way, runs, bristle, stuck });
    }
    Ok(Study { name, label, top_speed, period: period(&slips), sweeps })
}

impl Study {
    fn report(&self) {
        println!();
        println!(
            "{}: slip period {:.4} s, top speed {:.3} m/s",
            self.label, self.period, self.top_speed
        );
        println!(
            "                        bristle           stuck mass        outcome over the step"
        );
        for sweep in &self.sweeps {
            let [bristle, stuck] = [sweep.bristle, sweep.stuck].map(|critical| match critical {
                Some(c) => format!("{:.3} / {:.3}", c.predicted * 1e3, c.measured * 1e3),
                None => "no limit".to_owned(),
            });
            let outcomes: String =
                sweep.runs.iter().map(|run| run.outcome(self.period).letter()).collect();
            println!("{:22}  {bristle:16}  {stuck:16}  {outcomes}", sweep.way.label);
        }
    }
}

// ---------------------------------------------------------------------------------------------
// The chart

/// A row of panels: what to draw, the range of the values, and which critical step to mark.
struct Row {
    label: &'static str,
    title: &'static str,
    quantity: fn(&Run) -> f64,
    range: [f64; 2],
    limit: Option<fn(&Sweep) -> Option<Critical>>,
}

const ROWS: [Row; 3] = [
    Row {
        label: "RMS error of x (m)",
        title: "error; limits of the bristle",
        quantity: |run| run.error,
        range: [1e-11, 1.0],
        limit: Some(|sweep| sweep.bristle),
    },
    Row {
        label: "RMS error of v while stuck (m/s)",
        title: "chatter; limits of the stuck mass",
        quantity: |run| run.chatter,
        range: [1e-10, 1.0],
        limit: Some(|sweep| sweep.stuck),
    },
    Row {
        label: "mean slip period (s)",
        title: "slip period, where there are slips",
        quantity: |run| run.period,
        range: [0.0, 15.0],
        limit: None,
    },
];

const NOTE: &str = "Marks above the upper line: the run diverged at this step. Below the lower \
                    line: critical steps, measured (mark) and predicted (bar; limits of the \
                    bristle: at the top speed).";

fn chart(studies: &[Study; 2]) -> Figure {
    let mut figure = Figure::new(900, 1060)
        .title("Where methods fail: errors and slip period over the step of the stick-slip rig")
        .note(NOTE)
        .columns(2);
    let panels = ROWS.iter().flat_map(|row| studies.iter().map(move |study| (row, study)));
    for (row, study) in panels {
        let title = format!("{}: {}", study.label, row.title);
        figure = figure.panel(row.panel(study).title(title));
    }
    figure
}

impl Row {
    fn panel(&self, study: &Study) -> Panel {
        let [least, most] = self.range;
        let panel =
            Panel::new("step h (s)", self.label).log_x().x_range(SHORTEST * 0.9..=LONGEST * 1.1);
        // Above the greatest error there is a rung for each method that diverges.
        let mut panel = match self.limit {
            None => panel.y_range(least..=most).horizontal(study.period, "reference"),
            Some(_) => panel
                .log_y()
                .y_range(least * 1e-5..=most * 90.0)
                .horizontal(most * 2.0, "")
                .horizontal(least, ""),
        };
        for (index, sweep) in study.sweeps.iter().enumerate() {
            let Way { label, colour, marker, .. } = *sweep.way;
            let symbol = colour.marked(marker);
            let points = sweep.runs.iter().map(|run| (run.step, (self.quantity)(run)));
            panel = panel.marked_line(label, colour, symbol.size(5.0), points);
            let Some(limit) = self.limit else { continue };
            let rung = most * 4.0 * 2.25f64.powi(index as i32);
            let lost = sweep.runs.iter().filter(|run| run.error.is_nan());
            panel = panel.points(label, symbol.size(5.0), lost.map(|run| (run.step, rung)));
            if let Some(Critical { predicted, measured }) = limit(sweep) {
                // Each method has a level of its own, so that equal limits do not hide each other.
                let level = least * 3e-5 * 8f64.powi(index as i32);
                let (mark, line) =
                    ((measured, level), [(predicted, 0.36 * level), (predicted, 2.8 * level)]);
                panel =
                    panel.line("", colour.width(1.5), line).points("", symbol.size(7.0), [mark]);
            }
        }
        panel
    }
}
