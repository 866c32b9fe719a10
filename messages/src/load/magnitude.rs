//! The search of a scene or a robot for numbers that are not finite or too large.

use toml::Value;

/// Largest magnitude of any number. Its square and its cube are still finite.
pub(super) const MAX_MAGNITUDE: f64 = 1e30;

/// The first number that is not finite or exceeds [`MAX_MAGNITUDE`], with the path to it.
pub(super) fn first_excess(value: &Value) -> Option<(String, f64)> {
    let below = |key: String, (path, number): (String, f64)| match path.is_empty() {
        true => (key, number),
        false => (format!("{key}.{path}"), number),
    };
    match value {
        Value::Float(number) if number.is_nan() || number.abs() > MAX_MAGNITUDE => Some((String::new(), *number)),
        Value::Table(table) => {
            table.iter().find_map(|(key, part)| first_excess(part).map(|found| below(key.clone(), found)))
        }
        Value::Array(items) => {
            items.iter().enumerate().find_map(|(i, item)| first_excess(item).map(|found| below(i.to_string(), found)))
        }
        _ => None,
    }
}
