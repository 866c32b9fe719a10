//! Contact points between events.

use nalgebra::Vector3;

/// State of a contact point: at the beginning of the step, and according to its last force.
///
/// Gap and slip of an active or sticking contact drift by the method's error. So its last force decides whether it stays active or sticking;
/// its gap and slip do not.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct EventContact {
    /// The contact is active: it carries load, or would carry load if it were pressed.
    pub active: bool,
    /// The contact is active and does not slip.
    pub sticking: bool,
    /// Height above the ground that it meets; infinite where there is no ground [m].
    pub gap: f64,
    /// Rate of that height, after the impact of the points that land [m/s].
    pub rate: f64,
    /// Height of the tile under it [m].
    pub tile: f64,
    /// Direction of slip.
    pub slip_direction: Vector3<f64>,
    /// Speed of slip [m/s].
    pub speed: f64,
    /// The last force was compressive.
    pub pressed: bool,
    /// The last force left no tangential acceleration.
    pub held: bool,
}

impl EventContact {
    /// Whether it is active and carries load by its last force, over ground.
    pub fn carries_load(&self) -> bool {
        self.active && self.pressed && self.gap.is_finite()
    }
}
