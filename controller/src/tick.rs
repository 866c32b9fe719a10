//! One control period: from encoder counts to joint torques, through all levels of section 3 of the paper.

mod feed_forward;
mod initial_state;
mod limits;
mod rates;
mod requests;
mod set_points;
mod snapshot;

pub use snapshot::ControllerSnapshot;

use crate::constants::Constants;
use crate::encoder::{EncoderModel, EncoderState};
use crate::error::ControllerError;
use crate::gait::{GaitModel, GaitState};
use crate::load::{LoadModel, LoadState};
use crate::rate::{self, RateSolver};
use crate::servo::{ServoModel, ServoState};
use crate::support::{Chain, Joints, Task, mirror};
use messages::scene::{ControllerScene, Scene};
use messages::wire::{Encoders, Telemetry, Torques};

/// The constant part of the controller.
#[derive(Clone)]
struct ControllerModel {
    scene: ControllerScene,
    gravity: f64,
    torque_limit: f64,
    drive_inertia: f64,
    chain: Chain,
    constants: Constants,
    encoder: EncoderModel,
    load: LoadModel,
    servo: ServoModel,
}

/// The set-points that were last asked for.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct SetPoints {
    /// Period of two steps [s].
    period: f64,
    /// Walking speed [m/s].
    speed: f64,
    /// Simulated time at which the walk ends [s].
    stop_time: Option<f64>,
}

/// The variable part of the controller.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct ControllerState {
    set_points: SetPoints,
    /// Period of two steps that is walked, on the way to its set-point [s].
    period: f64,
    encoder: EncoderState,
    /// Whether the right foot supports.
    right: bool,
    /// Simulated time of the first reading of the encoders [s].
    begin: f64,
    /// `None` until the first reading of the encoders shows the posture of the robot.
    gait: Option<GaitState>,
    /// Load of the swing foot.
    load: LoadState,
    servo: ServoState,
}

/// The paper's walking controller. In each control period it computes torques from encoder counts.
#[derive(Clone)]
pub struct Controller {
    model: ControllerModel,
    state: ControllerState,
    /// The gait with the set-points and the period of the state: [`ControllerModel::planner`].
    planner: GaitModel,
    telemetry: Telemetry,
}

impl Controller {
    /// A controller for the scene.
    ///
    /// # Errors
    /// If the scene has no controller, its bodies are not an eight-axis biped, or its gait is outside the range of this robot; see
    /// [`ControllerError`].
    pub fn new(scene: &Scene) -> Result<Self, ControllerError> {
        let settings = scene.controller.clone().ok_or(ControllerError::NoController)?;
        let period = 1.0 / scene.rate;
        let chain = Chain::new(&scene.bodies)?;
        chain.parameters.check_set_points(settings.gait, settings.period, settings.speed)?;
        let constants = Constants::new(&chain, &settings, &scene.plant)?;
        let weight = chain.total_mass * scene.plant.gravity;
        let model = ControllerModel {
            gravity: scene.plant.gravity,
            torque_limit: scene.plant.torque_limit,
            drive_inertia: scene.plant.drive_inertia,
            encoder: EncoderModel::new(scene.plant.radians_per_count(), period, settings.rate_filter_hz),
            load: LoadModel::new(constants.inertia, weight, period, chain.parameters.time),
            servo: ServoModel::new(&settings, constants.nominal_inertia, period, chain.parameters.time),
            scene: settings,
            chain,
            constants,
        };
        let set_points = SetPoints::of(&model.scene);
        let state = ControllerState {
            set_points,
            period: set_points.period,
            encoder: EncoderState::default(),
            right: false,
            begin: 0.0,
            gait: None,
            load: LoadState::default(),
            servo: ServoState::default(),
        };
        let planner = model.planner(&state);
        Ok(Controller { model, state, planner, telemetry: Telemetry::default() })
    }

    /// Sets the simulated time of the first reading, which is zero otherwise [s]: a controller that takes over in the middle of a run must
    /// know whether the scene's stop time has passed. Call it before the first [`Controller::tick`]; later it has no effect.
    pub fn begin_at(&mut self, time: f64) {
        self.state.begin = time;
    }

    /// One control period: the torques for a reading of the encoders.
    ///
    /// # Errors
    /// [`ControllerError::Singular`] if no joint rates give the task rates.
    pub fn tick(&mut self, encoders: &Encoders) -> Result<Torques, ControllerError> {
        let Controller { model, state, planner, telemetry } = self;
        model.encoder.read(&mut state.encoder, encoders);
        model.detect_initial_state(planner, state);
        let mut task = model.chain.task(&state.in_support_order(&state.encoder.angle)); // (25)-(27)
        let mut gait = state.gait.unwrap_or_else(|| planner.start(&task, state.begin));
        if planner.exchange_due(&gait) {
            planner.exchange(&mut gait, &task);
            if model.lead_set_points(state, &mut gait) {
                *planner = model.planner(state);
            }
            model.servo.exchange(&mut state.servo);
            state.load = state.load.exchanged();
            state.right = !state.right;
            task = model.chain.task(&state.in_support_order(&state.encoder.angle));
        }
        let singular = ControllerError::Singular { time: gait.time };
        let Some(solver) = RateSolver::new(&task.jacobian) else { return Err(singular) };
        let rate = state.in_support_order(&state.encoder.rate);
        let acceleration = model.servo.observe(&mut state.servo, &rate);
        model.load.estimate(&mut state.load, &solver, &acceleration);
        let plan = planner.plan(&mut gait, &task, state.load.load); // (30)-(43)
        state.gait = Some(gait);
        let feed_forward = model.feed_forward(state, &task, &plan);
        let bias = rate::bias(task.swing_pitch / model.chain.parameters.time);
        let reference = model.resolve(state, &solver, &plan, &bias, &rate, &feed_forward).ok_or(singular)?; // (28), (29)
        let limits = model.torque_limits(&gait, &task, &solver, &plan);
        let servo = &model.servo;
        let (torque, surface) = servo.drive(&mut state.servo, &rate, &reference, &feed_forward, &limits, plan.support); // (24)
        state.load.torque = torque;
        *telemetry = telemetry_of(planner, state, &gait, &task, &state.in_support_order(&surface));
        Ok(Torques { torque: state.in_support_order(&torque).into() })
    }

    /// State of the controller in the last control period, for recording.
    pub fn telemetry(&self) -> Telemetry {
        self.telemetry
    }
}

impl SetPoints {
    /// Those of a scene.
    fn of(&ControllerScene { period, speed, stop_time, .. }: &ControllerScene) -> SetPoints {
        SetPoints { period, speed, stop_time }
    }
}

impl ControllerState {
    /// Simulated time of the next reading [s].
    fn time(&self) -> f64 {
        self.gait.map_or(self.begin, |gait| gait.time)
    }

    /// Converts wire order to support order, and back.
    fn in_support_order(self, q: &Joints) -> Joints {
        if self.right { mirror(q) } else { *q }
    }
}

impl ControllerModel {
    /// The gait of a state.
    fn planner(&self, ControllerState { set_points, period, .. }: &ControllerState) -> GaitModel {
        let SetPoints { speed, stop_time, .. } = *set_points;
        let scene = ControllerScene { period: *period, speed, stop_time, ..self.scene.clone() };
        GaitModel::new(&scene, &self.chain, &self.constants, self.servo.period)
    }
}

/// The state of the controller, for recording.
fn telemetry_of(
    planner: &GaitModel,
    state: &ControllerState,
    gait: &GaitState,
    task: &Task,
    surface: &Joints,
) -> Telemetry {
    let [sagittal, lateral] = gait.com;
    Telemetry {
        phase: gait.phase as u32,
        support: u32::from(state.right),
        steps: gait.steps,
        com: task.com().into(),
        swing: task.swing().into(),
        pendulum: [sagittal.x, sagittal.v, lateral.x, lateral.v],
        energy: planner.energies(gait),
        energy_ref: planner.energy_references(gait),
        landing: gait.landing,
        surface: (*surface).into(),
    }
}
