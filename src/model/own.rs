//! A friction model behind a pointer.

use alloc::boxed::Box;
use core::fmt::Debug;

use super::{Affine, Characteristics, Form, HeldStep, Law, Limits, Linearised};
use crate::{Bristle, LoadChange, Scalar, Surface};

/// A model of one deflection behind a pointer, from [`AnyBristle::own`](crate::AnyBristle::own).
#[derive(Debug)]
pub struct OwnModel<T>(Box<dyn Erased<T>>);

impl<T: Scalar> OwnModel<T> {
    pub(super) fn new(model: impl Bristle<T, Deflection = T> + Send + Sync + 'static) -> Self {
        Self(Box::new(model))
    }
}

impl<T> Clone for OwnModel<T> {
    fn clone(&self) -> Self {
        Self(self.0.cloned())
    }
}

/// Declares [`Bristle`] as a trait object, and passes every method to it and back.
macro_rules! erased {
    (
        { $($name:ident($($argument:ident: $type:ty),*) -> $answer:ty;)* }
        surface { $($at:ident($($number:ident),*) -> $found:ty;)* }
    ) => {
        trait Erased<T>: Debug + Send + Sync {
            fn cloned(&self) -> Box<dyn Erased<T>>;
            $(fn $name(&self, $($argument: $type),*) -> $answer where T: Scalar;)*
            $(fn $at(&self, surface: Surface<T>, $($number: T),*) -> $found where T: Scalar;)*
        }

        impl<T: Scalar, M> Erased<T> for M
        where
            M: Bristle<T, Deflection = T> + Send + Sync + 'static,
        {
            fn cloned(&self) -> Box<dyn Erased<T>> {
                Box::new(self.clone())
            }

            $(fn $name(&self, $($argument: $type),*) -> $answer {
                Bristle::$name(self, $($argument),*)
            })*

            $(fn $at(&self, surface: Surface<T>, $($number: T),*) -> $found {
                Bristle::$at(self, surface, $($number),*)
            })*
        }

        impl<T: Scalar> Bristle<T> for OwnModel<T> {
            type Deflection = T;

            $(fn $name(&self, $($argument: $type),*) -> $answer {
                self.0.$name($($argument),*)
            })*

            $(fn $at(&self, surface: impl Into<Surface<T>>, $($number: T),*) -> $found {
                self.0.$at(surface.into(), $($number),*)
            })*
        }
    };
}

erased! {
    {
        affine(surface: Surface<T>, deflection: T) -> Affine<T>;
        affine_and_slopes(surface: Surface<T>, deflection: T) -> (Affine<T>, Affine<T>);
        storage_stiffness() -> T;
        folding_scale() -> Option<T>;
        holding_coefficient(surface: Surface<T>, carried: T) -> T;
        held(change: LoadChange<T>, surface: Surface<T>, deflection: T) -> T;
        form() -> Form;
        name() -> &'static str;
        obeys(law: Law) -> bool;
        limits(fastest: T) -> Limits<T>;
        characteristics(fastest: T) -> Option<Characteristics<T>>;
    }
    surface {
        stationary() -> T;
        stationary_coefficient() -> T;
        linearised(deflection) -> Linearised<T>;
        steady_linearised() -> Linearised<T>;
        hold(deflection, duration) -> HeldStep<T>;
    }
}
