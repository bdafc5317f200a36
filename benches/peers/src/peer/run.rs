//! What a peer is, and how its runs are put together from leg to leg and from reversal to reversal.

use bristle::ode::System;
use nalgebra::SVector;

use crate::field::{Field, Leg};

/// A method of a crate.
pub(crate) struct Peer<S, const N: usize> {
    pub(crate) crate_: &'static str,
    pub(crate) method: &'static str,
    /// Integrates a scene at a relative tolerance.
    pub(crate) solve: fn(&Field<'_, S, N>, f64) -> Result<Run, Failure>,
}

/// A run that reached the end.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Run {
    /// The judged component at the output samples.
    pub(crate) judged: Vec<f64>,
    pub(crate) steps: u64,
    pub(crate) rejected: u64,
}

/// A run that did not.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Failure {
    /// A short word for the table.
    pub(crate) word: &'static str,
    /// What the crate said.
    pub(crate) message: String,
}

impl Failure {
    pub(crate) fn new(word: &'static str, message: impl Into<String>) -> Failure {
        Failure { word, message: message.into() }
    }
}

/// What a crate returned for one leg.
pub(crate) struct Part<const N: usize> {
    /// The states at the leg's times.
    pub(crate) states: Vec<SVector<f64, N>>,
    pub(crate) steps: u64,
    pub(crate) rejected: u64,
}

/// What a code that looks for reversals returned: a part of a leg, and time and state of the
/// reversal that ended it.
pub(crate) struct Piece<const N: usize> {
    pub(crate) part: Part<N>,
    pub(crate) reversal: Option<(f64, SVector<f64, N>)>,
}

/// Integrates a leg from reversal to reversal, for a peer with a root function.
pub(crate) fn told<S: System<f64, N>, const N: usize>(
    field: &Field<'_, S, N>,
    leg: &Leg,
    mut state: SVector<f64, N>,
    tolerance: f64,
    solve: impl Fn(&Leg, SVector<f64, N>) -> Result<Piece<N>, Failure>,
) -> Result<Part<N>, Failure> {
    let (mut rest, mut all) = (leg.clone(), Part { states: Vec::new(), steps: 0, rejected: 0 });
    field.lock(leg.start, &state, tolerance);
    loop {
        let Piece { part, reversal } = solve(&rest, state)?;
        all.steps += part.steps;
        all.rejected += part.rejected;
        rest.times.drain(..part.states.len().min(rest.times.len()));
        all.states.extend(part.states);
        match reversal {
            Some((time, _)) if time <= rest.start => {
                return Err(Failure::new("reversal", "found where the piece begins"));
            }
            Some((time, there)) if !rest.times.is_empty() => (rest.start, state) = (time, there),
            _ => break,
        }
        field.reverse();
    }
    field.free();
    Ok(all)
}

/// Integrates leg after leg.
pub(crate) fn drive<S: System<f64, N>, const N: usize>(
    field: &Field<'_, S, N>,
    mut solve: impl FnMut(&Leg, SVector<f64, N>) -> Result<Part<N>, Failure>,
) -> Result<Run, Failure> {
    let scene = field.scene();
    let mut state = scene.start;
    let mut run = Run { judged: vec![state[scene.judged]], steps: 0, rejected: 0 };
    for leg in field.legs() {
        let part = solve(&leg, state)?;
        let (expected, given) = (leg.times.len(), part.states.len());
        let last = part.states.last().filter(|_| given == expected);
        state = *last.ok_or_else(|| {
            Failure::new("samples", format!("success, but {given} of {expected} samples"))
        })?;
        let samples = expected - usize::from(leg.ends_between_samples);
        run.judged.extend(part.states[..samples].iter().map(|state| state[scene.judged]));
        run.steps += part.steps;
        run.rejected += part.rejected;
    }
    Ok(run)
}
