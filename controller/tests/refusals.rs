//! Claims about what the controller refuses: gaits out of range, and set-points without an effect.

#![expect(clippy::expect_used, reason = "a test may panic")]

use biped_controller::messages::load::{SCENES, load};
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
            is_accepted
                || sentence.ends_with("0.30 to 2.00 s, and a step, half a period times the speed, at most 0.250 m")
        );
    }
}

#[test]
fn a_robot_that_stands_or_stops_takes_no_set_points() {
    let mut standing = controller(&["controller.gait=\"stand\""]);
    assert_eq!(standing.set(None, Some(0.1)), Err(ControllerError::Standing));
    assert_eq!(standing.answer_set(None, Some(0.1)), Verdict::NotServed);
    let mut stopping = controller(&["controller.stop_time=8"]);
    assert_eq!(stopping.set(None, Some(0.1)), Ok(()));
    stopping.begin_at(8.0);
    assert_eq!(stopping.set(None, Some(0.1)), Err(ControllerError::Stopped(8.0)));
}
