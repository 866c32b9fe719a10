//! Contact with the ground: which impulse f makes the velocity after the step, v = A f + b, obey the contact law?
//!
//! | law | conditions | method |
//! |---|---|---|
//! | `EnergyQp` | the minimum of (14) under (15), (16), as printed | principal pivoting (`energy_qp`) |
//! | `Complementarity` | (17)-(22), one tangent | lexicographic Lemke (`facets`, `lemke`) |
//! | `Aligned` | (17)-(22), two tangents, landing at the ground | the same |
//!
//! The laws differ in how they find a complementary basis: which contacts are open, stick, or slide which way. The impulse
//! of a basis is then computed afresh from A and b (`basis`), and it is accepted by its residual alone (`residual`), so a
//! basis remembered from the last step is tried first and the outcome is right however it was found.
//!
//! The paper takes (17)-(22) for the conditions of its program (14)-(16). They are not: with multipliers the program gives
//! f_N (v_N - mu |v_F|) = 0 in place of (19), so whatever slides is thrown up. See docs/PAPER.md.

mod basis;
mod dictionary;
mod energy_qp;
mod facets;
mod lemke;
mod residual;
mod scaled;

use basis::Block;
use energy_qp::EnergyQp;
use facets::Facets;
use messages::scene::Law;
use residual::Yardstick;
use scaled::Scaled;

/// A residual up to this is solved: about what rounding leaves at a mass ratio of 1e6.
const SOLVED: f64 = 1e-11;
/// A remembered basis has to be this good. It is stricter, so that being warm is not seen in the velocity.
const SOLVED_WARM: f64 = 1e-12;
/// Size below which an entry is no pivot, the unit diagonal being 1.
const ZERO: f64 = 1e-9;
/// The fallback's rounds: regularisation rho, and what counts as zero.
const ROUNDS: [(f64, f64); 12] = [
    (0.0, 1e-12),
    (0.0, 1e-7),
    (1e-8, 1e-9),
    (1e-8, 1e-12),
    (1e-6, 1e-9),
    (1e-6, 1e-12),
    (1e-4, 1e-9),
    (1e-8, 1e-9),
    (1e-6, 1e-9),
    (1e-4, 1e-9),
    (1e-8, 1e-9),
    (1e-8, 1e-9),
];

/// One contact step, `v = A f + b`.
///
/// Rows are contact-major: for each contact its normal, then its tangents. The first tangent is the direction of the free
/// slip, so b = (v_N, v_s >= 0, 0); any other choice is solved as well, but the square cone of two tangents is exact only
/// along them.
///
/// # Source
/// (12)-(14): A = K^T H^-1 K and b = K^T (xdot + H^-1 Δf_b).
#[derive(Clone, Debug, Default)]
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
    /// Speed at which each contact would close its gap within the step, max(gap, 0)/h [m/s].
    pub approach: Vec<f64>,
}

impl Problem {
    /// A problem of this size, all zeros. Keeps its buffers: no allocation when it was as large before.
    pub fn reset(&mut self, contacts: usize, tangents: usize) {
        (self.contacts, self.tangents) = (contacts, tangents);
        let m = self.rows();
        let zeros = |buffer: &mut Vec<f64>, length| {
            buffer.clear();
            buffer.resize(length, 0.0);
        };
        zeros(&mut self.delassus, m * m);
        zeros(&mut self.drift, m);
        zeros(&mut self.friction, contacts);
        zeros(&mut self.approach, contacts);
        self.id.clear();
        self.id.extend(0..contacts);
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
        Law::Aligned => 2,
    }
}

/// Speed at which contact i may still approach the ground [m/s]: what is added to v_N in (18) and (19).
///
/// The paper's conditions speak of velocity alone, so a contact with a gap is stopped above the ground. `Aligned` lets it
/// close its gap and no more: `0 <= f_N _|_ v_N + gap/h >= 0` lands exactly on the ground. At rest both are the same.
fn lift(problem: &Problem, law: Law, i: usize) -> f64 {
    match law {
        Law::EnergyQp | Law::Complementarity => 0.0,
        Law::Aligned => problem.approach[i],
    }
}

/// Bases of the last step, by contact identity. Part of the state of a simulation: where A is singular, f (not v) depends
/// on it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    basis: Vec<u8>,
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
    /// Greatest angle between f_F and -v_F at a slipping contact [rad].
    pub slip_misalignment: f64,
    /// Energy after the step less that of the free motion, f·v - f·A f/2 [J]. Plastic contact never raises it.
    pub energy_gain: f64,
    /// Pivots of all attempts; zero when warm.
    pub pivots: u32,
    /// The remembered basis was right (of no contact: that nothing touches).
    pub warm: bool,
    /// Pivoting failed on the problem itself and went through a regularised one; see `own` for how well that ended.
    pub fallback: bool,
}

/// Solver of contact problems: workspace and last solution. It may be dropped between steps without changing results.
#[derive(Clone, Debug, Default)]
pub struct Solver {
    /// Contact impulse f [N·s].
    pub impulse: Vec<f64>,
    /// Contact velocity v = A f + b [m/s].
    pub velocity: Vec<f64>,
    scaled: Scaled,
    proximal: Scaled,
    facets: Facets,
    energy_qp: EnergyQp,
    block: Block,
    basis: Vec<u8>,
    f: Vec<f64>,
    v: Vec<f64>,
    best: Vec<f64>,
}

impl Solver {
    /// Solves the problem under the law and writes [`Solver::impulse`] and [`Solver::velocity`].
    ///
    /// First the basis in `memory` is tried, then pivoting from the start, then, flagged, a regularised problem. Nothing
    /// is allocated once a problem of this size was solved. Where the law has one velocity as its answer, v is the same
    /// warm or cold; f may differ by what A does not see. (The energy minimum always has one. Coulomb's law has several in
    /// jammed arrangements at high friction; then either is valid.)
    pub fn solve(&mut self, problem: &Problem, law: Law, memory: &mut Memory) -> Report {
        self.scaled.set(problem, law);
        self.recall(problem, memory);
        let mut report = Report { warm: self.try_basis(law) <= SOLVED_WARM, ..Report::default() };
        if !report.warm {
            let pivots = self.pivot(law);
            report.pivots = pivots.unwrap_or(0);
            let own = self.try_basis(law);
            if pivots.is_none() || !(own <= SOLVED) {
                if std::env::var("DBG").is_ok() { eprintln!("FB {law:?} pivots {pivots:?} own {own:.1e} n {} mu {} approach {}", self.scaled.contacts, self.scaled.friction[0], problem.approach[0]>0.0);}
                report.fallback = true;
                report.pivots += self.fall_back(law);
            }
        }
        self.remember(problem, memory);
        self.unscale(problem);
        self.measure(problem, law, &mut report);
        report
    }

    /// Residuals of a given impulse, as a yardstick for any other solver.
    pub fn measure_impulse(&mut self, problem: &Problem, law: Law, impulse: &[f64]) -> Report {
        self.scaled.set(problem, law);
        self.f.clear();
        self.f.extend(impulse.iter().zip(&self.scaled.root).map(|(f, r)| f * r));
        self.scaled.velocity(&self.f, &mut self.v);
        self.unscale(problem);
        let mut report = Report::default();
        self.measure(problem, law, &mut report);
        report
    }

    fn recall(&mut self, problem: &Problem, memory: &Memory) {
        self.basis.clear();
        self.basis.extend(problem.id.iter().map(|&id| memory.basis.get(id).copied().unwrap_or(0)));
    }

    fn remember(&self, problem: &Problem, memory: &mut Memory) {
        for (&id, &bits) in problem.id.iter().zip(&self.basis) {
            if memory.basis.len() <= id {
                memory.basis.resize(id + 1, 0);
            }
            memory.basis[id] = bits;
        }
    }

    /// Finds a complementary basis; the number of pivots, or `None`.
    fn pivot(&mut self, law: Law) -> Option<u32> {
        match law {
            Law::EnergyQp => self.energy_qp.pivot(&self.scaled, ZERO, &mut self.basis),
            Law::Complementarity | Law::Aligned => self.facets.pivot(&self.scaled, ZERO, &mut self.basis),
        }
    }

    /// Impulse and velocity of the basis; its residual, infinite when the basis is singular.
    fn try_basis(&mut self, law: Law) -> f64 {
        if !self.block.solve(&self.scaled, law, &self.basis, &mut self.f, &mut self.v) {
            return f64::INFINITY;
        }
        residual::natural_map(&self.scaled, &self.f, &self.v, yardstick(law))
    }

    /// Proximal rounds: f' solves the problem with A + rho I and b - rho f, which is nowhere singular and has the same
    /// fixed point. Each basis is first tried on the true problem. Keeps the best impulse; returns the pivots.
    fn fall_back(&mut self, law: Law) -> u32 {
        let mut pivots = 0;
        let mut least = f64::INFINITY;
        self.best.clear();
        self.best.resize(self.scaled.drift.len(), 0.0);
        self.f.clone_from(&self.best);
        for (rho, zero) in ROUNDS {
            self.proximal.regularise(&self.scaled, rho, &self.f);
            let found = match law {
                Law::EnergyQp => self.energy_qp.pivot(&self.proximal, zero, &mut self.basis),
                Law::Complementarity | Law::Aligned => self.facets.pivot(&self.proximal, zero, &mut self.basis),
            };
            let Some(count) = found else { continue };
            pivots += count;
            for exact in [true, false] {
                let problem = if exact { &self.scaled } else { &self.proximal };
                if self.block.solve(problem, law, &self.basis, &mut self.f, &mut self.v) {
                    self.scaled.velocity(&self.f, &mut self.v);
                    let error = residual::natural_map(&self.scaled, &self.f, &self.v, yardstick(law));
                    if error < least {
                        least = error;
                        self.best.clone_from(&self.f);
                    }
                }
                if least <= SOLVED {
                    break;
                }
            }
            if least <= SOLVED {
                break;
            }
        }
        self.f.clone_from(&self.best);
        self.scaled.velocity(&self.f, &mut self.v);
        pivots
    }

    /// From energy units back to N·s and m/s.
    fn unscale(&mut self, problem: &Problem) {
        let m = problem.rows();
        self.impulse.clear();
        self.impulse.extend(self.f.iter().zip(&self.scaled.root).map(|(f, &r)| if r > 0.0 { f / r } else { 0.0 }));
        self.velocity.clear();
        let rows = problem.delassus.chunks_exact(m.max(1)).zip(&problem.drift);
        self.velocity.extend(rows.map(|(row, b)| b + scaled::dot(row, &self.impulse)));
    }

    fn measure(&self, problem: &Problem, law: Law, report: &mut Report) {
        let Solver { scaled, f, v, .. } = self;
        report.natural_map = residual::natural_map(scaled, f, v, Yardstick::Coulomb);
        report.own = match law {
            Law::EnergyQp => residual::natural_map(scaled, f, v, Yardstick::EnergyMinimum),
            Law::Complementarity | Law::Aligned => report.natural_map,
        };
        report.signorini = residual::signorini(scaled, f, v);
        report.slip_misalignment = residual::slip_misalignment(scaled, f, v);
        // f·v - f·A f/2 with A f = v - b.
        let work = self.impulse.iter().zip(self.velocity.iter().zip(&problem.drift)).map(|(f, (v, b))| f * (v + b));
        report.energy_gain = 0.5 * work.sum::<f64>();
    }
}

/// Optimality that the law's own solution has.
fn yardstick(law: Law) -> Yardstick {
    match law {
        Law::EnergyQp => Yardstick::EnergyMinimum,
        Law::Complementarity | Law::Aligned => Yardstick::Coulomb,
    }
}
