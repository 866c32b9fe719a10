//! From text to a scene that can be trusted: file or built-in name, `--set` overrides, then every value checked.
//!
//! A bad scene is refused with one sentence that names where, which key, what it is and what would be right.

use crate::robot::Body;
use crate::scene::{ControllerScene, LinkScene, Scene};
use crate::wire::{CONTACTS, JOINTS};
use serde::Deserialize;
use std::collections::BTreeSet;
use thiserror::Error;
use toml::{Table, Value};

/// A scene that comes with the program: its name and its TOML text.
pub type BuiltIn = (&'static str, &'static str);

/// Why a scene was refused.
#[derive(Debug, Error)]
pub enum SceneError {
    /// Neither a built-in name nor a file.
    #[error("there is no scene or file `{name}`; the built-in scenes are {known}")]
    Unknown {
        /// As it was asked for.
        name: String,
        /// The built-in names.
        known: String,
    },
    /// The file exists but cannot be read.
    #[error("{path} cannot be read: {reason}")]
    Unreadable {
        /// The file.
        path: String,
        /// The system's words.
        reason: std::io::Error,
    },
    /// Not TOML, an unknown key, or a value of the wrong type; the reason shows line and caret.
    #[error("{origin}: {reason}")]
    Malformed {
        /// File or built-in scene.
        origin: String,
        /// Line, caret and the valid names.
        reason: Box<toml::de::Error>,
    },
    /// An override that the scene cannot take.
    #[error("--set {setting}: {reason}")]
    Override {
        /// The override as given.
        setting: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A value out of range.
    #[error("{origin}: {key} = {value}, but {rule}")]
    Invalid {
        /// File or built-in scene, with its overrides.
        origin: String,
        /// Dotted key.
        key: String,
        /// Value found.
        value: String,
        /// What would be right.
        rule: String,
    },
}

/// Loads a built-in scene, or a file by its path, applies overrides `key=value` in order and checks the result.
///
/// Keys are dotted (`plant.dt`, `bodies.trunk.mass`, `initial.joints.1`); a value is TOML, or else a bare string.
///
/// # Errors
/// One sentence on whatever is wrong: see [`SceneError`].
pub fn load(name: &str, settings: &[String], built_in: &[BuiltIn]) -> Result<Scene, SceneError> {
    let (mut origin, text) = match built_in.iter().find(|(known, _)| *known == name) {
        Some((_, text)) => (format!("scene {name}"), text.to_string()),
        None => (name.to_string(), read(name, built_in)?),
    };
    let mut scene = parse(&text, &origin)?;
    for setting in settings {
        scene =
            overridden(&scene, setting).map_err(|reason| SceneError::Override { setting: setting.clone(), reason })?;
        origin += &format!(" --set {setting}");
    }
    validate(&scene, &origin)?;
    Ok(scene)
}

fn read(path: &str, built_in: &[BuiltIn]) -> Result<String, SceneError> {
    std::fs::read_to_string(path).map_err(|reason| match reason.kind() {
        std::io::ErrorKind::NotFound => {
            let known = built_in.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
            SceneError::Unknown { name: path.into(), known }
        }
        _ => SceneError::Unreadable { path: path.into(), reason },
    })
}

/// Reads a scene from TOML text, unchecked; `origin` names the text in errors.
///
/// # Errors
/// [`SceneError::Malformed`] with line, caret and the valid names.
pub fn parse(text: &str, origin: &str) -> Result<Scene, SceneError> {
    toml::from_str(text).map_err(|reason| SceneError::Malformed { origin: origin.into(), reason: Box::new(reason) })
}

/// The scene with one value replaced, found by walking the scene as a table: so every key exists that serde knows.
fn overridden(scene: &Scene, setting: &str) -> Result<Scene, String> {
    let (key, text) = setting.split_once('=').ok_or("an override is key=value, for example plant.dt=0.001")?;
    let (key, text) = (key.trim(), text.trim());
    let value = format!("value = {text}").parse::<Table>().ok().and_then(|mut table| table.remove("value"));
    let value = value.unwrap_or_else(|| Value::String(text.into()));
    let mut root = Value::try_from(scene).map_err(|error| error.to_string())?;
    *slot(&mut root, key)? = value;
    Scene::deserialize(root).map_err(|error| error.to_string().trim().replace('\n', " "))
}

/// The place that a dotted key names; missing tables and keys are made, serde judges their names afterwards.
fn slot<'a>(root: &'a mut Value, key: &str) -> Result<&'a mut Value, String> {
    let mut place = root;
    for part in key.split('.') {
        place = match place {
            Value::Table(table) => table.entry(part).or_insert_with(|| Value::Table(Table::new())),
            Value::Array(items) => {
                let named = |item: &Value| item.get("name").and_then(Value::as_str) == Some(part);
                let index = items.iter().position(named).or_else(|| part.parse().ok());
                let known: Vec<_> = items.iter().filter_map(|item| item.get("name")?.as_str()).collect();
                let hint = if known.is_empty() { String::new() } else { format!(" or one of {}", known.join(", ")) };
                let last = items.len().saturating_sub(1);
                index
                    .and_then(|index| items.get_mut(index))
                    .ok_or_else(|| format!("there is no `{part}` in that list: an index 0..={last}{hint} is needed"))?
            }
            _ => return Err(format!("`{part}` cannot follow a plain value")),
        };
    }
    Ok(place)
}

/// Checks every value of a scene; `origin` names it in the error.
///
/// # Errors
/// [`SceneError::Invalid`] for the first value that cannot be simulated or controlled.
pub fn validate(scene: &Scene, origin: &str) -> Result<(), SceneError> {
    let check = Check { origin };
    let table = Value::try_from(scene).map_err(|error| check.fail("scene", error, "it cannot be written as TOML"))?;
    check.finite(&table, "")?;
    check.timing(scene)?;
    check.plant(scene)?;
    check.link(&scene.link)?;
    check.bodies(&scene.bodies)?;
    check.initial(scene)?;
    scene.controller.as_ref().map_or(Ok(()), |controller| check.controller(scene, controller))
}

/// The scene as TOML, complete with every default: another run of it, file for file.
pub fn text(scene: &Scene) -> String {
    toml::to_string(scene).unwrap_or_else(|error| format!("# this scene cannot be written as TOML: {error}\n"))
}

/// The JSON schema of scenes, made of the fields' own comments.
pub fn schema() -> schemars::Schema {
    schemars::schema_for!(Scene)
}

/// Rules, each with the words for breaking it.
struct Check<'a> {
    origin: &'a str,
}

type Checked = Result<(), SceneError>;

impl Check<'_> {
    fn fail(&self, key: &str, value: impl ToString, rule: impl Into<String>) -> SceneError {
        SceneError::Invalid { origin: self.origin.into(), key: key.into(), value: value.to_string(), rule: rule.into() }
    }

    fn require(&self, holds: bool, key: &str, value: impl ToString, rule: impl Into<String>) -> Checked {
        if holds { Ok(()) } else { Err(self.fail(key, value, rule)) }
    }

    fn positive(&self, key: &str, value: f64) -> Checked {
        self.require(value > 0.0, key, value, "it must be greater than 0")
    }

    fn not_negative(&self, key: &str, value: f64) -> Checked {
        self.require(value >= 0.0, key, value, "it must not be negative")
    }

    /// Every number is finite; the path to the one that is not is spelt out.
    fn finite(&self, value: &Value, path: &str) -> Checked {
        let below = |part: &str| if path.is_empty() { part.to_string() } else { format!("{path}.{part}") };
        match value {
            Value::Float(number) => {
                self.require(number.is_finite(), path, number, "every number of a scene must be finite")
            }
            Value::Table(table) => table.iter().try_for_each(|(key, value)| self.finite(value, &below(key))),
            Value::Array(items) => {
                items.iter().enumerate().try_for_each(|(i, item)| self.finite(item, &below(&i.to_string())))
            }
            _ => Ok(()),
        }
    }

    fn timing(&self, scene: &Scene) -> Checked {
        self.positive("duration", scene.duration)?;
        self.positive("rate", scene.rate)?;
        self.positive("plant.dt", scene.plant.dt)?;
        let steps = 1.0 / (scene.rate * scene.plant.dt);
        let whole = steps.round() >= 1.0 && (steps - steps.round()).abs() < 1e-9 * steps;
        let rule = format!(
            "a whole number of steps must fit into one control period of 1/{} s, not {steps}: try {}",
            scene.rate,
            1.0 / (scene.rate * steps.round().max(1.0)),
        );
        self.require(whole, "plant.dt", scene.plant.dt, rule)?;
        let periods = scene.duration * scene.rate;
        let rule = format!("it must be at least one control period of 1/{} s", scene.rate);
        self.require(periods.round() >= 1.0, "duration", scene.duration, rule)
    }

    fn plant(&self, scene: &Scene) -> Checked {
        let plant = &scene.plant;
        self.positive("plant.tolerance", plant.tolerance)?;
        self.positive("plant.tolerance_step", plant.tolerance_step)?;
        self.not_negative("plant.gravity", plant.gravity)?;
        let tilt = plant.incline_deg;
        self.require(tilt.abs() < 90.0, "plant.incline_deg", tilt, "it must lie between -90 and 90")?;
        self.not_negative("plant.friction", plant.friction)?;
        let bounce = plant.restitution;
        self.require((0.0..=1.0).contains(&bounce), "plant.restitution", bounce, "it must lie between 0 and 1")?;
        self.positive("plant.contact_stiffness", plant.contact_stiffness)?;
        self.not_negative("plant.contact_damping_ratio", plant.contact_damping_ratio)?;
        self.not_negative("plant.drive_inertia", plant.drive_inertia)?;
        self.not_negative("plant.joint_damping", plant.joint_damping)?;
        self.not_negative("plant.torque_limit", plant.torque_limit)?;
        let bits = plant.encoder_bits;
        self.require((8..=30).contains(&bits), "plant.encoder_bits", bits, "it must be 8 to 30")?;
        let ticks = plant.latency_ticks;
        self.require(ticks <= 1000, "plant.latency_ticks", ticks, "it must be at most 1000")?;
        let stale = plant.stale_probability;
        let rule = "a probability must lie between 0 and 1";
        self.require((0.0..=1.0).contains(&stale), "plant.stale_probability", stale, rule)?;
        self.not_negative("plant.payload_kg", plant.payload_kg)?;
        self.not_negative("plant.push_time", plant.push_time)?;
        self.positive("plant.push_duration", plant.push_duration)?;
        for (key, name) in [("plant.payload_body", &plant.payload_body), ("plant.push_body", &plant.push_body)] {
            self.known_body(&scene.bodies, key, name)?;
        }
        Ok(())
    }

    fn link(&self, link: &LinkScene) -> Checked {
        for (key, delay) in [("link.delay_ms", link.delay_ms), ("link.jitter_ms", link.jitter_ms)] {
            self.require((0.0..=1000.0).contains(&delay), key, delay, "it must lie between 0 and 1000 ms")?;
        }
        for (key, share) in
            [("link.loss", link.loss), ("link.duplicate", link.duplicate), ("link.reorder", link.reorder)]
        {
            self.require((0.0..=1.0).contains(&share), key, share, "a probability must lie between 0 and 1")?;
        }
        Ok(())
    }

    fn known_body(&self, bodies: &[Body], key: &str, name: &str) -> Checked {
        let names: Vec<_> = bodies.iter().map(|body| body.name.as_str()).collect();
        let rule = format!("it must be empty or one of {}", names.join(", "));
        self.require(name.is_empty() || names.contains(&name), key, format!("\"{name}\""), rule)
    }

    fn bodies(&self, bodies: &[Body]) -> Checked {
        self.require(!bodies.is_empty(), "bodies", "[]", "a scene needs at least one body")?;
        let names: BTreeSet<_> = bodies.iter().map(|body| body.name.as_str()).collect();
        for (i, body) in bodies.iter().enumerate() {
            let key = |field: &str| format!("bodies.{}.{field}", body.name);
            self.require(!body.name.is_empty(), &format!("bodies.{i}.name"), "\"\"", "every body needs a name")?;
            let twice = bodies[..i].iter().any(|other| other.name == body.name);
            self.require(!twice, &format!("bodies.{i}.name"), format!("\"{}\"", body.name), "names must differ")?;
            self.positive(&key("mass"), body.mass)?;
            body.size.iter().try_for_each(|&side| self.positive(&key("size"), side))?;
            body.moments().iter().try_for_each(|&moment| self.positive(&key("inertia"), moment))?;
            if let Some(joint) = &body.joint {
                let rule = format!("it must be another body: {}", names.iter().copied().collect::<Vec<_>>().join(", "));
                let known = names.contains(joint.parent.as_str()) && joint.parent != body.name;
                self.require(known, &key("joint.parent"), format!("\"{}\"", joint.parent), rule)?;
                let length = joint.axis.iter().map(|c| c * c).sum::<f64>().sqrt();
                let rule = "an axis must be a unit vector";
                self.require((length - 1.0).abs() < 1e-9, &key("joint.axis"), format!("{:?}", joint.axis), rule)?;
                self.not_negative(&key("joint.stiffness"), joint.stiffness)?;
                self.not_negative(&key("joint.damping"), joint.damping)?;
            }
            body.spheres.iter().try_for_each(|ball| self.positive(&key("spheres.radius"), ball.radius))?;
            if let Some(tiles) = body.tiles {
                self.positive(&key("tiles.pitch"), tiles.pitch)?;
                let rule = "tiles must be longer than 0 and no longer than their pitch";
                let fits = tiles.length > 0.0 && tiles.length <= tiles.pitch;
                self.require(fits, &key("tiles.length"), tiles.length, rule)?;
            }
        }
        self.tree(bodies)?;
        let joints = bodies.iter().filter(|body| body.joint.is_some()).count();
        let rule = format!("the messages carry at most {JOINTS} of them");
        self.require(joints <= JOINTS, "number of joints", joints, rule)?;
        let contacts = bodies.iter().map(|body| body.touchable().count()).sum::<usize>();
        let rule = format!("the messages carry at most {CONTACTS} of them");
        self.require(contacts <= CONTACTS, "number of contact points and balls", contacts, rule)
    }

    /// One base, and every body hangs from it.
    fn tree(&self, bodies: &[Body]) -> Checked {
        let bases: Vec<_> = bodies.iter().filter(|body| body.joint.is_none()).map(|body| &*body.name).collect();
        let rule = "exactly one body, the base, must be without a joint";
        self.require(bases.len() == 1, "bodies without a joint", format!("[{}]", bases.join(", ")), rule)?;
        for body in bodies {
            let mut link = body;
            for _ in 0..bodies.len() {
                let parent = link.joint.as_ref().and_then(|joint| bodies.iter().find(|b| b.name == joint.parent));
                link = parent.unwrap_or(link);
            }
            let rule = "its parents must lead to the base, not in a circle";
            self.require(link.joint.is_none(), &format!("bodies.{}.joint.parent", body.name), &link.name, rule)?;
        }
        Ok(())
    }

    fn initial(&self, scene: &Scene) -> Checked {
        let joints = scene.bodies.iter().filter(|body| body.joint.is_some()).count();
        let lists = [("initial.joints", &scene.initial.joints), ("initial.joint_rates", &scene.initial.joint_rates)];
        for (key, list) in lists {
            let rule = format!("it must be empty or have one value for each of the {joints} joints");
            self.require(list.is_empty() || list.len() == joints, key, format!("{list:?}"), rule)?;
        }
        let contacts = scene.bodies.iter().any(|body| body.touchable().next().is_some());
        let clearance = scene.initial.clearance;
        let rule = "it needs a body with contact points or balls";
        self.require(clearance.is_none() || contacts, "initial.clearance", clearance.unwrap_or(0.0), rule)?;
        self.not_negative("initial.clearance", clearance.unwrap_or(0.0))
    }

    fn controller(&self, scene: &Scene, controller: &ControllerScene) -> Checked {
        let joints = scene.bodies.iter().filter(|body| body.joint.is_some()).count();
        let rule = format!("the walking controller drives the robot of Table 1 with its {JOINTS} joints");
        self.require(joints == JOINTS, "number of joints", joints, rule)?;
        for (key, value) in [
            ("controller.period", controller.period),
            ("controller.com_height", controller.com_height),
            ("controller.com_gain", controller.com_gain),
            ("controller.swing_gain", controller.swing_gain),
            ("controller.switch_rate", controller.switch_rate),
            ("controller.rate_filter_hz", controller.rate_filter_hz),
            ("controller.release_x2", controller.release_x2.unwrap_or(1.0)),
            ("controller.rate_limit", controller.rate_limit.unwrap_or(1.0)),
            ("controller.torque_bound", controller.torque_bound.unwrap_or(1.0)),
        ] {
            self.positive(key, value)?;
        }
        for (key, value) in [
            ("controller.stop_time", controller.stop_time.unwrap_or(0.0)),
            ("controller.swing_height", controller.swing_height),
            ("controller.energy_gain", controller.energy_gain),
            ("controller.foot_placement_gain", controller.foot_placement_gain),
            ("controller.sagittal_energy_gain", controller.sagittal_energy_gain),
            ("controller.com_feedback", controller.com_feedback),
            ("controller.observer_bandwidth", controller.observer_bandwidth),
        ] {
            self.not_negative(key, value)?;
        }
        let half = controller.period / 2.0;
        let rule = format!("half of it, one step, must last at least ten control periods of 1/{} s", scene.rate);
        self.require(half * scene.rate >= 10.0, "controller.period", controller.period, rule)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn an_override_creates_the_controller_that_a_scene_lacks() {
        let settings = ["controller.speed=0.1".to_string()];
        let scene = load("bare", &settings, &[("bare", "")]).expect("a scene with a controller");
        assert_eq!(scene.controller, Some(ControllerScene { speed: 0.1, ..ControllerScene::default() }));
    }

    #[test]
    fn a_perfect_link_is_not_written_and_any_other_is_read_back() {
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
        refused(&["bodies.head.mass=1"], &["`head`", "left shank", "trunk"]);
        refused(&["plant.method=Verlet"], &["Verlet", "`SemiImplicitEuler`", "`EventDriven`"]);
        refused(&["plant.law=Coulomb"], &["Coulomb", "`Aligned`"]);
        refused(&["plant.dt=fast"], &["plant.dt=fast", "fast", "f64"]);
        refused(&["plant.dt.x=1"], &["`x`"]);
        refused(&["plant.dt"], &["key=value"]);
    }

    #[test]
    fn every_bad_value_is_refused_by_its_key() {
        refused(&["plant.friction=nan"], &["scene walk", "plant.friction", "finite"]);
        refused(&["bodies.trunk.com=[0.0, inf, 0.0]"], &["bodies.4.com.1", "inf", "finite"]);
        refused(&["plant.dt=0"], &["plant.dt = 0", "greater than 0"]);
        refused(&["plant.dt=0.0003"], &["plant.dt", "whole number of steps", "0.0003333"]);
        refused(&["plant.dt=0.002"], &["plant.dt", "whole number of steps"]);
        refused(&["duration=-1"], &["duration", "greater than 0"]);
        refused(&["duration=0.0001"], &["duration", "at least one control period"]);
        refused(&["rate=0"], &["rate", "greater than 0"]);
        refused(&["bodies.trunk.mass=-3"], &["bodies.trunk.mass = -3", "greater than 0"]);
        refused(&["plant.friction=-0.1"], &["plant.friction", "negative"]);
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
        refused(&["controller.period=0"], &["controller.period", "greater than 0"]);
        refused(&["controller.period=0.01"], &["controller.period", "control periods"]);
        refused(&["controller.com_height=-0.27"], &["controller.com_height"]);
        refused(&["controller.torque_bound=0"], &["controller.torque_bound"]);
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
