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

// Of a patch under a parabolic pressure, in another run of 100 000 steps each, best of nine, right-hand side 8 ns. The
// first four hold within some 20 % for other pressures in closed form (constant pressure costs half).

/// The steady force of a patch: 200 ns.
pub(super) const SLIP_CURVE: f64 = 25.0;
/// A step of the relaxation length besides the steady force: one `exp`.
pub(super) const RELAXATION: f64 = 1.1;
/// A step of the exact reduction at a held motion: 430 to 480 ns with the force.
pub(super) const PATCH_HOLD: f64 = 45.0;
/// The same of fourth order: 600 to 860 ns with the force.
pub(super) const PATCH_GAUSS: f64 = 80.0;
/// The force of a patch whose step is done.
pub(super) const PATCH_FORCE: f64 = 15.0;
/// A step of a grid between whole Courant numbers, for each cell: 2.4 µs for 96 and 11 µs for 384 cells.
pub(super) const GRID_CELL: f64 = 3.5;
/// The same besides its cells.
pub(super) const GRID_STEP: f64 = 10.0;

// Steps of a mechanism, in the same unit, a sine force and a ramp of the base included: right-hand side 12.1 ns, Dahl's
// passive step 37, FrBD's 42.5, that of the static curve 47.5 while it slides (the curve is 18 of them); under error control 57 ns
// an evaluation with Dormand–Prince 8, and 71 ns with Rodas5P and its Jacobians, an eighth of the evaluations.

/// A step of a mass under dry friction without memory, but for the curve.
pub(super) const SLIDE: f64 = 2.4;
/// The static force of a model, deflection and all.
pub(super) const STEADY: f64 = 1.5;
/// A passive step of a mass on Dahl's bristle.
pub(super) const DAHL_COMPANION: f64 = 3.1;
/// The same on FrBD's.
pub(super) const COMPANION: f64 = 3.5;
/// One evaluation of a right-hand side under error control, the method around it included.
pub(super) const STAGE: f64 = 4.7;
/// A Jacobian, and its decomposition.
pub(super) const JACOBIAN: f64 = 9.6;
/// An answer between two steps under error control: a polynomial.
pub(super) const DENSE: f64 = 1.0;
