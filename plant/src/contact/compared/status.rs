//! What each contact does, as the bits of a basis: of a complementary one ([`Status`]), or those of the edges along which it pushes.

use super::super::coulomb::Kind;
use super::super::memory::Contact;
use super::diamond;
use super::scaled::Scaled;

/// At the optimum of the energy program a contact slips if it is faster than this, relative to the step's scale.
const SLIPS: f64 = 1e-10;

/// Marks a contact whose bits are the edges along which it pushes, as in the energy program, not a [`Status`].
pub(super) const EDGES: u8 = 0x80;

/// The edges along which a contact pushed; none of one that stuck, of which they are not known.
pub(super) fn edges(bits: u8, d: usize) -> u8 {
    if bits & EDGES != 0 {
        return bits ^ EDGES;
    }
    match Status::read(bits, d) {
        Status::Open | Status::Sticks => 0,
        Status::Slides(j) => 1 << j,
        Status::SlidesBetween(j, k) => 1 << j | 1 << k,
    }
}

/// The bits of what a contact did in the last step; of one whose link stood they are not known.
pub(super) fn recall(last: Contact, d: usize) -> u8 {
    match (last.basis, last.kind) {
        (0, Kind::Open) => 0,
        (0, _) => Status::Sticks.write(d),
        (bits, _) => bits,
    }
}

/// Lets the contacts slide that do so at the optimum of the energy program; the others keep their edges.
pub(super) fn slide(scaled: &Scaled, f: &[f64], v: &[f64], basis: &mut [u8]) {
    let (d, stride) = (scaled.facets(), scaled.stride());
    let least = SLIPS * diamond::scale(scaled, f);
    for (i, bits) in basis.iter_mut().enumerate() {
        let slips = (1..stride).any(|k| v[i * stride + k].abs() > least);
        if slips {
            *bits = Status::read(*bits, d).write(d);
        }
    }
}

/// Writes the basis as a complementary one: what sticks is carried by one facet of each tangent, which `f` tells.
pub(super) fn complement(scaled: &Scaled, f: &[f64], basis: &mut [u8]) {
    let (d, stride) = (scaled.facets(), scaled.stride());
    for (bits, f) in basis.iter_mut().zip(f.chunks_exact(stride)) {
        let guess = Status::read(*bits, d);
        *bits = match guess {
            Status::Sticks => (1..stride).fold(1, |bits, k| bits | 1 << (1 + Scaled::facet_along(k, f[k] > 0.0))),
            _ => guess.write(d),
        };
    }
}

/// What a contact does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Status {
    Open,
    Sticks,
    Slides(usize),
    SlidesBetween(usize, usize),
}

impl Status {
    /// From the bits of a basis: 0 the normal, 1 + j facet j, d + 1 the slip speed.
    fn read(bits: u8, d: usize) -> Status {
        if bits & EDGES != 0 {
            let mut active = (0..d).filter(|j| bits >> j & 1 == 1);
            return match (active.next(), active.next(), active.next()) {
                (None, ..) => Status::Open,
                (Some(j), None, _) => Status::Slides(j),
                (Some(j), Some(k), None) if j / 2 != k / 2 => Status::SlidesBetween(j, k),
                _ => Status::Sticks,
            };
        }
        let mut active = (0..d).filter(|j| bits >> (1 + j) & 1 == 1);
        let slips = bits >> (d + 1) & 1 == 1;
        match (bits & 1 == 1, slips, active.next(), active.next()) {
            (false, ..) => Status::Open,
            (true, true, Some(j), Some(k)) if j / 2 != k / 2 => Status::SlidesBetween(j, k),
            (true, true, Some(j), None) => Status::Slides(j),
            (true, ..) => Status::Sticks,
        }
    }

    fn write(self, d: usize) -> u8 {
        let slip = 1 | 1 << (d + 1);
        match self {
            Status::Open => 0,
            Status::Sticks => (0..d).step_by(2).fold(1, |bits, j| bits | 1 << (1 + j)),
            Status::Slides(j) => slip | 1 << (1 + j),
            Status::SlidesBetween(j, k) => slip | 1 << (1 + j) | 1 << (1 + k),
        }
    }
}
