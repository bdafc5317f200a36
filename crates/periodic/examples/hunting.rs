//! A position loop that hunts, over two of its gains; its cycle; and where stick-slip begins and
//! ends over the stiffness of a spring.
//!
//! Leaves `hunting.csv` and `hunting.svg`, and prints the report of one loop and what the map costs
//! beside as many runs by hand.

use std::process::ExitCode;
use std::thread;
use std::time::Instant;

use bristle::companion::VelocityHistory;
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::nalgebra::{SVector, Vector3};
use bristle::ode::{Automatic, Direction, Event, Solver, System, Tolerances};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, Contact, FrBd, Mechanism, paper};
use bristle_analysis::linear::{self, Threshold};
use bristle_charts::{Arguments, Colour, Csv, Figure, HeatMap, Panel, Rule, println};
use bristle_periodic::{
    Continuation, ControlLoop, ControlLoopParameters, DrivenMass, Orbit, OrbitBranch, Outcome, Pid,
    PointKind, hunting, hunting_map, hunting_orbit,
};

type Friction = Contact<f64, FrBd<Stribeck<f64>, KelvinVoigt<f64>>>;

/// K_P [N/m]
const PROPORTIONAL: f64 = 400.0;
/// The start of a run: at rest, so far from the target [m].
const START: f64 = 0.02;
/// The starts of the map that is drawn [m]: from some a loop rests that hunts from others.
const STARTS: [f64; 4] = [0.02, 0.014, 0.01, 0.007];

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("hunting", "A position loop that hunts, and stick-slip")
            .count("gains", 20, "values of each gain in the map")
            .number("duration", 120.0, "s", "simulated time of each loop in the map")
            .must_be(Rule::Positive)
            .parse()?;
        let (gains, duration) = (arguments.count("gains"), arguments.number("duration"));
        let mut table = Csv::create(arguments.out_dir(), "hunting", &["panel", "x", "y", "value"])?;
        let loops = friction()?;
        println!("{}", hunting(&control_loop(&loops, 400.0, 20.0), &[1e-3, START], duration)?);
        let system = ControlLoop::new(control_loop(&loops, 400.0, 20.0))?;
        let cycle = hunting_orbit(&system, START, 60.0)?;
        let figure = Figure::new(980, 940)
            .title("A loop that hunts, and stick-slip")
            .columns(2)
            .panel(phase_plane(&system, &cycle, &mut table)?)
            .panel(map(&loops, &cycle, (gains, duration), &mut table)?)
            .panel(amplitudes(&loops, &cycle, &mut table)?)
            .panel(stick_slip_map(&mut table)?);
        table.finish()?;
        println!("\n{}", figure.save(arguments.out_dir(), "hunting")?.display());
        Ok(())
    })
}

fn friction() -> bristle_charts::Result<Friction> {
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: 5.0,
        dynamic_coefficient: 3.0,
        stribeck_velocity: 0.01,
        stribeck_exponent: 2.0,
        viscous_friction: 1.0,
    })?;
    let bristle = KelvinVoigtParameters { micro_stiffness: 5e4, micro_damping: 224.0 };
    Ok(FrBd::new(curve, KelvinVoigt::new(bristle)?).under_load(1.0)?)
}

fn control_loop(
    contact: &Friction,
    integral: f64,
    derivative: f64,
) -> ControlLoopParameters<FrBd<Stribeck<f64>, KelvinVoigt<f64>>> {
    let controller = Pid {
        proportional: PROPORTIONAL,
        integral,
        derivative,
        filter_time: 0.0,
        sample_time: 0.0,
    };
    let mechanism = Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 };
    ControlLoopParameters { contact: *contact, mechanism, controller }
}

/// Where loops end over two gains, and where their stable cycles end.
fn map(
    contact: &Friction,
    cycle: &Orbit<4>,
    (gains, duration): (usize, f64),
    table: &mut Csv,
) -> bristle_charts::Result<Panel> {
    let steps =
        |last: f64| -> Vec<f64> { (1..=gains).map(|i| last * i as f64 / gains as f64).collect() };
    let (integral, derivative) = (steps(2000.0), steps(80.0));
    let began = Instant::now();
    let of = |integral: f64, derivative: f64| control_loop(contact, integral, derivative);
    hunting_map(of, [&integral, &derivative], START, duration)?;
    let took = began.elapsed().as_secs_f64();
    let began = Instant::now();
    by_hand(contact, [&integral, &derivative], duration)?;
    let by_hand = began.elapsed().as_secs_f64();
    println!(
        "map of {} loops over {duration} s: {took:.2} s; by hand with companion steps {by_hand:.2} \
         s; ratio {:.2}",
        gains * gains,
        took / by_hand
    );
    // What is drawn: the largest cycle of several starts, for longer.
    let mut amplitudes = vec![vec![f64::NAN; gains]; gains];
    for start in STARTS {
        let outcomes = hunting_map(of, [&integral, &derivative], start, 5.0 * duration)?;
        for (row, outcomes) in amplitudes.iter_mut().zip(&outcomes) {
            for (most, outcome) in row.iter_mut().zip(outcomes) {
                if let Outcome::Hunts(cycle) = outcome {
                    *most = most.max(1e3 * cycle.amplitude);
                }
            }
        }
    }
    let amplitude = |i: usize, j: usize| amplitudes[j][i];
    for (j, down) in derivative.iter().enumerate() {
        for (i, across) in integral.iter().enumerate() {
            table.row(&["map"], &[*across, *down, amplitude(i, j)])?;
        }
    }
    let border = border(contact, cycle)?;
    for &(x, y) in &border {
        table.row(&["border"], &[x, y, f64::NAN])?;
    }
    let grows = [(0.0, 0.0), (2000.0, 2000.0 / PROPORTIONAL)];
    Ok(Panel::new("integral gain K_I (N/(m s))", "derivative gain K_D (N s/m)")
        .title("Hunting over two gains (white: comes to rest)")
        .heat_map(HeatMap::new("amplitude (mm)", integral, derivative, amplitude))
        .line("large motions grow below", Colour::Black.dashed(), grows)
        .marked_line("cycles end", Colour::Blue, Colour::Blue, border)
        .own_legend())
}

/// As many runs by hand, on as many threads: companion steps of 1 ms.
fn by_hand(
    contact: &Friction,
    [integral, derivative]: [&[f64]; 2],
    duration: f64,
) -> bristle_charts::Result<()> {
    let friction = contact.companion(1.0)?;
    let run = |integral: f64, derivative: f64| {
        let (h, steps) = (1e-3, (duration / 1e-3) as usize);
        let (mut x, mut v, mut z, mut sum) = (START, 0.0, 0.0, 0.0);
        let mut history = VelocityHistory::new(v);
        for _ in 0..steps {
            let step = friction.step(history.predict(), z, h);
            let force = PROPORTIONAL * x + integral * (sum + 0.5 * h * x) + step.bias();
            let mean = (2.0 / h * v - force)
                / (2.0 / h + derivative + 0.5 * h * PROPORTIONAL + step.damping());
            z = step.commit(mean).deflection;
            sum += h * (x + 0.5 * h * mean);
            (x, v) = (x + h * mean, 2.0 * mean - v);
            history.push(v);
        }
        std::hint::black_box(x);
    };
    let workers = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| {
        for worker in 0..workers {
            scope.spawn(move || {
                for &down in derivative.iter().skip(worker).step_by(workers) {
                    integral.iter().for_each(|&across| run(across, down));
                }
            });
        }
    });
    Ok(())
}

/// The derivative gain at which the stable cycle ends, over the integral gain.
fn border(contact: &Friction, cycle: &Orbit<4>) -> bristle_charts::Result<Vec<(f64, f64)>> {
    let across = Continuation {
        first_step: -30.0,
        stable_only: true,
        most_points: 8,
        ..Continuation::over(200.0..2000.0)
    };
    let of = |integral: f64| ControlLoop::new(control_loop(contact, integral, 20.0));
    let less = across.free(of, 400.0, cycle.guess())?;
    let more = Continuation { first_step: 30.0, ..across }.free(of, 400.0, cycle.guess())?;
    let mut border: Vec<_> = less.special().map(|point| (point.parameter, 20.0)).collect();
    let starts = less.points.iter().chain(more.points.iter().skip(1));
    for start in starts.filter(|point| point.kind == PointKind::Regular) {
        let integral = start.parameter;
        let up = Continuation { first_step: 1.0, ..Continuation::over(10.0..80.0) };
        let of = |derivative: f64| ControlLoop::new(control_loop(contact, integral, derivative));
        let end = up.border(of, 20.0, start.orbit.guess())?;
        border.extend(end.map(|point| (integral, point.parameter)));
    }
    border.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(border)
}

/// Position and velocity along a cycle.
fn along<S: System<f64, N>, const N: usize>(
    system: &S,
    orbit: &Orbit<N>,
) -> bristle_charts::Result<Vec<SVector<f64, N>>> {
    // Unstable ones, too: no check of how errors grow.
    let solver = Solver::adaptive(Automatic, Tolerances::scaled(1e-10, system.scales())?);
    let mut run = solver.begin(system, 0.0..orbit.period, orbit.start)?;
    let mut states = vec![orbit.start];
    while let Some(step) = run.advance()? {
        states.extend([0.25, 0.5, 0.75, 1.0].map(|part| step.at_fraction(part)));
    }
    Ok(states)
}

fn phase_plane<S: System<f64, 4>>(
    system: &S,
    cycle: &Orbit<4>,
    table: &mut Csv,
) -> bristle_charts::Result<Panel> {
    let states = along(system, cycle)?;
    let points: Vec<_> = states.iter().map(|state| (1e3 * state[0], 1e3 * state[1])).collect();
    for &(x, v) in &points {
        table.row(&["phase plane"], &[x, v, f64::NAN])?;
    }
    Ok(Panel::new("position error x (mm)", "velocity v (mm/s)")
        .title(format!("Its cycle at K_I = 400, K_D = 20: T = {:.4} s", cycle.period))
        .line("", Colour::Blue, points))
}

/// Half of the way between the largest and the smallest position of the motions of a branch [mm],
/// stable and unstable.
fn amplitudes(
    contact: &Friction,
    cycle: &Orbit<4>,
    table: &mut Csv,
) -> bristle_charts::Result<Panel> {
    let of = |derivative: f64| ControlLoop::new(control_loop(contact, 400.0, derivative));
    let follow = |first_step: f64, most_points: usize| {
        let along = Continuation { first_step, most_points, ..Continuation::over(2.0..80.0) };
        along.free(of, 20.0, cycle.guess())
    };
    let [down, up]: [OrbitBranch<4>; 2] = [follow(-1.0, 12)?, follow(1.0, 14)?];
    let (mut stable, mut unstable, mut special) = (Vec::new(), Vec::new(), Vec::new());
    for point in down.points.iter().rev().chain(up.points.iter().skip(1)) {
        let states = along(&of(point.parameter)?, &point.orbit)?;
        let most = states.iter().map(|it| it[0]).fold(f64::NEG_INFINITY, f64::max);
        let least = states.iter().map(|it| it[0]).fold(f64::INFINITY, f64::min);
        let at = (point.parameter, 0.5e3 * (most - least));
        table.row(&["amplitude"], &[at.0, at.1, point.orbit.transverse()[0].value().re])?;
        if point.kind == PointKind::Regular {
            if point.orbit.is_stable() { stable.push(at) } else { unstable.push(at) }
        } else {
            special.push(at);
            stable.push(at);
            unstable.insert(0, at);
            println!("at K_I = 400 the cycle loses its stability at K_D = {:.6} N s/m", at.0);
        }
    }
    Ok(Panel::new("derivative gain K_D (N s/m)", "amplitude (mm)")
        .title("Amplitude at K_I = 400")
        .line("stable", Colour::Blue, stable)
        .line("unstable", Colour::Vermilion.dashed(), unstable)
        .points("branches cross", Colour::Black, special)
        .own_legend())
}

/// The speeds above which steady sliding is stable and no cycle of stick-slip is left, over the
/// stiffness.
fn stick_slip_map(table: &mut Csv) -> bristle_charts::Result<Panel> {
    let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
    let contact = FrBd::new(Stribeck::new(paper::STICK_SLIP_CURVE)?, bristle).under_load(1.0)?;
    let (mut onset, mut end) = (Vec::new(), Vec::new());
    println!("\nstiffness (N/m)   steady sliding stable above (m/s)   stick-slip ends at (m/s)");
    for stiffness in [0.1, 0.2, 0.5, 1.0, 2.0, 3.5, 5.0, 10.0, 20.0, 50.0, 100.0] {
        let mechanism =
            Mechanism { spring_stiffness: stiffness, ..paper::stick_slip_rig(contact).mechanism };
        if let Threshold::StableAbove(speed) =
            linear::critical_speed(&contact, mechanism, 1e-3..1.0)?
        {
            onset.push((stiffness, speed));
        }
        let rig = |speed: f64| DrivenMass::new(contact, mechanism, speed);
        // So slow that a mass at rest begins to stick and slip.
        let slow = f64::max(0.05, 0.3 / f64::sqrt(stiffness));
        let ahead = |_: f64, state: &Vector3<f64>| state[1] - slow;
        let overtakes = Event { function: &ahead, direction: Direction::Rising, stops: false };
        let mut along = Continuation { most_points: 200, ..Continuation::over(0.02..2.0) };
        along.shooting.segments = 20;
        let start = rig(slow)?;
        let guess = along.shooting.settle(&start, start.at_rest(), 200.0, &overtakes)?;
        let branch = along.free(rig, slow, guess)?;
        let last = branch.points.iter().map(|point| point.parameter).max_by(f64::total_cmp);
        end.extend(last.map(|speed| (stiffness, speed)));
        let [begins, ends] = [onset.last(), end.last()].map(|it| it.map_or(f64::NAN, |at| at.1));
        println!("{stiffness:15}   {begins:33.6}   {ends:24.6}");
        table.row(&["stick-slip"], &[stiffness, begins, ends])?;
    }
    Ok(Panel::new("spring stiffness k (N/m)", "speed of the drive (m/s)")
        .title("Stick-slip of the rig of the paper (k = 2 N/m)")
        .log_x()
        .log_y()
        .marked_line("steady sliding stable above", Colour::Green, Colour::Green, onset)
        .marked_line("its cycle ends (last fold)", Colour::Vermilion, Colour::Vermilion, end)
        .points("the paper: 0.1 m/s", Colour::Black, [(2.0, 0.1)])
        .own_legend())
}
