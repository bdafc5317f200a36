//! A friction model behind a pointer.

use alloc::boxed::Box;
use core::fmt::Debug;

use super::{Affine, Characteristics, Form, HeldStep, Law, Limits, Linearised};
use crate::{Bristle, LoadChange, Scalar, Surface};

own! {
    /// A model of your own, of one deflection, behind a pointer. [`AnyBristle::own`] makes it, and
    /// you meet its name only where you match on an [`AnyBristle`]: call its methods as those of
    /// any [`Bristle`]. It is for a choice at run time between your model and those of this crate;
    /// if the type of your model is known, use that type, which costs no call through a pointer.
    ///
    /// [`AnyBristle`]: crate::AnyBristle
    /// [`AnyBristle::own`]: crate::AnyBristle::own
    OwnModel: [Bristle<T, Deflection = T>] Bristle { type Deflection = T; }
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
    copies {}
    surface {
        stationary() -> T;
        stationary_coefficient() -> T;
        linearised(deflection) -> Linearised<T>;
        steady_linearised() -> Linearised<T>;
        hold(deflection, duration) -> HeldStep<T>;
    }
}
