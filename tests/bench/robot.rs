//! The motions of the robot that are measured: scenes, with the recorded torques of their controller.

use controller::Controller;
use messages::load::{SCENES, load};
use messages::scene::Scene;
use messages::wire::{Encoders, Torques, Truth};
use plant::Plant;
use plant::contact::Problem;
use plant::state::State;
use std::ops::Range;

/// A motion of the robot of Table 1, by the paper's method (12) with one step of 1 ms in each control period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Activity {
    /// Free rotation without gravity, with all joints moving.
    Flying,
    /// Standing on eight contact points, held by springs and dampers.
    Standing,
    /// Two steps of the paper's walk.
    Walking,
    /// Falling after a push: on an edge, on a corner, in the air.
    Tumbling,
}

impl Activity {
    /// The whole walk.
    pub const ALL: [Activity; 4] = [Activity::Flying, Activity::Standing, Activity::Walking, Activity::Tumbling];

    /// The scene of the motion.
    pub fn scene(self, settings: &[String]) -> Scene {
        let (name, own): (_, &[&str]) = match self {
            Activity::Flying => ("free", &["plant.method=SemiImplicitEuler", "plant.dt=0.001", "rate=1000"]),
            Activity::Standing => ("stand0", &["plant.method=SemiImplicitEuler"]),
            Activity::Walking => ("walk", &[]),
            Activity::Tumbling => ("stand", &["plant.push_impulse=[0.0, 40.0, 0.0]", "plant.push_time=0.3"]),
        };
        let settings: Vec<_> = own.iter().map(|setting| setting.to_string()).chain(settings.to_vec()).collect();
        load(name, &settings, SCENES).expect("a good scene")
    }

    /// The control periods that are measured.
    pub fn window(self) -> Range<usize> {
        match self {
            Activity::Flying => 0..1000,
            Activity::Standing => 500..1500,
            Activity::Walking => 5000..5600,
            Activity::Tumbling => 300..900,
        }
    }
}

/// The record of a motion up to the end of the measured window.
pub struct Recording {
    pub scene: Scene,
    pub window: Range<usize>,
    /// Encoder counts before each period.
    pub encoders: Vec<Encoders>,
    /// Torques of each period.
    pub torques: Vec<Torques>,
    /// States before each period of the window.
    pub states: Vec<State>,
    /// The same states, as messages of truth.
    pub truths: Vec<Truth>,
    /// Contact problems of the periods with contact in the window. Standing feet count as separate contacts.
    pub problems: Vec<Problem>,
}

impl Recording {
    /// Simulates the motion once.
    pub fn of(activity: Activity, settings: &[String]) -> Recording {
        Recording::over(activity, settings, activity.window())
    }

    /// The same with another window. If the scene ends early, the window is shorter.
    pub fn over(activity: Activity, settings: &[String], window: Range<usize>) -> Recording {
        let scene = activity.scene(settings);
        let mut plant = Plant::new(&scene).expect("a good scene");
        let mut posing = Plant::new(&scene).expect("a good scene").without_standing_feet();
        let controller = scene.controller.as_ref().map(|_| Controller::new(&scene));
        let mut controller = controller.transpose().expect("a good scene");
        let (encoders, torques, states, truths, problems) = Default::default();
        let mut recording = Recording { scene, window, encoders, torques, states, truths, problems };
        for period in 0..recording.window.end {
            let encoders = plant.encoders();
            // After a fall the controller may fail. The torques are then zero.
            let tick = |controller: &mut Controller| controller.tick(&encoders).unwrap_or_default();
            let torques = controller.as_mut().map(tick).unwrap_or_default();
            let (state, truth) = (plant.state().clone(), plant.truth());
            if plant.advance(&torques).is_err() || posing.advance(&torques).is_err() {
                recording.window.end = period;
                break;
            }
            recording.encoders.push(encoders);
            recording.torques.push(torques);
            if recording.window.contains(&period) {
                recording.states.push(state);
                recording.truths.push(truth);
                recording.problems.extend(Some(posing.problem()).filter(|problem| problem.contacts > 0).cloned());
            }
        }
        assert!(!recording.window.is_empty(), "{activity:?} breaks off before it begins");
        recording
    }
}

/// A plant that repeats the window, with the same bits each time.
pub struct Replay {
    recording: Recording,
    plant: Plant,
    period: usize,
}

impl Replay {
    /// At the beginning of the window.
    pub fn of(recording: Recording) -> Replay {
        let plant = Plant::new(&recording.scene).expect("a good scene");
        let mut replay = Replay { period: recording.window.end, recording, plant };
        replay.torques();
        replay
    }

    /// The torques of the next period. At the end of the window the plant is reset to its start, which takes long.
    pub fn torques(&mut self) -> Torques {
        let Range { start, end } = self.recording.window;
        if self.period == end {
            self.plant = Plant::new(&self.recording.scene).expect("a good scene");
            self.period = 0;
            while self.period < start {
                self.advance(&self.recording.torques[self.period].clone());
            }
        }
        self.recording.torques[self.period]
    }

    /// Simulates one period.
    pub fn advance(&mut self, torques: &Torques) {
        self.plant.advance(torques).expect("it did before");
        self.period += 1;
    }
}
