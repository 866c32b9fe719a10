//! Peak values between two rows, so that storing fewer rows hides no peak.

use messages::wire::{JOINTS, Truth};

/// Peak values over the records since the previous row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peaks {
    /// Torque of each drive, the value with the greatest magnitude [N·m].
    pub torque: [f64; JOINTS],
    /// Natural-map residual, relative.
    pub natural_map: f64,
    /// Signorini residual, relative.
    pub signorini: f64,
    /// Age of the applied command [control periods].
    pub age: u32,
    /// Delay from sensor message to command; 0 for the first command of a controller, which also waits for its start [ns].
    pub reply_ns: u64,
    /// Delay of the start of a control period [ns].
    pub late_ns: u64,
}

impl Peaks {
    /// The values of one record.
    pub fn new(truth: &Truth) -> Peaks {
        let &Truth { torque, natural_map, signorini, age, late_ns, .. } = truth;
        let reply_ns = if truth.command.seq > 1 { truth.reply_ns } else { 0 };
        Peaks { torque, natural_map, signorini, age, reply_ns, late_ns }
    }

    /// The greater value of each quantity.
    pub fn max(mut self, other: &Peaks) -> Peaks {
        for (own, other) in self.torque.iter_mut().zip(other.torque) {
            *own = if own.abs() < other.abs() { other } else { *own };
        }
        self.natural_map = self.natural_map.max(other.natural_map);
        self.signorini = self.signorini.max(other.signorini);
        self.age = self.age.max(other.age);
        self.reply_ns = self.reply_ns.max(other.reply_ns);
        self.late_ns = self.late_ns.max(other.late_ns);
        self
    }
}
