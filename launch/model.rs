//! The model of a run: how large it is, and what it costs beside the one that its scene names.

use messages::scene::Scene;
use messages::wire::Torques;
use plant::smallest::Smallest;
use plant::{Plant, PlantError};
use std::time::{Duration, Instant};

/// Control periods that one model goes on by before it is the other's turn.
const BATCH: usize = 10;
/// How long both together are watched.
const PATIENCE: Duration = Duration::from_millis(60);

/// What a run was simulated on.
#[derive(Clone, Debug, PartialEq)]
pub struct RunModel {
    /// What it has, and what the scene's own model has if that is larger.
    pub size: String,
    /// Its time for a step over that of the scene's own model; 1 if it is that one, NaN if it cannot be told.
    pub cost_ratio: f64,
}

impl RunModel {
    /// The smallest model of a scene, or with `full` its own.
    pub fn of(scene: &Scene, plan: &Smallest, full: bool) -> RunModel {
        if full || plan.scene == *scene {
            return RunModel { size: plan.full.to_string(), cost_ratio: 1.0 };
        }
        RunModel { size: plan.to_string(), cost_ratio: cost_ratio(&plan.scene, scene).unwrap_or(f64::NAN) }
    }
}

/// Median ratio of the times that two models take for the same few control periods, in turn from the beginning of the scene on.
fn cost_ratio(small: &Scene, full: &Scene) -> Result<f64, PlantError> {
    let mut plants = [Plant::new(small)?, Plant::new(full)?];
    let (begun, mut ratios) = (Instant::now(), Vec::new());
    let batches = ((full.duration * full.rate) as usize / BATCH).max(1);
    while ratios.len() < batches && (ratios.is_empty() || begun.elapsed() < PATIENCE) {
        let mut times = [0.0; 2];
        for (plant, time) in plants.iter_mut().zip(&mut times) {
            let start = Instant::now();
            (0..BATCH).try_for_each(|_| plant.advance(&Torques::default()).map(drop))?;
            *time = start.elapsed().as_secs_f64();
        }
        ratios.push(times[0] / times[1]);
    }
    ratios.sort_by(f64::total_cmp);
    Ok(ratios[ratios.len() / 2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::list::SCENES;
    use messages::load::load;
    use plant::smallest::smallest;

    #[test]
    fn a_smaller_model_costs_less_and_the_same_one_the_same() {
        let incline = load("incline", &[], SCENES).unwrap(); // slides all the time: at rest the full model is welded
        let plan = smallest(&incline).unwrap();
        let small = RunModel::of(&incline, &plan, false);
        assert!(small.cost_ratio < 0.8 && small.size.contains("in full"), "{small:?}");
        let full = RunModel::of(&incline, &plan, true);
        assert!(full.cost_ratio == 1.0 && full.size.starts_with("quaternion"), "{full:?}");
        let walk = load("walk", &[], SCENES).unwrap();
        assert_eq!(RunModel::of(&walk, &smallest(&walk).unwrap(), false).cost_ratio, 1.0);
        let twin = cost_ratio(&incline, &incline).unwrap();
        assert!((0.5..2.0).contains(&twin), "negative control: a model beside itself costs {twin}");
    }
}
