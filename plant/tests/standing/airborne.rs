//! A foot about to land while another one stands.

use biped_plant::Plant;
use biped_plant::kinematics::{self, Pose};
use messages::robot::{Body, Joint};
use messages::scene::{Base, Method, Scene};
use messages::wire::Torques;

const STEP: f64 = 5e-3;
/// Force on the foot, ten times its weight [N].
const FORCE: f64 = 2000.0;

/// A rod that tips over on a hinge above a standing foot, with its end `clearance` above the ground and falling.
fn tipping_rod(angle: f64) -> Scene {
    let (height, length) = (0.2, 0.6);
    let sole = [[0.2, 0.2], [0.2, -0.2], [-0.2, 0.2], [-0.2, -0.2]].map(|[x, y]| [x, y, 0.0]);
    let foot =
        Body { name: "foot".into(), mass: 20.0, size: [0.4, 0.4, 0.1], contacts: sole.into(), ..Body::default() };
    let joint = Joint { parent: "foot".into(), axis: [0.0, 1.0, 0.0], at: [0.0, 0.0, height], ..Joint::default() };
    let rod = Body {
        name: "rod".into(),
        mass: 1.0,
        size: [length, 0.05, 0.05],
        com: [0.5 * length, 0.0, 0.0],
        contacts: vec![[length, 0.0, 0.0]],
        joint: Some(joint),
        ..Body::default()
    };
    let mut scene = Scene { bodies: vec![foot, rod], ..Scene::default() };
    (scene.plant.base, scene.plant.method) = (Base::Quaternion, Method::SemiImplicitEuler);
    (scene.plant.dt, scene.rate, scene.plant.drive_inertia, scene.plant.friction) = (STEP, 1.0 / STEP, 0.0, 1.0);
    scene.initial.clearance = Some(0.0);
    scene.initial.joints = vec![(height / length).asin() - angle];
    scene
}

/// Without contact, the force on the foot would move the hinge down and throw the end of the rod up. But the ground holds the foot, so the
/// end comes down. A foot that seemed airborne must then land on the ground, not in it.
#[test]
fn a_foot_driven_down_by_a_standing_foot_lands_on_the_ground() {
    let (mut airborne, mut landed) = (0, 0);
    for start in 0..200 {
        let mut plant = Plant::new(&tipping_rod(0.05 + 1e-3 * f64::from(start))).expect("a rod on a foot");
        assert!(plant.push(0, [0.0, 0.0, -FORCE * 40.0 * STEP], 40.0 * STEP), "a foot");
        let mut before = Pose::new(plant.model());
        let end = plant.model().contact_points[4].clone();
        for step in 0..40 {
            kinematics::pose(plant.model(), plant.state(), &mut before);
            let gap = before.point(end.link, &end.at).z;
            plant.advance(&Torques::default()).expect("a step");
            let after = before.twist(plant.model(), end.link, &plant.state().xdot);
            let left = gap + STEP * after.at(&before.arm(end.link, &end.at)).z;
            assert!(left > -1e-12, "start {start}, step {step}: {left:e} m from {gap:e} m");
            let (touching, held) = (plant.problem().contacts, plant.problem().delassus.is_empty());
            airborne += usize::from(touching == 5 && held);
            if left < 1e-12 {
                landed += 1;
                break;
            }
        }
    }
    println!("{landed} of 200 rods landed; {airborne} steps airborne beside a foot that was held");
    assert!(landed == 200 && airborne > 20, "{landed}, {airborne}");
}
