//! Lumped friction: every curve, bristle and model, built from parameters of run time and stepped.

use bristle::companion::{PointMass, Prediction, VelocityHistory};
use bristle::curve::{
    Asymmetric, Coulomb, CoulombParameters, FrictionCurve, FunctionCurve, Knot, RationalStribeck,
    RationalStribeckParameters, Stribeck, StribeckParameters, Tabulated,
};
use bristle::exponential::Exponential;
use bristle::regularisation::{HyperbolicTangent, SquareRoot, Unregularised};
use bristle::rheology::{
    Deflection, GeneralisedMaxwell, GeneralisedMaxwellParameters, KelvinVoigt,
    KelvinVoigtParameters, Maxwell, MaxwellArm, MaxwellParameters, Rheology, ZenerParameters,
};
use bristle::{
    Bounds, Bristle, Contact, Dahl, DahlParameters, ElastoPlastic, FrBd, ImplicitBristle, LuGre,
    ParameterError, Scalar,
};
use bristle_joint::{GearFriction, GearFrictionParameters, TorqueLoad, TorqueLoadParameters};
use bristle_joint::{
    GearedJoint, GearedJointParameters, Gravity, JointState, VoltageMotor, VoltageMotorParameters,
};
use nalgebra::SVector;

use crate::{Input, lit};

pub(crate) type Answer<T> = Result<T, ParameterError>;

/// One step of each kind for any state, and the answers beside them.
fn steps<T: Scalar, M: Bristle<T>>(
    model: M,
    deflection: M::Deflection,
    input: &Input<T>,
) -> Answer<(Contact<T, M>, T)> {
    let &Input { velocity, next_velocity, duration, normal_force, fastest, .. } = input;
    let one = M::Deflection::fill(T::one());
    let mut contact = model.under_load(normal_force)?;
    let reloaded = contact.reload(normal_force * lit(0.5), velocity, deflection)?;
    let deflection = reloaded.deflection;
    let under = contact.response_under(input.output[1], velocity, deflection);
    let hold = contact.hold(velocity, deflection, duration);
    let response = contact.response(velocity, deflection);
    let linear = contact.linearised(velocity, deflection);
    let mut sum =
        reloaded.dissipated + hold.end_force + hold.mean_force + hold.deflection.inner_product(one);
    sum += response.force + response.rate.inner_product(one);
    sum += under.force + under.rate.inner_product(one);
    sum += linear.force_by_velocity + linear.force_by_deflection.inner_product(one);
    sum += contact.stationary_force(velocity) + contact.stationary(velocity).inner_product(one);
    sum += contact.stored_energy(deflection) + contact.dissipated_power(velocity, deflection);
    let limits = contact.limits(fastest);
    sum += limits.force.unwrap_or(T::zero()) + limits.deflection.unwrap_or(T::zero());

    let mut history = VelocityHistory::new(velocity);
    history.push(next_velocity);
    let mut companion = contact.clone().companion(fastest)?;
    let step = companion.step(history.predict(), hold.deflection, duration);
    let done = step.commit(next_velocity);
    sum +=
        step.bias() + step.damping() + done.deflection.inner_product(one) + done.force + done.work;
    sum += done.stored + done.dissipated;
    if step.is_passive() {
        sum += T::one();
    }
    // A free mass, with the coefficients frozen in the middle.
    let middle = hold.deflection + (one * velocity) * (duration * lit(0.5));
    let step = companion.step_about(
        Prediction { velocity: next_velocity, deflection: middle },
        hold.deflection,
        duration,
    );
    let &Input { mass, end_weight, .. } = input;
    let body = PointMass { mass, velocity, force: normal_force, end_weight };
    let mean = step.point_mass(body);
    sum += step.commit(mean).dissipated + step.target_velocity().unwrap_or(T::zero());
    let lighter = companion.reload(input.output[1], next_velocity, deflection)?;
    let renewed = companion.renew(normal_force, lighter.deflection)?;
    sum += lighter.deflection.inner_product(one) + lighter.dissipated;
    sum += renewed.deflection.inner_product(one) + renewed.dissipated;
    Ok((contact, sum))
}

/// The same with the exponential steps, for a bristle of one spring.
fn scalar<T: Scalar, M: Bristle<T, Deflection = T>>(model: M, input: &Input<T>) -> Answer<T> {
    let [deflection, ..] = input.deflections;
    let &Input { velocity: from, next_velocity: to, duration, .. } = input;
    let (contact, mut sum) = steps(model, deflection, input)?;
    let ramp = Exponential::<3>.ramp(&contact, from..to, deflection, duration);
    sum += ramp.deflection + ramp.end + ramp.mean + ramp.work;
    let smooth = |part: T| from + (to - from) * part * part;
    let step = Exponential::<3>.step(&contact, smooth, deflection, duration);
    Ok(sum + step.deflection + step.end + step.mean + step.work + gear(contact, input)?)
}

/// A step of a gear and of a joint, with the load of another one.
fn gear<T: Scalar, M: Bristle<T, Deflection = T>>(
    contact: Contact<T, M>,
    input: &Input<T>,
) -> Answer<T> {
    let &Input { velocity, duration, normal_force, fastest, mass, .. } = input;
    let load = TorqueLoad::new(TorqueLoadParameters {
        idle_load: normal_force,
        motor_share: T::one(),
        external_share: lit(0.5),
    })?;
    let friction = contact.model().clone();
    let reference_load = normal_force;
    let gear = GearFrictionParameters { friction, load, reference_load, drag: mass, fastest };
    let mut gear = GearFriction::new(gear)?;
    gear.set_friction_scale(lit(0.5))?;
    let motor = VoltageMotor::new(VoltageMotorParameters {
        voltage: velocity,
        torque_constant: mass,
        resistance: mass,
        largest_voltage: Some(fastest),
        largest_current: None,
    })?;
    let external = Gravity { horizontal_torque: normal_force, hanging_angle: velocity };
    let parameters = GearedJointParameters { gear, inertia: mass, motor, external };
    let joint = GearedJoint::new(parameters)?;
    let (state, done) = joint.step(&JointState::at_rest(velocity), duration)?;
    Ok(state.velocity + state.deflection + done.dissipated)
}

fn springs<T: Scalar, const N: usize, M: Bristle<T, Deflection = SVector<T, N>>>(
    model: M,
    input: &Input<T>,
) -> Answer<T> {
    let deflection = SVector::from_iterator(input.deflections.iter().copied().cycle().take(N));
    Ok(steps(model, deflection, input)?.1)
}

pub(crate) fn stribeck<T: Scalar>(input: &Input<T>) -> Answer<Stribeck<T>> {
    Stribeck::new(StribeckParameters {
        static_coefficient: input.static_coefficient,
        dynamic_coefficient: input.dynamic_coefficient,
        stribeck_velocity: input.stribeck_velocity,
        stribeck_exponent: input.stribeck_exponent,
        viscous_friction: input.viscous_friction,
    })
}

pub(crate) fn coulomb<T: Scalar>(input: &Input<T>) -> Answer<Coulomb<T>> {
    Coulomb::new(CoulombParameters {
        dynamic_coefficient: input.dynamic_coefficient,
        viscous_friction: input.viscous_friction,
    })
}

pub(crate) fn bristle<T: Scalar>(input: &Input<T>) -> Answer<KelvinVoigt<T>> {
    KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness: input.micro_stiffness,
        micro_damping: input.micro_damping,
    })
}

fn frbd<T: Scalar, C: FrictionCurve<T>>(curve: C, input: &Input<T>) -> Answer<T> {
    scalar(FrBd::new(curve, bristle(input)?), input)
}

fn on<T: Scalar, R: Rheology<T>>(bristle: R, input: &Input<T>) -> Answer<FrBd<Stribeck<T>, R>> {
    Ok(FrBd::new(stribeck(input)?, bristle))
}

pub(crate) fn frbd_stribeck<T: Scalar>(input: &Input<T>) -> Answer<T> {
    frbd(stribeck(input)?, input)
}

pub(crate) fn frbd_rational<T: Scalar>(input: &Input<T>) -> Answer<T> {
    let curve = RationalStribeck::new(RationalStribeckParameters {
        static_coefficient: input.static_coefficient,
        dynamic_coefficient: input.dynamic_coefficient,
        stribeck_velocity: input.stribeck_velocity,
        viscous_friction: input.viscous_friction,
    })?;
    frbd(curve, input)
}

pub(crate) fn frbd_tabulated<T: Scalar>(input: &Input<T>) -> Answer<T> {
    let knots = input.knots.map(|[speed, coefficient]| Knot { speed, coefficient });
    let curve = Tabulated::new(knots)?;
    Ok(frbd(curve, input)? + curve.least_slope().unwrap_or(T::zero()))
}

pub(crate) fn frbd_coulomb<T: Scalar>(input: &Input<T>) -> Answer<T> {
    frbd(coulomb(input)?, input)
}

pub(crate) fn frbd_asymmetric<T: Scalar>(input: &Input<T>) -> Answer<T> {
    frbd(Asymmetric { forward: stribeck(input)?, backward: coulomb(input)? }, input)
}

pub(crate) fn frbd_function<T: Scalar>(input: &Input<T>) -> Answer<T> {
    let (level, fall) = (input.dynamic_coefficient, input.viscous_friction);
    let bounds = Bounds { min: level, max: input.static_coefficient };
    let function = move |speed: T| {
        let part = T::one() / (T::one() + speed * speed);
        (level + fall * part, -fall * speed * part * part)
    };
    frbd(FunctionCurve::new(function, bounds)?, input)
}

pub(crate) fn frbd_spring<T: Scalar>(input: &Input<T>) -> Answer<T> {
    let spring = KelvinVoigt::new(KelvinVoigtParameters {
        micro_stiffness: input.micro_stiffness,
        micro_damping: T::zero(),
    })?;
    scalar(on(spring, input)?, input)
}

pub(crate) fn frbd_square_root<T: Scalar>(input: &Input<T>) -> Answer<T> {
    let regularisation = SquareRoot::new(input.threshold_velocity)?;
    scalar(on(bristle(input)?, input)?.regularised(regularisation), input)
}

pub(crate) fn frbd_tanh<T: Scalar>(input: &Input<T>) -> Answer<T> {
    let regularisation = HyperbolicTangent::new(input.threshold_velocity)?;
    scalar(on(bristle(input)?, input)?.regularised(regularisation), input)
}

pub(crate) fn frbd_maxwell<T: Scalar>(input: &Input<T>) -> Answer<T> {
    let [[micro_stiffness, series_damping], ..] = input.elements;
    scalar(on(Maxwell::new(MaxwellParameters { micro_stiffness, series_damping })?, input)?, input)
}

pub(crate) fn frbd_zener<T: Scalar>(input: &Input<T>) -> Answer<T> {
    let [[relaxing_stiffness, series_damping], ..] = input.elements;
    let bristle = GeneralisedMaxwell::zener(ZenerParameters {
        static_stiffness: input.micro_stiffness,
        relaxing_stiffness,
        series_damping,
    })?;
    springs(on(bristle, input)?, input)
}

pub(crate) fn frbd_maxwell_arms<T: Scalar>(input: &Input<T>) -> Answer<T> {
    let arms = input.elements.map(|[stiffness, damping]| MaxwellArm {
        stiffness,
        series_damping: (damping > T::zero()).then_some(damping),
    });
    let bristle = GeneralisedMaxwell::new(GeneralisedMaxwellParameters {
        arms,
        micro_damping: input.micro_damping,
    })?;
    springs(on(bristle, input)?, input)
}

pub(crate) fn lugre<T: Scalar>(input: &Input<T>) -> Answer<T> {
    scalar(LuGre::classical(stribeck(input)?, bristle(input)?), input)
}

pub(crate) fn lugre_inside<T: Scalar>(input: &Input<T>) -> Answer<T> {
    scalar(LuGre::with_viscous_friction(stribeck(input)?, bristle(input)?, T::zero())?, input)
}

pub(crate) fn dahl_model<T: Scalar>(input: &Input<T>) -> Answer<Dahl<T>> {
    Dahl::new(DahlParameters {
        dynamic_coefficient: input.dynamic_coefficient,
        micro_stiffness: input.micro_stiffness,
    })
}

pub(crate) fn dahl<T: Scalar>(input: &Input<T>) -> Answer<T> {
    scalar(dahl_model(input)?, input)
}

pub(crate) fn elasto_plastic_model<T: Scalar>(
    input: &Input<T>,
) -> Answer<ElastoPlastic<Stribeck<T>, KelvinVoigt<T>, Unregularised, T>> {
    ElastoPlastic::new(stribeck(input)?, bristle(input)?, input.stick_limit)
}

pub(crate) fn elasto_plastic<T: Scalar>(input: &Input<T>) -> Answer<T> {
    scalar(elasto_plastic_model(input)?, input)
}

pub(crate) fn implicit_model<T: Scalar>(
    input: &Input<T>,
) -> Answer<ImplicitBristle<Stribeck<T>, T>> {
    ImplicitBristle::new(stribeck(input)?, bristle(input)?)
}

pub(crate) fn implicit<T: Scalar>(input: &Input<T>) -> Answer<T> {
    scalar(implicit_model(input)?, input)
}
