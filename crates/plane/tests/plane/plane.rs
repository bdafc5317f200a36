//! Bristles of several axes: their theorems, their limits, and the scalar model as a special case.

use bristle::curve::{Coulomb, CoulombParameters, FrictionCurve, Stribeck, StribeckParameters};
use bristle::regularisation::{Regularisation, SquareRoot, Unregularised};
use bristle::rheology::KelvinVoigt;
use bristle::{Bristle, FrBd, Law, LuGre, Scalar, paper};
use bristle_analysis::ledger::{EnergyBalance, EnergyLedger};
use bristle_plane::{Axis, DiscPressure, PlaneBristle, PlaneContact, PlaneFrBd, PlaneLuGre};
use nalgebra::{SVector, Vector1, Vector2, Vector3, convert};
use num_dual::Dual64;
use proptest::prelude::*;

use bristle_specimens::recipe::{decades, velocity};
use bristle_specimens::specimens::{kelvin_voigt, table_2_curve};
use bristle_specimens::{assert_within, check, integral, lit};

type Model<T, const N: usize, E = Unregularised> = PlaneFrBd<Stribeck<T>, T, N, E>;

/// Curve and axes over many decades, a velocity, and a deflection as a share of its box.
#[derive(Debug, Clone, Copy)]
struct Draw<const N: usize> {
    /// μ_d, μ_s, v_S, δ, σ2
    curve: [f64; 5],
    /// a, σ0, σ1
    axes: [[f64; 3]; N],
    velocity: SVector<f64, N>,
    share: SVector<f64, N>,
    load: f64,
    epsilon: f64,
}

fn draw<const N: usize>() -> impl Strategy<Value = Draw<N>> {
    let axis = (
        decades(0.1, 10.0),
        decades(1e2, 1e5),
        prop_oneof![1 => Just(0.0), 4 => decades(0.1, 1e3)],
    );
    (
        (
            decades(0.1, 2.0),
            1.0..2.0,
            decades(1e-3, 1.0),
            prop_oneof![Just(1.0), Just(2.0), 0.5..3.0],
            prop_oneof![Just(0.0), decades(1e-2, 1.0)],
        ),
        prop::collection::vec(axis, N),
        prop::collection::vec(velocity(), N),
        prop::collection::vec(-1.0..1.0, N),
        decades(0.1, 1e3),
        decades(1e-12, 1e-2),
    )
        .prop_map(|(curve, axes, velocity, share, load, epsilon)| {
            let (dynamic, rise, stribeck, exponent, viscous) = curve;
            Draw {
                curve: [dynamic, dynamic * rise, stribeck, exponent, viscous],
                axes: std::array::from_fn(|i| [axes[i].0, axes[i].1, axes[i].2]),
                velocity: SVector::from_vec(velocity),
                share: SVector::from_vec(share),
                load,
                epsilon,
            }
        })
}

fn bristle<T: Scalar>(micro_stiffness: f64, micro_damping: f64) -> KelvinVoigt<T> {
    kelvin_voigt(lit(micro_stiffness), lit(micro_damping))
}

/// Friction that does not depend on the speed.
fn coulomb<T: Scalar>(mu: f64) -> Coulomb<T> {
    let (dynamic_coefficient, viscous_friction) = (lit(mu), T::zero());
    Coulomb::new(CoulombParameters { dynamic_coefficient, viscous_friction }).unwrap()
}

fn axis<T: Scalar>([ratio, stiffness, damping]: [f64; 3]) -> Axis<T> {
    Axis { friction_ratio: lit(ratio), bristle: bristle(stiffness, damping) }
}

impl<const N: usize> Draw<N> {
    fn curve<T: Scalar>(&self) -> Stribeck<T> {
        let [dynamic, static_, stribeck, exponent, viscous] = self.curve.map(convert);
        Stribeck::new(StribeckParameters {
            dynamic_coefficient: dynamic,
            static_coefficient: static_,
            stribeck_velocity: stribeck,
            stribeck_exponent: exponent,
            viscous_friction: viscous,
        })
        .unwrap()
    }

    fn axes<T: Scalar>(&self) -> [Axis<T>; N] {
        self.axes.map(axis)
    }

    fn model<T: Scalar>(&self) -> Model<T, N> {
        PlaneFrBd::new(self.curve(), self.axes()).unwrap()
    }

    fn regularised<T: Scalar>(&self) -> Model<T, N, SquareRoot<T>> {
        self.model().regularised(SquareRoot::new(lit(self.epsilon)).unwrap())
    }

    fn contact(&self) -> PlaneContact<f64, Model<f64, N>, N> {
        self.model::<f64>().under_load(self.load).unwrap()
    }

    /// The deflection inside the box for the speeds met.
    fn deflection(&self) -> SVector<f64, N> {
        let limit = self.model::<f64>().limits(self.velocity.norm()).deflection.unwrap();
        limit.component_mul(&self.share)
    }
}

/// F·v − Ẇ = p(‖M(v − ż)‖²/N + Σ σ1ᵢ żᵢ²), from the rates and forces of the model.
fn dissipates<const N: usize, E: Regularisation<f64>>(
    model: impl Fn(&Draw<N>) -> Model<f64, N, E>,
) {
    check(300, draw::<N>(), |draw| {
        let model = model(&draw);
        assert!(model.obeys(Law::Passivity));
        let weighted = SVector::<f64, N>::from_fn(|i, _| draw.axes[i][0] * draw.velocity[i]).norm();
        let n = model.regularisation().speed(weighted.into());
        let contact = model.under_load(draw.load).unwrap();
        let (v, z) = (draw.velocity, draw.deflection());
        let (rate, force) = (contact.rate(&v, &z), contact.force(&v, &z));
        let mu = draw.curve::<f64>().at(v.norm());
        let (mut want, mut scale) = (0.0, force.abs().dot(&v.abs()));
        for i in 0..N {
            let [ratio, stiffness, damping] = draw.axes[i];
            let slip = ratio * (v[i] - rate[i]);
            want += draw.load * damping * rate[i] * rate[i];
            if n > 0.0 {
                want += draw.load * mu * slip * slip / n;
            }
            scale += draw.load * (stiffness * z[i] * rate[i]).abs();
        }
        // Slip is the difference v − ż, with roundings of v, and their squares count.
        let got = contact.dissipated_power(&v, &z);
        assert_within(1e-12, scale.max(want), got, want, || format!("{draw:?}"));
        // Of the definition F·v − Ẇ, too.
        let stored = |i: usize| draw.load * draw.axes[i][1] * z[i] * rate[i];
        let defined = force.dot(&v) - (0..N).map(stored).sum::<f64>();
        assert_within(1e-12, scale.max(want), defined, want, || format!("{draw:?}"));
        assert!(got >= -1e-12 * scale, "{got} of {scale}: {draw:?}");
    });
}

#[test]
fn every_anisotropy_dissipates() {
    dissipates::<1, _>(Draw::model);
    dissipates::<2, _>(Draw::model);
    dissipates::<3, _>(Draw::model);
    dissipates::<2, _>(Draw::regularised);
    dissipates::<3, _>(Draw::regularised);
}

#[test]
fn the_box_is_never_left_and_forces_keep_to_theirs() {
    let turns = prop::collection::vec((velocity(), velocity(), decades(1e-6, 10.0)), 6);
    check(300, (draw::<2>(), turns), |(draw, turns)| {
        let contact = draw.contact();
        let fastest = turns.iter().fold(0.0_f64, |most, (x, y, _)| most.max(x.hypot(*y)));
        let limits = contact.model().limits(fastest);
        let (deflection, coefficient) = (limits.deflection.unwrap(), limits.coefficient.unwrap());
        let companion = contact.companion(fastest).unwrap();
        let mut z = deflection.component_mul(&draw.share);
        for (x, y, h) in turns {
            let v = Vector2::new(x, y);
            let held = contact.hold(&v, &z, h);
            // A step that meets its prediction is the held one.
            let passive = companion.step(&v, &z, h).commit(&v);
            for i in 0..2 {
                assert!(held.deflection[i].abs() <= deflection[i] * (1.0 + 1e-12), "{draw:?}");
                let force = held.end_force[i].abs().max(held.mean_force[i].abs());
                let bound = draw.load * coefficient[i];
                assert!(force <= bound * (1.0 + 1e-12), "{force} of {bound}: {draw:?}");
                let mean = held.mean_force[i];
                assert_within(1e-11, bound, passive.force[i], mean, || format!("{draw:?}"));
            }
            z = held.deflection;
        }
    });
}

#[test]
fn no_velocity_relaxes_faster_than_the_limit() {
    check(300, draw::<3>(), |draw| {
        let fastest = draw.velocity.norm();
        fn within<M: PlaneBristle<f64, 3>>(model: M, draw: &Draw<3>, fastest: f64) {
            let Some(limit) = model.limits(fastest).relaxation_rate else { return };
            for (axis, v) in model.axes(&draw.velocity).iter().zip(&draw.velocity) {
                let rate = axis.affine((*v).into(), 0.0).relaxation;
                assert!(rate <= limit * (1.0 + 1e-12), "{draw:?}");
            }
        }
        within(draw.model(), &draw, fastest);
        within(draw.model(), &draw, f64::INFINITY);
        within(draw.regularised(), &draw, fastest);
        within(PlaneLuGre::classical(draw.curve(), draw.axes()).unwrap(), &draw, fastest);
    });
}

#[test]
fn the_ellipsoid_is_never_left_with_equal_relaxation_rates_and_is_with_unequal_ones() {
    // σ0 and σ1 in proportion to a²: equal rates.
    check(200, (draw::<2>(), decades(1e-5, 1.0)), |(draw, h)| {
        let [first, second] = draw.axes;
        let square = (second[0] / first[0]).powi(2);
        let alike = [second[0], first[1] * square, first[2] * square];
        let model = PlaneFrBd::new(draw.curve::<f64>(), [axis(first), axis(alike)]).unwrap();
        let limits = model.limits(draw.velocity.norm());
        assert!(limits.ellipsoid);
        let (semi, coefficient) = (limits.deflection.unwrap(), limits.coefficient.unwrap());
        let inside = draw.share / draw.share.norm().max(1.0);
        let contact = model.under_load(1.0).unwrap();
        let held = contact.hold(&draw.velocity, &semi.component_mul(&inside), h);
        let after = held.deflection.component_div(&semi);
        assert!(after.norm() <= 1.0 + 1e-12, "{after}: {draw:?}");
        let force = held.end_force.component_div(&coefficient);
        assert!(force.norm() <= 1.0 + 1e-12, "{force}: {draw:?}");
    });
    // Ratio 10: a turning velocity drives u out of the ball, to 1.22 at the most.
    let axes = [axis([1.0, 1e3, 0.0]), axis([1.0, 1e4, 0.0])];
    let model = PlaneFrBd::new(coulomb(1.0), axes).unwrap();
    assert!(!model.limits(1.0).ellipsoid);
    let contact = model.under_load(1.0).unwrap();
    // Along x until u = (1, 0), then along y: u_y rises faster than u_x falls.
    let z = contact.stationary(&Vector2::new(1.0, 0.0));
    let largest = (1..200)
        .map(|k| contact.hold(&Vector2::new(0.0, 1.0), &z, 1e-5 * f64::from(k)).end_force.norm());
    let largest = largest.fold(0.0, f64::max);
    assert!(largest > 1.15 && largest < 1.225, "{largest}");
}

/// Everything that one axis answers is what the scalar model answers, bit for bit.
fn compare_bits<T: Scalar, M: Bristle<T, Deflection = T>, P: PlaneBristle<T, 1>>(
    (scalar, plane): (M, P),
    (v, next, z, h): (T, T, T, T),
    what: &str,
) {
    let contact = scalar.under_load(lit(3.0)).unwrap();
    let one = plane.under_load(lit(3.0)).unwrap();
    let (vector, deflection) = (Vector1::new(v), Vector1::new(z));
    let (got, want) = (one.linearised(&vector, &deflection), contact.linearised(v, z));
    let (held, scalar_held) = (one.hold(&vector, &deflection, h), contact.hold(v, z, h));
    let step = one.clone().companion(lit(0.1)).unwrap().step(&vector, &deflection, h);
    let scalar_step = contact.clone().companion(lit(0.1)).unwrap().step(v, z, h);
    let (done, scalar_done) = (step.commit(&Vector1::new(next)), scalar_step.commit(next));
    let pairs = [
        (got.rate[0], want.rate),
        (got.force[0], want.force),
        (got.rate_by_deflection[0], want.rate_by_deflection),
        (got.rate_by_velocity[0], want.rate_by_velocity),
        (got.force_by_deflection[0], want.force_by_deflection),
        (got.force_by_velocity[0], want.force_by_velocity),
        (held.deflection[0], scalar_held.deflection),
        (held.end_force[0], scalar_held.end_force),
        (held.mean_force[0], scalar_held.mean_force),
        (step.bias()[0], scalar_step.bias()),
        (step.damping()[0], scalar_step.damping()),
        (done.deflection[0], scalar_done.deflection),
        (done.force[0], scalar_done.force),
        (done.work, scalar_done.work),
        (done.stored, scalar_done.stored),
        (done.dissipated, scalar_done.dissipated),
        (one.dissipated_power(&vector, &deflection), contact.dissipated_power(v, z)),
        (one.stationary_force(&vector)[0], contact.stationary_force(v)),
    ];
    for (number, (got, want)) in pairs.into_iter().enumerate() {
        assert!(got == want, "{what}, {number}: {got} is not {want}");
    }
    let (limits, scalar_limits) = (one.model().limits(h), contact.model().limits(h));
    assert_eq!(limits.deflection.map(|limit| limit[0]), scalar_limits.deflection, "{what}");
    assert_eq!(limits.coefficient.map(|limit| limit[0]), scalar_limits.coefficient, "{what}");
    assert_eq!(limits.relaxation_rate, scalar_limits.relaxation_rate, "{what}");
    assert!(limits.ellipsoid, "one axis is alike");
}

fn one_axis<T: Scalar>(draw: &Draw<1>, next: f64, h: f64) {
    let [_, stiffness, damping] = draw.axes[0];
    let axes = [axis([1.0, stiffness, damping])];
    let bristle = bristle::<T>(stiffness, damping);
    let curve = draw.curve::<T>();
    let state = (draw.velocity[0], next, 1e-4 * draw.share[0], h);
    let state = (lit(state.0), lit(state.1), lit(state.2), lit(state.3));
    let root = SquareRoot::new(lit::<T>(draw.epsilon)).unwrap();
    let what = format!("{draw:?}");

    let (scalar, plane) = (FrBd::new(curve, bristle), PlaneFrBd::new(curve, axes).unwrap());
    compare_bits((scalar, plane), state, &what);
    compare_bits((scalar.regularised(root), plane.regularised(root)), state, &what);
    let scalar = LuGre::classical(curve, bristle);
    let plane = PlaneLuGre::classical(curve, axes).unwrap();
    compare_bits((scalar, plane), state, &what);
    compare_bits((scalar.regularised(root), plane.regularised(root)), state, &what);
    let scalar = LuGre::with_viscous_friction(curve, bristle, T::zero()).unwrap();
    let plane = PlaneLuGre::with_viscous_friction(curve, axes, T::zero()).unwrap();
    compare_bits((scalar, plane), state, &what);
}

#[test]
fn one_axis_is_the_scalar_model_to_the_last_bit() {
    check(300, (draw::<1>(), velocity(), decades(1e-6, 10.0)), |(draw, next, h)| {
        one_axis::<f64>(&draw, next, h);
        one_axis::<f32>(&draw, next, h);
    });
}

/// Compares all derivatives of a contact with those of its dual numbers, relative to the sum of the
/// absolute values of the terms.
fn compare_derivatives<const N: usize, M: PlaneBristle<f64, N>, D: PlaneBristle<Dual64, N>>(
    draw: &Draw<N>,
    (model, dual): (M, D),
) {
    let (v, z) = (draw.velocity, draw.deflection());
    let axes = model.axes(&v);
    let (with_slopes, gradient) = model.axes_and_slopes(&v);
    // Under 0.6 of the load at which its stiffness was measured.
    let contact = model.under_load(0.6).unwrap().measured_at(1.0).unwrap();
    let dual = dual.under_load(Dual64::from(0.6)).unwrap();
    let dual = dual.measured_at(Dual64::from(1.0)).unwrap();
    let linearised = contact.linearised(&v, &z);
    assert_eq!(linearised.rate, contact.rate(&v, &z));
    assert_eq!(linearised.force, contact.force(&v, &z));
    for j in 0..N {
        let seed = |x: SVector<f64, N>, along: f64| {
            SVector::<Dual64, N>::from_fn(|i, _| {
                Dual64::new(x[i], if i == j { along } else { 0.0 })
            })
        };
        let by_velocity = dual.response(&seed(v, 1.0), &seed(z, 0.0));
        let by_deflection = dual.response(&seed(v, 0.0), &seed(z, 1.0));
        for i in 0..N {
            let affine = axes[i].affine(v[i].into(), z[i]);
            let (_, slope) = with_slopes[i].affine_and_slopes(v[i].into(), z[i]);
            let [_, stiffness, damping] = draw.axes[i];
            let terms = |slope: f64, other: f64, own: f64| {
                ((slope * z[i]).abs() + (other * v[i]).abs()) * gradient[j].abs() + own.abs()
            };
            // μ', n' and ‖v‖' are at most a few of their quantities over ‖v‖, and may cancel.
            let (steep, stiff) = (z[i].abs() / v.norm(), stiffness + affine.stiffness.abs());
            let rate = terms(slope.relaxation, slope.drive, affine.drive);
            let rate = rate + affine.relaxation * steep + 1.0;
            let force = terms(slope.stiffness, slope.damping, affine.damping);
            let force = force + stiff * steep + damping;
            let diagonal = |value: f64| if i == j { value } else { 0.0 };
            let relaxes = diagonal(linearised.rate_by_deflection[i]);
            let springs = diagonal(linearised.force_by_deflection[i]);
            let rows = [
                (rate, linearised.rate_by_velocity[(i, j)], by_velocity.rate[i]),
                (force, linearised.force_by_velocity[(i, j)], by_velocity.force[i]),
                (affine.relaxation, relaxes, by_deflection.rate[i]),
                (stiff, springs, by_deflection.force[i]),
            ];
            for (row, (scale, got, want)) in rows.into_iter().enumerate() {
                assert_within(1e-12, scale, got, want.eps, || format!("{row}: {i}, {j}, {draw:?}"));
            }
        }
    }
}

fn derivatives<const N: usize>() {
    // At v = 0 the derivatives depend on the direction.
    let moving = draw::<N>().prop_filter("it moves", |draw| draw.velocity.norm() > 0.0);
    check(200, moving, |draw| {
        compare_derivatives(&draw, (draw.model::<f64>(), draw.model::<Dual64>()));
        compare_derivatives(&draw, (draw.regularised::<f64>(), draw.regularised::<Dual64>()));
        let lugre = PlaneLuGre::classical(draw.curve::<f64>(), draw.axes()).unwrap();
        let dual = PlaneLuGre::classical(draw.curve::<Dual64>(), draw.axes()).unwrap();
        compare_derivatives(&draw, (lugre, dual));
    });
}

#[test]
fn derivatives_agree_with_dual_numbers() {
    derivatives::<1>();
    derivatives::<2>();
    derivatives::<3>();
}

#[test]
fn steady_friction_is_the_ellipsoids_and_that_of_a_sphere_opposes_the_velocity() {
    check(200, draw::<3>(), |draw| {
        let mu = draw.curve::<f64>().at(draw.velocity.norm());
        // F = p M² v/N and F·v = p N with N = μ n.
        let force = draw.contact().stationary_force(&draw.velocity);
        let ratios = Vector3::from_fn(|i, _| draw.axes[i][0]);
        let n = ratios.component_mul(&draw.velocity).norm();
        let square = ratios.component_mul(&ratios).component_mul(&draw.velocity);
        let want = square * (draw.load * mu / n.max(f64::MIN_POSITIVE));
        assert_within(1e-13, want.norm(), (force - want).norm(), 0.0, || format!("{draw:?}"));
        let power = draw.load * mu * n;
        assert_within(1e-13, power, force.dot(&draw.velocity), power, || format!("{draw:?}"));

        let sphere = PlaneFrBd::<_, f64, 3>::isotropic(draw.curve::<f64>(), bristle(1e4, 10.0));
        let force = sphere.under_load(draw.load).unwrap().stationary_force(&draw.velocity);
        let speed = draw.velocity.norm().max(f64::MIN_POSITIVE);
        let want = draw.velocity * (draw.load * mu / speed);
        assert_within(1e-13, want.norm(), (force - want).norm(), 0.0, || format!("{draw:?}"));
    });
}

#[test]
fn an_isotropic_contact_does_not_know_its_axes() {
    check(200, (draw::<2>(), -4.0..4.0, decades(1e-5, 1.0)), |(draw, angle, h)| {
        let model = PlaneFrBd::<_, f64, 2>::isotropic(draw.curve::<f64>(), bristle(1e4, 10.0));
        let contact = model.under_load(draw.load).unwrap();
        let turn = |x: &Vector2<f64>| contact.turn(x, angle).deflection;
        let z = draw.share * 1e-5;
        assert_eq!(contact.turn(&z, angle).supplied, 0.0);
        let v = draw.velocity;
        let (straight, turned) = (contact.hold(&v, &z, h), contact.hold(&turn(&v), &turn(&z), h));
        let what = || format!("{draw:?}");
        let scale = z.norm() + straight.deflection.norm();
        let off = turn(&straight.deflection) - turned.deflection;
        assert_within(1e-12, scale, off.norm(), 0.0, what);
        let off = turn(&straight.mean_force) - turned.mean_force;
        assert_within(1e-12, 2.0 * draw.load, off.norm(), 0.0, what);
        let companion = contact.companion(1.0).unwrap();
        let half = 0.5 * v;
        let done = companion.step(&half, &z, h).commit(&v);
        let done_turned = companion.step(&turn(&half), &turn(&z), h).commit(&turn(&v));
        let off = turn(&done.force) - done_turned.force;
        assert_within(1e-11, done.force.norm() + draw.load, off.norm(), 0.0, what);
        // One direction is the scalar model along it.
        let scalar = FrBd::new(draw.curve::<f64>(), bristle(1e4, 10.0));
        let scalar = scalar.under_load(draw.load).unwrap().hold(v.norm(), 0.0, h);
        let along = contact.hold(&v, &Vector2::zeros(), h).mean_force;
        assert_within(1e-12, 2.0 * draw.load, along.norm(), scalar.mean_force, what);
    });
}

#[test]
fn a_turn_keeps_the_length_and_tells_what_unequal_springs_take() {
    let curve = table_2_curve();
    let axes = [axis([1.0, 1e4, 1.0]), axis([1.0, 4e4, 1.0]), axis([1.0, 2e4, 1.0])];
    let contact = PlaneFrBd::new(curve, axes).unwrap().under_load(2.0).unwrap();
    let z = Vector3::new(1e-5, 0.0, 3e-5);
    let turned = contact.turn(&z, std::f64::consts::FRAC_PI_2);
    // From the first axis towards the second; the third stays.
    assert!((turned.deflection - Vector3::new(0.0, 1e-5, 3e-5)).norm() < 1e-20);
    // ½ p (σ0y − σ0x) z² = ½·2·3e4·1e-10.
    assert_within(1e-14, 3e-6, turned.supplied, 3e-6, || "supplied".into());
    let back = contact.turn(&turned.deflection, -std::f64::consts::FRAC_PI_2);
    assert_within(1e-14, 3e-6, back.supplied, -3e-6, || "given back".into());
    let line = PlaneFrBd::<_, f64, 1>::isotropic(curve, bristle(1e4, 1.0)).under_load(1.0).unwrap();
    assert_eq!(line.turn(&Vector1::new(1e-5), 1.0).deflection, Vector1::new(1e-5));
    // Equal springs take nothing, and nobody knows what becomes of no number.
    let equal = PlaneFrBd::isotropic(curve, bristle(1e4, 1.0)).under_load(2.0).unwrap();
    assert_eq!(equal.turn(&z, 0.3).supplied, 0.0);
    for angle in [f64::NAN, f64::INFINITY] {
        assert!(equal.turn(&z, angle).supplied.is_nan(), "angle {angle}");
    }
    for odd in [f64::NAN, f64::INFINITY] {
        assert!(equal.turn(&Vector3::new(1e-5, odd, 0.0), 0.3).supplied.is_nan(), "z = {odd}");
    }
}

fn no_engine<const N: usize>() {
    let motion = || prop::collection::vec(velocity(), N);
    let move_ = (motion(), motion(), any::<bool>(), decades(1e-9, 1e3), -4.0..4.0, 0..4);
    check(200, (draw::<N>(), prop::collection::vec(move_, 12)), |(draw, moves)| {
        let mut companion = draw.contact().companion(1.0).unwrap();
        let mut z = draw.deflection();
        let begin = companion.contact().stored_energy(&z);
        let (mut ledger, mut scale) = (EnergyLedger::new(), begin);
        for (v, other, near, h, angle, lift) in moves {
            let load = if lift == 0 { 0.0 } else { draw.load * f64::from(lift) };
            let v = SVector::<f64, N>::from_vec(v);
            let predicted = if near { 1.5 * v } else { SVector::from_vec(other) };
            let reloaded = companion.reload(load, &predicted, &z).unwrap();
            assert!(reloaded.dissipated >= 0.0, "{draw:?}");
            ledger.enter(reloaded);
            let turned = companion.contact().turn(&reloaded.deflection, angle);
            let supplied = turned.supplied; // all of it stored
            ledger.enter(EnergyBalance { supplied, stored: supplied, dissipated: 0.0 });
            let before = companion.contact().stored_energy(&turned.deflection);
            let step = companion.step(&predicted, &turned.deflection, h);
            assert!(step.is_passive() && step.damping().iter().all(|&damping| damping >= 0.0));
            // The three energies of a step from their definitions.
            let force = step.bias() + step.damping().component_mul(&v);
            let done = step.commit(&v);
            assert!(done.dissipated >= 0.0, "{draw:?}");
            let size = h * force.abs().dot(&v.abs()) + before;
            let gained = companion.contact().stored_energy(&done.deflection) - before;
            let what = || format!("{draw:?}");
            assert_within(1e-10, size, done.stored, gained, what);
            assert_within(1e-10, size, done.work, h * force.dot(&v), what);
            assert_within(1e-10, size, done.work, done.stored + done.dissipated, what);
            scale += turned.supplied.abs() + done.work.abs() + done.dissipated + done.stored.abs();
            ledger.enter(done);
            z = done.deflection;
        }
        // Stored at the end, by its definition; all that was supplied is stored or dissipated.
        let stored = companion.contact().stored_energy(&z) - begin;
        let balance = ledger.total();
        assert_within(1e-9, scale, balance.stored, stored, || format!("{draw:?}"));
        assert_within(1e-9, scale, balance.residual(), 0.0, || format!("{draw:?}"));
        assert!(balance.dissipated >= 0.0);
    });
}

#[test]
fn no_sequence_of_loads_turns_and_steps_makes_an_engine() {
    no_engine::<1>();
    no_engine::<2>();
    no_engine::<3>();
}

#[test]
fn a_renewed_load_changes_every_axis_as_it_does_one() {
    check(100, (draw::<2>(), decades(1e-2, 1e2)), |(draw, factor)| {
        let (v, z) = (draw.velocity, draw.deflection());
        let mut contact = draw.contact();
        let renewed = contact.renew(draw.load * factor, &z).unwrap();
        assert_eq!(contact.normal_force(), draw.load * factor);
        let mut lost = 0.0;
        for (i, axis) in draw.contact().axes(&v).iter().enumerate() {
            let want = { *axis }.renew(draw.load * factor, z[i]).unwrap();
            assert_eq!(renewed.deflection[i], want.deflection);
            lost += want.dissipated;
        }
        assert_within(1e-13, lost, renewed.dissipated, lost, || format!("{draw:?}"));
        assert_eq!(contact.renew(-1.0, &z).unwrap_err().name, "normal_force");
        assert_eq!(contact.reload(-1.0, &v, &z).unwrap_err().name, "normal_force");
    });
}

#[test]
fn a_load_that_falls_lets_the_bristles_slip_back_along_their_deflection() {
    check(200, (draw::<2>(), decades(1e-2, 1e2)), |(draw, factor)| {
        let (v, z) = (draw.velocity, draw.deflection());
        let (before, mut contact) = (draw.contact(), draw.contact());
        let reloaded = contact.reload(draw.load * factor, &v, &z).unwrap();
        let left = reloaded.deflection;
        let name = || format!("{factor} {draw:?}");
        // What slips is dissipated.
        let (stored, held) = (before.stored_energy(&z), contact.stored_energy(&left));
        assert_within(1e-13, stored, reloaded.dissipated, stored - held, name);
        // What the surface holds under the new load, of which the bristles carry a part.
        let limits = contact.model().limits(v.norm());
        let shares = |z: Vector2<f64>| {
            let shares = z.component_div(&(limits.deflection.unwrap() * factor)).abs();
            if limits.ellipsoid { shares.norm() } else { shares.max() }
        };
        let kept = left.norm() / z.norm();
        if factor >= 1.0 || shares(z) <= 1.0 {
            assert_eq!(left, z, "{}", name());
        } else {
            assert_within(1e-13, z.norm(), left.perp(&z), 0.0, name);
            // All that it holds, unless the share of the load is more.
            assert_within(1e-12, 1.0, kept, (1.0 / shares(z)).max(factor), name);
        }
        // At one instant: the force that is held, at the rate of the new load.
        let at_once = before.response_under(draw.load * factor, &v, &z);
        assert_eq!(at_once.rate, contact.rate(&v, &z));
        let held = if shares(z) > 1.0 { z / shares(z) } else { z };
        let want = contact.force(&v, &held);
        assert_within(1e-12, want.norm(), (at_once.force - want).norm(), 0.0, name);
        assert!(before.response_under(-1.0, &v, &z).force.iter().all(|force| force.is_nan()));
    });
}

#[test]
fn a_load_that_varies_is_that_of_the_scalar_contact_along_one_axis() {
    check(200, (draw::<1>(), decades(1e-2, 1e2)), |(mut draw, factor)| {
        // Of a viscous part the plane takes an upper bound, the line its value.
        draw.curve[4] = 0.0;
        let bristle = draw.axes::<f64>()[0].bristle;
        let plane = PlaneFrBd::<_, _, 1>::isotropic(draw.curve::<f64>(), bristle);
        let (v, load) = (draw.velocity, draw.load * factor);
        let z = plane.limits(v.norm()).deflection.unwrap().component_mul(&draw.share);
        let mut plane = plane.under_load(draw.load).unwrap();
        let mut line = FrBd::new(draw.curve::<f64>(), bristle).under_load(draw.load).unwrap();
        let at_once = (plane.response_under(load, &v, &z), line.response_under(load, v.x, z.x));
        let got = plane.reload(load, &v, &z).unwrap();
        let want = line.reload(load, v.x, z.x).unwrap();
        let stored = plane.stored_energy(&z);
        assert_within(1e-13, z.x.abs(), got.deflection.x, want.deflection, || format!("{draw:?}"));
        assert_within(1e-13, stored, got.dissipated, want.dissipated, || format!("{draw:?}"));
        assert_eq!(plane.stationary(&v).x, line.stationary(v.x));
        let (got, want) = at_once;
        assert_eq!(got.rate.x, want.rate);
        assert_within(1e-13, want.force.abs(), got.force.x, want.force, || format!("{draw:?}"));
    });
}

#[test]
fn a_body_faster_than_expected_keeps_its_deflection() {
    // The friction rises with ‖v‖, and the axis that carries it is slow beside the other.
    let curve = StribeckParameters { viscous_friction: 1.0, ..paper::STICK_SLIP_CURVE };
    let axes = [axis([1.0, 1e4, 1.0]), axis([0.1, 1e4, 1.0])];
    let contact = PlaneFrBd::new(Stribeck::new(curve).unwrap(), axes).unwrap();
    let contact = contact.under_load(1.0).unwrap();
    let (v, z) = (Vector2::new(0.9, 3.0), Vector2::zeros());
    let expected = contact.companion(1.0).unwrap();
    let beyond = contact.model().limits(1.0).deflection.unwrap();
    let (held, done) = (contact.hold(&v, &z, 1.0), expected.step(&v, &z, 1.0).commit(&v));
    assert!(held.deflection.x > 1.2 * beyond.x);
    assert!((done.deflection - held.deflection).norm() < 1e-15);
}

#[test]
fn spin_radii_are_those_of_the_full_torque() {
    // ∫ r dF over a disc, by quadrature: of a uniform pressure, and of Hertz's p ∝ √(1 − r²/a²).
    let torque = |pressure: &dyn Fn(f64) -> f64| {
        let weigh = |power: i32| integral(0.0, 1.0, 4000, |r: f64| pressure(r) * r.powi(power));
        weigh(2) / weigh(1)
    };
    let hertz = torque(&|r: f64| (1.0 - r * r).max(0.0).sqrt());
    for (pressure, want, tolerance) in
        [(DiscPressure::Uniform, torque(&|_| 1.0), 1e-9), (DiscPressure::Hertz, hertz, 1e-5)]
    {
        assert_within(tolerance, 1.0, pressure.spin_radius(1.0), want, || format!("{pressure:?}"));
    }
    for radius in [-1.0, f64::NAN] {
        assert!(DiscPressure::Uniform.spin_radius(radius).is_nan());
        assert!(DiscPressure::Hertz.spin_radius(radius).is_nan());
    }
}

#[test]
fn bad_axes_are_refused_by_name() {
    let curve = table_2_curve();
    let good = axis([1.0, 1e4, 64.5]);
    for bad in [0.0, -0.0, -1.0, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE] {
        let axes = [good, Axis { friction_ratio: bad, ..good }];
        for refused in [
            PlaneFrBd::new(curve, axes).unwrap_err(),
            PlaneLuGre::classical(curve, axes).unwrap_err(),
            PlaneLuGre::with_viscous_friction(curve, axes, 0.0).unwrap_err(),
        ] {
            assert_eq!((refused.name, refused.component), ("friction_ratio", Some(1)), "{bad}");
        }
    }
    let model = PlaneFrBd::new(curve, [good; 2]).unwrap();
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(model.under_load(bad).unwrap_err().name, "normal_force");
        let contact = model.under_load(1.0).unwrap();
        assert_eq!(contact.companion(bad).unwrap_err().name, "fastest");
    }
}

/// Rest, tiny and huge velocities, no load, numbers that are none. Below `smallest` numbers are
/// subnormal.
fn edges<T: Scalar>(sizes: &[f64], smallest: f64) {
    let t = lit::<T>;
    let curve = table_2_curve::<T>();
    let axes = [axis([1.0, 1e4, 64.5]), axis([0.6, 1e4, 64.5])];
    let model = PlaneFrBd::new(curve, axes).unwrap();
    let contact = model.under_load(t(1.0)).unwrap();
    let z = Vector2::new(t(1e-5), t(-2e-5));
    let zero = Vector2::zeros();
    // At rest nothing relaxes, and the bristles are springs: λ = 0, r = 1.
    assert_eq!(contact.rate(&zero, &z), zero);
    let springs = contact.model().storage_stiffness().component_mul(&z);
    assert_eq!(contact.force(&zero, &z), springs);
    assert_eq!(contact.stationary_force(&zero), zero);
    assert!(contact.linearised(&zero, &z).rate_by_velocity.iter().all(|x| x.is_finite()));
    let finite = |x: &Vector2<T>| x.iter().all(|x| x.is_finite());
    for &size in sizes {
        let v = Vector2::new(t(0.6), t(0.8)) * t(size);
        for axis in model.axes(&v) {
            let affine = axis.affine(v.x.into(), z.x);
            assert!(affine.relaxation >= t(0.0) && affine.relaxation <= t(1e4 / 64.5), "{size:e}");
            assert!(affine.drive >= t(0.0) && affine.drive <= t(1.0), "{size:e}");
            if size < 1e-15 {
                assert!(affine.relaxation <= t(1e5 * size) && affine.drive == t(1.0), "{size:e}");
            }
        }
        let linearised = contact.linearised(&v, &z);
        assert!(linearised.rate_by_velocity.iter().all(|x| x.is_finite()), "{size:e}");
        assert!(linearised.force_by_velocity.iter().all(|x| x.is_finite()), "{size:e}");
        assert!(finite(&contact.force(&v, &z)) && finite(&contact.rate(&v, &z)), "{size:e}");
        // On the ellipse of friction where the curve is known; its viscous part is 0.04 ‖v‖.
        let force = contact.stationary_force(&v);
        let mu = curve.at(t(size));
        let on = (force.x / mu).powi(2) + (force.y / (t(0.6) * mu)).powi(2);
        // Subnormal components have few digits, the least have none.
        let few = t(size) < t(smallest);
        let tolerance = if few { 1.1 } else { 1e-5 };
        assert!((on - t(1.0)).abs() < t(tolerance), "{size:e}: {on}");
        let step = contact.companion(t(1.0)).unwrap().step(&v, &z, t(1e-3));
        assert!(finite(&step.bias()) && finite(&step.damping()), "{size:e}");
    }
    let nan = t(f64::NAN);
    for bad in [Vector2::new(nan, t(1.0)), Vector2::new(t(1.0), nan), Vector2::new(nan, t(0.0))] {
        let is_nan = |x: &Vector2<T>| x.iter().all(|x| x.partial_cmp(x).is_none());
        assert!(is_nan(&contact.rate(&bad, &z)) && is_nan(&contact.force(&bad, &z)));
        assert!(is_nan(&contact.hold(&bad, &z, t(1e-3)).deflection));
        let step = contact.companion(t(1.0)).unwrap().step(&bad, &z, t(1e-3));
        assert!(is_nan(&step.commit(&zero).deflection) && is_nan(&step.force(&zero)));
        assert!(model.limits(nan).deflection.is_none());
    }
    let held = contact.hold(&zero, &z, t(-1.0));
    assert!(held.deflection.iter().all(|z| z.partial_cmp(z).is_none()), "nothing goes back");
    // Without a load there are bristles, but no forces and no energies.
    let idle = model.under_load(t(0.0)).unwrap();
    let v = Vector2::new(t(0.1), t(0.2));
    assert_eq!(idle.force(&v, &z), zero);
    let done = idle.companion(t(1.0)).unwrap().step(&v, &z, t(1e-3)).commit(&v);
    assert_eq!((done.work, done.stored, done.dissipated), (t(0.0), t(0.0), t(0.0)));
    assert!(finite(&done.deflection) && done.force == zero);
}

#[test]
fn odd_velocities_answer() {
    edges::<f64>(&[5e-324, 1e-310, 1e-300, 1e-160, 1e-20, 1e-3, 1e20, 1e160, 1e300], 1e-307);
    edges::<f32>(&[1e-44, 1e-40, 1e-30, 1e-18, 1e-3, 1e10, 1e20, 1e30], 1e-37);
}

/// Ratios down to the smallest admissible one, under curves and loads that are as small: where a² μ
/// is below what the scalar carries there is no friction along that axis, which is 1e-36 of p off.
fn least_ratios<T: Scalar>(smallest: f64) {
    let t = lit::<T>;
    for powers in [[1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.5, 0.5, 1.0]] {
        let [ratio, mu, load] = powers.map(|power| smallest.powf(power));
        let axes = [axis([1.0, 1e4, 64.5]), axis([ratio, 1e4, 64.5])];
        let model = PlaneFrBd::new(coulomb(mu), axes).unwrap();
        let contact = model.under_load(t(load)).unwrap();
        let contact = contact.measured_at(t(1.0)).unwrap();
        for v in [0.0, 1e-9] {
            let v = Vector2::repeat(t(v));
            let limit = model.limits(t(1.0)).deflection.unwrap() * contact.normal_force();
            let force = contact.force(&v, &limit);
            for (force, ratio) in force.iter().zip([1.0, ratio]) {
                let most = t(ratio) * t(mu) * contact.normal_force();
                assert!(force.abs() <= most * t(1.00001), "{ratio:e} {mu:e} {load:e}: {force}");
            }
            let held = contact.hold(&v, &limit, t(1e-3)).deflection;
            assert!(held.iter().zip(&limit).all(|(z, most)| z.abs() <= *most * t(1.00001)));
        }
    }
}

#[test]
fn the_least_ratios_give_numbers_at_rest() {
    least_ratios::<f64>(1e-100);
    least_ratios::<f32>(1e-18);
}
