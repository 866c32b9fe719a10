//! Every message of the wire format.

use super::hash::{FNV_START, fnv1a};
use super::layout::{Field, Message, wire};
use super::names::REFUSALS;
use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

/// Number of drives. Wire order: left ankle roll, ankle pitch, knee, hip, right hip, knee, ankle pitch, ankle roll. A scene with
/// fewer joints leaves the rest at zero.
pub const JOINTS: usize = 8;
/// Number of contact points that [`Truth`] holds, in the order of the scene's bodies.
pub const CONTACTS: usize = 16;
/// First word of every message: "BIPD" in ASCII.
pub const MAGIC: u32 = 0x4250_4944;
/// Hash of [`SCHEMA`]. Two processes exchange messages only if theirs are equal.
pub const SCHEMA_HASH: u64 = fnv1a(FNV_START, SCHEMA.as_bytes());

wire! {
    /// Stamp at the head of every message.
    struct Stamp "biped.Stamp" 64 {
        /// [`MAGIC`].
        magic: u32,
        /// Check sum of all bytes after this field: lower half of XXH3 (64 bits, no seed).
        check: u32,
        /// [`SCHEMA_HASH`].
        schema: u64,
        /// Number of the plant's run. It is random and changes at each start or reset.
        run: u64,
        /// Number of the sending process, random at each start.
        epoch: u64,
        /// Number of the message: the sender counts its messages of this run from 1.
        seq: u64,
        /// In a command: `seq` of the sensors that it answers. In other messages: 0.
        ack: u64,
        /// Simulated time [ns].
        sim_ns: u64,
        /// Monotonic clock of the sender when it sent the message [ns].
        mono_ns: u64,
    }

    /// Reading of the joint encoders.
    struct Encoders "biped.Encoders" 64 {
        /// Counts of each joint: 2^bits counts per turn, 0 at angle zero.
        counts: [i64; 8],
    }

    /// Torque command for the drives.
    struct Torques "biped.Torques" 64 {
        /// Torque at each joint [N·m].
        torque: [f64; 8],
    }

    /// State of the controller, for display and recording. The plant does not use it.
    struct Telemetry "biped.Telemetry" 200 {
        /// Index into [`PHASES`](super::PHASES).
        phase: u32,
        /// Supporting leg: 0 left, 1 right.
        support: u32,
        /// Number of steps taken, that is, of exchanges of support.
        steps: u64,
        /// Measured centre of gravity in the support frame S: forward, toward the swing foot, up [m].
        com: [f64; 3],
        /// Measured position of the centre of the swing foot's sole in S [m].
        swing: [f64; 3],
        /// Planned state x_1, v_1, x_2, v_2 of the two pendulums (31), (32) in S [m, m/s].
        pendulum: [f64; 4],
        /// Energies E_1, E_2 by (33) [m²/s²].
        energy: [f64; 2],
        /// Reference values of E_1, E_2 by (42), (40) [m²/s²].
        energy_ref: [f64; 2],
        /// Planned landing position of the swing foot, x_t1 in S [m].
        landing: f64,
        /// Sliding variable of each servo, wire order [rad/s].
        surface: [f64; 8],
    }

    /// Plant to controller: data that a real robot could measure.
    struct Sensors "biped.Sensors" 136 {
        /// Stamp.
        stamp: Stamp,
        /// Joint encoders.
        encoders: Encoders,
        /// 1 in the last message of a run, which needs no answer; otherwise 0.
        last: u64,
    }

    /// Controller to plant.
    struct Command "biped.Command" 328 {
        /// Stamp; `ack` is the number of the sensors that this command answers.
        stamp: Stamp,
        /// Joint torques.
        torques: Torques,
        /// State of the controller, for recording only.
        telemetry: Telemetry,
    }

    /// Counters of the plant since the start of its run.
    struct Tally "biped.Tally" 136 {
        /// Refused commands, one counter for each reason in [`REFUSALS`].
        refused: [u64; 9],
        /// Commands that never arrived, counted by gaps in their numbers. A repeated answer does not count.
        lost: u64,
        /// Control periods that reused the torques of an earlier command.
        held: u64,
        /// Control periods in which the joints were damped because no recent command had arrived.
        damped: u64,
        /// Control periods in which the drives were off.
        faulted: u64,
        /// Control periods skipped because the plant was late by whole periods of real time.
        skipped: u64,
        /// Number of times that another controller process took over.
        takeovers: u64,
        /// Messages of truth that a recorder did not receive.
        unrecorded: u64,
        /// Requests answered.
        requests: u64,
    }

    /// Data that only the simulation knows, for recording. Never for control.
    struct Truth "biped.Truth" 1376 {
        /// Stamp; `seq` is that of the sensors of the same instant.
        stamp: Stamp,
        /// Position of the base frame in W [m].
        base_position: [f64; 3],
        /// Orientation of the base in W: unit quaternion w, x, y, z.
        base_orientation: [f64; 4],
        /// Velocity of the base frame's origin in W [m/s].
        base_velocity: [f64; 3],
        /// Angular velocity of the base in W [rad/s].
        base_spin: [f64; 3],
        /// Joint angles [rad].
        angle: [f64; 8],
        /// Joint rates [rad/s].
        rate: [f64; 8],
        /// Torques of the drives over the control period before this instant, after delay and limits [N·m].
        torque: [f64; 8],
        /// Mean force of the ground on each contact point over that period: x, y, z in W [N].
        contact_force: [f64; 48],
        /// Largest natural-map residual of the steps in that period, relative to each step's scale.
        natural_map: f64,
        /// Largest Signorini residual, scaled likewise.
        signorini: f64,
        /// Largest angle between the friction force and the direction opposite to slip, over slipping contacts [rad].
        slip_misalignment: f64,
        /// Largest excess of the energy after the contact impulse over that of the free motion [J].
        energy_gain: f64,
        /// Deepest penetration of the ground at this instant, as a positive number [m].
        penetration: f64,
        /// Hash of every state since the start of the run.
        hash: u64,
        /// Number of steps so far whose contact problem needed a fallback.
        fallbacks: u64,
        /// Largest number of pivots of one step in the period.
        pivots: u64,
        /// Time in which the plant computed the period [ns].
        plant_ns: u64,
        /// Time for which the plant waited for the command [ns].
        wait_ns: u64,
        /// Delay of the period's start after its deadline, in real time [ns].
        late_ns: u64,
        /// Time from sending the sensors to sending the command that answers them; 0 if that command did not arrive [ns].
        reply_ns: u64,
        /// Index into [`STATES`](super::STATES).
        state: u32,
        /// Age of the command that drives the robot [control periods].
        age: u32,
        /// Counters of the plant so far.
        tally: Tally,
        /// Telemetry of the last accepted command.
        telemetry: Telemetry,
        /// Stamp of that command, the newest one accepted before this instant; zero before the first.
        command: Stamp,
        /// Torques of that command.
        asked: Torques,
        /// Reading of the joint encoders at this instant.
        encoders: Encoders,
    }

    /// Request to the control service of the plant or of the controller.
    struct Request "biped.Request" 136 {
        /// Stamp.
        stamp: Stamp,
        /// Index into [`REQUESTS`](super::REQUESTS).
        kind: u64,
        /// For `step`: number of control periods to run. For `push`: number of the body in the scene.
        count: u64,
        /// For `reset`: the new seed; 0 keeps the old one.
        seed: u64,
        /// For `push`: impulse in W [N·s].
        impulse: [f64; 3],
        /// For `push`: duration [s].
        duration: f64,
        /// For `set`: period of two steps [s]; infinity leaves it unchanged.
        period: f64,
        /// For `set`: walking speed [m/s]; infinity leaves it unchanged.
        speed: f64,
    }

    /// Answer of the control service.
    struct Reply "biped.Reply" 80 {
        /// Stamp; `sim_ns` is the simulated time.
        stamp: Stamp,
        /// Index into [`VERDICTS`](super::VERDICTS).
        verdict: u64,
        /// Index into [`STATES`](super::STATES): state of the plant. The controller sends 0.
        state: u64,
    }

    /// A request with its answer, for recorders.
    struct Served "biped.Served" 208 {
        /// Stamp of the reply. From the plant: the request took effect between the sensors of this number and the next ones.
        /// From the controller: the request took effect after its answer to the sensors `ack`.
        stamp: Stamp,
        /// The request.
        request: Request,
        /// Index into [`VERDICTS`](super::VERDICTS).
        verdict: u64,
    }
}

// An array length on the wire must be a literal, because its text is part of the schema.
const _: () = assert!(REFUSALS.len() == 9, "Tally.refused has one counter for each reason");

impl Field {
    /// The message that the field consists of, if it is one.
    pub fn message(&self) -> Option<&'static Message> {
        LAYOUT.iter().find(|message| message.name == self.kind)
    }

    /// Size [bytes].
    pub fn size(&self) -> usize {
        let (kind, count) = self.shape();
        self.message().map_or_else(|| if kind == "u32" { 4 } else { 8 * count.unwrap_or(1) }, |message| message.size)
    }
}
