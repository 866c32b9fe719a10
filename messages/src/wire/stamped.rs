//! Sealing and checking of messages.

use super::declaration::{Command, MAGIC, Reply, Request, SCHEMA_HASH, Sensors, Served, Stamp, Truth};
use bytemuck::Pod;
use iceoryx2::prelude::ZeroCopySend;
use xxhash_rust::xxh3::xxh3_64;

/// Seconds in a nanosecond [s/ns].
const SECONDS_PER_NS: f64 = 1e-9;

/// A message that begins with a stamp.
pub trait Stamped: Pod + ZeroCopySend + std::fmt::Debug {
    /// The stamp.
    fn stamp(&self) -> &Stamp;
    /// The stamp, to fill in.
    fn stamp_mut(&mut self) -> &mut Stamp;

    /// Writes magic number, schema hash and check sum.
    fn seal(&mut self) {
        *self.stamp_mut() = Stamp { magic: MAGIC, schema: SCHEMA_HASH, ..*self.stamp() };
        self.stamp_mut().check = self.check_sum();
    }

    /// The message with magic number, schema hash and check sum.
    fn sealed(mut self) -> Self {
        self.seal();
        self
    }

    /// Whether magic number and schema hash are those of this program.
    fn is_ours(&self) -> bool {
        self.stamp().magic == MAGIC && self.stamp().schema == SCHEMA_HASH
    }

    /// Whether magic number, schema hash and check sum are right.
    fn is_sound(&self) -> bool {
        self.is_ours() && self.stamp().check == self.check_sum()
    }

    /// Check sum of all bytes after the field `check`.
    fn check_sum(&self) -> u32 {
        const BEFORE: usize = std::mem::offset_of!(Stamp, schema);
        xxh3_64(&bytemuck::bytes_of(self)[BEFORE..]) as u32
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

impl Stamp {
    /// Simulated time [s].
    pub fn time(&self) -> f64 {
        self.sim_ns as f64 * SECONDS_PER_NS
    }
}

impl Command {
    /// Whether this is an undamaged answer to the sensors with the stamp `asked`. The fields of a damaged message are not used.
    pub fn answers(&self, asked: &Stamp) -> bool {
        self.is_sound() && (self.stamp.run, self.stamp.ack) == (asked.run, asked.seq)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_flipped_bit_is_detected() {
        let good = Command::default().sealed();
        assert!(good.is_sound());
        for bit in 0..8 * size_of::<Command>() {
            let mut bytes = bytemuck::bytes_of(&good).to_vec();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(!bytemuck::pod_read_unaligned::<Command>(&bytes).is_sound(), "bit {bit}");
        }
    }
}
