//! A bristle of one spring along a part of a scene, as an affine map of what it remembers.
//!
//! With s = ∫λ dt as the clock the equation of one direction of sliding is dy/ds = y_ss(s) − y, where
//! y = p σ0 z \[N\] is the memory and y_ss the stationary one, so that
//!
//! y(Λ) = e^−Λ y(0) + ∫₀^Λ e^−(Λ − s) y_ss(s) ds.
//!
//! A panel knows λ and y_ss at its start, middle and end. Parabolas through these (of λ over time, of y_ss over s) give a
//! map of fourth order, and the middle alone that of an exact hold. Panels are halved where that is not
//! enough; every look at the curve serves both the reference and the held steps that are tried beside it.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | λ, Λ | relaxation rate, relaxation over the panel | 1/s, – |
//! | y, y_ss | memory, and the stationary one | N |

use alloc::vec::Vec;

use super::{exp, exp_m1, size};

/// What is known at one instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    /// λ [1/s].
    pub(super) rate: f64,
    /// y_ss [N].
    pub(super) steady: f64,
}

/// y ↦ keep y + add.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Map {
    pub(super) keep: f64,
    pub(super) add: f64,
}

/// What a difference from two coarser maps of second order is larger than the error, at least.
const RAW: f64 = 4.0;
/// By what a difference of second order falls at least where halving resolves what happens: 8 where all is smooth.
const FALLS: f64 = 2.5;
/// What halving a panel changes is larger than the error that is left, at least: 15 at fourth order.
const HALVED: f64 = 8.0;

impl Map {
    pub(super) const IDENTITY: Map = Map { keep: 1.0, add: 0.0 };

    pub(super) fn at(self, memory: f64) -> f64 {
        self.keep * memory + self.add
    }

    /// This one, and then the next.
    pub(super) fn then(self, next: Map) -> Map {
        Map { keep: next.keep * self.keep, add: next.at(self.add) }
    }

    /// The exact step at one look.
    pub(super) fn held(look: Look, duration: f64) -> Map {
        let x = look.rate * duration;
        Map { keep: exp(-x), add: -exp_m1(-x) * look.steady }
    }

    /// y_ss a straight line between the ends.
    fn linear(ends: [Look; 2], duration: f64) -> Map {
        let [a, b] = ends;
        let x = 0.5 * (a.rate + b.rate) * duration;
        let [zeroth, first, _] = moments(x);
        Map { keep: exp(-x), add: zeroth * a.steady + first * (b.steady - a.steady) }
    }

    /// y_ss a parabola.
    fn parabola(a: Look, middle: Look, b: Look, duration: f64) -> Map {
        let x = (a.rate + 4.0 * middle.rate + b.rate) * duration / 6.0;
        let half = (5.0 * a.rate + 8.0 * middle.rate - b.rate) * duration / 24.0;
        // Where on the clock the middle lies: at the reversal of a ramp at ¼ or ¾.
        let place = half / x;
        let place = if place > 0.1 { if place < 0.9 { place } else { 0.9 } } else { 0.1 };
        let [zeroth, first, second] = moments(x);
        let (rise, half_rise) = (b.steady - a.steady, middle.steady - a.steady);
        // y_ss = a + slope θ + bend θ², θ = s/Λ.
        let bend = (rise - half_rise / place) / (1.0 - place);
        let slope = rise - bend;
        Map { keep: exp(-x), add: zeroth * a.steady + first * slope + second * bend }
    }
}

/// ∫₀^Λ e^−(Λ − s) (s/Λ)^j ds for j = 0, 1, 2.
fn moments(x: f64) -> [f64; 3] {
    if x < 0.5 {
        // Λ Σ (−Λ)^i j!/(i + j + 1)!: nine terms leave 1e-9 of it.
        let series = |j: u32| {
            let mut term = (1..=j + 1).fold(x, |t, k| t / f64::from(k));
            term *= f64::from(if j == 2 { 2 } else { 1 });
            let mut sum = term;
            for i in 1..9 {
                term *= -x / f64::from(i + j + 1);
                sum += term;
            }
            sum
        };
        return [series(0), series(1), series(2)];
    }
    let zeroth = -exp_m1(-x);
    let first = 1.0 - zeroth / x;
    [zeroth, first, 1.0 - 2.0 * first / x]
}

/// A part of a scene without a kink inside, and the looks at the middles of its halves, quarters, …
#[derive(Debug, Clone)]
pub(super) struct Panel {
    pub(super) start: f64,
    pub(super) duration: f64,
    pub(super) ends: [Look; 2],
    /// The middle of the whole first, then of its halves, of its quarters, …
    middles: Vec<Option<Look>>,
}

/// What a panel makes of a memory.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passage {
    pub(super) map: Map,
    /// About how far off the end is.
    pub(super) error: f64,
    /// The part that adds most to that, and what.
    worst: (usize, f64),
}

/// What a panel tells of its halves: how far its maps of second order are off, and what halving it changes.
#[derive(Debug, Clone, Copy)]
struct Parent {
    raw: f64,
    change: f64,
}

impl Panel {
    pub(super) fn new(start: f64, duration: f64, ends: [Look; 2], middle: Look) -> Self {
        Self { start, duration, ends, middles: alloc::vec![Some(middle)] }
    }

    fn middle(&self, part: usize) -> Option<Look> {
        self.middles.get(part - 1).copied().flatten()
    }

    /// When the middle of a part is.
    fn time(&self, part: usize) -> f64 {
        let depth = part.ilog2();
        let whole = (1_usize << depth) as f64;
        self.start + self.duration * ((part - (1 << depth)) as f64 + 0.5) / whole
    }

    /// Looks at the middle of a part, unless that is done; says how many looks it took.
    fn look(&mut self, part: usize, at: &impl Fn(f64) -> Look) -> f64 {
        if self.middle(part).is_some() {
            return 0.0;
        }
        if self.middles.len() < part {
            self.middles.resize(part, None);
        }
        let time = self.time(part);
        if let Some(entry) = self.middles.get_mut(part - 1) {
            *entry = Some(at(time));
        }
        1.0
    }

    /// The finest map that the looks allow, from a memory on.
    pub(super) fn passage(&self, memory: f64, steep: bool) -> Passage {
        self.part(1, self.ends, self.duration, memory, None, steep)
    }

    fn part(
        &self,
        part: usize,
        [a, b]: [Look; 2],
        duration: f64,
        memory: f64,
        parent: Option<Parent>,
        steep: bool,
    ) -> Passage {
        let Some(middle) = self.middle(part) else {
            return Passage { map: Map::IDENTITY, error: f64::INFINITY, worst: (part, 0.0) };
        };
        let map = Map::parabola(a, middle, b, duration);
        let off = |other: Map| size(other.at(memory) - map.at(memory));
        let (one, two) = (off(Map::held(middle, duration)), off(Map::linear([a, b], duration)));
        let raw = if one > two { one } else { two };
        let (left, right) = (2 * part, 2 * part + 1);
        let (Some(l), Some(r)) = (self.middle(left), self.middle(right)) else {
            let error = match parent {
                // A layer that is not resolved looks the same from shorter panels.
                Some(Parent { raw: before, change }) if raw * FALLS <= before => change,
                _ if steep => raw,
                _ => raw / RAW,
            };
            return Passage { map, error, worst: (part, error) };
        };
        // What of the halves is not halved itself is as good as this change tells.
        let half = 0.5 * duration;
        let fine = Map::parabola(a, l, middle, half).then(Map::parabola(middle, r, b, half));
        let change = Some(Parent { raw, change: 0.5 * off(fine) / HALVED });
        let first = self.part(left, [a, middle], half, memory, change, steep);
        let last = self.part(right, [middle, b], half, first.map.at(memory), change, steep);
        let map = first.map.then(last.map);
        let worst = if first.worst.1 >= last.worst.1 { first.worst } else { last.worst };
        Passage { map, error: first.error * last.map.keep + last.error, worst }
    }

    /// Halves the part that errs most; says how many looks that took.
    pub(super) fn refine(&mut self, passage: &Passage, at: &impl Fn(f64) -> Look) -> f64 {
        let part = passage.worst.0;
        if part >= 1 << 22 {
            return 0.0;
        }
        self.look(2 * part, at) + self.look(2 * part + 1, at)
    }

    /// The looks that are missing for 2^depth held steps.
    pub(super) fn missing(&self, depth: u32) -> usize {
        (1 << depth..2 << depth).filter(|part| self.middle(*part).is_none()).count()
    }

    /// Whether none is.
    pub(super) fn knows(&self, depth: u32) -> bool {
        (1 << depth..2 << depth).all(|part| self.middle(part).is_some())
    }

    /// One step of fourth order.
    pub(super) fn coarse(&self) -> Map {
        let [a, b] = self.ends;
        self.middle(1).map_or(Map::IDENTITY, |m| Map::parabola(a, m, b, self.duration))
    }

    /// So many held steps, of looks that are there.
    pub(super) fn held(&self, depth: u32) -> Option<Map> {
        let step = self.duration / (1_usize << depth) as f64;
        (1 << depth..2 << depth).try_fold(Map::IDENTITY, |map, part| {
            Some(map.then(Map::held(self.middle(part)?, step)))
        })
    }

    /// Makes these looks.
    pub(super) fn look_at_all(&mut self, depth: u32, at: &impl Fn(f64) -> Look) -> f64 {
        (1 << depth..2 << depth).map(|part| self.look(part, at)).sum()
    }
}
