//! One chart of a figure.

use std::borrow::Borrow;
use std::ops::RangeInclusive;

use super::heat_map::HeatMap;
use super::scale::Scale;
use super::style::{Stroke, Symbol};

/// Free space around the data, as a fraction of the range. A line over time starts and ends at the edge instead.
const MARGIN_X: f64 = 0.04;
const MARGIN_Y: f64 = 0.06;

/// A chart: two axes, the series drawn in their order, and reference lines.
///
/// NaN and infinite values break a line, as do zero and negative values on a logarithmic axis; of points they are left out.
#[derive(Debug, Clone)]
#[must_use = "a panel is drawn by a `Figure`"]
pub struct Panel {
    pub(super) title: String,
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) series: Vec<Series>,
    pub(super) references: Vec<Reference>,
    pub(super) heat_map: Option<HeatMap>,
}

#[derive(Debug, Clone, Default)]
pub(super) struct Axis {
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
}

/// A thin line across the panel.
#[derive(Debug, Clone)]
pub(super) enum Reference {
    Horizontal(f64, String),
    Vertical(f64, String),
}

impl Panel {
    /// An empty chart. Labels carry the unit: `"time t / s"`.
    pub fn new(x_label: impl Into<String>, y_label: impl Into<String>) -> Panel {
        Panel {
            title: String::new(),
            x: Axis { label: x_label.into(), ..Axis::default() },
            y: Axis { label: y_label.into(), ..Axis::default() },
            series: Vec::new(),
            references: Vec::new(),
            heat_map: None,
        }
    }

    /// Sets the line above the chart: `"(a) stick-slip"`.
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

    /// Adds a line. Series of the same name and look share one entry of the legend; an empty name has none.
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

    /// Colours the ground by a quantity over x and y, and tells beside the panel what the colours mean.
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

    /// The scale of the x axis, or what is wrong with its range.
    pub(super) fn x_scale(&self) -> Result<Scale, &'static str> {
        if let Some(range) = &self.x.range {
            return Scale::fixed(range, self.x.logarithmic);
        }
        let rises = |series: &Series| {
            let line = matches!(series.look, Look::Line(_));
            line && series.points.iter().filter(|p| p.0.is_finite()).is_sorted_by(|p, q| p.0 <= q.0)
        };
        let margin = if self.series.iter().all(rises) { 0.0 } else { MARGIN_X };
        let references = self.references.iter().filter_map(|reference| match reference {
            Reference::Vertical(x, _) => Some(*x),
            Reference::Horizontal(..) => None,
        });
        let values = self.series.iter().flat_map(|series| &series.points).map(|point| point.0);
        let map = self.heat_map.iter().flat_map(|map| map.ends()[0]);
        let margin = if self.heat_map.is_some() { 0.0 } else { margin };
        Ok(Scale::fit(values.chain(references).chain(map), self.x.logarithmic, margin))
    }

    /// The scale of the y axis beside `x`, or what is wrong with its range.
    pub(super) fn y_scale(&self, x: &Scale) -> Result<Scale, &'static str> {
        if let Some(range) = &self.y.range {
            return Scale::fixed(range, self.y.logarithmic);
        }
        let references = self.references.iter().filter_map(|reference| match reference {
            Reference::Horizontal(y, _) => Some(*y),
            Reference::Vertical(..) => None,
        });
        let points = self.series.iter().flat_map(|series| &series.points);
        let values = points.filter(|point| x.shows(point.0)).map(|point| point.1);
        let map = self.heat_map.iter().flat_map(|map| map.ends()[1]);
        let margin = if self.heat_map.is_some() { 0.0 } else { MARGIN_Y };
        Ok(Scale::fit(values.chain(references).chain(map), self.y.logarithmic, margin))
    }
}
