//! Models that a batch does not vectorise: the same steps, one by one.

use std::fmt::Debug;

use bristle::{AnyBristle, Bristle, FrBd, Surface};
use bristle_batch::{Batch, BatchError, Outcome, Real, Uniform};
use bristle_specimens::lit;
use bristle_specimens::specimens::{elasto_plastic, table_2_lugre};

use crate::loads::reloads_are_those_of_a_bristle;
use crate::{
    Run, Task, every_model, f, friction, kelvin_voigt, steps_are_those_of_a_bristle, stribeck,
};

/// What is stationary at the predicted velocity, and what is at rest.
fn of_prediction<T: Real>(
    model: &impl Bristle<T, Deflection = T>,
    predicted: Surface<T>,
    _: T,
) -> f64 {
    let rest = f(model.limits(T::zero()).deflection.unwrap());
    rest.max(f(model.stationary(predicted)).abs())
}

fn goes_one_by_one<T: Real>(model: &(impl Bristle<T, Deflection = T> + Sync)) {
    let mut run = Run::random(150);
    let batch = Batch::of_model(model).unwrap();
    steps_are_those_of_a_bristle(&batch, &run, of_prediction, |load| {
        model.clone().under_load(load).unwrap()
    });
    run.load.iter_mut().step_by(7).for_each(|load| *load = T::zero());
    let (batch, reference) = (batch.measured_at(lit(2.0)).unwrap(), lit(2.0));
    steps_are_those_of_a_bristle(&batch, &run, of_prediction, |load| {
        model.clone().under_load(load).unwrap().measured_at(reference).unwrap()
    });
}

struct OneByOne;

impl<T: Real> Task<T> for OneByOne {
    fn does<M: Uniform<T> + Bristle<T, Deflection = T> + Debug + Copy + Sync>(&self, model: M) {
        goes_one_by_one(&model);
    }
}

#[test]
fn a_model_of_its_own_takes_the_steps_of_its_coefficients() {
    every_model::<f64>(&OneByOne);
    every_model::<f32>(&OneByOne);
    let lugre = table_2_lugre::<f64>();
    goes_one_by_one(&lugre);
    goes_one_by_one(&AnyBristle::own(lugre));
    reloads_are_those_of_a_bristle(&Batch::of_model(&lugre).unwrap(), &lugre, 0.7);
    // An exponent that has no vectors.
    goes_one_by_one(&FrBd::new(stribeck::<f64>(1.5), kelvin_voigt()));
}

#[test]
fn a_model_whose_coefficients_depend_on_the_deflection_is_refused_by_its_name() {
    let elastic = elasto_plastic(stribeck::<f64>(2.0), kelvin_voigt(), 1e-5);
    let text = "a batch takes models whose coefficients depend on the velocity alone, not \
                elasto-plastic FrBD";
    assert_eq!(Batch::of_model(&elastic).unwrap_err().to_string(), text);
    assert_eq!(Batch::of_model(&AnyBristle::from(elastic)).unwrap_err().to_string(), text);
    let model = friction::<f64>();
    let refused = Batch::of_model(&model).unwrap().isotropic::<2>().unwrap_err();
    assert!(matches!(refused, BatchError::Parameter(error) if error.name == "a model of its own"));
}

#[test]
fn what_is_not_finite_affects_no_neighbour() {
    let lugre = table_2_lugre::<f64>();
    let batch = Batch::of_model(&lugre).unwrap();
    let reported = Outcome { not_finite: 1, first: Some(11) };
    let (outcomes, got) = crate::spoilt(&batch, |run| run.predicted[11] = f64::NAN);
    assert_eq!(outcomes, [reported; 3]);
    assert!(got.share[0].is_nan() && got.bias[0].is_nan() && got.after[0].is_nan());
    let (outcomes, got) = crate::spoilt(&batch, |run| run.load[11] = -1.0);
    assert_eq!((outcomes[0], outcomes[2]), (reported, reported));
    assert!(got.bias[0].is_nan() && got.after[0].is_finite() && got.held[0].is_finite());
}

#[cfg(feature = "rayon")]
#[test]
fn several_threads_give_the_bits_of_one() {
    let lugre = table_2_lugre::<f64>();
    let batch = Batch::of_model(&lugre).unwrap();
    let mut one = Run::<f64>::random(10_001);
    let mut several = one.clone();
    assert_eq!(one.step(&batch, 1e-3), several.step(&batch.in_parallel(), 1e-3));
    assert_eq!(one, several);
}
