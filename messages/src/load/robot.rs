//! Replacing the robot of a scene: reading the new robot from a file, and scaling the numbers of the scene to it.
//!
//! | scaled by dynamic similarity, see [`SimilarityScale`] | unchanged |
//! |---|---|
//! | gait: period √L, speed √L, heights L | duration, rates, steps, ground, gravity |
//! | gains and bandwidths of planner and servos 1/√L | dimensionless gains |
//! | drives, if the robot's file does not set them: J_r M L², D M L√L, torque limit M L | payload, pushes, delays |
//! | initial posture: the centre of gravity is over the same point of the soles | |

use super::error::SceneError;
use super::robot_file::RobotFile;
use super::{check, units, urdf};
use crate::robot::{CROUCH, Robot, SimilarityScale, canonical_biped, stance};
use crate::scene::{ControllerScene, Initial, PlantScene, Scene};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Reads a robot from a file, in canonical order and checked. The file is URDF if its name ends in `.urdf` or its text is XML;
/// otherwise it is TOML.
///
/// # Errors
/// See [`SceneError`].
pub fn read(path: &Path) -> Result<Robot, SceneError> {
    Ok(file(path)?.robot)
}

/// The same, with the notes. The file is read once, because it may be a pipe.
pub(super) fn file(path: &Path) -> Result<RobotFile, SceneError> {
    let origin = if path.as_os_str().is_empty() { "robot = \"\"".into() } else { path.display().to_string() };
    let text = crate::file::text(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => {
            SceneError::Robot { origin: origin.clone(), reason: "there is no such file".into() }
        }
        _ => SceneError::Unreadable { path: origin.clone(), reason: error },
    })?;
    of_text(&text, path, &origin)
}

/// The robot of the text of the file at a path; `origin` names it in errors.
pub(super) fn of_text(text: &str, path: &Path, origin: &str) -> Result<RobotFile, SceneError> {
    let refused = |reason| SceneError::Robot { origin: origin.into(), reason };
    if text.trim().is_empty() {
        return Err(refused("the file is empty; `biped export toml` writes a robot to edit".into()));
    }
    let is_urdf = path.extension().is_some_and(|end| end == "urdf") || text.trim_start().starts_with('<');
    let mut file = match is_urdf {
        true => urdf::parse(text).map_err(refused)?,
        false => {
            let malformed = |reason| SceneError::Malformed { origin: origin.into(), reason: Box::new(reason) };
            RobotFile { robot: toml::from_str(text).map_err(malformed)?, notes: vec![], mount: None }
        }
    };
    check::robot(&file.robot, origin).map_err(|error| match error {
        SceneError::Invalid { key, value, rule, .. } if is_urdf => {
            refused(format!("{} is {value}, but {rule}", urdf::words::of_key(&key, &file.robot.bodies)))
        }
        error => error,
    })?;
    file.robot.bodies = canonical_biped(&file.robot.bodies).map_err(refused)?;
    file.notes.extend(units::doubts(&file.robot.bodies));
    if file.robot.name.is_empty() {
        file.robot.name = path.file_stem().unwrap_or_default().to_string_lossy().into();
    }
    Ok(file)
}

/// The robot file that a scene names.
fn file_beside(scene: &Scene, text: &str, origin: &str) -> Option<PathBuf> {
    let given: Table = text.parse().unwrap_or_default();
    let path = scene.robot.as_ref().filter(|_| !given.contains_key("bodies"))?;
    Some(Path::new(origin).parent().unwrap_or(Path::new("")).join(path))
}

/// The scene of a file, complete, and the file of its robot. If it names one, the defaults are those of `walk`, scaled to the robot.
pub(super) fn resolved(scene: Scene, text: &str, origin: &str) -> Result<(Scene, Option<RobotFile>), SceneError> {
    let given: Table = text.parse().unwrap_or_default();
    let Some(path) = scene.robot.clone() else { return Ok((scene, None)) };
    let refused = |reason: String| SceneError::Robot { origin: origin.into(), reason };
    if given.contains_key("bodies") {
        let is_file = [".toml", ".urdf"].iter().any(|end| path.ends_with(end));
        let both = format!("robot = {path} is a file, but the scene also has bodies: leave out one of them");
        return if is_file { Err(refused(both)) } else { Ok((scene, None)) };
    }
    let file = file(&file_beside(&scene, text, origin).unwrap_or_default())?;
    let mut defaults = Scene {
        controller: Some(ControllerScene::default()),
        initial: Initial { clearance: Some(0.0), joints: CROUCH.into(), ..Initial::default() },
        ..Scene::default()
    };
    defaults = with_robot(&defaults, &file.robot).map_err(refused)?;
    defaults.controller = defaults.controller.filter(|_| scene.controller.is_some());
    let name = defaults.robot.clone();
    let mut whole = Value::try_from(defaults).map_err(|error| refused(error.to_string()))?;
    overlay(&mut whole, Value::Table(given));
    let scene = Scene::deserialize(whole).map_err(|error| refused(error.to_string()))?;
    Ok((Scene { robot: name, ..scene }, Some(file)))
}

/// Merges tables and replaces all other values.
fn overlay(under: &mut Value, over: Value) {
    match (under, over) {
        (Value::Table(under), Value::Table(over)) => {
            over.into_iter().for_each(|(key, value)| match under.get_mut(&key) {
                Some(slot) => overlay(slot, value),
                None => drop(under.insert(key, value)),
            })
        }
        (slot, value) => *slot = value,
    }
}

/// The scene with its robot replaced, scaled as the table above shows. Replacing a robot by itself changes no bit.
///
/// # Errors
/// If the bodies of the scene are not a biped, so that there is no scale, or if the robot cannot reach the initial posture.
pub fn with_robot(scene: &Scene, robot: &Robot) -> Result<Scene, String> {
    let springs = scene.bodies.iter().flat_map(|body| &body.joint).any(|joint| joint.stiffness != 0.0);
    let own = canonical_biped(&scene.bodies).ok().filter(|own| *own == scene.bodies && !springs);
    let own = own.ok_or("only a biped without springs, such as that of `walk`, can be replaced by another robot")?;
    let scale = SimilarityScale::between(&own, &robot.bodies);
    if scale.length.is_nan() || scale.length <= 0.0 {
        return Err("its centre of gravity is not above its soles at zero angles".into());
    }
    Ok(Scene {
        plant: plant(&scene.plant, robot, scale),
        controller: scene.controller.as_ref().map(|controller| scaled(controller, scale)),
        initial: Initial { joints: stance(&own, &scene.initial.joints, &robot.bodies)?, ..scene.initial.clone() },
        robot: Some(robot.name.clone()),
        bodies: robot.bodies.clone(),
        ..scene.clone()
    })
}

fn plant(plant: &PlantScene, robot: &Robot, scale: SimilarityScale) -> PlantScene {
    let drives = robot.drives;
    PlantScene {
        drive_inertia: drives.inertia.unwrap_or(plant.drive_inertia * scale.inertia()),
        joint_damping: drives.damping.unwrap_or(plant.joint_damping * scale.torque() * scale.time()),
        torque_limit: drives.torque_limit.unwrap_or(plant.torque_limit * scale.torque()),
        encoder_bits: drives.encoder_bits.unwrap_or(plant.encoder_bits),
        ..plant.clone()
    }
}

fn scaled(from: &ControllerScene, scale: SimilarityScale) -> ControllerScene {
    let SimilarityScale { length, .. } = scale;
    let (time, speed) = (scale.time(), scale.speed());
    ControllerScene {
        period: from.period * time,
        speed: from.speed * speed,
        com_height: from.com_height * length,
        swing_height: from.swing_height * length,
        release_x2: from.release_x2.map(|release| release * length),
        energy_gain: from.energy_gain / time,
        sagittal_energy_gain: from.sagittal_energy_gain / time,
        com_feedback: from.com_feedback / time,
        com_gain: from.com_gain / time,
        swing_gain: from.swing_gain / time,
        rate_limit: from.rate_limit.map(|rate| rate / time),
        torque_bound: from.torque_bound.map(|torque| torque * scale.torque()),
        switch_rate: from.switch_rate / time,
        observer_bandwidth: from.observer_bandwidth / time,
        rate_filter_hz: from.rate_filter_hz / time,
        ..from.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::parse;
    use crate::robot::{DriveParameters, table_1};

    fn walk() -> Scene {
        let text = "duration = 14.0\n[initial]\njoints = [0.0, 0.4943, -1.5177, 1.0234, -1.0234, 1.5177, -0.4943, \
                    0.0]\n[controller]\nspeed = 0.2\n";
        parse(text, "walk").expect("good TOML")
    }

    fn paper() -> Robot {
        Robot { name: "paper".into(), drives: DriveParameters::default(), bodies: table_1() }
    }

    #[test]
    fn the_same_robot_changes_nothing_but_the_name() {
        let same = with_robot(&walk(), &paper()).expect("Table 1");
        assert_eq!(same, Scene { robot: Some("paper".into()), ..walk() });
        assert_eq!(same.robot_name(), "paper");
    }

    #[test]
    fn scaling_to_another_robot_and_back_gives_the_same_scene() {
        let mut robot = paper();
        for body in &mut robot.bodies {
            body.mass *= 2.0;
            body.com[2] *= 1.25;
            body.joint.iter_mut().for_each(|joint| joint.at[2] *= 1.25);
            body.contacts.iter_mut().for_each(|point| point[2] *= 1.25);
        }
        let there = with_robot(&walk(), &robot).expect("a biped");
        let time = there.controller.as_ref().expect("a controller").period / 0.6;
        assert!((time - 1.25f64.sqrt()).abs() < 1e-12, "{time}");
        assert!((there.plant.torque_limit - 100.0).abs() < 1e-9 && (there.plant.drive_inertia - 0.3125).abs() < 1e-9);
        let back = with_robot(&there, &paper()).expect("Table 1").controller.expect("a controller");
        let controller = walk().controller.expect("a controller");
        assert!((back.period - controller.period).abs() + (back.com_gain - controller.com_gain).abs() < 1e-12);
    }

    #[test]
    fn values_of_a_file_are_kept_and_missing_ones_are_scaled_to_its_robot() {
        let folder = std::env::temp_dir().join(format!("biped-robot-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let robot = Robot { drives: DriveParameters { inertia: Some(0.5), ..DriveParameters::default() }, ..paper() };
        let text = toml::to_string(&robot).expect("TOML").replace("mass = ", "mass = 1");
        std::fs::write(folder.join("heavy.toml"), text).expect("a file");
        let scene = "robot = \"heavy.toml\"\n[plant]\nfriction = 0.4\n[controller]\nspeed = 0.3\n";
        let file = folder.join("scene.toml").display().to_string();
        std::fs::write(&file, scene).expect("a file");
        let scene = crate::load::load(&file, &[], &[]).expect("a good scene");
        assert_eq!((scene.robot_name(), scene.bodies[4].mass), ("paper", 13.0));
        assert_eq!((scene.plant.friction, scene.plant.drive_inertia), (0.4, 0.5));
        assert!(scene.plant.torque_limit > 100.0 && scene.initial.joints.len() == 8);
        assert_eq!(scene.controller.as_ref().map(|controller| controller.speed), Some(0.3));
        let again = parse(&crate::load::text(&scene), "written").expect("good TOML");
        assert_eq!(again, scene);
        std::fs::remove_dir_all(folder).expect("our own folder");
    }
}
