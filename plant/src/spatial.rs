//! Spatial vectors about one reference point: velocities, wrenches, and the inertia of a rigid body.
//!
//! Everything is in W axes and about the reference point O of [`crate::kinematics::Pose`]. So columns and inertias of different links add
//! without any transformation (Featherstone, Rigid Body Dynamics Algorithms, 2008).

use nalgebra::{Matrix3, Vector3};
use std::ops::{Add, AddAssign, Mul};

/// An angular and a linear vector about O: a velocity (w, v) of the body point at O, or a wrench (n, f).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spatial {
    /// Angular velocity [rad/s], or moment about O [N·m].
    pub angular: Vector3<f64>,
    /// Velocity of the body point at O [m/s], or force [N].
    pub linear: Vector3<f64>,
}

impl Spatial {
    /// The wrench of a force [N] at a point, given from O [m].
    pub fn force_at(point: &Vector3<f64>, force: &Vector3<f64>) -> Self {
        Spatial { angular: point.cross(force), linear: *force }
    }

    /// Power of a wrench on a velocity [W], or effort of a wrench on a column [N·m or N].
    #[inline]
    pub fn dot(&self, other: &Spatial) -> f64 {
        self.angular.dot(&other.angular) + self.linear.dot(&other.linear)
    }

    /// Rate of change of a spatial velocity fixed in a body that moves with `self`: (w × a, w × l + v × a).
    #[inline]
    pub fn cross(&self, other: &Spatial) -> Spatial {
        Spatial {
            angular: self.angular.cross(&other.angular),
            linear: self.angular.cross(&other.linear) + self.linear.cross(&other.angular),
        }
    }

    /// Velocity of the body point at `point`, given from O: v + w × r [m/s].
    #[inline]
    pub fn at(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(point)
    }
}

impl Add for Spatial {
    type Output = Spatial;
    #[inline]
    fn add(self, other: Spatial) -> Spatial {
        Spatial { angular: self.angular + other.angular, linear: self.linear + other.linear }
    }
}

impl AddAssign for Spatial {
    #[inline]
    fn add_assign(&mut self, other: Spatial) {
        *self = *self + other;
    }
}

impl Mul<f64> for Spatial {
    type Output = Spatial;
    #[inline]
    fn mul(self, factor: f64) -> Spatial {
        Spatial { angular: self.angular * factor, linear: self.linear * factor }
    }
}

/// A symmetric 3×3 matrix: xx, yy, zz, xy, xz, yz.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Symmetric(pub [f64; 6]);

impl Symmetric {
    /// The full matrix.
    pub fn matrix(&self) -> Matrix3<f64> {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    /// R diag(m) Rᵀ = m_x 1 + (m_y - m_x) y yᵀ + (m_z - m_x) z zᵀ with the columns y, z of R.
    #[inline]
    pub fn principal(m: &Vector3<f64>, r: &Matrix3<f64>) -> Symmetric {
        let (y, z) = (r.column(1), r.column(2));
        let (a, b) = (y * (m.y - m.x), z * (m.z - m.x));
        let entry = |i: usize, j: usize| a[i] * y[j] + b[i] * z[j];
        Symmetric([m.x + entry(0, 0), m.x + entry(1, 1), m.x + entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)])
    }

    /// m (c² 1 - c cᵀ): inertia of a point mass m at c about the origin.
    #[inline]
    pub fn of_point(mass: f64, c: &Vector3<f64>) -> Symmetric {
        let (x, y, z) = (mass * c.x, mass * c.y, mass * c.z);
        let (xx, yy, zz) = (x * c.x, y * c.y, z * c.z);
        Symmetric([yy + zz, xx + zz, xx + yy, -x * c.y, -x * c.z, -y * c.z])
    }
}

impl Add for Symmetric {
    type Output = Symmetric;
    #[inline]
    fn add(self, other: Symmetric) -> Symmetric {
        Symmetric(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Mul<&Vector3<f64>> for &Symmetric {
    type Output = Vector3<f64>;
    #[inline]
    fn mul(self, v: &Vector3<f64>) -> Vector3<f64> {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        Vector3::new(xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z)
    }
}

/// Inertia about O of a rigid body, or of several that move as one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inertia {
    /// Mass [kg].
    pub mass: f64,
    /// First moment m c, c being the centre of mass from O [kg·m].
    pub first: Vector3<f64>,
    /// Second moment about O [kg·m²].
    pub second: Symmetric,
}

impl Inertia {
    /// A body with `mass`, centre of mass `com` from O, and inertia `tensor` about that centre in W axes.
    #[inline]
    pub fn new(mass: f64, com: &Vector3<f64>, tensor: &Symmetric) -> Self {
        Inertia { mass, first: com * mass, second: *tensor + Symmetric::of_point(mass, com) }
    }

    /// Momentum of a velocity, or wrench of an acceleration: (J w + m c × v, m v + w × m c).
    #[inline]
    pub fn times(&self, motion: &Spatial) -> Spatial {
        Spatial {
            angular: &self.second * &motion.angular + self.first.cross(&motion.linear),
            linear: motion.linear * self.mass + motion.angular.cross(&self.first),
        }
    }

    /// The same for unit motions along and about the axes of W, with the same bits: adding zero makes 0 of -0, as the sums of products do.
    #[inline]
    pub fn columns(&self) -> [Spatial; 6] {
        let (m, [x, y, z]) = (self.mass, self.first.into());
        let [xx, yy, zz, xy, xz, yz] = self.second.0;
        [
            ([0.0, z, -y], [m, 0.0, 0.0]),
            ([-z, 0.0, x], [0.0, m, 0.0]),
            ([y, -x, 0.0], [0.0, 0.0, m]),
            ([xx, xy, xz], [0.0, -z, y]),
            ([xy, yy, yz], [z, 0.0, -x]),
            ([xz, yz, zz], [-y, x, 0.0]),
        ]
        .map(|(n, f)| Spatial { angular: n.map(|n| n + 0.0).into(), linear: f.map(|f| f + 0.0).into() })
    }
}

impl AddAssign for Inertia {
    #[inline]
    fn add_assign(&mut self, other: Inertia) {
        self.mass += other.mass;
        self.first += other.first;
        self.second = self.second + other.second;
    }
}
