//! The implicit bristle along a held velocity, by an integration of its own with tiny steps, which
//! finds the tip by bisection, ends a step where the tip begins or ceases to stick or changes its
//! branch, and is of fourth order in between.

use bristle::curve::{Stribeck, StribeckParameters};
use bristle::rheology::{KelvinVoigt, KelvinVoigtParameters};
use bristle::{FoldRule, ImplicitBristle, paper};

type Model = ImplicitBristle<Stribeck<f64>>;

/// A set of parameters.
#[derive(Debug, Clone, Copy)]
pub struct Set {
    pub curve: StribeckParameters<f64>,
    pub bristle: KelvinVoigtParameters<f64, f64>,
    pub rule: Option<FoldRule>,
}

pub const TABLE_2: Set =
    Set { curve: paper::STICK_SLIP_CURVE, bristle: paper::STICK_SLIP_BRISTLE, rule: None };

impl Set {
    pub fn model(&self) -> Model {
        ImplicitBristle::new(
            Stribeck::new(self.curve).unwrap(),
            KelvinVoigt::new(self.bristle).unwrap(),
            self.rule,
        )
        .unwrap()
    }

    /// Table 2; the same folded, with a valley below and above what sticks at rest; Table 1.
    pub fn all() -> Vec<Set> {
        let mut sets = vec![TABLE_2];
        for rule in [FoldRule::Slowest, FoldRule::Fastest] {
            let table_1 =
                Set { curve: paper::TYRE_CURVE, bristle: paper::TYRE_BRISTLE, rule: Some(rule) };
            let damped = |micro_damping| Set {
                bristle: KelvinVoigtParameters { micro_stiffness: 1e4, micro_damping },
                rule: Some(rule),
                ..TABLE_2
            };
            sets.extend([table_1, damped(5.0), damped(35.0)]);
        }
        sets
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

    /// E*, u⁻ and u⁺: the turns of Φ by golden section from a sample of 20 000 speeds.
    pub fn fold(&self) -> Option<(f64, f64, f64)> {
        let rule = self.rule?;
        let top = 10.0 * self.curve.stribeck_velocity;
        let at = |i: f64| top * (i / 20_000.0).powi(3);
        let falls = |i: &i32| self.phi(at(f64::from(*i) + 1.0)) < self.phi(at(f64::from(*i)));
        let turn = |i: i32, sign: f64| {
            let (mut low, mut high) = (at(f64::from(i - 1).max(0.0)), at(f64::from(i + 1)));
            for _ in 0..120 {
                let (a, b) = (low + 0.382 * (high - low), low + 0.618 * (high - low));
                if sign * self.phi(a) > sign * self.phi(b) { high = b } else { low = a }
            }
            0.5 * (low + high)
        };
        let first = (0..20_000).find(falls)?;
        let last = (0..20_000).rev().find(falls)?;
        let (summit, valley) = (turn(first, 1.0), turn(last + 1, -1.0));
        Some(match rule {
            FoldRule::Slowest => {
                let load = self.phi(summit);
                (load, summit, self.speed(load, (valley, 1e6)))
            }
            FoldRule::Fastest => {
                let load = self.phi(valley);
                let slow =
                    if self.phi(0.0) >= load { 0.0 } else { self.speed(load, (0.0, summit)) };
                (load, slow, valley)
            }
        })
    }

    /// Deflection after so long, and the mean coefficient.
    pub fn truth(&self, v: f64, z: f64, h: f64) -> (f64, f64) {
        self.truth_about(&self.fold(), v, z, h)
    }

    /// The same with a fold that is known already.
    pub fn truth_about(
        &self,
        fold: &Option<(f64, f64, f64)>,
        v: f64,
        mut z: f64,
        h: f64,
    ) -> (f64, f64) {
        let KelvinVoigtParameters { micro_stiffness: s0, micro_damping: s1 } = self.bristle;
        let fold = *fold;
        // −2 … 2: the sign of the load, and 0 sticking, 1 before, 2 beyond the fold.
        let mode = |z: f64| {
            let load = s0 * z + s1 * v;
            let beyond = fold.is_some_and(|(most, ..)| load.abs() > most);
            let sticks = load.abs() <= self.phi(0.0) && !beyond;
            let way = if load < 0.0 { -1 } else { 1 };
            if sticks {
                0
            } else if beyond {
                2 * way
            } else {
                way
            }
        };
        let tip = |mode: i32, z: f64| {
            let load = s0 * z + s1 * v;
            let (slow, fast) = fold.map_or((1e6, 1e6), |(_, slow, fast)| (slow, fast));
            match mode {
                0 => 0.0,
                1 | -1 => load.signum() * self.speed(load.abs(), (0.0, slow)),
                _ => load.signum() * self.speed(load.abs(), (fast, 1e6)),
            }
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
            if now != 0 {
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
            let next = mode(to);
            (z, left, impulse) = (to, left - dt, impulse + added);
            let crossed = next != now && (next.abs() == 2 || now.abs() == 2);
            if let (true, Some((load, slow, fast))) = (crossed, fold) {
                let w = v * (s0 * z + s1 * v).signum();
                if w >= slow && w <= fast {
                    let carried = (load - s1 * w) * (s0 * z + s1 * v).signum();
                    return (carried / s0, (impulse + left * carried) / h);
                }
            }
        }
        panic!("{self:?} at {v:e} from {z:e}: {left:e} of {h:e} s left");
    }
}
