//! The tyre of Romano et al. (arXiv 2602.09429, table 1), with and without dashpots.

use bristle::curve::{Coulomb, CoulombParameters, Stribeck, StribeckParameters};
use bristle::regularisation::Unregularised;
use bristle::rheology::KelvinVoigt;
use bristle::signal::Function;
use bristle::{Bristle, Dahl, DahlParameters, FrBd, LuGre, Scalar, paper};
use bristle_rolling::{
    FunctionPressure, Motion, Patch, PatchParameters, PolynomialExponential,
    PolynomialExponentialParameters, Pressure,
};
use bristle_specimens::{lit, specimens};
use nalgebra::Complex;

/// Length of its contact patch [m].
pub(crate) const LENGTH: f64 = bristle_rolling::TYRE_LENGTH;
/// σ0 [1/m]
pub(crate) const STIFFNESS: f64 = 252.0;
/// The load of [`loaded`] [N].
pub(crate) const LOAD: f64 = 4000.0;

/// A model of one deflection.
pub(crate) trait Model: Bristle<f64, Deflection = f64> + Copy {}
impl<M: Bristle<f64, Deflection = f64> + Copy> Model for M {}

/// A motion whose bristles cross its patch `transport` times a second.
pub(crate) fn motion(slip_velocity: f64, transport: f64) -> Motion<f64> {
    Motion { slip_velocity, rolling_speed: LENGTH * transport }
}

pub(crate) type Tyre<T = f64> = FrBd<Stribeck<T>, KelvinVoigt<T>>;

/// Its model with a damping σ1 [s/m], in some scalar type.
pub(crate) fn frbd_of<T: Scalar>(micro_damping: f64) -> Tyre<T> {
    let curve = paper::TYRE_CURVE;
    let curve = Stribeck::new(StribeckParameters {
        static_coefficient: lit(curve.static_coefficient),
        dynamic_coefficient: lit(curve.dynamic_coefficient),
        stribeck_velocity: lit(curve.stribeck_velocity),
        stribeck_exponent: lit(curve.stribeck_exponent),
        viscous_friction: lit(curve.viscous_friction),
    });
    FrBd::new(curve.unwrap(), specimens::kelvin_voigt(lit(STIFFNESS), lit(micro_damping)))
}

pub(crate) fn frbd(micro_damping: f64) -> Tyre {
    frbd_of(micro_damping)
}

/// Its model.
pub(crate) fn tyre() -> Tyre {
    frbd(0.0)
}

/// The classical LuGre model of the same.
pub(crate) fn lugre(
    micro_damping: f64,
) -> LuGre<Stribeck<f64>, KelvinVoigt<f64>, Unregularised, f64> {
    LuGre::classical(*tyre().curve(), *frbd(micro_damping).rheology())
}

/// That with the viscous friction inside.
pub(crate) fn lugre_inside(
    micro_damping: f64,
) -> LuGre<Stribeck<f64>, KelvinVoigt<f64>, Unregularised, f64> {
    specimens::lugre_inside(*tyre().curve(), *frbd(micro_damping).rheology())
}

pub(crate) fn dahl() -> Dahl<f64> {
    Dahl::new(DahlParameters { dynamic_coefficient: 0.4, micro_stiffness: STIFFNESS }).unwrap()
}

/// Coulomb bristles of its stiffness.
pub(crate) fn coulomb<T: Scalar>(
    dynamic_coefficient: f64,
    micro_damping: f64,
) -> FrBd<Coulomb<T>, KelvinVoigt<T>> {
    let dynamic_coefficient = lit(dynamic_coefficient);
    let curve = Coulomb::new(CoulombParameters { dynamic_coefficient, viscous_friction: lit(0.0) });
    FrBd::new(curve.unwrap(), specimens::kelvin_voigt(lit(STIFFNESS), lit(micro_damping)))
}

/// Its patch with another model, under a pressure as it is given.
pub(crate) fn patch<T: Scalar, M, P: Pressure<T>>(model: M, pressure: P) -> Patch<T, M, P> {
    Patch::new(PatchParameters { model, length: lit(LENGTH), pressure }).unwrap()
}

/// That patch under [`LOAD`].
pub(crate) fn loaded<M, P: Pressure<f64>>(model: M, pressure: P) -> Patch<f64, M, P> {
    patch(model, pressure).under_load(LOAD).unwrap()
}

pub(crate) fn constant<T: Scalar>() -> PolynomialExponential<T, 1> {
    PolynomialExponential::constant()
}

pub(crate) fn parabolic<T: Scalar>() -> PolynomialExponential<T, 3> {
    PolynomialExponential::parabolic()
}

pub(crate) fn exponential<T: Scalar>(decay: f64) -> PolynomialExponential<T, 1> {
    PolynomialExponential::exponential(lit(decay)).unwrap()
}

/// Σ cₖ ξᵏ e^(−aξ)
pub(crate) fn polynomial<const N: usize>(
    coefficients: [f64; N],
    decay: f64,
) -> PolynomialExponential<f64, N> {
    PolynomialExponential::new(PolynomialExponentialParameters { coefficients, decay }).unwrap()
}

/// Falls everywhere, and not evenly.
pub(crate) fn falling() -> PolynomialExponential<f64, 3> {
    polynomial([1.0, -0.3, -0.6], 0.2)
}

/// A held step of its bristles.
pub(crate) fn step_of<M: Model>(
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
    function(lines, [points[1].0, points[2].0])
}

/// The pressure (p, p') with kinks at some places.
pub(crate) fn function<const N: usize>(
    value: impl Fn(f64) -> (f64, f64) + Copy,
    kinks: [f64; N],
) -> impl Pressure<f64> + Copy {
    FunctionPressure::new(Function::new(value, kinks)).unwrap()
}

/// A pressure that weighs each place with its distance from the inlet, ξ p.
#[derive(Debug, Clone)]
pub(crate) struct Levered<P>(P);

impl<P: Pressure<f64>> Pressure<f64> for Levered<P> {
    fn at_and_slope(&self, place: f64) -> (f64, f64) {
        let (pressure, slope) = self.0.at_and_slope(place);
        (place * pressure, pressure + place * slope)
    }

    fn next_knot(&self, place: f64) -> Option<f64> {
        self.0.next_knot(place)
    }

    fn total(&self) -> f64 {
        self.0.lever(0.0)
    }
}

/// The patch under ξ p.
pub(crate) fn levered<M: Clone, P: Pressure<f64>>(
    patch: &Patch<f64, M, P>,
) -> Patch<f64, M, Levered<P>> {
    let (model, length) = (patch.model().clone(), patch.length());
    let pressure = Levered(patch.pressure().clone());
    let load = patch.normal_force() * pressure.total() / patch.pressure().total();
    Patch::new(PatchParameters { model, length, pressure }).unwrap().under_load(load).unwrap()
}

/// F̃/Ũ = −c₀ z_ss (κ/V) Q(κ, s) of a patch about a motion.
pub(crate) fn by_rolling_speed<M: Model, P: Pressure<f64>>(
    patch: &Patch<f64, M, P>,
    motion: Motion<f64>,
    angular_frequency: f64,
) -> Complex<f64> {
    let (contact, pressure) = (patch.contact(), patch.pressure());
    let (v, transport) = (motion.slip_velocity, motion.rolling_speed / patch.length());
    let affine = contact.affine(v, 0.0);
    let decay = affine.relaxation / transport;
    let shifted = if angular_frequency == 0.0 {
        pressure.lever(decay).into()
    } else {
        pressure.transform_slope(decay, Complex::new(decay, angular_frequency / transport))
    };
    let factor = patch.normal_force() / (patch.length() * pressure.total());
    -shifted * factor * affine.stiffness * contact.stationary(v) * decay / transport
}
