//! MuJoCo as the plant, as source text: the files of `plant/foreign/mujoco`. `biped new plant` copies them.

/// The plant, which is the program.
pub const MUJOCO_PLANT: &str = include_str!("../foreign/mujoco/plant.py");
/// Its end of a session.
pub const MUJOCO_LINK: &str = include_str!("../foreign/mujoco/link.py");
