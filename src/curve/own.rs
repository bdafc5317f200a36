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

/// Declares [`FrictionCurve`] as a trait object, and passes every method to it and back.
macro_rules! erased {
    ($($name:ident($($argument:ident: $type:ty),*) -> $answer:ty;)*) => {
        trait Erased<T>: Debug + Send + Sync {
            fn cloned(&self) -> Box<dyn Erased<T>>;
            fn with_less(&self, part: T) -> Box<dyn Erased<T>>;
            $(fn $name(&self, $($argument: $type),*) -> $answer;)*
        }

        impl<T: Scalar, C: FrictionCurve<T> + Send + Sync + 'static> Erased<T> for C {
            fn cloned(&self) -> Box<dyn Erased<T>> {
                Box::new(self.clone())
            }

            fn with_less(&self, part: T) -> Box<dyn Erased<T>> {
                Box::new(self.with_less_viscous_friction(part))
            }

            $(fn $name(&self, $($argument: $type),*) -> $answer {
                FrictionCurve::$name(self, $($argument),*)
            })*
        }

        impl<T: Scalar> FrictionCurve<T> for OwnCurve<T> {
            fn with_less_viscous_friction(&self, part: T) -> Self {
                Self(self.0.with_less(part))
            }

            $(fn $name(&self, $($argument: $type),*) -> $answer {
                self.0.$name($($argument),*)
            })*
        }
    };
}

erased! {
    coefficient(sliding: Sliding<T>) -> T;
    coefficient_and_slope(sliding: Sliding<T>) -> (T, T);
    bounds(fastest: T) -> Bounds<T>;
    viscous_friction() -> T;
    slope_at_rest() -> T;
    least_slope() -> Option<T>;
    is_even() -> bool;
}
