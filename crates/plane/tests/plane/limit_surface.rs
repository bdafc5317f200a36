//! The twist of a wrench, and limit surfaces from pushes.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::cell::Cell;

use bristle::nalgebra::{Matrix3, Vector3};
use bristle::scalar::{Scalar, lit, to_f64};
use bristle_plane::{
    Axis, DiscPressure, EllipsoidFamily, Footprint, FootprintPoint, FrictionEllipsoid,
    LimitSurfaceError, PlaneBristle, PlaneFrBd, Push, Support,
};
use bristle_specimens::check;
use proptest::prelude::*;

fn contact<T: Scalar>(
    ratios: [f64; 2],
) -> bristle_plane::PlaneContact<T, impl PlaneBristle<T, 2> + use<T>, 2> {
    use bristle::curve::{Coulomb, CoulombParameters};
    use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
    let bristle = KelvinVoigtParameters { micro_stiffness: lit(1e4), micro_damping: lit(10.0) };
    let bristle = KelvinVoigt::new(bristle).unwrap();
    let curve = CoulombParameters { dynamic_coefficient: lit(0.5), viscous_friction: T::zero() };
    let axes = ratios.map(|ratio| Axis { friction_ratio: lit(ratio), bristle });
    PlaneFrBd::new(Coulomb::new(curve).unwrap(), axes).unwrap().under_load(lit(10.0)).unwrap()
}

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-1.0..1.0_f64)
        .prop_filter("no direction", |x| Vector3::from(*x).norm() > 0.05)
        .prop_map(move |x| Vector3::from(x) * size)
}

/// A matrix B = L Lᵀ whose semi-axes differ by up to some tens.
fn matrix() -> impl Strategy<Value = Matrix3<f64>> {
    (prop::array::uniform3(0.3..3.0_f64), prop::array::uniform3(-1.0..1.0_f64)).prop_map(
        |([a, b, c], [d, e, f])| {
            let factor = Matrix3::new(a, 0.0, 0.0, d, b, 0.0, e, f, c);
            factor * factor.transpose()
        },
    )
}

#[test]
fn the_twist_of_an_ellipsoid_is_its_normal_and_gives_the_wrench_back() {
    check(300, (matrix(), vector(4.0)), |(matrix, wrench)| {
        let ellipsoid = FrictionEllipsoid::new(matrix).unwrap();
        let sliding = ellipsoid.twist(&wrench).unwrap();
        // Roundings over the squared ratio of the semi-axes.
        let back = ellipsoid.wrench(&sliding.twist) * sliding.utilisation;
        assert!((back - wrench).norm() < 1e-10 * wrench.norm(), "{back}");
        assert!((wrench.dot(&sliding.twist) - 1.0).abs() < 1e-10);
        let inverse = matrix.try_inverse().unwrap();
        assert!(
            (sliding.utilisation.powi(2) - wrench.dot(&(inverse * wrench))).abs()
                < 1e-9 * sliding.utilisation.powi(2)
        );
        // Maximum dissipation: no other wrench of the surface does more work.
        let most = ellipsoid.wrench(&sliding.twist).dot(&sliding.twist);
        for other in [Vector3::x(), Vector3::y(), Vector3::z(), wrench.yzx()] {
            assert!(ellipsoid.wrench(&other).dot(&sliding.twist) <= most * (1.0 + 1e-12));
        }
    });
}

fn points<T: Scalar>(count: usize) -> impl Strategy<Value = Vec<FootprintPoint<T>>> {
    let point = (-0.1..0.2_f64, -0.1..0.2_f64, 0.05..1.0_f64);
    prop::collection::vec(point, 3..count).prop_map(|points| {
        let point =
            |(x, y, weight)| FootprintPoint { place: [lit(x), lit(y)], weight: lit(weight) };
        points.into_iter().map(point).collect()
    })
}

/// The twist whose wrench is given comes back as one that has the same wrench. Few points: flat
/// parts are most of the surface, and a twist between them has many neighbours on them.
#[test]
fn the_twist_of_a_footprint_has_the_wrench_it_was_asked_for() {
    fn run<T: Scalar>(tolerance: f64) {
        let ratios = prop_oneof![Just([1.0, 1.0]), Just([1.0, 0.6])];
        check(300, (points::<T>(40), ratios, vector(0.01)), |(points, ratios, mut twist)| {
            twist.z *= 10.0;
            let twist = twist.map(lit::<T>);
            let footprint = Footprint::new(contact::<T>(ratios), points).unwrap();
            let wrench = footprint.stationary_wrench(&twist);
            let sliding = footprint.sliding_twist(&(wrench * lit::<T>(0.7)), lit(1e-3)).unwrap();
            assert!((to_f64(sliding.utilisation) - 0.7).abs() < tolerance, "{sliding:?}");
            let work = |of: &Vector3<T>| to_f64(wrench.dot(of));
            let back = footprint.stationary_wrench(&sliding.twist);
            assert!((work(&sliding.twist) * 0.7 - 1.0).abs() < tolerance);
            // Equal work, by maximum dissipation, is equal wrenches where the surface is curved.
            assert!((to_f64(back.dot(&sliding.twist)) * 0.7 - 1.0).abs() < tolerance);
        });
    }
    run::<f64>(1e-6);
    run::<f32>(5e-3);
}

/// One point carries up to nearly all of the load, and a wrench that it can hold turns the body
/// about it.
#[test]
fn a_heavy_point_is_turned_about() {
    let held = (0.0..0.9_f64, 0.0..std::f64::consts::TAU);
    check(300, (points::<f64>(40), 0..=6, held), |(mut points, heavy, (size, angle))| {
        points[0].weight *= 10f64.powi(heavy);
        let share = points[0].weight / points.iter().map(|point| point.weight).sum::<f64>();
        let [x, y] = points[0].place;
        let footprint = Footprint::new(contact([1.0, 1.0]), points).unwrap();
        let spin = footprint.stationary_wrench(&Vector3::new(y, -x, 1.0));
        // Of 5 N.
        let (f_x, f_y) = (5.0 * share * size * angle.cos(), 5.0 * share * size * angle.sin());
        let wrench = spin + Vector3::new(f_x, f_y, x * f_y - y * f_x);
        let sliding = footprint.sliding_twist(&wrench, 1e-3).unwrap();
        let (v_x, v_y, turning) = (sliding.twist.x, sliding.twist.y, sliding.twist.z);
        let slip = (v_x - turning * y).hypot(v_y + turning * x);
        assert!(slip < 1e-6 * turning && (sliding.utilisation - 1.0).abs() < 1e-6, "{sliding:?}");
    });
}

/// A flat part: three points, and a wrench that turns the body about one of them.
#[test]
fn a_wrench_on_a_flat_part_turns_the_body_about_a_point() {
    let points =
        [[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]].map(|place| FootprintPoint { place, weight: 1.0 });
    let footprint = Footprint::new(contact::<f64>([1.0, 1.0]), points).unwrap();
    // Of 5 N: the two others resist a spin by 5/3 N each, and the first carries half of its own.
    let spin = footprint.stationary_wrench(&Vector3::new(0.0, 0.0, 1.0));
    let held = spin + Vector3::new(0.5, -0.3, 0.0);
    let sliding = footprint.sliding_twist(&held, 1e-3).unwrap();
    assert!(sliding.twist.xy().norm() < 1e-7 * 0.1 * sliding.twist.z, "{sliding:?}");
    assert!((sliding.utilisation - 1.0).abs() < 1e-7 && (sliding.twist.z - 3.0).abs() < 1e-5);
    // A disc of many points: the closed form of pure sliding and of pure spin.
    let disc: Vec<_> = FootprintPoint::disc(0.03, DiscPressure::Uniform, 10).collect();
    let disc = Footprint::new(contact([1.0, 1.0]), disc).unwrap();
    let straight = disc.sliding_twist(&Vector3::new(3.0, 4.0, 0.0), 1e-3).unwrap();
    let want = Vector3::new(3.0, 4.0, 0.0) / 25.0;
    assert!((straight.twist - want).norm() < 1e-6 && (straight.utilisation - 1.0_f64).abs() < 1e-9);
}

#[test]
fn what_has_no_twist_is_refused_by_name() {
    let one = [FootprintPoint { place: [0.1, 0.2], weight: 1.0 }; 4];
    let name = |refused: LimitSurfaceError| match refused {
        LimitSurfaceError::Parameter(error) => error.name,
        other => panic!("{other}"),
    };
    let footprint = Footprint::new(contact::<f64>([1.0, 1.0]), one).unwrap();
    let wrench = Vector3::new(1.0, 0.0, 0.1);
    assert_eq!(name(footprint.sliding_twist(&wrench, 1e-3).unwrap_err()), "distance of the points");
    let mut two = one;
    two[0].place = [0.0, 0.0];
    let footprint = Footprint::new(contact::<f64>([1.0, 1.0]), two).unwrap();
    for bad in [Vector3::zeros(), Vector3::new(f64::NAN, 0.0, 0.0), Vector3::repeat(f64::INFINITY)]
    {
        assert_eq!(name(footprint.sliding_twist(&bad, 1e-3).unwrap_err()), "wrench");
        assert!(FrictionEllipsoid::isotropic(1.0, 1.0).unwrap().twist(&bad).is_err());
    }
    assert_eq!(name(footprint.sliding_twist(&wrench, 0.0).unwrap_err()), "speed");
    for bad in [Matrix3::zeros(), -Matrix3::identity(), Matrix3::repeat(f64::NAN)] {
        assert_eq!(FrictionEllipsoid::<f64>::new(bad).unwrap_err().name, "determinant");
    }
}

/// Sixty pushes with twists in all directions, over a length of 30 mm.
fn twists(noise: &mut impl FnMut() -> f64) -> Vec<Vector3<f64>> {
    (0..60).map(|_| 0.01 * Vector3::new(noise(), noise(), noise() / 0.03)).collect()
}

/// Noise of the wrenches: 2 % of 5 N, and of 5 N over 30 mm.
const NOISE: Vector3<f64> = Vector3::new(0.1, 0.1, 3e-3);

fn pushes(
    wrench: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    noise: &mut impl FnMut() -> f64,
) -> Vec<Push<f64>> {
    twists(noise)
        .into_iter()
        .map(|twist| {
            let scatter = Vector3::new(noise(), noise(), noise()).component_mul(&NOISE);
            Push { twist, wrench: wrench(&twist) + scatter }
        })
        .collect()
}

/// 200 planted ellipsoids: errors over their standard errors are Gaussian numbers. Six parameters
/// of 200 seeds within three standard errors 0.3 % of the time beyond.
#[test]
fn planted_ellipsoids_come_back_within_their_standard_errors() {
    let mut noise = bristle_charts::noise();
    for (family, count) in [
        (EllipsoidFamily::Isotropic, 2),
        (EllipsoidFamily::Ratios, 3),
        (EllipsoidFamily::Turned, 6),
    ] {
        let (mut beyond, mut squares, mut all) = (0, 0.0, 0);
        for _ in 0..200 {
            let mut about = |mean: f64| mean * (0.15 * noise()).exp();
            let [a, b, c] = [about(5.0), about(5.0), about(0.15)];
            let factor = match family {
                EllipsoidFamily::Isotropic => Matrix3::from_diagonal(&Vector3::new(a, a, c)),
                EllipsoidFamily::Ratios => Matrix3::from_diagonal(&Vector3::new(a, b, c)),
                _ => Matrix3::new(a, 0.0, 0.0, noise(), b, 0.0, 0.05 * noise(), 0.05 * noise(), c),
            };
            let real = FrictionEllipsoid::new(factor * factor.transpose()).unwrap();
            let measured = pushes(|twist| real.wrench(twist), &mut noise);
            let fit = FrictionEllipsoid::fit(&measured, family, &NOISE).unwrap();
            assert!((fit.scatter - 1.0).abs() < 0.25, "{}", fit.scatter);
            for (i, j) in [(0, 0), (1, 1), (2, 2), (1, 0), (2, 0), (2, 1)] {
                let (off, error) =
                    (fit.factor[(i, j)] - factor[(i, j)], fit.standard_errors[(i, j)]);
                if error > 0.0 {
                    beyond += usize::from((off / error).abs() > 3.0);
                    (squares, all) = (squares + (off / error).powi(2), all + 1);
                }
            }
        }
        let spread = (squares / f64::from(all)).sqrt();
        println!("{family:?}: {beyond} of {all} beyond three, spread {spread:.2}");
        assert!(all >= 200 * count && beyond * 100 <= all as usize, "{beyond} of {all}");
        assert!((spread - 1.0).abs() < 0.1, "{spread}");
    }
}

/// Of pushes without noise only roundings are left; the condition of the fit is some hundreds.
#[test]
fn exact_pushes_give_the_ellipsoid_in_either_precision() {
    fn check<T: Scalar>(tolerance: f64) {
        let mut noise = bristle_charts::noise();
        for family in [EllipsoidFamily::Isotropic, EllipsoidFamily::Ratios, EllipsoidFamily::Turned]
        {
            // In the later ones a step from the diagonal start makes the sum larger at first.
            for round in 0..30 {
                let spread = if round < 15 { 0.15 } else { 0.8 };
                let mut about = |mean: f64| mean * (spread * noise()).exp();
                let [a, b, c] = [about(5.0), about(5.0), about(0.15)];
                let factor = match family {
                    EllipsoidFamily::Isotropic => Matrix3::new(a, 0., 0., 0., a, 0., 0., 0., c),
                    EllipsoidFamily::Ratios => Matrix3::new(a, 0., 0., 0., b, 0., 0., 0., c),
                    _ => {
                        let [turn, shift] = [noise(), noise()].map(|it| it * spread / 0.15);
                        Matrix3::new(a, 0., 0., turn, b, 0., 0.05 * shift, 0.02, c)
                    }
                };
                let factor = factor.map(lit::<T>);
                let real = FrictionEllipsoid::new(factor * factor.transpose()).unwrap();
                let exact: Vec<_> = twists(&mut noise)
                    .iter()
                    .map(|twist| twist.map(lit::<T>))
                    .map(|twist| Push { twist, wrench: real.wrench(&twist) })
                    .collect();
                let fit = FrictionEllipsoid::fit(&exact, family, &NOISE.map(lit)).unwrap();
                let off = (fit.factor - factor).component_div(&factor.map(|x| x.abs() + lit(0.1)));
                assert!(to_f64(off.amax()) < tolerance, "{family:?}: {off}");
            }
        }
    }
    check::<f64>(1e-11);
    check::<f32>(1e-3);
}

/// A quarter of a turn between the directions, an eighth where a spin comes to as much.
#[test]
fn an_angle_of_twists_weighs_spins_by_the_length() {
    let spin = Vector3::z() / 0.03;
    for (twist, other) in [(Vector3::x(), Vector3::y()), (Vector3::y(), Vector3::x())] {
        let push = Push { twist, wrench: Vector3::zeros() };
        for (predicted, wanted) in
            [(other, FRAC_PI_2), (spin, FRAC_PI_2), (twist + spin, FRAC_PI_4)]
        {
            let angle = push.angle(&predicted, 0.03);
            assert!((angle - wanted).abs() < 4.0 * f64::EPSILON, "{angle} {wanted}");
        }
    }
}

#[test]
fn pushes_that_leave_a_parameter_open_are_refused() {
    let real = FrictionEllipsoid::isotropic(5.0, 0.03).unwrap();
    // All but one twist: the three numbers of one wrench, with noise.
    let (one, mut noise) = (Vector3::new(0.01, 0.003, 0.2), bristle_charts::noise());
    let flat: Vec<_> = pushes(|twist| real.wrench(&(one + twist * 1e-9)), &mut noise)
        .into_iter()
        .map(|push| Push { twist: one + push.twist * 1e-9, ..push })
        .collect();
    let fit = |pushes: &[Push<f64>], family| FrictionEllipsoid::fit(pushes, family, &NOISE);
    let undetermined = LimitSurfaceError::Undetermined(6);
    assert_eq!(fit(&flat, EllipsoidFamily::Turned).unwrap_err(), undetermined);
    assert!(matches!(fit(&[], EllipsoidFamily::Isotropic), Err(LimitSurfaceError::Parameter(_))));
    let mut bad = pushes(|twist| real.wrench(twist), &mut bristle_charts::noise());
    bad[3].wrench.x = f64::NAN;
    let refused = fit(&bad, EllipsoidFamily::Ratios).unwrap_err().to_string();
    assert!(refused.starts_with("wrench[3]"), "{refused}");
    assert!(Support::fit(&[], &bad[..3], &NOISE, 1.0).is_err());
}

/// Five feet of nine that could be there, and their 5 N: 60 pushes, noise 2 %.
#[test]
fn a_planted_support_comes_back() {
    let (mut noise, mut worst) = (bristle_charts::noise(), [0.0_f64; 2]);
    let grid: Vec<_> = FootprintPoint::rectangle([0.09, 0.09], [3, 3]).collect();
    for _ in 0..20 {
        let mut real = grid.clone();
        for (i, point) in real.iter_mut().enumerate() {
            point.weight = if i % 2 == 0 { (0.3 * noise()).exp() } else { 0.0 };
        }
        let sum: f64 = real.iter().map(|point| point.weight).sum();
        let support = Footprint::new(contact::<f64>([1.0, 1.0]), real.clone()).unwrap();
        let measured = pushes(|twist| support.stationary_wrench(twist), &mut noise);
        let found = Support::fit(&grid, &measured, &NOISE, 1e-3).unwrap();
        worst[0] = worst[0].max((found.friction - 5.0).abs());
        for (found, real) in found.points.iter().zip(&real) {
            worst[1] = worst[1].max((found.weight - real.weight / sum).abs());
        }
        assert!(found.points.iter().all(|point| point.weight >= 0.0));
        // The stronger the regulariser, the closer to equal weights.
        let drawn = Support::fit(&grid, &measured, &NOISE, 1e6).unwrap();
        assert!(drawn.points.iter().all(|point| (point.weight - 1.0 / 9.0).abs() < 1e-4));
    }
    println!("{worst:?}");
    // 0.1 N over the root of some 60 pushes for the sum; a point is told from its neighbours, half
    // the side away, by a tenth of that information.
    assert!(worst[0] < 0.05 && worst[1] < 0.05, "{worst:?}");
}

/// Points that count how often they are gone through.
struct Sums<'a>(&'a [FootprintPoint<f64>], &'a Cell<u32>);

impl AsRef<[FootprintPoint<f64>]> for Sums<'_> {
    fn as_ref(&self) -> &[FootprintPoint<f64>] {
        self.1.set(self.1.get() + 1);
        self.0
    }
}

/// As docs/plane.md says: so many sums over the points for a twist.
#[test]
fn a_twist_takes_a_few_dozen_sums_over_the_points() {
    let plate: Vec<_> = FootprintPoint::rectangle([0.1, 0.05], [12, 6]).collect();
    let few: Vec<_> = plate.iter().copied().step_by(29).collect();
    for points in [plate, few] {
        let (mut all, mut most, mut noise) = (0, 0, bristle_charts::noise());
        for _ in 0..150 {
            let sums = Cell::new(0);
            let footprint = Footprint::new(contact([1.0, 1.0]), Sums(&points, &sums)).unwrap();
            let wrench = Vector3::new(noise(), noise(), 0.03 * noise());
            let _ = footprint.sliding_twist(&wrench, 1e-3).unwrap();
            // The first is that of the constructor.
            (all, most) = (all + sums.get() - 1, most.max(sums.get() - 1));
        }
        println!("{} points: {} sums on average, {most} at most", points.len(), all / 150);
        assert!(all / 150 <= 50 && most <= 200, "{all} {most}");
    }
}
