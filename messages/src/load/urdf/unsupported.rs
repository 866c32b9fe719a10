//! Properties of URDF joints that this simulator does not model. They would change the motion of the robot, so a file that uses them is
//! refused.
//!
//! | property | accepted if |
//! |---|---|
//! | `type` | `revolute`, `continuous`, `prismatic`, `fixed` |
//! | `mimic`, `safety_controller` | absent |
//! | `lower`, `upper` | out of reach: [`FREE_ANGLE`], [`FREE_TRAVEL`] |
//! | `velocity` | out of reach: [`FREE_SPEED`] |
//! | `friction` | 0 |

use super::xml::{Parsed, attribute, child, optional};
use roxmltree::Node;
use std::f64::consts::TAU;

/// A leg cannot reach a stop beyond a whole turn [rad].
const FREE_ANGLE: f64 = TAU;
/// A prismatic joint cannot reach a stop beyond this [m].
const FREE_TRAVEL: f64 = 10.0;
/// No leg reaches this speed [rad/s or m/s]. The fastest drives of robots reach 30 to 50.
const FREE_SPEED: f64 = 100.0;

/// Refuses the file if a joint has such a property. One sentence names all joints with the first property found. Properties that no
/// change of numbers can correct come first.
pub(super) fn refuse(joints: &[Node]) -> Parsed<()> {
    let kinds: [(&str, JointTest); 6] = [
        (
            "neither revolute, continuous, prismatic nor fixed, but a joint must have one axis of rotation or translation",
            is_of_another_type,
        ),
        ("coupled (mimic), but joints move independently here: remove `mimic`, or make the joint fixed", |joint| {
            Ok(child(joint, "mimic").is_some())
        }),
        (
            "limited by a safety_controller, which is not modelled: remove it, or make it part of the controller",
            |joint| Ok(child(joint, "safety_controller").is_some()),
        ),
        ("subject to dry friction, but joints have only damping here: set `friction` to 0", has_friction),
        (
            "limited by stops (lower, upper), but joints have no stops here: use the type `continuous`, or limits of 10 m and more for a prismatic joint",
            has_stops,
        ),
        ("limited in speed (velocity), but drives have only a torque limit here: set `velocity` to 1000", is_slow),
    ];
    for (what, check) in kinds {
        let mut found = vec![];
        for joint in joints {
            if check(*joint)? {
                found.push(format!("`{}`", attribute(*joint, "name")?));
            }
        }
        let (verb, joint) = if found.len() == 1 { ("is", "joint") } else { ("are", "joints") };
        if !found.is_empty() {
            return Err(format!("{joint} {} {verb} {what}", found.join(", ")));
        }
    }
    Ok(())
}

type JointTest = fn(Node) -> Parsed<bool>;

fn is_of_another_type(joint: Node) -> Parsed<bool> {
    Ok(!matches!(attribute(joint, "type")?, "revolute" | "continuous" | "prismatic" | "fixed"))
}

fn has_friction(joint: Node) -> Parsed<bool> {
    child(joint, "dynamics").map_or(Ok(false), |dynamics| Ok(optional(dynamics, "friction", 0.0)? != 0.0))
}

fn has_stops(joint: Node) -> Parsed<bool> {
    let Some(limit) = child(joint, "limit") else { return Ok(false) };
    let (lower, upper) = (optional(limit, "lower", 0.0)?, optional(limit, "upper", 0.0)?);
    let far = match attribute(joint, "type")? {
        "revolute" => FREE_ANGLE,
        "prismatic" => FREE_TRAVEL,
        _ => return Ok(false), // a continuous joint has no stops, even if the file has limits
    };
    // By the format a missing limit is 0. If both are missing, the joint has no stops.
    let has_limits = ["lower", "upper"].iter().any(|key| limit.attribute(*key).is_some());
    Ok(has_limits && (lower > -far || upper < far))
}

fn is_slow(joint: Node) -> Parsed<bool> {
    child(joint, "limit").map_or(Ok(false), |limit| Ok(optional(limit, "velocity", FREE_SPEED)? < FREE_SPEED))
}

#[cfg(test)]
mod tests {
    use super::super::parse;

    /// A robot of two links whose joint has this type and these child elements.
    fn robot(kind: &str, within: &str) -> String {
        let link = |name| {
            format!(
                "<link name='{name}'><inertial><mass value='1'/><inertia ixx='1' ixy='1e-18' iyy='1' izz='1'/></inertial></link>"
            )
        };
        format!(
            "<robot name='r'>{}{}<joint name='j' type='{kind}'><parent link='a'/><child link='b'/><axis xyz='0 1 0'/>\
             <origin xyz='0 0 0' rpy='0 -1e-17 0'/>{within}</joint></robot>",
            link("a"),
            link("b")
        )
    }

    #[test]
    fn unsupported_properties_are_refused_unless_they_are_out_of_reach() {
        for (kind, within, words) in [
            ("floating", "", "neither revolute"),
            ("revolute", "<mimic joint='k'/>", "mimic"),
            ("revolute", "<safety_controller k_velocity='1'/>", "safety_controller"),
            ("revolute", "<dynamics friction='0.1'/>", "friction"),
            ("revolute", "<limit lower='-1' upper='100' effort='1'/>", "stops"),
            ("revolute", "<limit upper='100' effort='1'/>", "stops"),
            ("prismatic", "<limit lower='-1' upper='1' effort='1'/>", "stops"),
            ("continuous", "<limit effort='1' velocity='12'/>", "velocity"),
        ] {
            let refused = parse(&robot(kind, within)).expect_err(words);
            assert!(refused.starts_with("joint `j` is ") && refused.contains(words), "{refused}");
        }
        for (kind, within) in [
            ("revolute", "<limit lower='-7' upper='7' effort='1' velocity='1000'/><dynamics friction='0'/>"),
            ("revolute", "<limit effort='1'/>"),
            ("continuous", "<limit lower='0' upper='0' effort='1'/>"),
            ("prismatic", "<limit lower='-10' upper='10' effort='1'/>"),
        ] {
            parse(&robot(kind, within)).expect("a robot with rounding errors");
        }
    }

    #[test]
    fn values_that_are_not_finite_are_refused() {
        for kind in ["revolute", "continuous"] {
            for (tag, key) in [
                ("limit", "effort"),
                ("limit", "velocity"),
                ("limit", "lower"),
                ("limit", "upper"),
                ("dynamics", "damping"),
                ("dynamics", "friction"),
            ] {
                for value in ["nan", "inf", "-inf", "1e999"] {
                    let refused = parse(&robot(kind, &format!("<{tag} {key}='{value}'/>"))).expect_err(value);
                    assert_eq!(refused, format!("{key}=\"{value}\" in the {tag} of joint `j` is not a finite number"));
                }
            }
        }
        for (from, to) in [("0 1 0", "0 nan 0"), ("0 -1e-17 0", "0 inf 0"), ("value='1'", "value='nan'")] {
            let refused = parse(&robot("continuous", "").replace(from, to)).expect_err(to);
            assert!(refused.contains("finite number"), "{refused}");
        }
    }

    #[test]
    fn properties_that_no_number_can_correct_are_named_first() {
        let both = "<mimic joint='k'/><dynamics friction='1'/><limit lower='0' upper='1' effort='1'/>";
        assert!(parse(&robot("revolute", both)).expect_err("coupled").contains("mimic"));
    }

    #[test]
    fn collisions_that_cannot_be_modelled_are_refused() {
        let with = |shapes: &str| robot("continuous", "").replacen("</link>", &format!("{shapes}</link>"), 1);
        let shape = |shape: &str| format!("<collision><geometry>{shape}</geometry></collision>");
        let [good, ball] = ["<box size='1 1 1'/>", "<sphere radius='1'/>"].map(shape);
        for (bad, what) in [
            ("<mesh filename='package://r/foot.stl'/>", "mesh"),
            ("<cylinder radius='1' length='1'/>", "cylinder"),
            ("<capsule radius='1' length='1'/>", "capsule"),
        ] {
            let refused = parse(&with(&(good.clone() + &shape(bad)))).expect_err(what);
            assert_eq!(
                refused,
                format!(
                    "the collision of `a` has a {what}, but only spheres and boxes touch the ground here: use them, or remove it"
                )
            );
        }
        let body = &parse(&with(&(good + &ball))).expect("a robot").bodies[0];
        assert_eq!((body.contacts.len(), body.spheres.len()), (4, 1), "all shapes count");
    }

    #[test]
    fn drives_of_which_only_some_are_given_are_refused() {
        let joint = |name: &str, within: &str| {
            format!("<joint name='{name}' type='continuous'><parent link='a'/><child link='{name}'/>{within}</joint>")
        };
        let link = |name: &str| {
            format!(
                "<link name='{name}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>"
            )
        };
        let limit = "<limit effort='5'/>";
        let file = |second: &str| {
            let parts = [link("a"), link("b"), link("c"), joint("b", limit), joint("c", second)];
            format!("<robot name='r'>{}</robot>", parts.concat())
        };
        assert_eq!(parse(&file(limit)).expect("a robot").drives.torque_limit, Some(5.0));
        let refused = parse(&file("")).expect_err("one without");
        assert_eq!(refused, "effort is given for 1 of 2 joints, but all drives must be equal");
        let refused = parse(&file("<limit effort='6'/>")).expect_err("another one");
        assert!(refused.starts_with("effort differs between joints (5, 6), but"), "{refused}");
    }

    #[test]
    fn rotated_frames_and_products_of_inertia_beyond_rounding_are_refused() {
        let good = robot("continuous", "");
        for (from, to, words) in [("1e-18", "1e-3", "ixy"), ("-1e-17", "1e-3", "rpy")] {
            let refused = parse(&good.replace(from, to)).expect_err(words);
            assert!(refused.contains(words), "{refused}");
        }
    }
}
