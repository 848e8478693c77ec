//! The geometry of a loop candidate: matches by words, a motion, guided search.

use geometry::SO3;
use map::Map;

use super::*;
use crate::CameraParams;
use crate::scene::{Scene, Shot, add, at, described, gap, params, shot};

/// True poses of the two visits' keyframes.
fn poses() -> [SE3; 2] {
    let turned = SO3::exp(&Vec3::new(0.0, 0.05, 0.02));
    [SE3::identity(), SE3::new(turned, Vec3::new(-1.2, 0.1, 0.2))]
}

/// Two keyframes that see a wall of `n` landmarks, each with points of its own. The second has drifted by `drift` (points
/// of the true world to its own) and its lengths are `scale` times the true ones.
fn two_visits(n: usize, drift: &SE3, scale: f64, change: impl Fn(&mut Shot)) -> (Scene, World) {
    let scene = Scene::wall(n);
    let [first, second] = poses();
    let mut map = scene.map(&[first]);
    let mut shots: Vec<Shot> = (0..n).map(shot).collect();
    shots.iter_mut().for_each(&change);
    let mut estimate = second * drift.inverse();
    estimate.translation *= scale;
    let own: Vec<(u32, Vec3)> =
        (0..).zip(&scene.landmarks).map(|(i, &p)| (i, (*drift * p) * scale)).collect();
    add(&mut map, scene.frame(1, &second, &shots), &estimate, &[], &own);
    (scene, described(map))
}

fn drift() -> SE3 {
    SE3::new(SO3::exp(&Vec3::new(0.0, 0.03, 0.0)), Vec3::new(0.8, 0.1, -0.5))
}

fn verified(world: &World, params: &Params) -> Result<Verified, NoLoop> {
    verify(KeyframeId(0), KeyframeId(1), world, params)
}

#[test]
fn the_pose_in_the_earlier_world_is_found_and_every_point_matched() {
    let (_, world) = two_visits(80, &drift(), 1.0, |_| {});
    let found = verified(&world, &params()).unwrap();
    assert!(gap(&found.cam_from_world, &poses()[1]) < 1e-3, "{:?}", found.cam_from_world);
    assert_eq!((found.matched, found.scale), (KeyframeId(0), 1.0));
    assert_eq!(found.matches, (0..80).map(|i| (i, PointId(i))).collect::<Vec<_>>());
    assert_eq!(found.earlier_points.len(), 80);
}

#[test]
fn one_camera_also_finds_the_scale() {
    let (_, world) = two_visits(80, &drift(), 1.25, |s| s.stereo = false);
    let found = verified(&world, &Params::of(CameraParams::mono(10.0))).unwrap();
    assert!((found.scale - 1.25).abs() < 0.01, "{}", found.scale);
    assert!(gap(&found.cam_from_world, &poses()[1]) < 5e-3);
}

#[test]
fn nineteen_matches_are_too_few() {
    let (_, world) = two_visits(19, &drift(), 1.0, |_| {});
    assert!(matches!(verified(&world, &params()), Err(NoLoop::TooFewMatches { found: 19, needed: 20 })));
}

#[test]
fn matches_that_no_motion_explains_are_refused() {
    // The second visit sees the same looks at other places.
    let (scene, _) = two_visits(40, &drift(), 1.0, |_| {});
    let mut map = scene.map(&[poses()[0]]);
    let mut shuffled = scene.clone();
    shuffled.landmarks.rotate_left(17);
    let own: Vec<(u32, Vec3)> = (0..).zip(shuffled.landmarks.iter().copied()).collect();
    add(&mut map, shuffled.whole(1, &poses()[1]), &poses()[1], &[], &own);
    let result = verified(&described(map), &params());
    assert!(matches!(result, Err(NoLoop::NoGeometry { needed: 20, .. })), "{result:?}");
}

#[test]
fn forty_points_must_be_found() {
    for (n, accepted) in [(39, false), (40, true)] {
        let (_, world) = two_visits(n, &drift(), 1.0, |_| {});
        let result = verified(&world, &params());
        match result {
            Ok(found) => assert!(accepted && found.matches.len() == n, "{}", found.matches.len()),
            Err(reason) => {
                assert_eq!(reason, NoLoop::TooFewInliers { found: 39, needed: 40, visible: 39 });
                assert!(!accepted);
            }
        }
    }
}

#[test]
fn a_share_of_what_should_be_visible_must_be_found() {
    let (_, world) = two_visits(60, &drift(), 1.0, |s| {
        // Fifteen landmarks look otherwise and are not found.
        s.flipped = if s.landmark < 15 { 128 } else { 0 };
    });
    let with_share = |share: f64| {
        let mut params = params();
        params.loops.min_inlier_share = share;
        verified(&world, &params)
    };
    assert!(with_share(0.75).is_ok());
    let Err(NoLoop::TooFewInliers { found, needed, visible }) = with_share(0.76) else { panic!("accepted") };
    assert_eq!((found, needed, visible), (45, 46, 60));
}

#[test]
fn guided_search_finds_what_words_do_not() {
    // 55 bits off: too many for a match by words, but within the guided search's 60.
    let (_, world) = two_visits(80, &drift(), 1.0, |s| s.flipped = if s.landmark % 2 == 0 { 55 } else { 0 });
    let (here, there) = (KeyframeId(1), KeyframeId(0));
    let keyframe = |id| world.map.keyframe(id).unwrap();
    assert_eq!(match_places(keyframe(here), keyframe(there), &world).len(), 40);
    assert_eq!(verified(&world, &params()).unwrap().matches.len(), 80);
}

#[test]
fn the_scale_is_the_median_ratio_of_distances() {
    let (_, world) = two_visits(40, &SE3::identity(), 1.5, |_| {});
    let map: &Map = &world.map;
    let here = map.keyframe(KeyframeId(1)).unwrap();
    let found = Verified {
        matched: KeyframeId(0),
        cam_from_world: poses()[1],
        scale: 1.0,
        // Two wrong matches do not move the median.
        matches: (0..20).map(|i| (i, PointId(if i < 2 { i + 20 } else { i }))).collect(),
        earlier_points: Vec::new(),
    };
    assert!((scale_between(&found, here, map) - 1.5).abs() < 1e-9);
}

#[test]
fn a_world_without_words_matches_nothing() {
    let map = Scene::wall(40).map(&[at(0.0, 0.0, 0.0), at(0.3, 0.0, 0.0)]);
    let world = World { map, ..World::default() };
    assert!(matches!(verified(&world, &params()), Err(NoLoop::TooFewMatches { found: 0, .. })));
}
