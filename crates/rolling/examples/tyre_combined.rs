//! A tyre in combined slip: its force in steady rolling, braking and cornering at once, its camber
//! thrust, and a quarter of a car that changes lane while it brakes to a standstill.
//!
//! Car and road are those of the example `wheel_braking`, in `quarter_car/mod.rs`. The pressure in
//! the patch is parabolic, the bristles are isotropic. The slip angle α follows one period of a
//! sine, and the lateral velocity of the wheel is v_x tan α.
//!
//! Leaves `tyre_combined.csv` (the manoeuvre) and `tyre_combined.svg`.

mod quarter_car;
use std::error::Error;
use std::f64::consts::TAU;
use std::process::ExitCode;

use bristle::curve::Stribeck;
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Rule, Stroke, println};
use bristle_plane::PlaneFrBd;
use bristle_rolling::WheelLoads;
use bristle_rolling::{
    CombinedGrid, CombinedPatch, Motion, Patch, PatchParameters, PolynomialExponential, Segment,
};
use nalgebra::Vector2;
use quarter_car::{LENGTH, LOAD, QuarterCar, RADIUS, road_and_tread, rolling};

/// Speed [m/s] of the steady diagram.
const CRUISE: f64 = 20.0;
/// Begin and end [s] of the lane change.
const LANE_CHANGE: (f64, f64) = (0.8, 2.4);
/// Begin of braking [s], and the time in which the brake is applied [s].
const BRAKE: (f64, f64) = (0.5, 0.3);

type Outcome<T> = Result<T, Box<dyn Error>>;
/// One coefficient more than the parabola has, for the aligning moment.
type Pressure = PolynomialExponential<f64, 4>;
type Tyre = Patch<f64, PlaneFrBd<Stribeck<f64>, f64, 2>, Pressure>;
type Rolling = CombinedPatch<f64, PlaneFrBd<Stribeck<f64>, f64, 2>, 2, 4, Vec<Segment<f64, 4>>>;

/// The manoeuvre at the end of a step.
struct Row {
    time: f64,
    speed: f64,
    wheel_speed: f64,
    /// α [rad]
    slip_angle: f64,
    /// F_x, F_y [N]
    force: Vector2<f64>,
    /// M_z [N m]
    moment: f64,
}

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("tyre_combined", "A tyre that brakes and corners")
            .number("speed", 25.0, "m/s", "speed at the beginning")
            .must_be(Rule::Between(1.0, 100.0))
            .number("torque", 650.0, "N m", "what the brake can carry, fully applied")
            .must_be(Rule::AtLeast(0.0))
            .number("angle", 5.0, "°", "largest slip angle of the lane change")
            .must_be(Rule::Between(0.0, 45.0))
            .number("end", 6.0, "s", "end of the simulated time")
            .must_be(Rule::Between(0.1, 100.0))
            .number("step", 1e-3, "s", "time step of what is drawn and stored")
            .must_be(Rule::Between(1e-5, 0.1))
            .parse()?;
        let angle = arguments.number("angle").to_radians();
        let (speed, torque) = (arguments.number("speed"), arguments.number("torque"));
        let rows = manoeuvre(
            rolling(tyre()?.exact_in(200)?, speed)?,
            (torque, angle),
            arguments.number("end"),
            arguments.number("step"),
        )?;

        let columns = ["t", "speed", "wheel_speed", "slip_angle", "f_x", "f_y", "m_z"];
        let mut table = Csv::create(arguments.out_dir(), "tyre_combined", &columns)?;
        for Row { time, speed, wheel_speed, slip_angle, force, moment } in &rows {
            let numbers = [*time, *speed, *wheel_speed, *slip_angle, force.x, force.y, *moment];
            table.row(&[], &numbers)?;
        }
        table.finish()?;

        let tyre = tyre()?;
        report(&tyre, &rows)?;
        println!("{}", chart(&tyre, &rows)?.save(arguments.out_dir(), "tyre_combined")?.display());
        Ok(())
    })
}

fn tyre() -> Outcome<Tyre> {
    let (road, tread) = road_and_tread()?;
    let tyre = Patch::new(PatchParameters {
        model: PlaneFrBd::isotropic(road, tread),
        length: LENGTH,
        pressure: PolynomialExponential::parabolic().padded(),
    })?;
    Ok(tyre.under_load(LOAD)?)
}

/// Braking with a lane change: the torque that the brake can carry [N m] and the largest slip
/// angle [rad].
fn manoeuvre(
    mut wheel: QuarterCar<Rolling>,
    (torque, angle): (f64, f64),
    end: f64,
    h: f64,
) -> Outcome<Vec<Row>> {
    let steering = |time: f64| {
        let part = (time - LANE_CHANGE.0) / (LANE_CHANGE.1 - LANE_CHANGE.0);
        if (0.0..1.0).contains(&part) { angle * (TAU * part).sin() } else { 0.0 }
    };
    let mut rows = Vec::new();
    let mut before = wheel.state().speed;
    while wheel.state().time < end - 0.5 * h {
        let (middle, speed) = (wheel.state().time + 0.5 * h, wheel.state().speed);
        let lateral_velocity = (1.5 * speed - 0.5 * before) * steering(middle).tan();
        let applied = ((middle - BRAKE.0) / BRAKE.1).clamp(0.0, 1.0);
        let loads = WheelLoads { lateral_velocity, ..WheelLoads::braking(torque * applied) };
        before = speed;
        let state = wheel.step(loads, h)?;
        let slip_angle = steering(state.time);
        rows.push(Row {
            time: state.time,
            speed: state.speed,
            wheel_speed: state.angular_velocity * RADIUS,
            slip_angle,
            force: Vector2::new(state.force, state.lateral_force),
            moment: wheel.aligning_moment(state.speed * slip_angle.tan()),
        });
    }
    Ok(rows)
}

/// The steady force over the normal force at a braking slip (v_x − ωR)/v_x and a slip angle.
fn steady(tyre: &Tyre, slip: f64, slip_angle: f64) -> Outcome<Vector2<f64>> {
    let slip_velocity = CRUISE * Vector2::new(slip, slip_angle.tan());
    let motion = Motion { slip_velocity, rolling_speed: CRUISE * (1.0 - slip) };
    Ok(Vector2::from(tyre.combined_steady(motion)?.map(|axis| axis.force / LOAD)))
}

/// Lateral force over the normal force, and moment \[N m\], of a wheel that leans by an angle [rad]
/// as a motorcycle does, at a slip ratio of braking.
fn leaning(tyre: &Tyre, slip: f64, camber: f64) -> Outcome<(f64, f64)> {
    let spin = CRUISE / RADIUS * camber.sin(); // rad/s
    let velocity = |place: f64| Vector2::new(slip * CRUISE, spin * tyre.length() * (0.5 - place));
    let field = Motion { slip_velocity: |place, _| velocity(place), rolling_speed: |_, _| CRUISE };
    // A step longer than a crossing of the patch: steady rolling.
    let mut rolling = CombinedGrid::new(tyre, 50)?;
    let force = rolling.step_field(&field, 2.0 * tyre.length() / CRUISE)?;
    Ok((force.y / LOAD, rolling.moment(velocity).y))
}

fn report(tyre: &Tyre, rows: &[Row]) -> Outcome<()> {
    println!("steady rolling at {CRUISE} m/s, force over normal force");
    println!("slip angle   free: F_y   at 10 % of braking slip: F_x, F_y   locked: F_x, F_y");
    for degrees in [0.0, 2.0, 5.0, 10.0_f64] {
        let [free, braked, locked] =
            [0.0, 0.1, 1.0].map(|slip| steady(tyre, slip, degrees.to_radians()));
        let (free, braked, locked) = (free?, braked?, locked?);
        println!(
            "{degrees:8} ° {:11.3} {:25.3} {:8.3} {:16.3} {:6.3}",
            free.y, braked.x, braked.y, locked.x, locked.y
        );
    }
    let largest = |value: &dyn Fn(&Row) -> f64| rows.iter().map(value).fold(0.0, f64::max);
    println!();
    println!("lane change under braking");
    println!("largest force         {:.3} F_z", largest(&|row| row.force.norm() / LOAD));
    println!("largest lateral force {:.3} F_z", largest(&|row| row.force.y.abs() / LOAD));
    println!("largest moment        {:.1} N m", largest(&|row| row.moment.abs()));
    let mut rocking = rows.iter().skip_while(|row| row.speed > 0.0).peekable();
    if let Some(row) = rocking.peek() {
        println!("speed first zero      after {:.3} s", row.time);
        let fastest = rocking.map(|row| row.speed.abs()).fold(0.0, f64::max);
        println!("rocks on the tyre     at up to {fastest:.2} m/s");
    }
    if let Some(row) = rows.last() {
        println!("speed at the end      {:.2} m/s at {:.3} s", row.speed, row.time);
    }
    println!();
    Ok(())
}

fn chart(tyre: &Tyre, rows: &[Row]) -> Outcome<Figure> {
    let mut ellipses = Panel::new("lateral force F_y/F_z (–)", "braking force F_x/F_z (–)")
        .title("steady rolling at constant slip angles");
    let angles = [0.5, 1.0, 2.0, 5.0, 10.0_f64];
    for (number, degrees) in angles.into_iter().enumerate() {
        // From strong driving to a locked wheel, evenly spaced in the logarithm.
        let slips = (-160..=160).map(|k| {
            let size = 10.0_f64.powf(3.0 * (f64::from(k).abs() / 160.0 - 1.0));
            if k < 0 { -size } else { size }
        });
        let points: Outcome<Vec<(f64, f64)>> = slips
            .map(|slip| steady(tyre, slip, degrees.to_radians()).map(|force| (force.y, force.x)))
            .collect();
        ellipses = ellipses.line(format!("{degrees}°"), Stroke::nth(number), points?);
    }
    let leans = |label, title| Panel::new("camber γ (°)", label).title(title).own_legend();
    let mut thrust = leans("lateral force F_y/F_z (–)", "camber thrust at constant braking slips");
    let mut moment = leans("moment M_z (N m)", "its moment");
    for (number, slip) in [0.0, 0.02, 0.05, 0.1].into_iter().enumerate() {
        let points: Outcome<Vec<_>> =
            (0..=50).map(|degrees| leaning(tyre, slip, f64::from(degrees).to_radians())).collect();
        let points = points?;
        let over = |of: fn(&(f64, f64)) -> f64| {
            points.iter().enumerate().map(move |(degrees, at)| (degrees as f64, of(at)))
        };
        let name = format!("{:.0} %", 100.0 * slip);
        thrust = thrust.line(&name, Stroke::nth(number), over(|at| at.0));
        moment = moment.line(name, Stroke::nth(number), over(|at| at.1));
    }
    let plane = |from: f64, to: f64| {
        let rows = rows.iter().filter(move |row| row.time >= from && row.time <= to);
        rows.map(|row| (row.force.y / LOAD, row.force.x / LOAD))
    };
    let over_time = |value: &dyn Fn(&Row) -> f64| -> Vec<(f64, f64)> {
        rows.iter().map(|row| (row.time, value(row))).collect()
    };
    let time = "time t (s)";
    let end = rows.last().map_or(1.0, |row| row.time);
    let over = |label, title| Panel::new(time, label).title(title).x_range(0.0..=end).own_legend();
    let stands = rows.iter().find(|row| row.speed <= 0.0).map(|row| row.time);
    // Named in the panel of the speeds.
    let standstill = |(place, panel): (usize, Panel)| match stands {
        Some(time) => panel.vertical(time, if place == 0 { "first stop" } else { "" }),
        None => panel,
    };
    let timed = [
        over("speed (m/s)", "speeds")
            .line("vehicle v_x", Colour::Blue, over_time(&|row| row.speed))
            .line("wheel ωR", Colour::Orange.dashed(), over_time(&|row| row.wheel_speed)),
        over("slip angle α (°)", "steering").line(
            "slip angle",
            Colour::Blue,
            over_time(&|row| row.slip_angle.to_degrees()),
        ),
        over("force (kN)", "forces of the tyre")
            .line("braking F_x", Colour::Blue, over_time(&|row| 1e-3 * row.force.x))
            .line("lateral F_y", Colour::Vermilion, over_time(&|row| 1e-3 * row.force.y)),
        over("moment M_z (N m)", "self-aligning moment").line(
            "M_z",
            Colour::Green,
            over_time(&|row| row.moment),
        ),
    ];
    let figure = Figure::new(900, 1440)
        .title("A tyre that brakes and corners: steady forces, and a braking lane change")
        .columns(2)
        .panel(ellipses.own_legend())
        .panel(
            Panel::new("lateral force F_y/F_z (–)", "braking force F_x/F_z (–)")
                .title("the lane change, to standstill")
                .line("to 0.8 s", Colour::Orange.width(4.0), plane(0.0, 0.8))
                .line("to 1.6 s", Colour::Blue, plane(0.8, 1.6))
                .line("to 2.4 s", Colour::Green.dashed(), plane(1.6, 2.4))
                .line("then", Colour::Black.width(1.0), plane(2.4, end))
                .own_legend(),
        )
        .panel(thrust)
        .panel(moment);
    Ok(timed.into_iter().enumerate().map(standstill).fold(figure, Figure::panel))
}
