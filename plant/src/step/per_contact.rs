//! Contact by contact: the problem (14) and its solution (15)-(22).

use super::settings::{Settings, World};
use super::touches::Touches;
use crate::contact::{Memory, Report, Solver, tangents};
use crate::delassus::{ContactMap, Free, Response};
use crate::detect::Touch;
use crate::error::PlantError;
use crate::model::Model;
use messages::scene::{Law, Method};
use nalgebra::Vector3;

/// Tolerance of the greatest coefficient of restitution that does not raise the energy, relative to the scene's coefficient [-].
const RESTITUTION_TOLERANCE: f64 = 1e-3;

/// An impulse or a force with a greater natural map is none: the contacts jam (Painlevé's paradox) [-]. Those that exist are solved to 1e-10, or
/// to their rounding.
pub(super) const JAM: f64 = 1e-6;

/// The contact problem and its solver.
pub(super) struct PerContact {
    pub map: ContactMap,
    pub solver: Solver,
}

impl PerContact {
    /// Allocates for the contacts of a model, under a law. Forces between events are those of `Cone`, whatever the law is.
    pub fn new(model: &Model, law: Law, method: Method) -> PerContact {
        let mut solver = Solver::default();
        let mut reserve =
            |law| solver.reserve_for(model.contact_points.len(), tangents(law).min(model.directions), law);
        reserve(law);
        if method.locates_events() {
            reserve(Law::Cone);
        }
        PerContact { map: ContactMap::new(model), solver }
    }

    /// Records that `contacts` contacts were solved in another way, without a contact problem.
    pub fn skip(&mut self, contacts: usize) {
        self.map.problem.reset_rows(0, 0);
        (self.map.problem.contacts, self.map.problem.tangents) = (contacts, 2);
    }

    /// Sets up the problem (14) of the touching points, without A: their velocity at the end of the step without contact, friction, and
    /// allowed approach.
    ///
    /// Newton's law of impact: a contact that would land with v_N leaves with -e v_N or more, e being `restitution`.
    pub fn set_problem(&mut self, world: &World, free: &Free, touches: &Touches, restitution: f64) {
        let Settings { law, friction, spring, .. } = world.settings;
        let (touches, min_bounce_speed) = (&touches.list, touches.min_bounce_speed);
        let given = law == Law::Cone && touches.iter().any(|touch| touch.slip_direction != Vector3::zeros());
        let at_the_end = |i: usize, drift: Vector3<f64>| {
            let end = drift + touches[i].velocity_gain;
            if given { end } else { aligned_with(end, &touches[i].slip_direction) }
        };
        let problem = self.map.drift(&world.model, free, touches, law, at_the_end);
        if given {
            problem.slip.extend(touches.iter().map(|touch| [touch.slip_direction.x, touch.slip_direction.y]));
        }
        let before = |touch: &Touch| free.pose.links[touch.link].velocity.at(&touch.arm);
        problem.friction.fill(friction);
        problem.approach.iter_mut().zip(touches).for_each(|(approach, touch)| *approach = touch.approach);
        if law == Law::SpringDamper {
            problem.spring = spring;
            problem.gap.iter_mut().zip(touches).for_each(|(gap, touch)| *gap = touch.gap);
            for (rows, touch) in problem.before.chunks_exact_mut(3).zip(touches) {
                let v = before(touch);
                rows.copy_from_slice(&[v.z, v.x, v.y]);
            }
        }
        if restitution > 0.0 {
            let normals = problem.drift.iter().step_by(1 + problem.tangents);
            for ((approach, free), touch) in problem.approach.iter_mut().zip(normals).zip(touches) {
                let before = before(touch).z;
                if before < -min_bounce_speed && free + *approach < 0.0 {
                    *approach = restitution * before;
                }
            }
        }
    }

    /// Solves the problem (14), (15)-(22).
    pub fn solve(
        &mut self,
        world: &World,
        free: &Free,
        touches: &[Touch],
        law: Law,
        memory: &mut Memory,
    ) -> Result<Report, PlantError> {
        let report = self.solve_unchecked(world, free, touches, law, memory);
        world.check(&report, &self.map.problem)?;
        Ok(report)
    }

    /// The same, whatever its residual is.
    pub fn solve_unchecked(
        &mut self,
        world: &World,
        free: &Free,
        touches: &[Touch],
        law: Law,
        memory: &mut Memory,
    ) -> Report {
        let PerContact { map, solver } = self;
        solver.solve(map.assemble(&world.model, free, touches), law, memory)
    }

    /// Solves without conditions that leave no solution: a given direction of slip that contradicts the solution, and the recovery of points
    /// that friction holds inside the ground.
    pub fn solve_possible(
        &mut self,
        world: &World,
        free: &Free,
        touches: &mut Touches,
        memory: &mut Memory,
    ) -> Result<Report, PlantError> {
        let mut report = self.solve_impact(world, free, touches, memory)?;
        if self.contradicts_given_slip(&report) {
            touches.list.iter_mut().for_each(|touch| touch.slip_direction = Vector3::zeros());
            report = self.solve_impact(world, free, touches, memory)?;
        }
        if jams(world.settings.law, &report) && touches.leave_inside() {
            memory.set_jams(true);
            let tried = report.pivots;
            report = self.solve_impact(world, free, touches, memory)?;
            report.pivots += tried;
        }
        Ok(report)
    }

    /// Solves with restitution. Together with friction, Newton's law of impact may raise the energy, or have no solution, if friction against
    /// the slip after the impact presses the contact harder into the ground than its impulse lifts it. Then the greatest coefficient up to the
    /// scene's is taken that does neither, within [`RESTITUTION_TOLERANCE`].
    fn solve_impact(
        &mut self,
        world: &World,
        free: &Free,
        touches: &Touches,
        memory: &mut Memory,
    ) -> Result<Report, PlantError> {
        let Settings { restitution: e, law, .. } = world.settings;
        self.set_problem(world, free, touches, e);
        let report = self.solve(world, free, &touches.list, law, memory)?;
        let is_lawful = |report: &Report| world.is_dissipative(report) && !(law == Law::Cone && report.fallback);
        if e == 0.0 || is_lawful(&report) {
            return Ok(report);
        }
        let (mut good, mut bad) = (0.0, e);
        while bad - good > RESTITUTION_TOLERANCE * e {
            let middle = 0.5 * (good + bad);
            self.set_problem(world, free, touches, middle);
            let end =
                if is_lawful(&self.solve(world, free, &touches.list, law, memory)?) { &mut good } else { &mut bad };
            *end = middle;
        }
        self.set_problem(world, free, touches, good);
        self.solve(world, free, &touches.list, law, memory)
    }

    /// Whether a given direction of slip is none: the slip reverses, or friction along it leaves no solution, because it presses the contact
    /// harder into the ground than the impulse lifts it (Painlevé's paradox). Then the slip was not steady.
    fn contradicts_given_slip(&self, report: &Report) -> bool {
        let problem = &self.map.problem;
        let slips = self.solver.velocity.chunks_exact(1 + problem.tangents);
        let along = |(given, velocity): (&[f64; 2], &[f64])| -> f64 {
            velocity[1..].iter().zip(given).map(|(v, e)| v * e).sum()
        };
        !problem.slip.is_empty() && report.fallback || problem.slip.iter().zip(slips).any(|pair| along(pair) < 0.0)
    }

    /// The velocity change that the solution causes.
    pub fn respond(&mut self, world: &World, free: &Free) -> Response<'_> {
        self.map.respond(&world.model, free.factor, &self.solver.impulse)
    }
}

/// Whether Coulomb's law has no solution. The iterations of other laws may also have missed it.
fn jams(law: Law, report: &Report) -> bool {
    law == Law::Cone && report.natural_map > JAM
}

/// The velocity with its slip turned into a given direction, if there is one. For laws that take the direction of friction from the
/// velocity.
fn aligned_with(velocity: Vector3<f64>, along: &Vector3<f64>) -> Vector3<f64> {
    if *along == Vector3::zeros() {
        return velocity;
    }
    Vector3::new(0.0, 0.0, velocity.z) + along * velocity.xy().norm()
}
