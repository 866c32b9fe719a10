//! The contract: properties that must be equal in plant and controller before they exchange messages.

use crate::scene::Scene;
use crate::session::Session;
use crate::wire::{FNV_START, SCHEMA_HASH, fnv1a};

/// Pace of a run: lockstep or real time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// The plant waits for each answer. The run is as fast as possible, and every run gives the same result.
    Lockstep,
    /// Each control period takes as long as in reality.
    RealTime,
}

impl Pace {
    const ALL: [Pace; 2] = [Pace::Lockstep, Pace::RealTime];

    fn name(self) -> &'static str {
        match self {
            Pace::Lockstep => "lockstep",
            Pace::RealTime => "realtime",
        }
    }
}

/// Properties that must be equal in plant and controller before they exchange messages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contract {
    /// Hash of the wire format, [`SCHEMA_HASH`].
    pub schema: u64,
    /// Hash of the scene's plant and bodies.
    pub model: u64,
    /// Control rate [Hz].
    pub rate: f64,
    /// Integration step of the plant [s].
    pub dt: f64,
    /// Lockstep or real time.
    pub pace: Pace,
    /// Whether the topics have room for a tunnel to another machine, which reads and writes them too. A second plant is still refused,
    /// because there is only one control service. This is not compared: the first process decides.
    pub tunnel: bool,
}

impl Contract {
    /// The contract of a scene.
    pub fn of(scene: &Scene, pace: Pace) -> Contract {
        // `Debug` prints every field, and prints floats exactly.
        let text = format!("{:?}{:?}", scene.plant, scene.bodies);
        Contract {
            schema: SCHEMA_HASH,
            model: fnv1a(FNV_START, text.as_bytes()),
            rate: scene.rate,
            dt: scene.plant.dt,
            pace,
            tunnel: false,
        }
    }

    /// The same contract with room for a tunnel, or without it.
    pub fn with_tunnel(self, tunnel: bool) -> Contract {
        Contract { tunnel, ..self }
    }

    /// The parts with their names, as text.
    pub(super) fn attributes(&self) -> [(&'static str, String); 5] {
        [
            ("wire schema", format!("{:016x}", self.schema)),
            ("pace", self.pace.name().into()),
            ("rate", format!("{} Hz", self.rate)),
            ("dt", format!("{} s", self.dt)),
            ("model", format!("{:016x}", self.model)),
        ]
    }

    /// Environment variables by which a program in another language finds and joins a session: see docs/WIRE.md.
    pub fn variables(&self, session: &Session) -> Vec<(&'static str, String)> {
        let contract = self.attributes().map(|(key, value)| format!("{key}={value}\n")).concat();
        vec![
            ("BIPED_SESSION", session.name().into()),
            ("BIPED_PREFIX", session.prefix()),
            ("BIPED_ROOT", session.root().display().to_string()),
            ("BIPED_CONTRACT", contract),
        ]
    }

    /// Parses `BIPED_CONTRACT`; `None` if a part is missing or wrong.
    pub fn parse(text: &str) -> Option<Contract> {
        let part = |name: &str| text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix('='));
        let hash = |name: &str| u64::from_str_radix(part(name)?, 16).ok();
        let number = |name: &str, unit: &str| part(name)?.strip_suffix(unit)?.parse().ok();
        Some(Contract {
            schema: hash("wire schema")?,
            model: hash("model")?,
            rate: number("rate", " Hz")?,
            dt: number("dt", " s")?,
            pace: Pace::ALL.into_iter().find(|pace| part("pace") == Some(pace.name()))?,
            tunnel: false,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contract_reads_back_from_the_environment() {
        for pace in Pace::ALL {
            let contract = Contract { schema: SCHEMA_HASH, model: 7, rate: 1e3, dt: 1.0 / 3e3, pace, tunnel: false };
            let (_, text) = contract.variables(&Session::unique()).remove(3);
            assert_eq!(Contract::parse(&text), Some(contract));
            for line in text.lines() {
                assert_eq!(Contract::parse(&text.replace(line, "")), None, "without {line}");
            }
        }
    }
}
