//! The drawings: distributions of durations. Quantities that are compared share a drawing.

use super::carrier::Carrier;
use super::lines::Wake;
use super::paced;
use super::results::{Results, micros};
use super::spread::Spread;
use super::walk;
use messages::port::Waiting;
use plotters::style::RGBColor;
use records::report::draw::plot;
use records::report::plot::{COM, Frame, GREEN, GREY, LEFT, Mark, PlotAxis, RIGHT, ZMP};

/// Bins per power of ten.
const BINS: f64 = 20.0;
/// Smallest share of samples in the drawing: one in a million.
const LEAST: f64 = -6.0;

/// Section and metric of a series, and its label.
type SeriesKey = (&'static str, &'static str, &'static str);

/// Several series in one frame.
struct Drawing {
    name: &'static str,
    title: &'static str,
    parts: Vec<SeriesKey>,
}

fn drawings() -> Vec<Drawing> {
    let trips = |carriers: &[Carrier]| carriers.iter().map(|c| (c.name(), "round trip", c.name())).collect();
    let spinning = [
        Carrier::Lines(Wake::Spin),
        Carrier::Bare { ours: false },
        Carrier::Port(Waiting::Spin),
        Carrier::Port(Waiting::Hybrid),
        Carrier::Unix { spins: true },
        Carrier::Udp { spins: true },
    ];
    let blocking = [
        Carrier::Lines(Wake::Futex),
        Carrier::Port(Waiting::Event),
        Carrier::Unix { spins: false },
        Carrier::Udp { spins: false },
    ];
    let walks = walk::WAYS.map(|(waiting, section)| {
        let name = match waiting {
            Waiting::Spin => "spin",
            Waiting::Hybrid => "hybrid",
            Waiting::Event => "event",
        };
        (section, "whole period", name)
    });
    let wake = |section| vec![(section, paced::FLOOR, "host floor"), (section, "wake", "wake")];
    vec![
        Drawing { name: "trip-spinning", title: "Round trip, spinning", parts: trips(&spinning) },
        Drawing { name: "trip-blocking", title: "Round trip, blocking", parts: trips(&blocking) },
        Drawing { name: "walk-lockstep", title: "Control period of the walk in lockstep", parts: walks.to_vec() },
        Drawing { name: "wake-link", title: "Wake-up at 1 kHz, no plant", parts: wake(paced::LINK) },
        Drawing { name: "wake-walk", title: "Wake-up at 1 kHz, walk", parts: wake(paced::WALK) },
        Drawing {
            name: "answer-realtime",
            title: "Sensors to command at 1 kHz",
            parts: vec![
                (paced::LINK, "sensors to command", "no plant"),
                (paced::WALK, "sensors to command", "walk"),
                (paced::WALK, "plant computes", "walk, plant computes"),
            ],
        },
    ]
}

/// Names of all drawings.
pub fn names() -> impl Iterator<Item = &'static str> {
    drawings().into_iter().map(|drawing| drawing.name)
}

/// Each drawing with its file name.
pub fn all(results: &Results) -> Vec<(&'static str, String)> {
    drawings().iter().filter_map(|drawing| Some((drawing.name, draw(drawing, results)?))).collect()
}

/// `None` without samples.
fn draw(drawing: &Drawing, results: &Results) -> Option<String> {
    let colours = [GREY, LEFT, RIGHT, GREEN, COM, ZMP];
    let found = |&(section, metric, name): &SeriesKey| Some((name, results.spread(section, metric)?));
    let series: Vec<(&'static str, &Spread)> =
        drawing.parts.iter().filter_map(found).filter(|(_, spread)| spread.samples() > 0).collect();
    let ends = series.iter().flat_map(|(_, spread)| [spread.quantile(0.0), spread.quantile(1.0)]);
    let (low, high) = ends.fold((u64::MAX, 0), |(low, high), ns| (low.min(ns), high.max(ns)));
    // Histograms count nanoseconds, the axis shows microseconds.
    let decade = |ns: u64| (ns.max(1) as f64).log10() - 3.0;
    let mut marks: Vec<Mark> =
        series.iter().zip(colours).map(|((name, spread), colour)| outline(spread, colour).label(name)).collect();
    for ((_, spread), colour) in series.iter().zip(colours) {
        let median = decade(spread.quantile(0.5));
        marks.push(Mark::dashes(vec![(median, LEAST), (median, 0.3)], colour).faint(0.6));
    }
    let (first, last) = (series.first()?, series.last()?);
    let title = match series.len() {
        2 => {
            format!("{}: median {}, {} µs", drawing.title, micros(first.1.quantile(0.5)), micros(last.1.quantile(0.5)))
        }
        _ => drawing.title.into(),
    };
    let frame = Frame {
        title,
        height: 340,
        x: PlotAxis::powers("time [µs]", (decade(low) - 0.1).floor()..(decade(high) + 0.1).ceil()),
        y: PlotAxis::powers("share of samples", LEAST..0.3),
    };
    Some(plot(&frame, &marks))
}

/// The histogram as the outline of its bars.
fn outline(spread: &Spread, colour: RGBColor) -> Mark {
    let mut line: Vec<(f64, f64)> = Vec::new();
    for (edge, share) in spread.bins(BINS) {
        let (from, to, height) = (edge - 3.0, edge - 3.0 + 1.0 / BINS, share.log10().max(LEAST));
        if line.last().is_none_or(|last| last.0 < from - 1e-9) {
            line.extend(line.last().map(|last| (last.0, LEAST)));
            line.push((from, LEAST));
        }
        line.extend([(from, height), (to, height)]);
    }
    line.extend(line.last().map(|last| (last.0, LEAST)));
    Mark::line(line, colour)
}
