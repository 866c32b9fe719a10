//! One step taken apart: each stage by itself, and the same step by `Plant::step`. `cargo run --release --example one_step`

use messages::{load, scene::Law};
use plant::composite::Composite;
use plant::contact::{Memory, Solver};
use plant::delassus::{ContactMap, Free};
use plant::factor::{Factor, PathMatrix};
use plant::ground::GroundHeights;
use plant::{Plant, detect, kinematics};

const SCENE: &str = r#"
plant = { dt = 0.001, method = "SemiImplicitEuler", drive_inertia = 0.1 } # the robot of Table 1, motors off
initial = { clearance = 0.0, velocity = [0.5, 0.0, 0.0], joints = [0.0, 0.5, -1.5, 1.0, -1.0, 1.5, -0.5, 0.0] }
"#;

/// Prints results of the stages, and compares the velocity at the end with that of `Plant::step`.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = load::parse(SCENE, "one step")?;
    let mut plant = Plant::new(&scene)?.without_standing_feet();
    let (model, mut state, h) = (plant.model().clone(), plant.state().clone(), scene.plant.dt);

    let mut pose = kinematics::Pose::new(&model); // poses and velocities of all links
    kinematics::pose(&model, &state, &mut pose);
    kinematics::velocities(&model, &state.xdot, &mut pose);

    let (mut inertia, mut velocity) = (PathMatrix::new(&model), vec![0.0; model.dofs()]);
    let (mut composite, mut factor) = (Composite::new(&model), Factor::new(&model));
    composite.inertia(&model, &pose, &mut inertia); // H of (1)
    composite.bias(&model, &pose, &state.xdot, &mut velocity); // b of (1): weight, Coriolis and centrifugal forces
    factor.factorize(&model, &inertia)?; // H = LᵀDL
    velocity.iter_mut().for_each(|b| *b *= -h);
    factor.solve(&model, &mut velocity);
    velocity.iter_mut().zip(&state.xdot).for_each(|(free, before)| *free += before); // (12) without contact
    println!("{} degrees of freedom; the hip would fall at {:.4} m/s", model.dofs(), -velocity[2]);

    let (mut touches, mut map, ground) = (vec![], ContactMap::new(&model), GroundHeights::plane(&model));
    detect::touching(&model, &ground, &pose, Law::Cone, h, &velocity, &mut touches); // contact points that may touch
    let free = Free { pose: &pose, factor: &factor, rate: &velocity };
    let problem = map.drift(&model, &free, &touches, Law::Cone, |_, velocity| velocity); // b of v = A f + b
    problem.friction.fill(scene.plant.friction);
    problem.approach.iter_mut().zip(&touches).for_each(|(approach, touch)| *approach = touch.approach);
    let problem = map.assemble(&model, &free, &touches); // A = KᵀH⁻¹K of (14)

    let mut solver = Solver::default();
    let report = solver.solve(problem, Law::Cone, &mut Memory::default()); // impulse f, (17)-(22)
    println!("{} contacts, natural map {:.0e}", touches.len(), report.natural_map);
    let change = map.respond(&model, &factor, &solver.impulse).change.to_vec(); // H⁻¹K f
    state.xdot.iter_mut().zip(velocity.iter().zip(change)).for_each(|(after, (free, change))| *after = free + change);
    state.advance(&model, h); // x₊ = x + h ẋ₊

    plant.step()?;
    let differences = state.xdot.iter().zip(&plant.state().xdot).map(|(ours, its)| (ours - its).abs());
    let greatest = differences.fold(0.0, f64::max);
    println!("Plant::step ends with the same velocity to {greatest:.0e} m/s");
    assert!(greatest < 1e-12 && report.natural_map < 1e-10);
    Ok(())
}
