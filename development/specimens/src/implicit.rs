//! The implicit bristle along a held velocity, by an integration of its own with tiny steps, which
//! finds the tip by bisection, ends a step where the tip begins or ceases to stick, and is of
//! fourth order in between.

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{ImplicitBristle, paper};

type Model = ImplicitBristle<Stribeck<f64>>;

/// A set of parameters.
#[derive(Debug, Clone, Copy)]
pub struct Set {
    pub curve: StribeckParameters<f64>,
    pub bristle: KelvinVoigtParameters<f64>,
}

pub const TABLE_2: Set = Set { curve: paper::STICK_SLIP_CURVE, bristle: paper::STICK_SLIP_BRISTLE };

impl Set {
    pub fn model(&self) -> Model {
        ImplicitBristle::new(
            Stribeck::new(self.curve).unwrap(),
            KelvinVoigt::new(self.bristle).unwrap(),
        )
        .unwrap()
    }

    /// Table 2 (σ1 + min dμ/d|v| is 22 s/m), the same hardly damped enough (0.05 s/m), and a light
    /// one, where the tip is fast: Table 1 on a dashpot.
    pub fn all() -> [Set; 3] {
        let damped = |curve, micro_stiffness, micro_damping| Set {
            curve,
            bristle: KelvinVoigtParameters { micro_stiffness, micro_damping },
        };
        [TABLE_2, damped(TABLE_2.curve, 1e4, 42.9), damped(paper::TYRE_CURVE, 252.0, 0.04)]
    }

    pub fn mu(&self, u: f64) -> f64 {
        let StribeckParameters { static_coefficient, dynamic_coefficient, .. } = self.curve;
        let x = u / self.curve.stribeck_velocity;
        dynamic_coefficient
            + (static_coefficient - dynamic_coefficient) * (-x * x).exp()
            + self.curve.viscous_friction * u
    }

    /// Φ for u > 0, and at zero just above.
    pub fn phi(&self, u: f64) -> f64 {
        self.bristle.micro_damping * u + self.mu(u)
    }

    /// By bisection over [low, high], the end where Φ does not reach the load.
    pub fn speed(&self, load: f64, (mut low, mut high): (f64, f64)) -> f64 {
        for _ in 0..90 {
            let middle = if low > 0.0 && high > 4.0 * low {
                (low * high).sqrt()
            } else {
                0.5 * (low + high)
            };
            if self.phi(middle) < load { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    /// Deflection after so long, and the mean coefficient.
    pub fn truth(&self, v: f64, mut z: f64, h: f64) -> (f64, f64) {
        let KelvinVoigtParameters { micro_stiffness: s0, micro_damping: s1 } = self.bristle;
        // The sign of the load where it slides, 0 where it sticks.
        let mode = |z: f64| {
            let load = s0 * z + s1 * v;
            if load.abs() <= self.phi(0.0) { 0.0 } else { load.signum() }
        };
        let tip = |mode: f64, z: f64| {
            if mode == 0.0 { 0.0 } else { mode * self.speed((s0 * z + s1 * v) * mode, (0.0, 1e6)) }
        };
        let (mut left, mut impulse) = (h, 0.0);
        for _ in 0..200_000 {
            let now = mode(z);
            let u = tip(now, z);
            let gap = v - u;
            if gap.abs() <= 1e-9 * v.abs().min(self.curve.stribeck_velocity) {
                impulse += left * s0 * z;
                left = 0.0;
            }
            if left <= 0.0 {
                return (z, impulse / h);
            }
            // A fiftieth of what it takes to change the load, Φ' and the tip's speed, but never a
            // millionth.
            let slope = |u: f64| {
                let d = 1e-4 * (u.abs() + 1e-6 * self.curve.stribeck_velocity);
                (self.phi(u.abs() + d) - self.phi(u.abs())) / d
            };
            let load_time = self.mu(0.0) / (s0 * gap.abs());
            let mut dt = 0.02 * load_time;
            if now != 0.0 {
                let scale = u.abs() + 0.05 * self.curve.stribeck_velocity;
                let phi = slope(u).max(0.0);
                dt = dt.min(0.02 * phi / s0).min(0.02 * scale * phi / (s0 * gap.abs()));
                dt = dt.max(1e-6 * self.mu(0.0) / (s0 * (v.abs() + u.abs())));
            }
            let mut dt = dt.min(left);
            let advance = |dt: f64| {
                let (mut rate, mut force) = (0.0, 0.0);
                let mut k = 0.0;
                for (part, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
                    let at = z + part * dt * k;
                    let tip = tip(now, at);
                    k = v - tip;
                    rate += weight / 6.0 * k;
                    force += weight / 6.0 * (s0 * at + s1 * k);
                }
                (z + dt * rate, dt * force)
            };
            if mode(advance(dt).0) != now {
                let (mut low, mut high) = (0.0, dt);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if mode(advance(middle).0) == now { low = middle } else { high = middle }
                }
                dt = high;
            }
            let (to, added) = advance(dt);
            (z, left, impulse) = (to, left - dt, impulse + added);
        }
        panic!("{self:?} at {v:e} from {z:e}: {left:e} of {h:e} s left");
    }
}
