//! The strip above the panels that names every series once.

use super::canvas::{Anchor, Canvas, DrawError, Grey};
use super::layout::{EDGE, LABEL};
use super::panel::{Look, Panel};
use super::style::{Stroke, Symbol};
use super::text::width;

/// Length of a line sample / px: three dashes.
const SAMPLE: f64 = 30.0;
/// From the sample to its name / px.
const GAP: f64 = 7.0;
/// From a name to the next sample / px.
const BETWEEN: f64 = 20.0;
/// Height of a row / px.
const ROW: f64 = 18.0;

/// All entries, arranged in rows.
pub(super) struct Legend {
    entries: Vec<Entry>,
    /// Widths.
    columns: Vec<f64>,
    rows: usize,
}

struct Entry {
    name: String,
    line: Option<Stroke>,
    points: Option<Symbol>,
}

impl Entry {
    /// Takes a look in, unless another of its kind is there already.
    fn join(&mut self, look: Look) -> bool {
        match look {
            Look::Line(stroke) => *self.line.get_or_insert(stroke) == stroke,
            Look::Points(symbol) => *self.points.get_or_insert(symbol) == symbol,
        }
    }
}

impl Legend {
    /// The legend of all panels for a paper `paper` px wide.
    pub(super) fn new(panels: &[Panel], paper: f64) -> Legend {
        let mut entries: Vec<Entry> = Vec::new();
        for series in
            panels.iter().flat_map(|panel| &panel.series).filter(|series| !series.name.is_empty())
        {
            if !entries.iter_mut().any(|entry| entry.name == series.name && entry.join(series.look))
            {
                let mut entry = Entry { name: series.name.clone(), line: None, points: None };
                entry.join(series.look);
                entries.push(entry);
            }
        }
        let room: Vec<f64> = entries
            .iter()
            .map(|entry| SAMPLE + GAP + width(&entry.name, LABEL) + BETWEEN)
            .collect();
        // Entries run down the columns. As few rows as let all columns fit, at worst one entry a row.
        let columns_of = |rows: usize| -> Vec<f64> {
            room.chunks(rows).map(|column| column.iter().copied().fold(0.0, f64::max)).collect()
        };
        let fits =
            |&rows: &usize| columns_of(rows).iter().sum::<f64>() - BETWEEN <= paper - 2.0 * EDGE;
        let rows = (1..entries.len()).find(fits).unwrap_or(entries.len().max(1));
        let columns = columns_of(rows);
        Legend { entries, columns, rows }
    }

    /// The height it takes / px.
    pub(super) fn height(&self) -> f64 {
        if self.entries.is_empty() { 0.0 } else { self.rows as f64 * ROW + 4.0 }
    }

    /// Draws it below `top` in the middle between `left` and `right`.
    pub(super) fn draw(
        &self,
        canvas: &mut Canvas<'_>,
        left: f64,
        right: f64,
        top: f64,
    ) -> Result<(), DrawError> {
        let total = self.columns.iter().sum::<f64>() - BETWEEN;
        let start = (0.5 * (left + right - total)).min(right - total).max(EDGE);
        for (i, entry) in self.entries.iter().enumerate() {
            let (column, row) = (i / self.rows, i % self.rows);
            let x = start + self.columns[..column].iter().sum::<f64>();
            let y = top + (row as f64 + 0.5) * ROW;
            if let Some(stroke) = entry.line {
                canvas.line(&[vec![(x, y), (x + SAMPLE, y)]], stroke)?;
            }
            if let Some(symbol) = entry.points {
                canvas.symbol((x + 0.5 * SAMPLE, y), symbol)?;
            }
            canvas.text(&entry.name, (x + SAMPLE + GAP, y), Anchor::Left, LABEL, Grey(0))?;
        }
        Ok(())
    }
}
