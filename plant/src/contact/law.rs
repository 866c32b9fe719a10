//! Properties in which the contact laws differ.

use super::problem::Problem;
use messages::scene::Law;

/// Number of tangents along which a law has friction: its K has `1 + tangents(law)` columns per contact.
pub fn tangents(law: Law) -> usize {
    match law {
        Law::EnergyQp | Law::Complementarity => 1,
        _ => 2,
    }
}

/// Whether the law's solution is a complementary basis, with edges of the cone along the tangents. Its impulse then solves a linear system
/// and is exact to rounding, as a scene with `plant.tolerance` requires in every step. The first tangent is the direction of the free slip.
///
/// The other laws iterate, and set `fallback` if they did not converge, or evaluate a formula. Their tangents are the world's x and y: a
/// round cone is the same along any tangents, and a remembered impulse keeps its meaning in the next step.
pub fn has_basis(law: Law) -> bool {
    matches!(law, Law::EnergyQp | Law::EnergyQpGap | Law::Complementarity | Law::Aligned)
}

/// Whether the law's impulse can never raise the energy.
///
/// A spring returns energy that another motion stored in it. Sweeps that stop early leave friction bounded by an outdated normal impulse.
pub fn is_plastic(law: Law) -> bool {
    !matches!(law, Law::SpringDamper | Law::Sweep(_))
}

/// Whether the law's impulses obey Coulomb's law at any slip speed: no energy program, no springs, no lagged bounds.
pub fn is_coulomb(law: Law) -> bool {
    matches!(law, Law::Complementarity | Law::Aligned | Law::Facets(_) | Law::Cone | Law::FixedPoint(_))
}

/// Offset that a law adds to v_N in (18) and (19) [m/s]: the speed at which contact i may still approach the ground.
///
/// The paper's conditions contain velocities alone, so they stop a contact above the ground. The other laws let it close its gap and no
/// more: `0 <= f_N ⟂ v_N + gap/h >= 0` lands exactly on the ground. At rest, both are the same. Where a contact bounces, the offset is
/// negative under every law.
pub(super) fn approach_offset(problem: &Problem, law: Law, i: usize) -> f64 {
    match law {
        Law::EnergyQp | Law::Complementarity => problem.approach[i].min(0.0),
        _ => problem.approach[i],
    }
}
