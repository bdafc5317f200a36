//! x
use bristle::curve::*;
use bristle::ode::*;
use bristle::rheology::*;
use bristle::*;
use bristle_periodic::*;
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let friction = FrBd::new(
        Stribeck::new(paper::STICK_SLIP_CURVE)?,
        KelvinVoigt::new(paper::STICK_SLIP_BRISTLE)?,
    );
    let contact = friction.under_load(1.0)?;
    let rig = paper::stick_slip_rig(contact);
    let system = |speed: f64| DrivenMass::new(contact, rig.mechanism, speed);
    let r = system(0.1)?;
    let ahead = |_: f64, s: &nalgebra::Vector3<f64>| s[1] - 0.1;
    let ev = Event { function: &ahead, direction: Direction::Rising, stops: false };
    let guess = Shooting::default().settle(&r, r.at_rest(), 40.0, &ev)?;
    let t = std::time::Instant::now();
    let c = Continuation { most_points: 150, ..Continuation::over(0.02..2.0) };
    let b = c.free(system, 0.1, guess)?;
    for p in &b.points {
        println!(
            "{:.9} T {:.6} {:?} x {:.3?} mu {:.3e}",
            p.parameter,
            p.orbit.period,
            p.kind,
            p.orbit.start.as_slice(),
            p.orbit.transverse()[0].value().re
        );
    }
    println!("{:?} {:?}", b.end, t.elapsed());
    Ok(())
}
