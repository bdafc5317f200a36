//! x
use bristle::curve::*; use bristle::rheology::*; use bristle::*; use bristle_periodic::*; use bristle::ode::*;
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let curve = Stribeck::new(StribeckParameters { static_coefficient: 5.0, dynamic_coefficient: 3.0, stribeck_velocity: 0.01, stribeck_exponent: 2.0, viscous_friction: 1.0 })?;
    let friction = FrBd::new(curve, KelvinVoigt::new(KelvinVoigtParameters { micro_stiffness: 5e4, micro_damping: 224.0 })?);
    let contact = friction.under_load(1.0)?;
    let make = |kp: f64, ki: f64, kd: f64| ControlLoop::new(ControlLoopParameters { contact, mechanism: Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 }, controller: Pid { proportional: kp, integral: ki, derivative: kd, filter_time: 0.0, sample_time: 0.0 } });
    let r = make(400.0, 400.0, 20.0)?;
    let ahead = |_: f64, s: &nalgebra::SVector<f64, 4>| s[0];
    let ev = Event { function: &ahead, direction: Direction::Rising, stops: false };
    let guess = Shooting::default().settle(&r, r.displaced(0.02), 60.0, &ev)?;
    let show = |name: &str, b: &OrbitBranch<4>| {
        for p in &b.points { println!("{name} {:.9} T {:.6} {:?} v0 {:.5} mu {:.3e}", p.parameter, p.orbit.period, p.kind, p.orbit.start[1], p.orbit.transverse()[0].value().re); }
        println!("{:?}", b.end);
    };
    let t = std::time::Instant::now();
    let c = Continuation { most_points: 40, first_step: 0.3, ..Continuation::over(5.0..100.0) };
    show("Kd", &c.free(|kd| make(400.0, 400.0, kd), 20.0, guess)?);
    println!("{:?}", t.elapsed());
    let c = Continuation { most_points: 40, first_step: 3.0, ..Continuation::over(1.0..1000.0) };
    show("Ki", &c.free(|ki| make(400.0, ki, 20.0), 400.0, guess)?);
    println!("{:?}", t.elapsed());
    Ok(())
}
