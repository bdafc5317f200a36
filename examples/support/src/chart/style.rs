//! Colours, strokes and symbols.

/// A colour of Okabe and Ito's palette, whose members stay apart for colour-blind readers, and a grey.
///
/// Source: M. Okabe, K. Ito, "Color Universal Design" (2008), <https://jfly.uni-koeln.de/color/>. Their yellow is left
/// out: a thin yellow line is lost on white paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colour {
    /// Blue, the first choice.
    Blue,
    /// Orange, the second.
    Orange,
    /// Bluish green.
    Green,
    /// Reddish purple.
    Purple,
    /// Sky blue.
    Sky,
    /// Vermilion.
    Vermilion,
    /// Black.
    Black,
    /// Grey, for what stands in the background.
    Grey,
}

/// How a line is interrupted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dash {
    /// Not at all.
    Solid,
    /// Long strokes.
    Dashed,
    /// Short strokes.
    Dotted,
}

/// How a line is drawn. A bare [`Colour`] is a solid line of the default width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Colour.
    pub colour: Colour,
    /// Dash.
    pub dash: Dash,
    /// Width / px.
    pub width: f64,
}

/// The shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// A filled circle.
    Disc,
    /// A filled square.
    Square,
    /// A filled triangle.
    Triangle,
    /// A filled diamond.
    Diamond,
}

/// How points are drawn. A bare [`Colour`] is a disc of the default size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Symbol {
    /// Colour.
    pub colour: Colour,
    /// Shape.
    pub marker: Marker,
    /// Diameter / px.
    pub size: f64,
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
    /// The stroke of the `index`-th of many series: the colours in turn, first solid, then dashed, then dotted.
    pub fn nth(index: usize) -> Stroke {
        let dash = [Dash::Solid, Dash::Dashed, Dash::Dotted][index / Colour::ORDER.len() % 3];
        Stroke { dash, ..Colour::ORDER[index % Colour::ORDER.len()].into() }
    }

    /// The same stroke, `width` px wide.
    pub fn width(self, width: f64) -> Stroke {
        Stroke { width, ..self }
    }
}

impl Symbol {
    /// The symbol of the `index`-th of many series, of the same colour as [`Stroke::nth`].
    pub fn nth(index: usize) -> Symbol {
        let marker = [Marker::Disc, Marker::Square, Marker::Triangle, Marker::Diamond][index % 4];
        Stroke::nth(index).colour.marked(marker)
    }

    /// The same symbol, `size` px across.
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
