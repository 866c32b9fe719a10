//! Lists of names in a sentence.

/// Most names that a sentence lists.
const MOST: usize = 6;

/// The first names, separated by commas, and how many more there are.
pub(super) fn listed<T: AsRef<str>>(names: &[T]) -> String {
    let shown = names.iter().take(MOST).map(AsRef::as_ref).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MOST) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// A name in quotation marks.
pub(super) fn quoted(name: &str) -> String {
    format!("`{name}`")
}

/// The verb that follows such a list.
pub(super) fn has<T>(names: &[T]) -> &'static str {
    if names.len() == 1 { "has" } else { "have" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_list_is_cut_between_names_and_says_how_many_are_left_out() {
        assert_eq!(listed(&["a", "b"]), "a, b");
        assert_eq!(listed(&["a", "b", "c", "d", "e", "f", "g", "h"]), "a, b, c, d, e, f and 2 more");
    }
}
