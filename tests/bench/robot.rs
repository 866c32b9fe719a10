//! What the robot does while it is measured: scenes, with the torques that their controller gave.

use controller::Controller;
use messages::load::load;
use messages::scene::Scene;
use messages::wire::{Encoders, Torques, Truth};
use plant::Plant;
use plant::contact::Problem;
use plant::state::State;
use std::ops::Range;

/// Something that the robot of Table 1 does, by the paper's steps (12), which are Euler's, of 1 ms, one to a control period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doing {
    /// It turns weightless, every joint moving.
    Flying,
    /// On eight corners, held by springs and dampers.
    Standing,
    /// Two steps of the paper's walk.
    Walking,
    /// Pushed over: on an edge, on a corner, in the air.
    Tumbling,
}

impl Doing {
    /// All of it.
    pub const ALL: [Doing; 4] = [Doing::Flying, Doing::Standing, Doing::Walking, Doing::Tumbling];

    /// Its scene.
    pub fn scene(self, settings: &[String]) -> Scene {
        let (name, own): (_, &[&str]) = match self {
            Doing::Flying => ("free", &["plant.method=SemiImplicitEuler", "plant.dt=0.001", "rate=1000"]),
            Doing::Standing => ("stand0", &["plant.method=SemiImplicitEuler"]),
            Doing::Walking => ("walk", &[]),
            Doing::Tumbling => ("stand", &["plant.push_impulse=[0.0, 40.0, 0.0]", "plant.push_time=0.3"]),
        };
        let path = format!("{}/launch/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let settings: Vec<_> = own.iter().map(|setting| setting.to_string()).chain(settings.to_vec()).collect();
        load(&path, &settings, &[]).expect("a good scene")
    }

    /// The periods that are measured.
    pub fn window(self) -> Range<usize> {
        match self {
            Doing::Flying => 0..1000,
            Doing::Standing => 500..1500,
            Doing::Walking => 5000..5600,
            Doing::Tumbling => 300..900,
        }
    }
}

/// What went between plant and controller, and what the plant met, up to the end of the window.
pub struct Recording {
    pub scene: Scene,
    pub window: Range<usize>,
    /// Of every period, before it.
    pub encoders: Vec<Encoders>,
    /// Of every period.
    pub torques: Vec<Torques>,
    /// Of every period of the window, before it.
    pub states: Vec<State>,
    /// The same as truths.
    pub truths: Vec<Truth>,
    /// Of every period of the window in which something touched, feet that stand posed contact by contact.
    pub problems: Vec<Problem>,
}

impl Recording {
    /// Plays it once; a scene that breaks off has a shorter window.
    pub fn of(doing: Doing, settings: &[String]) -> Recording {
        let (scene, window) = (doing.scene(settings), doing.window());
        let mut plant = Plant::new(&scene).expect("a good scene");
        let mut posing = Plant::new(&scene).expect("a good scene").without_standing_feet();
        let controller = scene.controller.as_ref().map(|_| Controller::new(&scene));
        let mut controller = controller.transpose().expect("a good scene");
        let (encoders, torques, states, truths, problems) = Default::default();
        let mut recording = Recording { scene, window, encoders, torques, states, truths, problems };
        for period in 0..recording.window.end {
            let encoders = plant.encoders();
            // a controller that gives up after a fall leaves the joints to themselves
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
        assert!(!recording.window.is_empty(), "{doing:?} breaks off before it begins");
        recording
    }
}

/// A plant that goes through the window again and again, to the same bits.
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

    /// Those of the next period. At the end of the window it goes back to the beginning, which takes long.
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

    /// One period.
    pub fn advance(&mut self, torques: &Torques) {
        self.plant.advance(torques).expect("it did before");
        self.period += 1;
    }
}
