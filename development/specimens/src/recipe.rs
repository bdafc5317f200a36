//! Random admissible parameters and states, over many decades.

use proptest::prelude::*;

/// The parameters that all specimens of one test case share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recipe {
    /// Normal force p \[N\].
    pub load: f64,
    /// μ_d.
    pub dynamic: f64,
    /// μ_s.
    pub static_: f64,
    /// v_S [m/s].
    pub stribeck_velocity: f64,
    /// σ2 [s/m].
    pub viscous: f64,
    /// σ0 [1/m]; at rest, where it varies.
    pub stiffness: f64,
    /// σ1 [s/m]; its scale, where it varies.
    pub damping: f64,
    /// Velocity [m/s] over which a varying σ0 or σ1 varies.
    pub varying_velocity: f64,
    /// ε [m²/s²] of the square root.
    pub epsilon: f64,
    /// v_t [m/s] of the hyperbolic tangent.
    pub threshold: f64,
    /// Stick limit of the elasto-plastic model over its largest admissible value.
    pub stick_fraction: f64,
    /// Coefficients of the table, over μ_d.
    pub table: [f64; 5],
}

impl Recipe {
    /// Knot speeds of the table over v_S.
    pub const TABLE_SPEEDS: [f64; 5] = [0.0, 0.3, 1.0, 4.0, 20.0];

    /// The paper's Table 2 (σ0/(σ1 + σ2) = 1e4/64.54 1/s), with p = 1 N; what that table does not
    /// name is of the same order.
    pub const TABLE_2: Self = Self {
        load: 1.0,
        dynamic: 1.0,
        static_: 1.5,
        stribeck_velocity: 0.01,
        viscous: 0.04,
        stiffness: 1e4,
        damping: 64.5,
        varying_velocity: 1e-2,
        epsilon: 1e-10,
        threshold: 1e-5,
        stick_fraction: 0.6,
        table: [1.5, 1.4, 1.15, 1.02, 1.0],
    };

    /// The knots of the table: speed and coefficient.
    pub fn knots(&self) -> [(f64, f64); 5] {
        std::array::from_fn(|i| {
            (Self::TABLE_SPEEDS[i] * self.stribeck_velocity, self.table[i] * self.dynamic)
        })
    }
}

/// A state and a velocity, relative where an absolute value would say nothing.
#[derive(Debug, Clone)]
pub struct State {
    /// Deflection over the deflection limit, from −1 to 1, the ends included.
    pub fraction: f64,
    /// v [m/s].
    pub velocity: f64,
    /// λh, the length of a step in relaxation times.
    pub horizon: f64,
    /// Length of a step \[s\], for where λ = 0.
    pub duration: f64,
    /// Velocity over the fastest one, and λh, for a sequence of steps.
    pub chain: Vec<(f64, f64)>,
}

/// Uniform in the logarithm.
pub fn decades(least: f64, most: f64) -> impl Strategy<Value = f64> {
    (least.log10()..most.log10()).prop_map(|exponent| 10_f64.powf(exponent))
}

fn zero_or(strategy: impl Strategy<Value = f64>) -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 4 => strategy]
}

/// Velocities from 1e-9 to 1e3 m/s of both signs, and zero.
pub fn velocity() -> impl Strategy<Value = f64> {
    zero_or(nonzero_velocity())
}

/// Velocities from 1e-9 to 1e3 m/s of both signs.
pub fn nonzero_velocity() -> impl Strategy<Value = f64> {
    (decades(1e-9, 1e3), any::<bool>()).prop_map(|(v, backward)| if backward { -v } else { v })
}

/// Friction scales: 1, 0.3, 2, and from 1e-3 to 1e3.
pub fn scale() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(1.0), 1 => Just(0.3), 1 => Just(2.0), 3 => decades(1e-3, 1e3)]
}

/// From −1 to 1, with weight on the ends and the middle.
pub fn fraction() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(-1.0), 1 => Just(0.0), 1 => Just(1.0), 6 => -1.0..1.0]
}

prop_compose! {
    /// Random admissible parameters.
    pub fn recipe()(
        load in decades(1e-3, 1e6),
        dynamic in decades(1e-2, 1e1),
        drop in zero_or(decades(1e-3, 1e1)),
        stribeck_velocity in decades(1e-5, 1e1),
        viscous in zero_or(decades(1e-4, 1e3)),
        stiffness in decades(1e0, 1e9),
        damping in zero_or(decades(1e-2, 1e4)),
        varying_velocity in decades(1e-5, 1e1),
        epsilon in decades(1e-14, 1e2),
        threshold in decades(1e-7, 1e1),
        stick_fraction in 0.05..0.9,
        table in prop::array::uniform5(0.5..3.0),
    ) -> Recipe {
        Recipe {
            load, dynamic, static_: dynamic * (1.0 + drop), stribeck_velocity, viscous, stiffness,
            damping, varying_velocity, epsilon, threshold, stick_fraction, table,
        }
    }
}

prop_compose! {
    /// A random state.
    pub fn state()(
        fraction in fraction(),
        velocity in velocity(),
        horizon in decades(1e-9, 1e3),
        duration in decades(1e-9, 1e3),
        chain in prop::collection::vec((-1.0..=1.0, decades(1e-4, 1e2)), 8),
    ) -> State {
        State { fraction, velocity, horizon, duration, chain }
    }
}
