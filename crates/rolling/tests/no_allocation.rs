//! A patch in combined slip allocates nothing: neither its construction nor a step.
#![allow(clippy::unwrap_used, reason = "a test panics to fail")]

use bristle::curve::Stribeck;
use bristle::paper;
use bristle::rheology::KelvinVoigt;
use bristle_plane::PlaneFrBd;
use bristle_rolling::{Motion, Patch, PatchParameters, PolynomialExponential, Segment};
use nalgebra::Vector2;

#[test]
fn a_patch_in_combined_slip_allocates_nothing() {
    let curve = Stribeck::new(paper::TYRE_CURVE).unwrap();
    let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE).unwrap();
    let counted = allocation_counter::measure(|| {
        let tyre = Patch::new(PatchParameters {
            model: PlaneFrBd::isotropic(curve, bristle),
            length: bristle_rolling::TYRE_LENGTH,
            pressure: PolynomialExponential::parabolic().padded::<4>(),
        });
        let mut rolling = tyre.unwrap().combined([[Segment::default(); 40]; 2]).unwrap();
        for number in 0..200 {
            let slip_velocity = Vector2::new(0.5, 0.01 * f64::from(number));
            let motion = Motion { slip_velocity, rolling_speed: 16.0 };
            let load = 4000.0 - 10.0 * f64::from(number);
            let _ = rolling.reload(load, &slip_velocity).unwrap();
            let _ = rolling.renew(load + 5.0).unwrap();
            rolling.step(motion, 1e-3).unwrap();
            let step = rolling.companion_step(motion, 1e-4).unwrap();
            step.commit_with_ledger(&slip_velocity).unwrap();
            assert!(rolling.moment(&slip_velocity).y.is_finite());
        }
    });
    assert_eq!(counted.count_total, 0);
}
