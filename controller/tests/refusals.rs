//! Claims about what the controller refuses: gaits out of range, heights that no posture reaches, and set-points without an effect.

#![expect(clippy::expect_used, reason = "a test may panic")]

use biped_controller::messages::load::{SCENES, load};
use biped_controller::messages::port::GaitRequest;
use biped_controller::messages::scene::Scene;
use biped_controller::messages::wire::Verdict;
use biped_controller::{Controller, ControllerError};

fn scene(settings: &[&str]) -> Scene {
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).into()).collect();
    load("walk", &settings, SCENES).expect("a good scene")
}

fn controller(settings: &[&str]) -> Controller {
    Controller::new(&scene(settings)).expect("a controller")
}

#[test]
fn a_scene_and_a_request_accept_the_same_gaits() {
    for (speed, period, is_accepted) in [
        (0.5, 1.0, true), // a step of .25 m, as far as a foot reaches
        (-0.5, 1.0, true),
        (0.6, 0.8, true),
        (0.7, 0.6, true),
        (0.0, 0.3, true),
        (0.0, 2.0, true),
        (0.51, 1.0, false),
        (5.0, 0.6, false),
        (-1e9, 0.6, false),
        (0.1, 0.2, false),
        (0.0, 2.1, false),
    ] {
        let gait = [format!("controller.speed={speed}"), format!("controller.period={period}")];
        let loaded = Controller::new(&scene(&[&gait[0], &gait[1]]));
        let asked = controller(&[]).set(Some(period), Some(speed));
        assert_eq!(loaded.as_ref().err(), asked.as_ref().err(), "{speed} m/s, {period} s");
        assert_eq!(asked.is_ok(), is_accepted, "{speed} m/s, {period} s");
        let sentence = asked.map_or_else(|error| error.to_string(), |()| String::new());
        assert!(
            is_accepted || sentence.ends_with("0.3 to 2 s, and a step, half a period times the speed, at most 0.25 m")
        );
    }
}

#[test]
fn a_robot_that_stands_or_stops_takes_no_set_points() {
    let mut standing = controller(&["controller.gait=\"stand\""]);
    assert_eq!(standing.set(None, Some(0.1)), Err(ControllerError::Standing));
    assert_eq!(standing.answer(GaitRequest::Set { period: None, speed: Some(0.1) }), Verdict::NoEffect);
    let mut stopping = controller(&["controller.stop_time=8"]);
    assert_eq!(stopping.set(None, Some(0.1)), Ok(()));
    stopping.begin_at(8.0);
    assert_eq!(stopping.set(None, Some(0.1)), Err(ControllerError::Stopped(8.0)));
    for controller in [&mut standing, &mut stopping] {
        assert_eq!(controller.answer(GaitRequest::Stop), Verdict::Done);
    }
}

#[test]
fn an_error_of_the_height_names_heights_that_the_robot_reaches() {
    let long_shanks = ["bodies.left foot.joint.at=[0, 0, -0.4]", "bodies.right foot.joint.at=[0, 0, -0.4]"];
    let short_thighs = ["bodies.left shank.joint.at=[0, 0, -0.14]", "bodies.right shank.joint.at=[0, 0, -0.14]"];
    for robot in [vec![], [long_shanks, short_thighs].concat()] {
        let mut scene = scene(&robot);
        let mut at = |height: f64| {
            scene.controller.as_mut().expect("a controller").com_height = height;
            Controller::new(&scene).err()
        };
        let Some(ControllerError::Height { low, high, .. }) = at(0.9) else { panic!("{robot:?}: it reaches 0.9 m") };
        println!("{robot:?}: {low} to {high} m");
        for share in 0..=20 {
            let height = low + (high - low) * f64::from(share) / 20.0;
            assert_eq!(at(height), None, "{robot:?}: {height} m");
        }
        for height in [0.9 * low, 1.05 * high] {
            assert!(at(height).is_some(), "{robot:?}: {height} m");
        }
    }
}
