//! The values of a key: a list, a range or a logarithmic range.

use shared::exit::{Exit, Failure};

/// Most values of a range.
const MOST: usize = 100_000;
/// Decimals behind the first digit to which the values of a range are rounded, so that they are short and the same in a command line.
const DIGITS: usize = 11;

/// A value this close to 0 is 0, within rounding [steps of its range].
const ROUNDING: f64 = 1e-9;

/// A key and its values, as they are written in a setting.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Dotted key.
    pub key: String,
    /// Values in the order given.
    pub values: Vec<String>,
}

impl Axis {
    /// Reads `KEY=RANGE`. A range is a list of values and of `a:b:n` or `log:a:b:n`: n values from a to b.
    ///
    /// # Errors
    /// If there is no key or no value, or if a range is wrong. The text itself is not in the message.
    pub fn parse(text: &str) -> Result<Axis, String> {
        let parts = text.split_once('=').map(|(key, values)| (key.trim(), values.trim()));
        let Some((key, values)) = parts.filter(|(key, values)| !key.is_empty() && !values.is_empty()) else {
            return Err(
                "give a key with its values, for example plant.friction=0.7,0.3 or plant.friction=0.1:0.9:5".into()
            );
        };
        let mut all = Vec::new();
        for part in outside_brackets(values) {
            match part.trim() {
                "" => return Err("a value between two commas is missing".into()),
                part if part.chars().any(char::is_control) => return Err("a value contains a control character".into()),
                part if part.contains(':') && !part.starts_with(['"', '\'', '[', '{']) => all.extend(range(part)?),
                part => all.push(part.into()),
            }
        }
        Ok(Axis { key: key.into(), values: all })
    }

    /// The setting that chooses a value.
    pub fn setting(&self, index: usize) -> String {
        format!("{}={}", self.key, self.values[index])
    }
}

/// The indices of the values in every combination. The last axis varies fastest.
pub fn combinations(axes: &[Axis]) -> Vec<Vec<usize>> {
    axes.iter().fold(vec![vec![]], |combinations, axis| {
        let extended = |old: Vec<usize>| (0..axis.values.len()).map(move |k| [&old[..], &[k]].concat());
        combinations.into_iter().flat_map(extended).collect()
    })
}

/// The settings of a combination.
pub fn settings(axes: &[Axis], combination: &[usize]) -> Vec<String> {
    axes.iter().zip(combination).map(|(axis, index)| axis.setting(*index)).collect()
}

/// A usage error about an argument.
pub fn refused(argument: &str, words: String) -> Failure {
    Failure::new(Exit::Usage, format!("{argument}: {words}"))
}

/// The ends, as given, and the values in between.
fn range(text: &str) -> Result<Vec<String>, String> {
    let (is_log, ends) = text.strip_prefix("log:").map_or((false, text), |ends| (true, ends));
    let parts: Vec<&str> = ends.split(':').collect();
    let &[first, last, count] = &parts[..] else {
        return Err(format!("{text} is no range: a:b:n or log:a:b:n is needed, n values from a to b"));
    };
    let number = |text: &str| text.parse().ok().filter(|value: &f64| value.is_finite());
    let end = |text: &str| number(text).ok_or(format!("`{text}` is no finite number"));
    let (from, to) = (end(first)?, end(last)?);
    let steps = count.parse().ok().filter(|count| (2..=MOST).contains(count)).map(|count: usize| count - 1);
    let steps = steps.ok_or(format!("`{count}` values are impossible: a whole number from 2 to {MOST} is needed"))?;
    if from == to {
        return Err(format!("{text} is empty: both ends are {first}"));
    }
    if is_log && (from <= 0.0 || to <= 0.0) {
        return Err(format!("{text}: the ends of a logarithmic range must be greater than 0"));
    }
    let between = |k: usize| {
        let share = k as f64 / steps as f64;
        let mean = |from: f64, to: f64| from * (1.0 - share) + to * share;
        let value = if is_log { mean(from.ln(), to.ln()).exp() } else { mean(from, to) };
        let is_rounding = !is_log && value.abs() < ROUNDING * (to - from).abs() / steps as f64;
        if is_rounding { 0.0 } else { value }
    };
    Ok((0..=steps)
        .map(|k| match k {
            0 => from.to_string(),
            _ if k == steps => to.to_string(),
            _ => rounded(between(k)).to_string(),
        })
        .collect())
}

fn rounded(value: f64) -> f64 {
    format!("{value:.DIGITS$e}").parse().unwrap_or(value)
}

/// Splits at the commas that are not within brackets.
fn outside_brackets(values: &str) -> Vec<String> {
    let (mut parts, mut depth) = (vec![String::new()], 0);
    for letter in values.chars() {
        depth += i32::from(letter == '[') - i32::from(letter == ']');
        match parts.last_mut() {
            Some(part) if letter != ',' || depth > 0 => part.push(letter),
            _ => parts.push(String::new()),
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<String> {
        Axis::parse(&format!("key={text}")).expect(text).values
    }

    #[test]
    fn lists_within_brackets_stay_together() {
        assert_eq!(values("0.7,0.3"), ["0.7", "0.3"]);
        assert_eq!(values("[0,2,0],[0,-2,0]"), ["[0,2,0]", "[0,-2,0]"]);
    }

    #[test]
    fn a_range_has_both_ends_and_short_values_in_between() {
        assert_eq!(values("0:1:11")[3], "0.3");
        assert_eq!(values("0.1:0.7:4"), ["0.1", "0.3", "0.5", "0.7"]);
        assert_eq!(values("1:-1:3"), ["1", "0", "-1"]);
        assert_eq!(values("-0.5:0.7:25")[9..12], ["-0.05", "0", "0.05"], "not 5.55e-17");
        assert_eq!(values("log:0.001:10:5"), ["0.001", "0.01", "0.1", "1", "10"]);
        assert_eq!(values("0:2:3,5"), ["0", "1", "2", "5"]);
        assert_eq!(values("\"a:b\""), ["\"a:b\""], "quoted text is no range");
    }

    #[test]
    fn combinations_are_all_different_with_the_last_axis_fastest() {
        let axes = ["a=1,2", "b=x,y,z"].map(|text| Axis::parse(text).expect(text));
        let all = combinations(&axes);
        assert_eq!(all.len(), 6);
        assert_eq!(settings(&axes, &all[1]), ["a=1", "b=y"]);
        assert_eq!(combinations(&[]).len(), 1);
    }

    #[test]
    fn a_wrong_range_is_refused() {
        for (text, word) in [
            ("key", "give a key"),
            ("=1", "give a key"),
            ("key=", "give a key"),
            ("key=1,,2", "missing"),
            ("key=0:1", "a:b:n"),
            ("key=0:1:2:3", "a:b:n"),
            ("key=0:x:3", "`x` is no finite number"),
            ("key=0:inf:3", "`inf` is no finite number"),
            ("key=0:1:1", "from 2 to 100000"),
            ("key=0:1:2.5", "from 2 to 100000"),
            ("key=0:1:1000000000000", "from 2 to 100000"),
            ("key=1:1:3", "empty"),
            ("key=log:0:1:3", "greater than 0"),
            ("key=1\u{7}", "control"),
        ] {
            let words = Axis::parse(text).expect_err(text);
            assert!(words.contains(word), "{text}: {words}");
        }
    }
}
