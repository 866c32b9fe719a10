//! Growing problems: contact points of a table on four sprung feet, links of a chain, step length of a standing biped.

use crate::chart::cases::{Combination, LAW, scene};
use messages::robot::{Body, Joint};
use messages::scene::{Base, Method, Scene};
use shared::exit::Failure;

/// Steps of a run.
const STEPS: f64 = 100.0;
/// Law and integrator: the one that corresponds to MuJoCo's Euler.
const COMBINATION: Combination = Combination { law: LAW, method: Method::SemiImplicitEuler };

/// A growing quantity. The exponent is fitted for values from `from` on.
pub struct GrowthCurve {
    pub name: &'static str,
    pub title: &'static str,
    pub axis: &'static str,
    pub from: f64,
    values: &'static [f64],
    scene: fn(f64) -> Result<Scene, Failure>,
}

impl GrowthCurve {
    pub const ALL: [GrowthCurve; 3] = [
        GrowthCurve {
            name: "contacts",
            title: "contact points under a table of ten degrees of freedom",
            axis: "contacts",
            from: 4.0,
            values: &[0., 1., 2., 3., 4., 5., 6., 7., 8., 9., 10., 11., 12., 13., 14., 15., 16.],
            scene: |points| Ok(table(points as usize)),
        },
        GrowthCurve {
            name: "links",
            title: "links of a chain that swings in space",
            axis: "links",
            from: 8.0,
            values: &[3., 4., 6., 8., 12., 16., 24., 32., 48., 64.],
            scene: |links| Ok(chain(links as usize)),
        },
        GrowthCurve {
            name: "dt",
            title: "length of a step of the standing biped",
            axis: "step [ms]",
            from: 0.1,
            values: &[0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0],
            scene: |milliseconds| scene("stand0", COMBINATION, 1e-3 * milliseconds, &[]),
        },
    ];

    /// The values, each with its scene.
    ///
    /// # Errors
    /// None: the scenes are good.
    pub fn scenes(&self, quick: bool) -> Result<Vec<(f64, Scene)>, Failure> {
        let values = self.values.iter().step_by(if quick { 3 } else { 1 });
        let scene = |&value| {
            let scene = (self.scene)(value)?;
            Ok((value, Scene { duration: STEPS * scene.plant.dt, rate: 1.0 / scene.plant.dt, ..scene }))
        };
        values.map(scene).collect()
    }
}

/// A scene of these bodies.
fn scene_of(bodies: Vec<Body>, base: Base) -> Scene {
    let mut scene = Scene { bodies, ..Scene::default() };
    scene.plant.base = base;
    (scene.plant.law, scene.plant.method) = (COMBINATION.law, COMBINATION.method);
    (scene.plant.dt, scene.plant.drive_inertia) = (1e-3, 0.0);
    scene
}

/// Four feet on springs below a trunk, with `points` of their sixteen corners, distributed over the feet.
fn table(points: usize) -> Scene {
    let sides = [[1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]];
    let mut bodies = vec![Body { name: "trunk".into(), mass: 4.0, size: [0.4, 0.3, 0.1], ..Body::default() }];
    for (i, [x, y]) in sides.iter().enumerate() {
        let count = (points + 3 - i) / 4;
        bodies.push(Body {
            name: format!("foot {i}"),
            mass: 0.5,
            size: [0.1, 0.1, 0.05],
            com: [0.0, 0.0, -0.2],
            contacts: sides[..count].iter().map(|[dx, dy]| [0.05 * x * dx, 0.05 * y * dy, -0.225]).collect(),
            joint: Some(Joint {
                parent: "trunk".into(),
                axis: [0.0, 1.0, 0.0],
                at: [0.2 * x, 0.15 * y, -0.05],
                stiffness: 200.0,
                damping: 2.0,
                ..Joint::default()
            }),
            ..Body::default()
        });
    }
    let mut scene = scene_of(bodies, Base::Quaternion);
    scene.initial.clearance = Some(0.0).filter(|_| points > 0);
    scene
}

/// A chain of links below a hook, with alternating perpendicular axes, released bent.
fn chain(links: usize) -> Scene {
    let mut bodies = vec![Body { name: "0".into(), mass: 1.0, size: [0.05; 3], ..Body::default() }];
    for i in 1..=links {
        let axis = if i % 2 == 0 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let at = [0.0, 0.0, if i == 1 { 0.0 } else { -0.1 }];
        bodies.push(Body {
            name: i.to_string(),
            mass: 0.2,
            size: [0.04, 0.04, 0.1],
            com: [0.0, 0.0, -0.05],
            joint: Some(Joint { parent: (i - 1).to_string(), axis, at, ..Joint::default() }),
            ..Body::default()
        });
    }
    let mut scene = scene_of(bodies, Base::Fixed);
    scene.initial.joints = vec![0.2; links];
    scene
}
