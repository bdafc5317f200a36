//! What is measured, for one friction at one rate.

use std::error::Error;

use bristle::ode::{self, Output};
use bristle::rheology::KelvinVoigtParameters;
use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
use bristle::{Bristle, Mechanism};

use crate::scene::{BELT, BRISTLE, CURVE, Friction, GRAVITY, MASS, SPRING, Scene, frbd};

/// Any error.
pub type Outcome<T> = Result<T, Box<dyn Error>>;

/// A quantity over time or angle.
pub type Course = Vec<(f64, f64)>;

/// Before anything is measured the block settles [s].
const SETTLING: f64 = 1.0;

/// The slope [rad] on which the block needs half of the friction that it could have.
pub fn half_breakaway() -> f64 {
    (0.5 * CURVE.static_coefficient).atan()
}

/// Displacement [m] over time [s] on a slope that needs half of the friction.
pub fn creep(friction: Friction, rate: f64, seconds: f64) -> Outcome<Course> {
    creep_believing(1.0, friction, rate, seconds)
}

/// The same if the coupling by a force is told a wrong mass, in parts of the true one.
pub fn creep_believing(mass: f64, friction: Friction, rate: f64, seconds: f64) -> Outcome<Course> {
    let mut scene = Scene::slope(friction, rate, half_breakaway())?;
    scene.bond.believed_mass *= mass;
    settle(&mut scene, rate)?;
    let start = scene.place();
    run(&mut scene, rate, seconds, |scene, t| (t, scene.place() - start))
}

/// The load of [`load_cycles`], in parts of the friction that the block could have.
pub const LOADS: [f64; 2] = [0.4, 0.6];

/// Displacement [m] over time [s] on the level, under a pull that swings between two [`LOADS`] once
/// a second.
pub fn load_cycles(friction: Friction, rate: f64, cycles: f64) -> Outcome<Course> {
    let mut scene = Scene::slope(friction, rate, 0.0)?;
    let [least, most] = LOADS;
    let pull = |t: f64| {
        let share = 0.5 * (least + most) + 0.5 * (most - least) * (std::f64::consts::TAU * t).sin();
        share * CURVE.static_coefficient * GRAVITY
    };
    // Loaded over a second, and the first cycle, which still feels that.
    let steps = rate.round() as usize;
    for n in 0..steps {
        scene.world.gravity.x = pull(0.0) * (n + 1) as f64 / rate;
        scene.step()?;
    }
    for n in 0..steps {
        scene.world.gravity.x = pull(n as f64 / rate);
        scene.step()?;
    }
    let start = scene.place();
    let mut course = Vec::new();
    for n in 0..(rate * cycles).round() as usize {
        let t = n as f64 / rate;
        course.push((t, scene.place() - start));
        scene.world.gravity.x = pull(t);
        scene.step()?;
    }
    course.push((cycles, scene.place() - start));
    Ok(course)
}

/// What FrBD and LuGre drift in each such cycle if it is slow [m]. With u the share of the
/// friction, ẋ = ż + u|ẋ| and z = u z_max make dx = z_max du/(1 ∓ u) on the way up and down, and
/// round a cycle z_max ln((1 − u₁²)/(1 − u₂²)).
pub fn drift_law() -> f64 {
    let KelvinVoigtParameters { micro_stiffness, .. } = BRISTLE;
    let [least, most] = LOADS;
    CURVE.static_coefficient / micro_stiffness * ((1.0 - least * least) / (1.0 - most * most)).ln()
}

/// How fast the plane tilts [°/s].
const TILTING: f64 = 0.1;

/// The velocity that tells that the block slides [m/s].
const SLIDES: f64 = 0.01;

/// Velocity [m/s] over the angle [°] of a plane that tilts from some degrees on until the block
/// slides, or to 40°.
pub fn tilt(friction: Friction, rate: f64, from: f64) -> Outcome<Course> {
    let mut scene = Scene::tilting(friction, rate, from.to_radians(), TILTING.to_radians())?;
    settle(&mut scene, rate)?;
    let mut course = Vec::new();
    while scene.angle().to_degrees() < 40.0 {
        scene.step()?;
        course.push((scene.angle().to_degrees(), scene.velocity()));
        if !(scene.velocity() < SLIDES) {
            break;
        }
    }
    Ok(course)
}

/// By what part the acceleration on a slope of 40° is wrong, from one second after the release to
/// two.
pub fn acceleration_error(friction: Friction, rate: f64) -> Outcome<f64> {
    let angle = 40.0_f64.to_radians();
    let mut scene = Scene::slope(friction, rate, angle)?;
    settle(&mut scene, rate)?;
    let before = scene.velocity();
    settle(&mut scene, rate)?;
    let acceleration = (scene.velocity() - before) / SETTLING;
    let expected = GRAVITY * (angle.sin() - friction.sliding_coefficient() * angle.cos());
    Ok(acceleration / expected - 1.0)
}

/// Place [m] over time [s] on the belt.
pub fn belt(friction: Friction, rate: f64, seconds: f64) -> Outcome<Course> {
    let mut scene = Scene::belt(friction, rate)?;
    run(&mut scene, rate, seconds, |scene, t| (t, scene.block_x()))
}

/// The same without an engine: the crate's own scene, seen from the belt, at a tolerance of 1e-9.
pub fn belt_reference(seconds: f64) -> Outcome<Course> {
    let rig = MassSpringDamper::new(MassSpringDamperParameters {
        contact: frbd()?.under_load(MASS * GRAVITY)?,
        mechanism: Mechanism { mass: MASS, spring_stiffness: SPRING, viscous_damping: 0.0 },
        drive_velocity: -BELT,
        force: 0.0,
    })?;
    let samples = Output::Uniform((200.0 * seconds) as usize + 1);
    let motion = ode::solve(&rig, 0.0..seconds, rig.at_rest(), 1e-9, samples)?;
    Ok(motion.iter().map(|(t, state)| (t, state[0] + BELT * t)).collect())
}

/// Peak to peak [m] and period [s] of the second half of a course; no period where nothing swings.
pub fn swing(course: &[(f64, f64)]) -> (f64, Option<f64>) {
    let half = course.get(course.len() / 2..).unwrap_or_default();
    let (low, high) = half
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &(_, x)| (low.min(x), high.max(x)));
    let middle = 0.5 * (low + high);
    let falls: Vec<f64> = half
        .windows(2)
        .filter_map(|pair| match pair {
            &[(t0, x0), (t1, x1)] if x0 >= middle && x1 < middle => {
                Some(t0 + (t1 - t0) * (x0 - middle) / (x0 - x1))
            }
            _ => None,
        })
        .collect();
    let period = match falls.as_slice() {
        [first, .., last] => Some((last - first) / (falls.len() - 1) as f64),
        _ => None,
    };
    (high - low, period)
}

/// Launched on the level at some velocity [m/s]: by how much the energy of block and bristles ever
/// rises [J] above its lowest value so far, over two seconds.
pub fn energy_gain(friction: Friction, rate: f64, velocity: f64) -> Outcome<f64> {
    let mut scene = Scene::slope(friction, rate, 0.0)?;
    settle(&mut scene, rate)?;
    scene.launch(velocity);
    let stored = |scene: &Scene| scene.bond.law(0).ledger().total().stored;
    let (mut least, mut gain) = (scene.mechanical_energy() + stored(&scene), 0.0_f64);
    for _ in 0..(2.0 * rate) as usize {
        scene.step()?;
        let energy = scene.mechanical_energy() + stored(&scene);
        gain = gain.max(energy - least);
        least = least.min(energy);
    }
    Ok(gain)
}

fn settle(scene: &mut Scene, rate: f64) -> Outcome<()> {
    (0..(SETTLING * rate).round() as usize).try_for_each(|_| scene.step())
}

fn run(
    scene: &mut Scene,
    rate: f64,
    seconds: f64,
    look: impl Fn(&Scene, f64) -> (f64, f64),
) -> Outcome<Course> {
    let mut course = vec![look(scene, 0.0)];
    for n in 1..=(seconds * rate).round() as usize {
        scene.step()?;
        course.push(look(scene, n as f64 / rate));
    }
    Ok(course)
}
