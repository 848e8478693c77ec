//! Global bundle adjustment of a snapshot.

use geometry::{SE3, Vec3};
use map::{KeyframeId, PointId};

use super::*;
use crate::probe::NoProbe;
use crate::scene::{Scene, add_under, at, gap, params};

#[test]
fn a_bent_map_becomes_straight_and_its_roots_stay() {
    let scene = Scene::wall(40);
    let poses: Vec<SE3> = (0..4).map(|k| at(0.5 * f64::from(k), 0.0, 0.0)).collect();
    let mut map = scene.map(&poses);
    // A second sub-map of its own.
    let root = poses[0];
    let new: Vec<(u32, Vec3)> = (0..).zip(scene.landmarks.iter().copied()).collect();
    add_under(&mut map, scene.whole(4, &root), &root, &[], &new, map::Parent::NewSubmap);
    let bend = |k: u32| {
        SE3::exp(&geometry::Vec6::new(0.02, 0.03, -0.02, 0.002, 0.004, -0.003).map(|x| x * f64::from(k)))
    };
    let bent: Vec<(KeyframeId, SE3)> = (1..4).map(|k| (KeyframeId(k), bend(k) * poses[k as usize])).collect();
    let points: Vec<(PointId, Vec3)> =
        (0..40).map(|i| (PointId(i), scene.landmarks[i as usize] + Vec3::new(0.1, 0.0, 0.2))).collect();
    map.set_estimates(&bent, &points).unwrap();
    let world = World { map, ..World::default() };
    let solution = adjust_globally(&world, &params(), &mut NoProbe).unwrap();
    assert!(solution.cost[1] < 1e-3 * solution.cost[0], "{:?}", solution.cost);
    let moved: Vec<u32> = solution.correction.keyframes.iter().map(|k| k.keyframe.0).collect();
    assert_eq!(moved, vec![1, 2, 3], "neither root");
    for keyframe in &solution.correction.keyframes {
        let error = gap(&keyframe.cam_from_world, &poses[keyframe.keyframe.0 as usize]);
        assert!(error < 2e-3, "{keyframe:?}: {error}");
        assert_eq!(keyframe.scale, 1.0);
    }
    assert_eq!(solution.correction.points.len(), 40, "points that one keyframe sees are left");
    assert_eq!(solution.correction.seen_revision, world.map.revision());
}

#[test]
fn there_is_nothing_to_adjust_without_two_views() {
    let empty = World::default();
    assert!(adjust_globally(&empty, &params(), &mut NoProbe).is_none());
    let world = World { map: Scene::wall(20).map(&[SE3::identity()]), ..World::default() };
    assert!(adjust_globally(&world, &params(), &mut NoProbe).is_none());
}
