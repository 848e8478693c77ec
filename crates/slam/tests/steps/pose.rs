//! From matches to a pose.

use geometry::SO3;

use super::*;
use crate::scene::{Scene, Shot, gap, params, shot};

fn truth() -> SE3 {
    SE3::new(SO3::exp(&Vec3::new(0.03, -0.06, 0.1)), Vec3::new(0.4, -0.2, 0.3))
}

/// Forty matches of which the first `n_wrong` are elsewhere, and the map.
fn matched(n_wrong: usize) -> (std::sync::Arc<Frame>, Map, Vec<(u32, PointId)>) {
    let scene = Scene::wall(40);
    let mut shots: Vec<Shot> = (0..40).map(shot).collect();
    shots[..n_wrong].iter_mut().enumerate().for_each(|(i, s)| {
        let angle = i as f64;
        s.shift_px = [60.0 * angle.sin(), 60.0 * angle.cos()];
    });
    let matches = (0..40).map(|i| (i, PointId(i))).collect();
    (scene.frame(1, &truth(), &shots), scene.map(&[SE3::identity()]), matches)
}

#[test]
fn a_rough_pose_is_refined_and_outliers_are_named() {
    let (frame, map, matches) = matched(12);
    let rough = SE3::exp(&geometry::Vec6::new(0.05, 0.05, -0.05, 0.01, 0.01, 0.01)) * truth();
    let found = refine(&frame, &map, rough, &matches, params().noise());
    assert!(gap(&found.cam_from_world, &truth()) < 1e-3);
    assert_eq!(found.inliers, matches[12..]);
}

#[test]
fn removed_points_are_passed_over() {
    let (frame, mut map, matches) = matched(0);
    map.remove_point(PointId(5)).unwrap();
    let found = refine(&frame, &map, truth(), &matches, params().noise());
    assert!(found.inliers.len() == 39 && !found.inliers.contains(&(5, PointId(5))));
}

#[test]
fn ransac_needs_no_pose_to_begin_with() {
    let (frame, map, matches) = matched(20);
    let found = pose_by_ransac(&frame, &map, &matches, params().weights, 7).unwrap();
    assert!(gap(&found, &truth()) < 0.02, "{}", gap(&found, &truth()));
}

#[test]
fn distrusted_features_are_not_sampled() {
    // All but ten features are wrong, in a way that agrees: the wall seen from elsewhere.
    let scene = Scene::wall(40);
    let elsewhere = SE3::new(SO3::identity(), Vec3::new(-1.0, 0.0, 0.0));
    let mut frame = (*scene.whole(1, &elsewhere)).clone();
    let right = scene.whole(1, &truth());
    for i in 0..10 {
        frame.keypoints[i] = right.keypoints[i];
    }
    frame.activation = (0..40).map(|i| if i < 10 { 1.0 } else { 0.01 }).collect();
    let map = scene.map(&[SE3::identity()]);
    let matches: Vec<(u32, PointId)> = (0..40).map(|i| (i, PointId(i))).collect();
    let with = |ransac| {
        let weights = Weights { ransac, ..params().weights };
        pose_by_ransac(&frame, &map, &matches, weights, 7).unwrap()
    };
    assert!(gap(&with(true), &truth()) < 0.02);
    assert!(gap(&with(false), &elsewhere) < 0.02);
}
