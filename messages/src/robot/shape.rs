//! The tree of a biped: a trunk that carries two legs, each a chain of four joints. Values of bodies and joints do not matter here.

use super::Body;
use crate::wire::JOINTS;

/// Number of bodies of one leg.
pub(super) const LEG: usize = 4;
/// What a robot must be, as the end of a sentence.
const RULE: &str =
    "a robot here is a trunk with two legs of four joints each: hip pitch, knee pitch, ankle pitch and ankle roll";

/// Checks that a robot has no more joints than a biped, before any work that takes longer with many.
///
/// # Errors
/// The number of joints and the rule.
pub fn require_few_joints(count: usize) -> Result<(), String> {
    if count <= JOINTS { Ok(()) } else { Err(format!("there are {count} joints that move, but {RULE}")) }
}

/// Checks that bodies are a trunk and one or two legs of four joints. The parents of every body must lead to a body without a joint.
///
/// # Errors
/// What the bodies are instead, and the rule.
pub fn require_biped_tree(bodies: &[Body]) -> Result<(), String> {
    legs(bodies).map(|_| ())
}

/// The trunk and its legs, each from thigh to foot.
pub(super) fn legs(bodies: &[Body]) -> Result<(&Body, Vec<Vec<&Body>>), String> {
    let bases: Vec<&Body> = bodies.iter().filter(|body| body.joint.is_none()).collect();
    let [trunk] = bases[..] else {
        return Err(format!("{} bodies have no joint, but exactly one, the trunk, must have none", bases.len()));
    };
    require_few_joints(bodies.len() - 1)?;
    let hips = children_of(bodies, trunk);
    if hips.is_empty() || hips.len() > 2 {
        return Err(format!("`{}` carries {} legs, but {RULE}", trunk.name, hips.len()));
    }
    let legs = hips.into_iter().map(|hip| leg(bodies, hip)).collect::<Result<Vec<_>, _>>()?;
    match bodies.len() - 1 - legs.len() * LEG {
        0 => Ok((trunk, legs)),
        others => Err(format!("{others} bodies are part of neither the trunk nor a leg")),
    }
}

/// The bodies of a leg: thigh, shank, ankle and foot.
fn leg<'a>(bodies: &'a [Body], hip: &'a Body) -> Result<Vec<&'a Body>, String> {
    let mut leg = vec![hip];
    while let [next, others @ ..] = &children_of(bodies, leg[leg.len() - 1])[..] {
        if !others.is_empty() || leg.len() > bodies.len() {
            let (last, count) = (&leg[leg.len() - 1].name, 1 + others.len());
            return Err(format!("`{last}` carries {count} bodies, but each body of a leg carries at most one: {RULE}"));
        }
        leg.push(next);
    }
    let joints = if leg.len() == 1 { "1 joint".into() } else { format!("{} joints", leg.len()) };
    let fault = format!("the leg that begins with `{}` has {joints}, but {RULE}", hip.name);
    if leg.len() == LEG { Ok(leg) } else { Err(fault) }
}

fn children_of<'a>(bodies: &'a [Body], parent: &Body) -> Vec<&'a Body> {
    bodies.iter().filter(|body| body.joint.as_ref().is_some_and(|joint| joint.parent == parent.name)).collect()
}
