//! `differential-equations` 0.7 on statically sized nalgebra vectors.
//!
//! - Tolerances are given as vectors even where all are equal: Radau5 rescales a scalar one again
//!   for every component.
//! - The diagonally implicit methods compare the residual of their Newton iteration, in the units
//!   of the states, with a fixed 1e-10: they integrate x/scales, and their Newton tolerance follows
//!   the relative one. Their limit of rejections counts all of a run, so it is lifted.
//! - Radau5 keeps its default Newton tolerance. With zero, which asks for the formula of the
//!   original, it ends in "step size became too small" at reversals.
//! - The dense output of `dopri5` is of order three (its table keeps the coefficients in a row the
//!   method does not read), that of `dop853` has s and 1 − s exchanged in its last four terms. The
//!   samples are worse than the steps for it, by orders of magnitude at tight tolerances. There is
//!   no way round that from outside; `rkv878e` has a sound one.
//! - The last output time is a few roundings early: the run may end so much before it.

use bristle::ode::System;
use differential_equations::interpolate::Interpolation;
use differential_equations::linalg::Matrix;
use differential_equations::methods::{
    BackwardDifferentiationFormula, DiagonallyImplicitRungeKutta, ExplicitRungeKutta,
    ImplicitRungeKutta,
};
use differential_equations::ode::{ODE, OrdinaryNumericalMethod};
use differential_equations::prelude::{Error, IVP};
use nalgebra::SVector;

use super::{Failure, Part, Peer, Run, drive};
use crate::field::{Field, Leg};

type State<const N: usize> = SVector<f64, N>;

pub(super) fn methods<S: System<f64, N>, const N: usize>() -> Vec<Peer<S, N>> {
    let peer = |method, solve| Peer { crate_: "differential-equations", method, solve };
    vec![
        peer("dopri5", |field, r| {
            each_leg(field, || {
                ExplicitRungeKutta::dopri5()
                    .rtol([r; N])
                    .atol(absolute(field, r))
                    .max_steps(usize::MAX)
                    .max_rejects(usize::MAX)
            })
        }),
        peer("dop853", |field, r| {
            each_leg(field, || {
                ExplicitRungeKutta::dop853()
                    .rtol([r; N])
                    .atol(absolute(field, r))
                    .max_steps(usize::MAX)
                    .max_rejects(usize::MAX)
            })
        }),
        peer("rkv878e", |field, r| {
            each_leg(field, || {
                ExplicitRungeKutta::rkv878e()
                    .rtol([r; N])
                    .atol(absolute(field, r))
                    .max_steps(usize::MAX)
                    .max_rejects(usize::MAX)
            })
        }),
        peer("radau5", |field, r| {
            each_leg(field, || {
                ImplicitRungeKutta::radau5()
                    .rtol([r; N])
                    .atol(absolute(field, r))
                    .max_steps(usize::MAX)
                    .max_rejects(usize::MAX)
            })
        }),
        peer("kvaerno745", |field, r| {
            each_leg_scaled(field, || {
                DiagonallyImplicitRungeKutta::kvaerno745()
                    .rtol([r; N])
                    .atol([r; N])
                    .newton_tol(newton(r))
                    .max_steps(usize::MAX)
                    .max_rejects(usize::MAX)
            })
        }),
        peer("kvaerno423", |field, r| {
            each_leg_scaled(field, || {
                DiagonallyImplicitRungeKutta::kvaerno423()
                    .rtol([r; N])
                    .atol([r; N])
                    .newton_tol(newton(r))
                    .max_steps(usize::MAX)
                    .max_rejects(usize::MAX)
            })
        }),
        peer("bdf", |field, r| {
            each_leg(field, || {
                BackwardDifferentiationFormula::adaptive()
                    .rtol([r; N])
                    .atol(absolute(field, r))
                    .max_steps(usize::MAX)
            })
        }),
    ]
}

fn absolute<S: System<f64, N>, const N: usize>(field: &Field<'_, S, N>, r: f64) -> [f64; N] {
    (field.scene().scales * r).into()
}

/// A hundredth of the local error, but not below the rounding of a state of order one.
fn newton(r: f64) -> f64 {
    (0.01 * r).max(1e-15)
}

struct Plain<'a, 'f, S, const N: usize>(&'a Field<'f, S, N>);

impl<S: System<f64, N>, const N: usize> ODE<f64, State<N>> for Plain<'_, '_, S, N> {
    fn diff(&self, time: f64, state: &State<N>, rate: &mut State<N>) {
        *rate = self.0.rate(time, state);
    }

    fn jacobian(&self, time: f64, state: &State<N>, out: &mut Matrix<f64>) {
        let jacobian = self.0.jacobian(time, state);
        for i in 0..N {
            for j in 0..N {
                out[(i, j)] = jacobian[(i, j)];
            }
        }
    }
}

struct Scaled<'a, 'f, S, const N: usize>(&'a Field<'f, S, N>);

impl<S: System<f64, N>, const N: usize> ODE<f64, State<N>> for Scaled<'_, '_, S, N> {
    fn diff(&self, time: f64, state: &State<N>, rate: &mut State<N>) {
        *rate = self.0.scaled_rate(time, state);
    }

    fn jacobian(&self, time: f64, state: &State<N>, out: &mut Matrix<f64>) {
        let jacobian = self.0.scaled_jacobian(time, state);
        for i in 0..N {
            for j in 0..N {
                out[(i, j)] = jacobian[(i, j)];
            }
        }
    }
}

fn each_leg<S: System<f64, N>, M, const N: usize>(
    field: &Field<'_, S, N>,
    method: impl Fn() -> M,
) -> Result<Run, Failure>
where
    M: OrdinaryNumericalMethod<f64, State<N>> + Interpolation<f64, State<N>>,
{
    drive(field, |leg, start| solve(&Plain(field), leg, start, method()))
}

fn each_leg_scaled<S: System<f64, N>, M, const N: usize>(
    field: &Field<'_, S, N>,
    method: impl Fn() -> M,
) -> Result<Run, Failure>
where
    M: OrdinaryNumericalMethod<f64, State<N>> + Interpolation<f64, State<N>>,
{
    let scales = field.scene().scales;
    drive(field, |leg, start| {
        let mut part = solve(&Scaled(field), leg, start.component_div(&scales), method())?;
        part.states.iter_mut().for_each(|state| state.component_mul_assign(&scales));
        Ok(part)
    })
}

fn solve<F, M, const N: usize>(
    system: &F,
    leg: &Leg,
    start: State<N>,
    method: M,
) -> Result<Part<N>, Failure>
where
    F: ODE<f64, State<N>>,
    M: OrdinaryNumericalMethod<f64, State<N>> + Interpolation<f64, State<N>>,
{
    let mut times = leg.times.clone();
    if let Some(last) = times.last_mut() {
        *last -= 1e-14 * leg.end;
    }
    let problem = IVP::ode(system, leg.start, leg.end, start).t_eval(times);
    let solution = problem.method(method).solve().map_err(|error| failure(&error))?;
    Ok(Part {
        states: solution.y,
        steps: solution.steps.accepted as u64,
        rejected: solution.steps.rejected as u64,
    })
}

fn failure<const N: usize>(error: &Error<f64, State<N>>) -> Failure {
    let word = match error {
        Error::StepSize { .. } => "underflow",
        Error::Stiffness { .. } => "stiff",
        Error::MaxSteps { .. } => "max_steps",
        Error::LinearAlgebra { .. } => "singular",
        _ => "error",
    };
    Failure::new(word, format!("{error:?}"))
}
