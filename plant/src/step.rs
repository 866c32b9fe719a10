//! One integration step of the plant, in the order of the paper's section 2.
//!
//! ```text
//!   pose → H, b → free motion (12) → touching points → problem (14) → impulse (15)-(22) → velocity (12) → position
//! ```
//!
//! The stages are in `step/free.rs`, `step/contact.rs` and `step/per_contact.rs`. Each stage reads its arguments and returns its result in
//! its own workspace. The integration methods call the stages in different orders:
//!
//! | method | file |
//! |---|---|
//! | `ExplicitEuler`, `SemiImplicitEuler` | `step/euler.rs` |
//! | `MoreauJean` | `step/moreau.rs` |
//! | `MidpointContact` | `step/midpoint_contact.rs` |
//! | `MidpointMoreau`, `ImplicitMidpoint` | `step/midpoint.rs` |
//! | `StepDoubling` | `step/doubling.rs` |
//! | `Rk4` | `step/runge_kutta.rs` |
//! | `Rk4Impact`, `EventDriven` | `step/event.rs` |

mod contact;
mod doubling;
mod euler;
mod event;
mod event_contact;
mod free;
mod ground;
mod impact;
mod landed;
mod landing;
mod last_acceleration;
mod midpoint;
mod midpoint_contact;
mod moreau;
mod per_contact;
mod posed_state;
mod prediction;
mod rotation;
mod runge_kutta;
mod scales;
mod settings;
mod snapshot;
mod stability;
mod stages;
mod step_size;
mod step_state;
mod touches;
mod workspace;

use posed_state::PosedState;
use settings::{Input, Push, World};
pub use snapshot::PlantSnapshot;
use step_state::StepState;
use workspace::Workspace;

use crate::contact::Problem;
use crate::error::PlantError;
use crate::ground::GroundHeights;
use crate::model::Model;
use crate::state::State;
use messages::scene::{Method, Scene, steps_of_push};
use messages::wire::{Encoders, Torques, Truth};

/// Nanoseconds in a second [ns/s].
const NS_PER_S: f64 = 1e9;

/// A robot, its ground and its drives.
///
/// Model and settings are constant. Torques and pushes are constant during a step; the ground under each contact point is found at its
/// beginning, and between events. The future depends only on the world and on the state. The workspace may be replaced without changing a
/// result.
pub struct Plant {
    world: World,
    state: StepState,
    /// As in [`Counts`].
    events: u64,
    rejected: u64,
    work: Workspace,
}

/// Cost of a run so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Evaluations of H and b.
    pub evaluations: u64,
    /// Contact problems solved.
    pub contacts: u64,
    /// Contact problems of which the memory was nearly the solution, as in [`Report::warm`].
    pub warm: u64,
    /// Impacts and ends of slip at which a step was split.
    pub events: u64,
    /// Steps that were rejected and repeated with a shorter length.
    pub rejected: u64,
}

impl Plant {
    /// The plant of a scene in its initial state.
    ///
    /// # Errors
    /// If the scene's bodies, base or initial state cannot be simulated; see [`PlantError`].
    pub fn new(scene: &Scene) -> Result<Self, PlantError> {
        let mut world = World::new(scene)?;
        let now = PosedState::new(&world.model, State::initial(&world.model, &scene.initial)?);
        let mut work = Workspace::new(&world.model, scene.plant.law, scene.plant.method);
        if !world.model.springs.is_empty() {
            work.dynamics.set_couplings(&mut world.model, &now)?;
            stability::check(&world, &now, &mut work.dynamics)?;
        }
        work.dynamics.evaluations = 0;
        world.input.ground = GroundHeights::under(&world.model, &now.pose);
        let state = StepState::new(&world.model, now, &scene.plant);
        Ok(Plant { world, state, events: 0, rejected: 0, work })
    }

    /// One control period: the torques pass through the drives and act for all steps of the period.
    ///
    /// # Errors
    /// [`PlantError::Unsolved`] if a contact problem misses `plant.tolerance`; it contains the problem. Other errors if the simulation has
    /// diverged: the state is not finite, or H is not positive definite.
    pub fn advance(&mut self, command: &Torques) -> Result<Encoders, PlantError> {
        self.world.input.torques = self.state.drives.apply(command);
        self.state.record.begin_period();
        for _ in 0..self.world.settings.steps_per_period {
            self.step()?;
        }
        Ok(self.encoders())
    }

    /// Computes the parts of the next step that do not depend on the torques: H, b and the factor of H. A caller that waits for a command
    /// may call this meanwhile. No result depends on it.
    pub fn prepare(&mut self) {
        let h = self.world.settings.h;
        match self.world.settings.method {
            Method::SemiImplicitEuler => self.work.dynamics.prepare(&self.world.model, &self.state.now, h),
            Method::MidpointContact if self.state.last_acceleration.known => {
                let found = self.evaluate_midpoint(h).is_ok(); // the step reports the error again
                self.work.dynamics.set_prepared(found);
            }
            _ => {}
        }
    }

    /// One integration step with the present torques.
    ///
    /// # Errors
    /// As [`Plant::advance`].
    pub fn step(&mut self) -> Result<(), PlantError> {
        let h = self.world.settings.h;
        self.work.contacts.per_contact.map.problem.reset_rows(0, 0); // clears the problem of the step before
        self.find_ground();
        if self.world.input.steps == 0 {
            self.begin_with_dampers(h)?;
        }
        let near_pole = self.is_near_pole();
        match self.world.settings.method {
            Method::ExplicitEuler => self.explicit_euler(h),
            Method::SemiImplicitEuler => self.semi_implicit_euler(h),
            Method::MoreauJean => self.moreau_jean(h),
            Method::MidpointMoreau => self.midpoint_moreau(h),
            Method::MidpointContact => self.midpoint_contact(h),
            Method::Rk4 => self.rk4(h),
            Method::Rk4Impact => self.rk4_impact(h),
            Method::ImplicitMidpoint => self.implicit_midpoint(h),
            Method::StepDoubling => self.step_doubling(h),
            Method::EventDriven => self.event_driven(h),
        }
        .map_err(|error| if near_pole { PlantError::Gimbal { time: self.world.time() } } else { error })?;
        self.world.input.steps += 1;
        self.state.record.fold(&self.state.now.state);
        self.check_rotation_rate(near_pole)
    }

    /// Solves contact by contact even where whole feet stand: for comparisons, or for [`Plant::problem`].
    pub fn without_standing_feet(mut self) -> Plant {
        self.world.settings.standing_feet = false;
        self
    }

    /// Pushes the centre of mass of a body from now on, with an impulse in W [N·s] that is spread over a duration [s]. Returns whether the
    /// body exists.
    pub fn push(&mut self, body: usize, impulse: [f64; 3], duration: f64) -> bool {
        let World { model, settings, input: Input { pushes, steps, .. } } = &mut self.world;
        let Some(&link) = model.body_link.get(body) else { return false };
        pushes.retain(|push| push.steps.end > *steps);
        let end = steps.saturating_add(steps_of_push(duration, settings.h));
        pushes.push(Push::new(link, impulse, *steps..end, settings.h));
        true
    }

    /// Present encoder counts of the joints.
    pub fn encoders(&self) -> Encoders {
        let (model, state) = (self.model(), self.state());
        self.state.drives.read((0..model.joint_dof.len()).map(|k| state.joint(model, k)))
    }

    /// Ground truth of the present state and of the last control period. The caller sets stamp and timings.
    pub fn truth(&self) -> Truth {
        let World { model, settings, input } = &self.world;
        let period = settings.h * settings.steps_per_period as f64;
        self.state.record.truth(model, &self.state.now.state, &self.state.now.pose, &input.torques, period)
    }

    /// Simulated time [ns].
    pub fn time_ns(&self) -> u64 {
        (self.world.time() * NS_PER_S).round() as u64
    }

    /// The robot model of the dynamics.
    pub fn model(&self) -> &Model {
        &self.world.model
    }

    /// The contact problem of the last step; empty if nothing touched. For standing feet it has their number of contacts only, and no A.
    pub fn problem(&self) -> &Problem {
        &self.work.contacts.per_contact.map.problem
    }

    /// Cost of the run so far.
    pub fn counts(&self) -> Counts {
        let Plant { events, rejected, work: Workspace { dynamics, contacts, .. }, .. } = self;
        Counts {
            evaluations: dynamics.evaluations,
            contacts: contacts.solved,
            warm: contacts.warm,
            events: *events,
            rejected: *rejected,
        }
    }

    /// The present state.
    pub fn state(&self) -> &State {
        &self.state.now.state
    }
}
