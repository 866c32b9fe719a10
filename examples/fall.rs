//! A steel foot falls 0.1 m and comes to rest. Each row compares its height with the exact answer.
//!
//!     cargo run --release --example fall

use messages::load;
use plant::Plant;
use std::error::Error;

const SCENE: &str = r#"
rate = 100.0 # [Hz]
plant = { dt = 0.01 }
initial = { clearance = 0.1 } # height of the lowest contact point [m]
[[bodies]]
name = "foot"
mass = 1.0
size = [0.2, 0.1, 0.05]
contacts = [[0.1, 0.05, -0.025], [0.1, -0.05, -0.025], [-0.1, 0.05, -0.025], [-0.1, -0.05, -0.025]]
"#;

/// Prints time, height of the sole, exact height and error.
pub fn main() -> Result<(), Box<dyn Error>> {
    let scene = load::parse(SCENE, "fall")?;
    let mut plant = Plant::new(&scene)?;
    println!("{:>6} {:>12} {:>12} {:>8}", "t [s]", "height [m]", "exact [m]", "error");
    for period in 1..=20 {
        plant.advance(&Default::default())?; // no motors: the torques are zero
        let t = f64::from(period) / scene.rate;
        let height = plant.truth().base_position[2] - 0.025; // that of the body's centre
        let exact = (0.1 - 0.5 * scene.plant.gravity * t * t).max(0.0);
        println!("{t:>6.2} {height:>12.9} {exact:>12.9} {:>8.0e}", height - exact);
        assert!((height - exact).abs() < 1e-12, "{t} s");
    }
    Ok(())
}
