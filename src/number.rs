//! Numbers for a reader, in error messages and reports.

use core::fmt::{self, Write};

use nalgebra::ComplexField;

use crate::scalar::{Scalar, to_f64};

/// Text of at most `N` bytes on the stack, to write a number or an error to where nothing
/// allocates; what does not fit is cut off.
#[derive(Debug, Clone)]
pub struct Text<const N: usize> {
    bytes: [u8; N],
    length: usize,
}

impl<const N: usize> Default for Text<N> {
    fn default() -> Self {
        Self { bytes: [0; N], length: 0 }
    }
}

impl<const N: usize> Text<N> {
    /// What was written.
    pub fn as_str(&self) -> &str {
        let written = self.bytes.get(..self.length).unwrap_or(&[]);
        core::str::from_utf8(written).unwrap_or("")
    }
}

impl<const N: usize> Write for Text<N> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for character in text.chars() {
            let end = self.length + character.len_utf8();
            let Some(place) = self.bytes.get_mut(self.length..end) else { return Ok(()) };
            character.encode_utf8(place);
            self.length = end;
        }
        Ok(())
    }
}

/// In which units a report prints: of a contact that slides along a line, or of a joint that turns.
///
/// The numbers are what was given. A joint's are angles, torques and moments of inertia, see the
/// conventions of the [crate](crate#conventions).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Units {
    /// m, m/s, N, kg.
    #[default]
    Translation,
    /// rad, rad/s, N m, kg m².
    Rotation,
}

impl Units {
    /// A unit or a word of translation, such as `"m/s"` or `"force"`, or what takes its place:
    /// `"rad/s"`, `"torque"`. What is the same for both, and what is not known, is returned as it
    /// is.
    ///
    /// ```
    /// use bristle::Units;
    ///
    /// assert_eq!(Units::Rotation.of("N s/m"), "N m s/rad");
    /// assert_eq!(Units::Translation.of("N s/m"), "N s/m");
    /// assert_eq!(Units::Rotation.of("1/s"), "1/s");
    /// ```
    pub fn of(self, translation: &'static str) -> &'static str {
        match (self, translation) {
            (Units::Translation, _) => translation,
            (_, "m") => "rad",
            (_, "1/m") => "1/rad",
            (_, "m/s") => "rad/s",
            (_, "s/m") => "s/rad",
            (_, "N") => "N m",
            (_, "N/m") => "N m/rad",
            (_, "N/A") => "N m/A",
            (_, "N s/m") => "N m s/rad",
            (_, "kg") => "kg m²",
            (_, "position") => "angle",
            (_, "velocity") => "angular velocity",
            (_, "force") => "torque",
            (_, "friction force") => "friction torque",
            (_, "mass") => "inertia",
            _ => translation,
        }
    }
}

/// A number for a reader: plain from 1e-3 to 1e6, with an exponent beyond, without trailing zeros.
///
/// `{}` prints every digit, `{:.5}` five significant ones.
#[derive(Debug, Clone, Copy)]
pub struct Number(pub f64);

/// A number as its shortest digits say: of a single 1e-7 this is 1e-7, not 1.0000000116860974e-7.
///
/// By arithmetic, because formatting is not free of panics, and parameters are refused by firmware.
pub(crate) fn decimal<T: Scalar>(value: T) -> f64 {
    let wide = to_f64(value);
    if to_f64(T::default_epsilon()) < 1e-10 || !wide.is_finite() || wide == 0.0 {
        return wide;
    }
    let before = ComplexField::floor(ComplexField::log10(f64::abs(wide))) as i32;
    // Nine digits tell every single from its neighbours.
    let rounded = (0..9).map(|after| {
        // 10²² and smaller powers are exact, and so is the last operation rounded once.
        let power: f64 = ComplexField::powi(10.0, i32::abs(after - before));
        if after >= before {
            ComplexField::round(wide * power) / power
        } else {
            ComplexField::round(wide / power) * power
        }
    });
    rounded.into_iter().find(|short| *short as f32 == wide as f32).unwrap_or(wide)
}

impl Number {
    /// A scalar, with the digits that it has.
    pub fn of<T: Scalar>(value: T) -> Self {
        Self(decimal(value))
    }

    fn write(self, digits: Option<usize>, to: &mut impl Write) -> fmt::Result {
        let rounded = match digits {
            Some(digits) => {
                let mut text = Text::<32>::default();
                write!(text, "{:.*e}", digits.saturating_sub(1), self.0)?;
                text.as_str().parse().unwrap_or(self.0)
            }
            None => self.0,
        };
        let size = f64::abs(rounded);
        if rounded == 0.0 {
            to.write_str("0")
        } else if size.is_finite() && !(1e-3..1e6).contains(&size) {
            write!(to, "{rounded:e}")
        } else {
            write!(to, "{rounded}")
        }
    }
}

/// With the width and the alignment that are asked for, to the left by default.
impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = Text::<40>::default();
        self.write(f.precision(), &mut text)?;
        // `Formatter::pad` would cut the text to the precision.
        let (text, width) = (text.as_str(), f.width().unwrap_or(0));
        match f.align() {
            Some(fmt::Alignment::Right) => write!(f, "{text:>width$}"),
            Some(fmt::Alignment::Center) => write!(f, "{text:^width$}"),
            _ => write!(f, "{text:<width$}"),
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{Number, decimal};
    use std::format;
    use std::string::ToString;

    #[test]
    fn a_single_is_taken_by_its_shortest_digits() {
        let mut bits = 1_u32;
        for _ in 0..20_000 {
            bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let single = f32::from_bits(bits);
            if (1e-13..1e22).contains(&single.abs()) {
                assert_eq!(Ok(decimal(single)), format!("{single:e}").parse());
            } else if single.is_finite() {
                assert_eq!(decimal(single) as f32, single);
            }
        }
        assert!(decimal(f32::NAN).is_nan() && decimal(f32::INFINITY) == f64::INFINITY);
        assert_eq!((decimal(1e-7_f32), decimal(0.1_f64), decimal(-0.0_f32)), (1e-7, 0.1, 0.0));
    }

    #[test]
    fn a_number_is_plain_where_it_is_short() {
        for (value, all, three) in [
            (0.0, "0", "0"),
            (-0.0, "0", "0"),
            (1.0, "1", "1"),
            (-2.5, "-2.5", "-2.5"),
            (12.345, "12.345", "12.3"),
            (100.0, "100", "100"),
            (1.000_000_000_000_02, "1.00000000000002", "1"),
            (999_999.0, "999999", "1e6"),
            (1e6, "1e6", "1e6"),
            (-123_456.0, "-123456", "-123000"),
            (0.001, "0.001", "0.001"),
            (0.012_34, "0.01234", "0.0123"),
            (9.999e-4, "9.999e-4", "0.001"),
            (1.5e-7, "1.5e-7", "1.5e-7"),
            (1e100, "1e100", "1e100"),
            (f64::NAN, "NaN", "NaN"),
            (f64::INFINITY, "inf", "inf"),
            (f64::NEG_INFINITY, "-inf", "-inf"),
        ] {
            assert_eq!(Number(value).to_string(), all);
            assert_eq!(format!("{:.3}", Number(value)), three);
        }
        assert_eq!(format!("{:8.2}|{:>8.2}|", Number(-0.0456), Number(1e9)), "-0.046  |     1e9|");
    }
}
