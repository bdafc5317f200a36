//! `ode_solvers` 0.6: Dormand–Prince 5(4) and 8(5,3) on statically sized nalgebra vectors.
//!
//! - One absolute tolerance for all components: it integrates x/scales.
//! - Dense output on a uniform grid. Its last row is extrapolated from the step before the one
//!   that contains it, so the run goes half a sample further and that row is never asked for.
//! - `Dop853` evaluates its twelfth stage at t instead of t + h (its table has c₁₂ = 0), which
//!   spoils every system that depends on time. It gets the time as one more state.
//! - No fresh start at a kink of the input: with dense output the last state is not accessible.
//! - The stiffness test, which ends a run, is off.

use bristle::ode::System;
use nalgebra::SVector;
use ode_solvers::{Dop853, Dopri5, OutputType};

use super::{Failure, Peer, Run};
use crate::field::Field;
use crate::scenes::SAMPLES;

pub(super) fn methods<S: System<f64, N>, const N: usize>() -> [Peer<S, N>; 2] {
    let peer = |method, solve| Peer { crate_: "ode_solvers", method, solve };
    [peer("dopri5", dopri5), peer("dop853", dop853)]
}

/// The nalgebra that this crate is built with.
type State<const N: usize> = ode_solvers::SVector<f64, N>;

/// ẏ = f for y = x/scales.
struct Scaled<'a, 'f, S, const N: usize>(&'a Field<'f, S, N>);

impl<S: System<f64, N>, const N: usize> ode_solvers::System<f64, State<N>>
    for Scaled<'_, '_, S, N>
{
    fn system(&self, time: f64, state: &State<N>, rate: &mut State<N>) {
        let state = SVector::from_fn(|i, _| state[i]);
        rate.copy_from_slice(self.0.scaled_rate(time, &state).as_slice());
    }
}

/// The same with t/end as the last of M = N + 1 states.
struct WithTime<'a, 'f, S, const N: usize>(&'a Field<'f, S, N>);

impl<S: System<f64, N>, const N: usize, const M: usize> ode_solvers::System<f64, State<M>>
    for WithTime<'_, '_, S, N>
{
    fn system(&self, _time: f64, state: &State<M>, rate: &mut State<M>) {
        let end = self.0.scene().end;
        let time = state[N] * end;
        let state = SVector::from_fn(|i, _| state[i]);
        rate.as_mut_slice()[..N].copy_from_slice(self.0.scaled_rate(time, &state).as_slice());
        rate[N] = 1.0 / end;
    }
}

fn dopri5<S: System<f64, N>, const N: usize>(
    field: &Field<'_, S, N>,
    tolerance: f64,
) -> Result<Run, Failure> {
    let scene = field.scene();
    let scaled = scene.start.component_div(&scene.scales);
    let start = State::<N>::from_fn(|i, _| scaled[i]);
    let (end, sample) = past_the_end(scene.end);
    // Defaults, but no limit of steps and no test for stiffness.
    let mut stepper = Dopri5::from_param(
        Scaled(field),
        0.0,
        end,
        sample,
        start,
        tolerance,
        tolerance,
        0.9,
        0.04,
        0.2,
        10.0,
        end,
        0.0,
        u32::MAX,
        u32::MAX,
        OutputType::Dense,
    );
    let statistics = stepper.integrate().map_err(|error| failure(&error))?;
    let (steps, rejected) = (statistics.accepted_steps, statistics.rejected_steps);
    finish(field, stepper.y_out().iter().map(|state| state[scene.judged]), steps, rejected)
}

fn dop853<S: System<f64, N>, const N: usize>(
    field: &Field<'_, S, N>,
    tolerance: f64,
) -> Result<Run, Failure> {
    match N {
        1 => dop853_with_time::<S, N, 2>(field, tolerance),
        3 => dop853_with_time::<S, N, 4>(field, tolerance),
        4 => dop853_with_time::<S, N, 5>(field, tolerance),
        6 => dop853_with_time::<S, N, 7>(field, tolerance),
        _ => Err(Failure::new("size", format!("add the line for {N} states and the time"))),
    }
}

fn dop853_with_time<S: System<f64, N>, const N: usize, const M: usize>(
    field: &Field<'_, S, N>,
    tolerance: f64,
) -> Result<Run, Failure> {
    let scene = field.scene();
    let scaled = scene.start.component_div(&scene.scales);
    let start = State::<M>::from_fn(|i, _| if i < N { scaled[i] } else { 0.0 });
    let (end, sample) = past_the_end(scene.end);
    let mut stepper = Dop853::from_param(
        WithTime(field),
        0.0,
        end,
        sample,
        start,
        tolerance,
        tolerance,
        0.9,
        0.0,
        0.333,
        6.0,
        end,
        0.0,
        u32::MAX,
        u32::MAX,
        OutputType::Dense,
    );
    let statistics = stepper.integrate().map_err(|error| failure(&error))?;
    let (steps, rejected) = (statistics.accepted_steps, statistics.rejected_steps);
    finish(field, stepper.y_out().iter().map(|state| state[scene.judged]), steps, rejected)
}

/// Where the run ends, half a sample late, and the time between two samples [s].
fn past_the_end(end: f64) -> (f64, f64) {
    let sample = end / (SAMPLES - 1) as f64;
    (end + 0.5 * sample, sample)
}

fn finish<S: System<f64, N>, const N: usize>(
    field: &Field<'_, S, N>,
    judged: impl Iterator<Item = f64>,
    steps: u32,
    rejected: u32,
) -> Result<Run, Failure> {
    let scale = field.scene().scales[field.scene().judged];
    let judged: Vec<f64> = judged.map(|value| value * scale).collect();
    match judged.len() {
        SAMPLES => Ok(Run { judged, steps: steps.into(), rejected: rejected.into() }),
        given => Err(Failure::new("samples", format!("success, but {given} of {SAMPLES} samples"))),
    }
}

fn failure(error: &(impl std::fmt::Display + ?Sized)) -> Failure {
    // The error's type is not exported; its text is all there is.
    let message = error.to_string();
    let word = match &message {
        text if text.contains("underflow") => "underflow",
        text if text.contains("stiff") => "stiff",
        text if text.contains("steps") => "max_steps",
        _ => "error",
    };
    Failure::new(word, message)
}
