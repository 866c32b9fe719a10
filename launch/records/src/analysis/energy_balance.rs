//! Energy balance of a run: mechanical energy of the robot minus the work of its drives and of the scene's push.
//!
//! ```text
//!   balance = ½ Σ (m v² + ω·Iω) + ½ Σ J_r q̇² − m g·r + ½ Σ k (q − q₀)² [+ ½ Σ k gap² of springs under contacts] − ∫ τ q̇ dt − ∫ F·v dt
//! ```
//!
//! Contacts and dampers can only decrease the balance. An increase therefore shows one of three causes: an integration
//! error, a penetration that was corrected, or a push that a user requested during the run (records do not contain its
//! force). Before the first contact, and without joint damping, the balance is constant. A decrease then shows an
//! integration error. (With damping this is impossible to check: the samples at both ends of a period do not determine
//! the energy that a strong damper dissipates within it.)

use super::derived::DerivedState;
use super::kinematic_tree::{BodyState, KinematicTree};
use messages::scene::{Law, Scene};
use messages::wire::{JOINTS, Truth};
use nalgebra::Vector3;

/// Rounding error of the balance relative to the sum of its terms [-]: machine precision times some ten thousand steps.
const ROUNDING: f64 = 1e-12;
/// Tolerance of the comparison of record times with the ends of the push [s]: far below any integration step.
const TIME_TOLERANCE: f64 = 1e-9;

/// The energy balance up to the latest record.
pub struct EnergyBalance {
    /// Gravity in the world frame, which is parallel to the incline [m/s²].
    gravity: Vector3<f64>,
    /// Rotor inertia seen at the joint, J_r [kg·m²].
    drive_inertia: f64,
    /// Stiffness and rest position of each joint's spring, in wire order.
    springs: Vec<[f64; 2]>,
    /// Contact stiffness of the law `SpringDamper`; zero for other laws [N/m].
    ground_stiffness: f64,
    push: ScenePush,
    previous: Option<PreviousRecord>,
    /// Work of drives and push [J].
    work: f64,
    /// Least balance [J].
    least_balance: f64,
    /// Greatest increase of the balance above any earlier value [J].
    pub made: f64,
    /// Greatest balance [J].
    greatest_balance: f64,
    /// Greatest decrease of the balance below any earlier value, while nothing dissipates energy [J].
    pub lost: f64,
    /// A contact has been active, or a joint is damped.
    is_dissipative: bool,
    /// Greatest kinetic energy [J].
    pub kinetic: f64,
    /// Greatest sum of the magnitudes of all terms [J].
    scale: f64,
}

/// The push that the scene specifies.
struct ScenePush {
    /// [N].
    force: Vector3<f64>,
    /// Start and end [s].
    interval: [f64; 2],
    body: usize,
}

/// Values of the previous record that the work integrals need.
struct PreviousRecord {
    angle: [f64; JOINTS],
    push_point: Vector3<f64>,
}

impl EnergyBalance {
    /// The balance before the first record of a run of the scene.
    pub fn new(scene: &Scene) -> EnergyBalance {
        let plant = &scene.plant;
        let tilt = plant.incline_deg.to_radians();
        let joints = scene.bodies.iter().filter_map(|body| body.joint.as_ref());
        let named = scene.bodies.iter().position(|body| body.name == plant.push_body);
        let body = named.unwrap_or_else(|| scene.base_body());
        let duration = (plant.push_duration / plant.dt).round().max(1.0) * plant.dt;
        EnergyBalance {
            gravity: Vector3::new(tilt.sin(), 0.0, -tilt.cos()) * plant.gravity,
            drive_inertia: plant.drive_inertia,
            springs: joints.clone().map(|joint| [joint.stiffness, joint.rest]).collect(),
            ground_stiffness: if plant.law == Law::SpringDamper { plant.contact_stiffness } else { 0.0 },
            push: ScenePush {
                force: Vector3::from(plant.push_impulse) / duration,
                interval: [plant.push_time, plant.push_time + duration],
                body,
            },
            previous: None,
            work: 0.0,
            least_balance: f64::INFINITY,
            made: 0.0,
            greatest_balance: f64::NEG_INFINITY,
            lost: 0.0,
            is_dissipative: joints.into_iter().any(|joint| joint.damping + plant.joint_damping > 0.0),
            kinetic: 0.0,
            scale: 0.0,
        }
    }

    /// Rounding error of the balance [J].
    pub fn rounding(&self) -> f64 {
        ROUNDING * self.scale
    }

    /// Adds the next record.
    pub fn push(&mut self, robot: &KinematicTree, truth: &Truth, states: &[BodyState], derived: &DerivedState) {
        let joints = self.springs.len().min(JOINTS);
        let drives: f64 = truth.rate[..joints].iter().map(|rate| 0.5 * self.drive_inertia * rate * rate).sum();
        let kinetic = robot.kinetic(states) + drives;
        let spring_energy = self.springs.iter().zip(truth.angle).map(|([k, rest], q)| 0.5 * k * (q - rest).powi(2));
        let mut stored = spring_energy.sum::<f64>() - robot.mass * self.gravity.dot(&derived.com);
        if self.ground_stiffness > 0.0 {
            let depths = robot.contacts.iter().map(|(body, ball)| robot.height(states, *body, ball).min(0.0));
            stored += depths.map(|depth| 0.5 * self.ground_stiffness * depth * depth).sum::<f64>();
        }
        let push_point = robot.centre(states, self.push.body);
        if let Some(previous) = &self.previous {
            let rotations = truth.angle.iter().zip(previous.angle).map(|(now, before)| now - before);
            self.work +=
                truth.torque[..joints].iter().zip(rotations).map(|(torque, rotation)| torque * rotation).sum::<f64>();
            // A record is taken at the end of its period, so the push acts in the periods with from < time <= to.
            let [from, to] = self.push.interval;
            if derived.time > from + TIME_TOLERANCE && derived.time <= to + TIME_TOLERANCE {
                self.work += self.push.force.dot(&(push_point - previous.push_point));
            }
        }
        self.previous = Some(PreviousRecord { angle: truth.angle, push_point });
        let balance = kinetic + stored - self.work;
        self.least_balance = self.least_balance.min(balance);
        self.made = self.made.max(balance - self.least_balance);
        self.is_dissipative |= derived.load > 0.0;
        if !self.is_dissipative {
            self.greatest_balance = self.greatest_balance.max(balance);
            self.lost = self.lost.max(self.greatest_balance - balance);
        }
        self.kinetic = self.kinetic.max(kinetic);
        self.scale = self.scale.max(kinetic + stored.abs() + self.work.abs());
    }
}

#[cfg(test)]
mod tests {
    use super::super::RunAnalysis;
    use messages::load::parse;
    use messages::scene::{Method, Scene};
    use messages::wire::Torques;
    use plant::Plant;

    /// Increase and decrease of the balance under a method, and the greatest kinetic energy [J].
    fn balance(scene: &Scene, method: Method) -> [f64; 3] {
        let mut scene = scene.clone();
        (scene.plant.method, scene.plant.dt, scene.rate) = (method, 1e-3, 1e3);
        let mut plant = Plant::new(&scene).unwrap_or_else(|error| panic!("{error}"));
        let mut analysis = RunAnalysis::without_rows(&scene);
        for period in 0..=400_u64 {
            let mut truth = plant.truth();
            truth.stamp.sim_ns = period * 1_000_000;
            analysis.push(&truth);
            let torque = Torques { torque: [0.2 * (period as f64 * 0.01).sin(); 8] };
            plant.advance(&torque).unwrap_or_else(|error| panic!("{error}"));
        }
        let energy = &analysis.energy;
        [energy.made, energy.lost, energy.kinetic]
    }

    const SPIN: &str = "[plant]\ngravity = 0.0\n[initial]\nangular_velocity = [20.0, 10.0, 45.0]\n[[bodies]]\nname = \"box\"\nmass = 1.0\n\
        size = [0.05, 0.2, 0.45]\ncontacts = []\n";
    const SWING: &str = "[plant]\nbase = \"fixed\"\npush_impulse = [0.05, 0.0, 0.0]\npush_body = \"arm\"\npush_time = 0.1\n\
        [initial]\nposition = [0.0, 0.0, 2.0]\njoints = [0.5]\n[[bodies]]\nname = \"stand\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\n\
        [[bodies]]\nname = \"arm\"\nmass = 1.0\nsize = [0.05, 0.05, 0.3]\ncom = [0.0, 0.0, -0.15]\n\
        joint = { parent = \"stand\", at = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], stiffness = 300.0 }\n";

    #[test]
    fn integration_errors_change_the_balance_and_work_of_drives_and_pushes_does_not() {
        let scene = |text: &str| parse(text, "a test").unwrap_or_else(|error| panic!("{error}"));
        let (spin, swing) = (scene(SPIN), scene(SWING));
        let [made, lost, kinetic] = balance(&spin, Method::SemiImplicitEuler);
        assert!(made > 0.05 * kinetic, "the paper's step adds energy to a spin: {made} of {kinetic} J, lost {lost}");
        let [made, lost, kinetic] = balance(&swing, Method::SemiImplicitEuler);
        assert!(lost > 0.2 * kinetic, "and removes it from a spring: {lost} of {kinetic} J, made {made}");
        for scene in [&spin, &swing] {
            let [made, lost, kinetic] = balance(scene, Method::MidpointContact);
            println!("default: made {made:e}, lost {lost:e} of {kinetic:e} J");
            assert!(made.max(lost) < 2e-3 * kinetic, "{made:e} {lost:e} of {kinetic:e} J");
        }
    }
}
