//! The implicit bristle by itself: its force balance, what it sticks to and what it refuses; its
//! relation to FrBD in numbers; how steps and integrators cope with it. The laws it
//! shares run over it in tests/models/laws.rs.

use std::cell::Cell;

use bristle::curve::{Coulomb, CoulombParameters, FrictionCurve, FunctionCurve, Stribeck};
use bristle::rheology::KelvinVoigt;
use bristle::{Bounds, Branch, Bristle, FrBd, ImplicitBristle, Rule, paper};
use bristle_specimens::closed_form::Curve;
use bristle_specimens::recipe::{Recipe, recipe, state};
use bristle_specimens::specimens::{curves, function, implicit, kelvin_voigt, stribeck, tabulated};
use bristle_specimens::{assert_within, check};

type Table2 = ImplicitBristle<Stribeck<f64>>;

fn table_2() -> (Table2, FrBd<Stribeck<f64>, KelvinVoigt<f64>>) {
    let (curve, bristle) = bristle_specimens::specimens::table_2();
    (implicit(curve, bristle), FrBd::new(curve, bristle))
}

#[test]
fn it_sticks_up_to_breakaway_and_no_further() {
    let (model, _) = table_2();
    // Binary fractions, so that the trial coefficient is exact: σ0 z = 1.5 at breakaway.
    let model_z = |carried: f64| carried / 1e4;
    for v in [1e-3, -1e-3, 0.0] {
        for carried in [0.0, 0.75, -1.25] {
            let z = model_z(carried);
            assert!(model.sticks(v, z));
            assert_eq!(model.rate(v, z), v);
            assert_eq!(model.tip_velocity(v, z), 0.0);
            assert_eq!(model.coefficient(v, z), 1e4 * z + 64.5 * v);
            let at = model.linearised(v, z);
            assert_eq!(
                (at.rate_by_deflection, at.rate_by_velocity),
                (0.0, 1.0),
                "elastic while it sticks"
            );
            assert_eq!((at.coefficient_by_deflection, at.coefficient_by_velocity), (1e4, 64.5));
        }
    }
    // Beyond by one part in 1e9 it creeps by that load over σ1 + σ2: the curve starts flat.
    let z = model_z(1.5 * (1.0 + 1e-9));
    assert!(!model.sticks(0.0, z));
    assert_within(1e-6, 1.0, model.tip_velocity(0.0, z) * 64.54 / 1.5e-9, 1.0, || "creep".into());
    assert_within(1e-6, 1.0, model.stick_excess(0.0, z) / 1.5e-9, 1.0, || "excess".into());
    assert!(model.stick_excess(0.0, 0.0) == -1.5);
    // The damper alone can break it away, at 1.5/64.5 m/s.
    assert!(model.sticks(0.0232, 0.0) && !model.sticks(0.0233, 0.0));
}

/// A Stribeck curve whose speeds a test sees, and which is no number where the test says so.
pub(super) fn watched(
    whole: Stribeck<f64>,
    look: impl Fn(f64) -> bool + Clone,
) -> impl FrictionCurve<f64> {
    let value = move |speed: f64| {
        let (mu, slope) = whole.coefficient_and_slope(Branch::Forward.of(speed));
        if look(speed) { (mu, slope) } else { (f64::NAN, f64::NAN) }
    };
    let curve = FunctionCurve::new(value, whole.bounds(f64::INFINITY)).unwrap();
    curve.with_least_slope(whole.least_slope().unwrap()).unwrap()
}

#[test]
fn few_looks_at_the_curve_are_needed_and_never_more_than_160() {
    let looks = Cell::new(0_u32);
    let (most, sum, count) = (Cell::new(0_u32), Cell::new(0_u32), Cell::new(0_u32));
    check(2000, (recipe(), state()), |(r, state)| {
        let curve = watched(stribeck(&r, 2.0), |_| {
            looks.set(looks.get() + 1);
            true
        });
        // From hardly single-valued on.
        let fall = Curve::Stribeck(2.0).steepest_fall(&r);
        let bristle = kelvin_voigt(r.stiffness, r.damping + 1.0001 * fall + 1e-2);
        let model = implicit(curve, bristle);
        let (v, z) = (state.velocity, 1.5 * state.fraction * r.static_ / r.stiffness);
        looks.set(0);
        assert!(model.rate(v, z).is_finite());
        most.set(most.get().max(looks.get()));
        sum.set(sum.get() + looks.get());
        count.set(count.get() + 1);
    });
    let mean = f64::from(sum.get()) / f64::from(count.get());
    // Measured: 5.0 and 38; the guarantee is 160 and the look at rest.
    assert!(most.get() <= 60 && mean < 8.0, "most {}, mean {mean}", most.get());
}

#[test]
fn the_worst_of_curves_is_still_solved_within_the_bound() {
    // Steps that a Newton method cannot see, as smooth as a curve may be: a staircase.
    let looks = Cell::new(0_u32);
    for (height, width) in [(0.5, 1e-3), (3.0, 1e-9), (1e-6, 1e-12)] {
        let curve = FunctionCurve::new(
            |speed: f64| {
                looks.set(looks.get() + 1);
                let u = speed / width;
                let (whole, part) = (u.floor().min(1e6), u - u.floor());
                let rise = part.powi(40);
                (1.0 + height * (whole + rise), height * 40.0 * part.powi(39) / width)
            },
            Bounds { min: 1.0, max: f64::INFINITY },
        )
        .unwrap()
        .with_least_slope(0.0)
        .unwrap();
        let model = implicit(curve, kelvin_voigt(1.0, 1e-3));
        for i in 0..200 {
            let load = 1.0 + height * f64::from(i) * 0.1 + 1e-9;
            looks.set(0);
            let tip = model.tip_velocity(0.0, load);
            assert!(looks.get() <= 161, "{} looks", looks.get());
            // Below the answer it carries less, above more, as near as numbers go.
            let carried = |u: f64| 1e-3 * u + model.curve().coefficient(u.into());
            let near = 1e-14 * tip;
            assert!(carried(tip - near) <= load + 1e-14 * load, "{load}");
            assert!(carried(tip + near) >= load - 1e-14 * load, "{load}");
        }
    }
}

#[test]
fn a_curve_on_which_newton_would_crawl_is_solved_by_bisection() {
    // μ = 1 + (v/w)⁴⁰ from a guess a million w away: a Newton step takes off a fortieth, 550 would
    // be needed.
    let curve = FunctionCurve::new(
        |speed: f64| {
            let u: f64 = speed / 1e-3;
            (1.0 + u.powi(40), 40.0 * u.powi(39) / 1e-3)
        },
        Bounds { min: 1.0, max: f64::INFINITY },
    )
    .unwrap()
    .with_least_slope(0.0)
    .unwrap();
    let model = implicit(curve, kelvin_voigt(1.0, 1e-3));
    // (v/w)⁴⁰ = 1 − σ1 v, which is 1e-6: v = w to 3e-8.
    assert_within(1e-7, 1e-3, model.tip_velocity(0.0, 2.0), 1e-3, || "tip".into());
}

#[test]
fn an_answer_at_the_far_end_of_its_bracket_is_met() {
    // σ1 v = 5e5 and μ = 0.02: in single precision the guess is the end (e − μ)/σ1 = e/σ1 itself.
    let curve = FunctionCurve::new(
        |speed: f32| {
            let square = 1.0 + (speed / 0.02).powi(2);
            (0.02 * (1.0 + 0.5 / square.sqrt()), -0.5 * speed / (square * square.sqrt()) / 0.02)
        },
        Bounds { min: 0.02, max: 0.03 },
    )
    .unwrap()
    .with_least_slope(-0.2)
    .unwrap();
    let model = implicit(curve, kelvin_voigt(1_f32, 590.0));
    let tip = model.tip_velocity(890.5, 0.0);
    assert!((tip - 890.5).abs() < 1e-3, "{tip}");
    // μ/(μ + σ1 v), of which μ and a half of μ v_S/v are left out: 4e-8 and 1.1e-5.
    let drive = model.affine(890.5.into(), 0.0).drive;
    assert!((drive / (0.02 / (590.0 * 890.5)) - 1.0).abs() < 2e-5, "{drive}");
}

#[test]
fn the_least_slope_of_every_curve_is_its_least_slope() {
    check(64, recipe(), |r| {
        for (curve, subject) in curves::<f64>(&r) {
            let Some(least) = subject.least_slope() else { panic!("{curve:?} does not know") };
            let scale = (r.static_ - r.dynamic) / r.stribeck_velocity
                + r.viscous
                + r.dynamic * 30.0 / r.stribeck_velocity;
            let mut lowest = f64::INFINITY;
            // From v_S/1e6 to 1e3 v_S, 300 speeds to a decade.
            for i in 0..2700 {
                let speed = 1e-6 * r.stribeck_velocity * 10_f64.powf(f64::from(i) / 300.0);
                for v in [speed, -speed] {
                    let slope = subject.coefficient_and_slope(v.into()).1 * v.signum();
                    assert!(slope >= least - 1e-12 * scale, "{curve:?}: {slope:e} < {least:e}");
                    lowest = lowest.min(slope);
                }
            }
            if curve == Curve::Stribeck(0.7) {
                // The drop at v_S/1e6 is 63 times as steep as at v_S.
                assert!(r.static_ == r.dynamic || least == f64::NEG_INFINITY);
            } else {
                // It is come close to: a hundredth off the place costs (1/100)² at a smooth bottom.
                assert_within(1e-3, scale, lowest, least, || format!("{curve:?}"));
            }
        }
    });
}

#[test]
fn the_threshold_of_table_2_is_the_closed_form() {
    // (μ_s − μ_d)√(2/e)/v_S − σ2 = 50·0.857763885 − 0.04.
    let curve = Stribeck::new(paper::STICK_SLIP_CURVE).unwrap();
    let threshold = 50.0 * (2.0 / std::f64::consts::E).sqrt() - 0.04;
    let with = |damping| ImplicitBristle::new(curve, kelvin_voigt(1e4, damping));
    assert!(with(threshold * (1.0 + 1e-12)).is_ok());
    let refused = with(threshold * (1.0 - 1e-12)).unwrap_err();
    assert_eq!(refused.rule, Rule::Stated("be positive, or several tip velocities fit"));
    let refused = with(20.0).unwrap_err();
    assert_within(1e-12, 1.0, refused.value, 20.0 - threshold, || "margin".into());
    let told = refused.to_string();
    let begins = "micro_damping + least slope of the curve is -22.848194248";
    assert!(told.starts_with(begins), "{told}");
    assert!(told.ends_with(", but must be positive, or several tip velocities fit"), "{told}");
    // A load above the reference load makes the curve steeper, and folds it beyond a scale. A curve
    // that does not fall never is folded.
    let folding = with(64.5).unwrap().folding_scale().unwrap();
    assert_within(1e-12, 1.0, folding, 64.5 / threshold, || "scale".into());
    let level = CoulombParameters { dynamic_coefficient: 1.0, viscous_friction: 0.0 };
    let level = ImplicitBristle::new(Coulomb::new(level).unwrap(), kelvin_voigt(1e4, 64.5));
    assert_eq!(level.unwrap().folding_scale(), None);
}

#[test]
fn what_has_no_single_answer_is_refused_by_name() {
    let with = |viscous_friction, damping| {
        let curve = CoulombParameters { dynamic_coefficient: 1.0, viscous_friction };
        ImplicitBristle::new(Coulomb::new(curve).unwrap(), kelvin_voigt(1e4, damping))
    };
    // A Coulomb curve on a spring: every speed carries the same.
    let refused = with(0.0, 0.0).unwrap_err();
    assert_eq!((refused.name, refused.value), ("micro_damping + viscous_friction", 0.0));
    assert!(with(0.1, 0.0).is_ok() && with(0.0, 0.1).is_ok());
    // Table 1 is folded.
    let curve = Stribeck::new(paper::TYRE_CURVE).unwrap();
    let bristle = KelvinVoigt::new(paper::TYRE_BRISTLE).unwrap();
    assert!(ImplicitBristle::new(curve, bristle).unwrap_err().value < 0.0);
    // A curve that does not tell how steeply it falls, even if it rises.
    let bounds = Bounds { min: 1.0, max: f64::INFINITY };
    let unknown = FunctionCurve::new(|speed: f64| (1.0 + speed, 1.0), bounds).unwrap();
    let refused = ImplicitBristle::new(unknown, kelvin_voigt(1e4, 5.0)).unwrap_err();
    assert!(refused.value.is_nan() && refused.name == "micro_damping + least slope of the curve");
    assert!(unknown.with_least_slope(f64::NAN).is_err());
    // The function and the table of the other tests, when they are damped enough.
    let r = Recipe::TABLE_2;
    assert!(ImplicitBristle::new(function::<f64>(&r), kelvin_voigt(1e4, 64.5)).is_ok());
    assert!(ImplicitBristle::new(tabulated::<f64>(&r), kelvin_voigt(1e4, 64.5)).is_ok());
}

#[test]
fn in_the_stribeck_range_disturbances_fade_thirteen_times_as_fast_as_with_frbd() {
    let (solved, one_step) = table_2();
    let v = 5.5e-3;
    let z = solved.stationary(v);
    // σ0 v/(σ1 v + μ), and σ0/(σ1 + μ') with μ' = 0.04 − 2·0.5·v e^(−0.3025)/v_S².
    let decay = (-0.3025_f64).exp();
    let one = 1e4 * v / (64.5 * v + 1.0 + 0.5 * decay + 0.04 * v);
    let exact = 1e4 / (64.54 - v * decay / 1e-4);
    assert_within(1e-12, one, -one_step.linearised(v, z).rate_by_deflection, one, || "FrBD".into());
    assert_within(1e-12, exact, -solved.linearised(v, z).rate_by_deflection, exact, || {
        "solved".into()
    });
    assert_eq!((one.round(), exact.round()), (32.0, 418.0));
    // In steady sliding the chord of the one is that of the other, and the forces are the same.
    assert_within(1e-12, one, solved.affine(v.into(), z).relaxation, one, || "chord".into());
    // Fast, they fade alike: σ0/(σ1 + σ2) of both within μ/(σ1 v).
    let (fast, slow) = (
        -solved.linearised(100.0, z).rate_by_deflection,
        -one_step.linearised(100.0, z).rate_by_deflection,
    );
    assert_within(2e-3, fast, slow, fast, || "fast".into());
}

#[test]
fn at_high_speed_it_is_frbd_but_for_a_constant() {
    let (solved, one_step) = table_2();
    for z in [-1e-4, 0.0, 1e-4] {
        for v in [1e2, 1e3, 1e4] {
            let (a, b) = (solved.coefficient(v, z), one_step.coefficient(v, z));
            // With S = σ1 + σ2 and μ = 1 + σ2 v the one is σ0 z + σ1 (σ2 v + 1 − σ0 z)/S, the other
            // σ0 z + σ1 v (σ2 v + 1 − σ0 z)/(S v + 1): in powers of 1/v, and what is left out is
            // 5e-4/v².
            let (s1, s2, sum) = (64.5, 0.04, 64.54);
            let next = s1 / (sum * sum) * (s2 / sum - 1.0 + 1e4 * z);
            let want = -s1 * s2 / (sum * sum) + next / v;
            assert_within(1e-3 / (v * v), 1.0, b - a, want, || format!("v = {v}, z = {z}"));
        }
    }
}

#[cfg(feature = "alloc")]
mod runs {
    use super::*;
    use bristle::Mechanism;
    use bristle::ode::{
        Direction, DormandPrince8, Event, Method, Output, Rodas5P, Solver, System, Tolerances,
    };
    use bristle::scene::{MassSpringDamper, MassSpringDamperParameters, PrescribedVelocity};
    use bristle::signal::{Sine, SineParameters};
    use bristle_specimens::ode::rig;
    use nalgebra::Vector3;

    fn sine(mean: f64, amplitude: f64, frequency: f64) -> Sine<f64> {
        Sine::new(SineParameters { mean, amplitude, frequency, phase: 0.0 }).unwrap()
    }

    fn solver<M, S, const N: usize>(method: M, system: &S, relative: f64) -> Solver<f64, M, N>
    where
        M: Method<f64, N>,
        S: System<f64, N>,
    {
        Solver::checked(method, Tolerances::scaled(relative, system.scales()).unwrap())
    }

    /// Mean period of stick-slip in the rig of Table 2, p = 1 N, over 60 s from rest.
    fn period<M, N>(model: M, method: N, rtol: f64) -> f64
    where
        M: Bristle<f64, Deflection = f64>,
        N: Method<f64, 3>,
    {
        let (rig, output) = (rig(model, 0.1), Output::Uniform(2));
        let slips = |_: f64, state: &Vector3<f64>| state[1] - 0.01;
        let events = [Event { function: &slips, direction: Direction::Rising, stops: false }];
        let solver = solver(method, &rig, rtol);
        let run = solver.solve_with_events(&rig, 0.0..60.0, rig.at_rest(), &events, output);
        let run = run.unwrap();
        let slips = run.events();
        assert_eq!(slips.len(), 7);
        (slips[6].time - slips[0].time) / 6.0
    }

    #[test]
    fn the_period_of_stick_slip_is_longer_than_with_frbd() {
        let (solved, one_step) = table_2();
        // A program apart from the library's (classical Runge–Kutta with steps of 2e-4, 1e-4 and
        // 5e-5 s, the tip by Newton and bisection from the formulas) gives 7.755 823 344(2) s,
        // and one in 80-bit numbers 7.755 823 344 514 s.
        for (method, got) in [
            ("DormandPrince8", period(solved, DormandPrince8, 1e-9)),
            ("Rodas5P", period(solved, Rodas5P, 1e-9)),
        ] {
            assert!((got - 7.755_823_344).abs() < 2e-7, "{method}: {got}");
        }
        let got = period(one_step, DormandPrince8, 1e-9);
        // The same with FrBD's rate gives 7.639 267 026 s at 2e-4 and at 1e-4 s.
        assert!((got - 7.639_267_026).abs() < 2e-7, "FrBD: {got}");
    }

    #[test]
    fn the_force_of_stick_slip_is_as_far_off_as_the_tolerance_says() {
        // From a program apart from the library's, in 80-bit numbers: classical Runge–Kutta with
        // Richardson's extrapolation, restarted where the tip begins and ceases to stick, the tip
        // by Newton and bisection. Steps of 2e-4, 1e-4 and 5e-5 s agree to 1.2e-11 N. At 56.8 s the
        // body comes to a stop, and the force falls by 56 N/s.
        let wanted = [
            (15.4, 1.449_129_746_59),
            (15.45, 1.023_097_010_15),
            (30.95, 1.103_963_789_17),
            (49.05, 0.215_445_495_04),
            (56.8, 0.464_627_066_20),
        ];
        let (contact, rig) = (table_2().0.under_load(1.0).unwrap(), rig(table_2().0, 0.1));
        let off = |rtol: f64| {
            let solver = solver(DormandPrince8, &rig, rtol);
            let run = solver.solve(&rig, 0.0..60.0, rig.at_rest(), Output::Uniform(1201)).unwrap();
            wanted.iter().fold(0.0_f64, |worst, &(time, force)| {
                let state = run.states()[(time * 20.0_f64).round() as usize];
                worst.max((contact.force(state[1], state[2]) - force).abs())
            })
        };
        // A stop that comes 30 ns late is a force off by 1.7e-6 N: the error is the run's, not the
        // model's, and goes with the tolerance. (Measured: 4.3e-6, 1.3e-8 and 4.3e-10 N.)
        for (rtol, enough) in [(1e-9, 1e-5), (1e-11, 1e-7), (1e-12, 1e-8)] {
            let off = off(rtol);
            assert!(off < enough, "{off:e} N at {rtol:e}");
        }
    }

    #[test]
    fn the_loops_of_frictional_lag_are_two_tenths_apart() {
        let (solved, one_step) = table_2();
        fn forces<M: Bristle<f64, Deflection = f64>>(model: M, frequency: f64) -> Vec<f64> {
            let velocity = sine(0.0055, 0.005, frequency);
            let scene = PrescribedVelocity::new(model.under_load(1.0).unwrap(), velocity);
            let (start, output) = (scene.stationary(0.0), Output::Uniform(5001));
            let solver = solver(DormandPrince8, &scene, 1e-8);
            let run = solver.solve(&scene, 0.0..10.0 / frequency, start, output).unwrap();
            run.iter().skip(4500).map(|(t, state)| scene.friction_force(t, state)).collect()
        }
        for (frequency, want) in [(25.0, 0.211_006_6), (50.0, 0.207_002_5), (100.0, 0.200_990_3)] {
            let (a, b) = (forces(solved, frequency), forces(one_step, frequency));
            let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // A program apart from the library's, at the same instants (classical Runge–Kutta with
            // 500 and 1000 steps in a period, the tip by bisection), gives these to seven digits.
            assert!((apart - want).abs() < 1e-6, "{frequency} Hz: {apart}");
        }
    }

    #[test]
    fn load_cycles_below_breakaway_leave_no_drift_where_frbd_walks_away() {
        let (solved, one_step) = table_2();
        // 0 to 0.8 F_b and back, once a second, on a unit mass.
        fn positions<M: Bristle<f64, Deflection = f64>>(model: M) -> [f64; 2] {
            let mechanism = Mechanism { mass: 1.0, spring_stiffness: 0.0, viscous_damping: 0.0 };
            let scene = MassSpringDamper::new(MassSpringDamperParameters {
                contact: model.under_load(1.0).unwrap(),
                mechanism,
                drive_velocity: 0.0,
                force: sine(0.6, 0.6, 1.0),
            });
            let (scene, output) = (scene.unwrap(), Output::Uniform(3));
            let solver = solver(DormandPrince8, &scene, 1e-9);
            let run = solver.solve(&scene, 0.0..20.0, scene.at_rest(), output).unwrap();
            [run.states()[1][0], run.states()[2][0]]
        }
        let [half, whole] = positions(solved);
        // It sticks: nothing but the integrator's errors, 1e-9 of 1.5e-4 m and some of the
        // velocity's.
        assert!((whole - half).abs() < 1e-11, "{:e} m", whole - half);
        // FrBD: (μ_s/σ0) ln[F_b²/(F_b² − F2²)] per cycle, quasi-static; the cycles are not quite.
        let [half, whole] = positions(one_step);
        let drift = 10.0 * 1.5e-4 * (1.0 / (1.0 - 0.64_f64)).ln();
        assert_within(0.1, drift, whole - half, drift, || "FrBD".into());
    }

    #[test]
    fn the_beginning_of_sliding_is_an_event() {
        let (model, _) = table_2();
        let rig = rig(model, 0.1);
        let breaks_away = |_: f64, state: &Vector3<f64>| model.stick_excess(state[1], state[2]);
        let events = [Event { function: &breaks_away, direction: Direction::Rising, stops: true }];
        let (solver, output) = (solver(Rodas5P, &rig, 1e-8), Output::Uniform(2));
        let run = solver.solve_with_events(&rig, 0.0..60.0, rig.at_rest(), &events, output);
        // Stuck, k (0.1 t − x) = F with x = z nearly steady at 0.2/1e4 m/s: F = 1.5 N at t = 7.5 s
        // + x/0.1 + transients.
        let time = run.unwrap().events()[0].time;
        assert_within(1e-3, 7.5, time, 7.5 + 1.5e-4 / 0.1, || "breakaway".into());
    }
}
