//! Single precision in the long run, beside double precision from the same numbers.

use bristle::{
    Bristle, FrBd, KelvinVoigt, KelvinVoigtParameters, LuGre, Scalar, Stribeck, StribeckParameters,
    paper,
};
use nalgebra::convert;

type Set = (StribeckParameters<f64>, KelvinVoigtParameters<f64, f64>);

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

/// Mean forces of a million milliseconds, back and forth through the Stribeck range at 0.5 Hz, with ten
/// seconds of creep in every twenty: held and passive.
fn forces<T: Scalar>(set: Set) -> impl Iterator<Item = [f64; 2]> {
    let (curve, bristle) = parts::<T>(set);
    let contact = FrBd::new(curve, bristle).under_load(lit(1.0)).unwrap();
    let companion = contact.companion(lit(1.0)).unwrap();
    let (mut held, mut passive) = (T::zero(), T::zero());
    (0..1_000_000).map(move |number| {
        let time = 1e-3 * f64::from(number);
        let size = if (time * 0.05).fract() < 0.5 { 5.0 } else { 1e-3 };
        let velocity = lit((std::f64::consts::PI * time).sin() * size * set.0.stribeck_velocity);
        let step = contact.hold(velocity, held, lit(1e-3));
        held = step.deflection;
        let done = companion.step(velocity, passive, lit(1e-3)).commit(velocity);
        passive = done.deflection;
        [step.mean, done.force].map(|force| force.to_subset_unchecked())
    })
}

#[test]
fn a_million_steps_do_not_drift() {
    for set in SETS {
        let mut worst = [[0.0_f64; 2]; 10];
        let pairs = forces::<f32>(set).zip(forces::<f64>(set));
        for (number, (single, double)) in pairs.enumerate() {
            for kind in 0..2 {
                let off = (single[kind] - double[kind]).abs() / set.0.static_coefficient;
                let slot = &mut worst[number / 100_000][kind];
                *slot = slot.max(off);
            }
        }
        for tenth in worst {
            for (first, off) in worst[0].into_iter().zip(tenth) {
                // While it creeps it forgets nothing, and adds up roundings of half a last place.
                assert!(off < 1e-4, "{worst:?}");
                // The same a quarter of an hour later.
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
        for (got, want) in [(got.end, want.end), (got.mean, want.mean)] {
            // A dozen roundings, and at 1 m/s those of a rate of which e⁻¹⁰ is left.
            assert!((f64::from(got) / want - 1.0).abs() < 1e-6, "{speed}: {got} {want}");
        }
    }
}
