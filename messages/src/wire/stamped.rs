//! Sealing and checking of messages, and the hash of their declaration.

use super::{MAGIC, SCHEMA_HASH, Stamp};
use bytemuck::Pod;
use iceoryx2::prelude::ZeroCopySend;
use xxhash_rust::xxh3::xxh3_64;

/// Start value of [`fnv1a`].
pub const FNV_START: u64 = 0xcbf2_9ce4_8422_2325;

/// Hash of bytes, continued from `hash` (Fowler, Noll, Vo: FNV-1a, 64 bits).
pub const fn fnv1a(mut hash: u64, bytes: &[u8]) -> u64 {
    let mut i = 0;
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u64).wrapping_mul(0x0000_0100_0000_01b3);
        i += 1;
    }
    hash
}

/// A message with a stamp that can be sealed and checked.
pub trait Stamped: Pod + ZeroCopySend + std::fmt::Debug {
    /// Its head.
    fn stamp(&self) -> &Stamp;
    /// Its head, to fill in.
    fn stamp_mut(&mut self) -> &mut Stamp;

    /// Writes magic, schema hash and check sum.
    fn seal(&mut self) {
        *self.stamp_mut() = Stamp { magic: MAGIC, schema: SCHEMA_HASH, ..*self.stamp() };
        self.stamp_mut().check = self.check_sum();
    }

    /// With magic, schema hash and check sum.
    fn sealed(mut self) -> Self {
        self.seal();
        self
    }

    /// Whether magic and schema hash are ours.
    fn is_ours(&self) -> bool {
        self.stamp().magic == MAGIC && self.stamp().schema == SCHEMA_HASH
    }

    /// Whether magic, schema hash and check sum are right.
    fn is_sound(&self) -> bool {
        self.is_ours() && self.stamp().check == self.check_sum()
    }

    /// Check sum of what follows it.
    fn check_sum(&self) -> u32 {
        const BEFORE: usize = std::mem::offset_of!(Stamp, schema);
        xxh3_64(&bytemuck::bytes_of(self)[BEFORE..]) as u32
    }
}
