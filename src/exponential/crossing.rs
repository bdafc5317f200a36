//! Where a velocity first reverses within a step, from its values at the nodes.

use crate::Scalar;
use crate::root::enclose;
use crate::scalar::lit;

/// A time with the velocity there, counted positive in the direction of sliding.
pub(super) type Sight<T> = (T, T);

/// What the values at the nodes tell of reversals.
pub(super) enum Reversal<T> {
    /// None.
    None,
    /// It slides the other way from the start.
    AtStart,
    /// The last time, to rounding, before it slides the other way.
    At(T),
}

/// A velocity whose least value at the nodes is below this part of its variation may have been
/// negative between them.
const CLOSE: f64 = 0.25;

/// The first reversal of a velocity that is known at the start and at the nodes of a step.
pub(super) fn first_reversal<T: Scalar, const S: usize>(
    ahead: impl Fn(T) -> T,
    start: Sight<T>,
    nodes: &[Sight<T>; S],
) -> Reversal<T> {
    let zero = T::zero();
    let mut before = start;
    let (mut least, mut most, mut place) = (start.1, start.1, 0);
    for (index, &node) in nodes.iter().enumerate() {
        if node.1 < zero {
            return if before.1 > zero {
                Reversal::At(crossing(ahead, before, node))
            } else {
                Reversal::AtStart
            };
        }
        if node.1 < least {
            least = node.1;
            place = index + 1;
        }
        if node.1 > most {
            most = node.1;
        }
        before = node;
    }
    if !(least < (most - least) * lit(CLOSE)) {
        return Reversal::None;
    }
    // The three neighbours that hold the least value, of the start and the nodes.
    let right = place.clamp(1, S - 1);
    let sight = |index: usize| match index.checked_sub(1) {
        None => start,
        Some(index) => nodes.get(index).copied().unwrap_or(start),
    };
    match dip(&ahead, [sight(right - 1), sight(right), sight(right + 1)]) {
        Some((before, after)) => Reversal::At(crossing(ahead, before, after)),
        None => Reversal::None,
    }
}

/// Whether a velocity that is not negative at three times is so between them: a point before and one
/// where it is. The vertex of the parabola through three points, a few times over.
fn dip<T: Scalar>(
    ahead: impl Fn(T) -> T,
    mut three: [Sight<T>; 3],
) -> Option<(Sight<T>, Sight<T>)> {
    let (half, zero): (T, T) = (lit(0.5), T::zero());
    for _ in 0..4 {
        let [(t0, v0), (t1, v1), (t2, v2)] = three;
        let (first, second) = ((v1 - v0) / (t1 - t0), (v2 - v1) / (t2 - t1));
        let bend = (second - first) / (t2 - t0);
        if !(bend > zero) {
            return None;
        }
        let vertex = (t0 + t1 - first / bend) * half;
        let lowest = v1 - bend * (t1 - vertex) * (t1 - vertex);
        // Above half of the least value known the parabola need not be doubted.
        let least = if v0 < v1 { v0 } else { v1 };
        let least = if v2 < least { v2 } else { least };
        if !(vertex > t0 && vertex < t2 && lowest < least * half) {
            return None;
        }
        let there = (vertex, ahead(vertex));
        let late = vertex > t1;
        if there.1 < zero {
            let before = if late { three[1] } else { three[0] };
            return (before.1 > zero).then_some((before, there));
        }
        three = match (late, there.1 < v1) {
            (false, true) => [three[0], there, three[1]],
            (false, false) => [there, three[1], three[2]],
            (true, true) => [three[1], there, three[2]],
            (true, false) => [three[0], three[1], there],
        };
    }
    None
}

/// The last time, to rounding, at which a function that is positive at a is not negative on the way
/// to b, where it is.
fn crossing<T: Scalar>(function: impl Fn(T) -> T, a: Sight<T>, b: Sight<T>) -> T {
    let (before, _) = enclose(function, a, b, T::zero());
    before
}

#[cfg(test)]
mod tests {
    use super::{Reversal, first_reversal};

    #[test]
    fn reversals_between_nodes_are_seen_in_a_parabola() {
        let places = [0.1, 0.4, 0.8, 1.0];
        let find = |f: &dyn Fn(f64) -> f64| {
            let nodes = places.map(|place| (place, f(place)));
            first_reversal(f, (0.0, f(0.0)), &nodes)
        };
        let parabola = |bottom: f64| move |x: f64| (x - 0.6) * (x - 0.6) + bottom;
        assert!(matches!(find(&parabola(1e-9)), Reversal::None));
        let dips = find(&parabola(-1e-4));
        assert!(matches!(dips, Reversal::At(place) if (place - 0.59).abs() < 1e-12));
        assert!(matches!(find(&|x| x), Reversal::None));
        assert!(matches!(find(&|x| -x), Reversal::AtStart));
        assert!(matches!(find(&|_| 0.0), Reversal::None));
        assert!(matches!(find(&|x| 0.9 - x), Reversal::At(place) if (place - 0.9).abs() < 1e-15));
    }
}
