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
        impl<T> From<$held> for $any<T> {
            fn from(held: $held) -> Self {
                Self::$variant(held)
            }
        })*
    };
}
