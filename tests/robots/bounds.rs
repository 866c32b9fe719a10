//! Bounds that a refusal of the controller names, for robots of other sizes.

use crate::common::{scene, similar};
use controller::Controller;
use messages::load::with_robot;
use messages::scene::Scene;

/// The walk of a robot that is similar to that of Table 1, with lengths in this ratio, stepping in place.
fn walk(ratio: f64) -> Scene {
    let mut scene = with_robot(&scene("walk", &[]), &similar(ratio)).expect("a similar scene");
    scene.controller.as_mut().expect("a controller").speed = 0.0;
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
        let mut controller = Controller::new(&walk(ratio)).expect("a controller");
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
        let mut scene = walk(ratio);
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
