//! The contact problem for round cones. The rows of one contact have a common scale, so that its cone stays round.

use super::certificate::{self, Scales, largest_row_sum, max_or_nan, of_contact};
use super::law::approach_offset;
use super::problem::Problem;
use super::tolerance::{IMMOVABLE, ROUNDING};
use messages::scene::Law;

/// `v = A f + b` with three rows per contact; with one tangent the third row is empty. f~ = s f, v~ = v/s with s^2 = A_NN [sqrt(J)].
#[derive(Clone, Debug, Default)]
pub(super) struct RoundCones {
    pub contacts: usize,
    /// A~, square, of three rows per contact.
    pub delassus: Vec<f64>,
    /// b~, with the allowed approach added to the normal rows; zero in directions without motion.
    pub drift: Vec<f64>,
    /// μ of each contact.
    pub friction: Vec<f64>,
    /// s of each contact.
    pub scale: Vec<f64>,
    /// 1/s of each row of the problem; zero in directions without motion.
    inverse: Vec<f64>,
    /// Link of each contact.
    pub link: Vec<usize>,
    /// Given direction of slip of each contact, or zero.
    pub slip_direction: Vec<[f64; 2]>,
    /// Greatest diagonal entry of each contact in A~.
    pub inverse_mass: Vec<f64>,
    /// V of each contact [m/s]; see [`super::certificate`].
    speeds: Vec<f64>,
    /// |b| of each row [m/s].
    row_speeds: Vec<f64>,
    /// Largest scaled drift.
    pub size: f64,
}

impl RoundCones {
    /// Scales a problem for a law.
    pub fn set(&mut self, problem: &Problem, law: Law) {
        self.contacts = problem.contacts;
        let (n, m, stride) = (3 * problem.contacts, problem.rows(), 1 + problem.tangents);
        let greatest = (0..m).map(|k| problem.delassus[k * m + k]).fold(0.0, f64::max);
        let least = IMMOVABLE * greatest;
        let diagonal = |k: usize| problem.delassus[k * m + k];
        self.friction.clone_from(&problem.friction);
        self.scale.clear();
        self.scale.extend((0..problem.contacts).map(|i| {
            let rows = i * stride..(i + 1) * stride;
            let tangents = rows.clone().skip(1).map(diagonal).fold(0.0, f64::max);
            let own = if diagonal(rows.start) > least { diagonal(rows.start) } else { tangents };
            if own > least || own.is_nan() { own.sqrt() } else { 1.0 }
        }));
        self.inverse.clear();
        for (i, scale) in self.scale.iter().enumerate() {
            let moves = |k: usize| if diagonal(k) <= least { 0.0 } else { 1.0 / scale };
            self.inverse.extend((i * stride..(i + 1) * stride).map(moves));
        }
        self.delassus.clear();
        self.delassus.resize(n * n, 0.0);
        self.drift.clear();
        self.drift.resize(n, 0.0);
        for (k, own) in self.inverse.iter().enumerate() {
            let (i, row) = (k / stride, k / stride * 3 + k % stride);
            let extra = if k % stride == 0 { approach_offset(problem, law, i) } else { 0.0 };
            self.drift[row] = (problem.drift[k] + extra) * own;
            let scaled = self.delassus[row * n..][..n].chunks_exact_mut(3);
            let given = problem.delassus[k * m..][..m].chunks_exact(stride).zip(self.inverse.chunks_exact(stride));
            for (scaled, (a, inverse)) in scaled.zip(given) {
                scaled.iter_mut().zip(a).zip(inverse).for_each(|((scaled, a), inverse)| *scaled = a * (own * inverse));
            }
        }
        self.row_speeds.clear();
        self.row_speeds.extend(self.drift.iter().enumerate().map(|(row, b)| b.abs() * self.scale[row / 3]));
        self.size = self.drift.iter().fold(0.0, |size, b| b.abs().max(size));
        self.link.clear();
        self.link.extend((0..problem.contacts).map(|i| problem.link.get(i).copied().unwrap_or(i)));
        self.slip_direction.clear();
        self.slip_direction.extend((0..problem.contacts).map(|i| problem.given_slip(i)));
        self.inverse_mass.clear();
        let own = |i: usize| (3 * i..3 * i + 3).map(|k| self.delassus[k * n + k]).fold(0.0, f64::max);
        self.inverse_mass.extend((0..problem.contacts).map(|i| if own(i) > 0.0 { own(i) } else { 1.0 }));
        let RoundCones { delassus, drift, scale, speeds, .. } = self;
        let coupled = |i: usize, k: usize| (3 * i..3 * i + 3).any(|row| delassus[row * n + 3 * k..][..3] != [0.0; 3]);
        certificate::speeds(drift, scale, coupled, speeds);
    }

    /// The same problem over some of its contacts; the others have no impulse.
    pub fn select(&self, selected: &[usize], part: &mut RoundCones) {
        let n = 3 * self.contacts;
        let rows = || selected.iter().flat_map(|&i| 3 * i..3 * i + 3);
        part.contacts = selected.len();
        part.delassus.clear();
        rows().for_each(|row| part.delassus.extend(rows().map(|k| self.delassus[row * n + k])));
        for (part, all) in [(&mut part.drift, &self.drift), (&mut part.row_speeds, &self.row_speeds)] {
            part.clear();
            part.extend(rows().map(|row| all[row]));
        }
        for (part, all) in [
            (&mut part.friction, &self.friction),
            (&mut part.scale, &self.scale),
            (&mut part.inverse_mass, &self.inverse_mass),
            (&mut part.speeds, &self.speeds),
        ] {
            part.clear();
            part.extend(selected.iter().map(|&i| all[i]));
        }
        part.link.clear();
        part.link.extend(selected.iter().map(|&i| self.link[i]));
        part.slip_direction.clear();
        part.slip_direction.extend(selected.iter().map(|&i| self.slip_direction[i]));
        part.size = self.size;
    }

    /// V of a contact, in scaled units.
    pub fn speed(&self, i: usize) -> f64 {
        self.speeds[i] / self.scale[i]
    }

    /// Greatest natural map of Coulomb's law over all contacts.
    pub fn residual(&self, f: &[f64], v: &[f64]) -> f64 {
        let mut worst = 0.0;
        for i in 0..self.contacts {
            let (own_f, own_v, inverse_mass) = (contact_rows(f, i), contact_rows(v, i), self.inverse_mass[i]);
            let scales = Scales::of(self.speed(i), inverse_mass, own_f);
            let sum =
                || largest_row_sum(&self.delassus, f, 3 * i..3 * i + 3, |row| self.row_speeds[row], self.scale[i]);
            let given = self.slip_direction[i];
            let map = of_contact(scales, inverse_mass, [own_f, own_v], self.friction[i], given, ROUNDING, sum);
            worst = max_or_nan(worst, map);
        }
        worst
    }

    /// v~ = A~ f~ + b~.
    pub fn velocity(&self, f: &[f64], v: &mut Vec<f64>) {
        apply_delassus(&self.delassus, &self.drift, f, v);
    }

    /// Scales an impulse of the problem.
    pub fn scale_impulse(&self, impulse: &[f64], f: &mut Vec<f64>) {
        let stride = impulse.len() / self.contacts.max(1);
        f.clear();
        f.resize(3 * self.contacts, 0.0);
        for (i, part) in impulse.chunks_exact(stride.max(1)).enumerate() {
            f[3 * i..].iter_mut().zip(part).for_each(|(f, part)| *f = part * self.scale[i]);
        }
    }

    /// Converts a scaled impulse to N·s.
    pub fn unscale_impulse(&self, problem: &Problem, f: &[f64], impulse: &mut Vec<f64>) {
        impulse.clear();
        for (f, scale) in f.chunks_exact(3).zip(&self.scale) {
            impulse.extend(f.iter().take(1 + problem.tangents).map(|f| f / scale));
        }
    }

    /// max(||f~||, ||b~||): the scale of the step [sqrt(J)].
    pub fn magnitude(&self, f: &[f64]) -> f64 {
        f.iter().fold(self.size, |size, f| size.max(f.abs()))
    }
}

/// The three rows of contact i.
pub(super) fn contact_rows(x: &[f64], i: usize) -> [f64; 3] {
    [x[3 * i], x[3 * i + 1], x[3 * i + 2]]
}

/// v = A f + b, with A symmetric. Columns with zero impulse are multiplied as well, so that NaN in them propagates.
pub(super) fn apply_delassus(delassus: &[f64], drift: &[f64], impulse: &[f64], velocity: &mut Vec<f64>) {
    velocity.clear();
    velocity.extend_from_slice(drift);
    let (v, m) = (&mut velocity[..], drift.len());
    // four columns per pass: with one, each addition would wait for the store of the one before
    let (fours, rest) = impulse.as_chunks::<4>();
    for (k, f) in fours.iter().enumerate() {
        let [a, b, c, d] = std::array::from_fn(|r| &delassus[(4 * k + r) * m..][..v.len()]);
        for i in 0..v.len() {
            v[i] = d[i].mul_add(f[3], c[i].mul_add(f[2], b[i].mul_add(f[1], a[i].mul_add(f[0], v[i]))));
        }
    }
    for (f, row) in rest.iter().zip(delassus[4 * fours.len() * m..].chunks_exact(m.max(1))) {
        v.iter_mut().zip(row).for_each(|(v, a)| *v = a.mul_add(*f, *v));
    }
}

#[cfg(test)]
mod tests {
    use super::apply_delassus;
    use fastrand::Rng;

    #[test]
    fn the_product_equals_that_column_by_column_and_nan_propagates() {
        let mut rng = Rng::with_seed(1);
        for m in 0..=9 {
            let [drift, impulse]: [Vec<f64>; 2] = std::array::from_fn(|_| (0..m).map(|_| rng.f64() - 0.5).collect());
            let mut delassus: Vec<f64> = (0..m * m).map(|_| rng.f64() - 0.5).collect();
            let mut expected = drift.clone();
            for (r, f) in impulse.iter().enumerate() {
                expected.iter_mut().enumerate().for_each(|(i, v)| *v = delassus[r * m + i].mul_add(*f, *v));
            }
            let mut found = vec![1.0; 3];
            apply_delassus(&delassus, &drift, &impulse, &mut found);
            assert_eq!(found, expected, "{m} rows");
            for r in 0..m {
                let kept = std::mem::replace(&mut delassus[r * m], f64::NAN);
                apply_delassus(&delassus, &drift, &vec![0.0; m], &mut found);
                assert!(found[0].is_nan(), "row {r} of {m}: NaN must propagate");
                delassus[r * m] = kept;
            }
        }
    }
}
