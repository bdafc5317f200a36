//! What happens while nothing moves.
//!
//! A step over which hardly a state moves has hardly an error to estimate, and the next one is
//! longer. A force or a load that acts within it falls between the stages. So such a step is looked
//! into: the span has a thousand pieces, and each piece that the step covers is asked for its rates at one
//! time, at the state where the step begins. What differs from the rates there is the work of time
//! alone, however stiff the system is. The times are spread by the golden ratio, so that no period
//! falls between them.

use nalgebra::SVector;

use super::System;
use super::integration::Integration;
use super::locked::Interval;
use super::stepper::{Field, Method, Point};
use crate::Scalar;
use crate::scalar::{lit, to_f64};

/// Pieces of a span.
const PIECES: f64 = 1000.0;

/// The part of a piece between the times in two neighbouring ones: 1/φ.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// A step that moves a state by more tolerances is not looked into.
const HARDLY: f64 = 100.0;

impl<T: Scalar, S: System<T, N, K>, M: Method<T, N>, const N: usize, const K: usize>
    Integration<'_, T, S, M, N, K>
{
    /// Answers with a shorter step where what time changes in the rates would within one piece move
    /// a state by its tolerance, and by more than the whole step does.
    #[inline]
    pub(super) fn unseen(&mut self, end: &Point<T, N>, interval: Interval<T>) -> Option<T> {
        let step = end.time - self.point.time;
        let count = to_f64(step / self.progress.span()) * PIECES;
        if count < 1.0 {
            return None;
        }
        let size = |change: &SVector<T, N>| to_f64(change.component_div(&end.scale).amax());
        let moved = size(&(end.state - self.point.state));
        if !(moved < HARDLY) {
            return None;
        }
        let (_, mut field, from) = self.parts(interval);
        let (piece, mut within) = (step * lit(1.0 / count), 0.5);
        for number in 0..count as u32 {
            let before = f64::from(number);
            let time = from.time + piece * lit(before + within);
            let change = field.rate(time, &from.state) - from.rate;
            if !(size(&(change * piece)) <= moved.max(1.0)) {
                return Some(piece * lit(before.max(0.5)));
            }
            within = (within + GOLDEN) % 1.0;
        }
        None
    }
}
