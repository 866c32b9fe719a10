//! The model of a run: its size, and its cost relative to the model that the scene names. `biped model` prints both.

use messages::scene::Scene;
use messages::wire::Torques;
use plant::smallest::{Size, Smallest, smallest};
use plant::{Plant, PlantError};
use shared::args::SceneArgs;
use shared::exit::Failure;
use shared::output::print_text;
use std::time::{Duration, Instant};

/// Steps of one model before the other model continues.
const BATCH_STEPS: usize = 10;
/// Repetitions from the start of the scene.
const ROUNDS: usize = 5;
/// Longest duration of the first repetition; the others have the same number of batches.
const FIRST_ROUND_TIME: Duration = Duration::from_millis(20);
/// Message for a scene whose own model is the smallest.
const NONE_SMALLER: &str = "no smaller one is known to give the same answer";

/// The model that a run was simulated with.
#[derive(Clone, Debug, PartialEq)]
pub struct RunModel {
    /// Size of the model, and size of the scene's own model if that is larger.
    pub size: String,
    /// Computing time of the model divided by that of the scene's own model [-]: 1 if it is the same model, NaN if it cannot be measured.
    pub cost_ratio: f64,
}

impl RunModel {
    /// The model that a scene names, or with `plan` the smallest equivalent one.
    ///
    /// # Errors
    /// If the scene cannot be simulated.
    pub fn of(scene: &Scene, plan: Option<&Smallest>) -> Result<RunModel, PlantError> {
        let Some(plan) = plan else { return Ok(RunModel { size: Size::of(scene)?.to_string(), cost_ratio: 1.0 }) };
        let Smallest { size, full, .. } = plan;
        if !plan.is_smaller() {
            return Ok(RunModel { size: format!("{size}; {NONE_SMALLER}"), cost_ratio: 1.0 });
        }
        Ok(RunModel { size: format!("{size}; in full: {full}"), cost_ratio: cost_ratio(&plan.scene, scene) })
    }
}

/// Prints the size of the scene's own model, the size of the smallest equivalent model, and the cost ratio.
///
/// # Errors
/// If the scene cannot be simulated.
pub fn run(args: &SceneArgs) -> Result<(), Failure> {
    let scene = args.load()?;
    let plan = smallest(&scene)?;
    let full = format!("{}\n  {:<20} {}", args.scene, "the scene's own", plan.full);
    if !plan.is_smaller() {
        print_text(format!("{full}\n  {:<20} {NONE_SMALLER}\n", "the smallest"));
        return Ok(());
    }
    let cost = match cost_ratio(&plan.scene, &scene) {
        ratio if ratio.is_finite() => {
            format!("{ratio:.2} of the computing time, measured from the start of the scene, alternating between both")
        }
        _ => "cannot be measured: the scene is too short".into(),
    };
    print_text(format!("{full}\n  {:<20} {}\n  {:<20} {cost}\n", "the smallest", plan.size, "its cost"));
    Ok(())
}

/// Computing time of the small model divided by that of the full one, for the same steps from the start of the scene. The models
/// alternate after each batch. For each batch the least time of all rounds counts, which other processes have disturbed least. NaN if
/// the first batch fails.
fn cost_ratio(small: &Scene, full: &Scene) -> f64 {
    // In the scene a control period can have many steps and take minutes. Here it has one step.
    let [small, full] = &[small, full].map(|scene| Scene { rate: 1.0 / scene.plant.dt, ..scene.clone() });
    let mut least_times: Vec<[f64; 2]> = vec![];
    let mut batches = ((full.duration * full.rate) as usize / BATCH_STEPS).max(1);
    for _ in 0..ROUNDS {
        let (Ok(mut small), Ok(mut full)) = (Plant::new(small), Plant::new(full)) else { return f64::NAN };
        let start = Instant::now();
        for batch in 0..batches {
            let (Ok(small_time), Ok(full_time)) = (time_batch(&mut small), time_batch(&mut full)) else { break };
            match least_times.get_mut(batch) {
                Some(least) => *least = [least[0].min(small_time), least[1].min(full_time)],
                None if batch == 0 || start.elapsed() < FIRST_ROUND_TIME => least_times.push([small_time, full_time]),
                None => break,
            }
        }
        batches = least_times.len(); // the same in every round
    }
    let sum = |model: usize| least_times.iter().map(|times| times[model]).sum::<f64>();
    sum(0) / sum(1)
}

/// Time of one batch of steps [s].
fn time_batch(plant: &mut Plant) -> Result<f64, PlantError> {
    let start = Instant::now();
    (0..BATCH_STEPS).try_for_each(|_| plant.advance(&Torques::default()).map(drop))?;
    Ok(start.elapsed().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::load::load;
    use shared::list::SCENES;

    #[test]
    fn a_smaller_model_costs_less_and_the_same_model_costs_the_same() {
        let incline = load("incline", &[], SCENES).unwrap(); // it always slides; at rest the full model would use its faster standing contact
        let small = RunModel::of(&incline, Some(&smallest(&incline).unwrap())).unwrap();
        assert!(small.cost_ratio < 0.8 && small.size.contains("in full"), "{small:?}");
        let full = RunModel::of(&incline, None).unwrap();
        assert!(full.cost_ratio == 1.0 && full.size.starts_with("quaternion"), "{full:?}");
        let walk = load("walk", &[], SCENES).unwrap();
        let same = RunModel::of(&walk, Some(&smallest(&walk).unwrap())).unwrap();
        assert!(same.cost_ratio == 1.0 && same.size.ends_with(NONE_SMALLER), "{same:?}");
        let twin = cost_ratio(&incline, &incline);
        assert!((0.5..2.0).contains(&twin), "negative control: a model relative to itself costs {twin}");
    }

    #[test]
    fn the_cost_of_a_failing_model_is_nan() {
        let mut slide = load("slide", &[], SCENES).unwrap();
        slide.bodies[0].mass = f64::NAN;
        assert!(cost_ratio(&slide, &slide).is_nan());
    }
}
