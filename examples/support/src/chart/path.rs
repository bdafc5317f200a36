//! A line on its way to the paper: broken at gaps, clipped to the panel, thinned, dashed. All lengths in px.

use super::layout::Frame;
use super::style::Dash;

/// A place on the paper.
pub(super) type Point = (f64, f64);

/// A vertex may be left out if the line stays this close to it; a tenth of the thinnest line.
const TOLERANCE: f64 = 0.08;

/// Side of the cells by which ink already on the paper is remembered; a third of a line's width.
const CELL: f64 = 0.5;

/// Path length after which a line that returns to inked cells is not drawn again; some cells long.
const WET: f64 = 4.0 * CELL;

/// Most dashes of one line. A line so long that it needs more fills its panel anyway; its dashes are drawn longer.
const MOST_DASHES: f64 = 1200.0;

/// The pieces of a line that are to be drawn; `None` breaks the line.
pub(super) fn pieces(line: impl Iterator<Item = Option<Point>>, frame: &Frame) -> Vec<Vec<Point>> {
    let mut runs = vec![Vec::new()];
    for point in line {
        match (point, runs.last_mut()) {
            (Some(point), Some(run)) => run.push(point),
            _ => runs.push(Vec::new()),
        }
    }
    let mut ink = None;
    let mut pieces = Vec::new();
    for run in runs {
        if run.windows(2).all(|pair| pair[0].0 <= pair[1].0) {
            pieces.extend(clip(&columns(&run), frame).iter().map(|piece| simplify(piece)));
        } else {
            let ink = ink.get_or_insert_with(|| Ink::new(frame));
            for piece in clip(&run, frame) {
                pieces.extend(ink.fresh(&piece).iter().map(|piece| simplify(piece)));
            }
        }
    }
    pieces
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

/// For a line that runs from left to right: of every column one pixel wide, the first, lowest, highest and last point; of
/// a column that the line crosses up and down several times, an upright stroke in its middle.
fn columns(run: &[Point]) -> Vec<Point> {
    let mut kept = Vec::new();
    for column in run.chunk_by(|p, q| p.0.floor() == q.0.floor()) {
        let by_height = |&i: &usize, &j: &usize| column[i].1.total_cmp(&column[j].1);
        let low = (0..column.len()).min_by(by_height).unwrap_or(0);
        let high = (0..column.len()).max_by(by_height).unwrap_or(0);
        let travelled: f64 = column.windows(2).map(|pair| (pair[1].1 - pair[0].1).abs()).sum();
        let (from, to) = (low.min(high), low.max(high));
        if travelled > 3.0 * (column[high].1 - column[low].1) {
            // Slanted strokes from extreme to extreme would leave white wedges between the columns.
            let middle = column[from].0.floor() + 0.5;
            kept.extend([(middle, column[from].1), (middle, column[to].1)]);
        } else {
            let mut indices = vec![0, from, to, column.len() - 1];
            indices.dedup();
            kept.extend(indices.into_iter().map(|i| column[i]));
        }
    }
    kept
}

/// Remembers where ink lies, so that a loop run through a thousand times is drawn once.
struct Ink<'a> {
    frame: &'a Frame,
    columns: usize,
    /// The length of path drawn when the cell took its ink; blank cells will never.
    inked: Vec<f64>,
    drawn: f64,
}

impl Ink<'_> {
    fn new(frame: &Frame) -> Ink<'_> {
        let cells = |length: f64| (length / CELL).ceil() as usize + 1;
        let columns = cells(frame.width);
        Ink {
            frame,
            columns,
            inked: vec![f64::INFINITY; columns * cells(frame.height)],
            drawn: 0.0,
        }
    }

    /// The parts of `piece` with at least one segment that touches paper without ink.
    fn fresh(&mut self, piece: &[Point]) -> Vec<Vec<Point>> {
        let mut parts: Vec<Vec<Point>> = Vec::new();
        let mut joined = false;
        // Points closer than a fifth of a pixel add nothing but time.
        let mut from = match piece {
            [] => return parts,
            [only] => return vec![vec![*only]],
            [first, ..] => *first,
        };
        for (i, &to) in piece.iter().enumerate().skip(1) {
            let length = (to.0 - from.0).hypot(to.1 - from.1);
            if length < 0.2 && i + 1 < piece.len() {
                continue;
            }
            if self.touch(from, to, length) {
                match parts.last_mut() {
                    Some(part) if joined => part.push(to),
                    _ => parts.push(vec![from, to]),
                }
                joined = true;
            } else {
                joined = false;
            }
            from = to;
        }
        parts
    }

    /// Inks the segment and tells whether any of its cells was blank, or wet from the stretch of path just before.
    fn touch(&mut self, from: Point, to: Point, length: f64) -> bool {
        let steps = (length / (0.5 * CELL)).ceil().max(1.0);
        let mut fresh = false;
        for k in 0..=steps as usize {
            let t = k as f64 / steps;
            let (x, y) = (from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1));
            let (column, row) = ((x - self.frame.left) / CELL, (y - self.frame.top) / CELL);
            // `as` saturates: a point that rounding put just outside lands on the edge.
            if let Some(cell) = self.inked.get_mut(row as usize * self.columns + column as usize) {
                *cell = cell.min(self.drawn + t * length);
                fresh |= self.drawn + t * length - *cell < WET;
            }
        }
        self.drawn += length;
        fresh
    }
}

/// Leaves out the vertices closer than [`TOLERANCE`] to the line through their neighbours (Douglas and Peucker 1973).
fn simplify(piece: &[Point]) -> Vec<Point> {
    let mut keep = vec![false; piece.len()];
    let mut open = vec![(0, piece.len().saturating_sub(1))];
    while let Some((first, last)) = open.pop() {
        if let Some(end) = keep.get_mut(first) {
            *end = true;
        }
        if let Some(end) = keep.get_mut(last) {
            *end = true;
        }
        let distances =
            (first + 1..last).map(|i| (i, distance(piece[i], piece[first], piece[last])));
        if let Some((farthest, distance)) = distances.max_by(|a, b| a.1.total_cmp(&b.1))
            && distance > TOLERANCE
        {
            open.extend([(first, farthest), (farthest, last)]);
        }
    }
    piece.iter().zip(keep).filter_map(|(&point, keep)| keep.then_some(point)).collect()
}

/// From `p` to the segment `a b`.
fn distance(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let square = dx * dx + dy * dy;
    let t = if square > 0.0 {
        (((p.0 - a.0) * dx + (p.1 - a.1) * dy) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (p.0 - a.0 - t * dx).hypot(p.1 - a.1 - t * dy)
}

/// The strokes of a dashed line `width` px wide.
pub(super) fn dashes(piece: &[Point], dash: Dash, width: f64) -> Vec<Vec<Point>> {
    // Stroke and gap in line widths.
    let (stroke, gap) = match dash {
        Dash::Solid => return vec![piece.to_vec()],
        Dash::Dashed => (4.0, 2.2),
        Dash::Dotted => (1.1, 1.6),
    };
    let length: f64 =
        piece.windows(2).map(|pair| (pair[1].0 - pair[0].0).hypot(pair[1].1 - pair[0].1)).sum();
    let stretch = (length / ((stroke + gap) * width) / MOST_DASHES).max(1.0) * width;
    if !(stretch > 0.0) {
        return vec![piece.to_vec()];
    }
    let (mut strokes, mut current): (Vec<Vec<Point>>, Vec<Point>) =
        (Vec::new(), piece.first().copied().into_iter().collect());
    let (mut down, mut left) = (true, stroke * stretch);
    for pair in piece.windows(2) {
        let (mut from, to) = (pair[0], pair[1]);
        loop {
            let rest = (to.0 - from.0).hypot(to.1 - from.1);
            if rest <= left {
                left -= rest;
                if down {
                    current.push(to);
                }
                break;
            }
            from = (from.0 + (to.0 - from.0) * left / rest, from.1 + (to.1 - from.1) * left / rest);
            current.push(from);
            if down {
                strokes.push(std::mem::take(&mut current));
            }
            down = !down;
            left = stretch * if down { stroke } else { gap };
            if !down {
                current.clear();
            } else {
                current = vec![from];
            }
        }
    }
    if down && current.len() > 1 {
        strokes.push(current);
    }
    strokes
}

#[cfg(test)]
mod tests {
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
    fn dashes_cover_the_line_in_proportion() {
        let strokes = dashes(&[(0.0, 0.0), (30.0, 0.0), (62.0, 0.0)], Dash::Dashed, 1.0);
        assert_eq!(strokes.len(), 10);
        assert_eq!(strokes[4].len(), 2);
        let ink: f64 = strokes.iter().map(|s| s[s.len() - 1].0 - s[0].0).sum();
        assert!((ink - 40.0).abs() < 1e-9, "{ink}");
        let long = dashes(&[(0.0, 0.0), (1e6, 0.0)], Dash::Dotted, 1.0);
        assert!(long.len() <= MOST_DASHES as usize + 1);
    }
}
