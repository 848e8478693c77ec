//! A keyframe comes into the map with its matches and the points that its depth gives.

use map::RelativePose;

use super::*;
use crate::CameraParams;
use crate::scene::{Scene, Shot, at, gap, mapper, params, shot};
use crate::tracker::KeyframeReason;

/// Landmarks straight ahead at these depths.
fn depths(depths: &[f64]) -> Scene {
    Scene::at((0..).zip(depths).map(|(i, &z)| Vec3::new(0.1 * f64::from(i), 0.0, z)).collect())
}

fn chosen(
    scene: &Scene,
    shots: &[Shot],
    matched: &[u32],
    close_depth_m: f64,
    min_depth_points: usize,
) -> Vec<u32> {
    let frame = scene.frame(0, &SE3::identity(), shots);
    let matches: Vec<(u32, PointId)> = matched.iter().map(|&i| (i, PointId(i))).collect();
    let mut params = params();
    params.camera.close_depth_m = close_depth_m;
    params.mapping.min_depth_points = min_depth_points;
    let points = depth_points(&frame, &SE3::identity(), &matches, &params);
    points.into_iter().map(|(feature, _)| feature).collect()
}

#[test]
fn close_features_become_points_nearest_first() {
    let scene = depths(&[30.0, 5.0, 18.0, 40.0, 9.0]);
    let all: Vec<Shot> = (0..5).map(shot).collect();
    assert_eq!(chosen(&scene, &all, &[], 20.0, 0), vec![1, 4, 2]);
    assert_eq!(chosen(&scene, &all, &[4], 20.0, 0), vec![1, 2], "a matched feature has its point");
    let mut blind = all.clone();
    blind[1].stereo = false;
    assert_eq!(chosen(&scene, &blind, &[], 20.0, 0), vec![4, 2]);
}

#[test]
fn far_features_fill_up_to_the_least_number() {
    let scene = depths(&[30.0, 5.0, 18.0, 40.0, 9.0]);
    let all: Vec<Shot> = (0..5).map(shot).collect();
    assert_eq!(chosen(&scene, &all, &[], 20.0, 3), vec![1, 4, 2]);
    assert_eq!(chosen(&scene, &all, &[], 20.0, 4), vec![1, 4, 2, 0]);
    assert_eq!(chosen(&scene, &all, &[1], 20.0, 4), vec![4, 2, 0], "matched features count too");
    assert_eq!(chosen(&scene, &all, &[], 20.0, 9), vec![1, 4, 2, 0, 3]);
}

#[test]
fn positions_are_in_the_world() {
    let scene = depths(&[10.0, 12.0]);
    let pose = at(0.3, -0.2, 1.0);
    let frame = scene.whole(0, &pose);
    for (feature, position) in depth_points(&frame, &pose, &[], &params()) {
        let error = (position - scene.landmarks[feature as usize]).norm();
        assert!(error < 1e-3, "{error} m");
    }
}

fn request(frame: Arc<Frame>, placement: Placement, matches: Vec<(u32, PointId)>) -> KeyframeRequest {
    KeyframeRequest { frame, placement, matches, reason: KeyframeReason::FewShared, pair: None }
}

#[test]
fn a_keyframe_is_placed_relative_to_its_reference() {
    let scene = Scene::wall(20);
    let (first, motion) = (at(0.4, 0.1, 0.2), at(0.5, 0.0, 0.0));
    let mut mapper = mapper(map::Map::new(), &params());
    let start = request(scene.whole(0, &first), Placement::NewSubmap { cam_from_world: first }, Vec::new());
    let root = mapper.insert_keyframe(&start).unwrap();
    assert_eq!((root, mapper.young.len()), (KeyframeId(0), 20));
    let pose = RelativePose::new(&mapper.world.map, root, motion);
    let mut shots: Vec<Shot> = (0..20).map(shot).collect();
    shots[19].stereo = false;
    let matches = (0..10).map(|i| (i, mapper.young[i as usize])).collect();
    let frame = scene.frame(1, &(motion * first), &shots);
    let id = mapper.insert_keyframe(&request(frame, Placement::Near(pose), matches)).unwrap();
    let keyframe = mapper.world.map.keyframe(id).unwrap();
    assert!(gap(&keyframe.cam_from_world, &(motion * first)) < 1e-12);
    assert_eq!((keyframe.parent(), keyframe.points().iter().flatten().count()), (Some(root), 19));
    assert_eq!(mapper.young.len(), 29, "nine features with depth had no point");
    assert_eq!(mapper.world.map.check(), Ok(()));
}

#[test]
fn without_its_reference_it_is_refused() {
    let scene = Scene::wall(20);
    let mut mapper = mapper(map::Map::new(), &params());
    let nowhere = Placement::Near(RelativePose::of_keyframe(KeyframeId(7)));
    assert_eq!(
        mapper.insert_keyframe(&request(scene.whole(0, &at(0.0, 0.0, 0.0)), nowhere, Vec::new())),
        None
    );
    assert_eq!(mapper.world.map.n_keyframes(), 0);
}

#[test]
fn a_monocular_start_gives_two_keyframes_that_share_its_points() {
    let scene = Scene::wall(20);
    let (first, second) = (at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0));
    let points = (0..).zip(&scene.landmarks).map(|(i, &place)| (i, 19 - i, place)).collect();
    let pair = InitialPair {
        first: scene.whole(0, &first),
        first_from_world: first,
        second_from_world: second,
        points,
    };
    let reversed: Vec<Shot> = (0..20).rev().map(shot).collect();
    let frame = scene.frame(1, &second, &reversed);
    let start = Placement::NewSubmap { cam_from_world: second };
    let mut request = request(frame, start, Vec::new());
    request.pair = Some(Arc::new(pair));
    let mut mapper = mapper(map::Map::new(), &crate::Params::of(CameraParams::mono(10.0)));
    assert_eq!(mapper.insert_keyframe(&request), Some(KeyframeId(1)));
    let map = &mapper.world.map;
    assert_eq!((map.n_keyframes(), map.n_points(), mapper.young.len()), (2, 20, 20));
    assert_eq!(map.keyframe(KeyframeId(0)).unwrap().shared_points(KeyframeId(1)), 20);
    for point in map.points() {
        let [a, b] = point.observations() else { panic!("two observations") };
        assert_eq!(a.feature, 19 - b.feature);
        assert_eq!(point.position, scene.landmarks[a.feature as usize]);
    }
}
