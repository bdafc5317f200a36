//! A load that varies: a wheel that stands stands still, no bristle carries more than the surface
//! holds, steady sliding is p μ(v), and renewal creeps.
//!
//! Source: for the creep of renewal, each rise of the load from p to p' takes the share 1 − p/p' of
//! a deflection, so that a slow cycle walks by F/σ0 (1/p_min − 1/p_max).

use bristle::curve::Stribeck;
use bristle::{Bristle, ParameterError, Reloaded, paper};
use bristle_plane::PlaneFrBd;
use bristle_rolling::{CombinedGrid, Grid, Motion, PolynomialExponential, Segment};
use bristle_specimens::draw::Draw;
use bristle_specimens::{assert_within, check};
use nalgebra::Vector2;
use proptest::prelude::*;

use crate::tyre::{LENGTH, LOAD, STIFFNESS, Tyre, constant, frbd, loaded as patch, parabolic};

type Form = PolynomialExponential<f64, 3>;
type Standing = bristle_rolling::ExactPatch<f64, Tyre, 3, [Segment<f64, 3>; 40]>;

const TURN: f64 = std::f64::consts::TAU;

fn forms() -> [Form; 2] {
    [constant().padded(), parabolic()]
}

/// Damped critically under 400 kg: 2 √(σ0 m/P).
fn friction() -> Tyre {
    frbd(10.0)
}

fn plane() -> PlaneFrBd<Stribeck<f64>, f64, 2> {
    PlaneFrBd::isotropic(*friction().curve(), *friction().rheology())
}

/// The way [m], after the first second, of 400 kg on a locked wheel that a force pulls while the
/// load varies by ±50 %.
fn walked(
    pressure: Form,
    (pull, frequency, seconds): (f64, f64, f64),
    change: impl Fn(&mut Standing, f64, f64) -> Result<Reloaded<f64, ()>, ParameterError>,
) -> f64 {
    let mut wheel = patch(friction(), pressure).exact([[Segment::default(); 40]]).unwrap();
    let (mass, h) = (400.0, 1e-3);
    let (mut v, mut last, mut way) = (0.0, 0.0, 0.0);
    for number in 0..(seconds / h) as u32 {
        let middle = h * (f64::from(number) + 0.5);
        let predicted = if v * last < 0.0 { v } else { 1.5 * v - 0.5 * last };
        let load = LOAD * (1.0 + 0.5 * (TURN * frequency * middle).sin());
        let _ = change(&mut wheel, load, predicted).unwrap();
        let motion = Motion { slip_velocity: predicted, rolling_speed: 0.0 };
        let step = wheel.companion_step(motion, h).unwrap();
        let momentum = 2.0 * mass / h;
        let mean = (momentum * v + pull - step.bias()) / (momentum + step.damping());
        step.commit(mean).unwrap();
        (last, v) = (v, 2.0 * mean - v);
        if middle > 1.0 {
            way += h * mean;
        }
    }
    way
}

/// What the least load holds while it slides.
fn holds() -> f64 {
    0.5 * LOAD * paper::TYRE_CURVE.dynamic_coefficient
}

#[test]
fn a_wheel_on_a_slope_stands_while_its_load_varies() {
    for pressure in forms() {
        for frequency in [2.0, 50.0] {
            let pull = (0.6 * holds(), frequency, 20.0);
            let way = walked(pressure, pull, Standing::reload);
            assert!(way.abs() <= 1e-12, "at {frequency} Hz: {way:e} m");
        }
    }
}

#[test]
#[ignore = "an hour of a standing wheel takes minutes"]
fn a_wheel_on_a_slope_stands_for_an_hour() {
    let way = walked(forms()[0], (0.6 * holds(), 60.0, 3600.0), Standing::reload);
    assert!(way.abs() <= 1e-12, "{way:e} m");
}

#[test]
fn by_renewal_it_creeps_as_the_closed_form_says() {
    // A slow cycle of a force far below what is held.
    let pull = 0.01 * holds();
    for pressure in forms() {
        let way = walked(pressure, (pull, 1.0, 11.0), |wheel, load, _| wheel.renew(load));
        let cycle = pull / STIFFNESS * (1.0 / (0.5 * LOAD) - 1.0 / (1.5 * LOAD));
        // 1 % of what it holds bends the spring by as much.
        assert_within(0.02, 10.0 * cycle, way, 10.0 * cycle, || "way".into());
    }
}

#[test]
fn no_force_exceeds_what_the_load_holds() {
    // Viscous friction lifts the curve beyond μ_s by 1e-3 at most; a scan finds it to 1e-7.
    let speeds = (0..=100_000).map(|i| 1e-4 * f64::from(i));
    let most = speeds.map(|v| friction().stationary_coefficient(v)).fold(0.0, f64::max);
    check(60, any::<u64>(), |seed| {
        let mut draw = Draw(seed);
        let pressure = draw.one_of(&forms());
        let patch = patch(friction(), pressure);
        let (mut exact, mut grid) = (patch.exact_in(60).unwrap(), Grid::new(&patch, 20).unwrap());
        for _ in 0..60 {
            let load = draw.one_of(&[0.0, 1.0, 1.0, 1.0]) * draw.logarithmic(1e2, 1e5);
            let slip_velocity = draw.sign() * draw.logarithmic(1e-4, 10.0);
            let rolling_speed = draw.one_of(&[0.0, 1.0]) * draw.logarithmic(0.1, 30.0);
            let motion = Motion { slip_velocity, rolling_speed };
            let reloaded =
                [exact.reload(load, slip_velocity), grid.reload(load, |_| slip_velocity)];
            assert!(reloaded.iter().all(|left| left.as_ref().unwrap().dissipated >= 0.0));
            // Stuck bristles, then after a step.
            let most = load * most * (1.0 + 1e-6);
            let h = draw.logarithmic(1e-4, 1e-1);
            let [stuck, held] = [exact.force(0.0), grid.force(|_| 0.0)];
            let [one, other] = [exact.step(motion, h), grid.step(motion, h)].map(Result::unwrap);
            for force in [stuck, held, one, other] {
                assert!(force.abs() <= most, "{force} of {most} N");
            }
        }
    });
}

#[test]
fn steady_sliding_is_the_load_times_the_curve() {
    for (load, v) in [(500.0, 0.3), (4000.0, 2.0), (9000.0, -2.0)] {
        let want = load * friction().stationary_coefficient(v);
        for pressure in forms() {
            let tyre = patch(friction(), pressure);
            let locked = Motion { slip_velocity: v, rolling_speed: 0.0 };
            let mut exact = tyre.exact_in(20).unwrap();
            let _ = exact.reload(load, v).unwrap();
            let mut grid = Grid::new(&tyre, 20).unwrap();
            let _ = grid.reload(load, |_| v).unwrap();
            let under = tyre.under_load(load).unwrap().measured_at(LOAD).unwrap();
            for force in [
                under.steady(locked).unwrap().force,
                exact.step(locked, 1e3).unwrap(),
                grid.step(locked, 1e3).unwrap(),
            ] {
                assert_within(1e-12, want.abs(), force, want, || format!("{load} N, {v} m/s"));
            }
            // Its slip stiffness is that of the reference load.
            let stiffness = tyre.slip_stiffness(16.0).unwrap();
            let got = under.slip_stiffness(16.0).unwrap();
            assert_within(1e-14, stiffness, got, stiffness, || format!("C under {load} N"));
            let renewed = tyre.under_load(load).unwrap().slip_stiffness(16.0).unwrap();
            let in_proportion = stiffness * load / LOAD;
            assert_within(1e-12, in_proportion, renewed, in_proportion, || "C".into());
        }
    }
}

#[test]
fn a_constant_load_changes_no_bit() {
    let tyre = patch(friction(), forms()[1]);
    let plane = patch(plane(), forms()[1]);
    let (mut exact, mut plain) = (tyre.exact_in(50).unwrap(), tyre.exact_in(50).unwrap());
    let (mut grid, mut even) = (Grid::new(&tyre, 20).unwrap(), Grid::new(&tyre, 20).unwrap());
    let (mut two, mut both) = (plane.exact_in(50).unwrap(), plane.exact_in(50).unwrap());
    let mut draw = Draw(11);
    for number in 0..300 {
        let (v, w) = (draw.sign() * draw.logarithmic(1e-3, 5.0), draw.next());
        let motion =
            Motion { slip_velocity: v, rolling_speed: if number < 200 { 16.0 } else { 0.0 } };
        let turned = Motion { slip_velocity: Vector2::new(v, w), rolling_speed: 16.0 };
        for left in [
            exact.reload(LOAD, v),
            grid.reload(LOAD, |_| v),
            two.reload(LOAD, turned.slip_velocity),
            exact.renew(LOAD),
            grid.renew(LOAD),
            two.renew(LOAD),
        ] {
            assert_eq!(left.unwrap().dissipated, 0.0);
        }
        assert_eq!(exact.step(motion, 1e-3), plain.step(motion, 1e-3));
        assert_eq!(grid.step(motion, 1e-3), even.step(motion, 1e-3));
        assert_eq!(two.step(turned, 1e-3), both.step(turned, 1e-3));
    }
}

#[test]
fn an_isotropic_patch_that_slips_along_is_that_of_one_axis() {
    let line = patch(friction(), forms()[0]);
    let plane = patch(plane(), forms()[0]);
    let (mut one, mut two) = (line.exact_in(60).unwrap(), plane.exact_in(60).unwrap());
    let mut grid = CombinedGrid::new(&plane, 60).unwrap();
    let mut draw = Draw(5);
    for number in 0..200 {
        let load = if number % 40 == 7 { 0.0 } else { draw.logarithmic(1e2, 1e5) };
        let v = draw.sign() * draw.logarithmic(1e-2, 10.0);
        let along = Vector2::new(v, 0.0);
        let stored = one.stored_energy();
        let lost = one.reload(load, v).unwrap().dissipated;
        let lost_too = two.reload(load, along).unwrap().dissipated;
        assert_within(1e-3, stored, lost_too, lost, || format!("{number}"));
        // Trapezoids of z² around a kink in every cell.
        let lost_too = grid.reload(load, |_| along).unwrap().dissipated;
        assert_within(5e-2, stored, lost_too, lost, || format!("grid, {number}"));
        let h = LENGTH / 16.0 / 60.0;
        let want = one.step(Motion { slip_velocity: v, rolling_speed: 16.0 }, h).unwrap();
        let motion = Motion { slip_velocity: along, rolling_speed: 16.0 };
        let got = two.step(motion, h).unwrap();
        // One axis looks at the curve at v and at rest, two at its bound in between, see above.
        assert_within(1e-3, 1e-3 + load, (got - Vector2::new(want, 0.0)).norm(), 0.0, || {
            format!("{number}")
        });
        let field = Motion { slip_velocity: |_, _| along, rolling_speed: |_, _| 16.0 };
        let got = grid.step_field(&field, h).unwrap();
        assert_within(1e-3, 1e-3 + load, got.x, want, || format!("grid, {number}"));
    }
}

#[test]
fn a_load_that_is_none_is_named() {
    let (line, plane) = (patch(friction(), forms()[1]), patch(plane(), forms()[1]));
    let (mut exact, mut grid) = (line.exact_in(50).unwrap(), Grid::new(&line, 10).unwrap());
    let mut two = plane.exact_in(50).unwrap();
    let mut cells = CombinedGrid::new(&plane, 10).unwrap();
    for load in [-1.0, f64::NAN] {
        for refused in [
            exact.reload(load, 0.0),
            exact.renew(load),
            grid.reload(load, |_| 0.0),
            grid.renew(load),
            two.reload(load, Vector2::zeros()),
            two.renew(load),
            cells.reload(load, |_| Vector2::zeros()),
            cells.renew(load),
        ] {
            assert_eq!(refused.unwrap_err().name, "normal_force");
        }
    }
    assert_eq!((exact.patch().normal_force(), grid.normal_force()), (LOAD, LOAD));
    assert_eq!((two.patch().normal_force(), cells.normal_force()), (LOAD, LOAD));
}
