//! Workspace of the integration methods.

use super::contact::Contacts;
use super::free::{Dynamics, FreeMotion};
use super::last_acceleration::LastAcceleration;
use super::posed_state::PosedState;
use super::stages::Stages;
use super::touches::Touches;
use crate::contact::Memory;
use crate::ground::GroundHeights;
use crate::model::Model;
use crate::state::State;
use messages::scene::{Law, Method};

/// Results of the stages; allocated once.
pub(super) struct Workspace {
    pub dynamics: Dynamics,
    pub free: FreeMotion,
    pub touches: Touches,
    pub contacts: Contacts,
    /// The state that a step leads to: that at its middle until [`Workspace::integrate_position`], then that at its end.
    pub next: PosedState,
    /// Contact memory from before a step that may have to be split, or a part of one that may have to be repeated.
    pub remembered: Memory,
    /// Contact points that land in the step.
    pub landing: Vec<usize>,
    /// State at the beginning of a step, or of a part of it.
    pub start: State,
    pub stages: Stages,
    pub means: Means,
    /// Mean velocity of an implicit step.
    pub mean: Vec<f64>,
    pub doubling: StepDoublingState,
}

impl Workspace {
    pub fn new(model: &Model, law: Law, method: Method) -> Self {
        Workspace {
            dynamics: Dynamics::new(model),
            free: FreeMotion::new(model),
            touches: Touches::new(model),
            contacts: Contacts::new(model, law, method),
            next: PosedState::new(model, State::zero(model)),
            remembered: Memory::of(model.contact_points.len()),
            landing: Vec::with_capacity(model.contact_points.len()),
            start: State::zero(model),
            stages: Stages::new(model),
            means: Means::new(model),
            mean: vec![0.0; model.dofs()],
            doubling: StepDoublingState::new(model),
        }
    }
}

/// Mean values of a step.
pub(super) struct Means {
    /// h a(x, ẋ₋).
    pub start_change: Vec<f64>,
    /// ẋ₋ + h·½(a(x, ẋ₋) + a(x*, ẋ*)).
    pub velocity: Vec<f64>,
}

impl Means {
    pub fn new(model: &Model) -> Means {
        Means { start_change: vec![0.0; model.dofs()], velocity: vec![0.0; model.dofs()] }
    }
}

/// Memories at the beginning of a step, and the result that it is compared with.
pub(super) struct StepDoublingState {
    pub memory: Memory,
    pub last_acceleration: LastAcceleration,
    pub events: u64,
    pub ground: GroundHeights,
    /// State after one step over both halves.
    pub coarse: State,
}

impl StepDoublingState {
    pub fn new(model: &Model) -> StepDoublingState {
        StepDoublingState {
            memory: Memory::of(model.contact_points.len()),
            last_acceleration: LastAcceleration::new(model),
            events: 0,
            ground: GroundHeights::plane(model),
            coarse: State::zero(model),
        }
    }
}
