//! Rolling contact without a grid, in memory that the caller owns.

use bristle::curve::Stribeck;
use bristle::rheology::KelvinVoigt;
use bristle::{FrBd, ParameterError, Scalar};
use bristle_rolling::{ExactPatch, Motion, Patch, PatchParameters, PolynomialExponential, Segment};

use crate::steps::{bristle, stribeck};
use crate::{Input, lit};

type Rolling<T> = ExactPatch<T, FrBd<Stribeck<T>, KelvinVoigt<T>>, 3, [Segment<T, 3>; 64]>;

fn rolling<T: Scalar>(input: &Input<T>) -> Result<Rolling<T>, ParameterError> {
    Patch::new(PatchParameters {
        model: FrBd::new(stribeck(input)?, bristle(input)?),
        length: input.threshold_velocity,
        pressure: PolynomialExponential::parabolic(),
    })?
    .under_load(input.normal_force)?
    .exact([[Segment::default(); 64]])
}

fn motion<T: Scalar>(input: &Input<T>) -> Motion<T> {
    Motion { slip_velocity: input.velocity, rolling_speed: input.rolling[0] }
}

/// Steps with velocities held.
pub(crate) fn step<T: Scalar>(input: &Input<T>) -> Result<T, ParameterError> {
    let mut rolling = rolling(input)?;
    rolling.settle(motion(input))?;
    let mut force = rolling.step(motion(input), input.duration)?;
    for slip_velocity in input.rolling {
        force += rolling.step(Motion { slip_velocity, ..motion(input) }, input.duration)?;
    }
    Ok(force + rolling.force(input.velocity))
}

/// A passive step.
pub(crate) fn passive<T: Scalar>(input: &Input<T>) -> Result<T, ParameterError> {
    let mut rolling = rolling(input)?;
    let slipped = rolling.reload(input.normal_force * lit(0.5), input.velocity)?;
    let renewed = rolling.renew(input.normal_force)?;
    let step = rolling.companion_step(motion(input), input.duration)?;
    let sum = step.bias() + step.damping() + slipped.dissipated + renewed.dissipated;
    Ok(sum + step.commit(input.next_velocity)?)
}
