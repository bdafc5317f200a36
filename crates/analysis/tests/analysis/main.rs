//! Audits, ledgers and linear analysis.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

mod audit;
mod ledger;
mod linear;

use bristle::Scalar;
use bristle::curve::{Coulomb, CoulombParameters};
use bristle_specimens::lit;

fn coulomb<T: Scalar>(dynamic_coefficient: f64, viscous_friction: f64) -> Coulomb<T> {
    let [dynamic_coefficient, viscous_friction] = [dynamic_coefficient, viscous_friction].map(lit);
    Coulomb::new(CoulombParameters { dynamic_coefficient, viscous_friction }).unwrap()
}
