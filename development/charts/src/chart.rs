//! What a figure shows, and our style sheet: colours, strokes and symbols.

use std::borrow::Borrow;
use std::fs;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use super::{Result, at, create_folder, draw};

/// A colour of Okabe and Ito's palette, whose members stay apart for colour-blind readers, or grey.
///
/// Source: M. Okabe, K. Ito, "Color Universal Design" (2008), <https://jfly.uni-koeln.de/color/>.
/// Their yellow is left out: a thin yellow line is lost on white paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colour {
    Blue,
    Orange,
    Green,
    Purple,
    Sky,
    Vermilion,
    Black,
    Grey,
}

/// How a line is interrupted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dash {
    Solid,
    Dashed,
    Dotted,
}

/// How a line is drawn. A bare [`Colour`] is a solid line 1.5 px wide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    pub colour: Colour,
    pub(super) dash: Dash,
    pub(super) width: f64,
}

/// The shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    Disc,
    Square,
    Triangle,
    Diamond,
}

/// How points are drawn. A bare [`Colour`] is a disc 6 px across.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Symbol {
    pub(super) colour: Colour,
    pub(super) marker: Marker,
    pub(super) size: f64,
}

impl Colour {
    /// The order in which series take their colours.
    const ORDER: [Colour; 7] = [
        Colour::Blue,
        Colour::Orange,
        Colour::Green,
        Colour::Purple,
        Colour::Sky,
        Colour::Vermilion,
        Colour::Black,
    ];

    /// A dashed line of this colour.
    pub fn dashed(self) -> Stroke {
        Stroke { dash: Dash::Dashed, ..self.into() }
    }

    /// A dotted line of this colour.
    pub fn dotted(self) -> Stroke {
        Stroke { dash: Dash::Dotted, ..self.into() }
    }

    /// A solid line of this colour, `width` px wide.
    pub fn width(self, width: f64) -> Stroke {
        Stroke::from(self).width(width)
    }

    /// A point of this colour and shape.
    pub fn marked(self, marker: Marker) -> Symbol {
        Symbol { marker, ..self.into() }
    }

    pub(super) fn rgb(self) -> (u8, u8, u8) {
        match self {
            Colour::Blue => (0, 114, 178),
            Colour::Orange => (230, 159, 0),
            Colour::Green => (0, 158, 115),
            Colour::Purple => (204, 121, 167),
            Colour::Sky => (86, 180, 233),
            Colour::Vermilion => (213, 94, 0),
            Colour::Black => (0, 0, 0),
            Colour::Grey => (120, 120, 120),
        }
    }
}

impl Stroke {
    /// The stroke of the `index`-th of many series: every colour solid, then dashed, then dotted.
    pub fn nth(index: usize) -> Stroke {
        let count = Colour::ORDER.len();
        let dash = [Dash::Solid, Dash::Dashed, Dash::Dotted][index / count % 3];
        Stroke { dash, ..Colour::ORDER[index % count].into() }
    }

    /// This stroke, `width` px wide.
    pub fn width(self, width: f64) -> Stroke {
        Stroke { width, ..self }
    }
}

impl Symbol {
    /// This symbol, `size` px across.
    pub fn size(self, size: f64) -> Symbol {
        Symbol { size, ..self }
    }
}

impl From<Colour> for Stroke {
    fn from(colour: Colour) -> Stroke {
        Stroke { colour, dash: Dash::Solid, width: 1.5 }
    }
}

impl From<Colour> for Symbol {
    fn from(colour: Colour) -> Symbol {
        Symbol { colour, marker: Marker::Disc, size: 6.0 }
    }
}

/// Values on a grid of x and y as colours: blue below zero, white at zero, red above.
#[derive(Debug, Clone)]
pub struct HeatMap {
    pub(super) label: String,
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    pub(super) values: Vec<f64>,
}

impl HeatMap {
    /// A map of `value(i, j)` at the rising places `x[i]`, `y[j]`. The label of the colour bar
    /// carries the unit: `"deflection z (mm)"`. NaN stays white.
    pub fn new(
        label: impl Into<String>,
        x: impl Into<Vec<f64>>,
        y: impl Into<Vec<f64>>,
        value: impl Fn(usize, usize) -> f64,
    ) -> HeatMap {
        let (x, y, value) = (x.into(), y.into(), &value);
        let values = (0..y.len()).flat_map(|j| (0..x.len()).map(move |i| value(i, j))).collect();
        HeatMap { label: label.into(), x, y, values }
    }
}

/// A chart: two axes, series drawn in their order, reference lines and shades.
///
/// Non-finite values break a line, as do zero and negative values on a logarithmic axis; of points
/// they are left out. In every text `F_z` and `μ_{max}` set a subscript, and `\_` is a plain `_`.
#[derive(Debug, Clone)]
#[must_use = "a panel is drawn by a `Figure`"]
pub struct Panel {
    pub(super) title: String,
    pub(super) x: AxisChoice,
    pub(super) y: AxisChoice,
    pub(super) series: Vec<Series>,
    pub(super) references: Vec<Reference>,
    pub(super) shades: Vec<(String, RangeInclusive<f64>)>,
    pub(super) heat_map: Option<HeatMap>,
    pub(super) own_legend: bool,
    pub(super) equal_scales: bool,
}

#[derive(Debug, Clone, Default)]
pub(super) struct AxisChoice {
    pub(super) label: String,
    pub(super) logarithmic: bool,
    pub(super) range: Option<RangeInclusive<f64>>,
}

#[derive(Debug, Clone)]
pub(super) struct Series {
    pub(super) name: String,
    pub(super) look: Look,
    pub(super) points: Vec<(f64, f64)>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Look {
    Line(Stroke),
    Points(Symbol),
    Shade,
}

/// A thin line across the panel.
#[derive(Debug, Clone)]
pub(super) enum Reference {
    Horizontal(f64, String),
    Vertical(f64, String),
}

impl Panel {
    /// An empty chart. Labels carry the unit: `"time t (s)"`.
    pub fn new(x_label: impl Into<String>, y_label: impl Into<String>) -> Panel {
        Panel {
            title: String::new(),
            x: AxisChoice { label: x_label.into(), ..AxisChoice::default() },
            y: AxisChoice { label: y_label.into(), ..AxisChoice::default() },
            series: Vec::new(),
            references: Vec::new(),
            shades: Vec::new(),
            heat_map: None,
            own_legend: false,
            equal_scales: false,
        }
    }

    /// Sets the line above the chart; of several panels each gets a letter before it: `(a) title`.
    pub fn title(mut self, title: impl Into<String>) -> Panel {
        self.title = title.into();
        self
    }

    /// Makes the x axis logarithmic.
    pub fn log_x(mut self) -> Panel {
        self.x.logarithmic = true;
        self
    }

    /// Makes the y axis logarithmic.
    pub fn log_y(mut self) -> Panel {
        self.y.logarithmic = true;
        self
    }

    /// Fixes the ends of the x axis; without it all data are shown.
    pub fn x_range(mut self, range: RangeInclusive<f64>) -> Panel {
        self.x.range = Some(range);
        self
    }

    /// Fixes the ends of the y axis; without it all data inside the x range are shown.
    pub fn y_range(mut self, range: RangeInclusive<f64>) -> Panel {
        self.y.range = Some(range);
        self
    }

    /// Adds a line. Series of one name share an entry of the legend; an empty name has none.
    pub fn line(
        self,
        name: impl Into<String>,
        stroke: impl Into<Stroke>,
        points: impl IntoIterator<Item = impl Borrow<(f64, f64)>>,
    ) -> Panel {
        self.with(name.into(), Look::Line(stroke.into()), points)
    }

    /// Adds points. With the name of a line they join it in the legend.
    pub fn points(
        self,
        name: impl Into<String>,
        symbol: impl Into<Symbol>,
        points: impl IntoIterator<Item = impl Borrow<(f64, f64)>>,
    ) -> Panel {
        self.with(name.into(), Look::Points(symbol.into()), points)
    }

    /// Adds a line with a symbol at every point.
    pub fn marked_line(
        self,
        name: &str,
        stroke: impl Into<Stroke>,
        symbol: impl Into<Symbol>,
        points: impl IntoIterator<Item = impl Borrow<(f64, f64)>>,
    ) -> Panel {
        let points: Vec<_> = points.into_iter().map(|point| *point.borrow()).collect();
        self.line(name, stroke, &points).points(name, symbol, &points)
    }

    fn with(
        mut self,
        name: String,
        look: Look,
        points: impl IntoIterator<Item = impl Borrow<(f64, f64)>>,
    ) -> Panel {
        let points = points.into_iter().map(|point| *point.borrow()).collect();
        self.series.push(Series { name, look, points });
        self
    }

    /// Shades the ground over a range of x.
    pub fn shade(mut self, name: impl Into<String>, range: RangeInclusive<f64>) -> Panel {
        self.shades.push((name.into(), range));
        self
    }

    /// Colours the ground by a quantity over x and y, with a bar of the colours beside the panel.
    pub fn heat_map(mut self, map: HeatMap) -> Panel {
        self.heat_map = Some(map);
        self
    }

    /// Adds a reference line at `y`, with a label of a few characters or none.
    pub fn horizontal(mut self, y: f64, label: impl Into<String>) -> Panel {
        self.references.push(Reference::Horizontal(y, label.into()));
        self
    }

    /// Adds a reference line at `x`, with a label of a few characters or none.
    pub fn vertical(mut self, x: f64, label: impl Into<String>) -> Panel {
        self.references.push(Reference::Vertical(x, label.into()));
        self
    }

    /// Draws a unit of y as long as a unit of x: a circle is a circle. For linear axes.
    pub fn equal_scales(mut self) -> Panel {
        self.equal_scales = true;
        self
    }

    /// Names the series above this panel instead of in the legend of the figure.
    pub fn own_legend(mut self) -> Panel {
        self.own_legend = true;
        self
    }
}

/// Panels in a grid, filled row by row, under one legend that names every series once.
#[derive(Debug, Clone)]
#[must_use = "a figure is written by `save`"]
pub struct Figure {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) columns: usize,
    pub(super) panels: Vec<Panel>,
    pub(super) title: String,
    pub(super) note: String,
}

impl Figure {
    /// An empty figure of `width` × `height` px with a single column. Text is 12 px high, and
    /// larger in a figure wider than 720 px: printed across 170 mm it has at least 7 pt.
    pub fn new(width: u32, height: u32) -> Figure {
        let (title, note) = (String::new(), String::new());
        Figure { width, height, columns: 1, panels: Vec::new(), title, note }
    }

    /// Says what is shown, for screen readers and in the tooltip; without it the file's name does.
    pub fn title(mut self, title: impl Into<String>) -> Figure {
        self.title = title.into();
        self
    }

    /// Adds lines below the legend that explain a mark.
    pub fn note(mut self, note: impl Into<String>) -> Figure {
        self.note = note.into();
        self
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
    pub fn save(mut self, folder: impl AsRef<Path>, name: &str) -> Result<PathBuf> {
        if self.title.is_empty() {
            self.title = name.replace('_', " ");
        }
        let svg = draw::svg(&self)?;
        create_folder(folder.as_ref())?;
        let path = folder.as_ref().join(format!("{name}.svg"));
        fs::write(&path, svg).map_err(at("write", &path))?;
        Ok(path)
    }
}
