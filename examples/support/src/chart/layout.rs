//! Where everything stands. Plot areas of one column share their left and right edges, those of one row top and bottom,
//! and all are of one size. All lengths in px.

use super::panel::Panel;
use super::path::Point;
use super::scale::Scale;
use super::text::{width, wrap};
use super::ticks::{Tick, ticks};

/// Font size of axis labels, titles and the legend.
pub(super) const LABEL: f64 = 12.0;
/// Font size of tick labels and reference lines.
pub(super) const SMALL: f64 = 10.5;
/// Height of a line of labels.
pub(super) const LINE: f64 = 15.0;
/// Length of a major tick, outside the frame.
pub(super) const TICK: f64 = 4.0;
/// From the frame to the tick labels.
pub(super) const TICK_GAP: f64 = 7.0;
/// From the edge of the paper to anything.
pub(super) const EDGE: f64 = 8.0;
/// From the right end of a plot area on: half of the widest x tick label must fit in.
const RIGHT: f64 = 16.0;
/// Gap between a plot area and its bar of colours, and the bar's width.
pub(super) const BAR: (f64, f64) = (10.0, 12.0);
/// Between a column of panels and the next, beyond RIGHT; between a row and the next.
const BETWEEN: f64 = 8.0;
/// Closest labelled y ticks.
const Y_PITCH: f64 = 24.0;
/// Smallest plot area that can be read.
const SMALLEST: (f64, f64) = (80.0, 50.0);

/// A plot area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Frame {
    pub(super) fn right(&self) -> f64 {
        self.left + self.width
    }

    pub(super) fn bottom(&self) -> f64 {
        self.top + self.height
    }

    pub(super) fn contains(&self, (x, y): Point) -> bool {
        (self.left..=self.right()).contains(&x) && (self.top..=self.bottom()).contains(&y)
    }
}

/// A panel with its place on the paper.
pub(super) struct Placed<'a> {
    pub(super) panel: &'a Panel,
    pub(super) frame: Frame,
    pub(super) x: Scale,
    pub(super) y: Scale,
    pub(super) x_ticks: Vec<Tick>,
    pub(super) y_ticks: Vec<Tick>,
    pub(super) title: Vec<String>,
    pub(super) x_label: Vec<String>,
    pub(super) y_label: Vec<String>,
    /// From the frame to the middle of the y label's last line.
    pub(super) y_label_distance: f64,
    pub(super) bar: Option<Bar>,
}

/// The bar that tells what the colours of a heat map mean.
pub(super) struct Bar {
    pub(super) scale: Scale,
    pub(super) ticks: Vec<Tick>,
    pub(super) label: Vec<String>,
    /// From the bar to the middle of the label's first line.
    pub(super) label_distance: f64,
}

impl Bar {
    /// What it takes beside the plot area.
    fn width(&self) -> f64 {
        BAR.0 + BAR.1 + self.label_distance + (self.label.len() as f64 - 0.5) * LINE
    }
}

impl Placed<'_> {
    /// The place of a value; `None` if it cannot be drawn.
    pub(super) fn place(&self, (x, y): (f64, f64)) -> Option<Point> {
        // Far outside the frame only the direction matters; the bound keeps clipping away from overflow.
        let far = |length: f64| length.clamp(-1e9, 1e9);
        let x = self.frame.left + self.x.fraction(x)? * self.frame.width;
        let y = self.frame.bottom() - self.y.fraction(y)? * self.frame.height;
        Some((far(x), far(y)))
    }
}

/// Places the panels, row by row, in `columns` on a paper of `size`, below a legend that ends at `top`. Fails with the
/// size of a plot area too small to be read.
pub(super) fn place<'a>(
    panels: &'a [Panel],
    scales: &[(Scale, Scale)],
    columns: usize,
    size: (f64, f64),
    top: f64,
) -> Result<Vec<Placed<'a>>, (f64, f64)> {
    let rows = panels.len().div_ceil(columns);
    let cell = (size.0 - 2.0 * EDGE) / columns as f64;
    // Labels are wrapped to what is left beside a usual column of tick labels.
    let usual = (cell - 70.0).max(SMALLEST.0);
    let titles: Vec<_> = panels.iter().map(|panel| wrap(&panel.title, LABEL, usual)).collect();
    let x_labels: Vec<_> = panels.iter().map(|panel| wrap(&panel.x.label, LABEL, usual)).collect();
    let most_lines =
        |texts: &[Vec<String>]| texts.iter().map(Vec::len).max().unwrap_or(0) as f64 * LINE;
    let above: Vec<f64> = titles.chunks(columns).map(|row| most_lines(row) + 6.0).collect();
    let below: Vec<f64> =
        x_labels.chunks(columns).map(|row| TICK_GAP + LINE + most_lines(row) + 2.0).collect();
    let taken = above.iter().chain(&below).sum::<f64>() + BETWEEN * (rows as f64 - 1.0);
    let height = (size.1 - top - EDGE - taken) / rows as f64;

    let most = (height / Y_PITCH).floor().clamp(2.0, 8.0) as usize;
    let y_ticks: Vec<_> = scales
        .iter()
        .map(|(_, y)| ticks(y, most, |labelled| apart(y, labelled, height, |_| 13.0)))
        .collect();
    let y_labels: Vec<_> =
        panels.iter().map(|panel| wrap(&panel.y.label, LABEL, height + 8.0)).collect();
    let left: Vec<(f64, f64)> = (0..columns)
        .map(|column| {
            let own = || (column..panels.len()).step_by(columns);
            let numbers = own()
                .flat_map(|i| &y_ticks[i])
                .map(|tick| width(&tick.label, SMALL))
                .fold(0.0, f64::max);
            let lines = own().map(|i| y_labels[i].len()).max().unwrap_or(0) as f64 * LINE;
            let distance = TICK_GAP + numbers + 6.0 + 0.5 * LINE;
            (distance - 0.5 * LINE + lines, distance)
        })
        .collect();
    let bars: Vec<Option<Bar>> = panels
        .iter()
        .map(|panel| {
            let map = panel.heat_map.as_ref()?;
            let scale = map.scale();
            let ticks = ticks(&scale, most, |labelled| apart(&scale, labelled, height, |_| 13.0));
            let numbers = ticks.iter().map(|tick| width(&tick.label, SMALL)).fold(0.0, f64::max);
            let label = wrap(&map.label, LABEL, height + 8.0);
            Some(Bar { scale, ticks, label, label_distance: TICK_GAP + numbers + 6.0 + 0.5 * LINE })
        })
        .collect();
    let right: Vec<f64> = (0..columns)
        .map(|column| {
            let own = bars.iter().skip(column).step_by(columns).flatten();
            own.map(|bar| bar.width() + 4.0).fold(RIGHT, f64::max)
        })
        .collect();
    let margins = left.iter().map(|(margin, _)| margin).chain(&right).sum::<f64>()
        + BETWEEN * (columns as f64 - 1.0);
    let plot_width = (size.0 - 2.0 * EDGE - margins) / columns as f64;
    if !(plot_width >= SMALLEST.0 && height >= SMALLEST.1) {
        return Err((plot_width, height));
    }

    let mut placed = Vec::new();
    let texts = titles.into_iter().zip(x_labels).zip(y_labels).zip(y_ticks);
    for (i, ((((title, x_label), y_label), y_ticks), bar)) in texts.zip(bars).enumerate() {
        let (row, column) = (i / columns, i % columns);
        let (x, y) = scales[i];
        let frame = Frame {
            left: EDGE
                + left[..=column].iter().map(|(margin, _)| margin).sum::<f64>()
                + right[..column].iter().sum::<f64>()
                + column as f64 * (plot_width + BETWEEN),
            top: top
                + above[..=row].iter().sum::<f64>()
                + below[..row].iter().sum::<f64>()
                + row as f64 * (height + BETWEEN),
            width: plot_width,
            height,
        };
        let most = (plot_width / 40.0).floor().clamp(2.0, 10.0) as usize;
        let room = |tick: &Tick| width(&tick.label, SMALL) + 8.0;
        let x_ticks = ticks(&x, most, |labelled| apart(&x, labelled, plot_width, room));
        let y_label_distance = left[column].1;
        placed.push(Placed {
            panel: &panels[i],
            frame,
            x,
            y,
            x_ticks,
            y_ticks,
            title,
            x_label,
            y_label,
            y_label_distance,
            bar,
        });
    }
    Ok(placed)
}

/// Whether labels of the given `room` along an axis of `length` stay clear of each other.
fn apart(scale: &Scale, labelled: &[&Tick], length: f64, room: impl Fn(&Tick) -> f64) -> bool {
    labelled.windows(2).all(|pair| {
        let at = |tick: &Tick| scale.fraction(tick.value).unwrap_or(0.0) * length;
        at(pair[1]) - at(pair[0]) >= 0.5 * (room(pair[0]) + room(pair[1]))
    })
}
