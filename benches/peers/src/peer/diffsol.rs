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
    OdeSolverProblem, OdeSolverStopReason, Op, UnitCallable, Vector, VectorCommon,
};
use nalgebra::SVector;

use super::{Failure, Part, Peer, Piece, Run, drive, told};
use crate::field::{Field, Leg};

type M = NalgebraMat<f64>;
type V = NalgebraVec<f64>;
type Lu = NalgebraLU<f64>;

pub(super) fn methods<S: System<f64, N>, const N: usize>() -> [Peer<S, N>; 8] {
    let peer = |method, solve| Peer { crate_: "diffsol", method, solve };
    [
        peer("tsit45", |f, r| each_leg(f, r, false, |p, leg| sample(p.tsit45(), leg))),
        peer("bdf", |f, r| each_leg(f, r, false, |p, leg| sample(p.bdf::<Lu>(), leg))),
        peer("tr_bdf2", |f, r| each_leg(f, r, false, |p, leg| sample(p.tr_bdf2::<Lu>(), leg))),
        peer("esdirk34", |f, r| each_leg(f, r, false, |p, leg| sample(p.esdirk34::<Lu>(), leg))),
        peer("tsit45 + root", |f, r| each_leg(f, r, true, |p, leg| sample(p.tsit45(), leg))),
        peer("bdf + root", |f, r| each_leg(f, r, true, |p, leg| sample(p.bdf::<Lu>(), leg))),
        peer("tr_bdf2 + root", |f, r| {
            each_leg(f, r, true, |p, leg| sample(p.tr_bdf2::<Lu>(), leg))
        }),
        peer("esdirk34 + root", |f, r| {
            each_leg(f, r, true, |p, leg| sample(p.esdirk34::<Lu>(), leg))
        }),
    ]
}

/// The equations of one leg: right-hand side and first state.
struct Equations<'f, S, const N: usize> {
    field: &'f Field<'f, S, N>,
    start: SVector<f64, N>,
    /// Whether it has a root function.
    told: bool,
    context: NalgebraContext,
}

/// The root function: the sliding velocity.
struct Reversal<'a, 'f, S, const N: usize> {
    of: &'a Equations<'f, S, N>,
}

/// The right-hand side.
struct Right<'a, 'f, S, const N: usize> {
    of: &'a Equations<'f, S, N>,
}

/// The first state.
struct First<'a, 'f, S, const N: usize> {
    of: &'a Equations<'f, S, N>,
}

macro_rules! operator {
    ($name:ty, $outputs:expr, $($context:ident).+) => {
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
                $outputs
            }

            fn nparams(&self) -> usize {
                0
            }
        }
    };
}

operator!(Equations<'_, S, N>, N, context);
operator!(Right<'_, '_, S, N>, N, of.context);
operator!(First<'_, '_, S, N>, N, of.context);
operator!(Reversal<'_, '_, S, N>, 1, of.context);

impl<S: System<f64, N>, const N: usize> NonLinearOp for Reversal<'_, '_, S, N> {
    fn call_inplace(&self, x: &V, t: f64, y: &mut V) {
        y.inner_mut()[0] = self.of.field.reversal(t, &vector(x));
    }
}

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
    type Root = Reversal<'a, 'f, S, N>;
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

    fn root(&self) -> Option<Reversal<'_, 'f, S, N>> {
        self.told.then_some(Reversal { of: self })
    }

    fn set_params(&mut self, _p: &V) {}

    fn get_params(&self, _p: &mut V) {}
}

fn each_leg<S: System<f64, N>, const N: usize>(
    field: &Field<'_, S, N>,
    tolerance: f64,
    is_told: bool,
    solve: impl Fn(&OdeSolverProblem<Equations<'_, S, N>>, &Leg) -> Result<Piece<N>, DiffsolError>,
) -> Result<Run, Failure> {
    let piece = |leg: &Leg, start| {
        let context = NalgebraContext::default();
        let equations = Equations { field, start, told: is_told, context };
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
    };
    drive(field, |leg, start| {
        if is_told {
            told(field, leg, start, tolerance, piece)
        } else {
            Ok(piece(leg, start)?.part)
        }
    })
}

fn sample<'p, E, O, const N: usize>(
    solver: Result<O, DiffsolError>,
    leg: &Leg,
) -> Result<Piece<N>, DiffsolError>
where
    E: OdeEquations<T = f64, V = V, M = M, C = NalgebraContext> + 'p,
    O: OdeSolverMethod<'p, E>,
{
    let mut solver = solver?;
    let (samples, stopped) = solver.solve_dense(&leg.times)?;
    let states = samples.inner().column_iter().map(|column| SVector::from_fn(|i, _| column[i]));
    let mut states: Vec<_> = states.collect();
    let reversal = match stopped {
        OdeSolverStopReason::RootFound(time, _) => {
            // The state there follows the samples before it, if any are left.
            states.truncate(leg.times.partition_point(|&sample| sample <= time));
            Some((time, vector(solver.state().y)))
        }
        _ => None,
    };
    let statistics = solver.get_statistics();
    let part = Part {
        states,
        steps: statistics.number_of_steps as u64,
        rejected: (statistics.number_of_error_test_failures
            + statistics.number_of_nonlinear_solver_fails) as u64,
    };
    Ok(Piece { part, reversal })
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
