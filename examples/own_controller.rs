//! A controller of your own in one process with the plant: a spring and a damper at each joint hold the robot upright.
//! `cargo run --release --example own_controller`

use messages::wire::Torques;
use plant::Plant;

const STIFFNESS: f64 = 1000.0; // [N·m/rad]
const DAMPING: f64 = 20.0; // [N·m·s/rad]

/// Stands for two seconds, and prints how far the trunk has moved.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = messages::load::built_in("stand")?;
    let mut plant = Plant::new(&scene)?;
    let angles = |plant: &Plant| plant.encoders().angles(scene.plant.radians_per_count()); // [rad]
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
