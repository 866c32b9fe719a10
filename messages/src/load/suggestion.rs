//! Suggestions for unknown names.

/// Least Jaro-Winkler similarity of a suggestion. `wlak` and `walk` have .93, `walk` and `wheel` .73.
const MIN_SIMILARITY: f64 = 0.85;

/// `; did you mean ...?` if a known name is similar to the unknown one, whatever the case of the letters, otherwise an empty string.
pub fn suggest<'a>(unknown: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let likeness = |name: &'a str| (strsim::jaro_winkler(&unknown.to_lowercase(), &name.to_lowercase()), name);
    let best = known.into_iter().map(likeness).max_by(|one, other| one.0.total_cmp(&other.0));
    best.filter(|(likeness, _)| *likeness > MIN_SIMILARITY)
        .map_or(String::new(), |(_, name)| format!("; did you mean `{name}`?"))
}

/// A suggestion from the error of an unknown field, variant or law. That error contains the unknown name and all valid names.
pub(super) fn suggest_from_error(error: &str) -> String {
    let mut names = error.split('`').skip(1).step_by(2);
    match names.next().filter(|_| error.contains("unknown ")) {
        Some(unknown) => suggest(unknown, names),
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_typing_error_gets_a_suggestion_and_a_different_word_does_not() {
        let known = ["walk", "wheel", "stand", "walk-literal"];
        assert_eq!(suggest("wlak", known), "; did you mean `walk`?");
        assert_eq!(suggest("STAND", known), "; did you mean `stand`?");
        assert_eq!(suggest("standd", known), "; did you mean `stand`?");
        assert_eq!(suggest("quadruped", known), "");
        assert_eq!(
            suggest_from_error("unknown field `frition`, expected one of `dt`, `friction`, `law`"),
            "; did you mean `friction`?"
        );
        assert_eq!(suggest_from_error("invalid type: string, expected `friction`"), "");
    }
}
