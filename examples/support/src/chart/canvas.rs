//! The paper. The only file that knows plotters.
//!
//! The SVG backend of plotters takes whole pixels, too coarse for print: everything is drawn [`FINE`] times larger, and
//! the header of the finished document scales it back.

use std::io;

use plotters::backend::{DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{
    FontFamily, FontStyle, FontTransform, IntoFont, RGBAColor, ShapeStyle, TextStyle,
};

use super::dash::dashes;
use super::path::Point;
use super::style::{Marker, Stroke, Symbol};

/// Drawing units per px.
const FINE: f64 = 10.0;

/// Sans-serif fonts by decreasing preference.
const FONTS: &str = "Helvetica, Arial, DejaVu Sans, sans-serif";

/// plotters divides font sizes by this.
const FONT_FACTOR: f64 = 1.24;

/// What plotters may report. Its own type has no public name; a document in memory meets no error anyway.
pub(super) type DrawError = io::Error;

/// A shade of grey: 0 is black, 255 white.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grey(pub(super) u8);

impl Grey {
    fn colour(self, opacity: f64) -> RGBAColor {
        RGBAColor(self.0, self.0, self.0, opacity)
    }
}

/// Which point of a text lies at the given place.
#[derive(Debug, Clone, Copy)]
pub(super) enum Anchor {
    Left,
    Centre,
    Right,
    /// Centred, and turned to read upwards.
    Turned,
}

/// An SVG document in the making. Lengths in px, y downwards.
pub(super) struct Canvas<'a> {
    svg: SVGBackend<'a>,
}

/// Draws a document of `width` × `height` px on white paper.
pub(super) fn document(
    width: u32,
    height: u32,
    draw: impl FnOnce(&mut Canvas<'_>) -> Result<(), DrawError>,
) -> Result<String, DrawError> {
    let mut text = String::new();
    let (fine_width, fine_height) =
        (width.saturating_mul(FINE as u32), height.saturating_mul(FINE as u32));
    let mut canvas = Canvas { svg: SVGBackend::with_string(&mut text, (fine_width, fine_height)) };
    canvas.fill((0.0, 0.0), (f64::from(width), f64::from(height)), 1.0)?;
    draw(&mut canvas)?;
    canvas.svg.present().map_err(io::Error::other)?;
    drop(canvas);
    let header = format!("width=\"{fine_width}\" height=\"{fine_height}\"");
    let scaled = format!("width=\"{width}\" height=\"{height}\" stroke-linejoin=\"round\"");
    // Full opacity is the default of SVG; written out at every dash it takes an eighth of the file.
    Ok(text.replacen(&header, &scaled, 1).replace(" opacity=\"1\"", ""))
}

impl Canvas<'_> {
    /// A white rectangle.
    pub(super) fn fill(&mut self, from: Point, to: Point, opacity: f64) -> Result<(), DrawError> {
        self.svg
            .draw_rect(fine(from), fine(to), &style(Grey(255).colour(opacity), 1.0), true)
            .map_err(io::Error::other)
    }

    /// A rectangle of one colour.
    pub(super) fn tile(
        &mut self,
        from: Point,
        to: Point,
        rgb: (u8, u8, u8),
    ) -> Result<(), DrawError> {
        self.svg
            .draw_rect(fine(from), fine(to), &style(rgba(rgb), 1.0), true)
            .map_err(io::Error::other)
    }

    /// A thin line in grey.
    pub(super) fn rule(
        &mut self,
        points: &[Point],
        grey: Grey,
        width: f64,
    ) -> Result<(), DrawError> {
        self.svg
            .draw_path(points.iter().map(|&point| fine(point)), &style(grey.colour(1.0), width))
            .map_err(io::Error::other)
    }

    /// A line in pieces; a piece of a single point becomes a dot.
    pub(super) fn line(&mut self, pieces: &[Vec<Point>], stroke: Stroke) -> Result<(), DrawError> {
        let style = style(rgba(stroke.colour.rgb()), stroke.width);
        for dash in dashes(pieces, stroke.dash, stroke.width) {
            if let [only] = dash[..] {
                let radius = (0.6 * stroke.width * FINE).round() as u32;
                self.svg
                    .draw_circle(fine(only), radius, &style.filled(), true)
                    .map_err(io::Error::other)?;
            } else {
                self.svg.draw_path(dash.into_iter().map(fine), &style).map_err(io::Error::other)?;
            }
        }
        Ok(())
    }

    /// A symbol around `(x, y)`. All shapes cover about the same area.
    pub(super) fn symbol(&mut self, (x, y): Point, symbol: Symbol) -> Result<(), DrawError> {
        let style = style(rgba(symbol.colour.rgb()), 0.0).filled();
        let radius = 0.5 * symbol.size;
        let corners: &[Point] = match symbol.marker {
            Marker::Disc => {
                return self
                    .svg
                    .draw_circle(fine((x, y)), (radius * FINE).round() as u32, &style, true)
                    .map_err(io::Error::other);
            }
            Marker::Square => &[(-0.89, -0.89), (0.89, -0.89), (0.89, 0.89), (-0.89, 0.89)],
            Marker::Triangle => &[(0.0, -1.35), (1.17, 0.68), (-1.17, 0.68)],
            Marker::Diamond => &[(0.0, -1.3), (1.2, 0.0), (0.0, 1.3), (-1.2, 0.0)],
        };
        self.svg
            .fill_polygon(
                corners.iter().map(|(dx, dy)| fine((x + radius * dx, y + radius * dy))),
                &style,
            )
            .map_err(io::Error::other)
    }

    /// A text, its middle line at the height of `at`.
    pub(super) fn text(
        &mut self,
        text: &str,
        at: Point,
        anchor: Anchor,
        size: f64,
        grey: Grey,
    ) -> Result<(), DrawError> {
        let font =
            (FontFamily::Name(FONTS), size * FINE * FONT_FACTOR, FontStyle::Normal).into_font();
        let (h_pos, font) = match anchor {
            Anchor::Left => (HPos::Left, font),
            Anchor::Centre => (HPos::Center, font),
            Anchor::Right => (HPos::Right, font),
            Anchor::Turned => (HPos::Center, font.transform(FontTransform::Rotate270)),
        };
        let colour = grey.colour(1.0);
        let style = TextStyle::from(font).color(&colour).pos(Pos { h_pos, v_pos: VPos::Center });
        self.svg.draw_text(text, &style, fine(at)).map_err(io::Error::other)
    }
}

fn fine((x, y): Point) -> (i32, i32) {
    ((x * FINE).round() as i32, (y * FINE).round() as i32)
}

fn rgba((r, g, b): (u8, u8, u8)) -> RGBAColor {
    RGBAColor(r, g, b, 1.0)
}

fn style(colour: RGBAColor, width: f64) -> ShapeStyle {
    ShapeStyle { color: colour, filled: false, stroke_width: (width * FINE).round() as u32 }
}
