//! Batches of many bristles, in slices of a length known at run time.

use bristle::FrBd;
use bristle::curve::{RationalStribeck, RationalStribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle_batch::{
    Batch, BatchError, Columns, CommitInput, Fall, PassiveOutput, Real, ReloadInput, StepInput,
    Uniform,
};

use crate::steps::{bristle, coulomb, dahl_model, stribeck};
use crate::{Input, MANY};

type Answer<T> = Result<T, BatchError>;

/// Every step of a batch: whole blocks and what is left over.
fn steps<T: Real>(batch: Batch<'_, T>, input: &Input<T>) -> Answer<T> {
    let length = input.count;
    let part = |column: usize| {
        input.many.get(column).and_then(|values| values.get(..length)).unwrap_or_default()
    };
    let (velocities, normal_forces, deflections) = (part(0), part(1), part(2));
    let mut room = [[T::zero(); MANY]; 5];
    let [shares, biases, dampings, after, mean_forces] =
        room.each_mut().map(|values| values.get_mut(..length).unwrap_or_default());
    after.iter_mut().zip(deflections).for_each(|(to, from)| *to = *from);
    let loads = ReloadInput { before: normal_forces, after: part(3), velocities };
    let reloaded = batch.reload(loads, after, mean_forces)?;
    let begun = batch.companions(
        StepInput { velocities, normal_forces, deflections: &mut *after },
        input.duration,
        PassiveOutput { shares: &mut *shares, biases: &mut *biases, dampings: &mut *dampings },
    )?;
    let found = CommitInput { shares: &*shares, velocities: part(3), normal_forces };
    let ended = batch.commit(found, input.duration, after)?;
    let held = StepInput { velocities, normal_forces, deflections: after };
    let held = batch.hold(held, input.duration, mean_forces)?;
    let mut sum = T::zero();
    for outcome in [reloaded, begun, ended, held] {
        if outcome.is_finite() && outcome.first.is_none() {
            sum += T::one();
        }
    }
    Ok(room.iter().flatten().fold(sum, |sum, &value| sum + value))
}

fn uniform<T: Real>(model: &impl Uniform<T>, input: &Input<T>) -> Answer<T> {
    steps(Batch::of(model)?, input)
}

/// With an exponent of 1, of 2, or refused.
pub(crate) fn stribeck_curve<T: Real>(input: &Input<T>) -> Answer<T> {
    uniform(&FrBd::new(stribeck(input)?, bristle(input)?), input)
}

pub(crate) fn rational<T: Real>(input: &Input<T>) -> Answer<T> {
    let curve = RationalStribeck::new(RationalStribeckParameters {
        static_coefficient: input.static_coefficient,
        dynamic_coefficient: input.dynamic_coefficient,
        stribeck_velocity: input.stribeck_velocity,
        viscous_friction: input.viscous_friction,
    })?;
    uniform(&FrBd::new(curve, bristle(input)?), input)
}

pub(crate) fn spring<T: Real>(input: &Input<T>) -> Answer<T> {
    let spring = KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness: input.micro_stiffness,
        micro_damping: T::zero(),
    })?;
    uniform(&FrBd::new(coulomb(input)?, spring), input)
}

pub(crate) fn dahl<T: Real>(input: &Input<T>) -> Answer<T> {
    uniform(&dahl_model(input)?, input)
}

/// Parameters of each bristle.
pub(crate) fn each<T: Real>(input: &Input<T>) -> Answer<T> {
    let column = |number: usize| {
        input.columns.get(number).and_then(|values| values.get(..input.count)).unwrap_or_default()
    };
    let mut sum = T::zero();
    for fall in [Fall::Exponential, Fall::Gaussian, Fall::Rational] {
        let columns = Columns {
            static_coefficients: column(0),
            dynamic_coefficients: column(1),
            stribeck_velocities: column(2),
            viscous_frictions: column(3),
            micro_stiffnesses: column(4),
            // Of a length that may be another.
            micro_dampings: &input.columns[5],
        };
        sum += steps(Batch::of_each(fall, columns)?, input)?;
    }
    Ok(sum)
}
