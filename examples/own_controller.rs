//! A controller of your own in the same process: a spring and a damper at each joint hold the robot upright.
//!
//!     cargo run --release --example own_controller

use messages::load;
use messages::wire::Torques;
use plant::Plant;
use std::error::Error;
use std::f64::consts::TAU;

const STIFFNESS: f64 = 1000.0; // [N·m/rad]
const DAMPING: f64 = 20.0; // [N·m·s/rad]
const SCENE: &str = r#"
plant = { dt = 0.001 } # the robot is that of Table 1; one step per control period of 1 ms
initial = { clearance = 0.0, joints = [0.0, 0.4943, -1.5177, 1.0234, -1.0234, 1.5177, -0.4943, 0.0] }
"#;

/// Stands for two seconds, and prints how far the trunk has moved.
pub fn main() -> Result<(), Box<dyn Error>> {
    let scene = load::parse(SCENE, "stand")?;
    let mut plant = Plant::new(&scene)?;
    let radians = TAU / 2f64.powi(scene.plant.encoder_bits as i32); // of one encoder count
    let angles = |plant: &Plant| plant.encoders().counts.map(|count| radians * count as f64);
    let (wanted, start) = (angles(&plant), plant.truth().base_position[2]);
    let mut before = wanted;
    for _ in 0..2000 {
        let q = angles(&plant);
        let torque = |k: usize| STIFFNESS * (wanted[k] - q[k]) - DAMPING * (q[k] - before[k]) * scene.rate;
        plant.advance(&Torques { torque: std::array::from_fn(torque) })?;
        before = q;
    }
    let sunk = start - plant.truth().base_position[2];
    println!("after {} s the trunk is {:.2} mm lower", plant.time_ns() as f64 * 1e-9, 1e3 * sunk);
    assert!((0.0..0.01).contains(&sunk), "the robot fell");
    Ok(())
}
