//! What the models cost on the Rabinowicz rig, and fixed steps beside those of the field.

use bristle_charts::println;

use super::*;

/// Stick-slip by `ode::solve`: evaluations, and the largest error of the position over 25 s.
pub(super) fn costs() -> Result<()> {
    println!("\nevaluations, error [m] of the position at tolerances of 1e-3, 1e-6, 1e-9");
    let (curve, bristle) = (curve()?, bristle()?);
    scene("static curve", Static(curve))?;
    scene("Dahl", dahl()?)?;
    scene("LuGre", LuGre::classical(curve, bristle))?;
    scene("LuGre, viscous part in g", LuGre::of_frbd(FrBd::new(curve, bristle), 0.0))?;
    scene("FrBD", FrBd::new(curve, bristle))?;
    scene("implicit", ImplicitBristle::new(curve, bristle)?)?;
    scene("elasto-plastic", elasto_plastic()?)?;
    let slow = Elements(ten(0.95)?.under_load(1.0)?);
    evaluations("ten elements", &slow, SVector::zeros())
}

fn scene<M: Bristle<f64, Deflection = f64>>(name: &str, model: M) -> Result<()> {
    let rig = MassSpringDamper::new(paper::stick_slip_rig(model.under_load(1.0)?))?;
    evaluations::<_, 3>(name, &rig, Vector3::zeros())
}

fn evaluations<S: System<f64, N>, const N: usize>(
    name: &str,
    rig: &S,
    start: SVector<f64, N>,
) -> Result<()> {
    let solve = |tolerance| ode::solve(rig, 0.0..25.0, start, tolerance, Output::Uniform(501));
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

/// The rig with ten elements: position, velocity, deflections.
struct Elements(Contact<f64, MaxwellSlip<Stribeck<f64>, f64, 10>>);

impl System<f64, 12> for Elements {
    fn rate(&self, t: f64, state: &SVector<f64, 12>, [branch]: [Branch; 1]) -> SVector<f64, 12> {
        let deflection = Parallel(state.fixed_rows::<10>(2).into_owned());
        let friction = self.0.response(branch.of(state[1]), deflection);
        let mut rate = SVector::<f64, 12>::zeros();
        (rate[0], rate[1]) = (state[1], 2.0 * (0.1 * t - state[0]) - friction.force);
        rate.fixed_rows_mut::<10>(2).copy_from(&friction.rate.0);
        rate
    }

    fn sliding_velocities(&self, _: f64, state: &SVector<f64, 12>) -> [f64; 1] {
        [state[1]]
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
