//! Loading a scene: from a file or a built-in name, with `--set` overrides, to a scene whose values have all been checked.
//!
//! A bad scene is refused with one sentence. It names the file, the key, the value, and the values that are allowed.

mod bodies;
mod built_in;
mod check;
mod error;
mod ground;
mod listed;
mod magnitude;
mod robot;
mod robot_file;
mod setting;
mod suggestion;
mod units;
mod urdf;

pub use built_in::{BuiltIn, SCENES};
pub use check::validate;
pub use error::SceneError;
pub use robot::{read, with_robot};
pub use suggestion::suggest;

use crate::log;
use crate::scene::{Base, Scene};
use std::sync::Once;

/// Loads a built-in scene, or the file at a path. Then applies the overrides `key=value` in order and checks the result.
///
/// Keys are dotted: `plant.dt`, `bodies.trunk.mass`, `initial.joints.1`. A value is TOML, or otherwise a bare string. The key `robot`
/// replaces the robot of the scene by that of a file and scales the scene: see [`with_robot`].
///
/// # Errors
/// See [`SceneError`].
pub fn load(name: &str, settings: &[String], built_in: &[BuiltIn]) -> Result<Scene, SceneError> {
    let (mut origin, text) = match built_in.iter().find(|(known, _)| *known == name) {
        Some((_, text)) => (format!("scene {name}"), text.to_string()),
        None => (name.to_string(), text_of(name, built_in)?),
    };
    if text.trim().is_empty() {
        let reason = std::io::Error::other("the file is empty; `biped new scene NAME` writes a scene to edit");
        return Err(SceneError::Unreadable { path: name.into(), reason });
    }
    let parsed = parse(&text, &origin).map_err(|error| {
        let is_robot = text.trim_start().starts_with('<') || robot::of_text(&text, name.as_ref(), &origin).is_ok();
        let reason = format!("this is a robot, not a scene: give it to a scene by --robot {name}");
        if is_robot { SceneError::Robot { origin: name.into(), reason } } else { error }
    })?;
    let (mut scene, mut file) = robot::resolved(parsed, &text, &origin)?;
    for setting in settings {
        let refused = |reason| SceneError::Override { setting: setting.clone(), reason };
        scene = match setting::robot(setting) {
            Some(path) => {
                let read = robot::file(path.as_ref())?;
                let scene = with_robot(&scene, &read.robot).map_err(refused)?;
                file = Some(read);
                scene
            }
            None => setting::apply(&scene, setting).map_err(refused)?,
        };
        origin += &format!(" --set {setting}");
    }
    validate(&scene, &origin)?;
    if let Some(file) = file {
        let mount = file.mount.filter(|_| scene.plant.base != Base::Fixed);
        NOTED.call_once(|| mount.into_iter().chain(file.notes).for_each(log));
    }
    Ok(scene)
}

/// A process may load its robot for every run of a sweep, and says only once what it ignores.
static NOTED: Once = Once::new();

/// Loads a built-in scene by its name.
///
/// ```
/// let scene = biped_messages::load::built_in("walk")?;
/// assert_eq!(scene.bodies.len(), 9);
/// # Ok::<(), biped_messages::load::SceneError>(())
/// ```
///
/// # Errors
/// [`SceneError::Unknown`] with the names that exist.
pub fn built_in(name: &str) -> Result<Scene, SceneError> {
    match SCENES.iter().any(|(known, _)| *known == name) {
        true => load(name, &[], SCENES),
        false => Err(SceneError::unknown(name, SCENES)),
    }
}

fn text_of(path: &str, built_in: &[BuiltIn]) -> Result<String, SceneError> {
    crate::file::text(path.as_ref()).map_err(|reason| match reason.kind() {
        std::io::ErrorKind::NotFound => SceneError::unknown(path, built_in),
        _ => SceneError::Unreadable { path: path.into(), reason },
    })
}

/// Parses a scene from TOML text without checking its values. Errors name the text by `origin`.
///
/// If a scene has bodies of its own, no controller and no `drive_inertia`, its drive inertia is 0.
///
/// # Errors
/// [`SceneError::Malformed`] with line, caret and the valid names.
pub fn parse(text: &str, origin: &str) -> Result<Scene, SceneError> {
    let malformed = |reason| SceneError::Malformed { origin: origin.into(), reason: Box::new(reason) };
    let mut scene: Scene = toml::from_str(text).map_err(malformed)?;
    let given: toml::Table = text.parse().map_err(malformed)?;
    let has_drive_inertia = given.get("plant").is_some_and(|plant| plant.get("drive_inertia").is_some());
    if given.contains_key("bodies") && scene.controller.is_none() && !has_drive_inertia {
        scene.plant.drive_inertia = 0.0;
    }
    Ok(scene)
}

/// The scene as TOML, with every default written out. Loading that text gives the same scene.
pub fn text(scene: &Scene) -> String {
    toml::to_string(scene).unwrap_or_else(|error| format!("# this scene cannot be written as TOML: {error}\n"))
}

/// JSON schema of scenes. Its descriptions are the comments of the fields.
pub fn schema() -> schemars::Schema {
    schemars::schema_for!(Scene)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ControllerScene;
    use crate::wire::CONTACTS;

    const WALK: BuiltIn = ("walk", "duration = 2.0\n[controller]\nspeed = 0.2\n");

    fn with(settings: &[&str]) -> Result<Scene, SceneError> {
        load("walk", &settings.iter().map(|setting| setting.to_string()).collect::<Vec<_>>(), &[WALK])
    }

    fn refused(settings: &[&str], words: &[&str]) {
        let error = with(settings).expect_err(&format!("{settings:?} should be refused")).to_string();
        for word in words {
            assert!(error.contains(word), "{settings:?} gave {error:?}, which does not say {word:?}");
        }
    }

    #[test]
    fn an_override_changes_its_value_and_nothing_else() {
        let mut expected = with(&[]).expect("the plain scene");
        expected.plant.law = crate::scene::Law::EnergyQp;
        expected.duration = 110.0;
        expected.initial.joints = vec![0.1; 8];
        expected.initial.clearance = Some(0.0);
        expected.bodies[4].mass = 5.0;
        if let Some(controller) = &mut expected.controller {
            controller.rate_limit = Some(12.0);
            controller.speed = 0.1;
        }
        let changed = with(&[
            "plant.law=EnergyQp",
            "duration=110",
            "initial.joints=[.1, .1, .1, .1, .1, .1, .1, .1]".replace("=[.", "=[0.").replace(" .", " 0.").as_str(),
            "initial.clearance=0",
            "bodies.trunk.mass=5",
            "controller.rate_limit=12.0",
            "controller.speed=0.1",
        ]);
        assert_eq!(changed.expect("good overrides"), expected);
    }

    #[test]
    fn an_override_adds_a_controller_to_a_scene_without_one() {
        let settings = ["controller.speed=0.1".to_string()];
        let scene = load("bare", &settings, &[("bare", "duration = 1.0")]).expect("a scene with a controller");
        assert_eq!(scene.controller, Some(ControllerScene { speed: 0.1, ..ControllerScene::default() }));
    }

    #[test]
    fn a_perfect_link_is_not_written_and_another_one_survives_writing() {
        assert!(!text(&with(&[]).expect("the plain scene")).contains("[link]"));
        let late = with(&["link.delay_ms=2", "link.jitter=burst", "link.seed=7"]).expect("a late link");
        assert_eq!((late.link.delay_ms, late.link.jitter), (2.0, crate::scene::Jitter::Burst));
        assert_eq!(parse(&text(&late), "written").expect("good TOML"), late);
    }

    #[test]
    fn an_unknown_key_is_shown_with_line_caret_and_the_valid_names() {
        let error = parse("duration = 1.0\n[plant]\nfricton = 0.5\n", "my.toml").expect_err("a typo").to_string();
        for word in ["my.toml", "line 3", "^", "fricton", "friction", "drive_inertia"] {
            assert!(error.contains(word), "{error} does not say {word}");
        }
    }

    #[test]
    fn an_unknown_override_names_the_key_and_the_valid_ones() {
        refused(&["plant.fricton=0.5"], &["--set plant.fricton=0.5", "`fricton`", "`friction`"]);
        refused(&["controler.speed=1"], &["`controler`", "`controller`"]);
        refused(&["bodies.head.mass=1"], &["no `head` in `bodies`", "left shank", "trunk"]);
        refused(&["friction=1"], &["unknown field `friction`", "did you mean `plant.friction`?"]);
        refused(&["speed=1"], &["did you mean `controller.speed`?"]);
        refused(&["plant.method=Verlet"], &["Verlet", "`SemiImplicitEuler`", "`EventDriven`"]);
        refused(&["plant.law=Coulomb"], &["Coulomb", "`Aligned`"]);
        refused(&["plant.dt=fast"], &["plant.dt=fast", "fast", "a number"]);
        refused(&["plant.dt.x=1"], &["`x` cannot follow `plant.dt`"]);
        refused(&["plant.dt"], &["key=value"]);
    }

    #[test]
    fn every_bad_value_is_refused_by_its_key() {
        refused(&["plant.friction=nan"], &["scene walk", "plant.friction", "finite"]);
        refused(&["bodies.trunk.com=[0.0, inf, 0.0]"], &["bodies.4.com.1", "inf", "finite"]);
        refused(&["initial.position=[1e308, 0.0, 0.0]"], &["initial.position.0", "1e308", "beyond 1e30"]);
        refused(&["plant.dt=0"], &["plant.dt = 0", "greater than 0"]);
        refused(&["plant.dt=0.0003"], &["plant.dt", "whole number of steps", "0.0003333"]);
        refused(&["plant.dt=0.002"], &["plant.dt", "whole number of steps"]);
        refused(&["duration=-1"], &["duration", "greater than 0"]);
        refused(&["duration=0.0001"], &["duration", "at least one control period"]);
        refused(&["rate=0"], &["rate", "greater than 0"]);
        refused(&["bodies.trunk.mass=-3"], &["bodies.trunk.mass = -3", "greater than 0"]);
        refused(&["plant.friction=-0.1"], &["plant.friction", "negative"]);
        refused(&["plant.ground.tiles=[{height = nan}]"], &["plant.ground.tiles.0.height", "finite"]);
        refused(&["plant.ground.tiles=[{x = [1.0, 0.5], height = 0.1}]"], &["plant.ground.tiles.0.x", "less than"]);
        refused(
            &["plant.ground.tiles=[{x = [0.0, 1.0], height = 0.1}, {y = [0.0, 1.0], height = 0.2}]"],
            &["plant.ground.tiles.1", "must not overlap plant.ground.tiles.0"],
        );
        refused(&["plant.ground.tiles=[{x = [0.0, 1.0]}]"], &["`height`"]);
        refused(&["plant.ground.random.size=[0.2, 0.0]"], &["plant.ground.random.size", "at least 1e-9 m"]);
        refused(&["plant.ground.random.height=-0.01"], &["plant.ground.random.height", "negative"]);
        refused(&["plant.ground.steps=1"], &["`steps`", "`tiles`"]);
        refused(&["plant.restitution=1.1"], &["plant.restitution", "between 0 and 1"]);
        refused(&["bodies.left foot.joint.stiffness=-1"], &["bodies.left foot.joint.stiffness", "negative"]);
        refused(&["bodies.left foot.joint.damping=-1"], &["bodies.left foot.joint.damping", "negative"]);
        refused(&["bodies.trunk.spheres=[{at = [0.0, 0.0, 0.0], radius = 0.0}]"], &["bodies.trunk.spheres.radius"]);
        refused(&["bodies.trunk.tiles={first = 0.0, pitch = 1.0, length = 2.0}"], &["bodies.trunk.tiles.length"]);
        refused(&["plant.stale_probability=1.5"], &["between 0 and 1"]);
        refused(&["link.delay_ms=-1"], &["link.delay_ms = -1", "between 0 and 1000"]);
        refused(&["link.jitter_ms=1001"], &["link.jitter_ms", "between 0 and 1000"]);
        refused(&["link.loss=1.5"], &["link.loss = 1.5", "between 0 and 1"]);
        refused(&["link.duplicate=-0.1"], &["link.duplicate", "between 0 and 1"]);
        refused(&["link.reorder=nan"], &["link.reorder", "finite"]);
        refused(&["link.jitter=gamma"], &["gamma", "`uniform`", "`burst`"]);
        refused(&["plant.encoder_bits=7"], &["plant.encoder_bits", "8 to 30"]);
        refused(&["plant.payload_body=head"], &["plant.payload_body", "trunk"]);
        refused(&["initial.joints=[0.0, 1.0]"], &["initial.joints", "8 joints"]);
        refused(&["initial.clearance=-0.1"], &["initial.clearance", "negative"]);
        refused(&["bodies.trunk.size=[0.1, 0.0, 0.1]"], &["bodies.trunk.size"]);
        refused(&["bodies.left foot.joint.parent=tail"], &["bodies.left foot.joint.parent", "left ankle"]);
        refused(&["bodies.left foot.joint.axis=[1, 1, 0]"], &["unit vector"]);
        refused(&["bodies.left thigh.joint.parent=left foot"], &["circle"]);
        refused(&["bodies.left foot.name=trunk"], &["names must differ"]);
        refused(&["bodies.left foot.name=\"\\u001b[2J\""], &["bodies.0.name", "control characters"]);
        refused(&["plant.push_body=\"\\u001b[2J\""], &["plant.push_body", "\\u{1b}[2J"]);
        refused(&["controller.period=0"], &["controller.period", "greater than 0"]);
        refused(&["controller.period=0.01"], &["controller.period", "control periods"]);
        refused(&["controller.com_height=-0.27"], &["controller.com_height"]);
        refused(&["controller.torque_bound=0"], &["controller.torque_bound"]);
        let both = ["controller.torque_bound=20", "controller.nominal_inertia=matrix"];
        refused(&both, &["controller.nominal_inertia", "diagonal"]);
        let one = "[[bodies]]\nname = \"a\"\nmass = 1.0\nsize = [1.0, 1.0, 1.0]\n";
        let point = format!("{one}contacts = [{}]", "[0.0, 0.0, 0.0],".repeat(CONTACTS + 1));
        let two_bases = one.to_string() + &one.replace("\"a\"", "\"b\"");
        for (text, words) in [(point, "contact points"), (two_bases, "exactly one"), ("bodies = []".into(), "one body")]
        {
            let error = validate(&parse(&text, "here").expect("good syntax"), "here").expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        }
    }

    #[test]
    fn a_missing_scene_lists_the_known_ones() {
        let error = load("wlak", &[], &[WALK]).expect_err("no such scene").to_string();
        assert!(error.contains("wlak") && error.contains("walk"), "{error}");
    }
}
