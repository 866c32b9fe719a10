//! What comes in peaks, at its greatest between one row and the next: thinning out rows hides none.

use messages::wire::{JOINTS, Truth};

/// The greatest values over the records since the row before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peaks {
    /// Torque of each drive, the greatest either way [N·m].
    pub torque: [f64; JOINTS],
    /// Natural-map residual, relative.
    pub natural_map: f64,
    /// Signorini residual, relative.
    pub signorini: f64,
    /// Age of the command in force [control periods].
    pub age: u32,
    /// From sensors to command [ns].
    pub reply_ns: u64,
    /// How late a period began [ns].
    pub late_ns: u64,
}

impl Peaks {
    /// Of one record.
    pub fn of(truth: &Truth) -> Peaks {
        let &Truth { torque, natural_map, signorini, age, reply_ns, late_ns, .. } = truth;
        Peaks { torque, natural_map, signorini, age, reply_ns, late_ns }
    }

    /// The worse of both.
    pub fn and(mut self, other: &Peaks) -> Peaks {
        for (mine, theirs) in self.torque.iter_mut().zip(other.torque) {
            *mine = if mine.abs() < theirs.abs() { theirs } else { *mine };
        }
        self.natural_map = self.natural_map.max(other.natural_map);
        self.signorini = self.signorini.max(other.signorini);
        self.age = self.age.max(other.age);
        self.reply_ns = self.reply_ns.max(other.reply_ns);
        self.late_ns = self.late_ns.max(other.late_ns);
        self
    }
}
