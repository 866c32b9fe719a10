//! A foot and its sole.

use messages::robot::Body;
use nalgebra::{Point3, Vector3};

/// A foot and its flat rectangular sole.
pub struct FootGeometry {
    /// Index of the body.
    pub body: usize,
    /// Centre of the sole in the body's frame [m].
    pub sole: Point3<f64>,
    /// Half the depth and half the width of the sole [m].
    pub half: [f64; 2],
}

impl FootGeometry {
    /// The sole is the bounding rectangle of the body's contact points. Without contact points it is the bottom of the box.
    pub fn new(index: usize, body: &Body) -> Self {
        let [depth, width, height] = body.size;
        if body.contacts.is_empty() {
            let sole = Point3::from(body.com) - Vector3::z() * height / 2.0;
            return FootGeometry { body: index, sole, half: [depth / 2.0, width / 2.0] };
        }
        let span = |axis: usize| {
            let values = body.contacts.iter().map(move |point| point[axis]);
            (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max))
        };
        let [x, y, z] = [span(0), span(1), span(2)];
        let sole = Point3::new((x.0 + x.1) / 2.0, (y.0 + y.1) / 2.0, z.0);
        FootGeometry { body: index, sole, half: [(x.1 - x.0) / 2.0, (y.1 - y.0) / 2.0] }
    }
}
