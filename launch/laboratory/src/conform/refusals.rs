//! Peers that a program must refuse, and when it must give up: the same for plant and controller.

use super::program::{END_LIMIT, ProgramSetup, ProgramUnderTest};
use super::report::RuleReport;
use messages::port::{Contract, ControllerPort, Pace, PlantPort, PortError};
use messages::session::Session;
use std::time::{Duration, Instant};

/// Exit code after TERM.
pub const INTERRUPTED: i32 = 130;
/// Time after which a process without a peer gives up.
const LIMIT_ALONE: Duration = Duration::from_secs(1);
const REFUSAL: &str = "Topics";

/// Role of the tested program.
#[derive(Clone, Copy, PartialEq)]
pub enum ProgramRole {
    Plant,
    Controller,
}

/// A silent peer: it occupies its role but sends nothing.
#[expect(dead_code, reason = "held, not used")]
enum Held {
    Plant(Box<PlantPort>),
    Controller(Box<ControllerPort>),
}

impl ProgramRole {
    fn hold_other_side(self, session: &Session, contract: &Contract) -> Result<Held, PortError> {
        Ok(match self {
            ProgramRole::Controller => Held::Plant(Box::new(PlantPort::open(session, contract)?)),
            ProgramRole::Plant => Held::Controller(Box::new(ControllerPort::open(session, contract)?)),
        })
    }

    fn other(self) -> &'static str {
        if self == ProgramRole::Plant { "controller" } else { "plant" }
    }
}

/// Contracts that a holder of this contract must refuse. Each differs in one part.
pub fn others(ours: &Contract) -> [(&'static str, Contract); 4] {
    [
        ("a wire schema that it was not built for", Contract { schema: ours.schema ^ 1, ..*ours }),
        ("another model", Contract { model: ours.model ^ 1, ..*ours }),
        ("another rate", Contract { rate: ours.rate * 2.0, ..*ours }),
        ("another pace", Contract { pace: Pace::RealTime, ..*ours }),
    ]
}

/// Sessions with another contract and sessions without a peer, all in parallel.
pub fn check(host: &ProgramSetup, role: ProgramRole, report: &mut RuleReport) -> Result<(), String> {
    let mut environment_alone = host.environment(Pace::Lockstep);
    environment_alone.patience = LIMIT_ALONE;
    let mut program_alone = host.start(&environment_alone)?;

    let ours = host.environment(Pace::Lockstep).contract;
    let mut refused = vec![];
    for (what, other) in others(&ours) {
        let mut environment = host.environment(Pace::Lockstep);
        // The program takes the contract from the environment, except the schema, for which it was built.
        environment.contract.schema = other.schema;
        let held = role.hold_other_side(&environment.session, &other).map_err(|error| error.to_string())?;
        refused.push((what, held, host.start(&environment)?));
    }

    let deadline = Instant::now() + host.patience + END_LIMIT;
    let end = |program: &mut ProgramUnderTest| program.end(deadline.saturating_duration_since(Instant::now()));
    for (what, held, mut program) in refused {
        let finding = end(&mut program).and_then(|ended| ended.by_refusing());
        report.rule(&format!("refuses a session with {what}, with a sentence"), REFUSAL, finding);
        drop(held);
    }
    let finding = end(&mut program_alone).and_then(|ended| ended.by_refusing());
    let rule = format!("gives up without a {}, after its patience, with a sentence", role.other());
    if report.rule(&rule, "Your own controller", finding) {
        let left = environment_alone.session.shm_files();
        let left = match left.first() {
            None => Ok(String::new()),
            Some(file) => Err(format!("{} files, such as {}", left.len(), file.display())),
        };
        report.rule("leaves nothing in /dev/shm, as the last one of its session", "Topics", left);
    }
    environment_alone.session.remove_files();
    Ok(())
}
