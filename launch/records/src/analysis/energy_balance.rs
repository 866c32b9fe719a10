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
    /// Greatest sum of the magnitudes of all terms, or the energy of the push if that is greater: it may press a robot that stays at rest [J].
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
    /// The balance before the first record of a run of the scene.
    pub fn new(scene: &Scene) -> EnergyBalance {
        let plant = &scene.plant;
        let tilt = plant.incline_deg.to_radians();
        let joints = scene.bodies.iter().filter_map(|body| body.joint.as_ref());
        let [first, end] = [plant.push_steps().start, plant.push_steps().end].map(|step| step as f64);
        EnergyBalance {
            gravity: Vector3::new(tilt.sin(), 0.0, -tilt.cos()) * plant.gravity,
            drive_inertia: plant.drive_inertia,
            springs: joints.clone().map(|joint| [joint.stiffness, joint.rest]).collect(),
            ground_stiffness: if plant.law == Law::SpringDamper { plant.contact_stiffness } else { 0.0 },
            push: ScenePush {
                force: Vector3::from(plant.push_impulse) / ((end - first) * plant.dt),
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
        self.scale = self.scale.max(kinetic + stored.abs() + self.work.abs()).max(self.push.energy(robot.mass));
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

    /// The energy that the push would give a free body of this mass [J].
    fn energy(&self, mass: f64) -> f64 {
        let impulse = self.force.norm() * (self.steps[1] - self.steps[0]) * self.dt;
        0.5 * impulse * impulse / mass
    }
}

#[cfg(test)]
mod tests {
    use super::super::RunAnalysis;
    use messages::load::parse;
    use messages::scene::{Initial, Method, Scene};
    use messages::wire::Torques;
    use plant::Plant;

    /// Increase and decrease of the balance under a method, and the greatest kinetic energy [J]. A control period has this many steps.
    fn balance(scene: &Scene, method: Method, steps: u64) -> [f64; 3] {
        let mut scene = scene.clone();
        (scene.plant.method, scene.plant.dt, scene.rate) = (method, 1e-3, 1e3 / steps as f64);
        let mut plant = Plant::new(&scene).unwrap_or_else(|error| panic!("{error}"));
        let mut analysis = RunAnalysis::without_rows(&scene);
        for period in 0..=400 / steps {
            let mut truth = plant.truth();
            truth.stamp.sim_ns = period * steps * 1_000_000;
            analysis.push(&truth);
            let torque = Torques { torque: [0.2 * ((period * steps) as f64 * 0.01).sin(); 8] };
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

    const G: f64 = 9.81;
    const BOX: &str = "[plant]\npush_impulse = [1.0, 0.5, 2.0]\n[initial]\nposition = [0.0, 0.0, 9.0]\nvelocity = [0.3, 0.0, 0.0]\n\
        [[bodies]]\nname = \"box\"\nmass = 2.0\nsize = [0.1, 0.1, 0.1]\n";

    fn scene(text: &str) -> Scene {
        parse(text, "a test").unwrap_or_else(|error| panic!("{error}"))
    }

    /// Start and duration of pushes [s]: over whole periods of 5 ms; within one; from one into the next; to the end and the start of one; no
    /// whole number of steps of 1 ms; shorter than a step.
    const PUSHES: [[f64; 2]; 9] = [
        [0.1, 0.05],
        [0.101, 0.002],
        [0.102, 0.01],
        [0.104, 0.002],
        [0.103, 0.002],
        [0.1, 0.003],
        [0.1024, 0.0104],
        [0.1026, 0.0007],
        [0.1023, 0.0001],
    ];

    #[test]
    fn no_push_changes_the_balance_in_free_flight() {
        let mut scene = scene(BOX);
        let exact = [Method::MidpointContact, Method::EventDriven, Method::Rk4].map(|method| (method, G));
        let euler = [Method::SemiImplicitEuler, Method::ExplicitEuler].map(|method| (method, 0.0)); // gravity makes an error of its own there
        for [start, duration] in PUSHES {
            (scene.plant.push_time, scene.plant.push_duration) = (start, duration);
            for (method, gravity, steps) in exact
                .iter()
                .chain(&euler)
                .flat_map(|&(method, gravity)| [1, 5, 10].map(|steps| (method, gravity, steps)))
            {
                scene.plant.gravity = gravity;
                let [made, lost, kinetic] = balance(&scene, method, steps);
                assert!(made.max(lost) < 1e-11 && kinetic > 1.0, "{start} s, {duration} s: {made:e} {lost:e} J");
            }
        }
    }

    #[test]
    fn a_push_acts_on_the_common_centre_of_mass_of_a_body_and_its_payload() {
        let mut scene = scene(BOX);
        (scene.plant.payload_kg, scene.plant.payload_offset) = (1.0, [0.5, 0.1, 0.0]);
        (scene.plant.push_time, scene.initial.angular_velocity) = (0.1, [3.0, 10.0, 0.0]);
        let [made, lost, kinetic] = balance(&scene, Method::EventDriven, 1);
        assert!(made.max(lost) < 1e-9 * kinetic && kinetic > 1.0, "{made:e} {lost:e} of {kinetic:e} J");
    }

    /// A strong push of a stiff swing. The acceleration changes so much between two records that these do not tell its work: it was wrong by
    /// 2 % of the kinetic energy and more, by an exact method, and the program warned.
    #[test]
    fn no_push_within_a_control_period_changes_the_balance_where_accelerations_change() {
        let mut scene = scene(SWING);
        scene.plant.push_impulse[0] = 0.5;
        for [start, duration] in PUSHES {
            (scene.plant.push_time, scene.plant.push_duration) = (start, duration);
            for steps in [1, 5, 50, 100] {
                let [made, lost, kinetic] = balance(&scene, Method::EventDriven, steps);
                println!("{start} s, {duration} s, {steps} steps: {made:e} {lost:e} of {kinetic:e} J");
                assert!(made.max(lost) < 1e-9 * kinetic, "{start} s, {duration} s, {steps} steps: {made:e} {lost:e}");
            }
        }
    }

    /// What the force of the ground leaves of the velocity, 1e-18 m/s, has an energy of 1e-36 J, which a warning called a gain.
    #[test]
    fn a_body_at_rest_that_a_push_presses_to_the_ground_without_gravity_makes_no_energy() {
        let mut scene = scene(BOX);
        (scene.plant.gravity, scene.plant.push_impulse, scene.plant.push_time) = (0.0, [0.4, 0.0, -1.0], 0.1);
        scene.initial = Initial { clearance: Some(0.0), ..Initial::default() };
        let corner = |k: usize| [0.05 * (1.0 - (k & 1) as f64 * 2.0), 0.05 * (1.0 - (k >> 1) as f64 * 2.0), -0.05];
        scene.bodies[0].contacts = (0..4).map(corner).collect();
        let mut plant = Plant::new(&scene).unwrap_or_else(|error| panic!("{error}"));
        let mut analysis = RunAnalysis::without_rows(&scene);
        for period in 0..500 {
            let mut truth = plant.truth();
            truth.stamp.sim_ns = period * 1_000_000;
            analysis.push(&truth);
            plant.advance(&Torques::default()).unwrap_or_else(|error| panic!("{error}"));
        }
        let energy = &analysis.energy;
        println!("{:e} J made, {:e} J of motion", energy.made, energy.kinetic);
        assert!(energy.kinetic < 1e-20 && energy.made <= energy.rounding(), "{:e} J", energy.made);
    }

    #[test]
    fn integration_errors_change_the_balance_and_work_of_drives_and_pushes_does_not() {
        let (spin, swing) = (scene(SPIN), scene(SWING));
        let [made, lost, kinetic] = balance(&spin, Method::SemiImplicitEuler, 1);
        assert!(made > 0.05 * kinetic, "the paper's step adds energy to a spin: {made} of {kinetic} J, lost {lost}");
        let [made, lost, kinetic] = balance(&swing, Method::SemiImplicitEuler, 1);
        assert!(lost > 0.2 * kinetic, "and removes it from a spring: {lost} of {kinetic} J, made {made}");
        for scene in [&spin, &swing] {
            let [made, lost, kinetic] = balance(scene, Method::MidpointContact, 1);
            println!("default: made {made:e}, lost {lost:e} of {kinetic:e} J");
            assert!(made.max(lost) < 2e-3 * kinetic, "{made:e} {lost:e} of {kinetic:e} J");
        }
    }
}
