//! What an evaluation costs, in evaluations of rate and force of FrBD with one spring and a
//! Stribeck curve of exponent 2, whose one `exp` is most of it.
//!
//! Ratios of `cargo bench -p bristle --bench cost`, rounded; they differ by some 20 % between
//! machines.

/// The friction curve at a velocity.
pub(super) const CURVE: f64 = 1.0;
/// The force of a bristle whose step is done.
pub(super) const FORCE: f64 = 0.8;
/// An exact step of Dahl's bristle: an `exp` and no curve.
pub(super) const DAHL_HOLD: f64 = 0.7;
/// An exact step of a bristle of one spring.
pub(super) const HOLD: f64 = 1.7;
/// An exact step of a bristle of several springs: a matrix exponential.
pub(super) const MATRIX_HOLD: f64 = 43.0;
/// A step of the implicit bristle, whose tip velocity is solved for again and again.
pub(super) const IMPLICIT_HOLD: f64 = 24.0;
/// The force of the implicit bristle: one such solution.
pub(super) const IMPLICIT_FORCE: f64 = 5.0;

// A patch under a parabolic pressure, from `cargo bench -p bristle-rolling`; some 20 % less
// under an exponential one, half under a constant one.

/// The steady force of a patch.
pub(super) const SLIP_CURVE: f64 = 25.0;
/// The lag of a relaxation length: one `exp`.
pub(super) const LAG: f64 = 1.1;
/// An evaluation of the friction model in a step of the exact reduction, whose queue is the cost.
pub(super) const PATCH: f64 = 42.0;
/// The force of a patch whose step is done.
pub(super) const PATCH_FORCE: f64 = 15.0;

// A mass under friction, drive and force included.

/// A step of a mass under dry friction without memory, besides the curve.
pub(super) const SLIDE: f64 = 2.4;
/// A passive step of a mass on Dahl's bristle.
pub(super) const DAHL_COMPANION: f64 = 3.1;
/// A passive step of a mass on any other bristle of one deflection.
pub(super) const COMPANION: f64 = 3.5;
