//! Names and colours of curves.

use crate::chart::cases::{LAW, word};
use crate::chart::csv::{OURS, Row};
use plotters::style::RGBColor;
use records::report::plot::{GREEN, GREY, LEFT, RIGHT};

/// Whose curve it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    /// Another simulator.
    Peer,
    /// A law, with the integrator that all laws are compared with.
    Law,
    /// An integrator, under the law that all are compared under.
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

    /// Its colour: one for each family, another for what does not converge.
    pub fn colour(self, hollow: bool) -> RGBColor {
        match self {
            Family::Peer => GREY,
            _ if hollow => RIGHT,
            Family::Law => GREEN,
            Family::Integrator => LEFT,
        }
    }
}

/// What a method is called beside its curve: of ours the part that varies, of others no remark.
pub fn label(row: &Row) -> String {
    match (Family::of(row), row.method.split_once('/')) {
        (Family::Integrator, Some((_, method))) => method.into(),
        (Family::Law, Some((law, _))) => law.into(),
        _ => format!("{} {}", row.engine, row.method.split(" (").next().unwrap_or_default()),
    }
}
