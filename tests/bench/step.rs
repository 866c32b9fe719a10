//! A whole step of the plant, a whole tick of the controller, and a whole second of both.

use crate::robot::{Activity, Recording, Replay};
use controller::Controller;
use divan::Bencher;
use plant::Plant;
use std::cell::RefCell;

/// Each sample is one step; the steps are in the order of the motion.
#[divan::bench(args = Activity::ALL, sample_count = 3000, sample_size = 1)]
fn plant_step(bencher: Bencher, activity: Activity) {
    let replay = RefCell::new(Replay::of(Recording::of(activity, &[])));
    bencher
        .with_inputs(|| replay.borrow_mut().torques())
        .bench_local_values(|torques| replay.borrow_mut().advance(&torques));
}

/// Without bounds the QP has a closed form. With bounds on rates it is solved by an interior-point method.
#[divan::bench(args = ["without bounds", "within bounds"], sample_count = 3000, sample_size = 1)]
fn controller_tick(bencher: Bencher, bounds: &str) {
    let settings = if bounds == "within bounds" { vec!["controller.rate_limit=11".into()] } else { vec![] };
    let Recording { scene, window, encoders, .. } = Recording::of(Activity::Walking, &settings);
    let begun = || Controller::new(&scene).expect("a good scene");
    let controller = RefCell::new(begun());
    let mut period = window.end;
    let heard = || {
        if period == window.end {
            *controller.borrow_mut() = begun();
            period = window.start;
            encoders[..period].iter().for_each(|before| drop(controller.borrow_mut().tick(before)));
        }
        period += 1;
        &encoders[period - 1]
    };
    bencher.with_inputs(heard).bench_local_values(|encoders| controller.borrow_mut().tick(encoders));
}

/// A simulated second of the walk, plant and controller in one process.
#[divan::bench(sample_count = 30, sample_size = 1)]
fn second_in_one_process(bencher: Bencher) {
    let scene = Activity::Walking.scene(&[]);
    let begun = || {
        let (plant, controller) = (Plant::new(&scene), Controller::new(&scene));
        (plant.expect("a good scene"), controller.expect("a good scene"))
    };
    bencher.with_inputs(begun).bench_local_values(|(mut plant, mut controller)| {
        let mut encoders = plant.encoders();
        for _ in 0..1000 {
            let torques = controller.tick(&encoders).expect("it walks");
            encoders = plant.advance(&torques).expect("it walks");
        }
    });
}
