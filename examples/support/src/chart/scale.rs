//! From values to a fraction of the axis length.

use std::ops::RangeInclusive;

/// Greatest magnitude that is drawn. Beyond it differences of two values overflow.
const LARGEST: f64 = 1e300;

/// Narrowest range, relative to its ends, whose ticks are still told apart by `f64` arithmetic.
const NARROWEST: f64 = 1e-12;

/// A resolved axis: a range, linear or logarithmic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    low: f64,
    high: f64,
    logarithmic: bool,
}

impl Scale {
    /// The axis with the given ends, or what is wrong with them.
    pub(super) fn fixed(
        range: &RangeInclusive<f64>,
        logarithmic: bool,
    ) -> Result<Scale, &'static str> {
        let (low, high) = (*range.start(), *range.end());
        let magnitude = low.abs().max(high.abs());
        if !(magnitude <= LARGEST) {
            Err("both ends must be finite")
        } else if !(high - low > NARROWEST * magnitude) {
            Err("the end must lie above the start")
        } else if logarithmic && !(low >= 1.0 / LARGEST) {
            Err("a logarithmic axis starts above zero")
        } else {
            Ok(Scale { low, high, logarithmic })
        }
    }

    /// The axis that shows all `values`, with `margin` (a fraction of the range) at both ends.
    pub(super) fn fit(values: impl Iterator<Item = f64>, logarithmic: bool, margin: f64) -> Scale {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|&value| drawable(value, logarithmic)) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            (low, high) = if logarithmic { (1.0, 10.0) } else { (0.0, 1.0) };
        }
        if logarithmic {
            let (a, b) = (low.log10(), high.log10());
            let pad = if b - a < 1e-3 { 0.5 } else { margin * (b - a) };
            return Scale { low: 10f64.powf(a - pad), high: 10f64.powf(b + pad), logarithmic };
        }
        let (span, magnitude) = (high - low, low.abs().max(high.abs()));
        let pad = match magnitude {
            tiny if tiny < 1.0 / LARGEST => 1.0,
            _ if span <= NARROWEST * magnitude => 0.1 * magnitude,
            _ => margin * span,
        };
        Scale { low: low - pad, high: high + pad, logarithmic }
    }

    pub(super) fn range(&self) -> (f64, f64) {
        (self.low, self.high)
    }

    pub(super) fn logarithmic(&self) -> bool {
        self.logarithmic
    }

    /// 0 at the low end, 1 at the high end; `None` for what cannot be drawn: NaN, infinity, and on a logarithmic axis
    /// zero and below.
    pub(super) fn fraction(&self, value: f64) -> Option<f64> {
        drawable(value, self.logarithmic).then(|| {
            if self.logarithmic {
                (value.log10() - self.low.log10()) / (self.high.log10() - self.low.log10())
            } else {
                (value - self.low) / (self.high - self.low)
            }
        })
    }

    /// Whether `value` lies on the axis.
    pub(super) fn shows(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

fn drawable(value: f64, logarithmic: bool) -> bool {
    value.abs() <= LARGEST && (!logarithmic || value >= 1.0 / LARGEST)
}

#[cfg(test)]
impl Scale {
    pub(super) fn linear(low: f64, high: f64) -> Scale {
        Scale { low, high, logarithmic: false }
    }

    pub(super) fn logarithmic_between(low: f64, high: f64) -> Scale {
        Scale { low, high, logarithmic: true }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_drawn_does_not_move_the_axis() {
        let values = [f64::NAN, 1.0, f64::INFINITY, 3.0, f64::MAX];
        assert_eq!(Scale::fit(values.into_iter(), false, 0.0), Scale::linear(1.0, 3.0));
        let scale = Scale::fit([0.0, -1.0, 10.0, 1000.0].into_iter(), true, 0.0);
        let (low, high) = scale.range();
        assert!((low - 10.0).abs() < 1e-12 && (high - 1000.0).abs() < 1e-9, "{scale:?}");
        assert_eq!(scale.fraction(0.0), None);
    }

    #[test]
    fn nothing_and_a_constant_still_get_an_axis() {
        for logarithmic in [false, true] {
            for values in [
                &[][..],
                &[5.0, 5.0],
                &[0.0],
                &[5e-324],
                &[1e300],
                &[-1e300, 1e300],
                &[1.0, 1.0 + 1e-15],
            ] {
                let (low, high) = Scale::fit(values.iter().copied(), logarithmic, 0.05).range();
                assert!(low < high && (high - low).is_finite(), "{values:?} {low} {high}");
            }
        }
    }

    #[test]
    fn a_fixed_range_is_refused_when_it_is_empty_or_leaves_the_axis() {
        for range in [1.0..=1.0, 2.0..=1.0, f64::NAN..=1.0, 0.0..=f64::INFINITY] {
            assert!(Scale::fixed(&range, false).is_err(), "{range:?}");
        }
        assert!(Scale::fixed(&(0.0..=1.0), true).is_err());
    }
}
