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
//! the energy that a strong damper dissipates within it.) If the push begins or ends between two records, its work is
//! unknown, and the balance counts as unchanged between them.

use super::derived::DerivedState;
use super::kinematic_tree::{BodyState, KinematicTree};
use messages::scene::{Law, Method, Scene};
use messages::wire::{JOINTS, Truth};
use nalgebra::Vector3;

/// Rounding error of the balance relative to the sum of its terms [-]: machine precision times some ten thousand steps.
const ROUNDING: f64 = 1e-12;

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
    /// Greatest sum of the magnitudes of all terms, or the energy that the push would give a free body: it may press a robot that stays at rest
    /// [J].
    scale: f64,
}

/// The push that the scene specifies.
struct ScenePush {
    /// [N].
    force: Vector3<f64>,
    /// Number of the first integration step in which it acts, and of the first one after it. As in the plant, it acts in whole steps.
    steps: [f64; 2],
    /// Integration step [s].
    dt: f64,
    /// Displacement in a step beyond h(v₀ + v₁)/2, relative to h(v₁ − v₀) [-]. Euler's methods take one of the two velocities, and only a
    /// force times the mean of both is the work that the body gains.
    lead: f64,
    body: usize,
}

/// Values of the previous record that the work integrals need.
struct PreviousRecord {
    angle: [f64; JOINTS],
    pushed: PushedPoint,
    /// Kinetic and stored energy [J].
    energy: f64,
}

/// The point that the scene's push acts on, in W.
struct PushedPoint {
    /// Number of integration steps before this instant.
    step: f64,
    /// [m].
    position: Vector3<f64>,
    /// [m/s].
    velocity: Vector3<f64>,
}

impl EnergyBalance {
    /// The balance before the first record of a run of the scene with this robot.
    pub fn new(scene: &Scene, robot: &KinematicTree) -> EnergyBalance {
        let plant = &scene.plant;
        let tilt = plant.incline_deg.to_radians();
        let joints = scene.bodies.iter().filter_map(|body| body.joint.as_ref());
        let [first, end] = [plant.push_steps().start, plant.push_steps().end].map(|step| step as f64);
        let impulse = Vector3::from(plant.push_impulse);
        EnergyBalance {
            gravity: Vector3::new(tilt.sin(), 0.0, -tilt.cos()) * plant.gravity,
            drive_inertia: plant.drive_inertia,
            springs: joints.clone().map(|joint| [joint.stiffness, joint.rest]).collect(),
            ground_stiffness: if plant.law == Law::SpringDamper { plant.contact_stiffness } else { 0.0 },
            push: ScenePush {
                force: impulse / ((end - first) * plant.dt),
                steps: [first, end],
                dt: plant.dt,
                lead: match plant.method {
                    Method::SemiImplicitEuler => 0.5,
                    Method::ExplicitEuler => -0.5,
                    _ => 0.0,
                },
                body: scene.pushed_body(),
            },
            previous: None,
            work: 0.0,
            least_balance: f64::INFINITY,
            made: 0.0,
            greatest_balance: f64::NEG_INFINITY,
            lost: 0.0,
            is_dissipative: joints.into_iter().any(|joint| joint.damping + plant.joint_damping > 0.0),
            kinetic: 0.0,
            scale: 0.5 * impulse.norm_squared() / robot.mass,
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
        let (position, velocity) = robot.centre(states, self.push.body);
        let pushed = PushedPoint { step: (derived.time / self.push.dt).round(), position, velocity };
        if let Some(previous) = &self.previous {
            let rotations = truth.angle.iter().zip(previous.angle).map(|(now, before)| now - before);
            let drives: f64 =
                truth.torque[..joints].iter().zip(rotations).map(|(torque, rotation)| torque * rotation).sum();
            self.work += match self.push.work(&previous.pushed, &pushed) {
                Some(work) => drives + work,
                None => kinetic + stored - previous.energy,
            };
        }
        self.previous = Some(PreviousRecord { angle: truth.angle, pushed, energy: kinetic + stored });
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

impl ScenePush {
    /// Work between two records [J]: force times displacement of the point. `None` if the push begins or ends between them: the records do not
    /// tell how far the point moved while it acted.
    fn work(&self, before: &PushedPoint, after: &PushedPoint) -> Option<f64> {
        let [first, end] = self.steps;
        if after.step <= first || before.step >= end {
            return Some(0.0);
        }
        let covers = first <= before.step && after.step <= end;
        let moved = after.position - before.position - self.lead * self.dt * (after.velocity - before.velocity);
        covers.then(|| self.force.dot(&moved))
    }
}

#[cfg(test)]
mod tests;
