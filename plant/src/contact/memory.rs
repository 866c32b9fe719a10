//! Warm-start memory: modes, slips and impulses of the contacts in the step before.

use super::mode::ContactMode;
use super::problem::Problem;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Mode, slip and impulse of each contact in the last step, by identity. It is part of the state of a simulation: where A is singular, f
/// depends on it, but v does not.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    contacts: Vec<LastContact>,
    /// No contact with an impulse moved in the last solution.
    pub(super) is_static: bool,
    /// Friction held a point inside the ground against its recovery.
    #[serde(default)]
    jams: bool,
}

/// One contact in the last step, in the axes of the problem.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct LastContact {
    /// Contact mode. Laws other than `Cone` only store whether there was an impulse.
    pub mode: ContactMode,
    /// Velocity of slip [m/s].
    pub slip: [f64; 2],
    /// Normal and tangential impulse [N·s].
    pub impulse: [f64; 3],
    /// Bits of its basis, under a law with a basis; see [`super::compared`].
    pub basis: u8,
}

impl Memory {
    /// Memory of this many contacts without impulse.
    pub(crate) fn of(contacts: usize) -> Memory {
        Memory { contacts: vec![LastContact::default(); contacts], ..Memory::default() }
    }

    /// Copies another memory without allocation.
    pub(crate) fn copy(&mut self, other: &Memory) {
        self.contacts.clone_from(&other.contacts);
        (self.is_static, self.jams) = (other.is_static, other.jams);
    }

    /// Stores contacts of standing feet with their impulses in W [N·s]. Contacts with an impulse stick as a patch, the others are open.
    pub(crate) fn record_standing(&mut self, contacts: impl Iterator<Item = (usize, Vector3<f64>)>) {
        self.clear();
        for (id, impulse) in contacts {
            let mode = if impulse.z > 0.0 { ContactMode::Patch } else { ContactMode::Open };
            *self.contact_mut(id) =
                LastContact { mode, impulse: [impulse.z, impulse.x, impulse.y], ..LastContact::default() };
        }
        self.is_static = true;
    }

    /// Expects an impact of these contacts: they stick, and the others are open. An impact lifts contacts that rest on the ground in most cases.
    pub(crate) fn expect_impact(&mut self, landing: impl Iterator<Item = usize>) {
        self.clear();
        for id in landing {
            self.contact_mut(id).mode = ContactMode::Sticking;
        }
    }

    /// Forgets a contact.
    pub(crate) fn forget(&mut self, id: usize) {
        *self.contact_mut(id) = LastContact::default();
    }

    /// Whether no contact with an impulse moved in the last step.
    pub(crate) fn is_static(&self) -> bool {
        self.is_static
    }

    /// Whether friction held a point inside the ground in the last step, and nothing has moved since.
    pub(crate) fn jams(&self) -> bool {
        self.jams && self.is_static
    }

    pub(crate) fn set_jams(&mut self, jams: bool) {
        self.jams = jams;
    }

    /// Whether a contact had an impulse in the last step.
    pub(crate) fn was_active(&self, id: usize) -> bool {
        self.contact(id).mode != ContactMode::Open
    }

    /// Whether a contact had an impulse and slipped in the last step.
    pub(crate) fn was_sliding(&self, id: usize) -> bool {
        self.contact(id).mode == ContactMode::Sliding
    }

    /// The contact in the last step; the default if it was not listed.
    pub(super) fn contact(&self, id: usize) -> LastContact {
        self.contacts.get(id).copied().unwrap_or_default()
    }

    pub(super) fn contact_mut(&mut self, id: usize) -> &mut LastContact {
        if self.contacts.len() <= id {
            self.contacts.resize(id + 1, LastContact::default());
        }
        &mut self.contacts[id]
    }

    /// Resets all contacts to the default.
    pub(super) fn clear(&mut self) {
        self.contacts.fill(LastContact::default());
    }

    /// Stores the impulses of a law that has no contact modes, and which contacts are active.
    pub(super) fn store(&mut self, problem: &Problem, impulse: &[f64]) {
        self.clear();
        for (&id, part) in problem.id.iter().zip(impulse.chunks_exact(1 + problem.tangents)) {
            let own = self.contact_mut(id);
            own.impulse[..part.len()].copy_from_slice(part);
            own.mode = if part[0] > 0.0 { ContactMode::Sliding } else { ContactMode::Open };
        }
    }
}
