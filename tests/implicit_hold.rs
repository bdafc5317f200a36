//! The step of the implicit bristle at a held velocity, beside an integration of its own with tiny steps: which finds the tip by
//! bisection, ends a step where the tip begins or ceases to stick or changes its branch, and is of fourth order in between.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test panics to fail")]

use bristle::{
    Bristle, Exact, FoldRule, ImplicitBristle, ImplicitBristleParameters, KelvinVoigt,
    KelvinVoigtParameters, Regularisation, SquareRoot, Stribeck, StribeckParameters, paper,
};

type Model<E> = ImplicitBristle<f64, Stribeck<f64>, E>;

/// Uniform numbers in [0, 1) by the 64-bit linear congruential generator of Knuth (MMIX), upper 53 bits.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn logarithmic(&mut self, from: f64, to: f64) -> f64 {
        from * (to / from).powf(self.next())
    }
}

/// A set of parameters.
#[derive(Debug, Clone, Copy)]
struct Set {
    curve: StribeckParameters<f64>,
    bristle: KelvinVoigtParameters<f64, f64>,
    rule: Option<FoldRule>,
    /// √ε [m/s], or zero.
    rest: f64,
}

const TABLE_2: Set = Set {
    curve: paper::STICK_SLIP_CURVE,
    bristle: paper::STICK_SLIP_BRISTLE,
    rule: None,
    rest: 0.0,
};

impl Set {
    fn model(&self) -> Model<Exact> {
        ImplicitBristle::new(ImplicitBristleParameters {
            curve: Stribeck::new(self.curve).unwrap(),
            rheology: KelvinVoigt::new(self.bristle).unwrap(),
            fold_rule: self.rule,
        })
        .unwrap()
    }

    fn regularised(&self) -> Model<SquareRoot<f64>> {
        self.model().regularised(SquareRoot::new(self.rest * self.rest).unwrap())
    }

    /// Table 2; the same folded, with a valley below and above what sticks at rest; Table 1. Sharp, and regularised.
    fn all() -> Vec<Set> {
        let mut sets = vec![TABLE_2, Set { rest: 1e-5, ..TABLE_2 }];
        for rule in [FoldRule::Slowest, FoldRule::Fastest] {
            let table_1 = Set {
                curve: paper::TYRE_CURVE,
                bristle: paper::TYRE_BRISTLE,
                rule: Some(rule),
                rest: 0.0,
            };
            let damped = |micro_damping| Set {
                bristle: KelvinVoigtParameters { micro_stiffness: 1e4, micro_damping },
                rule: Some(rule),
                ..TABLE_2
            };
            for set in [table_1, damped(5.0), damped(35.0)] {
                let rest = 1e-3 * set.curve.stribeck_velocity;
                sets.extend([set, Set { rest, ..set }]);
            }
        }
        sets
    }

    fn mu(&self, u: f64) -> f64 {
        let StribeckParameters { static_coefficient, dynamic_coefficient, .. } = self.curve;
        let x = u / self.curve.stribeck_velocity;
        dynamic_coefficient
            + (static_coefficient - dynamic_coefficient) * (-x * x).exp()
            + self.curve.viscous_friction * u
    }

    /// Φ for u > 0, and at zero just above.
    fn phi(&self, u: f64) -> f64 {
        let sign = if self.rest > 0.0 { u / u.hypot(self.rest) } else { 1.0 };
        self.bristle.micro_damping * u + self.mu(u) * sign
    }

    /// By bisection over [low, high], the end where Φ does not reach the load.
    fn speed(&self, load: f64, (mut low, mut high): (f64, f64)) -> f64 {
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
    fn fold(&self) -> Option<(f64, f64, f64)> {
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
                let slow = if self.phi(0.0) >= load { 0.0 } else { self.speed(load, (0.0, summit)) };
                (load, slow, valley)
            }
        })
    }

    /// Deflection after so long, and the mean coefficient.
    fn truth(&self, v: f64, mut z: f64, h: f64) -> (f64, f64) {
        let KelvinVoigtParameters { micro_stiffness: s0, micro_damping: s1 } = self.bristle;
        let fold = self.fold();
        // −2 … 2: the sign of the load, and 0 sticking, 1 before, 2 beyond the fold.
        let mode = |z: f64| {
            let load = s0 * z + s1 * v;
            let beyond = fold.is_some_and(|(most, ..)| load.abs() > most);
            let sticks = self.rest == 0.0 && load.abs() <= self.phi(0.0) && !beyond;
            let way = if load < 0.0 { -1 } else { 1 };
            if sticks { 0 } else if beyond { 2 * way } else { way }
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
            // A fiftieth of what it takes to change the load, Φ' and the tip's speed, but never a millionth.
            let slope = |u: f64| {
                let d = 1e-4 * (u.abs() + self.rest + 1e-6 * self.curve.stribeck_velocity);
                (self.phi(u.abs() + d) - self.phi(u.abs())) / d
            };
            let load_time = self.mu(0.0) / (s0 * gap.abs());
            let mut dt = 0.02 * load_time;
            if now != 0 {
                let scale = u.abs() + self.rest + 0.05 * self.curve.stribeck_velocity;
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

#[derive(Debug, Clone, Copy)]
struct Scene {
    velocity: f64,
    deflection: f64,
    duration: f64,
}

fn draw(dice: &mut Draw, set: &Set) -> Scene {
    let unit = set.curve.stribeck_velocity;
    let sign = if dice.next() < 0.5 { -1.0 } else { 1.0 };
    Scene {
        velocity: sign * dice.logarithmic(1e-4 * unit, 1e3 * unit),
        deflection: (2.6 * dice.next() - 1.3) * set.mu(0.0) / set.bristle.micro_stiffness,
        duration: dice.logarithmic(1e-7, 1e3),
    }
}

fn assert_true<E: Regularisation<f64>>(set: &Set, model: &Model<E>, scene: Scene) -> bool {
    let Scene { velocity, deflection, duration } = scene;
    let held = model.hold(velocity, deflection, duration);
    let (end, mean) = set.truth(velocity, deflection, duration);
    let full = set.mu(0.0) / set.bristle.micro_stiffness;
    // The reference errs by some (1/50)⁴/100, and by the last millionth before a fold.
    let off = (held.deflection - end).abs() / full;
    let mut ok = off < 1e-6;
    if !ok { println!("{set:?} {scene:?}: {:e} for {end:e}, {off:e}", held.deflection); }
    let off = (held.mean - mean).abs() / (set.mu(0.0) + set.mu(velocity.abs()));
    if !(off < 1e-6) { println!("{set:?} {scene:?}: mean {} for {mean}, {off:e}", held.mean); ok=false; }
    ok
}

#[test]
fn a_step_of_any_length_is_what_tiny_steps_come_to() {
    let mut dice = Draw(1);
    let mut bad=0;
    for set in Set::all() {
        let start = std::time::Instant::now();
        for _ in 0..25 {
            let scene = draw(&mut dice, &set);
            let ok = if set.rest > 0.0 {
                assert_true(&set, &set.regularised(), scene)
            } else {
                assert_true(&set, &set.model(), scene)
            };
            if !ok {bad+=1;}
        }
        println!("TIME {:?} {set:?}", start.elapsed());
    }
    assert_eq!(bad,0);
}
