//! Rules for bodies: the values of each, and the tree that their joints form.

use super::check::{Checked, Validator};
use super::listed::listed;
use crate::robot::Body;
use crate::wire::{CONTACTS, JOINTS};
use std::collections::BTreeSet;

/// Relative deviation of a sum or of a length that counts as rounding [-].
const ROUNDING: f64 = 1e-9;
/// Greatest ratio of the inertias of a scene [-]. Double precision has 16 digits: beyond this ratio the rounding of the greatest inertia
/// exceeds the least.
const MAX_INERTIA_RATIO: f64 = 1e16;

impl Validator<'_> {
    /// Checks the name of a body.
    pub(super) fn known_body(&self, bodies: &[Body], key: &str, name: &str) -> Checked {
        let names: Vec<_> = bodies.iter().map(|body| body.name.as_str()).collect();
        let rule = format!("it must be empty or one of {}", names.join(", "));
        self.require(name.is_empty() || names.contains(&name), key, format!("{name:?}"), rule)
    }

    /// Checks numbers of bodies, joints and contact points, which takes no longer with many of them.
    pub(super) fn numbers(&self, bodies: &[Body]) -> Checked {
        self.require(!bodies.is_empty(), "bodies", "[]", "a scene needs at least one body")?;
        let bases: Vec<_> = bodies.iter().filter(|body| body.joint.is_none()).map(|body| &*body.name).collect();
        let rule = "exactly one body, the base, must be without a joint";
        self.require(bases.len() == 1, "bodies without a joint", format!("[{}]", listed(&bases)), rule)?;
        let joints = bodies.len() - 1;
        let rule = format!("a message holds at most {JOINTS} joints");
        self.require(joints <= JOINTS, "number of joints", joints, rule)?;
        let contacts = bodies.iter().map(|body| body.contacts.len() + body.spheres.len()).sum::<usize>();
        let rule = format!("a message holds at most {CONTACTS} contact points");
        self.require(contacts <= CONTACTS, "number of contact points and balls", contacts, rule)
    }

    /// Checks that names differ, and that the parents of every body lead to the base.
    pub(super) fn tree(&self, bodies: &[Body]) -> Checked {
        let names: BTreeSet<_> = bodies.iter().map(|body| body.name.as_str()).collect();
        for (i, body) in bodies.iter().enumerate() {
            let twice = bodies[..i].iter().any(|other| other.name == body.name);
            self.require(!twice, &format!("bodies.{i}.name"), format!("\"{}\"", body.name), "names must differ")?;
            let Some(joint) = &body.joint else { continue };
            let rule = format!("it must be another body: {}", names.iter().copied().collect::<Vec<_>>().join(", "));
            let known = names.contains(joint.parent.as_str()) && joint.parent != body.name;
            let key = format!("bodies.{}.joint.parent", body.name);
            self.require(known, &key, format!("{:?}", joint.parent), rule)?;
        }
        for body in bodies {
            let mut link = body;
            for _ in 0..bodies.len() {
                let parent = link.joint.as_ref().and_then(|joint| bodies.iter().find(|b| b.name == joint.parent));
                link = parent.unwrap_or(link);
            }
            let rule = "its parents must lead to the base, not in a circle";
            self.require(link.joint.is_none(), &format!("bodies.{}.joint.parent", body.name), &link.name, rule)?;
        }
        Ok(())
    }

    /// Checks the values of every body.
    pub(super) fn bodies(&self, bodies: &[Body]) -> Checked {
        for body in bodies {
            let key = |field: &str| format!("bodies.{}.{field}", body.name);
            self.positive(&key("mass"), body.mass)?;
            body.size.iter().try_for_each(|&side| self.positive(&key("size"), side))?;
            body.moments().iter().try_for_each(|&moment| self.positive(&key("inertia"), moment))?;
            let [a, b, c] = body.moments();
            let physical = 2.0 * a.max(b).max(c) <= (a + b + c) * (1.0 + ROUNDING);
            let rule = "each moment of inertia must be at most the sum of the other two";
            self.require(physical, &key("inertia"), format!("{:?}", [a, b, c]), rule)?;
            if let Some(joint) = &body.joint {
                let length = joint.axis.iter().map(|c| c * c).sum::<f64>().sqrt();
                let rule = "an axis must be a unit vector";
                self.require((length - 1.0).abs() < ROUNDING, &key("joint.axis"), format!("{:?}", joint.axis), rule)?;
                self.not_negative(&key("joint.stiffness"), joint.stiffness)?;
                self.not_negative(&key("joint.damping"), joint.damping)?;
            }
            body.spheres.iter().try_for_each(|ball| self.positive(&key("spheres.radius"), ball.radius))?;
            if let Some(tiles) = body.tiles {
                self.positive(&key("tiles.pitch"), tiles.pitch)?;
                let rule = "tiles must be longer than 0 and no longer than their pitch";
                let fits = tiles.length > 0.0 && tiles.length <= tiles.pitch;
                self.require(fits, &key("tiles.length"), tiles.length, rule)?;
            }
        }
        self.inertia_ratio(bodies)
    }

    /// Checks that double precision resolves the least inertia beside the greatest.
    fn inertia_ratio(&self, bodies: &[Body]) -> Checked {
        let inertias = || bodies.iter().flat_map(|body| body.inertias().map(|inertia| (inertia, body)));
        let least = inertias().min_by(|(a, _), (b, _)| a.total_cmp(b));
        let greatest = inertias().max_by(|(a, _), (b, _)| a.total_cmp(b));
        let Some(((least, light), (greatest, heavy))) = least.zip(greatest) else { return Ok(()) };
        let value = format!("inertias of {least:.1e} kg ({}) and {greatest:.1e} kg ({})", light.name, heavy.name);
        let rule = format!(
            "masses, and moments of inertia over the squared reach of their body, must differ by less than {MAX_INERTIA_RATIO:e}: double \
             precision loses the lesser"
        );
        self.require(greatest <= MAX_INERTIA_RATIO * least, "bodies", value, rule)
    }
}
