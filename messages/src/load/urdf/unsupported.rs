//! What a URDF file may say that joints here do not have. It changes how the robot moves, so it is refused, never dropped.
//!
//! | from | is accepted if |
//! |---|---|
//! | `type` | `revolute`, `continuous`, `prismatic`, `fixed` |
//! | `mimic`, `safety_controller` | there is none |
//! | `lower`, `upper` | the joint never gets there: [`TURN`], [`FAR`] |
//! | `velocity` | no drive is so fast: [`FAST`] |
//! | `friction` | it is 0 |

use super::{Node, Parsed, attribute, child, optional};
use std::f64::consts::TAU;

/// A stop beyond a whole turn is none for a leg [rad].
const TURN: f64 = TAU;
/// Nor is one beyond this for a slide [m].
const FAR: f64 = 10.0;
/// A limit of the speed that no leg reaches [rad/s or m/s]: the fastest drives of robots have 30 to 50.
const FAST: f64 = 100.0;

/// Refuses it, all joints of the first kind that is found in one sentence; what no edit of numbers can mend is first.
pub(super) fn refuse(joints: &[Node]) -> Parsed<()> {
    let kinds: [(&str, JointTest); 6] = [
        (
            "neither revolute, continuous, prismatic nor fixed, but joints here turn or slide about one axis",
            is_of_another_type,
        ),
        ("coupled (mimic), but joints here move by themselves: leave out `mimic`, or fix the joint", |joint| {
            Ok(child(joint, "mimic").is_some())
        }),
        (
            "limited by a safety_controller, which is not modelled: leave it out, or make it part of the controller",
            |joint| Ok(child(joint, "safety_controller").is_some()),
        ),
        ("subject to dry friction, but joints here have damping alone: set `friction` to 0", has_friction),
        (
            "limited by stops (lower, upper), but joints here have none: make them `continuous`, or a slide's limits 10 m and more",
            has_stops,
        ),
        ("limited in speed (velocity), but drives here are limited in torque alone: set `velocity` to 1000", is_slow),
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
    let far = match attribute(joint, "type")? {
        "revolute" => TURN,
        "prismatic" => FAR,
        _ => return Ok(false), // a continuous joint has none, whatever is written
    };
    // without a number a stop is at 0, as the format says; but where both are missing none is meant
    let meant = ["lower", "upper"].iter().any(|key| limit.attribute(*key).is_some());
    Ok(meant && (optional(limit, "lower", 0.0)? > -far || optional(limit, "upper", 0.0)? < far))
}

fn is_slow(joint: Node) -> Parsed<bool> {
    child(joint, "limit").map_or(Ok(false), |limit| Ok(optional(limit, "velocity", f64::INFINITY)? < FAST))
}

#[cfg(test)]
mod tests {
    use super::super::parse;

    /// A robot of two links, whose joint is of this type and has this within.
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
    fn what_joints_do_not_have_is_refused_and_what_they_never_meet_is_not() {
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
            parse(&robot(kind, within)).expect("a robot, for all the rounding in it");
        }
    }

    #[test]
    fn what_no_number_mends_is_named_first() {
        let both = "<mimic joint='k'/><dynamics friction='1'/><limit lower='0' upper='1' effort='1'/>";
        assert!(parse(&robot("revolute", both)).expect_err("coupled").contains("mimic"));
    }

    #[test]
    fn turned_frames_and_products_of_inertia_beyond_rounding_are_refused() {
        let good = robot("continuous", "");
        for (from, to, words) in [("1e-18", "1e-3", "ixy"), ("-1e-17", "1e-3", "rpy")] {
            let refused = parse(&good.replace(from, to)).expect_err(words);
            assert!(refused.contains(words), "{refused}");
        }
    }
}
