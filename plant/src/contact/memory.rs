//! What a step remembers of the one before.

use super::Problem;
use super::coulomb::ContactMode;
use nalgebra::Vector3;

/// What the contacts did in the last step, by their identity. Part of the state of a simulation: where A is singular, f (not v) depends
/// on it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Memory {
    contacts: Vec<LastContact>,
    /// The last solution left no velocity where anything pushed.
    pub(super) is_static: bool,
}

/// What a contact did in the last step, in the axes of the problem.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LastContact {
    /// By the round cone; by another law only whether it pushed.
    pub mode: ContactMode,
    /// Velocity of slip [m/s].
    pub slip: [f64; 2],
    /// Normal and tangents [N·s].
    pub impulse: [f64; 3],
    /// By a law with a basis, its bits; see [`super::compared`].
    pub basis: u8,
}

impl Memory {
    /// Of so many contacts, none of which did anything.
    pub(crate) fn of(contacts: usize) -> Memory {
        Memory { contacts: vec![LastContact::default(); contacts], is_static: false }
    }

    /// Becomes the other memory, in the room it has.
    pub(crate) fn copy(&mut self, other: &Memory) {
        self.contacts.clone_from(&other.contacts);
        self.is_static = other.is_static;
    }

    /// Remembers contacts that neither moved nor slipped, with their impulses in W [N·s]: those that push stick, the others are open.
    pub(crate) fn record_standing(&mut self, contacts: impl Iterator<Item = (usize, Vector3<f64>)>) {
        self.clear();
        for (id, impulse) in contacts {
            let mode = if impulse.z > 0.0 { ContactMode::Patch } else { ContactMode::Open };
            *self.contact_mut(id) =
                LastContact { mode, impulse: [impulse.z, impulse.x, impulse.y], ..LastContact::default() };
        }
        self.is_static = true;
    }

    /// Whether nothing that pushed moved in the last step.
    pub(crate) fn is_static(&self) -> bool {
        self.is_static
    }

    /// Whether a contact pushed in the last step.
    pub(crate) fn was_active(&self, id: usize) -> bool {
        self.contact(id).mode != ContactMode::Open
    }

    /// Whether a contact pushed and slipped in the last step.
    pub(crate) fn was_sliding(&self, id: usize) -> bool {
        self.contact(id).mode == ContactMode::Sliding
    }

    /// What a contact did in the last step; nothing if it was not listed.
    pub(super) fn contact(&self, id: usize) -> LastContact {
        self.contacts.get(id).copied().unwrap_or_default()
    }

    pub(super) fn contact_mut(&mut self, id: usize) -> &mut LastContact {
        if self.contacts.len() <= id {
            self.contacts.resize(id + 1, LastContact::default());
        }
        &mut self.contacts[id]
    }

    /// Forgets what the contacts did, before it is told anew.
    pub(super) fn clear(&mut self) {
        self.contacts.fill(LastContact::default());
    }

    /// Keeps the impulses of a law that knows no kinds, and which contacts push.
    pub(super) fn store(&mut self, problem: &Problem, impulse: &[f64]) {
        self.clear();
        for (&id, part) in problem.id.iter().zip(impulse.chunks_exact(1 + problem.tangents)) {
            let own = self.contact_mut(id);
            own.impulse[..part.len()].copy_from_slice(part);
            own.mode = if part[0] > 0.0 { ContactMode::Sliding } else { ContactMode::Open };
        }
    }
}
