//! A quantity over two others, as colours.

use super::layout::Frame;
use super::scale::Scale;

/// Shades that are told apart. More would only lengthen the file.
const SHADES: usize = 48;

/// How values become colours. Both are made in Oklab, where equal steps look equal: the lightness runs straight.
///
/// Source of Oklab: B. Ottosson, "A perceptual color space for image processing" (2020),
/// <https://bottosson.github.io/posts/oklab/>.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColourMap {
    /// From nearly white at the lowest value to dark blue.
    Sequential,
    /// Blue below zero, nearly white at zero, red above. The range is symmetric.
    Diverging,
}

/// Values on a grid of x and y, coloured cell by cell, with a bar that tells what the colours mean.
#[derive(Debug, Clone)]
pub struct HeatMap {
    pub(super) label: String,
    map: ColourMap,
    x: Vec<f64>,
    y: Vec<f64>,
    values: Vec<f64>,
}

/// A rectangle of one colour, in fractions of the axes.
pub(super) struct Tile {
    pub(super) x: (f64, f64),
    pub(super) y: (f64, f64),
    pub(super) rgb: (u8, u8, u8),
}

impl HeatMap {
    /// A map of `value(i, j)` at the rising places `x[i]`, `y[j]`. The label of the bar carries the unit:
    /// `"deflection z / mm"`. NaN leaves the paper white.
    pub fn new(
        label: impl Into<String>,
        map: ColourMap,
        x: impl Into<Vec<f64>>,
        y: impl Into<Vec<f64>>,
        value: impl Fn(usize, usize) -> f64,
    ) -> HeatMap {
        let (x, y) = (x.into(), y.into());
        let value = &value;
        let values = (0..y.len()).flat_map(|j| (0..x.len()).map(move |i| value(i, j))).collect();
        HeatMap { label: label.into(), map, x, y, values }
    }

    /// The ends of x and of y.
    pub(super) fn ends(&self) -> [[f64; 2]; 2] {
        let ends = |places: &[f64]| match places {
            [] => [f64::NAN; 2],
            [first, .., last] => [*first, *last],
            [only] => [*only; 2],
        };
        [ends(&self.x), ends(&self.y)]
    }

    /// The scale of the colours.
    pub(super) fn scale(&self) -> Scale {
        let values = self.values.iter().copied();
        match self.map {
            ColourMap::Sequential => Scale::fit(values, false, 0.0),
            ColourMap::Diverging => Scale::fit(values.flat_map(|z| [z, -z]), false, 0.0),
        }
    }

    /// The colour at a fraction of the scale.
    pub(super) fn colour(&self, fraction: f64) -> (u8, u8, u8) {
        let shade = (fraction * SHADES as f64).floor().clamp(0.0, SHADES as f64 - 1.0);
        let middle = (shade + 0.5) / SHADES as f64;
        match self.map {
            // Lightness, chroma, hue in degrees.
            ColourMap::Sequential => oklch(0.97 - 0.67 * middle, 0.14 * middle, 250.0),
            ColourMap::Diverging => {
                let side = 2.0 * middle - 1.0;
                let hue = if side < 0.0 { 255.0 } else { 35.0 };
                oklch(0.97 - 0.52 * side.abs(), 0.17 * side.abs(), hue)
            }
        }
    }

    /// The shades from the lowest to the highest.
    pub(super) fn shades(&self) -> impl Iterator<Item = ((f64, f64), (u8, u8, u8))> + '_ {
        (0..SHADES).map(|i| {
            let edge = |i: usize| i as f64 / SHADES as f64;
            ((edge(i), edge(i + 1)), self.colour(0.5 * (edge(i) + edge(i + 1))))
        })
    }

    /// The cells, those of one shade in a row taken together, for a plot area of this size.
    pub(super) fn tiles(&self, x: &Scale, y: &Scale, frame: &Frame) -> Vec<Tile> {
        let scale = self.scale();
        let mut tiles: Vec<Tile> = Vec::new();
        let cells =
            |places: &[f64], axis: &Scale, length: f64| thinned(&edges(places, axis), length);
        let columns = cells(&self.x, x, frame.width);
        for (row, low, high) in cells(&self.y, y, frame.height) {
            let mut open: Option<Tile> = None;
            for &(column, left, right) in &columns {
                let value = self.values.get(row * self.x.len() + column).copied();
                let rgb = value.and_then(|z| scale.fraction(z)).map(|f| self.colour(f));
                match (&mut open, rgb) {
                    (Some(tile), Some(rgb)) if tile.rgb == rgb => tile.x.1 = right,
                    (_, rgb) => {
                        tiles.extend(open.take());
                        open = rgb.map(|rgb| Tile { x: (left, right), y: (low, high), rgb });
                    }
                }
            }
            tiles.extend(open);
        }
        tiles
    }
}

/// Of every place the cell around it, halfway to its neighbours, cut to the axis.
fn edges(places: &[f64], axis: &Scale) -> Vec<(usize, f64, f64)> {
    let at = |i: usize| axis.fraction(places[i]);
    (0..places.len())
        .filter_map(|i| {
            let here = at(i)?;
            let low = if i == 0 { here } else { 0.5 * (at(i - 1)? + here) };
            let high = if i + 1 == places.len() { here } else { 0.5 * (here + at(i + 1)?) };
            let (low, high) = (low.clamp(0.0, 1.0), high.clamp(0.0, 1.0));
            (low < high).then_some((i, low, high))
        })
        .collect()
}

/// Narrowest cell / px. Finer ones would only lengthen the file.
const NARROWEST: f64 = 1.5;

/// Cells that are too narrow give way to the first of those that stand together.
fn thinned(cells: &[(usize, f64, f64)], length: f64) -> Vec<(usize, f64, f64)> {
    let mut kept: Vec<(usize, f64, f64)> = Vec::new();
    for &(i, low, high) in cells {
        match kept.last_mut() {
            Some(last) if (last.2 - last.1) * length < NARROWEST => last.2 = high,
            _ => kept.push((i, low, high)),
        }
    }
    kept
}

/// Lightness 0 … 1, chroma and hue in degrees, as the red, green and blue of a screen.
fn oklch(lightness: f64, chroma: f64, hue: f64) -> (u8, u8, u8) {
    let (a, b) = (chroma * hue.to_radians().cos(), chroma * hue.to_radians().sin());
    let cube = |value: f64| value * value * value;
    let l = cube(lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b);
    let m = cube(lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b);
    let s = cube(lightness - 0.089_484_177_5 * a - 1.291_485_548 * b);
    let byte = |linear: f64| {
        let linear = linear.clamp(0.0, 1.0);
        let value = if linear <= 0.003_130_8 {
            12.92 * linear
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        };
        (255.0 * value).round() as u8
    };
    (
        byte(4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s),
        byte(-1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s),
        byte(-0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701 * s),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(colours: ColourMap, values: &[f64]) -> HeatMap {
        let x: Vec<f64> = (0..values.len()).map(|i| i as f64).collect();
        HeatMap::new("z / m", colours, x, [0.0, 1.0], |i, _| values[i])
    }

    /// Relative luminance of a screen colour (IEC 61966-2-1).
    fn luminance((r, g, b): (u8, u8, u8)) -> f64 {
        let linear = |byte: u8| {
            let value = f64::from(byte) / 255.0;
            if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b)
    }

    #[test]
    fn known_colours_of_oklab_come_out() {
        assert_eq!(oklch(1.0, 0.0, 0.0), (255, 255, 255));
        assert_eq!(oklch(0.0, 0.0, 0.0), (0, 0, 0));
        // The screen's red, in Ottosson's own conversion.
        assert_eq!(oklch(0.627_955, 0.257_683, 29.2339), (255, 0, 0));
    }

    #[test]
    fn the_maps_darken_steadily_away_from_their_light_end() {
        let sequential = map(ColourMap::Sequential, &[0.0, 1.0]);
        let light: Vec<f64> = sequential.shades().map(|shade| luminance(shade.1)).collect();
        assert!(light.windows(2).all(|pair| pair[0] > pair[1]), "{light:?}");
        let diverging = map(ColourMap::Diverging, &[-1.0, 1.0]);
        let light: Vec<f64> = diverging.shades().map(|shade| luminance(shade.1)).collect();
        let (below, above) = light.split_at(SHADES / 2);
        assert!(below.windows(2).all(|pair| pair[0] < pair[1]), "{below:?}");
        assert!(above.windows(2).all(|pair| pair[0] > pair[1]), "{above:?}");
        // Both ends look equally far from zero.
        assert!((light[0] / light[SHADES - 1] - 1.0).abs() < 0.25, "{light:?}");
    }

    #[test]
    fn zero_is_in_the_middle_of_a_diverging_map_and_nan_is_left_out() {
        let map = map(ColourMap::Diverging, &[-1.0, -1.0, f64::NAN, 3.0]);
        assert_eq!(map.scale().range(), (-3.0, 3.0));
        let frame = Frame { left: 0.0, top: 0.0, width: 100.0, height: 100.0 };
        let tiles = map.tiles(&Scale::linear(0.0, 3.0), &Scale::linear(0.0, 1.0), &frame);
        // Two rows, in each the first two cells as one, a gap, and the last.
        let x: Vec<(f64, f64)> = tiles.iter().map(|tile| tile.x).collect();
        let wanted = [(0.0, 0.5), (2.5 / 3.0, 1.0), (0.0, 0.5), (2.5 / 3.0, 1.0)];
        assert_eq!(x.len(), wanted.len());
        for ((left, right), (from, to)) in x.into_iter().zip(wanted) {
            assert!((left - from).abs() < 1e-12 && (right - to).abs() < 1e-12, "{left} {right}");
        }
    }
}
