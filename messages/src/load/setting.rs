//! `--set key=value`: one value of a scene replaced.

use super::suggestion::suggest_from_error;
use crate::scene::Scene;
use serde::Deserialize;
use toml::{Table, Value};

/// The path of `robot=PATH`, bare or as a TOML string; nothing of another key.
pub(super) fn robot(setting: &str) -> Option<&str> {
    let (key, path) = setting.split_once('=')?;
    (key.trim() == "robot").then(|| path.trim().trim_matches('"'))
}

/// The scene with one value replaced, found by walking the scene as a table: so every key exists that serde knows.
pub(super) fn apply(scene: &Scene, setting: &str) -> Result<Scene, String> {
    let (key, text) = setting.split_once('=').ok_or("an override is key=value, for example plant.dt=0.001")?;
    let (key, text) = (key.trim(), text.trim());
    let value = format!("value = {text}").parse::<Table>().ok().and_then(|mut table| table.remove("value"));
    // TOML wants a digit on both sides of the point; people do not
    let value = value.or_else(|| text.parse().ok().map(Value::Float)).unwrap_or_else(|| Value::String(text.into()));
    let mut root = Value::try_from(scene).map_err(|error| error.to_string())?;
    *slot(&mut root, key)? = value;
    Scene::deserialize(root).map_err(|error| {
        let words = error.to_string().trim().replace('\n', " ");
        let hint = suggest_from_error(&words);
        words + &hint
    })
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
