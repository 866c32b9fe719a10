//! Constants and contract that both processes of the measurement share.

use messages::port::{Contract, Pace};
use messages::scene::Scene;
use std::time::Duration;

/// Time limit for the other process.
pub const PATIENCE: Duration = Duration::from_secs(3);
/// The message when this limit is exceeded.
pub const LOST: &str = "the other process of the measurement has fallen silent";

/// Contract of a link without a plant.
pub fn null_plant() -> Contract {
    Contract::of(&Scene::default(), Pace::Lockstep)
}
