//! A steel foot falls 0.1 m and comes to rest, beside the exact answer: `cargo run --release --example fall`

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

/// Prints time, height of the sole and its error.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut plant = plant::Plant::new(&messages::load::parse(SCENE, "fall")?)?;
    for period in 1..=20 {
        plant.advance(&Default::default())?; // no motors: the torques are zero
        let t = 0.01 * f64::from(period);
        let height = plant.truth().base_position[2] - 0.025; // the base is the centre of the box
        let error = height - (0.1 - 0.5 * 9.81 * t * t).max(0.0);
        println!("{t:.2} s: {height:.9} m, error {error:.0e} m");
        assert!(error.abs() < 1e-12);
    }
    Ok(())
}
