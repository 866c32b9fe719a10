//! What can go wrong in a plant, one clear sentence each.

use crate::contact::Problem;
use messages::scene::Law;
use thiserror::Error;

/// Why a plant could not be built or could not take a step.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PlantError {
    /// The tree has no root, or several.
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
        /// Who names it.
        what: String,
        /// The name.
        name: String,
        /// Names of the bodies.
        known: String,
    },
    /// Bodies that hang from each other.
    #[error("the parents of body `{body}` lead in a circle and never to the base")]
    Cycle {
        /// One body of the circle, or below it.
        body: String,
    },
    /// A value that no body or scene can have.
    #[error("{what} is {value}, but it must be {rule}")]
    Value {
        /// Quantity, and whose it is.
        what: String,
        /// As found.
        value: String,
        /// What would be right.
        rule: String,
    },
    /// The inertia matrix is not positive definite, so the model or its state is no longer one of masses.
    #[error("the inertia matrix has the pivot {pivot} at degree of freedom {dof}, but it must be positive and finite")]
    Singular {
        /// Index of the degree of freedom.
        dof: usize,
        /// The pivot.
        pivot: f64,
    },
    /// A contact law that finds exact solutions has found none.
    #[error("contact problem of step {} at t = {time:.4} s: {law} leaves a residual of {residual:.1e}, but plant.tolerance is {tolerance:.1e}", .step)]
    Unsolved {
        /// Number of the step, the first being 0.
        step: u64,
        /// Simulated time at its beginning [s].
        time: f64,
        /// The law.
        law: Law,
        /// Natural map of the law's own problem, relative to the step's scale; NaN if there is no impulse at all [-].
        residual: f64,
        /// What was asked for [-].
        tolerance: f64,
        /// The problem.
        problem: Box<Problem>,
    },
    /// Plastic contact has raised the energy, which no impulse that obeys its law can.
    #[error(
        "contact at t = {time:.4} s: the impulses of {law} raise the energy by {gain:.1e} J, with a residual of {residual:.1e}; plant.dt is too long for this scene, or its masses differ too much"
    )]
    GainsEnergy {
        /// Simulated time at the step's beginning [s].
        time: f64,
        /// The law.
        law: Law,
        /// Energy after the step less that without contact [J].
        gain: f64,
        /// Natural map of the law's own problem [-].
        residual: f64,
    },
    /// The simulation has blown up.
    #[error("the state is no longer finite at t = {time:.4} s: the step plant.dt is too long for this scene")]
    NotFinite {
        /// Simulated time [s].
        time: f64,
    },
    /// Something turns so fast that a step cannot tell which way.
    #[error(
        "at t = {time:.4} s something turns at {rate:.1e} rad/s, by more than half a turn in a step of {dt} s: plant.dt is too long for this scene"
    )]
    Spins {
        /// Simulated time [s].
        time: f64,
        /// How fast [rad/s].
        rate: f64,
        /// The step [s].
        dt: f64,
    },
    /// Virtual joints that cannot turn every way.
    #[error(
        "at t = {time:.4} s the base stands at 90° pitch, where the virtual joints lose a direction: use plant.base = \"quaternion\""
    )]
    Gimbal {
        /// Simulated time [s].
        time: f64,
    },
    /// A step whose iteration or error control does not settle.
    #[error("the step at t = {time:.4} s does not settle: {reason}")]
    Unsettled {
        /// Simulated time at the step's beginning [s].
        time: f64,
        /// What goes on changing.
        reason: String,
    },
}

impl PlantError {
    /// A [`PlantError::Value`].
    pub(crate) fn value(what: impl Into<String>, value: impl std::fmt::Debug, rule: impl Into<String>) -> Self {
        PlantError::Value { what: what.into(), value: format!("{value:?}"), rule: rule.into() }
    }
}
