//! Delay tolerance of the servos: the eigenvalues of their sampled loop inside the boundary layer.
//!
//! With a fixed supporting foot, and without weight and velocity products, the robot is M q̈ = τ. Its servos are equal except for
//! the factor J_n. Coordinates that diagonalise M⁻¹J_n separate the loops: each is that of one joint with the inertia J = J_n/λ,
//! where λ is an eigenvalue of M⁻¹J_n. If J_n is a multiple of M, all λ are that multiple. With u = (τ − τ_ff)/J_n, the period T and a
//! command that acts d periods late, one period is
//! ```text
//!   v⁺ = v + T λ u_{−d}                            speed, after a constant torque
//!   r⁺ = r + α (v + β T λ u_{−d} − r)              difference of encoders, low-passed: α = 1 − exp(−2π f T)
//!   D⁺ = φ D + (1 − φ)(u − (r⁺ − r)/T)             observer: φ = exp(−g T)
//!   u⁺ = D⁺ − κ r⁺                                 boundary layer
//! ```
//! β = ½ if the torque accelerates continuously, and ½ + 1/(2n) if the plant makes n steps of the paper's method. The loop is stable
//! while all eigenvalues of this map of (v, r, D, u, u_{−1}, …, u_{−d}) lie inside the unit circle. With a delay d + ε the share ε of
//! the torque is that of one period earlier.

use crate::constants::Constants;
use crate::error::ControllerError;
use messages::scene::{Method, Scene};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use std::f64::consts::TAU;

/// One servo with its load, linearised about its sliding surface.
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

/// Longest delay that is examined [control periods].
const LONGEST: usize = 200;
/// Accuracy of a critical delay [control periods].
const DELAY_TOLERANCE: f64 = 1e-9;
/// Indices of v, r, D and u in the state.
const V: usize = 0;
const R: usize = 1;
const D: usize = 2;
const U: usize = 3;

/// The eight loops of a scene's robot, by increasing λ.
///
/// # Errors
/// If the scene has no controller for its robot.
pub fn loops(scene: &Scene) -> Result<Vec<ServoLoop>, ControllerError> {
    let settings = scene.controller.as_ref().ok_or(ControllerError::NoController)?;
    let constants = Constants::of(scene)?;
    // With M = L Lᵀ, λ are the eigenvalues of the symmetric matrix L⁻¹ J_n L⁻ᵀ.
    let Some(root) = constants.inertia.cholesky().and_then(|factor| factor.l().try_inverse()) else {
        return Err(ControllerError::Robot("its inertia matrix is not positive definite".into()));
    };
    let scaled = root * constants.nominal_inertia * root.transpose();
    let mut ratios: Vec<f64> = SymmetricEigen::new(scaled).eigenvalues.iter().copied().collect();
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
    /// The map over one period as a matrix, for a delay in control periods that need not be a whole number.
    pub fn map(&self, delay: f64) -> DMatrix<f64> {
        let (whole, part) = (delay.floor() as usize, delay.fract());
        let size = U + whole + 2;
        let unit = |k: usize| DVector::from_fn(size, |i, _| f64::from(u8::from(i == k)));
        let share = 1.0 - libm::exp(-TAU * self.rate_filter_hz * self.period);
        let keep = libm::exp(-self.observer_bandwidth * self.period);
        let gain = self.period * self.inertia_ratio * ((1.0 - part) * unit(U + whole) + part * unit(U + whole + 1));
        let v = unit(V) + &gain;
        let r = unit(R) + share * (unit(V) + self.midpoint * gain - unit(R));
        let d = keep * unit(D) + (1.0 - keep) * (unit(U) - (&r - unit(R)) / self.period);
        let u = &d - self.switch_rate * &r;
        let older = (U..size - 1).map(unit);
        let rows: Vec<_> = [v, r, d, u].into_iter().chain(older).map(|row| row.transpose()).collect();
        DMatrix::from_rows(&rows)
    }

    /// Spectral radius: the factor by which the loop grows or decays in a period after a long time.
    pub fn spectral_radius(&self, delay: f64) -> f64 {
        self.map(delay).complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
    }

    /// Smallest delay at which the loop is unstable [control periods].
    pub fn critical_delay(&self) -> f64 {
        let stable = |delay: f64| self.spectral_radius(delay) < 1.0;
        let Some(unstable) = (0..LONGEST).find(|whole| !stable(*whole as f64)) else { return LONGEST as f64 };
        let (mut low, mut high) = (unstable as f64 - 1.0, unstable as f64);
        while high - low > DELAY_TOLERANCE && unstable > 0 {
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
    use messages::scene::{ControllerScene, NominalInertia};

    fn scene(inertia: NominalInertia) -> Scene {
        let controller = ControllerScene { nominal_inertia: Some(inertia), ..ControllerScene::default() };
        Scene { controller: Some(controller), ..Scene::default() }
    }

    fn of_the_paper() -> Vec<ServoLoop> {
        loops(&scene(NominalInertia::Diagonal)).expect("the robot of Table 1")
    }

    #[test]
    fn a_number_for_each_joint_has_ratios_with_a_mean_of_two_and_a_matrix_has_eight_equal_ones() {
        // tr M⁻¹J_n = Σ 2 (M⁻¹)_ii/(M⁻¹)_ii.
        let sum: f64 = of_the_paper().iter().map(|servo| servo.inertia_ratio).sum();
        assert!((sum - 16.0).abs() < 1e-9, "{sum}");
        let matrix = loops(&scene(NominalInertia::Matrix)).expect("the robot of Table 1");
        assert!(matrix.iter().all(|servo| (servo.inertia_ratio - 1.5).abs() < 1e-12), "{matrix:?}");
    }

    #[test]
    fn the_loop_of_all_joints_is_as_stable_as_the_worst_of_the_eight() {
        let constants = Constants::of(&scene(NominalInertia::Diagonal)).expect("the paper's robot");
        let inverse = constants.inertia.try_inverse().expect("it has mass");
        let coupling = inverse * constants.nominal_inertia; // M⁻¹J_n
        let loops = of_the_paper();
        for delay in [0.0, 2.0, 3.0, 4.0] {
            // The map is affine in λ. The map of all joints has M⁻¹J_n in place of λ.
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
                midpoint: 1.0, // the difference is the speed at the end of the period
            };
            let radius = |k: f64| with(k).spectral_radius(f64::from(delay));
            // Without an observer D stays constant, which is an eigenvalue at 1.
            assert!(radius(0.999 * exact) <= 1.0 + 1e-12 && radius(1.001 * exact) > 1.0 + 1e-6, "{delay}");
        }
    }
}
