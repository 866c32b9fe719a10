//! Drives and encoders between controller and joints: delay, lost periods, torque limits, resolution.

use messages::scene::PlantScene;
use messages::wire::{Encoders, JOINTS, Torques};
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// Drives and encoders of a robot.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Drives {
    /// Greatest torque [N·m].
    limit: f64,
    /// Encoder counts per radian.
    resolution: f64,
    /// Periods between a command and its effect.
    latency: usize,
    /// Probability that a period keeps the torques of the one before.
    stale: f64,
    #[serde(with = "crate::serial::random")]
    random: fastrand::Rng,
    queue: VecDeque<Torques>,
    applied: Torques,
}

impl Drives {
    /// Drives and encoders of a scene.
    pub fn new(scene: &PlantScene) -> Self {
        let latency = scene.latency_ticks as usize;
        Drives {
            limit: scene.torque_limit,
            resolution: 2f64.powi(scene.encoder_bits as i32) / TAU,
            latency,
            stale: scene.stale_probability,
            random: fastrand::Rng::with_seed(scene.seed),
            queue: VecDeque::with_capacity(latency + 1),
            applied: Torques::default(),
        }
    }

    /// Takes the command of one period and returns the torques that act in it [N·m].
    ///
    /// The delay line initially holds the first command, so that the robot starts in a stance that its torques hold.
    pub fn apply(&mut self, command: &Torques) -> Torques {
        while self.queue.len() <= self.latency {
            self.queue.push_back(*command);
        }
        let due = self.queue.pop_front().unwrap_or_default();
        if self.stale == 0.0 || self.random.f64() >= self.stale {
            self.applied.torque = due.torque.map(|torque| torque.clamp(-self.limit, self.limit));
        }
        self.applied
    }

    /// Encoder counts at the given joint angles [rad], rounded to the nearest count.
    pub fn read(&self, angles: impl Iterator<Item = f64>) -> Encoders {
        let mut counts = [0; JOINTS];
        for (count, angle) in counts.iter_mut().zip(angles) {
            *count = (angle * self.resolution).round() as i64;
        }
        Encoders { counts }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_acts_after_the_configured_number_of_periods() {
        let mut drives = Drives::new(&PlantScene { latency_ticks: 2, ..PlantScene::default() });
        let seen: Vec<f64> = (1..=5).map(|k| drives.apply(&Torques { torque: [f64::from(k); 8] }).torque[0]).collect();
        assert_eq!(seen, [1.0, 1.0, 1.0, 2.0, 3.0]);
    }

    #[test]
    fn an_encoder_is_never_off_by_more_than_half_a_count() {
        let drives = Drives::new(&PlantScene { encoder_bits: 12, ..PlantScene::default() });
        let angle = -0.123_456;
        let read = drives.read([angle].into_iter()).counts[0] as f64 * TAU / 4096.0;
        assert!((angle - read).abs() <= 0.5 * TAU / 4096.0);
    }
}
