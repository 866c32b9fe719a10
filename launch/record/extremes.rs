//! Greatest and least values over a run, and whether the robot fell; every record counts.

use super::robot::Robot;
use super::sample::Sample;
use messages::wire::{JOINTS, Truth};

/// Time in which a landing foot comes to rest on its whole sole [s].
const LANDED: f64 = 0.04;

/// Extremes so far. A NaN among the inputs makes the extreme NaN: a broken residual is never hidden.
pub struct Extremes {
    /// Time of the fall [s].
    pub fall: Option<f64>,
    /// Greatest torque of each drive [N·m].
    pub torque: [f64; JOINTS],
    /// Greatest mechanical power of each drive, given or taken [W].
    pub power: [f64; JOINTS],
    /// Greatest tilt of the foot that carries more [rad].
    pub foot_tilt: f64,
    /// Least distance of the zero-moment point inside the edge of the only foot that carries, from [`LANDED`] after it
    /// began to carry alone: a sole that has just come down may still stand on one edge [m].
    pub zmp_margin: f64,
    /// When the foot that carries now began to do so alone [s].
    alone_since: Option<f64>,
    /// Greatest Signorini residual, relative to each step's scale.
    pub signorini: f64,
    /// Greatest natural-map residual, likewise.
    pub natural_map: f64,
    /// Greatest energy above that of free motion [J].
    pub energy_gain: f64,
    /// Greatest angle between friction and the direction opposite to slip [rad].
    pub slip_misalignment: f64,
    /// Deepest penetration [m].
    pub penetration: f64,
    /// Greatest normal force of the ground on the whole robot, mean over a control period [N].
    pub force: f64,
    /// Greatest height of the lowest contact point after the first contact [m].
    pub hop: f64,
    /// Greatest sideways distance of the centre of mass from where it began [m].
    pub drift: f64,
    upright: Option<Upright>,
    touched: bool,
}

/// The first sample, as far as falling and drifting are measured from it.
struct Upright {
    y: f64,
    trunk_height: f64,
    com_height: f64,
}

impl Default for Extremes {
    fn default() -> Self {
        Extremes {
            fall: None,
            torque: [0.0; JOINTS],
            power: [0.0; JOINTS],
            foot_tilt: f64::NEG_INFINITY,
            zmp_margin: f64::INFINITY,
            alone_since: None,
            signorini: 0.0,
            natural_map: 0.0,
            energy_gain: f64::NEG_INFINITY,
            slip_misalignment: 0.0,
            penetration: 0.0,
            force: 0.0,
            hop: f64::NEG_INFINITY,
            drift: 0.0,
            upright: None,
            touched: false,
        }
    }
}

impl Extremes {
    /// Takes the next record.
    pub fn push(&mut self, robot: &Robot, truth: &Truth, sample: &Sample) {
        for i in 0..JOINTS {
            raise(&mut self.torque[i], truth.torque[i].abs());
            raise(&mut self.power[i], (truth.torque[i] * truth.rate[i]).abs());
        }
        raise(&mut self.signorini, truth.signorini);
        raise(&mut self.natural_map, truth.natural_map);
        raise(&mut self.energy_gain, truth.energy_gain);
        raise(&mut self.slip_misalignment, truth.slip_misalignment);
        raise(&mut self.penetration, truth.penetration);
        raise(&mut self.force, sample.load);
        if let Some((foot, soles)) = sample.loaded_foot().zip(sample.soles) {
            raise(&mut self.foot_tilt, soles[foot].tilt);
        }
        match sample.single_support() {
            Some(sole) => {
                let since = *self.alone_since.get_or_insert(sample.time);
                if sample.time - since >= LANDED {
                    self.zmp_margin = self.zmp_margin.min(sole.zmp_margin);
                }
            }
            None => self.alone_since = None,
        }
        self.touched |= sample.load > 0.0;
        if self.touched {
            raise(&mut self.hop, sample.clearance);
        }
        let start = self.upright.get_or_insert_with(|| Upright::new(sample));
        raise(&mut self.drift, (sample.com.y - start.y).abs());
        if robot.feet.is_some() && self.fall.is_none() && start.has_fallen(sample) {
            self.fall = Some(sample.time);
        }
    }
}

impl Upright {
    fn new(sample: &Sample) -> Self {
        let ground = if sample.clearance.is_finite() { sample.clearance } else { 0.0 };
        Upright { y: sample.com.y, trunk_height: sample.trunk_height - ground, com_height: sample.com.z - ground }
    }

    /// Trunk below 60 % of the height it stood at above its feet, or tilted by 45°, or centre of mass below half.
    fn has_fallen(&self, sample: &Sample) -> bool {
        sample.trunk_height < 0.6 * self.trunk_height
            || sample.trunk_tilt > 45f64.to_radians()
            || sample.com.z < 0.5 * self.com_height
    }
}

/// Keeps the greater value; NaN stays.
fn raise(greatest: &mut f64, value: f64) {
    if value > *greatest || value.is_nan() {
        *greatest = value;
    }
}
