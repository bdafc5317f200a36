//! A block on a slope, on a tilting plane and on a belt in rapier, with four kinds of friction:
//! `cargo run --release --manifest-path examples/engine/Cargo.toml` (half a minute).
//!
//! Prints a table, and leaves `engine.csv` (the same) and `engine.svg` in `target/figures`, or
//! `--out DIR`.

use std::process::ExitCode;

use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, Stroke, println};
use bristle_engine::bond::Coupling;
use bristle_engine::capsule::{Grip, slip};
use bristle_engine::measure::{
    Course, Outcome, acceleration_error, belt, belt_reference, creep, creep_believing, drift_law,
    energy_gain, load_cycles, swing, tilt,
};
use bristle_engine::scene::{CURVE, Friction};

/// Where the tilting plane begins [°]; below it nothing breaks away.
const FROM: f64 = 25.0;

/// Cycles of the load.
const CYCLES: f64 = 20.0;

/// On the belt [s].
const ON_BELT: f64 = 30.0;

/// Launched on the level [m/s].
const LAUNCHED: f64 = 2.0;

const FRICTIONS: [(&str, Friction); 11] = [
    ("rapier, Coulomb", Friction::Rapier),
    ("regularised, explicit, ε = 0.1 m/s", Friction::Explicit(0.1)),
    ("regularised, explicit, ε = 0.01 m/s", Friction::Explicit(0.01)),
    ("regularised, implicit, ε = 0.01 m/s", Friction::Implicit(1e-2)),
    ("regularised, implicit, ε = 1e-4 m/s", Friction::Implicit(1e-4)),
    ("regularised, implicit, ε = 1e-6 m/s", Friction::Implicit(1e-6)),
    ("FrBD, force", Friction::FrBd(Coupling::Force)),
    ("FrBD, motor", Friction::FrBd(Coupling::Motor)),
    ("FrBD, impulse", Friction::FrBd(Coupling::Impulse)),
    ("elasto-plastic, force", Friction::ElastoPlastic(Coupling::Force)),
    ("elasto-plastic, motor", Friction::ElastoPlastic(Coupling::Motor)),
];

const GRIPS: [(&str, Grip); 4] = [
    ("rapier, Coulomb", Grip::Rapier),
    ("regularised, implicit, ε = 0.01 m/s", Grip::Regularised(1e-2)),
    ("regularised, implicit, ε = 1e-4 m/s", Grip::Regularised(1e-4)),
    ("FrBD on two axes, motor", Grip::FrBd),
];

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("engine", "Friction of bristle inside rapier")
            .number("seconds", 60.0, "s", "how long the block has to stand")
            .must_be(Rule::Positive)
            .parse()?;
        let seconds = arguments.number("seconds");

        let columns = [
            "friction",
            "rate",
            "creep",
            "drift",
            "breakaway",
            "acceleration_error",
            "swing",
            "period",
            "gain",
        ];
        let mut table = Csv::create(arguments.out_dir(), "engine", &columns)?;
        println!(
            "block of 1 kg, μ from {} to {}",
            CURVE.static_coefficient, CURVE.dynamic_coefficient
        );
        println!(
            "creep: in {seconds} s at half of breakaway; drift: in each cycle of the load; \
             breakaway: of a plane\ntilting by 0.1 °/s; swing, period: on the belt; \
             gain: of energy, of a block launched at {LAUNCHED} m/s\n"
        );
        println!(
            "{:36} {:>4}  {:>9}  {:>9}  {:>9}  {:>12}  {:>7}  {:>8}  {:>7}",
            "friction",
            "Hz",
            "creep",
            "drift",
            "breakaway",
            "acceleration",
            "swing",
            "period",
            "gain"
        );
        for rate in [60.0, 240.0] {
            for (name, friction) in FRICTIONS {
                let creep = last(&creep(friction, rate, seconds)?).1;
                let drift = last(&load_cycles(friction, rate, CYCLES)?).1 / CYCLES;
                let (breakaway, _) = last(&tilt(friction, rate, FROM)?);
                let error = acceleration_error(friction, rate)?;
                let (swing, period) = swing(&belt(friction, rate, ON_BELT)?);
                let gain = energy_gain(friction, rate, LAUNCHED)?;
                let shown = period.map_or("–".to_owned(), |period| format!("{period:.3} s"));
                println!(
                    "{name:36} {rate:4}  {creep:7.0e} m  {drift:7.0e} m  {breakaway:7.2} °  \
                     {:10.3} %  {:4.1} cm  {shown:>8}  {gain:5.0e} J",
                    100.0 * error,
                    100.0 * swing,
                );
                let period = period.unwrap_or(f64::NAN);
                table.row(&[name], &[rate, creep, drift, breakaway, error, swing, period, gain])?;
            }
        }
        table.finish()?;
        let reference = belt_reference(ON_BELT)?;
        let (swing, period) = swing(&reference);
        println!(
            "{:36}    –          –  {:7.0e} m  {:7.2} °             –  {:4.1} cm  {:>6.3} s",
            "closed form, or solved to 1e-9",
            drift_law(),
            CURVE.static_coefficient.atan().to_degrees(),
            100.0 * swing,
            period.unwrap_or(f64::NAN),
        );
        println!();
        for mass in [0.25, 0.5, 2.0] {
            let friction = Friction::FrBd(Coupling::Force);
            let creep = last(&creep_believing(mass, friction, 60.0, seconds)?).1;
            println!("FrBD, force, 60 Hz, told {mass} of the mass: creep {creep:.0e} m");
        }
        println!();
        println!("capsule of 45 g in a grip, 60 Hz: slip in the first second, then creep");
        for ((name, grip), force) in GRIPS.into_iter().flat_map(|grip| [(grip, 12.0), (grip, 60.0)])
        {
            let (first, creep) = slip(grip, (60.0, 61.0), force, 0.0)?;
            println!("{name:36} {force:3} N  {first:5.0e} m  {:9.4} µm/s", 1e6 * creep);
        }
        println!();
        let figure = chart(seconds, &reference)?;
        println!("{}", figure.save(arguments.out_dir(), "engine")?.display());
        Ok(())
    })
}

/// The last of a course; there is one.
fn last(course: &[(f64, f64)]) -> (f64, f64) {
    course.last().copied().unwrap_or((f64::NAN, f64::NAN))
}

/// What is drawn, all at 60 Hz.
fn drawn() -> [(&'static str, Stroke, Friction); 5] {
    [
        ("regularised, explicit, ε = 0.1 m/s", Colour::Vermilion.dotted(), Friction::Explicit(0.1)),
        ("regularised, implicit, ε = 1e-4 m/s", Colour::Orange.dashed(), Friction::Implicit(1e-4)),
        ("rapier, Coulomb", Colour::Grey.into(), Friction::Rapier),
        ("FrBD", Colour::Blue.width(3.5), Friction::FrBd(Coupling::Force)),
        ("elasto-plastic", Colour::Green.dashed(), Friction::ElastoPlastic(Coupling::Force)),
    ]
}

fn chart(seconds: f64, reference: &Course) -> Outcome<Figure> {
    let mut standing = Panel::new("time t (s)", "displacement |x| (m)")
        .title("standing at half of breakaway")
        .log_y()
        .y_range(1e-16..=1e1);
    let mut cycles = Panel::new("cycles of the load", "displacement x (mm)")
        .title("load between 0.4 and 0.6 of breakaway")
        .y_range(-0.1..=1.5);
    let mut tilting = Panel::new("angle of the plane (°)", "velocity v (mm/s)")
        .title("a plane that tilts by 0.1 °/s")
        .x_range(30.7..=31.3)
        .y_range(-1.0..=10.0)
        .vertical(CURVE.static_coefficient.atan().to_degrees(), "atan μ_s");
    let mut sliding = Panel::new("time t (s)", "position x (cm)")
        .title("on the belt")
        .x_range(0.0..=8.0)
        .line("solved to 1e-9", Colour::Black.width(3.0), scaled(reference, 100.0));
    for (name, stroke, friction) in drawn() {
        let course = creep(friction, 60.0, seconds)?;
        // Where nothing moves, a logarithmic axis shows rounding.
        let course: Course = course.iter().map(|&(t, x)| (t, x.abs().max(1e-16))).collect();
        standing = standing.line(name, stroke, course);
        cycles = cycles.line(name, stroke, scaled(&load_cycles(friction, 60.0, CYCLES)?, 1e3));
        tilting = tilting.line(name, stroke, scaled(&tilt(friction, 60.0, FROM)?, 1e3));
        sliding = sliding.line(name, stroke, scaled(&belt(friction, 60.0, ON_BELT)?, 100.0));
    }
    Ok(Figure::new(1000, 760)
        .columns(2)
        .panel(standing)
        .panel(cycles)
        .panel(tilting)
        .panel(sliding))
}

fn scaled(course: &[(f64, f64)], factor: f64) -> Course {
    course.iter().map(|&(t, x)| (t, factor * x)).collect()
}
