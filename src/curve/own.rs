//! A friction curve behind a pointer.

use alloc::boxed::Box;
use core::fmt::Debug;

use super::FrictionCurve;
use crate::{Bounds, Scalar, Sliding};

/// A curve of any type behind a pointer, from [`AnyCurve::own`](super::AnyCurve::own).
#[derive(Debug)]
pub struct OwnCurve<T>(Box<dyn Erased<T>>);

impl<T: Scalar> OwnCurve<T> {
    pub(super) fn new(curve: impl FrictionCurve<T> + Send + Sync + 'static) -> Self {
        Self(Box::new(curve))
    }
}

impl<T> Clone for OwnCurve<T> {
    fn clone(&self) -> Self {
        Self(self.0.cloned())
    }
}

/// [`FrictionCurve`] as a trait object: what returns a curve returns a boxed one.
trait Erased<T>: Debug + Send + Sync {
    fn cloned(&self) -> Box<dyn Erased<T>>;
    fn with_less(&self, part: T) -> Box<dyn Erased<T>>;
    fn coefficient(&self, sliding: Sliding<T>) -> T;
    fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T);
    fn bounds(&self, fastest: T) -> Bounds<T>;
    fn viscous_friction(&self) -> T;
    fn slope_at_rest(&self) -> T;
    fn least_slope(&self) -> Option<T>;
    fn is_even(&self) -> bool;
}

impl<T: Scalar, C: FrictionCurve<T> + Send + Sync + 'static> Erased<T> for C {
    fn cloned(&self) -> Box<dyn Erased<T>> {
        Box::new(self.clone())
    }

    fn with_less(&self, part: T) -> Box<dyn Erased<T>> {
        Box::new(self.with_less_viscous_friction(part))
    }

    fn coefficient(&self, sliding: Sliding<T>) -> T {
        FrictionCurve::coefficient(self, sliding)
    }

    fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        FrictionCurve::coefficient_and_slope(self, sliding)
    }

    fn bounds(&self, fastest: T) -> Bounds<T> {
        FrictionCurve::bounds(self, fastest)
    }

    fn viscous_friction(&self) -> T {
        FrictionCurve::viscous_friction(self)
    }

    fn slope_at_rest(&self) -> T {
        FrictionCurve::slope_at_rest(self)
    }

    fn least_slope(&self) -> Option<T> {
        FrictionCurve::least_slope(self)
    }

    fn is_even(&self) -> bool {
        FrictionCurve::is_even(self)
    }
}

impl<T: Scalar> FrictionCurve<T> for OwnCurve<T> {
    fn coefficient(&self, sliding: Sliding<T>) -> T {
        self.0.coefficient(sliding)
    }

    fn coefficient_and_slope(&self, sliding: Sliding<T>) -> (T, T) {
        self.0.coefficient_and_slope(sliding)
    }

    fn bounds(&self, fastest: T) -> Bounds<T> {
        self.0.bounds(fastest)
    }

    fn viscous_friction(&self) -> T {
        self.0.viscous_friction()
    }

    fn with_less_viscous_friction(&self, part: T) -> Self {
        Self(self.0.with_less(part))
    }

    fn slope_at_rest(&self) -> T {
        self.0.slope_at_rest()
    }

    fn least_slope(&self) -> Option<T> {
        self.0.least_slope()
    }

    fn is_even(&self) -> bool {
        self.0.is_even()
    }
}
