//! Exit codes of all programs of a session.

use std::process::ExitCode;

/// Declares the exit codes. Each has one sentence, for its documentation and for `biped --help`.
macro_rules! exit_codes {
    ($( $name:ident = $code:literal, $meaning:literal; )*) => {
        /// Exit code of a program.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Exit { $( #[doc = $meaning] $name = $code, )* }

        impl Exit {
            /// Every exit code, in ascending order.
            pub const ALL: [Exit; [$( $code ),*].len()] = [$( Exit::$name ),*];

            /// What the code means.
            pub fn meaning(self) -> &'static str {
                match self { $( Exit::$name => $meaning, )* }
            }
        }
    };
}

exit_codes! {
    Ok = 0, "success";
    Usage = 2, "wrong arguments, or an invalid scene";
    PeerMissing = 3, "the other process did not start, or ended too early";
    Fault = 4, "the simulation or the controller failed, or results could not be written";
    Incompatible = 5, "the other process has another program version, scene or pace";
    SharedMemory = 6, "shared memory is missing, full or blocked";
    Fell = 7, "the robot fell";
    Unsolved = 8, "a contact problem was not solved to plant.tolerance; it is saved to a file";
    Refused = 9, "the system refused what --rt=require needs";
    Nonconforming = 10, "a program breaks a rule of the wire format (`biped conform`)";
    Unrecorded = 11, "the run is complete, but its recording ended early";
    Interrupted = 130, "interrupted by Ctrl-C or TERM";
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> ExitCode {
        ExitCode::from(exit as u8)
    }
}

impl Exit {
    /// The exit codes as a table, for `biped --help`.
    pub fn table() -> String {
        let row = |exit: Exit| format!("\n{:>5}  {}", exit as u8, exit.meaning());
        std::iter::once("Exit codes:".to_string()).chain(Exit::ALL.map(row)).collect()
    }

    /// The meaning of a child's exit code. A code that no child has, or death by a signal (`None`), is a fault.
    pub fn of_child(code: Option<i32>) -> Exit {
        let by_child = |exit: &Exit| match exit {
            Exit::Ok | Exit::Usage | Exit::PeerMissing | Exit::Incompatible | Exit::SharedMemory => true,
            Exit::Unsolved | Exit::Refused | Exit::Interrupted => true,
            Exit::Fault | Exit::Fell | Exit::Nonconforming | Exit::Unrecorded => false,
        };
        let mut known = Exit::ALL.into_iter().filter(by_child);
        known.find(|exit| code == Some(*exit as i32)).unwrap_or(Exit::Fault)
    }

    /// Why a run ended early, in a few words; `None` if the code is not about an early end.
    pub fn cause(self) -> Option<&'static str> {
        match self {
            Exit::Ok | Exit::Fell | Exit::Nonconforming | Exit::Unrecorded => None,
            Exit::Usage | Exit::Refused => Some("refused"),
            Exit::PeerMissing => Some("other process missing"),
            Exit::Fault => Some("fault"),
            Exit::Incompatible => Some("incompatible processes"),
            Exit::SharedMemory => Some("shared memory"),
            Exit::Unsolved => Some("unsolved contact problem"),
            Exit::Interrupted => Some("interrupted"),
        }
    }
}
