//! Contact with the ground: which impulse f makes the velocity after the step, v = A f + b, obey the contact law?
//!
//! | law | conditions | method |
//! |---|---|---|
//! | `EnergyQp` | the minimum of (14) under (15), (16), as printed | principal pivoting (`energy_qp`) |
//! | `EnergyQpGap` | the same with two tangents and v_N + gap/h >= mu |v_F|, as convex engines have it \[1\] | the same |
//! | `Complementarity` | (17)-(22), one tangent | the program, shifted along a path; Lemke in 16 and 32 digits (`solver`) |
//! | `Aligned` | (17)-(22), two tangents, landing at the ground | the same |
//! | `Facets(d)` | (17)-(22), d directions fixed in the world \[2\] | semismooth Newton (`newton`), the same behind it |
//! | `Cone` | (17)-(22), round cone \[3\] | the same (`cones`) |
//! | `FixedPoint(Tresca)`, `(Aclm)` | the same as the limit of energy minima \[4\] | `fixed_point` |
//! | `ConeQp` | the minimum of (14) over round cones | interior points, clarabel (`cone_qp`) |
//! | `Lagged` | that with |f_F| <= mu f_N of the step before \[5\] | semismooth Newton (`newton`) |
//! | `Sweep(n)` | `Cone`, as near as n sweeps come \[6\] | projected Gauss-Seidel (`sweep`) |
//! | `SpringDamper` | none: springs, dampers, regularised friction | a formula (`spring_damper`) |
//!
//! The first four laws find a complementary basis: which contacts are open, stick, or slide which way. The impulse of a
//! basis is then computed afresh from A and b (`basis`), and it is accepted by its residual alone (`residual`), so a basis
//! remembered from the last step is where most ways begin and the outcome is right however it was found (`solver`). The others start
//! from the last impulse; their cones are round, and so are their residuals (`round`).
//!
//! \[1\] Anitescu 2006; Tasora & Anitescu 2011; Todorov 2011. \[2\] Stewart & Trinkle 1996; Anitescu & Potra 1997.
//! \[3\] De Saxcé & Feng 1998; Alart & Curnier 1991. \[4\] Haslinger 1983; Acary, Cadoux, Lemaréchal & Malick 2011.
//! \[5\] Lötstedt 1984. \[6\] Moreau 1999; Jourdan, Alart & Jean 1998.
//!
//! The paper takes (17)-(22) for the conditions of its program (14)-(16). They are not: with multipliers the program gives
//! f_N (v_N - mu |v_F|) = 0 in place of (19), so whatever slides is thrown up. See docs/PAPER.md.

mod basis;
mod certificate;
mod cone_qp;
mod cones;
mod coulomb;
mod dictionary;
mod energy_qp;
mod facets;
mod fixed_point;
mod lemke;
mod memory;
mod newton;
mod pivoted;
mod project;
mod residual;
mod round;
mod scaled;
mod solver;
mod spring_damper;
mod status;
mod sweep;
mod tolerance;
mod twofold;

pub use memory::Memory;
pub(crate) use residual::relative;
pub(crate) use scaled::YIELD;
pub use solver::Solver;
pub(crate) use tolerance::SOLVED;

use messages::scene::Law;
use serde::{Deserialize, Serialize};

/// Contacts of a problem at most, and numbers of contacts.
const MOST: usize = 1 << 12;

/// One contact step, `v = A f + b`.
///
/// Rows are contact-major: for each contact its normal, then its tangents. The first tangent is the direction of the free
/// slip, so b = (v_N, v_s >= 0, 0); any other choice is solved as well, but the square cone of two tangents is exact only
/// along them.
///
/// # Source
/// (12)-(14): A = K^T H^-1 K and b = K^T (xdot + H^-1 Δf_b).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Problem {
    /// Number of touching contacts.
    pub contacts: usize,
    /// Tangents per contact: 1 or 2.
    pub tangents: usize,
    /// Stable identity of each contact, a small number; carries the memory from step to step.
    pub id: Vec<usize>,
    /// Delassus matrix A, row-major, m by m with m = contacts·(1 + tangents) [1/kg].
    pub delassus: Vec<f64>,
    /// Contact velocity without contact impulse, b [m/s].
    pub drift: Vec<f64>,
    /// Coulomb friction coefficient of each contact [-].
    pub friction: Vec<f64>,
    /// Speed at which each contact would close its gap within the step, max(gap, 0)/h; if it bounces, e v_N of the
    /// velocity before, which is negative [m/s].
    pub approach: Vec<f64>,
    /// Height of each contact above the ground, negative inside it; for `SpringDamper` [m].
    pub gap: Vec<f64>,
    /// Contact velocity before the step, rows as of `drift`; likewise [m/s].
    pub before: Vec<f64>,
    /// The spring of each contact, likewise.
    pub spring: Spring,
    /// Link of each contact: those of one link, listed together, can stick only together. Empty if nobody knows.
    #[serde(default)]
    pub link: Vec<usize>,
    /// Unit direction of slip of each contact, along the tangents, where it is given by a motion that goes on, else zero; empty if it
    /// is given nowhere. Friction then acts against it, whatever the velocity.
    #[serde(default)]
    pub slip: Vec<[f64; 2]>,
}

/// What `SpringDamper` needs to know besides the state of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spring {
    /// k [N/m].
    pub stiffness: f64,
    /// zeta, 1 being critical for the contact point by itself [-].
    pub damping_ratio: f64,
    /// Step over which the force acts [s].
    pub h: f64,
}

impl Problem {
    /// A problem of this size, all zeros. Keeps its buffers: no allocation when it was as large before.
    pub fn reset(&mut self, contacts: usize, tangents: usize) {
        self.reset_rows(contacts, tangents);
        self.delassus.resize(self.rows() * self.rows(), 0.0);
    }

    /// The same without A, which is still to come.
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

    /// The direction of slip of a contact where it is given, else zero.
    pub(crate) fn given_slip(&self, i: usize) -> [f64; 2] {
        self.slip.get(i).copied().unwrap_or_default()
    }

    /// The same contacts with their first `tangents` tangents alone.
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

    /// Whether its numbers are those of a contact problem; if not, which are not.
    ///
    /// # Errors
    /// A sentence.
    pub fn check(&self) -> Result<(), String> {
        if !(1..=2).contains(&self.tangents) {
            return Err(format!("tangents = {}, but it must be 1 or 2", self.tangents));
        }
        if self.contacts > MOST {
            return Err(format!("contacts = {}, but there may be {MOST} at most", self.contacts));
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
        if let Some(id) = self.id.iter().find(|id| **id >= MOST) {
            return Err(format!("id {id} is not below {MOST}"));
        }
        if let Some(i) = (1..self.contacts).find(|&i| self.id[..i].contains(&self.id[i])) {
            return Err(format!("id {} is there twice", self.id[i]));
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
            (0..m).any(|i| (0..i).any(|j| (at(i, j) - at(j, i)).abs() > 1e-9 * (at(i, i) * at(j, j)).sqrt()));
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

/// Tangents that a law resists: its K has `1 + tangents(law)` columns per contact.
pub fn tangents(law: Law) -> usize {
    match law {
        Law::EnergyQp | Law::Complementarity => 1,
        _ => 2,
    }
}

/// Whether the law's own problem ends at a complementary basis, on rays along its tangents, whose impulse is the solution of a
/// linear system: exact to rounding, as `plant.tolerance` asks in every step. The first tangent is the direction of the free slip.
///
/// The other laws come nearer with each iteration and say with `fallback` where they did not come near enough, or evaluate a
/// formula. Their tangents are the world's x and y: a round cone looks the same along any, and an impulse remembered along them
/// means the same in the next step.
pub fn has_basis(law: Law) -> bool {
    matches!(law, Law::EnergyQp | Law::EnergyQpGap | Law::Complementarity | Law::Aligned)
}

/// Whether the law's impulse can never raise the energy.
///
/// A spring gives back what it was compressed with by somebody else, and sweeps that stop early leave a bound of friction
/// behind that is no longer that of their normal impulse.
pub fn is_plastic(law: Law) -> bool {
    !matches!(law, Law::SpringDamper | Law::Sweep(_))
}

/// Whether the law's impulses are Coulomb's however large the slip: no energy program, no springs, no memory of forces.
pub fn is_coulomb(law: Law) -> bool {
    matches!(law, Law::Complementarity | Law::Aligned | Law::Facets(_) | Law::Cone | Law::FixedPoint(_))
}

/// Speed at which contact i may still approach the ground [m/s]: what is added to v_N in (18) and (19).
///
/// The paper's conditions speak of velocity alone, so a contact with a gap is stopped above the ground. The other laws let
/// it close its gap and no more: `0 <= f_N _|_ v_N + gap/h >= 0` lands exactly on the ground. At rest both are the same.
/// Where restitution throws a contact back, it is negative under every law.
fn lift(problem: &Problem, law: Law, i: usize) -> f64 {
    match law {
        Law::EnergyQp | Law::Complementarity => problem.approach[i].min(0.0),
        _ => problem.approach[i],
    }
}

/// How well a step was solved, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Natural map of (17)-(22), ||f - P_K(f - v^)||, relative to the step's scale max(||f||, ||b||), all scaled by the
    /// diagonal of A into sqrt(J). The same yardstick for every law; `EnergyQp` violates it by design when it slides.
    pub natural_map: f64,
    /// The same map for the law's own problem: it says that the solver did its work.
    pub own: f64,
    /// Greatest |f_N v_N| of (19), relative to the square of the step's scale; v_N counts from the allowed approach.
    pub signorini: f64,
    /// Greatest angle between f_F and -v_F at a slipping contact \[rad\].
    pub slip_misalignment: f64,
    /// Energy after the step less that of the free motion, f·v - f·A f/2 \[J\]. Plastic contact never raises it.
    pub energy_gain: f64,
    /// What the gain is to be seen beside: work of the impulses, and energy of motion that the contacts could take \[J\].
    pub work: f64,
    /// Pivots of all attempts; of the round cone, linear systems solved.
    pub pivots: u32,
    /// The remembered basis was right (of no contact: that nothing touches).
    pub warm: bool,
    /// Pivoting failed on the problem itself and went through a regularised one; see `own` for how well that ended.
    pub fallback: bool,
}
