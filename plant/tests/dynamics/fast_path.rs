//! The fast path equals the paper's recursion, and the sparse factor is a factor of H.

use crate::support::*;
use biped_plant::PlantError;
use biped_plant::dynamics::{self, Force};
use biped_plant::factor::{Factor, PathMatrix};
use biped_plant::kinematics::contact_column;
use biped_plant::spatial::{Inertia, Spatial, Symmetric};
use biped_plant::state::State;
use messages::scene::Base;
use nalgebra::{DMatrix, DVector, Vector3};

#[test]
fn composite_bodies_give_the_inertia_of_unit_accelerations() {
    for_each_case(1, 20, |_, case| {
        let reference = dynamics::inertia(&case.model, &case.pose);
        close("H", case.inertia().as_slice(), reference.as_slice(), 1e-12);
    });
}

#[test]
fn columns_of_an_inertia_are_its_products_with_unit_motions_to_the_bit() {
    let unit = |k: usize, first: usize| Vector3::from_fn(|row, _| f64::from(first + row == k));
    let bits = |wrench: Spatial| [wrench.angular, wrench.linear].map(|part| part.data.0[0].map(f64::to_bits));
    for signs in 0..4_usize.pow(6) {
        let number = |k: u32| [0.7, -0.3, 0.0, -0.0][signs / 4_usize.pow(k) % 4];
        let first = Vector3::new(number(0), number(1), number(2));
        let second = Symmetric([1.5, 2.0, 1.25, number(3), number(4), number(5)]);
        let inertia = Inertia { mass: 3.0, first, second };
        for (k, column) in inertia.columns().into_iter().enumerate() {
            let motion = Spatial { linear: unit(k, 0), angular: unit(k, 3) };
            assert_eq!(bits(column), bits(inertia.times(&motion)), "{k} of {inertia:?}");
        }
    }
}

#[test]
fn one_recursion_gives_the_bias_of_zero_acceleration() {
    for_each_case(2, 20, |_, case| {
        let reference = dynamics::bias(&case.model, &case.pose, &case.state.xdot);
        close("b", &case.b, &reference, 1e-12);
    });
}

#[test]
fn jacobian_columns_are_the_contact_map_of_unit_forces() {
    for_each_case(3, 10, |rng, case| {
        for point in &case.model.contact_points {
            let (arm, force) = (case.pose.arm(point.link, &point.at), vector(rng, 1.0).into());
            let mut column = vec![0.0; case.model.depth(point.link)];
            contact_column(&case.model, &case.pose, point.link, &arm, &force, &mut column);
            let mut full = vec![0.0; case.model.dofs()];
            column.iter().zip(case.model.path(point.link)).for_each(|(k, &dof)| full[dof] = *k);
            let reference = dynamics::contact_column(&case.model, &case.pose, Force { link: point.link, arm, force });
            let scale = reference.iter().fold(1.0_f64, |scale, k| scale.max(k.abs()));
            for (fast, reference) in full.iter().zip(&reference) {
                assert!((fast - reference).abs() <= 1e-12 * scale, "{full:?} instead of {reference:?}");
            }
        }
    });
}

#[test]
fn the_sparse_factor_gives_the_solution_of_a_dense_one() {
    for_each_case(4, 10, |rng, case| {
        let u = random_efforts(rng, case.model.dofs());
        let dense = case.inertia().cholesky().expect("a positive H").solve(&u);
        let error = (case.inertia() * DVector::from_vec(case.solve(u.as_slice())) - &u).amax() / u.amax();
        assert!(error < 1e-11, "residual {error:e}");
        close("H⁻¹u", &case.solve(u.as_slice()), dense.as_slice(), 1e-9);
    });
}

#[test]
fn half_solved_columns_give_the_delassus_matrix() {
    for_each_case(5, 5, |_, case| {
        let model = &case.model;
        let factor = Factor::of(model, &case.h).expect("a positive H");
        let corners = &model.contact_points;
        let jacobians: Vec<DMatrix<f64>> = corners.iter().map(|point| case.jacobian(point.link, &point.at)).collect();
        let half = |c: usize, axis: usize| {
            let column = model.path(corners[c].link).iter().map(|&dof| jacobians[c][(axis, dof)]);
            let mut y: Vec<_> = column.map(|k| [k]).collect();
            factor.half_solve(model, corners[c].link, &mut y);
            y.iter().map(|row| row[0]).collect::<Vec<f64>>()
        };
        let cholesky = case.inertia().cholesky().expect("a positive H");
        for (a, b) in [(0, 0), (0, 1), (0, 4), (3, 7), (5, 2)] {
            let dense = &jacobians[a] * cholesky.solve(&jacobians[b].transpose());
            let shared = model.shared(corners[a].link, corners[b].link);
            let sparse = DMatrix::from_fn(3, 3, |i, j| {
                half(a, i)[..shared].iter().zip(&half(b, j)[..shared]).map(|(y, z)| y * z).sum::<f64>()
            });
            let error = (&sparse - &dense).amax() / cholesky.inverse().amax();
            assert!(error < 1e-11, "{sparse} instead of {dense}");
        }
    });
}

#[test]
fn an_indefinite_inertia_is_refused_and_named() {
    let model = model(&bare_table_1(Base::Quaternion));
    let case = Case::new(&model, &State::zero(&model));
    for bad in [-1.0, 0.0, f64::NAN] {
        let mut h: PathMatrix = case.h.clone();
        h.row_mut(7)[7] = bad;
        let error = Factor::new(&model).factorize(&model, &h).expect_err("not positive definite");
        assert!(matches!(error, PlantError::Singular { dof: 7, .. }), "{error}");
    }
}

#[test]
fn different_branches_share_only_the_base() {
    let model = model(&bare_table_1(Base::Virtual));
    let feet =
        [model.link_of("left foot", "test"), model.link_of("right foot", "test")].map(|link| link.expect("a foot"));
    assert_eq!(model.shared(feet[0], feet[1]), 6);
    assert_eq!(model.path(feet[0]), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
    assert_eq!(model.path(feet[1]), [0, 1, 2, 3, 4, 5, 10, 11, 12, 13]);
}
