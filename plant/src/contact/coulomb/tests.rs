//! Claims about single stages.

mod heavy_on_light;
mod landing_plate;
mod stages;
mod wedged_feet;

use super::{Law, Memory, Problem, Report};
use crate::contact::solver::Solver;

/// Solves recorded problems, each with the memory of the step before.
fn solve_recorded(text: &str) -> Vec<Report> {
    let steps: Vec<(Problem, Memory)> = serde_json::from_str(text).expect("problems with memories");
    let solve = |(problem, mut memory): (Problem, Memory)| Solver::default().solve(&problem, Law::Cone, &mut memory);
    steps.into_iter().map(solve).collect()
}
