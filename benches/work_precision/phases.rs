//! Where a method's evaluations go on stick-slip, S1 with FrBD: `--phases`.
//!
//! A step belongs to the fastest of its two ends: sliding above 3 v_S, the Stribeck range above
//! v_S/10, stuck below. The ring-down is the first half second stuck, in which the mass swings on
//! its bristles.

use std::error::Error;

use bristle::curve::Stribeck;
use bristle::ode::{AnyMethod, Solver, Tolerances};
use bristle::rheology::KelvinVoigt;
use bristle::scene::MassSpringDamper;
use bristle::{Bristle, FrBd, paper};

const NAMES: [&str; 5] = ["ring-down", "creep", "breakaway", "arrest", "sliding"];
const RING_DOWN: f64 = 0.5;

/// Prints evaluations by phase, for steps of several tolerances.
pub(crate) fn report() -> Result<(), Box<dyn Error>> {
    let friction = FrBd::new(
        Stribeck::new(paper::STICK_SLIP_CURVE)?,
        KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?,
    );
    let rig = MassSpringDamper::new(paper::stick_slip_rig(friction.under_load(1.0)?))?;
    let stribeck_velocity = paper::STICK_SLIP_CURVE.stribeck_velocity;
    println!("evaluations on S1 FrBD by phase, reversals while ringing down");
    print!("{:16} {:>9} {:>7}", "method", "tolerance", "all");
    NAMES.iter().for_each(|name| print!(" {name:>9}"));
    println!(" reversals");
    for method in [AnyMethod::DormandPrince8, AnyMethod::Rodas5P, AnyMethod::Automatic] {
        for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
            let tolerances = Tolerances::scaled(tolerance, rig.scales())?;
            let solver = Solver::adaptive(method, tolerances);
            let mut run = solver.begin(&rig, 0.0..100.0, rig.at_rest())?;
            let (mut counts, mut before, mut reversals) = ([0; NAMES.len()], 0, 0);
            let mut arrested = f64::NEG_INFINITY;
            while let Some(step) = run.advance()? {
                let (from, to) = (step.start()[1].abs(), step.end()[1].abs());
                let (end, reverses) = (step.end_time(), step.reversal().is_some());
                let phase = match from.max(to) {
                    speed if speed > 3.0 * stribeck_velocity => 4,
                    speed if speed > 0.1 * stribeck_velocity => 2 + usize::from(to < from),
                    _ => usize::from(end > arrested + RING_DOWN),
                };
                if phase >= 3 {
                    arrested = end;
                }
                reversals += u32::from(phase == 0 && reverses);
                let all = run.statistics().evaluations;
                counts[phase] += all - before;
                before = all;
            }
            print!("{:16} {tolerance:9.0e} {before:7}", method.to_string());
            counts.iter().for_each(|count| print!(" {count:9}"));
            println!(" {reversals:9}");
        }
    }
    Ok(())
}
