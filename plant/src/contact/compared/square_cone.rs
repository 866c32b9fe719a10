//! Distance of an impulse from a law with a four-sided friction cone, |f_1| + |f_2| <= μ f_N, along the problem's tangents. The solvers
//! with a basis accept an impulse if this distance is small enough.

use super::super::certificate::relative;
use super::scaled_problem::ScaledProblem;
use super::vector::max_abs;

/// The optimality conditions that the natural map measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Optimality {
    /// Coulomb's law (17)-(22), the measure for every law.
    Coulomb,
    /// The convex program (14)-(16).
    EnergyMinimum,
}

/// max(||f~||, ||b~||): the scale of the step [sqrt(J)].
pub(super) fn scale(scaled: &ScaledProblem, f: &[f64]) -> f64 {
    scaled.size.max(max_abs(f))
}

/// Natural map: the greatest entry of ||f - P_K(f - v̂)||, relative to the step's scale.
///
/// K is the cone along the law's tangents: |f_F| <= μ f_N with one tangent, the square cone |f_1| + |f_2| <= μ f_N with two. The map
/// vanishes exactly when f minimises f·v̂ over K. With v̂_N = v_N + μ |v_F|, where |v_F| is the largest slip along a tangent (De Saxcé's
/// correction), these are the conditions (17)-(22). With v̂ = v, they are the conditions of (14)-(16), which ask for v_N >= μ |v_F|
/// instead.
pub(super) fn natural_map(scaled: &ScaledProblem, f: &[f64], v: &[f64], optimality: Optimality) -> f64 {
    let (mut worst, mut nan) = (0.0_f64, 0.0);
    for i in 0..scaled.contacts {
        let [f, v, cone_slope] = [f, v, &scaled.cone_slope].map(|rows| contact_rows(scaled, i, rows));
        let mut x = [f[0] - v[0], f[1] - v[1], f[2] - v[2]];
        if optimality == Optimality::Coulomb {
            x[0] -= saxce_shift(cone_slope, v);
        }
        let nearest = nearest_point(x, [cone_slope[1], cone_slope[2]]);
        for k in 0..3 {
            let error = (f[k] - nearest[k]).abs();
            worst = if error > worst { error } else { worst };
            nan += 0.0 * x[k]; // propagates NaN, which the projection and the comparisons hide
        }
    }
    relative(worst + nan, scale(scaled, f))
}

/// Nearest point of the cone |x_1|/h_1 + |x_2|/h_2 <= x_0. With h_2 = 0 it is the planar cone |x_1| <= h_1 x_0.
///
/// The cases are decided by signs. Comparing distances would lose half of the digits, because distances differ in second order only.
fn nearest_point(x: [f64; 3], half: [f64; 2]) -> [f64; 3] {
    let [n, a, b] = [x[0], x[1].abs(), x[2].abs()];
    let [h1, h2] = half;
    if n + a * h1 <= 0.0 && n + b * h2 <= 0.0 {
        return [0.0; 3];
    }
    let excess = a * h2 + b * h1 - n * h1 * h2;
    let inside = if h2 == 0.0 { b == 0.0 && a <= h1 * n } else { excess <= 0.0 };
    if inside {
        return x;
    }
    let signed = |nearest: [f64; 3]| [nearest[0], nearest[1].copysign(x[1]), nearest[2].copysign(x[2])];
    if h2 > 0.0 {
        let step = excess / (h1 * h1 * (1.0 + h2 * h2) + h2 * h2);
        let facet = [n + step * h1 * h2, a - step * h2, b - step * h1];
        if facet.iter().all(|&p| p >= 0.0) {
            return signed(facet);
        }
    }
    // Squared lengths of the edges, and projections on them. The longer projection is positive.
    let (l1, l2) = (1.0 + h1 * h1, 1.0 + h2 * h2);
    let (p1, p2) = (n + a * h1, n + b * h2);
    if p1 > 0.0 && (p2 <= 0.0 || p1 * p1 * l2 >= p2 * p2 * l1) {
        signed([p1 / l1, p1 / l1 * h1, 0.0])
    } else {
        signed([p2 / l2, 0.0, p2 / l2 * h2])
    }
}

/// Rows of contact i; zero for a tangent that the problem does not have.
fn contact_rows(scaled: &ScaledProblem, i: usize, rows: &[f64]) -> [f64; 3] {
    let stride = scaled.stride();
    match rows[i * stride..(i + 1) * stride] {
        [normal, along, across] => [normal, along, across],
        [normal, along] => [normal, along, 0.0],
        _ => [f64::NAN; 3],
    }
}

/// De Saxcé's correction μ |v_F| of a contact in scaled units, |v_F| being the largest slip along a tangent.
fn saxce_shift(cone_slope: [f64; 3], v: [f64; 3]) -> f64 {
    f64::max(0.0, cone_slope[1] * v[1].abs()).max(cone_slope[2] * v[2].abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use fastrand::Rng;

    /// One contact with μ = .5.
    fn contact(tangents: usize, cone_slope: &[f64]) -> ScaledProblem {
        let mut scaled = ScaledProblem::default();
        (scaled.contacts, scaled.tangents, scaled.size) = (1, tangents, 1.0);
        scaled.cone_slope = cone_slope.to_vec();
        scaled
    }

    #[test]
    fn one_tangent_equals_two_with_one_frictionless() {
        let (seed, mut rng) = (fastrand::u64(..), Rng::new());
        println!("seed {seed}");
        rng.seed(seed);
        for _ in 0..1000 {
            let [f, v] = [(); 2].map(|()| [2.0 * rng.f64() - 1.0, 2.0 * rng.f64() - 1.0, 0.0]);
            for optimality in [Optimality::Coulomb, Optimality::EnergyMinimum] {
                let one = natural_map(&contact(1, &[0.0, 0.5]), &f[..2], &v[..2], optimality);
                let two = natural_map(&contact(2, &[0.0, 0.5, 0.0]), &f, &v, optimality);
                assert_eq!(one, two, "{f:?} {v:?}");
            }
        }
    }

    #[test]
    fn nan_gives_a_nan_residual() {
        let scaled = contact(2, &[0.0, 0.5, 0.5]);
        for k in 0..6 {
            let mut rows = [0.0; 6];
            rows[k] = f64::NAN;
            let found = natural_map(&scaled, &rows[..3], &rows[3..], Optimality::Coulomb);
            assert!(found.is_nan(), "number {k}: {found}");
        }
    }

    /// Moreau's theorem: p is the nearest point of a cone to x exactly if p is in the cone, x − p has no acute angle with any edge, and x −
    /// p is perpendicular to p.
    #[test]
    fn the_projection_is_in_the_cone_and_no_edge_is_nearer() {
        let (seed, mut rng) = (fastrand::u64(..), Rng::new());
        println!("seed {seed}");
        rng.seed(seed);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let unit = |a: [f64; 3]| a.map(|x| x / dot(a, a).sqrt());
        let mut ends = [0; 4];
        for _ in 0..100_000 {
            let size = if rng.bool() { 1.0 } else { 12.0 }; // in decades
            let [h1, mut h2] = [(); 2].map(|()| 10_f64.powf(size * (rng.f64() - 0.5)));
            let mut x = [(); 3].map(|()| (2.0 * rng.f64() - 1.0) * 10_f64.powf(-4.0 * rng.f64()));
            if rng.u8(..) < 32 {
                (h2, x[2]) = (0.0, 0.0); // one tangent
            }
            let (p, much) = (nearest_point(x, [h1, h2]), 1e-14 * dot(x, x).sqrt());
            let rest = [0, 1, 2].map(|k| x[k] - p[k]);
            let context = format!("{p:?} of {x:?} for {h1:e}, {h2:e}");
            let outside = match h2 > 0.0 {
                true => dot(unit([-h1 * h2, h2, h1]), [p[0], p[1].abs(), p[2].abs()]),
                false => dot(unit([-h1, 1.0, 0.0]), [p[0], p[1].abs(), 0.0]) + p[2].abs(),
            };
            assert!(p[0] >= 0.0 && outside <= much, "outside by {outside:e}: {context}");
            for edge in [[1.0, h1, 0.0], [1.0, -h1, 0.0], [1.0, 0.0, h2], [1.0, 0.0, -h2]] {
                let nearer = dot(unit(edge), rest);
                assert!(nearer <= much, "{edge:?} leads nearer by {nearer:e}: {context}");
            }
            let along = dot(rest, p);
            assert!(along.abs() <= much * dot(x, x).sqrt(), "not at right angles, {along:e}: {context}");
            ends[if rest == [0.0; 3] {
                3
            } else {
                p.iter().filter(|p| **p != 0.0).count() - usize::from(p[0] != 0.0)
            }] += 1;
        }
        println!("at the tip, on an edge, on a face, inside: {ends:?}");
        assert!(ends.iter().all(|count| *count > 1000), "{ends:?}");
    }
}
