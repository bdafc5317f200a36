//! The bristles of a patch as a queue, from which the moments of the whole profile are read in a fixed
//! number of operations.
//!
//! All bristles obey the same linear equation, so a step does the same to each, z ← e^(−λh) z + offset,
//! moves them on by V h, and adds a *segment* of new ones, of known profile. In the order of age, newest
//! first, the queue has three parts:
//!
//! * the *back*: its moments are advanced step by step, for nothing leaves it;
//! * the *middle*: a back that was frozen; over it runs, a few segments a step, the preparation of …
//! * the *front*: segments with the moments of all that are newer, in the coordinates of the moment when it
//!   was frozen, with one map and one shift for all that has happened map_since. What is left of it inside the
//!   patch is read by cutting one segment.
//!
//! When the front has left, the middle becomes the front and the back is frozen. Nothing is ever taken
//! away from a sum, which is why no digits are lost: a heavily deflected bristle that has left leaves no
//! rounding error behind.
//!
//! It is the two-stack queue of sliding-window aggregation, with its rebuilding spread over the steps.

use super::profile::{Map, Profile, shifted};
use crate::Scalar;
use crate::scalar::{is_zero, lit};

/// Steps are taken in parts no longer than this: what is new then fits between the inlet and a back
/// that is about to be frozen.
pub(super) const LONGEST: f64 = 0.25;
/// A back of this length is frozen if there is no middle …
const LONG: f64 = 0.5;
/// … and when the front has left, one of this length at least.
const SHORT: f64 = 0.25;

/// Room for one segment of a profile in an [`ExactPatch`](crate::rolling::ExactPatch).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment<T, const N: usize> {
    pub(super) segment: Profile<T>,
    /// What became of older bristles while this segment entered. In the front it is used up.
    map: Map<T>,
    /// Place of the newest bristle, in the front's coordinates.
    place: T,
    /// Moments of the segment, in its own coordinates; once prepared those of all newer segments, in the
    /// front's.
    moments: [T; N],
}

impl<T: Scalar, const N: usize> Default for Segment<T, N> {
    fn default() -> Self {
        let zero = T::zero();
        Self {
            segment: Profile::straight(zero, zero, zero),
            map: Map::identity(),
            place: zero,
            moments: [zero; N],
        }
    }
}

/// A frozen part of the profile and what has happened to it map_since.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stack<T, const N: usize> {
    count: usize,
    /// From its newest to its oldest bristle.
    length: T,
    /// How far it has moved.
    shift: T,
    map: Map<T>,
    /// Moments of the whole, when it was frozen.
    total: [T; N],
}

impl<T: Scalar, const N: usize> Stack<T, N> {
    fn empty() -> Self {
        let zero = T::zero();
        Self { count: 0, length: zero, shift: zero, map: Map::identity(), total: [zero; N] }
    }
}

/// A step with held coefficients: λ, u = r v, V and a duration, in what it does.
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
        let affine =
            crate::Affine { relaxation, drive: T::one(), stiffness: T::zero(), damping: T::zero() };
        let weights = affine.weights(duration);
        let map =
            Map { decay: weights.end(T::one(), T::zero()), offset: weights.end(T::zero(), drive) };
        Self { distance, map, inflow: Profile::inflow(distance, relaxation, drive, duration) }
    }
}

/// The queue.
#[derive(Debug, Clone)]
pub(super) struct Queue<T, const N: usize, B> {
    slots: B,
    /// Index of the oldest slot in the ring.
    oldest: usize,
    front: Stack<T, N>,
    middle: Stack<T, N>,
    /// How many segments of the middle are prepared, newest first, and the state of that.
    ready: usize,
    place: T,
    newer: [T; N],
    map_since: Map<T>,
    back_count: usize,
    back_length: T,
    back: [T; N],
    /// a of the weight e^(−aξ).
    decay: T,
    /// Steps that move on by less are merged with each other.
    narrowest: T,
}

impl<T: Scalar, const N: usize, B: AsRef<[Segment<T, N>]> + AsMut<[Segment<T, N>]>> Queue<T, N, B> {
    /// Least number of slots: a half of [`LONGEST`], the least part of a step that is split, is then not
    /// merged.
    pub(super) const LEAST: usize = 22;

    /// A patch of undeflected bristles, in at least [`Queue::LEAST`] slots.
    pub(super) fn new(slots: B, decay: T) -> Self {
        // Every slot that is narrower is followed by one that is not; a few more are cut at the outlet or
        // were frozen early.
        let narrowest = lit::<T>(2.0) / lit(slots.as_ref().len().saturating_sub(6).max(1) as f64);
        let mut queue = Self {
            slots,
            oldest: 0,
            front: Stack::empty(),
            middle: Stack::empty(),
            ready: 0,
            place: T::zero(),
            newer: [T::zero(); N],
            map_since: Map::identity(),
            back_count: 0,
            back_length: T::zero(),
            back: [T::zero(); N],
            decay,
            narrowest,
        };
        queue.fill(Profile::straight(T::one(), T::zero(), T::zero()));
        queue
    }

    pub(super) fn narrowest(&self) -> T {
        self.narrowest
    }

    pub(super) fn capacity(&self) -> usize {
        self.slots.as_ref().len()
    }

    /// Number of slots in use.
    pub(super) fn len(&self) -> usize {
        self.front.count + self.middle.count + self.back_count
    }

    /// One segment for the whole patch.
    pub(super) fn fill(&mut self, segment: Profile<T>) {
        self.begin();
        self.append(segment);
        self.finish();
    }

    /// Forgets everything; [`Queue::append`] and then [`Queue::finish`] make a new profile.
    pub(super) fn begin(&mut self) {
        self.oldest = 0;
        self.front = Stack::empty();
        self.middle = Stack::empty();
        self.clear_back();
        self.start_rebuild();
    }

    /// Adds a segment at the outlet side of those that were appended before.
    pub(super) fn append(&mut self, segment: Profile<T>) {
        // The ring grows towards the older side: one before the oldest.
        let capacity = self.capacity();
        self.oldest = (self.oldest + capacity - 1) % capacity;
        self.front.count += 1;
        self.put(0, segment);
    }

    pub(super) fn finish(&mut self) {
        self.front.length = self.place;
        self.front.total = self.newer;
        self.start_rebuild();
    }

    fn clear_back(&mut self) {
        self.back_count = 0;
        self.back_length = T::zero();
        self.back = [T::zero(); N];
    }

    /// Begins the preparation of a middle.
    fn start_rebuild(&mut self) {
        self.ready = 0;
        self.place = T::zero();
        self.newer = [T::zero(); N];
        self.map_since = Map::identity();
    }

    /// Where the slot of some age is in the ring, counted from the oldest.
    #[inline(always)]
    fn index(&self, number: usize) -> usize {
        let capacity = self.slots.as_ref().len();
        let index = self.oldest + number;
        if index >= capacity { index - capacity } else { index }
    }

    #[inline(always)]
    fn slot(&self, number: usize) -> Option<&Segment<T, N>> {
        self.slots.as_ref().get(self.index(number))
    }

    /// Into how many equal parts a step of this distance has to be split; none if nothing of what is
    /// there will be left.
    pub(super) fn parts(distance: T) -> Option<usize> {
        (1..=4).find(|&parts| distance <= lit(LONGEST * parts as f64))
    }

    /// Everything is new: the profile of steady rolling.
    pub(super) fn replace(&mut self, relaxation: T, drive: T, transport: T) {
        let crossing = T::one() / transport;
        self.fill(Profile::inflow(T::one(), relaxation, drive, crossing));
    }

    /// A step of at most a quarter of the patch.
    #[inline]
    pub(super) fn advance(&mut self, held: &Held<T>) {
        if self.len() >= self.capacity() {
            // Not by the count of narrow and wide ones; roundings may add a few.
            self.collapse();
        }
        self.prepare(held.distance);
        self.front.map = held.map.after(self.front.map);
        self.middle.map = held.map.after(self.middle.map);
        self.front.shift += held.distance;
        self.middle.shift += held.distance;
        let moments = held.inflow.moments::<N>(T::one(), self.decay);
        self.back = self.back_after(held, &moments);
        self.back_length += held.distance;
        self.enter(held, moments);
        self.leave();
    }

    /// Prepares as much of the middle as this distance asks for, all of it if the front will leave.
    #[inline]
    fn prepare(&mut self, distance: T) {
        if self.ready >= self.middle.count {
            return;
        }
        let left = T::one() - self.back_length - self.middle.length;
        let open = self.middle.count - self.ready;
        if !(distance < left) {
            while self.ready < self.middle.count {
                self.prepare_one();
            }
            return;
        }
        // In proportion to the way that the front still has to go.
        let quota = lit::<T>(open as f64) * distance / left;
        let mut done = T::zero();
        while done < quota && self.ready < self.middle.count {
            self.prepare_one();
            done += T::one();
        }
    }

    fn prepare_one(&mut self) {
        let number = self.front.count + self.middle.count - 1 - self.ready;
        let (index, decay) = (self.index(number), self.decay);
        let (place, newer, map_since) = (self.place, self.newer, self.map_since);
        if let Some(slot) = self.slots.as_mut().get_mut(index) {
            let moments = map_since.of_moments(slot.moments, slot.segment.width, decay);
            slot.segment = slot.segment.mapped(map_since);
            slot.place = place;
            slot.moments = newer;
            self.map_since = map_since.after(slot.map);
            self.place += slot.segment.width;
            add(&mut self.newer, &shifted(moments, place, decay));
        }
        self.ready += 1;
    }

    /// The moments of the back after a step.
    #[inline]
    fn back_after(&self, held: &Held<T>, new: &[T; N]) -> [T; N] {
        let mut back = self.back;
        if self.back_length > T::zero() {
            back = held.map.of_moments(back, self.back_length, self.decay);
            back = shifted(back, held.distance, self.decay);
        }
        add(&mut back, new);
        back
    }

    /// Puts the segment of a step into a slot.
    #[inline]
    fn enter(&mut self, held: &Held<T>, moments: [T; N]) {
        let (narrowest, decay) = (self.narrowest, self.decay);
        if self.back_count > 0 {
            let newest = self.index(self.len() - 1);
            let narrow = held.distance < narrowest;
            if let Some(slot) = self.slots.as_mut().get_mut(newest) {
                let nothing_new = is_zero(held.distance);
                if nothing_new || (narrow && slot.segment.width < narrowest) {
                    let mut exact = held.map.of_moments(slot.moments, slot.segment.width, decay);
                    slot.segment = slot.segment.mapped(held.map);
                    slot.map = held.map.after(slot.map);
                    if !nothing_new {
                        slot.segment = slot.segment.merged_with(&held.inflow, decay);
                        exact = shifted(exact, held.distance, decay);
                        add(&mut exact, &moments);
                    }
                    slot.moments = slot.segment.moments(T::one(), decay);
                    // The newest segment begins at the inlet: its moments are its part of the back's. Those
                    // of a straight line are kept in the account, or force and energy would part.
                    for ((back, merged), exact) in
                        self.back.iter_mut().zip(slot.moments).zip(exact).skip(1)
                    {
                        *back += merged - exact;
                    }
                    return;
                }
            }
        } else if is_zero(held.distance) {
            return;
        }
        let free = self.index(self.len());
        if let Some(slot) = self.slots.as_mut().get_mut(free) {
            let segment = held.inflow;
            *slot = Segment { segment, map: held.map, place: T::zero(), moments };
            self.back_count += 1;
        }
    }

    /// Forgets what has left the patch.
    #[inline]
    fn leave(&mut self) {
        while self.front.count > 0 {
            let outside = self.slot(0).is_none_or(|s| !(s.place + self.front.shift < T::one()));
            if !outside {
                break;
            }
            self.oldest = self.index(1);
            self.front.count -= 1;
        }
        if self.middle.count > 0 && !(self.back_length + self.middle.length < T::one()) {
            // The front has left, up to rounding.
            while self.ready < self.middle.count {
                self.prepare_one();
            }
            self.oldest = self.index(self.front.count);
            self.front = Stack { total: self.newer, ..self.middle };
            self.middle = Stack::empty();
            self.start_rebuild();
            if self.back_length >= lit(SHORT) {
                self.freeze();
            }
        }
        if self.middle.count == 0 && self.back_length >= lit(LONG) {
            self.freeze();
        }
    }

    fn freeze(&mut self) {
        self.middle = Stack {
            count: self.back_count,
            length: self.back_length,
            shift: T::zero(),
            map: Map::identity(),
            total: self.back,
        };
        self.clear_back();
        self.start_rebuild();
    }

    /// The moments ∫₀¹ ξᵏ e^(−aξ) z dξ of the whole profile.
    #[inline]
    pub(super) fn moments(&self) -> [T; N] {
        let mut total = self.back;
        add(&mut total, &self.of_stack(&self.middle, None, T::zero()));
        add(&mut total, &self.of_stack(&self.front, Some(0), T::zero()));
        total
    }

    /// The moments of what is inside of a frozen part, and still will be after a distance; `first` is the
    /// number of its oldest slot, if it is prepared and may be cut by the outlet.
    #[inline]
    fn of_stack(&self, stack: &Stack<T, N>, first: Option<usize>, distance: T) -> [T; N] {
        let Stack { shift, map, .. } = *stack;
        let cut = T::one() - shift - distance;
        if stack.count == 0 || !(cut > T::zero()) {
            return [T::zero(); N];
        }
        let (mut moments, mut length) = (stack.total, stack.length);
        if let Some(first) = first
            && cut < length
        {
            length = cut;
            moments = [T::zero(); N];
            for number in first..first + stack.count {
                let Some(slot) = self.slot(number) else { break };
                if slot.place < cut {
                    moments = slot.moments;
                    let part = (cut - slot.place) / slot.segment.width;
                    let part = if part < T::one() { part } else { T::one() };
                    let own = slot.segment.moments::<N>(part, self.decay);
                    add(&mut moments, &shifted(own, slot.place, self.decay));
                    break;
                }
            }
        }
        shifted(map.of_moments(moments, length, self.decay), shift, self.decay)
    }
}

impl<T: Scalar, const N: usize, B: AsRef<[Segment<T, N>]> + AsMut<[Segment<T, N>]>> Queue<T, N, B> {
    /// Makes ready for [`Queue::staying`] over a distance, however long.
    pub(super) fn look_ahead(&mut self, distance: T) {
        if distance <= lit(LONGEST) {
            self.prepare(distance);
        } else if self.middle.count > 0 || self.back_count > 0 {
            self.collapse();
        }
    }

    /// Makes one front of all that is inside: as many operations as there are segments. A narrow segment
    /// that is followed by another one is merged with it, for there is no back left to merge what
    /// comes next with, and narrow ones would add up.
    fn collapse(&mut self) {
        while self.ready < self.middle.count {
            self.prepare_one();
        }
        let (front, middle, count) = (self.front, self.middle, self.len());
        let (narrowest, decay) = (self.narrowest, self.decay);
        self.start_rebuild();
        let mut map_since = Map::identity();
        // From the newest to the oldest; `last` is yet to be written, and never farther than what is read.
        let (mut last, mut written): (Option<Profile<T>>, usize) = (None, count);
        for number in (0..count).rev() {
            let Some(slot) = self.slot(number) else { break };
            let mut segment = if number < front.count {
                slot.segment.mapped(front.map)
            } else if number < front.count + middle.count {
                slot.segment.mapped(middle.map)
            } else {
                let now = map_since;
                map_since = map_since.after(slot.map);
                slot.segment.mapped(now)
            };
            if let Some(newer) = last {
                let narrow = newer.width < narrowest && segment.width < narrowest;
                let inside = self.place + newer.width + segment.width <= T::one();
                if narrow && inside {
                    segment = segment.merged_with(&newer, decay);
                } else {
                    written -= 1;
                    self.put(written, newer);
                }
            }
            last = Some(segment);
        }
        if let Some(oldest) = last {
            written -= 1;
            self.put(written, oldest);
        }
        self.oldest = self.index(written);
        self.front = Stack {
            count: count - written,
            length: self.place,
            shift: T::zero(),
            map: Map::identity(),
            total: self.newer,
        };
        self.middle = Stack::empty();
        self.clear_back();
        self.start_rebuild();
    }

    /// Writes the segment that follows those before it into a slot, prepared.
    fn put(&mut self, number: usize, segment: Profile<T>) {
        let (index, place, newer) = (self.index(number), self.place, self.newer);
        if let Some(slot) = self.slots.as_mut().get_mut(index) {
            *slot = Segment { segment, map: Map::identity(), place, moments: newer };
        }
        let moments = segment.moments::<N>(T::one(), self.decay);
        add(&mut self.newer, &shifted(moments, place, self.decay));
        self.place += segment.width;
    }

    /// The frozen parts that the outlet may cut, with the number of their first slot: oldest first.
    fn stacks(&self) -> [(&Stack<T, N>, Option<usize>); 2] {
        let ready = (self.ready == self.middle.count).then_some(self.front.count);
        [(&self.front, Some(0)), (&self.middle, ready)]
    }

    /// The moments of those bristles that are inside now and still will be after a distance. After
    /// [`Queue::look_ahead`].
    pub(super) fn staying(&self, distance: T) -> [T; N] {
        let mut total = self.back;
        for (stack, first) in self.stacks() {
            add(&mut total, &self.of_stack(stack, first, distance));
        }
        total
    }

    /// Calls `visit` for every segment that crosses the outlet on the way, oldest first: from which
    /// distance on, to which, how steep its profile is over that part, and its deflection at the outlet
    /// over the distance, if nothing drove it meanwhile. After [`Queue::look_ahead`].
    pub(super) fn leaving(&self, distance: T, mut visit: impl FnMut(T, T, T, &dyn Fn(T) -> T)) {
        let mut from = T::zero();
        for (stack, first) in self.stacks() {
            let Some(first) = first else { return };
            for number in first..first + stack.count {
                let Some(slot) = self.slot(number) else { return };
                // The newest bristle of the segment is at the outlet after this distance.
                let gone = T::one() - stack.shift - slot.place;
                let to = if gone < distance { gone } else { distance };
                if to > from {
                    let segment = slot.segment.mapped(stack.map);
                    let steepness = segment.exponent * ((to - from) / segment.width);
                    visit(from, to, steepness, &|at| segment.at((gone - at) / segment.width));
                    from = to;
                }
                if !(from < distance) {
                    return;
                }
            }
        }
    }

    /// Calls `visit` for every segment inside, newest first: its profile now, the place of its newest
    /// bristle, and the part of its width that is inside.
    pub(super) fn profile(&self, mut visit: impl FnMut(&Profile<T>, T, T)) {
        let (mut place, mut map_since) = (T::zero(), Map::identity());
        let (front, middle) = (&self.front, &self.middle);
        for number in (0..self.len()).rev() {
            let Some(slot) = self.slot(number) else { return };
            let in_middle = (front.count + middle.count).wrapping_sub(number + 1);
            let segment = if number < front.count {
                slot.segment.mapped(front.map)
            } else if number < front.count + middle.count {
                if in_middle < self.ready {
                    slot.segment.mapped(middle.map)
                } else {
                    if in_middle == self.ready {
                        map_since = middle.map.after(self.map_since);
                    }
                    let now = map_since;
                    map_since = map_since.after(slot.map);
                    slot.segment.mapped(now)
                }
            } else {
                let now = map_since;
                map_since = map_since.after(slot.map);
                slot.segment.mapped(now)
            };
            let room = T::one() - place;
            if !(room > T::zero()) {
                return;
            }
            let part = if segment.width > room { room / segment.width } else { T::one() };
            visit(&segment, place, part);
            place += segment.width;
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
    use crate::rolling::integrals::integrate;
    use std::vec;

    /// A step, and how many segments it prepared.
    fn prepared(queue: &mut Queue<f64, 1, vec::Vec<Segment<f64, 1>>>, way: f64) -> usize {
        let (count, ready) = (queue.middle.count, queue.ready);
        queue.advance(&Held::new(0.1, 0.01, 1.0, way));
        // A middle that has become the front was prepared to its end.
        let same = queue.middle.count == count && queue.middle.shift >= way;
        if same { queue.ready - ready } else { count - ready }
    }

    #[test]
    fn a_step_prepares_at_most_three_times_its_share_of_the_slots() {
        let mut seed = 5_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut worst = 0.0_f64;
        for slots in [22, 100, 2000] {
            let mut queue = Queue::new(vec![Segment::<f64, 1>::default(); slots], 0.0);
            let narrowest = queue.narrowest();
            let (mut dense, mut wide, mut left) = (true, 0.1, 0.0);
            for _ in 0..300_000 {
                if left <= 0.0 {
                    // Stretches of as many segments as there can be, and of as few.
                    (dense, wide, left) = (random() < 0.7, 0.05 * random(), random());
                }
                let way = match (dense, random() < 0.5) {
                    (true, true) => narrowest * 1e-6,
                    (true, false) => narrowest,
                    (false, _) => wide + 1e-9,
                };
                let way = way.min(0.05);
                left -= way;
                let count = prepared(&mut queue, way);
                // One for the rounding up.
                let share = (count as f64 - 1.0) / (slots as f64 * way);
                worst = if count > 1 && share > worst { share } else { worst };
                assert!(
                    count as f64 <= 3.0 * slots as f64 * way + 1.0,
                    "{count} of {slots}, {way}"
                );
            }
        }
        // Twice would not do.
        assert!(worst > 2.0, "{worst}");
    }

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
            let narrowest = queue.narrowest();
            let (mut merged, mut drive) = (0, 0.0);
            for number in 0..3000 {
                if number % 37 == 0 {
                    drive = 2.0 * random() - 1.0;
                }
                let before = queue.len();
                // Mostly up to half as wide as what is not merged; a wide one, and patches that stand. With
                // u = λ drive all |z| ≤ 1.
                let (transport, duration) = match number % 50 {
                    0 => (1.0, 0.2),
                    1..4 => (0.0, 1e-3),
                    _ => (1.0, 0.5 * narrowest * random()),
                };
                queue.advance(&Held::new(5.0, 5.0 * drive, transport, duration));
                let way = transport * duration;
                merged += usize::from(way > 0.0 && queue.len() <= before);
                let (got, want) = (queue.moments(), shown(&queue, decay));
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
