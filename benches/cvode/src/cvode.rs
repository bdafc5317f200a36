//! CVODE of SUNDIALS 6 (`libsundials-dev`): BDF and Adams with Newton's iteration, dense analytic
//! Jacobian, tolerances per component, samples by its own interpolation; with its rootfinding, it
//! starts again at each reversal.

#![allow(unsafe_code, reason = "a library in C")]

use std::any::Any;
use std::cell::Cell;
use std::ffi::{c_int, c_long, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::ptr::{null_mut, slice_from_raw_parts, slice_from_raw_parts_mut};

use bristle::ode::System;
use nalgebra::SVector;

use crate::field::{Field, Leg};
use crate::peer::{Failure, Part, Peer, Piece, Run, drive, told};

type Object = *mut c_void;
type Rate = extern "C" fn(f64, Object, Object, Object) -> c_int;
type Roots = extern "C" fn(f64, Object, *mut f64, Object) -> c_int;
type Jacobian = extern "C" fn(f64, Object, Object, Object, Object, Object, Object, Object) -> c_int;

const ADAMS: c_int = 1;
const BDF: c_int = 2;
const NORMAL: c_int = 1;
const ROOT_RETURN: c_int = 2;

#[link(name = "sundials_cvode")]
unsafe extern "C" {
    fn SUNContext_Create(communicator: Object, context: *mut Object) -> c_int;
    fn SUNContext_Free(context: *mut Object) -> c_int;
    fn N_VNew_Serial(length: i64, context: Object) -> Object;
    fn N_VGetArrayPointer(vector: Object) -> *mut f64;
    fn N_VDestroy(vector: Object);
    fn SUNDenseMatrix(rows: i64, columns: i64, context: Object) -> Object;
    fn SUNDenseMatrix_Data(matrix: Object) -> *mut f64;
    fn SUNMatDestroy(matrix: Object);
    fn SUNLinSol_Dense(vector: Object, matrix: Object, context: Object) -> Object;
    fn SUNLinSolFree(solver: Object) -> c_int;
    fn CVodeCreate(method: c_int, context: Object) -> Object;
    fn CVodeInit(memory: Object, rate: Rate, time: f64, state: Object) -> c_int;
    fn CVodeSVtolerances(memory: Object, relative: f64, absolute: Object) -> c_int;
    fn CVodeSetUserData(memory: Object, data: Object) -> c_int;
    fn CVodeSetErrFile(memory: Object, file: Object) -> c_int;
    fn CVodeSetMaxNumSteps(memory: Object, steps: c_long) -> c_int;
    fn CVodeSetLinearSolver(memory: Object, solver: Object, matrix: Object) -> c_int;
    fn CVodeSetJacFn(memory: Object, jacobian: Jacobian) -> c_int;
    fn CVodeSetStopTime(memory: Object, time: f64) -> c_int;
    fn CVodeRootInit(memory: Object, count: c_int, roots: Roots) -> c_int;
    fn CVode(memory: Object, end: f64, state: Object, time: *mut f64, task: c_int) -> c_int;
    fn CVodeGetNumSteps(memory: Object, steps: *mut c_long) -> c_int;
    fn CVodeGetNumErrTestFails(memory: Object, failures: *mut c_long) -> c_int;
    fn CVodeFree(memory: *mut Object);
}

pub(crate) fn methods<S: System<f64, N>, const N: usize>() -> [Peer<S, N>; 4] {
    let peer = |method, solve| Peer { crate_: "cvode", method, solve };
    [
        peer("bdf", |f, r| each_leg(f, r, BDF, false)),
        peer("adams", |f, r| each_leg(f, r, ADAMS, false)),
        peer("bdf + root", |f, r| each_leg(f, r, BDF, true)),
        peer("adams + root", |f, r| each_leg(f, r, ADAMS, true)),
    ]
}

/// What a callback gets: the field, and a panic on its way through C.
struct Call<'a, 'f, S, const N: usize> {
    field: &'a Field<'f, S, N>,
    panic: Cell<Option<Box<dyn Any + Send>>>,
}

/// Runs a callback; zero, or −1 where it panicked.
///
/// # Safety
///
/// `data` is the `Call` that `piece` gave, and alive.
unsafe fn guarded<S: System<f64, N>, const N: usize>(
    data: Object,
    callback: impl FnOnce(&Field<'_, S, N>),
) -> c_int {
    // SAFETY: by the caller.
    let call = unsafe { &*data.cast::<Call<'_, '_, S, N>>() };
    match catch_unwind(AssertUnwindSafe(|| callback(call.field))) {
        Ok(()) => 0,
        Err(payload) => {
            call.panic.set(Some(payload));
            -1
        }
    }
}

/// A copy of a vector of N numbers.
fn read<const N: usize>(vector: Object) -> SVector<f64, N> {
    // SAFETY: all vectors here are made by `N_VNew_Serial` with N numbers.
    let numbers = unsafe { &*slice_from_raw_parts(N_VGetArrayPointer(vector), N) };
    SVector::from_column_slice(numbers)
}

fn write(to: *mut f64, numbers: &[f64]) {
    // SAFETY: N numbers of a vector, N² of a matrix, one root: as many as are given.
    unsafe { (*slice_from_raw_parts_mut(to, numbers.len())).copy_from_slice(numbers) }
}

extern "C" fn rate<S: System<f64, N>, const N: usize>(
    time: f64,
    state: Object,
    rate: Object,
    data: Object,
) -> c_int {
    let callback = |field: &Field<'_, S, N>| {
        let value = field.rate(time, &read(state));
        // SAFETY: a vector of CVODE.
        write(unsafe { N_VGetArrayPointer(rate) }, value.as_slice());
    };
    // SAFETY: `piece` gave the data.
    unsafe { guarded(data, callback) }
}

extern "C" fn jacobian<S: System<f64, N>, const N: usize>(
    time: f64,
    state: Object,
    _: Object,
    matrix: Object,
    data: Object,
    _: Object,
    _: Object,
    _: Object,
) -> c_int {
    let callback = |field: &Field<'_, S, N>| {
        let value = field.jacobian(time, &read(state));
        // SAFETY: a dense matrix of CVODE, column by column as ours.
        write(unsafe { SUNDenseMatrix_Data(matrix) }, value.as_slice());
    };
    // SAFETY: `piece` gave the data.
    unsafe { guarded(data, callback) }
}

extern "C" fn reversal<S: System<f64, N>, const N: usize>(
    time: f64,
    state: Object,
    root: *mut f64,
    data: Object,
) -> c_int {
    let callback = |field: &Field<'_, S, N>| write(root, &[field.reversal(time, &read(state))]);
    // SAFETY: `piece` gave the data.
    unsafe { guarded(data, callback) }
}

fn each_leg<S: System<f64, N>, const N: usize>(
    field: &Field<'_, S, N>,
    tolerance: f64,
    method: c_int,
    is_told: bool,
) -> Result<Run, Failure> {
    let piece = |leg: &Leg, start| piece(field, tolerance, method, is_told, leg, start);
    drive(field, |leg, start| {
        if is_told {
            told(field, leg, start, tolerance, piece)
        } else {
            Ok(piece(leg, start)?.part)
        }
    })
}

fn piece<S: System<f64, N>, const N: usize>(
    field: &Field<'_, S, N>,
    tolerance: f64,
    method: c_int,
    is_told: bool,
    leg: &Leg,
    start: SVector<f64, N>,
) -> Result<Piece<N>, Failure> {
    let call = Call { field, panic: Cell::new(None) };
    let (mut context, size) = (null_mut(), N as i64);
    let mut states = Vec::new();
    let (mut reversal_at, mut failed) = (None, 0);
    let (mut steps, mut rejected, mut time): (c_long, c_long, f64) = (0, 0, leg.start);
    // SAFETY: each object is made before it is used and freed once, after its last use; `call`
    // outlives the memory that points to it.
    unsafe {
        let mut check = |status: c_int| failed = if failed == 0 { status } else { failed };
        check(SUNContext_Create(null_mut(), &mut context));
        let (state, absolute) = (N_VNew_Serial(size, context), N_VNew_Serial(size, context));
        write(N_VGetArrayPointer(state), start.as_slice());
        write(N_VGetArrayPointer(absolute), (field.scene().scales * tolerance).as_slice());
        let matrix = SUNDenseMatrix(size, size, context);
        let solver = SUNLinSol_Dense(state, matrix, context);
        let mut memory = CVodeCreate(method, context);
        check(CVodeSetErrFile(memory, null_mut()));
        check(CVodeInit(memory, rate::<S, N>, leg.start, state));
        check(CVodeSVtolerances(memory, tolerance, absolute));
        check(CVodeSetUserData(memory, (&raw const call).cast_mut().cast()));
        check(CVodeSetMaxNumSteps(memory, -1)); // the watchdog ends what takes too long
        check(CVodeSetLinearSolver(memory, solver, matrix));
        check(CVodeSetJacFn(memory, jacobian::<S, N>));
        check(CVodeSetStopTime(memory, leg.end));
        if is_told {
            check(CVodeRootInit(memory, 1, reversal::<S, N>));
        }
        for &sample in &leg.times {
            let status = CVode(memory, sample, state, &mut time, NORMAL);
            if status < 0 {
                check(status);
                break;
            }
            if status != ROOT_RETURN || time >= sample {
                states.push(read(state));
            }
            if status == ROOT_RETURN {
                reversal_at = Some((time, read(state)));
                break;
            }
        }
        CVodeGetNumSteps(memory, &mut steps);
        CVodeGetNumErrTestFails(memory, &mut rejected);
        CVodeFree(&mut memory);
        SUNLinSolFree(solver);
        SUNMatDestroy(matrix);
        N_VDestroy(absolute);
        N_VDestroy(state);
        SUNContext_Free(&mut context);
    }
    if let Some(payload) = call.panic.take() {
        resume_unwind(payload);
    }
    if failed != 0 {
        return Err(Failure::new("error", format!("CVODE returned {failed} at {time} s")));
    }
    let part = Part { states, steps: steps as u64, rejected: rejected as u64 };
    Ok(Piece { part, reversal: reversal_at })
}
