//! The bristles of a rolling patch, followed one by one: the closed form of every held step along a
//! characteristic, and quadrature over the patch. Nothing of the library but a model's
//! coefficients.

#![allow(dead_code, unreachable_pub, reason = "the bench includes it, too")]

/// A step with everything held, as the bristles see it.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    /// λ [1/s]
    pub relaxation: f64,
    /// r v [m/s]
    pub drive: f64,
    /// V [1/s]
    pub transport: f64,
    /// h [s]
    pub duration: f64,
}

impl Step {
    pub fn way(&self) -> f64 {
        self.transport * self.duration
    }

    /// What a deflection becomes in some part of the step: z e^(−λt) + u (1 − e^(−λt))/λ.
    pub fn relax(&self, z: f64, time: f64) -> f64 {
        let x = self.relaxation * time;
        let gained = if x == 0.0 {
            self.drive * time
        } else {
            self.drive / self.relaxation * -(-x).exp_m1()
        };
        (-x).exp() * z + gained
    }
}

/// What happened since the bristle that is now at the outlet came in, and the profile before that.
pub struct History<'a> {
    pub steps: std::collections::VecDeque<Step>,
    initial: &'a dyn Fn(f64) -> f64,
    /// Places where the initial profile has kinks.
    kinks: &'a [f64],
}

impl<'a> History<'a> {
    pub fn new(initial: &'a dyn Fn(f64) -> f64, kinks: &'a [f64]) -> Self {
        Self { steps: std::collections::VecDeque::new(), initial, kinks }
    }

    pub fn push(&mut self, step: Step) {
        self.steps.push_back(step);
        if self.steps.len().is_multiple_of(1024) {
            // What is beyond two transits no bristle remembers.
            let (mut way, mut keep) = (0.0, 0);
            for step in self.steps.iter().rev() {
                keep += 1;
                way += step.way();
                if way > 2.0 {
                    self.steps.drain(..self.steps.len() - keep);
                    break;
                }
            }
        }
    }

    /// ∫₀¹ p z dξ: between the places where the profile is not smooth by Gauss–Legendre quadrature
    /// in panels over which no exponential falls by more than e^−2.
    pub fn weighted(&self, pressure: &dyn Fn(f64) -> f64, steepness: f64) -> f64 {
        let gauss = gauss();
        let panels = |from: f64, to: f64, steep: f64, z: &dyn Fn(f64) -> f64| {
            let mut sum = 0.0;
            let mut panel = |from: f64, to: f64| {
                for (node, weight) in &gauss {
                    let place = from + (to - from) * node;
                    sum += (to - from) * weight * pressure(place) * z(place);
                }
            };
            let width = 2.0 / (steep / (to - from) + steepness);
            let mut place = from;
            // A layer near the inlet side is all there is to resolve: e^−44 is nothing.
            for _ in 0..22 {
                if place + width >= to {
                    break;
                }
                panel(place, place + width);
                place += width;
            }
            let rest = ((to - place) * steepness / 2.0).ceil().max(1.0);
            let (begin, length) = (place, (to - place) / rest);
            for number in 0..rest as usize {
                panel(begin + length * number as f64, begin + length * (number + 1) as f64);
            }
            sum
        };
        let mut total = 0.0;
        let mut place = 0.0;
        // What became since of a bristle: z ← a z + b.
        let (mut a, mut b) = (1.0, 0.0);
        for step in self.steps.iter().rev() {
            let way = step.way();
            if way > 0.0 {
                let to = (place + way).min(1.0);
                let steep = step.relaxation * step.duration * (to - place) / way;
                let z = |xi: f64| {
                    a * step.relax(0.0, ((xi - place) / step.transport).min(step.duration)) + b
                };
                total += panels(place, to, steep, &z);
                place += way;
            }
            if place >= 1.0 {
                return total;
            }
            b += a * step.relax(0.0, step.duration);
            a *= (-step.relaxation * step.duration).exp();
        }
        let mut from = place;
        for kink in self.kinks.iter().map(|kink| kink + place).chain([1.0]) {
            if kink > from {
                let to = kink.min(1.0);
                total += panels(from, to, 0.0, &|xi| a * (self.initial)(xi - place) + b);
                from = to;
            }
            if from >= 1.0 {
                break;
            }
        }
        total
    }

    /// The deflection at one place: its bristle is followed back to where it came in, and forth
    /// again.
    pub fn deflection(&self, place: f64) -> f64 {
        let (mut left, mut first) = (place, self.steps.len());
        let mut entered = None;
        while first > 0 {
            first -= 1;
            let way = self.steps[first].way();
            if left < way {
                entered = Some(left / self.steps[first].transport);
                break;
            }
            left -= way;
        }
        let (mut z, rest) = match entered {
            Some(time) => (self.steps[first].relax(0.0, time), first + 1),
            None => ((self.initial)(left), 0),
        };
        for step in self.steps.iter().skip(rest) {
            z = step.relax(z, step.duration);
        }
        z
    }
}

/// Twelve-point Gauss–Legendre nodes and weights on [0, 1]: Legendre's recurrence and Newton's
/// method.
pub fn gauss() -> [(f64, f64); 12] {
    std::array::from_fn(|i| {
        let n = 12.0;
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut last, mut p) = (1.0, x);
            for k in 2..=12 {
                let k = f64::from(k);
                (last, p) = (p, ((2.0 * k - 1.0) * x * p - (k - 1.0) * last) / k);
            }
            slope = n * (x * p - last) / (x * x - 1.0);
            x -= p / slope;
        }
        (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
    })
}

/// Bristles under velocities that vary smoothly, undeflected at the beginning. From
/// z(ξ, t) = ∫ u(τ) e^(−∫λ) dτ since the bristle came in, with the integrals over τ and ξ swapped,
///
/// ∫₀¹ p z dξ = ∫ u(τ) e^(−∫_τ^t λ) ∫_x^1 p dξ dτ,  x = ∫_τ^t V
///
/// from the time on at which x = 1.
pub struct SmoothHistory<'a> {
    /// λ and u = r v at a time.
    pub coefficients: &'a dyn Fn(f64) -> (f64, f64),
    /// V at a time.
    pub transport: &'a dyn Fn(f64) -> f64,
    /// Times at which one of them is not smooth, in order.
    pub kinks: &'a [f64],
    /// Length of a panel of twelve Gauss points [s].
    pub panel: f64,
}

impl SmoothHistory<'_> {
    /// ∫₀¹ p z dξ at a time, from ∫_x^1 p dξ.
    pub fn weighted(&self, from: f64, to: f64, rest: &dyn Fn(f64) -> f64) -> f64 {
        let gauss = gauss();
        // λ and V between two times.
        let passed = |from: f64, to: f64| {
            let (mut relaxed, mut way) = (0.0, 0.0);
            for (node, weight) in gauss {
                let time = from + (to - from) * node;
                relaxed += (to - from) * weight * (self.coefficients)(time).0;
                way += (to - from) * weight * (self.transport)(time);
            }
            (relaxed, way)
        };
        let (mut end, mut sum) = (to, 0.0);
        let (mut relaxed, mut way) = (0.0, 0.0);
        while end > from && way < 1.0 {
            let mut begin = (end - self.panel).max(from);
            for &kink in self.kinks {
                if kink < end && kink > begin {
                    begin = kink;
                }
            }
            let (more, further) = passed(begin, end);
            let last = way + further > 1.0;
            if last {
                // The bristle at the outlet came in within this panel.
                let (mut low, mut high) = (begin, end);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if way + passed(middle, end).1 > 1.0 { low = middle } else { high = middle }
                }
                begin = high;
            }
            for (node, weight) in gauss {
                let time = begin + (end - begin) * node;
                let (own, on) = passed(time, end);
                let (_, drive) = (self.coefficients)(time);
                let place = (way + on).min(1.0);
                sum += (end - begin) * weight * drive * (-(relaxed + own)).exp() * rest(place);
            }
            if last {
                break;
            }
            (relaxed, way, end) = (relaxed + more, way + further, begin);
        }
        sum
    }
}
