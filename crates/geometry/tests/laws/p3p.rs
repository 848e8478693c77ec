//! Known answers for the minimal pose solver.

use crate::support::{generator, motion_error, random_motion, random_visible_point};
use dsslam_geometry::{SE3, Vec3, p3p};

struct Case {
    cam_from_world: SE3,
    rays: [Vec3; 3],
    points_world: [Vec3; 3],
}

fn case(seed: u64) -> Case {
    let mut rng = generator(seed);
    let cam_from_world = random_motion(&mut rng, 20.0, 3.1);
    let points_cam: [Vec3; 3] = std::array::from_fn(|_| random_visible_point(&mut rng));
    Case {
        cam_from_world,
        rays: points_cam.map(|p| p * (1.0 / p.z)),
        points_world: points_cam.map(|p| cam_from_world.inverse() * p),
    }
}

/// Errors of the solution nearest to the truth: radians, meters.
fn nearest(case: &Case, solutions: &[SE3]) -> Option<(f64, f64)> {
    let errors = solutions.iter().map(|s| motion_error(s, &case.cam_from_world));
    errors.min_by(|a, b| (a.0 + a.1).total_cmp(&(b.0 + b.1)))
}

#[test]
fn the_true_pose_is_among_the_solutions_of_ten_thousand_exact_cases() {
    let mut n_exact = 0;
    let mut n_close = 0;
    for seed in 0..10_000 {
        let case = case(seed);
        let solutions = p3p(&case.rays, &case.points_world);
        assert!(solutions.len() <= 4);
        let (angle, distance) = nearest(&case, &solutions).unwrap_or((f64::INFINITY, f64::INFINITY));
        n_exact += usize::from(angle < 1e-9 && distance < 1e-8);
        n_close += usize::from(angle < 1e-5 && distance < 1e-4);
    }
    // The rest are nearly double roots, where the answer itself is ill-conditioned.
    assert!(n_exact >= 9_998, "{n_exact}");
    assert_eq!(n_close, 10_000);
}

#[test]
fn every_solution_sees_the_points_along_the_rays_and_is_a_motion() {
    for seed in 0..2_000 {
        let case = case(seed);
        for solution in p3p(&case.rays, &case.points_world) {
            let rotation = solution.rotation.matrix();
            assert!((rotation.transpose() * rotation - dsslam_geometry::Mat3::identity()).amax() < 1e-13);
            assert!((rotation.determinant() - 1.0).abs() < 1e-13);
            for (ray, point) in case.rays.iter().zip(&case.points_world) {
                let seen = (solution * point).normalize();
                assert!((seen - ray.normalize()).norm() < 1e-8, "seed {seed}");
            }
        }
    }
}

#[test]
fn solutions_are_distinct() {
    for seed in 0..2_000 {
        let case = case(seed);
        let solutions = p3p(&case.rays, &case.points_world);
        for (i, a) in solutions.iter().enumerate() {
            for b in &solutions[..i] {
                let (angle, distance) = motion_error(a, b);
                assert!(angle + distance > 1e-7, "seed {seed}");
            }
        }
    }
}

#[test]
fn moving_the_world_moves_every_solution() {
    for seed in 0..200 {
        let case = case(seed);
        let world_from_moved = random_motion(&mut generator(seed + 77), 10.0, 3.0);
        let moved = case.points_world.map(|p| world_from_moved.inverse() * p);
        let expected: Vec<_> =
            p3p(&case.rays, &case.points_world).iter().map(|s| s * world_from_moved).collect();
        let found = p3p(&case.rays, &moved);
        assert_eq!(found.len(), expected.len());
        for s in &found {
            let error =
                expected.iter().map(|e| motion_error(s, e)).map(|(a, d)| a + d).fold(f64::INFINITY, f64::min);
            assert!(error < 1e-6, "seed {seed}: {error:e}");
        }
    }
}

#[test]
fn the_symmetric_case_has_its_answer() {
    // An equilateral triangle seen straight from above its center, 2 m away.
    let corner = |k: f64| Vec3::new((k * 2.0944).cos(), (k * 2.0944).sin(), 0.0);
    let points_world = [corner(0.0), corner(1.0), corner(2.0)];
    let rays = points_world.map(|p| p + Vec3::new(0.0, 0.0, 2.0));
    let truth = SE3::new(dsslam_geometry::SO3::identity(), Vec3::new(0.0, 0.0, 2.0));
    let solutions = p3p(&rays, &points_world);
    assert!(solutions.iter().any(|s| (s.matrix() - truth.matrix()).amax() < 1e-9), "{solutions:?}");
}

#[test]
fn degenerate_input_has_no_solution() {
    let rays = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(0.1, 0.0, 1.0), Vec3::new(0.0, 0.1, 1.0)];
    let line = [Vec3::x(), Vec3::x() * 2.0, Vec3::x() * 3.0];
    assert!(p3p(&rays, &line).is_empty());
    assert!(p3p(&rays, &[Vec3::x(); 3]).is_empty());
    assert!(p3p(&[Vec3::z(); 3], &[Vec3::x(), Vec3::y(), Vec3::z()]).is_empty());
    assert!(p3p(&[Vec3::zeros(); 3], &[Vec3::x(), Vec3::y(), Vec3::z()]).is_empty());
    assert!(p3p(&rays, &[Vec3::x(), Vec3::y(), Vec3::new(f64::NAN, 0.0, 0.0)]).is_empty());
}
