//! What friction remembers: loops within loops, small loops about a load, the damping of a bolted
//! joint, and what a step costs.
//!
//! Leaves `memory.csv` and `memory.svg`, and prints beside them the work that the elasto-plastic
//! LuGre model, as published, gives in a cycle.

use std::error::Error;
use std::hint::black_box;
use std::process::ExitCode;
use std::time::Instant;

use bristle::curve::{Coulomb, CoulombParameters, FrictionCurve, Stribeck};

use bristle::rheology::{Deflection, KelvinVoigt};
use bristle::{Bristle, Dahl, DahlParameters, FrBd, paper};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, Stroke, println};
use bristle_memory::{Element, MaxwellSlip, MaxwellSlipParameters, Parallel};

/// Stiffness of all elements together [1/m]; the friction coefficient is one.
const STIFFNESS: f64 = 1e4;
/// Length of a step [m].
const STEP: f64 = 5e-8;
/// Exponent χ of the strengths of the elements of a bolted joint, ρ(φ) ∝ φ^χ.
const CHI: f64 = -0.5;

type Points = Vec<(f64, f64)>;

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("memory", "What friction remembers")
            .number("stick-ratio", 0.95, "", "share of its yield length where an element sticks")
            .must_be(Rule::Between(0.01, 0.999))
            .count("cycles", 50, "small loops about a load")
            .parse()?;
        let (ratio, cycles) = (arguments.number("stick-ratio"), arguments.count("cycles"));
        let mut table = Csv::create(arguments.out_dir(), "memory", &["panel", "curve", "x", "y"])?;
        let mut figure = Figure::new(980, 760).title("What friction remembers").columns(2);
        for panel in [
            loops(ratio, &mut table)?,
            drift(ratio, cycles, &mut table)?,
            damping(ratio, &mut table)?,
            cost(&mut table)?,
        ] {
            figure = figure.panel(panel);
        }
        under_force(cycles)?;
        as_published()?;
        table.finish()?;
        println!("\n{}", figure.save(arguments.out_dir(), "memory")?.display());
        Ok(())
    })
}

fn coulomb() -> Result<Coulomb<f64>, Box<dyn Error>> {
    let curve = CoulombParameters { dynamic_coefficient: 1.0, viscous_friction: 0.0 };
    Ok(Coulomb::new(curve)?)
}

fn dahl() -> Result<Dahl<f64>, Box<dyn Error>> {
    Ok(Dahl::new(DahlParameters { dynamic_coefficient: 1.0, micro_stiffness: STIFFNESS })?)
}

type Slip<const N: usize> = MaxwellSlip<Coulomb<f64>, f64, N>;

fn slip<const N: usize>(
    elements: [Element<f64>; N],
    ratio: f64,
) -> Result<Slip<N>, Box<dyn Error>> {
    Ok(MaxwellSlip::new(MaxwellSlipParameters {
        curve: coulomb()?,
        elements,
        micro_damping: 0.0,
        stick_ratio: ratio,
    })?)
}

/// Equal springs whose yield lengths lie evenly up to 2 μ/σ0.
fn even<const N: usize>() -> [Element<f64>; N] {
    core::array::from_fn(|i| Element {
        stiffness: STIFFNESS / N as f64,
        yield_length: (i as f64 + 0.5) / N as f64 * 2.0 / STIFFNESS,
    })
}

/// Force over normal force along a path through given displacements [µm], slowly.
fn along<M: Bristle<f64>>(model: &M, places: &[f64]) -> Points {
    let (mut z, mut points) = (M::Deflection::fill(0.0), vec![(places[0], 0.0)]);
    for leg in places.windows(2) {
        let distance = 1e-6 * (leg[1] - leg[0]);
        let count = (distance.abs() / STEP).round().max(1.0);
        for step in 1..=count as usize {
            let held = model.hold(distance / count, z, 1.0);
            z = held.deflection;
            if step % 10 == 0 {
                let place = leg[0] + 1e6 * distance * step as f64 / count;
                points.push((place, held.end_coefficient));
            }
        }
    }
    points
}

/// The same with elements of sharp yield.
fn sharply<const N: usize>(model: &Slip<N>, places: &[f64]) -> Points {
    let (mut z, mut points) = (Parallel::default(), vec![(places[0], 0.0)]);
    for leg in places.windows(2) {
        let step = model.sharp_step(0.0, 1e-6 * (leg[1] - leg[0]), z);
        z = step.deflection;
        points.push((leg[1], step.coefficient));
    }
    points
}

fn enter(
    table: &mut Csv,
    panel: &str,
    curve: &str,
    points: &[(f64, f64)],
) -> bristle_charts::Result<()> {
    points.iter().try_for_each(|&(x, y)| table.row(&[panel, curve], &[x, y]))
}

fn loops(ratio: f64, table: &mut Csv) -> bristle_charts::Result<Panel> {
    let path = [0.0, 150.0, -150.0, 120.0, 20.0, 90.0, 50.0, 90.0, 20.0, 150.0];
    let [forgets, remembers] = [along(&dahl()?, &path), along(&slip(even::<10>(), ratio)?, &path)];
    enter(table, "loops", "dahl", &forgets)?;
    enter(table, "loops", "ten_elements", &remembers)?;
    Ok(Panel::new("displacement x (µm)", "force over load F/p (–)")
        .title("Loops within loops")
        .line("Dahl", Colour::Vermilion.dashed(), forgets)
        .line("ten elements", Colour::Blue, remembers)
        .own_legend())
}

/// The force at 80 µm over loops 80 → 60 → 80 µm, and the miss at 120 µm of a loop
/// 120 → 60 → 120 µm.
fn drift(ratio: f64, cycles: usize, table: &mut Csv) -> bristle_charts::Result<Panel> {
    let one = [Element { stiffness: STIFFNESS, yield_length: 1.0 / STIFFNESS }];
    let ten = |ratio| slip(even::<10>(), ratio);
    let mut path = vec![0.0, 80.0];
    path.extend([60.0, 80.0].repeat(cycles));
    let once = [0.0, 120.0, 60.0, 120.0];
    let (dahl, single, half, near) = (dahl()?, slip(one, 0.5)?, ten(0.5)?, ten(ratio)?);
    let label = format!("ten, ρ = {ratio}");
    let runs: [(&str, Stroke, Points, Points); 5] = [
        ("Dahl", Colour::Vermilion.dashed(), along(&dahl, &path), along(&dahl, &once)),
        (
            "one elasto-plastic, ρ = 0.5",
            Colour::Orange.into(),
            along(&single, &path),
            along(&single, &once),
        ),
        ("ten, ρ = 0.5", Colour::Green.into(), along(&half, &path), along(&half, &once)),
        (&label, Colour::Blue.into(), along(&near, &path), along(&near, &once)),
        ("ten sharp", Colour::Black.dotted(), sharply(&near, &path), sharply(&near, &once)),
    ];
    let mut panel = Panel::new("loops 80 → 60 → 80 µm", "F/p at 80 µm (–)")
        .title("Small loops about a load")
        .y_range(0.0..=0.8)
        .own_legend();
    println!("                              miss of a loop   first   after {cycles} loops");
    for (name, stroke, drift, once) in runs {
        let tops = |points: &[(f64, f64)], place: f64| -> Vec<f64> {
            // A path meets the place where a leg ends.
            points.iter().filter(|it| (it.0 - place).abs() < 1e-9).map(|it| it.1).collect()
        };
        let [outer, .., closed] = tops(&once, 120.0)[..] else { return Err("no loop".into()) };
        let tops = tops(&drift, 80.0);
        let last = tops.last().copied().unwrap_or(f64::NAN);
        println!("{name:28}  {:14.4}  {:6.3}  {last:6.3}", closed - outer, tops[0]);
        let points: Points = tops.iter().enumerate().map(|(i, &top)| (i as f64, top)).collect();
        enter(table, "drift", name, &points)?;
        panel = panel.line(name, stroke, points);
    }
    Ok(panel)
}

/// How far [%] loops between two forces carry the place, where the displacement 80 → 60 → 80 µm
/// gave these forces.
fn under_force(cycles: usize) -> bristle_charts::Result<()> {
    let one = [Element { stiffness: STIFFNESS, yield_length: 1.0 / STIFFNESS }];
    println!("\nloops between the forces of 80 and 60 µm: drift after {cycles} [% of 80 µm]");
    println!("Dahl                {:9.1}", creep(&dahl()?, cycles));
    println!("one elasto-plastic  {:9.1}", creep(&slip(one, 0.5)?, cycles));
    for ratio in [0.5, 0.8, 0.95] {
        println!("ten, ρ = {ratio:4}       {:9.1}", creep(&slip(even::<10>(), ratio)?, cycles));
    }
    Ok(())
}

fn creep<M: Bristle<f64>>(model: &M, cycles: usize) -> f64 {
    let path = along(model, &[0.0, 80.0, 60.0]);
    let upper = path.iter().map(|it| it.1).fold(f64::NEG_INFINITY, f64::max);
    let lower = path.last().map_or(0.0, |it| it.1);
    let (mut z, mut place, mut force) = (M::Deflection::fill(0.0), 0.0, 0.0);
    for target in [upper].into_iter().chain([lower, upper].repeat(cycles)) {
        let step = if target > force { STEP } else { -STEP };
        while (target - force) * step > 0.0 {
            let held = model.hold(step, z, 1.0);
            // The last step ends at the force.
            let share = ((target - force) / (held.end_coefficient - force)).min(1.0);
            let held = model.hold(share * step, z, 1.0);
            (z, place) = (held.deflection, place + share * step);
            force = if share < 1.0 { target } else { held.end_coefficient };
        }
    }
    1e2 * (place / 80e-6 - 1.0)
}

/// N elements whose strengths have the density φ^χ up to 100 µm, over two and a half decades.
fn bolted<const N: usize>() -> [Element<f64>; N] {
    let end = |i: usize| 100e-6 * 300_f64.powf(i as f64 / N as f64 - 1.0);
    let power = |x: f64, more: f64| density() * x.powf(CHI + 1.0 + more) / (CHI + 1.0 + more);
    core::array::from_fn(|i| {
        // The first also stands for those below.
        let (low, high) = (if i == 0 { 0.0 } else { end(i) }, end(i + 1));
        let stiffness = power(high, 0.0) - power(low, 0.0);
        Element { stiffness, yield_length: (power(high, 1.0) - power(low, 1.0)) / stiffness }
    })
}

/// R, where the friction coefficient is one: R (100 µm)^(χ+2)/(χ + 2) = 1.
fn density() -> f64 {
    (CHI + 2.0) / 100e-6_f64.powf(CHI + 2.0)
}

/// Work lost in a settled cycle of amplitude X over the limit of many elements,
/// D = 4 R X^(χ+3)/((χ + 2)(χ + 3)).
fn damping(ratio: f64, table: &mut Csv) -> bristle_charts::Result<Panel> {
    let amplitudes: Vec<f64> = (0..=32).map(|i| 10_f64.powf(f64::from(i) / 16.0)).collect();
    let law = |amplitude: f64| {
        let power = (1e-6 * amplitude).powf(CHI + 3.0);
        4.0 * density() * power / ((CHI + 2.0) * (CHI + 3.0))
    };
    let exact: Points = amplitudes.iter().map(|&x| (x, law(x))).collect();
    enter(table, "damping", "power law", &exact)?;
    let mut panel = Panel::new("amplitude X (µm)", "work lost a cycle, over p (m)")
        .title("A bolted joint")
        .log_x()
        .log_y()
        .line("X^2.5", Colour::Black.dotted(), exact)
        .own_legend();
    println!("\nelements   exponent of the damping (law: {})   largest error", CHI + 3.0);
    panel = joint::<4>(panel, Colour::Orange, ratio, &amplitudes, &law, table)?;
    panel = joint::<8>(panel, Colour::Green, ratio, &amplitudes, &law, table)?;
    joint::<16>(panel, Colour::Blue, ratio, &amplitudes, &law, table)
}

fn joint<const N: usize>(
    panel: Panel,
    colour: Colour,
    ratio: f64,
    amplitudes: &[f64],
    law: &impl Fn(f64) -> f64,
    table: &mut Csv,
) -> bristle_charts::Result<Panel> {
    let model = slip(bolted::<N>(), ratio)?;
    let points: Points = amplitudes.iter().map(|&x| (x, loss(&model, x))).collect();
    let off = points.iter().map(|&(x, loss)| (loss / law(x) - 1.0).abs()).fold(0.0, f64::max);
    // By least squares over the decades.
    let logs: Points = points.iter().map(|&(x, loss)| (x.ln(), loss.ln())).collect();
    let count = logs.len() as f64;
    let [mean_x, mean_y] = [
        logs.iter().map(|it| it.0).sum::<f64>() / count,
        logs.iter().map(|it| it.1).sum::<f64>() / count,
    ];
    let slope = logs.iter().map(|it| (it.0 - mean_x) * (it.1 - mean_y)).sum::<f64>()
        / logs.iter().map(|it| (it.0 - mean_x).powi(2)).sum::<f64>();
    println!("{N:8}   {slope:6.3}                                  {:5.1} %", 1e2 * off);
    let name = format!("{N} elements");
    enter(table, "damping", &name, &points)?;
    Ok(panel.line(name, colour, points))
}

/// The work of a settled cycle, in 400 steps a leg.
fn loss<const N: usize>(model: &Slip<N>, amplitude: f64) -> f64 {
    let (mut z, mut work) = (Parallel::default(), 0.0);
    for leg in 0..7 {
        let step = if leg % 2 == 0 { 2e-6 } else { -2e-6 } * amplitude / 400.0;
        for _ in 0..if leg == 0 { 200 } else { 400 } {
            let held = model.hold(step, z, 1.0);
            z = held.deflection;
            work += if leg > 4 { held.mean_coefficient * step } else { 0.0 };
        }
    }
    work
}

/// A companion step with its end, over that of FrBD with one spring, in the same run.
fn cost(table: &mut Csv) -> bristle_charts::Result<Panel> {
    let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
    let base = time(FrBd::new(stribeck()?, bristle))?;
    let points = vec![
        (1.0, time(moving::<1>()?)? / base),
        (2.0, time(moving::<2>()?)? / base),
        (4.0, time(moving::<4>()?)? / base),
        (8.0, time(moving::<8>()?)? / base),
        (16.0, time(moving::<16>()?)? / base),
        (24.0, time(moving::<24>()?)? / base),
    ];
    println!("\nelements   time of a step over FrBD's ({:.0} ns)", 1e9 * base);
    for (count, times) in &points {
        println!("{count:8}   {times:5.1}");
    }
    enter(table, "cost", "companion step", &points)?;
    Ok(Panel::new("elements N", "time of a step, FrBD = 1 (–)")
        .title("Cost")
        .y_range(0.0..=points.iter().fold(1.0, |most, it| it.1.max(most)) * 1.1)
        .marked_line("", Colour::Blue, Colour::Blue, points))
}

fn stribeck() -> Result<Stribeck<f64>, Box<dyn Error>> {
    Ok(Stribeck::new(paper::STICK_SLIP_CURVE)?)
}

fn moving<const N: usize>() -> Result<MaxwellSlip<Stribeck<f64>, f64, N>, Box<dyn Error>> {
    Ok(MaxwellSlip::new(MaxwellSlipParameters {
        curve: stribeck()?,
        elements: even::<N>(),
        micro_damping: paper::STICK_SLIP_BRISTLE.micro_damping,
        stick_ratio: 0.95,
    })?)
}

/// The least of eleven runs \[s\].
fn time<M: Bristle<f64>>(model: M) -> Result<f64, Box<dyn Error>> {
    let joint = model.under_load(1.0)?.companion(0.1)?;
    let count = 20_000;
    let mut least = f64::INFINITY;
    for _ in 0..11 {
        let (mut z, start) = (M::Deflection::fill(0.0), Instant::now());
        for step in 0..count {
            let velocity = if step % 1000 < 500 { 1e-3 } else { -1e-3 };
            z = joint.step(black_box(velocity), z, 1e-3).commit(velocity).deflection;
        }
        black_box(z);
        least = least.min(start.elapsed().as_secs_f64() / f64::from(count));
    }
    Ok(least)
}

/// Work over a cycle of 1 mm/s over 1.5 mm and 10 m/s over 0.1 mm under 1 N: of the elasto-plastic
/// LuGre model as published, ż = v (1 − α z/z_ss), F = σ0 z + σ1 ż + σ2 v, and of one element.
fn as_published() -> bristle_charts::Result<()> {
    let (curve, bristle) = (stribeck()?, paper::STICK_SLIP_BRISTLE);
    let (sigma0, sigma1) = (bristle.micro_stiffness, bristle.micro_damping);
    let sigma2 = paper::STICK_SLIP_CURVE.viscous_friction;
    let (dry, ratio) = (curve.without_viscous_friction(), 0.5);
    // A constant stick limit has to stay below the least z_ss.
    let stick_limit = ratio * dry.bounds(10.0).min / sigma0;
    let rate = |v: f64, z: f64| {
        let full = dry.at(v) / sigma0;
        let share = ((z.abs() - stick_limit) / (full - stick_limit)).clamp(0.0, 1.0);
        let alpha =
            if v * z > 0.0 { (std::f64::consts::FRAC_PI_2 * share).sin().powi(2) } else { 0.0 };
        v - alpha * v.abs() * z / full
    };
    let one = [Element { stiffness: sigma0, yield_length: 1.0 / sigma0 }];
    let ours = MaxwellSlip::new(MaxwellSlipParameters {
        curve,
        elements: one,
        micro_damping: sigma1,
        stick_ratio: ratio,
    })?;
    let (mut z, mut x) = (1e-4, ours.stationary(1e-3));
    let mut work = [0.0; 2];
    for _ in 0..20 {
        work = [0.0; 2];
        for (v, distance) in [(1e-3, 1.5e-3), (10.0, 1e-4)] {
            let count = 50_000;
            let h = distance / v / f64::from(count);
            for _ in 0..count {
                let middle = z + 0.5 * h * rate(v, z);
                let middle_rate = rate(v, middle);
                z += h * middle_rate;
                work[0] += h * v * (sigma0 * middle + sigma1 * middle_rate + sigma2 * v);
                let held = ours.hold(v, x, h);
                x = held.deflection;
                work[1] += h * v * held.mean_coefficient;
            }
        }
    }
    println!("\nwork of a cycle, 1 mm/s over 1.5 mm and 10 m/s over 0.1 mm, under 1 N:");
    println!(
        "elasto-plastic LuGre as published {:+.3e} J, one element {:+.3e} J",
        work[0], work[1]
    );
    Ok(())
}
