//! An axis, linear or logarithmic, with its ticks: a coordinate of plotters.

use std::ops::{Range, RangeInclusive};

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;

/// A range of values and its ticks.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    pub(super) start: f64,
    pub(super) end: f64,
    logarithmic: bool,
    ticks: Vec<f64>,
}

impl Axis {
    /// An axis with given ends, or what is wrong with them.
    pub(super) fn fixed(
        range: &RangeInclusive<f64>,
        logarithmic: bool,
    ) -> Result<Axis, &'static str> {
        let (start, end) = (*range.start(), *range.end());
        if !(start.is_finite() && end.is_finite() && start < end) {
            Err("an axis rises from one finite value to another")
        } else if logarithmic && start <= 0.0 {
            Err("a logarithmic axis starts above zero")
        } else {
            Ok(Axis { start, end, logarithmic, ticks: Vec::new() })
        }
    }

    /// An axis that shows all `values` that it can, with a `margin` (a part of the range) around.
    pub(super) fn fit(values: impl Iterator<Item = f64>, logarithmic: bool, margin: f64) -> Axis {
        let values = values.filter(|v| v.is_finite() && (!logarithmic || *v > 0.0));
        let values = values.map(|v| if logarithmic { v.log10() } else { v });
        let (mut low, mut high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        let width = high - low;
        let smallest = 1e-9 * high.abs().max(low.abs());
        // A constant gets an axis around it.
        let margin = match width {
            w if w > smallest => margin * w,
            _ if smallest > 0.0 && !logarithmic => 0.1 * high.abs(),
            _ => 0.5,
        };
        let (low, high) = (low - margin, high + margin);
        let value = |place: f64| if logarithmic { 10f64.powf(place) } else { place };
        Axis { start: value(low), end: value(high), logarithmic, ticks: Vec::new() }
    }

    /// This axis with about `count` ticks.
    pub(super) fn with_ticks(mut self, count: usize) -> Axis {
        self.ticks = if self.logarithmic {
            self.powers(count)
        } else {
            RangedCoordf64::from(self.start..self.end).key_points(count.max(3))
        };
        self
    }

    /// Widens this axis on both sides to `length`; the spacing of the ticks stays.
    pub(super) fn widen(&mut self, length: f64) {
        let middle = 0.5 * (self.start + self.end);
        let count = self.ticks.len();
        let grown = (length / (self.end - self.start)).max(1.0);
        (self.start, self.end) = (middle - 0.5 * length, middle + 0.5 * length);
        *self = self.clone().with_ticks((count as f64 * grown).ceil() as usize);
    }

    /// Powers of ten; twice and five times these where there are few.
    fn powers(&self, count: usize) -> Vec<f64> {
        let (low, high) = (self.start.log10(), self.end.log10());
        let decades = (high - low).max(1e-3);
        let stride = (decades / count.max(2) as f64).ceil().max(1.0) as i32;
        let factors: &[f64] = if decades * 3.0 <= count as f64 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        (low.floor() as i32..=high.ceil() as i32)
            .filter(|power| power % stride == 0)
            .flat_map(|power| factors.iter().map(move |factor| factor * 10f64.powi(power)))
            .filter(|tick| (self.start * (1.0 - 1e-9)..=self.end * (1.0 + 1e-9)).contains(tick))
            .collect()
    }

    /// Where a value lies from the start, 0, to the end, 1.
    pub(super) fn fraction(&self, value: f64) -> Option<f64> {
        let place = if self.logarithmic {
            (value / self.start).ln() / (self.end / self.start).ln()
        } else {
            (value - self.start) / (self.end - self.start)
        };
        place.is_finite().then_some(place)
    }

    pub(super) fn shows(&self, value: f64) -> bool {
        self.fraction(value).is_some_and(|place| (-1e-9..=1.0 + 1e-9).contains(&place))
    }

    /// The texts beside the ticks.
    pub(super) fn labels(&self) -> Vec<String> {
        self.ticks.iter().map(|tick| self.label(*tick)).collect()
    }

    fn label(&self, value: f64) -> String {
        let largest = self.ticks.iter().fold(0.0, |most: f64, tick| most.max(tick.abs()));
        let smallest = self.ticks.iter().fold(largest, |least, tick| least.min(tick.abs()));
        // Powers of ten alone are written as such; 20, 50 and 100 where a range is short.
        let near = smallest > 0.999e-2 && largest < 1.001e3;
        let plain = !self.logarithmic || (near && !self.ticks.iter().copied().all(is_power));
        // As few decimals as tell each tick from its neighbours; on a logarithmic axis its own.
        let step = self.ticks.windows(2).map(|pair| pair[1] - pair[0]).fold(largest, f64::min);
        let exact = |decimals: i32| {
            let off =
                |v: f64| ((v * 10f64.powi(decimals)).round() / 10f64.powi(decimals) - v).abs();
            let ticks = if self.logarithmic { &[value] } else { &self.ticks[..] };
            ticks.iter().all(|tick| off(*tick) < 1e-3 * step)
        };
        let text = match (0..=5).find(|&decimals| exact(decimals)) {
            Some(decimals) if plain && largest < 1e6 => {
                // Without the sign of a negative zero.
                let scale = 10f64.powi(decimals);
                format!("{:.*}", decimals as usize, (value * scale).round() / scale + 0.0)
            }
            _ if value == 0.0 => "0".to_owned(),
            _ => {
                let scale = if self.logarithmic { value } else { largest };
                let power = (scale.log10() + 1e-9).floor();
                let factor = (value / 10f64.powf(power) * 1e3).round() / 1e3;
                let factor = if self.logarithmic && factor == 1.0 {
                    String::new()
                } else {
                    format!("{factor}·")
                };
                format!("{factor}10{}", superscript(power as i32))
            }
        };
        text.replace('-', "−")
    }
}

/// Whether a tick is a power of ten.
fn is_power(tick: f64) -> bool {
    let power = tick.log10();
    (power - power.round()).abs() < 1e-9
}

/// `−3` raised.
fn superscript(power: i32) -> String {
    let raise = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32(u32::from('⁰') + digit.to_digit(10).unwrap_or(0)).unwrap_or('⁰'),
    };
    power.to_string().chars().map(raise).collect()
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let place = self.fraction(*value).unwrap_or(0.0).clamp(0.0, 1.0);
        limit.0 + (place * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.start..self.end
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        self.label(*value)
    }
}
