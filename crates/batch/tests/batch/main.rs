//! Batches: the same step as one bristle takes, the energy balance, the same bits wherever a
//! bristle stands, and numbers that are none.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test panics to fail")]

mod axes;
mod loads;
mod own;

use std::fmt::Debug;

use bristle::curve::{
    Coulomb, CoulombParameters, RationalStribeck, RationalStribeckParameters, Stribeck,
    StribeckParameters,
};
use bristle::rheology::KelvinVoigt;
use bristle::{Affine, Bristle, Contact, Dahl, DahlParameters, FrBd, Law, Scalar, Surface};
use bristle_batch::{
    Batch, BatchError, Columns, CommitInput, Fall, Outcome, PassiveOutput, Real, StepInput, Uniform,
};
use bristle_specimens::draw::Draw;
use bristle_specimens::recipe::Recipe;
use bristle_specimens::specimens::{
    self, table_2_bristle as kelvin_voigt, table_2_frbd as friction,
};
use bristle_specimens::{assert_within, lit};

/// Bristles of a batch, before and after a step.
#[derive(Debug, Clone, PartialEq)]
struct Run<T> {
    predicted: Vec<T>,
    mean: Vec<T>,
    load: Vec<T>,
    before: Vec<T>,
    share: Vec<T>,
    bias: Vec<T>,
    damping: Vec<T>,
    after: Vec<T>,
    held: Vec<T>,
    held_force: Vec<T>,
}

impl<T: Real> Run<T> {
    fn columns(&mut self) -> [&mut Vec<T>; 10] {
        let Self { predicted, mean, load, before, share, bias, damping, after, .. } = self;
        let (held, held_force) = (&mut self.held, &mut self.held_force);
        [predicted, mean, load, before, share, bias, damping, after, held, held_force]
    }

    /// Velocities around the Stribeck velocity of 0.01 m/s and far from it, deflections within and
    /// beyond their limit of 1.5e-4 m.
    fn random(length: usize) -> Self {
        let mut draw = Draw(9429);
        let zeros = [(); 10].map(|()| vec![T::zero(); length]);
        let [predicted, mean, load, before, share, bias, damping, after, held, held_force] = zeros;
        let mut run =
            Self { predicted, mean, load, before, share, bias, damping, after, held, held_force };
        for i in 0..length {
            let mut velocity = || lit(draw.sign() * draw.logarithmic(1e-6, 10.0));
            (run.predicted[i], run.mean[i]) = (velocity(), velocity());
            run.load[i] = lit(draw.logarithmic(1e-3, 1e3));
            run.before[i] = lit(draw.sign() * draw.logarithmic(1e-9, 3e-4));
        }
        run
    }

    /// A part of the bristles.
    fn part(&self, from: usize, to: usize) -> Self {
        let mut part = self.clone();
        for column in part.columns() {
            *column = column[from..to].to_vec();
        }
        part
    }

    /// Both kinds of step: what the beginning and the end of the passive one report, and the exact
    /// one.
    fn step(&mut self, batch: &Batch<'_, T>, duration: T) -> [Outcome; 3] {
        self.after.copy_from_slice(&self.before);
        let predicted = StepInput {
            velocities: &self.predicted,
            normal_forces: &self.load,
            deflections: &mut self.after,
        };
        let dampers = PassiveOutput {
            shares: &mut self.share,
            biases: &mut self.bias,
            dampings: &mut self.damping,
        };
        let begun = batch.companions(predicted, duration, dampers).unwrap();
        // The beginning leaves the deflections to the end.
        let found =
            CommitInput { shares: &self.share, velocities: &self.mean, normal_forces: &self.load };
        let ended = batch.commit(found, duration, &mut self.after).unwrap();
        self.held.copy_from_slice(&self.before);
        let held = StepInput {
            velocities: &self.predicted,
            normal_forces: &self.load,
            deflections: &mut self.held,
        };
        [begun, ended, batch.hold(held, duration, &mut self.held_force).unwrap()]
    }

    /// The bits of everything that a step leaves of one bristle; NaN has none of its own.
    fn bits(&self, index: usize) -> [u64; 6] {
        let columns =
            [&self.share, &self.bias, &self.damping, &self.after, &self.held, &self.held_force];
        columns.map(|column| {
            let value: f64 = column[index].to_subset_unchecked();
            if value.is_nan() { f64::NAN.to_bits() } else { value.to_bits() }
        })
    }
}

fn stribeck<T: Scalar>(exponent: f64) -> Stribeck<T> {
    specimens::stribeck(&Recipe::TABLE_2, exponent)
}

fn spring<T: Scalar>(stiffness: f64) -> KelvinVoigt<T> {
    specimens::spring(lit(stiffness))
}

/// The parameters of Table 2, in the order of [`Columns`].
const PARAMETERS: [f64; 6] = [1.5, 1.0, 0.01, 0.04, 1e4, 64.5];

fn columns<'a, T, C: AsRef<[T]>>(of: &'a [C; 6]) -> Columns<'a, T> {
    let [static_, dynamic, velocity, viscous, stiffness, damping] = of.each_ref().map(C::as_ref);
    Columns {
        static_coefficients: static_,
        dynamic_coefficients: dynamic,
        stribeck_velocities: velocity,
        viscous_frictions: viscous,
        micro_stiffnesses: stiffness,
        micro_dampings: damping,
    }
}

/// What is done with every model that a batch knows.
trait Task<T: Real> {
    fn does<M: Uniform<T> + Bristle<T, Deflection = T> + Debug + Copy + Sync>(&self, model: M);
}

fn every_model<T: Real>(task: &impl Task<T>) {
    let rational = RationalStribeck::new(RationalStribeckParameters {
        static_coefficient: lit(0.6),
        dynamic_coefficient: lit(0.2),
        stribeck_velocity: lit(0.05),
        viscous_friction: lit(0.1),
    })
    .unwrap();
    let coulomb = CoulombParameters { dynamic_coefficient: lit(0.7), viscous_friction: lit(0.2) };
    let coulomb = Coulomb::new(coulomb).unwrap();
    let (spring, kelvin_voigt) = (spring(3e3), kelvin_voigt());
    let dahl = DahlParameters { dynamic_coefficient: lit(0.5), micro_stiffness: lit(1e4) };
    task.does(friction());
    task.does(FrBd::new(stribeck(1.0), kelvin_voigt));
    task.does(FrBd::new(rational, kelvin_voigt));
    task.does(FrBd::new(rational, spring));
    task.does(FrBd::new(coulomb, kelvin_voigt));
    task.does(FrBd::new(stribeck(2.0), spring));
    task.does(Dahl::new(dahl).unwrap());
}

fn f<T: Scalar>(value: T) -> f64 {
    value.to_subset_unchecked()
}

const DURATIONS: [f64; 6] = [0.0, 1e-6, 1e-3, 0.02, 1.0, 1e3];

struct Steps;

impl<T: Real> Task<T> for Steps {
    fn does<M: Uniform<T> + Bristle<T, Deflection = T> + Debug + Copy + Sync>(&self, model: M) {
        let mut run = Run::random(300);
        steps_are_those_of_a_bristle(&Batch::of(&model).unwrap(), &run, of_each, |load| {
            model.under_load(load).unwrap()
        });
        // Under a load that scales the friction, and under none.
        let reference = lit(2.0);
        run.load.iter_mut().step_by(7).for_each(|load| *load = T::zero());
        let batch = Batch::of(&model).unwrap().measured_at(reference).unwrap();
        steps_are_those_of_a_bristle(&batch, &run, of_each, |load| {
            model.under_load(load).unwrap().measured_at(reference).unwrap()
        });
    }
}

/// (μ_s + σ2|v̄|)/σ0, the second from what the model allows at very high speeds.
fn of_each<T: Real>(model: &impl Bristle<T, Deflection = T>, _: Surface<T>, mean: T) -> f64 {
    let limit = |speed: f64| f(model.limits(lit(speed)).deflection.unwrap());
    limit(0.0) + (limit(2e6) - limit(1e6)) / 1e6 * f(mean).abs()
}

fn steps_are_those_of_a_bristle<T: Real, M: Bristle<T, Deflection = T>>(
    batch: &Batch<'_, T>,
    run: &Run<T>,
    limit: impl Fn(&M, Surface<T>, T) -> f64,
    contact: impl Fn(T) -> Contact<T, M>,
) {
    let mut run = run.clone();
    for h in DURATIONS {
        for outcome in run.step(batch, lit(h)) {
            assert!(outcome.is_finite(), "{batch:?} {outcome}");
        }
        for i in 0..run.mean.len() {
            let contact = contact(run.load[i]);
            if contact.friction_scale() == T::zero() {
                // What is left of a bristle without a load does nothing.
                assert_eq!([run.bias[i], run.damping[i], run.held_force[i]].map(f), [0.0; 3]);
                continue;
            }
            let near = |ulps: f64, size: f64, got: T, want: f64, name: &str| {
                let what = || format!("{name} of {contact:?}, bristle {i}, h = {h}");
                assert_within(ulps * f(T::default_epsilon()), size, f(got), want, what);
            };
            // Some ten roundings, of which the commit's 1 − c doubles one.
            let (model, v) = (contact.model(), run.predicted[i].into());
            let most = f(contact.friction_scale()) * limit(model, v, run.mean[i]);
            is_the_midpoint_rule(&contact, &run, i, (h, most), |size, got, want, name| {
                near(16.0, size, got, want, name);
            });
            // Below x = ½ the scalar step takes a series, above it loses less than two digits
            // of φ2; both exponents carry a few roundings of x, of which e⁻ˣ gets 1/e at most.
            is_that_of_one_bristle(&contact, &run, i, h, |size, got, want, name| {
                near(24.0, size, got, want, name);
            });
            if model.obeys(Law::Passivity) {
                gives_no_energy(&contact, &run, i, h);
            }
        }
    }
}

/// Bias, damping and deflection of the implicit midpoint rule, as the crate writes it, in f64 of
/// the model's own numbers, and the size of what is subtracted.
fn midpoint<T: Real>(a: Affine<T>, load: T, [before, v]: [T; 2], h: f64) -> [f64; 4] {
    let (rate, drive, stiffness) = (f(a.relaxation), f(a.drive), f(a.stiffness));
    let (load, before, v) = (f(load), f(before), f(v));
    let slack = 1.0 / (1.0 + 0.5 * rate * h);
    let damping = load * (stiffness * slack * 0.5 * h * drive + f(a.damping));
    let mean = slack * (before + 0.5 * h * drive * v);
    let size = slack * h * (drive * v.abs() + rate * before.abs()) + before.abs();
    [load * stiffness * slack * before, damping, before + 2.0 * (mean - before), size]
}

fn is_the_midpoint_rule<T: Real>(
    contact: &Contact<T, impl Bristle<T, Deflection = T>>,
    run: &Run<T>,
    i: usize,
    (h, most): (f64, f64),
    near: impl Fn(f64, T, f64, &str),
) {
    let a = contact.affine(run.predicted[i], run.before[i]);
    let states = [run.before[i], run.mean[i]];
    let [bias, damping, after, size] = midpoint(a, contact.reference_load(), states, h);
    let most = most.max(f(run.before[i]).abs());
    near(bias.abs(), run.bias[i], bias, "bias");
    near(damping, run.damping[i], damping, "damping");
    near(size, run.after[i], after.clamp(-most, most), "deflection");
}

/// The exact step of a contact.
fn is_that_of_one_bristle<T: Real>(
    contact: &Contact<T, impl Bristle<T, Deflection = T>>,
    run: &Run<T>,
    i: usize,
    h: f64,
    near: impl Fn(f64, T, f64, &str),
) {
    let (v, before) = (run.predicted[i], run.before[i]);
    let want = contact.hold(v, before, lit(h));
    // The two terms of each sum, in size: what came and what was there.
    let a = contact.affine(v, before);
    let x = (f(a.relaxation) * h).min(1.0);
    let size = f(before).abs() + x * f(contact.stationary(v)).abs();
    let force =
        f(contact.reference_load()) * (f(a.stiffness).abs() * size + f(a.damping) * f(v).abs());
    near(size, run.held[i], f(want.deflection), "held deflection");
    near(force, run.held_force[i], f(want.mean_force), "held force");
}

/// No step gives energy that was not stored.
fn gives_no_energy<T: Real>(
    contact: &Contact<T, impl Bristle<T, Deflection = T>>,
    run: &Run<T>,
    i: usize,
    h: f64,
) {
    let stiffness = contact.model().storage_stiffness();
    let half = 0.5 * f(contact.reference_load()) * f(stiffness);
    let stored = |z: T| half * f(z) * f(z);
    let before = stored(run.before[i]);
    // Any mean velocity, whatever was predicted; and a held one.
    let (v, bias, damping) = (f(run.mean[i]), f(run.bias[i]), f(run.damping[i]));
    let size = h * v.abs() * (bias.abs() + damping * v.abs());
    let held = h * f(run.predicted[i]) * f(run.held_force[i]);
    for (work, size, after) in [
        (h * v * (bias + damping * v), size, stored(run.after[i])),
        (held, held.abs(), stored(run.held[i])),
    ] {
        let (gain, terms) = (after - before, size + after + before);
        let rounding = 32.0 * f(T::default_epsilon()) * terms;
        assert!(work - gain >= -rounding, "{contact:?}, bristle {i}, h = {h}: {work} {gain}");
    }
}

#[test]
fn a_passive_step_is_the_midpoint_rule_an_exact_one_that_of_one_bristle_and_none_gives_energy() {
    every_model::<f64>(&Steps);
    every_model::<f32>(&Steps);
}

/// Loads before and after that come from or go to nothing, and such as are none.
const NO_LOADS: [[f64; 8]; 2] = [
    [0.0, 2.0, 0.0, f64::NAN, 1.0, 1.0, f64::INFINITY, f64::INFINITY],
    [2.0, 0.0, 0.0, 1.0, -1.0, f64::INFINITY, 1.0, f64::INFINITY],
];

fn same_bits_in_batches_of_every_size<T: Real>() {
    let batch = Batch::of(&friction::<T>()).unwrap();
    let h = lit(2e-3);
    let mut all = Run::<T>::random(67);
    // What must be spoilt by no neighbour, nor spoil one.
    all.predicted[13] = lit(f64::NAN);
    all.before[40] = lit(f64::INFINITY);
    let alone: Vec<_> = (0..67)
        .map(|i| {
            let mut one = all.part(i, i + 1);
            let _ = one.step(&batch, h);
            one.bits(0)
        })
        .collect();
    for offset in [0, 1, 2, 3, 5, 7, 8, 15, 16, 31, 33] {
        for size in 0..=67 - offset {
            let mut part = all.part(offset, offset + size);
            let _ = part.step(&batch, h);
            for i in 0..size {
                assert_eq!(part.bits(i), alone[offset + i], "bristle {i} of {size} from {offset}");
            }
        }
    }
}

#[test]
fn a_bristle_gets_the_same_bits_in_a_batch_of_any_size_and_at_any_place() {
    same_bits_in_batches_of_every_size::<f64>();
    same_bits_in_batches_of_every_size::<f32>();
}

#[test]
fn every_bristle_obeys_its_own_parameters() {
    let mut draw = Draw(7);
    let mut column =
        |from: f64, to: f64| (0..70).map(|_| draw.logarithmic(from, to)).collect::<Vec<_>>();
    let ranges = [(1.0, 3.0), (0.1, 1.0), (1e-3, 1.0), (1e-3, 1.0), (1e2, 1e5), (1e-2, 1e2)];
    let values = ranges.map(|(from, to)| column(from, to));
    for (fall, exponent) in [(Fall::Gaussian, 2.0), (Fall::Exponential, 1.0)] {
        let mut run = Run::<f64>::random(70);
        let _ = run.step(&Batch::of_each(fall, columns(&values)).unwrap(), 1e-3);
        for i in 0..70 {
            let [static_, dynamic, velocity, viscous, stiffness, damping] =
                values.each_ref().map(|column| column[i]);
            let curve = Stribeck::new(StribeckParameters {
                static_coefficient: static_,
                dynamic_coefficient: dynamic,
                stribeck_velocity: velocity,
                stribeck_exponent: exponent,
                viscous_friction: viscous,
            });
            let model = FrBd::new(curve.unwrap(), specimens::kelvin_voigt(stiffness, damping));
            let mut alone = run.part(i, i + 1);
            let _ = alone.step(&Batch::of(&model).unwrap(), 1e-3);
            assert_eq!(run.bits(i), alone.bits(0), "bristle {i}");
        }
    }
}

#[test]
fn the_deflection_is_cut_to_its_limit_only_when_the_velocity_was_mispredicted() {
    let batch = Batch::of(&friction::<f64>()).unwrap();
    // Predicted at rest, then 1 m/s for 1 s: the bristle would follow by 1 m.
    let mut deflections = [0.0, 0.0, 4e-4];
    let found =
        CommitInput { shares: &[1.0; 3], velocities: &[1.0, -1.0, 1.0], normal_forces: &[1.0; 3] };
    assert!(batch.commit(found, 1.0, &mut deflections).unwrap().is_finite());
    // (μ_s + σ2|v̄|)/σ0, and what was beyond it stays.
    assert_eq!(deflections, [1.54e-4, -1.54e-4, 4e-4]);
}

#[test]
fn a_step_of_no_length_changes_no_deflection() {
    // Without damping κ = σ1 + h σ0/2 is zero too.
    let batch = Batch::of(&FrBd::new(stribeck(2.0), spring(1e4))).unwrap();
    let mut run = Run::<f64>::random(40);
    assert!(run.step(&batch, 0.0).iter().all(Outcome::is_finite));
    assert_eq!((&run.before, &run.before), (&run.after, &run.held));
}

/// What bristle 11 of 40 gets, and whether its neighbours keep their bits.
fn spoilt(batch: &Batch<'_, f64>, spoil: impl Fn(&mut Run<f64>)) -> ([Outcome; 3], Run<f64>) {
    let mut clean = Run::<f64>::random(40);
    let mut run = clean.clone();
    let _ = clean.step(batch, 1e-3);
    spoil(&mut run);
    let outcomes = run.step(batch, 1e-3);
    for i in (0..40).filter(|&i| i != 11) {
        assert_eq!(run.bits(i), clean.bits(i), "bristle {i}");
    }
    (outcomes, run.part(11, 12))
}

#[test]
fn non_finite_values_affect_no_neighbour_and_are_counted() {
    let reported = Outcome { not_finite: 1, first: Some(11) };
    let fine = Outcome { not_finite: 0, first: None };
    // Without viscous friction a curve has a finite value even at an infinite speed.
    let dry = specimens::stribeck(&Recipe { viscous: 0.0, ..Recipe::TABLE_2 }, 2.0);
    let dry = FrBd::new(dry, kelvin_voigt());
    let batches = [Batch::of(&friction::<f64>()).unwrap(), Batch::of(&dry).unwrap()];
    let nothings = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    for (batch, nothing) in batches.iter().flat_map(|b| nothings.map(|nothing| (b, nothing))) {
        let (outcomes, got) = spoilt(batch, |run| run.predicted[11] = nothing);
        assert_eq!(outcomes, [reported; 3]);
        assert!(got.share[0].is_nan() && got.bias[0].is_nan() && got.damping[0].is_nan());
        let (outcomes, got) = spoilt(batch, |run| run.before[11] = nothing);
        assert_eq!(outcomes, [reported; 3]);
        assert!(got.share[0].is_finite() && !got.bias[0].is_finite() && !got.after[0].is_finite());
        let (outcomes, got) = spoilt(batch, |run| run.mean[11] = nothing);
        assert_eq!(outcomes, [fine, reported, fine]);
        assert!(!got.after[0].is_finite() && got.held[0].is_finite());
        // A load that is none spoils the forces and leaves the deflection as it is.
        let (outcomes, got) = spoilt(batch, |run| run.load[11] = nothing);
        assert_eq!(outcomes, [reported, fine, reported]);
        assert!(!got.bias[0].is_finite() && got.after[0].is_finite() && got.held[0].is_finite());
    }
}

#[test]
fn no_normal_force_is_no_force_and_a_negative_one_is_reported() {
    let reported = Outcome { not_finite: 1, first: Some(11) };
    let batch = Batch::of(&friction::<f64>()).unwrap();
    let (outcomes, got) = spoilt(&batch, |run| run.load[11] = 0.0);
    assert!(outcomes.iter().all(Outcome::is_finite));
    assert_eq!((got.bias[0].abs(), got.damping[0], got.held_force[0].abs()), (0.0, 0.0, 0.0));
    // The deflection goes on.
    assert_ne!(got.after[0], got.before[0]);
    let (outcomes, got) = spoilt(&batch, |run| run.load[11] = -1e-9);
    assert_eq!((outcomes[0], outcomes[2]), (reported, reported));
    assert!(got.bias[0].is_nan() && got.damping[0].is_nan() && got.held_force[0].is_nan());
    // Where the stiffness stays, a load that is none spoils the end of a step too.
    let measured = batch.measured_at(2.0).unwrap();
    for nothing in [f64::NAN, f64::INFINITY, -1.0] {
        let (outcomes, got) = spoilt(&measured, |run| run.load[11] = nothing);
        assert_eq!(outcomes, [reported; 3]);
        assert!(got.bias[0].is_nan() && got.held_force[0].is_nan());
    }
}

#[test]
fn slices_of_other_lengths_are_refused_by_name_and_nothing_is_written() {
    let batch = Batch::of(&friction::<f64>()).unwrap();
    let names = ["normal_forces", "deflections", "shares", "biases", "dampings"];
    for (odd, name) in names.into_iter().enumerate() {
        let length = |k| if k == odd { 4 } else { 5 };
        let (load, mut z) = (vec![1.0; length(0)], vec![0.0; length(1)]);
        let mut out = [2, 3, 4].map(|k| vec![7.0; length(k)]);
        let [shares, biases, dampings] = &mut out;
        let refused = batch.companions(
            StepInput { velocities: &[0.1; 5], normal_forces: &load, deflections: &mut z },
            1e-3,
            PassiveOutput { shares, biases, dampings },
        );
        let want = BatchError::Length { name, length: 4, other: "velocities", expected: 5 };
        assert_eq!(refused, Err(want));
        assert!(out.iter().flatten().all(|&number| number == 7.0));
    }
    let mut z = [0.0; 3];
    let numbers = [1.0; 3];
    for (shares, velocities, normal_forces, text) in [
        (2, 3, 3, "shares has length 2, but velocities asks for 3"),
        (3, 3, 2, "normal_forces has length 2, but velocities asks for 3"),
        (2, 2, 2, "deflections has length 3, but velocities asks for 2"),
    ] {
        let [shares, velocities, normal_forces] =
            [shares, velocities, normal_forces].map(|length| &numbers[..length]);
        let found = CommitInput { shares, velocities, normal_forces };
        assert_eq!(batch.commit(found, 1e-3, &mut z).unwrap_err().to_string(), text);
    }
    for (name, lengths) in
        [("normal_forces", [2, 3, 3]), ("deflections", [3, 2, 3]), ("mean_forces", [3, 3, 2])]
    {
        let [load, mut z, mut force] = lengths.map(|length| vec![1.0; length]);
        let held = StepInput { velocities: &[0.1; 3], normal_forces: &load, deflections: &mut z };
        let refused = batch.hold(held, 1e-3, &mut force);
        let want = BatchError::Length { name, length: 2, other: "velocities", expected: 3 };
        assert_eq!(refused, Err(want));
    }
}

#[test]
fn a_bad_duration_is_refused() {
    let batch = Batch::of(&friction::<f64>()).unwrap();
    for duration in [-1e-3, f64::NAN, f64::INFINITY] {
        let found = CommitInput { shares: &[1.0], velocities: &[0.1], normal_forces: &[1.0] };
        let refused = batch.commit(found, duration, &mut [0.0]);
        assert!(matches!(refused, Err(BatchError::Parameter(error)) if error.name == "duration"));
    }
}

#[test]
fn parameters_out_of_range_are_refused_by_name_and_index() {
    let refused = Batch::<f64>::of(&FrBd::new(stribeck(1.5), kelvin_voigt())).unwrap_err();
    assert_eq!(refused.to_string(), "stribeck_exponent is 1.5, but must be 1 or 2 here");
    let may_be_zero = ["viscous_frictions", "micro_dampings"];
    let [viscous, damping] = may_be_zero;
    let names = [
        "static_coefficients",
        "dynamic_coefficients",
        "stribeck_velocities",
        viscous,
        "micro_stiffnesses",
        damping,
    ];
    let of = |values: &[Vec<f64>; 6]| {
        let mut out = [[0.0; 3]; 2];
        let [deflections, mean_forces] = &mut out;
        let held = StepInput { velocities: &[0.1; 3], normal_forces: &[1.0; 3], deflections };
        Batch::of_each(Fall::Rational, columns(values))?.hold(held, 1e-3, mean_forces)
    };
    let columns = PARAMETERS.map(|value| vec![value; 3]);
    assert!(of(&columns).unwrap().is_finite());
    for (k, name) in names.into_iter().enumerate() {
        for value in [f64::NAN, -1.0, f64::INFINITY] {
            let mut columns = columns.clone();
            columns[k][2] = value;
            let Err(BatchError::Parameter(error)) = of(&columns) else { panic!("{name} {value}") };
            assert_eq!((error.name, error.component), (name, Some(2)));
        }
        let mut columns = columns.clone();
        columns[k][2] = 0.0;
        let refused = of(&columns);
        if may_be_zero.contains(&name) {
            assert!(refused.is_ok(), "{name}");
        } else {
            let Err(BatchError::Parameter(error)) = refused else { panic!("{name}") };
            assert_eq!((error.name, error.component, error.value), (name, Some(2), 0.0));
        }
        columns[k].push(1.0);
        assert!(matches!(of(&columns), Err(BatchError::Length { .. })), "{name}");
    }
    let mut below = columns.clone();
    below[0][1] = 0.5;
    assert!(matches!(of(&below), Err(BatchError::Parameter(error)) if error.component == Some(1)));
    // Of one length, but not that of the step.
    let longer = columns.map(|column| [column, vec![1.5]].concat());
    let (name, other) = ("static_coefficients", "velocities");
    assert_eq!(of(&longer), Err(BatchError::Length { name, length: 4, other, expected: 3 }));
}

#[cfg(feature = "rayon")]
#[test]
fn several_threads_give_the_bits_and_the_report_of_one() {
    let batch = Batch::of(&friction::<f64>()).unwrap();
    let mut one = Run::<f64>::random(50_001);
    one.predicted[49_999] = f64::NAN;
    one.predicted[30_000] = f64::NAN;
    let mut several = one.clone();
    let outcomes = one.step(&batch, 1e-3);
    assert_eq!(outcomes[0], Outcome { not_finite: 2, first: Some(30_000) });
    assert_eq!(several.step(&batch.in_parallel(), 1e-3), outcomes);
    assert!((0..50_001).all(|i| one.bits(i) == several.bits(i)));
}
