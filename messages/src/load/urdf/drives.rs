//! The drives of a URDF file. Those of all joints must be equal; only the damping may differ from joint to joint.

use super::super::listed::{listed, quoted};
use super::links::Rigid;
use super::xml::{Parsed, attribute, child, children, number, optional};
use crate::robot::{Body, DriveParameters};
use roxmltree::Node;
use std::collections::BTreeMap;

/// The drives of the joints that move. If their damping differs, each body keeps that of its joint.
pub(super) fn read(root: Node, joints: &[Node], rigid: &[Rigid], bodies: &mut [Body]) -> Parsed<DriveParameters> {
    let damping = |joint: &Node| child(*joint, "dynamics").map_or(Ok(0.0), |node| optional(node, "damping", 0.0));
    let dampings: Vec<f64> = joints.iter().map(damping).collect::<Parsed<_>>()?;
    let common = dampings.first().copied().filter(|first| dampings.iter().all(|value| value == first));
    if common.is_none() {
        for (own, body) in rigid.iter().zip(bodies) {
            let damping =
                own.joint.as_ref().and_then(|joint| dampings.get(joints.iter().position(|other| other == joint)?));
            body.joint.iter_mut().zip(damping).for_each(|(joint, own)| joint.damping = *own);
        }
    }
    let names: Vec<&str> = joints.iter().map(|joint| attribute(*joint, "name")).collect::<Parsed<_>>()?;
    let efforts = joints.iter().map(|joint| child(*joint, "limit").map(|limit| number(limit, "effort")).transpose());
    let rotors = rotors(root)?;
    if let Some(other) = rotors.keys().find(|name| !names.contains(name)) {
        return Err(format!("a transmission drives joint `{other}`, which does not move or is not in the file"));
    }
    let inertias: Vec<Option<f64>> = names.iter().map(|name| rotors.get(name).copied()).collect();
    Ok(DriveParameters {
        inertia: require_common("rotor_inertia", &names, &inertias)?,
        damping: common.or(Some(0.0)),
        torque_limit: require_common("effort", &names, &efforts.collect::<Parsed<Vec<_>>>()?)?,
        encoder_bits: None,
    })
}

/// Reflected inertia of each drive for which the file gives one: rotor inertia times the square of the gear ratio.
fn rotors<'a>(root: Node<'a, 'a>) -> Parsed<BTreeMap<&'a str, f64>> {
    let mut rotors = BTreeMap::new();
    for transmission in children(root, "transmission") {
        for actuator in children(transmission, "actuator") {
            let Some(rotor) = child(actuator, "rotor_inertia") else { continue };
            let ratio = child(actuator, "gear_ratio").map_or(Ok(1.0), |gear| number(gear, "value"))?;
            let inertia = number(rotor, "value")? * ratio.powi(2);
            for joint in children(transmission, "joint") {
                let name = attribute(joint, "name")?;
                if rotors.insert(name, inertia).is_some() {
                    return Err(format!("two actuators with rotor_inertia drive joint `{name}`, but it can have one"));
                }
            }
        }
    }
    Ok(rotors)
}

/// The common value of a quantity that must be equal for all drives, or absent from all.
fn require_common(what: &str, names: &[&str], values: &[Option<f64>]) -> Parsed<Option<f64>> {
    let Some(first) = values.iter().flatten().next().copied() else { return Ok(None) };
    let without: Vec<_> =
        names.iter().zip(values).filter(|(_, value)| value.is_none()).map(|(name, _)| quoted(name)).collect();
    if !without.is_empty() {
        return Err(format!("{what} is not given for joint {}, but all drives must be equal", listed(&without)));
    }
    match names.iter().zip(values.iter().flatten()).find(|(_, value)| **value != first) {
        None => Ok(Some(first)),
        Some((other, value)) => {
            let all = "but all drives must be equal";
            Err(format!("{what} differs between joints ({first} of `{}`, {value} of `{other}`), {all}", names[0]))
        }
    }
}
