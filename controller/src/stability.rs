//! How much delay the servos bear: the eigenvalues of their sampled loop, inside the boundary layer.
//!
//! With the supporting foot held and weight and velocity products left out, the robot is M q̈ = τ, and its servos are
//! equal but for the scale J_n. In coordinates that diagonalise M⁻¹J_n the eight loops fall apart, each that of one joint
//! with the inertia J = J_n/λ, λ being an eigenvalue of M⁻¹J_n. With u = (τ − τ_ff)/J_n, the period T and a command that acts
//! d periods late, one period of it is
//! ```text
//!   v⁺ = v + T λ u_{−d}                            speed, after a constant torque
//!   r⁺ = r + α (v + β T λ u_{−d} − r)              difference of encoders, low-passed: α = 1 − exp(−2π f T)
//!   D⁺ = φ D + (1 − φ)(u − (r⁺ − r)/T)             observer: φ = exp(−g T)
//!   u⁺ = D⁺ − κ r⁺                                 boundary layer
//! ```
//! β = ½ where the torque accelerates continuously, ½ + 1/(2n) where the plant does it in n steps of the paper's method. The loop is
//! stable while all eigenvalues of this map of (v, r, D, u, u_{−1}, …, u_{−d}) lie within the unit circle. A delay d + ε
//! takes the share ε of the torque from a period earlier still.

use crate::constants::Constants;
use crate::error::ControllerError;
use crate::support::Joints;
use messages::scene::{Method, Scene};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use std::f64::consts::TAU;

/// One servo with its load, linearised about its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoLoop {
    /// λ = J_n/J: nominal inertia over the true one [-].
    pub inertia_ratio: f64,
    /// T [s].
    pub period: f64,
    /// κ [1/s].
    pub switch_rate: f64,
    /// g [rad/s].
    pub observer_bandwidth: f64,
    /// f [Hz].
    pub rate_filter_hz: f64,
    /// β [-].
    pub midpoint: f64,
}

/// No delay is looked for beyond this [control periods].
const LONGEST: usize = 200;
/// Places of v, r, D and u in the state.
const V: usize = 0;
const R: usize = 1;
const D: usize = 2;
const U: usize = 3;

/// The eight loops of a scene's robot, λ ascending.
///
/// # Errors
/// If the scene has no controller for its robot.
pub fn loops(scene: &Scene) -> Result<Vec<ServoLoop>, ControllerError> {
    let settings = scene.controller.as_ref().ok_or(ControllerError::NoController)?;
    let constants = Constants::of(scene)?;
    let scale: Joints = constants.nominal_inertia.map(f64::sqrt);
    // Eigenvalues of J_n^{-1/2} M J_n^{-1/2} are 1/λ.
    let scaled = constants.inertia.map_with_location(|i, j, m| m / (scale[i] * scale[j]));
    let mut ratios: Vec<f64> = SymmetricEigen::new(scaled).eigenvalues.iter().map(|inverse| 1.0 / inverse).collect();
    ratios.sort_by(f64::total_cmp);
    let midpoint = match scene.plant.method {
        Method::SemiImplicitEuler => 0.5 + 0.5 * scene.rate * scene.plant.dt,
        Method::ExplicitEuler => 0.5 - 0.5 * scene.rate * scene.plant.dt,
        _ => 0.5,
    };
    let servo = |inertia_ratio| ServoLoop {
        inertia_ratio,
        period: 1.0 / scene.rate,
        switch_rate: settings.switch_rate,
        observer_bandwidth: settings.observer_bandwidth,
        rate_filter_hz: settings.rate_filter_hz,
        midpoint,
    };
    Ok(ratios.into_iter().map(servo).collect())
}

impl ServoLoop {
    /// One period with a delay in control periods, whole or not, as a matrix.
    pub fn map(&self, delay: f64) -> DMatrix<f64> {
        let (whole, part) = (delay.floor() as usize, delay.fract());
        let size = U + whole + 2;
        let unit = |k: usize| DVector::from_fn(size, |i, _| f64::from(u8::from(i == k)));
        let share = 1.0 - (-TAU * self.rate_filter_hz * self.period).exp();
        let keep = (-self.observer_bandwidth * self.period).exp();
        let gain = self.period * self.inertia_ratio * ((1.0 - part) * unit(U + whole) + part * unit(U + whole + 1));
        let v = unit(V) + &gain;
        let r = unit(R) + share * (unit(V) + self.midpoint * gain - unit(R));
        let d = keep * unit(D) + (1.0 - keep) * (unit(U) - (&r - unit(R)) / self.period);
        let u = &d - self.switch_rate * &r;
        let older = (U..size - 1).map(unit);
        let rows: Vec<_> = [v, r, d, u].into_iter().chain(older).map(|row| row.transpose()).collect();
        DMatrix::from_rows(&rows)
    }

    /// Factor by which the loop grows or decays in a period, in the long run: the greatest magnitude of an eigenvalue.
    pub fn spectral_radius(&self, delay: f64) -> f64 {
        self.map(delay).complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
    }

    /// Delay from which on the loop is unstable [control periods].
    pub fn critical_delay(&self) -> f64 {
        let stable = |delay: f64| self.spectral_radius(delay) < 1.0;
        let Some(unstable) = (0..LONGEST).find(|whole| !stable(*whole as f64)) else { return LONGEST as f64 };
        let (mut low, mut high) = (unstable as f64 - 1.0, unstable as f64);
        while high - low > 1e-9 && unstable > 0 {
            let middle = 0.5 * (low + high);
            if stable(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::scene::ControllerScene;

    fn of_the_paper() -> Vec<ServoLoop> {
        loops(&Scene { controller: Some(ControllerScene::default()), ..Scene::default() })
            .expect("the robot of Table 1")
    }

    #[test]
    fn the_ratios_of_the_robot_keep_their_sum() {
        // tr M⁻¹J_n = Σ 2 (M⁻¹)_ii/(M⁻¹)_ii.
        let sum: f64 = of_the_paper().iter().map(|servo| servo.inertia_ratio).sum();
        assert!((sum - 16.0).abs() < 1e-9, "{sum}");
    }

    #[test]
    fn the_loop_of_all_joints_is_as_stable_as_the_worst_of_the_eight() {
        let scene = Scene { controller: Some(ControllerScene::default()), ..Scene::default() };
        let constants = Constants::of(&scene).expect("the paper's robot");
        let inverse = constants.inertia.try_inverse().expect("it has mass");
        let coupling = inverse * nalgebra::SMatrix::from_diagonal(&constants.nominal_inertia); // M⁻¹J_n
        let loops = of_the_paper();
        for delay in [0.0, 2.0, 3.0, 4.0] {
            // The map is affine in λ, so that of all joints has M⁻¹J_n in its place.
            let [without, one] = [0.0, 1.0].map(|inertia_ratio| ServoLoop { inertia_ratio, ..loops[0] }.map(delay));
            let all = DMatrix::identity(8, 8).kronecker(&without) + coupling.kronecker(&(one - &without));
            let all = all.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max);
            let worst = loops.iter().map(|servo| servo.spectral_radius(delay)).fold(0.0, f64::max);
            assert!((all - worst).abs() < 1e-8, "delay {delay}: {all}, {worst}");
        }
    }

    #[test]
    fn a_critical_delay_is_where_the_spectral_radius_is_one() {
        for servo in of_the_paper() {
            let delay = servo.critical_delay();
            assert!((servo.spectral_radius(delay) - 1.0).abs() < 1e-8, "{servo:?}: {delay}");
            assert!(servo.spectral_radius(0.9 * delay) < 1.0 && servo.spectral_radius(1.1 * delay) > 1.0, "{servo:?}");
        }
    }

    #[test]
    fn without_observer_and_filter_the_limit_is_that_of_a_delayed_integrator() {
        // v⁺ = v − k v_{−d} with k = κ T λ is stable for k < 2 sin(π/(4d + 2)) (Levin and May, 1976).
        for delay in 0..8 {
            let exact = 2.0 * (std::f64::consts::PI / (4.0 * f64::from(delay) + 2.0)).sin();
            let with = |k: f64| ServoLoop {
                inertia_ratio: k / (80.0 * 1e-3),
                period: 1e-3,
                switch_rate: 80.0,
                observer_bandwidth: 0.0,
                rate_filter_hz: 1e9,
                midpoint: 1.0, // the difference is the speed at its end
            };
            let radius = |k: f64| with(k).spectral_radius(f64::from(delay));
            // D, which nothing moves without an observer, keeps an eigenvalue at 1.
            assert!(radius(0.999 * exact) <= 1.0 + 1e-12 && radius(1.001 * exact) > 1.0 + 1e-6, "{delay}");
        }
    }
}
