//! A friction model behind a pointer.

use alloc::boxed::Box;
use core::fmt::Debug;

use super::{Affine, Characteristics, Form, HeldStep, Law, Limits, Linearised};
use crate::{Bristle, Scalar, Surface};

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
    ($($name:ident($($argument:ident: $type:ty),*) -> $answer:ty;)*) => {
        trait Erased<T>: Debug + Send + Sync {
            fn cloned(&self) -> Box<dyn Erased<T>>;
            $(fn $name(&self, $($argument: $type),*) -> $answer
            where
                T: Scalar;)*
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
        }
    };
}

erased! {
    affine(surface: Surface<T>, deflection: T) -> Affine<T>;
    affine_and_slopes(surface: Surface<T>, deflection: T) -> (Affine<T>, Affine<T>);
    stationary(surface: Surface<T>) -> T;
    stationary_coefficient(surface: Surface<T>) -> T;
    storage_stiffness() -> T;
    holding_coefficient(surface: Surface<T>, carried: T) -> T;
    form() -> Form;
    name() -> &'static str;
    obeys(law: Law) -> bool;
    limits(fastest: T) -> Limits<T>;
    characteristics(fastest: T) -> Option<Characteristics<T>>;
    linearised(surface: Surface<T>, deflection: T) -> Linearised<T>;
    steady_linearised(surface: Surface<T>) -> Linearised<T>;
    hold(surface: Surface<T>, deflection: T, duration: T) -> HeldStep<T>;
}

/// Calls the model behind the pointer; an `impl Into<Surface>` is one by then.
macro_rules! passed_on {
    ($($name:ident($($argument:ident: $type:ty),*) -> $answer:ty;)*) => {
        $(fn $name(&self, $($argument: $type),*) -> $answer {
            self.0.$name($($argument.into()),*)
        })*
    };
}

impl<T: Scalar> Bristle<T> for OwnModel<T> {
    type Deflection = T;

    passed_on! {
        affine(surface: Surface<T>, deflection: T) -> Affine<T>;
        affine_and_slopes(surface: Surface<T>, deflection: T) -> (Affine<T>, Affine<T>);
        stationary(surface: impl Into<Surface<T>>) -> T;
        stationary_coefficient(surface: impl Into<Surface<T>>) -> T;
        storage_stiffness() -> T;
        holding_coefficient(surface: Surface<T>, carried: T) -> T;
    form() -> Form;
        name() -> &'static str;
        obeys(law: Law) -> bool;
        limits(fastest: T) -> Limits<T>;
        characteristics(fastest: T) -> Option<Characteristics<T>>;
        linearised(surface: impl Into<Surface<T>>, deflection: T) -> Linearised<T>;
        steady_linearised(surface: impl Into<Surface<T>>) -> Linearised<T>;
        hold(surface: impl Into<Surface<T>>, deflection: T, duration: T) -> HeldStep<T>;
    }
}
