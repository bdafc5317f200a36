//! The classical experiments on friction, with every model: break-away over the rate of the force,
//! loops that turn before they close, load cycles, frictional lag, stick-slip.
//!
//! All models have the curve and the bristle of Table 2 of Romano et al.; a mass of 1 kg under 1 N.
//!
//! Leaves `experiments.csv` and `experiments.svg`, and prints the tables of `docs/experiments.md`.

use std::process::ExitCode;

use bristle::companion::{Companion, PointMass, Prediction, VelocityHistory};
use bristle::curve::{FrictionCurve, Stribeck};
use bristle::nalgebra::{SVector, Vector3};
use bristle::ode::{self, Output, System};
use bristle::rheology::{Deflection, KelvinVoigt};
use bristle::{
    Affine, Branch, Bristle, Contact, Dahl, DahlParameters, ElastoPlastic, FrBd, ImplicitBristle,
    LuGre, Surface, paper,
};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Result, Stroke, println};
use bristle_memory::{Element, MaxwellSlip, MaxwellSlipParameters, Parallel};

/// Static friction coefficient: breakaway in slow motion.
const STATIC: f64 = paper::STICK_SLIP_CURVE.static_coefficient;
const STIFFNESS: f64 = paper::STICK_SLIP_BRISTLE.micro_stiffness;
/// Rates of the force [N/s].
const RATES: [f64; 5] = [0.1, 1.0, 5.0, 10.0, 20.0];
/// Least and greatest force of a load cycle over breakaway [–].
const CYCLE: [f64; 2] = [0.1, 0.45];
const CYCLES: usize = 20;
/// Steps of the mass [s]: its period on the bristles is 63 ms.
const STEP: f64 = 1e-4;

#[path = "experiments/numerics.rs"]
mod numerics;

type Points = Vec<(f64, f64)>;

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let about = "The classical experiments on friction, with every model";
        let arguments = Arguments::new("experiments", about).parse()?;
        let measured = all()?;
        let columns = ["experiment", "model", "x", "y"];
        let mut table = Csv::create(arguments.out_dir(), "experiments", &columns)?;
        for it in &measured {
            for (name, points) in ["break-away", "loop", "cycles", "lag", "stick-slip"]
                .iter()
                .zip([&it.break_away, &it.minor_loop, &it.cycles, &it.lag, &it.stick_slip])
            {
                points.iter().try_for_each(|&(x, y)| table.row(&[name, it.name], &[x, y]))?;
            }
        }
        print(&measured);
        let steps = numerics::fixed_steps()?;
        for (name, _, points) in &steps {
            points.iter().try_for_each(|&(x, y)| table.row(&["steps", name], &[x, y]))?;
        }
        table.finish()?;
        numerics::costs()?;
        println!(
            "\n{}",
            chart(measured, steps).save(arguments.out_dir(), "experiments")?.display()
        );
        Ok(())
    })
}

fn curve() -> Result<Stribeck<f64>> {
    Ok(Stribeck::new(paper::STICK_SLIP_CURVE)?)
}

fn bristle() -> Result<KelvinVoigt<f64>> {
    Ok(KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?)
}

fn dahl() -> Result<Dahl<f64>> {
    Ok(Dahl::new(DahlParameters { dynamic_coefficient: STATIC, micro_stiffness: STIFFNESS })?)
}

/// Its stick limit is half the deflection of breakaway.
fn elasto_plastic() -> Result<ElastoPlastic<Stribeck<f64>, KelvinVoigt<f64>>> {
    Ok(ElastoPlastic::new(curve()?, bristle()?, 0.5 * STATIC / STIFFNESS)?)
}

/// Ten equal springs that yield at (i + ½)/10 · 2μ/σ0.
fn ten(stick_ratio: f64) -> Result<MaxwellSlip<Stribeck<f64>, f64, 10>> {
    let elements = core::array::from_fn(|i| Element {
        stiffness: STIFFNESS / 10.0,
        yield_length: (i as f64 + 0.5) / 5.0 * STATIC / STIFFNESS,
    });
    let micro_damping = paper::STICK_SLIP_BRISTLE.micro_damping;
    let parameters =
        MaxwellSlipParameters { curve: curve()?, elements, micro_damping, stick_ratio };
    Ok(MaxwellSlip::new(parameters)?)
}

/// No bristle: the curve with a smoothed sign, F/p = μ(v) v/√(v² + ε).
#[derive(Debug, Clone)]
struct Static(Stribeck<f64>);

impl Static {
    /// √ε [m/s]
    const WIDTH: f64 = 1e-4;
}

impl Bristle<f64> for Static {
    type Deflection = f64;

    fn affine(&self, surface: Surface<f64>, _: f64) -> Affine<f64> {
        let damping = surface.friction(&self.0) / surface.velocity().hypot(Self::WIDTH);
        Affine { relaxation: 0.0, drive: 0.0, stiffness: 0.0, damping }
    }

    fn affine_and_slopes(&self, surface: Surface<f64>, z: f64) -> (Affine<f64>, Affine<f64>) {
        let (mu, slope) = surface.friction_and_slope(&self.0);
        let (v, root) = (surface.velocity(), surface.velocity().hypot(Self::WIDTH));
        let damping = (slope - mu * v / (root * root)) / root;
        let none = Affine { relaxation: 0.0, drive: 0.0, stiffness: 0.0, damping };
        (self.affine(surface, z), none)
    }

    fn stationary(&self, _: impl Into<Surface<f64>>) -> f64 {
        0.0
    }

    fn storage_stiffness(&self) -> f64 {
        0.0
    }
}

/// What the experiments measured with a model.
struct Measured {
    name: &'static str,
    stroke: Stroke,
    /// Peak of the friction force [N] over the rate of the force [N/s].
    break_away: Points,
    /// Force [N] over position [µm], 0 → 180 → 90 → 180 µm.
    minor_loop: Points,
    /// Force after that loop less the force before it, and the forces before and after 50 loops
    /// 120 → 90 → 120 µm, over breakaway.
    memory: [f64; 3],
    /// Position [µm] at the end of each load cycle.
    cycles: Points,
    /// Force [N] over velocity [mm/s] at 25 Hz.
    lag: Points,
    /// Force of the rising velocity less that of the falling one [N], at 5.5 mm/s, 25 and 100 Hz.
    lags: [f64; 2],
    /// Force of the spring [N] over time [s].
    stick_slip: Points,
    /// Period \[s\], least and greatest force of the spring [N] of settled stick-slip.
    limit_cycle: Option<[f64; 3]>,
}

fn all() -> Result<Vec<Measured>> {
    let (curve, bristle) = (curve()?, bristle()?);
    Ok(vec![
        measure("static curve", Colour::Grey.into(), Static(curve))?,
        measure("Dahl", Colour::Orange.dashed(), dahl()?)?,
        measure("LuGre", Colour::Green.dashed(), LuGre::classical(curve, bristle))?,
        measure("FrBD", Colour::Blue.into(), FrBd::new(curve, bristle))?,
        measure("implicit", Colour::Black.dotted(), ImplicitBristle::new(curve, bristle)?)?,
        measure("elasto-plastic", Colour::Purple.into(), elasto_plastic()?)?,
        measure("ten elements", Colour::Vermilion.into(), ten(0.95)?)?,
    ])
}

fn measure<M: Bristle<f64>>(name: &'static str, stroke: Stroke, model: M) -> Result<Measured> {
    let break_away: Result<Points> =
        RATES.iter().map(|&rate| Ok((rate, break_away(&model, rate, 0.0)?))).collect();
    let mut minor_loop = vec![(0.0, 0.0)];
    let ends = along(&model, &[0.0, 180.0, 90.0, 180.0], &mut minor_loop);
    let fifty = [&[0.0, 120.0][..], &[90.0, 120.0].repeat(50)].concat();
    let fifty = along(&model, &fifty, &mut Points::new());
    let (lag, slow) = lag(&model, 25.0);
    let (stick_slip, limit_cycle) = stick_slip(&model)?;
    Ok(Measured {
        name,
        stroke,
        break_away: break_away?,
        minor_loop,
        memory: [ends[2] - ends[0], fifty[0], fifty[100]].map(|force| force / STATIC),
        cycles: cycles(&model)?,
        lag,
        lags: [slow, lag_of(&model, 100.0)],
        stick_slip,
        limit_cycle,
    })
}

/// A mass of 1 kg on a surface, in companion steps of second order.
struct Block<M: Bristle<f64>> {
    joint: Companion<f64, M>,
    x: f64,
    v: f64,
    z: M::Deflection,
    history: VelocityHistory<f64>,
}

impl<M: Bristle<f64>> Block<M> {
    fn new(model: &M) -> Result<Self> {
        let (z, history) = (M::Deflection::fill(0.0), VelocityHistory::new(0.0));
        let joint = model.clone().under_load(1.0)?.companion(1.0)?;
        Ok(Self { joint, x: 0.0, v: 0.0, z, history })
    }

    /// A step under the mean force \[N\]; returns the friction force at its end.
    fn step(&mut self, force: f64, h: f64) -> f64 {
        let velocity = self.history.predict();
        let middle = self.z + self.joint.contact().rate(velocity, self.z) * (0.5 * h);
        let step = self.joint.step_about(Prediction { velocity, deflection: middle }, self.z, h);
        let body = PointMass { mass: 1.0, velocity: self.v, force, end_weight: 0.5 };
        let mean = step.point_mass(body);
        (self.x, self.v) = (self.x + h * mean, 2.0 * mean - self.v);
        self.z = step.commit(mean).deflection;
        self.history.push(self.v);
        self.joint.contact().force(self.v, self.z)
    }
}

/// Canudas de Wit and others: the peak of the friction force \[N\] while a force rises, after a
/// `dwell` \[s\] under half of breakaway.
fn break_away<M: Bristle<f64>>(model: &M, rate: f64, dwell: f64) -> Result<f64> {
    let (mut block, mut peak, mut n) = (Block::new(model)?, 0.0_f64, 0.0);
    for n in 0..(dwell / STEP) as usize {
        block.step(0.5 * STATIC * (n as f64 * STEP).min(1.0), STEP);
    }
    let from = if dwell > 0.0 { 0.5 * STATIC } else { 0.0 };
    while block.v < 0.2 {
        peak = peak.max(block.step(from + rate * STEP * (n + 0.5), STEP));
        n += 1.0;
    }
    Ok(peak)
}

/// Swevers and others, Al-Bender and others: slow motion through displacements [µm]; the force
/// \[N\] at each.
fn along<M: Bristle<f64>>(model: &M, places: &[f64], points: &mut Points) -> Vec<f64> {
    let mut z = M::Deflection::fill(0.0);
    let leg = |leg: &[f64]| {
        // 0.1 µm in 1 s
        let count = ((leg[1] - leg[0]).abs() * 10.0).round();
        let mut force = 0.0;
        for n in 1..=count as usize {
            let held = model.hold(1e-6 * (leg[1] - leg[0]) / count, z, 1.0);
            (z, force) = (held.deflection, held.end_coefficient);
            points.push((leg[0] + (leg[1] - leg[0]) * n as f64 / count, force));
        }
        force
    };
    places.windows(2).map(leg).collect()
}

/// Dupont and others: the position [µm] after each cycle of a force between two that are below
/// breakaway, of 10 s each.
fn cycles<M: Bristle<f64>>(model: &M) -> Result<Points> {
    let mut block = Block::new(model)?;
    let [least, greatest] = CYCLE.map(|share| share * STATIC);
    let count = 10_000;
    let mut points = Points::new();
    for cycle in 0..=CYCLES {
        for n in 0..count {
            let phase = (n as f64 + 0.5) / count as f64;
            // The first cycle only loads.
            let rise =
                if cycle == 0 { phase } else { (std::f64::consts::PI * phase).sin().powi(2) };
            let from = if cycle == 0 { 0.0 } else { least };
            let to = if cycle == 0 { least } else { greatest };
            block.step(from + (to - from) * rise, 10.0 / count as f64);
        }
        points.push((cycle as f64, 1e6 * block.x));
    }
    let start = points[0].1;
    Ok(points.into_iter().map(|(cycle, x)| (cycle, x - start)).collect())
}

/// Hess and Soom: 5.5 ± 5 mm/s at a frequency [Hz], the last period of half a second; force \[N\]
/// over velocity [mm/s], and the force at 5.5 mm/s of the rising velocity less that of the falling
/// one.
fn lag<M: Bristle<f64>>(model: &M, frequency: f64) -> (Points, f64) {
    let (count, settle) = (4_000, (0.5 * frequency) as usize);
    let v = |n: f64| 5.5e-3 + 5e-3 * (std::f64::consts::TAU * n / f64::from(count)).sin();
    let h = 1.0 / (frequency * f64::from(count));
    let (mut z, mut points) = (model.stationary(5.5e-3), Points::new());
    for n in 0..settle as i32 * count {
        z = model.hold(v(f64::from(n % count) + 0.5), z, h).deflection;
        if n >= (settle as i32 - 1) * count {
            let v = v(f64::from(n % count) + 1.0);
            points.push((1e3 * v, model.coefficient(v, z)));
        }
    }
    let width = points[count as usize - 1].1 - points[count as usize / 2 - 1].1;
    (points, width)
}

fn lag_of<M: Bristle<f64>>(model: &M, frequency: f64) -> f64 {
    lag(model, frequency).1
}

/// Force \[N\] of the spring over time, and period, least and greatest force of the settled cycle.
type StickSlip = (Points, Option<[f64; 3]>);

/// Rabinowicz: a mass of 1 kg on a spring of 2 N/m whose end moves at 0.1 m/s.
fn stick_slip<M: Bristle<f64>>(model: &M) -> Result<StickSlip> {
    let (mut block, mut points, mut turns) = (Block::new(model)?, Points::new(), Vec::new());
    let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
    for n in 0..600_000 {
        let t = f64::from(n) * STEP;
        let (before, place) = (block.v, block.x + 0.5 * STEP * block.v);
        let force = 2.0 * (0.1 * (t + 0.5 * STEP) - place);
        block.step(force, STEP);
        if n % 500 == 0 {
            points.push((t, force));
        }
        // The spring is longest where the mass becomes as fast as its end.
        if before < 0.1 && block.v >= 0.1 {
            turns.push(t + STEP * (0.1 - before) / (block.v - before));
            (least, greatest) = if turns.len() == 4 { (force, force) } else { (least, greatest) };
        }
        (least, greatest) = (least.min(force), greatest.max(force));
    }
    // Settled after the third; without stick-slip the oscillation fades.
    let slips = greatest - least > 0.1 && turns.len() > 5;
    let last = turns.len().saturating_sub(1);
    let cycle = slips.then(|| [(turns[last] - turns[3]) / (last - 3) as f64, least, greatest]);
    Ok((points, cycle))
}

fn print(measured: &[Measured]) {
    println!("break-away at the rates {RATES:?} N/s; drift per load cycle; lag; stick-slip");
    for it in measured {
        let peaks = it.break_away.iter().map(|it| format!("{:.5}", it.1)).collect::<Vec<_>>();
        let drift = it.cycles[CYCLES].1 - it.cycles[CYCLES - 1].1;
        let [miss, before, after] = it.memory;
        let [slow, fast] = it.lags.map(|lag| 1e3 * lag);
        println!(
            "{:14} {}  miss {miss:.4}, 50 loops {before:.3} -> {after:.3}  drift {drift:.4} um  \
             lag {slow:.1} {fast:.1} mN  {:.5?}",
            it.name,
            peaks.join(" "),
            it.limit_cycle
        );
    }
}

fn chart(measured: Vec<Measured>, steps: Vec<(&'static str, Stroke, Points)>) -> Figure {
    let panels = [
        Panel::new("rate of the force (N/s)", "peak of the friction force (N)")
            .title("Break-away")
            .log_x(),
        Panel::new("displacement x (µm)", "friction force F (N)").title("A loop that turns early"),
        Panel::new("load cycles, 0.15 … 0.675 N", "position (µm)")
            .title("Load cycles")
            .y_range(-20.0..=700.0),
        Panel::new("sliding velocity v (mm/s)", "friction force F (N)")
            .title("Frictional lag, 25 Hz")
            .y_range(0.9..=1.6),
        Panel::new("time t (s)", "force of the spring (N)").title("Stick-slip").x_range(0.0..=25.0),
    ];
    let mut panels = panels.into_iter().enumerate().map(|(i, panel)| {
        measured.iter().fold(panel, |panel, it| {
            let points = match i {
                0 => &it.break_away,
                1 => &it.minor_loop,
                2 => &it.cycles,
                3 => &it.lag,
                _ => &it.stick_slip,
            };
            panel.line(it.name, it.stroke, points)
        })
    });
    let figure = Figure::new(980, 1120).columns(2);
    let figure = panels.by_ref().fold(figure, Figure::panel);
    let last = Panel::new("step h (s)", "error of the position (m)")
        .title("Fixed steps on the stick-slip rig")
        .log_x()
        .log_y();
    let last = steps.into_iter().fold(last, |panel, it| panel.line(it.0, it.1, it.2));
    figure.title("The classical experiments, with every model").panel(last)
}

#[cfg(test)]
#[path = "experiments/tests.rs"]
mod tests;
