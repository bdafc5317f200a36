//! A grid of panels under one legend.

use std::collections::HashSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::canvas::{Anchor, Canvas, DrawError, Grey, document};
use super::labels::{all_over, along, beside};
use super::layout::{BAR, EDGE, LABEL, LINE, Placed, SMALL, TICK, TICK_GAP, place};
use super::legend::Legend;
use super::panel::{Look, Panel, Reference};
use super::path::{Point, pieces};
use crate::file::{FileError, create_folder};

const GRID: Grey = Grey(228);
const REFERENCE: Grey = Grey(90);
const FRAME: Grey = Grey(60);
const BLACK: Grey = Grey(0);

/// A figure: panels in a grid, filled row by row, and one legend above them that names every series once.
#[derive(Debug, Clone)]
#[must_use = "a figure is written by `save`"]
pub struct Figure {
    width: u32,
    height: u32,
    columns: usize,
    panels: Vec<Panel>,
}

/// Why a figure could not be drawn or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FigureError {
    /// The fixed range of an axis makes no sense.
    #[error("panel {panel}, {axis} axis from {start} to {end}: {rule}")]
    Range {
        /// Number of the panel, from 1.
        panel: usize,
        /// `x` or `y`.
        axis: char,
        /// Start of the range.
        start: f64,
        /// End of the range.
        end: f64,
        /// What the range must obey.
        rule: &'static str,
    },
    /// The panels do not fit on the paper.
    #[error(
        "a figure of {width} × {height} px leaves {plot_width:.0} × {plot_height:.0} px for each plot; enlarge it"
    )]
    TooSmall {
        /// Width of the figure / px.
        width: u32,
        /// Height of the figure / px.
        height: u32,
        /// Width of a plot area / px.
        plot_width: f64,
        /// Height of a plot area / px.
        plot_height: f64,
    },
    /// The file could not be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The drawing library failed.
    #[error("cannot draw: {0}")]
    Draw(#[from] io::Error),
}

impl Figure {
    /// An empty figure of `width` × `height` px with a single column. Text is 12 px high: a figure 640 px wide, printed
    /// across 17 cm, has labels of 9 pt.
    pub fn new(width: u32, height: u32) -> Figure {
        Figure { width, height, columns: 1, panels: Vec::new() }
    }

    /// Sets the number of columns.
    pub fn columns(mut self, columns: usize) -> Figure {
        self.columns = columns.max(1);
        self
    }

    /// Adds a panel: to the right of the last one, or in the next row.
    pub fn panel(mut self, panel: Panel) -> Figure {
        self.panels.push(panel);
        self
    }

    /// Writes `folder/name.svg` (and creates the folder) and returns its path.
    pub fn save(&self, folder: impl AsRef<Path>, name: &str) -> Result<PathBuf, FigureError> {
        let svg = self.svg()?;
        create_folder(folder.as_ref())?;
        let path = folder.as_ref().join(format!("{name}.svg"));
        fs::write(&path, svg).map_err(FileError::at("write", &path))?;
        Ok(path)
    }

    /// The figure as the text of an SVG document.
    pub fn svg(&self) -> Result<String, FigureError> {
        let mut scales = Vec::new();
        for (i, panel) in self.panels.iter().enumerate() {
            let refuse = |axis: char, range: &Option<std::ops::RangeInclusive<f64>>, rule| {
                let (start, end) =
                    range.as_ref().map_or((f64::NAN, f64::NAN), |r| (*r.start(), *r.end()));
                FigureError::Range { panel: i + 1, axis, start, end, rule }
            };
            let x = panel.x_scale().map_err(|rule| refuse('x', &panel.x.range, rule))?;
            let y = panel.y_scale(&x).map_err(|rule| refuse('y', &panel.y.range, rule))?;
            scales.push((x, y));
        }
        let size = (f64::from(self.width), f64::from(self.height));
        let legend = Legend::new(&self.panels, size.0);
        let placed = place(&self.panels, &scales, self.columns, size, EDGE + legend.height());
        let placed = placed.map_err(|(plot_width, plot_height)| FigureError::TooSmall {
            width: self.width,
            height: self.height,
            plot_width,
            plot_height,
        })?;
        let left = placed.iter().map(|placed| placed.frame.left).fold(size.0, f64::min);
        let right = placed.iter().map(|placed| placed.frame.right()).fold(0.0, f64::max);
        Ok(document(self.width, self.height, |canvas| {
            legend.draw(canvas, left, right, EDGE)?;
            placed.iter().try_for_each(|placed| draw_panel(canvas, placed))
        })?)
    }
}

/// Draws from the back to the front: grid, reference lines, series, frame, words.
fn draw_panel(canvas: &mut Canvas<'_>, placed: &Placed<'_>) -> Result<(), DrawError> {
    draw_grid(canvas, placed)?;
    let coloured = draw_heat_map(canvas, placed)?;
    let lines = reference_lines(placed);
    for &(from, to, _) in &lines {
        canvas.rule(&[from, to], REFERENCE, 0.8)?;
    }
    let mut taken = draw_series(canvas, placed)?;
    draw_axes(canvas, placed)?;
    for (from, to, label) in lines.into_iter().filter(|(_, _, label)| !label.is_empty()) {
        let place = beside(label, from, to, &placed.frame, &taken);
        canvas.fill((place.left, place.top), (place.right(), place.bottom()), 0.8)?;
        canvas.text(
            label,
            (place.left + 2.0, place.top + 0.5 * place.height),
            Anchor::Left,
            SMALL,
            REFERENCE,
        )?;
        taken.extend(all_over(&place));
    }
    if taken.is_empty() && !coloured {
        let middle = (
            placed.frame.left + 0.5 * placed.frame.width,
            placed.frame.top + 0.5 * placed.frame.height,
        );
        canvas.text("no data", middle, Anchor::Centre, LABEL, REFERENCE)?;
    }
    Ok(())
}

fn draw_grid(canvas: &mut Canvas<'_>, placed: &Placed<'_>) -> Result<(), DrawError> {
    let frame = &placed.frame;
    for tick in placed.x_ticks.iter().filter(|tick| !tick.label.is_empty()) {
        let x = frame.left + placed.x.fraction(tick.value).unwrap_or(0.0) * frame.width;
        canvas.rule(&[(x, frame.top), (x, frame.bottom())], GRID, 0.6)?;
    }
    for tick in placed.y_ticks.iter().filter(|tick| !tick.label.is_empty()) {
        let y = frame.bottom() - placed.y.fraction(tick.value).unwrap_or(0.0) * frame.height;
        canvas.rule(&[(frame.left, y), (frame.right(), y)], GRID, 0.6)?;
    }
    Ok(())
}

/// Draws the coloured ground and the bar beside it, and tells whether there is one.
fn draw_heat_map(canvas: &mut Canvas<'_>, placed: &Placed<'_>) -> Result<bool, DrawError> {
    let (Some(map), Some(bar)) = (&placed.panel.heat_map, &placed.bar) else { return Ok(false) };
    let frame = &placed.frame;
    // Neighbours overlap by a pixel, or the paper would shine through between them.
    const OVERLAP: f64 = 1.0;
    let tiles = map.tiles(&placed.x, &placed.y, frame);
    let drawn = !tiles.is_empty();
    for tile in tiles {
        let x = |fraction: f64| frame.left + fraction * frame.width;
        let y = |fraction: f64| frame.bottom() - fraction * frame.height;
        let from = (x(tile.x.0), (y(tile.y.1) - OVERLAP).max(frame.top));
        canvas.tile(from, ((x(tile.x.1) + OVERLAP).min(frame.right()), y(tile.y.0)), tile.rgb)?;
    }
    let (left, right) = (frame.right() + BAR.0, frame.right() + BAR.0 + BAR.1);
    let y = |fraction: f64| frame.bottom() - fraction * frame.height;
    for ((low, high), rgb) in map.shades() {
        canvas.tile((left, (y(high) - OVERLAP).max(frame.top)), (right, y(low)), rgb)?;
    }
    let (top, bottom) = (frame.top, frame.bottom());
    let around = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
    canvas.rule(&around, FRAME, 0.9)?;
    for tick in &bar.ticks {
        let y = y(bar.scale.fraction(tick.value).unwrap_or(0.0));
        canvas.rule(&[(right, y), (right + TICK, y)], FRAME, 0.9)?;
        canvas.text(&tick.label, (right + TICK_GAP, y), Anchor::Left, SMALL, BLACK)?;
    }
    let centre = top + 0.5 * frame.height;
    for (i, line) in bar.label.iter().enumerate() {
        let x = right + bar.label_distance + i as f64 * LINE;
        canvas.text(line, (x, centre), Anchor::Turned, LABEL, BLACK)?;
    }
    Ok(drawn)
}

/// The reference lines inside the frame, with their labels.
fn reference_lines<'a>(placed: &Placed<'a>) -> Vec<(Point, Point, &'a str)> {
    let frame = &placed.frame;
    let line = |reference: &'a Reference| match reference {
        Reference::Horizontal(y, label) => {
            let y = placed.y.shows(*y).then(|| placed.y.fraction(*y)).flatten()?;
            let y = frame.bottom() - y * frame.height;
            Some(((frame.left, y), (frame.right(), y), label.as_str()))
        }
        Reference::Vertical(x, label) => {
            let x = placed.x.shows(*x).then(|| placed.x.fraction(*x)).flatten()?;
            let x = frame.left + x * frame.width;
            Some(((x, frame.bottom()), (x, frame.top), label.as_str()))
        }
    };
    placed.panel.references.iter().filter_map(line).collect()
}

/// Draws the series and returns the places they cover.
fn draw_series(canvas: &mut Canvas<'_>, placed: &Placed<'_>) -> Result<Vec<Point>, DrawError> {
    let mut taken = Vec::new();
    for series in &placed.panel.series {
        let points = series.points.iter().map(|&point| placed.place(point));
        match series.look {
            Look::Line(stroke) => {
                let pieces = pieces(points, &placed.frame);
                canvas.line(&pieces, stroke)?;
                for piece in &pieces {
                    taken.extend(piece.first());
                    taken.extend(along(piece));
                }
            }
            Look::Points(symbol) => {
                // Of symbols that nearly cover each other one is enough.
                let cell = (symbol.size / 3.0).max(1.0);
                let mut drawn = HashSet::new();
                for point in points.flatten().filter(|&point| placed.frame.contains(point)) {
                    if drawn.insert(((point.0 / cell) as i32, (point.1 / cell) as i32)) {
                        canvas.symbol(point, symbol)?;
                        taken.push(point);
                    }
                }
            }
        }
    }
    Ok(taken)
}

fn draw_axes(canvas: &mut Canvas<'_>, placed: &Placed<'_>) -> Result<(), DrawError> {
    let frame = &placed.frame;
    let (left, right, top, bottom) = (frame.left, frame.right(), frame.top, frame.bottom());
    canvas.rule(
        &[(left, top), (right, top), (right, bottom), (left, bottom), (left, top)],
        FRAME,
        0.9,
    )?;
    let length = |label: &str| if label.is_empty() { 0.55 * TICK } else { TICK };
    for tick in &placed.x_ticks {
        let x = left + placed.x.fraction(tick.value).unwrap_or(0.0) * frame.width;
        canvas.rule(&[(x, bottom), (x, bottom + length(&tick.label))], FRAME, 0.9)?;
        if !tick.label.is_empty() {
            canvas.text(
                &tick.label,
                (x, bottom + TICK_GAP + 0.45 * LINE),
                Anchor::Centre,
                SMALL,
                BLACK,
            )?;
        }
    }
    for tick in &placed.y_ticks {
        let y = bottom - placed.y.fraction(tick.value).unwrap_or(0.0) * frame.height;
        canvas.rule(&[(left, y), (left - length(&tick.label), y)], FRAME, 0.9)?;
        if !tick.label.is_empty() {
            canvas.text(&tick.label, (left - TICK_GAP, y), Anchor::Right, SMALL, BLACK)?;
        }
    }
    let (middle, centre) = (left + 0.5 * frame.width, top + 0.5 * frame.height);
    for (i, line) in placed.x_label.iter().enumerate() {
        let y = bottom + TICK_GAP + LINE + 2.0 + (i as f64 + 0.5) * LINE;
        canvas.text(line, (middle, y), Anchor::Centre, LABEL, BLACK)?;
    }
    for (i, line) in placed.y_label.iter().rev().enumerate() {
        let x = left - placed.y_label_distance - i as f64 * LINE;
        canvas.text(line, (x, centre), Anchor::Turned, LABEL, BLACK)?;
    }
    for (i, line) in placed.title.iter().rev().enumerate() {
        let y = top - 5.0 - (i as f64 + 0.5) * LINE;
        canvas.text(line, (left, y), Anchor::Left, LABEL, BLACK)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Colour, ColourMap, HeatMap};

    fn panel() -> Panel {
        Panel::new("time t / s", "position x / m").line(
            "a < b",
            Colour::Blue,
            [(0.0, 1.0), (1.0, 2.0)],
        )
    }

    #[test]
    fn the_legend_names_a_series_once_for_all_panels() -> Result<(), FigureError> {
        let svg = Figure::new(400, 600).panel(panel()).panel(panel()).svg()?;
        assert_eq!(svg.matches("a &lt; b").count(), 1);
        assert_eq!(svg.matches("position x").count(), 2);
        assert!(svg.starts_with("<svg width=\"400\" height=\"600\""));
        Ok(())
    }

    #[test]
    fn what_cannot_be_drawn_is_told() {
        let refusal = |figure: Figure| figure.svg().map(|_| ()).map_err(|error| error.to_string());
        let range =
            refusal(Figure::new(400, 300).panel(panel()).panel(panel().log_y().y_range(0.0..=1.0)));
        let rule = "a logarithmic axis starts above zero";
        assert_eq!(range, Err(format!("panel 2, y axis from 0 to 1: {rule}")));
        let small = refusal(Figure::new(100, 100).panel(panel()));
        assert!(small.is_err_and(|message| message.starts_with("a figure of 100 × 100 px leaves")));
    }

    #[test]
    fn a_heat_map_has_a_bar_with_its_label_beside_it() -> Result<(), FigureError> {
        let map = |value: f64| {
            HeatMap::new("z / mm", ColourMap::Diverging, [0.0, 1.0], [0.0, 1.0], move |i, _| {
                value * i as f64
            })
        };
        let ground = |value| Panel::new("t / s", "place ξ").heat_map(map(value));
        let svg = Figure::new(500, 300).panel(ground(2.0)).panel(panel()).columns(2).svg()?;
        for (text, times) in [("z\u{a0}/\u{a0}mm", 1), ("place ξ", 1), ("no data", 0)] {
            assert_eq!(svg.matches(text).count(), times, "{text}");
        }
        // 48 shades in the bar, and two rows of two cells.
        let tiles = svg.matches("<rect").count();
        assert!(tiles >= 52, "{tiles}");
        let nothing = Figure::new(500, 300).panel(ground(f64::NAN)).svg()?;
        assert!(nothing.contains("z\u{a0}/\u{a0}mm"));
        Ok(())
    }

    #[test]
    fn no_data_is_no_error() -> Result<(), FigureError> {
        let nothing = Panel::new("x / m", "y / m").log_x().line(
            "",
            Colour::Blue,
            [(f64::NAN, 1.0), (-1.0, 1.0)],
        );
        assert!(Figure::new(400, 300).panel(nothing).svg()?.contains("no data"));
        Figure::new(400, 300).svg().map(|_| ())
    }
}
