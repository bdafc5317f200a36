//! A normal force that varies: what is held stands still, and renewal walks. That no history of the
//! load gives energy is in tests/steps/load.rs.
#![allow(clippy::unwrap_used, reason = "a test panics to fail")]

use bristle::companion::{PointMass, VelocityHistory};
use bristle::curve::Stribeck;
use bristle::rheology::{KelvinVoigt, Rheology};
use bristle::{Bristle, Contact, ElastoPlastic, FrBd, Scalar};
use bristle_specimens::recipe::Recipe;
use bristle_specimens::specimens::{kelvin_voigt, stribeck};
use bristle_specimens::{lit, viscoelastic};
use nalgebra::SVector;

/// The part and the grip of the model sheet: 16 N, 0.3 kg, μ 0.8 to 0.6.
fn curve<T: Scalar>() -> Stribeck<T> {
    stribeck(&Recipe { dynamic: 0.6, static_: 0.8, viscous: 0.0, ..Recipe::TABLE_2 }, 2.0)
}

fn bristle<T: Scalar>() -> KelvinVoigt<T> {
    kelvin_voigt(lit(5e3), lit(10.0))
}

type Grip<T> = Contact<T, FrBd<Stribeck<T>, KelvinVoigt<T>>>;

fn grip<T: Scalar>() -> Grip<T> {
    FrBd::new(curve(), bristle()).under_load(lit(GRIP)).unwrap()
}

const GRIP: f64 = 16.0;
const MASS: f64 = 0.3;
const WEIGHT: f64 = 2.943;

/// A part under a constant force, in a grip that varies by a share at a frequency.
struct Held {
    force: f64,
    share: f64,
    frequency: f64,
    /// Length of a step [s], and their number.
    step: f64,
    steps: usize,
    /// Weight of the velocity at the end of a step, see `PointMass`.
    end_weight: f64,
    renews: bool,
}

impl Held {
    /// How far the part has walked after the first second [m].
    fn walked<T: Scalar, M: Bristle<T, Deflection = T>>(&self, contact: Contact<T, M>) -> f64 {
        let mut companion = contact.companion(lit(1.0)).unwrap();
        let (mut velocity, mut z, mut way) = (T::zero(), T::zero(), 0.0);
        let mut history = VelocityHistory::new(T::zero());
        for step in 0..self.steps {
            let time = (step as f64 + 0.5) * self.step;
            let phase = (std::f64::consts::TAU * self.frequency * time).sin();
            let load = lit(GRIP * (1.0 + self.share * phase));
            let predicted = history.predict();
            let reloaded = if self.renews {
                companion.renew(load, z)
            } else {
                companion.reload(load, predicted, z)
            };
            let friction = companion.step(predicted, reloaded.unwrap().deflection, lit(self.step));
            let (force, end_weight) = (lit(self.force), lit(self.end_weight));
            let mean =
                friction.point_mass(PointMass { mass: lit(MASS), velocity, force, end_weight });
            velocity += (mean - velocity) / end_weight;
            history.push(velocity);
            z = friction.commit(mean).deflection;
            if time > 1.0 {
                let mean: f64 = mean.to_subset_unchecked();
                way += self.step * mean;
            }
        }
        way
    }
}

/// Weight and a constant pull, for some seconds: at 60 Hz as an engine steps, and at 1 kHz.
fn scenes(seconds: usize) -> impl Iterator<Item = Held> {
    [(1.0 / 60.0, 60, 1.0), (1e-3, 1000, 0.5)].into_iter().flat_map(move |(step, rate, weight)| {
        [(0.5, 50.0), (0.5, 7.3), (0.1, 50.0), (0.01, 180.0)].map(|(share, frequency)| Held {
            force: WEIGHT + 0.5,
            share,
            frequency,
            step,
            steps: rate * seconds,
            end_weight: weight,
            renews: false,
        })
    })
}

#[test]
fn a_held_part_stands_still_while_the_grip_varies() {
    stands_still_for(60);
}

/// `cargo test --release --test load -- --ignored`.
#[test]
#[ignore = "an hour in steps of a millisecond takes seconds in release and minutes without"]
fn a_held_part_stands_still_for_an_hour() {
    stands_still_for(3600);
}

fn stands_still_for(seconds: usize) {
    for held in scenes(seconds) {
        let Held { share, frequency, step, steps, .. } = held;
        let way = held.walked(grip::<f64>());
        assert!(way.abs() <= 1e-12, "±{share} at {frequency} Hz, steps of {step} s: {way:e} m");
        // In single precision an increment h v below half a rounding of z = 4e-5 m is lost: v
        // stays at up to 2e-12 m over h.
        let (way, bound) = (held.walked(grip::<f32>()), 2e-12 * steps as f64);
        assert!(way.abs() <= bound, "f32, ±{share}, steps of {step} s: {way:e} m of {bound:e}");
    }
}

#[test]
fn renewal_walks_as_its_closed_form_says() {
    // An elastic bristle, slow cycles: (w/σ0)(1/p_min − 1/p_max) each.
    let elastic = ElastoPlastic::new(curve(), bristle(), 1e-4).unwrap().under_load(GRIP).unwrap();
    let renewal = |share: f64, frequency: f64, step: f64, seconds: f64| Held {
        force: WEIGHT,
        share,
        frequency,
        step,
        steps: (seconds / step).round() as usize,
        end_weight: 0.5,
        renews: true,
    };
    let way = renewal(0.5, 1.0, 1e-4, 11.0).walked(elastic);
    let each = WEIGHT / 5e3 * (1.0 / (0.5 * GRIP) - 1.0 / (1.5 * GRIP));
    assert!((way / (10.0 * each) - 1.0).abs() < 0.01, "{way:e} m for ten times {each:e}");
    // With FrBD and the mass, at 50 Hz, the model sheet has 4.57, 0.528 and 0.050 mm/s.
    for (share, speed) in [(0.5, 4.57e-3), (0.1, 0.528e-3), (0.01, 0.050e-3)] {
        let way = renewal(share, 50.0, 1e-4, 11.0).walked(grip::<f64>());
        assert!((way / (10.0 * speed) - 1.0).abs() < 0.01, "{:e} for {speed:e}", way / 10.0);
    }
}

fn zener() -> FrBd<Stribeck<f64>, impl Rheology<f64, Deflection = SVector<f64, 2>>> {
    FrBd::new(curve(), viscoelastic::zener(5e3, 1e4, 30.0))
}

#[test]
fn the_force_stays_within_what_the_load_holds_and_slides_on_the_curve() {
    let mut contact = grip::<f64>();
    let z = contact.stationary(1e-9) * 0.9;
    for load in [16.0, 12.0, 4.0, 0.5] {
        let left = contact.reload(load, 0.0, z).unwrap().deflection;
        let force = contact.force(0.0, left);
        assert!(force <= 0.8 * load * (1.0 + 4.0 * f64::EPSILON), "{force} under {load}");
        // No less than it has to: what the surface holds, or what was there.
        assert!(force >= (0.8 * load).min(0.9 * 0.8 * GRIP) * (1.0 - 1e-12) || left == z);
        let sliding = contact.stationary_force(0.3);
        assert!((sliding - load * 0.6).abs() < 1e-9 * load, "{sliding} under {load}");
        let long = contact.hold(0.3, 0.0, 10.0).end_force;
        assert!((long - sliding).abs() < 1e-12 * load, "{long} for {sliding}");
        contact = grip::<f64>();
    }
    // What carries more than the surface holds falls with the load, and no further.
    let overloaded = 3.0 * contact.stationary(1e-9);
    assert_eq!(contact.reload(0.5 * GRIP, 0.0, overloaded).unwrap().deflection, 0.5 * overloaded);
}

#[test]
fn when_the_tip_slips_every_stretch_shifts_alike() {
    let mut contact = zener().under_load(4.0).unwrap();
    let stiffness = contact.model().storage_stiffness();
    let stretched = SVector::from([6e-5, -1e-5]);
    // At rest the surface holds 0.8 p: under this load half of what the springs carry.
    let carried = 4.0 * stiffness.dot(&stretched);
    let left = contact.reload(0.5 * carried / 0.8, 0.0, stretched).unwrap().deflection;
    let [first, second] = (stretched - left).into();
    assert!(first > 1e-6 && (first - second).abs() < 1e-14 * first, "{first:e} and {second:e}");
    assert!((4.0 * stiffness.dot(&left) - 0.5 * carried).abs() < 1e-14 * carried);
}

#[test]
fn a_constant_load_leaves_the_same_bits() {
    let (mut reloaded, plain) = (grip::<f64>(), grip::<f64>());
    let mut z = 1e-5;
    for v in [0.0, 1e-3, -0.02, 0.7] {
        let left = reloaded.reload(GRIP, v, z).unwrap();
        assert_eq!((left.deflection, left.dissipated), (z, 0.0));
        assert_eq!(reloaded.response(v, z), plain.response(v, z));
        assert_eq!(reloaded.response_under(GRIP, v, z), plain.response(v, z));
        z = plain.hold(v, z, 1e-3).deflection;
        assert_eq!(reloaded.hold(v, left.deflection, 1e-3).deflection, z);
    }
}
