//! Robots as URDF: the files that `biped export urdf` writes, and others of the same form.
//!
//! | in the file | in the robot |
//! |---|---|
//! | `inertial`: mass, `origin`, moments of inertia | the same; products of inertia must be 0 |
//! | box of the first `visual` | size of the box that is drawn |
//! | `collision`: sphere | ball; contact point if its radius is 1 mm |
//! | `collision`: box | contact points at its bottom corners |
//! | `effort`, `drake:rotor_inertia` times `drake:gear_ratio`², `damping` | drives |
//! | links without mass, held by `fixed` joints | their collisions and joints belong to the body that they are fixed to |
//!
//! Properties that this simulator does not have are refused: [`unsupported`], [`faults`]. So are parts that may occur once and occur
//! twice: [`repeated`]. The rest of the file is not read, and a note says so: [`ignored`].

mod contacts;
mod drives;
mod faults;
mod ignored;
mod links;
mod repeated;
mod unsupported;
pub(super) mod words;
mod xml;

use super::robot_file::RobotFile;
use crate::robot::{Body, Joint, JointKind, Robot};
use links::{Rigid, WORLD, carrier, sum};
use roxmltree::{Document, Error, Node};
use xml::{Parsed, attribute, child, children, is_fixed, lengths, linked, number, position, vector};

/// Size of the drawn box of a body for which the file draws none [m]. It affects no motion: the moments of inertia are given.
const UNDRAWN_SIZE: [f64; 3] = [0.05; 3];

/// The robot of a URDF file, not yet in canonical order and not yet checked.
///
/// What is no biped is refused first: whoever brings another kind of robot need not correct its parts.
pub(super) fn parse(text: &str) -> Parsed<RobotFile> {
    require_few_attributes(text)?;
    let document = Document::parse(text).map_err(|error| not_xml(&error))?;
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        return Err(format!("the root element of a URDF file is `robot`, not `{}`", root.tag_name().name()));
    }
    ignored::refuse(root)?;
    repeated::refuse(root)?;
    let rigid = links::bodies(root)?;
    let joints: Vec<Node> = children(root, "joint").filter(|joint| !is_fixed(*joint)).collect();
    unsupported::refuse(&joints)?;
    faults::refuse(&rigid)?;
    contacts::refuse_other_shapes(rigid.iter().flat_map(|body| &body.parts))?;
    let mut bodies = rigid.iter().map(|own| body(own, &rigid)).collect::<Parsed<Vec<_>>>()?;
    let drives = drives::read(root, &joints, &rigid, &mut bodies)?;
    let name = root.attribute("name").unwrap_or_default();
    let robot = Robot { name: name.into(), drives, bodies };
    Ok(RobotFile { robot, notes: ignored::notes(root), mount: mount(root) })
}

/// Most attributes of an element. The time that the parser takes grows with the square of their number.
const MOST_ATTRIBUTES: usize = 1000;

/// Refuses elements with very many attributes. Comments and the like begin with an exclamation mark.
fn require_few_attributes(text: &str) -> Parsed<()> {
    let count = |tag: &str| tag.split('>').next().unwrap_or_default().matches('=').count();
    let most = text.split('<').filter(|tag| !tag.starts_with('!')).map(count).max().unwrap_or(0);
    let rule = format!("an element may have at most {MOST_ATTRIBUTES}");
    if most <= MOST_ATTRIBUTES { Ok(()) } else { Err(format!("an element has about {most} attributes, but {rule}")) }
}

fn not_xml(error: &Error) -> String {
    match error {
        Error::DtdDetected => "the file has a document type (<!DOCTYPE …>), which is not read: remove it".into(),
        Error::UnknownNamespace(prefix, _) if prefix == "xacro" => ignored::of_macro("xacro:"),
        error => format!("the file is not XML: {error}"),
    }
}

/// The sentence about a joint that fixes the robot to a link named `world`, if there is one. Other programs then hold the robot, which moves
/// freely here unless `plant.base` is fixed.
fn mount(root: Node) -> Option<String> {
    let joint = children(root, "joint").find(|joint| links::is_mount(*joint))?;
    let (name, link) = (joint.attribute("name")?, linked(joint, "child")?);
    let free = "the robot is free to move: plant.base = \"fixed\" fixes it";
    Some(format!("joint `{name}` fixes `{link}` to the link `{WORLD}`, but {free}"))
}

/// A body from its link with mass, the collisions of all its links, and its joint.
fn body(own: &Rigid, all: &[Rigid]) -> Parsed<Body> {
    let name = own.name();
    let Some(main) = own.masses().next() else { return Err(format!("`{name}` has no inertial")) };
    let inertial = child(main.link, "inertial").ok_or(format!("`{name}` has no inertial"))?;
    let part = |tag| child(inertial, tag).ok_or(format!("the inertial of `{name}` has no {tag}"));
    let mass = number(part("mass")?, "value")?;
    let tensor = part("inertia")?;
    let moments = [number(tensor, "ixx")?, number(tensor, "iyy")?, number(tensor, "izz")?];
    let drawn = children(main.link, "visual").find_map(|visual| child(child(visual, "geometry")?, "box"));
    let size = drawn.map_or(Ok(UNDRAWN_SIZE), |shape| lengths(shape, "size"))?;
    let mut body = Body { name: name.into(), mass, size, com: sum(main.at, position(inertial)?), ..Body::default() };
    if body.moments() != moments {
        body.inertia = Some(moments);
    }
    own.parts.iter().try_for_each(|part| contacts::add(&mut body, part))?;
    body.joint = own.joint.map(|node| joint_of(node, all)).transpose()?;
    Ok(body)
}

/// The joint that moves a body, in the frame of the body that carries it.
fn joint_of(node: Node, bodies: &[Rigid]) -> Parsed<Joint> {
    let name = attribute(node, "name")?;
    let kind = if attribute(node, "type")? == "prismatic" { JointKind::Prismatic } else { JointKind::Revolute };
    let axis = child(node, "axis").map_or(Ok([1.0, 0.0, 0.0]), |axis| vector(axis, "xyz"))?;
    let length = axis.iter().map(|c| c * c).sum::<f64>().sqrt();
    if length == 0.0 {
        return Err(format!("the axis of joint `{name}` is 0 0 0, but it needs a direction"));
    }
    let (parent, part) = carrier(bodies, node).ok_or(format!("joint `{name}` has no parent"))?;
    let at = sum(part.at, position(node)?);
    Ok(Joint { parent: parent.name().into(), kind, axis: axis.map(|c| c / length), at, ..Joint::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A biped with these elements in every joint, in every link and at the end. Links are l0 (trunk), l1 … l4 (left leg), l5 … l8; joint jN
    /// moves link lN.
    pub(super) fn biped(of_joint: &str, of_link: &str, of_robot: &str) -> String {
        let link = |k: usize| {
            let sole = if k == 4 || k == 8 {
                "<collision><geometry><box size='0.2 0.1 0.1'/></geometry></collision>"
            } else {
                ""
            };
            let inertial = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>";
            format!("<link name='l{k}'>{inertial}{sole}{of_link}</link>")
        };
        let joint = |k: usize| {
            let (parent, at) = match k {
                1 => (0, "0 0.1 0"),
                5 => (0, "0 -0.1 0"),
                _ => (k - 1, "0 0 -0.2"),
            };
            let axis = if k.is_multiple_of(4) { "1 0 0" } else { "0 1 0" };
            format!(
                "<joint name='j{k}' type='continuous'><parent link='l{parent}'/><child link='l{k}'/><origin xyz='{at}'/><axis \
                 xyz='{axis}'/>{of_joint}</joint>"
            )
        };
        let (links, joints): (String, String) = ((0..9).map(link).collect(), (1..9).map(joint).collect());
        format!("<robot name='r'>{links}{joints}{of_robot}</robot>")
    }

    /// The robot of a file, with its bodies by name: the order of the file has no meaning.
    fn read(text: &str) -> Robot {
        let mut robot = parse(text).expect("a biped").robot;
        robot.bodies.sort_by(|a, b| a.name.cmp(&b.name));
        robot
    }

    fn refused(text: &str, words: &str) {
        let error = parse(text).err().expect(words);
        assert!(error.contains(words), "{error}");
    }

    /// A frame without mass that is fixed to a link.
    fn frame(name: &str, on: &str, at: &str, inside: &str) -> String {
        format!(
            "<link name='{name}'>{inside}</link><joint name='to {name}' type='fixed'><parent link='{on}'/><child link='{name}'/><origin \
             {at}/></joint>"
        )
    }

    #[test]
    fn links_without_mass_are_parts_of_the_body_that_they_are_fixed_to() {
        let plain = read(&biped("", "", ""));
        let ball = "<collision><origin xyz='0 0 1'/><geometry><sphere radius='0.1'/></geometry></collision>";
        let toes = frame("toe", "l4", "xyz='1 0 0'", "") + &frame("tip", "toe", "xyz='0 2 0'", ball);
        let foot = &read(&biped("", "", &toes)).bodies.into_iter().find(|body| body.name == "l4").expect("the foot");
        assert_eq!(foot.spheres, [crate::robot::Sphere { at: [1.0, 2.0, 1.0], radius: 0.1 }]);
        // a hip on a frame, the mass of a shank on a frame, a base without mass, and frames with a mass of 0
        let hip = biped("", "", &frame("side", "l0", "xyz='0 0.1 0'", "")).replace(
            "<parent link='l0'/><child link='l1'/><origin xyz='0 0.1 0'/>",
            "<parent link='side'/><child link='l1'/>",
        );
        assert_eq!(read(&hip), plain);
        let moved = biped("", "", &frame("l2", "shin", "xyz='0 0 0'", "")).replacen("<link name='l2'></link>", "", 1);
        let moved =
            moved.replace("<child link='l2'/><origin xyz='0 0 -0.2'/>", "<child link='shin'/><origin xyz='0 0 -0.2'/>");
        assert_eq!(read(&moved.replace("<robot name='r'>", "<robot name='r'><link name='shin'/>")), plain);
        let zero = "<inertial><mass value='0'/><inertia ixx='0' iyy='0' izz='0'/></inertial>";
        for inside in ["", zero] {
            let base = format!(
                "<link name='base'>{inside}</link><joint name='b' type='fixed'><parent link='base'/><child link='l0'/><origin xyz='0 0 5'/></joint>"
            );
            assert_eq!(read(&biped("", "", &base)), plain, "the frame of the trunk is that of its mass");
        }
    }

    #[test]
    fn every_link_of_a_body_is_held_to_the_rules_of_shapes_and_frames() {
        let mesh = "<collision><geometry><mesh filename='a'/></geometry></collision>";
        refused(&biped("", "", &frame("toe", "l4", "", mesh)), "the collision of `toe` has a mesh");
        let turned = |inside: &str| biped("", "", &frame("toe", "l4", "rpy='0 1 0'", inside));
        refused(&turned("<collision/>"), "joint `to toe` has a rotated origin");
        read(&turned("")); // nothing depends on this frame
        let base = "<link name='base'/><joint name='b' type='fixed'><parent link='base'/><child link='l0'/><origin rpy='0 1 0'/></joint>";
        refused(&biped("", "", base), "joint `b` has a rotated origin");
        read(&biped("", "", &base.replace("'base'", "'world'"))); // which only holds the robot
        refused(
            &biped("", "", &frame("pack", "l0", "", "<inertial><mass value='1'/></inertial>")),
            "`pack` to `l0`, but a body has one",
        );
    }

    #[test]
    fn sizes_of_shapes_must_be_greater_than_zero() {
        for (shape, words) in [
            ("box size='-0.2 0.1 -0.05'", "size=\"-0.2 0.1 -0.05\" in the box of link `l0` must be greater than 0"),
            ("box size='0.2 0 0.1'", "size=\"0.2 0 0.1\" in the box of link `l0` must be greater than 0"),
            ("box size='0.2 NaN 0.1'", "is not three finite numbers"),
            ("sphere radius='-0.1'", "radius=\"-0.1\" in the sphere of link `l0` must be greater than 0"),
            ("sphere radius='0'", "radius=\"0\" in the sphere of link `l0` must be greater than 0"),
            ("sphere radius='inf'", "is not a finite number"),
        ] {
            refused(&biped("", &format!("<collision><geometry><{shape}/></geometry></collision>"), ""), words);
            if shape.starts_with("box") {
                refused(&biped("", &format!("<visual><geometry><{shape}/></geometry></visual>"), ""), words);
            }
        }
    }

    #[test]
    fn several_offenders_are_named_at_once() {
        let mesh = "<collision><geometry><mesh filename='a'/></geometry></collision>";
        refused(
            &biped("", mesh, ""),
            "the collision of `l0` has a mesh, `l1` has a mesh, `l2` has a mesh, `l3` has a mesh, `l4` has a mesh, `l5` has a mesh and 3 more, but",
        );
        let turned = biped("", "", "").replace("<origin xyz='0 0 -0.2'/>", "<origin xyz='0 0 -0.2' rpy='1 0 0'/>");
        refused(
            &turned,
            "joint `j2`, joint `j3`, joint `j4`, joint `j6`, joint `j7`, joint `j8` have a rotated origin",
        );
        let products = biped("", "", "").replacen("iyy", "ixy='1' iyy", 2);
        refused(&products, "ixy of `l0` is 1, ixy of `l1` is 1, not 0");
        refused(
            &biped("", "", "").replacen("<inertial>", "<Inertial>", 2).replacen("</inertial>", "</Inertial>", 2),
            "`l0`, `l1` have no inertial",
        );
    }

    #[test]
    fn another_kind_of_robot_hears_so_before_anything_else() {
        let bad = "<mimic joint='j1'/><limit lower='0' upper='1' effort='1'/>";
        let chain = |links: usize| {
            let link: String = (0..links).map(|k| format!("<link name='a{k}'/>")).collect();
            let joint = |k: usize| {
                format!(
                    "<joint name='b{k}' type='revolute'><parent link='a{}'/><child link='a{k}'/>{bad}</joint>",
                    k - 1
                )
            };
            format!("<robot name='r'>{link}{}</robot>", (1..links).map(joint).collect::<String>())
        };
        let rule = "but a robot here is a trunk with two legs of four joints each";
        refused(&chain(3), &format!("the leg that begins with `a1` has 2 joints, {rule}"));
        refused(&chain(20_000), &format!("there are 19999 joints that move, {rule}"));
        let extra = "<link name='x'/><joint name='y' type='revolute'><parent link='l0'/><child link='x'/></joint>";
        refused(&biped(bad, "", extra), "there are 9 joints that move");
        refused("<robot name='r'/>", "the file has no link with mass");
        refused(
            &biped("", "", "<link name='x'><collision/></link>"),
            "2 links hang on no joint, but only the trunk must hang on none: `l0`, `x`",
        );
        refused(
            &biped("", "", "")
                .replace("<parent link='l0'/><child link='l1'/>", "<parent link='l4'/><child link='l1'/>"),
            "circle",
        );
    }

    /// Work that grows with the square of the number of links would take hours.
    #[test]
    fn a_long_chain_of_fixed_links_is_read_at_once() {
        let frames: String =
            (1..50_000).map(|k| frame(&format!("f{k}"), &format!("f{}", k - 1), "xyz='0 0 1'", "")).collect();
        assert_eq!(read(&biped("", "", &(frame("f0", "l0", "", "") + &frames))), read(&biped("", "", "")));
        let attributes: String = (0..50_000).map(|k| format!(" a{k}=''")).collect();
        refused(
            &format!("<robot{attributes}/>"),
            "an element has about 50000 attributes, but an element may have at most 1000",
        );
    }

    #[test]
    fn a_joint_without_a_type_and_a_macro_are_named() {
        refused(&biped("", "", "").replacen(" type='continuous'", "", 1), "joint `j1` has no type");
        refused("<!DOCTYPE robot []><robot/>", "the file has a document type");
    }
}
