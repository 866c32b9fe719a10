//! What the laws have in common, and what parts them.

use super::Problem;
use messages::scene::Law;

/// Tangents that a law resists: its K has `1 + tangents(law)` columns per contact.
pub fn tangents(law: Law) -> usize {
    match law {
        Law::EnergyQp | Law::Complementarity => 1,
        _ => 2,
    }
}

/// Whether the law's own problem ends at a complementary basis, on rays along its tangents, whose impulse is the solution of a
/// linear system: exact to rounding, as `plant.tolerance` asks in every step. The first tangent is the direction of the free slip.
///
/// The other laws come nearer with each iteration and say with `fallback` where they did not come near enough, or evaluate a
/// formula. Their tangents are the world's x and y: a round cone looks the same along any, and an impulse remembered along them
/// means the same in the next step.
pub fn has_basis(law: Law) -> bool {
    matches!(law, Law::EnergyQp | Law::EnergyQpGap | Law::Complementarity | Law::Aligned)
}

/// Whether the law's impulse can never raise the energy.
///
/// A spring gives back what it was compressed with by somebody else, and sweeps that stop early leave a bound of friction
/// behind that is no longer that of their normal impulse.
pub fn is_plastic(law: Law) -> bool {
    !matches!(law, Law::SpringDamper | Law::Sweep(_))
}

/// Whether the law's impulses are Coulomb's however large the slip: no energy program, no springs, no memory of forces.
pub fn is_coulomb(law: Law) -> bool {
    matches!(law, Law::Complementarity | Law::Aligned | Law::Facets(_) | Law::Cone | Law::FixedPoint(_))
}

/// Speed at which contact i may still approach the ground [m/s]: what is added to v_N in (18) and (19).
///
/// The paper's conditions speak of velocity alone, so a contact with a gap is stopped above the ground. The other laws let
/// it close its gap and no more: `0 <= f_N _|_ v_N + gap/h >= 0` lands exactly on the ground. At rest both are the same.
/// Where restitution throws a contact back, it is negative under every law.
pub(super) fn approach_offset(problem: &Problem, law: Law, i: usize) -> f64 {
    match law {
        Law::EnergyQp | Law::Complementarity => problem.approach[i].min(0.0),
        _ => problem.approach[i],
    }
}
