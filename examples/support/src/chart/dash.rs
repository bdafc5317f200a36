//! Dashed and dotted lines. The SVG backend draws solid ones only, so each dash is a line of its own.

use super::path::Point;
use super::style::Dash;

/// Most dashes of one series, for the size of the file.
const MOST: f64 = 1200.0;

/// A series that needs more dashes gets longer ones, up to this factor. A line longer still fills its panel: it is drawn
/// solid, since stretched dashes would show stripes that the data do not have.
const MOST_STRETCH: f64 = 2.5;

/// The dashes of the pieces of a line `width` px wide.
pub(super) fn dashes(pieces: &[Vec<Point>], dash: Dash, width: f64) -> Vec<Vec<Point>> {
    // Stroke and gap in line widths.
    let (stroke, gap) = match dash {
        Dash::Solid => return pieces.to_vec(),
        Dash::Dashed => (4.0, 2.2),
        Dash::Dotted => (1.1, 1.6),
    };
    let length: f64 = pieces
        .iter()
        .flat_map(|piece| piece.windows(2))
        .map(|pair| distance(pair[0], pair[1]))
        .sum();
    let stretch = (length / ((stroke + gap) * width) / MOST).max(1.0);
    if width > 0.0 && stretch <= MOST_STRETCH {
        let unit = stretch * width;
        pieces.iter().flat_map(|piece| cut(piece, stroke * unit, gap * unit)).collect()
    } else {
        pieces.to_vec()
    }
}

/// Cuts a line into strokes of the given length with gaps between them.
fn cut(piece: &[Point], stroke: f64, gap: f64) -> Vec<Vec<Point>> {
    let mut strokes = Vec::new();
    let mut current: Vec<Point> = piece.first().copied().into_iter().collect();
    let (mut down, mut left) = (true, stroke);
    for pair in piece.windows(2) {
        let (mut from, to) = (pair[0], pair[1]);
        let mut rest = distance(from, to);
        while rest > left {
            from = (from.0 + (to.0 - from.0) * left / rest, from.1 + (to.1 - from.1) * left / rest);
            rest -= left;
            current.push(from);
            if down {
                strokes.push(std::mem::take(&mut current));
            } else {
                current = vec![from];
            }
            down = !down;
            left = if down { stroke } else { gap };
        }
        left -= rest;
        if down {
            current.push(to);
        }
    }
    if down {
        strokes.push(current);
    }
    strokes
}

fn distance(p: Point, q: Point) -> f64 {
    (q.0 - p.0).hypot(q.1 - p.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_cover_the_line_in_proportion() {
        let strokes = dashes(&[vec![(0.0, 0.0), (30.0, 0.0), (61.0, 0.0)]], Dash::Dashed, 1.0);
        assert_eq!(strokes.len(), 10);
        let ink: f64 = strokes.iter().map(|s| s[s.len() - 1].0 - s[0].0).sum();
        assert!((ink - 40.0).abs() < 1e-9, "{ink}");
    }

    #[test]
    fn a_line_without_end_is_not_dashed_without_end() {
        for length in [1e3, 1e4, 1e6, 1e9] {
            let strokes = dashes(&[vec![(0.0, 0.0), (length, 0.0)]], Dash::Dotted, 1.5);
            assert!(strokes.len() <= MOST as usize + 1, "{length}");
        }
    }
}
