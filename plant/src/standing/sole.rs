//! Distribution of a wrench over the contacts of a sole: normal impulses linear over the sole, friction in proportion to them.
//!
//! Contacts at d_i from c, with q_i = (1, x_i, y_i), carry
//!
//! ```text
//!   n_i = q_i·N⁻¹(F_z, -m_y, m_x),   N = Σ q_i q_iᵀ
//!   f_i = n_i (s + γ z × (d_i − r)), s = F/F_z, γ = (m_z − r × F)/Σ n_i|d_i − r|²
//! ```
//!
//! where r is the centre of pressure. Of all normal impulses with that load, these have the least norm. A contact that would pull is left
//! out. Contacts on one line do not hold the link against rotation about that line, and a single contact holds no rotation at all. About
//! these free axes there is no moment and no unknown, and N⁻¹ is the pseudoinverse.
//!
//! No contact slips, so the impulses obey Coulomb's law wherever |f_F| <= μ f_N.

use super::spatial_pair::SpatialPair;
use crate::contact::{COLLINEAR, PULL_ROUNDING};
use crate::detect::Touch;
use nalgebra::{Matrix3, Vector2, Vector3};

/// Trials of the friction weights at most.
const MAX_TRIALS: usize = 8;
/// Factor by which the friction weight of a slipping contact is reduced beyond the necessary [-], so that few trials suffice.
const OVERREDUCTION: f64 = 1.5;

/// The contacts of a link, relative to a point amid them.
#[derive(Clone, Debug, Default)]
pub(super) struct Sole {
    /// c, from O [m].
    pub centre: Vector3<f64>,
    /// d_i [m].
    pub arms: Vec<Vector3<f64>>,
    /// Greatest |d_i| [m].
    pub reach: f64,
    /// N⁻¹ of all contacts.
    moment_inverse: Matrix3<f64>,
    /// Projection on the free axes, about which the contacts do not hold the link; zero unless they are on one line.
    pub free_axes: Matrix3<f64>,
    /// For each contact: normal impulse, friction weight, and friction impulse.
    pressure: Vec<f64>,
    weights: Vec<f64>,
    friction_forces: Vec<Vector2<f64>>,
}

impl Sole {
    /// Allocates for so many contacts.
    pub fn new(contacts: usize) -> Sole {
        Sole {
            arms: Vec::with_capacity(contacts),
            pressure: Vec::with_capacity(contacts),
            weights: Vec::with_capacity(contacts),
            friction_forces: Vec::with_capacity(contacts),
            ..Sole::default()
        }
    }

    /// Sets the contacts of a link.
    pub fn set(&mut self, touches: &[Touch]) {
        self.centre = touches.iter().map(|touch| touch.arm).sum::<Vector3<f64>>() / touches.len() as f64;
        self.centre.z = touches[0].arm.z; // all contacts are at the height of the ground
        self.arms.clear();
        self.arms.extend(touches.iter().map(|touch| touch.arm - self.centre));
        self.free_axes = match &self.arms[..] {
            [_] => Matrix3::identity(),
            [d, _] => d.normalize() * d.normalize().transpose(),
            _ => Matrix3::zeros(),
        };
    }

    /// Prepares the sole to carry a wrench; none if three or more contacts are on one line.
    pub fn prepare(&mut self) -> Option<()> {
        self.reach = self.arms.iter().fold(0.0, |reach: f64, d| reach.max(d.norm_squared())).sqrt();
        self.moment_inverse = match &self.arms[..] {
            [_] => Matrix3::from_diagonal(&Vector3::x()),
            [d, _] => {
                let (up, along) = (Vector3::x(), Vector3::new(0.0, d.x, d.y));
                0.5 * (up * up.transpose() + along * along.transpose() / along.norm_squared().powi(2))
            }
            arms => inverse_moment_matrix(arms.iter())?,
        };
        Some(())
    }

    /// Compliance of the sole to force and moment if each contact has this compliance: N⁻¹ for normal forces, 1/Σ1 and 1/Σ|d|² for
    /// friction. It is one along free axes.
    pub fn compliance(&self, relative_compliance: f64) -> [Matrix3<f64>; 2] {
        let (n, s) = (self.arms.len() as f64, &self.moment_inverse);
        let angular = self.arms.iter().map(|d| d.xy().norm_squared()).sum::<f64>();
        let force = Matrix3::from_diagonal(&Vector3::new(1.0 / n, 1.0 / n, s[(0, 0)]));
        let twist = if angular > 0.0 { 1.0 / angular } else { 0.0 };
        let moment = Matrix3::new(s[(2, 2)], -s[(1, 2)], 0.0, -s[(1, 2)], s[(1, 1)], 0.0, 0.0, 0.0, twist);
        [force * relative_compliance, moment * relative_compliance + self.free_axes]
    }

    /// The velocity that brings every contact as far down as its allowed approach, and is zero otherwise.
    pub fn closing_velocity(&self, touches: &[Touch], approach: impl Fn(&Vector3<f64>, &Touch) -> f64) -> SpatialPair {
        let approach = |(d, touch): (&Vector3<f64>, &Touch)| affine_row(d) * approach(d, touch);
        let fit = self.moment_inverse * self.arms.iter().zip(touches).map(approach).sum::<Vector3<f64>>();
        [Vector3::new(0.0, 0.0, -fit.x), Vector3::new(-fit.z, fit.y, 0.0)]
    }

    /// Distributes the wrench over the contacts; none if a contact would have to pull or slip.
    pub fn distribute(&mut self, wrench: &SpatialPair, friction: f64, impulses: &mut [Vector3<f64>]) -> Option<()> {
        let Sole { arms, moment_inverse, pressure, weights, friction_forces, .. } = self;
        let [force, moment] = wrench;
        let pressure =
            normal_distribution(arms, moment_inverse, &Vector3::new(force.z, -moment.y, moment.x), pressure)?;
        let friction_forces =
            friction_distribution(arms, pressure, &force.xy(), moment.z, friction, weights, friction_forces)?;
        for ((impulse, f), &n) in impulses.iter_mut().zip(friction_forces).zip(pressure) {
            *impulse = Vector3::new(f.x, f.y, n);
        }
        Some(())
    }
}

/// Normal impulses of least norm for a load (F_z, -m_y, m_x) [N·s, N·m·s], none of which pulls. `all` is N⁻¹ of all contacts.
fn normal_distribution<'a>(
    arms: &[Vector3<f64>],
    all: &Matrix3<f64>,
    load: &Vector3<f64>,
    pressure: &'a mut Vec<f64>,
) -> Option<&'a [f64]> {
    pressure.clear();
    pressure.resize(arms.len(), 1.0);
    let mut fit = all * load;
    loop {
        let mut least = -PULL_ROUNDING * load.x; // a smaller pull is rounding
        let mut worst = None;
        for (i, (n, d)) in pressure.iter_mut().zip(arms).enumerate().filter(|(_, (n, _))| **n != 0.0) {
            *n = affine_row(d).dot(&fit);
            if *n < least {
                (least, worst) = (*n, Some(i));
            }
            *n = n.max(0.0);
        }
        let Some(worst) = worst else { return Some(pressure) };
        pressure[worst] = 0.0;
        let rest = arms.iter().zip(&*pressure).filter(|(_, n)| **n != 0.0).map(|(d, _)| d);
        fit = inverse_moment_matrix(rest)? * load;
    }
}

/// Friction impulses for a force and a moment: in proportion to the normal impulses, reduced where a contact would slip.
fn friction_distribution<'a>(
    arms: &[Vector3<f64>],
    pressure: &[f64],
    force: &Vector2<f64>,
    moment: f64,
    friction: f64,
    weights: &mut Vec<f64>,
    friction_forces: &'a mut Vec<Vector2<f64>>,
) -> Option<&'a [Vector2<f64>]> {
    weights.clear();
    weights.extend_from_slice(pressure);
    for _ in 0..MAX_TRIALS {
        let total: f64 = weights.iter().sum();
        let centre: Vector2<f64> = arms.iter().zip(&*weights).map(|(d, g)| d.xy() * *g).sum::<Vector2<f64>>() / total;
        let inertia: f64 = arms.iter().zip(&*weights).map(|(d, g)| g * (d.xy() - centre).norm_squared()).sum();
        let twist = if inertia > 0.0 { (moment - centre.perp(force)) / inertia } else { 0.0 };
        let mean = force / total;
        friction_forces.clear();
        let mut slips = false;
        for ((d, g), n) in arms.iter().zip(weights.iter_mut()).zip(pressure) {
            let from = d.xy() - centre;
            let f = (mean + Vector2::new(-from.y, from.x) * twist) * *g;
            let excess = f.norm() / (friction * n);
            if excess > 1.0 {
                *g /= OVERREDUCTION * excess * excess;
                slips = true;
            }
            friction_forces.push(f);
        }
        if !slips {
            return Some(friction_forces);
        }
    }
    None
}

/// q_i.
fn affine_row(d: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(1.0, d.x, d.y)
}

/// N⁻¹.
fn inverse_moment_matrix<'a>(arms: impl Iterator<Item = &'a Vector3<f64>>) -> Option<Matrix3<f64>> {
    let n = arms.fold(Matrix3::zeros(), |n, d| n + affine_row(d) * affine_row(d).transpose());
    let regular = n.determinant() > COLLINEAR * n.diagonal().product();
    if regular { n.try_inverse() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MU: f64 = 0.7;

    /// A sole of 200 mm by 100 mm.
    fn foot() -> Sole {
        let point = |(id, (x, y)): (usize, (f64, f64))| {
            let arm = Vector3::new(0.3 + x, y - 0.2, -0.6);
            Touch::new(id, 1, arm, 0.0)
        };
        let mut sole = Sole::default();
        let corners = [(0.1, 0.05), (0.1, -0.05), (-0.1, 0.05), (-0.1, -0.05)];
        sole.set(&corners.into_iter().enumerate().map(point).collect::<Vec<_>>());
        sole.prepare().expect("a sole");
        sole
    }

    /// Impulses of a load at a place on the sole, with friction there and a moment about the normal.
    fn spread(
        [x, y]: [f64; 2],
        friction_forces: [f64; 2],
        twist: f64,
    ) -> (Sole, SpatialPair, Option<Vec<Vector3<f64>>>) {
        let (mut sole, mut impulses) = (foot(), vec![Vector3::zeros(); 4]);
        let (load, yaw) = (0.1, twist + x * friction_forces[1] - y * friction_forces[0]);
        let wrench =
            [Vector3::new(friction_forces[0], friction_forces[1], 1.0) * load, Vector3::new(y, -x, yaw) * load];
        let found = sole.distribute(&wrench, MU, &mut impulses);
        (sole, wrench, found.map(|()| impulses))
    }

    /// Checks that the impulses are within the law; returns how far they are from the wrench.
    fn lawful(sole: &Sole, wrench: &SpatialPair, impulses: &[Vector3<f64>]) -> f64 {
        for (d, f) in sole.arms.iter().zip(impulses) {
            assert!(f.z >= 0.0 && f.xy().norm() <= MU * f.z * (1.0 + 1e-12), "{f:?} at {d:?}");
        }
        let moment = |(d, f): (&Vector3<f64>, &Vector3<f64>)| d.cross(f);
        let sum: SpatialPair = [impulses.iter().sum(), sole.arms.iter().zip(impulses).map(moment).sum()];
        sum.iter().zip(wrench).fold(0.0_f64, |most, (a, b)| most.max((a - b).amax()))
    }

    #[test]
    fn impulses_balance_the_wrench_within_the_law() {
        for place in [[0.0, 0.0], [0.07, -0.02], [-0.095, 0.0], [0.06, 0.03]] {
            for (friction_forces, twist) in
                [([0.0, 0.0], 0.0), ([0.2, -0.3], 0.0), ([0.05, 0.1], 0.01), ([0.0, -0.1], -0.015)]
            {
                let (sole, wrench, impulses) = spread(place, friction_forces, twist);
                let impulses = impulses.unwrap_or_else(|| panic!("{place:?} {friction_forces:?} {twist}"));
                let error = lawful(&sole, &wrench, &impulses);
                assert!(error < 1e-15, "{place:?} {friction_forces:?} {twist}: {error:e}");
            }
        }
    }

    #[test]
    fn an_edge_carries_no_moment_about_itself() {
        let ends = [Vector3::new(0.1, 0.05, -0.6), Vector3::new(-0.1, 0.03, -0.6)];
        let touch = |(id, arm): (usize, Vector3<f64>)| Touch::new(id, 1, arm, 0.0);
        let touches: Vec<_> = ends.into_iter().enumerate().map(touch).collect();
        let (mut sole, mut impulses) = (Sole::default(), vec![Vector3::zeros(); 2]);
        sole.set(&touches);
        sole.prepare().expect("an edge");
        let carries = |share: f64, sole: &mut Sole, impulses: &mut [Vector3<f64>]| {
            let force = Vector3::new(0.02, -0.01, 0.1);
            let moment = (sole.arms[0] * share + sole.arms[1] * (1.0 - share)).cross(&force);
            assert!((sole.free_axes * moment).amax() < 1e-17, "{moment:?}");
            sole.distribute(&[force, moment], MU, impulses).map(|()| [force, moment])
        };
        for share in [0.1, 0.5, 0.9] {
            let [force, moment] = carries(share, &mut sole, &mut impulses).unwrap_or_else(|| panic!("{share}"));
            let moments: Vector3<f64> = sole.arms.iter().zip(&impulses).map(|(d, f)| d.cross(f)).sum();
            let error = (impulses[0] + impulses[1] - force).amax().max((moments - moment).amax());
            assert!(error < 1e-15, "{share}: {error:e}");
        }
        assert!(carries(1.01, &mut sole, &mut impulses).is_none(), "an end pulls");
        let between = Touch::new(2, 1, (ends[0] + ends[1]) * 0.5, 0.0);
        sole.set(&[touches[0], touches[1], between]);
        assert!(sole.prepare().is_none(), "three in line");
    }

    #[test]
    fn a_sole_that_would_tip_or_slip_has_no_distribution() {
        for (place, friction_forces, twist) in [
            ([0.101, 0.0], [0.0, 0.0], 0.0),
            ([0.0, -0.051], [0.0, 0.0], 0.0),
            ([0.0, 0.0], [0.5, 0.6], 0.0),
            ([0.0, 0.0], [0.0, 0.0], 0.08), // more than mu times the distance of the contacts
        ] {
            let (.., impulses) = spread(place, friction_forces, twist);
            assert!(impulses.is_none(), "{place:?} {friction_forces:?} {twist}: {impulses:?}");
        }
    }

    /// The load moves to where a contact carries nothing, and to the edge of the sole, and slightly beyond either.
    #[test]
    fn the_wrench_is_balanced_to_rounding_near_tipping() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut none = 0;
        for _ in 0..20_000 {
            let hair = 10_f64.powf(-2.0 - 12.0 * rng.f64()) * if rng.bool() { 1.0 } else { -1.0 };
            let (along, angular_gain, far) = (0.1 + 0.8 * rng.f64(), [rng.bool(), rng.bool()], rng.bool());
            // |x|/a + |y|/b = 1, where one contact of four carries nothing, or an edge of the sole
            let [x, y] = if far { [1.0, along] } else { [along, 1.0 - along] };
            let turn = |x: f64, angular_gain: bool| if angular_gain { -x } else { x } * (1.0 + hair);
            let place = [0.1 * turn(x, angular_gain[0]), 0.05 * turn(y, angular_gain[1])];
            let (sole, wrench, impulses) = spread(place, [0.02, -0.05], 0.0);
            let outside = far && hair > 0.0;
            let Some(impulses) = impulses else {
                assert!(outside, "none at {place:?}, {hair:e} from where it would tip");
                none += 1;
                continue;
            };
            assert!(!outside || hair < 1e-12, "{hair:e} beyond the edge: {impulses:?}");
            let error = lawful(&sole, &wrench, &impulses);
            assert!(error < 2e-15, "{place:?}, {hair:e}: {error:e}");
        }
        assert!(none > 1000, "{none}");
    }
}
