//! Default values of a scene. The comment of a field in `scene.rs` gives its meaning, the comment here gives the reason for its value. Gains of
//! the controller without a comment were chosen by simulation.

use super::{
    Base, ControllerScene, Gait, Ground, Initial, Law, LinkScene, Method, PlantScene, Sagittal, Scene, Switching,
};
use crate::robot;
use std::ops::Range;

impl Default for Scene {
    fn default() -> Self {
        Scene {
            description: String::new(),
            duration: 1.0,
            rate: 1000.0, // [Hz] usual for the joint servos of legged robots
            plant: PlantScene::default(),
            link: LinkScene::default(),
            initial: Initial::default(),
            controller: None,
            robot: None,
            bodies: robot::table_1(),
        }
    }
}

impl Scene {
    /// Name of the robot.
    pub fn robot_name(&self) -> &str {
        let own = if self.bodies == robot::table_1() { "Table 1" } else { "bodies of the scene" };
        self.robot.as_deref().unwrap_or(own)
    }

    /// Number of the base: the body without a joint to another one.
    pub fn base_body(&self) -> usize {
        self.bodies.iter().position(|body| body.joint.is_none()).unwrap_or(0)
    }

    /// Number of control periods.
    pub fn periods(&self) -> u64 {
        (self.duration * self.rate).round() as u64
    }

    /// Number of the body that `plant.push_body` names; the base without a name.
    pub fn pushed_body(&self) -> usize {
        let named = self.bodies.iter().position(|body| body.name == self.plant.push_body);
        named.unwrap_or_else(|| self.base_body())
    }
}

impl PlantScene {
    /// Integration steps in which the push acts.
    pub fn push_steps(&self) -> Range<u64> {
        let first = (self.push_time / self.dt).round() as u64;
        first..first.saturating_add(steps_of_push(self.push_duration, self.dt))
    }
}

/// Steps of `dt` in which a push of this duration acts [s]: whole ones, and at least one.
pub fn steps_of_push(duration: f64, dt: f64) -> u64 {
    ((duration / dt).round() as u64).max(1)
}

impl Default for PlantScene {
    fn default() -> Self {
        PlantScene {
            dt: 5e-4, // [s] two steps in a control period
            base: Base::Quaternion,
            law: Law::DEFAULT,
            tolerance: 1e-9, // [-] ten times what every solved step promises (`PROMISED` of the plant)
            method: Method::MidpointContact,
            tolerance_step: 1e-10, // [-] far below the error of a step of `dt`
            gravity: 9.81,         // [m/s²] on Earth
            incline_deg: 0.0,
            ground: Ground::default(),
            friction: 0.7, // [-] typical of rubber on concrete
            restitution: 0.0,
            contact_stiffness: 1e5, // [N/m] the robot of Table 1 sinks by less than 1 mm on one foot
            contact_damping_ratio: 0.5, // [-] half of critical
            drive_inertia: 0.1,     // [kg·m²] Table 1 gives no motors; without drive inertia the robot falls
            joint_damping: 0.0,
            torque_limit: 40.0, // [N·m] about twice the peak torque of the walk
            encoder_bits: 20,   // [bit] 6 µrad, finer than the noise of the gait
            latency_ticks: 0,
            stale_probability: 0.0,
            seed: 1995, // the year of the paper
            payload_kg: 0.0,
            payload_offset: [0.0; 3],
            payload_body: String::new(),
            push_impulse: [0.0; 3],
            push_time: 0.0,
            push_duration: 0.05, // [s] short beside a step of .3 s
            push_body: String::new(),
        }
    }
}

impl Default for ControllerScene {
    fn default() -> Self {
        ControllerScene {
            gait: Gait::Walk,
            period: 0.6, // [s] of the paper
            speed: 0.0,
            stop_time: None,
            com_height: 0.27,   // [m] knees clearly bent, see `robot::CROUCH`
            swing_height: 0.01, // [m] clears level ground
            release_x2: None,
            energy_gain: 4.0,
            sagittal: Sagittal::FootPlacement,
            foot_placement_gain: 0.9,
            sagittal_energy_gain: 3.0,
            com_feedback: 20.0,
            com_gain: 25.0,
            swing_gain: 40.0,
            rate_limit: None,
            torque_bound: None,
            nominal_inertia: None,
            switching: Switching::BoundaryLayer,
            switch_rate: 80.0,
            observer_bandwidth: 20.0,
            rate_filter_hz: 150.0,
            feed_forward: true,
        }
    }
}
