//! A drawing of a curve: this simulator and, where measured, MuJoCo, each with its exponent.

use super::peers;
use super::points::{Point, exponent, of};
use super::scenes::GrowthCurve;
use crate::chart::csv::OURS;
use records::report::draw::plot;
use records::report::plot::{Frame, GREY, LEFT, Mark, PlotAxis};

/// Share of the axis that is kept free for names.
const MARGIN: f64 = 0.45;
/// Share of the height that a line of text takes.
const LINE: f64 = 0.065;
/// Space above and below the curves, in powers of ten.
const EDGE: f64 = 0.3;

/// The drawing: time of a step over the growing quantity. Both axes are logarithmic, except that of contacts, which may be 0.
pub fn draw(curve: &GrowthCurve, points: &[Point]) -> String {
    let linear = curve.name == "contacts";
    let place = |point: &&Point| (if linear { point.x } else { point.x.log10() }, point.us.log10());
    let (mut marks, mut ends) = (Vec::new(), Vec::new());
    let (mut left, mut right, mut low, mut high) = (f64::MAX, f64::MIN, f64::MAX, f64::MIN);
    for (engine, name, colour) in [(peers::NAME, peers::NAME, GREY), (OURS, "this simulator", LEFT)] {
        let own = of(points, curve, engine);
        let places: Vec<_> = own.iter().map(place).collect();
        for (x, y) in &places {
            (left, right, low, high) = (left.min(*x), right.max(*x), low.min(*y), high.max(*y));
        }
        let power = exponent(&own, curve.from).map_or(String::new(), |p| format!(" ~ n^{p:.2}"));
        ends.extend(places.last().map(|end| (end.1, format!("{name}{power}"), colour)));
        marks.extend([Mark::line(places.clone(), colour), Mark::dots(places, 3.0, colour)]);
    }
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut free = f64::MIN;
    for (end, name, colour) in ends {
        let height = f64::max(end, free);
        free = height + LINE * (high - low + 2.0 * EDGE);
        marks.push(Mark::note((right + 0.03 * (right - left), height), name, colour));
    }
    let x = left - 0.03 * (right - left)..right + MARGIN * (right - left);
    let frame = Frame {
        title: curve.title.into(),
        height: 300,
        x: if linear { PlotAxis::new(curve.axis, x) } else { PlotAxis::powers(curve.axis, x) },
        y: PlotAxis::powers("time of a step [µs]", low - EDGE..high + EDGE),
    };
    plot(&frame, &marks)
}
