//! Statistics of the solver on the problems of a family, and their table.

use super::families::ProblemFamily;
use messages::scene::Law;
use plant::contact::{Problem, Report};
use strum::VariantArray;

/// The laws of the study.
pub const LAWS: [Law; 2] = [Law::Cone, Law::Aligned];

/// Statistics of one law on one family.
#[derive(Clone, Debug, Default)]
pub struct SolverTally {
    /// Number of problems.
    pub count: usize,
    /// Problems with a warm start.
    pub remembered: usize,
    /// Problems in which the warm start was already the solution.
    pub warm: usize,
    /// Greatest number of rows of a problem.
    pub rows: usize,
    /// Greatest residual of the natural map of the law's own cone.
    pub natural_map: f64,
    /// Problems whose residual exceeds 1e-10 or is NaN.
    pub unsolved: usize,
    /// Problems that were solved by a regularised problem first.
    pub fallbacks: usize,
    /// Pivots of each problem, and the same divided by its number of complementary pairs.
    pub pivots: Vec<(u32, f64)>,
    /// Time of all solves [s].
    pub time: f64,
}

impl SolverTally {
    pub(super) fn note(&mut self, problem: &Problem, is_remembered: bool, own: &Report, judged: &Report) {
        self.count += 1;
        self.remembered += usize::from(is_remembered);
        self.warm += usize::from(is_remembered && own.warm);
        self.rows = self.rows.max(problem.rows());
        self.natural_map = self.natural_map.max(judged.own);
        self.unsolved += usize::from(judged.breaks_promise());
        self.fallbacks += usize::from(own.fallback);
        let pairs = problem.contacts * (2 + 2 * problem.tangents); // v_N, the facets, the slip speed of each
        self.pivots.push((own.pivots, f64::from(own.pivots) / pairs as f64));
    }

    pub(super) fn merge(mut self, mut other: SolverTally) -> SolverTally {
        self.count += other.count;
        self.remembered += other.remembered;
        self.warm += other.warm;
        self.rows = self.rows.max(other.rows);
        self.natural_map = self.natural_map.max(other.natural_map);
        self.unsolved += other.unsolved;
        self.fallbacks += other.fallbacks;
        self.pivots.append(&mut other.pivots);
        self.time += other.time;
        self
    }
}

/// Rows of the table. The first one names the columns.
pub fn rows(results: &mut [[SolverTally; 2]]) -> Vec<Vec<String>> {
    let columns = [
        "family",
        "law",
        "problems",
        "rows",
        "natural map",
        "unsolved",
        "fallbacks",
        "warm",
        "pivots p50",
        "p99.9",
        "max",
        "p99.9 per pair",
        "µs",
    ];
    let mut rows = vec![columns.map(String::from).to_vec()];
    for (family, tallies) in ProblemFamily::VARIANTS.iter().zip(results) {
        for (law, tally) in LAWS.iter().zip(tallies) {
            let last = tally.pivots.len().saturating_sub(1) as f64;
            let at = |share: f64| (share * last) as usize;
            tally.pivots.sort_unstable_by_key(|count| count.0);
            let count = |share: f64| tally.pivots.get(at(share)).map_or(0, |p| p.0).to_string();
            let counts = [0.5, 0.999, 1.0].map(count);
            tally.pivots.sort_unstable_by(|a, b| a.1.total_cmp(&b.1));
            let per_pair = tally.pivots.get(at(0.999)).map_or(0.0, |p| p.1);
            let warm = tally.warm as f64 / tally.remembered.max(1) as f64;
            let [p50, p999, most] = counts;
            rows.push(vec![
                format!("{family:?}").to_lowercase(),
                format!("{law:?}"),
                tally.count.to_string(),
                tally.rows.to_string(),
                format!("{:.1e}", tally.natural_map),
                tally.unsolved.to_string(),
                tally.fallbacks.to_string(),
                format!("{:.3}", warm),
                p50,
                p999,
                most,
                format!("{per_pair:.2}"),
                format!("{:.1}", 1e6 * tally.time / tally.count.max(1) as f64),
            ]);
        }
    }
    rows
}
