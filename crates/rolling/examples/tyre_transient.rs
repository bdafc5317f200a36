//! A tyre whose slip velocity rises and swings (Table 1 of the paper, U = 2 m/s, v(t) = 1 −
//! exp(−t/5 ms) + 0.5 sin(2π 10 t)): the friction force under three pressures, with FrBD and
//! LuGre, from undeflected bristles.
//!
//! Table 1 has no micro-damping, σ1 = 0. Then both models nearly coincide: in full sliding they
//! give the same force, and they differ only where they put the viscous part σ2 |v|, by a
//! thousandth of the normal force at most. With classical LuGre it is there at once, with FrBD it
//! builds up with the deflection. The last panel shows the difference enlarged.
//!
//! Leaves `tyre_transient.csv` and `tyre_transient.svg`.

use std::error::Error;
use std::process::ExitCode;

use bristle::curve::Stribeck;
use bristle::rheology::KelvinVoigt;
use bristle::signal::{Function, Signal};
use bristle::{Bristle, FrBd, LuGre, paper};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, println};
use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential};

/// Error of the force ratios; the integration chooses its steps, whatever the number of samples.
const TOLERANCE: f64 = 1e-9;
/// The normal force / N: forces are then ratios.
const LOAD: f64 = 1.0;

const PRESSURES: [&str; 3] = ["constant", "exponential", "parabolic"];
const COLOURS: [Colour; 3] = [Colour::Blue, Colour::Green, Colour::Orange];

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments =
            Arguments::new("tyre_transient", "A tyre under a slip velocity that swings")
                .number("end", 0.5, "s", "end of the simulated time")
                .must_be(Rule::Between(1e-3, 100.0))
                .number("rolling-speed", 2.0, "m/s", "rolling speed")
                .must_be(Rule::Between(0.0, 1e4))
                .count(
                    "samples",
                    1001,
                    "rows per model and pressure, evenly spaced, both ends included",
                )
                .must_be(Rule::Between(2.0, 1e6))
                .parse()?;
        let (end, samples) = (arguments.number("end"), arguments.count("samples"));
        let rolling_speed = arguments.number("rolling-speed");
        let slip = Function::new(slip_velocity, []);
        let motion = Motion { slip_velocity: slip, rolling_speed };
        let times: Vec<f64> =
            (0..samples).map(|number| end * number as f64 / (samples - 1) as f64).collect();

        let curve = Stribeck::new(paper::TYRE_CURVE)?;
        let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE)?;
        let frbd = forces(FrBd::new(curve, bristle), &motion, &times)?;
        let lugre = forces(LuGre::classical(curve, bristle), &motion, &times)?;

        let columns = ["model", "pressure", "t", "v", "force_ratio"];
        let mut table = Csv::create(arguments.out_dir(), "tyre_transient", &columns)?;
        for (model, runs) in [("frbd", &frbd), ("lugre", &lugre)] {
            for (pressure, forces) in PRESSURES.iter().zip(runs) {
                for (&t, &force) in times.iter().zip(forces) {
                    table.row(&[model, pressure], &[t, slip.value(t), force])?;
                }
            }
        }
        table.finish()?;

        println!("Table 1, rolling at {rolling_speed} m/s, from undeflected bristles, {end} s");
        println!();
        println!(
            "pressure      greatest F/F_z: FrBD    LuGre   greatest difference  steady at v = 1 m/s"
        );
        for (number, pressure) in PRESSURES.iter().enumerate() {
            let most = |forces: &[f64]| forces.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let apart = frbd[number].iter().zip(&lugre[number]).map(|(a, b)| (a - b).abs());
            println!(
                "{pressure:12} {:21.5} {:8.5} {:21.5} {:>21.5}",
                most(&frbd[number]),
                most(&lugre[number]),
                apart.fold(0.0, f64::max),
                steady(number, rolling_speed)?,
            );
        }
        println!();
        let figure = chart(&times, &frbd, &lugre);
        println!("{}", figure.save(arguments.out_dir(), "tyre_transient")?.display());
        Ok(())
    })
}

/// v(t) = 1 − exp(−t/5 ms) + 0.5 sin(2π 10 t) and its rate.
fn slip_velocity(t: f64) -> (f64, f64) {
    let fading = (-t / 0.005).exp();
    let turn = 2.0 * std::f64::consts::PI * 10.0;
    (1.0 - fading + 0.5 * (turn * t).sin(), fading / 0.005 + 0.5 * turn * (turn * t).cos())
}

/// Force over normal force under each pressure.
fn forces<M, S, W>(
    model: M,
    motion: &Motion<S, W>,
    times: &[f64],
) -> Result<[Vec<f64>; 3], Box<dyn Error>>
where
    M: Bristle<f64, Deflection = f64> + Copy,
    S: Signal<f64>,
    W: Signal<f64>,
{
    let exponential = PolynomialExponential::exponential(bristle_rolling::TYRE_PRESSURE_DECAY)?;
    Ok([
        force(model, PolynomialExponential::constant(), motion, times)?,
        force(model, exponential, motion, times)?,
        force(model, PolynomialExponential::parabolic(), motion, times)?,
    ])
}

fn force<M, S, W, const N: usize>(
    model: M,
    pressure: PolynomialExponential<f64, N>,
    motion: &Motion<S, W>,
    times: &[f64],
) -> Result<Vec<f64>, Box<dyn Error>>
where
    M: Bristle<f64, Deflection = f64>,
    S: Signal<f64>,
    W: Signal<f64>,
{
    let patch =
        Patch::new(PatchParameters { model, length: bristle_rolling::TYRE_LENGTH, pressure })?;
    let mut rolling = patch.under_load(LOAD)?.exact_in(4000)?;
    let mut forces = vec![rolling.force(motion.slip_velocity.value(0.0)) / LOAD];
    for pair in times.windows(2) {
        forces.push(rolling.follow_within(motion, pair[0]..pair[1], TOLERANCE)? / LOAD);
    }
    Ok(forces)
}

/// The steady force ratio of FrBD at v = 1 m/s.
fn steady(number: usize, rolling_speed: f64) -> Result<f64, Box<dyn Error>> {
    let model =
        FrBd::new(Stribeck::new(paper::TYRE_CURVE)?, KelvinVoigt::new(paper::TYRE_BRISTLE)?);
    let motion = Motion { slip_velocity: 1.0, rolling_speed };
    // Two transits, or long enough to slide where the patch stands.
    let time = 2.0 * bristle_rolling::TYRE_LENGTH / rolling_speed.max(0.1);
    Ok(forces(model, &motion, &[0.0, time])?[number][1])
}

fn chart(times: &[f64], frbd: &[Vec<f64>; 3], lugre: &[Vec<f64>; 3]) -> Figure {
    let over_time = |values: &[f64]| -> Vec<(f64, f64)> {
        times.iter().copied().zip(values.iter().copied()).collect()
    };
    let velocity: Vec<f64> = times.iter().map(|&t| slip_velocity(t).0).collect();
    let time = "time t (s)";
    let ratio = "force ratio F/F_z (–)";
    let mut force = Panel::new(time, ratio).title("friction force, FrBD");
    let mut near = Panel::new(time, ratio).title("enlarged").y_range(0.53..=0.6);
    let mut apart = Panel::new(time, "difference of F/F_z (10⁻³)").title("LuGre − FrBD");
    for (number, pressure) in PRESSURES.into_iter().enumerate() {
        let stroke = [COLOURS[0].into(), COLOURS[1].dashed(), COLOURS[2].into()][number];
        let both = lugre[number].iter().zip(&frbd[number]);
        let difference: Vec<f64> = both.map(|(a, b)| (a - b) * 1e3).collect();
        let own = over_time(&frbd[number]);
        force = force.line(format!("{pressure} pressure"), stroke, &own);
        near = near.line("", stroke, &own);
        apart = apart.line("", stroke, over_time(&difference));
    }
    let slip = Panel::new(time, "slip velocity v (m/s)").title("slip velocity");
    Figure::new(900, 640)
        .title("A tyre under a slip velocity that swings: force ratio over time, three pressures")
        .columns(2)
        .panel(slip.line("", Colour::Black, over_time(&velocity)))
        .panel(force)
        .panel(near)
        .panel(apart)
}
