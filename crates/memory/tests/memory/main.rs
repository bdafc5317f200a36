//! Laws of the Maxwell-slip model, its figures, and elements from virgin curves.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod laws;
mod loads;
mod loops;
mod record;
mod virgin_curve;

use bristle::curve::{Coulomb, CoulombParameters, Stribeck, StribeckParameters};

use bristle_memory::{Element, MaxwellSlip, MaxwellSlipParameters, Parallel};

/// μ = 1.
fn coulomb() -> Coulomb<f64> {
    let curve = CoulombParameters { dynamic_coefficient: 1.0, viscous_friction: 0.0 };
    Coulomb::new(curve).unwrap()
}

/// A curve that falls from 1.5 to 1 within some mm/s, and rises.
fn stribeck() -> Stribeck<f64> {
    Stribeck::new(StribeckParameters {
        static_coefficient: 1.5,
        dynamic_coefficient: 1.0,
        stribeck_velocity: 0.01,
        stribeck_exponent: 2.0,
        viscous_friction: 0.04,
    })
    .unwrap()
}

/// N equal springs with yield lengths (i + ½)/N · 2μ/σ0, σ0 = 1e4 1/m, μ = 1.
fn even<const N: usize>() -> [Element<f64>; N] {
    core::array::from_fn(|i| Element {
        stiffness: 1e4 / N as f64,
        yield_length: (i as f64 + 0.5) / N as f64 * 2e-4,
    })
}

fn slip<C: bristle::curve::FrictionCurve<f64>, const N: usize>(
    curve: C,
    micro_damping: f64,
    stick_ratio: f64,
) -> MaxwellSlip<C, f64, N> {
    MaxwellSlip::new(MaxwellSlipParameters { curve, elements: even(), micro_damping, stick_ratio })
        .unwrap()
}

fn zeros<const N: usize>() -> Parallel<f64, N> {
    Parallel::default()
}
