//! The tyre of Romano et al. (arXiv 2602.09429, table 1), with and without dashpots.

use bristle::curve::Stribeck;
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::signal::Function;
use bristle::{FrBd, paper};
use bristle_rolling::{FunctionPressure, Motion, Patch, PatchParameters, Pressure};

/// Length of its contact patch [m].
pub(crate) const LENGTH: f64 = bristle_rolling::TYRE_LENGTH;

/// A motion whose bristles cross its patch `transport` times a second.
pub(crate) fn motion(slip_velocity: f64, transport: f64) -> Motion<f64> {
    Motion { slip_velocity, rolling_speed: LENGTH * transport }
}

/// Its friction curve.
pub(crate) fn curve() -> Stribeck<f64> {
    Stribeck::new(paper::TYRE_CURVE).unwrap()
}

/// Its bristle with a damping σ1 [s/m].
pub(crate) fn bristle(micro_damping: f64) -> KelvinVoigt<f64> {
    KelvinVoigt::new(KelvinVoigtParameters { micro_damping, ..paper::TYRE_BRISTLE }).unwrap()
}

pub(crate) type Tyre = FrBd<Stribeck<f64>, KelvinVoigt<f64>>;

/// Its model with that.
pub(crate) fn frbd(micro_damping: f64) -> Tyre {
    FrBd::new(curve(), bristle(micro_damping))
}

/// Its model.
pub(crate) fn tyre() -> Tyre {
    frbd(0.0)
}

/// Its patch with another model, under a pressure as it is given.
pub(crate) fn patch<M, P: Pressure<f64>>(model: M, pressure: P) -> Patch<f64, M, P> {
    Patch::new(PatchParameters { model, length: LENGTH, pressure }).unwrap()
}

/// That patch under 4000 N.
pub(crate) fn loaded<M, P: Pressure<f64>>(model: M, pressure: P) -> Patch<f64, M, P> {
    patch(model, pressure).under_load(4000.0).unwrap()
}

/// A held step of its bristles.
#[cfg(feature = "alloc")]
pub(crate) fn step_of<M: bristle::Bristle<f64, Deflection = f64>>(
    model: &M,
    v: f64,
    transport: f64,
    duration: f64,
) -> crate::characteristics::Step {
    let affine = model.affine(v.into(), 0.0);
    let (relaxation, drive) = (affine.relaxation, affine.drive * v);
    crate::characteristics::Step { relaxation, drive, transport, duration }
}

/// Pressure along straight lines between four points (place, pressure).
pub(crate) fn table(points: [(f64, f64); 4]) -> impl Pressure<f64> + Copy {
    let lines = move |place: f64| {
        let piece = usize::from(place >= points[1].0) + usize::from(place >= points[2].0);
        let ((from, start), (to, end)) = (points[piece], points[piece + 1]);
        let part = (place - from) / (to - from);
        (start * (1.0 - part) + end * part, (end - start) / (to - from))
    };
    FunctionPressure::new(Function::new(lines, [points[1].0, points[2].0])).unwrap()
}
