//! Warnings about a scene and about the energy of its run: one sentence each. The run goes on.

use messages::legible;
use messages::scene::{Base, Ground, Law, Scene};
use messages::wire::{PHASES, Phase};
use plant::Plant;
use plant::detect::lasting_depth;
use plant::model::Model;
use records::analysis::RunAnalysis;
use records::summary::Summary;
use shared::output::log;

/// Initial penetration above which the user is warned; less can be rounding in the pose of the scene [m].
const PENETRATION_WARNING: f64 = 1e-6;
/// A duration this close to a whole number of control periods is one, within rounding [-].
const DURATION_ROUNDING: f64 = 1e-9;
/// Energy error above which the user is warned, relative to the largest kinetic energy [-]. The walk with the default method has a
/// hundredth of it.
const ENERGY_WARNING: f64 = 0.02;
/// Energy that the ground can give to a robot that it pushes out, relative to that of lifting all of it out [-]. A box gets up to twice as
/// much, because it still rises at the surface.
const LIFTING: f64 = 10.0;

/// Warns about a duration that is no whole number of control periods. The run ends with the nearest period.
pub fn warn_of_duration(scene: &Scene) {
    let Scene { duration, rate, .. } = *scene;
    let simulated = scene.periods() as f64 / rate;
    if (simulated - duration).abs() > DURATION_ROUNDING * duration {
        let [simulated, duration, rate] = [simulated, duration, rate].map(legible);
        log(format_args!(
            "the run lasts {simulated} s, not {duration} s: duration is no whole number of control periods of 1/{rate} s"
        ));
    }
}

/// Warns about a robot that starts inside the ground. Returns the energy that the ground can give it by pushing it out [J]. An invalid scene
/// is reported later, by the run.
pub fn warn_of_penetration(scene: &Scene) -> f64 {
    let Ok(plant) = Plant::new(scene) else { return 0.0 };
    let (depth, left) = (plant.truth().penetration, lasting_depth(&scene.plant, plant.model()));
    let recovers = scene.plant.gravity > 0.0 || scene.plant.law == Law::SpringDamper;
    let is_pushed_out = recovers && depth > left;
    if depth > PENETRATION_WARNING {
        let [millimetres, rest] = [depth, left].map(|depth| depth * 1e3);
        let what_follows = match (recovers, is_pushed_out) {
            (false, _) => {
                "which does not push it out, because the speed of recovery is proportional to plant.gravity = 0".into()
            }
            (_, false) => format!(
                "which does not push it out, because plant.method = {:?} leaves points up to {rest:.3} mm inside",
                scene.plant.method
            ),
            (_, true) if left > 0.0 => format!(
                "which pushes it out, up to the {rest:.3} mm that plant.method = {:?} leaves",
                scene.plant.method
            ),
            _ => "which pushes it out".into(),
        };
        log(format_args!(
            "the robot starts {millimetres:.3} mm inside the ground, {what_follows}: initial.clearance = 0 puts it on the ground"
        ));
    }
    match scene.plant.law {
        _ if !is_pushed_out => 0.0,
        Law::SpringDamper => f64::INFINITY,
        _ => LIFTING * plant.model().mass() * scene.plant.gravity * depth,
    }
}

/// Warns about a push that has no effect, or not all of it, a stop after the end, contact points that never touch, and disturbances of
/// commands that nobody sends.
pub fn warn_of_settings_without_effect(scene: &Scene) {
    if let Some(warning) = push_without_effect(scene) {
        log(format_args!("{warning}"));
    }
    if let Some([stop, end]) = stop_and_end(scene).filter(|[stop, end]| stop >= end) {
        let [stop, end] = [stop, end].map(legible);
        log(format_args!("the robot does not stop: controller.stop_time = {stop} s, but the run ends at {end} s"));
    }
    for body in bodies_with_unmoved_points(scene) {
        log(format_args!("the contact points of body `{body}` that no joint moves never touch the ground"));
    }
    if scene.controller.is_none() && !scene.link.is_perfect() {
        log(format_args!("[link] has no effect: the scene has no [controller], so there are no commands to disturb"));
    }
}

/// The time at which the robot is to stop, if it is, and that at which the run ends [s].
fn stop_and_end(scene: &Scene) -> Option<[f64; 2]> {
    let stop = scene.controller.as_ref().and_then(|controller| controller.stop_time)?;
    Some([stop, scene.periods() as f64 / scene.rate])
}

/// Warns about a stop that the end of the run interrupts. `recorder` has analysed the whole run.
pub fn warn_of_unfinished_stop(scene: &Scene, recorder: &RunAnalysis) {
    let times = stop_and_end(scene).filter(|[stop, end]| stop < end);
    let phase = recorder.last.as_ref().and_then(|last| PHASES.get(last.truth.telemetry.phase as usize));
    let stands = [Phase::Stand, Phase::Rest].map(|phase| PHASES[phase as usize]);
    if let Some(([stop, end], _)) = times.zip(phase).filter(|(_, phase)| !stands.contains(phase)) {
        let [stop, end] = [stop, end].map(legible);
        log(format_args!(
            "the stop is cut off: controller.stop_time = {stop} s, but the run ends at {end} s, before the robot rests"
        ));
    }
}

/// Names of the bodies with contact points that no joint moves. An invalid scene has none: the run reports it.
fn bodies_with_unmoved_points(scene: &Scene) -> Vec<String> {
    let Ok(model) = Model::new(scene) else { return vec![] };
    let holds_one = |link: &usize| model.contact_points.iter().any(|point| point.link == *link && !point.moves);
    let bodies = model.body_name.iter().zip(&model.body_link).filter(|(_, link)| holds_one(link));
    bodies.map(|(name, _)| name.clone()).collect()
}

/// What keeps the scene's push from its effect.
fn push_without_effect(scene: &Scene) -> Option<String> {
    let Scene { plant, rate, .. } = scene;
    if plant.push_impulse == [0.0; 3] {
        return None;
    }
    let end = scene.periods() as f64 / rate;
    let (steps, last) = (plant.push_steps(), (end / plant.dt).round() as u64);
    let pushes_base = scene.pushed_body() == scene.base_body();
    let [start, end] = [plant.push_time, end].map(legible);
    if steps.start >= last {
        Some(format!("the push does not happen: plant.push_time = {start} s, but the run ends at {end} s"))
    } else if plant.base == Base::Fixed && pushes_base {
        Some("the push moves nothing: plant.push_body is the base, which plant.base = \"fixed\" holds".into())
    } else if steps.end > last {
        let length = legible(plant.push_duration);
        Some(format!(
            "the push is cut off: it begins at {start} s and plant.push_duration = {length} s, but the run ends at {end} s"
        ))
    } else {
        None
    }
}

/// Warns about energy that the integration method has generated or lost, or the ground by pushing out a robot that starts inside it, which
/// can give it `push_out` [J].
pub fn warn_of_energy_error(summary: &Summary, ground: &Ground, push_out: f64) {
    let Summary { energy_made_j, energy_lost_j, kinetic_max_j: kinetic, .. } = summary;
    let is_pushed = summary.requests.iter().any(|request| request.impulse_ns.is_some());
    let gain = match (*energy_made_j <= push_out, ground.is_plane()) {
        (true, _) => "the ground pushed out the robot, which started inside it",
        (_, true) => "plant.dt is too long for plant.method",
        _ => "plant.dt is too long for plant.method, or a tile lifted a point that had entered it from the side",
    };
    let loss = "plant.dt is too long for plant.method, and a method of second order loses less";
    for (what, energy, is_explained, cause) in
        [("gained", *energy_made_j, is_pushed, gain), ("lost", *energy_lost_j, false, loss)]
    {
        if energy > ENERGY_WARNING * kinetic && !is_explained {
            log(format_args!("the run {what} {energy:.1e} J; its largest kinetic energy is {kinetic:.1e} J: {cause}"));
        }
    }
}
