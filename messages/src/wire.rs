//! The messages: what plant and controller say to each other, word for word.
//!
//! Each struct is declared once, inside [`wire!`]: the macro lays it out as C does, checks its size, proves that it has
//! no padding, and adds its text to [`SCHEMA`], whose hash both sides compare before they speak. Only fixed-width
//! integers and `f64` travel, in SI units.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

mod names;
mod stamped;
mod tally;

pub use names::{PHASES, REFUSALS, REQUESTS, STATES, VERDICTS};
pub use stamped::{FNV_START, Stamped, fnv1a};

/// Drives of the robot, in wire order: left ankle roll, ankle pitch, knee, hip, right hip, knee, ankle pitch, ankle
/// roll. Scenes with fewer joints leave the rest at zero.
pub const JOINTS: usize = 8;
/// Contact points that [`Truth`] has room for, in the order of the scene's bodies.
pub const CONTACTS: usize = 16;
/// First word of every message: "BIPD" in ASCII.
pub const MAGIC: u32 = 0x4250_4944;
/// Hash of [`SCHEMA`]: equal on both sides, or they do not speak.
pub const SCHEMA_HASH: u64 = fnv1a(FNV_START, SCHEMA.as_bytes());

macro_rules! wire {
    ($( $(#[doc = $doc:literal])* struct $name:ident $wire_name:literal $size:literal
        { $( $(#[doc = $about:literal])* $field:ident : $type:ty, )* } )*) => {
        $(
            $(#[doc = $doc])*
            #[repr(C)]
            #[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, ZeroCopySend)]
            #[type_name($wire_name)]
            pub struct $name { $( $(#[doc = $about])* pub $field: $type, )* }

            impl Default for $name {
                fn default() -> Self { Zeroable::zeroed() }
            }

            const _: () = assert!(size_of::<$name>() == $size, "the layout of a message changed");
        )*
        /// The wire format as text.
        pub const SCHEMA: &str = concat!($(
            $wire_name, "{", $( stringify!($field), ":", stringify!($type), ";", )* "}",
        )*);
        /// The wire format as a table, for those who describe or convert it.
        pub const LAYOUT: &[Message] = &[$( Message {
            name: stringify!($name),
            doc: &[$($doc),*],
            size: $size,
            fields: &[$( Field {
                name: stringify!($field),
                kind: stringify!($type),
                doc: &[$($about),*],
                offset: std::mem::offset_of!($name, $field),
            }, )*],
        }, )*];
    };
}

/// A message as [`LAYOUT`] has it.
#[derive(Debug)]
pub struct Message {
    /// Its name.
    pub name: &'static str,
    /// What it is, a line each.
    pub doc: &'static [&'static str],
    /// [bytes].
    pub size: usize,
    /// In the order of their offsets, without gaps.
    pub fields: &'static [Field],
}

/// A field of a message.
#[derive(Debug)]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// Type as Rust writes it.
    pub kind: &'static str,
    /// What it is, a line each.
    pub doc: &'static [&'static str],
    /// From the beginning of the message [bytes].
    pub offset: usize,
}

impl Field {
    /// Type of an element, and their number if it is an array.
    pub fn shape(&self) -> (&'static str, Option<usize>) {
        let array = self.kind.strip_prefix('[').and_then(|kind| kind.strip_suffix(']'));
        let parts = array.and_then(|kind| kind.split_once(';'));
        parts.map_or((self.kind, None), |(kind, count)| (kind, count.trim().parse().ok()))
    }

    /// What it is made of, if that is a message.
    pub fn message(&self) -> Option<&'static Message> {
        LAYOUT.iter().find(|message| message.name == self.kind)
    }

    /// [bytes].
    pub fn size(&self) -> usize {
        let (kind, count) = self.shape();
        self.message().map_or_else(|| if kind == "u32" { 4 } else { 8 * count.unwrap_or(1) }, |message| message.size)
    }
}

wire! {
    /// Head of every message.
    struct Stamp "biped.Stamp" 64 {
        /// [`MAGIC`].
        magic: u32,
        /// Check sum of all that follows it: lower half of XXH3 (64 bits, no seed).
        check: u32,
        /// [`SCHEMA_HASH`].
        schema: u64,
        /// Number of the plant's run: new at each start or reset.
        run: u64,
        /// Number of the sending process: random at each start.
        epoch: u64,
        /// Counts the sender's messages of this run from 1.
        seq: u64,
        /// In a command: `seq` of the sensors that it answers; else 0.
        ack: u64,
        /// Simulated time [ns].
        sim_ns: u64,
        /// Monotonic clock of the sender [ns].
        mono_ns: u64,
    }

    /// What a robot's joints report.
    struct Encoders "biped.Encoders" 64 {
        /// Counts of each joint, 2^bits to a turn, zero at zero angle.
        counts: [i64; 8],
    }

    /// What a robot's drives are asked for.
    struct Torques "biped.Torques" 64 {
        /// Torque at each joint [N·m].
        torque: [f64; 8],
    }

    /// What the controller thinks, for people to look at: nothing acts on it.
    struct Telemetry "biped.Telemetry" 200 {
        /// Index into [`PHASES`].
        phase: u32,
        /// Supporting leg: 0 left, 1 right.
        support: u32,
        /// Steps taken: exchanges of support.
        steps: u64,
        /// Measured centre of gravity in the support frame S: forward, toward the swing foot, up [m].
        com: [f64; 3],
        /// Measured position of the swing sole's centre in S [m].
        swing: [f64; 3],
        /// Planned state x_1, v_1, x_2, v_2 of the two pendulums (31), (32) in S [m, m/s].
        pendulum: [f64; 4],
        /// Energies E_1, E_2 by (33) [m²/s²].
        energy: [f64; 2],
        /// Their references by (42), (40) [m²/s²].
        energy_ref: [f64; 2],
        /// Where the swing foot is to land, x_t1 in S [m].
        landing: f64,
        /// Distance of each servo from its sliding surface, wire order [rad/s].
        surface: [f64; 8],
    }

    /// Plant to controller: all that a robot could know of itself.
    struct Sensors "biped.Sensors" 136 {
        /// Head.
        stamp: Stamp,
        /// Joint encoders.
        encoders: Encoders,
        /// 1 in the last message of a run, which wants no answer; else 0.
        last: u64,
    }

    /// Controller to plant.
    struct Command "biped.Command" 328 {
        /// Head; `ack` names the sensors answered.
        stamp: Stamp,
        /// Joint torques.
        torques: Torques,
        /// For the record only.
        telemetry: Telemetry,
    }

    /// What the plant met since the start of its run.
    struct Tally "biped.Tally" 136 {
        /// Commands refused, by reason, in the order of [`REFUSALS`].
        refused: [u64; 9],
        /// Commands that never came: gaps in their numbers.
        lost: u64,
        /// Control periods on torques of an earlier one.
        held: u64,
        /// Control periods damped for want of a young command.
        damped: u64,
        /// Control periods with the drives off.
        faulted: u64,
        /// Whole control periods that real time was ahead and that were left out.
        skipped: u64,
        /// Times that another controller process took over.
        takeovers: u64,
        /// Messages of truth that a recorder did not get.
        unrecorded: u64,
        /// Requests served.
        requests: u64,
    }

    /// What only a simulation knows; for recording, never for control.
    struct Truth "biped.Truth" 1376 {
        /// Head; `seq` as in the sensors of the same instant.
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
        /// Mean force of the ground on each contact point over that period, x, y, z in W [N].
        contact_force: [f64; 48],
        /// Greatest natural-map residual of the steps in that period, relative to each step's scale.
        natural_map: f64,
        /// Greatest Signorini residual, likewise.
        signorini: f64,
        /// Greatest angle between friction and the direction opposite to slip, over slipping contacts [rad].
        slip_misalignment: f64,
        /// Greatest energy after the impulse above that of free motion [J].
        energy_gain: f64,
        /// Deepest penetration at the instant, as a positive number [m].
        penetration: f64,
        /// Hash of every state since the start of the run.
        hash: u64,
        /// Steps so far whose contact problem needed a fallback.
        fallbacks: u64,
        /// Greatest number of pivots that one step of the period took.
        pivots: u64,
        /// Time that the plant took to compute the period [ns].
        plant_ns: u64,
        /// Time that it waited for the command [ns].
        wait_ns: u64,
        /// How late the period began against its deadline, in real time [ns].
        late_ns: u64,
        /// From sending the sensors to sending of the command that answers them; 0 if that one did not come [ns].
        reply_ns: u64,
        /// Index into [`STATES`].
        state: u32,
        /// Age of the command in force [control periods].
        age: u32,
        /// What the plant met so far.
        tally: Tally,
        /// As the last command had it.
        telemetry: Telemetry,
        /// Head of that command: the newest accepted before this instant; zero before the first.
        command: Stamp,
        /// What it asked for.
        asked: Torques,
        /// What the joints report at this instant.
        encoders: Encoders,
    }

    /// Somebody at the plant's or the controller's desk.
    struct Request "biped.Request" 136 {
        /// Head.
        stamp: Stamp,
        /// Index into [`REQUESTS`].
        kind: u64,
        /// Of `step`: control periods to run. Of `push`: number of the body in the scene.
        count: u64,
        /// Of `reset`: the new seed, 0 keeping the old one.
        seed: u64,
        /// Of `push`: impulse in W [N·s].
        impulse: [f64; 3],
        /// Of `push`: duration [s].
        duration: f64,
        /// Of `set`: period of two steps [s], infinity leaving it.
        period: f64,
        /// Of `set`: walking speed [m/s], infinity leaving it.
        speed: f64,
    }

    /// What the desk says.
    struct Reply "biped.Reply" 80 {
        /// Head; `sim_ns` tells the simulated time.
        stamp: Stamp,
        /// Index into [`VERDICTS`].
        verdict: u64,
        /// Index into [`STATES`]: the plant's state; 0 from the controller.
        state: u64,
    }

    /// A request that was answered, for whoever records.
    struct Served "biped.Served" 208 {
        /// Head of the reply. Of the plant: the request took effect after the sensors of this number, before the next. Of the
        /// controller: after its answer to the sensors `ack`.
        stamp: Stamp,
        /// As it was asked.
        request: Request,
        /// Index into [`VERDICTS`].
        verdict: u64,
    }
}

macro_rules! stamped {
    ($($name:ident)*) => {$(
        impl Stamped for $name {
            fn stamp(&self) -> &Stamp { &self.stamp }
            fn stamp_mut(&mut self) -> &mut Stamp { &mut self.stamp }
        }
    )*};
}
stamped!(Sensors Command Truth Request Reply Served);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flipped_bit_is_seen() {
        let good = Command::default().sealed();
        assert!(good.is_sound());
        for bit in 0..8 * size_of::<Command>() {
            let mut bytes = bytemuck::bytes_of(&good).to_vec();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(!bytemuck::pod_read_unaligned::<Command>(&bytes).is_sound(), "bit {bit}");
        }
    }
}
