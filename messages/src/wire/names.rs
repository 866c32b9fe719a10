//! Enumerations behind the numbers in messages.
//!
//! One declaration makes the enum and the array of its names, so that the two cannot disagree. The number on the wire is the
//! position in the declaration.

/// Declares an enum, `ALL` its variants, and the array of their names.
macro_rules! named {
    ($(#[$meta:meta])* $enum:ident, $(#[$names_meta:meta])* $names:ident: $(
        $(#[$variant_meta:meta])* $variant:ident $name:literal,
    )*) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $enum { $( $(#[$variant_meta])* $variant, )* }

        impl $enum {
            /// Every variant, in the order of the numbers.
            pub const ALL: [$enum; $names.len()] = [$( $enum::$variant ),*];
        }

        $(#[$names_meta])*
        pub const $names: [&str; [$( $name ),*].len()] = [$( $name ),*];
    };
}

named! {
    /// Phase of the controller's gait.
    #[derive(serde::Serialize, serde::Deserialize)]
    Phase,
    /// Names of [`Phase`], the number in [`Telemetry::phase`](super::Telemetry).
    PHASES:
    /// Standing still on both feet.
    Stand "stand",
    /// The centre of gravity moves over the first supporting foot. Both feet are on the ground.
    Sway "sway",
    /// The swing foot leaves the ground.
    Lift "lift",
    /// Stepping.
    Walk "walk",
    /// Both feet are on the ground and the robot comes to rest.
    Land "land",
    /// Standing still after the walk.
    Rest "rest",
}

named! {
    /// State of the plant.
    #[derive(Default, serde::Serialize, serde::Deserialize)]
    PlantState,
    /// Names of [`PlantState`], the number in [`Truth::state`](super::Truth).
    STATES:
    /// No command has been accepted yet. Simulated time stands still and the robot is held.
    #[default]
    Wait "wait",
    /// Driven by a command that arrived in this control period.
    Run "run",
    /// Simulated time stands still by request.
    Paused "paused",
    /// Driven by an older command.
    Hold "hold",
    /// No recent command: the joints are damped.
    Damp "damp",
    /// The drives are off until they are re-armed.
    Fault "fault",
}

named! {
    /// Why the plant refuses a command. The plant checks in this order.
    Refusal,
    /// Names of [`Refusal`], the index into [`Tally::refused`](super::Tally).
    REFUSALS:
    /// The magic number or the schema hash differs.
    Version "of another version",
    /// The command is for another run.
    Run "for another run",
    /// The sender is a controller that another one has replaced.
    Owner "of a controller that has been replaced",
    /// The check sum is wrong.
    Damaged "damaged",
    /// The command is not newer than the last accepted one.
    Stale "not newer than the last",
    /// The command answers sensors that have not been sent yet.
    Early "ahead of the sensors",
    /// A torque is NaN or infinite.
    NotFinite "not finite",
    /// A torque is far beyond the limit of the drives.
    TooStrong "beyond four times the torque limit",
    /// A torque changes by more than the whole range of the drives in one control period.
    TooSteep "a jump beyond twice the torque limit",
}

named! {
    /// Kind of a request.
    RequestKind,
    /// Names of [`RequestKind`], the number in [`Request::kind`](super::Request).
    REQUESTS:
    /// Stop simulated time.
    Pause "pause",
    /// Let simulated time go on.
    Resume "resume",
    /// Run for a number of control periods, then pause.
    Step "step",
    /// Start a new run from time zero.
    Reset "reset",
    /// Apply an impulse to a body.
    Push "push",
    /// Switch the drives on again after a fault.
    Rearm "rearm",
    /// Change the set-points of the gait.
    Set "set",
    /// End the walk.
    Stop "stop",
}

named! {
    /// Answer to a request.
    Verdict,
    /// Names of [`Verdict`], the number in [`Reply::verdict`](super::Reply).
    VERDICTS:
    /// The request has been carried out.
    Done "done",
    /// The request is for the other process.
    WrongProcess "this request is for the other process",
    /// The scene has no such body.
    NoSuchBody "no such body",
    /// A number is NaN or outside its range.
    OutOfRange "a number is out of range",
    /// The request cannot be decoded.
    Damaged "damaged request",
    /// The process carries out no requests of this kind.
    NotServed "this program does not serve the request",
    /// The robot only stands, or its walk ends already.
    NoEffect "the robot stands or stops, so the request has no effect",
}

impl Verdict {
    /// Name of a verdict as it is on the wire.
    pub fn text(verdict: u64) -> &'static str {
        usize::try_from(verdict).ok().and_then(|index| VERDICTS.get(index)).copied().unwrap_or("an unknown answer")
    }
}
