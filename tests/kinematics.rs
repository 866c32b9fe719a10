//! Claims about the kinematics of controller and plant: both agree, although the controller computes in the frame of the supporting foot and
//! the plant in the world frame.

#![expect(clippy::expect_used, reason = "a test may panic")]

use controller::support::{Chain, Joints, TaskVector, mirror};
use messages::scene::{Base, Scene};
use messages::wire::JOINTS;
use nalgebra::{Matrix3, Vector3};
use plant::kinematics::{self, Pose};
use plant::model::Model;
use plant::state::State;

/// The plant's model, evaluated for the quantities of the controller.
struct PlantModel {
    scene: Scene,
    model: Model,
    state: State,
    pose: Pose,
}

impl PlantModel {
    fn new() -> PlantModel {
        let mut scene = Scene::default();
        scene.plant.base = Base::Virtual; // its six coordinates can be set freely
        let model = Model::new(&scene).expect("Table 1");
        PlantModel { state: State::zero(&model), pose: Pose::new(&model), model, scene }
    }

    /// Sets the joint angles to `q`, in wire order.
    fn set_joints(&mut self, q: &Joints) {
        let offset = self.model.coordinates() - self.model.dofs();
        for (&dof, angle) in self.model.joint_dof.iter().zip(q) {
            self.state.x[offset + dof] = *angle;
        }
        kinematics::pose(&self.model, &self.state, &mut self.pose);
    }

    fn rotation(&self, body: usize) -> Matrix3<f64> {
        self.pose.links[self.model.body_link[body]].rotation
    }

    fn sole(&self, body: usize) -> Vector3<f64> {
        let contacts = &self.scene.bodies[body].contacts;
        let sum: Vector3<f64> = contacts.iter().map(|at| Vector3::from(*at)).sum();
        self.pose.point(self.model.body_link[body], &(sum / contacts.len() as f64))
    }

    /// x of (26), in the frame of the supporting foot: axis 2 toward the swing foot.
    fn task(&self, right: bool) -> TaskVector {
        let (support, swing, side) = if right { (8, 0, 1.0) } else { (0, 8, -1.0) };
        let foot = self.rotation(support);
        let seen = |point: Vector3<f64>| {
            let local = foot.transpose() * (point - self.sole(support));
            [local.x, side * local.y, local.z]
        };
        let com = seen(kinematics::totals(&self.model, &self.state, &self.pose).com);
        // Relative to the foot, the orientation of the trunk is roll, then pitch: Rx(a) Ry(g).
        let trunk = foot.transpose() * self.rotation(4);
        let tilt = trunk[(0, 2)].atan2(trunk[(0, 0)]);
        TaskVector::from_iterator([com, seen(self.sole(swing)), [tilt, 0.0, 0.0]].concat().into_iter().take(7))
    }
}

/// Random postures at random base poses. The quantities relative to the foot must not depend on the base pose.
fn postures(count: usize, mut visit: impl FnMut(&mut PlantModel, Joints, bool)) {
    let seed = fastrand::u64(..);
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let mut within = move |bound: f64| bound * (2.0 * random.f64() - 1.0);
    let mut world = PlantModel::new();
    for i in 0..count {
        for x in &mut world.state.x[..6] {
            *x = within(1.0);
        }
        // Pitch angles add up along a leg. The limit keeps the trunk within a quarter turn of the foot.
        let support = Joints::from_fn(|_, _| within(0.5));
        visit(&mut world, support, i % 2 == 1);
    }
}

/// Joints in support order to wire order.
fn wire(support: &Joints, right: bool) -> Joints {
    if right { mirror(support) } else { *support }
}

#[test]
fn controller_and_plant_agree_on_centre_of_gravity_foot_and_trunk() {
    let chain = Chain::new(&Scene::default().bodies).expect("Table 1");
    let mut worst = 0.0_f64;
    postures(200, |world, support, right| {
        world.set_joints(&wire(&support, right));
        worst = worst.max((world.task(right) - chain.task(&support).x).amax());
    });
    println!("largest difference {worst:.1e}");
    assert!(worst < 1e-12, "{worst:e}");
}

#[test]
fn the_controllers_jacobian_is_the_derivative_of_the_plants_kinematics() {
    let chain = Chain::new(&Scene::default().bodies).expect("Table 1");
    let step = 1e-5;
    let mut worst = [0.0_f64; 2];
    postures(100, |world, support, right| {
        let jacobian = chain.task(&support).jacobian;
        for k in 0..JOINTS {
            let mut at = |sign: f64| {
                let mut moved = support;
                moved[k] += sign * step;
                world.set_joints(&wire(&moved, right));
                world.task(right)
            };
            let slope = (at(1.0) - at(-1.0)) / (2.0 * step);
            let error = (slope - jacobian.column(k)).amax();
            worst[usize::from(right)] = worst[usize::from(right)].max(error);
        }
    });
    println!("largest difference {:.1e} on the left foot, {:.1e} on the right", worst[0], worst[1]);
    assert!(worst[0] < 1e-7 && worst[1] < 1e-7, "{worst:?}");
}

/// The negative case: without mirroring, the results for the right foot are wrong.
#[test]
fn without_mirroring_the_kinematics_of_the_right_foot_would_be_wrong() {
    let chain = Chain::new(&Scene::default().bodies).expect("Table 1");
    let mut least = f64::INFINITY;
    postures(20, |world, support, _| {
        world.set_joints(&support);
        least = least.min((world.task(true) - chain.task(&support).x).amax());
    });
    assert!(least > 1e-3, "{least:e}");
}
