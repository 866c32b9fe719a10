//! Reading elements and attributes of a URDF file.

use roxmltree::Node;

/// Result of reading a part of the file. An error is one sentence.
pub type Parsed<T> = Result<T, String>;

/// Children of a node with this tag.
pub fn children<'a>(node: Node<'a, 'a>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(move |child| child.tag_name().name() == tag)
}

/// First child of a node with this tag.
pub fn child<'a>(node: Node<'a, 'a>, tag: &'static str) -> Option<Node<'a, 'a>> {
    children(node, tag).next()
}

/// Whether a joint fixes two links to each other.
pub fn is_fixed(joint: Node) -> bool {
    joint.attribute("type") == Some("fixed")
}

/// Name of the link at an end of a joint: `parent` or `child`.
pub fn linked<'a>(joint: Node<'a, 'a>, end: &'static str) -> Option<&'a str> {
    child(joint, end)?.attribute("link")
}

/// A node in words: by its own name if it has one, otherwise with the link, joint or actuator that it belongs to.
pub fn place(node: Node) -> String {
    let tag = |node: Node| node.tag_name().name().to_string();
    if let Some(name) = node.attribute("name").filter(|_| matches!(node.tag_name().name(), "link" | "joint")) {
        return format!("{} `{name}`", tag(node));
    }
    let owner = node.ancestors().skip(1).filter(|part| part.tag_name().name() != "robot");
    let owner = owner.filter_map(|part| Some((tag(part), part.attribute("name")?))).next();
    owner.map_or(tag(node), |(kind, name)| format!("{} of {kind} `{name}`", tag(node)))
}

/// Attribute of a node.
pub fn attribute<'a>(node: Node<'a, 'a>, key: &str) -> Parsed<&'a str> {
    node.attribute(key).ok_or_else(|| match place(node) {
        part if part.contains(" of ") => format!("the {part} has no {key}"),
        part if part.contains(' ') => format!("{part} has no {key}"),
        part => format!("a {part} has no {key}"),
    })
}

/// Attribute of a node as a finite number.
pub fn number(node: Node, key: &str) -> Parsed<f64> {
    let text = attribute(node, key)?;
    finite(text).ok_or_else(|| format!("{key}=\"{text}\" in the {} is not a finite number", place(node)))
}

/// Attribute of a node as a number, or `otherwise` if it is absent.
pub fn optional(node: Node, key: &str, otherwise: f64) -> Parsed<f64> {
    node.attribute(key).map_or(Ok(otherwise), |_| number(node, key))
}

/// Attribute of a node as three finite numbers.
pub fn vector(node: Node, key: &str) -> Parsed<[f64; 3]> {
    let text = attribute(node, key)?;
    let parts: Option<Vec<f64>> = text.split_whitespace().map(finite).collect();
    let parts = parts.and_then(|parts| parts.try_into().ok());
    parts.ok_or_else(|| format!("{key}=\"{text}\" in the {} is not three finite numbers", place(node)))
}

/// Attribute of a shape as a length greater than 0.
pub fn length(shape: Node, key: &str) -> Parsed<f64> {
    let value = number(shape, key)?;
    require_positive(shape, key, &[value]).map(|()| value)
}

/// Attribute of a shape as three lengths greater than 0.
pub fn lengths(shape: Node, key: &str) -> Parsed<[f64; 3]> {
    let values = vector(shape, key)?;
    require_positive(shape, key, &values).map(|()| values)
}

fn require_positive(shape: Node, key: &str, values: &[f64]) -> Parsed<()> {
    let text = attribute(shape, key)?;
    let fault = || format!("{key}=\"{text}\" in the {} must be greater than 0", place(shape));
    if values.iter().all(|value| *value > 0.0) { Ok(()) } else { Err(fault()) }
}

/// The finite number that a text states.
fn finite(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|value: &f64| value.is_finite())
}

/// Position of the `origin` of an element.
pub fn position(node: Node) -> Parsed<[f64; 3]> {
    let origin = child(node, "origin").filter(|origin| origin.has_attribute("xyz"));
    origin.map_or(Ok([0.0; 3]), |origin| vector(origin, "xyz"))
}

/// Angles up to this are rounding of the program that wrote the file [rad].
const ROUNDING: f64 = 1e-9;

/// Whether the `origin` of an element turns it.
pub fn is_rotated(node: Node) -> Parsed<bool> {
    let origin = child(node, "origin").filter(|origin| origin.has_attribute("rpy"));
    origin.map_or(Ok(false), |origin| Ok(vector(origin, "rpy")?.iter().any(|angle| angle.abs() > ROUNDING)))
}
