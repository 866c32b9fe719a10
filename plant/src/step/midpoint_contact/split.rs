//! Landings split a step: the motion to the ground without the contact that lands, the impact, and the rest.

use super::Part;
use crate::error::PlantError;
use crate::step::Plant;
use crate::step::landed::{Landed, landed_height};
use crate::step::landing::{Landing, LandingSearch};
use crate::step::step_state::StepState;
use crate::step::workspace::Workspace;
use messages::scene::Method;

/// Trials to locate a landing at most; two or three are typical.
const MAX_TRIALS: usize = 20;
/// A landing is located if its point is nearer to the ground than this part of [`landed_height`] [-]. With half of that height, the error of a step
/// with an impact would not be of third order.
const LOCATED: f64 = 0.1;

impl Plant {
    /// Advances to the first landing, if there is one. Else the end of the step is computed, in [`Workspace`].
    pub(super) fn advance_to_landing(&mut self, rest: Part) -> Result<Option<Landing>, PlantError> {
        self.predict_free_motion(rest)?;
        let Plant {
            state: StepState { memory, last_acceleration, .. },
            work: Workspace { touches, landing, remembered, .. },
            ..
        } = self;
        landing.clear();
        landing.extend(touches.list.iter().filter(|touch| touch.lands()).map(|touch| touch.id));
        let h = rest.h;
        let mut time = touches.list.iter().fold(f64::INFINITY, |first, touch| first.min(touch.lands_after));
        if !landing.is_empty() || !last_acceleration.known {
            remembered.copy(memory);
        }
        if time >= h {
            self.solve_contact(rest)?;
            if !self.work.lands() {
                self.repeat_with_acceleration(rest)?;
                return self.work.integrate_position(&self.world, h).map(|()| None);
            }
            self.state.memory.copy(&self.work.remembered);
            time = h;
        }
        let Plant { world, state: StepState { now, .. }, work: Workspace { landing, .. }, .. } = self;
        let gap = |id: usize| world.input.ground.gap(&world.model, &now.pose, id);
        if landing.iter().any(|&id| gap(id) <= landed_height(world)) {
            return Ok(Some(Landing { time: 0.0, gap: 0.0 }));
        }
        self.locate_landing(rest, time)
    }

    /// Advances to the first landing within a part. The first trial has the length `time` [s]. If no point lands after all, the end of the step is
    /// computed instead.
    ///
    /// The gap at the end of a trial depends on its length; see [`LandingSearch`].
    fn locate_landing(&mut self, rest: Part, mut time: f64) -> Result<Option<Landing>, PlantError> {
        let h = rest.h;
        let mut search = LandingSearch::new();
        for trial in 1.. {
            self.solve_again(Part { h: time, skips_landings: true, ..rest }, Plant::predict_free_motion)?;
            self.work.integrate_position(&self.world, time)?;
            let Plant { world, state: StepState { now, .. }, work: Workspace { next, landing, .. }, .. } = self;
            let end = |id: usize| world.input.ground.gap(&world.model, &next.pose, id);
            let Some(&first) = landing.iter().min_by(|a, b| end(**a).total_cmp(&end(**b))) else { break };
            let (gap, point) = (end(first), &world.model.contact_points[first]);
            if gap > 0.0 && time >= h {
                return Ok(None);
            }
            let rate = now.pose.links[point.link].velocity.at(&now.pose.lowest(point)).z;
            if gap.abs() <= LOCATED * landed_height(world) || trial == MAX_TRIALS {
                self.accept();
                return Ok(Some(Landing { time, gap }));
            }
            let start = world.input.ground.gap(&world.model, &now.pose, first);
            time = search.next(Landing { time, gap }, [start, rate], h);
        }
        Ok(None)
    }

    /// Impact of all points on the ground, before the rest of the step.
    pub(super) fn impact_at_landing(&mut self, landing: Landing, rest: Part) -> Result<(), PlantError> {
        let Plant { world, state: StepState { now, memory, .. }, work, .. } = self;
        let landed = Landed::new(world, landed_height(world), rest.whole).above(landing.gap.max(0.0));
        work.touches.find_on_ground(world, &now.pose, landed, memory);
        self.events += 1;
        let settings = &self.world.settings;
        // in flight dampers need no impulse, and `StepDoubling` shortens its steps instead
        let damps = settings.restitution == 0.0 && settings.method == Method::MidpointContact;
        self.impact(if damps { [rest.h.max(0.0), rest.whole] } else { [0.0; 2] })?;
        self.state.last_acceleration.forget();
        Ok(())
    }
}

impl Workspace {
    /// Whether an impulse stopped a point that lands.
    pub(super) fn lands(&self) -> bool {
        let pairs = self.touches.list.iter().zip(&self.contacts.contact.impulses);
        pairs.into_iter().any(|(touch, (_, impulse))| touch.lands() && impulse.z > 0.0)
    }
}
