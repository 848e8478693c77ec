//! A loop is applied: the correction first, then the duplicates around the new side.

use geometry::{SE3, Vec3};
use map::{Correction, KeyframeCorrection, PointId};

use super::*;
use crate::scene::{Scene, add, at, gap, mapper, params};

#[test]
fn both_sides_share_their_points_after_the_correction() {
    let scene = Scene::wall(30);
    let mut map = scene.map(&[at(0.0, 0.0, 0.0)]);
    // The second visit: two keyframes with points of their own, 0.7 m off.
    let off = SE3::new(geometry::SO3::identity(), Vec3::new(0.7, 0.0, 0.0));
    let pose = |k: u32| at(0.2 * f64::from(k), 0.0, 0.0);
    let own: Vec<(u32, Vec3)> = (0..).zip(&scene.landmarks).map(|(i, p)| (i, off.inverse() * *p)).collect();
    add(&mut map, scene.whole(1, &pose(1)), &(pose(1) * off), &[], &own);
    let matches: Vec<(u32, u32)> = (0..25).map(|i| (i, 30 + i)).collect();
    add(&mut map, scene.whole(2, &pose(2)), &(pose(2) * off), &matches, &[]);
    let correction = Correction {
        keyframes: [1, 2].map(|k| KeyframeCorrection::rigid(KeyframeId(k), pose(k))).to_vec(),
        merged: vec![(PointId(0), PointId(30)), (PointId(1), PointId(31))],
        loop_edges: vec![(KeyframeId(0), KeyframeId(2))],
        seen_revision: map.revision(),
        ..Correction::default()
    };
    let found = LoopCorrection {
        keyframe: KeyframeId(2),
        matched: KeyframeId(0),
        inliers: 2,
        moved_m: 0.7,
        turned_deg: 0.0,
        scale: 1.0,
        joins_submaps: false,
        correction,
        earlier_points: (0..30).map(PointId).collect(),
    };
    let mut mapper = mapper(map, &params());
    mapper.apply_loop(&found).unwrap();
    let map = &mapper.world().map;
    // Each of the 30 landmarks is one point again, and the last keyframe also shows the five that it had not matched.
    assert_eq!(map.n_points(), 30);
    let shown = |k: u32| map.keyframe(KeyframeId(k)).unwrap().points().to_vec();
    assert!(shown(0).iter().all(Option::is_some));
    assert_eq!([shown(1), shown(2)], [shown(0), shown(0)]);
    assert!(gap(&map.keyframe(KeyframeId(1)).unwrap().cam_from_world, &pose(1)) < 1e-12);
    assert_eq!(map.keyframe(KeyframeId(0)).unwrap().loop_edges(), [KeyframeId(2)]);
    assert_eq!(map.check(), Ok(()));
}

#[test]
fn a_correction_that_the_map_refuses_changes_nothing() {
    let map = Scene::wall(10).map(&[at(0.0, 0.0, 0.0), at(0.2, 0.0, 0.0)]);
    let digest = map.digest();
    let correction = Correction { seen_revision: map.revision() + 1, ..Correction::default() };
    let found = LoopCorrection {
        keyframe: KeyframeId(1),
        matched: KeyframeId(0),
        inliers: 0,
        moved_m: 0.0,
        turned_deg: 0.0,
        scale: 1.0,
        joins_submaps: false,
        correction,
        earlier_points: Vec::new(),
    };
    let mut mapper = mapper(map, &params());
    assert!(mapper.apply_loop(&found).is_err());
    assert_eq!(mapper.world().map.digest(), digest);
}
