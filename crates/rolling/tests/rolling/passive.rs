//! The coupling of a rolling patch to a mechanism: step-mean force and energy balance.

use crate::characteristics::{History, Step as Held};
use crate::tyre::{
    LENGTH, LOAD, Model, constant, exponential, falling, frbd, frbd_of, loaded, lugre, motion,
    parabolic, patch,
};
use bristle::curve::{Stribeck, StribeckParameters};
use bristle::{Bristle, LuGre, Scalar, paper};
use bristle_rolling::{Motion, PolynomialExponential, Pressure};
use bristle_specimens::recipe::decades;
use bristle_specimens::{assert_within, check, integral, lit};
use proptest::collection::vec;
use proptest::prelude::*;

/// One step: predicted and found slip velocity, V, h.
#[derive(Debug, Clone, Copy)]
struct Step {
    predicted: f64,
    mean: f64,
    transport: f64,
    duration: f64,
}

impl Step {
    fn motion(&self) -> Motion<f64> {
        motion(self.predicted, self.transport)
    }
}

fn signed(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (decades(from, to), any::<bool>()).prop_map(|(v, backward)| if backward { -v } else { v })
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let step = (
        signed(1e-6, 30.0),
        prop_oneof![signed(1e-6, 30.0), Just(0.0)],
        prop_oneof![1 => Just(0.0), 5 => decades(0.1, 400.0)],
        decades(1e-5, 3e-2),
    );
    let step = step.prop_map(|(predicted, mean, transport, duration)| Step {
        predicted,
        mean,
        transport,
        duration,
    });
    vec(step, 1..40)
}

#[test]
fn a_patch_that_does_not_roll_is_a_companion_at_every_speed_and_its_damping_positive() {
    // LuGre's c₀ = σ0 − σ1 λ falls with the speed: summed up term by term it would leave a
    // rounding.
    let contact = lugre(0.5).under_load(LOAD).unwrap().companion(1.0).unwrap();
    let mut rolling = loaded(lugre(0.5), parabolic()).exact_in(50).unwrap();
    for slip_velocity in [0.0, 1e-3, -1.0, 1e3, 1e6, -1e9] {
        for duration in [1e-6, 1e-3, 1.0] {
            let want = contact.step(slip_velocity, 0.0, duration).damping();
            // Crawling, the part that is new is a millionth of a millionth. Standing, a few
            // roundings of sums of positive terms.
            for (way, tolerance) in [(0.0, 1e-14), (1e-13, 1e-11)] {
                let motion = Motion { slip_velocity, rolling_speed: way * LENGTH / duration };
                let got = rolling.companion_step(motion, duration).unwrap().damping();
                assert_within(tolerance, want, got, want, || format!("{motion:?} {duration}"));
            }
        }
    }
    // Rolling without σ2 it is F_z (σ1 + (σ0 − σ1 λ) ū) with ū ≈ 1/λ: σ1 − σ1 and a rounding.
    let curve = StribeckParameters { viscous_friction: 0.0, ..paper::TYRE_CURVE };
    for micro_damping in [0.1, 0.3, 7.0] {
        let bristle = *frbd(micro_damping).rheology();
        let model = LuGre::classical(Stribeck::new(curve).unwrap(), bristle);
        let mut rolling = loaded(model, parabolic()).exact_in(100).unwrap();
        for number in 0..400 {
            // 1e6 to 1e18 m/s.
            let v = 10.0_f64.powf(6.0 + 0.03 * f64::from(number));
            for duration in [1e-5, 1e-3, 0.1] {
                let damping = rolling.companion_step(motion(v, 100.0), duration).unwrap().damping();
                assert!(damping > 0.0, "{damping:e} at {v:e}, {duration}");
            }
        }
    }
}

#[test]
fn a_patch_whose_pressure_does_not_rise_never_gives_more_than_it_stored() {
    fn holds<const N: usize>(
        pressure: PolynomialExponential<f64, N>,
        (run, loads): (&[Step], Option<&[f64]>),
        (damping, renews): (f64, bool),
        tolerance: f64,
    ) {
        let mut rolling = loaded(frbd(damping), pressure).exact_in(100).unwrap();
        for (number, step) in run.iter().enumerate() {
            let (stored, somewhere) = (rolling.stored_energy(), rolling.deflection(0.3));
            let was = rolling.patch().normal_force();
            let load = loads.map_or(was, |loads| loads[number]);
            let left = if renews {
                let kept = if was == 0.0 || load == 0.0 { 0.0 } else { (was / load).min(1.0) };
                let left = rolling.renew(load).unwrap();
                let now = rolling.deflection(0.3);
                assert_within(1e-14, somewhere.abs(), now, kept * somewhere, || "z".into());
                left
            } else {
                let left = rolling.reload(load, step.predicted).unwrap();
                if load >= was {
                    assert_eq!((left.dissipated, rolling.deflection(0.3)), (0.0, somewhere));
                }
                left
            };
            let kept = stored - left.dissipated;
            assert!(left.dissipated >= 0.0 && left.dissipated <= stored * (1.0 + 1e-12));
            let now = rolling.stored_energy();
            assert_within(1e-12, stored, now, kept, || format!("{was} N to {load} N"));
            let companion = rolling.companion_step(step.motion(), step.duration).unwrap();
            assert!(companion.damping() >= 0.0);
            let terms = companion.bias().abs() + companion.damping() * step.mean.abs();
            let [done] = companion.commit_with_ledger(step.mean).unwrap();
            let scale = terms * step.mean.abs() * step.duration
                + stored
                + rolling.stored_energy()
                + done.stored.abs()
                + done.outlet;
            assert!(done.volume >= -tolerance * scale, "{done:?} of {scale:e}, {load}, {step:?}");
            assert!(done.outlet >= 0.0);
            let gained = rolling.stored_energy() - kept;
            assert!(done.work - gained >= -tolerance * scale, "{done:?}, {load}, {step:?}");
        }
    }
    let load = prop_oneof![1 => Just(0.0), 5 => decades(1.0, 1e5)];
    let damping = prop_oneof![Just(0.0), 0.0..50.0];
    let runs = (steps(), vec(load, 40), damping, any::<bool>());
    check(100, runs, |(run, loads, damping, renews)| {
        let (varies, rule) = ((&run[..], Some(&loads[..])), (damping, renews));
        // Every term is right to some roundings of the largest. Merging narrow steps takes energy
        // away under these two pressures, …
        holds(constant(), varies, rule, 1e-12);
        holds(exponential(0.7), varies, rule, 1e-12);
        // … and may add some under others, whose weight is another one at every place.
        holds(falling(), (&run, None), rule, MERGED);
    });
}

/// What merging in some hundred slots may cost, of the largest energy: it was 1e-9 in trials.
const MERGED: f64 = 1e-8;

/// Where the profile has kinks, with both ends.
fn kinks(history: &History<'_>, more: &[f64]) -> Vec<f64> {
    let mut places = vec![0.0, 1.0];
    places.extend(more);
    let mut way = 0.0;
    for step in history.steps.iter().rev() {
        way += step.way();
        places.push(way);
    }
    places.retain(|place| (0.0..=1.0).contains(place));
    places.sort_by(f64::total_cmp);
    places
}

/// λ times the longest that a bristle of one step has been inside during it, of all steps.
fn steepest(history: &History<'_>) -> f64 {
    let inside = |step: &Held| step.duration.min(1.0 / step.transport);
    history.steps.iter().map(|step| step.relaxation * inside(step)).fold(0.0, f64::max)
}

/// ∫₀¹ f(ξ, z(ξ)) dξ
fn over_patch(history: &History<'_>, f: impl Fn(f64, f64) -> f64) -> f64 {
    let panels = 4 + (2.0 * steepest(history)) as usize;
    let part =
        |pair: &[f64]| integral(pair[0], pair[1], panels, |xi| f(xi, history.deflection(xi)));
    kinks(history, &[]).windows(2).map(part).sum()
}

/// ∫∫ f(ξ, z) dξ dt over a step, along the paths of the bristles: of those that are there at the
/// beginning, and of those that enter.
fn over_step(history: &History<'_>, step: &Held, f: impl Fn(f64, f64) -> f64) -> f64 {
    let Held { transport, duration, .. } = *step;
    let panels = |time: f64| 4 + (step.relaxation * time) as usize;
    let path = |from: f64, z: f64, time: f64| {
        integral(0.0, time, panels(time), |t| f(from + transport * t, step.relax(z, t)))
    };
    let last = 1.0 - transport * duration;
    let old = kinks(history, &[last]).windows(2).fold(0.0, |sum, pair| {
        let panels = panels(duration) + steepest(history) as usize;
        sum + integral(pair[0], pair[1], panels, |s| {
            let inside = if transport > 0.0 { (1.0 - s) / transport } else { duration };
            path(s, history.deflection(s), inside.min(duration))
        })
    });
    if transport == 0.0 {
        return old;
    }
    let crossing = 1.0 / transport;
    let late = (duration - crossing).max(0.0);
    let new = |from: f64, to: f64| {
        integral(from, to, panels(to - from), |entry| {
            transport * path(0.0, 0.0, (duration - entry).min(crossing))
        })
    };
    old + new(0.0, late) + new(late, duration)
}

/// Runs some steps and compares every entry of their ledgers with quadrature.
fn ledger_is_that_of_quadrature<M: Model, const N: usize>(
    model: M,
    pressure: PolynomialExponential<f64, N>,
    run: &[Step],
) {
    let mut rolling = loaded(model, pressure).exact_in(4000).unwrap();
    let scale = LOAD / pressure.total();
    let stiffness = model.storage_stiffness();
    let mut history = History::new(&|_| 0.0, &[]);
    for step in run {
        let Step { predicted, mean, transport, duration } = *step;
        let a = model.affine(predicted.into(), 0.0);
        let held = Held { relaxation: a.relaxation, drive: a.drive * mean, transport, duration };
        let companion = rolling.companion_step(step.motion(), duration).unwrap();
        let [done] = companion.commit_with_ledger(mean).unwrap();

        let over = |f: &dyn Fn(f64, f64) -> f64| scale * over_step(&history, &held, f);
        let p = |xi: f64| pressure.at(xi);
        let force = over(&|xi, z| p(xi) * (a.stiffness * z + a.damping * mean)) / duration;
        // What is lost in the bristles, to the slip and to a falling pressure.
        let terms = |xi: f64, z: f64| {
            let slope = pressure.at_and_slope(xi).1;
            [
                p(xi) * (stiffness * a.relaxation * z * z + a.damping * mean * mean),
                p(xi) * a.stiffness * z * mean,
                -p(xi) * stiffness * a.drive * z * mean,
                -0.5 * transport * stiffness * slope * z * z,
            ]
        };
        let volume = over(&|xi, z| terms(xi, z).iter().sum());
        let size = over(&|xi, z| terms(xi, z).iter().map(|term| term.abs()).sum());
        let energy = |history: &History<'_>| {
            0.5 * stiffness * scale * over_patch(history, |xi, z| p(xi) * z * z)
        };
        let before = energy(&history);
        history.push(held);
        let stored = energy(&history) - before;
        // Gauss–Legendre with panels of λt ≤ 1 misses 1e-12 of a decay; the sums are exact to some
        // hundred roundings.
        let size = size + before;
        let close = |got: f64, want: f64, size: f64, what: &str| {
            assert_within(2e-12, size, got, want, || format!("{what} of {step:?}"));
        };
        close(done.force, force, size / duration / (mean.abs() + 1e-9), "force");
        close(done.stored, stored, size, "stored");
        close(done.volume, volume, size, "volume");
        close(done.outlet, done.work - stored - volume, size, "outlet");
    }
}

/// Steps as short as V h = 0.01 and as long as three transits, none merged with another; λh is
/// moderate, for the sake of the quadrature.
fn kept_steps() -> impl Strategy<Value = Vec<Step>> {
    let step = (
        signed(1e-4, 1.0),
        signed(1e-4, 1.0),
        prop_oneof![1 => Just(0.0), 5 => 50.0..150.0],
        prop_oneof![3 => decades(1e-2, 0.5), 2 => 0.5..3.0],
    );
    let step = step.prop_map(|(predicted, mean, transport, way): (f64, f64, f64, f64)| Step {
        predicted,
        mean,
        transport,
        duration: way / if transport > 0.0 { transport } else { 100.0 },
    });
    vec(step, 1..7)
}

#[test]
fn every_entry_of_the_ledger_is_its_integral_over_space_and_time() {
    check(24, (kept_steps(), prop_oneof![Just(0.0), 0.0..2.0]), |(run, damping)| {
        let model = frbd(damping);
        ledger_is_that_of_quadrature(model, constant(), &run);
        ledger_is_that_of_quadrature(model, exponential(0.7), &run);
        ledger_is_that_of_quadrature(model, parabolic(), &run);
        ledger_is_that_of_quadrature(model, falling(), &run);
        ledger_is_that_of_quadrature(lugre(damping), parabolic(), &run);
    });
}

#[test]
fn a_step_that_is_dropped_leaves_no_trace() {
    fn same<const N: usize>(pressure: PolynomialExponential<f64, N>, run: &[Step]) {
        let mut rolling = patch(frbd(0.3), pressure).exact_in(4000).unwrap();
        let mut other = rolling.clone();
        for step in run {
            let motion = step.motion();
            let force = rolling.force(step.mean);
            let unit = rolling.patch().normal_force();
            // As long as it may be: it prepares more than the step that follows.
            for duration in [0.3, step.duration, 2.0] {
                let dropped = rolling.companion_step(motion, duration).unwrap();
                assert!(dropped.bias().is_finite());
                // What is prepared early is added up in another order.
                assert_within(1e-14, unit, rolling.force(step.mean), force, || format!("{step:?}"));
            }
            let (one, two) = [&mut rolling, &mut other]
                .map(|patch| {
                    let step =
                        patch.companion_step(motion, step.duration).unwrap().commit(step.mean);
                    step.unwrap()
                })
                .into();
            assert_within(1e-13, unit, one, two, || format!("{step:?}"));
            let (one, two) = (rolling.force(step.mean), other.force(step.mean));
            assert_within(1e-13, unit, one, two, || format!("{step:?}"));
        }
    }
    check(60, kept_steps(), |run| {
        same(constant(), &run);
        same(parabolic(), &run);
    });
}

/// A speed too small to be a parameter is none: even at 5e-324 m/s nothing is 0/0.
#[test]
fn a_patch_that_all_but_stands_steps_as_one_that_stands() {
    let moved = |rolling_speed| {
        let mut rolling = patch(frbd(0.5), parabolic()).exact_in(20).unwrap();
        rolling.step(motion(0.1, 100.0), 1e-3).unwrap();
        let motion = Motion { slip_velocity: 0.2, rolling_speed };
        let step = rolling.companion_step(motion, 1e-3).unwrap();
        let found = (step.bias(), step.damping());
        step.commit(0.15).unwrap();
        (found, rolling.force(0.15))
    };
    let standing = moved(0.0);
    for rolling_speed in (1..3000).map(f64::from_bits).chain([1e-310, 1e-200]) {
        assert_eq!(moved(rolling_speed), standing, "{rolling_speed:e}");
    }
}

/// A free body: a mass and a wheel on a patch, in steps whose predictions are made up.
fn no_energy_from_nowhere<T: Scalar, const N: usize>(
    pressure: PolynomialExponential<T, N>,
    damping: f64,
    (mass, inertia): (f64, f64),
    run: &[Step],
    rounding: f64,
) {
    let t = |value: f64| lit::<T>(value);
    let f = |value: T| -> f64 { value.to_subset_unchecked() };
    let patch = patch(frbd_of::<T>(damping), pressure).under_load(t(1000.0)).unwrap();
    let mut rolling = patch.exact_in(50).unwrap();
    let radius = 0.3;
    let (mut v, mut w) = (t(3.0), t(20.0));
    let kinetic = |v: T, w: T| 0.5 * (mass * f(v) * f(v) + inertia * f(w) * f(w));
    let mut energy = kinetic(v, w) + f(rolling.stored_energy());
    let start = energy;
    for step in run {
        let motion = step.motion();
        let motion = Motion {
            slip_velocity: t(motion.slip_velocity),
            rolling_speed: t(motion.rolling_speed),
        };
        let h = t(step.duration);
        let companion = rolling.companion_step(motion, h).unwrap();
        // The slip velocity s = v − ωR has the inertia 1/(1/m + R²/J).
        let compliance = t(1.0 / mass + radius * radius / inertia);
        let slip = v - w * t(radius);
        let half = h * t(0.5) * compliance;
        let mean = (slip - half * companion.bias()) / (T::one() + half * companion.damping());
        let force = companion.force(mean);
        let [done] = companion.commit_with_ledger(mean).unwrap();
        v -= h * force / t(mass);
        w += h * force * t(radius / inertia);
        let now = kinetic(v, w) + f(rolling.stored_energy());
        // An energy of this size has passed through.
        let size = start + f(done.work.abs() + done.stored.abs());
        assert!(now <= energy + rounding * size, "{now:e} after {energy:e}, {step:?}");
        assert!(f(done.volume) >= -rounding * size, "{done:?}");
        assert_within(rounding, size, now - energy, -f(done.volume + done.outlet), || {
            format!("{step:?}")
        });
        energy = now;
    }
}

#[test]
fn a_free_body_never_gains_energy_however_absurd_the_predictions() {
    let step = (
        signed(1e-9, 1e3),
        prop_oneof![1 => Just(0.0), 5 => decades(1e-3, 1e3)],
        decades(1e-6, 1.0),
    );
    let step = step.prop_map(|(predicted, transport, duration)| Step {
        predicted,
        mean: 0.0,
        transport,
        duration,
    });
    let body = (decades(0.1, 1e4), decades(1e-2, 1e2));
    let runs = (body, vec(step, 1..40), prop_oneof![Just(0.0), 0.0..5.0]);
    check(60, runs, |(body, run, damping)| {
        // A few hundred roundings: some per segment, and the moments'.
        no_energy_from_nowhere::<f64, 1>(constant(), damping, body, &run, 1e-12);
        no_energy_from_nowhere::<f64, 1>(exponential(0.7), damping, body, &run, 1e-12);
        no_energy_from_nowhere::<f32, 1>(constant(), damping, body, &run, 2e-4);
        no_energy_from_nowhere::<f32, 1>(exponential(0.7), damping, body, &run, 2e-4);
    });
}
