//! A stiffness that stays while the load varies: the change of the load is that of a contact, equal
//! loads change no bit, and what is none is reported.

use std::fmt::Debug;

use bristle::Bristle;
use bristle_batch::{
    Batch, BatchError, Columns, CommitInput, Fall, Outcome, Real, ReloadInput, StepInput, Uniform,
};
use bristle_specimens::draw::Draw;
use bristle_specimens::specimens::table_2_lugre;
use bristle_specimens::{assert_within, lit};

use crate::{Run, Task, every_model, f, friction};

struct Reloads;

impl<T: Real> Task<T> for Reloads {
    fn does<M: Uniform<T> + Bristle<T, Deflection = T> + Debug + Copy + Sync>(&self, model: M) {
        for reference in [1e-2, 1.0, 1e2] {
            let reference = lit(reference);
            reloads_are_those_of_a_bristle(&Batch::of(&model).unwrap(), &model, reference);
            reloads_are_those_of_a_bristle(&Batch::of_model(&model).unwrap(), &model, reference);
        }
    }
}

pub(crate) fn reloads_are_those_of_a_bristle<T: Real, M: Bristle<T, Deflection = T>>(
    batch: &Batch<'_, T>,
    model: &M,
    reference: T,
) {
    let (mut run, mut draw) = (Run::<T>::random(300), Draw(7));
    let after = run.load.clone().into_iter().map(|load| match draw.next() {
        share if share < 0.1 => T::zero(),
        share if share < 0.2 => load,
        _ => load * lit(draw.logarithmic(1e-3, 10.0)),
    });
    let after: Vec<T> = after.collect();
    run.after.copy_from_slice(&run.before);
    let batch = batch.measured_at(reference).unwrap();
    let change = ReloadInput { before: &run.load, after: &after, velocities: &run.predicted };
    let outcome = batch.reload(change, &mut run.after, &mut run.bias).unwrap();
    assert!(outcome.is_finite());
    let mut cut = 0;
    for (i, &after) in after.iter().enumerate() {
        let contact = model.clone().under_load(run.load[i]).unwrap();
        let mut contact = contact.measured_at(reference).unwrap();
        let stored = f(contact.stored_energy(run.before[i]));
        let want = contact.reload(after, run.predicted[i], run.before[i]).unwrap();
        let (z, left) = (f(want.deflection), f(want.dissipated));
        let what = || format!("{i}: {} to {} N, {contact:?}", run.load[i], after);
        // Some ten roundings, and two of the exponential.
        let rounding = 16.0 * f(T::default_epsilon());
        assert_within(rounding, f(run.before[i]).abs(), f(run.after[i]), z, what);
        assert_within(rounding, stored, f(run.bias[i]), left, what);
        cut += u32::from(z != f(run.before[i]) && z != 0.0);
    }
    assert!(cut > 20, "{cut} slipped");
}

#[test]
fn a_reload_is_that_of_one_bristle() {
    every_model::<f64>(&Reloads);
    every_model::<f32>(&Reloads);
}

#[test]
fn what_has_no_load_has_no_deflection_and_what_is_no_load_is_reported() {
    let batch = Batch::of(&friction::<f64>()).unwrap().measured_at(2.0).unwrap();
    let (mut z, mut left) = ([1e-5; 8], [0.0; 8]);
    let [before, after] = &crate::NO_LOADS;
    let loads = ReloadInput { before, after, velocities: &[0.1; 8] };
    let outcome = batch.reload(loads, &mut z, &mut left).unwrap();
    assert_eq!(z, [0.0; 8]);
    assert_eq!(left[..3], [0.0, 0.5 * 2.0 * (1e4 * 1e-5 * 1e-5), 0.0]);
    assert_eq!(outcome, Outcome { not_finite: 5, first: Some(3) });
    // A velocity matters only where the load falls below what is carried.
    let (mut z, mut left) = ([1e-4; 3], [0.0; 3]);
    let loads =
        ReloadInput { before: &[2.0; 3], after: &[2.0, 4.0, 0.1], velocities: &[f64::NAN; 3] };
    let outcome = batch.reload(loads, &mut z, &mut left).unwrap();
    assert_eq!((z[0], z[1], z[2].is_nan()), (1e-4, 1e-4, true));
    assert_eq!(outcome, Outcome { not_finite: 1, first: Some(2) });
}

fn equal_loads_change_no_bit<T: Real>() {
    let batch = Batch::of(&friction::<T>()).unwrap();
    let mut one = Run::<T>::random(67);
    one.load.fill(lit(0.7));
    let (mut other, mut third) = (one.clone(), one.clone());
    let _ = one.step(&batch, lit(1e-3));
    let _ = other.step(&batch.measured_at(lit(0.7)).unwrap(), lit(1e-3));
    assert_eq!(one, other);
    let _ = third.step(&batch.measured_at(lit(0.8)).unwrap(), lit(1e-3));
    assert_ne!(one, third);
}

/// Reference loads Pᵢ of each bristle are those of σ0 Pᵢ/P and σ1 Pᵢ/P, under one P.
#[test]
fn a_reference_load_only_scales_stiffness_and_damping() {
    let (curve, bristle) = (crate::stribeck(2.0), crate::kelvin_voigt::<f64>().parameters());
    let references = [0.5, 1.0, 3.0, 20.0];
    let stiffnesses = references.map(|reference| bristle.micro_stiffness * reference / 2.0);
    let dampings = references.map(|reference| bristle.micro_damping * reference / 2.0);
    let curve = curve.parameters();
    let columns = Columns {
        static_coefficients: &[curve.static_coefficient; 4],
        dynamic_coefficients: &[curve.dynamic_coefficient; 4],
        stribeck_velocities: &[curve.stribeck_velocity; 4],
        viscous_frictions: &[curve.viscous_friction; 4],
        micro_stiffnesses: &stiffnesses,
        micro_dampings: &dampings,
    };
    let mut all = Run::<f64>::random(4);
    let each = Batch::of_each(Fall::Gaussian, columns).unwrap().measured_at(2.0).unwrap();
    let _ = all.step(&each, 1e-3);
    let model = friction::<f64>();
    for (i, reference) in references.into_iter().enumerate() {
        let mut one = Run::<f64>::random(4);
        let _ = one.step(&Batch::of(&model).unwrap().measured_at(reference).unwrap(), 1e-3);
        for (got, want) in all.columns().into_iter().zip(one.columns()) {
            // Some twenty roundings.
            assert_within(1e-14, want[i].abs(), got[i], want[i], || format!("{i}"));
        }
    }
}

#[test]
fn normal_forces_that_are_the_reference_loads_give_the_bits_of_none() {
    equal_loads_change_no_bit::<f64>();
    equal_loads_change_no_bit::<f32>();
}

/// A part in a grip that trembles: at rest it keeps its place to the last bit, however often.
#[test]
fn a_load_that_varies_moves_nothing_that_is_held() {
    let grip = Batch::of(&friction::<f64>()).unwrap().measured_at(2.0).unwrap();
    let mut z = [5e-5; 40];
    for step in 0..1000 {
        let load = |step: i32| 2.0 + f64::from(step % 7) / 7.0;
        let (before, after) = ([load(step); 40], [load(step + 1); 40]);
        let change = ReloadInput { before: &before, after: &after, velocities: &[0.0; 40] };
        assert!(grip.reload(change, &mut z, &mut [0.0; 40]).unwrap().is_finite());
        let input =
            StepInput { velocities: &[0.0; 40], normal_forces: &after, deflections: &mut z };
        let mut forces = [0.0; 40];
        assert!(grip.hold(input, 1e-3, &mut forces).unwrap().is_finite());
        assert!((forces[39] - 2.0 * 1e4 * 5e-5).abs() < 1e-15);
        let found =
            CommitInput { shares: &[1.0; 40], velocities: &[0.0; 40], normal_forces: &after };
        assert!(grip.commit(found, 1e-3, &mut z).unwrap().is_finite());
    }
    assert_eq!(z, [5e-5; 40]);
}

#[test]
fn a_reload_of_a_stiffness_that_follows_the_load_is_refused() {
    let batch = Batch::of(&friction::<f64>()).unwrap();
    let measured = batch.measured_at(2.0).unwrap();
    let loads = ReloadInput { before: &[1.0], after: &[1.0], velocities: &[0.0] };
    assert_eq!(
        batch.reload(loads, &mut [0.0], &mut [0.0]).unwrap_err().to_string(),
        "a reload takes Batch::measured_at, not a stiffness that follows the load"
    );
    for load in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let Err(BatchError::Parameter(error)) = batch.measured_at(load) else { panic!("{load}") };
        assert_eq!(error.name, "reference_load");
    }
    let short = ReloadInput { before: &[1.0], after: &[1.0], velocities: &[0.0; 2] };
    let refused = measured.reload(short, &mut [0.0], &mut [0.0]).unwrap_err();
    assert!(matches!(refused, BatchError::Length { name: "velocities", length: 2, .. }));
}

#[test]
fn no_step_and_no_change_of_the_load_allocates() {
    let (own, lugre) = (friction::<f64>(), table_2_lugre::<f64>());
    let batches = [Batch::of(&own), Batch::of_model(&own), Batch::of_model(&lugre)];
    for batch in batches.map(Result::unwrap) {
        let measured = batch.measured_at(2.0).unwrap();
        let mut run = Run::<f64>::random(1001);
        let (mut z, mut left, velocities) = ([1e-4; 99], [0.0; 99], [0.1; 99]);
        let counted = allocation_counter::measure(|| {
            let _ = run.step(&batch, 1e-3);
            let change =
                ReloadInput { before: &[2.0; 99], after: &[0.1; 99], velocities: &velocities };
            let _ = measured.reload(change, &mut z, &mut left);
        });
        assert_eq!((counted.count_total, z[98] < 1e-4), (0, true));
    }
}
