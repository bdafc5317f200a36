//! Combined slip: laws over random bristles and motions, the patch of one axis as a special case,
//! and the integral along the characteristics.

use crate::tyre::{by_rolling_speed, constant, coulomb, exponential, falling, levered, parabolic};
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::KelvinVoigt;
use bristle::{FrBd, Scalar};
use bristle_plane::{Axis, PlaneBristle, PlaneFrBd, PlaneLuGre};
use bristle_rolling::{
    CombinedGrid, LinearisedPatch, Motion, Patch, PatchParameters, PatchPassivity,
    PolynomialExponential, Segment,
};
use bristle_specimens::recipe::decades;
use bristle_specimens::specimens::kelvin_voigt;
use bristle_specimens::{assert_within, check, lit};
use nalgebra::{Vector1, Vector2, Vector3};
use proptest::prelude::*;

pub(super) const LENGTH: f64 = 0.12;
pub(super) const LOAD: f64 = 4000.0;

pub(super) type Model<T = f64, const A: usize = 2> = PlaneFrBd<Stribeck<T>, T, A>;
type Tyre<P, const A: usize = 2> = Patch<f64, Model<f64, A>, P>;
pub(super) type Slip = Motion<Vector2<f64>, f64>;

pub(super) fn curve<T: Scalar>([dynamic, rise, stribeck]: [f64; 3]) -> Stribeck<T> {
    Stribeck::new(StribeckParameters {
        static_coefficient: lit(dynamic * rise),
        dynamic_coefficient: lit(dynamic),
        stribeck_velocity: lit(stribeck),
        stribeck_exponent: lit(1.0),
        viscous_friction: lit(0.0),
    })
    .unwrap()
}

pub(super) fn bristle<T: Scalar>(micro_stiffness: f64, micro_damping: f64) -> KelvinVoigt<T> {
    kelvin_voigt(lit(micro_stiffness), lit(micro_damping))
}

/// Curve, and σ0 and σ1 for every axis with its friction ratio.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rubber {
    pub(super) curve: [f64; 3],
    pub(super) axes: [[f64; 3]; 2],
}

impl Rubber {
    pub(super) const TREAD: Self =
        Self { curve: [0.7, 1.5, 6.0], axes: [[1.0, 300.0, 0.3], [0.7, 200.0, 0.1]] };

    pub(super) fn model(&self) -> Model {
        let axis = |[friction_ratio, stiffness, damping]: [f64; 3]| Axis {
            friction_ratio,
            bristle: bristle(stiffness, damping),
        };
        PlaneFrBd::new(curve(self.curve), self.axes.map(axis)).unwrap()
    }

    /// With the bristle of the first axis on each.
    pub(super) fn isotropic<const A: usize>(&self) -> Model<f64, A> {
        PlaneFrBd::isotropic(*self.line().curve(), *self.line().rheology())
    }

    /// The model of one axis with the bristle of the first.
    pub(super) fn line(&self) -> FrBd<Stribeck<f64>, KelvinVoigt<f64>> {
        FrBd::new(curve(self.curve), bristle(self.axes[0][1], self.axes[0][2]))
    }
}

pub(super) fn rubber() -> impl Strategy<Value = Rubber> {
    let damping = || prop_oneof![1 => Just(0.0), 3 => decades(1e-2, 10.0)];
    let axis = || (decades(0.2, 5.0), decades(20.0, 5e3), damping());
    let curve = (decades(0.1, 2.0), 1.0..2.0, decades(0.1, 20.0));
    (curve, axis(), axis()).prop_map(|(curve, x, y)| Rubber {
        curve: [curve.0, curve.1, curve.2],
        axes: [[x.0, x.1, x.2], [y.0, y.1, y.2]],
    })
}

pub(super) fn slip() -> impl Strategy<Value = Vector2<f64>> {
    (decades(1e-6, 50.0), 0.0..std::f64::consts::TAU)
        .prop_map(|(speed, angle)| Vector2::new(speed * angle.cos(), speed * angle.sin()))
}

pub(super) fn patch<T: Scalar, M, const N: usize>(
    model: M,
    pressure: PolynomialExponential<T, N>,
) -> Patch<T, M, PolynomialExponential<T, N>> {
    let patch = Patch::new(PatchParameters { model, length: lit(LENGTH), pressure });
    patch.unwrap().under_load(lit(LOAD)).unwrap()
}

fn steady<P: bristle_rolling::Pressure<f64>>(tyre: &Tyre<P>, motion: Slip) -> Vector2<f64> {
    Vector2::from(tyre.combined_steady(motion).unwrap().map(|axis| axis.force))
}

/// One step: predicted and found slip velocity, V, h.
#[derive(Debug, Clone, Copy)]
struct Step {
    predicted: Vector2<f64>,
    mean: Vector2<f64>,
    transport: f64,
    duration: f64,
}

impl Step {
    fn motion(&self) -> Slip {
        Motion { slip_velocity: self.predicted, rolling_speed: LENGTH * self.transport }
    }
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let transport = prop_oneof![1 => Just(0.0), 5 => decades(0.1, 400.0)];
    let found = prop_oneof![3 => slip(), 1 => Just(Vector2::zeros())];
    let step = (slip(), found, transport, decades(1e-5, 3e-2)).prop_map(
        |(predicted, mean, transport, duration)| Step { predicted, mean, transport, duration },
    );
    prop::collection::vec(step, 1..40)
}

#[test]
fn the_steady_force_of_isotropic_bristles_opposes_the_slip_as_that_of_one_axis_does() {
    check(300, (rubber(), slip(), 0.0..60.0), |(rubber, v, rolling_speed)| {
        let motion = Motion { slip_velocity: v, rolling_speed };
        let plane = steady(&patch(rubber.isotropic::<2>(), falling()), motion);
        let along = Motion { slip_velocity: v.norm(), rolling_speed };
        let want = patch(rubber.line(), falling()).steady(along).unwrap().force;
        // Roundings of ‖v‖ and of κ, which the stiffest bristles have at 5e4.
        assert_within(1e-13, want, plane.norm(), want, || "size".into());
        assert_within(1e-14, want, plane.perp(&v) / v.norm(), 0.0, || "direction".into());
        assert!(plane.dot(&v) > 0.0);
    });
}

#[test]
fn the_steady_force_stays_inside_the_friction_ellipse() {
    check(300, (rubber(), slip(), 0.0..60.0), |(rubber, v, rolling_speed)| {
        let motion = Motion { slip_velocity: v, rolling_speed };
        let force = steady(&patch(rubber.model(), falling()), motion);
        let [dynamic, rise, stribeck] = rubber.curve;
        let mu = dynamic * (1.0 + (rise - 1.0) * (-v.norm() / stribeck).exp());
        let [x, y] = [0, 1].map(|i| force[i] / (LOAD * mu * rubber.axes[i][0]));
        // A few roundings.
        assert!(x.hypot(y) <= 1.0 + 1e-14, "{x} {y}");
        // It is reached by a patch that slides without rolling.
        let locked = Motion { rolling_speed: 0.0, ..motion };
        let force = steady(&patch(rubber.model(), falling()), locked);
        let [x, y] = [0, 1].map(|i| force[i] / (LOAD * mu * rubber.axes[i][0]));
        assert_within(1e-14, 1.0, x.hypot(y), 1.0, || "locked".into());
    });
}

#[test]
fn the_moment_is_the_force_at_the_pneumatic_trail() {
    check(200, (rubber(), slip(), 1.0..60.0), |(rubber, v, rolling_speed)| {
        let tyre = patch(rubber.model(), falling());
        let motion = Motion { slip_velocity: v, rolling_speed };
        let mut rolling = tyre.exact_in(40).unwrap();
        rolling.settle(motion).unwrap();
        let padded = patch(rubber.model(), falling().padded::<4>());
        let mut direct = padded.exact_in(40).unwrap();
        direct.settle(motion).unwrap();
        let (force, moment) = (rolling.force(v), rolling.moment(v));
        let next = direct.moment(v);
        for i in 0..2 {
            let axis = Motion { slip_velocity: v[i], rolling_speed };
            let trail = tyre.axes(&v)[i].pneumatic_trail(axis).unwrap().unwrap();
            // The integrals about the inlet are larger than that about the middle; κ up to 1e5.
            let scale = force[i].abs() * LENGTH;
            assert_within(1e-12, scale, moment[i], trail * force[i], || format!("{i}"));
            assert_within(1e-12, scale, next[i], moment[i], || format!("next {i}"));
        }
    });
}

#[test]
fn little_none_and_very_much_slip_have_their_limits() {
    let rubber = Rubber { curve: [0.7, 1.5, 6.0], axes: [[1.0, 300.0, 0.3], [0.5, 200.0, 0.0]] };
    let tyre = patch(rubber.model(), constant().padded::<2>());
    let at = |slip_velocity| steady(&tyre, Motion { slip_velocity, rolling_speed: 16.0 });
    assert_eq!(at(Vector2::zeros()), Vector2::zeros());
    // In adhesion F = F_z (σ0 L/(2U) + σ1) v on each axis.
    for size in [5e-324, 1e-310, 1e-200, 1e-30, 1e-12] {
        let force = at(Vector2::new(size, -size));
        let stiffness = [300.0, 200.0].map(|sigma| LOAD * sigma * LENGTH / 32.0);
        let want = Vector2::new(stiffness[0] + LOAD * 0.3, -stiffness[1]) * size;
        // Curve and κ deviate by some 1e-11 of 1e-12 m/s; subnormal numbers by their last digit.
        let close = (force - want).abs().max() <= 1e-9 * want.abs().max() + 4e3 * 5e-324;
        assert!(close, "{size:e}: {force} {want}");
    }
    // In full sliding M² v/‖Mv‖.
    for size in [1e10, 1e50, 1e100] {
        let force = at(Vector2::new(size, -size));
        let want = Vector2::new(1.0, -0.25) * (LOAD * 0.7 / 1.25_f64.sqrt());
        assert_within(1e-9, LOAD, (force - want).norm(), 0.0, || format!("{size:e}"));
    }
    // A step takes them all, and a patch that stood still stays undeflected.
    let mut rolling = tyre.exact([[Segment::default(); 30]; 2]).unwrap();
    for (size, speed) in [(0.0, 0.0), (0.0, 16.0), (5e-324, 16.0), (1e-310, 0.0), (1e100, 16.0)] {
        let motion = Motion { slip_velocity: Vector2::new(size, -size), rolling_speed: speed };
        let force = rolling.step(motion, 1e-3).unwrap();
        assert!(force.iter().all(|f| f.is_finite()), "{size:e} {force}");
        if size == 0.0 {
            assert_eq!(force, Vector2::zeros());
        }
        let step = rolling.companion_step(motion, 1e-3).unwrap();
        assert!(step.damping().iter().all(|&c| c >= 0.0 && c.is_finite()), "{size:e}");
        step.commit(motion.slip_velocity).unwrap();
    }
}

#[test]
fn one_axis_has_the_bits_of_the_scalar_patch() {
    check(50, (rubber(), steps()), |(rubber, run)| {
        let mut plane = patch(rubber.isotropic::<1>(), falling()).exact_in(40).unwrap();
        let mut line = patch(rubber.line(), falling()).exact_in(40).unwrap();
        for step in run {
            let (slip_velocity, rolling_speed) = (step.predicted.x, LENGTH * step.transport);
            let along = Motion { slip_velocity, rolling_speed };
            let motion = Motion { slip_velocity: Vector1::new(slip_velocity), rolling_speed };
            let want = line.step(along, step.duration).unwrap();
            assert_eq!(plane.step(motion, step.duration).unwrap().x, want);
        }
    });
}

#[test]
fn a_motion_that_stays_leads_to_steady_rolling() {
    check(100, (rubber(), steps(), slip(), 1.0..60.0), |(rubber, run, v, rolling_speed)| {
        let tyre = patch(rubber.model(), falling().padded::<4>());
        let mut rolling = tyre.exact_in(40).unwrap();
        for step in run {
            rolling.step(step.motion(), step.duration).unwrap();
        }
        let motion = Motion { slip_velocity: v, rolling_speed };
        let mut force = Vector2::zeros();
        for _ in 0..26 {
            // A crossing takes 25 of them.
            force = rolling.step(motion, 0.04 * LENGTH / rolling_speed).unwrap();
        }
        let want = steady(&tyre, motion);
        // Bristles of a stiffness up to 5e3 1/m with κ up to 1e5.
        assert_within(1e-12, want.norm(), (force - want).norm(), 0.0, || format!("{want}"));
        let mut settled = tyre.exact_in(40).unwrap();
        settled.settle(motion).unwrap();
        let (got, want) = (rolling.moment(v), settled.moment(v));
        let scale = LENGTH * force.norm();
        assert_within(1e-12, scale, (got - want).norm(), 0.0, || format!("{want}"));
    });
}

#[test]
fn no_transient_of_isotropic_bristles_exceeds_the_largest_friction() {
    check(200, (rubber(), steps()), |(rubber, run)| {
        let mut rolling = patch(rubber.isotropic::<2>(), falling()).exact_in(40).unwrap();
        let most = LOAD * rubber.curve[0] * rubber.curve[1];
        for step in run {
            let force = rolling.step(step.motion(), step.duration).unwrap();
            // Forty roundings.
            assert!(force.norm() <= most * (1.0 + 1e-13), "{force} of {most}");
        }
    });
}

/// Slip that turns: the sum of two sines.
pub(super) fn manoeuvre(time: f64) -> Slip {
    let slip_velocity = Vector2::new(0.8 + 0.6 * (40.0 * time).sin(), 0.5 * (23.0 * time).cos());
    Motion { slip_velocity, rolling_speed: 16.0 }
}

#[test]
fn the_integral_along_the_characteristics_is_met() {
    fn at_end<const N: usize>(pressure: PolynomialExponential<f64, N>, steps: u32) -> Vector3<f64> {
        let model = Model::isotropic(curve([0.7, 1.1 / 0.7, 6.0]), bristle(300.0, 0.0));
        let tyre = patch(model, pressure).under_load(1.0).unwrap();
        let mut rolling = tyre.exact_in(2000).unwrap();
        rolling.settle(manoeuvre(0.0)).unwrap();
        let h = 0.05 / f64::from(steps);
        for number in 0..steps {
            rolling.step(manoeuvre(h * (f64::from(number) + 0.5)), h).unwrap();
        }
        let v = manoeuvre(0.05).slip_velocity;
        let force = rolling.force(v);
        Vector3::new(force.x, force.y, rolling.moment(v).y)
    }
    /// Of second order with clean coefficients: the error of the finer run is a third of what it
    /// differs by.
    fn extrapolated<const N: usize>(pressure: PolynomialExponential<f64, N>) -> Vector3<f64> {
        let (coarse, fine) = (at_end(pressure, 4000), at_end(pressure, 8000));
        assert!((fine - coarse).norm() < 1e-7);
        fine + (fine - coarse) / 3.0
    }
    // Runge–Kutta of fourth order along 30 characteristics at Gauss points, with another program; a
    // halved step changes 1e-12.
    let constant = extrapolated(constant().padded::<2>());
    let want = Vector3::new(0.690_899_003_564, 0.111_780_823_013, 0.001_421_795_899);
    assert!((constant - want).abs().max() < 1e-11, "{constant:.12}");
    let parabolic = extrapolated(parabolic());
    let want = Vector3::new(0.730_872_906_621, 0.117_987_569_680, 0.000_811_783_431);
    assert!((parabolic - want).abs().max() < 1e-11, "{parabolic:.12}");
}

#[test]
fn single_precision_gives_the_same_to_its_roundings() {
    fn run<T: Scalar>() -> [Vector2<f64>; 2] {
        let model = PlaneFrBd::isotropic(curve::<T>([0.7, 1.5, 6.0]), bristle(300.0, 0.5));
        let tyre = patch(model, parabolic());
        let mut rolling = tyre.exact([[Segment::default(); 64]; 2]).unwrap();
        let mut grid = CombinedGrid::new(&tyre, 30).unwrap();
        let mut forces = [Vector2::zeros(); 2];
        for number in 0..100 {
            let motion = manoeuvre(5e-4 * f64::from(number));
            let slip_velocity = motion.slip_velocity.map(lit::<T>);
            let motion = Motion { slip_velocity, rolling_speed: lit(16.0) };
            let spinning = |place: T, time: T| slip_velocity + Vector2::new(time, -place);
            let field = Motion { slip_velocity: spinning, rolling_speed: |_, _| lit::<T>(16.0) };
            forces = [rolling.step(motion, lit(5e-4)), grid.step_field(&field, lit(5e-4))]
                .map(Result::unwrap);
        }
        forces.map(|force| force.map(|f| f.to_subset_unchecked()))
    }
    // Some ten roundings a step over a crossing of 15 steps.
    for (single, double) in run::<f32>().into_iter().zip(run::<f64>()) {
        assert!((single - double).norm() < 1e-5 * double.norm(), "{single} {double}");
    }
}

fn dissipates<const N: usize>(
    rubber: &Rubber,
    pressure: PolynomialExponential<f64, N>,
    run: &[Step],
    tolerance: f64,
) {
    let tyre = patch(rubber.model(), pressure);
    assert!(
        tyre.axes(&Vector2::zeros()).iter().all(|axis| axis.passivity() == PatchPassivity::Passive)
    );
    let mut rolling = tyre.exact_in(100).unwrap();
    for (number, step) in run.iter().enumerate() {
        if number % 5 == 4 {
            let (stored, load) = (rolling.stored_energy(), LOAD * (0.2 + step.duration * 100.0));
            let reloaded =
                if number % 2 == 0 { rolling.reload(load, step.mean) } else { rolling.renew(load) };
            let left = stored - reloaded.unwrap().dissipated;
            assert_within(1e-12, stored, rolling.stored_energy(), left, || "load".into());
        }
        let before = rolling.stored_energy();
        let companion = rolling.companion_step(step.motion(), step.duration).unwrap();
        let (bias, damping) = (companion.bias(), companion.damping());
        let force = companion.force(step.mean);
        let done = companion.commit_with_ledger(step.mean).unwrap();
        for (i, axis) in done.iter().enumerate() {
            let v = step.mean[i];
            let scale = (bias[i].abs() + damping[i] * v.abs()) * v.abs() * step.duration
                + before
                + axis.stored.abs()
                + axis.outlet;
            assert!(damping[i] >= 0.0);
            assert!(axis.volume >= -tolerance * scale, "{axis:?} of {scale:e} at {step:?}");
            assert!(axis.outlet >= 0.0);
            assert_eq!(axis.force, force[i]);
        }
        let work: f64 = done.iter().map(|axis| axis.work).sum();
        let want = step.duration * force.dot(&step.mean);
        assert_within(1e-12, force.norm() * step.mean.norm() * step.duration, work, want, || {
            format!("{step:?}")
        });
    }
}

#[test]
fn no_step_gives_more_than_was_stored_under_pressures_that_do_not_rise() {
    check(80, (rubber(), steps()), |(rubber, run)| {
        // Merging narrow steps takes energy away under these pressures; all terms are right to
        // some roundings of the largest.
        dissipates(&rubber, constant(), &run, 1e-12);
        dissipates(&rubber, exponential(0.7), &run, 1e-12);
    });
}

#[test]
fn slow_responses_are_the_slopes_of_the_steady_force_and_moment() {
    check(100, (rubber(), slip(), 1.0..60.0), |(rubber, v, rolling_speed)| {
        let tyre = patch(rubber.model(), falling());
        let motion = Motion { slip_velocity: v, rolling_speed };
        // F_x, F_y and F_y times the trail over the length.
        let answer = |motion: Slip| {
            let v = motion.slip_velocity;
            let along = Motion { slip_velocity: v.y, rolling_speed: motion.rolling_speed };
            let trail = tyre.axes(&v)[1].pneumatic_trail(along).unwrap().unwrap();
            let force = steady(&tyre, motion);
            Vector3::new(force.x, force.y, force.y * trail / LENGTH)
        };
        // Slopes over a relative change of the motion, of fourth order.
        let slope = |changed: &dyn Fn(f64) -> Slip| {
            let at = |part: f64| answer(changed(1e-4 * part));
            (8.0 * (at(1.0) - at(-1.0)) - at(2.0) + at(-2.0)) / 12e-4
        };
        let rows = tyre.combined_linearised(motion).unwrap();
        let lever = levered(&tyre);
        let levered = lever.combined_linearised(motion).unwrap();
        let scale = steady(&tyre, motion).norm();
        for (j, row) in rows.iter().enumerate() {
            let mut side = Vector2::zeros();
            side[j] = v.norm();
            let want = slope(&|part| Motion { slip_velocity: v + part * side, ..motion });
            let [x, y] = [0, 1].map(|i| row[i].by_slip_velocity(0.0));
            let moment = levered[j][1].by_slip_velocity(0.0) - 0.5 * y;
            assert_eq!((x.im, y.im), (0.0, 0.0));
            let got = Vector3::new(x.re, y.re, moment.re) * v.norm();
            assert_within(1e-9, scale, (got - want).abs().max(), 0.0, || format!("v {j}"));
        }
        let want = slope(&|part| Motion { rolling_speed: rolling_speed * (1.0 + part), ..motion });
        let along = |i: usize| Motion { slip_velocity: v[i], rolling_speed };
        let (axes, levers) = (tyre.axes(&v), lever.axes(&v));
        let [x, y] = [0, 1].map(|i| by_rolling_speed(&axes[i], along(i), 0.0).re);
        let moment = by_rolling_speed(&levers[1], along(1), 0.0).re - 0.5 * y;
        let got = Vector3::new(x, y, moment) * rolling_speed;
        assert_within(1e-9, scale, (got - want).abs().max(), 0.0, || "U".into());
    });
}

#[test]
fn a_small_wave_of_one_axis_moves_forces_and_moments_as_the_linearisation_says() {
    let rubber = Rubber::TREAD;
    let tyre = patch(rubber.model(), falling().padded::<4>());
    let motion = Motion { slip_velocity: Vector2::new(0.7, 0.5), rolling_speed: 16.0 };
    let rows = tyre.combined_linearised(motion).unwrap();
    let levered = levered(&tyre).combined_linearised(motion).unwrap();
    // Two and a half periods in a crossing.
    let frequency = 5.0 * std::f64::consts::PI * 16.0 / LENGTH;
    let (periods, steps) = (4, 1000);
    let h = std::f64::consts::TAU / frequency / f64::from(steps);
    for (j, row) in rows.iter().enumerate() {
        let wave = |time: f64, size: f64| {
            let mut slip_velocity = motion.slip_velocity;
            slip_velocity[j] += size * (frequency * time).sin();
            Motion { slip_velocity, ..motion }
        };
        let answer = |size: f64| {
            let mut rolling = tyre.exact_in(500).unwrap();
            rolling.settle(motion).unwrap();
            let mut sums = [[0.0; 2]; 4];
            for number in 0..periods * steps {
                let time = h * f64::from(number);
                rolling.step(wave(time + 0.5 * h, size), h).unwrap();
                // The last period, with the force at the end of the step.
                if number >= (periods - 1) * steps {
                    let end = time + h;
                    let v = wave(end, size).slip_velocity;
                    let (force, moment) = (rolling.force(v), rolling.moment(v));
                    let (sin, cos) = (frequency * end).sin_cos();
                    for (sum, value) in sums.iter_mut().zip(force.iter().chain(&moment)) {
                        sum[0] += value * sin * 2.0 / f64::from(steps);
                        sum[1] += value * cos * 2.0 / f64::from(steps);
                    }
                }
            }
            sums
        };
        let (up, down) = (answer(1e-3), answer(-1e-3));
        let forces = row.iter().map(|axis| axis.by_slip_velocity(frequency));
        let moments = row.iter().zip(&levered[j]).map(|(axis, levered)| {
            let [force, lever] =
                [axis.by_slip_velocity(frequency), levered.by_slip_velocity(frequency)];
            LENGTH * (lever - 0.5 * force)
        });
        for (i, want) in forces.chain(moments).enumerate() {
            let [re, im] = [0, 1].map(|part| (up[i][part] - down[i][part]) / 2e-3);
            // Of second order in the wave, 1e-6, and in 2π/1000 rad, 3e-6.
            let lever = if i < 2 { 1.0 } else { LENGTH };
            let scale = lever * row[j].by_slip_velocity(frequency).norm();
            assert_within(2e-5, scale, re, want.re, || format!("{j} {i} re"));
            assert_within(2e-5, scale, im, want.im, || format!("{j} {i} im"));
        }
    }
}

#[test]
fn about_rest_no_axis_feels_another() {
    let rubber = Rubber::TREAD;
    let tyre = patch(rubber.model(), falling());
    let free = Motion { slip_velocity: Vector2::zeros(), rolling_speed: 16.0 };
    let rows = tyre.combined_linearised(free).unwrap();
    let response = |axis: &LinearisedPatch<_, _>| axis.by_slip_velocity(0.0).re;
    assert_eq!((response(&rows[0][1]), response(&rows[1][0])), (0.0, 0.0));
    for (i, (row, axis)) in rows.iter().zip(rubber.axes).enumerate() {
        let [_, stiffness, damping] = axis;
        let model = FrBd::new(curve(rubber.curve), bristle(stiffness, damping));
        let want = patch(model, falling()).slip_stiffness(16.0).unwrap() / 16.0;
        assert_within(1e-14, want, response(&row[i]), want, || format!("{i}"));
    }
}

#[test]
fn lugre_rolls_too() {
    let axis = Axis { friction_ratio: 1.0, bristle: bristle(300.0, 0.0) };
    let curve = *coulomb(0.8, 0.0).curve();
    let lugre = patch(PlaneLuGre::classical(curve, [axis; 2]).unwrap(), falling());
    let frbd = patch(PlaneFrBd::new(curve, [axis; 2]).unwrap(), falling());
    // Without damping the two are one model.
    let motion = Motion { slip_velocity: Vector2::new(0.4, -0.3), rolling_speed: 10.0 };
    let want = Vector2::from(frbd.combined_steady(motion).unwrap().map(|axis| axis.force));
    let mut rolling = lugre.exact_in(40).unwrap();
    let mut force = Vector2::zeros();
    for _ in 0..30 {
        force = rolling.step(motion, 0.04 * LENGTH / 10.0).unwrap();
    }
    assert_within(1e-13, LOAD, (force - want).norm(), 0.0, || "LuGre".into());
    let field = Motion { slip_velocity: |_, _| motion.slip_velocity, rolling_speed: |_, _| 10.0 };
    let h = 1.5 * LENGTH / 10.0;
    let one = CombinedGrid::new(&lugre, 30).unwrap().step_field(&field, h).unwrap();
    let two = CombinedGrid::new(&frbd, 30).unwrap().step_field(&field, h).unwrap();
    assert_within(1e-13, LOAD, (one - two).norm(), 0.0, || "LuGre on a grid".into());
}

#[test]
fn an_axis_that_cannot_follow_is_named_and_changes_nothing() {
    // Behind one that can: λ = 1e12 · 1e100/1e-198 is no number.
    let frail = Rubber { axes: [[1.0, 300.0, 0.3], [1e-99, 1e12, 0.0]], ..Rubber::TREAD };
    let mut rolling = patch(frail.model(), falling()).exact_in(40).unwrap();
    let slip = |x, y| Motion { slip_velocity: Vector2::new(x, y), rolling_speed: 16.0 };
    let force = rolling.step(slip(0.7, 0.5), 1e-3).unwrap();
    for error in [
        rolling.step(slip(1e100, 0.1), 1e-3).unwrap_err(),
        rolling.settle(slip(1e100, 0.1)).unwrap_err(),
    ] {
        assert_eq!(error.name, "relaxation rate of the friction model");
    }
    assert_eq!(rolling.force(Vector2::new(0.7, 0.5)), force);
}

#[test]
fn three_axes_of_which_the_last_spins_nothing_are_as_good_as_two() {
    let axis = |[friction_ratio, stiffness, damping]: [f64; 3]| Axis {
        friction_ratio,
        bristle: bristle(stiffness, damping),
    };
    let [x, y] = Rubber::TREAD.axes.map(axis);
    let model = PlaneFrBd::new(curve(Rubber::TREAD.curve), [x, y, y]).unwrap();
    assert!(model.limits(1.0).deflection.is_some());
    let (three, two) = (patch(model, falling()), patch(Rubber::TREAD.model(), falling()));
    let motion = Motion { slip_velocity: Vector2::new(0.7, 0.5), rolling_speed: 16.0 };
    let deep = Motion { slip_velocity: motion.slip_velocity.push(0.0), rolling_speed: 16.0 };
    let want = two.exact_in(40).unwrap().step(motion, 1e-3).unwrap();
    assert_eq!(three.exact_in(40).unwrap().step(deep, 1e-3).unwrap(), want.push(0.0));
    let field = Motion { slip_velocity: |_, _| motion.slip_velocity, rolling_speed: |_, _| 16.0 };
    let want = CombinedGrid::new(&two, 30).unwrap().step_field(&field, 1e-2).unwrap();
    let field = Motion { slip_velocity: |_, _| deep.slip_velocity, rolling_speed: |_, _| 16.0 };
    let got = CombinedGrid::new(&three, 30).unwrap().step_field(&field, 1e-2).unwrap();
    assert_eq!(got, want.push(0.0));
}

#[test]
fn a_patch_in_combined_slip_allocates_nothing() {
    let counted = allocation_counter::measure(|| {
        let tyre = patch(Rubber::TREAD.model(), parabolic().padded::<4>());
        let mut rolling = tyre.exact([[Segment::default(); 40]; 2]).unwrap();
        for number in 0..200 {
            let slip_velocity = Vector2::new(0.5, 0.01 * f64::from(number));
            let motion = Motion { slip_velocity, rolling_speed: 16.0 };
            let load = 4000.0 - 10.0 * f64::from(number);
            let _ = rolling.reload(load, slip_velocity).unwrap();
            let _ = rolling.renew(load + 5.0).unwrap();
            rolling.step(motion, 1e-3).unwrap();
            let step = rolling.companion_step(motion, 1e-4).unwrap();
            step.commit_with_ledger(slip_velocity).unwrap();
            assert!(rolling.moment(slip_velocity).y.is_finite());
        }
    });
    let mut grid = CombinedGrid::new(&patch(Rubber::TREAD.model(), falling()), 30).unwrap();
    let slip_velocity = |place: f64, _| Vector2::new(0.4, 20.0 * place);
    let field = Motion { slip_velocity, rolling_speed: |_, _| 16.0 };
    let of_grid = allocation_counter::measure(|| {
        grid.step_field(&field, 1e-3).unwrap();
        grid.moment(|place| slip_velocity(place, 0.0));
    });
    assert_eq!((counted.count_total, of_grid.count_total), (0, 0));
}
