//! View (i) of a scene: a curve for each method, with its name at the end.

use super::style::{CurveFamily, label};
use crate::chart::cases::ComparisonScene;
use crate::chart::csv::{Measurement, View};
use crate::chart::precision::is_hollow;
use records::report::draw::plot;
use records::report::plot::{Frame, Mark, PlotAxis};

/// An error of this size is rounding of a double.
const NOTHING: f64 = 1e-16;
/// Width of a label beside the curves, as a share of the axis.
const MARGIN: f64 = 0.62;
/// Longest label [characters]: what `MARGIN` leaves at the size of the letters.
const LABEL: usize = 24;
/// Height of a drawing, and of the plane within it [px].
const HEIGHT: [f64; 2] = [430.0, 345.0];
/// Height of a line of labels [px].
const LINE: f64 = 13.5;

/// One method in one scene, from coarse to fine steps.
struct ErrorCurve {
    family: CurveFamily,
    engine: String,
    label: String,
    /// Common logarithms of cost and error.
    points: Vec<(f64, f64)>,
    hollow: bool,
    /// Cost and error of the step of 1 ms, or of the finest.
    at_1_ms: (f64, f64),
    /// Whether the curve is drawn in bold and labelled with its name.
    named: bool,
}

/// View (i) of a scene; `None` without measurements.
pub fn precision(case: &ComparisonScene, rows: &[Measurement]) -> Option<String> {
    let mut curves = distinct(curves(case, rows));
    name_peers(&mut curves);
    let all = || curves.iter().flat_map(|curve| &curve.points);
    let (left, right) = (floor(all().map(|point| point.0)), all().map(|point| point.0).fold(f64::MIN, f64::max));
    let (low, high) = (floor(all().map(|point| point.1)), all().map(|point| point.1).fold(f64::MIN, f64::max));
    if curves.is_empty() {
        return None;
    }
    let (y, width) = (low - 0.4..high.ceil().max(low + 2.0) + 0.2, (right - left).max(1.0) / MARGIN);
    let mut marks = Vec::new();
    for curve in curves.iter().filter(|curve| !curve.named) {
        marks.push(Mark::thin(curve.points.clone(), curve.family.colour(false)).faint(0.35));
    }
    for curve in curves.iter().filter(|curve| curve.named) {
        let (points, colour) = (curve.points.clone(), curve.family.colour(curve.hollow));
        marks.push(Mark::line(points.clone(), colour));
        marks.push(if curve.hollow { Mark::rings(points, 3.0, colour) } else { Mark::dots(points, 3.0, colour) });
    }
    let ends: Vec<_> = curves
        .iter()
        .filter(|curve| curve.named)
        .filter_map(|curve| curve.points.last().map(|end| (*end, curve)))
        .collect();
    let unit = (y.end - y.start) / HEIGHT[1];
    let heights = spread_out(&ends.iter().map(|(end, _)| end.1).collect::<Vec<_>>(), LINE * unit, y.start, y.end);
    let at = right + 0.045 * width;
    for ((end, curve), height) in ends.iter().zip(heights) {
        let colour = curve.family.colour(curve.hollow);
        marks.push(Mark::thin(vec![*end, (at - 0.008 * width, height)], colour).faint(0.5));
        marks.push(Mark::note((at, height), curve.label.clone(), colour));
    }
    let frame = Frame {
        title: case.title.into(),
        height: HEIGHT[0] as u32,
        x: PlotAxis::powers("CPU time per simulated time [-]", left - 0.1..left - 0.1 + width),
        y: PlotAxis::powers(case.words, y),
    };
    Some(plot(&frame, &marks))
}

/// Names only the setting of each other engine with the least error at 1 ms, and the fastest of equal ones.
fn name_peers(curves: &mut [ErrorCurve]) {
    let merit = |curve: &ErrorCurve| curve.at_1_ms.1.max(-14.0) + 1e-3 * curve.at_1_ms.0;
    for i in 0..curves.len() {
        let better = |other: &ErrorCurve| other.engine == curves[i].engine && merit(other) < merit(&curves[i]);
        curves[i].named = curves[i].family != CurveFamily::Peer || !curves.iter().any(better);
    }
}

/// The greatest power of ten that does not exceed the least value.
fn floor(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::INFINITY, f64::min).floor()
}

/// The curves of a scene, those of other engines first.
fn curves(case: &ComparisonScene, rows: &[Measurement]) -> Vec<ErrorCurve> {
    let mut names: Vec<(&str, &str)> = Vec::new();
    let of_scene: Vec<_> = rows.iter().filter(|row| row.view == View::Precision && row.scene == case.name).collect();
    for row in &of_scene {
        if !names.contains(&(&row.engine, &row.method)) {
            names.push((&row.engine, &row.method));
        }
    }
    let curve = |(engine, method): (&str, &str)| {
        let runs: Vec<_> =
            of_scene.iter().copied().filter(|row| row.engine == engine && row.method == method).collect();
        let points = points(case, &runs);
        let at_1_ms = points.iter().find(|point| point.0 == 1e-3).or(points.last()).map_or((0.0, 0.0), |point| point.1);
        ErrorCurve {
            family: CurveFamily::of(runs[0]),
            engine: engine.into(),
            label: label(runs[0]),
            points: points.into_iter().map(|point| point.1).collect(),
            hollow: is_hollow(&runs),
            at_1_ms,
            named: true,
        }
    };
    let mut curves: Vec<_> = names.into_iter().map(curve).filter(|curve| !curve.points.is_empty()).collect();
    curves.sort_by_key(|curve| curve.family);
    curves
}

/// Each step with logarithms of its cost and its error, the greatest of the scene's metrics, from coarse to fine.
fn points(case: &ComparisonScene, runs: &[&Measurement]) -> Vec<(f64, (f64, f64))> {
    let mut steps: Vec<f64> = runs.iter().map(|row| row.dt).collect();
    steps.sort_by(|a, b| b.total_cmp(a));
    steps.dedup();
    let point = |dt: f64| {
        let metrics = case.question.metrics();
        let asked = runs.iter().filter(|row| row.dt == dt && metrics.contains(&row.metric.as_str()));
        let (cost, error) = asked.fold((f64::NAN, 0.0), |(_, error), row| (row.cost, row.error.max(error)));
        (dt, (cost.log10(), error.max(NOTHING).log10()))
    };
    steps.into_iter().map(point).filter(|(_, point)| point.0.is_finite() && point.1 < 3.0).collect()
}

/// Merges curves of one kind with equal errors into one curve with all names and the cost of the fastest.
fn distinct(curves: Vec<ErrorCurve>) -> Vec<ErrorCurve> {
    let mut kept: Vec<ErrorCurve> = Vec::new();
    for curve in curves {
        let same = |other: &&mut ErrorCurve| {
            let near = |(a, b): (&(f64, f64), &(f64, f64))| (a.1 - b.1).abs() < 0.03 || a.1.max(b.1) < -13.0;
            other.family == curve.family
                && other.hollow == curve.hollow
                && other.points.len() == curve.points.len()
                && other.points.iter().zip(&curve.points).all(near)
        };
        match kept.iter_mut().find(same).filter(|_| curve.family != CurveFamily::Peer) {
            None => kept.push(curve),
            Some(other) => {
                let cost = |curve: &ErrorCurve| curve.points.iter().map(|point| point.0).sum::<f64>();
                if cost(&curve) < cost(other) {
                    other.points = curve.points;
                    other.label = format!("{}, {}", curve.label, other.label);
                } else {
                    other.label = format!("{}, {}", other.label, curve.label);
                }
            }
        }
    }
    kept.iter_mut().for_each(|curve| curve.label = short(&curve.label));
    kept
}

/// As many names of a list as fit beside the curves, at least one, and the number of the others.
fn short(label: &str) -> String {
    let names: Vec<_> = label.split(", ").collect();
    let shown = |count: usize| match names.len() - count {
        0 => label.into(),
        others => format!("{}, +{others}", names[..count].join(", ")),
    };
    (1..=names.len()).rev().map(shown).find(|text| text.len() <= LABEL).unwrap_or_else(|| shown(1))
}

/// Places between `low` and `high`, at least `gap` apart, as close as possible to the wanted ones.
fn spread_out(wanted: &[f64], gap: f64, low: f64, high: f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|&a, &b| wanted[a].total_cmp(&wanted[b]));
    let mut places = wanted.to_vec();
    // A few passes, upwards and then downwards, end close to the wanted places.
    for _ in 0..60 {
        for pair in order.windows(2) {
            let lack = gap - (places[pair[1]] - places[pair[0]]);
            if lack > 0.0 {
                places[pair[0]] -= 0.5 * lack;
                places[pair[1]] += 0.5 * lack;
            }
        }
        for (i, &k) in order.iter().enumerate() {
            let room = gap * (i as f64 + 0.5);
            let above = gap * ((order.len() - i) as f64 - 0.5);
            places[k] = places[k].clamp((low + room).min(high), (high - above).max(low + room).min(high));
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_has_the_names_that_fit_and_counts_the_others() {
        assert_eq!(short("Rk4, Rk4Impact"), "Rk4, Rk4Impact");
        assert_eq!(short("MidpointContact, MoreauJean"), "MidpointContact, +1");
        assert_eq!(short("EnergyQp, Complementarity, ConeQp"), "EnergyQp, +2");
        assert_eq!(short("a setting with a name of its own"), "a setting with a name of its own");
    }

    #[test]
    fn labels_keep_their_distance_and_their_order() {
        let places = spread_out(&[0.0, 0.1, 0.05, 5.0], 1.0, -3.0, 7.0);
        let mut sorted = places.clone();
        sorted.sort_by(f64::total_cmp);
        assert!(sorted.windows(2).all(|pair| pair[1] - pair[0] > 0.95), "{places:?}");
        assert!(places[0] < places[2] && places[2] < places[1] && (places[3] - 5.0).abs() < 1e-9);
    }
}
