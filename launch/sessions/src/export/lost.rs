//! What a file of the exported robot does not say, although the scene does: a sentence for each.

use super::format::RobotFormat;
use super::robot::{ExportRobot, POINT_RADIUS};
use messages::robot::{Body, canonical_biped};
use messages::scene::{Base, PlantScene, Scene};

/// The sentences for a format.
pub fn sentences(scene: &Scene, robot: &ExportRobot, format: RobotFormat) -> Vec<String> {
    let plant = &scene.plant;
    let named = |has: fn(&Body) -> bool| {
        let names = scene.bodies.iter().filter(|body| has(body)).map(|body| format!("`{}`", body.name));
        Some(names.collect::<Vec<_>>().join(", ")).filter(|names| !names.is_empty())
    };
    let springs = named(|body| body.joint.as_ref().is_some_and(|joint| joint.stiffness != 0.0));
    let tiles = named(|body| body.tiles.is_some());
    let turned = robot.bodies.iter().find(|body| [(0, 1), (0, 2), (1, 2)].iter().any(|&at| body.inertia[at] != 0.0));
    let bits = plant.encoder_bits;
    let encoders = (bits != PlantScene::default().encoder_bits)
        .then(|| format!("plant.encoder_bits = {bits} is not written: the format has no resolution of encoders"));
    let tiles = tiles.map(|names| format!("the tiles of {names} are not written: the format has no such ground"));
    match format {
        RobotFormat::Urdf => [
            encoders,
            (plant.base == Base::Planar)
                .then(|| "plant.base = \"planar\" is not written: a robot in URDF moves freely, or is fixed".into()),
            named(|body| body.spheres.iter().any(|ball| ball.radius == POINT_RADIUS)).map(|names| {
                format!(
                    "the balls of {names} with a radius of {POINT_RADIUS} m are not written as balls: --robot reads spheres of \
                     this radius as contact points"
                )
            }),
            springs.map(|names| format!("the springs in the joints of {names} are not written: URDF has none")),
            tiles,
            turned.map(|body| {
                let read = "other programs read them, but --robot refuses them";
                format!("the payload gives `{}` products of inertia: {read}", body.name)
            }),
        ]
        .into_iter()
        .flatten()
        .collect(),
        RobotFormat::Mjcf => {
            let restitution = (plant.restitution != 0.0).then(|| {
                format!("plant.restitution = {} is not written: MJCF has no coefficient of restitution", plant.restitution)
            });
            encoders.into_iter().chain(tiles).chain(restitution).collect()
        }
        RobotFormat::Toml => {
            let payload = (plant.payload_kg != 0.0).then(|| {
                format!("plant.payload_kg = {} is not written: it belongs to the scene, as --set", plant.payload_kg)
            });
            let held = match plant.base {
                Base::Fixed => Some("fixed"),
                Base::Planar => Some("planar"),
                Base::Virtual | Base::Quaternion => None, // both are free
            };
            let held = held.filter(|_| canonical_biped(&scene.bodies).is_ok()).map(|base| {
                format!("plant.base = \"{base}\" is not written: it belongs to the scene, as --set")
            });
            payload.into_iter().chain(held).collect()
        }
    }
}
