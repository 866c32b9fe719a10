//! A synthetic walk for tests: the robot of Table 1 follows the exact lateral limit cycle of (32), without dynamics.

use super::kinematic_tree::KinematicTree;
use messages::scene::Scene;
use messages::wire::{Stamp, Telemetry, Truth};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// Duration of one step, T/2 [s].
pub const STEP: f64 = 0.3;
/// ω_2 of the pendulum [1/s].
pub const OMEGA: f64 = 4.947;
/// Start of the first step, after standing, swaying and lifting [s].
pub const RELEASE: f64 = 1.6;
/// Half the distance between the feet [m].
const HALF_WIDTH: f64 = 0.05;
/// Height of the trunk's centre above the ankle roll joint of the support foot, along the trunk's z axis [m]: that of the
/// hips plus half the trunk.
const TRUNK_ABOVE_ROLL: f64 = 0.40 + 0.15;

/// A walk with constant step length [m].
pub struct SyntheticWalk {
    robot: KinematicTree,
    step_length: f64,
}

/// The state that the walk prescribes at one time.
struct PlannedState {
    /// Support foot: 0 left, 1 right.
    support: usize,
    /// x of the stance foot [m].
    stance: f64,
    /// x of the swing foot [m].
    swing: f64,
    /// Height of the swing foot [m].
    lift: f64,
    /// x and y of the centre of mass [m].
    com: [f64; 2],
    /// Lateral distance of the centre of mass from the support foot [m].
    x2: f64,
}

impl SyntheticWalk {
    /// A walk; length zero means stepping in place.
    pub fn new(step_length: f64) -> Self {
        SyntheticWalk { robot: KinematicTree::new(&Scene::default()), step_length }
    }

    /// Least lateral distance of the centre of mass from the support foot [m].
    pub fn x2_min() -> f64 {
        HALF_WIDTH / (OMEGA * STEP / 2.0).cosh()
    }

    /// The record at one time.
    pub fn truth(&self, seq: u64, time: f64) -> Truth {
        let (h, now) = (1e-5, self.pose(time));
        let (before, after) = (self.pose(time - h), self.pose(time + h));
        let slope = |a: f64, b: f64| (b - a) / (2.0 * h);
        let plan = self.plan(time);
        let mut truth = now;
        truth.stamp = Stamp { seq, run: 1, sim_ns: (time * 1e9).round() as u64, ..Stamp::default() };
        truth.base_velocity = std::array::from_fn(|i| slope(before.base_position[i], after.base_position[i]));
        let roll = |truth: &Truth| 2.0 * truth.base_orientation[1].asin();
        truth.base_spin[0] = slope(roll(&before), roll(&after));
        truth.rate = std::array::from_fn(|i| slope(before.angle[i], after.angle[i]));
        truth.torque = std::array::from_fn(|i| [2.5, 5.0, 11.0, 6.0][i.min(7 - i)] * now.angle[i].sin() * 0.9);
        self.set_contact_forces(&mut truth, &plan, time);
        let noise = |k: u64| (seq.wrapping_mul(6_364_136_223_846_793_005 + 2 * k) >> 33) as f64 / 2f64.powi(31);
        truth.natural_map = 10f64.powf(-16.5 + 2.5 * noise(1) * noise(2));
        truth.signorini = if noise(3) < 0.3 { 0.0 } else { 10f64.powf(-17.0 + 2.0 * noise(4)) };
        truth.energy_gain = 4e-17 * (noise(5) - 0.8);
        truth.pivots = (2.0 + 9.0 * noise(6) * noise(7)) as u64;
        truth.plant_ns = (9_000.0 * (1.0 + noise(8)).powi(2) / noise(9).max(0.01).powf(0.3)) as u64;
        truth.wait_ns = (4_000.0 * (1.0 + noise(10)) / noise(11).max(0.001).powf(0.5)) as u64;
        truth.hash = 0x0123_4567_89ab_cdef ^ seq;
        truth.telemetry = self.telemetry(&plan, time);
        truth.command = Stamp { seq, ack: seq, ..truth.stamp };
        truth
    }

    fn plan(&self, time: f64) -> PlannedState {
        let foot_x = |k: i64| self.step_length * (1..=k).map(|i| (i as f64 / 4.0).min(1.0)).sum::<f64>();
        let walked = time - RELEASE + STEP / 2.0;
        if time < RELEASE {
            let share = ((time - 0.5) / 0.8).clamp(0.0, 1.0);
            let smooth = share.powi(3) * (10.0 - 15.0 * share + 6.0 * share * share);
            let x2 = HALF_WIDTH + smooth * (Self::x2_min() - HALF_WIDTH);
            let lift = if time > 1.3 { 0.01 * ((time - 1.3) / STEP).min(1.0) } else { 0.0 };
            return PlannedState { support: 0, stance: 0.0, swing: 0.0, lift, com: [0.0, HALF_WIDTH - x2], x2 };
        }
        let k = (walked / STEP).floor();
        let (tau, k) = (walked - k * STEP, k as i64);
        let x2 = Self::x2_min() * (OMEGA * (tau - STEP / 2.0)).cosh();
        let side = if k % 2 == 0 { 1.0 } else { -1.0 };
        let (stance, from, to) = (foot_x(k), foot_x((k - 1).max(0)), foot_x(k + 1));
        let blend = OMEGA * STEP;
        let x1 = ((from - stance) / 2.0 * (blend - OMEGA * tau).sinh() + (to - stance) / 2.0 * (OMEGA * tau).sinh())
            / blend.sinh();
        let s = tau / STEP;
        let swing = from + (to - from) * s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s);
        let lift = 0.01 * (std::f64::consts::PI * s).sin().powi(2);
        let com = [stance + x1, side * (HALF_WIDTH - x2)];
        PlannedState { support: (k % 2) as usize, stance, swing, lift, com, x2 }
    }

    /// Rolls and shifts the trunk iteratively until the centre of mass has the planned position.
    fn pose(&self, time: f64) -> Truth {
        let plan = self.plan(time);
        let (mut roll, mut shift, mut truth) = (0.0, 0.0, Truth::default());
        for _ in 0..40 {
            truth = inverse_kinematics(&plan, roll, shift);
            let (com, _) = self.robot.com(&self.robot.body_states(&truth));
            roll -= (plan.com[1] - com.y) / 0.27;
            shift += plan.com[0] - com.x;
        }
        truth
    }

    /// Sets contact forces: the weight on the support foot, or on both feet while standing, off the centre of the sole.
    fn set_contact_forces(&self, truth: &mut Truth, plan: &PlannedState, time: f64) {
        let share = if time < 1.3 {
            (HALF_WIDTH + plan.x2 - 2.0 * Self::x2_min()) / (4.0 * (HALF_WIDTH - Self::x2_min()))
        } else {
            0.0
        };
        let weight = 9.81 * self.robot.mass;
        let shares = if plan.support == 0 { [1.0 - share, share] } else { [share, 1.0 - share] };
        let (zx, zy) = (0.4 * (9.0 * time).sin(), 0.3 * (21.0 * time).cos());
        for (foot, share) in shares.into_iter().enumerate() {
            for (corner, (x, y)) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].into_iter().enumerate() {
                truth.contact_force[3 * (4 * foot + corner) + 2] =
                    weight * share * (1.0 + x * zx) * (1.0 + y * zy) / 4.0;
            }
        }
    }

    fn telemetry(&self, plan: &PlannedState, time: f64) -> Telemetry {
        let energy = -0.5 * (OMEGA * Self::x2_min()).powi(2);
        let velocity = OMEGA * (plan.x2.powi(2) - Self::x2_min().powi(2)).max(0.0).sqrt();
        Telemetry {
            phase: if time < 0.5 {
                0
            } else if time < 1.3 {
                1
            } else if time < RELEASE {
                2
            } else {
                3
            },
            support: plan.support as u32,
            steps: ((time - RELEASE + STEP / 2.0) / STEP).max(0.0) as u64,
            pendulum: [plan.com[0] - plan.stance, 0.0, plan.x2, velocity],
            energy: [0.0, energy * (1.0 + 0.03 * (7.0 * time).sin() * (-0.3 * time).exp())],
            energy_ref: [0.0, energy],
            ..Telemetry::default()
        }
    }
}

/// The pose with both soles horizontal and the trunk rolled about and shifted forward of the support ankle.
fn inverse_kinematics(plan: &PlannedState, roll: f64, shift: f64) -> Truth {
    let side = [1.0, -1.0][plan.support];
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), roll);
    let ankle = Vector3::new(plan.stance, side * HALF_WIDTH, 0.05);
    let trunk = ankle + rotation * Vector3::new(shift, -side * HALF_WIDTH, TRUNK_ABOVE_ROLL - 0.05);
    let pose = Isometry3::from_parts(Translation3::from(trunk), rotation);
    let mut truth = Truth { base_position: trunk.into(), ..Truth::default() };
    truth.base_orientation = [rotation.w, rotation.i, rotation.j, rotation.k];
    for leg in 0..2 {
        let (x, lift) = if leg == plan.support { (plan.stance, 0.0) } else { (plan.swing, plan.lift) };
        let lateral = [1.0, -1.0][leg] * HALF_WIDTH;
        // There is no hip roll joint, so the foot stays in the leg's plane: its height determines its lateral position.
        let below = (trunk.z + lateral * roll.sin() - lift - 0.05) / roll.cos();
        let sole = pose * nalgebra::Point3::new(x - trunk.x, lateral, -below);
        let reach = pose.inverse() * sole - nalgebra::Point3::new(0.0, lateral, -0.15) + Vector3::z() * 0.05;
        let length = reach.xz().norm();
        let knee = 2.0 * (length / 0.4).min(1.0).acos();
        let thigh = (-reach.x).atan2(-reach.z) - knee / 2.0;
        let chain = [thigh, knee, -thigh - knee, -roll];
        for (i, angle) in chain.into_iter().enumerate() {
            truth.angle[if leg == 0 { 3 - i } else { 4 + i }] = if leg == 0 { -angle } else { angle };
        }
    }
    truth
}
