//! One step taken apart: each stage by itself, and the same step by `Plant::step`. `cargo run --release --example one_step`

use messages::{load, scene::Law};
use plant::contact::{Memory, Solver};
use plant::delassus::{ContactMap, Free};
use plant::{Plant, composite::Composite, detect, factor::Factor, ground::GroundHeights, kinematics::Pose};

const SCENE: &str = r#"
plant = { dt = 0.001, method = "SemiImplicitEuler", drive_inertia = 0.1 } # the robot of Table 1, motors off
initial = { clearance = 0.0, velocity = [0.5, 0.0, 0.0], joints = [0.0, 0.5, -1.5, 1.0, -1.0, 1.5, -0.5, 0.0] }
"#;

/// Prints results of the stages, and compares the velocity at the end with that of `Plant::step`.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = load::parse(SCENE, "one step")?;
    let mut plant = Plant::new(&scene)?.without_standing_feet();
    let (model, before, h) = (plant.model().clone(), plant.state().clone(), scene.plant.dt);

    let pose = Pose::of(&model, &before); // of all links, and their velocities
    let (inertia, mut velocity) = Composite::equations(&model, &pose, &before.xdot); // H and b of (1)
    let factor = Factor::of(&model, &inertia)?; // H = LᵀDL
    factor.solve(&model, &mut velocity); // H⁻¹b
    velocity.iter_mut().zip(&before.xdot).for_each(|(v, before)| *v = before - h * *v); // (12) without contact

    let (mut touches, ground) = (vec![], GroundHeights::plane(&model));
    detect::touching(&model, &ground, &pose, Law::Cone, h, &velocity, &mut touches); // contact points that may touch
    let (mut map, free) = (ContactMap::new(&model), Free { pose: &pose, factor: &factor, rate: &velocity });
    let problem = map.set_up(&model, &free, &touches, Law::Cone, scene.plant.friction); // v = A f + b, (14)
    let mut solver = Solver::default();
    let report = solver.solve(problem, Law::Cone, &mut Memory::default()); // impulse f, (17)-(22)
    println!("{} contacts, natural map {:.0e}", touches.len(), report.natural_map);
    let change = map.respond(&model, &factor, &solver.impulse).change; // H⁻¹K f, (12)

    plant.step()?;
    let ours = velocity.iter().zip(change).map(|(free, change)| free + change);
    let difference = ours.zip(&plant.state().xdot).map(|(ours, its)| (ours - its).abs()).fold(0.0, f64::max);
    println!("Plant::step ends with the same velocity to {difference:.0e} m/s");
    assert!(difference < 1e-12 && report.natural_map < 1e-10);
    Ok(())
}
