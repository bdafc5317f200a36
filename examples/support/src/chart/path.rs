//! A line on its way to the paper: broken at gaps, clipped to the panel, thinned. All lengths in px.

use super::layout::Frame;
use super::thin::{Ink, columns, simplify};

/// A place on the paper.
pub(super) type Point = (f64, f64);

/// The pieces of a line that are to be drawn; `None` breaks the line.
pub(super) fn pieces(line: impl Iterator<Item = Option<Point>>, frame: &Frame) -> Vec<Vec<Point>> {
    let mut runs = vec![Vec::new()];
    for point in line {
        match (point, runs.last_mut()) {
            (Some(point), Some(run)) => run.push(point),
            _ => runs.push(Vec::new()),
        }
    }
    let rises = |run: &Vec<Point>| run.windows(2).all(|pair| pair[0].0 <= pair[1].0);
    if runs.iter().all(rises) {
        let clipped = runs.iter().flat_map(|run| clip(&columns(run), frame));
        return clipped.map(|piece| simplify(&piece)).collect();
    }
    let mut ink = Ink::new(frame);
    let clipped = runs.iter().flat_map(|run| clip(run, frame));
    clipped.flat_map(|piece| ink.fresh(&piece)).map(|piece| simplify(&piece)).collect()
}

/// The parts of `run` inside `frame` (Liang and Barsky 1984).
fn clip(run: &[Point], frame: &Frame) -> Vec<Vec<Point>> {
    if let [only] = run {
        return if frame.contains(*only) { vec![vec![*only]] } else { Vec::new() };
    }
    let mut parts: Vec<Vec<Point>> = Vec::new();
    for pair in run.windows(2) {
        let Some((from, to)) = clip_segment(pair[0], pair[1], frame) else { continue };
        match parts.last_mut() {
            Some(part) if part.last() == Some(&from) => part.push(to),
            _ => parts.push(vec![from, to]),
        }
    }
    parts
}

fn clip_segment(p: Point, q: Point, frame: &Frame) -> Option<(Point, Point)> {
    let (dx, dy) = (q.0 - p.0, q.1 - p.1);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    let edges = [
        (-dx, p.0 - frame.left),
        (dx, frame.right() - p.0),
        (-dy, p.1 - frame.top),
        (dy, frame.bottom() - p.1),
    ];
    for (outward, distance) in edges {
        if outward == 0.0 {
            if distance < 0.0 {
                return None;
            }
        } else if outward < 0.0 {
            enter = enter.max(distance / outward);
        } else {
            leave = leave.min(distance / outward);
        }
    }
    let at = |t: f64| (p.0 + t * dx, p.1 + t * dy);
    // Unclipped ends stay exactly what they were, so that neighbouring segments join.
    let (from, to) =
        (if enter > 0.0 { at(enter) } else { p }, if leave < 1.0 { at(leave) } else { q });
    (enter <= leave).then_some((from, to))
}

#[cfg(test)]
mod tests {
    use super::super::thin::distance;
    use super::*;

    const FRAME: Frame = Frame { left: 0.0, top: 0.0, width: 500.0, height: 100.0 };

    fn drawn(points: impl Iterator<Item = Point>) -> Vec<Vec<Point>> {
        pieces(points.map(Some), &FRAME)
    }

    fn vertices(pieces: &[Vec<Point>]) -> usize {
        pieces.iter().map(Vec::len).sum()
    }

    #[test]
    fn a_straight_line_keeps_its_ends_only() {
        let line = drawn((0..=100_000).map(|i| (f64::from(i) / 200.0, f64::from(i) / 1000.0)));
        assert_eq!(line, [[(0.0, 0.0), (500.0, 100.0)]]);
    }

    #[test]
    fn a_dense_line_keeps_its_peaks() {
        let peak = 54_321;
        let line = drawn((0..100_000).map(|i| {
            (f64::from(i) / 200.0, if i == peak { 3.0 } else { 50.0 + f64::from(i % 3) })
        }));
        assert!(vertices(&line) < 2500, "{}", vertices(&line));
        assert!(line[0].iter().any(|p| p.1 == 3.0 && (p.0 - f64::from(peak) / 200.0).abs() <= 0.5));
    }

    #[test]
    fn no_point_of_a_smooth_curve_is_farther_from_the_drawing_than_a_fifth_of_a_pixel() {
        let curve = |i: u32| (f64::from(i) / 200.0, 50.0 + 40.0 * (f64::from(i) * 5e-4).sin());
        let line = drawn((0..100_000).map(curve));
        for point in (0..100_000).step_by(97).map(curve) {
            let near = line[0]
                .windows(2)
                .map(|pair| distance(point, pair[0], pair[1]))
                .fold(f64::INFINITY, f64::min);
            assert!(near < 0.2, "{point:?} is {near} px off");
        }
    }

    #[test]
    fn a_loop_run_through_many_times_is_drawn_about_once() {
        let circle = |turns: u32, steps: u32| {
            let angle =
                move |i| std::f64::consts::TAU * f64::from(turns) * f64::from(i) / f64::from(steps);
            drawn(
                (0..=steps)
                    .map(move |i| (250.0 + 40.0 * angle(i).cos(), 50.0 + 40.0 * angle(i).sin())),
            )
        };
        let (once, often) = (vertices(&circle(1, 1000)), vertices(&circle(307, 100_000)));
        assert!(once < 120, "{once}");
        assert!(often < 40 * once, "{often}");
    }

    #[test]
    fn a_gap_breaks_the_line_and_a_lone_point_survives() {
        let line = [Some((0.0, 1.0)), None, Some((2.0, 1.0)), Some((3.0, 5.0))];
        assert_eq!(
            pieces(line.into_iter(), &FRAME),
            [vec![(0.0, 1.0)], vec![(2.0, 1.0), (3.0, 5.0)]]
        );
    }

    #[test]
    fn a_line_is_cut_at_the_frame() {
        let line = drawn([(-100.0, 50.0), (250.0, 50.0), (250.0, 1e9), (260.0, 50.0)].into_iter());
        assert_eq!(line.len(), 2);
        assert_eq!(line[0], [(0.0, 50.0), (250.0, 50.0), (250.0, 100.0)]);
        assert!(line.iter().flatten().all(|&point| FRAME.contains(point)));
        assert!(drawn([(-2.0, -1.0), (600.0, -1.0)].into_iter()).is_empty());
    }

    #[test]
    fn no_point_of_a_line_that_crosses_itself_is_farther_from_ink_than_a_line_is_wide() {
        let angle = |i: u32| f64::from(i) * 0.01;
        let curve =
            |i: u32| (250.0 + 240.0 * angle(i).sin(), 50.0 + 40.0 * (1.01734 * angle(i)).sin());
        let line = drawn((0..100_000).map(curve));
        for point in (0..100_000).step_by(997).map(curve) {
            let segments = line.iter().flat_map(|piece| piece.windows(2));
            let near = segments
                .map(|pair| distance(point, pair[0], pair[1]))
                .fold(f64::INFINITY, f64::min);
            assert!(near < 1.0, "{point:?} is {near} px off");
        }
    }
}
