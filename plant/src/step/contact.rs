//! The stages of a step at contact: what touches, the problem (14), its impulse (15)-(22), the velocity after it.

use super::{Plant, Workspace};
use crate::contact::Report;
use crate::detect::{overlooked, touching};
use crate::error::PlantError;
use crate::step::settings::Settings;
use messages::scene::Law;

/// Radius of the disc within the cone of a law, however its tangents are turned, as a part of μ; none if feet that stand do not obey it.
fn disc(law: Law) -> Option<f64> {
    match law {
        Law::Cone => Some(1.0),
        Law::Aligned => Some(std::f64::consts::FRAC_1_SQRT_2),
        _ => None,
    }
}

impl Plant {
    /// The points that may touch within a step of `h`.
    pub(super) fn find_touches(&mut self, h: f64) {
        let Workspace { pose, free, touches, horizon, .. } = &mut self.work;
        *horizon = h;
        touching(&self.model, pose, self.settings.law, h, free, touches);
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
    /// Where nothing that pushed moved in the step before, feet that stand are tried first: see [`crate::weld`]. What the impulses drive
    /// into the ground though it was not listed joins, and the problem is solved again.
    pub(super) fn solve_contacts(&mut self, h: f64) -> Result<(), PlantError> {
        self.state.xdot.copy_from_slice(&self.work.free);
        while !self.work.touches.is_empty() {
            let report = match self.weld(h) {
                Some(report) => report,
                None => self.solve_problem(h)?,
            };
            self.settings.check_energy(&report, self.steps)?;
            self.counts.note(&report);
            self.report = report;
            let Workspace { pose, free, change, touches, horizon, .. } = &mut self.work;
            let after = self.state.xdot.iter_mut().zip(free.iter().zip(change.iter()));
            after.for_each(|(after, (free, change))| *after = free + change);
            if !overlooked(&self.model, pose, self.settings.law, *horizon, &self.state.xdot, touches) {
                break;
            }
        }
        Ok(())
    }

    /// The solution in which every link that pushes stays where it is, if it did in the step before and that obeys the law.
    fn weld(&mut self, h: f64) -> Option<Report> {
        let Settings { law, restitution, welds, friction, .. } = self.settings;
        let Workspace { pose, factor, free, touches, problem, weld, change, .. } = &mut self.work;
        let memory = &mut self.memory;
        weld.disc = disc(law)?;
        if !(welds && restitution == 0.0 && self.model.floats() && memory.rests()) {
            return None;
        }
        weld.stand(&self.model, pose, factor, touches, free, h, |id| memory.pushed(id))?;
        let report = weld.hold(&self.model, factor, touches, friction, h, change)?;
        memory.stand(touches.iter().zip(&weld.impulse).map(|(touch, impulse)| (touch.id, *impulse)));
        (problem.contacts, problem.tangents) = (touches.len(), 2);
        problem.delassus.clear();
        Some(report)
    }

    /// The solution of the problem (14), every contact by itself.
    fn solve_problem(&mut self, h: f64) -> Result<Report, PlantError> {
        self.pose_problem(h);
        let Workspace { pose, factor, touches, map, problem, solver, change, .. } = &mut self.work;
        map.assemble(&self.model, pose, factor, touches, problem);
        let report = solver.solve(problem, self.settings.law, &mut self.memory);
        self.settings.check(&report, self.steps, problem)?;
        map.respond(&self.model, factor, &solver.impulse, change);
        Ok(report)
    }

    /// Takes the contact impulses of the last solution into the record.
    pub(super) fn record_contacts(&mut self) {
        let Workspace { touches, map, solver, problem, weld, .. } = &self.work;
        if touches.is_empty() {
            return;
        }
        self.record.note(&self.report);
        for (i, touch) in touches.iter().enumerate() {
            let impulse = match problem.delassus.is_empty() {
                true => weld.impulse[i],
                false => map.force(i, &solver.impulse, touches.len()),
            };
            self.record.push(touch.id, impulse.into());
        }
    }
}
