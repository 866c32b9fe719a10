//! Accuracy of the solutions of the contact problems.

use super::draw::plot;
use super::figure::{Figure, FigurePanel};
use super::plot::{COM, Frame, GREEN, GREY, LEFT, Mark, PlotAxis, RIGHT};
use crate::analysis::{Histogram, RunAnalysis};
use plotters::style::RGBColor;

/// Histograms of residuals, energy gain and pivots.
pub fn figure(analysis: &RunAnalysis) -> Figure {
    let distributions = &analysis.distributions;
    Figure {
        title: "Contact residuals",
        caption: "Residuals of the conditions (17)-(22) for the worst contact solution in each control period, relative to \
                  the scale of the step; the energy that the impulse added; and the number of pivots. Residuals and energy \
                  should be at rounding error. Grey bars count exact zeros.",
        panels: vec![
            FigurePanel::new(
                "residual-natural-map",
                powers("Natural-map residual", "relative residual", &distributions.natural_map, LEFT),
            ),
            FigurePanel::new(
                "residual-signorini",
                powers("Signorini residual", "relative residual", &distributions.signorini, RIGHT),
            ),
            FigurePanel::new(
                "energy-gain",
                powers("Energy above free motion", "energy gain [J]", &distributions.energy_gain, GREEN),
            ),
            FigurePanel::new("pivots", pivots(&distributions.pivots)),
        ],
    }
}

/// Bars per decade of the histograms.
const BARS_PER_DECADE: usize = 4;
/// Decimal logarithm up to which the axes reach at least: a solution to rounding error lies well below.
const AXIS_END: f64 = -10.0;

/// A histogram on a logarithmic axis that reaches at least to [`AXIS_END`]. The bar of the zeros is at the left edge.
fn powers(title: &str, label: &'static str, histogram: &Histogram, colour: RGBColor) -> String {
    let bars = histogram.bars(BARS_PER_DECADE);
    let width = 1.0 / BARS_PER_DECADE as f64;
    let low = bars.first().map_or(-18.0, |bar| bar.0.floor()).min(-17.0) - 1.0;
    let high = bars.last().map_or(AXIS_END, |bar| (bar.0 + width).ceil()).max(AXIS_END);
    let mut marks: Vec<Mark> = bars.iter().map(|&(from, count)| bar(from, width, count, colour)).collect();
    if histogram.zeros > 0 {
        marks.push(bar(low, 0.5, histogram.zeros, GREY));
    }
    let greatest_count = bars.iter().map(|bar| bar.1).chain([histogram.zeros, 1]).max().unwrap_or(1);
    let zeros = 100.0 * histogram.zeros as f64 / histogram.total().max(1) as f64;
    let frame = Frame {
        title: format!("{title}: {} periods, {zeros:.0} % zero", histogram.total()),
        height: 300,
        x: PlotAxis::powers(label, low..high),
        y: count_axis(greatest_count),
    };
    plot(&frame, &marks)
}

fn pivots(counts: &[u64]) -> String {
    let last = counts.iter().rposition(|count| *count > 0).unwrap_or(0);
    let marks: Vec<Mark> = (counts.iter().enumerate())
        .filter(|(_, count)| **count > 0)
        .map(|(pivots, count)| bar(pivots as f64 - 0.4, 0.8, *count, COM))
        .collect();
    let frame = Frame {
        title: "Pivots of the longest solution in a period".into(),
        height: 300,
        x: PlotAxis::new("pivots", -0.6..last.max(5) as f64 + 0.6),
        y: count_axis(counts.iter().copied().max().unwrap_or(1)),
    };
    plot(&frame, &marks)
}

/// Decimal logarithm of the lower end of the bars: half a count.
const FLOOR: f64 = -0.3;

/// A logarithmic axis of counts.
pub fn count_axis(greatest_count: u64) -> PlotAxis {
    PlotAxis::powers("control periods", FLOOR..(greatest_count.max(1) as f64).log10().max(1.0) + 0.25)
}

/// A bar on [`count_axis`].
pub fn bar(from: f64, width: f64, count: u64, colour: RGBColor) -> Mark {
    let (to, top) = (from + 0.92 * width, (count.max(1) as f64).log10().max(FLOOR + 0.35));
    Mark::area(vec![(from, FLOOR), (to, FLOOR), (to, top), (from, top)], colour)
}
