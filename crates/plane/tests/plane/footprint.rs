//! Contact surfaces: sums over points of a footprint.

use std::f64::consts::{PI, TAU};

use bristle::curve::{Coulomb, CoulombParameters, Stribeck};
use bristle_plane::{
    Axis, DiscPressure, Footprint, FootprintPoint, PlaneBristle, PlaneCompanionStep, PlaneContact,
    PlaneFrBd,
};
use nalgebra::{Matrix3, Vector2, Vector3};
use proptest::prelude::*;

use bristle_specimens::recipe::{decades, velocity};
use bristle_specimens::specimens::{table_2_bristle, table_2_curve};
use bristle_specimens::{assert_within, check, integral};

/// μ = 1 under 1 N: forces are those of the limit surface.
fn coulomb() -> PlaneContact<f64, PlaneFrBd<Coulomb<f64>, f64, 2>, 2> {
    let curve = CoulombParameters { dynamic_coefficient: 1.0, viscous_friction: 0.0 };
    PlaneFrBd::isotropic(Coulomb::new(curve).unwrap(), table_2_bristle()).under_load(1.0).unwrap()
}

/// Table 2, six tenths of the friction across.
fn table_2() -> PlaneContact<f64, PlaneFrBd<Stribeck<f64>, f64, 2>, 2> {
    let bristle = table_2_bristle();
    let axes = [1.0, 0.6].map(|friction_ratio| Axis { friction_ratio, bristle });
    PlaneFrBd::new(table_2_curve(), axes).unwrap().under_load(3.0).unwrap()
}

fn disc(pressure: DiscPressure, rings: u16) -> Vec<FootprintPoint<f64>> {
    FootprintPoint::disc(1.0, pressure, rings).collect()
}

#[test]
fn rings_and_cells_carry_what_they_should() {
    for pressure in [DiscPressure::Uniform, DiscPressure::Hertz] {
        let points = disc(pressure, 7);
        assert_eq!(points.len(), 3 * 49);
        let sum = |of: &dyn Fn(&FootprintPoint<f64>) -> f64| points.iter().map(of).sum::<f64>();
        assert_within(1e-13, 1.0, sum(&|p| p.weight), 1.0, || "weights".into());
        for first in [sum(&|p| p.weight * p.place[0]), sum(&|p| p.weight * p.place[1])] {
            assert_within(1e-14, 1.0, first, 0.0, || "centre".into());
        }
        assert!(points.iter().all(|p| p.place[0].hypot(p.place[1]) < 1.0 && p.weight > 0.0));
    }
    let points: Vec<FootprintPoint<f64>> = FootprintPoint::rectangle([4.0, 2.0], [8, 6]).collect();
    assert_eq!(points.len(), 48);
    let second = |axis: usize| points.iter().map(|p| p.place[axis].powi(2)).sum::<f64>() / 48.0;
    // The variance of n middles of a length is L²(1 − 1/n²)/12.
    assert_within(1e-14, 1.0, second(0), 16.0 / 12.0 * (1.0 - 1.0 / 64.0), || "x".into());
    assert_within(1e-14, 1.0, second(1), 4.0 / 12.0 * (1.0 - 1.0 / 36.0), || "y".into());
}

/// The error of a quantity at n and 2 n.
fn converges(want: f64, of: impl Fn(u16) -> f64) {
    let error = |n: u16| (of(n) - want).abs();
    let (coarse, fine) = (error(8), error(16));
    assert!(fine < 2e-3 * want && coarse / fine > 2.7, "{coarse:e}, {fine:e} of {want}");
}

#[test]
fn spin_converges_to_the_full_torque_of_discs_and_squares() {
    let spin = Vector3::new(0.0, 0.0, 1.0);
    let torque = |points| Footprint::new(coulomb(), points).unwrap().stationary_wrench(&spin).z;
    converges(DiscPressure::Uniform.spin_radius(1.0), |n| torque(disc(DiscPressure::Uniform, n)));
    converges(DiscPressure::Hertz.spin_radius(1.0), |n| torque(disc(DiscPressure::Hertz, n)));
    // The mean distance from the centre of a unit square, (√2 + ln(1 + √2))/6.
    let root = 2.0_f64.sqrt();
    converges((root + (1.0 + root).ln()) / 6.0, |n| {
        torque(FootprintPoint::rectangle([1.0, 1.0], [n, n]).collect())
    });
}

/// F = ∫ (v + ω × r)/‖v + ω × r‖ dA/A over a unit disc and its torque under a twist (c, 0, 1), in
/// polar coordinates, in so many panels of each: no points.
fn disc_wrench(c: f64, panels: usize) -> (f64, f64) {
    let over = |part: &dyn Fn(f64, f64, f64, f64) -> f64| {
        integral(0.0, 1.0, panels, |r| {
            let ring = integral(0.0, TAU, panels, |angle| {
                let (x, y) = (r * angle.cos(), r * angle.sin());
                part(x, y, c - y, x) / (c - y).hypot(x)
            });
            ring * r / PI
        })
    };
    (over(&|_, _, v_x, _| v_x), over(&|x, y, v_x, v_y| x * v_y - y * v_x))
}

#[test]
fn the_limit_surface_of_a_disc_is_that_of_the_integral() {
    for ratio in [0.2, 0.7, 1.5, 4.0] {
        let (force, torque) = disc_wrench(ratio, 200);
        let footprint = Footprint::new(coulomb(), disc(DiscPressure::Uniform, 60)).unwrap();
        let got = footprint.stationary_wrench(&Vector3::new(ratio, 0.0, 1.0));
        assert_within(2e-4, 1.0, got.x, force, || format!("force at {ratio}"));
        assert_within(2e-4, 1.0, got.z, torque, || format!("torque at {ratio}"));
        assert!(got.y.abs() < 2e-4, "{got}");
    }
}

#[test]
fn one_point_is_the_contact_and_many_in_one_place_too() {
    let place = FootprintPoint { place: [0.0, 0.0], weight: 2.0 };
    let (v, h) = (Vector2::new(0.03, -0.01), 1e-3);
    let twist = Vector3::new(v.x, v.y, 5.0);
    let contact = table_2();
    let held = contact.hold(&v, &Vector2::new(1e-5, 2e-5), h);
    let passive = contact.companion(1.0).unwrap().step(&(0.5 * v), &Vector2::new(1e-5, 2e-5), h);
    for count in [1, 5] {
        let footprint = Footprint::new(contact, vec![place; count]).unwrap();
        let mut z = vec![Vector2::new(1e-5, 2e-5); count];
        let force = footprint.wrench(&twist, &z);
        assert!((force.xy() - contact.force(&v, &z[0])).norm() < 1e-14 && force.z == 0.0);
        let energy = footprint.stored_energy(&z);
        assert_within(1e-14, energy, contact.stored_energy(&z[0]), energy, || "energy".into());
        let companion = footprint.clone().companion(1.0).unwrap();
        let mut steps = vec![PlaneCompanionStep::default(); z.len()];
        let step = companion.step(&(0.5 * twist), &z, h, &mut steps).unwrap();
        assert!((step.bias.xy() - passive.bias()).norm() < 1e-14);
        let damping = Matrix3::from_diagonal(&passive.damping().push(0.0));
        assert!((step.damping - damping).norm() < 1e-13 * damping.norm());
        let mean = footprint.hold(&twist, &mut z, h).unwrap();
        assert!((mean.xy() - held.mean_force).norm() < 1e-14);
        assert!(z.iter().all(|z| *z == held.deflection));
    }
}

#[test]
fn no_step_of_a_footprint_gives_energy() {
    let point = (-0.1..0.1, -0.1..0.1, prop_oneof![1 => Just(0.0), 4 => decades(1e-2, 1e2)]);
    let load = prop_oneof![1 => Just(0.0), 6 => decades(0.1, 10.0)];
    let twist =
        || (velocity(), velocity(), velocity()).prop_map(|(x, y, spin)| Vector3::new(x, y, spin));
    let draw = (
        prop::collection::vec(point, 1..12),
        prop::collection::vec((load, (twist(), twist(), decades(1e-6, 1.0))), 4),
    );
    check(200, draw, |(points, steps)| {
        let points: Vec<_> = points
            .into_iter()
            .map(|(x, y, weight)| FootprintPoint { place: [x, y], weight })
            .collect();
        if points.iter().all(|point| point.weight == 0.0) {
            return;
        }
        let mut z = vec![Vector2::zeros(); points.len()];
        let mut kept = vec![PlaneCompanionStep::default(); points.len()];
        let mut companion = Footprint::new(table_2(), points).unwrap().companion(1.0).unwrap();
        for (load, (predicted, twist, h)) in steps {
            let before = companion.footprint().stored_energy(&z);
            let lost = companion.reload(load, &predicted, &mut z).unwrap().dissipated;
            let after = companion.footprint().stored_energy(&z);
            assert!(lost >= 0.0 && companion.footprint().contact().normal_force() == load);
            assert_within(1e-13, before, before, after + lost, || format!("reload to {load}"));
            let before = companion.footprint().stored_energy(&z);
            let step = companion.step(&predicted, &z, h, &mut kept).unwrap();
            let damping = step.damping;
            assert!((damping - damping.transpose()).norm() <= 1e-14 * damping.norm());
            let least = damping.symmetric_eigenvalues().min();
            assert!(least >= -1e-13 * damping.norm(), "{least}");
            let done = companion.commit(&kept, &twist, &mut z).unwrap();
            let after = companion.footprint().stored_energy(&z);
            assert!(done.dissipated >= 0.0);
            let what = || format!("{predicted} {twist} {h}");
            let wrench = step.bias + damping * twist;
            let terms = step.bias.abs() + damping.abs() * twist.abs();
            let off = (done.force - wrench).abs();
            assert!((0..3).all(|i| off[i] <= 1e-12 * terms[i]), "{off} of {terms}");
            let scale = h * terms.dot(&twist.abs()) + before + after;
            assert_within(1e-10, scale, done.work, h * wrench.dot(&twist), what);
            assert_within(1e-10, scale, done.stored, after - before, what);
            assert_within(1e-10, scale, done.work, done.stored + done.dissipated, what);
        }
    });
}

#[test]
fn a_changed_load_leaves_what_it_leaves_of_one_contact() {
    let points = [FootprintPoint { place: [0.01, 0.0], weight: 1.0 }; 3];
    let (twist, start) = (Vector3::new(0.01, 0.02, 0.3), Vector2::new(1e-5, 2e-5));
    for load in [0.0, 1.0, 3.0, 7.0] {
        let (mut contact, mut z) = (table_2(), [start; 3]);
        let left = contact.reload(load, &Vector2::new(0.01, 0.023), &start).unwrap();
        let mut companion = Footprint::new(table_2(), points).unwrap().companion(1.0).unwrap();
        let lost = companion.reload(load, &twist, &mut z).unwrap().dissipated;
        assert_eq!(z, [left.deflection; 3]);
        assert_within(1e-14, left.dissipated, lost, left.dissipated, || load.to_string());
        let fresh = Footprint::new(contact, points).unwrap().companion(1.0).unwrap();
        let [mut one, mut other] = [[PlaneCompanionStep::default(); 3]; 2];
        let step = companion.step(&twist, &z, 1e-3, &mut one).unwrap();
        assert_eq!(step, fresh.step(&twist, &z, 1e-3, &mut other).unwrap());
        assert_eq!(one, other);
    }
    let mut footprint = Footprint::new(table_2(), points).unwrap();
    for load in [f64::NAN, f64::INFINITY, -1.0] {
        let (before, mut z) = (footprint, [start; 3]);
        assert_eq!(footprint.reload(load, &twist, &mut z).unwrap_err().name, "normal_force");
        assert!(footprint == before && z == [start; 3]);
    }
    assert!(footprint.reload(1.0, &twist, &mut [start; 2]).is_err());
}

#[test]
fn bad_footprints_are_refused_by_name() {
    let good = FootprintPoint { place: [0.0, 0.0], weight: 1.0 };
    let refused = |point| Footprint::new(coulomb(), [good, point]).unwrap_err();
    for bad in [f64::NAN, f64::INFINITY] {
        for place in [[bad, 0.0], [0.0, bad]] {
            let refused = refused(FootprintPoint { place, ..good });
            assert_eq!((refused.name, refused.component), ("place", Some(1)));
        }
    }
    for weight in [f64::NAN, f64::INFINITY, -1.0] {
        let refused = refused(FootprintPoint { weight, ..good });
        assert_eq!((refused.name, refused.component), ("weight", Some(1)));
    }
    let none = Footprint::new(coulomb(), [FootprintPoint { weight: 0.0, ..good }]).unwrap_err();
    assert_eq!(none.name, "sum of weights");
    assert!(Footprint::new(coulomb(), []).is_err());
    let backwards: [Vec<FootprintPoint<f64>>; 3] = [
        FootprintPoint::disc(-1.0, DiscPressure::Hertz, 3).collect(),
        FootprintPoint::rectangle([-1.0, 1.0], [2, 2]).collect(),
        FootprintPoint::rectangle([1.0, -1.0], [2, 2]).collect(),
    ];
    for points in backwards {
        assert_eq!(Footprint::new(coulomb(), points).unwrap_err().name, "place");
    }

    let footprint = Footprint::new(coulomb(), [good; 3]).unwrap();
    let (mut z, twist) = ([Vector2::zeros(); 2], Vector3::new(1.0, 0.0, 0.0));
    let error = footprint.hold(&twist, &mut z, 1e-3).unwrap_err();
    assert_eq!(error.to_string(), "there must be 3 deflections, not 2");
    assert!(footprint.wrench(&twist, &z).iter().all(|x| x.is_nan()));
    let companion = footprint.companion(1.0).unwrap();
    let (mut still, mut steps) = ([Vector2::zeros(); 3], [PlaneCompanionStep::default(); 3]);
    assert_eq!(companion.step(&twist, &z, 1e-3, &mut steps).unwrap_err().name, "deflections");
    assert_eq!(companion.step(&twist, &still, 1e-3, &mut steps[1..]).unwrap_err().name, "steps");
    let _ = companion.step(&twist, &still, 1e-3, &mut steps).unwrap();
    assert_eq!(companion.commit(&steps, &twist, &mut z).unwrap_err().name, "deflections");
    assert_eq!(companion.commit(&steps[1..], &twist, &mut still).unwrap_err().name, "steps");
    // NaN in, NaN out.
    let bad = Vector3::new(f64::NAN, 0.0, 0.0);
    let step = companion.step(&bad, &still, 1e-3, &mut steps).unwrap();
    assert!(step.bias.x.is_nan() && step.damping[(0, 0)].is_nan());
}

#[test]
fn the_ellipsoid_of_a_disc_is_as_far_off_as_an_integral_over_the_disc_says() {
    // About a point of the rim: 8/(3π) and 8/(9π).
    let (force, torque) = disc_wrench(1.0, 24);
    assert!((force - 8.0 / (3.0 * PI)).abs() < 1e-4 && (torque - 8.0 / (9.0 * PI)).abs() < 1e-4);
    let of_all = |off: &dyn Fn(f64, f64, f64) -> f64| {
        (1..60).map(|k| 0.05 * f64::from(k)).fold(0.0, |most, c| {
            let (force, torque) = disc_wrench(c, 24);
            f64::max(most, off(c, force, 1.5 * torque))
        })
    };
    let farthest = of_all(&|_, force, torque| 1.0 - force.hypot(torque));
    // The ellipsoid answers (c, 0, 1) with the direction of (c, 0, ⅔).
    let apart = of_all(&|c, force, torque| {
        let size = c.hypot(2.0 / 3.0);
        (force - c / size).hypot(torque - 2.0 / 3.0 / size)
    });
    let surface = Footprint::new(coulomb(), disc(DiscPressure::Uniform, 24));
    let ellipsoid = surface.unwrap().limit_ellipsoid();
    assert!((ellipsoid.spin_radius - 2.0 / 3.0).abs() < 1e-3, "{ellipsoid:?}");
    assert!((ellipsoid.surface_error - farthest).abs() < 2e-3, "{ellipsoid:?}, {farthest}");
    assert!((ellipsoid.wrench_error - apart).abs() < 2e-3, "{ellipsoid:?}, {apart}");
    assert!(apart > 0.14, "{apart}");
}

#[test]
fn the_ellipsoids_of_few_points_are_known_in_closed_form() {
    let of = |places: &[[f64; 2]]| {
        let points: Vec<_> =
            places.iter().map(|&place| FootprintPoint { place, weight: 1.0 }).collect();
        Footprint::new(coulomb(), points).unwrap().limit_ellipsoid()
    };
    // A point has no torque.
    let point = of(&[[0.0, 0.0]]);
    assert_eq!((point.spin_radius, point.surface_error, point.wrench_error), (0.0, 0.0, 0.0));
    // Two points whose frictions point along a and b: the square of the wrench is
    // 1 − ¼(cos a − cos b)², at least ¾ where it counts.
    let two = of(&[[0.3, 0.0], [-0.3, 0.0]]);
    assert!((two.spin_radius - 0.3).abs() < 1e-15);
    let error = two.surface_error;
    assert!(error < 1.0 - 0.75_f64.sqrt() + 1e-12 && error > 0.12, "{two:?}");
}

/// As docs/plane.md says; the mean distance from the centre, by quadrature over a quarter.
#[test]
fn few_points_give_the_spin_radius_of_a_rectangle() {
    let want = integral(0.0, 1.0, 100, |x| 2.0 * integral(0.0, 0.5, 100, |y| x.hypot(y)));
    let points: Vec<_> = FootprintPoint::rectangle([2.0, 1.0], [12, 6]).collect();
    let got = Footprint::new(coulomb(), points).unwrap().limit_ellipsoid().spin_radius;
    let off = (got - want).abs() / want;
    assert!((want - 0.593).abs() < 5e-4 && off > 0.0035 && off < 0.0045, "{got} {want}");
}
