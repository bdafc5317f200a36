//! Whether the instants of a pilot show what a velocity does between them.
//!
//! A velocity costs nothing to look at beside a friction model. So it is looked at every answer of what a pilot judges,
//! and a pilot that looks at each n-th answer only must not leave out, from one of its instants to the next,
//!
//! - a velocity outside the range of both by more than 5 % of the largest speed,
//! - a speed above twice that of the faster one, or, in one direction, below half that of the slower one, by more than
//!   0.5 % of the largest speed,
//! - a reversal that is not told by both ends.

/// Share of the largest speed by which the range of both ends may be left. What it does to μ is of the second
/// order in the stretch of time for a smooth velocity.
const BEYOND: f64 = 0.05;
/// Share of the largest speed below which a ratio of speeds tells nothing.
const SMALL: f64 = 0.005;
/// Share of the largest speed that is zero but for roundings.
const NOTHING: f64 = 1e-9;

/// Whether the instants after each so many answers show what a velocity, given by its answer, does until the last.
pub(super) fn shows(stride: usize, answers: usize, velocity: impl Fn(usize) -> f64) -> bool {
    if stride <= 1 {
        return true;
    }
    let speeds = (0..=answers).map(|answer| super::size(velocity(answer)));
    let largest = speeds.fold(0.0, |most: f64, speed| if speed <= most { most } else { speed });
    let mut begin = 0;
    let mut first = velocity(0);
    while begin < answers {
        let end = begin + stride;
        // No pilot looks at what is left after its last instant.
        let (last, stop) = if end <= answers { (velocity(end), end) } else { (first, answers + 1) };
        if hides([first, last], largest, (begin + 1..stop).map(&velocity)) {
            return false;
        }
        (begin, first) = (end, last);
    }
    true
}

/// Whether something happens between two instants that they do not show.
fn hides(ends: [f64; 2], largest: f64, between: impl Iterator<Item = f64>) -> bool {
    let sorted = |a: f64, b: f64| if a < b { (a, b) } else { (b, a) };
    let [first, last] = ends;
    let (low, high) = sorted(first, last);
    let (slow, fast) = sorted(super::size(first), super::size(last));
    let side = |v: f64| {
        if super::size(v) <= NOTHING * largest { 0 } else { if v > 0.0 { 1 } else { -1 } }
    };
    let (beyond, small) = (BEYOND * largest, SMALL * largest);
    let one_way = side(first) * side(last) > 0;
    let (mut now, mut reversals) = (side(first), 0);
    for v in between.chain([last]) {
        let speed = super::size(v);
        // NaN is not inside.
        let inside = v >= low - beyond && v <= high + beyond;
        let slower = one_way && 2.0 * speed + small < slow;
        if !inside || speed > 2.0 * fast + small || slower {
            return true;
        }
        let next = side(v);
        if next != 0 {
            if now * next < 0 {
                reversals += 1;
            }
            now = next;
        }
    }
    reversals > i32::from(side(first) * side(last) < 0)
}

#[cfg(test)]
mod tests {
    use super::shows;

    /// A velocity of so much at some answers and 1 at all others, and whether each eighth shows it.
    fn each_eighth_shows(odd: &[usize], value: f64) -> bool {
        shows(8, 100, |answer| if odd.contains(&answer) { value } else { 1.0 })
    }

    #[test]
    fn what_leaves_the_range_of_both_ends_does_not_show() {
        assert!(each_eighth_shows(&[19], 1.04));
        assert!(!each_eighth_shows(&[19], 1.2));
        assert!(!each_eighth_shows(&[19], f64::NAN));
        assert!(!each_eighth_shows(&[99], 1.2), "after the last instant");
    }

    #[test]
    fn a_reversal_there_and_back_does_not_show() {
        let velocity = |answer: usize| match answer {
            0..=39 => 1.0,
            43 | 45 => -0.01,
            40..=47 => 0.01,
            _ => -1.0,
        };
        assert!(!shows(8, 100, velocity));
        assert!(shows(8, 96, |answer| 50.5 - answer as f64));
        assert!(shows(8, 96, |answer| 56.0 - answer as f64), "a reversal at an instant");
    }

    #[test]
    fn a_slow_or_a_quick_moment_does_not_show_beside_a_fast_one() {
        // The range is left by less than 5 % of the largest speed.
        let velocity = |value: f64| {
            move |answer: usize| match answer {
                0 => 1.0,
                50 => value,
                _ => 0.04,
            }
        };
        assert!(!shows(8, 100, |answer| if answer < 8 { 1.0 } else { velocity(1e-3)(answer) }));
        assert!(!shows(8, 100, |answer| if answer < 8 { 1.0 } else { velocity(0.088)(answer) }));
        assert!(shows(8, 100, |answer| if answer < 8 { 1.0 } else { velocity(0.03)(answer) }));
    }
}
