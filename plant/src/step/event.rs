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

mod active_set;

use super::Plant;
use super::runge_kutta::{DOP853, DOP853_ERRORS, RK4, Tableau};
use super::settings::Settings;
use super::step_size::{MIN_FACTOR, SAFETY};
use crate::error::PlantError;
use crate::model::ContactPoint;
use crate::truth::Record;
pub(super) use active_set::EventContact;
use active_set::slip;

/// An event is located when its gap or slip is this small beside that at the step's beginning.
const LOCATED: f64 = 1e-13;
/// Events in a step at most. Where they crowd (a ball at the end of its bounces) the rest of the step is one of `MidpointContact`.
const MAX_EVENTS: u32 = 40;
/// Parts of a step at most. Where forces jump to and fro (a contact that begins to slip and sticks again) none is short enough for the error
/// control; then the rest of the step is one of `MidpointContact`, and the step is flagged as a fallback.
const MAX_PARTS: u32 = 2000;
/// Trials of locating an event at most; it takes about eight.
const MAX_TRIALS: usize = 100;
/// Shortest step of the error control, as a part of dt: short enough that a bend of the acceleration costs nothing to speak of,
/// long enough that a contact which cannot make up its mind ends.
const MIN_STEP: f64 = 1e-4;
/// Greatest factor from one step of the error control to the next [-].
const MAX_FACTOR: f64 = 5.0;
/// 1/8: the combined error estimate of DOP853 goes with h⁸ [-].
const ERROR_EXPONENT: f64 = 0.125;
/// Weight of the squared error of third order in the combined estimate of DOP853 [-].
const THIRD_ORDER_WEIGHT: f64 = 0.01;
/// Two times that differ by less than this part of the step are equal to rounding [-].
const TIME_ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Factor on the value at an end of the bracket that stays twice, in the Illinois form of regula falsi [-].
const ILLINOIS: f64 = 0.5;

impl Plant {
    /// The classical method of fourth order from event to event, one step where nothing happens.
    pub(super) fn rk4_impact(&mut self, h: f64) -> Result<(), PlantError> {
        self.integrate_between_events(h, &RK4, false)
    }

    /// Dormand & Prince's method of eighth order from event to event, in steps as short as the tolerance asks for.
    pub(super) fn event_driven(&mut self, h: f64) -> Result<(), PlantError> {
        self.integrate_between_events(h, &DOP853, true)
    }

    fn integrate_between_events(&mut self, h: f64, tableau: &Tableau, controlled: bool) -> Result<(), PlantError> {
        let (mut done, mut events, mut parts) = (0.0, 0, 0);
        while done < h {
            if events == MAX_EVENTS || parts == MAX_PARTS {
                self.last_acceleration.forget();
                self.record.flag(parts == MAX_PARTS);
                return self.midpoint_contact(h - done);
            }
            parts += 1;
            self.update_active_set()?;
            self.work.start.copy(&self.now.state);
            let (rest, record) = (h - done, self.record);
            let part = if controlled { self.controlled(tableau, rest)? } else { self.uncontrolled(tableau, rest)? };
            let mut reached = part;
            if self.margin() < 0.0 {
                reached = self.locate(tableau, part, record)?;
                self.events += 1;
                events += 1;
            }
            // the last part may fall short of h by rounding
            done = if reached == rest { h } else { done + reached };
        }
        Ok(())
    }

    /// One step over `part`.
    fn uncontrolled(&mut self, tableau: &Tableau, part: f64) -> Result<f64, PlantError> {
        self.integrate(tableau, part)?;
        Ok(part)
    }

    /// One step with an error within the tolerance, over `rest` or less; its length.
    fn controlled(&mut self, tableau: &Tableau, rest: f64) -> Result<f64, PlantError> {
        let Settings { h, tolerance_step: tolerance, .. } = self.world.settings;
        let record = self.record;
        let mut part = self.next_step.min(rest);
        loop {
            self.integrate(tableau, part)?;
            let [fifth, third] = DOP853_ERRORS.map(|weights| self.work.stages.sum(&self.work.start, weights, part));
            let error = if fifth > 0.0 {
                fifth * fifth / (fifth * fifth + THIRD_ORDER_WEIGHT * third * third).sqrt()
            } else {
                0.0
            };
            let best = part * (SAFETY * (tolerance / error).powf(ERROR_EXPONENT)).clamp(MIN_FACTOR, MAX_FACTOR);
            // a step cut short by `rest` says little about the next one
            let next = if part < self.next_step && best > part { self.next_step } else { best };
            self.next_step = next.clamp(MIN_STEP * h, h);
            if error <= tolerance || part <= MIN_STEP * h {
                return Ok(part);
            }
            self.rejected += 1;
            self.record = record;
            part = self.next_step;
        }
    }

    /// How far the present state is from the next event: the least of every open gap and every slip, each as a part of
    /// what it was when the step began. Negative beyond the event.
    fn margin(&self) -> f64 {
        let pose = &self.now.pose;
        let margin = |(point, contact): (&ContactPoint, &EventContact)| match (contact.active, contact.sticking) {
            (true, true) => 1.0,
            (true, false) => slip(pose, point).dot(&contact.slip_direction) / contact.speed,
            (false, _) => {
                let at = pose.reference + pose.lowest(point);
                if contact.gap.is_finite() && point.has_ground(at.x) { at.z / contact.gap } else { 1.0 }
            }
        };
        self.world.model.contact_points.iter().zip(&self.event_contacts).map(margin).fold(1.0, f64::min)
    }

    /// Takes the step again as far as its first event; the way there. Its margin over `part` is negative.
    ///
    /// # Source
    /// Regula falsi in the Illinois form: Dahlquist & Björck, *Numerical Methods* (1974), 6.2.
    fn locate(&mut self, tableau: &Tableau, part: f64, record: Record) -> Result<f64, PlantError> {
        let (mut before, mut ahead) = ((0.0, 1.0), (part, self.margin()));
        let (mut time, mut late) = (part, None);
        for _ in 0..MAX_TRIALS {
            time = ahead.0 - (ahead.0 - before.0) * ahead.1 / (ahead.1 - before.1);
            self.record = record;
            self.integrate(tableau, time)?;
            let margin = self.margin();
            if margin.abs() <= LOCATED || ahead.0 - before.0 <= TIME_ROUNDING * part {
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
                other.1 *= ILLINOIS;
            }
            late = Some(side);
        }
        Ok(time)
    }
}
