//! Claims about the torques between controller and joints.

use biped_plant::drive::Drives;
use biped_plant::validation::CommandValidator;
use messages::scene::PlantScene;
use messages::wire::{Command, Refusal, Stamp, Stamped, Torques};

/// The torques that act in each of 2000 periods. The command differs in every period.
fn acting_torques(stale_probability: f64) -> Vec<f64> {
    let scene = PlantScene { stale_probability, torque_limit: 1e4, ..PlantScene::default() };
    let mut drives = Drives::new(&scene);
    (1..=2000).map(|k| drives.apply(&Torques { torque: [f64::from(k); 8] }).torque[0]).collect()
}

#[test]
fn a_period_repeats_the_torques_before_it_with_the_probability_of_the_scene() {
    for probability in [0.0, 0.25, 1.0] {
        let torques = acting_torques(probability);
        let repeated = torques.windows(2).filter(|pair| pair[0] == pair[1]).count() as f64 / 1999.0;
        assert!((repeated - probability).abs() < 0.05, "{repeated} of the periods, not {probability}");
    }
}

/// The drives clamp a command beyond their limit, so the next jump begins at the limit and not at the command.
#[test]
fn a_jump_counts_from_the_torque_that_the_drives_gave() {
    let (run, limit) = (7, 40.0);
    let command = |seq, torque: f64| {
        let stamp = Stamp { run, epoch: 1, seq, ack: seq, ..Stamp::default() };
        Command { stamp, torques: Torques { torque: [torque; 8] }, ..Command::default() }.sealed()
    };
    let mut validator = CommandValidator::new(run, limit);
    assert!(validator.validate(&command(1, 2.0 * limit), 1).is_ok());
    assert_eq!(validator.validate(&command(2, -1.1 * limit), 2), Err(Refusal::TooSteep));
    assert!(validator.validate(&command(3, -limit), 3).is_ok(), "from one limit to the other");
}
