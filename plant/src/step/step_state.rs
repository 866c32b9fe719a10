//! The part of a plant that a step changes and on which the next step depends.

use super::event_contact::EventContact;
use super::last_acceleration::LastAcceleration;
use super::posed_state::PosedState;
use crate::contact::Memory;
use crate::drive::Drives;
use crate::model::Model;
use crate::truth::Record;
use messages::scene::PlantScene;

/// State of the robot, with the memories of its contacts and drives. In a snapshot the robot has a state without its pose, which follows
/// from it.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct StepState<Robot = PosedState> {
    pub now: Robot,
    pub drives: Drives,
    pub memory: Memory,
    pub last_acceleration: LastAcceleration,
    /// Mode of every contact point between events.
    pub event_contacts: Vec<EventContact>,
    /// Length of the next step, as the step size control chose it [s].
    pub next_step: f64,
    pub record: Record,
}

impl<Robot> StepState<Robot> {
    /// The same memories with the robot held as another type.
    pub fn with<Other>(&self, now: Other) -> StepState<Other> {
        StepState {
            now,
            drives: self.drives.clone(),
            memory: self.memory.clone(),
            last_acceleration: self.last_acceleration.clone(),
            event_contacts: self.event_contacts.clone(),
            next_step: self.next_step,
            record: self.record,
        }
    }
}

impl StepState {
    /// The beginning of a run at the state `now`.
    pub fn new(model: &Model, now: PosedState, plant: &PlantScene) -> StepState {
        let contact_points = model.contact_points.len();
        StepState {
            now,
            drives: Drives::new(plant),
            memory: Memory::of(contact_points),
            last_acceleration: LastAcceleration::new(model),
            event_contacts: vec![EventContact::default(); contact_points],
            next_step: plant.dt,
            record: Record::default(),
        }
    }
}
