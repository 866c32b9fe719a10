//! The bits of a contact's basis. They encode a [`BasisStatus`], or the set of its basic edges.

use super::super::memory::LastContact;
use super::super::mode::ContactMode;
use super::super::tolerance::MIN_SLIP;
use super::scaled_problem::ScaledProblem;
use super::square_cone;

/// Marks bits that are the basic edges of the energy program, not a [`BasisStatus`].
pub(super) const EDGES: u8 = 0x80;

/// The basic edges of a contact; none for a sticking contact, because the status does not contain its edges.
pub(super) fn edges(bits: u8, d: usize) -> u8 {
    if bits & EDGES != 0 {
        return bits ^ EDGES;
    }
    match BasisStatus::read(bits, d) {
        BasisStatus::Open | BasisStatus::Sticking => 0,
        BasisStatus::Sliding(j) => 1 << j,
        BasisStatus::SlidingBetween(j, k) => 1 << j | 1 << k,
    }
}

/// The bits of a contact in the last step. A contact of a standing foot has none, so it counts as sticking.
pub(super) fn recall(last: LastContact, d: usize) -> u8 {
    match (last.basis, last.mode) {
        (0, ContactMode::Open) => 0,
        (0, _) => BasisStatus::Sticking.write(d),
        (bits, _) => bits,
    }
}

/// Converts the contacts that slip at the optimum of the energy program to a status; the others keep their edges.
pub(super) fn mark_sliding(scaled: &ScaledProblem, f: &[f64], v: &[f64], basis: &mut [u8]) {
    let (d, stride) = (scaled.facets(), scaled.stride());
    let least = MIN_SLIP * square_cone::scale(scaled, f);
    for (i, bits) in basis.iter_mut().enumerate() {
        let slips = (1..stride).any(|k| v[i * stride + k].abs() > least);
        if slips {
            *bits = BasisStatus::read(*bits, d).write(d);
        }
    }
}

/// Converts the basis to a complementary one. A sticking contact is carried by one facet of each tangent, depending on the sign of `f`.
pub(super) fn complement(scaled: &ScaledProblem, f: &[f64], basis: &mut [u8]) {
    let (d, stride) = (scaled.facets(), scaled.stride());
    for (bits, f) in basis.iter_mut().zip(f.chunks_exact(stride)) {
        let guess = BasisStatus::read(*bits, d);
        *bits = match guess {
            BasisStatus::Sticking => {
                (1..stride).fold(1, |bits, k| bits | 1 << (1 + ScaledProblem::facet_along(k, f[k] > 0.0)))
            }
            _ => guess.write(d),
        };
    }
}

/// State of a contact in a complementary basis, in terms of facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BasisStatus {
    Open,
    Sticking,
    Sliding(usize),
    SlidingBetween(usize, usize),
}

impl BasisStatus {
    /// From the bits: 0 the normal, 1 + j facet j, d + 1 the slip speed.
    fn read(bits: u8, d: usize) -> BasisStatus {
        if bits & EDGES != 0 {
            let mut active = (0..d).filter(|j| bits >> j & 1 == 1);
            return match (active.next(), active.next(), active.next()) {
                (None, ..) => BasisStatus::Open,
                (Some(j), None, _) => BasisStatus::Sliding(j),
                (Some(j), Some(k), None) if j / 2 != k / 2 => BasisStatus::SlidingBetween(j, k),
                _ => BasisStatus::Sticking,
            };
        }
        let mut active = (0..d).filter(|j| bits >> (1 + j) & 1 == 1);
        let slips = bits >> (d + 1) & 1 == 1;
        match (bits & 1 == 1, slips, active.next(), active.next()) {
            (false, ..) => BasisStatus::Open,
            (true, true, Some(j), Some(k)) if j / 2 != k / 2 => BasisStatus::SlidingBetween(j, k),
            (true, true, Some(j), None) => BasisStatus::Sliding(j),
            (true, ..) => BasisStatus::Sticking,
        }
    }

    fn write(self, d: usize) -> u8 {
        let slip = 1 | 1 << (d + 1);
        match self {
            BasisStatus::Open => 0,
            BasisStatus::Sticking => (0..d).step_by(2).fold(1, |bits, j| bits | 1 << (1 + j)),
            BasisStatus::Sliding(j) => slip | 1 << (1 + j),
            BasisStatus::SlidingBetween(j, k) => slip | 1 << (1 + j) | 1 << (1 + k),
        }
    }
}
