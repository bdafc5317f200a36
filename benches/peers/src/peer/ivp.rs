//! `ivp` 0.6: scipy's `solve_ivp` in Rust, on slices.
//!
//! Tolerances per component, `t_eval`, analytic Jacobian (LSODA has to be told to ask for it).
//!
//! - Tolerances are given as vectors even where all are equal: RADAU rescales a scalar one again
//!   for every component.
//! - A failed integration comes back as `Ok` with a status, which is read here.
//! - DOPRI5 and DOP853 end a run that looks stiff to them. The builder `Ivp` does not let one
//!   switch that off, so they are called directly, with an output callback.

use bristle::ode::System;
use ivp::dense::StepInterpolant;
use ivp::error::Error;
use ivp::matrix::Matrix;
use ivp::methods::{DOP853, DOPRI5, IntegrationResult, Tolerance};
use ivp::prelude::{
    ControlFlag, EventConfig, FirstOrderSystem, Ivp, JacobianSource, Method, Status,
};
use ivp::solout::SolOut;
use nalgebra::SVector;

use super::{Failure, Part, Peer, Piece, Run, drive, told};
use crate::field::{Field, Leg};

pub(super) fn methods<S: System<f64, N>, const N: usize>() -> [Peer<S, N>; 8] {
    let peer = |method, solve| Peer { crate_: "ivp", method, solve };
    [
        peer("rk23", |field, r| each_leg(field, r, Method::RK23)),
        peer("dopri5", |field, r| {
            let method = DOPRI5::builder().max_steps(usize::MAX).stiff_test(usize::MAX).build();
            each_leg_explicit(field, r, |leg, y0, rtol, atol, samples| {
                method.solve(&Plain(field), leg.start, y0, leg.end, rtol, atol, Some(samples))
            })
        }),
        peer("dop853", |field, r| {
            let method = DOP853::builder().max_steps(usize::MAX).stiff_test(usize::MAX).build();
            each_leg_explicit(field, r, |leg, y0, rtol, atol, samples| {
                method.solve(&Plain(field), leg.start, y0, leg.end, rtol, atol, Some(samples))
            })
        }),
        peer("radau", |field, r| each_leg(field, r, Method::RADAU)),
        peer("bdf", |field, r| each_leg(field, r, Method::BDF)),
        peer("lsoda", |field, r| each_leg(field, r, Method::LSODA)),
        peer("radau + root", |field, r| each_piece(field, r, Method::RADAU)),
        peer("bdf + root", |field, r| each_piece(field, r, Method::BDF)),
    ]
}

struct Plain<'a, 'f, S, const N: usize>(&'a Field<'f, S, N>);

impl<S: System<f64, N>, const N: usize> FirstOrderSystem for Plain<'_, '_, S, N> {
    fn derivative(&self, time: f64, state: &[f64], rate: &mut [f64]) {
        let state = SVector::<f64, N>::from_column_slice(state);
        rate.copy_from_slice(self.0.rate(time, &state).as_slice());
    }

    fn jac(&self, time: f64, state: &[f64], out: &mut Matrix) {
        let jacobian = self.0.jacobian(time, &SVector::<f64, N>::from_column_slice(state));
        for i in 0..N {
            for j in 0..N {
                out[(i, j)] = jacobian[(i, j)];
            }
        }
    }
}

/// The same, told of reversals.
struct Told<'a, 'f, S, const N: usize>(&'a Field<'f, S, N>);

impl<S: System<f64, N>, const N: usize> FirstOrderSystem for Told<'_, '_, S, N> {
    fn derivative(&self, time: f64, state: &[f64], rate: &mut [f64]) {
        Plain(self.0).derivative(time, state, rate);
    }

    fn jac(&self, time: f64, state: &[f64], out: &mut Matrix) {
        Plain(self.0).jac(time, state, out);
    }

    fn events(&self, time: f64, state: &[f64], out: &mut [f64]) {
        out[0] = self.0.reversal(time, &SVector::from_column_slice(state));
    }

    fn n_events(&self) -> usize {
        1
    }

    fn event_config(&self, _: usize) -> EventConfig {
        let mut config = EventConfig::new();
        config.terminal();
        config
    }
}

fn each_piece<S: System<f64, N>, const N: usize>(
    field: &Field<'_, S, N>,
    tolerance: f64,
    method: Method,
) -> Result<Run, Failure> {
    let absolute: [f64; N] = (field.scene().scales * tolerance).into();
    let piece = |leg: &Leg, start: SVector<f64, N>| {
        let mut solution = Ivp::first_order(&Told(field), leg.start, leg.end, start.as_slice())
            .method(method)
            .rtol([tolerance; N])
            .atol(absolute)
            .dense_output(true)
            .jacobian_source(JacobianSource::UserProvided)
            .solve()
            .map_err(|error| Failure::new("error", error.to_string()))?;
        let times = solution.t_events.pop().unwrap_or_default();
        let there = solution.y_events.pop().unwrap_or_default();
        let reversal = times.first().zip(there.first());
        let reversal = reversal.map(|(&time, y)| (time, SVector::from_column_slice(y)));
        if reversal.is_none() {
            succeeded(solution.status)?;
        }
        let last = reversal.map_or(f64::INFINITY, |it| it.0);
        // It drops the samples of `t_eval` in the step that ends at an event.
        let dense = solution.continuous_sol.as_ref();
        let at = |&time: &f64| dense.and_then(|it| it.evaluate_extrapolate(time));
        let samples = leg.times.iter().take_while(|&&time| time <= last).map_while(at);
        let states = samples.map(|y| SVector::from_column_slice(&y)).collect();
        let (steps, rejected) = (solution.naccpt as u64, solution.nrejct as u64);
        Ok(Piece { part: Part { states, steps, rejected }, reversal })
    };
    drive(field, |leg, start| told(field, leg, start, tolerance, piece))
}

fn each_leg<S: System<f64, N>, const N: usize>(
    field: &Field<'_, S, N>,
    tolerance: f64,
    method: Method,
) -> Result<Run, Failure> {
    let absolute: [f64; N] = (field.scene().scales * tolerance).into();
    drive(field, |leg: &Leg, start| {
        let solution = Ivp::first_order(&Plain(field), leg.start, leg.end, start.as_slice())
            .method(method)
            .rtol([tolerance; N])
            .atol(absolute)
            .t_eval(leg.times.clone())
            .jacobian_source(JacobianSource::UserProvided)
            .solve()
            .map_err(|error| Failure::new("error", error.to_string()))?;
        succeeded(solution.status)?;
        let states = solution.y.iter().map(|y| SVector::from_column_slice(y)).collect();
        let (steps, rejected) = (solution.naccpt as u64, solution.nrejct as u64);
        Ok(Part { states, steps, rejected })
    })
}

fn each_leg_explicit<S: System<f64, N>, const N: usize>(
    field: &Field<'_, S, N>,
    tolerance: f64,
    solve: impl Fn(
        &Leg,
        &[f64],
        Tolerance,
        Tolerance,
        &mut Samples<'_, N>,
    ) -> Result<IntegrationResult, Error>,
) -> Result<Run, Failure> {
    let absolute: [f64; N] = (field.scene().scales * tolerance).into();
    drive(field, |leg: &Leg, start| {
        let mut samples = Samples { times: &leg.times, states: Vec::new() };
        let (relative, absolute) = ([tolerance; N].into(), absolute.into());
        let result = solve(leg, start.as_slice(), relative, absolute, &mut samples)
            .map_err(|error| Failure::new("error", error.to_string()))?;
        succeeded(result.status)?;
        let (steps, rejected) = (result.steps.accepted as u64, result.steps.rejected as u64);
        Ok(Part { states: samples.states, steps, rejected })
    })
}

/// Takes the states at the output times from each step's interpolant.
struct Samples<'a, const N: usize> {
    times: &'a [f64],
    states: Vec<SVector<f64, N>>,
}

impl<const N: usize> SolOut for Samples<'_, N> {
    fn solout(
        &mut self,
        before: f64,
        now: &mut f64,
        _state: &mut [f64],
        interpolant: Option<&StepInterpolant<'_>>,
    ) -> ControlFlag {
        let Some(interpolant) = interpolant.filter(|_| before < *now) else {
            return ControlFlag::Continue; // the call before the first step
        };
        // As the crate's own output does: a time that rounding puts just behind a step is in it.
        while let Some(&time) = self.times.get(self.states.len()).filter(|&&t| t <= *now + 1e-12) {
            let mut state = SVector::<f64, N>::zeros();
            interpolant.interpolate(time, state.as_mut_slice());
            self.states.push(state);
        }
        ControlFlag::Continue
    }
}

fn succeeded(status: Status) -> Result<(), Failure> {
    let word = match status {
        Status::Success => return Ok(()),
        Status::StepSizeTooSmall => "underflow",
        Status::ProbablyStiff => "stiff",
        Status::NeedLargerNMax => "max_steps",
        Status::SingularMatrix => "singular",
        Status::PoorConvergence => "newton",
        Status::UserInterrupt => "error",
    };
    Err(Failure::new(word, format!("Ok with status {status:?}")))
}
