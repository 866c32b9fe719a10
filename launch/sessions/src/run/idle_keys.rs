//! Keys that a user names although they have no effect in his scene: one sentence each.

use messages::load::{SCENES, text};
use messages::scene::{ControllerScene, Gait, Jitter, Law, Sagittal, Scene};
use shared::args::SceneArgs;
use std::path::Path;
use toml::{Table, Value};

/// Keys that have no effect in some scenes.
struct IdleKeys {
    keys: &'static [&'static str],
    /// Whether they have no effect in this scene.
    are_idle: fn(&Scene) -> bool,
    /// Why not.
    reason: &'static str,
}

const RULES: [IdleKeys; 8] = [
    IdleKeys {
        keys: &["controller.speed", "controller.period", "controller.stop_time"],
        are_idle: |scene| scene.controller.as_ref().is_some_and(|controller| controller.gait == Gait::Stand),
        reason: "controller.gait = \"stand\" does not walk",
    },
    IdleKeys {
        keys: &["controller.sagittal_energy_gain"],
        are_idle: |scene| {
            scene.controller.as_ref().is_some_and(|controller| controller.sagittal == Sagittal::FootPlacement)
        },
        reason: "it belongs to controller.sagittal = \"energy\"",
    },
    IdleKeys {
        keys: &["plant.payload_offset", "plant.payload_body"],
        are_idle: |scene| scene.plant.payload_kg == 0.0,
        reason: "there is no payload, because plant.payload_kg = 0",
    },
    IdleKeys {
        keys: &["plant.push_time", "plant.push_duration", "plant.push_body"],
        are_idle: |scene| scene.plant.push_impulse == [0.0; 3],
        reason: "there is no push, because plant.push_impulse = 0",
    },
    IdleKeys {
        keys: &["plant.ground.random.seed", "plant.ground.random.size"],
        are_idle: |scene| scene.plant.ground.random.height == 0.0,
        reason: "there are no random tiles, because plant.ground.random.height = 0",
    },
    IdleKeys {
        keys: &["plant.contact_stiffness", "plant.contact_damping_ratio"],
        are_idle: |scene| scene.plant.law != Law::SpringDamper,
        reason: "it belongs to plant.law = \"SpringDamper\"",
    },
    IdleKeys {
        keys: &["plant.tolerance_step"],
        are_idle: |scene| !scene.plant.method.chooses_steps(),
        reason: "plant.method does not choose its steps; StepDoubling and EventDriven do",
    },
    IdleKeys {
        keys: &["link.jitter"],
        are_idle: |scene| scene.link.jitter != Jitter::default() && scene.link.jitter_ms == 0.0,
        reason: "there is no jitter, because link.jitter_ms = 0",
    },
];

/// Sentences on the keys without effect that `--set` or a scene of the user's own names. A file may write defaults out, as those do that the
/// program prints, so in a file only other values count. A scene for a given robot has values that are scaled to it, so its file does not.
pub fn named(args: &SceneArgs, scene: &Scene) -> Vec<String> {
    let tables = own_file(args, scene)
        .map(|file| (file, [scene, &usual(scene)].map(|scene| text(scene).parse::<Table>().unwrap_or_default())));
    let is_written = |key: &str| {
        tables.as_ref().is_some_and(|(file, [own, usual])| {
            value(file, key).is_some() && value(own, key).is_some_and(|own| value(usual, key) != Some(own))
        })
    };
    let is_set = |key: &str| args.settings.iter().any(|setting| setting.split('=').next().map(str::trim) == Some(key));
    let idle = RULES.iter().filter(|rule| (rule.are_idle)(scene));
    let keys = idle.flat_map(|rule| rule.keys.iter().map(|key| (*key, rule.reason)));
    let named = keys.filter(|(key, _)| is_set(key) || is_written(key));
    named.map(|(key, reason)| format!("{key} has no effect: {reason}")).collect()
}

/// The keys of the user's own scene. A pipe can be read only once, so its keys are not known any more.
fn own_file(args: &SceneArgs, scene: &Scene) -> Option<Table> {
    let (name, path) = (args.scene.as_str(), Path::new(&args.scene));
    let is_own = SCENES.iter().all(|(known, _)| *known != name) && scene.robot.is_none() && path.is_file();
    is_own.then(|| messages::file::text(path).ok()?.parse().ok()).flatten()
}

/// The defaults, with every table that the scene may have.
fn usual(scene: &Scene) -> Scene {
    let mut usual =
        Scene { controller: scene.controller.as_ref().map(|_| ControllerScene::default()), ..Scene::default() };
    usual.plant.ground.tiles = scene.plant.ground.tiles.clone();
    usual
}

/// The value of a dotted key.
fn value<'a>(table: &'a Table, key: &str) -> Option<&'a Value> {
    let (head, rest) = key.split_once('.').unwrap_or((key, ""));
    let found = table.get(head)?;
    if rest.is_empty() { Some(found) } else { value(found.as_table()?, rest) }
}
