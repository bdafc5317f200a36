//! The tyre of Romano et al. (arXiv 2602.09429, table 1), with and without dashpots.

use bristle::curve::Stribeck;
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::signal::Function;
use bristle::{FrBd, paper};
use bristle_rolling::{FunctionPressure, Motion, Pressure};

/// Length of its contact patch [m].
pub(crate) const LENGTH: f64 = paper::TYRE_LENGTH;

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

/// Its model with that.
pub(crate) fn frbd(micro_damping: f64) -> FrBd<Stribeck<f64>, KelvinVoigt<f64>> {
    FrBd::new(curve(), bristle(micro_damping))
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
