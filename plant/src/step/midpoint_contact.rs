//! The midpoint rule with contact: forces at the middle of the step, the contact law at its end, and landings located in time.

mod split;

use super::Plant;
use super::midpoint::{check_convergence, update_mean};
use super::prediction::Prediction;
use super::scales::greatest_size;
use super::settings::World;
use super::step_state::StepState;
use super::workspace::Workspace;
use crate::error::PlantError;
use crate::kinematics;
use crate::springs;
use messages::scene::Law;

/// Iterations of the rule in flight at most; one is typical.
const MAX_ITERATIONS: usize = 60;
/// The mean velocity has converged when the next iteration would change it by less than this, relative to 1 + |ẋ| [-]. The prediction
/// assumes linear convergence, by the contraction that was measured last.
const CONVERGED: f64 = 1e-13;
/// Factor by which the measured contraction of the iteration is raised per step [-]. A step with a single iteration measures no contraction,
/// and the contraction may have become worse because the motion has become faster.
const CONTRACTION_GROWTH: f64 = 1.05;
/// Least contraction that is assumed, relative to the greatest velocity [-]. b is quadratic in the velocity, so the contraction of a system of links
/// is about as great as their rates. One that was measured at rest, or where the links moved alike, may be zero; after a push it is not.
const LEAST_CONTRACTION: f64 = 0.1;
/// Landings at which a step is split at most. Later landings take effect at the end of the step.
const MAX_LANDINGS: usize = 3;
/// The same with restitution, per contact point [-]. A point that bounces needs several steps until it lands again.
const LANDINGS_PER_POINT: usize = 2;
/// Least part of a step whose acceleration helps to predict the next step [-]. A point that lands closes its gap with the speed that a whole step
/// needs. With steps of 1 ms, a shorter part would make an acceleration of more than 1 % of g of that speed.
const LEAST_KNOWN: f64 = 0.05;

/// A part of a step.
#[derive(Clone, Copy, Debug)]
struct Part {
    /// Length of the part, and of the whole step [s].
    h: f64,
    whole: f64,
    /// Whether points that land in this part are ignored.
    skips_landings: bool,
}

impl Plant {
    /// x_m = x ⊕ ½hẋ₋; ẋ₊ = ẋ₋ + H⁻¹(Δf_b + KΔf) with H and K at x_m, b at (x_m, ẋ̄); x₊ = x_m ⊕ ½hẋ₊; the law holds for K₊ᵀẋ₊.
    ///
    /// In flight ẋ̄ = ½(ẋ₋ + ẋ₊): the step is symmetric in time, and its energy oscillates by h² without drift. If springs of joints swing, that
    /// needs x_m = x ⊕ ½hẋ̄ and x₊ = x ⊕ hẋ̄ as well, as in [`Plant::implicit_midpoint`]. In contact ẋ̄ = ẋ₋ + ½hẍ, with the acceleration of the
    /// step before. With `SpringDamper` ẋ̄ = ẋ₋, because contact springs may oscillate from step to step. [`Prediction`] explains the law at the
    /// end pose. Springs and dampers of joints are implicit.
    ///
    /// A fast landing splits the step: the motion to the ground without that contact, the impact, and the rest. A landing that takes effect at the
    /// end of the step does not bounce; with restitution the step is then flagged as a fallback.
    ///
    /// # Source
    /// Moreau (1988); Jean, *The non-smooth contact dynamics method* (1999), with θ = ½; Hairer, Lubich & Wanner, *Geometric Numerical
    /// Integration*, V.
    pub(super) fn midpoint_contact(&mut self, h: f64) -> Result<(), PlantError> {
        let mut rest = Part { h, whole: h, skips_landings: false };
        let bounces = self.world.settings.restitution > 0.0;
        let most = if bounces { LANDINGS_PER_POINT * self.world.model.contact_points.len() } else { MAX_LANDINGS };
        for _ in 0..most {
            let Some(landing) = self.advance_to_landing(rest)? else {
                self.finish(rest);
                return Ok(());
            };
            rest.h -= landing.time;
            self.impact_at_landing(landing, rest)?;
            if rest.h <= 0.0 {
                return Ok(());
            }
        }
        self.find_end(rest)?;
        self.state.record.flag(bounces && self.work.lands());
        self.finish(rest);
        Ok(())
    }

    /// Computes H, b and the factor of H at the middle of the step. They do not depend on the torques.
    pub(super) fn evaluate_midpoint(&mut self, h: f64) -> Result<(), PlantError> {
        let Plant { world, state: StepState { now, .. }, work: Workspace { next: middle, .. }, .. } = self;
        middle.state.copy(&now.state);
        middle.integrate_position(world, 0.5 * h)?;
        self.predict_mean(h);
        let Workspace { next: middle, mean, dynamics, .. } = &mut self.work;
        dynamics.find_at_midpoint(&self.world.model, middle, mean, h)
    }

    /// Predicts the mean velocity from the acceleration of the step before.
    fn predict_mean(&mut self, h: f64) {
        let Plant { world, state: StepState { now, last_acceleration, .. }, work, .. } = self;
        let Workspace { next: middle, mean, .. } = work;
        mean.copy_from_slice(&now.state.xdot);
        if last_acceleration.known && world.settings.law != Law::SpringDamper {
            last_acceleration.add(h, mean);
        }
        kinematics::velocities(&world.model, mean, &mut middle.pose);
    }

    /// Computes the end of a part of a step, in [`Workspace`].
    fn find_end(&mut self, part: Part) -> Result<(), PlantError> {
        self.predict_free_motion(part)?;
        self.solve_contact(part)?;
        self.work.integrate_position(&self.world, part.h)
    }

    /// Predicts the motion of a part of a step without contact, and lists the points that may touch.
    fn predict_free_motion(&mut self, part: Part) -> Result<(), PlantError> {
        if !self.work.dynamics.take_prepared() {
            self.evaluate_midpoint(part.h)?;
        }
        self.find_free_motion(part)
    }

    /// The same where H and b are those of the part.
    fn find_free_motion(&mut self, part: Part) -> Result<(), PlantError> {
        let Part { h, whole, skips_landings } = part;
        let Plant { world, state: StepState { now, memory, last_acceleration, .. }, work, .. } = self;
        let contraction = &mut last_acceleration.contraction;
        let Workspace { next: middle, mean, dynamics, free, touches, .. } = work;
        let swings = world.model.has_springs();
        let mut last = f64::INFINITY;
        *contraction *= CONTRACTION_GROWTH;
        for round in 0..MAX_ITERATIONS {
            let rate = free.velocity(world, middle, dynamics, h); // (12)
            if round == 0 {
                let prediction = Prediction::of(now, middle, rate, [h, whole]);
                if !touches.find_predicted(world, &prediction, memory, skips_landings).list.is_empty() {
                    break;
                }
            }
            let change = update_mean(mean, &middle.state.xdot, rate);
            if last > 0.0 && last < f64::INFINITY {
                *contraction = change / (last * h); // at rest nothing changes, and there is none
            }
            let posed = !swings || round > 0; // the first pose does not depend on ẋ̄
            let fastest = greatest_size(mean.iter().copied()); // whatever its unit: that of the base may cost an iteration, but no accuracy
            let factor = contraction.max(LEAST_CONTRACTION * fastest) * h;
            if posed && (change <= CONVERGED || change * factor <= CONVERGED) {
                break;
            }
            if round + 1 == MAX_ITERATIONS {
                check_convergence(world, change, MAX_ITERATIONS)?;
            }
            last = change;
            if swings {
                middle.set_displaced(world, &now.state, |i| 0.5 * h * mean[i], &now.state.xdot)?;
            }
            kinematics::velocities(&world.model, mean, &mut middle.pose);
            if swings {
                dynamics.find_with_guess(&world.model, middle, mean, h)?;
            } else {
                dynamics.with_bias_at(&world.model, middle, mean);
            }
        }
        Ok(())
    }

    /// Solves the contact problem for the predicted motion.
    fn solve_contact(&mut self, part: Part) -> Result<(), PlantError> {
        let Plant { world, state: StepState { now, memory, .. }, work, .. } = self;
        let Workspace { next: middle, dynamics, free, touches, contacts, .. } = work;
        let free = free.found(middle, dynamics);
        let prediction = Prediction::of(now, middle, free.rate, [part.h, part.whole]);
        contacts.solve(world, &free, touches, Some(&prediction), memory).map(|_| ())
    }

    /// Solves a part again that was solved before with another length or acceleration. `predict` predicts its motion without contact, from the
    /// memory of the step before, which [`Workspace`] has remembered.
    fn solve_again(
        &mut self,
        part: Part,
        predict: impl FnOnce(&mut Plant, Part) -> Result<(), PlantError>,
    ) -> Result<(), PlantError> {
        std::mem::swap(&mut self.state.memory, &mut self.work.remembered);
        predict(self, part)?;
        std::mem::swap(&mut self.state.memory, &mut self.work.remembered);
        if self.world.settings.law != Law::Cone {
            // `Cone` starts from the last solution; other laws, such as `Lagged`, need the memory of the step before
            self.state.memory.copy(&self.work.remembered);
        }
        self.solve_contact(part)
    }

    /// If the acceleration of the step before is unknown, repeats the contact problem with the acceleration that was just found. Only b changes.
    fn repeat_with_acceleration(&mut self, part: Part) -> Result<(), PlantError> {
        let Plant { world, state: StepState { now, last_acceleration, .. }, work, .. } = self;
        if last_acceleration.known
            || world.settings.law == Law::SpringDamper
            || work.contacts.contact.impulses.is_empty()
        {
            return Ok(()); // in flight the mean velocity is iterated in any case
        }
        last_acceleration.set(&now.state.xdot, &work.contacts.contact.rate, part.h, false);
        self.predict_mean(part.h);
        let Workspace { next: middle, mean, dynamics, .. } = &mut self.work;
        dynamics.with_bias_at(&self.world.model, middle, mean);
        self.solve_again(part, Plant::find_free_motion)
    }

    /// Accepts the end that was computed as the present state. Stores its acceleration if it helps to predict the next step. It does not after a
    /// part that is too short, after an impact that a damper feels for a while, and in flight with springs, which may swing fast.
    fn finish(&mut self, part: Part) {
        let Plant { world, state: StepState { now, last_acceleration, .. }, work, .. } = self;
        let contact = &work.contacts.contact;
        let flies = contact.impulses.is_empty();
        let is_long = part.h == part.whole || part.h >= LEAST_KNOWN * part.whole && !world.model.has_dampers();
        if is_long && !(flies && world.model.has_springs()) {
            last_acceleration.set(&now.state.xdot, &contact.rate, part.h, flies);
        } else {
            last_acceleration.forget();
        }
        self.accept();
    }

    /// Accepts the end that was computed as the present state.
    fn accept(&mut self) {
        let Plant { state: StepState { now, record, .. }, work, .. } = self;
        record.take(&work.contacts.contact, 1.0);
        std::mem::swap(now, &mut work.next);
    }
}

impl Workspace {
    /// Moves the next state from the middle of the step to its end: x₊ = x_m ⊕ ½hẋ₊; in flight with springs x_m ⊕ ½hẋ̄. Joints with dampers in
    /// flight as in [`springs::move_by_weighted_mean`].
    fn integrate_position(&mut self, world: &World, h: f64) -> Result<(), PlantError> {
        let Workspace { next, contacts, dynamics, mean, .. } = self;
        let (model, rate) = (&world.model, &contacts.contact.rate);
        let flies = contacts.contact.impulses.is_empty();
        if flies {
            let (rates, x) = ([&next.state.xdot[..], rate], &mut next.state.x);
            springs::move_by_weighted_mean(model, &dynamics.end_weights, h, rates, x);
        }
        let swings = flies && model.has_springs();
        next.state.xdot.copy_from_slice(if swings { mean } else { rate });
        next.integrate_position(world, 0.5 * h)?;
        if swings {
            next.state.xdot.copy_from_slice(rate);
            kinematics::velocities(model, rate, &mut next.pose);
        }
        Ok(())
    }
}
