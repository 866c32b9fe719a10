//! Claims about what the controller refuses: gaits out of range, heights that no posture reaches, and set-points without an effect.

#![expect(clippy::expect_used, clippy::panic, reason = "a test may panic")]

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

/// The scene of a walk of a robot that is similar to that of Table 1, with lengths in this ratio.
fn similar(ratio: f64) -> Scene {
    let mut scene = scene(&[]);
    for body in &mut scene.bodies {
        body.mass *= ratio.powi(3);
        let joint = body.joint.iter_mut().map(|joint| &mut joint.at);
        for vector in [&mut body.size, &mut body.com].into_iter().chain(&mut body.contacts).chain(joint) {
            *vector = vector.map(|x| ratio * x);
        }
    }
    let gait = scene.controller.as_mut().expect("a controller");
    (gait.com_height, gait.period, gait.speed) = (ratio * gait.com_height, ratio.sqrt() * gait.period, 0.0);
    scene
}

/// The numbers of a sentence after these words.
fn named<const N: usize>(sentence: &str, words: &str) -> [f64; N] {
    let (_, after) = sentence.split_once(words).unwrap_or_else(|| panic!("no `{words}` in: {sentence}"));
    let mut numbers = after.split([' ', ',']).filter_map(|word| word.parse().ok());
    std::array::from_fn(|_| numbers.next().unwrap_or_else(|| panic!("too few numbers in: {sentence}")))
}

#[test]
fn every_bound_that_a_refusal_names_is_itself_accepted() {
    let seed = fastrand::u64(..);
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    for ratio in [1.0, 0.37, 0.021, 1e-3, 3.3] {
        let mut controller = Controller::new(&similar(ratio)).expect("a controller");
        let (time, speed) = (ratio.sqrt(), ratio.sqrt());
        for _ in 0..200 {
            let (period, fast) = (time * (0.3 + 1.7 * random.f64()), speed * (0.2 + 2.0 * random.f64()));
            let both = controller.out_of_range(Some(9.0 * time), Some(9.0 * speed)).to_string();
            let [shortest, longest] = named(&both, "the period must be ");
            let [step]: [f64; 1] = named(&both, "at most ");
            let only_period = controller.out_of_range(Some(period), None).to_string();
            let [backward, forward] = named(&only_period, "the speed must be ");
            let only_speed = controller.out_of_range(None, Some(fast)).to_string();
            let mut accepted = vec![
                (shortest, 0.0),
                (longest, 0.0),
                (longest, 2.0 * step / longest),
                (shortest, -2.0 * step / shortest),
                (period, backward),
                (period, forward),
            ];
            match only_speed.contains("the period must be ") {
                true => accepted.extend(named::<2>(&only_speed, "the period must be ").map(|period| (period, fast))),
                false => accepted.extend(named::<2>(&only_speed, "it must be ").map(|speed| (shortest, speed))),
            }
            for (period, speed) in accepted {
                let outcome = controller.set(Some(period), Some(speed));
                assert_eq!(outcome, Ok(()), "length ratio {ratio}; {only_period}; {only_speed}");
            }
        }
        let mut scene = similar(ratio);
        let mut at = |height: f64| {
            scene.controller.as_mut().expect("a controller").com_height = height;
            Controller::new(&scene).err()
        };
        let sentence = at(9.0 * ratio).expect("a refusal").to_string();
        for height in named::<2>(&sentence, "this robot reaches ") {
            assert_eq!(at(height), None, "length ratio {ratio}: {sentence}");
        }
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
