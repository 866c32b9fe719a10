//! Steps that end where something happens: contact forces in every stage, impacts and ends of slip located.
//!
//! Between events a contact bears (its gap and normal velocity are zero) or is open, and one that bears sticks or slips. Its
//! force follows from the accelerations by the same law that impulses follow from velocities:
//!
//! ```text
//!   a = A f + Kᵀẍ_f + K̇ᵀẋ,   0 ≤ f_N ⟂ a_N ≥ 0,   sticking: |f_F| ≤ μ f_N against a_F,   slipping: f_F = −μ f_N v_F/|v_F|
//! ```
//!
//! so the motion is that of an ordinary differential equation, which any Runge-Kutta method solves to its order. Gap and
//! velocity of what bears, zero but for the method's error, are drawn back to zero (Baumgarte).
//!
//! A step in which a gap closes or a slip ends is taken again, only as far as that. There a gap that closed with speed is an
//! impact: the contact law on velocities at this very pose. What changes without a jump of velocity (friction reaching its
//! limit, lift-off) bends the acceleration and is left to the step control.
//!
//! # Source
//! Acary & Brogliato, *Numerical Methods for Nonsmooth Dynamical Systems* (2008), ch. 8; Pfeiffer & Glocker, *Multibody
//! Dynamics with Unilateral Contacts* (1996), ch. 6; Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*,
//! II.6; Baumgarte (1972).

use super::runge_kutta::{DOP853, DOP853_ERRORS, RK4, Tableau};
use super::{Plant, Workspace};
use crate::detect::Touch;
use crate::error::PlantError;
use crate::kinematics::{self, Pose};
use crate::model::Corner;
use crate::truth::Record;
use nalgebra::Vector3;

/// A corner bears up to this gap [m]; an impact is located to 1e-15 m, so what has landed is far below it.
const BEARS: f64 = 1e-8;
/// Rate at which gap and velocity of what bears are drawn back to zero [1/s]. Slow: the stages of a step are off the ground
/// by h², and what pulls them there costs the method its order.
const SETTLES: f64 = 20.0;
/// What approaches the ground faster than this hits it [m/s].
const HITS: f64 = 1e-6;
/// What moves slower than this along the ground sticks [m/s].
const STICKS: f64 = 1e-6;
/// What is accelerated less than this sticks on [m/s²].
const HELD: f64 = 1e-6;
/// Tangential acceleration that tells the law of a slip [m/s²]: more than any that friction could stop.
const SLIP: f64 = 1e3;
/// A slip slower than this, beside that at the step's beginning, keeps its direction of then.
const NEARLY_STOPPED: f64 = 1e-6;
/// An event is located when its gap or slip is this small beside that at the step's beginning.
const LOCATED: f64 = 1e-13;
/// Events in a step at most. Where they crowd (a ball at the end of its bounces) the rest of the step is one impulse.
const EVENTS: u32 = 40;
/// Parts of a step at most. Where a law's forces jump at random (an iteration that has not converged) none is short enough.
const PARTS: u32 = 2000;
/// Trials of locating an event at most; it takes about eight.
const TRIALS: usize = 100;
/// Shortest step of the error control, as a part of dt: short enough that a bend of the acceleration costs nothing to speak of,
/// long enough that a contact which cannot make up its mind ends.
const SHORTEST: f64 = 1e-4;

/// What a corner does: as it was when a step began, and as its last force says.
///
/// Gap and slip of a contact that bears or sticks drift by the method's error. So it goes on doing so for as long as its
/// force does, however far it has drifted.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bearing {
    /// It carries, or would if pressed.
    bears: bool,
    /// Bearing, it does not move along the ground.
    sticks: bool,
    /// Height above the ground; infinite where there is none [m].
    gap: f64,
    /// Direction of slip …
    along: Vector3<f64>,
    /// … and its speed [m/s].
    speed: f64,
    /// The last force presses.
    pressed: bool,
    /// The last force leaves no acceleration along the ground.
    held: bool,
}

impl Plant {
    /// The classical method of fourth order from event to event, one step where nothing happens.
    pub(super) fn rk4_impact(&mut self, h: f64) -> Result<(), PlantError> {
        self.through_events(h, &RK4, false)
    }

    /// Dormand & Prince's method of eighth order from event to event, in steps as short as the tolerance asks for.
    pub(super) fn event_driven(&mut self, h: f64) -> Result<(), PlantError> {
        self.through_events(h, &DOP853, true)
    }

    fn through_events(&mut self, h: f64, tableau: &Tableau, controlled: bool) -> Result<(), PlantError> {
        let (mut done, mut events, mut parts) = (0.0, 0, 0);
        while done < h {
            if parts == PARTS {
                let (time, law) = (self.steps as f64 * self.settings.h, self.settings.law);
                let reason = format!(
                    "after {PARTS} parts it is not done; the forces of {law} jump too much for its error control"
                );
                return Err(PlantError::Unsettled { time, reason });
            }
            parts += 1;
            if events == EVENTS {
                return self.midpoint_moreau(h - done);
            }
            self.land()?;
            self.begin();
            let (rest, record) = (h - done, self.record);
            let part = if controlled { self.controlled(tableau, rest)? } else { self.uncontrolled(tableau, rest)? };
            let mut reached = part;
            if self.margin() < 0.0 {
                reached = self.locate(tableau, part, record)?;
                self.counts.events += 1;
                events += 1;
            }
            // the last part may fall short of h by rounding
            done = if reached == rest { h } else { done + reached };
        }
        Ok(())
    }

    /// One step over `part`.
    fn uncontrolled(&mut self, tableau: &Tableau, part: f64) -> Result<f64, PlantError> {
        self.integrate(tableau, part, Plant::accelerate_on_ground)?;
        Ok(part)
    }

    /// One step with an error within the tolerance, over `rest` or less; its length.
    fn controlled(&mut self, tableau: &Tableau, rest: f64) -> Result<f64, PlantError> {
        let (h, tolerance, record) = (self.settings.h, self.settings.tolerance_step, self.record);
        let mut part = self.stride.min(rest);
        loop {
            self.integrate(tableau, part, Plant::accelerate_on_ground)?;
            let [fifth, third] = DOP853_ERRORS.map(|weights| self.work.stages.sum(weights, part));
            let error = if fifth > 0.0 { fifth * fifth / (fifth * fifth + 0.01 * third * third).sqrt() } else { 0.0 };
            let best = part * (0.9 * (tolerance / error).powf(0.125)).clamp(0.2, 5.0);
            // a step cut short by `rest` says little about the next one
            let next = if part < self.stride && best > part { self.stride } else { best };
            self.stride = next.clamp(SHORTEST * h, h);
            if error <= tolerance || part <= SHORTEST * h {
                return Ok(part);
            }
            self.counts.rejected += 1;
            self.record = record;
            part = self.stride;
        }
    }

    /// What bears and what sticks now, after the impact of whatever comes down.
    fn land(&mut self) -> Result<(), PlantError> {
        let (pose, mut hits) = (&self.work.pose, false);
        for (corner, bearing) in self.model.corners.iter().zip(&mut self.bearings) {
            let arm = pose.lowest(corner);
            let at = pose.reference + arm;
            bearing.gap = if corner.has_ground(at.x) { at.z } else { f64::INFINITY };
            let bore = bearing.bears && bearing.pressed && bearing.gap.is_finite();
            bearing.bears = bearing.gap <= BEARS || bore;
            hits |= bearing.bears && pose.links[corner.link].velocity.at(&arm).z < -HITS;
        }
        if hits {
            self.hit()?;
        }
        let pose = &self.work.pose;
        for (corner, bearing) in self.model.corners.iter().zip(&mut self.bearings) {
            // what the impact throws off does not bear, though it has no gap yet; what drifts off does
            let rises = pose.links[corner.link].velocity.at(&pose.lowest(corner)).z > HITS;
            if bearing.bears && rises && (hits || !bearing.pressed) {
                (bearing.bears, bearing.gap) = (false, bearing.gap.max(BEARS));
            }
            let slip = slip(pose, corner);
            bearing.speed = slip.norm();
            bearing.sticks = bearing.bears && (bearing.speed <= STICKS || bearing.sticks && bearing.held);
            bearing.along = if bearing.speed > 0.0 { slip / bearing.speed } else { slip };
        }
        Ok(())
    }

    /// Impact: the contact law on the velocities of all that bears, in no time.
    fn hit(&mut self) -> Result<(), PlantError> {
        self.find_inertia(0.0, 0.0)?;
        self.work.free.copy_from_slice(&self.state.xdot);
        self.touch_bearings();
        self.solve_contacts(f64::INFINITY)?; // no time to approach in
        self.record_contacts();
        kinematics::velocities(&self.model, &self.state.xdot, &mut self.work.pose);
        Ok(())
    }

    /// Lists what bears.
    fn touch_bearings(&mut self) {
        let Workspace { pose, touches, .. } = &mut self.work;
        let corners = self.model.corners.iter().zip(&self.bearings).enumerate();
        touches.clear();
        touches.extend(corners.filter(|(_, (_, bearing))| bearing.bears).map(|(id, (corner, _))| {
            let arm = pose.lowest(corner);
            Touch { id, link: corner.link, arm, gap: pose.reference.z + arm.z }
        }));
    }

    /// The acceleration with the forces of all that bears, in `free`; the forces count for the time `weight` in the record.
    fn accelerate_on_ground(&mut self, weight: f64) -> Result<(), PlantError> {
        self.accelerate_freely()?;
        self.touch_bearings();
        if self.work.touches.is_empty() {
            return Ok(());
        }
        let law = self.settings.law;
        let Workspace { pose, composite, factor, free, change, touches, map, problem, solver, .. } = &mut self.work;
        let pull = |i: usize, own: Vector3<f64>| {
            let touch = &touches[i];
            let (corner, bearing) = (&self.model.corners[touch.id], &self.bearings[touch.id]);
            let velocity = pose.links[touch.link].velocity.at(&touch.arm);
            let mut pull = own + composite.swept(&self.model, pose, corner) + velocity * SETTLES;
            pull.z += (velocity.z + touch.gap * SETTLES) * SETTLES;
            if !bearing.sticks {
                // near its end a slip has no direction, and beyond it goes on being braked: the end is a zero of its speed
                let slip = Vector3::new(velocity.x, velocity.y, 0.0);
                let clear = slip.dot(&bearing.along) > NEARLY_STOPPED * bearing.speed;
                let along = if clear { slip.normalize() } else { bearing.along };
                (pull.x, pull.y) = (SLIP * along.x, SLIP * along.y);
            }
            pull
        };
        map.drift(&self.model, pose, touches, free, law, problem, pull);
        map.assemble(&self.model, pose, factor, touches, problem);
        problem.friction.fill(self.settings.friction);
        let report = solver.solve(problem, law, &mut self.memory);
        self.counts.note(&report);
        self.record.note(&report);
        self.settings.check(&report, self.steps, problem)?;
        map.respond(&self.model, factor, &solver.impulse, change);
        let rows = 1 + problem.tangents;
        for (i, (touch, velocity)) in touches.iter().zip(solver.velocity.chunks_exact(rows)).enumerate() {
            let force = map.force(i, &solver.impulse, touches.len());
            self.record.push(touch.id, (force * weight).into());
            let bearing = &mut self.bearings[touch.id];
            bearing.pressed = force.z > 0.0;
            bearing.held = velocity[1..].iter().all(|a| a.abs() <= HELD);
        }
        free.iter_mut().zip(change.iter()).for_each(|(acceleration, change)| *acceleration += change);
        Ok(())
    }

    /// How far the present state is from the next event: the least of every open gap and every slip, each as a part of
    /// what it was when the step began. Negative beyond the event.
    fn margin(&self) -> f64 {
        let pose = &self.work.pose;
        let margin = |(corner, bearing): (&Corner, &Bearing)| match (bearing.bears, bearing.sticks) {
            (true, true) => 1.0,
            (true, false) => slip(pose, corner).dot(&bearing.along) / bearing.speed,
            (false, _) => {
                let at = pose.reference + pose.lowest(corner);
                if bearing.gap.is_finite() && corner.has_ground(at.x) { at.z / bearing.gap } else { 1.0 }
            }
        };
        self.model.corners.iter().zip(&self.bearings).map(margin).fold(1.0, f64::min)
    }

    /// Takes the step again as far as its first event; the way there. Its margin over `part` is negative.
    ///
    /// # Source
    /// Regula falsi in the Illinois form: Dahlquist & Björck, *Numerical Methods* (1974), 6.2.
    fn locate(&mut self, tableau: &Tableau, part: f64, record: Record) -> Result<f64, PlantError> {
        let (mut before, mut ahead) = ((0.0, 1.0), (part, self.margin()));
        let (mut time, mut late) = (part, None);
        for _ in 0..TRIALS {
            time = ahead.0 - (ahead.0 - before.0) * ahead.1 / (ahead.1 - before.1);
            self.record = record;
            self.integrate(tableau, time, Plant::accelerate_on_ground)?;
            let margin = self.margin();
            if margin.abs() <= LOCATED || ahead.0 - before.0 <= 4.0 * f64::EPSILON * part {
                break;
            }
            // an end that stays twice counts half, or it would stay for ever
            let side = margin < 0.0;
            if side {
                ahead = (time, margin);
            } else {
                before = (time, margin);
            }
            if late == Some(side) {
                let other = if side { &mut before } else { &mut ahead };
                other.1 *= 0.5;
            }
            late = Some(side);
        }
        Ok(time)
    }
}

/// Velocity of a corner along the ground [m/s].
fn slip(pose: &Pose, corner: &Corner) -> Vector3<f64> {
    let velocity = pose.links[corner.link].velocity.at(&pose.lowest(corner));
    Vector3::new(velocity.x, velocity.y, 0.0)
}
