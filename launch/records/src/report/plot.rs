//! Elements of figures: colours, axes and marks. `draw.rs` renders them as SVG.

use plotters::style::RGBColor;
use std::ops::Range;

/// Text and axes. The report replaces it by the text colour of the page.
pub const INK: RGBColor = RGBColor(0x1F, 0x23, 0x28);
/// Grid lines. The report replaces it by the grid colour of the page.
pub const GRID: RGBColor = RGBColor(0xE1, 0xE5, 0xEA);
/// Left foot and leg.
pub const LEFT: RGBColor = RGBColor(0x2F, 0x81, 0xD6);
/// Right foot and leg.
pub const RIGHT: RGBColor = RGBColor(0xE0, 0x6C, 0x1F);
/// Centre of mass.
pub const COM: RGBColor = RGBColor(0x8E, 0x5B, 0xD6);
/// Zero-moment point.
pub const ZMP: RGBColor = RGBColor(0xD0, 0x3D, 0x78);
/// Other quantities.
pub const GREEN: RGBColor = RGBColor(0x1F, 0x9D, 0x76);
/// References and background.
pub const GREY: RGBColor = RGBColor(0x8B, 0x94, 0x9E);

/// Opacity of an area behind lines.
pub const FAINT: f64 = 0.13;

/// Format of the tick labels of an axis.
#[derive(Clone, Copy)]
pub enum Ticks {
    /// Decimal numbers.
    Plain,
    /// Powers of ten; the coordinates are decimal logarithms.
    Powers,
    /// No axis.
    None,
}

/// One axis.
pub struct PlotAxis {
    /// Quantity and unit.
    pub label: String,
    /// Limits.
    pub range: Range<f64>,
    /// Format of the tick labels.
    pub ticks: Ticks,
}

/// The frame of a figure.
pub struct Frame {
    /// Title.
    pub title: String,
    /// Height [px]. The width is always 560 px.
    pub height: u32,
    /// Horizontal axis.
    pub x: PlotAxis,
    /// Vertical axis.
    pub y: PlotAxis,
}

/// A graphical element in the coordinates of the axes.
pub struct Mark {
    pub(super) shape: MarkShape,
    pub(super) colour: RGBColor,
    pub(super) opacity: f64,
    pub(super) label: Option<&'static str>,
}

/// Shape of a mark, with sizes in px.
pub(super) enum MarkShape {
    Line(Vec<(f64, f64)>, f64),
    Dashes(Vec<(f64, f64)>),
    Dots(Vec<(f64, f64)>, f64),
    Rings(Vec<(f64, f64)>, f64),
    Area(Vec<(f64, f64)>),
    Text((f64, f64), String),
    Note((f64, f64), String),
}

impl PlotAxis {
    /// An axis with decimal numbers.
    pub fn new(label: impl Into<String>, range: Range<f64>) -> Self {
        PlotAxis { label: label.into(), range, ticks: Ticks::Plain }
    }

    /// An axis of decimal logarithms.
    pub fn powers(label: impl Into<String>, range: Range<f64>) -> Self {
        PlotAxis { label: label.into(), range, ticks: Ticks::Powers }
    }

    /// An axis that is not drawn.
    pub fn hidden(range: Range<f64>) -> Self {
        PlotAxis { label: String::new(), range, ticks: Ticks::None }
    }
}

impl Mark {
    fn new(shape: MarkShape, colour: RGBColor) -> Self {
        Mark { shape, colour, opacity: 1.0, label: None }
    }

    /// A line through the points, interrupted at non-finite points.
    pub fn line(points: Vec<(f64, f64)>, colour: RGBColor) -> Self {
        Self::new(MarkShape::Line(points, 1.6), colour)
    }

    /// A thin line.
    pub fn thin(points: Vec<(f64, f64)>, colour: RGBColor) -> Self {
        Self::new(MarkShape::Line(points, 0.9), colour)
    }

    /// A dashed line.
    pub fn dashes(points: Vec<(f64, f64)>, colour: RGBColor) -> Self {
        Self::new(MarkShape::Dashes(points), colour)
    }

    /// Filled circles of a radius [px].
    pub fn dots(points: Vec<(f64, f64)>, radius: f64, colour: RGBColor) -> Self {
        Self::new(MarkShape::Dots(points, radius), colour)
    }

    /// Open circles of a radius [px].
    pub fn rings(points: Vec<(f64, f64)>, radius: f64, colour: RGBColor) -> Self {
        Self::new(MarkShape::Rings(points, radius), colour)
    }

    /// A filled polygon.
    pub fn area(points: Vec<(f64, f64)>, colour: RGBColor) -> Self {
        Self::new(MarkShape::Area(points), colour)
    }

    /// Small text, centred above a point.
    pub fn text(at: (f64, f64), text: String) -> Self {
        Self::new(MarkShape::Text(at, text), INK)
    }

    /// Small coloured text to the right of a point.
    pub fn note(at: (f64, f64), text: String, colour: RGBColor) -> Self {
        Self::new(MarkShape::Note(at, text), colour)
    }

    /// Sets the opacity.
    pub fn faint(mut self, opacity: f64) -> Self {
        self.opacity = opacity;
        self
    }

    /// Adds the mark to the legend.
    pub fn label(mut self, label: &'static str) -> Self {
        self.name(label);
        self
    }

    /// As [`Mark::label`], in place.
    pub fn name(&mut self, label: &'static str) {
        self.label = Some(label);
    }
}

/// The range of the values, at least `min_width` wide, extended on both sides by the fraction `margin`.
pub fn padded_range(values: impl IntoIterator<Item = f64>, margin: f64, min_width: f64) -> Range<f64> {
    let (low, high) = (values.into_iter().filter(|value| value.is_finite()))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if low > high {
        return 0.0..1.0;
    }
    let width = (high - low).max(min_width) * (1.0 + 2.0 * margin);
    (low + high - width) / 2.0..(low + high + width) / 2.0
}

/// Text escaped for XML and HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
