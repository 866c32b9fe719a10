//! Names and colours of curves.

use crate::chart::cases::{LAW, word};
use crate::chart::csv::{Measurement, OURS};
use plotters::style::RGBColor;
use records::report::plot::{GREEN, GREY, LEFT, RIGHT};

/// The kind of method that a curve shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CurveFamily {
    /// Another simulator.
    Peer,
    /// A law, with the integrator used to compare laws.
    Law,
    /// An integrator, under the law used to compare integrators.
    Integrator,
}

impl CurveFamily {
    /// The curve family of a row.
    pub fn of(row: &Measurement) -> CurveFamily {
        match (row.engine.as_str(), row.method.split('/').next()) {
            (OURS, Some(law)) if law == word(&LAW) => CurveFamily::Integrator,
            (OURS, _) => CurveFamily::Law,
            _ => CurveFamily::Peer,
        }
    }

    /// Colour: one for each kind, another one for methods that do not converge.
    pub fn colour(self, hollow: bool) -> RGBColor {
        match self {
            CurveFamily::Peer => GREY,
            _ if hollow => RIGHT,
            CurveFamily::Law => GREEN,
            CurveFamily::Integrator => LEFT,
        }
    }
}

/// The label beside a curve: of our methods the part that varies, of other engines the name without the remark in brackets.
pub fn label(row: &Measurement) -> String {
    match (CurveFamily::of(row), row.method.split_once('/')) {
        (CurveFamily::Integrator, Some((_, method))) => method.into(),
        (CurveFamily::Law, Some((law, _))) => law.into(),
        _ => format!("{} {}", row.engine, row.method.split(" (").next().unwrap_or_default()),
    }
}
