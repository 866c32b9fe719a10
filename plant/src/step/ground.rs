//! The ground under the contact points at the beginning of a step, or of a part between events.

use super::Plant;
use super::event_contact::EventContact;
use super::settings::World;
use super::step_state::StepState;
use crate::detect::{Touch, level_height};

impl Plant {
    /// Takes the tiles under the contact points. A contact whose ground changes is forgotten: it lands again, or it leaves the inside of a
    /// tile.
    pub(super) fn find_ground(&mut self) {
        let Plant {
            world: World { model, settings, input }, state: StepState { now, memory, event_contacts, .. }, ..
        } = self;
        if model.ground.is_none() {
            return;
        }
        let locates = settings.method.locates_events();
        for (id, contact) in event_contacts.iter_mut().enumerate() {
            let had_force = memory.was_active(id) && (!locates || contact.active);
            if input.ground.update(model, &now.pose, id, had_force, settings.h) {
                memory.forget(id);
                *contact = EventContact::default();
            }
        }
    }

    /// Whether a contact point is over a tile of another height than at the beginning of the step.
    pub(super) fn crosses_an_edge(&self) -> bool {
        let World { model, .. } = &self.world;
        let pose = &self.state.now.pose;
        let points = model.contact_points.iter().zip(&self.state.event_contacts);
        let mut places = points.map(|(point, contact)| (pose.reference + pose.lowest(point), contact.tile));
        model.ground.is_some() && places.any(|(place, tile)| model.ground_at(&place) != tile)
    }
}

impl World {
    /// Whether the contacts of each link lie in a horizontal plane, as those of a standing foot must: not on tiles of different heights, and none
    /// deep in the ground beside others at its surface.
    pub(super) fn are_level(&self, touches: &[Touch]) -> bool {
        let height = |touch: &Touch| self.input.ground.of(touch.id);
        touches.windows(2).filter(|pair| pair[0].link == pair[1].link).all(|pair| {
            height(&pair[0]) == height(&pair[1]) && (pair[0].arm.z - pair[1].arm.z).abs() <= level_height(&self.model)
        })
    }
}
