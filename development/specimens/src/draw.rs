//! Random scenes: numbers from a seed, and signals of every kind.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use bristle::signal::{Polyline, Signal, Sine, SineParameters, Vertex};

/// Uniform numbers in [0, 1) by the 64-bit linear congruential generator of Knuth (MMIX), upper 53
/// bits.
pub struct Draw(pub u64);

impl Draw {
    /// Of the seed `BRISTLE_SEED`, or of the one given.
    pub fn seeded(default: u64) -> Self {
        let seed = std::env::var("BRISTLE_SEED").ok().and_then(|seed| seed.parse().ok());
        Self(seed.unwrap_or(default))
    }

    pub fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn one_of<A: Copy>(&mut self, all: &[A]) -> A {
        all[((self.next() * all.len() as f64) as usize).min(all.len() - 1)]
    }

    pub fn logarithmic(&mut self, from: f64, to: f64) -> f64 {
        from * (to / from).powf(self.next())
    }

    /// −1 or 1.
    pub fn sign(&mut self) -> f64 {
        if self.next() < 0.5 { -1.0 } else { 1.0 }
    }

    /// A Gaussian number by Box and Muller.
    pub fn gauss(&mut self) -> f64 {
        let (a, b) = (1.0 - self.next(), self.next());
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }

    /// An autoregressive series of variance one.
    pub fn coloured(mut self, correlation: f64) -> impl Iterator<Item = f64> {
        let mut state = 0.0;
        let news = (1.0 - correlation * correlation).sqrt();
        std::iter::repeat_with(move || {
            state = correlation * state + news * self.gauss();
            state
        })
    }

    /// A signal about a mean with an amplitude and a frequency: smooth, with declared kinks and
    /// jumps, with jumps and corners that it keeps to itself, or steep.
    pub fn wave(&mut self, mean: f64, amplitude: f64, frequency: f64, end: f64) -> Wave {
        let phase = self.one_of(&[0.0, 0.25, 0.1, 0.4]);
        let declared = self.next() < 0.5;
        let repeated =
            |shape| Wave::Repeated { shape, mean, amplitude, frequency, phase, declared };
        match self.one_of(&[0, 0, 0, 1, 2, 2, 3, 4]) {
            0 => {
                let phase = std::f64::consts::TAU * phase;
                let sine = SineParameters { mean, amplitude, frequency, phase };
                Wave::Sine(Sine::new(sine).unwrap())
            }
            1 => {
                let mut time = 0.0;
                let vertices = [(); 12].map(|()| {
                    let value = mean + amplitude * (2.0 * self.next() - 1.0);
                    let vertex = Vertex { time, value };
                    time += end * (0.01 + 0.15 * self.next());
                    vertex
                });
                Wave::Line(Polyline::new(vertices).unwrap())
            }
            2 => repeated(Shape::Square),
            3 => repeated(Shape::Triangle),
            _ => repeated(Shape::Steep(self.logarithmic(3.0, 30.0))),
        }
    }
}

/// What [`Draw::wave`] draws.
#[derive(Debug, Clone)]
pub enum Wave {
    Sine(Sine<f64>),
    Line(Polyline<[Vertex<f64>; 12]>),
    Repeated {
        shape: Shape,
        mean: f64,
        amplitude: f64,
        frequency: f64,
        phase: f64,
        /// Whether it tells of its jumps and corners.
        declared: bool,
    },
}

impl Wave {
    /// The same values, with all jumps and corners declared.
    pub fn declared(mut self) -> Self {
        if let Wave::Repeated { declared, .. } = &mut self {
            *declared = true;
        }
        self
    }
}

/// The shape of one period.
#[derive(Debug, Clone, Copy)]
pub enum Shape {
    Square,
    Triangle,
    /// tanh(s sin): a square with flanks of so much the slope of a sine.
    Steep(f64),
}

/// When so many half periods are over.
fn half_period(halves: f64, frequency: f64, phase: f64) -> f64 {
    (0.5 * halves - phase) / frequency
}

/// Half periods that are over at a time.
fn half_periods(time: f64, frequency: f64, phase: f64) -> f64 {
    let about = (2.0 * (time * frequency + phase)).round();
    if half_period(about, frequency, phase) <= time { about } else { about - 1.0 }
}

impl Signal<f64> for Wave {
    fn value(&self, time: f64) -> f64 {
        self.value_and_rate(time).0
    }

    fn value_and_rate(&self, time: f64) -> (f64, f64) {
        match self {
            Wave::Sine(sine) => sine.value_and_rate(time),
            Wave::Line(line) => line.value_and_rate(time),
            Wave::Repeated { shape, mean, amplitude, frequency, phase, .. } => {
                // At the last digit of a jump it is over, as the signal says that it is.
                let halves = half_periods(time, *frequency, *phase);
                let since = time - half_period(halves, *frequency, *phase);
                let place = 0.5 * halves.rem_euclid(2.0) + (since * frequency).min(0.5);
                let (value, rate) = match shape {
                    Shape::Square => (if place < 0.5 { 1.0 } else { -1.0 }, 0.0),
                    Shape::Triangle if place < 0.5 => (4.0 * place - 1.0, 4.0),
                    Shape::Triangle => (3.0 - 4.0 * place, -4.0),
                    Shape::Steep(slope) => {
                        let (sin, cos) = (std::f64::consts::TAU * place).sin_cos();
                        let value = (slope * sin).tanh();
                        (value, (1.0 - value * value) * slope * cos * std::f64::consts::TAU)
                    }
                };
                (mean + amplitude * value, amplitude * rate * frequency)
            }
        }
    }

    fn next_kink(&self, time: f64, towards: f64) -> Option<f64> {
        match self {
            Wave::Line(line) => line.next_kink(time, towards),
            Wave::Repeated { declared: true, frequency, phase, .. } => {
                assert!(towards > time, "kinks are only looked for ahead");
                let next =
                    half_period(half_periods(time, *frequency, *phase) + 1.0, *frequency, *phase);
                Some(next).filter(|next| *next < towards)
            }
            _ => None,
        }
    }
}
