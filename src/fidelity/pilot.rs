//! The pilot along a known velocity: every look at the friction curve is kept and serves the bound, the reference
//! and the plans that are tried beside it.

use alloc::collections::BTreeMap;
use alloc::vec::Vec;
use core::cell::RefCell;

use super::history::{History, Stretch};
use super::ladder::{
    ACCURACY, Bound, Cache, Cached, Candidate, Climb, Instants, Known, Output, Pace, Run, Trace,
};
use super::panel::{Look, Map, Panel, Passage};
use super::report::{Evidence, FidelityError, Integrator, Norm, Rung};
use super::{Reducible, between, exp, norm_of, size, weight};
use crate::root::enclose;
use crate::scalar::{is_zero, lit, to_f64};
use crate::signal::Signal;
use crate::{Branch, Bristle, Scalar, Sliding};

/// What steps that are not tried where they hardly matter may add to the error, as a share of the tolerance.
const UNTRIED: f64 = 0.15;

/// A scene that is being looked at.
pub(super) struct Pilot<'a, T: Scalar, M: Reducible<T>, V> {
    scene: &'a History<T, M, V>,
    memo: RefCell<Memo>,
}

#[derive(Default)]
struct Memo {
    /// Answers looked at, by their number.
    ends: BTreeMap<usize, End>,
    stride: usize,
    norm: Option<Norm>,
    allowed: f64,
    /// The reference, from the start on \[N\].
    memories: Vec<f64>,
    intervals: Vec<Interval>,
}

/// What is known of an answer.
#[derive(Debug, Clone, Copy)]
struct End {
    velocity: f64,
    look: Look,
    by_memory: f64,
    without: f64,
}

/// The reference from one instant looked at to the next.
struct Interval {
    /// The whole, for held steps, and for the reference too where it is smooth.
    whole: Panel,
    /// Its smooth parts where it is not.
    parts: Vec<Panel>,
    passages: Vec<Passage>,
    map: Map,
    error: f64,
    steep: bool,
    /// The ways of Dahl's bristle \[m\] that were tried last.
    ways: Vec<f64>,
}

impl Interval {
    /// From a memory on.
    fn settle(&mut self, memory: f64) {
        let parts =
            if self.parts.is_empty() { core::slice::from_ref(&self.whole) } else { &self.parts };
        self.passages.clear();
        (self.map, self.error) = (Map::IDENTITY, 0.0);
        for part in parts {
            let passage = part.passage(self.map.at(memory), self.steep);
            self.map = self.map.then(passage.map);
            self.error = self.error * passage.map.keep + passage.error;
            self.passages.push(passage);
        }
    }

    /// Halves the part that errs most; says how many looks that took.
    fn refine(&mut self, at: &impl Fn(f64) -> Look) -> f64 {
        let mut worst: Option<(usize, &Passage)> = None;
        for (index, passage) in self.passages.iter().enumerate() {
            if worst.is_none_or(|(_, other)| passage.error > other.error) {
                worst = Some((index, passage));
            }
        }
        match worst {
            None => 0.0,
            Some((index, passage)) => {
                self.parts.get_mut(index).unwrap_or(&mut self.whole).refine(passage, at)
            }
        }
    }

    /// One step of fourth order in each smooth part.
    fn coarse(&self) -> Map {
        let parts =
            if self.parts.is_empty() { core::slice::from_ref(&self.whole) } else { &self.parts };
        parts.iter().fold(Map::IDENTITY, |map, part| map.then(part.coarse()))
    }

    /// The largest number of held steps, up to so many, whose looks are all there.
    fn depth(&self, most: u32) -> u32 {
        (0..=most).rev().find(|depth| self.whole.knows(*depth)).unwrap_or(0)
    }
}

impl<'a, T: Scalar, M: Reducible<T>, V: Signal<T>> Pilot<'a, T, M, V> {
    pub(super) fn new(scene: &'a History<T, M, V>) -> Self {
        Self { scene, memo: RefCell::default() }
    }

    /// p σ0 \[N/m\].
    fn springs(&self) -> f64 {
        let lumped = &self.scene.lumped;
        to_f64(lumped.model().storage_stiffness() * lumped.normal_force())
    }

    /// The memory at the start \[N\].
    fn start(&self) -> f64 {
        to_f64(self.scene.initial(self.scene.lumped.model())) * self.springs()
    }

    fn end(&self, sliding: Sliding<T>) -> End {
        let scene = self.scene;
        let (v, contact) = (sliding.velocity(), &scene.lumped);
        let affine = contact.model().affine(sliding, T::zero());
        let rate = to_f64(affine.relaxation);
        let steady = if rate > 0.0 {
            to_f64(affine.drive * v / affine.relaxation) * self.springs()
        } else {
            // The limit beside v = 0.
            to_f64(scene.breakaway) * to_f64(sliding.direction())
        };
        let springs = contact.model().storage_stiffness();
        End {
            velocity: to_f64(v),
            look: Look { rate, steady },
            by_memory: to_f64(affine.stiffness / springs),
            without: to_f64(contact.normal_force() * affine.damping * v),
        }
    }

    fn look(&self, time: f64) -> Look {
        self.end(Sliding::from(self.scene.velocity.value(lit(time)))).look
    }

    fn velocity(&self, time: f64) -> f64 {
        to_f64(self.scene.velocity.value(lit(time)))
    }

    /// Kinks and reversals after a time until another one: where a kink is, a rounding before it.
    fn corners(&self, from: f64, to: f64) -> Vec<(f64, bool)> {
        let rounding = 8.0 * to_f64(T::default_epsilon()) * size(to);
        let mut corners = Vec::new();
        let mut time = from;
        for _ in 0..64 {
            let kink = self.scene.velocity.next_kink(lit(time), lit(to + rounding));
            let Some(kink) = kink.map(to_f64).filter(|kink| *kink > time) else { break };
            if kink > from + rounding {
                corners.push((kink, true));
            }
            time = kink;
        }
        // A kink at the end of the interval, without a jump, is none of the interval's.
        let calm = |v: f64, w: f64| size(v - w) <= 1e-9 * to_f64(self.scene.fastest);
        corners.retain(|(kink, _)| {
            *kink < to - rounding
                || !calm(self.velocity(kink - rounding), self.velocity(kink + rounding))
        });
        let mut all = Vec::new();
        let mut start = from;
        for (stop, kink) in corners.into_iter().chain([(to, false)]) {
            let last = if kink { stop - rounding } else { stop };
            let middle = 0.5 * (start + last);
            let mut a = (start, self.velocity(start));
            for time in [middle, last] {
                let b = (time, self.velocity(time));
                if a.1 * b.1 < 0.0 {
                    let (_, after) = enclose(|t| self.velocity(t), a, b, rounding);
                    all.push((after, false));
                }
                a = b;
            }
            if kink && stop < to + rounding {
                all.push((stop, true));
            }
            start = stop;
        }
        all
    }

    /// The smooth parts of an interval that is not smooth as a whole, and the looks they took beside those
    /// known at its ends and at rest.
    fn parts(
        &self,
        span: [f64; 2],
        ends: [End; 2],
        rest: [Look; 2],
        corners: &[(f64, bool)],
    ) -> (Vec<Panel>, f64) {
        let [from, to] = span;
        let rounding = 8.0 * to_f64(T::default_epsilon()) * size(to);
        let nothing = 1e-9 * to_f64(self.scene.fastest);
        let mut known: Vec<(f64, Look)> = ends.iter().map(|end| (end.velocity, end.look)).collect();
        let mut looks = 0.0;
        let mut parts = Vec::new();
        let mut start = from;
        for (stop, kink) in corners.iter().copied().chain([(to, false)]) {
            if stop - start > 2.0 * rounding {
                let last = if kink { stop - rounding } else { stop };
                let middle = 0.5 * (start + last);
                let forward = self.velocity(middle) >= 0.0;
                let [ahead, behind] = rest;
                let mut at = |time: f64| {
                    let v = self.velocity(time);
                    // At a reversal, what it is on the way there.
                    let along = if forward { v } else { -v };
                    if along <= nothing {
                        return if forward { ahead } else { behind };
                    }
                    if let Some((_, look)) = known.iter().find(|(w, _)| size(w - v) <= nothing) {
                        return *look;
                    }
                    looks += 1.0;
                    let look = self.look(time);
                    known.push((v, look));
                    look
                };
                parts.push(Panel::new(start, last - start, [at(start), at(last)], at(middle)));
            }
            start = if stop > start { stop } else { start };
        }
        (parts, looks)
    }

    /// The intervals of the pilot's grid as far as the middle of each, and the looks that took.
    fn intervals(
        &self,
        stride: usize,
        strides: usize,
        budget: f64,
        cache: &Cache,
    ) -> Result<(Vec<Interval>, f64), FidelityError> {
        let memo = self.memo.borrow();
        let rest = [Branch::Forward, Branch::Backward].map(|b| self.end(b.of(T::zero())).look);
        let mut looks = rest.len() as f64;
        let mut intervals = Vec::with_capacity(strides);
        for index in 0..strides {
            if looks + 1.0 > budget {
                let needed = 2.0 * looks * strides as f64 / index.max(1) as f64;
                return Err(FidelityError::PilotTooShort { needed, allowed: budget });
            }
            let time = |index: usize| to_f64(self.scene.time(index, stride));
            let (from, to) = (time(index), time(index + 1));
            let known = |index: usize| memo.ends.get(&(index * stride)).copied();
            let (Some(a), Some(b)) = (known(index), known(index + 1)) else { continue };
            let middle = self.look(0.5 * (from + to));
            looks += 1.0;
            let whole = Panel::new(from, to - from, [a.look, b.look], middle);
            let corners = self.corners(from, to);
            let parts = if corners.is_empty() && !is_zero(a.velocity) && !is_zero(b.velocity) {
                Vec::new()
            } else {
                let (parts, more) = self.parts([from, to], [a, b], rest, &corners);
                looks += more;
                parts
            };
            let steep = cache.entries.get(index).is_some_and(|cached| cached.steep);
            intervals.push(Interval {
                whole,
                parts,
                passages: Vec::new(),
                map: Map::IDENTITY,
                error: 0.0,
                steep,
                ways: Vec::new(),
            });
        }
        Ok((intervals, looks))
    }

    /// What the memory at the end of each stride comes to if these are off by so much.
    fn carried(&self, memo: &Memo, off: impl Iterator<Item = f64>) -> f64 {
        let mut error = 0.0;
        let errors: Vec<f64> = memo
            .intervals
            .iter()
            .zip(off)
            .map(|(interval, off)| {
                error = error * interval.map.keep + off;
                error
            })
            .collect();
        norm_of(memo.norm.unwrap_or(Norm::Greatest), errors.iter().copied())
    }

    /// A map for each interval where one that is known will do, and the rest adds up to next to nothing. Of
    /// each are given the map and by how much it is off.
    fn substitutes(&self, memo: &Memo, known: &[Option<(Map, f64)>]) -> Vec<Option<Map>> {
        let most = known.iter().flatten().fold(0.0, |most: f64, e| most.max(e.1));
        let mut least = most;
        for _ in 0..60 {
            let small = |e: &Option<(Map, f64)>| match e {
                Some((_, off)) if *off <= least => *off,
                _ => 0.0,
            };
            if self.carried(memo, known.iter().map(small)) <= UNTRIED * memo.allowed {
                break;
            }
            least *= 0.5;
        }
        known.iter().map(|e| e.filter(|e| e.1 <= least).map(|e| e.0)).collect()
    }

    /// What up to 2^depth held steps make of an interval, if that is known, and by how much more of them may be off.
    fn known(interval: &Interval, memory: f64, depth: u32) -> Option<(Map, f64)> {
        let known = interval.depth(depth);
        let off = |map: Map| size(map.at(memory) - interval.map.at(memory));
        let map = interval.whole.held(known)?;
        if known == depth {
            return Some((map, 0.0));
        }
        // One that is near by chance tells nothing of shorter steps: at corners it takes two that agree.
        let rough = interval.steep || !interval.parts.is_empty();
        let before = known.checked_sub(1).and_then(|d| interval.whole.held(d)).map(off);
        let doubt = match before {
            Some(before) if rough => before,
            Some(before) => 0.25 * before,
            None if rough => return None,
            None => 0.0,
        };
        let off = off(map);
        Some((map, if off > doubt { off } else { doubt }))
    }

    /// What 2^depth held steps to a stride make of each interval, where fewer tell enough or all looks are there.
    fn held_maps(&self, memo: &Memo, depth: u32) -> Vec<Option<Map>> {
        let places = memo.intervals.iter().zip(&memo.memories);
        let known: Vec<_> = places.map(|(i, memory)| Self::known(i, *memory, depth)).collect();
        self.substitutes(memo, &known)
    }

    /// The same for collocation: where steps of a lower order tell enough.
    fn collocation_maps(&self, memo: &Memo) -> Vec<Option<Map>> {
        let known: Vec<_> = memo
            .intervals
            .iter()
            .zip(&memo.memories)
            .map(|(interval, memory)| {
                let off = |map: Map| size(map.at(*memory) - interval.map.at(*memory));
                let held = Self::known(interval, *memory, DEEP);
                // Where the field is smooth it is better than one held step by more than this.
                let one = off(interval.whole.held(0)?);
                let smooth = !interval.steep && interval.parts.is_empty() && one <= memo.allowed;
                if !smooth {
                    return held;
                }
                let (map, least) = (interval.coarse(), one / SMOOTHER);
                let coarse = if off(map) > least { off(map) } else { least };
                held.filter(|held| held.1 < coarse).or(Some((map, coarse)))
            })
            .collect();
        self.substitutes(memo, &known)
    }

    /// How many steps of a plan go into a stride of the pilot: a power of two.
    fn depth(&self, memo: &Memo, pace: Pace) -> Option<u32> {
        let steps = memo.stride.checked_div(pace.stride)? * pace.substeps;
        let whole = memo.stride.is_multiple_of(pace.stride) && !memo.intervals.is_empty();
        (whole && steps.is_power_of_two()).then(|| steps.ilog2())
    }

    /// From map to map.
    fn along(
        &self,
        memo: &Memo,
        cache: &Cache,
        own: usize,
        start: f64,
        mut step: impl FnMut(usize, f64) -> f64,
    ) -> Vec<Output> {
        let mut memory = start;
        let mut outputs = Vec::with_capacity(memo.intervals.len() * own);
        for index in 0..memo.intervals.len() {
            memory = step(index, memory);
            let output = match cache.entries.get(index) {
                Some(cached) => cached.with(memory),
                None => Output { value: f64::NAN, memory, spread: 0.0 },
            };
            outputs.extend(core::iter::repeat_n(output, own));
        }
        outputs
    }

    fn held(&self, depth: u32, own: usize, cache: &Cache) -> Run {
        let mut maps = self.held_maps(&self.memo.borrow(), depth);
        let mut evaluations = 0.0;
        for (interval, map) in self.memo.borrow_mut().intervals.iter_mut().zip(&mut maps) {
            if map.is_none() {
                evaluations += interval.whole.look_at_all(depth, &|time| self.look(time));
                *map = interval.whole.held(depth);
            }
        }
        let outputs = self.along(&self.memo.borrow(), cache, own, self.start(), |index, memory| {
            maps.get(index).copied().flatten().map_or(f64::NAN, |map| map.at(memory))
        });
        Run { outputs, evaluations }
    }

    /// Dahl's bristle takes no curve. In one direction its held steps are one, as long as their way; where that is the
    /// same as with other steps, so is what comes of it.
    fn dahl(&self, steps: usize, own: usize) -> Run {
        let springs = self.springs();
        let dahl = &self.scene.dahl;
        let limit = to_f64(dahl.model().stationary_coefficient(T::one()) * dahl.normal_force());
        let mut evaluations = 0.0;
        let mut maps = Vec::new();
        for interval in &mut self.memo.borrow_mut().intervals {
            let step = interval.whole.duration / steps as f64;
            let mut ways: Vec<f64> = Vec::new();
            for index in 0..steps {
                let v = self.velocity(interval.whole.start + step * (index as f64 + 0.5));
                match ways.last_mut() {
                    Some(way) if !(*way * v < 0.0) => *way += v * step,
                    _ => ways.push(v * step),
                }
            }
            let same = |(a, b): (&f64, &f64)| size(a - b) <= 1e-9 * size(*b);
            let known =
                ways.len() == interval.ways.len() && ways.iter().zip(&interval.ways).all(same);
            if !known {
                evaluations += weight::DAHL_HOLD * ways.len() as f64;
            }
            maps.push(ways.iter().fold(Map::IDENTITY, |map, way| {
                let rate = springs * size(*way) / limit;
                let steady = if *way < 0.0 { -limit } else { limit };
                map.then(Map::held(Look { rate, steady }, 1.0))
            }));
            interval.ways = ways;
        }
        let memo = self.memo.borrow();
        let start = to_f64(self.scene.initial(dahl.model())) * springs;
        let mut outputs = self.along(&memo, &Cache::default(), own, start, |index, memory| {
            maps.get(index).map_or(f64::NAN, |map| map.at(memory))
        });
        for output in &mut outputs {
            output.value = output.memory;
        }
        Run { outputs, evaluations }
    }

    fn collocated(&self, steps: usize, own: usize, cache: &Cache) -> Result<Run, FidelityError> {
        let memo = self.memo.borrow();
        let maps = self.collocation_maps(&memo);
        let springs = self.springs();
        let (mut evaluations, mut failure) = (0.0, None);
        let outputs = self.along(&memo, cache, own, self.start(), |index, memory| {
            if let Some(map) = maps.get(index).copied().flatten() {
                return map.at(memory);
            }
            let stretch = Stretch { from: index, to: index + 1, stride: memo.stride };
            match self.scene.deflections::<3>(stretch, steps, lit(memory / springs)) {
                Ok((z, more)) => {
                    evaluations += more;
                    z.first().map_or(f64::NAN, |z| to_f64(*z) * springs)
                }
                Err(error) => {
                    failure = Some(error);
                    f64::NAN
                }
            }
        });
        match failure {
            Some(error) => Err(error),
            None => Ok(Run { outputs, evaluations }),
        }
    }
}

/// How much farther off than asked for the reference may be: what it may be off is added to every error.
const LOOSER: f64 = 2.0;
/// A step of collocation is better than a held one by at least this factor where neither is far off.
const SMOOTHER: f64 = 16.0;
/// More halvings than are looked for.
const DEEP: u32 = 13;
/// Intervals that err no less than the worst by this factor are halved together.
const GATHERED: f64 = 8.0;

impl<T: Scalar, M: Reducible<T>, V: Signal<T>> Climb for Pilot<'_, T, M, V> {
    fn instants(&self) -> Instants {
        self.scene.instants
    }

    fn scale(&self) -> f64 {
        to_f64(self.scene.scale)
    }

    fn roundings(&self) -> f64 {
        // Some for each step of a pilot, added up.
        64.0 * to_f64(T::default_epsilon()) * to_f64(self.scene.scale)
    }

    fn looks(&self) -> f64 {
        if self.scene.is_lumped {
            // One evaluation at each, one in the middle, half as many again for reversals, and what Dahl takes.
            0.25
        } else {
            // One; and a step and the force, and two steps and the force.
            0.14
        }
    }

    fn most_looks(&self) -> f64 {
        if self.scene.is_lumped { 0.38 } else { self.looks() }
    }

    fn shows(&self, stride: usize, answers: usize) -> bool {
        between::shows(stride, answers, |answer| {
            to_f64(self.scene.velocity.value(self.scene.time(answer, 1)))
        })
    }

    fn candidates(&self) -> Vec<Candidate> {
        self.scene.candidates()
    }

    fn price(&self, plan: &Candidate, pace: Pace) -> Option<f64> {
        let memo = self.memo.borrow();
        let depth = self.depth(&memo, pace)?;
        let all = memo.intervals.len() as f64;
        match (plan.rung, plan.integrator) {
            (Rung::StaticCurve, _) => Some(0.0),
            (Rung::Dahl, _) => {
                let parts = memo.intervals.iter().map(|i| i.parts.len().max(1) as f64);
                Some(weight::DAHL_HOLD * parts.sum::<f64>())
            }
            (Rung::FrBd, Integrator::Collocation) => {
                let steps = (1_usize << depth) as f64;
                let tried = self.collocation_maps(&memo).into_iter().zip(&memo.intervals);
                let tried = tried.filter(|(map, _)| map.is_none());
                Some(tried.map(|(_, i)| 3.0 * steps + 2.0 + 10.0 * i.parts.len() as f64).sum())
            }
            (Rung::FrBd, _) => {
                let maps = self.held_maps(&memo, depth).into_iter().zip(&memo.intervals);
                let tried = maps.filter(|(map, _)| map.is_none());
                Some(tried.map(|(_, i)| i.whole.missing(depth) as f64).sum())
            }
            _ => Some(all * plan.evaluations(1 << depth)),
        }
    }

    fn bound(&self, stride: usize, strides: usize) -> Result<Bound, FidelityError> {
        let scene = self.scene;
        let step = scene.instants.interval * stride as f64;
        let springs = self.springs();
        let (breakaway, scale) = (to_f64(scene.breakaway), to_f64(scene.scale));
        let quickest = to_f64(scene.fastest);
        let mut evaluations = 0.0;
        let mut at = |index: usize| {
            *self.memo.borrow_mut().ends.entry(index * stride).or_insert_with(|| {
                evaluations += 1.0;
                self.end(Sliding::from(scene.velocity.value(scene.time(index, stride))))
            })
        };
        let mut last = at(0);
        let mut steady = last.look.steady;
        let mut entries = Vec::with_capacity(strides);
        let start = to_f64(scene.initial(scene.lumped.model())) * springs;
        let mut error = size(
            start
                - to_f64(scene.lumped.model().stationary(scene.velocity.value(T::zero())))
                    * springs,
        );
        let mut errors = Vec::with_capacity(strides);
        let mut relaxation = 0.0;
        let (mut relaxations, mut fastest_rate) = (Vec::with_capacity(strides), last.look.rate);
        let (mut slowest, mut fastest) = (size(last.velocity), size(last.velocity));
        let (mut lag, mut reversals, mut stuck) = (0.0_f64, 0, 0_usize);
        // The way slid in the direction of now, and the longest.
        let (mut way, mut longest) = (0.0, 0.0);
        let mut direction = last.velocity;
        for index in 1..=strides {
            let next = at(index);
            let (v, next_v) = (last.velocity, next.velocity);
            let (rate, next_rate) = (last.look.rate, next.look.rate);
            let next_steady = if next_v == 0.0 { 0.0 } else { next.look.steady };
            let lowest_force = if scene.is_lumped {
                next.by_memory * next_steady + next.without
            } else {
                to_f64(
                    scene.contact.stationary_force(scene.velocity.value(scene.time(index, stride))),
                )
            };
            // A velocity that is zero but for roundings has either sign, sooner or later.
            let nearly = size(next_v) <= quickest * 1e-9;
            let speeds = (size(v), size(next_v));
            let (slow, fast) = if speeds.0 < speeds.1 { speeds } else { (speeds.1, speeds.0) };
            let turned = !(v * next_v > 0.0);
            let uneven = turned || slow < fast * 0.5;
            let change = size(next_steady - steady);
            let relaxes = rate.max(next_rate) * step > 0.3;
            let steep = uneven && relaxes && change > breakaway * 0.05;
            // Answers between the instants looked at, just after a reversal or the start.
            let unseen = stride > 1 && (turned || index == 1);
            let spread = if nearly || unseen { scale + size(lowest_force) } else { 0.0 };
            entries.push(Cached {
                by_memory: next.by_memory,
                without: next.without,
                lowest: lowest_force,
                spread,
                steep,
            });
            // Between two velocities of one sign the rate is taken to lie between theirs, and z_ss to
            // vary by no more than from one to the other.
            let lowest = if turned { 0.0 } else { rate.min(next_rate) };
            error = error * exp(-lowest * step) + change;
            errors.push(next.by_memory * error + spread);
            relaxation += (rate + next_rate) * 0.5 * step;
            relaxations.push(relaxation);
            fastest_rate = fastest_rate.max(next_rate);
            lag = lag.max(change / (step * next_rate * breakaway));
            slowest = slowest.min(size(next_v));
            fastest = fastest.max(size(next_v));
            if direction * next_v < 0.0 {
                reversals += 1;
                way = 0.0;
                slowest = 0.0;
            }
            if next_v != 0.0 {
                direction = next_v;
            }
            way += size(next_v) * step;
            longest = if way > longest { way } else { longest };
            if way * springs < breakaway {
                stuck += 1;
            }
            (last, steady) = (next, next_steady);
        }
        let periods = match scene.instants.period {
            Some(period) => (strides * stride) as f64 / period as f64,
            None => 1.0,
        };
        let evidence = Evidence {
            slowest,
            fastest,
            reversals,
            lag,
            presliding: breakaway / (springs * longest),
            stuck_share: stuck as f64 / strides as f64,
            relaxation: relaxation / periods,
            transits: None,
        };
        Ok(Bound {
            errors: scene.is_lumped.then_some(errors),
            relaxation: relaxations,
            fastest_rate,
            evidence,
            cache: Cache { stride, entries },
            evaluations,
        })
    }

    fn run(
        &self,
        plan: &Candidate,
        pace: Pace,
        strides: usize,
        cache: &Cache,
    ) -> Result<Run, FidelityError> {
        let (depth, stride) = {
            let memo = self.memo.borrow();
            (self.depth(&memo, pace), memo.stride)
        };
        // Answers between the instants looked at are not asked for.
        let own = stride.checked_div(pace.stride).unwrap_or(1);
        match (depth, plan.rung, plan.integrator) {
            (Some(depth), Rung::Dahl, _) => Ok(self.dahl(1 << depth, own)),
            (Some(depth), Rung::FrBd, Integrator::Hold) => Ok(self.held(depth, own, cache)),
            (Some(depth), Rung::FrBd, Integrator::Collocation) => {
                self.collocated(1 << depth, own, cache)
            }
            _ => self.scene.run(plan, pace, strides, cache),
        }
    }

    fn trace(
        &self,
        stride: usize,
        strides: usize,
        norm: Norm,
        accuracy: f64,
        budget: f64,
        cache: &Cache,
    ) -> Result<Trace, FidelityError> {
        let scene = self.scene;
        if !scene.is_lumped {
            let steep = cache.entries.iter().any(|cached| cached.steep);
            return scene.trace_by_halving((stride, strides), norm, accuracy, budget, steep);
        }
        let (intervals, mut evaluations) = self.intervals(stride, strides, budget, cache)?;
        let start = self.start();
        let mut memo = self.memo.borrow_mut();
        *memo = Memo {
            ends: core::mem::take(&mut memo.ends),
            stride,
            norm: Some(norm),
            allowed: accuracy / ACCURACY,
            memories: alloc::vec![start],
            intervals,
        };
        let at = |time: f64| self.look(time);
        let mut stale = alloc::vec![true; memo.intervals.len()];
        let uncertainty = loop {
            let mut memory = start;
            for (interval, stale) in memo.intervals.iter_mut().zip(&mut stale) {
                if core::mem::take(stale) {
                    interval.settle(memory);
                }
                memory = interval.map.at(memory);
            }
            let uncertainty = self.carried(&memo, memo.intervals.iter().map(|i| i.error));
            if uncertainty <= LOOSER * accuracy {
                break uncertainty;
            }
            // Those that err most, together.
            let most = memo.intervals.iter().map(|i| i.error).fold(0.0, f64::max);
            let before = evaluations;
            for (interval, stale) in memo.intervals.iter_mut().zip(&mut stale) {
                if interval.error >= most / GATHERED && evaluations + 2.0 <= budget {
                    evaluations += interval.refine(&at);
                    *stale = true;
                }
            }
            if !(evaluations > before) {
                break uncertainty;
            }
        };
        let mut memories = Vec::with_capacity(strides + 1);
        let mut outputs = Vec::with_capacity(strides);
        let mut memory = start;
        memories.push(start);
        for (interval, cached) in memo.intervals.iter().zip(&cache.entries) {
            memory = interval.map.at(memory);
            memories.push(memory);
            outputs.push(cached.with(memory));
        }
        memo.memories = memories;
        drop(memo);
        let held = self.held(0, 1, cache);
        let run = Run { outputs, evaluations: evaluations + held.evaluations };
        let known = Known { runs: alloc::vec![(Integrator::Hold, 1, held.outputs)] };
        Ok(Trace { run, uncertainty, known: Some(known) })
    }
}
