//! A number that counts what is done with it.

use std::cell::Cell;
use std::fmt;
use std::ops::{
    Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign,
};

use approx::{AbsDiffEq, RelativeEq, UlpsEq};
use nalgebra::{ComplexField, Field, RealField, SimdValue};
use num_traits::{FromPrimitive, Num, One, Signed, Zero};
use simba::scalar::SubsetOf;

/// How often each operation was done. A change of sign, a comparison and a modulus cost a cycle or
/// nothing, and are not counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Additions and subtractions.
    pub add: u32,
    pub mul: u32,
    pub div: u32,
    pub sqrt: u32,
    /// e^x, and e^x − 1.
    pub exp: u32,
    /// x^y.
    pub pow: u32,
    /// Everything else: logarithms, circular and hyperbolic functions.
    pub other: u32,
}

thread_local! {
    static COUNTS: Cell<Counts> = const {
        Cell::new(Counts { add: 0, mul: 0, div: 0, sqrt: 0, exp: 0, pow: 0, other: 0 })
    };
}

/// What some work does.
pub fn counts<R>(work: impl FnOnce() -> R) -> Counts {
    COUNTS.set(Counts::default());
    std::hint::black_box(work());
    COUNTS.get()
}

fn count(what: impl FnOnce(&mut Counts)) {
    let mut counts = COUNTS.get();
    what(&mut counts);
    COUNTS.set(counts);
}

/// A double-precision number whose operations are counted.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Counted(pub f64);

impl fmt::Display for Counted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident $assign:ident $assign_method:ident $field:ident;)*) => {$(
        impl $operator for Counted {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                count(|counts| counts.$field += 1);
                Self(self.0.$method(other.0))
            }
        }

        impl $assign for Counted {
            fn $assign_method(&mut self, other: Self) {
                *self = self.$method(other);
            }
        }
    )*};
}

operators! {
    Add add AddAssign add_assign add;
    Sub sub SubAssign sub_assign add;
    Mul mul MulAssign mul_assign mul;
    Div div DivAssign div_assign div;
    Rem rem RemAssign rem_assign other;
}

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Zero for Counted {
    fn zero() -> Self {
        Self(0.0)
    }
    fn is_zero(&self) -> bool {
        self.0 == 0.0
    }
}

impl One for Counted {
    fn one() -> Self {
        Self(1.0)
    }
}

impl Num for Counted {
    type FromStrRadixErr = <f64 as Num>::FromStrRadixErr;
    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        f64::from_str_radix(text, radix).map(Self)
    }
}

impl Signed for Counted {
    fn abs(&self) -> Self {
        Self(self.0.abs())
    }
    fn abs_sub(&self, other: &Self) -> Self {
        Self((self.0 - other.0).max(0.0))
    }
    fn signum(&self) -> Self {
        Self(self.0.signum())
    }
    fn is_positive(&self) -> bool {
        self.0 > 0.0
    }
    fn is_negative(&self) -> bool {
        self.0 < 0.0
    }
}

impl FromPrimitive for Counted {
    fn from_i64(n: i64) -> Option<Self> {
        Some(Self(n as f64))
    }
    fn from_u64(n: u64) -> Option<Self> {
        Some(Self(n as f64))
    }
    fn from_f64(n: f64) -> Option<Self> {
        Some(Self(n))
    }
}

macro_rules! subsets {
    ($($type:ty, |$wide:ident| $to:expr, |$narrow:ident| $from:expr;)*) => {$(
        impl SubsetOf<Counted> for $type {
            fn to_superset(&self) -> Counted {
                let $wide = *self;
                $to
            }
            fn from_superset_unchecked($narrow: &Counted) -> Self {
                $from
            }
            fn is_in_subset(_: &Counted) -> bool {
                true
            }
        }
    )*};
}

subsets! {
    Counted, |value| value, |value| *value;
    f64, |value| Counted(value), |value| value.0;
    f32, |value| Counted(f64::from(value)), |value| value.0 as f32;
}

impl AbsDiffEq for Counted {
    type Epsilon = Self;
    fn default_epsilon() -> Self {
        Self(f64::EPSILON)
    }
    fn abs_diff_eq(&self, other: &Self, epsilon: Self) -> bool {
        self.0.abs_diff_eq(&other.0, epsilon.0)
    }
}

impl RelativeEq for Counted {
    fn default_max_relative() -> Self {
        Self(f64::EPSILON)
    }
    fn relative_eq(&self, other: &Self, epsilon: Self, max_relative: Self) -> bool {
        self.0.relative_eq(&other.0, epsilon.0, max_relative.0)
    }
}

impl UlpsEq for Counted {
    fn default_max_ulps() -> u32 {
        4
    }
    fn ulps_eq(&self, other: &Self, epsilon: Self, max_ulps: u32) -> bool {
        self.0.ulps_eq(&other.0, epsilon.0, max_ulps)
    }
}

impl Field for Counted {}

#[allow(unsafe_code, reason = "two methods of the trait are declared so")]
impl SimdValue for Counted {
    const LANES: usize = 1;
    type Element = Self;
    type SimdBool = bool;
    fn splat(value: Self) -> Self {
        value
    }
    fn extract(&self, _: usize) -> Self {
        *self
    }
    unsafe fn extract_unchecked(&self, _: usize) -> Self {
        *self
    }
    fn replace(&mut self, _: usize, value: Self) {
        *self = value;
    }
    unsafe fn replace_unchecked(&mut self, _: usize, value: Self) {
        *self = value;
    }
    fn select(self, condition: bool, other: Self) -> Self {
        if condition { self } else { other }
    }
}

macro_rules! functions {
    ($($field:ident: $($method:ident)*;)*) => {$($(
        fn $method(self) -> Self {
            count(|counts| counts.$field += 1);
            Self(self.0.$method())
        }
    )*)*};
}

/// What is not counted.
macro_rules! free {
    ($($method:ident($($argument:ident),*))*) => {$(
        fn $method(self $(, $argument: Self)*) -> Self {
            Self(self.0.$method($($argument.0),*))
        }
    )*};
}

/// Written in terms of others.
macro_rules! by_others {
    ($(|$this:ident $(, $argument:ident)*| $method:ident = $value:expr;)*) => {$(
        fn $method(self $(, $argument: Self)*) -> Self {
            let $this = self;
            $value
        }
    )*};
}

impl ComplexField for Counted {
    type RealField = Self;

    functions! {
        sqrt: sqrt;
        exp: exp exp2 exp_m1;
        div: recip;
        other: floor ceil round trunc fract sin cos tan asin acos atan sinh cosh tanh asinh acosh
            atanh log2 log10 ln ln_1p cbrt;
    }
    free! { abs() }
    by_others! {
        |x| real = x;
        |_x| imaginary = Self(0.0);
        |x| modulus = Self(x.0.abs());
        |x| modulus_squared = x * x;
        |x| argument = Self(if x.0 >= 0.0 { 0.0 } else { std::f64::consts::PI });
        |x| norm1 = Self(x.0.abs());
        |x, factor| scale = x * factor;
        |x, factor| unscale = x / factor;
        |x, a, b| mul_add = x * a + b;
        |x, other| hypot = (x * x + other * other).sqrt();
        |x| conjugate = x;
        |x, base| log = x.ln() / base.ln();
        |x, n| powc = x.powf(n);
    }

    fn from_real(re: Self) -> Self {
        re
    }
    fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }
    fn powi(self, n: i32) -> Self {
        count(|counts| counts.pow += 1);
        Self(self.0.powi(n))
    }
    fn powf(self, n: Self) -> Self {
        count(|counts| counts.pow += 1);
        Self(self.0.powf(n.0))
    }
    fn is_finite(&self) -> bool {
        self.0.is_finite()
    }
    fn try_sqrt(self) -> Option<Self> {
        (self.0 >= 0.0).then(|| self.sqrt())
    }
}

macro_rules! constants {
    ($($method:ident $constant:ident;)*) => {$(
        fn $method() -> Self {
            Self(std::f64::consts::$constant)
        }
    )*};
}

impl RealField for Counted {
    constants! {
        pi PI;
        two_pi TAU;
        frac_pi_2 FRAC_PI_2;
        frac_pi_3 FRAC_PI_3;
        frac_pi_4 FRAC_PI_4;
        frac_pi_6 FRAC_PI_6;
        frac_pi_8 FRAC_PI_8;
        frac_1_pi FRAC_1_PI;
        frac_2_pi FRAC_2_PI;
        frac_2_sqrt_pi FRAC_2_SQRT_PI;
        e E;
        log2_e LOG2_E;
        log10_e LOG10_E;
        ln_2 LN_2;
        ln_10 LN_10;
    }

    fn is_sign_positive(&self) -> bool {
        self.0.is_sign_positive()
    }
    fn is_sign_negative(&self) -> bool {
        self.0.is_sign_negative()
    }
    free! { copysign(sign) max(other) min(other) clamp(least, most) }
    fn atan2(self, other: Self) -> Self {
        count(|counts| counts.other += 1);
        Self(self.0.atan2(other.0))
    }
    fn min_value() -> Option<Self> {
        Some(Self(f64::MIN))
    }
    fn max_value() -> Option<Self> {
        Some(Self(f64::MAX))
    }
}
