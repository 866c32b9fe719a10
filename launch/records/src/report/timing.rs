//! Computing time and waiting time.

use super::contact::{bar, count_axis};
use super::draw::plot;
use super::figure::{Figure, FigurePanel};
use super::plot::{Frame, GREEN, INK, LEFT, Mark, PlotAxis};
use crate::analysis::{Histogram, RunAnalysis};
use plotters::style::RGBColor;

/// Resolution of the histograms.
const BARS_PER_DECADE: usize = 15;

/// Histograms of the computing and waiting time per control period.
pub fn figure(analysis: &RunAnalysis) -> Figure {
    let distributions = &analysis.distributions;
    let mut panels = vec![FigurePanel::new("timing-plant", panel("Plant", &distributions.plant, LEFT))];
    if distributions.wait.total() > distributions.wait.zeros {
        panels.push(FigurePanel::new("timing-wait", panel("Wait for the command", &distributions.wait, GREEN)));
    }
    Figure {
        title: "Timing",
        caption: "Computing time of the plant per control period, and the time that it waited for the command. The wait includes \
                  the controller and, if that is a separate process, both transfers over shared memory. Dashed: median and \
                  99th percentile.",
        panels,
    }
}

fn panel(title: &str, histogram: &Histogram, colour: RGBColor) -> String {
    // The histogram is in nanoseconds, the axis in microseconds.
    let bars = histogram.bars(BARS_PER_DECADE).into_iter().map(|(from, count)| (from - 3.0, count));
    let bars: Vec<(f64, u64)> = bars.collect();
    let low = bars.first().map_or(0.0, |bar| bar.0.floor());
    let high = bars.last().map_or(1.0, |bar| (bar.0 + 0.07).ceil()).max(low + 2.0);
    let axis = count_axis(bars.iter().map(|bar| bar.1).max().unwrap_or(1));
    let mut marks: Vec<Mark> =
        bars.iter().map(|&(from, count)| bar(from, 1.0 / BARS_PER_DECADE as f64, count, colour)).collect();
    let (median, tail) = (histogram.quantile(0.5) * 1e-3, histogram.quantile(0.99) * 1e-3);
    for quantile in [median, tail].into_iter().filter(|quantile| *quantile > 0.0) {
        let position = quantile.log10();
        marks.push(Mark::dashes(vec![(position, axis.range.start), (position, axis.range.end)], INK));
    }
    let frame = Frame {
        title: format!("{title}: median {median:.1} µs, 99 % {tail:.1} µs"),
        height: 300,
        x: PlotAxis::powers("time per control period [µs]", low..high),
        y: axis,
    };
    plot(&frame, &marks)
}
