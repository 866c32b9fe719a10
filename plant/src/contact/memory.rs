//! What a step remembers of the one before.

use super::coulomb::Kind;
use super::{Problem, status};
use nalgebra::Vector3;

/// By contact identity, bases of when each was last listed, or impulses of the last step. Part of the state of a simulation: where A is
/// singular, f (not v) depends on it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Memory {
    basis: Vec<u8>,
    /// The last solution needed contacts that yield: the next one tries them first.
    pub(super) yields: bool,
    /// How the bases last: 0 if the last solution took many pivots, 1 if few, 2 if none, 3 if nor did the one before.
    steady: u8,
    /// The last solution left no velocity where anything pushed.
    pub(super) rests: bool,
    impulse: Vec<[f64; 3]>,
    contacts: Vec<Contact>,
}

/// What a contact did in the last step, by the round cone, in the axes of W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Contact {
    pub kind: Kind,
    /// Velocity of slip [m/s].
    pub slip: [f64; 2],
    /// Normal and tangents [N·s].
    pub impulse: [f64; 3],
}

impl Memory {
    /// Becomes the other memory, in the room it has.
    pub(crate) fn copy(&mut self, other: &Memory) {
        self.basis.clone_from(&other.basis);
        (self.yields, self.steady, self.rests) = (other.yields, other.steady, other.rests);
        self.impulse.clone_from(&other.impulse);
        self.contacts.clone_from(&other.contacts);
    }

    /// Remembers contacts that neither moved nor slipped, with their impulses in W [N·s]: those that push stick, the others are open.
    pub(crate) fn stand(&mut self, contacts: impl Iterator<Item = (usize, Vector3<f64>)>) {
        self.forget_contacts();
        for (id, impulse) in contacts {
            let pushes = impulse.z > 0.0;
            self.remember(id, status::standing(pushes, 4));
            let kind = if pushes { Kind::Patch } else { Kind::Open };
            *self.contact_mut(id) = Contact { kind, slip: [0.0; 2], impulse: [impulse.z, impulse.x, impulse.y] };
        }
        (self.yields, self.steady, self.rests) = (true, 0, true);
    }

    /// Whether nothing that pushed moved in the last step.
    pub(crate) fn rests(&self) -> bool {
        self.rests
    }

    /// Whether the basis of two feet may be right once more: of those that slide it seldom is, unless it was twice.
    pub(super) fn may_last(&self) -> bool {
        self.steady >= if self.rests { 1 } else { 3 }
    }

    /// Notes how many pivots a solution took, and whether those are few.
    pub(super) fn note_pivots(&mut self, pivots: u32, few: bool) {
        self.steady = match pivots {
            0 if self.steady >= 2 => 3,
            0 => 2,
            _ => few.into(),
        };
    }

    /// Whether a contact pushed when it was last listed.
    pub(crate) fn pushed(&self, id: usize) -> bool {
        self.recall(id) != 0
    }

    /// What a contact did in the last step; nothing if it was not listed.
    pub(super) fn contact(&self, id: usize) -> Contact {
        self.contacts.get(id).copied().unwrap_or_default()
    }

    pub(super) fn contact_mut(&mut self, id: usize) -> &mut Contact {
        if self.contacts.len() <= id {
            self.contacts.resize(id + 1, Contact::default());
        }
        &mut self.contacts[id]
    }

    /// Forgets what the contacts did, before it is told anew.
    pub(super) fn forget_contacts(&mut self) {
        self.contacts.fill(Contact::default());
    }

    pub(super) fn recall(&self, id: usize) -> u8 {
        self.basis.get(id).copied().unwrap_or(0)
    }

    pub(super) fn remember(&mut self, id: usize, bits: u8) {
        if self.basis.len() <= id {
            self.basis.resize(id + 1, 0);
        }
        self.basis[id] = bits;
    }

    /// Impulse of the last step [N·s]; zero of what did not touch.
    pub(super) fn impulse(&self, id: usize) -> [f64; 3] {
        self.impulse.get(id).copied().unwrap_or_default()
    }

    pub(super) fn keep(&mut self, problem: &Problem, impulse: &[f64]) {
        self.impulse.fill([0.0; 3]);
        for (&id, part) in problem.id.iter().zip(impulse.chunks_exact(1 + problem.tangents)) {
            if self.impulse.len() <= id {
                self.impulse.resize(id + 1, [0.0; 3]);
            }
            self.impulse[id][..part.len()].copy_from_slice(part);
        }
    }
}
