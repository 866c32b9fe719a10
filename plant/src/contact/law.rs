//! Properties in which the contact laws differ. Every `match` names all laws, so the compiler asks for those of a new one.

use super::problem::Problem;
use messages::scene::Law;

/// Number of tangents along which a law has friction: its K has `1 + tangents(law)` columns per contact.
pub fn tangents(law: Law) -> usize {
    match law {
        Law::EnergyQp | Law::Complementarity => 1,
        Law::EnergyQpGap | Law::Lagged | Law::Aligned | Law::Facets(_) | Law::Cone | Law::ConeQp => 2,
        Law::SpringDamper | Law::FixedPoint(_) | Law::Sweep(_) => 2,
    }
}

/// Whether the law's solution is a complementary basis, with edges of the cone along the tangents. Its impulse then solves a linear system
/// and is exact to rounding, as a scene with `plant.tolerance` requires in every step. The first tangent is the direction of the free slip.
///
/// The other laws iterate, and set `fallback` if they did not converge, or evaluate a formula. Their tangents are the world's x and y: a
/// round cone is the same along any tangents, and a remembered impulse keeps its meaning in the next step.
pub fn has_basis(law: Law) -> bool {
    match law {
        Law::EnergyQp | Law::EnergyQpGap | Law::Complementarity | Law::Aligned => true,
        Law::Lagged | Law::Facets(_) | Law::Cone | Law::ConeQp | Law::FixedPoint(_) | Law::Sweep(_) => false,
        Law::SpringDamper => false,
    }
}

/// Whether the law's impulse can never raise the energy.
///
/// A spring returns energy that another motion stored in it. Sweeps that stop early leave friction bounded by an outdated normal impulse.
pub fn is_plastic(law: Law) -> bool {
    match law {
        Law::EnergyQp | Law::EnergyQpGap | Law::Lagged | Law::Complementarity | Law::Aligned | Law::Facets(_) => true,
        Law::Cone | Law::ConeQp | Law::FixedPoint(_) => true,
        Law::SpringDamper | Law::Sweep(_) => false,
    }
}

/// Whether the law's impulses obey Coulomb's law at any slip speed: no energy program, no springs, no lagged bounds.
pub fn is_coulomb(law: Law) -> bool {
    match law {
        Law::Complementarity | Law::Aligned | Law::Facets(_) | Law::Cone | Law::FixedPoint(_) => true,
        Law::EnergyQp | Law::EnergyQpGap | Law::Lagged | Law::ConeQp | Law::Sweep(_) | Law::SpringDamper => false,
    }
}

/// Whether the law stops a listed contact above the ground: the paper's conditions contain velocities alone. The other laws let it close its
/// gap and no more: `0 <= f_N ⟂ v_N + gap/h >= 0` lands exactly on the ground. At rest, both are the same.
pub fn stops_at_any_height(law: Law) -> bool {
    match law {
        Law::EnergyQp | Law::Complementarity => true,
        Law::EnergyQpGap | Law::Lagged | Law::Aligned | Law::Facets(_) | Law::Cone | Law::ConeQp => false,
        Law::SpringDamper | Law::FixedPoint(_) | Law::Sweep(_) => false,
    }
}

/// Radius of the greatest disc within the friction cone of a law, relative to μ, for any directions of its tangents. `None` for laws
/// that standing feet may violate.
pub fn disc(law: Law) -> Option<f64> {
    match law {
        Law::Cone => Some(1.0),
        Law::Aligned => Some(std::f64::consts::FRAC_1_SQRT_2),
        Law::EnergyQp | Law::EnergyQpGap | Law::Lagged | Law::Complementarity | Law::Facets(_) | Law::ConeQp => None,
        Law::SpringDamper | Law::FixedPoint(_) | Law::Sweep(_) => None,
    }
}

/// Offset that a law adds to v_N in (18) and (19) [m/s]: the speed at which contact i may still approach the ground. Where a contact
/// bounces, it is negative under every law.
pub(super) fn approach_offset(problem: &Problem, law: Law, i: usize) -> f64 {
    if stops_at_any_height(law) { problem.approach[i].min(0.0) } else { problem.approach[i] }
}
