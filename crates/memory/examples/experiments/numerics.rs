//! What the models cost on three rigs, and fixed steps beside those of the field.

use bristle::Mechanism;
use bristle::scene::{MassSpringDamper, MassSpringDamperParameters};
use bristle::signal::{Signal, Sine, SineParameters};
use bristle_charts::println;

use super::*;

/// A mass of 1 kg under 1 N, on a spring whose end moves, under a sine.
struct Rig {
    name: &'static str,
    /// Stiffness of the spring [N/m] and velocity of its end [m/s].
    spring: [f64; 2],
    /// Amplitude \[N\] and frequency [Hz] of the force.
    force: [f64; 2],
    /// Position \[m\] at the beginning.
    start: f64,
    end: f64,
}

const RIGS: [Rig; 3] = [
    Rig { name: "Rabinowicz", spring: [2.0, 0.1], force: [0.0, 1e-3], start: 0.0, end: 25.0 },
    Rig { name: "forced", spring: [0.0, 0.0], force: [2.0, 0.5], start: 0.0, end: 10.0 },
    Rig { name: "let go", spring: [20.0, 0.0], force: [0.0, 1e-3], start: 0.5, end: 5.0 },
];

/// Each rig by `ode::solve`: evaluations, and the largest error of the position.
pub(super) fn costs() -> Result<()> {
    let (curve, bristle) = (curve()?, bristle()?);
    for rig in &RIGS {
        println!("\n{}: evaluations, error [m] at tolerances of 1e-3, 1e-6, 1e-9", rig.name);
        scene("static curve", rig, Static(curve))?;
        scene("Dahl", rig, dahl()?)?;
        scene("LuGre", rig, LuGre::classical(curve, bristle))?;
        let viscous = LuGre::of_frbd(FrBd::new(curve, bristle), 0.0);
        scene("LuGre, viscous part in g", rig, viscous)?;
        scene("FrBD", rig, FrBd::new(curve, bristle))?;
        scene("implicit", rig, ImplicitBristle::new(curve, bristle)?)?;
        scene("elasto-plastic", rig, elasto_plastic()?)?;
        let slow = Elements { contact: ten(0.95)?.under_load(1.0)?, force: sine(rig)?, rig };
        let mut start = SVector::zeros();
        start[0] = rig.start;
        evaluations("ten elements", &slow, start, rig.end)?;
    }
    Ok(())
}

fn sine(rig: &Rig) -> Result<Sine<f64>> {
    let [amplitude, frequency] = rig.force;
    Ok(Sine::new(SineParameters { mean: 0.0, amplitude, frequency, phase: 0.0 })?)
}

fn scene<M: Bristle<f64, Deflection = f64>>(name: &str, rig: &Rig, model: M) -> Result<()> {
    let [spring_stiffness, drive_velocity] = rig.spring;
    let mass = MassSpringDamper::new(MassSpringDamperParameters {
        contact: model.under_load(1.0)?,
        mechanism: Mechanism { mass: 1.0, spring_stiffness, viscous_damping: 0.0 },
        drive_velocity,
        force: sine(rig)?,
    })?;
    evaluations::<_, 3>(name, &mass, Vector3::new(rig.start, 0.0, 0.0), rig.end)
}

fn evaluations<S: System<f64, N>, const N: usize>(
    name: &str,
    rig: &S,
    start: SVector<f64, N>,
    end: f64,
) -> Result<()> {
    let solve = |tolerance| ode::solve(rig, 0.0..end, start, tolerance, Output::Uniform(501));
    let reference = solve(1e-10)?;
    let mut line = format!("{name:24}");
    for tolerance in [1e-3, 1e-6, 1e-9] {
        let run = match solve(tolerance) {
            Ok(run) => run,
            Err(error) => {
                line += &format!("  {error}");
                continue;
            }
        };
        let pairs = run.states().iter().zip(reference.states());
        let error = pairs.map(|(one, other)| (one[0] - other[0]).abs()).fold(0.0, f64::max);
        line += &format!("  {:7} {error:.1e}", run.statistics().evaluations);
    }
    println!("{line}");
    Ok(())
}

/// A rig with ten elements: position, velocity, deflections.
struct Elements<'a> {
    contact: Contact<f64, MaxwellSlip<Stribeck<f64>, f64, 10>>,
    force: Sine<f64>,
    rig: &'a Rig,
}

impl System<f64, 12> for Elements<'_> {
    fn rate(&self, t: f64, state: &SVector<f64, 12>, [branch]: [Branch; 1]) -> SVector<f64, 12> {
        let deflection = Parallel(state.fixed_rows::<10>(2).into_owned());
        let friction = self.contact.response(branch.of(state[1]), deflection);
        let [stiffness, speed] = self.rig.spring;
        let force = self.force.value(t) + stiffness * (speed * t - state[0]);
        let mut rate = SVector::<f64, 12>::zeros();
        (rate[0], rate[1]) = (state[1], force - friction.force);
        rate.fixed_rows_mut::<10>(2).copy_from(&friction.rate.0);
        rate
    }

    fn sliding_velocities(&self, _: f64, state: &SVector<f64, 12>) -> [f64; 1] {
        [state[1]]
    }

    fn longest_step(&self) -> Option<f64> {
        self.force.longest_step()
    }

    fn scales(&self) -> SVector<f64, 12> {
        SVector::from_fn(|i, _| if i < 2 { 1.0 } else { STATIC / STIFFNESS })
    }
}

/// Largest error of the position \[m\] over 25 s of the stick-slip rig over the length of the step
/// \[s\], each against its own limit: the companion step with FrBD; backward Euler with a slider
/// behind the bristle (Kikuuwe and others); with a slider alone (Moreau, Jean).
pub(super) fn fixed_steps() -> Result<Vec<(&'static str, Stroke, Points)>> {
    let model = FrBd::new(curve()?, bristle()?);
    let companion = |count: usize| -> Result<Vec<f64>> {
        let (mut block, h) = (Block::new(&model)?, 0.5 / count as f64);
        Ok(sampled(count, |t| {
            let place = block.x + 0.5 * h * block.v;
            block.step(2.0 * (0.1 * (t + 0.5 * h) - place), h);
            block.x
        }))
    };
    let slider = |count: usize, stiffness: f64| -> Result<Vec<f64>> {
        let (curve, h, mut state) = (curve()?, 0.5 / count as f64, [0.0; 3]);
        let damping = paper::STICK_SLIP_BRISTLE.micro_damping;
        Ok(sampled(count, |t| {
            let [x, v, z] = state;
            let (mass, force) = (1.0 / h + 2.0 * h, v / h + 2.0 * (0.1 * (t + h) - x));
            let most: f64 = curve.at(v);
            let resists = stiffness * h + damping;
            let sticks = if stiffness.is_finite() {
                (force - stiffness * z) / (mass + resists)
            } else {
                0.0
            };
            let friction = (force - mass * sticks).clamp(-most, most);
            let v = (force - friction) / mass;
            state = [x + h * v, v, (friction * h + damping * z) / resists];
            state[0]
        }))
    };
    let counts = (0..9).map(|i| 20 << i);
    let errors = |run: &dyn Fn(usize) -> Result<Vec<f64>>| -> Result<Points> {
        let limit = run(160_000)?;
        let error = |count: usize| {
            let pairs = run(count)?.into_iter().zip(&limit).map(|(x, end)| (x - end).abs());
            Ok((0.5 / count as f64, pairs.fold(0.0, f64::max)))
        };
        counts.clone().map(error).collect()
    };
    Ok(vec![
        ("companion step, FrBD", Colour::Sky.into(), errors(&companion)?),
        ("slider behind a bristle", Colour::Sky.dashed(), errors(&|n| slider(n, STIFFNESS))?),
        ("slider alone", Colour::Vermilion.dotted(), errors(&|n| slider(n, f64::INFINITY))?),
    ])
}

/// What 25 s in `count` steps each half a second give at the end of each.
fn sampled(count: usize, mut step: impl FnMut(f64) -> f64) -> Vec<f64> {
    let h = 0.5 / count as f64;
    let mut half = |i: usize| (0..count).fold(0.0, |_, n| step(0.5 * i as f64 + h * n as f64));
    (0..50).map(&mut half).collect()
}
