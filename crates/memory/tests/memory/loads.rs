//! Loads that vary: elements that share every load, and elements that come one after the other.

use std::f64::consts::TAU;

use bristle::companion::{PointMass, VelocityHistory};
use bristle::curve::{Coulomb, CoulombParameters, Stribeck};
use bristle::{Bristle, Contact, Surface};
use bristle_memory::{LoadedStiffness, MaxwellSlip, MaxwellSlipParameters};
use bristle_specimens::draw::Draw;

use super::{slip, stribeck, zeros};

/// The parameters of a stiffness that follows the load.
type Following<const N: usize> = MaxwellSlipParameters<Stribeck<f64>, f64, N, LoadedStiffness<f64>>;

/// Stiffness K ∝ p^exponent in N bands up to twice the reference load.
fn following<const N: usize>(exponent: f64) -> Following<N> {
    MaxwellSlipParameters {
        curve: stribeck(),
        elements: core::array::from_fn(|i| {
            let load = (i + 1) as f64 * 2.0 / N as f64;
            LoadedStiffness { load, stiffness: 5e3 * load.powf(exponent) }
        }),
        micro_damping: 10.0,
        stick_ratio: 0.9,
    }
}

fn hertz() -> MaxwellSlip<Stribeck<f64>, f64, 24> {
    MaxwellSlip::following_load(following(1.0 / 3.0)).unwrap()
}

#[test]
fn the_stiffness_follows_the_load_and_the_friction_is_proportional_to_it() {
    for exponent in [1.0 / 3.0, 1.0] {
        let model = MaxwellSlip::following_load(following::<24>(exponent)).unwrap();
        let mut contact = model.under_load(8.0).unwrap();
        for band in 1..=40 {
            // Above the last band its friction goes on, its stiffness does not.
            let load = f64::from(band) / 12.0;
            let _ = contact.reload(8.0 * load, 0.0, zeros()).unwrap();
            let want = 8.0 * 5e3 * load.min(2.0).powf(exponent);
            let stiffness = contact.linearised(0.0, zeros()).force_by_deflection.sum();
            assert!((stiffness - want).abs() < 1e-11 * want, "{load}: {stiffness} is not {want}");
            for v in [1e-4, -0.03] {
                let want = 8.0 * load * model.stationary_coefficient(v);
                assert!((contact.stationary_force(v) - want).abs() < 1e-13 * want.abs());
            }
        }
    }
}

#[test]
fn under_the_reference_load_alone_the_share_of_each_element_is_its_band() {
    let lengths = hertz().yield_lengths(Surface::scaled(1.0, 0.7));
    let mu = 1.04; // at 1 m/s
    let shares = lengths.component_mul(&hertz().storage_stiffness().0) / mu;
    for (i, share) in shares.iter().enumerate() {
        let want = (0.7 - i as f64 / 12.0).clamp(0.0, 1.0 / 12.0);
        assert!((share - want).abs() < 1e-15, "{i}: {share} is not {want}");
    }
}

/// Mean velocity [m/s] of a part that hangs in a grip of 16 N ± 50 % at 50 Hz, over two seconds
/// after two.
fn creep<M>(contact: Contact<f64, M>, start: M::Deflection) -> f64
where
    M: Bristle<f64>,
{
    let mut joint = contact.companion(0.1).unwrap();
    let (mut x, mut v, h) = (start, 0.0, 1e-4);
    let (mut history, mut fallen) = (VelocityHistory::new(0.0), 0.0);
    for step in 0..40_000 {
        let load = 16.0 * (1.0 + 0.5 * (TAU * 50.0 * h * (f64::from(step) + 0.5)).sin());
        let predicted = history.predict();
        x = joint.reload(load, predicted, x).unwrap().deflection;
        let friction = joint.step(predicted, x, h);
        let part = PointMass { mass: 0.3, velocity: v, force: 2.943, end_weight: 0.5 };
        let mean = friction.point_mass(part);
        (x, v) = (friction.commit(mean).deflection, 2.0 * mean - v);
        history.push(v);
        if step >= 20_000 {
            fallen += h * mean;
        }
    }
    fallen / 2.0
}

#[test]
fn a_held_part_stands_while_the_stiffness_follows_the_grip() {
    let curve = CoulombParameters { dynamic_coefficient: 0.8, viscous_friction: 0.0 };
    let curve = Coulomb::new(curve).unwrap();
    let Following { elements, micro_damping, stick_ratio, .. } = following::<24>(1.0 / 3.0);
    let parameters = MaxwellSlipParameters { curve, elements, micro_damping, stick_ratio };
    let hertz = MaxwellSlip::following_load(parameters).unwrap().under_load(16.0).unwrap();
    let shared = slip::<_, 10>(curve, 10.0, 0.9).under_load(16.0).unwrap();
    // Displacements of 1e-4 m are rounded to 1e-20 m.
    let speeds = [creep(hertz, zeros()), creep(shared, zeros())];
    assert!(speeds.iter().all(|speed| speed.abs() < 1e-15), "{speeds:?}");
}

#[test]
fn a_load_that_varies_gives_no_energy() {
    let mut draw = Draw::seeded(5);
    let mut joint = hertz().under_load(4.0).unwrap().companion(1.0).unwrap();
    let mut x = zeros();
    for _ in 0..20_000 {
        let velocity = |draw: &mut Draw| draw.sign() * draw.logarithmic(1e-6, 1.0);
        let (predicted, mean) = (velocity(&mut draw), velocity(&mut draw));
        let load = 4.0 * draw.one_of(&[0.0, 0.05, 0.5, 1.0, 1.7, 3.0]) * draw.next();
        let before = joint.contact().stored_energy(x);
        x = joint.reload(load, predicted, x).unwrap().deflection;
        let held = joint.contact().stored_energy(x);
        let step = joint.step(predicted, x, draw.logarithmic(1e-6, 0.1)).commit(mean);
        x = step.deflection;
        let after = joint.contact().stored_energy(x);
        assert!(held <= before);
        // Roundings of 24 terms.
        assert!(step.work - (after - held) >= -1e-14 * (step.work.abs() + held + after));
    }
}

#[test]
fn each_element_slips_back_to_what_its_own_load_holds() {
    let mut contact = hertz().under_load(4.0).unwrap();
    let stuck = contact.stationary(1e-15);
    // At rest the surface holds μ_s, on every element.
    for load in [3.9, 2.0, 0.3, 0.0] {
        let left = contact.reload(load, 0.0, stuck).unwrap();
        let lengths = contact.model().yield_lengths(contact.surface(0.0));
        // The end of a band is a difference of numbers of order one.
        assert!((left.deflection.0 - lengths).amax() < 1e-15 * lengths.amax().max(1e-4), "{load}");
        assert!((contact.force(0.0, left.deflection) - 1.5 * load).abs() < 1e-13);
        assert!(left.dissipated > 0.0);
        // The same force at one instant, of a contact that stays as it is.
        let at_once = hertz().under_load(4.0).unwrap().response_under(load, 0.0, stuck);
        assert!((at_once.force - 1.5 * load).abs() < 1e-13);
        let _ = contact.reload(4.0, 0.0, zeros()).unwrap();
    }
    // A rise leaves everything, and what comes is unstretched.
    let pulled = contact.reload(6.0, 0.0, stuck).unwrap();
    assert_eq!((pulled.deflection, pulled.dissipated), (stuck, 0.0));
}

#[test]
fn an_unusable_stiffness_is_refused_by_name() {
    for (i, point, name) in [
        (0, (0.0, 1.0), "elements.load"),
        (1, (f64::NAN, 1e3), "elements.load"),
        (2, (0.5, 1e4), "elements.load"),
        (2, (2.0, 1e3), "elements.stiffness"),
        (0, (0.1, -1.0), "elements.stiffness"),
    ] {
        let mut parameters = following::<3>(0.5);
        parameters.elements[i] = LoadedStiffness { load: point.0, stiffness: point.1 };
        let error = MaxwellSlip::following_load(parameters).unwrap_err();
        assert_eq!((error.name, error.component), (name, Some(i)));
    }
}
