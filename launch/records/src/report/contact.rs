//! How well the contact problems were solved.

use super::draw::plot;
use super::figure::{Figure, FigurePanel};
use super::plot::{Axis, COM, Frame, GREEN, GREY, LEFT, Mark, RIGHT};
use crate::analysis::{Histogram, RunAnalysis};
use plotters::style::RGBColor;

/// Histograms of residuals, energy gain and pivots.
pub fn figure(analysis: &RunAnalysis) -> Figure {
    let distributions = &analysis.distributions;
    Figure {
        title: "Contact residuals",
        caption: "How far each control period's worst contact solution is from the conditions (17)-(22), relative to the \
                  step's own scale, whether the impulse ever raised the energy, and the pivots it took: everything \
                  belongs at rounding error, grey bars are exact zeros.",
        panels: vec![
            FigurePanel::new(
                "residual-natural-map",
                powers("Natural-map residual", "relative residual", &distributions.natural_map, -10.0, LEFT),
            ),
            FigurePanel::new(
                "residual-signorini",
                powers("Signorini residual", "relative residual", &distributions.signorini, -10.0, RIGHT),
            ),
            FigurePanel::new(
                "energy-gain",
                powers("Energy above free motion", "energy gain [J]", &distributions.energy_gain, -10.0, GREEN),
            ),
            FigurePanel::new("pivots", pivots(&distributions.pivots)),
        ],
    }
}

/// Bars over the powers of ten, from wherever they begin to at least `end`; zeros stand at the left edge.
fn powers(title: &str, label: &'static str, histogram: &Histogram, end: f64, colour: RGBColor) -> String {
    let bars = histogram.bars(4);
    let low = bars.first().map_or(-18.0, |bar| bar.0.floor()).min(-17.0) - 1.0;
    let high = bars.last().map_or(end, |bar| (bar.0 + 0.25).ceil()).max(end);
    let mut marks: Vec<Mark> = bars.iter().map(|&(from, count)| bar(from, 0.25, count, colour)).collect();
    if histogram.zeros > 0 {
        marks.push(bar(low, 0.5, histogram.zeros, GREY));
    }
    let most = bars.iter().map(|bar| bar.1).chain([histogram.zeros, 1]).max().unwrap_or(1);
    let zeros = 100.0 * histogram.zeros as f64 / histogram.total().max(1) as f64;
    let frame = Frame {
        title: format!("{title}: {} periods, {zeros:.0} % zero", histogram.total()),
        height: 300,
        x: Axis::powers(label, low..high),
        y: count_axis(most),
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
        x: Axis::new("pivots", -0.6..last.max(5) as f64 + 0.6),
        y: count_axis(counts.iter().copied().max().unwrap_or(1)),
    };
    plot(&frame, &marks)
}

/// Lowest end of the bars: half an event.
const FLOOR: f64 = -0.3;

/// A logarithmic axis of counts.
pub fn count_axis(most: u64) -> Axis {
    Axis::powers("control periods", FLOOR..(most.max(1) as f64).log10().max(1.0) + 0.25)
}

/// One bar against [`count_axis`].
pub fn bar(from: f64, width: f64, count: u64, colour: RGBColor) -> Mark {
    let (to, top) = (from + 0.92 * width, (count.max(1) as f64).log10().max(FLOOR + 0.35));
    Mark::area(vec![(from, FLOOR), (to, FLOOR), (to, top), (from, top)], colour)
}
