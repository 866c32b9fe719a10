//! Claims about other set-points and requests to stop while the robot walks.

#![expect(clippy::expect_used, reason = "a test may panic")]

use crate::common::scene;
use controller::{Controller, ControllerError};
use messages::scene::Scene;
use plant::Plant;

/// Period [s] and speed [m/s].
type Gait = [f64; 2];

/// The robot has walked that long before the first request [control periods of 1 ms].
const BEFORE: u32 = 8500;
/// Time for the change [control periods].
const AFTER: u32 = 9000;
/// Number of phases of the request within one period.
const PHASES: u32 = 12;
/// Least height of the trunk of a robot that walks [m].
const LEAST_HEIGHT: f64 = 0.2;

fn walk([period, speed]: Gait) -> Scene {
    scene("walk", &[&format!("controller.period={period}"), &format!("controller.speed={speed}")])
}

/// A copy of a plant.
fn copy(plant: &Plant, scene: &Scene) -> Plant {
    let mut copy = Plant::new(scene).expect("a plant");
    copy.restore(&plant.snapshot());
    copy
}

/// One control period; `None` if the robot falls.
fn advance(plant: &mut Plant, controller: &mut Controller) -> Option<()> {
    plant.advance(&controller.tick(&plant.encoders()).ok()?).ok()?;
    (plant.truth().base_position[2] > LEAST_HEIGHT).then_some(())
}

/// Walks with the new set-points. Returns the time until every step has the new period within 5 % [s]; `None` if the robot falls.
fn settled(mut plant: Plant, mut controller: Controller, [period, speed]: Gait) -> Option<f64> {
    let (mut steps, mut last, mut settled) = (controller.telemetry().steps, 0, 0);
    controller.set(Some(period), Some(speed)).expect("set-points in range");
    for now in 0..AFTER {
        advance(&mut plant, &mut controller)?;
        if controller.telemetry().steps > steps {
            let duration = f64::from(now - last) * 1e-3;
            if (2.0 * duration / period - 1.0).abs() > 0.05 {
                settled = now;
            }
            (steps, last) = (controller.telemetry().steps, now);
        }
    }
    Some(f64::from(settled) * 1e-3)
}

/// The results of something done at all phases of a walk, at a time [s].
fn at_all_phases<T>(gait: Gait, what: impl Fn(Plant, Controller, f64) -> T) -> Vec<T> {
    let scene = walk(gait);
    let mut plant = Plant::new(&scene).expect("a plant");
    let mut controller = Controller::new(&scene).expect("a controller");
    let phases: Vec<u32> =
        (0..PHASES).map(|k| BEFORE + (1000.0 * gait[0] * f64::from(k) / f64::from(PHASES)) as u32).collect();
    let mut results = vec![];
    for now in 0..=phases[phases.len() - 1] {
        if phases.contains(&now) {
            results.push(what(copy(&plant, &scene), controller.clone(), f64::from(now) * 1e-3));
        }
        advance(&mut plant, &mut controller).expect("a robot that walks");
    }
    results
}

/// Long steps become shorter ones with a shorter period, and the other way round. If the new period held at once and the step length followed,
/// the steps would for a while be as long as before in less time: the robot fell at up to half of the phases of the first six rows.
#[test]
fn a_request_for_another_period_makes_no_robot_fall_at_any_phase() {
    let changes: [[Gait; 2]; 14] = [
        [[1.2, 0.38], [0.7, 0.38]],
        [[1.1, 0.4], [0.7, 0.4]],
        [[1.0, 0.45], [0.7, 0.45]],
        [[1.01, 0.44], [0.68, 0.44]],
        [[0.9, 0.5], [0.6, 0.5]],
        [[0.87, -0.43], [0.61, -0.27]],
        [[0.8, 0.6], [0.6, 0.2]],
        [[1.0, 0.4], [0.6, 0.4]],
        [[0.8, 0.5], [0.6, 0.5]],
        [[0.6, 0.5], [0.45, 0.5]],
        [[0.7, 0.45], [1.0, 0.45]],
        [[0.6, 0.5], [0.9, 0.5]],
        [[0.6, 0.2], [0.36, 0.2]],
        [[0.36, 0.2], [0.8, 0.2]],
    ];
    let results = std::thread::scope(|scope| {
        let runs = changes.map(|change| {
            scope.spawn(move || {
                (change, at_all_phases(change[0], |plant, controller, _| settled(plant, controller, change[1])))
            })
        });
        runs.map(|run| run.join().expect("an orderly end"))
    });
    for (change, times) in results {
        let falls = times.iter().filter(|time| time.is_none()).count();
        let longest = times.into_iter().flatten().fold(0.0, f64::max);
        println!("{change:?}: {falls} of {PHASES} fall, {longest:.2} s");
        assert!(falls == 0 && longest < 4.0, "{change:?}: {falls} falls, settled within {longest} s");
    }
}

/// The launcher repeats the set-points to a controller that starts within a step with those of the scene. Were they led, a third and more of these
/// robots would fall.
#[test]
fn a_controller_that_takes_over_within_a_step_walks_with_the_set_points_at_once() {
    for [scene, walked] in [[[0.8, 0.6], [0.6, 0.2]], [[1.2, 0.38], [0.5, 0.1]], [[0.6, 0.3], [0.9, 0.5]]] {
        let times = at_all_phases(walked, |mut plant, _, now| {
            let mut new = Controller::new(&walk(scene)).expect("a controller");
            new.begin_at(now);
            (0..5).try_for_each(|_| advance(&mut plant, &mut new))?;
            settled(plant, new, walked)
        });
        let falls = times.iter().filter(|time| time.is_none()).count();
        println!("{scene:?}, {walked:?}: {falls} of {PHASES} fall");
        assert_eq!(falls, 0, "{scene:?}, {walked:?}");
    }
}

#[test]
fn a_snapshot_within_a_change_continues_it() {
    let scene = walk([1.0, 0.45]);
    let mut plant = Plant::new(&scene).expect("a plant");
    let mut controller = Controller::new(&scene).expect("a controller");
    (0..4000).for_each(|_| advance(&mut plant, &mut controller).expect("a robot that walks"));
    controller.set(Some(0.7), None).expect("a period in range");
    (0..900).for_each(|_| advance(&mut plant, &mut controller).expect("a robot that walks"));
    let (mut other, mut restored) = (copy(&plant, &scene), Controller::new(&scene).expect("a controller"));
    restored.restore(&controller.snapshot()).expect("a state of this scene");
    for _ in 0..1000 {
        advance(&mut plant, &mut controller).expect("a robot that walks");
        advance(&mut other, &mut restored).expect("a robot that walks");
        assert_eq!(plant.truth().angle, other.truth().angle);
    }
}

/// Also while the period changes.
#[test]
fn a_request_to_stop_does_what_the_stop_time_of_a_scene_does() {
    let changed = |controller: &mut Controller| controller.set(Some(0.7), Some(0.45)).expect("set-points in range");
    for now in (3000..3600).step_by(75) {
        let of = |stop: &[&str]| {
            let scene = scene("walk", &[&["controller.period=1", "controller.speed=0.4"], stop].concat());
            (Plant::new(&scene).expect("a plant"), Controller::new(&scene).expect("a controller"))
        };
        let stop = format!("controller.stop_time={}", f64::from(now) * 1e-3);
        let [mut asked, mut told, mut walks] = [of(&[]), of(&[&stop]), of(&[])];
        for period in 0..6000 {
            for (plant, controller) in [&mut asked, &mut told, &mut walks] {
                if period == 2500 {
                    changed(controller);
                }
                advance(plant, controller).expect("a robot that does not fall");
            }
            if period + 1 == now {
                asked.1.stop();
                let mut restored = Controller::new(&walk([1.0, 0.4])).expect("a controller");
                restored.restore(&asked.1.snapshot()).expect("a state of this scene");
                asked.1 = restored;
            }
            if period == 4500 {
                asked.1.stop(); // a second request changes nothing
            }
            assert_eq!(asked.0.truth().angle, told.0.truth().angle, "stopped at {now} ms, {period} ms");
        }
        let end = |(plant, _): &(Plant, Controller)| plant.truth().base_position[0];
        assert!(end(&walks) > end(&asked) + 0.3, "the walk without a stop goes on");
        let refused = asked.1.set(None, Some(0.1));
        assert!(
            matches!(refused, Err(ControllerError::Stopped(stop)) if (stop - f64::from(now) * 1e-3).abs() < 1e-9),
            "{refused:?}"
        );
    }
}
