//! The numbers by which Coulomb's law is solved and judged, each with its unit and what it follows from.

/// A natural map up to this is a solution [-]. Below the 1e-10 that every step promises, so that a second evaluation, which rounds
/// differently, also finds less than that.
pub(crate) const SOLVED: f64 = 4e-11;

/// The natural map that every solved step promises [-].
pub const PROMISED: f64 = 1e-10;

/// Compliance of the contacts [-]: what is added to the scaled A, whose diagonal of the normal is 1.
///
/// Two feet of one robot press against each other along directions that A holds at 1e-12 or not at all. With the compliance the impulse
/// there is the one of least norm, not a quotient of two roundings. Half of [`SOLVED`]: what it moves is then seldom too much.
pub(crate) const COMPLIANCE: f64 = 0.5 * SOLVED;

/// Rounding of A f + b, as a part of the size of its terms [-]. A contact cannot be judged more finely than that.
pub(super) const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// What is left of the diagonal of A when a direction depends on those before it, as a part of the greatest [-]. A has 16 digits, so
/// what is left of a dependent direction is near 1e-16.
pub(super) const DEPENDENT: f64 = 1e-12;

/// A diagonal entry of A this small beside the largest is a direction in which the contact cannot move [-]. A = YᵀY has squared rounding
/// on its diagonal, so an honest zero is near 1e-32.
pub(super) const IMMOVABLE: f64 = 1e-20;

/// Compliance of the contacts while Lemke's method pivots in 32 digits [-], added to the scaled A, whose diagonal is 1. It lies far above
/// the rounding of A (1e-16), so that there is one solution, and a tenth of [`SOLVED`], so that it does not show in the residual.
pub(super) const LEMKE_COMPLIANCE: f64 = 4e-12;
