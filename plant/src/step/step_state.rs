//! The part of a plant that a step changes and on which the next step depends.

use super::event_contact::EventContact;
use super::last_acceleration::LastAcceleration;
use super::posed_state::PosedState;
use crate::contact::Memory;
use crate::drive::Drives;
use crate::model::Model;
use crate::truth::Record;
use messages::scene::PlantScene;

/// State of the robot, with the memories of its contacts and drives.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct StepState {
    pub now: PosedState,
    pub drives: Drives,
    pub memory: Memory,
    pub last_acceleration: LastAcceleration,
    /// Mode of every contact point between events.
    pub event_contacts: Vec<EventContact>,
    /// Length of the next step, as the step size control chose it [s].
    pub next_step: f64,
    pub record: Record,
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
