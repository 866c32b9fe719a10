//! Where the energy of a run goes: all that the robot has, less what its drives and the scene's push have given it.
//!
//! ```text
//!   balance = ½ Σ (m v² + ω·Iω) + ½ Σ J_r q̇² − m g·r + ½ Σ k (q − q₀)² [+ ½ Σ k gap² of springs under contacts] − ∫ τ q̇ dt − ∫ F·v dt
//! ```
//!
//! Contact and dampers only take from it. So whatever it rises by was made: by integration errors, by what is lifted out of the ground, or by pushes that
//! were asked for on the way, of which a record says nothing. And as long as nothing touches and no joint is
//! damped, whatever it falls by was lost. (What a strong damper takes within a period cannot be told from the ends of the period.)

use super::derived::DerivedState;
use super::kinematic_tree::{BodyState, KinematicTree};
use messages::scene::{Law, Scene};
use messages::wire::{JOINTS, Truth};
use nalgebra::Vector3;

/// Rounding of a balance, as a part of the sum of its parts [-]: of some ten thousand steps.
const ROUNDING: f64 = 1e-12;

/// The balance of a run so far.
pub struct EnergyBalance {
    gravity: Vector3<f64>,
    drive_inertia: f64,
    /// Stiffness and rest of each joint's spring, in wire order.
    springs: Vec<[f64; 2]>,
    /// Of the law `SpringDamper`, else zero [N/m].
    ground: f64,
    push: ScenePush,
    last: Option<PreviousRecord>,
    /// Work of drives and push so far [J].
    given: f64,
    /// Least balance so far [J].
    least: f64,
    /// The most that the balance rose above an earlier one [J].
    pub made: f64,
    /// Greatest balance so far [J].
    most: f64,
    /// The most that it fell below an earlier one, while nothing took from it [J].
    pub lost: f64,
    /// Something touched, or a joint is damped.
    taken: bool,
    /// Greatest kinetic energy so far [J].
    pub kinetic: f64,
    /// Greatest sum of all parts, without their signs [J].
    scale: f64,
}

/// The scene's push: its force, when it acts, on which body [N, s].
struct ScenePush {
    force: Vector3<f64>,
    span: [f64; 2],
    body: usize,
}

/// What the record before said.
struct PreviousRecord {
    angle: [f64; JOINTS],
    pushed: Vector3<f64>,
}

impl EnergyBalance {
    /// Before the first record of a scene.
    pub fn new(scene: &Scene) -> EnergyBalance {
        let plant = &scene.plant;
        let tilt = plant.incline_deg.to_radians();
        let joints = scene.bodies.iter().filter_map(|body| body.joint.as_ref());
        let base = || scene.bodies.iter().position(|body| body.joint.is_none());
        let body = scene.bodies.iter().position(|body| body.name == plant.push_body).or_else(base).unwrap_or(0);
        let duration = (plant.push_duration / plant.dt).round().max(1.0) * plant.dt;
        EnergyBalance {
            gravity: Vector3::new(tilt.sin(), 0.0, -tilt.cos()) * plant.gravity,
            drive_inertia: plant.drive_inertia,
            springs: joints.clone().map(|joint| [joint.stiffness, joint.rest]).collect(),
            ground: if plant.law == Law::SpringDamper { plant.contact_stiffness } else { 0.0 },
            push: ScenePush {
                force: Vector3::from(plant.push_impulse) / duration,
                span: [plant.push_time, plant.push_time + duration],
                body,
            },
            last: None,
            given: 0.0,
            least: f64::INFINITY,
            made: 0.0,
            most: f64::NEG_INFINITY,
            lost: 0.0,
            taken: joints.into_iter().any(|joint| joint.damping + plant.joint_damping > 0.0),
            kinetic: 0.0,
            scale: 0.0,
        }
    }

    /// What rounding makes of the balance [J].
    pub fn rounding(&self) -> f64 {
        ROUNDING * self.scale
    }

    /// Takes the next record.
    pub fn push(&mut self, robot: &KinematicTree, truth: &Truth, placed: &[BodyState], derived: &DerivedState) {
        let joints = self.springs.len().min(JOINTS);
        let drives: f64 = truth.rate[..joints].iter().map(|rate| 0.5 * self.drive_inertia * rate * rate).sum();
        let kinetic = robot.kinetic(placed) + drives;
        let pulled = self.springs.iter().zip(truth.angle).map(|([k, rest], q)| 0.5 * k * (q - rest).powi(2));
        let mut stored = pulled.sum::<f64>() - robot.mass * self.gravity.dot(&derived.com);
        if self.ground > 0.0 {
            let depths = robot.contacts.iter().map(|(body, ball)| robot.height(placed, *body, ball).min(0.0));
            stored += depths.map(|depth| 0.5 * self.ground * depth * depth).sum::<f64>();
        }
        let pushed = robot.centre(placed, self.push.body);
        if let Some(last) = &self.last {
            let turned = truth.angle.iter().zip(last.angle).map(|(now, before)| now - before);
            self.given += truth.torque[..joints].iter().zip(turned).map(|(torque, turn)| torque * turn).sum::<f64>();
            // the records of the periods in which it acts: a period's record comes at its end
            let [from, to] = self.push.span;
            if derived.time > from + 1e-9 && derived.time <= to + 1e-9 {
                self.given += self.push.force.dot(&(pushed - last.pushed));
            }
        }
        self.last = Some(PreviousRecord { angle: truth.angle, pushed });
        let balance = kinetic + stored - self.given;
        self.least = self.least.min(balance);
        self.made = self.made.max(balance - self.least);
        self.taken |= derived.load > 0.0;
        if !self.taken {
            self.most = self.most.max(balance);
            self.lost = self.lost.max(self.most - balance);
        }
        self.kinetic = self.kinetic.max(kinetic);
        self.scale = self.scale.max(kinetic + stored.abs() + self.given.abs());
    }
}

#[cfg(test)]
mod tests {
    use super::super::RunAnalysis;
    use messages::load::parse;
    use messages::scene::{Method, Scene};
    use messages::wire::Torques;
    use plant::Plant;

    /// Energy made and lost by a method, and the greatest of motion [J].
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
    fn what_a_step_makes_or_loses_is_seen_and_what_drives_and_pushes_give_is_not() {
        let scene = |text: &str| parse(text, "a test").unwrap_or_else(|error| panic!("{error}"));
        let (spin, swing) = (scene(SPIN), scene(SWING));
        let [made, lost, kinetic] = balance(&spin, Method::SemiImplicitEuler);
        assert!(made > 0.05 * kinetic, "the paper's step makes energy of a spin: {made} of {kinetic} J, lost {lost}");
        let [made, lost, kinetic] = balance(&swing, Method::SemiImplicitEuler);
        assert!(lost > 0.2 * kinetic, "and takes it from a spring: {lost} of {kinetic} J, made {made}");
        for scene in [&spin, &swing] {
            let [made, lost, kinetic] = balance(scene, Method::MidpointContact);
            println!("default: made {made:e}, lost {lost:e} of {kinetic:e} J");
            assert!(made.max(lost) < 2e-3 * kinetic, "{made:e} {lost:e} of {kinetic:e} J");
        }
    }
}
