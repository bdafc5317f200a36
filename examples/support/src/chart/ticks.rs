//! Where an axis is marked, and what stands there.

use super::scale::Scale;

/// A mark on an axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub(super) value: f64,
    /// Empty for a minor tick.
    pub(super) label: String,
}

/// Steps of a linear axis in units of a power of ten, and those to fall back on when labels would be too few.
const STEPS: [&[f64]; 2] = [&[1.0, 2.0, 5.0], &[2.5, 4.0]];

/// Multiples of a power of ten with a label, for a logarithmic axis that holds at most one power of ten.
const MULTIPLES: [&[i32]; 2] = [&[1, 2, 5], &[1, 2, 3, 5, 7]];

/// The ticks of `scale`: as many as possible up to about `most` whose labels fit side by side, by `fits(labelled ticks)`.
/// Three labels show the scale of an axis better than two; one does not show it.
pub(super) fn ticks(scale: &Scale, most: usize, fits: impl Fn(&[&Tick]) -> bool) -> Vec<Tick> {
    let fewer = || (2..=most.max(2)).rev();
    let mut candidates: Vec<Vec<Vec<Tick>>> = Vec::new();
    if scale.logarithmic() {
        let tries =
            MULTIPLES.into_iter().flat_map(|multiples| fewer().map(move |most| (most, multiples)));
        candidates
            .push(tries.map(|(most, multiples)| logarithmic(scale, most, multiples)).collect());
    }
    // Linear marks on a logarithmic axis serve where it is so short that it is nearly linear.
    let tries = STEPS.into_iter().flat_map(|steps| fewer().map(move |most| (most, steps)));
    candidates.push(tries.map(|(most, steps)| linear(scale, most, steps)).collect());
    let shows = |ticks: &[Tick], enough: usize| {
        let labelled: Vec<&Tick> = ticks.iter().filter(|tick| !tick.label.is_empty()).collect();
        labelled.len() >= enough && fits(&labelled)
    };
    let best =
        |enough: usize, kind: &[Vec<Tick>]| kind.iter().find(|ticks| shows(ticks, enough)).cloned();
    let chosen = candidates.iter().find_map(|kind| best(3, kind).or_else(|| best(2, kind)));
    chosen.or_else(|| candidates.pop()?.pop()).unwrap_or_default()
}

/// Multiples of the finest step with at most `most` intervals, out of `steps` times a power of ten.
fn linear(scale: &Scale, most: usize, steps: &[f64]) -> Vec<Tick> {
    let (low, high) = scale.range();
    let coarse = (high - low) / most as f64;
    let decade = coarse.log10().floor() as i32;
    // Rounding must not turn a step that fits exactly into the next one.
    let long_enough = |step: &&f64| **step >= coarse / power(decade) * (1.0 - 1e-6);
    let (factor, decade) = match steps.iter().find(long_enough) {
        Some(&factor) => (factor, decade),
        None => (steps[0], decade + 1),
    };
    let step = factor * power(decade);
    // A tick on the edge counts although rounding may have pushed it out.
    let (first, last) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
    let largest = (first as f64 * step).abs().max((last as f64 * step).abs());
    let decimal = if factor.fract() == 0.0 { decade } else { decade - 1 };
    (first..=last)
        .map(|k| {
            // Dividing by a power of ten keeps 3 / 10 the number nearest to 0.3; 3 * 0.1 is not.
            let value =
                if decade < 0 { k as f64 * factor / power(-decade) } else { k as f64 * step };
            Tick { value, label: linear_label(value, decimal, largest) }
        })
        .collect()
}

/// `value`, exact to the decimals that a step of the order 10^`decade` asks for; with a power of ten where the plain
/// number would be long.
fn linear_label(value: f64, decade: i32, largest: f64) -> String {
    if value == 0.0 {
        return "0".to_owned(); // perhaps the only mark, and then there is no largest
    }
    let long = largest >= 99_999.5 || decade < -4;
    let exponent = largest.log10().floor() as i32;
    let digits = exponent - decade; // of the mantissa
    if long && digits <= 4 {
        format!("{}×10{}", signed(value / power(exponent), digits), superscript(exponent))
    } else {
        signed(value, -decade)
    }
}

/// Powers of ten, with the multiples 2 to 9 as minor ticks; where there is at most one power of ten, `multiples` of it
/// have labels too.
fn logarithmic(scale: &Scale, most: usize, multiples: &[i32]) -> Vec<Tick> {
    let (low, high) = scale.range();
    let (first, last) = ((low.log10() + 1e-9).floor() as i32, (high.log10() - 1e-9).ceil() as i32);
    let inside = |value: f64| value >= low * (1.0 - 1e-9) && value <= high * (1.0 + 1e-9);
    let decades = (first..=last).filter(|&decade| inside(power(decade))).count();
    let stride = decades.div_ceil(most).max(1) as i32;
    let labelled = |decade: i32, multiple: i32| {
        if decades < 2 {
            multiples.contains(&multiple)
        } else {
            multiple == 1 && decade % stride == 0
        }
    };
    let mut marks = Vec::new();
    for decade in first..=last {
        // With decades left out, these are the minor ticks, and multiples would only blacken the axis.
        for multiple in 1..=(if stride == 1 { 9 } else { 1 }) {
            let value = if decade < 0 {
                f64::from(multiple) / power(-decade)
            } else {
                f64::from(multiple) * power(decade)
            };
            if inside(value) {
                let label = match (labelled(decade, multiple), decades < 2) {
                    (false, _) => String::new(),
                    (true, false) => format!("10{}", superscript(decade)),
                    (true, true) => linear_label(value, decade, value),
                };
                marks.push(Tick { value, label });
            }
        }
    }
    marks
}

fn power(exponent: i32) -> f64 {
    10f64.powi(exponent)
}

fn signed(value: f64, decimals: i32) -> String {
    format!("{value:.*}", decimals.max(0) as usize).replace('-', "−")
}

fn superscript(exponent: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => digit.to_digit(10).and_then(|d| char::from_u32(0x2070 + d)).unwrap_or(digit),
    };
    exponent.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale, most: usize) -> String {
        let ticks = ticks(&scale, most, |_| true);
        ticks
            .into_iter()
            .filter(|t| !t.label.is_empty())
            .map(|t| t.label)
            .collect::<Vec<_>>()
            .join(" ")
    }

    #[test]
    fn zero_may_be_the_only_mark() {
        let only = linear(&Scale::linear(-348.0, 20.0), 2, &[1.0, 5.0]);
        assert_eq!(only.iter().map(|tick| tick.label.as_str()).collect::<Vec<_>>(), ["0"]);
    }

    #[test]
    fn linear_ticks_are_round_numbers() {
        assert_eq!(labels(Scale::linear(0.0, 60.0), 6), "0 10 20 30 40 50 60");
        assert_eq!(
            labels(Scale::linear(-0.13, 0.31), 5),
            "−0.1 0.0 0.1 0.2 0.3".replace("0.0 ", "0 ")
        );
        assert_eq!(labels(Scale::linear(-1.3e-6, 2.1e-6), 4), "−1×10⁻⁶ 0 1×10⁻⁶ 2×10⁻⁶");
        assert_eq!(
            labels(Scale::linear(0.0, 2.5e6), 5),
            "0 0.5×10⁶ 1.0×10⁶ 1.5×10⁶ 2.0×10⁶ 2.5×10⁶"
        );
        assert_eq!(
            labels(Scale::linear(100.0, 100.004), 4),
            "100.000 100.001 100.002 100.003 100.004"
        );
    }

    #[test]
    fn labels_that_collide_give_way_to_coarser_steps() {
        let three = ticks(&Scale::linear(0.0, 9.9), 8, |labelled| labelled.len() <= 4);
        assert_eq!(
            three.iter().map(|tick| tick.label.as_str()).collect::<Vec<_>>(),
            ["0", "2.5", "5.0", "7.5"]
        );
    }

    #[test]
    fn logarithmic_ticks_are_powers_of_ten_and_thin_out() {
        assert_eq!(labels(Scale::logarithmic_between(1e-3, 10.0), 8), "10⁻³ 10⁻² 10⁻¹ 10⁰ 10¹");
        assert_eq!(labels(Scale::logarithmic_between(1e-12, 1.0), 5), "10⁻¹² 10⁻⁹ 10⁻⁶ 10⁻³ 10⁰");
        assert_eq!(labels(Scale::logarithmic_between(0.015, 0.3), 5), "0.02 0.05 0.1 0.2");
        assert_eq!(labels(Scale::logarithmic_between(3.0, 4.0), 5), "3.0 3.2 3.4 3.6 3.8 4.0");
    }
}
