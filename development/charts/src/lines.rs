//! Lines cut to the frame and thinned: a hundred thousand points fit on a few hundred pixels.

/// A place in the plot area, in tenths of a pixel from its upper left corner.
pub(super) type Point = (f64, f64);

/// The pieces of a line that lie inside `size`, with the vertices that can be seen.
pub(super) fn pieces(
    points: impl Iterator<Item = Option<Point>>,
    size: Point,
) -> Vec<Vec<(i32, i32)>> {
    let mut pieces: Vec<Vec<Point>> = Vec::new();
    let mut before = None;
    for point in points {
        if let (Some(from), Some(to)) = (before, point)
            && let Some((a, b)) = clip(from, to, size)
        {
            match pieces.last_mut() {
                Some(piece) if piece.last() == Some(&a) && a == from => piece.push(b),
                _ => pieces.push(vec![a, b]),
            }
        }
        before = point;
    }
    let thin = |piece: Vec<Point>| {
        let rises = piece.is_sorted_by(|p, q| p.0 <= q.0);
        let piece = if rises { columns(&piece) } else { piece };
        let mut fine: Vec<_> = simplified(&piece)
            .into_iter()
            .map(|(x, y)| (x.round() as i32, y.round() as i32))
            .collect();
        fine.dedup();
        fine
    };
    pieces.into_iter().map(thin).collect()
}

/// The part of a segment inside the frame (Liang and Barsky 1984).
fn clip(from: Point, to: Point, size: Point) -> Option<(Point, Point)> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    let sides = [(-dx, from.0), (dx, size.0 - from.0), (-dy, from.1), (dy, size.1 - from.1)];
    for (speed, distance) in sides {
        if speed == 0.0 && distance < 0.0 {
            return None;
        } else if speed < 0.0 {
            enter = enter.max(distance / speed);
        } else if speed > 0.0 {
            leave = leave.min(distance / speed);
        }
    }
    let at = |t: f64| (from.0 + t * dx, from.1 + t * dy);
    let start = if enter == 0.0 { from } else { at(enter) };
    (enter <= leave).then(|| (start, if leave == 1.0 { to } else { at(leave) }))
}

/// For a line from left to right: of every pixel's column the first, lowest, highest and last
/// point.
fn columns(run: &[Point]) -> Vec<Point> {
    let mut kept = Vec::new();
    for column in run.chunk_by(|p, q| (0.1 * p.0).floor() == (0.1 * q.0).floor()) {
        let by_height = |&i: &usize, &j: &usize| column[i].1.total_cmp(&column[j].1);
        let low = (0..column.len()).min_by(by_height).unwrap_or(0);
        let high = (0..column.len()).max_by(by_height).unwrap_or(0);
        let mut indices = vec![0, low.min(high), low.max(high), column.len() - 1];
        indices.dedup();
        kept.extend(indices.into_iter().map(|i| column[i]));
    }
    kept
}

/// Leaves out vertices closer than a tenth of a pixel to the line without them (Douglas and
/// Peucker 1973).
fn simplified(piece: &[Point]) -> Vec<Point> {
    let last = piece.len() - 1;
    let mut keep = vec![false; piece.len()];
    (keep[0], keep[last]) = (true, true);
    let mut open = vec![(0, last)];
    while let Some((first, last)) = open.pop() {
        let off = (first + 1..last).map(|i| (i, distance(piece[i], piece[first], piece[last])));
        if let Some((farthest, distance)) = off.max_by(|a, b| a.1.total_cmp(&b.1))
            && distance > 1.0
        {
            keep[farthest] = true;
            open.extend([(first, farthest), (farthest, last)]);
        }
    }
    piece.iter().zip(keep).filter_map(|(&point, keep)| keep.then_some(point)).collect()
}

/// From `p` to the segment `a b`.
fn distance(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let square = dx * dx + dy * dy;
    let along = if square > 0.0 { ((p.0 - a.0) * dx + (p.1 - a.1) * dy) / square } else { 0.0 };
    let t = along.clamp(0.0, 1.0);
    (p.0 - a.0 - t * dx).hypot(p.1 - a.1 - t * dy)
}
