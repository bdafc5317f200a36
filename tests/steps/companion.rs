//! Passive steps: the energy balance for every step and every prediction, the order of accuracy
//! inside a mechanism, and a stuck mass under steps of any length.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test panics to fail")]

use std::cell::Cell;

use bristle::companion::{Companion, CompanionStep, CompletedStep, PointMass, VelocityHistory};
use bristle::curve::{Coulomb, CoulombParameters, Stribeck};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{Affine, Bristle, Contact, FrBd, Law, LuGre, Scalar, paper};
use bristle_specimens::closed_form::{Element, Family};
use bristle_specimens::recipe::{Recipe, State, decades, recipe, state, velocity};
use bristle_specimens::specimens::{
    AsModel, Bare, Specimen, kelvin_voigt, specimens, stribeck, table_2_frbd,
};
use bristle_specimens::{assert_within, check, lit};
use proptest::prelude::*;

/// Relative to the sum of the absolute terms: about forty roundings of 1.1e-16, a few of which φ2
/// multiplies by up to five just above x = ½.
const ROUNDING: f64 = 2e-14;
/// The same for `f32`, with roundings of 6e-8.
const ROUNDING_F32: f64 = 1e-5;

fn companion<T: Scalar>(specimen: &Specimen<T>, fastest: T) -> Companion<T, AsModel<'_, T>> {
    let load = lit(specimen.form.recipe.load);
    AsModel(specimen).under_load(load).unwrap().companion(fastest).unwrap()
}

/// A step of any length from any deflection, with a prediction that need not have to do with what
/// comes.
#[derive(Debug, Clone, Copy)]
struct Wild {
    predicted: f64,
    mean: f64,
    /// z over max μ/σ0 at the predicted speed.
    fraction: f64,
    duration: f64,
}

fn wild() -> impl Strategy<Value = Wild> {
    let fraction = (-1.0..=1.0, prop_oneof![4 => Just(1.0), 1 => decades(1e-6, 1e6)]);
    (velocity(), velocity(), fraction, decades(1e-9, 1e3)).prop_map(
        |(predicted, mean, (sign, size), duration)| Wild {
            predicted,
            mean,
            fraction: sign * size,
            duration,
        },
    )
}

/// The sums of the absolute terms of work, stored and dissipated energy, in plain `f64`.
fn energy_terms(specimen: &Form, a: Affine<f64>, wild: Wild, z: f64) -> f64 {
    let (h, v, z) = (wild.duration, wild.mean.abs(), z.abs());
    let x = a.relaxation * h;
    let phi1 = if x < 1e-4 { 1.0 } else { -(-x).exp_m1() / x };
    let phi2 = if x < 1e-4 { 0.5 } else { (1.0 - phi1) / x };
    let end = (-x).exp() * z + phi1 * h * a.drive * v;
    let mean = phi1 * z + phi2 * h * a.drive * v;
    let spread = 0.5 * x / (6.0 + x); // ½L(x/2) ≤ this, and no less than half of it
    let excess = a.stiffness.abs() + specimen.storage * a.drive;
    specimen.load
        * (h * v * (excess * mean + a.damping * v)
            + specimen.storage * (x * mean * mean + spread * (z + end).powi(2) + (z + end).powi(2)))
}

/// What the terms need to know.
struct Form {
    load: f64,
    storage: f64,
}

/// Plays a wild step on a specimen, in its scalar type.
fn play<T: Scalar>(
    specimen: &Specimen<T>,
    wild: Wild,
) -> (CompanionStep<T>, CompletedStep<T>, Affine<T>, T) {
    let t = |value: f64| lit::<T>(value);
    let fastest = t(wild.predicted.abs());
    let companion = companion(specimen, fastest);
    let limit = specimen.subject.limits(fastest).deflection.unwrap_or_else(T::one);
    let z = limit * t(wild.fraction);
    let step = companion.step(t(wild.predicted), z, t(wild.duration));
    let affine = specimen.subject.affine(t(wild.predicted).into(), z);
    (step, step.commit(t(wild.mean)), affine, z)
}

fn to_f64<T: Scalar>(value: T) -> f64 {
    value.to_subset_unchecked()
}

/// Runs a check over every specimen: committed step, terms of its ledger.
fn every_wild_step<T: Scalar>(
    cases: u32,
    test: impl Fn(&Specimen<T>, Wild, &CompanionStep<T>, &CompletedStep<T>, f64),
) {
    check(cases, (recipe(), wild()), |(recipe, wild)| {
        for specimen in specimens::<T>(&recipe) {
            let (step, committed, a, z) = play(&specimen, wild);
            let a = Affine {
                relaxation: to_f64(a.relaxation),
                drive: to_f64(a.drive),
                stiffness: to_f64(a.stiffness),
                damping: to_f64(a.damping),
            };
            let form = Form { load: recipe.load, storage: recipe.stiffness };
            let terms = energy_terms(&form, a, wild, to_f64(z));
            test(&specimen, wild, &step, &committed, terms);
        }
    });
}

/// Dahl, FrBD on constant stiffness and elasto-plastic FrBD: the theorem's models.
fn is_of_the_theorem<T: Scalar>(specimen: &Specimen<T>) -> bool {
    let family =
        matches!(specimen.form.family, Family::FrBd | Family::Dahl | Family::ElastoPlastic)
            || specimen.is_implicit();
    family && specimen.form.stiffness == Element::Constant
}

// ---------------------------------------------------------------------------------------------
// one step
// ---------------------------------------------------------------------------------------------

#[test]
fn a_prediction_that_comes_true_makes_it_the_step_at_a_held_velocity() {
    check(48, (recipe(), state()), |(recipe, state): (Recipe, State)| {
        for specimen in specimens::<f64>(&recipe) {
            let (v, subject) = (state.velocity, &specimen.subject);
            let Some(limit) = subject.limits(v).deflection else { continue };
            let (z, h) = (state.fraction * limit, state.duration);
            let step = companion(&specimen, v.abs()).step(v, z, h);
            let a = subject.affine(v.into(), z);
            let held = subject.hold(v, z, h);
            let (deflection, mean) = if specimen.is_implicit() {
                // Its step follows the tip; this one freezes the coefficients.
                let frozen = a.hold(v, z, h);
                (frozen.deflection, frozen.mean_coefficient * recipe.load)
            } else {
                (held.deflection, held.mean_force)
            };
            let got = step.commit(v);
            let name = || format!("{} from {z:e} at v = {v:e} for {h:e} s", specimen.name());
            // Elasto-plastic models can overshoot when α is frozen.
            let want = deflection.clamp(-limit, limit);
            assert_within(ROUNDING, limit, got.deflection, want, name);
            let reach = limit.max(deflection.abs());
            let terms = recipe.load
                * ((a.stiffness.abs() + specimen.form.storage()) * reach + a.damping * v.abs());
            assert_within(ROUNDING, terms, got.force, mean, name);
            assert_eq!(got.force, step.force(v));
            assert_eq!(step.force(v), step.bias() + step.damping() * v);
        }
    });
}

#[test]
fn the_work_is_stored_or_dissipated_in_every_step() {
    every_wild_step::<f64>(192, |specimen, wild, _, done, terms| {
        assert_within(ROUNDING, terms, done.work, done.stored + done.dissipated, || {
            format!("{} {wild:?}", specimen.name())
        });
    });
}

#[test]
fn frbd_gives_no_energy_in_any_step_however_wrong_the_prediction() {
    every_wild_step::<f64>(192, |specimen, wild, step, done, terms| {
        if is_of_the_theorem(specimen) {
            let name = || format!("{} {wild:?}", specimen.name());
            assert!(step.is_passive(), "{}", name());
            // By construction, without a tolerance …
            assert!(done.dissipated >= 0.0, "{}: {:e}", name(), done.dissipated);
            // … and by force, velocity and deflection alone.
            let margin = done.work - done.stored;
            assert!(margin >= -ROUNDING * terms, "{}: {margin:e}", name());
        }
    });
}

#[test]
fn the_balance_holds_in_single_precision() {
    // The extremes of these ranges overflow an f32, by the square of a deflection of v h.
    let seen = Cell::new([0_u32; 2]);
    every_wild_step::<f32>(192, |specimen, wild, step, done, terms| {
        let [mut inside, mut beyond] = seen.get();
        if terms < 1e37 && wild.fraction.abs() <= 1.0 {
            inside += 1;
            let (work, stored) = (f64::from(done.work), f64::from(done.stored));
            let dissipated = f64::from(done.dissipated);
            let name = || format!("{} {wild:?}", specimen.name());
            // Below 1e-38 an f32 keeps no relative accuracy: a few products of squares of 1e-38
            // with coefficients of up to 1e9 · 1e6.
            let off = (work - stored - dissipated).abs();
            assert!(off <= ROUNDING_F32 * terms + 1e-22, "{}: {off:e} of {terms:e}", name());
            if is_of_the_theorem(specimen) {
                assert!(step.is_passive() && dissipated >= 0.0, "{}", name());
            }
            assert!(step.damping() >= 0.0);
        } else {
            beyond += 1;
        }
        seen.set([inside, beyond]);
    });
    let [inside, beyond] = seen.get();
    assert!(inside > 2 * beyond, "{inside} steps tried, {beyond} left out");
}

/// Work less stored and dissipated energy, in roundings of what [`CompletedStep`] says that they
/// are sums of; nothing where an f32 overflows, or has no digits.
fn roundings<T: Scalar>(specimen: &Specimen<T>, wild: Wild) -> Option<f64> {
    let (_, done, affine, z) = play(specimen, wild);
    let [relaxation, drive, stiffness, damping] =
        [affine.relaxation, affine.drive, affine.stiffness, affine.damping].map(to_f64);
    let [work, stored, dissipated] = [done.work, done.stored, done.dissipated].map(to_f64);
    let Recipe { load, stiffness: storage, .. } = specimen.form.recipe;
    let energy = |z: f64| 0.5 * load * storage * z * z;
    let mut sum = work.abs() + energy(to_f64(z)) + energy(to_f64(done.deflection));
    if !is_of_the_theorem(specimen) {
        let (h, v, x) = (wild.duration, wild.mean.abs(), relaxation * wild.duration);
        let phi1 = if x < 1e-4 { 1.0 } else { -(-x).exp_m1() / x };
        let phi2 = if x < 1e-4 { 0.5 } else { (1.0 - phi1) / x };
        let mean = phi1 * to_f64(z).abs() + phi2 * h * drive * v;
        sum += load * h * v * ((stiffness - storage * drive).abs() * mean + damping * v);
    }
    let off = (work - stored - dissipated).abs();
    let sound = sum < 1e30 && off > 1e-22 && wild.fraction.abs() <= 1.0;
    sound.then(|| off / sum / to_f64(T::default_epsilon()))
}

/// The worst of 6000 draws are 5.4 where c₀ = K r, and 6.7 elsewhere.
#[test]
fn a_balance_is_off_by_16_roundings_of_its_terms_at_most() {
    check(96, (recipe(), wild()), |(recipe, wild)| {
        for specimen in specimens::<f64>(&recipe) {
            let off = roundings(&specimen, wild).unwrap_or(0.0);
            assert!(off <= 16.0, "{} {wild:?}: {off}", specimen.name());
        }
        for specimen in specimens::<f32>(&recipe) {
            let off = roundings(&specimen, wild).unwrap_or(0.0);
            assert!(off <= 16.0, "{} {wild:?}: {off}", specimen.name());
        }
    });
    // A stuck bristle that moves by less than a rounding of its deflection: the work is a millionth
    // of the energy that is stored, which does not change.
    let model = FrBd::new(stribeck::<f32>(&Recipe::TABLE_2, 2.0), kelvin_voigt(1e4_f32, 64.5));
    let step = model.under_load(1.0).unwrap().companion(1.0).unwrap().step(1e-6, 1e-4, 1e-6);
    let done = step.commit(1e-6);
    assert!(done.stored == 0.0 && done.dissipated < 0.7 * done.work, "{done:?}");
}

#[test]
fn a_step_that_says_so_is_passive_for_every_model() {
    let seen = Cell::new([0_u32; 2]);
    every_wild_step::<f64>(192, |specimen, wild, step, done, terms| {
        let [mut passive, mut not] = seen.get();
        if is_of_the_theorem(specimen) {
        } else if step.is_passive() {
            passive += 1;
            let name = || format!("{} {wild:?}", specimen.name());
            assert!(done.dissipated >= -ROUNDING * terms, "{}: {:e}", name(), done.dissipated);
        } else {
            not += 1;
        }
        seen.set([passive, not]);
    });
    let [passive, not] = seen.get();
    assert!(passive > 1000 && not > 1000, "{passive} passive, {not} not");
}

#[test]
fn a_step_that_does_not_say_so_gives_energy_at_some_velocity() {
    // For h → 0 the dissipation is Kλz² + (c₀ − K r) z v̄ + c₂v̄² times p h, least at
    // v̄ = −(c₀ − K r) z/(2c₂).
    let seen = Cell::new(0_u32);
    check(128, (recipe(), wild()), |(recipe, wild)| {
        for specimen in specimens::<f64>(&recipe) {
            let limit = specimen.subject.limits(wild.predicted).deflection.unwrap();
            let z = 0.5 * limit; // so that nothing is cut
            let a = specimen.subject.affine(wild.predicted.into(), z);
            let excess = a.stiffness - recipe.stiffness * a.drive;
            // Away from the edge, by more than the step's own length can hide.
            let edge = 4.0 * recipe.stiffness * a.relaxation * a.damping;
            if a.damping == 0.0 || excess * excess <= 1.01 * edge {
                continue;
            }
            let mean = -excess * z / (2.0 * a.damping);
            let h = 1e-6 * (z / mean.abs()).min(1.0 / a.relaxation.max(1e-30));
            let step = companion(&specimen, wild.predicted.abs()).step(wild.predicted, z, h);
            assert!(!step.is_passive());
            let done = step.commit(mean);
            assert!(done.dissipated < 0.0, "{} {wild:?}: {done:?}", specimen.name());
            seen.set(seen.get() + 1);
        }
    });
    assert!(seen.get() > 100, "{}", seen.get());
}

#[test]
fn damping_is_never_negative() {
    every_wild_step::<f64>(192, |specimen, wild, step, _, _| {
        assert!(step.damping() >= 0.0, "{} {wild:?}: {:e}", specimen.name(), step.damping());
    });
}

#[test]
fn the_damping_of_lugre_is_a_sum_of_what_is_not_negative() {
    // p (σ0φ2h + σ1φ1 + σ2), though c₀ is about −σ0σ1|v|/g at high speed.
    let r = Recipe { load: 3.0, ..Recipe::TABLE_2 };
    let model = LuGre::classical(stribeck(&r, 2.0), kelvin_voigt(r.stiffness, r.damping));
    let companion = model.under_load(r.load).unwrap().companion(1.0).unwrap();
    for v in [1e-3, 1.0, 1e3, 1e6, 1e9, 1e12_f64] {
        for h in [1e-9, 1e-6, 1e-3, 1.0, 1e3] {
            let x = h * r.stiffness * v / (1.0 + 0.5 * (-(v / 0.01).powi(2)).exp());
            let phi1 = if x < 1e-9 { 1.0 } else { -(-x).exp_m1() / x };
            let phi2 = if x < 1e-5 { 0.5 } else { (1.0 - phi1) / x };
            let want = r.load * (r.stiffness * phi2 * h + r.damping * phi1 + r.viscous);
            let got = companion.step(v, 1e-4, h).damping();
            // φ2 below x = 1e-5 is ½ up to x/6.
            assert_within(2e-6, want, got, want, || format!("{v:e} m/s, {h:e} s"));
        }
    }
    // The same in an f32, with its digits though σ1 − σ1φ1λh leaves none; x = λh is far above one
    // here.
    let r = Recipe { viscous: 0.0, ..r };
    let bristle = kelvin_voigt(1e4_f32, 64.5);
    let model = LuGre::classical(stribeck::<f32>(&r, 2.0), bristle);
    let companion = model.under_load(3.0).unwrap().companion(1.0).unwrap();
    for v in (0..400).map(|n| 1e3 * 1.05_f64.powi(n)) {
        for h in [1e-2, 1.0, 1e2] {
            let damping = f64::from(companion.step(v as f32, 1e-4, h).damping());
            let phi1 = 1.0 / (f64::from(h) * r.stiffness * v);
            let want = r.load * (1.0 - phi1 + r.damping / f64::from(h) / r.stiffness) / v;
            // A dozen roundings of 6e-8; v is rounded, too.
            assert_within(1e-6, want, damping, want, || format!("{v:e} m/s, {h:e} s"));
        }
    }
}

#[test]
fn a_mirrored_step_is_the_mirror_of_the_step() {
    check(48, (recipe(), wild()), |(recipe, wild)| {
        for specimen in specimens::<f64>(&recipe) {
            if !specimen.subject.obeys(Law::OddSymmetry) {
                continue;
            }
            let back = Wild {
                predicted: -wild.predicted,
                mean: -wild.mean,
                fraction: -wild.fraction,
                ..wild
            };
            let ((_, a, ..), (_, b, ..)) = (play(&specimen, wild), play(&specimen, back));
            assert_eq!(a.deflection, -b.deflection, "{}", specimen.name());
            assert_eq!(a.force, -b.force, "{}", specimen.name());
            assert_eq!(
                (a.work, a.stored, a.dissipated),
                (b.work, b.stored, b.dissipated),
                "{}",
                specimen.name()
            );
        }
    });
}

#[test]
fn nan_comes_out_as_nan() {
    for specimen in specimens::<f64>(&Recipe::TABLE_2) {
        let companion = companion(&specimen, 1.0);
        let nan = f64::NAN;
        for (predicted, z, h, mean) in
            [(nan, 1e-5, 1e-3, 0.1), (0.1, nan, 1e-3, 0.1), (0.1, 1e-5, nan, 0.1)]
        {
            let step = companion.step(predicted, z, h);
            assert!(step.bias().is_nan(), "{}", specimen.name());
            let done = step.commit(mean);
            assert!(done.deflection.is_nan() && done.force.is_nan(), "{}", specimen.name());
            assert!(done.work.is_nan() && done.dissipated.is_nan(), "{}", specimen.name());
        }
        let done = companion.step(0.1, 1e-5, 1e-3).commit(nan);
        assert!(done.deflection.is_nan() && done.force.is_nan(), "{}", specimen.name());
        assert!(done.work.is_nan() && done.dissipated.is_nan(), "{}", specimen.name());
    }
}

#[test]
fn the_fastest_speed_must_be_a_number_and_not_negative() {
    let contact = table_2_frbd().under_load(1.0).unwrap();
    for wrong in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(contact.companion(wrong).unwrap_err().name, "fastest");
    }
    assert_eq!(contact.companion(0.0).unwrap().contact(), &contact);
}

// ---------------------------------------------------------------------------------------------
// the limit of the deflection
// ---------------------------------------------------------------------------------------------

#[test]
fn the_deflection_keeps_to_its_limit_and_what_is_cut_off_is_dissipated() {
    // max μ/σ0 = 1.5/1e4 at rest, where σ2|v| adds nothing.
    let companion = table_2_frbd().under_load(2.0).unwrap().companion(0.0).unwrap();
    // Predicted at rest, nothing relaxes and the bristle is carried along: 1e-4 + 0.1 m/s · 2 ms.
    for sign in [1.0, -1.0] {
        let step = companion.step(0.0, sign * 1e-4, 2e-3);
        let done = step.commit(sign * 0.1);
        assert_within(ROUNDING, 1e-4, done.deflection, sign * 1.5e-4, || "cut".into());
        // λ = 0: only the dashpot, p c₂ h v̄² = 2 · 64.5 · 2e-3 · 0.01, and what is cut off.
        let cut = 0.5 * 2.0 * 1e4 * (3e-4_f64.powi(2) - 1.5e-4_f64.powi(2));
        let want = 2.0 * 64.5 * 2e-3 * 0.01 + cut;
        assert_within(ROUNDING, want, done.dissipated, want, || "dissipated".into());
        let stored = 0.5 * 2.0 * 1e4 * (1.5e-4_f64.powi(2) - 1e-8);
        assert_within(ROUNDING, want, done.stored, stored, || "stored".into());
        assert_within(ROUNDING, want, done.work, want + stored, || "work".into());
    }
    // A deflection beyond the limit is not cut, it relaxes; and does not grow.
    let beyond = companion.step(1e-3, 4e-4, 1e-6).commit(1e-3).deflection;
    assert!(beyond > 3.9e-4 && beyond < 4e-4);
    assert_eq!(companion.step(0.0, 4e-4, 1e-3).commit(0.1).deflection, 4e-4);
}

#[test]
fn any_sequence_of_wild_steps_keeps_the_bristle_within_its_limit() {
    check(64, (recipe(), proptest::collection::vec(wild(), 12)), |(recipe, steps)| {
        for specimen in specimens::<f64>(&recipe) {
            let fastest = 1e3; // of `velocity`
            let Some(limit) = specimen.subject.limits(fastest).deflection else { continue };
            let companion = companion(&specimen, fastest);
            let mut z = 0.0;
            for wild in &steps {
                z = companion.step(wild.predicted, z, wild.duration).commit(wild.mean).deflection;
                assert!(z.abs() <= limit, "{}: {z:e} beyond {limit:e}", specimen.name());
            }
        }
    });
}

#[test]
fn a_model_without_a_limit_is_not_cut() {
    let companion = Bare(table_2_frbd()).under_load(1.0).unwrap().companion(1.0).unwrap();
    // Predicted at rest, the bristle is carried along by 10 m/s · 1 s.
    let done = companion.step(0.0, 0.0, 1.0).commit(10.0);
    assert_within(ROUNDING, 10.0, done.deflection, 10.0, || "z".into());
    assert_within(ROUNDING, done.work, done.stored + done.dissipated, done.work, || "W".into());
}

#[test]
fn faster_than_expected_the_deflection_may_be_what_the_curve_asks_for() {
    // Viscous friction carries the valve's packing far beyond its static friction.
    let curve = Stribeck::new(paper::VALVE_CURVE).unwrap();
    let model = FrBd::new(curve, KelvinVoigt::new(paper::VALVE_BRISTLE).unwrap());
    let companion = model.under_load(1.0).unwrap().companion(0.0).unwrap();
    let v = 0.5;
    let done = companion.step(v, 0.0, 1.0).commit(v);
    let want = (39.73 + 2.97e3 * v) / 6.82e7;
    assert!(want > 10.0 * 59.86 / 6.82e7);
    assert_within(ROUNDING, want, done.deflection, want, || "z".into());
    assert_within(1e-2, 1.0, done.force / (want * 6.82e7), 1.0, || "F".into());
}

// ---------------------------------------------------------------------------------------------
// LuGre
// ---------------------------------------------------------------------------------------------

/// Work and dissipation of one cycle of the energy machine on its settled orbit: 1 mm/s over 1.5
/// mm, then 10 m/s over 0.1 mm, p = 1 N, every stroke in ten steps whose prediction comes true.
fn energy_machine<M: Bristle<f64, Deflection = f64>>(model: M) -> (f64, f64) {
    let companion = model.under_load(1.0).unwrap().companion(10.0).unwrap();
    let (mut z, mut cycle) = (0.0, (0.0, 0.0));
    for _ in 0..100 {
        cycle = (0.0, 0.0);
        for (v, distance) in [(1e-3, 1.5e-3), (10.0, 1e-4)] {
            for _ in 0..10 {
                let done = companion.step(v, z, 0.1 * distance / v).commit(v);
                z = done.deflection;
                cycle = (cycle.0 + done.work, cycle.1 + done.dissipated);
            }
        }
    }
    cycle
}

#[test]
fn the_energy_machine_runs_on_lugre_and_not_on_frbd() {
    let r = Recipe::TABLE_2;
    let (curve, bristle) = (|| stribeck(&r, 2.0), || kelvin_voigt(r.stiffness, r.damping));
    // The periodic orbit in closed form, as in tests/models/laws.rs, to half of the last digit
    // given.
    for ((work, dissipated), want, half_digit) in [
        (energy_machine(LuGre::classical(curve(), bristle())), -0.017_813_4, 0.5e-7),
        (
            energy_machine(LuGre::with_viscous_friction(curve(), bristle(), 0.0).unwrap()),
            -0.000_747_45,
            0.5e-8,
        ),
        (energy_machine(FrBd::new(curve(), bristle())), 0.002_382_6, 0.5e-7),
    ] {
        assert!((work - want).abs() <= half_digit, "{work} is not {want}");
        // Nothing is stored over a cycle.
        assert!((dissipated - want).abs() <= half_digit, "{dissipated} is not {want}");
    }
}

#[test]
fn lugre_is_passive_for_every_prediction_up_to_a_speed() {
    // σ1²λ = 4σ0(σ1 + σ2) at |v| = 4 μ_d (σ1 + σ2)/σ1², where the curve has fallen to μ_d.
    let r = Recipe::TABLE_2;
    let model = LuGre::classical(stribeck(&r, 2.0), kelvin_voigt(r.stiffness, r.damping));
    let companion = model.under_load(1.0).unwrap().companion(1.0).unwrap();
    let fastest = 4.0 * 64.54 / 64.5_f64.powi(2);
    assert!(fastest > 6.0 * r.stribeck_velocity); // e⁻³⁶ of the fall is left
    for sign in [1.0, -1.0] {
        let passive = |share: f64| companion.step(sign * share * fastest, 1e-4, 1e-3).is_passive();
        assert!(passive(1.0 - 1e-9) && !passive(1.0 + 1e-9));
    }
}

#[test]
fn lugre_gives_energy_to_a_wrong_prediction_even_where_its_theorem_holds() {
    // σ2 = 33 > 32.25 = σ1(μ_s − μ_d)/μ_d, but σ1²λ > 4σ0(σ1 + σ2) at 10 m/s.
    let r = Recipe { viscous: 33.0, ..Recipe::TABLE_2 };
    let model = LuGre::classical(stribeck(&r, 2.0), kelvin_voigt(r.stiffness, r.damping));
    assert!(model.obeys(Law::Passivity));
    let companion = model.under_load(1.0).unwrap().companion(10.0).unwrap();
    let step = companion.step(10.0, 1.5e-4, 1e-8);
    assert!(!step.is_passive() && step.commit(5.0).dissipated < 0.0);
    // A prediction that comes true, or one that is slow enough, does not harm.
    assert!(step.commit(10.0).dissipated > 0.0);
    assert!(companion.step(0.05, 1.5e-4, 1e-8).is_passive());
}

// ---------------------------------------------------------------------------------------------
// inside a mechanism
// ---------------------------------------------------------------------------------------------

/// A mass of 1 kg on a spring whose end moves, p = 1 N.
#[derive(Debug, Clone, Copy)]
struct Rig {
    stiffness: f64,
    drive: f64,
}

impl Rig {
    const STICK_SLIP: Self = Self { stiffness: 2.0, drive: 0.1 };
}

/// Where the prediction comes from, and which v̄ the mechanism takes.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Variant {
    /// 1.5 vₙ − 0.5 vₙ₋₁
    Extrapolated,
    /// v₀ + (h/2) a₀
    Accelerated,
    /// Extrapolated, then once more with the v̄ found.
    Corrected,
    /// v₀
    Start,
    /// Extrapolated, v̄ = v₁
    BackwardEuler,
}

type MotionState = [f64; 3];

fn steps_of(h: f64, end: f64) -> u32 {
    (end / h).round() as u32
}

/// Position, velocity and deflection after `steps` steps; `watch` sees every step.
fn run<M: Bristle<f64, Deflection = f64>>(
    companion: &Companion<f64, M>,
    rig: Rig,
    (start, end): (MotionState, f64),
    steps: u32,
    variant: Variant,
    mut watch: impl FnMut(f64, MotionState, &CompletedStep<f64>),
) -> MotionState {
    let h = end / f64::from(steps);
    let ([mut x, mut v, mut z], k) = (start, rig.stiffness);
    let mut history = VelocityHistory::new(v);
    for n in 0..steps {
        let t = h * f64::from(n);
        // m (v₁ − v)/h = k (y − x) − F̄, all at the end of the step or in its middle.
        let solve = |step: &CompanionStep<f64>| {
            if variant == Variant::BackwardEuler {
                (v / h + k * (rig.drive * (t + h) - x) - step.bias())
                    / (1.0 / h + h * k + step.damping())
            } else {
                (2.0 / h * v + k * (rig.drive * (t + 0.5 * h) - x) - step.bias())
                    / (2.0 / h + 0.5 * h * k + step.damping())
            }
        };
        let predicted = match variant {
            Variant::Start => v,
            Variant::Accelerated => {
                let force = companion.contact().force(v, z);
                v + 0.5 * h * (k * (rig.drive * t - x) - force)
            }
            _ => history.predict(),
        };
        let mut step = companion.step(predicted, z, h);
        if variant == Variant::Corrected {
            step = companion.step(solve(&step), z, h);
        }
        let mean = solve(&step);
        let done = step.commit(mean);
        v = if variant == Variant::BackwardEuler { mean } else { 2.0 * mean - v };
        (x, z) = (x + h * mean, done.deflection);
        history.push(v);
        watch(t + h, [x, v, z], &done);
    }
    [x, v, z]
}

/// The same motion by the classical Runge–Kutta method.
fn runge_kutta<M: Bristle<f64, Deflection = f64>>(
    contact: &Contact<f64, M>,
    rig: Rig,
    (start, end): (MotionState, f64),
    steps: u32,
) -> MotionState {
    let h = end / f64::from(steps);
    let rate = |t: f64, [x, v, z]: MotionState| {
        let response = contact.response(v, z);
        [v, rig.stiffness * (rig.drive * t - x) - response.force, response.rate]
    };
    let along = |s: MotionState, a: f64, d: MotionState| std::array::from_fn(|i| s[i] + a * d[i]);
    let mut s = start;
    for n in 0..steps {
        let t = h * f64::from(n);
        let k1 = rate(t, s);
        let k2 = rate(t + 0.5 * h, along(s, 0.5 * h, k1));
        let k3 = rate(t + 0.5 * h, along(s, 0.5 * h, k2));
        let k4 = rate(t + h, along(s, h, k3));
        let slope = std::array::from_fn(|i| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0);
        s = along(s, h, slope);
    }
    s
}

/// Motions without a reversal: steady sliding that is disturbed, acceleration through the Stribeck
/// range, and loading up to half of breakaway. With the number of steps to begin with.
fn smooth_motions() -> [(&'static str, Rig, (MotionState, f64), u32); 3] {
    let steady = table_2_frbd().stationary(0.15);
    [
        ("sliding", Rig::STICK_SLIP, ([-0.502, 0.15, steady], 1.0), 400),
        ("Stribeck", Rig { drive: 0.02, ..Rig::STICK_SLIP }, ([-0.55, 0.012, 0.9e-4], 0.5), 800),
        ("loading", Rig { stiffness: 200.0, drive: 0.02 }, ([0.0, 0.0, 0.0], 0.3), 400),
    ]
}

/// Errors of position, velocity and deflection, relative to the size of each in the motion.
fn errors(variant: Variant, rig: Rig, motion: (MotionState, f64), steps: u32) -> [f64; 3] {
    let contact = table_2_frbd().under_load(1.0).unwrap();
    // h λ ≤ 1e-3 in the reference: its errors are below 1e-13.
    let want = runge_kutta(&contact, rig, motion, 200_000);
    let got = run(&contact.companion(1.0).unwrap(), rig, motion, steps, variant, |_, _, _| {});
    std::array::from_fn(|i| (got[i] - want[i]).abs() / want[i].abs())
}

#[test]
fn a_velocity_predicted_at_the_middle_of_the_step_gives_second_order() {
    for (name, rig, motion, steps) in smooth_motions() {
        for variant in [Variant::Extrapolated, Variant::Accelerated] {
            let coarse = errors(variant, rig, motion, 4 * steps);
            let fine = errors(variant, rig, motion, 8 * steps);
            for i in 0..3 {
                let order = (coarse[i] / fine[i]).log2();
                assert!(
                    (1.9..2.1).contains(&order),
                    "{name}, {variant:?}: order {order} of state {i}"
                );
            }
        }
    }
}

#[test]
fn a_second_solution_keeps_the_order_and_gains_accuracy() {
    for (name, rig, motion, steps) in smooth_motions() {
        let extrapolated = errors(Variant::Extrapolated, rig, motion, 16 * steps);
        let coarse = errors(Variant::Corrected, rig, motion, 8 * steps);
        let fine = errors(Variant::Corrected, rig, motion, 16 * steps);
        for i in 0..3 {
            let order = (coarse[i] / fine[i]).log2();
            // Where the error of h² nearly vanishes, that of h³ is still in sight.
            assert!((1.85..2.15).contains(&order), "{name}: order {order} of state {i}");
        }
        // Twice the work would gain four from a halved step; this gains more.
        let gain = extrapolated[1] / fine[1];
        assert!(gain > 8.0, "{name}: only {gain} times better");
    }
}

#[test]
fn a_velocity_from_the_beginning_of_the_step_gives_first_order() {
    for (name, rig, motion, steps) in smooth_motions() {
        for variant in [Variant::Start, Variant::BackwardEuler] {
            let coarse = errors(variant, rig, motion, 4 * steps);
            let fine = errors(variant, rig, motion, 8 * steps);
            for i in 0..3 {
                let order = (coarse[i] / fine[i]).log2();
                assert!((0.9..1.1).contains(&order), "{name}, {variant:?}: order {order}");
            }
        }
    }
}

/// max μ/σ0 \[m\]: static friction, and at 4 µm/s the 8e-8 that σ2|v| adds before the curve falls.
const LIMIT: f64 = 1.500_000_1e-4;

#[test]
fn a_stuck_mass_stays_stuck_and_bounded_for_every_step() {
    let companion = table_2_frbd().under_load(1.0).unwrap().companion(1.0).unwrap();
    for variant in [Variant::Extrapolated, Variant::Corrected, Variant::BackwardEuler] {
        for h in [6e-4, 1e-3, 5e-3, 1e-2, 2.5e-2, 3e-2, 5e-2, 0.1, 0.25, 0.5] {
            let steps = steps_of(h, 25.0);
            let (mut stuck, mut energy): (f64, f64) = (0.0, 0.0);
            let name = || format!("{variant:?}, h = {h}");
            run(&companion, Rig::STICK_SLIP, ([0.0; 3], 25.0), steps, variant, |t, s, done| {
                let [x, v, z] = s;
                let terms = done.work.abs() + done.stored.abs() + done.dissipated;
                let margin = done.work - done.stored;
                assert!(margin >= -ROUNDING * terms, "{}: {margin:e} at {t}", name());
                assert!(done.dissipated >= 0.0);
                assert!(z.abs() <= LIMIT, "{}: z = {z:e} at {t}", name());
                // The spring holds at most about breakaway, 1.5 N over 2 N/m, and the swing after
                // it.
                let stretch = 0.1 * t - x;
                assert!(stretch.abs() < 1.5 && v.abs() < 1.0, "{}: {s:?} at {t}", name());
                if t < 5.0 {
                    stuck = stuck.max(x);
                }
                energy += done.stored;
            });
            // At 5 s the spring pulls with 1 N of 1.5. With ż = v (1 − σ0z/μ_s), quasi-static,
            // x = −(μ_s/σ0) ln(1 − ⅔) = 1.65e-4 m.
            assert!(stuck < 1.75e-4, "{}: {stuck:e}", name());
            let stored = companion.contact().stored_energy(LIMIT);
            assert!(energy >= 0.0 && energy <= stored);
        }
    }
    // The classical Runge–Kutta method holds it up to 28 ms, then lets it creep, then explodes.
    let lost = |h: f64| {
        let motion = ([0.0; 3], 4.8);
        runge_kutta(companion.contact(), Rig::STICK_SLIP, motion, steps_of(h, 4.8))[0]
    };
    assert!(lost(0.027) < 2e-4 && lost(0.03) > 5e-4 && !(lost(0.04).abs() < 1.0));
}

#[test]
fn a_struck_mass_is_caught_where_it_should_be() {
    // Pulled by 0.8 N and struck at 0.3 m/s.
    let contact = table_2_frbd().under_load(1.0).unwrap();
    let companion = contact.companion(1.0).unwrap();
    let (rig, motion) = (Rig { drive: 0.0, ..Rig::STICK_SLIP }, ([-0.4, 0.3, 0.8e-4], 10.0));
    let want = runge_kutta(&contact, rig, motion, 100_000)[0];
    // Within so many millimetres of the 132 it slides; long steps are worse by the order, and
    // creep.
    for (variant, h, off) in [
        (Variant::Extrapolated, 0.01, 0.1),
        (Variant::Corrected, 0.01, 0.02),
        (Variant::Extrapolated, 0.05, 3.0),
        (Variant::Corrected, 0.05, 0.5),
        (Variant::Corrected, 0.1, 2.0),
    ] {
        let [x, v, _] = run(&companion, rig, motion, steps_of(h, 10.0), variant, |_, _, _| {});
        let got = 1e3 * (x - want).abs();
        assert!(got < off && v.abs() < 1e-5, "{variant:?}, h = {h}: {got} mm off, v = {v:e}");
    }
}

#[test]
fn a_mass_on_a_slope_stands_in_steps_too_long_for_its_bristles() {
    // ω = 261 rad/s: 4.4 rad a step of 1/60 s. A linear extrapolation lets it creep by 4.9 mm/s.
    let curve = Coulomb::new(CoulombParameters { dynamic_coefficient: 0.7, viscous_friction: 0.0 });
    let bristle = KelvinVoigtParameters { micro_stiffness: 1e4, micro_damping: 50.0 };
    let contact = FrBd::new(curve.unwrap(), KelvinVoigt::new(bristle).unwrap());
    let (weight, slope, h) = (9.81, 30_f64.to_radians(), 1.0 / 60.0);
    let contact = contact.under_load(weight * slope.cos()).unwrap();
    let companion = contact.companion(1.0).unwrap();
    let (mut x, mut v, mut z, mut settled) = (0.0, 0.0, 0.0, 0.0);
    let mut history = VelocityHistory::new(v);
    for n in 0..3600 * 60 {
        let step = companion.step(history.predict(), z, h);
        let body =
            PointMass { mass: 1.0, velocity: v, force: weight * slope.sin(), end_weight: 0.5 };
        let mean = step.point_mass(body);
        (x, v, z) = (x + h * mean, 2.0 * mean - v, step.commit(mean).deflection);
        history.push(v);
        if n == 60 * 60 {
            settled = x;
        }
    }
    // Quasi-static, ż = v (1 − σ0 z/μ): x = −(μ/σ0) ln(1 − tan(30°)/μ) = 1.22e-4 m. The first
    // minute it swings, and creeps by that.
    assert!(settled < 1e-3 && (x - settled).abs() < 1e-12, "{settled:e} {:e}", x - settled);
}

#[test]
fn the_force_overshoots_by_what_the_docs_say() {
    // The table in the documentation of `Companion`, rounded to its last digit.
    let companion = table_2_frbd().under_load(1.0).unwrap().companion(1.0).unwrap();
    for (h, extrapolated, corrected) in OVERSHOOT {
        for (variant, want) in
            [(Variant::Extrapolated, extrapolated), (Variant::Corrected, corrected)]
        {
            let steps = steps_of(h, 25.0);
            let mut largest: f64 = 0.0;
            run(&companion, Rig::STICK_SLIP, ([0.0; 3], 25.0), steps, variant, |_, _, done| {
                largest = largest.max(done.force.abs());
            });
            assert!((largest - want).abs() < 0.0055, "{variant:?}, h = {h}: {largest}");
        }
    }
}

/// Step [s], largest force [N] in the stick-slip rig, extrapolated and corrected.
const OVERSHOOT: [(f64, f64, f64); 6] = [
    (1e-3, 1.48, 1.48),
    (1e-2, 1.49, 1.48),
    (5e-2, 1.52, 1.51),
    (0.1, 1.58, 1.55),
    (0.25, 1.74, 1.66),
    (0.5, 2.00, 1.83),
];

#[test]
fn the_whole_mechanism_keeps_its_energy_balance() {
    // Kinetic and elastic energy, the bristle's, what is dissipated: together the work of the
    // drive.
    let companion = table_2_frbd().under_load(1.0).unwrap().companion(1.0).unwrap();
    let rig = Rig::STICK_SLIP;
    for h in [1e-3, 2.5e-2, 0.5] {
        let (mut before, mut dissipated, mut drive, mut peak) = ([0.0; 3], 0.0, 0.0, 0.0_f64);
        let energy = |t: f64, [x, v, z]: MotionState| {
            let stretch = rig.drive * t - x;
            0.5 * v * v
                + 0.5 * rig.stiffness * stretch * stretch
                + companion.contact().stored_energy(z)
        };
        let steps = steps_of(h, 25.0);
        let start = ([0.0; 3], 25.0);
        let end = run(&companion, rig, start, steps, Variant::Extrapolated, |t, s, done| {
            let stretch = rig.drive * (t - 0.5 * h) - 0.5 * (before[0] + s[0]);
            drive += rig.stiffness * stretch * rig.drive * h;
            dissipated += done.dissipated;
            before = s;
            peak = peak.max(energy(t, s));
        });
        // 25 000 steps of a dozen roundings of the largest energy.
        let total = energy(25.0, end) + dissipated;
        assert_within(1e-10, drive + peak, total, drive, || format!("h = {h}"));
    }
}

// ---------------------------------------------------------------------------------------------
// prediction, allocation
// ---------------------------------------------------------------------------------------------

#[test]
fn the_history_extrapolates_to_the_middle_of_the_next_step() {
    let mut history = VelocityHistory::new(2.0);
    assert_eq!(history.predict(), 2.0);
    history.push(3.0);
    assert_eq!(history.predict(), 3.5);
    history.push(1.0);
    assert_eq!(history.predict(), 0.0);
    history.push(-1.0);
    assert_eq!(history.predict(), -1.0); // a reversal
    history.push(-2.0);
    assert_eq!(history.predict(), -2.5);
    history = VelocityHistory::new(-4.0);
    assert_eq!(history.predict(), -4.0);
    history.push(-5.0);
    assert_eq!(history.predict(), -5.5);
    history.push(f64::NAN);
    assert!(history.predict().is_nan());
}

#[test]
fn a_run_of_passive_steps_allocates_nothing() {
    let counted = allocation_counter::measure(|| {
        let companion = table_2_frbd().under_load(1.0).unwrap().companion(1.0).unwrap();
        let motion = ([0.0; 3], 25.0);
        let mut dissipated = 0.0;
        run(&companion, Rig::STICK_SLIP, motion, 5000, Variant::Corrected, |_, _, done| {
            dissipated += done.dissipated;
        });
        assert!(dissipated > 0.1, "{dissipated}");
    });
    assert_eq!(counted.count_total, 0);
}
