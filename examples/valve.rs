//! The diaphragm valve of the paper (section V-B, Table 3) in its two tests: the opening asked for
//! goes up and down a ramp (Test 1) or swings in a sine (Test 2), and the stem follows against the
//! friction of its packing, with FrBD and LuGre.
//!
//! The paper does not print its inputs. Here Test 1 asks for 0 → 100 % over 100 s and back, Test 2
//! for 50 + 30 sin(2π·0.02 t) %. Both start settled, with no force on the bristle.
//!
//! Leaves `valve.csv` and `valve.svg`.

use std::error::Error;
use std::ops::RangeInclusive;
use std::process::ExitCode;

use bristle::curve::Stribeck;
use bristle::ode::{Direction, Event, Output, Solver, Trajectory};
use bristle::rheology::KelvinVoigt;
use bristle::scene::DiaphragmValve;
use bristle::signal::{Polyline, Signal, Sine, SineParameters, Vertex};
use bristle::{Bristle, FrBd, LuGre, paper};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, Stroke, println};
use nalgebra::Vector4;

/// Position, velocity, deflection, pressure.
type State = Vector4<f64>;

/// Something to draw.
type Quantity = fn(&Row) -> f64;

/// Below this speed the stem counts as held: a hundredth of the Stribeck velocity [m/s].
const HELD: f64 = 0.01 * paper::VALVE_CURVE.stribeck_velocity;

/// The upper end of the loop of Test 1, for the chart [kPa].
const UPPER_END: RangeInclusive<f64> = 195.0..=208.0;

/// The first turn of the stem in Test 2, for the chart [s].
const TURN: [f64; 2] = [11.5, 16.5];

/// Time shown before and after a reversal [s].
const AROUND: [f64; 2] = [-3e-3, 15e-3];

/// One test with every model.
struct Test {
    number: &'static str,
    runs: [Run; 3],
}

/// One test with one model, ready for the tables and the chart.
struct Run {
    name: &'static str,
    label: &'static str,
    stroke: Stroke,
    trajectory: Trajectory<f64, 4>,
    rows: Vec<Row>,
    /// Area of the diaphragm [m²] and pressure gain [Pa/%].
    area: f64,
    gain: f64,
}

/// One sample.
#[derive(Clone, Copy)]
struct Row {
    time: f64,
    state: State,
    /// Friction [N].
    force: f64,
    /// Where the stem would stand without friction at this pressure [m].
    ideal: f64,
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("valve", "The diaphragm valve of the paper")
            .number("end", 200.0, "s", "end of the simulated time")
            .must_be(Rule::Between(0.1, 1e5))
            .count("samples", 4001, "rows per model and test, evenly spaced, both ends included")
            .must_be(Rule::Between(2.0, 1e6))
            .number("rtol", 1e-8, "", "tolerance, relative to each state's scale")
            .must_be(Rule::Positive)
            .parse()?;
        let settings = Settings {
            end: arguments.number("end"),
            samples: arguments.count("samples"),
            rtol: arguments.number("rtol"),
        };

        let corner = |time, value| Vertex { time, value };
        let ramp = Polyline::new([corner(0.0, 0.0), corner(100.0, 100.0), corner(200.0, 0.0)])?;
        let sine =
            Sine::new(SineParameters { mean: 50.0, amplitude: 30.0, frequency: 0.02, phase: 0.0 })?;
        let [first, second] = [0.933, 0.425]; // s, in the paper
        let tests = [
            Test { number: "1", runs: settings.runs(first, ramp)? },
            Test { number: "2", runs: settings.runs(second, sine)? },
        ];

        settings.report(&tests);
        let columns = ["model", "test", "t", "x", "v", "pressure", "z", "force"];
        let mut table = Csv::create(arguments.out_dir(), "valve", &columns)?;
        for test in &tests {
            for run in &test.runs {
                for row in &run.rows {
                    let [[x, v, z, pressure]] = row.state.data.0;
                    table
                        .row(&[run.name, test.number], &[row.time, x, v, pressure, z, row.force])?;
                }
            }
        }
        table.finish()?;
        println!();
        println!("{}", chart(&tests).save(arguments.out_dir(), "valve")?.display());
        Ok(())
    })
}

/// How every test is run.
struct Settings {
    end: f64,
    samples: usize,
    rtol: f64,
}

impl Settings {
    /// One test with every model.
    fn runs<U: Signal<f64>>(&self, lag: f64, opening: U) -> Result<[Run; 3], Box<dyn Error>> {
        let curve = Stribeck::new(paper::VALVE_CURVE)?;
        let bristle = KelvinVoigt::new(paper::VALVE_BRISTLE)?;
        let frbd = FrBd::new(curve, bristle);
        let classical = LuGre::classical(curve, bristle);
        let inside = LuGre::with_viscous_friction(curve, bristle, 0.0)?;
        let names =
            [("frbd", "FrBD"), ("lugre", "LuGre"), ("lugre_inside", "LuGre, viscous part inside")];
        Ok([
            self.run(names[0], Colour::Blue.into(), frbd, lag, opening.clone())?,
            self.run(names[1], Colour::Orange.dashed(), classical, lag, opening.clone())?,
            self.run(names[2], Colour::Black.dotted(), inside, lag, opening)?,
        ])
    }

    /// One test with one model.
    fn run<M: Bristle<f64, Deflection = f64>, U: Signal<f64>>(
        &self,
        (name, label): (&'static str, &'static str),
        stroke: Stroke,
        model: M,
        lag: f64,
        opening: U,
    ) -> Result<Run, Box<dyn Error>> {
        let parameters = paper::valve(model.under_load(1.0)?, lag, opening);
        let (area, preload) = (parameters.diaphragm_area, parameters.preload);
        let (gain, stiffness) = (parameters.pressure_gain, parameters.mechanism.spring_stiffness);
        let valve = DiaphragmValve::new(parameters)?;
        let speed = |_: f64, state: &State| state[1].abs() - HELD;
        let events = [Event { function: &speed, direction: Direction::Either, stops: false }];
        // As `ode::solve` does it, with events besides.
        let trajectory = Solver::automatic(self.rtol, valve.scales())?.solve_with_events(
            &valve,
            0.0..self.end,
            valve.balanced(0.0),
            &events,
            Output::Dense,
        )?;
        let row = |sample: usize| {
            // Not beyond the end by rounding.
            let time = (self.end * sample as f64 / (self.samples - 1) as f64).min(self.end);
            trajectory.at(time).map(|state| Row {
                time,
                state,
                force: valve.friction_force(&state),
                ideal: (area * state[3] - preload) / stiffness,
            })
        };
        let rows = (0..self.samples).filter_map(row).collect();
        Ok(Run { name, label, stroke, trajectory, rows, area, gain })
    }

    fn report(&self, tests: &[Test]) {
        println!("Table 3, p = 1 N, {} s, rtol {:e}", self.end, self.rtol);
        println!("held: slower than {:.1} µm/s; dead band: its pressures, as opening", HELD * 1e6);
        println!();
        println!(
            "test  model                       slips  holds      each  dead band  behind ideal  \
             top speed     steps  evaluations  reversals"
        );
        for test in tests {
            for run in &test.runs {
                run.report(test.number);
            }
        }
        if let Some(run) = tests.first().and_then(|test| test.runs.first()) {
            let band = 2.0 * paper::VALVE_CURVE.static_coefficient / (run.area * run.gain);
            println!();
            println!("2 μ_s p/(S_a K_P) = {band:.4} % of the opening");
        }
        println!();
        println!(
            "test  distance from FrBD of           position, rms  greatest  velocity, greatest"
        );
        for test in tests {
            let [frbd, others @ ..] = &test.runs;
            for other in others {
                frbd.compare(other, test.number);
            }
        }
    }
}

impl Run {
    /// A line of the table. A hold begins with one event and ends with the next.
    fn report(&self, test: &str) {
        let events = self.trajectory.events();
        let slips = events.len().div_ceil(2);
        let holds: Vec<_> = events.get(1..).unwrap_or(&[]).chunks_exact(2).collect();
        let mean = |unit: &str, value: &dyn Fn(f64, f64) -> f64| match holds.len() {
            0 => "–".to_owned(),
            n => {
                let sum: f64 = holds.iter().map(|hold| value(hold[0].time, hold[1].time)).sum();
                format!("{:.4} {unit}", sum / n as f64)
            }
        };
        let held = mean("s", &|from, to| to - from);
        // From the extreme of the pressure, which the stem reaches almost held, to breakaway.
        let band = mean("%", &|from, to| {
            let within = (0..=1000).map(|i| from + (to - from) * f64::from(i) / 1000.0);
            let pressures = within.filter_map(|time| Some(self.trajectory.at(time)?[3]));
            let (least, most) =
                pressures.fold((f64::INFINITY, 0.0_f64), |(a, b), p| (a.min(p), b.max(p)));
            (most - least) / self.gain
        });
        let behind = most(self.rows.iter().map(|row| row.state[0] - row.ideal));
        let speed = most(self.rows.iter().map(|row| row.state[1]));
        let statistics = self.trajectory.statistics();
        println!(
            "{test:>4}  {:26}  {slips:5}  {:5}  {held:>8}  {band:>9}  {:9.4} mm  {:7.4} mm/s  \
             {:8}  {:11}  {:9}",
            self.label,
            holds.len(),
            behind * 1e3,
            speed * 1e3,
            statistics.steps,
            statistics.evaluations,
            statistics.reversals,
        );
    }

    /// How far another model's stem is from this one's.
    fn compare(&self, other: &Run, test: &str) {
        let pairs = || self.rows.iter().zip(&other.rows);
        let position = || pairs().map(|(a, b)| a.state[0] - b.state[0]);
        let mean = position().map(|x| x * x).sum::<f64>() / self.rows.len() as f64;
        let velocity = most(pairs().map(|(a, b)| a.state[1] - b.state[1]));
        println!(
            "{test:>4}  {:28}  {:10.1e} m  {:6.1e} m  {velocity:14.1e} m/s",
            other.label,
            mean.sqrt(),
            most(position()),
        );
    }

    /// Velocity [µm/s] over time [ms] around the first reversal of the first turn.
    fn at_the_turn(&self) -> Vec<(f64, f64)> {
        let mut reversals = self.trajectory.reversals().iter().map(|reversal| reversal.time);
        let Some(reversal) = reversals.find(|&time| time > TURN[0]) else {
            return Vec::new();
        };
        let after = |i: i32| AROUND[0] + (AROUND[1] - AROUND[0]) * f64::from(i) / 1000.0;
        (0..=1000)
            .map(after)
            .filter_map(|t| Some((t * 1e3, self.trajectory.at(reversal + t)?[1] * 1e6)))
            .collect()
    }

    /// A line of the chart.
    fn line(&self, x: impl Fn(&Row) -> f64, y: impl Fn(&Row) -> f64) -> Vec<(f64, f64)> {
        self.rows.iter().map(|row| (x(row), y(row))).collect()
    }
}

/// The greatest magnitude.
fn most(values: impl Iterator<Item = f64>) -> f64 {
    values.map(f64::abs).fold(0.0, f64::max)
}

/// Two panels from Test 1 and Test 2, and two around the first turn of Test 2. Everywhere else the
/// models coincide; LuGre with the viscous part inside coincides with FrBD in all panels but the
/// last.
fn chart([ramp, sine]: &[Test; 2]) -> Figure {
    let position: Quantity = |row| row.state[0] * 1e3;
    let ideal: Quantity = |row| row.ideal * 1e3;
    let pressure: Quantity = |row| row.state[3] * 1e-3;
    let time: Quantity = |row| row.time;
    let draw = |panel: Panel, test: &Test, x: Quantity, y: Quantity| {
        let runs = test.runs[..2].iter();
        runs.fold(panel, |panel, run| panel.line(run.label, run.stroke, run.line(x, y)))
    };
    let free = |panel: Panel, test: &Test, x: Quantity| {
        panel.line("without friction", Colour::Grey.width(1.0), test.runs[0].line(x, ideal))
    };
    let end = Panel::new("pressure P (kPa)", "position x (mm)")
        .title("Test 1: upper end of the loop")
        .x_range(UPPER_END);
    let deflection = Panel::new("time t (s)", "deflection z (µm)").title("Test 2: the bristle");
    let turn = Panel::new("time t (s)", "position x (mm)")
        .title("Test 2: the first turn")
        .x_range(TURN[0]..=TURN[1]);
    let rest = Panel::new("time since the reversal (ms)", "velocity v (µm/s)")
        .title("that turn, where the stem comes to rest")
        .own_legend();
    Figure::new(900, 680)
        .title("The diaphragm valve: end of the loop, deflection, a turn and its end")
        .columns(2)
        .panel(draw(free(end, ramp, pressure), ramp, pressure, position))
        .panel(draw(deflection, sine, time, |row| row.state[2] * 1e6))
        .panel(draw(free(turn, sine, time), sine, time, position))
        .panel(
            sine.runs
                .iter()
                .fold(rest, |panel, run| panel.line(run.label, run.stroke, run.at_the_turn())),
        )
}
