//! Names of reference lines, put where they cover the least.

use super::layout::{Frame, SMALL};
use super::path::Point;
use super::text::width;

/// From the reference line and the frame to the label / px.
const GAP: f64 = 3.0;
/// Height of a label / px.
const HEIGHT: f64 = 13.0;

/// The place of a label beside the reference line from `from` to `to`: of the places along both of its sides the one
/// that covers the least of `taken` (points about a pixel apart). Among equals the one nearest to the line's end wins.
pub(super) fn beside(label: &str, from: Point, to: Point, frame: &Frame, taken: &[Point]) -> Frame {
    let (width, height) = (width(label, SMALL) + 4.0, HEIGHT);
    let at = |left: f64, top: f64| Frame { left, top, width, height };
    let horizontal = from.1 == to.1;
    let along = |t: f64, free: f64| GAP + t * (free - 2.0 * GAP).max(0.0);
    let places = (0..=40).map(|step| f64::from(step) / 40.0).flat_map(|t| {
        if horizontal {
            let left = frame.right() - width - along(t, frame.width - width);
            [at(left, from.1 - GAP - height), at(left, from.1 + GAP)]
        } else {
            let top = frame.top + along(t, frame.height - height);
            [at(from.0 + GAP, top), at(from.0 - GAP - width, top)]
        }
    });
    let inside = |place: &Frame| {
        frame.contains((place.left, place.top)) && frame.contains((place.right(), place.bottom()))
    };
    let covers = |place: &Frame| taken.iter().filter(|&&point| place.contains(point)).count();
    places
        .filter(inside)
        .min_by_key(covers)
        .unwrap_or_else(|| at(frame.left + GAP, frame.top + GAP))
}

/// Points about a pixel apart along a line.
pub(super) fn along(line: &[Point]) -> impl Iterator<Item = Point> {
    line.windows(2).flat_map(|pair| {
        let (p, q) = (pair[0], pair[1]);
        let steps = (q.0 - p.0).hypot(q.1 - p.1).ceil().max(1.0);
        (0..=steps as u32).map(move |k| {
            let t = f64::from(k) / steps;
            (p.0 + t * (q.0 - p.0), p.1 + t * (q.1 - p.1))
        })
    })
}

/// Points about four pixels apart all over a label, so that the next label avoids it.
pub(super) fn all_over(place: &Frame) -> impl Iterator<Item = Point> {
    let (left, top) = (place.left, place.top);
    let (columns, rows) = ((place.width / 4.0).ceil() as u32, (place.height / 4.0).ceil() as u32);
    (0..=columns).flat_map(move |i| {
        (0..=rows).map(move |k| (left + 4.0 * f64::from(i), top + 4.0 * f64::from(k)))
    })
}
