//! The solver: from the cheapest way to a complementary basis to the surest, each judged by its residual alone.

use super::basis::Block;
use super::cones::Cones;
use super::energy_qp::{EnergyQp, minimises_energy};
use super::facets::Facets;
use super::lemke::{CAREFUL, Care, QUICK};
use super::residual::{self, Yardstick};
use super::scaled::{self, Scaled};
use super::shift::{Growth, Shift, WAYS};
use super::{Memory, Problem, Report, active_set};
use messages::scene::Law;

/// A residual up to this is solved: twice what contacts yield by, and below the 1e-10 that a step promises.
const SOLVED: f64 = 4e-11;
/// Contacts of one foot: so few settle even from a poor guess.
const FEW: usize = 4;
/// The fallback's rounds: regularisation rho, and what counts as zero. First the problem itself with other tolerances.
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

/// Solver of contact problems: workspace and last solution. With [`Memory`] kept it may be dropped between steps without
/// changing results.
#[derive(Clone, Debug, Default)]
pub struct Solver {
    /// Contact impulse f [N·s].
    pub impulse: Vec<f64>,
    /// Contact velocity v = A f + b [m/s].
    pub velocity: Vec<f64>,
    scaled: Scaled,
    cones: Cones,
    proximal: Scaled,
    facets: Facets,
    energy_qp: EnergyQp,
    block: Block,
    basis: Vec<u8>,
    rays: Vec<u8>,
    /// What is added to each v_N in the shifted energy program.
    shift: Vec<Shift>,
    f: Vec<f64>,
    v: Vec<f64>,
    best: Vec<f64>,
    /// Residual of `best`.
    least: f64,
}

impl Solver {
    /// Solves the problem under the law and writes [`Solver::impulse`] and [`Solver::velocity`].
    ///
    /// Each way ends in a basis, and whatever way it came is accepted by its residual in the given problem alone:
    ///
    /// 1. the basis in `memory`, as it is;
    /// 2. for Coulomb's law, that basis corrected contact by contact (of few with one tangent, then Lemke's method); for the energy
    ///    program, principal pivoting;
    /// 3. the same with contacts that yield by rounding (`scaled::YIELD`); for Coulomb's law then the shifted energy
    ///    program, and Lemke's method with a dictionary made afresh at each pivot;
    /// 4. for Coulomb's law, Lemke's method for contacts that do not yield;
    /// 5. flagged as a fallback: a regularised problem, and the impulse with the least residual of all.
    ///
    /// Nothing is allocated once a problem of this size was solved. Where the law has one velocity as its answer, v is the
    /// same warm or cold to the residual; f may differ by what A does not see. (The energy minimum always has one.
    /// Coulomb's law has several in jammed arrangements at high friction; then either is valid.)
    pub fn solve(&mut self, problem: &Problem, law: Law, memory: &mut Memory) -> Report {
        if !has_basis(law) {
            return self.solve_cones(problem, law, memory);
        }
        self.scaled.set(problem, law);
        self.least = f64::INFINITY;
        self.best.clear();
        self.best.resize(self.scaled.drift.len(), 0.0);
        self.basis.clear();
        self.basis.extend(problem.id.iter().map(|&id| memory.recall(id)));
        let warm = [memory.yields, !memory.yields].iter().any(|&yields| self.holds(law, yields));
        let mut report = Report { warm, ..Report::default() };
        if !report.warm {
            let solved = self.find(law, &mut report.pivots);
            if !solved {
                report.fallback = true;
                report.pivots += self.fall_back(law);
            }
        }
        problem.id.iter().zip(&self.basis).for_each(|(&id, &bits)| memory.remember(id, bits));
        memory.yields = self.scaled.yields();
        self.unscale(problem);
        self.measure(problem, law, &mut report);
        report
    }

    /// The laws without a basis: forces by formula, round cones, pyramids, iterations.
    fn solve_cones(&mut self, problem: &Problem, law: Law, memory: &mut Memory) -> Report {
        let mut report = self.cones.solve(problem, law, memory, &mut self.impulse);
        self.find_velocity(problem);
        report.energy_gain = self.energy_gain(problem);
        report
    }

    /// Finds the solution, the way that most steps take first; false if every way failed.
    fn find(&mut self, law: Law, pivots: &mut u32) -> bool {
        let found = match law {
            Law::EnergyQp | Law::EnergyQpGap => self.minimise(law, pivots),
            // where its path is short, Lemke's method ends at a basis that is solved to rounding
            Law::Complementarity if self.scaled.contacts <= FEW => {
                !self.on_rays() && self.settle(law, pivots) || self.pivot(law, QUICK, pivots)
            }
            _ => !self.on_rays() && self.settle(law, pivots),
        };
        found || self.with_yield(law, pivots) || (!minimises_energy(law) && self.pivot(law, QUICK, pivots))
    }

    /// The ways that see the finest directions, for contacts that yield.
    fn with_yield(&mut self, law: Law, pivots: &mut u32) -> bool {
        self.scaled.soften();
        let found = match law {
            Law::EnergyQp | Law::EnergyQpGap => self.minimise(law, pivots),
            _ => {
                let few = self.scaled.contacts <= FEW;
                let settled = (few || !self.on_rays()) && self.settle(law, pivots);
                settled || self.slide(law, pivots) || self.pivot(law, CAREFUL, pivots)
            }
        };
        if !found {
            self.scaled.stiffen();
        }
        found
    }

    /// Residuals of a given impulse, as a yardstick for any other solver.
    pub fn measure_impulse(&mut self, problem: &Problem, law: Law, impulse: &[f64]) -> Report {
        if !has_basis(law) {
            let mut report = self.cones.measure(problem, law, impulse);
            self.impulse.clear();
            self.impulse.extend_from_slice(impulse);
            self.find_velocity(problem);
            report.energy_gain = self.energy_gain(problem);
            return report;
        }
        self.scaled.set(problem, law);
        self.f.clear();
        self.f.extend(impulse.iter().zip(&self.scaled.root).map(|(f, r)| f * r));
        self.scaled.velocity(&self.f, &mut self.v);
        self.unscale(problem);
        let mut report = Report::default();
        self.measure(problem, law, &mut report);
        report
    }

    /// Impulse and velocity of the basis; its residual, infinite when the basis is singular.
    fn try_basis(&mut self, law: Law) -> f64 {
        if !self.block.solve(&self.scaled, law, &self.basis, &mut self.f, &mut self.v) {
            return f64::INFINITY;
        }
        if minimises_energy(law) {
            self.scaled.harden(&self.f, &mut self.v);
        }
        residual::natural_map(&self.scaled, &self.f, &self.v, yardstick(law))
    }

    /// Whether the basis in memory is the solution, of contacts that yield or do not.
    fn holds(&mut self, law: Law, yields: bool) -> bool {
        if yields {
            self.scaled.soften();
        }
        let holds = self.is_solved(law);
        if yields && !holds {
            self.scaled.stiffen();
        }
        holds
    }

    /// Whether the present basis is the solution.
    fn is_solved(&mut self, law: Law) -> bool {
        self.try_basis(law) <= SOLVED
    }

    /// Principal pivoting on the energy program.
    fn minimise(&mut self, law: Law, pivots: &mut u32) -> bool {
        self.basis.fill(0);
        let Solver { scaled, energy_qp, block, basis, f, v, .. } = self;
        let Some(count) = energy_qp.pivot(scaled, block, basis, f, v, false) else { return false };
        *pivots += count;
        self.is_solved(law)
    }

    /// Lemke's pivoting on the complementarity problem.
    fn pivot(&mut self, law: Law, care: Care, pivots: &mut u32) -> bool {
        let Some(count) = self.facets.pivot(&self.scaled, care, &mut self.basis) else { return false };
        *pivots += count;
        self.is_solved(law)
    }

    /// Whether the basis comes from the energy program, where [`Solver::slide`] goes on from it.
    fn on_rays(&self) -> bool {
        self.basis.iter().any(|bits| bits & active_set::RAYS != 0)
    }

    /// Corrects the present basis contact by contact.
    fn settle(&mut self, law: Law, pivots: &mut u32) -> bool {
        let Solver { scaled, block, basis, f, v, .. } = self;
        let Some(rounds) = active_set::settle(scaled, law, block, basis, f, v) else { return false };
        *pivots += rounds;
        residual::natural_map(scaled, f, v, yardstick(law)) <= SOLVED
    }

    /// The energy program (14)-(16), with mu |v_F| of its last solution added to each v_N until nothing changes.
    ///
    /// Its optimum has v_N >= mu |v_F|: that is Coulomb's law where nothing slides, and the shift makes it so where
    /// something does (De Saxcé; Acary & Cadoux). Long before the shift has settled the optimum says what slides where,
    /// and the block has the solution. Where a foot turns against what hardly yields, shifts grow by the same little each
    /// round: they are exaggerated, in one of the [`WAYS`] after the other.
    ///
    /// Each round also undoes what contacts yielded by in the one before (a proximal step), so that the limit is the
    /// solution of rigid ones.
    fn slide(&mut self, law: Law, pivots: &mut u32) -> bool {
        for bits in &mut self.basis {
            *bits = active_set::rays(*bits, self.scaled.facets());
        }
        self.rays.clone_from(&self.basis);
        WAYS.iter().any(|&(rounds, growth)| self.slide_by(rounds, growth, law, pivots))
    }

    fn slide_by(&mut self, rounds: usize, growth: Growth, law: Law, pivots: &mut u32) -> bool {
        let stride = self.scaled.stride();
        self.proximal.copy(&self.scaled);
        self.shift.clear();
        self.shift.resize(self.scaled.contacts, Shift::default());
        let (mut boost, mut before) = (1.0, f64::INFINITY);
        for round in 0..rounds {
            let Solver { scaled, shift, proximal, energy_qp, block, f, v, basis, rays, .. } = self;
            basis.clone_from(rays);
            let Some(count) = energy_qp.pivot(proximal, block, basis, f, v, round > 0) else { return false };
            *pivots += count;
            rays.clone_from(basis);
            for (v, (shifted, b)) in v.iter_mut().zip(proximal.drift.iter().zip(&scaled.drift)) {
                *v -= shifted - b;
            }
            scaled.harden(f, v);
            let error = residual::natural_map(scaled, f, v, yardstick(law));
            basis.iter_mut().for_each(|bits| *bits |= active_set::RAYS);
            if error <= SOLVED {
                return true;
            }
            boost = growth.boost(round, boost, error > 0.5 * before);
            before = error;
            scaled.lead(f, &mut proximal.drift);
            for (i, (v, shift)) in v.chunks_exact(stride).zip(shift).enumerate() {
                shift.approach(residual::slip(scaled, i, v), (growth != Growth::Each).then_some(boost));
                proximal.drift[i * stride] += shift.value;
            }
            active_set::slide(scaled, f, v, basis);
            self.note(error);
            if self.is_solved(law) || usize::is_power_of_two(round + 1) && self.settle(law, pivots) {
                return true;
            }
        }
        false
    }

    /// Remembers the impulse if its residual is the least so far.
    fn note(&mut self, error: f64) {
        if error < self.least {
            self.least = error;
            self.best.clone_from(&self.f);
        }
    }

    /// Proximal rounds: f' solves the problem with A + rho I and b - rho f, which is nowhere singular and has the same
    /// fixed point. Each basis is first tried on the true problem. Ends with the impulse whose residual is the least of
    /// all; returns the pivots.
    fn fall_back(&mut self, law: Law) -> u32 {
        let mut pivots = 0;
        self.f.clear();
        self.f.resize(self.scaled.drift.len(), 0.0);
        for (rho, zero) in ROUNDS {
            self.proximal.regularise(&self.scaled, rho, &self.f);
            pivots += match law {
                Law::EnergyQp | Law::EnergyQpGap => self.energy_qp.pivot(
                    &self.proximal,
                    &mut self.block,
                    &mut self.basis,
                    &mut self.f,
                    &mut self.v,
                    false,
                ),
                _ => self.facets.pivot(&self.proximal, Care { zero, ..QUICK }, &mut self.basis),
            }
            .unwrap_or(0);
            for exact in [true, false] {
                let problem = if exact { &self.scaled } else { &self.proximal };
                if self.block.solve(problem, law, &self.basis, &mut self.f, &mut self.v) {
                    self.scaled.velocity(&self.f, &mut self.v);
                    self.note(residual::natural_map(&self.scaled, &self.f, &self.v, yardstick(law)));
                }
                if self.least <= SOLVED {
                    self.f.clone_from(&self.best);
                    self.scaled.velocity(&self.f, &mut self.v);
                    return pivots;
                }
            }
        }
        self.f.clone_from(&self.best);
        self.scaled.velocity(&self.f, &mut self.v);
        pivots
    }

    /// From energy units back to N·s and m/s.
    fn unscale(&mut self, problem: &Problem) {
        self.impulse.clear();
        self.impulse.extend(self.f.iter().zip(&self.scaled.root).map(|(f, &r)| if r > 0.0 { f / r } else { 0.0 }));
        self.find_velocity(problem);
    }

    /// v = A f + b of the present impulse.
    fn find_velocity(&mut self, problem: &Problem) {
        self.velocity.clear();
        let rows = problem.delassus.chunks_exact(problem.rows().max(1)).zip(&problem.drift);
        self.velocity.extend(rows.map(|(row, b)| b + scaled::dot(row, &self.impulse)));
    }

    fn measure(&self, problem: &Problem, law: Law, report: &mut Report) {
        let Solver { scaled, f, v, .. } = self;
        report.natural_map = residual::natural_map(scaled, f, v, Yardstick::Coulomb);
        report.own = match yardstick(law) {
            Yardstick::Coulomb => report.natural_map,
            own => residual::natural_map(scaled, f, v, own),
        };
        report.signorini = residual::signorini(scaled, f, v);
        report.slip_misalignment = residual::slip_misalignment(scaled, f, v);
        report.energy_gain = self.energy_gain(problem);
    }

    /// f·v - f·A f/2 with A f = v - b \[J\].
    fn energy_gain(&self, problem: &Problem) -> f64 {
        let work = self.impulse.iter().zip(self.velocity.iter().zip(&problem.drift)).map(|(f, (v, b))| f * (v + b));
        0.5 * work.sum::<f64>()
    }
}

/// Whether the law's solution is a basis: rays or facets along the problem's own tangents.
fn has_basis(law: Law) -> bool {
    matches!(law, Law::EnergyQp | Law::EnergyQpGap | Law::Complementarity | Law::Aligned)
}

/// Optimality that the law's own solution has.
fn yardstick(law: Law) -> Yardstick {
    match law {
        Law::EnergyQp | Law::EnergyQpGap => Yardstick::EnergyMinimum,
        _ => Yardstick::Coulomb,
    }
}
