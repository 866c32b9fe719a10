//! Check that explicit methods are stable with the springs and dampers of the joints.

use super::free::Dynamics;
use super::posed_state::PosedState;
use super::settings::World;
use super::step_size::SHORTEST_BETWEEN_EVENTS;
use crate::error::PlantError;
use messages::scene::Method;

/// Stability limit of h d/H and h √(k/H) for methods of second order [-]. Beyond 2, a damper adds energy.
const SECOND_ORDER: f64 = 2.0;
/// The same for the classical Runge-Kutta method; Hairer & Wanner, *Solving Ordinary Differential Equations II*, IV.2.
const FOURTH_ORDER: f64 = 2.78;
/// The same for Dormand and Prince's method of eighth order: 5.96 for oscillations and 6.39 for decay, from its coefficients.
const EIGHTH_ORDER: f64 = 5.9;

/// Checks that the scene's method is stable with its springs and dampers, at the initial pose.
///
/// # Errors
/// One sentence on the first joint that is too stiff; or if H is not positive definite.
pub(super) fn check(world: &World, now: &PosedState, dynamics: &mut Dynamics) -> Result<(), PlantError> {
    let (h, method) = (world.settings.h, world.settings.method);
    let (shortest, limit) = match method {
        Method::ExplicitEuler | Method::MoreauJean => (h, SECOND_ORDER),
        Method::Rk4 | Method::Rk4Impact => (h, FOURTH_ORDER),
        Method::EventDriven => (SHORTEST_BETWEEN_EVENTS * h, EIGHTH_ORDER), // accepted whatever its error is
        Method::SemiImplicitEuler | Method::MidpointMoreau | Method::MidpointContact => return Ok(()), // implicit
        Method::ImplicitMidpoint | Method::StepDoubling => return Ok(()),
    };
    let model = &world.model;
    let dynamics = dynamics.find(model, now, 0.0)?;
    for spring in &model.springs {
        let name = || {
            let body = model.body_link.iter().position(|&link| link == spring.dof + 1);
            body.map_or("", |body| &model.body_name[body])
        };
        // |1 + hλ|² = 1 − h d/H + h² k/H of an oscillation
        if method == Method::ExplicitEuler && h * spring.stiffness > spring.damping {
            let what = format!("plant.dt × stiffness of the joint of body `{}`", name());
            let rule = format!(
                "at most its damping, {}, for the method ExplicitEuler, which makes an oscillation grow otherwise: take another method",
                spring.damping
            );
            return Err(PlantError::value(what, h * spring.stiffness, rule));
        }
        let mobility = dynamics.factor.mobility(model, spring.dof); // 1/H
        let stiff = shortest * (spring.damping * mobility).max((spring.stiffness * mobility).sqrt());
        if stiff > limit {
            let step = match shortest < h {
                true => format!(", h being the shortest step, {SHORTEST_BETWEEN_EVENTS} plant.dt,"),
                false => String::new(),
            };
            let what = format!("h d/H or h √(k/H) of the joint of body `{}`{step}", name());
            let rule = format!(
                "at most {limit} for the method {method:?}: take a shorter plant.dt, or a method that has springs and dampers implicit, as \
                 MidpointContact, SemiImplicitEuler or ImplicitMidpoint"
            );
            return Err(PlantError::value(what, format!("{stiff:.3}"), rule));
        }
    }
    Ok(())
}
