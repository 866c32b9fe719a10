//! A contact problem, and the check of its numbers.

use super::tolerance::ASYMMETRY;
use serde::{Deserialize, Serialize};

/// Greatest number of contacts, and upper limit of their identities.
const MAX_CONTACTS: usize = 1 << 12;

/// One contact problem, `v = A f + b`.
///
/// Rows are contact-major: for each contact its normal, then its tangents. The first tangent is the direction of the free slip, so b =
/// (v_N, v_s >= 0, 0). Other tangents are allowed, but the four-sided cone of two tangents is exact only along these.
///
/// # Source
/// (12)-(14): A = KᵀH⁻¹K and b = Kᵀ(xdot + H⁻¹Δf_b).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Problem {
    /// Number of touching contacts.
    pub contacts: usize,
    /// Tangents per contact: 1 or 2.
    pub tangents: usize,
    /// Stable identity of each contact, a small number, by which the memory finds it in the next step.
    pub id: Vec<usize>,
    /// Delassus matrix A, row-major, m by m with m = contacts·(1 + tangents) [1/kg].
    pub delassus: Vec<f64>,
    /// Contact velocity without contact impulse, b [m/s].
    pub drift: Vec<f64>,
    /// Coulomb friction coefficient of each contact [-].
    pub friction: Vec<f64>,
    /// Allowed approach of each contact: the speed that closes its gap within the step, max(gap, 0)/h. For a contact that bounces, e v_N
    /// instead, where v_N is its negative normal velocity before the impact and e the coefficient of restitution [m/s].
    pub approach: Vec<f64>,
    /// Height of each contact above the ground, negative inside it; used by `SpringDamper` [m].
    pub gap: Vec<f64>,
    /// Contact velocity before the step, rows as in `drift`; used by `SpringDamper` [m/s].
    pub before: Vec<f64>,
    /// Spring and damper of each contact; used by `SpringDamper`.
    pub spring: ContactSpring,
    /// Link of each contact. Contacts of one link are listed together and can stick as a patch. May be empty.
    #[serde(default)]
    pub link: Vec<usize>,
    /// Given unit direction of slip of each contact, along the tangents. Friction acts against it at every velocity. A contact whose slip
    /// is steady has one. It is zero for a contact without, and the list is empty if no contact has one.
    #[serde(default)]
    pub slip: Vec<[f64; 2]>,
}

/// Parameters of `SpringDamper`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactSpring {
    /// k [N/m].
    pub stiffness: f64,
    /// Damping ratio ζ; 1 is critical for the mass of the contact point by itself [-].
    pub damping_ratio: f64,
    /// Step over which the force acts [s].
    pub h: f64,
}

impl Problem {
    /// Resets to a problem of this size with all numbers zero. It allocates only if the problem is larger than any before.
    pub fn reset(&mut self, contacts: usize, tangents: usize) {
        self.reset_rows(contacts, tangents);
        self.delassus.resize(self.rows() * self.rows(), 0.0);
    }

    /// The same, but A is left empty.
    pub(crate) fn reset_rows(&mut self, contacts: usize, tangents: usize) {
        (self.contacts, self.tangents) = (contacts, tangents);
        let m = self.rows();
        let zeros = |buffer: &mut Vec<f64>, length| {
            buffer.clear();
            buffer.resize(length, 0.0);
        };
        self.delassus.clear();
        zeros(&mut self.drift, m);
        zeros(&mut self.friction, contacts);
        zeros(&mut self.approach, contacts);
        zeros(&mut self.gap, contacts);
        zeros(&mut self.before, m);
        self.id.clear();
        self.id.extend(0..contacts);
        self.link.clear();
        self.slip.clear();
    }

    /// The given direction of slip of a contact, or zero.
    pub(crate) fn given_slip(&self, i: usize) -> [f64; 2] {
        self.slip.get(i).copied().unwrap_or_default()
    }

    /// The same problem with the first `tangents` tangents of each contact only.
    pub fn narrowed(&self, tangents: usize) -> Problem {
        let keeps = |row: &usize| row % (1 + self.tangents) <= tangents;
        let rows: Vec<usize> = (0..self.rows()).filter(keeps).collect();
        let mut narrow = Problem { tangents: tangents.min(self.tangents), ..self.clone() };
        narrow.drift = rows.iter().map(|&row| self.drift[row]).collect();
        narrow.before = rows.iter().map(|&row| self.before[row]).collect();
        narrow.delassus =
            rows.iter().flat_map(|&row| rows.iter().map(move |&k| self.delassus[row * self.rows() + k])).collect();
        narrow
    }

    /// Checks that the numbers are those of a contact problem.
    ///
    /// # Errors
    /// One sentence that names the wrong number.
    pub fn check(&self) -> Result<(), String> {
        if !(1..=2).contains(&self.tangents) {
            return Err(format!("tangents = {}, but it must be 1 or 2", self.tangents));
        }
        if self.contacts > MAX_CONTACTS {
            return Err(format!("contacts = {}, but there may be {MAX_CONTACTS} at most", self.contacts));
        }
        let m = self.rows();
        let lengths = [
            ("id", self.id.len(), self.contacts),
            ("delassus", self.delassus.len(), m * m),
            ("drift", self.drift.len(), m),
            ("friction", self.friction.len(), self.contacts),
            ("approach", self.approach.len(), self.contacts),
            ("gap", self.gap.len(), self.contacts),
            ("before", self.before.len(), m),
        ];
        for (name, length, right) in lengths {
            if length != right {
                let (contacts, tangents) = (self.contacts, self.tangents);
                return Err(format!(
                    "{name} has {length} numbers, but {right} are needed for contacts = {contacts}, tangents = {tangents}"
                ));
            }
        }
        for (name, length) in [("link", self.link.len()), ("slip", self.slip.len())] {
            if length != 0 && length != self.contacts {
                return Err(format!(
                    "{name} has {length} entries, but it must have none or contacts = {}",
                    self.contacts
                ));
            }
        }
        if let Some(id) = self.id.iter().find(|id| **id >= MAX_CONTACTS) {
            return Err(format!("id {id} is not below {MAX_CONTACTS}"));
        }
        if let Some(i) = (1..self.contacts).find(|&i| self.id[..i].contains(&self.id[i])) {
            return Err(format!("id {} occurs twice", self.id[i]));
        }
        let lists = [&self.delassus, &self.drift, &self.friction, &self.approach, &self.gap, &self.before];
        if !lists.into_iter().flatten().all(|number| number.is_finite()) {
            return Err("every number must be finite".into());
        }
        if self.friction.iter().any(|mu| *mu < 0.0) {
            return Err("friction must not be negative".into());
        }
        let at = |i: usize, j: usize| self.delassus[i * m + j];
        let asymmetric =
            (0..m).any(|i| (0..i).any(|j| (at(i, j) - at(j, i)).abs() > ASYMMETRY * (at(i, i) * at(j, j)).sqrt()));
        if asymmetric || (0..m).any(|i| at(i, i) < 0.0) {
            return Err("delassus must be symmetric and not negative on its diagonal".into());
        }
        Ok(())
    }

    /// Number of rows m.
    pub fn rows(&self) -> usize {
        self.contacts * (1 + self.tangents)
    }
}
