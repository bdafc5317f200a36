//! What single precision costs: every result in `f32` beside the same in `f64`, from the same
//! numbers.
//!
//! The parameters are rounded to `f32` for both, so that what differs is the arithmetic alone.
//! Velocities run from the smallest subnormal to 1 km/s, λh from 1e-12 to 1e6; then a million steps
//! of a millisecond. Leaves `precision.csv` and `precision.svg`.

use std::process::ExitCode;

use bristle::companion::Companion;
use bristle::curve::{
    Cubic, FrictionCurve, Knot, RationalStribeck, RationalStribeckParameters, Stribeck,
    StribeckParameters, Tabulated,
};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, Contact, Dahl, DahlParameters, FrBd, LuGre, ParameterError, Scalar, paper};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Progress, Rule, Stroke, println};

/// Rounded to single precision, in either type.
fn lit<T: Scalar>(value: f64) -> T {
    nalgebra::convert(f64::from(value as f32))
}

fn wide(value: f32) -> f64 {
    f64::from(value)
}

/// A curve's numbers, and a bristle's.
#[derive(Clone, Copy)]
struct Set {
    name: &'static str,
    curve: StribeckParameters<f64>,
    bristle: KelvinVoigtParameters<f64>,
}

const SETS: [Set; 2] = [
    Set { name: "Table 2", curve: paper::STICK_SLIP_CURVE, bristle: paper::STICK_SLIP_BRISTLE },
    Set { name: "valve", curve: paper::VALVE_CURVE, bristle: paper::VALVE_BRISTLE },
];

impl Set {
    fn stribeck<T: Scalar>(&self) -> Result<Stribeck<T>, ParameterError> {
        Stribeck::new(StribeckParameters {
            static_coefficient: lit(self.curve.static_coefficient),
            dynamic_coefficient: lit(self.curve.dynamic_coefficient),
            stribeck_velocity: lit(self.curve.stribeck_velocity),
            stribeck_exponent: lit(self.curve.stribeck_exponent),
            viscous_friction: lit(self.curve.viscous_friction),
        })
    }

    fn rational<T: Scalar>(&self) -> Result<RationalStribeck<T>, ParameterError> {
        RationalStribeck::new(RationalStribeckParameters {
            static_coefficient: lit(self.curve.static_coefficient),
            dynamic_coefficient: lit(self.curve.dynamic_coefficient),
            stribeck_velocity: lit(self.curve.stribeck_velocity),
            viscous_friction: lit(self.curve.viscous_friction),
        })
    }

    fn tabulated<T: Scalar>(&self) -> Result<Tabulated<[Cubic<T>; 8]>, ParameterError> {
        let curve = self.stribeck::<f64>()?;
        let knot = |part: f64| {
            let speed = part * self.curve.stribeck_velocity;
            Knot { speed: lit(speed), coefficient: lit(curve.at(speed)) }
        };
        Tabulated::new([0.0, 0.4, 0.7, 1.1, 1.6, 2.3, 5.0, 100.0].map(knot))
    }

    fn bristle<T: Scalar>(&self) -> Result<KelvinVoigt<T>, ParameterError> {
        KelvinVoigt::new(KelvinVoigtParameters {
            micro_stiffness: lit(self.bristle.micro_stiffness),
            micro_damping: lit(self.bristle.micro_damping),
        })
    }

    fn dahl<T: Scalar>(&self) -> Result<Dahl<T>, ParameterError> {
        Dahl::new(DahlParameters {
            dynamic_coefficient: lit(self.curve.dynamic_coefficient),
            micro_stiffness: lit(self.bristle.micro_stiffness),
        })
    }
}

/// What is compared, and in which part of the larger of the two it is told.
const RESULTS: [&str; 7] = [
    "curve μ",
    "force at a state",
    "held: force at the end",
    "held: mean force",
    "held: deflection",
    "passive: mean force",
    "passive: dissipated energy",
];

/// Errors of all results in units of the rounding 2⁻²⁴, forces as parts of p μ(v).
fn errors<M32, M64>(
    single: &(Contact<f32, M32>, Companion<f32, M32>),
    double: &(Contact<f64, M64>, Companion<f64, M64>),
    (v, z, h): (f32, f32, f32),
) -> [f64; 7]
where
    M32: Bristle<f32, Deflection = f32>,
    M64: Bristle<f64, Deflection = f64>,
{
    let (wv, wz, wh) = (wide(v), wide(z), wide(h));
    let scale = double.0.stationary_force(wv).abs().max(double.0.stationary_force(1e-30).abs());
    let rounding = 0.5 * f64::from(f32::EPSILON);
    let off = |got: f32, want: f64, scale: f64| {
        // Below the normal numbers a few last places of these.
        let least = f64::from(f32::MIN_POSITIVE) / rounding;
        (wide(got) - want).abs() / scale.abs().max(least) / rounding
    };
    let (held, wanted) = (single.0.hold(v, z, h), double.0.hold(wv, wz, wh));
    let passive = single.1.step(v, z, h).commit(v);
    let done = double.1.step(wv, wz, wh).commit(wv);
    let size = |value: f64| value.abs().max(scale);
    let (force, at_state) = (single.0.force(v, z), double.0.force(wv, wz));
    let steady = double.0.stationary_force(wv);
    let energy = double.0.stored_energy(wz).max(done.dissipated.abs()).max(done.work.abs());
    [
        off(single.0.stationary_force(v), steady, steady),
        off(force, at_state, size(at_state)),
        off(held.end_force, wanted.end_force, size(wanted.end_force)),
        off(held.mean_force, wanted.mean_force, size(wanted.mean_force)),
        off(held.deflection, wanted.deflection, wanted.deflection.abs().max(wz.abs())),
        off(passive.force, done.force, size(done.force)),
        off(passive.dissipated, done.dissipated, energy),
    ]
}

/// The worst errors at each λh and at each speed.
struct Scan {
    name: String,
    by_step: Vec<(f64, [f64; 7])>,
    by_speed: Vec<(f64, [f64; 7])>,
}

impl Scan {
    fn worst(&self) -> [f64; 7] {
        let rows = self.by_speed.iter().map(|row| row.1);
        rows.fold([0.0; 7], larger)
    }
}

fn larger(mut a: [f64; 7], b: [f64; 7]) -> [f64; 7] {
    for (a, b) in a.iter_mut().zip(b) {
        *a = if b > *a || b.is_nan() { b } else { *a };
    }
    a
}

fn scan<M32, M64>(
    name: String,
    (single, double): (M32, M64),
    density: usize,
) -> Result<Scan, ParameterError>
where
    M32: Bristle<f32, Deflection = f32>,
    M64: Bristle<f64, Deflection = f64>,
{
    let (single, double) = (single.under_load(8.0)?, double.under_load(8.0)?);
    let both = (single.clone(), single.companion(1e3)?);
    let wide_both = (double.clone(), double.clone().companion(1e3)?);
    let bins = 18;
    let mut by_step: Vec<_> = (0..bins).map(|bin| (10f64.powi(bin - 12), [0.0; 7])).collect();
    let mut by_speed = Vec::new();
    for number in 0..=48 * density {
        // From the smallest subnormal, 1.4e-45 m/s, to 1e3 m/s.
        let speed = (10f64.powf(-45.0 + number as f64 / density as f64) as f32).max(1e-45);
        let mut worst = [0.0; 7];
        for velocity in [speed, -speed] {
            let rate = double.model().affine(wide(velocity).into(), 0.0).relaxation;
            for part in [-1.0, -0.3, 0.0, 0.5, 0.99, 1.0] {
                let z = (double.stationary(wide(speed)) * part) as f32;
                for exponent in 0..bins as usize * density {
                    let x = 10f64.powf(-12.0 + exponent as f64 / density as f64);
                    // Of some time between a nanosecond and a day.
                    let h = (x / rate).clamp(1e-9, 1e5) as f32;
                    let found = errors(&both, &wide_both, (velocity, z, h));
                    worst = larger(worst, found);
                    let x = (rate * wide(h)).log10() + 12.0;
                    if (0.0..18.0).contains(&x) {
                        let row = &mut by_step[x as usize].1;
                        *row = larger(*row, found);
                    }
                }
            }
        }
        by_speed.push((wide(speed), worst));
    }
    Ok(Scan { name, by_step, by_speed })
}

/// A million steps of 1 ms: the largest error of the force in parts of p μ_s, in the first and in
/// the last tenth of the run.
fn run<M32, M64>(
    models: (M32, M64),
    stribeck: f64,
    steps: usize,
) -> Result<[f64; 4], ParameterError>
where
    M32: Bristle<f32, Deflection = f32>,
    M64: Bristle<f64, Deflection = f64>,
{
    let (single, double) = (models.0.under_load(1.0)?, models.1.under_load(1.0)?);
    let (passive, wide_passive) = (single.clone().companion(1.0)?, double.clone().companion(1.0)?);
    let most = double.stationary_force(1e-30);
    let (mut z, mut wz, mut y, mut wy) = (0.0_f32, 0.0, 0.0_f32, 0.0);
    let mut worst = [0.0_f64; 4];
    for number in 0..steps {
        // Back and forth at 0.5 Hz through the Stribeck range, and creep in between.
        let t = 1e-3 * number as f64;
        let swing = (std::f64::consts::PI * t).sin();
        let size = if (t * 0.05).fract() < 0.5 { 5.0 } else { 1e-3 };
        let v = (swing * size * stribeck) as f32;
        let (held, wanted) = (single.hold(v, z, 1e-3), double.hold(wide(v), wz, wide(1e-3_f32)));
        (z, wz) = (held.deflection, wanted.deflection);
        let done = passive.step(v, y, 1e-3).commit(v);
        let wide_done = wide_passive.step(wide(v), wy, wide(1e-3_f32)).commit(wide(v));
        (y, wy) = (done.deflection, wide_done.deflection);
        let late = if number < steps / 10 { 0 } else { 1 };
        if number < steps / 10 || number >= steps - steps / 10 {
            let off = [(held.mean_force, wanted.mean_force), (done.force, wide_done.force)];
            for (place, (got, want)) in off.into_iter().enumerate() {
                let slot = &mut worst[2 * place + late];
                *slot = slot.max((wide(got) - want).abs() / most);
            }
        }
    }
    Ok(worst)
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("precision", "Single precision beside double precision")
            .count("density", 4, "velocities, and steps, per decade")
            .must_be(Rule::Between(1.0, 100.0))
            .count("steps", 1_000_000, "steps of the long runs")
            .must_be(Rule::Between(10.0, 1e9))
            .parse()?;
        let (density, steps) = (arguments.count("density"), arguments.count("steps"));

        let mut scans = Vec::new();
        let mut runs = Vec::new();
        let mut progress = Progress::new("models", 5 * SETS.len());
        for set in SETS {
            macro_rules! both {
                ($name:literal, $of:expr) => {{
                    fn of<T: Scalar>(
                        set: &Set,
                    ) -> Result<impl Bristle<T, Deflection = T>, ParameterError> {
                        let build: fn(&Set) -> _ = $of;
                        build(set)
                    }
                    let name = format!("{}, {}", $name, set.name);
                    scans.push(scan(name.clone(), (of::<f32>(&set)?, of::<f64>(&set)?), density)?);
                    let models = (of::<f32>(&set)?, of::<f64>(&set)?);
                    runs.push((name, run(models, set.curve.stribeck_velocity, steps)?));
                    progress.step();
                }};
            }
            both!("FrBD", |set| Ok(FrBd::new(set.stribeck::<T>()?, set.bristle::<T>()?)));
            both!("FrBD rational", |set| Ok(FrBd::new(set.rational::<T>()?, set.bristle::<T>()?)));
            both!("FrBD tabulated", |set| Ok(FrBd::new(
                set.tabulated::<T>()?,
                set.bristle::<T>()?
            )));
            both!("LuGre", |set| Ok(LuGre::classical(set.stribeck::<T>()?, set.bristle::<T>()?)));
            both!("Dahl", |set| set.dahl::<T>());
        }

        let mut columns = vec!["model", "over", "at"];
        columns.extend(RESULTS);
        let mut table = Csv::create(arguments.out_dir(), "precision", &columns)?;
        println!(
            "Largest errors in roundings (2⁻²⁴ = 6e-8), of p μ for forces and of W for energies."
        );
        println!();
        println!("| | {} |", RESULTS.join(" | "));
        println!("|---|{}", "---|".repeat(RESULTS.len()));
        for scan in &scans {
            let cells = scan.worst().map(|worst| format!("{worst:.1}"));
            println!("| {} | {} |", scan.name, cells.join(" | "));
        }
        for scan in &scans {
            for (over, rows) in [("λh", &scan.by_step), ("|v|", &scan.by_speed)] {
                for (at, errors) in rows {
                    let mut row = vec![*at];
                    row.extend(errors);
                    table.row(&[&scan.name, over], &row)?;
                }
            }
        }
        table.finish()?;
        println!();
        println!("Error of the force in p μ_s over {steps} steps of 1 ms, first and last tenth.");
        println!();
        println!("| | held, first | last | passive, first | last |");
        println!("|---|---|---|---|---|");
        for (name, [a, b, c, d]) in &runs {
            println!("| {name} | {a:.1e} | {b:.1e} | {c:.1e} | {d:.1e} |");
        }
        println!();
        println!("{}", chart(&scans).save(arguments.out_dir(), "precision")?.display());
        Ok(())
    })
}

fn chart(scans: &[Scan]) -> Figure {
    // Single errors scatter by their rounding: of every decade the largest is drawn.
    let points = |rows: &[(f64, [f64; 7])], place: usize| -> Vec<(f64, f64)> {
        let decade = |at: f64| (at.log10() + 1e-9).floor();
        rows.chunk_by(|a, b| decade(a.0) == decade(b.0))
            .map(|rows| {
                let largest = rows.iter().fold(0.0, |most: f64, row| most.max(row.1[place]));
                (10f64.powf(decade(rows[0].0) + 0.5), largest)
            })
            .collect()
    };
    let lines: [(usize, &str, Stroke); 4] = [
        (2, "held: force at the end", Colour::Blue.into()),
        (4, "held: deflection", Colour::Green.dashed()),
        (5, "passive: mean force", Colour::Orange.into()),
        (6, "passive: dissipated energy", Colour::Purple.dotted()),
    ];
    let mut figure = Figure::new(900, 470).title("What single precision costs").columns(2);
    let label = "largest error in a decade (roundings)";
    let mut by_step =
        Panel::new("step λh (–)", label).title("FrBD, Table 2, over the step").log_x();
    let mut by_speed =
        Panel::new("speed |v| (m/s)", label).title("FrBD, Table 2, over the speed").log_x();
    for (place, name, stroke) in lines {
        by_step = by_step.line(name, stroke, points(&scans[0].by_step, place));
        by_speed = by_speed.line(name, stroke, points(&scans[0].by_speed, place));
    }
    figure = figure.panel(by_step).panel(by_speed);
    figure
}
