//! `biped list`: the built-in scenes, and all keys of a scene.

pub use messages::load::SCENES;

use crate::exit::Failure;
use crate::output::print_text;
use messages::load;
use serde_json::Value;

/// Prints the name and description of every built-in scene.
///
/// # Errors
/// If a built-in scene is invalid. A test excludes that.
pub fn scenes() -> Result<(), Failure> {
    for &(name, _) in SCENES {
        print_text(format!("{name:<16} {}\n", load::load(name, &[], SCENES)?.description));
    }
    Ok(())
}

/// Prints every key of a scene with its type, default and meaning. They come from the JSON schema of the scene types.
///
/// # Errors
/// None.
pub fn keys() -> Result<(), Failure> {
    let schema = load::schema();
    let root = schema.as_value();
    for key in keys_of(root, root, "") {
        print_text(format!("{:<34} {:<40} {}\n", key.path, key.type_name, key.meaning));
    }
    Ok(())
}

/// One line of `biped list --keys`.
struct Key {
    path: String,
    type_name: String,
    meaning: String,
}

/// The keys of a table and its subtables, depth first.
fn keys_of(root: &Value, table: &Value, path: &str) -> Vec<Key> {
    let properties = table["properties"].as_object().into_iter().flatten();
    properties
        .flat_map(|(name, property)| {
            let path = format!("{path}{name}");
            let target = resolve(root, property);
            if target["properties"].is_object() {
                return keys_of(root, target, &format!("{path}."));
            }
            let items = resolve(root, &property["items"]);
            if items["properties"].is_object() {
                return keys_of(root, items, &format!("{path}.NAME."));
            }
            let default = match &property["default"] {
                Value::Null => String::new(),
                default => format!(" = {default}"),
            };
            let meaning = property["description"].as_str().or(target["description"].as_str()).unwrap_or_default();
            vec![Key { path, type_name: type_name(root, property) + &default, meaning: meaning.replace('\n', " ") }]
        })
        .collect()
}

/// Follows a schema reference, also that of an optional value.
fn resolve<'a>(root: &'a Value, property: &'a Value) -> &'a Value {
    let option = property["anyOf"].as_array().and_then(|options| options.first());
    let schema = option.unwrap_or(property);
    match schema["$ref"].as_str() {
        Some(reference) => root.pointer(reference.trim_start_matches('#')).unwrap_or(schema),
        None => schema,
    }
}

/// Type of a value: the TOML type, or the allowed words.
fn type_name(root: &Value, property: &Value) -> String {
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
        Some("array") => format!("[{}; {count}]", type_name(root, &target["items"])).replace("; ]", "]"),
        Some(name) => name.into(),
        None => "table".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_scenes_are_valid_and_have_descriptions() {
        for &(name, _) in SCENES {
            let scene = load::load(name, &[], SCENES).expect(name);
            assert!(scene.description.ends_with('.'), "{name}: the description is no sentence");
        }
    }

    #[test]
    fn every_key_is_listed_with_type_and_meaning() {
        let schema = load::schema();
        let keys = keys_of(schema.as_value(), schema.as_value(), "");
        for key in &keys {
            assert!(
                !key.type_name.is_empty() && !key.meaning.is_empty(),
                "{} = {}: {}",
                key.path,
                key.type_name,
                key.meaning
            );
        }
        let listed = |path: &str| keys.iter().any(|key| key.path == path);
        for path in ["duration", "plant.law", "controller.rate_limit", "initial.clearance", "bodies.NAME.joint.axis"] {
            assert!(listed(path), "{path} is missing");
        }
        // Every key of a serialized scene is listed.
        let scene = load::load("walk", &[], SCENES).expect("walk");
        let written = serde_json::to_value(&scene).expect("plain data");
        for (name, part) in written.as_object().into_iter().flatten() {
            for (key, _) in part.as_object().into_iter().flatten() {
                assert!(listed(&format!("{name}.{key}")), "{name}.{key} is not listed");
            }
        }
    }
}
