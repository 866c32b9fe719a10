//! Random robots and states, and comparisons.

use biped_plant::composite::Composite;
use biped_plant::factor::{Factor, PathMatrix};
use biped_plant::kinematics::{self, Pose};
use biped_plant::model::Model;
use biped_plant::state::State;
use messages::robot::{Body, Joint, JointKind};
use messages::scene::{Base, Scene};
use nalgebra::{DMatrix, DVector, Vector3};

pub const BASES: [Base; 4] = [Base::Fixed, Base::Planar, Base::Virtual, Base::Quaternion];

/// A model in a state, with all results of the fast path.
pub struct Case {
    pub model: Model,
    pub state: State,
    pub pose: Pose,
    pub h: PathMatrix,
    pub b: Vec<f64>,
}

impl Case {
    pub fn new(model: &Model, state: &State) -> Self {
        let (model, state) = (model.clone(), state.clone());
        let pose = Pose::of(&model, &state);
        let (h, b) = Composite::equations(&model, &pose, &state.xdot);
        Case { model, state, pose, h, b }
    }

    pub fn inertia(&self) -> DMatrix<f64> {
        self.h.dense(&self.model)
    }

    /// H⁻¹ v by the sparse factor.
    pub fn solve(&self, v: &[f64]) -> Vec<f64> {
        let factor = Factor::of(&self.model, &self.h).expect("a positive H");
        let mut solution = v.to_vec();
        factor.solve(&self.model, &mut solution);
        solution
    }

    /// xddot under the effort u.
    pub fn forward(&self, u: &[f64]) -> Vec<f64> {
        self.solve(&u.iter().zip(&self.b).map(|(u, b)| u - b).collect::<Vec<_>>())
    }

    /// Jacobian of a point, 3 × dofs.
    pub fn jacobian(&self, link: usize, at: &Vector3<f64>) -> DMatrix<f64> {
        let arm = self.pose.arm(link, at);
        let mut jacobian = DMatrix::zeros(3, self.model.dofs());
        let mut row = vec![0.0; self.model.depth(link)];
        for axis in 0..3 {
            let mut direction = Vector3::zeros();
            direction[axis] = 1.0;
            kinematics::contact_column(&self.model, &self.pose, link, &arm, &direction, &mut row);
            for (value, &dof) in row.iter().zip(self.model.path(link)) {
                jacobian[(axis, dof)] = *value;
            }
        }
        jacobian
    }
}

/// Table 1 on a base, without drive inertia.
pub fn bare_table_1(base: Base) -> Scene {
    let mut scene = Scene::default();
    scene.plant.base = base;
    scene.plant.drive_inertia = 0.0;
    scene
}

pub fn model(scene: &Scene) -> Model {
    Model::new(scene).expect("a good scene")
}

pub fn vector(rng: &mut fastrand::Rng, size: f64) -> [f64; 3] {
    std::array::from_fn(|_| size * (2.0 * rng.f64() - 1.0))
}

/// A robot of twelve bodies listed in any order, branched or one long chain, with sliding joints, drives, damping, payload and slope.
pub fn random_tree(rng: &mut fastrand::Rng, base: Base) -> Scene {
    let is_chain = rng.bool();
    let mut bodies: Vec<Body> = (0..12)
        .map(|i| Body {
            name: format!("body {i}"),
            mass: 0.5 + rng.f64(),
            size: [0.1 + 0.2 * rng.f64(), 0.1 + 0.2 * rng.f64(), 0.1 + 0.2 * rng.f64()],
            com: vector(rng, 0.1),
            joint: (i > 0).then(|| Joint {
                parent: format!("body {}", if is_chain { i - 1 } else { rng.usize(..i) }),
                kind: if rng.f64() < 0.3 { JointKind::Prismatic } else { JointKind::Revolute },
                axis: vector(rng, 3.0),
                at: vector(rng, 0.3),
                ..Joint::default()
            }),
            contacts: vec![vector(rng, 0.2), vector(rng, 0.2)],
            ..Body::default()
        })
        .collect();
    rng.shuffle(&mut bodies);
    let mut scene = Scene { bodies, ..Scene::default() };
    scene.plant.base = base;
    scene.plant.drive_inertia = 0.07;
    scene.plant.joint_damping = 0.3;
    scene.plant.incline_deg = 12.0;
    scene.plant.payload_kg = 1.5;
    scene.plant.payload_offset = [0.05, -0.1, 0.2];
    scene.plant.payload_body = "body 5".into();
    scene
}

/// Random coordinates and rates, far from the singular pitch of virtual joints.
pub fn random_state(rng: &mut fastrand::Rng, model: &Model) -> State {
    let mut state = State::zero(model);
    state.x.iter_mut().for_each(|x| *x = 2.4 * rng.f64() - 1.2);
    state.xdot.iter_mut().for_each(|rate| *rate = 4.0 * rng.f64() - 2.0);
    if model.base == Base::Quaternion {
        let length = state.x[3..7].iter().map(|c| c * c).sum::<f64>().sqrt();
        state.x[3..7].iter_mut().for_each(|c| *c /= length);
    }
    state
}

/// Calls `claim` for `count` random states of Table 1 and of random trees on every base. Prints the seed when a claim fails.
pub fn for_each_case(seed: u64, count: usize, mut claim: impl FnMut(&mut fastrand::Rng, Case)) {
    println!("seed {seed}");
    let mut rng = fastrand::Rng::with_seed(seed);
    for base in BASES {
        for _ in 0..count {
            let tree = random_tree(&mut rng, base);
            let mut biped = Scene { plant: tree.plant.clone(), ..Scene::default() };
            biped.plant.payload_body = "left foot".into();
            for scene in [biped, tree] {
                let model = model(&scene);
                let state = random_state(&mut rng, &model);
                claim(&mut rng, Case::new(&model, &state));
            }
        }
    }
}

/// Largest difference, relative to the largest expected number.
pub fn error(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().fold(0.0_f64, |scale, value| scale.max(value.abs()));
    let error = found.iter().zip(expected).fold(0.0_f64, |error, (a, b)| error.max((a - b).abs()));
    assert!(error.is_finite());
    if error == 0.0 { 0.0 } else { error / scale }
}

#[track_caller]
pub fn close(what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    let error = error(found, expected);
    assert!(error <= tolerance, "{what} differs by {error:e} relative: {found:?} instead of {expected:?}");
}

pub fn random_efforts(rng: &mut fastrand::Rng, dofs: usize) -> DVector<f64> {
    DVector::from_fn(dofs, |_, _| 20.0 * (2.0 * rng.f64() - 1.0))
}
