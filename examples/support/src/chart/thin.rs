//! Leaving out what would not be seen: a hundred thousand points fit on a few hundred pixels.

use super::layout::Frame;
use super::path::Point;

/// A vertex may be left out if the line stays this close to it / px; a twentieth of a line's width.
const TOLERANCE: f64 = 0.08;

/// Side of the cells by which ink is remembered / px; a quarter of a line's width.
const CELL: f64 = 0.4;

/// Path length after which ink is dry: a line that returns to it is not drawn again / px.
const WET: f64 = 4.0 * CELL;

/// For a line that runs from left to right: of every column one pixel wide, the first, lowest, highest and last point; of
/// a column that the line crosses up and down several times, an upright stroke in its middle.
pub(super) fn columns(run: &[Point]) -> Vec<Point> {
    let mut kept = Vec::new();
    for column in run.chunk_by(|p, q| p.0.floor() == q.0.floor()) {
        let by_height = |&i: &usize, &j: &usize| column[i].1.total_cmp(&column[j].1);
        let low = (0..column.len()).min_by(by_height).unwrap_or(0);
        let high = (0..column.len()).max_by(by_height).unwrap_or(0);
        let travelled: f64 = column.windows(2).map(|pair| (pair[1].1 - pair[0].1).abs()).sum();
        let (from, to) = (low.min(high), low.max(high));
        if travelled > 3.0 * (column[high].1 - column[low].1) {
            // Slanted strokes from extreme to extreme would leave white wedges between the columns.
            let middle = 0.5 * (column[0].0 + column[column.len() - 1].0);
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
pub(super) struct Ink<'a> {
    frame: &'a Frame,
    columns: usize,
    /// The length of path drawn when the cell took its ink; blank cells will never.
    inked: Vec<f64>,
    drawn: f64,
}

impl Ink<'_> {
    pub(super) fn new(frame: &Frame) -> Ink<'_> {
        let cells = |length: f64| (length / CELL).ceil() as usize + 1;
        let columns = cells(frame.width);
        Ink {
            frame,
            columns,
            inked: vec![f64::INFINITY; columns * cells(frame.height)],
            drawn: 0.0,
        }
    }

    /// The parts of `piece` made of segments that touch paper without ink.
    pub(super) fn fresh(&mut self, piece: &[Point]) -> Vec<Vec<Point>> {
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

    /// Inks the segment and tells whether any of it lies more than a cell away from dry ink. Ink is wet, and does not
    /// count, for the stretch of path just before.
    fn touch(&mut self, from: Point, to: Point, length: f64) -> bool {
        let steps = (length / (0.5 * CELL)).ceil().max(1.0);
        let mut fresh = false;
        for k in 0..=steps as usize {
            let t = k as f64 / steps;
            let (x, y) = (from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1));
            let (column, row) = ((x - self.frame.left) / CELL, (y - self.frame.top) / CELL);
            // `as` saturates: a point that rounding put just outside lands on the edge.
            let cell = row as usize * self.columns + column as usize;
            let now = self.drawn + t * length;
            let around = [
                Some(cell),
                cell.checked_sub(1),
                Some(cell + 1),
                cell.checked_sub(self.columns),
                Some(cell + self.columns),
            ];
            let dry = |inked: &f64| now - inked > WET;
            fresh |= !around.into_iter().flatten().filter_map(|cell| self.inked.get(cell)).any(dry);
            if let Some(inked) = self.inked.get_mut(cell) {
                *inked = inked.min(now);
            }
        }
        self.drawn += length;
        fresh
    }
}

/// Leaves out the vertices closer than [`TOLERANCE`] to the line through their neighbours (Douglas and Peucker 1973).
pub(super) fn simplify(piece: &[Point]) -> Vec<Point> {
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
pub(super) fn distance(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let square = dx * dx + dy * dy;
    let t = if square > 0.0 {
        (((p.0 - a.0) * dx + (p.1 - a.1) * dy) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (p.0 - a.0 - t * dx).hypot(p.1 - a.1 - t * dy)
}
