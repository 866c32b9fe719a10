//! Families of contact problems: generators of random scenes.

use fastrand::Rng;
use messages::load::load;
use messages::robot::{Body, Joint, JointKind};
use messages::scene::{Base, Initial, Method, PlantScene, Scene};
use shared::exit::Failure;
use shared::list::SCENES;
use strum::VariantArray;

/// A generator of contact problems.
#[derive(Clone, Copy, Debug, PartialEq, Eq, VariantArray)]
pub enum ProblemFamily {
    /// The robot stands on both feet: eight contact points, rank at most eleven.
    Standing,
    /// Its weight shifts from both feet to one.
    Swaying,
    /// It walks in any direction on ground with any friction.
    Walking,
    /// It is pushed while it walks.
    Pushed,
    /// It walks without foot placement, falls after a hard push, and is simulated long after the fall.
    Falling,
    /// A box with two limbs and contact points at all corners is thrown onto the ground.
    Tumbling,
    /// One body on 64 contact points.
    Corners,
    /// A chain of bodies whose masses differ by up to 1e9.
    IllScaled,
    /// Rods that slide fast on rough ground: Painlevé's paradox.
    Jams,
    /// Random trees of bodies.
    Chains,
    /// The same with masses that differ by up to 1e14.
    Conditioned,
    /// Two legs, hinged at the top, that push their feet apart.
    Wedged,
    /// A tumbling box with up to four copies of each contact point.
    Duplicated,
    /// The tumbling box with friction from 0 to 1000, or with [`STICKS`].
    Rough,
}

/// Friction coefficient at which nothing slips [-].
const STICKS: f64 = 1e6;

impl ProblemFamily {
    /// A scene of this family, and the time from which its problems count [s].
    pub(super) fn scene(self, random: &mut Rng) -> Result<(Scene, f64), Failure> {
        let mut between = |low: f64, high: f64| low + (high - low) * random.f64();
        Ok(match self {
            ProblemFamily::Standing => (robot("stand", random)?, 0.0),
            ProblemFamily::Swaying => (robot("walk", random)?, 0.5),
            ProblemFamily::Walking => {
                let begin = between(1.3, 6.0);
                (robot("walk", random)?, begin)
            }
            ProblemFamily::Pushed => {
                let begin = between(2.0, 6.0);
                let impulse = [between(-4.0, 4.0), between(-4.0, 4.0), between(-1.0, 1.0)];
                let mut scene = robot("walk", random)?;
                (scene.plant.push_impulse, scene.plant.push_time) = (impulse, begin);
                (scene, begin)
            }
            ProblemFamily::Falling => {
                let begin = between(1.5, 3.5);
                let impulse = [between(-9.0, 9.0), between(-9.0, 9.0), between(-3.0, 3.0)];
                let mut scene = robot("walk", random)?;
                scene.controller.iter_mut().for_each(|controller| controller.foot_placement_gain = 0.0);
                (scene.plant.push_impulse, scene.plant.push_time) = (impulse, begin - 0.2);
                (scene, begin)
            }
            ProblemFamily::Tumbling => (thrown(tumbler(random), 6.0, random), 0.0),
            ProblemFamily::Corners => (thrown(vec![many_corners(random)], 0.5, random), 0.0),
            ProblemFamily::IllScaled => {
                let bodies = tree(random, 9.0);
                (thrown(bodies, 1.0, random), 0.0)
            }
            ProblemFamily::Jams => (jam(random), 0.0),
            ProblemFamily::Chains => {
                let bodies = tree(random, 1.0);
                (thrown(bodies, 2.0, random), 0.0)
            }
            ProblemFamily::Conditioned => {
                let bodies = tree(random, 14.0);
                (thrown(bodies, 1.0, random), 0.0)
            }
            ProblemFamily::Wedged => (wedge(random), 0.0),
            ProblemFamily::Duplicated => {
                let mut bodies = tumbler(random);
                bodies.iter_mut().for_each(|body| body.contacts = body.contacts.repeat(random.usize(2..=4)));
                (thrown(bodies, 6.0, random), 0.0)
            }
            ProblemFamily::Rough => {
                let mut scene = thrown(tumbler(random), 6.0, random);
                let any = 10f64.powf(6.0 * random.f64() - 3.0);
                scene.plant.friction = *random.choice(&[0.0, any, any, any, STICKS]).unwrap_or(&any);
                (scene, 0.0)
            }
        })
    }
}

/// The robot of Table 1 in a built-in scene, with random ground and load.
fn robot(name: &str, random: &mut Rng) -> Result<Scene, Failure> {
    let mut scene = load(name, &[], SCENES)?;
    scene.plant.method = Method::SemiImplicitEuler;
    scene.plant.dt = *random.choice(&[2.5e-4, 5e-4, 1e-3]).unwrap_or(&5e-4);
    scene.rate = 1.0 / scene.plant.dt;
    scene.plant.friction = 0.3 + 0.9 * random.f64();
    scene.plant.payload_kg = 2.0 * random.f64();
    scene.plant.payload_offset = [0.0; 3].map(|_: f64| 0.04 * (random.f64() - 0.5));
    scene.plant.encoder_bits = random.u32(16..=24);
    scene.initial.orientation_deg = [0.0, 0.0, 360.0 * random.f64()];
    if random.bool() {
        scene.initial.clearance = Some(1e-3 * random.f64());
        scene.initial.velocity = [0.0; 3].map(|_: f64| 0.1 * (random.f64() - 0.5));
    }
    Ok(scene)
}

/// Bodies near the ground with random attitude and motion: up to `speed` m/s and 10 `speed` rad/s.
fn thrown(bodies: Vec<Body>, speed: f64, random: &mut Rng) -> Scene {
    let dt = 10f64.powf(-2.0 - 2.0 * random.f64());
    let joints = bodies.len() - 1;
    let calm = random.f64().powi(2);
    let mut any = |size: f64| size * (2.0 * random.f64() - 1.0);
    let initial = Initial {
        clearance: Some(0.0),
        orientation_deg: [any(180.0 * calm), any(80.0 * calm), any(180.0)],
        velocity: [0.0; 3].map(|_: f64| any(speed)),
        angular_velocity: [0.0; 3].map(|_: f64| any(10.0 * speed * calm)),
        joints: (0..joints).map(|_| any(2.0 * calm)).collect(),
        joint_rates: (0..joints).map(|_| any(5.0 * speed * calm)).collect(),
        ..Initial::default()
    };
    let plant = PlantScene {
        dt,
        base: Base::Quaternion,
        method: Method::SemiImplicitEuler, // one problem per step: steps are not split at impacts
        friction: *random.choice(&[0.0, 0.1, 0.3, 0.5, 0.7, 1.0, 1.5]).unwrap_or(&0.5),
        drive_inertia: if random.bool() { 0.0 } else { 0.1 },
        ..PlantScene::default()
    };
    Scene { rate: 1.0 / dt, plant, initial, bodies, ..Scene::default() }
}

fn body(name: String, mass: f64, size: [f64; 3], contacts: Vec<[f64; 3]>) -> Body {
    Body { name, mass, size, contacts, ..Body::default() }
}

/// Corners of a box.
fn corners(size: [f64; 3]) -> Vec<[f64; 3]> {
    let sign = |bits: usize, k: usize| if bits >> k & 1 == 1 { 0.5 } else { -0.5 };
    (0..8).map(|bits| [0, 1, 2].map(|k| sign(bits, k) * size[k])).collect()
}

fn tumbler(random: &mut Rng) -> Vec<Body> {
    let size = [0.0; 3].map(|_: f64| 0.1 + 0.4 * random.f64());
    let mut bodies = vec![body("box".into(), 2.0, size, corners(size))];
    for side in [1.0, -1.0] {
        let limb = [0.05, 0.05, 0.3];
        bodies.push(Body {
            joint: Some(hinge("box", [0.0, 1.0, 0.0], [0.0, side * size[1] / 2.0, 0.0])),
            com: [0.0, 0.0, -0.15],
            contacts: vec![[0.0, 0.0, -0.3]],
            ..body(format!("limb {side}"), 0.5, limb, vec![])
        });
    }
    bodies
}

fn hinge(parent: &str, axis: [f64; 3], at: [f64; 3]) -> Joint {
    Joint { parent: parent.into(), axis, at, ..Joint::default() }
}

/// A plate with 64 contact points, in a grid or at random places.
fn many_corners(random: &mut Rng) -> Body {
    let (grid, [a, b]) = (random.bool(), [0.05 + random.f64(), 0.05 + random.f64()]);
    let place = |k: usize| (k as f64) / 7.0 - 0.5;
    let contacts = (0..64).map(|k| {
        let [x, y] = if grid { [place(k % 8), place(k / 8)] } else { [random.f64() - 0.5, random.f64() - 0.5] };
        [a * x, b * y, -0.05]
    });
    let contacts = contacts.collect();
    body("plate".into(), 3.0, [a, b, 0.1], contacts)
}

/// Three to eight bodies, each with an earlier one as its parent; masses vary over `decades` powers of ten.
fn tree(random: &mut Rng, decades: f64) -> Vec<Body> {
    let mut bodies: Vec<Body> = Vec::new();
    for i in 0..random.usize(3..=8) {
        let size = [0.0; 3].map(|_: f64| 0.05 + 0.3 * random.f64());
        let mut contacts = corners(size);
        random.shuffle(&mut contacts);
        contacts.truncate(random.usize(1..=4));
        let mass = 10f64.powf(decades * random.f64() - 0.5 * decades);
        let mut next = body(format!("body {i}"), mass, size, contacts);
        if i > 0 {
            let parent = &bodies[random.usize(0..i)];
            let mut axis = [0.0; 3].map(|_: f64| random.f64() - 0.5);
            let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
            axis = axis.map(|x| x / length);
            let at = parent.size.map(|side| side * (random.f64() - 0.5));
            let kind = if random.f64() < 0.8 { JointKind::Revolute } else { JointKind::Prismatic };
            next.joint = Some(Joint { kind, ..hinge(&parent.name, axis, at) });
            next.com = size.map(|side| 0.5 * side);
        }
        bodies.push(next);
    }
    bodies
}

/// A rod, perhaps with a second one hinged to it, pushed along rough ground at an angle at which it may jam.
fn jam(random: &mut Rng) -> Scene {
    let ends = |length: f64| vec![[0.5 * length, 0.0, 0.0], [-0.5 * length, 0.0, 0.0]];
    let mut bodies = vec![body("rod".into(), 1.0, [2.0, 0.02, 0.02], ends(2.0))];
    if random.bool() {
        let next = body("second".into(), random.f64() + 0.1, [1.0, 0.02, 0.02], ends(1.0));
        bodies.push(Body { joint: Some(hinge("rod", [0.0, 1.0, 0.0], [1.0, 0.0, 0.0])), ..next });
    }
    let mut scene = thrown(bodies, 1.0, random);
    scene.plant.friction = 1.0 + 2.0 * random.f64();
    scene.plant.drive_inertia = 0.0;
    scene.initial.orientation_deg = [0.0, 20.0 + 60.0 * random.f64(), 360.0 * random.f64()];
    scene.initial.velocity[0] *= 10.0;
    scene.initial.angular_velocity = scene.initial.angular_velocity.map(|rate| 0.1 * rate);
    scene
}

/// An A-frame: two legs hinged at the top, a load there, and feet with one to four contact points. Friction may or may not hold it.
fn wedge(random: &mut Rng) -> Scene {
    let mut between = |low: f64, high: f64| low + (high - low) * random.f64();
    let (spread, load, friction) = (between(0.2, 1.3), 10f64.powf(between(-1.0, 3.0)), 10f64.powf(between(-1.0, 1.0)));
    let clearance = 1e-3 * between(0.0, 1.0);
    let mut bodies = vec![body("load".into(), load, [0.1; 3], vec![])];
    for side in [1.0, -1.0] {
        let [x, y] = [0.02, 0.05].map(|half| if random.bool() { half } else { 0.0 });
        let corners = [[x, y], [x, -y], [-x, y], [-x, -y]].map(|[x, y]| [x, y, -1.0]);
        bodies.push(Body {
            joint: Some(hinge("load", [0.0, 1.0, 0.0], [0.0, side * 0.1, 0.0])),
            com: [0.0, 0.0, -0.5],
            contacts: corners.to_vec(),
            ..body(format!("leg {side}"), 1.0, [0.05, 0.05, 1.0], vec![])
        });
    }
    let mut scene = thrown(bodies, 0.01, random);
    scene.plant.friction = friction;
    scene.plant.drive_inertia = 0.0;
    scene.initial.clearance = Some(clearance);
    scene.initial.orientation_deg = [0.0; 3];
    scene.initial.joints = vec![0.5 * spread, -0.5 * spread];
    scene
}
