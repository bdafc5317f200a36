//! The search for the first sign change of a speed that is known at a few places of a step.

use crate::Scalar;
use crate::root::enclose;
use crate::scalar::lit;

/// A place in a step, and the speed there: positive in the direction of sliding.
pub(crate) type SpeedAt<T> = (T, T);

/// Where a speed first becomes negative within a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Crossing<T> {
    /// Nowhere.
    None,
    /// It is negative from the start.
    AtStart,
    /// The last place, within the tolerance of the search, at which it is not negative.
    At(T),
}

/// How exactly a sign change is searched for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Search<T> {
    /// A negative speed of no more than this size is taken for noise.
    pub(crate) forgiven: T,
    /// Tolerance of the place found; the rounding of a place if it is smaller.
    pub(crate) tolerance: T,
    /// A sign change within this distance of the start counts as one at the start.
    pub(crate) shortest: T,
}

/// A speed may have been negative between the places if its least value there is below this part of
/// its variation.
const CLOSE: f64 = 0.25;

/// Most parabolas through three places in the search for a minimum.
const PARABOLAS: u32 = 4;

/// Where a speed that starts from zero is looked up, as parts of the way to where it is negative.
const PROBES: [f64; 3] = [1e-3, 0.03, 0.3];

impl<T: Scalar> Search<T> {
    /// The first sign change of a speed, from its values at the start of the step and at two or
    /// more places after it.
    #[inline]
    pub(crate) fn first(self, mut speed: impl FnMut(T) -> T, speeds: &[SpeedAt<T>]) -> Crossing<T> {
        let Some(&start) = speeds.first() else { return Crossing::None };
        let Some((right, wrong)) = self.bracket(&mut speed, speeds) else {
            return Crossing::None;
        };
        let mut right = right.unwrap_or(start);
        if !(right.0 > start.0) && right.1 >= -self.forgiven {
            // A speed that starts near zero may be positive first.
            let probes = PROBES.map(|part| right.0 + (wrong.0 - right.0) * lit(part));
            let mut seen = probes.into_iter().map(|place| (place, speed(place)));
            right = seen.find(|&(_, speed)| speed > T::zero()).unwrap_or(right);
        }
        if right.1 < T::zero() {
            return Crossing::AtStart;
        }
        let (place, _) = enclose(speed, right, wrong, self.tolerance);
        if place - start.0 > self.shortest { Crossing::At(place) } else { Crossing::AtStart }
    }

    /// The first sight with a negative speed, and the last one before it with a speed that is not,
    /// if there is one.
    #[inline(always)]
    fn bracket(
        self,
        speed: &mut impl FnMut(T) -> T,
        speeds: &[SpeedAt<T>],
    ) -> Option<(Option<SpeedAt<T>>, SpeedAt<T>)> {
        let mut right = None;
        let (mut least, mut most, mut lowest) = (None, T::zero(), 0);
        for (index, &sight) in speeds.iter().enumerate() {
            if sight.1 < -self.forgiven {
                return Some((right, sight));
            }
            if sight.1 >= T::zero() {
                right = Some(sight);
            }
            if least.is_none_or(|least| sight.1 < least) {
                (least, lowest) = (Some(sight.1), index);
            }
            most = most.larger(sight.1);
        }
        let least = least?;
        if !(least < (most - least) * lit(CLOSE)) {
            return None;
        }
        let middle = lowest.clamp(1, speeds.len().checked_sub(2)?);
        let three = [speeds.get(middle - 1)?, speeds.get(middle)?, speeds.get(middle + 1)?];
        let (before, after) = self.dip(speed, three.map(|&sight| sight))?;
        Some((Some(before), after))
    }

    /// Whether a speed that is not negative at three places is negative between them: a place
    /// before, and one where it is, from the vertex of the parabola through the three places.
    fn dip(
        self,
        speed: &mut impl FnMut(T) -> T,
        mut three: [SpeedAt<T>; 3],
    ) -> Option<(SpeedAt<T>, SpeedAt<T>)> {
        let (half, zero): (T, T) = (lit(0.5), T::zero());
        for _ in 0..PARABOLAS {
            let [(t0, v0), (t1, v1), (t2, v2)] = three;
            let (first, second) = ((v1 - v0) / (t1 - t0), (v2 - v1) / (t2 - t1));
            let bend = (second - first) / (t2 - t0);
            if !(bend > zero) {
                return None;
            }
            let vertex = (t0 + t1 - first / bend) * half;
            let lowest = v1 - bend * (t1 - vertex) * (t1 - vertex);
            // A parabola above half of the least value known is taken for what it is.
            let least = v0.smaller(v1).smaller(v2);
            if !(vertex > t0 && vertex < t2 && lowest < least * half) {
                return None;
            }
            let there = (vertex, speed(vertex));
            let is_late = vertex > t1;
            if there.1 < -self.forgiven {
                let before = if is_late { (t1, v1) } else { (t0, v0) };
                return (before.1 > zero).then_some((before, there));
            }
            three = match (is_late, there.1 < v1) {
                (false, true) => [three[0], there, three[1]],
                (false, false) => [there, three[1], three[2]],
                (true, true) => [three[1], there, three[2]],
                (true, false) => [three[0], three[1], there],
            };
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::{Crossing, Search};

    #[test]
    fn sign_changes_between_places_are_seen_in_a_parabola() {
        let places = [0.0, 0.1, 0.4, 0.8, 1.0];
        let search = Search { forgiven: 0.0, tolerance: 0.0, shortest: 0.0 };
        let find = |f: &dyn Fn(f64) -> f64| search.first(f, &places.map(|place| (place, f(place))));
        let parabola = |bottom: f64| move |x: f64| (x - 0.6) * (x - 0.6) + bottom;
        assert_eq!(find(&parabola(1e-9)), Crossing::None);
        let dips = find(&parabola(-1e-4));
        assert!(matches!(dips, Crossing::At(place) if (place - 0.59).abs() < 1e-12));
        assert_eq!(find(&|x| x), Crossing::None);
        assert_eq!(find(&|x| -x), Crossing::AtStart);
        assert_eq!(find(&|_| 0.0), Crossing::None);
        assert!(matches!(find(&|x| 0.9 - x), Crossing::At(place) if (place - 0.9).abs() < 1e-15));
    }

    #[test]
    fn a_speed_that_starts_from_zero_may_be_positive_first() {
        let search = Search { forgiven: 0.0, tolerance: 0.0, shortest: 1e-9 };
        let hump = |x: f64| x * (0.05 - x);
        let speeds = [0.0, 0.5, 1.0].map(|place| (place, hump(place)));
        let found = search.first(hump, &speeds);
        assert!(matches!(found, Crossing::At(place) if (place - 0.05).abs() < 1e-12), "{found:?}");
    }
}
