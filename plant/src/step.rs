//! The step: one integration step of the plant, in the order of the paper's section 2.
//!
//! ```text
//!   pose → H, b → free motion (12) → touching → problem (14) → impulse (15)-(22) → velocity (12) → position
//! ```
//!
//! The stages are in `step/free.rs`, `step/contact.rs` and `step/per_contact.rs`: each reads what it is given and returns what it makes, in room
//! of its own. An integration method has them in its order:
//!
//! | method | where |
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
mod free;
mod midpoint;
mod midpoint_contact;
mod moreau;
mod per_contact;
mod posed_state;
mod prediction;
mod runge_kutta;
mod settings;
mod stability;
mod step_size;

use contact::{Contacts, Touches};
use doubling::StepDoublingState;
use event::EventContact;
use free::{Dynamics, FreeMotion};
use midpoint_contact::LastAcceleration;
use moreau::Means;
use posed_state::{BaseCentre, PosedState};
use runge_kutta::Stages;
use settings::{Push, World};

use crate::contact::{Memory, Problem};
use crate::drive::Drives;
use crate::error::PlantError;
use crate::model::Model;
use crate::state::State;
use crate::truth::Record;
use messages::scene::{Law, Method, Scene};
use messages::wire::{Encoders, Torques, Truth};
use std::f64::consts::PI;

/// Nanoseconds in a second [ns/s].
const NS_PER_S: f64 = 1e9;

/// A robot, its ground and its drives.
///
/// The world stays as it is during a step. The state, with the memories of contacts and drives, is all that the future depends on; the
/// workspace may be dropped without changing a result.
pub struct Plant {
    world: World,
    drives: Drives,
    now: PosedState,
    memory: Memory,
    last_acceleration: LastAcceleration,
    /// What every corner does between events.
    event_contacts: Vec<EventContact>,
    /// Length that the step control would take next [s].
    next_step: f64,
    record: Record,
    /// As in [`Counts`].
    events: u64,
    rejected: u64,
    work: Workspace,
}

/// What a run has cost so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Evaluations of H and b.
    pub evaluations: u64,
    /// Contact problems solved.
    pub contacts: u64,
    /// Those whose remembered basis was right.
    pub warm: u64,
    /// Impacts and ends of slip that a step was split at.
    pub events: u64,
    /// Steps that were taken back and made shorter.
    pub rejected: u64,
}

/// Room for what the stages make.
struct Workspace {
    dynamics: Dynamics,
    free: FreeMotion,
    touches: Touches,
    contacts: Contacts,
    /// The middle of a step, then its end.
    middle: PosedState,
    /// ẋ₋ in the middle of the step, and the centre of the base there, with ẋ₋ and ẋ₊.
    before: Vec<f64>,
    centres: [BaseCentre; 2],
    /// What the contacts did before a step that may have to be split.
    remembered: Memory,
    /// What lands in it.
    landing: Vec<usize>,
    /// Where a step began, or a part of it.
    start: State,
    stages: Stages,
    means: Means,
    /// Mean velocity of an implicit step.
    mean: Vec<f64>,
    doubling: StepDoublingState,
}

impl Plant {
    /// The plant of a scene in its initial state.
    ///
    /// # Errors
    /// If the scene's bodies, base or initial state cannot be simulated; see [`PlantError`].
    pub fn new(scene: &Scene) -> Result<Self, PlantError> {
        let world = World::new(scene)?;
        let model = &world.model;
        let (now, mut work) =
            (PosedState::new(model, State::initial(model, &scene.initial)?), Workspace::new(model, scene.plant.law));
        stability::check(&world, &now, &mut work.dynamics)?;
        work.dynamics.evaluations = 0;
        Ok(Plant {
            drives: Drives::new(&scene.plant),
            now,
            memory: Memory::of(model.contact_points.len()),
            last_acceleration: LastAcceleration::new(model),
            event_contacts: vec![EventContact::default(); model.contact_points.len()],
            next_step: scene.plant.dt,
            record: Record::default(),
            events: 0,
            rejected: 0,
            work,
            world,
        })
    }

    /// One control period: the torques go through the drives and act for as many steps as fit.
    ///
    /// # Errors
    /// If the state is no longer finite or H no longer positive definite: the simulation has blown up. If a contact
    /// problem was not solved as well as `plant.tolerance` asks: [`PlantError::Unsolved`] holds it.
    pub fn advance(&mut self, command: &Torques) -> Result<Encoders, PlantError> {
        self.world.torques = self.drives.apply(command);
        self.record.begin_period();
        for _ in 0..self.world.settings.steps_per_period {
            self.step()?;
        }
        Ok(self.encoders())
    }

    /// Finds what the next step needs whatever the torques will be: H, b and the factor of H. Who waits for a command may
    /// call this meanwhile; no result depends on it.
    pub fn prepare(&mut self) {
        let h = self.world.settings.h;
        match self.world.settings.method {
            Method::SemiImplicitEuler => self.work.dynamics.prepare(&self.world.model, &self.now, h, h),
            Method::MidpointContact if self.last_acceleration.known() => {
                let found = self.evaluate_midpoint(h).is_ok(); // the step finds an error again
                self.work.dynamics.set_prepared(found);
            }
            _ => {}
        }
    }

    /// One integration step under the torques in force.
    ///
    /// # Errors
    /// As [`Plant::advance`].
    pub fn step(&mut self) -> Result<(), PlantError> {
        let h = self.world.settings.h;
        self.work.contacts.per_contact.map.problem.reset_rows(0, 0); // of the step before
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
        }?;
        self.world.steps += 1;
        self.record.fold(&self.now.state);
        self.check_rotation_rate()
    }

    /// That nothing turns by more than half a turn in a step, which looks as if it turned the other way: what comes of that is no motion,
    /// and may have any energy. A method that chooses its own steps finds shorter ones.
    fn check_rotation_rate(&self) -> Result<(), PlantError> {
        let World { model, settings, steps, .. } = &self.world;
        let (rate, dt) = (self.now.state.fastest_turn(model), settings.h);
        if rate * dt <= PI || settings.method.chooses_steps() {
            return Ok(());
        }
        Err(PlantError::Spins { time: *steps as f64 * dt, rate, dt })
    }

    /// Every contact by itself even where whole links stick: for a comparison, or for [`Plant::problem`].
    pub fn without_standing_feet(mut self) -> Plant {
        self.world.settings.standing_feet = false;
        self
    }

    /// Pushes the centre of mass of a body of the scene, from now on: an impulse in W [N·s], spread over a duration [s].
    /// Returns whether there is such a body.
    pub fn push(&mut self, body: usize, impulse: [f64; 3], duration: f64) -> bool {
        let World { model, settings, pushes, steps, .. } = &mut self.world;
        let Some(&link) = model.body_link.get(body) else { return false };
        pushes.retain(|push| push.steps.end > *steps);
        pushes.push(Push::new(link, impulse, *steps, duration, settings.h));
        true
    }

    /// What the joint encoders read now.
    pub fn encoders(&self) -> Encoders {
        let (model, state) = (self.model(), self.state());
        self.drives.read((0..model.joint_dof.len()).map(|k| state.joint(model, k)))
    }

    /// What only a simulation knows, now and of the control period before. Stamp and timings are the caller's.
    pub fn truth(&self) -> Truth {
        let World { model, settings, torques, .. } = &self.world;
        let period = settings.h * settings.steps_per_period as f64;
        self.record.truth(model, &self.now.state, &self.now.pose, torques, period)
    }

    /// Simulated time [ns].
    pub fn time_ns(&self) -> u64 {
        (self.world.time() * NS_PER_S).round() as u64
    }

    /// The robot as the dynamics see it.
    pub fn model(&self) -> &Model {
        &self.world.model
    }

    /// The contact problem of the last step; of no contact if nothing touched. Of welded links only their number counts, and there is
    /// no A.
    pub fn problem(&self) -> &Problem {
        &self.work.contacts.per_contact.map.problem
    }

    /// What the run has cost so far.
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
        &self.now.state
    }
}

impl Workspace {
    fn new(model: &Model, law: Law) -> Self {
        Workspace {
            dynamics: Dynamics::new(model),
            free: FreeMotion::new(model),
            touches: Touches::new(model),
            contacts: Contacts::new(model, law),
            middle: PosedState::new(model, State::zero(model)),
            before: vec![0.0; model.dofs()],
            centres: [BaseCentre::default(); 2],
            remembered: Memory::of(model.contact_points.len()),
            landing: Vec::with_capacity(model.contact_points.len()),
            start: State::zero(model),
            stages: Stages::new(model),
            means: Means::new(model),
            mean: vec![0.0; model.dofs()],
            doubling: StepDoublingState::new(model),
        }
    }
}
