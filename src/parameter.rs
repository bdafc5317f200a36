//! The gate: every parameter of the crate is checked here, once, when a value is built. A refusal
//! is a [`ParameterError`]; [`Named`] is for parameters of your own curve, bristle or model.
//!
//! A check asks "is it finite and inside?", never "is it outside?": NaN answers no to both.
//! Positive parameters must also keep their reciprocals and a few products finite, so magnitudes
//! are limited to 10⁻¹⁰⁰ … 10¹⁰⁰ for `f64` and 10⁻¹⁸ … 10¹⁵ for `f32`, far beyond any friction
//! experiment; what is refused is a slip of units or an uninitialised number.

use core::fmt;

use crate::number::{Number, decimal};
use crate::scalar::{Scalar, lit, to_f64};

/// Why a parameter was refused: its name, its value and the rule it breaks.
///
/// ```
/// use bristle::{Dahl, DahlParameters};
///
/// let parameters = DahlParameters { dynamic_coefficient: 0.5, micro_stiffness: -3.0 };
/// let refused = Dahl::new(parameters).unwrap_err();
/// assert_eq!(
///     refused.to_string(),
///     "micro_stiffness is -3, but must lie between 1e-100 and 1e100"
/// );
/// ```
///
/// `Debug` prints the same sentence, so that a `main` that returns the error does, too.
#[derive(Clone, Copy, PartialEq, thiserror::Error)]
pub struct ParameterError {
    /// Name of the parameter, as in the struct or function that took it.
    pub name: &'static str,
    /// Which component, if the parameter is an array or a vector.
    pub component: Option<usize>,
    /// The value that was given, with the decimal digits of its type: 0.1 for an `f32` of 0.1.
    pub value: f64,
    /// The rule the value breaks.
    pub rule: Rule,
}

/// What passed the gate, or the parameter that was refused: what constructors and settings return.
pub type Checked<T> = Result<T, ParameterError>;

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, count) = (self.name, self.value);
        match self.rule {
            Rule::Count { least: 1 } | Rule::CountBetween { least: 1, most: 1 } => {
                return write!(f, "of {name} there must be {}, not {count}", self.rule);
            }
            Rule::Count { .. } | Rule::CountBetween { .. } => {
                return write!(f, "there must be {} {name}, not {count}", self.rule);
            }
            Rule::Takes(choices) => return write!(f, "{choices}, not {name}"),
            _ => f.write_str(name)?,
        }
        if let Some(component) = self.component {
            write!(f, "[{component}]")?;
        }
        write!(f, " is {}, but must {}", Number(self.value), self.rule)
    }
}

impl fmt::Debug for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// What a parameter must satisfy. For a program that acts on the reason of a refusal; a reader has
/// the sentence of the [`ParameterError`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Rule {
    /// Finite.
    Finite,
    /// Not NaN (infinity is allowed).
    Number,
    /// Between two limits, or at one of them.
    Between {
        /// Smallest admissible value.
        least: f64,
        /// Largest admissible value.
        most: f64,
    },
    /// At least as large as another parameter.
    AtLeast {
        /// Name of the other parameter.
        other: &'static str,
        /// Its value.
        limit: f64,
    },
    /// At most as large as another parameter.
    AtMost {
        /// Name of the other parameter.
        other: &'static str,
        /// Its value.
        limit: f64,
    },
    /// Smaller than another quantity.
    Below {
        /// Name of the other quantity.
        other: &'static str,
        /// Its value.
        limit: f64,
    },
    /// Exactly some value.
    Exactly {
        /// The only admissible value.
        value: f64,
    },
    /// A rule of one construction, in words: the value must …
    Stated(&'static str),
    /// Strictly larger than the component before it.
    Increasing {
        /// The component before.
        previous: f64,
    },
    /// Among the choices that some place takes, in words: "a batch takes FrBD or Dahl". The name of
    /// the error is the choice that was given, and its value is NaN.
    Takes(&'static str),
    /// A number of things with a lower limit.
    Count {
        /// Smallest admissible count.
        least: usize,
    },
    /// A number of things within limits.
    CountBetween {
        /// Smallest admissible count.
        least: usize,
        /// Largest admissible count.
        most: usize,
    },
    /// Between two limits everywhere, which it is not at one velocity.
    BetweenAt {
        /// Smallest admissible value.
        least: f64,
        /// Largest admissible value.
        most: f64,
        /// The velocity where it is outside, in m/s, of a joint in rad/s.
        place: f64,
    },
    /// Finite everywhere, which it is not at one velocity.
    FiniteAt {
        /// The velocity where it is not finite, in m/s, of a joint in rad/s.
        place: f64,
    },
    /// Zero or positive everywhere, which it is not at one place.
    NonNegativeAt {
        /// The place where it is negative.
        place: f64,
    },
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Rule::Finite => write!(f, "be finite"),
            Rule::Number => write!(f, "be a number"),
            Rule::Between { least, most } => {
                write!(f, "lie between {} and {}", Number(least), Number(most))
            }
            Rule::AtLeast { other, limit } => write!(f, "be at least {other} = {}", Number(limit)),
            Rule::AtMost { other, limit } => write!(f, "be at most {other} = {}", Number(limit)),
            Rule::Below { other, limit } => write!(f, "be below {other} = {}", Number(limit)),
            Rule::Exactly { value } => write!(f, "be exactly {}", Number(value)),
            Rule::Stated(rule) => f.write_str(rule),
            Rule::Increasing { previous } => {
                write!(f, "be larger than its predecessor {}", Number(previous))
            }
            Rule::Takes(choices) => f.write_str(choices),
            Rule::Count { least } => write!(f, "at least {least}"),
            Rule::CountBetween { least, most } if least == most => write!(f, "{least}"),
            Rule::CountBetween { least, most } => write!(f, "{least} to {most}"),
            Rule::BetweenAt { least, most, place } => {
                let (least, most) = (Number(least), Number(most));
                write!(f, "lie between {least} and {most} at v = {}", Number(place))
            }
            Rule::FiniteAt { place } => write!(f, "be finite at v = {}", Number(place)),
            Rule::NonNegativeAt { place } => {
                write!(f, "be zero or positive at ξ = {}", Number(place))
            }
        }
    }
}

/// Smallest and largest admissible magnitude for a scalar type.
fn limits<T: Scalar>() -> (f64, f64) {
    // A type with the range of an f32 has no 1e100; both leave room for products of several.
    let wide = T::max_value().is_none_or(|max| to_f64(max) > 1e100);
    if wide { (1e-100, 1e100) } else { (1e-18, 1e15) }
}

impl ParameterError {
    /// The error for a choice (a model, a curve, a method) at a place that takes others. It reads
    /// "`takes`, not `choice`".
    pub fn chosen(choice: &'static str, takes: &'static str) -> Self {
        Self { name: choice, component: None, value: f64::NAN, rule: Rule::Takes(takes) }
    }

    /// The result of a check with the component of an array that it was made for.
    pub fn of_component<V>(index: usize, checked: Result<V, Self>) -> Result<V, Self> {
        checked.map_err(|error| Self { component: Some(index), ..error })
    }

    /// Checks each component of an array; the error has that of the first one that is refused.
    ///
    /// # Errors
    ///
    /// The first of the checks.
    pub fn of_components<I: IntoIterator, V>(
        items: I,
        mut check: impl FnMut(I::Item) -> Checked<V>,
    ) -> Checked<()> {
        let mut items = items.into_iter().enumerate();
        items.try_for_each(|(index, item)| Self::of_component(index, check(item).map(drop)))
    }
}

/// A value before the gate, with its name in the struct or function that took it: to check the
/// parameters of a type of your own as this crate does.
///
/// Each check returns the value, or the error that names the parameter and the rule.
///
/// ```
/// use bristle::parameter::Named;
///
/// assert_eq!(Named("micro_stiffness", 1e4).positive()?, 1e4); // 1/m
/// assert!(Named("micro_stiffness", f64::NAN).positive().is_err());
/// # Ok::<(), bristle::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Named<T>(pub &'static str, pub T);

impl<T: Scalar> Named<T> {
    /// The smallest admissible magnitude of a positive parameter: 10⁻¹⁰⁰, of an `f32` 10⁻¹⁸.
    pub fn smallest() -> T {
        lit(limits::<T>().0)
    }

    /// The error for this value, which breaks a rule.
    pub fn refused(self, rule: Rule) -> ParameterError {
        ParameterError { name: self.0, component: None, value: decimal(self.1), rule }
    }

    /// The value if it passes, else the error with the rule that it breaks.
    pub fn check(self, passes: bool, rule: Rule) -> Checked<T> {
        if passes { Ok(self.1) } else { Err(self.refused(rule)) }
    }

    /// As [`Named::check`], with a rule in words, which go on from "must": "be even".
    pub fn stated(self, passes: bool, rule: &'static str) -> Checked<T> {
        self.check(passes, Rule::Stated(rule))
    }

    /// Not NaN.
    pub fn number(self) -> Checked<T> {
        self.check(self.1.abs() >= T::zero(), Rule::Number)
    }

    /// Finite, of either sign and of admissible magnitude.
    pub fn finite(self) -> Checked<T> {
        let (_, most) = limits::<T>();
        self.between(-most, most)
    }

    /// Strictly positive.
    pub fn positive(self) -> Checked<T> {
        let (least, most) = limits::<T>();
        self.between(least, most)
    }

    /// Zero or positive; −0 becomes 0, because what is divided by it has a sign.
    pub fn non_negative(self) -> Checked<T> {
        let (_, most) = limits::<T>();
        self.between(0.0, most).map(|value| value + T::zero())
    }

    /// Between two limits, or at one of them.
    pub fn between(self, least: f64, most: f64) -> Checked<T> {
        let inside = self.1 >= lit(least) && self.1 <= lit(most);
        self.check(inside, Rule::Between { least, most })
    }

    /// Not smaller than another parameter (both are checked to be finite elsewhere).
    pub fn at_least(self, other: &'static str, limit: T) -> Checked<T> {
        self.check(self.1 >= limit, Rule::AtLeast { other, limit: decimal(limit) })
    }

    /// Not larger than another parameter (both are checked to be finite elsewhere).
    pub fn at_most(self, other: &'static str, limit: T) -> Checked<T> {
        self.check(self.1 <= limit, Rule::AtMost { other, limit: decimal(limit) })
    }

    /// Strictly smaller than another quantity.
    pub fn below(self, other: &'static str, limit: T) -> Checked<T> {
        self.check(self.1 < limit, Rule::Below { other, limit: decimal(limit) })
    }

    /// Finite and strictly larger than the component before it.
    pub fn increasing(self, previous: T) -> Checked<T> {
        self.finite()?;
        self.check(self.1 > previous, Rule::Increasing { previous: decimal(previous) })
    }

    /// Exactly the value that the construction needs.
    pub fn exactly(self, wanted: T) -> Checked<T> {
        self.check(self.1 == wanted, Rule::Exactly { value: decimal(wanted) })
    }
}

impl Named<usize> {
    /// A count of at least `least`.
    pub fn count(self, least: usize) -> Checked<()> {
        let count = Named(self.0, self.1 as f64);
        count.check(self.1 >= least, Rule::Count { least }).map(drop)
    }

    /// A count of at least `least` and at most `most`.
    #[inline]
    pub fn count_between(self, least: usize, most: usize) -> Checked<()> {
        if (least..=most).contains(&self.1) {
            return Ok(());
        }
        Err(Named(self.0, self.1 as f64).refused(Rule::CountBetween { least, most }))
    }
}
