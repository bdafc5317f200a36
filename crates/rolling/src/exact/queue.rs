//! The bristles of a patch as a queue whose moments are read in a fixed number of operations.
//!
//! All bristles obey one linear equation. A held step maps each of them, z ← e^(−λh) z + offset,
//! moves them on by V h, and lets in one *segment* of new bristles. From the newest bristle to the
//! oldest the queue has two parts:
//!
//! * the *back*: the segments that entered since the last rebuild. None of them leaves the patch,
//!   so their moments are advanced step by step.
//! * the *front*: the profile at the last rebuild. Each of its segments stores the moments of all
//!   newer ones. One map and one shift stand for all steps since, and the outlet cuts one segment.
//!
//! Before a step that would push the back over the outlet, the queue is rebuilt: the back and what
//! is left of the front become the new front. That takes one visit to each segment, about once a
//! crossing of the patch. Nothing is ever subtracted from a sum, so a heavily deflected bristle
//! leaves no rounding error behind when it leaves the patch.
//!
//! Source: the two-stack queue of sliding-window aggregation, see [the module](super).

use super::profile::{Map, Profile, shifted};
use crate::patch::Frozen;
use crate::quadrature::integrate;
use crate::{PolynomialExponential, Pressure};
use bristle::Scalar;
use bristle::rheology::{Deflection as _, HeldWeights as _};
use bristle::scalar::{is_zero, lit};

/// Memory for one segment of the deflection profile of an
/// [`ExactPatch`](crate::ExactPatch).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment<T, const N: usize> {
    profile: Profile<T>,
    /// What happened to older bristles while a segment of the back entered.
    map: Map<T>,
    /// Place of the newest bristle of a segment of the front, at the rebuild.
    place: T,
    /// Back: moments of the segment in its own coordinates. Front: moments of all newer segments
    /// at the rebuild.
    moments: [T; N],
}

impl<T: Scalar, const N: usize> Default for Segment<T, N> {
    fn default() -> Self {
        let zero = T::zero();
        Self {
            profile: Profile::straight(zero, zero, zero),
            map: Map::identity(),
            place: zero,
            moments: [zero; N],
        }
    }
}

/// Memory for the segments of an [`ExactPatch`](crate::ExactPatch): an array, a mutable slice or a
/// vector of them.
pub trait Memory<T, const N: usize>: AsRef<[Segment<T, N>]> + AsMut<[Segment<T, N>]> {}

impl<T, const N: usize, B: AsRef<[Segment<T, N>]> + AsMut<[Segment<T, N>]>> Memory<T, N> for B {}

/// What a step with held λ, u = r v and V does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Held<T> {
    /// V h
    pub(super) distance: T,
    /// For bristles that are there from the beginning to the end.
    pub(super) map: Map<T>,
    /// The bristles that enter.
    pub(super) inflow: Profile<T>,
}

impl<T: Scalar> Held<T> {
    /// From λ \[1/s\], u = r v \[m/s\], V \[1/s\] and h \[s\].
    #[inline]
    pub(super) fn new(relaxation: T, drive: T, transport: T, duration: T) -> Self {
        let distance = transport * duration;
        let weights = T::weights(relaxation, duration);
        let map =
            Map { decay: weights.end(T::one(), T::zero()), offset: weights.end(T::zero(), drive) };
        Self { distance, map, inflow: Profile::inflow(distance, relaxation, drive, duration) }
    }
}

/// The queue, in a ring of segments: first those of the front, then those of the back, each from
/// the oldest to the newest.
#[derive(Debug, Clone)]
pub(super) struct Queue<T, const N: usize, B> {
    segments: B,
    /// Index of the oldest segment.
    oldest: usize,
    front_count: usize,
    /// Length and moments of the front at the rebuild.
    front_length: T,
    front: [T; N],
    /// What the steps since the rebuild make of the front.
    map_since: Map<T>,
    /// Distance moved since the rebuild: the length of the back.
    shift: T,
    back_count: usize,
    back: [T; N],
    /// a of the weight e^(−aξ).
    decay: T,
    /// Steps that move on by less are merged with each other.
    pub(super) narrowest: T,
}

impl<T: Scalar, const N: usize, B: Memory<T, N>> Queue<T, N, B> {
    /// Least number of segments.
    pub(super) const LEAST: usize = 22;

    /// A patch of undeflected bristles, in at least [`Queue::LEAST`] segments.
    pub(super) fn new(segments: B, decay: T) -> Self {
        // Every narrower segment is followed by one that is not. A few more are cut at the outlet
        // or were rebuilt early.
        let most = segments.as_ref().len().saturating_sub(6).max(1);
        let mut queue = Self {
            segments,
            oldest: 0,
            front_count: 0,
            front_length: T::zero(),
            front: [T::zero(); N],
            map_since: Map::identity(),
            shift: T::zero(),
            back_count: 0,
            back: [T::zero(); N],
            decay,
            narrowest: lit::<T>(2.0) / lit(most as f64),
        };
        queue.fill(Profile::straight(T::one(), T::zero(), T::zero()));
        queue
    }

    pub(super) fn capacity(&self) -> usize {
        self.segments.as_ref().len()
    }

    /// Number of segments in use.
    pub(super) fn len(&self) -> usize {
        self.front_count + self.back_count
    }

    /// Where a segment is in the ring, counted from the oldest.
    #[inline(always)]
    fn index(&self, number: usize) -> usize {
        let (capacity, index) = (self.capacity(), self.oldest + number);
        if index >= capacity { index - capacity } else { index }
    }

    #[inline(always)]
    fn segment(&self, number: usize) -> Option<&Segment<T, N>> {
        self.segments.as_ref().get(self.index(number))
    }

    #[inline(always)]
    fn segment_mut(&mut self, number: usize) -> Option<&mut Segment<T, N>> {
        let index = self.index(number);
        self.segments.as_mut().get_mut(index)
    }

    /// Forgets all bristles, but for what the ring holds.
    fn clear(&mut self) {
        (self.front_count, self.back_count) = (0, 0);
        (self.front_length, self.shift) = (T::zero(), T::zero());
        (self.front, self.back) = ([T::zero(); N], [T::zero(); N]);
        self.map_since = Map::identity();
    }

    /// Writes the segment of the front that follows those written before it.
    fn put(&mut self, number: usize, profile: Profile<T>, own: [T; N]) {
        let (place, moments) = (self.front_length, self.front);
        if let Some(segment) = self.segment_mut(number) {
            *segment = Segment { profile, map: Map::identity(), place, moments };
        }
        add(&mut self.front, &shifted(own, place, self.decay));
        self.front_length += profile.width;
        self.front_count += 1;
    }

    /// Forgets everything but one segment.
    pub(super) fn fill(&mut self, profile: Profile<T>) {
        self.clear();
        self.oldest = 0;
        self.put(0, profile, profile.moments(T::one(), self.decay));
    }

    /// Replaces all bristles by those of steady rolling.
    pub(super) fn replace(&mut self, relaxation: T, drive: T, transport: T) {
        let crossing = T::one() / transport;
        self.fill(Profile::inflow(T::one(), relaxation, drive, crossing));
    }

    /// Rebuilds the queue if the back would reach the outlet over a distance.
    #[inline]
    pub(super) fn make_room(&mut self, distance: T) {
        let full = self.len() >= self.capacity();
        if self.back_count > 0 && (full || self.shift + distance > T::one()) {
            self.rebuild();
        }
    }

    /// Makes one front of all that is inside. Two narrow segments that meet are merged, so that
    /// rebuilds that follow each other closely do not fill the memory.
    fn rebuild(&mut self) {
        let (front_count, count) = (self.front_count, self.len());
        let (narrowest, decay) = (self.narrowest, self.decay);
        let (front_map, mut back_map) = (self.map_since, Map::identity());
        self.clear();
        // From the newest to the oldest. What is written is never older than what is read.
        let mut last: Option<(Profile<T>, [T; N])> = None;
        let mut written = count;
        for number in (0..count).rev() {
            let Some(&Segment { profile, map, moments, .. }) = self.segment(number) else { break };
            let (mut profile, mut moments) = if number < front_count {
                let profile = profile.mapped(front_map);
                (profile, profile.moments(T::one(), decay))
            } else {
                let now = back_map;
                back_map = now.after(map);
                (profile.mapped(now), now.of_moments(moments, profile.width, decay))
            };
            if let Some((newer, own)) = last {
                let narrow = newer.width < narrowest && profile.width < narrowest;
                if narrow && self.front_length + newer.width + profile.width <= T::one() {
                    profile = profile.merged_with(&newer, decay);
                    moments = profile.moments(T::one(), decay);
                } else {
                    written -= 1;
                    self.put(written, newer, own);
                }
            }
            last = Some((profile, moments));
        }
        if let Some((oldest, own)) = last {
            written -= 1;
            self.put(written, oldest, own);
        }
        self.oldest = self.index(written);
    }

    /// Takes all bristles to the profile of steady rolling.
    pub(super) fn settle(&mut self, frozen: &Frozen<T>) {
        // A patch that stands settles as one that takes very long to cross.
        let transport = frozen.transport.larger(lit(1e-30));
        self.replace(frozen.affine.relaxation, frozen.drive(), transport);
    }

    /// Moves the bristles with held coefficients and another drive.
    #[inline]
    pub(super) fn roll(&mut self, frozen: &Frozen<T>, drive: T, duration: T) {
        let &Frozen { affine, transport, .. } = frozen;
        if transport * duration <= T::one() {
            self.advance(&Held::new(affine.relaxation, drive, transport, duration));
        } else {
            self.replace(affine.relaxation, drive, transport);
        }
    }

    /// No deflection is outside of this.
    pub(super) fn range(&self) -> (T, T) {
        let mut range = (T::zero(), T::zero());
        self.profile(|segment, _, part| {
            let (low, high) = segment.range(part);
            range = (range.0.smaller(low), range.1.larger(high));
        });
        range
    }

    /// Multiplies every deflection: a step of no length.
    pub(super) fn scale(&mut self, factor: T) {
        if factor == T::one() {
            return;
        }
        let zero = T::zero();
        let map = Map { decay: factor, offset: zero };
        self.advance(&Held { distance: zero, map, inflow: Profile::straight(zero, zero, zero) });
    }

    /// A step of at most the length of the patch.
    #[inline]
    pub(super) fn advance(&mut self, held: &Held<T>) {
        self.make_room(held.distance);
        let decay = self.decay;
        let inflow = held.inflow.moments::<N>(T::one(), decay);
        self.map_since = held.map.after(self.map_since);
        if self.shift > T::zero() {
            let back = held.map.of_moments(self.back, self.shift, decay);
            self.back = shifted(back, held.distance, decay);
        }
        add(&mut self.back, &inflow);
        self.shift += held.distance;
        self.enter(held, inflow);
        // Forget what has left the patch.
        while self.front_count > 0 {
            if self.segment(0).is_some_and(|oldest| oldest.place + self.shift < T::one()) {
                break;
            }
            self.oldest = self.index(1);
            self.front_count -= 1;
        }
    }

    /// Puts the segment of a step into the ring.
    #[inline]
    fn enter(&mut self, held: &Held<T>, moments: [T; N]) {
        let (narrowest, decay) = (self.narrowest, self.decay);
        let nothing_new = is_zero(held.distance);
        let newest = self.len().saturating_sub(1);
        if self.back_count == 0 {
            if nothing_new {
                return;
            }
        } else if let Some(segment) = self.segment_mut(newest)
            && (nothing_new || held.distance < narrowest && segment.profile.width < narrowest)
        {
            let mut exact = held.map.of_moments(segment.moments, segment.profile.width, decay);
            segment.profile = segment.profile.mapped(held.map);
            segment.map = held.map.after(segment.map);
            if !nothing_new {
                segment.profile = segment.profile.merged_with(&held.inflow, decay);
                exact = shifted(exact, held.distance, decay);
                add(&mut exact, &moments);
            }
            let merged = segment.profile.moments::<N>(T::one(), decay);
            segment.moments = merged;
            // The newest segment begins at the inlet: its moments are its part of the back's. The
            // back takes those of the merged profile, so that force and energy are of one profile.
            let kept = self.back.iter_mut().zip(merged).zip(exact).skip(1);
            kept.for_each(|((back, merged), exact)| *back += merged - exact);
            return;
        }
        if let Some(free) = self.segment_mut(self.len()) {
            *free = Segment { profile: held.inflow, map: held.map, place: T::zero(), moments };
            self.back_count += 1;
        }
    }

    /// Calls `visit` with places, deflections and p dξ of a quadrature over the patch.
    pub(super) fn over_bristles(
        &self,
        pressure: &PolynomialExponential<T, N>,
        mut visit: impl FnMut(T, T, T),
    ) {
        let steep = pressure.decay().abs();
        self.profile(|segment, from, part| {
            let width = segment.width * part;
            let steepness = lit::<T>(2.0) * segment.exponent * part + steep * width;
            integrate(steepness, |at, weight| {
                let at = at * part;
                let place = from + segment.width * at;
                visit(place, segment.at(at), weight * width * pressure.at(place));
            });
        });
    }

    /// The deflection at a place between 0 and 1, NaN elsewhere.
    pub(super) fn deflection(&self, place: T) -> T {
        let mut found = T::nan();
        if place >= T::zero() && place <= T::one() {
            self.profile(|segment, from, _| {
                if place >= from && segment.width > T::zero() {
                    let part = (place - from) / segment.width;
                    found = segment.at(if part < T::one() { part } else { T::one() });
                }
            });
        }
        found
    }

    /// The moments ∫₀¹ ξᵏ e^(−aξ) z dξ of those bristles that are inside now and still will be
    /// after a distance. After [`Queue::make_room`].
    #[inline]
    pub(super) fn staying(&self, distance: T) -> [T; N] {
        let mut total = self.back;
        let cut = T::one() - self.shift - distance;
        if self.front_count == 0 || !(cut > T::zero()) {
            return total;
        }
        let (mut moments, mut length) = (self.front, self.front_length);
        if cut < length {
            length = cut;
            moments = [T::zero(); N];
            let front = (0..self.front_count).filter_map(|number| self.segment(number));
            if let Some(last) = front.into_iter().find(|segment| segment.place < cut) {
                let part = ((cut - last.place) / last.profile.width).smaller(T::one());
                let own = last.profile.moments::<N>(part, self.decay);
                moments = shifted(own, last.place, self.decay);
                add(&mut moments, &last.moments);
            }
        }
        let now = self.map_since.of_moments(moments, length, self.decay);
        add(&mut total, &shifted(now, self.shift, self.decay));
        total
    }

    /// Calls `visit` for every segment that crosses the outlet on the way, oldest first: from which
    /// distance on, to which, how steep its profile is over that part, and its deflection at the
    /// outlet over the distance, if nothing drove it meanwhile. After [`Queue::make_room`].
    pub(super) fn leaving(&self, distance: T, mut visit: impl FnMut(T, T, T, &dyn Fn(T) -> T)) {
        let mut from = T::zero();
        for number in 0..self.front_count {
            let Some(segment) = self.segment(number) else { return };
            // The newest bristle of the segment is at the outlet after this distance.
            let gone = T::one() - self.shift - segment.place;
            let to = gone.smaller(distance);
            if to > from {
                let profile = segment.profile.mapped(self.map_since);
                let steepness = profile.exponent * ((to - from) / profile.width);
                visit(from, to, steepness, &|at| profile.at((gone - at) / profile.width));
                from = to;
            }
            if !(from < distance) {
                return;
            }
        }
    }

    /// Calls `visit` for every segment inside, newest first: its profile now, the place of its
    /// newest bristle, and the part of its width that is inside.
    pub(super) fn profile(&self, mut visit: impl FnMut(&Profile<T>, T, T)) {
        let (mut place, mut back_map) = (T::zero(), Map::identity());
        for number in (0..self.len()).rev() {
            let Some(segment) = self.segment(number) else { return };
            let now = if number < self.front_count { self.map_since } else { back_map };
            let profile = segment.profile.mapped(now);
            back_map = back_map.after(segment.map);
            let room = T::one() - place;
            if !(room > T::zero()) {
                return;
            }
            let part = if profile.width > room { room / profile.width } else { T::one() };
            visit(&profile, place, part);
            place += profile.width;
        }
    }
}

#[inline(always)]
fn add<T: Scalar, const N: usize>(sum: &mut [T; N], more: &[T; N]) {
    for (sum, more) in sum.iter_mut().zip(more) {
        *sum += *more;
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{Held, Queue, Segment};
    use crate::quadrature::integrate;
    use std::vec;

    /// ∫ ξᵏ e^(−aξ) z dξ over the profile that the queue would show.
    fn shown<const N: usize>(
        queue: &Queue<f64, N, vec::Vec<Segment<f64, N>>>,
        decay: f64,
    ) -> [f64; N] {
        let mut sum = [0.0; N];
        queue.profile(|segment, place, part| {
            let width = segment.width * part;
            integrate(segment.exponent * part + decay.abs() * width, |at, weight| {
                let at = at * part;
                let xi = place + segment.width * at;
                let mut value = weight * width * (-decay * xi).exp() * segment.at(at);
                for sum in &mut sum {
                    *sum += value;
                    value *= xi;
                }
            });
        });
        sum
    }

    #[test]
    fn the_account_is_that_of_the_profile_at_every_step_though_steps_are_merged() {
        let mut seed = 11_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        for (slots, decay) in [(22, 0.0), (22, 0.7), (40, -1.3), (80, 4.0)] {
            let mut queue = Queue::new(vec![Segment::<f64, 3>::default(); slots], decay);
            let narrowest = queue.narrowest;
            let (mut merged, mut drive) = (0, 0.0);
            for number in 0..3000 {
                if number % 37 == 0 {
                    drive = 2.0 * random() - 1.0;
                }
                let before = queue.len();
                // Mostly up to half as wide as what is not merged; a wide one, and patches that
                // stand. With u = λ drive all |z| ≤ 1.
                let (transport, duration) = match number % 50 {
                    0 => (1.0, 0.2),
                    1..4 => (0.0, 1e-3),
                    _ => (1.0, 0.5 * narrowest * random()),
                };
                queue.advance(&Held::new(5.0, 5.0 * drive, transport, duration));
                let way = transport * duration;
                merged += usize::from(way > 0.0 && queue.len() <= before);
                let (got, want) = (queue.staying(0.0), shown(&queue, decay));
                let weight = if decay < 0.0 { (-decay).exp() } else { 1.0 };
                for (k, (got, want)) in got.into_iter().zip(want).enumerate() {
                    // Some thousand roundings in a transit, of which most cancel.
                    let off = (got - want).abs() / weight;
                    assert!(off < 1e-13, "{slots}, {decay}, {number}, {k}: {got} {want}, {off:e}");
                }
            }
            // Most of them were.
            assert!(merged > 1000, "{merged}");
        }
    }
}
