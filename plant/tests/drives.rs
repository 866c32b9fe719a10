//! Claims about the torques between controller and joints.

use biped_plant::command_pipeline::CommandPipeline;
use biped_plant::drive::Drives;
use biped_plant::validation::CommandValidator;
use messages::scene::{PlantScene, Scene};
use messages::wire::{Command, PlantState, Refusal, Sensors, Stamp, Stamped, Torques};
use std::f64::consts::TAU;

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

#[test]
fn a_command_beyond_the_limit_acts_as_the_limit() {
    let mut drives = Drives::new(&PlantScene { torque_limit: 12.0, ..PlantScene::default() });
    for (torque, acts) in [(11.9, 11.9), (12.1, 12.0), (47.0, 12.0), (-11.9, -11.9), (-12.1, -12.0), (-47.0, -12.0)] {
        assert_eq!(drives.apply(&Torques { torque: [torque; 8] }).torque, [acts; 8], "{torque} N·m");
    }
}

/// The command pipeline of a run with 100 encoder counts per radian and the rate 1000 Hz.
struct Run {
    pipeline: CommandPipeline,
    now: u64,
}

impl Run {
    fn new() -> Run {
        Run::with_torque_limit(Scene::default().plant.torque_limit)
    }

    fn with_torque_limit(limit: f64) -> Run {
        let mut scene = Scene::default();
        scene.plant.torque_limit = limit;
        Run { pipeline: CommandPipeline::new(&scene, 1), now: 0 }
    }

    /// Command `seq` of the controller `epoch`.
    fn command(&mut self, epoch: u32, seq: u64, torque: f64) {
        let stamp = Stamp { run: 1, epoch: epoch.into(), seq, ack: self.now, ..Stamp::default() };
        let command = Command { stamp, torques: Torques { torque: [torque; 8] }, ..Command::default() };
        self.pipeline.receive(&command.sealed(), self.now);
    }

    /// The torque that acts in the next period, while the encoders count one up per period.
    fn torque(&mut self) -> f64 {
        self.now += 1;
        let mut sensors = Sensors::default();
        (sensors.stamp.seq, sensors.encoders.counts) = (self.now, [self.now as i64; 8]);
        self.pipeline.torques(&sensors).torque[0]
    }
}

/// The old controller was silent for 20 periods, so the drives damp the joints. Its successor begins from that torque, not from the last
/// command of the old one.
#[test]
fn a_successor_takes_over_from_the_torques_that_acted() {
    let mut run = Run::new();
    run.command(1, 1, 30.0);
    let held = run.torque();
    let damped = (0..20).map(|_| run.torque()).last().unwrap_or_default();
    assert_eq!((held, run.pipeline.state()), (30.0, PlantState::Damp));
    let rate = 1000.0 * TAU / 2f64.powi(Scene::default().plant.encoder_bits as i32);
    assert!((damped + 2.0 * rate).abs() < 1e-15, "{damped} N·m are not the damping of {rate} rad/s");
    run.command(2, 1, -20.0);
    for step in 1..=7 {
        let w = f64::min(f64::from(step) / 5.0, 1.0);
        let (found, exact) = (run.torque(), (1.0 - w) * damped - 20.0 * w);
        assert!((found - exact).abs() < 1e-12, "period {step}: {found} instead of {exact}");
    }
}

/// Damping follows the strength of the drives: with that of a robot of 40 N·m, one of 1 N·m would brake with its full torque at .5 rad/s.
#[test]
fn drives_without_commands_brake_in_proportion_to_their_torque_limit() {
    let braked = |limit: f64| {
        let mut run = Run::with_torque_limit(limit);
        run.command(1, 1, 0.0);
        let torque = (0..20).map(|_| run.torque()).last().unwrap_or_default();
        assert_eq!(run.pipeline.state(), PlantState::Damp);
        torque
    };
    assert!(braked(40.0) < 0.0);
    for limit in [1e-3, 1.0, 160.0] {
        let (found, exact) = (braked(limit), braked(40.0) * limit / 40.0);
        assert!((found - exact).abs() <= 1e-15 * exact.abs(), "{limit} N·m: {found} instead of {exact} N·m");
    }
}

/// Commands are numbered, so a gap shows how many never arrived. The first command of a successor does not count as a gap.
#[test]
fn commands_that_never_arrived_are_counted() {
    let mut run = Run::new();
    for (epoch, seq, lost) in [(1, 1, 0), (1, 2, 0), (1, 5, 2), (1, 6, 2), (2, 9, 2), (2, 11, 3)] {
        while run.now < seq {
            run.torque();
        }
        run.command(epoch, seq, 0.0);
        assert_eq!(run.pipeline.tally().lost, lost, "after command {seq} of controller {epoch}");
    }
}
