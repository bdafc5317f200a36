//! A stiffness that stays while the load varies: the change of the load is that of a contact, equal
//! loads change no bit, and what is none is reported.

use std::fmt::Debug;

use bristle::Bristle;
use bristle_batch::{
    Batch, BatchError, CommitInput, Outcome, Real, ReloadInput, RenewInput, StepInput, Uniform,
};
use bristle_specimens::draw::Draw;
use bristle_specimens::specimens::table_2_lugre;
use bristle_specimens::{assert_within, lit};

use crate::{Run, Task, every_model, f, friction};

struct Reloads;

impl<T: Real> Task<T> for Reloads {
    fn does<M: Uniform<T> + Bristle<T, Deflection = T> + Debug + Copy + Sync>(&self, model: M) {
        reloads_are_those_of_a_bristle(&Batch::of(&model).unwrap(), &model);
        reloads_are_those_of_a_bristle(&Batch::of_model(&model).unwrap(), &model);
    }
}

pub(crate) fn reloads_are_those_of_a_bristle<T: Real, M: Bristle<T, Deflection = T>>(
    batch: &Batch<'_, T>,
    model: &M,
) {
    let (mut run, mut draw) = (Run::<T>::random(300), Draw(7));
    let reference = [(); 300].map(|()| lit(draw.logarithmic(1e-2, 1e2)));
    let after = run.load.clone().into_iter().map(|load| match draw.next() {
        share if share < 0.1 => T::zero(),
        share if share < 0.2 => load,
        _ => load * lit(draw.logarithmic(1e-3, 10.0)),
    });
    let after: Vec<T> = after.collect();
    run.after.copy_from_slice(&run.before);
    let batch = batch.measured_at_each(&reference).unwrap();
    let change = ReloadInput { before: &run.load, after: &after, velocities: &run.predicted };
    let outcome = batch.reload(change, &mut run.after, &mut run.bias).unwrap();
    assert!(outcome.is_finite());
    let mut cut = 0;
    for i in 0..300 {
        let contact = model.clone().under_load(run.load[i]).unwrap();
        let mut contact = contact.measured_at(reference[i]).unwrap();
        let stored = f(contact.stored_energy(run.before[i]));
        let want = contact.reload(after[i], run.predicted[i], run.before[i]).unwrap();
        let (z, left) = (f(want.deflection), f(want.dissipated));
        let what = || format!("{i}: {} to {} N, {contact:?}", run.load[i], after[i]);
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
    let (mut other, mut third) = (one.clone(), one.clone());
    let _ = one.step(&batch, lit(1e-3));
    let references = other.load.clone();
    let _ = other.step(&batch.measured_at_each(&references).unwrap(), lit(1e-3));
    assert_eq!(one, other);
    // Nor whether a reference load is shared.
    let references = [lit(0.7); 67];
    let _ = other.step(&batch.measured_at_each(&references).unwrap(), lit(1e-3));
    let _ = third.step(&batch.measured_at(lit(0.7)).unwrap(), lit(1e-3));
    assert_eq!(other, third);
    assert_ne!(one, third);
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
fn a_change_of_the_load_that_does_not_go_with_the_stiffness_is_refused() {
    let batch = Batch::of(&friction::<f64>()).unwrap();
    let measured = batch.measured_at(2.0).unwrap();
    let loads = ReloadInput { before: &[1.0], after: &[1.0], velocities: &[0.0] };
    assert_eq!(
        batch.reload(loads, &mut [0.0], &mut [0.0]).unwrap_err().to_string(),
        "a reload takes Batch::measured_at, not a stiffness that follows the load"
    );
    let loads = RenewInput { before: &[1.0], after: &[1.0] };
    assert_eq!(
        measured.renew(loads, &mut [0.0], &mut [0.0]).unwrap_err().to_string(),
        "a renewal takes a stiffness that follows the load, not Batch::measured_at"
    );
    for load in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let Err(BatchError::Parameter(error)) = batch.measured_at(load) else { panic!("{load}") };
        assert_eq!(error.name, "reference_load");
        let loads = [1.0, load];
        let refused = batch.measured_at_each(&loads);
        let Err(BatchError::Parameter(error)) = refused else { panic!("{load}") };
        assert_eq!((error.name, error.component), ("reference_loads", Some(1)));
    }
    // As many as there are bristles.
    let three = batch.measured_at_each(&[1.0; 3]).unwrap();
    let mut z = [0.0; 2];
    let input = StepInput { velocities: &[0.1; 2], normal_forces: &[1.0; 2], deflections: &mut z };
    let text = "reference_loads has length 3, but velocities asks for 2";
    assert_eq!(three.hold(input, 1e-3, &mut [0.0; 2]).unwrap_err().to_string(), text);
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
