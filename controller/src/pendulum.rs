//! The inverted-pendulum mode of the centre of gravity, one axis at a time: (31)-(42).
//!
//! ```text
//!   ẍ = ω² x + u          (31), (32)
//!   E = v²/2 - ω² x²/2    (33), constant without input
//! ```
//! Positions are those of the centre of gravity relative to the supporting sole's centre [m].

/// Least A of x = A e^(ωt) + B e^(−ωt) with which a motion counts as diverging [m].
const LEAST_DIVERGING: f64 = 1e-5;

/// State of one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PendulumState {
    /// Position relative to the support [m].
    pub x: f64,
    /// Velocity [m/s].
    pub v: f64,
}

impl PendulumState {
    /// E = v²/2 − ω²x²/2 [m²/s²]. Source: (33).
    pub fn energy(self, omega: f64) -> f64 {
        0.5 * self.v * self.v - 0.5 * (omega * self.x).powi(2) // (33)
    }

    /// The state after the propagator's time under the constant input `u`: (34) about the equilibrium −u/ω².
    pub fn propagated(self, propagator: &Propagator, u: f64) -> PendulumState {
        let Propagator { omega, sinh, cosh } = *propagator;
        let rest = -u / (omega * omega);
        let x = self.x - rest;
        PendulumState { x: rest + x * cosh + self.v / omega * sinh, v: x * omega * sinh + self.v * cosh } // (34)
    }

    /// Time until the free motion reaches `width`, at most `longest` [s].
    ///
    /// (34) in the form x = A e^(ωt) + B e^(−ωt) is a quadratic equation in e^(ωt). The motion reaches `width` only if A > 0.
    pub fn time_to(self, width: f64, omega: f64, longest: f64) -> f64 {
        let a = 0.5 * (self.x + self.v / omega);
        let b = 0.5 * (self.x - self.v / omega);
        if a <= LEAST_DIVERGING {
            return longest;
        }
        let root = (width * width - 4.0 * a * b).max(0.0).sqrt();
        (libm::log((width + root) / (2.0 * a)) / omega).clamp(0.0, longest)
    }
}

/// Propagator of a pendulum over a time t: ω, sinh ωt and cosh ωt.
#[derive(Clone, Copy, Debug)]
pub struct Propagator {
    /// ω [1/s].
    pub omega: f64,
    /// sinh ωt.
    pub sinh: f64,
    /// cosh ωt.
    pub cosh: f64,
}

impl Propagator {
    /// The propagator over the time `t` [s].
    pub fn new(omega: f64, t: f64) -> Propagator {
        let grown = libm::expm1(omega * t); // no cancellation where ωt is small
        let shrunk = grown / (1.0 + grown); // 1 − e^(−ωt)
        Propagator { omega, sinh: 0.5 * (grown + shrunk), cosh: 1.0 + 0.5 * (grown - shrunk) }
    }
}

/// Energy of the lateral orbit of this period with feet `width` apart [m²/s²]. Source: (37), (40).
pub fn lateral_energy(omega: f64, width: f64, period: f64) -> f64 {
    let e = libm::exp(0.5 * omega * period);
    -(omega * width).powi(2) * e / (2.0 * (1.0 + e).powi(2)) // (40)
}

/// Energy of the sagittal orbit with steps of length `step` [m²/s²]. Source: (42).
pub fn sagittal_energy(omega: f64, step: f64, period: f64) -> f64 {
    let e = libm::exp(0.5 * omega * period);
    (omega * step).powi(2) * e / (2.0 * (1.0 - e).powi(2)) // (42)
}

/// Turning point of the lateral orbit: the position at which the energy (40) belongs to speed zero in (33) [m].
pub fn turning_point(omega: f64, width: f64, period: f64) -> f64 {
    0.5 * width / libm::cosh(0.25 * omega * period)
}

/// Virtual input that drives the energy to its reference: u = k_E (E_ref − E)/v, within ±`limit` [m/s²]. `missing` is E_ref − E.
///
/// (39) is singular at v = 0. Here v/(v² + v_0²) replaces 1/v, with v_0 = `fading` [m/s]. Near the turning point the input then
/// fades and does not jump between its limits. The energy follows dE/dt = k_E (E_ref − E) v²/(v² + v_0²): that is (41), but slower
/// near the turning point. Source: (38), (39).
pub fn virtual_input(gain: f64, missing: f64, v: f64, fading: f64, limit: f64) -> f64 {
    (gain * missing * v / (v * v + fading * fading)).clamp(-limit, limit) // (39)
}

#[cfg(test)]
mod tests {
    use super::*;

    const OMEGA: f64 = 4.947;

    #[test]
    fn the_free_orbit_of_the_reference_energy_has_the_reference_period() {
        let (width, period) = (0.1, 0.6);
        let start = PendulumState { x: turning_point(OMEGA, width, period), v: 0.0 };
        assert!((start.energy(OMEGA) - lateral_energy(OMEGA, width, period)).abs() < 1e-15);
        assert!((start.time_to(width / 2.0, OMEGA, 1.0) - period / 4.0).abs() < 1e-12);
        let end = start.propagated(&Propagator::new(OMEGA, period / 4.0), 0.0);
        let back = PendulumState { x: end.x, v: -end.v }.propagated(&Propagator::new(OMEGA, period / 2.0), 0.0);
        assert!((back.x - width / 2.0).abs() < 1e-12 && (back.v - end.v).abs() < 1e-12); // (35), (36)
    }

    #[test]
    fn a_sagittal_orbit_of_the_reference_energy_covers_one_step_in_half_a_period() {
        let (step, period) = (0.06, 0.6);
        let v = (2.0 * sagittal_energy(OMEGA, step, period) + (OMEGA * step / 2.0).powi(2)).sqrt();
        let end = PendulumState { x: -step / 2.0, v }.propagated(&Propagator::new(OMEGA, period / 2.0), 0.0);
        assert!((end.x - step / 2.0).abs() < 1e-12);
    }

    #[test]
    fn energy_is_constant_without_input_and_follows_38_with_it() {
        let start = PendulumState { x: 0.042, v: -0.08 };
        assert!(
            (start.propagated(&Propagator::new(OMEGA, 0.2), 0.0).energy(OMEGA) - start.energy(OMEGA)).abs() < 1e-15
        );
        let (u, h) = (0.4, 1e-6);
        let rate = (start.propagated(&Propagator::new(OMEGA, h), u).energy(OMEGA) - start.energy(OMEGA)) / h;
        assert!((rate - start.v * u).abs() < 1e-5); // (38)
    }
}
