//! Bundles that determine little or nothing: no panic, no NaN, no step where nothing is known.

mod common;

use common::{StreetOptions, displaced, rig, street};
use dsslam_optim::{
    BundleObservation, BundleOptions, BundleProblem, BundleSolution, StopReason, refine_bundle,
};
use geometry::{SE3, Vec2, Vec3};
use proptest::prelude::*;

const SMALL: StreetOptions =
    StreetOptions { seed: 30, cameras: 5, points: 80, max_track: 4, noise_px: 0.5, mono_share: 0.3 };

fn solve(problem: &BundleProblem) -> BundleSolution {
    let solution = refine_bundle(problem, &BundleOptions { max_iterations: 30, ..Default::default() });
    assert!(solution.cameras.iter().all(SE3::is_finite), "a pose is not finite");
    assert!(solution.points.iter().all(|p| p.iter().all(|v| v.is_finite())), "a point is not finite");
    assert!(solution.report.final_cost <= solution.report.initial_cost, "{:?}", solution.report);
    assert_eq!(solution.chi_sq.len(), problem.observations.len());
    solution
}

fn observe(camera: u32, point: u32, u: f64, v: f64, right_u: f64) -> BundleObservation {
    BundleObservation { camera, point, pixel: Vec2::new(u, v), right_u, inv_sigma_sq: 1.0 }
}

#[test]
fn nothing_at_all() {
    let empty =
        BundleProblem { rig: rig(), cameras: vec![], fixed: vec![], points: vec![], observations: vec![] };
    let solution = solve(&empty);
    assert_eq!(solution.report.stop, StopReason::NoData);
    assert_eq!((solution.report.iterations, solution.report.final_cost), (0, 0.0));
}

#[test]
fn nothing_observed_leaves_all_in_place() {
    let mut problem = street(&SMALL);
    problem.observations.clear();
    let solution = solve(&problem);
    assert_eq!(solution.report.stop, StopReason::NoData);
    assert_eq!((solution.cameras, solution.points), (problem.cameras, problem.points));
}

#[test]
fn no_free_camera_still_moves_the_points() {
    let mut truth = street(&StreetOptions { noise_px: 0.0, mono_share: 0.0, ..SMALL });
    truth.fixed.fill(true);
    let solution = solve(&displaced(&truth, 31, 0.0, 0.0, 0.3));
    assert_eq!(solution.cameras, truth.cameras);
    for (solved, expected) in solution.points.iter().zip(&truth.points) {
        assert!((solved - expected).norm() < 1e-3, "{solved} {expected}");
    }
}

#[test]
fn no_fixed_camera_still_fits() {
    let truth = street(&StreetOptions { noise_px: 0.0, ..SMALL });
    let solution = solve(&displaced(&truth, 32, 0.05, 0.005, 0.2));
    assert!(solution.report.final_cost < 1e-6, "{:?}", solution.report);
}

#[test]
fn monocular_without_any_anchor_still_fits() {
    let truth = street(&StreetOptions { noise_px: 0.0, mono_share: 1.0, ..SMALL });
    let solution = solve(&displaced(&truth, 33, 0.02, 0.002, 0.1));
    assert!(solution.report.final_cost < 1e-6, "{:?}", solution.report);
}

#[test]
fn unobserved_cameras_and_points_stay() {
    let mut problem = displaced(&street(&SMALL), 34, 0.02, 0.002, 0.1);
    problem.fixed[0] = true;
    problem.observations.retain(|o| o.camera != 3 && o.point != 7);
    let solution = solve(&problem);
    assert!(common::pose_difference(&solution.cameras[3], &problem.cameras[3]).0 < 1e-12);
    assert_eq!(solution.points[7], problem.points[7]);
    assert_ne!(solution.points[8], problem.points[8]);
}

#[test]
fn one_monocular_ray_is_met_near_where_the_point_was() {
    let point = Vec3::new(1.0, 0.5, 10.0);
    let pixel = rig().camera.project(&point);
    let problem = BundleProblem {
        rig: rig(),
        cameras: vec![SE3::identity()],
        fixed: vec![true],
        points: vec![point],
        observations: vec![observe(0, 0, pixel.x + 4.0, pixel.y, f64::NAN)],
    };
    let solution = solve(&problem);
    assert!(solution.chi_sq[0] < 1e-9, "{:?}", solution.report);
    assert!((solution.points[0] - point).norm() < 0.5, "{}", solution.points[0]);
}

#[test]
fn points_behind_a_camera_are_told_and_pull_nothing() {
    let mut truth = street(&StreetOptions { noise_px: 0.0, ..SMALL });
    truth.fixed[0] = true;
    truth.points.push(truth.cameras[2].inverse() * Vec3::new(0.0, 0.0, -3.0));
    truth.points.push(truth.cameras[2].center());
    let (n, point) = (truth.observations.len(), truth.points.len() as u32 - 2);
    truth.observations.push(observe(2, point, 600.0, 200.0, 590.0));
    truth.observations.push(observe(2, point + 1, 600.0, 200.0, 590.0));
    let mut problem = displaced(&truth, 35, 0.02, 0.002, 0.1);
    problem.points[point as usize..].copy_from_slice(&truth.points[point as usize..]);
    problem.cameras[2] = truth.cameras[2];
    let solution = solve(&problem);
    assert!(!solution.inliers[n], "3 m behind the camera");
    assert!(solution.inliers[..n].iter().all(|&inlier| inlier));
    assert_eq!(solution.chi_sq[n..], [1e6, 1e6]);
    assert_eq!(solution.points[point as usize..], truth.points[point as usize..]);
    assert!(solution.chi_sq[..n].iter().all(|&c| c < 1e-6), "the others are disturbed");
}

#[test]
fn an_observation_given_twice_counts_twice() {
    let problem = displaced(&street(&SMALL), 36, 0.02, 0.002, 0.1);
    let (mut doubled, mut weighted) = (problem.clone(), problem);
    doubled.fixed[0] = true;
    weighted.fixed[0] = true;
    doubled.observations.extend_from_within(..);
    weighted.observations.iter_mut().for_each(|o| o.inv_sigma_sq *= 2.0);
    let options = BundleOptions { huber: None, ..Default::default() };
    let (a, b) = (refine_bundle(&doubled, &options), refine_bundle(&weighted, &options));
    assert!((a.report.final_cost / b.report.final_cost - 1.0).abs() < 1e-12);
    for (a, b) in a.cameras.iter().zip(&b.cameras) {
        assert!(common::pose_difference(a, b).0 < 1e-9);
    }
}

#[test]
fn measurements_that_are_not_finite_are_ignored() {
    let mut problem = displaced(&street(&SMALL), 37, 0.02, 0.002, 0.1);
    problem.fixed[0] = true;
    let mut without = problem.clone();
    let bad = [3, 50, 90];
    problem.observations[3].pixel.x = f64::NAN;
    problem.observations[50].right_u = f64::INFINITY;
    problem.observations[90].inv_sigma_sq = f64::NAN;
    let mut index = 0..;
    without.observations.retain(|_| !bad.contains(&index.next().unwrap()));
    let (a, b) = (solve(&problem), solve(&without));
    assert_eq!(a.cameras, b.cameras);
    assert_eq!(a.points, b.points);
}

#[test]
#[should_panic(expected = "names a camera or point that does not exist")]
fn an_unknown_camera_is_refused() {
    let mut problem = street(&SMALL);
    problem.observations[0].camera = 5;
    solve(&problem);
}

#[test]
#[should_panic(expected = "one `fixed` flag per camera")]
fn a_missing_flag_is_refused() {
    let mut problem = street(&SMALL);
    problem.fixed.pop();
    solve(&problem);
}

fn any_problem() -> impl Strategy<Value = BundleProblem> {
    let scale = prop_oneof![Just(1e-9), Just(1.0), Just(1e6)];
    let point = (scale, prop::array::uniform3(-1.0..1.0f64)).prop_map(|(s, p)| Vec3::from(p) * s);
    let cameras = prop::collection::vec((prop::array::uniform6(-2.0..2.0f64), any::<bool>()), 1..6);
    (cameras, prop::collection::vec(point, 1..8)).prop_flat_map(|(cameras, points)| {
        let (n_cameras, n_points) = (cameras.len() as u32, points.len() as u32);
        let right = prop_oneof![Just(f64::NAN), -1e3..1e4f64];
        let observation = (0..n_cameras, 0..n_points, -1e4..1e4f64, -1e4..1e4f64, right)
            .prop_map(|(camera, point, u, v, right_u)| observe(camera, point, u, v, right_u));
        prop::collection::vec(observation, 0..40).prop_map(move |observations| BundleProblem {
            rig: rig(),
            cameras: cameras.iter().map(|(v, _)| SE3::exp(&(*v).into())).collect(),
            fixed: cameras.iter().map(|&(_, fixed)| fixed).collect(),
            points: points.clone(),
            observations,
        })
    })
}

proptest! {
    #[test]
    fn any_garbage_gives_finite_values_and_no_higher_cost(problem in any_problem()) {
        solve(&problem);
    }
}
