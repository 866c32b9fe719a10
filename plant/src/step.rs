//! The step: one integration step of the plant, in the order of the paper's section 2.
//!
//! ```text
//!   pose → H, b → free motion (12) → touching → problem (14) → impulse (15)-(22) → velocity (12) → position
//! ```
//!
//! Each integration method is the same stages in an order of its own:
//!
//! | method | where |
//! |---|---|
//! | `ExplicitEuler`, `SemiImplicitEuler` | `step/euler.rs` |
//! | `MoreauJean` | `step/moreau.rs` |
//! | `MidpointMoreau`, `ImplicitMidpoint` | `step/midpoint.rs` |
//! | `StepDoubling` | `step/doubling.rs` |
//! | `Rk4` | `step/runge_kutta.rs` |
//! | `Rk4Impact`, `EventDriven` | `step/event.rs` |

mod doubling;
mod euler;
mod event;
mod midpoint;
mod moreau;
mod runge_kutta;
mod settings;

use event::Bearing;
use runge_kutta::Stages;
use settings::{Push, Settings};

use crate::composite::Composite;
use crate::contact::{Memory, Problem, Report, Solver, is_plastic};
use crate::delassus::ContactMap;
use crate::detect::{Touch, touching};
use crate::drive::Drives;
use crate::error::PlantError;
use crate::factor::{Factor, PathMatrix};
use crate::kinematics::{self, Pose, contact_column};
use crate::model::Model;
use crate::springs;
use crate::state::State;
use crate::truth::Record;
use crate::weld::Weld;
use messages::scene::{Base, Law, Method, Scene};
use messages::wire::{Encoders, Torques, Truth};

/// Coordinate of the pitch of virtual joints.
const PITCH: usize = 4;
/// Trials of a weld, each with the contacts corrected by the one before.
const WELDS: usize = 4;
/// Cosine of a pitch so near to 90° that yaw and roll are the same to rounding.
const UPRIGHT: f64 = 1e-8;

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
        let mut work = Workspace::new(&model);
        kinematics::pose(&model, &state, &mut work.pose);
        Ok(Plant {
            settings: Settings::new(&scene.plant, scene.rate, &model)?,
            drives: Drives::new(&scene.plant),
            memory: Memory::default(),
            bearings: vec![Bearing::default(); model.corners.len()],
            steps: 0,
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

    /// One integration step under the torques in force.
    ///
    /// # Errors
    /// As [`Plant::advance`].
    pub fn step(&mut self) -> Result<(), PlantError> {
        let h = self.settings.h;
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

    /// H, b and H = LᵀL at the present pose and velocity. Springs and dampers of the joints act as they will after the
    /// time `ahead`, their forces changing with those of the step over the time `grip`; see [`springs`].
    fn find_inertia(&mut self, grip: f64, ahead: f64) -> Result<(), PlantError> {
        self.counts.evaluations += 1;
        let Workspace { pose, composite, inertia, factor, free, .. } = &mut self.work;
        composite.inertia(&self.model, pose, inertia);
        composite.bias(&self.model, pose, &self.state.xdot, free);
        springs::stiffen(&self.model, grip, inertia);
        springs::pull(&self.model, &self.state, ahead, free);
        factor.factorize(&self.model, inertia)
    }

    /// The velocity that a step of `h` would end with if nothing touched: ẋ₋ + H⁻¹Δf_b, Δf_b = (u − b)h. (12)
    fn predict_free_motion(&mut self, h: f64) {
        self.find_efforts();
        let Workspace { factor, free, .. } = &mut self.work;
        for effort in free.iter_mut() {
            *effort *= h; // Δf_b
        }
        factor.solve(&self.model, free);
        for (free, before) in free.iter_mut().zip(&self.state.xdot) {
            *free += before;
        }
    }

    /// u − b, with the push: all efforts but those of contact.
    fn find_efforts(&mut self) {
        let Workspace { pose, free, column, .. } = &mut self.work;
        for bias in free.iter_mut() {
            *bias = -*bias;
        }
        for (&dof, torque) in self.model.joint_dof.iter().zip(self.applied.torque) {
            free[dof] += torque;
        }
        for push in self.settings.pushes.iter().filter(|push| push.steps.contains(&self.steps)) {
            let arm = pose.links[push.link].com;
            contact_column(&self.model, pose, push.link, &arm, &push.force, column);
            for (k, &dof) in column.iter().zip(self.model.path(push.link)) {
                free[dof] += k;
            }
        }
    }

    /// The points that may touch within a step of `h`.
    fn find_touches(&mut self, h: f64) {
        let Workspace { pose, touches, .. } = &mut self.work;
        touching(&self.model, pose, self.settings.law, h, touches);
    }

    /// The problem (14) of the touching points, A apart.
    fn pose_problem(&mut self, h: f64) {
        let Settings { law, friction, restitution, .. } = self.settings;
        let Workspace { pose, free, touches, map, problem, .. } = &mut self.work;
        map.drift(&self.model, pose, touches, free, law, problem, |_, drift| drift);
        problem.friction.fill(friction);
        for (approach, touch) in problem.approach.iter_mut().zip(&*touches) {
            *approach = touch.gap.max(0.0) / h;
        }
        if law == Law::SpringDamper {
            problem.spring = self.settings.spring;
            problem.gap.iter_mut().zip(&*touches).for_each(|(gap, touch)| *gap = touch.gap);
            for (before, touch) in problem.before.chunks_exact_mut(3).zip(&*touches) {
                let v = pose.links[touch.link].velocity.at(&touch.arm);
                before.copy_from_slice(&[v.z, v.x, v.y]);
            }
        }
        if restitution > 0.0 {
            self.bounce(h);
        }
    }

    /// Newton's law of impact: what would land within the step of `h` and was falling at v_N leaves at -e v_N or more. What
    /// two steps of free fall made as fast stays down, or the last of its bounces would never come.
    fn bounce(&mut self, h: f64) {
        let slow = if h.is_finite() { 2.0 * self.model.gravity.norm() * h } else { 0.0 };
        let Workspace { pose, touches, problem, .. } = &mut self.work;
        let rows = 1 + problem.tangents;
        for ((approach, free), touch) in
            problem.approach.iter_mut().zip(problem.drift.iter().step_by(rows)).zip(touches)
        {
            let before = pose.links[touch.link].velocity.at(&touch.arm).z;
            if before < -slow && free + *approach < 0.0 {
                *approach = self.settings.restitution * before;
            }
        }
    }

    /// Δf by the contact law, and the velocity after it: ẋ₊ = ẋ₋ + H⁻¹(Δf_b + KΔf). (12)
    ///
    /// Where nothing moved in the step before, links welded to the ground are tried first: see [`crate::weld`].
    fn solve_contacts(&mut self, h: f64) -> Result<(), PlantError> {
        if !self.work.touches.is_empty() {
            self.pose_problem(h);
            let (welded, report) = match self.weld() {
                Some(report) => (true, report),
                None => (false, self.solve_problem()?),
            };
            let plastic = is_plastic(self.settings.law) && self.settings.restitution == 0.0;
            debug_assert!(!plastic || report.energy_gain < 1e-9, "plastic contact raised the energy: {report:?}");
            self.counts.note(&report);
            self.report = report;
            let Workspace { factor, free, change, map, solver, weld, .. } = &mut self.work;
            let impulse = if welded { &weld.wrench } else { &solver.impulse };
            map.respond(&self.model, factor, impulse, change);
            free.iter_mut().zip(change.iter()).for_each(|(velocity, change)| *velocity += change);
        }
        self.state.xdot.copy_from_slice(&self.work.free);
        Ok(())
    }

    /// The solution in which every touching link stays where it is, if it did in the step before and that obeys the law.
    fn weld(&mut self) -> Option<Report> {
        let Settings { law, restitution, welds, .. } = self.settings;
        let Workspace { pose, factor, free, touches, map, problem, solver, weld, .. } = &mut self.work;
        if !(welds && law == Law::Aligned && restitution == 0.0 && problem.tangents == 2 && self.memory.rests()) {
            return None;
        }
        weld.reduce(&self.model, pose, factor, touches, free, map);
        solver.recall(problem, &self.memory);
        for _ in 0..WELDS {
            if !weld.hold(touches, problem, map, solver.basis()) {
                return None;
            }
            let rows = [&weld.diagonal, &weld.impulse, &weld.velocity].map(Vec::as_slice);
            let report = solver.accept(problem, rows, &mut self.memory);
            if report.is_some() || !solver.correct() {
                return report;
            }
        }
        None
    }

    /// The solution of the problem (14), every contact by itself.
    fn solve_problem(&mut self) -> Result<Report, PlantError> {
        let Workspace { pose, factor, touches, map, problem, solver, .. } = &mut self.work;
        map.assemble(&self.model, pose, factor, touches, problem);
        let report = solver.solve(problem, self.settings.law, &mut self.memory);
        self.settings.check(&report, self.steps, problem)?;
        Ok(report)
    }

    /// Every contact by itself even where whole links stick: for a comparison, or for [`Plant::problem`].
    pub fn without_welds(mut self) -> Plant {
        self.settings.welds = false;
        self
    }

    /// Takes the contact impulses of the last solution into the record.
    fn record_contacts(&mut self) {
        let Workspace { touches, map, solver, .. } = &self.work;
        if !touches.is_empty() {
            self.record.note(&self.report);
            for (i, touch) in touches.iter().enumerate() {
                self.record.push(touch.id, map.force(i, &solver.impulse, touches.len()).into());
            }
        }
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
        if self.model.base == Base::Virtual && self.state.x[PITCH].cos().abs() < UPRIGHT {
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

    /// The contact problem of the last step; of no contact if nothing touched. Without A if the links were welded.
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
    fn new(model: &Model) -> Self {
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
            map: ContactMap::new(model),
            problem: Problem::default(),
            solver: Solver::default(),
            weld: Weld::default(),
        }
    }
}
