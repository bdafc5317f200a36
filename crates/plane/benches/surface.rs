//! Steps of a square contact surface of n² points beside those of its cheap model, three axes with
//! a spin radius, all within one run: microseconds, and ratios. The command is
//! `cargo bench -p bristle-plane --bench surface`.
//!
//! Twist (0.1 m/s, −0.05 m/s, 1.59 rad/s) and step (0.1 ms) are those of the published script of G.
//! A. Waltersson and Y. Karayiannidis, "Planar friction modelling with LuGre dynamics and limit
//! surfaces" (IEEE Transactions on Robotics 40, 2024), whose reduced model is 63 to 80 times as
//! fast as its distributed one. What is unfair: theirs is LuGre by an explicit step, ours FrBD by
//! an exact or a passive one; theirs reads its limit surface from a table, ours is the ellipsoid.
//!
//! Every line is the best of many rounds, and the lines take turns, so that other load of the
//! machine affects them alike.

use std::hint::black_box;
use std::time::Instant;

use bristle::curve::Stribeck;
use bristle::paper;
use bristle::rheology::KelvinVoigt;
use bristle_plane::{
    DiscPressure, Footprint, FootprintPoint, PlaneBristle, PlaneCompanionStep, PlaneFrBd,
};
use nalgebra::{Vector2, Vector3};

/// Rounds of which the best counts, and steps in each over the number of points.
const ROUNDS: usize = 400;
const STEPS: usize = 4000;
/// Side of the square [m], and length of a step [s].
const SIDE: f64 = 0.02;
const STEP: f64 = 1e-4;

/// Microseconds of a step of the best round so far.
struct Best(f64);

impl Best {
    fn time(&mut self, steps: usize, mut work: impl FnMut()) {
        let start = Instant::now();
        (0..steps).for_each(|_| work());
        self.0 = self.0.min(start.elapsed().as_secs_f64() * 1e6 / steps as f64);
    }
}

fn main() -> Result<(), bristle::ParameterError> {
    let twist = Vector3::new(0.1, -0.05, 1.59);
    let curve = Stribeck::new(paper::STICK_SLIP_CURVE)?;
    let bristle = KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?;
    let point = PlaneFrBd::<_, f64, 2>::isotropic(curve, bristle).under_load(1.0)?;
    let spin = PlaneFrBd::<_, f64, 3>::isotropic(curve, bristle).under_load(1.0)?;
    let passive_spin = spin.companion(1.0)?;
    println!("points   exact step   of three axes   passive step   of three axes");
    for n in [5, 9, 17, 33] {
        let points: Vec<_> = FootprintPoint::rectangle([SIDE, SIDE], [n, n]).collect();
        let count = points.len();
        let surface = Footprint::new(point, points)?;
        let passive = surface.clone().companion(1.0)?;
        let radius = surface.limit_ellipsoid().spin_radius;
        let axes = Vector3::new(twist.x, twist.y, twist.z * radius);
        let mut z = vec![Vector2::zeros(); count];
        let (mut along, mut kept) = (Vector3::zeros(), vec![PlaneCompanionStep::default(); count]);
        let mut best: [Best; 4] = [(); 4].map(|()| Best(f64::INFINITY));
        let [exact, whole, exact_axes, passive_axes] = &mut best;
        let steps = (STEPS / count).max(4);
        for _ in 0..ROUNDS {
            exact.time(steps, || {
                let _ = black_box(surface.hold(black_box(&twist), &mut z, STEP));
            });
            whole.time(steps, || {
                if let Ok(step) = passive.step(black_box(&twist), &z, STEP, &mut kept) {
                    let _ = black_box(passive.commit(&kept, &twist, &mut z));
                    black_box((step.bias, step.damping));
                }
            });
            exact_axes.time(STEPS, || {
                let held = black_box(spin.hold(black_box(&axes), &along, STEP));
                along = held.deflection;
            });
            passive_axes.time(STEPS, || {
                let step = passive_spin.step(black_box(&axes), &along, STEP);
                let done = black_box(step.commit(&axes));
                along = done.deflection;
            });
        }
        let [exact, whole, exact_axes, passive_axes] = best.map(|best| best.0);
        println!(
            "{count:6} {exact:9.2} µs {:15.0} {whole:11.2} µs {:15.0}",
            exact / exact_axes,
            whole / passive_axes
        );
    }
    println!("\ncontact surface   spin radius   error of the ellipsoid: surface, wrench");
    let disc = |pressure| FootprintPoint::disc(1.0, pressure, 24).collect();
    let rectangle = |length| FootprintPoint::rectangle([length, 1.0], [48, 48]).collect();
    let ring = |k: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 200.0).sin_cos();
        FootprintPoint { place: [cos, sin], weight: 1.0 }
    };
    let surfaces: [(&str, Vec<_>); 6] = [
        ("Hertz disc / radius", disc(DiscPressure::Hertz)),
        ("disc / radius", disc(DiscPressure::Uniform)),
        ("ring / radius", (0..200).map(ring).collect()),
        ("square / side", rectangle(1.0)),
        ("rectangle 2:1 / width", rectangle(2.0)),
        ("rectangle 4:1 / width", rectangle(4.0)),
    ];
    for (name, points) in surfaces {
        let ellipsoid = Footprint::new(point, points)?.limit_ellipsoid();
        let errors = [ellipsoid.surface_error, ellipsoid.wrench_error].map(|error| 100.0 * error);
        println!(
            "{name:22} {:8.4} {:22.1} % {:5.1} %",
            ellipsoid.spin_radius, errors[0], errors[1]
        );
    }
    Ok(())
}
