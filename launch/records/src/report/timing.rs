//! Where the time went.

use super::contact::{bar, count_axis};
use super::draw::plot;
use super::figure::{Figure, FigurePanel};
use super::plot::{Axis, Frame, GREEN, INK, LEFT, Mark};
use crate::analysis::{Histogram, RunAnalysis};
use plotters::style::RGBColor;

/// Histograms of computing and waiting per control period.
pub fn figure(analysis: &RunAnalysis) -> Figure {
    let distributions = &analysis.distributions;
    let mut panels = vec![FigurePanel::new("timing-plant", panel("Plant", &distributions.plant, LEFT))];
    if distributions.wait.total() > distributions.wait.zeros {
        panels.push(FigurePanel::new("timing-wait", panel("Wait for the command", &distributions.wait, GREEN)));
    }
    Figure {
        title: "Timing",
        caption: "Time that the plant needed for one control period and, with a controller in a process of its own, time \
                  that it waited for the answer (its tick and both ways over shared memory); dashed: median and 99th \
                  percentile.",
        panels,
    }
}

fn panel(title: &str, histogram: &Histogram, colour: RGBColor) -> String {
    // Bins count nanoseconds, the axis shows microseconds.
    let bars: Vec<(f64, u64)> = histogram.bars(15).into_iter().map(|(from, count)| (from - 3.0, count)).collect();
    let low = bars.first().map_or(0.0, |bar| bar.0.floor());
    let high = bars.last().map_or(1.0, |bar| (bar.0 + 0.07).ceil()).max(low + 2.0);
    let axis = count_axis(bars.iter().map(|bar| bar.1).max().unwrap_or(1));
    let mut marks: Vec<Mark> = bars.iter().map(|&(from, count)| bar(from, 1.0 / 15.0, count, colour)).collect();
    let (median, tail) = (histogram.quantile(0.5) * 1e-3, histogram.quantile(0.99) * 1e-3);
    for quantile in [median, tail].into_iter().filter(|quantile| *quantile > 0.0) {
        let place = quantile.log10();
        marks.push(Mark::dashes(vec![(place, axis.range.start), (place, axis.range.end)], INK));
    }
    let frame = Frame {
        title: format!("{title}: median {median:.1} us, 99 % {tail:.1} us"),
        height: 300,
        x: Axis::powers("time per control period [us]", low..high),
        y: axis,
    };
    plot(&frame, &marks)
}
