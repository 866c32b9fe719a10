//! Runs one scene in rapier: `rapier-scenes trace|time DT STEPS STRIDE < scene.json`.
//!
//! `trace` prints a row per STRIDE steps: poses `x y z qw qx qy qz` of the watched bodies, or the kinetic energy if none
//! is watched; `time` prints the CPU time of a step in seconds.

use cpu_time::ThreadTime;
use rapier3d_f64::{na::Unit, prelude::*};
use serde::Deserialize;
use std::error::Error;

#[derive(Deserialize)]
struct Scene {
    gravity: [f64; 3],
    friction: f64,
    contact: bool,
    links: Vec<Link>,
    watch: Vec<usize>,
}

#[derive(Deserialize)]
struct Link {
    mass: f64,
    com: [f64; 3],
    inertia: [f64; 3],
    position: [f64; 3],
    quaternion: [f64; 4],
    velocity: [f64; 3], // of the centre of mass
    spin: [f64; 3],
    joint: Option<Hinge>,
    box_size: Option<[f64; 3]>, // about the centre of mass
    tips: Vec<[f64; 3]>,        // centres of spheres
    tip: f64,                   // radius of these spheres
}

#[derive(Deserialize)]
struct Hinge {
    parent: usize,
    anchor: [f64; 3],
    axis: [f64; 3],
    angle: f64, // at the start
    rate: f64,
    stiffness: f64,
    damping: f64,
    rest: f64,
}

struct RapierWorld {
    gravity: Vector,
    parameters: IntegrationParameters,
    pipeline: PhysicsPipeline,
    islands: IslandManager,
    broad_phase: BroadPhaseBvh,
    narrow_phase: NarrowPhase,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    impulse_joints: ImpulseJointSet,
    multibody_joints: MultibodyJointSet,
    soft_bodies: SoftBodySet,
    ccd: CCDSolver,
    handles: Vec<RigidBodyHandle>,
}

impl RapierWorld {
    fn new(scene: &Scene, dt: f64) -> Result<RapierWorld, Box<dyn Error>> {
        let parameters = IntegrationParameters { dt, ..Default::default() };
        let mut world = RapierWorld {
            gravity: Vector::from(scene.gravity),
            parameters,
            pipeline: PhysicsPipeline::new(),
            islands: IslandManager::new(),
            broad_phase: BroadPhaseBvh::new(),
            narrow_phase: NarrowPhase::new(),
            bodies: RigidBodySet::new(),
            colliders: ColliderSet::new(),
            impulse_joints: ImpulseJointSet::new(),
            multibody_joints: MultibodyJointSet::new(),
            soft_bodies: SoftBodySet::new(),
            ccd: CCDSolver::new(),
            handles: Vec::new(),
        };
        if scene.contact {
            let up = Unit::new_unchecked(Vector::Z);
            world.colliders.insert(ColliderBuilder::halfspace(up).friction(scene.friction));
        }
        for link in &scene.links {
            world.add(scene, link);
        }
        world.articulate(scene)?;
        Ok(world)
    }

    /// A link as a rigid body, with its colliders.
    fn add(&mut self, scene: &Scene, link: &Link) {
        let inertia = MassProperties::new(Vector::from(link.com), link.mass, Vector::from(link.inertia));
        let body = RigidBodyBuilder::dynamic()
            .pose(Pose::from_parts(Vector::from(link.position), rotation(link.quaternion)))
            .linvel(Vector::from(link.velocity))
            .angvel(Vector::from(link.spin))
            .additional_mass_properties(inertia)
            .gyroscopic_forces_enabled(true)
            .can_sleep(false);
        let handle = self.bodies.insert(body);
        self.handles.push(handle);
        if !scene.contact {
            return;
        }
        let mut touch = |collider: ColliderBuilder, at: [f64; 3]| {
            let collider = collider.translation(Vector::from(at)).density(0.0).friction(scene.friction);
            self.colliders.insert_with_parent(collider, handle, &mut self.bodies);
        };
        if let Some([x, y, z]) = link.box_size {
            touch(ColliderBuilder::cuboid(0.5 * x, 0.5 * y, 0.5 * z), link.com);
        }
        for &tip in &link.tips {
            touch(ColliderBuilder::ball(link.tip), tip);
        }
    }

    /// Hinges in reduced coordinates that count from the angles at the start; servos as motors.
    fn articulate(&mut self, scene: &Scene) -> Result<(), Box<dyn Error>> {
        let mut last = None;
        for (link, &handle) in scene.links.iter().zip(&self.handles) {
            let Some(hinge) = &link.joint else { continue };
            let axis = Vector::from(hinge.axis);
            let frame = Rotation::from_rotation_arc(Vector::X, axis);
            let turned = Rotation::from_axis_angle(axis, -hinge.angle) * frame;
            let joint = GenericJointBuilder::new(JointAxesMask::LOCKED_REVOLUTE_AXES)
                .local_frame1(Pose::from_parts(Vector::from(hinge.anchor), frame))
                .local_frame2(Pose::from_parts(Vector::ZERO, turned))
                .contacts_enabled(false);
            last = self.multibody_joints.insert(self.handles[hinge.parent], handle, joint.build(), true);
        }
        let Some(joint) = last else { return Ok(()) };
        let (multibody, _) = self.multibody_joints.get_mut(joint).ok_or("no multibody")?;
        multibody.set_self_contacts_enabled(false);
        multibody.damping_mut().rows_mut(0, 6).fill(0.0);
        let hinges = || scene.links.iter().filter_map(|link| link.joint.as_ref());
        for (hinge, link) in hinges().zip(multibody.links_mut().skip(1)) {
            link.joint.set_spring(3, hinge.stiffness, hinge.rest - hinge.angle);
        }
        hinges().enumerate().for_each(|(i, hinge)| multibody.damping_mut()[6 + i] = hinge.damping);
        let base = &scene.links[0];
        let rates = hinges().map(|hinge| hinge.rate);
        let velocities = base.velocity.into_iter().chain(base.spin).chain(rates);
        multibody.generalized_velocity_mut().iter_mut().zip(velocities).for_each(|(slot, velocity)| *slot = velocity);
        Ok(())
    }

    fn step(&mut self) {
        self.pipeline.step(
            self.gravity,
            &self.parameters,
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &mut self.impulse_joints,
            &mut self.multibody_joints,
            &mut self.soft_bodies,
            &mut self.ccd,
            &(),
            &(),
        );
    }

    /// Kinetic energy of one link [J].
    fn kinetic_energy(&self, link: &Link, handle: RigidBodyHandle) -> f64 {
        let body = &self.bodies[handle];
        let (velocity, spin) = (body.linvel(), body.rotation().inverse() * body.angvel());
        0.5 * (link.mass * velocity.dot(velocity) + spin.dot(Vector::from(link.inertia) * spin))
    }

    fn print(&self, scene: &Scene) {
        if scene.watch.is_empty() {
            let links = scene.links.iter().zip(&self.handles);
            return println!("{:e}", links.map(|(link, &handle)| self.kinetic_energy(link, handle)).sum::<f64>());
        }
        let poses = scene.watch.iter().map(|&link| self.bodies[self.handles[link]].position());
        let cells = poses.flat_map(|pose| {
            let (p, q) = (pose.translation, pose.rotation);
            [p.x, p.y, p.z, q.w, q.x, q.y, q.z].map(|value| format!("{value:e}"))
        });
        println!("{}", cells.collect::<Vec<_>>().join(" "));
    }
}

fn rotation([w, x, y, z]: [f64; 4]) -> Rotation {
    Rotation::from_xyzw(x, y, z, w)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<_> = std::env::args().collect();
    let [_, mode, dt, steps, stride] = arguments.as_slice() else {
        return Err("usage: rapier-scenes trace|time DT STEPS STRIDE < scene.json".into());
    };
    let (steps, stride): (usize, usize) = (steps.parse()?, stride.parse()?);
    let scene: Scene = serde_json::from_reader(std::io::stdin())?;
    let mut world = RapierWorld::new(&scene, dt.parse()?)?;
    if mode == "time" {
        let start = ThreadTime::now();
        (0..steps).for_each(|_| world.step());
        println!("{:e}", start.elapsed().as_secs_f64() / steps as f64);
        return Ok(());
    }
    world.print(&scene);
    for step in 1..=steps {
        world.step();
        if step % stride == 0 {
            world.print(&scene);
        }
    }
    Ok(())
}
