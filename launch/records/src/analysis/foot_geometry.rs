//! A foot and its sole.

use super::convex_hull::convex_hull;
use messages::robot::Body;
use nalgebra::{Point3, Vector2, Vector3};

/// A foot and its flat sole.
pub struct FootGeometry {
    /// Index of the body.
    pub body: usize,
    /// Centre of the sole's bounding rectangle in the body's frame [m].
    pub sole: Point3<f64>,
    /// Half the depth and half the width of that rectangle [m].
    pub half: [f64; 2],
    /// Corners of the sole from that centre, anticlockwise [m].
    pub outline: Vec<Vector2<f64>>,
}

impl FootGeometry {
    /// The sole is the convex hull of the body's contact points. Without contact points it is the bottom of the box.
    pub fn new(index: usize, body: &Body) -> Self {
        let [depth, width, height] = body.size;
        if body.contacts.is_empty() {
            let sole = Point3::from(body.com) - Vector3::z() * height / 2.0;
            let [a, b] = [depth / 2.0, width / 2.0];
            let outline = [[-a, -b], [a, -b], [a, b], [-a, b]].map(Vector2::from).into();
            return FootGeometry { body: index, sole, half: [a, b], outline };
        }
        let span = |axis: usize| {
            let values = body.contacts.iter().map(move |point| point[axis]);
            (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max))
        };
        let [x, y, z] = [span(0), span(1), span(2)];
        let sole = Point3::new((x.0 + x.1) / 2.0, (y.0 + y.1) / 2.0, z.0);
        let corners = convex_hull(body.contacts.iter().map(|[x, y, _]| (x - sole.x, y - sole.y)).collect());
        let outline = corners.into_iter().map(|(x, y)| Vector2::new(x, y)).collect();
        FootGeometry { body: index, sole, half: [(x.1 - x.0) / 2.0, (y.1 - y.0) / 2.0], outline }
    }

    /// Distance of a point from the edge of the sole, from its centre; negative outside [m].
    pub fn margin(&self, point: Vector2<f64>) -> f64 {
        let next = self.outline.iter().cycle().skip(1);
        let inside = |(from, to): (&Vector2<f64>, &Vector2<f64>)| (to - from).normalize().perp(&(point - from));
        self.outline.iter().zip(next).map(inside).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn foot(points: &[[f64; 2]]) -> FootGeometry {
        let contacts = points.iter().map(|[x, y]| [x + 0.03, y - 0.01, -0.05]).collect();
        FootGeometry::new(0, &Body { contacts, ..Body::default() })
    }

    #[test]
    fn the_margin_is_the_distance_from_the_edge_of_the_convex_hull() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a}, not {b}");
        // a rectangle with points within it and on its edge
        let rectangle = foot(&[[0.1, 0.05], [-0.1, 0.05], [0.1, -0.05], [-0.1, -0.05], [0.0, 0.0], [0.1, 0.0]]);
        assert_eq!(rectangle.outline.len(), 4);
        for [x, y] in [[0.0, 0.0], [0.09, 0.02], [-0.03, -0.045], [0.12, 0.0], [0.0, 0.07]] {
            near(rectangle.margin(Vector2::new(x, y)), f64::min(0.1 - f64::abs(x), 0.05 - f64::abs(y)));
        }
        // the distance from the edge x/.12 + y/.06 = 1
        let diamond = foot(&[[0.12, 0.0], [0.0, 0.06], [0.0, -0.06], [-0.12, 0.0]]);
        for [x, y] in [[0.0, 0.0], [0.09, 0.0], [0.1, 0.03], [-0.05, 0.01]] {
            let edge = (1.0 - f64::abs(x) / 0.12 - f64::abs(y) / 0.06) / f64::hypot(1.0 / 0.12, 1.0 / 0.06);
            near(diamond.margin(Vector2::new(x, y)), edge);
        }
        let triangle = foot(&[[0.0, 0.0], [0.2, 0.0], [0.0, 0.1]]);
        near(triangle.margin(Vector2::new(0.0, 0.0)), 0.0); // the middle of its longest side
        near(triangle.margin(Vector2::new(-0.09, 0.0)), 0.01);
    }
}
