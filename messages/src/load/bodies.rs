//! Rules for bodies: what each must be, and that they hang together as a tree.

use super::check::{Checked, Validator};
use crate::robot::Body;
use crate::wire::{CONTACTS, JOINTS};
use std::collections::BTreeSet;

impl Validator<'_> {
    pub(super) fn known_body(&self, bodies: &[Body], key: &str, name: &str) -> Checked {
        let names: Vec<_> = bodies.iter().map(|body| body.name.as_str()).collect();
        let rule = format!("it must be empty or one of {}", names.join(", "));
        self.require(name.is_empty() || names.contains(&name), key, format!("{name:?}"), rule)
    }

    /// Every body, their tree, and how many joints and points there are.
    pub(super) fn bodies(&self, bodies: &[Body]) -> Checked {
        self.require(!bodies.is_empty(), "bodies", "[]", "a scene needs at least one body")?;
        let names: BTreeSet<_> = bodies.iter().map(|body| body.name.as_str()).collect();
        for (i, body) in bodies.iter().enumerate() {
            let key = |field: &str| format!("bodies.{}.{field}", body.name);
            self.require(!body.name.is_empty(), &format!("bodies.{i}.name"), "\"\"", "every body needs a name")?;
            let twice = bodies[..i].iter().any(|other| other.name == body.name);
            self.require(!twice, &format!("bodies.{i}.name"), format!("\"{}\"", body.name), "names must differ")?;
            self.positive(&key("mass"), body.mass)?;
            body.size.iter().try_for_each(|&side| self.positive(&key("size"), side))?;
            body.moments().iter().try_for_each(|&moment| self.positive(&key("inertia"), moment))?;
            let [a, b, c] = body.moments();
            let solid = 2.0 * a.max(b).max(c) <= (a + b + c) * (1.0 + 1e-9);
            let rule = "of the moments of a body none exceeds the sum of the other two";
            self.require(solid, &key("inertia"), format!("{:?}", [a, b, c]), rule)?;
            if let Some(joint) = &body.joint {
                let rule = format!("it must be another body: {}", names.iter().copied().collect::<Vec<_>>().join(", "));
                let known = names.contains(joint.parent.as_str()) && joint.parent != body.name;
                self.require(known, &key("joint.parent"), format!("{:?}", joint.parent), rule)?;
                let length = joint.axis.iter().map(|c| c * c).sum::<f64>().sqrt();
                let rule = "an axis must be a unit vector";
                self.require((length - 1.0).abs() < 1e-9, &key("joint.axis"), format!("{:?}", joint.axis), rule)?;
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
        self.tree(bodies)?;
        let joints = bodies.iter().filter(|body| body.joint.is_some()).count();
        let rule = format!("the messages carry at most {JOINTS} of them");
        self.require(joints <= JOINTS, "number of joints", joints, rule)?;
        let contacts = bodies.iter().map(|body| body.contact_spheres().count()).sum::<usize>();
        let rule = format!("the messages carry at most {CONTACTS} of them");
        self.require(contacts <= CONTACTS, "number of contact points and balls", contacts, rule)
    }

    /// One base, and every body hangs from it.
    fn tree(&self, bodies: &[Body]) -> Checked {
        let bases: Vec<_> = bodies.iter().filter(|body| body.joint.is_none()).map(|body| &*body.name).collect();
        let rule = "exactly one body, the base, must be without a joint";
        self.require(bases.len() == 1, "bodies without a joint", format!("[{}]", bases.join(", ")), rule)?;
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
}
