//! Friction on several axes.

use bristle::Scalar;
use bristle::companion::PointMass;
use bristle::regularisation::SquareRoot;
use bristle_plane::{
    Axis, Footprint, FootprintPoint, PlaneBristle, PlaneCompanionStep, PlaneFrBd, PlaneLuGre,
};
use nalgebra::{SVector, Vector2, Vector3};

use crate::steps::{Answer, bristle, stribeck};
use crate::{Input, lit};

/// One step of each kind, and the answers beside them.
fn steps<T: Scalar, M: PlaneBristle<T, N>, const N: usize>(
    model: M,
    input: &Input<T>,
) -> Answer<T> {
    let &Input { duration, normal_force, fastest, mass, end_weight, .. } = input;
    let vector = |numbers: &[T]| {
        SVector::<T, N>::from_iterator(numbers.iter().copied().chain(core::iter::repeat(T::zero())))
    };
    let [velocities, next, ..] = &input.many;
    let (velocity, next) = (vector(velocities), vector(next));
    let mut contact = model.under_load(normal_force)?;
    let deflection = vector(&input.deflections);
    let reloaded = contact.reload(normal_force * lit(0.5), &velocity, &deflection)?;
    let turned = contact.turn(&reloaded.deflection, input.velocity);
    let z = turned.deflection;
    let (hold, linear) = (contact.hold(&velocity, &z, duration), contact.linearised(&velocity, &z));
    let under = contact.response_under(input.output[0], &velocity, &z);
    let mut sum = reloaded.dissipated + turned.supplied + under.rate.sum() + under.force.sum();
    sum += hold.deflection.sum() + hold.end_force.sum() + hold.mean_force.sum();
    sum += linear.rate.sum() + linear.force.sum() + linear.rate_by_velocity.sum();
    sum += linear.force_by_velocity.sum() + linear.rate_by_deflection.sum();
    sum += contact.stationary_force(&velocity).sum() + contact.stored_energy(&z);
    sum += contact.dissipated_power(&velocity, &z);
    if let Some(limits) = contact.model().limits(fastest).deflection {
        sum += limits.sum();
    }
    let step = contact.companion(fastest)?.step(&velocity, &z, duration);
    let mean = step.point_mass(PointMass {
        mass: SVector::repeat(mass),
        velocity,
        force: next,
        end_weight: SVector::repeat(end_weight),
    });
    let done = step.commit(&mean);
    sum += step.bias().sum() + step.damping().sum() + step.force(&next).sum();
    Ok(sum + done.deflection.sum() + done.work + done.stored + done.dissipated)
}

fn axes<T: Scalar, const N: usize>(input: &Input<T>) -> Answer<[Axis<T>; N]> {
    let mut axes = [Axis { friction_ratio: T::one(), bristle: bristle(input)? }; N];
    for (axis, [ratio, _]) in axes.iter_mut().zip(input.elements) {
        axis.friction_ratio = ratio;
    }
    Ok(axes)
}

pub(crate) fn frbd<T: Scalar>(input: &Input<T>) -> Answer<T> {
    let model = PlaneFrBd::<_, _, 2>::new(stribeck(input)?, axes(input)?)?;
    let root = SquareRoot::new(input.threshold_velocity)?;
    Ok(steps(model, input)? + steps(model.regularised(root), input)?)
}

pub(crate) fn spin<T: Scalar>(input: &Input<T>) -> Answer<T> {
    steps(PlaneFrBd::<_, _, 3>::new(stribeck(input)?, axes(input)?)?, input)
}

pub(crate) fn lugre<T: Scalar>(input: &Input<T>) -> Answer<T> {
    steps(PlaneLuGre::<_, _, 2>::classical(stribeck(input)?, axes(input)?)?, input)
}

pub(crate) fn footprint<T: Scalar>(input: &Input<T>) -> Answer<T> {
    let contact = PlaneFrBd::<_, _, 2>::new(stribeck(input)?, axes(input)?)?;
    let mut points = [FootprintPoint { place: [T::zero(); 2], weight: T::one() }; 7];
    for (point, &place) in points.iter_mut().zip(&input.knots) {
        point.place = place;
    }
    let footprint = Footprint::new(contact.under_load(input.normal_force)?, points)?;
    let mut deflections = [Vector2::zeros(); 7];
    for (z, column) in deflections.iter_mut().zip(&input.elements) {
        *z = Vector2::from(*column);
    }
    let twist = Vector3::new(input.velocity, input.next_velocity, input.time_constant);
    let mut sum = footprint.stationary_wrench(&twist).sum();
    sum += footprint.wrench(&twist, &deflections).sum() + footprint.stored_energy(&deflections);
    sum += footprint.hold(&twist, &mut deflections, input.duration)?.sum();
    let companion = footprint.companion(input.fastest)?;
    let mut kept = [PlaneCompanionStep::default(); 7];
    let step = companion.step(&twist, &deflections, input.duration, &mut kept)?;
    let done = companion.commit(&kept, &(twist * lit::<T>(0.5)), &mut deflections)?;
    sum += step.bias.sum() + step.damping.sum() + done.force.sum() + done.work;
    Ok(sum + done.stored + done.dissipated)
}
