//! Points from several views.

use crate::assert_close;
use crate::support::{generator, random_motion, random_visible_point};
use dsslam_geometry::{SE3, SO3, Vec2, Vec3, angle_between, triangulate, triangulate_dlt};
use rand::Rng;

struct Scene {
    point: Vec3,
    cams_from_world: Vec<SE3>,
    normalized: Vec<Vec2>,
}

/// Views of one point, all in front; noise is in normalized units.
fn scene(seed: u64, n_views: usize, noise: f64) -> Scene {
    let mut rng = generator(seed);
    let point = random_visible_point(&mut rng);
    let mut cams_from_world = vec![SE3::identity()];
    while cams_from_world.len() < n_views {
        let cam = random_motion(&mut rng, 1.0, 0.3);
        if (cam * point).z > 0.5 && cam.center().norm() > 0.3 {
            cams_from_world.push(cam);
        }
    }
    let see = |cam: &SE3| {
        let p = cam * point;
        p.xy() / p.z + Vec2::from_fn(|_, _| rng.random_range(-1.0..1.0)) * noise
    };
    let normalized = cams_from_world.iter().map(see).collect();
    Scene { point, cams_from_world, normalized }
}

#[test]
fn exact_views_give_the_point() {
    for seed in 0..500 {
        let s = scene(seed, 2 + (seed as usize % 5), 0.0);
        let found = triangulate(&s.cams_from_world, &s.normalized).unwrap();
        assert!((found - s.point).norm() < 1e-8 * s.point.norm(), "seed {seed}: {found} {}", s.point);
    }
}

#[test]
fn the_point_moves_along_with_the_world() {
    for seed in 0..100 {
        let s = scene(seed, 2 + (seed as usize % 3), 1e-4);
        let moved_from_world = random_motion(&mut generator(seed + 1000), 5000.0, 3.0);
        let cams: Vec<_> = s.cams_from_world.iter().map(|cam| cam * moved_from_world.inverse()).collect();
        let (Some(there), Some(here)) =
            (triangulate_dlt(&cams, &s.normalized), triangulate_dlt(&s.cams_from_world, &s.normalized))
        else {
            panic!("seed {seed}: no point");
        };
        assert_close!(there, moved_from_world * here, 1e-6 * here.norm().max(1.0));
    }
}

#[test]
fn more_noisy_views_come_nearer_on_average() {
    let error = |n_views| -> f64 {
        let distance = |seed| {
            let s = scene(seed, n_views, 5e-4);
            (triangulate_dlt(&s.cams_from_world, &s.normalized).unwrap() - s.point).norm() / s.point.norm()
        };
        (0..100).map(distance).sum()
    };
    assert!(error(10) < 0.5 * error(2));
}

#[test]
fn a_point_behind_a_camera_is_refused_by_cheirality_only() {
    let turned = SE3::new(SO3::exp(&Vec3::new(0.0, std::f64::consts::PI, 0.0)), Vec3::new(1.0, 0.0, 0.0));
    let point = Vec3::new(0.2, 0.1, 5.0);
    let cams = [SE3::identity(), turned];
    let normalized = cams.map(|cam| (cam * point).xy() / (cam * point).z);
    assert!(triangulate(&cams, &normalized).is_none());
    assert_close!(triangulate_dlt(&cams, &normalized).unwrap(), point, 1e-10);
}

#[test]
fn views_that_determine_nothing_are_refused() {
    let side = SE3::new(SO3::identity(), Vec3::new(-1.0, 0.0, 0.0));
    let straight = Vec2::zeros();
    assert!(triangulate_dlt(&[SE3::identity()], &[straight]).is_none(), "one view");
    assert!(triangulate_dlt(&[SE3::identity(); 2], &[straight; 2]).is_none(), "no baseline");
    assert!(triangulate_dlt(&[SE3::identity(), side], &[straight; 2]).is_none(), "parallel rays");
    assert!(triangulate_dlt(&[SE3::identity(), side], &[straight]).is_none(), "lengths");
    let lost = Vec2::new(f64::NAN, 0.0);
    assert!(triangulate_dlt(&[SE3::identity(), side], &[lost, straight]).is_none(), "not a number");
}

#[test]
fn parallax_is_the_angle_at_the_point() {
    let point = Vec3::new(0.0, 0.0, 1.0);
    let expected = 2.0 * 0.5_f64.atan();
    let to = |center: Vec3| center - point;
    let found = angle_between(&to(Vec3::new(-0.5, 0.0, 0.0)), &to(Vec3::new(0.5, 0.0, 0.0)));
    assert!((found - expected).abs() < 1e-15);
    let tiny = angle_between(&Vec3::z(), &Vec3::new(1e-12, 0.0, 1.0));
    assert!((tiny - 1e-12).abs() < 1e-26);
}
