//! Construction of models from scenes, and the errors of bad scenes.

use crate::support::*;
use biped_plant::kinematics::totals;
use biped_plant::model::Model;
use biped_plant::state::State;
use messages::robot::Joint;
use messages::scene::{Base, Scene};
use nalgebra::{Matrix3, Vector3};

fn refused(change: impl Fn(&mut Scene), words: &[&str]) {
    let mut scene = Scene::default();
    change(&mut scene);
    let error = match Model::new(&scene) {
        Ok(model) => State::initial(&model, &scene.initial).err(),
        Err(error) => Some(error),
    };
    let message = error.expect("a bad scene").to_string();
    for word in words {
        assert!(message.contains(word), "{message:?} does not say {word:?}");
    }
}

fn joint(scene: &mut Scene, body: usize) -> &mut Joint {
    scene.bodies[body].joint.as_mut().expect("a body with a joint")
}

#[test]
fn every_bad_scene_is_refused_by_name() {
    refused(|scene| scene.bodies[0].name = "trunk".into(), &["two bodies", "`trunk`"]);
    refused(|scene| joint(scene, 0).parent = "tail".into(), &["`left foot`", "`tail`", "left shank"]);
    refused(|scene| scene.bodies[0].joint = None, &["exactly one", "2", "left foot", "trunk"]);
    refused(|scene| scene.bodies.clear(), &["exactly one", "0"]);
    refused(|scene| joint(scene, 3).parent = "left foot".into(), &["circle", "left"]);
    refused(|scene| joint(scene, 2).axis = [0.0; 3], &["axis", "`left shank`", "not zero"]);
    refused(|scene| joint(scene, 2).axis = [f64::NAN; 3], &["axis", "`left shank`"]);
    refused(|scene| joint(scene, 2).at = [f64::INFINITY; 3], &["joint", "`left shank`", "finite"]);
    refused(|scene| scene.bodies[1].mass = -0.5, &["mass", "`left ankle`", "-0.5", "greater than 0"]);
    refused(|scene| scene.bodies[1].mass = f64::NAN, &["mass", "NaN"]);
    refused(|scene| scene.bodies[1].inertia = Some([1.0, 0.0, 1.0]), &["inertia", "`left ankle`"]);
    refused(|scene| scene.bodies[1].com[2] = f64::NAN, &["centre of mass", "`left ankle`"]);
    refused(|scene| scene.bodies[0].contacts[2][1] = f64::NAN, &["contact point", "`left foot`"]);
    refused(|scene| scene.plant.payload_kg = -1.0, &["payload", "not negative"]);
    refused(|scene| scene.plant.payload_body = "head".into(), &["payload", "`head`", "trunk"]);
    refused(|scene| scene.plant.gravity = f64::NAN, &["gravity"]);
    refused(|scene| scene.initial.joints = vec![0.0; 7], &["initial.joints", "8"]);
    refused(|scene| scene.initial.joint_rates = vec![f64::NAN; 8], &["initial.joint_rates", "finite"]);
    refused(|scene| scene.initial.position[1] = f64::NAN, &["position"]);
    let virtually = |scene: &mut Scene| scene.plant.base = Base::Virtual;
    refused(|scene| (virtually(scene), scene.initial.orientation_deg[1] = 90.0).1, &["orientation", "pitch"]);
    let planar = |scene: &mut Scene| scene.plant.base = Base::Planar;
    refused(|scene| (planar(scene), scene.initial.orientation_deg[0] = 5.0).1, &["orientation", "roll"]);
    refused(|scene| (planar(scene), scene.initial.velocity[1] = 1.0).1, &["initial.velocity", "planar"]);
    refused(|scene| (planar(scene), scene.initial.angular_velocity[2] = 1.0).1, &["angular_velocity", "planar"]);
    let fixed = |scene: &mut Scene| scene.plant.base = Base::Fixed;
    refused(|scene| (fixed(scene), scene.initial.velocity[0] = 1.0).1, &["initial.velocity", "fixed"]);
    let floating = |scene: &mut Scene| scene.bodies.iter_mut().for_each(|body| body.contacts.clear());
    refused(|scene| (floating(scene), scene.initial.clearance = Some(0.1)).1, &["clearance", "contact points"]);
}

#[test]
fn the_initial_state_has_the_scenes_pose_and_velocity_in_the_world() {
    for base in [Base::Virtual, Base::Quaternion] {
        let mut scene = bare_table_1(base);
        let initial = &mut scene.initial;
        initial.position = [1.0, -2.0, 3.0];
        initial.orientation_deg = [20.0, -40.0, 130.0];
        initial.velocity = [0.1, 0.2, -0.3];
        initial.angular_velocity = [1.0, -2.0, 0.5];
        let model = model(&scene);
        let case = Case::new(&model, &State::initial(&model, &scene.initial).expect("a good state"));
        let turn = |axis: [f64; 3], degrees: f64| {
            nalgebra::Rotation3::from_scaled_axis(Vector3::from(axis) * degrees.to_radians()).into_inner()
        };
        let expected: Matrix3<f64> =
            turn([0.0, 0.0, 1.0], 130.0) * turn([0.0, 1.0, 0.0], -40.0) * turn([1.0, 0.0, 0.0], 20.0);
        let found = &case.pose.links[model.base_link];
        assert!((found.rotation - expected).amax() < 1e-14);
        let origin = Vector3::zeros();
        close("position", case.pose.point(model.base_link, &origin).as_slice(), &[1.0, -2.0, 3.0], 1e-15);
        close("velocity", case.pose.point_velocity(model.base_link, &origin).as_slice(), &[0.1, 0.2, -0.3], 1e-14);
        close("spin", found.velocity.angular.as_slice(), &[1.0, -2.0, 0.5], 1e-14);
        let q = case.pose.orientation(model.base_link);
        assert!((q.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-14 && q[0] >= 0.0);
    }
}

#[test]
fn clearance_is_the_height_of_the_lowest_contact_point_on_every_base() {
    for base in BASES {
        let mut scene = bare_table_1(base);
        scene.initial.clearance = Some(0.02);
        scene.initial.position = [1.0, 0.0, -7.0];
        scene.initial.orientation_deg[1] = 15.0;
        scene.initial.joints = vec![0.3, 0.2, -1.0, 0.5, 0.1, 0.4, -0.2, -0.6];
        let model = model(&scene);
        let case = Case::new(&model, &State::initial(&model, &scene.initial).expect("a good state"));
        let heights = model.contact_points.iter().map(|point| case.pose.point(point.link, &point.at).z);
        let lowest = heights.fold(f64::INFINITY, f64::min);
        assert!((lowest - 0.02).abs() < 1e-14, "{base:?}: {lowest}");
    }
}

#[test]
fn joints_keep_the_order_of_the_list_in_any_sorting() {
    let scene = bare_table_1(Base::Quaternion);
    let mut reversed = scene.clone();
    reversed.bodies.reverse();
    let angles: Vec<f64> = (0..8).map(|k| 0.1 * (k + 1) as f64).collect();
    let case = |scene: &Scene, joints: Vec<f64>| {
        let mut initial = scene.initial.clone();
        initial.joint_rates = joints.iter().map(|q| 2.0 * q).collect();
        initial.joints = joints;
        let model = model(scene);
        let state = State::initial(&model, &initial).expect("a good state");
        assert_eq!((0..8).map(|k| state.joint(&model, k)).collect::<Vec<_>>(), initial.joints);
        assert_eq!((0..8).map(|k| state.joint_rate(&model, k)).collect::<Vec<_>>(), initial.joint_rates);
        let case = Case::new(&model, &state);
        let sum = totals(&model, &state, &case.pose);
        let foot = model.link_of("right foot", "test").expect("a foot");
        let sole = case.pose.point(foot, &Vector3::new(0.0, 0.0, -0.05));
        let mut torques = vec![0.0; 14];
        model.joint_dof.iter().enumerate().for_each(|(k, &dof)| torques[dof] = state.joint(&model, k));
        let acceleration = case.forward(&torques);
        let joints: Vec<f64> = model.joint_dof.iter().map(|&dof| acceleration[dof]).collect();
        (sole, sum.kinetic, joints)
    };
    let forward = case(&scene, angles.clone());
    let mut backward = case(&reversed, angles.into_iter().rev().collect());
    backward.2.reverse();
    close("sole", forward.0.as_slice(), backward.0.as_slice(), 1e-14);
    close("energy", &[forward.1], &[backward.1], 1e-14);
    close("accelerations", &forward.2, &backward.2, 1e-11);
}

#[test]
fn a_payload_is_a_point_mass_of_its_body() {
    let mut scene = bare_table_1(Base::Quaternion);
    let bare = model(&scene);
    scene.plant.payload_kg = 2.0;
    scene.plant.payload_offset = [0.1, -0.05, 0.2];
    scene.plant.payload_body = "left thigh".into();
    let loaded = model(&scene);
    let state = random_state(&mut fastrand::Rng::with_seed(31), &bare);
    let (bare, loaded) = (Case::new(&bare, &state), Case::new(&loaded, &state));
    let thigh = loaded.model.link_of("left thigh", "test").expect("a thigh");
    let jacobian = bare.jacobian(thigh, &Vector3::new(0.1, -0.05, 0.2));
    let expected = bare.inertia() + jacobian.transpose() * jacobian * 2.0;
    close("H with payload", loaded.inertia().as_slice(), expected.as_slice(), 1e-13);
}

#[test]
fn downhill_is_positive_x() {
    let mut scene = bare_table_1(Base::Quaternion);
    scene.plant.incline_deg = 30.0;
    close("gravity", model(&scene).gravity.as_slice(), &[4.905, 0.0, -9.81 * 0.75_f64.sqrt()], 1e-15);
}

#[test]
fn a_joint_axis_may_have_any_length() {
    let mut scene = bare_table_1(Base::Quaternion);
    let unit = model(&scene);
    joint(&mut scene, 2).axis = [0.0, -7.0, 0.0];
    let state = random_state(&mut fastrand::Rng::with_seed(32), &unit);
    assert_eq!(Case::new(&unit, &state).b, Case::new(&model(&scene), &state).b);
}

#[test]
fn a_robot_may_have_one_body() {
    for base in BASES {
        let mut scene = bare_table_1(base);
        scene.bodies = vec![scene.bodies[4].clone()];
        let model = model(&scene);
        let case = Case::new(&model, &State::zero(&model));
        let falling = case.forward(&vec![0.0; model.dofs()]);
        let expected: &[f64] = match base {
            Base::Fixed => &[],
            Base::Planar => &[0.0, -9.81, 0.0],
            Base::Virtual | Base::Quaternion => &[0.0, 0.0, -9.81, 0.0, 0.0, 0.0],
        };
        assert!(falling.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-14), "{falling:?}");
        assert_eq!(falling.len(), expected.len());
    }
}
