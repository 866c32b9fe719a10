//! Event-driven integration: contact forces in every stage, with impacts and ends of slip located in time.
//!
//! Between events a contact is active (its gap and normal velocity are zero) or open, and an active contact sticks or slips. Contact forces
//! follow from accelerations by the same law by which impulses follow from velocities:
//!
//! ```text
//!   a = A f + Kᵀẍ_f + K̇ᵀẋ,   0 ≤ f_N ⟂ a_N ≥ 0,   sticking: |f_F| ≤ μ f_N against a_F,   slipping: f_F = −μ f_N v_F/|v_F|
//! ```
//!
//! The motion is thus the solution of an ordinary differential equation, which any Runge-Kutta method solves to its order. Gap and normal
//! velocity of active contacts drift by the method's error; Baumgarte terms drive them back to zero.
//!
//! If a gap closes or a slip ends within a step, the step is repeated up to that event. A gap that closes with speed causes an impact
//! there: the contact law on velocities at this pose. Events without a jump of velocity (friction reaches its limit, a contact opens) only
//! bend the acceleration, and the step size control handles them.
//!
//! # Source
//! Acary & Brogliato, *Numerical Methods for Nonsmooth Dynamical Systems* (2008), ch. 8; Pfeiffer & Glocker, *Multibody Dynamics with
//! Unilateral Contacts* (1996), ch. 6; Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*, II.6; Baumgarte (1972).

mod active_set;

use super::Plant;
use super::event_contact::EventContact;
use super::scales::{natural_rate, typical_length};
use super::settings::Settings;
use super::stages::{DOP853, DOP853_ERRORS, RK4, Tableau};
use super::step_size::{MIN_FACTOR, SAFETY, SHORTEST_BETWEEN_EVENTS};
use super::step_state::StepState;
use super::workspace::Workspace;
use crate::error::PlantError;
use crate::model::ContactPoint;
use crate::truth::Record;
use active_set::slip;

/// An event is located when its gap or slip is this small relative to that at the beginning of the step [-].
const LOCATED: f64 = 1e-13;
/// Events per step at most. If there are more (a ball at the end of its bounces), `MidpointContact` integrates the rest of the step, and the step is
/// flagged as a fallback.
const MAX_EVENTS: u32 = 40;
/// Parts per step at most. If forces alternate between two values (a contact between slip and stick), no part is short enough for the
/// error control. Then `MidpointContact` integrates the rest of the step, and the step is flagged as a fallback.
const MAX_PARTS: u32 = 2000;
/// Trials to locate an event at most; about eight are typical.
const MAX_TRIALS: usize = 100;
/// Greatest factor from one step of the error control to the next [-].
const MAX_FACTOR: f64 = 5.0;
/// 1/8: the combined error estimate of DOP853 goes with h⁸ [-].
const ERROR_EXPONENT: f64 = 0.125;
/// Weight of the squared error of third order in the combined estimate of DOP853 [-].
const THIRD_ORDER_WEIGHT: f64 = 0.01;
/// Energy that contact forces may make in a part, relative to ẋ₋·Hẋ₋ + M g l, l being the length of the robot [-]. The recovery of points inside the
/// ground makes a twentieth of that in a step. Where contacts jam it exceeds all bounds.
const ENERGY_MADE: f64 = 0.01;
/// Two times that differ by less than this part of the step are equal to rounding [-].
const TIME_ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Factor on the value at an end of the bracket that stays twice, in the Illinois form of regula falsi [-].
const ILLINOIS: f64 = 0.5;

impl Plant {
    /// The classical method of fourth order from event to event; one step if there is no event.
    pub(super) fn rk4_impact(&mut self, h: f64) -> Result<(), PlantError> {
        self.integrate_between_events(h, &RK4, false)
    }

    /// Dormand and Prince's method of eighth order from event to event, with error control.
    pub(super) fn event_driven(&mut self, h: f64) -> Result<(), PlantError> {
        self.integrate_between_events(h, &DOP853, true)
    }

    fn integrate_between_events(&mut self, h: f64, tableau: &Tableau, controlled: bool) -> Result<(), PlantError> {
        let (mut done, mut events, mut parts) = (0.0, 0, 0);
        while done < h {
            if events == MAX_EVENTS || parts == MAX_PARTS {
                self.state.last_acceleration.forget();
                self.state.record.flag(true);
                return self.midpoint_contact(h - done);
            }
            parts += 1;
            self.update_active_set()?;
            self.work.start.copy(&self.state.now.state);
            self.work.remembered.copy(&self.state.memory);
            let (rest, record) = (h - done, self.state.record);
            if self.state.memory.jams() {
                return self.end_by_impulses(rest, record); // a point that jams inside the ground stays there
            }
            self.state.memory.set_jams(false); // something has moved
            let mut part = if controlled { self.controlled(tableau, rest)? } else { self.uncontrolled(tableau, rest)? };
            if let Some(beyond) = part
                && self.margin(beyond) < 0.0
            {
                part = self.locate(tableau, beyond, record)?;
                self.events += 1;
                events += 1;
            }
            let Some(part) = part.filter(|_| !self.contact_makes_energy()) else {
                return self.end_by_impulses(rest, record);
            };
            // the last part may fall short of h by rounding
            done = if part == rest { h } else { done + part };
        }
        Ok(())
    }

    /// Whether the contact forces of the part that was just computed have raised the energy. Near a jam they grow beyond all bounds, and a step over
    /// that moment throws the robot.
    ///
    /// With the velocity change Δ that they cause, the gain is Δ·H(ẋ₊ − ½Δ). Forces of plastic contact never have one.
    fn contact_makes_energy(&self) -> bool {
        let Plant { world, state: StepState { now, .. }, work: Workspace { start, stages, dynamics, .. }, .. } = self;
        let (change, before, after) = (&stages.contact_change, &start.xdot, &now.state.xdot);
        let energy = |a: &[f64], b: &[f64]| dynamics.inertia.product(&world.model, a, b);
        let [both, own] = [energy(change, after), energy(change, change)];
        let gain = both - 0.5 * own;
        let natural = world.model.mass() * (typical_length(world) * natural_rate(world)).powi(2);
        gain.is_nan() || gain > ENERGY_MADE * (natural + energy(before, before))
    }

    /// The rest of a step in which the contacts jam, by `MidpointContact`: an impulse ends the slip for which no force exists. The step is
    /// flagged as a fallback, because it is of first order.
    fn end_by_impulses(&mut self, rest: f64, record: Record) -> Result<(), PlantError> {
        let Plant { world, state: StepState { now, .. }, work, .. } = self;
        now.state.copy(&work.start);
        now.update_pose(world)?;
        self.state.record = record;
        self.state.record.flag(true);
        self.state.last_acceleration.forget();
        self.midpoint_contact(rest)
    }

    /// One step over `part`; `None` if no force exists.
    fn uncontrolled(&mut self, tableau: &Tableau, part: f64) -> Result<Option<f64>, PlantError> {
        let exists = self.integrate(tableau, part)?;
        Ok(exists.then_some(part))
    }

    /// One step with an error within the tolerance, of length `rest` or less. Returns its length; `None` if no force exists, however short it
    /// is.
    fn controlled(&mut self, tableau: &Tableau, rest: f64) -> Result<Option<f64>, PlantError> {
        let Settings { h, tolerance_step: tolerance, .. } = self.world.settings;
        let record = self.state.record;
        let mut part = self.state.next_step.min(rest);
        loop {
            let exists = self.integrate(tableau, part);
            let error = match exists {
                Err(failure) if part <= SHORTEST_BETWEEN_EVENTS * h => return Err(failure),
                Err(_) => f64::INFINITY, // the step is so long that a stage leaves the range of numbers
                Ok(false) => f64::INFINITY, // a shorter step may not reach the jam
                Ok(true) => self.error_estimate(part),
            };
            let best = part * (SAFETY * libm::pow(tolerance / error, ERROR_EXPONENT)).clamp(MIN_FACTOR, MAX_FACTOR);
            // a step that `rest` has shortened is no measure for the next one
            let next = if part < self.state.next_step && best > part { self.state.next_step } else { best };
            self.state.next_step = next.clamp(SHORTEST_BETWEEN_EVENTS * h, h);
            if error <= tolerance || part <= SHORTEST_BETWEEN_EVENTS * h {
                return Ok(exists?.then_some(part));
            }
            self.rejected += 1;
            self.state.record = record;
            part = self.state.next_step;
        }
    }

    /// Combined error of the step over `part` that was just computed, by the two embedded estimates.
    fn error_estimate(&self, part: f64) -> f64 {
        let [fifth, third] = DOP853_ERRORS.map(|weights| self.work.stages.sum(&self.work.start, weights, part));
        // a square that underflows leaves no error; without the comparison it would leave 0/0
        if fifth * fifth > 0.0 {
            fifth * fifth / (fifth * fifth + THIRD_ORDER_WEIGHT * third * third).sqrt()
        } else {
            0.0
        }
    }

    /// Distance to the next event within the part of the step that was just computed: the least of all open gaps and slips, each relative to its
    /// value at the beginning of the part. Negative beyond the event, and beyond the edge of a tile. A gap may be negative for a time within
    /// the part only.
    fn margin(&self, part: f64) -> f64 {
        if self.crosses_an_edge() {
            return -1.0;
        }
        let pose = &self.state.now.pose;
        let margin = |(id, (point, contact)): (usize, (&ContactPoint, &EventContact))| match (
            contact.active,
            contact.sticking,
        ) {
            (true, true) => 1.0,
            (true, false) => slip(pose, point).dot(&contact.slip_direction) / contact.speed,
            (false, _) => {
                let arm = pose.lowest(point);
                let gap = self.world.input.ground.gap_at(pose, &arm, id);
                if contact.gap.is_finite() && point.may_touch(pose.reference.x + arm.x) {
                    let rate = pose.links[point.link].velocity.at(&arm).z;
                    least_gap([contact.gap, gap], [contact.rate, rate], part) / contact.gap
                } else {
                    1.0
                }
            }
        };
        let points = self.world.model.contact_points.iter().zip(&self.state.event_contacts);
        points.enumerate().map(margin).fold(1.0, f64::min)
    }

    /// Repeats the step up to its first event. Returns the length; `None` if no force exists there. Its margin must be negative.
    ///
    /// # Source
    /// Regula falsi in the Illinois form: Dahlquist & Björck, *Numerical Methods* (1974), 6.2.
    fn locate(&mut self, tableau: &Tableau, part: f64, record: Record) -> Result<Option<f64>, PlantError> {
        let (mut before, mut ahead) = ((0.0, 1.0), (part, self.margin(part)));
        let (mut time, mut exists, mut late) = (part, true, None);
        for _ in 0..MAX_TRIALS {
            time = ahead.0 - (ahead.0 - before.0) * ahead.1 / (ahead.1 - before.1);
            self.state.record = record;
            exists = self.integrate(tableau, time)?;
            let margin = self.margin(time);
            let narrow = ahead.0 - before.0 <= TIME_ROUNDING * part;
            if narrow && margin > LOCATED && self.world.model.ground.is_some() {
                time = ahead.0; // beyond the edge of a tile, where the margin jumps
                self.state.record = record;
                exists = self.integrate(tableau, time)?;
            }
            if margin.abs() <= LOCATED || narrow {
                break;
            }
            // the Illinois rule: if the same end of the interval stays twice, its value is halved, so that it moves at last
            let side = margin < 0.0;
            if side {
                ahead = (time, margin);
            } else {
                before = (time, margin);
            }
            if late == Some(side) {
                let other = if side { &mut before } else { &mut ahead };
                other.1 *= ILLINOIS;
            }
            late = Some(side);
        }
        Ok(exists.then_some(time))
    }
}

/// The least gap within a time [m], from its values and rates at both ends: that of the cubic through them. Only a gap that falls first and rises
/// last is least in between.
fn least_gap([start, end]: [f64; 2], [start_rate, end_rate]: [f64; 2], time: f64) -> f64 {
    if start_rate >= 0.0 || end_rate <= 0.0 {
        return start.min(end);
    }
    let [first, last] = [start_rate, end_rate].map(|rate| rate * time);
    let square = 3.0 * (end - start) - 2.0 * first - last;
    let cube = 2.0 * (start - end) + first + last;
    let lowest = -first / (square + (square * square - 3.0 * cube * first).sqrt()); // the zero of first + 2 square s + 3 cube s²
    start + lowest * (first + lowest * (square + lowest * cube))
}
