//! Draws a figure with plotters as SVG.
//!
//! The SVG backend of plotters takes whole pixels, too coarse for print: everything is drawn ten
//! times larger, and [`finish`] scales the document back. It also adds what plotters lacks: a
//! title, dashes and subscripts. Without font libraries the width of a text is estimated.

use std::collections::HashSet;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::Result;
use super::axis::Axis;
use super::chart::{
    AxisChoice, Dash, Figure, HeatMap, Look, Marker, Panel, Reference, Stroke, Symbol,
};
use super::lines::{Point, pieces};

/// Drawing units per pixel.
const FINE: f64 = 10.0;

/// A wider figure is drawn this wide [px] and enlarged. Across a page of 170 mm the smallest text
/// is then 7.2 pt high, and a line of 1.5 px is 1 pt wide.
const CANVAS: f64 = 720.0;

/// Sans-serif fonts by decreasing preference; plotters divides their size by a factor.
const FONTS: &str = "Helvetica, Arial, DejaVu Sans, sans-serif";
const FONT_FACTOR: f64 = 1.24;

/// Sizes of labels and of ticks, and the height of a line [px].
const LABEL: f64 = 12.0;
const SMALL: f64 = 11.0;
const LINE: f64 = 17.0;
const TICK: f64 = 4.0;

/// Around the figure, and beside a panel without a colour bar and with it [px].
const EDGE: f64 = 8.0;
const BAR: f64 = 76.0;

const GRID: RGBColor = RGBColor(228, 228, 228);
const SHADE: RGBColor = RGBColor(236, 236, 236);
const REFERENCE: RGBColor = RGBColor(90, 90, 90);
const FRAME: RGBColor = RGBColor(60, 60, 60);

/// Opacities that [`finish`] turns into dashes.
const DASHED: f64 = 0.9921;
const DOTTED: f64 = 0.9922;

/// The diverging map from its lower end to its upper one (ColorBrewer, RdBu).
const BLUE_WHITE_RED: [RGBColor; 5] = [
    RGBColor(33, 102, 172),
    RGBColor(146, 197, 222),
    RGBColor(247, 247, 247),
    RGBColor(244, 165, 130),
    RGBColor(178, 24, 43),
];

type Area<'a, 'b> = DrawingArea<SVGBackend<'a>, Shift>;

/// A figure as the text of an SVG document.
pub(super) fn svg(figure: &Figure) -> Result<String> {
    let mut text = String::new();
    {
        let (width, height) = canvas(figure);
        let size = (px(width) as u32, px(height) as u32);
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&WHITE)?;
        draw(figure, &root)?;
        root.present()?;
    }
    Ok(finish(&text, figure))
}

/// Width and height of what is drawn, before it is enlarged to the figure [px].
fn canvas(figure: &Figure) -> (f64, f64) {
    let (width, height) = (f64::from(figure.width), f64::from(figure.height));
    let enlarged = (width / CANVAS).max(1.0);
    (width / enlarged, height / enlarged)
}

/// Scales the document back and adds a title, dashes and subscripts.
fn finish(text: &str, figure: &Figure) -> String {
    let Figure { width, height, title, .. } = figure;
    let title = title.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let drawn = canvas(figure);
    let fine = format!("width=\"{}\" height=\"{}\"", px(drawn.0), px(drawn.1));
    let scaled =
        format!("role=\"img\" stroke-linejoin=\"round\" width=\"{width}\" height=\"{height}\"");
    let text =
        text.replacen(&fine, &scaled, 1).replacen('\n', &format!("\n<title>{title}</title>\n"), 1);
    let dash = |width: &str| format!(" stroke-linecap=\"butt\" stroke-dasharray=\"{width}\"");
    text.replace(" opacity=\"1\"", "")
        .replace(" stroke=\"none\"", "")
        .replace(&format!(" opacity=\"{DASHED}\""), &dash("65 35"))
        .replace(&format!(" opacity=\"{DOTTED}\""), &dash("18 22"))
        .lines()
        .map(|line| if line.starts_with('<') { line.to_owned() } else { subscripts(line) })
        .collect::<Vec<_>>()
        .join("\n")
}

/// `F_z` and `μ_{max}` with lowered, smaller letters.
fn subscripts(text: &str) -> String {
    const PLAIN: char = '\u{1}';
    let text = text.replace(r"\_", "\u{1}");
    let mut parts = text.split('_');
    let mut set = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (low, rest) = match part.strip_prefix('{').and_then(|part| part.split_once('}')) {
            Some(braced) => braced,
            None => part.split_at(part.chars().next().map_or(0, char::len_utf8)),
        };
        set += &format!("<tspan dy=\"0.3em\" font-size=\"75%\">{low}</tspan>");
        // Some readers drop a blank at the begin of a `tspan`.
        let (gap, rest) = match rest.strip_prefix(' ') {
            Some(rest) => (" dx=\"0.3em\"", rest),
            None => ("", rest),
        };
        if !rest.is_empty() {
            set += &format!("<tspan{gap} dy=\"-0.225em\">{rest}</tspan>");
        }
    }
    set.replace(PLAIN, "_")
}

/// An upper estimate of the width of a text [px].
fn width(text: &str, size: f64) -> f64 {
    let advance = |c: char| match c {
        '_' | '{' | '}' => 0.0,
        'i' | 'j' | 'l' | ' ' | '.' | ',' | 'I' | '·' | '\'' => 0.31,
        '/' | '-' | 'f' | ':' | ';' | '|' | '(' | ')' | '[' | ']' | 't' | 'r' | '°' => 0.4,
        'm' | 'w' | 'M' | 'W' | '%' => 0.95,
        '−' | '×' | '+' | '=' | '<' | '>' | '±' | '≤' | '≥' | '≈' | '→' => 0.8,
        'A'..='Z' | 'Δ' | 'Σ' | 'Ω' => 0.72,
        _ => 0.6,
    };
    size * text.chars().map(advance).sum::<f64>()
}

fn px(length: f64) -> i32 {
    (length * FINE).round() as i32
}

fn font(size: f64, colour: RGBColor, h_pos: HPos, v_pos: VPos) -> TextStyle<'static> {
    let font = (FONTS, size * FINE * FONT_FACTOR).into_font();
    font.color(&colour).pos(Pos { h_pos, v_pos })
}

fn thin(colour: RGBColor, width: f64) -> ShapeStyle {
    colour.stroke_width(px(width) as u32)
}

/// A panel with its axes and the space around its plot area [px].
struct Placed<'a> {
    panel: &'a Panel,
    title: String,
    x: Axis,
    y: Axis,
    legend: Vec<Vec<Entry>>,
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

impl Placed<'_> {
    /// Widens one axis until a unit is as long on x as on y, on a plot area of this size.
    fn equalise(&mut self, (width, height): Point) {
        let (x, y) = (self.x.end - self.x.start, self.y.end - self.y.start);
        let unit = (x / width).max(y / height);
        self.x.widen(unit * width);
        self.y.widen(unit * height);
    }
}

fn draw(figure: &Figure, root: &Area<'_, '_>) -> Result<()> {
    let (full_width, full_height) = canvas(figure);
    let columns = figure.columns.min(figure.panels.len().max(1));
    let rows = figure.panels.len().div_ceil(columns).max(1);
    let shared = figure.panels.iter().filter(|panel| !panel.own_legend);
    let legend = rows_of(entries(shared), full_width - 2.0 * EDGE - 56.0);
    let notes = wrapped(&figure.note, LABEL, full_width - 2.0 * EDGE - 56.0);
    let note = LINE * notes.len() as f64;
    let head = EDGE + LINE * legend.len() as f64;
    let (cell_width, cell_height) = (
        (full_width - 2.0 * EDGE) / columns as f64,
        (full_height - EDGE - head - note) / rows as f64,
    );
    let mut placed = figure
        .panels
        .iter()
        .enumerate()
        .map(|(index, panel)| {
            let title = lettered(&panel.title, index, figure.panels.len());
            place(panel, title, (cell_width, cell_height))
                .map_err(|problem| format!("panel {}: {problem}", index + 1))
        })
        .collect::<std::result::Result<Vec<_>, _>>()?;
    // All plot areas have one size, so that axes stand in line.
    let most = |side: fn(&Placed<'_>) -> f64| placed.iter().map(side).fold(0.0, f64::max);
    let (left, right, top) = (most(|p| p.left), most(|p| p.right), most(|p| p.top));
    placed.iter_mut().for_each(|panel| {
        (panel.left, panel.right, panel.top) = (left, right, top);
        let size = (cell_width - left - right, cell_height - top - panel.bottom);
        if panel.panel.equal_scales {
            panel.equalise(size);
        }
    });
    let left = EDGE + left;
    for (row, entries) in legend.iter().enumerate() {
        draw_entries(root, entries, (left, EDGE + LINE * (row as f64 + 0.5)))?;
    }
    let style = font(LABEL, BLACK, HPos::Left, VPos::Center);
    for (row, text) in notes.iter().enumerate() {
        root.draw_text(text, &style, (px(left), px(head + LINE * (row as f64 + 0.5))))?;
    }
    for (index, panel) in placed.into_iter().enumerate() {
        let corner = (
            EDGE + cell_width * (index % columns) as f64,
            head + note + cell_height * (index / columns) as f64,
        );
        let (x, y) = (px(corner.0), px(corner.1));
        let (w, h) = (px(cell_width) as u32, px(cell_height) as u32);
        draw_panel(&root.clone().shrink((x, y), (w, h)), panel)?;
    }
    Ok(())
}

/// `(b) title`, where there are several panels.
fn lettered(title: &str, index: usize, count: usize) -> String {
    match u8::try_from(index).ok().and_then(|index| b'a'.checked_add(index)) {
        Some(letter @ b'a'..=b'z') if count > 1 => {
            format!("({}) {title}", char::from(letter)).trim_end().to_owned()
        }
        _ => title.to_owned(),
    }
}

/// Chooses the axes of a panel and the space around them.
fn place(
    panel: &Panel,
    title: String,
    (width_of_cell, height): Point,
) -> std::result::Result<Placed<'_>, String> {
    let values = |coordinate: fn(&(f64, f64)) -> f64| {
        panel.series.iter().flat_map(move |series| series.points.iter().map(coordinate))
    };
    let map_x = panel.heat_map.iter().flat_map(|map| map.x.iter().copied());
    let map_y = panel.heat_map.iter().flat_map(|map| map.y.iter().copied());
    let references = |horizontal: bool| {
        panel.references.iter().filter_map(move |reference| match reference {
            Reference::Horizontal(y, _) if horizontal => Some(*y),
            Reference::Vertical(x, _) if !horizontal => Some(*x),
            _ => None,
        })
    };
    let axis = |name: &str, choice: &AxisChoice, fit: &dyn Fn() -> Axis| match &choice.range {
        None => Ok(fit()),
        Some(range) => Axis::fixed(range, choice.logarithmic).map_err(|rule| {
            format!("{name} axis from {} to {}: {rule}", range.start(), range.end())
        }),
    };
    // A line over time starts and ends at the edge; everything else has air around it.
    let rises = panel.series.iter().all(|series| {
        let finite = series.points.iter().filter(|p| p.0.is_finite());
        matches!(series.look, Look::Line(_)) && finite.is_sorted_by(|p, q| p.0 <= q.0)
    });
    let mapped = panel.heat_map.is_some();
    let margin = if rises || mapped { 0.0 } else { 0.04 };
    let x = axis("x", &panel.x, &|| {
        let all = values(|point| point.0).chain(references(false)).chain(map_x.clone());
        Axis::fit(all, panel.x.logarithmic, margin)
    })?;
    let y = axis("y", &panel.y, &|| {
        let points = panel.series.iter().flat_map(|series| &series.points);
        let seen = points.filter(|point| x.shows(point.0)).map(|point| point.1);
        let all = seen.chain(references(true)).chain(map_y.clone());
        Axis::fit(all, panel.y.logarithmic, if mapped { 0.0 } else { 0.06 })
    })?;
    let right = if mapped { BAR } else { 16.0 };
    let legend = if panel.own_legend { entries(std::iter::once(panel)) } else { Vec::new() };
    let legend = rows_of(legend, width_of_cell - 56.0);
    let head = if title.is_empty() { 0.0 } else { LINE };
    let top = 10.0 + head + LINE * legend.len() as f64;
    let bottom = TICK + 2.0 * LINE + 4.0;
    let y = y.with_ticks(((height - top - bottom) / 24.0) as usize);
    let widest = y.labels().iter().map(|label| width(label, SMALL)).fold(0.0, f64::max);
    let left = widest + 2.0 * TICK + LINE + 6.0;
    let (plot_width, plot_height) = (width_of_cell - left - right, height - top - bottom);
    if plot_width < 40.0 || plot_height < 40.0 {
        return Err(format!(
            "{plot_width:.0} × {plot_height:.0} px are left for the plot; enlarge it"
        ));
    }
    let x = x.with_ticks((plot_width / 52.0) as usize);
    Ok(Placed { panel, title, x, y, legend, left, top, right, bottom })
}

/// Draws from the back to the front: shades, grid, reference lines, series, frame, words.
fn draw_panel(cell: &Area<'_, '_>, placed: Placed<'_>) -> Result<()> {
    let Placed { panel, title, x, y, legend, left, top, right, bottom } = placed;
    let (cell_width, _) = cell.dim_in_pixel();
    let mut builder = ChartBuilder::on(cell);
    builder.margin_top(px(top)).margin_right(px(right));
    builder.x_label_area_size(px(bottom)).y_label_area_size(px(left));
    let mut chart = builder.build_cartesian_2d(x.clone(), y.clone())?;
    let plot = chart.plotting_area().strip_coord_spec();
    let (plot_width, plot_height) = plot.dim_in_pixel();
    let size = (f64::from(plot_width), f64::from(plot_height));
    let at_x = |value: f64| x.fraction(value).map(|place| place * size.0);
    let at_y = |value: f64| y.fraction(value).map(|place| (1.0 - place) * size.1);
    let corners = [(0, 0), (plot_width as i32, plot_height as i32)];

    for (_, range) in &panel.shades {
        let edge = |value: f64| at_x(value.clamp(x.start, x.end)).unwrap_or(0.0).round() as i32;
        let corners = [(edge(*range.start()), 0), (edge(*range.end()), corners[1].1)];
        plot.draw(&Rectangle::new(corners, SHADE.filled()))?;
    }
    if let Some(map) = &panel.heat_map {
        draw_heat_map(cell, &plot, map, (at_x, at_y), (px(top), cell_width as i32 - px(right)))?;
    }
    let description = font(LABEL, BLACK, HPos::Center, VPos::Center);
    let tick = font(SMALL, BLACK, HPos::Center, VPos::Center);
    chart
        .configure_mesh()
        .x_desc(panel.x.label.as_str())
        .y_desc(panel.y.label.as_str())
        .axis_desc_style(description)
        .label_style(tick)
        .axis_style(thin(FRAME, 0.9))
        .bold_line_style(thin(GRID, 0.6))
        .light_line_style(TRANSPARENT)
        .set_all_tick_mark_size(px(TICK))
        .draw()?;

    let mut labels = Vec::new();
    for reference in &panel.references {
        let line = match reference {
            Reference::Horizontal(value, label) if y.shows(*value) => at_y(*value).map(|y| {
                let end = (size.0 - FINE * 4.0, y - 0.5 * FINE * LINE);
                ([(0, y as i32), (corners[1].0, y as i32)], label, end, HPos::Right)
            }),
            Reference::Vertical(value, label) if x.shows(*value) => at_x(*value).map(|x| {
                let fits = x + FINE * (width(label, SMALL) + 6.0) < size.0;
                let (side, anchor) = if fits { (4.0, HPos::Left) } else { (-4.0, HPos::Right) };
                let end = (x + FINE * side, 0.6 * FINE * LINE);
                ([(x as i32, 0), (x as i32, corners[1].1)], label, end, anchor)
            }),
            _ => None,
        };
        if let Some((line, label, place, anchor)) = line {
            plot.draw(&PathElement::new(line.to_vec(), thin(REFERENCE, 0.8)))?;
            labels.push((label, place, anchor));
        }
    }
    let mut drawn = panel.heat_map.is_some();
    for series in &panel.series {
        let points = series.points.iter().map(|&(x, y)| Some((at_x(x)?, at_y(y)?)));
        match series.look {
            Look::Line(stroke) => {
                for piece in pieces(points, size) {
                    drawn = true;
                    plot.draw(&PathElement::new(piece, line_style(stroke)))?;
                }
            }
            Look::Points(symbol) => {
                // Of symbols that nearly cover each other one is enough.
                let cell = (symbol.size * FINE / 3.0).max(FINE);
                let mut taken = HashSet::new();
                for (x, y) in points.flatten() {
                    let inside = (0.0..=size.0).contains(&x) && (0.0..=size.1).contains(&y);
                    if inside && taken.insert(((x / cell) as i32, (y / cell) as i32)) {
                        drawn = true;
                        draw_symbol(&plot, (x, y), symbol)?;
                    }
                }
            }
            Look::Shade => {}
        }
    }
    plot.draw(&Rectangle::new(corners, thin(FRAME, 0.9)))?;
    for (label, (x, y), h_pos) in labels.into_iter().filter(|(label, ..)| !label.is_empty()) {
        let style = font(SMALL, REFERENCE, h_pos, VPos::Center);
        plot.draw_text(label, &style, (x as i32, y as i32))?;
    }
    if !drawn {
        let style = font(LABEL, REFERENCE, HPos::Center, VPos::Center);
        plot.draw_text("no data", &style, ((0.5 * size.0) as i32, (0.5 * size.1) as i32))?;
    }
    if !title.is_empty() {
        let style = font(LABEL, BLACK, HPos::Left, VPos::Center);
        cell.draw_text(&title, &style, (px(left), px(4.0 + 0.5 * LINE)))?;
    }
    let first = top - 6.0 - LINE * legend.len() as f64;
    for (row, entries) in legend.iter().enumerate() {
        draw_entries(cell, entries, (left, first + LINE * (row as f64 + 0.5)))?;
    }
    Ok(())
}

fn line_style(stroke: Stroke) -> ShapeStyle {
    let (r, g, b) = stroke.colour.rgb();
    let opacity = match stroke.dash {
        Dash::Solid => 1.0,
        Dash::Dashed => DASHED,
        Dash::Dotted => DOTTED,
    };
    RGBAColor(r, g, b, opacity).stroke_width(px(stroke.width) as u32)
}

/// A symbol; all shapes cover about the same area.
fn draw_symbol(area: &Area<'_, '_>, (x, y): Point, symbol: Symbol) -> Result<()> {
    let (r, g, b) = symbol.colour.rgb();
    let (style, radius) = (RGBColor(r, g, b).filled(), 0.5 * symbol.size * FINE);
    let corners: &[Point] = match symbol.marker {
        Marker::Disc => {
            let place = (x.round() as i32, y.round() as i32);
            return Ok(area.draw(&Circle::new(place, radius.round() as i32, style))?);
        }
        Marker::Square => &[(-0.89, -0.89), (0.89, -0.89), (0.89, 0.89), (-0.89, 0.89)],
        Marker::Triangle => &[(0.0, -1.35), (1.17, 0.68), (-1.17, 0.68)],
        Marker::Diamond => &[(0.0, -1.3), (1.2, 0.0), (0.0, 1.3), (-1.2, 0.0)],
    };
    let corner = |(dx, dy): &Point| ((x + radius * dx) as i32, (y + radius * dy) as i32);
    Ok(area.draw(&Polygon::new(corners.iter().map(corner).collect::<Vec<_>>(), style))?)
}

/// Colours the ground and draws the bar beside it, between `top` and the plot's lower edge.
fn draw_heat_map(
    cell: &Area<'_, '_>,
    plot: &Area<'_, '_>,
    map: &HeatMap,
    (at_x, at_y): (impl Fn(f64) -> Option<f64>, impl Fn(f64) -> Option<f64>),
    (top, right): (i32, i32),
) -> Result<()> {
    let (width, height) = plot.dim_in_pixel();
    let most = map.values.iter().filter(|z| z.is_finite()).fold(0.0, |m: f64, z| m.max(z.abs()));
    let most = if most > 0.0 { most } else { 1.0 };
    // Without negative values the bar begins at zero.
    let (least, first) = if map.values.iter().any(|z| *z < 0.0) { (-most, -16) } else { (0.0, 0) };
    // Whole shades, so that neighbours of one colour become one rectangle.
    let shade = |z: f64| (16.0 * z / most).round() as i32;
    let colour = |shade: i32| blend(0.5 + f64::from(shade) / 32.0).filled();
    let columns = cells(&map.x, at_x, f64::from(width));
    for (row, y0, y1) in cells(&map.y, at_y, f64::from(height)) {
        let shades = columns.iter().filter_map(|&(column, x0, x1)| {
            let z = map.values.get(row * map.x.len() + column).filter(|z| z.is_finite())?;
            Some((shade(*z), x0, x1))
        });
        let shades: Vec<_> = shades.collect();
        for run in shades.chunk_by(|a, b| a.0 == b.0 && a.2 == b.1) {
            // Neighbours overlap, or the paper would shine through between them.
            let (x0, x1) = (run[0].1, (run[run.len() - 1].2 + 6).min(width as i32));
            let (upper, lower) = ((y0.min(y1) - 6).max(0), y0.max(y1));
            plot.draw(&Rectangle::new([(x0, upper), (x1, lower)], colour(run[0].0)))?;
        }
    }
    let scale = Axis::fixed(&(least..=most), false)?.with_ticks((height / 360) as usize);
    let bar = cell.clone().shrink((right + px(12.0), top), (px(BAR - 12.0) as u32, height));
    let mut builder = ChartBuilder::on(&bar);
    builder.set_label_area_size(LabelAreaPosition::Right, px(BAR - 24.0));
    let mut chart = builder.build_cartesian_2d(Axis::fixed(&(0.0..=1.0), false)?, scale)?;
    let step = most / 16.0;
    chart.draw_series((first..=16).map(|k| {
        let edge = |offset: f64| ((f64::from(k) + offset) * step).clamp(least, most);
        Rectangle::new([(0.0, edge(-0.5)), (1.0, edge(0.6))], colour(k))
    }))?;
    chart
        .configure_mesh()
        .disable_mesh()
        .disable_x_axis()
        .y_desc(map.label.as_str())
        .axis_desc_style(font(LABEL, BLACK, HPos::Center, VPos::Center))
        .label_style(font(SMALL, BLACK, HPos::Center, VPos::Center))
        .axis_style(thin(FRAME, 0.9))
        .set_all_tick_mark_size(px(TICK))
        .draw()?;
    let (w, h) = chart.plotting_area().dim_in_pixel();
    let frame = Rectangle::new([(0, 0), (w as i32, h as i32)], thin(FRAME, 0.9));
    Ok(chart.plotting_area().strip_coord_spec().draw(&frame)?)
}

/// The colour of the map at a place from 0 to 1.
fn blend(place: f64) -> RGBColor {
    let place = place.clamp(0.0, 1.0) * (BLUE_WHITE_RED.len() - 1) as f64;
    let below = (place as usize).min(BLUE_WHITE_RED.len() - 2);
    let (a, b, part) = (BLUE_WHITE_RED[below], BLUE_WHITE_RED[below + 1], place - below as f64);
    let mix = |a: u8, b: u8| (f64::from(a) + part * (f64::from(b) - f64::from(a))).round() as u8;
    RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

/// Of every place the cell around it, halfway to its neighbours. Cells too narrow to be seen give
/// way to the first of those that stand together.
fn cells(places: &[f64], at: impl Fn(f64) -> Option<f64>, length: f64) -> Vec<(usize, i32, i32)> {
    let narrowest = (4.0 * FINE) as i32;
    let mut kept: Vec<(usize, i32, i32)> = Vec::new();
    for (i, &place) in places.iter().enumerate() {
        let edge = |j: Option<&f64>| {
            let middle = j.map_or(place, |neighbour| 0.5 * (neighbour + place));
            at(middle).map(|edge| edge.clamp(0.0, length).round() as i32)
        };
        let low = edge(i.checked_sub(1).and_then(|j| places.get(j)));
        let (Some(low), Some(high)) = (low, edge(places.get(i + 1))) else { continue };
        match kept.last_mut() {
            Some(last) if (last.2 - last.1).abs() < narrowest => last.2 = high,
            _ => kept.push((i, low, high)),
        }
    }
    kept
}

/// An entry of a legend.
#[derive(Debug, Clone)]
struct Entry {
    name: String,
    looks: Vec<Look>,
}

impl Entry {
    /// Length of the sample, and width with the name and the gap behind it [px].
    fn widths(&self) -> (f64, f64) {
        let line = self.looks.iter().any(|look| !matches!(look, Look::Points(_)));
        let sample = if line { 28.0 } else { 10.0 };
        (sample, sample + 6.0 + width(&self.name, LABEL) + 14.0)
    }
}

/// Every name once, with the looks of its series; series without any point have no entry.
fn entries<'a>(panels: impl Iterator<Item = &'a Panel>) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    for panel in panels {
        let shades = panel.shades.iter().map(|(name, _)| (name, Look::Shade));
        let finite = |point: &(f64, f64)| point.0.is_finite() && point.1.is_finite();
        let series = panel.series.iter().filter(|series| series.points.iter().any(finite));
        let series = series.map(|series| (&series.name, series.look));
        for (name, look) in series.chain(shades).filter(|(name, _)| !name.is_empty()) {
            match entries.iter_mut().find(|entry| entry.name == *name) {
                Some(entry) if entry.looks.contains(&look) => {}
                Some(entry) => entry.looks.push(look),
                None => entries.push(Entry { name: name.clone(), looks: vec![look] }),
            }
        }
    }
    entries
}

/// Breaks a legend into rows.
fn rows_of(entries: Vec<Entry>, limit: f64) -> Vec<Vec<Entry>> {
    let mut rows: Vec<Vec<Entry>> = Vec::new();
    let mut used = f64::INFINITY;
    for entry in entries {
        let (_, width) = entry.widths();
        match rows.last_mut() {
            Some(row) if used + width <= limit => row.push(entry),
            _ => {
                used = 0.0;
                rows.push(vec![entry]);
            }
        }
        used += width;
    }
    rows
}

/// Breaks a text into lines.
fn wrapped(text: &str, size: f64, limit: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if width(line, size) + width(word, size) < limit => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Draws a row of a legend, its middle line at the height of `(x, y)` [px].
fn draw_entries(area: &Area<'_, '_>, entries: &[Entry], (mut x, y): Point) -> Result<()> {
    for entry in entries {
        let (sample, width) = entry.widths();
        for look in &entry.looks {
            match *look {
                Look::Line(stroke) => {
                    let line = vec![(px(x), px(y)), (px(x + sample), px(y))];
                    area.draw(&PathElement::new(line, line_style(stroke)))?;
                }
                Look::Points(symbol) => {
                    draw_symbol(area, (FINE * (x + 0.5 * sample), FINE * y), symbol)?;
                }
                Look::Shade => {
                    let corners = [(px(x), px(y - 5.0)), (px(x + sample), px(y + 5.0))];
                    area.draw(&Rectangle::new(corners, SHADE.filled()))?;
                }
            }
        }
        let style = font(LABEL, BLACK, HPos::Left, VPos::Center);
        area.draw_text(&entry.name, &style, (px(x + sample + 6.0), px(y)))?;
        x += width;
    }
    Ok(())
}
