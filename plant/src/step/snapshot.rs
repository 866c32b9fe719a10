//! Snapshots: everything on which the future of a plant depends, apart from its scene.

use super::event_contact::EventContact;
use super::last_acceleration::LastAcceleration;
use super::posed_state::PosedState;
use super::settings::Push;
use super::{Plant, World};
use crate::contact::Memory;
use crate::drive::Drives;
use crate::ground::GroundHeights;
use crate::truth::Record;
use messages::wire::Torques;

/// The state of a plant, with the memories of its contacts and drives. The workspace and the [`Counts`](super::Counts) of evaluations are
/// not part of it.
#[derive(Clone, Debug)]
pub struct PlantSnapshot {
    ground: GroundHeights,
    torques: Torques,
    pushes: Vec<Push>,
    steps: u64,
    drives: Drives,
    now: PosedState,
    memory: Memory,
    last_acceleration: LastAcceleration,
    event_contacts: Vec<EventContact>,
    next_step: f64,
    record: Record,
}

impl Plant {
    /// The present state, to continue from it later.
    pub fn snapshot(&self) -> PlantSnapshot {
        let World { ground, torques, pushes, steps, .. } = &self.world;
        PlantSnapshot {
            ground: ground.clone(),
            torques: *torques,
            pushes: pushes.clone(),
            steps: *steps,
            drives: self.drives.clone(),
            now: self.now.clone(),
            memory: self.memory.clone(),
            last_acceleration: self.last_acceleration.clone(),
            event_contacts: self.event_contacts.clone(),
            next_step: self.next_step,
            record: self.record,
        }
    }

    /// Returns to a state of this plant, or of another plant of the same scene. What follows has the same bits as it had then.
    pub fn restore(&mut self, snapshot: &PlantSnapshot) {
        let World { ground, torques, pushes, steps, .. } = &mut self.world;
        ground.copy(&snapshot.ground);
        (*torques, *steps) = (snapshot.torques, snapshot.steps);
        pushes.clone_from(&snapshot.pushes);
        self.drives.clone_from(&snapshot.drives);
        self.now.clone_from(&snapshot.now);
        self.memory.clone_from(&snapshot.memory);
        self.last_acceleration.clone_from(&snapshot.last_acceleration);
        self.event_contacts.clone_from(&snapshot.event_contacts);
        (self.next_step, self.record) = (snapshot.next_step, snapshot.record);
        self.work.dynamics.set_prepared(false);
    }
}
