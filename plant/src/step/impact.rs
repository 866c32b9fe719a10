//! Impact: a velocity jump at one instant.

use super::Plant;
use super::landed::{Landed, landed_height};
use super::step_state::StepState;
use crate::error::PlantError;
use crate::kinematics;
#[cfg(doc)]
use crate::springs;
use messages::scene::{Law, Method};

impl Plant {
    /// Impact: the contact law on the velocities of all listed points, without passage of time. Joint dampers take part as in
    /// [`springs::add_to_impact_inertia`]; with `times` of zero they do not.
    pub(super) fn impact(&mut self, times: [f64; 2]) -> Result<(), PlantError> {
        let Plant { world, state: StepState { now, memory, record, .. }, work, .. } = self;
        let free = work.free.impact(&world.model, now, &mut work.dynamics, times)?;
        let contact = work.contacts.solve(world, &free, &mut work.touches, None, memory)?;
        record.take(contact, 1.0);
        now.state.xdot.copy_from_slice(&contact.rate);
        kinematics::velocities(&world.model, &now.state.xdot, &mut now.pose);
        Ok(())
    }

    /// The first step of a run begins as after an impact, if joints with dampers move and the robot is on the ground.
    pub(super) fn begin_with_dampers(&mut self, h: f64) -> Result<(), PlantError> {
        let Plant { world, state: StepState { now, memory, .. }, work, .. } = self;
        let (method, law) = (world.settings.method, world.settings.law);
        let moves_by_mean = match method {
            Method::MidpointContact | Method::MidpointMoreau | Method::ImplicitMidpoint => true,
            Method::ExplicitEuler | Method::SemiImplicitEuler | Method::MoreauJean | Method::Rk4 => false,
            Method::Rk4Impact | Method::EventDriven | Method::StepDoubling => false,
        };
        let moves = world.model.springs.iter().any(|spring| spring.damping * now.state.xdot[spring.dof] != 0.0);
        if !moves_by_mean || !moves || law == Law::SpringDamper {
            return Ok(());
        }
        let landed = Landed::new(world, landed_height(world), h);
        match work.touches.find_on_ground(world, &now.pose, landed, memory).list.is_empty() {
            true => Ok(()),
            false => self.impact([h, h]),
        }
    }
}
