//! Parts of a URDF file that may occur once. Only one of several would be read, so a file that repeats them is refused.

use super::xml::{Parsed, attribute, child, children, linked};
use roxmltree::Node;
use std::collections::BTreeSet;

/// Elements that a link has at most once. A link may have several visuals and collisions.
const OF_A_LINK: [&str; 1] = ["inertial"];
/// Elements that an inertial has at most once.
const OF_AN_INERTIAL: [&str; 3] = ["origin", "mass", "inertia"];
/// Elements that a joint has at most once.
const OF_A_JOINT: [&str; 8] = ["parent", "child", "origin", "axis", "limit", "dynamics", "mimic", "safety_controller"];

/// Refuses the file if two links or two joints have one name, if two joints move one link, if a joint moves no link of the file, or if a
/// link or joint repeats an element.
pub(super) fn refuse(root: Node) -> Parsed<()> {
    let links = names(root, "link")?;
    names(root, "joint")?;
    let mut moved = BTreeSet::new();
    for joint in children(root, "joint") {
        let name = attribute(joint, "name")?;
        at_most_one(joint, &OF_A_JOINT, &format!("joint `{name}`"))?;
        let link = linked(joint, "child").ok_or(format!("joint `{name}` has no child"))?;
        if !links.contains(link) {
            return Err(format!("joint `{name}` moves the link `{link}`, which the file does not have"));
        }
        let parent = linked(joint, "parent").ok_or(format!("joint `{name}` has no parent"))?;
        if !links.contains(parent) {
            return Err(format!("joint `{name}` hangs on the link `{parent}`, which the file does not have"));
        }
        if !moved.insert(link) {
            return Err(format!("joint `{name}` moves the link `{link}`, which another joint moves already"));
        }
    }
    for link in children(root, "link") {
        let owner = format!("link `{}`", attribute(link, "name")?);
        at_most_one(link, &OF_A_LINK, &owner)?;
        if let Some(inertial) = child(link, "inertial") {
            at_most_one(inertial, &OF_AN_INERTIAL, &format!("the inertial of {owner}"))?;
        }
    }
    Ok(())
}

/// The names of all elements with this tag, each of which must differ.
fn names<'a>(root: Node<'a, 'a>, tag: &'static str) -> Parsed<BTreeSet<&'a str>> {
    let mut known = BTreeSet::new();
    for node in children(root, tag) {
        let name = attribute(node, "name")?;
        if !known.insert(name) {
            return Err(format!("two {tag}s have the name `{name}`, but every {tag} needs a name of its own"));
        }
    }
    Ok(known)
}

fn at_most_one(node: Node, tags: &[&'static str], owner: &str) -> Parsed<()> {
    match tags.iter().find(|tag| children(node, tag).nth(1).is_some()) {
        Some(tag) => Err(format!("{owner} has more than one `{tag}`, but it can have only one: remove the others")),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse;

    use super::super::tests::biped;

    const INERTIAL: &str = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>";

    #[test]
    fn what_may_occur_once_is_refused_when_it_occurs_twice() {
        parse(&biped("<limit effort='1'/>", "", "")).expect("a robot without repetitions");
        let joint = |name: &str, child: &str| {
            format!("<joint name='{name}' type='continuous'><parent link='l0'/><child link='{child}'/></joint>")
        };
        let link = |name: &str| format!("<link name='{name}'>{INERTIAL}</link>");
        let limits = "<limit effort='1'/><limit effort='2'/>";
        let masses = INERTIAL.replace("<mass value='1'/>", "<mass value='1'/><mass value='2'/>");
        for (file, words) in [
            (biped("", INERTIAL, ""), "link `l0` has more than one `inertial`"),
            (biped("", "", "").replace(INERTIAL, &masses), "the inertial of link `l0` has more than one `mass`"),
            (biped(limits, "", ""), "joint `j1` has more than one `limit`"),
            (biped("<axis xyz='1 0 0'/>", "", ""), "joint `j1` has more than one `axis`"),
            (biped("", "", &(link("c") + &joint("j1", "c"))), "two joints have the name `j1`"),
            (biped("", "", &link("l1")), "two links have the name `l1`"),
            (biped("", "", &joint("k", "l1")), "joint `k` moves the link `l1`, which another joint moves already"),
            (biped("", "", &joint("k", "c")), "joint `k` moves the link `c`, which the file does not have"),
            (
                biped("", "", "").replacen("<parent link='l1'/>", "<parent link='hip'/>", 1),
                "joint `j2` hangs on the link `hip`, which the file does not have",
            ),
        ] {
            let refused = parse(&file).err().expect(words);
            assert!(refused.starts_with(words), "{refused}");
        }
    }
}
