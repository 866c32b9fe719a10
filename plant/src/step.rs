//! The step: one integration step of the plant, in the order of the paper's section 2.
//!
//! ```text
//!   pose → H, b → free motion (12) → touching → problem (14) → impulse (15)-(22) → velocity (12) → position
//! ```
//!
//! The stages are in `step/free.rs` and `step/contact.rs`; each integration method has them in an order of its own:
//!
//! | method | where |
//! |---|---|
//! | `ExplicitEuler`, `SemiImplicitEuler` | `step/euler.rs` |
//! | `MoreauJean` | `step/moreau.rs` |
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
mod moreau;
mod runge_kutta;
mod settings;

use event::Bearing;
use runge_kutta::Stages;
use settings::{Push, Settings};

use crate::composite::Composite;
use crate::contact::{Memory, Problem, Report, Solver, tangents};
use crate::delassus::ContactMap;
use crate::detect::Touch;
use crate::drive::Drives;
use crate::error::PlantError;
use crate::factor::{Factor, PathMatrix};
use crate::kinematics::{self, Pose};
use crate::model::Model;
use crate::state::State;
use crate::truth::Record;
use crate::weld::Weld;
use messages::scene::{Base, Law, Method, Scene};
use messages::turn::sin_cos;
use messages::wire::{Encoders, Torques, Truth};

/// Coordinate of the pitch of virtual joints.
const PITCH: usize = 4;
/// Cosine of a pitch so near to 90° that yaw and roll are the same to rounding.
const GIMBAL: f64 = 1e-8;

/// A robot, its ground and its drives.
///
/// The model never changes; the state, with the memories of contacts and drives, is all that the future depends on; the
/// workspace may be dropped without changing a result.
pub struct Plant {
    model: Model,
    settings: Settings,
    state: State,
    memory: Memory,
    /// What every corner does between events.
    bearings: Vec<Bearing>,
    drives: Drives,
    steps: u64,
    /// Whether H, b and the factor of H are there already for the step to come.
    ready: bool,
    applied: Torques,
    record: Record,
    report: Report,
    counts: Counts,
    /// Length that the step control would take next [s].
    stride: f64,
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

impl Counts {
    fn note(&mut self, report: &Report) {
        self.contacts += 1;
        self.warm += u64::from(report.warm);
    }
}

/// Scratch of one step. `pose` belongs to the state at all times.
struct Workspace {
    pose: Pose,
    composite: Composite,
    inertia: PathMatrix,
    factor: Factor,
    /// b, then Δf_b, then H⁻¹Δf_b, then ẋ₋ + H⁻¹Δf_b.
    free: Vec<f64>,
    /// H⁻¹KΔf.
    change: Vec<f64>,
    /// Mean velocity of a step.
    mean: Vec<f64>,
    /// Stages of a Runge-Kutta step, and where it began.
    stages: Stages,
    /// End of the step that step doubling compares with, and memory at its beginning.
    coarse: State,
    memory: Memory,
    column: Vec<f64>,
    touches: Vec<Touch>,
    /// Time within which they may touch [s].
    horizon: f64,
    map: ContactMap,
    problem: Problem,
    solver: Solver,
    weld: Weld,
}

impl Plant {
    /// The plant of a scene in its initial state.
    ///
    /// # Errors
    /// If the scene's bodies, base or initial state cannot be simulated; see [`PlantError`].
    pub fn new(scene: &Scene) -> Result<Self, PlantError> {
        let model = Model::new(scene)?;
        let state = State::initial(&model, &scene.initial)?;
        let mut work = Workspace::new(&model, scene.plant.law);
        kinematics::pose(&model, &state, &mut work.pose);
        Ok(Plant {
            settings: Settings::new(&scene.plant, scene.rate, &model)?,
            drives: Drives::new(&scene.plant),
            memory: Memory::default(),
            bearings: vec![Bearing::default(); model.corners.len()],
            steps: 0,
            ready: false,
            applied: Torques::default(),
            record: Record::default(),
            report: Report::default(),
            counts: Counts::default(),
            stride: scene.plant.dt,
            model,
            state,
            work,
        })
    }

    /// One control period: the torques go through the drives and act for as many steps as fit.
    ///
    /// # Errors
    /// If the state is no longer finite or H no longer positive definite: the simulation has blown up. If a contact
    /// problem was not solved as well as `plant.tolerance` asks: [`PlantError::Unsolved`] holds it.
    pub fn advance(&mut self, command: &Torques) -> Result<Encoders, PlantError> {
        self.applied = self.drives.apply(command);
        self.record.begin_period();
        for _ in 0..self.settings.steps_per_period {
            self.step()?;
        }
        Ok(self.encoders())
    }

    /// Finds what the paper's next step needs whatever the torques will be: H, b and the factor of H. Who waits for a command may
    /// call this meanwhile; no result depends on it.
    pub fn get_ready(&mut self) {
        if !self.ready && self.settings.method == Method::SemiImplicitEuler {
            let h = self.settings.h;
            self.ready = self.find_inertia(h, h).is_ok(); // the step finds the error again
        }
    }

    /// One integration step under the torques in force.
    ///
    /// # Errors
    /// As [`Plant::advance`].
    pub fn step(&mut self) -> Result<(), PlantError> {
        let h = self.settings.h;
        self.work.problem.reset_rows(0, 0); // of the step before
        match self.settings.method {
            Method::ExplicitEuler => self.explicit_euler(h),
            Method::SemiImplicitEuler => self.semi_implicit_euler(h),
            Method::MoreauJean => self.moreau_jean(h),
            Method::MidpointMoreau => self.midpoint_moreau(h),
            Method::Rk4 => self.rk4(h),
            Method::Rk4Impact => self.rk4_impact(h),
            Method::ImplicitMidpoint => self.implicit_midpoint(h),
            Method::StepDoubling => self.step_doubling(h),
            Method::EventDriven => self.event_driven(h),
        }?;
        self.steps += 1;
        self.record.fold(&self.state);
        Ok(())
    }

    /// Every contact by itself even where whole links stick: for a comparison, or for [`Plant::problem`].
    pub fn without_welds(mut self) -> Plant {
        self.settings.welds = false;
        self
    }

    /// Moves on for a time with the present velocity.
    fn travel(&mut self, time: f64) -> Result<(), PlantError> {
        self.state.advance(&self.model, time);
        self.pose()
    }

    /// The pose that belongs to the state.
    fn pose(&mut self) -> Result<(), PlantError> {
        if !self.state.x.iter().chain(&self.state.xdot).all(|number| number.is_finite()) {
            return Err(PlantError::NotFinite { time: (self.steps + 1) as f64 * self.settings.h });
        }
        if self.model.base == Base::Virtual && sin_cos(self.state.x[PITCH]).1.abs() < GIMBAL {
            return Err(PlantError::Gimbal { time: (self.steps + 1) as f64 * self.settings.h });
        }
        kinematics::pose(&self.model, &self.state, &mut self.work.pose);
        Ok(())
    }

    /// Pushes the centre of mass of a body of the scene, from now on: an impulse in W [N·s], spread over a duration [s].
    /// Returns whether there is such a body.
    pub fn push(&mut self, body: usize, impulse: [f64; 3], duration: f64) -> bool {
        let Some(&link) = self.model.body_link.get(body) else { return false };
        self.settings.pushes.retain(|push| push.steps.end > self.steps);
        self.settings.pushes.push(Push::new(link, impulse, self.steps, duration, self.settings.h));
        true
    }

    /// What the joint encoders read now.
    pub fn encoders(&self) -> Encoders {
        self.drives.read((0..self.model.joint_dof.len()).map(|k| self.state.joint(&self.model, k)))
    }

    /// What only a simulation knows, now and of the control period before. Stamp and timings are the caller's.
    pub fn truth(&self) -> Truth {
        let period = self.settings.h * self.settings.steps_per_period as f64;
        self.record.truth(&self.model, &self.state, &self.work.pose, &self.applied, period)
    }

    /// Simulated time [ns].
    pub fn time_ns(&self) -> u64 {
        (self.steps as f64 * self.settings.h * 1e9).round() as u64
    }

    /// The robot as the dynamics see it.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The contact problem of the last step; of no contact if nothing touched. Of welded links only their number counts, and there is
    /// no A.
    pub fn problem(&self) -> &Problem {
        &self.work.problem
    }

    /// What the run has cost so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The present state.
    pub fn state(&self) -> &State {
        &self.state
    }
}

impl Workspace {
    fn new(model: &Model, law: Law) -> Self {
        let mut solver = Solver::default();
        solver.rehearse(model.corners.len(), tangents(law).min(model.directions), law);
        Workspace {
            pose: Pose::new(model),
            composite: Composite::new(model),
            inertia: PathMatrix::new(model),
            factor: Factor::new(model),
            free: vec![0.0; model.dofs()],
            change: vec![0.0; model.dofs()],
            mean: vec![0.0; model.dofs()],
            stages: Stages::new(model),
            coarse: State::zero(model),
            memory: Memory::default(),
            column: vec![0.0; model.dofs()],
            touches: Vec::with_capacity(model.corners.len()),
            horizon: 0.0,
            map: ContactMap::new(model),
            problem: Problem::default(),
            solver,
            weld: Weld::new(model),
        }
    }
}
