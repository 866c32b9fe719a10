//! Renders axes, marks and legend as SVG with plotters, in one style for all figures.

use super::plot::{Frame, GREY, GRID, INK, Mark, MarkShape, PlotAxis, Ticks, escaped};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::error::Error;
use std::ops::Range;

/// Width of every figure [px]. It is readable on a phone.
const WIDTH: u32 = 560;
/// Scale of the drawing. plotters rounds coordinates to whole pixels, so the drawing is larger than its displayed size.
const SCALE: u32 = 4;
/// plotters' SVG backend writes 1/1.24 of the requested font size.
const FONT_CORRECTION: f64 = 1.24;

/// Size of ordinary text [px].
const TEXT_SIZE: f64 = 13.0;
/// Size of text beside marks [px].
const SMALL_TEXT_SIZE: f64 = 12.0;
/// Space for the title above the legend [px].
const TITLE_HEIGHT: f64 = 34.0;
/// Height of a row of the legend [px].
const LEGEND_ROW: f64 = 20.0;
/// Position of the first entry of a row of the legend [px].
const LEGEND_START: f64 = 12.0;
/// Width of the line of an open circle [px].
const RING: f64 = 1.3;
/// Mean width of a character of ordinary text [px].
const CHARACTER_WIDTH: f64 = 7.4;

/// Renders a figure. An error is shown as the text of the figure, so that it does not prevent the report.
pub fn plot(frame: &Frame, marks: &[Mark]) -> String {
    let mut svg = String::new();
    let result = {
        let root = SVGBackend::with_string(&mut svg, (WIDTH * SCALE, frame.height * SCALE)).into_drawing_area();
        draw(&root, frame, marks)
    };
    let title = escaped(&frame.title);
    if let Err(error) = result {
        return format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\"><text y=\"20\">{title}: {}</text></svg>",
            escaped(&error.to_string())
        );
    }
    let (wide, tall) = (WIDTH * SCALE, frame.height * SCALE);
    let drawing_size = format!("width=\"{wide}\" height=\"{tall}\"");
    let displayed_size = format!("width=\"{WIDTH}\" height=\"{}\" role=\"img\" aria-label=\"{title}\"", frame.height);
    svg.replacen(&drawing_size, &displayed_size, 1)
}

type PlotResult = Result<(), Box<dyn Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn px(pixels: f64) -> i32 {
    (pixels * f64::from(SCALE)).round() as i32
}

/// Font size for plotters.
fn font_px(size: f64) -> i32 {
    px(FONT_CORRECTION * size)
}

fn font(size: f64, colour: RGBColor) -> TextStyle<'static> {
    ("sans-serif", font_px(size)).into_font().color(&colour)
}

fn draw(root: &Area, frame: &Frame, marks: &[Mark]) -> PlotResult {
    root.fill(&WHITE)?;
    root.draw(&Text::new(
        frame.title.clone(),
        (px(10.0), px(9.0)),
        ("sans-serif", font_px(15.0), FontStyle::Bold).into_font().color(&INK),
    ))?;
    let rows = legend(root, marks)?;
    let has_no_y_axis = matches!(frame.y.ticks, Ticks::None);
    let mut chart = ChartBuilder::on(root)
        .margin_top(px(TITLE_HEIGHT + LEGEND_ROW * rows))
        .margin_right(px(24.0))
        .margin_left(px(if has_no_y_axis { 10.0 } else { 4.0 }))
        .margin_bottom(px(5.0))
        .x_label_area_size(px(if matches!(frame.x.ticks, Ticks::None) { 4.0 } else { 46.0 }))
        .y_label_area_size(px(if has_no_y_axis { 0.0 } else { 70.0 }))
        .build_cartesian_2d(drawable_range(&frame.x.range), drawable_range(&frame.y.range))?;
    mesh(&mut chart, frame)?;
    marks.iter().try_for_each(|mark| draw_mark(&mut chart, mark))
}

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

fn mesh(chart: &mut Chart, frame: &Frame) -> PlotResult {
    let (x, y) = (write_ticks(&frame.x, 8), write_ticks(&frame.y, 6));
    let mut mesh = chart.configure_mesh();
    mesh.disable_x_mesh().light_line_style(TRANSPARENT).bold_line_style(GRID.stroke_width(SCALE));
    mesh.axis_style(GREY.stroke_width(SCALE)).label_style(font(TEXT_SIZE, INK)).axis_desc_style(font(TEXT_SIZE, INK));
    mesh.x_labels(8).y_labels(6).x_desc(&frame.x.label).y_desc(&frame.y.label);
    mesh.x_label_formatter(&x).y_label_formatter(&y).set_all_tick_mark_size(px(4.0));
    if matches!(frame.x.ticks, Ticks::None) {
        mesh.disable_x_axis();
    }
    if matches!(frame.y.ticks, Ticks::None) {
        mesh.disable_y_axis().disable_y_mesh();
    }
    Ok(mesh.draw()?)
}

fn draw_mark(chart: &mut Chart, mark: &Mark) -> PlotResult {
    let colour = mark.colour.mix(mark.opacity);
    let plane = chart.plotting_area();
    match &mark.shape {
        MarkShape::Line(points, width) => {
            let style = colour.stroke_width(px(*width).unsigned_abs());
            for part in finite_segments(points) {
                plane.draw(&PathElement::new(part.to_vec(), style))?;
            }
        }
        MarkShape::Dashes(points) => {
            let style = colour.stroke_width(px(1.6).unsigned_abs());
            for part in finite_segments(points) {
                plane.draw(&DashedPathElement::new(part.to_vec(), px(6.0), px(4.0), style))?;
            }
        }
        MarkShape::Dots(points, radius) => {
            for &point in points.iter().filter(|point| is_finite(point)) {
                plane.draw(&Circle::new(point, px(*radius), colour.filled()))?;
            }
        }
        MarkShape::Rings(points, radius) => {
            for &point in points.iter().filter(|point| is_finite(point)) {
                plane.draw(&Circle::new(point, px(*radius), WHITE.filled()))?;
                plane.draw(&Circle::new(point, px(*radius), colour.stroke_width(px(RING).unsigned_abs())))?;
            }
        }
        MarkShape::Area(points) => plane.draw(&Polygon::new(points.clone(), colour.filled()))?,
        MarkShape::Text(at, text) => {
            let style = font(SMALL_TEXT_SIZE, INK).pos(Pos::new(HPos::Center, VPos::Bottom));
            plane.draw(&Text::new(text.clone(), *at, style))?;
        }
        MarkShape::Note(at, text) => {
            let style = font(SMALL_TEXT_SIZE, mark.colour).pos(Pos::new(HPos::Left, VPos::Center));
            plane.draw(&Text::new(text.clone(), *at, style))?;
        }
    }
    Ok(())
}

/// Draws the legend below the title. Returns its number of rows.
fn legend(root: &Area, marks: &[Mark]) -> Result<f64, Box<dyn Error>> {
    let (mut x, mut row) = (LEGEND_START, 0.0);
    for (mark, label) in marks.iter().filter_map(|mark| mark.label.map(|label| (mark, label))) {
        let width = 26.0 + CHARACTER_WIDTH * label.chars().count() as f64 + 14.0;
        if x + width > f64::from(WIDTH) && x > LEGEND_START {
            (x, row) = (LEGEND_START, row + 1.0);
        }
        let (y, colour) = (40.0 + LEGEND_ROW * row, mark.colour.mix(mark.opacity.max(0.35)));
        let line = |from: f64, to: f64| {
            PathElement::new(
                vec![(px(x + from), px(y)), (px(x + to), px(y))],
                colour.stroke_width(px(2.5).unsigned_abs()),
            )
        };
        match &mark.shape {
            MarkShape::Area(_) => {
                root.draw(&Rectangle::new([(px(x), px(y - 5.0)), (px(x + 18.0), px(y + 5.0))], colour.filled()))?
            }
            MarkShape::Dots(..) => root.draw(&Circle::new((px(x + 9.0), px(y)), px(4.0), colour.filled()))?,
            MarkShape::Rings(..) => {
                root.draw(&Circle::new((px(x + 9.0), px(y)), px(4.0), colour.stroke_width(px(RING).unsigned_abs())))?
            }
            MarkShape::Dashes(_) => [line(0.0, 7.0), line(11.0, 18.0)].iter().try_for_each(|dash| root.draw(dash))?,
            MarkShape::Line(..) | MarkShape::Text(..) | MarkShape::Note(..) => root.draw(&line(0.0, 18.0))?,
        }
        let style = font(TEXT_SIZE, INK).pos(Pos::new(HPos::Left, VPos::Center));
        root.draw(&Text::new(label, (px(x + 24.0), px(y)), style))?;
        x += width;
    }
    Ok(if x > LEGEND_START { row + 1.0 } else { 0.0 })
}

/// The range if it is finite and not empty, else 0 to 1.
fn drawable_range(range: &Range<f64>) -> Range<f64> {
    let finite = range.start.is_finite() && range.end.is_finite();
    if finite && range.end > range.start { range.clone() } else { 0.0..1.0 }
}

fn write_ticks(axis: &PlotAxis, labels: usize) -> impl Fn(&f64) -> String + use<> {
    let (ticks, step) =
        (axis.ticks, (drawable_range(&axis.range).end - drawable_range(&axis.range).start) / labels as f64);
    let decimals = (0.7 - step.log10()).floor().clamp(0.0, 9.0) as usize;
    move |value| match ticks {
        Ticks::Plain if value.abs() < 1e-9 * step => "0".into(),
        Ticks::Plain => format!("{value:.decimals$}"),
        Ticks::Powers if (value - value.round()).abs() > 1e-6 => between_powers(*value),
        Ticks::Powers if (-0.5..4.5).contains(value) => format!("{:.0}", 10f64.powf(*value)),
        Ticks::Powers if value.round() == -1.0 => "0.1".into(),
        Ticks::Powers => format!("1e{value:.0}"),
        Ticks::None => String::new(),
    }
}

/// Label of a tick between two powers of ten; none where it would be long.
fn between_powers(logarithm: f64) -> String {
    match logarithm.floor() {
        -1.0 => format!("{:.2}", 10f64.powf(logarithm)),
        0.0 => format!("{:.1}", 10f64.powf(logarithm)),
        1.0..=3.0 => format!("{:.0}", 10f64.powf(logarithm)),
        _ => String::new(),
    }
}

fn is_finite(point: &(f64, f64)) -> bool {
    point.0.is_finite() && point.1.is_finite()
}

/// The segments of consecutive finite points.
fn finite_segments(points: &[(f64, f64)]) -> impl Iterator<Item = &[(f64, f64)]> {
    points.split(|point| !is_finite(point)).filter(|part| part.len() > 1)
}
