//! What plant and controller must agree on before they speak.

use crate::scene::Scene;
use crate::session::Session;
use crate::wire::{FNV_START, SCHEMA_HASH, fnv1a};

/// Who sets the pace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// The plant waits for each answer: as fast as possible, and every run the same.
    Lockstep,
    /// The clock does: each control period takes as long as in reality.
    RealTime,
}

impl Pace {
    fn name(self) -> &'static str {
        match self {
            Pace::Lockstep => "lockstep",
            Pace::RealTime => "realtime",
        }
    }
}

/// What both sides must agree on before they speak.
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
    /// Whether there is room for a tunnel to another machine, which reads and writes the topics too. A second plant is still
    /// refused, for there is one service. Not agreed upon: whoever comes first decides.
    pub tunnel: bool,
}

impl Contract {
    /// The contract of a scene.
    pub fn of(scene: &Scene, pace: Pace) -> Contract {
        // Debug prints every field, and floats so that they read back exactly.
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

    /// The same with room for a tunnel, or without.
    pub fn with_tunnel(self, tunnel: bool) -> Contract {
        Contract { tunnel, ..self }
    }

    /// The parts by name, as text.
    pub(super) fn attributes(&self) -> [(&'static str, String); 5] {
        [
            ("wire schema", format!("{:016x}", self.schema)),
            ("pace", self.pace.name().into()),
            ("rate", format!("{} Hz", self.rate)),
            ("dt", format!("{} s", self.dt)),
            ("model", format!("{:016x}", self.model)),
        ]
    }

    /// What a program in another language needs to find a session and to be let in, as environment variables: see
    /// docs/WIRE.md.
    pub fn environment(&self, session: &Session) -> Vec<(&'static str, String)> {
        let contract = self.attributes().map(|(key, value)| format!("{key}={value}\n")).concat();
        vec![
            ("BIPED_SESSION", session.name().into()),
            ("BIPED_PREFIX", session.prefix()),
            ("BIPED_ROOT", session.root().display().to_string()),
            ("BIPED_CONTRACT", contract),
        ]
    }

    /// Reads `BIPED_CONTRACT` back, if it is one.
    pub fn parse(text: &str) -> Option<Contract> {
        let part = |name: &str| text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix('='));
        let hash = |name: &str| u64::from_str_radix(part(name)?, 16).ok();
        let number = |name: &str, unit: &str| part(name)?.strip_suffix(unit)?.parse().ok();
        Some(Contract {
            schema: hash("wire schema")?,
            model: hash("model")?,
            rate: number("rate", " Hz")?,
            dt: number("dt", " s")?,
            pace: [Pace::Lockstep, Pace::RealTime].into_iter().find(|pace| part("pace") == Some(pace.name()))?,
            tunnel: false,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contract_reads_back_from_the_environment() {
        for pace in [Pace::Lockstep, Pace::RealTime] {
            let contract = Contract { schema: SCHEMA_HASH, model: 7, rate: 1e3, dt: 1.0 / 3e3, pace, tunnel: false };
            let (_, text) = contract.environment(&Session::unique()).remove(3);
            assert_eq!(Contract::parse(&text), Some(contract));
            for line in text.lines() {
                assert_eq!(Contract::parse(&text.replace(line, "")), None, "without {line}");
            }
        }
    }
}
