//! What an enum passes on to the variant that it is.

/// Methods of a trait, each by the macro that matches the variants.
macro_rules! passed_on {
    ($each:ident: $(
        $(#[$attribute:meta])*
        $name:ident($($argument:ident: $type:ty),*) -> $answer:ty;
    )*) => {
        $($(#[$attribute])*
        fn $name(&self, $($argument: $type),*) -> $answer {
            $each!(self, variant => variant.$name($($argument),*))
        })*
    };
}

/// Variants from what they hold.
macro_rules! holds {
    ($any:ident: $($(#[$attribute:meta])* $variant:ident($held:ty))*) => {
        $($(#[$attribute])*
        impl<T: Scalar> From<$held> for $any<T> {
            fn from(held: $held) -> Self {
                Self::$variant(held)
            }
        })*
    };
}

/// A user's own type behind a pointer: its trait as an object, and every method to it and back.
///
/// What `copies` names returns the type itself; what `surface` names takes whatever becomes one.
#[cfg(feature = "alloc")]
macro_rules! own {
    (
        $(#[$attribute:meta])*
        $own:ident: [$($bound:tt)*] $trait:ident { $($type_of:tt)* }
        { $($name:ident($($argument:ident: $type:ty),*) -> $answer:ty;)* }
        copies { $($copy:ident($part:ident);)* }
        surface { $($at:ident($($number:ident),*) -> $found:ty;)* }
    ) => {
        $(#[$attribute])*
        #[derive(Debug)]
        pub struct $own<T: Scalar>(Box<dyn Erased<T>>);

        impl<T: Scalar> $own<T> {
            pub(super) fn new(own: impl $($bound)* + Send + Sync + 'static) -> Self {
                Self(Box::new(own))
            }
        }

        impl<T: Scalar> Clone for $own<T> {
            fn clone(&self) -> Self {
                Self(self.0.cloned())
            }
        }

        trait Erased<T: Scalar>: Debug + Send + Sync {
            fn cloned(&self) -> Box<dyn Erased<T>>;
            $(fn $copy(&self, $part: T) -> Box<dyn Erased<T>>;)*
            $(fn $name(&self, $($argument: $type),*) -> $answer;)*
            $(fn $at(&self, surface: Surface<T>, $($number: T),*) -> $found;)*
        }

        impl<T: Scalar, M: $($bound)* + Send + Sync + 'static> Erased<T> for M {
            fn cloned(&self) -> Box<dyn Erased<T>> {
                Box::new(self.clone())
            }

            $(fn $copy(&self, $part: T) -> Box<dyn Erased<T>> {
                Box::new($trait::$copy(self, $part))
            })*

            $(fn $name(&self, $($argument: $type),*) -> $answer {
                $trait::$name(self, $($argument),*)
            })*

            $(fn $at(&self, surface: Surface<T>, $($number: T),*) -> $found {
                $trait::$at(self, surface, $($number),*)
            })*
        }

        impl<T: Scalar> $trait<T> for $own<T> {
            $($type_of)*

            $(fn $copy(&self, $part: T) -> Self {
                Self(self.0.$copy($part))
            })*

            $(fn $name(&self, $($argument: $type),*) -> $answer {
                self.0.$name($($argument),*)
            })*

            $(fn $at(&self, surface: impl Into<Surface<T>>, $($number: T),*) -> $found {
                self.0.$at(surface.into(), $($number),*)
            })*
        }
    };
}
