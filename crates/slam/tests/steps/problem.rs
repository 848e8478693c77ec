//! A bundle problem says what the map says.

use geometry::SE3;

use super::*;
use crate::scene::{Scene, at};

const NOISE: Noise = Noise { sigma_px: 2.0, weighted: false };

#[test]
fn cameras_points_and_observations_are_those_of_the_map() {
    let scene = Scene::wall(6);
    let poses = [SE3::identity(), at(0.3, 0.0, 0.0), at(0.6, 0.0, 0.0)];
    let map = scene.map(&poses);
    let points: Vec<PointId> = [4, 1, 9].map(PointId).to_vec();
    let keyframes = vec![KeyframeId(2), KeyframeId(8), KeyframeId(0)];
    let MapProblem { problem, keyframes, points } =
        MapProblem::new(&map, keyframes, points, NOISE, |id| id == KeyframeId(0)).unwrap();
    // Ids that are not in the map are skipped; the other observer comes last and is fixed.
    assert_eq!(keyframes, [2, 0, 1].map(KeyframeId));
    assert_eq!(points, [4, 1].map(PointId));
    assert_eq!(problem.fixed, [false, true, true]);
    assert_eq!(problem.cameras, [poses[2], poses[0], poses[1]]);
    assert_eq!(problem.points, [scene.landmarks[4], scene.landmarks[1]]);
    assert_eq!(problem.observations.len(), 6);
    for seen in &problem.observations {
        let frame = &map.keyframe(keyframes[seen.camera as usize]).unwrap().frame;
        let feature = points[seen.point as usize].0 as usize;
        assert_eq!(seen.pixel, frame.pixel(feature));
        assert_eq!(seen.right_u, f64::from(frame.right_u[feature]));
        assert_eq!(seen.inv_sigma_sq, frame.inv_sigma_sq(feature) / 4.0);
    }
}

#[test]
fn without_a_keyframe_there_is_no_problem() {
    let map = Scene::wall(3).map(&[SE3::identity()]);
    assert!(MapProblem::new(&map, vec![KeyframeId(5)], vec![PointId(0)], NOISE, |_| false).is_none());
}
