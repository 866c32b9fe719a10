//! Error and cost of every method on the twelve comparison scenes: `cargo run --release -p plant --example time_methods [SCENE [METHOD [TOLERANCE]]]`.

#![expect(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "an example")]

use messages::load::load;
use messages::scene::{Method, Scene};
use messages::wire::Torques;
use plant::Plant;
use plant::kinematics::{self, Pose, Totals};
use std::time::Instant;

const SCENES: [&str; 12] =
    ["free", "slide", "slide30", "incline", "stick", "drop", "stand0", "stand10", "rock", "wheel", "turn", "ball"];
const STEPS: [f64; 5] = [0.02, 0.01, 0.005, 0.002, 0.001];

/// What a scene is scored by, over its run.
struct Watch {
    pose: Pose,
    start: Totals,
    place: [f64; 3],
    lowest: f64,
    feet: Vec<[f64; 3]>,
    /// Kinetic and potential energy after half a second [J].
    half: f64,
}

impl Watch {
    fn new(plant: &Plant) -> Self {
        let mut pose = Pose::new(plant.model());
        kinematics::pose(plant.model(), plant.state(), &mut pose);
        let start = kinematics::totals(plant.model(), plant.state(), &pose);
        let place = start.com.into();
        let feet = corners(plant, &pose);
        Watch { pose, start, place, lowest: f64::INFINITY, feet, half: f64::NAN }
    }

    fn look(&mut self, plant: &Plant) {
        kinematics::pose(plant.model(), plant.state(), &mut self.pose);
        let heights = corners(plant, &self.pose).into_iter().map(|corner| corner[2]);
        self.lowest = heights.fold(self.lowest, f64::min);
        if plant.time_ns() <= 500_000_000 {
            let now = kinematics::totals(plant.model(), plant.state(), &self.pose);
            self.half = now.kinetic + now.potential;
        }
    }

    fn error(&self, name: &str, plant: &Plant) -> f64 {
        let end = kinematics::totals(plant.model(), plant.state(), &self.pose);
        let way = (0..2).map(|k| (end.com[k] - self.place[k]).powi(2)).sum::<f64>().sqrt();
        match name {
            "free" => (end.kinetic - self.start.kinetic).abs(),
            "slide" | "slide30" => (way / 0.407_747_196_738_022_4 - 1.0).abs(),
            "incline" => {
                let (s, c) = 20f64.to_radians().sin_cos();
                (way / (0.5 * 9.81 * (s - 0.3 * c) * 4.0) - 1.0).abs()
            }
            "stick" => way / 5.0,
            "drop" => -self.lowest,
            "stand0" | "stand10" => {
                let moved = corners(plant, &self.pose).into_iter().zip(&self.feet);
                let far = moved.map(|(a, b)| ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sqrt());
                far.fold(0.0, f64::max) / 10.0
            }
            "rock" => {
                // flat, its centre is .2 m high: what is above that goes with the square of the ratio of speeds
                let flat = 9.81 * 0.2;
                let ratio = (self.half - flat) / (self.start.kinetic + self.start.potential - flat);
                (ratio.sqrt() / 0.911_764_705_882_352_9 - 1.0).abs()
            }
            "wheel" => (way / 4.0 / 0.784_571 - 1.0).abs(),
            "turn" => {
                let ahead = self.pose.links[plant.model().base_link].rotation.column(0).into_owned();
                (ahead.y.atan2(ahead.x) / 0.431_227_433_721 - 1.0).abs()
            }
            "ball" => {
                let axis = self.pose.links[plant.model().base_link].rotation.column(2).into_owned();
                ((axis.x.atan2(axis.z) + 0.070_267_594_408) / 1.2).abs()
            }
            _ => panic!("{name}"),
        }
    }
}

fn corners(plant: &Plant, pose: &Pose) -> Vec<[f64; 3]> {
    plant.model().corners.iter().map(|corner| pose.point(corner.link, &corner.at).into()).collect()
}

fn scene(name: &str, method: Method, dt: f64) -> Scene {
    let path = format!("{}/../launch/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let tolerance = std::env::args().nth(3).unwrap_or("1e-10".into());
    let settings = [
        format!("plant.method={method:?}"),
        format!("plant.dt={dt}"),
        format!("rate={}", 1.0 / dt),
        format!("plant.tolerance_step={tolerance}"),
    ];
    load(&path, &settings, &[]).expect("a good scene")
}

fn main() {
    let (only, method) = (std::env::args().nth(1), std::env::args().nth(2));
    println!("scene    method             dt ms  error       ms CPU/s  us/step  evals  events  warm   lowest gap");
    for name in SCENES.into_iter().filter(|name| only.as_deref().is_none_or(|only| only == *name)) {
        let wanted = |wanted: &Method| method.as_deref().is_none_or(|only| only == format!("{wanted:?}"));
        for method in Method::ALL.into_iter().filter(wanted) {
            for dt in STEPS {
                let scene = scene(name, method, dt);
                let steps = (scene.duration / dt).round() as usize;
                let mut plant = Plant::new(&scene).unwrap();
                let mut watch = Watch::new(&plant);
                let failed = (0..steps).find_map(|_| {
                    let failed = plant.advance(&Torques::default()).err();
                    watch.look(&plant);
                    failed
                });
                if let Some(error) = failed {
                    println!("{name:8} {:18} {:5} {error}", format!("{method:?}"), dt * 1e3);
                    continue;
                }
                let (error, counts, lowest) = (watch.error(name, &plant), plant.counts(), watch.lowest);
                let mut plant = Plant::new(&scene).unwrap();
                // the median of parts, for others may share the machine
                let mut times: Vec<f64> = (0..steps)
                    .map(|_| {
                        let start = Instant::now();
                        let _ = plant.advance(&Torques::default());
                        start.elapsed().as_secs_f64()
                    })
                    .collect();
                times.sort_by(f64::total_cmp);
                let time = times[..steps * 9 / 10].iter().sum::<f64>() / 0.9;
                println!(
                    "{name:8} {:18} {:5} {error:10.2e}  {:8.2}  {:7.2}  {:5.1}  {:6}  {:.3}  {lowest:.1e}",
                    format!("{method:?}"),
                    dt * 1e3,
                    time / scene.duration * 1e3,
                    time / steps as f64 * 1e6,
                    counts.evaluations as f64 / steps as f64,
                    counts.events,
                    counts.warm as f64 / counts.contacts as f64,
                );
            }
        }
    }
}
