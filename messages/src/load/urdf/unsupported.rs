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

use super::super::listed::{listed, quoted};
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
                found.push(quoted(attribute(*joint, "name")?));
            }
        }
        let (verb, joint) = if found.len() == 1 { ("is", "joint") } else { ("are", "joints") };
        if !found.is_empty() {
            return Err(format!("{joint} {} {verb} {what}", listed(&found)));
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
    use super::super::tests::biped;

    /// A biped whose joints have this type and these child elements.
    fn robot(kind: &str, within: &str) -> String {
        biped(within, "", "").replace("continuous", kind)
    }

    fn refused(text: &str) -> String {
        parse(text).err().expect("it must be refused")
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
            let refused = refused(&robot(kind, within));
            let all = "joints `j1`, `j2`, `j3`, `j4`, `j5`, `j6` and 2 more are ";
            assert!(refused.starts_with(all) && refused.contains(words), "{refused}");
        }
        for (kind, within) in [
            ("revolute", "<limit lower='-7' upper='7' effort='1' velocity='1000'/><dynamics friction='0'/>"),
            ("revolute", "<limit effort='1'/>"),
            ("continuous", "<limit lower='0' upper='0' effort='1'/>"),
            ("prismatic", "<limit lower='-10' upper='10' effort='1'/>"),
        ] {
            let rounded = robot(kind, within).replace("ixx='1'", "ixx='1' ixy='1e-18'");
            parse(&rounded.replace("xyz='0 0 -0.2'", "xyz='0 0 -0.2' rpy='0 -1e-17 0'")).expect("rounding errors");
        }
    }

    #[test]
    fn a_joint_that_does_not_move_has_no_properties_to_refuse() {
        let frame = "<link name='f'/><joint name='k' type='fixed'><parent link='l0'/><child link='f'/><dynamics \
                     friction='1'/><limit lower='0' upper='1' effort='1' velocity='1'/><mimic joint='j1'/></joint>";
        parse(&biped("", "", frame)).expect("a biped");
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
                    let refused = refused(&robot(kind, &format!("<{tag} {key}='{value}'/>")));
                    assert_eq!(refused, format!("{key}=\"{value}\" in the {tag} of joint `j1` is not a finite number"));
                }
            }
        }
        for (from, to) in [
            ("axis xyz='0 1 0'", "axis xyz='0 nan 0'"),
            ("origin xyz='0 0 -0.2'", "origin rpy='0 inf 0'"),
            ("value='1'", "value='nan'"),
        ] {
            let refused = refused(&robot("continuous", "").replace(from, to));
            assert!(refused.contains("finite number"), "{refused}");
        }
    }

    #[test]
    fn properties_that_no_number_can_correct_are_named_first() {
        let both = "<mimic joint='k'/><dynamics friction='1'/><limit lower='0' upper='1' effort='1'/>";
        assert!(refused(&robot("revolute", both)).contains("mimic"));
    }

    #[test]
    fn all_shapes_of_a_collision_count_and_others_are_refused() {
        let with = |shapes: &str| biped("", "", "").replacen("</link>", &format!("{shapes}</link>"), 1);
        let shape = |shape: &str| format!("<collision><geometry>{shape}</geometry></collision>");
        let [good, ball] = ["<box size='1 1 1'/>", "<sphere radius='1'/>"].map(shape);
        for (bad, what) in [
            ("<mesh filename='package://r/foot.stl'/>", "mesh"),
            ("<cylinder radius='1' length='1'/>", "cylinder"),
            ("<capsule radius='1' length='1'/>", "capsule"),
        ] {
            let rule = "only spheres and boxes touch the ground here: use them, or remove the collision";
            let sentence = format!("the collision of `l0` has a {what}, but {rule}");
            assert_eq!(refused(&with(&(good.clone() + &shape(bad)))), sentence);
        }
        let body = &parse(&with(&(good + &ball))).expect("a robot").robot.bodies[0];
        assert_eq!((body.contacts.len(), body.spheres.len()), (4, 1), "all shapes count");
    }

    #[test]
    fn drives_of_which_only_some_are_given_or_that_differ_are_refused_by_name() {
        let file = |last: &str| {
            biped("<limit effort='5'/>", "", "").replace("j8", "heel").replacen(
                "<axis xyz='1 0 0'/><limit effort='5'/></joint></robot>",
                &format!("<axis xyz='1 0 0'/>{last}</joint></robot>"),
                1,
            )
        };
        let same = parse(&file("<limit effort='5'/>")).expect("a robot").robot;
        assert_eq!(same.drives.torque_limit, Some(5.0));
        assert_eq!(refused(&file("")), "effort is not given for joint `heel`, but all drives must be equal");
        let differs = "effort differs between joints (5 of `j1`, 6 of `heel`), but all drives must be equal";
        assert_eq!(refused(&file("<limit effort='6'/>")), differs);
        let rotor = |joint: &str| {
            format!(
                "<transmission><joint name='{joint}'/><actuator><rotor_inertia value='1'/></actuator></transmission>"
            )
        };
        let rotors = |count: usize| biped("", "", &(1..=count).map(|k| rotor(&format!("j{k}"))).collect::<String>());
        assert_eq!(parse(&rotors(8)).expect("a robot").robot.drives.inertia, Some(1.0));
        assert!(refused(&rotors(7)).starts_with("rotor_inertia is not given for joint `j8`"));
        assert!(
            refused(&biped("", "", &rotor("j1").repeat(2)))
                .starts_with("two actuators with rotor_inertia drive joint `j1`")
        );
        assert!(refused(&biped("", "", &rotor("knee"))).starts_with("a transmission drives joint `knee`, which"));
    }
}
