//! Bodies in a plane: they arrive where two independent integrators say, and stand where they
//! should.
#![cfg(feature = "alloc")]

use bristle::Mechanism;
use bristle::companion::{PointMass, VelocityHistory};
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::ode::{
    self, DormandPrince, DormandPrince8, Output, Rodas5P, Solver, System, Tolerances,
};
use bristle::signal::{Sine, SineParameters};
use bristle_plane::{
    Axis, PlaneBody, PlaneBodyParameters, PlaneBristle, PlaneCompanion, PlaneFrBd,
};
use nalgebra::{SVector, Vector2, Vector3};

use bristle_specimens::assert_within;
use bristle_specimens::specimens::{kelvin_voigt, table_2_bristle, table_2_curve};

type Model<const N: usize> = PlaneFrBd<Stribeck<f64>, f64, N>;

/// The pulled block: Table 2, with six tenths of the friction across.
fn pulled() -> Model<2> {
    let bristle = table_2_bristle();
    let axes = [1.0, 0.6].map(|friction_ratio| Axis { friction_ratio, bristle });
    PlaneFrBd::new(table_2_curve(), axes).unwrap()
}

/// The spinning block.
fn spinning() -> Model<3> {
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: 0.3,
        dynamic_coefficient: 0.25,
        stribeck_velocity: 0.02,
        stribeck_exponent: 2.0,
        viscous_friction: 0.0,
    });
    PlaneFrBd::isotropic(curve.unwrap(), kelvin_voigt(1e4, 50.0))
}

/// Positions, velocities and deflections at 40 s: ten digits, from two integrators with the
/// equations written out.
const PULLED: [f64; 6] =
    [-1.23462930, 0.445240871, 0.198556786, -0.337793501, 7.08811076e-5, -4.36412227e-5];

fn pulled_body() -> PlaneBody<f64, Model<2>, 2, Sine<f64>> {
    let sine = |mean, amplitude, phase| {
        let frequency = 0.3 / std::f64::consts::TAU;
        Sine::new(SineParameters { mean, amplitude, frequency, phase }).unwrap()
    };
    PlaneBody::new(PlaneBodyParameters {
        contact: pulled().under_load(1.0).unwrap(),
        mechanisms: [Mechanism { mass: 1.0, spring_stiffness: 2.0, viscous_damping: 0.0 }; 2],
        anchor: [sine(0.0, 1.5, 0.0), sine(1.5, -1.5, std::f64::consts::FRAC_PI_2)],
        force: [0.0; 2],
    })
    .unwrap()
}

#[test]
fn a_pulled_block_arrives_where_two_integrators_say() {
    let body = pulled_body();
    let run = ode::solve(&body, 0.0..40.0, SVector::<f64, 6>::zeros(), 1e-11, Output::Uniform(2))
        .unwrap();
    // The last printed digit of each.
    let digits = [1e-8, 1e-9, 1e-9, 1e-9, 1e-13, 1e-13];
    for i in 0..6 {
        assert_within(1.0, digits[i], run.states()[1][i], PULLED[i], || format!("state {i}"));
    }
}

#[test]
fn a_spinning_block_comes_to_rest_where_two_integrators_say() {
    let radius = 0.05;
    let free = |mass| Mechanism { mass, spring_stiffness: 0.0, viscous_damping: 0.0 };
    let body = PlaneBody::new(PlaneBodyParameters {
        contact: spinning().under_load(9.81).unwrap(),
        // The third axis is R ω: its mass is J/R².
        mechanisms: [free(1.0), free(1.0), free(2e-3 / (radius * radius))],
        anchor: [0.0; 3],
        force: [0.0; 3],
    })
    .unwrap();
    let mut start = SVector::<f64, 9>::zeros();
    (start[3], start[4], start[5]) = (0.5, 0.2, 15.0 * radius);
    let run = ode::solve(&body, 0.0..0.5, start, 1e-11, Output::Uniform(2)).unwrap();
    let end = run.states()[1];
    // The last printed digit of each; half of it rounds.
    assert_within(0.6, 1e-8, end[0], 0.08749125, || "x".into());
    assert_within(0.6, 1e-7, end[1], 0.0349965, || "y".into());
    assert_within(0.6, 1e-7, end[2] / radius, 2.3503214, || "angle".into());
    assert!(end.rows(3, 3).norm() < 1e-6, "it rests: {end}");
}

/// Every method of the solver passes the cone of ‖v‖ at rest with the answers of the others.
#[test]
fn every_method_passes_the_cone() {
    let body = pulled_body();
    let tolerances = Tolerances::scaled(1e-9, System::<_, 6, 0>::scales(&body)).unwrap();
    let (rest, two) = (SVector::zeros(), Output::Uniform(2));
    for run in [
        Solver::checked(DormandPrince, tolerances).solve(&body, 0.0..40.0, rest, two),
        Solver::checked(DormandPrince8, tolerances).solve(&body, 0.0..40.0, rest, two),
        Solver::checked(Rodas5P, tolerances).solve(&body, 0.0..40.0, rest, two),
    ] {
        let end = run.unwrap().states()[1];
        for i in 0..2 {
            assert_within(1e-6, 1.0, end[i], PULLED[i], || format!("{end}"));
        }
    }
}

/// m v̇ = f(t, x) − F with the companion step.
fn companion_run<const N: usize>(
    contact: &PlaneCompanion<f64, Model<N>, N>,
    masses: SVector<f64, N>,
    start: SVector<f64, N>,
    (force, stiffness): (impl Fn(f64, &SVector<f64, N>) -> SVector<f64, N>, f64),
    (steps, end): (u32, f64),
) -> [SVector<f64, N>; 3] {
    let h = end / f64::from(steps);
    let (mut x, mut v, mut z) = (SVector::zeros(), start, SVector::zeros());
    let mut history: [_; N] = core::array::from_fn(|i| VelocityHistory::new(v[i]));
    for n in 0..steps {
        let predicted = SVector::from_fn(|i, _| history[i].predict());
        let step = contact.step(&predicted, &z, h);
        let pull = force(h * (f64::from(n) + 0.5), &x);
        let inertia = masses * (2.0 / h);
        let resistance = inertia.add_scalar(0.5 * h * stiffness) + step.damping();
        let mean = (inertia.component_mul(&v) + pull - step.bias()).component_div(&resistance);
        z = step.commit(&mean).deflection;
        (x, v) = (x + h * mean, 2.0 * mean - v);
        history.iter_mut().zip(&v).for_each(|(history, &v)| history.push(v));
    }
    [x, v, z]
}

#[test]
fn companion_steps_are_of_second_order_in_the_plane() {
    let contact = pulled().under_load(1.0).unwrap().companion(1.0).unwrap();
    let anchor = |t: f64| Vector2::new(1.5 * (0.3 * t).sin(), 1.5 * (1.0 - (0.3 * t).cos()));
    let run = |steps: u32| {
        let pull = |t: f64, x: &Vector2<f64>| 2.0 * (anchor(t) - x);
        let ones = Vector2::repeat(1.0);
        companion_run(&contact, ones, Vector2::zeros(), (pull, 2.0), (steps, 40.0))
    };
    // Of place, velocity and deflection.
    let errors = |steps: u32| {
        let run = run(steps);
        [0, 1, 2].map(|i| (run[i] - Vector2::new(PULLED[2 * i], PULLED[2 * i + 1])).norm())
    };
    let (coarse, fine) = (errors(20_000), errors(40_000));
    for (coarse, fine) in coarse.iter().zip(fine) {
        assert!((3.0..5.5).contains(&(coarse / fine)), "{coarse:e}, {fine:e}");
    }
}

#[test]
fn a_spinning_block_comes_to_rest_by_companion_steps() {
    let contact = spinning().under_load(9.81).unwrap().companion(2.0).unwrap();
    let radius = 0.05;
    let masses = Vector3::new(1.0, 1.0, 2e-3 / (radius * radius));
    let start = Vector3::new(0.5, 0.2, 15.0 * radius);
    let run = |steps| {
        let nothing = |_: f64, _: &Vector3<f64>| Vector3::zeros();
        companion_run(&contact, masses, start, (nothing, 0.0), (steps, 0.5))[0]
    };
    let (coarse, fine) = (run(50_000), run(100_000));
    let best = fine + (fine - coarse) / 3.0;
    let got = Vector3::new(best.x, best.y, best.z / radius);
    // The sheet has seven digits of the angle, and Richardson leaves the fourth order.
    let want = Vector3::new(0.08749125, 0.0349965, 2.3503214);
    assert_within(1e-7, 1.0, (got - want).norm(), 0.0, || format!("{got}"));
}

#[test]
fn a_block_on_a_tilted_plane_stands_for_an_hour_at_sixty_steps_a_second() {
    let model = PlaneFrBd::<_, _, 2>::isotropic(table_2_curve(), table_2_bristle());
    // 1 kg on a slope of 30°, downhill between the axes: 4.9 N against 12.7 N of breakaway.
    let (weight, slope) = (9.81, 30_f64.to_radians());
    let contact = model.under_load(weight * slope.cos()).unwrap().companion(1.0).unwrap();
    let pull = Vector2::new(0.6, 0.8) * (weight * slope.sin());
    let h = 1.0 / 60.0;
    // With v̄ = v₁ a stiff start settles at once; with v̄ = (v₀ + v₁)/2 it rings, and fades.
    for end_weight in [1.0, 0.5] {
        let (mut x, mut v, mut z) = (Vector2::zeros(), Vector2::zeros(), Vector2::zeros());
        let mut settled: Vector2<f64> = x;
        for n in 0..3600 * 60 {
            let step = contact.step(&v, &z, h);
            let mean = step.point_mass(PointMass {
                mass: Vector2::repeat(1.0),
                velocity: v,
                force: pull,
                end_weight: Vector2::repeat(end_weight),
            });
            x += h * mean;
            (v, z) = (v + (mean - v) / end_weight, step.commit(&mean).deflection);
            if n == 60 * 60 {
                settled = x;
            }
        }
        let creep = (x - settled).norm();
        assert!(creep < 1e-12, "{creep:e} m in an hour, end weight {end_weight}");
        assert!(x.norm() < 1e-3, "it stands where it was put: {x}");
    }
}
