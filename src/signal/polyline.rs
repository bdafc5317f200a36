//! Straight lines between given points: ramps, holds, trapezes.

use super::{Signal, first_between};
use crate::Scalar;
use crate::parameter::{self, ParameterError, Rule};

/// One corner of a [`Polyline`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex<T> {
    /// Time \[s\].
    pub time: T,
    /// Value at that time, in the unit of the signal.
    pub value: T,
}

/// Straight lines between N points, level before the first and after the last. For a signal that
/// jumps see [`Function`](super::Function).
///
/// ```
/// use bristle::signal::{Polyline, Signal, Vertex};
///
/// // A ramp from 0 to 100 % over 100 s, then held.
/// let ramp = Polyline::new([
///     Vertex { time: 0.0, value: 0.0 },
///     Vertex { time: 100.0, value: 100.0 },
/// ])?;
/// assert_eq!(ramp.value(25.0), 25.0);
/// assert_eq!(ramp.next_kink(10.0, 120.0), Some(100.0));
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Polyline<T, const N: usize> {
    vertices: [Vertex<T>; N],
}

impl<T: Scalar, const N: usize> Polyline<T, N> {
    /// A signal through the points.
    ///
    /// # Errors
    ///
    /// Names the point that is not finite or whose time does not increase; refuses an empty list.
    pub fn new(vertices: [Vertex<T>; N]) -> Result<Self, ParameterError> {
        if N == 0 {
            return Err(ParameterError {
                name: "vertices",
                component: None,
                value: 0.0,
                rule: Rule::Count { least: 1 },
            });
        }
        let mut previous: Option<Vertex<T>> = None;
        for (index, vertex) in vertices.iter().enumerate() {
            parameter::component(index, parameter::finite("time", vertex.time))?;
            parameter::component(index, parameter::finite("value", vertex.value))?;
            if let Some(before) = previous {
                let time = parameter::increasing("time", vertex.time, before.time);
                parameter::component(index, time)?;
                let slope = (vertex.value - before.value) / (vertex.time - before.time);
                parameter::component(index, parameter::finite("slope", slope))?;
            }
            previous = Some(*vertex);
        }
        Ok(Self { vertices })
    }
}

impl<T: Scalar, const N: usize> Signal<T> for Polyline<T, N> {
    #[inline]
    fn value(&self, time: T) -> T {
        self.value_and_rate(time).0
    }

    fn value_and_rate(&self, time: T) -> (T, T) {
        let after = self.vertices.partition_point(|vertex| vertex.time <= time);
        match (after.checked_sub(1).and_then(|i| self.vertices.get(i)), self.vertices.get(after)) {
            (Some(a), Some(b)) => {
                let rate = (b.value - a.value) / (b.time - a.time);
                (a.value + rate * (time - a.time), rate)
            }
            (Some(only), None) | (None, Some(only)) => (only.value, T::zero()),
            (None, None) => (T::zero(), T::zero()),
        }
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        first_between(self.vertices.iter().map(|vertex| vertex.time), time, towards)
    }
}
