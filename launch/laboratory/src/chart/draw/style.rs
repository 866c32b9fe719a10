//! Names and colours of curves.

use crate::chart::cases::{LAW, word};
use crate::chart::csv::{OURS, Row};
use plotters::style::RGBColor;
use records::report::plot::{GREEN, GREY, LEFT, RIGHT};

/// The kind of method that a curve shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    /// Another simulator.
    Peer,
    /// A law, with the integrator used to compare laws.
    Law,
    /// An integrator, under the law used to compare integrators.
    Integrator,
}

impl Family {
    /// Of a row.
    pub fn of(row: &Row) -> Family {
        match (row.engine.as_str(), row.method.split('/').next()) {
            (OURS, Some(law)) if law == word(&LAW) => Family::Integrator,
            (OURS, _) => Family::Law,
            _ => Family::Peer,
        }
    }

    /// Its colour: one for each kind, another one for methods that do not converge.
    pub fn colour(self, hollow: bool) -> RGBColor {
        match self {
            Family::Peer => GREY,
            _ if hollow => RIGHT,
            Family::Law => GREEN,
            Family::Integrator => LEFT,
        }
    }
}

/// The label beside a curve: of our methods the part that varies, of other engines the name without the remark in brackets.
pub fn label(row: &Row) -> String {
    match (Family::of(row), row.method.split_once('/')) {
        (Family::Integrator, Some((_, method))) => method.into(),
        (Family::Law, Some((law, _))) => law.into(),
        _ => format!("{} {}", row.engine, row.method.split(" (").next().unwrap_or_default()),
    }
}
