//! Friction compensation: every compensator, built from parameters of run time and stepped over
//! many samples.

use bristle::control::{
    FeedForwardCompensator, FeedForwardParameters, FeedbackCompensator, FeedbackParameters,
    FrictionObserver, Injection, Measured, MicroDamping, ObserverParameters, OutputParameters,
    VelocityFromPosition, VelocityFromPositionParameters,
};
use bristle::{Bristle, FrBd, LuGre, Scalar};
use bristle_adaptation::{AdaptiveFriction, AdaptiveFrictionParameters, FrictionEstimate, Sample};

use crate::steps::{Answer, bristle, dahl_model, elasto_plastic_model, implicit_model, stribeck};
use crate::{Input, lit};

fn output<T: Scalar>(input: &Input<T>) -> OutputParameters<T> {
    let [share, largest_force] = input.output;
    OutputParameters { share, largest_force }
}

fn filter<T: Scalar>(input: &Input<T>) -> VelocityFromPositionParameters<T> {
    VelocityFromPositionParameters {
        sample_time: input.duration,
        time_constant: input.time_constant,
        fastest: input.fastest,
        count: input.duration,
    }
}

/// The velocity of an encoder, by positions and by displacements.
pub(crate) fn secant<T: Scalar>(input: &Input<T>) -> Answer<T> {
    let [positions, displacements, ..] = &input.many;
    let mut encoder = VelocityFromPosition::new(filter(input))?;
    let mut sum = T::zero();
    for (&position, &displacement) in positions.iter().zip(displacements) {
        for sample in [encoder.step(position), encoder.advance(displacement)] {
            sum += sample.map_or_else(T::one, |sample| sample.displacement + sample.velocity);
        }
    }
    encoder.reset();
    Ok(sum + encoder.velocity())
}

fn forward_of<T: Scalar, M: Bristle<T, Deflection = T>>(model: M, input: &Input<T>) -> Answer<T> {
    let mut compensator = FeedForwardCompensator::new(FeedForwardParameters {
        contact: model.under_load(input.normal_force)?,
        sample_time: input.duration,
        fastest: input.fastest,
        output: output(input),
    })?;
    let mut sum = T::zero();
    compensator.reload(input.normal_force * lit(0.5))?;
    for &velocity in &input.many[0] {
        let answer = compensator.step(velocity);
        sum += answer.force + answer.deflection;
    }
    compensator.reset();
    Ok(sum + compensator.step(input.velocity).force)
}

fn feedback_of<T: Scalar, M: Bristle<T, Deflection = T>>(model: M, input: &Input<T>) -> Answer<T> {
    let [positions, displacements, ..] = &input.many;
    let contact = model.under_load(input.normal_force)?;
    let mut sum = T::zero();
    for damping in [MicroDamping::Uncompensated, MicroDamping::Filtered] {
        let mut compensator = FeedbackCompensator::new(FeedbackParameters {
            contact: contact.clone(),
            velocity: filter(input),
            damping,
            output: output(input),
        })?;
        compensator.reload(input.normal_force * lit(0.5))?;
        for (&position, &displacement) in positions.iter().zip(displacements) {
            sum += compensator.step(position).force + compensator.advance(displacement).force;
        }
        sum += compensator.step_per_count(input.velocity).unwrap_or(T::zero());
        sum += compensator.velocity();
        compensator.reset();
    }
    Ok(sum)
}

fn observer_of<T: Scalar, M: Bristle<T, Deflection = T>>(model: M, input: &Input<T>) -> Answer<T> {
    let [positions, references, error_rates, ..] = &input.many;
    let [proportional_gain, derivative_gain, integral_gain, gain, corner] = input.gains;
    let contact = model.under_load(input.normal_force)?;
    let mut sum = T::zero();
    for injection in [Injection::Velocity { gain, corner }, Injection::Position { gain }] {
        let mut observer = FrictionObserver::new(ObserverParameters {
            contact: contact.clone(),
            mass: input.mass,
            proportional_gain,
            derivative_gain,
            integral_gain,
            injection,
            velocity: filter(input),
            output: output(input),
        })?;
        observer.reload(input.normal_force * lit(0.5))?;
        for ((&position, &reference), &error_rate) in
            positions.iter().zip(references).zip(error_rates)
        {
            sum += observer.step(position, reference).force;
            let measured = Measured { velocity: position, error: reference, error_rate };
            sum += observer.step_measured(measured).force + observer.deflection();
        }
        observer.reset();
    }
    Ok(sum)
}

/// A model whose estimate's error obeys the theorems: all three.
fn all<T: Scalar, M: Bristle<T, Deflection = T>>(model: M, input: &Input<T>) -> Answer<T> {
    let two = forward_of(model.clone(), input)? + feedback_of(model.clone(), input)?;
    Ok(two + observer_of(model, input)?)
}

pub(crate) fn feed_forward<T: Scalar>(input: &Input<T>) -> Answer<T> {
    forward_of(FrBd::new(stribeck(input)?, bristle(input)?), input)
}

pub(crate) fn feedback<T: Scalar>(input: &Input<T>) -> Answer<T> {
    feedback_of(FrBd::new(stribeck(input)?, bristle(input)?), input)
}

pub(crate) fn observer<T: Scalar>(input: &Input<T>) -> Answer<T> {
    observer_of(FrBd::new(stribeck(input)?, bristle(input)?), input)
}

pub(crate) fn lugre<T: Scalar>(input: &Input<T>) -> Answer<T> {
    all(LuGre::classical(stribeck(input)?, bristle(input)?), input)
}

pub(crate) fn dahl<T: Scalar>(input: &Input<T>) -> Answer<T> {
    all(dahl_model(input)?, input)
}

pub(crate) fn elasto_plastic<T: Scalar>(input: &Input<T>) -> Answer<T> {
    let model = elasto_plastic_model(input)?;
    Ok(forward_of(model, input)? + feedback_of(model, input)?)
}

pub(crate) fn implicit<T: Scalar>(input: &Input<T>) -> Answer<T> {
    let model = implicit_model(input)?;
    Ok(forward_of(model, input)? + feedback_of(model, input)?)
}

/// Friction that is followed, and its estimate handed to a compensator.
pub(crate) fn adaptation<T: Scalar>(input: &Input<T>) -> Answer<T> {
    let model = FrBd::new(stribeck(input)?, bristle(input)?);
    let [displacements, forces, loads, _] = &input.many;
    let [slowest, noise, memory, ..] = input.gains;
    let bounds = input.knots.map(|[idle_load, load_share]| FrictionEstimate {
        idle_load,
        load_share,
        drag: idle_load,
        offset: load_share,
    });
    let [start, least, most, ..] = bounds;
    let mut adaptive = AdaptiveFriction::new(AdaptiveFrictionParameters {
        model,
        mass: input.mass,
        sample_time: input.duration,
        corner: input.time_constant,
        slowest,
        fastest: input.fastest,
        noise,
        memory,
        start,
        least,
        most,
    })?;
    let given = |contact| FeedForwardParameters {
        contact,
        sample_time: input.duration,
        fastest: input.fastest,
        output: output(input),
    };
    let mut compensator =
        FeedForwardCompensator::new(given(model.under_load(input.normal_force)?))?;
    let mut sum = T::zero();
    for ((&displacement, &force), &load) in displacements.iter().zip(forces).zip(loads) {
        let estimate = adaptive.step(Sample { displacement, force, load }).estimate;
        compensator.change(given(model.under_load(estimate.normal_force(load))?))?;
        sum += compensator.step(input.velocity).force + estimate.beside(input.velocity);
    }
    Ok(sum + adaptive.deviation().drag)
}
