//! A string in its modes under a bow. It moves as Helmholtz saw it, sticking to the bow but for one
//! slip in each period, between a least and a largest bow force.
//!
//! A map of the motion over bow position β and bow force, from runs that begin in Helmholtz motion,
//! stands beside the limits of J. C. Schelleng, "The bowed string and the player", J. Acoust. Soc.
//! Am. 53 (1973), with Z the impedance of the string, α the decay of its low modes, v_b the
//! velocity of the bow and Δμ = μ_s − μ_d:
//!
//! F_max = 2 Z v_b/(β Δμ),  F_min = Z α v_b/(4 f₁ β² Δμ)
//!
//! A string as it is published solves in each sample for the relative velocity and the deflection
//! by Newton's method: elasto-plastic friction with the bristle law of P. Dupont et al. (2002) as
//! in S. Serafin, F. Avanzini, D. Rocchesso, "Bowed string simulation using an elasto-plastic
//! friction model" (2003), and S. Willemsen, S. Bilbao, S. Serafin, "Real-time implementation of an
//! elasto-plastic friction model applied to stiff strings" (2019). It is compared with
//! elasto-plastic FrBD in companion steps on the same modes: errors are those of each against
//! itself in far shorter steps, for the two models are not the same. Both string updates are plain
//! loops over the modes.
//!
//! Leaves `bowed_string.csv` (the map), `bowed_string.svg` and `bowed_string.wav`, the force on the
//! bridge as sound.

use std::f64::consts::PI;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use bristle::companion::Companion;
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, ElastoPlastic, FrBd, ParameterError};
use bristle_charts::{Arguments, Colour, Csv, Figure, Panel, Progress, Rule, Symbol, println};
use bristle_mechanism::{ContactState, Inputs, LinearMechanism, Matrices, Motion, Structure};

const MODES: usize = 60;
/// Pitch [Hz], length [m] and impedance √(tension · mass per length) [kg/s] of the string.
const PITCH: f64 = 196.0;
const LENGTH: f64 = 0.33;
const IMPEDANCE: f64 = 0.386;
/// Decay of the lowest modes [1/s], and its rise with the square of the number of the mode.
const DECAY: f64 = 3.0;
const DECAY_RISE: f64 = 0.1;
/// Friction of rosin: static and dynamic coefficient, Stribeck velocity [m/s], bristle.
const STATIC: f64 = 0.8;
const DYNAMIC: f64 = 0.3;
const STRIBECK: f64 = 0.1;
const MICRO_STIFFNESS: f64 = 1e4; // 1/m
const MICRO_DAMPING: f64 = 1.0; // s/m
const STICK_LIMIT: f64 = 0.7 * DYNAMIC / MICRO_STIFFNESS; // m
/// Samples a second.
const RATE: f64 = 88_200.0;

fn main() -> ExitCode {
    bristle_charts::run(|| {
        let arguments = Arguments::new("bowed_string", "A bowed string, its forces and its sound")
            .number("force", 0.7, "N", "bow force of the sound")
            .must_be(Rule::Positive)
            .number("position", 0.12, "", "bow position of the sound, as share of the length")
            .must_be(Rule::Between(0.01, 0.5))
            .number("velocity", 0.1, "m/s", "velocity of the bow")
            .must_be(Rule::Positive)
            .number("end", 1.5, "s", "length of the sound")
            .must_be(Rule::Between(0.1, 60.0))
            .count("cells", 22, "columns and rows of the map")
            .must_be(Rule::Between(2.0, 200.0))
            .parse()?;
        let [force, position, velocity, end] =
            ["force", "position", "velocity", "end"].map(|name| arguments.number(name));
        let bow = Bow { force, position, velocity };
        let (out, cells) = (arguments.out_dir(), arguments.count("cells"));

        let mut string = Bowed::new(frbd()?, &bow, 1.0 / RATE, 0.0)?;
        let samples = (end * RATE) as usize;
        let sound: Result<Vec<_>, ParameterError> = (0..samples)
            .map(|n| {
                // The bow comes down in 50 ms.
                let load = force * (n as f64 / (0.05 * RATE)).clamp(1e-3, 1.0);
                string.step(load)?;
                Ok((n as f64 / RATE, string.bridge_force(), string.velocity()))
            })
            .collect();
        let sound = sound?;
        write_wav(&out.join("bowed_string.wav"), sound.iter().map(|sample| sample.1))?;

        let map = map(velocity, cells)?;
        let mut table = Csv::create(out, "bowed_string", &["motion", "position", "force"])?;
        for (motion, points) in &map {
            for (position, force) in points {
                table.row(&[motion], &[*position, *force])?;
            }
        }
        table.finish()?;
        for (motion, points) in &map {
            println!("{motion:17} {:5} of {} cells", points.len(), cells * cells);
        }
        let compared = compare(&bow)?;
        println!("{}", figure(&bow, &sound, &map, &compared).save(out, "bowed_string")?.display());
        Ok(())
    })
}

/// A bow: its force [N], its place as a share of the string, its velocity [m/s].
#[derive(Clone, Copy)]
struct Bow {
    force: f64,
    position: f64,
    velocity: f64,
}

/// Modal mass [kg], and damping, stiffness and shape at the bow of each mode. The stiffness is such
/// that the trapezoidal rule in steps of h rings at the frequency ω of the mode: (2/h) tan(ω h/2).
fn modes(bow: &Bow, h: f64) -> (f64, [[f64; MODES]; 3]) {
    let mass = IMPEDANCE / (4.0 * PITCH); // ρ L/2 with Z = ρ c and c = 2 L f₁
    let of = |value: &dyn Fn(f64) -> f64| std::array::from_fn(|n| value((n + 1) as f64));
    let damping = of(&|n| 2.0 * mass * (DECAY + DECAY_RISE * n * n));
    let stiffness = of(&|n| mass * (2.0 / h * (PI * PITCH * n * h).tan()).powi(2));
    (mass, [damping, stiffness, of(&|n| (n * PI * bow.position).sin())])
}

/// Velocities of the modes in Helmholtz motion, when its corner is at the nut and the string is
/// straight: those of v_b x/x_b, with the corner rounded by Lanczos' factors.
fn helmholtz(bow: &Bow) -> [f64; MODES] {
    std::array::from_fn(|n| {
        let n = (n + 1) as f64;
        let sign = if n % 2.0 == 1.0 { 1.0 } else { -1.0 };
        let angle = PI * n / (MODES + 1) as f64;
        sign * 2.0 * bow.velocity / (bow.position * PI * n) * angle.sin() / angle
    })
}

type Rosin = (Stribeck<f64>, KelvinVoigt<f64>);

fn rosin() -> Result<Rosin, ParameterError> {
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: STATIC,
        dynamic_coefficient: DYNAMIC,
        stribeck_velocity: STRIBECK,
        stribeck_exponent: 2.0,
        viscous_friction: 0.0,
    })?;
    let bristle =
        KelvinVoigtParameters { micro_stiffness: MICRO_STIFFNESS, micro_damping: MICRO_DAMPING };
    Ok((curve, KelvinVoigt::new(bristle)?))
}

fn frbd() -> Result<FrBd<Stribeck<f64>, KelvinVoigt<f64>>, ParameterError> {
    let (curve, bristle) = rosin()?;
    Ok(FrBd::new(curve, bristle))
}

/// The shape of each mode at the bow.
type Row = Vec<(usize, f64)>;

/// A string under a bow in companion steps.
struct Bowed<M: Bristle<f64>> {
    mechanism: LinearMechanism<f64, [Row; 1], Vec<f64>>,
    companion: Companion<f64, M>,
    contact: [ContactState<f64, M::Deflection>; 1],
    position: [f64; MODES],
    velocity: [f64; MODES],
    bow: f64,
    h: f64,
}

impl<M: Bristle<f64, Deflection = f64>> Bowed<M> {
    /// In a share of the Helmholtz motion.
    fn new(model: M, bow: &Bow, h: f64, share: f64) -> Result<Self, ParameterError> {
        let (mass, [damping, stiffness, shape]) = modes(bow, h);
        let matrices = Matrices {
            structure: Structure::Diagonal,
            mass: &[mass; MODES],
            damping: &damping,
            stiffness: &stiffness,
        };
        let row = shape.into_iter().enumerate().collect();
        let companion = model.under_load(bow.force)?.companion(bow.velocity / bow.position)?;
        Ok(Self {
            mechanism: LinearMechanism::on_heap(&matrices, [row])?,
            contact: [ContactState::new(&companion, 0.0)],
            companion,
            position: [0.0; MODES],
            velocity: helmholtz(bow).map(|v| share * v),
            bow: bow.velocity,
            h,
        })
    }

    fn step(&mut self, load: f64) -> Result<(), ParameterError> {
        let motion = Motion { position: &mut self.position, velocity: &mut self.velocity };
        let inputs = Inputs { force: &[0.0; MODES], prescribed: &[-self.bow], load: &[load] };
        let companions = std::slice::from_ref(&self.companion);
        self.mechanism.step(self.h, &inputs, motion, companions, &mut self.contact)
    }

    /// Velocity of the string under the bow [m/s].
    fn velocity(&self) -> f64 {
        self.mechanism.sliding_velocity(0, &self.velocity)
    }

    fn displacement(&self) -> f64 {
        self.mechanism.sliding_velocity(0, &self.position)
    }

    /// Force of the string on the bridge [N]: its tension Z c times its slope.
    fn bridge_force(&self) -> f64 {
        let slopes =
            self.position.iter().enumerate().map(|(n, q)| (n + 1) as f64 * PI / LENGTH * q);
        IMPEDANCE * 2.0 * LENGTH * PITCH * slopes.sum::<f64>()
    }
}

/// The cells of a map, by the name of their motion.
type Map = [(&'static str, Vec<(f64, f64)>); 3];

fn map(velocity: f64, cells: usize) -> Result<Map, ParameterError> {
    let mut map = ["one slip a period", "several", "not periodic"].map(|name| (name, Vec::new()));
    let place = |from: f64, to: f64, k| from * (to / from).powf(k as f64 / (cells - 1) as f64);
    let mut progress = Progress::new("map", cells);
    for column in 0..cells {
        for row in 0..cells {
            let (position, force) = (place(0.03, 0.25, column), place(5e-3, 20.0, row));
            let bow = Bow { force, position, velocity };
            map[kind(&bow)?].1.push((position, force));
        }
        progress.step();
    }
    Ok(map)
}

/// Which motion it is from the 60th period to the 80th: periodic with one slip in each, periodic
/// with another number of slips, or not periodic.
fn kind(bow: &Bow) -> Result<usize, ParameterError> {
    let mut string = Bowed::new(frbd()?, bow, 1.0 / RATE, 1.0)?;
    let period = (RATE / PITCH).round() as usize;
    let mut velocities = Vec::with_capacity(80 * period);
    for _ in 0..80 * period {
        string.step(bow.force)?;
        velocities.push(bow.velocity - string.velocity());
    }
    let late = velocities.split_off(59 * period);
    let (before, after) = (&late[..20 * period], &late[period..]);
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let change = square(&mut before.iter().zip(after).map(|(a, b)| a - b));
    if !(change < 0.05 * square(&mut after.iter().copied())) {
        return Ok(2);
    }
    // The string of Helmholtz slips at v_b/β.
    let slip = bow.velocity / bow.position;
    let (mut slides, mut slips) = (true, 0);
    for speed in after {
        slips += usize::from(*speed > 0.3 * slip && !slides);
        slides = *speed > if slides { 0.1 } else { 0.3 } * slip;
    }
    Ok(usize::from(!(19..=21).contains(&slips)))
}

/// The string with elasto-plastic friction solved by Newton's method in each sample.
struct Newton {
    modes: [[f64; MODES]; 3],
    inverse: [f64; MODES],
    position: [f64; MODES],
    velocity: [f64; MODES],
    response: f64,
    deflection: f64,
    sliding: f64,
    bow: Bow,
    h: f64,
    tolerance: f64,
    iterations: u64,
    /// Samples in which 100 iterations were not enough.
    lost: u32,
}

impl Newton {
    fn new(bow: &Bow, h: f64, tolerance: f64) -> Self {
        let (mass, modes) = modes(bow, h);
        let half = 0.5 * h;
        let inverse: [f64; MODES] =
            std::array::from_fn(|n| 1.0 / (mass + half * (modes[0][n] + half * modes[1][n])));
        let response =
            modes[2].iter().zip(&inverse).map(|(shape, a)| half * shape * shape * a).sum();
        let (velocity, bow) = (helmholtz(bow), *bow);
        let (position, deflection) = ([0.0; MODES], 0.0);
        let (sliding, iterations, lost) = (0.0, 0, 0);
        Self {
            modes,
            inverse,
            position,
            velocity,
            response,
            deflection,
            sliding,
            bow,
            h,
            tolerance,
            iterations,
            lost,
        }
    }

    /// ż, ∂ż/∂v and ∂ż/∂z of Dupont's law.
    fn rate(v: f64, z: f64) -> [f64; 3] {
        if v * z <= 0.0 || z.abs() <= STICK_LIMIT {
            return [v, 1.0, 0.0];
        }
        let excess = (STATIC - DYNAMIC) * (-(v / STRIBECK).powi(2)).exp() / MICRO_STIFFNESS;
        let (steady, slope) =
            (DYNAMIC / MICRO_STIFFNESS + excess, -2.0 * v.abs() / STRIBECK.powi(2) * excess);
        let (width, size) = (steady - STICK_LIMIT, z.abs());
        let [alpha, by_size, by_steady] = if size >= steady {
            [1.0, 0.0, 0.0]
        } else {
            let beside = size - 0.5 * (steady + STICK_LIMIT);
            let (sine, cosine) = (PI * beside / width).sin_cos();
            let rise = 0.5 * PI * cosine / width;
            [0.5 + 0.5 * sine, rise, -rise * (0.5 + beside / width)]
        };
        let share = size / steady;
        let by_speed = (by_steady * share - alpha * share / steady) * slope;
        let by_size = by_size * share + alpha / steady;
        [v * (1.0 - alpha * share), 1.0 - alpha * share - v.abs() * by_speed, -v.abs() * by_size]
    }

    fn step(&mut self) {
        let (h, half, [damping, stiffness, shape]) = (self.h, 0.5 * self.h, &self.modes);
        let mut acceleration = [0.0; MODES];
        let mut free = -self.bow.velocity;
        for n in 0..MODES {
            let (x, v) = (self.position[n], self.velocity[n]);
            acceleration[n] = -(damping[n] * v + stiffness[n] * (x + half * v)) * self.inverse[n];
            free += shape[n] * (v + half * acceleration[n]);
        }
        // v + G F = free, ż = 2 (z̄ − z)/h, from the values of the step before.
        let (p, before) = (self.bow.force, self.deflection);
        let by_mean = p * (MICRO_STIFFNESS + MICRO_DAMPING * 2.0 / h);
        let force = |z: f64| p * (MICRO_STIFFNESS * z + MICRO_DAMPING * 2.0 * (z - before) / h);
        let (mut v, mut z) = (self.sliding, before);
        for iteration in 1..=100 {
            let [rate, by_v, by_z] = Self::rate(v, z);
            let first = v - free + self.response * force(z);
            let second = rate - 2.0 * (z - before) / h;
            let (across, last) = (self.response * by_mean, by_z - 2.0 / h);
            let determinant = last - across * by_v;
            let dv = (first * last - second * across) / determinant;
            let dz = (second - by_v * first) / determinant;
            (v, z) = (v - dv, z - dz);
            self.iterations += 1;
            self.lost += u32::from(iteration == 100);
            if dv.abs() + dz.abs() < self.tolerance {
                break;
            }
        }
        let force = force(z);
        for n in 0..MODES {
            let a = acceleration[n] - self.inverse[n] * shape[n] * force;
            self.position[n] += h * (self.velocity[n] + half * a);
            self.velocity[n] += h * a;
        }
        (self.sliding, self.deflection) = (v, 2.0 * z - before);
    }

    fn displacement(&self) -> f64 {
        self.modes[2].iter().zip(&self.position).map(|(shape, q)| shape * q).sum()
    }
}

/// A string that is compared with others at the samples of 20 ms.
struct Timed {
    displacements: Vec<f64>,
    /// Time that a second of sound takes [s].
    time: f64,
    iterations: f64,
}

const COMPARED: usize = 1764;

/// The best of five runs with so many steps a sample.
fn timed<S>(
    steps: u32,
    new: impl Fn() -> Result<S, ParameterError>,
    step: impl Fn(&mut S) -> Result<(), ParameterError>,
    read: impl Fn(&S) -> (f64, u64),
) -> Result<Timed, ParameterError> {
    let mut best = Timed { displacements: Vec::new(), time: f64::INFINITY, iterations: 0.0 };
    for _ in 0..5 {
        let (mut string, mut displacements, beginning) = (new()?, Vec::new(), Instant::now());
        for _ in 0..COMPARED {
            for _ in 0..steps {
                step(&mut string)?;
            }
            displacements.push(read(&string).0);
        }
        let time = beginning.elapsed().as_secs_f64() * RATE / COMPARED as f64;
        let iterations = read(&string).1 as f64 / (COMPARED as f64 * f64::from(steps));
        best = Timed { displacements, time: time.min(best.time), iterations };
    }
    Ok(best)
}

/// Time over error of companion steps, and of Newton's method to 1e-15 as published and to 1e-7.
type Compared = [(&'static str, Vec<(f64, f64)>); 3];

const RATES: [u32; 4] = [1, 2, 4, 8];

fn compare(bow: &Bow) -> Result<Compared, ParameterError> {
    let companion = |steps: u32| {
        let h = 1.0 / (RATE * f64::from(steps));
        let new = || {
            let (curve, bristle) = rosin()?;
            Bowed::new(ElastoPlastic::new(curve, bristle, STICK_LIMIT)?, bow, h, 1.0)
        };
        timed(steps, new, |string| string.step(bow.force), |string| (string.displacement(), 0))
    };
    let newton = |tolerance: f64| {
        move |steps: u32| {
            let h = 1.0 / (RATE * f64::from(steps));
            let new = || Ok(Newton::new(bow, h, tolerance));
            let step = |string: &mut Newton| {
                string.step();
                Ok(())
            };
            timed(steps, new, step, |string| (string.displacement(), string.iterations))
        }
    };
    for force in [0.7, 2.0, 8.0] {
        let bow = Bow { force, ..*bow };
        let mut string = Newton::new(&bow, 1.0 / RATE, 1e-7);
        (0..RATE as u32).for_each(|_| string.step());
        let (lost, iterations) = (string.lost, string.iterations as f64 / RATE);
        println!(
            "Newton under {force} N: {lost} of {RATE} samples lost, {iterations:.1} iterations"
        );
    }
    println!("                  samples a second   error, rms/rms   time of a second   iterations");
    Ok([
        ("companion", errors("companion", &companion)?),
        ("Newton to 1e-15", errors("Newton to 1e-15", &newton(1e-15))?),
        ("Newton to 1e-7", errors("Newton to 1e-7", &newton(1e-7))?),
    ])
}

fn errors(
    name: &str,
    run: &dyn Fn(u32) -> Result<Timed, ParameterError>,
) -> Result<Vec<(f64, f64)>, ParameterError> {
    let exact = run(128)?.displacements;
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let size = square(&mut exact.iter().copied());
    RATES
        .into_iter()
        .map(|steps| {
            let Timed { displacements, time, iterations } = run(steps)?;
            let off = square(&mut displacements.iter().zip(&exact).map(|(a, b)| a - b));
            let (error, rate) = ((off / size).sqrt(), f64::from(steps) * RATE);
            println!("{name:16} {rate:17.0} {error:16.1e} {time:16.3} s {iterations:12.2}");
            Ok((time, error))
        })
        .collect()
}

fn figure(bow: &Bow, sound: &[(f64, f64, f64)], map: &Map, compared: &Compared) -> Figure {
    let last = sound.last().map_or(0.0, |sample| sample.0);
    let shown = sound.iter().filter(|sample| sample.0 > last - 3.0 / PITCH);
    let velocities =
        shown.map(|(time, _, v)| ((time - last) * 1e3 + 3e3 / PITCH, v / bow.velocity));
    let waveform = Panel::new("time t (ms)", "velocity / v_b")
        .title("velocity under the bow")
        .line("", Colour::Blue, velocities.collect::<Vec<_>>());
    let shown = sound.iter().filter(|sample| sample.0 > last - 3.0 / PITCH);
    let forces = shown.map(|(time, f, _)| ((time - last) * 1e3 + 3e3 / PITCH, *f));
    let bridge = Panel::new("time t (ms)", "force (N)").title("force on the bridge: its sound");
    let bridge = bridge.line("", Colour::Blue, forces.collect::<Vec<_>>());
    let mut schelleng = Panel::new("bow position β", "bow force (N)")
        .title("slips over the bow's place and force")
        .log_x()
        .log_y()
        .own_legend();
    let colours = [Colour::Blue, Colour::Orange, Colour::Grey];
    for ((motion, points), colour) in map.iter().zip(colours) {
        schelleng = schelleng.points(*motion, Symbol::from(colour).size(6.0), points);
    }
    let positions = [0.03, 0.25];
    let slope = IMPEDANCE * bow.velocity / (STATIC - DYNAMIC);
    let most = positions.map(|at| (at, 2.0 * slope / at));
    let least = positions.map(|at| (at, slope * DECAY / (4.0 * PITCH * at * at)));
    schelleng = schelleng
        .line("Schelleng", Colour::Black, most)
        .line("Schelleng", Colour::Black, least)
        .y_range(5e-3..=20.0);
    let mut precision = Panel::new("computing time of a second of sound (s)", "error, rms/rms")
        .title("error over cost")
        .log_x()
        .log_y()
        .own_legend();
    for ((name, points), colour) in
        compared.iter().zip([Colour::Blue, Colour::Orange, Colour::Green])
    {
        precision = precision.marked_line(name, colour, colour, points);
    }
    Figure::new(900, 760)
        .columns(2)
        .title("A bowed string")
        .panel(waveform)
        .panel(schelleng)
        .panel(bridge)
        .panel(precision)
}

/// Sixteen bits, one channel, the loudest sample at 0.7 of the range.
fn write_wav(path: &Path, sound: impl Iterator<Item = f64> + Clone) -> std::io::Result<()> {
    let loudest = sound.clone().fold(1e-30, |most: f64, sample| most.max(sample.abs()));
    let samples = sound.clone().count() as u32;
    let rate = RATE as u32;
    let mut bytes = Vec::with_capacity(44 + 2 * samples as usize);
    bytes.extend(b"RIFF");
    bytes.extend((36 + 2 * samples).to_le_bytes());
    bytes.extend(b"WAVEfmt ");
    bytes.extend(16_u32.to_le_bytes()); // what follows of the format
    bytes.extend(1_u16.to_le_bytes()); // integers
    bytes.extend(1_u16.to_le_bytes()); // channels
    bytes.extend(rate.to_le_bytes());
    bytes.extend((2 * rate).to_le_bytes()); // bytes a second
    bytes.extend(2_u16.to_le_bytes()); // bytes of a sample in all channels
    bytes.extend(16_u16.to_le_bytes()); // bits of a sample
    bytes.extend(b"data");
    bytes.extend((2 * samples).to_le_bytes());
    for sample in sound {
        bytes.extend(((sample / loudest * 0.7 * f64::from(i16::MAX)) as i16).to_le_bytes());
    }
    std::fs::write(path, bytes)
}
