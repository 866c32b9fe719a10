//! Solver of the laws without a basis: round cones, cylinders and pyramids. The attempts run from the cheapest to the most reliable.

use super::super::memory::Memory;
use super::super::problem::Problem;
use super::super::report::Report;
use super::super::round_cones::RoundCones;
use super::super::tolerance::{LEMKE_COMPLIANCE, SOLVED};
use super::condition::{Condition, natural_map};
use super::cone_qp::ConeQp;
use super::facets::Facets;
use super::gauss_seidel::sweep;
use super::scaled_problem::ScaledProblem;
use super::semismooth_newton::SemismoothNewton;
use super::spring_damper;
use messages::scene::{Iteration, Law};

/// Gauss-Seidel sweeps before each new start of Newton's method.
const SWEEP_COUNTS: [u32; 4] = [3, 12, 50, 200];

/// Workspace and last solution.
#[derive(Clone, Debug, Default)]
pub(super) struct ConeSolver {
    cones: RoundCones,
    f: Vec<f64>,
    v: Vec<f64>,
    newton: SemismoothNewton,
    cone_qp: ConeQp,
    facets: Facets,
    scaled: ScaledProblem,
    swept: Vec<f64>,
    best: Vec<f64>,
    /// Friction bounds or shifts of v_N, held during one energy minimum.
    pub held: Vec<f64>,
    /// Difference between the held values and those of the last minimum.
    change: Vec<f64>,
}

impl ConeSolver {
    /// Solves the problem and writes the impulse [N·s].
    pub fn solve(&mut self, problem: &Problem, law: Law, memory: &mut Memory, impulse: &mut Vec<f64>) -> Report {
        let mut report = Report::default();
        self.cones.set(problem, law);
        impulse.clear();
        problem
            .id
            .iter()
            .for_each(|&id| impulse.extend_from_slice(&memory.contact(id).impulse[..1 + problem.tangents]));
        self.cones.scale_impulse(impulse, &mut self.f);
        let solved = match law {
            Law::SpringDamper => {
                spring_damper::write_impulse(problem, impulse);
                self.cones.scale_impulse(impulse, &mut self.f);
                true
            }
            Law::Sweep(count) => {
                (0..count).for_each(|_| sweep(&self.cones, Condition::Coulomb, &mut self.f));
                report.pivots = count.into();
                true
            }
            Law::Lagged => {
                self.held.clear();
                self.hold(Iteration::Tresca, 1.0);
                self.with_held(|solver, held| solver.minimise(Condition::Bound(held), &mut report.pivots))
            }
            Law::ConeQp => {
                let energy = Condition::Energy(&[]);
                self.interior_then_newton(energy, &mut report.pivots) || self.minimise(energy, &mut report.pivots)
            }
            Law::FixedPoint(iteration) => self.iterate_fixed_point(iteration, &mut report.pivots),
            _ => self.polygon(condition(law), &mut report.pivots),
        };
        report.fallback = !solved;
        self.cones.velocity(&self.f, &mut self.v);
        report.own = match law {
            Law::SpringDamper => 0.0 * self.cones.magnitude(&self.f), // a formula has no residual, but NaN propagates
            Law::Lagged => natural_map(&self.cones, Condition::Bound(&self.held), &self.f, &self.v),
            _ => natural_map(&self.cones, condition(law), &self.f, &self.v),
        };
        report.warm = solved && report.pivots == 0;
        self.cones.unscale_impulse(problem, &self.f, impulse);
        memory.store(problem, impulse);
        report
    }

    /// The residual of a given impulse in the conditions of the law itself.
    pub fn own_residual(&mut self, problem: &Problem, law: Law, impulse: &[f64]) -> f64 {
        self.cones.set(problem, law);
        self.cones.scale_impulse(impulse, &mut self.f);
        self.residual(condition(law))
    }

    /// Updates the held values from the present impulse, with under- or over-relaxation. Returns whether they change in the same direction
    /// as the last time.
    pub fn hold(&mut self, iteration: Iteration, relaxation: f64) -> bool {
        let first = self.held.is_empty();
        if first {
            self.change.clear();
        }
        let ConeSolver { cones, f, v, held, change, .. } = self;
        held.resize(cones.contacts, 0.0);
        change.resize(cones.contacts, 0.0);
        let (at_rest, mut along) = (f.iter().all(|f| *f == 0.0), 0.0);
        for (i, (held, last)) in held.iter_mut().zip(change).enumerate() {
            let mu = cones.friction[i];
            let new = match iteration {
                Iteration::Tresca => mu * f[3 * i].max(0.0),
                Iteration::Aclm if at_rest => 0.0,
                Iteration::Aclm => mu * libm::hypot(v[3 * i + 1], v[3 * i + 2]),
            };
            let rise = new - *held;
            let next = if first { new } else { *held + relaxation * rise };
            *held = if next < 0.0 { 0.0 } else { next }; // NaN propagates
            along += rise * *last;
            *last = rise;
        }
        along > 0.0
    }

    /// Runs `work`, which may change the solver while it reads the held values.
    pub fn with_held<T>(&mut self, work: impl FnOnce(&mut ConeSolver, &[f64]) -> T) -> T {
        let held = std::mem::take(&mut self.held);
        let result = work(self, &held);
        self.held = held;
        result
    }

    /// Coulomb's law with a polygon: Newton's method from the remembered impulse and from sweeps, then Lemke's method with 32 digits and
    /// compliant contacts.
    fn polygon(&mut self, condition: Condition<'_>, steps: &mut u32) -> bool {
        if self.newton_with_sweeps(condition, steps) {
            return true;
        }
        let Condition::Polygon(d) = condition else { return false };
        let (least, kept) = (self.residual(condition), self.f.clone());
        let ConeSolver { cones, scaled, facets, newton, f, v, .. } = self;
        scaled.set_alike(cones);
        scaled.set_compliance(LEMKE_COMPLIANCE);
        facets.solve_polygon(scaled, d, f, steps);
        let error = newton.polish(cones, condition, f, v, steps);
        if error.is_nan() || error > least {
            self.f = kept;
        }
        error <= SOLVED
    }

    /// Minimum of a convex condition: Newton's method, then the interior-point method.
    pub fn minimise(&mut self, condition: Condition<'_>, steps: &mut u32) -> bool {
        if self.newton_with_sweeps(condition, steps) || self.interior_then_newton(condition, steps) {
            return true;
        }
        let (error, kept) = (self.residual(condition), self.f.clone());
        self.f.fill(0.0);
        if !self.newton_with_sweeps(condition, steps) && self.residual(condition) > error {
            self.f = kept;
        }
        self.residual(condition) <= SOLVED
    }

    /// The interior-point method, with the last digits by Newton's method.
    fn interior_then_newton(&mut self, condition: Condition<'_>, steps: &mut u32) -> bool {
        *steps += self.cone_qp.solve(&self.cones, condition, &mut self.f);
        self.newton.polish(&self.cones, condition, &mut self.f, &mut self.v, steps) <= SOLVED
    }

    /// Newton's method from `f`, then after an increasing number of sweeps; leaves the best iterate.
    fn newton_with_sweeps(&mut self, condition: Condition<'_>, steps: &mut u32) -> bool {
        self.swept.clone_from(&self.f);
        let mut least = self.newton.polish(&self.cones, condition, &mut self.f, &mut self.v, steps);
        if least <= SOLVED || !self.cones.size.is_finite() {
            return least <= SOLVED;
        }
        for count in SWEEP_COUNTS {
            (0..count).for_each(|_| sweep(&self.cones, condition, &mut self.swept));
            self.best.clone_from(&self.f);
            self.f.clone_from(&self.swept);
            let error = self.newton.polish(&self.cones, condition, &mut self.f, &mut self.v, steps);
            if error <= SOLVED {
                return true;
            }
            if error < least {
                least = error;
            } else {
                self.f.clone_from(&self.best);
            }
        }
        false
    }

    /// Natural map of the present impulse.
    pub fn residual(&mut self, condition: Condition<'_>) -> f64 {
        self.cones.velocity(&self.f, &mut self.v);
        natural_map(&self.cones, condition, &self.f, &self.v)
    }
}

/// The condition whose residual a law reports as its own.
pub(super) fn condition(law: Law) -> Condition<'static> {
    match law {
        Law::ConeQp => Condition::Energy(&[]),
        Law::Facets(d) => Condition::Polygon(d.into()),
        _ => Condition::Coulomb,
    }
}
