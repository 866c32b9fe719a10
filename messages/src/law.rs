//! Contact laws by name: what an impulse has to satisfy, and who finds it.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

/// Contact laws. Their conditions and sources are in `plant/src/contact.rs`.
///
/// In a scene a law is one word, with its number or its kind in brackets: `Aligned`, `Facets(8)`, `FixedPoint(Tresca)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Law {
    /// Springs, dampers and regularised friction, explicit in the velocity before the step.
    SpringDamper,
    /// The energy minimum (14)-(16) as printed, by principal pivoting. Not Coulomb's law: what slides is thrown up.
    EnergyQp,
    /// The same with gap and two tangents, v_N + gap/h >= mu |v_F|, as convex engines have it.
    EnergyQpGap,
    /// The energy minimum with friction bounded by mu f_N of the step before.
    Lagged,
    /// The conditions (17)-(22) with the paper's one slip direction.
    Complementarity,
    /// (17)-(22) with both tangents resisted, the first along the slip.
    Aligned,
    /// (17)-(22) with this many directions of friction, fixed in the world.
    Facets(u8),
    /// Coulomb's law with a round cone; the default.
    Cone,
    /// The energy minimum over round cones, by an interior-point method of others.
    ConeQp,
    /// Coulomb's law with a round cone as the limit of energy minima.
    FixedPoint(Iteration),
    /// This many sweeps of projected Gauss-Seidel towards Coulomb's law.
    Sweep(u16),
}

/// What [`Law::FixedPoint`] carries from one energy minimum to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Iteration {
    /// The bound of friction, mu f_N.
    Tresca,
    /// The slip mu |v_F|, added to v_N (Acary, Cadoux, Lemaréchal & Malick).
    Aclm,
}

impl Law {
    /// That of a scene that names none.
    pub const DEFAULT: Law = Law::Cone;
    /// Every law, in the order of the paper's story; of those with a number the usual ones.
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
        Law::Sweep(50),
    ];
}

impl fmt::Display for Law {
    /// The name without its number is the name of the variant.
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
        let facets = |count: &str| count.parse().ok().filter(|d| [4, 8, 12, 16].contains(d)).map(Law::Facets);
        let sweeps = |count: &str| count.parse().ok().filter(|n| *n > 0).map(Law::Sweep);
        let law = match (name, detail) {
            ("Facets", detail) => facets(detail.unwrap_or("8")),
            ("Sweep", detail) => sweeps(detail.unwrap_or("50")),
            ("FixedPoint", None | Some("Aclm")) => Some(Law::FixedPoint(Iteration::Aclm)),
            ("FixedPoint", Some("Tresca")) => Some(Law::FixedPoint(Iteration::Tresca)),
            (name, None) => Law::ALL.into_iter().find(|law| law.to_string() == name),
            _ => None,
        };
        law.ok_or_else(|| format!("unknown law `{text}`, expected one of {}", names()))
    }
}

/// What a scene may say, for the error that lists it.
fn names() -> String {
    let plain = Law::ALL.map(|law| law.to_string()).into_iter().filter(|name| !name.contains('('));
    let numbered = ["Facets(4)", "Facets(8)", "Facets(12)", "Facets(16)", "FixedPoint(Tresca)", "FixedPoint(Aclm)"];
    let names = plain.chain(numbered.map(String::from)).chain(["Sweep(n)".into()]);
    names.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
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
    fn every_law_is_read_as_it_is_written() {
        for law in Law::ALL.into_iter().chain([Law::Facets(12), Law::Sweep(4)]) {
            assert_eq!(law.to_string().parse(), Ok(law));
        }
        for (short, law) in
            [("Facets", Law::Facets(8)), ("FixedPoint", Law::FixedPoint(Iteration::Aclm)), ("Sweep", Law::Sweep(50))]
        {
            assert_eq!(short.parse(), Ok(law));
        }
    }

    #[test]
    fn an_unknown_law_lists_those_that_exist() {
        for wrong in ["Coulomb", "Facets(5)", "Facets(20)", "Sweep(0)", "FixedPoint(x)", "Cone(3)", "", "aligned"] {
            let error = wrong.parse::<Law>().expect_err(wrong);
            for name in ["Aligned", "SpringDamper", "Facets(16)", "FixedPoint(Tresca)", "Sweep(n)"] {
                assert!(error.contains(&format!("`{name}`")), "{error} does not name {name}");
            }
        }
    }
}
