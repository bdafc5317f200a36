//! Straight lines between given points: ramps, holds, trapezes.

use core::fmt::Debug;

use super::Signal;
use crate::Scalar;
use crate::parameter::{Checked, Named, ParameterError};

/// One corner of a [`Polyline`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Vertex<T> {
    /// Time \[s\].
    pub time: T,
    /// Value at that time, in the unit of the signal.
    pub value: T,
}

/// Straight lines between points, constant before the first and after the last.
///
/// The points are an array, a slice, a `Vec` or any other storage `S`. For a signal that jumps see
/// [`Function`](super::Function).
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
pub struct Polyline<S> {
    vertices: S,
}

impl<S> Polyline<S> {
    /// A signal through the points.
    ///
    /// # Errors
    ///
    /// Names the point that is not finite or whose time does not increase; refuses an empty list.
    pub fn new<T: Scalar>(vertices: S) -> Checked<Self>
    where
        S: AsRef<[Vertex<T>]>,
    {
        Named("vertices", vertices.as_ref().len()).count(1)?;
        let mut previous: Option<Vertex<T>> = None;
        ParameterError::of_components(vertices.as_ref(), |vertex| {
            Named("time", vertex.time).finite()?;
            Named("value", vertex.value).finite()?;
            let Some(before) = previous.replace(*vertex) else { return Ok(vertex.time) };
            let interval = Named("time", vertex.time).increasing(before.time)? - before.time;
            Named("slope", (vertex.value - before.value) / interval).finite()
        })?;
        Ok(Self { vertices })
    }

    /// The points.
    pub fn vertices(&self) -> &S {
        &self.vertices
    }
}

impl<T: Scalar, S: AsRef<[Vertex<T>]> + Debug + Clone> Signal<T> for Polyline<S> {
    fn value_and_rate(&self, time: T) -> (T, T) {
        let vertices = self.vertices.as_ref();
        let after = vertices.partition_point(|vertex| vertex.time <= time);
        match (after.checked_sub(1).and_then(|i| vertices.get(i)), vertices.get(after)) {
            (Some(a), Some(b)) => {
                let rate = (b.value - a.value) / (b.time - a.time);
                (a.value + rate * (time - a.time), rate)
            }
            (Some(only), None) | (None, Some(only)) => (only.value, T::zero()),
            (None, None) => (T::zero(), T::zero()),
        }
    }

    fn next_kink(&self, time: T, towards: T) -> Option<T> {
        let vertices = self.vertices.as_ref();
        let after = vertices.partition_point(|vertex| vertex.time <= time);
        vertices.get(after).map(|vertex| vertex.time).filter(|&kink| kink > time && kink < towards)
    }
}
