//! Errors of a plant, one clear sentence each.

use crate::contact::Problem;
use messages::scene::Law;
use thiserror::Error;

/// Why a plant could not be built or could not take a step.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PlantError {
    /// The tree has no root, or several roots.
    #[error("exactly one body, the base, must be without a joint, but there are {}: [{}]", .names.len(), .names.join(", "))]
    Base {
        /// Bodies without a joint.
        names: Vec<String>,
    },
    /// Two bodies with one name.
    #[error("two bodies are called `{name}`, but names must differ")]
    Duplicate {
        /// The name.
        name: String,
    },
    /// A name that no body has.
    #[error("{what} names the body `{name}`, but there are only: {known}")]
    Unknown {
        /// Key or option that refers to the name.
        what: String,
        /// The unknown name.
        name: String,
        /// Names of the bodies.
        known: String,
    },
    /// Bodies that are each other's ancestors.
    #[error("the parents of body `{body}` lead in a circle and never to the base")]
    Cycle {
        /// A body of the cycle, or below it.
        body: String,
    },
    /// A value outside its range.
    #[error("{what} is {value}, but it must be {rule}")]
    Value {
        /// Quantity and owner.
        what: String,
        /// The value.
        value: String,
        /// The allowed values.
        rule: String,
    },
    /// The inertia matrix is not positive definite: model or state no longer describe masses.
    #[error("the inertia matrix has the pivot {pivot} at degree of freedom {dof}, but it must be positive and finite")]
    Singular {
        /// Index of the degree of freedom.
        dof: usize,
        /// The pivot.
        pivot: f64,
    },
    /// A law that should be exact missed its tolerance.
    #[error("contact problem of step {} at t = {time:.4} s: {law} leaves a residual of {residual:.1e}, but plant.tolerance is {tolerance:.1e}", .step)]
    Unsolved {
        /// Number of the step, the first being 0.
        step: u64,
        /// Simulated time at its beginning [s].
        time: f64,
        /// The law.
        law: Law,
        /// Natural map of the law's own conditions, relative to the step's scale; NaN if there is no impulse [-].
        residual: f64,
        /// `plant.tolerance` [-].
        tolerance: f64,
        /// The problem.
        problem: Box<Problem>,
    },
    /// Plastic contact raised the energy. No impulse that obeys its law can do that.
    #[error(
        "contact at t = {time:.4} s: the impulses of {law} raise the energy by {gain:.1e} J, with a residual of {residual:.1e}; for this scene plant.dt is too long, plant.friction is too large, or the masses differ too much"
    )]
    GainsEnergy {
        /// Simulated time at the step's beginning [s].
        time: f64,
        /// The law.
        law: Law,
        /// Energy after the step minus that without contact [J].
        gain: f64,
        /// Natural map of the law's own conditions [-].
        residual: f64,
    },
    /// The simulation has diverged.
    #[error("the state is no longer finite at t = {time:.4} s: the step plant.dt is too long for this scene")]
    NotFinite {
        /// Simulated time [s].
        time: f64,
    },
    /// A rotation rate at which a step cannot tell the direction of rotation.
    #[error(
        "at t = {time:.4} s a body or a joint turns at {rate:.1e} rad/s, by more than half a turn in a step of {dt} s: plant.dt is too long for this scene"
    )]
    Spins {
        /// Simulated time [s].
        time: f64,
        /// The rotation rate [rad/s].
        rate: f64,
        /// The step [s].
        dt: f64,
    },
    /// Virtual joints at their singular pitch, or so near it that they turn too fast for a step.
    #[error(
        "at t = {time:.4} s the base is near 90° pitch, where the virtual joints lose a direction: use plant.base = \"quaternion\""
    )]
    Gimbal {
        /// Simulated time [s].
        time: f64,
    },
    /// A step whose iteration does not converge.
    #[error("the step at t = {time:.4} s does not converge: {reason}")]
    NotConverged {
        /// Simulated time at the step's beginning [s].
        time: f64,
        /// The quantity that still changes.
        reason: String,
    },
}

impl PlantError {
    /// A [`PlantError::Value`].
    pub(crate) fn value(what: impl Into<String>, value: impl std::fmt::Debug, rule: impl Into<String>) -> Self {
        PlantError::Value { what: what.into(), value: format!("{value:?}"), rule: rule.into() }
    }
}
