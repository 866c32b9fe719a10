//! Elements and attributes of a URDF file that are not read. Those that make another robot of it are refused: macros, and joints that close
//! a loop. One sentence for each kind of the rest says that it has no effect, because it may be a misspelt one.
//!
//! `visual` and `material` are passed over: they describe looks.

use super::super::suggestion::suggest;
use super::xml::{Parsed, child, place};
use roxmltree::Node;
use std::collections::{BTreeMap, BTreeSet};

/// For each element: the elements in it that are read or describe looks, and its attributes.
const KNOWN: [(&str, &[&str], &[&str]); 18] = [
    ("robot", &["link", "joint", "transmission", "material"], &["name", "version"]),
    ("link", &["inertial", "visual", "collision"], &["name"]),
    ("inertial", &["origin", "mass", "inertia"], &[]),
    ("origin", &[], &["xyz", "rpy"]),
    ("mass", &[], &["value"]),
    ("inertia", &[], &["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]),
    ("collision", &["origin", "geometry"], &["name"]),
    ("geometry", &["box", "sphere"], &[]),
    ("box", &[], &["size"]),
    ("sphere", &[], &["radius"]),
    (
        "joint",
        &["parent", "child", "origin", "axis", "limit", "dynamics", "mimic", "safety_controller"],
        &["name", "type"],
    ),
    ("parent", &[], &["link"]),
    ("child", &[], &["link"]),
    ("axis", &[], &["xyz"]),
    ("limit", &[], &["lower", "upper", "effort", "velocity"]),
    ("dynamics", &[], &["damping", "friction"]),
    ("transmission", &["type", "joint", "actuator"], &["name"]),
    ("actuator", &["rotor_inertia", "gear_ratio", "hardwareInterface"], &["name"]),
];
/// Most kinds of parts that get a sentence of their own.
const MOST: usize = 12;
/// Words in the names of elements by which other programs close a loop of links.
const LOOPS: [&str; 4] = ["loop", "bushing", "constraint", "weld"];

/// Refuses macros that are not expanded, and joints that close a loop.
pub(super) fn refuse(root: Node) -> Parsed<()> {
    let is_macro = |node: &Node| node.tag_name().namespace().is_some_and(|space| space.contains("xacro"));
    let has_macro = |node: &Node| node.attributes().any(|attribute| attribute.value().contains("${"));
    if let Some(node) = root.descendants().find(|node| is_macro(node) || has_macro(node)) {
        let prefix = if is_macro(&node) { "xacro:" } else { "" };
        return Err(of_macro(&format!("{prefix}{}", place(node))));
    }
    let closes = |node: &Node| {
        let tag = node.tag_name().name().to_lowercase();
        let joins = child(*node, "parent").is_some() && child(*node, "child").is_some() && tag != "joint";
        joins || LOOPS.iter().any(|word| tag.contains(word))
    };
    match root.children().filter(Node::is_element).find(closes).map(|node| node.tag_name().name()) {
        None => Ok(()),
        Some(tag) => Err(format!(
            "`{tag}` joins links, but only the element `joint` does so here, and the links of a robot form a tree without loops"
        )),
    }
}

/// The sentence about a part of a file that only the program xacro understands.
pub(super) fn of_macro(part: &str) -> String {
    format!("{part} is a macro: expand the file first, with `xacro FILE > robot.urdf`")
}

/// A sentence for each kind of element and attribute that is not read, with the first place of it.
pub(super) fn notes(root: Node) -> Vec<String> {
    let mut notes = Notes::default();
    let mut read = BTreeSet::from([root.id().get()]);
    for node in root.descendants().filter(Node::is_element) {
        let parent = node.parent_element().map(|parent| (parent.id().get(), parent.tag_name().name()));
        let (tag, within) = (node.tag_name().name(), parent.map_or("", |(_, tag)| tag));
        let elements = known(within).map_or(&[][..], |(elements, _)| elements);
        match parent {
            Some((id, _)) if !read.contains(&id) => continue,
            Some(_) if tag == "material" || within == "transmission" && tag == "joint" => continue,
            Some(_) if !elements.contains(&tag) => {
                notes.add(&format!("{within} {tag}"), tag, &whole(node), elements);
                continue;
            }
            _ => (),
        }
        let Some((_, attributes)) = known(tag) else { continue };
        read.insert(node.id().get());
        for attribute in node.attributes().filter(|attribute| !attributes.contains(&attribute.name())) {
            notes.add(&format!("{tag}={}", attribute.name()), attribute.name(), &place(node), attributes);
        }
    }
    notes.sentences()
}

fn known(tag: &str) -> Option<(&'static [&'static str], &'static [&'static str])> {
    KNOWN.iter().find(|(known, ..)| *known == tag).map(|(_, elements, attributes)| (*elements, *attributes))
}

/// What an element is in, in words.
fn whole(node: Node) -> String {
    node.parent_element().map(place).unwrap_or_default()
}

/// Sentences on kinds of parts, in the order of their first places.
#[derive(Default)]
struct Notes {
    /// For each kind: its number, its sentence without the count, a suggestion, and how many there are.
    kinds: BTreeMap<String, (usize, String, String, usize)>,
}

impl Notes {
    fn add(&mut self, kind: &str, name: &str, place: &str, known: &[&'static str]) {
        let number = self.kinds.len();
        let first = || (number, format!("`{name}` in {place} is not read"), suggest(name, known.iter().copied()), 0);
        self.kinds.entry(kind.into()).or_insert_with(first).3 += 1;
    }

    fn sentences(self) -> Vec<String> {
        let mut kinds: Vec<_> = self.kinds.into_values().collect();
        kinds.sort();
        let more = kinds.len().saturating_sub(MOST);
        let sentence = |(_, words, hint, count): (usize, String, String, usize)| match count {
            1 => words + &hint,
            2 => format!("{words}, nor is another one{hint}"),
            _ => format!("{words}, nor are {} others like it{hint}", count - 1),
        };
        let mut sentences: Vec<_> = kinds.into_iter().take(MOST).map(sentence).collect();
        sentences.extend((more > 0).then(|| format!("{more} more kinds of elements and attributes are not read")));
        sentences
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::super::tests::biped;

    #[test]
    fn what_is_not_read_is_noted_once_for_each_kind_with_its_first_place() {
        let plain = parse(&biped("", "", "")).expect("a biped");
        assert_eq!(plain.notes, Vec::<String>::new());
        for (of_joint, of_link, of_robot, words) in [
            (
                "<dynamic damping='5'/>",
                "",
                "",
                "`dynamic` in joint `j1` is not read, nor are 7 others like it; did you mean `dynamics`?",
            ),
            (
                "<dynamics spring_stiffness='5'/>",
                "",
                "",
                "`spring_stiffness` in dynamics of joint `j1` is not read, nor are 7",
            ),
            ("<calibration rising='0'/>", "", "", "`calibration` in joint `j1` is not read"),
            ("", "<sensor/>", "", "`sensor` in link `l0` is not read, nor are 8 others like it"),
            ("", "", "<gazebo><link/></gazebo>", "`gazebo` in robot is not read"),
            ("", "", "<sensor name='s'><origin/></sensor>", "`sensor` in robot is not read"),
        ] {
            let read = parse(&biped(of_joint, of_link, of_robot)).expect(words);
            assert!(read.notes.len() == 1 && read.notes[0].starts_with(words), "{:?}", read.notes);
            assert_eq!(read.robot, plain.robot);
        }
        let looks = "<visual><geometry><mesh filename='a'/></geometry><material name='m'/></visual>";
        assert!(parse(&biped("", looks, "<material name='m'/>")).expect("a biped").notes.is_empty(), "looks");
    }

    #[test]
    fn macros_and_loops_are_refused() {
        let xacro = "xmlns:xacro='http://www.ros.org/wiki/xacro'";
        for (of_joint, of_robot, words) in [
            ("", format!("<xacro:include {xacro} filename='a'/>"), "xacro:include is a macro"),
            ("<limit effort='${e}'/>", String::new(), "limit of joint `j1` is a macro"),
            ("", "<loop_joint name='a'/>".into(), "`loop_joint` joins links"),
            ("", "<d:linear_bushing_rpy xmlns:d='drake'/>".into(), "`linear_bushing_rpy` joins links"),
            ("", "<rod><parent link='l1'/><child link='l2'/></rod>".into(), "`rod` joins links"),
        ] {
            let error = parse(&biped(of_joint, "", &of_robot)).err().expect(words);
            assert!(error.starts_with(words), "{error}");
        }
        assert!(parse("<robot><xacro:a/></robot>").is_err_and(|error| error.contains("xacro FILE > robot.urdf")));
    }
}
