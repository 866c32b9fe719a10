//! Overrides `--set key=value`: replacing one value of a scene.

use super::error::in_plain_words;
use super::suggestion::suggest_from_error;
use crate::scene::Scene;
use serde::Deserialize;
use toml::{Table, Value};

/// The path of an override `robot=PATH`, bare or as a TOML string; `None` for other keys.
pub(super) fn robot(setting: &str) -> Option<&str> {
    let (key, path) = setting.split_once('=')?;
    (key.trim() == "robot").then(|| path.trim().trim_matches('"'))
}

/// The scene with one value replaced. The key is looked up in the scene as a TOML table, so every key of the scene's file works.
pub(super) fn apply(scene: &Scene, setting: &str) -> Result<Scene, String> {
    let (key, text) = setting.split_once('=').ok_or("an override is key=value, for example plant.dt=0.001")?;
    let (key, text) = (key.trim(), text.trim());
    // a text with a second key is not a value
    let table = format!("value = {text}").parse::<Table>().ok().filter(|table| table.len() == 1);
    let value = table.and_then(|mut table| table.remove("value"));
    // TOML requires a digit on both sides of the decimal point. Here `.5` is accepted too.
    let value = value.or_else(|| text.parse().ok().map(Value::Float)).unwrap_or_else(|| Value::String(text.into()));
    let mut root = Value::try_from(scene).map_err(|error| error.to_string())?;
    let tables = root.as_table().into_iter().flatten();
    let holder = tables.filter(|(_, table)| table.get(key).is_some()).map(|(name, _)| name.clone()).next();
    *slot(&mut root, key)? = value;
    Scene::deserialize(root).map_err(|error| {
        let words = in_plain_words(&error.to_string()).trim().replace('\n', " ");
        let whole =
            holder.map(|table| format!("; did you mean `{table}.{key}`?")).filter(|_| words.contains("unknown "));
        let hint = whole.unwrap_or_else(|| suggest_from_error(&words));
        let has_comma = text.replacen(',', ".", 1).parse::<f64>().is_ok() && text.contains(',');
        let point = if has_comma { "; the decimal sign is a point" } else { "" };
        words + point + &hint
    })
}

/// The value that a dotted key names. Missing tables and keys are created; serde checks their names afterwards.
fn slot<'a>(root: &'a mut Value, key: &str) -> Result<&'a mut Value, String> {
    let mut place = root;
    let mut path = String::new();
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
                    .ok_or_else(|| format!("there is no `{part}` in `{path}`: use an index from 0 to {last}{hint}"))?
            }
            _ => return Err(format!("`{part}` cannot follow `{path}`, which has a single value")),
        };
        path += if path.is_empty() { "" } else { "." };
        path += part;
    }
    Ok(place)
}
