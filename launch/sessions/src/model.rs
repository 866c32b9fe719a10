//! The model of a run: how large it is, and what it costs beside the one that its scene names. `biped model` shows both.

use messages::scene::Scene;
use messages::wire::Torques;
use plant::smallest::{Size, Smallest, smallest};
use plant::{Plant, PlantError};
use shared::args::SceneArgs;
use shared::exit::Failure;
use shared::output::say;
use std::time::{Duration, Instant};

/// Steps that one model goes on by before it is the other's turn.
const BATCH: usize = 10;
/// Rounds from the beginning of the scene, and how long the first goes on.
const ROUNDS: usize = 5;
const PATIENCE: Duration = Duration::from_millis(20);
/// Where the scene's own model is the smallest.
const NONE_SMALLER: &str = "no smaller one is known to give the same answer";

/// What a run was simulated on.
#[derive(Clone, Debug, PartialEq)]
pub struct RunModel {
    /// What it has, and what the scene's own model has if that is larger.
    pub size: String,
    /// Its time over that of the scene's own model; 1 if it is that one, NaN if it cannot be told.
    pub cost_ratio: f64,
}

impl RunModel {
    /// The model that a scene names, or the smallest one that gives its answer.
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

/// Prints the size of the model that a scene names, that of the smallest, and what that costs.
///
/// # Errors
/// If the scene cannot be simulated.
pub fn run(args: &SceneArgs) -> Result<(), Failure> {
    let scene = args.load()?;
    let plan = smallest(&scene)?;
    let full = format!("{}\n  {:<20} {}", args.scene, "the scene's own", plan.full);
    if !plan.is_smaller() {
        say(format!("{full}\n  {:<20} {NONE_SMALLER}\n", "the smallest"));
        return Ok(());
    }
    let cost = match cost_ratio(&plan.scene, &scene) {
        ratio if ratio.is_finite() => format!("{ratio:.2} of the time, from the beginning of the scene on, in turns"),
        _ => "cannot be told: the scene ends too soon".into(),
    };
    say(format!("{full}\n  {:<20} {}\n  {:<20} {cost}\n", "the smallest", plan.size, "its cost"));
    Ok(())
}

/// Ratio of the times that two models take for the same steps, in turns from the beginning of the scene on. Of each few steps the
/// least time counts, which nobody else had the processor in. NaN if not even the first come to an end.
fn cost_ratio(small: &Scene, full: &Scene) -> f64 {
    // A control period may have any number of steps, and take minutes: here it has one.
    let [small, full] = &[small, full].map(|scene| Scene { rate: 1.0 / scene.plant.dt, ..scene.clone() });
    let mut least: Vec<[f64; 2]> = vec![];
    let mut batches = ((full.duration * full.rate) as usize / BATCH).max(1);
    for _ in 0..ROUNDS {
        let (Ok(mut small), Ok(mut full)) = (Plant::new(small), Plant::new(full)) else { return f64::NAN };
        let begun = Instant::now();
        for batch in 0..batches {
            let (Ok(ours), Ok(theirs)) = (time(&mut small), time(&mut full)) else { break };
            match least.get_mut(batch) {
                Some(least) => *least = [least[0].min(ours), least[1].min(theirs)],
                None if batch == 0 || begun.elapsed() < PATIENCE => least.push([ours, theirs]),
                None => break,
            }
        }
        batches = least.len(); // the same in every round
    }
    let sum = |model: usize| least.iter().map(|times| times[model]).sum::<f64>();
    sum(0) / sum(1)
}

/// Time that a plant takes for some steps [s].
fn time(plant: &mut Plant) -> Result<f64, PlantError> {
    let start = Instant::now();
    (0..BATCH).try_for_each(|_| plant.advance(&Torques::default()).map(drop))?;
    Ok(start.elapsed().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::load::load;
    use shared::list::SCENES;

    #[test]
    fn a_smaller_model_costs_less_and_the_same_one_the_same() {
        let incline = load("incline", &[], SCENES).unwrap(); // slides all the time: at rest the full model is welded
        let small = RunModel::of(&incline, Some(&smallest(&incline).unwrap())).unwrap();
        assert!(small.cost_ratio < 0.8 && small.size.contains("in full"), "{small:?}");
        let full = RunModel::of(&incline, None).unwrap();
        assert!(full.cost_ratio == 1.0 && full.size.starts_with("quaternion"), "{full:?}");
        let walk = load("walk", &[], SCENES).unwrap();
        let same = RunModel::of(&walk, Some(&smallest(&walk).unwrap())).unwrap();
        assert!(same.cost_ratio == 1.0 && same.size.ends_with(NONE_SMALLER), "{same:?}");
        let twin = cost_ratio(&incline, &incline);
        assert!((0.5..2.0).contains(&twin), "negative control: a model beside itself costs {twin}");
    }

    #[test]
    fn what_cannot_be_measured_is_no_number() {
        let mut slide = load("slide", &[], SCENES).unwrap();
        slide.bodies[0].mass = f64::NAN;
        assert!(cost_ratio(&slide, &slide).is_nan());
    }
}
