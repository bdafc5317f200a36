//! Figures for a journal: a grid of panels with one legend, written as SVG.
//!
//! From the caller down to the ink:
//! [`figure`] and [`panel`] hold what to show, [`style`] how; [`layout`] finds the place of every panel;
//! [`scale`] maps values to lengths and [`ticks`] marks them; [`path`] cuts lines to the panel, [`thin`] leaves out
//! what would not be seen, [`dash`] dashes the rest;
//! [`heat_map`] turns a quantity over two others into colours;
//! [`labels`] names reference lines and [`legend`] the series; [`canvas`] draws, with [`text`] to guess widths.

mod canvas;
mod dash;
mod figure;
mod heat_map;
mod labels;
mod layout;
mod legend;
mod panel;
mod path;
mod scale;
mod style;
mod text;
mod thin;
mod ticks;

pub use figure::{Figure, FigureError};
pub use heat_map::{ColourMap, HeatMap};
pub use panel::Panel;
pub use style::{Colour, Dash, Marker, Stroke, Symbol};
