//! `biped list`: the built-in scenes, and every key of a scene.

use crate::exit::Failure;
use crate::output::say;
use messages::load::{self, BuiltIn};
use serde_json::Value;

/// The scenes that come with the program.
pub const SCENES: &[BuiltIn] = &[
    ("walk", include_str!("../../scenes/walk.toml")),
    ("stamp", include_str!("../../scenes/stamp.toml")),
    ("walk-literal", include_str!("../../scenes/walk-literal.toml")),
    ("paper", include_str!("../../scenes/paper.toml")),
    ("stand", include_str!("../../scenes/stand.toml")),
    // compared with other engines
    ("free", include_str!("../../scenes/free.toml")),
    ("slide", include_str!("../../scenes/slide.toml")),
    ("slide30", include_str!("../../scenes/slide30.toml")),
    ("incline", include_str!("../../scenes/incline.toml")),
    ("stick", include_str!("../../scenes/stick.toml")),
    ("drop", include_str!("../../scenes/drop.toml")),
    ("stand0", include_str!("../../scenes/stand0.toml")),
    ("stand10", include_str!("../../scenes/stand10.toml")),
    ("rock", include_str!("../../scenes/rock.toml")),
    ("wheel", include_str!("../../scenes/wheel.toml")),
    ("turn", include_str!("../../scenes/turn.toml")),
    ("ball", include_str!("../../scenes/ball.toml")),
    // with known answers
    ("sliding-block", include_str!("../../scenes/known/sliding-block.toml")),
    ("fast-cube", include_str!("../../scenes/known/fast-cube.toml")),
    ("slope", include_str!("../../scenes/known/slope.toml")),
    ("roll", include_str!("../../scenes/known/roll.toml")),
    ("rocking-block", include_str!("../../scenes/known/rocking-block.toml")),
    ("squat-block", include_str!("../../scenes/known/squat-block.toml")),
    ("rimless-wheel", include_str!("../../scenes/known/rimless-wheel.toml")),
    ("simplest-walker", include_str!("../../scenes/known/simplest-walker.toml")),
    ("compass-gait", include_str!("../../scenes/known/compass-gait.toml")),
    ("painleve-rod", include_str!("../../scenes/known/painleve-rod.toml")),
    ("zeno", include_str!("../../scenes/known/zeno.toml")),
    ("flat-drop", include_str!("../../scenes/known/flat-drop.toml")),
    ("eight-corners", include_str!("../../scenes/known/eight-corners.toml")),
    ("pivot", include_str!("../../scenes/known/pivot.toml")),
    ("spinning-box", include_str!("../../scenes/known/spinning-box.toml")),
    ("gimbal", include_str!("../../scenes/known/gimbal.toml")),
    ("spring-ground", include_str!("../../scenes/known/spring-ground.toml")),
    ("stick-hour", include_str!("../../scenes/known/stick-hour.toml")),
    ("tumbling-foot", include_str!("../../scenes/known/tumbling-foot.toml")),
    ("double-pendulum", include_str!("../../scenes/known/double-pendulum.toml")),
    ("spinning-foot", include_str!("../../scenes/known/spinning-foot.toml")),
];

/// Prints name and description of every built-in scene.
///
/// # Errors
/// If one of them is bad, which a test excludes.
pub fn scenes() -> Result<(), Failure> {
    for &(name, _) in SCENES {
        say(format!("{name:<16} {}\n", load::load(name, &[], SCENES)?.description));
    }
    Ok(())
}

/// Prints every key with type, default and meaning, from the comments of the scene's own types.
///
/// # Errors
/// None.
pub fn keys() -> Result<(), Failure> {
    let schema = load::schema();
    let root = schema.as_value();
    for key in below(root, root, "") {
        say(format!("{:<34} {:<40} {}\n", key.path, key.kind, key.meaning));
    }
    Ok(())
}

/// One line of `biped list --keys`.
struct Key {
    path: String,
    kind: String,
    meaning: String,
}

/// The keys of a table, depth first.
fn below(root: &Value, table: &Value, path: &str) -> Vec<Key> {
    let properties = table["properties"].as_object().into_iter().flatten();
    properties
        .flat_map(|(name, property)| {
            let path = format!("{path}{name}");
            let target = resolve(root, property);
            if target["properties"].is_object() {
                return below(root, target, &format!("{path}."));
            }
            let items = resolve(root, &property["items"]);
            if items["properties"].is_object() {
                return below(root, items, &format!("{path}.NAME."));
            }
            let default = match &property["default"] {
                Value::Null => String::new(),
                default => format!(" = {default}"),
            };
            let meaning = property["description"].as_str().or(target["description"].as_str()).unwrap_or_default();
            vec![Key { path, kind: kind(root, property) + &default, meaning: meaning.replace('\n', " ") }]
        })
        .collect()
}

/// Follows a reference, also an optional one.
fn resolve<'a>(root: &'a Value, property: &'a Value) -> &'a Value {
    let option = property["anyOf"].as_array().and_then(|options| options.first());
    let place = option.unwrap_or(property);
    match place["$ref"].as_str() {
        Some(reference) => root.pointer(reference.trim_start_matches('#')).unwrap_or(place),
        None => place,
    }
}

/// Type of a value in words: a TOML type, or the words to choose from.
fn kind(root: &Value, property: &Value) -> String {
    let target = resolve(root, property);
    let choices = target["oneOf"].as_array().into_iter().flatten().filter_map(|choice| choice["const"].as_str());
    let choices: Vec<_> = choices.collect();
    if !choices.is_empty() {
        return choices.join("|");
    }
    let name = match &target["type"] {
        Value::Array(names) => names.first().and_then(Value::as_str),
        name => name.as_str(),
    };
    let count = target["minItems"].as_u64().map(|count| count.to_string()).unwrap_or_default();
    match name {
        Some("array") => format!("[{}; {count}]", kind(root, &target["items"])).replace("; ]", "]"),
        Some(name) => name.into(),
        None => "table".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_scene_is_good_and_described() {
        for &(name, _) in SCENES {
            let scene = load::load(name, &[], SCENES).expect(name);
            assert!(scene.description.ends_with('.'), "{name} wants a sentence");
        }
    }

    #[test]
    fn every_key_has_type_and_meaning_and_can_be_written() {
        let schema = load::schema();
        let keys = below(schema.as_value(), schema.as_value(), "");
        for key in &keys {
            assert!(!key.kind.is_empty() && !key.meaning.is_empty(), "{} = {}: {}", key.path, key.kind, key.meaning);
        }
        let listed = |path: &str| keys.iter().any(|key| key.path == path);
        for path in ["duration", "plant.law", "controller.rate_limit", "initial.clearance", "bodies.NAME.joint.axis"] {
            assert!(listed(path), "{path} is missing");
        }
        // Every key that a scene writes is listed.
        let scene = load::load("walk", &[], SCENES).expect("walk");
        let written = serde_json::to_value(&scene).expect("plain data");
        for (name, part) in written.as_object().into_iter().flatten() {
            for (key, _) in part.as_object().into_iter().flatten() {
                assert!(listed(&format!("{name}.{key}")), "{name}.{key} is not listed");
            }
        }
    }
}
