//! A quarter of a passenger car brakes harder than its tyre can carry: rolling, over the peak of
//! the force–slip curve, locked, to standstill, where it swings out on its bristles.
//!
//! The pressure in the patch is parabolic; the car is that of `quarter_car/mod.rs`.
//!
//! The slip is NaN once the car crawls. Leaves `wheel_braking.csv` and `wheel_braking.svg`.

mod quarter_car;
use std::error::Error;
use std::process::ExitCode;

use bristle::FrBd;
use bristle::curve::Stribeck;
use bristle::rheology::KelvinVoigt;
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Progress, Rule, println};
use bristle_rolling::{ExactPatch, Patch, PatchParameters, PolynomialExponential, Segment};
use bristle_rolling::{WheelLoads, WheelState};
use quarter_car::{INERTIA, LENGTH, LOAD, MASS, QuarterCar, RADIUS, road_and_tread, rolling};

/// Below this speed [m/s] a slip says nothing.
const CRAWL: f64 = 0.05;

type Friction = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;
type Wheel = QuarterCar<ExactPatch<f64, Friction, 3, Vec<Segment<f64, 3>>>>;

/// The brake pedal: torque that the brake can carry, over time.
#[derive(Debug, Clone, Copy)]
struct Pedal {
    ramp: f64,
    most: f64,
}

/// A row of the table: state after a step, slip, and what acted over it.
struct Row {
    state: WheelState<f64>,
    slip: f64,
    /// Since the beginning \[J\]: lost in the patch, in the brake.
    lost: [f64; 2],
}

/// What came of a run.
struct Run {
    rows: Vec<Row>,
    distance: f64,
    /// Largest share of a step's energy account that does not balance.
    defect: f64,
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("wheel_braking", "A wheel braked until it stands")
            .number("speed", 30.0, "m/s", "speed at the beginning")
            .must_be(Rule::Between(1.0, 100.0))
            .number("torque", 2500.0, "N m", "what the brake can carry, fully applied")
            .must_be(Rule::AtLeast(0.0))
            .number("ramp", 3000.0, "N m/s", "how fast it is applied")
            .must_be(Rule::Positive)
            .number("end", 5.0, "s", "end of the simulated time")
            .must_be(Rule::Between(0.1, 100.0))
            .number("step", 1e-3, "s", "time step of what is drawn and stored")
            .must_be(Rule::Between(1e-5, 0.1))
            .parse()?;
        let pedal = Pedal { ramp: arguments.number("ramp"), most: arguments.number("torque") };
        let (speed, end) = (arguments.number("speed"), arguments.number("end"));

        println!("{MASS} kg from {speed} m/s, brake of {} N m", pedal.most);
        println!();
        println!(
            "time step  distance at {end} s  off by      largest defect of the energy account"
        );
        let mut progress = Progress::new("braking", 4);
        let fine = fine_distance(pedal, speed, end)?;
        for step in [1e-2, 1e-3, 1e-4] {
            progress.step();
            let run = simulate(pedal, speed, end, step, false)?;
            println!(
                "{:6} ms  {:13.6} m  {:8.1e} m  {:.0e} of the kinetic energy at the beginning",
                1e3 * step,
                run.distance,
                (run.distance - fine).abs(),
                run.defect,
            );
        }

        let run = simulate(pedal, speed, end, arguments.number("step"), true)?;
        progress.step();
        report(&run);
        let columns = ["t", "speed", "wheel_speed", "slip", "force", "brake_torque"];
        let mut table = Csv::create(arguments.out_dir(), "wheel_braking", &columns)?;
        for Row { state, slip, .. } in &run.rows {
            let wheel_speed = state.angular_velocity * RADIUS;
            let numbers =
                [state.time, state.speed, wheel_speed, *slip, state.force, state.brake_torque];
            table.row(&[], &numbers)?;
        }
        table.finish()?;
        println!();
        println!("{}", chart(&run).save(arguments.out_dir(), "wheel_braking")?.display());
        Ok(())
    })
}

fn wheel(speed: f64) -> Result<Wheel, Box<dyn Error>> {
    let (road, tread) = road_and_tread()?;
    let tyre = Patch::new(PatchParameters {
        model: FrBd::new(road, tread),
        length: LENGTH,
        pressure: PolynomialExponential::parabolic(),
    })?;
    rolling(tyre.under_load(LOAD)?.exact_in(200)?, speed)
}

impl Pedal {
    /// What acts over the step that begins at a time.
    fn over(self, begin: f64, h: f64) -> WheelLoads<f64> {
        WheelLoads::braking(self.most.min(self.ramp * (begin + 0.5 * h)))
    }
}

/// Distance \[m\] after very many steps, without an account of the energy.
fn fine_distance(pedal: Pedal, speed: f64, end: f64) -> Result<f64, Box<dyn Error>> {
    let mut wheel = wheel(speed)?;
    let steps = (end / 2e-5).round();
    while wheel.state().time < end - 0.5 * end / steps {
        wheel.step(pedal.over(wheel.state().time, end / steps), end / steps)?;
    }
    Ok(wheel.state().position)
}

fn simulate(
    pedal: Pedal,
    speed: f64,
    end: f64,
    time_step: f64,
    stored: bool,
) -> Result<Run, Box<dyn Error>> {
    let mut wheel = wheel(speed)?;
    let start = wheel.kinetic_energy();
    let steps = (end / time_step).round().max(1.0) as u32;
    let h = end / f64::from(steps);
    let mut run = Run { rows: Vec::new(), distance: 0.0, defect: 0.0 };
    let mut lost = [0.0; 2];
    for number in 0..steps {
        let (before, kinetic) = (wheel.state(), wheel.kinetic_energy());
        let in_tyre = wheel.tyre().stored_energy();
        let state = wheel.step(pedal.over(h * f64::from(number), h), h)?;
        let speed = 0.5 * (before.speed + state.speed);
        let spin = 0.5 * (before.angular_velocity + state.angular_velocity);
        let works = [h * state.force * (speed - RADIUS * spin), h * state.brake_torque * spin];
        let defect = wheel.kinetic_energy() - kinetic + works[0] + works[1];
        run.defect = run.defect.max(defect.abs() / start);
        // What tyre and brake do not store. The brake's bristle gets energy from its normal force.
        let brake = wheel.brake();
        lost[0] += works[0] - (wheel.tyre().stored_energy() - in_tyre);
        lost[1] += works[1] + brake.stored_energy(before.brake_deflection)
            - brake.stored_energy(state.brake_deflection);
        if stored {
            let slip = if state.speed > CRAWL { wheel.braking_slip() } else { f64::NAN };
            run.rows.push(Row { state, slip, lost });
        }
    }
    run.distance = wheel.state().position;
    Ok(run)
}

fn report(run: &Run) {
    let locked = run.rows.iter().position(|row| row.state.angular_velocity <= 0.0);
    let rolling = run.rows.iter().take(locked.unwrap_or(run.rows.len()));
    let peak = rolling.max_by(|a, b| a.state.force.total_cmp(&b.state.force));
    let locked = locked.and_then(|number| run.rows.get(number));
    let stands = run.rows.iter().find(|row| row.state.speed <= 0.0);
    println!();
    if let Some(Row { state, slip, .. }) = peak {
        let (share, time) = (state.force / LOAD, state.time);
        println!("peak     {time:.3} s  F = {share:.3} F_z at a slip of {:.1} %", 100.0 * slip);
    }
    if let Some(Row { state, .. }) = locked {
        println!("locked   {:.3} s  at {:.2} m/s", state.time, state.speed);
    }
    if let Some(Row { state, .. }) = stands {
        println!("stands   {:.3} s  after {:.2} m", state.time, state.position);
    }
    if let Some(Row { state, lost, .. }) = run.rows.last() {
        println!(
            "at {} s  {:.0e} m/s, wheel {:.0e} m/s",
            state.time.round(),
            state.speed.abs(),
            (state.angular_velocity * RADIUS).abs()
        );
        let [patch, brake] = lost.map(|energy| 1e-3 * energy);
        println!("lost     {patch:.1} kJ in the patch, {brake:.1} kJ in the brake");
    }
}

fn chart(run: &Run) -> Figure {
    let over_time = |value: &dyn Fn(&Row) -> f64| -> Vec<(f64, f64)> {
        run.rows.iter().map(|row| (row.state.time, value(row))).collect()
    };
    let time = "time t (s)";
    let end = run.rows.last().map_or(1.0, |row| row.state.time);
    let over = |label, title| Panel::new(time, label).title(title).x_range(0.0..=end).own_legend();
    let speeds = over("speed (m/s)", "speeds")
        .line("vehicle v_x", Colour::Blue, over_time(&|row| row.state.speed))
        .line(
            "wheel ωR",
            Colour::Orange.dashed(),
            over_time(&|row| row.state.angular_velocity * RADIUS),
        );
    let stands = run.rows.iter().find(|row| row.state.speed <= 0.0).map(|row| row.state.time);
    let standstill = |panel: Panel| match stands {
        Some(time) => panel.vertical(time, "stands"),
        None => panel,
    };
    let slip = over("slip (v_x − ωR)/v_x (–)", "slip of the tyre").line(
        "slip, until the car crawls",
        Colour::Blue,
        {
            let rows = run.rows.iter().take_while(|row| row.state.speed > CRAWL);
            rows.map(|row| (row.state.time, row.slip)).collect::<Vec<_>>()
        },
    );
    let forces = over("force (kN)", "forces")
        .line("tyre F", Colour::Blue, over_time(&|row| 1e-3 * row.state.force))
        .line(
            "brake T/R",
            Colour::Orange.dashed(),
            over_time(&|row| 1e-3 * row.state.brake_torque / RADIUS),
        );
    let energies = over("energy (kJ)", "energies")
        .line(
            "kinetic",
            Colour::Black,
            over_time(&|row| {
                let WheelState { speed, angular_velocity, .. } = row.state;
                0.5e-3 * (MASS * speed * speed + INERTIA * angular_velocity * angular_velocity)
            }),
        )
        .line("lost in the patch", Colour::Green, over_time(&|row| 1e-3 * row.lost[0]))
        .line("lost in the brake", Colour::Vermilion, over_time(&|row| 1e-3 * row.lost[1]));
    let panels = [speeds, slip, forces, energies].map(standstill);
    panels.into_iter().fold(
        Figure::new(900, 640)
            .title("A wheel braked over lock-up to standstill: speeds, slip, forces, energies")
            .note("The slip is undefined once the car stands; then it swings on its bristles.")
            .columns(2),
        Figure::panel,
    )
}
