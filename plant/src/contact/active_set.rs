//! Guess what each contact does, solve, correct the guess: the way to the basis that a walking robot's step needs.
//!
//! Every contact is open, sticks, slides against one facet, or slides between two facets. For a guess the impulse follows
//! from one linear system ([`Block`]); then each contact whose impulse or velocity contradicts the guess changes:
//!
//! | guess | contradicted by | becomes |
//! |---|---|---|
//! | open | v_N < 0 (18) | sticks |
//! | any other | f_N < 0 (17) | open |
//! | sticks | |f_F| > mu f_N (20) | slides against the facet that carries most |
//! | slides | slip along its friction (21) | sticks |
//! | slides against one facet | faster slip along the other tangent | slides between both |
//! | slides between two | one of them pulls | slides against the other |
//!
//! This is Newton's method on the natural map, whose pieces are linear. It ends after two or three rounds where a step
//! resembles the last, and has no proof that it ends at all; [`super::lemke`] has, and stands behind it.

use super::basis::Block;
use super::residual;
use super::scaled::Scaled;
use messages::scene::Law;

/// Rounds in which all contradicted guesses change at once; then one at a time, so that they cannot swap for ever.
const BOLD: usize = 4;
/// Rounds at most; of few contacts one more than [`BOLD`] for each.
const ROUNDS: usize = 8;
/// Contradictions smaller than this, relative to the step's scale, are rounding.
const ROUNDING: f64 = 1e-13;
/// At the optimum of the energy program a contact slips if it is faster than this, likewise.
const SLIPS: f64 = 1e-10;

/// Corrects `basis` until nothing contradicts it and adds the rounds to `count`; false if it does not end. Leaves impulse
/// and velocity in `f`, `v`.
pub(super) fn settle(
    scaled: &Scaled,
    law: Law,
    block: &mut Block,
    basis: &mut [u8],
    f: &mut Vec<f64>,
    v: &mut Vec<f64>,
    count: &mut u32,
) -> bool {
    for round in 0..ROUNDS.min(BOLD + basis.len()) {
        if !block.solve(scaled, law, basis, f, v) {
            return false;
        }
        if block.is_dependent() {
            return false; // contacts that yield share the load; rigid ones would take it in the order of their rows
        }
        if !correct(scaled, f, v, basis, round < BOLD) {
            return true;
        }
        *count += 1;
    }
    false
}

/// Corrects the guesses that impulse and velocity contradict, all of them or the first; false if none is.
fn correct(scaled: &Scaled, f: &[f64], v: &[f64], basis: &mut [u8], all: bool) -> bool {
    let least = ROUNDING * residual::scale(scaled, f);
    let mut changed = false;
    for (i, bits) in basis.iter_mut().enumerate() {
        let better = Guess::read(*bits, scaled.facets()).corrected(scaled, i, f, v, least).write(scaled.facets());
        changed |= better != *bits;
        *bits = better;
        if changed && !all {
            break;
        }
    }
    changed
}

/// Marks a contact whose bits are the rays that span its impulse, as in the energy program, not a [`Guess`].
pub(super) const RAYS: u8 = 0x80;

/// The rays along which a contact pushed.
pub(super) fn rays(bits: u8, d: usize) -> u8 {
    if bits & RAYS != 0 {
        return bits ^ RAYS;
    }
    match Guess::read(bits, d) {
        Guess::Open => 0,
        Guess::Sticks => (1 << d) - 1,
        Guess::Slides(j) => 1 << j,
        Guess::SlidesBetween(j, k) => 1 << j | 1 << k,
    }
}

/// The rays that span an impulse of contact `i` within its cone, or the nearest of one outside.
pub(super) fn rays_of(scaled: &Scaled, i: usize, f: &[f64]) -> u8 {
    if f[0] <= 0.0 {
        return 0;
    }
    let reach = &scaled.reach[i * f.len()..];
    let (mut rays, mut friction) = (0, 0.0);
    for k in (1..f.len()).filter(|&k| f[k] != 0.0) {
        rays |= 1 << Scaled::facet_along(k, f[k] > 0.0);
        friction += f[k].abs() / reach[k];
    }
    if friction < f[0] { rays | 0b11 } else { rays }
}

/// The bits of a contact that sticks, or of one that is open.
pub(super) fn standing(sticks: bool, d: usize) -> u8 {
    if sticks { Guess::Sticks } else { Guess::Open }.write(d)
}

/// Lets the contacts slide that do so at the optimum of the energy program; the others keep their rays.
pub(super) fn slide(scaled: &Scaled, f: &[f64], v: &[f64], basis: &mut [u8]) {
    let (d, stride) = (scaled.facets(), scaled.stride());
    let least = SLIPS * residual::scale(scaled, f);
    for (i, bits) in basis.iter_mut().enumerate() {
        let slips = (1..stride).any(|k| v[i * stride + k].abs() > least);
        if slips {
            *bits = Guess::read(*bits, d).write(d);
        }
    }
}

/// Writes the basis as a complementary one: what sticks is carried by one facet of each tangent, which `f` tells.
pub(super) fn complement(scaled: &Scaled, f: &[f64], basis: &mut [u8]) {
    let (d, stride) = (scaled.facets(), scaled.stride());
    for (bits, f) in basis.iter_mut().zip(f.chunks_exact(stride)) {
        let guess = Guess::read(*bits, d);
        *bits = match guess {
            Guess::Sticks => (1..stride).fold(1, |bits, k| bits | 1 << (1 + Scaled::facet_along(k, f[k] > 0.0))),
            _ => guess.write(d),
        };
    }
}

/// What a contact does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Guess {
    Open,
    Sticks,
    Slides(usize),
    SlidesBetween(usize, usize),
}

impl Guess {
    /// From the bits of a basis: 0 the normal, 1 + j facet j, d + 1 the slip speed.
    fn read(bits: u8, d: usize) -> Guess {
        if bits & RAYS != 0 {
            let mut active = (0..d).filter(|j| bits >> j & 1 == 1);
            return match (active.next(), active.next(), active.next()) {
                (None, ..) => Guess::Open,
                (Some(j), None, _) => Guess::Slides(j),
                (Some(j), Some(k), None) if j / 2 != k / 2 => Guess::SlidesBetween(j, k),
                _ => Guess::Sticks,
            };
        }
        let mut active = (0..d).filter(|j| bits >> (1 + j) & 1 == 1);
        let slips = bits >> (d + 1) & 1 == 1;
        match (bits & 1 == 1, slips, active.next(), active.next()) {
            (false, ..) => Guess::Open,
            (true, true, Some(j), Some(k)) if j / 2 != k / 2 => Guess::SlidesBetween(j, k),
            (true, true, Some(j), None) => Guess::Slides(j),
            (true, ..) => Guess::Sticks,
        }
    }

    fn write(self, d: usize) -> u8 {
        let slip = 1 | 1 << (d + 1);
        match self {
            Guess::Open => 0,
            Guess::Sticks => (0..d).step_by(2).fold(1, |bits, j| bits | 1 << (1 + j)),
            Guess::Slides(j) => slip | 1 << (1 + j),
            Guess::SlidesBetween(j, k) => slip | 1 << (1 + j) | 1 << (1 + k),
        }
    }

    /// The guess that impulse and velocity of contact `i` speak for.
    fn corrected(self, scaled: &Scaled, i: usize, f: &[f64], v: &[f64], least: f64) -> Guess {
        let stride = scaled.stride();
        let rows = i * stride..(i + 1) * stride;
        let (f, v, ratio) = (&f[rows.clone()], &v[rows.clone()], &scaled.ratio[rows]);
        let share = |k: usize| ratio[k] * f[k].abs();
        let push = |j: usize| Scaled::facet(j).1 * f[Scaled::facet(j).0];
        // Slip against facet j: positive if the friction of that facet brakes it.
        let slip = |j: usize| -Scaled::facet(j).1 * v[Scaled::facet(j).0] / ratio[Scaled::facet(j).0];
        let fastest = |other: usize| {
            let tangent = (1..stride).find(|&k| k != Scaled::facet(other).0)?;
            let against = Scaled::facet_along(tangent, v[tangent] < 0.0);
            (slip(against) > slip(other) + least).then_some(against)
        };
        match self {
            Guess::Open if v[0] < -least => Guess::Sticks,
            Guess::Open => Guess::Open,
            _ if f[0] < -least => Guess::Open,
            Guess::Sticks => {
                let most = (2..stride).fold(1, |most, k| if share(k) > share(most) { k } else { most });
                let carried: f64 = (1..stride).map(share).sum();
                if carried > scaled.friction[i] * f[0] + least {
                    Guess::Slides(Scaled::facet_along(most, f[most] > 0.0))
                } else {
                    Guess::Sticks
                }
            }
            Guess::Slides(j) | Guess::SlidesBetween(j, _) if slip(j) < -least => Guess::Sticks,
            Guess::Slides(j) => fastest(j).map_or(self, |k| Guess::SlidesBetween(j.min(k), j.max(k))),
            Guess::SlidesBetween(j, k) if push(j) < -least => Guess::Slides(k),
            Guess::SlidesBetween(j, k) if push(k) < -least => Guess::Slides(j),
            Guess::SlidesBetween(..) => self,
        }
    }
}
