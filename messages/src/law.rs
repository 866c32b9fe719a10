//! Contact laws by name: the conditions on an impulse, and the method that solves them.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

/// Numbers of friction directions that [`Law::Facets`] may have.
const FACETS: [u8; 4] = [4, 8, 12, 16];
/// Number of friction directions of `Facets` without a parameter.
const DEFAULT_FACETS: u8 = 8;
/// Number of sweeps of `Sweep` without a parameter.
const DEFAULT_SWEEPS: u16 = 50;

/// Contact laws. Their conditions and sources are in `plant/src/contact.rs`.
///
/// In a scene a law is one word, some with a parameter in brackets: `Aligned`, `Facets(8)`, `FixedPoint(Tresca)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Law {
    /// Springs, dampers and regularised friction, explicit in the velocity before the step.
    SpringDamper,
    /// The energy minimum (14)-(16) as printed in the paper, by principal pivoting. It is not Coulomb's law: a sliding body is thrown up.
    EnergyQp,
    /// The same energy minimum with gap and two tangents, v_N + gap/h >= mu |v_F|, as in convex simulators.
    EnergyQpGap,
    /// The energy minimum with friction bounded by mu f_N of the preceding step.
    Lagged,
    /// The conditions (17)-(22) with the paper's single slip direction.
    Complementarity,
    /// The conditions (17)-(22) with friction along both tangents, the first of which is the slip direction.
    Aligned,
    /// The conditions (17)-(22) with this number of friction directions, fixed in the world.
    Facets(u8),
    /// Coulomb's law with a circular cone; the default.
    Cone,
    /// The energy minimum over circular cones, by the interior-point method of another library.
    ConeQp,
    /// Coulomb's law with a circular cone as the limit of a sequence of energy minima.
    FixedPoint(Iteration),
    /// This number of sweeps of projected Gauss-Seidel for Coulomb's law.
    Sweep(u16),
}

/// Quantity that [`Law::FixedPoint`] takes from one energy minimum to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Iteration {
    /// The bound of friction, mu f_N.
    Tresca,
    /// The slip mu |v_F|, added to v_N (Acary, Cadoux, Lemaréchal & Malick).
    Aclm,
}

impl Law {
    /// The law of a scene that names none.
    pub const DEFAULT: Law = Law::Cone;
    /// Every law. Laws with a parameter appear with its usual values.
    pub const ALL: [Law; 14] = [
        Law::SpringDamper,
        Law::EnergyQp,
        Law::EnergyQpGap,
        Law::Lagged,
        Law::Complementarity,
        Law::Aligned,
        Law::Facets(4),
        Law::Facets(8),
        Law::Facets(16),
        Law::Cone,
        Law::ConeQp,
        Law::FixedPoint(Iteration::Tresca),
        Law::FixedPoint(Iteration::Aclm),
        Law::Sweep(DEFAULT_SWEEPS),
    ];
}

impl fmt::Display for Law {
    /// The name of the variant, with its parameter.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{self:?}")
    }
}

impl FromStr for Law {
    type Err = String;

    fn from_str(text: &str) -> Result<Law, String> {
        let (name, detail) = match text.trim().strip_suffix(')').and_then(|text| text.split_once('(')) {
            Some((name, detail)) => (name.trim(), Some(detail.trim())),
            None => (text.trim(), None),
        };
        let facets = |count: &str| count.parse().ok().filter(|d| FACETS.contains(d)).map(Law::Facets);
        let sweeps = |count: &str| count.parse().ok().filter(|n| *n > 0).map(Law::Sweep);
        let law = match (name, detail) {
            ("Facets", None) => Some(Law::Facets(DEFAULT_FACETS)),
            ("Facets", Some(count)) => facets(count),
            ("Sweep", None) => Some(Law::Sweep(DEFAULT_SWEEPS)),
            ("Sweep", Some(count)) => sweeps(count),
            ("FixedPoint", None | Some("Aclm")) => Some(Law::FixedPoint(Iteration::Aclm)),
            ("FixedPoint", Some("Tresca")) => Some(Law::FixedPoint(Iteration::Tresca)),
            (name, None) => Law::ALL.into_iter().find(|law| law.to_string() == name),
            _ => None,
        };
        law.ok_or_else(|| format!("unknown law `{text}`, expected one of {}", names()))
    }
}

/// The names that a scene may use, for an error or a description.
fn names() -> String {
    let plain = Law::ALL.map(|law| law.to_string()).into_iter().filter(|name| !name.contains('('));
    let facets = FACETS.map(|count| Law::Facets(count).to_string());
    let iterations = [Iteration::Tresca, Iteration::Aclm].map(|kind| Law::FixedPoint(kind).to_string());
    let names = plain.chain(facets).chain(iterations).chain(["Sweep(n)".into()]);
    let names = names.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    format!("{names} with n from 1 to {}", u16::MAX)
}

impl TryFrom<String> for Law {
    type Error = String;

    fn try_from(text: String) -> Result<Law, String> {
        text.parse()
    }
}

impl From<Law> for String {
    fn from(law: Law) -> String {
        law.to_string()
    }
}

impl JsonSchema for Law {
    fn schema_name() -> Cow<'static, str> {
        "Law".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "description": format!("Contact law: {}.", names()) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_law_survives_writing_and_reading() {
        for law in Law::ALL.into_iter().chain([Law::Facets(12), Law::Sweep(1), Law::Sweep(65535)]) {
            assert_eq!(law.to_string().parse(), Ok(law));
        }
        for (short, law) in
            [("Facets", Law::Facets(8)), ("FixedPoint", Law::FixedPoint(Iteration::Aclm)), ("Sweep", Law::Sweep(50))]
        {
            assert_eq!(short.parse(), Ok(law));
        }
    }

    #[test]
    fn the_error_of_an_unknown_law_lists_the_known_ones() {
        let words = ["Coulomb", "Facets(5)", "Facets(20)", "FixedPoint(x)", "Cone(3)", "Lagged(2)", "", "aligned"];
        for wrong in words.into_iter().chain(["Sweep(0)", "Sweep(65536)", "Sweep(1000000)", "Sweep(-1)", "Sweep(n)"]) {
            let error = wrong.parse::<Law>().expect_err(wrong);
            for name in ["Aligned", "SpringDamper", "Facets(16)", "FixedPoint(Tresca)", "Sweep(n)"] {
                assert!(error.contains(&format!("`{name}`")), "{error} does not name {name}");
            }
            assert!(error.contains("`Sweep(n)` with n from 1 to 65535"), "{error}");
        }
    }
}
