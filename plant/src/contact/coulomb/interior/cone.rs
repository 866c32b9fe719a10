//! Algebra of the cone L = {x_N ≥ |x_F|}: Jordan product, scaling, and distance to the boundary.

use super::super::super::projection::norm;

pub(super) type Vector = [f64; 3];

/// W = β(2vvᵀ − J) with Wx = W⁻¹y, J = diag(1, −1, −1).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Scaling {
    v: Vector,
    beta: f64,
}

impl Scaling {
    pub fn of(x: Vector, y: Vector) -> Scaling {
        let (length_x, length_y) = (determinant(x).sqrt(), determinant(y).sqrt());
        let (x, y) = (x.map(|x| x / length_x), y.map(|y| y / length_y));
        let double = 2.0 * ((1.0 + dot(x, y)) / 2.0).sqrt();
        let w = [(y[0] + x[0]) / double, (y[1] - x[1]) / double, (y[2] - x[2]) / double];
        let root = (2.0 * (w[0] + 1.0)).sqrt();
        Scaling { v: [(w[0] + 1.0) / root, w[1] / root, w[2] / root], beta: (length_y / length_x).sqrt() }
    }

    /// W a.
    pub fn apply(&self, a: Vector) -> Vector {
        let [v, along] = [self.v, [2.0 * dot(self.v, a), 0.0, 0.0]];
        [v[0] * along[0] - a[0], v[1] * along[0] + a[1], v[2] * along[0] + a[2]].map(|w| self.beta * w)
    }

    /// W⁻¹ a.
    pub fn apply_inverse(&self, a: Vector) -> Vector {
        let v = [self.v[0], -self.v[1], -self.v[2]];
        let along = 2.0 * dot(v, a);
        [v[0] * along - a[0], v[1] * along + a[1], v[2] * along + a[2]].map(|w| w / self.beta)
    }
}

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn axpy(a: Vector, share: f64, b: Vector) -> Vector {
    [0, 1, 2].map(|k| a[k] + share * b[k])
}

/// Determinant x_N² − |x_F|², as a product, which cancels less.
pub(super) fn determinant(x: Vector) -> f64 {
    let length = norm(x[1], x[2]);
    (x[0] - length) * (x[0] + length)
}

/// The Jordan product a∘b.
pub(super) fn jordan_product(a: Vector, b: Vector) -> Vector {
    [dot(a, b), a[0] * b[1] + b[0] * a[1], a[0] * b[2] + b[0] * a[2]]
}

/// x with a∘x = b.
pub(super) fn jordan_solve(a: Vector, b: Vector) -> Vector {
    let normal = (a[0] * b[0] - a[1] * b[1] - a[2] * b[2]) / determinant(a);
    [normal, (b[1] - normal * a[1]) / a[0], (b[2] - normal * a[2]) / a[0]]
}

/// The greatest s for which x + s d is in the cone; x must be inside.
pub(super) fn max_step(x: Vector, d: Vector) -> f64 {
    let product = |a: Vector, b: Vector| a[0] * b[0] - a[1] * b[1] - a[2] * b[2];
    let (a, b, c) = (product(d, d), product(x, d), determinant(x));
    let mut most = if d[0] < 0.0 { -x[0] / d[0] } else { f64::INFINITY };
    let square = b * b - a * c;
    if square >= 0.0 {
        let q = -(b + square.sqrt().copysign(b));
        for root in [q / a, c / q] {
            if root > 0.0 && root < most {
                most = root;
            }
        }
    }
    most
}
