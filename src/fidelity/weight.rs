//! What a step and an answer cost, in right-hand sides of FrBD with a Stribeck curve of δ = 2 (one `exp`).
//!
//! Ratios measured in one run of 400 000 steps each on one core, velocities included, rounded: right-hand
//! side 9 to 10 ns, curve 12, Dahl's step and force 6.5, FrBD's step 17 and with the force 22.5, collocation with
//! three nodes 115 of which 25 are the sine, Zener's step and force 440.

/// The friction curve at a velocity.
pub(super) const CURVE: f64 = 1.0;
/// The force of a bristle whose step is done.
pub(super) const FORCE: f64 = 0.8;
/// An exact step of Dahl's bristle; the force is a product.
pub(super) const DAHL_HOLD: f64 = 0.7;
/// An exact step of FrBD with one spring.
pub(super) const HOLD: f64 = 1.7;
/// A step of collocation with three nodes.
pub(super) const COLLOCATION: f64 = 9.0;
/// An exact step of a bristle of several springs: a matrix exponential.
pub(super) const MATRIX_HOLD: f64 = 43.0;
/// A step of the implicit bristle: looks at the friction curve, counted. In Table 2 it is 23 on average over steps of all
/// lengths, and fewer where it sticks.
pub(super) const SOLVED_HOLD: f64 = 24.0;
/// The force of the implicit bristle: looks at the friction curve of one solution.
pub(super) const SOLVED_FORCE: f64 = 5.0;
