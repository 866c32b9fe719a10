//! `biped study problems`: contact problems by the million, from whatever a robot or a heap of bodies can get into.
//!
//! A family is a way to make scenes by chance. Each of its episodes is one scene, simulated for some steps; the problem
//! of each step is solved again under each law, every fourth time without the basis of the last step. The impulse is
//! then judged afresh: what a solver says of itself counts for nothing.

use crate::exit::{Exit, Failure};
use crate::list::SCENES;
use controller::Controller;
use fastrand::Rng;
use messages::load::load;
use messages::robot::{Body, Joint, JointKind};
use messages::scene::{Base, Initial, Law, PlantScene, Scene};
use messages::wire::Torques;
use plant::Plant;
use plant::contact::{Memory, Problem, Report, Solver, tangents};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Instant;

/// Laws that are asked.
pub const LAWS: [Law; 2] = [Law::Aligned, Law::Complementarity];
/// Problems of one episode at most.
const EPISODE: usize = 25;
/// A residual up to this is a solution.
const SOLVED: f64 = 1e-10;

/// Where problems come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// The robot stands on both feet: eight corners, rank eleven at most.
    Standing,
    /// Its weight goes from both feet to one.
    Swaying,
    /// It walks, on ground of any friction, in any direction.
    Walking,
    /// It is pushed while it walks.
    Pushed,
    /// It walks without foot placement, pushed hard, until long after it fell.
    Falling,
    /// A box with two limbs, contacts all over, is thrown on the ground.
    Tumbling,
    /// One body on 64 corners.
    Corners,
    /// A chain of bodies whose masses differ by up to 1e9.
    IllScaled,
    /// Rods that slide fast on rough ground: the jams of Painlevé.
    Jams,
    /// Trees of bodies without any order.
    Chains,
}

impl Family {
    /// All of them.
    pub const ALL: [Family; 10] = [
        Family::Standing,
        Family::Swaying,
        Family::Walking,
        Family::Pushed,
        Family::Falling,
        Family::Tumbling,
        Family::Corners,
        Family::IllScaled,
        Family::Jams,
        Family::Chains,
    ];

    /// A scene of this family, and the time at which its problems begin to count.
    fn scene(self, random: &mut Rng) -> Result<(Scene, f64), Failure> {
        let mut between = |low: f64, high: f64| low + (high - low) * random.f64();
        Ok(match self {
            Family::Standing => (robot("stand", random)?, 0.0),
            Family::Swaying => (robot("walk", random)?, 0.5),
            Family::Walking => {
                let begin = between(1.3, 6.0);
                (robot("walk", random)?, begin)
            }
            Family::Pushed => {
                let begin = between(2.0, 6.0);
                let impulse = [between(-4.0, 4.0), between(-4.0, 4.0), between(-1.0, 1.0)];
                let mut scene = robot("walk", random)?;
                (scene.plant.push_impulse, scene.plant.push_time) = (impulse, begin);
                (scene, begin)
            }
            Family::Falling => {
                let begin = between(1.5, 3.5);
                let impulse = [between(-9.0, 9.0), between(-9.0, 9.0), between(-3.0, 3.0)];
                let mut scene = robot("walk", random)?;
                scene.controller.iter_mut().for_each(|controller| controller.foot_placement_gain = 0.0);
                (scene.plant.push_impulse, scene.plant.push_time) = (impulse, begin - 0.2);
                (scene, begin)
            }
            Family::Tumbling => (thrown(tumbler(random), 6.0, random), 0.0),
            Family::Corners => (thrown(vec![many_corners(random)], 0.5, random), 0.0),
            Family::IllScaled => {
                let bodies = tree(random, 9.0);
                (thrown(bodies, 1.0, random), 0.0)
            }
            Family::Jams => (jam(random), 0.0),
            Family::Chains => {
                let bodies = tree(random, 1.0);
                (thrown(bodies, 2.0, random), 0.0)
            }
        })
    }
}

/// The robot of Table 1 in one of the built-in scenes, on unknown ground with unknown load.
fn robot(name: &str, random: &mut Rng) -> Result<Scene, Failure> {
    let mut scene = load(name, &[], SCENES)?;
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

/// Bodies near the ground, in any attitude and motion; `speed` in m/s and, tenfold, rad/s.
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

/// A plate on 64 corners, in a grid or anywhere.
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

/// Three to eight bodies, each hung from one before it; masses spread over `decades`.
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

/// A rod, or one with a second hinged to it, pushed along rough ground at an angle at which it may jam.
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

/// What was found about one law on one family.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Problems.
    pub count: usize,
    /// Those that were given the basis of the step before …
    pub remembered: usize,
    /// … and those of which it was right.
    pub warm: usize,
    /// Most rows of a problem.
    pub rows: usize,
    /// Greatest natural map.
    pub natural_map: f64,
    /// Those with a natural map beyond 1e-10, or none.
    pub unsolved: usize,
    /// Those that went through a regularised problem.
    pub fallbacks: usize,
    /// Pivots of each problem, and the same in units of its rows.
    pub pivots: Vec<(u32, f64)>,
    /// Time of all solves [s].
    pub time: f64,
}

impl Tally {
    fn note(&mut self, problem: &Problem, is_remembered: bool, own: &Report, judged: &Report) {
        self.count += 1;
        self.remembered += usize::from(is_remembered);
        self.warm += usize::from(is_remembered && own.warm);
        self.rows = self.rows.max(problem.rows());
        self.natural_map = self.natural_map.max(judged.natural_map);
        self.unsolved += usize::from(judged.natural_map.is_nan() || judged.natural_map > SOLVED);
        self.fallbacks += usize::from(own.fallback);
        self.pivots.push((own.pivots, f64::from(own.pivots) / problem.rows() as f64));
    }

    fn merge(mut self, mut other: Tally) -> Tally {
        self.count += other.count;
        self.remembered += other.remembered;
        self.warm += other.warm;
        self.rows = self.rows.max(other.rows);
        self.natural_map = self.natural_map.max(other.natural_map);
        self.unsolved += other.unsolved;
        self.fallbacks += other.fallbacks;
        self.pivots.append(&mut other.pivots);
        self.time += other.time;
        self
    }
}

/// One episode: simulates a scene and solves its problems under each law.
///
/// # Errors
/// If the scene is bad, or on Ctrl-C.
fn episode(family: Family, seed: u64, count: usize, stop: &AtomicBool) -> Result<[Tally; 2], Failure> {
    let mut random = Rng::with_seed(seed);
    let (scene, begin) = family.scene(&mut random)?;
    let mut plant = Plant::new(&scene)?;
    let controller = scene.controller.as_ref().map(|_| Controller::new(&scene)).transpose();
    let mut controller = controller.map_err(controller::process::ProcessError::from)?;
    let (mut torques, mut encoders) = (Torques::default(), plant.encoders());
    let mut tallies: [Tally; 2] = Default::default();
    let mut solver = Solver::default();
    let mut memories: [Memory; 2] = Default::default();
    let mut step = 0;
    while tallies[0].count < count && step < 50_000 {
        if stop.load(Relaxed) {
            return Err(Failure::new(Exit::Interrupted, "interrupted"));
        }
        if let Some(controller) = &mut controller {
            // A controller that gives up after a fall leaves the joints to themselves.
            torques = controller.tick(&encoders).unwrap_or_default();
        }
        match plant.advance(&torques) {
            Ok(read) => encoders = read,
            Err(_) => break, // what was thrown too hard blows up
        }
        step += 1;
        let problem = plant.problem();
        if step as f64 * scene.plant.dt < begin || problem.contacts == 0 {
            continue;
        }
        for ((law, tally), memory) in LAWS.into_iter().zip(&mut tallies).zip(&mut memories) {
            let narrowed;
            let problem = if tangents(law) == problem.tangents {
                problem
            } else {
                narrowed = problem.narrowed(tangents(law));
                &narrowed
            };
            let is_remembered = random.f64() < 0.75 && *memory != Memory::default();
            if !is_remembered {
                *memory = Memory::default();
            }
            let start = Instant::now();
            let own = solver.solve(problem, law, memory);
            tally.time += start.elapsed().as_secs_f64();
            let impulse = solver.impulse.clone();
            let judged = solver.measure_impulse(problem, law, &impulse);
            tally.note(problem, is_remembered, &own, &judged);
        }
    }
    Ok(tallies)
}

/// Solves `count` problems, as many of each family, on all cores; `told` hears how many more are done.
///
/// # Errors
/// As [`episode`].
pub fn solve(count: usize, stop: &AtomicBool, told: impl Fn(u64) + Sync) -> Result<Vec<[Tally; 2]>, Failure> {
    let each = count.div_ceil(Family::ALL.len());
    Family::ALL
        .iter()
        .map(|&family| {
            let sum = |[a, b]: [Tally; 2], [c, d]: [Tally; 2]| [a.merge(c), b.merge(d)];
            (0..each.div_ceil(EPISODE))
                .into_par_iter()
                .map(|k| {
                    let count = EPISODE.min(each - k * EPISODE);
                    let tallies = episode(family, k as u64, count, stop)?;
                    told(count as u64);
                    Ok(tallies)
                })
                .try_reduce(Default::default, |a, b| Ok(sum(a, b)))
        })
        .collect()
}

/// Rows of the table, the first naming the columns.
pub fn rows(results: &mut [[Tally; 2]]) -> Vec<Vec<String>> {
    let columns = [
        "family",
        "law",
        "problems",
        "rows",
        "natural map",
        "unsolved",
        "fallbacks",
        "warm",
        "pivots p50",
        "p99.9",
        "max",
        "p99.9 per row",
        "µs",
    ];
    let mut rows = vec![columns.map(String::from).to_vec()];
    for (family, tallies) in Family::ALL.iter().zip(results) {
        for (law, tally) in LAWS.iter().zip(tallies) {
            let last = tally.pivots.len().saturating_sub(1) as f64;
            let at = |share: f64| (share * last) as usize;
            tally.pivots.sort_unstable_by_key(|count| count.0);
            let count = |share: f64| tally.pivots.get(at(share)).map_or(0, |p| p.0).to_string();
            let counts = [0.5, 0.999, 1.0].map(count);
            tally.pivots.sort_unstable_by(|a, b| a.1.total_cmp(&b.1));
            let per_row = tally.pivots.get(at(0.999)).map_or(0.0, |p| p.1);
            let warm = tally.warm as f64 / tally.remembered.max(1) as f64;
            let [p50, p999, most] = counts;
            rows.push(vec![
                format!("{family:?}").to_lowercase(),
                format!("{law:?}"),
                tally.count.to_string(),
                tally.rows.to_string(),
                format!("{:.1e}", tally.natural_map),
                tally.unsolved.to_string(),
                tally.fallbacks.to_string(),
                format!("{:.3}", warm),
                p50,
                p999,
                most,
                format!("{per_row:.2}"),
                format!("{:.1}", 1e6 * tally.time / tally.count.max(1) as f64),
            ]);
        }
    }
    rows
}
