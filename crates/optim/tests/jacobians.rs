//! Analytic normal equations of the rig against numeric Jacobians of its projection.

#![allow(clippy::needless_range_loop)]

mod common;

use common::{random, residual, rig, small_motion};
use dsslam_optim::{
    BundleObservation, CHI2_MONO, CHI2_STEREO, Loss, ObservationModel, RigCamera, RigModel, RigObservation,
};
use geometry::{SE3, Vec2, Vec3, Vec6};

const STEP: f64 = 1e-6;

/// Columns of the numeric Jacobian: six of the pose, three of the point.
fn numeric(cam_from_world: &SE3, point: &Vec3, o: &BundleObservation) -> [Vec3; 9] {
    std::array::from_fn(|k| {
        let at = |step: f64| {
            let (mut motion, mut moved) = (Vec6::zeros(), *point);
            match k {
                0..6 => motion[k] = step,
                _ => moved[k - 6] += step,
            }
            residual(&rig(), &(SE3::exp(&motion) * *cam_from_world), &moved, o)
        };
        (at(STEP) - at(-STEP)) / (2.0 * STEP)
    })
}

#[test]
fn every_block_equals_the_numeric_one() {
    let model = RigModel::new(&rig());
    for seed in 0..40 {
        let mut random = random(seed);
        let cam_from_world = small_motion(&mut random, 3.0, 0.8);
        let point_cam = Vec3::new(1.5, -0.7, 8.0) + common::normal_vec3(&mut random, 1.0);
        let point = cam_from_world.inverse() * point_cam;
        let projection = rig().project(&point_cam);
        let (is_mono, is_far_off) = (seed % 2 == 0, seed % 4 < 2);
        let o = BundleObservation {
            camera: 0,
            point: 0,
            pixel: Vec2::new(projection.x + if is_far_off { 20.0 } else { 0.3 }, projection.y - 0.4),
            right_u: if is_mono { f64::NAN } else { projection.z + 0.2 },
            inv_sigma_sq: 0.7,
        };
        let observation = RigObservation::new(o.pixel.x, o.pixel.y, o.right_u, o.inv_sigma_sq);
        let lin = model
            .linearize(&RigCamera::new(cam_from_world), &point.into(), &observation, Loss::Huber)
            .expect("in front of the camera");

        let r = residual(&rig(), &cam_from_world, &point, &o);
        let columns = numeric(&cam_from_world, &point, &o);
        let delta_sq = if is_mono { CHI2_MONO } else { CHI2_STEREO };
        let weight = Loss::Huber.weight(r.norm_squared(), delta_sq);
        assert_eq!(weight < 1.0, is_far_off);
        let check = |analytic: f64, i: usize, b: &Vec3, what: &str| {
            let expected = weight * columns[i].dot(b);
            let scale = weight * columns[i].norm() * b.norm();
            assert!((analytic - expected).abs() < 1e-7 * scale, "{what} {i}: {analytic} {expected}");
        };
        for i in 0..6 {
            for j in 0..=i {
                check(lin.camera_camera[i][j], i, &columns[j], "camera");
            }
            for j in 0..3 {
                check(lin.point_camera[j][i], i, &columns[6 + j], "camera-point");
            }
            check(lin.camera_gradient[i], i, &r, "camera gradient");
        }
        for i in 0..3 {
            for j in 0..=i {
                check(lin.point_point[i * (i + 1) / 2 + j], 6 + i, &columns[6 + j], "point");
            }
            check(lin.point_gradient[i], 6 + i, &r, "point gradient");
        }
    }
}

#[test]
fn a_point_behind_the_camera_has_no_blocks() {
    let model = RigModel::new(&rig());
    let camera = RigCamera::new(SE3::identity());
    let observation = RigObservation::new(600.0, 180.0, f64::NAN, 1.0);
    for point in [[0.0, 0.0, -5.0], [1.0, 1.0, 0.0], [0.0, 0.0, f64::NAN], [f64::INFINITY, 0.0, 1.0]] {
        assert!(model.chi_sq(&camera, &point, &observation).is_none(), "{point:?}");
        assert!(model.linearize(&camera, &point, &observation, Loss::Squared).is_none(), "{point:?}");
    }
}
