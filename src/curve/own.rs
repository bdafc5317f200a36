//! A friction curve behind a pointer.

use alloc::boxed::Box;
use core::fmt::Debug;

use super::FrictionCurve;
use crate::{Bounds, Scalar, Sliding};

own! {
    /// A curve of your own inside an [`AnyCurve`](super::AnyCurve), behind a pointer. Made by
    /// [`AnyCurve::own`](super::AnyCurve::own).
    OwnCurve: [FrictionCurve<T>] FrictionCurve {}
    {
        coefficient(sliding: Sliding<T>) -> T;
        coefficient_and_slope(sliding: Sliding<T>) -> (T, T);
        bounds(fastest: T) -> Bounds<T>;
        viscous_friction() -> T;
        slope_at_rest() -> T;
        least_slope() -> Option<T>;
        is_even() -> bool;
    }
    copies { with_less_viscous_friction(part); }
    surface {}
}
