//! Keys of a robot in the words of its URDF file, for error messages.

use crate::robot::Body;

/// What a dotted key names: `bodies.trunk.mass` is the mass of link `trunk`. Bodies are named by name or number.
pub(in super::super) fn of_key(key: &str, bodies: &[Body]) -> String {
    let drive = match key {
        "drives.inertia" => "the rotor_inertia of the drives",
        "drives.damping" => "the damping of the joints",
        "drives.torque_limit" => "the effort of the joints",
        _ => "",
    };
    if !drive.is_empty() {
        return drive.into();
    }
    let Some(rest) = key.strip_prefix("bodies.") else { return format!("the {key}") };
    let by_number =
        rest.split_once('.').and_then(|(index, field)| Some((bodies.get(index.parse::<usize>().ok()?)?, field)));
    let by_name = || bodies.iter().find_map(|body| Some((body, rest.strip_prefix(&*body.name)?.strip_prefix('.')?)));
    let Some((body, field)) = by_number.or_else(by_name) else { return format!("the {key}") };
    let words = match field {
        "inertia.0" => "ixx",
        "inertia.1" => "iyy",
        "inertia.2" => "izz",
        _ => match field.split('.').next().unwrap_or_default() {
            "inertia" => "inertia (ixx, iyy, izz)",
            "com" => "origin of the inertial",
            "size" => "box of the visual",
            "contacts" | "spheres" => "collision",
            "joint" => "joint",
            other => other,
        },
    };
    format!("the {words} of link `{}`", body.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_of_bodies_and_drives_become_elements_of_the_file() {
        let bodies = [Body { name: "l.foot".into(), ..Body::default() }];
        for (key, words) in [
            ("bodies.l.foot.mass", "the mass of link `l.foot`"),
            ("bodies.0.inertia.2", "the izz of link `l.foot`"),
            ("bodies.0.name", "the name of link `l.foot`"),
            ("drives.torque_limit", "the effort of the joints"),
            ("number of contact points and balls", "the number of contact points and balls"),
        ] {
            assert_eq!(of_key(key, &bodies), words);
        }
    }
}
