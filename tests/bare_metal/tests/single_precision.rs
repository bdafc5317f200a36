//! Single precision in the long run, beside double precision from the same numbers.

use bristle::companion::VelocityHistory;
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Bristle, FrBd, LuGre, Scalar, paper};
use nalgebra::convert;

/// Steps of a tenth of the long run: a swing of ten seconds and as long a creep.
const TENTH: u32 = 20_000;

type Set = (StribeckParameters<f64>, KelvinVoigtParameters<f64>);

const SETS: [Set; 2] = [
    (paper::STICK_SLIP_CURVE, paper::STICK_SLIP_BRISTLE),
    (paper::VALVE_CURVE, paper::VALVE_BRISTLE),
];

/// Rounded to single precision, in either type.
fn lit<T: Scalar>(value: f64) -> T {
    convert(f64::from(value as f32))
}

fn parts<T: Scalar>((curve, bristle): Set) -> (Stribeck<T>, KelvinVoigt<T>) {
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: lit(curve.static_coefficient),
        dynamic_coefficient: lit(curve.dynamic_coefficient),
        stribeck_velocity: lit(curve.stribeck_velocity),
        stribeck_exponent: lit(curve.stribeck_exponent),
        viscous_friction: lit(curve.viscous_friction),
    });
    let bristle = KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness: lit(bristle.micro_stiffness),
        micro_damping: lit(bristle.micro_damping),
    });
    (curve.unwrap(), bristle.unwrap())
}

/// Mean forces of some hundred thousand milliseconds, back and forth through the Stribeck range at
/// 0.5 Hz, with ten seconds of creep in every twenty: held and passive.
fn forces<T: Scalar>(set: Set) -> impl Iterator<Item = [f64; 2]> {
    let (curve, bristle) = parts::<T>(set);
    let contact = FrBd::new(curve, bristle).under_load(lit(1.0)).unwrap();
    let companion = contact.companion(lit(1.0)).unwrap();
    let (mut held, mut passive) = (T::zero(), T::zero());
    (0..10 * TENTH).map(move |number| {
        let time = 1e-3 * f64::from(number);
        let size = if (time * 0.05).fract() < 0.5 { 5.0 } else { 1e-3 };
        let velocity = lit((std::f64::consts::PI * time).sin() * size * set.0.stribeck_velocity);
        let step = contact.hold(velocity, held, lit(1e-3));
        held = step.deflection;
        let done = companion.step(velocity, passive, lit(1e-3)).commit(velocity);
        passive = done.deflection;
        [step.mean_force, done.force].map(|force| force.to_subset_unchecked())
    })
}

#[test]
fn hundreds_of_thousands_of_steps_do_not_drift() {
    for set in SETS {
        let mut worst = [[0.0_f64; 2]; 10];
        let pairs = forces::<f32>(set).zip(forces::<f64>(set));
        for (number, (single, double)) in pairs.enumerate() {
            for kind in 0..2 {
                let off = (single[kind] - double[kind]).abs() / set.0.static_coefficient;
                let slot = &mut worst[number / TENTH as usize][kind];
                *slot = slot.max(off);
            }
        }
        for tenth in worst {
            for (first, off) in worst[0].into_iter().zip(tenth) {
                // While it creeps it forgets nothing, and adds up roundings of half a last place.
                assert!(off < 1e-4, "{worst:?}");
                // The same minutes later.
                assert!(off < 2.0 * first + 1e-6, "{worst:?}");
            }
        }
    }
}

#[test]
fn lugre_keeps_its_digits_in_fast_sliding() {
    // σ1 v is 6450 here and the force 5: taken from each other they would leave 1e-4 of it.

    let (curve, bristle) = parts::<f32>(SETS[0]);
    let (wide_curve, wide_bristle) = parts::<f64>(SETS[0]);
    let (single, double) =
        (LuGre::classical(curve, bristle), LuGre::classical(wide_curve, wide_bristle));
    for speed in [1.0_f32, 10.0, 100.0, 1000.0] {
        let (got, want) = (
            single.hold(speed, 1e-4, 1e-3),
            double.hold(f64::from(speed), f64::from(1e-4_f32), f64::from(1e-3_f32)),
        );
        for (got, want) in [
            (got.end_coefficient, want.end_coefficient),
            (got.mean_coefficient, want.mean_coefficient),
        ] {
            // A dozen roundings, and at 1 m/s those of a rate of which e⁻¹⁰ is left.
            assert!((f64::from(got) / want - 1.0).abs() < 1e-6, "{speed}: {got} {want}");
        }
    }
    let companion = single.under_load(1.0).unwrap().companion(1.0).unwrap();
    let wide_companion = double.under_load(1.0).unwrap().companion(1.0).unwrap();
    for speed in [1.0_f32, 10.0, 100.0, 1000.0] {
        let done = companion.step(speed, 1e-4, 1e-3).commit(speed);
        let wide = f64::from(speed);
        let wanted =
            wide_companion.step(wide, f64::from(1e-4_f32), f64::from(1e-3_f32)).commit(wide);
        // The mean of the rate is v σ1 φ1 = σ1 g/(σ0 h) = 6.5 here: some roundings of that. And one
        // of σ1 v, because σ2 is what is left of c₂ = σ1 + σ2.
        let rounding = f64::from(f32::EPSILON) * 64.5 * wide;
        let way = 1e-3 * wide;
        for (got, want, scale) in
            [(done.force, wanted.force, 1.0), (done.dissipated, wanted.dissipated, way)]
        {
            let off = (f64::from(got) - want).abs();
            assert!(off < 4e-6 * want.abs() + rounding * scale, "{speed}: {got} {want}");
        }
    }
}

/// Stick-slip of the paper's rig in passive steps of a millisecond: times of breaking away, and
/// every force.
fn stick_slip<T: Scalar>(seconds: u32) -> (Vec<f64>, Vec<f64>) {
    let (curve, bristle) = parts::<T>(SETS[0]);
    let companion =
        FrBd::new(curve, bristle).under_load(lit(1.0)).unwrap().companion(lit(1.0)).unwrap();
    let (mass, stiffness, drive, h) = (lit::<T>(1.0), lit::<T>(2.0), lit::<T>(0.1), lit::<T>(1e-3));
    let two = lit::<T>(2.0);
    // The stretch of the spring, not the positions of its ends: those grow, and lose their digits.
    let (mut stretch, mut velocity, mut deflection) = (T::zero(), T::zero(), T::zero());
    let mut history = VelocityHistory::new(velocity);
    let (mut times, mut forces) = (Vec::new(), Vec::new());
    for number in 0..1000 * seconds {
        let step = companion.step(history.predict(), deflection, h);
        let pull = stiffness * (stretch + h * drive / two);
        let mean = (two * mass / h * velocity + pull - step.bias())
            / (two * mass / h + h * stiffness / two + step.damping());
        let done = step.commit(mean);
        let next = two * mean - velocity;
        if velocity <= drive && next > drive {
            times.push(1e-3 * f64::from(number));
        }
        stretch += h * (drive - mean);
        (velocity, deflection) = (next, done.deflection);
        history.push(velocity);
        forces.push(done.force.to_subset_unchecked());
    }
    (times, forces)
}

#[test]
fn stick_slip_has_the_same_period_and_the_same_forces() {
    let ((times, forces), (wide_times, wide_forces)) =
        (stick_slip::<f32>(500), stick_slip::<f64>(500));
    let period = |times: &[f64]| (times[times.len() - 1] - times[1]) / (times.len() - 2) as f64;
    let mean = |forces: &[f64]| forces.iter().sum::<f64>() / forces.len() as f64;
    let most = |forces: &[f64]| forces.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = |forces: &[f64]| forces[10_000..].iter().copied().fold(f64::INFINITY, f64::min);
    let spread = |forces: &[f64]| {
        let about = mean(forces);
        forces.iter().map(|force| (force - about).powi(2)).sum::<f64>().sqrt()
    };
    assert_eq!((times.len(), wide_times.len()), (65, 65));
    for (name, got, want, bound) in [
        // A step adds 0.1 mm to a stretch of half a metre, rounded to 3e-8 m: 3e-4 of it at worst.
        ("period", period(&times), period(&wide_times), 3e-4),
        ("mean force", mean(&forces), mean(&wide_forces), 3e-4),
        ("spread of the force", spread(&forces), spread(&wide_forces), 3e-4),
        // Breaking away.
        ("largest force", most(&forces), most(&wide_forces), 1e-5),
        // One step out of thousands, whose place in its period differs.
        ("least force", least(&forces), least(&wide_forces), 1e-3),
    ] {
        let off = (got / want - 1.0).abs();
        println!("{name}: {got} and {want}, off by {off:.1e}");
        assert!(off < bound, "{name}: {got} and {want}, off by {off:.1e}");
    }
}
