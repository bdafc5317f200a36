//! `diffsol` 0.18: BDF, TR-BDF2, ESDIRK34 and Tsitouras 5(4), with nalgebra's matrices.
//!
//! Its vectors are allocated; small static ones are not on offer. The equations are a type of our
//! own, as the documentation proposes for more control, so that the Jacobian is written at once
//! instead of column by column. Limits of failed Newton iterations and error tests count a whole
//! run and are lifted; the least step is lowered from 1e-13 s. Each leg is a problem of its own.

use bristle::ode::System;
use diffsol::error::{DiffsolError, OdeSolverError};
use diffsol::{
    ConstantOp, Matrix, MatrixCommon, NalgebraContext, NalgebraLU, NalgebraMat, NalgebraVec,
    NonLinearOp, NonLinearOpJacobian, OdeBuilder, OdeEquations, OdeEquationsRef, OdeSolverMethod,
    OdeSolverProblem, Op, UnitCallable, Vector, VectorCommon,
};
use nalgebra::SVector;

use super::{Failure, Part, Peer, Run, drive};
use crate::field::{Field, Leg};

type M = NalgebraMat<f64>;
type V = NalgebraVec<f64>;
type Lu = NalgebraLU<f64>;

pub(super) fn methods<S: System<f64, N>, const N: usize>() -> [Peer<S, N>; 4] {
    let peer = |method, solve| Peer { crate_: "diffsol", method, solve };
    [
        peer("tsit45", |field, r| each_leg(field, r, |problem, leg| sample(problem.tsit45(), leg))),
        peer("bdf", |field, r| each_leg(field, r, |problem, leg| sample(problem.bdf::<Lu>(), leg))),
        peer("tr_bdf2", |field, r| {
            each_leg(field, r, |problem, leg| sample(problem.tr_bdf2::<Lu>(), leg))
        }),
        peer("esdirk34", |field, r| {
            each_leg(field, r, |problem, leg| sample(problem.esdirk34::<Lu>(), leg))
        }),
    ]
}

/// The equations of one leg: right-hand side and first state.
struct Equations<'f, S, const N: usize> {
    field: &'f Field<'f, S, N>,
    start: SVector<f64, N>,
    context: NalgebraContext,
}

/// The right-hand side.
struct Right<'a, 'f, S, const N: usize> {
    of: &'a Equations<'f, S, N>,
}

/// The first state.
struct First<'a, 'f, S, const N: usize> {
    of: &'a Equations<'f, S, N>,
}

macro_rules! square_operator {
    ($name:ty, $($context:ident).+) => {
        impl<S: System<f64, N>, const N: usize> Op for $name {
            type T = f64;
            type V = V;
            type M = M;
            type C = NalgebraContext;

            fn context(&self) -> &NalgebraContext {
                &self.$($context).+
            }

            fn nstates(&self) -> usize {
                N
            }

            fn nout(&self) -> usize {
                N
            }

            fn nparams(&self) -> usize {
                0
            }
        }
    };
}

square_operator!(Equations<'_, S, N>, context);
square_operator!(Right<'_, '_, S, N>, of.context);
square_operator!(First<'_, '_, S, N>, of.context);

fn vector<const N: usize>(x: &V) -> SVector<f64, N> {
    SVector::from_column_slice(x.inner().as_slice())
}

impl<S: System<f64, N>, const N: usize> NonLinearOp for Right<'_, '_, S, N> {
    fn call_inplace(&self, x: &V, t: f64, y: &mut V) {
        let rate = self.of.field.rate(t, &vector(x));
        y.inner_mut().as_mut_slice().copy_from_slice(rate.as_slice());
    }
}

impl<S: System<f64, N>, const N: usize> NonLinearOpJacobian for Right<'_, '_, S, N> {
    fn jac_mul_inplace(&self, x: &V, t: f64, v: &V, y: &mut V) {
        let product = self.of.field.jacobian(t, &vector(x)) * vector::<N>(v);
        y.inner_mut().as_mut_slice().copy_from_slice(product.as_slice());
    }

    fn jacobian_inplace(&self, x: &V, t: f64, y: &mut M) {
        let jacobian = self.of.field.jacobian(t, &vector(x));
        // Both are stored column by column.
        y.inner_mut().as_mut_slice().copy_from_slice(jacobian.as_slice());
    }
}

impl<S: System<f64, N>, const N: usize> ConstantOp for First<'_, '_, S, N> {
    fn call_inplace(&self, _t: f64, y: &mut V) {
        y.inner_mut().as_mut_slice().copy_from_slice(self.of.start.as_slice());
    }
}

impl<'a, 'f, S: System<f64, N>, const N: usize> OdeEquationsRef<'a> for Equations<'f, S, N> {
    type Rhs = Right<'a, 'f, S, N>;
    type Init = First<'a, 'f, S, N>;
    type Mass = UnitCallable<M>;
    type Root = UnitCallable<M>;
    type Out = UnitCallable<M>;
    type Reset = UnitCallable<M>;
}

impl<'f, S: System<f64, N>, const N: usize> OdeEquations for Equations<'f, S, N> {
    fn rhs(&self) -> Right<'_, 'f, S, N> {
        Right { of: self }
    }

    fn mass(&self) -> Option<UnitCallable<M>> {
        None
    }

    fn init(&self) -> First<'_, 'f, S, N> {
        First { of: self }
    }

    fn set_params(&mut self, _p: &V) {}

    fn get_params(&self, _p: &mut V) {}
}

fn each_leg<S: System<f64, N>, const N: usize>(
    field: &Field<'_, S, N>,
    tolerance: f64,
    solve: impl Fn(&OdeSolverProblem<Equations<'_, S, N>>, &Leg) -> Result<Part<N>, DiffsolError>,
) -> Result<Run, Failure> {
    drive(field, |leg, start| {
        let equations = Equations { field, start, context: NalgebraContext::default() };
        let problem = OdeBuilder::<M>::new()
            .t0(leg.start)
            .rtol(tolerance)
            .atol((field.scene().scales * tolerance).iter().copied().collect::<Vec<f64>>())
            .build_from_eqn(equations);
        let mut problem = problem.map_err(|error| failure(&error))?;
        problem.ode_options.max_nonlinear_solver_failures = usize::MAX;
        problem.ode_options.max_error_test_failures = usize::MAX;
        problem.ode_options.min_timestep = 1e-16;
        solve(&problem, leg).map_err(|error| failure(&error))
    })
}

fn sample<'p, E, O, const N: usize>(
    solver: Result<O, DiffsolError>,
    leg: &Leg,
) -> Result<Part<N>, DiffsolError>
where
    E: OdeEquations<T = f64, V = V, M = M, C = NalgebraContext> + 'p,
    O: OdeSolverMethod<'p, E>,
{
    let mut solver = solver?;
    let (samples, _) = solver.solve_dense(&leg.times)?;
    let states = samples.inner().column_iter().map(|column| SVector::from_fn(|i, _| column[i]));
    let statistics = solver.get_statistics();
    Ok(Part {
        states: states.collect(),
        steps: statistics.number_of_steps as u64,
        rejected: (statistics.number_of_error_test_failures
            + statistics.number_of_nonlinear_solver_fails) as u64,
    })
}

fn failure(error: &DiffsolError) -> Failure {
    let word = match error {
        DiffsolError::OdeSolverError(OdeSolverError::StepSizeTooSmall { .. }) => "underflow",
        DiffsolError::OdeSolverError(OdeSolverError::TooManyErrorTestFailures { .. }) => {
            "rejections"
        }
        DiffsolError::OdeSolverError(OdeSolverError::TooManyNonlinearSolverFailures { .. })
        | DiffsolError::NonLinearSolverError(_) => "newton",
        DiffsolError::LaError(_) => "singular",
        _ => "error",
    };
    Failure::new(word, error.to_string())
}
