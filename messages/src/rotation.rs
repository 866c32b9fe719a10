//! Sine, cosine and rotations. Each step, control period and record needs them for every joint.
//!
//! The functions of the C library are accurate to half a unit in the last place but four times slower, because they save and set the
//! rounding mode. Also, different C libraries give different bits.
//!
//! # Source
//! Reduction by Cody & Waite, *Software Manual for the Elementary Functions* (1980); polynomials of Sun Microsystems' fdlibm 5.3,
//! `k_sin.c` and `k_cos.c`.

use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// π/2 as a sum of two numbers.
const HALF_PI_PARTS: [f64; 2] = [FRAC_PI_2, 6.123_233_995_736_766e-17];
/// Angles beyond this are left to the C library [rad].
const MAX_REDUCED_ANGLE: f64 = 1e5;

/// Coefficients of z, z²… in sin r/r − 1, with z = r².
const SINE: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_007e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];
/// Coefficients of z², z³… in cos r − 1 + z/2.
const COSINE: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// 1.5·2⁵². Adding it to a number leaves the nearest whole number in the last bits.
const ROUNDING_SHIFT: f64 = 6_755_399_441_055_744.0;

/// sin x and cos x, accurate to a unit in the last place of 1.
#[inline]
pub fn sin_cos(x: f64) -> (f64, f64) {
    if x.abs() < MAX_REDUCED_ANGLE { reduced(x) } else { libm::sincos(x) }
}

/// sin and cos of many angles, with the same bits as [`sin_cos`], several at a time.
#[inline]
pub fn sin_cos_all(angles: &[f64], out: &mut [(f64, f64)]) {
    for (x, out) in angles.iter().zip(&mut *out) {
        *out = reduced(*x);
    }
    if !angles.iter().all(|x| x.abs() < MAX_REDUCED_ANGLE) {
        angles.iter().zip(out).for_each(|(x, out)| *out = sin_cos(*x));
    }
}

/// sin x and cos x of |x| < [`MAX_REDUCED_ANGLE`], without a branch.
#[inline(always)]
fn reduced(x: f64) -> (f64, f64) {
    let shifted = x * FRAC_2_PI + ROUNDING_SHIFT;
    let quarters = shifted - ROUNDING_SHIFT;
    let r = (-quarters).mul_add(HALF_PI_PARTS[1], (-quarters).mul_add(HALF_PI_PARTS[0], x)); // |r| <= π/4
    let z = r * r;
    let sum = |coefficients: &[f64; 6]| coefficients.iter().rev().fold(0.0_f64, |sum, c| sum.mul_add(z, *c));
    let sine = (r * z).mul_add(sum(&SINE), r);
    let cosine = (z * z).mul_add(sum(&COSINE), 1.0 - 0.5 * z);
    let whole = shifted.to_bits();
    let (s, c) = if whole & 1 == 0 { (sine, cosine) } else { (cosine, sine) };
    let turned = |value: f64, quarters: u64| f64::from_bits(value.to_bits() ^ ((quarters & 2) << 62));
    (turned(s, whole), turned(c, whole.wrapping_add(1)))
}

/// The axis of the body's frame along which a unit axis lies, if there is one. A rotation about such an axis is cheaper.
pub fn aligned_axis(axis: &Vector3<f64>) -> Option<usize> {
    (0..3).find(|&k| axis[k].abs() == 1.0)
}

/// R rotated about a unit axis in the frame of R, by the angle with this sine and cosine. `along` is the [`aligned_axis`] of the axis.
#[inline]
pub fn rotated(r: &Matrix3<f64>, axis: &Vector3<f64>, along: Option<usize>, (s, c): (f64, f64)) -> Matrix3<f64> {
    match along {
        Some(k) => rotated_about(r, k, (s * axis[k], c)),
        None => r * (Matrix3::identity() * c + axis.cross_matrix() * s + axis * axis.transpose() * (1.0 - c)),
    }
}

/// R rotated about the k-th axis of its own frame by the angle with this sine and cosine.
#[inline]
pub fn rotated_about(r: &Matrix3<f64>, k: usize, (s, c): (f64, f64)) -> Matrix3<f64> {
    let [x, y, z] = [0, 1, 2].map(|k| r.column(k).into_owned());
    // Each case is written out. Columns selected by a variable index go through memory and cost an eighth of the controller's time.
    let mixed = |u: Vector3<f64>, v: Vector3<f64>| (u * c + v * s, v * c - u * s);
    match k {
        0 => {
            let (y, z) = mixed(y, z);
            Matrix3::from_columns(&[x, y, z])
        }
        1 => {
            let (z, x) = mixed(z, x);
            Matrix3::from_columns(&[x, y, z])
        }
        _ => {
            let (x, y) = mixed(x, y);
            Matrix3::from_columns(&[x, y, z])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    #[test]
    fn sine_and_cosine_agree_with_the_c_library_to_two_units_in_the_last_place() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut random = fastrand::Rng::with_seed(seed);
        for _ in 0..1_000_000 {
            let x = (random.f64() - 0.5) * 10f64.powi(random.i32(-8..=6));
            let ((s, c), (sine, cosine)) = (sin_cos(x), x.sin_cos());
            for (own, exact) in [(s, sine), (c, cosine)] {
                let most = f64::EPSILON.min(2.0 * f64::EPSILON * exact.abs()); // a unit in the last place of 1, and two units in its own last place
                assert!((own - exact).abs() <= most, "{x:e}: {own:e}, {exact:e}");
            }
            assert_eq!(sin_cos(-x), (-s, c));
        }
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        assert!(sin_cos(f64::NAN).0.is_nan() && sin_cos(f64::INFINITY).1.is_nan());
    }

    #[test]
    fn many_angles_at_once_give_the_same_bits() {
        for far in [0.0, 1e7, f64::NAN] {
            let angles: Vec<f64> = (0..11).map(|k| 1.7 * f64::from(k) - 8.0).chain([far, -0.0]).collect();
            let mut pairs = vec![(0.0, 0.0); angles.len()];
            sin_cos_all(&angles, &mut pairs);
            let bits = |(s, c): (f64, f64)| [s.to_bits(), c.to_bits()];
            assert!(angles.iter().zip(&pairs).all(|(x, pair)| bits(sin_cos(*x)) == bits(*pair)), "{far}");
        }
    }

    #[test]
    fn a_body_rotates_about_its_own_axis() {
        let start = Rotation3::from_euler_angles(0.3, -1.1, 2.0);
        for k in 0..3 {
            let unit = Vector3::ith_axis(k);
            for angle in [-2.5, 0.0, 0.7] {
                let expected = start * Rotation3::from_axis_angle(&unit, angle);
                assert!(
                    (rotated_about(start.matrix(), k, sin_cos(angle)) - expected.matrix()).amax() < 1e-15,
                    "{k} {angle}"
                );
                for axis in [unit.into_inner(), -unit.into_inner()] {
                    let turned =
                        [aligned_axis(&axis), None].map(|along| rotated(start.matrix(), &axis, along, sin_cos(angle)));
                    assert!((turned[0] - turned[1]).amax() < 1e-15, "{axis} {angle}");
                }
            }
        }
        assert_eq!(aligned_axis(&Vector3::new(0.6, 0.0, 0.8)), None);
    }
}
