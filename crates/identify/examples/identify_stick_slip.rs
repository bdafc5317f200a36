//! Friction parameters from stick-slip, by its statistics: a mass m \[kg\] is pulled by a spring k
//! [N/m] whose end moves at V.
//!
//! m v̇ = F − p μ,  Ḟ = k (V − v),  p = m g
//!
//! Events of a real contact are irregular, so the runs are compared by three statistics, computed
//! by the same code for data and simulation: the mean fall of F/p at a slip (between turning points
//! more than a threshold apart), the period (the first maximum of the autocorrelation after its
//! first minimum), and the mean of F/p.
//!
//! `identify::least_squares` finds one set of parameters for all speeds. Sensitivities are exact,
//! by dual numbers through mechanism and statistics.
//!
//! The threshold is chosen so that the mean time between falls and the period agree in the data.
//!
//! Without files it takes the statistics of a known model at four speeds and finds it again. With
//! `--runs FILE:V,FILE:V` each file has one column, F/p, at even times (`--rate`), and V is in m/s.
//! `--predict FILE:V:K` are runs that are not fitted, with a spring of K [N/m].
//! `--model lugre` takes the other model; `--mass-factor 3` lets the moving mass differ
//! from the weight over g by that factor; `--mean-weight 0` leaves the mean friction out. A
//! parameter that is e times its start counts as much as a statistic that is off by `--prior`.
//!
//! Leaves `identify_stick_slip.csv` and `identify_stick_slip.svg`: F/p over time, measured and
//! simulated.

use std::error::Error;
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::ExitCode;

use bristle::companion::VelocityHistory;
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{Deflection, KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, FrBd, LuGre, ParameterError, Scalar};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Progress, Rule, Values, println};
use bristle_identify as identify;
use bristle_identify::{Identifiability, Parameter, Residuals, SearchSettings};

/// Acceleration of gravity \[m/s²\]: the load is the slider's own weight.
const GRAVITY: f64 = 9.81;

/// Rows between two samples of the autocorrelation.
const THINNING: usize = 4;

/// μ_d, μ_s − μ_d, v_S, σ2, σ0, σ1, and the moving mass over that of the load.
const COUNT: usize = 7;

/// Parameters of the synthetic runs.
const TRUTH: [f64; COUNT] = [0.30, 0.04, 5e-4, 0.5, 1e5, 60.0, 1.0];
const TRUE_SPEEDS: [f64; 4] = [0.5e-3, 1e-3, 1.5e-3, 2e-3];

/// Which friction model.
#[derive(Debug, Clone, Copy)]
enum Model {
    FrBd,
    LuGre,
}

/// Statistics of a record of F/p. Zero where there is no stick-slip.
#[derive(Debug, Clone, Copy)]
struct Statistics<T> {
    /// Mean fall at a slip \[–\].
    amplitude: T,
    /// First maximum of the autocorrelation after its first minimum \[s\].
    period: T,
    /// Mean \[–\].
    mean: T,
    /// Mean duration of a fall \[s\].
    fall: f64,
    /// Mean time from one fall to the next \[s\].
    interval: f64,
}

/// One measured run.
struct Run {
    name: String,
    speed: f64,
    /// Of the spring [N/m].
    stiffness: f64,
    force: Vec<f64>,
    measured: Statistics<f64>,
}

/// The rig, what was measured, and how it is simulated.
struct Rig {
    model: Model,
    mass: f64,
    mass_factor: f64,
    mean_weight: f64,
    prior: f64,
    threshold: f64,
    /// Time between two rows \[s\].
    row: f64,
    substeps: usize,
    runs: Vec<Run>,
    /// Runs that are not fitted.
    unseen: Vec<Run>,
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments =
            Arguments::new("identify_stick_slip", "Friction parameters from stick-slip statistics")
                .text("runs", "", "FILE:SPEED,FILE:SPEED with the spring's speed in m/s")
                .text(
                    "predict",
                    "",
                    "FILE:SPEED:STIFFNESS of runs that are not fitted, in m/s, N/m",
                )
                .text("model", "frbd", "frbd or lugre")
                .number("mass", 0.0307, "kg", "mass of the slider, whose weight is the load")
                .must_be(Rule::Positive)
                .number("stiffness", 168.0, "N/m", "stiffness of the spring")
                .must_be(Rule::Positive)
                .number("mass-factor", 1.0, "", "the moving mass may differ by this factor")
                .must_be(Rule::AtLeast(1.0))
                .number("prior", 0.01, "", "weight of the logarithm of a parameter over its start")
                .must_be(Rule::AtLeast(0.0))
                .number("mean-weight", 0.3, "", "weight of the mean friction beside the others")
                .must_be(Rule::AtLeast(0.0))
                .number("threshold", 0.022, "", "least fall and rise of F/p that count")
                .must_be(Rule::Positive)
                .number("rate", 2000.0, "Hz", "rows per second")
                .must_be(Rule::Between(1.0, 1e6))
                .count("starts", 6, "searches from different places")
                .must_be(Rule::Between(1.0, 1e3))
                .count("iterations", 50, "most iterations of a search")
                .must_be(Rule::Between(1.0, 1e4))
                .parse()?;
        let model = match arguments.text("model") {
            "frbd" => Model::FrBd,
            "lugre" => Model::LuGre,
            other => {
                return Err(
                    format!("--model must be frbd or lugre, but {other:?} was given").into()
                );
            }
        };
        let mut rig = Rig {
            model,
            mass: arguments.number("mass"),
            mass_factor: arguments.number("mass-factor"),
            mean_weight: arguments.number("mean-weight"),
            prior: arguments.number("prior"),
            threshold: arguments.number("threshold"),
            row: 1.0 / arguments.number("rate"),
            substeps: 4,
            runs: vec![],
            unseen: vec![],
        };
        let synthetic = arguments.text("runs").is_empty();
        let stiffness = arguments.number("stiffness");
        rig.runs = if synthetic {
            rig.synthetic(stiffness)?
        } else {
            rig.read("--runs", arguments.text("runs"), Some(stiffness))?
        };
        rig.unseen = rig.read("--predict", arguments.text("predict"), None)?;
        report(rig, synthetic, &arguments)
    })
}

/// The statistics of a record of F/p.
fn statistics<T: Scalar>(force: &[T], threshold: f64, row: f64) -> Statistics<T> {
    let number = |x: f64| -> T { nalgebra::convert(x) };
    let count = |n: usize| number(n.max(1) as f64);
    let sum = |values: &[T]| values.iter().fold(T::zero(), |sum, &x| sum + x);
    let mean = sum(force) / count(force.len());

    // Turning points: a maximum counts once the force has fallen by the threshold, and so on.
    let threshold = number(threshold);
    let start = force.first().copied().unwrap_or(T::zero());
    let (mut highest, mut lowest) = ((0, start), (0, start));
    let mut rising = true;
    let (mut falls, mut rows, mut peaks) = (vec![], 0, vec![]);
    for (place, &now) in force.iter().enumerate() {
        if now > highest.1 {
            highest = (place, now);
        }
        if now < lowest.1 {
            lowest = (place, now);
        }
        if rising && now < highest.1 - threshold {
            (rising, lowest) = (false, (place, now));
            peaks.push(highest.0);
        } else if !rising && now > lowest.1 + threshold {
            falls.push(highest.1 - lowest.1);
            rows += lowest.0 - highest.0;
            (rising, highest) = (true, (place, now));
        }
    }
    let interval = match peaks[..] {
        [first, .., last] => (last - first) as f64 * row / (peaks.len() - 1) as f64,
        _ => 0.0,
    };
    Statistics {
        amplitude: sum(&falls) / count(falls.len()),
        period: if falls.len() > 1 { period(force, mean) * number(row) } else { T::zero() },
        mean,
        fall: rows as f64 * row / falls.len().max(1) as f64,
        interval,
    }
}

/// First maximum of the autocorrelation after its first minimum, in rows; zero if there is none.
fn period<T: Scalar>(force: &[T], mean: T) -> T {
    let number = |x: f64| -> T { nalgebra::convert(x) };
    let swing: Vec<T> = force.iter().step_by(THINNING).map(|&x| x - mean).collect();
    let correlation = |lag: usize| {
        let pairs = swing.iter().zip(swing.iter().skip(lag));
        pairs.fold(T::zero(), |sum, (&a, &b)| sum + a * b) / number((swing.len() - lag) as f64)
    };
    let (mut before, mut here, mut fallen) = (correlation(0), correlation(1), false);
    for lag in 2..swing.len() / 3 {
        let after = correlation(lag);
        fallen |= here < before && after >= here;
        if fallen && here >= before && after < here {
            // The summit of the parabola through the three.
            let shift = (before - after) / (before - here - here + after) * number(0.5);
            return (number((lag - 1) as f64) + shift) * number(THINNING as f64);
        }
        (before, here) = (here, after);
    }
    T::zero()
}

impl Rig {
    /// F/p of a simulated run, row by row, after a second of settling.
    fn simulate<T: Scalar>(
        &self,
        &[dynamic, excess, velocity, viscous, s0, s1, share]: &[T; COUNT],
        [speed, stiffness]: [f64; 2],
        start: f64,
        duration: f64,
    ) -> Result<Vec<T>, ParameterError> {
        let curve = Stribeck::new(StribeckParameters {
            static_coefficient: dynamic + excess,
            dynamic_coefficient: dynamic,
            stribeck_velocity: velocity,
            stribeck_exponent: nalgebra::convert(2.0),
            viscous_friction: viscous,
        })?;
        let rheology =
            KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness: s0, micro_damping: s1 })?;
        let mass = share * nalgebra::convert(self.mass);
        let span = (speed, stiffness, start, duration);
        match self.model {
            Model::FrBd => self.drive(FrBd::new(curve, rheology), mass, span),
            Model::LuGre => self.drive(LuGre::classical(curve, rheology), mass, span),
        }
    }

    /// The mechanism, by companion steps: the friction of each is a source and a damper, and the
    /// step has a closed form.
    fn drive<T: Scalar, M: Bristle<T>>(
        &self,
        friction: M,
        mass: T,
        (speed, spring, start, duration): (f64, f64, f64, f64),
    ) -> Result<Vec<T>, ParameterError> {
        let number = |x: f64| -> T { nalgebra::convert(x) };
        let load = self.mass * GRAVITY;
        let step = self.row / self.substeps as f64;
        let (settle, rows) = ((1.0 / self.row) as usize, (duration / self.row) as usize);
        let contact = friction.under_load(number(load))?.companion(number(10.0 * speed))?;
        let (h, stiffness, end) = (number(step), number(spring), number(speed));
        let half = number(0.5 * step * spring);
        let inertia = (mass + mass) / h;
        let mut stretch = number(start * load / spring);
        let (mut v, mut z) = (T::zero(), M::Deflection::fill(T::zero()));
        let mut history = VelocityHistory::new(v);
        let mut force = Vec::with_capacity(rows);
        for row in 0..settle + rows {
            if row >= settle {
                force.push(stretch * number(spring / load));
            }
            for _ in 0..self.substeps {
                let friction = contact.step(history.predict(), z, h);
                // m (v₁ − v)/h = k (s + h (V − v̄)/2) − bias − damping v̄ with v₁ = 2 v̄ − v
                let mean_velocity = (inertia * v + stiffness * stretch + half * end
                    - friction.bias())
                    / (inertia + half + friction.damping());
                stretch += h * (end - mean_velocity);
                v = mean_velocity + mean_velocity - v;
                z = friction.commit(mean_velocity).deflection;
                history.push(v);
            }
        }
        Ok(force)
    }

    /// Period \[s\] of stick-slip with an amplitude A = 2a, for constant friction in sliding and
    /// sticking at v = 0, whatever the level and drop of the friction:
    ///
    /// (π + 2 atan(w/Δ))/ω + 2Δ p/(k V),  ω = √(k/m),  w = V √(k m)/p,  Δ² = a² − w²
    fn ideal_period(&self, run: &Run, amplitude: f64) -> f64 {
        let (load, speed, stiffness) = (self.mass * GRAVITY, run.speed, run.stiffness);
        let (half, steady) = (0.5 * amplitude, speed * (stiffness * self.mass).sqrt() / load);
        let drop = (half * half - steady * steady).max(0.0).sqrt();
        (PI + 2.0 * steady.atan2(drop)) * (self.mass / stiffness).sqrt()
            + 2.0 * drop * load / (stiffness * speed)
    }

    /// Time to simulate \[s\]: some ten periods.
    fn duration(&self, run: &Run) -> f64 {
        (10.0 * run.measured.period).clamp(0.5, 10.0)
    }

    /// `FILE:SPEED`, or `FILE:SPEED:STIFFNESS` where no stiffness is given, separated by commas.
    fn read(
        &self,
        option: &str,
        runs: &str,
        stiffness: Option<f64>,
    ) -> Result<Vec<Run>, Box<dyn Error>> {
        let read = |text: &str| -> Result<Run, Box<dyn Error>> {
            let form = if stiffness.is_some() { "FILE:SPEED" } else { "FILE:SPEED:STIFFNESS" };
            let wrong = || format!("{option} must be {form},… in SI units, but {text:?} was given");
            let number = |text: &str| text.parse().ok().filter(|&x: &f64| x > 0.0 && x.is_finite());
            let (path, last) = text.rsplit_once(':').ok_or_else(wrong)?;
            let last = number(last).ok_or_else(wrong)?;
            let (path, speed, stiffness) = match stiffness {
                Some(stiffness) => (path, last, stiffness),
                None => {
                    let (path, speed) = path.rsplit_once(':').ok_or_else(wrong)?;
                    (path, number(speed).ok_or_else(wrong)?, last)
                }
            };
            let mut columns = bristle_charts::read_columns(Path::new(path), "f=1")?;
            let (_, force) = columns.pop().ok_or_else(wrong)?;
            self.run(speed, stiffness, force)
        };
        runs.split(',').filter(|text| !text.is_empty()).map(read).collect()
    }

    fn run(&self, speed: f64, stiffness: f64, force: Vec<f64>) -> Result<Run, Box<dyn Error>> {
        let name = format!("{stiffness:4.0} N/m, {:.2} mm/s", 1e3 * speed);
        let measured = statistics(&force, self.threshold, self.row);
        if !(measured.amplitude > 0.0 && measured.period > 0.0 && measured.mean > 0.0) {
            return Err(format!("no stick-slip in the run at {name}").into());
        }
        Ok(Run { name, speed, stiffness, force, measured })
    }

    /// Runs of the known model with the step of the search, so that only what the statistics do not
    /// determine remains.
    fn synthetic(&self, stiffness: f64) -> Result<Vec<Run>, Box<dyn Error>> {
        let run = |&speed: &f64| {
            let force = self.simulate(&TRUTH, [speed, stiffness], TRUTH[0], 4.0)?;
            self.run(speed, stiffness, force)
        };
        TRUE_SPEEDS.iter().map(run).collect()
    }
}

impl Rig {
    /// Starts and bounds.
    fn parameters(&self) -> [Parameter; COUNT] {
        let means = self.runs.iter().map(|run| run.measured.mean);
        let mean = means.sum::<f64>() / self.runs.len().max(1) as f64;
        let within = |name, unit, start, least, most| Parameter {
            name,
            unit,
            start,
            least,
            most,
            typical: None,
        };
        [
            Parameter::positive("dynamic_coefficient", "", 0.9 * mean, 10.0),
            Parameter::positive("static_excess", "", 0.1 * mean, 30.0),
            within("stribeck_velocity", "m/s", 1e-3, 1e-5, 3e-2),
            within("viscous_friction", "s/m", 0.3, 1e-2, 300.0),
            within("micro_stiffness", "1/m", 5e4, 3e3, 3e5),
            within("micro_damping", "s/m", 30.0, 1e-1, 300.0),
            Parameter::positive("moving_mass", "of load", 1.0, self.mass_factor),
        ]
    }
}

impl Residuals<COUNT> for Rig {
    fn evaluate<T: Scalar>(
        &self,
        values: &[T; COUNT],
        each: &mut impl FnMut(T),
    ) -> Result<(), ParameterError> {
        for run in &self.runs {
            let Statistics { amplitude, period, mean, .. } = run.measured;
            let force =
                self.simulate(values, [run.speed, run.stiffness], mean, self.duration(run))?;
            let simulated = statistics(&force, self.threshold, self.row);
            let off = |simulated: T, measured: f64, weight: f64| {
                (simulated / nalgebra::convert(measured) - T::one()) * nalgebra::convert(weight)
            };
            each(off(simulated.amplitude, amplitude, 1.0));
            each(off(simulated.period, period, 1.0));
            each(off(simulated.mean, mean, self.mean_weight));
        }
        // What the statistics do not tell stays near its start: otherwise rounding would choose.
        for (&value, parameter) in values.iter().zip(self.parameters()) {
            let weight: T = nalgebra::convert(self.prior);
            each((value / nalgebra::convert(parameter.start)).ln() * weight);
        }
        Ok(())
    }
}

fn report(rig: Rig, synthetic: bool, arguments: &Values) -> Result<(), Box<dyn Error>> {
    let Rig { mass, row, .. } = rig;
    let stiffness = arguments.number("stiffness");
    println!(
        "m = {mass} kg, k = {stiffness} N/m: half a swing π√(m/k) = {:.4} s\n",
        PI * (mass / stiffness).sqrt()
    );
    println!(
        "measured               threshold  amplitude    period  by counting    a fall   mean  \
         constant friction"
    );
    for run in rig.runs.iter().chain(&rig.unseen) {
        for threshold in [0.5, 1.0, 1.5, 2.0].map(|factor| factor * rig.threshold) {
            let Statistics { amplitude, period, mean, fall, interval } =
                statistics(&run.force, threshold, row);
            println!(
                "{:22} {threshold:9.3} {amplitude:10.4} {period:7.4} s {interval:10.4} s \
                 {fall:7.4} s  {mean:.3} {:16.4} s",
                run.name,
                rig.ideal_period(run, amplitude)
            );
        }
    }

    let settings = SearchSettings {
        iterations: arguments.count("iterations"),
        starts: arguments.count("starts"),
        ..SearchSettings::default()
    };
    let mut progress = Progress::new("searches", settings.starts);
    let mut start = 0;
    let mut watch = |now: &identify::SearchProgress<'_>| {
        if now.start != start {
            start = now.start;
            progress.step();
        }
        ControlFlow::Continue(())
    };
    let fit = identify::least_squares(&rig, rig.parameters(), &settings, &mut watch)?;
    progress.step();
    let (values, load) = (fit.array::<COUNT>(), mass * GRAVITY);
    println!("\nparameter                value {}", if synthetic { "      truth" } else { "" });
    for (estimate, truth) in fit.estimates.iter().zip(TRUTH) {
        let Parameter { name, unit, least, most, .. } = estimate.parameter;
        let truth = if synthetic { format!("{truth:10.3e}") } else { String::new() };
        let remark = match estimate.verdict {
            _ if least == most => "given".to_owned(),
            verdict @ (Identifiability::AtLowerBound | Identifiability::AtUpperBound) => {
                verdict.to_string()
            }
            _ => String::new(),
        };
        println!("{name:20} {:10.3e} {truth} {unit:7}  {remark}", estimate.value);
    }
    let count = fit.rows - COUNT;
    if count <= COUNT {
        println!(
            "{count} statistics do not tell {COUNT} parameters: the set nearest to the start."
        );
    }

    // Longer, and with a quarter of the step, so that the result does not depend on the search's
    // step.
    let fine = Rig { substeps: 4 * rig.substeps, runs: vec![], unseen: vec![], ..rig };
    let mut table = Csv::create(
        arguments.out_dir(),
        "identify_stick_slip",
        &["run", "speed", "t", "measured", "simulated"],
    )?;
    let count = rig.runs.len() + rig.unseen.len();
    let mut figure = Figure::new(760, 300 * count as u32)
        .title("Friction identified from the statistics of stick-slip")
        .note("Shifted in time to lie on each other: the fit compares statistics, not phases.");
    // Of an oscillation that stops at all: below it no stick-slip lasts.
    let least = |run: &Run| 2.0 * run.speed * (run.stiffness * mass * values[6]).sqrt() / load;
    println!(
        "\n| simulated over measured | spring, speed | amplitude | least that lasts | period \
         | mean | a fall |"
    );
    let share = if rig.mass_factor > 1.0 { "moving mass free" } else { "mass given" };
    for (place, run) in rig.runs.iter().chain(&rig.unseen).enumerate() {
        let (fitted, measured) = (place < rig.runs.len(), &run.measured);
        let rig_run = [run.speed, run.stiffness];
        let force = fine.simulate(&values, rig_run, measured.mean, 3.0 * rig.duration(run))?;
        let simulated = statistics(&force, rig.threshold, row);
        println!(
            "| {:?}, {share} | {}{} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} |",
            rig.model,
            run.name.trim(),
            if fitted { "" } else { ", predicted" },
            simulated.amplitude / measured.amplitude,
            least(run) / measured.amplitude,
            simulated.period / measured.period,
            simulated.mean / measured.mean,
            simulated.fall / measured.fall
        );
        let time = |place: usize| place as f64 * row;
        for (place, (&data, &model)) in run.force.iter().zip(&force).enumerate() {
            table.row(&[&run.name], &[run.speed, time(place), data, model])?;
        }
        // The simulation begins where it fits the first second best, within a period.
        let second = &run.force[..run.force.len().min((1.0 / row) as usize)];
        let off = |start: usize| -> f64 {
            second.iter().zip(&force[start..]).map(|(data, model)| (data - model).powi(2)).sum()
        };
        let starts = 0..(measured.period / row) as usize;
        let start = starts.min_by(|&a, &b| off(a).total_cmp(&off(b))).unwrap_or(0);
        let line = |force: &[f64]| -> Vec<(f64, f64)> {
            force.iter().enumerate().map(|(i, &f)| (time(i), f)).take_while(|p| p.0 < 1.0).collect()
        };
        let data = if synthetic { "made: simulated with known parameters" } else { "measured" };
        let model = line(&force[start..]);
        figure = figure.panel(
            Panel::new("time t (s)", "spring force over load F/p (–)")
                .title(format!(
                    "spring of {:.0} N/m, pulled at {:.2} mm/s{}",
                    run.stiffness,
                    1e3 * run.speed,
                    if fitted { "" } else { ", predicted" }
                ))
                .line(data, Colour::Orange.width(4.0), line(&run.force))
                .line("simulated with what was fitted", Colour::Blue.width(1.2), model),
        );
    }
    table.finish()?;
    println!("\nrmse {:.4} of statistics and starts; {}", fit.rmse, fit.outcome);
    println!("\n{}", figure.save(arguments.out_dir(), "identify_stick_slip")?.display());
    Ok(())
}
