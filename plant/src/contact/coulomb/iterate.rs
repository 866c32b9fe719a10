//! Initial guess and iterate of the methods for the round cone.

use super::super::mode::ContactMode;
use super::super::tolerance::{COMPLIANCE, LEAST_COMPLIANCE};
use super::patch::LinkContacts;

/// Initial guess for Newton's method: modes, and slip velocities in scaled units.
#[derive(Clone, Debug, Default)]
pub(super) struct Guess {
    pub modes: Vec<ContactMode>,
    pub slips: Vec<[f64; 2]>,
}

impl Guess {
    /// Contacts of a link of which several stick and none slides form a patch.
    pub fn join_patches(&mut self, groups: &[LinkContacts]) {
        for group in groups {
            let modes = &mut self.modes[group.first..group.end];
            let sticking = modes.iter().filter(|mode| **mode == ContactMode::Sticking).count();
            if sticking > 1 && !modes.contains(&ContactMode::Sliding) {
                let sticking = modes.iter_mut().filter(|mode| **mode == ContactMode::Sticking);
                sticking.for_each(|mode| *mode = ContactMode::Patch);
            }
        }
    }
}

/// How a run of Newton's method begins, and how long it may take.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start<'a> {
    /// Modes and slips of the first step. Without a guess they follow from the impulse.
    pub guess: Option<&'a Guess>,
    /// Whether contacts that stick form patches.
    pub patches: bool,
    /// Weight of the velocities in the choice of the modes.
    pub weight: Weight,
    pub limits: Limits,
}

/// When a run of Newton's method gives up, and how compliant the contacts are meanwhile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Steps at most.
    steps: u32,
    /// Steps without progress at most.
    patience: u32,
    /// ε [-].
    pub compliance: f64,
    /// Whether the proximal centre f₀ is the initial impulse instead of zero; with balanced weights it always is.
    pub compliance_from_start: bool,
}

impl Limits {
    /// From a good guess the method takes one to four steps.
    pub const NORMAL: Limits = Limits { steps: 12, patience: 3, compliance: COMPLIANCE, compliance_from_start: false };
    /// From modes that interior points have indicated before they end.
    pub const EARLY: Limits = Limits { steps: 4, patience: 4, compliance: COMPLIANCE, compliance_from_start: false };
    /// For patient attempts, with hardly any compliance.
    pub const STIFF: Limits = Limits::patient(LEAST_COMPLIANCE);
    /// For patient attempts, with the usual compliance.
    pub const PATIENT: Limits = Limits { steps: 36, patience: 12, compliance: COMPLIANCE, compliance_from_start: true };

    /// [`Limits::PATIENT`] with another compliance.
    pub const fn patient(compliance: f64) -> Limits {
        Limits { compliance, ..Limits::PATIENT }
    }

    /// Whether the method gives up at a step. `best` is the step of the least residual so far.
    pub fn are_reached(self, step: u32, best: u32) -> bool {
        step >= self.steps || step > best + self.patience
    }
}

/// Weight ρ of the velocities in x = f − ρ v. Any weight has the same solutions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Weight {
    /// The mass of the contact.
    Mass,
    /// The weight that makes the greatest velocity as large as the greatest impulse. Feet that wedge between two contacts need it: they
    /// slip 1e9 times as slowly as without contact, so with the mass as weight their slip would decide no mode. The compliance is not small
    /// compared with such a slip, so the proximal centre is then the impulse of the step before, from the initial one on.
    Balanced,
    /// This many times the mass of the contact. The proximal centre is that of balanced weights.
    Masses(f64),
}

/// An impulse with its velocity and residual, all scaled; and the number of linear systems solved so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Iterate {
    pub f: Vec<f64>,
    pub v: Vec<f64>,
    pub error: f64,
    pub steps: u32,
}

impl Iterate {
    /// Copies another iterate without allocation, but not its count of linear systems.
    pub fn copy(&mut self, other: &Iterate) {
        self.f.clone_from(&other.f);
        self.v.clone_from(&other.v);
        self.error = other.error;
    }
}
