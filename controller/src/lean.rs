//! The lean of the gait: the distance by which its zero-moment point lies before the centre of the supporting sole.
//!
//! ```text
//!   ẍ_1 = ω_1² (x_1 − d) + u_1          (31) with the lean d
//!   τ_k = M g ∂x_c3/∂q_k                what the weight needs of the knee
//! ```
//! In the middle of a step the knee of the supporting leg carries the weight of the robot. If the centre of gravity is farther forward, it
//! is nearer to the knee. Then the knee needs less torque, and the ankle more. So a robot with weak drives leans forward by the least
//! distance with which its knee has enough torque left. The paper knows no limit of the torque, and no lean: a robot with strong drives has
//! d = 0. Neither has the paper's sagittal rule (42), in which the centre of gravity stays halfway between the feet.

use crate::posture::solve_posture;
use crate::support::{Chain, Joints, TaskVector};
use messages::robot::CROUCH;
use messages::scene::{ControllerScene, PlantScene, Sagittal};

/// Greatest τ_k over the torque limit [-]. The rest of the torque moves the legs and the drives. With this share the robot of the paper walks
/// at .2 m/s down to a limit of 11.5 N·m. At 12 N·m it walks evenly with shares of .65 to .75, and falls with .85.
const KNEE_SHARE: f64 = 0.72;
/// Greatest lean over the sole's half-depth [-]. In front of it the zero-moment point needs room to move: at 11.5 N·m the robot of the paper walks
/// with a lean of .7, and falls with .74.
const GREATEST: f64 = 0.7;
/// Number of distances that are tried, up to the greatest one: each 1 mm for the paper's robot.
const TRIED: u32 = 70;
/// The knee of the supporting leg, in support order.
const KNEE: usize = 2;

/// The lean [m], and the posture with the centre of gravity there. `target` is the task of that posture without lean. `None` if that has
/// no posture.
pub fn lean(chain: &Chain, scene: &ControllerScene, plant: &PlantScene, target: &TaskVector) -> Option<(f64, Joints)> {
    let greatest = match scene.sagittal {
        Sagittal::FootPlacement => GREATEST * chain.sole_half[0],
        Sagittal::Energy => 0.0,
    };
    let weight = chain.total_mass * plant.gravity;
    let mut found = None;
    for k in 0..=TRIED {
        let lean = greatest * f64::from(k) / f64::from(TRIED);
        let mut moved = *target;
        moved[0] += lean;
        let Some(s) = solve_posture(chain, &moved, &Joints::from(CROUCH)) else { break };
        found = Some((lean, s));
        let knee = weight * chain.task(&s).jacobian[(2, KNEE)]; // τ_k
        if knee.abs() <= KNEE_SHARE * plant.torque_limit {
            break;
        }
    }
    found
}
