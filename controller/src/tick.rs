//! One control period: from encoder counts to joint torques, through all levels of section 3 of the paper.

mod limits;
mod set_points;
mod snapshot;

pub use snapshot::ControllerSnapshot;

use crate::ankle::Ankle;
use crate::constants::Constants;
use crate::encoder::{EncoderModel, EncoderState};
use crate::error::ControllerError;
use crate::gait::{GaitModel, GaitState, Reference};
use crate::load::{LoadModel, LoadState};
use crate::rate::{self, RateSolver};
use crate::resume;
use crate::servo::{ServoModel, ServoState};
use crate::support::{Chain, Joints, Task, mirror};
use messages::scene::{ControllerScene, Gait, Scene};
use messages::wire::{Encoders, JOINTS, Telemetry, Torques};

/// The constant part of the controller. Only the set-points change.
#[derive(Clone)]
struct ControllerModel {
    /// With the set-points that were last asked for. The period that is walked is in `gait`.
    scene: ControllerScene,
    gravity: f64,
    torque_limit: f64,
    drive_inertia: f64,
    chain: Chain,
    constants: Constants,
    encoder: EncoderModel,
    gait: GaitModel,
    load: LoadModel,
    servo: ServoModel,
}

/// The variable part of the controller.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct ControllerState {
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
        if settings.gait == Gait::Walk {
            chain.parameters.check_set_points(&settings)?;
        }
        let constants = Constants::new(&chain, &settings, &scene.plant)?;
        let weight = chain.total_mass * scene.plant.gravity;
        let model = ControllerModel {
            gravity: scene.plant.gravity,
            torque_limit: scene.plant.torque_limit,
            drive_inertia: scene.plant.drive_inertia,
            encoder: EncoderModel::new(scene.plant.radians_per_count(), period, settings.rate_filter_hz),
            gait: GaitModel::new(&settings, &chain, &constants, period),
            load: LoadModel::new(constants.inertia, weight, period, chain.parameters.time),
            servo: ServoModel::new(&settings, constants.nominal_inertia, period, chain.parameters.time),
            scene: settings,
            chain,
            constants,
        };
        let state = ControllerState {
            encoder: EncoderState::default(),
            right: false,
            begin: 0.0,
            gait: None,
            load: LoadState::default(),
            servo: ServoState::default(),
        };
        Ok(Controller { model, state, telemetry: Telemetry::default() })
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
        let Controller { model, state, telemetry } = self;
        model.encoder.read(&mut state.encoder, encoders);
        model.detect_initial_state(state);
        let mut task = model.chain.task(&state.in_support_order(&state.encoder.angle)); // (25)-(27)
        let mut gait = state.gait.unwrap_or_else(|| model.gait.start(&task, state.begin));
        if model.gait.exchange_due(&gait) {
            model.gait.exchange(&mut gait, &task);
            model.lead_set_points(&mut gait);
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
        let plan = model.gait.plan(&mut gait, &task, state.load.load); // (30)-(43)
        state.gait = Some(gait);
        let feed_forward = model.feed_forward(state, &task, &plan);
        let bias = rate::bias(task.swing_pitch / model.chain.parameters.time);
        let reference = model.resolve(state, &solver, &plan, &bias, &rate, &feed_forward).ok_or(singular)?; // (28), (29)
        let limits = model.torque_limits(&gait, &task, &solver, &plan);
        let (torque, surface) = model.servo.drive(&mut state.servo, &rate, &reference, &feed_forward, &limits); // (24)
        state.load.torque = torque;
        *telemetry = model.telemetry(state, &gait, &task, &state.in_support_order(&surface));
        Ok(Torques { torque: state.in_support_order(&torque).into() })
    }

    /// State of the controller in the last control period, for recording.
    pub fn telemetry(&self) -> Telemetry {
        self.telemetry
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
    /// In the first two control periods: determines the supporting foot, and whether the robot is already stepping. A robot that
    /// stands still on both feet counts as supported by the left one.
    fn detect_initial_state(&self, state: &mut ControllerState) {
        let side = |moving| {
            let from_left = self.chain.task(&state.encoder.angle);
            resume::right_supports(&from_left, moving, self.chain.parameters.airborne)
        };
        match state.encoder.readings {
            1 => state.right = side(false),
            2 => {
                let rate = self.encoder.unfiltered(&state.encoder);
                let right = side(true);
                let ordered = |q: &Joints| if right { mirror(q) } else { *q };
                let task = self.chain.task(&ordered(&state.encoder.angle));
                if let Some(gait) = self.gait.resume(&task, &ordered(&rate), state.time()) {
                    let encoder = EncoderState { rate, ..state.encoder };
                    *state = ControllerState {
                        encoder,
                        right,
                        gait: Some(gait),
                        load: LoadState::default(),
                        servo: ServoState::default(),
                        ..*state
                    };
                }
            }
            _ => (),
        }
    }

    /// Torques that carry the weight and accelerate the centre of gravity as planned, from kinematics alone [N·m]:
    /// τ = M (g J_c3ᵀ + a_1 J_c1ᵀ + a_2 J_c2ᵀ) for a fixed supporting foot, shared between the feet by the load. If one foot carries the
    /// whole weight, its ankle gets the torque of the planned zero-moment point (`ankle.rs`), which includes the rotation of the
    /// links.
    ///
    /// If both feet carry weight, the distribution of the load balances the robot sideways. Roll torques as for two separate feet
    /// would press the feet apart up to the friction limit. So the roll torque of the swing foot's ankle is zero, and that of the
    /// supporting foot's ankle is the remainder, M g (x_zmp − (1 − load) W_2).
    fn feed_forward(&self, state: &ControllerState, task: &Task, plan: &Reference) -> Joints {
        if !self.scene.feed_forward {
            return Joints::zeros();
        }
        let [a_1, a_2] = plan.acceleration;
        let carry = |task: &Task, a_2: f64| {
            let row = |k: usize| task.jacobian.row(k).transpose();
            self.chain.total_mass * (self.gravity * row(2) + a_1 * row(0) + a_2 * row(1))
        };
        let mut stance = carry(task, a_2);
        if plan.load >= 1.0 {
            for ankle in Ankle::BOTH {
                let k = ankle.axis();
                stance[ankle.joint()] =
                    self.chain.ankle_torque(task, ankle, self.gravity, plan.zmp[k], plan.acceleration[k]);
            }
            return stance;
        }
        // Axis 2 of the other foot's support frame points the opposite way.
        let other = self.chain.task(&mirror(&state.in_support_order(&state.encoder.angle)));
        let mut shared = plan.load * stance + (1.0 - plan.load) * mirror(&carry(&other, -a_2));
        let off_balance = plan.zmp[1] - (1.0 - plan.load) * self.chain.leg_width();
        shared[0] = -self.chain.total_mass * self.gravity * off_balance;
        shared[JOINTS - 1] = 0.0;
        shared
    }

    /// Joint rates for the task rates: in closed form, or by the QP with bounds if the scene sets any.
    fn resolve(
        &self,
        state: &ControllerState,
        solver: &RateSolver,
        plan: &Reference,
        bias: &Joints,
        rate: &Joints,
        feed_forward: &Joints,
    ) -> Option<Joints> {
        let parameters = &self.chain.parameters;
        let clamped = |low: &Joints, high: &Joints| {
            solver.rates(&plan.xdot, bias).map(|free| free.zip_zip_map(low, high, f64::clamp))
        };
        let hard = Joints::repeat(parameters.rate_limit);
        if self.scene.rate_limit.is_none() && self.scene.torque_bound.is_none() {
            return clamped(&-hard, &hard);
        }
        let mut high = Joints::repeat(self.scene.rate_limit.unwrap_or(parameters.rate_limit));
        let mut low = -high;
        if let Some(bound) = self.scene.torque_bound {
            let [least, most] = self.servo.rates_within(&state.servo, rate, feed_forward, bound);
            // If the present rate is outside both bounds, the rate bound takes precedence.
            high = most.zip_zip_map(&low, &high, f64::clamp);
            low = least.zip_zip_map(&low, &high, f64::clamp);
        }
        let bounded = solver.rates_within(&plan.xdot, bias, &low, &high);
        bounded.or_else(|| clamped(&low, &high))
    }

    fn telemetry(&self, state: &ControllerState, gait: &GaitState, task: &Task, surface: &Joints) -> Telemetry {
        let [sagittal, lateral] = gait.com;
        Telemetry {
            phase: gait.phase as u32,
            support: u32::from(state.right),
            steps: gait.steps,
            com: task.com().into(),
            swing: task.swing().into(),
            pendulum: [sagittal.x, sagittal.v, lateral.x, lateral.v],
            energy: self.gait.energies(gait),
            energy_ref: self.gait.energy_references(gait),
            landing: gait.landing,
            surface: (*surface).into(),
        }
    }
}
